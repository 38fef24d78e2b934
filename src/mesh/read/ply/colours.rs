//! Colours at the vertices: `red green blue`, and `alpha` where it is there, in bytes, shorts or floats.
//!
//! The format does not say what the numbers mean. Programs write what a screen shows (sRGB), whole numbers from 0 to the largest, floats
//! from 0 to 1; alpha is a part of one.

use super::header::{Element, Number, Property};
use crate::mesh::paint::VertexColour;
use crate::mesh::srgb::{LINEAR, linear, short};

/// Where the channels of a colour are in a row, and what is 1 in each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channels {
    /// Red, green, blue and alpha.
    pub(super) places: [Option<usize>; 4],
    ones: [f64; 4],
}

impl Channels {
    /// The colours of an element, if it has any.
    pub(super) fn of(element: &Element) -> Option<Self> {
        ["", "diffuse_"].into_iter().find_map(|prefix| {
            let mut channels = Self {
                places: [None; 4],
                ones: [1.0; 4],
            };
            for (at, name) in ["red", "green", "blue", "alpha"].into_iter().enumerate() {
                let found = element.place(format!("{prefix}{name}").as_bytes());
                let one = found.and_then(|place| one(element.properties.get(place)?));
                if let Some(one) = one {
                    channels.places[at] = found;
                    channels.ones[at] = one;
                }
            }
            let has_all = channels.places[..3].iter().all(Option::is_some);
            has_all.then_some(channels)
        })
    }

    /// The colour of which these are the numbers.
    #[inline]
    pub(super) fn colour(&self, values: [f64; 4]) -> VertexColour {
        let mut colour = [u16::MAX; 4];
        for (at, to) in colour.iter_mut().enumerate() {
            if self.places[at].is_none() {
                continue;
            }
            let value = values[at];
            *to = match self.ones[at] {
                one if at == 3 => short(value / one),
                255.0 => LINEAR[usize::from(byte(value))],
                one => short(linear(value / one)),
            };
        }
        colour
    }
}

/// What is 1 in a property; None where it is no channel.
fn one(property: &Property) -> Option<f64> {
    match property {
        Property::Scalar(Number::U8) => Some(255.0),
        Property::Scalar(Number::U16) => Some(65_535.0),
        Property::Scalar(Number::F32 | Number::F64) => Some(1.0),
        _ => None,
    }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0 to 255 by its type, and `as` saturates"
)]
fn byte(value: f64) -> u8 {
    value as u8
}
