//! The turtle: each sign, frames, shapes, widths, births.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use ramus::lsystem::turtle::TreeCanvas;
use ramus::lsystem::{DeriveProblem, Grammar, ModuleString, TurtleParams, draw_on, interpret};
use ramus::tree::{NO_PARENT, Tree};

use super::{derive, draw, parse};

fn tree_of(text: &str) -> Tree {
    let grammar = parse(text);
    draw(&grammar, &derive(&grammar, 0))
}

fn end_of(axiom: &str) -> Vec3 {
    *tree_of(&format!("angle 90\naxiom {axiom}\n"))
        .position
        .last()
        .unwrap()
}

fn near(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-5
}

/// Start: H = +Y, L = −X, U = +Z. `+` turns H toward L, `&` toward −U, `\` tips U toward L, `/` toward −L.
#[test]
fn signs() {
    for (axiom, end) in [
        ("F", Vec3::Y),
        ("F(2)", Vec3::Y * 2.0),
        ("G(2)", Vec3::Y * 2.0),
        ("F(-1)", Vec3::NEG_Y),
        ("+F", Vec3::NEG_X),
        ("-F", Vec3::X),
        ("+(30)F", Vec3::new(-0.5, 0.866_025_4, 0.0)),
        // Negative angles turn the other way, negative lengths go backward.
        ("+(-90)F", Vec3::X),
        ("-(-90)F", Vec3::NEG_X),
        ("&(-90)F", Vec3::Z),
        ("^(-90)F", Vec3::NEG_Z),
        ("\\(-90)&F", Vec3::NEG_X),
        ("/(-90)&F", Vec3::X),
        ("f(-2)F", Vec3::NEG_Y),
        ("g(-2)G(-1)", Vec3::NEG_Y * 3.0),
        ("+(0)F", Vec3::Y),
        ("F(0)F", Vec3::Y),
        ("+(360)+(90)-(720)F", Vec3::NEG_X),
        ("+(90)+F", Vec3::NEG_Y),
        ("/&F", Vec3::NEG_X),
        ("\\&F", Vec3::X),
        ("G", Vec3::Y),
        ("fgF", Vec3::Y * 3.0),
        ("&F", Vec3::NEG_Z),
        ("^F", Vec3::Z),
        ("\\F", Vec3::Y),
        ("/(90)&(90)F", Vec3::NEG_X),
        ("\\(90)&(90)F", Vec3::X),
        ("/(90)+(90)F", Vec3::Z),
        ("\\(90)+(90)F", Vec3::NEG_Z),
        ("+&F", Vec3::NEG_Z),
        ("|F", Vec3::NEG_Y),
        ("F|F(3)", Vec3::NEG_Y * 2.0),
        ("|+F", Vec3::X),
        ("f(5)F", Vec3::Y * 6.0),
        ("g(5)F", Vec3::Y * 6.0),
        ("F[+F]F", Vec3::Y * 2.0),
        ("F[+F[-F]f(9)]-F", Vec3::new(1.0, 1.0, 0.0)),
        // $: a heading of +X has its left along Y × X = −Z; then + turns toward −Z whatever the roll was.
        ("-(90)$+(90)F", Vec3::NEG_Z),
        ("-(90)/(77)$+(90)F", Vec3::NEG_Z),
        ("-(90)/(77)$^(90)F", Vec3::Y),
        // $ on a vertical heading changes nothing.
        ("$+(90)F", Vec3::NEG_X),
        // What a skeleton has no place for leaves the turtle alone.
        ("'(2),(3);(1)@O(5)@Gs@Ge~L(2)F", Vec3::Y),
        (
            "'(-2),(-3);(-1)@O(-5)@Ge@Ge~L(-2)?P(0,0,0)T(-1)!(-2)F",
            Vec3::Y,
        ),
        ("',;@O@Gs~L T!F", Vec3::Y),
        ("{.f+f.}F", Vec3::new(-1.0, 1.0, 0.0) + Vec3::NEG_X),
        ("X(3)F", Vec3::Y),
    ] {
        let end = if axiom.starts_with('{') {
            Vec3::new(-2.0, 1.0, 0.0)
        } else {
            end
        };
        let found = end_of(axiom);
        assert!(near(found, end), "{axiom} ends at {found}, not {end}");
    }
}

