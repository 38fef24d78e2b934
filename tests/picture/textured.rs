//! Scanned models as their files colour them: images, colours of vertices, what is cut out, and how images come to the device.

use std::io::Cursor;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine2, Affine3A, Vec2, Vec3, Vec4};
use image::{ImageFormat, Rgba, RgbaImage};
use ramus::mesh::Mesh;
use ramus::mesh::display::Display;
use ramus::mesh::paint::{Alpha, Image, ImageLimits, Material, Paint, Texture, Wrap};
use ramus::mesh::textured::{LayerLimits, Textured};
use ramus::render::{Offscreen, Renderer, RendererParams, StereoMode};
use ramus::world::scene::{ModelLook, PlacedModel, Scene, SurfaceLook, new_revision};

use super::support::{SIDE, Shot, ahead, device, mode, plain, shoot, silent};

static NEVER: AtomicBool = AtomicBool::new(false);
const DISTANCE: f32 = 1.0;

/// A square of this half side that faces the eye; the image's upper left corner at its upper left one, and so many times across and down.
fn square(half: f32, times: f32) -> (Mesh, Vec<Vec2>) {
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let mesh = Mesh {
        positions: corners
            .map(|[u, v]| Vec3::new(2.0 * u - 1.0, 1.0 - 2.0 * v, 0.0) * half)
            .to_vec(),
        triangles: vec![[0, 2, 1], [1, 2, 3]],
        ..Mesh::default()
    };
    (mesh, corners.map(|at| Vec2::from(at) * times).to_vec())
}

fn png(width: u32, height: u32, colour: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let pixels = RgbaImage::from_fn(width, height, |x, y| Rgba(colour(x, y)));
    let mut bytes = Vec::new();
    let to = &mut Cursor::new(&mut bytes);
    pixels.write_to(to, ImageFormat::Png).unwrap();
    Image::new("bark".into(), Arc::new(bytes), &ImageLimits::default()).unwrap()
}

/// Red, green, blue and yellow, a quarter each.
fn quarters() -> Image {
    let of = |x: u32, y: u32| match (x < 8, y < 8) {
        (true, true) => [200, 0, 0, 255],
        (false, true) => [0, 200, 0, 255],
        (true, false) => [0, 0, 200, 255],
        (false, false) => [200, 200, 0, 255],
    };
    png(16, 16, of)
}

/// Its colour in any light, so that pictures can be compared with images.
fn unlit() -> Material {
    Material {
        base_colour_image: Some(Texture {
            image: 0,
            image_from_texture: Affine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
        }),
        is_unlit: true,
        ..Material::default()
    }
}

fn model(mesh: Mesh, paint: Paint) -> PlacedModel {
    let (textured, remarks) = Textured::new(paint, &LayerLimits::default(), &NEVER).unwrap();
    assert!(remarks.is_empty(), "{remarks:?}");
    let textured = textured.unwrap();
    let display = Display::new(Arc::new(mesh), Some(&textured), &NEVER).unwrap();
    PlacedModel {
        display: Arc::new(display.textured(Arc::new(textured))),
        revision: new_revision(),
        world_from_model: Affine3A::IDENTITY,
        look: ModelLook {
            surface: Some(SurfaceLook::Textured),
            ..ModelLook::default()
        },
    }
}

fn scene(models: Vec<PlacedModel>) -> Scene {
    Scene {
        models,
        ..Scene::default()
    }
}

/// A square with a material and an image.
fn painted(times: f32, material: Material, image: Image) -> Scene {
    let (mesh, texture_coordinates) = square(0.4, times);
    let paint = Paint {
        texture_coordinates,
        materials: vec![material],
        images: vec![image],
        ..Paint::default()
    };
    scene(vec![model(mesh, paint)])
}

fn shot(gpu: &ramus::render::Gpu, mode: StereoMode, scene: &Scene) -> Shot {
    shoot(gpu, &plain(mode, 0.0), scene, &ahead(DISTANCE))
}

