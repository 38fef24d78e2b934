//! Scanned models: faces, edges, vertices, what is seen through, what is cut away, and their way to the device.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Vec3, Vec4};
use image::{Rgba, RgbaImage};
use ramus::mesh::Mesh;
use ramus::mesh::display::Display;
use ramus::render::{ModelUpload, Offscreen, Renderer, RendererParams, StereoMode};
use ramus::world::scene::{ModelLook, PlacedModel, Scene, SurfaceLook, new_revision};

use super::support::{
    SIDE, Shot, ahead, blob, device, mode, pixels_per_tangent, plain, shoot, silent,
};

/// A ball of `rows` × 2 `rows` quads, wound to be seen from outside.
pub(crate) fn ball_mesh(rows: u32, radius: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..2 * rows {
            let (down, round) = (
                PI * row as f32 / rows as f32,
                TAU * column as f32 / (2 * rows) as f32,
            );
            mesh.positions.push(
                Vec3::new(
                    down.sin() * round.sin(),
                    down.cos(),
                    down.sin() * round.cos(),
                ) * radius,
            );
        }
    }
    let at = |row: u32, column: u32| row * 2 * rows + column % (2 * rows);
    for row in 0..rows {
        for column in 0..2 * rows {
            let (a, b) = (at(row, column), at(row, column + 1));
            let (c, d) = (at(row + 1, column), at(row + 1, column + 1));
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    mesh
}

fn display(mesh: Mesh) -> Display {
    Display::new(Arc::new(mesh), None, &AtomicBool::new(false)).unwrap()
}

fn model(display: Display, look: ModelLook) -> PlacedModel {
    PlacedModel {
        display: Arc::new(display),
        revision: new_revision(),
        world_from_model: Affine3A::IDENTITY,
        look,
    }
}

fn scene(model: PlacedModel) -> Scene {
    Scene {
        models: vec![model],
        ..Scene::default()
    }
}

fn look(change: impl FnOnce(&mut ModelLook)) -> ModelLook {
    let mut look = ModelLook::default();
    change(&mut look);
    look
}

/// Pixels that differ from black.
fn covered(picture: &RgbaImage) -> usize {
    picture
        .pixels()
        .filter(|pixel| pixel.0[..3].iter().any(|&part| part > 6))
        .count()
}

fn mean(picture: &RgbaImage) -> f32 {
    let sum: f32 = picture.pixels().map(|pixel| f32::from(pixel.0[1])).sum();
    sum / (SIDE * SIDE) as f32
}

const DISTANCE: f32 = 1.2;
const RADIUS: f32 = 0.3;

/// Pixels of a ball's disc, seen from [`DISTANCE`].
fn disc() -> f32 {
    let tangent = (RADIUS / DISTANCE).asin().tan();
    PI * (tangent * pixels_per_tangent()).powi(2)
}

#[test]
fn a_ball_covers_its_disc_at_its_place_depth_and_disparity() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let eyes = ahead(DISTANCE);
    for surface in [SurfaceLook::Shaded, SurfaceLook::Matte] {
        let look = look(|look| look.surface = Some(surface));
        let shot = shoot(
            &gpu,
            &params,
            &scene(model(display(ball_mesh(48, RADIUS)), look)),
            &eyes,
        );
        let [left, right] = &shot.color;
        for picture in [left, right] {
            let share = covered(picture) as f32 / disc();
            assert!((share - 1.0).abs() < 0.03, "{surface:?}: {share}");
        }
        let black = Rgba([0, 0, 0, 255]);
        let ((x, y, _), (other, _, _)) = (blob(left, black), blob(right, black));
        let middle = SIDE as f32 / 2.0;
        // Each eye is 32 mm to its side of the middle.
        let shift = 0.032 / DISTANCE * pixels_per_tangent();
        assert!(
            (y - middle).abs() < 1.0 && (x - middle - shift).abs() < 1.0,
            "{x} {y}"
        );
        assert!((x - other - 2.0 * shift).abs() < 1.0, "{x} {other}");
        // Reversed depth: the near plane over the distance.
        let depth = shot.depth[0][(SIDE * SIDE / 2 + SIDE / 2) as usize];
        let there = ramus::render::NEAR / (DISTANCE - RADIUS);
        assert!((depth / there - 1.0).abs() < 0.02, "{depth} {there}");
    }
    silent(&gpu);
}

