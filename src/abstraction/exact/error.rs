//! What keeps a tree from being written as a grammar within a tolerance.

use thiserror::Error;

use crate::lsystem::{DeriveError, GrammarErrors};
use crate::tree::TreeError;

/// Why there is no grammar.
#[derive(Debug, Error)]
pub enum ExactError {
    /// A tolerance that is no length.
    #[error("the tolerance is {0}: give a length above 0, or a part of the tree's size as 0.5%")]
    Tolerance(f64),
    /// Nothing of the tree would be left.
    #[error(
        "the tolerance of {tolerance} is no smaller than the tree, which is {size} from corner to corner: choose a smaller one"
    )]
    Coarse {
        /// As asked for.
        tolerance: f64,
        /// The diagonal of the tree's box.
        size: f64,
    },
    /// Trees hold single precision.
    #[error(
        "the tolerance of {tolerance} is finer than single precision holds so far from the root: choose {least} or more"
    )]
    Fine {
        /// As asked for.
        tolerance: f64,
        /// The least that can be kept.
        least: f64,
    },
    /// There is no segment.
    #[error("the tree has no segment, so there is nothing to write as a grammar")]
    Empty,
    /// All nodes lie at one place.
    #[error("all of the tree's nodes lie at one place, so it has no shape to write as a grammar")]
    Point,
    /// The arrays do not fit each other.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// No grammar was as near as it must be: a fault of the program.
    #[error("no grammar was found that keeps a tolerance of {0}: please report this")]
    Unmet(f64),
    /// The grammar cannot be read: a fault of the program.
    #[error(transparent)]
    Grammar(#[from] GrammarErrors),
    /// The grammar cannot be derived or drawn.
    #[error(transparent)]
    Derive(#[from] DeriveError),
    /// Somebody stopped it.
    #[error("stopped")]
    Cancelled,
}
