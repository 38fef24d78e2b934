//! What a model's page says of its centerlines: a table of branches, what they are like together, plots, and what is not reached.

use std::sync::Arc;

use egui::{Button, RichText, ScrollArea, Ui};

use super::{
    LineWish,
    marks::page,
    models::TITLE_SIZE,
    panels::{View, Wish},
    plot::{self, Histogram},
    theme::{MESSAGE, TITLE},
    words::Words,
};
use crate::centerline::analysis::{BranchFacts, MeanStd};
use crate::mesh::unit::{Rounded, Unit};
use crate::tree::measure::Spread;
use crate::world::DrawTool;
use crate::world::lines::{Dimension, LineLook, Lines, Quantity, Shading};
use crate::world::model::{LoadedModel, Model};
use crate::world::scene::SurfaceLook;

/// Rows of the table that are seen at a time.
const ROWS: u8 = 7;
/// Gaps that are bridged, in thousandths of the model's longest side.
const GAPS: [u16; 4] = [5, 10, 20, 50];
/// How wide the first column is, in widths of the others.
const FIRST: f32 = 0.75;
/// Columns of the table beside the number of the branch and what it is coloured by.
const COLUMNS: [Quantity; 3] = [Quantity::Length, Quantity::Radius, Quantity::Order];
/// Signs that the label beside a hand has room for.
const LABEL: usize = 22;
/// Files that are written.
const ENDINGS: [(&str, &str); 5] = [
    ("SWC", "swc"),
    ("VTP", "vtp"),
    ("GLB", "glb"),
    ("CSV", "csv"),
    ("JSON", "json"),
];

/// What the page remembers between looks.
#[derive(Default)]
pub(super) struct Table {
    /// By what it is sorted (the number of the branch, where by nothing), and whether the largest is first.
    by: Option<Quantity>,
    falls: bool,
    /// The order of the rows, and for what it was made.
    order: Vec<usize>,
    of: Option<(Arc<Lines>, Option<Quantity>, bool)>,
    /// The branch that the table was scrolled to last.
    scrolled_to: Option<usize>,
    bars: Option<(Arc<Lines>, Quantity, Histogram)>,
    /// The first row that is seen of what is not reached.
    first: usize,
}

/// A model's centerlines on the page.
struct Page<'a> {
    at: usize,
    lines: &'a Arc<Lines>,
    words: &'a Words,
    unit: Unit,
    lit: Option<usize>,
    wishes: &'a mut Vec<Wish>,
}

