//! What the turtle draws besides the skeleton, as its canvas is told: outlines, spheres, placed shapes, colours, materials, cylinders.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::{DQuat, DVec3};
use ramus::lsystem::turtle::{Canvas, Cylinder, Drawn, Extent, Outline, Pen};
use ramus::lsystem::{DeriveError, DeriveProblem, TurtleParams, draw_on, interpret};
use ramus::tree::NO_PARENT;

use super::{derive, draw, parse};

/// Writes down what it is told.
#[derive(Default)]
struct Told {
    text: String,
    nodes: u32,
}

fn at(p: DVec3) -> String {
    // No negative zeros.
    let short = |x: f64| (x * 1e6).round() / 1e6 + 0.0;
    format!("({} {} {})", short(p.x), short(p.y), short(p.z))
}

fn ink(pen: &Pen) -> String {
    let cylinder = match pen.cylinder {
        Cylinder::None => String::new(),
        Cylinder::Begins => " begins".to_owned(),
        Cylinder::Of(first) => format!(" of {first}"),
    };
    match (pen.colour, pen.material) {
        (0, 0) => cylinder,
        (colour, material) => format!(" ink {colour}/{material}{cylinder}"),
    }
}

impl Told {
    fn line(&mut self, line: &str) {
        let _ = writeln!(self.text, "{line}");
    }
}

impl Canvas for Told {
    fn root(&mut self, pen: &Pen, _: Drawn, _: f32) -> Result<u32, DeriveError> {
        assert_eq!(pen.node, NO_PARENT, "only where there is no node");
        self.nodes += 1;
        self.line(&format!("root {} {}", self.nodes, at(pen.position)));
        Ok(self.nodes)
    }

    fn segment(&mut self, pen: &Pen, _: Drawn, end: DVec3, _: f32) -> Result<u32, DeriveError> {
        self.nodes += 1;
        let line = format!("{}-{} {}{}", pen.node, self.nodes, at(end), ink(pen));
        self.line(&line);
        Ok(self.nodes)
    }

    fn polygon(&mut self, pen: &Pen, by: Drawn, outline: Outline<'_>) -> Result<(), DeriveError> {
        let vertices: Vec<String> = outline.vertices.iter().map(|v| at(*v)).collect();
        let node = outline.node.cast_signed();
        let line = format!(
            "polygon {}{} at {node} module {}",
            vertices.join(" "),
            ink(pen),
            by.position
        );
        self.line(&line);
        Ok(())
    }

    fn sphere(&mut self, pen: &Pen, _: Drawn, radius: f64) -> Result<(), DeriveError> {
        self.line(&format!("sphere {} {radius}{}", at(pen.position), ink(pen)));
        Ok(())
    }

    fn surface(&mut self, pen: &Pen, _: Drawn, scale: f64) -> Result<(), DeriveError> {
        let frame = [pen.heading(), pen.left(), pen.up()].map(at).join(" ");
        let line = format!("surface {} {frame} {scale}{}", at(pen.position), ink(pen));
        self.line(&line);
        Ok(())
    }
}

fn told(text: &str) -> Result<String, DeriveError> {
    let grammar = parse(text);
    let string = derive(&grammar, 0);
    let (params, cancel) = (TurtleParams::default(), AtomicBool::new(false));
    draw_on(&grammar, &string, &params, &cancel, |_| Told::default()).map(|told| told.text)
}

