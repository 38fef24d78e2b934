//! Rows of one size in a binary file, on all cores: vertices, and faces that are all triangles.
//!
//! What nearly all files hold, coordinates in single precision side by side and corners of four bytes, has loops of its own. *Tried*: all
//! types by one loop, which made each number a double and asked again of each which type it is: most of the time that such a file took.
//!
//! Whoever calls goes through the same rows value by value where this gives nothing, so nothing is said here of what is wrong.

use std::ops::Range;

use super::colours::Channels;
use super::header::{Element, Number, Property};
use super::rows::Vertices;
use super::{Coordinate, Stop, Task};
use crate::mesh::read::made;
use crate::mesh::read::points::is_coordinate;

/// The number of which the bytes are these, as many as its type has.
#[inline]
pub(super) fn value(bytes: &[u8], number: Number, is_big: bool) -> f64 {
    /// The first bytes, zeros where there are none.
    fn first<const COUNT: usize>(bytes: &[u8], is_big: bool) -> [u8; COUNT] {
        let mut first: [u8; COUNT] = bytes.first_chunk().copied().unwrap_or([0; COUNT]);
        if is_big {
            first.reverse();
        }
        first
    }
    match number {
        Number::I8 => i8::from_le_bytes(first(bytes, is_big)).into(),
        Number::U8 => u8::from_le_bytes(first(bytes, is_big)).into(),
        Number::I16 => i16::from_le_bytes(first(bytes, is_big)).into(),
        Number::U16 => u16::from_le_bytes(first(bytes, is_big)).into(),
        Number::I32 => i32::from_le_bytes(first(bytes, is_big)).into(),
        Number::U32 => u32::from_le_bytes(first(bytes, is_big)).into(),
        Number::F32 => f32::from_le_bytes(first(bytes, is_big)).into(),
        Number::F64 => f64::from_le_bytes(first(bytes, is_big)),
    }
}

/// Three numbers of four bytes that stand one behind the other.
#[inline]
fn three(bytes: &[u8], is_big: bool) -> Option<[u32; 3]> {
    let (numbers, _) = bytes.first_chunk::<12>()?.as_chunks::<4>();
    let &[a, b, c] = numbers.first_chunk()?;
    Some([a, b, c].map(|number| match is_big {
        true => u32::from_be_bytes(number),
        false => u32::from_le_bytes(number),
    }))
}

/// A value as a whole number.
#[inline]
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "only values in range are cast"
)]
pub(super) fn whole(value: f64) -> Option<u32> {
    let is_whole = (0.0..=f64::from(u32::MAX)).contains(&value) && value.fract() == 0.0;
    is_whole.then_some(value as u32)
}

/// Rows of one size.
pub(super) struct Rows<'a> {
    bytes: &'a [u8],
    range: Range<usize>,
    row: usize,
    element: &'a Element,
    /// Where each property begins in a row.
    places: Vec<usize>,
    is_big: bool,
}

impl<'a> Rows<'a> {
    /// The rows of an element that has no list, or only the one that is named, of three items in each row; none where it has others or
    /// the file is too short.
    pub(super) fn new(
        bytes: &'a [u8],
        at: usize,
        element: &'a Element,
        list: Option<usize>,
        is_big: bool,
    ) -> Option<Self> {
        let mut row = 0;
        let mut places = Vec::with_capacity(element.properties.len());
        for (place, property) in element.properties.iter().enumerate() {
            places.push(row);
            row += match *property {
                Property::Scalar(number) => number.bytes(),
                Property::List { count, item } if list == Some(place) => {
                    count.bytes() + 3 * item.bytes()
                }
                Property::List { .. } => return None,
            };
        }
        let end = at.checked_add(row.checked_mul(element.rows)?)?;
        bytes.get(at..end).filter(|_| row > 0)?;
        Some(Self {
            bytes,
            range: at..end,
            row,
            element,
            places,
            is_big,
        })
    }

    /// Where they end.
    pub(super) fn end(&self) -> usize {
        self.range.end
    }

