//! What a drawing carries: statements about looks, and the canvas that keeps them.

use std::sync::atomic::AtomicBool;

use glam::Vec3;
use ramus::lsystem::{DeriveError, DeriveProblem, Grammar, Limits, TurtleParams};
use ramus::tree::organs::{Paint, from_bytes};
use ramus::tree::{Drawing, NO_PARENT};

use super::{derive, draw, parse};

fn drawing_within(text: &str, bytes: u64) -> Result<Drawing, DeriveError> {
    let grammar = parse(text);
    let string = derive(&grammar, 0);
    let params = TurtleParams {
        limits: Limits {
            bytes,
            ..Limits::default()
        },
        ..TurtleParams::default()
    };
    ramus::lsystem::draw(&grammar, &string, &params, &AtomicBool::new(false))
}

fn drawing(text: &str) -> Drawing {
    let drawing = drawing_within(text, 1 << 30).unwrap();
    drawing.tree.validate().unwrap();
    drawing.organs.validate(&drawing.tree).unwrap();
    let grammar = parse(text);
    assert_eq!(
        drawing.tree,
        draw(&grammar, &derive(&grammar, 0)),
        "the skeleton is the same"
    );
    drawing
}

#[test]
fn everything_reaches_the_drawing() {
    let made = drawing(
        "axiom F '(3) ;(2) F @O(0.5) ~L(2) [+(90) {.f.+(90)f.}] ,  F @Gs F +(30) F [ F ] @Ge F\nsurface L = petal\n",
    );
    let organs = &made.organs;
    let paint = |colour, material| Paint { colour, material };
    let painted: Vec<Paint> = (1..=7).map(|node| organs.paint(node)).collect();
    assert_eq!(painted[..3], [paint(0, 0), paint(3, 2), paint(2, 2)]);
    let [sphere] = organs.spheres[..] else {
        panic!("one sphere")
    };
    assert_eq!((sphere.center, sphere.radius), (Vec3::Y * 2.0, 0.5));
    assert_eq!((sphere.paint, sphere.node), (paint(3, 2), 2));
    let [placed] = organs.placed[..] else {
        panic!("one surface")
    };
    assert_eq!(
        (placed.scale, placed.position, placed.node),
        (2.0, Vec3::Y * 2.0, 2)
    );
    assert_eq!(organs.polygons.len(), 1);
    let corners = organs.corners_of(0);
    assert!(
        corners[1].distance(Vec3::new(-1.0, 2.0, 0.0)) < 1e-6,
        "{corners:?}"
    );
    // Nodes 4 and 5 are one cylinder, 6 in its bracket is one of its own, 7 is none.
    let smooth: Vec<_> = organs.smooth.iter().map(|s| (s.node, s.cylinder)).collect();
    assert_eq!(smooth, [(4, 4), (5, 4), (6, 6)]);
}

#[test]
fn a_plain_tree_carries_nothing() {
    let made = drawing("axiom F[+F]F\n");
    assert_eq!(made.organs.bytes(), 0);
    assert!(made.organs.is_bare());
}

#[test]
fn what_a_tilde_places() {
    let made = drawing(
        "axiom ~L ~M ~S ~M\nsurface L = [(0 0 0) (1 0 0) (0 1 0)]\nshape S = [(0 1 0) (1 0 0)]\n",
    );
    let organs = &made.organs;
    let [first, second, third] = organs.placed[..] else {
        panic!("three surfaces")
    };
    assert_eq!(
        organs.surfaces[usize::from(first.surface)].positions.len(),
        3
    );
    assert!(
        organs.surfaces[usize::from(second.surface)].positions.len() > 20,
        "the leaf"
    );
    assert_eq!(second.surface, third.surface);
    assert_eq!(made.tree.segment_count(), 2, "a shape is drawn as segments");
    assert_eq!(first.node, 0);
    assert_eq!(drawing("axiom f ~L\n").organs.placed[0].node, NO_PARENT);
}

