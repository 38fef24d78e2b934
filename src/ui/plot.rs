//! Plots on panels: bars of how often, and a line of what is along a way. Painted by hand: two plots that nobody drags or zooms need no library for them.

use std::ops::Range;

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Sense, Stroke, Ui, vec2};

use super::theme::{INK, SMALLEST};
use crate::mesh::colour::Ramp;
use crate::mesh::unit::Rounded;
use crate::world::branches::LIT;
use crate::world::comparing::Plot;

/// Height of a plot without its numbers, points.
const HEIGHT: f32 = 90.0;
/// Bars at most.
const BARS_MOST: usize = 24;
/// Whole numbers that are no farther apart than this have a bar each.
const BARS_WIDE: f32 = 23.5;
const GROUND: Color32 = Color32::from_rgb(12, 15, 17);
const LINE: Color32 = Color32::from_rgb(86, 180, 233);

/// How many of some numbers lie in each of as many equally wide steps between two numbers; those outside are in the first and the last.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Histogram {
    /// Numbers at both ends.
    pub(super) range: [f32; 2],
    /// Whether each step is a whole number's, in its middle.
    whole: bool,
    /// How many in each step.
    pub(super) counts: Vec<u32>,
}

impl Histogram {
    /// Of the numbers that are finite; about as many steps as the root of how many they are, and one for each where they are few whole ones.
    pub(super) fn of(numbers: &[f32]) -> Option<Self> {
        let finite = || numbers.iter().copied().filter(|number| number.is_finite());
        let [low, high] = crate::world::lines::range(numbers, Ramp::Rising)?;
        let count = finite().count();
        let whole = finite().all(|number| number.fract() == 0.0);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "held between 1 and 24"
        )]
        let steps = match whole && high - low < BARS_WIDE {
            true => (high - low) as usize + 1,
            false => ((count as f32).sqrt().ceil() as usize).clamp(1, BARS_MOST),
        };
        // A whole number is the middle of its step.
        let few = whole && high - low < BARS_WIDE;
        let [low, high] = match few {
            true => [low - 0.5, high + 0.5],
            false if high > low => [low, high],
            false => [low - 0.5, low + 0.5],
        };
        let mut counts = vec![0; steps];
        for number in finite() {
            if let Some(count) = counts.get_mut(step(number, [low, high], steps)) {
                *count += 1;
            }
        }
        Some(Self {
            range: [low, high],
            whole: few,
            counts,
        })
    }
}

/// In which step a number lies.
fn step(number: f32, [low, high]: [f32; 2], steps: usize) -> usize {
    #[expect(clippy::cast_precision_loss, reason = "a handful of steps")]
    let at = (number - low) / (high - low) * steps as f32;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "it saturates, and is held below"
    )]
    let at = at.max(0.0) as usize;
    at.min(steps.saturating_sub(1))
}

/// A plot's ground; numbers stand at its corners.
fn ground(ui: &mut Ui) -> Rect {
    let width = ui.available_width();
    let (place, _) = ui.allocate_exact_size(vec2(width, HEIGHT + 2.0 * SMALLEST), Sense::hover());
    let ground = Rect::from_min_max(
        place.min + vec2(0.0, SMALLEST),
        place.max - vec2(0.0, SMALLEST),
    );
    ui.painter().rect_filled(ground, 2.0, GROUND);
    ground
}

fn write(ui: &Ui, at: Pos2, align: Align2, text: String) {
    ui.painter()
        .text(at, align, text, FontId::proportional(SMALLEST), INK);
}

/// Bars of how often, in the colours that the numbers have on the model.
pub(super) fn bars(
    ui: &mut Ui,
    histogram: &Histogram,
    ramp: Ramp,
    unit: &str,
    chosen: Option<f32>,
) {
    let ground = ground(ui);
    let most = histogram.counts.iter().copied().max().unwrap_or(0).max(1);
    let [low, high] = histogram.range;
    let about = low.abs().max(high.abs());
    let steps = histogram.counts.len();
    let lit = chosen.filter(|number| number.is_finite());
    let lit = lit.map(|number| step(number, histogram.range, steps));
    #[expect(clippy::cast_precision_loss, reason = "a handful of bars")]
    let width = ground.width() / steps.max(1) as f32;
    for (at, count) in histogram.counts.iter().enumerate() {
        #[expect(clippy::cast_precision_loss, reason = "what is drawn")]
        let (left, part) = (at as f32 * width, *count as f32 / most as f32);
        let middle = (left + width * 0.5) / ground.width();
        let part_of_scale = match ramp {
            Ramp::Rising => middle,
            Ramp::AboutZero => (low + (high - low) * middle + about) / (2.0 * about),
        };
        let [red, green, blue, _] = ramp.colour(part_of_scale);
        let bar = Rect::from_min_max(
            ground.left_bottom() + vec2(left + 1.0, -part * ground.height()),
            ground.left_bottom() + vec2(left + width - 1.0, 0.0),
        );
        let colour = Color32::from_rgb(red, green, blue);
        ui.painter().rect_filled(bar, 0.0, colour);
        if lit == Some(at) {
            let foot = Rect::from_min_max(bar.left_bottom(), bar.right_bottom() + vec2(0.0, 4.0));
            ui.painter().rect_filled(foot, 0.0, lit_colour());
        }
    }
    write(ui, ground.left_top(), Align2::LEFT_BOTTOM, most.to_string());
    let inwards = if histogram.whole { 0.5 } else { 0.0 };
    let numbers = [low + inwards, high - inwards].map(f64::from);
    ends(ui, ground, numbers, unit);
}

