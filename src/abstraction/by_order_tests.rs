//! Lengths, radii and angles by order: in tables, in grammars and in fits.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that fails shows the line"
)]
use std::sync::atomic::AtomicBool;

use super::*;
use crate::lsystem::{Grammar, Limits};
use crate::tree::Tree;
use crate::tree::measure::{Measures, OfOrder as Measured, spread};

/// A kind whose orders differ by no ratio.
fn uneven() -> Params {
    Params {
        bifurcation_probability: 1.0,
        iterations: 6.0,
        radial_increment: 0.0,
        segment_length: 2.0,
        segment_radius: 0.1,
        stem_length: 3,
        upwards_angle: 0.0,
        upwards_angle_std: 0.0,
        roll_range: 0,
        around: true,
        length_by_order: vec![0.5, 2.0, 0.25],
        radius_by_order: vec![4.0, 3.0, 0.5],
        angle_by_order: vec![9.0, 1.0, 2.0],
        seed: 3,
        ..Params::default()
    }
}

fn grown(params: &Params) -> Tree {
    grow(params, &Limits::default(), &AtomicBool::new(false)).unwrap()
}

fn by_order(params: &Params) -> Vec<Measured> {
    Measures::whole(&grown(params)).by_order
}

#[test]
fn orders_have_the_lengths_radii_and_angles_of_their_factors() {
    let params = uneven();
    let orders = by_order(&params);
    assert!(orders.len() >= 4);
    // Three segments of the stem; one of each branch; the last factor holds for what is beyond.
    for (order, long) in [(0, 3.0 * 2.0 * 0.5), (1, 2.0 * 2.0), (2, 0.5), (3, 0.5)] {
        assert!((orders[order].length.mean - long).abs() < 1e-5, "{order}");
    }
    for (order, pitch) in [(1, 17.5), (2, 35.0), (3, 35.0)] {
        let angle = orders[order].angle.mean.to_degrees();
        assert!((angle - 2.0 * pitch).abs() < 1e-2, "{order}: {angle}");
    }
    let tree = grown(&params);
    let thick: Vec<f32> = tree.radius.iter().copied().collect();
    for radius in [0.4, 0.3, 0.05] {
        assert!(
            thick.iter().any(|one| (one - radius).abs() < 1e-6),
            "{radius}"
        );
    }
    // What a person opens grows the same.
    let said = text(&params);
    assert!(said.contains("pick(f, 0.5, 2, 0.25)"), "{said}");
    assert!(said.contains("other, forks) a live tip"), "{said}");
    assert!(Grammar::parse(&said, "orders.lsys").is_ok());
    // None are as all of them 1.
    let plain = Params {
        length_by_order: vec![1.0; 5],
        radius_by_order: vec![1.0],
        angle_by_order: vec![1.0; 2],
        ..params.clone()
    };
    let none = Params {
        length_by_order: Vec::new(),
        radius_by_order: Vec::new(),
        angle_by_order: Vec::new(),
        ..params
    };
    assert_eq!(grown(&plain), grown(&none));
}

#[test]
fn orders_are_those_of_forks_also_where_tips_go_on_without_one() {
    // About half of the tips go on, so that branches have several segments.
    let params = Params {
        bifurcation_probability: 0.5,
        iterations: 14.0,
        length_by_order: vec![1.0, 4.0, 0.25, 2.0],
        ..uneven()
    };
    let measures = Measures::whole(&grown(&params));
    assert!(measures.by_order.len() >= 4);
    for branch in measures.branches.iter().filter(|one| one.order > 0) {
        let factors = [1.0, 4.0, 0.25, 2.0];
        let long = 2.0 * factors[(branch.order as usize).min(3)];
        let segments = branch.length / long;
        assert!((segments - segments.round()).abs() < 1e-4, "{segments}");
        assert!((1.0..=20.0).contains(&segments.round()), "{segments}");
        let nodes = branch.nodes.len() as f64;
        assert!(
            (segments - (nodes - 1.0)).abs() < 1e-4,
            "{segments} {nodes}"
        );
    }
    let several = measures.branches.iter().filter(|one| one.nodes.len() > 2);
    assert!(several.count() > 3);
}

#[test]
fn rows_of_nothing_are_not_compared() {
    let row = |mean| OfOrder {
        order: 0,
        branches: 1,
        branch_length: Some(MeanStd { mean, std: None }),
        bifurcation_angle_deg: Some(MeanStd { mean, std: None }),
        ..OfOrder::default()
    };
    let found = by_order::differences([&[row(0.0)], &[row(50.0)]]);
    assert_eq!(found.len(), 1, "an angle of nothing is one: {found:?}");
    assert!(found[0].difference.relative.is_finite());
    assert!(distance(&[], &found, 0.0).is_finite());
    assert!(by_order::differences([&[row(1.0)], &[row(f64::NAN)]]).is_empty());
}

#[test]
fn factors_beyond_their_limits_are_named() {
    for (factors, name) in [
        (vec![0.0], "length_by_order"),
        (vec![1.0, f64::NAN], "length_by_order"),
        (vec![1.0, -1.0], "length_by_order"),
        (vec![1.0; ORDERS_MOST + 1], "length_by_order"),
    ] {
        let wrong = Params {
            length_by_order: factors,
            ..Params::default()
        };
        let said = wrong.check().unwrap_err().to_string();
        assert!(said.contains(name), "{said}");
    }
    let most = Params {
        angle_by_order: vec![1.0; ORDERS_MOST],
        ..Params::default()
    };
    assert!(most.check().is_ok() && grown(&most).segment_count() > 0);
}

