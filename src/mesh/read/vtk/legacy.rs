//! Legacy VTK files, versions 1.0 to 5.1: a title, `ASCII` or `BINARY`, `DATASET POLYDATA`, then sections of points and cells.
//!
//! Cells are lists `n i0 i1 …` up to version 5.0, and since 5.1 two arrays `OFFSETS` and `CONNECTIVITY`; which they are is told by the
//! word that follows, since programs lie about the version. Binary numbers are big-endian.

use super::super::cursor::Cursor;
use super::super::numerals::{self, Value};
use super::super::points::{Coordinate, mesh};
use super::super::stretch::Stretch;
use super::super::{Stop, Surface, Task, zeroed};
use super::cells::{Shape, Triangles, are_triangles, points_of};
use super::number::{Kind, Plain};

/// How the first line begins.
pub(in crate::mesh::read) const MAGIC: &[u8] = b"# vtk DataFile Version";

/// Lines between two looks at whether to go on.
const LINES: usize = 1 << 12;

/// Newest version that is read.
const NEWEST: f64 = 5.1;

/// Reads a legacy VTK file.
pub(in crate::mesh::read) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let mut reader = Reader {
        cursor: Cursor::new(bytes, MAGIC.len()),
        is_text: false,
        task,
    };
    reader.header()?;
    let mut sections = Sections {
        points: Points::Single(Vec::new()),
        triangles: Triangles::new(task),
        surface: Surface::default(),
    };
    while reader.section(&mut sections)? {}
    let Sections {
        points,
        triangles,
        mut surface,
    } = sections;
    surface.skipped_faces = triangles.skipped;
    surface.mesh = match points {
        Points::Single(points) => mesh(points, triangles.made),
        Points::Double(points) => mesh(points, triangles.made),
    };
    Ok(surface)
}

/// What was read so far.
struct Sections<'a> {
    points: Points,
    triangles: Triangles<'a>,
    surface: Surface,
}

/// Points in the file's precision.
enum Points {
    Single(Vec<[f32; 3]>),
    Double(Vec<[f64; 3]>),
}

/// Goes through the file.
struct Reader<'a> {
    cursor: Cursor<'a>,
    is_text: bool,
    task: &'a Task<'a>,
}

/// The type of numbers by its name; identifiers are written as `int`.
fn kind_named(name: &[u8]) -> Option<Kind> {
    Some(match name.to_ascii_lowercase().as_slice() {
        b"char" | b"signed_char" | b"vtktypeint8" => Kind::I8,
        b"unsigned_char" | b"vtktypeuint8" => Kind::U8,
        b"short" | b"vtktypeint16" => Kind::I16,
        b"unsigned_short" | b"vtktypeuint16" => Kind::U16,
        b"int" | b"vtkidtype" | b"vtktypeint32" => Kind::I32,
        b"unsigned_int" | b"vtktypeuint32" => Kind::U32,
        b"long" | b"vtktypeint64" => Kind::I64,
        b"unsigned_long" | b"vtktypeuint64" => Kind::U64,
        b"float" => Kind::F32,
        b"double" => Kind::F64,
        _ => return None,
    })
}

impl<'a> Reader<'a> {
    /// The version, the title, and how numbers are written.
    fn header(&mut self) -> Result<(), Stop> {
        let cursor = &mut self.cursor;
        cursor.skip_blanks();
        let version = cursor.number();
        if !version.is_some_and(|version| (0.0..NEWEST + 0.05).contains(&version)) {
            let problem = format!(
                "names no version from 1.0 to {NEWEST}, which are read: save the file with one of these"
            );
            return Err(Stop::fault(0, problem));
        }
        cursor.skip_line();
        cursor.skip_line(); // the title
        cursor.skip_space();
        let at = cursor.at;
        let word = cursor.word();
        self.is_text = word.eq_ignore_ascii_case(b"ASCII");
        if !self.is_text && !word.eq_ignore_ascii_case(b"BINARY") {
            let problem = "has neither ASCII nor BINARY where that stands, behind the title: save the file again";
            return Err(Stop::fault(at, problem));
        }
        cursor.skip_line();
        cursor.skip_space();
        let at = cursor.at;
        let is_dataset = cursor.word().eq_ignore_ascii_case(b"DATASET");
        cursor.skip_blanks();
        let name = cursor.shown();
        if !is_dataset {
            let problem =
                "has no DATASET where that stands, behind ASCII or BINARY: save the file again";
            return Err(Stop::fault(at, problem));
        }
        if !cursor.word().eq_ignore_ascii_case(b"POLYDATA") {
            let problem = format!(
                "has the dataset {name}, and POLYDATA is read: extract the surface as PolyData (ParaView: Extract Surface) and save that"
            );
            return Err(Stop::fault(at, problem));
        }
        cursor.skip_line();
        Ok(())
    }

