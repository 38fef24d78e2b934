//! The published study, and files as nobody should hand them in.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use serde_json::{Value, json};

use super::answers::Form;
use super::report::{Report, Sickness, report};
use super::told::told;
use super::*;
use crate::app::sentence;
use crate::world::study::score::{self, Factor, SSQ_ITEMS, SUS_ITEMS};

/// Raw answers as they were published.
fn published() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/study/answers.csv")
}

fn found() -> Report {
    report(&Study::read(&published(), true).unwrap())
}

/// As numbers are printed there.
fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0 + 0.0
}

/// 86.07 and 62.50 were published: the standard score and 12.5 more, since nobody took 1 from the odd statements.
#[test]
fn the_published_study_comes_to_what_its_answers_say() {
    let report = found();
    let [prototype, speedtree] = report.conditions.as_slice() else {
        panic!("two conditions: {:?}", report.conditions);
    };
    let means = [prototype, speedtree].map(|one| one.sus.as_ref().unwrap().summary);
    assert_eq!(means.map(|one| rounded(one.mean)), [73.57, 50.0]);
    assert_eq!(means.map(|one| rounded(one.mean + 12.5)), [86.07, 62.5]);
    assert_eq!(means.map(|one| rounded(one.sd.unwrap())), [9.0, 23.36]);
    assert_eq!(means.map(|one| one.median), [72.5, 50.0]);
    let sus = report.pairs[0].sus.unwrap();
    let test = sus.test.unwrap();
    assert_eq!((test.w_plus, test.w_minus), (1.5, 26.5));
    assert_eq!((test.z * 1000.0).round() / 1000.0, -2.117);
    assert_eq!((test.p, test.p_method), (0.046_875, "exact"));
    let ssq = |of: fn(&Sickness) -> f64| -> Vec<f64> {
        prototype
            .ssq
            .iter()
            .map(|factor| rounded(of(factor)))
            .collect()
    };
    assert_eq!(
        ssq(|one| one.before.unwrap().mean),
        [17.72, 9.75, 0.0, 11.75]
    );
    assert_eq!(
        ssq(|one| one.after.unwrap().mean),
        [12.27, 10.83, 17.9, 14.96]
    );
    assert_eq!(
        ssq(|one| one.change.unwrap().difference.mean),
        [-5.45, 1.08, 17.9, 3.21]
    );
    assert!(speedtree.ssq.is_empty(), "nobody was asked there");
    let text = told(&report);
    for said in [
        "prototype    7   73.57",
        "Z −2.117, p 0.047 (exact; 0.034 by the normal distribution)",
        "491 under speedtree is left out of some means of own statements: no answer to 3",
    ] {
        assert!(text.contains(said), "{said}: {text}");
    }
}

