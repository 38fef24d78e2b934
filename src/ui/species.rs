//! The bench's tab of species: what to begin with, how it grows, and what it wears.

use std::path::PathBuf;

use egui::{ColorImage, ScrollArea, Slider, SliderClamping, TextureHandle, TextureOptions, Ui};

use super::{
    panels::{Recent, View, Wish},
    previews::Row,
    words::Words,
};
use crate::sketch::habit::{Habit, LAWS, MOST_BEARS};
use crate::tree::bark::Bark;
use crate::tree::foliage::{Bare, Bearing, Season, USUAL_FLARE, kinds};
use crate::world::document::Edit;
use crate::world::species::SPECIES;

/// Width and height of a picture, points.
const SIDE: f32 = 58.0;
/// Tiles in a row.
const ROW: usize = 4;

/// See the module.
#[derive(Default)]
pub(super) struct SpeciesTab {
    pictures: Vec<Option<TextureHandle>>,
    /// A person's own projects, with their pictures.
    own: Vec<(PathBuf, Option<TextureHandle>)>,
    recent: Vec<Recent>,
    /// The next individuals of the tree on the platform.
    pub(super) row: Row,
}

impl SpeciesTab {
    /// Offers a person's own projects beside the species.
    pub(super) fn offer(&mut self, recent: Vec<Recent>) {
        self.recent = recent;
        self.own.clear();
    }

    /// Pictures are given to another egui with the next look.
    pub(super) fn load_anew(&mut self) {
        self.pictures.clear();
        self.own.clear();
        self.row.load_anew();
    }

    /// Lays the tab out.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &'static Words,
        wishes: &mut Vec<Wish>,
    ) {
        self.load(ui);
        ui.label(words.begin_with);
        let all: Vec<_> = SPECIES
            .iter()
            .zip(&self.pictures)
            .zip(words.species())
            .collect();
        for row in all.chunks(ROW) {
            ui.horizontal(|ui| {
                for ((species, picture), name) in row {
                    if tile(ui, picture.as_ref(), name) {
                        wishes.push(Wish::Edit(species.edit()));
                    }
                }
            });
        }
        if !self.own.is_empty() {
            ui.label(words.own_species);
            ScrollArea::horizontal().show(ui, |ui| {
                ui.horizontal(|ui| {
                    for (project, picture) in &self.own {
                        let name = project.file_stem().unwrap_or_default().to_string_lossy();
                        if tile(ui, picture.as_ref(), &name) {
                            wishes.push(Wish::TakeSketch(project.clone()));
                        }
                    }
                });
            });
        }
        ui.separator();
        let mut page = Page {
            habit: Habit::clone(&view.document.sketch.habit),
            bare: view.world.bare(),
            words,
            wishes,
        };
        page.individual(ui);
        self.row.show(ui, view, words, page.wishes);
        page.laws(ui);
        ui.separator();
        page.dress(ui);
    }

    fn load(&mut self, ui: &Ui) {
        if self.pictures.is_empty() {
            self.pictures = SPECIES
                .iter()
                .map(|species| load(ui, species.name, species.picture))
                .collect();
        }
        if self.own.len() != self.recent.len() {
            let own = self.recent.iter().map(|recent| {
                let picture = recent
                    .picture
                    .as_ref()
                    .filter(|picture| picture.rgba.len() == picture.side * picture.side * 4);
                let texture = picture.map(|picture| {
                    let pixels =
                        ColorImage::from_rgba_unmultiplied([picture.side; 2], &picture.rgba);
                    ui.ctx().load_texture(
                        recent.project.to_string_lossy(),
                        pixels,
                        TextureOptions::LINEAR,
                    )
                });
                (recent.project.clone(), texture)
            });
            self.own = own.collect();
        }
    }
}

/// A picture with its name under it; whether it was pressed.
fn tile(ui: &mut Ui, picture: Option<&TextureHandle>, name: &str) -> bool {
    ui.vertical(|ui| {
        let pressed = picture.is_some_and(|picture| {
            let image = egui::Image::new((picture.id(), egui::vec2(SIDE, SIDE)));
            ui.add(egui::Button::image(image)).clicked()
        });
        ui.button(name).clicked() || pressed
    })
    .inner
}

fn load(ui: &Ui, name: &str, png: &[u8]) -> Option<TextureHandle> {
    let picture = image::load_from_memory(png).ok()?.to_rgba8();
    let size = [picture.width() as usize, picture.height() as usize];
    let pixels = ColorImage::from_rgba_unmultiplied(size, picture.as_raw());
    Some(ui.ctx().load_texture(name, pixels, TextureOptions::LINEAR))
}

/// The tab below the pictures: each control changes a copy of the habit and wishes for it.
struct Page<'a> {
    habit: Habit,
    /// What the tree that is shown does not bear.
    bare: &'a [Bare],
    words: &'static Words,
    wishes: &'a mut Vec<Wish>,
}

