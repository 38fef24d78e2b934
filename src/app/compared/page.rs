//! A page of plots: each quantity of all trees, one curve over the other, and the trees' barcodes.

use crate::app::plot::{Anchor, Axis, COLOURS, GRID, INK, PALE, Svg, density, shortened, wrapped};
use crate::tree::compare::barcode::Bar;
use crate::tree::compare::samples::Apart;
use crate::tree::compare::told::About;
use crate::tree::compare::{Pair, Studied};
use crate::world::comparing::Plot;

/// A plot's place with what is around it, and what is around it: left, top, right, bottom.
const SIZE: [f64; 2] = [236.0, 168.0];
const MARGINS: [f64; 4] = [14.0, 36.0, 10.0, 24.0];
/// Plots beside each other.
const PER_ROW: usize = 4;
/// Above the plots, with one line of names.
const HEAD: f64 = 34.0;
const LEGEND_LINE: f64 = 16.0;
/// How many times as high as the flattest curve's peak others are drawn.
const PEAKS: f64 = 6.0;
/// Bars of a tree that are drawn, the longest.
const BARS_MOST: usize = 200;

/// The colour of a tree, as it is written in SVG.
pub(super) fn ink(tree: usize) -> &'static str {
    COLOURS[tree % COLOURS.len()]
}

/// A curve: where it is, 0 to 1, and how high, in parts of the same for all of a plot.
type Curve = Vec<[f64; 2]>;

/// How a quantity is spread in each tree: curves of the same area, from 0 to 1 high, with marks at places along.
pub(in crate::app) fn curves(trees: &[Studied], sample: usize) -> Option<Plot> {
    let values = |tree: &Studied| tree.samples[sample].values.clone();
    let all: Vec<Vec<f64>> = trees.iter().map(values).collect();
    let axis = axis(trees, sample)?;
    let mut curves: Vec<Curve> = all
        .into_iter()
        .map(|values| {
            let shown: Vec<f64> = values.into_iter().map(|value| axis.shown(value)).collect();
            // What is all one value is a line to the top.
            let alone = shown.first().map(|value| axis.part(*value));
            let shape = density(shown);
            match (alone, shape.is_empty()) {
                (Some(part), true) => vec![[part, 0.0], [part, f64::INFINITY]],
                _ => of_one_area(
                    shape
                        .into_iter()
                        .map(|(at, high)| [axis.part(at), high])
                        .collect(),
                ),
            }
        })
        .collect();
    let highest = |curve: &Curve| curve.iter().map(|[_, high]| *high).fold(0.0, f64::max);
    let peaks = || {
        curves
            .iter()
            .map(highest)
            .filter(|peak| *peak > 0.0 && peak.is_finite())
    };
    let lowest = peaks().fold(f64::INFINITY, f64::min);
    let top = peaks().fold(0.0, f64::max).min(PEAKS * lowest);
    let top = if top > 0.0 { top } else { 1.0 };
    for point in curves.iter_mut().flatten() {
        point[1] = (point[1] / top).min(1.0);
    }
    // Down to the axis at both ends, so that the narrowest curve is seen.
    for curve in &mut curves {
        let ends = [curve.first(), curve.last()].map(|end| end.map(|[part, _]| [*part, 0.0]));
        if let [Some(first), Some(last)] = ends {
            curve.insert(0, first);
            curve.push(last);
        }
    }
    Some(Plot {
        name: trees[0].samples[sample].name,
        curves,
        marks: axis.marks(),
    })
}

/// The axis of a quantity of all trees; angles and shares are never shown by their logarithms.
fn axis(trees: &[Studied], sample: usize) -> Option<Axis> {
    let samples = || trees.iter().filter_map(|tree| tree.samples.get(sample));
    let has_unit = samples().any(|sample| sample.power != 0);
    let values: Vec<f64> = samples()
        .flat_map(|sample| sample.values.iter().copied())
        .collect();
    Axis::around(values.into_iter(), has_unit)
}

