//! Which unit a model's numbers are most likely in. PLY, STL, OBJ and VTK do not say; glTF means metres; SWC does not say either, but
//! its files are in micrometres by custom (<https://swc-specification.readthedocs.io>; some atlases have nanometres or voxels).
//!
//! The longest side of the box tells, by what branching structures are: plants are measured in metres, organs and vessels are scanned in
//! millimetres (as DICOM has it), neurons are traced in micrometres or, from electron microscopes, in nanometres.
//!
//! | longest side | guess | or |
//! |---|---|---|
//! | below 20 | metres: a plant, or an organ in metres | centimetres, millimetres |
//! | 20 to 2,000 | millimetres: an organ or a small plant | centimetres, metres |
//! | 2,000 to 50,000 | micrometres: a neuron | millimetres |
//! | from 50,000 on | nanometres: a neuron from an electron microscope | micrometres |
//!
//! It is a guess and called so; nothing is ever scaled by it unasked. A model of no size or of no finite size has no guess.

use serde::{Deserialize, Serialize};

/// What a number of a model's file stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// 1 m.
    Metres,
    /// 10⁻² m.
    Centimetres,
    /// 10⁻³ m.
    Millimetres,
    /// 10⁻⁶ m.
    Micrometres,
    /// 10⁻⁹ m.
    Nanometres,
}

impl Unit {
    /// How many metres one is.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metres => 1.0,
            Self::Centimetres => 1e-2,
            Self::Millimetres => 1e-3,
            Self::Micrometres => 1e-6,
            Self::Nanometres => 1e-9,
        }
    }

    /// As it is written behind a number.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metres => "m",
            Self::Centimetres => "cm",
            Self::Millimetres => "mm",
            Self::Micrometres => "µm",
            Self::Nanometres => "nm",
        }
    }

    /// As it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metres => "metres",
            Self::Centimetres => "centimetres",
            Self::Millimetres => "millimetres",
            Self::Micrometres => "micrometres",
            Self::Nanometres => "nanometres",
        }
    }
}

/// A number with three digits, as people read it: `0.012`, `3.40`, `12.5`, `1280`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rounded(pub f64);

impl std::fmt::Display for Rounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let size = self.0.abs();
        let decimals = match size {
            _ if size >= 100.0 => 0,
            _ if size >= 10.0 => 1,
            _ if size >= 1.0 || size == 0.0 => 2,
            _ if size >= 0.1 => 3,
            _ if size >= 1e-3 => 4,
            _ => return write!(f, "{:.2e}", self.0),
        };
        write!(f, "{:.decimals$}", self.0)
    }
}

/// How sure a unit is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Confidence {
    /// The file's format says so.
    Stated,
    /// The file's format does not say so, but those who use it do.
    Customary,
    /// By size only.
    Guessed,
}

/// A model's unit as far as it can be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Scale {
    /// The likeliest unit.
    pub unit: Unit,
    /// How sure that is.
    pub confidence: Confidence,
    /// What it may be instead, likelier ones first.
    pub alternatives: &'static [Unit],
}

impl Scale {
    /// The unit of a format that has one. Programs that know no units write scans in millimetres as metres, so there are others it may be.
    pub fn stated(unit: Unit) -> Self {
        Self {
            unit,
            confidence: Confidence::Stated,
            alternatives: match unit {
                Unit::Metres => &[Unit::Millimetres, Unit::Centimetres, Unit::Micrometres],
                _ => &[],
            },
        }
    }

    /// The unit that files of a format have by custom.
    pub fn customary(unit: Unit) -> Self {
        Self {
            unit,
            confidence: Confidence::Customary,
            alternatives: &[Unit::Nanometres],
        }
    }

    /// Guesses by the longest side of the box; None where that is zero or not finite.
    pub fn guessed(longest: f64) -> Option<Self> {
        use Unit::{Centimetres, Metres, Micrometres, Millimetres, Nanometres};
        let (unit, alternatives): (Unit, &[Unit]) = match longest {
            side if !(side > 0.0 && side.is_finite()) => return None,
            side if side < 20.0 => (Metres, &[Centimetres, Millimetres]),
            side if side < 2e3 => (Millimetres, &[Centimetres, Metres]),
            side if side < 5e4 => (Micrometres, &[Millimetres]),
            _ => (Nanometres, &[Micrometres]),
        };
        Some(Self {
            unit,
            confidence: Confidence::Guessed,
            alternatives,
        })
    }
}

/// A length in metres in the unit that a person would say it in.
pub fn told(metres: f64) -> String {
    let units = [
        Unit::Metres,
        Unit::Centimetres,
        Unit::Millimetres,
        Unit::Micrometres,
    ];
    let unit = units
        .into_iter()
        .find(|unit| metres >= unit.metres() * 0.995)
        .unwrap_or(Unit::Nanometres);
    let number = metres / unit.metres();
    let digits = if number < 9.95 { 1 } else { 0 };
    format!("{number:.digits$} {}", unit.symbol())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn sizes_are_taken_for_what_they_are_most_likely_in() {
        let table = [
            (0.0, None),
            (-1.0, None),
            (f64::NAN, None),
            (f64::INFINITY, None),
            (1e-300, Some(Unit::Metres)),
            (0.3, Some(Unit::Metres)),
            (19.9, Some(Unit::Metres)),
            (20.0, Some(Unit::Millimetres)),
            (350.0, Some(Unit::Millimetres)),
            (2e3, Some(Unit::Micrometres)),
            (5e4, Some(Unit::Nanometres)),
            (1e300, Some(Unit::Nanometres)),
        ];
        for (longest, expected) in table {
            let found = Scale::guessed(longest);
            assert_eq!(found.map(|scale| scale.unit), expected, "{longest}");
            assert!(found.is_none_or(|scale| !scale.alternatives.contains(&scale.unit)));
            assert!(found.is_none_or(|scale| scale.confidence == Confidence::Guessed));
        }
    }

    #[test]
    fn lengths_are_told_in_their_own_unit() {
        let table = [
            (12.4, "12 m"),
            (1.0, "1.0 m"),
            (0.35, "35 cm"),
            (0.0049, "4.9 mm"),
            (0.000_02, "20 µm"),
            (3e-9, "3.0 nm"),
            (0.0, "0.0 nm"),
        ];
        for (metres, expected) in table {
            assert_eq!(told(metres), expected);
        }
    }
}