#[test]
fn both_eyes_in_one_pass_are_each_in_its_own() {
    let Some(gpu) = device() else { return };
    let mut all = scene(model(
        display(ball_mesh(12, RADIUS)),
        look(|look| {
            (look.wireframe, look.vertices) = (true, true);
        }),
    ));
    let mut beside = model(
        display(ball_mesh(12, 0.2)),
        look(|look| {
            look.surface = Some(SurfaceLook::XRay);
        }),
    );
    beside.world_from_model = Affine3A::from_translation(Vec3::new(0.25, 0.1, 0.2));
    all.models.push(beside);
    let eyes = ahead(DISTANCE);
    let one = shoot(&gpu, &plain(mode(&gpu), 0.2), &all, &eyes);
    let each = shoot(&gpu, &plain(StereoMode::PerEye, 0.2), &all, &eyes);
    assert!(one.color == each.color && one.depth == each.depth);
    assert_ne!(one.color[0], one.color[1]);
    silent(&gpu);
}

#[test]
fn edges_alone_let_see_through_and_keep_their_width() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let wire = |rows: u32, distance: f32| {
        let look = look(|look| (look.surface, look.wireframe) = (None, true));
        let shot = shoot(
            &gpu,
            &params,
            &scene(model(display(ball_mesh(rows, RADIUS)), look)),
            &ahead(distance),
        );
        covered(&shot.color[0]) as f32
    };
    let coarse = wire(6, DISTANCE);
    assert!(
        (0.05..0.75).contains(&(coarse / disc())),
        "{}",
        coarse / disc()
    );
    assert!(wire(12, DISTANCE) > 1.3 * coarse, "more edges");
    // Twice as far, lines are half as long and as wide: half the pixels, not a quarter. (One triangle: its lines hide none.)
    let one = Mesh {
        positions: vec![
            Vec3::new(-0.3, -0.3, 0.0),
            Vec3::new(0.3, -0.2, 0.0),
            Vec3::new(0.0, 0.3, 0.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    let light = |distance: f32| {
        let look = look(|look| (look.surface, look.wireframe) = (None, true));
        let shot = shoot(
            &gpu,
            &params,
            &scene(model(display(one.clone()), look)),
            &ahead(distance),
        );
        covered(&shot.color[0]) as f32
    };
    let part = light(2.0 * DISTANCE) / light(DISTANCE);
    assert!((part - 0.5).abs() < 0.06, "{part}");
    // Over faces they darken, and leave the outline as it is.
    let with = |wireframe| {
        let look = look(|look| look.wireframe = wireframe);
        shoot(
            &gpu,
            &params,
            &scene(model(display(ball_mesh(8, RADIUS)), look)),
            &ahead(DISTANCE),
        )
    };
    let (edged, bare) = (with(true), with(false));
    assert!(mean(&edged.color[0]) < 0.95 * mean(&bare.color[0]));
    assert_eq!(edged.depth, bare.depth);
    silent(&gpu);
}

#[test]
fn far_meshes_with_edges_do_not_turn_black() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 1.0);
    let light = |rows: u32, wireframe| {
        let look = look(|look| {
            (look.wireframe, look.surface) = (wireframe, Some(SurfaceLook::Matte));
        });
        let picture = &shoot(
            &gpu,
            &params,
            &scene(model(display(ball_mesh(rows, RADIUS)), look)),
            &ahead(DISTANCE),
        )
        .color[0];
        f32::from(picture.get_pixel(SIDE / 2 + 10, SIDE / 2 + 6).0[1])
    };
    // A hundred and fifty rows on a hundred pixels: each triangle is smaller than a line is wide.
    let (edged, bare) = (light(150, true), light(150, false));
    assert!(edged > 0.6 * bare && edged < bare, "{edged} of {bare}");
    silent(&gpu);
}

