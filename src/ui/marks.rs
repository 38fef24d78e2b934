//! What a model's page says of places on it: endpoints, proposals, and what is measured.

use std::sync::Arc;

use egui::{Button, RichText, TextEdit, Ui};

use super::{
    models::TITLE_SIZE,
    panels::{View, Wish},
    theme::TITLE,
    words::Words,
};
use crate::mesh::colour::Ramp;
use crate::mesh::endpoints::{Kind, Reason, count};
use crate::mesh::measure::Thickness;
use crate::mesh::unit::{Rounded, Unit};
use crate::world::DrawTool;
use crate::world::marks::{Found, Mark, Measure, Measuring};
use crate::world::model::{Colouring, Model};

/// Rows of a list that are seen at a time.
const PAGE: usize = 10;

/// What the page remembers between looks.
#[derive(Default)]
pub(super) struct Marks {
    /// Files that endpoints can be taken from.
    pub(super) offered: Vec<String>,
    /// The endpoint whose name is being written, and the name so far.
    naming: Option<(usize, usize, String)>,
    /// The first row that is seen of the endpoints, and of the proposals.
    first: [usize; 2],
}

impl Marks {
    /// Lays out what concerns one model; changes of its endpoints are made in `model`.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        (at, model): (usize, &mut Model),
        wishes: &mut Vec<Wish>,
    ) {
        trigger(ui, view, words, wishes);
        ui.separator();
        ui.label(RichText::new(words.endpoints).color(TITLE).size(TITLE_SIZE));
        let [sources, targets] =
            [Kind::Source, Kind::Target].map(|kind| count(&model.endpoints, kind));
        ui.label(format!(
            "{sources} {}, {targets} {}",
            words.sources, words.targets
        ));
        self.endpoints(ui, words, at, model);
        self.proposals(ui, view, words, (at, model), wishes);
        self.files(ui, words, (at, model), wishes);
        ui.separator();
        measures(ui, view, words, model, wishes);
    }

    fn endpoints(&mut self, ui: &mut Ui, words: &Words, at: usize, model: &mut Model) {
        let rows = page(ui, &mut self.first[0], model.endpoints.len());
        let mut gone = None;
        for row in rows {
            let Some(end) = model.endpoints.get(row).cloned() else {
                break;
            };
            if self
                .naming
                .as_ref()
                .is_some_and(|(of, number, _)| (*of, *number) == (at, row))
            {
                self.name(ui, words, row, model);
                continue;
            }
            ui.horizontal_wrapped(|ui| {
                if ui.button(shown(&end.name)).clicked() {
                    self.naming = Some((at, row, end.name.clone()));
                }
                let kind = match end.kind {
                    Kind::Source => words.source,
                    Kind::Target => words.target,
                };
                if ui.button(kind).clicked()
                    && let Some(end) = Arc::make_mut(&mut model.endpoints).get_mut(row)
                {
                    end.kind = end.kind.other();
                }
                if let Some(snapped) = &end.snapped {
                    let symbol = model.unit.symbol();
                    ui.label(format!(
                        "{} {} {symbol}",
                        words.radius,
                        Rounded(snapped.radius)
                    ));
                }
                if ui.button("×").clicked() {
                    gone = Some(row);
                }
            });
        }
        if let Some(row) = gone {
            Arc::make_mut(&mut model.endpoints).remove(row);
            self.naming = None;
        }
        if !model.endpoints.is_empty() && ui.button(words.no_endpoints).clicked() {
            model.endpoints = Arc::default();
            self.naming = None;
        }
    }

    /// An endpoint's name is being written.
    fn name(&mut self, ui: &mut Ui, words: &Words, row: usize, model: &mut Model) {
        let Some((_, _, name)) = &mut self.naming else {
            return;
        };
        ui.add(TextEdit::singleline(name).desired_width(f32::INFINITY));
        let (mut take, mut done) = (false, false);
        ui.horizontal(|ui| {
            take = ui.button(words.apply).clicked();
            done = take || ui.button(words.cancel).clicked();
        });
        if take && let Some(end) = Arc::make_mut(&mut model.endpoints).get_mut(row) {
            end.name = name.trim().to_owned();
        }
        if done {
            self.naming = None;
        }
    }

    fn proposals(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &Words,
        (at, model): (usize, &Model),
        wishes: &mut Vec<Wish>,
    ) {
        let proposals = view.world.proposals(model);
        ui.horizontal_wrapped(|ui| {
            if ui.button(words.propose).clicked() {
                wishes.push(Wish::Mark(Mark::Propose(at)));
            }
            if proposals.is_empty() {
                return;
            }
            if ui.button(words.take_all).clicked() {
                wishes.push(Wish::Mark(Mark::Take(at, None)));
            }
            if ui.button(words.refuse_all).clicked() {
                wishes.push(Wish::Mark(Mark::Refuse(at, None)));
            }
        });
        for row in page(ui, &mut self.first[1], proposals.len()) {
            let Some(proposal) = proposals.get(row) else {
                break;
            };
            let why = match proposal.reason {
                Reason::OpenEnd => words.open_end,
                Reason::Tip => words.tip,
            };
            let symbol = model.unit.symbol();
            ui.label(format!(
                "{}: {why}, {} {symbol}",
                proposal.endpoint.name,
                Rounded(proposal.arm)
            ));
            ui.horizontal(|ui| {
                if ui.button(words.take).clicked() {
                    wishes.push(Wish::Mark(Mark::Take(at, Some(row))));
                }
                if ui.button(words.refuse).clicked() {
                    wishes.push(Wish::Mark(Mark::Refuse(at, Some(row))));
                }
            });
        }
    }

    /// Endpoints into files and out of them.
    fn files(
        &self,
        ui: &mut Ui,
        words: &Words,
        (at, model): (usize, &Model),
        wishes: &mut Vec<Wish>,
    ) {
        ui.horizontal_wrapped(|ui| {
            ui.label(words.write_endpoints);
            for (name, ending) in [("CSV", "csv"), ("JSON", "json")] {
                let can = !model.endpoints.is_empty();
                if ui.add_enabled(can, Button::new(name)).clicked() {
                    wishes.push(Wish::WriteEnds(at, ending));
                }
            }
        });
        if self.offered.is_empty() {
            return;
        }
        ui.label(words.read_endpoints);
        for file in &self.offered {
            if ui.button(file).clicked() {
                wishes.push(Wish::ReadEnds(at, file.clone()));
            }
        }
    }
}

