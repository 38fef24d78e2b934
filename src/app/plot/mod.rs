//! What plots have in common: colours, axes, distributions' shapes, and SVG to write them in.
//!
//! Colours are those of Okabe and Ito, which people tell apart however they see colours. Written as SVG by ourselves: it is lines and text, and
//! the drawing crates would bring more than they save.

mod axis;
mod svg;

pub(crate) use self::axis::Axis;
pub(crate) use self::svg::{Anchor, Svg};
use crate::tree::measure::{quantile, spread};

/// By Okabe and Ito (2008), without yellow, which is too pale for points.
pub(crate) const COLOURS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#595959",
];
pub(crate) const INK: &str = "#1a1a1a";
pub(crate) const PALE: &str = "#6b6b6b";
pub(crate) const GRID: &str = "#e6e6e6";
/// Heights at which the shape of a distribution is drawn, and bins that it is counted in.
const SHAPE_STEPS: usize = 64;
const SHAPE_BINS: usize = 256;

/// Lines of so many letters at most, if no word is longer.
pub(crate) fn wrapped(text: &str, letters: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.len() - 1;
        let together = lines[last].chars().count() + 1 + word.chars().count();
        match lines[last].is_empty() {
            true => lines[last] = word.to_owned(),
            false if together as f64 <= letters => lines[last] += &format!(" {word}"),
            false => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A text of so many letters at most.
pub(crate) fn shortened(text: &str, letters: usize) -> String {
    match text.chars().count() > letters {
        true => text.chars().take(letters - 1).chain(['…']).collect(),
        false => text.to_owned(),
    }
}

/// How thick a distribution is at steps from its lowest value to its highest: a sum of bells, as wide as Silverman's rule has it.
pub(crate) fn density(mut shown: Vec<f64>) -> Vec<(f64, f64)> {
    shown.retain(|value| value.is_finite());
    shown.sort_by(f64::total_cmp);
    let (Some(low), Some(high)) = (shown.first().copied(), shown.last().copied()) else {
        return Vec::new();
    };
    let of_all = spread(shown.iter().copied());
    let quartiles = [0.25, 0.75].map(|part| quantile(&shown, part).unwrap_or(low));
    let robust = (quartiles[1] - quartiles[0]) / 1.34;
    let width = if robust > 0.0 {
        of_all.std.min(robust)
    } else {
        of_all.std
    };
    let bin = (high - low) / SHAPE_BINS as f64;
    let bell = (0.9 * width * (shown.len() as f64).powf(-0.2)).max(bin);
    if !(bell.is_finite() && bell > 0.0) {
        return Vec::new();
    }
    let mut bins = [0.0_f64; SHAPE_BINS];
    let mut next = shown.iter().peekable();
    for (place, count) in bins.iter_mut().enumerate() {
        let end = low + bin * (place + 1) as f64;
        let is_last = place + 1 == SHAPE_BINS;
        while next.next_if(|value| is_last || **value < end).is_some() {
            *count += 1.0;
        }
    }
    (0..=SHAPE_STEPS)
        .map(|step| {
            let at = low + (high - low) * (step as f64 / SHAPE_STEPS as f64);
            let sum: f64 = bins
                .iter()
                .enumerate()
                .map(|(place, count)| {
                    let from = (low + bin * (place as f64 + 0.5) - at) / bell;
                    count * (-from * from / 2.0).exp()
                })
                .sum();
            (at, sum)
        })
        .collect()
}
