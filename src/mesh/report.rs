//! What a mesh is like: what hangs together, where it is open, and all that is wrong with it, each with the place where it is.
//!
//! ```text
//! triangles ─▶ weld ─▶ faces ─▶ edges ─▶ boundary loops, fans, turning ─▶ components
//!                        └─ left out: unusable, degenerate, duplicate
//! ```
//!
//! The report looks at the mesh as it would be once vertices of exactly equal coordinates are one: files without connectivity (STL) and
//! files that part vertices at seams (glTF, OBJ) have the surface that is seen. How many vertices that joins is told, and
//! [`ReportParams::weld`] takes the vertices as the file numbers them. Triangles that no surface has (a vertex that is not there, the same
//! vertex twice, the same three vertices again) are told and left out of all that follows, so that one of them does not hide how the
//! rest is; triangles without area but with three vertices stay, since without them there would be a hole.
//!
//! Everything is in flat arrays that are sorted or counted, and results do not depend on the number of threads. Per triangle about 60
//! bytes are taken while it works.

mod components;
pub(in crate::mesh) mod edges;
mod fans;
mod hollow;
mod loops;
mod turning;
pub(in crate::mesh) mod union;
pub(in crate::mesh) mod weld;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use robust::{Coord, orient2d};

pub use self::components::Component;
use self::components::Findings;
use self::edges::{Edges, Kinds, from_to};
pub use self::loops::BoundaryLoop;
use self::turning::Turning;
pub(super) use self::weld::representatives;
use super::Mesh;

/// No vertex, triangle or component.
pub const NONE: u32 = u32::MAX;

/// Most triangles that a report takes: half-edges are numbered in 32 bits.
pub const TRIANGLES_MOST: usize = (u32::MAX / 3) as usize;

/// A triangle by its vertices as the report joins them; [`NONE`] three times where it is left out.
pub(in crate::mesh) type Face = [u32; 3];

fn is_left_out(face: &Face) -> bool {
    face[0] == NONE
}

/// How a report looks at a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReportParams {
    /// Whether vertices of exactly equal coordinates are one.
    pub weld: bool,
}

impl Default for ReportParams {
    fn default() -> Self {
        Self { weld: true }
    }
}

/// Why there is no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReportError {
    /// Somebody asked to stop.
    #[error("the check of the model was cancelled")]
    Cancelled,
    /// More than [`TRIANGLES_MOST`] triangles, or as many vertices.
    #[error(
        "the model has {triangles} triangles and {vertices} vertices, and {TRIANGLES_MOST} of each can be checked: decimate it or cut it into parts"
    )]
    TooLarge {
        /// Triangles of the mesh.
        triangles: usize,
        /// Vertices of the mesh.
        vertices: usize,
    },
}

/// What a mesh is like. Lists of triangles and vertices hold numbers of the mesh, sorted; a vertex is told by the smallest number of its
/// coordinates. Measures are in the file's unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Vertices of the mesh.
    pub vertices: usize,
    /// Triangles of the mesh.
    pub triangles: usize,
    /// Smallest corner of the box around all that triangles use, in the file's coordinates; zero where there is none.
    pub min: DVec3,
    /// Largest corner of it.
    pub max: DVec3,
    /// Vertices that no usable triangle has.
    pub unused_vertices: Vec<u32>,
    /// Vertices that have the coordinates of one before them; where the report welds they are taken for that one.
    pub duplicate_vertices: Vec<u32>,
    /// Triangles with a vertex that is not there or not finite; left out.
    pub unusable_triangles: Vec<u32>,
    /// Triangles that have a vertex twice; left out.
    pub degenerate_triangles: Vec<u32>,
    /// Triangles of three vertices on one line, exactly.
    pub zero_area_triangles: Vec<u32>,
    /// Triangles with the same vertices as one before, in any order; left out.
    pub duplicate_triangles: Vec<u32>,
    /// Open ends.
    pub boundary_loops: Vec<BoundaryLoop>,
    /// Vertices of all open ends, one after the other.
    pub loop_vertices: Vec<u32>,
    /// Edges with more than two triangles.
    pub non_manifold_edges: Vec<[u32; 2]>,
    /// Vertices whose triangles are more than one fan; ends of non-manifold edges are not among them.
    pub non_manifold_vertices: Vec<u32>,
    /// Edges that both their triangles run through in the same direction, so that one shows its back where the other shows its front.
    pub inconsistent_edges: Vec<[u32; 2]>,
    /// Triangles to turn so that neighbours agree: the fewer of each patch, which is what hangs together by edges with two triangles.
    /// Patches with only one side are not among them.
    pub turned_triangles: Vec<u32>,
    /// What hangs together by shared vertices, larger areas first.
    pub components: Vec<Component>,
    /// The component of each triangle, [`NONE`] of those that are left out.
    pub component_of_triangle: Vec<u32>,
}