#[test]
fn each_symbol_draws_what_the_language_says() {
    for (axiom, expected) in [
        // Outlines: F and f go to a vertex, G and g only move, `.` marks one; nothing else is drawn.
        (
            "{.F+F+F}",
            "polygon (0 0 0) (0 1 0) (-1 1 0) (-1 0 0) at 0 module 7\n",
        ),
        (
            "{F+F+F+F}",
            "polygon (0 1 0) (-1 1 0) (-1 0 0) (0 0 0) at 0 module 8\n",
        ),
        (
            "{.f+f+f+f}",
            "polygon (0 0 0) (0 1 0) (-1 1 0) (-1 0 0) at 0 module 9\n",
        ),
        (
            "{.G+G.+G.}",
            "polygon (0 0 0) (-1 1 0) (-1 0 0) at 0 module 9\n",
        ),
        (
            "{.g+g.+g.}",
            "polygon (0 0 0) (-1 1 0) (-1 0 0) at 0 module 9\n",
        ),
        (
            "{.F.+F..}",
            "polygon (0 0 0) (0 1 0) (-1 1 0) at 0 module 8\n",
        ),
        // Two vertices are no polygon; a vertex outside an outline is none.
        ("{.F}.F", "root 1 (0 1 0)\n1-2 (0 2 0)\n"),
        ("{}", ""),
        ("..", ""),
        // An outline across branches, as ABOP's leaves (section 5.1).
        (
            "[+F{.]F.-F.}F",
            "0-1 (-1 0 0)\npolygon (-1 0 0) (0 1 0) (1 1 0) at 1 module 11\nroot 2 (1 1 0)\n2-3 (2 1 0)\n",
        ),
        // The second side of ABOP's bush leaf lies in the first one's mirror image.
        (
            "{-(45)f+(45)f+(45)f-(45)|-(45)f+(45)f+(45)f}",
            "polygon (0.707107 0.707107 0) (0.707107 1.707107 0) (0 2.414214 0) (-0.707107 1.707107 0) (-0.707107 0.707107 0) (0 0 0) at 0 module 15\n",
        ),
        // Outlines in outlines.
        (
            "{.F[+{.F+F.}]+F+F}",
            "polygon (0 1 0) (-1 1 0) (-1 0 0) at -1 module 11\npolygon (0 0 0) (0 1 0) (-1 1 0) (-1 0 0) at 0 module 17\n",
        ),
        (
            "f(3){.F+F}",
            "polygon (0 3 0) (0 4 0) (-1 4 0) at -1 module 6\n",
        ),
        // Spheres: a radius, else half the width.
        ("!(3)@O(2)", "sphere (0 0 0) 2\n"),
        ("!(3)F@O", "0-1 (0 1 0)\nsphere (0 1 0) 1.5\n"),
        ("@O(-2)", "sphere (0 0 0) 2\n"),
        // Surfaces in the turtle's frame; it stays where it is.
        (
            "~L(2)F",
            "surface (0 0 0) (0 1 0) (-1 0 0) (0 0 1) 2\n0-1 (0 1 0)\n",
        ),
        (
            "F+~L",
            "0-1 (0 1 0)\nsurface (0 1 0) (-1 0 0) (0 -1 0) (0 0 1) 1\n",
        ),
        // Colours and materials: next, previous, given; brackets restore them.
        (
            "''F,F'(7)F,(3)F",
            "0-1 (0 1 0) ink 2/0\n1-2 (0 2 0) ink 1/0\n2-3 (0 3 0) ink 7/0\n3-4 (0 4 0) ink 3/0\n",
        ),
        (
            ";F;(9)F;F",
            "0-1 (0 1 0) ink 0/1\n1-2 (0 2 0) ink 0/9\n2-3 (0 3 0) ink 0/10\n",
        ),
        ("'[';F]F", "0-1 (0 1 0) ink 2/1\n0-2 (0 1 0) ink 1/0\n"),
        (
            ",F'(-4)F'(1e9)F'F",
            "0-1 (0 1 0)\n1-2 (0 2 0)\n2-3 (0 3 0) ink 65535/0\n3-4 (0 4 0) ink 65535/0\n",
        ),
        (
            "';(2){.F+F'}",
            "polygon (0 0 0) (0 1 0) (-1 1 0) ink 2/2 at 0 module 8\n",
        ),
        // Generalized cylinders: a branch is one of its own, and so is what follows a move.
        (
            "F@GsFF[+FF]F@GeF",
            "0-1 (0 1 0)\n1-2 (0 2 0) begins\n2-3 (0 3 0) of 2\n3-4 (-1 3 0) begins\n4-5 (-2 3 0) of 4\n3-6 (0 4 0) of 2\n6-7 (0 5 0)\n",
        ),
        (
            "@GsFfF@Gs[F]F",
            "0-1 (0 1 0) begins\nroot 2 (0 2 0)\n2-3 (0 3 0) begins\n3-4 (0 4 0) begins\n3-5 (0 4 0) begins\n",
        ),
    ] {
        let found = told(&format!("angle 90\naxiom {axiom}\n")).unwrap();
        assert_eq!(found, expected, "{axiom}");
    }
}

#[test]
fn a_shape_can_be_placed() {
    let shape = "shape A = [(0 1 0) (1 0 0)]\nangle 90\n";
    assert_eq!(
        told(&format!("{shape}axiom F+~A(2)F\n")).unwrap(),
        "0-1 (0 1 0)\n1-2 (-2 1 0)\n2-3 (-2 3 0)\n1-4 (-1 1 0)\n",
        "twice as large, ahead and then to the right; the turtle goes on from where it was"
    );
    let grammar = parse(&format!("{shape}axiom A~A\n"));
    assert_eq!(
        draw(&grammar, &derive(&grammar, 0)).letters,
        ["A"],
        "one letter"
    );
    assert_eq!(
        told(&format!("{shape}axiom {{.A(0)A(1)}}\n")).unwrap(),
        "polygon (0 0 0) (0 1 0) (1 1 0) at 0 module 4\n",
        "in an outline a shape's segments are edges"
    );
}

