//! SWC: one line a node, `id type x y z radius parent`, the exchange format of neuron morphology.
//!
//! Specification: <https://swc-specification.readthedocs.io>. It asks for one root, parents before children and ids from 1, and
//! that is what is written. Readers take lengths as micrometres; a tree's are metres, and the header says so in words:
//! scaling them here would only make a plant of a million units that no reader of ours or theirs gains from.
//! Numbers are written with as many digits as bring back the same f32.

use std::collections::BTreeSet;
use std::io::{self, Write};

use crate::tree::{NO_PARENT, Tree, TreeError};

/// First structure type that the format leaves to its users.
const FIRST_CUSTOM_TYPE: u32 = 5;

/// The tree as an SWC file.
///
/// # Errors
/// As [`Swc::new`].
pub fn swc(tree: &Tree) -> Result<Vec<u8>, TreeError> {
    let file = Swc::new(tree)?;
    let mut text = Vec::new();
    let _ = file.write(&mut text); // Writing into a vector cannot fail.
    Ok(text)
}

/// An SWC file that is checked and not written yet.
///
/// A letter's structure type is 5 (the first custom one) plus its index; the header names each.
#[derive(Clone, Copy, Debug)]
pub struct Swc<'a> {
    tree: &'a Tree,
    unit: &'a str,
}

/// What a plant's numbers are.
const METRES: &str = "metre (1 unit = 1 m = 1000000 micrometre); Y up";

impl<'a> Swc<'a> {
    /// Checks a tree.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has no segment or more than one root.
    pub fn new(tree: &'a Tree) -> Result<Self, TreeError> {
        tree.validate()?;
        match tree.root_count() {
            _ if tree.segment_count() == 0 => Err(TreeError::Empty("SWC")),
            0 | 1 => Ok(Self { tree, unit: METRES }),
            roots => Err(TreeError::ManyRoots(roots)),
        }
    }

    /// With other words on what its numbers are, in one line.
    #[must_use]
    pub fn in_unit(self, unit: &'a str) -> Self {
        Self { unit, ..self }
    }

    /// Writes the file.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        write_lines(out, self.tree, self.unit)
    }
}

fn write_lines(text: &mut dyn Write, tree: &Tree, unit: &str) -> io::Result<()> {
    writeln!(
        text,
        "# Ramus {}: {} segments",
        env!("CARGO_PKG_VERSION"),
        tree.segment_count()
    )?;
    writeln!(text, "# unit: {unit}")?;
    for &letter in &tree.letter.iter().copied().collect::<BTreeSet<u16>>() {
        let name = &tree.letters[usize::from(letter)];
        // One line each, whatever the name holds.
        let name: String = name
            .chars()
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        writeln!(
            text,
            "# type {}: letter {name}",
            FIRST_CUSTOM_TYPE + u32::from(letter)
        )?;
    }
    writeln!(text, "# id type x y z radius parent")?;
    for (node, &parent) in tree.parent.iter().enumerate() {
        let kind = FIRST_CUSTOM_TYPE + u32::from(tree.letter[node]);
        let [x, y, z] = tree.position[node].to_array();
        let radius = tree.radius[node];
        write!(text, "{} {kind} {x} {y} {z} {radius} ", node + 1)?;
        match parent {
            NO_PARENT => writeln!(text, "-1")?,
            parent => writeln!(text, "{}", u64::from(parent) + 1)?,
        }
    }
    Ok(())
}
