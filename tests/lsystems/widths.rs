//! Strings are stored as narrowly as grammar and steps allow; what they hold does not depend on it.

use std::fmt::Write as _;

use super::{derive, parse};

/// Births pass 255, 65,535 and come out right on every way to derive: by blocks, by the list of active modules and by rounds.
#[test]
fn births_of_long_derivations() {
    for (way, text) in [
        ("blocks", "axiom A\nA -> AB\n"),
        ("active", "axiom CA\nA -> AB\nC > X -> C\n"),
        ("rounds", "axiom A\nA : weight 1 -> AB\n"),
    ] {
        let grammar = parse(text);
        for steps in [255_u32, 256, 1000] {
            let string = derive(&grammar, steps);
            let born: Vec<u32> = string.births().filter(|b| *b > 0).collect();
            assert!(born.iter().copied().eq((1..=steps).rev()), "{way} {steps}");
            let width = if steps < 256 { 1 } else { 2 };
            assert_eq!(string.bytes(), string.len() as u64 * (1 + width), "{way}");
        }
    }
    let counter = parse("axiom A F\nA > F -> B\nB > F -> A\n");
    let births: Vec<u32> = derive(&counter, 70_000).births().collect();
    assert_eq!(births, [70_000, 0]);
}

/// More than 256 symbols, and more than 255 productions of few symbols.
#[test]
fn large_grammars() {
    let mut many = String::from("axiom S0\n");
    for i in 0..400 {
        let (next, last) = ((i + 1) % 400, i == 399);
        writeln!(
            many,
            "module S{i}\nS{i} -> S{next}{}",
            if last { "" } else { " S0" }
        )
        .unwrap();
    }
    let grammar = parse(&many);
    assert_eq!(derive(&grammar, 3).to_text(&grammar), "S3S0S1S0S2S0S1S0");
    assert_eq!(derive(&grammar, 3).bytes(), 8 * 3, "two bytes a symbol");

    let mut cases = String::from("axiom A(300) B A(12)\n");
    for i in 0..400 {
        writeln!(cases, "A(x) > B : x == {i} -> A({})", 1000 + i).unwrap();
    }
    let grammar = parse(&cases);
    assert_eq!(derive(&grammar, 1).to_text(&grammar), "A(1300)BA(12)");
}
