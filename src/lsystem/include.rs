//! `include`: a grammar's text from several files of one folder.

use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use super::error::{GrammarError, GrammarErrors, nearest};
use super::parse::end;
use super::source::{Block, Cursor, MAX_SOURCE_BYTES, Source, Statement, statements};

/// Files that may include each other in a chain.
const MAX_INCLUDE_DEPTH: usize = 16;

/// Cuts a file and what it includes into statements, in the order of the text.
pub(super) fn gather(
    errors: &mut GrammarErrors,
    sources: &mut Vec<Source>,
    all: &mut Vec<Statement>,
    mut source: Source,
    folder: Option<&Path>,
    chain: &mut Vec<PathBuf>,
) {
    if let Some(stripped) = source.text.strip_prefix('\u{feff}') {
        source.text = stripped.to_owned();
    }
    let total: usize = sources.iter().map(|s| s.text.len()).sum::<usize>() + source.text.len();
    if total > MAX_SOURCE_BYTES {
        let message =
            format!("this grammar has {total} bytes of text; at most {MAX_SOURCE_BYTES} are read");
        errors.push(GrammarError::new(&source.name, &source.text, 0, message));
        return;
    }
    let index = sources.len();
    let found = statements(index, &source, errors);
    sources.push(source);
    for statement in found {
        if statement.keyword != "include" {
            all.push(statement);
            continue;
        }
        let Some(source) = sources.get(index) else {
            return;
        };
        match included(source, &statement, folder, chain) {
            Ok((path, included)) => {
                chain.push(path);
                gather(errors, sources, all, included, folder, chain);
                chain.pop();
            }
            Err(error) => errors.push(error),
        }
    }
}

/// Reads the file that an `include` names, which must lie in the grammar's folder.
fn included(
    source: &Source,
    statement: &Statement,
    folder: Option<&Path>,
    chain: &[PathBuf],
) -> Result<(PathBuf, Source), GrammarError> {
    let mut cursor = Cursor::new(source, statement.body, statement.end);
    if statement.block != Block::Main {
        return Err(cursor.error_at(
            statement.start,
            "`include` inside a block; expected it outside".into(),
        ));
    }
    if !cursor.take("\"") {
        return Err(cursor.expected("a file's name in quotes, as in `include \"rules.lsys\"`"));
    }
    let start = cursor.pos();
    let rest = cursor.rest();
    let Some(length) = rest.find('"') else {
        return Err(cursor.error_at(start, "this file name is not closed; expected `\"`".into()));
    };
    let name = rest.get(..length).unwrap_or("");
    cursor.advance(length + 1);
    end(&mut cursor)?;
    read_included(name, folder, chain).map_err(|message| cursor.error_at(start, message))
}

/// Reads a file of the grammar's folder.
///
/// # Errors
/// Why it cannot be read, or may not be.
pub(super) fn read_included(
    name: &str,
    folder: Option<&Path>,
    chain: &[PathBuf],
) -> Result<(PathBuf, Source), String> {
    let Some(folder) = folder else {
        return Err(format!(
            "cannot include `{name}`: this grammar is not in a file, so it has no folder to read from"
        ));
    };
    if chain.len() >= MAX_INCLUDE_DEPTH {
        return Err(format!("includes nest deeper than {MAX_INCLUDE_DEPTH}"));
    }
    let path = match folder.join(name).canonicalize() {
        Ok(path) if path.starts_with(folder) => path,
        Ok(_) => {
            return Err(format!(
                "`{name}` is outside the grammar's folder; copy it there"
            ));
        }
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let hint = neighbour(folder, name).map_or(String::new(), |near| {
                format!("; the nearest that is there is `{near}`")
            });
            return Err(format!(
                "there is no `{name}` in the grammar's folder{hint}"
            ));
        }
        Err(error) => return Err(format!("cannot read `{name}`: {error}")),
    };
    if chain.contains(&path) {
        return Err(format!("`{name}` includes itself"));
    }
    match read(&path) {
        Ok(text) => Ok((path, Source::new(name.to_owned(), text))),
        Err(why) => Err(format!("cannot read `{name}`: {why}")),
    }
}

/// Files of a folder that are looked at for one with a name like another.
const MOST_NEIGHBOURS: usize = 1000;

/// The grammar in the folder whose name is nearest to `name`.
fn neighbour(folder: &Path, name: &str) -> Option<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .take(MOST_NEIGHBOURS)
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|file| file.ends_with(".lsys"))
        .collect();
    names.sort_unstable(); // whatever the order in which the system tells them
    // The ending is what they have in common.
    let stem = name.strip_suffix(".lsys").unwrap_or(name);
    let stems = names.iter().filter_map(|file| file.strip_suffix(".lsys"));
    nearest(stem, stems).map(|near| format!("{near}.lsys"))
}

/// The text of a regular file of bounded size. What a file says of its size is not relied on: some say 0 and
/// never end.
fn read(path: &Path) -> Result<String, String> {
    let no_file = || "it is no regular file; include a text file".to_owned();
    let told = |error: std::io::Error| error.to_string();
    // Looked at before it is opened, since opening a pipe waits for its writer, and again after, since it may be another.
    if !path.metadata().map_err(told)?.is_file() {
        return Err(no_file());
    }
    let file = File::open(path).map_err(told)?;
    let about = file.metadata().map_err(told)?;
    if !about.is_file() {
        return Err(no_file());
    }
    let too_long = || format!("it is longer than {MAX_SOURCE_BYTES} bytes; include a shorter file");
    if about.len() > MAX_SOURCE_BYTES as u64 {
        return Err(too_long());
    }
    let mut text = String::new();
    file.take(MAX_SOURCE_BYTES as u64 + 1)
        .read_to_string(&mut text)
        .map_err(told)?;
    if text.len() > MAX_SOURCE_BYTES {
        return Err(too_long());
    }
    Ok(text)
}

/// The folder of a grammar file that exists on this machine.
pub(super) fn folder_of(file: &str) -> Option<PathBuf> {
    let path = Path::new(file);
    if !path.is_file() {
        return None;
    }
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    folder.canonicalize().ok()
}
