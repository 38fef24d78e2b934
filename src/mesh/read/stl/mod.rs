//! STL, the format of printers: triangles, each with its own corners. Corners of equal coordinates are joined while they are read,
//! since a surface in pieces has no neighbours. Normals are passed over: the corners' order has them, and files lie about them.

pub(super) mod ascii;
pub(super) mod binary;

use super::join::{Joiner, Pages};
use super::points::{Coordinate, mesh_of_pages};
use super::{Stop, Surface, Task, with_room};

/// Triangles between two looks at whether to go on.
const TRIANGLES: usize = 1 << 12;

/// Triangles of which the corners are joined.
pub(super) struct Joined<C> {
    joiner: Joiner<C>,
    triangles: Vec<[u32; 3]>,
}

impl<C: Coordinate> Joined<C> {
    /// With room for so many triangles of a closed surface, which has half as many vertices.
    pub(super) fn with_room(triangles: usize) -> Result<Self, Stop> {
        Ok(Self {
            joiner: Joiner::with_room(triangles / 2 + triangles / 64)?,
            triangles: with_room(triangles)?,
        })
    }

    #[inline]
    pub(super) fn add(&mut self, [a, b, c]: [[C; 3]; 3], task: &Task<'_>) -> Result<(), Stop> {
        if self.triangles.len().is_multiple_of(TRIANGLES) {
            task.go_on()?;
            task.check_triangles(self.triangles.len() + 1)?;
            self.joiner.check(task)?;
        }
        let corners = [
            self.joiner.number(a)?,
            self.joiner.number(b)?,
            self.joiner.number(c)?,
        ];
        self.triangles.push(corners);
        Ok(())
    }

    /// The vertices, each of its own coordinates, and the triangles.
    pub(super) fn into_parts(self, task: &Task<'_>) -> Result<Parts<C>, Stop> {
        task.check_triangles(self.triangles.len())?;
        self.joiner.check(task)?;
        Ok((self.joiner.into_points(), self.triangles))
    }

    fn into_surface(self, task: &Task<'_>) -> Result<Surface, Stop> {
        let (points, triangles) = self.into_parts(task)?;
        Ok(Surface {
            mesh: mesh_of_pages(points, triangles)?,
            ..Surface::default()
        })
    }
}

/// Vertices and triangles.
pub(super) type Parts<C> = (Pages<C>, Vec<[u32; 3]>);