    /// Reads a section, and says whether more may follow that are of interest.
    fn section(&mut self, sections: &mut Sections<'_>) -> Result<bool, Stop> {
        self.task.go_on()?;
        self.cursor.skip_space();
        let at = self.cursor.at;
        let shown = self.cursor.shown();
        let word = self.cursor.word();
        match word
            .get(..word.len().min(24))
            .unwrap_or_default()
            .to_ascii_lowercase()
            .as_slice()
        {
            b"" | b"point_data" | b"cell_data" => return Ok(false),
            b"points" => self.points(at, sections)?,
            b"polygons" => self.cells(at, Shape::Polygon, &mut sections.triangles)?,
            b"triangle_strips" => self.cells(at, Shape::Strip, &mut sections.triangles)?,
            b"lines" => {
                let lines = &mut sections.surface.skipped_lines;
                *lines = lines.saturating_add(self.skip_cells(at)?);
            }
            b"vertices" => {
                let points = &mut sections.surface.skipped_points;
                *points = points.saturating_add(self.skip_cells(at)?);
            }
            b"metadata" => self.metadata()?,
            b"field" => self.field(at)?,
            _ => {
                let problem = format!(
                    "has {shown} where a section begins, POINTS, POLYGONS, TRIANGLE_STRIPS, LINES or VERTICES: the file is damaged, save it again"
                );
                return Err(Stop::fault(at, problem));
            }
        }
        Ok(true)
    }

    /// A whole number on the line that began at a byte.
    fn count(&mut self, at: usize) -> Result<usize, Stop> {
        self.cursor.skip_blanks();
        let count = self.cursor.integer();
        count
            .and_then(|count| usize::try_from(count).ok())
            .ok_or_else(|| {
                let problem = format!(
                    "has {} where a number of points or cells stands: save the file again",
                    self.cursor.shown()
                );
                Stop::fault(at, problem)
            })
    }

    /// A type of numbers on the line that began at a byte.
    fn kind(&mut self, at: usize) -> Result<Kind, Stop> {
        self.cursor.skip_blanks();
        let shown = self.cursor.shown();
        kind_named(self.cursor.word()).ok_or_else(|| {
            let problem = format!(
                "has numbers of the type {shown}, and char, short, int, long, their unsigned ones, float and double are read: save the file with these"
            );
            Stop::fault(at, problem)
        })
    }

    /// That so many numbers may stand in the rest of the file.
    fn check_room(&self, at: usize, kind: Kind, count: usize) -> Result<(), Stop> {
        let left = self.cursor.bytes.len().saturating_sub(self.cursor.at);
        // In text a digit and a blank each; the last may end the file.
        let (left, each) = match self.is_text {
            true => (left + 1, 2),
            false => (left, kind.bytes()),
        };
        let needed = count.saturating_mul(each);
        if needed > left {
            let problem = format!(
                "announces {count} numbers, which take {needed} bytes or more, but {left} are left: the file is cut short, save it again"
            );
            return Err(Stop::fault(at, problem));
        }
        Ok(())
    }

    /// Reads numbers, which begin on the next line; there is room for them.
    fn numbers<V: Value>(&mut self, kind: Kind, to: &mut [V]) -> Result<(), Stop> {
        let bytes = self.cursor.bytes;
        self.cursor.skip_line();
        if self.is_text {
            self.cursor.at = numerals::read(bytes, self.cursor.at, to, self.task)?;
            return Ok(());
        }
        let numbers = self.plain(kind, to.len())?;
        numbers.fill_all(to, self.task)?;
        self.cursor.at += to.len() * kind.bytes();
        Ok(())
    }

