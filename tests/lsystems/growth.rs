//! Growing in time: pictures between two steps.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use ramus::lsystem::{Grammar, Growing, Limits, TurtleParams};
use ramus::tree::{NO_PARENT, Tree};

use super::{derive, draw, parse};

const HONDA: &str = include_str!("../../assets/grammars/honda.lsys");
const TERNARY: &str = include_str!("../../assets/grammars/ternary.lsys");
const KOCH: &str = "angle 60\naxiom F--F--F\nF -> F+F--F+F\n";
const SKETCH: &str = "context literal\naxiom A(0) B\nA(x) > B -> A(x) A(x+1)\n\
    A(x) > A(y) : y == x+1 && (x+1) % 2 == 0 -> A(x) [ /(137.508 * ((x+1)/2 - 1)) C(0) B ]\n\
    C(x) > B -> C(x) C(x+1)\nshape A = [(0 0.4 0) (0.1 0.4 0) (0 0.3 0.1)]\nshape C = [(0.3 0.3 0) (0.3 0.1 0)]\n";
const SHOWN: &str = "angle 30\naxiom A(1)\nA(x) -> S(x) [+A(x/2)] [-A(x/2)]\nS(x) -> S(x*2)\n\
    interpret {\n  S(x) -> !(x/10) F(x)\n  A(x) -> F(x/3)\n}\n";
const DECOMPOSED: &str = "axiom B\nB -> C(2) B\ndecompose {\n  C(x) -> F(x) [+(40)F(x/2)]\n}\n";

fn growing(grammar: &Grammar, step: u32) -> Growing {
    Growing::new(grammar, step, &Limits::default(), &AtomicBool::new(false)).unwrap()
}

/// The tree at an age of the step. Its drawing may derive nothing: a limit of no modules at all would stop it.
fn tree(grammar: &Grammar, growing: &Growing, age: f64) -> Tree {
    let mut params = TurtleParams::default();
    if !grammar_shows(grammar) {
        params.limits.modules = 0;
    }
    growing
        .tree(grammar, age, &params, &AtomicBool::new(false))
        .unwrap()
}

/// The `interpret` block is drawing, and the one thing that rewrites for a picture.
fn grammar_shows(grammar: &Grammar) -> bool {
    let string = derive(grammar, 1);
    let params = TurtleParams {
        limits: Limits {
            modules: 0,
            ..Limits::default()
        },
        ..TurtleParams::default()
    };
    ramus::lsystem::interpret(grammar, &string, &params, &AtomicBool::new(false)).is_err()
}

#[test]
fn whole_steps_are_those_of_the_derivation_bit_for_bit() {
    for text in [HONDA, TERNARY, KOCH, SKETCH, SHOWN, DECOMPOSED] {
        let grammar = parse(text);
        for step in 0..=5 {
            let growing = growing(&grammar, step);
            let string = derive(&grammar, step);
            assert_eq!(growing.string(), &string, "{text}");
            assert!(
                tree(&grammar, &growing, 1.0) == draw(&grammar, &string),
                "step {step} of {text}"
            );
            // And the way to it ends there.
            let nearly = tree(&grammar, &growing, 1.0 - 1e-12);
            let whole = draw(&grammar, &string);
            assert_eq!(nearly.parent, whole.parent, "step {step} of {text}");
            let far = |(a, b): (&Vec3, &Vec3)| a.distance(*b) > 1e-5 * (1.0 + b.length());
            assert!(
                !nearly.position.iter().zip(&whole.position).any(far),
                "step {step} of {text}"
            );
            let wide = |(a, b): (&f32, &f32)| (a - b).abs() > 1e-5 * (1.0 + b.abs());
            assert!(
                !nearly.radius.iter().zip(&whole.radius).any(wide),
                "step {step} of {text}"
            );
        }
    }
}

/// Segments longer than next to nothing, as their ends and radius.
fn segments(tree: &Tree) -> Vec<(Vec3, Vec3, f32)> {
    (0..tree.len())
        .filter(|i| tree.parent[*i] != NO_PARENT)
        .map(|i| {
            (
                tree.position[tree.parent[i] as usize],
                tree.position[i],
                tree.radius[i],
            )
        })
        .filter(|(a, b, _)| a.distance(*b) > 1e-5)
        .collect()
}

/// Just after a step the picture is that of the step.
#[test]
fn growth_begins_with_the_picture_of_the_step_before() {
    for (text, steps) in [(HONDA, 7), (TERNARY, 4), (KOCH, 4), (SKETCH, 9)] {
        let grammar = parse(text);
        for step in 1..=steps {
            let before = segments(&draw(&grammar, &derive(&grammar, step - 1)));
            let begun = segments(&tree(&grammar, &growing(&grammar, step), 1e-9));
            let near = |a: &(Vec3, Vec3, f32), b: &(Vec3, Vec3, f32)| {
                a.0.distance(b.0) < 1e-4 && a.1.distance(b.1) < 1e-4 && (a.2 - b.2).abs() < 1e-4
            };
            assert_eq!(begun.len(), before.len(), "step {step} of {text}");
            for (a, b) in begun.iter().zip(&before) {
                assert!(near(a, b), "step {step} of {text}: {a:?} {b:?}");
            }
        }
    }
}

