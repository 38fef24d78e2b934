//! Holds a headset's rate: where the device needs too long for pictures, they get fewer pixels, and more again when there is time.
//!
//! What is asked is how long the device worked on a frame ([`DrawReport::device`](crate::render::DrawReport::device)), not when frames came: a headset's runtime
//! waits for its screen, so frames come no sooner than that. A frame that is late by itself (a shadow drawn anew, a tree that arrives) changes nothing.

use std::time::Duration;

use ash::vk;

/// Parts of a side: a picture's sides are so many sixteenths of all.
const WHOLE: u32 = 16;
/// No fewer: 0.39 of all pixels, where text on panels can still be read.
const LEAST: u32 = 10;
/// Late frames in a row that are a reason, and frames in time with room for more.
const LATE: u32 = 3;
const EARLY: u32 = 90;
/// Frames that are under way when the size changes: they are as large as before.
const UNDER_WAY: u32 = 3;
/// Parts of a period: more is late, since the runtime needs the device, too; so much is aimed at; and less is early once there are more pixels.
const TOO_LONG: f64 = 0.90;
const AIM: f64 = 0.80;
const SHORT: f64 = 0.75;

/// No screen's period is shorter.
const SHORTEST: Duration = Duration::from_millis(1);

/// How large pictures are.#[derive(Clone, Debug)]
pub(super) struct Rate {
    sixteenths: u32,
    late: u32,
    early: u32,
    under_way: u32,
    /// The screen's own period; zero before it is known.
    period: Duration,
}

impl Default for Rate {
    fn default() -> Self {
        Self {
            sixteenths: WHOLE,
            late: 0,
            early: 0,
            under_way: 0,
            period: Duration::ZERO,
        }
    }
}

impl Rate {
    /// The screen's own period: a runtime that is late tells two or three of them (Monado's pacing does), and that is no reason to be content.
    fn base(&mut self, told: Duration) -> Duration {
        let known = self.period.as_secs_f64();
        if self.period < SHORTEST || told.as_secs_f64() < 1.5 * known {
            self.period = told;
        }
        self.period
    }