/// Each brace and each bracket of a string has its other half, unless `%` cut it off.
#[test]
fn outlines_that_are_cut_are_named() {
    let problem = |text: &str| {
        let grammar = parse(text);
        let (params, cancel) = (TurtleParams::default(), AtomicBool::new(false));
        let drawn = draw_on(&grammar, &derive(&grammar, 1), &params, &cancel, |_| {
            Extent::default()
        });
        *drawn.unwrap_err().problem
    };
    let open = problem("axiom F{.F A F}\nA -> %\n");
    assert!(
        matches!(open, DeriveProblem::OpenOutline { position: 1 }),
        "{open:?}"
    );
    let none = problem("axiom F[A {.]F}\nA -> %\n");
    assert!(
        matches!(none, DeriveProblem::NoOutline { position: 4 }),
        "{none:?}"
    );
}

/// Counting without a tree finds what the tree holds.
#[test]
fn extents_are_those_of_the_tree() {
    for (text, steps) in [
        (include_str!("../../assets/grammars/honda.lsys"), 8),
        (include_str!("../../assets/grammars/wild-bush.lsys"), 4),
        ("axiom f(3)F[+F]f F@O(3){.F+F.}f(100)\n", 0),
        ("axiom A\n", 0),
    ] {
        let grammar = parse(text);
        let string = derive(&grammar, steps);
        let (params, cancel) = (TurtleParams::default(), AtomicBool::new(false));
        let extent = draw_on(&grammar, &string, &params, &cancel, |_| Extent::default()).unwrap();
        let tree = draw(&grammar, &string);
        assert_eq!(extent.segments, tree.segment_count() as u64, "{text}");
        let ends = (0..tree.len())
            .filter(|i| tree.parent[*i] != NO_PARENT)
            .flat_map(|i| [tree.position[i], tree.position[tree.parent[i] as usize]]);
        let bounds = ends.fold(None, |bounds: Option<[glam::Vec3; 2]>, p| {
            let [min, max] = bounds.unwrap_or([p, p]);
            Some([min.min(p), max.max(p)])
        });
        assert_eq!(extent.bounds, bounds, "{text}");
    }
}

/// The frame stays a rotation however it is turned.
#[test]
fn frames_stay_rotations() {
    struct Frames;
    impl Canvas for Frames {
        fn root(&mut self, _: &Pen, _: Drawn, _: f32) -> Result<u32, DeriveError> {
            Ok(0)
        }
        fn segment(&mut self, pen: &Pen, _: Drawn, _: DVec3, _: f32) -> Result<u32, DeriveError> {
            let DQuat { x, y, z, w } = pen.frame;
            assert!(
                ((x * x + y * y + z * z + w * w).sqrt() - 1.0).abs() < 1e-14,
                "length 1"
            );
            let [h, l, u] = [pen.heading(), pen.left(), pen.up()];
            assert!((h.cross(l) - u).length() < 1e-14, "H × L = U");
            Ok(0)
        }
    }
    let turns = "F+(17.3)&(31.1)/(7.7)$F-(1e-9)\\(179.9)^(90)|F".repeat(5000);
    let grammar = parse(&format!("tropism 1 2 3\naxiom T(0.1){turns}\n"));
    let (params, cancel) = (TurtleParams::default(), AtomicBool::new(false));
    assert!(draw_on(&grammar, &derive(&grammar, 0), &params, &cancel, |_| Frames).is_ok());
}

/// Cancels the drawing at a segment, and counts on.
struct Cancels<'c> {
    cancel: &'c AtomicBool,
    drawn: &'c AtomicU64,
}

impl Canvas for Cancels<'_> {
    fn root(&mut self, _: &Pen, _: Drawn, _: f32) -> Result<u32, DeriveError> {
        Ok(0)
    }

    fn segment(&mut self, _: &Pen, _: Drawn, _: DVec3, _: f32) -> Result<u32, DeriveError> {
        let before = self.drawn.fetch_add(1, Ordering::Relaxed);
        self.cancel
            .fetch_or(before == CANCELLED_AT, Ordering::Relaxed);
        Ok(0)
    }
}

const CANCELLED_AT: u64 = 5_000;

#[test]
fn a_drawing_that_is_cancelled_soon_ends() {
    let grammar = parse("axiom F\nF -> F[+F]F\n");
    let string = derive(&grammar, 11);
    let (params, cancel, drawn) = (
        TurtleParams::default(),
        AtomicBool::new(false),
        AtomicU64::new(0),
    );
    let canvas = |_: &TurtleParams| Cancels {
        cancel: &cancel,
        drawn: &drawn,
    };
    let ended = draw_on(&grammar, &string, &params, &cancel, canvas).err();
    assert!(ended.is_some_and(|error| error.is_cancelled()));
    let more = drawn.into_inner() - CANCELLED_AT;
    // Some tens of microseconds.
    assert!(more < 1_100, "{more} segments after it was cancelled");
    // In parts beside each other, and on a canvas that takes everything.
    let cancelled = |ended: Option<DeriveError>| ended.is_some_and(|error| error.is_cancelled());
    assert!(cancelled(
        interpret(&grammar, &string, &params, &cancel).err()
    ));
    assert!(cancelled(
        ramus::lsystem::draw(&grammar, &string, &params, &cancel).err()
    ));
}
