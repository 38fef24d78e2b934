//! Images become layers as bright as they were, seams stay, and paint follows what is mended.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "a test that fails shows the line"
)]

use std::io::Cursor;
use std::sync::Arc;

use glam::{Affine2, Vec3, Vec4};
use image::{ImageFormat, Rgba, RgbaImage};

use super::*;
use crate::mesh::paint::{Image, Texture, WHITE, Wrap};

static NEVER: AtomicBool = AtomicBool::new(false);

fn image(width: u32, height: u32, colour: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let pixels = RgbaImage::from_fn(width, height, |x, y| Rgba(colour(x, y)));
    let mut bytes = Vec::new();
    pixels
        .write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png)
        .unwrap();
    Image::new("bark".into(), Arc::new(bytes), &ImageLimits::default()).unwrap()
}

fn of_image(image: u32) -> Material {
    Material {
        base_colour_image: Some(Texture {
            image,
            image_from_texture: Affine2::IDENTITY,
            wrap: [Wrap::Repeat; 2],
        }),
        ..Material::default()
    }
}

fn textured(paint: Paint, limits: &LayerLimits) -> (Textured, Vec<String>) {
    let (textured, remarks) = Textured::new(paint, limits, &NEVER).unwrap();
    (textured.unwrap(), remarks)
}

fn of_images(images: Vec<Image>, limits: &LayerLimits) -> (Textured, Vec<String>) {
    let count = u32::try_from(images.len()).unwrap();
    let paint = Paint {
        materials: (0..count).map(of_image).collect(),
        images,
        ..Paint::default()
    };
    textured(paint, limits)
}

/// The texel of a level of a layer.
fn texel(layers: &Layers, layer: u32, level: u32, [x, y]: [u32; 2]) -> [u8; 4] {
    let mut parts = layers.parts();
    let part = parts.find(|part| (part.layer, part.level) == (layer, level));
    let part = part.unwrap();
    let at = part.bytes.start + 4 * (y * part.size_px[0] + x) as usize;
    *layers.texels[at..part.bytes.end].first_chunk().unwrap()
}

#[test]
fn coarser_levels_are_as_bright_as_the_image() {
    let stripes = image(64, 64, |x, _| [[0, 0, 0, 255], [255; 4]][x as usize % 2]);
    let (textured, remarks) = of_images(vec![stripes], &LayerLimits::default());
    let layers = &textured.layers;
    assert!(remarks.is_empty());
    assert_eq!(
        (layers.size_px, layers.count, layers.levels()),
        ([64; 2], 1, 7)
    );
    assert_eq!(texel(layers, 0, 0, [5, 9]), [255; 4]);
    // Half of the light, which is byte 188; halved bytes would be 128.
    for level in 1..7 {
        assert_eq!(texel(layers, 0, level, [0, 0]), [188, 188, 188, 255]);
    }
}

#[test]
fn sides_of_any_length_keep_every_texel() {
    for (width, height) in [(1, 1), (5, 3), (3, 64), (1, 7), (100, 1)] {
        // One bright texel at each end: none is lost on the way to the last level.
        let is_end = move |x: u32, y: u32| (x, y) == (0, 0) || (x, y) == (width - 1, height - 1);
        let ends = image(width, height, |x, y| {
            if is_end(x, y) {
                [255; 4]
            } else {
                [0, 0, 0, 255]
            }
        });
        let (textured, _) = of_images(vec![ends], &LayerLimits::default());
        let layers = &textured.layers;
        let whole: usize = layers.parts().map(|part| part.bytes.len()).sum();
        assert_eq!(whole, layers.texels.len());
        let parts: Vec<_> = layers.parts().collect();
        assert!(
            parts
                .windows(2)
                .all(|pair| pair[0].bytes.end == pair[1].bytes.start)
        );
        let last = texel(layers, 0, layers.levels() - 1, [0, 0]);
        let bright = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let share =
            f64::from(u32::try_from(bright.filter(|(x, y)| is_end(*x, *y)).count()).unwrap())
                / f64::from(width * height);
        let light = crate::mesh::srgb::linear(f64::from(last[0]) / 255.0);
        // A level's rounding to bytes is felt in the dark.
        assert!(
            (light - share).abs() < 0.02,
            "{width} × {height}: {light} of {share}"
        );
    }
}

