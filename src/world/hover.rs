//! What a hand means: the node or the platform's rim that it touches or points at.
//!
//! Touch comes before pointing, because a hand inside the miniature means what it
//! is at, not what happens to lie farther along its ray. There is no memory
//! between frames: what is hovered depends on this frame's pose alone, so a
//! dropped or doubled frame cannot change what a button does.

use glam::Vec3;

/// How near is near enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoverParams {
    /// A node within this of the tip is touched, metres.
    pub touch: f32,
    /// How far a ray reaches, metres.
    pub reach: f32,
    /// Angle by which a ray may miss, radians: an unsteady hand's share.
    pub tolerance: f32,
    /// The rim within this of the tip or the hand is touched, metres.
    pub rim_touch: f32,
}

impl Default for HoverParams {
    fn default() -> Self {
        Self {
            touch: 0.025,
            reach: 4.0,
            tolerance: 1.2_f32.to_radians(),
            rim_touch: 0.04,
        }
    }
}

/// A hand as the search sees it, in the stage, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pointer {
    /// Start of the ray.
    pub origin: Vec3,
    /// Unit vector along the ray.
    pub direction: Vec3,
    /// The drawing tip.
    pub tip: Vec3,
    /// The hand's centre.
    pub hand: Vec3,
}

/// Something found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Which of the balls.
    pub index: usize,
    /// Metres along the ray, where it ends at what was found.
    pub along: f32,
    /// True where the tip touches it.
    pub touched: bool,
}

/// The nearest of the balls that the tip touches, else the nearest that the ray meets; the first of equals.
pub fn ball(
    centers: impl Iterator<Item = Vec3> + Clone,
    radius: f32,
    pointer: &Pointer,
    params: &HoverParams,
) -> Option<Hit> {
    let touched = centers
        .clone()
        .enumerate()
        .map(|(index, center)| (index, center.distance(pointer.tip)))
        .filter(|&(_, distance)| distance <= params.touch)
        .min_by(|a, b| a.1.total_cmp(&b.1));
    if let Some((index, _)) = touched {
        return Some(Hit {
            index,
            along: 0.0,
            touched: true,
        });
    }
    let spread = params.tolerance.tan();
    centers
        .enumerate()
        .filter_map(|(index, center)| {
            let along = (center - pointer.origin).dot(pointer.direction);
            let aside = center.distance(pointer.origin + pointer.direction * along);
            (along > 0.0 && along <= params.reach && aside <= radius + along * spread)
                .then_some((index, along))
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(index, along)| Hit {
            index,
            along,
            touched: false,
        })
}

/// How far along the way of a tip it comes nearest to a point, 0 to 1, if that is within `touch`.
pub(super) fn near_line(point: Vec3, from: Vec3, to: Vec3, touch: f32) -> Option<f32> {
    let way = to - from;
    let along = (point - from).dot(way) / way.length_squared();
    // A tip that stands still gives NaN or infinity.
    let part = if along.is_finite() {
        along.clamp(0.0, 1.0)
    } else {
        0.0
    };
    (point.distance(from + way * part) <= touch).then_some(part)
}

/// A level ring in the stage: the platform's rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Centre in metres.
    pub center: Vec3,
    /// Inner radius in metres.
    pub inner: f32,
    /// Outer radius in metres.
    pub outer: f32,
}

