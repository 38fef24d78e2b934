//! What rules and parameters of Houdini become, and what is drawn.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use ramus::lsystem::dialect::Dialect::Houdini;
use ramus::lsystem::{Grammar, TurtleParams, interpret};

use super::{brought, derive, fault, lines, string};

const VALUES: &str = "step size scale: 0.5\nangle scale: 0.5\nthickness scale: 0.5\nangle: 90\n";

/// The productions that rules become.
fn rules(text: &str) -> Vec<String> {
    let except = ["const", "angle", "axiom", "module", "interpret", "}"];
    let made = lines(Houdini, &format!("premise: A\n{VALUES}{text}\n"), &except);
    made.into_iter()
        .filter(|l| !l.contains("-> @") && !l.contains("(p1) ->"))
        .collect()
}

#[test]
fn rules_of_the_node() {
    for (theirs, ours) in [
        ("A=FF[+A]", vec!["A -> F F [ - A ]"]),
        ("rule 1: A=B", vec!["A -> B"]),
        ("A=", vec!["A -> *"]),
        (
            "A(i,j):i>=3=F(j)A(i+1,j*0.5)",
            vec!["A(i, j) : i >= 3 -> F(j) A(i + 1, j*0.5)"],
        ),
        (
            "A< F(i) >B :i<10 = F(5)F(i+1) :0.5",
            vec!["A < F(i) > B : i < 10, weight 0.5 -> F(5) F(i + 1)"],
        ),
        (
            "A=F:0.25\nA=G:0.75",
            vec!["A : weight 0.25 -> F", "A : weight 0.75 -> G"],
        ),
        (
            "A=-(30)+&^/\\|$J(2)KM",
            vec!["A -> +(30) - & ^ / \\ | $ ~J(2) ~K ~M"],
        ),
        ("J=K", vec!["~J -> ~K"]),
        (
            "A(x)=B(sin(x)^2,pow(x,2),int(x))",
            vec!["A(x) -> B(sin(x)^2, x^2, sign(x)*floor(abs(x)))"],
        ),
        ("A(x):x&1|0=B", vec!["A(x) : x && 1 || 0 -> B"]),
    ] {
        assert_eq!(rules(theirs), ours, "{theirs}");
    }
}

/// Where the last segment of a string ends.
fn end(premise: &str) -> Vec3 {
    let text = format!("dialect houdini\npremise: {premise}\ngenerations: 0\n{VALUES}");
    let grammar = Grammar::parse(&text, "t").unwrap_or_else(|e| panic!("{e}\n{text}"));
    let made = derive(&grammar, 0);
    let tree = interpret(
        &grammar,
        &made,
        &TurtleParams::default(),
        &AtomicBool::new(false),
    )
    .unwrap();
    *tree.position.last().unwrap()
}

#[test]
fn the_turtle_draws_what_houdini_draws() {
    for (premise, expected) in [
        ("F", Vec3::Y),
        // Houdini turns right with `+`; its pitches are ours.
        ("+F", Vec3::X),
        ("-F", -Vec3::X),
        ("&F", -Vec3::Z),
        ("\"F", Vec3::Y * 0.5),
        ("\"(3)F", Vec3::Y * 3.0),
        ("\"F(2)", Vec3::Y * 2.0),
        ("_F", Vec3::Y * 2.0),
        ("_(4)F", Vec3::Y * 0.25),
        ("[\"F]F", Vec3::Y),
        ("H", Vec3::Y * 0.5),
        ("HF", Vec3::Y * 1.5),
        ("H(3)", Vec3::Y * 1.5),
        ("hF", Vec3::Y * 1.5),
        (
            ";+F;(2)+F",
            Vec3::new(
                0.5_f32.sqrt() + 0.5_f32.sqrt(),
                0.5_f32.sqrt() - 0.5_f32.sqrt(),
                0.0,
            ),
        ),
        ("@(0.5)+F", -Vec3::Y),
        ("*+F", -Vec3::X),
    ] {
        assert!(
            end(premise).distance(expected) < 1e-5,
            "{premise}: {}, not {expected}",
            end(premise)
        );
    }
}

#[test]
fn widths_are_scaled() {
    let text =
        format!("dialect houdini\npremise: F!F![!F]?F\nthickness: 0.8\ngenerations: 0\n{VALUES}");
    let grammar = Grammar::parse(&text, "t").unwrap();
    let made = derive(&grammar, 0);
    let tree = interpret(
        &grammar,
        &made,
        &TurtleParams::default(),
        &AtomicBool::new(false),
    )
    .unwrap();
    assert_eq!(tree.radius, [0.4, 0.4, 0.2, 0.05, 0.2]);
}

#[test]
fn a_whole_node() {
    let text = "# the node's tabs, Rules and Values\ngenerations: 3\npremise: FFFA\nRule 1: A=!\"[B]////[B]////B\nRule 2: B=&FFFA\nangle: 28\nstep size scale: 0.9\nthickness scale: 0.8\ncontext ignore: F+-\nvariable b: 3\ngravity: 20\n";
    let expected = [
        "const step_size_scale = 0.9",
        "const thickness_scale = 0.8",
        "const b = 3",
        "steps 3",
        "angle 28",
        "module Thicker",
        "module Longer",
        "ignore F - +",
        "axiom F F F A",
        "A -> Thicker Longer [ B ] / / / / [ B ] / / / / B",
        "B -> & F F F A",
        "interpret {",
        "Longer -> @l(step_size_scale)",
        "Thicker -> @w(thickness_scale)",
        "}",
    ];
    assert_eq!(lines(Houdini, text, &[]), expected);
    let said: Vec<String> = brought(Houdini, text)
        .remarks
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(
        said,
        ["test:11:1: not carried over: `gravity`: state `tropism 0 -1 0` and use `T(e)`"]
    );
    let made = string(&format!("dialect houdini\n{text}"), 2);
    assert_eq!(made, "FFFThickerLonger[&FFFA]////[&FFFA]////&FFFA");
}

#[test]
fn faults_are_told_where_the_text_has_them() {
    for (text, line, column, part) in [
        (
            "premise: A\nA=\"F",
            2,
            3,
            "uses the node's step size scale; expected a line `step size scale: …`",
        ),
        ("premise: A\nA=!F", 2, 3, "thickness scale"),
        ("premise: A\nA(i)=B(t)", 2, 8, "unknown name `t`"),
        (
            "premise: A\nA(i)=B(rand(i))",
            2,
            8,
            "`rand` with 1 argument",
        ),
        ("premise: A\nA=F`ch(\"x\")`", 2, 4, "backquotes"),
        ("premise: A\nAB=F", 2, 2, "the one symbol"),
        ("premise: A\nA F", 2, 3, "expected `=` or `:`"),
        ("premise: A\nA=F[", 2, 4, "not closed"),
        ("A=F", 1, 1, "no axiom"),
    ] {
        let (l, c, message) = fault(Houdini, text);
        assert!(message.contains(part), "{text}: {message}");
        assert_eq!((l, c), (line, column), "{text}: {message}");
    }
}
