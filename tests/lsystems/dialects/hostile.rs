//! Texts that no program wrote: bounded time, no panics, and what is written can be read.

use std::time::Duration;

use proptest::prelude::*;
use ramus::lsystem::Grammar;
use ramus::lsystem::dialect::{Dialect, import};

/// Text that looks like what the programs read.
fn scraps() -> impl Strategy<Value = String> {
    let scrap = prop::sample::select(vec![
        "A",
        "B(x)",
        "F(1)",
        "(",
        ")",
        "[",
        "]",
        "{",
        "}",
        "-->",
        "=",
        ":",
        ";",
        "<",
        ">",
        "\n",
        "\n\t",
        "\n  ",
        " ",
        "if ",
        "else",
        "produce ",
        "x",
        "1.5",
        "+",
        "^",
        "**",
        "%",
        "?",
        "\"",
        "'",
        "#",
        "#define m(x) x\n",
        "m(1)",
        "/*",
        "*/",
        "//",
        "\\\n",
        "Lsystem: 1\n",
        "Axiom: A\n",
        "premise: A\n",
        "production:\n",
        "interpretation:\n",
        "homomorphism\n",
        "Start: {",
        "a = 1",
        "random()",
        "not ",
        " and ",
        "~l",
        "@Gs",
        "é",
        "′",
        "\u{1}",
        "ran(1)",
    ]);
    prop::collection::vec(scrap, 0..60).prop_map(|parts| parts.concat())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    #[test]
    fn any_text_is_a_grammar_or_faults_and_what_is_written_can_be_read(
        text in prop_oneof![scraps(), ".{0,200}"],
        which in 0_usize..3,
    ) {
        if let Ok(imported) = import(&text, "any", Dialect::ALL[which]) {
            let again = Grammar::parse(&imported.text, "written");
            prop_assert!(again.is_ok(), "{text}\n→\n{}\n{}", imported.text, again.unwrap_err());
        }
    }
}

/// Time of this thread's process for a piece of work.
fn cpu(work: impl FnOnce()) -> Duration {
    let began = cpu_time::ThreadTime::now();
    work();
    began.elapsed()
}

#[test]
fn hostile_texts_are_refused_in_time_that_grows_with_their_length() {
    let cpfg = "Lsystem: 1\nAxiom: A\n";
    let lpy = "Axiom: A\nproduction:\n";
    let many = |part: &str, n: usize| part.repeat(n);
    for (dialect, text) in [
        (
            Dialect::Cpfg,
            format!("{cpfg}A --> {}\n", many("[", 1_000_000)),
        ),
        (
            Dialect::Cpfg,
            format!("{cpfg}A --> B({}\n", many("(", 1_000_000)),
        ),
        (
            Dialect::Cpfg,
            format!("{cpfg}A --> B({}1)\n", many("-", 1_000_000)),
        ),
        (
            Dialect::Cpfg,
            format!("{cpfg}A --> B({}1)\n", many("1+", 1_000_000)),
        ),
        (
            Dialect::Cpfg,
            format!("{cpfg}A --> B\n{}", many("\tB\n", 500_000)),
        ),
        (
            Dialect::Cpfg,
            format!("{cpfg}A : {{{}}} * --> B\n", many("\nx = 1;", 200_000)),
        ),
        (
            Dialect::Cpfg,
            format!("{}{cpfg}", many("#define a b c\n", 200_000)),
        ),
        (
            Dialect::Cpfg,
            format!("#define m(x) x x\n{cpfg}A --> {}\n", many("m(", 300_000)),
        ),
        (
            Dialect::Cpfg,
            format!(
                "#define a b b\n#define b c c\n#define c d d\n#define d e e\n#define e a a\n{cpfg}A --> {}\n",
                many("a ", 100_000)
            ),
        ),
        (
            Dialect::Cpfg,
            (0..100_000)
                .map(|i| format!("#define c{i} {i}\n"))
                .collect::<String>()
                + cpfg,
        ),
        (Dialect::Cpfg, many("#ifdef x\n", 300_000)),
        (Dialect::Cpfg, many("/*", 1_000_000)),
        (
            Dialect::Cpfg,
            format!("{cpfg}A(x) --> B({}x{})\n", many("x ? 1 : ", 50), ""),
        ),
        (
            Dialect::Lpy,
            format!(
                "{lpy}A :\n{}",
                (0..2000)
                    .map(|i| format!("{}if 1:\n", " ".repeat(i)))
                    .collect::<String>()
            ),
        ),
        (
            Dialect::Lpy,
            format!(
                "{lpy}A(x) :
  y = x
{}  produce B(y)
",
                many(
                    "  y = y + y
",
                    5000
                )
            ),
        ),
        (
            Dialect::Lpy,
            format!(
                "{lpy}A(x) :\n{}  produce B\n",
                many("  if x > 1: nproduce C\n", 5000)
            ),
        ),
        (
            Dialect::Lpy,
            format!("{lpy}A --> {}\n", many("~", 1_000_000)),
        ),
        (
            Dialect::Lpy,
            format!("{lpy}A --> B({})\n", many("x if x else ", 300_000)),
        ),
        (
            Dialect::Lpy,
            format!("{lpy}A --> B({}x)\n", many("not ", 300_000)),
        ),
        (
            Dialect::Lpy,
            format!(
                "{}{lpy}",
                (0..100_000)
                    .map(|i| format!("module M{i}\n"))
                    .collect::<String>()
            ),
        ),
        (Dialect::Lpy, many("a = b = ", 300_000)),
        (
            Dialect::Houdini,
            format!("premise: {}\n", many("\"", 1_000_000)),
        ),
        (Dialect::Houdini, many("A=B:0.1\n", 300_000)),
        (Dialect::Houdini, many("b: 1\n", 300_000)),
        (
            Dialect::Houdini,
            format!("premise: A({}1)\n", many("1^", 300_000)),
        ),
    ] {
        let took = cpu(|| drop(import(&text, "hostile", dialect)));
        let start: String = text.chars().take(60).collect();
        // A third of a second a megabyte when it is slow; squares would take hours.
        assert!(
            took < Duration::from_secs(20),
            "{dialect} {start}: {took:?}"
        );
    }
}
