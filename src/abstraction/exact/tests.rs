//! Exact grammars: trees that come back, what is shared, what is refused, and what holds of any tree.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::sync::atomic::AtomicBool;

use glam::{Quat, Vec3};
use proptest::prelude::*;

use super::*;
use crate::tree::axes::Children;
use crate::tree::{NO_PARENT, Node};

fn found(tree: &Tree, tolerance: f64) -> Exact {
    exact(tree, tolerance, &AtomicBool::new(false), &|_, _| {}).unwrap()
}

/// A tree of nodes: parent (−1 for none), place and radius.
fn tree(nodes: &[(i64, [f32; 3], f32)]) -> Tree {
    let mut tree = Tree {
        letters: vec!["F".to_owned()],
        ..Tree::default()
    };
    for (parent, place, radius) in nodes {
        tree.push(Node {
            parent: u32::try_from(*parent).unwrap_or(NO_PARENT),
            position: Vec3::from(*place),
            radius: *radius,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    tree
}

/// What a grammar draws after its steps.
fn grown(text: &str) -> Tree {
    let never = AtomicBool::new(false);
    let grammar = Grammar::parse(text, "test.lsys").unwrap();
    let string = grammar
        .derive(grammar.steps().unwrap(), &Limits::default(), &never)
        .unwrap();
    interpret(&grammar, &string, &TurtleParams::default(), &never).unwrap()
}

/// Junctions and tips as nested brackets, in an order of their own; a root's own radius is no junction.
fn topology(tree: &Tree) -> Vec<String> {
    let children = Children::new(tree);
    let mut said: Vec<String> = vec![String::new(); tree.len()];
    let mut roots = Vec::new();
    for node in (0..tree.len()).rev() {
        let own = children.of(u32::try_from(node).unwrap());
        let mut parts: Vec<String> = own
            .iter()
            .map(|child| said[*child as usize].clone())
            .collect();
        parts.sort();
        said[node] = match parts.as_slice() {
            [one] => one.clone(),
            parts => format!("({})", parts.concat()),
        };
        if tree.parent[node] == NO_PARENT {
            roots.push(said[node].clone());
        }
    }
    roots.sort();
    roots
}

/// The farthest that points of one tree's center lines are from the other's, by trying a great many.
fn farthest(from: &Tree, to: &Tree) -> f64 {
    let segments = |tree: &Tree| -> Vec<[DVec3; 2]> {
        let root = tree.position[0].as_dvec3();
        let of = |node: usize| {
            let parent = match tree.parent[node] {
                NO_PARENT => node,
                parent => parent as usize,
            };
            [parent, node].map(|node| tree.position[node].as_dvec3() - root)
        };
        (0..tree.len()).map(of).collect()
    };
    let to = segments(to);
    let mut farthest = 0.0_f64;
    for [start, end] in segments(from) {
        for step in 0..=20 {
            let point = start.lerp(end, f64::from(step) / 20.0);
            let near = to
                .iter()
                .map(|segment| shape::from_segment(point, *segment).0);
            farthest = farthest.max(near.fold(f64::INFINITY, f64::min));
        }
    }
    farthest
}

/// What holds of every grammar: it draws the tree again, with its topology, as near as is said, and says how large it is.
fn holds(tree: &Tree, exact: &Exact) {
    assert!(exact.error.max <= exact.tolerance && exact.error.radius <= exact.tolerance);
    let drawn = grown(&exact.grammar);
    assert_eq!(drawn, exact.tree);
    assert_eq!(topology(&drawn), topology(tree), "{}", exact.grammar);
    for [from, to] in [[tree, &drawn], [&drawn, tree]] {
        let off = farthest(from, to);
        assert!(
            off <= exact.error.max + 1e-9 * exact.tolerance,
            "{off} {:?}",
            exact.error
        );
    }
    let grammar = Grammar::parse(&exact.grammar, "test.lsys").unwrap();
    assert_eq!(grammar.productions().len(), exact.size.productions);
    assert_eq!(exact.grammar.len(), exact.size.bytes);
}

const GRAMMARS: [(&str, &str, usize, usize); 9] = [
    // Productions and symbols at most; the originals have as many productions.
    (
        "honda",
        include_str!("../../../assets/grammars/honda.lsys"),
        3,
        70,
    ),
    (
        "honda-b",
        include_str!("../../../assets/grammars/honda-b.lsys"),
        3,
        70,
    ),
    (
        "honda-c",
        include_str!("../../../assets/grammars/honda-c.lsys"),
        3,
        70,
    ),
    (
        "honda-d",
        include_str!("../../../assets/grammars/honda-d.lsys"),
        3,
        70,
    ),
    (
        "aono-kunii-a",
        include_str!("../../../assets/grammars/aono-kunii-a.lsys"),
        1,
        50,
    ),
    (
        "aono-kunii-d",
        include_str!("../../../assets/grammars/aono-kunii-d.lsys"),
        1,
        50,
    ),
    (
        "branching-exponential",
        include_str!("../../../assets/grammars/branching-exponential.lsys"),
        1,
        30,
    ),
    (
        "weed-a",
        include_str!("../../../assets/grammars/weed-a.lsys"),
        9,
        120,
    ),
    (
        "mycelis",
        include_str!("../../../assets/grammars/mycelis.lsys"),
        10,
        150,
    ),
];

#[test]
fn trees_that_grammars_grew_come_back_as_small_grammars() {
    for (name, text, productions, symbols) in GRAMMARS {
        let tree = grown(text);
        let exact = found(&tree, 0.005 * size(&tree));
        assert!(
            exact.size.productions <= productions,
            "{name}: {}",
            exact.grammar
        );
        assert!(exact.size.symbols() <= symbols, "{name}: {}", exact.grammar);
        assert_eq!(topology(&exact.tree), topology(&tree), "{name}");
        // As exact as single precision nearly is: the rules are found, not a likeness.
        let fine = found(&tree, 1e-5 * size(&tree));
        assert!(fine.error.max <= 1e-5 * size(&tree), "{name}");
    }
}

#[test]
fn hondas_tree_is_hondas_grammar() {
    let tree = grown(GRAMMARS[0].1);
    let exact = found(&tree, 1e-4 * size(&tree));
    let lines: Vec<&str> = exact.grammar.lines().collect();
    assert_eq!(
        lines,
        [
            "steps 10",
            "axiom A(1, 10)",
            "A(l, w) -> !(w) F(l) [ &(45) $ B(l*0.6, w*0.707) ] /(137.5) A(l*0.9, w*0.707)",
            "B(l, w) -> !(w) F(l) [ /(-90) &(45) $ C(l*0.6, w*0.707) ] $ C(l*0.9, w*0.707)",
            "C(l, w) -> !(w) F(l) [ /(90) &(45) $ B(l*0.6, w*0.707) ] $ B(l*0.9, w*0.707)",
        ]
    );
}

#[test]
fn a_self_similar_tree_is_as_small_whatever_its_depth() {
    let symbols = |steps: u32| {
        let text = format!(
            "steps {steps}\naxiom A(1)\nA(l) -> F(l) [ +(30) A(l*0.7) ] /(90) [ &(40) A(l*0.6) ] A(l*0.8)"
        );
        let tree = grown(&text);
        (tree.len(), found(&tree, 1e-3 * size(&tree)).size.symbols())
    };
    let [(few, small), (many, same)] = [4, 9].map(symbols);
    assert!(many > 200 * few);
    assert!(same <= small + 2, "{small} {same}");
}

#[test]
fn repetitions_along_a_branch_are_counted() {
    // Internodes with a leaf each, then a fork that is like nothing before it.
    let text = "steps 1\naxiom X\nX -> ".to_owned()
        + &"F(1) [ &(60) F(0.4) +(20) F(0.3) ] /(137.5) ".repeat(30)
        + "F(1) [ +(25) F(2) ] -(35) F(1.5)";
    let tree = grown(&text);
    let exact = found(&tree, 1e-3 * size(&tree));
    holds(&tree, &exact);
    assert!(exact.size.symbols() < 80, "{}", exact.grammar);
}

#[test]
fn a_rule_of_several_forks_repeats_itself_whatever_it_ends_in() {
    // The tree of Guo et al.'s our-branch-5: segments grow, so the last ones are of another length than the rule says.
    let symbols = |steps: u32| {
        let text = format!(
            "steps {steps}\naxiom X\nX -> F(1) [ +(40) X ] F(1) [ -(40) X ] X\nF(l) -> F(l*1.9)"
        );
        let tree = grown(&text);
        let exact = found(&tree, 1e-4 * size(&tree));
        assert_eq!(topology(&exact.tree), topology(&tree));
        exact.size
    };
    let [small, same] = [5, 7].map(symbols);
    assert_eq!(small.productions, same.productions);
    assert!(same.symbols() <= small.symbols() + 2, "{small:?} {same:?}");
}

/// Rules of one production, with what they are found as; the first of ABOP's figure 1.24, the others with the turns and the growth of examples of Guo et
/// al. (2020, `our-branch-N`).
const ONE_RULE: [(&str, &str); 12] = [
    (
        "steps 5\naxiom F\nF -> F [ +(25.7) F ] F [ -(25.7) F ] F",
        "F(l) -> F(l) [ +(25.7) F(l) ] F(l) [ +(-25.7) F(l) ] F(l)",
    ),
    (
        "steps 5\naxiom F\nF -> F [ +(20) F ] F [ -(20) F ] [ F ]",
        "F(l) -> F(l) [ +(20) F(l) ] F(l) [ F(l) ] [ +(-20) F(l) ]",
    ),
    (
        "steps 4\naxiom F\nF -> F F -(22.5) [ -(22.5) F +(22.5) F +(22.5) F ] +(22.5) [ +(22.5) F -(22.5) F -(22.5) F ]",
        "F(l) -> F(l) F(l) [ +(22.5) F(l) +(-22.5) F(l) +(-22.5) F(l) ] [ +(-45) F(l) +(22.5) F(l) +(22.5) F(l) ]",
    ),
    (
        "steps 5\naxiom F\nF -> F [ +(30) F ] F [ -(30) F ] F",
        "F(l) -> F(l) [ +(30) F(l) ] F(l) [ +(-30) F(l) ] F(l)",
    ),
    (
        "steps 6\naxiom A(1)\nA(s) -> F(s) [ +(85) A(s) ] [ -(20) A(0.7*s) ]\nF(l) -> F(1.4*l)",
        "A(l) -> F(l) [ +(-20) A(l*0.5) ] +(85) A(l*0.714286)",
    ),
    (
        "steps 6\naxiom X\nX -> A [ +(40) X ] [ -(40) X ]\nA -> F(1) [ +(30) F(1) ] F(1) [ -(30) F(1) ] F(1)\nF(l) -> F(1.6*l)",
        "A(l) -> F(l) [ +(30) F(l) ] F(l) [ +(-30) F(l) ] F(l) [ +(-40) A(l*0.625) ] +(40) A(l*0.625)",
    ),
    (
        "steps 6\naxiom X\nX -> F(1) [ +(40) X ] [ -(40) X ] F(1) X\nF(l) -> F(1.64*l)",
        "A(l) -> F(l) [ +(40) A(l*0.60976) ] [ +(-40) A(l*0.60976) ] F(l) A(l*0.60976)",
    ),
    (
        "steps 6\naxiom X\nX -> F(1) [ +(40) X ] F(1) [ -(40) X ] X\nF(l) -> F(1.9*l)",
        "A(l) -> F(l) [ +(40) A(l*0.52632) ] F(l) [ +(-40) A(l*0.52632) ] A(l*0.52632)",
    ),
    (
        "steps 6\naxiom X\nX -> F(1) [ +(40) X ] F(1) [ -(40) X ] +(40) X\nF(l) -> F(2.3*l)",
        "A(l) -> F(l) [ +(40) A(l*0.43478) ] F(l) [ +(-40) A(l*0.43478) ] +(40) A(l*0.43478)",
    ),
    (
        "steps 6\naxiom X\nX -> F(1) [ +(40) F(1) ] [ -(40) X ] +(40) F(1) -(40) F(1) [ +(40) X ] -(40) X\nF(l) -> F(2.2*l)",
        "A(l) -> F(l) [ +(40) F(l) ] [ +(-40) A(l*0.45455) ] +(40) F(l) +(-40) F(l) [ +(40) A(l*0.45455) ] +(-40) A(l*0.45455)",
    ),
    (
        "steps 4\naxiom F\nF -> F [ +(40) F [ +(40) F [ -(40) F ] ] [ +(40) F [ +(40) F ] ] ] [ -(40) F [ -(40) F [ +(40) F ] ] ]",
        "F(l) -> F(l) [ +(-40) F(l) +(-40) F(l) +(40) F(l) ] [ +(40) F(l) [ +(40) F(l) +(40) F(l) ] +(40) F(l) +(-40) F(l) ]",
    ),
    (
        "steps 60\naxiom X\nX -> F(1) +(30) X\nF(l) -> F(1.02*l)",
        "A(l) -> F(l) +(30) A(l*0.980392)",
    ),
];

#[test]
fn rules_of_one_production_are_found_again_as_they_are() {
    for (text, rule) in ONE_RULE {
        let tree = grown(text);
        let exact = found(&tree, 1e-3 * size(&tree));
        let (_, own) = exact.grammar.split_once("\naxiom !(0.1) ").unwrap();
        let (_, own) = own.split_once('\n').unwrap();
        assert_eq!(own.replace("\n ", "").trim_end(), rule);
        assert_eq!(topology(&exact.tree), topology(&tree), "{rule}");
    }
}

#[test]
fn a_helix_is_one_production() {
    let nodes: Vec<(i64, [f32; 3], f32)> = (0_u8..120)
        .map(|at| {
            let angle = 0.2 * f32::from(at);
            let place = [angle.cos(), 0.1 * angle, angle.sin()];
            (i64::from(at) - 1, place, 0.05)
        })
        .collect();
    let tree = tree(&nodes);
    let exact = found(&tree, 0.02 * size(&tree));
    holds(&tree, &exact);
    assert!(exact.size.symbols() < 30, "{}", exact.grammar);
}

#[test]
fn odd_trees_are_drawn_again() {
    let star: Vec<(i64, [f32; 3], f32)> = [(-1, [0.0; 3], 1.0), (0, [0.0, 1.0, 0.0], 1.0)]
        .into_iter()
        .chain((0_u16..300).map(|at| {
            let angle = f32::from(at);
            (1, [3.0 * angle.cos(), 2.0, 3.0 * angle.sin()], 0.2)
        }))
        .collect();
    let zero = [
        (-1, [0.0; 3], 1.0),
        (0, [0.0; 3], 1.0),
        (1, [0.0; 3], 0.5),
        (2, [0.0, 1.0, 0.0], 1.0),
        (2, [0.0, 1.0, 0.0], 0.0),
        (3, [0.0, 1.0, 0.0], 0.0),
        (3, [1.0, 2.0, 0.0], 0.1),
    ];
    let forest = [
        (-1, [5.0, 1.0, 2.0], 0.3),
        (0, [5.0, 2.0, 2.0], 0.3),
        (-1, [8.0, 1.0, 2.0], 0.2),
        (2, [8.0, 3.0, 2.0], 0.1),
        (2, [7.0, 3.0, 1.0], 0.1),
        (-1, [0.0, 0.0, 1.0], 0.4),
    ];
    let down = [
        (-1, [0.0; 3], 1.0),
        (0, [0.0, -2.0, 0.0], 1.0),
        (1, [0.0, -1.0, 0.0], 1.0),
    ];
    for (name, nodes) in [
        ("star", star.as_slice()),
        ("zero", &zero),
        ("forest", &forest),
        ("down and back", &down),
        ("segment", &[(-1, [1.0; 3], 0.1), (0, [2.0, 1.0, 1.0], 0.4)]),
    ] {
        let tree = tree(nodes);
        for part in [1e-4, 1e-2, 0.2] {
            println!("{name} {part}");
            holds(&tree, &found(&tree, part * size(&tree)));
        }
    }
}

#[test]
fn what_cannot_be_asked_for_is_said() {
    let line = tree(&[(-1, [0.0; 3], 1.0), (0, [0.0, 10.0, 0.0], 1.0)]);
    let point = tree(&[(-1, [0.0; 3], 1.0), (0, [0.0; 3], 1.0)]);
    let lone = tree(&[(-1, [1.0; 3], 1.0)]);
    let broken = tree(&[(-1, [0.0; 3], f32::NAN), (0, [1.0; 3], 1.0)]);
    for (tree, tolerance, part) in [
        (&line, 0.0, "the tolerance is 0"),
        (&line, -1.0, "the tolerance is -1"),
        (&line, f64::NAN, "the tolerance is NaN"),
        (&line, f64::INFINITY, "the tolerance is inf"),
        (&line, 10.0, "no smaller than the tree"),
        (&line, 1e-9, "single precision"),
        (&point, 0.1, "at one place"),
        (&lone, 0.1, "no segment"),
        (&Tree::default(), 0.1, "no segment"),
        (&broken, 0.1, "radius"),
    ] {
        let error = exact(tree, tolerance, &AtomicBool::new(false), &|_, _| {}).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
    let stopped = exact(&line, 0.1, &AtomicBool::new(true), &|_, _| {}).unwrap_err();
    assert!(matches!(stopped, ExactError::Cancelled));
}

#[test]
fn a_curve_falls_and_holds_what_it_says() {
    let tree = grown(include_str!("../../../assets/grammars/ternary.lsys"));
    let never = AtomicBool::new(false);
    let known = found(&tree, 0.003 * size(&tree));
    let points = curve(&tree, &known, &never, &mut |_, _| {}).unwrap();
    assert_eq!(points.len(), 10);
    assert!(points.contains(&Point::of(&known)));
    for pair in points.windows(2) {
        assert!(pair[0].tolerance < pair[1].tolerance);
        // What is found is no optimum, but near one.
        let [fine, coarse] = [0, 1].map(|at| pair[at].size.symbols() as f64);
        assert!(coarse <= 1.1 * fine, "{pair:?}");
    }
    for point in &points {
        assert!(point.error.max <= point.tolerance && point.error.radius <= point.tolerance);
    }
}

#[test]
fn a_long_path_takes_no_stack_and_little_time() {
    let mut nodes = vec![(-1, [0.0_f32; 3], 1.0_f32)];
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from(u16::try_from(state >> 16).unwrap()) / 65_536.0 - 0.5
    };
    for at in 0..20_000 {
        let (_, [x, y, z], _) = nodes[at];
        let next = [x + random(), y + 0.3 + random(), z + random()];
        nodes.push((i64::try_from(at).unwrap(), next, 1.0));
    }
    let tree = tree(&nodes);
    let exact = found(&tree, 1e-3 * size(&tree));
    assert!(exact.error.max <= exact.tolerance);
    assert_eq!(topology(&exact.tree), topology(&tree));
}

/// Trees of up to 60 nodes: each grows from one before it, some at no distance.
fn random_tree() -> impl Strategy<Value = Tree> {
    let node = (
        any::<u16>(),
        prop::array::uniform3(-1.0_f32..1.0),
        0.0_f32..0.5,
        0_u8..10,
    );
    prop::collection::vec(node, 1..60).prop_map(|all| {
        let mut nodes = vec![(-1, [3.0_f32, -2.0, 1.0], 0.3_f32)];
        for (from, [x, y, z], radius, kind) in all {
            let count = nodes.len();
            // Mostly on from one of the last few.
            let parent = match kind {
                0..6 => count - 1 - usize::from(from) % count.min(2),
                _ => usize::from(from) % count,
            };
            let (_, place, _) = nodes[parent];
            let step = if kind == 9 { 0.0 } else { 1.0 };
            let place = [
                place[0] + x * step,
                place[1] + y * step,
                place[2] + z * step,
            ];
            nodes.push((i64::try_from(parent).unwrap(), place, radius));
        }
        tree(&nodes)
    })
}

/// What a production makes: modules in brackets or not, with turns that differ, and how many modules and parameters that takes. `again` is the module that
/// is made again, where `may` says so.
fn any_rule(again: &'static str) -> impl Strategy<Value = (String, usize)> {
    let angles = Just(vec![-75, -60, -45, -30, -15, 15, 30, 45, 60, 75]).prop_shuffle();
    let items = prop::collection::vec((prop::bool::ANY, prop::bool::ANY), 1..5);
    (angles, items).prop_map(move |(angles, items)| {
        let mut body = "F(l)".to_owned();
        let mut symbols = 2;
        let count = items.len();
        for (at, ((bracketed, is_again), angle)) in items.into_iter().zip(angles).enumerate() {
            let is_last = at + 1 == count;
            // What goes on behind the module is not what is looked for.
            let bracketed = !is_last && (bracketed || again == "A");
            let module = match is_last || is_again {
                true => again,
                false => "F",
            };
            let module = if module == "A" { "A(l*0.6)" } else { "F(l)" };
            body += &match bracketed {
                true => format!(" [ +({angle}) {module} ]"),
                false => format!(" +({angle}) {module}"),
            };
            symbols += 4 + 2 * usize::from(bracketed);
        }
        (body, symbols)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn a_rule_that_makes_its_module_again_is_found_again(
        (edges, few) in any_rule("F"),
        (nodes, some) in any_rule("A"),
        steps in 2_u32..4,
    ) {
        for (text, symbols) in [
            (format!("steps {steps}\naxiom F(1)\nF(l) -> {edges}"), few),
            (format!("steps {}\naxiom A(1)\nA(l) -> {nodes}", steps + 1), some),
        ] {
            let tree = grown(&text);
            let exact = found(&tree, 1e-4 * size(&tree));
            prop_assert_eq!(topology(&exact.tree), topology(&tree));
            // Its width, its first module with a length, and the head.
            prop_assert!(exact.size.symbols() <= symbols + 6, "{}\n{}", text, exact.grammar);
        }
    }


    #[test]
    fn any_tree_is_drawn_again(tree in random_tree(), part in 0.0005_f64..0.3) {
        let tolerance = part * size(&tree);
        prop_assume!(tolerance > 0.0);
        let exact = found(&tree, tolerance);
        holds(&tree, &exact);
        // The same bytes each time,
        prop_assert_eq!(&found(&tree, tolerance).grammar, &exact.grammar);
        // and what was drawn is drawn again by no larger a grammar.
        let again = found(&exact.tree, tolerance);
        holds(&exact.tree, &again);
        let [first, second] = [&exact, &again].map(|one| one.size.symbols());
        prop_assert!(second <= first + first / 10 + 4, "{} {}", first, second);
    }

    #[test]
    fn a_turned_tree_is_as_small(axis in prop::array::uniform3(-1.0_f32..1.0), angle in 0.0_f32..6.0) {
        let text = "steps 6\naxiom A(1)\nA(l) -> F(l) [ &(35) A(l*0.7) ] /(100) [ &(50) F(l) ] A(l*0.85)";
        let straight = grown(text);
        let turn = Quat::from_axis_angle(Vec3::from(axis).normalize_or(Vec3::X), angle);
        let mut turned = straight.clone();
        for position in turned.position.iter_mut() {
            *position = turn * *position;
        }
        let [first, second] = [&straight, &turned].map(|tree| found(tree, 1e-3 * size(&straight)));
        prop_assert_eq!(first.size.productions, second.size.productions);
        prop_assert!(second.size.symbols() <= first.size.symbols() + 6, "{}", second.grammar);
    }
}