#[test]
fn vertices_are_points_of_one_size() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let corners = Mesh {
        positions: vec![
            Vec3::new(-0.2, -0.2, 0.0),
            Vec3::new(0.2, -0.2, 0.0),
            Vec3::new(0.0, 0.2, 0.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    for distance in [0.8, 1.6] {
        let look = look(|look| (look.surface, look.vertices) = (None, true));
        let picture = &shoot(
            &gpu,
            &params,
            &scene(model(display(corners.clone()), look)),
            &ahead(distance),
        )
        .color[0];
        let found = covered(picture);
        // Three points of three pixels across, their rims half covered.
        assert!((3 * 5..=3 * 16).contains(&found), "{found} at {distance}");
    }
    silent(&gpu);
}

#[test]
fn what_is_seen_through_does_not_depend_on_the_order_and_shows_what_is_within() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.6);
    let x_ray = |mesh: Mesh| {
        model(
            display(mesh),
            look(|look| look.surface = Some(SurfaceLook::XRay)),
        )
    };
    let mesh = ball_mesh(16, RADIUS);
    let mut turned = mesh.clone();
    turned.triangles.reverse();
    let eyes = ahead(DISTANCE);
    let one = shoot(&gpu, &params, &scene(x_ray(mesh.clone())), &eyes);
    let other = shoot(&gpu, &params, &scene(x_ray(turned)), &eyes);
    for (a, b) in one.color[0].pixels().zip(other.color[0].pixels()) {
        assert!(
            a.0.iter().zip(b.0).all(|(a, b)| a.abs_diff(b) <= 2),
            "{a:?} {b:?}"
        );
    }
    // Its depth is nobody's.
    assert!(one.depth[0].iter().all(|&depth| depth == 0.0));
    // The rim is darker than the middle, and the middle than the background.
    let at = |shot: &Shot, x: f32| {
        let x = SIDE as f32 / 2.0 + 0.032 / DISTANCE * pixels_per_tangent() + x;
        i32::from(shot.color[0].get_pixel(x as u32, SIDE / 2).0[1])
    };
    let rim = (disc() / PI).sqrt() - 2.0;
    assert!(
        at(&one, rim) + 15 < at(&one, 0.0),
        "{} {}",
        at(&one, rim),
        at(&one, 0.0)
    );
    assert!(at(&one, 0.0) + 8 < at(&one, rim + 12.0));
    // A red ball within is seen.
    let mut both = scene(x_ray(mesh));
    both.balls.push(ramus::world::scene::Ball {
        center: Vec3::ZERO,
        radius: 0.08,
        color: [0.9, 0.02, 0.02, 1.0],
    });
    let both = shoot(&gpu, &params, &both, &eyes);
    let pixel = both.color[0].get_pixel(SIDE / 2 + 7, SIDE / 2).0;
    assert!(pixel[0] > 2 * pixel[1], "{pixel:?}");
    silent(&gpu);
}

#[test]
fn a_cut_takes_away_what_is_before_it_and_shows_the_inside() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let shot = |cut: Option<Vec4>| {
        let look = look(|look| look.cut = cut);
        shoot(
            &gpu,
            &params,
            &scene(model(display(ball_mesh(48, RADIUS)), look)),
            &ahead(DISTANCE),
        )
    };
    let whole = covered(&shot(None).color[0]) as f32;
    let right_half = shot(Some(Vec4::new(1.0, 0.0, 0.0, 0.0)));
    let share = covered(&right_half.color[0]) as f32 / whole;
    assert!((share - 0.5).abs() < 0.04, "{share}");
    // Its front half gone, the far wall is seen: farther, and in the inside's red.
    let open = shot(Some(Vec4::new(0.0, 0.0, 1.0, 0.0)));
    let middle = (SIDE * SIDE / 2 + SIDE / 2) as usize;
    let depth = open.depth[0][middle];
    let there = ramus::render::NEAR / (DISTANCE + RADIUS);
    assert!((depth / there - 1.0).abs() < 0.02, "{depth} {there}");
    let pixel = open.color[0].get_pixel(SIDE / 2, SIDE / 2).0;
    assert!(pixel[0] > pixel[1] + 15, "{pixel:?}");
    // A plane that is none cuts nothing.
    for none in [Vec4::NAN, Vec4::ZERO] {
        assert_eq!(covered(&shot(Some(none)).color[0]) as f32, whole);
    }
    silent(&gpu);
}

