//! What the parts of a tree are called in files: by what an artist looks for, not by numbers.
//!
//! `wood` is what has bark; leaves of all species are `leaves`; needles, blossom, fruit, cones, spines keep their names; what a grammar paints is
//! `painted` with the number of its material, as grammars give it.

use super::surface::{Matter, Surface};
use crate::tree::foliage::kind;

/// Built-in surfaces that are leaves, whatever their species.
const LEAVES: [&str; 7] = [
    "leaf", "maple", "oak", "birch", "willow", "ovate", "pinnule",
];

/// A name for each group of a surface, no two of them alike.
pub(super) fn names(surface: &Surface<'_>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for group in &surface.groups {
        names.push(unlike(&names, name(surface, group.matter)));
    }
    names
}

/// The same as USD has them: names that differ may be one identifier.
pub(super) fn identifiers(surface: &Surface<'_>) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for group in &surface.groups {
        names.push(unlike_identifier(&names, &name(surface, group.matter)));
    }
    names
}

/// A name that none of these has.
pub(super) fn unlike(names: &[String], name: String) -> String {
    numbered(names, name, '-')
}

/// A name as USD has them that none of these is.
pub(super) fn unlike_identifier(names: &[String], name: &str) -> String {
    numbered(names, identifier(name), '_')
}

/// A name, with a number behind it where one of these has it already.
fn numbered(names: &[String], name: String, between: char) -> String {
    let mut other = name.clone();
    let mut number = 2;
    while names.contains(&other) {
        other = format!("{name}{between}{number}");
        number += 1;
    }
    other
}

pub(super) fn name(surface: &Surface<'_>, matter: Matter) -> String {
    let palette = &surface.organs.palette;
    match matter {
        Matter::Bark => "wood".to_owned(),
        Matter::Painted(0) if !palette.is_named(0) => "painted".to_owned(),
        Matter::Painted(index) if !palette.is_named(index) => format!("painted-{index}"),
        Matter::Painted(index) => {
            let name = palette.name(index);
            match kind(&name) {
                Some(known) if LEAVES.contains(&known.surface) => "leaves".to_owned(),
                Some(known) => known.name.to_owned(),
                None => format!("leaves-{name}"),
            }
        }
    }
}

/// A name as USD has them: letters, digits and low lines, no digit first.
pub(super) fn identifier(name: &str) -> String {
    let mut made: String = name
        .chars()
        .map(|c| if c.is_ascii_alphanumeric() { c } else { '_' })
        .collect();
    if !made.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        made.insert(0, '_');
    }
    made
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn names_are_fit_for_their_file_and_unlike_each_other() {
        assert_eq!(identifier("young oak-3"), "young_oak_3");
        assert_eq!(identifier("3 oaks"), "_3_oaks");
        assert_eq!(identifier(""), "_");
        assert_eq!(identifier("Ästchen"), "_stchen");
        let taken = ["leaves", "leaves-2"].map(str::to_owned);
        assert_eq!(unlike(&taken, "leaves".to_owned()), "leaves-3");
        assert_eq!(unlike(&taken, "wood".to_owned()), "wood");
    }

    #[test]
    fn identifiers_differ_where_names_differ_in_letters_that_usd_has_not() {
        let mut taken: Vec<String> = Vec::new();
        for name in ["leaves-ä", "leaves-ö", "leaves-ü", "leaves-__2"] {
            taken.push(unlike_identifier(&taken, name));
        }
        assert_eq!(
            taken,
            ["leaves__", "leaves___2", "leaves___3", "leaves___2_2"]
        );
        for name in &taken {
            assert_eq!(&identifier(name), name);
        }
    }
}
