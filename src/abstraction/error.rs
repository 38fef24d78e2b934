//! What keeps a model from being abstracted.

use thiserror::Error;

use crate::lsystem::{DeriveError, GrammarErrors};

/// Why there is no abstraction.
#[derive(Debug, Error)]
pub enum AbstractionError {
    /// A parameter is beyond its limits.
    #[error("{name} is {value}: it must be from {} to {}", limits[0], limits[1])]
    Parameter {
        /// Its name.
        name: &'static str,
        /// What it is.
        value: f64,
        /// The least and the most that it may be.
        limits: [f64; 2],
    },
    /// A table says nothing that a tree could be made of.
    #[error("{0}")]
    Table(String),
    /// The grammar cannot be read.
    #[error(transparent)]
    Grammar(#[from] GrammarErrors),
    /// The grammar cannot be derived.
    #[error(transparent)]
    Derive(#[from] DeriveError),
    /// Somebody stopped it.
    #[error("stopped")]
    Cancelled,
}
