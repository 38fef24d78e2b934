//! Input that is made to hurt: a clear error or a right result, in bounded time and memory.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use proptest::prelude::*;
use ramus::lsystem::{DeriveProblem, Grammar, Limits, TurtleParams, interpret};

use super::{derive, draw, parse, text_of};

#[test]
fn ten_million_nested_brackets() {
    let deep = 10_000_000;
    let (open, close) = ("[".repeat(deep), "]".repeat(deep));
    for rules in ["F -> F\n", "A < F -> F\nF > A -> F\n"] {
        let grammar = parse(&format!("axiom {open}F{close}\n{rules}"));
        let string = derive(&grammar, 1);
        assert_eq!(string.len(), 2 * deep + 1, "{rules}");
        if rules.contains('<') {
            let tree = draw(&grammar, &string);
            assert_eq!(tree.order[1], u16::MAX, "orders stop at what they can hold");
        }
    }
    // Half of the memory holds two pens.
    let grammar = parse("axiom [[[F]]]\n");
    let small = TurtleParams {
        limits: Limits {
            modules: 10,
            bytes: 4 * size_of::<ramus::lsystem::turtle::Pen>() as u64,
        },
        ..TurtleParams::default()
    };
    let never = AtomicBool::new(false);
    let error = interpret(&grammar, &derive(&grammar, 0), &small, &never).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("nest fewer brackets"), "{said}");
    assert!(!said.contains("steps"), "{said}");
}

#[test]
fn brackets_a_million_times_too_many() {
    for text in [
        format!("axiom {}", "[".repeat(1_000_000)),
        format!("axiom {}", "]".repeat(1_000_000)),
        "axiom A\n]".repeat(100_000),
    ] {
        assert!(!Grammar::parse(&text, "t").unwrap_err().errors.is_empty());
    }
    let pattern = format!(
        "axiom A\nA > {}B{} -> C\n",
        "[".repeat(1000),
        "]".repeat(1000)
    );
    assert!(
        Grammar::parse(&pattern, "t")
            .unwrap_err()
            .to_string()
            .contains("nest deeper")
    );
}

#[test]
fn million_character_lines() {
    let text = format!("axiom {}\"\n", "F(1)".repeat(250_000));
    let error = Grammar::parse(&text, "t").unwrap_err();
    assert_eq!(error.errors[0].column, 1_000_007);
    assert!(error.to_string().len() < 500, "the line is cut for show");
    let good = parse(&format!("axiom {}\n", "F(1)".repeat(250_000)));
    assert_eq!(derive(&good, 0).len(), 250_000);
    for text in [
        format!("axiom A({}1)\n", "1+".repeat(500_000)),
        format!("axiom A({})\n", "9".repeat(300)),
    ] {
        assert!(Grammar::parse(&text, "t").is_ok());
    }
    for text in [
        format!("axiom A({})\n", "9".repeat(1_000_000)),
        format!("axiom A({}1{})\n", "(".repeat(500_000), ")".repeat(500_000)),
    ] {
        assert!(Grammar::parse(&text, "t").is_err());
    }
    let names = format!("module {}\naxiom A\n", "x".repeat(1_000_000));
    assert!(Grammar::parse(&names, "t").is_err());
}

/// As many productions as a grammar may have, and as many faults: all are read, all are counted, and the first are
/// shown. Where reading took a time that grows with the square, this would take hours and the runner would end it.
#[test]
fn many_productions_and_as_many_faults() {
    const MANY: usize = 64_000;
    // Each with a context, a condition, names of its own and a declared module.
    let good: String = (0..MANY)
        .map(|i| format!("A(x{i}) < B > C : x{i} == {i} -> A(x{i}+{i})[B]\n"))
        .collect();
    let last = MANY - 1;
    let grammar = parse(&format!("axiom A({last})BC\n{good}"));
    assert_eq!(
        text_of(&grammar, 1),
        format!("A({last})A({})[B]C", 2 * last),
        "the last of them is read as the first is"
    );
    let faults: [(&str, &dyn Fn(usize) -> String); 5] = [
        ("unknown name", &|i| format!("A(x) -> B(y{i})\n")),
        ("closes nothing", &|i| format!("A -> B{i}]\n")),
        ("closes no polygon", &|i| format!("A -> B{i}}}\n")),
        ("`->`", &|i| format!("A{i}\n")),
        ("is declared with 2 parameters", &|i| {
            format!("A -> Leaf({i})\n")
        }),
    ];
    for (words, fault) in faults {
        let bad: String = (0..MANY).map(fault).collect();
        let text = format!("module Leaf(a, b)\naxiom AB\n{bad}");
        let errors = Grammar::parse(&text, "t").unwrap_err();
        assert_eq!(errors.errors.len() + errors.more, MANY, "{words}");
        for (error, line) in errors.errors.iter().zip(3..) {
            assert!(error.message.contains(words), "{words}: {error}");
            assert_eq!(error.line, line, "{words}: {error}");
        }
    }
    // Names to choose the nearest of: as many as statements.
    let constants: String = (0..MANY).map(|i| format!("const k{i} = {i}\n")).collect();
    let uses: String = (0..MANY).map(|i| format!("A -> B(q{i})\n")).collect();
    let text = format!("{constants}axiom A\n{uses}");
    let errors = Grammar::parse(&text, "t").unwrap_err();
    assert_eq!(errors.errors.len() + errors.more, MANY);
    // One more than a grammar may have.
    let over = Grammar::parse(&format!("axiom A\n{}", "A -> B\n".repeat(65_600)), "t");
    assert!(
        over.unwrap_err()
            .to_string()
            .contains("more than 65,000 productions")
    );
}

