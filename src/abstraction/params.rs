//! What the stochastic L-system of Algorithm 1 is told, with the limits of each number.

use serde::{Deserialize, Serialize};

use super::by_order::ByOrder;
use super::error::AbstractionError;

/// Parameters of Algorithm 1 (van Nielen, Verbeek and Cao, Table 2), and some that it lacks, which change nothing as they are by default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// Radius of new segments, in the model's unit.
    pub segment_radius: f64,
    /// What each iteration adds to the radius of every segment, in the model's unit.
    pub radial_increment: f64,
    /// How likely a tip that has grown for its time forks, 0 to 1.
    pub bifurcation_probability: f64,
    /// How likely a fork has three branches, 0 to 1. Not of the source.
    pub trifurcation_probability: f64,
    /// Sides of the cylinders, from 3, for whoever draws them: a grammar has none.
    pub radial_segments: u32,
    /// How many iterations a centerline may be long, in the mean.
    pub iterations: f64,
    /// Its standard deviation.
    pub iterations_std: f64,
    /// How much of what is left of its centerline a further branch of a fork has, 0 to 1: below 1 the first goes on as a main line, and others are its sides.
    /// Not of the source.
    pub side_life: f64,
    /// Up to which order tips grow longer before they fork.
    pub max_order: u32,
    /// Length of new segments, in the model's unit, in the mean.
    pub segment_length: f64,
    /// Its standard deviation.
    pub segment_length_std: f64,
    /// Length of a segment over that of one of the order before. Not of the source.
    pub length_ratio: f64,
    /// The same of radii. Not of the source.
    pub radius_ratio: f64,
    /// Of each order from the stem's, which is 0, on: what lengths of its segments are multiplied by; the last holds for those beyond. Empty: by nothing. Not of
    /// the source.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub length_by_order: Vec<f64>,
    /// The same of radii.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub radius_by_order: Vec<f64>,
    /// The same of how much branches are pitched at their fork; the stem's means nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub angle_by_order: Vec<f64>,
    /// How much a segment is pitched up, degrees, in the mean.
    pub upwards_angle: f64,
    /// Its standard deviation.
    pub upwards_angle_std: f64,
    /// How much each branch of a fork is pitched down, degrees, in the mean.
    pub bifurcation_angle: f64,
    /// Its standard deviation.
    pub bifurcation_angle_std: f64,
    /// Segments before the first fork.
    pub stem_length: u32,
    /// The largest roll before a branch, degrees.
    pub roll_range: u32,
    /// Branches of a fork are turned away from each other, all around. In the source they are not: rolled by up to 60 degrees, both are pitched to the same side.
    pub around: bool,
    /// Segments that run into others are left out, and what grows from them.
    pub prune_intersections: bool,
    /// So are those that leave an ellipsoid about the root with these three radii, in the model's unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounding_ellipsoid: Option<[f64; 3]>,
    /// One seed gives one tree.
    pub seed: u64,
}

impl Default for Params {
    /// The source's (Table 2), with a stem of one segment.
    fn default() -> Self {
        Self {
            segment_radius: 0.03,
            radial_increment: 0.0001,
            bifurcation_probability: 0.4,
            trifurcation_probability: 0.0,
            radial_segments: 8,
            iterations: 4.0,
            iterations_std: 0.0,
            side_life: 1.0,
            max_order: 0,
            segment_length: 0.3,
            segment_length_std: 0.0,
            length_ratio: 1.0,
            radius_ratio: 1.0,
            length_by_order: Vec::new(),
            radius_by_order: Vec::new(),
            angle_by_order: Vec::new(),
            upwards_angle: 5.0,
            upwards_angle_std: 2.0,
            bifurcation_angle: 17.5,
            bifurcation_angle_std: 0.0,
            stem_length: 1,
            roll_range: 60,
            around: false,
            prune_intersections: false,
            bounding_ellipsoid: None,
            seed: 0,
        }
    }
}

