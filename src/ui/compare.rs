//! The page of a model beside others: what they have in common and what not, in words, numbers and curves, and laid over each other on the stage.

use egui::{Color32, RichText, Sense, Ui, vec2};

use super::{
    abstraction::{cells, lines_first, name},
    models::{linked, name_of},
    panels::{CompareWish, View, Wish},
    plot,
    theme::{INK, MESSAGE, SMALLEST, TITLE},
    words::Words,
};
use crate::mesh::unit::Rounded;
use crate::tree::compare::Pair;
use crate::tree::compare::verdict::Kind;
use crate::world::comparing::{Comparison, OTHERS_MOST, Overlay, Subject};
use crate::world::model::Model;

/// Height of the curves, points.
const HIGH: f32 = 120.0;
const GROUND: Color32 = Color32::from_rgb(238, 236, 230);
const LETTERS: Color32 = Color32::from_rgb(26, 26, 26);

/// What the page remembers between looks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Comparisons {
    /// Which of the others the numbers are of.
    pair: usize,
    /// Which quantity's curves are seen.
    plot: usize,
    /// Whether all numbers are told, and not those of the papers' table alone.
    all: bool,
}

impl Comparisons {
    /// Lays out what concerns one model.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        (at, model): (usize, &mut Model),
        wishes: &mut Vec<Wish>,
    ) {
        if !view.world.has_tree(at) {
            return lines_first(ui, words, model);
        }
        choose(ui, view, words, at, wishes);
        let with = view.world.compared_with(at);
        if with.is_empty() {
            return;
        }
        let found = view.world.comparison(at);
        if !matches!(found, Some((_, true))) {
            ui.horizontal_wrapped(|ui| {
                ui.label(words.comparing);
                if ui.button(words.cancel).clicked() {
                    wishes.push(Wish::Compare(CompareWish::With(at, Vec::new())));
                }
            });
        }
        match found {
            None => {}
            Some((Err(why), _)) => {
                ui.label(RichText::new(view.settings.language.say(why)).color(MESSAGE));
            }
            Some((Ok(found), _)) => {
                self.found(ui, view, words, found, &with);
                lay_over(ui, view, words, wishes);
                linked(ui, view, words, wishes);
            }
        }
    }

    fn found(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        found: &Comparison,
        with: &[Subject],
    ) {
        self.pair = self.pair.min(found.pairs.len().saturating_sub(1));
        for (place, (pair, subject)) in found.pairs.iter().zip(with).enumerate() {
            ui.horizontal(|ui| {
                square(ui, found.colours[place + 1]);
                let name = called(view, words, *subject);
                if ui.selectable_label(self.pair == place, name).clicked() {
                    self.pair = place;
                }
            });
            ui.label(RichText::new(kind(pair, words)).color(TITLE));
        }
        if let Some(pair) = found.pairs.get(self.pair) {
            verdict(ui, words, pair);
            self.numbers(ui, words, pair);
        }
        self.curves(ui, words, found);
    }

    /// What both have, number by number; those that are no match are marked.
    fn numbers(&mut self, ui: &mut Ui, words: &Words, pair: &Pair) {
        ui.checkbox(&mut self.all, words.all_numbers);
        let scale_free = pair.verdict.at_one_size;
        let off = match scale_free {
            true => format!("{} ({})", words.off_by, words.at_one_size),
            false => words.off_by.to_owned(),
        };
        let heads = [words.in_the_model, words.in_the_other, off.as_str()].map(str::to_owned);
        cells(ui, "", heads, INK);
        let told = |number: Option<f64>| {
            number.map_or_else(|| "-".to_owned(), |number| Rounded(number).to_string())
        };
        for one in &pair.differences {
            if !(self.all || one.of_papers) {
                continue;
            }
            let relative = match scale_free {
                true => one.relative_scale_free,
                false => one.relative,
            };
            let off = relative.map_or_else(|| "-".to_owned(), percent);
            let ink = if one.matches(scale_free) {
                INK
            } else {
                MESSAGE
            };
            cells(
                ui,
                &name(one.name, words),
                [told(one.a), told(one.b), off],
                ink,
            );
        }
    }

    /// How a quantity is spread in all of them.
    fn curves(&mut self, ui: &mut Ui, words: &Words, found: &Comparison) {
        let count = found.plots.len();
        self.plot = self.plot.min(count.saturating_sub(1));
        let Some(shown) = found.plots.get(self.plot) else {
            return;
        };
        ui.horizontal_wrapped(|ui| {
            for (label, step) in [("<", count - 1), (">", 1)] {
                if ui.button(label).clicked() {
                    self.plot = (self.plot + step) % count;
                }
            }
            ui.label(name(shown.name, words));
        });
        let size = vec2(ui.available_width(), HIGH);
        let (place, _) = ui.allocate_exact_size(size, Sense::hover());
        ui.painter().rect_filled(place, 2.0, GROUND);
        let inks: Vec<Color32> = found.colours.iter().copied().map(opaque).collect();
        let plot = place
            .shrink(8.0)
            .with_max_y(place.bottom() - 1.6 * SMALLEST);
        plot::spread(ui.painter(), plot, SMALLEST, shown, (&inks, LETTERS));
    }
}

