//! The reader of grammars, then a few bounded steps of derivation and the turtle on what it accepted.
#![no_main]

use std::sync::atomic::AtomicBool;

use libfuzzer_sys::fuzz_target;
use ramus::lsystem::{Grammar, Limits, TurtleParams, draw};

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    // A name that is no file: includes find nothing to read.
    let Ok(grammar) = Grammar::parse(text, "fuzz-input") else {
        return;
    };
    let limits = Limits {
        modules: 5_000,
        bytes: 1 << 20,
    };
    let cancel = AtomicBool::new(false);
    if let Ok(string) = grammar.derive(3, &limits, &cancel) {
        let _ = string.to_text(&grammar);
        let params = TurtleParams {
            limits,
            ..TurtleParams::default()
        };
        if let Ok(made) = draw(&grammar, &string, &params, &cancel) {
            made.tree.validate().expect("the turtle draws whole trees");
            let fits = made.organs.validate(&made.tree);
            fits.expect("what they carry fits them");
        }
    }
});
