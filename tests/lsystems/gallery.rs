//! The grammars of assets/grammars: each is drawn as its file says, names its source, and stands in the guide's
//! gallery with a picture; those that the reference systems hold give their strings.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use ramus::lsystem::report::Report;
use ramus::lsystem::{Grammar, TurtleParams};
use serde_json::Value;

use super::{derive, draw, parse};

fn place(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Names without the ending, and texts.
fn files() -> Vec<(String, String)> {
    let mut files: Vec<(String, String)> = fs::read_dir(place("assets/grammars"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| {
            assert_eq!(path.extension().unwrap(), "lsys", "{}", path.display());
            let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
            (name, fs::read_to_string(path).unwrap())
        })
        .collect();
    files.sort();
    files
}

#[test]
fn every_grammar_draws_at_its_own_steps() {
    let files = files();
    assert!(files.len() >= 24, "{} grammars", files.len());
    for (name, text) in files {
        let grammar =
            Grammar::parse(&text, &name).unwrap_or_else(|errors| panic!("{name}: {errors}"));
        let steps = grammar
            .steps()
            .unwrap_or_else(|| panic!("{name} says no steps"));
        let string = derive(&grammar, steps);
        let drawing = ramus::lsystem::draw(
            &grammar,
            &string,
            &TurtleParams::default(),
            &AtomicBool::new(false),
        )
        .unwrap();
        drawing.tree.validate().unwrap();
        drawing.organs.validate(&drawing.tree).unwrap();
        assert!(!drawing.is_empty(), "{name} draws nothing");
        let (low, high) = drawing.bounds().unwrap();
        assert!(low.is_finite() && high.is_finite(), "{name}: {low} {high}");
        assert!((high - low).max_element() > 0.0, "{name} is a point");
        if name == "honda" {
            assert_eq!(string.len(), 7162, "Honda's tree after 10 steps");
        }
    }
}

#[test]
fn every_grammar_names_its_source() {
    for (name, text) in files() {
        let comment: Vec<&str> = text.lines().take_while(|l| l.starts_with('#')).collect();
        let comment = comment.join(" ");
        let has_year = comment.split(|c: char| !c.is_ascii_digit()).any(|digits| {
            digits.len() == 4 && (digits.starts_with("19") || digits.starts_with("20"))
        });
        let is_sourced =
            has_year || comment.contains("our own") || comment.contains("Algorithmic Beauty");
        assert!(is_sourced, "{name}: {comment}");
    }
}

#[test]
fn the_page_has_every_grammar_with_its_picture_and_no_other() {
    let page = fs::read_to_string(place("docs/src/gallery.md")).unwrap();
    let mut names: Vec<String> = files().into_iter().map(|(name, _)| name).collect();
    for name in &names {
        let row = format!("| ![{name}](images/gallery/{name}.png) | **{name}** · ");
        assert!(page.contains(&row), "{name} is not in the gallery");
        let picture = place(&format!("docs/src/images/gallery/{name}.png"));
        let (width, height) = image::image_dimensions(&picture).unwrap();
        assert_eq!((width, height), (256, 256), "{name}");
    }
    let mut shown: Vec<String> = fs::read_dir(place("docs/src/images/gallery"))
        .unwrap()
        .map(|entry| {
            entry
                .unwrap()
                .path()
                .file_stem()
                .unwrap()
                .to_str()
                .unwrap()
                .to_owned()
        })
        .collect();
    shown.sort();
    names.sort();
    assert_eq!(shown, names, "pictures and grammars");
    let bytes: u64 = names
        .iter()
        .map(|name| {
            let picture = place(&format!("docs/src/images/gallery/{name}.png"));
            fs::metadata(picture).unwrap().len()
        })
        .sum();
    assert!(bytes < 1_500_000, "{bytes} bytes of pictures");
}

/// File, reference system; the file's axiom may also set widths or a direction, so the reference's takes its place.
const REFERENCE: [(&str, &str); 29] = [
    ("koch-island", "koch-quadratic-island"),
    ("dragon", "dragon"),
    ("sierpinski-gasket", "sierpinski-arrowhead"),
    ("hilbert", "hilbert-2d"),
    ("weed-a", "plant-1.24a"),
    ("weed-b", "plant-1.24b"),
    ("weed-c", "plant-1.24c"),
    ("weed-d", "plant-1.24d"),
    ("weed-e", "plant-1.24e"),
    ("bush", "bush-1.25"),
    ("hogeweg-hesper-a", "hogeweg-hesper-1.31a"),
    ("hogeweg-hesper", "hogeweg-hesper-1.31b"),
    ("hogeweg-hesper-d", "hogeweg-hesper-1.31d"),
    ("row-of-trees", "row-of-trees"),
    ("branching-exponential", "branching-exp"),
    ("honda", "honda-monopodial-2.6a"),
    ("honda-b", "honda-monopodial-2.6b"),
    ("aono-kunii-a", "aono-kunii-sympodial-2.7a"),
    ("aono-kunii-b", "aono-kunii-sympodial-2.7b"),
    ("ternary", "ternary-2.8a"),
    ("ternary-b", "ternary-2.8b"),
    ("crocus", "crocus"),
    ("cordate-leaf", "leaf-cordate"),
    ("compound-leaf", "compound-leaf-D1"),
    ("compound-leaf-alternating", "compound-leaf-alternating"),
    ("phyllotaxis", "sunflower-phyllotaxis"),
    ("shedding", "cut-abscission"),
    ("anabaena", "anabaena-catenula"),
    ("fibonacci-word", "algae-fibonacci"),
];

#[test]
fn grammars_of_the_reference_systems_give_their_strings() {
    let data: Value = serde_json::from_str(include_str!("../data/lsystems.json")).unwrap();
    let systems = data["systems"].as_array().unwrap();
    for (name, id) in REFERENCE {
        let text = fs::read_to_string(place(&format!("assets/grammars/{name}.lsys"))).unwrap();
        let system = systems
            .iter()
            .find(|system| system["id"] == id)
            .unwrap_or_else(|| panic!("no reference {id}"));
        let axiom = text
            .lines()
            .find(|line| line.starts_with("axiom "))
            .unwrap();
        // The parameters of the algae as a curve are its own.
        let text = if name == "fibonacci-word" {
            text
        } else {
            let expected = system["axiom"].as_str().unwrap();
            text.replace(axiom, &format!("axiom {expected}"))
        };
        let grammar = parse(&text);
        for check in system["checks"].as_array().unwrap() {
            let steps = u32::try_from(check["n"].as_u64().unwrap()).unwrap();
            let string = derive(&grammar, steps);
            // The hash is that of the symbols; what is drawn does not matter.
            let tree = draw(&grammar, &derive(&grammar, 0));
            let report = Report::new(&grammar, &string, &tree, steps, 0.0, 0.0);
            assert_eq!(report.fnv1a64, check["fnv1a64"], "{name}, {steps} steps");
        }
    }
}
