//! Where grammars come from: files and standard input.

use std::fs::File;
use std::io::{Read, stdin};
use std::path::Path;

use anyhow::{Result, anyhow, bail};

/// Larger files are no grammars.
const MAX_GRAMMAR_BYTES: u64 = 64 << 20;

/// The text of a grammar file.
pub(super) fn grammar_text(path: &Path) -> Result<String> {
    let name = path.display().to_string();
    if path.extension().is_some_and(|ending| ending == "ramus") {
        bail!(
            "{name} is a project and no grammar: `ramus export {name}` writes its tree, with `--format lsys` its grammar and with `--sheet` a picture"
        );
    }
    let file = File::open(path).map_err(|error| unreadable(&name, &error))?;
    text_of(file, &name)
}

/// The text of a grammar on standard input, which messages call `name`.
pub(super) fn standard_input(name: &str) -> Result<String> {
    text_of(stdin().lock(), name)
}

fn unreadable(name: &str, error: &std::io::Error) -> anyhow::Error {
    anyhow!("cannot read {name} ({error}): check that it is there and may be read")
}

fn text_of(input: impl Read, name: &str) -> Result<String> {
    let mut bytes = Vec::new();
    input
        .take(MAX_GRAMMAR_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| unreadable(name, &error))?;
    if bytes.len() as u64 > MAX_GRAMMAR_BYTES {
        bail!("{name} is longer than {MAX_GRAMMAR_BYTES} bytes, and no grammar is");
    }
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        anyhow!("{name} is no UTF-8 text (byte {at}): save the grammar as UTF-8")
    })
}
