//! Which models a cohort is of: a folder, or a list.

use std::collections::HashSet;
use std::fs::File;
use std::io::Read as _;
use std::path::{Component, Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use glam::DVec3;

use super::told;

/// Models of a cohort at most.
pub const MODELS_MOST: usize = 100_000;
/// Longest list that is read, in bytes.
const BYTES_MOST: u64 = 256 << 20;
/// How names of models' files end.
const ENDINGS: [&str; 8] = ["ply", "stl", "obj", "vtp", "vtk", "gltf", "glb", "swc"];
/// How the name of a file of endpoints ends that lies beside its model, after the model's without its ending.
const BESIDE: [&str; 2] = ["endpoints.csv", "endpoints.json"];
/// What columns of lists are called; `model` stands for `path`, too.
const COLUMNS: [&str; 3] = ["path", "endpoints", "source"];

/// A model of a cohort.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Entry {
    /// Its file, or the file that `ramus analyze --json` wrote of it.
    pub path: PathBuf,
    /// Where its endpoints are; they are found where there is none.
    pub endpoints: Option<PathBuf>,
    /// Where its centerlines begin.
    pub source: Option<DVec3>,
}

impl Entry {
    /// Whether it was analyzed already, and the file tells what was found.
    pub fn is_analyzed(&self) -> bool {
        has_ending(&self.path, &["json"])
    }
}

/// The models of a folder, by name, or of a list, in its order.
///
/// # Errors
/// What is wrong with the folder or the list, and how to mend it.
pub fn entries(of: &Path) -> Result<Vec<Entry>> {
    let name = of.display();
    let known = of.metadata().map_err(|error| {
        anyhow!("{name} cannot be read ({error}): check that it is there and may be read")
    })?;
    let entries = match known.is_dir() {
        true => in_folder(of)?,
        false if has_ending(of, &ENDINGS) => bail!(
            "{name} is a model: `ramus analyze` measures one; name a folder or a list of models here"
        ),
        false if has_ending(of, &["json"]) => {
            bail!("{name} is one analysis at most: name a folder or a list of them")
        }
        false => {
            from_text(&text_of(of, "list of models")?, of).with_context(|| name.to_string())?
        }
    };
    ensure!(
        entries.len() <= MODELS_MOST,
        "{name} has {} models, more than {MODELS_MOST}: split it",
        entries.len()
    );
    ensure!(
        !entries.is_empty(),
        "{name} has no models: they end in .{}, or are the .json files of `ramus analyze --json`",
        ENDINGS.join(", .")
    );
    Ok(entries)
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| endings.iter().any(|one| one.eq_ignore_ascii_case(ending)))
}

/// The bytes of a plain file of no more than so many; messages say `what` it is to be.
pub(crate) fn bytes_of(path: &Path, most: u64, what: &str) -> Result<Vec<u8>> {
    let name = path.display();
    let unreadable = |error: std::io::Error| {
        anyhow!("{name} cannot be read ({error}): check that it is there and may be read")
    };
    // What is no plain file may never end, or never begin.
    ensure!(
        path.metadata().map_err(unreadable)?.is_file(),
        "{name} is no file: name a {what}"
    );
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(most + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    ensure!(
        bytes.len() as u64 <= most,
        "{name} is longer than {most} bytes, and no {what} is"
    );
    Ok(bytes)
}

/// The text of a table, of which messages say `what` it is to be.
pub(crate) fn text_of(path: &Path, what: &str) -> Result<String> {
    let name = path.display();
    let bytes = bytes_of(path, BYTES_MOST, what)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        anyhow!("{name} is no UTF-8 text (byte {at}): save the {what} as such")
    })?;
    Ok(text.strip_prefix('\u{feff}').unwrap_or(&text).to_owned())
}

fn in_folder(folder: &Path) -> Result<Vec<Entry>> {
    let unreadable = |error: std::io::Error| {
        anyhow!(
            "{} cannot be read ({error}): check that it is there and may be read",
            folder.display()
        )
    };
    let mut paths = Vec::new();
    for file in folder.read_dir().map_err(unreadable)? {
        let path = file.map_err(unreadable)?.path();
        let is_model = has_ending(&path, &ENDINGS)
            || has_ending(&path, &["json"]) && told::looks_like_one(&path);
        if is_model && path.is_file() {
            paths.push(path);
        }
    }
    paths.sort();
    paths
        .into_iter()
        .map(|path| {
            let endpoints = beside(&path)?;
            Ok(Entry {
                path,
                endpoints,
                source: None,
            })
        })
        .collect()
}

