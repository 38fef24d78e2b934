//! Query modules: the turtle answers after each step, and productions act on the answers.

use std::sync::atomic::AtomicBool;

use ramus::lsystem::{Grammar, Limits, ModuleString};

use super::{derive, draw, parse, text_of};

#[test]
fn answers() {
    for (text, steps, expected) in [
        ("axiom F(2)?P(0,0,0)", 0, "F(2)?P(0,2,0)"),
        (
            "axiom ?P(9,9,9)?H(0,0,0)?U(0,0,0)?L(0,0,0)",
            0,
            "?P(0,0,0)?H(0,1,0)?U(0,0,1)?L(-1,0,0)",
        ),
        // Two parameters: x and y.
        ("axiom f(3)F[+(180)F]?P(7,7)", 0, "f(3)F[+(180)F]?P(0,4)"),
        // After each step, before anything reads them.
        ("axiom A?P(0,0,0)\nA -> F A", 3, "FFFA?P(0,3,0)"),
        (
            "axiom A?P(0,0,0)\nA > ?P(x,y,z) : y < 2 -> F A",
            5,
            "FFA?P(0,2,0)",
        ),
        (
            "axiom B\nB -> F(4)?P(0,0,0) B\n?P(x,y,z) : y > 0 -> C(y)",
            2,
            "F(4)C(4)F(4)?P(0,8,0)B",
        ),
        // What a block draws counts, though it is not in the string.
        (
            "axiom A?P(0,0,0)\nA -> A A\ninterpret {\n A -> F(5)\n}",
            1,
            "AA?P(0,10,0)",
        ),
        (
            "axiom A?P(0,0,0)\ndecompose {\n A -> F(5)\n}",
            0,
            "F(5)?P(0,5,0)",
        ),
        // Branches give the turtle back, outlines do not draw but move it.
        (
            "axiom [F?P(0,0,0)]{.F}?P(0,0,0)",
            0,
            "[F?P(0,1,0)]{.F}?P(0,1,0)",
        ),
        // Turned by the step before.
        ("angle 90\naxiom ?H(0,0)A\nA -> +?H(0,0)A", 0, "?H(0,1)A"),
    ] {
        let grammar = parse(&format!("{text}\n"));
        assert_eq!(text_of(&grammar, steps), expected, "{text}");
        // Step by step it is the same.
        let mut string = derive(&grammar, 0);
        for step in 1..=steps {
            let limits = Limits::default();
            string = grammar
                .derive_next(&string, step, &limits, &AtomicBool::new(false))
                .unwrap();
        }
        assert_eq!(string.to_text(&grammar), expected, "{text}, step by step");
    }
}

#[test]
fn refusals() {
    for (text, expected) in [
        (
            "axiom ?P\n",
            "the two or three that the turtle writes its answer into",
        ),
        ("axiom ?H(1)\n", "?H(0, 0, 0)"),
        ("axiom ?L(1,2,3,4)\n", "with 4 parameters"),
        ("axiom ?X(1,2,3)\n", "`?P`, `?H`, `?U`, `?L`, `?S`, `?C`"),
        ("axiom F?C\n", "as in `?C(0, 0, 0)`"),
        ("axiom F?C(1)\n", "found `?C` with 1 parameters"),
        (
            "axiom A?C(0,1)\ninterpret {\n A -> F?C(0,1)\n}\n",
            "`interpret` block",
        ),
        (
            "axiom A?P(0,0)\ninterpret {\n A -> ?P(0,0)\n}\n",
            "`interpret` block",
        ),
        (
            "axiom A?P(0,0)\ninterpret {\n A -> F%\n}\n",
            "neither queries nor `%`",
        ),
    ] {
        let errors = Grammar::parse(text, "test.lsys").unwrap_err().to_string();
        assert!(errors.contains(expected), "{text}\n{errors}");
    }
}

/// A branching structure pruned to a square, after Prusinkiewicz, James and Měch 1994, "Synthetic topiary", section 5: an apex out of
/// the square is cut, the signal S runs down its branch and wakes the dormant buds.
#[test]
fn topiary_stays_in_its_square() {
    let grammar = parse(include_str!("../../assets/grammars/topiary.lsys"));
    let apices = |string: &ModuleString| string.to_text(&grammar).matches('A').count();
    let mut most = 0;
    for steps in [4, 12, 30, 70] {
        let string = derive(&grammar, steps);
        let tree = draw(&grammar, &string);
        let (min, max) = tree.bounds().unwrap();
        let (half, side, reach) = (10.0, 20.0, 1.001);
        assert!(
            min.x > -half - reach && max.x < half + reach && min.y > -reach && max.y < side + reach,
            "{steps} steps: {min} {max}"
        );
        most = most.max(apices(&string));
        if steps == 70 {
            assert!(
                max.x > half - 2.0 && min.x < 2.0 - half,
                "it fills the square: {min} {max}"
            );
        }
    }
    assert!(most > 3, "cut branches wake others: {most}");
}