fn of_one_area(mut curve: Curve) -> Curve {
    let area: f64 = curve
        .windows(2)
        .map(|pair| (pair[1][0] - pair[0][0]) * f64::midpoint(pair[0][1], pair[1][1]))
        .sum();
    for point in curve.iter_mut().filter(|_| area > 0.0) {
        point[1] /= area;
    }
    curve
}

/// What is told of a quantity of two trees.
pub(super) fn told(apart: &Apart) -> String {
    let Some(d) = apart.d else {
        return "one has none".to_owned();
    };
    match apart.tested {
        Some(tested) => {
            let p = tested.ks_p[1].min(tested.mann_whitney[2]);
            let p = match p {
                p if p < 0.001 => "p < 0.001".to_owned(),
                p => format!("p = {p:.3}"),
            };
            let is_told = if apart.is_told() { ", told apart" } else { "" };
            format!("D = {d:.2}, {p}{is_told}")
        }
        None => format!("D = {d:.2}"),
    }
}

/// The page, as SVG.
pub fn page(about: &[About], trees: &[Studied], pairs: &[Pair]) -> String {
    let mut svg = Svg::default();
    let width = PER_ROW as f64 * SIZE[0] + 24.0;
    let head = HEAD + legend(&mut svg, about, width);
    let samples = trees.first().map_or(0, |tree| tree.samples.len());
    let corner = |place: usize, top: f64| {
        let [column, row] = [place % PER_ROW, place / PER_ROW];
        [12.0 + column as f64 * SIZE[0], top + row as f64 * SIZE[1]]
    };
    let rows = |plots: usize| plots.div_ceil(PER_ROW) as f64 * SIZE[1];
    let one = (trees.len() == 2).then(|| pairs.first()).flatten();
    for sample in 0..samples {
        let said = one.map(|pair| told(&pair.distributions[sample]));
        distribution(&mut svg, trees, sample, corner(sample, head), said);
    }
    let below = head + rows(samples);
    let longest = trees
        .iter()
        .flat_map(|tree| &tree.bars[0])
        .map(|bar| bar.end);
    let longest = longest.fold(0.0, f64::max);
    for (place, (about, tree)) in about.iter().zip(trees).enumerate() {
        barcode(
            &mut svg,
            about,
            &tree.bars[0],
            longest,
            (place, corner(place, below)),
        );
    }
    let foot = [
        "Curves: how values are spread in each tree, of the same area, high peaks cut; lengths in each tree's own unit. Bars: where each tip's branch leaves a farther one, and where it ends, along the way from the root (Kanari et al. 2018); the longest 200 at most.",
        "D: largest difference of both distributions (Kolmogorov and Smirnov); p: the smaller of that test's and of Mann and Whitney's, corrected by Holm. Branches of one tree are no independent draws: a small p alone says little.",
    ];
    let mut y = below + rows(trees.len()) + 14.0;
    for line in foot
        .iter()
        .flat_map(|line| wrapped(line, (width - 24.0) / 4.6))
    {
        svg.text([18.0, y], 9.0, Anchor::Start, PALE, &line);
        y += 12.0;
    }
    svg.finish(width, y)
}

/// The trees' colours and names; says how much higher it is than one line.
fn legend(svg: &mut Svg, about: &[About], width: f64) -> f64 {
    let [mut x, mut y] = [18.0, 12.0];
    for (place, one) in about.iter().enumerate() {
        let name = shortened(&one.name, 40);
        let wide = 30.0 + 6.0 * name.chars().count() as f64;
        if x > 18.0 && x + wide > width {
            [x, y] = [18.0, y + LEGEND_LINE];
        }
        svg.square([x, y], 9.0, ink(place));
        svg.text([x + 13.0, y + 8.0], 10.0, Anchor::Start, INK, &name);
        x += wide;
    }
    y - 12.0
}

