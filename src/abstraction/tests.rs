//! The generator, the rules, the pruning and the fit.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]
use std::collections::HashSet;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};
use proptest::prelude::*;

use super::*;
use crate::lsystem::{Limits, ModuleString};
use crate::tree::measure::Measures;
use crate::tree::{NO_PARENT, Node, Tree};

/// The tables that the source publishes.
const DUCT: &str = include_str!("../../tests/data/tables/duct.json");
const ARTERY: &str = include_str!("../../tests/data/tables/artery.json");

fn never() -> AtomicBool {
    AtomicBool::new(false)
}

/// Some of all kinds.
fn kinds() -> Vec<Params> {
    let source = Params::default();
    vec![
        source.clone(),
        Params {
            bifurcation_probability: 1.0,
            iterations: 8.0,
            iterations_std: 3.0,
            ..source.clone()
        },
        Params {
            bifurcation_probability: 0.8,
            trifurcation_probability: 0.4,
            iterations: 9.0,
            iterations_std: 2.0,
            segment_length_std: 0.1,
            around: true,
            stem_length: 4,
            ..source.clone()
        },
        Params {
            max_order: 3,
            iterations: 12.0,
            ..source.clone()
        },
        Params {
            stem_length: 0,
            ..source
        },
    ]
}

/// The letters and the parameters of a string.
fn modules(params: &Params, string: &ModuleString) -> Vec<(String, Vec<f64>)> {
    let grammar = grammar(params).unwrap();
    let all = string.iter();
    all.map(|one| (grammar.name(one.symbol).to_owned(), one.parameters.to_vec()))
        .collect()
}

#[test]
fn trees_have_a_centerline_a_tip_and_as_many_branches_as_tips_and_junctions() {
    for (kind, params) in kinds().into_iter().enumerate() {
        for seed in 0..20 {
            let params = Params {
                seed,
                ..params.clone()
            };
            let grammar = grammar(&params).unwrap();
            let string = grammar
                .derive(steps(&params), &Limits::default(), &never())
                .unwrap();
            let all = modules(&params, &string);
            let of = |letter: &str| all.iter().filter(|one| one.0 == letter).count();
            assert_eq!((of("J"), of("S")), (0, 0), "{kind}");
            assert_eq!(of("B"), 0, "{kind}: none lives in the end");
            let lines: HashSet<u64> = all
                .iter()
                .filter(|one| one.0 == "D")
                .map(|one| one.1[0].to_bits())
                .collect();
            assert_eq!(lines.len(), of("D"), "{kind}: a number each");
            let tree = grow(&params, &Limits::default(), &never()).unwrap();
            assert_eq!(tree.segment_count(), of("I"), "{kind}");
            let measures = Measures::new(&tree);
            if measures.junctions.iter().all(|one| one.node > 0) {
                assert_eq!(
                    measures.branches.len(),
                    measures.tips + measures.junctions.len(),
                    "{kind}"
                );
            }
            // A fork without a stem may have lost a branch that died at once; all tips are ends of lines.
            assert!(measures.tips <= of("D"), "{kind}");
        }
    }
}

#[test]
fn iteration_k_of_a_longer_run_is_a_run_of_k() {
    for params in kinds() {
        let grammar = grammar(&params).unwrap();
        let limits = Limits::default();
        let mut string = grammar.derive(0, &limits, &never()).unwrap();
        for step in 1..=steps(&params) {
            string = grammar
                .derive_next(&string, step, &limits, &never())
                .unwrap();
            let whole = grammar.derive(step, &limits, &never()).unwrap();
            assert_eq!(string.to_text(&grammar), whole.to_text(&grammar), "{step}");
        }
    }
}

#[test]
fn a_segment_takes_two_iterations_and_every_segment_thickens() {
    let params = Params {
        bifurcation_probability: 1.0,
        iterations: 20.0,
        upwards_angle_std: 0.0,
        ..Params::default()
    };
    let grammar = grammar(&params).unwrap();
    // Two branches, then each forks in every second iteration.
    for (iteration, segments) in [(0, 0), (1, 2), (2, 2), (3, 6), (4, 6), (5, 14)] {
        let string = grammar
            .derive(iteration, &Limits::default(), &never())
            .unwrap();
        let all = modules(&params, &string);
        let of_tree: Vec<_> = all.iter().filter(|one| one.0 == "I").collect();
        assert_eq!(of_tree.len(), 1 + segments, "{iteration}");
        let stem = params.segment_radius + f64::from(iteration) * params.radial_increment;
        assert!((of_tree[0].1[1] - stem).abs() < 1e-12);
    }
}