/// `?S` is told the light between the leaves of all `?S`: much at the top, less below, nearly all where its own leaves alone take some.
#[test]
fn light_reaches_the_top_and_less_of_it_what_is_below() {
    let light = |text: &str| -> Vec<f64> {
        let string = derive(&parse(text), 0);
        let asked = string.iter().filter(|module| module.parameters.len() == 2);
        asked.map(|module| module.parameters[0]).collect()
    };
    let [alone] = light("axiom F(3)?S(0, 0.1)")[..] else {
        panic!("one")
    };
    assert!(alone > 0.8, "{alone}");
    // Five floors of nine leaves each, a metre apart.
    let floor = "[+(90)f(0.5)?S(0, 0.2)][-(90)f(0.5)?S(0, 0.2)][&(90)f(0.5)?S(0, 0.2)][^(90)f(0.5)?S(0, 0.2)]?S(0, 0.2)";
    let told = light(&format!("axiom {}", format!("F(1){floor}").repeat(5)));
    assert_eq!(told.len(), 25);
    let floors: Vec<f64> = told
        .chunks(5)
        .map(|floor| floor.iter().sum::<f64>() / 5.0)
        .collect();
    assert!(
        floors.windows(2).all(|pair| pair[0] < pair[1]),
        "{floors:?}"
    );
    assert!(floors[0] < 0.9 * floors[4] && floors[0] > 0.0, "{floors:?}");
    // What takes no light leaves all of it.
    assert_eq!(light("axiom F?S(0, 0)F?S(0, 0)"), [1.0, 1.0]);
}

/// `?C` is told how far the nearest wood is that is neither of its own line nor of the line that this grows from.
#[test]
fn clearance_is_that_of_other_branches() {
    let far = |text: &str| -> Vec<f64> {
        let string = derive(&parse(text), 0);
        let asked = string.iter().filter(|module| module.parameters.len() == 2);
        asked.map(|module| module.parameters[0]).collect()
    };
    for (text, expected) in [
        // Alone, and among its own.
        ("axiom F(3)?C(7, 2)", vec![2.0]),
        ("axiom F(3)[+(90)F(1)?C(7, 5)]F(1)", vec![5.0]),
        // A sibling from the same node, an ancestor's parent, what is beyond the second parameter.
        (
            "axiom F(3)[+(90)F(2)?C(0, 9)][-(90)F(2)?C(0, 9)]",
            vec![2.0, 2.0],
        ),
        ("axiom F(3)[+(90)F(2)[F(1)?C(0, 9)]]", vec![3.0]),
        ("axiom F(3)[+(90)F(2)[F(1)?C(0, 1.5)]]", vec![1.5]),
        // Beside two trees, a metre apart; a move begins another line.
        ("axiom [F(2)?C(0, 9)]+(90)f(1)-(90)F(2)", vec![1.0]),
        // It looks nowhere.
        ("axiom [F(2)?C(5, 0)][+F(1)]", vec![0.0]),
        ("axiom [F(2)?C(5, -1)][+F(1)]", vec![0.0]),
        // What is drawn counts, not what is in the string.
        (
            "axiom X[+(90)F(2)[F(1)?C(0, 9)]]\ninterpret {\n X -> F(3)\n}",
            vec![3.0],
        ),
    ] {
        let told = far(&format!("{text}\n"));
        assert_eq!(told.len(), expected.len(), "{text}");
        for (told, expected) in told.iter().zip(expected) {
            assert!((told - expected).abs() < 1e-6, "{text}: {told}");
        }
    }
}

/// Two shoots that bend towards each other stop before they meet, and the same for any number of threads.
#[test]
fn ends_stop_where_wood_is_near() {
    let text = "const room = 0.7\naxiom [A(20)?C(room, room)]f(0.1)-(90)f(6)+(90)[A(-20)?C(room, room)]\ncontext literal\nA(a) > ?C(c, r) : c < r -> *\nA(a) -> -(a/4)F(0.5)A(a)\n";
    let grammar = parse(text);
    let tree = draw(&grammar, &derive(&grammar, 40));
    let free = parse(&text.replace("c < r", "c < 0"));
    let freely = draw(&free, &derive(&free, 40));
    assert!(tree.segment_count() * 2 < freely.segment_count());
    let (left, right): (Vec<_>, Vec<_>) = tree.position.iter().partition(|at| at.x < 3.0);
    let gap = left
        .iter()
        .flat_map(|a: &glam::Vec3| right.iter().map(move |b| a.distance(*b)));
    let gap = gap.fold(f32::INFINITY, f32::min);
    assert!(
        (0.1..0.7).contains(&gap),
        "they come near, and no nearer than a segment more: {gap}"
    );
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let again = pool.install(|| draw(&grammar, &derive(&grammar, 40)));
        assert_eq!(again, tree, "{threads} threads");
    }
}

/// Huge and tiny numbers are no panic.
#[test]
fn hostile_clearances() {
    for text in [
        "axiom F(1e30)?C(0, 1e300)[+F(1e-30)?C(0, 1e-300)]",
        "axiom F(0)?C(0, 1)[F(0)?C(0, 1)][F(0)?C(0, 1)]",
        "axiom [[[?C(0, 1)]]]",
        "axiom F?C(0, 1, 2)",
        "axiom f?C(0, 1)F?C(0, 1)]",
        "axiom F(1e300)?C(0, 1)",
    ] {
        let Ok(grammar) = Grammar::parse(&format!("{text}\n"), "test.lsys") else {
            continue;
        };
        let limits = Limits::default();
        match grammar.derive(3, &limits, &AtomicBool::new(false)) {
            Ok(string) => assert!(
                string
                    .iter()
                    .all(|module| module.parameters.iter().all(|p| p.is_finite()))
            ),
            Err(error) => assert!(
                error.to_string().contains("?C") || error.to_string().contains('F'),
                "{error}"
            ),
        }
    }
}