#[test]
fn images_become_layers_of_one_size_within_their_limits() {
    let plain = |width, height, colour: [u8; 4]| image(width, height, move |_, _| colour);
    let three = || {
        vec![
            plain(32, 8, [200, 0, 0, 255]),
            plain(8, 16, [0, 200, 0, 255]),
            plain(4, 4, [0, 0, 200, 128]),
        ]
    };
    let (found, _) = of_images(three(), &LayerLimits::default());
    let layers = &found.layers;
    assert_eq!((layers.size_px, layers.count), ([32, 16], 3));
    for (layer, colour) in [
        (0, [200, 0, 0, 255]),
        (1, [0, 200, 0, 255]),
        (2, [0, 0, 200, 128]),
    ] {
        assert_eq!(texel(layers, layer, 0, [17, 9]), colour);
        assert_eq!(texel(layers, layer, 3, [1, 0]), colour);
    }
    for limits in [
        LayerLimits {
            side_px: 10,
            ..LayerLimits::default()
        },
        LayerLimits {
            bytes: 1000,
            ..LayerLimits::default()
        },
    ] {
        let (found, _) = of_images(three(), &limits);
        let [width, height] = found.layers.size_px;
        assert!(width.max(height) <= limits.side_px && width >= height);
        assert!(found.layers.texels.len() as u64 <= limits.bytes);
        assert_eq!(texel(&found.layers, 2, 0, [0, 0]), [0, 0, 200, 128]);
    }
    let two = LayerLimits {
        count: 2,
        ..LayerLimits::default()
    };
    let (found, remarks) = of_images(three(), &two);
    assert_eq!(found.layers.count, 2);
    assert_eq!(remarks, ["more than 2 images are not shown"]);
    let shown = |material: &Material| material.base_colour_image.is_some();
    assert_eq!(found.materials.iter().filter(|of| shown(of)).count(), 2);
}

#[test]
fn the_same_image_a_hundred_times_is_one_layer() {
    let one = image(8, 8, |x, _| [x as u8 * 30, 0, 0, 255]);
    let (found, remarks) = of_images(vec![one; 300], &LayerLimits::default());
    assert!(remarks.is_empty(), "{remarks:?}");
    assert_eq!((found.layers.count, found.layers.size_px), (1, [8, 8]));
    let layer = |material: &Material| material.base_colour_image.map(|image| image.image);
    assert!(
        found
            .materials
            .iter()
            .all(|material| layer(material) == Some(0))
    );
}

#[test]
fn a_broken_image_is_told_and_the_others_stay() {
    let good = image(4, 4, |_, _| [9, 8, 7, 255]);
    let whole = image(64, 64, |x, y| [x as u8, y as u8, 3, 255]);
    let cut = whole.encoded[..whole.encoded.len() / 2].to_vec();
    let broken = Image {
        encoded: Arc::new(cut),
        ..whole
    };
    let (found, remarks) = of_images(vec![broken, good], &LayerLimits::default());
    assert_eq!(remarks.len(), 1);
    assert!(
        remarks[0].contains("the image bark cannot be shown"),
        "{}",
        remarks[0]
    );
    let layers: Vec<_> = found
        .materials
        .iter()
        .map(|material| material.base_colour_image.map(|texture| texture.image))
        .collect();
    assert_eq!(layers, [None, Some(0)]);
    assert_eq!(texel(&found.layers, 0, 0, [1, 1]), [9, 8, 7, 255]);
}

#[test]
fn a_file_that_says_nothing_of_colours_has_no_look() {
    let paint = Paint {
        texture_coordinates: vec![Vec2::ZERO; 3],
        ..Paint::default()
    };
    let (none, remarks) = Textured::new(paint, &LayerLimits::default(), &NEVER).unwrap();
    assert!(none.is_none() && remarks.is_empty());
    let coloured = Paint {
        colours: vec![[u16::MAX, 32_768, 0, u16::MAX], WHITE],
        ..Paint::default()
    };
    let (found, _) = textured(coloured.clone(), &LayerLimits::default());
    assert_eq!(found.colours, [[255, 188, 0, 255], [255; 4]]);
    assert_eq!(found.materials.len(), 1);
    assert!(
        found.materials[0].metallic.abs() < 1e-6,
        "a scan is no metal"
    );
    let stopped = AtomicBool::new(true);
    let with_image = Paint {
        images: vec![image(2, 2, |_, _| [0; 4])],
        ..coloured
    };
    assert!(Textured::new(with_image, &LayerLimits::default(), &stopped).is_none());
}

#[test]
fn vertices_are_one_where_place_and_look_are() {
    let (mut found, _) = textured(
        Paint {
            materials: vec![Material::default(); 2],
            ..Paint::default()
        },
        &LayerLimits::default(),
    );
    let places = [0, 1, 0, 0, 1, 5, 0];
    assert_eq!(found.joined(&places), places, "nothing parts them");
    found.coordinates = [0.0, 0.0, 0.5, 0.0, 0.0, 0.5, 0.5]
        .map(|u| Vec2::new(u, 1.0))
        .to_vec();
    assert_eq!(found.joined(&places), [0, 1, 2, 0, 1, 5, 2]);
    found.colours = vec![[255; 4]; 7];
    found.colours[3] = [0; 4];
    assert_eq!(found.joined(&places), [0, 1, 2, 3, 1, 5, 2]);
    // All in one place, each another look: not compared with each other for ever.
    let many = 200_000;
    found.colours.clear();
    found.coordinates = (0..many).map(|x| Vec2::new(x as f32, 0.0)).collect();
    let joined = found.joined(&vec![0; many]);
    assert!((0..).zip(joined).all(|(vertex, own)| own == vertex));
}