/// Most iterations of a centerline.
pub const ITERATIONS_MOST: f64 = 50.0;
/// Most segments of a stem.
pub const STEM_MOST: u32 = 1000;
/// Least of what is a length in the model's unit.
const LENGTH_LEAST: f64 = 1e-9;
/// Most of what is a length, and of what is one over another.
const LENGTH_MOST: f64 = 1e9;
const RATIO_MOST: f64 = 10.0;
/// Most of a factor of an order.
const FACTOR_MOST: f64 = 1000.0;
/// Orders that have factors at most.
pub const ORDERS_MOST: usize = 64;

impl Params {
    /// Whether each number is within its limits.
    ///
    /// # Errors
    /// [`AbstractionError::Parameter`], which names the first that is not, and its limits.
    pub fn check(&self) -> Result<(), AbstractionError> {
        let tiny = LENGTH_LEAST;
        let numbers: [(&'static str, f64, [f64; 2]); 18] = [
            ("segment_radius", self.segment_radius, [tiny, LENGTH_MOST]),
            (
                "radial_increment",
                self.radial_increment,
                [-LENGTH_MOST, LENGTH_MOST],
            ),
            (
                "bifurcation_probability",
                self.bifurcation_probability,
                [0.0, 1.0],
            ),
            (
                "trifurcation_probability",
                self.trifurcation_probability,
                [0.0, 1.0],
            ),
            (
                "radial_segments",
                f64::from(self.radial_segments),
                [3.0, 64.0],
            ),
            ("iterations", self.iterations, [1.0, ITERATIONS_MOST]),
            (
                "iterations_std",
                self.iterations_std,
                [0.0, ITERATIONS_MOST],
            ),
            ("side_life", self.side_life, [0.0, 1.0]),
            ("max_order", f64::from(self.max_order), [0.0, 1000.0]),
            ("segment_length", self.segment_length, [tiny, LENGTH_MOST]),
            (
                "segment_length_std",
                self.segment_length_std,
                [0.0, LENGTH_MOST],
            ),
            (
                "length_ratio",
                self.length_ratio,
                [1.0 / RATIO_MOST, RATIO_MOST],
            ),
            (
                "radius_ratio",
                self.radius_ratio,
                [1.0 / RATIO_MOST, RATIO_MOST],
            ),
            ("upwards_angle", self.upwards_angle, [-180.0, 180.0]),
            ("upwards_angle_std", self.upwards_angle_std, [0.0, 180.0]),
            ("bifurcation_angle", self.bifurcation_angle, [-180.0, 180.0]),
            (
                "bifurcation_angle_std",
                self.bifurcation_angle_std,
                [0.0, 180.0],
            ),
            ("roll_range", f64::from(self.roll_range), [0.0, 180.0]),
        ];
        let radii = self.bounding_ellipsoid.unwrap_or([1.0; 3]);
        let radii = radii.map(|radius| ("bounding_ellipsoid", radius, [tiny, LENGTH_MOST]));
        let stem = (
            "stem_length",
            f64::from(self.stem_length),
            [0.0, f64::from(STEM_MOST)],
        );
        let factors = ByOrder::ALL.into_iter().flat_map(|of| {
            let all = of.factors(self).iter();
            all.map(move |factor| (of.name(), *factor, [1.0 / FACTOR_MOST, FACTOR_MOST]))
        });
        for of in ByOrder::ALL {
            let orders = of.factors(self).len();
            if orders > ORDERS_MOST {
                return Err(AbstractionError::Parameter {
                    name: of.name(),
                    value: orders as f64,
                    limits: [0.0, ORDERS_MOST as f64],
                });
            }
        }
        let all = numbers
            .into_iter()
            .chain(radii)
            .chain([stem])
            .chain(factors);
        for (name, value, limits) in all {
            if !(limits[0]..=limits[1]).contains(&value) {
                return Err(AbstractionError::Parameter {
                    name,
                    value,
                    limits,
                });
            }
        }
        Ok(())
    }
}