#[test]
fn tips_of_higher_order_fork_sooner() {
    // Four segments at order 0, ⌊3 / 2⌋ + 1 = 2 at order 1, and so on.
    let params = Params {
        bifurcation_probability: 1.0,
        max_order: 3,
        iterations: 9.0,
        ..Params::default()
    };
    let tree = grow(&params, &Limits::default(), &never()).unwrap();
    let measures = Measures::new(&tree);
    let segments = |generation: u32| -> Vec<usize> {
        let all = measures
            .branches
            .iter()
            .filter(|one| one.order == generation);
        all.map(|one| one.nodes.len() - 1).collect()
    };
    assert_eq!(segments(1), [4, 4]);
    assert_eq!(segments(2), [2; 4]);
}

#[test]
fn the_published_tables_have_the_published_parameters() {
    for (table, iterations, std, length, radius, stem, angle) in [
        (DUCT, 10.0, 3.86, 63.96, 14.46, 4, 62.81 / 2.0),
        (ARTERY, 14.0, 2.4, 17.25, 6.39, 2, 22.2),
    ] {
        let table = Table::read(table).unwrap();
        let found = table.table.iterations.unwrap();
        assert!((2.0 * found.mean - iterations).abs() < 0.5, "{found:?}");
        let params = rules::params(&table, 7);
        assert_eq!(
            (params.iterations, params.stem_length, params.seed),
            (iterations, stem, 7)
        );
        assert!(
            (params.iterations_std - std).abs() < 0.01,
            "{}",
            params.iterations_std
        );
        assert_eq!(
            (params.segment_length, params.segment_radius),
            (length, radius)
        );
        assert!((params.bifurcation_angle - angle).abs() < 1e-9);
        assert_eq!((params.bifurcation_probability, params.max_order), (1.0, 0));
        assert_eq!(
            params.segment_length_std,
            table.table.branch_length.unwrap().std.unwrap()
        );
        params.check().unwrap();
    }
}

#[test]
fn numbers_beyond_their_limits_are_named() {
    type Change = fn(&mut Params);
    let changes: [(&str, Change); 7] = [
        ("iterations", |p| p.iterations = 51.0),
        ("iterations", |p| p.iterations = f64::NAN),
        ("bifurcation_probability", |p| {
            p.bifurcation_probability = 1.5
        }),
        ("radial_segments", |p| p.radial_segments = 2),
        ("upwards_angle", |p| p.upwards_angle = -181.0),
        ("segment_length", |p| p.segment_length = 0.0),
        ("bounding_ellipsoid", |p| {
            p.bounding_ellipsoid = Some([1.0, -1.0, 1.0])
        }),
    ];
    for (name, change) in changes {
        let mut params = Params::default();
        change(&mut params);
        let said = grammar(&params).unwrap_err().to_string();
        assert!(
            said.starts_with(&format!("{name} is ")) && said.contains("it must be from"),
            "{said}"
        );
    }
}

#[test]
fn a_tree_that_explodes_is_an_error_and_not_a_full_memory() {
    let params = Params {
        bifurcation_probability: 1.0,
        iterations: 50.0,
        ..Params::default()
    };
    let limits = Limits {
        modules: 100_000,
        bytes: 1 << 28,
    };
    let said = grow(&params, &limits, &never()).unwrap_err().to_string();
    assert!(
        said.contains("100000") || said.contains("100,000"),
        "{said}"
    );
    let stopped = AtomicBool::new(true);
    assert!(grow(&params, &limits, &stopped).is_err());
}