impl Report {
    /// Width, height and depth of the box.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// There is a surface, and every edge has exactly two triangles.
    pub fn is_watertight(&self) -> bool {
        !self.components.is_empty() && self.components.iter().all(Component::is_closed)
    }

    /// Every edge has one or two triangles and every vertex one fan.
    pub fn is_manifold(&self) -> bool {
        self.non_manifold_edges.is_empty() && self.non_manifold_vertices.is_empty()
    }

    /// Triangles can be turned so that neighbours show the same side.
    pub fn is_orientable(&self) -> bool {
        self.components.iter().all(|component| component.orientable)
    }

    /// Euler characteristic V − E + F of all components.
    pub fn euler_characteristic(&self) -> i64 {
        self.components
            .iter()
            .map(Component::euler_characteristic)
            .sum()
    }

    /// Surface area.
    pub fn area(&self) -> f64 {
        self.components.iter().map(|component| component.area).sum()
    }

    /// What the closed components enclose, less their hollows; what two of them share counts twice. None where no component is closed.
    pub fn volume(&self) -> Option<f64> {
        // Hollows are in the largest component, and there is nothing to take them off where that has no volume.
        let largest = self.components.first();
        let solid = largest.is_some_and(|largest| largest.signed_volume.is_some());
        self.components
            .iter()
            .filter(|component| solid || !component.hollow)
            .filter_map(|component| {
                let volume = component.signed_volume?;
                Some(if component.hollow {
                    volume
                } else {
                    volume.abs()
                })
            })
            .reduce(|sum, volume| sum + volume)
    }
}

/// Counts the stages of a report, and ends it between two where that is asked for.
struct Stages<'a> {
    cancel: &'a AtomicBool,
    progress: &'a mut dyn FnMut(usize, usize),
    done: usize,
}

impl Stages<'_> {
    const ALL: usize = 6;

    fn next(&mut self) -> Result<(), ReportError> {
        if self.cancel.load(Ordering::Relaxed) {
            return Err(ReportError::Cancelled);
        }
        (self.progress)(self.done, Self::ALL);
        self.done += 1;
        Ok(())
    }
}

