//! Endpoints of models in files of their own: tables (CSV) and JSON.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::mesh::endpoints::{BYTES_MOST, Endpoint, from_csv, from_json, to_csv, to_json};
use crate::tree::file::write_atomically;

/// Reads endpoints from a file; what begins with a brace is JSON, whatever the file is called.
///
/// # Errors
/// In one sentence: what is wrong, where, and how to mend it.
pub fn read(path: &Path) -> Result<Vec<Endpoint>, String> {
    let name = path.display();
    let unreadable = |error: std::io::Error| {
        format!("{name} cannot be read ({error}): check that it is there and may be read")
    };
    // What is no plain file may never end, or never begin.
    if !path.metadata().map_err(unreadable)?.is_file() {
        return Err(format!(
            "{name} is no file: name a CSV or JSON file of endpoints"
        ));
    }
    let mut bytes = Vec::new();
    let most = u64::try_from(BYTES_MOST)
        .unwrap_or(u64::MAX)
        .saturating_add(1);
    let file = File::open(path).map_err(unreadable)?;
    file.take(most)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&bytes);
    let read = match text.trim_ascii_start().first() {
        Some(b'{') => from_json(&bytes),
        _ => from_csv(&bytes),
    };
    read.map_err(|error| format!("{name}: {error}"))
}

/// How endpoints are written.
type Written = fn(&[Endpoint]) -> String;

fn written(path: &Path) -> Result<Written, String> {
    let ending = path.extension().and_then(|ending| ending.to_str());
    match ending.map(str::to_lowercase).as_deref() {
        Some("csv") => Ok(to_csv),
        Some("json") => Ok(to_json),
        _ => Err(format!(
            "{} is no name for endpoints: let it end in .csv or .json",
            path.display()
        )),
    }
}

/// Whether endpoints can be written into a file of this name.
///
/// # Errors
/// In one sentence, where it ends neither in csv nor in json.
pub fn check_name(path: &Path) -> Result<(), String> {
    written(path).map(|_| ())
}

/// Writes endpoints, as JSON where the file's name ends so and as a table where it ends in csv; whole or not at all.
///
/// # Errors
/// In one sentence, for other endings too.
pub fn write(path: &Path, endpoints: &[Endpoint]) -> Result<(), String> {
    let text = written(path)?(endpoints);
    write_atomically(path, text.as_bytes()).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn what_is_written_is_read_and_what_cannot_be_is_told_with_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let ends = vec![Endpoint {
            name: "inlet".to_owned(),
            ..Endpoint::default()
        }];
        for name in ["a.csv", "a.JSON"] {
            let path = folder.path().join(name);
            write(&path, &ends).unwrap();
            assert_eq!(read(&path).unwrap(), ends);
        }
        let told = write(&folder.path().join("a.txt"), &ends).unwrap_err();
        assert!(told.contains(".csv or .json"), "{told}");
        let bad = folder.path().join("bad.csv");
        std::fs::write(&bad, "x,y,z\n1,2,drei\n").unwrap();
        for (path, expected) in [
            (bad.as_path(), "bad.csv: line 2 of the endpoints"),
            (folder.path(), "is no file"),
            (&folder.path().join("none.csv"), "none.csv cannot be read"),
        ] {
            let told = read(path).unwrap_err();
            assert!(
                told.contains(expected) && told.lines().count() == 1,
                "{told}"
            );
        }
    }
}
