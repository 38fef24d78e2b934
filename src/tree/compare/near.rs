//! How far a point is from a tree's axis.

use glam::{DVec3, Vec3};

use crate::tree::{NO_PARENT, Tree, nearest};

/// Finds nearest points of an axis.
pub(super) struct Nearest(nearest::Nearest<2>);

/// All segments of a tree.
fn pieces(tree: &Tree) -> Vec<[Vec3; 2]> {
    let piece = |(parent, to): (&u32, &Vec3)| match *parent {
        NO_PARENT => None,
        parent => Some([tree.position[parent as usize], *to]),
    };
    let ends = tree.parent.iter().zip(tree.position.iter());
    ends.filter_map(piece).collect()
}

impl Nearest {
    /// Of all segments of a tree.
    pub(super) fn new(tree: &Tree) -> Self {
        Self(nearest::Nearest::new(pieces(tree)))
    }

    /// The nearest point to a point, on the first of equally near segments. None where there is no segment.
    pub(super) fn point(&self, to: DVec3) -> Option<DVec3> {
        self.0.point(to, on_piece)
    }
}

/// The point of a straight piece that is nearest to a point.
fn on_piece([a, b]: [DVec3; 2], to: DVec3) -> DVec3 {
    let along = b - a;
    let length = along.length_squared();
    if length > 0.0 {
        a + ((to - a).dot(along) / length).clamp(0.0, 1.0) * along
    } else {
        a
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::super::tests::spec;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_hierarchy_finds_what_asking_all_finds(tree in spec(40), to in prop::array::uniform3(-9.0..9.0)) {
            let to = DVec3::from(to);
            let nearest = Nearest::new(&tree);
            let pieces = pieces(&tree);
            let all = pieces.iter().map(|ends| on_piece(ends.map(|end| end.as_dvec3()), to));
            let least = all.map(|point| point.distance(to)).reduce(f64::min);
            let found = nearest.point(to).map(|point| point.distance(to));
            prop_assert_eq!(found, least);
        }
    }
}
