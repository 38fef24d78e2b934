//! Everything that can go wrong with trees and their files, each in one sentence that says how to mend it.

use std::path::PathBuf;

/// A number for people: one that came from an f32 with the digits of an f32 (0.3, not 0.30000001192092896).
pub(crate) fn shortest(value: f64) -> String {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "only whether it is an f32 is asked"
    )]
    let narrow = value as f32;
    let plain = value == 0.0 || (1e-5..1e16).contains(&value.abs());
    match (f64::from(narrow) == value, plain) {
        (true, true) => narrow.to_string(),
        (true, false) => format!("{narrow:e}"),
        (false, true) => value.to_string(),
        (false, false) => format!("{value:e}"),
    }
}

/// An error of the room `tree`.
#[derive(Debug, thiserror::Error)]
pub enum TreeError {
    /// The arrays of a tree differ in length.
    #[error(
        "the tree's arrays differ in length (`{array}` has {found} entries, `parent` has {expected}): push whole nodes"
    )]
    Lengths {
        /// Name of the field.
        array: &'static str,
        /// Its length.
        found: usize,
        /// Length of `parent`.
        expected: usize,
    },
    /// More nodes than u32 indices can count.
    #[error("the tree has {0} nodes, and 32-bit indices end at 4294967294: split it")]
    TooManyNodes(usize),
    /// A parent does not stand before its child.
    #[error(
        "node {node} names {parent} as its parent, but a parent must stand before its child: sort the nodes"
    )]
    Parent {
        /// Index of the node.
        node: usize,
        /// Its `parent` entry.
        parent: u32,
    },
    /// A letter index without a letter.
    #[error(
        "node {node} uses letter {letter} of {letters}: add the letter's name to the tree first"
    )]
    Letter {
        /// Index of the node.
        node: usize,
        /// Its `letter` entry.
        letter: u16,
        /// Number of letters.
        letters: usize,
    },
    /// A position that is not a finite number of metres.
    #[error("node {0} has a position that is not finite: check the numbers it was made from")]
    Position(usize),
    /// A radius that is negative or not finite.
    #[error("node {node} has the radius {radius}: it must be finite and not negative")]
    Radius {
        /// Index of the node.
        node: usize,
        /// Its radius in metres.
        radius: f32,
    },
    /// A parameter outside its range.
    #[error(
        "{name} is {}, but must lie between {} and {}: choose a value in that range",
        shortest(*value),
        shortest(*least),
        shortest(*most)
    )]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest value allowed.
        least: f64,
        /// Largest value allowed.
        most: f64,
    },
    /// What the tree carries does not fit it.
    #[error(transparent)]
    Organs(#[from] super::organs::OrganError),
    /// Nothing to export.
    #[error(
        "the tree has no segment, so there is nothing to write as {0}: segments are drawn by `F` and by the letters of shapes"
    )]
    Empty(&'static str),
    /// SWC holds one root.
    #[error(
        "the tree has {0} roots, since it was drawn with gaps, but an SWC file holds one: draw with `F` where the grammar moves with `f`, or export it as GLB or OBJ"
    )]
    ManyRoots(usize),
    /// The file would be larger than its format (or memory) allows.
    #[error(
        "a {format} file of this may take up to {:.1} GB, and is written up to {:.1} GB: take fewer steps or trees, or a coarser level of detail",
        gigabytes(*.bytes),
        gigabytes(super::export::MOST_BYTES)
    )]
    TooLarge {
        /// Format's name.
        format: &'static str,
        /// What it may take at most.
        bytes: u64,
    },
    /// The machine did not give the memory.
    #[error(
        "the machine does not give the memory for the tubes of {0} segments: take fewer steps, or close other programs"
    )]
    Memory(usize),
    /// Positions and radii that leave f32 when they are added.
    #[error("the tree is so large that 32-bit coordinates cannot hold its surface: scale it down")]
    TooWide,
    /// The bark texture could not be encoded (a fault of the program).
    #[error("the bark texture could not be encoded as PNG ({0}): please report this")]
    Texture(String),
    /// A line of an SWC file that cannot be read.
    #[error("line {line} of the SWC file {problem}")]
    Swc {
        /// Line number from 1.
        line: usize,
        /// What is wrong and how to mend it, as the rest of the sentence.
        problem: String,
    },
    /// An SWC file without a single node.
    #[error("the SWC file holds no node: each node is a line `id type x y z radius parent`")]
    SwcEmpty,
    /// A file could not be written; the old one, if there was one, is still whole.
    #[error("{problem}; any older file there is unchanged: {path}", path = path.display())]
    Write {
        /// What is wrong and how to mend it.
        problem: String,
        /// The file that was to be written.
        path: PathBuf,
    },
}

#[allow(clippy::cast_precision_loss, reason = "one digit is told")]
fn gigabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e9
}
