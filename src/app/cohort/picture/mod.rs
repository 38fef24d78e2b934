//! Pages of small plots: each measure of models by groups, and how branches are spread in each group.
//!
//! Models are points over a box of quartiles, as readers of biology expect. Branches are shown as the shape of their distribution, with
//! the mean of each model as a point upon it ("SuperPlots", Lord et al. 2020), so that nobody counts branches as if they were models. Colours
//! are those of Okabe and Ito, which people tell apart however they see colours. Written as SVG by ourselves: it is lines and text, and
//! the drawing crates would bring more than they save.

mod axis;
pub(in crate::app) mod svg;

use self::axis::Axis;
use self::svg::{Anchor, Svg};
use super::comparison::{Comparison, values};
use super::measures::{LENGTH, Measure, of_branches, of_models};
use super::told::{Branch, Definition};
use super::{Cohort, Model};
use crate::app::table::Column;
use crate::mesh::unit::Unit;
use crate::tree::measure::{quantile, spread};

/// By Okabe and Ito (2008), without yellow, which is too pale for points.
const COLOURS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#595959",
];
const INK: &str = "#1a1a1a";
const PALE: &str = "#6b6b6b";
const GRID: &str = "#e6e6e6";
/// Plots beside each other.
const PER_ROW: usize = 5;
/// Around a plot: left, top, right, bottom.
const MARGINS: [f64; 4] = [44.0, 36.0, 8.0, 32.0];
/// How high a plot is within its margins, and how wide for each group, at least.
const HEIGHT: f64 = 118.0;
const PER_GROUP: f64 = 49.0;
const WIDTH_LEAST: f64 = 128.0;
/// Above the plots, with one line of groups.
const HEAD: f64 = 34.0;
const LEGEND_LINE: f64 = 16.0;
/// Values from which on a box is drawn; fewer have a line at their median.
const BOX_FROM: usize = 5;
/// Points of a group at most; of more, those beyond the whiskers are shown.
const POINTS_MOST: usize = 200;
/// Heights at which the shape of a distribution is drawn, and bins that it is counted in.
const SHAPE_STEPS: usize = 64;
const SHAPE_BINS: usize = 256;
/// What branches are on a page.
const DEFINITIONS: &str = "Branches are whole, from junction to junction or to the root or a tip, where nothing else is written; VMTK's branches are outside bifurcations, which begin one sphere before a line leaves another's tube.";

/// What a plot shows of a group.
struct Group {
    points: Vec<f64>,
    /// The values behind them, whose shape is drawn; empty where points are all.
    behind: Vec<f64>,
}

/// A plot.
struct Plot {
    title: String,
    /// Of which branches it is, and what tests say, in a few words.
    told: Option<String>,
    may_be_logarithmic: bool,
    groups: Vec<Group>,
    /// What stands under each group.
    counts: Vec<String>,
}

/// The page of models.
pub(super) fn models(cohort: &Cohort, comparisons: &[Comparison]) -> String {
    let measures = of_models();
    let plots = measures
        .iter()
        .filter(|measure| measure.compared)
        .map(|measure| {
            let groups: Vec<Group> = shown_groups(cohort)
                .map(|group| Group {
                    points: values(cohort, group, measure),
                    behind: Vec::new(),
                })
                .collect();
            Plot {
                title: title(cohort, &measure.column),
                told: below_title(cohort, comparisons, &measure.column),
                may_be_logarithmic: false,
                counts: groups
                    .iter()
                    .map(|group| format!("n = {}", group.points.len()))
                    .collect(),
                groups,
            }
        });
    let mut foot = vec![
        "Points: models. Boxes: quartiles and median, whiskers to the farthest model within 1.5 interquartile ranges; with fewer than five models the median alone.".to_owned(),
    ];
    if let [a, b] = cohort.groups.as_slice() {
        foot.push(format!(
            "δ: Cliff's delta, above zero where {a} is larger than {b}; p: Mann–Whitney test, corrected by Holm for all measures of both definitions."
        ));
    }
    foot.push(DEFINITIONS.to_owned());
    page(cohort, plots.collect(), &foot)
}

/// The page of branches, of both definitions.
pub(super) fn branches(cohort: &Cohort) -> String {
    let mut plots = Vec::new();
    for definition in Definition::ALL {
        for measure in of_branches().iter().filter(|measure| measure.compared) {
            let plot = branches_plot(cohort, definition, measure);
            // By VMTK's definition not all measures are told.
            let is_told = plot.groups.iter().any(|group| !group.behind.is_empty());
            if is_told || definition == Definition::Whole {
                plots.push(plot);
            }
        }
    }
    let foot = [
        "Shapes: how branches are spread (n: branches, and of how many models); points: the mean of each model's branches; bars: quartiles and median of branches.".to_owned(),
        "Branches of one model are not independent of each other: groups are compared by models.".to_owned(),
        DEFINITIONS.to_owned(),
    ];
    page(cohort, plots, &foot)
}

