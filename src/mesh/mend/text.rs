//! Mends as people write them: `weld=0.1%,debris,close=smooth:20`.
//!
//! ```text
//! list   = mend {"," mend}
//! mend   = name ["=" value]
//! length = number | number "%"          in the file's unit, or of the diagonal of the model's box
//! amount = whole number | number "%" | number with a point up to 1
//! ```
//!
//! What is wrong is told with the place in the text. Numbers are written back with as many digits as bring the same value.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use super::{Amount, Cap, Close, Debris, Decimate, Length, Mend, Remesh, Smooth, Weld};

/// Largest length; coordinates go as far.
const LONGEST: f64 = 1e15;

/// Most mends in a list.
const MENDS_MOST: usize = 100;

const NAMES: [&str; 8] = [
    "weld", "debris", "largest", "orient", "close", "smooth", "decimate", "remesh",
];

/// What cannot be understood in a mend or a list of mends.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("mend {place} of the list, `{word}`: {problem}")]
pub struct MendSyntax {
    /// Which mend of the list, from 1.
    pub place: usize,
    /// The mend as it stands there.
    pub word: String,
    /// What is wrong and what would be right.
    pub problem: String,
}

/// Reads mends parted by commas.
///
/// # Errors
/// The first that cannot be understood.
pub fn list_from_text(text: &str) -> Result<Vec<Mend>, MendSyntax> {
    let mut mends = Vec::new();
    for (at, word) in text.split(',').enumerate() {
        let error = |problem| MendSyntax {
            place: at + 1,
            word: shortened(word.trim()),
            problem,
        };
        if at >= MENDS_MOST {
            return Err(error(format!("a list has {MENDS_MOST} mends at most")));
        }
        mends.push(read(word).map_err(error)?);
    }
    Ok(mends)
}

/// Writes mends parted by commas.
pub fn text_from_list(mends: &[Mend]) -> String {
    let words: Vec<String> = mends.iter().map(Mend::to_string).collect();
    words.join(",")
}

impl Mend {
    /// Reads one mend as [`Display`] writes it.
    ///
    /// # Errors
    /// A name that is not known, with the nearest that is; a value that cannot be understood or is out of its limits.
    pub fn parse(text: &str) -> Result<Self, MendSyntax> {
        read(text).map_err(|problem| MendSyntax {
            place: 1,
            word: shortened(text.trim()),
            problem,
        })
    }
}

impl FromStr for Mend {
    type Err = MendSyntax;

    fn from_str(text: &str) -> Result<Self, MendSyntax> {
        Self::parse(text)
    }
}

impl TryFrom<String> for Mend {
    type Error = MendSyntax;

    fn try_from(text: String) -> Result<Self, MendSyntax> {
        Self::parse(&text)
    }
}

impl From<Mend> for String {
    fn from(mend: Mend) -> Self {
        mend.to_string()
    }
}

/// So much of a word as a sentence has room for.
fn shortened(word: &str) -> String {
    const MOST: usize = 40;
    match word.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    }
}

fn read(word: &str) -> Result<Mend, String> {
    let word = word.trim();
    let (name, value) = match word.split_once('=') {
        Some((name, value)) => (name.trim(), Some(value.trim())),
        None => (word, None),
    };
    let mend = match name {
        "weld" => Mend::Weld(match value {
            Some(value) => Weld {
                distance: length(value, true)?,
            },
            None => Weld::default(),
        }),
        "debris" => Mend::Debris(match value {
            Some(value) => Debris {
                below: amount(value)?,
            },
            None => Debris::default(),
        }),
        "largest" => none(value, Mend::Largest)?,
        "orient" => none(value, Mend::Orient)?,
        "close" => Mend::Close(value.map(cap).transpose()?.unwrap_or_default()),
        "smooth" => Mend::Smooth(match value {
            Some(value) => Smooth {
                passes: passes(value)?,
            },
            None => Smooth::default(),
        }),
        "decimate" => Mend::Decimate(match value {
            Some(value) => Decimate { to: amount(value)? },
            None => Decimate::default(),
        }),
        "remesh" => Mend::Remesh(match value {
            Some(value) => Remesh {
                edge: length(value, false)?,
            },
            None => Remesh::default(),
        }),
        "" => return Err(format!("a mend is missing here: {}", NAMES.join(", "))),
        other => {
            return Err(match nearest(other) {
                Some(near) => format!("there is no such mend; `{near}` is near"),
                None => format!("there is no such mend; there are {}", NAMES.join(", ")),
            });
        }
    };
    Ok(mend)
}

fn none(value: Option<&str>, mend: Mend) -> Result<Mend, String> {
    match value {
        Some(_) => Err(format!("`{mend}` has no value: leave it out")),
        None => Ok(mend),
    }
}