impl Table {
    /// Lays out what concerns one model; how its centerlines look is changed in `model`.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        (at, model): (usize, &mut Model),
        wishes: &mut Vec<Wish>,
    ) {
        let Some(mut look) = model.lines else {
            if ui.button(words.find_lines).clicked() {
                model.lines = Some(LineLook::default());
                // What hides them is seen through from now on.
                if model.surface.is_some() {
                    model.surface = Some(SurfaceLook::XRay);
                }
            }
            return;
        };
        // As it is kept: a hand that carries an endpoint changes nothing yet.
        let kept = view.world.document().models.get(at);
        let found = kept.and_then(|kept| view.world.lines(kept));
        match found {
            None => searching(ui, view, words, model, wishes),
            Some(Err(why)) => {
                let why = view.settings.language.say(why);
                ui.label(RichText::new(why).color(MESSAGE));
                gaps(ui, view, words, model, &mut look);
                if ui.button(words.again).clicked() {
                    wishes.push(Wish::Line(LineWish::Again(at)));
                }
            }
            Some(Ok(lines)) => {
                let shading = kept.and_then(|kept| view.world.shading(kept));
                let mut page = Page {
                    at,
                    lines,
                    words,
                    unit: model.unit,
                    lit: kept.and_then(|kept| view.world.lit_branch(kept)),
                    wishes,
                };
                page.counts(ui);
                self.unreached(ui, view, &page);
                if look.bridge.is_some() || !lines.centerline.unreached.is_empty() {
                    gaps(ui, view, words, model, &mut look);
                }
                trigger(ui, view, words, page.wishes);
                self.table(ui, &mut page, look.by);
                page.path(ui);
                page.take(ui);
                ui.separator();
                coloured_by(ui, words, &mut look);
                if lines.analysis.model.open_ends > 0 {
                    ui.checkbox(&mut look.caps, words.caps);
                }
                legend(ui, shading, words, model.unit);
                self.bars(ui, &page, look.by);
                ui.separator();
                page.summary(ui);
                page.files(ui);
            }
        }
        model.lines = Some(look);
        ui.separator();
        if ui.button(words.no_lines).clicked() {
            model.lines = None;
        }
    }

    /// Targets that no way leads to.
    fn unreached(&mut self, ui: &mut Ui, view: &View<'_>, page: &Page<'_>) {
        let all = &page.lines.centerline.unreached;
        if all.is_empty() {
            return;
        }
        let heading = format!("{}: {}", page.words.not_reached, all.len());
        ui.label(RichText::new(heading).color(MESSAGE));
        for row in self::page(ui, &mut self.first, all.len()) {
            if let Some(one) = all.get(row) {
                let why = view.settings.language.say(&one.to_string());
                ui.label(format!("{}: {why}", one.name));
            }
        }
    }

    /// The order of the rows.
    fn sort(&mut self, lines: &Arc<Lines>) {
        let is_so = |(of, by, falls): &(Arc<Lines>, Option<Quantity>, bool)| {
            Arc::ptr_eq(of, lines) && (*by, *falls) == (self.by, self.falls)
        };
        if self.of.as_ref().is_some_and(is_so) {
            return;
        }
        self.order = ordered(&lines.analysis.branches, self.by, self.falls);
        self.of = Some((Arc::clone(lines), self.by, self.falls));
        self.scrolled_to = None;
    }

    fn table(&mut self, ui: &mut Ui, page: &mut Page<'_>, by: Option<Quantity>) {
        self.sort(page.lines);
        let mut columns: Vec<Quantity> = COLUMNS.to_vec();
        let further = by.filter(|by| *by != Quantity::RadiusHere && !columns.contains(by));
        columns.push(further.unwrap_or(Quantity::Tortuosity));
        #[expect(clippy::cast_precision_loss, reason = "five columns")]
        let width = (ui.available_width() - 20.0) / (columns.len() as f32 + FIRST);
        let height = ui.spacing().interact_size.y;
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            ui.spacing_mut().button_padding.x = 2.0;
            let mut head = |ui: &mut Ui, of: Option<Quantity>, name: &str, width: f32| {
                let mark = match (self.by == of, self.falls) {
                    (false, _) => "",
                    (true, false) => " +",
                    (true, true) => " -",
                };
                let button = Button::new(format!("{name}{mark}")).truncate();
                if ui.add_sized([width, height], button).clicked() {
                    self.falls = self.by == of && !self.falls;
                    self.by = of;
                }
            };
            head(ui, None, page.words.branch, width * FIRST + 8.0);
            for column in &columns {
                head(ui, Some(*column), name(*column, page.words), width);
            }
        });
        self.sort(page.lines);
        let each = height + ui.spacing().item_spacing.y;
        let rows = u8::try_from(self.order.len()).unwrap_or(ROWS).min(ROWS);
        let mut area = ScrollArea::vertical()
            .id_salt("branches")
            .auto_shrink([false, true])
            .min_scrolled_height(each * f32::from(rows))
            .max_height(each * f32::from(rows));
        if self.scrolled_to != page.lit {
            self.scrolled_to = page.lit;
            let row = self.order.iter().position(|one| Some(*one) == page.lit);
            if let Some(row) = row {
                #[expect(clippy::cast_precision_loss, reason = "a place on a panel")]
                let above = row as f32 - f32::from(ROWS / 2);
                area = area.vertical_scroll_offset((above * each).max(0.0));
            }
        }
        area.show_rows(ui, height, self.order.len(), |ui, rows| {
            for row in rows {
                if let Some(facts) = self
                    .order
                    .get(row)
                    .and_then(|one| page.lines.analysis.branches.get(*one))
                    && page.row(ui, facts, &columns, [width, height])
                {
                    // It is where the hand is: it need not be scrolled to.
                    let lit = (page.lit != Some(facts.id)).then_some(facts.id);
                    self.scrolled_to = lit;
                    page.wishes.push(Wish::Line(LineWish::Light(page.at, lit)));
                }
            }
        });
    }

    /// How often which numbers are.
    fn bars(&mut self, ui: &mut Ui, page: &Page<'_>, by: Option<Quantity>) {
        let of = by.unwrap_or(Quantity::Length);
        let is_so = |(lines, by, _): &(Arc<Lines>, Quantity, Histogram)| {
            Arc::ptr_eq(lines, page.lines) && *by == of
        };
        if !self.bars.as_ref().is_some_and(is_so) {
            let bars = Histogram::of(&page.lines.numbers(of));
            self.bars = bars.map(|bars| (Arc::clone(page.lines), of, bars));
        }
        if let Some((_, _, bars)) = &self.bars {
            ui.label(format!("{}: {}", page.words.how_many, name(of, page.words)));
            #[expect(clippy::cast_possible_truncation, reason = "a place in a plot")]
            let chosen = page.facts().map(|facts| of.of(facts) as f32);
            plot::bars(ui, bars, of.ramp(), &symbol(of, page.unit), chosen);
        }
    }
}

