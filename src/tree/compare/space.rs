//! Two trees laid over each other: how far points of one's axis are from the other's, to both sides.
//!
//! As they are in their files; moved so that their roots are at one place; and fitted: moved, made of one size and turned about the root so that they lie
//! upon each other as well as can be found (main directions, sixteen turns tried, the best three improved by iterated closest points; Besl and McKay
//! 1992), once as a body can be turned and once mirrored. The fit is the best that was found, not the best there is.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::near::Nearest;
use super::turn::{frame, turn};
use crate::tree::{NO_PARENT, Tree};

/// Points of an axis that are looked at, equally far from each other, besides its tips.
const POINTS: u16 = 10_000;
/// Tips that are looked at, of the first that there are.
const TIPS: usize = 10_000;
/// Points that a fit looks at.
const FEW: usize = 300;
/// Turns about the main direction that are tried, to either end of it.
const TURNS: u8 = 8;
/// How many of them are improved, and in how many steps at most.
const IMPROVED: usize = 3;
const STEPS: u8 = 40;

/// A tree's axis, ready to be laid over others. Its root is that of its first node.
pub struct Axis {
    nearest: Nearest,
    /// In the tree's own frame.
    root: DVec3,
    /// Where the tree's frame begins.
    origin: DVec3,
    /// Equally spaced, from the root.
    points: Vec<DVec3>,
    tips: Vec<DVec3>,
    /// The farthest point from the root, in a straight line.
    pub reach: f64,
    /// The root of the mean square of distances from the root.
    size: f64,
}

/// How far two axes are apart, in the first one's unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Apart {
    /// The mean distance of a point of one to the other, of both ways the mean.
    pub mean: f64,
    /// The largest, of both ways (Hausdorff's distance), of the points and tips that are looked at.
    pub max: f64,
}

/// How a point of the second tree comes to the first, both counted from their roots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// How many times as large the second tree is made.
    pub scale: f64,
    /// How it is turned, or turned and mirrored.
    pub turn: DMat3,
    /// How far the axes are apart then.
    pub apart: Apart,
}

/// All that is told of two trees in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    /// As they are.
    pub as_is: Apart,
    /// With their roots at one place.
    pub rooted: Apart,
    /// Moved, scaled and turned.
    pub fitted: Fit,
    /// The same of the second one's mirror image.
    pub mirrored: Fit,
    /// The mean of both reaches, the second one's in the fit's scale: what distances are small or large by.
    pub reach: f64,
}

/// A point's way from one tree's frame to the other's.
struct Way {
    turn: DMat3,
    scale: f64,
    from: DVec3,
    to: DVec3,
}

impl Way {
    fn there(&self, point: DVec3) -> DVec3 {
        self.to + self.scale * (self.turn * (point - self.from))
    }

    fn back(&self, point: DVec3) -> DVec3 {
        self.from + self.turn.transpose() * (point - self.to) / self.scale
    }
}

impl Axis {
    /// Of a tree whose frame begins at a place of its file. None where it has no length.
    pub fn new(tree: &Tree, origin: DVec3) -> Option<Self> {
        let length = tree.total_length();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let root = tree.position.first()?.as_dvec3();
        let points = spaced(tree, length / f64::from(POINTS));
        let tips = tree.tips().into_iter().take(TIPS);
        let tips = tips
            .map(|tip| tree.position[tip as usize].as_dvec3())
            .collect();
        let away = tree.position.iter().map(|at| at.as_dvec3().distance(root));
        let squares: f64 = points
            .iter()
            .map(|point| point.distance_squared(root))
            .sum();
        Some(Self {
            nearest: Nearest::new(tree),
            root,
            origin,
            tips,
            reach: away.fold(0.0, f64::max),
            size: (squares / points.len().max(1) as f64).sqrt(),
            points,
        })
    }

    /// So many points at most, from the root.
    fn few(&self) -> Vec<DVec3> {
        let step = self.points.len().div_ceil(FEW).max(1);
        self.points
            .iter()
            .step_by(step)
            .map(|point| *point - self.root)
            .collect()
    }

    /// How far both are apart where the second is brought to the first.
    fn apart(&self, other: &Self, way: &Way) -> Apart {
        let here = |point: &DVec3| {
            let found = self.nearest.point(way.there(*point));
            found.map_or(0.0, |found| found.distance(way.there(*point)))
        };
        let there = |point: &DVec3| {
            let at = way.back(*point);
            let found = other.nearest.point(at);
            found.map_or(0.0, |found| found.distance(at) * way.scale)
        };
        let mean = |far: &[f64]| far.iter().sum::<f64>() / far.len().max(1) as f64;
        let far = |points: &[DVec3], how: &(dyn Fn(&DVec3) -> f64 + Sync)| -> Vec<f64> {
            points.par_iter().map(how).collect()
        };
        let (one, two) = (far(&other.points, &here), far(&self.points, &there));
        let tips = [far(&other.tips, &here), far(&self.tips, &there)].concat();
        let all = one.iter().chain(&two).chain(&tips);
        Apart {
            mean: f64::midpoint(mean(&one), mean(&two)),
            max: all.copied().fold(0.0, f64::max),
        }
    }