/// How branches of a definition are spread.
fn branches_plot(cohort: &Cohort, definition: Definition, measure: &Measure<Branch>) -> Plot {
    let groups: Vec<Group> = shown_groups(cohort)
        .map(|group| branches_of(cohort, group, definition, measure))
        .collect();
    let counts = groups
        .iter()
        .map(|group| format!("n = {} ({})", group.behind.len(), group.points.len()));
    Plot {
        title: title(cohort, &measure.column),
        told: of_vmtk(definition.name()).map(str::to_owned),
        may_be_logarithmic: true,
        counts: counts.collect(),
        groups,
    }
}

/// The groups; all models where there are none.
fn shown_groups(cohort: &Cohort) -> impl Iterator<Item = Option<usize>> {
    let groups = cohort.groups.len();
    let all = (groups == 0).then_some(None);
    (0..groups).map(Some).chain(all)
}

fn branches_of(
    cohort: &Cohort,
    group: Option<usize>,
    definition: Definition,
    measure: &Measure<Branch>,
) -> Group {
    let models = cohort
        .models
        .iter()
        .filter(|model| group.is_none() || model.group == group);
    let mut of_group = Group {
        points: Vec::new(),
        behind: Vec::new(),
    };
    for facts in models.filter_map(Model::facts) {
        let first = of_group.behind.len();
        let branches = facts.branches_of(definition).iter();
        let values = branches.filter_map(|branch| measure.number(branch));
        of_group.behind.extend(values);
        let mean = spread(of_group.behind[first..].iter().copied());
        of_group
            .points
            .extend((mean.n > 0 && mean.mean.is_finite()).then_some(mean.mean));
    }
    of_group
}

/// A column's name as words, with its unit.
fn title(cohort: &Cohort, column: &Column) -> String {
    let name = column.name.replace("_deg", "");
    let name = name
        .strip_prefix(Definition::Vmtk.prefix())
        .unwrap_or(&name);
    let (name, part) = match name.rsplit_once('_') {
        Some((first, part @ ("mean" | "max"))) => (first, format!(", {part}")),
        Some((first, "std")) => (first, ", standard deviation".to_owned()),
        _ => (name, String::new()),
    };
    let words = name.replace('_', " ");
    let mut letters = words.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    let unit = match column.unit {
        "" => String::new(),
        "degrees" => " (°)".to_owned(),
        unit => format!(" ({})", unit.replace(LENGTH, unit_of(cohort))),
    };
    format!(
        "{}{}{part}{unit}",
        first.unwrap_or_default(),
        letters.as_str()
    )
}

/// The unit of all models, where they have one.
fn unit_of(cohort: &Cohort) -> &'static str {
    let mut units = cohort
        .models
        .iter()
        .filter_map(Model::facts)
        .map(|facts| facts.model.unit);
    let first = units.next().flatten();
    match first.filter(|_| units.all(|unit| unit == first)) {
        Some(unit) => Unit::symbol(unit),
        None => "model unit",
    }
}

/// What is told of a definition that is not that of whole branches.
fn of_vmtk(definition: &str) -> Option<&'static str> {
    (definition == Definition::Vmtk.name()).then_some("VMTK's branches")
}

/// Of which branches a measure is, and what the test of two groups says.
fn below_title(cohort: &Cohort, comparisons: &[Comparison], column: &Column) -> Option<String> {
    let parts = [
        of_vmtk(column.definition).map(str::to_owned),
        told(cohort, comparisons, column),
    ];
    let told: Vec<String> = parts.into_iter().flatten().collect();
    (!told.is_empty()).then(|| told.join("; "))
}

/// What the test of two groups says of a measure.
fn told(cohort: &Cohort, comparisons: &[Comparison], column: &Column) -> Option<String> {
    if cohort.groups.len() != 2 {
        return None;
    }
    let comparison = comparisons.iter().find(|one| one.measure == *column)?;
    Some(match &comparison.tested {
        Some(tested) => {
            let delta = format!("{:.2}", tested.delta).replace('-', "−");
            format!("δ = {delta}, {}", p(tested.ranks_corrected[0]))
        }
        None => "not tested".to_owned(),
    })
}

/// A p as papers have it.
fn p(value: f64) -> String {
    match value {
        _ if value < 0.001 => "p < 0.001".to_owned(),
        _ if value < 0.1 => format!("p = {value:.3}"),
        _ => format!("p = {value:.2}"),
    }
}

