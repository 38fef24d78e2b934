//! Vertices near each other become one.
//!
//! In the order of their numbers, each vertex joins the nearest of those that stand for others and are within the distance, or stands for
//! itself. So none moves farther than the distance, those that stand for others are farther than that from each other, and a second time
//! changes nothing. (Joining whatever is near something near, by union–find, would run along a finely cut surface and make a point of it.)
//!
//! Vertices are looked for in a grid of cells twice the distance wide: what is within the distance lies in the eight cells nearest to
//! it, and no cell holds more than a few of them.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3, Vec3};

use super::{MendError, Weld, Work, clean};
use crate::mesh::Mesh;
use crate::mesh::report::NONE;

/// Vertices between two looks at whether to go on.
const BLOCK: usize = 1 << 13;

pub(super) fn weld(mesh: Mesh, weld: &Weld, work: &mut Work) -> Result<Mesh, MendError> {
    let distance = weld.distance.of(&mesh);
    if distance <= 0.0 {
        return Ok(mesh); // That is what it was cleaned of.
    }
    let nearest = representatives(&mesh.positions, distance, work)?;
    Ok(clean::joined(mesh, &nearest, work))
}

/// The vertex that stands for each.
fn representatives(
    positions: &[Vec3],
    distance: f64,
    work: &mut Work,
) -> Result<Vec<u32>, MendError> {
    let mut grid = Grid {
        positions,
        distance,
        heads: HashMap::new(),
        next: vec![NONE; positions.len()],
    };
    let mut found = Vec::with_capacity(positions.len());
    for vertex in (0_u32..).take(positions.len()) {
        if found.len() % BLOCK == 0 {
            work.step(found.len(), positions.len())?;
        }
        found.push(grid.nearest(vertex).unwrap_or_else(|| {
            grid.put(vertex);
            vertex
        }));
    }
    Ok(found)
}

/// Vertices that stand for others, by cells.
struct Grid<'a> {
    positions: &'a [Vec3],
    distance: f64,
    /// The last vertex of each cell.
    heads: HashMap<I64Vec3, u32>,
    /// The one before it in the same cell.
    next: Vec<u32>,
}

impl Grid<'_> {
    fn point(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize].as_dvec3()
    }

    /// The nearest that stands for others within the distance; of equally near ones the first.
    fn nearest(&self, vertex: u32) -> Option<u32> {
        let point = self.point(vertex);
        let low = ((point - self.distance) / (2.0 * self.distance)).floor();
        let mut best: Option<(f64, u32)> = None;
        for corner in 0..8_u8 {
            let bit = |at: u8| f64::from(corner >> at & 1);
            let cell = low + DVec3::new(bit(0), bit(1), bit(2));
            let mut other = self.heads.get(&cell.as_i64vec3()).copied();
            while let Some(near) = other.filter(|other| *other != NONE) {
                let far = self.point(near).distance(point);
                let closer = best.is_none_or(|best| (far, near) < best);
                if far <= self.distance && closer {
                    best = Some((far, near));
                }
                other = self.next.get(near as usize).copied();
            }
        }
        best.map(|(_, near)| near)
    }

    fn put(&mut self, vertex: u32) {
        let cell = (self.point(vertex) / (2.0 * self.distance)).floor();
        let head = self.heads.entry(cell.as_i64vec3()).or_insert(NONE);
        self.next[vertex as usize] = std::mem::replace(head, vertex);
    }
}
