//! What a stick or a touchpad says on controllers that have nothing better: its sides undo and redo, its top grows, its bottom steps back.

use glam::Vec2;

/// Pushed so far it counts,
const PUSHED: f32 = 0.7;
/// and counts until it is back here: a hand trembles.
const RELEASED: f32 = 0.4;

/// What a controller says of one frame; `None` where it has no such part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Said {
    /// The stick or where the touchpad is touched, −1 to 1 each.
    pub(crate) stick: Vec2,
    /// Its height again, where it grows and steps back.
    pub(crate) step: Option<f32>,
    /// Whether the touchpad is pressed, where a touch alone does nothing.
    pub(crate) press: Option<bool>,
}

/// What that means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Meant {
    /// What is left for undo and redo.
    pub(crate) stick: Vec2,
    /// Grows.
    pub(crate) lower: bool,
    /// Steps back.
    pub(crate) upper: bool,
}

/// One hand's, from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Directions {
    /// 1: grows, −1: steps back.
    held: f32,
}

impl Directions {
    /// What a frame means.
    pub(crate) fn meant(&mut self, said: Said) -> Meant {
        if said.press == Some(false) {
            self.held = 0.0;
            return Meant::default();
        }
        let Some(step) = said.step else {
            return Meant {
                stick: said.stick,
                ..Meant::default()
            };
        };
        // A direction holds until it is left, whatever the other axis says meanwhile.
        let up = step
            * if self.held == 0.0 {
                step.signum()
            } else {
                self.held
            };
        let goes_on = self.held != 0.0 && up > RELEASED;
        let begins = self.held == 0.0 && up > PUSHED && step.abs() > said.stick.x.abs();
        if begins {
            self.held = step.signum();
        } else if !goes_on {
            self.held = 0.0;
        }
        let sideways = self.held == 0.0 && said.stick.x.abs() >= step.abs();
        Meant {
            stick: if sideways { said.stick } else { Vec2::ZERO },
            lower: self.held > 0.0,
            upper: self.held < 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the tables name their rows")]
    use super::*;

    /// A stick that grows, at a place.
    fn stick(x: f32, y: f32) -> Said {
        Said {
            stick: Vec2::new(x, y),
            step: Some(y),
            press: None,
        }
    }

    /// A touchpad, touched there and pressed or not.
    fn pad(x: f32, y: f32, pressed: bool) -> Said {
        Said {
            press: Some(pressed),
            ..stick(x, y)
        }
    }

    /// What the frames mean, as letters: `+` grows, `-` steps back, `<` and `>` sideways, `.` nothing.
    fn told(frames: &[Said]) -> String {
        let mut directions = Directions::default();
        let letter = |meant: Meant| match meant {
            Meant { lower: true, .. } => '+',
            Meant { upper: true, .. } => '-',
            Meant { stick, .. } if stick.x > 0.5 => '>',
            Meant { stick, .. } if stick.x < -0.5 => '<',
            _ => '.',
        };
        frames
            .iter()
            .map(|said| letter(directions.meant(*said)))
            .collect()
    }

    #[test]
    fn sides_and_ends_are_told_apart() {
        for (frames, expected) in [
            (
                vec![
                    stick(0.0, 0.6),
                    stick(0.0, 0.8),
                    stick(0.0, 0.5),
                    stick(0.0, 0.3),
                ],
                ".++.",
            ),
            (
                vec![
                    stick(0.0, -0.8),
                    stick(0.0, -0.5),
                    stick(0.0, 0.9),
                    stick(0.0, 0.9),
                ],
                "--.+",
            ),
            // One push trembles, and is one push.
            (
                vec![stick(0.0, 0.71), stick(0.0, 0.69), stick(0.0, 0.71)],
                "+++",
            ),
            (vec![stick(0.9, 0.2), stick(-0.9, 0.2)], "><"),
            // Askew: whichever is more; a push that began goes on.
            (
                vec![stick(0.8, 0.75), stick(0.75, 0.8), stick(0.8, 0.75)],
                ">++",
            ),
            (
                vec![
                    pad(0.0, 0.9, false),
                    pad(0.0, 0.9, true),
                    pad(0.0, 0.9, false),
                ],
                ".+.",
            ),
            (
                vec![
                    pad(0.9, 0.0, false),
                    pad(0.9, 0.0, true),
                    pad(-0.9, 0.1, true),
                ],
                ".><",
            ),
        ] {
            assert_eq!(told(&frames), expected, "{frames:?}");
        }
    }

    #[test]
    fn a_stick_beside_buttons_is_a_stick() {
        let said = Said {
            stick: Vec2::new(0.1, 0.9),
            ..Said::default()
        };
        let meant = Directions::default().meant(said);
        assert_eq!(
            meant,
            Meant {
                stick: said.stick,
                ..Meant::default()
            }
        );
    }
}
