//! Short texts on the stage, such as lengths, written with rods: they stand where they belong, at any size, and need no panel.
//!
//! A sign turns about the vertical towards the person and is as large as they need to read it.

use std::fmt::{Arguments, Write};

use glam::Vec3;

use super::scene::{Color, Rod, Scene};

/// Height of a sign's signs as a part of how far it is from the head: 1.3 degrees.
const HEIGHT: f32 = 0.0227;
/// Nobody is nearer to a sign than this, metres.
const NEAREST: f32 = 0.3;
/// Colours, linear: dark strokes on light ones that stand a little behind them, so that a sign is read before anything.
const COLORS: [Color; 2] = [[0.02, 0.03, 0.06, 1.0], [0.85, 0.85, 0.80, 1.0]];
/// Thickness of the dark strokes and the light ones, in heights.
const STROKES: [f32; 2] = [0.055, 0.11];
/// How far the light ones stand behind, in heights.
const BEHIND: f32 = 0.12;

/// A sign's strokes as lines through places of a grid, 0 to 4 to the right and 0 to 6 upwards: two digits a place, a space between lines; and how far on
/// the next sign begins.
fn strokes(sign: char) -> (&'static str, f32) {
    match sign {
        '0' => ("103041453616050110", 5.5),
        '1' => ("152620", 4.0),
        '2' => ("05163645440040", 5.5),
        '3' => ("05163645443323 334241301001", 5.5),
        '4' => ("30360242", 5.5),
        '5' => ("4606043443413000", 5.5),
        '6' => ("36160501103041423303", 5.5),
        '7' => ("064610", 5.5),
        '8' => ("13040516364544331302011030414233", 5.5),
        '9' => ("10304145361605041343", 5.5),
        '.' => ("1011", 2.6),
        '-' => ("1333", 4.5),
        '°' => ("1516262515", 4.0),
        'm' => ("0004 03142320 23344340", 5.6),
        'c' => ("3324140301102031", 4.6),
        'n' => ("0004 0314243330", 4.6),
        'µ' => ("0400 0110203134 3130", 4.6),
        'e' => ("023233241403011030", 4.8),
        _ => ("", 3.0),
    }
}

/// A text of at most so many bytes, so that a frame can write numbers without memory.
struct Short {
    bytes: [u8; 48],
    len: usize,
}

impl Write for Short {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        let end = self.len + text.len();
        let room = self.bytes.get_mut(self.len..end).ok_or(std::fmt::Error)?;
        room.copy_from_slice(text.as_bytes());
        self.len = end;
        Ok(())
    }
}

/// Writes a text above a place, in the middle, to be read from `head`; what is longer than 48 bytes ends there.
pub(super) fn write(text: Arguments<'_>, above: Vec3, head: Vec3, scene: &mut Scene) {
    let mut short = Short {
        bytes: [0; 48],
        len: 0,
    };
    // Too long: as far as it goes.
    let _ = short.write_fmt(text);
    let text = std::str::from_utf8(short.bytes.get(..short.len).unwrap_or_default());
    let text = text.unwrap_or_default();
    let to_head = head - above;
    let height = to_head.length().max(NEAREST) * HEIGHT;
    let level = Vec3::new(to_head.x, 0.0, to_head.z).normalize_or(Vec3::Z);
    let (right, up) = (
        Vec3::Y.cross(level) * (height / 6.0),
        Vec3::Y * (height / 6.0),
    );
    if !(right.is_finite() && above.is_finite()) {
        return;
    }
    let width: f32 = text.chars().map(|sign| strokes(sign).1).sum();
    let mut at = above + up * 3.0 - right * (width / 2.0);
    for sign in text.chars() {
        let (lines, step) = strokes(sign);
        let place = |pair: &[u8]| match *pair {
            [x, y] => {
                let [x, y] = [x, y].map(|digit| f32::from(digit.saturating_sub(b'0')));
                Some(at + right * x + up * y)
            }
            _ => None,
        };
        for line in lines.split_ascii_whitespace() {
            let pairs = line.as_bytes().chunks_exact(2);
            for (from, to) in pairs.clone().zip(pairs.skip(1)) {
                if let (Some(from), Some(to)) = (place(from), place(to)) {
                    for ((color, stroke), back) in
                        COLORS.into_iter().zip(STROKES).zip([0.0, BEHIND])
                    {
                        let back = level * (back * height);
                        scene.rods.push(Rod {
                            from: from - back,
                            to: to - back,
                            radius: height * stroke,
                            color,
                        });
                    }
                }
            }
        }
        at += right * step;
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    fn written(text: &str, above: Vec3, head: Vec3) -> Vec<Rod> {
        let mut scene = Scene::default();
        write(format_args!("{text}"), above, head, &mut scene);
        scene.rods
    }

    #[test]
    fn every_sign_that_lengths_and_angles_need_has_strokes() {
        for sign in "0123456789.-e°mcnµ".chars() {
            let rods = written(&sign.to_string(), Vec3::ZERO, Vec3::Z);
            assert!(!rods.is_empty(), "{sign}");
        }
        assert!(written(" ", Vec3::ZERO, Vec3::Z).is_empty());
    }

    #[test]
    fn a_sign_is_read_from_left_to_right_and_large_enough() {
        // From before it, and from its right side.
        for (head, right) in [(Vec3::Z * 2.0, Vec3::X), (Vec3::X * 2.0, Vec3::NEG_Z)] {
            let rods = written("1 8", Vec3::ZERO, head);
            let at = |rod: &Rod| rod.from.dot(right);
            let first = rods.first().map_or(0.0, at);
            let last = rods.last().map_or(0.0, at);
            assert!(first < 0.0 && last > 0.0, "{first} {last}");
            let heights = rods.iter().map(|rod| rod.from.y.max(rod.to.y));
            let (low, high) = (
                rods.iter().map(|rod| rod.from.y).fold(f32::MAX, f32::min),
                heights.fold(0.0, f32::max),
            );
            let angle = ((high - low) / 2.0).atan().to_degrees();
            assert!((1.0..1.5).contains(&angle), "{angle}");
        }
    }

    #[test]
    fn what_is_too_long_or_nowhere_is_no_trouble() {
        let long = "8".repeat(500);
        assert!(written(&long, Vec3::ZERO, Vec3::Z).len() <= 48 * 40);
        assert!(written("8", Vec3::NAN, Vec3::Z).is_empty());
        let above = written("8", Vec3::ZERO, Vec3::Y);
        assert!(above.iter().all(|rod| rod.from.is_finite()));
    }
}