impl Page<'_> {
    /// The branch that is lit.
    fn facts(&self) -> Option<&BranchFacts> {
        self.lines.analysis.branches.get(self.lit?)
    }

    /// The radius along the way through the branch that is lit.
    fn path(&self, ui: &mut Ui) {
        let Some(facts) = self.facts() else {
            return;
        };
        let words = self.words;
        ui.label(format!(
            "{} {}: {}",
            words.branch, facts.id, words.path_radius
        ));
        let (path, within) = self.lines.path_through(facts.id);
        plot::line(ui, &path, &within, self.unit.symbol());
    }

    /// What is taken into the sketch: the branch that is lit, or all.
    fn take(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            let mut button = |ui: &mut Ui, name: &str, branch: Option<usize>| {
                if ui.button(name).clicked() {
                    let wish = LineWish::Take(self.at, branch);
                    self.wishes.push(Wish::Line(wish));
                }
            };
            if let Some(lit) = self.lit {
                button(ui, self.words.take_branch, Some(lit));
            }
            button(ui, self.words.take_tree, None);
        });
    }

    fn counts(&self, ui: &mut Ui) {
        let (counts, words) = (self.lines.analysis.counts, self.words);
        ui.label(format!(
            "{}: {}, {}: {}, {}: {}",
            words.branches,
            counts.branches,
            words.junctions,
            counts.junctions,
            words.tips,
            counts.tips
        ));
    }

    /// A row of the table; whether it was pressed.
    fn row(&self, ui: &mut Ui, facts: &BranchFacts, columns: &[Quantity], size: [f32; 2]) -> bool {
        let [width, height] = size;
        let is_lit = self.lit == Some(facts.id);
        let (place, answer) = ui.allocate_exact_size(
            egui::vec2(ui.available_width(), height),
            egui::Sense::click(),
        );
        let fill = match (is_lit, answer.hovered()) {
            (true, _) => Some(plot::lit_colour().gamma_multiply(0.6)),
            (false, true) => Some(ui.visuals().widgets.hovered.bg_fill),
            (false, false) => None,
        };
        if let Some(fill) = fill {
            ui.painter().rect_filled(place, 3.0, fill);
        }
        let font = egui::TextStyle::Body.resolve(ui.style());
        let ink = ui.visuals().text_color();
        let mut right = place.left() + width * FIRST + 4.0;
        let cell = |text: String, right: f32| {
            let at = egui::pos2(right, place.center().y);
            let align = egui::Align2::RIGHT_CENTER;
            ui.painter().text(at, align, text, font.clone(), ink);
        };
        cell(facts.id.to_string(), right);
        for column in columns {
            right += width;
            cell(written(*column, facts), right);
        }
        answer.clicked()
    }

    /// What the branches are like together: the source papers' table.
    fn summary(&self, ui: &mut Ui) {
        let (words, table) = (self.words, self.lines.analysis.table);
        ui.label(RichText::new(words.summary).color(TITLE).size(TITLE_SIZE));
        let unit = self.unit.symbol();
        let per = format!("1/{unit}");
        let rows: [(&str, &str, Spread); 7] = [
            (words.length, unit, table.branch_length),
            (words.points, unit, table.point_radius),
            (words.whole_way, unit, table.centerline_length),
            (words.angle, "°", table.bifurcation_angle_deg),
            (words.tortuosity, "", table.tortuosity),
            (words.curvature, &per, table.curvature),
            (words.torsion, &per, table.torsion),
        ];
        let heads = ["n", words.mean, words.deviation, words.least, words.most];
        cells(ui, "", heads.map(str::to_owned));
        for (name, unit, spread) in rows {
            let Spread {
                n,
                mean,
                std,
                min,
                max,
            } = spread;
            let number = |number: f64| match n {
                0 => "-".to_owned(),
                _ => short(number),
            };
            let [mean, std, min, max] = [mean, std, min, max].map(number);
            let name = format!("{name} {unit}");
            cells(ui, &name, [n.to_string(), mean, std, min, max]);
        }
        let MeanStd { mean, std } = table.upwards_angle_deg;
        ui.label(format!(
            "{} {} {unit}, {} {} ± {}°",
            words.stem,
            rounded(table.stem_length),
            words.upwards,
            rounded(mean),
            rounded(std)
        ));
    }

    fn files(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            ui.label(self.words.write_lines);
            for (name, ending) in ENDINGS {
                if ui.button(name).clicked() {
                    self.wishes
                        .push(Wish::Line(LineWish::Write(self.at, ending)));
                }
            }
        });
    }
}

