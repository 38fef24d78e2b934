//! What a person expects of a sketch: the strings of the thesis, the first branch where it was
//! drawn, counts known beforehand, and the same tree for the same sketch, always.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "tests"
)]

mod sketch {
    mod as_drawn;
    mod guide;
}

use std::sync::{Arc, atomic::AtomicBool};

use glam::Vec3;
use proptest::prelude::*;
use ramus::{
    lsystem::{Grammar, Limits},
    sketch::{
        BOUNDS, GROW, GrowParams, Grower, Grown, Letter, MAX_SEGMENTS, NodeRef, SelfSimilar,
        Sketch, SketchError, Stroke, Wrap, grow, predict_segments_within,
    },
    tree::NO_PARENT,
    world::{document::Edit, history::History, journal::Journal, project},
};

fn grown(sketch: &Sketch, step: u32) -> Grown {
    let params = GrowParams {
        string_bytes: 1 << 20,
        ..GROW
    };
    Grower::new(params)
        .grow(sketch, step, &AtomicBool::new(false))
        .unwrap()
}

/// How many segments there will be, however many.
fn predicted(sketch: &Sketch, step: u32) -> u64 {
    predict_segments_within(sketch, step, u64::MAX - 1).unwrap()
}

fn letter(index: u16) -> Letter {
    Letter::from_index(index)
}

/// Draws a stroke of `segments` segments from a node, leaning a little more with each.
fn draw(sketch: &Sketch, from: NodeRef, segments: u32, lean: f32) -> Sketch {
    let start = sketch.position(from).unwrap();
    let to: Vec<Vec3> = (1..=segments)
        .map(|n| start + Vec3::new(lean * n as f32, 0.1 * n as f32, 0.02 * (n % 3) as f32))
        .collect();
    sketch.add_segments(from, &to).unwrap().0
}

/// A trunk and one branch, as the cases file describes a sketch.
fn one_branch(trunk: u32, node: u32, branch: u32) -> Sketch {
    let sketch = draw(&Sketch::default(), NodeRef::ROOT, trunk, 0.0);
    draw(&sketch, NodeRef::new(Letter::TRUNK, node), branch, 0.1)
}

/// The cases file leaves the rolls out of its strings.
fn without_rolls(text: &str) -> String {
    let mut parts = text.split("/(");
    let mut short = parts.next().unwrap().to_owned();
    for part in parts {
        short.push_str(part.split_once(')').unwrap().1);
    }
    short
}

#[test]
fn every_case_of_the_thesis() {
    let mut texts = vec![include_str!("data/sketch-cases.json").to_owned()];
    match std::env::var_os("RAMUS_SHARED") {
        Some(shared) => {
            let path = std::path::Path::new(&shared).join("reference/sketch-cases.json");
            texts.push(std::fs::read_to_string(path).unwrap());
        }
        None => eprintln!("RAMUS_SHARED is unset: only the repository's copy of the cases is read"),
    }
    for text in texts {
        let file: serde_json::Value = serde_json::from_str(&text).unwrap();
        let mut seen = 0;
        for case in file["cases"].as_array().unwrap() {
            let name = case["case"].as_str().unwrap();
            if !name.starts_with("thesis-intended") {
                continue; // other systems than a sketch's: the engine's tests read them
            }
            let size = |key: &str| case["sketch"][key].as_u64().unwrap() as u32;
            let sketch = one_branch(
                size("trunk_segments"),
                size("branch_node"),
                size("branch_segments"),
            );
            let iteration = case["iteration"].as_u64().unwrap();
            let tree = grown(&sketch, iteration as u32 + 1);
            let what = format!("{name} at {iteration}");
            assert_eq!(
                without_rolls(&tree.string),
                case["string"].as_str().unwrap(),
                "{what}"
            );
            let segments = case["segments"].as_u64().unwrap();
            assert_eq!(predicted(&sketch, iteration as u32 + 1), segments, "{what}");
            assert_eq!(
                tree.tree.parent.len() as u64,
                segments + 1,
                "{what}: and the root"
            );
            for (index, key) in [(0, "trunk_drawn"), (1, "branch_drawn")] {
                let Some(drawn) = case[key].as_u64() else {
                    continue;
                };
                let found = letter_count(&tree, letter(index));
                assert_eq!(found, drawn, "{what} {key}");
            }
            seen += 1;
        }
        assert_eq!(seen, 28, "all cases were read");
    }
}

