//! Paths of a hand: sampled, smoothed and simplified, sound or hostile.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a test that fails shows the line; numbers are small"
)]
use proptest::prelude::*;

use super::*;
use crate::sketch::{NodeRef, Sketch, Symmetry};

/// An arc of 0.6 m about a metre up, looked at `looks` times.
fn arc(looks: u16) -> impl Iterator<Item = Vec3> {
    (0..=looks).map(move |n| {
        let angle = 2.0 * f32::from(n) / f32::from(looks);
        Vec3::new(0.6 - 0.6 * angle.cos(), 0.6 * angle.sin(), 0.1 * angle)
    })
}

fn raw() -> FreehandParams {
    FreehandParams {
        smoothing: 0.0,
        ..FreehandParams::default()
    }
}

fn nodes(spans: &Spans) -> Vec<Vec3> {
    let root = NodeRef::ROOT;
    let (sketch, _) = Sketch::default()
        .draw_curve(root, &spans.through, &spans.segments, Symmetry::OFF)
        .unwrap();
    sketch.strokes[0].points.clone()
}

#[test]
fn a_line_is_one_span_with_nodes_at_the_spacing() {
    for looks in [1, 7, 300] {
        let line = (0..=looks).map(|n| Vec3::Y * 1.6 * (n as f32 / looks as f32));
        let spans = fit(line, &FreehandParams::default());
        assert_eq!(spans.segments.iter().sum::<u32>(), 10, "{looks}");
        assert_eq!(spans.through.last(), Some(&(Vec3::Y * 1.6)));
        for (n, node) in (1_u8..).zip(nodes(&spans)) {
            assert!(
                node.distance(Vec3::Y * 0.16 * f32::from(n)) < 2e-3,
                "{node}"
            );
        }
    }
}

#[test]
fn how_often_the_hand_is_looked_at_changes_little() {
    let params = FreehandParams::default();
    let [rare, often] = [72, 144].map(|looks| nodes(&fit(arc(looks), &params)));
    assert_eq!(rare.len(), often.len());
    for (a, b) in rare.iter().zip(&often) {
        assert!(a.distance(*b) < 0.01, "{a} {b}");
    }
}

#[test]
fn a_hand_that_trembles_in_place_draws_nothing() {
    let still = (0..10_000).map(|n| Vec3::new(0.003 * (n % 2) as f32, 0.0, 0.002 * (n % 3) as f32));
    let mut freehand = Freehand::default();
    still.for_each(|place| {
        freehand.push(place);
    });
    assert!(freehand.samples.len() < 3 && freehand.spans().through.len() < 2);
}

#[test]
fn smoothing_takes_the_trembling_away_and_keeps_the_ends() {
    let shaky: Vec<Vec3> = (0..=200_u8)
        .map(|n| {
            let aside = if n % 200 == 0 {
                0.0
            } else {
                0.01 * (f32::from(n) * 1.9).sin()
            };
            Vec3::new(aside, 0.01 * f32::from(n), 0.0)
        })
        .collect();
    let widest = |smoothing| {
        let params = FreehandParams {
            smoothing,
            tolerance: 0.001,
            ..FreehandParams::default()
        };
        let spans = fit(shaky.iter().copied(), &params);
        assert_eq!(spans.through.last(), shaky.last());
        // Towards the ends there are fewer neighbours to smooth with.
        let middle = spans.through.iter().filter(|at| (0.2..1.8).contains(&at.y));
        middle.map(|at| at.x.abs()).fold(0.0, f32::max)
    };
    let [none, half, full] = [0.0, 0.5, 1.0].map(widest);
    assert!(
        none > 0.006 && half < 0.6 * none && full < 0.6 * half,
        "{none} {half} {full}"
    );
}

#[test]
fn strength_none_changes_nothing() {
    let path: Vec<Vec3> = arc(50).collect();
    for (index, place) in path.iter().enumerate() {
        assert_eq!(smoothed(&path, index, 0), Some(*place));
    }
    assert_eq!(smoothed(&path, path.len(), 3), None);
    assert_eq!(
        (smoothed(&path, 0, 9), smoothed(&path, 50, 9)),
        (Some(path[0]), Some(path[50]))
    );
}

#[test]
fn degenerate_paths_are_nothing_or_short() {
    let (nan, far) = (Vec3::NAN, Vec3::splat(1e30));
    for path in [
        vec![],
        vec![Vec3::ONE],
        vec![nan, Vec3::INFINITY, far],
        vec![Vec3::ONE; 1000],
        vec![Vec3::ONE, nan, Vec3::ONE, far, Vec3::ONE],
    ] {
        assert_eq!(
            fit(path.iter().copied(), &raw()),
            Spans::default(),
            "{path:?}"
        );
    }
    assert_eq!(simplify(&[], 0.1), Vec::<usize>::new());
    assert_eq!(simplify(&[Vec3::ONE], 0.1), [0]);
    assert_eq!(simplify(&[Vec3::ONE; 5], 0.1), [0, 4]);
    assert_eq!(simplify(&[Vec3::X, nan, Vec3::Y], 0.1), [0, 2]);
}

