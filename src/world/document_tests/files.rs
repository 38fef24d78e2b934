//! Journals and projects that were cut, damaged or edited: what is whole comes back, the rest is told.

use super::*;

fn example_journal() -> (Vec<Document>, String) {
    let mut history = History::default();
    let (mut journal, mut text) = Journal::begin(history.committed());
    let mut states = vec![history.committed().clone()];
    for edit in example() {
        history.apply(edit).unwrap();
        for action in history.take_log() {
            text.push_str(&journal.line(&action));
            states.push(history.committed().clone());
        }
    }
    history.undo();
    text.push_str(&journal.line(&history.take_log()[0]));
    states.push(history.committed().clone());
    (states, text)
}

#[test]
fn a_journal_cut_anywhere_recovers_every_finished_line() {
    let (states, text) = example_journal();
    for length in 0..=text.len() {
        let part = &text.as_bytes()[..length];
        let finished = part.iter().filter(|&&byte| byte == b'\n').count();
        let torn = part.last().is_some_and(|&byte| byte != b'\n');
        match journal::decode(part) {
            Err(error) => {
                assert_eq!(error, JournalError::Empty, "{length}");
                assert_eq!(finished, 0, "{length}");
            }
            Ok(decoded) => {
                assert_eq!(decoded.actions.len(), finished - 1, "{length}");
                assert_eq!(decoded.damage.is_some(), torn, "{length}");
                let recovered = journal::recover(&decoded);
                assert_eq!(
                    *recovered.history.committed(),
                    states[finished - 1],
                    "{length}"
                );
                assert_eq!(recovered.message.is_some(), torn, "{length}");
                let whole = text[..length].rfind('\n').unwrap() + 1;
                assert_eq!(decoded.whole_bytes, whole, "{length}");
            }
        }
    }
}

#[test]
fn a_journal_damaged_in_the_middle_stops_there() {
    let (states, text) = example_journal();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    // Every byte changed in turn: never a panic, and what comes back is a true beginning.
    for at in 0..text.len() {
        let mut damaged = text.clone().into_bytes();
        damaged[at] ^= 0x10;
        if let Ok(decoded) = journal::decode(&damaged) {
            let recovered = journal::recover(&decoded);
            assert!(decoded.damage.is_some(), "byte {at} is noticed");
            assert_eq!(
                *recovered.history.committed(),
                states[decoded.actions.len()],
                "byte {at}"
            );
        }
    }
    let without = |gone: usize| -> String {
        lines
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != gone)
            .map(|(_, line)| *line)
            .collect()
    };
    let swapped: String = [0, 1, 3, 2].iter().map(|&i| lines[i]).collect();
    for (damaged, kept, lost) in [
        (without(4), 3, lines.len() - 5),
        (without(1), 0, lines.len() - 2),
        (swapped, 1, 2),
    ] {
        let decoded = journal::decode(damaged.as_bytes()).unwrap();
        let expected = Damage::Broken {
            line: kept + 2,
            recovered: kept,
            lost,
        };
        assert_eq!(decoded.damage, Some(expected));
        let message = journal::recover(&decoded).message.unwrap();
        assert!(
            message.contains(&format!("{kept} actions before it were recovered")),
            "{message}"
        );
    }
    // Undo behind the start cannot have been written, so it is told and not passed over.
    let (mut journal, mut text_of_undo) = Journal::begin(&states[3]);
    text_of_undo.push_str(&journal.line(&Action::Undo));
    let decoded = journal::decode(text_of_undo.as_bytes()).unwrap();
    let recovered = journal::recover(&decoded);
    assert_eq!(*recovered.history.committed(), states[3]);
    assert!(recovered.message.unwrap().contains("nothing to undo"));
    let newer = text.replacen("\"version\":1", "\"version\":2", 1);
    assert_eq!(
        journal::decode(newer.as_bytes()),
        Err(JournalError::Version(2))
    );
    for garbage in [
        "\n",
        "{}\n",
        "[1]\n",
        "\0\u{1}\n",
        "{\"format\":\"ramus-project\",\"version\":1,\"base\":\"0\"}\n",
    ] {
        assert_eq!(
            journal::decode(garbage.as_bytes()),
            Err(JournalError::NotAJournal),
            "{garbage:?}"
        );
    }
}

#[test]
fn a_project_cut_anywhere_is_an_error() {
    let bytes = project::to_bytes(apply_all(&example()).committed());
    // The last byte is only the line end.
    for length in 0..bytes.len() - 1 {
        let error = project::from_bytes(&bytes[..length]).unwrap_err();
        assert!(
            matches!(
                error,
                ProjectError::NotAProject | ProjectError::Malformed(_)
            ),
            "{length}: {error}"
        );
    }
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0x04;
        if let Ok(document) = project::from_bytes(&damaged) {
            document.validate().unwrap();
        }
    }
}

