//! The panel of a study: questions with their scales, tasks with their pictures and their time.

use egui::{Align, Button, ColorImage, Layout, RichText, TextureHandle, TextureOptions, Ui, vec2};

use super::{
    panels::{Thumbnail, View, Wish},
    theme::{MESSAGE, PAPER, TITLE},
    words::{Language, StudyWords},
};
use crate::world::study::{
    flow::{Event, Outcome, Page, Study},
    score::Part,
};

/// Width and height of a task's picture, points.
const PICTURE: f32 = 250.0;
/// Width of what can be answered to a symptom, and of what to a statement, points.
const CELLS: [f32; 2] = [57.0, 78.0];
/// Height of answers, points.
const CELL_HEIGHT: f32 = 27.0;
/// Room for a symptom's name, points.
const SYMPTOM: f32 = 166.0;

/// The pictures of tasks.
#[derive(Default)]
pub(super) struct Pictures {
    of: Vec<Option<Thumbnail>>,
    /// As they were given to egui; they come with the first look.
    loaded: Vec<Option<TextureHandle>>,
}

impl Pictures {
    pub(super) fn of(pictures: Vec<Option<Thumbnail>>) -> Self {
        Self {
            of: pictures,
            loaded: Vec::new(),
        }
    }

    /// They are given to another egui with the next look.
    pub(super) fn load_anew(&mut self) {
        self.loaded.clear();
    }

    fn get(&mut self, ui: &Ui, task: usize) -> Option<&TextureHandle> {
        if self.loaded.len() != self.of.len() {
            let load = |(number, picture): (usize, &Option<Thumbnail>)| {
                load(ui, number, picture.as_ref()?)
            };
            self.loaded = self.of.iter().enumerate().map(load).collect();
        }
        self.loaded.get(task)?.as_ref()
    }
}

fn load(ui: &Ui, number: usize, picture: &Thumbnail) -> Option<TextureHandle> {
    let side = picture.side;
    if picture.rgba.len() != side * side * 4 {
        return None;
    }
    let pixels = ColorImage::from_rgba_unmultiplied([side, side], &picture.rgba);
    let name = format!("task {number}");
    Some(ui.ctx().load_texture(name, pixels, TextureOptions::LINEAR))
}

/// Lays the page out.
pub(super) fn show(ui: &mut Ui, view: &View<'_>, pictures: &mut Pictures, wishes: &mut Vec<Wish>) {
    let Some(study) = view.world.study() else {
        return;
    };
    let language = view.settings.language;
    let words = language.study();
    let frame = egui::Frame::new().fill(PAPER).inner_margin(12.0);
    egui::CentralPanel::default().frame(frame).show(ui, |ui| {
        let [page, pages] = study.place();
        ui.label(RichText::new(format!("{page} / {pages}")).color(MESSAGE));
        match study.page() {
            Page::Welcome => told(ui, words.welcome, words.welcome_text),
            Page::Thanks => told(ui, words.thanks, words.thanks_text),
            Page::Task(number) => task(ui, study, number, language, pictures, wishes),
            Page::Questions(part, from, to) => {
                questions(ui, study, part, from..to, words, wishes);
            }
        }
        ui.with_layout(Layout::bottom_up(Align::Min), |ui| {
            footer(ui, study, words, wishes);
        });
    });
}

fn title(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).color(TITLE).size(19.0));
}

fn told(ui: &mut Ui, head: &str, text: &str) {
    title(ui, head);
    ui.add_space(8.0);
    ui.label(RichText::new(text).size(17.0));
}

/// From the lower edge upwards.
fn footer(ui: &mut Ui, study: &Study, words: &StudyWords, wishes: &mut Vec<Wish>) {
    let size = vec2(110.0, 34.0);
    // A row begins as high as small parts are, and grows down.
    ui.add_space(size.y - ui.spacing().interact_size.y);
    ui.horizontal(|ui| {
        let mut button = |ui: &mut Ui, can, name, event| {
            let button = Button::new(RichText::new(name).size(16.0)).min_size(size);
            if ui.add_enabled(can, button).clicked() {
                wishes.push(Wish::Study(event));
            }
        };
        button(ui, study.can_go_back(), words.back, Event::Back);
        button(ui, study.can_go_on(), words.next, Event::Next);
    });
    if let Some(missing) = study.missing_told() {
        let text = words.missing.replace("{}", &missing.to_string());
        ui.label(RichText::new(text).color(MESSAGE));
    }
}

