//! The source's own way from a table to parameters: each number from one or two of the table's.

use super::params::{ITERATIONS_MOST, Params, STEM_MOST};
use super::table::{MeanStd, Table};

/// How much segments may be pitched up at most, degrees.
const UPWARDS_MOST: f64 = 30.0;
/// Segments grow in every second iteration.
const STEPS_OF_A_SEGMENT: f64 = 2.0;

/// The parameters of Algorithm 1 for a table.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a number of segments"
)]
pub fn params(table: &Table, seed: u64) -> Params {
    let known = table.table;
    let std = |of: MeanStd| of.std.unwrap_or(0.0);
    let length = known.branch_length.unwrap_or(MeanStd {
        mean: 1.0,
        std: None,
    });
    let iterations = known.iterations.unwrap_or(MeanStd {
        mean: 2.0,
        std: None,
    });
    let default = Params::default();
    let upwards = known.upwards_angle_deg.unwrap_or(MeanStd {
        mean: default.upwards_angle,
        std: Some(default.upwards_angle_std),
    });
    let angle = known.bifurcation_angle_deg.unwrap_or(MeanStd {
        mean: 35.0,
        std: None,
    });
    Params {
        segment_radius: known
            .point_radius
            .map_or(0.1 * length.mean, |radius| radius.mean),
        bifurcation_probability: 1.0,
        iterations: (STEPS_OF_A_SEGMENT * iterations.mean)
            .round()
            .clamp(1.0, ITERATIONS_MOST),
        iterations_std: (STEPS_OF_A_SEGMENT * std(iterations)).min(ITERATIONS_MOST),
        max_order: 0,
        segment_length: length.mean,
        segment_length_std: std(length),
        stem_length: known
            .stem_iterations
            .map_or(1.0, |stem| stem.round().clamp(0.0, f64::from(STEM_MOST)))
            as u32,
        upwards_angle: upwards.mean.clamp(-UPWARDS_MOST, UPWARDS_MOST),
        upwards_angle_std: std(upwards).min(UPWARDS_MOST),
        bifurcation_angle: (angle.mean / 2.0).clamp(-180.0, 180.0),
        seed,
        ..default
    }
}