/// What stops a derivation or a drawing is named, with what mends it and not with what cannot.
#[test]
fn what_is_too_large_says_what_to_make_smaller() {
    let limits = Limits {
        modules: 1000,
        bytes: 1 << 30,
    };
    let params = TurtleParams::default();
    let cancel = AtomicBool::new(false);
    let table: [(&str, u32, &[&str], &[&str]); 9] = [
        (
            "axiom A\nA -> AA\n",
            20,
            &["step 10 would make 1024 modules", "take fewer steps"],
            &["axiom"],
        ),
        (
            "axiom A\ndecompose {\n  A -> AA\n}\n",
            3,
            &["decomposition does not end", "`A -> AA` (test.lsys:3)"],
            &["fewer steps"],
        ),
        (
            "axiom A\nA -> B\ndecompose {\n  B -> CC\n  C -> B\n}\n",
            3,
            &["step 1: decomposition does not end", "may be cyclic"],
            &["fewer steps", "past the limit"],
        ),
        (
            "axiom A(0)\ndecompose {\n  A(x) : x >= 0 -> A(x) A(x)\n}\n",
            3,
            &[
                "step 0: round 10 of the decomposition passes the limit of 1000 modules",
                "`A(x) : x >= 0 -> A(x) A(x)` (test.lsys:3)",
                "may be cyclic",
            ],
            &["fewer steps"],
        ),
        (
            &format!("axiom {}\n", "A".repeat(1001)),
            0,
            &["step 0 (the axiom", "1001 modules", "shorten the axiom"],
            &["fewer steps"],
        ),
        (
            "axiom F !(1e300) F\n",
            0,
            &[
                "module 2 (`F`)",
                "width of 1e300 m",
                "make the `!` before it smaller",
            ],
            &["length"],
        ),
        (
            "axiom !(-1e39) F\n",
            0,
            &["module 1 (`F`)", "width of 1e39 m"],
            &["length"],
        ),
        (
            "axiom F(1) F(1e300)\n",
            0,
            &["module 1 (`F`)", "make lengths smaller"],
            &["width"],
        ),
        (
            "axiom !(1e300) F(1e300)\n",
            0,
            &["make lengths smaller"],
            &[],
        ),
    ];
    for (text, steps, says, never) in table {
        let grammar = parse(text);
        let error = match grammar.derive(steps, &limits, &cancel) {
            Ok(string) => interpret(&grammar, &string, &params, &cancel).expect_err(text),
            Err(error) => error,
        };
        let said = error.to_string();
        for words in says {
            assert!(said.contains(words), "{text}\n{said}\nlacks: {words}");
        }
        for words in never {
            assert!(!said.contains(words), "{text}\n{said}\nsays: {words}");
        }
    }
}

/// Explosive growth, endless contexts, decompositions and drawings stop soon after the flag is set, and derivations
/// keep their last whole step.
#[test]
fn cancelling_is_quick() {
    let ignored = format!(
        "ignore F\naxiom {}\nA < F -> F\nF > A -> F\n",
        "F".repeat(300_000)
    );
    let row = format!("axiom {}F\n", "A".repeat(1 << 20));
    for text in [
        "axiom b\na -> ab\nb -> a\n",
        &ignored,
        &format!("{row}A < A > A -> A\nF -> F\n"),
        "axiom F\nF -> F\ndecompose depth 1000000000 {\n  F : weight 1 -> F\n}\n",
        &format!("{row}interpret depth 1000000000 {{\n  A : weight 1 -> A\n}}\n"),
    ] {
        let grammar = parse(text);
        let cancel = AtomicBool::new(false);
        let limits = Limits {
            modules: u64::MAX,
            bytes: u64::MAX,
        };
        let algae = text.contains("b -> a");
        let (result, waited) = std::thread::scope(|scope| {
            let worker = scope.spawn(|| {
                // Algae of 10^9 modules, which takes a moment.
                let steps = if algae { 42 } else { 1_000_000 };
                let result = grammar.derive(steps, &limits, &cancel).map(|string| {
                    let params = TurtleParams::default();
                    interpret(&grammar, &string, &params, &cancel).map(drop)
                });
                (result, Instant::now())
            });
            std::thread::sleep(Duration::from_millis(60));
            cancel.store(true, Ordering::Relaxed);
            let set = Instant::now();
            let (result, ended) = worker.join().unwrap();
            (result, ended.saturating_duration_since(set))
        });
        let shown = &text[..text.len().min(80)];
        match result {
            Err(error) => {
                assert!(error.is_cancelled(), "{shown}: {error}");
            }
            Ok(drawn) => assert!(drawn.unwrap_err().is_cancelled(), "{shown}"),
        }
        // 50 ms on an idle machine; this one may be busy.
        assert!(waited < Duration::from_millis(1000), "{shown}: {waited:?}");
    }
}

