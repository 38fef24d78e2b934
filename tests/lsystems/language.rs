//! The language: what a grammar file may say and how its faults are told.

use std::sync::atomic::AtomicBool;

use ramus::lsystem::{DeriveError, DeriveProblem, Grammar, Limits, ValueProblem};

use super::{derive, draw, parse, text_of};

#[test]
fn strings_of_small_grammars() {
    for (what, text, steps, expected) in [
        (
            "declared words, longest first",
            "module Leaf(s), Le\naxiom LeafLe Leaf(2) L\nLe -> L\n".replace("LeafLe ", "Le"),
            1,
            "LLeaf(2)L",
        ),
        (
            "subscripts and primes",
            "module A'(x)\naxiom A₁A′ A'(2)F'\nA₁ -> A′\nA'(x) -> A'(x+1)\n".into(),
            1,
            "A′A′A'(3)F'",
        ),
        (
            "one name, two numbers of parameters",
            "axiom A A(1)\nA -> B\nA(x) -> C(x)\n".into(),
            1,
            "BC(1)",
        ),
        ("the long arrow", "axiom A\nA --> B\n".into(), 1, "B"),
        (
            "signs as predecessors",
            "axiom +-\n+ -> -\n- -> +\n".into(),
            1,
            "-+",
        ),
        (
            "a minus right before the arrow",
            "axiom A-\n-->+\n".into(),
            1,
            "A+",
        ),
        (
            "a minus as right context",
            "axiom A-\nA > - -> B\n".into(),
            1,
            "B-",
        ),
        (
            "digits as modules",
            "axiom F1F0\n1 -> 0\n".into(),
            1,
            "F0F0",
        ),
        ("the empty successor", "axiom ABA\nA -> *\n".into(), 1, "B"),
        (
            "comments and continued lines",
            "axiom A # the first\n\n  B # more\nA -> C\n  [D]\n".into(),
            1,
            "C[D]B",
        ),
        (
            "constants in any order of use",
            "axiom A(k)\nconst j = 2\nconst k = j^2 + 1, m = k\nA(x) -> A(x+m)\n".into(),
            1,
            "A(10)",
        ),
        (
            "a parameter hides a constant",
            "const x = 9\naxiom A(1)\nA(x) -> A(x)B(x)\n".into(),
            1,
            "A(1)B(1)",
        ),
        (
            "ABOP's condition that always holds",
            "axiom A(1)\nA(x) : * -> B\n".into(),
            1,
            "B",
        ),
        (
            "first: file order",
            "axiom ABA\nA -> X\nB < A -> Y\n".into(),
            1,
            "XBX",
        ),
        (
            "specific: longer contexts first",
            "order specific\naxiom ABA\nA -> X\nB < A -> Y\n".into(),
            1,
            "XBY",
        ),
        (
            "specific: then conditions, then file order",
            "order specific\naxiom A(1)A(5)\nA(x) -> X\nA(x) -> W\nA(x) : x > 2 -> Y\n".into(),
            1,
            "XY",
        ),
        (
            "ignore",
            "ignore +\naxiom A+B\nA < B -> C\n".into(),
            1,
            "A+C",
        ),
        ("not ignored", "axiom A+B\nA < B -> C\n".into(), 1, "A+B"),
        (
            "consider",
            "consider AB\naxiom A+F(1)B\nA < B -> C\n".into(),
            1,
            "A+F(1)C",
        ),
        (
            "left over a branch",
            "axiom A[XX[Y]]B\nA < B -> C\n".into(),
            1,
            "A[XX[Y]]C",
        ),
        (
            "left out of a branch",
            "axiom A[[B]]\nA < B -> C\n".into(),
            1,
            "A[[C]]",
        ),
        (
            "right over a branch",
            "axiom A[X]B\nA > B -> C\n".into(),
            1,
            "C[X]B",
        ),
        (
            "right ends with the branch",
            "axiom [A]B\nA > B -> C\n".into(),
            1,
            "[A]B",
        ),
        (
            "a branch in the pattern",
            "axiom A[XY]B\nA > [X]B -> C\n".into(),
            1,
            "C[XY]B",
        ),
        (
            "the second branch fits",
            "axiom A[Z][XY]B\nA > [X]B -> C\n".into(),
            1,
            "C[Z][XY]B",
        ),
        (
            "a branch within a branch",
            "axiom A[X[Y]Z]\nA > [X[Y]Z] -> C\n".into(),
            1,
            "C[X[Y]Z]",
        ),
        (
            "literal: brackets end contexts",
            "context literal\naxiom A[B]A B\nA > B -> C\nA < B -> D\n".into(),
            1,
            "A[B]CD",
        ),
        (
            "contexts bind parameters",
            "axiom A(2)[Q(9)]B(3)C(4)\nA(a) < B(b) > C(c) -> B(a*100+b*10+c)\n".into(),
            1,
            "A(2)[Q(9)]B(234)C(4)",
        ),
        (
            "contexts bind in branches",
            "axiom A[X(7)]B(1)\nA > [X(x)] B(y) -> A(x+y)\n".into(),
            1,
            "A(8)[X(7)]B(1)",
        ),
        (
            "contexts are only read",
            "axiom ABB\nA > B -> AX\nB < B -> Y\n".into(),
            1,
            "AXBY",
        ),
        (
            "ABOP's leaf: an outline that begins in a branch",
            "axiom A\nA -> [+A{.].C.}\n".into(),
            1,
            "[+A{.].C.}",
        ),
        ("cut", "axiom A[B%C[D]E]F\n".into(), 0, "A[B]F"),
        ("cut at the end", "axiom A[B]C%D[E]\n".into(), 0, "A[B]C"),
        (
            "cut at the start of the next step",
            "axiom AB\nA -> C\nB -> X[%Y]Z\nC -> %\n".into(),
            2,
            "",
        ),
        (
            "cut what decomposing the axiom brings",
            "axiom A\ndecompose {\n  A -> F[%F]F\n}\n".into(),
            0,
            "F[]F",
        ),
        (
            "decomposition goes on until nothing changes",
            "axiom N(3)\ndecompose {\n  N(n) : n > 0 -> F N(n-1)\n  N(n) -> *\n}\nF -> N(1)G\n"
                .into(),
            1,
            "FGFGFG",
        ),
        (
            "interpretation leaves the string alone",
            "axiom L\nL -> LL\ninterpret {\n  L -> F\n}\n".into(),
            1,
            "LL",
        ),
        (
            "a weight in the condition's place",
            "axiom F(1)\nF(x) : weight 0.5 -> G(x)\nF(x) : x > 0, weight x/2 -> G(x)\n".into(),
            1,
            "G(1)",
        ),
        (
            "only the weighted that match are drawn",
            "axiom A\nA : weight 0 -> X\nA : 1 > 2, weight 100 -> Y\nA : weight 1 -> Z\n".into(),
            1,
            "Z",
        ),
        (
            "neighbours with parameters of several without, to the right",
            "axiom DDA(0)A(2)\nD > A(x) : x >= 1 -> %\n".into(),
            1,
            "DDA(0)A(2)",
        ),
        (
            "and on both sides of some",
            "axiom A(2)A(0)DDDA(7)\nA(x) < D : x >= 1 -> %\nD < D > A(x) : x > 6 -> F(x)\n".into(),
            1,
            "A(2)A(0)DDF(7)A(7)",
        ),
        (
            "numbers as C prints them",
            "axiom A(1/3)B(1e10,2^0.5)C(-0.00001)\n".into(),
            0,
            "A(0.3333333333)B(1e+10,1.414213562)C(-1e-05)",
        ),
    ] {
        assert_eq!(text_of(&parse(&text), steps), expected, "{what}:\n{text}");
    }
}

