//! What branches are like by their centrifugal order: the stem is of order 0, and each junction begins one more.

use super::branch::Branch;
use super::junction::Junction;
use super::statistics::{Spread, spread};

/// The branches of one order. Lengths are in the tree's unit, angles in radians.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OfOrder {
    /// Which, from 0.
    pub order: u32,
    /// Lengths of its branches, as many as it has.
    pub length: Spread,
    /// The mean radius along its branches, by length; 0 where they have none.
    pub radius: f64,
    /// Angles between branches of it that leave the same junction.
    pub angle: Spread,
}

/// All orders from 0 on. `branches` stand behind their parents.
pub(super) fn by_order(branches: &[Branch], junctions: &[Junction]) -> Vec<OfOrder> {
    let most = branches.iter().map(|branch| branch.order as usize).max();
    let mut lengths: Vec<Vec<f64>> = vec![Vec::new(); most.map_or(0, |most| most + 1)];
    let (mut radii, mut angles) = (vec![0.0; lengths.len()], lengths.clone());
    for branch in branches {
        let order = branch.order as usize;
        lengths[order].push(branch.length);
        radii[order] += branch.radius.mean * branch.length;
    }
    for junction in junctions {
        if let Some(first) = junction.daughters.first() {
            angles[branches[*first].order as usize].extend(&junction.angles);
        }
    }
    let orders = (0_u32..).zip(lengths).zip(radii).zip(angles);
    orders
        .map(|(((order, lengths), radius), angles)| OfOrder {
            order,
            radius: match lengths.iter().sum::<f64>() {
                long if long > 0.0 => radius / long,
                _ => 0.0,
            },
            length: spread(lengths),
            angle: spread(angles),
        })
        .collect()
}
