//! The projects that somebody worked on, with their pictures, to go on with.

use egui::{ColorImage, TextureHandle, TextureOptions, Ui};

use super::{
    panels::{Recent, Wish},
    words::Words,
};

/// Width and height of a picture, points.
const SIDE: f32 = 64.0;

/// See the module.
#[derive(Default)]
pub(super) struct Projects {
    recent: Vec<Recent>,
    /// As they were given to egui; they come with the first look.
    pictures: Vec<Option<TextureHandle>>,
}

impl Projects {
    pub(super) fn of(recent: Vec<Recent>) -> Self {
        Self {
            recent,
            pictures: Vec::new(),
        }
    }

    /// Lays the list out.
    pub(super) fn show(&mut self, ui: &mut Ui, words: &Words, wishes: &mut Vec<Wish>) {
        if self.recent.is_empty() {
            return;
        }
        if self.pictures.len() != self.recent.len() {
            let load = |recent: &Recent| load(ui, recent);
            self.pictures = self.recent.iter().map(load).collect();
        }
        ui.label(words.recent);
        for (number, (recent, picture)) in self.recent.iter().zip(&self.pictures).enumerate() {
            ui.push_id(number, |ui| {
                ui.horizontal(|ui| {
                    if let Some(picture) = picture {
                        ui.image((picture.id(), egui::vec2(SIDE, SIDE)));
                    }
                    ui.vertical(|ui| {
                        let name = recent.project.file_name().unwrap_or_default();
                        ui.label(name.to_string_lossy());
                        if ui.button(words.go_on).clicked() {
                            wishes.push(Wish::Open(recent.project.clone()));
                        }
                    });
                });
            });
        }
    }
}

fn load(ui: &Ui, recent: &Recent) -> Option<TextureHandle> {
    let picture = recent.picture.as_ref()?;
    let side = picture.side;
    if picture.rgba.len() != side * side * 4 {
        return None;
    }
    let pixels = ColorImage::from_rgba_unmultiplied([side, side], &picture.rgba);
    let name = recent.project.to_string_lossy();
    Some(ui.ctx().load_texture(name, pixels, TextureOptions::LINEAR))
}
