//! Panels in the stage, laid out by egui: content in, painted triangles out.
//!
//! The board by the platform shows the step, the L-string, the rules, the buttons and
//! messages. `ui` only lays it out: it knows neither Vulkan (`render` paints the
//! triangles) nor tools (`world` writes the text). A board is laid out again only
//! when its revision changes, so a warm frame costs nothing here.

use egui::epaint::{ClippedPrimitive, textures::TexturesDelta};
use egui::{Color32, RichText, ScrollArea};

use crate::world::scene::{Board, BoardContent};

/// How densely boards are laid out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LayoutParams {
    /// Pixels of the panel's image for each metre of the board.
    pub pixels_per_metre: f32,
    /// Pixels for each of egui's points: the size of text.
    pub pixels_per_point: f32,
}

impl Default for LayoutParams {
    /// At a metre's distance a line of the board is about 1.2° high (rendering.md §5 asks for 1°–1.5°).
    fn default() -> Self {
        Self {
            pixels_per_metre: 1280.0,
            pixels_per_point: 2.0,
        }
    }
}

/// A laid out panel, ready for the renderer. The receiver applies `textures` before it paints.
#[derive(Debug)]
pub struct Painted {
    /// Width and height of the panel's image in pixels.
    pub size_px: [u32; 2],
    /// Pixels for each of egui's points, in which the primitives are given.
    pub pixels_per_point: f32,
    /// The triangles, back to front.
    pub primitives: Vec<ClippedPrimitive>,
    /// Changed textures (glyphs), to be applied before painting.
    pub textures: TexturesDelta,
}

/// Lays out the board; keeps egui's fonts and what was shown last.
#[derive(Default)]
pub struct BoardUi {
    context: egui::Context,
    params: LayoutParams,
    shown: Option<(u64, [f32; 2])>,
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
    pub fn lay_out(&mut self, board: &Board) -> Option<Painted> {
        let key = (board.revision, board.size);
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
        let output = self
            .context
            .run_ui(input, |ui| show_board(ui, &board.content));
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

/// Rounds a pixel count up and holds it within what every device can make an image of.
fn whole_pixels(pixels: f32) -> u32 {
    const LARGEST: f32 = 4096.0;
    let held = if pixels.is_finite() {
        pixels.ceil().clamp(1.0, LARGEST)
    } else {
        1.0
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "held between 1 and 4096 just above"
    )]
    let whole = held as u32;
    whole
}

const PAPER: Color32 = Color32::from_rgb(24, 29, 33);
const INK: Color32 = Color32::from_rgb(222, 226, 220);
const TITLE: Color32 = Color32::from_rgb(244, 238, 214);
/// Okabe–Ito orange: told apart from the ink by everyone.
const MESSAGE: Color32 = Color32::from_rgb(230, 159, 0);

fn show_board(ui: &mut egui::Ui, content: &BoardContent) {
    let frame = egui::Frame::new()
        .fill(PAPER)
        .inner_margin(14.0)
        .corner_radius(10.0);
    egui::CentralPanel::default().frame(frame).show(ui, |ui| {
        ui.label(
            RichText::new(&content.title)
                .color(TITLE)
                .size(22.0)
                .strong(),
        );
        if let Some(message) = &content.message {
            ui.label(RichText::new(message).color(MESSAGE).size(17.0));
        }
        ui.separator();
        ScrollArea::vertical().show(ui, |ui| {
            for line in &content.lines {
                ui.label(RichText::new(line).color(INK).monospace().size(14.0));
            }
        });
    });
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
        let mut first = ui.lay_out(&board(1, 3)).into_iter().collect::<Vec<_>>();
        assert_eq!(first.len(), 1);
        assert_eq!(first[0].size_px, [1024, 640]);
        assert!(!first[0].primitives.is_empty());
        assert!(
            !first[0].textures.is_empty(),
            "the glyphs come with the first layout"
        );
        first[0].textures.clear();
        assert!(ui.lay_out(&board(1, 3)).is_none());
        assert!(ui.lay_out(&board(2, 3)).is_some_and(|mut painted| {
            painted.textures.clear();
            true
        }));
    }

    #[test]
    fn text_stays_within_the_panel() {
        let mut ui = BoardUi::default();
        let Some(mut painted) = ui.lay_out(&board(1, 500)) else {
            panic!("nothing laid out")
        };
        painted.textures.clear();
        for clipped in &painted.primitives {
            assert!(clipped.clip_rect.max.y <= 640.0 / 2.0 + 1.0);
        }
    }

    #[test]
    fn absurd_sizes_are_held() {
        for (pixels, expected) in [
            (f32::NAN, 1),
            (-4.0, 1),
            (f32::INFINITY, 1),
            (1e9, 4096),
            (10.2, 11),
        ] {
            assert_eq!(whole_pixels(pixels), expected, "{pixels}");
        }
    }
}
