//! Where the trees of a grove stand: side by side, so that no crown reaches into another.
//!
//! Each tree takes the first free place along a spiral of the golden angle, which seeds turn (Vogel 1979, "A better way to construct the sunflower head"): a grove is
//! about round and has no rows. A place is free where the crown's circle meets none that stands already. What is passed over stays empty, and who finds nothing
//! goes outwards in ever wider steps, so that the time grows no faster than the trees times their number, however unlike they are.

use glam::{DVec2, Vec3};

use crate::tree::Drawing;
use crate::tree::draws::Draws;

/// The golden angle, radians.
const GOLDEN: f64 = 2.399_963_229_728_653;
/// Between two crowns, in parts of their reach.
const GAP: f64 = 1.06;
/// Places on the spiral, in parts of the middle crown's reach.
const STEP: f64 = 0.4;
/// Places that are tried one by one before steps become wider, and again before they become wider still.
const TRIES: u32 = 64;
/// How much wider, in parts of the number of the place on the spiral, which is as the ground within.
const WIDER: f64 = 1.0 / 64.0;
/// What a crown reaches at most, metres.
const FARTHEST: f32 = 1e30;

/// Where a tree's foot is, and how far its crown reaches from there, level, metres.
#[must_use]
pub fn crown(drawing: &Drawing) -> (Vec3, f32) {
    let Drawing { tree, organs } = drawing;
    let foot = tree.position.first().copied().unwrap_or_default();
    let mut reach = 0.0_f32;
    let mut add = |place: Vec3, radius: f32| {
        let way = (place - foot) * Vec3::new(1.0, 0.0, 1.0);
        reach = reach.max(way.length() + radius);
    };
    for (place, radius) in tree.position.iter().zip(&tree.radius) {
        add(*place, *radius);
    }
    for corner in &organs.corners {
        add(*corner, 0.0);
    }
    for sphere in &organs.spheres {
        add(sphere.center, sphere.radius);
    }
    let lengths: Vec<f32> = organs
        .surfaces
        .iter()
        .map(|surface| {
            surface
                .positions
                .iter()
                .map(|p| p.length())
                .fold(0.0, f32::max)
        })
        .collect();
    for placed in &organs.placed {
        let length = lengths.get(usize::from(placed.surface)).copied();
        add(placed.position, length.unwrap_or(0.0) * placed.scale.abs());
    }
    (foot, reach.clamp(0.0, FARTHEST))
}

/// Places on the ground (y is 0) for crowns that reach so far, in their order.
#[must_use]
pub fn places(reaches: &[f32], seed: u64) -> Vec<Vec3> {
    // `max` passes over what is no number.
    let reach = |reach: &f32| f64::from(reach.max(0.0)).min(FARTHEST.into());
    let mut sorted: Vec<f64> = reaches.iter().map(reach).collect();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
    let step = STEP * middle.max(1e-3);
    let turned = Draws::new(seed, 0).uniform(0.0, std::f64::consts::TAU);
    let mut taken: Vec<(DVec2, f64)> = Vec::with_capacity(reaches.len());
    // The place on the spiral, and how often it turned: each try looks another way, even where one more place makes no difference to the number.
    let (mut number, mut turns) = (0.0_f64, 0.0_f64);
    for reach in reaches.iter().map(reach) {
        let mut tries = 0_u32;
        let place = loop {
            let (sin, cos) = (turned + GOLDEN * turns).sin_cos();
            let place = step * number.sqrt() * DVec2::new(cos, sin);
            // As the file has it.
            let place = place.as_vec2().as_dvec2();
            let is_free = taken
                .iter()
                .all(|(other, far)| place.distance(*other) >= GAP * (far + reach));
            number += 1.0 + number * WIDER * f64::from(tries / TRIES);
            turns += 1.0;
            tries += 1;
            if is_free {
                break place;
            }
        };
        taken.push((place, reach));
    }
    let on_ground = |(place, _): &(DVec2, f64)| {
        let place = place.as_vec2();
        Vec3::new(place.x, 0.0, place.y)
    };
    taken.iter().map(on_ground).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn crowns_do_not_stand_in_each_other_and_a_seed_is_a_grove() {
        let even = vec![2.0; 200];
        let mixed: Vec<f32> = (0..300_u16)
            .map(|n| {
                if n % 50 == 7 {
                    900.0
                } else {
                    0.3 + f32::from(n % 11)
                }
            })
            .collect();
        let mut unlike = vec![0.01; 200];
        unlike[100] = 1e6;
        let mut half = vec![1e-6; 401];
        half[1..].iter_mut().step_by(2).for_each(|one| *one = 1e30);
        for reaches in [
            &even,
            &mixed,
            &unlike,
            &half,
            &vec![0.0; 20],
            &vec![1e30, 1e-6, 1e30],
            &vec![1e-6, 1e-6, 1e30],
        ] {
            let stand = places(reaches, 5);
            assert_eq!(stand, places(reaches, 5));
            assert_ne!(stand[1..], places(reaches, 6)[1..]);
            for (at, place) in stand.iter().enumerate() {
                assert!(place.is_finite() && place.y == 0.0);
                for other in 0..at {
                    let apart = place.distance(stand[other]);
                    assert!(apart >= reaches[at] + reaches[other], "{at} {other}");
                }
            }
        }
        // No more ground than a few times what the crowns cover.
        let far = places(&even, 1)
            .iter()
            .map(|p| p.length())
            .fold(0.0, f32::max);
        assert!(far * far < 3.0 * 200.0 * 4.0, "{far}");
        assert!(places(&[], 0).is_empty());
    }
}
