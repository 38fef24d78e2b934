//! The board by the platform: step, L-string, rules, buttons and messages, to be read.
//!
//! It is laid out again only when its revision changes, so a warm frame costs nothing here.

use egui::{RichText, ScrollArea};

use super::{
    LayoutParams, Painted,
    theme::{BOARD_TEXT, INK, MESSAGE, PAPER, TITLE},
    whole_pixels,
    words::Language,
};
use crate::world::scene::{Board, BoardContent};

/// Lays out the board; keeps egui's fonts and what was shown last.
#[derive(Default)]
pub struct BoardUi {
    context: egui::Context,
    params: LayoutParams,
    shown: Option<(u64, [f32; 2], Language)>,
}

impl BoardUi {
    /// A board with the given density.
    #[must_use]
    pub fn new(params: LayoutParams) -> Self {
        Self {
            context: egui::Context::default(),
            params,
            shown: None,
        }
    }

    /// Lays the board out, or gives `None` where what was given last still holds.
    pub fn lay_out(&mut self, board: &Board, language: Language) -> Option<Painted> {
        let key = (board.revision, board.size, language);
        if self.shown == Some(key) {
            return None;
        }
        self.shown = Some(key);
        let LayoutParams {
            pixels_per_metre,
            pixels_per_point,
        } = self.params;
        let size_px = board
            .size
            .map(|metres| whole_pixels(metres * pixels_per_metre));
        let size_points = egui::vec2(
            size_px[0] as f32 / pixels_per_point,
            size_px[1] as f32 / pixels_per_point,
        );
        let mut input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, size_points)),
            ..Default::default()
        };
        if let Some(viewport) = input.viewports.get_mut(&egui::ViewportId::ROOT) {
            viewport.native_pixels_per_point = Some(pixels_per_point);
        }
        let output = self.context.run_ui(input, |ui| {
            show_board(ui, &board.content, language);
        });
        let primitives = self
            .context
            .tessellate(output.shapes, output.pixels_per_point);
        Some(Painted {
            size_px,
            pixels_per_point: output.pixels_per_point,
            primitives,
            textures: output.textures_delta,
        })
    }
}

/// Returns whether all of it is to be seen.
fn show_board(ui: &mut egui::Ui, content: &BoardContent, language: Language) -> bool {
    let frame = egui::Frame::new()
        .fill(PAPER)
        .inner_margin(14.0)
        .corner_radius(10.0);
    let shown = egui::CentralPanel::default().frame(frame).show(ui, |ui| {
        ui.label(
            RichText::new(&content.title)
                .color(TITLE)
                .size(22.0)
                .strong(),
        );
        if let Some(message) = &content.message {
            ui.label(
                RichText::new(language.say(message))
                    .color(MESSAGE)
                    .size(17.0),
            );
        }
        ui.separator();
        let lines = ScrollArea::vertical().show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            for line in &content.lines {
                ui.label(
                    RichText::new(language.say(line))
                        .color(INK)
                        .monospace()
                        .size(BOARD_TEXT),
                );
            }
        });
        lines.content_size.y <= lines.inner_rect.height()
    });
    shown.inner
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "the assertions speak for themselves"
    )]
    use std::sync::Arc;

    use glam::Affine3A;

    use super::*;
    use crate::world::{board::BoardParams, stage::StageParams};

    fn board(revision: u64, lines: usize) -> Board {
        let content = BoardContent {
            title: "Step 3".to_owned(),
            lines: (0..lines).map(|i| format!("A({i})[C(0)B]")).collect(),
            message: Some("Nothing to undo.".to_owned()),
        };
        Board {
            world_from_board: Affine3A::IDENTITY,
            size: [0.8, 0.5],
            revision,
            content: Arc::new(content),
        }
    }

    #[test]
    fn a_board_is_laid_out_once_for_each_revision() {
        let mut ui = BoardUi::default();
        let mut first = ui
            .lay_out(&board(1, 3), Language::English)
            .into_iter()
            .collect::<Vec<_>>();
        assert_eq!(first.len(), 1);
        assert_eq!(first[0].size_px, [1024, 640]);
        assert!(!first[0].primitives.is_empty());
        assert!(
            !first[0].textures.is_empty(),
            "the glyphs come with the first layout"
        );
        first[0].textures.clear();
        assert!(ui.lay_out(&board(1, 3), Language::English).is_none());
        assert!(
            ui.lay_out(&board(2, 3), Language::English)
                .is_some_and(|mut painted| {
                    painted.textures.clear();
                    true
                })
        );
    }

    /// Nobody scrolls the board: what does not fit is not read.
    #[test]
    fn the_fullest_board_shows_all_its_lines() {
        let size = StageParams::default().board_size.map(|metres| {
            let LayoutParams {
                pixels_per_metre,
                pixels_per_point,
            } = LayoutParams::default();
            metres * pixels_per_metre / pixels_per_point
        });
        let most = BoardParams::default();
        let fits = |lines| {
            let mut board = (*board(1, lines).content).clone();
            board.lines[0] = "M".repeat(most.columns);
            let rect = egui::Rect::from_min_size(egui::Pos2::ZERO, size.into());
            let input = egui::RawInput {
                screen_rect: Some(rect),
                ..Default::default()
            };
            let mut fits = false;
            let mut output = egui::Context::default().run_ui(input, |ui| {
                fits = show_board(ui, &board, Language::German);
            });
            output.textures_delta.clear();
            fits
        };
        assert!(fits(most.lines()));
        assert!(!fits(2 * most.lines()));
    }

    #[test]
    fn text_stays_within_the_panel() {
        let mut ui = BoardUi::default();
        let Some(mut painted) = ui.lay_out(&board(1, 500), Language::English) else {
            panic!("nothing laid out")
        };
        painted.textures.clear();
        for clipped in &painted.primitives {
            assert!(clipped.clip_rect.max.y <= 640.0 / 2.0 + 1.0);
        }
    }
}
