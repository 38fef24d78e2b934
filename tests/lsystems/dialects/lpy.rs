//! What files of L-Py become.

use ramus::lsystem::dialect::Dialect::Lpy;

use super::{brought, fault, lines, string};

const HEAD: [&str; 6] = ["const", "steps", "axiom", "interpret", "}", "module"];

/// The productions that rules become.
fn rules(text: &str) -> Vec<String> {
    lines(
        Lpy,
        &format!("Axiom: A\nproduction:\n{text}\nendlsystem\n"),
        &HEAD,
    )
}

#[test]
fn rules_with_arrows() {
    for (theirs, ours) in [
        ("A --> B", "A -> B"),
        ("A --> *", "A -> *"),
        ("A -->", "A -> *"),
        ("A(x) --> F(x)[+A(x/2)]", "A(x) -> F(x) [ + A(x/2) ]"),
        (
            "A --> Left(30)Down^(2)RollL\\RollR(1)TurnAround",
            "A -> +(30) & ^(2) / \\ \\(1) |",
        ),
        (
            "A --> F(1)f(2)@v@O(3);(1),(2),",
            "A -> F(1) f(2) $ @O(3) '(1) ,(2) ,",
        ),
        ("A --> {.F.}@Gc F @Ge", "A -> { . F . } @Gs F @Ge"),
        ("A --> StartGC F EndGC", "A -> @Gs F @Ge"),
        (
            "A --> ~l(2) ~('k', 3) surface(\"m\")",
            "A -> ~l(2) ~k(3) ~m",
        ),
        ("L < A(x) > R[H] --> B", "L < A(x) > R [ H ] -> B"),
        ("A -static-> B", "A -> B"),
        ("A --> B # gone", "A -> B"),
        ("A --> F\n  F\n  [F]", "A -> F F [ F ]"),
        ("A --> G T", "A -> G′ T′"),
        ("A --> ?P(x0,1,2)", "A -> ?P(1, 2, x0)"),
    ] {
        let theirs = theirs.replace("x0", "0");
        assert_eq!(rules(&theirs), [ours.replace("x0", "0")], "{theirs}");
    }
}

#[test]
fn python_decides_what_is_produced() {
    for (theirs, ours) in [
        ("A(x) :\n  produce B(x)", vec!["A(x) -> B(x)"]),
        ("A(x) : produce B(x)", vec!["A(x) -> B(x)"]),
        ("A :\n  produce", vec!["A -> *"]),
        (
            "A(x) :\n  if x > 3:\n    produce B\n  elif x > 2: produce C\n  else:\n    produce D",
            vec!["A(x) : x > 3 -> B", "A(x) : x > 2 -> C", "A(x) -> D"],
        ),
        // Where a way produces nothing, the rest has to say what it is.
        (
            "A(x) :\n  if x > 3:\n    y = 1\n  else:\n    produce D",
            vec!["A(x) : !(x > 3) -> D"],
        ),
        (
            "A(x) :\n  if x > 3:\n    if x < 5: produce B\n  produce C",
            vec![
                "A(x) : x > 3 && x < 5 -> B",
                "A(x) : x > 3 -> C",
                "A(x) : !(x > 3) -> C",
            ],
        ),
        (
            "A(x) :\n  y = x*2\n  y += 1\n  nproduce B(y)\n  for_later = y\n  produce C(for_later)",
            vec!["A(x) -> B(x*2 + 1) C(x*2 + 1)"],
        ),
        (
            "A :\n  if random() < 0.25:\n    produce B\n  else:\n    produce C",
            vec!["A : weight 0.25 -> B", "A : weight 1 - 0.25 -> C"],
        ),
        (
            "A(x) --> B(x if x > 1 else 0)",
            vec!["A(x) : x > 1 -> B(x)", "A(x) : !(x > 1) -> B(0)"],
        ),
        (
            "A(x) :\n  if (x > 1 and\n      x < 3):\n    produce B",
            vec!["A(x) : x > 1 && x < 3 -> B"],
        ),
    ] {
        assert_eq!(rules(theirs), ours, "{theirs}");
    }
}

#[test]
fn operations_keep_their_order() {
    for (theirs, ours) in [
        ("-x**2", "-x^2"),
        ("2**-x", "2^(-x)"),
        ("2**3**x", "2^3^x"),
        ("0 < x < 3", "0 < x && x < 3"),
        ("not x == 1 or x", "!(x == 1) || x"),
        ("x // 2", "floor(x/2)"),
        ("x % 2", "x % 2 + 2*(x % 2 < 0)"),
        ("sin(radians(x))", "sin(x)"),
        ("sin(x)", "sin(x*57.29577951308232)"),
        ("math.sqrt(pow(x, 2))", "sqrt(x^2)"),
        ("max(x, 1, 2)", "max(max(x, 1), 2)"),
        ("int(x)", "sign(x)*floor(abs(x))"),
        (
            "uniform(1, 2) + gauss(0, 1)",
            "uniform(1, 2) + normal(0, 1)",
        ),
        ("1_000.5", "1000.5"),
        ("True", "1"),
    ] {
        let made = rules(&format!("A(x) --> B({theirs})"));
        assert_eq!(made, [format!("A(x) -> B({ours})")], "{theirs}");
    }
}