fn page(cohort: &Cohort, plots: Vec<Plot>, foot: &[String]) -> String {
    let mut svg = Svg::default();
    let groups = cohort.groups.len().max(1);
    let inner = WIDTH_LEAST.max(PER_GROUP * groups as f64);
    let [left, top, right, bottom] = MARGINS;
    let [wide, high] = [left + inner + right, top + HEIGHT + bottom];
    let per_row = per_row(plots.len(), wide);
    let rows = plots.len().div_ceil(per_row);
    let width = per_row as f64 * wide + 2.0 * right;
    let head = HEAD + legend(&mut svg, cohort, right + 6.0, width);
    for (place, plot) in plots.iter().enumerate() {
        let x = right + (place % per_row) as f64 * wide + left;
        let y = head + (place / per_row) as f64 * high + top;
        draw(&mut svg, plot, [x, y], inner, cohort);
    }
    let mut y = head + rows as f64 * high + 16.0;
    for line in foot {
        for line in wrapped(line, ((width - 24.0) / 4.6).max(40.0)) {
            svg.text([right + 6.0, y], 9.0, Anchor::Start, PALE, &line);
            y += 12.0;
        }
    }
    svg.finish(width, y)
}

/// The groups' colours and names; says how much higher it is than one line.
fn legend(svg: &mut Svg, cohort: &Cohort, left: f64, width: f64) -> f64 {
    let [mut x, mut y] = [left, 12.0];
    for (place, name) in cohort.groups.iter().enumerate() {
        let name = shortened(name, 40);
        let wide = 30.0 + 6.0 * name.chars().count() as f64;
        if x > left && x + wide > width {
            [x, y] = [left, y + LEGEND_LINE];
        }
        svg.square([x, y], 9.0, colour(place));
        svg.text([x + 13.0, y + 8.0], 10.0, Anchor::Start, INK, &name);
        x += wide;
    }
    y - 12.0
}

/// How many plots of a width stand beside each other: as many as narrow ones would, in rows of the same length.
fn per_row(plots: usize, wide: f64) -> usize {
    let [left, _, right, _] = MARGINS;
    let room = PER_ROW as f64 * (WIDTH_LEAST + left + right);
    let most = (1..=PER_ROW)
        .rev()
        .find(|count| *count as f64 * wide <= room);
    let rows = plots.max(1).div_ceil(most.unwrap_or(1));
    plots.max(1).div_ceil(rows)
}

/// Lines of so many letters at most, if no word is longer.
fn wrapped(text: &str, letters: f64) -> Vec<String> {
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

fn shortened(text: &str, letters: usize) -> String {
    match text.chars().count() > letters {
        true => text.chars().take(letters - 1).chain(['…']).collect(),
        false => text.to_owned(),
    }
}

fn colour(group: usize) -> &'static str {
    COLOURS[group % COLOURS.len()]
}

/// Draws a plot whose upper left corner, within its margins, is at a place.
fn draw(svg: &mut Svg, plot: &Plot, [x, y]: [f64; 2], wide: f64, cohort: &Cohort) {
    let [left, ..] = MARGINS;
    svg.text(
        [x - left + 6.0, y - 20.0],
        9.5,
        Anchor::Start,
        INK,
        &plot.title,
    );
    if let Some(told) = &plot.told {
        svg.text([x - left + 6.0, y - 8.0], 8.5, Anchor::Start, PALE, told);
    }
    let all = plot
        .groups
        .iter()
        .flat_map(|group| group.points.iter().chain(&group.behind));
    let axis = Axis::around(all.copied(), plot.may_be_logarithmic);
    match &axis {
        Some(axis) => {
            for (part, told) in axis.marks() {
                let at = y + HEIGHT * (1.0 - part);
                svg.line([x, at], [x + wide, at], GRID, 0.75);
                svg.text([x - 4.0, at + 3.0], 8.5, Anchor::End, INK, &told);
            }
        }
        None => svg.text(
            [x + wide / 2.0, y + HEIGHT / 2.0],
            9.0,
            Anchor::Middle,
            PALE,
            "nothing to show",
        ),
    }
    let each = wide / plot.groups.len() as f64;
    for (place, group) in plot.groups.iter().enumerate() {
        let middle = x + (place as f64 + 0.5) * each;
        if let Some(axis) = &axis {
            let height = |number: f64| y + HEIGHT * (1.0 - axis.part(axis.shown(number)));
            let half = (each / 2.0 - 5.0).min(26.0);
            if group.behind.is_empty() {
                boxed(svg, &group.points, middle, half, colour(place), &height);
            } else {
                let shown: Vec<f64> = group
                    .behind
                    .iter()
                    .map(|value| axis.shown(*value))
                    .collect();
                let shape = shape(shown);
                let level = |shown: f64| y + HEIGHT * (1.0 - axis.part(shown));
                shaped(svg, &shape, middle, half, colour(place), &level);
                bars(svg, &group.behind, middle, colour(place), &height);
            }
            points(svg, group, middle, half, colour(place), &height);
        }
        let name = cohort
            .groups
            .get(place)
            .map_or("all models", String::as_str);
        let letters = (each / 5.2).floor().clamp(3.0, 40.0);
        let letters = (3..=40)
            .rev()
            .find(|count| f64::from(*count) <= letters)
            .unwrap_or(3);
        let name = shortened(name, letters as usize);
        svg.text([middle, y + HEIGHT + 12.0], 9.0, Anchor::Middle, INK, &name);
        svg.text(
            [middle, y + HEIGHT + 23.0],
            8.0,
            Anchor::Middle,
            PALE,
            &plot.counts[place],
        );
    }
    svg.line([x, y], [x, y + HEIGHT], INK, 0.75);
    svg.line([x, y + HEIGHT], [x + wide, y + HEIGHT], INK, 0.75);
}

