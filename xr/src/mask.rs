//! The parts of a picture that the lenses hide: nobody sees them, so nobody need draw them.

/// What both eyes cannot see of their pictures. Plain data; whoever draws keeps the depth test busy there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VisibilityMask {
    /// Another one whenever the mask is another one.
    pub revision: u64,
    /// Left, right: three corners a triangle, each at the tangents (x right, y up) of the angles at which the eye sees it.
    /// Numbers are finite. An eye that sees its whole picture has none.
    pub hidden: [Vec<[f32; 2]>; 2],
}

/// A mask of more corners than this is no mask but a fault: runtimes have some hundreds.
pub const MOST_CORNERS: usize = 65_536;

/// The triangles that a runtime's vertices and indices mean. One that names a vertex that is not there, or whose
/// corners are no numbers, is left out, and so is a mask that is absurdly large: to draw too much harms nobody.
#[must_use]
pub fn triangles(vertices: &[[f32; 2]], indices: &[u32]) -> Vec<[f32; 2]> {
    if indices.len() > MOST_CORNERS {
        return Vec::new();
    }
    let corner = |index: &u32| {
        let place = vertices.get(usize::try_from(*index).ok()?)?;
        place
            .iter()
            .all(|value| value.is_finite())
            .then_some(*place)
    };
    indices
        .chunks_exact(3)
        .filter_map(|triangle| match triangle {
            [a, b, c] => Some([corner(a)?, corner(b)?, corner(c)?]),
            _ => None,
        })
        .flatten()
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "the table says what it expects"
    )]

    use super::*;

    #[test]
    fn only_whole_triangles_of_numbers_count() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [f32::NAN, 1.0]];
        let one = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let cases: [(&[u32], &[[f32; 2]]); 6] = [
            (&[], &[]),
            (&[0, 1, 2], &one),
            (&[0, 1, 2, 0, 1], &one),
            (&[0, 1, 4, 0, 1, 2], &one),
            (&[0, 1, u32::MAX], &[]),
            (&[3, 1, 2], &[]),
        ];
        for (indices, expected) in cases {
            assert_eq!(triangles(&corners, indices), expected, "{indices:?}");
        }
        assert!(triangles(&[], &[0, 1, 2]).is_empty());
        assert!(triangles(&corners, &vec![0; MOST_CORNERS + 3]).is_empty());
    }
}
