//! Knots: stubs of branches that died and broke off, on old wood.
//!
//! No tree keeps what it has lost, so where knots are is drawn by chance from the place itself: a tree that grows on, or is drawn again, has them where it had
//! them. A knot is a swelling of the tube and a stub in it that leans towards the tip, as branches do, blunt and a little thicker at its foot (Shigo,
//! *Tree Anatomy*, 1994). The stub is a branch like any other: closed, and gone in coarser levels of detail.

use glam::{Quat, Vec3};

/// The wood round a knot is so many times as thick.
pub(super) const SWELLS: f32 = 1.1;
/// The swelling dies away over so many radii of the stub.
pub(super) const SWELLING: f32 = 2.2;
/// A stub's radius in parts of its wood's: least, and how much more at most.
const THICK: [f32; 2] = [0.2, 0.14];
/// How far a stub stands out of the bark, in its radii: least, and how much more at most.
const LONG: [f32; 2] = [0.5, 1.1];
/// By what angle a stub leans from the wood, radians: least, and how much more at most.
const LEAN: [f32; 2] = [0.8, 0.5];
/// Segments shorter than so many of their radii have no knot.
const SHORTEST: f32 = 1.6;
/// And no more than this part of the others.
const MOST: f32 = 0.6;
/// A stub: how far from the bark in its radii, as far as the second says of its length, and how thick in its radii. Its tube narrows behind the last but one.
const PROFILE: [[f32; 3]; 4] = [
    [-0.15, 0.0, 1.5],
    [0.35, 0.0, 1.12],
    [0.35, 1.0, 1.0],
    [1.0, 1.0, 1.0],
];

/// A knot on a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    /// Where on the segment, 0 to 1.
    pub(super) at: f32,
    /// Unit vector along the stub.
    direction: Vec3,
    /// Of the stub, in parts of the wood's radius.
    thick: f32,
    /// How far it stands out, in its radii.
    long: f32,
}

/// Numbers by chance, 0 to 1, from a place: the same for the same bits.
struct Chance(u32);

impl Chance {
    fn of(place: Vec3) -> Self {
        let mix = |bits: u32, part: f32| (bits ^ part.to_bits()).wrapping_mul(0x9E37_79B9);
        Self(place.to_array().into_iter().fold(0x85EB_CA6B, mix))
    }

    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9);
        let mut bits = self.0;
        for factor in [0x7FEB_352D_u32, 0x846C_A68B] {
            bits = (bits ^ (bits >> 16)).wrapping_mul(factor);
        }
        #[allow(clippy::cast_precision_loss, reason = "24 bits fit f32 exactly")]
        let part = (bits >> 8) as f32 / 16_777_216.0;
        part
    }

    fn within(&mut self, [least, more]: [f32; 2]) -> f32 {
        least + more * self.next()
    }
}

impl Knot {
    /// The knot of a segment, if chance gives it one: `often` in ten radii of its length. `shown` is how far it has come out, 0 to 1.
    pub(super) fn of([from, to]: [Vec3; 2], radius: f32, often: f32, shown: f32) -> Option<Self> {
        let length = from.distance(to);
        let along = (to - from).try_normalize()?;
        let is_long = shown > 0.0 && radius > 0.0 && length > SHORTEST * radius;
        let mut chance = Chance::of(to);
        let share = (often * length / (10.0 * radius)).min(MOST);
        if !is_long || chance.next() >= share {
            return None;
        }
        let at = chance.within([0.35, 0.3]);
        let round = Quat::from_axis_angle(along, std::f32::consts::TAU * chance.next());
        let lean = chance.within(LEAN);
        let aside = round * along.any_orthonormal_vector();
        Some(Self {
            at,
            direction: along * lean.cos() + aside * lean.sin(),
            thick: shown * chance.within(THICK),
            long: chance.within(LONG),
        })
    }

