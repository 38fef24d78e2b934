//! Open ends of a surface: those of tubes, and not holes in walls.
//!
//! An open end is the end of a tube if the surface within one radius of it has the area of a tube (2π r²) and not that of a plate around a hole
//! (3π r²).

use std::f64::consts::{PI, TAU};
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use crate::mesh::surface::Surface;
use crate::mesh::surface::graph::field;

/// Area within one radius of an open end, in π · radius², above which it is a hole in a wall: tubes have 2, plates 3, and less as ways along edges
/// are longer than straight ones.
const PLATE: f64 = 2.2;

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
    let tubes = ends.iter().zip(near.into_iter().zip(all));
    let tubes = tubes.map(|(end, (near, all))| {
        let disc = PI * end.radius * end.radius;
        let is_tube = near < PLATE * disc && all > SHEET * disc;
        (is_tube && end.centre.is_finite()).then_some(*end)
    });
    Some(tubes.collect())
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
    }
}