fn ends(ui: &Ui, ground: Rect, [low, high]: [f64; 2], unit: &str) {
    let low = Rounded(low).to_string();
    write(
        ui,
        ground.left_bottom() + vec2(0.0, 3.0),
        Align2::LEFT_TOP,
        low,
    );
    let high = format!("{} {unit}", Rounded(high));
    write(
        ui,
        ground.right_bottom() + vec2(0.0, 3.0),
        Align2::RIGHT_TOP,
        high,
    );
}

/// A line from left to right through places, from zero up; those in `lit` stand out.
pub(super) fn line(ui: &mut Ui, places: &[[f64; 2]], lit: &Range<usize>, unit: &str) {
    let ground = ground(ui);
    let far = places.last().map_or(0.0, |[far, _]| *far);
    let most = places.iter().map(|[_, up]| *up).fold(0.0, f64::max);
    #[expect(clippy::cast_possible_truncation, reason = "what is drawn")]
    let part = |value: f64, of: f64| (value / of.max(f64::MIN_POSITIVE)) as f32;
    let at = |[along, up]: &[f64; 2]| {
        let [x, y] = [part(*along, far), part(*up, most)];
        ground.left_bottom() + vec2(x * ground.width(), -y * (ground.height() - 2.0))
    };
    // More than two a point are not told apart.
    let every = places.len().div_ceil(800).max(1);
    let thinned = |places: &[[f64; 2]]| -> Vec<Pos2> {
        let last = places.last().into_iter();
        places.iter().step_by(every).chain(last).map(at).collect()
    };
    let painter = ui.painter();
    painter.line(thinned(places), Stroke::new(1.5, LINE));
    if let Some(own) = places.get(lit.clone()) {
        painter.line(thinned(own), Stroke::new(3.0, lit_colour()));
    }
    let top = format!("{} {unit}", Rounded(most));
    write(ui, ground.left_top(), Align2::LEFT_BOTTOM, top);
    ends(ui, ground, [0.0, far], unit);
}

/// How a quantity is spread in some trees, one curve over the other in their inks, with marks below in the ink of letters; `size`: of letters, points.
pub(crate) fn spread(
    painter: &Painter,
    plot: Rect,
    size: f32,
    shown: &Plot,
    (inks, letters): (&[Color32], Color32),
) {
    #[expect(clippy::cast_possible_truncation, reason = "what is drawn")]
    let spot = |[part, up]: [f64; 2]| {
        let [x, y] = [part as f32 * plot.width(), up as f32 * plot.height()];
        plot.left_bottom() + vec2(x, -y)
    };
    let step = shown.marks.len().div_ceil(4).max(1);
    for (part, said) in shown.marks.iter().step_by(step) {
        let at = spot([*part, 0.0]);
        let tick = [at, at + vec2(0.0, size * 0.25)];
        painter.line_segment(tick, Stroke::new(1.0, letters));
        let (below, font) = (
            at + vec2(0.0, size * 0.35),
            FontId::proportional(size * 0.8),
        );
        painter.text(below, Align2::CENTER_TOP, said, font, letters);
    }
    for (curve, ink) in shown.curves.iter().zip(inks) {
        let pale = Color32::from_rgba_unmultiplied(ink.r(), ink.g(), ink.b(), 46);
        for pair in curve.windows(2) {
            let foot = |at: [f64; 2]| spot([at[0], 0.0]);
            let corners = [spot(pair[0]), spot(pair[1]), foot(pair[1]), foot(pair[0])];
            let mut piece = egui::Mesh::default();
            for (number, corner) in (0_u32..).zip(corners) {
                piece.colored_vertex(corner, pale);
                if number > 1 {
                    piece.add_triangle(0, number - 1, number);
                }
            }
            painter.add(piece);
        }
        let line: Vec<Pos2> = curve.iter().map(|at| spot(*at)).collect();
        let stroke = Stroke::new((size * 0.12).max(1.0), *ink);
        painter.add(egui::Shape::line(line, stroke));
    }
    let base = [plot.left_bottom(), plot.right_bottom()];
    painter.line_segment(base, Stroke::new(1.0, letters));
}

/// The colour in which a branch is lit.
pub(super) fn lit_colour() -> Color32 {
    let [red, green, blue, _] = LIT;
    egui::Rgba::from_rgb(red, green, blue).into()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "each shows the figures")]
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn bars_count_what_there_is() {
        let of = |numbers: &[f32]| Histogram::of(numbers).map(|bars| (bars.range, bars.counts));
        assert_eq!(of(&[]), None);
        assert_eq!(of(&[f32::NAN, f32::INFINITY]), None);
        // Whole numbers have a bar each, also where there are none of them.
        let few = [1.0, 1.0, 4.0, 2.0, f32::NAN];
        assert_eq!(of(&few), Some(([0.5, 4.5], vec![2, 1, 0, 1])));
        assert_eq!(of(&[3.0]), Some(([2.5, 3.5], vec![1])));
        // All the same, and not whole.
        assert_eq!(of(&[0.25; 4]), Some(([-0.25, 0.75], vec![0, 4])));
        let wide = [0.5, 0.6, 1.0, 2.5];
        assert_eq!(of(&wide), Some(([0.5, 2.5], vec![3, 1])));
    }

    proptest! {
        #[test]
        fn every_number_is_in_one_bar(numbers in prop::collection::vec(-1e6_f32..1e6, 1..400)) {
            let bars = Histogram::of(&numbers).unwrap_or_default();
            prop_assert!(bars.counts.len() <= BARS_MOST);
            prop_assert_eq!(bars.counts.iter().sum::<u32>() as usize, numbers.len());
            let [low, high] = bars.range;
            let own = |at: usize| numbers.iter().filter(|number| step(**number, [low, high], bars.counts.len()) == at).count();
            for (at, count) in bars.counts.iter().enumerate() {
                prop_assert_eq!(own(at), *count as usize);
            }
        }
    }
}
