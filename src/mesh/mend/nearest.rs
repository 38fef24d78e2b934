//! The nearest point of a mesh.

use glam::{DVec3, Vec3};

use crate::mesh::Mesh;
use crate::tree::nearest;

/// Finds nearest points of a mesh.
pub(super) struct Nearest(nearest::Nearest<3>);

impl Nearest {
    /// Over all triangles of a mesh that is clean.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let corners = |face: &[u32; 3]| face.map(|vertex| mesh.positions[vertex as usize]);
        let triangles: Vec<[Vec3; 3]> = mesh.triangles.iter().map(corners).collect();
        Self(nearest::Nearest::new(triangles))
    }

    /// The nearest point to a point, on the first of equally near triangles. None where there is no triangle.
    pub(super) fn point(&self, to: DVec3) -> Option<DVec3> {
        self.0.point(to, on_triangle)
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
