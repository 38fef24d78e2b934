//! Whether triangles can be turned so that all show the same side, and which would have to be.
//!
//! Only edges with exactly two triangles bind them: at other edges there is no neighbour on the other side. What hangs together over such
//! edges is a patch; in each patch the fewer triangles are those that are turned.

use super::edges::from_to;
use super::union::Sides;
use super::{Face, NONE, is_left_out};

/// What turning would mend and what it cannot.
#[derive(Default)]
pub(super) struct Turning {
    /// Triangles that face against most of their patch, sorted.
    pub(super) turned: Vec<u32>,
    /// A triangle of each patch that has only one side.
    pub(super) one_sided: Vec<u32>,
}

impl Turning {
    /// Looks at all patches; `twins` are the other half-edges of edges that have two.
    pub(super) fn new(faces: &[Face], twins: &[u32]) -> Self {
        let mut sides = Sides::new(faces.len());
        let mut torn = Vec::new();
        for (half_edge, twin) in (0_u32..).zip(twins) {
            if *twin == NONE || half_edge > *twin {
                continue;
            }
            let different = from_to(faces, half_edge) == from_to(faces, *twin);
            if !sides.join(half_edge / 3, twin / 3, different) {
                torn.push(half_edge / 3);
            }
        }
        let mut one_sided: Vec<u32> = torn.iter().map(|one| sides.find(*one).0).collect();
        one_sided.sort_unstable();
        one_sided.dedup();
        let turned = turned(faces, &mut sides, &one_sided);
        Self { turned, one_sided }
    }
}

fn turned(faces: &[Face], sides: &mut Sides, one_sided: &[u32]) -> Vec<u32> {
    let triangles = || {
        (0_u32..)
            .zip(faces)
            .filter(|(_, face)| !is_left_out(face))
            .map(|(triangle, _)| triangle)
    };
    // How many more of a patch are on its first triangle's side than on the other.
    let mut lead = vec![0_i32; faces.len()];
    for triangle in triangles() {
        let (root, other_side) = sides.find(triangle);
        lead[root as usize] += if other_side { -1 } else { 1 };
    }
    triangles()
        .filter(|triangle| {
            let (root, other_side) = sides.find(*triangle);
            // Where both are as many, the first triangle is right.
            other_side == (lead[root as usize] >= 0) && one_sided.binary_search(&root).is_err()
        })
        .collect()
}
