//! Leaves of coarser levels of detail: simpler, then fewer and larger, so that a crown stays as dense as it was.
//!
//! Of leaves that lean on their crown ([`Surface::rounded`]) alone; what a grammar places one by one (flowers, leaves of its own) stays. A leaf of length s
//! becomes two triangles where the level may be off by more than s/12 (a sparse one later), and of all leaves s/4w parts stay where it may be off by w beyond s/4, each as much
//! larger as keeps their area (Cook, Halstead, Planck and Ryu 2007, "Stochastic simplification of aggregate detail").

use glam::Vec3;

use super::super::organs::{Organs, Placed, Surface};

/// A leaf longer than so many bounds keeps its shape.
const SHAPED: f32 = 12.0;
/// Leaves longer than so many bounds all stay.
const ALL: f32 = 4.0;
/// No fewer than one leaf in so many, which is then five times as long.
const FEWEST: f32 = 25.0;

/// Thins the leaves of a level that may be off by `within`, metres.
pub(crate) fn thin(organs: &mut Organs, within: f32) {
    if within.is_nan() || within <= 0.0 {
        return;
    }
    let coarse: Vec<Option<(u16, f32)>> = (0..organs.surfaces.len())
        .map(|at| {
            let surface = organs.surfaces.get(at).filter(|one| one.rounded > 0.0)?;
            let number = u16::try_from(organs.surfaces.len()).ok()?;
            let (kite, part) = two_triangles(surface);
            organs.surfaces.push(kite);
            Some((number, part))
        })
        .collect();
    // By surface: how much of a leaf is owed.
    let mut owed = vec![0.0_f32; coarse.len()];
    organs.placed.retain_mut(|leaf| {
        let at = usize::from(leaf.surface);
        let Some((coarse, part)) = coarse.get(at).copied().flatten() else {
            return true;
        };
        let share = share(leaf, within);
        if let Some(owed) = owed.get_mut(at) {
            *owed += share;
            if *owed < 1.0 {
                return false;
            }
            *owed -= 1.0;
        }
        if leaf.scale.abs() < SHAPED * part * within {
            leaf.surface = coarse;
        }
        leaf.scale *= share.sqrt().recip();
        true
    });
}

/// Of how many leaves like this one stays, 1/[`FEWEST`] to 1.
fn share(leaf: &Placed, within: f32) -> f32 {
    (leaf.scale.abs() / (ALL * within)).clamp(1.0 / FEWEST, 1.0)
}

/// A leaf as a kite (foot, widest place, tip) of the leaf's own area, and what part of the kite around the leaf that is, [`SPARSE`] to 1: a spray of needles
/// fills little of its outline, so it must look smaller than a leaf before a kite may stand for it.
pub(crate) fn two_triangles(surface: &Surface) -> (Surface, f32) {
    let tip = surface
        .positions
        .iter()
        .fold(Vec3::ZERO, |tip, p| if p.y > tip.y { *p } else { tip });
    let mut widest =
        surface.positions.iter().fold(
            Vec3::ZERO,
            |widest, p| if p.x > widest.x { *p } else { widest },
        );
    let around = widest.x * tip.y;
    let part = area(surface) / around;
    let part = if part.is_finite() {
        part.clamp(SPARSE, 1.0)
    } else {
        1.0
    };
    // As much folded as it was.
    (widest.x, widest.z) = (widest.x * part, widest.z * part);
    let other = Vec3::new(-widest.x, widest.y, widest.z);
    let mut kite = Surface {
        positions: vec![Vec3::ZERO, widest, tip, other],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..surface.clone()
    };
    kite.normals.clear();
    kite.tone.clear();
    kite.smooth();
    (kite, part)
}

/// The least part of its outline that a leaf is taken to fill.
const SPARSE: f32 = 0.2;

/// The area of a surface of scale 1.
fn area(surface: &Surface) -> f32 {
    let at = |corner: &u32| surface.positions.get(*corner as usize).copied();
    let triangles = surface.indices.as_chunks::<3>().0.iter();
    triangles
        .filter_map(|[a, b, c]| {
            let (a, b, c) = (at(a)?, at(b)?, at(c)?);
            Some((b - a).cross(c - a).length() / 2.0)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use glam::Quat;

    use super::super::super::organs::Paint;
    use super::*;

    fn crown(scale: f32) -> Organs {
        let leaf = |at: u16| Placed {
            surface: at % 2,
            paint: Paint::default(),
            position: Vec3::X * f32::from(at),
            orientation: Quat::IDENTITY,
            scale,
            birth: 0,
            node: 0,
            light: 1.0,
        };
        let surfaces = ["oak", "flower"].map(|name| Surface::built_in(name).unwrap());
        Organs {
            surfaces: surfaces.to_vec(),
            placed: (0..2000).map(leaf).collect(),
            ..Organs::default()
        }
    }

    /// Number and area (length squared) of leaves and of flowers.
    fn told(organs: &Organs) -> [(usize, f32); 2] {
        [false, true].map(|flowers| {
            let of = organs
                .placed
                .iter()
                .filter(|one| (one.surface == 1) == flowers);
            of.fold((0, 0.0), |(count, area), one| {
                (count + 1, area + one.scale * one.scale)
            })
        })
    }

    #[test]
    fn crowns_stay_as_dense_with_fewer_and_simpler_leaves() {
        for (within, expected, simple) in [
            (0.001, 1000, false),
            (0.01, 1000, false),
            (0.02, 1000, true),
            (0.1, 500, true),
            (9.0, 40, true),
        ] {
            let mut organs = crown(0.2);
            let before = told(&organs);
            thin(&mut organs, within);
            let after = told(&organs);
            assert_eq!(after[1], before[1], "flowers stay");
            assert!(
                after[0].0.abs_diff(expected) <= 1,
                "{within}: {} leaves",
                after[0].0
            );
            assert!(
                (after[0].1 / before[0].1 - 1.0).abs() < 0.03,
                "{within}: {after:?}"
            );
            let first = organs.placed.iter().find(|one| one.surface != 1).unwrap();
            let triangles = organs.surfaces[usize::from(first.surface)].indices.len() / 3;
            assert_eq!(triangles == 2, simple, "{within}: {triangles}");
        }
        let mut organs = crown(0.2);
        thin(&mut organs, 0.0);
        assert_eq!(organs, crown(0.2));
    }
}
