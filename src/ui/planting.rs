//! What is set of the brush that plants: how far apart trees stand, how much their sizes differ, and that all go.

use egui::{Button, RichText, Slider, SliderClamping, Ui};

use super::panels::View;
use super::theme::MESSAGE;
use super::words::Words;
use crate::world::DrawSettings;
use crate::world::document::Edit;
use crate::world::grove::PLANTS_MOST;

/// Lays the brush's settings out; gives the edit that uproots everything, when it was asked for twice.
pub(super) fn show(
    ui: &mut Ui,
    view: &View<'_>,
    words: &'static Words,
    draw: &mut DrawSettings,
    asks: &mut bool,
) -> Option<Edit> {
    ui.label(words.plant_how);
    let [least, most] = DrawSettings::PLANT_SPACING;
    ui.label(words.plant_spacing);
    let slider = Slider::new(&mut draw.plant_spacing, least..=most)
        .logarithmic(true)
        .max_decimals(1)
        .suffix(" m");
    ui.add(slider.clamping(SliderClamping::Edits));
    let [least, most] = DrawSettings::PLANT_VARY.map(|part| part * 100.0);
    ui.label(words.plant_vary);
    let mut percent = draw.plant_vary * 100.0;
    let slider = Slider::new(&mut percent, least..=most)
        .max_decimals(0)
        .suffix(" %");
    if ui.add(slider.clamping(SliderClamping::Edits)).changed() {
        draw.plant_vary = percent / 100.0;
    }
    ui.separator();
    let many = view.document.grove.plants.len();
    ui.label(format!("{many} / {PLANTS_MOST} {}", words.planted));
    uproot_all(ui, many, words, asks)
}

/// Uproots everything, when it is asked twice.
fn uproot_all(ui: &mut Ui, many: usize, words: &'static Words, asks: &mut bool) -> Option<Edit> {
    *asks &= many > 0;
    if !*asks {
        let button = Button::new(words.uproot_all);
        *asks = ui.add_enabled(many > 0, button).clicked();
        return None;
    }
    let really = RichText::new(words.really_uproot).color(MESSAGE);
    let mut edit = None;
    ui.horizontal(|ui| {
        if ui.button(really).clicked() {
            *asks = false;
            edit = Some(Edit::Uproot {
                trees: (0..u32::try_from(many).unwrap_or(u32::MAX)).collect(),
            });
        }
        if ui.button(words.keep).clicked() {
            *asks = false;
        }
    });
    edit
}
