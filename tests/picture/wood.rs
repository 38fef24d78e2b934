//! The shadow of models that stand for good, as planted trees do: where it lies, how large it is, what it is on, and when its map is drawn.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, Vec2, Vec3};
use image::{Rgba, RgbaImage};
use ramus::mesh::display::Display;
use ramus::render::{Eye, Fov, Gpu, Offscreen, Pose, Renderer, RendererParams};
use ramus::world::scene::{ModelLook, PlacedModel, Scene, new_revision, weather::Light};

use super::lights::{luminance, params, pole};
use super::models::ball_mesh;
use super::support::{device, mode, shoot, silent};

const RADIUS: f32 = 0.5;
const SIDE: u32 = 256;
/// How high pictures from above are taken, metres: beneath the haze.
const HIGH: f32 = 5.0;

fn ball() -> Arc<Display> {
    let mesh = Arc::new(ball_mesh(24, RADIUS));
    Arc::new(Display::new(mesh, None, &AtomicBool::new(false)).unwrap())
}

fn at(display: &Arc<Display>, place: Vec3, shadow: bool) -> PlacedModel {
    PlacedModel {
        display: Arc::clone(display),
        revision: new_revision(),
        world_from_model: Affine3A::from_translation(place),
        look: ModelLook {
            shadow,
            ..ModelLook::default()
        },
    }
}

fn scene(models: &[PlacedModel]) -> Scene {
    Scene {
        models: models.to_vec(),
        ..Scene::default()
    }
}

/// Straight down on a place of the ground, so many metres across; the picture's right is +X, its top −Z.
fn above(place: Vec3, across: f32) -> [Eye; 2] {
    Eye {
        world_from_eye: Pose {
            orientation: Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
            position: place + Vec3::Y * HIGH,
        },
        fov: Fov::symmetric(2.0 * (across / 2.0 / HIGH).atan(), 1.0),
    }
    .pair(0.0)
}

/// Where the shadow of what is at such a place falls.
fn fallen(params: &RendererParams, place: Vec3) -> Vec3 {
    let sun = params.sun.normalize();
    place - sun * (place.y / sun.y)
}

/// Light, of which half is half.
fn linear(pixel: &Rgba<u8>) -> f64 {
    (luminance(pixel) / 255.0).powf(2.2)
}

/// Of what is missing of the light somewhere: middle and area in metres, as if all that is dark were as dark as the darkest.
fn dark(with: &RgbaImage, without: &RgbaImage, across: f32) -> (Vec2, f32) {
    let metre = across / SIDE as f32;
    let (mut sum, mut middle, mut most) = (0.0_f64, [0.0_f64; 2], 0.0_f64);
    for (x, y, pixel) in without.enumerate_pixels() {
        let lost = (1.0 - linear(with.get_pixel(x, y)) / linear(pixel)).max(0.0);
        let lost = if lost < 0.02 { 0.0 } else { lost };
        sum += lost;
        most = most.max(lost);
        for (middle, at) in middle.iter_mut().zip([x, y]) {
            *middle += lost * (f64::from(at) + 0.5);
        }
    }
    let half = f64::from(SIDE) / 2.0;
    let [x, y] = middle.map(|part| ((part / sum.max(1e-9) - half) * f64::from(metre)) as f32);
    (
        Vec2::new(x, y),
        (sum / most.max(1e-9)) as f32 * metre * metre,
    )
}