fn letter_count(grown: &Grown, letter: Letter) -> u64 {
    let tree = &grown.tree;
    let named = |&(parent, name): &(&u32, &u16)| {
        *parent != NO_PARENT && tree.letters[usize::from(*name)] == letter.to_string()
    };
    tree.parent.iter().zip(&tree.letter).filter(named).count() as u64
}

/// The rules of the sketch applied one module at a time, from their description alone.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Module {
    Open,
    Close,
    Roll(u32),
    End,
    Segment { stroke: usize, x: u32, depth: u32 },
}

fn rewritten(sketch: &Sketch, string: &[Module]) -> Vec<Module> {
    let mut next = Vec::new();
    for (index, &module) in string.iter().enumerate() {
        next.push(module);
        let Module::Segment { stroke, x, depth } = module else {
            continue;
        };
        match string.get(index + 1) {
            Some(Module::End) => next.push(Module::Segment {
                stroke,
                x: x + 1,
                depth,
            }),
            Some(Module::Segment { .. }) => {
                let parent = &sketch.strokes[stroke];
                for (other, child) in sketch.strokes.iter().enumerate() {
                    let (rate, depth) = if other == stroke {
                        let Some(own) = child.self_similar else {
                            continue;
                        };
                        if own.depth_limit.is_some_and(|limit| depth >= limit) {
                            continue;
                        }
                        (own.rate, depth + 1)
                    } else {
                        match child.attachment {
                            Some(at) if at.letter == parent.letter => (at.node, 0),
                            _ => continue,
                        }
                    };
                    if (x + 1).is_multiple_of(rate) {
                        let first = Module::Segment {
                            stroke: other,
                            x: 0,
                            depth,
                        };
                        let roll = Module::Roll((x + 1) / rate - 1);
                        next.extend([Module::Open, roll, first, Module::End, Module::Close]);
                    }
                }
            }
            _ => {}
        }
    }
    next
}

fn by_hand(sketch: &Sketch, step: u32) -> Vec<Module> {
    let mut string = vec![
        Module::Segment {
            stroke: 0,
            x: 0,
            depth: 0,
        },
        Module::End,
    ];
    for _ in 1..step {
        string = rewritten(sketch, &string);
    }
    string
}

fn text_of(sketch: &Sketch, string: &[Module]) -> String {
    let text = |module: &Module| match *module {
        Module::Open => "[".to_owned(),
        Module::Close => "]".to_owned(),
        Module::End => "B".to_owned(),
        Module::Roll(k) => format!("/({k})"),
        Module::Segment { stroke, x, depth } => {
            let stroke = &sketch.strokes[stroke];
            match stroke.self_similar.and_then(|own| own.depth_limit) {
                Some(_) => format!("{}({x},{depth})", stroke.letter),
                None => format!("{}({x})", stroke.letter),
            }
        }
    };
    string.iter().map(text).collect()
}

