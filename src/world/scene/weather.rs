//! Light and wind on the stage: what a person may set, and how far the wind moves a place.
//!
//! Sway is a function of a place at rest and of time and of nothing else, so that rings at a joint, leaves on their twig and all levels of detail of a
//! tree move alike. [`Sway::at`] is the twin of shaders/shared/wind.wgsl. Boughs lean downwind by their height over the tree's root squared, as a beam does
//! that is held at one end; gusts run over the stage as a few slow waves; twigs shake besides, the more the farther they are from the root's vertical. All waves
//! go a whole number of times into [`PERIOD`], so that the clock can begin anew unseen, and a session of any length has the same precision.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// By which light everything is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Light {
    /// A high sun in a blue sky.
    #[default]
    Day,
    /// A low warm sun, long soft shadows.
    Evening,
    /// A large lamp, a fill and a rim before a neutral backdrop.
    Studio,
}

impl Light {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Day, Self::Evening, Self::Studio];

    /// What it is called on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Day => "day",
            Self::Evening => "evening",
            Self::Studio => "studio",
        }
    }
}

/// How strongly it blows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Wind {
    /// Not at all: what moves by itself can make people sick.
    #[default]
    Still,
    /// Leaves flutter, twigs nod.
    Breeze,
    /// Boughs bend.
    Strong,
}

impl Wind {
    /// All, from none on.
    pub const ALL: [Self; 3] = [Self::Still, Self::Breeze, Self::Strong];

    /// As a part of the strongest.
    #[must_use]
    pub fn strength(self) -> f32 {
        match self {
            Self::Still => 0.0,
            Self::Breeze => 0.35,
            Self::Strong => 1.0,
        }
    }
}

/// Seconds after which the wind's clock begins anew, at the pace of 1.
pub const PERIOD: f64 = 256.0;

/// Seconds in which the wind gets up or dies down for the most part.
const EASE: f64 = 0.8;

/// What is weaker than this is still.
const LEAST: f32 = 1e-3;

/// A frame is never longer than this for the wind, seconds.
const LONGEST: f64 = 0.1;

/// The wind as it gets up, dies down and goes on from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gusts {
    strength: f32,
    clock: f64,
    last: Option<f64>,
}

impl Gusts {
    /// How things sway at a time of the session in seconds, the wind being set like this.
    pub fn blow(&mut self, wind: Wind, time: f64) -> Sway {
        let target = wind.strength();
        let passed = self.last.map_or(0.0, |last| time - last);
        let seconds = if passed > 0.0 {
            passed.min(LONGEST)
        } else {
            0.0
        };
        self.last = Some(time);
        #[allow(clippy::cast_possible_truncation, reason = "0 to 1")]
        let nearer = (1.0 - (-seconds / EASE).exp()) as f32;
        self.strength += (target - self.strength) * nearer;
        if (target - self.strength).abs() < LEAST {
            self.strength = target;
        }
        // Stronger wind is faster, too.
        let pace = 0.8 + 0.6 * f64::from(self.strength);
        self.clock = (self.clock + seconds * pace / PERIOD).fract();
        #[allow(clippy::cast_possible_truncation, reason = "0 to 1")]
        let clock = self.clock as f32;
        Sway {
            strength: self.strength,
            clock,
        }
    }
}

/// How the wind moves things at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sway {
    /// 0, not at all, to 1.
    pub strength: f32,
    /// Of [`PERIOD`], 0 to 1.
    pub clock: f32,
}

/// Where to it blows, and across that; x and z.
const ALONG: Vec2 = Vec2::new(0.937, 0.349);
const ACROSS: Vec2 = Vec2::new(-0.349, 0.937);
/// How far boughs lean at most, of their height, and twigs shake, of their distance from the root's vertical.
const LEAN: f32 = 0.09;
const SHAKE: f32 = 0.05;
/// Below such heights and distances, metres, they go by the square.
const STIFF_HEIGHT: f32 = 0.6;
const STIFF_REACH: f32 = 0.5;
const SHELTERED: f32 = 0.4;
/// A leaf's turn about each of its axes at most, radians.
const FLUTTER: f32 = 0.35;

/// By its square where it is small, then as it is.
fn bent(length: f32, stiff: f32) -> f32 {
    length * length / (length + stiff)
}

impl Sway {
    /// Whether anything moves.
    #[must_use]
    pub fn moves(self) -> bool {
        self.strength > 0.0
    }

    /// How far a place of a tree is from where it rests, metres; `root`: where the tree stands.
    #[must_use]
    pub fn at(self, place: Vec3, root: Vec3) -> Vec3 {
        if !self.moves() {
            return Vec3::ZERO;
        }
        let wave = |phase: f32, times: f32| (phase - TAU * (times * self.clock).fract()).sin();
        let level = Vec2::new(place.x, place.z);
        let height = (place.y - root.y).max(0.0);
        let reach = level.distance(Vec2::new(root.x, root.z));
        let (along, across) = (level.dot(ALONG), level.dot(ACROSS));
        let gust = 0.62
            + 0.26 * wave(0.9 * along, 41.0)
            + 0.12 * wave(2.1 * along + 0.7 * across + 1.3, 97.0);
        let swing = 0.22 * wave(0.6 * height + 0.5 * across, 151.0);
        let aside = 0.20 * wave(0.8 * along + 0.4 * height + 0.5, 113.0);
        let lean = (ALONG * (gust + swing) + ACROSS * aside)
            * (LEAN * self.strength * bent(height, STIFF_HEIGHT));
        // As far along the bough as before: what leans aside comes down.
        let drop = 0.5 * lean.length_squared() / height.max(1e-4);
        let shake =
            SHAKE * self.strength * gust * bent(reach, STIFF_REACH) * height / (height + SHELTERED);
        let up = shake * wave(2.3 * along + 1.7 * across + 1.1 * place.y, 211.0);
        let side = shake * 0.6 * wave(1.9 * across - 2.7 * along + 1.3 * place.y + 2.0, 263.0);
        let moved = lean + ALONG * side;
        Vec3::new(moved.x, up - drop, moved.y)
    }