    /// The vertices and their colours, unless a coordinate is none.
    pub(super) fn vertices<C: Coordinate>(
        &self,
        axes: [usize; 3],
        task: &Task<'_>,
    ) -> Result<Option<Vertices<C>>, Stop> {
        let Some(points) = self.points(axes, task)? else {
            return Ok(None);
        };
        let Some(channels) = Channels::of(self.element) else {
            let colours = Vec::new();
            return Ok(Some(Vertices { points, colours }));
        };
        let columns = channels.places.map(|place| {
            let place = place?;
            match self.element.properties.get(place)? {
                Property::Scalar(number) => Some((*self.places.get(place)?, *number)),
                Property::List { .. } => None,
            }
        });
        let colours = self.each(task, |row| {
            let values = columns.map(|column| {
                let (place, number) = column?;
                Some(value(row.get(place..)?, number, self.is_big))
            });
            Some(channels.colour(values.map(Option::unwrap_or_default)))
        })?;
        Ok(colours.map(|colours| Vertices { points, colours }))
    }

    /// The positions, unless a coordinate is none.
    fn points<C: Coordinate>(
        &self,
        axes: [usize; 3],
        task: &Task<'_>,
    ) -> Result<Option<Vec<[C; 3]>>, Stop> {
        let mut columns = [(0, Number::F32); 3];
        for (column, axis) in columns.iter_mut().zip(axes) {
            let Property::Scalar(number) = self.element.properties[axis] else {
                return Ok(None);
            };
            *column = (self.places[axis], number);
        }
        let [(first, number), ..] = columns;
        let is_packed = columns == [0, 1, 2].map(|axis| (first + axis * number.bytes(), number));
        match number {
            Number::F32 if is_packed => self.each(task, |row| {
                let point = three(row.get(first..)?, self.is_big)?.map(f32::from_bits);
                let point = point.map(f64::from);
                let is_good = point.into_iter().all(is_coordinate);
                is_good.then(|| point.map(C::nearest))
            }),
            _ => self.each(task, |row| {
                let point =
                    columns.map(|(place, number)| value(&row[place..], number, self.is_big));
                let is_good = point.into_iter().all(is_coordinate);
                is_good.then(|| point.map(C::nearest))
            }),
        }
    }

    /// The triangles, unless a face is none or names a vertex that is not there.
    pub(super) fn triangles(
        &self,
        list: usize,
        vertices: usize,
        task: &Task<'_>,
    ) -> Result<Option<Vec<[u32; 3]>>, Stop> {
        let Property::List { count, item } = self.element.properties[list] else {
            return Ok(None);
        };
        let items = self.places[list] + count.bytes();
        let columns = [0, 1, 2].map(|corner| items + corner * item.bytes());
        // Nearly all files: numbers of four bytes, which a negative one is beyond.
        let is_usual =
            matches!(count, Number::I8 | Number::U8) && matches!(item, Number::I32 | Number::U32);
        if is_usual && let Ok(1..) = i32::try_from(vertices) {
            let at = self.places[list];
            return self.each(task, |row| {
                let (count, row) = row.get(at..)?.split_first()?;
                let corners = three(row, self.is_big)?;
                let is_good = *count == 3 && corners.iter().all(|&it| (it as usize) < vertices);
                is_good.then_some(corners)
            });
        }
        self.each(task, |row| {
            if value(&row[self.places[list]..], count, self.is_big) != 3.0 {
                return None;
            }
            let corners = columns.map(|place| whole(value(&row[place..], item, self.is_big)));
            let [Some(a), Some(b), Some(c)] = corners else {
                return None;
            };
            let is_good = [a, b, c].iter().all(|&corner| (corner as usize) < vertices);
            is_good.then_some([a, b, c])
        })
    }

    /// What each row gives, unless one gives nothing.
    fn each<T: Copy + Default + Send>(
        &self,
        task: &Task<'_>,
        of_row: impl Fn(&[u8]) -> Option<T> + Sync,
    ) -> Result<Option<Vec<T>>, Stop> {
        let bytes = &self.bytes[self.range.clone()];
        let made = made::rows(self.element.rows, task, |first, to| {
            let rows = bytes.get(first * self.row..).unwrap_or_default();
            for (to, row) in to.iter_mut().zip(rows.chunks_exact(self.row)) {
                // What is wrong is told by whoever goes through the rows again.
                *to = of_row(row).ok_or_else(|| Stop::fault(first, ""))?;
            }
            Ok(())
        });
        match made {
            Ok(made) => Ok(Some(made)),
            Err(Stop::Fault { .. }) => Ok(None),
            Err(stop) => Err(stop),
        }
    }
}
