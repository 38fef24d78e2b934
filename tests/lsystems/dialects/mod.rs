//! Grammars of cpfg, L-Py and Houdini: what they become, what they derive, where their faults are told.

mod cpfg;
mod hostile;
mod houdini;
mod lpy;
mod reference;

use ramus::lsystem::dialect::{Dialect, Imported, import};
use ramus::lsystem::{Grammar, Limits};

use super::derive;

fn brought(dialect: Dialect, text: &str) -> Imported {
    import(text, "test", dialect).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The lines of what is made of a text, without the first, which says where it comes from, and without `except`.
fn lines(dialect: Dialect, text: &str, except: &[&str]) -> Vec<String> {
    let text = brought(dialect, text).text;
    let kept = text.lines().skip(1);
    let wanted = |line: &&str| !except.iter().any(|word| line.starts_with(word));
    kept.filter(wanted).map(|l| l.trim().to_owned()).collect()
}

/// The first fault of a text: line, column, message.
fn fault(dialect: Dialect, text: &str) -> (usize, usize, String) {
    match import(text, "test", dialect) {
        Err(faults) => {
            let first = &faults.errors[0];
            (first.line, first.column, first.message.clone())
        }
        Ok(imported) => panic!("no fault in\n{text}\n→\n{}", imported.text),
    }
}

/// The string that a file of another program derives to, read directly.
fn string(text: &str, steps: u32) -> String {
    let grammar = Grammar::parse(text, "test").unwrap_or_else(|e| panic!("{e}\n{text}"));
    let made = derive(&grammar, steps);
    let again = brought(ramus::lsystem::dialect::named(text).unwrap(), text);
    let written = Grammar::parse(&again.text, "test.lsys").unwrap();
    let limits = Limits::default();
    let same = written
        .derive(steps, &limits, &std::sync::atomic::AtomicBool::new(false))
        .unwrap();
    assert_eq!(
        same.to_text(&written),
        made.to_text(&grammar),
        "what import writes derives to the same string"
    );
    made.to_text(&grammar)
}