/// Strings that grow all over, at their ends only, towards one end, not at all, all over at first, and through decomposition.
#[test]
fn step_k_is_a_derivation_of_k_steps() {
    for (text, steps) in [
        (
            "axiom A\nA : weight 1 -> A[+A]B\nA : weight 2 -> BA\nB < B -> A\nB : weight 1 -> B%\nB: weight 5 -> B(uniform(0,1))\n",
            12,
        ),
        ("axiom A\nA -> AB\nB -> A\n", 15),
        (
            "context literal\naxiom A(0) B\nA(x) > B -> A(x) A(x+1)\nA(x) > A(y) : y % 3 == 0 -> A(x) [ +(y) A(0) B ]\n",
            40,
        ),
        (
            "context literal\naxiom S X X X X X X X X\nS < X > X X -> S\nS > S -> *\nX < X > X -> X F\n",
            12,
        ),
        (
            "context literal\naxiom S\nS < S -> *\nS > S S -> X\nX -> S S\nX X < S -> X S\n",
            8,
        ),
        ("axiom F(1)\n", 5),
        (
            "context literal\naxiom A(0) B C(9)\nA(x) > B -> A(x) A(x+1)\nC(n) : n > 0 -> C(n-1) C(n-1)\n",
            40,
        ),
        ("axiom A(9)\nA(n) : n > 0 -> A(n-1) A(n-1)\n", 14),
        (
            "context literal\naxiom A(0) B\nA(x) > B -> A(x) H(x) A(x+1)\nA(x) < H(y) -> *\n\
             decompose {\n  H(x) : x % 2 == 0 -> [ G(x/2) B ]\n  H(x) : x % 3 == 0 -> *\n  G(x) : x % 2 == 1 -> A(x) G(x-1)\n}\n",
            60,
        ),
    ] {
        let grammar = parse(text);
        let (limits, cancel) = (Limits::default(), AtomicBool::new(false));
        let mut string = derive(&grammar, 0);
        for step in 1..steps {
            string = grammar
                .derive_next(&string, step, &limits, &cancel)
                .unwrap();
            assert_eq!(string, derive(&grammar, step), "step {step} of\n{text}");
        }
    }
}

