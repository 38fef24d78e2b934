//! What files of cpfg become.

use ramus::lsystem::dialect::Dialect::Cpfg;

use super::{brought, fault, lines, string};

/// A production in a file of its own.
fn production(text: &str) -> Vec<String> {
    let file = format!("Lsystem: 1\nAxiom: A\n{text}\nendlsystem\n");
    lines(Cpfg, &file, &["angle", "axiom", "interpret", "}", "module"])
}

#[test]
fn productions() {
    for (theirs, ours) in [
        ("A --> B", "A -> B"),
        ("A --> *", "A -> *"),
        ("A-->F+[/F]", "A -> F + [ \\ F ]"),
        ("A(x) --> \\(x)&(x)^|f", "A(x) -> /(x) &(x) ^ | f"),
        ("A(x) : x > 1 --> A(x-1)", "A(x) : x > 1 -> A(x - 1)"),
        ("A(x) : 1 --> A(x)", "A(x) -> A(x)"),
        ("A(x) : * --> A(x)", "A(x) -> A(x)"),
        ("L < A > R --> B", "L < A > R -> B"),
        ("* < A > R --> B", "A > R -> B"),
        ("A > B[H=]M --> C", "A > B [ H ] M -> C"),
        ("A --> F\n\tF\n\t[F]", "A -> F F [ F ]"),
        ("A --> {.F.}", "A -> { . F . }"),
        ("A --> @v;(2),@Gs@Ge", "A -> $ '(2) , @Gs @Ge"),
        ("A --> ~l(2)@O", "A -> ~l(2) @O"),
        (
            "A(x) : {y=x*2; z=y+1;} z > 3 {w=z;} --> B(y,w)",
            "A(x) : x*2 + 1 > 3 -> B(x*2, x*2 + 1)",
        ),
        ("A(x) : {y=x;\n z=1;} * --> B(y,z)", "A(x) -> B(x, 1)"),
        ("A(weight) --> B(weight)", "A(weight_) -> B(weight_)"),
        ("G --> g", "G -> g"),
        ("T --> T", "T′ -> T′"),
        ("A --> F//F // two rolls, then a comment", "A -> F \\ \\ F"),
        ("/* gone */ A --> B /* gone\n too */", "A -> B"),
        ("A -o> B", "A -> B"),
    ] {
        assert_eq!(production(theirs), [ours], "{theirs}");
    }
}

#[test]
fn operations_keep_their_order() {
    for (theirs, ours) in [
        ("-x^2", "(-x)^2"),
        ("2^3^x", "(2^3)^x"),
        ("x - (1 - x)", "x - (1 - x)"),
        ("(x - 1) - x", "x - 1 - x"),
        ("x < 1 == 0", "(x < 1) == 0"),
        ("x <> 1", "x != 1"),
        ("!x == 0", "!x == 0"),
        ("!(x == 0)", "!(x == 0)"),
        ("x % 3", "sign(x)*floor(abs(x)) % 3"),
        ("sin(30) + fabs(x)", "sin(30) + abs(x)"),
        ("trunc(x)", "floor(x + 0.5)"),
        ("ran(2)", "uniform(0, 2)"),
        ("nran(5, x)", "normal(5, x)"),
    ] {
        let made = production(&format!("A(x) --> B({theirs})"));
        assert_eq!(made, [format!("A(x) -> B({ours})")], "{theirs}");
    }
}

#[test]
fn a_choice_between_values_is_two_productions() {
    assert_eq!(
        production("A(x) : x < 9 --> B(x > 3 ? 1 : x)"),
        [
            "A(x) : x < 9 && x > 3 -> B(1)",
            "A(x) : x < 9 && !(x > 3) -> B(x)"
        ]
    );
}

#[test]
fn statements() {
    let text = "#define r 0.5\n#define TWICE(x) (x*2)\nLsystem: 1\nderivation length: 3*2\nseed: 7\nStart: {\n  a = 30;\n  b = TWICE(a);\n}\nignore: +-F\nAxiom: A(r)B\nA(x) --> B : 2\nA(x) --> C\nB --> C\ndecomposition\nmaximum depth: 4\nD --> E\nhomomorphism\nC --> F(b)\nendlsystem\n";
    let expected = [
        "const r = 0.5",
        "const a = 30",
        "const b = a*2",
        "steps 3*2",
        "seed 7",
        "angle 45",
        "ignore + - F",
        "axiom A(r) B",
        "A(x) : weight 2 -> B",
        "A(x) : weight 1 -> C",
        "B -> C",
        "decompose depth 4 {",
        "D -> E",
        "}",
        "interpret {",
        "C -> F(b)",
        "}",
    ];
    // `b` is seen before `const` sorts anything: constants use those above them.
    assert_eq!(lines(Cpfg, text, &[]), expected);
}

#[test]
fn what_is_not_carried_over_is_named() {
    let text = "Lsystem: 1\nAxiom: A\nA --> @L(3)!\nendlsystem\n";
    let said: Vec<String> = brought(Cpfg, text)
        .remarks
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(said[0], "test:3:7: not carried over: labels are not drawn");
    assert!(
        said[1].starts_with("test:3:12: not carried over: `!` without a parameter"),
        "{said:?}"
    );
    // They stay in the string, so that it is as long as cpfg's.
    assert_eq!(
        string(&format!("dialect cpfg\n{text}"), 1),
        "Label(3)Narrow"
    );
}

#[test]
fn faults_are_told_where_the_file_has_them() {
    let head = "Lsystem: 1\nAxiom: A\n";
    for (text, line, column, part) in [
        ("A B --> C", 3, 3, "several modules at once"),
        ("A > B[H]M --> C", 3, 8, "expected `=]`"),
        ("A(x) --> B(y)", 3, 12, "unknown name `y`"),
        ("A(x) --> B(x", 3, 13, "expected `,` or `)`"),
        ("A(x) --> B[", 3, 11, "this `[` is not closed"),
        ("A(x) --> B(bran(x, 2))", 3, 12, "`bran` with 2 arguments"),
        ("A --> ?(2,1)A$", 3, 7, "sub-L-systems"),
        ("A --> B\n\tC(z)", 4, 4, "unknown name `z`"),
        (
            "A(x) : {if (x > 1) {x = 2;}} * --> B",
            3,
            9,
            "only assignments",
        ),
        (
            "A(x) : {r = ran(1);} * --> B(r, r)",
            3,
            13,
            "drawn at random once and used twice",
        ),
        ("homomorphism\nA < B --> C", 4, 1, "contexts"),
        ("StartEach: {n = n + 1;}", 3, 1, "from step to step"),
    ] {
        let (l, c, message) = fault(Cpfg, &format!("{head}{text}\n"));
        assert!(message.contains(part), "{text}: {message}");
        assert_eq!((l, c), (line, column), "{text}: {message}");
    }
}

#[test]
fn a_file_is_read_directly() {
    let anabaena = "dialect cpfg\nLsystem: 1\nderivation length: 3\nAxiom: A(0)B\nA(x) > B --> A(x)A(x+1)\nendlsystem\n";
    assert_eq!(string(anabaena, 3), "A(0)A(1)A(2)A(3)B");
}
