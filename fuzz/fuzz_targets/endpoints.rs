//! The readers of endpoints: no bytes may stop them, and what they read is written and read again the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::mesh::endpoints::{from_csv, from_json, to_csv, to_json};

fuzz_target!(|bytes: &[u8]| {
    for list in [from_csv(bytes), from_json(bytes)] {
        let Ok(list) = list else { continue };
        let json = from_json(to_json(&list).as_bytes()).expect("what was written can be read");
        assert_eq!(json, list, "nothing is lost");
        let csv = from_csv(to_csv(&list).as_bytes()).expect("what was written can be read");
        assert_eq!(csv.len(), list.len(), "no endpoint is lost");
    }
});
