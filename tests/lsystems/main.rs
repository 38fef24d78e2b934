//! The L-system engine through its public interface: reference systems, the language, the turtle, a slow interpreter as
//! oracle, and hostile input.
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::missing_assert_message,
    clippy::float_cmp,
    reason = "a test fails by panic, and its data is known"
)]

mod canvas;
mod dialects;
mod faults;
mod gallery;
mod growth;
mod guide;
mod history;
mod hostile;
mod include;
mod language;
mod oracle;
mod organs;
mod queries;
mod record;
mod reference;
mod sketch_cases;
mod turtle;
mod unwritten;
mod widths;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use ramus::lsystem::{Grammar, Limits, ModuleString, TurtleParams, interpret};
use ramus::tree::Tree;

/// A file of the folder with all reference data, where `RAMUS_SHARED` names it.
fn shared(name: &str) -> Option<String> {
    let Some(folder) = std::env::var_os("RAMUS_SHARED") else {
        eprintln!("skipped: RAMUS_SHARED does not name the folder with reference/{name}");
        return None;
    };
    Some(std::fs::read_to_string(PathBuf::from(folder).join("reference").join(name)).unwrap())
}

fn parse(text: &str) -> Grammar {
    Grammar::parse(text, "test.lsys").unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn derive(grammar: &Grammar, steps: u32) -> ModuleString {
    grammar
        .derive(steps, &Limits::default(), &AtomicBool::new(false))
        .unwrap()
}

fn text_of(grammar: &Grammar, steps: u32) -> String {
    derive(grammar, steps).to_text(grammar)
}

fn draw(grammar: &Grammar, string: &ModuleString) -> Tree {
    interpret(
        grammar,
        string,
        &TurtleParams::default(),
        &AtomicBool::new(false),
    )
    .unwrap()
}