#[test]
fn hostile_projects_are_refused_with_a_reason() {
    let good = String::from_utf8(project::to_bytes(apply_all(&example()).committed())).unwrap();
    let table: Vec<(&str, &str, &str)> = vec![
        (
            "\"version\": 1",
            "\"version\": 7",
            "format version 7, which Ramus 0.1.0 or later reads",
        ),
        ("\"version\": 1", "\"version\": -1", "damaged"),
        ("ramus-project", "other", "no Ramus project"),
        ("\"step\": 0", "\"step\": 10001", "too far"),
        ("\"step\": 0", "\"step\": -1", "invalid value"),
        ("\"step\": 0", "\"step\": 0, \"step\": 1", "duplicate field"),
        (
            "\"step\": 0",
            "\"step\": 0, \"colour\": 1",
            "unknown field `colour`",
        ),
        ("[0.0,0.1,0.0]", "[0.0,1e999,0.0]", "number out of range"),
        ("[0.0,0.1,0.0]", "[0.0,1e39,0.0]", "damaged"),
        ("[0.0,0.1,0.0]", "[0.0,NaN,0.0]", "damaged"),
        ("[0.0,0.1,0.0]", "[0.0,null,0.0]", "damaged"),
        ("[0.0,0.1,0.0]", "[0.0,0.2,0.0]", "shorter than 1 mm"),
        ("[0.0,0.1,0.0]", "[0.0,0.1]", "damaged"),
        ("\"letter\": \"C\"", "\"letter\": \"B\"", "`B` is no letter"),
        (
            "\"letter\": \"C\"",
            "\"letter\": \"D\"",
            "which no earlier stroke has",
        ),
        (
            "\"letter\": \"D\"",
            "\"letter\": \"C\"",
            "two strokes are called `C`",
        ),
        (
            "{\"letter\":\"A\",\"node\":2}",
            "{\"letter\":\"D\",\"node\":1}",
            "which no earlier stroke has",
        ),
        (
            "{\"letter\":\"A\",\"node\":2}",
            "{\"letter\":\"C\",\"node\":1}",
            "which no earlier stroke has",
        ),
        (
            "{\"letter\":\"A\",\"node\":2}",
            "{\"letter\":\"A\",\"node\":5}",
            "which no earlier stroke has",
        ),
        (
            "{\"letter\":\"A\",\"node\":2}",
            "{\"letter\":\"A\",\"node\":0}",
            "which no earlier stroke has",
        ),
        ("{\"letter\":\"A\",\"node\":2}", "null", "hangs nowhere"),
        (
            "\"attachment\": null",
            "\"attachment\": {\"letter\":\"C\",\"node\":1}",
            "hangs nowhere",
        ),
        (
            "\"selected\": {\"letter\":\"E\",\"node\":1}",
            "\"selected\": {\"letter\":\"E\",\"node\":2}",
            "its last one is 1",
        ),
        ("\"scale\": 2.0", "\"scale\": 0", "scale"),
        ("137.508", "1e308", "damaged"),
    ];
    for (found, replaced, reason) in table {
        assert!(good.contains(found), "{found} is in the example");
        let message = project::from_bytes(good.replacen(found, replaced, 1).as_bytes())
            .unwrap_err()
            .to_string();
        assert!(message.contains(reason), "{found} → {replaced}: {message}");
        assert!(message.len() < 500, "{message}");
    }
    for garbage in [&b""[..], b"{}", b"null", b"\xff\xfe", b"[[[[", b"glTF"] {
        assert_eq!(
            project::from_bytes(garbage),
            Err(ProjectError::NotAProject),
            "{garbage:?}"
        );
    }
    let deep = "[".repeat(1 << 20);
    assert_eq!(
        project::from_bytes(deep.as_bytes()),
        Err(ProjectError::NotAProject)
    );
    let huge = vec![b' '; (64 << 20) + 1];
    assert_eq!(
        project::from_bytes(&huge),
        Err(ProjectError::TooLarge(huge.len()))
    );
    let many = format!("{}{}", "\"D\": 0, ".repeat(100_000), "\"step\": 0");
    assert!(project::from_bytes(good.replacen("\"step\": 0", &many, 1).as_bytes()).is_err());
}

#[test]
fn an_edited_project_is_brought_to_the_grid() {
    let good = String::from_utf8(project::to_bytes(apply_all(&example()).committed())).unwrap();
    let edited = good.replacen("[0.0,0.1,0.0]", "[-0.0, 0.10000001, 1e-9]", 1);
    let read = project::from_bytes(edited.as_bytes()).unwrap();
    assert_eq!(String::from_utf8(project::to_bytes(&read)).unwrap(), good);
}
