//! How often the surface goes round a point: the generalized winding number.
//!
//! Of a closed surface it is 1 inside and 0 outside, of several that are pushed into each other how many the point is in, and of one with holes
//! it changes smoothly across them (Jacobson, Kavan and Sorkine-Hornung 2013). A triangle adds its solid angle over 4π (Van Oosterom and
//! Strackee 1983). Far away, boxes of triangles add what one dipole of their area does (Barill, Dickson, Schmidt, Levin and Jacobson 2018, "Fast
//! winding numbers for soups and clouds"), so a point costs as many steps as the hierarchy is deep, and not as many as there are triangles.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::Picker;
use super::node::Child;

/// A box is far from a point beyond so many of its radii. The error is below two hundredths then.
const FAR: f64 = 3.0;

/// What the triangles of a child are like from afar.
#[derive(Clone, Copy, Debug, Default)]
struct Dipole {
    /// Sum of their areas as vectors.
    area: DVec3,
    /// Their middle.
    centre: DVec3,
    /// All are within so much of it.
    radius: f64,
}

/// Winding numbers about one surface.
#[derive(Clone, Debug)]
pub struct Winding<'a> {
    picker: &'a Picker,
    /// Of each node's four children.
    dipoles: Vec<[Dipole; 4]>,
    sign: f64,
}

impl<'a> Winding<'a> {
    /// Looks at all triangles once.
    pub fn new(picker: &'a Picker) -> Self {
        let nodes = &picker.hierarchy.nodes;
        let mut dipoles = vec![[Dipole::default(); 4]; nodes.len()];
        // Children stand behind their parents.
        for place in (0..nodes.len()).rev() {
            for slot in 0..4 {
                dipoles[place][slot] = match Child::new(nodes[place].children[slot]) {
                    Child::Empty => Dipole::default(),
                    Child::Node(child) => joined(&dipoles[child as usize]),
                    Child::Run { start, length } => {
                        let corners =
                            &picker.hierarchy.corners[start as usize..(start + length) as usize];
                        of_triangles(corners)
                    }
                };
            }
        }
        Self {
            picker,
            dipoles,
            sign: if picker.inside_out { -1.0 } else { 1.0 },
        }
    }

    /// The winding number at a point.
    pub fn at(&self, point: DVec3) -> f64 {
        let hierarchy = &self.picker.hierarchy;
        let mut open: Vec<u32> = if hierarchy.nodes.is_empty() {
            Vec::new()
        } else {
            vec![0]
        };
        let mut sum = 0.0;
        while let Some(node) = open.pop() {
            for (child, dipole) in hierarchy.nodes[node as usize]
                .children
                .iter()
                .zip(&self.dipoles[node as usize])
            {
                let to = dipole.centre - point;
                let distance = to.length();
                match Child::new(*child) {
                    Child::Empty => {}
                    _ if distance > FAR * dipole.radius => {
                        sum += dipole.area.dot(to) / distance.powi(3)
                    }
                    Child::Node(child) => open.push(child),
                    Child::Run { start, length } => {
                        let corners = &hierarchy.corners[start as usize..(start + length) as usize];
                        sum += corners
                            .iter()
                            .map(|corners| solid_angle(*corners, point))
                            .sum::<f64>();
                    }
                }
            }
        }
        self.sign * sum / (2.0 * TAU)
    }

    /// Whether a point is inside.
    pub fn is_inside(&self, point: DVec3) -> bool {
        self.at(point) > 0.5
    }
}

fn of_triangles(triangles: &[[Vec3; 3]]) -> Dipole {
    let mut dipole = Dipole::default();
    let mut weights = 0.0;
    for corners in triangles {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let area = (b - a).cross(c - a) / 2.0;
        let weight = area.length();
        dipole.area += area;
        dipole.centre += weight * (a + b + c) / 3.0;
        weights += weight;
    }
    let all = || triangles.iter().flatten().map(|corner| corner.as_dvec3());
    dipole.centre = if weights > 0.0 {
        dipole.centre / weights
    } else {
        all().next().unwrap_or(DVec3::ZERO)
    };
    dipole.radius = all()
        .map(|corner| corner.distance(dipole.centre))
        .fold(0.0, f64::max);
    dipole
}

