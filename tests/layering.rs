//! Holds the order of the rooms: a room imports only rooms below it.
//!
//! The checker reads source text as tokens (comments, strings and characters taken out), finds
//! every path that leads into a room (`crate::room`, `ramus::room`, and `super::…` where it climbs
//! out of the room; groups in `use` included) and every name of a crate that a room must not know.
//! Tokens, not `use` lines alone, so that a path written out in a function counts too. A parser of
//! the whole language would see no more and would double the time to build the tests.
//!
//! The last test turns the checker on made-up sources, so that it is known to find what it looks for.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

mod layering {
    pub(crate) mod made_up;
    pub(crate) mod tokens;
}

use std::{
    fs,
    path::{Path, PathBuf},
};

use layering::{
    made_up::MADE_UP,
    tokens::{Token, tokens},
};

/// A room, how high it stands, and what it must not name.
struct Room {
    name: &'static str,
    /// A room may import only rooms with a smaller number.
    level: u32,
    /// Whether Vulkan, OpenXR, egui and windows are its business.
    pure: bool,
    /// Crates that it must not name in any case.
    banned: &'static [&'static str],
}

/// The crates that no room below `render` names.
const DEVICES: &[&str] = &[
    "ash",
    "openxr",
    "egui",
    "gpu_allocator",
    "ramus_xr",
    "winit",
    "ash_window",
    "raw_window_handle",
];

const ROOMS: &[Room] = &[
    pure("tree", 0),
    pure("mesh", 1),
    pure("lsystem", 1),
    pure("centerline", 2),
    pure("abstraction", 2),
    pure("sketch", 2),
    pure("world", 3),
    Room {
        name: "render",
        level: 4,
        pure: false,
        banned: &["openxr", "ramus_xr", "winit"],
    },
    Room {
        name: "ui",
        level: 4,
        pure: false,
        banned: &["ash", "openxr", "gpu_allocator", "ramus_xr", "winit"],
    },
    Room {
        name: "app",
        level: 5,
        pure: false,
        banned: &["openxr"],
    },
    Room {
        name: "cli",
        level: 6,
        pure: false,
        banned: &["openxr", "gpu_allocator", "winit"],
    },
];

const fn pure(name: &'static str, level: u32) -> Room {
    Room {
        name,
        level,
        pure: true,
        banned: &[],
    }
}

/// What `render` may know of `world`: the scene and nothing of tools, documents or input.
const RENDER_SEES_OF_WORLD: &[&str] = &["scene"];

fn room(name: &str) -> Option<&'static Room> {
    ROOMS.iter().find(|room| room.name == name)
}

/// A path into a room: the room, the next name where there is one, and the line.
#[derive(Debug, PartialEq)]
struct Reach<'a> {
    room: &'a str,
    next: Option<&'a str>,
    line: usize,
}

/// Finds the paths that lead into rooms. `module` is the file's own module path, room first.
fn reaches<'a>(tokens: &[Token<'a>], module: &[&'a str]) -> Vec<Reach<'a>> {
    let text = |at: usize| tokens.get(at).map_or("", |token| token.text);
    let mut found = Vec::new();
    // Modules written inside the file, each with the depth of braces at which it ends.
    let mut inline: Vec<(&str, usize)> = Vec::new();
    let mut depth = 0_usize;
    for at in 0..tokens.len() {
        match text(at) {
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                if inline.last().is_some_and(|(_, ends)| *ends == depth) {
                    inline.pop();
                }
            }
            "mod" if text(at + 2) == "{" => inline.push((text(at + 1), depth)),
            "crate" | "ramus" | "super"
                if text(at + 1) == "::" && (at == 0 || text(at - 1) != "::") =>
            {
                let mut base: Vec<&str> = Vec::new();
                let mut here = at;
                if text(at) == "super" {
                    base.extend(module);
                    base.extend(inline.iter().map(|(name, _)| *name));
                    while text(here) == "super" && text(here + 1) == "::" {
                        base.pop();
                        here += 2;
                    }
                } else {
                    here += 2;
                }
                heads(tokens, here, &base, &mut found);
            }
            _ => {}
        }
    }
    found
}

/// Follows a path or a group at `at` from the module `base` as far as the second name.
fn heads<'a>(tokens: &[Token<'a>], at: usize, base: &[&'a str], found: &mut Vec<Reach<'a>>) {
    let text = |at: usize| tokens.get(at).map_or("", |token| token.text);
    if text(at) == "{" {
        let mut depth = 1_usize;
        let mut here = at + 1;
        let mut begins = true;
        while depth > 0 && here < tokens.len() {
            match text(here) {
                "{" => depth += 1,
                "}" => depth -= 1,
                "," if depth == 1 => begins = true,
                _ if depth == 1 && begins => {
                    heads(tokens, here, base, found);
                    begins = false;
                }
                _ => {}
            }
            here += 1;
        }
        return;
    }
    let mut path = base.to_vec();
    let mut here = at;
    let line = tokens.get(at).map_or(0, |token| token.line);
    while path.len() < 2 {
        let name = text(here);
        if !name.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            break;
        }
        if name != "self" {
            path.push(name);
        }
        if text(here + 1) != "::" {
            break;
        }
        here += 2;
        if text(here) == "{" && path.len() < 2 {
            // `crate::{world::{scene, input}}`: each name of the group on its own.
            heads(tokens, here, &path, found);
            return;
        }
    }
    if let Some(first) = path.first().filter(|name| room(name).is_some()) {
        found.push(Reach {
            room: first,
            next: path.get(1).copied(),
            line,
        });
    }
}

