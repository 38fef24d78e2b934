//! Layouts by hand, and properties of any layout.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use proptest::prelude::*;

use super::{FormatError, format};
use crate::lsystem::parse;

fn laid_out(text: &str) -> String {
    let once = format(text, "t.lsys").unwrap_or_else(|e| panic!("{e}\n{text}"));
    let twice = format(&once, "t.lsys").unwrap_or_else(|e| panic!("{e}\n{once}"));
    assert_eq!(once, twice, "its own layout");
    once
}

#[test]
fn statements() {
    for (text, expected) in [
        (" axiom   A( 1,2 )B  [ + C ]", "axiom A(1, 2)B [ + C ]\n"),
        ("axiom   A()  B ( 1 )", "axiom A() B(1)\n"),
        (
            "const a=1,b = - a*2+ (3-a)^ 2 , c=max( a,2+ 1)\n",
            "const a = 1, b = -a * 2 + (3-a)^2, c = max(a, 2+1)\n",
        ),
        (
            "steps   10\nseed  7\nangle 22.50\n",
            "steps 10\nseed 7\nangle 22.50\n",
        ),
        ("axiom *\nignore +-F\n", "axiom *\nignore + - F\n"),
        (
            "ground   - 0.5\ntropism 0 - 1   +2\norder   first\nwrap restart\n",
            "ground -0.5\ntropism 0 -1 +2\norder first\nwrap restart\n",
        ),
        (
            "module Leaf( size,age ) ,Bud\naxiom Leaf(1,2)Bud A\n",
            "module Leaf(size, age), Bud\naxiom Leaf(1, 2)Bud A\n",
        ),
        (
            "shape A=[( 0 1 0 )(.5,-1 0  .1),]\n",
            "shape A = [(0 1 0) (.5, -1 0 .1),]\n",
        ),
        (
            "shape A = [\n (0 1 0)\n     (1 0 0)\n]\n",
            "shape A = [\n    (0 1 0)\n    (1 0 0)\n]\n",
        ),
    ] {
        assert_eq!(laid_out(text), expected, "{text}");
    }
}

#[test]
fn productions() {
    for (text, expected) in [
        ("A-->B\n", "A -> B\n"),
        ("- -> +\n+-->-\n--->A\n", "- -> +\n+ -> -\n- -> A\n"),
        (
            "A(x):x>1&&!(x==3)||x<-1->A(x-1)F(- -x)[-(x--1)]\n",
            "A(x) : x > 1 && !(x == 3) || x < -1 -> A(x-1)F(- -x)[-(x- -1)]\n",
        ),
        ("B  C<A>D [E]  :  *->  *\n", "B C < A > D [E] : * -> *\n"),
        (
            "A:weight  0.33->A A\nA:1<2,weight 2*3->*\n",
            "A : weight 0.33 -> A A\nA : 1 < 2, weight 2 * 3 -> *\n",
        ),
        (
            "A(x) : x<7 -> B\nA(x) : x>=17 -> C\nB > C -> D\n",
            "A(x) : x < 7   -> B\nA(x) : x >= 17 -> C\nB > C -> D\n",
        ),
        (
            "A(x):x<1->B\n B\nAB<G(x):x<2->C\n",
            "A(x)      : x < 1 -> B\n    B\nAB < G(x) : x < 2 -> C\n",
        ),
        // Neighbours end at blank lines and comments, and long heads leave the others alone.
        (
            "A -> B\n# c\nA < B -> B\n\nA -> C\n",
            "A -> B\n# c\nA < B -> B\n\nA -> C\n",
        ),
        (
            "A -> B\nA < B : 1 + 1 == 2 && 3 + 3 == 6 -> B\n",
            "A -> B\nA < B : 1 + 1 == 2 && 3 + 3 == 6 -> B\n",
        ),
    ] {
        assert_eq!(laid_out(text), expected, "{text}");
    }
}

#[test]
fn lines_and_comments() {
    for (text, expected) in [
        (
            "\n\n# a grammar \r\n\n\n\naxiom A   # first\n\n\nA -> F\n  [A]#x\n       # between\n  A\n\n",
            "# a grammar\n\naxiom A  # first\n\nA -> F\n    [A]  #x\n    # between\n    A\n",
        ),
        (
            "axiom A # one\nA -> BB# two\nB -> A\n",
            "axiom A  # one\nA -> BB  # two\nB -> A\n",
        ),
        (
            "A -> B # one\nA -> BB# two\n",
            "A -> B   # one\nA -> BB  # two\n",
        ),
        (
            "decompose   depth 2*3{ # why\nA->B\n     # in it\nB -> C\n C\n  # last\n}\n# after\n",
            "decompose depth 2 * 3 {  # why\n  A -> B\n  # in it\n  B -> C\n      C\n  # last\n}\n# after\n",
        ),
        ("", ""),
        ("\u{feff}axiom\u{a0}A\u{2003}B\n", "axiom A B\n"),
    ] {
        assert_eq!(laid_out(text), expected, "{text}");
    }
}

