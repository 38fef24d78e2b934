//! Rows from value to value: any element, text or bytes.

use super::colours::Channels;
use super::header::{Element, Number, Property};
use super::{Coordinate, Stop, Task, same_size};
use crate::mesh::paint::VertexColour;
use crate::mesh::read::cursor::Cursor;
use crate::mesh::read::points::{is_coordinate, no_coordinate};
use crate::mesh::read::{numerals, with_room, zeroed};

/// Rows between two looks at whether to go on.
const ROWS: usize = 1 << 14;

/// Where values come from.
pub(super) trait Source {
    /// Where the next value stands.
    fn at(&self) -> usize;
    /// The next value; all types fit into a double.
    fn value(&mut self, number: Number) -> Result<f64, Stop>;
    /// Passes over so many values.
    fn skip(&mut self, number: Number, count: usize, task: &Task<'_>) -> Result<(), Stop>;
    /// That the file is long enough for what an element announces.
    fn check_room(&self, element: &Element) -> Result<(), Stop>;
    /// All vertices at once, where they are rows of one size without fault.
    fn same_size_points<C: Coordinate>(
        &mut self,
        element: &Element,
        axes: [usize; 3],
        task: &Task<'_>,
    ) -> Result<Option<Vertices<C>>, Stop>;
    /// All faces at once, where they are triangles in rows of one size without fault.
    fn same_size_faces(
        &mut self,
        element: &Element,
        list: usize,
        vertices: usize,
        task: &Task<'_>,
    ) -> Result<Option<Vec<[u32; 3]>>, Stop>;
}

/// Numbers as bytes.
pub(super) struct Binary<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
}

impl<'a> Binary<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize, is_big: bool) -> Self {
        Self { bytes, at, is_big }
    }

    /// The next so many bytes.
    fn take(&mut self, count: usize) -> Result<&'a [u8], Stop> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        let taken = taken.ok_or_else(|| cut_short(self.bytes.len()))?;
        self.at += count;
        Ok(taken)
    }
}

fn cut_short(at: usize) -> Stop {
    Stop::fault(
        at,
        "is the end, amid a row: the file is cut short, save it again",
    )
}

impl Source for Binary<'_> {
    fn at(&self) -> usize {
        self.at
    }

    #[inline]
    fn value(&mut self, number: Number) -> Result<f64, Stop> {
        let is_big = self.is_big;
        Ok(same_size::value(self.take(number.bytes())?, number, is_big))
    }

    fn skip(&mut self, number: Number, count: usize, _: &Task<'_>) -> Result<(), Stop> {
        self.take(number.bytes().saturating_mul(count)).map(|_| ())
    }

    fn check_room(&self, element: &Element) -> Result<(), Stop> {
        let row: usize = element.properties.iter().map(|it| it.least_bytes()).sum();
        check_room(element, row, self.at, self.bytes.len())
    }

    fn same_size_points<C: Coordinate>(
        &mut self,
        element: &Element,
        axes: [usize; 3],
        task: &Task<'_>,
    ) -> Result<Option<Vertices<C>>, Stop> {
        let rows = same_size::Rows::new(self.bytes, self.at, element, None, self.is_big);
        let Some(rows) = rows else { return Ok(None) };
        let vertices = rows.vertices(axes, task)?;
        if vertices.is_some() {
            self.at = rows.end();
        }
        Ok(vertices)
    }

    fn same_size_faces(
        &mut self,
        element: &Element,
        list: usize,
        vertices: usize,
        task: &Task<'_>,
    ) -> Result<Option<Vec<[u32; 3]>>, Stop> {
        task.check_triangles(element.rows)?;
        let rows = same_size::Rows::new(self.bytes, self.at, element, Some(list), self.is_big);
        let Some(rows) = rows else { return Ok(None) };
        let triangles = rows.triangles(list, vertices, task)?;
        if triangles.is_some() {
            self.at = rows.end();
        }
        Ok(triangles)
    }
}

/// Numbers as text, parted by blanks. That rows stand on lines of their own is not asked for.
pub(super) struct Text<'a>(Cursor<'a>);

impl<'a> Text<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self(Cursor::new(bytes, at))
    }
}