    fn way(&self, other: &Self, turn: DMat3, scale: f64) -> Way {
        Way {
            turn,
            scale,
            from: other.root,
            to: self.root,
        }
    }

    /// The best turn that was found for another tree, which is mirrored first or not.
    fn fitted(&self, other: &Self, mirrored: bool) -> Fit {
        let scale = if other.size > 0.0 {
            self.size / other.size
        } else {
            1.0
        };
        let mirror = match mirrored {
            true => DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
            false => DMat3::IDENTITY,
        };
        let ours = self.few();
        let theirs: Vec<DVec3> = other
            .few()
            .iter()
            .map(|point| mirror * *point * scale)
            .collect();
        let (to, from) = (frame(&ours), frame(&theirs));
        let turned = |number: u8| {
            let flip = match number < TURNS {
                true => DMat3::IDENTITY,
                false => DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0)),
            };
            let angle = TAU * f64::from(number % TURNS) / f64::from(TURNS);
            to * DMat3::from_rotation_x(angle) * flip * from.transpose()
        };
        let tries = (0..2 * TURNS).map(turned).chain([DMat3::IDENTITY]);
        let pairs = |turn: DMat3| {
            self.pairs(
                other,
                [&ours, &theirs],
                &self.way(other, turn * mirror, scale),
                turn,
            )
        };
        let cost = |pairs: &[[DVec3; 2]], turn: DMat3| -> f64 {
            pairs
                .iter()
                .map(|[from, to]| (turn * *from).distance_squared(*to))
                .sum()
        };
        let mut tries: Vec<(f64, DMat3)> =
            tries.map(|turn| (cost(&pairs(turn), turn), turn)).collect();
        tries.sort_by(|a, b| a.0.total_cmp(&b.0));
        let improved = tries
            .into_iter()
            .take(IMPROVED)
            .map(|(mut least, mut best)| {
                for _ in 0..STEPS {
                    let next = turn(&pairs(best));
                    let now = cost(&pairs(next), next);
                    let is_better = now < least * (1.0 - 1e-6);
                    if !is_better {
                        break;
                    }
                    (least, best) = (now, next);
                }
                (least, best)
            });
        let best = improved.min_by(|a, b| a.0.total_cmp(&b.0));
        let turn = best.map_or(DMat3::IDENTITY, |(_, turn)| turn) * mirror;
        Fit {
            scale,
            turn,
            apart: self.apart(other, &self.way(other, turn, scale)),
        }
    }

    /// Points of the second, mirrored and scaled, each with where it is to come to, and of the first each with the one that is to come to it.
    fn pairs(
        &self,
        other: &Self,
        [ours, theirs]: [&[DVec3]; 2],
        way: &Way,
        turn: DMat3,
    ) -> Vec<[DVec3; 2]> {
        let here = theirs.par_iter().filter_map(|point| {
            let found = self.nearest.point(self.root + turn * *point)?;
            Some([*point, found - self.root])
        });
        let there = ours.par_iter().filter_map(|point| {
            let found = other.nearest.point(way.back(self.root + *point))?;
            // Where that is before it is turned.
            Some([turn.transpose() * (way.there(found) - self.root), *point])
        });
        here.chain(there).collect()
    }

    /// Lays another tree over this one.
    pub fn with(&self, other: &Self) -> Space {
        let as_is = Way {
            turn: DMat3::IDENTITY,
            scale: 1.0,
            from: other.root,
            to: other.root + (other.origin - self.origin),
        };
        let fitted = self.fitted(other, false);
        Space {
            as_is: self.apart(other, &as_is),
            rooted: self.apart(other, &self.way(other, DMat3::IDENTITY, 1.0)),
            mirrored: self.fitted(other, true),
            reach: f64::midpoint(self.reach, other.reach * fitted.scale),
            fitted,
        }
    }
}

