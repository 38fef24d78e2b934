//! The record of a step: which production rewrote each module, and what became of it.

use std::sync::atomic::AtomicBool;

use ramus::lsystem::{Grammar, Limits, ModuleString, Recorded};

use super::{derive, parse};

fn record(grammar: &Grammar, step: u32) -> (ModuleString, Recorded) {
    let before = derive(grammar, step - 1);
    let recorded = grammar
        .derive_recorded(&before, step, &Limits::default(), &AtomicBool::new(false))
        .unwrap();
    (before, recorded)
}

/// Each module of the string before with its production and its successor: `A 0 AB`.
fn shown(grammar: &Grammar, before: &ModuleString, recorded: &Recorded) -> String {
    let after: Vec<String> = recorded
        .string
        .iter()
        .map(|module| {
            let values: Vec<String> = module.parameters.iter().map(f64::to_string).collect();
            let name = grammar.name(module.symbol);
            if values.is_empty() {
                name.to_owned()
            } else {
                format!("{name}({})", values.join(","))
            }
        })
        .collect();
    let lines = before.iter().enumerate().map(|(at, module)| {
        let production = recorded
            .production(at)
            .map_or("-".to_owned(), |p| p.to_string());
        let successor = after[recorded.successor(at)].concat();
        format!("{} {production} {successor}", grammar.name(module.symbol))
    });
    lines.collect::<Vec<_>>().join("; ")
}

#[test]
fn each_module_has_its_production_and_its_successor() {
    for (text, step, expected) in [
        ("axiom A\nA -> AB\nB -> A\n", 3, "A 0 AB; B 1 A; A 0 AB"),
        (
            "axiom A(0) B\nA(x) > B -> A(x) A(x+1)\n",
            2,
            "A - A(0); A 0 A(1)A(2); B - B",
        ),
        ("axiom A B C\nB -> *\n", 1, "A - A; B 0 ; C - C"),
        // Contexts see the string before the step.
        (
            "axiom S A A\nS < A -> S\nS -> A\n",
            1,
            "S 1 A; A 0 S; A - A",
        ),
        // What a step makes is what is left after decomposition,
        (
            "axiom A\nA -> B C\ndecompose {\n  B -> D D\n  D -> F\n}\n",
            1,
            "A 0 FFC",
        ),
        // and after a cut.
        (
            "axiom A[XAB]C\nX -> F%\n",
            1,
            "A - A; [ - [; X 0 F; A - ; B - ; ] - ]; C - C",
        ),
        ("axiom A\n", 1, "A - A"),
    ] {
        let grammar = parse(text);
        let (before, recorded) = record(&grammar, step);
        assert_eq!(shown(&grammar, &before, &recorded), expected, "{text}");
        assert_eq!(recorded.string, derive(&grammar, step), "{text}");
        assert_eq!(recorded.len(), before.len(), "{text}");
    }
}

#[test]
fn the_record_is_that_of_the_derivation_itself() {
    for file in ["honda", "hogeweg-hesper", "wild-bush", "ternary"] {
        let path = format!("{}/assets/grammars/{file}.lsys", env!("CARGO_MANIFEST_DIR"));
        let grammar = parse(&std::fs::read_to_string(path).unwrap());
        let steps = grammar.steps().unwrap().min(6);
        for step in 1..=steps {
            let (before, recorded) = record(&grammar, step);
            assert_eq!(recorded.string, derive(&grammar, step), "{file} {step}");
            let mut end = 0;
            for (at, module) in before.iter().enumerate() {
                let range = recorded.successor(at);
                assert_eq!(range.start, end, "{file} {step}: no gaps");
                end = range.end;
                if recorded.production(at).is_none() {
                    assert_eq!(
                        recorded.string.iter().nth(range.start),
                        Some(module),
                        "{file}"
                    );
                    assert_eq!(range.len(), 1, "{file} {step}");
                }
            }
            assert_eq!(end, recorded.string.len(), "{file} {step}: all of it");
        }
    }
}

#[test]
fn productions_are_told_by_text_and_line() {
    let grammar = parse("axiom A\nA -> B # grows\nB : weight 1 -> A\n");
    let all: Vec<_> = grammar.productions().collect();
    assert_eq!(
        all,
        [
            ("A -> B", "test.lsys:2"),
            ("B : weight 1 -> A", "test.lsys:3")
        ]
    );
}
