//! What branches are like by their centrifugal order: rows of a model's table, and factors of a grammar.

use serde::{Deserialize, Serialize};

use super::difference::{Difference, OF_DEVIATIONS};
use super::params::Params;
use super::table::MeanStd;
use crate::tree::measure::OfOrder as Measured;

/// Branches of one order. Lengths are in the model's unit, angles in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OfOrder {
    /// Which: 0 is the stem's, and each junction begins one more.
    pub order: u32,
    /// How many there are.
    pub branches: usize,
    /// Their lengths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch_length: Option<MeanStd>,
    /// Radii along them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point_radius: Option<MeanStd>,
    /// Angles between those that leave the same junction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bifurcation_angle_deg: Option<MeanStd>,
}

impl OfOrder {
    /// Of a measured tree.
    pub fn of(measured: &Measured) -> Self {
        let angle = measured.angle;
        Self {
            order: measured.order,
            branches: measured.length.n,
            branch_length: Some(measured.length.into()),
            point_radius: Some(MeanStd {
                mean: measured.radius,
                std: None,
            }),
            bifurcation_angle_deg: (angle.n > 0).then(|| MeanStd {
                mean: angle.mean.to_degrees(),
                std: Some(angle.std.to_degrees()),
            }),
        }
    }
}

/// What changes by order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByOrder {
    /// Lengths of segments.
    Length,
    /// Their radii.
    Radius,
    /// How much branches are pitched at their fork.
    Angle,
}

impl ByOrder {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Length, Self::Radius, Self::Angle];

    /// The name of its factors.
    pub fn name(self) -> &'static str {
        match self {
            Self::Length => "length_by_order",
            Self::Radius => "radius_by_order",
            Self::Angle => "angle_by_order",
        }
    }

    /// Its factors.
    pub fn factors(self, params: &Params) -> &Vec<f64> {
        match self {
            Self::Length => &params.length_by_order,
            Self::Radius => &params.radius_by_order,
            Self::Angle => &params.angle_by_order,
        }
    }

    /// Its factors, to be changed.
    pub fn factors_mut(self, params: &mut Params) -> &mut Vec<f64> {
        match self {
            Self::Length => &mut params.length_by_order,
            Self::Radius => &mut params.radius_by_order,
            Self::Angle => &mut params.angle_by_order,
        }
    }

    /// Its row of a table: the mean.
    fn of(self, row: &OfOrder) -> Option<f64> {
        let row = match self {
            Self::Length => row.branch_length,
            Self::Radius => row.point_radius,
            Self::Angle => row.bifurcation_angle_deg,
        };
        row.map(|one| one.mean)
    }

    /// The name of that.
    fn table_name(self) -> &'static str {
        match self {
            Self::Length => "branch_length",
            Self::Radius => "point_radius",
            Self::Angle => "bifurcation_angle_deg",
        }
    }
}

/// A number of one order in two tables.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OrderDifference {
    /// Which order.
    pub order: u32,
    /// How much it counts: all of a quantity together 1.
    #[serde(skip)]
    pub share: f64,
    /// The number.
    #[serde(flatten)]
    pub difference: Difference,
}

/// Angles count as parts of this at least, degrees.
const ANGLE_LEAST: f64 = 1.0;

/// What orders of a model have otherwise than those of a tree: means of all orders that both have. Each order counts alike: the first ones have few branches,
/// and are what one sees first.
pub(super) fn differences([target, got]: [&[OfOrder]; 2]) -> Vec<OrderDifference> {
    let share = 1.0 / target.len().max(1) as f64;
    let mut found = Vec::new();
    for (wanted, got) in target.iter().zip(got) {
        for of in ByOrder::ALL {
            let (Some(wanted_mean), Some(got)) = (of.of(wanted), of.of(got)) else {
                continue;
            };
            // Of nothing no part is known.
            let unit = match of {
                ByOrder::Angle => wanted_mean.max(ANGLE_LEAST),
                _ if wanted_mean > 0.0 => wanted_mean,
                _ => continue,
            };
            if !(unit.is_finite() && got.is_finite()) {
                continue;
            }
            found.push(OrderDifference {
                order: wanted.order,
                share,
                difference: Difference::new(
                    of.table_name(),
                    wanted_mean,
                    got,
                    [OF_DEVIATIONS, unit],
                ),
            });
        }
    }
    found
}

/// Which part of a model's branches a tree has in other orders, 0 to 1, and more where it has more of them. 0 where the model's orders are not known.
pub(super) fn misplaced([target, got]: [&[OfOrder]; 2]) -> f64 {
    let of =
        |rows: &[OfOrder], place: usize| rows.get(place).map_or(0.0, |row| row.branches as f64);
    let all: f64 = target.iter().map(|row| row.branches as f64).sum();
    if all == 0.0 {
        return 0.0;
    }
    let apart = (0..target.len().max(got.len()))
        .map(|place| (of(target, place) - of(got, place)).abs())
        .sum::<f64>();
    apart / (2.0 * all)
}
