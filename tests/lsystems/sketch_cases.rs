//! Growth of sketches: the cases and worked examples that the sketch's grammars must give.

use serde_json::Value;

use super::{derive, draw, parse, shared, text_of};

/// The rules of a sketch with one branch letter that carries itself, in the general language.
fn sketch_grammar(branch_node: u64) -> String {
    let mut text = String::from("context literal\naxiom A(0) B\n");
    for letter in ["A", "C"] {
        text += &format!(
            "{letter}(x) > B -> {letter}(x) {letter}(x+1)\n\
             {letter}(x) > {letter}(y) : y == x + 1 && (x + 1) % {branch_node} == 0 \
             -> {letter}(x) [ /(137.508 * ((x + 1) / {branch_node} - 1)) C(0) B ]\n"
        );
    }
    text + "shape A = [(0 1 0)]\nshape C = [(0.5 0.5 0) (0 1 0)]\n"
}

fn without_rolls(text: &str) -> String {
    let mut parts = text.split('/');
    let mut kept = parts.next().unwrap().to_owned();
    for part in parts {
        kept += part.split_once(')').unwrap().1;
    }
    kept
}

/// Section 3.2.1 as the cases repair it: B grows only at the end and not after BB.
const GROWTH: &str = "axiom AB\nB < B > B -> A\nA < B > A -> C\nB > B -> B\nB > A -> B\nB > C -> B\nBB < B -> B\nB -> BB\n";

#[test]
fn counts_of_the_text() {
    for (node, counts) in [
        (1, &[1, 2, 4, 7, 12, 20, 33][..]),
        (2, &[1, 2, 3, 5, 7, 10, 14, 19, 26, 35]),
        (3, &[1, 2, 3, 4, 6, 8, 10, 13, 17, 21, 26]),
    ] {
        let grammar = parse(&sketch_grammar(node));
        for (step, expected) in (0..).zip(counts) {
            let string = derive(&grammar, step);
            let letters = |name: &str| matches!(name, "A" | "C");
            let segments = string
                .iter()
                .filter(|m| letters(grammar.name(m.symbol)))
                .count();
            assert_eq!(segments, *expected, "n = {node}, w{step}");
            assert_eq!(
                draw(&grammar, &string).parent.len(),
                segments + 1,
                "one segment each, and the root"
            );
        }
    }
    let grammar = parse(&sketch_grammar(2));
    assert_eq!(
        without_rolls(&text_of(&grammar, 6)),
        "A(0)A(1)[C(0)C(1)[C(0)B]C(2)C(3)B]A(2)A(3)[C(0)C(1)B]A(4)A(5)A(6)B"
    );
    assert!(
        text_of(&grammar, 5).contains("A(3)[/(137.508)C(0)B]"),
        "the second branch is turned"
    );
}

/// The project's own copy of the cases, and the shared one where there is one.
fn case_files() -> Vec<Value> {
    let own = include_str!("../data/sketch-cases.json").to_owned();
    std::iter::once(own)
        .chain(shared("sketch-cases.json"))
        .map(|text| serde_json::from_str(&text).unwrap())
        .collect()
}

#[test]
fn all_cases() {
    for data in case_files() {
        let cases = data["cases"].as_array().unwrap();
        for case in cases {
            let steps = case["iteration"].as_u64().unwrap() as u32;
            let text = case["sketch"]["branch_node"]
                .as_u64()
                .map_or(GROWTH.to_owned(), sketch_grammar);
            let found = without_rolls(&text_of(&parse(&text), steps));
            assert_eq!(
                found,
                case["string"].as_str().unwrap(),
                "{} after {steps}",
                case["case"]
            );
        }
        assert!(cases.len() > 30, "{} cases", cases.len());
    }
}

/// The worked examples of the source text: section, grammar, and the step of the first string that the file lists.
#[test]
fn listings() {
    let grammars: [(&str, &str, u32); 6] = [
        ("2.4", "axiom AA\nA -> ABA\n", 1),
        ("3.2.1 signal", "axiom BAAAAAAA\nB < A -> B\nB -> A\n", 1),
        (
            "3.2.1 growth, repaired: B->BB only at the end and not after BB",
            GROWTH,
            0,
        ),
        (
            "3.2.2",
            "axiom A B(1)\nB(x) : x < 3 -> B(x+1)\nB(x) : x == 3 -> A B(1)\n",
            0,
        ),
        (
            "3.2.3",
            "axiom A(1) B(2)\nA(x) < B(y) : y >= 3 -> A(x*0.5) B(1)\nB(y) -> B(y+1)\n",
            0,
        ),
        ("3.3.4 first rule", "axiom AB\nA > B -> AA\n", 0),
    ];
    for data in case_files() {
        let listings = data["listings"].as_array().unwrap();
        assert_eq!(listings.len(), grammars.len(), "one grammar each");
        for (listing, (section, text, first)) in listings.iter().zip(grammars) {
            assert_eq!(listing["section"], section);
            let grammar = parse(text);
            let computed = &listing["computed"];
            let strings = computed
                .as_array()
                .map_or(std::slice::from_ref(computed), Vec::as_slice);
            assert!(!strings.is_empty(), "{section} lists nothing");
            for (step, expected) in (first..).zip(strings) {
                assert_eq!(
                    text_of(&grammar, step),
                    expected.as_str().unwrap(),
                    "{section}, step {step}"
                );
            }
        }
    }
}
