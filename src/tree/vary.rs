//! Another individual of the same kind: a drawing whose branches stand and are as long a little otherwise, by a seed.
//!
//! Each branch is turned where it leaves its parent, about a random axis square to it, by an angle drawn evenly from 0 to the spread; each segment is made longer or
//! shorter by a factor drawn evenly around 1. All that grows from it, organs too, goes along. Radii stay. What is drawn for a node depends on the seed
//! and the node's number alone (SplitMix64, Steele, Lea and Flood 2014), so the same seed gives the same tree on every machine.

use glam::{Quat, Vec3};

use super::axes::axis_children;
use super::draws::Draws;
use super::{Drawing, NO_PARENT, Tree};

/// How far individuals differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Radians that a branch is turned at most.
    pub angle: f32,
    /// Parts of its length that a segment is longer or shorter at most, 0 to 1.
    pub length: f32,
}

impl Spread {
    /// That of the individuals of a sketch whose laws leave nothing to chance: 12° and 15 %.
    pub const USUAL: Self = Self {
        angle: std::f32::consts::PI / 15.0,
        length: 0.15,
    };

    /// None at all.
    pub const NONE: Self = Self {
        angle: 0.0,
        length: 0.0,
    };
}

/// The individual of a seed; with no spread it is the drawing itself.
#[must_use]
pub fn varied(drawing: &Drawing, seed: u64, spread: Spread) -> Drawing {
    let mut other = drawing.clone();
    if spread == Spread::NONE {
        return other;
    }
    let Tree {
        parent, position, ..
    } = &drawing.tree;
    let axis = axis_children(&drawing.tree);
    let mut turn = vec![Quat::IDENTITY; parent.len()];
    for node in 0..parent.len() {
        if parent[node] == NO_PARENT {
            continue;
        }
        let before = parent[node] as usize;
        let step = position[node] - position[before];
        let mut draws = Draws::new(seed, node as u64);
        #[allow(
            clippy::cast_possible_truncation,
            reason = "positions are single, and so are their factors and angles"
        )]
        let mut up_to = |most: f64| draws.uniform(0.0, most) as f32;
        let longer = 1.0 + spread.length * (up_to(2.0) - 1.0);
        let around = up_to(std::f64::consts::TAU);
        let by = up_to(1.0) * spread.angle;
        let leaves = axis[before] as usize != node;
        let own = match step.try_normalize().filter(|_| leaves) {
            Some(ahead) => {
                let aside = Quat::from_axis_angle(ahead, around) * ahead.any_orthonormal_vector();
                Quat::from_axis_angle(aside, by)
            }
            None => Quat::IDENTITY,
        };
        turn[node] = (turn[before] * own).normalize();
        let start = other.tree.position[before];
        other.tree.position[node] = start + turn[node] * step * longer;
    }
    let moved = |node: u32, point: Vec3| match position.get(node as usize) {
        Some(place) => other.tree.position[node as usize] + turn[node as usize] * (point - *place),
        None => point,
    };
    let organs = &mut other.organs;
    let ends = organs
        .polygons
        .iter()
        .skip(1)
        .map(|next| next.first as usize);
    let ends: Vec<usize> = ends.chain([organs.corners.len()]).collect();
    for (polygon, end) in organs.polygons.iter().zip(ends) {
        for corner in organs
            .corners
            .get_mut(polygon.first as usize..end)
            .into_iter()
            .flatten()
        {
            *corner = moved(polygon.node, *corner);
        }
    }
    for sphere in &mut organs.spheres {
        sphere.center = moved(sphere.node, sphere.center);
    }
    for placed in &mut organs.placed {
        placed.position = moved(placed.node, placed.position);
        if let Some(turn) = turn.get(placed.node as usize) {
            placed.orientation = (*turn * placed.orientation).normalize();
        }
    }
    other
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;
    use crate::tree::Node;
    use crate::tree::organs::{Paint, Sphere};

    fn fork() -> Drawing {
        let mut tree = Tree {
            letters: vec!["F".to_owned()],
            ..Tree::default()
        };
        let places = [
            (NO_PARENT, [0.0, 0.0, 0.0]),
            (0, [0.0, 1.0, 0.0]),
            (1, [0.0, 2.0, 0.0]),
            (1, [0.5, 1.5, 0.0]),
            (3, [1.0, 1.5, 0.0]),
        ];
        for (parent, place) in places {
            tree.push(Node {
                parent,
                position: Vec3::from(place),
                radius: 0.1,
                letter: 0,
                order: 0,
                birth: 0,
            });
        }
        let mut drawing = Drawing {
            tree,
            ..Drawing::default()
        };
        drawing.organs.spheres.push(Sphere {
            center: Vec3::new(1.0, 1.6, 0.0),
            radius: 0.05,
            paint: Paint::default(),
            birth: 0,
            node: 4,
        });
        drawing
    }

    #[test]
    fn individuals_differ_within_the_spread_and_a_seed_is_one_of_them() {
        let drawing = fork();
        let spread = Spread {
            angle: 0.3,
            length: 0.2,
        };
        assert_eq!(varied(&drawing, 7, Spread::NONE), drawing);
        let mut largest = 0.0_f32;
        for seed in 0..200 {
            let other = varied(&drawing, seed, spread);
            assert_eq!(other, varied(&drawing, seed, spread));
            assert_eq!(other.tree.parent, drawing.tree.parent);
            let step = |drawing: &Drawing, node: usize| {
                let before = drawing.tree.parent[node] as usize;
                drawing.tree.position[node] - drawing.tree.position[before]
            };
            for node in 1..5 {
                let [was, is] = [&drawing, &other].map(|drawing| step(drawing, node));
                let longer = is.length() / was.length();
                assert!((0.8 - 1e-5..=1.2 + 1e-5).contains(&longer), "{longer}");
            }
            // The trunk stands as it did; the branch is turned, and what grows from it with it.
            assert!(step(&other, 2).angle_between(Vec3::Y) < 1e-3);
            let turned = step(&other, 3).angle_between(step(&drawing, 3));
            assert!(turned <= 0.3 + 1e-3, "{turned}");
            largest = largest.max(turned);
            let bend = step(&other, 3).angle_between(step(&other, 4));
            assert!((bend - step(&drawing, 3).angle_between(step(&drawing, 4))).abs() < 1e-3);
            let carried = other.organs.spheres[0]
                .center
                .distance(other.tree.position[4]);
            assert!((carried - 0.1).abs() < 1e-5);
        }
        assert!(largest > 0.25, "{largest}");
        assert_ne!(varied(&drawing, 1, spread), varied(&drawing, 2, spread));
    }
}
