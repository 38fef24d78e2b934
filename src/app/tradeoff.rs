//! The curve of a grammar's size against its error, as SVG.

use super::plot::{Anchor, Svg};
use crate::abstraction::exact::Point;

const SIZE: [f64; 2] = [520.0, 340.0];
/// Around the plot: left, top, right, bottom.
const MARGINS: [f64; 4] = [64.0, 44.0, 18.0, 58.0];
const SHARED: &str = "#0072b2";
const PLAIN: &str = "#d55e00";
const INK: &str = "#1a1a1a";
const GRID: &str = "#e6e6e6";

/// A logarithmic axis between powers of ten.
struct Decades {
    first: f64,
    last: f64,
}

impl Decades {
    fn around(numbers: impl Iterator<Item = f64>) -> Self {
        let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
        for decade in numbers.filter(|one| *one > 0.0).map(f64::log10) {
            (first, last) = (first.min(decade.floor()), last.max(decade.ceil()));
        }
        match first < last {
            true => Self { first, last },
            // One power of ten, or nothing at all.
            false if first.is_finite() => Self {
                first,
                last: first + 1.0,
            },
            false => Self {
                first: 0.0,
                last: 1.0,
            },
        }
    }

    /// 0 at the lower end, 1 at the upper; what is not above zero is at the lower.
    fn part(&self, number: f64) -> f64 {
        let decade = number.log10().max(self.first);
        (decade - self.first) / (self.last - self.first)
    }

    fn marks(&self) -> impl Iterator<Item = f64> {
        let count = (self.last - self.first).clamp(0.0, 40.0);
        let first = self.first;
        (0..)
            .map(f64::from)
            .take_while(move |at| *at <= count)
            .map(move |at| 10.0_f64.powf(first + at))
    }
}

/// Modules and parameters against the error, as a part of the tree's size.
pub fn svg(name: &str, size: f64, points: &[Point]) -> String {
    let percent = |point: &Point| 100.0 * point.error.max / size;
    let across = Decades::around(points.iter().map(percent));
    let symbols = points.iter().flat_map(|point| [point.size, point.plain]);
    let up = Decades::around(symbols.map(|size| number(size.symbols())));
    let [left, top, right, bottom] = MARGINS;
    let [width, height] = [SIZE[0] - left - right, SIZE[1] - top - bottom];
    let x = |value: f64| left + width * across.part(value);
    let y = |value: f64| top + height * (1.0 - up.part(value));
    let mut svg = Svg::default();
    for mark in up.marks() {
        svg.line([left, y(mark)], [left + width, y(mark)], GRID, 1.0);
        svg.text(
            [left - 6.0, y(mark) + 3.5],
            10.0,
            Anchor::End,
            INK,
            &mark.to_string(),
        );
    }
    for mark in across.marks() {
        svg.line([x(mark), top], [x(mark), top + height], GRID, 1.0);
        let label = format!("{mark} %");
        svg.text(
            [x(mark), top + height + 14.0],
            10.0,
            Anchor::Middle,
            INK,
            &label,
        );
    }
    for (colour, of) in [
        (
            PLAIN,
            (|point| point.plain.symbols()) as fn(&Point) -> usize,
        ),
        (SHARED, |point| point.size.symbols()),
    ] {
        let places: Vec<[f64; 2]> = points
            .iter()
            .map(|point| [x(percent(point)), y(number(of(point)))])
            .collect();
        for pair in places.windows(2) {
            svg.line(pair[0], pair[1], colour, 1.5);
        }
        for place in places {
            svg.dot(place, 3.5, colour);
        }
    }
    svg.text(
        [left, 18.0],
        12.0,
        Anchor::Start,
        INK,
        &format!("{name}: size of the grammar against its error"),
    );
    svg.square([left, 26.0], 9.0, SHARED);
    svg.text([left + 13.0, 34.0], 10.0, Anchor::Start, INK, "grammar");
    svg.square([left + 76.0, 26.0], 9.0, PLAIN);
    svg.text(
        [left + 89.0, 34.0],
        10.0,
        Anchor::Start,
        INK,
        "each segment of the tree written out",
    );
    let below = top + height + 30.0;
    let middle = left + width / 2.0;
    svg.text(
        [middle, below],
        10.0,
        Anchor::Middle,
        INK,
        "largest distance between center lines, of the tree's size",
    );
    svg.text(
        [middle, below + 15.0],
        10.0,
        Anchor::Middle,
        INK,
        "upwards: modules and parameters; each point was drawn by its grammar and measured",
    );
    svg.finish(SIZE[0], SIZE[1])
}

fn number(count: usize) -> f64 {
    count as f64
}
