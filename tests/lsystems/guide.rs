//! The guide's grammars: each is one, and each picture is that of the grammar above it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use ramus::lsystem::format;

use super::{derive, parse};

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src")
}

/// Blocks of grammars on a page: what stands after `lsys` and the text, with the line that follows the block.
fn blocks(page: &str) -> Vec<(String, String, String)> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("```lsys") {
            let text: String = lines
                .by_ref()
                .take_while(|line| !line.starts_with("```"))
                .map(|line| format!("{line}\n"))
                .collect();
            let next = lines.clone().find(|line| !line.is_empty()).unwrap_or("");
            found.push((name.trim().to_owned(), text, next.to_owned()));
        }
    }
    found
}

#[test]
fn every_grammar_of_the_guide_is_one() {
    let mut count = 0;
    for entry in fs::read_dir(source()).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|ending| ending == "md") {
            for (name, text, _) in blocks(&fs::read_to_string(&path).unwrap()) {
                count += 1;
                let read = format(&text, "guide.lsys");
                assert!(read.is_ok(), "{} {name}: {read:?}\n{text}", path.display());
            }
        }
    }
    assert!(count > 15, "{count} grammars");
}

#[test]
fn the_pictures_of_the_language_are_those_of_its_grammars() {
    let page = fs::read_to_string(source().join("language.md")).unwrap();
    let mut named = BTreeSet::new();
    for (name, text, next) in blocks(&page) {
        let Some(name) = name.split(' ').next().filter(|name| !name.is_empty()) else {
            continue;
        };
        let grammar = parse(&text);
        let string = derive(&grammar, grammar.steps().expect(name));
        assert!(string.len() > 3, "{name}");
        assert_eq!(
            next.rsplit('(').next(),
            Some(format!("images/language/{name}.png)").as_str()),
            "the picture stands below {name}"
        );
        named.insert(format!("{name}.png"));
    }
    let there: BTreeSet<String> = fs::read_dir(source().join("images/language"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(named, there, "pictures named and pictures there");
}
