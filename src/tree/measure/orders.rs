//! Orders of branches: by generation, Strahler's and Horsfield's, and how numbers, lengths and radii go from one to the next.

use serde::Serialize;

use super::branch::Branch;

/// The branches of one of Strahler's orders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Order {
    /// Which, from 1.
    #[serde(rename = "order")]
    pub strahler: u32,
    /// How many branches it has.
    pub branches: usize,
    /// Their mean length.
    pub length: f64,
    /// Their mean radius.
    pub radius: f64,
}

/// By how much one order differs from the next: the slope of the logarithm over the orders, as Horton has it. None with fewer than two orders.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ratios {
    /// Branches of an order to those of the next.
    pub branching: Option<f64>,
    /// Length of an order to that of the one before.
    pub length: Option<f64>,
    /// Radius of an order to that of the one before.
    pub radius: Option<f64>,
}

/// Numbers the branches, which stand behind their parents.
pub(super) fn number(branches: &mut [Branch]) {
    for place in 0..branches.len() {
        branches[place].order = branches[place]
            .parent
            .map_or(0, |parent| branches[parent].order + 1);
    }
    // Of each branch's daughters: the highest Strahler order, how many have it, and the highest of Horsfield's.
    let mut highest = vec![(0_u32, 0_u32, 0_u32); branches.len()];
    for place in (0..branches.len()).rev() {
        let (strahler, with_it, horsfield) = highest[place];
        let branch = &mut branches[place];
        branch.strahler = strahler + u32::from(strahler == 0 || with_it > 1);
        branch.horsfield = horsfield + 1;
        branch.tips += u32::from(strahler == 0);
        let (own, horsfield, tips) = (branch.strahler, branch.horsfield, branch.tips);
        if let Some(parent) = branch.parent {
            branches[parent].tips += tips;
            let above = &mut highest[parent];
            match own.cmp(&above.0) {
                std::cmp::Ordering::Greater => (above.0, above.1) = (own, 1),
                std::cmp::Ordering::Equal => above.1 += 1,
                std::cmp::Ordering::Less => {}
            }
            above.2 = above.2.max(horsfield);
        }
    }
}

/// What each order is like.
pub(super) fn orders(branches: &[Branch]) -> Vec<Order> {
    let most = branches
        .iter()
        .map(|branch| branch.strahler)
        .max()
        .unwrap_or(0);
    let of = |strahler: u32| {
        let mut order = Order {
            strahler,
            ..Order::default()
        };
        for branch in branches.iter().filter(|branch| branch.strahler == strahler) {
            order.branches += 1;
            order.length += branch.length;
            order.radius += branch.radius.mean;
        }
        order.length /= order.branches.max(1) as f64;
        order.radius /= order.branches.max(1) as f64;
        order
    };
    (1..=most).map(of).collect()
}

pub(super) fn ratios(orders: &[Order]) -> Ratios {
    Ratios {
        branching: slope(orders, |order| order.branches as f64).map(f64::recip),
        length: slope(orders, |order| order.length),
        radius: slope(orders, |order| order.radius),
    }
}

/// By how much a quantity is multiplied from an order to the next, by least squares of its logarithm.
fn slope(orders: &[Order], of: impl Fn(&Order) -> f64) -> Option<f64> {
    let points: Vec<(f64, f64)> = orders
        .iter()
        .map(|order| (f64::from(order.strahler), of(order).ln()))
        .filter(|(_, value)| value.is_finite())
        .collect();
    let n = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (mean_x, mean_y) = (mean(|point| point.0), mean(|point| point.1));
    let (mut over, mut under) = (0.0, 0.0);
    for (x, y) in &points {
        over += (x - mean_x) * (y - mean_y);
        under += (x - mean_x).powi(2);
    }
    (points.len() > 1 && under > 0.0).then(|| (over / under).exp())
}
