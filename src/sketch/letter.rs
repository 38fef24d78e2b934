//! The letters of a sketch: `A` is the trunk, each branch gets the next free one.
//!
//! A letter is also a module of the generated grammar, so every character that the turtle or the
//! growth rules give a meaning is left out: `B` marks a growing end, `F` and `G` draw, `T` sets the
//! tropism. After `Z` the words `C1`, `D1`, … follow, which the grammar declares.
//! A letter is a small number with a name, so hovering and hashing copy no strings.

use std::{fmt, str::FromStr};

use serde::{Deserialize, Serialize};

/// The characters that may name a stroke; the first one is the trunk's alone.
const SYMBOLS: &[u8; 22] = b"ACDEHIJKLMNOPQRSUVWXYZ";

/// The name of a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Letter(u16);

impl Letter {
    /// The trunk.
    pub const TRUNK: Self = Self(0);

    /// The letter's place in the sequence A, C, D, …, Z, C1, D1, ….
    #[must_use]
    pub const fn index(self) -> u16 {
        self.0
    }

    /// The letter at a place of the sequence A, C, D, …, Z, C1, D1, ….
    #[must_use]
    pub const fn from_index(index: u16) -> Self {
        Self(index)
    }

    /// The character and the number of the round (0: a bare character).
    fn parts(self) -> (char, u16) {
        let branches = SYMBOLS.len() - 1;
        let Some(branch) = usize::from(self.0).checked_sub(1) else {
            return (char::from(SYMBOLS[0]), 0);
        };
        let round = u16::try_from(branch / branches).unwrap_or(u16::MAX);
        (char::from(SYMBOLS[1 + branch % branches]), round)
    }

    /// Whether the name is longer than one character, so that a grammar must declare it.
    #[must_use]
    pub fn is_word(self) -> bool {
        self.parts().1 > 0
    }
}

impl fmt::Display for Letter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.parts() {
            (symbol, 0) => write!(f, "{symbol}"),
            (symbol, round) => write!(f, "{symbol}{round}"),
        }
    }
}

impl From<Letter> for String {
    fn from(letter: Letter) -> Self {
        letter.to_string()
    }
}

impl FromStr for Letter {
    type Err = UnknownLetter;

    fn from_str(name: &str) -> Result<Self, UnknownLetter> {
        // Long garbage is not repeated in the message.
        let unknown = || UnknownLetter(name.chars().take(12).collect());
        let mut characters = name.chars();
        let symbol = characters.next().ok_or_else(unknown)?;
        let place = SYMBOLS
            .iter()
            .position(|&known| char::from(known) == symbol)
            .ok_or_else(unknown)?;
        let number = characters.as_str();
        let round = match number {
            "" => 0,
            _ if place == 0 || number.starts_with(['0', '+']) => return Err(unknown()),
            _ => number.parse::<u16>().map_err(|_| unknown())?,
        };
        let index = usize::from(round) * (SYMBOLS.len() - 1) + place;
        u16::try_from(index).map(Self).map_err(|_| unknown())
    }
}

impl TryFrom<String> for Letter {
    type Error = UnknownLetter;

    fn try_from(name: String) -> Result<Self, UnknownLetter> {
        name.parse()
    }
}

/// A name that no stroke can have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no letter of a sketch: use A for the trunk and C, D, E, H … Z, C1, D1 … for branches (B, F, G and T have other meanings)"
)]
pub struct UnknownLetter(String);

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;

    #[test]
    fn the_sequence_skips_what_has_a_meaning() {
        let names: Vec<_> = (0..26).map(|i| Letter::from_index(i).to_string()).collect();
        let expected = "A C D E H I J K L M N O P Q R S U V W X Y Z C1 D1 E1 H1";
        assert_eq!(names.join(" "), expected, "letters in drawing order");
    }

    #[test]
    fn every_name_reads_back() {
        for index in 0..=u16::MAX {
            let letter = Letter::from_index(index);
            assert_eq!(letter.to_string().parse(), Ok(letter), "letter {index}");
            assert_eq!(letter.is_word(), index > 21, "letter {index}");
        }
    }

    #[test]
    fn other_names_are_refused() {
        for name in [
            "", "B", "F", "G", "T", "a", "A1", "C0", "C01", "C+1", "C-1", "C 1", "CC", "Ä",
            "C99999",
        ] {
            let message = name.parse::<Letter>().unwrap_err().to_string();
            assert!(message.contains(&format!("`{name}`")), "{message}");
        }
    }
}
