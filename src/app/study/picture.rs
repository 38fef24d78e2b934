//! A report as one picture (SVG): usability by conditions, and sickness before and after, each person a pale line, means dark.

use std::collections::HashMap;

use super::Study;
use super::report::{Condition, Report};
use super::summary::Summary;
use crate::app::plot::{Anchor, Svg};
use crate::world::study::score::{Factor, Part, Ssq};

const INK: &str = "#1a1a1a";
const PALE: &str = "#8a8a8a";
const GRID: &str = "#e6e6e6";
/// By Okabe and Ito (2008): usability, sickness.
const COLOURS: [&str; 2] = ["#0072b2", "#d55e00"];
/// Height of a plot, and where it begins.
const HEIGHT: f64 = 260.0;
const TOP: f64 = 64.0;
/// Left of a plot's first column, and the width of one.
const LEFT: f64 = 54.0;
const COLUMN: f64 = 96.0;
/// Between two plots.
const GAP: f64 = 40.0;
/// Steps of an axis at most.
const STEPS: f64 = 6.0;

/// A line of points, a place along the axis of each column; none where there is no value.
type Row = Vec<Option<f64>>;

/// A plot: columns, what persons have in them, and the means.
struct Plot {
    title: String,
    columns: Vec<String>,
    persons: Vec<Row>,
    means: Row,
    most: f64,
    colour: &'static str,
}

/// Draws it.
pub fn picture(study: &Study, report: &Report) -> String {
    let mut plots = Vec::new();
    plots.extend(usability(report));
    plots.extend(sickness(study, report));
    let mut svg = Svg::default();
    let mut left = 0.0;
    for plot in &plots {
        left = draw(&mut svg, plot, left) + GAP;
    }
    let people = report.participants.len();
    let told = format!("{people} participants; pale lines are persons, dark points means");
    svg.text([12.0, 20.0], 12.0, Anchor::Start, INK, &told);
    svg.finish(left.max(420.0), TOP + HEIGHT + 56.0)
}

fn mean(summary: Option<Summary>) -> Option<f64> {
    Some(summary?.mean)
}

/// Scores of each participant under each condition.
fn usability(report: &Report) -> Option<Plot> {
    let conditions = &report.conditions;
    let means: Row = conditions
        .iter()
        .map(|one| Some(one.sus.as_ref()?.summary.mean))
        .collect();
    means.iter().any(Option::is_some).then_some(())?;
    let scored = report.conditions.iter().flat_map(|one| {
        let scores = one.sus.iter().flat_map(|sus| &sus.scores);
        scores.map(|found| {
            (
                (found.participant.as_str(), one.condition.as_str()),
                found.score,
            )
        })
    });
    let scored: HashMap<(&str, &str), f64> = scored.collect();
    let persons = report.participants.iter().map(|participant| {
        let of = |one: &Condition| {
            let key = (participant.as_str(), one.condition.as_str());
            scored.get(&key).copied()
        };
        conditions.iter().map(of).collect()
    });
    Some(Plot {
        title: "System Usability Scale".to_owned(),
        columns: conditions.iter().map(|one| one.condition.clone()).collect(),
        persons: persons.collect(),
        means,
        most: 100.0,
        colour: COLOURS[0],
    })
}

/// Of each condition and factor: before and after.
fn sickness(study: &Study, report: &Report) -> Vec<Plot> {
    let mut plots = Vec::new();
    for condition in report.conditions.iter().filter(|one| !one.ssq.is_empty()) {
        let sittings = study.sittings.iter();
        let of = sittings.filter(|one| one.condition == condition.condition);
        let sums: Vec<[Option<Ssq>; 2]> = of
            .map(|one| {
                [Part::SsqBefore, Part::SsqAfter].map(|part| Ssq::of(&one.whole(part).ok()?))
            })
            .collect();
        let most = sums
            .iter()
            .flatten()
            .flatten()
            .flat_map(|sums| Factor::ALL.map(|factor| sums.score(factor)))
            .fold(20.0, f64::max);
        for found in &condition.ssq {
            let person = |sums: &[Option<Ssq>; 2]| {
                let score = |sums: &Option<Ssq>| sums.map(|sums| sums.score(found.factor));
                sums.iter().map(score).collect()
            };
            plots.push(Plot {
                title: format!("SSQ {}, {}", found.factor.name(), condition.condition),
                columns: vec!["before".to_owned(), "after".to_owned()],
                persons: sums.iter().map(person).collect(),
                means: vec![mean(found.before), mean(found.after)],
                most,
                colour: COLOURS[1],
            });
        }
    }
    plots
}

/// A round step, so that few of them reach `most`.
fn step(most: f64) -> f64 {
    let sizes = [5.0, 10.0, 20.0, 25.0, 50.0];
    let fits = sizes.into_iter().find(|size| most / size <= STEPS);
    fits.unwrap_or(100.0)
}

/// Draws a plot from a place on; gives where it ends.
fn draw(svg: &mut Svg, plot: &Plot, from: f64) -> f64 {
    let left = from + LEFT;
    let right = left + COLUMN * plot.columns.len() as f64;
    let step = step(plot.most);
    let top = (plot.most / step).ceil() * step;
    let height = |value: f64| TOP + HEIGHT * (1.0 - value / top);
    svg.text(
        [from + 12.0, TOP - 18.0],
        12.0,
        Anchor::Start,
        INK,
        &plot.title,
    );
    let mut value = 0.0;
    while value <= top {
        let y = height(value);
        svg.line([left, y], [right, y], GRID, 1.0);
        svg.text(
            [left - 6.0, y + 3.5],
            10.0,
            Anchor::End,
            PALE,
            &format!("{value}"),
        );
        value += step;
    }
    let across = |column: usize| left + COLUMN * (column as f64 + 0.5);
    for (column, name) in plot.columns.iter().enumerate() {
        svg.text(
            [across(column), TOP + HEIGHT + 18.0],
            11.0,
            Anchor::Middle,
            INK,
            name,
        );
    }
    for person in &plot.persons {
        for (column, pair) in person.windows(2).enumerate() {
            if let [Some(a), Some(b)] = pair {
                let [a, b] = [(column, a), (column + 1, b)];
                svg.line(
                    [across(a.0), height(*a.1)],
                    [across(b.0), height(*b.1)],
                    "#bdbdbd",
                    1.0,
                );
            }
        }
        for (column, value) in person.iter().enumerate() {
            if let Some(value) = value {
                svg.dot([across(column), height(*value)], 3.0, PALE);
            }
        }
    }
    for (column, mean) in plot.means.iter().enumerate() {
        let Some(mean) = mean else { continue };
        let at = [across(column), height(*mean)];
        svg.dot(at, 5.5, plot.colour);
        svg.text(
            [at[0] + 9.0, at[1] - 6.0],
            11.0,
            Anchor::Start,
            plot.colour,
            &format!("{mean:.1}"),
        );
    }
    right
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::step;

    #[test]
    fn axes_have_few_steps() {
        for (most, expected) in [
            (20.0, 5.0),
            (100.0, 20.0),
            (55.68, 10.0),
            (292.32, 50.0),
            (1e3, 100.0),
        ] {
            assert_eq!(step(most), expected, "{most}");
        }
    }
}