/// A row of the summary: what it is, how many, and four numbers.
fn cells(ui: &mut Ui, name: &str, numbers: [String; 5]) {
    let width = ui.available_width();
    let height = ui.spacing().interact_size.y - 4.0;
    let (place, _) = ui.allocate_exact_size(egui::vec2(width, height), egui::Sense::hover());
    let font = egui::TextStyle::Body.resolve(ui.style());
    let ink = ui.visuals().text_color();
    let cell = |at: egui::Pos2, align: egui::Align2, text: &str| {
        ui.painter().text(at, align, text, font.clone(), ink);
    };
    cell(place.left_center(), egui::Align2::LEFT_CENTER, name);
    let part = width / 7.2;
    for (back, number) in (0_u8..).zip(numbers.iter().rev()) {
        let right = place.right_center() - egui::vec2(part * f32::from(back), 0.0);
        cell(right, egui::Align2::RIGHT_CENTER, number);
    }
}

/// How far the search is.
fn searching(ui: &mut Ui, view: &View<'_>, words: &Words, model: &Model, wishes: &mut Vec<Wish>) {
    let finding = view.world.finding();
    let Some(finding) = finding.filter(|finding| finding.file == model.file) else {
        ui.label(words.waits);
        return;
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(format!("{}: {} %", words.finding, finding.percent));
        if ui.button(words.cancel).clicked() {
            wishes.push(Wish::Line(LineWish::Stop));
        }
    });
}

/// Whether the trigger chooses branches.
fn trigger(ui: &mut Ui, view: &View<'_>, words: &Words, wishes: &mut Vec<Wish>) {
    let mut draw = view.draw;
    ui.horizontal_wrapped(|ui| {
        ui.label(words.the_trigger);
        ui.selectable_value(&mut draw.tool, DrawTool::Draw, words.trigger_draws);
        ui.selectable_value(&mut draw.tool, DrawTool::Branch, words.trigger_chooses);
    });
    if draw != view.draw {
        wishes.push(Wish::Draw(draw));
    }
}

fn coloured_by(ui: &mut Ui, words: &Words, look: &mut LineLook) {
    ui.horizontal_wrapped(|ui| {
        ui.label(words.colour_by);
        ui.selectable_value(&mut look.by, None, words.nothing);
        for by in Quantity::ALL {
            ui.selectable_value(&mut look.by, Some(by), name(by, words));
        }
    });
    ui.checkbox(&mut look.balls, words.inscribed_balls);
}

/// Up to how wide gaps are bridged.
fn gaps(ui: &mut Ui, view: &View<'_>, words: &Words, model: &Model, look: &mut LineLook) {
    let Some(side) = view.world.loaded_model(model).map(LoadedModel::side) else {
        return;
    };
    ui.horizontal_wrapped(|ui| {
        ui.label(words.bridge_gaps);
        ui.selectable_value(&mut look.bridge, None, words.nothing);
        for gap in GAPS {
            let wide = Rounded(f64::from(gap) / 1e3 * f64::from(side));
            let wide = format!("{wide} {}", model.unit.symbol());
            ui.selectable_value(&mut look.bridge, Some(gap), wide);
        }
    });
}

/// What the colours mean.
fn legend(ui: &mut Ui, shading: Option<&Shading>, words: &Words, unit: Unit) {
    let Some((by, shading)) = shading.and_then(|shading| Some((shading.by?, shading))) else {
        return;
    };
    match shading.range {
        Some(range) => super::marks::scale(ui, by.ramp(), range, &symbol(by, unit)),
        None => _ = ui.label(words.no_numbers),
    }
}

/// Branches in an order: by a quantity, those without a number last; by nothing, as they are numbered.
fn ordered(branches: &[BranchFacts], by: Option<Quantity>, falls: bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..branches.len()).collect();
    let Some(by) = by else {
        if falls {
            order.reverse();
        }
        return order;
    };
    let number = |at: usize| branches.get(at).map_or(f64::NAN, |branch| by.of(branch));
    order.sort_by(|one, other| {
        let [a, b] = [one, other].map(|at| number(*at));
        let sorted = match falls {
            true => b.total_cmp(&a),
            false => a.total_cmp(&b),
        };
        (a.is_nan().cmp(&b.is_nan())).then(sorted)
    });
    order
}