/// The pixel at a part of the square across and down.
fn at(picture: &RgbaImage, across: f32, down: f32) -> [u8; 3] {
    // The square's edges, by what differs from the black behind it in the middle row and column.
    let lit = |x: u32, y: u32| picture.get_pixel(x, y).0[..3].iter().any(|part| *part > 3);
    let middle = SIDE / 2;
    let columns: Vec<u32> = (0..SIDE)
        .filter(|x| (0..SIDE).any(|y| lit(*x, y)))
        .collect();
    let rows: Vec<u32> = (0..SIDE)
        .filter(|y| (0..SIDE).any(|x| lit(x, *y)))
        .collect();
    let place = |all: &[u32], part: f32| {
        let (first, last) = (all.first().copied(), all.last().copied());
        let (first, last) = (
            first.unwrap_or(middle) as f32,
            last.unwrap_or(middle) as f32,
        );
        (first + (last - first) * part).round() as u32
    };
    let pixel = picture.get_pixel(place(&columns, across), place(&rows, down));
    [0, 1, 2].map(|channel| pixel.0[channel])
}

fn assert_near(found: [u8; 3], expected: [u8; 3], what: &str) {
    let far = found.iter().zip(expected).map(|(a, b)| a.abs_diff(b)).max();
    assert!(far.unwrap() <= 4, "{what}: {found:?}, not {expected:?}");
}

const RED: [u8; 3] = [200, 0, 0];
const GREEN: [u8; 3] = [0, 200, 0];
const BLUE: [u8; 3] = [0, 0, 200];
const YELLOW: [u8; 3] = [200, 200, 0];

#[test]
fn an_image_lies_the_right_way_up_in_both_ways_to_draw_two_eyes() {
    let Some(gpu) = device() else { return };
    let scene = painted(1.0, unlit(), quarters());
    for mode in [mode(&gpu), StereoMode::PerEye] {
        let shot = shot(&gpu, mode, &scene);
        for eye in &shot.color {
            for (across, down, colour) in [
                (0.25, 0.25, RED),
                (0.75, 0.25, GREEN),
                (0.25, 0.75, BLUE),
                (0.75, 0.75, YELLOW),
            ] {
                assert_near(at(eye, across, down), colour, "a quarter");
            }
        }
    }
    silent(&gpu);
}

#[test]
fn beyond_its_edges_an_image_is_repeated_mirrored_or_its_edge() {
    let Some(gpu) = device() else { return };
    // Twice across and down: the places in the second half of the square.
    let seen = |wrap: [Wrap; 2]| {
        let mut material = unlit();
        if let Some(texture) = &mut material.base_colour_image {
            texture.wrap = wrap;
        }
        let shot = shot(&gpu, mode(&gpu), &painted(2.0, material, quarters()));
        [(0.6, 0.1), (0.9, 0.1), (0.1, 0.6), (0.1, 0.9)]
            .map(|(across, down)| at(&shot.color[0], across, down))
    };
    use Wrap::{Clamp, Mirror, Repeat};
    for (wrap, expected) in [
        ([Repeat, Repeat], [RED, GREEN, RED, BLUE]),
        ([Mirror, Repeat], [GREEN, RED, RED, BLUE]),
        ([Clamp, Repeat], [GREEN, GREEN, RED, BLUE]),
        ([Repeat, Mirror], [RED, GREEN, BLUE, RED]),
        ([Repeat, Clamp], [RED, GREEN, BLUE, BLUE]),
        ([Clamp, Mirror], [GREEN, GREEN, BLUE, RED]),
    ] {
        for (found, expected) in seen(wrap).into_iter().zip(expected) {
            assert_near(found, expected, &format!("{wrap:?}"));
        }
    }
    // Turned, scaled and moved on its way to the image: by a quarter turn, what was right is below.
    let mut material = unlit();
    if let Some(texture) = &mut material.base_colour_image {
        texture.image_from_texture = Affine2::from_cols(Vec2::Y, Vec2::NEG_X, Vec2::X);
    }
    let shot = shot(&gpu, mode(&gpu), &painted(1.0, material, quarters()));
    assert_near(at(&shot.color[0], 0.25, 0.25), GREEN, "turned");
    assert_near(at(&shot.color[0], 0.75, 0.25), YELLOW, "turned");
    silent(&gpu);
}

