//! `ramus derive --time` and `--stream`.

use super::{HONDA, folder, ramus, refused, succeed};

/// A JSON object's text without its times.
fn counted(json: &str) -> String {
    json.split(",\"derive_ms\"").next().unwrap().to_owned()
}

#[test]
fn a_part_of_a_step_is_drawn_and_a_whole_one_is_the_step() {
    let json = |args: &[&str]| {
        counted(&succeed(
            ramus().args(["derive", HONDA, "--json"]).args(args),
        ))
    };
    let whole = json(&["--steps", "6"]);
    assert_eq!(
        json(&["--time", "6"]).replace("\"time\":6.0,", ""),
        whole,
        "at a whole step"
    );
    let part = json(&["--time", "5.5"]);
    assert!(part.contains("\"steps\":6,\"time\":5.5,"), "{part}");
    let bounds = |json: &str| json.split("\"bounds\"").nth(1).unwrap().to_owned();
    assert_ne!(bounds(&part), bounds(&whole), "half grown");
    let folder = folder();
    let file = folder.path().join("half.swc");
    succeed(
        ramus()
            .args(["derive", HONDA, "--time", "5.5", "--export"])
            .arg(&file),
    );
    assert!(file.exists(), "a file of the part");
    let output = ramus()
        .args(["derive", HONDA, "--time", "1", "--steps", "2"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2), "wrong usage");
}

#[test]
fn a_streamed_string_is_told_as_any_other() {
    let json = |args: &[&str]| {
        counted(&succeed(
            ramus().args(["derive", HONDA, "--json"]).args(args),
        ))
    };
    assert_eq!(
        json(&["--stream"]),
        json(&[]),
        "the same counts and measures"
    );
    let folder = folder();
    let file = folder.path().join("chance.lsys");
    std::fs::write(
        &file,
        "steps 2\naxiom F\nF : weight 1 -> F F\nF : weight 1 -> F\n",
    )
    .unwrap();
    let output = ramus()
        .arg("derive")
        .arg(&file)
        .args(["--json", "--stream"])
        .output()
        .unwrap();
    refused(&output, &["--stream", "derived"]);
}