/// What a person reads beside a branch that a hand is at.
pub(super) fn said(view: &View<'_>, words: &Words, at: usize, branch: usize) -> Option<String> {
    let model = view.world.document().models.get(at)?;
    let lines = view.world.lines(model)?.ok()?;
    let facts = lines.analysis.branches.get(branch)?;
    let unit = model.unit.symbol();
    let length = format!("{branch}: {} {unit}", rounded(facts.length));
    let radius = rounded(facts.radius.along.mean);
    let both = format!("{length}, r {radius} {unit}");
    Some(match both.len() <= LABEL {
        true => both,
        false => format!("{} {length}", words.branch),
    })
}

/// A branch's number as the table has it.
fn written(of: Quantity, facts: &BranchFacts) -> String {
    let number = of.of(facts);
    match of.dimension() == Dimension::Number && number.fract() == 0.0 {
        true => format!("{number:.0}"),
        false => rounded(number),
    }
}

fn rounded(number: f64) -> String {
    match number.is_finite() {
        true => Rounded(number).to_string(),
        false => "-".to_owned(),
    }
}

/// In at most six signs and a minus, which the summary's columns have room for.
fn short(number: f64) -> String {
    let fits = |text: &String| text.trim_start_matches('-').len() <= 6;
    let one = || Some(format!("{number:.1e}")).filter(fits);
    let written = Some(rounded(number)).filter(fits).or_else(one);
    written.unwrap_or_else(|| format!("{number:.0e}"))
}

fn name(of: Quantity, words: &Words) -> &'static str {
    match of {
        Quantity::RadiusHere => words.radius_here,
        Quantity::Length => words.length,
        Quantity::Radius => words.mean_radius,
        Quantity::Tortuosity => words.tortuosity,
        Quantity::Curvature => words.curvature,
        Quantity::Torsion => words.torsion,
        Quantity::Taper => words.taper,
        Quantity::Volume => words.volume,
        Quantity::Area => words.area,
        Quantity::Order => words.order,
        Quantity::Strahler => words.strahler,
        Quantity::Horsfield => words.horsfield,
        Quantity::Tips => words.tips,
    }
}

fn symbol(of: Quantity, unit: Unit) -> String {
    let unit = unit.symbol();
    match of.dimension() {
        Dimension::Number => String::new(),
        Dimension::Unit(-1) => format!("1/{unit}"),
        Dimension::Unit(1) => unit.to_owned(),
        Dimension::Unit(2) => format!("{unit}²"),
        Dimension::Unit(power) => format!("{unit}^{power}"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "each shows the figures")]
    use super::*;
    use crate::centerline::Centerline;
    use crate::centerline::analysis::{Analysis, ModelFacts};

    #[test]
    fn rows_are_sorted_and_those_without_a_number_are_the_last() {
        let none = Analysis::new(ModelFacts::default(), &Centerline::default(), false, 0);
        assert!(ordered(&none.branches, Some(Quantity::Length), true).is_empty());
        let found = Centerline {
            tree: crate::world::lines::tests::tree(),
            ..Centerline::default()
        };
        let mut branches = Analysis::new(ModelFacts::default(), &found, false, 0).branches;
        assert_eq!(branches.len(), 5);
        for (branch, torsion) in
            branches
                .iter_mut()
                .zip([Some(2.0), None, Some(-3.0), Some(1.0), None])
        {
            branch.torsion = torsion;
        }
        for (by, falls, expected) in [
            (None, false, [0, 1, 2, 3, 4]),
            (None, true, [4, 3, 2, 1, 0]),
            (Some(Quantity::Torsion), false, [2, 3, 0, 1, 4]),
            (Some(Quantity::Torsion), true, [0, 3, 2, 1, 4]),
            (Some(Quantity::Order), true, [3, 4, 1, 2, 0]),
        ] {
            assert_eq!(ordered(&branches, by, falls), expected, "{by:?} {falls}");
        }
        for (number, expected) in [
            (0.0, "0.00"),
            (-0.001_57, "-0.0016"),
            (123_456.0, "123456"),
            (1_234_567.0, "1.2e6"),
            (2.13e-4, "2.1e-4"),
            (1.53e-16, "2e-16"),
            (-1.53e-16, "-2e-16"),
            (f64::NAN, "-"),
        ] {
            assert_eq!(short(number), expected, "{number}");
        }
        let cell = |of, at: usize| branches.get(at).map(|branch| written(of, branch));
        assert_eq!(cell(Quantity::Order, 3).as_deref(), Some("2"));
        assert_eq!(cell(Quantity::Torsion, 1).as_deref(), Some("-"));
        assert_eq!(cell(Quantity::Length, 0).as_deref(), Some("2.00"));
    }
}
