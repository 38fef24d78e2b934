//! Growth curves: how far a module has come at an age between its step's beginning and end.
//!
//! Each maps 0…1 to 0…1, 0 to 0 and 1 to 1, so that a picture at a whole step is that of the derivation.

use std::collections::BTreeMap;

use super::error::GrammarError;
use super::expression::signed;
use super::source::Cursor;

/// Steepest logistic: beyond it the curve is a step to the eye, and its tails leave f64.
const STEEPEST: f64 = 100.0;

/// A growth curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum Curve {
    /// As much as the age.
    #[default]
    Linear,
    /// The logistic function of this steepness round the middle of the step, stretched to begin at 0 and end at 1.
    Logistic(f64),
    /// Straight between these points.
    Table(Vec<[f64; 2]>),
    /// All of it at once, as soon as the step begins.
    Once,
}

impl Curve {
    /// The value at an age of 0 to 1.
    pub(crate) fn at(&self, age: f64) -> f64 {
        if age >= 1.0 {
            return 1.0;
        }
        let age = age.max(0.0);
        match self {
            Self::Once if age > 0.0 => 1.0,
            Self::Once => 0.0,
            Self::Linear => age,
            Self::Logistic(steepness) => {
                let logistic = |x: f64| 1.0 / (1.0 + (-steepness * (x - 0.5)).exp());
                let (low, high) = (logistic(0.0), logistic(1.0));
                ((logistic(age) - low) / (high - low)).clamp(0.0, 1.0)
            }
            Self::Table(points) => {
                let after = points.partition_point(|[x, _]| *x <= age);
                let point = |at: Option<usize>| at.and_then(|at| points.get(at));
                match (point(after.checked_sub(1)), point(Some(after))) {
                    (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * (age - x0) / (x1 - x0),
                    _ => age,
                }
            }
        }
    }
}

/// The curves of a grammar.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Curves {
    /// Of modules by their names.
    pub(crate) of: BTreeMap<String, Curve>,
    /// Of all others.
    pub(crate) default: Option<Curve>,
}

impl Curves {
    /// The values of all curves at an age, by symbol.
    pub(crate) fn at(&self, age: f64, names: impl Iterator<Item = impl AsRef<str>>) -> Vec<f64> {
        let default = self.default.as_ref().map_or(age, |curve| curve.at(age));
        let value = |name: &str| self.of.get(name).map_or(default, |curve| curve.at(age));
        names.map(|name| value(name.as_ref())).collect()
    }
}

/// Reads `linear`, `logistic K`, `table (x y) …` or `once`.
pub(crate) fn curve(cursor: &mut Cursor<'_>) -> Result<Curve, GrammarError> {
    cursor.skip_blank();
    let at = cursor.pos();
    match cursor.identifier() {
        Some("linear") => Ok(Curve::Linear),
        Some("once") => Ok(Curve::Once),
        Some("logistic") => {
            cursor.skip_blank();
            let at = cursor.pos();
            let steepness = signed(cursor)?;
            if steepness > 0.0 && steepness <= STEEPEST {
                Ok(Curve::Logistic(steepness))
            } else {
                let message = format!(
                    "found a steepness of {steepness}; expected a number above 0, at most {STEEPEST}"
                );
                Err(cursor.error_at(at, message))
            }
        }
        Some("table") => table(cursor),
        _ => {
            let message = "expected a growth curve: `linear`, `logistic 6`, `table (0 0) (0.5 0.8) (1 1)` or `once`";
            Err(cursor.error_at(at, message.into()))
        }
    }
}

fn table(cursor: &mut Cursor<'_>) -> Result<Curve, GrammarError> {
    cursor.skip_blank();
    let start = cursor.pos();
    let mut points: Vec<[f64; 2]> = Vec::new();
    while cursor.take("(") {
        cursor.skip_blank();
        let at = cursor.pos();
        let x = signed(cursor)?;
        cursor.take(",");
        let y = signed(cursor)?;
        cursor.expect(")")?;
        cursor.take(",");
        let refuse = |message: &str| Err(cursor.error_at(at, message.into()));
        if !(0.0..=1.0).contains(&x) || !(0.0..=1.0).contains(&y) {
            return refuse("a point of a growth curve lies outside 0 to 1");
        }
        if points.last().is_some_and(|[before, _]| *before >= x) {
            return refuse(
                "the points of a growth curve go from left to right, each at an age of its own",
            );
        }
        points.push([x, y]);
    }
    match (points.first(), points.last()) {
        (Some([0.0, 0.0]), Some([1.0, 1.0])) => Ok(Curve::Table(points)),
        _ => {
            let message = "a growth curve begins at (0 0) and ends at (1 1)".into();
            Err(cursor.error_at(start, message))
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn curves_by_hand() {
        let table = Curve::Table(vec![[0.0, 0.0], [0.5, 0.8], [0.75, 0.8], [1.0, 1.0]]);
        let e = std::f64::consts::E;
        // 1/(1+e^-x) at -1, 0, 1 for a steepness of 4 at the ages 0.25, 0.5 and 0.75.
        let s = |x: f64| 1.0 / (1.0 + e.powf(-x));
        let stretched = |x: f64| (s(x) - s(-2.0)) / (s(2.0) - s(-2.0));
        for (curve, age, value) in [
            (Curve::Linear, 0.0, 0.0),
            (Curve::Linear, 0.3, 0.3),
            (Curve::Linear, 1.0, 1.0),
            (Curve::Once, 0.0, 0.0),
            (Curve::Once, 1e-9, 1.0),
            (table.clone(), 0.0, 0.0),
            (table.clone(), 0.25, 0.4),
            (table.clone(), 0.5, 0.8),
            (table.clone(), 0.6, 0.8),
            (table.clone(), 0.875, 0.9),
            (table, 1.0, 1.0),
            (Curve::Logistic(4.0), 0.0, 0.0),
            (Curve::Logistic(4.0), 0.25, stretched(-1.0)),
            (Curve::Logistic(4.0), 0.5, 0.5),
            (Curve::Logistic(4.0), 0.75, stretched(1.0)),
            (Curve::Logistic(100.0), 0.5, 0.5),
            (Curve::Logistic(4.0), 1.0, 1.0),
        ] {
            let found = curve.at(age);
            assert!(
                (found - value).abs() < 1e-12,
                "{curve:?} at {age}: {found} not {value}"
            );
        }
        assert_eq!(Curve::Logistic(4.0).at(1.0), 1.0, "exactly");
    }
}
