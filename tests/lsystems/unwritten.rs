//! Strings that are not written down: the same modules, counts and growth as those that are, at any length.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use ramus::lsystem::report::Report;
use ramus::lsystem::{DeriveProblem, Grammar, Limits, TurtleParams, Unwritten};

use super::{derive, draw, parse};

const SYSTEMS: [(&str, u32); 8] = [
    ("axiom b\na -> ab\nb -> a\n", 14),
    ("axiom A\nA -> AB\n", 300),
    ("axiom X\nX -> F[+X]F[-X]+X\nF -> FF\n", 5),
    ("axiom A F(1) A\nA -> F(2)[A]F(3,4)\nF(x) -> F(x+0.1)A\n", 5),
    (
        "axiom A\nA -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\nF -> S/////F\nS -> FL\nL -> ['''^^{-f+f+f-|-f+f+f}]\n",
        5,
    ),
    ("axiom A\nA -> B\nB -> *\n", 3),
    (
        "axiom A\nshape A = [(0 1 0) (1 1 0)]\nA -> {F.F}A A(1) F\n",
        4,
    ),
    (include_str!("../../assets/grammars/honda.lsys"), 7),
];

fn unwritten(grammar: &Grammar, steps: u32) -> Unwritten {
    let never = AtomicBool::new(false);
    let made = grammar.unwritten(steps, &Limits::default(), &never);
    made.unwrap().unwrap()
}

/// The string by rounds, step after step, and its length at each.
fn by_rounds(grammar: &Grammar, steps: u32) -> (ramus::lsystem::ModuleString, Vec<u128>) {
    let mut string = derive(grammar, 0);
    let mut lengths = vec![string.len() as u128];
    for step in 1..=steps {
        let never = AtomicBool::new(false);
        string = grammar
            .derive_next(&string, step, &Limits::default(), &never)
            .unwrap();
        lengths.push(string.len() as u128);
    }
    (string, lengths)
}

#[test]
fn it_is_the_string_that_rounds_make() {
    for (text, steps) in SYSTEMS {
        let grammar = parse(text);
        let string = unwritten(&grammar, steps);
        let (rounds, lengths) = by_rounds(&grammar, steps);
        assert!(string.iter().eq(rounds.iter()), "{text}");
        assert!(string.growth().eq(lengths), "{text}");
        assert_eq!(string.modules(), rounds.len() as u128);
        assert_eq!(string.bytes(), u128::from(derive(&grammar, steps).bytes()));
        for position in (0..=rounds.len()).step_by(1 + rounds.len() / 40) {
            let rest = string.iter_from(position as u128);
            assert!(
                rest.eq(rounds.iter().skip(position)),
                "{text} from {position}"
            );
        }
        let mut written = Vec::new();
        string.write_text(&grammar, &mut written).unwrap();
        assert_eq!(
            String::from_utf8(written).unwrap(),
            rounds.to_text(&grammar)
        );
    }
}

#[test]
fn counts_are_those_of_the_string() {
    for (text, steps) in SYSTEMS {
        let grammar = parse(text);
        let counts = unwritten(&grammar, steps).counts(&grammar);
        let string = derive(&grammar, steps);
        let tree = draw(&grammar, &string);
        let report = Report::new(&grammar, &string, &tree, steps, 0.0, 0.0);
        assert_eq!(counts.text(), report.counts_text(), "{text}");
        assert_eq!(counts.modules, u128::from(report.modules));
    }
}

/// The numbers of Fibonacci, far beyond what a string can hold.
#[test]
fn billions_and_more_are_counted_at_once() {
    let algae = parse("axiom b\na -> ab\nb -> a\n");
    let began = Instant::now();
    let string = unwritten(&algae, 180);
    let mut last = (1_u128, 1_u128);
    for modules in string.growth().skip(2) {
        last = (last.1, last.0 + last.1);
        assert_eq!(modules, last.1);
    }
    let counts = string.counts(&algae);
    assert_eq!(
        (counts.counts["b"], counts.counts["a"]),
        (last.1 - last.0, last.0)
    );
    let middle = string.iter_from(string.modules() / 2).take(1000);
    assert_eq!(
        middle
            .filter(|module| algae.name(module.symbol) == "a")
            .count(),
        618
    );
    assert!(
        began.elapsed() < Duration::from_secs(2),
        "{:?}",
        began.elapsed()
    );

    let doubling = parse("axiom F\nF -> FF\n");
    assert_eq!(unwritten(&doubling, 127).modules(), 1 << 127);
    let never = AtomicBool::new(false);
    let error = doubling
        .unwritten(1000, &Limits::default(), &never)
        .unwrap_err();
    assert_eq!(*error.problem, DeriveProblem::Countless { step: 128 });
    let strangers = parse("axiom A(1)\nA(x) -> A(2*x) A(2*x+1)\n");
    let cancelled = strangers.unwritten(40, &Limits::default(), &AtomicBool::new(true));
    assert!(cancelled.unwrap_err().is_cancelled());
}

#[test]
fn what_has_to_be_derived_is_said() {
    for text in [
        "axiom A\nA < A -> A\n",
        "axiom A\nA : weight 1 -> A\n",
        "axiom A(0)\nA(x) -> A(1/x)\n",
    ] {
        let never = AtomicBool::new(false);
        let made = parse(text).unwritten(3, &Limits::default(), &never);
        assert!(made.unwrap().is_none(), "{text}");
    }
}

/// The limit is told before anything is made, and what is kept is soon made.
#[test]
fn a_limit_costs_no_time() {
    let began = Instant::now();
    let error = parse("axiom F\nF -> FF\n")
        .derive(40, &Limits::default(), &AtomicBool::new(false))
        .unwrap_err();
    assert!(
        matches!(*error.problem, DeriveProblem::Limit { step: 31 | 32, .. }),
        "{error}"
    );
    let (step, string) = *error.last.unwrap();
    assert_eq!(string.len(), 1 << step);
    assert!(
        step >= 20 && began.elapsed() < Duration::from_secs(1),
        "{step} {:?}",
        began.elapsed()
    );
}

/// Drawn as it comes, a string has the counts and measures that it has written down.
#[test]
fn streamed_reports_are_those_of_string_and_tree() {
    for (text, steps) in [
        (include_str!("../../assets/grammars/honda.lsys"), 9),
        (include_str!("../../assets/grammars/ternary.lsys"), 5),
        ("axiom A(1)\nA(x) -> F(x) [+A(x/2)] f(x) [-A(x/2)]\n", 7),
        // An `interpret` block, over several of the pieces that it is shown.
        (
            "angle 30\naxiom A(1)\nA(x) -> S(x) [+A(x/2)] [-A(x/2)]\nS(x) -> S(x*1.1)\n\
             interpret depth 2 {\n  S(x) -> !(x/10) B F(x)\n  B -> [&(90)F]\n}\n",
            14,
        ),
        ("axiom b\na -> ab\nb -> a\n", 20),
    ] {
        let grammar = parse(text);
        let (limits, cancel) = (Limits::default(), AtomicBool::new(false));
        let string = derive(&grammar, steps);
        let written = Report::new(&grammar, &string, &draw(&grammar, &string), steps, 0.0, 0.0);
        let unwritten = grammar.unwritten(steps, &limits, &cancel).unwrap().unwrap();
        let params = TurtleParams::default();
        let mut streamed =
            Report::streamed(&grammar, unwritten.iter(), steps, &params, &cancel).unwrap();
        streamed.turtle_ms = 0.0;
        assert_eq!(streamed, written, "{text}");
    }
}
