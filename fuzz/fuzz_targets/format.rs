//! The formatter of grammars: what can be read can be laid out, means the same then (which `format` looks at itself), and is
//! its own layout.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::lsystem::{Grammar, format};

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match format(text, "fuzz-input") {
        Ok(once) => assert_eq!(format(&once, "fuzz-input"), Ok(once)),
        Err(error) => assert!(Grammar::parse(text, "fuzz-input").is_err(), "{error}"),
    }
});
