//! The nearest point of a mesh, by a hierarchy of boxes (obvhs).

use glam::{DVec3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use crate::mesh::Mesh;

/// Finds nearest points of a mesh.
pub(super) struct Nearest {
    triangles: Vec<[Vec3; 3]>,
    bvh: Bvh2,
}

impl Nearest {
    /// Over all triangles of a mesh that is clean.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let corners = |face: &[u32; 3]| face.map(|vertex| mesh.positions[vertex as usize]);
        let triangles: Vec<[Vec3; 3]> = mesh.triangles.iter().map(corners).collect();
        let boxes: Vec<Aabb> = triangles
            .iter()
            .map(|[a, b, c]| Aabb::new(a.min(*b).min(*c).into(), a.max(*b).max(*c).into()))
            .collect();
        let indices = (0_u32..).take(boxes.len()).collect();
        let bvh = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Low,
            &boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        Self { triangles, bvh }
    }

    /// The nearest point to a point; of equally near ones that on the first triangle, so that the shape of the hierarchy does not matter. None where
    /// there is no triangle.
    pub(super) fn point(&self, to: DVec3) -> Option<DVec3> {
        let mut best: Option<(f64, u32, DVec3)> = None;
        let mut open = vec![(0.0, 0_u32)];
        while let Some((least, number)) = open.pop() {
            if best.is_some_and(|(distance, ..)| least > distance) {
                continue;
            }
            let Some(node) = self.bvh.nodes.get(number as usize) else {
                continue;
            };
            if !node.is_leaf() {
                let children = [node.first_index, node.first_index + 1];
                let mut children = children.map(|child| (self.away(child, to), child));
                // The nearer one is looked at first.
                children.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
                open.extend(children);
                continue;
            }
            let first = node.first_index as usize;
            let range = first..first + node.prim_count as usize;
            for triangle in self.bvh.primitive_indices.get(range).unwrap_or_default() {
                let Some(corners) = self.triangles.get(*triangle as usize) else {
                    continue;
                };
                let point = on_triangle(corners.map(|corner| corner.as_dvec3()), to);
                let distance = point.distance_squared(to);
                let is_better =
                    |(far, other, _): (f64, u32, DVec3)| (distance, *triangle) < (far, other);
                if best.is_none_or(is_better) {
                    best = Some((distance, *triangle, point));
                }
            }
        }
        best.map(|(_, _, point)| point)
    }

    /// The squared distance to a node's box.
    fn away(&self, number: u32, to: DVec3) -> f64 {
        let Some(node) = self.bvh.nodes.get(number as usize) else {
            return f64::INFINITY;
        };
        let (min, max) = (node.aabb().min, node.aabb().max);
        let (min, max) = (Vec3::from(min).as_dvec3(), Vec3::from(max).as_dvec3());
        to.clamp(min, max).distance_squared(to)
    }
}

/// The point of a triangle that is nearest to a point (Ericson, *Real-Time Collision Detection*, section 5.1.5).
fn on_triangle([a, b, c]: [DVec3; 3], to: DVec3) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let (d1, d2) = (ab.dot(to - a), ac.dot(to - a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(to - b), ac.dot(to - b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let over_ab = d1 * d4 - d3 * d2;
    if over_ab <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return a + d1 / (d1 - d3) * ab;
    }
    let (d5, d6) = (ab.dot(to - c), ac.dot(to - c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let over_ac = d5 * d2 - d1 * d6;
    if over_ac <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return a + d2 / (d2 - d6) * ac;
    }
    let over_bc = d3 * d6 - d5 * d4;
    let (to_c, to_b) = (d4 - d3, d5 - d6);
    if over_bc <= 0.0 && to_c >= 0.0 && to_b >= 0.0 && to_c + to_b > 0.0 {
        return b + to_c / (to_c + to_b) * (c - b);
    }
    let sum = over_ab + over_ac + over_bc;
    if sum > 0.0 {
        a + (over_ac * ab + over_ab * ac) / sum
    } else {
        a
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that stops says enough by stopping"
    )]
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::made;

    fn point() -> impl Strategy<Value = DVec3> {
        let c = || -3.0..3.0;
        (c(), c(), c()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn no_mixture_of_corners_is_nearer(
            a in point(), b in point(), c in point(), to in point(), u in 0.0..1.0, v in 0.0..1.0,
        ) {
            let found = on_triangle([a, b, c], to);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let other: DVec3 = a + u * (b - a) + v * (c - a);
            prop_assert!(found.distance(to) <= other.distance(to) + 1e-9);
        }

        #[test]
        fn the_hierarchy_finds_what_asking_all_finds(to in point()) {
            let mesh = made::torus(17, 9);
            let found = Nearest::new(&mesh).point(to).unwrap();
            let all = mesh.triangles.iter().map(|face| {
                on_triangle(face.map(|vertex| mesh.positions[vertex as usize].as_dvec3()), to)
            });
            let least = all.map(|point| point.distance(to)).fold(f64::INFINITY, f64::min);
            prop_assert!((found.distance(to) - least).abs() < 1e-12);
        }
    }

    #[test]
    fn nothing_is_near_where_nothing_is_and_needles_have_points_too() {
        assert_eq!(Nearest::new(&Mesh::default()).point(DVec3::ZERO), None);
        let [a, b] = [DVec3::ZERO, DVec3::X];
        for corners in [[a, a, a], [a, b, a], [a, b, b], [a, b, b / 2.0]] {
            let found = on_triangle(corners, DVec3::new(0.25, 1.0, 0.0));
            assert!(found.is_finite() && found.y == 0.0, "{corners:?}: {found}");
        }
    }
}
