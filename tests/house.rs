//! Holds the rules of the house that no compiler checks: short files that say what they are for, a
//! guide without dead links, a reason for every dependency.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Above this many lines there is a second idea in a file.
const LINES_MOST: usize = 700;

/// Folders with Rust code of ours.
const CODE: &[&str] = &[
    "src",
    "xr",
    "tests",
    "benches",
    "fuzz/fuzz_targets",
    "build.rs",
];

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files under `folder` (or the file itself) whose name ends in `.extension`, sorted; folders that
/// hold what was built are left out.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            let name = path.file_name().unwrap_or_default();
            if name != "target" && name != "node_modules" && name != "out" {
                open.extend(
                    fs::read_dir(&path)
                        .unwrap()
                        .map(|entry| entry.unwrap().path()),
                );
            }
        } else if path.extension().is_some_and(|found| found == extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn code_files() -> Vec<PathBuf> {
    let found: Vec<PathBuf> = CODE
        .iter()
        .flat_map(|folder| files(&repository().join(folder), "rs"))
        .collect();
    assert!(
        found.len() > 10,
        "the sources are not where this test looks"
    );
    found
}

fn shown(path: &Path) -> String {
    path.strip_prefix(repository())
        .unwrap_or(path)
        .display()
        .to_string()
}

#[test]
fn files_hold_one_idea() {
    let long: Vec<String> = code_files()
        .iter()
        .chain(&files(&repository().join("shaders"), "wgsl"))
        .filter_map(|path| {
            let lines = fs::read_to_string(path).unwrap().lines().count();
            (lines > LINES_MOST).then(|| format!("{} has {lines} lines", shown(path)))
        })
        .collect();
    assert!(
        long.is_empty(),
        "over {LINES_MOST} lines, split them:\n{}",
        long.join("\n")
    );
}

#[test]
fn modules_say_what_they_are_for() {
    let silent: Vec<String> = code_files()
        .iter()
        .filter(|path| {
            let source = fs::read_to_string(path).unwrap();
            // An attribute for the whole file may come first.
            let first = source
                .lines()
                .find(|line| !line.trim().is_empty() && !line.starts_with("#!["));
            !first.is_some_and(|line| line.starts_with("//!"))
        })
        .map(|path| shown(path))
        .collect();
    assert!(
        silent.is_empty(),
        "these open without //!:\n{}",
        silent.join("\n")
    );
}

/// Targets of the links `[…](target)` in Markdown text, fenced code left out.
fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut fenced = false;
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        }
        if fenced {
            continue;
        }
        for (at, _) in line.match_indices("](") {
            // In `code` brackets are no link.
            if line[..at].matches('`').count() % 2 == 0
                && let Some(end) = line[at + 2..].find(')')
            {
                found.push(line[at + 2..at + 2 + end].to_owned());
            }
        }
    }
    found
}

#[test]
fn links_are_found_in_markdown() {
    let text = "a [b](c.md) ![d](e/f.png) `x[1](y)`\n```\n[g](h)\n```\n[i](https://j#k)";
    assert_eq!(links(text), ["c.md", "e/f.png", "https://j#k"]);
}

/// A link between files of the repository, without its fragment; `None` where it leads outside.
fn inner(link: &str) -> Option<&str> {
    let file = link.split('#').next().unwrap_or_default();
    (!file.is_empty() && !link.contains("://") && !link.starts_with("mailto:")).then_some(file)
}

#[test]
fn the_guide_has_no_dead_links() {
    let mut pages = files(&repository().join("docs"), "md");
    pages.extend(
        ["README.md", "CHANGELOG.md", "assets/LICENSES.md"].map(|name| repository().join(name)),
    );
    let mut dead = Vec::new();
    for page in &pages {
        for link in links(&fs::read_to_string(page).unwrap()) {
            if inner(&link).is_some_and(|file| !page.parent().unwrap().join(file).exists()) {
                dead.push(format!("{}: {link}", shown(page)));
            }
        }
    }
    assert!(
        dead.is_empty(),
        "links that lead nowhere:\n{}",
        dead.join("\n")
    );
}

#[test]
fn every_page_is_in_the_summary() {
    let source = repository().join("docs/src");
    let summary = fs::read_to_string(source.join("SUMMARY.md")).unwrap();
    let listed: BTreeSet<PathBuf> = links(&summary)
        .iter()
        .filter_map(|link| inner(link).map(|file| source.join(file)))
        .collect();
    let there: BTreeSet<PathBuf> = files(&source, "md")
        .into_iter()
        .filter(|path| !path.ends_with("SUMMARY.md"))
        .collect();
    assert_eq!(listed, there, "docs/src/SUMMARY.md and the pages differ");
}

/// The packages of a workspace, as cargo describes them.
fn packages_of(manifest: &str) -> Vec<serde_json::Value> {
    let output = Command::new(env!("CARGO"))
        .args([
            "metadata",
            "--no-deps",
            "--offline",
            "--format-version",
            "1",
        ])
        .args(["--manifest-path", manifest])
        .current_dir(repository())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    match metadata["packages"].take() {
        serde_json::Value::Array(packages) => packages,
        other => panic!("no packages: {other}"),
    }
}

#[test]
fn every_dependency_has_its_reason() {
    // The peers of the benchmarks are a package of their own.
    let packages: Vec<serde_json::Value> = ["Cargo.toml", "benches/peers/Cargo.toml"]
        .into_iter()
        .flat_map(packages_of)
        .collect();
    let names = |value: &serde_json::Value| value["name"].as_str().unwrap().to_owned();
    let own: BTreeSet<String> = packages.iter().map(names).collect();
    let wanted: BTreeSet<String> = packages
        .iter()
        .flat_map(|package| {
            package["dependencies"]
                .as_array()
                .unwrap()
                .iter()
                .map(names)
        })
        .filter(|name| !own.contains(name))
        .collect();
    let page = fs::read_to_string(repository().join("docs/dependencies.md")).unwrap();
    // The first cell of a table's row holds one or more names in backquotes.
    let explained: BTreeSet<String> = page
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split(" |").next())
        .flat_map(|cell| cell.split('`').map(str::to_owned).collect::<Vec<_>>())
        .filter(|name| name.chars().any(char::is_alphanumeric))
        .collect();
    assert_eq!(
        explained, wanted,
        "docs/dependencies.md (left) and the manifests (right) differ"
    );
}