#[test]
fn tables_that_say_too_little_or_nonsense_are_refused() {
    for (text, part) in [
        ("", "it is no table"),
        ("[1, 2]", "it is no table"),
        (r#"{"format": "x", "table": {}}"#, "its format is \"x\""),
        (
            r#"{"format": "ramus-table/1", "table": {"branch_length": {"mean": 1}}}"#,
            "how many centerlines",
        ),
        (
            r#"{"format": "ramus-table/1", "counts": {"centerlines": 4}, "table": {}}"#,
            "how long branches are",
        ),
        (
            r#"{"format": "ramus-table/1", "counts": {"centerlines": 4}, "table": {"branch_length": {"mean": -1}}}"#,
            "above 0",
        ),
        (
            r#"{"format": "ramus-table/1", "counts": {"centerlines": 4}, "table": {"branch_length": {"mean": 1, "std": -1}}}"#,
            "0 or more",
        ),
        (
            r#"{"format": "ramus-table/1", "counts": {"centerlines": 4}, "table": {"branch_length": {"mean": 1e999}}}"#,
            "it is no table",
        ),
    ] {
        let said = Table::read(text).unwrap_err().to_string();
        assert!(said.contains(part), "{text}: {said}");
    }
    for (counts, branch, part) in [
        (
            r#"{"centerlines": 4}"#,
            "1e12",
            "segment_radius is 100000000000: it must be from 0.000000001 to 1000000000",
        ),
        (
            r#"{"centerlines": 4000000000}"#,
            "1",
            "an L-system is made of 10000 at most",
        ),
    ] {
        let text = format!(
            r#"{{"format": "ramus-table/1", "counts": {counts}, "table": {{"branch_length": {{"mean": {branch}}}}}}}"#
        );
        let table = Table::read(&text).unwrap();
        let params = FitParams::default();
        let said = fit(&table, &params, &never(), &mut |_, _, _| {})
            .unwrap_err()
            .to_string();
        assert!(said.contains(part), "{said}");
    }
    let one = r#"{"format": "ramus-table/1", "counts": {"centerlines": 1}, "table": {"branch_length": {"mean": 1}}}"#;
    let table = Table::read(one).unwrap();
    let said = fit(&table, &FitParams::default(), &never(), &mut |_, _, _| {})
        .unwrap_err()
        .to_string();
    assert!(said.contains("there are no forks"), "{said}");
}

/// As the program does it, but slowly.
fn pruned_slowly(tree: &Tree) -> Vec<bool> {
    let place = |node: u32| tree.position[node as usize].as_dvec3();
    let mut kept = vec![false; tree.len()];
    let mut built: Vec<(u32, u32)> = Vec::new();
    for node in (0_u32..).take(tree.len()) {
        let parent = tree.parent[node as usize];
        if parent == NO_PARENT {
            kept[node as usize] = true;
            continue;
        }
        let radius = |node: u32| f64::from(tree.radius[node as usize]);
        let is_free = built.iter().all(|(from, to)| {
            let is_kin = *to == parent || *from == parent;
            is_kin
                || between([place(parent), place(node)], [place(*from), place(*to)])
                    >= radius(node) + radius(*to)
        });
        if kept[parent as usize] && is_free {
            kept[node as usize] = true;
            built.push((parent, node));
        }
    }
    kept
}

/// How far two straight pieces are from each other: the least over one of the distance to the other, which has one least place.
fn between([a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> f64 {
    let to_other = |s: f64| {
        let (point, along) = (a.lerp(b, s), d - c);
        let t = ((point - c).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
        point.distance(c + t * along)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..100 {
        let (one, other) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if to_other(one) < to_other(other) {
            high = other;
        } else {
            low = one;
        }
    }
    to_other(f64::midpoint(low, high))
}

fn any_tree() -> impl Strategy<Value = Tree> {
    let node = (
        any::<prop::sample::Index>(),
        prop::array::uniform3(-1.0_f32..1.0),
        0.01_f32..0.15,
    );
    prop::collection::vec(node, 2..40).prop_map(|nodes| {
        let mut tree = Tree {
            letters: vec!["I".to_owned()],
            ..Tree::default()
        };
        for (place, (parent, step, radius)) in nodes.into_iter().enumerate() {
            let parent = match place {
                0 => NO_PARENT,
                some => u32::try_from(parent.index(some)).unwrap(),
            };
            let from = if place == 0 {
                Vec3::ZERO
            } else {
                tree.position[parent as usize]
            };
            tree.push(Node {
                parent,
                position: from + Vec3::from(step),
                radius,
                letter: 0,
                order: 0,
                birth: 0,
            });
        }
        tree
    })
}

proptest! {
    #[test]
    fn pruning_leaves_what_the_slow_way_leaves(tree in any_tree()) {
        let slow = pruned_slowly(&tree);
        let fast = pruned(&tree, true, None);
        prop_assert_eq!(fast.len(), slow.iter().filter(|kept| **kept).count());
        let kept = tree.position.iter().zip(&slow).filter(|(_, kept)| **kept).map(|(place, _)| place);
        prop_assert!(fast.position.iter().eq(kept));
        fast.validate().unwrap();
        prop_assert_eq!(pruned(&tree, false, None).len(), tree.len());
    }

    #[test]
    fn an_ellipsoid_holds_all_that_is_left(tree in any_tree(), radii in prop::array::uniform3(0.2_f64..2.0)) {
        let left = pruned(&tree, false, Some(radii));
        let root = left.position[0].as_dvec3();
        for place in left.position.iter() {
            prop_assert!(((place.as_dvec3() - root) / DVec3::from(radii)).length() <= 1.0 + 1e-9);
        }
    }
}

#[test]
fn the_published_tables_are_met() {
    for (name, table) in [("duct", DUCT), ("artery", ARTERY)] {
        let table = Table::read(table).unwrap();
        let params = FitParams {
            candidates: 10_000,
            ..FitParams::default()
        };
        let mut told = Vec::new();
        let found = fit(&table, &params, &never(), &mut |done, of, best| {
            told.push((done, of, best.first().map(|best| best.distance)));
        })
        .unwrap();
        let best = &found.ranked[0];
        for one in &best.differences {
            assert!(one.matches(), "{name}: {one:?}");
        }
        let ruled = found.by_rules.unwrap();
        assert!(best.distance < ruled.distance / 4.0, "{name}");
        assert!(found.ranked.is_sorted_by(|a, b| a.distance <= b.distance));
        // What is told of the best is what its grammar grows.
        let tree = grow(&best.params, &Limits::default(), &never()).unwrap();
        assert_eq!(Table::of(&Measures::new(&tree)), best.table, "{name}");
        assert_eq!(told.first().map(|one| one.0), Some(0));
        assert!(
            told.windows(2)
                .all(|pair| pair[1].2 <= pair[0].2 || pair[0].2.is_none())
        );
    }
}

#[test]
fn a_table_whose_rules_explode_is_fitted_all_the_same() {
    // Fifty iterations of sure forks are a million tips; the model has twelve.
    let text = r#"{"format": "ramus-table/1", "counts": {"centerlines": 12}, "table": {"branch_length": {"mean": 2, "std": 0.5},
        "iterations": {"mean": 40, "std": 0}}}"#;
    let table = Table::read(text).unwrap();
    let params = FitParams {
        candidates: 1_500,
        ..FitParams::default()
    };
    let found = fit(&table, &params, &never(), &mut |_, _, _| {}).unwrap();
    assert!(found.by_rules.is_none());
    assert_eq!(found.ranked[0].table.counts.centerlines, Some(12));
}

#[test]
fn one_seed_gives_one_fit_for_any_number_of_threads() {
    let table = Table::read(DUCT).unwrap();
    let params = FitParams {
        candidates: 1_000,
        seed: 3,
        ..FitParams::default()
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let found = pool
            .install(|| fit(&table, &params, &never(), &mut |_, _, _| {}))
            .unwrap();
        let bits = |one: &Candidate| (one.params.clone(), one.distance.to_bits());
        found.ranked.iter().map(bits).collect::<Vec<_>>()
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_fit_that_is_stopped_gives_what_it_has() {
    let table = Table::read(DUCT).unwrap();
    let params = FitParams {
        candidates: 1_000_000,
        ..FitParams::default()
    };
    let cancel = AtomicBool::new(false);
    let found = fit(&table, &params, &cancel, &mut |_, _, best| {
        cancel.store(!best.is_empty(), std::sync::atomic::Ordering::Relaxed);
    })
    .unwrap();
    assert!(found.stopped && !found.ranked.is_empty());
    let cancel = AtomicBool::new(true);
    assert!(fit(&table, &params, &cancel, &mut |_, _, _| {}).is_err());
}
