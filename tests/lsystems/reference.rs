//! Results that several engines agree on.
//!
//! `tests/data/lsystems.json` is the repository's own copy of a part of them; where `RAMUS_SHARED` names the folder with
//! all of them, those are checked too.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use glam::Vec3;
use ramus::lsystem::Grammar;
use ramus::lsystem::report::Report;
use serde_json::Value;

use super::{derive, draw, parse, shared};

/// The grammar file of a reference system.
fn grammar_text(system: &Value) -> String {
    let mut text = String::new();
    if let Some(constants) = system["constants"].as_object() {
        for (name, value) in constants {
            let value = value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned);
            writeln!(text, "const {name} = {value}").unwrap();
        }
    }
    for list in ["ignore", "consider"] {
        if let Some(names) = system[list].as_str() {
            writeln!(text, "{list} {names}").unwrap();
        }
    }
    writeln!(text, "axiom {}", system["axiom"].as_str().unwrap()).unwrap();
    for production in system["productions"].as_array().unwrap() {
        writeln!(text, "{}", production.as_str().unwrap()).unwrap();
    }
    let geometry = system["checks"]
        .as_array()
        .into_iter()
        .flatten()
        .map(|c| &c["geometry"])
        .find(|g| g.is_object());
    if let Some(geometry) = geometry {
        writeln!(text, "angle {}\ninterpret {{", geometry["delta"]).unwrap();
        for letter in geometry["draw"]
            .as_str()
            .unwrap()
            .chars()
            .filter(|c| *c != 'F')
        {
            writeln!(text, "  {letter} -> F").unwrap();
        }
        writeln!(text, "}}").unwrap();
    }
    text
}

fn close(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance * expected.abs().max(1.0)
}

pub(super) fn check(id: &str, grammar: &Grammar, check: &Value) {
    let n = check["n"].as_u64().unwrap() as u32;
    let string = derive(grammar, n);
    let tree = draw(grammar, &string);
    let report = Report::new(grammar, &string, &tree, n, 0.0, 0.0);
    let place = format!("{id}, n = {n}");
    assert_eq!(
        report.modules,
        check["length"].as_u64().unwrap(),
        "{place}: length"
    );
    assert_eq!(
        report.fnv1a64,
        check["fnv1a64"].as_str().unwrap(),
        "{place}: symbols"
    );
    assert_eq!(
        report.max_depth,
        check["max_bracket_depth"].as_u64().unwrap(),
        "{place}: depth"
    );
    let counts: BTreeMap<String, u64> = check["counts"]
        .as_object()
        .unwrap()
        .iter()
        .map(|(k, v)| (k.clone(), v.as_u64().unwrap()))
        .collect();
    assert_eq!(report.counts, counts, "{place}: counts");
    let sums = check["param_sums"].as_object();
    assert_eq!(
        report.param_sums.len(),
        sums.map_or(0, |s| s.len()),
        "{place}: parameters"
    );
    for (name, expected) in sums.into_iter().flatten() {
        let expected = expected.as_f64().unwrap();
        let found = report.param_sums[name];
        assert!(
            (found - expected).abs() <= 1e-9 * expected.abs(),
            "{place}: {name} sums to {found}, not {expected}"
        );
    }
    if let Some(expected) = check["string"].as_str() {
        assert_eq!(string.to_text(grammar), expected, "{place}: string");
    }
    let geometry = &check["geometry"];
    if geometry.is_object() {
        assert_eq!(
            report.segments,
            geometry["segments"].as_u64().unwrap(),
            "{place}: segments"
        );
        let end = tree.position.last().unwrap().length();
        assert!(
            close(
                f64::from(end),
                geometry["end_distance"].as_f64().unwrap(),
                1e-5
            ),
            "{place}: end at {end}"
        );
        // Vertices stand at least half a step apart, so a grid of a hundredth tells them apart in f32.
        let grid = |p: &Vec3| (*p * 100.0).round().as_i64vec3().to_array();
        let distinct: BTreeSet<[i64; 3]> = tree.position.iter().map(grid).collect();
        assert_eq!(
            distinct.len() as u64,
            geometry["distinct_vertices"].as_u64().unwrap(),
            "{place}: vertices"
        );
        let mut extents: Vec<f64> = (0..3)
            .map(|i| f64::from(report.bounds.max[i]) - f64::from(report.bounds.min[i]))
            .collect();
        extents.sort_by(f64::total_cmp);
        for (found, expected) in extents
            .iter()
            .zip(geometry["bbox_extents_sorted"].as_array().unwrap())
        {
            assert!(
                close(*found, expected.as_f64().unwrap(), 1e-5),
                "{place}: extents {extents:?}"
            );
        }
    }
}

fn check_all(data: &str, least: usize) {
    let data: Value = serde_json::from_str(data).unwrap();
    let mut checks = 0;
    for system in data["systems"].as_array().unwrap() {
        let id = system["id"].as_str().unwrap();
        let text = grammar_text(system);
        let grammar = parse(&text);
        for expected in system["checks"].as_array().unwrap() {
            check(id, &grammar, expected);
            checks += 1;
        }
    }
    assert!(checks >= least, "only {checks} checks were found");
}

#[test]
fn reference_systems_of_the_repository() {
    check_all(include_str!("../data/lsystems.json"), 100);
}

#[test]
fn reference_systems_all() {
    if let Some(data) = shared("lsystems-reference.json") {
        check_all(&data, 176);
    }
}

/// ABOP Fig 1.27: the number of F is a branching process with mean 3.66^n and known spread.
#[test]
fn stochastic_moments() {
    let text = "axiom F\nF : weight 0.33 -> F[+F]F[-F]F\nF : weight 0.33 -> F[+F]F\nF : weight 0.34 -> F[-F]F\n";
    for (steps, mean, spread) in [
        (1, 3.66, 0.940_425),
        (3, 49.0279, 14.6255),
        (5, 656.758, 197.796),
    ] {
        let seeds = 400;
        let mut counts = Vec::new();
        for seed in 0..seeds {
            let grammar = parse(text).with_seed(seed);
            let string = derive(&grammar, steps);
            assert_eq!(
                string,
                derive(&grammar, steps),
                "the same seed gives the same string"
            );
            counts.push(
                string
                    .iter()
                    .filter(|m| grammar.name(m.symbol) == "F")
                    .count() as f64,
            );
        }
        let n = seeds as f64;
        let average = counts.iter().sum::<f64>() / n;
        let variance = counts.iter().map(|c| (c - average).powi(2)).sum::<f64>() / n;
        assert!(
            (average - mean).abs() < 4.0 * spread / n.sqrt(),
            "n = {steps}: mean {average}, not {mean}"
        );
        assert!(
            (variance.sqrt() / spread - 1.0).abs() < 0.2,
            "n = {steps}: spread {}, not {spread}",
            variance.sqrt()
        );
    }
    // Which of the three applied in the first step, over many seeds: chi-square with 2 degrees of freedom.
    let mut seen = BTreeMap::new();
    for seed in 0..3000 {
        let grammar = parse(text).with_seed(seed);
        *seen
            .entry(derive(&grammar, 1).to_text(&grammar))
            .or_insert(0.0) += 1.0;
    }
    let expected = [
        ("F[+F]F[-F]F", 990.0),
        ("F[+F]F", 990.0),
        ("F[-F]F", 1020.0),
    ];
    let chi: f64 = expected
        .iter()
        .map(|(s, e)| (seen[*s] - e) * (seen[*s] - e) / e)
        .sum();
    assert!(chi < 18.4, "chi-square {chi} is beyond 1 in 10,000");
}
