//! The translators of cpfg, L-Py and Houdini: the first byte picks one, and what it writes must be read again as it was.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::lsystem::Grammar;
use ramus::lsystem::dialect::{Dialect, import};

fuzz_target!(|bytes: &[u8]| {
    let Some((first, rest)) = bytes.split_first() else {
        return;
    };
    let Ok(text) = std::str::from_utf8(rest) else {
        return;
    };
    let dialect = Dialect::ALL[usize::from(*first) % Dialect::ALL.len()];
    // A name that is no file: includes find nothing to read.
    if let Ok(imported) = import(text, "fuzz-input", dialect) {
        Grammar::parse(&imported.text, "written").expect("what is written is a grammar");
    }
});
