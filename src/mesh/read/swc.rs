//! SWC, the skeletons of neuron atlases: nodes with radii, read by the room `tree`, and a surface of tubes to see and check them by.
//!
//! The surface is what Ramus draws of any tree: a tube for each axis, closed at both ends, laterals beginning within their parents.
//! Tubes narrow at tips, as everything that grows does here; the skeleton's radii stay as they are. A tree has single precision, so the
//! skeleton is moved to its origin before tubes are made, where that loses nothing.

use glam::{DVec3, Vec3};

use super::points::origin;
use super::stl::{Joined, Parts};
use super::{Stop, Surface, Task};
use crate::mesh::Mesh;
use crate::tree::tubes::{self, NODE_BYTES, TubeSegment};
use crate::tree::{Tree, import};

/// Corners of a ring, from the finest on: fewer where there would be more triangles than are read.
const SIDES: [u32; 4] = [12, 8, 6, 4];

/// Segments that are made triangles at once.
const SEGMENTS: usize = 1 << 10;

/// Reads an SWC file.
pub(super) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    task.go_on()?;
    let mut skeleton = import::swc(bytes).map_err(Stop::Skeleton)?;
    let origin = origin(skeleton.position.iter().map(|point| point.to_array()));
    for position in skeleton.position.iter_mut() {
        *position = (position.as_dvec3() - origin).as_vec3();
    }
    of_skeleton(skeleton, origin, task)
}

/// A skeleton of which positions are counted from an origin, with the surface of its tubes.
pub(super) fn of_skeleton(skeleton: Tree, origin: DVec3, task: &Task<'_>) -> Result<Surface, Stop> {
    task.go_on()?;
    let segments = skeleton.segment_count();
    if segments == 0 {
        let problem = "begins a skeleton in which no node has a parent: there is nothing to see, save it with its segments";
        return Err(Stop::fault(0, problem));
    }
    let (points, triangles) = tubes(&skeleton, segments, task)?;
    Ok(Surface {
        mesh: Mesh {
            origin,
            positions: points.iter().map(Vec3::from).collect(),
            triangles,
        },
        skeleton: Some(skeleton),
        ..Surface::default()
    })
}

/// The surface of a skeleton's tubes.
fn tubes(skeleton: &Tree, segments: usize, task: &Task<'_>) -> Result<Parts<f32>, Stop> {
    let most = |sides: u32| segments.saturating_mul(4 * sides as usize);
    let fits = |sides: &u32| most(*sides) <= task.limits.triangles;
    let sides = SIDES.into_iter().find(fits).unwrap_or(3);
    let bytes = skeleton.len().saturating_mul(NODE_BYTES);
    let given = Vec::<u8>::new().try_reserve_exact(bytes);
    given.map_err(|_| Stop::Memory(bytes as u64))?;
    let mut records = Vec::new();
    tubes::segments(skeleton, &[], u32::MAX, &mut records);
    let mut joined = Joined::<f32>::with_room(2 * sides as usize * segments)?;
    for records in records.chunks(SEGMENTS) {
        task.go_on()?;
        add(records, sides, &mut joined, task)?;
    }
    joined.into_parts(task)
}

/// Adds the triangles of some segments, but those that a radius or length of 0 leaves without three corners.
fn add(
    records: &[TubeSegment],
    sides: u32,
    joined: &mut Joined<f32>,
    task: &Task<'_>,
) -> Result<(), Stop> {
    let mesh = tubes::mesh(records, 1.0, sides);
    let corner = |&corner: &u32| {
        mesh.positions
            .get(corner as usize)
            .copied()
            .unwrap_or_default()
    };
    for [a, b, c] in mesh.indices.as_chunks::<3>().0 {
        let [a, b, c] = [a, b, c].map(corner);
        let is_finite = [a, b, c]
            .iter()
            .all(|&corner| Vec3::from(corner).is_finite());
        if !is_finite {
            let problem = "begins a skeleton so large that single precision does not hold its surface: scale it down";
            return Err(Stop::fault(0, problem));
        }
        if a != b && b != c && c != a {
            joined.add([a, b, c], task)?;
        }
    }
    Ok(())
}
