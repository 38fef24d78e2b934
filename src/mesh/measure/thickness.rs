//! How thick a solid is at a place of its surface, in two ways.

use std::f64::consts::FRAC_PI_3;

use glam::{DQuat, DVec3, Vec3};

use super::axis::spread;
use crate::mesh::pick::Picker;

/// Rays of a cone.
const RAYS: u32 = 30;

/// How thick the solid is below a place of its surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thickness {
    /// How far it is to the other side, straight in.
    pub opposite: Option<f32>,
    /// The shape diameter (Shapira, Shamir and Cohen-Or 2008): the mean length of rays into a cone of 120°, nearer to its axis weighing more (by
    /// the inverse of the angle), without those that are farther from the median than one standard deviation. It changes little
    /// with bumps and poses; since most rays are slanted it is more than the diameter, on a long tube by a tenth.
    pub diameter: Option<f32>,
}

/// How thick the solid is below a point of its surface, of which `normal` is that of the triangles.
pub fn thickness(picker: &Picker, point: Vec3, normal: Vec3) -> Thickness {
    Thickness {
        opposite: inside(picker, point, picker.inwards(normal)),
        diameter: diameter(picker, point, normal),
    }
}

/// How far a ray that starts on the surface is inside.
pub(super) fn inside(picker: &Picker, point: Vec3, direction: Vec3) -> Option<f32> {
    let hit = picker.ray_to(point, direction, f32::INFINITY, picker.inner_sides())?;
    // What is hit where it starts is the surface it starts on.
    let rounding = 16.0 * f32::EPSILON * point.abs().max_element();
    (hit.distance > rounding).then_some(hit.distance)
}

/// The shape diameter alone.
pub(crate) fn diameter(picker: &Picker, point: Vec3, normal: Vec3) -> Option<f32> {
    let inwards = picker.inwards(normal).as_dvec3().try_normalize()?;
    let turn = DQuat::from_rotation_arc(DVec3::Z, inwards);
    let rays: Vec<(f64, f64)> = spread(RAYS, FRAC_PI_3)
        .filter_map(|direction| {
            let length = inside(picker, point, (turn * direction).as_vec3())?;
            Some((f64::from(length), direction.z.acos().recip()))
        })
        .collect();
    mean_near_median(rays)
}

/// The weighted mean of those within one standard deviation of the median.
#[allow(
    clippy::cast_possible_truncation,
    reason = "told in single precision, as the mesh is"
)]
pub(super) fn mean_near_median(mut rays: Vec<(f64, f64)>) -> Option<f32> {
    rays.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = u32::try_from(rays.len()).map_or(1.0, f64::from);
    let (median, _) = *rays.get(rays.len() / 2)?;
    let mean = rays.iter().map(|(length, _)| length).sum::<f64>() / count;
    let variance = rays
        .iter()
        .map(|(length, _)| (length - mean).powi(2))
        .sum::<f64>()
        / count;
    let near = rays
        .iter()
        .filter(|(length, _)| (length - median).powi(2) <= variance);
    let (sum, weights) = near.fold((0.0, 0.0), |(sum, weights), (length, weight)| {
        (sum + length * weight, weights + weight)
    });
    Some((sum / weights) as f32)
}