    /// No place is farther than this from where it rests, metres: of a tree that is so high and reaches so far aside.
    #[must_use]
    pub fn most(self, height: f32, reach: f32) -> f32 {
        if !self.moves() {
            return 0.0;
        }
        let (height, reach) = (height.max(0.0), reach.max(0.0));
        let lean = LEAN * self.strength * 1.22_f32.hypot(0.20);
        lean * bent(height, STIFF_HEIGHT)
            + 0.5 * lean * lean * height
            + SHAKE * self.strength * bent(reach, STIFF_REACH) * 1.0_f32.hypot(0.6)
    }

    /// No corner of a leaf is moved by its flutter farther than this, of the leaf's length.
    #[must_use]
    pub fn flutter(self) -> f32 {
        FLUTTER * self.strength * 3.0_f32.sqrt()
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    const ROOT: Vec3 = Vec3::new(0.4, 0.2, -3.0);

    fn places() -> impl Iterator<Item = Vec3> {
        (0_u16..600).map(|at| {
            let turn = f32::from(at) * 2.4;
            let reach = f32::from(at % 23) * 0.1;
            let height = f32::from(at % 41) * 0.1;
            ROOT + Vec3::new(turn.cos() * reach, height, turn.sin() * reach)
        })
    }

    fn moments() -> impl Iterator<Item = f32> {
        (0_u16..256).map(|at| f32::from(at) / 256.0)
    }

    #[test]
    fn nothing_sways_at_the_ground_or_in_still_air() {
        for clock in moments() {
            let strong = Sway {
                strength: 1.0,
                clock,
            };
            for place in places() {
                let still = Sway {
                    strength: 0.0,
                    clock,
                };
                assert_eq!(still.at(place, ROOT), Vec3::ZERO);
                let below = place.with_y(ROOT.y - (place.y - ROOT.y));
                assert_eq!(strong.at(below, ROOT), Vec3::ZERO, "{below}");
            }
        }
        assert_eq!(Sway::default().most(100.0, 100.0), 0.0);
    }

    #[test]
    fn sway_is_bounded_and_grows_with_height() {
        let (mut low, mut high) = (0.0_f32, 0.0_f32);
        for clock in moments() {
            for strength in [0.35, 1.0] {
                let sway = Sway { strength, clock };
                for place in places() {
                    let moved = sway.at(place, ROOT).length();
                    let height = place.y - ROOT.y;
                    let reach = (place - ROOT).with_y(0.0).length();
                    assert!(moved <= sway.most(height, reach), "{place} at {clock}");
                    let highest = if height < 1.0 { &mut low } else { &mut high };
                    *highest = highest.max(moved);
                }
            }
        }
        // Strong wind moves what is four metres high by some decimetres.
        assert!((0.2..0.6).contains(&high), "{high}");
        assert!(low < 0.3 * high, "{low} of {high}");
    }

    #[test]
    fn neighbours_move_alike_and_so_do_moments() {
        const STEP: f32 = 1e-3;
        for clock in moments() {
            let sway = |clock| Sway {
                strength: 1.0,
                clock,
            };
            for place in places().step_by(7) {
                let here = sway(clock).at(place, ROOT);
                for aside in [Vec3::X, Vec3::Y, Vec3::Z] {
                    let there = sway(clock).at(place + aside * STEP, ROOT);
                    assert!(there.distance(here) < 0.6 * STEP, "{place} {aside}");
                }
                // A ninetieth of a second.
                #[allow(clippy::cast_possible_truncation, reason = "small")]
                let later = clock + (1.4 / 90.0 / PERIOD) as f32;
                assert!(sway(later).at(place, ROOT).distance(here) < 0.02);
            }
        }
    }

    #[test]
    fn the_clock_begins_anew_unseen() {
        for place in places().step_by(5) {
            let at = |clock| {
                let sway = Sway {
                    strength: 1.0,
                    clock,
                };
                sway.at(place, ROOT)
            };
            assert!(at(0.0).distance(at(1.0)) < 1e-3);
        }
    }

    #[test]
    fn the_wind_gets_up_and_dies_down_without_a_jump() {
        let mut gusts = Gusts::default();
        let mut time = 0.0;
        let mut last = gusts.blow(Wind::Still, time);
        assert_eq!(last, Sway::default());
        for (wind, seconds) in [(Wind::Strong, 8), (Wind::Breeze, 8), (Wind::Still, 8)] {
            for _ in 0..seconds * 90 {
                time += 1.0 / 90.0;
                let now = gusts.blow(wind, time);
                assert!((now.strength - last.strength).abs() < 0.02, "{now:?}");
                last = now;
            }
            assert_eq!(last.strength, wind.strength(), "{wind:?}");
        }
        assert!(!last.moves());
        // Time that goes back, or far ahead, is no jump.
        let now = gusts.blow(Wind::Still, time - 100.0);
        let then = gusts.blow(Wind::Still, time + 1e6);
        assert_eq!(now.clock, last.clock);
        assert!((then.clock - now.clock).abs() < 0.001);
    }
}