#[test]
fn statements_set_colours_and_materials() {
    let made = drawing(
        "colour 0 = 1 0 0\ncolour 300 = 0.2, 0.6, 0.1\nmaterial 7 = metallic 1 roughness 0.25\naxiom F\n",
    );
    let palette = &made.organs.palette;
    assert_eq!(palette.colour(0), Some(from_bytes([255, 0, 0])));
    let [r, g, b] = palette.colour(300).unwrap();
    assert!(g > r && r > b);
    let material = palette.material(7);
    assert_eq!((material.metallic, material.roughness), (1.0, 0.25));
}

#[test]
fn faults_in_looks_are_told_where_they_stand() {
    for (line, said) in [
        ("colour x = 1 1 1", "whole number"),
        ("colour 70000 = 1 1 1", "whole number"),
        ("colour 1 = 1 1", "number"),
        ("colour 1 = 1 1 2", "blue as a number from 0 to 1"),
        ("colour 1 = -0.1 1 1", "red as a number from 0 to 1"),
        ("colour 1 = 1 1 1\ncolour 1 = 0 0 0", "given twice"),
        ("material 1 =", "`roughness` or `metallic`"),
        ("material 1 = rough 1", "`roughness` or `metallic`"),
        (
            "material 1 = roughness 3",
            "roughness as a number from 0 to 1",
        ),
        (
            "material 1 = metallic 0\nmaterial 1 = metallic 0",
            "given twice",
        ),
        ("surface L = lead", "nearest known one is `leaf`"),
        ("surface L = [(0 0 0) (1 0 0)]", "spans no area"),
        ("surface L = [(0 0 0) (1 0 0) (2 0 0)]", "spans no area"),
        ("surface L = [(0 0) (1 0 0)]", "number"),
        ("surface L = [(0 0 1e30) (1 0 0)]", "about 1 long"),
        ("surface + = leaf", "sign of the turtle"),
        ("surface L = leaf\nsurface L = disc", "already"),
        ("shape L = [(0 1 0)]\nsurface L = disc", "already"),
        ("color 1 = 1 1 1", "nearest known word is `colour`"),
    ] {
        let errors = Grammar::parse(&format!("axiom F\n{line}\n"), "looks.lsys").unwrap_err();
        let text = errors.to_string();
        assert!(
            text.contains(said) && text.contains("looks.lsys:"),
            "{line}: {text}"
        );
    }
}

#[test]
fn braces_may_close_what_the_segment_before_began() {
    // ABOP Fig. 5.8, the rose leaf.
    parse("axiom [{A.}]\nA -> .G.[+BG.}][+B{.]A\n");
    let error = |text: &str| Grammar::parse(text, "braces.lsys").unwrap_err().to_string();
    assert!(error("axiom F}\n").contains("closes no polygon"));
    assert!(error("axiom F\nF -> {F}}\n").contains("closes no polygon"));
    assert!(error("axiom F\nF -> }{{F\n").contains("is not closed"));
}

#[test]
fn a_drawing_ends_where_its_memory_does() {
    let many = |what: &str| format!("axiom {}\n", what.repeat(1000));
    for text in [
        many("@O"),
        many("~L"),
        many("{.f.+f.}"),
        many("'F"),
        many("@Gs F @Ge"),
    ] {
        let error = drawing_within(&text, 20_000).unwrap_err();
        assert!(
            matches!(
                *error.problem,
                DeriveProblem::TooManyOrgans { .. } | DeriveProblem::TooManyNodes { .. }
            ),
            "{error}"
        );
        drawing_within(&text, 200_000).unwrap();
    }
    let mut wide = String::from("axiom {");
    wide.push_str(&"f+(1)".repeat(50_001));
    wide.push_str("}\n");
    let error = drawing_within(&wide, 1 << 30).unwrap_err();
    assert!(error.to_string().contains("50001 corners"), "{error}");
}