#[test]
fn words_that_a_blank_would_make_statements() {
    for (text, expected) in [
        (
            "const seed = 2\nconst b = 1 +\n  seed*2\n",
            "const seed = 2\nconst b = 1 +\n    seed* 2\n",
        ),
        (
            "module seed(x), angle\nangle->seed(1)\nseed(x):x>1->*\n",
            "module seed(x), angle\nangle-> seed(1)\nseed(x) : x > 1 -> *\n",
        ),
    ] {
        assert_eq!(laid_out(text), expected, "{text}");
    }
}

#[test]
fn a_text_with_faults_is_not_laid_out() {
    let fault = format("axiom A\nA -> B(x)\n", "t.lsys");
    assert!(matches!(fault, Err(FormatError::Grammar(_))), "{fault:?}");
}

/// Pieces of a statement that blanks may part.
fn pieces() -> impl Strategy<Value = Vec<&'static str>> {
    let statements: Vec<Vec<&'static str>> = [
        "axiom | A ( 1 , x * 2 ) B [ + C ] ~S F′ A₁ @Gs ?",
        "ignore | + - F",
        "const | x = - 2 ^ 2 , y = x * ( 3 - - x ) + min ( x , 4 ) % 3",
        "const | z = x == 1 && ! ( x < 2 || x != .5e3 )",
        "angle | x + 5",
        "order | specific",
        "tropism | 0 - 1 2",
        "module | Leaf ( a , b ) , Bud",
        "shape | A = [ ( 0 1 0 ) ( 1 -1 0.5 0.1 ) ]",
        "include | \"none.lsys\"",
        "B < A ( a ) > C [ D ] : a > x , weight 2 * a -> A ( a - x ) [ + B ] Leaf ( 1 , 2 ) Bud { . }",
        "A ( a ) : weight a / 2 -> *",
        "- -> + - F % $ / ( 3 ) \\ | ' , ;",
        "+ : * --> A ( - - x , ! x , x < - 2 )",
        "decompose | depth 3 {",
        "interpret | {",
        "}",
        "seed | x",
    ]
    .iter()
    .map(|line| line.split(' ').collect())
    .collect();
    proptest::sample::select(statements)
}

/// A statement with blanks, comments and line ends of all kinds between its pieces.
fn statement() -> impl Strategy<Value = String> {
    let gap = prop_oneof![
        4 => Just(""),
        4 => Just(" "),
        1 => Just("  \t"),
        1 => Just("\n   "),
        1 => Just(" # c -> d\n  "),
        1 => Just("\r\n\n "),
        1 => Just("\u{feff}"),
    ];
    let end = prop_oneof![
        Just("\n"),
        Just("  # c\n"),
        Just("\r\n\n\n"),
        Just("\n  # c\n")
    ];
    (pieces(), proptest::collection::vec(gap, 40), end).prop_map(|(pieces, gaps, end)| {
        let mut text = String::new();
        for (piece, gap) in pieces.iter().zip(gaps) {
            match *piece {
                "|" => text.push(' '),
                piece => {
                    text.push_str(piece);
                    text.push_str(gap);
                }
            }
        }
        text.push_str(end);
        text
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn any_layout_is_its_own_and_means_the_same(statements in proptest::collection::vec(statement(), 1..6)) {
        let text = statements.concat();
        if let Ok((grammar, _)) = parse::with_text(&text, "t.lsys") {
            let once = format(&text, "t.lsys");
            prop_assert!(once.is_ok(), "{once:?}");
            let once = once.unwrap();
            prop_assert_eq!(&format(&once, "t.lsys").unwrap(), &once);
            let (again, _) = parse::with_text(&once, "t.lsys").unwrap();
            prop_assert!(again.meaning() == grammar.meaning());
        }
    }
}

#[test]
fn the_texts_of_the_property_are_mostly_grammars() {
    use proptest::strategy::ValueTree as _;
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let read = (0..500)
        .filter(|_| {
            let text = statement().new_tree(&mut runner).unwrap().current();
            parse::with_text(&text, "t.lsys").is_ok()
        })
        .count();
    assert!(
        read > 150,
        "{read} of 500 are read: the property says little"
    );
}
