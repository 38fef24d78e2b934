//! Cohorts of numbers that no model has: nothing of them may stop tables, tests or pictures.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]

use glam::Vec3;

use super::told::Branch;
use super::*;
use crate::centerline::Centerline;
use crate::centerline::analysis::{Analysis, ModelFacts};
use crate::tree::{NO_PARENT, Node, Tree};

/// The analysis of a Y as JSON.
fn analysis() -> String {
    let mut tree = Tree::default();
    for (parent, position) in [
        (NO_PARENT, Vec3::ZERO),
        (0, Vec3::Y),
        (1, Vec3::new(1.0, 2.0, 0.0)),
        (1, Vec3::new(-1.0, 2.0, 0.5)),
    ] {
        tree.push(Node {
            parent,
            position,
            radius: 0.1,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    let found = Centerline {
        tree,
        ..Centerline::default()
    };
    let model = ModelFacts {
        file: "y.swc".to_owned(),
        ..ModelFacts::default()
    };
    serde_json::to_string(&Analysis::new(model, &found, false, 0)).unwrap()
}

/// The same with this in place of each number that may be any.
fn with_number(json: &str, number: &str) -> Told {
    fn replaced(value: &mut serde_json::Value, with: &serde_json::Value) {
        match value {
            serde_json::Value::Number(number) if number.is_f64() => *value = with.clone(),
            serde_json::Value::Array(all) => all.iter_mut().for_each(|one| replaced(one, with)),
            serde_json::Value::Object(all) => all.values_mut().for_each(|one| replaced(one, with)),
            _ => {}
        }
    }
    let mut value = serde_json::from_str(json).unwrap();
    replaced(&mut value, &serde_json::from_str(number).unwrap());
    Told::from_bytes(value.to_string().as_bytes()).unwrap()
}

#[test]
fn any_numbers_can_be_compared_drawn_and_written() {
    let json = analysis();
    let numbers = [
        "0.0", "-1.5", "1e308", "-1e308", "5e-324", "1e-300", "null", "1e15", "3.0",
    ];
    let told = numbers.map(|number| with_number(&json, number));
    for groups in 1..4 {
        for few in 0..told.len() {
            let models = told[few..].iter().chain(&told[few..]).enumerate();
            let models = models.map(|(place, told)| Model {
                label: format!("{place:02}"),
                group: (groups > 1).then_some(place % groups),
                told: told.clone(),
            });
            let cohort = Cohort {
                models: models.collect(),
                groups: ["a", "b", "c"][..if groups > 1 { groups } else { 0 }]
                    .iter()
                    .map(|name| (*name).to_owned())
                    .collect(),
                unknown: Vec::new(),
            };
            let comparisons = cohort.comparisons();
            for one in comparisons.iter().filter_map(|one| one.tested) {
                let [p, d] = [one.ranks.p, one.apart.d];
                assert!(
                    (0.0..=1.0).contains(&p) && (0.0..=1.0).contains(&d),
                    "{one:?}"
                );
            }
            for picture in pictures(&cohort, &comparisons) {
                for word in ["NaN", "inf"] {
                    assert!(
                        !picture.contains(word),
                        "{word} of {groups} groups from {few}"
                    );
                }
            }
            if few > 0 {
                continue; // A disk takes its time.
            }
            let folder = tempfile::tempdir().unwrap();
            write(&cohort, &comparisons, folder.path()).unwrap();
            let text = std::fs::read_to_string(folder.path().join("models.json")).unwrap();
            let rows: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
            assert_eq!(rows.len(), cohort.models.len());
        }
    }
}

#[test]
fn an_analysis_is_taken_as_it_was_made() {
    let Told::Found(facts) = Told::from_bytes(analysis().as_bytes()).unwrap() else {
        panic!("it was found");
    };
    assert_eq!(
        (
            facts.counts.branches,
            facts.branches.len(),
            facts.junctions.len()
        ),
        (3, 3, 1)
    );
    assert_eq!(
        (facts.branches[2].parent, facts.branches[2].nodes),
        (Some(0), Some([1, 3]))
    );
    let vmtk: Vec<&Branch> = facts.branches_vmtk.iter().collect();
    assert!(
        facts
            .counts_vmtk
            .is_some_and(|counts| counts.branches == vmtk.len())
    );
    assert!(
        vmtk.iter()
            .all(|one| one.definition == Definition::Vmtk && one.nodes.is_none())
    );
    assert_eq!(
        (facts.model.file.as_str(), facts.endpoints.unreached()),
        ("y.swc", 0)
    );
}

/// A seed that is refused at its beginning teaches the fuzzer nothing of what comes behind.
#[test]
fn the_seed_of_the_fuzzer_is_a_whole_analysis() {
    let seed = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus/cohort/y.json");
    let Told::Found(facts) = Told::read(&seed).unwrap() else {
        panic!("it was found");
    };
    for definition in Definition::ALL {
        assert_eq!(facts.branches_of(definition).len(), 3, "{definition:?}");
        assert!(facts.table_of(definition).is_some(), "{definition:?}");
    }
}
