//! Lines that end, and ends that keep away from other wood.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    reason = "a test fails by panic, and its numbers are small"
)]

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};
use proptest::prelude::*;

use super::*;
use crate::sketch::{Grown, Letter, NodeRef, SelfSimilar, grow};
use crate::tree::{NO_PARENT, Tree};

/// A trunk of three segments with a branch at its first node that carries copies of itself.
fn sketch(copies: Option<u32>) -> Sketch {
    let up: Vec<Vec3> = (1..=3).map(|k| Vec3::Y * 0.2 * k as f32).collect();
    let (sketch, _) = Sketch::default().add_segments(NodeRef::ROOT, &up).unwrap();
    let at = NodeRef::new(Letter::TRUNK, 1);
    let out = [Vec3::new(0.2, 0.3, 0.0), Vec3::new(0.4, 0.4, 0.02)];
    let (sketch, apex) = sketch.add_segments(at, &out).unwrap();
    let copies = copies.map(|depth| SelfSimilar {
        rate: 2,
        depth_limit: Some(depth),
    });
    sketch.with_self_similar(apex.letter, copies).unwrap()
}

fn grown(sketch: &Sketch, habit: Habit, step: u32) -> Grown {
    let sketch = sketch.with_habit(habit).unwrap();
    grow(&sketch, step, &AtomicBool::new(false)).unwrap()
}

/// Segments of each line, the longest where there are several: by where on its parent's line it begins, counted in nodes, the trunk at 0.
fn lines(tree: &Tree, of_order: u16) -> BTreeMap<usize, usize> {
    let mut along = vec![0_usize; tree.len()];
    let mut begins = vec![0_usize; tree.len()];
    let mut found = BTreeMap::new();
    for node in 0..tree.len() {
        let parent = tree.parent[node];
        if parent == NO_PARENT {
            continue;
        }
        let below = parent as usize;
        let goes_on = tree.order[below] == tree.order[node] && tree.parent[below] != NO_PARENT;
        along[node] = if goes_on { along[below] + 1 } else { 1 };
        begins[node] = match (goes_on, tree.order[node]) {
            (true, _) => begins[below],
            (false, 0) => 0,
            (false, _) => along[below],
        };
        if tree.order[node] == of_order {
            let longest = found.entry(begins[node]).or_insert(0);
            *longest = along[node].max(*longest);
        }
    }
    found
}

/// What the formula in the module says of a branch at a node of a line of n segments.
fn segments(habit: &Habit, node: f64, n: f64) -> usize {
    if habit.reach == 0.0 {
        return habit.length.ceil() as usize;
    }
    let peak = habit.peak;
    let rises = if peak > 0.0 {
        (node / (n * peak)).powf(peak / (1.0 - peak))
    } else {
        1.0
    };
    (habit.reach * (n - node) / (1.0 - peak) * rises).ceil() as usize
}

#[test]
fn lines_end_where_the_law_says() {
    for (length, reach, peak) in [
        (8.0, 0.0, 0.0),
        (12.0, 0.5, 0.0),
        (12.0, 1.0, 0.0),
        (12.0, 0.7, 0.5),
        (16.0, 0.4, 0.25),
        (16.0, 0.6, 0.9),
        (1.0, 1.0, 0.3),
    ] {
        let habit = Habit {
            length,
            reach,
            peak,
            ..Habit::default()
        };
        // Far beyond the end: all lines are as long as they become.
        let tree = grown(&sketch(None), habit.clone(), 60).tree;
        assert_eq!(lines(&tree, 0), BTreeMap::from([(0, length as usize)]));
        let expected =
            (1..length as usize).map(|node| (node, segments(&habit, node as f64, length)));
        assert_eq!(
            lines(&tree, 1),
            expected.collect(),
            "{length} {reach} {peak}"
        );
        let later = grown(&sketch(None), habit, 70).tree;
        assert_eq!(later, tree, "it has ended");
    }
}

#[test]
fn the_longest_branch_stands_at_the_peak_and_cones_are_straight() {
    let of = |peak: f64| {
        let habit = Habit {
            length: 40.0,
            reach: 1.0,
            peak,
            ..Habit::default()
        };
        lines(&grown(&sketch(None), habit, 90).tree, 1)
    };
    for peak in [0.25, 0.5, 0.75] {
        let by_node = of(peak);
        let most = *by_node.values().max().unwrap();
        let longest: Vec<usize> = (by_node.iter())
            .filter(|(_, segments)| **segments == most)
            .map(|(node, _)| *node)
            .collect();
        let middle = longest.iter().sum::<usize>() as f64 / longest.len() as f64;
        assert!((middle / 40.0 - peak).abs() < 0.05, "{peak}: {longest:?}");
        assert_eq!(most, 40, "reach 1: as many as the trunk");
    }
    let cone: Vec<usize> = of(0.0).into_values().collect();
    assert!(
        cone.windows(2).all(|pair| pair[0] == pair[1] + 1),
        "{cone:?}"
    );
    assert_eq!(*cone.last().unwrap(), 1, "no bare leader");
}

