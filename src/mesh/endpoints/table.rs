//! Endpoints in files: a table in CSV, or JSON.
//!
//! Written numbers are the shortest that are read back the same.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{
    BYTES_MOST, COORDINATE_MOST, ENDPOINTS_MOST, Endpoint, EndpointError, Kind, NAME_MOST, Snapped,
};

/// What JSON files of endpoints say that they are.
const FORMAT: &str = "ramus-endpoints/1";

const COLUMNS: [&str; 9] = [
    "name", "kind", "x", "y", "z", "centre_x", "centre_y", "centre_z", "radius",
];

#[derive(Serialize, Deserialize)]
struct File {
    format: String,
    endpoints: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Entry {
    #[serde(default)]
    name: String,
    #[serde(default)]
    kind: String,
    point: [f64; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    centre: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
}

/// A table with the columns name, kind, x, y, z, and centre_x, centre_y, centre_z, radius, which are empty where an endpoint is not snapped.
#[must_use]
pub fn to_csv(endpoints: &[Endpoint]) -> String {
    let mut out = csv::Writer::from_writer(Vec::new());
    // Writing to memory does not fail.
    let _ = out.write_record(COLUMNS);
    for one in endpoints {
        let snapped = one.snapped.map(|snapped| {
            let [x, y, z] = snapped.centre.to_array();
            [x, y, z, snapped.radius].map(written)
        });
        let fields = [one.name.clone(), one.kind.as_str().to_owned()];
        let point = one.point.to_array().map(written);
        let all = fields.into_iter().chain(point);
        let _ = out.write_record(all.chain(snapped.unwrap_or_default()));
    }
    let bytes = out.into_inner().unwrap_or_default();
    String::from_utf8(bytes).unwrap_or_default()
}

/// All digits of a number, and no row of zeros where it is next to nothing.
fn written(number: f64) -> String {
    format!("{number:?}")
}

/// Reads such a table. Columns may stand in any order; x, y and z must be there, others may be missing, and those of other names are passed over.
///
/// # Errors
/// [`EndpointError`] with the line.
pub fn from_csv(bytes: &[u8]) -> Result<Vec<Endpoint>, EndpointError> {
    let text = text(bytes)?;
    let mut rows = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = rows.headers().map_err(|error| damaged(&error))?.clone();
    let column = |name: &str| {
        header
            .iter()
            .position(|other| other.eq_ignore_ascii_case(name))
    };
    for name in ["x", "y", "z"] {
        column(name).ok_or(EndpointError::NoColumn(name))?;
    }
    let columns = COLUMNS.map(column);
    let mut list = Vec::new();
    for row in rows.records() {
        let row = row.map_err(|error| damaged(&error))?;
        let line = row.position().map_or(0, csv::Position::line);
        if list.len() == ENDPOINTS_MOST {
            return Err(EndpointError::TooMany {
                line,
                number: ENDPOINTS_MOST + 1,
            });
        }
        let entry = Entry::from_row(&row, &columns)
            .and_then(Entry::endpoint)
            .map_err(|problem| EndpointError::Damaged { line, problem })?;
        list.push(entry);
    }
    Ok(list)
}

/// The same as JSON.
#[must_use]
pub fn to_json(endpoints: &[Endpoint]) -> String {
    let file = File {
        format: FORMAT.to_owned(),
        endpoints: endpoints.iter().cloned().map(Entry::from).collect(),
    };
    serde_json::to_string_pretty(&file).unwrap_or_default()
}

/// Reads such JSON.
///
/// # Errors
/// [`EndpointError`] with the line, or the endpoint's number.
pub fn from_json(bytes: &[u8]) -> Result<Vec<Endpoint>, EndpointError> {
    let file: File = serde_json::from_str(text(bytes)?).map_err(|error| {
        let told = error.to_string();
        let problem = told.split(" at line ").next().unwrap_or_default();
        EndpointError::Damaged {
            line: u64::try_from(error.line()).unwrap_or(0),
            problem: format!("is not as JSON of endpoints must be ({problem}): mend it there"),
        }
    })?;
    if file.format != FORMAT {
        return Err(EndpointError::Format(shown(&file.format)));
    }
    if file.endpoints.len() > ENDPOINTS_MOST {
        return Err(EndpointError::Wrong {
            number: ENDPOINTS_MOST + 1,
            problem: "is more than are read: split the file".to_owned(),
        });
    }
    let entries = file.endpoints.into_iter().enumerate();
    entries
        .map(|(place, entry)| {
            entry.endpoint().map_err(|problem| EndpointError::Wrong {
                number: place + 1,
                problem,
            })
        })
        .collect()
}

fn text(bytes: &[u8]) -> Result<&str, EndpointError> {
    if bytes.len() > BYTES_MOST {
        return Err(EndpointError::TooLong(bytes.len()));
    }
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    std::str::from_utf8(bytes).map_err(|error| {
        let before = bytes.get(..error.valid_up_to()).unwrap_or_default();
        let lines = before.iter().filter(|byte| **byte == b'\n').count();
        EndpointError::Damaged {
            line: u64::try_from(lines + 1).unwrap_or(u64::MAX),
            problem: "has bytes that are no UTF-8 text: save the file as text".to_owned(),
        }
    })
}

fn damaged(error: &csv::Error) -> EndpointError {
    let line = error.position().map_or(1, csv::Position::line);
    let problem = match error.kind() {
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => {
            format!(
                "has {len} columns and the first line {expected_len}: write as many, empty ones too"
            )
        }
        _ => "cannot be read as CSV: mend or remove it".to_owned(),
    };
    EndpointError::Damaged { line, problem }
}

/// The beginning of what a file says, as much as fits in a sentence.
fn shown(what: &str) -> String {
    let short: String = what.chars().take(30).collect();
    format!("{short:?}")
}

impl From<Endpoint> for Entry {
    fn from(one: Endpoint) -> Self {
        Self {
            name: one.name,
            kind: one.kind.as_str().to_owned(),
            point: one.point.to_array(),
            centre: one.snapped.map(|snapped| snapped.centre.to_array()),
            radius: one.snapped.map(|snapped| snapped.radius),
        }
    }
}

impl TryFrom<Entry> for Endpoint {
    type Error = String;

    fn try_from(entry: Entry) -> Result<Self, String> {
        entry.endpoint()
    }
}

impl Entry {
    fn from_row(row: &csv::StringRecord, columns: &[Option<usize>; 9]) -> Result<Self, String> {
        let field = |column: usize| columns[column].and_then(|at| row.get(at)).unwrap_or("");
        let number = |column: usize| {
            let (written, name) = (field(column), COLUMNS[column]);
            written.parse::<f64>().map_err(|_| {
                format!(
                    "has {} in column {name}, which is no number: write a decimal number such as -12.5",
                    shown(written)
                )
            })
        };
        let has = |column: usize| !field(column).is_empty();
        let is_snapped = (5..9).any(has);
        Ok(Self {
            name: field(0).to_owned(),
            kind: field(1).to_owned(),
            point: [number(2)?, number(3)?, number(4)?],
            centre: match is_snapped {
                true => Some([number(5)?, number(6)?, number(7)?]),
                false => None,
            },
            radius: if is_snapped { Some(number(8)?) } else { None },
        })
    }

    fn endpoint(self) -> Result<Endpoint, String> {
        if self.name.len() > NAME_MOST {
            return Err(format!(
                "has a name of {} bytes, more than the {NAME_MOST} that are read: shorten it",
                self.name.len()
            ));
        }
        if self.name.contains(char::is_control) {
            return Err("has a name with a line break or another sign that is not shown: write it in one line".to_owned());
        }
        let kind = match self.kind.to_ascii_lowercase().as_str() {
            "source" => Kind::Source,
            "target" | "" => Kind::Target,
            _ => {
                return Err(format!(
                    "has the kind {}: write source or target",
                    shown(&self.kind)
                ));
            }
        };
        let snapped = match (self.centre, self.radius) {
            (Some(centre), Some(radius)) if radius > 0.0 && radius <= COORDINATE_MOST => {
                Some(Snapped {
                    centre: coordinates(centre)?,
                    radius,
                })
            }
            (Some(_), Some(radius)) => {
                return Err(format!(
                    "has the radius {radius}: write a number above zero, or leave centre and radius out"
                ));
            }
            (None, None) => None,
            _ => {
                return Err(
                    "has only one of centre and radius: write both or leave both out".to_owned(),
                );
            }
        };
        Ok(Endpoint {
            point: coordinates(self.point)?,
            name: self.name,
            kind,
            snapped,
        })
    }
}

fn coordinates(numbers: [f64; 3]) -> Result<DVec3, String> {
    let wrong = numbers
        .iter()
        .find(|number| number.abs().is_nan() || number.abs() > COORDINATE_MOST);
    match wrong {
        None => Ok(DVec3::from(numbers)),
        Some(wrong) => Err(format!(
            "has the coordinate {wrong}: write one between -1e15 and 1e15"
        )),
    }
}
