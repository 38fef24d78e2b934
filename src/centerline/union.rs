//! The outer wall of parts that are pushed into each other.
//!
//! What is inside another part is no wall: there the winding number is above a half on both sides. Stretches of triangles that hang together
//! and pass through nothing are wall or not as a whole, and one point decides. Triangles that others pass through are cut into four again and
//! again where one of their pieces is wall and another is not. Pieces are not sewn to their neighbours: they share corners with them,
//! which is all that [the cover](super::cover) goes by.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::mesh::Mesh;
use crate::mesh::intersect::{IntersectParams, intersections};
use crate::mesh::pick::{Picker, Winding};
use crate::mesh::report::NONE;
use crate::mesh::surface::Surface;

/// How often a triangle is cut in four at most.
const CUTS: u32 = 4;
/// How far off a piece it is looked whether that is inside, as a part of its size, and of the model's.
const OFF: f64 = 1e-3;
const OFF_LEAST: f64 = 2e-6;
/// Pieces at most.
const PIECES_MOST: usize = 20_000_000;

/// Which side of a piece is inside.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// The back, as it should be.
    Back,
    /// The front: it is turned.
    Front,
    /// Both or none: it is no wall.
    Neither,
}

/// The outer wall as a mesh of its own. `Some(None)` where the whole surface is outer wall; None when `cancel` was set.
pub(super) fn outer(surface: &Surface, cancel: &AtomicBool) -> Option<Option<Mesh>> {
    let mesh = surface.mesh();
    let found = intersections(mesh, &IntersectParams::default(), cancel, &mut |_, _| {})?;
    let mut passed = vec![false; mesh.triangles.len()];
    found
        .triangles()
        .iter()
        .for_each(|triangle| passed[*triangle as usize] = true);
    let stretches = stretches(surface, &passed);
    if found.pairs.is_empty() && stretches.len() == 1 {
        return Some(None);
    }
    let size = mesh
        .positions
        .iter()
        .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[min, max], one| {
            [min.min(*one), max.max(*one)]
        });
    let sorter = Sorter {
        winding: Winding::new(surface.picker()),
        outward: if surface.picker().is_inside_out() {
            -1.0
        } else {
            1.0
        },
        least: OFF_LEAST * f64::from((size[1] - size[0]).max_element()),
    };
    let mut wall = Mesh {
        origin: mesh.origin,
        positions: mesh.positions.clone(),
        triangles: Vec::new(),
    };
    let corners = |triangle: u32| {
        surface.faces()[triangle as usize].map(|vertex| mesh.positions[vertex as usize])
    };
    let mut changed = false;
    for stretch in &stretches {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let area = |triangle: &&u32| {
            let [a, b, c] = corners(**triangle).map(Vec3::as_dvec3);
            (b - a).cross(c - a).length()
        };
        let largest = stretch
            .iter()
            .max_by(|a, b| area(a).total_cmp(&area(b)).then(b.cmp(a)));
        let side = largest.map_or(Side::Neither, |largest| sorter.side(corners(*largest)));
        changed |= side != Side::Back;
        for triangle in stretch {
            push(&mut wall, surface.faces()[*triangle as usize], side);
        }
    }
    let cut: Vec<(u32, [u32; 3])> = surface
        .triangles()
        .filter(|(triangle, _)| passed[*triangle as usize])
        .collect();
    changed |= !cut.is_empty();
    let pieces: Vec<Vec<[Vec3; 3]>> = cut
        .par_iter()
        .map(|(triangle, _)| {
            let mut pieces = Vec::new();
            if !cancel.load(Ordering::Relaxed) {
                sorter.cut(corners(*triangle), CUTS, &mut pieces);
            }
            pieces
        })
        .collect();
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    // Vertices in one place are joined when the wall becomes a surface.
    for piece in pieces.into_iter().flatten().take(PIECES_MOST) {
        let first = u32::try_from(wall.positions.len()).unwrap_or(NONE);
        wall.positions.extend(piece);
        wall.triangles.push([first, first + 1, first + 2]);
    }
    Some(changed.then_some(wall))
}

fn push(wall: &mut Mesh, [a, b, c]: [u32; 3], side: Side) {
    match side {
        Side::Back => wall.triangles.push([a, b, c]),
        Side::Front => wall.triangles.push([a, c, b]),
        Side::Neither => {}
    }
}

struct Sorter<'a> {
    winding: Winding<'a>,
    outward: f64,
    least: f64,
}

impl Sorter<'_> {
    fn side(&self, corners: [Vec3; 3]) -> Side {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        self.side_at((a + b + c) / 3.0, (b - a).cross(c - a))
    }

    /// Of a piece at a point of it; `cross` is twice its area on it.
    fn side_at(&self, point: DVec3, cross: DVec3) -> Side {
        let Some(normal) = cross.try_normalize() else {
            return Side::Neither;
        };
        let off = (OFF * cross.length().sqrt()).max(self.least) * self.outward * normal;
        match (
            self.winding.is_inside(point - off),
            self.winding.is_inside(point + off),
        ) {
            (true, false) => Side::Back,
            (false, true) => Side::Front,
            _ => Side::Neither,
        }
    }

    /// Adds what of a triangle is wall.
    fn cut(&self, corners: [Vec3; 3], cuts: u32, wall: &mut Vec<[Vec3; 3]>) {
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let (middle, cross) = ((a + b + c) / 3.0, (b - a).cross(c - a));
        let side = self.side_at(middle, cross);
        let near = |corner: DVec3| self.side_at(corner.lerp(middle, 0.1), cross);
        if cuts == 0 || cuts < CUTS && [a, b, c].into_iter().all(|corner| near(corner) == side) {
            let [p, q, r] = corners;
            match side {
                Side::Back => wall.push([p, q, r]),
                Side::Front => wall.push([p, r, q]),
                Side::Neither => {}
            }
            return;
        }
        let [p, q, r] = corners;
        let (pq, qr, rp) = ((p + q) / 2.0, (q + r) / 2.0, (r + p) / 2.0);
        for piece in [[p, pq, rp], [pq, q, qr], [rp, qr, r], [pq, qr, rp]] {
            self.cut(piece, cuts - 1, wall);
        }
    }
}

/// Triangles that hang together by edges, without those that others pass through.
fn stretches(surface: &Surface, passed: &[bool]) -> Vec<Vec<u32>> {
    let mut seen = passed.to_vec();
    let mut all = Vec::new();
    for (first, _) in surface.triangles() {
        if std::mem::replace(&mut seen[first as usize], true) {
            continue;
        }
        let mut stretch = vec![first];
        let mut next = 0;
        while let Some(triangle) = stretch.get(next).copied() {
            next += 1;
            for half_edge in 3 * triangle..3 * triangle + 3 {
                if let Some(other) = surface.twin(half_edge).map(|twin| twin / 3)
                    && !std::mem::replace(&mut seen[other as usize], true)
                {
                    stretch.push(other);
                }
            }
        }
        all.push(stretch);
    }
    all
}

/// The surface of a mesh. None when `cancel` was set.
pub(super) fn surface_of(mesh: Mesh, cancel: &AtomicBool) -> Option<Surface> {
    let picker = Picker::new(Arc::new(mesh), cancel, &mut |_, _| {})?;
    Surface::new(picker, cancel)
}