#[test]
fn what_the_file_states() {
    let grammar = parse("steps 2*3\nseed 18446744073709551615\nangle 22.5 * 2\naxiom A\nA -> A\n");
    assert_eq!(
        (grammar.steps(), grammar.seed(), grammar.angle()),
        (Some(6), u64::MAX, Some(45.0))
    );
}

#[test]
fn interpretation_is_drawn() {
    let grammar = parse(
        "angle 90\naxiom L(2)\ninterpret depth 2 {\n  L(x) -> M(x)M(x)\n  M(x) -> F(x)+F%F\n}\n",
    );
    assert_eq!(
        draw(&grammar, &derive(&grammar, 0)).parent.len(),
        3,
        "what follows % is not drawn"
    );
}

/// Text, line, column, parts of the message.
#[test]
fn faults_are_told_where_they_are() {
    for (text, line, column, parts) in [
        (
            "axiom A\nA(l) -> F(l*r3)\nconst r2 = 1\n",
            2,
            13,
            &[
                "unknown name `r3`",
                "expected a parameter",
                "nearest known name is `r2`",
            ][..],
        ),
        (
            "axoim A\naxiom A\n",
            1,
            1,
            &["found `axoim`", "nearest known word is `axiom`"],
        ),
        ("A -> B\n", 2, 1, &["no axiom", "`axiom A`"]),
        ("axiom A]\n", 1, 8, &["closes nothing"]),
        (
            "axiom A\nA -> [B[C]\n",
            2,
            6,
            &["not closed", "expected a `]`"],
        ),
        (
            "axiom A(1\n",
            1,
            10,
            &["found the end of the line", "`,` or `)`"],
        ),
        (
            "axiom A\nA -> B(1,,2)\n",
            2,
            10,
            &["found `,`", "expected a number"],
        ),
        ("axiom A\nA > -> B\n", 2, 5, &["right context"]),
        (
            "axiom A\nA > B[F] -> B\nignore + F\n",
            2,
            7,
            &["contexts skip `F`", "never matches", "out of `ignore`"],
        ),
        (
            "consider A B\naxiom A\nB C < A -> B\n",
            3,
            3,
            &["contexts skip `C`", "add `C` to `consider`"],
        ),
        ("axiom A\n< A -> B\n", 2, 1, &["left context is empty"]),
        (
            "axiom A\n-> B\n",
            2,
            1,
            &["expected the module that is replaced"],
        ),
        ("axiom A\nA B -> C\n", 2, 3, &["one predecessor only"]),
        ("axiom A\nA ->\n", 2, 5, &["expected the successor, or `*`"]),
        ("axiom A\nA -> B * C\n", 2, 8, &["`*` means no module"]),
        (
            "axiom A\nA(0) -> B\n",
            2,
            3,
            &["expected the name of a parameter", "x == 0"],
        ),
        (
            "axiom A\nA(x) > B(x) -> B\n",
            2,
            10,
            &["`x` is bound twice"],
        ),
        (
            "axiom A\nA[B] < C -> D\n",
            2,
            2,
            &["left context", "no brackets"],
        ),
        (
            "context literal\naxiom A\nA > [B] -> D\n",
            3,
            5,
            &["`context literal`"],
        ),
        ("context literal\nignore F\naxiom A\n", 2, 1, &["`ignore`"]),
        ("axiom A\nA(x) : x = 1 -> B\n", 2, 10, &["`==`"]),
        (
            "axiom A\nA(x) : weight -> B\n",
            2,
            15,
            &["found `-`; expected a number"],
        ),
        (
            "axiom A\nA(x) : uniform(0,1) > 0.5 -> B\n",
            2,
            8,
            &["draws at random"],
        ),
        (
            "axiom A\nA(x) : x > 1 weight 2 -> B\n",
            2,
            14,
            &["expected `->`"],
        ),
        (
            "module Leaf(a, b)\naxiom Leaf(1)\n",
            2,
            7,
            &["declared with 2 parameters (a, b); found 1"],
        ),
        (
            "module Leaf\nmodule Leaf\naxiom Leaf\n",
            2,
            8,
            &["declared twice"],
        ),
        ("const a = 1, a = 2\naxiom A\n", 1, 14, &["a value twice"]),
        ("const a = 1/0\naxiom A\n", 1, 11, &["division by zero"]),
        ("axiom A\naxiom B\n", 2, 1, &["second time"]),
        ("axiom A@X\n", 1, 8, &["`@O`, `@Gs`, `@Ge`, `@l`"]),
        ("axiom A\"\n", 1, 8, &["found `\"`"]),
        (
            "axiom ?P(1)\n",
            1,
            7,
            &["`?P` with 1 parameters", "`?P(0, 0, 0)`"],
        ),
        ("axiom A\n[ -> A\n", 2, 1, &["cannot be replaced"]),
        ("steps 1.5\naxiom A\n", 1, 7, &["whole number"]),
        ("order best\naxiom A\n", 1, 7, &["`first` or `specific`"]),
        (
            "axiom A\ndialect houdini\n",
            2,
            9,
            &["`houdini` is told too late", "before everything else"],
        ),
        (
            "dialect foo\naxiom A\n",
            1,
            9,
            &["`foo` is not known", "`ramus`, `cpfg`, `lpy` or `houdini`"],
        ),
        (
            "steps 9999999999999999\naxiom A\n",
            1,
            7,
            &[
                "found `9999999999999999`;",
                "a whole number from 0 to 4294967295",
            ],
        ),
        (
            "const n = 3\nsteps n/2 # half\naxiom A\n",
            2,
            7,
            &["found `n/2`, which is `1.5`; expected a whole number"],
        ),
        ("axiom F}\n", 1, 8, &["closes no polygon", "expected a `{`"]),
        ("axiom A\nA -> {F[+F}F\n", 2, 8, &["`[` is not closed"]),
        (
            "axiom A\nA -> [{F]F\n",
            2,
            7,
            &["polygon's `{` is not closed", "expected a `}`"],
        ),
        ("shape A = []\naxiom A(0)\n", 1, 7, &["is empty"]),
        ("shape A = [(1 2)]\naxiom A(0)\n", 1, 17, &["three numbers"]),
        (
            "shape A = [(1 2 3 -4)]\naxiom A(0)\n",
            1,
            19,
            &["cannot be negative"],
        ),
        (
            "shape + = [(1 2 3)]\naxiom A(0)\n",
            1,
            7,
            &["sign of the turtle"],
        ),
        ("decompose {\n  A -> B\naxiom A\n", 1, 1, &["not closed"]),
        (
            "decompose {\n  A < B -> C\n}\naxiom A\n",
            2,
            3,
            &["found a context"],
        ),
        (
            "decompose {\n steps 3\n}\naxiom A\n",
            2,
            2,
            &["inside a block"],
        ),
        (
            "include \"other.lsys\"\naxiom A\n",
            1,
            10,
            &["not in a file"],
        ),
        ("axiom é(x)\n", 1, 9, &["unknown name `x`"]),
    ] {
        let errors = Grammar::parse(text, "t.lsys").expect_err(text).errors;
        let error = &errors[0];
        assert_eq!(
            (error.line, error.column),
            (line, column),
            "{text}\n{error}"
        );
        for part in parts {
            assert!(
                error.message.contains(part),
                "{text}\n{error}\nlacks: {part}"
            );
        }
    }
}