#[test]
fn colours_of_materials_vertices_and_images_are_multiplied() {
    let Some(gpu) = device() else { return };
    let (mesh, texture_coordinates) = square(0.4, 1.0);
    let half = u16::MAX / 2;
    let mut paint = Paint {
        texture_coordinates,
        colours: vec![[u16::MAX, half, 0, u16::MAX]; 4],
        materials: vec![Material {
            base_colour: Vec4::new(0.5, 1.0, 1.0, 1.0),
            ..unlit()
        }],
        images: vec![png(2, 2, |_, _| [255, 255, 255, 255])],
        ..Paint::default()
    };
    let shown = |paint: &Paint| {
        let scene = scene(vec![model(mesh.clone(), paint.clone())]);
        at(&shot(&gpu, mode(&gpu), &scene).color[0], 0.5, 0.5)
    };
    // Half of the light is byte 188.
    assert_near(shown(&paint), [188, 188, 0], "all three");
    paint.images.clear();
    paint.materials[0].base_colour_image = None;
    assert_near(shown(&paint), [188, 188, 0], "without an image");
    // Colours alone, as scans have them, are lit.
    paint.materials.clear();
    let [red, green, blue] = shown(&paint);
    assert!(
        red > green && green > 60 && blue < green / 2,
        "{red} {green} {blue}"
    );
    silent(&gpu);
}

#[test]
fn triangles_have_the_material_that_their_file_gives_them() {
    let Some(gpu) = device() else { return };
    let (mesh, texture_coordinates) = square(0.4, 1.0);
    let of = |base_colour: Vec4| Material {
        base_colour,
        base_colour_image: None,
        ..unlit()
    };
    let paint = Paint {
        texture_coordinates,
        triangle_materials: vec![2, 1],
        materials: vec![of(Vec4::ONE), of(Vec4::Y + Vec4::W), of(Vec4::X + Vec4::W)],
        ..Paint::default()
    };
    let shot = shot(&gpu, mode(&gpu), &scene(vec![model(mesh, paint)]));
    assert_near(at(&shot.color[0], 0.2, 0.2), [255, 0, 0], "upper left");
    assert_near(at(&shot.color[0], 0.8, 0.8), [0, 255, 0], "lower right");
    silent(&gpu);
}

#[test]
fn what_alpha_cuts_out_shows_what_is_behind() {
    let Some(gpu) = device() else { return };
    // A hole in the middle, half as wide as the square.
    let hole = |x: u32, y: u32| {
        let inside = (4..12).contains(&x) && (4..12).contains(&y);
        [200, 200, 200, if inside { 40 } else { 255 }]
    };
    let shown = |alpha: Alpha| {
        let material = Material { alpha, ..unlit() };
        let shot = shot(&gpu, mode(&gpu), &painted(1.0, material, png(16, 16, hole)));
        [0.5, 0.1].map(|across| at(&shot.color[0], across, 0.5))
    };
    let grey = [200; 3];
    for (alpha, middle) in [
        (Alpha::Opaque, grey),
        (Alpha::Mask(0.1), grey),
        (Alpha::Mask(0.5), [0; 3]),
    ] {
        let [found, edge] = shown(alpha);
        assert_near(found, middle, &format!("{alpha:?}"));
        assert_near(edge, grey, &format!("{alpha:?}, outside"));
    }
    // An eighth is hardly there: a quarter of the samples at most.
    let [found, edge] = shown(Alpha::Blend);
    assert!(found[0] < 110, "{found:?}");
    assert_near(edge, grey, "outside of what shines through");
    silent(&gpu);
}

