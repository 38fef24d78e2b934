//! Vertices of equal coordinates: files without connectivity (STL) have one for every corner of a triangle.
//!
//! The coordinates' bits and the vertex's number make one key of 128 bits; sorted keys stand in groups of equal coordinates, each
//! begun by its smallest number. Equal is equal exactly: vertices that are merely near are a question of tolerance, which a report has
//! no business to answer.

use glam::Vec3;
use rayon::prelude::*;

/// The smallest used vertex with the same coordinates, for each vertex; unused vertices stand for themselves.
pub(in crate::mesh) fn representatives(positions: &[Vec3], used: &[bool]) -> Vec<u32> {
    let mut keys: Vec<u128> = (0_u32..)
        .zip(positions.iter().zip(used))
        .filter(|(_, (_, used))| **used)
        .map(|(vertex, (position, _))| key(*position, vertex))
        .collect();
    keys.par_sort_unstable();
    let mut first: Vec<u32> = (0_u32..).take(positions.len()).collect();
    for group in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
        for key in &group[1..] {
            first[vertex(*key) as usize] = vertex(group[0]);
        }
    }
    first
}

/// Adding zero makes -0 and 0 one.
fn key(position: Vec3, vertex: u32) -> u128 {
    let [x, y, z] = (position + Vec3::ZERO)
        .to_array()
        .map(|c| u128::from(c.to_bits()));
    x << 96 | y << 64 | z << 32 | u128::from(vertex)
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the low half is what is asked for"
)]
fn vertex(key: u128) -> u32 {
    key as u32
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn zeros_of_both_signs_are_one_and_neighbours_are_two() {
        let positions = [Vec3::ZERO, Vec3::new(-0.0, 0.0, -0.0), Vec3::splat(1e-45)];
        assert_eq!(representatives(&positions, &[true; 3]), [0, 0, 2]);
        assert_eq!(representatives(&positions, &[false, true, true]), [0, 1, 2]);
    }

    proptest! {
        #[test]
        fn each_vertex_gets_the_first_used_one_of_its_place(
            vertices in prop::collection::vec(((-1_i8..=1, -1_i8..=1, 0_i8..=1), prop::bool::weighted(0.8)), 0..60)
        ) {
            let positions: Vec<Vec3> = vertices
                .iter()
                .map(|((x, y, z), _)| Vec3::new(f32::from(*x), f32::from(*y), f32::from(*z)))
                .collect();
            let used: Vec<bool> = vertices.iter().map(|(_, used)| *used).collect();
            let found = representatives(&positions, &used);
            for vertex in 0..positions.len() {
                let first = (0..positions.len())
                    .find(|other| used[*other] && positions[*other] == positions[vertex]);
                let expected = if used[vertex] { first.unwrap_or(vertex) } else { vertex };
                prop_assert_eq!(found[vertex] as usize, expected);
            }
        }
    }
}
