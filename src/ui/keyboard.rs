//! The keyboard: keys that type into whatever takes text on another panel.

use egui::{Event, Key, Modifiers, Ui, vec2};

use super::{theme::PAPER, words::Words};

/// The rows of characters; all that grammars are written with is here.
const ROWS: [&str; 5] = [
    "1234567890.,;:",
    "qwertyuiop()[]",
    "asdfghjkl{}<>|",
    "zxcvbnm_+-*/%^",
    "&!=~$#@?'\"\\",
];

/// The keyboard's state.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Keyboard {
    capitals: bool,
}

impl Keyboard {
    /// Lays the keys out; `typed` takes what they type, and the answer says whether it is to be closed.
    pub(super) fn show(&mut self, ui: &mut Ui, words: &Words, typed: &mut Vec<Event>) -> bool {
        let frame = egui::Frame::new().fill(PAPER).inner_margin(8.0);
        let mut close = false;
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            ui.spacing_mut().item_spacing = vec2(3.0, 3.0);
            ui.spacing_mut().button_padding = vec2(2.0, 2.0);
            for row in ROWS {
                ui.horizontal(|ui| {
                    for key in row.chars() {
                        self.character(ui, key, typed);
                    }
                });
            }
            ui.horizontal(|ui| {
                ui.toggle_value(&mut self.capitals, "ABC");
                if ui.button(words.space).clicked() {
                    typed.push(Event::Text(" ".into()));
                }
                for (name, key) in [
                    (words.delete, Key::Backspace),
                    ("<", Key::ArrowLeft),
                    (">", Key::ArrowRight),
                    (words.enter, Key::Enter),
                ] {
                    if ui.button(name).clicked() {
                        typed.extend([true, false].map(|pressed| press(key, pressed)));
                    }
                }
                close = ui.button(words.close).clicked();
            });
        });
        close
    }

    fn character(self, ui: &mut Ui, key: char, typed: &mut Vec<Event>) {
        let key = if self.capitals {
            key.to_ascii_uppercase()
        } else {
            key
        };
        let button = egui::Button::new(key.to_string()).min_size(vec2(22.0, 22.0));
        if ui.add(button).clicked() {
            typed.push(Event::Text(key.into()));
        }
    }
}

fn press(key: Key, pressed: bool) -> Event {
    Event::Key {
        key,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    }
}