/// Metres along the ray to the ring, 0 where tip or hand touches it; `None` where neither means it.
pub fn ring(ring: &Ring, pointer: &Pointer, params: &HoverParams) -> Option<f32> {
    let touches = |point: Vec3| {
        let offset = point - ring.center;
        let level = offset.x.hypot(offset.z);
        let outside = (ring.inner - level).max(level - ring.outer).max(0.0);
        outside.hypot(offset.y) <= params.rim_touch
    };
    if touches(pointer.tip) || touches(pointer.hand) {
        return Some(0.0);
    }
    let along = (ring.center.y - pointer.origin.y) / pointer.direction.y;
    // A level ray gives ±∞ or NaN, which fails here.
    if !(along > 0.0 && along <= params.reach) {
        return None;
    }
    let offset = pointer.origin + pointer.direction * along - ring.center;
    let level = offset.x.hypot(offset.z);
    let spread = along * params.tolerance.tan();
    (level >= ring.inner - spread && level <= ring.outer + spread).then_some(along)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use proptest::prelude::*;

    use super::*;

    const RADIUS: f32 = 0.01;

    fn pointer(origin: Vec3, direction: Vec3) -> Pointer {
        let direction = direction.normalize();
        Pointer {
            origin,
            direction,
            tip: origin + direction * 0.06,
            hand: origin,
        }
    }

    #[test]
    fn touch_beats_pointing_and_the_nearest_wins() {
        type Found = Option<(usize, bool)>;
        let params = HoverParams::default();
        let at = pointer(Vec3::ZERO, Vec3::NEG_Z);
        let cases: [(&str, Vec<Vec3>, Found); 7] = [
            ("nothing there", vec![], None),
            ("aside", vec![Vec3::new(0.2, 0.0, -1.0)], None),
            ("behind", vec![Vec3::new(0.0, 0.0, 0.5)], None),
            ("too far", vec![Vec3::new(0.0, 0.0, -4.5)], None),
            (
                "two on the ray",
                vec![Vec3::new(0.0, 0.0, -2.0), Vec3::new(0.0, 0.005, -1.0)],
                Some((1, false)),
            ),
            (
                "touched and on the ray",
                vec![Vec3::new(0.0, 0.0, -0.02), Vec3::new(0.0, 0.02, -0.06)],
                Some((1, true)),
            ),
            (
                "two touched",
                vec![Vec3::new(0.0, 0.02, -0.06), Vec3::new(0.0, -0.01, -0.06)],
                Some((1, true)),
            ),
        ];
        for (what, balls, expected) in cases {
            let hit = ball(balls.iter().copied(), RADIUS, &at, &params);
            assert_eq!(hit.map(|hit| (hit.index, hit.touched)), expected, "{what}");
        }
    }

    #[test]
    fn the_tolerance_is_an_angle() {
        let params = HoverParams::default();
        let at = pointer(Vec3::ZERO, Vec3::NEG_Z);
        for distance in [0.5_f32, 1.0, 3.0] {
            let edge = RADIUS + distance * params.tolerance.tan();
            let hit = |aside: f32| {
                ball(
                    [Vec3::new(aside, 0.0, -distance)].into_iter(),
                    RADIUS,
                    &at,
                    &params,
                )
                .is_some()
            };
            assert!(hit(edge * 0.98) && !hit(edge * 1.02), "{distance}");
        }
    }

    #[test]
    fn the_ring_is_touched_or_pointed_at_on_its_rim_only() {
        let params = HoverParams::default();
        let rim = Ring {
            center: Vec3::new(0.0, 0.9, -0.6),
            inner: 0.24,
            outer: 0.28,
        };
        let above = |x: f32, z: f32| pointer(Vec3::new(x, 1.6, z), Vec3::NEG_Y);
        assert!(
            ring(&rim, &above(0.26, -0.6), &params).is_some(),
            "on the rim"
        );
        assert!(
            ring(&rim, &above(0.0, -0.34), &params).is_some(),
            "on the near rim"
        );
        assert_eq!(
            ring(&rim, &above(0.0, -0.6), &params),
            None,
            "in the middle"
        );
        assert_eq!(ring(&rim, &above(0.5, -0.6), &params), None, "outside");
        assert_eq!(
            ring(
                &rim,
                &pointer(Vec3::new(0.0, 1.5, 0.0), Vec3::NEG_Z),
                &params
            ),
            None,
            "level"
        );
        assert_eq!(
            ring(
                &rim,
                &pointer(Vec3::new(0.26, 0.92, -0.6), Vec3::Y),
                &params
            ),
            Some(0.0),
            "the hand is at it"
        );
    }

    proptest! {
        /// The search agrees with a plain statement of what it is to be the nearest touched ball.
        #[test]
        fn touch_agrees_with_brute_force(balls in prop::collection::vec(prop::array::uniform3(-0.1_f32..0.1), 0..20)) {
            let balls: Vec<Vec3> = balls.into_iter().map(Vec3::from).collect();
            let at = Pointer { origin: Vec3::Y * 9.0, direction: Vec3::Y, tip: Vec3::ZERO, hand: Vec3::Y * 9.0 };
            let found = ball(balls.iter().copied(), RADIUS, &at, &HoverParams::default());
            let nearest = balls.iter().map(|ball| ball.length()).fold(f32::INFINITY, f32::min);
            match found {
                Some(hit) => prop_assert!(hit.touched && balls[hit.index].length() == nearest),
                None => prop_assert!(nearest > HoverParams::default().touch),
            }
        }
    }
}
