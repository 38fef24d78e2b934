//! Tables as files: CSV, JSON and Parquet of the same cells.
//!
//! A table asks for its cells one by one and is written as it goes, so that none is in memory twice. Empty cells are empty in CSV, `null` in
//! JSON and Parquet. Numbers are the shortest that are read back the same; what is not finite is empty.

use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use crate::tree::TreeError;
use crate::tree::file::write_atomically_with;

/// Rows of a Parquet file's group: what is in memory at once.
const GROUP: usize = 1 << 17;

/// What all cells of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Words.
    Text,
    /// Whole numbers.
    Whole,
    /// Numbers.
    Real,
    /// Yes or no.
    Flag,
}

impl Kind {
    /// Its name in tables of columns.
    pub fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Whole => "whole number",
            Self::Real => "number",
            Self::Flag => "true or false",
        }
    }
}

/// What is in a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell<'a> {
    /// Nothing.
    Empty,
    /// Words.
    Text(&'a str),
    /// A whole number.
    Whole(i64),
    /// A number; empty where it is not finite.
    Real(f64),
    /// Yes or no.
    Flag(bool),
}

impl Cell<'_> {
    /// A whole number that no file of this world is too small for.
    pub fn whole(number: usize) -> Self {
        i64::try_from(number).map_or(Self::Empty, Self::Whole)
    }

    /// What is there, or nothing.
    pub fn or_empty<T>(value: Option<T>, cell: impl FnOnce(T) -> Self) -> Self {
        value.map_or(Self::Empty, cell)
    }

    /// A number as text; empty where there is none.
    fn number(&self) -> Option<String> {
        match self {
            Self::Whole(number) => Some(number.to_string()),
            Self::Real(number) => number.is_finite().then(|| format!("{number:?}")),
            Self::Flag(yes) => Some(yes.to_string()),
            Self::Empty | Self::Text(_) => None,
        }
    }
}

/// A column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// What its cells are.
    pub kind: Kind,
    /// What its numbers are counted in; empty where that is nothing.
    pub unit: &'static str,
    /// What it says, in a few words.
    pub meaning: String,
    /// The definition of a branch that it follows; empty where it follows none.
    pub definition: &'static str,
}

/// Gives the cell of a row and a column.
type Cells<'a> = Box<dyn Fn(usize, usize) -> Cell<'a> + 'a>;

/// A table.
pub struct Table<'a> {
    /// Its columns.
    pub columns: Vec<Column>,
    /// How many rows it has.
    pub rows: usize,
    /// What is in them.
    pub cells: Cells<'a>,
}

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A line a row, names in the first.
    Csv,
    /// An object a row.
    Json,
    /// Apache Parquet.
    Parquet,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Csv, Self::Json, Self::Parquet];

    /// How its files' names end.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
            Self::Parquet => "parquet",
        }
    }
}

impl Table<'_> {
    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// Where the disk does not take it.
    pub fn write(&self, path: &Path, format: Format) -> Result<(), TreeError> {
        write_atomically_with(path, |out| match format {
            Format::Csv => self.csv(out),
            Format::Json => self.json(out),
            Format::Parquet => self.parquet(out),
        })
    }

    fn csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut out = csv::Writer::from_writer(out);
        out.write_record(self.columns.iter().map(|column| &column.name))?;
        for row in 0..self.rows {
            for column in 0..self.columns.len() {
                match (self.cells)(row, column) {
                    Cell::Text(text) => out.write_field(text)?,
                    cell => out.write_field(cell.number().unwrap_or_default())?,
                }
            }
            out.write_record(None::<&[u8]>)?;
        }
        out.flush()
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(b"[")?;
        for row in 0..self.rows {
            out.write_all(if row == 0 { b"\n{" } else { b",\n{" })?;
            for (place, column) in self.columns.iter().enumerate() {
                let name = serde_json::to_string(&column.name)?;
                let value = match (self.cells)(row, place) {
                    Cell::Text(text) => serde_json::to_string(text)?,
                    cell => cell.number().unwrap_or_else(|| "null".to_owned()),
                };
                let comma = if place == 0 { "" } else { "," };
                write!(out, "{comma}{name}:{value}")?;
            }
            out.write_all(b"}")?;
        }
        out.write_all(b"\n]\n")
    }

    fn parquet(&self, out: &mut (dyn Write + '_)) -> io::Result<()> {
        // Its writer wants bytes that may go to another thread, as `out` may not: they are handed on after each group.
        let mut file =
            SerializedFileWriter::new(Vec::<u8>::new(), self.schema()?, self.properties())?;
        let mut first = 0;
        while first < self.rows {
            let rows = first..self.rows.min(first + GROUP);
            first = rows.end;
            let mut group = file.next_row_group()?;
            for (place, column) in self.columns.iter().enumerate() {
                let Some(mut writer) = group.next_column()? else {
                    return Err(io::Error::other("a column of the table was lost"));
                };
                let cells = rows.clone().map(|row| (self.cells)(row, place));
                match column.kind {
                    Kind::Text => put::<ByteArrayType>(&mut writer, cells, |cell| match cell {
                        Cell::Text(text) => Some(ByteArray::from(text)),
                        _ => None,
                    }),
                    Kind::Whole => put::<Int64Type>(&mut writer, cells, |cell| match cell {
                        Cell::Whole(number) => Some(number),
                        _ => None,
                    }),
                    Kind::Real => put::<DoubleType>(&mut writer, cells, |cell| match cell {
                        Cell::Real(number) if number.is_finite() => Some(number),
                        _ => None,
                    }),
                    Kind::Flag => put::<BoolType>(&mut writer, cells, |cell| match cell {
                        Cell::Flag(yes) => Some(yes),
                        _ => None,
                    }),
                }?;
                writer.close()?;
            }
            group.close()?;
            file.flush()?;
            out.write_all(&std::mem::take(file.inner_mut()))?;
        }
        out.write_all(&file.into_inner()?)
    }

    fn schema(&self) -> Result<Arc<Type>, ParquetError> {
        let field = |column: &Column| {
            let physical = match column.kind {
                Kind::Text => Physical::BYTE_ARRAY,
                Kind::Whole => Physical::INT64,
                Kind::Real => Physical::DOUBLE,
                Kind::Flag => Physical::BOOLEAN,
            };
            let is_text = column.kind == Kind::Text;
            let field = Type::primitive_type_builder(&column.name, physical)
                .with_repetition(Repetition::OPTIONAL)
                .with_logical_type(is_text.then_some(LogicalType::String));
            let field = match is_text {
                true => field.with_converted_type(ConvertedType::UTF8),
                false => field,
            };
            field.build().map(Arc::new)
        };
        let fields: Result<Vec<_>, _> = self.columns.iter().map(field).collect();
        let table = Type::group_type_builder("table").with_fields(fields?);
        table.build().map(Arc::new)
    }

    /// Units are told as `unit of NAME`.
    fn properties(&self) -> Arc<WriterProperties> {
        let told = self
            .columns
            .iter()
            .filter(|column| !column.unit.is_empty())
            .map(|column| {
                KeyValue::new(format!("unit of {}", column.name), column.unit.to_owned())
            });
        let properties = WriterProperties::builder()
            .set_created_by("ramus".to_owned())
            .set_key_value_metadata(Some(told.collect()));
        Arc::new(properties.build())
    }
}