#[test]
fn several_faults_at_once() {
    let text = "axiom A(z)\nA(x) -> B(y, w)\nB -> [\nC -> D\nE - F\nconst k = 1 +\nmodule 5\n";
    let errors = Grammar::parse(text, "t.lsys").unwrap_err();
    let places: Vec<(usize, usize)> = errors.errors.iter().map(|e| (e.line, e.column)).collect();
    assert_eq!(
        places,
        [(1, 9), (2, 11), (2, 14), (3, 6), (5, 6), (6, 14), (7, 8)],
        "{errors}"
    );
    let shown = errors.to_string();
    assert!(shown.contains("t.lsys:2:11: unknown name `y`"), "{shown}");
    assert!(
        shown.contains("\n    A(x) -> B(y, w)\n              ^\n"),
        "{shown}"
    );
    let many = Grammar::parse(&"= B\n".repeat(100), "t.lsys").unwrap_err();
    assert_eq!(
        (many.errors.len(), many.more),
        (20, 81),
        "100 and the missing axiom"
    );
}

fn fails(text: &str, steps: u32, limits: &Limits) -> DeriveError {
    parse(text)
        .derive(steps, limits, &AtomicBool::new(false))
        .expect_err(text)
}

/// Values that cannot be: the production, its place and the step are named, and the last whole step is kept.
#[test]
fn values_that_cannot_be() {
    for (text, problem) in [
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(1/(x-1))\n",
            ValueProblem::DivisionByZero,
        ),
        (
            "axiom A(3)\nB -> C\nA(x) : 1/(x-1) > 0 -> A(x-1)\n",
            ValueProblem::DivisionByZero,
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(sqrt(x-2))\n",
            ValueProblem::NotANumber,
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(log(x-1))\n",
            ValueProblem::Overflow,
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(10^(1000*(2-x)))\n",
            ValueProblem::Overflow,
        ),
        (
            "axiom A(3)\nB -> C\nA(x) : weight x-1.5 -> A(x-1)\n",
            ValueProblem::BadWeight,
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(uniform(1, x-1))\n",
            ValueProblem::BadDraw("uniform", "its lower bound first"),
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(normal(1, x-2))\n",
            ValueProblem::BadDraw("normal", "a spread of 0 or more"),
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(lognormal(x-2, 1))\n",
            ValueProblem::BadDraw("lognormal", "a mean above 0 and a spread of 0 or more"),
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(integer(1.1, x-1.1))\n",
            ValueProblem::BadDraw(
                "integer",
                "a whole number between its bounds, the lower one first, both below 9e15",
            ),
        ),
        (
            "axiom A(3)\nB -> C\nA(x) -> A(x-1)B(chance(x-2.5))\n",
            ValueProblem::BadDraw("chance", "a number from 0 to 1"),
        ),
    ] {
        let error = fails(text, 9, &Limits::default());
        let DeriveProblem::Value {
            step,
            production,
            location,
            position,
            problem: found,
        } = *error.problem.clone()
        else {
            panic!("{text}: {error}");
        };
        assert_eq!(found, problem, "{text}");
        assert_eq!(location, "test.lsys:3", "{text}");
        assert!(production.starts_with("A(x)"), "{production}");
        let (last, string) = *error.last.unwrap();
        assert_eq!(last + 1, step, "the step before is whole");
        assert_eq!(string, derive(&parse(text), last), "{text}");
        assert_eq!(position, 0);
    }
}

