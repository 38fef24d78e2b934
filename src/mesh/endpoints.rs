//! Where a branching model begins and ends: the source that paths start from, and their targets.
//!
//! Endpoints are set by hand, [read](from_csv) from CSV or JSON, or [proposed](propose()), in the model's own coordinates and unit.

mod arms;
mod error;
mod open;
mod propose;
mod table;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use self::error::EndpointError;
pub use self::propose::{Proposal, Reason, propose};
use self::table::Entry;
pub use self::table::{from_csv, from_json, to_csv, to_json};

/// Most endpoints of a list that is read.
pub const ENDPOINTS_MOST: usize = 100_000;
/// Longest name that is read, in bytes.
pub const NAME_MOST: usize = 200;
/// Longest file that is read.
pub const BYTES_MOST: usize = 64 << 20;
/// Largest coordinate that is read, either way; as of models.
const COORDINATE_MOST: f64 = 1e15;

/// What paths do at an endpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// They start.
    Source,
    /// They end.
    #[default]
    Target,
}

impl Kind {
    /// What it is not.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Source => Self::Target,
            Self::Target => Self::Source,
        }
    }

    /// Its name in files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Source => "source",
            Self::Target => "target",
        }
    }
}

/// The middle of the tube at an endpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snapped {
    /// Where it is, in the model's coordinates.
    pub centre: DVec3,
    /// How thick the tube is.
    pub radius: f64,
}

/// A place where a model begins or ends; written as in JSON files of endpoints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Entry", into = "Entry")]
pub struct Endpoint {
    /// Where it was set, in the model's coordinates.
    pub point: DVec3,
    /// What people call it.
    pub name: String,
    /// Source or target.
    pub kind: Kind,
    /// The middle of the tube there, where it was snapped.
    pub snapped: Option<Snapped>,
}

impl Endpoint {
    /// Whether a file can hold it: its name is short and in one line, its numbers are within bounds.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        Self::try_from(Entry::from(self.clone())).is_ok()
    }
}

/// How many there are of a kind.
#[must_use]
pub fn count(endpoints: &[Endpoint], kind: Kind) -> usize {
    let of_kind = endpoints.iter().filter(|one| one.kind == kind);
    of_kind.count()
}

/// What the next one of a kind is called: `source`, `source 2`, `target 1`, `target 2`, the first that no other has.
#[must_use]
pub fn next_name(endpoints: &[Endpoint], kind: Kind) -> String {
    let free = |name: &String| !endpoints.iter().any(|other| other.name == *name);
    let name = |number: usize| match (kind, number) {
        (Kind::Source, 1) => kind.as_str().to_owned(),
        _ => format!("{} {number}", kind.as_str()),
    };
    // Among so many names one is free.
    let mut names = (1..=endpoints.len() + 1).map(name);
    names.find(free).unwrap_or_default()
}

#[cfg(test)]
mod tests;