/// The file of endpoints beside a model.
fn beside(model: &Path) -> Result<Option<PathBuf>> {
    if has_ending(model, &["json"]) {
        return Ok(None);
    }
    let mut found = BESIDE
        .iter()
        .map(|ending| model.with_extension(ending))
        .filter(|path| path.exists());
    match (found.next(), found.next()) {
        (Some(one), Some(other)) => bail!(
            "{} and {} both lie beside {}: leave one of them",
            one.display(),
            other.display(),
            model.display()
        ),
        (one, _) => Ok(one),
    }
}

/// The models of a list whose text this is; paths in it are seen from where it lies.
///
/// # Errors
/// What is wrong with it, and in which line.
pub fn from_text(text: &str, list: &Path) -> Result<Vec<Entry>> {
    let folder = list.parent().unwrap_or(Path::new(""));
    let mut rows = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut columns: Option<Vec<usize>> = None;
    let mut entries = Vec::new();
    for row in rows.records() {
        let row = row.map_err(|error| anyhow!("no table can be read there ({error})"))?;
        let line = row.position().map_or(0, csv::Position::line);
        let columns = match &columns {
            Some(columns) => columns,
            None => {
                let named = named_columns(&row).with_context(|| format!("line {line}"))?;
                let is_header = named.is_some();
                let columns = columns.insert(named.unwrap_or_else(|| vec![0, 1, 2]));
                if is_header {
                    continue;
                }
                columns
            }
        };
        let entry = entry(&row, columns, folder).with_context(|| format!("line {line}"))?;
        entries.extend(entry);
        ensure!(
            entries.len() <= MODELS_MOST,
            "line {line} is of one model more than {MODELS_MOST}: split the list"
        );
    }
    Ok(entries)
}

/// Which of [`COLUMNS`] each place is of, where a row has their names.
fn named_columns(row: &csv::StringRecord) -> Result<Option<Vec<usize>>> {
    let number = |name: &str| {
        let name = if name.eq_ignore_ascii_case("model") {
            "path"
        } else {
            name
        };
        COLUMNS
            .iter()
            .position(|column| column.eq_ignore_ascii_case(name))
    };
    if !row.iter().any(|name| number(name) == Some(0)) {
        return Ok(None);
    }
    let mut columns = Vec::new();
    for name in row {
        let Some(number) = number(name) else {
            bail!("there is no column {name:?}: columns are path, endpoints and source");
        };
        ensure!(
            !columns.contains(&number),
            "the column {} is there twice: leave one of them",
            COLUMNS[number]
        );
        columns.push(number);
    }
    Ok(Some(columns))
}

/// The model of a row; None where the row is empty.
fn entry(row: &csv::StringRecord, columns: &[usize], folder: &Path) -> Result<Option<Entry>> {
    let mut cells = [""; COLUMNS.len()];
    for (place, cell) in row.iter().enumerate() {
        match columns.get(place) {
            Some(column) => cells[*column] = cell,
            None if cell.is_empty() => {}
            None => bail!(
                "{cell:?} is in no column: a path with commas in it stands between quotes, and so does a source \"X,Y,Z\""
            ),
        }
    }
    let [path, endpoints, source] = cells;
    if cells.iter().all(|cell| cell.is_empty()) {
        return Ok(None);
    }
    ensure!(!path.is_empty(), "a model's path is missing");
    let entry = Entry {
        path: folder.join(path),
        endpoints: (!endpoints.is_empty()).then(|| folder.join(endpoints)),
        source: (!source.is_empty()).then(|| point(source)).transpose()?,
    };
    ensure!(
        !entry.is_analyzed() || (entry.endpoints.is_none() && entry.source.is_none()),
        "{path} was analyzed already: leave out its endpoints and its source"
    );
    let endpoints = match &entry.endpoints {
        None if !entry.is_analyzed() => beside(&entry.path)?,
        given => given.clone(),
    };
    Ok(Some(Entry { endpoints, ..entry }))
}

/// Three numbers with commas, semicolons or blanks between.
fn point(text: &str) -> Result<DVec3> {
    let parts = text.split([',', ';', ' ']).filter(|part| !part.is_empty());
    let numbers: Option<Vec<f64>> = parts.map(|part| part.parse().ok()).collect();
    match numbers.as_deref() {
        Some([x, y, z]) if [x, y, z].iter().all(|one| one.is_finite()) => {
            Ok(DVec3::new(*x, *y, *z))
        }
        _ => bail!("the source {text:?} is not three numbers, such as \"1.5,-2,30\""),
    }
}