/// Copies of copies follow the line that they stand on, not the trunk.
#[test]
fn copies_are_short_on_short_branches() {
    let habit = Habit {
        length: 20.0,
        reach: 0.5,
        ..Habit::default()
    };
    let tree = grown(&sketch(Some(2)), habit, 60).tree;
    let longest = |order: u16| lines(&tree, order).into_values().max().unwrap();
    assert_eq!([0, 1, 2, 3].map(longest), [20, 10, 4, 1]);
}

#[test]
fn new_laws_stand_in_the_grammar_and_at_0_they_do_not() {
    let plain = sketch(Some(2));
    let text = |habit: Habit| plain.with_habit(habit).unwrap().grammar_text();
    let with = |change: &dyn Fn(&mut Habit)| {
        let mut habit = Habit::default();
        change(&mut habit);
        text(habit)
    };
    assert_eq!(with(&|_| ()), plain.grammar_text());
    // What says nothing without `length` is not there.
    let idle = with(&|habit| (habit.reach, habit.peak) = (0.5, 0.5));
    for word in ["const reach", "const peak", "n)"] {
        assert!(!idle.contains(word), "{word}: {idle}");
    }
    let ends = with(&|habit| (habit.length, habit.reach, habit.dominance) = (9.0, 0.5, 0.2));
    for line in [
        "const length = 9",
        "const reach = 0.5",
        "axiom A(0, length) B",
        "A(x, n) > B : x+1 < n -> A(x, n) A(x+1, n)",
        "C(x, d, n) > B : x+1 < n, weight 1 - dominance -> C(x, d, n) C(x+1, d, n)",
        "C(x, d, n) > B : x >= 0, weight dominance -> C(x, d, n)",
    ] {
        assert!(ends.lines().any(|found| found == line), "{line}: {ends}");
    }
    assert!(ends.contains("C(0, 0, reach * (n-x-1)) B ]"), "{ends}");
    let room = with(&|habit| habit.crowd = 0.5);
    for line in [
        "A(x) > B ?C(c, r) : c < r -> A(x)",
        "A(x) > B -> A(x) A(x+1)",
        "B > ?C(c, r) : c < r -> *",
        "?C(c, r) : c < r -> *",
    ] {
        assert!(room.lines().any(|found| found == line), "{line}: {room}");
    }
    let both = with(&|habit| (habit.crowd, habit.starve) = (0.5, 0.1));
    assert!(both.contains("B ?S(1, leafage) ?C(room, room)"), "{both}");
}

