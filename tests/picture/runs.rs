//! Models of one mesh and one look, as the trees of a wood are: one draw shows them, each in its place, as if each had a draw of its own.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, Vec3};
use image::RgbaImage;
use ramus::mesh::display::Display;
use ramus::mesh::paint::{Material, Paint};
use ramus::mesh::textured::{LayerLimits, Textured};
use ramus::render::{ModelUpload, Offscreen, Renderer, RendererParams};
use ramus::world::scene::{ModelLook, PlacedModel, Scene, SurfaceLook, new_revision};

use super::models::ball_mesh;
use super::support::{ahead, device, mode, plain, silent};

/// Two of three are seen, more than one draw takes.
const MANY: u16 = 420;
const MOST: u32 = 256;
const DISTANCE: f32 = 8.0;
static NEVER: AtomicBool = AtomicBool::new(false);

/// Half red, half blue, by its materials.
fn ball() -> Display {
    let mesh = Arc::new(ball_mesh(12, 0.3));
    let material = |colour: [f32; 3]| Material {
        base_colour: Vec3::from(colour).extend(1.0),
        ..Material::default()
    };
    let paint = Paint {
        materials: vec![material([0.8, 0.1, 0.1]), material([0.1, 0.1, 0.8])],
        triangle_materials: (0..mesh.triangles.len()).map(|n| (n % 2) as u16).collect(),
        ..Paint::default()
    };
    let (textured, _) = Textured::new(paint, &LayerLimits::default(), &NEVER).unwrap();
    let textured = textured.unwrap();
    let display = Display::new(mesh, Some(&textured), &NEVER).unwrap();
    display.textured(Arc::new(textured))
}

/// On a spiral, turned and larger one after the other; each third is behind one's back.
fn spiral(display: &Arc<Display>, look: ModelLook, revision: impl Fn() -> u64) -> Scene {
    let models = (0..MANY).map(|number| {
        let n = f32::from(number);
        let side = if number % 3 == 0 { 2.0 * DISTANCE } else { 0.0 };
        let away = Quat::from_rotation_z(n * 2.4) * Vec3::X * (0.15 * n.sqrt());
        PlacedModel {
            display: Arc::clone(display),
            revision: revision(),
            world_from_model: Affine3A::from_scale_rotation_translation(
                Vec3::splat(0.2 + 0.001 * n),
                Quat::from_rotation_y(n),
                away + Vec3::Z * side,
            ),
            look,
        }
    });
    Scene {
        models: models.collect(),
        ..Scene::default()
    }
}

/// The largest difference of two pictures' colours.
fn farthest(a: &RgbaImage, b: &RgbaImage) -> u8 {
    let parts = a.as_raw().iter().zip(b.as_raw());
    parts.map(|(a, b)| a.abs_diff(*b)).max().unwrap()
}

#[test]
fn models_of_one_mesh_and_look_are_one_draw_and_look_as_if_each_had_its_own() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        direct_triangles: 0,
        ..plain(mode(&gpu), 0.0)
    };
    let display = Arc::new(ball());
    let seen = u32::from(MANY) - u32::from(MANY).div_ceil(3);
    let look = |change: &dyn Fn(&mut ModelLook)| {
        let mut look = ModelLook::default();
        change(&mut look);
        look
    };
    let surface = |surface| look(&|look: &mut ModelLook| look.surface = Some(surface));
    // With the draws of a model, by chunk.
    let looks = [
        (surface(SurfaceLook::Matte), 1),
        (surface(SurfaceLook::Textured), 1),
        (surface(SurfaceLook::XRay), 1),
        (
            look(&|look| {
                look.surface = None;
                (look.wireframe, look.vertices) = (true, true);
            }),
            2,
        ),
        (
            look(&|look| (look.surface, look.vertices) = (None, true)),
            1,
        ),
    ];
    let eyes = ahead(DISTANCE);
    // Whole, and in pieces of some hundred triangles.
    for chunk_bytes in [1 << 20, 4096] {
        for (look, parts) in looks {
            let shoot = |scene: &Scene| {
                let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
                let mut renderer = Renderer::new(&gpu, &params).unwrap();
                let mut known = Vec::new();
                for placed in &scene.models {
                    if !known.contains(&placed.revision) {
                        known.push(placed.revision);
                        let upload = ModelUpload::in_chunks(&gpu, placed, chunk_bytes).unwrap();
                        renderer.set_model(upload);
                    }
                }
                let mut draws = || {
                    let report = renderer.draw(scene, &eyes, &offscreen.target()).unwrap();
                    report.draws
                };
                let draws = [draws(), draws()][1];
                let chosen = renderer.chosen_triangles(scene).unwrap();
                (draws, chosen, offscreen.read_color().unwrap())
            };
            let (none, ..) = shoot(&Scene::default());
            let revision = new_revision();
            let (few, chosen_few, together) = shoot(&spiral(&display, look, || revision));
            let (many, chosen_many, each) = shoot(&spiral(&display, look, new_revision));
            let chunks = (many - none) / (seen * parts);
            assert!(chunks == 1 || chunks > 1 && chunk_bytes < 1 << 20);
            assert_eq!(many - none, seen * parts * chunks, "{look:?}");
            assert_eq!(few - none, parts * chunks * seen.div_ceil(MOST), "{look:?}");
            assert!(chosen_few == chosen_many, "{look:?}");
            // What is seen through comes in another order, chunk by chunk, and each layer is rounded.
            let rounded = look.surface == Some(SurfaceLook::XRay) && chunks > 1;
            let most = if rounded { 2 } else { 0 };
            let off = farthest(&together[0], &each[0]).max(farthest(&together[1], &each[1]));
            assert!(off <= most, "{look:?} in {chunks} chunks: {off}");
            let lit = together[0]
                .pixels()
                .filter(|pixel| pixel.0[..3].iter().any(|part| *part > 20));
            assert!(lit.count() > 1_000, "{look:?}");
        }
    }
    silent(&gpu);
}
