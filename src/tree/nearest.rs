//! The nearest of many small pieces, straight or flat, by a hierarchy of boxes (obvhs, PLOC).

use glam::{DVec3, Vec3};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

/// Finds nearest points of pieces with so many corners each.
pub(crate) struct Nearest<const N: usize> {
    pieces: Vec<[Vec3; N]>,
    bvh: Bvh2,
}

impl<const N: usize> Nearest<N> {
    /// Over all pieces.
    pub(crate) fn new(pieces: Vec<[Vec3; N]>) -> Self {
        let around = |corners: &[Vec3; N]| {
            let all = || corners.iter().copied();
            let low = all().fold(Vec3::INFINITY, Vec3::min);
            let high = all().fold(Vec3::NEG_INFINITY, Vec3::max);
            Aabb::new(low.into(), high.into())
        };
        let boxes: Vec<Aabb> = pieces.iter().map(around).collect();
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

    /// The nearest point to a point, where `on` gives that of one piece; of equally near ones that on the first piece, so that the shape of the hierarchy
    /// does not matter. None where there is no piece.
    pub(crate) fn point(
        &self,
        to: DVec3,
        on: impl Fn([DVec3; N], DVec3) -> DVec3,
    ) -> Option<DVec3> {
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
                let Some(corners) = self.pieces.get(*piece as usize) else {
                    continue;
                };
                let point = on(corners.map(|corner| corner.as_dvec3()), to);
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

    /// How far the nearest piece is, at most `within`; `squared` gives the squared distance of the piece of a number, or none where that does not count.
    pub(crate) fn distance(
        &self,
        to: DVec3,
        within: f64,
        squared: impl Fn(u32, [DVec3; N]) -> Option<f64>,
    ) -> f64 {
        let mut best = within * within;
        let mut open = vec![(0.0, 0_u32)];
        while let Some((least, number)) = open.pop() {
            let Some(node) = self.bvh.nodes.get(number as usize) else {
                continue;
            };
            if least >= best {
                continue;
            }
            if !node.is_leaf() {
                let children = [node.first_index, node.first_index + 1];
                let mut children = children.map(|child| (self.away(child, to), child));
                children.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
                open.extend(children);
                continue;
            }
            let first = node.first_index as usize;
            let range = first..first + node.prim_count as usize;
            for piece in self.bvh.primitive_indices.get(range).unwrap_or_default() {
                if let Some(corners) = self.pieces.get(*piece as usize) {
                    let far = squared(*piece, corners.map(|corner| corner.as_dvec3()));
                    best = best.min(far.unwrap_or(best));
                }
            }
        }
        // The root of a square is not always the number itself.
        if best < within * within {
            best.sqrt()
        } else {
            within
        }
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