    /// So many numbers that stand here as bytes.
    fn plain(&self, kind: Kind, count: usize) -> Result<Plain<'a>, Stop> {
        let (bytes, at) = (self.cursor.bytes, self.cursor.at);
        let length = count.saturating_mul(kind.bytes());
        let numbers = bytes.get(at..).and_then(|rest| rest.get(..length));
        let bytes = numbers.ok_or_else(|| {
            let problem = "is the end, amid numbers: the file is cut short, save it again";
            Stop::fault(bytes.len(), problem)
        })?;
        Ok(Plain {
            bytes: Stretch::Read(bytes),
            kind,
            is_big: true,
            at,
            is_placed: true,
        })
    }

    /// Passes over numbers, which begin on the next line.
    fn skip_numbers(&mut self, at: usize, kind: Kind, count: usize) -> Result<(), Stop> {
        self.check_room(at, kind, count)?;
        self.cursor.skip_line();
        let bytes = self.cursor.bytes;
        self.cursor.at = match self.is_text {
            true => numerals::skip(bytes, self.cursor.at, count, self.task)?,
            false => bytes.len().min(
                self.cursor
                    .at
                    .saturating_add(count.saturating_mul(kind.bytes())),
            ),
        };
        Ok(())
    }

    fn points(&mut self, at: usize, sections: &mut Sections<'_>) -> Result<(), Stop> {
        let count = self.count(at)?;
        let kind = self.kind(at)?;
        if sections.triangles.points > 0 {
            let problem = "begins points for a second time: put all into one section";
            return Err(Stop::fault(at, problem));
        }
        self.task.check_vertices(count)?;
        self.check_room(at, kind, count.saturating_mul(3))?;
        sections.triangles.points = u32::try_from(count).unwrap_or(u32::MAX);
        sections.points = match kind.is_wide() {
            true => Points::Double(self.points_as(kind, count)?),
            false => Points::Single(self.points_as(kind, count)?),
        };
        Ok(())
    }

    fn points_as<C: Coordinate>(&mut self, kind: Kind, count: usize) -> Result<Vec<[C; 3]>, Stop> {
        if self.is_text {
            let mut points: Vec<[C; 3]> = zeroed(count)?;
            self.numbers(kind, points.as_flattened_mut())?;
            return Ok(points);
        }
        self.cursor.skip_line();
        let numbers = self.plain(kind, count.saturating_mul(3))?;
        let points = numbers.points(count, self.task)?;
        self.cursor.at += 3 * count * kind.bytes();
        Ok(points)
    }

    /// Whether the next line begins with this word; if so the cursor is behind it.
    fn next_line_is(&mut self, word: &[u8]) -> bool {
        let at = self.cursor.at;
        self.cursor.skip_line();
        self.cursor.skip_space();
        let is_word = self.cursor.word().eq_ignore_ascii_case(word);
        if !is_word {
            self.cursor.at = at;
        }
        is_word
    }

    /// A list of cells, and which layout it has: in the newer one the type of its offsets.
    fn list(&mut self, at: usize) -> Result<([usize; 2], Option<Kind>), Stop> {
        let counts = [self.count(at)?, self.count(at)?];
        let has_offsets = self.next_line_is(b"OFFSETS");
        let kind = has_offsets.then(|| self.kind(at)).transpose()?;
        Ok((counts, kind))
    }

    /// The type of the numbers that follow offsets.
    fn connectivity(&mut self, at: usize) -> Result<Kind, Stop> {
        self.cursor.skip_space();
        let place = self.cursor.at;
        if !self.cursor.word().eq_ignore_ascii_case(b"CONNECTIVITY") {
            let problem =
                "has no CONNECTIVITY where that stands, behind OFFSETS: save the file again";
            return Err(Stop::fault(place, problem));
        }
        self.whole_kind(at)
    }

    /// A type of whole numbers.
    fn whole_kind(&mut self, at: usize) -> Result<Kind, Stop> {
        let kind = self.kind(at)?;
        if !kind.is_whole() {
            let problem = "begins cells that are no whole numbers: save the file again";
            return Err(Stop::fault(at, problem));
        }
        Ok(kind)
    }

    fn cells(
        &mut self,
        at: usize,
        shape: Shape,
        triangles: &mut Triangles<'_>,
    ) -> Result<(), Stop> {
        let ([first, second], offsets) = self.list(at)?;
        let Some(kind) = offsets else {
            self.check_room(at, Kind::I32, second)?;
            let mut numbers = zeroed::<u32>(second)?;
            self.numbers(Kind::I32, &mut numbers)?;
            return triangles.counted(at, shape, first, &numbers);
        };
        if !kind.is_whole() {
            let problem = "begins cells that are no whole numbers: save the file again";
            return Err(Stop::fault(at, problem));
        }
        self.check_room(at, kind, first)?;
        if !self.is_text && shape == Shape::Polygon && first > 0 {
            let before = self.cursor.at;
            self.cursor.skip_line();
            let ends = self.plain(kind, first)?;
            if second == 3 * (first - 1) && ends.are_threes(0, first, self.task) {
                self.cursor.at += first * kind.bytes();
                return self.triangles(at, first - 1, triangles);
            }
            self.cursor.at = before;
        }
        let mut ends = zeroed::<u32>(first)?;
        self.numbers(kind, &mut ends)?;
        let kind = self.connectivity(at)?;
        self.check_room(at, kind, second)?;
        // The first is where the first cell begins.
        let ends = match ends.split_first() {
            None if second == 0 => return self.numbers::<u32>(kind, &mut []),
            Some((0, ends)) if points_of(at, ends)? == second => ends,
            _ => {
                let problem = format!(
                    "begins cells of which the offsets do not run from 0 to the {second} points that they have: save the file again"
                );
                return Err(Stop::fault(at, problem));
            }
        };
        if shape == Shape::Polygon && are_triangles(ends) {
            return triangles.all(at, ends.len(), |to| self.numbers(kind, to));
        }
        let mut points = zeroed::<u32>(second)?;
        self.numbers(kind, &mut points)?;
        triangles.ending(at, shape, ends, &points)
    }

    /// So many triangles, of which the points stand here as bytes.
    fn triangles(
        &mut self,
        at: usize,
        count: usize,
        triangles: &mut Triangles<'_>,
    ) -> Result<(), Stop> {
        let kind = self.connectivity(at)?;
        self.check_room(at, kind, 3 * count)?;
        self.cursor.skip_line();
        let numbers = self.plain(kind, 3 * count)?;
        triangles.plain(at, count, &numbers)?;
        self.cursor.at += 3 * count * kind.bytes();
        Ok(())
    }

    /// Passes over cells that are no surface, and returns how many there are.
    fn skip_cells(&mut self, at: usize) -> Result<usize, Stop> {
        let ([first, second], offsets) = self.list(at)?;
        let Some(kind) = offsets else {
            self.skip_numbers(at, Kind::I32, second)?;
            return Ok(first);
        };
        self.skip_numbers(at, kind, first)?;
        let kind = self.connectivity(at)?;
        self.skip_numbers(at, kind, second)?;
        Ok(first.saturating_sub(1))
    }

    /// Names of components and the like, up to a blank line.
    fn metadata(&mut self) -> Result<(), Stop> {
        self.cursor.skip_line();
        for lines in 0.. {
            if lines % LINES == 0 {
                self.task.go_on()?;
            }
            let from = self.cursor.at;
            self.cursor.skip_line();
            let line = self.cursor.bytes.get(from..self.cursor.at);
            if line.unwrap_or_default().trim_ascii().is_empty() {
                break;
            }
        }
        Ok(())
    }

    /// Arrays of the whole file: a time, a name.
    fn field(&mut self, at: usize) -> Result<(), Stop> {
        self.cursor.skip_blanks();
        self.cursor.word(); // its name
        let arrays = self.count(at)?;
        self.cursor.skip_line();
        let mut passed = 0;
        while passed < arrays {
            self.task.go_on()?;
            self.cursor.skip_space();
            let at = self.cursor.at;
            match self.cursor.word() {
                b"" => {
                    let problem = "is the end, amid a field: the file is cut short, save it again";
                    return Err(Stop::fault(at, problem));
                }
                b"METADATA" => self.metadata()?,
                _ => {
                    let [components, rows] = [self.count(at)?, self.count(at)?];
                    let kind = self.kind(at)?;
                    self.skip_numbers(at, kind, components.saturating_mul(rows))?;
                    passed += 1;
                }
            }
        }
        Ok(())
    }
}