/// Every total of the reference, where `RAMUS_SHARED` names the folder with it.
#[test]
fn every_total_of_the_reference_comes_out() {
    let shared = std::env::var_os("RAMUS_SHARED").map(PathBuf::from);
    let Some(shared) = shared else {
        eprintln!("skipped: RAMUS_SHARED does not name the folder with reference/study-data.json");
        return;
    };
    let text = std::fs::read_to_string(shared.join("reference/study-data.json")).unwrap();
    let all: Value = serde_json::from_str(&text).unwrap();
    let study = Study::read(&published(), true).unwrap();
    let report = found();
    let number = |value: &Value| value.as_f64().unwrap();
    // Each person's scores, and our copy of the answers.
    for person in all["participants"].as_array().unwrap() {
        let id = person["id"].to_string();
        for (place, condition) in ["prototype", "speedtree"].into_iter().enumerate() {
            let sus = report.conditions[place].sus.as_ref().unwrap();
            let scored = sus.scores.iter().find(|one| one.participant == id).unwrap();
            let name = format!("sus_{condition}");
            assert_eq!(scored.score, number(&person["computed"][&name]));
            let mut sittings = study.sittings.iter();
            let sitting = sittings
                .find(|one| one.participant == id && one.condition == condition)
                .unwrap();
            let parts = [(Part::Sus, name), (Part::Own, format!("app_{condition}"))];
            for (part, name) in parts {
                let raw: Vec<Answer> = person[&name]
                    .as_array()
                    .unwrap()
                    .iter()
                    .map(|one| answers::answer(part, one.as_f64()))
                    .collect();
                assert_eq!(sitting.part(part), raw, "{id} {name}");
            }
            if condition == "speedtree" {
                continue;
            }
            for (part, name) in [(Part::SsqBefore, "ssq_pre"), (Part::SsqAfter, "ssq_post")] {
                let sums = score::Ssq::of(&sitting.whole(part).unwrap()).unwrap();
                for factor in Factor::ALL {
                    let expected = number(&person["computed"][name][factor.name()]);
                    assert_eq!(rounded(sums.score(factor)), expected, "{id} {name}");
                }
            }
        }
    }
    // Each statement.
    let pair = &report.pairs[0];
    let [prototype, speedtree] = [&report.conditions[0], &report.conditions[1]];
    let sus_items = [prototype, speedtree].map(|one| &one.sus.as_ref().unwrap().items);
    let own_items = [&prototype.own, &speedtree.own];
    for (name, items, paired) in [
        ("sus_items", sus_items, &pair.items),
        ("application_items", own_items, &pair.own),
    ] {
        let expected = all["recomputed"][name].as_array().unwrap();
        assert_eq!(expected.len(), paired.len(), "{name}");
        for (place, row) in expected.iter().enumerate() {
            let means = items.map(|all| rounded(all[place].unwrap().mean));
            let given = ["mean_prototype", "mean_speedtree"].map(|name| number(&row[name]));
            assert_eq!(means, given, "{name} {place}");
            let p = paired[place].unwrap().test.map_or(1.0, |test| test.p);
            let given = number(&row["wilcoxon_exact_p_uncorrected"]);
            assert!((p - given).abs() < 1e-3, "{name} {place}: {p}");
        }
    }
    // By what came first.
    for (order, name, place) in [("VR First", "prototype", 0), ("ST First", "speedtree", 1)] {
        let by = &all["recomputed"]["by_order"][order];
        let first = &report.conditions[place].sus.as_ref().unwrap().by_order[0];
        assert_eq!(
            rounded(first.summary.mean),
            number(&by[format!("sus_{name}")])
        );
        assert_eq!(first.summary.n as f64, number(&by["n"]));
    }
    let ssq = &all["recomputed"]["ssq"];
    let p = |factor: usize| prototype.ssq[factor].change.unwrap().test.unwrap().p;
    assert_eq!(p(3), number(&ssq["wilcoxon_total_exact_p"]));
    assert_eq!(p(2), number(&ssq["wilcoxon_disorientation_exact_p"]));
}

/// A file of answers, whole.
fn form(participant: &str, condition: &str) -> Value {
    json!({
        "format": "ramus-study/1", "participant": participant, "condition": condition, "order": 1,
        "ssq_before": vec![0; SSQ_ITEMS], "sus": vec![3; SUS_ITEMS], "ssq_after": vec![1; SSQ_ITEMS],
        "tasks": [{"task": "stem", "seconds": 12.5, "outcome": "done"}],
    })
}

fn write(folder: &Path, form: &Value) {
    let name = |key: &str| form[key].as_str().unwrap();
    let place = folder.join(name("participant")).join(name("condition"));
    std::fs::create_dir_all(&place).unwrap();
    std::fs::write(place.join(answers::ANSWERS), form.to_string()).unwrap();
}

#[test]
fn a_folder_and_its_table_come_to_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for (participant, condition) in [("P1", "a"), ("P1", "b"), ("P2", "b")] {
        write(folder.path(), &form(participant, condition));
    }
    let mut odd = form("P3", "a");
    odd["sus"] = json!([3, 3, 3, 3, null, 3, 3, 3, 3]);
    odd["ssq_after"][0] = json!(7);
    odd["page"] = json!(4);
    write(folder.path(), &odd);
    let study = Study::read(folder.path(), false).unwrap();
    assert_eq!(
        study.remarks,
        ["P3 under a has not finished: it stands at page 5"]
    );
    let of_folder = report(&study);
    let table = String::from_utf8(paper::table(&study).unwrap()).unwrap();
    let again = paper::from_text(&table, false, "all.csv").unwrap();
    assert_eq!(report(&again), of_folder);
    let reasons: Vec<(Part, &str)> = of_folder
        .left_out
        .iter()
        .map(|one| (one.part, one.reason.as_str()))
        .collect();
    let expected = [
        (Part::Sus, "no answer to 5, 10"),
        (Part::SsqAfter, "answers that are not 0 to 3: 1 is 7"),
    ];
    assert_eq!(reasons, expected);
    assert_eq!(of_folder.conditions[0].sus.as_ref().unwrap().summary.n, 1);
    let second = &of_folder.conditions[0].ssq[3];
    assert_eq!(second.before.map(|all| all.n), Some(2));
    assert_eq!(second.change.map(|all| all.difference.n), Some(1));
}