#[test]
fn angles_default_to_the_grammar_then_to_60() {
    assert!(near(end_of("+(90)F"), Vec3::NEG_X), "stated");
    let tree = tree_of("axiom +F\n");
    assert!(
        near(
            *tree.position.last().unwrap(),
            Vec3::new(-0.866_025_4, 0.5, 0.0)
        ),
        "60 degrees as in L-Py"
    );
}

/// Ten thousand turns leave an orthonormal frame: equal steps there and back end at the start.
#[test]
fn frames_stay_orthonormal() {
    let turns = "+(17.3)&(31.1)/(7.7)".repeat(3333);
    let back = "\\(7.7)^(31.1)-(17.3)".repeat(3333);
    let found = end_of(&format!("F(1000){turns}F(1000)|F(1000)|{back}F(1000)"));
    assert!((found - Vec3::Y * 2000.0).length() < 1e-3, "{found}");
}

#[test]
fn trees_are_topological() {
    let tree = tree_of("angle 90\naxiom !(2)F(1)[+!(1)F][-F[+F]]F f F\n");
    tree_is_whole(&tree);
    let segments: Vec<(u32, f32, u16)> = (0..tree.parent.len())
        .map(|i| (tree.parent[i], tree.radius[i], tree.order[i]))
        .collect();
    assert_eq!(
        segments,
        [
            (NO_PARENT, 1.0, 0),
            (0, 1.0, 0),
            (1, 0.5, 1),
            (1, 1.0, 1),
            (3, 1.0, 2),
            (1, 1.0, 0),
            (NO_PARENT, 1.0, 0), // after f a new root
            (6, 1.0, 0),
        ],
        "parents, radii (half the width), orders"
    );
    assert_eq!(tree.letters, ["F"], "letters that draw");
}

fn tree_is_whole(tree: &Tree) {
    let n = tree.parent.len();
    assert!(
        [
            tree.position.len(),
            tree.radius.len(),
            tree.letter.len(),
            tree.order.len(),
            tree.birth.len()
        ]
        .iter()
        .all(|l| *l == n)
    );
    for i in 0..n {
        assert!(
            tree.parent[i] == NO_PARENT || (tree.parent[i] as usize) < i,
            "parent before child"
        );
        assert!(usize::from(tree.letter[i]) < tree.letters.len(), "letter");
        assert!(
            tree.position[i].is_finite() && tree.radius[i] >= 0.0,
            "finite"
        );
    }
}

#[test]
fn nothing_drawn_is_a_root() {
    for axiom in ["*", "A", "[[+]]", "f(3)", "!(4)"] {
        let tree = tree_of(&format!("axiom {axiom}\n"));
        assert_eq!(
            (tree.parent.as_slice(), tree.position.as_slice()),
            (&[NO_PARENT][..], &[Vec3::ZERO][..]),
            "{axiom}"
        );
        tree_is_whole(&tree);
    }
}

#[test]
fn polygons_draw_no_segments() {
    let tree = tree_of("angle 90\naxiom F{.+F.F}[{.]F.}F\n");
    assert_eq!(
        tree.parent.iter().filter(|p| **p != NO_PARENT).count(),
        2,
        "only the first and the last F"
    );
}

#[test]
fn narrowing() {
    let tree = tree_of("axiom !(2)F!F\n");
    assert!(
        (tree.radius[2] - 0.5_f32.sqrt()).abs() < 1e-6,
        "half the cross-section"
    );
}

/// e·|H × T| radians toward T after each segment.
#[test]
fn tropism() {
    let tree = tree_of("tropism 1 0 0\naxiom T(0.5)F F\n");
    let last = tree.position[2] - tree.position[1];
    assert!(
        near(last, Vec3::new(0.5_f32.sin(), 0.5_f32.cos(), 0.0)),
        "{last}"
    );
    let straight = tree_of("axiom T(0.5)F F\n");
    assert!(
        near(straight.position[2], Vec3::Y * 2.0),
        "without a vector nothing pulls"
    );
}