/// Looks a mesh over. `progress` gets how many stages of how many are done; between stages `cancel` is looked at.
///
/// # Errors
/// [`ReportError`]: cancelled or too large. Whatever the mesh holds, there is a report.
pub fn report(
    mesh: &Mesh,
    params: &ReportParams,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Report, ReportError> {
    let (triangles, vertices) = (mesh.triangles.len(), mesh.positions.len());
    if triangles.max(vertices) > TRIANGLES_MOST {
        return Err(ReportError::TooLarge {
            triangles,
            vertices,
        });
    }
    let mut stages = Stages {
        cancel,
        progress,
        done: 0,
    };
    let mut report = Report {
        vertices,
        triangles,
        ..Report::default()
    };
    stages.next()?;
    let mut faces = report.faces(mesh, params);
    stages.next()?;
    let kinds = report.edges(&mut faces, vertices);
    stages.next()?;
    report.vertices_of_fans(&faces, &kinds, vertices);
    let turning = match kinds.inconsistent.is_empty() {
        true => Turning::default(),
        false => Turning::new(&faces, &kinds.twins),
    };
    stages.next()?;
    let (of_triangle, areas) = components::numbers(mesh, &faces);
    report.component_of_triangle = of_triangle;
    stages.next()?;
    let loops = report.loops(mesh, &faces, &kinds);
    stages.next()?;
    report.components = components::components(
        mesh,
        &Findings {
            faces: &faces,
            of_triangle: &report.component_of_triangle,
            areas: &areas,
            boundary: &kinds.boundary,
            non_manifold: &kinds.non_manifold,
            loops: &loops,
            non_manifold_vertices: &report.non_manifold_vertices,
            turned: &turning.turned,
            one_sided: &turning.one_sided,
        },
    );
    report.turned_triangles = turning.turned;
    stages.next()?;
    Ok(report)
}

/// What the triangles of a surface are to each other.
#[derive(Clone, Debug)]
pub(super) struct Neighbours {
    /// Triangles by joined vertices; [`NONE`] three times where no surface has them.
    pub(super) faces: Vec<[u32; 3]>,
    /// For each half-edge the one on the other side, [`NONE`] where there is not exactly one.
    pub(super) twins: Vec<u32>,
    /// Vertices of the closed boundary loops.
    pub(super) loops: Vec<Vec<u32>>,
}

/// Finds out. None when `cancel` was set, or for more triangles or vertices than a report takes.
pub(super) fn neighbours(mesh: &Mesh, cancel: &AtomicBool) -> Option<Neighbours> {
    let (triangles, vertices) = (mesh.triangles.len(), mesh.positions.len());
    if triangles.max(vertices) > TRIANGLES_MOST || cancel.load(Ordering::Relaxed) {
        return None;
    }
    let mut report = Report {
        vertices,
        triangles,
        ..Report::default()
    };
    let mut faces = report.faces(mesh, &ReportParams::default());
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    let kinds = report.edges(&mut faces, vertices);
    let boundary = kinds.boundary.iter();
    let edges: Vec<[u32; 2]> = boundary.map(|one| from_to(&faces, *one)).collect();
    let ways = loops::ways(&edges).into_iter();
    Some(Neighbours {
        loops: ways
            .filter(|way| way.closed)
            .map(|way| way.vertices)
            .collect(),
        faces,
        twins: kinds.twins,
    })
}

/// The numbers of those that are so.
fn numbers_where(len: usize, is_so: impl Fn(usize) -> bool + Sync) -> Vec<u32> {
    let len = u32::try_from(len).unwrap_or(NONE);
    (0..len)
        .into_par_iter()
        .filter(|one| is_so(*one as usize))
        .collect()
}

impl Report {
    /// Triangles by joined vertices, without those that no surface has; tells of these, of vertices and of the box.
    fn faces(&mut self, mesh: &Mesh, params: &ReportParams) -> Vec<Face> {
        let positions = &mesh.positions;
        let usable = |triangle: usize| {
            mesh.triangles[triangle].iter().all(|vertex| {
                positions
                    .get(*vertex as usize)
                    .is_some_and(|position| position.is_finite())
            })
        };
        self.unusable_triangles = numbers_where(self.triangles, |triangle| !usable(triangle));
        let mut used = vec![false; positions.len()];
        let mut left_out = self.unusable_triangles.iter().peekable();
        for (triangle, vertices) in (0_u32..).zip(&mesh.triangles) {
            if left_out.next_if_eq(&&triangle).is_none() {
                vertices
                    .iter()
                    .for_each(|vertex| used[*vertex as usize] = true);
            }
        }
        self.unused_vertices = numbers_where(positions.len(), |vertex| !used[vertex]);
        self.measure(mesh, &used);
        let first = representatives(positions, &used);
        self.duplicate_vertices =
            numbers_where(positions.len(), |vertex| first[vertex] as usize != vertex);
        let mut faces = mesh.triangles.clone();
        if params.weld && !self.duplicate_vertices.is_empty() {
            faces.par_iter_mut().for_each(|face| {
                *face = face.map(|vertex| first.get(vertex as usize).copied().unwrap_or(NONE));
            });
        }
        leave_out(&mut faces, &self.unusable_triangles);
        self.degenerate_triangles = numbers_where(faces.len(), |triangle| {
            let face = &faces[triangle];
            !is_left_out(face) && (face[0] == face[1] || face[1] == face[2] || face[2] == face[0])
        });
        leave_out(&mut faces, &self.degenerate_triangles);
        self.zero_area_triangles = numbers_where(faces.len(), |triangle| {
            !is_left_out(&faces[triangle]) && is_line(components::corners(mesh, triangle))
        });
        faces
    }

    fn measure(&mut self, mesh: &Mesh, used: &[bool]) {
        let of_used = mesh.positions.iter().zip(used).filter(|(_, used)| **used);
        let bounds = of_used.fold(None, |bounds: Option<(Vec3, Vec3)>, (position, _)| {
            let (min, max) = bounds.unwrap_or((*position, *position));
            Some((min.min(*position), max.max(*position)))
        });
        if let Some((min, max)) = bounds {
            (self.min, self.max) = (mesh.origin + min.as_dvec3(), mesh.origin + max.as_dvec3());
        }
    }

    /// Pairs half-edges, once duplicates are away.
    fn edges(&mut self, faces: &mut [Face], vertices: usize) -> Kinds {
        let edges = Edges::new(faces, vertices);
        self.duplicate_triangles = edges.duplicates();
        let kinds = match self.duplicate_triangles.is_empty() {
            true => edges.kinds(),
            false => {
                drop(edges);
                leave_out(faces, &self.duplicate_triangles);
                Edges::new(faces, vertices).kinds()
            }
        };
        let ends = |half_edge: &u32| sorted_ends(from_to(faces, *half_edge));
        self.non_manifold_edges = kinds
            .non_manifold
            .iter()
            .map(|(one, _)| ends(one))
            .collect();
        self.inconsistent_edges = kinds.inconsistent.iter().map(ends).collect();
        kinds
    }

    fn vertices_of_fans(&mut self, faces: &[Face], kinds: &Kinds, vertices: usize) {
        self.non_manifold_vertices = fans::non_manifold_vertices(
            faces,
            &kinds.twins,
            vertices,
            self.non_manifold_edges.as_flattened(),
        );
    }

    /// Strings boundary edges together; a triangle of each loop.
    fn loops(&mut self, mesh: &Mesh, faces: &[Face], kinds: &Kinds) -> Vec<u32> {
        let edges: Vec<[u32; 2]> = kinds
            .boundary
            .iter()
            .map(|half_edge| from_to(faces, *half_edge))
            .collect();
        let mut triangles = Vec::new();
        for way in loops::ways(&edges) {
            let triangle = kinds.boundary[way.edge] / 3;
            let component = self.component_of_triangle[triangle as usize];
            let (length, centre) = loops::length_and_centre(mesh, &way);
            let start = self.loop_vertices.len();
            self.loop_vertices.extend(way.vertices);
            self.boundary_loops.push(BoundaryLoop {
                vertices: start..self.loop_vertices.len(),
                closed: way.closed,
                length,
                centre,
                component,
            });
            triangles.push(triangle);
        }
        triangles
    }
}

fn sorted_ends([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn leave_out(faces: &mut [Face], triangles: &[u32]) {
    for triangle in triangles {
        faces[*triangle as usize] = [NONE; 3];
    }
}

/// Whether three points are on one line, exactly: then they are in each of three views along the axes.
pub(super) fn is_line(points: [Vec3; 3]) -> bool {
    let views = [[0, 1], [1, 2], [2, 0]];
    views.iter().all(|[x, y]| {
        let [a, b, c] = points.map(|point| Coord {
            x: f64::from(point[*x]),
            y: f64::from(point[*y]),
        });
        orient2d(a, b, c) == 0.0
    })
}

#[cfg(test)]
mod tests;