    /// Takes how long the device worked on the last frame that is done, and how long the runtime says that one is shown.
    pub(super) fn take(&mut self, worked: Duration, period: Duration) {
        let period = self.base(period);
        if self.under_way > 0 {
            self.under_way -= 1;
            return;
        }
        let load = worked.as_secs_f64() / period.as_secs_f64();
        if !load.is_finite() {
            return;
        }
        let more = f64::from(self.sixteenths + 1) / f64::from(self.sixteenths);
        self.late = if load > TOO_LONG { self.late + 1 } else { 0 };
        self.early = if load * more * more < SHORT {
            self.early + 1
        } else {
            0
        };
        if self.late >= LATE {
            // As if all of it were pixels: what is not is seen next time.
            let fits = f64::from(self.sixteenths) * (AIM / load).sqrt();
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "between 0 and 16"
            )]
            let fits = fits as u32;
            self.set(fits.min(self.sixteenths - 1));
        } else if self.early >= EARLY {
            self.set(self.sixteenths + 1);
        }
    }

    fn set(&mut self, sixteenths: u32) {
        let sixteenths = sixteenths.clamp(LEAST, WHOLE);
        if sixteenths != self.sixteenths {
            self.under_way = UNDER_WAY;
        }
        *self = Self {
            sixteenths,
            late: 0,
            early: 0,
            ..*self
        };
    }

    /// Pixels to draw, of a picture of so many.
    pub(super) fn part_of(&self, all: vk::Extent2D) -> vk::Extent2D {
        let part = |pixels: u32| {
            let wide = u64::from(pixels) * u64::from(self.sixteenths);
            u32::try_from(wide.div_ceil(u64::from(WHOLE))).unwrap_or(pixels)
        };
        vk::Extent2D {
            width: part(all.width),
            height: part(all.height),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use proptest::prelude::*;

    use super::*;

    const PERIOD: Duration = Duration::from_nanos(11_111_111);

    /// A device that needs so much of a period, and for all pixels so much more.
    fn after(rate: &mut Rate, fixed: f64, pixels: f64, frames: usize) -> Vec<u32> {
        // It tells of a frame when two more are under way.
        let mut sizes = std::collections::VecDeque::from([rate.sixteenths; 2]);
        (0..frames)
            .map(|_| {
                sizes.push_back(rate.sixteenths);
                let side = f64::from(sizes.pop_front().unwrap_or(WHOLE)) / f64::from(WHOLE);
                let load = fixed + pixels * side * side;
                rate.take(PERIOD.mul_f64(load), PERIOD);
                rate.sixteenths
            })
            .collect()
    }

    #[test]
    fn pictures_are_as_large_as_there_is_time_for() {
        for (fixed, pixels, expected) in [
            (0.1, 0.5, 16..=16),
            (0.1, 0.79, 16..=16),
            (0.0, 1.0, 14..=14),
            (0.3, 0.8, 11..=13),
            (0.0, 1.6, 11..=11),
            (0.0, 9.0, 10..=10),
            (2.0, 0.1, 10..=10),
        ] {
            let mut rate = Rate::default();
            let sizes = after(&mut rate, fixed, pixels, 600);
            assert!(
                sizes[300..].iter().all(|size| expected.contains(size)),
                "{fixed} {pixels}: {sizes:?}"
            );
        }
    }

    #[test]
    fn a_hitch_changes_nothing_and_time_gives_pixels_back() {
        let mut rate = Rate::default();
        for _ in 0..50 {
            after(&mut rate, 0.1, 0.5, 20);
            after(&mut rate, 3.0, 0.5, 2);
        }
        assert_eq!(rate.sixteenths, 16);
        let down = after(&mut rate, 0.0, 2.0, 60);
        assert_eq!(down.last(), Some(&10));
        let up = after(&mut rate, 0.0, 0.5, 2000);
        assert!(up.is_sorted() && up.last() == Some(&16));
    }

    /// A runtime that shows each picture twice while they are late.
    #[test]
    fn a_period_that_doubles_is_still_the_old_one() {
        let mut rate = Rate::default();
        after(&mut rate, 0.1, 0.5, 20);
        for _ in 0..40 {
            rate.take(PERIOD.mul_f64(1.9), 2 * PERIOD);
        }
        assert_eq!(rate.sixteenths, 10);
        // Another rate of the screen's, slower by less than twice, is another period.
        for _ in 0..2000 {
            rate.take(PERIOD.mul_f64(0.3), PERIOD.mul_f64(1.25));
        }
        assert_eq!((rate.sixteenths, rate.period), (16, PERIOD.mul_f64(1.25)));
    }

    #[test]
    fn a_part_has_whole_pixels() {
        let all = vk::Extent2D {
            width: 1832,
            height: 1919,
        };
        let mut rate = Rate::default();
        assert_eq!(rate.part_of(all), all);
        rate.set(10);
        let part = rate.part_of(all);
        assert_eq!((part.width, part.height), (1145, 1200));
        let most = vk::Extent2D {
            width: u32::MAX,
            height: 0,
        };
        assert!(rate.part_of(most).width < u32::MAX && rate.part_of(most).height == 0);
    }

    proptest! {
        /// Whatever a device says: there is a size, and a steady load has one in the end.
        #[test]
        fn it_settles(fixed in 0.0_f64..3.0, pixels in 0.0_f64..5.0, nonsense in any::<[u64; 4]>()) {
            let mut rate = Rate::default();
            for nanos in nonsense {
                rate.take(Duration::from_nanos(nanos), Duration::from_nanos(nanos % 3));
            }
            let sizes = after(&mut rate, fixed, pixels, 2500);
            let (low, high) = sizes[1500..].iter().fold((WHOLE, LEAST), |(low, high), size| (low.min(*size), high.max(*size)));
            prop_assert!((LEAST..=WHOLE).contains(&low) && high == low, "{low} to {high}");
        }
    }
}