/// One file that cannot be read costs nobody the rest, and is told.
#[test]
fn what_is_wrong_with_a_file_is_told() {
    let whole = form("P1", "a");
    let with = |key: &str, value: Value| {
        let mut form = whole.clone();
        form[key] = value;
        form.to_string()
    };
    let long = format!("{}{}", whole, " ".repeat(2 << 20));
    let task = |seconds: Value| {
        with(
            "tasks",
            json!([{"task": "s", "seconds": seconds, "outcome": "done"}]),
        )
    };
    let many: Vec<Value> = (0..60)
        .map(|place| json!({"task": format!("t{place}"), "seconds": 1, "outcome": "done"}))
        .collect();
    for (text, expected) in [
        (String::new(), "no answers can be read"),
        (
            "{}".to_owned(),
            "its format is \"\" and not \"ramus-study/1\"",
        ),
        ("[".repeat(100_000), "no answers can be read"),
        (
            with("format", json!("ramus-study/2")),
            "its format is \"ramus-study/2\"",
        ),
        (
            with("sus", json!(vec![3; 11])),
            "11 answers to SUS are more than 10",
        ),
        (with("sus", json!(["3"])), "no answers can be read"),
        (with("ssq_befor", json!([])), "unknown field `ssq_befor`"),
        (
            with("participant", json!("P2")),
            "is of the participant P2 and lies in",
        ),
        (
            with("participant", json!("../P2")),
            "\"../P2\" is not of letters",
        ),
        (with("condition", json!("")), "the condition has no name"),
        (
            with("condition", json!("x".repeat(1000))),
            "has more than 40 letters",
        ),
        (task(json!(-1)), "which is no time"),
        (
            task(json!(0)).replace("\"seconds\":0", "\"seconds\":1e999"),
            "no answers can be read",
        ),
        (with("tasks", Value::Array(many)), "more than 50 tasks"),
        (long, "is longer than"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &whole);
        write(folder.path(), &form("P9", "a"));
        std::fs::write(folder.path().join("P1/a/answers.json"), &text).unwrap();
        let study = Study::read(folder.path(), false).unwrap();
        assert_eq!(study.sittings.len(), 1, "{expected}");
        assert_eq!(study.failed.len(), 1, "{expected}");
        assert!(
            study.failed[0].contains(expected),
            "{expected}: {}",
            study.failed[0]
        );
        assert!(
            study.failed[0].contains("answers.json"),
            "{}",
            study.failed[0]
        );
    }
}

#[test]
fn what_is_wrong_with_a_table_is_told() {
    for (text, expected) in [
        ("", "the column participant is missing"),
        ("participant,age\nP1,3\n", "there is no column of answers"),
        ("participant,sus_1\n", "there are no answers in it"),
        (
            "participant,sus_11\nP1,3\n",
            "\"sus_11\" is no answer to the SUS: they are sus_1 to sus_10",
        ),
        ("participant,sus1\nP1,3\n", "\"sus1\" is no answer"),
        ("participant,ssq_1\nP1,3\n", "before or after"),
        ("participant,sus_1,SUS_1\nP1,3,3\n", "is there twice"),
        (
            "participant,sus_1\nP/1,3\n",
            "line 2: the participant \"P/1\" is not",
        ),
        (
            "participant,sus_1\n,3\n",
            "line 2: the participant has no name",
        ),
        ("participant,sus_1\nP1,3,4\n", "no table can be read"),
        ("participant,task_a\nP1,3\n", "is no column of a task"),
        ("participant,task_a_seconds\nP1,x\n", "are no number"),
        ("participant,task_a_seconds\nP1,nan\n", "which is no time"),
        (
            "participant,task_a_seconds,task_a_outcome\nP1,,done\n",
            "has an outcome and no seconds",
        ),
        (
            "participant,task_a_seconds,task_a_outcome\nP1,3,finished\n",
            "is not done, time-over or left",
        ),
        ("participant,order,sus_1\nP1,0,3\n", "no number from 1 on"),
    ] {
        let told = paper::from_text(text, false, "t.csv").unwrap_err();
        let told = sentence(&told);
        assert!(told.contains(expected), "{text}: {told}");
    }
}

