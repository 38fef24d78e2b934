//! Curves through handles: where their nodes lie, and what moving, deleting and drawing on does to them.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a test that fails shows the line; numbers are small"
)]
use proptest::prelude::*;

use super::*;
use crate::sketch::{Letter, NodeRef, Sketch, SketchError, Symmetry};

/// Five handles of a wave, four segments to each.
fn wave() -> (Vec<Vec3>, Vec<u32>) {
    let through = (1..=5_u8).map(|n| {
        let aside = if n % 2 == 0 { -0.2 } else { 0.2 };
        Vec3::new(aside, 0.4 * f32::from(n), 0.05 * f32::from(n))
    });
    (through.collect(), vec![4; 5])
}

fn drawn() -> Sketch {
    let (through, segments) = wave();
    let (sketch, apex) = Sketch::default()
        .draw_curve(NodeRef::ROOT, &through, &segments, Symmetry::OFF)
        .unwrap();
    assert_eq!(apex, a(20));
    sketch
}

fn a(node: u32) -> NodeRef {
    NodeRef::new(Letter::TRUNK, node)
}

fn trunk(sketch: &Sketch) -> &Stroke {
    &sketch.strokes[0]
}

#[test]
fn the_curve_goes_through_its_handles_at_even_steps() {
    let sketch = drawn();
    let stroke = trunk(&sketch);
    assert_eq!(stroke.handles, [4, 8, 12, 16, 20]);
    for (handle, place) in stroke.handles.iter().zip(wave().0) {
        assert_eq!(stroke.offset(*handle), Some(place));
    }
    for span in 0..5_u32 {
        let places: Vec<Vec3> = (4 * span..=4 * span + 4)
            .map(|node| stroke.offset(node).unwrap())
            .collect();
        let steps: Vec<f32> = places
            .windows(2)
            .map(|pair| pair[0].distance(pair[1]))
            .collect();
        let (least, most) = steps
            .iter()
            .fold((f32::MAX, 0.0_f32), |(a, b), &s| (a.min(s), b.max(s)));
        assert!(most / least < 1.06, "span {span}: {steps:?}");
    }
}

#[test]
fn the_curve_has_no_corner_at_its_handles() {
    let through = wave().0;
    let (sketch, _) = Sketch::default()
        .draw_curve(NodeRef::ROOT, &through, &[40; 5], Symmetry::OFF)
        .unwrap();
    let stroke = trunk(&sketch);
    let heading = |node: u32| stroke.offset(node + 1).unwrap() - stroke.offset(node).unwrap();
    let turns = (0..199).map(|node| heading(node).angle_between(heading(node + 1)));
    let sharpest = turns.fold(0.0, f32::max);
    let corner = (through[1] - through[0]).angle_between(through[2] - through[1]);
    assert!(sharpest < 0.3 * corner, "{sharpest} of {corner}");
}

#[test]
fn a_straight_row_of_handles_is_a_line() {
    let through = [Vec3::Y * 0.3, Vec3::Y * 0.4, Vec3::Y * 1.0];
    let (sketch, _) = Sketch::default()
        .draw_curve(NodeRef::ROOT, &through, &[3, 1, 6], Symmetry::OFF)
        .unwrap();
    for (n, point) in (1_u8..).zip(&trunk(&sketch).points) {
        assert!(
            point.distance(Vec3::Y * 0.1 * f32::from(n)) < 2e-4,
            "{point}"
        );
    }
}

#[test]
fn a_handle_that_moves_takes_two_spans_to_either_side_along() {
    let before = drawn();
    let to = Vec3::new(-0.5, 0.8, 0.4);
    let after = before.move_node(a(8), to).unwrap();
    let (old, new) = (trunk(&before), trunk(&after));
    assert_eq!(
        (new.points.len(), &new.handles),
        (20, &old.handles),
        "nodes stay as many"
    );
    assert_eq!(new.offset(8), Some(to));
    for node in 1..=20 {
        let moved = old.offset(node) != new.offset(node);
        let is_handle = node % 4 == 0;
        let expected = if is_handle { node == 8 } else { node < 16 };
        assert_eq!(moved, expected, "node {node}");
    }
    let back = after.move_node(a(8), wave().0[1]).unwrap();
    assert_eq!(back, before, "and back is back");
}

#[test]
fn a_node_between_becomes_a_handle_when_it_is_moved() {
    let before = drawn();
    assert!(!trunk(&before).is_handle(10) && trunk(&before).is_handle(12));
    let to = before.position(a(10)).unwrap() + Vec3::X * 0.1;
    let after = before.move_node(a(10), to).unwrap();
    assert_eq!(trunk(&after).handles, [4, 8, 10, 12, 16, 20]);
    for handle in [4, 8, 12, 16, 20] {
        assert_eq!(after.position(a(handle)), before.position(a(handle)));
    }
    assert_eq!(after.position(a(10)), Some(to));
    assert_eq!(
        trunk(&after).points[16..],
        trunk(&before).points[16..],
        "local"
    );
    after.validate().unwrap();
}

#[test]
fn attachments_and_branches_stay_on_their_nodes() {
    let (sketch, branch) = drawn().add_segment(a(6), Vec3::new(0.5, 1.0, 0.0)).unwrap();
    let own = sketch.position(branch).unwrap() - sketch.position(a(6)).unwrap();
    let moved = sketch.move_node(a(8), Vec3::new(-0.4, 0.8, 0.0)).unwrap();
    assert_ne!(moved.position(a(6)), sketch.position(a(6)));
    let carried = moved.position(branch).unwrap() - moved.position(a(6)).unwrap();
    assert!(carried.distance(own) < 1e-6);
}

