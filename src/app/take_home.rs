//! What a session leaves to take home: its tree as a file, and a line that says what it is.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result};

use crate::app::export;
use crate::sketch;
use crate::tree::file::write_atomically;
use crate::world::World;

/// One line on what a session made.
#[must_use]
pub fn summary(world: &World) -> String {
    let document = world.document();
    let lines = document
        .sketch
        .strokes
        .iter()
        .filter(|stroke| stroke.segments() > 0)
        .count();
    let drawn = document.sketch.segments().count();
    let grown = sketch::predict_segments(&document.sketch, document.step);
    format!(
        "{lines} lines of {drawn} segments drawn, {grown} segments grown at step {}",
        document.step
    )
}

/// Writes the full-size tree of the document's step.
///
/// # Errors
/// Where there is no tree yet or it cannot be written.
pub fn export(world: &World, path: &Path) -> Result<()> {
    let document = world.document();
    let grown = sketch::grow(&document.sketch, document.step, &AtomicBool::new(false))?;
    export::tree(&grown.tree, path).with_context(|| "the tree was not written")
}

/// Writes the grammar that the sketch became, to be read, edited and derived.
///
/// # Errors
/// Where it cannot be written.
pub fn grammar(world: &World, path: &Path) -> Result<()> {
    let text = world.document().sketch.grammar_text();
    write_atomically(path, text.as_bytes()).context("the grammar was not written")
}
