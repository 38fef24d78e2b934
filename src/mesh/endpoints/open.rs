//! Open ends of a surface: those of tubes, and not holes in walls.
//!
//! An open end is the end of a tube if the surface within one radius of it has the area of a tube (2π r²) and not that of a plate around a hole
//! (3π r²). Where triangles are longer than that, it is if they lead away across the plane of the end, and not within it.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use crate::mesh::surface::Surface;
use crate::mesh::surface::graph::field;

/// Area within one radius of an open end, in π · radius², above which it is a hole in a wall: tubes have 2, plates 3, and less as ways along edges
/// are longer than straight ones.
const PLATE: f64 = 2.2;

/// Triangles at the end that are longer than so many of its radii have their area elsewhere.
const COARSE: f64 = 0.5;
/// How steeply, as a sine, triangles of a tube lead away from the plane of its end.
const STEEP: f64 = 0.7;

/// Area within some radii, in the same, below which it is the rim of a sheet: a disc has 1.
const SHEET: f64 = 1.5;
/// How many radii that is; enough that triangles longer than one radius do no harm.
const WIDE: f64 = 4.0;

/// An open end that a tube has.
#[derive(Clone, Copy)]
pub(super) struct Open {
    /// Centre of its line, from the mesh's origin.
    pub(super) centre: DVec3,
    /// Of a circle of its area.
    pub(super) radius: f64,
    /// Across its plane, of length 1.
    axis: DVec3,
}

/// How far triangles lead away from an end: in all, and across its plane to one side, each times the length of its edge there; and the sum of
/// these.
#[derive(Clone, Copy, Default)]
struct Rim {
    away: f64,
    across: f64,
    length: f64,
}

impl Rim {
    /// Whether triangles are so long that areas say little, and lead away as those of a tube do.
    fn is_of_coarse_tube(&self, radius: f64) -> bool {
        self.away > COARSE * radius * self.length && self.across.abs() > STEEP * self.away
    }
}

/// The ends of tubes among a surface's open ends, in their order; None inside for holes in walls, outside when `cancel` was set.
pub(super) fn open_ends(
    surface: &Surface,
    areas: &[f64],
    cancel: &AtomicBool,
) -> Option<Vec<Option<Open>>> {
    let loops = surface.open_ends();
    let ends: Vec<Open> = loops.iter().map(|line| measured(surface, line)).collect();
    let sources: Vec<(u32, u32)> = (0_u32..)
        .zip(loops)
        .flat_map(|(number, line)| line.iter().map(move |vertex| (*vertex, number)))
        .collect();
    let radius = |number: u32| ends.get(number as usize).map_or(0.0, |end| end.radius);
    let wide = |number: u32| WIDE * radius(number);
    let found = field(surface, surface.graph(), &sources, wide, cancel)?;
    let (mut near, mut all) = (vec![0.0; ends.len()], vec![0.0; ends.len()]);
    for (area, (source, distance)) in areas.iter().zip(found.sources.iter().zip(&found.distances)) {
        if let Some(sum) = all.get_mut(*source as usize) {
            *sum += area;
        }
        if let Some(sum) = near.get_mut(*source as usize)
            && *distance <= radius(*source)
        {
            *sum += area;
        }
    }
    let rims = rims(surface, &ends);
    let tubes = ends.iter().zip(rims).zip(near.into_iter().zip(all));
    let tubes = tubes.map(|((end, rim), (near, all))| {
        let disc = PI * end.radius * end.radius;
        let is_tube =
            (near < PLATE * disc || rim.is_of_coarse_tube(end.radius)) && all > SHEET * disc;
        (is_tube && end.centre.is_finite()).then_some(*end)
    });
    Some(tubes.collect())
}

/// How triangles lead away from each end.
fn rims(surface: &Surface, ends: &[Open]) -> Vec<Rim> {
    let mut rims = vec![Rim::default(); ends.len()];
    let of_vertex: BTreeMap<u32, usize> = (surface.open_ends().iter().enumerate())
        .flat_map(|(number, line)| line.iter().map(move |vertex| (*vertex, number)))
        .collect();
    for (triangle, face) in surface.triangles() {
        for corner in 0..3_u32 {
            let half_edge = 3 * triangle + corner;
            let [from, to, third] = [0, 1, 2].map(|on| face[(corner as usize + on) % 3]);
            let (None, Some(number)) = (surface.twin(half_edge), of_vertex.get(&from)) else {
                continue;
            };
            let [from, to, third] = [from, to, third].map(|vertex| surface.position(vertex));
            let edge = to - from;
            let away = (third - from).reject_from_normalized(edge.normalize_or_zero());
            let rim = &mut rims[*number];
            rim.length += edge.length();
            rim.away += edge.length() * away.length();
            rim.across += edge.length() * away.dot(ends[*number].axis);
        }
    }
    rims
}

/// Centre of a loop, and its radius by what it encloses; its length is too long where it zigzags from triangle to triangle.
fn measured(surface: &Surface, line: &[u32]) -> Open {
    let first = surface.position(line.first().copied().unwrap_or(0));
    let (mut length, mut moment, mut twice) = (0.0, DVec3::ZERO, DVec3::ZERO);
    for (from, to) in line.iter().zip(line.iter().cycle().skip(1)) {
        let [from, to] = [from, to].map(|vertex| surface.position(*vertex) - first);
        length += from.distance(to);
        moment += from.distance(to) * from.midpoint(to);
        twice += from.cross(to);
    }
    Open {
        centre: first + moment / length,
        radius: (twice.length() / TAU).sqrt(),
        axis: twice.normalize_or_zero(),
    }
}
