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
    let output = ramus()
        .args(["derive", HONDA, "--stream"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2), "nothing is asked for");
}

#[test]
fn a_streamed_string_is_exported_as_any_other() {
    let folder = folder();
    let fern = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/grammars/fern.lsys");
    for grammar in [HONDA, fern] {
        let files =
            |name: &str| ["glb", "obj"].map(|kind| folder.path().join(format!("{name}.{kind}")));
        let export = |name: &str, more: &[&str]| {
            let [glb, obj] = files(name);
            let mut command = ramus();
            command
                .args(["derive", grammar, "--export"])
                .arg(&glb)
                .arg("--export")
                .arg(&obj);
            succeed(command.args(more));
            // What a file says of itself is its name, here as long in both.
            [glb, obj].map(|file| {
                let bytes = std::fs::read(file).unwrap();
                String::from_utf8_lossy(&bytes).replace(name, "it")
            })
        };
        assert!(
            export("buffered", &[]) == export("streamed", &["--stream", "--json"]),
            "{grammar}"
        );
    }
    // A string that does not fit, of which little is drawn.
    let file = folder.path().join("sparse.lsys");
    std::fs::write(&file, "steps 25\naxiom A F [+F] F\nA -> A A\n").unwrap();
    let picture = folder.path().join("sparse.swc");
    let mut command = ramus();
    command
        .arg("derive")
        .arg(&file)
        .args(["--memory", "64", "--export"])
        .arg(&picture);
    refused(&command.output().unwrap(), &["64 MiB"]);
    succeed(command.arg("--stream"));
    let swc = std::fs::read_to_string(&picture).unwrap();
    let points = swc.lines().filter(|line| !line.starts_with('#')).count();
    assert_eq!(points, 4, "the root and three segments");
}
