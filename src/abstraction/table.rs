//! What an abstraction is to be like: the counts and the table of a measured model, `ramus-table/1`.

use serde::{Deserialize, Serialize};

use super::by_order::OfOrder;
use super::error::AbstractionError;
use crate::tree::measure::{Measures, Spread};

/// The format's name.
pub const FORMAT: &str = "ramus-table/1";

/// Lengths of orders at most: a segment's, and many times more.
const LENGTH_MOST: f64 = 1e15;
/// Rows of orders at most, and branches of one.
const ORDERS_READ: usize = 10_000;
const BRANCHES_MOST: usize = 1_000_000_000;

/// A mean and its standard deviation, the population's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeanStd {
    /// The mean.
    pub mean: f64,
    /// The standard deviation; none where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std: Option<f64>,
}

impl From<Spread> for MeanStd {
    fn from(spread: Spread) -> Self {
        Self {
            mean: spread.mean,
            std: Some(spread.std),
        }
    }
}

/// How many there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Ways from the root to tips.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centerlines: Option<usize>,
    /// Nodes with two children or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub junctions: Option<usize>,
    /// Runs between junctions, the root and tips.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branches: Option<usize>,
}

/// Quantities; none where they are not known. Lengths are in the model's unit, angles in degrees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantities {
    /// Lengths of branches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch_length: Option<MeanStd>,
    /// Radii at points spread equally along branches.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point_radius: Option<MeanStd>,
    /// Lengths of the ways from root to tip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centerline_length: Option<MeanStd>,
    /// From the root to the first junction, in mean branch lengths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stem_iterations: Option<f64>,
    /// Mean of (centerline less stem) over mean branch length, and standard deviation of centerline length over it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub iterations: Option<MeanStd>,
    /// Angles between daughters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bifurcation_angle_deg: Option<MeanStd>,
    /// How much branches bend towards the stem's direction, over their length in mean branch lengths.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upwards_angle_deg: Option<MeanStd>,
}

/// What branches are like by order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Orders {
    /// By centrifugal order, from 0 on; empty where it is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub centrifugal: Vec<OfOrder>,
}

impl Orders {
    fn is_empty(&self) -> bool {
        self.centrifugal.is_empty()
    }
}

/// The table of a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// [`FORMAT`], or that of what it is the table of.
    pub format: String,
    /// How many there are of what.
    #[serde(default)]
    pub counts: Counts,
    /// How its quantities are spread.
    pub table: Quantities,
    /// What its branches are like by order.
    #[serde(default, skip_serializing_if = "Orders::is_empty")]
    pub orders: Orders,
}

impl Table {
    /// The table of a measured tree.
    pub fn of(measures: &Measures) -> Self {
        let table = &measures.table;
        let degrees = |spread: Spread| MeanStd {
            mean: spread.mean.to_degrees(),
            std: Some(spread.std.to_degrees()),
        };
        let [mean, std] = table.iterations;
        Self {
            format: FORMAT.to_owned(),
            counts: Counts {
                centerlines: Some(measures.tips),
                junctions: Some(measures.junctions.len()),
                branches: Some(measures.branches.len()),
            },
            table: Quantities {
                branch_length: Some(table.branch_length.into()),
                point_radius: Some(table.point_radius.into()),
                centerline_length: Some(table.centerline_length.into()),
                stem_iterations: Some(table.stem_iterations),
                iterations: Some(MeanStd {
                    mean,
                    std: Some(std),
                }),
                bifurcation_angle_deg: Some(degrees(table.bifurcation_angle)),
                upwards_angle_deg: Some(degrees(table.upwards_angle)),
            },
            orders: Orders {
                centrifugal: measures.by_order.iter().map(OfOrder::of).collect(),
            },
        }
    }

    /// Reads a table: `ramus-table/1`, or what `ramus analyze --json` prints.
    ///
    /// # Errors
    /// A sentence that says what is wrong with it.
    pub fn read(text: &str) -> Result<Self, AbstractionError> {
        let wrong = |why: String| AbstractionError::Table(why);
        let table: Self = serde_json::from_str(text).map_err(|error| {
            wrong(format!("it is no table: {error}; a table is an object with \"format\": \"{FORMAT}\", \"counts\" and \"table\", or what ramus analyze --json prints"))
        })?;
        if ![FORMAT, "ramus-analysis/1"].contains(&table.format.as_str()) {
            return Err(wrong(format!(
                "its format is {:?}: it must be {FORMAT:?} or \"ramus-analysis/1\"",
                table.format
            )));
        }
        let table = Self {
            format: FORMAT.to_owned(),
            ..table
        };
        table.check()?;
        table.completed()
    }