#[test]
fn far_away_an_image_is_its_average() {
    let Some(gpu) = device() else { return };
    let stripes = png(512, 512, |x, _| [[0, 0, 0, 255], [255; 4]][x as usize % 2]);
    // Some twenty stripes a pixel.
    let shot = shot(&gpu, mode(&gpu), &painted(8.0, unlit(), stripes));
    for part in [0.2, 0.4, 0.6, 0.8] {
        assert_near(
            at(&shot.color[0], part, part),
            [188; 3],
            "half of the light",
        );
    }
    silent(&gpu);
}

#[test]
fn light_and_sides_are_as_the_material_says() {
    let Some(gpu) = device() else { return };
    let seen = |turned: bool, change: &dyn Fn(&mut Material)| {
        let mut material = Material {
            is_unlit: false,
            metallic: 0.0,
            ..unlit()
        };
        change(&mut material);
        let mut scene = painted(1.0, material, png(2, 2, |_, _| [0, 180, 0, 255]));
        if turned {
            scene.models[0].world_from_model = Affine3A::from_rotation_y(std::f32::consts::PI);
        }
        let shot = shot(&gpu, mode(&gpu), &scene);
        at(&shot.color[0], 0.5, 0.5)
    };
    let lit = seen(false, &|_| ());
    assert!(lit[1] > 60 && lit[1] > lit[0] + 40, "{lit:?}");
    // From behind, a surface of one side shows its inside.
    let behind = seen(true, &|_| ());
    assert!(behind[0] > behind[1], "{behind:?}");
    let both = seen(true, &|material| material.is_double_sided = true);
    assert!(both[1] > both[0] + 30, "{both:?}");
    let shining = seen(false, &|material| material.emission = Vec3::X);
    assert!(
        shining[0] > 240 && shining[1].abs_diff(lit[1]) < 6,
        "{shining:?}"
    );
    silent(&gpu);
}

/// A green square with more images, as [`unlit`] puts them on.
fn with_image(image: Image, change: &dyn Fn(&mut Material, Texture)) -> Scene {
    let (mesh, texture_coordinates) = square(0.4, 1.0);
    let mut material = Material {
        is_unlit: false,
        is_double_sided: true,
        metallic: 0.0,
        base_colour: Vec4::new(0.1, 0.4, 0.1, 1.0),
        ..unlit()
    };
    if let Some(texture) = material.base_colour_image.take() {
        change(&mut material, texture);
    }
    let paint = Paint {
        texture_coordinates,
        materials: vec![material],
        images: vec![image],
        ..Paint::default()
    };
    scene(vec![model(mesh, paint)])
}

#[test]
fn normals_of_an_image_light_a_surface_as_if_it_were_turned() {
    let Some(gpu) = device() else { return };
    let plain = || png(2, 2, |_, _| [255; 4]);
    let turns: [(f32, Vec3, [u8; 3]); 4] = [
        // Half a right angle's half: sin 0.5, cos 0.866.
        (30.0, Vec3::Y, [191, 128, 238]),
        (-30.0, Vec3::Y, [64, 128, 238]),
        (-30.0, Vec3::X, [128, 191, 238]),
        (30.0, Vec3::X, [128, 64, 238]),
    ];
    let mut seen = Vec::new();
    for mode in [mode(&gpu), StereoMode::PerEye] {
        for (degrees, axis, [red, green, blue]) in turns {
            let normals = png(4, 4, |_, _| [red, green, blue, 255]);
            let mapped = with_image(normals, &|material, texture| {
                material.normal_image = Some(texture);
            });
            let mut turned = with_image(plain(), &|_, _| ());
            turned.models[0].world_from_model =
                Affine3A::from_axis_angle(axis, degrees.to_radians());
            let [mapped, turned] =
                [mapped, turned].map(|scene| at(&shot(&gpu, mode, &scene).color[0], 0.5, 0.5));
            for (a, b) in mapped.iter().zip(turned) {
                assert!(
                    a.abs_diff(b) <= 6,
                    "{degrees}° about {axis}: {mapped:?}, {turned:?}"
                );
            }
            seen.push(mapped);
        }
    }
    seen.sort_unstable();
    assert!(seen[0][1] + 20 < seen[7][1], "the turns differ: {seen:?}");
    silent(&gpu);
}

