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
/// Colour of all signs, linear: dark, as the scale bars are.
const COLOR: Color = [0.02, 0.03, 0.06, 1.0];
/// Thickness of strokes, in heights.
const STROKE: f32 = 0.055;

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
                    scene.rods.push(Rod {
                        from,
                        to,
                        radius: height * STROKE,
                        color: COLOR,
                    });
                }
            }
        }
        at += right * step;
    }
}
