//! How the faults of a grammar are told: where, what was found, what was expected, and the nearest known name; without
//! further faults that follow from the first.

use std::fmt::Write as _;

use ramus::lsystem::{Grammar, GrammarErrors};

fn faults(text: &str) -> GrammarErrors {
    Grammar::parse(text, "t.lsys").expect_err(text)
}

/// Line, column and message of each fault.
fn told(text: &str) -> Vec<String> {
    let each = faults(text).errors;
    each.iter()
        .map(|fault| format!("{}:{}: {}", fault.line, fault.column, fault.message))
        .collect()
}

#[test]
fn every_fault_is_told_as_a_person_wants_it() {
    for (text, expected) in [
        (
            "axoim A\n",
            &[
                "1:1: found `axoim`; expected a statement or a production with `->`; the nearest known word is `axiom`",
            ][..],
        ),
        (
            "Axiom A\n",
            &[
                "1:1: found `Axiom`; expected a statement or a production with `->`; the nearest known word is `axiom`",
            ][..],
        ),
        (
            "axiom\n",
            &["1:6: found the end of the line; expected modules, or `*` for none"][..],
        ),
        (
            "axiom A(\n",
            &["1:9: found the end of the line; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A(1\n",
            &["1:10: found the end of the line; expected `,` or `)`"][..],
        ),
        (
            "axiom A(1,)\n",
            &["1:11: found `)`; expected a number, a name or `(`"][..],
        ),
        ("axiom A)B\n", &["1:8: found `)`; expected a module"][..]),
        (
            "axiom A[B\n",
            &["1:8: this `[` is not closed; expected a `]`"][..],
        ),
        (
            "axiom A]B\n",
            &["1:8: this `]` closes nothing; expected a `[` before it"][..],
        ),
        (
            "axiom A{B\n",
            &["1:8: this polygon's `{` is not closed; expected a `}`"][..],
        ),
        (
            "axiom A(b)\n",
            &["1:9: unknown name `b`; expected a number or a constant given above"][..],
        ),
        (
            "axiom A\naxiom B\n",
            &["2:1: `axiom` stands here a second time; expected it once"][..],
        ),
        (
            "axiom A\nsteps\n",
            &["2:6: found the end of the line; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nsteps ten\n",
            &["2:7: unknown name `ten`; expected a number or a constant given above"][..],
        ),
        (
            "axiom A\nsteps -1\n",
            &["2:7: found `-1`; expected a whole number from 0 to 4294967295"][..],
        ),
        (
            "axiom A\nsteps 2.5\n",
            &["2:7: found `2.5`; expected a whole number from 0 to 4294967295"][..],
        ),
        (
            "axiom A\nsteps 99999999999\n",
            &["2:7: found `99999999999`; expected a whole number from 0 to 4294967295"][..],
        ),
        (
            "axiom A\nstep 5\n",
            &[
                "2:1: found `step`; expected a statement or a production with `->`; the nearest known word is `steps`",
            ][..],
        ),
        (
            "axiom A\nseed x\n",
            &["2:6: found `x`; expected a whole number below 2^64"][..],
        ),
        (
            "axiom A\nangle\n",
            &["2:6: found the end of the line; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nangle 20 degrees\n",
            &["2:10: found `degrees`; expected the end of the line"][..],
        ),
        (
            "axiom A\nA -> B(x)\n",
            &["2:8: unknown name `x`; expected a parameter of this production or a constant"][..],
        ),
        (
            "axiom A\nA(len) -> B(lne)\n",
            &[
                "2:13: unknown name `lne`; expected a parameter of this production or a constant; the nearest known name is `len`",
            ][..],
        ),
        (
            "axiom A\nconst r1 = 2\nA -> F(r2)\n",
            &[
                "3:8: unknown name `r2`; expected a parameter of this production or a constant; the nearest known name is `r1`",
            ][..],
        ),
        (
            "axiom A\nA(x) -> B(sni(x))\n",
            &["2:11: unknown function `sni`; the nearest known is `sin`"][..],
        ),
        (
            "axiom A\nA(x) -> B(sqrt)\n",
            &["2:11: found `sqrt` without its arguments; expected `sqrt(…)`"][..],
        ),
        (
            "axiom A\nA(x) -> B(max(x))\n",
            &["2:11: `max` takes 2 arguments; found 1"][..],
        ),
        (
            "axiom A\nA(x) -> B(min(1, 2, 3))\n",
            &["2:11: `min` takes 2 arguments; found 3"][..],
        ),
        (
            "axiom A\nA(x) -> B(x +)\n",
            &["2:14: found `)`; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nA(x) -> B(x + * 2)\n",
            &["2:15: found `*`; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nA(x) -> B((x)\n",
            &["2:14: found the end of the line; expected `,` or `)`"][..],
        ),
        (
            "axiom A\nA(x) -> B(2x)\n",
            &["2:12: found `x`; expected an operator before `x`, as in `2*x`"][..],
        ),
        (
            "axiom A\nA(x) : x = 2 -> B\n",
            &["2:10: found `=`; expected a comparison; equality is written `==`"][..],
        ),
        (
            "axiom A\nA(x) : 1 < x < 3 -> B\n",
            &[
                "2:14: found `<`; expected one comparison; join two with `&&`, as in `0 < x && x < 1`",
            ][..],
        ),
        (
            "axiom A\nA(x) : x > 2 and x < 4 -> B\n",
            &["2:14: found `and`; expected `->` or `&&`"][..],
        ),
        (
            "axiom A\nA(x) : uniform(0,1) < x -> B\n",
            &[
                "2:8: `uniform` draws at random, which only a successor's parameters may; found it elsewhere",
            ][..],
        ),
        (
            "axiom A\nA(x) : x > 2\n",
            &["2:13: found the end of the line; expected `->` and a successor"][..],
        ),
        ("axiom A\nA => B\n", &["2:3: found `=>`; expected `->`"][..]),
        (
            "axiom A\nA - > B\n",
            &["2:3: found `- >`; expected `->`"][..],
        ),
        ("axiom A\nA → B\n", &["2:3: found `→`; expected `->`"][..]),
        (
            "axiom A\nA ->\n",
            &["2:5: found the end of the line; expected the successor, or `*` for none"][..],
        ),
        (
            "axiom A\n-> B\n",
            &["2:1: found `-`; expected the module that is replaced, before `->`"][..],
        ),
        (
            "axiom A\nA B -> C\n",
            &[
                "2:3: found `B`; expected one predecessor only (contexts stand before `<` and after `>`)",
            ][..],
        ),
        (
            "axiom A\n< A -> C\n",
            &["2:1: the left context is empty; expected a module before `<`"][..],
        ),
        (
            "axiom A\nA > -> C\n",
            &["2:5: found `-`; expected a module of the right context"][..],
        ),
        (
            "axiom A\nA(1) -> B\n",
            &[
                "2:3: found `1`; expected the name of a parameter; a value is tested in the condition, as in `A(x) : x == 0 -> …`",
            ][..],
        ),
        (
            "axiom A\nA(x, x) -> B\n",
            &["2:6: the parameter `x` is bound twice in this production; give one another name"][..],
        ),
        (
            "axiom A\nB(x) < A(x) -> B\n",
            &["2:3: the parameter `x` is bound twice in this production; give one another name"][..],
        ),
        (
            "axiom A\n[B] < A -> C\n",
            &[
                "2:1: a left context is the path to the root and has no brackets; expected modules only",
            ][..],
        ),
        (
            "axiom A\nA > [B -> C\n",
            &["2:5: this `[` is not closed; expected a `]`"][..],
        ),
        (
            "axiom A\nA > B] -> C\n",
            &["2:6: this `]` closes nothing; expected a `[` before it"][..],
        ),
        (
            "axiom A\n[ -> B\n",
            &["2:1: `[` cannot be replaced by a production"][..],
        ),
        (
            "axiom A\nA -> [B\n",
            &["2:6: this `[` is not closed; expected a `]`"][..],
        ),
        (
            "axiom A\nA -> B]\n",
            &["2:7: this `]` closes nothing; expected a `[` before it"][..],
        ),
        (
            "axiom A\nA -> {B\n",
            &["2:6: this polygon's `{` is not closed; expected a `}`"][..],
        ),
        (
            "axiom A\nA : weight -> B\n",
            &["2:12: found `-`; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nA : weigth 2 -> B\n",
            &[
                "2:5: found `weigth`; expected a condition or `weight`, which is the nearest known word",
            ][..],
        ),
        (
            "axiom A\nA : 0.33 -> B\nA : 0.5 -> C\n",
            &[
                "2:5: found the number `0.33` as a condition, which always holds; a weight is written `weight 0.33`",
                "3:5: found the number `0.5` as a condition, which always holds; a weight is written `weight 0.5`",
            ][..],
        ),
        (
            "axiom A\nA : x > 1, 2 -> B\n",
            &[
                "2:5: unknown name `x`; expected a parameter of this production or a constant",
                "2:12: found `2`; expected `weight`",
            ][..],
        ),
        (
            "axiom A\nA -(0.5)-> B\n",
            &[
                "2:5: found `0.5`; expected the name of a parameter; a value is tested in the condition, as in `A(x) : x == 0 -> …`",
            ][..],
        ),
        (
            "axiom A\nA : 33%  -> B\n",
            &["2:10: found `-`; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nmodule Leaf(s)\nA -> Leaf\n",
            &["3:6: `Leaf` is declared with 1 parameter (s); found 0"][..],
        ),
        (
            "axiom A\nmodule Leaf(s)\nA -> Laef(1)\n",
            &[
                "3:6: found `Laef`, which reads as one module for each letter; the nearest declared module is `Leaf` (blanks between the letters say that they are meant)",
            ][..],
        ),
        (
            "axiom A\nmodule Leaf(s)\nmodule Leaf(t)\n",
            &["3:8: `Leaf` is declared twice"][..],
        ),
        (
            "axiom A\nmodule 3x\n",
            &["2:8: found `3x`; expected the name of a module, beginning with a letter"][..],
        ),
        (
            "axiom A\nmodule Leaf(1)\n",
            &["2:13: found `1`; expected the name of a parameter"][..],
        ),
        (
            "axiom A\nignore [ ]\n",
            &["2:8: brackets are always seen by contexts; expected other modules"][..],
        ),
        (
            "axiom A\nignore A\nB < A -> C\nA < B -> C\n",
            &[
                "4:1: contexts skip `A`, so this one never matches; take `A` out of `ignore`, or out of the context",
            ][..],
        ),
        (
            "axiom A\nconsider B\nA < B -> C\n",
            &[
                "3:1: contexts skip `A`, so this one never matches; add `A` to `consider`, or take it out of the context",
            ][..],
        ),
        (
            "axiom A\nignore +\nconsider B\n",
            &["3:1: found both `ignore` and `consider`; expected one of them"][..],
        ),
        (
            "axiom A\ncontext literal\nignore +\n",
            &[
                "3:1: `context literal` sees every module, so `ignore` and `consider` mean nothing with it; remove one of them",
            ][..],
        ),
        (
            "axiom A\ncontext litteral\n",
            &["2:9: found `litteral`; expected `literal` or `branches`; the nearest is `literal`"]
                [..],
        ),
        (
            "axiom A\norder best\n",
            &["2:7: found `best`; expected `first` or `specific`"][..],
        ),
        (
            "axiom A\nwrap round\n",
            &["2:6: found `round`; expected `carry` or `restart`"][..],
        ),
        (
            "axiom A\ntropism 0 -1\n",
            &["2:13: found the end of the line; expected a number"][..],
        ),
        (
            "axiom A\nground\n",
            &["2:7: found the end of the line; expected a number"][..],
        ),
        (
            "axiom A\nground 1e999\n",
            &["2:8: this number is larger than a number can be (1.8e308)"][..],
        ),
        (
            "axiom A\ntropism down\n",
            &["2:9: found `down`; expected a number"][..],
        ),
        (
            "axiom A\nshape A = [(1 2)]\n",
            &["2:17: found `]`; expected three numbers x y z, or four with a radius, before `)`"][..],
        ),
        (
            "axiom A\nshape A = []\n",
            &["2:7: the shape `A` is empty; expected at least one `(x y z)`"][..],
        ),
        (
            "axiom A\nshape A [(0 1 0)]\n",
            &["2:9: found `[`; expected `=`"][..],
        ),
        (
            "axiom A\nshape + = [(0 1 0)]\n",
            &["2:7: `+` is a sign of the turtle; expected a letter"][..],
        ),
        (
            "axiom A\nshape A = [(0 1 0 -1)]\n",
            &["2:19: a radius cannot be negative"][..],
        ),
        (
            "axiom A\nshape A = [(0 1 0)\nA -> B\n",
            &["2:19: found the end of the line; expected `(`"][..],
        ),
        (
            "axiom A\nshape A = [(0 1 z)]\n",
            &["2:17: found `z`; expected a number"][..],
        ),
        (
            "axiom A\nshape A = [(0 1 0)]\nshape A = [(0 1 0)]\n",
            &["3:7: `A` is a shape or surface already"][..],
        ),
        (
            "axiom A\ninclude rules.lsys\n",
            &[
                "2:9: found `rules.lsys`; expected a file's name in quotes, as in `include \"rules.lsys\"`",
            ][..],
        ),
        (
            "axiom A\ninclude \"rules.lsys\n",
            &["2:10: this file name is not closed; expected `\"`"][..],
        ),
        (
            "axiom A\ndecompose\n  A -> B\n",
            &["2:10: found the end of the line; expected `{`"][..],
        ),
        (
            "axiom A\ndecompose {\n  A -> B\n",
            &["2:1: this block is not closed; expected `}` on its own line"][..],
        ),
        (
            "axiom A\ndecompose {\n  B < A -> B\n}\n",
            &["3:3: found a context; productions in `decompose` and `interpret` have none"][..],
        ),
        (
            "axiom A\ndecompose {\n  steps 4\n}\n",
            &["3:3: found `steps` inside a block; expected a production or `}`"][..],
        ),
        ("axiom A\n}\n", &["2:1: this `}` closes no block"][..]),
        (
            "axiom A\ninterpret {\n  A -> B\n  interpret {\n}\n",
            &["4:3: found `interpret` inside a block; expected a production or `}`"][..],
        ),
        (
            "axiom A\ninterprte {\n  A -> B\n}\n",
            &[
                "2:1: found `interprte`; expected a statement or a production with `->`; the nearest known word is `interpret`",
            ][..],
        ),
        (
            "axiom A\nconst = 3\n",
            &["2:7: found `=`; expected the name of a constant"][..],
        ),
        (
            "axiom A\nconst r\n",
            &["2:8: found the end of the line; expected `=`"][..],
        ),
        (
            "axiom A\nconst r 3\n",
            &["2:9: found `3`; expected `=`"][..],
        ),
        (
            "axiom A\nconst a = b, b = 2\n",
            &["2:11: unknown name `b`; expected a number or a constant given above"][..],
        ),
        (
            "axiom A\nconst a = 1\nconst a = 2\n",
            &["3:7: the constant `a` is given a value twice"][..],
        ),
        (
            "axiom A\nconst a = 1/0\n",
            &["2:11: this has no value: division by zero"][..],
        ),
        (
            "axiom A\nconst a = uniform(0,1)\n",
            &[
                "2:11: `uniform` draws at random, which only a successor's parameters may; found it elsewhere",
            ][..],
        ),
        (
            "axiom ~\n",
            &["1:8: found the end of the line; expected the name of a shape after `~`"][..],
        ),
        (
            "axiom @X\n",
            &["1:7: found `@`; expected one of the turtle's `@O`, `@Gs`, `@Ge`, `@l`, `@a`, `@w`"]
                [..],
        ),
        (
            "axiom ?Q(1,2)\n",
            &["1:7: found `?`; expected one of the turtle's `?P`, `?H`, `?U`, `?L`, `?S`, `?C`"][..],
        ),
        (
            "axiom ?P\n",
            &[
                "1:7: found `?P` with 0 parameters; expected the two or three that the turtle writes its answer into, as in `?P(0, 0, 0)`",
            ][..],
        ),
        (
            "axiom F(1)(2)\n",
            &["1:11: found `(`; expected a module; parameters follow a module's name"][..],
        ),
        (
            "axiom A*B\n",
            &["1:8: found `*`; expected a module; `*` means no module at all and stands alone"][..],
        ),
        ("axiom \"A\"\n", &["1:7: found `\"`; expected a module"][..]),
        (
            "axiom A\u{1}B\n",
            &["1:8: found the control character U+0001; expected a module"][..],
        ),
        (
            "A -> B\n",
            &["2:1: this grammar has no axiom; expected a line such as `axiom A`"][..],
        ),
        (
            "",
            &["1:1: this grammar has no axiom; expected a line such as `axiom A`"][..],
        ),
        (
            "#define R 2\naxiom A\nF(x) -> F(x*R)\n",
            &["3:13: unknown name `R`; expected a parameter of this production or a constant"][..],
        ),
        (
            "axiom: A\n",
            &["1:1: found `axiom:`; expected a blank after `axiom`, as in `axiom …`"][..],
        ),
        ("axiom = A\n", &["1:7: found `=`; expected a module"][..]),
        (
            "lsystem: 1\naxiom A\n",
            &["1:11: found the end of the line; expected `->` and a successor"][..],
        ),
        (
            "derivation length: 5\naxiom A\n",
            &[
                "1:1: found `derivation`; expected a statement; the number of steps is said by `steps 5`",
            ][..],
        ),
        (
            "axiom A\np1: A -> B\n",
            &["2:1: found the label `p1:`; productions have none, expected the production alone"][..],
        ),
        (
            "axiom A\nA -> B(1e999)\n",
            &["2:8: this number is larger than a number can be (1.8e308)"][..],
        ),
        (
            "axiom A\nA(x) -> B(x^)\n",
            &["2:13: found `)`; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nA(x) -> B(pi)\n",
            &["2:11: unknown name `pi`; expected a parameter of this production or a constant"][..],
        ),
        (
            "axiom A\nA(x) -> B(X)\n",
            &[
                "2:11: unknown name `X`; expected a parameter of this production or a constant; the nearest known name is `x`",
            ][..],
        ),
        (
            "axiom A\nA(x)-> B(x\nC -> D\n",
            &["2:11: found the end of the line; expected `,` or `)`"][..],
        ),
        (
            "axiom A\nmodule Leaf(s)\nA -> Laef(1) [Leag(2)] LLLL Leaf(1)F\n",
            &[
                "3:6: found `Laef`, which reads as one module for each letter; the nearest declared module is `Leaf` (blanks between the letters say that they are meant)",
                "3:15: found `Leag`, which reads as one module for each letter; the nearest declared module is `Leaf` (blanks between the letters say that they are meant)",
            ][..],
        ),
        (
            "axiom A\nconst r = 2 +\nA -> B(r)\nC -> B(r)\n",
            &["2:14: found the end of the line; expected a number, a name or `(`"][..],
        ),
        (
            "axiom A\nA -> B(q) C(q)\nD -> B(q)\n",
            &[
                "2:8: unknown name `q`; expected a parameter of this production or a constant",
                "3:8: unknown name `q`; expected a parameter of this production or a constant",
            ][..],
        ),
        (
            "axiom A\nA(x) : x > 2 or x < 1 -> B\n",
            &["2:14: found `or`; expected `->` or `||`"][..],
        ),
        (
            "axiom A\nmodul Leaf(s)\n",
            &[
                "2:1: found `modul`; expected a statement or a production with `->`; the nearest known word is `module`",
            ][..],
        ),
        (
            "axiom A\nincldue \"x.lsys\"\n",
            &[
                "2:1: found `incldue`; expected a statement or a production with `->`; the nearest known word is `include`",
            ][..],
        ),
        (
            "axiom A\ninterpret {\n  A -> B\n  include \"x.lsys\"\n}\n",
            &["4:3: `include` inside a block; expected it outside"][..],
        ),
        (
            "axiom A\nA -> B(é, xx)\n",
            &[
                "2:8: unknown name `é`; expected a parameter of this production or a constant",
                "2:11: unknown name `xx`; expected a parameter of this production or a constant",
            ][..],
        ),
        (
            "axiom A\nshape A = [(0 1 0 0 1)]\n",
            &["2:21: found `1`; expected `)` after x, y, z and a radius"][..],
        ),
        (
            "axiom F[+F\nF -> F]\nG -> [{F]}\n",
            &[
                "1:8: this `[` is not closed; expected a `]`",
                "2:7: this `]` closes nothing; expected a `[` before it",
            ][..],
        ),
    ] {
        assert_eq!(told(text), expected, "{text}");
    }
}

#[test]
fn the_caret_stands_under_the_fault() {
    for (text, shown) in [
        (
            "axiom A\nA -> B(é, xx)\n",
            "    A -> B(é, xx)\n              ^",
        ),
        ("\taxiom A(b)\n", "     axiom A(b)\n             ^"),
    ] {
        let said = faults(text).to_string();
        assert!(said.ends_with(shown), "{said}");
    }
    let missing = faults("A -> B\n").to_string();
    assert_eq!(
        missing.lines().count(),
        1,
        "what is missing has no line: {missing}"
    );
}

#[test]
fn a_line_of_a_million_characters_is_shown_around_the_fault() {
    let text = format!("axiom {}]{}\n", "AB".repeat(250_000), "C".repeat(500_000));
    let errors = faults(&text).errors;
    assert_eq!((errors[0].line, errors[0].column), (1, 500_007));
    let caret = errors[0].excerpt.chars().nth(errors[0].caret);
    assert_eq!(caret, Some(']'), "{}", errors[0].excerpt);
    assert!(errors[0].excerpt.len() <= 100);
}

#[test]
fn twenty_faults_are_told_and_the_others_counted() {
    let mut text = "axiom A\n".to_owned();
    for at in 0..50 {
        let _ = writeln!(text, "A -> B(x{at})");
    }
    let errors = faults(&text);
    assert_eq!((errors.errors.len(), errors.more), (20, 30));
    assert!(errors.to_string().ends_with("\nand 30 more"), "{errors}");
}

#[test]
fn an_include_that_is_not_there_names_the_one_that_is() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.lsys");
    std::fs::write(folder.path().join("leaves.lsys"), "B -> C\n").unwrap();
    let text = "include \"leafes.lsys\"\naxiom A\n";
    std::fs::write(&main, text).unwrap();
    let errors = Grammar::parse(text, main.to_str().unwrap()).unwrap_err();
    assert_eq!(
        errors.errors[0].message,
        "there is no `leafes.lsys` in the grammar's folder; the nearest that is there is `leaves.lsys`"
    );
}
