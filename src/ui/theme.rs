//! How panels look: dark paper, light ink, and parts large enough for an unsteady hand.
//!
//! Colours are Okabe and Ito's (<https://jfly.uni-koeln.de/color/>); contrast of ink on paper is about 12 : 1.

use egui::{Color32, CornerRadius, Stroke, vec2};

pub(super) const PAPER: Color32 = Color32::from_rgb(24, 29, 33);
pub(super) const INK: Color32 = Color32::from_rgb(222, 226, 220);
pub(super) const TITLE: Color32 = Color32::from_rgb(244, 238, 214);
/// Okabe–Ito orange: told apart from the ink by everyone.
pub(super) const MESSAGE: Color32 = Color32::from_rgb(230, 159, 0);
/// Smallest text of panels, and the text of the board, which stands farther away; points. Both are a degree high at least from where a head is.
pub(super) const SMALLEST: f32 = 14.0;
pub(super) const BOARD_TEXT: f32 = 15.0;
/// What can be used, what is under the hand, what is chosen.
const PART: Color32 = Color32::from_rgb(48, 57, 64);
const UNDER: Color32 = Color32::from_rgb(70, 84, 95);
const CHOSEN: Color32 = Color32::from_rgb(0, 98, 150);

/// Dresses a context.
pub(super) fn apply(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.options_mut(|options| {
        // A hand in the air moves while it pulls, and takes its time: 25 mm are still a click.
        options.input_options.max_click_dist = 16.0;
        options.input_options.max_click_duration = 3.0;
    });
    context.all_styles_mut(|style| {
        // Nothing moves by itself, so nothing is laid out again for it.
        style.animation_time = 0.0;
        style.spacing.interact_size = vec2(44.0, 25.0);
        style.spacing.slider_width = 170.0;
        style.spacing.slider_rail_height = 10.0;
        style.spacing.item_spacing = vec2(7.0, 6.0);
        style.spacing.button_padding = vec2(9.0, 4.0);
        style.spacing.icon_width = 20.0;
        style.spacing.icon_width_inner = 13.0;
        style.spacing.scroll.bar_width = 12.0;
        style.spacing.scroll.floating = false;
        style.spacing.scroll.foreground_color = false;
        // A drag of a panel's text would select it and move nothing.
        style.interaction.selectable_labels = false;
        style.interaction.interact_radius = 6.0;
        for font in style.text_styles.values_mut() {
            font.size = font.size.max(SMALLEST);
        }
        let visuals = &mut style.visuals;
        visuals.panel_fill = PAPER;
        visuals.window_fill = PAPER;
        visuals.override_text_color = Some(INK);
        visuals.selection.bg_fill = CHOSEN;
        visuals.selection.stroke = Stroke::new(1.0, INK);
        visuals.extreme_bg_color = Color32::from_rgb(12, 15, 17);
        visuals.text_cursor.blink = false;
        let widgets = &mut visuals.widgets;
        for (part, fill) in [
            (&mut widgets.inactive, PART),
            (&mut widgets.hovered, UNDER),
            (&mut widgets.active, CHOSEN),
            (&mut widgets.open, PART),
        ] {
            part.bg_fill = fill;
            part.weak_bg_fill = fill;
            part.corner_radius = CornerRadius::same(5);
            part.expansion = 0.0;
        }
        widgets.hovered.bg_stroke = Stroke::new(1.5, MESSAGE);
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "each shows the figures")]
    use glam::Vec3;

    use super::*;
    use crate::ui::LayoutParams;
    use crate::world::scene::Scene;
    use crate::world::{World, history::History};

    /// The study's users could not read small print; a degree is what the guides of headsets ask for at least.
    #[test]
    fn text_is_a_degree_high_for_those_who_sit_and_those_who_stand() {
        let mut scene = Scene::default();
        World::new(History::default()).scene(&mut scene);
        let LayoutParams {
            pixels_per_metre,
            pixels_per_point,
        } = LayoutParams::default();
        let board = scene.board.iter().map(|b| (b.world_from_board, BOARD_TEXT));
        let panels = scene.panels.iter().map(|p| (p.world_from_panel, SMALLEST));
        let mut seen = 0;
        for (place, points) in board.chain(panels) {
            for height in [1.2, 1.6] {
                let distance = (Vec3::from(place.translation) - Vec3::Y * height).length();
                let metres = points * pixels_per_point / pixels_per_metre;
                let degrees = (metres / distance).atan().to_degrees();
                assert!(degrees >= 1.0, "{degrees}° from {distance} m");
                seen += 1;
            }
        }
        assert_eq!(seen, 4, "the board and the bench");
        let context = egui::Context::default();
        apply(&context);
        let style = context.global_style();
        let smallest = style.text_styles.values().map(|font| font.size);
        assert_eq!(smallest.fold(f32::MAX, f32::min), SMALLEST);
    }
}