impl Source for Text<'_> {
    fn at(&self) -> usize {
        self.0.at
    }

    #[inline]
    fn value(&mut self, _: Number) -> Result<f64, Stop> {
        self.0.skip_space();
        if let Some(value) = self.0.number() {
            return Ok(value);
        }
        if self.0.peek().is_none() {
            return Err(cut_short(self.0.bytes.len()));
        }
        let problem = format!(
            "has {} where a number stands: save the file again",
            self.0.shown()
        );
        Err(Stop::fault(self.0.at, problem))
    }

    fn skip(&mut self, _: Number, count: usize, task: &Task<'_>) -> Result<(), Stop> {
        for skipped in 0..count {
            if skipped % ROWS == 0 {
                task.go_on()?;
            }
            self.0.skip_space();
            if self.0.word().is_empty() {
                return Err(cut_short(self.0.bytes.len()));
            }
        }
        Ok(())
    }

    fn check_room(&self, element: &Element) -> Result<(), Stop> {
        // A digit and a blank each; the last may end the file.
        let row = element.properties.len() * 2;
        check_room(element, row, self.0.at, self.0.bytes.len() + 1)
    }

    fn same_size_points<C: Coordinate>(
        &mut self,
        element: &Element,
        axes: [usize; 3],
        task: &Task<'_>,
    ) -> Result<Option<Vertices<C>>, Stop> {
        let columns = element.properties.len();
        let is_list = |property: &Property| matches!(property, Property::List { .. });
        if element.properties.iter().any(is_list) {
            return Ok(None);
        }
        let mut points: Vec<[C; 3]> = zeroed(element.rows)?;
        let mut axis_of = vec![None; columns];
        for (axis, &column) in axes.iter().enumerate() {
            axis_of[column] = Some(axis);
        }
        let channels = Channels::of(element);
        let mut colours = with_room(channels.map_or(0, |_| element.rows))?;
        let mut channel_of = vec![None; columns];
        for (channel, place) in channels.iter().flat_map(|it| it.places).enumerate() {
            if let Some(column) = place {
                channel_of[column] = Some(channel);
            }
        }
        let mut colour = [0.0; 4];
        let (text, at) = (self.0.bytes, self.0.at);
        let count = element.rows.saturating_mul(columns);
        let end = numerals::each(text, at, count, task, |from, values: &[C]| {
            let mut row = from / columns;
            let mut column = from % columns;
            for &value in values {
                if let Some(axis) = axis_of[column] {
                    points[row][axis] = value;
                }
                if let Some(channel) = channel_of[column] {
                    colour[channel] = value.into();
                }
                column += 1;
                if column == columns {
                    colours.extend(channels.map(|channels| channels.colour(colour)));
                    column = 0;
                    row += 1;
                }
            }
            Ok(())
        });
        let end = self.or_slowly(end)?;
        Ok(end.map(|()| Vertices { points, colours }))
    }

    fn same_size_faces(
        &mut self,
        element: &Element,
        _: usize,
        vertices: usize,
        task: &Task<'_>,
    ) -> Result<Option<Vec<[u32; 3]>>, Stop> {
        let [Property::List { .. }] = element.properties[..] else {
            return Ok(None);
        };
        task.check_triangles(element.rows)?;
        // A triangle is the number 3, then three vertices.
        let count = element.rows.saturating_mul(4);
        // A digit and a blank each; the last may end the file.
        if count.saturating_mul(2) > self.0.bytes.len() - self.0.at + 1 {
            return Ok(None);
        }
        let mut triangles: Vec<[u32; 3]> = zeroed(element.rows)?;
        let (text, at) = (self.0.bytes, self.0.at);
        let end = numerals::each(text, at, count, task, |from, values: &[u32]| {
            for (place, &value) in (from..).zip(values) {
                let is_good = match place % 4 {
                    0 => value == 3,
                    corner => {
                        triangles[place / 4][corner - 1] = value;
                        (value as usize) < vertices
                    }
                };
                if !is_good {
                    return Err(Stop::fault(at, "has other faces than triangles"));
                }
            }
            Ok(())
        });
        Ok(self.or_slowly(end)?.map(|()| triangles))
    }
}

impl Text<'_> {
    /// Goes on where numbers that were read end. Where one of them was none it stays, so that they are gone through value by value.
    fn or_slowly(&mut self, end: Result<usize, Stop>) -> Result<Option<()>, Stop> {
        match end {
            Ok(end) => self.0.at = end,
            Err(Stop::Fault { .. }) => return Ok(None),
            Err(other) => return Err(other),
        }
        Ok(Some(()))
    }
}

/// That rows of so many bytes at least fit between two places.
fn check_room(element: &Element, row: usize, from: usize, to: usize) -> Result<(), Stop> {
    let needed = element.rows.saturating_mul(row);
    let left = to.saturating_sub(from);
    if needed > left {
        let problem = format!(
            "is where {} rows of {} follow, as the header says, which take {needed} bytes or more, but {left} are left: the file is cut short, save it again",
            element.rows, element.name
        );
        return Err(Stop::fault(from, problem));
    }
    Ok(())
}

/// Vertices, and colours where they have any.
pub(super) struct Vertices<C> {
    pub(super) points: Vec<[C; 3]>,
    pub(super) colours: Vec<VertexColour>,
}

