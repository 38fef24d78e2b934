//! Cells as lists of point numbers, made triangles: polygons as fans from their first point, strips triangle by triangle.

use rayon::prelude::*;

use super::super::{Stop, Task, made, zeroed};
use super::number::{NUMBERS, Plain};

/// Cells, or corners of one, between two looks at whether to go on.
const CELLS: usize = 1 << 14;

/// What the points of a cell are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Polygon,
    Strip,
}

/// Triangles of which the points are counted from those of a piece.
pub(super) struct Triangles<'a> {
    pub(super) made: Vec<[u32; 3]>,
    /// Cells with fewer than three points.
    pub(super) skipped: usize,
    /// Points before the piece.
    pub(super) before: u32,
    /// Points of the piece.
    pub(super) points: u32,
    pub(super) task: &'a Task<'a>,
}

impl<'a> Triangles<'a> {
    pub(super) fn new(task: &'a Task<'a>) -> Self {
        Self {
            made: Vec::new(),
            skipped: 0,
            before: 0,
            points: 0,
            task,
        }
    }

    /// Room for so many more, by the numbers that the file has for their points.
    pub(super) fn reserve(&mut self, count: usize) -> Result<(), Stop> {
        self.task.check_triangles(self.made.len() + count)?;
        let bytes = (count * size_of::<[u32; 3]>()) as u64;
        let given = match self.made.is_empty() {
            true => self.made.try_reserve_exact(count),
            false => self.made.try_reserve(count),
        };
        given.map_err(|_| Stop::Memory(bytes))
    }

    /// Takes so many triangles as they are, each of three points: `fill` gives their numbers within the piece.
    pub(super) fn all(
        &mut self,
        at: usize,
        count: usize,
        fill: impl FnOnce(&mut [u32]) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let from = self.made.len();
        if from == 0 {
            self.task.check_triangles(count)?;
            self.made = zeroed(count)?;
        } else {
            self.reserve(count)?;
            self.made.resize(from + count, [0; 3]);
        }
        let made = self.made[from..].as_flattened_mut();
        fill(made)?;
        let (before, points, task) = (self.before, self.points, self.task);
        made.par_chunks_mut(NUMBERS).try_for_each(|made| {
            task.go_on()?;
            for point in made {
                if *point >= points {
                    return Err(no_point(at, *point, points));
                }
                *point += before;
            }
            Ok(())
        })
    }

    /// Takes so many triangles as they are, as [`all`](Self::all), from numbers that stand in the file: read, checked and counted from the piece in one
    /// pass.
    pub(super) fn plain(&mut self, at: usize, count: usize, from: &Plain<'_>) -> Result<(), Stop> {
        if !self.made.is_empty() {
            let task = self.task;
            return self.all(at, count, |to| from.fill_all(to, task));
        }
        self.task.check_triangles(count)?;
        let (before, points) = (self.before, self.points);
        self.made = made::rows_by(count, self.task, |window, first, to: &mut [[u32; 3]]| {
            let to = to.as_flattened_mut();
            from.fill(window, 3 * first, to)?;
            let most = to.iter().fold(0, |most, point| (*point).max(most));
            if most >= points && !to.is_empty() {
                let wrong = to.iter().find(|point| **point >= points);
                return Err(no_point(at, wrong.copied().unwrap_or(most), points));
            }
            if before > 0 {
                to.iter_mut().for_each(|point| *point += before);
            }
            Ok(())
        })?;
        Ok(())
    }

    /// Cuts a cell into triangles.
    fn cell(&mut self, at: usize, shape: Shape, points: &[u32]) -> Result<(), Stop> {
        if let Some(&wrong) = points.iter().find(|&&point| point >= self.points) {
            return Err(no_point(at, wrong, self.points));
        }
        let before = self.before;
        let [first, rest @ ..] = points else {
            self.skipped += 1;
            return Ok(());
        };
        self.skipped += usize::from(points.len() < 3);
        self.task
            .check_triangles(self.made.len() + rest.len().saturating_sub(1))?;
        match shape {
            Shape::Polygon => {
                let pairs = rest.windows(2);
                let triangles = pairs.map(|pair| [*first, pair[0], pair[1]]);
                self.made
                    .extend(triangles.map(|points| points.map(|point| point + before)));
            }
            Shape::Strip => {
                let threes = points.windows(3).enumerate();
                // Every second one runs the other way.
                let triangles = threes.map(|(place, three)| match place % 2 {
                    0 => [three[0], three[1], three[2]],
                    _ => [three[1], three[0], three[2]],
                });
                self.made
                    .extend(triangles.map(|points| points.map(|point| point + before)));
            }
        }
        Ok(())
    }

    /// Cuts cells, each as long as the number before its points says.
    pub(super) fn counted(
        &mut self,
        at: usize,
        shape: Shape,
        cells: usize,
        mut numbers: &[u32],
    ) -> Result<(), Stop> {
        // Each cell has its own count before it, and two triangles fewer than points.
        let most = numbers.len().saturating_sub(cells.saturating_mul(3));
        self.reserve(most)?;
        for cell in 0..cells {
            if cell % CELLS == 0 {
                self.task.go_on()?;
            }
            let cut = numbers.split_first();
            let cut = cut.and_then(|(&length, rest)| rest.split_at_checked(length as usize));
            let Some((points, rest)) = cut else {
                let problem = format!(
                    "begins a list of cells of which cell {cell} is longer than the list: save the file again"
                );
                return Err(Stop::fault(at, problem));
            };
            self.cell(at, shape, points)?;
            numbers = rest;
        }
        if !numbers.is_empty() {
            let problem = format!(
                "begins a list of {cells} cells that goes on behind the last of them: save the file again"
            );
            return Err(Stop::fault(at, problem));
        }
        Ok(())
    }

    /// Cuts cells of which the ends in the list of points are given.
    pub(super) fn ending(
        &mut self,
        at: usize,
        shape: Shape,
        ends: &[u32],
        points: &[u32],
    ) -> Result<(), Stop> {
        self.reserve(points.len().saturating_sub(ends.len().saturating_mul(2)))?;
        let mut from = 0;
        for (cell, &end) in ends.iter().enumerate() {
            if cell % CELLS == 0 {
                self.task.go_on()?;
            }
            let points = points.get(from..end as usize);
            let Some(points) = points else {
                return Err(no_end(at, cell, end));
            };
            self.cell(at, shape, points)?;
            from = end as usize;
        }
        Ok(())
    }
}

/// Whether all cells are triangles, by their ends.
pub(super) fn are_triangles(ends: &[u32]) -> bool {
    let ends = ends.par_iter().with_min_len(NUMBERS).enumerate();
    ends.all(|(cell, &end)| end as usize == 3 * (cell + 1))
}

/// How many points cells have, by their ends: the last, where they grow.
pub(super) fn points_of(at: usize, ends: &[u32]) -> Result<usize, Stop> {
    let mut pairs = ends.windows(2).enumerate();
    match pairs.find(|(_, pair)| pair[0] > pair[1]) {
        Some((cell, pair)) => Err(no_end(at, cell + 1, pair[1])),
        None => Ok(ends.last().map_or(0, |&end| end as usize)),
    }
}

fn no_end(at: usize, cell: usize, end: u32) -> Stop {
    let problem = format!(
        "begins a list in which cell {cell} ends at {end}, before it begins or behind the last point: save the file again"
    );
    Stop::fault(at, problem)
}

fn no_point(at: usize, point: u32, points: u32) -> Stop {
    let problem = format!(
        "begins a list of cells that names the point {point}, but there are {points}, counted from 0: mend or remove the cell"
    );
    Stop::fault(at, problem)
}
