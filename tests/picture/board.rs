//! What is seen through, and the board: ghosts, and what egui painted.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use image::RgbaImage;
use ramus::{
    render::{Offscreen, Renderer},
    world::scene::{Board, Scene},
};

use super::support::{SIDE, ahead, ball, device, mode, pixels_per_tangent, plain, shoot, silent};

#[test]
fn ghosts_let_half_of_the_light_through() {
    let Some(gpu) = device() else { return };
    let mut scene = ball(Vec3::ZERO, 0.3, [0.8, 0.8, 0.8, 1.0]);
    let solid = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &ahead(1.0));
    scene.balls[0].color[3] = 0.5;
    // Twice the same ghost: overlaps do not add up.
    scene.balls.push(scene.balls[0]);
    let ghost = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &ahead(1.0));
    let light = |picture: &RgbaImage| {
        let linear = |byte: u8| (f32::from(byte) / 255.0).powf(2.2);
        picture
            .pixels()
            .map(|pixel| linear(pixel.0[1]))
            .sum::<f32>()
    };
    for eye in 0..2 {
        let share = light(&ghost.color[eye]) / light(&solid.color[eye]);
        assert!((share - 0.5).abs() < 0.05, "eye {eye}: {share}");
    }
    silent(&gpu);
}

/// egui's output for a panel of 400 × 250 pixels: four coloured quarters, no text.
fn quarters() -> Vec<egui::ClippedPrimitive> {
    let rect = |x: f32, y: f32, color: egui::Color32| {
        let mut mesh = egui::Mesh::default();
        mesh.add_colored_rect(
            egui::Rect::from_min_size(egui::pos2(x, y), egui::vec2(100.0, 62.5)),
            color,
        );
        egui::ClippedPrimitive {
            clip_rect: egui::Rect::EVERYTHING,
            primitive: egui::epaint::Primitive::Mesh(mesh),
        }
    };
    vec![
        rect(0.0, 0.0, egui::Color32::from_rgb(200, 100, 50)),
        rect(100.0, 0.0, egui::Color32::from_rgb(20, 160, 60)),
        rect(0.0, 62.5, egui::Color32::from_rgb(30, 60, 220)),
        rect(100.0, 62.5, egui::Color32::from_rgb(128, 128, 128)),
    ]
}

#[test]
fn the_board_shows_what_egui_painted_upright_and_in_its_colours() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    let params = plain(mode, 0.0);
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let board = Board {
        world_from_board: Affine3A::IDENTITY,
        size: [0.8, 0.5],
        revision: 1,
        content: Arc::default(),
    };
    let scene = Scene {
        board: Some(board),
        ..Scene::default()
    };
    let eyes = ahead(0.8);
    // A font texture of one white pixel: what `add_colored_rect` refers to.
    let mut textures = egui::TexturesDelta::default();
    let white = egui::ColorImage::filled([2, 2], egui::Color32::WHITE);
    textures.push(
        egui::TextureId::default(),
        egui::epaint::ImageDelta::full(white, egui::TextureOptions::LINEAR),
    );
    for round in 0..3 {
        renderer
            .paint_panel(0, &quarters(), &mut textures, [400, 250], 2.0)
            .unwrap();
        assert!(textures.is_empty(), "taken over");
        renderer.draw(&scene, &eyes, &offscreen.target()).unwrap();
        let pictures = offscreen.read_color().unwrap();
        for (eye, side) in [(0, -0.032), (1, 0.032)] {
            for (x, y, expected) in [
                (-0.2, 0.12, [200, 100, 50]),
                (0.2, 0.12, [20, 160, 60]),
                (-0.2, -0.12, [30, 60, 220]),
                (0.2, -0.12, [128, 128, 128]),
            ] {
                let scale = pixels_per_tangent() / 0.8;
                let half = SIDE as f32 / 2.0;
                let pixel = pictures[eye].get_pixel(
                    (half + (x - side) * scale) as u32,
                    (half - y * scale) as u32,
                );
                for channel in 0..3 {
                    assert!(
                        pixel.0[channel].abs_diff(expected[channel]) <= 2,
                        "round {round}, eye {eye}: {pixel:?} against {expected:?}"
                    );
                }
            }
        }
        textures.push(
            egui::TextureId::default(),
            egui::epaint::ImageDelta::partial(
                [1, 0],
                egui::ColorImage::filled([1, 1], egui::Color32::WHITE),
                egui::TextureOptions::LINEAR,
            ),
        );
    }
    // A texture that does not fit is refused in a sentence and breaks nothing.
    let outside = egui::ColorImage::filled([9, 9], egui::Color32::WHITE);
    textures.push(
        egui::TextureId::default(),
        egui::epaint::ImageDelta::partial([1, 1], outside, egui::TextureOptions::LINEAR),
    );
    assert!(
        renderer
            .paint_panel(0, &quarters(), &mut textures, [400, 250], 2.0)
            .is_err()
    );
    renderer.draw(&scene, &eyes, &offscreen.target()).unwrap();
    drop(renderer);
    silent(&gpu);
}
