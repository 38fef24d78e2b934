//! How many pictures a second to ask of a headset that leaves the choice.

/// Rates in hertz that are wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefreshWish {
    /// The lowest rate offered of at least this is taken: more costs pictures that nobody notices,
    pub enough: f32,
    /// but none above this. Where none is enough, the highest below it is taken.
    pub highest: f32,
}

impl Default for RefreshWish {
    /// 90 Hz, and never above 120.
    fn default() -> Self {
        Self {
            enough: 90.0,
            highest: 120.0,
        }
    }
}

/// The rate to ask for; none where nothing that is offered will do. What is no rate (NaN, infinite, not above 0) is
/// passed over, whatever the order.
#[must_use]
pub fn choose(offered: &[f32], wish: RefreshWish) -> Option<f32> {
    let sane = || {
        offered
            .iter()
            .copied()
            .filter(|rate| rate.is_finite() && *rate > 0.0 && *rate <= wish.highest)
    };
    let enough = sane().filter(|rate| *rate >= wish.enough);
    enough
        .min_by(f32::total_cmp)
        .or_else(|| sane().max_by(f32::total_cmp))
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "the table says what it expects"
    )]

    use super::*;

    #[test]
    fn enough_is_chosen_and_never_too_much() {
        for (offered, chosen) in [
            (&[][..], None),
            (&[72.0, 80.0, 90.0, 120.0], Some(90.0)),
            (&[120.0, 72.0], Some(120.0)),
            (&[72.0, 60.0, 80.0], Some(80.0)),
            (&[144.0, 1000.0], None),
            (&[60.0, 144.0], Some(60.0)),
            (
                &[f32::NAN, -90.0, 0.0, f32::INFINITY, f32::NEG_INFINITY],
                None,
            ),
            (&[f32::NAN, -90.0, 72.0, 1000.0], Some(72.0)),
            (&[59.94, 89.9, 90.1], Some(90.1)),
        ] {
            assert_eq!(
                choose(offered, RefreshWish::default()),
                chosen,
                "{offered:?}"
            );
        }
        let calm = RefreshWish {
            enough: 60.0,
            highest: 72.0,
        };
        assert_eq!(choose(&[72.0, 60.0, 90.0], calm), Some(60.0));
    }
}
