//! The readers of a study's answers: no bytes may stop them, and whatever they say comes to a report that can be told and written as a table.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::app::study::answers::Form;
use ramus::app::study::picture::picture;
use ramus::app::study::plan::plan;
use ramus::app::study::report::report;
use ramus::app::study::told::told;
use ramus::app::study::{Study, paper};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(sitting) = Form::from_bytes(bytes).and_then(|form| form.sitting("file".to_owned())) {
        let study = Study {
            sittings: vec![sitting],
            ..Study::default()
        };
        told(&report(&study));
        picture(&study, &report(&study));
        assert!(paper::table(&study).is_ok());
    }
    let Ok(text) = str::from_utf8(bytes) else {
        return;
    };
    let _ = plan(text);
    for from_one in [false, true] {
        if let Ok(study) = paper::from_text(text, from_one, "table") {
            told(&report(&study));
            picture(&study, &report(&study));
            let table = paper::table(&study).expect("what was read can be written");
            let table = String::from_utf8(table).expect("of text comes text");
            let again = paper::from_text(&table, false, "table").expect("what was written can be read");
            assert_eq!(report(&again).conditions, report(&study).conditions, "{table}");
        }
    }
});