/// A segment that would go below the ground is turned up; each takes half of what is left of the way down at most.
#[test]
fn ground() {
    let tree = tree_of("ground 0\naxiom F(1) +(180) F(0.8) F(0.8) F(0.8)\n");
    let heights: Vec<f32> = tree.position.iter().map(|place| place.y).collect();
    assert_eq!(heights, [0.0, 1.0, 0.5, 0.25, 0.125]);
    let lengths = (1..4).map(|at| tree.position[at].distance(tree.position[at + 1]));
    assert!(
        lengths
            .into_iter()
            .all(|length| (length - 0.8).abs() < 1e-6)
    );
    // What begins below it goes level at most, up as it is told, and outlines are left alone.
    let below = tree_of(
        "ground 3\naxiom +(120) F(1) -(120) F(1) [ { +(180) F(1) +(90) F(1) } ] +(180) F(1)\n",
    );
    assert!(
        near(below.position[1], Vec3::NEG_X),
        "{}",
        below.position[1]
    );
    assert!(below.position[2].y > 0.4 && below.position.iter().all(|place| place.y >= 0.0));
    let shape = tree_of("ground -0.5\nshape A = [(0 -1 0) (1 -1 0)]\naxiom A\n");
    let lowest = shape
        .position
        .iter()
        .fold(0.0_f32, |low, place| low.min(place.y));
    assert!((lowest + 0.375).abs() < 1e-6, "{lowest}");
}

/// A large plant that sinks is drawn beside itself as in one go, and lies on its ground.
#[test]
fn sinking_plants_are_drawn_in_parts_as_in_one_go() {
    let grammar = parse(
        "ground 0.1\ntropism 0 -1 0\nangle 31\naxiom T(0.2) F(1) A\nA -> F(0.3) [ +A ] [ /(100) -A ] &(20) F(0.4)\n",
    );
    let string = derive(&grammar, 13);
    let never = AtomicBool::new(false);
    let params = TurtleParams::default();
    let read = draw_on(&grammar, &string, &params, &never, |params| {
        TreeCanvas::new(&grammar, params)
    });
    let tree = draw(&grammar, &string);
    assert!(tree.len() > 16_000, "{} nodes", tree.len());
    assert_eq!(tree, read.unwrap().finish());
    let lowest = tree
        .position
        .iter()
        .skip(1)
        .fold(f32::MAX, |low, place| low.min(place.y));
    assert!((0.1..0.2).contains(&lowest), "{lowest}");
}

/// In the start frame a shape's coordinates are the stage's; at the wrap the heading is carried over or restarts.
#[test]
fn shapes() {
    let shape = "shape A = [(0 1 0 0.3) (1 1 0) (0 0 -2)]\n";
    let axiom = "axiom !(0.2)A(0)A(1)A(2)A(3)A(4)A(5)A(6)\n";
    let restart = tree_of(&format!("wrap restart\n{shape}{axiom}"));
    let round = Vec3::new(1.0, 2.0, -2.0);
    let ends = [Vec3::Y, Vec3::new(1.0, 2.0, 0.0), round];
    for i in 0..7 {
        let expected = round * (i / 3) as f32 + ends[i % 3];
        assert!(
            near(restart.position[i + 1], expected),
            "restart {i}: {} {expected}",
            restart.position[i + 1]
        );
    }
    assert_eq!(
        &restart.radius[..4],
        &[0.3, 0.3, 0.1, 0.1],
        "a radius from the shape, else half the width"
    );

    let carry = tree_of(&format!("{shape}{axiom}"));
    for (i, end) in ends.iter().enumerate() {
        assert!(
            near(carry.position[i + 1], *end),
            "the first time is as drawn"
        );
    }
    let direction = |tree: &Tree, i: usize| (tree.position[i + 1] - tree.position[i]).normalize();
    assert!(
        near(direction(&carry, 3), direction(&carry, 2)),
        "the first repeated segment goes on as the last one"
    );
    assert!(
        near(direction(&carry, 6), direction(&carry, 5)),
        "and again"
    );
    for i in 0..4 {
        let angle = |tree: &Tree, at: usize| direction(tree, at).dot(direction(tree, at + 1));
        if i != 2 {
            assert!(
                (angle(&carry, i) - angle(&carry, i % 3)).abs() < 1e-5,
                "the same bends each time"
            );
        }
    }
}

