//! How small the grammar becomes as more error is allowed: each point is a grammar that was written, drawn and checked.

use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::{Deviation, Exact, ExactError, Size, exact, size};
use crate::tree::Tree;

/// Tolerances of a curve, parts of the tree's size.
const LADDER: [f64; 9] = [1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2];

/// A point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// As asked for, in the tree's unit.
    pub tolerance: f64,
    /// How far off the grammar's tree is.
    pub error: Deviation,
    /// How large the grammar is.
    pub size: Size,
    /// How large it would be with each of the tree's segments written out.
    pub plain: Size,
    /// Segments that it draws.
    pub segments: usize,
}

impl Point {
    /// The point of a grammar.
    pub fn of(exact: &Exact) -> Self {
        let [_, segments] = exact.segments;
        Self {
            tolerance: exact.tolerance,
            error: exact.error,
            size: exact.size,
            plain: exact.plain,
            segments,
        }
    }
}

/// The points of tolerances from 0.01 % to 5 % of the tree's size, and of `known`, by tolerance. What is too fine or too coarse for the tree is left
/// out. `progress` gets how many points are done of how many.
///
/// # Errors
/// As [`exact`].
pub fn curve(
    tree: &Tree,
    known: &Exact,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Vec<Point>, ExactError> {
    let own = Point::of(known);
    let mut points = vec![own];
    for (done, part) in LADDER.into_iter().enumerate() {
        progress(done, LADDER.len());
        let tolerance = part * size(tree);
        if (tolerance / own.tolerance - 1.0).abs() < 1e-9 {
            continue;
        }
        match exact(tree, tolerance, cancel, &|_, _| {}) {
            Ok(exact) => points.push(Point::of(&exact)),
            Err(ExactError::Fine { .. } | ExactError::Coarse { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    points.sort_by(|a, b| a.tolerance.total_cmp(&b.tolerance));
    Ok(points)
}