    /// Where the swelling begins and ends, in metres from the knot.
    pub(super) fn swelling(&self, radius: f32) -> f32 {
        SWELLING * self.thick * radius
    }

    /// The stub's nodes behind the one on its wood's middle line: place and radius, for wood of a radius there.
    pub(super) fn stub(&self, middle: Vec3, along: Vec3, radius: f32) -> [(Vec3, f32); 4] {
        let own = self.thick * radius;
        // As far as the bark along the way out.
        let aside = self.direction.reject_from(along).length().max(0.1);
        let skin = radius / aside;
        PROFILE.map(|[away, part, thick]| {
            let out = skin + own * (away + part * self.long);
            (middle + self.direction * out, own * thick)
        })
    }
}

/// A stub has so many nodes.
pub(super) const NODES: u64 = PROFILE.len() as u64;

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;

    #[test]
    fn knots_come_as_often_as_said_and_stay_where_they_are() {
        let segments = (0..4000_u16).map(|k| {
            let from = Vec3::new(f32::from(k), 0.5 * f32::from(k % 7), 0.0);
            [from, from + Vec3::new(0.0, 0.5, 0.1)]
        });
        let segments: Vec<_> = segments.collect();
        let of = |often: f32| -> Vec<Option<Knot>> {
            let knot = |segment: &[Vec3; 2]| Knot::of(*segment, 0.1, often, 1.0);
            segments.iter().map(knot).collect()
        };
        for (often, expected) in [(0.0, 0.0), (0.4, 0.204), (1.0, 0.51), (9.0, 0.6)] {
            let found = of(often).into_iter().flatten().count() as f32 / 4000.0;
            assert!((found - expected).abs() < 0.03, "{often}: {found}");
        }
        assert_eq!(of(0.7), of(0.7));
        // Where there are some, there are when more come.
        let both = of(0.4).into_iter().zip(of(1.0));
        assert!(
            both.into_iter()
                .all(|(few, more)| few.is_none() || few == more)
        );
    }

    #[test]
    fn a_stub_stands_out_of_the_bark_and_leans_to_the_tip() {
        let mut found = 0;
        for k in 0..500_u16 {
            let from = Vec3::new(f32::from(k), 1.0, 2.0);
            let Some(knot) = Knot::of([from, from + Vec3::Y], 0.2, 2.0, 1.0) else {
                continue;
            };
            found += 1;
            assert!((knot.direction.length() - 1.0).abs() < 1e-5);
            assert!((0.2..0.75).contains(&knot.direction.y), "{knot:?}");
            let stub = knot.stub(from, Vec3::Y, 0.2);
            let aside = stub.map(|(place, _)| {
                place
                    .reject_from(Vec3::Y)
                    .distance(from.reject_from(Vec3::Y))
            });
            assert!(
                aside[0] < 0.2 && aside[1] > 0.2 && aside[3] < 0.5,
                "{aside:?}"
            );
            assert!(aside.windows(2).all(|pair| pair[0] < pair[1]));
            assert!(stub.iter().all(|(_, radius)| (0.0..0.11).contains(radius)));
        }
        assert!(found > 200, "{found}");
    }

    #[test]
    fn short_thin_and_broken_segments_have_none() {
        let none = |to: Vec3, radius: f32, shown: f32| {
            (0..64_u8).all(|k| {
                let from = Vec3::splat(f32::from(k));
                Knot::of([from, from + to], radius, 9.0, shown).is_none()
            })
        };
        assert!(none(Vec3::ZERO, 0.1, 1.0) && none(Vec3::Y * 0.1, 0.1, 1.0));
        assert!(none(Vec3::Y, 0.0, 1.0) && none(Vec3::Y, 0.1, 0.0));
        assert!(none(Vec3::NAN, 0.1, 1.0) && none(Vec3::Y, f32::NAN, 1.0));
        assert!(!none(Vec3::Y, 0.1, 1.0));
    }
}
