//! The species that a person can begin with: sketches with their habit, as project files.
//!
//! A species is a project like anybody's own (`assets/species/*.ramus`), so all that grows of it is in its sketch, and a person's own
//! projects stand beside them.

use super::document::{Document, Edit};
use super::project;

/// A species.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Species {
    /// Its name: that of its file.
    pub name: &'static str,
    /// The project.
    project: &'static str,
    /// What it looks like: PNG.
    pub picture: &'static [u8],
}

macro_rules! species {
    ($($name:literal),*) => {
        [$(Species {
            name: $name,
            project: include_str!(concat!("../../assets/species/", $name, ".ramus")),
            picture: include_bytes!(concat!("../../assets/species/", $name, ".png")),
        }),*]
    };
}

/// All of them.
pub static SPECIES: [Species; 8] = species!(
    "maple", "oak", "birch", "spruce", "willow", "apple", "fern", "cactus"
);

impl Species {
    /// What begins with it.
    #[must_use]
    pub fn edit(&self) -> Edit {
        Edit::TakeSpecies {
            project: self.project.to_owned(),
        }
    }

    /// Its document; the test holds that it is one.
    #[must_use]
    pub fn document(&self) -> Document {
        project::from_bytes(self.project.as_bytes()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::sketch;

    /// Each can be read and grown, stands on the ground in real metres, bears leaves, and is written as Ramus writes it.
    #[test]
    fn every_species_grows() {
        for species in &SPECIES {
            let name = species.name;
            let document = project::from_bytes(species.project.as_bytes()).unwrap();
            let file = format!("{}/assets/species/{name}.ramus", env!("CARGO_MANIFEST_DIR"));
            let bytes = project::to_bytes(&document);
            if std::env::var_os("UPDATE_SPECIES").is_some() {
                std::fs::write(&file, &bytes).unwrap();
            }
            let is_canonical = std::fs::read(&file).unwrap() == bytes;
            assert!(is_canonical, "{name}: UPDATE_SPECIES=1 writes it anew");
            let never = AtomicBool::new(false);
            let grown = sketch::grow(&document.sketch, document.step, &never).unwrap();
            grown.tree.validate().unwrap();
            grown.organs.validate(&grown.tree).unwrap();
            let (_, high) = grown.tree.bounds().unwrap();
            for seed in 0..8 {
                let one = sketch::grow(&document.sketch.with_seed(seed), document.step, &never);
                let low = one.unwrap().tree.bounds().unwrap().0;
                assert!(
                    low.y > -1e-5,
                    "{name} {seed} grows into the ground: {}",
                    low.y
                );
            }
            assert!((0.3..16.0).contains(&high.y), "{name} is {} m high", high.y);
            assert!(
                (30..30_000).contains(&grown.tree.len()),
                "{name}: {} nodes",
                grown.tree.len()
            );
            assert!(
                (50..80_000).contains(&grown.organs.placed.len()),
                "{name}: {} leaves",
                grown.organs.placed.len()
            );
            // It is the tree of its grammar, and another seed is another tree.
            let other =
                sketch::grow(&document.sketch.with_seed(99), document.step, &never).unwrap();
            assert_ne!(other.tree, grown.tree, "{name}");
        }
    }

    #[test]
    fn taking_a_species_is_an_edit_that_can_be_undone() {
        let before = Document::default();
        for species in &SPECIES {
            let after = before.after(&species.edit()).unwrap();
            assert_eq!(*after.sketch, *species.document().sketch);
            assert_eq!(after.platform, before.platform);
            after.validate().unwrap();
        }
        let bad = Edit::TakeSpecies {
            project: "{}".to_owned(),
        };
        let refused = before.after(&bad).unwrap_err().to_string();
        assert!(refused.contains("cannot be taken"), "{refused}");
    }
}