#[test]
fn deleting_cuts_the_handles_too() {
    for (at, handles) in [
        (9, vec![4, 8]),
        (8, vec![4, 7]),
        (5, vec![4]),
        (3, vec![2]),
        (2, vec![]),
        (1, vec![]),
    ] {
        let (sketch, end) = drawn().delete_node(a(at)).unwrap();
        sketch.validate().unwrap();
        assert_eq!(trunk(&sketch).points.len() as u32, at - 1);
        assert_eq!(
            (end, &trunk(&sketch).handles),
            (a(at - 1), &handles),
            "{at}"
        );
    }
}

#[test]
fn drawing_on_adds_handles_and_moves_nothing() {
    let sketch = drawn();
    let (on, apex) = sketch.add_segment(a(20), Vec3::new(0.0, 2.3, 0.0)).unwrap();
    assert_eq!(trunk(&on).handles, [4, 8, 12, 16, 20, 21]);
    assert_eq!(trunk(&on).points[..20], trunk(&sketch).points);
    let further = [Vec3::new(0.1, 2.6, 0.0)];
    let (on, _) = on.draw_curve(apex, &further, &[3], Symmetry::OFF).unwrap();
    assert_eq!(trunk(&on).handles, [4, 8, 12, 16, 20, 21, 24]);
    assert_eq!(trunk(&on).points[..20], trunk(&sketch).points);
}

#[test]
fn a_polyline_that_goes_on_as_a_curve_keeps_its_nodes_as_handles() {
    let up = [Vec3::Y * 0.3, Vec3::new(0.1, 0.6, 0.0)];
    let (plain, apex) = Sketch::default().add_segments(NodeRef::ROOT, &up).unwrap();
    let (sketch, _) = plain
        .draw_curve(apex, &[Vec3::new(0.5, 0.9, 0.0)], &[4], Symmetry::OFF)
        .unwrap();
    assert_eq!(trunk(&sketch).handles, [1, 2, 6]);
    assert_eq!(trunk(&sketch).points[..2], up);
    // It leaves the polyline in its direction, between the two chords.
    let first = trunk(&sketch).points[2] - up[1];
    let chords = [up[1] - up[0], Vec3::new(0.4, 0.3, 0.0)];
    assert!(
        first.angle_between(chords[1]) > 0.05
            && first.angle_between(chords[0]) < chords[0].angle_between(chords[1])
    );
}

#[test]
fn a_curve_of_single_segments_is_a_polyline() {
    let through = wave().0;
    let (curve, _) = Sketch::default()
        .draw_curve(NodeRef::ROOT, &through, &[1; 5], Symmetry::OFF)
        .unwrap();
    let (plain, _) = Sketch::default()
        .add_segments(NodeRef::ROOT, &through)
        .unwrap();
    assert_eq!(curve, plain);
}

#[test]
fn what_cannot_be_a_curve_is_refused() {
    let (through, segments) = wave();
    let draw = |through: &[Vec3], segments: &[u32]| {
        let error = Sketch::default().draw_curve(NodeRef::ROOT, through, segments, Symmetry::OFF);
        error.unwrap_err()
    };
    assert_eq!(draw(&[], &[]), SketchError::Spans);
    assert_eq!(draw(&through, &segments[1..]), SketchError::Spans);
    assert_eq!(draw(&through, &[1, 0, 1, 1, 1]), SketchError::Spans);
    let many = SketchError::TooMany {
        what: "nodes",
        most: 100_000,
    };
    assert_eq!(draw(&through, &[u32::MAX; 5]), many);
    assert_eq!(draw(&through, &[100_000, 1, 1, 1, 1]), many);
    let short = draw(&[Vec3::Y * 0.01], &[100]);
    assert!(matches!(short, SketchError::TooShort(..)), "{short}");
    for bad in [Vec3::NAN, Vec3::INFINITY] {
        assert!(matches!(draw(&[bad], &[3]), SketchError::NotFinite(_)));
    }
    assert!(matches!(
        draw(&[Vec3::splat(2000.0)], &[3]),
        SketchError::OutOfBounds { .. }
    ));
}

#[test]
fn handles_that_are_none_are_found() {
    for handles in [
        vec![0, 20],
        vec![4, 4, 20],
        vec![8, 4, 20],
        vec![4, 19],
        vec![21],
        (1..=20).collect(),
    ] {
        let mut sketch = drawn();
        std::sync::Arc::make_mut(&mut sketch.strokes[0]).handles = handles.clone();
        assert_eq!(
            sketch.validate(),
            Err(SketchError::Handles(Letter::TRUNK)),
            "{handles:?}"
        );
    }
}

proptest! {
    #[test]
    fn any_move_keeps_handles_and_numbers(moves in prop::collection::vec((1..=20_u32, prop::array::uniform3(-2.0_f32..2.0)), 1..20)) {
        let mut sketch = drawn();
        for (node, to) in moves {
            let before = sketch.clone();
            let Ok(after) = sketch.move_node(a(node), Vec3::from(to)) else { continue };
            sketch = after;
            let (old, new) = (trunk(&before), trunk(&sketch));
            prop_assert_eq!(new.points.len(), 20);
            for &handle in old.handles.iter().filter(|&&handle| handle != node) {
                prop_assert_eq!(old.offset(handle), new.offset(handle));
            }
            prop_assert!(new.points.iter().all(|&point| quantize::point(point) == point));
            sketch.validate().unwrap();
        }
    }
}
