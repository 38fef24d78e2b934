//! Where a branching model begins and ends: the source that paths start from, and their targets.
//!
//! Endpoints are set by hand, [read](Endpoints::from_csv) from CSV or JSON, or [proposed](propose()), in the model's own coordinates and unit. Each
//! has a number of its own that is never given again while the list lives, so that undo, panels and other threads can name it.

mod arms;
mod error;
mod open;
mod propose;
mod table;

use glam::DVec3;

pub use self::error::EndpointError;
pub use self::propose::{Proposal, Reason, propose};

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

/// A place where a model begins or ends.
#[derive(Clone, Debug, Default, PartialEq)]
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

/// The number of an endpoint in its list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EndpointId(u32);

/// Endpoints of a model, in the order in which they were set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Endpoints {
    list: Vec<(EndpointId, Endpoint)>,
    next: u32,
}

impl Endpoints {
    /// Adds one to the end.
    pub fn add(&mut self, endpoint: Endpoint) -> EndpointId {
        let id = EndpointId(self.next);
        self.next = self.next.saturating_add(1);
        self.list.push((id, endpoint));
        id
    }

    /// Puts one back that was removed, where it was, with its number; what undo does. False, and nothing is done, where the number is in use or
    /// was never given.
    pub fn restore(&mut self, place: usize, id: EndpointId, endpoint: Endpoint) -> bool {
        let possible = id.0 < self.next && place <= self.list.len() && self.get(id).is_none();
        if possible {
            self.list.insert(place, (id, endpoint));
        }
        possible
    }

    /// Takes one away: where it was and what it was.
    pub fn remove(&mut self, id: EndpointId) -> Option<(usize, Endpoint)> {
        let place = self.list.iter().position(|(other, _)| *other == id)?;
        Some((place, self.list.remove(place).1))
    }

    /// One of them.
    pub fn get(&self, id: EndpointId) -> Option<&Endpoint> {
        let found = self.list.iter().find(|(other, _)| *other == id);
        found.map(|(_, endpoint)| endpoint)
    }

    /// One of them, to move, name or turn into the other kind.
    pub fn get_mut(&mut self, id: EndpointId) -> Option<&mut Endpoint> {
        let found = self.list.iter_mut().find(|(other, _)| *other == id);
        found.map(|(_, endpoint)| endpoint)
    }

    /// All, in their order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (EndpointId, &Endpoint)> {
        self.list.iter().map(|(id, endpoint)| (*id, endpoint))
    }

    /// How many there are of a kind.
    pub fn count(&self, kind: Kind) -> usize {
        let of_kind = self.list.iter().filter(|(_, one)| one.kind == kind);
        of_kind.count()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

impl FromIterator<Endpoint> for Endpoints {
    fn from_iter<T: IntoIterator<Item = Endpoint>>(all: T) -> Self {
        let mut list = Self::default();
        all.into_iter().for_each(|endpoint| {
            list.add(endpoint);
        });
        list
    }
}

#[cfg(test)]
mod tests;