fn joined(dipoles: &[Dipole; 4]) -> Dipole {
    let there = || dipoles.iter().filter(|dipole| dipole.radius > 0.0);
    let weights: f64 = there().map(|dipole| dipole.area.length()).sum();
    let centre = if weights > 0.0 {
        there()
            .map(|dipole| dipole.area.length() * dipole.centre)
            .sum::<DVec3>()
            / weights
    } else {
        there().map(|dipole| dipole.centre).sum::<DVec3>() / (there().count().max(1) as f64)
    };
    Dipole {
        area: there().map(|dipole| dipole.area).sum(),
        centre,
        radius: there()
            .map(|dipole| dipole.centre.distance(centre) + dipole.radius)
            .fold(0.0, f64::max),
    }
}

/// The solid angle of a triangle as seen from a point, above zero from behind.
fn solid_angle(corners: [Vec3; 3], point: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3() - point);
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let over = a.dot(b.cross(c));
    let under = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * over.atan2(under)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use proptest::prelude::*;

    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::made::{sphere, torus, tube};

    fn picker(mesh: Mesh) -> Picker {
        Picker::new(Arc::new(mesh), &AtomicBool::new(false), &mut |_, _| {})
            .unwrap_or_else(|| unreachable!())
    }

    fn exact(mesh: &Mesh, point: DVec3) -> f64 {
        let corners = mesh
            .triangles
            .iter()
            .map(|face| face.map(|vertex| mesh.positions[vertex as usize]));
        corners
            .map(|corners| solid_angle(corners, point))
            .sum::<f64>()
            / (2.0 * TAU)
    }

    #[test]
    fn solids_go_once_round_what_is_in_them() {
        for (mesh, inside, outside) in [
            (
                sphere(4),
                DVec3::new(0.3, 0.2, 0.1),
                DVec3::new(1.1, 0.0, 0.0),
            ),
            (torus(60, 20), DVec3::new(2.0, 0.0, 0.1), DVec3::ZERO),
        ] {
            let picker = picker(mesh);
            let winding = Winding::new(&picker);
            assert!(
                (winding.at(inside) - 1.0).abs() < 0.02,
                "{}",
                winding.at(inside)
            );
            assert!(winding.at(outside).abs() < 0.02, "{}", winding.at(outside));
            assert!(
                winding.is_inside(inside) && !winding.is_inside(outside),
                "told apart"
            );
        }
    }

    #[test]
    fn turned_solids_have_the_same_inside_and_open_ones_half_of_it_at_the_opening() {
        let mut turned = sphere(3);
        turned.triangles.iter_mut().for_each(|face| face.swap(1, 2));
        assert!(
            Winding::new(&picker(turned)).is_inside(DVec3::ZERO),
            "turned"
        );
        let tube = picker(tube(40, 21));
        let winding = Winding::new(&tube);
        assert!(
            winding.at(DVec3::new(0.0, 0.0, 10.0)) > 0.95,
            "in the middle"
        );
        assert!(
            (winding.at(DVec3::ZERO) - 0.5).abs() < 0.02,
            "at the opening"
        );
        assert!(
            winding.at(DVec3::new(0.0, 0.0, -3.0)) < 0.1,
            "in front of it"
        );
    }

    proptest! {
        #[test]
        fn far_boxes_are_near_enough(x in -3.0..3.0_f64, y in -3.0..3.0_f64, z in -3.0..3.0_f64) {
            let mut mesh = sphere(3);
            let other = torus(30, 12);
            let first = u32::try_from(mesh.positions.len()).unwrap_or(0);
            mesh.positions.extend(other.positions);
            mesh.triangles.extend(other.triangles.into_iter().map(|face| face.map(|vertex| vertex + first)));
            let expected = exact(&mesh, DVec3::new(x, y, z));
            let found = Winding::new(&picker(mesh)).at(DVec3::new(x, y, z));
            prop_assert!((found - expected).abs() < 0.02, "{found} {expected}");
        }
    }
}
