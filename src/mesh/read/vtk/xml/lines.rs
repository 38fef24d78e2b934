//! Lines with radii: centerlines as VMTK and 3D Slicer save them, whole or cut into tracts.

use std::collections::BTreeMap;

use glam::Vec3;

use super::super::super::{Stop, Task, zeroed};
use super::super::cells::points_of;
use super::array::Arrays;
use super::document::{Array, Document, Piece};
use crate::tree::{Tree, import};

/// Whether there are lines, all of them with radii.
pub(super) fn have_radii(document: &Document) -> bool {
    let pieces = document.pieces.iter();
    let mut with_lines = pieces.filter(|piece| piece.lines.count > 0).peekable();
    with_lines.peek().is_some() && with_lines.all(|piece| piece.radii.is_some())
}

/// Reads lines and joins them; `points` are those of all pieces.
pub(super) fn skeleton(
    arrays: &mut Arrays<'_>,
    document: &Document,
    points: &[Vec3],
    task: &Task<'_>,
) -> Result<Tree, Stop> {
    let mut radii = zeroed::<f32>(points.len())?;
    let mut lines: Vec<Vec<u32>> = Vec::new();
    let mut before = 0;
    for piece in &document.pieces {
        task.go_on()?;
        let end = before + piece.point_count;
        if let (Some((_, array)), Some(to)) = (piece.radii, radii.get_mut(before..end)) {
            read_radii(arrays, &array, to, task)?;
        }
        let found = lines_of(arrays, piece, before, task)?;
        lines.extend(joined(found, parts(arrays, piece, task)?, points));
        before = end;
    }
    import::lines(points, &radii, &lines).map_err(Stop::Skeleton)
}

fn read_radii(
    arrays: &mut Arrays<'_>,
    array: &Array,
    to: &mut [f32],
    task: &Task<'_>,
) -> Result<(), Stop> {
    if array.components != 1 {
        let problem = format!(
            "begins an array of radii with {} components, and they have one: save the file again",
            array.components
        );
        return Err(Stop::fault(array.at, problem));
    }
    arrays.find(array, to.len())?.read(to, task)?;
    if let Some(radius) = to.iter().find(|radius| **radius < 0.0) {
        let problem = format!("begins an array with the radius {radius}: give 0 or more");
        return Err(Stop::fault(array.at, problem));
    }
    Ok(())
}

/// The points of each line, counted from those of all pieces.
fn lines_of(
    arrays: &mut Arrays<'_>,
    piece: &Piece,
    before: usize,
    task: &Task<'_>,
) -> Result<Vec<Vec<u32>>, Stop> {
    let cells = &piece.lines;
    if cells.count == 0 {
        return Ok(Vec::new());
    }
    let (Some(ends), Some(of_lines)) = (&cells.ends, &cells.points) else {
        let problem = format!(
            "begins a piece that announces {} lines and has not both their arrays, connectivity and offsets: save the file again",
            cells.count
        );
        return Err(Stop::fault(cells.at, problem));
    };
    let end_of = whole(arrays, ends, cells.count, task)?;
    let count = points_of(ends.at, &end_of)?;
    let mut numbers = whole(arrays, of_lines, count, task)?;
    if let Some(point) = numbers
        .iter()
        .find(|point| **point as usize >= piece.point_count)
    {
        let problem = format!(
            "begins a list of lines that names the point {point}, but there are {}, counted from 0: mend or remove the line",
            piece.point_count
        );
        return Err(Stop::fault(of_lines.at, problem));
    }
    // All points together have numbers of 32 bits.
    let before = u32::try_from(before).unwrap_or(u32::MAX);
    numbers.iter_mut().for_each(|number| *number += before);
    let mut from = 0;
    let lines = end_of.iter().map(|end| {
        let line = numbers
            .get(from..*end as usize)
            .unwrap_or_default()
            .to_vec();
        from = *end as usize;
        line
    });
    Ok(lines.collect())
}

/// For each line of a piece, which centerline it is a part of, and which part; None where the file does not say.
fn parts(
    arrays: &mut Arrays<'_>,
    piece: &Piece,
    task: &Task<'_>,
) -> Result<Option<Vec<[u32; 2]>>, Stop> {
    let [Some(centerlines), Some(tracts)] = &piece.parts else {
        return Ok(None);
    };
    // Data of cells begin with those of points.
    let cells = piece.vertices.saturating_add(piece.lines.count);
    let mut both = Vec::new();
    for array in [centerlines, tracts] {
        both.push(whole(arrays, array, cells, task)?);
    }
    let pairs = both[0].iter().zip(&both[1]).skip(piece.vertices);
    Ok(Some(pairs.map(|(one, other)| [*one, *other]).collect()))
}

fn whole(
    arrays: &mut Arrays<'_>,
    array: &Array,
    count: usize,
    task: &Task<'_>,
) -> Result<Vec<u32>, Stop> {
    if !array.kind.is_whole() {
        let problem = "begins an array of lines that are no whole numbers: save the file again";
        return Err(Stop::fault(array.at, problem));
    }
    let stored = arrays.find(array, count)?;
    let mut numbers = zeroed::<u32>(count)?;
    stored.read(&mut numbers, task)?;
    Ok(numbers)
}

/// Tracts of a centerline made one line again, where each begins at the point that the last ended in.
fn joined(lines: Vec<Vec<u32>>, parts: Option<Vec<[u32; 2]>>, points: &[Vec3]) -> Vec<Vec<u32>> {
    let Some(parts) = parts else {
        return lines;
    };
    let ordered: BTreeMap<([u32; 2], usize), Vec<u32>> = parts
        .into_iter()
        .enumerate()
        .map(|(place, part)| (part, place))
        .zip(lines)
        .collect();
    let mut joined: Vec<(u32, Vec<u32>)> = Vec::new();
    for (([centerline, _], _), line) in ordered {
        let place = |number: Option<&u32>| number.and_then(|at| points.get(*at as usize));
        match joined.last_mut() {
            Some((other, whole))
                if *other == centerline && place(whole.last()) == place(line.first()) =>
            {
                whole.extend(line.into_iter().skip(1));
            }
            _ => joined.push((centerline, line)),
        }
    }
    joined.into_iter().map(|(_, line)| line).collect()
}
