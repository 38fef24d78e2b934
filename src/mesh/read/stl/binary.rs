//! Binary STL: 84 bytes of header and count, then 50 bytes a triangle: normal, three corners, two bytes that mean nothing.
//!
//! To join the corners takes nearly all of the time, since each is looked for in a large table. So each thread goes through the whole
//! file and joins a share of the corners, by a hash of their coordinates, in a table of its own; then the vertices are numbered anew
//! as they first come.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::super::join::{Joiner, NONE, Pages, folded};
use super::super::kind::{STL_HEADER, STL_TRIANGLE, stl_length, stl_triangles};
use super::super::points::{Coordinate, is_coordinate, mesh, no_coordinate};
use super::super::{MOST_VERTICES, Stop, Surface, Task, with_room};
use super::TRIANGLES;

/// Bytes of the normal.
const NORMAL: usize = 12;

/// Shares at most: each goes through the whole file.
const MOST_SHARES: usize = 8;

/// Reads a binary STL file.
pub(in crate::mesh::read) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let count = stl_triangles(bytes).unwrap_or(0);
    let rows = &bytes[STL_HEADER..];
    let length = (count as usize).saturating_mul(STL_TRIANGLE);
    let Some((rows, surplus)) = rows.split_at_checked(length) else {
        let problem = format!(
            "announces {count} triangles, which make a file of {} bytes, but it has {}, enough for {}: it is cut short or damaged, save it again",
            stl_length(count),
            bytes.len(),
            rows.len() / STL_TRIANGLE
        );
        return Err(Stop::fault(STL_HEADER - 4, problem));
    };
    if count == 0 && !surplus.is_empty() {
        let problem = format!(
            "announces no triangle, but {} bytes follow: the number is wrong, save the file again",
            surplus.len()
        );
        return Err(Stop::fault(STL_HEADER - 4, problem));
    }
    task.check_triangles(rows.len() / STL_TRIANGLE)?;
    let shares = 1 << rayon::current_num_threads().clamp(1, MOST_SHARES).ilog2();
    let mut corners = with_room(rows.len() / STL_TRIANGLE)?;
    corners.resize_with(rows.len() / STL_TRIANGLE, Default::default);
    let points = (0..shares).into_par_iter();
    let points = points.map(|share| join(rows, share, shares, &corners, task));
    let points = all_or_first(points.collect())?;
    let mut surface = number(corners, &points, task)?;
    surface.surplus_bytes = surplus.len();
    Ok(surface)
}

/// Corners by the numbers that the threads gave their vertices.
type Corners = Vec<[AtomicU32; 3]>;

/// Joins the corners of a share: each corner belongs to one share, and equal ones to the same. Its vertices are numbered
/// `share, share + shares, share + 2 shares, …`.
fn join(
    rows: &[u8],
    share: usize,
    shares: usize,
    corners: &Corners,
    task: &Task<'_>,
) -> Result<Pages<f32>, Stop> {
    // A closed surface has half as many vertices as triangles.
    let vertices = corners.len() / 2 / shares;
    let mut joiner = Joiner::with_room(vertices + vertices / 32)?;
    for (at, (row, numbers)) in rows.chunks_exact(STL_TRIANGLE).zip(corners).enumerate() {
        if at % TRIANGLES == 0 {
            task.go_on()?;
            joiner.check(task)?;
        }
        for (corner, number) in numbers.iter().enumerate() {
            let place = NORMAL + 12 * corner;
            let point = [0, 4, 8].map(|axis| float(row, place + axis));
            if share_of(point, shares) != share {
                continue;
            }
            if !point.into_iter().all(|value| is_coordinate(value.into())) {
                return Err(no_point(point, STL_HEADER + STL_TRIANGLE * at + place));
            }
            let found = joiner
                .number(point)?
                .checked_mul(u32::try_from(shares).unwrap_or(1));
            let found = found.and_then(|found| found.checked_add(u32::try_from(share).ok()?));
            let most = MOST_VERTICES / shares;
            let found = found.ok_or(Stop::TooMany {
                what: "vertices",
                most,
            })?;
            // Read after all threads have ended, so no order is asked for.
            number.store(found, Ordering::Relaxed);
        }
    }
    Ok(joiner.into_points())
}

/// The share that a corner belongs to, of a power of two of them.
#[inline]
fn share_of(point: [f32; 3], shares: usize) -> usize {
    /// Odd numbers without a pattern (of π).
    const MIX: [u64; 2] = [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7345];
    let [x, y, z] = point.map(Coordinate::bits);
    let hash = folded(x ^ MIX[0], (y | z << 32) ^ MIX[1]);
    usize::try_from(hash >> 32).unwrap_or(0) & (shares - 1)
}

/// The fault of a corner that stands at a byte.
fn no_point(point: [f32; 3], at: usize) -> Stop {
    let values = point.into_iter().map(f64::from).zip(0..);
    let mut wrong = values.filter(|(value, _)| !is_coordinate(*value));
    let (value, place) = wrong.next().unwrap_or_default();
    no_coordinate(at + 4 * place, value)
}

/// What all threads made, or the fault that stands first in the file.
fn all_or_first<T>(made: Vec<Result<T, Stop>>) -> Result<Vec<T>, Stop> {
    let place = |stop: &Stop| match stop {
        Stop::Fault { at, .. } => *at,
        _ => 0,
    };
    let mut all = Vec::with_capacity(made.len());
    let mut first: Option<Stop> = None;
    for made in made {
        match made {
            Ok(made) => all.push(made),
            Err(stop)
                if first
                    .as_ref()
                    .is_none_or(|first| place(&stop) < place(first)) =>
            {
                first = Some(stop)
            }
            Err(_) => {}
        }
    }
    first.map_or(Ok(all), Err)
}

/// Numbers the vertices as they first come in the file, so that nothing tells how many threads there were.
fn number(mut corners: Corners, shares: &[Pages<f32>], task: &Task<'_>) -> Result<Surface, Stop> {
    let count = shares.iter().map(Pages::len).sum();
    task.check_vertices(count)?;
    let mut points = with_room(count)?;
    let mut numbers: Vec<Vec<u32>> = Vec::with_capacity(shares.len());
    for share in shares {
        let mut none = with_room(share.len())?;
        none.resize(share.len(), NONE);
        numbers.push(none);
    }
    let bits = shares.len().ilog2();
    for corners in corners.chunks_mut(TRIANGLES) {
        task.go_on()?;
        for corner in corners.as_flattened_mut() {
            let corner = corner.get_mut();
            let share = *corner as usize & (shares.len() - 1);
            let place = (*corner >> bits) as usize;
            let number = &mut numbers[share][place];
            if *number == NONE {
                *number = u32::try_from(points.len()).unwrap_or(NONE);
                points.push(shares[share].get(place));
            }
            *corner = *number;
        }
    }
    drop(numbers);
    // In place.
    let triangles = corners
        .into_iter()
        .map(|corners| corners.map(AtomicU32::into_inner));
    Ok(Surface {
        mesh: mesh(points, triangles.collect()),
        ..Surface::default()
    })
}

/// The number at a place.
#[inline]
fn float(row: &[u8], at: usize) -> f32 {
    let bytes = row.get(at..).and_then(<[u8]>::first_chunk);
    f32::from_le_bytes(bytes.copied().unwrap_or_default())
}