/// Points of a tree's segments, so far from each other, half of that from the beginning.
fn spaced(tree: &Tree, step: f64) -> Vec<DVec3> {
    let mut points = Vec::new();
    let mut left = step / 2.0;
    for (parent, to) in tree.parent.iter().zip(tree.position.iter()) {
        if *parent == NO_PARENT {
            continue;
        }
        let [from, to] = [tree.position[*parent as usize], *to].map(|end| end.as_dvec3());
        let length = from.distance(to);
        while left < length {
            points.push(from.lerp(to, left / length));
            left += step;
        }
        left -= length;
    }
    points
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::super::tests::{grown, moved, spec};
    use super::*;
    use glam::{Quat, Vec3};
    use proptest::prelude::*;

    /// A crooked tree that no mirror and no turn brings onto itself.
    fn crooked() -> Tree {
        grown(&[
            (0, [0.0, 10.0, 0.0]),
            (1, [6.0, 5.0, 0.0]),
            (1, [-2.0, 4.0, 3.0]),
            (2, [3.0, 0.0, 5.0]),
            (2, [1.0, 6.0, -1.0]),
        ])
    }

    fn space(a: &Tree, b: &Tree) -> Space {
        let axis = |tree| Axis::new(tree, DVec3::ZERO).unwrap();
        axis(a).with(&axis(b))
    }

    #[test]
    fn moved_turned_scaled_and_mirrored_trees_are_found_again() {
        let tree = crooked();
        let quat = Quat::from_euler(glam::EulerRot::XYZ, 2.0, -1.0, 0.7);
        let none = Quat::IDENTITY;
        for (turn, scale, shift, as_is, rooted) in [
            (none, 1.0, Vec3::ZERO, true, true),
            (none, 1.0, Vec3::new(50.0, 2.0, -3.0), false, true),
            (quat, 1.0, Vec3::ZERO, false, false),
            (quat, 2.5, Vec3::new(9.0, 9.0, 9.0), false, false),
        ] {
            let other = moved(&tree, |at| shift + scale * (turn * at));
            let found = space(&tree, &other);
            let small = 1e-4 * found.reach;
            assert_eq!(found.as_is.max < small, as_is, "{found:?}");
            assert_eq!(found.rooted.max < small, rooted, "{found:?}");
            assert!(found.fitted.apart.max < small, "{found:?}");
            assert!(
                (found.fitted.scale * f64::from(scale) - 1.0).abs() < 1e-3,
                "{found:?}"
            );
            assert!(found.mirrored.apart.max > 0.05 * found.reach, "{found:?}");
            let mirror = moved(&other, |at| at * Vec3::new(1.0, 1.0, -1.0));
            let found = space(&tree, &mirror);
            assert!(found.mirrored.apart.max < small, "{found:?}");
            assert!(found.fitted.apart.max > 0.05 * found.reach, "{found:?}");
        }
    }

    #[test]
    fn where_frames_begin_counts_as_they_are() {
        let axis = |origin| Axis::new(&crooked(), origin).unwrap();
        let shifted = axis(DVec3::X).with(&axis(DVec3::ZERO));
        let mean = shifted.as_is.mean;
        assert!(mean > 0.1 && shifted.as_is.max <= 1.0 + 1e-9, "{shifted:?}");
        assert!(shifted.rooted.max < 1e-12);
        // Back where it was.
        let back = moved(&crooked(), |at| at + Vec3::X);
        let back = axis(DVec3::X).with(&Axis::new(&back, DVec3::ZERO).unwrap());
        assert!(back.as_is.max < 1e-5, "{back:?}");
    }

    #[test]
    fn parallel_lines_are_apart_by_what_is_between_them() {
        let line = grown(&[(0, [0.0, 10.0, 0.0])]);
        let other = moved(&line, |at| at + Vec3::new(3.0, 0.0, 4.0));
        let found = space(&line, &other).as_is;
        assert!(
            (found.mean - 5.0).abs() < 1e-6 && (found.max - 5.0).abs() < 1e-6,
            "{found:?}"
        );
        let longer = grown(&[(0, [0.0, 14.0, 0.0])]);
        let found = space(&line, &longer).as_is;
        // The farthest is a tip, the mean half of 4²/2 over 14.
        assert!((found.max - 4.0).abs() < 1e-9, "{found:?}");
        assert!((found.mean - 8.0 / 14.0 / 2.0).abs() < 1e-3, "{found:?}");
        assert!(Axis::new(&grown(&[]), DVec3::ZERO).is_none());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn distances_are_the_same_both_ways(a in spec(12), b in spec(12)) {
            let (Some(one), Some(other)) = (Axis::new(&a, DVec3::ZERO), Axis::new(&b, DVec3::ZERO)) else {
                return Ok(());
            };
            let (to, back) = (one.with(&other), other.with(&one));
            prop_assert!((to.as_is.mean - back.as_is.mean).abs() < 1e-9);
            prop_assert!((to.as_is.max - back.as_is.max).abs() < 1e-9);
            prop_assert!((to.rooted.max - back.rooted.max).abs() < 1e-5);
            prop_assert!(to.as_is.mean <= to.as_is.max);
        }
    }
}