/// Quartiles, and the farthest values within 1.5 of their distance from them.
fn five(values: &[f64]) -> Option<[f64; 5]> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let [low, median, high] = [0.25, 0.5, 0.75].map(|part| quantile(&sorted, part));
    let (low, median, high) = (low?, median?, high?);
    let reach = 1.5 * (high - low);
    let mut within = sorted
        .iter()
        .filter(|value| (low - reach..=high + reach).contains(*value));
    let first = within.next().copied().unwrap_or(low);
    let last = within.next_back().copied().unwrap_or(first);
    Some([first.min(low), low, median, high, last.max(high)])
}

fn boxed(
    svg: &mut Svg,
    values: &[f64],
    x: f64,
    half: f64,
    colour: &str,
    height: &dyn Fn(f64) -> f64,
) {
    let Some(five) = five(values) else { return };
    let [first, low, median, high, last] = five.map(height);
    let half = half * 0.7;
    if values.len() >= BOX_FROM {
        svg.line([x, first], [x, low], colour, 1.0);
        svg.line([x, high], [x, last], colour, 1.0);
        svg.area(
            &[
                [x - half, low],
                [x + half, low],
                [x + half, high],
                [x - half, high],
            ],
            colour,
        );
    }
    svg.line([x - half, median], [x + half, median], colour, 2.0);
}

/// Quartiles and median within a shape.
fn bars(svg: &mut Svg, values: &[f64], x: f64, colour: &str, height: &dyn Fn(f64) -> f64) {
    let Some(five) = five(values) else { return };
    let [_, low, median, high, _] = five.map(height);
    svg.line([x, low], [x, high], colour, 3.0);
    svg.line([x - 6.0, median], [x + 6.0, median], INK, 1.5);
}

/// Points beside each other: by turns to both sides, so that equal ones are seen.
fn points(
    svg: &mut Svg,
    group: &Group,
    x: f64,
    half: f64,
    colour: &str,
    height: &dyn Fn(f64) -> f64,
) {
    let mut sorted = group.points.clone();
    sorted.sort_by(f64::total_cmp);
    if sorted.len() > POINTS_MOST {
        let Some([first, .., last]) = five(&sorted) else {
            return;
        };
        sorted.retain(|value| !(first..=last).contains(value));
        sorted.truncate(POINTS_MOST);
    }
    // Multiples of the golden ratio never fall together, and the same values always stand the same.
    let golden = (5_f64.sqrt() - 1.0) / 2.0;
    let radius = if sorted.len() > 60 { 1.8 } else { 2.6 };
    let many = sorted.len() > 1;
    for (place, value) in sorted.iter().enumerate() {
        let aside = if many {
            (place as f64 * golden).fract() - 0.5
        } else {
            0.0
        };
        svg.dot([x + aside * half, height(*value)], radius, colour);
    }
}

/// How thick a distribution is at steps from its lowest value to its highest: a sum of bells, as wide as Silverman's rule has it.
fn shape(mut shown: Vec<f64>) -> Vec<(f64, f64)> {
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

fn shaped(
    svg: &mut Svg,
    shape: &[(f64, f64)],
    x: f64,
    half: f64,
    colour: &str,
    level: &dyn Fn(f64) -> f64,
) {
    let thickest = shape.iter().map(|(_, thick)| *thick).fold(0.0, f64::max);
    if thickest <= 0.0 {
        return;
    }
    let side = |sign: f64| {
        move |(at, thick): &(f64, f64)| [x + sign * half * thick / thickest, level(*at)]
    };
    let right = shape.iter().map(side(1.0));
    let points: Vec<[f64; 2]> = right.chain(shape.iter().rev().map(side(-1.0))).collect();
    svg.area(&points, colour);
}