#[test]
fn a_whole_file() {
    let text = "from math import *\nr, a = 0.5, 2*pi\nmodule Apex(x), Leaf\nignore: +-\nAxiom: _(0.1)!(0.2)Apex(1)\nderivation length: 4\nproduction:\nApex(x) --> F(x, 0.1)[+Apex(x*r)]Leaf\nApex --> Leaf\ninterpretation:\nLeaf --> !(0.3)~l(2)\nendlsystem\n";
    let expected = [
        "const pi = 3.141592653589793",
        "const r = 0.5",
        "const a = 2*pi",
        "steps 4",
        "module Apex(x)",
        "module IncWidth(p1)",
        "module Leaf",
        "module Apex0",
        "ignore + -",
        "axiom IncWidth(0.1) !(0.2) Apex(1)",
        "Apex(x) -> F(x, 0.1) [ + Apex(x*r) ] Leaf",
        "Apex0 -> Leaf",
        "interpret {",
        "Leaf -> !(2*0.3) ~l(2)",
        "!(p1) -> !(2*p1)",
        "F(p1, p2) -> !(2*p2) F(p1)",
        "IncWidth(p1) -> !(2*p1)",
        "}",
    ];
    assert_eq!(lines(Lpy, text, &[]), expected);
    assert!(string(&format!("dialect lpy\n{text}"), 1).contains("F(1,0.1)[+Apex(0.5)]Leaf"));
}

#[test]
fn what_is_drawn_twice_over_keeps_its_own_name() {
    // A second round would double the width again, so `!` goes by another name.
    let text = "Axiom: !(1)\nproduction:\nA --> A\ninterpretation:\nmaximum depth: 3\nB --> !(2)B\nendlsystem\n";
    let made = brought(Lpy, text).text;
    assert!(made.contains("axiom DecWidth(1)"), "{made}");
    assert!(
        made.contains("interpret depth 3 {\n    B -> !(2*2) B\n    DecWidth(p1) -> !(2*p1)\n}"),
        "{made}"
    );
}

#[test]
fn what_is_not_carried_over_is_named() {
    let text = "colors = [1, 2]\ndef help(x):\n  return x\nAxiom: @o(2)F\nproduction:\nF --> F@L(1)\ngroup 1:\nF --> G\nendgroup\nendlsystem\n###### INITIALISATION ######\nwhatever(\n";
    let said: Vec<String> = brought(Lpy, text)
        .remarks
        .iter()
        .map(ToString::to_string)
        .collect();
    for part in [
        "test:11:1: not carried over: the settings of L-Py's editor",
        "test:1:1: not carried over: `colors`, whose value is no number",
        "test:2:1: not carried over: the Python function `help`",
        "test:4:8: not carried over: circles, boxes, labels",
        "test:7:1: not carried over: groups of rules",
    ] {
        assert!(
            said.iter().any(|s| s.starts_with(part)),
            "{part}: {said:#?}"
        );
    }
}

#[test]
fn faults_are_told_where_the_file_has_them() {
    for (text, line, column, part) in [
        (
            "Axiom: A\nproduction:\nA(x) --> B(y)\n",
            3,
            12,
            "unknown name `y`",
        ),
        (
            "Axiom: A\nproduction:\nA :\n  for i in range(3):\n    nproduce B\n",
            4,
            3,
            "this Python code",
        ),
        (
            "Axiom: A\nproduction:\nA(x) :\n  if x > 1:\n    produce B[\n",
            5,
            14,
            "this `[` is not closed",
        ),
        (
            "Axiom: A\nproduction:\nA B --> C\n",
            3,
            3,
            "several modules at once",
        ),
        (
            "Axiom: A\nproduction:\nA --> B(helper(1))\n",
            3,
            9,
            "`helper` with 1 argument",
        ),
        (
            "Axiom: A\nproduction:\nA --> B([1,2])\n",
            3,
            9,
            "lists, tuples",
        ),
        (
            "def EndEach(s):\n  pass\nAxiom: A\n",
            1,
            1,
            "runs between the steps",
        ),
        (
            "Axiom: A\nproduction:\nA << B --> C\n",
            3,
            3,
            "expected one `<`",
        ),
        (
            "Axiom: A\nproduction:\nA :\n  r = random()\n  produce B(r, r)\n",
            4,
            7,
            "drawn at random once and used twice",
        ),
        ("production:\nA --> B\n", 2, 1, "no axiom"),
    ] {
        let (l, c, message) = fault(Lpy, text);
        assert!(message.contains(part), "{text}: {message}");
        assert_eq!((l, c), (line, column), "{text}: {message}");
    }
}
