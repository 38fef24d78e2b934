//! A skeleton as it is seen inside the surface that is around it: a thin tube along its axes.

use glam::Vec3;

use super::Mesh;
use crate::tree::Tree;
use crate::tree::tubes;

/// Of the skeleton's own radius, so that it lies inside whatever it belongs to.
const THIN: f32 = 0.3;
/// Thickest, in parts of the skeleton's longest side.
const THICKEST: f32 = 0.004;
/// Corners of a ring.
const SIDES: u32 = 6;

/// Thin tubes along a skeleton's axes, from the same origin as its positions.
#[must_use]
pub fn along(skeleton: &Tree) -> Mesh {
    let places = || skeleton.position.iter().copied();
    let low = places().fold(Vec3::INFINITY, Vec3::min);
    let high = places().fold(Vec3::NEG_INFINITY, Vec3::max);
    let most = THICKEST * (high - low).max_element();
    let mut thin = skeleton.clone();
    for radius in thin.radius.iter_mut() {
        *radius = (*radius * THIN).min(most);
    }
    let mut records = Vec::new();
    tubes::segments(&thin, &[], u32::MAX, &mut records);
    let made = tubes::mesh(&records, 1.0, SIDES);
    let (triangles, _) = made.indices.as_chunks::<3>();
    Mesh {
        positions: made.positions.into_iter().map(Vec3::from).collect(),
        triangles: triangles.to_vec(),
        ..Mesh::default()
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::mesh::{ReadLimits, read_bytes};

    #[test]
    fn a_line_lies_within_the_tubes_of_its_skeleton() {
        let swc = b"1 1 0 0 0 2 -1\n2 1 0 10 0 2 1\n3 1 5 18 0 1 2\n4 1 -5 18 0 0.01 2\n";
        let read = read_bytes(
            swc,
            &ReadLimits::default(),
            &std::sync::atomic::AtomicBool::new(false),
        )
        .unwrap();
        let skeleton = read.skeleton.unwrap();
        let line = along(&skeleton);
        assert!(!line.triangles.is_empty());
        for at in &line.positions {
            let near = (1..skeleton.len()).any(|node| {
                let parent = skeleton.parent[node] as usize;
                let (a, b) = (skeleton.position[parent], skeleton.position[node]);
                let part = ((at - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                let radius = skeleton.radius[parent].max(skeleton.radius[node]);
                at.distance(a.lerp(b, part)) <= radius * 0.31
            });
            assert!(near, "{at}");
        }
    }
}
