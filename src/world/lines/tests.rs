//! Lines of a small tree that is known.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]
use super::*;
use crate::centerline::analysis::ModelFacts;
use crate::mesh::made;
use crate::tree::Node;

/// A stem of 2 that forks in two, one of 1 and one of 3 that forks again into 4 and 1; radii 1 in the stem, then 0.5.
pub(crate) fn tree() -> Tree {
    let mut tree = Tree {
        letters: vec!["centerline".to_owned()],
        ..Tree::default()
    };
    for (parent, x, y, radius) in [
        (NO_PARENT, 0.0, 0.0, 1.0),
        (0, 0.0, 1.0, 1.0),
        (1, 0.0, 2.0, 1.0),
        (2, -1.0, 2.0, 0.5),
        (2, 3.0, 2.0, 0.5),
        (4, 3.0, 6.0, 0.5),
        (4, 3.0, 1.0, 0.25),
    ] {
        tree.push(Node {
            parent,
            position: Vec3::new(x, y, 0.0),
            radius,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    tree
}

fn lines() -> Lines {
    let centerline = Centerline {
        tree: tree(),
        origin: glam::DVec3::new(100.0, 0.0, 0.0),
        ..Centerline::default()
    };
    let analysis = Analysis::new(ModelFacts::default(), &centerline, false, 0);
    let never = AtomicBool::new(false);
    let mut mesh = made::placed(made::sphere(1), 10.0, Vec3::ZERO);
    mesh.origin = glam::DVec3::new(98.0, 0.0, 0.0);
    let model = Display::new(Arc::new(mesh), None, &never).unwrap();
    let stop = AtomicBool::new(true);
    let stopped = Lines::new(
        centerline.clone(),
        analysis.clone(),
        Vec::new(),
        &model,
        &stop,
    );
    assert!(stopped.is_none());
    Lines::new(centerline, analysis, Vec::new(), &model, &never).unwrap()
}

fn branch(lines: &Lines, length: f64) -> usize {
    let mut all = lines.analysis.branches.iter();
    all.position(|one| (one.length - length).abs() < 1e-6)
        .unwrap()
}

#[test]
fn branches_have_their_nodes_and_lie_where_the_model_does() {
    let lines = lines();
    assert_eq!(lines.len(), 5);
    assert_eq!(lines.nodes_of(branch(&lines, 2.0)), [0, 1, 2]);
    assert_eq!(lines.nodes_of(branch(&lines, 4.0)), [4, 5]);
    assert!(lines.nodes_of(99).is_empty());
    // Two units aside of where the mesh counts from, and thinner than the balls.
    let (place, thick) = lines.place(1).unwrap();
    assert!(place.distance(Vec3::new(2.0, 1.0, 0.0)) < 1e-6);
    assert!((thick - 0.1).abs() < 1e-3, "{thick}");
    assert!(lines.place(7).is_none());
    for one in 0..lines.len() {
        let (centre, far) = lines.around(one).unwrap();
        for node in lines.nodes_of(one) {
            assert!(lines.place(*node).unwrap().0.distance(centre) <= far + 1e-6);
        }
    }
}

#[test]
fn what_is_drawn_lies_on_the_line_and_has_its_colours() {
    let lines = lines();
    let plain = lines.shaded(None);
    assert!(!plain.display.has_colours() && plain.range.is_none());
    let mesh = &plain.display.mesh;
    assert_eq!(mesh.positions.len(), lines.vertices.len());
    for (at, [of, node]) in mesh.positions.iter().zip(&lines.vertices) {
        let (place, thick) = lines.place(*node).unwrap();
        assert!(at.distance(place) <= thick * SPHERE + 1e-5, "{at}");
        assert!(lines.nodes_of(*of as usize).contains(node));
    }
    for by in Quantity::ALL {
        let shading = lines.shaded(Some(by));
        assert!(
            Arc::ptr_eq(&shading.display.levels, &plain.display.levels),
            "only colours are uploaded anew"
        );
        let colours = &shading.display.vertex_colours;
        assert_eq!(colours.len(), mesh.positions.len(), "{by:?}");
        if let Some([low, high]) = shading.range {
            let ramp = by.ramp();
            for (colour, [of, node]) in colours.iter().zip(&lines.vertices) {
                let facts = &lines.analysis.branches[*of as usize];
                let number = match by {
                    Quantity::RadiusHere => f64::from(lines.radius(*node)),
                    by => by.of(facts),
                };
                let part = (number - f64::from(low)) / f64::from(high - low);
                let part = if high > low { part } else { 0.5 + 0.0 * number };
                #[expect(clippy::cast_possible_truncation, reason = "a colour")]
                let expected = ramp.colour(part as f32).map(i32::from);
                let found = colour.map(i32::from);
                let off = (0..3).map(|n| (expected[n] - found[n]).abs()).max();
                assert!(off <= Some(1), "{by:?} {number} {found:?} {expected:?}");
            }
        }
    }
    // All branches here are straight: no torsion.
    assert!(lines.shaded(Some(Quantity::Torsion)).range.is_none());
    assert_eq!(lines.shaded(Some(Quantity::Length)).range, Some([1.0, 4.0]));
}

#[test]
fn the_way_through_a_branch_leads_from_the_root_to_the_farthest_tip() {
    let lines = lines();
    let way = |length: f64| lines.path_through(branch(&lines, length));
    let (path, within) = way(2.0);
    let lengths: Vec<f64> = path.iter().map(|[length, _]| *length).collect();
    assert_eq!(lengths, [0.0, 1.0, 2.0, 5.0, 9.0], "on to the farthest");
    assert_eq!(within, 0..3);
    let (path, within) = way(4.0);
    assert_eq!((path.len(), within), (5, 3..5));
    assert_eq!(path[4], [9.0, 0.5]);
    // The first branch of length 1 from the fork at the stem's end.
    let one = lines.analysis.branches.iter();
    let short = one.clone().filter(|one| (one.length - 1.0).abs() < 1e-6);
    let ends: Vec<f64> = short
        .map(|one| lines.path_through(one.id).0.last().unwrap()[0])
        .collect();
    assert_eq!(ends, [3.0, 6.0]);
    assert!(lines.path_through(99).0.is_empty());
}

#[test]
fn balls_stand_at_forks_and_ends_and_touch_between() {
    let lines = lines();
    let near = lines.strung(BALLS_APART);
    for node in [0, 2, 3, 4, 5, 6] {
        let (place, _) = lines.place(node).unwrap();
        let ball = place.extend(lines.radius(node));
        assert!(near.iter().any(|one| one.distance(ball) < 1e-6), "{node}");
    }
    assert!(lines.strung(1e9).len() == 6 && near.len() <= 7);
    // Its surface is outside, and round.
    let ball = sphere();
    let volume: f32 = ball
        .triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| ball.positions[corner as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum();
    assert!((3.8..4.19).contains(&volume), "{volume}");
}

#[test]
fn scales_hold_all_numbers() {
    for (numbers, ramp, expected) in [
        (&[][..], Ramp::Rising, None),
        (&[f32::NAN][..], Ramp::AboutZero, None),
        (&[2.0, 1.0, f32::NAN][..], Ramp::Rising, Some([1.0, 2.0])),
        (&[-2.0, 1.0][..], Ramp::AboutZero, Some([-2.0, 2.0])),
        (&[3.0][..], Ramp::Rising, Some([3.0, 3.0])),
    ] {
        assert_eq!(range(numbers, ramp), expected, "{numbers:?}");
    }
    let (same, _) = colours(&[3.0, 3.0, f32::NAN], Ramp::Rising);
    assert_eq!(same[0], Ramp::Rising.colour(0.5));
    assert_eq!(same[2], Ramp::Rising.colour(f32::NAN));
}
