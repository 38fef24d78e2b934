//! The reader of recorded sessions: no bytes may stop it, and what it read must survive writing.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus_xr::session;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(frames) = session::from_bytes(bytes) {
        let written = session::to_bytes(&frames).expect("what was read can be written");
        let again = session::from_bytes(&written).expect("what was written can be read");
        assert_eq!(frames, again, "writing and reading change nothing");
    }
});
