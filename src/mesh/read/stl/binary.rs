//! Binary STL: 84 bytes of header and count, then 50 bytes a triangle: normal, three corners, two bytes that mean nothing.

use super::super::kind::{STL_HEADER, STL_TRIANGLE, stl_length, stl_triangles};
use super::super::points::{is_coordinate, no_coordinate};
use super::super::{Stop, Surface, Task};
use super::Joined;

/// Bytes of the normal.
const NORMAL: usize = 12;

/// Reads a binary STL file.
pub(in crate::mesh::read) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let count = stl_triangles(bytes).unwrap_or(0);
    if stl_length(count) != bytes.len() as u64 {
        let problem = format!(
            "announces {count} triangles, which make a file of {} bytes, but it has {}: it is cut short or damaged, save it again",
            stl_length(count),
            bytes.len()
        );
        return Err(Stop::fault(STL_HEADER - 4, problem));
    }
    let rows = bytes[STL_HEADER..].chunks_exact(STL_TRIANGLE);
    task.check_triangles(rows.len())?;
    let mut joined = Joined::<f32>::with_room(rows.len())?;
    for (row, number) in rows.zip(0..) {
        let corners = [0, 1, 2]
            .map(|corner| [0, 1, 2].map(|axis| float(row, NORMAL + 12 * corner + 4 * axis)));
        for (coordinate, place) in corners.as_flattened().iter().zip(0..) {
            if !is_coordinate((*coordinate).into()) {
                let at = STL_HEADER + STL_TRIANGLE * number + NORMAL + 4 * place;
                return Err(no_coordinate(at, (*coordinate).into()));
            }
        }
        joined.add(corners, task)?;
    }
    joined.into_surface(task)
}

/// The number at a place.
#[inline]
fn float(row: &[u8], at: usize) -> f32 {
    let bytes = row.get(at..).and_then(<[u8]>::first_chunk);
    f32::from_le_bytes(bytes.copied().unwrap_or_default())
}