/// Everything that a file of `src/` does against the order. `path` is relative to `src/`.
fn check_source(path: &str, source: &str) -> Vec<String> {
    let parts: Vec<&str> = path.trim_end_matches(".rs").split('/').collect();
    let mut module = parts.clone();
    if module.last() == Some(&"mod") {
        module.pop();
    }
    let tokens = tokens(source);
    let Some(own) = room(parts[0]) else {
        return vec![format!(
            "src/{path}: {} is no room yet: give it its place in tests/layering.rs and in docs/src/architecture.md",
            parts[0]
        )];
    };
    let mut wrong = Vec::new();
    for reach in reaches(&tokens, &module) {
        let other = room(reach.room).unwrap();
        if other.name != own.name && other.level >= own.level {
            wrong.push(format!(
                "src/{path}:{}: {} reaches up to {}",
                reach.line, own.name, other.name
            ));
        }
        if own.name == "render"
            && other.name == "world"
            && !reach
                .next
                .is_some_and(|next| RENDER_SEES_OF_WORLD.contains(&next))
        {
            wrong.push(format!(
                "src/{path}:{}: render sees of world only {RENDER_SEES_OF_WORLD:?}, not {:?}",
                reach.line, reach.next
            ));
        }
    }
    let banned: Vec<&str> = own
        .banned
        .iter()
        .chain(if own.pure { DEVICES } else { &[] })
        .copied()
        .collect();
    wrong.extend(names_crates(&tokens, &banned, &format!("src/{path}")));
    if own.name != "render" {
        wrong.extend(unsafe_code(&tokens, &format!("src/{path}")));
    }
    wrong
}

/// Complaints about each crate of `banned` that the tokens name.
fn names_crates(tokens: &[Token<'_>], banned: &[&str], place: &str) -> Vec<String> {
    tokens
        .iter()
        .enumerate()
        .filter(|(at, token)| {
            let before = |steps: usize| at.checked_sub(steps).map_or("", |at| tokens[at].text);
            let after = tokens.get(at + 1).map_or("", |token| token.text);
            // A crate's name heads a path (`::egui` too) or is imported whole; in `self.egui` and
            // `crate::ui::egui` it is another name.
            let rooted = before(1) == "::"
                && matches!(before(2), "" | "use" | "(" | "<" | "," | ":" | "=" | "&");
            let inner = matches!(before(1), "::" | ".") && !rooted;
            // Vulkan's handles between a headset and the renderer: nothing of OpenXR is in there.
            let part = tokens.get(at + 2).map_or("", |token| token.text);
            if place.starts_with("src/render/") && token.text == "ramus_xr" && part == "vulkan" {
                return false;
            }
            banned.contains(&token.text)
                && !inner
                && (rooted || after == "::" || matches!(before(1), "use" | "crate"))
        })
        .map(|(_, token)| format!("{place}:{}: must not name {}", token.line, token.text))
        .collect()
}

/// Complaints about each use of `unsafe`.
fn unsafe_code(tokens: &[Token<'_>], place: &str) -> Vec<String> {
    tokens
        .iter()
        .filter(|token| token.text == "unsafe")
        .map(|token| {
            format!(
                "{place}:{}: unsafe belongs to src/render and xr only",
                token.line
            )
        })
        .collect()
}

/// All Rust files under `folder`, sorted.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Complaints about `path`, relative to `folder`, by `check`.
fn complaints(folder: &Path, check: impl Fn(&str, &str) -> Vec<String>) -> Vec<String> {
    let files = rust_files(folder);
    assert!(!files.is_empty(), "no sources under {}", folder.display());
    files
        .iter()
        .flat_map(|path| {
            let relative = path
                .strip_prefix(folder)
                .unwrap()
                .to_str()
                .unwrap()
                .to_owned();
            check(&relative, &fs::read_to_string(path).unwrap())
        })
        .collect()
}

#[test]
fn rooms_import_only_rooms_below_them() {
    let wrong = complaints(&repository().join("src"), |path, source| {
        // The roots only declare the rooms.
        if matches!(path, "lib.rs" | "main.rs") {
            return unsafe_code(&tokens(source), &format!("src/{path}"));
        }
        check_source(path, source)
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn headsets_know_nothing_of_ramus() {
    let wrong = complaints(&repository().join("xr/src"), |path, source| {
        names_crates(
            &tokens(source),
            &["ramus", "egui", "gpu_allocator", "winit"],
            &format!("xr/src/{path}"),
        )
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let manifest = fs::read_to_string(repository().join("xr/Cargo.toml")).unwrap();
    assert!(
        !manifest
            .lines()
            .any(|line| line.trim_start().starts_with("ramus ") || line.starts_with("ramus.")),
        "xr/Cargo.toml must not depend on ramus"
    );
}

#[test]
fn rooms_without_devices_forbid_unsafe_code() {
    let root = fs::read_to_string(repository().join("src/lib.rs")).unwrap();
    let lines: Vec<&str> = root.lines().collect();
    for room in ROOMS.iter().filter(|room| room.pure || room.name == "ui") {
        let Some(at) = lines
            .iter()
            .position(|line| *line == format!("pub mod {};", room.name))
        else {
            continue; // not opened yet
        };
        assert_eq!(
            lines[at - 1],
            "#[forbid(unsafe_code)]",
            "src/lib.rs: {} lost its forbid",
            room.name
        );
    }
}

#[test]
fn the_checker_finds_what_it_looks_for() {
    for (path, source, expected) in MADE_UP {
        let wrong = check_source(path, source);
        assert_eq!(wrong.len(), expected.len(), "{path}: {source}: {wrong:?}");
        for (complaint, part) in wrong.iter().zip(*expected) {
            assert!(
                complaint.contains(part),
                "{path}: {source}: {complaint} lacks {part}"
            );
        }
    }
}
