//! The row of the next individuals on the tab of species: each a picture and its seed, to be taken by pressing it.
//!
//! The row stays when one of it is taken, so that others can be tried beside it; *more* goes on to the next ones. It begins anew behind the individual that
//! is there when that is none of the row's.

use egui::{Align2, ColorImage, FontId, Sense, TextureHandle, TextureOptions, Ui, vec2};

use super::panels::{Thumbnail, View, Wish};
use super::theme::{MESSAGE, TITLE};
use super::words::Words;
use crate::sketch::habit::Habit;
use crate::world::document::Edit;
use crate::world::{DrawSettings, DrawTool};

/// Individuals in the row.
pub(super) const MANY: usize = 5;
/// The same, to count seeds with.
const SEEDS: u32 = 5;

/// Width and height of a picture, points.
const SIDE: f32 = 56.0;
/// Between a picture and the edge of its button, points.
const MARGIN: f32 = 3.0;

/// The picture of an individual.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Preview {
    /// Its seed.
    pub seed: u32,
    /// What it looks like, or why there is no picture of it.
    pub picture: Result<Thumbnail, String>,
}

/// What is known of the individuals in the row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Previews {
    /// Those that are ready.
    pub all: Vec<Preview>,
    /// All are the same tree: nothing in the sketch is left to chance.
    pub are_alike: bool,
}

/// The row between looks.
#[derive(Default)]
pub(super) struct Row {
    /// The first seed, and the sketch's when the row was looked at last.
    first: Option<u32>,
    seed: u32,
    given: Previews,
    pictures: Vec<(u32, TextureHandle)>,
}

impl Row {
    /// Takes pictures that were made.
    pub(super) fn give(&mut self, given: Previews) {
        self.given = given;
        self.pictures.clear();
    }

    /// The seeds in the row.
    pub(super) fn seeds(&self) -> Option<[u32; MANY]> {
        let first = self.first?;
        let mut next = first.wrapping_sub(1);
        Some([(); MANY].map(|()| {
            next = next.wrapping_add(1);
            next
        }))
    }

    /// Forgets what is on the device, to be loaded anew.
    pub(super) fn load_anew(&mut self) {
        self.pictures.clear();
    }

    /// Lays the row out.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        view: &View<'_>,
        words: &'static Words,
        wishes: &mut Vec<Wish>,
    ) {
        let document = view.document;
        if document.sketch.is_empty() || document.step == 0 {
            self.first = None;
            ui.label(words.grow_first);
            return;
        }
        let seed = document.sketch.habit.seed;
        // The seed before the row's first is the one that the row began behind.
        let is_near = |first: u32| seed.wrapping_sub(first.wrapping_sub(1)) <= SEEDS;
        let stays = |first: &u32| self.seed == seed || is_near(*first);
        let first = self.first.filter(stays).unwrap_or(seed.wrapping_add(1));
        (self.first, self.seed) = (Some(first), seed);
        self.load(ui);
        // What a thread has made shows where the tiles are, and moves nothing: a session that is played again has other pictures, or none.
        let row = ui.horizontal(|ui| {
            for seed in (0..SEEDS).map(|n| first.wrapping_add(n)) {
                if self.tile(ui, seed, document.sketch.habit.seed == seed) {
                    let to = Habit {
                        seed,
                        ..Habit::clone(&document.sketch.habit)
                    };
                    wishes.push(Wish::Edit(Edit::SetHabit { to: Box::new(to) }));
                }
            }
        });
        if let Some(said) = self.said(words) {
            over(ui, row.response.rect, said);
        }
        ui.horizontal(|ui| {
            let more = egui::Button::new(words.more_individuals);
            if ui.add(more).clicked() {
                self.first = Some(first.wrapping_add(SEEDS));
            }
            let plants = view.draw.tool == DrawTool::Plant;
            let plant = egui::Button::new(words.plant_them).selected(plants);
            if ui.add(plant).clicked() {
                let tool = if plants {
                    DrawTool::Draw
                } else {
                    DrawTool::Plant
                };
                wishes.push(Wish::Draw(DrawSettings { tool, ..view.draw }));
            }
        });
    }

    /// What there is to say of the row: why all are the same, or why there is no picture.
    fn said(&self, words: &Words) -> Option<String> {
        if self.given.are_alike {
            return Some(words.all_alike.to_owned());
        }
        let mut pictures = self.given.all.iter().map(|one| &one.picture);
        let wrong = pictures.find_map(|picture| picture.as_ref().err())?;
        Some(format!("{}: {wrong}.", words.no_pictures))
    }

    fn load(&mut self, ui: &Ui) {
        if !self.pictures.is_empty() {
            return;
        }
        let loaded = self.given.all.iter().filter_map(|one| {
            let picture = one.picture.as_ref().ok()?;
            let size = [picture.side; 2];
            if picture.rgba.len() != picture.side * picture.side * 4 {
                return None;
            }
            let pixels = ColorImage::from_rgba_unmultiplied(size, &picture.rgba);
            let name = format!("individual {}", one.seed);
            let texture = ui.ctx().load_texture(name, pixels, TextureOptions::LINEAR);
            Some((one.seed, texture))
        });
        self.pictures = loaded.collect();
    }

    /// A picture with its seed under it; whether it was pressed.
    fn tile(&self, ui: &mut Ui, seed: u32, is_taken: bool) -> bool {
        let size = vec2(SIDE + 2.0 * MARGIN, SIDE + 2.0 * MARGIN + 20.0);
        let (rect, answer) = ui.allocate_exact_size(size, Sense::click());
        let look = ui.style().interact_selectable(&answer, is_taken);
        let painter = ui.painter();
        painter.rect_filled(rect, 4.0, look.weak_bg_fill);
        let corner = rect.min + vec2(MARGIN, MARGIN);
        let frame = egui::Rect::from_min_size(corner, vec2(SIDE, SIDE));
        let picture = self.pictures.iter().find(|(of, _)| *of == seed);
        match picture {
            Some((_, picture)) => {
                let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
                painter.image(picture.id(), frame, whole, egui::Color32::WHITE);
            }
            None => {
                painter.rect_filled(frame, 2.0, TITLE.gamma_multiply(0.08));
                let dots = FontId::proportional(16.0);
                painter.text(
                    frame.center(),
                    Align2::CENTER_CENTER,
                    "…",
                    dots,
                    look.text_color(),
                );
            }
        }
        let under = egui::pos2(rect.center().x, rect.max.y - 11.0);
        let font = FontId::proportional(14.0);
        painter.text(
            under,
            Align2::CENTER_CENTER,
            seed.to_string(),
            font,
            look.text_color(),
        );
        answer.clicked()
    }
}

/// A sentence over what is there.
fn over(ui: &Ui, rect: egui::Rect, text: String) {
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, ui.visuals().panel_fill.gamma_multiply(0.94));
    let font = FontId::proportional(14.0);
    let laid = painter.layout(text, font, MESSAGE, rect.width() - 2.0 * MARGIN);
    painter.galley(rect.min + vec2(MARGIN, MARGIN), laid, MESSAGE);
}