#[test]
fn borders_are_where_materials_meet() {
    let (mut found, _) = textured(
        Paint {
            materials: vec![of_image(7), Material::default()],
            ..Paint::default()
        },
        &LayerLimits::default(),
    );
    assert!(
        found.materials[0].base_colour_image.is_none(),
        "no such image"
    );
    let mesh = Mesh {
        positions: vec![Vec3::ZERO; 6],
        triangles: vec![[0, 1, 2], [2, 1, 3], [4, 5, 3]],
        ..Mesh::default()
    };
    let places = [0, 1, 2, 3, 2, 5];
    assert!(found.borders(&mesh, &places).is_empty());
    found.triangle_materials = vec![0, 0, 1];
    let borders = found.borders(&mesh, &places);
    assert_eq!(borders, [false, false, true, true, false, false]);
    // Numbers that are none are the first.
    found.triangle_materials = vec![9];
    assert_eq!([0, 1].map(|triangle| found.material_of(triangle)), [0, 0]);
    assert_eq!(found.colour(99), [255; 4]);
    assert_eq!(Vec4::ONE, found.materials[1].base_colour);
}

/// A flat sheet of quads, its place in the image the same as on the ground; the second half lies in another part of the image.
fn sheet(side: u32) -> (Mesh, Paint) {
    let mut mesh = Mesh::default();
    let mut paint = Paint {
        materials: vec![Material::default(); 2],
        ..Paint::default()
    };
    for (half, moved) in [(0, 0.0), (1, 5.0)] {
        let first = u32::try_from(mesh.positions.len()).unwrap();
        for y in 0..=side {
            for x in 0..=side {
                let at = Vec2::new((x + half * side) as f32, y as f32);
                mesh.positions.push(at.extend(0.0));
                paint.texture_coordinates.push(at * 0.1 + Vec2::Y * moved);
                let red = u16::try_from(1000 * (x + half * side)).unwrap();
                paint.colours.push([red, 0, 0, u16::MAX]);
            }
        }
        for y in 0..side {
            for x in 0..side {
                let a = first + y * (side + 1) + x;
                let [b, c, d] = [a + 1, a + side + 1, a + side + 2];
                mesh.triangles.extend([[a, b, d], [a, d, c]]);
                paint.triangle_materials.extend([half as u16; 2]);
            }
        }
    }
    (mesh, paint)
}

#[test]
fn paint_stays_where_it_was_when_a_mesh_is_mended() {
    use crate::mesh::mend::{list_from_text, mend_all};
    let (before, paint) = sheet(12);
    for (list, exactly) in [
        ("weld", true),
        ("weld,orient,largest", true),
        ("weld,decimate=25%", false),
        ("weld,remesh=0.8", false),
    ] {
        let mends = list_from_text(list).unwrap();
        let (mended, _) = mend_all(before.clone(), &mends, &NEVER, &mut |_, _, _| ()).unwrap();
        let (mesh, found) = moved(&paint, before.clone(), &mended, &NEVER).unwrap();
        assert_eq!(mesh.triangles.len(), mended.triangles.len(), "{list}");
        assert_eq!(found.texture_coordinates.len(), mesh.positions.len());
        if exactly {
            // Parted along the seam again, and nowhere else.
            assert_eq!(mesh.positions.len(), before.positions.len(), "{list}");
        }
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
            let middle = corners.into_iter().sum::<Vec3>() / 3.0;
            let half = u16::from(middle.x > 12.0);
            let over = corners
                .iter()
                .any(|at| (at.x > 12.01) != (half == 1) && (at.x - 12.0).abs() > 0.01);
            assert_eq!(found.triangle_materials[number], half, "{list}: {middle}");
            for (vertex, at) in triangle.iter().zip(corners) {
                let expected = at.truncate() * 0.1 + Vec2::Y * 5.0 * f32::from(half);
                let place = found.texture_coordinates[*vertex as usize];
                let off = place.distance(expected);
                // Where a triangle reaches over the seam its own part of the image goes on.
                assert!(off < 1e-4, "{list}: {place} at {at}, over the seam: {over}");
                let red = f32::from(found.colours[*vertex as usize][0]);
                assert!((red - 1000.0 * at.x).abs() < 2.0, "{list}: {red} at {at}");
            }
        }
    }
    let stopped = AtomicBool::new(true);
    assert!(moved(&paint, before.clone(), &before, &stopped).is_none());
}

#[test]
fn paint_of_nothing_but_points_and_lines_is_no_trouble() {
    let before = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
        triangles: vec![[0, 0, 0], [0, 1, 1], [0, 1, 9]],
        ..Mesh::default()
    };
    let paint = Paint {
        texture_coordinates: vec![Vec2::ONE; 2],
        materials: vec![Material::default()],
        ..Paint::default()
    };
    let (mesh, found) = moved(&paint, before.clone(), &before, &NEVER).unwrap();
    assert_eq!(mesh.triangles.len(), 3);
    assert_eq!(found.texture_coordinates.len(), mesh.positions.len());
}
