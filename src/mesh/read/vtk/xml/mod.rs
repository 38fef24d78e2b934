//! VTK XML PolyData: pieces, each with its points and cells in arrays.

mod array;
mod blocks;
mod document;
mod lines;

use std::fs::File;

use super::super::points::{Coordinate, mesh};
use super::super::swc::of_skeleton;
use super::super::{Stop, Surface, Task, zeroed};
use super::cells::{Shape, Triangles, are_triangles, points_of};
use super::number::{Kind, Plain};
use array::Arrays;
use document::{Cells, Document, Piece};

/// Reads a VTP file.
pub(in crate::mesh::read) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let document = document::read(bytes, task)?;
    let points = document.pieces.iter().filter_map(|piece| piece.points);
    if points.clone().any(|array| array.kind.is_wide()) {
        read_as::<f64>(bytes, None, &document, task)
    } else {
        read_as::<f32>(bytes, None, &document, task)
    }
}

/// Reads a VTP file of which only the start is in memory, where that has all but raw arrays behind it; none where it has not.
pub(in crate::mesh::read) fn read_start(
    start: &[u8],
    file: (&File, usize),
    task: &Task<'_>,
) -> Option<Result<Surface, Stop>> {
    let document = document::read(start, task).ok()?;
    document.appended.filter(|appended| !appended.is_base64)?;
    let mut points = document.pieces.iter().filter_map(|piece| piece.points);
    Some(if points.any(|array| array.kind.is_wide()) {
        read_as::<f64>(start, Some(file), &document, task)
    } else {
        read_as::<f32>(start, Some(file), &document, task)
    })
}

fn read_as<C: Coordinate>(
    bytes: &[u8],
    file: Option<(&File, usize)>,
    document: &Document,
    task: &Task<'_>,
) -> Result<Surface, Stop> {
    let mut arrays = Arrays::new(bytes, file, document, task);
    let mut points: Vec<[C; 3]> = Vec::new();
    let mut triangles = Triangles::new(task);
    let mut surface = Surface::default();
    for piece in &document.pieces {
        task.go_on()?;
        triangles.before = u32::try_from(points.len()).unwrap_or(u32::MAX);
        triangles.points = add_points(&mut arrays, piece, &mut points, task)?;
        cells(&mut arrays, &piece.polygons, Shape::Polygon, &mut triangles)?;
        cells(&mut arrays, &piece.strips, Shape::Strip, &mut triangles)?;
        surface.skipped_lines = surface.skipped_lines.saturating_add(piece.lines.count);
        surface.skipped_points = surface.skipped_points.saturating_add(piece.vertices);
    }
    if triangles.made.is_empty() && lines::have_radii(document) {
        let placed = mesh(points, Vec::new());
        let skeleton = lines::skeleton(&mut arrays, document, &placed.positions, task)?;
        return of_skeleton(skeleton, placed.origin, task);
    }
    surface.skipped_faces = triangles.skipped;
    surface.mesh = mesh(points, triangles.made);
    Ok(surface)
}

/// Reads a piece's points and returns how many there are.
fn add_points<C: Coordinate>(
    arrays: &mut Arrays<'_>,
    piece: &Piece,
    points: &mut Vec<[C; 3]>,
    task: &Task<'_>,
) -> Result<u32, Stop> {
    let count = piece.point_count;
    task.check_vertices(points.len().saturating_add(count))?;
    if count == 0 {
        return Ok(0);
    }
    let Some(array) = &piece.points else {
        let problem = format!(
            "begins a piece that announces {count} points and has no array of them: save the file again"
        );
        return Err(Stop::fault(piece.at, problem));
    };
    if array.components != 3 {
        let problem = format!(
            "begins an array of points with {} components, and they have three: save the file again",
            array.components
        );
        return Err(Stop::fault(array.at, problem));
    }
    let stored = arrays.find(array, count.saturating_mul(3))?;
    // Now it is known that the file has them.
    let from = points.len();
    if from == 0
        && let Some(numbers) = stored.as_it_is(3 * count)
    {
        *points = numbers.points(count, task)?;
        return Ok(u32::try_from(count).unwrap_or(u32::MAX));
    }
    if from == 0 {
        *points = zeroed(count)?;
    } else {
        let bytes = (count * size_of::<[C; 3]>()) as u64;
        let given = points.try_reserve(count);
        given.map_err(|_| Stop::Memory(bytes))?;
        points.resize(from + count, [C::default(); 3]);
    }
    stored.read(points[from..].as_flattened_mut(), task)?;
    Ok(u32::try_from(count).unwrap_or(u32::MAX))
}

/// Reads cells of one shape.
fn cells(
    arrays: &mut Arrays<'_>,
    cells: &Cells,
    shape: Shape,
    triangles: &mut Triangles<'_>,
) -> Result<(), Stop> {
    if cells.count == 0 {
        return Ok(());
    }
    let (Some(ends), Some(points)) = (&cells.ends, &cells.points) else {
        let problem = format!(
            "begins a piece that announces {} cells and has not both their arrays, connectivity and offsets: save the file again",
            cells.count
        );
        return Err(Stop::fault(cells.at, problem));
    };
    for array in [ends, points] {
        if !array.kind.is_whole() {
            let problem = "begins an array of cells that are no whole numbers: save the file again";
            return Err(Stop::fault(array.at, problem));
        }
    }
    let task = triangles.task;
    let stored = arrays.find(ends, cells.count)?;
    let are_threes = |ends: Plain<'_>| ends.are_threes(3, cells.count, task);
    if shape == Shape::Polygon && stored.as_it_is(cells.count).is_some_and(are_threes) {
        let stored = arrays.find(points, 3 * cells.count)?;
        return match stored.as_it_is(3 * cells.count) {
            Some(numbers) => triangles.plain(points.at, cells.count, &numbers),
            None => triangles.all(points.at, cells.count, |to| stored.read(to, task)),
        };
    }
    let mut end_of = zeroed::<u32>(cells.count)?;
    stored.read(&mut end_of, task)?;
    let count = points_of(ends.at, &end_of)?;
    let stored = arrays.find(points, count)?;
    if shape == Shape::Polygon && are_triangles(&end_of) {
        drop(end_of);
        return triangles.all(points.at, cells.count, |to| stored.read(to, task));
    }
    let mut point_of = zeroed::<u32>(count)?;
    stored.read(&mut point_of, task)?;
    triangles.ending(points.at, shape, &end_of, &point_of)
}

/// The type of numbers that an array says it has.
fn kind_named(name: &str) -> Option<Kind> {
    Some(match name {
        "Int8" => Kind::I8,
        "UInt8" => Kind::U8,
        "Int16" => Kind::I16,
        "UInt16" => Kind::U16,
        "Int32" => Kind::I32,
        "UInt32" => Kind::U32,
        "Int64" => Kind::I64,
        "UInt64" => Kind::U64,
        "Float32" => Kind::F32,
        "Float64" => Kind::F64,
        _ => return None,
    })
}
