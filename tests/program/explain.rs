//! `ramus derive --explain`: which production rewrote each module.

use std::fs;

use super::{folder, ramus, succeed, text};

#[test]
fn a_step_is_told_module_by_module() {
    let folder = folder();
    let file = folder.path().join("plant.lsys");
    let grammar = "seed 1\nignore + -\naxiom S A(1) [ + B ] C D\nS < A(x) > C : x < 9 -> A(x+1) F\nB : weight 1 -> G\nC -> X %\n";
    fs::write(&file, grammar).unwrap();
    let said = succeed(
        ramus()
            .arg("derive")
            .arg(&file)
            .args(["--steps", "1", "--explain"]),
    );
    let at = format!("{}", file.display());
    let expected = format!(
        "step 1: 8 modules → 8 modules

  0  S  stays
  1  A(1) → A(2)F
       {at}:4  S < A(x) > C : x < 9 -> A(x+1) F
       left context: S at 0
       right context: C at 6
2–3  [+  stay
  4  B → G
       {at}:5  B : weight 1 -> G
       drawn with probability 1 (weight 1 of 1, 1 matched)
  5  ]  stays
  6  C → X
       {at}:6  C -> X %
  7  D  cut by a %

modules  production
      1  {at}:4  S < A(x) > C : x < 9 -> A(x+1) F
      1  {at}:5  B : weight 1 -> G
      1  {at}:6  C -> X %
      5  none: they stay
"
    );
    assert_eq!(said, expected);
}

#[test]
fn long_strings_are_shown_in_part_and_from_anywhere() {
    let folder = folder();
    let file = folder.path().join("algae.lsys");
    fs::write(&file, "steps 12\naxiom A\nA -> AB\nB -> A\n").unwrap();
    let explain = |arguments: &[&str]| {
        succeed(
            ramus()
                .arg("derive")
                .arg(&file)
                .arg("--explain")
                .args(arguments),
        )
    };
    let said = explain(&["--entries", "2"]);
    assert!(
        said.starts_with("step 12: 233 modules → 377 modules\n"),
        "{said}"
    );
    assert!(
        said.contains("… and 231 more modules (--at 2 shows them from there"),
        "{said}"
    );
    assert!(said.contains("    144  "), "{said}");
    let said = explain(&["--entries", "1", "--at", "232"]);
    assert!(said.contains("232  B → A\n"), "{said}");
    assert!(!said.contains("more modules"), "{said}");
    let said = explain(&["3"]);
    assert!(
        said.starts_with("step 3: 3 modules → 5 modules\n"),
        "{said}"
    );
}

#[test]
fn json_holds_the_same() {
    let folder = folder();
    let file = folder.path().join("bush.lsys");
    fs::write(
        &file,
        "steps 2\naxiom F(1)\nF(x) : weight 1 -> F(x/2)\nF(x) : weight 3 -> F(x)[+F(x)]\n",
    )
    .unwrap();
    let said = succeed(
        ramus()
            .arg("derive")
            .arg(&file)
            .args(["--explain", "1", "--json"]),
    );
    let json: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(json["format"], "ramus-explain/1");
    assert_eq!(json["modules"][0]["module"], "F(1)");
    let production = json["modules"][0]["production"].as_u64().unwrap();
    let weight = if production == 0 { 1.0 } else { 3.0 };
    assert_eq!(json["modules"][0]["drawn"]["weight"], weight);
    assert_eq!(json["modules"][0]["drawn"]["total"], 4.0);
    assert_eq!(
        json["productions"][usize::try_from(production).unwrap()]["modules"],
        1
    );
}

#[test]
fn what_cannot_be_explained_is_said() {
    let folder = folder();
    let file = folder.path().join("a.lsys");
    fs::write(&file, "axiom A\nA -> AB\n").unwrap();
    for (arguments, code, expected) in [
        (
            &["--steps", "0", "--explain"][..],
            1,
            "there is no step to explain after 0 steps",
        ),
        (
            &["--explain", "0", "--steps", "1"],
            2,
            "the first step is 1",
        ),
        (
            &["--explain", "x.lsys"],
            2,
            "a grammar file stands before `--explain`",
        ),
        (
            &["--explain", "2", "--steps", "2", "--at", "2"],
            1,
            "no module 2 to explain: the string before step 2 has 2 modules",
        ),
        (&["--at", "2"], 2, "--explain"),
        (
            &["--explain", "--print", "string"],
            2,
            "cannot be used with",
        ),
        (
            &["--explain", "--json", "--stream"],
            2,
            "cannot be used with '--stream'",
        ),
        (
            &["--explain", "--time", "2.5"],
            2,
            "cannot be used with '--time <STEPS>'",
        ),
        (
            &["--json", "--print", "growth"],
            2,
            "cannot be used with '--print <WHAT>'",
        ),
    ] {
        let output = ramus()
            .arg("derive")
            .arg(&file)
            .args(arguments)
            .output()
            .unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
}
