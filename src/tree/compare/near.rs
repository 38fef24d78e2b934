//! A tree's axis as straight pieces, in a hierarchy of boxes (obvhs, PLOC): how far a point is from it.

use glam::{DVec3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use crate::tree::{NO_PARENT, Tree};

/// Finds nearest points of an axis.
pub(super) struct Nearest {
    pieces: Vec<[Vec3; 2]>,
    bvh: Bvh2,
}

impl Nearest {
    /// Of all segments of a tree.
    pub(super) fn new(tree: &Tree) -> Self {
        let piece = |(parent, to): (&u32, &Vec3)| match *parent {
            NO_PARENT => None,
            parent => Some([tree.position[parent as usize], *to]),
        };
        let ends = tree.parent.iter().zip(tree.position.iter());
        let pieces: Vec<[Vec3; 2]> = ends.filter_map(piece).collect();
        let boxes: Vec<Aabb> = pieces
            .iter()
            .map(|[a, b]| Aabb::new(a.min(*b).into(), a.max(*b).into()))
            .collect();
        let indices = (0_u32..).take(boxes.len()).collect();
        let bvh = PlocBuilder::with_capacity(boxes.len()).build(
            PlocSearchDistance::Low,
            &boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        Self { pieces, bvh }
    }

    /// The nearest point to a point; of equally near ones that of the first segment, so that the shape of the hierarchy does not matter. None where
    /// there is no segment.
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
            for piece in self.bvh.primitive_indices.get(range).unwrap_or_default() {
                let Some(ends) = self.pieces.get(*piece as usize) else {
                    continue;
                };
                let point = on_piece(ends.map(|end| end.as_dvec3()), to);
                let distance = point.distance_squared(to);
                let is_better =
                    |(far, other, _): (f64, u32, DVec3)| (distance, *piece) < (far, other);
                if best.is_none_or(is_better) {
                    best = Some((distance, *piece, point));
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
            let all = nearest.pieces.iter().map(|ends| on_piece(ends.map(|end| end.as_dvec3()), to));
            let least = all.map(|point| point.distance(to)).reduce(f64::min);
            let found = nearest.point(to).map(|point| point.distance(to));
            prop_assert_eq!(found, least);
        }
    }
}