fn number(text: &str) -> Option<f64> {
    // Not what `f64` reads besides: words and signs.
    let is_number = text.starts_with(|c: char| c.is_ascii_digit() || c == '.');
    text.parse()
        .ok()
        .filter(|number: &f64| is_number && number.is_finite())
}

fn length(text: &str, may_be_zero: bool) -> Result<Length, String> {
    let found = match text.strip_suffix('%') {
        Some(percent) => number(percent.trim())
            .filter(|percent| *percent <= 100.0)
            .map(Length::Percent),
        None => number(text)
            .filter(|length| *length <= LONGEST)
            .map(Length::Units),
    };
    let is_zero = |length: &Length| match length {
        Length::Units(length) | Length::Percent(length) => *length <= 0.0,
    };
    found
        .filter(|length| may_be_zero || !is_zero(length))
        .ok_or_else(|| {
            let least = if may_be_zero { "from 0 on" } else { "above 0" };
            format!(
                "a length is a number {least} in the model's unit (0.5), or in hundredths of the diagonal of its box (0.1%)"
            )
        })
}

fn amount(text: &str) -> Result<Amount, String> {
    let share = |number: Option<f64>| {
        number
            .filter(|share| *share > 0.0 && *share <= 1.0)
            .map(Amount::Share)
    };
    let found = match text.strip_suffix('%') {
        Some(percent) => share(number(percent.trim()).map(|percent| percent / 100.0)),
        None if text.contains(['.', 'e', 'E']) => share(number(text)),
        None => text
            .parse()
            .ok()
            .filter(|triangles| *triangles > 0)
            .map(Amount::Triangles),
    };
    found.ok_or_else(|| {
        "this takes a number of triangles (5000) or a share above 0, up to all (25% or 0.25)"
            .to_owned()
    })
}

fn passes(text: &str) -> Result<u32, String> {
    let most = Smooth::PASSES_MOST;
    let found = text
        .parse()
        .ok()
        .filter(|passes| (1..=most).contains(passes));
    found.ok_or_else(|| format!("this takes a number of passes from 1 to {most}"))
}

fn cap(text: &str) -> Result<Close, String> {
    let (cap, longest) = match text.split_once(':') {
        Some((cap, longest)) => (cap.trim(), Some(length(longest.trim(), false)?)),
        None => (text, None),
    };
    let cap = match cap {
        "flat" => Cap::Flat,
        "smooth" => Cap::Smooth,
        _ => {
            return Err(
                "holes are closed `flat` or `smooth`, perhaps with the longest loop: smooth:20"
                    .to_owned(),
            );
        }
    };
    Ok(Close { cap, longest })
}

/// The known name that a word is likely meant for.
fn nearest(word: &str) -> Option<&'static str> {
    let wanted: Vec<char> = word.to_lowercase().chars().take(20).collect();
    let most = if wanted.len() < 4 { 1 } else { 2 };
    let scored = NAMES.map(|name| (changes(&wanted, name), name));
    let best = scored.into_iter().min()?;
    (best.0 <= most).then_some(best.1)
}

/// How many letters are to be changed, put in or taken away (Levenshtein).
fn changes(wanted: &[char], name: &str) -> usize {
    let mut row: Vec<usize> = (0..=wanted.len()).collect();
    for letter in name.chars() {
        let mut above_left = row[0];
        row[0] += 1;
        for (at, other) in wanted.iter().enumerate() {
            let change = above_left + usize::from(letter != *other);
            above_left = row[at + 1];
            row[at + 1] = change.min(row[at] + 1).min(above_left + 1);
        }
    }
    row[wanted.len()]
}

impl Display for Length {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Units(length) => write!(to, "{length}"),
            Self::Percent(percent) => write!(to, "{percent}%"),
        }
    }
}

impl Display for Amount {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Triangles(triangles) => write!(to, "{triangles}"),
            // With a point, which makes it a share: 1 alone would be a triangle.
            Self::Share(share) => write!(to, "{share:?}"),
        }
    }
}

impl Display for Mend {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Weld(weld) => write!(to, "weld={}", weld.distance),
            Self::Debris(debris) => write!(to, "debris={}", debris.below),
            Self::Largest => to.write_str("largest"),
            Self::Orient => to.write_str("orient"),
            Self::Close(close) => {
                let cap = match close.cap {
                    Cap::Flat => "flat",
                    Cap::Smooth => "smooth",
                };
                write!(to, "close={cap}")?;
                close
                    .longest
                    .map_or(Ok(()), |longest| write!(to, ":{longest}"))
            }
            Self::Smooth(smooth) => write!(to, "smooth={}", smooth.passes),
            Self::Decimate(decimate) => write!(to, "decimate={}", decimate.to),
            Self::Remesh(remesh) => write!(to, "remesh={}", remesh.edge),
        }
    }
}
