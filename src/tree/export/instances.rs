//! Leaves, blossoms and all else that a tree places, as instances: a mesh for each look, and where it stands.
//!
//! A leaf is some thirty vertices, an instance of it 32 bytes: a crown takes a thirtieth of the bytes, and is written as fast as it grows. What is lost is
//! the crown in the normals ([`Surface::rounded`]): each instance has the normals of its own leaf.

use std::collections::BTreeMap;

use glam::Vec3;

use crate::tree::organs::{Colour, Organs, Paint, Surface};

/// Everything placed that looks the same.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// Index into [`Organs::surfaces`].
    pub(super) surface: u16,
    pub(super) paint: Paint,
    /// Indices into [`Organs::placed`], never empty.
    pub(super) placed: Vec<u32>,
}

impl Run {
    /// The colours of its surface's vertices, linear.
    pub(super) fn colours(&self, organs: &Organs) -> Vec<Colour> {
        let Some(surface) = organs.surfaces.get(usize::from(self.surface)) else {
            return Vec::new();
        };
        (0..surface.positions.len())
            .map(|vertex| surface.colour(vertex, &organs.palette, self.paint.colour))
            .collect()
    }
}

/// All that is placed, by material, surface and colour; `None` where something reaches beyond f32.
pub(super) fn runs(organs: &Organs) -> Option<Vec<Run>> {
    let lengths: Vec<f32> = organs.surfaces.iter().map(length).collect();
    let mut found: BTreeMap<(u16, u16, u16), Vec<u32>> = BTreeMap::new();
    for (index, placed) in (0_u32..).zip(&organs.placed) {
        let reach = lengths.get(usize::from(placed.surface))? * placed.scale.abs();
        if !(placed.position.abs() + Vec3::splat(reach)).is_finite() {
            return None;
        }
        let key = (placed.paint.material, placed.surface, placed.paint.colour);
        found.entry(key).or_default().push(index);
    }
    let run = |((material, surface, colour), placed)| Run {
        surface,
        paint: Paint { colour, material },
        placed,
    };
    // A surface without a triangle shows nothing.
    let is_shown = |run: &Run| {
        let surface = organs.surfaces.get(usize::from(run.surface));
        surface.is_some_and(|surface| !surface.indices.is_empty())
    };
    Some(found.into_iter().map(run).filter(is_shown).collect())
}

/// How far a surface reaches from its foot.
pub(super) fn length(surface: &Surface) -> f32 {
    let reach = surface.positions.iter().map(|place| place.length());
    reach.fold(0.0, f32::max)
}