/// Writes the cells of a column.
fn put<'a, T: DataType>(
    writer: &mut SerializedColumnWriter<'_>,
    cells: impl Iterator<Item = Cell<'a>>,
    value: impl Fn(Cell<'a>) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    for cell in cells {
        let value = value(cell);
        levels.push(i16::from(value.is_some()));
        values.extend(value);
    }
    writer
        .typed::<T>()
        .write_batch(&values, Some(&levels), None)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::Field;

    use super::*;

    fn column(name: &str, kind: Kind, unit: &'static str) -> Column {
        Column {
            name: name.to_owned(),
            kind,
            unit,
            meaning: String::new(),
            definition: "",
        }
    }

    /// So many rows of every kind, each third one empty.
    fn table(rows: usize) -> Table<'static> {
        Table {
            columns: vec![
                column("name", Kind::Text, ""),
                column("many", Kind::Whole, ""),
                column("long", Kind::Real, "mm"),
                column("good", Kind::Flag, ""),
            ],
            rows,
            cells: Box::new(|row, column| match column {
                _ if row % 3 == 2 => Cell::Empty,
                0 => Cell::Text("ä \"b\", c"),
                1 => Cell::whole(row),
                2 if row == 0 => Cell::Real(f64::INFINITY),
                2 => Cell::Real(row as f64 / 10.0),
                _ => Cell::Flag(row.is_multiple_of(2)),
            }),
        }
    }

    fn written(table: &Table<'_>, format: Format) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table");
        table.write(&path, format).unwrap();
        std::fs::read(path).unwrap()
    }

    #[test]
    fn text_formats_have_the_same_cells() {
        let text = |format| String::from_utf8(written(&table(3), format)).unwrap();
        assert_eq!(
            text(Format::Csv),
            "name,many,long,good\n\"ä \"\"b\"\", c\",0,,true\n\"ä \"\"b\"\", c\",1,0.1,false\n,,,\n"
        );
        let json: serde_json::Value = serde_json::from_str(&text(Format::Json)).unwrap();
        let name = "ä \"b\", c";
        let expected = serde_json::json!([
            {"name": name, "many": 0, "long": null, "good": true},
            {"name": name, "many": 1, "long": 0.1, "good": false},
            {"name": null, "many": null, "long": null, "good": null},
        ]);
        assert_eq!(json, expected);
        let empty = String::from_utf8(written(&table(0), Format::Json)).unwrap();
        assert_eq!(empty, "[\n]\n");
    }

    /// Over the edge of a group, and nothing at all.
    #[test]
    fn parquet_is_read_back_with_types_units_and_empty_cells() {
        for rows in [0, 1, GROUP + 5] {
            let table = table(rows);
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(&written(&table, Format::Parquet)).unwrap();
            let reader = SerializedFileReader::new(file).unwrap();
            let told = reader.metadata().file_metadata().key_value_metadata();
            assert_eq!(told.unwrap()[0].key, "unit of long");
            let mut read = 0;
            for row in reader.get_row_iter(None).unwrap() {
                let row = row.unwrap();
                for (place, (name, field)) in row.get_column_iter().enumerate() {
                    assert_eq!(*name, table.columns[place].name);
                    let same = match ((table.cells)(read, place), field) {
                        (Cell::Text(text), Field::Str(field)) => text == field,
                        (Cell::Whole(number), Field::Long(field)) => number == *field,
                        (Cell::Real(number), Field::Double(field)) => number == *field,
                        (Cell::Real(number), Field::Null) => !number.is_finite(),
                        (Cell::Flag(yes), Field::Bool(field)) => yes == *field,
                        (Cell::Empty, Field::Null) => true,
                        _ => false,
                    };
                    assert!(same, "row {read}, {name}: {field}");
                }
                read += 1;
            }
            assert_eq!(read, rows);
        }
    }
}