#[test]
fn tables_say_what_orders_are_like_or_nothing() {
    let table = |rows: &str| {
        let text = format!(
            r#"{{"format": "ramus-table/1", "counts": {{"centerlines": 3}}, "table": {{"branch_length": {{"mean": 2}}}}, "orders": {{"strahler": [1], "centrifugal": {rows}}}}}"#
        );
        Table::read(&text)
    };
    let good = table(r#"[{"order": 0, "branches": 1, "branch_length": {"mean": 3}}, {"order": 1, "branches": 2, "bifurcation_angle_deg": {"mean": 40, "std": 2}}]"#).unwrap();
    assert_eq!(good.orders.centrifugal.len(), 2);
    assert_eq!(good.orders.centrifugal[1].point_radius, None);
    assert!(table("[]").unwrap().orders.centrifugal.is_empty());
    for (rows, why) in [
        (r#"[{"order": 1, "branches": 1}]"#, "orders 0, 1, 2"),
        (
            r#"[{"order": 0, "branches": 1, "point_radius": {"mean": -1}}]"#,
            "from 0 to",
        ),
        (r#"[{"order": 0}]"#, "branches"),
        (r#"[{"order": 0, "branches": -1}]"#, "no table"),
        (
            r#"[{"order": 0, "branches": 18446744073709551615}]"#,
            "at most",
        ),
        (
            r#"[{"order": 0, "branches": 1, "branch_length": {"mean": 1e300}}]"#,
            "from 0 to",
        ),
        ("7", "no table"),
    ] {
        let said = table(rows).unwrap_err().to_string();
        assert!(said.contains(why), "{rows}: {said}");
    }
}

#[test]
fn branches_in_other_orders_are_counted() {
    let rows = |counts: &[usize]| -> Vec<OfOrder> {
        let row = |(order, branches): (u32, &usize)| OfOrder {
            order,
            branches: *branches,
            ..OfOrder::default()
        };
        (0..).zip(counts).map(row).collect()
    };
    for (target, got, part) in [
        (vec![1, 2, 4], vec![1, 2, 4], 0.0),
        (vec![1, 2, 2], vec![1, 4], 0.4),
        (vec![1, 2], vec![1, 2, 3], 0.5),
        (vec![], vec![1, 2], 0.0),
    ] {
        let found = by_order::misplaced([&rows(&target), &rows(&got)]);
        assert!((found - part).abs() < 1e-12, "{target:?} {got:?}: {found}");
    }
}

#[test]
fn a_fit_has_the_orders_of_the_model() {
    // A stem, two long thick branches, and many short thin ones: no ratio from order to order says that.
    let model = Params {
        roll_range: 20,
        segment_length_std: 0.3,
        bifurcation_angle_std: 4.0,
        ..uneven()
    };
    let target = Table::of(&Measures::whole(&grown(&model)));
    let fitted = |target: &Table| {
        let params = FitParams {
            candidates: 3000,
            ..FitParams::default()
        };
        let fit = fit(target, &params, &AtomicBool::new(false), &mut |_, _, _| {}).unwrap();
        fit.ranked.into_iter().next().unwrap()
    };
    let best = fitted(&target);
    assert_eq!(
        best.matching(),
        best.differences.len(),
        "{:?}",
        best.differences
    );
    let orders = target.orders.centrifugal.len();
    assert_eq!(best.params.length_by_order.len(), orders);
    let off: Vec<_> = best
        .by_order
        .iter()
        .filter(|one| !one.difference.matches())
        .collect();
    assert!(10 * off.len() <= best.by_order.len(), "{off:?}");
    // Without the rows of orders the same model gets none of its own, and is farther from them.
    let plain = fitted(&Table {
        orders: Orders::default(),
        ..target.clone()
    });
    assert!(plain.params.length_by_order.is_empty() && plain.by_order.is_empty());
    let rows = |one: &Candidate| Table::of(&Measures::whole(&grown(&one.params))).orders;
    let far = |one: &Candidate| -> f64 {
        let rows = [target.orders.centrifugal.clone(), rows(one).centrifugal];
        let all = by_order::differences([&rows[0], &rows[1]]);
        all.iter().map(|one| one.difference.relative.abs()).sum()
    };
    assert!(
        far(&best) < 0.5 * far(&plain),
        "{} {}",
        far(&best),
        far(&plain)
    );
}

#[test]
fn orders_of_a_group_are_those_of_its_models_together() {
    let mean = |mean| {
        Some(MeanStd {
            mean,
            std: Some(0.0),
        })
    };
    let row = |order, branches, long, thick| OfOrder {
        order,
        branches,
        branch_length: mean(long),
        point_radius: mean(thick),
        bifurcation_angle_deg: None,
    };
    let part = |rows: Vec<OfOrder>| Part {
        centerlines: 2,
        junctions: 1,
        branches: 3,
        total_length: 1.0,
        branch_length: spread([1.0]),
        point_radius: spread([1.0]),
        centerline_length: spread([2.0]),
        by_order: rows,
        ..Part::default()
    };
    let parts = [
        part(vec![row(0, 1, 4.0, 1.0), row(1, 2, 1.0, 2.0)]),
        part(vec![row(0, 1, 8.0, 3.0)]),
    ];
    let rows = pooled(&parts).unwrap().orders.centrifugal;
    assert_eq!(rows.len(), 2);
    let of = |row: &OfOrder| [row.branch_length, row.point_radius].map(|one| one.unwrap().mean);
    assert_eq!(of(&rows[0]), [6.0, (4.0 * 1.0 + 8.0 * 3.0) / 12.0]);
    assert_eq!(rows[0].branch_length.unwrap().std, Some(2.0));
    assert_eq!((rows[1].branches, of(&rows[1])), (1, [1.0, 2.0]));
    assert_eq!(rows[1].bifurcation_angle_deg, None);
}