    pub(super) fn check(&self) -> Result<(), AbstractionError> {
        let wrong = |why: String| Err(AbstractionError::Table(why));
        let Quantities {
            branch_length,
            point_radius,
            centerline_length,
            stem_iterations,
            iterations,
            bifurcation_angle_deg,
            upwards_angle_deg,
        } = self.table;
        for (name, of, is_length) in [
            ("branch_length", branch_length, true),
            ("point_radius", point_radius, true),
            ("centerline_length", centerline_length, true),
            ("iterations", iterations, false),
            ("bifurcation_angle_deg", bifurcation_angle_deg, false),
            ("upwards_angle_deg", upwards_angle_deg, false),
        ] {
            let Some(MeanStd { mean, std }) = of else {
                continue;
            };
            if !mean.is_finite() || is_length && mean <= 0.0 {
                return wrong(format!(
                    "the mean of {name} is {mean}: it must be {}",
                    if is_length { "above 0" } else { "a number" }
                ));
            }
            if std.is_some_and(|std| !(std.is_finite() && std >= 0.0)) {
                return wrong(format!(
                    "the standard deviation of {name} must be 0 or more"
                ));
            }
        }
        if self.orders.centrifugal.len() > ORDERS_READ {
            return wrong(format!(
                "orders.centrifugal has more than {ORDERS_READ} rows, and no tree has as many orders"
            ));
        }
        for (place, row) in (0..).zip(&self.orders.centrifugal) {
            if row.branches > BRANCHES_MOST {
                return wrong(format!(
                    "order {place} has {} branches: it must be {BRANCHES_MOST} at most",
                    row.branches
                ));
            }
            if row.order != place {
                return wrong(format!(
                    "row {place} of orders.centrifugal is of order {}: its rows must be of orders 0, 1, 2 and so on",
                    row.order
                ));
            }
            for (name, of) in [
                ("branch_length", row.branch_length),
                ("point_radius", row.point_radius),
                ("bifurcation_angle_deg", row.bifurcation_angle_deg),
            ] {
                if of.is_some_and(|of| !(0.0..LENGTH_MOST).contains(&of.mean)) {
                    return wrong(format!(
                        "the mean of {name} of order {place} must be from 0 to {LENGTH_MOST:e}"
                    ));
                }
            }
        }
        if stem_iterations.is_some_and(|stem| !(stem.is_finite() && stem >= 0.0)) {
            return wrong("stem_iterations must be 0 or more".to_owned());
        }
        Ok(())
    }

    /// With what follows from the rest.
    fn completed(mut self) -> Result<Self, AbstractionError> {
        let Counts {
            centerlines,
            junctions,
            branches,
        } = &mut self.counts;
        // Each junction begins branches and each tip ends one; the stem is one more than forks make.
        match (*centerlines, *junctions, *branches) {
            (None, Some(some), Some(all)) => *centerlines = all.checked_sub(some),
            (Some(tips), None, Some(all)) => *junctions = all.checked_sub(tips),
            (Some(tips), Some(some), None) => *branches = tips.checked_add(some),
            _ => {}
        }
        let table = &mut self.table;
        if let (None, Some(branch), Some(centerline), Some(stem)) = (
            table.iterations,
            table.branch_length,
            table.centerline_length,
            table.stem_iterations,
        ) {
            table.iterations = Some(MeanStd {
                mean: centerline.mean / branch.mean - stem,
                std: centerline.std.map(|std| std / branch.mean),
            });
        }
        if self.counts.centerlines.is_none_or(|tips| tips == 0) {
            return Err(AbstractionError::Table(
                "it does not say how many centerlines there are: counts.centerlines must be 1 or more".to_owned(),
            ));
        }
        if table.branch_length.is_none() {
            return Err(AbstractionError::Table(
                "it does not say how long branches are: table.branch_length must have a mean"
                    .to_owned(),
            ));
        }
        Ok(self)
    }
}