/// Metres between a place and a segment.
fn apart(place: DVec3, [from, to]: [DVec3; 2]) -> f64 {
    let along = to - from;
    let part = ((place - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    place.distance(from + along * part)
}

/// By brute force: of each tip how far the nearest wood is that is neither of its line nor of its parent's.
fn clearances(tree: &Tree) -> Vec<(u32, f64)> {
    let mut line = vec![0_usize; tree.len()];
    let mut parent_line = vec![usize::MAX; tree.len()];
    let mut bears = vec![false; tree.len()];
    for node in 1..tree.len() {
        let below = tree.parent[node] as usize;
        bears[below] = true;
        (line[node], parent_line[node]) = if tree.order[node] == tree.order[below] {
            (line[below], parent_line[below])
        } else {
            (node, line[below])
        };
    }
    let at = |node: usize| tree.position[node].as_dvec3();
    let tips = (1..tree.len()).filter(|node| !bears[*node]);
    let of = |tip: usize| {
        let others = (1..tree.len())
            .filter(|node| line[*node] != line[tip] && line[*node] != parent_line[tip]);
        let far = others.map(|node| apart(at(tip), [at(tree.parent[node] as usize), at(node)]));
        (tree.birth[tip], far.fold(f64::INFINITY, f64::min))
    };
    tips.map(of).collect()
}

/// An end goes on if, and only if, it had room: told by trees of successive steps.
#[test]
fn crowded_ends_die_and_free_ends_grow() {
    let plain = sketch(Some(3));
    let free = grown(&plain, Habit::default(), 14).tree.segment_count();
    let mut before = usize::MAX;
    for crowd in [0.6, 0.7, 1.2] {
        let habit = Habit {
            crowd,
            ..Habit::default()
        };
        let text = plain.with_habit(habit.clone()).unwrap().grammar_text();
        let room: f64 = (text.lines())
            .find_map(|line| line.strip_prefix("const room = "))
            .unwrap()
            .parse()
            .unwrap();
        let mut dead = 0;
        let mut tree = grown(&plain, habit.clone(), 1).tree;
        for step in 2..=14 {
            let next = grown(&plain, habit.clone(), step).tree;
            // Alive are those that grew last; of them the ones with room grow on, and no others.
            let tips = clearances(&tree);
            let alive = tips.iter().filter(|(birth, _)| *birth == step - 1);
            let with_room = alive.clone().filter(|(_, far)| *far >= room).count();
            let grew_on = (1..next.len()).filter(|node| {
                let below = next.parent[*node] as usize;
                let is_end =
                    next.birth[below] == step - 1 && next.order[below] == next.order[*node];
                next.birth[*node] == step && is_end
            });
            assert_eq!(grew_on.count(), with_room, "{crowd}, step {step}");
            dead += alive.count() - with_room;
            tree = next;
        }
        assert!(dead > 0, "{crowd}");
        let segments = tree.segment_count();
        assert!(
            segments < free && segments < before,
            "{crowd}: {segments} of {free}"
        );
        before = segments;
    }
}

#[test]
fn projects_keep_them() {
    let habit = Habit {
        length: 12.3456,
        crowd: 0.25,
        ..Habit::default()
    };
    assert!(habit.has_later_laws() && habit.is_uncertain());
    let text = serde_json::to_string(&habit.quantized()).unwrap();
    assert!(text.contains("\"length\":12.346,\"crowd\":0.25") && !text.contains("reach"));
    let plain = serde_json::to_string(&Habit::default()).unwrap();
    for word in ["length", "reach", "peak", "crowd"] {
        assert!(!plain.contains(word), "{word}: {plain}");
    }
    assert_eq!(
        serde_json::from_str::<Habit>(&plain).unwrap(),
        Habit::default()
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever the laws, lines are no longer than they may be, and a tree of fewer steps is part of one of more.
    #[test]
    fn no_line_is_longer_than_its_law(
        length in 1.0..12.0_f64, reach in 0.0..1.0_f64, peak in 0.0..0.9_f64, crowd in 0.0..0.6_f64, seed in 0_u32..99,
    ) {
        let habit = Habit { length, reach, peak, crowd, seed, wander_deg: 9.0, dominance: 0.2, ..Habit::default() }.quantized();
        // As they are kept: the least of a number may be none.
        let (length, reach) = (habit.length, habit.reach);
        let tree = grown(&sketch(Some(2)), habit.clone(), 16).tree;
        tree.validate().unwrap();
        prop_assert!(lines(&tree, 0).into_values().all(|segments| segments as f64 <= length.ceil()));
        let most = if reach > 0.0 { (reach * length).ceil().max(1.0) } else { length.ceil() };
        for order in 1..=3 {
            prop_assert!(lines(&tree, order).into_values().all(|segments| segments as f64 <= most));
        }
        let fewer = grown(&sketch(Some(2)), habit, 12).tree;
        prop_assert!(fewer.segment_count() <= tree.segment_count());
    }
}

/// Branches that hang come to lie on the ground, unless a person drew something below it.
#[test]
fn hanging_branches_know_the_ground() {
    let hangs = Habit {
        gravity: 0.6,
        wander_deg: 4.0,
        ..Habit::default()
    };
    let never = AtomicBool::new(false);
    let lowest = |grown: &Grown| grown.tree.bounds().unwrap().0.y;
    let sketch = sketch(Some(2)).with_habit(hangs).unwrap();
    assert!(sketch.grammar_text().contains("\nground 0\n"));
    let lying = grow(&sketch, 20, &never).unwrap();
    assert!(lowest(&lying) >= 0.0, "{}", lowest(&lying));
    // A root that is drawn, and is moved above the ground again: each as if it had been drawn so.
    let mut grower = crate::sketch::Grower::default();
    assert_eq!(grower.grow(&sketch, 20, &never).unwrap(), lying);
    let end = NodeRef::new(Letter::TRUNK, 3);
    let down = sketch.move_node(end, Vec3::new(0.3, -0.1, 0.0)).unwrap();
    assert!(!down.grammar_text().contains("ground"));
    let free = grower.grow(&down, 20, &never).unwrap();
    assert_eq!(free, grow(&down, 20, &never).unwrap());
    assert!(lowest(&free) < -0.5, "{}", lowest(&free));
    let again = down.move_node(end, Vec3::Y * 0.6).unwrap();
    let kept = grower.grow(&again, 20, &never).unwrap();
    assert_eq!(kept, grow(&again, 20, &never).unwrap());
    assert!(lowest(&kept) >= 0.0, "{}", lowest(&kept));
}

/// Individuals by one grower are those that grow each for itself, but for the text of their strings.
#[test]
fn individuals_need_the_grammar_once() {
    let never = AtomicBool::new(false);
    let laws = Habit {
        wander_deg: 6.0,
        dominance: 0.2,
        bears: vec!["oak".to_owned()],
        ..Habit::default()
    };
    let drawn = sketch(Some(2)).with_habit(laws).unwrap();
    let own = |line: &str| drawn.with_rule("", Some(line)).unwrap();
    let leaves_alone = sketch(None)
        .with_habit(Habit {
            bears: vec!["oak".to_owned()],
            ..Habit::default()
        })
        .unwrap();
    for sketch in [&drawn, &own("seed 7"), &own("bears fruit"), &leaves_alone] {
        let grower = crate::sketch::Grower::of_individuals(sketch).unwrap();
        for seed in [0, 1, 9, u32::MAX] {
            let one = sketch.with_seed(seed);
            let mut own = grower.clone();
            for step in [12, 9] {
                let kept = own.grow(&one, step, &never).unwrap();
                let anew = grow(&one, step, &never).unwrap();
                assert_eq!((kept.tree, kept.organs), (anew.tree, anew.organs), "{seed}");
                assert_eq!(kept.string, "…");
            }
        }
    }
}