/// Small sketches: curved strokes on strokes, copies with and without limits, any settings.
fn sketches() -> impl Strategy<Value = Sketch> {
    let offset = || {
        (-3..4_i8, -3..4_i8, -3..4_i8).prop_filter("a segment has a length", |&o| o != (0, 0, 0))
    };
    let stroke = (
        any::<prop::sample::Index>(),
        any::<prop::sample::Index>(),
        proptest::collection::vec(offset(), 1..5),
        proptest::option::of((1..4_u32, proptest::option::of(0..4_u32))),
    );
    (proptest::collection::vec(stroke, 1..6), any::<bool>()).prop_map(|(drawn, restart)| {
        let mut sketch = Sketch {
            self_similar_branches: false,
            ..Sketch::default()
        };
        for (number, (parent, node, offsets, own)) in drawn.into_iter().enumerate() {
            let mut from = NodeRef::ROOT;
            if number > 0 {
                let parent = &sketch.strokes[parent.index(sketch.strokes.len())];
                // The last node would go on with the line.
                let inner = parent.points.len() - 1;
                if inner == 0 {
                    continue;
                }
                from = NodeRef::new(parent.letter, node.index(inner) as u32 + 1);
            }
            let mut at = sketch.position(from).unwrap();
            let step = |(x, y, z): (i8, i8, i8)| {
                at += Vec3::new(f32::from(x), f32::from(y), f32::from(z)) * 0.04;
                at
            };
            let to: Vec<Vec3> = offsets.into_iter().map(step).collect();
            let (next, apex) = sketch.add_segments(from, &to).unwrap();
            let own = own.map(|(rate, depth_limit)| SelfSimilar { rate, depth_limit });
            sketch = next.with_self_similar(apex.letter, own).unwrap();
        }
        if restart {
            sketch.with_wrap(Wrap::Restart)
        } else {
            sketch
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn the_generated_grammar_does_what_the_rules_say(sketch in sketches(), step in 1..8_u32) {
        let expected = by_hand(&sketch, step);
        prop_assume!(expected.len() < 100_000);
        let segments = expected.iter().filter(|m| matches!(m, Module::Segment { .. })).count();
        prop_assert_eq!(predicted(&sketch, step), segments as u64);
        // A divergence of 1° makes the rolls read as the copies' numbers.
        let numbered = sketch.with_divergence(1.0).unwrap();
        let grammar = Grammar::parse(&numbered.grammar_text(), "test").unwrap();
        let string = grammar.derive(step - 1, &Limits::default(), &AtomicBool::new(false)).unwrap();
        prop_assert_eq!(string.to_text(&grammar), text_of(&sketch, &expected), "{}", numbered.grammar_text());
        let tree = grown(&sketch, step).tree;
        prop_assert_eq!(tree.parent.len(), segments + 1);
        for earlier in 1..=step {
            let born = tree.birth.iter().filter(|&&birth| birth >= 1 && birth <= earlier).count();
            prop_assert_eq!(born as u64, predicted(&sketch, earlier), "born by step {}", earlier);
        }
    }

    #[test]
    fn nodes_stand_where_each_is_asked_for(sketch in sketches()) {
        for (at, place) in sketch.nodes() {
            prop_assert_eq!(sketch.position(at), Some(place), "{:?}", at);
        }
        for (at, from, to) in sketch.segments() {
            let below = NodeRef::new(at.letter, at.node - 1);
            prop_assert_eq!([sketch.position(below), sketch.position(at)], [Some(from), Some(to)], "{:?}", at);
        }
    }

    #[test]
    fn a_grower_gives_what_growing_anew_gives(
        one in sketches(), other in sketches(),
        visits in proptest::collection::vec((any::<bool>(), 0..9_u32, 0..4_u8), 1..8),
    ) {
        let never = AtomicBool::new(false);
        let mut grower = Grower::new(GrowParams { segments: 20_000, ..GROW });
        for (first, step, moved) in visits {
            let mut sketch = if first { one.clone() } else { other.clone() };
            // Where only nodes moved, or a line is longer, the grammar read before serves on.
            if moved > 0 {
                let at = NodeRef::new(Letter::TRUNK, 1);
                let to = Vec3::new(0.3, 0.77, f32::from(moved) * 0.1);
                sketch = sketch.move_node(at, to).unwrap();
            }
            if moved > 2 {
                let apex = sketch.apex(Letter::TRUNK).unwrap();
                let to = sketch.position(apex).unwrap() + Vec3::Y * 0.2;
                sketch = sketch.add_segment(apex, to).unwrap().0;
            }
            let kept = grower.grow(&sketch, step, &never);
            if !matches!(kept, Err(SketchError::TooLarge { .. })) {
                prop_assert_eq!(kept, grow(&sketch, step, &never));
            }
        }
    }

    #[test]
    fn prediction_is_exact_further_up(sketch in sketches(), step in 8..14_u32) {
        let segments = predict_segments_within(&sketch, step, 20_000);
        prop_assume!(segments.is_some());
        let tree = grown(&sketch, step).tree;
        prop_assert_eq!(Some(tree.segment_count() as u64), segments);
    }
}

#[test]
fn several_branches_at_one_place_come_in_the_order_drawn() {
    let mut sketch = Sketch {
        self_similar_branches: false,
        ..Sketch::default()
    };
    sketch = draw(&sketch, NodeRef::ROOT, 4, 0.0);
    for (node, lean) in [(2, 0.1), (3, 0.2), (2, -0.1)] {
        sketch = draw(&sketch, NodeRef::new(Letter::TRUNK, node), 1, lean);
    }
    let string = without_rolls(&grown(&sketch, 8).string);
    let expected = "A(0)A(1)[C(0)C(1)C(2)C(3)C(4)B][E(0)E(1)E(2)E(3)E(4)B]A(2)[D(0)D(1)D(2)D(3)B]\
                    A(3)[C(0)C(1)C(2)B][E(0)E(1)E(2)B]A(4)A(5)[C(0)B][D(0)B][E(0)B]A(6)A(7)B";
    assert_eq!(string, expected);
}

#[test]
fn a_depth_limit_ends_the_copies() {
    let limited = |depth_limit| {
        let own = Some(SelfSimilar {
            rate: 1,
            depth_limit,
        });
        one_branch(3, 1, 2)
            .with_self_similar(letter(1), own)
            .unwrap()
    };
    let orders = |sketch: &Sketch| grown(sketch, 10).tree.order.into_iter().max().unwrap();
    assert_eq!(orders(&limited(Some(0))), 1, "no copies");
    assert_eq!(orders(&limited(Some(1))), 2);
    assert_eq!(orders(&limited(Some(2))), 3);
    assert_eq!(
        orders(&limited(None)),
        4,
        "a copy in a copy every second step"
    );
    let string = without_rolls(&grown(&limited(Some(1)), 5).string);
    let expected = "A(0)[C(0,0)[C(0,1)B]C(1,0)C(2,0)B]A(1)[C(0,0)C(1,0)B]A(2)[C(0,0)B]A(3)A(4)B";
    assert_eq!(string, expected);
}

#[test]
fn each_next_branch_is_turned_about_its_parent_by_the_divergence() {
    for degrees in [137.508, 180.0, 90.0, 0.0] {
        let trunk = [Vec3::Y * 0.1, Vec3::Y * 0.2];
        let (sketch, _) = Sketch::default()
            .add_segments(NodeRef::ROOT, &trunk)
            .unwrap();
        let from = NodeRef::new(Letter::TRUNK, 1);
        let sketch = sketch
            .add_segment(from, Vec3::new(0.1, 0.2, 0.0))
            .unwrap()
            .0;
        let sketch = sketch.with_divergence(degrees).unwrap();
        let tree = grown(&sketch, 6).tree;
        let mut copies = 0_u32;
        for index in 0..tree.parent.len() {
            let is_first = tree.parent[index] != NO_PARENT
                && tree.order[index] == 1
                && tree.order[tree.parent[index] as usize] == 0;
            if is_first {
                let along = tree.position[index] - tree.position[tree.parent[index] as usize];
                // Right-handed about the parent's axis, which here is +Y: from X toward −Z.
                let k = (tree.position[tree.parent[index] as usize].y / 0.2).round() - 1.0;
                let angle = (f64::from(k) * degrees).to_radians() as f32;
                let expected = Vec3::new(angle.cos(), 1.0, -angle.sin()) * 0.2;
                assert!(
                    (along - expected).length() < 1e-5,
                    "{degrees}° copy {k}: {along} {expected}"
                );
                copies += 1;
            }
        }
        assert_eq!(copies, 4, "nodes 1 to 4 carry a branch at step 6");
    }
}

#[test]
fn a_curved_trunk_goes_on_curving_or_starts_anew() {
    let bend = Vec3::new(0.1, 0.1, 0.0);
    let (sketch, _) = Sketch::default()
        .add_segments(NodeRef::ROOT, &[Vec3::Y * 0.1, Vec3::Y * 0.1 + bend])
        .unwrap();
    let directions = |sketch: &Sketch| -> Vec<Vec3> {
        let tree = grown(sketch, 4).tree;
        tree.position
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / 0.2)
            .collect()
    };
    let near = |found: Vec<Vec3>, expected: [Vec3; 4]| {
        for (found, expected) in found.iter().zip(expected) {
            assert!((*found - expected).length() < 1e-5, "{found} {expected}");
        }
    };
    let diagonal = Vec3::new(1.0, 1.0, 0.0);
    let carried = [
        Vec3::Y,
        diagonal,
        diagonal / 2_f32.sqrt(),
        Vec3::X * 2_f32.sqrt(),
    ];
    near(directions(&sketch), carried);
    near(
        directions(&sketch.with_wrap(Wrap::Restart)),
        [Vec3::Y, diagonal, Vec3::Y, diagonal],
    );
}

#[test]
fn radii_follow_da_vinci_and_steps_keep_what_was_there() {
    let sketch = one_branch(4, 2, 2);
    let (before, after) = (grown(&sketch, 7), grown(&sketch, 8));
    let tree = &after.tree;
    assert_eq!(after.newest, 8);
    for index in 0..tree.parent.len() {
        let children: Vec<usize> = (0..tree.parent.len())
            .filter(|&child| tree.parent[child] as usize == index)
            .collect();
        let area: f32 = children
            .iter()
            .map(|&child| tree.radius[child].powi(2))
            .sum();
        let expected = if children.is_empty() {
            sketch.tip_radius
        } else {
            area.sqrt()
        };
        assert!((tree.radius[index] - expected).abs() < 1e-6, "node {index}");
    }
    // What is not new stands where it stood, in the same order, with the radius it had.
    let old: Vec<usize> = (0..tree.parent.len())
        .filter(|&node| tree.birth[node] < 8)
        .collect();
    let positions: Vec<Vec3> = old.iter().map(|&node| tree.position[node]).collect();
    assert_eq!(positions, before.tree.position);
    let radii: Vec<f32> = old.iter().map(|&node| after.radius_before[node]).collect();
    for (now, then) in radii.iter().zip(&before.tree.radius) {
        assert!((now - then).abs() < 1e-6, "{now} {then}");
    }
}

#[test]
fn radii_of_its_own_stay_and_become_thinner_where_a_line_goes_on() {
    let to: Vec<Vec3> = (1..=4).map(|n| Vec3::Y * (0.1 * n as f32)).collect();
    let radii = [0.08, 0.06, 0.05, 0.04];
    let (sketch, _) = Sketch::default()
        .add_thick_segments(NodeRef::ROOT, &to, &radii)
        .unwrap();
    sketch.validate().unwrap();
    let scale = sketch.scale;
    // Six steps: two segments beyond what was drawn, which end half as thick as they began.
    let tree = grown(&sketch, 6).tree;
    let expected = [0.08, 0.06, 0.05, 0.04, 0.04, 0.03].map(|radius| radius * scale);
    for (found, expected) in tree.radius[1..].iter().zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{found} {expected}");
    }
    // Somebody who has grown the plain one grows them the same.
    let mut grower = Grower::new(GROW);
    let never = AtomicBool::new(false);
    let plain = sketch.without_radii(Letter::TRUNK).unwrap();
    let slim = grower.grow(&plain, 6, &never).unwrap().tree;
    assert_eq!(grower.grow(&sketch, 6, &never).unwrap().tree, tree);
    assert_eq!(grower.grow(&plain, 6, &never).unwrap().tree, slim);
    // However far it goes on, it is no thinner than a tenth of its end.
    let long = grower.grow(&sketch, 400, &never).unwrap().tree;
    let thin = long.radius[1..]
        .iter()
        .fold(f32::INFINITY, |thin, radius| thin.min(*radius));
    assert!((thin - 0.004 * scale).abs() < 1e-6, "{thin}");
    // What grows from it is as thick as it is by itself, and what it is drawn on carries it.
    let at = NodeRef::new(Letter::TRUNK, 2);
    let branched = draw(&sketch, at, 2, 0.1);
    let tree = grown(&branched, 4).tree;
    let tip = tree.tips();
    let thin = tip.iter().map(|node| tree.radius[*node as usize]);
    assert!(
        thin.clone().any(|radius| radius == sketch.tip_radius),
        "{:?}",
        thin.collect::<Vec<_>>()
    );
    assert!((tree.radius[2] - 0.06 * scale).abs() < 1e-5);
    // What is drawn on has none, what is deleted takes its own along, and all can be forgotten.
    let on = draw(&sketch, sketch.apex(Letter::TRUNK).unwrap(), 1, 0.0);
    assert_eq!(on.strokes[0].radii[3..], [0.04, 0.0]);
    let hand_drawn = draw(&Sketch::default(), NodeRef::ROOT, 3, 0.0);
    let apex = hand_drawn.apex(Letter::TRUNK).unwrap();
    let above = [Vec3::Y * 2.0, Vec3::Y * 2.5];
    let (mixed, _) = hand_drawn
        .add_thick_segments(apex, &above, &[0.1; 2])
        .unwrap();
    assert_eq!(mixed.strokes[0].radii, [0.0, 0.0, 0.0, 0.1, 0.1]);
    let (cut, _) = mixed.delete_node(NodeRef::new(Letter::TRUNK, 4)).unwrap();
    assert_eq!(cut, hand_drawn, "a stroke without radii lists none");
    assert_eq!(
        hand_drawn.add_thick_segments(apex, &[], &[]).unwrap().0,
        hand_drawn
    );
    let (less, _) = sketch.delete_node(NodeRef::new(Letter::TRUNK, 3)).unwrap();
    assert_eq!(less.strokes[0].radii, radii[..2]);
    let plain = sketch.without_radii(Letter::TRUNK).unwrap();
    assert_eq!(
        plain,
        Sketch::default()
            .add_segments(NodeRef::ROOT, &to)
            .unwrap()
            .0
    );
    // The text that a person saves has them.
    let grammar = Grammar::parse(&sketch.grammar_text(), "thick.lsys").unwrap();
    assert!(
        sketch.grammar_text().contains(" 0.16)"),
        "{}",
        sketch.grammar_text()
    );
    let string = grammar
        .derive(3, &Limits::default(), &AtomicBool::new(false))
        .unwrap();
    let turtle = ramus::lsystem::TurtleParams::default();
    let drawn =
        ramus::lsystem::interpret(&grammar, &string, &turtle, &AtomicBool::new(false)).unwrap();
    assert!((drawn.radius[2] - 0.12).abs() < 1e-5, "{:?}", drawn.radius);
    // One for each node, and each a radius.
    for wrong in [
        vec![0.1; 3],
        vec![0.1; 5],
        vec![0.1, 0.1, 0.1, f32::NAN],
        vec![-0.1; 4],
        vec![1e9; 4],
    ] {
        assert!(
            Sketch::default()
                .add_thick_segments(NodeRef::ROOT, &to, &wrong)
                .is_err(),
            "{wrong:?}"
        );
    }
}

#[test]
fn step_0_and_an_empty_sketch_show_the_root_alone() {
    for (sketch, step) in [
        (one_branch(3, 1, 2), 0),
        (Sketch::default(), 0),
        (Sketch::default(), 50),
    ] {
        let root = grown(&sketch, step);
        assert_eq!(root.tree.parent, [NO_PARENT]);
        assert_eq!(root.tree.position, [Vec3::ZERO]);
        assert_eq!(root.radius_before.len(), 1);
        assert_eq!(root.newest, step);
    }
    Grammar::parse(&Sketch::default().grammar_text(), "empty").unwrap();
}

#[test]
fn what_cannot_be_grown_is_refused_at_once() {
    let never = AtomicBool::new(false);
    let sketch = one_branch(3, 1, 2);
    let error = grow(&sketch, 60, &never).unwrap_err();
    assert!(
        matches!(error, SketchError::TooLarge { step: 60, .. }),
        "{error}"
    );
    let error = grow(&sketch, BOUNDS.step + 1, &never).unwrap_err();
    assert!(matches!(error, SketchError::StepTooFar { .. }), "{error}");
    let error = grow(&sketch, 20, &AtomicBool::new(true)).unwrap_err();
    assert!(matches!(error, SketchError::Grow(_)), "{error}");
    // Long without being large.
    let line = draw(&Sketch::default(), NodeRef::ROOT, 2, 0.0);
    assert_eq!(
        grown(&line, BOUNDS.step).tree.parent.len(),
        BOUNDS.step as usize + 1
    );
}

#[test]
fn more_branches_than_letters_and_than_a_line_holds() {
    let mut sketch = draw(&Sketch::default(), NodeRef::ROOT, 600, 0.0);
    while sketch.strokes.len() < BOUNDS.strokes {
        let number = sketch.strokes.len();
        let limit = SelfSimilar {
            rate: 7,
            depth_limit: (number.is_multiple_of(2)).then_some(1),
        };
        sketch.strokes.push(Arc::new(Stroke {
            letter: letter(number as u16),
            points: vec![Vec3::X * 0.1],
            handles: vec![],
            attachment: Some(NodeRef::new(Letter::TRUNK, number as u32)),
            self_similar: (number.is_multiple_of(3)).then_some(limit),
            radii: vec![],
        }));
    }
    sketch.validate().unwrap();
    let step = 30;
    let expected = by_hand(&sketch, step);
    let tree = grown(&sketch, step);
    assert_eq!(tree.tree.parent.len() as u64, predicted(&sketch, step) + 1);
    assert_eq!(
        without_rolls(&tree.string),
        without_rolls(&text_of(&sketch, &expected))
    );
    assert!(tree.string.contains("C1(0)"), "declared words are used");
}

#[test]
fn the_string_is_cut_to_its_bound() {
    let sketch = one_branch(3, 1, 2);
    let long = grow(&sketch, 15, &AtomicBool::new(false)).unwrap();
    assert!(
        long.string.len() <= GROW.string_bytes + 4,
        "{} bytes",
        long.string.len()
    );
    assert!(long.string.ends_with('…'));
    assert!(long.modules > 4000);
}

/// The tools, the world and the grower refuse the same, and the handbook says so.
#[test]
fn one_bound_of_segments() {
    let params = ramus::world::WorldParams::default();
    for most in [
        GROW.segments,
        params.growth.max_segments,
        params.tools.draw.max_segments,
    ] {
        assert_eq!(most, MAX_SEGMENTS);
    }
    let said = format!("Above {} million it is refused", MAX_SEGMENTS / 1_000_000);
    assert!(MAX_SEGMENTS.is_multiple_of(1_000_000));
    assert!(
        include_str!("../docs/src/sketch.md").contains(&said),
        "{said}"
    );
}