fn questions(
    ui: &mut Ui,
    study: &Study,
    part: Part,
    items: std::ops::Range<usize>,
    words: &StudyWords,
    wishes: &mut Vec<Wish>,
) {
    let head = match part {
        Part::SsqBefore => words.how_before,
        Part::SsqAfter => words.how_after,
        Part::Sus => words.statements,
        Part::Own => words.own_statements,
    };
    title(ui, head);
    ui.add_space(4.0);
    match part {
        Part::SsqBefore | Part::SsqAfter => {
            heading(ui, words.severity);
            for item in items {
                ui.horizontal(|ui| {
                    let name = words.symptoms.get(item).copied().unwrap_or_default();
                    fixed(ui, SYMPTOM, |ui| {
                        ui.add(egui::Label::new(RichText::new(name).size(15.0)).wrap());
                    });
                    scale(ui, study, (part, item), CELLS[0], wishes);
                });
            }
        }
        Part::Sus | Part::Own => {
            ui.horizontal(|ui| {
                ui.label(words.disagree);
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    ui.label(words.agree);
                });
            });
            for item in items {
                let own = study.plan().statements.get(item).map(String::as_str);
                let text = match part {
                    Part::Own => own,
                    _ => words.sus.get(item).copied(),
                };
                ui.label(RichText::new(text.unwrap_or_default()).size(15.0));
                ui.horizontal(|ui| scale(ui, study, (part, item), CELLS[1], wishes));
                ui.add_space(2.0);
            }
        }
    }
}

/// A place of a width, whatever is in it.
fn fixed(ui: &mut Ui, width: f32, add: impl FnOnce(&mut Ui)) {
    let size = vec2(width, 34.0);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_size(size);
        ui.set_max_width(width);
        add(ui);
    });
}

/// The names of severities over their columns.
fn heading(ui: &mut Ui, names: [&str; 4]) {
    ui.horizontal(|ui| {
        ui.add_space(SYMPTOM);
        ui.add_space(ui.spacing().item_spacing.x);
        for name in names {
            let size = vec2(CELLS[0], 20.0);
            ui.add_sized(
                size,
                egui::Label::new(RichText::new(name).size(14.0)).extend(),
            );
        }
    });
}

/// The answers to an item, of which one may be chosen.
fn scale(
    ui: &mut Ui,
    study: &Study,
    (part, item): (Part, usize),
    width: f32,
    wishes: &mut Vec<Wish>,
) {
    let [least, most] = part.range();
    for value in least..=most {
        let chosen = study.answer(part, item) == Some(value);
        let button = Button::selectable(chosen, value.to_string())
            .frame_when_inactive(true)
            .min_size(vec2(width, CELL_HEIGHT));
        if ui.add(button).clicked() {
            wishes.push(Wish::Study(Event::Answer(part, item, value)));
        }
    }
}

fn task(
    ui: &mut Ui,
    study: &Study,
    number: usize,
    language: Language,
    pictures: &mut Pictures,
    wishes: &mut Vec<Wish>,
) {
    let words = language.study();
    let Some((task, result)) = study.task() else {
        return;
    };
    let of = study.plan().tasks.len();
    title(ui, &format!("{} {} / {of}", words.task, number + 1));
    let text = match (language, &task.german) {
        (Language::German, Some(german)) => german,
        _ => &task.text,
    };
    ui.label(RichText::new(text).size(16.0));
    ui.vertical_centered(|ui| match pictures.get(ui, number) {
        Some(picture) => {
            ui.image((picture.id(), vec2(PICTURE, PICTURE)));
        }
        // What stands below stays where it is, with and without a picture.
        None => ui.add_space(PICTURE),
    });
    let (name, seconds) = match (result, study.seconds_left()) {
        (None, Some(left)) => (words.time_left, left),
        (result, _) => (words.time, result.map_or(0.0, |result| result.seconds)),
    };
    ui.label(
        RichText::new(format!("{name}: {}", clock(seconds)))
            .color(TITLE)
            .size(18.0),
    );
    ui.horizontal(|ui| {
        let mut button = |name, event| {
            let button = Button::new(RichText::new(name).size(16.0)).min_size(vec2(130.0, 34.0));
            if ui.add(button).clicked() {
                wishes.push(Wish::Study(event));
            }
        };
        match result.map(|result| result.outcome) {
            None if study.is_running() => {
                button(words.done, Event::Done);
                button(words.leave, Event::Leave);
            }
            None if study.is_begun() => button(words.go_on, Event::Begin),
            None => button(words.begin, Event::Begin),
            Some(outcome) => {
                let text = match outcome {
                    Outcome::Done => words.is_done,
                    Outcome::TimeOver => words.is_over,
                    Outcome::Left => words.is_left,
                };
                ui.label(RichText::new(text).color(MESSAGE).size(16.0));
            }
        }
    });
}

/// Minutes and seconds, begun ones as whole ones.
fn clock(seconds: f64) -> String {
    // No task takes longer than a day.
    let seconds = seconds.clamp(0.0, 1e6).ceil();
    let minutes = (seconds / 60.0).floor();
    format!("{minutes}:{:02}", seconds - minutes * 60.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::clock;

    #[test]
    fn times_are_minutes_and_seconds() {
        for (seconds, said) in [
            (0.0, "0:00"),
            (0.2, "0:01"),
            (60.0, "1:00"),
            (119.5, "2:00"),
            (3600.0, "60:00"),
        ] {
            assert_eq!(clock(seconds), said);
        }
    }
}
