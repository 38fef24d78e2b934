//! What a session leaves to take home: its tree as a file, and a line that says what it is.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result};

use crate::app::export::{self, Format};
use crate::app::wood;
use crate::sketch;
use crate::tree::Drawing;
use crate::tree::export::{ExportParams, Extras};
use crate::tree::file::write_atomically;
use crate::world::World;
use crate::world::document::Document;

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
    let (step, most) = (document.step, sketch::MAX_SEGMENTS);
    // A sketch of copies in copies may have more than can be counted in a lifetime: the count ends at the bound.
    if !document.sketch.own_rules.is_empty() {
        return format!(
            "{lines} lines of {drawn} segments drawn, grown to step {step} by rules of your own"
        );
    }
    if document.sketch.habit.is_uncertain() {
        return format!(
            "{lines} lines of {drawn} segments drawn, grown to step {step} by its laws"
        );
    }
    let grown = match sketch::predict_segments_within(&document.sketch, step, most) {
        Some(grown) => format!("{grown} segments grown"),
        None => format!("more than {most} segments to grow"),
    };
    format!("{lines} lines of {drawn} segments drawn, {grown} at step {step}")
}

/// Writes the full-size tree of the document's step, with what is planted around it where a file can hold that.
///
/// # Errors
/// Where there is no tree yet or it cannot be written.
pub fn export(document: &Document, path: &Path) -> Result<()> {
    if holds_planted(document, path) {
        let wood = wood::grown(document, None)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let sides = ExportParams::default().sides;
        let trees = wood.iter().map(|one| {
            let Drawing { tree, organs } = &one.drawing;
            (tree, organs, sides, one.places.as_slice())
        });
        let stand = wood::stand(&name, trees, Extras::default());
        return export::stand(&stand, path).context("the planted trees were not written");
    }
    let grown = sketch::grow(&document.sketch, document.step, &AtomicBool::new(false))?;
    export::drawing(&grown.tree, &grown.organs, path).with_context(|| "the tree was not written")
}

/// Whether a file that the tree is taken home as holds the planted ones, too: all surfaces do; a skeleton and a grammar are of one tree.
#[must_use]
pub fn holds_planted(document: &Document, path: &Path) -> bool {
    let format = Format::of(path);
    !document.grove.is_empty() && !matches!(format, Ok(Format::Swc) | Err(_))
}

/// Writes the grammar that the sketch became, to be read, edited and derived.
///
/// # Errors
/// Where it cannot be written.
pub fn grammar(document: &Document, path: &Path) -> Result<()> {
    let text = document.sketch.grammar_text();
    write_atomically(path, text.as_bytes()).context("the grammar was not written")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::{
        sketch::{BOUNDS, Letter, NodeRef, Sketch},
        world::history::History,
    };
    use glam::Vec3;

    /// A trunk of two segments whose branch carries itself at each node: it doubles with every other step.
    fn world_at(step: u32) -> World {
        let (sketch, _) = Sketch::default()
            .add_segments(NodeRef::ROOT, &[Vec3::Y * 0.1, Vec3::Y * 0.2])
            .unwrap();
        let fork = NodeRef::new(Letter::TRUNK, 1);
        let (sketch, _) = sketch.add_segment(fork, Vec3::X * 0.1).unwrap();
        World::new(History::new(Document {
            sketch: sketch.into(),
            step,
            ..Document::default()
        }))
    }

    #[test]
    fn the_summary_counts_no_further_than_a_tree_may_grow() {
        for (step, expected) in [
            (
                7,
                "2 lines of 3 segments drawn, 33 segments grown at step 7",
            ),
            (
                BOUNDS.step,
                "2 lines of 3 segments drawn, more than 2000000 segments to grow at step 10000",
            ),
        ] {
            assert_eq!(summary(&world_at(step)), expected, "step {step}");
        }
    }
}