/// What models are called: their files' names, with as many folders before as tell all apart.
///
/// # Errors
/// A model is there twice.
pub(super) fn labels(paths: &[PathBuf]) -> Result<Vec<String>> {
    let parts: Vec<Vec<String>> = paths
        .iter()
        .map(|path| {
            let whole = std::path::absolute(path).unwrap_or_else(|_| path.clone());
            whole
                .components()
                .filter(|part| !matches!(part, Component::RootDir | Component::CurDir))
                .map(|part| part.as_os_str().to_string_lossy().into_owned())
                .collect()
        })
        .collect();
    let mut seen = HashSet::new();
    for path in paths {
        // However it is spelled; of what is not here the name alone is known.
        let place = path.canonicalize().or_else(|_| std::path::absolute(path));
        let is_new = seen.insert(place.unwrap_or_else(|_| path.clone()));
        ensure!(
            is_new,
            "{} is there twice: leave one of them",
            path.display()
        );
    }
    let most = parts.iter().map(Vec::len).max().unwrap_or(0);
    for depth in 1..=most {
        let labels: Vec<String> = parts
            .iter()
            .map(|parts| parts[parts.len().saturating_sub(depth)..].join("/"))
            .collect();
        if labels.iter().collect::<HashSet<_>>().len() == labels.len() {
            return Ok(labels);
        }
    }
    bail!("two models cannot be told apart by their names: rename one of them")
}

/// A list of models as [`entries`] reads it, with paths as seen from here.
///
/// # Errors
/// None that a person could meet.
pub fn plan(entries: &[Entry]) -> Result<String> {
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record(COLUMNS)?;
    for entry in entries {
        let endpoints = entry.endpoints.as_deref().map(Path::display);
        let source = entry
            .source
            .map(|DVec3 { x, y, z }| format!("{x:?},{y:?},{z:?}"));
        out.write_record([
            entry.path.display().to_string(),
            endpoints.map_or_else(String::new, |path| path.to_string()),
            source.unwrap_or_default(),
        ])?;
    }
    Ok(String::from_utf8(out.into_inner()?)?)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::app::sentence;

    fn list(text: &str) -> Result<Vec<Entry>, String> {
        from_text(text, Path::new("here/list.csv")).map_err(|error| sentence(&error))
    }

    #[test]
    fn lists_have_one_model_a_line_with_or_without_names_of_columns() {
        let entry = |path: &str, endpoints: Option<&str>, source| Entry {
            path: path.into(),
            endpoints: endpoints.map(PathBuf::from),
            source,
        };
        for (text, expected) in [
            ("", vec![]),
            (
                "# mine\na.obj\n\n/b/b.swc\n",
                vec![
                    entry("here/a.obj", None, None),
                    entry("/b/b.swc", None, None),
                ],
            ),
            (
                "source,Model\n\"1,-2,3e1\",a.obj\n,\"b, c.ply\"\n",
                vec![
                    entry("here/a.obj", None, Some(DVec3::new(1.0, -2.0, 30.0))),
                    entry("here/b, c.ply", None, None),
                ],
            ),
            (
                "a.obj , ends.csv, 1 2 3\nb.json,,",
                vec![
                    entry(
                        "here/a.obj",
                        Some("here/ends.csv"),
                        Some(DVec3::new(1.0, 2.0, 3.0)),
                    ),
                    entry("here/b.json", None, None),
                ],
            ),
        ] {
            assert_eq!(list(text).unwrap(), expected, "{text}");
        }
        let entries = list("a.obj,e.csv,1 2 3\nb.obj\n").unwrap();
        let again = from_text(&plan(&entries).unwrap(), Path::new("list.csv")).unwrap();
        assert_eq!(again, entries);
    }

    #[test]
    fn what_is_wrong_with_a_list_is_told_with_its_line() {
        for (text, expected) in [
            ("a.obj\nb.obj,,1 2\n", "line 2: the source \"1 2\" is not"),
            ("a.obj,,1 2 nan", "is not three numbers"),
            ("a.obj,,1,2,3", "line 1: \"2\" is in no column"),
            ("path,colour\n", "there is no column \"colour\""),
            ("path,model\n", "the column path is there twice"),
            (",e.csv\n", "a model's path is missing"),
            ("a.json,e.csv\n", "was analyzed already"),
        ] {
            let told = list(text).unwrap_err();
            assert!(told.contains(expected), "{text}: {told}");
        }
    }

    #[test]
    fn labels_are_as_short_as_they_can_be() {
        let of = |paths: &[&str]| {
            let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
            labels(&paths).map_err(|error| error.to_string())
        };
        assert_eq!(of(&["/x/a.obj", "b.obj"]).unwrap(), ["a.obj", "b.obj"]);
        assert_eq!(
            of(&["/x/1/a.obj", "/x/2/a.obj", "/y/b.obj"]).unwrap(),
            ["1/a.obj", "2/a.obj", "y/b.obj"]
        );
        let told = of(&["/x/a.obj", "/x/./a.obj"]).unwrap_err();
        assert!(told.contains("is there twice"), "{told}");
    }
}
