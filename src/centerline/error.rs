//! Why there is no centerline, in a sentence each.

use glam::DVec3;

use crate::mesh::mend::MendError;

/// Why a model has no centerline.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CenterlineError {
    /// Somebody asked to stop.
    #[error("the search for the centerline was cancelled")]
    Cancelled,
    /// More triangles than are taken.
    #[error(
        "the model has {triangles} triangles, and centerlines are found of up to {most}: decimate it first (ramus inspect --repair decimate)"
    )]
    TooLarge {
        /// Triangles of the model.
        triangles: usize,
        /// How many there may be.
        most: usize,
    },
    /// No triangle with an area.
    #[error("the model has no surface: it is empty, or all of its triangles are lines and points")]
    NoSurface,
    /// Nowhere is one side of the surface opposite the other.
    #[error(
        "the model has no inside: it is flat or too open for the largest ball within it to be found; close its holes first (ramus inspect --repair close)"
    )]
    NoInside,
    /// Nothing to begin at.
    #[error("there is no source: give one, or let the endpoints be found")]
    NoSource,
    /// Nothing to end at.
    #[error("there is no target: give some, or let the endpoints be found")]
    NoTarget,
    /// More than one source.
    #[error("there are {0} sources, and a tree begins at one: make the others targets")]
    ManySources(usize),
    /// An endpoint that is no place.
    #[error("{0} is not at a finite place: its coordinates must be numbers")]
    NotFinite(String),
    /// An endpoint outside, away from the surface.
    #[error(
        "{name} at ({}, {}, {}) is {distance:.3} off the surface, outside of it: set it on the surface or inside", point.x, point.y, point.z
    )]
    OffSurface {
        /// Which.
        name: String,
        /// Where, in the model's coordinates.
        point: DVec3,
        /// How far, in the model's unit.
        distance: f64,
    },
    /// A target where the source is.
    #[error("{0} is where the source is: set it elsewhere, or leave it out")]
    SourceIsTarget(String),
    /// No target can be reached.
    #[error("no target can be reached from the source: {0}")]
    NothingReached(String),
    /// The model could not be prepared.
    #[error("the model cannot be prepared: {0}")]
    Mend(#[from] MendError),
}