/// What the trigger does with models.
fn trigger(ui: &mut Ui, view: &View<'_>, words: &Words, wishes: &mut Vec<Wish>) {
    let mut draw = view.draw;
    ui.label(
        RichText::new(words.the_trigger)
            .color(TITLE)
            .size(TITLE_SIZE),
    );
    ui.horizontal_wrapped(|ui| {
        ui.selectable_value(&mut draw.tool, DrawTool::Draw, words.trigger_draws);
        ui.selectable_value(&mut draw.tool, DrawTool::Mark, words.trigger_marks);
    });
    ui.horizontal_wrapped(|ui| {
        ui.label(words.trigger_measures);
        for what in Measuring::ALL {
            let tool = DrawTool::Measure(what);
            ui.selectable_value(&mut draw.tool, tool, measuring(what, words));
        }
    });
    if draw.tool == DrawTool::Mark {
        ui.horizontal_wrapped(|ui| {
            ui.label(words.next_end);
            ui.selectable_value(&mut draw.next_end, Kind::Source, words.source);
            ui.selectable_value(&mut draw.next_end, Kind::Target, words.target);
        });
        ui.checkbox(&mut draw.snap_ends, words.snap_ends);
    }
    if draw != view.draw {
        wishes.push(Wish::Draw(draw));
    }
}

fn measuring(what: Measuring, words: &Words) -> &'static str {
    match what {
        Measuring::Distance => words.distance,
        Measuring::Along => words.along,
        Measuring::Angle => words.angle,
        Measuring::Thickness => words.thickness,
    }
}