/// Draws frames one after the other: with how many draws, and the left eye's picture.
fn frames(
    gpu: &Gpu,
    params: &RendererParams,
    eyes: [Eye; 2],
) -> impl FnMut(&Scene) -> (u32, RgbaImage) {
    let offscreen = Offscreen::new(gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(gpu, params).unwrap();
    move |scene| {
        let report = renderer.draw(scene, &eyes, &offscreen.target()).unwrap();
        let [left, _] = offscreen.read_color().unwrap();
        (report.draws, left)
    }
}

#[test]
fn a_ball_that_stands_for_good_darkens_an_ellipse_where_the_sun_says() {
    let Some(gpu) = device() else { return };
    let display = ball();
    for (light, height, across) in [
        (Light::Day, 3.0, 3.0),
        (Light::Day, 9.0, 3.0),
        (Light::Evening, 1.5, 8.0),
    ] {
        let params = params(mode(&gpu), SIDE, light);
        let place = Vec3::new(4.0, height, -6.0);
        let eyes = above(fallen(&params, place), across);
        let shot = |models: &[PlacedModel]| {
            let [left, _] = shoot(&gpu, &params, &scene(models), &eyes).color;
            left
        };
        let bare = shot(&[]);
        // A scan is held, turned and scaled all the time, and throws none.
        assert!(shot(&[at(&display, place, false)]) == bare);
        let (middle, area) = dark(&shot(&[at(&display, place, true)]), &bare, across);
        assert!(middle.length() < 0.05, "{light:?} {height}: {middle}");
        // Soft edges lie as far outside as inside.
        let sun = params.sun.normalize();
        let ellipse = std::f32::consts::PI * RADIUS * RADIUS / sun.y;
        let seen = area / ellipse;
        assert!((0.8..1.2).contains(&seen), "{light:?} {height}: {seen}");
    }
    silent(&gpu);
}

#[test]
fn its_map_is_drawn_when_something_comes_goes_or_moves_and_not_else() {
    let Some(gpu) = device() else { return };
    let params = params(mode(&gpu), SIDE, Light::Day);
    let display = ball();
    let (here, there) = (Vec3::new(0.0, 3.0, 0.0), Vec3::new(1.0, 3.0, 0.3));
    let across = 3.0;
    let eyes = above(fallen(&params, here), across);
    let mut draw = frames(&gpu, &params, eyes);
    let one = scene(&[at(&display, here, true)]);
    let (first, with_one) = draw(&one);
    let (second, again) = draw(&one);
    assert!(second < first, "{second} draws after {first}");
    assert!(again == with_one);
    // Moved: the shadow has moved with it.
    let moved = scene(&[at(&display, there, true)]);
    let (third, with_moved) = draw(&moved);
    assert_eq!(third, first);
    let (_, bare) = draw(&Scene::default());
    let (middle, _) = dark(&with_moved, &bare, across);
    let way = middle - Vec2::new(there.x - here.x, there.z - here.z);
    assert!(way.length() < 0.12, "{middle}");
    // Gone and back: as it was.
    let (_, back) = draw(&one);
    assert!(back == with_one);
    // Two far apart share a map that is coarser; each still throws its own.
    let two = scene(&[
        at(&display, here, true),
        at(&display, here + Vec3::X * 60.0, true),
    ]);
    let (middle, area) = dark(&draw(&two).1, &bare, across);
    let (_, alone) = dark(&with_one, &bare, across);
    assert!(middle.length() < 0.06, "{middle}");
    assert!((0.85..1.15).contains(&(area / alone)), "{area} {alone}");
    silent(&gpu);
}

#[test]
fn a_wood_behind_ones_back_costs_no_draws_and_still_throws_its_shadow() {
    let Some(gpu) = device() else { return };
    let params = params(mode(&gpu), SIDE, Light::Day);
    let display = ball();
    // Behind what looks at where the shadow of the first of them falls.
    let place = Vec3::new(0.0, 3.0, 0.0);
    let wood: Vec<PlacedModel> = (0..200_u8)
        .map(|n| at(&display, place + Vec3::X * f32::from(n), true))
        .collect();
    let eyes = above(fallen(&params, place), 3.0);
    let mut draw = frames(&gpu, &params, eyes);
    let (without, bare) = draw(&Scene::default());
    let (first, _) = draw(&scene(&wood));
    let (second, shaded) = draw(&scene(&wood));
    assert!(first > 200, "{first} draws of the map");
    assert_eq!(second, without);
    let (_, area) = dark(&shaded, &bare, 3.0);
    assert!(area > 0.5, "{area}");
    silent(&gpu);
}

/// What stands in the shadow is dark, be it a tree on the platform or another model; a ball in the sun has a side of its own that is not.
#[test]
fn it_falls_on_trees_and_models_and_not_on_what_is_in_the_sun() {
    let Some(gpu) = device() else { return };
    let params = params(mode(&gpu), SIDE, Light::Day);
    let sun = params.sun.normalize();
    let display = ball();
    let look = |at: Vec3| {
        let eye = at + sun.with_y(0.0).normalize() * 4.0 + Vec3::Y * 0.6;
        Eye::looking_at(eye, at, Fov::symmetric(0.2, 1.0)).pair(0.0)
    };
    let light = |scene: &Scene, at: Vec3| {
        let [left, _] = shoot(&gpu, &params, scene, &look(at)).color;
        let mut sum = 0.0;
        for pixel in image::imageops::crop_imm(&left, 112, 112, 32, 32)
            .to_image()
            .pixels()
        {
            sum += linear(pixel);
        }
        sum
    };
    let middle = Vec3::Y * 1.0;
    let shade = |throws: bool| at(&display, middle + sun * 4.0, throws);
    // A tree.
    let tree = |throws: bool| Scene {
        tree: Some(pole(0.0, 2.0, 0.12)),
        ..scene(&[shade(throws)])
    };
    let dark = light(&tree(true), middle) / light(&tree(false), middle);
    assert!(dark < 0.75, "a tree in the shade: {dark}");
    // A model that throws none itself.
    let model = |throws: bool| scene(&[at(&display, middle, false), shade(throws)]);
    let dark = light(&model(true), middle) / light(&model(false), middle);
    assert!(dark < 0.75, "a model in the shade: {dark}");
    // What throws it is as bright as before where the sun is on it.
    let top = middle + sun * 4.0;
    let lit = light(&model(true), top) / light(&model(false), top);
    assert!((0.97..1.03).contains(&lit), "what throws it: {lit}");
    silent(&gpu);
}