#[test]
fn a_lamp_lights_what_it_is_at_and_colours_are_the_triangles_own() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let lit = |lamp: Option<Vec3>| {
        let look = look(|look| (look.lamp, look.surface) = (lamp, Some(SurfaceLook::Matte)));
        let shot = shoot(
            &gpu,
            &params,
            &scene(model(display(ball_mesh(32, RADIUS)), look)),
            &ahead(DISTANCE),
        );
        [SIDE / 2 - 30, SIDE / 2 + 40].map(|x| i32::from(shot.color[0].get_pixel(x, SIDE / 2).0[1]))
    };
    let (dark, bright) = (lit(None), lit(Some(Vec3::new(-0.4, 0.0, 0.3))));
    assert!(
        bright[0] > dark[0] + 20 && bright[0] - dark[0] > bright[1] - dark[1],
        "{dark:?} {bright:?}"
    );

    let mesh = ball_mesh(32, RADIUS);
    let half = mesh.triangles.len() / 2;
    // The upper half blue, the lower its own colour.
    let colours = (0..mesh.triangles.len())
        .map(|triangle| {
            if triangle < half {
                [0, 60, 220, 255]
            } else {
                [0; 4]
            }
        })
        .collect();
    let coloured = model(display(mesh).coloured(colours), ModelLook::default());
    let shot = shoot(&gpu, &params, &scene(coloured), &ahead(DISTANCE));
    let blue = |y: u32| {
        let [red, _, blue, _] = shot.color[0].get_pixel(SIDE / 2 + 7, y).0;
        i32::from(blue) - i32::from(red)
    };
    assert!(blue(SIDE / 2 - 25) > 60 && blue(SIDE / 2 + 25) < 0);
    silent(&gpu);
}

#[test]
fn a_model_in_many_chunks_is_the_same_and_goes_when_the_scene_lets_it_go() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        direct_triangles: 0,
        ..plain(mode(&gpu), 0.1)
    };
    let mesh = ball_mesh(24, RADIUS);
    let colours = (0..mesh.triangles.len()).map(|n| [(n % 251) as u8, 90, 40, 255]);
    let placed = model(
        display(mesh.clone()).coloured(colours.collect()),
        look(|look| look.wireframe = true),
    );
    let shown = scene(placed.clone());
    let eyes = ahead(DISTANCE);
    let whole = shoot(&gpu, &plain(mode(&gpu), 0.1), &shown, &eyes);

    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let report = renderer.draw(&shown, &eyes, &offscreen.target()).unwrap();
    assert_eq!(report.model, Some(placed.revision), "too large for a frame");
    assert!(!renderer.has_models(&shown));
    let upload = ModelUpload::in_chunks(&gpu, &placed, 4096).unwrap();
    assert_eq!(upload.revision(), placed.revision);
    renderer.set_model(upload);
    let report = renderer.draw(&shown, &eyes, &offscreen.target()).unwrap();
    assert!(renderer.has_models(&shown) && report.model.is_none());
    // At most 341 triangles a chunk, none but whole clusters.
    assert!(
        report.draws as usize > mesh.triangles.len() / 341,
        "{}",
        report.draws
    );
    assert_eq!(offscreen.read_color().unwrap(), whole.color);

    let empty = Scene::default();
    for _ in 0..3 {
        renderer.draw(&empty, &eyes, &offscreen.target()).unwrap();
    }
    assert!(
        offscreen.read_color().unwrap()[0]
            .pixels()
            .all(|pixel| pixel.0[1] < 100)
    );
    let report = renderer.draw(&shown, &eyes, &offscreen.target()).unwrap();
    assert_eq!(report.model, Some(placed.revision), "it was let go");
    silent(&gpu);
}

#[test]
fn nonsense_is_not_drawn_and_harms_nothing() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let mut nowhere = model(display(ball_mesh(8, RADIUS)), ModelLook::default());
    nowhere.world_from_model = Affine3A::from_translation(Vec3::NAN);
    let empty = model(display(Mesh::default()), look(|look| look.vertices = true));
    let broken = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X],
        triangles: vec![[0, 1, 7], [9, 9, 9]],
        ..Mesh::default()
    };
    let broken = model(
        display(broken),
        look(|look| (look.wireframe, look.vertices) = (true, true)),
    );
    for model in [nowhere, empty, broken] {
        let shot = shoot(&gpu, &params, &scene(model), &ahead(DISTANCE));
        assert!(covered(&shot.color[0]) < 60);
    }
    silent(&gpu);
}