fn measures(ui: &mut Ui, view: &View<'_>, words: &Words, model: &Model, wishes: &mut Vec<Wish>) {
    let measures = view.world.measures();
    let mut own = measures
        .iter()
        .filter(|measure| measure.is_on(model))
        .peekable();
    if own.peek().is_none() {
        return;
    }
    ui.label(RichText::new(words.measured).color(TITLE).size(TITLE_SIZE));
    for measure in own {
        ui.horizontal_wrapped(|ui| {
            ui.label(told(measure, model.unit, words));
            if ui.button("×").clicked() {
                wishes.push(Wish::Mark(Mark::Unmeasure(Some(measure.id))));
            }
        });
    }
    if ui.button(words.no_measures).clicked() {
        wishes.push(Wish::Mark(Mark::Unmeasure(None)));
    }
}

/// A measure in words.
fn told(measure: &Measure, unit: Unit, words: &Words) -> String {
    let (name, symbol) = (measuring(measure.what, words), unit.symbol());
    let length = |length: f64| format!("{} {symbol}", Rounded(length));
    let value = match measure.found {
        Found::Begun => format!(
            "{} / {} {}",
            measure.places.len(),
            measure.what.places(),
            words.places
        ),
        Found::Waiting => "…".to_owned(),
        Found::Length(way) => length(way),
        Found::Degrees(degrees) => format!("{}°", Rounded(degrees)),
        Found::Thickness(Thickness { opposite, diameter }) => {
            let told =
                |value: Option<f32>| value.map_or("-".to_owned(), |value| length(value.into()));
            format!(
                "{} {}, {} {}",
                told(opposite),
                words.opposite_side,
                told(diameter),
                words.by_rays
            )
        }
        Found::None => words.no_way.to_owned(),
    };
    format!("{name}: {value}")
}

/// What the colours of a model mean, where they are numbers.
pub(super) fn legend(ui: &mut Ui, view: &View<'_>, words: &Words, model: &Model) {
    if !model.colouring.is_numbers() {
        return;
    }
    let Some(painting) = view.world.painting(model) else {
        ui.label("…");
        return;
    };
    let Some([low, high]) = painting.range else {
        ui.label(words.no_numbers);
        return;
    };
    let symbol = model.unit.symbol();
    let (ramp, unit) = match model.colouring {
        Colouring::Curvature => (Ramp::AboutZero, format!("1/{symbol}")),
        _ => (Ramp::Rising, symbol.to_owned()),
    };
    scale(ui, ramp, [low, high], &unit);
}

/// A scale of colours, with the numbers at both ends.
pub(super) fn scale(ui: &mut Ui, ramp: Ramp, [low, high]: [f32; 2], unit: &str) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.label(format!("{} ", Rounded(low.into())));
        let parts: u8 = 16;
        for part in 0..parts {
            let [red, green, blue, _] = ramp.colour((f32::from(part) + 0.5) / f32::from(parts));
            let (place, _) = ui.allocate_exact_size(egui::vec2(8.0, 14.0), egui::Sense::hover());
            let colour = egui::Color32::from_rgb(red, green, blue);
            ui.painter().rect_filled(place, 0.0, colour);
        }
        ui.label(format!(" {} {unit}", Rounded(high.into())));
    });
}

/// The rows of a list that are seen, and what goes to others where there are more.
pub(super) fn page(ui: &mut Ui, first: &mut usize, rows: usize) -> std::ops::Range<usize> {
    if rows <= PAGE {
        *first = 0;
        return 0..rows;
    }
    *first = (*first).min((rows - 1) / PAGE * PAGE);
    ui.horizontal(|ui| {
        if ui.add_enabled(*first > 0, Button::new("<")).clicked() {
            *first -= PAGE;
        }
        let last = (*first + PAGE).min(rows);
        ui.label(format!("{} … {last} / {rows}", *first + 1));
        if ui.add_enabled(last < rows, Button::new(">")).clicked() {
            *first += PAGE;
        }
    });
    *first..(*first + PAGE).min(rows)
}

/// A name as it is read where it is empty.
fn shown(name: &str) -> &str {
    if name.is_empty() { "…" } else { name }
}