impl<C> Default for Vertices<C> {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            colours: Vec::new(),
        }
    }
}

/// Reads the vertices.
pub(super) fn points<C: Coordinate>(
    source: &mut impl Source,
    element: &Element,
    axes: [usize; 3],
    task: &Task<'_>,
) -> Result<Vertices<C>, Stop> {
    let mut points = with_room(element.rows)?;
    let channels = Channels::of(element);
    let mut colours = with_room(channels.map_or(0, |_| element.rows))?;
    for row in 0..element.rows {
        if row % ROWS == 0 {
            task.go_on()?;
        }
        let mut point = [C::default(); 3];
        let mut colour = [0.0; 4];
        for (place, &property) in element.properties.iter().enumerate() {
            let Property::Scalar(number) = property else {
                skip_property(source, property, task)?;
                continue;
            };
            let at = source.at();
            let value = source.value(number)?;
            for (coordinate, &axis) in point.iter_mut().zip(&axes) {
                if axis == place {
                    if !is_coordinate(value) {
                        return Err(no_coordinate(at, value));
                    }
                    *coordinate = C::nearest(value);
                }
            }
            for (to, from) in colour
                .iter_mut()
                .zip(channels.iter().flat_map(|it| it.places))
            {
                if from == Some(place) {
                    *to = value;
                }
            }
        }
        points.push(point);
        colours.extend(channels.map(|channels| channels.colour(colour)));
    }
    Ok(Vertices { points, colours })
}

/// Triangles, and how many faces were none.
#[derive(Default)]
pub(super) struct Faces {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) skipped: usize,
}

/// Reads the faces, polygons as fans.
pub(super) fn faces(
    source: &mut impl Source,
    element: &Element,
    list: usize,
    vertices: usize,
    task: &Task<'_>,
) -> Result<Faces, Stop> {
    let mut faces = Faces {
        triangles: with_room(element.rows.min(task.limits.triangles))?,
        skipped: 0,
    };
    for row in 0..element.rows {
        if row % ROWS == 0 {
            task.go_on()?;
        }
        for (place, &property) in element.properties.iter().enumerate() {
            match property {
                Property::List { count, item } if place == list => {
                    let corners = whole(source, count, "the number of a face's vertices")?;
                    fan(source, corners, item, vertices, &mut faces, task)?;
                }
                other => skip_property(source, other, task)?,
            }
        }
    }
    Ok(faces)
}

/// Reads a polygon and cuts it into triangles from its first vertex.
fn fan(
    source: &mut impl Source,
    corners: u32,
    item: Number,
    vertices: usize,
    faces: &mut Faces,
    task: &Task<'_>,
) -> Result<(), Stop> {
    let mut first = 0;
    let mut last = 0;
    for corner in 0..corners {
        let at = source.at();
        let vertex = whole(source, item, "the number of a vertex")?;
        if vertex as usize >= vertices {
            let problem = format!(
                "names the vertex {vertex}, but there are {vertices}, counted from 0: mend or remove the face"
            );
            return Err(Stop::fault(at, problem));
        }
        match corner {
            0 => first = vertex,
            1 => {}
            _ => faces.triangles.push([first, last, vertex]),
        }
        last = vertex;
        if faces.triangles.len().is_multiple_of(ROWS) {
            task.go_on()?;
            task.check_triangles(faces.triangles.len())?;
        }
    }
    faces.skipped += usize::from(corners < 3);
    task.check_triangles(faces.triangles.len())
}

/// A value that counts something.
#[inline]
fn whole(source: &mut impl Source, number: Number, what: &str) -> Result<u32, Stop> {
    let at = source.at();
    let value = source.value(number)?;
    same_size::whole(value).ok_or_else(|| {
        let problem = format!(
            "has {value} as {what}, which is a whole number from 0 on: mend or remove the face"
        );
        Stop::fault(at, problem)
    })
}

fn skip_property(
    source: &mut impl Source,
    property: Property,
    task: &Task<'_>,
) -> Result<(), Stop> {
    match property {
        Property::Scalar(number) => source.skip(number, 1, task),
        Property::List { count, item } => {
            let count = whole(source, count, "the length of a list")?;
            source.skip(item, count as usize, task)
        }
    }
}

/// Passes over an element of no interest.
pub(super) fn skip(
    source: &mut impl Source,
    element: &Element,
    task: &Task<'_>,
) -> Result<(), Stop> {
    // Rows without properties take no bytes, however many there are.
    if element.properties.is_empty() {
        return Ok(());
    }
    for row in 0..element.rows {
        if row % ROWS == 0 {
            task.go_on()?;
        }
        for &property in &element.properties {
            skip_property(source, property, task)?;
        }
    }
    Ok(())
}
