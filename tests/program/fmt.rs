//! `ramus fmt`: grammar files in the canonical layout.

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Output, Stdio};

use super::{folder, ramus, text};

const UGLY: &str = "# a bush\nsteps   3\n\naxiom  F\nF-->F[+F ]F   # grows\n";
const TIDY: &str = "# a bush\nsteps 3\n\naxiom F\nF -> F[+F ]F  # grows\n";

fn fmt(arguments: &[&str], files: &[&Path]) -> Output {
    ramus()
        .arg("fmt")
        .args(arguments)
        .args(files)
        .output()
        .unwrap()
}

#[test]
fn files_are_laid_out_in_place_and_stay_so() {
    let folder = folder();
    let file = folder.path().join("bush.lsys");
    fs::write(&file, UGLY).unwrap();
    let output = fmt(&[], &[&file]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(text(&output.stdout), format!("{}\n", file.display()));
    assert_eq!(fs::read_to_string(&file).unwrap(), TIDY);
    let output = fmt(&[], &[&file]);
    assert!(output.status.success());
    assert_eq!(text(&output.stdout), "", "nothing was left to do");
}

#[test]
fn check_names_what_would_change_and_writes_nothing() {
    let folder = folder();
    let [ugly, tidy] = ["ugly.lsys", "tidy.lsys"].map(|name| folder.path().join(name));
    fs::write(&ugly, UGLY).unwrap();
    fs::write(&tidy, TIDY).unwrap();
    let output = fmt(&["--check"], &[&ugly, &tidy]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stdout), format!("{}\n", ugly.display()));
    assert_eq!(
        text(&output.stderr),
        "ramus: 1 file is not in the canonical layout; `ramus fmt` lays it out\n"
    );
    assert_eq!(fs::read_to_string(&ugly).unwrap(), UGLY);
    let output = fmt(&["--check"], &[&tidy]);
    assert_eq!(
        (output.status.code(), text(&output.stderr)),
        (Some(0), String::new())
    );
}

#[test]
fn a_file_with_faults_is_left_and_the_others_are_done() {
    let folder = folder();
    let [faulty, ugly] = ["faulty.lsys", "ugly.lsys"].map(|name| folder.path().join(name));
    let fault = "axoim  F\n";
    fs::write(&faulty, fault).unwrap();
    fs::write(&ugly, UGLY).unwrap();
    let missing = folder.path().join("missing.lsys");
    let output = fmt(&[], &[&faulty, &missing, &ugly]);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(said.contains("faulty.lsys:1:1: "), "{said}");
    assert!(said.contains("`axiom`"), "{said}");
    assert!(said.contains("\nramus: cannot read "), "{said}");
    assert_eq!(fs::read_to_string(&faulty).unwrap(), fault);
    assert_eq!(fs::read_to_string(&ugly).unwrap(), TIDY);
}

#[test]
fn standard_input_goes_to_standard_output() {
    for (arguments, said, code) in [
        (&["-"][..], TIDY, 0),
        (&["-", "--check"], "standard input\n", 1),
    ] {
        let mut child = ramus()
            .arg("fmt")
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        child
            .stdin
            .take()
            .unwrap()
            .write_all(UGLY.as_bytes())
            .unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(
            (text(&output.stdout).as_str(), output.status.code()),
            (said, Some(code))
        );
    }
}

#[test]
fn a_part_that_is_included_elsewhere_is_laid_out_and_the_including_file_too() {
    let folder = folder();
    let [part, whole] = ["part.lsys", "whole.lsys"].map(|name| folder.path().join(name));
    fs::write(&part, "module Leaf(a)\nLeaf(a)->F\n").unwrap();
    fs::write(&whole, "include   \"part.lsys\"\naxiom   Leaf(1)F\n").unwrap();
    let output = fmt(&[], &[&whole, &part]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_eq!(
        fs::read_to_string(&part).unwrap(),
        "module Leaf(a)\nLeaf(a) -> F\n"
    );
    assert_eq!(
        fs::read_to_string(&whole).unwrap(),
        "include \"part.lsys\"\naxiom Leaf(1)F\n"
    );
}

#[test]
fn the_grammars_of_the_repository_are_laid_out() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/grammars");
    let files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    assert!(files.len() >= 4);
    let paths: Vec<&Path> = files.iter().map(AsRef::as_ref).collect();
    let output = fmt(&["--check"], &paths);
    assert!(output.status.success(), "{}", text(&output.stdout));
}