/// Everything moves a little in a little time.
#[test]
fn growth_is_steady() {
    for text in [HONDA, TERNARY, KOCH, SHOWN, DECOMPOSED] {
        let grammar = parse(text);
        let growing = growing(&grammar, 4);
        let size = draw(&grammar, growing.string())
            .bounds()
            .map_or(0.0, |(low, high)| low.distance(high));
        let mut last: Option<Tree> = None;
        for frame in 1..100 {
            let tree = tree(&grammar, &growing, f64::from(frame) / 100.0);
            if let Some(last) = &last {
                let far = |(a, b): (&Vec3, &Vec3)| a.distance(*b) > size / 10.0;
                assert!(
                    !last.position.iter().zip(&tree.position).any(far),
                    "frame {frame} of {text}"
                );
            }
            last = Some(tree);
        }
    }
}

#[test]
fn half_way_by_hand() {
    let half = |text: &str, age: f64| {
        let grammar = parse(text);
        tree(&grammar, &growing(&grammar, 1), age)
    };
    let ends = |tree: &Tree| tree.position[1..].to_vec();
    // New: half the length, half the width, half the turn.
    let tree = half("axiom A\nA -> !(4) F(2) +(60) F(1)\n", 0.5);
    assert_eq!(tree.radius[1], 1.0, "half of 4 is a radius of 1");
    let turned = Vec3::new(-0.25, 1.0 + 0.5 * 0.75_f32.sqrt(), 0.0);
    assert!(
        tree.position[2].distance(turned) < 1e-6,
        "{}",
        tree.position[2]
    );
    // The same module goes from its old parameters to its new ones.
    assert_eq!(
        ends(&half("axiom F(2)\nF(x) -> F(x*2)\n", 0.25)),
        [Vec3::Y * 2.5]
    );
    // Rather the one outside of branches.
    assert_eq!(
        ends(&half("axiom F(2)\nF(x) -> [F(x*2)]F(x*3)\n", 0.5)),
        [Vec3::Y * 2.0, Vec3::Y * 4.0],
        "the one in the branch is new, the other goes from 2 to 6"
    );
    // Another drawing module takes the length over; what says no length is 1 m.
    assert_eq!(
        ends(&half("axiom F(3)\nF(x) -> B G(1) G(2)\n", 0.5)),
        [Vec3::Y * 2.0, Vec3::Y * 3.0]
    );
    assert_eq!(ends(&half("axiom F\nF -> G(3)\n", 0.5)), [Vec3::Y * 2.0]);
    assert_eq!(
        ends(&half("axiom F\nF -> F F\n", 0.5)),
        [Vec3::Y, Vec3::Y * 1.5]
    );
    // What stays is whole, `|` turns as far as it has come, a narrowing is half a narrowing.
    assert_eq!(ends(&half("axiom F A\nA -> *\n", 0.5)), [Vec3::Y]);
    let turned = half("axiom F A F\nA -> |\n", 0.5);
    assert!(
        turned.position[2].distance(Vec3::new(-1.0, 1.0, 0.0)) < 1e-6,
        "a quarter turn"
    );
    let narrowed = half("axiom !(2) A F\nA -> !\n", 0.5);
    let expected = 1.0 - 0.5 * (1.0 - 0.5_f32.sqrt());
    assert!(
        (narrowed.radius[1] - expected).abs() < 1e-6,
        "{}",
        narrowed.radius[1]
    );
    // Shapes: a segment of the dictionary grows in length; its index is none of its measures.
    let shape = "shape A = [(0 2 0) (2 0 0)]\n";
    let drawn = half(&format!("{shape}axiom A(0) B\nB -> A(1)\n"), 0.5);
    assert_eq!(ends(&drawn), [Vec3::Y * 2.0, Vec3::new(1.0, 2.0, 0.0)]);
}

#[test]
fn each_module_has_its_curve() {
    let text = "axiom A\nA -> F(1) +(90) F(1) G(1)\n\
        growth F table (0 0) (0.5 0.8) (1 1)\ngrowth + once\ngrowth default logistic 8\n";
    let grammar = parse(text);
    let tree = tree(&grammar, &growing(&grammar, 1), 0.25);
    let logistic = |x: f32| 1.0 / (1.0 + (-8.0 * (x - 0.5)).exp());
    let g = (logistic(0.25) - logistic(0.0)) / (logistic(1.0) - logistic(0.0));
    for (found, expected) in tree.position[1..].iter().zip([
        Vec3::Y * 0.4,
        Vec3::new(-0.4, 0.4, 0.0),
        Vec3::new(-0.4 - g, 0.4, 0.0),
    ]) {
        assert!(found.distance(expected) < 1e-6, "{found} {expected}");
    }
}

#[test]
fn refusals() {
    for (line, column, expected) in [
        ("growth F", 9, "a growth curve: `linear`"),
        ("growth F quick", 10, "a growth curve: `linear`"),
        ("growth F logistic 0", 19, "above 0"),
        ("growth F logistic -3", 19, "above 0"),
        ("growth F logistic 1e9", 19, "at most 100"),
        ("growth F table (0 0)", 16, "ends at (1 1)"),
        ("growth F table (0.1 0) (1 1)", 16, "begins at (0 0)"),
        ("growth F table (0 0) (1 0.9)", 16, "ends at (1 1)"),
        ("growth F table (0 0) (0.5 1.5) (1 1)", 23, "outside 0 to 1"),
        (
            "growth F table (0 0) (0.5 0.5) (0.5 0.6) (1 1)",
            33,
            "from left to right",
        ),
        ("growth G linear", 8, "`G`"),
        ("growth F linear\ngrowth F once", 8, "second time"),
        (
            "growth default linear\ngrowth default once",
            8,
            "second time",
        ),
    ] {
        let errors = Grammar::parse(&format!("axiom F\n{line}\n"), "test.lsys").unwrap_err();
        let error = errors.errors.first().unwrap();
        assert!(error.message.contains(expected), "{line}\n{errors}");
        assert_eq!(error.column, column, "{line}\n{errors}");
    }
}
