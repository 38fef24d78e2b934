//! The reader of project files: no bytes may stop it, and what it read must survive writing.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::world::project;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(document) = project::from_bytes(bytes) {
        let written = project::to_bytes(&document);
        let again = project::from_bytes(&written).expect("what was written can be read");
        assert_eq!(
            written,
            project::to_bytes(&again),
            "writing and reading change nothing"
        );
    }
});