#[test]
fn shapes_in_odd_directions() {
    for (x, y, z) in [
        (0.0, -1.0, 0.0),
        (0.0, 1.0, 0.0),
        (1e-9, -1.0, 0.0),
        (0.0, 0.0, 0.0),
        (3.0, -4.0, 12.0),
    ] {
        let tree = tree_of(&format!(
            "shape A = [({x} {y} {z}) ({x} {y} {z}) (0 -1 0)]\naxiom A(0)A(1)A(2)A(3)A\n"
        ));
        tree_is_whole(&tree);
        let first = Vec3::new(x as f32, y as f32, z as f32);
        assert!(
            near(tree.position[1], first) && near(tree.position[2], first * 2.0),
            "along {first}"
        );
        assert_eq!(
            tree.parent.len(),
            8,
            "without a parameter the whole shape is drawn"
        );
    }
}

/// A branch begins in the frame of its parent segment, turned by the roll that the string says.
#[test]
fn branches_begin_in_the_parents_frame() {
    let shapes = "shape A = [(1 0 0)]\nshape C = [(0.6 0.8 0)]\n";
    // Along +X the frame is X = −Y, Y = +X: the branch's own (0.6, 0.8, 0) is (0.8, −0.6, 0).
    let tree = tree_of(&format!("{shapes}axiom A(0)[C(0)B]A(1)\n"));
    assert!(
        near(
            tree.position[2] - tree.position[1],
            Vec3::new(0.8, -0.6, 0.0)
        ),
        "{}",
        tree.position[2]
    );
    let turned = tree_of(&format!("{shapes}axiom A(0)[/(180)C(0)B]A(1)\n"));
    assert!(
        near(
            turned.position[2] - turned.position[1],
            Vec3::new(0.8, 0.6, 0.0)
        ),
        "{}",
        turned.position[2]
    );
    assert!(
        near(turned.position[3], Vec3::X * 2.0),
        "the parent goes on"
    );
    assert_eq!(turned.letters, ["A", "C"], "letters");
    assert_eq!(turned.order, [0, 0, 1, 0], "orders");
}

/// Unchanged modules keep their birth; the first successor equal to the predecessor inherits it.
#[test]
fn births() {
    let grammar = parse("axiom F(0) B\nF(x) > B -> F(x) F(x+1)\n");
    let string = derive(&grammar, 3);
    let born = |string: &ModuleString| string.births().collect::<Vec<_>>();
    assert_eq!(born(&string), [0, 1, 2, 3, 0], "F(0) F(1) F(2) F(3) B");
    assert_eq!(
        draw(&grammar, &string).birth,
        [0, 0, 1, 2, 3],
        "the root, then the segments"
    );
    for (text, steps, expected) in [
        ("axiom A\nA -> AA\n", 2, &[0, 2, 1, 2][..]),
        ("axiom A(1)\nA(x) -> A(x+1)\n", 2, &[2]),
        ("axiom A(1)\nA(x) -> A(x+1) A(x) A(x)\n", 1, &[1, 0, 1]),
        ("axiom A B\nA -> B A(1) A\n", 1, &[1, 1, 0, 0]),
        ("axiom A\nA -> B\ndecompose {\n  B -> C C\n}\n", 1, &[1, 1]),
    ] {
        assert_eq!(born(&derive(&parse(text), steps)), expected, "{text}");
    }
    // Interpretation draws parts as old as the module they show.
    let shown = parse("axiom A\nA -> A A\ninterpret {\n  A -> F[+F]\n}\n");
    assert_eq!(
        draw(&shown, &derive(&shown, 2)).birth,
        [0, 0, 0, 2, 2, 1, 1, 2, 2],
        "two segments each"
    );
}

#[test]
fn limits_of_the_turtle() {
    let run = |text: &str, params: &TurtleParams| {
        let grammar: Grammar = parse(text);
        interpret(
            &grammar,
            &derive(&grammar, 0),
            params,
            &AtomicBool::new(false),
        )
        .map_err(|e| *e.problem)
    };
    let small = TurtleParams {
        max_depth: 2,
        max_nodes: 3,
        ..TurtleParams::default()
    };
    assert!(matches!(
        run("axiom [[[]]]\n", &small),
        Err(DeriveProblem::TooDeep {
            position: 2,
            depth: 2
        })
    ));
    assert!(matches!(
        run("axiom FFF\n", &small),
        Err(DeriveProblem::TooManyNodes { limit: 3 })
    ));
    assert!(run("axiom FF\n", &small).is_ok(), "at the limit");
    let far = run("axiom F(1e300)\n", &small);
    assert!(
        matches!(&far, Err(DeriveProblem::TooFar { position: 0, module }) if module == "F"),
        "{far:?}"
    );
    let wide = run("axiom !(1e300)F\n", &small);
    assert!(
        matches!(wide, Err(DeriveProblem::TooWide { position: 1, .. })),
        "{wide:?}"
    );
    let grammar = parse("axiom F\n");
    let cancelled = interpret(
        &grammar,
        &derive(&grammar, 0),
        &small,
        &AtomicBool::new(true),
    );
    assert!(cancelled.unwrap_err().is_cancelled());
}