#[test]
fn limits_keep_the_last_whole_step() {
    let limits = Limits {
        modules: 1000,
        ..Limits::default()
    };
    let error = fails("axiom A\nA -> AA\n", 99, &limits);
    assert!(
        error
            .to_string()
            .contains("step 10 would make 1024 modules"),
        "{error}"
    );
    let (step, string) = *error.last.unwrap();
    assert_eq!((step, string.len()), (9, 512));
    let bytes = Limits {
        bytes: 10_000,
        ..Limits::default()
    };
    assert!(
        fails("axiom A\nA -> AA\n", 99, &bytes)
            .to_string()
            .contains("past the limit of 10000 bytes")
    );
    let wide = format!("axiom A\nA -> {}\n", "A".repeat(100_000));
    assert!(matches!(
        *fails(&wide, 9, &Limits::default()).problem,
        DeriveProblem::Limit {
            step: 2,
            modules: 10_000_000_000,
            ..
        }
    ));
    assert!(
        parse("axiom A\nA -> A\n")
            .derive(u32::MAX, &Limits::default(), &AtomicBool::new(true))
            .unwrap_err()
            .is_cancelled()
    );
}

#[test]
fn cyclic_decomposition_is_found() {
    let error = fails(
        "axiom C\nC -> A\ndecompose {\n  A -> B\n  B -> A\n}\n",
        3,
        &Limits::default(),
    );
    assert!(
        matches!(&*error.problem, DeriveProblem::Decomposition { step: 1, depth: 100, location, .. } if location.starts_with("test.lsys")),
        "{error}"
    );
    assert_eq!(error.last.unwrap().1.len(), 1);
    let deep = parse("axiom N(150)\ndecompose depth 151 {\n  N(n) : n > 0 -> F N(n-1)\n}\n");
    assert_eq!(derive(&deep, 0).len(), 151);
}
