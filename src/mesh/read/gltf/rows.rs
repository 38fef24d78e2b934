//! Work on rows of numbers by all threads, with a look at whether to go on now and then.
//!
//! Rows with nothing between them, as most files have them, are taken as they stand, without a look at strides and types: then reading
//! costs little more than the copy.

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::super::points::{LARGEST, narrow};
use super::super::{Stop, Task};

/// Rows that a thread takes at once.
const ROWS: usize = 1 << 14;
/// Rows between two looks at whether to go on, shared by all threads.
const SLAB: usize = 1 << 20;
/// What threads make of all rows, a few at a time.
pub(super) fn all_rows<T: Send>(
    rows: usize,
    task: &Task<'_>,
    of_rows: impl Fn(Range<usize>) -> T + Sync,
    unite: impl Fn(T, T) -> T + Sync + Send,
    none: impl Fn() -> T + Sync + Send,
) -> Result<T, Stop> {
    let of_piece = |piece: usize| {
        task.go_on()?;
        let from = piece * ROWS;
        Ok(of_rows(from..rows.min(from + ROWS)))
    };
    if rows <= ROWS {
        return of_piece(0); // without waking anybody
    }
    (0..rows.div_ceil(ROWS))
        .into_par_iter()
        .map(of_piece)
        .try_reduce(&none, |left, right| Ok(unite(left, right)))
}

/// Appends what each row gives.
pub(super) fn extend<T: Send>(
    to: &mut Vec<T>,
    rows: usize,
    task: &Task<'_>,
    of_row: impl Fn(usize) -> T + Sync + Send,
) -> Result<(), Stop> {
    if rows <= ROWS {
        to.extend((0..rows).map(of_row));
        return Ok(());
    }
    for from in (0..rows).step_by(SLAB) {
        task.go_on()?;
        let slab = from..rows.min(from + SLAB);
        to.par_extend(slab.into_par_iter().with_min_len(ROWS).map(&of_row));
    }
    Ok(())
}

/// Appends what each row gives, where rows are so many bytes with nothing between them: many times as fast.
pub(super) fn extend_packed<const BYTES: usize, T: Send>(
    to: &mut Vec<T>,
    rows: &[u8],
    task: &Task<'_>,
    of_row: impl Fn(&[u8; BYTES]) -> T + Sync + Send,
) -> Result<(), Stop> {
    let (rows, _) = rows.as_chunks::<BYTES>();
    if rows.len() <= ROWS {
        to.extend(rows.iter().map(of_row));
        return Ok(());
    }
    for slab in rows.chunks(SLAB) {
        task.go_on()?;
        to.par_extend(slab.par_iter().with_min_len(ROWS).map(&of_row));
    }
    Ok(())
}

/// Numbers that stand one after the other.
#[inline]
pub(super) fn words<const COUNT: usize, T>(bytes: &[u8], of: impl Fn([u8; 4]) -> T) -> [T; COUNT] {
    std::array::from_fn(|at| {
        let word = bytes.get(4 * at..).and_then(<[u8]>::first_chunk);
        of(word.copied().unwrap_or_default())
    })
}

/// The largest of numbers that stand one after the other.
pub(super) fn largest_packed(bytes: &[u8], task: &Task<'_>) -> Result<u32, Stop> {
    let (words, _) = bytes.as_chunks::<4>();
    let of_rows = |rows: Range<usize>| {
        let words = words.get(rows).unwrap_or_default().iter();
        words.fold(0, |largest, word| largest.max(u32::from_le_bytes(*word)))
    };
    all_rows(words.len(), task, of_rows, u32::max, || 0)
}

/// Two corners of a box; None where a coordinate is none.
pub(super) type Box3 = Option<(DVec3, DVec3)>;

/// The box of positions in single precision, one after the other; four of them at a time, so that a processor does so, too.
pub(super) fn packed_bounds(bytes: &[u8]) -> Box3 {
    const LANES: usize = 12;
    let limit = narrow(LARGEST);
    let (mut least, mut most) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    let mut all = true;
    let (fours, rest) = bytes.as_chunks::<{ 4 * LANES }>();
    let mut take = |values: [f32; LANES]| {
        let mut is_good = true;
        for (lane, value) in values.into_iter().enumerate() {
            is_good &= value.abs() <= limit;
            least[lane] = if value < least[lane] {
                value
            } else {
                least[lane]
            };
            most[lane] = if value > most[lane] {
                value
            } else {
                most[lane]
            };
        }
        all &= is_good;
    };
    for four in fours {
        take(words(four, f32::from_le_bytes));
    }
    let (rest, _) = rest.as_chunks::<12>();
    for row in rest {
        let [x, y, z] = words(row, f32::from_le_bytes);
        take([x, y, z, x, y, z, x, y, z, x, y, z]);
    }
    let corner = |lanes: [f32; LANES], of: fn(DVec3, DVec3) -> DVec3| {
        let (points, _) = lanes.as_chunks::<3>();
        points
            .iter()
            .map(|point| Vec3::from(*point).as_dvec3())
            .reduce(of)
    };
    let corners = corner(least, DVec3::min).zip(corner(most, DVec3::max));
    corners.filter(|_| all)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn boxes_are_those_of_a_plain_loop(points in prop::collection::vec(prop::array::uniform3(-1e16_f32..1e16), 0..50), scale in prop::sample::select(&[1e-20_f32, 1.0][..])) {
            let points: Vec<[f32; 3]> = points.iter().map(|point| point.map(|value| value * scale)).collect();
            let bytes: Vec<u8> = points.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
            let all = points.iter().map(|point| Vec3::from(*point).as_dvec3());
            let is_good = all.clone().all(|point| point.abs().max_element() <= LARGEST);
            let least = all.clone().fold(DVec3::INFINITY, DVec3::min);
            let most = all.fold(DVec3::NEG_INFINITY, DVec3::max);
            prop_assert_eq!(packed_bounds(&bytes), is_good.then_some((least, most)));
        }
    }

    #[test]
    fn what_is_no_number_has_no_box() {
        for place in 0..15 {
            let mut values = [1.0_f32; 15];
            values[place] = f32::NAN;
            let bytes: Vec<u8> = values
                .iter()
                .flat_map(|value| value.to_le_bytes())
                .collect();
            assert_eq!(packed_bounds(&bytes), None, "{place}");
        }
    }
}