/// A tree drawn in parts beside each other is that of one thread, for whatever stands across their borders.
#[test]
fn trees_do_not_depend_on_threads() {
    let long = "F+(3)F".repeat(3000);
    for (text, steps) in [
        (
            include_str!("../../assets/grammars/honda.lsys").to_owned(),
            14,
        ),
        (
            include_str!("../../assets/grammars/ternary.lsys").to_owned(),
            8,
        ),
        // Large branches with moves, outlines in branches and across them, branches at once after a move.
        (
            format!("axiom f A\nA -> [{long} f F]f(2)[+A F]F[f[A]F]{{.F[+F.]F}}A\n"),
            6,
        ),
        (format!("axiom A\nA -> F[{long}{{.]F.}}[{long}A]F\n"), 5),
        // Shapes, whole and by the segment, placed and across brackets.
        (
            format!(
                "shape S = [(0 1 0) (1 0 0) (0 0 2)]\naxiom A(0)\n\
                 A(x) -> S(x)[+(50)S ~S(2){long}f ~S S A(x+1)]S(x+1)f[{long}~S[F]A(x)]\n"
            ),
            5,
        ),
        // All in one piece, which is cut anywhere: within small branches, outlines, shapes, after moves, with and without parameters.
        (format!("axiom {}\n", "F+F[-F[f F]&F]/F!F".repeat(6000)), 0),
        (
            format!(
                "shape S = [(0 1 0) (1 0 0) (0 0 2)]\naxiom {}\n",
                "F(1)+(3)[f F]f S(1)~S{.F[+F.]F.}!(0.2)[[S]$F]f(2)".repeat(3000)
            ),
            0,
        ),
        // One long branch that begins with moves, and another depth of brackets at each border.
        (
            format!("axiom f[[[{long}[A]]]]F\nA -> [f{long}]{long}[A]\n"),
            8,
        ),
    ] {
        let grammar = parse(&text);
        let string = derive(&grammar, steps);
        assert!(
            string.len() > 1 << 15,
            "long enough to be drawn in parts: {}",
            string.len()
        );
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap().install(|| draw(&grammar, &string))
        };
        let alone = on(1);
        tree_is_whole(&alone);
        for threads in [2, 3, 5, 16] {
            assert!(
                on(threads) == alone,
                "{threads} threads: {}",
                &text[..text.len().min(80)]
            );
        }
        // And it is that of the canvas that is drawn on in one go.
        let (params, cancel) = (TurtleParams::default(), AtomicBool::new(false));
        let canvas = draw_on(&grammar, &string, &params, &cancel, |params| {
            TreeCanvas::new(&grammar, params)
        });
        assert!(canvas.unwrap().finish() == alone, "in one go");
        let drawing = ramus::lsystem::draw(&grammar, &string, &params, &cancel).unwrap();
        assert!(drawing.tree == alone, "with its organs");
    }
}

/// The first fault of the string is told, whoever finds one first.
#[test]
fn faults_do_not_depend_on_threads() {
    let long = "F".repeat(40_000);
    let text = format!("axiom [{long}][{long}F(1e300)][F(1e300){long}][!(1e300)F]{long}F(1e300)\n");
    let grammar = parse(&text);
    let string = derive(&grammar, 0);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let error = pool.unwrap().install(|| {
            let (params, cancel) = (TurtleParams::default(), AtomicBool::new(false));
            interpret(&grammar, &string, &params, &cancel).unwrap_err()
        });
        assert!(
            matches!(
                *error.problem,
                DeriveProblem::TooFar {
                    position: 80_003,
                    ..
                }
            ),
            "{threads} threads: {error}"
        );
    }
}