/// A plot's frame: its title and what is told; gives its inner corner and extent.
fn frame(
    svg: &mut Svg,
    title: &str,
    said: Option<String>,
    [x, y]: [f64; 2],
) -> ([f64; 2], [f64; 2]) {
    let [left, top, right, bottom] = MARGINS;
    let letters: String = title
        .chars()
        .take(1)
        .flat_map(char::to_uppercase)
        .chain(title.chars().skip(1))
        .collect();
    svg.text([x + 6.0, y + top - 18.0], 9.5, Anchor::Start, INK, &letters);
    if let Some(said) = said {
        svg.text([x + 6.0, y + top - 7.0], 8.5, Anchor::Start, PALE, &said);
    }
    (
        [x + left, y + top],
        [SIZE[0] - left - right, SIZE[1] - top - bottom],
    )
}

fn distribution(
    svg: &mut Svg,
    trees: &[Studied],
    sample: usize,
    at: [f64; 2],
    said: Option<String>,
) {
    let ([x, y], [wide, high]) = frame(svg, trees[0].samples[sample].words, said, at);
    let base = y + high;
    let middle = x + wide / 2.0;
    match curves(trees, sample) {
        None => svg.text(
            [middle, y + high / 2.0],
            9.0,
            Anchor::Middle,
            PALE,
            "nothing to show",
        ),
        Some(Plot { curves, marks, .. }) => {
            for (part, told) in marks {
                let at = x + part * wide;
                svg.line([at, y], [at, base], GRID, 0.75);
                svg.text([at, base + 11.0], 8.0, Anchor::Middle, INK, &told);
            }
            for (place, curve) in curves.iter().enumerate() {
                let spot = |[part, up]: &[f64; 2]| [x + part * wide, base - up * high];
                let points: Vec<[f64; 2]> = curve.iter().map(spot).collect();
                if !points.is_empty() {
                    svg.area(&points, ink(place));
                }
            }
        }
    }
    svg.line([x, base], [x + wide, base], INK, 0.75);
}

fn barcode(
    svg: &mut Svg,
    about: &About,
    bars: &[Bar],
    longest: f64,
    (place, at): (usize, [f64; 2]),
) {
    let title = format!("barcode of {}", shortened(&about.name, 26));
    let said = format!("{} bars", bars.len());
    let ([x, y], [wide, high]) = frame(svg, &title, Some(said), at);
    let mut shown: Vec<&Bar> = bars.iter().collect();
    shown.sort_by(|a, b| b.length().total_cmp(&a.length()));
    shown.truncate(BARS_MOST);
    shown.sort_by(|a, b| a.start.total_cmp(&b.start).then(b.end.total_cmp(&a.end)));
    let step = high / shown.len().max(1) as f64;
    let axis = Axis::around([0.0, longest].into_iter(), false);
    let part = |value: f64| axis.map_or(0.0, |axis| axis.part(axis.shown(value)));
    for (part, told) in axis.map(|axis| axis.marks()).unwrap_or_default() {
        let at = x + part * wide;
        svg.line([at, y], [at, y + high], GRID, 0.75);
        svg.text([at, y + high + 11.0], 8.0, Anchor::Middle, INK, &told);
    }
    for (number, bar) in shown.into_iter().enumerate() {
        let level = y + (number as f64 + 0.5) * step;
        let ends = [bar.start, bar.end].map(|end| [x + part(end) * wide, level]);
        svg.line(ends[0], ends[1], ink(place), (0.7 * step).clamp(0.4, 3.0));
    }
    svg.line([x, y + high], [x + wide, y + high], INK, 0.75);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn curves_are_of_one_area() {
        let triangle = vec![[0.0, 0.0], [0.5, 3.0], [1.0, 0.0]];
        assert_eq!(of_one_area(triangle)[1], [0.5, 2.0]);
        assert_eq!(of_one_area(Vec::new()), Curve::new());
    }
}