fn grown(grammar: &Grammar, steps: u32) -> Drawing {
    let never = AtomicBool::new(false);
    let string = derive(grammar, steps);
    ramus::lsystem::draw(grammar, &string, &TurtleParams::default(), &never).unwrap()
}

/// What a grammar says of bark, leaves and the season is on its trees.
#[test]
fn trees_wear_what_their_grammar_says() {
    let text = "widths da-vinci tip 0.005 exponent 2\nbark birch flare 1\nseason autumn\nbears birch size 0.06 every 0.1 twig 0.01\n\
                bears fruit in autumn winter tips\nsteps 3\naxiom A\nA -> F(1) [ +(40) A ] [ -(40) A ]\n";
    let grammar = Grammar::parse(text, "t.lsys").unwrap();
    let mut drawing = grown(&grammar, 3);
    assert_eq!(grammar.finish(&mut drawing), None, "no widths to fit");
    drawing.organs.validate(&drawing.tree).unwrap();
    assert_eq!(drawing.organs.surfaces.len(), 2);
    assert!(
        (drawing.tree.radius[0] - 0.01).abs() < 1e-6,
        "four tips of 5 mm: {}",
        drawing.tree.radius[0]
    );
    let leaves = drawing
        .organs
        .placed
        .iter()
        .filter(|placed| placed.surface == 0)
        .count();
    let fruit = drawing
        .organs
        .placed
        .iter()
        .filter(|placed| placed.surface == 1)
        .count();
    assert!((60..=80).contains(&leaves), "{leaves}");
    assert_eq!(fruit, 4);
    let winter = grammar.with_season(ramus::tree::foliage::Season::Winter);
    let mut bare = grown(&winter, 3);
    winter.finish(&mut bare);
    assert!(
        bare.organs.placed.iter().all(|placed| placed.surface == 0),
        "fruit alone"
    );
    assert_eq!(bare.organs.placed.len(), 4);
}

#[test]
fn faults_in_what_trees_wear_are_told() {
    for (line, told) in [
        ("bark oack", "the nearest known one is `oak`"),
        ("bark oak flare 9", "from 0 to 4"),
        ("bark oak shiny", "expected one of flare"),
        ("bark", "one of plain, maple"),
        (
            "season fall",
            "expected one of spring, summer, autumn, winter",
        ),
        ("bears elm", "expected one of leaf, maple"),
        ("bears oak size", "expected"),
        ("bears oak size -1", "expected size as a number from"),
        ("bears oak size 0.1 in", "one of spring"),
        ("bears oak colour 3", "expected one of size"),
        ("widths wide", "`metres` or `da-vinci`"),
        ("widths da-vinci tip 0", "expected tip as a number"),
        ("season summer\nseason winter", "season"),
    ] {
        let error = Grammar::parse(&format!("axiom F\n{line}\n"), "t.lsys")
            .unwrap_err()
            .to_string();
        assert!(error.contains(told), "{line}: {error}");
        assert!(error.contains("t.lsys:"), "{error}");
    }
    let many = "axiom F\n".to_owned() + &"bears oak\n".repeat(17);
    assert!(
        Grammar::parse(&many, "t.lsys")
            .unwrap_err()
            .to_string()
            .contains("at most 16")
    );
}

#[test]
fn a_surface_of_the_grammars_own_is_borne_too() {
    let text = "surface K = [(0 0 0) (0.4 0.5 0) (0 1 0) (-0.4 0.5 0)]\nbears K size 0.3 tips\nsteps 0\naxiom F(2)\n";
    let grammar = Grammar::parse(text, "t.lsys").unwrap();
    let mut drawing = grown(&grammar, 0);
    grammar.finish(&mut drawing);
    let [leaf] = drawing.organs.placed[..] else {
        panic!("{:?}", drawing.organs.placed)
    };
    assert!((leaf.position.y - 2.0).abs() < 1e-5);
    let surface = &drawing.organs.surfaces[usize::from(leaf.surface)];
    assert_eq!(surface.positions.len(), 4);
}
