//! Snapping: a segment that is almost at a round angle, or a node almost in the mirror plane, is put there.

use glam::{Quat, Vec3};

/// The direction turned to the nearest multiple of `every` to an axis, if it is within `within` of it; radians. The
/// first axis that fits is taken; lengths and the plane of axis and direction stay.
pub(super) fn turned(
    direction: Vec3,
    axes: [Option<Vec3>; 2],
    every: f32,
    within: f32,
) -> Option<Vec3> {
    // Half a step would snap everything.
    let within = within.min(every * 0.25);
    axes.into_iter().flatten().find_map(|axis| {
        let axis = axis.try_normalize()?;
        let length = direction.length();
        let unit = direction.try_normalize()?;
        let angle = unit.dot(axis).clamp(-1.0, 1.0).acos();
        let round = (angle / every).round() * every;
        if (angle - round).abs() > within {
            return None;
        }
        match axis.cross(unit).try_normalize() {
            Some(about) => Some(Quat::from_axis_angle(about, round) * axis * length),
            // Along the axis already.
            None => Some(direction),
        }
    })
}

/// The place put onto the plane x = 0 if it is within `within` of it; metres.
pub(super) fn onto_plane(place: Vec3, within: f32) -> Option<Vec3> {
    (place.x.abs() <= within).then_some(Vec3 { x: 0.0, ..place })
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    const STEP: f32 = 15.0_f32 * std::f32::consts::PI / 180.0;
    const WITHIN: f32 = 3.0_f32 * std::f32::consts::PI / 180.0;

    fn at(degrees: f32) -> Vec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        Vec3::new(sin, cos, 0.0) * 0.3
    }

    #[test]
    fn near_a_multiple_it_turns_there_and_between_it_stays() {
        for (degrees, expected) in [
            (44.0, Some(45.0)),
            (47.9, Some(45.0)),
            (1.0, Some(0.0)),
            (178.5, Some(180.0)),
            (37.5, None),
            (52.0, None),
        ] {
            let found = turned(at(degrees), [Some(Vec3::Y * 7.0), None], STEP, WITHIN);
            match expected {
                Some(degrees) => assert!(
                    found.unwrap().distance(at(degrees)) < 1e-4,
                    "{degrees}: {found:?}"
                ),
                None => assert_eq!(found, None, "{degrees}"),
            }
        }
    }

    #[test]
    fn the_first_axis_comes_first() {
        let axes = [Some(at(10.0)), Some(Vec3::Y)];
        assert!(
            turned(at(56.0), axes, STEP, WITHIN)
                .unwrap()
                .distance(at(55.0))
                < 1e-4
        );
        // 62° is between the multiples from 10°, but near 60° from the vertical.
        assert!(
            turned(at(62.0), axes, STEP, WITHIN)
                .unwrap()
                .distance(at(60.0))
                < 1e-4
        );
        assert_eq!(turned(at(62.0), [None; 2], STEP, WITHIN), None);
        assert_eq!(turned(Vec3::ZERO, axes, STEP, WITHIN), None);
        assert_eq!(turned(Vec3::NAN, axes, STEP, WITHIN), None);
    }

    #[test]
    fn the_plane_takes_what_is_near() {
        let place = Vec3::new(-0.01, 0.4, 0.2);
        assert_eq!(onto_plane(place, 0.02), Some(Vec3::new(0.0, 0.4, 0.2)));
        assert_eq!(onto_plane(place, 0.005), None);
        assert_eq!(onto_plane(Vec3::NAN, 1.0), None);
    }
}