#[test]
fn images_of_emission_metal_and_roughness_count() {
    let Some(gpu) = device() else { return };
    let seen = |pixel: [u8; 4], change: &dyn Fn(&mut Material, Texture)| {
        let scene = with_image(png(2, 2, |_, _| pixel), change);
        at(&shot(&gpu, mode(&gpu), &scene).color[0], 0.5, 0.5)
    };
    let none = seen([255; 4], &|_, _| ());
    // Half of the light is byte 188.
    let shining = seen([188, 0, 0, 255], &|material, texture| {
        (material.emission, material.emission_image) = (Vec3::ONE, Some(texture));
    });
    assert!(
        shining[0] > 185 && shining[1].abs_diff(none[1]) <= 2,
        "{shining:?}, {none:?}"
    );
    // By numbers: an image that says half rough and all metal is a material that says so.
    let by_image = seen([0, 128, 255, 255], &|material, texture| {
        (material.metallic, material.roughness) = (1.0, 1.0);
        material.metal_roughness_image = Some(texture);
    });
    let by_number = seen([255; 4], &|material, _| {
        (material.metallic, material.roughness) = (1.0, 0.5);
    });
    for (a, b) in by_image.iter().zip(by_number) {
        assert!(a.abs_diff(b) <= 3, "{by_image:?}, {by_number:?}");
    }
    assert!(by_number.iter().zip(none).any(|(a, b)| a.abs_diff(b) > 10));
    silent(&gpu);
}

#[test]
fn large_images_come_in_parts_and_go_with_their_model() {
    let Some(gpu) = device() else { return };
    let [start, _] = gpu.memory();
    let params = RendererParams {
        direct_triangles: usize::MAX,
        ..plain(mode(&gpu), 0.0)
    };
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    // 64 MiB, twice what goes up in a frame.
    let large = png(4096, 4096, |x, y| [(x / 16) as u8, (y / 16) as u8, 90, 255]);
    let scene = painted(1.0, unlit(), large);
    let mut frames = 0;
    while !renderer.has_models(&scene) {
        renderer
            .draw(&scene, &ahead(DISTANCE), &offscreen.target())
            .unwrap();
        frames += 1;
        assert!(frames < 12, "it never came");
    }
    assert!(frames > 2, "{frames} frames");
    let [with, _] = gpu.memory();
    let picture = |renderer: &mut Renderer| {
        renderer
            .draw(&scene, &ahead(DISTANCE), &offscreen.target())
            .unwrap();
        let [left, _] = offscreen.read_color().unwrap();
        left
    };
    let left = picture(&mut renderer);
    for (across, down) in [(0.1, 0.1), (0.9, 0.2), (0.5, 0.5), (0.3, 0.9)] {
        let expected = [across, down].map(|part: f32| (part * 255.0) as u8);
        assert_near(
            at(&left, across, down),
            [expected[0], expected[1], 90],
            "a place of the large image",
        );
    }
    for _ in 0..8 {
        renderer
            .draw(&Scene::default(), &ahead(DISTANCE), &offscreen.target())
            .unwrap();
    }
    assert!(gpu.memory()[0] < with - (64 << 20), "its image is let go");
    drop((renderer, offscreen));
    assert_eq!(gpu.memory()[0], start);
    silent(&gpu);
}
