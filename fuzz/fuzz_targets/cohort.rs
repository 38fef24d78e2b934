//! The readers of analyses, lists and groups: no bytes may stop them, and whatever an analysis says can be compared and drawn.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use ramus::app::cohort::groups::Groups;
use ramus::app::cohort::told::Told;
use ramus::app::cohort::{Cohort, Model, entries, pictures};

fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = str::from_utf8(bytes) {
        let _ = Groups::from_text(text, Path::new("groups.csv"));
        if let Ok(listed) = entries::from_text(text, Path::new("list.csv")) {
            let again = entries::plan(&listed).expect("what was read can be written");
            assert!(entries::from_text(&again, Path::new("list.csv")).is_ok());
        }
    }
    let Ok(told) = Told::from_bytes(bytes) else {
        return;
    };
    let models = (0..5).map(|place| Model {
        label: place.to_string(),
        group: Some(place % 2),
        told: told.clone(),
    });
    let cohort = Cohort {
        models: models.collect(),
        groups: vec!["a".to_owned(), "b".to_owned()],
        unknown: Vec::new(),
    };
    pictures(&cohort, &cohort.comparisons());
});