#[test]
fn a_million_places_take_bounded_memory_and_time() {
    let params = FreehandParams {
        nodes: u32::MAX,
        spacing: 0.02,
        ..raw()
    };
    let mut freehand = Freehand::new(params);
    let (mut most, mut pushed) = (0, 0);
    // A coil on the spot: each part as curved as the others.
    for n in 0..1_000_000_u32 {
        let angle = n as f32 * 0.02;
        pushed += u32::from(freehand.push(Vec3::new(angle.cos(), 0.0002 * n as f32, angle.sin())));
        most = most.max(freehand.tail.len() + freehand.samples.len());
    }
    assert!(most < 4 * WINDOW, "{most}");
    assert!(freehand.is_full() && pushed < 1_000_000);
    let spans = freehand.spans();
    assert_eq!(spans.segments.iter().sum::<u32>(), 2_000);
}

#[test]
fn what_is_settled_stays() {
    let mut freehand = Freehand::new(raw());
    let mut before = Vec::new();
    for place in
        arc(200).chain((0..2000_u16).map(|n| Vec3::new(0.85, 0.5 + 0.01 * f32::from(n), 0.2)))
    {
        freehand.push(place);
        let settled = &freehand.settled.through;
        assert_eq!(settled[..before.len()], before);
        before.clone_from(settled);
    }
    assert!(before.len() > 8);
}

#[test]
fn a_jump_is_a_line() {
    let mut freehand = Freehand::new(raw());
    freehand.push(Vec3::ZERO);
    freehand.push(Vec3::Y * 200.0);
    assert!(freehand.tail.len() + freehand.samples.len() < 3 * WINDOW);
    let spans = freehand.spans();
    assert!(spans.through.iter().all(|at| at.x == 0.0 && at.z == 0.0));
    assert!(spans.through.last().unwrap().distance(Vec3::Y * 200.0) < 1e-3);
}

#[test]
fn places_near_the_plane_are_drawn_onto_it() {
    let params = FreehandParams {
        snap: 0.05,
        ..raw()
    };
    let wavy =
        (0..200_u8).map(|n| Vec3::new(0.04 * (f32::from(n) * 0.1).sin(), 0.01 * f32::from(n), 0.0));
    assert!(nodes(&fit(wavy, &params)).iter().all(|node| node.x == 0.0));
}

#[test]
fn absurd_settings_are_brought_to_sense() {
    let absurd = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e30, f32::MIN_POSITIVE];
    for value in absurd {
        let params = FreehandParams {
            sample: value,
            spacing: value,
            tolerance: value,
            smoothing: value,
            reach: value,
            snap: value,
            nodes: 0,
        };
        let spans = fit(arc(72), &params);
        assert!(spans.segments.iter().sum::<u32>() <= 1, "{value}");
    }
}

fn path() -> impl Strategy<Value = Vec<Vec3>> {
    let step = prop_oneof![
        12 => prop::array::uniform3(-0.03_f32..0.03),
        2 => prop::array::uniform3(-0.8_f32..0.8),
        1 => Just([0.0; 3]),
        1 => prop::array::uniform3(any::<f32>()),
    ];
    prop::collection::vec(step, 0..400).prop_map(|steps| {
        let mut at = Vec3::ZERO;
        let places = steps.into_iter().map(|step| {
            let next = at + Vec3::from(step);
            if next.is_finite() && next.length() < 500.0 {
                at = next;
            }
            next
        });
        std::iter::once(Vec3::ZERO).chain(places).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_point_is_within_the_tolerance(path in path(), tolerance in 0.0_f32..0.2) {
        let finite: Vec<Vec3> = path.into_iter().filter(|at| at.abs().max_element() < 1e3).collect();
        let kept = simplify(&finite, tolerance);
        prop_assert!(kept.windows(2).all(|pair| pair[0] < pair[1]));
        let last = finite.len().checked_sub(1);
        prop_assert_eq!((kept.first().copied(), kept.last().copied()), (last.map(|_| 0), last));
        for pair in kept.windows(2) {
            for &point in &finite[pair[0]..=pair[1]] {
                let distance = from_line(point, finite[pair[0]], finite[pair[1]]);
                prop_assert!(distance <= f64::from(tolerance) + 1e-9);
            }
        }
    }

    #[test]
    fn any_path_can_be_drawn(path in path(), smoothing in 0.0_f32..1.0, fine in any::<bool>()) {
        let mut params = FreehandParams { smoothing, ..FreehandParams::default() };
        if fine {
            (params.sample, params.spacing, params.tolerance) = (0.0, 0.0, 0.0);
        }
        let spans = fit(path, &params);
        prop_assert_eq!(spans.through.len(), spans.segments.len());
        if !spans.through.is_empty() {
            let drawn = nodes(&spans);
            let mut end = 0;
            for (place, count) in spans.through.iter().zip(&spans.segments) {
                end += *count as usize;
                prop_assert_eq!(drawn[end - 1], crate::sketch::point(*place), "it goes through its handles");
            }
            prop_assert_eq!(drawn.len(), end);
        }
    }
}
