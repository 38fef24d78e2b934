//! `ramus study`: the published answers scored, folders of answers read, and what is said of wrong ones.

use serde_json::{Value, json};

use super::cohort::write;
use super::*;

const PUBLISHED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/study/answers.csv");

fn report(source: &Path) -> Command {
    let mut command = ramus();
    command.args(["study", "report"]).arg(source);
    command
}

#[track_caller]
fn refused(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{command:?}");
    text(&output.stderr)
}

fn answers(participant: &str, condition: &str, sus: &[u8]) -> String {
    json!({
        "format": "ramus-study/1", "participant": participant, "condition": condition,
        "ssq_before": vec![0; 16], "sus": sus, "ssq_after": vec![1; 16],
        "tasks": [{"task": "stem", "seconds": 40.0, "outcome": "done"}],
    })
    .to_string()
}

#[test]
fn the_published_answers_are_scored() {
    let said = succeed(report(Path::new(PUBLISHED)).arg("--ssq-from-one"));
    for line in [
        "7 participants, 2 conditions: prototype (7), speedtree (7)",
        "  prototype    7   73.57    9.00   72.50   57.5   82.5  good, acceptable",
        "  speedtree    7   50.00   23.36   50.00     15   87.5  OK, marginal",
        "Z −2.117, p 0.047 (exact; 0.034 by the normal distribution)",
        "  disorientation       0.00 (0.00)    17.90 (22.32)    17.90 (22.32)",
    ] {
        assert!(said.contains(line), "{line}\n{said}");
    }
    // Whoever forgets how the SSQ was coded there is told.
    let output = report(Path::new(PUBLISHED)).output().unwrap();
    assert!(text(&output.stderr).contains("add --ssq-from-one"));
}

#[test]
fn a_folder_gives_a_report_and_a_table_that_gives_the_same() {
    let folder = folder();
    let place = |name: &str| format!("study/{name}/answers.json");
    for (name, sus) in [("P1/a", [5; 10]), ("P1/b", [3; 10]), ("P2/a", [4; 10])] {
        let (participant, condition) = name.split_once('/').unwrap();
        write(
            folder.path(),
            &place(name),
            &answers(participant, condition, &sus),
        );
    }
    let (study, csv) = (folder.path().join("study"), folder.path().join("all.csv"));
    let said = succeed(report(&study).arg("--csv").arg(&csv));
    assert!(
        said.starts_with("2 participants, 2 conditions: a (2), b (1)\n"),
        "{said}"
    );
    assert_eq!(succeed(&mut report(&csv)), said);
    let found: Value = serde_json::from_str(&succeed(report(&csv).arg("--json"))).unwrap();
    assert_eq!(found["format"], "ramus-study-report/1");
    assert_eq!(
        found["conditions"][0]["tasks"][0]["seconds"]["median"],
        40.0
    );
    // One file that is broken costs nobody the rest, and the exit code tells.
    write(folder.path(), &place("P2/b"), "{");
    let output = report(&study).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stdout), said);
    let told = text(&output.stderr);
    assert!(
        told.contains("P2/b/answers.json: no answers can be read there"),
        "{told}"
    );
    assert!(
        told.ends_with("1 of 4 files of answers could not be read and is not in the report\n"),
        "{told}"
    );
}

/// Each of the fourteen scores and of the seven people's lines is there, and the means as they are printed.
#[test]
fn the_report_is_drawn() {
    let folder = folder();
    let svg = folder.path().join("report.svg");
    let mut command = report(Path::new(PUBLISHED));
    succeed(command.arg("--ssq-from-one").arg("--svg").arg(&svg));
    let drawn = fs::read_to_string(&svg).unwrap();
    // Two columns of usability and eight of sickness: a person's dot in each, and a mean's.
    assert_eq!(drawn.matches("r=\"3\"").count(), 10 * 7);
    assert_eq!(drawn.matches("r=\"5.5\"").count(), 10);
    for said in [
        ">73.6<",
        ">50.0<",
        ">17.9<",
        "SSQ disorientation, prototype",
        "7 participants",
    ] {
        assert!(drawn.contains(said), "{said}");
    }
}

/// The studies of this machine's window and headset: without either nothing is begun.
#[test]
fn a_sitting_without_a_headset_or_a_window_begins_nothing() {
    let folder = folder();
    let run = |code: &str, more: &[&str]| {
        let mut command = ramus();
        command
            .args(["study", "run"])
            .arg(folder.path().join("trial"));
        command.args(["--participant", code]).args(more);
        refused(&mut command)
    };
    for (code, more, expected) in [
        (
            "P1",
            &[][..],
            "a study takes a headset or a window, and there is neither",
        ),
        ("../P1", &[], "\"../P1\" is not of letters"),
        ("P1", &["--condition", ""], "the condition has no name"),
        (
            "P1",
            &["--tasks", "/nonexistent/t.json"],
            "/nonexistent/t.json cannot be read",
        ),
    ] {
        let said = run(code, more);
        assert!(said.contains(expected), "{expected}: {said}");
        assert!(!folder.path().join("trial").exists());
    }
}

#[test]
fn what_is_no_study_is_refused_in_a_sentence() {
    let folder = folder();
    let path = folder.path();
    let broken = write(path, "broken/P1/a/answers.json", "[");
    for (source, args, expected) in [
        (path.join("none"), vec![], "none cannot be read"),
        (path.to_owned(), vec!["--ssq-from-one"], "is of tables"),
        (
            folder_in(path, "empty"),
            vec![],
            "has no answers: they are in PARTICIPANT/CONDITION/answers.json",
        ),
        (
            write(path, "t.csv", "a,b\n1,2\n"),
            vec![],
            "the column participant is missing",
        ),
        (
            write(path, "t.bin", "\u{0}\u{1}"),
            vec![],
            "the column participant is missing",
        ),
        (
            broken.ancestors().nth(3).unwrap().to_owned(),
            vec![],
            "no answers in",
        ),
        (
            PUBLISHED.into(),
            vec!["--csv", PUBLISHED],
            "would be overwritten",
        ),
        (
            PUBLISHED.into(),
            vec!["--csv", "/nonexistent/all.csv"],
            "/nonexistent",
        ),
    ] {
        let said = refused(report(&source).args(args));
        assert!(said.contains(expected), "{expected}: {said}");
        assert!(!said.contains("panicked"), "{said}");
    }
}

fn folder_in(path: &Path, name: &str) -> std::path::PathBuf {
    let folder = path.join(name);
    fs::create_dir(&folder).unwrap();
    folder
}