#[test]
fn what_is_no_condition_is_not_compared_with_everything() {
    let rows: String = (0..25).map(|row| format!("P{row},c{row},3\n")).collect();
    let text = format!("participant,condition,sus_1\n{rows}");
    let told = sentence(&paper::from_text(&text, false, "t").unwrap_err());
    assert!(
        told.contains("there are 25 conditions, more than 24"),
        "{told}"
    );
}

#[test]
fn who_is_there_twice_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("t.csv");
    std::fs::write(&table, "participant,sus_1\nP1,3\n\nP1,4\n").unwrap();
    let told = Study::read(&table, false).unwrap_err().to_string();
    assert!(
        told.contains("P1 is there twice under the condition all, in line 2 and in line 4"),
        "{told}"
    );
    for (from_one, remarks) in [(false, 1), (true, 0)] {
        std::fs::write(&table, "participant,ssq_before_1,ssq_before_2\nP1,1,2\n").unwrap();
        let study = Study::read(&table, from_one).unwrap();
        assert_eq!(study.remarks.len(), remarks, "{:?}", study.remarks);
    }
}

/// A 0 where 1 is none is no answer, and does not become one on its way through a table whose scale begins with 0.
#[test]
fn what_is_no_answer_stays_none_in_a_table() {
    let text = "participant,ssq_before_1,ssq_before_2,sus_1\nP1,0,5,7\n";
    let study = paper::from_text(text, true, "t").unwrap();
    let table = String::from_utf8(paper::table(&study).unwrap()).unwrap();
    let again = paper::from_text(&table, false, "t").unwrap();
    for (part, place) in [(Part::SsqBefore, 0), (Part::SsqBefore, 1), (Part::Sus, 0)] {
        let answer = &again.sittings[0].part(part)[place];
        assert!(matches!(answer, Answer::Strange(_)), "{answer:?}");
    }
}

#[test]
fn the_place_of_a_sitting_counts_those_under_other_conditions() {
    let folder = tempfile::tempdir().unwrap();
    let next = |condition: &str| answers::place_of_next(folder.path(), "P1", condition);
    assert_eq!(next("a"), 1);
    write(folder.path(), &form("P1", "a"));
    assert_eq!((next("a"), next("b")), (1, 2));
}

proptest! {
    /// Whatever is in a table: it is refused in a sentence, or every score is on its scale.
    #[test]
    fn scores_are_on_their_scales(cells in prop::collection::vec("[0-9]{0,1}|x|-1|2\\.5", 42), from_one: bool) {
        let names = |part: Part| (1..=part.items().unwrap()).map(move |item| format!("{}_{item}", part.name()));
        let parts = [Part::Sus, Part::SsqBefore, Part::SsqAfter];
        let names: Vec<String> = parts.into_iter().flat_map(names).collect();
        let text = format!("participant,{}\nP1,{}\n", names.join(","), cells.join(","));
        let report = report(&paper::from_text(&text, from_one, "t").unwrap());
        let one = &report.conditions[0];
        if let Some(sus) = &one.sus {
            prop_assert!((0.0..=100.0).contains(&sus.summary.mean));
        }
        for factor in &one.ssq {
            for summary in [factor.before, factor.after].into_iter().flatten() {
                prop_assert!((0.0..=300.0).contains(&summary.mean));
            }
        }
    }

    #[test]
    fn no_bytes_stop_the_reader(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        if let Ok(form) = Form::from_bytes(&bytes) {
            let _ = form.sitting("file".to_owned());
        }
    }
}
