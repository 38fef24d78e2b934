//! Panels in the stage, laid out by egui: state and pointers in, wishes and painted triangles out.
//!
//! `ui` knows neither Vulkan (`render` paints the triangles) nor headsets (`world` says where hands point on a panel), and
//! changes nothing itself: what a person wants is a [`Wish`], which the application carries out. The
//! [`board`] is read; the panels ([`Panels`]) are used: the [`bench`](self) with everything that can be set, the
//! few things on the back of a hand, the keyboard, and the line beside a handle. [`words`] has all
//! strings, one file a language.

use egui::epaint::{ClippedPrimitive, textures::TexturesDelta};

mod abstraction;
mod bench;
pub mod board;
mod compare;
mod keyboard;
mod lesson;
mod lines;
mod marks;
mod models;
mod panels;
mod planting;
pub(crate) mod plot;
mod previews;
mod projects;
mod rules;
pub mod sheet;
mod species;
mod study;
mod theme;
pub mod words;

pub use board::BoardUi;
pub use panels::{
    AbstractionWish, CompareWish, LineWish, Panels, Recent, Settings, Thumbnail, View, Wish,
};
pub use previews::{Preview, Previews};

/// How densely boards are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutParams {
    /// Pixels of the panel's image for each metre of the board.
    pub pixels_per_metre: f32,
    /// Pixels for each of egui's points: the size of text.
    pub pixels_per_point: f32,
}

impl Default for LayoutParams {
    /// At a metre's distance a line of the board is about 1.2° high (rendering.md §5 asks for 1°–1.5°).
    fn default() -> Self {
        Self {
            pixels_per_metre: 1280.0,
            pixels_per_point: 2.0,
        }
    }
}

/// A laid out panel, ready for the renderer. The receiver applies `textures` before it paints.
#[derive(Debug)]
pub struct Painted {
    /// Width and height of the panel's image in pixels.
    pub size_px: [u32; 2],
    /// Pixels for each of egui's points, in which the primitives are given.
    pub pixels_per_point: f32,
    /// The triangles, back to front.
    pub primitives: Vec<ClippedPrimitive>,
    /// Changed textures (glyphs), to be applied before painting.
    pub textures: TexturesDelta,
}

/// Rounds a pixel count up and holds it within what every device can make an image of.
fn whole_pixels(pixels: f32) -> u32 {
    const LARGEST: f32 = 4096.0;
    let held = if pixels.is_finite() {
        pixels.ceil().clamp(1.0, LARGEST)
    } else {
        1.0
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held between 1 and 4096 just above"
    )]
    let whole = held as u32;
    whole
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "the assertions speak for themselves"
    )]
    use super::*;

    #[test]
    fn absurd_sizes_are_held() {
        for (pixels, expected) in [
            (f32::NAN, 1),
            (-4.0, 1),
            (f32::INFINITY, 1),
            (1e9, 4096),
            (10.2, 11),
        ] {
            assert_eq!(whole_pixels(pixels), expected, "{pixels}");
        }
    }
}