impl Page<'_> {
    fn set(&mut self, at_once: bool) {
        let edit = Edit::SetHabit {
            to: Box::new(self.habit.clone()),
        };
        self.wishes.push(if at_once {
            Wish::Edit(edit)
        } else {
            Wish::TryOut(edit)
        });
    }

    /// A slider whose last place is one edit.
    fn slider(&mut self, ui: &mut Ui, slider: Slider<'_>) -> bool {
        let answer = ui.add(slider.clamping(SliderClamping::Edits));
        if answer.drag_stopped() || (answer.changed() && !answer.dragged()) {
            // After what it is set to, which the caller wishes for first.
            self.wishes.push(Wish::Settle);
        }
        answer.changed()
    }

    fn individual(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.label(format!("{} {}", self.words.individual, self.habit.seed));
            if ui.button(self.words.another).clicked() {
                self.habit.seed = self.habit.seed.wrapping_add(1);
                self.set(true);
            }
        });
    }

    fn laws(&mut self, ui: &mut Ui) {
        for (at, (name, (law, [least, most]))) in
            self.words.laws().into_iter().zip(LAWS).enumerate()
        {
            ui.label(name);
            let mut value = self.habit.law(at);
            let before = self.wishes.len();
            let unit = if at < 2 { "°" } else { "" };
            let slider = Slider::new(&mut value, least..=most)
                .max_decimals(if law == "length" { 0 } else { 2 })
                .suffix(unit);
            if self.slider(ui, slider) {
                self.habit.set_law(at, value);
                self.try_out_before(before);
            }
        }
    }

    /// Wishes for what is set, before the settling that came after `before`.
    fn try_out_before(&mut self, before: usize) {
        let settle: Vec<Wish> = self.wishes.drain(before..).collect();
        self.set(false);
        self.wishes.extend(settle);
    }

    fn dress(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            for (season, name) in Season::ALL.into_iter().zip(self.words.seasons()) {
                let chosen = self.habit.season == season;
                if ui.selectable_label(chosen, name).clicked() && !chosen {
                    self.habit.season = season;
                    self.set(true);
                }
            }
        });
        ui.label(self.words.bark);
        ui.horizontal_wrapped(|ui| {
            let none = self.habit.bark.is_none();
            if ui.selectable_label(none, self.words.nothing).clicked() && !none {
                self.habit.bark = None;
                self.set(true);
            }
            for bark in Bark::ALL {
                let chosen = self.habit.bark == Some(bark);
                if ui.selectable_label(chosen, bark.name()).clicked() && !chosen {
                    if none {
                        self.habit.flare = USUAL_FLARE;
                    }
                    self.habit.bark = Some(bark);
                    self.set(true);
                }
            }
        });
        ui.label(self.words.bears);
        let bearings = self.habit.bearings().unwrap_or_default();
        for (at, bearing) in bearings.into_iter().enumerate() {
            ui.push_id(at, |ui| self.bearing(ui, at, bearing));
        }
        if self.habit.bears.len() < MOST_BEARS {
            ui.horizontal_wrapped(|ui| {
                for kind in kinds() {
                    if ui.button(format!("+ {}", kind.name)).clicked() {
                        self.habit.bears.push(kind.name.to_owned());
                        self.set(true);
                    }
                }
            });
        }
    }

    /// One kind of leaf: how large, how dense, on which twigs.
    fn bearing(&mut self, ui: &mut Ui, at: usize, mut bearing: Bearing) {
        ui.separator();
        ui.horizontal(|ui| {
            ui.label(&bearing.name);
            if ui.button(self.words.take_away).clicked() {
                self.habit.bears.remove(at);
                self.set(true);
            }
        });
        let line = bearing.to_string();
        if let Some(bare) = self.bare.iter().find(|bare| bare.bearing == line) {
            let why = match bare.light {
                Some(_) => self.words.bare_dark,
                None => self.words.bare_twigs,
            };
            ui.label(why);
        }
        let numbers = [
            ("size", 0.005, 1.0, true),
            ("every", 0.005, 2.0, true),
            ("droop", 0.0, 1.0, false),
            ("young", 1.0, 40.0, true),
        ];
        for ((name, least, most, logarithmic), word) in
            numbers.into_iter().zip(self.words.leaf_numbers())
        {
            let mut value = bearing.get(name).unwrap_or(least).min(most);
            let before = self.wishes.len();
            let slider = Slider::new(&mut value, least..=most)
                .logarithmic(logarithmic)
                .max_decimals(3)
                .text(word);
            if self.slider(ui, slider) {
                // At its end the slider means all twigs, however old.
                let all = name == "young" && value >= most;
                bearing.set(name, if all { f32::MAX } else { value });
                if let Some(line) = self.habit.bears.get_mut(at) {
                    *line = bearing.to_string();
                }
                self.try_out_before(before);
            }
        }
    }
}