/// Whatever the text: no panic; what is accepted derives within its limits and draws a whole tree.
fn survives(text: &str) {
    let Ok(grammar) = Grammar::parse(text, "no such file") else {
        return;
    };
    let cancel = AtomicBool::new(false);
    let limits = Limits {
        modules: 3000,
        bytes: 1 << 20,
    };
    let string = match grammar.derive(4, &limits, &cancel) {
        Ok(string) => string,
        Err(error) => match error.last {
            Some(last) => last.1,
            None => return,
        },
    };
    assert!(string.len() <= 3000);
    let _ = string.to_text(&grammar);
    let params = TurtleParams {
        limits,
        ..TurtleParams::default()
    };
    if let Ok(tree) = interpret(&grammar, &string, &params, &cancel) {
        assert!(tree.position.iter().all(|p| p.is_finite()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn any_text(text in "\\PC{0,200}") {
        survives(&text);
        survives(&format!("axiom {text}\n"));
        survives(&format!("axiom AB\nA{text} -> {text}\n"));
    }

    #[test]
    fn text_of_the_languages_own_parts(parts in prop::collection::vec(prop::sample::select(vec![
        "axiom ", "\n", "A", "B", "F", "[", "]", "(", ")", ",", "x", "y", "1", "0.5", "+", "-", "*", "/", "^", "%", "<", ">", ":", "->", " ",
        "const ", "=", "weight ", "module ", "Leaf", "ignore ", "context literal\n", "decompose {\n", "}\n", "interpret {\n",
        "shape A = [(1 0 0)]\n", "uniform(", "&&", "||", "!", "==", "{", ".", "'", "~", "@O", "#", "A(x) -> A(x+1)B[A(x/2)]\n", "axiom A(1)\n",
        "B < A(x) > [A(y)] B : x > y -> A(x-y)%\n", "A(x) : weight x -> F(x)\n", "depth 3", "order specific\n",
    ]), 0..60)) {
        survives(&parts.concat());
    }
}

/// Modules are tried and evaluated in batches, symbol by symbol; of many faults the first in the string is told.
#[test]
fn of_many_faults_the_first_is_told() {
    let axiom: String = (0..3000).map(|i| format!("A({i})B({i})")).collect();
    let zero = |a, b| format!("6 % ((x - {a}) * (x - {b}))");
    let (of_a, of_b) = (zero(700, 1500), zero(650, 2000));
    for (productions, position) in [
        (
            format!("A(x) : {of_a} < 9 -> A(x)\nB(x) : {of_b} < 9 -> B(x)"),
            1301,
        ),
        (format!("A(x) -> A({of_a})\nB(x) -> B({of_b})B(x)"), 1301),
        // Whatever production is looked for comes before what one makes.
        (
            format!("A(x) : {of_a} < 9 -> A(x)\nB(x) -> B({of_b})"),
            1400,
        ),
        (
            format!("A(x) : x >= 0, weight 9 + {of_a} -> A(x)\nA(x) : weight 1 -> A(x)"),
            1400,
        ),
        (format!("B(y) < A(x) : x > 700 && {of_a} < 9 -> A(x)"), 3000),
    ] {
        let grammar = parse(&format!("axiom {axiom}\n{productions}\n"));
        let error = grammar.derive(1, &Limits::default(), &AtomicBool::new(false));
        let problem = error.unwrap_err().problem;
        let told = matches!(*problem, DeriveProblem::Value { position: at, .. } if at == position);
        assert!(told, "{productions}: {problem}");
    }
}

/// A step of too many modules is refused in the same words, whether strings are derived from the axiom or one by one.
#[test]
fn too_many_modules_are_too_many_either_way() {
    let limits = Limits {
        modules: 5_000,
        ..Limits::default()
    };
    for text in [
        "axiom B\nB -> BBBB\n",
        "axiom B(1)A\nB(x) -> B(x)AB(x)B(2)\n",
    ] {
        let (grammar, never) = (parse(text), AtomicBool::new(false));
        let mut string = derive(&grammar, 0);
        let refused = (1..).find_map(|step| {
            match grammar.derive_next(&string, step, &limits, &never) {
                Ok(following) => string = following,
                Err(error) => return Some(error),
            }
            None
        });
        let error = grammar.derive(9, &limits, &never).expect_err(text);
        assert_eq!(error.to_string(), refused.unwrap().to_string(), "{text}");
    }
}
