//! The rules on the bench: every production, to be read and rewritten; every constant, to be slid.
//!
//! A rule is tried while it is written: what is wrong with it stands under it at once, and nothing changes until it is
//! right and applied.

use egui::{RichText, Slider, SliderClamping, TextEdit, Ui};

use super::{
    panels::{View, Wish},
    theme::{MESSAGE, TITLE},
    words::Words,
};
use crate::{
    sketch::{Sketch, own_rules::FURTHER},
    world::document::Edit,
};

/// A rule that is being written.
#[derive(Clone, Debug)]
struct Draft {
    of: String,
    text: String,
    /// What is wrong with it.
    wrong: Option<String>,
}

/// The farthest that a slider reaches: its ends must be finite.
const MOST: f64 = 1e12;

/// What the tab remembers.
#[derive(Clone, Debug, Default)]
pub(super) struct Rules {
    draft: Option<Draft>,
    /// The slider under a hand and its largest value: its ends stay while it is dragged.
    slid: Option<(usize, f64)>,
}

/// The tab being laid out: what it is about, and what is wanted.
struct Page<'a> {
    sketch: &'a Sketch,
    words: &'static Words,
    wishes: &'a mut Vec<Wish>,
}

/// A production, or the further lines, as they stand there.
struct Row<'a> {
    of: &'a str,
    text: &'a str,
    /// A person wrote it.
    own: bool,
}

impl Rules {
    /// Lays the rules out.
    pub(super) fn show(&mut self, ui: &mut Ui, view: &View<'_>, wishes: &mut Vec<Wish>) {
        let words = view.settings.language.words();
        let sketch = &*view.document.sketch;
        if sketch.is_empty() {
            ui.label(words.nothing_drawn);
            return;
        }
        let mut page = Page {
            sketch,
            words,
            wishes,
        };
        ui.label(words.rules_hint);
        for (number, rule) in sketch.productions().iter().enumerate() {
            ui.separator();
            let row = Row {
                of: &rule.of,
                text: rule.own.as_ref().unwrap_or(&rule.generated),
                own: rule.own.is_some(),
            };
            ui.push_id(number, |ui| self.rule(ui, &row, &mut page));
        }
        ui.separator();
        ui.label(RichText::new(words.further).color(TITLE));
        let further = sketch.own_rules.get(FURTHER).map_or("", String::as_str);
        constants(ui, further, &mut self.slid, page.wishes);
        let row = Row {
            of: FURTHER,
            text: further,
            own: !further.is_empty(),
        };
        ui.push_id(FURTHER, |ui| self.rule(ui, &row, &mut page));
    }

    fn rule(&mut self, ui: &mut Ui, row: &Row<'_>, page: &mut Page<'_>) {
        if let Some(draft) = self.draft.as_mut().filter(|draft| draft.of == row.of) {
            if write(ui, draft, page) {
                self.draft = None;
            }
            return;
        }
        let words = page.words;
        ui.label(RichText::new(row.text).monospace());
        ui.horizontal(|ui| {
            if ui.button(words.edit).clicked() {
                self.draft = Some(Draft {
                    of: row.of.to_owned(),
                    text: row.text.to_owned(),
                    wrong: None,
                });
            }
            if row.own && ui.button(words.generated).clicked() {
                page.wishes.push(set(row.of, None));
            }
            if row.own {
                ui.label(RichText::new(words.own).color(MESSAGE));
            }
        });
    }
}

impl Draft {
    /// Finds out what is wrong with it.
    fn check(&mut self, sketch: &Sketch) {
        let tried = sketch.with_rule(&self.of, Some(&self.text));
        self.wrong = tried.err().map(|error| error.to_string());
    }
}

/// A rule being written; true when it is done with.
fn write(ui: &mut Ui, draft: &mut Draft, page: &mut Page<'_>) -> bool {
    let words = page.words;
    let box_ = TextEdit::multiline(&mut draft.text)
        .code_editor()
        .desired_rows(2)
        .hint_text(words.further_hint)
        .desired_width(f32::INFINITY);
    if ui.add(box_).changed() {
        draft.check(page.sketch);
    }
    if let Some(wrong) = &draft.wrong {
        ui.label(RichText::new(wrong).monospace().color(MESSAGE));
    }
    let mut done = false;
    ui.horizontal(|ui| {
        let apply = egui::Button::new(words.apply);
        if ui.add_enabled(draft.wrong.is_none(), apply).clicked() {
            // Once more: the sketch may have changed since the last letter was typed.
            draft.check(page.sketch);
            if draft.wrong.is_none() {
                page.wishes.push(set(&draft.of, Some(draft.text.clone())));
                done = true;
            }
        }
        done |= ui.button(words.cancel).clicked();
    });
    done
}

fn set(of: &str, to: Option<String>) -> Wish {
    Wish::Edit(Edit::SetRule {
        of: of.to_owned(),
        to,
    })
}

/// A slider for each constant of the further lines.
fn constants(ui: &mut Ui, further: &str, held: &mut Option<(usize, f64)>, wishes: &mut Vec<Wish>) {
    for (number, line) in further.lines().enumerate() {
        let Some((name, value)) = constant(line) else {
            continue;
        };
        let mut slid = value;
        let most = held
            .filter(|(at, _)| *at == number)
            .map_or((value.abs() * 2.0).clamp(1.0, MOST), |(_, most)| most);
        let least = -most;
        let slider = Slider::new(&mut slid, least..=most)
            .clamping(SliderClamping::Edits)
            .text(name)
            .max_decimals(3);
        let answer = ui.add(slider);
        if answer.dragged() {
            *held = Some((number, most));
        } else if held.is_some_and(|(at, _)| at == number) {
            *held = None;
        }
        if answer.changed() {
            let text = with_line(further, number, &format!("const {name} = {slid}"));
            wishes.push(Wish::TryOut(Edit::SetRule {
                of: FURTHER.to_owned(),
                to: Some(text),
            }));
        }
        if answer.drag_stopped() || (answer.changed() && !answer.dragged()) {
            wishes.push(Wish::Settle);
        }
    }
}

/// Name and value of a line that sets a constant to a number.
fn constant(line: &str) -> Option<(&str, f64)> {
    let (name, value) = line.trim().strip_prefix("const ")?.split_once('=')?;
    let value: f64 = value.trim().parse().ok()?;
    value.is_finite().then(|| (name.trim(), value))
}

/// A text with another line in the place of one.
fn with_line(text: &str, number: usize, line: &str) -> String {
    let lines = text.lines().enumerate();
    let lines: Vec<&str> = lines
        .map(|(at, old)| if at == number { line } else { old })
        .collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn constants_are_found_and_set() {
        for (line, expected) in [
            ("const a = 2", Some(("a", 2.0))),
            ("  const long_name=-1.5", Some(("long_name", -1.5))),
            ("const a = b * 2", None),
            ("# const a = 2", None),
            ("const a = inf", None),
            ("A -> B", None),
        ] {
            assert_eq!(constant(line), expected, "{line}");
        }
        assert_eq!(with_line("a\nb\nc", 1, "x"), "a\nx\nc");
        assert_eq!(with_line("a", 5, "x"), "a");
    }
}