/// How much more, with one digit behind the point; of next to nothing 0.
fn percent(part: f64) -> String {
    let tenths = (1000.0 * part).round();
    if tenths == 0.0 {
        return "0 %".to_owned();
    }
    format!("{:+.1} %", tenths / 10.0)
}

fn opaque([red, green, blue]: [u8; 3]) -> Color32 {
    Color32::from_rgb(red, green, blue)
}

/// What it is compared with: each other thing on the stage that has a tree.
fn choose(ui: &mut Ui, view: &View<'_>, words: &Words, at: usize, wishes: &mut Vec<Wish>) {
    let all = view.world.comparable(at);
    if all.is_empty() {
        ui.label(words.nothing_to_compare);
        return;
    }
    ui.horizontal_wrapped(|ui| {
        ui.label(words.compare_with);
        let with = view.world.compared_with(at);
        for one in all {
            let is_chosen = with.contains(&one);
            let label = called(view, words, one);
            let can = is_chosen || with.len() < OTHERS_MOST;
            let answer = ui.add_enabled(can, egui::Button::selectable(is_chosen, label));
            if answer.clicked() {
                let mut with = with.clone();
                match is_chosen {
                    true => with.retain(|other| *other != one),
                    false => with.push(one),
                }
                wishes.push(Wish::Compare(CompareWish::With(at, with)));
            }
        }
    });
}

fn called(view: &View<'_>, words: &Words, subject: Subject) -> String {
    match subject {
        Subject::Model(at) => view
            .document
            .models
            .get(at)
            .map(name_of)
            .unwrap_or_default(),
        Subject::Sketch => words.the_sketch.to_owned(),
    }
}

fn kind(pair: &Pair, words: &Words) -> &'static str {
    match pair.verdict.kind {
        Kind::Same => words.same_tree,
        Kind::SameKind => words.same_kind,
        Kind::InPart => words.alike_in_part,
        Kind::TooFew => words.too_few_to_tell,
        Kind::Different => words.different_trees,
    }
}

/// What speaks for that.
fn verdict(ui: &mut Ui, words: &Words, pair: &Pair) {
    let [within, of] = pair.verdict.within;
    let [apart, tested] = pair.verdict.told_apart;
    let whole = |part: f64| format!("{:.0} %", 100.0 * part);
    ui.label(format!("{}: {within} / {of}", words.numbers_match_both));
    ui.label(format!("{}: {apart} / {tested}", words.distributions_apart));
    let share = whole(pair.topology.path.scale_free.share);
    ui.label(format!("{}: {share}", words.no_counterpart));
    if let Some(edits) = pair.topology.edits {
        ui.label(format!("{}: {edits}", words.branch_edits));
    }
    if let Some(space) = &pair.space {
        let part = whole(space.fitted.apart.mean / space.reach.max(f64::MIN_POSITIVE));
        ui.label(format!("{}: {part}", words.apart_in_space));
    }
}

/// How they lie over each other on the stage.
fn lay_over(ui: &mut Ui, view: &View<'_>, words: &Words, wishes: &mut Vec<Wish>) {
    let mut how = view.world.overlay();
    ui.horizontal_wrapped(|ui| {
        ui.label(words.lay_over);
        for (overlay, label) in [
            (Overlay::None, words.not_laid),
            (Overlay::Rooted, words.root_to_root),
            (Overlay::Fitted, words.fitted),
        ] {
            ui.selectable_value(&mut how, overlay, label);
        }
    });
    if how != view.world.overlay() {
        wishes.push(Wish::Compare(CompareWish::LayOver(how)));
    }
}

/// A square in a tree's colour.
fn square(ui: &mut Ui, colour: [u8; 3]) {
    let side = ui.text_style_height(&egui::TextStyle::Body) * 0.7;
    let (place, _) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
    ui.painter().rect_filled(place, 2.0, opaque(colour));
}
