//! Colours, texture coordinates, materials and images.

use std::io::Cursor;

use glam::{Vec2, Vec4};

use super::*;
use crate::mesh::paint::{Alpha, ImageKind, Material, Paint, WHITE, Wrap};

/// An image of four pixels.
pub(in super::super) fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let image = image::RgbImage::from_pixel(2, 2, image::Rgb([9, 8, 7]));
    let png = image::ImageFormat::Png;
    image.write_to(&mut Cursor::new(&mut bytes), png).unwrap();
    bytes
}

/// The pyramid with a textured foot, coloured sides, and a part without anything.
pub(in super::super) fn painted() -> Made {
    let mut made = Made::new();
    let points = made.points();
    let uvs: Vec<f64> = (0..10).map(|value| f64::from(value) / 4.0).collect();
    let uv = made.accessor(FLOAT, "VEC2", &uvs);
    let colours: Vec<f64> = (0..15).map(|value| f64::from(value) * 17.0).collect();
    let colour = made.accessor(UNSIGNED_BYTE, "VEC3", &colours);
    made.json["accessors"][colour]["normalized"] = json!(true);
    let view = made.view(&png());
    made.add(
        "images",
        json!({ "bufferView": view, "mimeType": "image/jpeg", "name": "moss" }),
    );
    made.add("samplers", json!({ "wrapS": 33071, "wrapT": 33648 }));
    made.add("textures", json!({ "source": 0, "sampler": 0 }));
    made.add("materials", json!({ "name": "nobody's" }));
    made.add(
        "materials",
        json!({
            "name": "foot", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
            "pbrMetallicRoughness": {
                "baseColorFactor": [1, 0.5, 0.25, 1], "metallicFactor": 0, "roughnessFactor": 0.75,
                "baseColorTexture": { "index": 0, "texCoord": 7, "extensions": { "KHR_texture_transform": {
                    "texCoord": 1, "offset": [0.5, 0.25], "scale": [2, 4], "rotation": std::f32::consts::FRAC_PI_2,
                } } },
            },
            "extensions": { "KHR_materials_unlit": {} },
        }),
    );
    let parts = [&TRIANGLES[4..], &TRIANGLES[..2], &TRIANGLES[2..4]];
    let parts = parts.map(|part| {
        let corners: Vec<f64> = part
            .as_flattened()
            .iter()
            .map(|&corner| corner.into())
            .collect();
        made.accessor(UNSIGNED_BYTE, "SCALAR", &corners)
    });
    let primitives = [
        json!({ "attributes": { "POSITION": points, "TEXCOORD_0": colour, "TEXCOORD_1": uv }, "indices": parts[0], "material": 1 }),
        json!({ "attributes": { "POSITION": points, "COLOR_0": colour }, "indices": parts[1] }),
        json!({ "attributes": { "POSITION": points }, "indices": parts[2] }),
    ];
    one_mesh(made, &primitives)
}

fn paint(made: &Made) -> (Paint, Vec<String>) {
    let model = made.read();
    (model.paint.unwrap(), model.remarks)
}

#[test]
fn all_paint_is_read() {
    let (paint, remarks) = paint(&painted());
    assert!(remarks.is_empty(), "{remarks:?}");
    let uvs = (0..5).map(|at| Vec2::new(2.0 * at as f32, 2.0 * at as f32 + 1.0) / 4.0);
    let uvs: Vec<Vec2> = uvs.chain([Vec2::ZERO; 10]).collect();
    assert_eq!(paint.texture_coordinates, uvs);
    let colour = |at: u16| [3 * at, 3 * at + 1, 3 * at + 2].map(|value| value * 17 * 257);
    let colours = (0..5).map(colour).map(|[r, g, b]| [r, g, b, u16::MAX]);
    let colours: Vec<_> = [WHITE; 5]
        .into_iter()
        .chain(colours)
        .chain([WHITE; 5])
        .collect();
    assert_eq!(paint.colours, colours);
    assert_eq!(paint.triangle_materials, [1, 1, 0, 0, 0, 0]);
    assert_eq!(paint.materials.len(), 2);
    assert_eq!(paint.materials[0], Material::default());
    let foot = &paint.materials[1];
    assert_eq!(
        (foot.name.as_str(), foot.alpha),
        ("foot", Alpha::Mask(0.25))
    );
    assert_eq!(foot.base_colour, Vec4::new(1.0, 0.5, 0.25, 1.0));
    assert_eq!((foot.metallic, foot.roughness), (0.0, 0.75));
    assert!(foot.is_double_sided && foot.is_unlit);
    let texture = foot.base_colour_image.unwrap();
    assert_eq!(texture.wrap, [Wrap::Clamp, Wrap::Mirror]);
    // Scaled to (2, 0) and (0, 4), turned by a quarter from v, which goes down, to u, and moved.
    for (at, expected) in [
        (Vec2::X, Vec2::new(0.5, -1.75)),
        (Vec2::Y, Vec2::new(4.5, 0.25)),
    ] {
        let found = texture.image_from_texture.transform_point2(at);
        assert!(found.distance(expected) < 1e-5, "{found} is not {expected}");
    }
    let image = &paint.images[texture.image as usize];
    assert_eq!((image.name.as_str(), image.kind), ("moss", ImageKind::Png));
    let pixels = image.decode(&Default::default()).unwrap();
    assert_eq!(pixels.rgba, [9, 8, 7, 255].repeat(4));
}

#[test]
fn a_single_material_needs_no_numbers_and_the_older_model_of_gloss_is_understood() {
    let mut made = Made::with_pyramid();
    made.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    made.json["extensionsRequired"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    made.add(
        "materials",
        json!({ "alphaMode": "BLEND", "extensions": { "KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.5, 0.25, 0, 0.5], "glossinessFactor": 0.25,
        } } }),
    );
    let (paint, _) = paint(&made);
    assert!(paint.triangle_materials.is_empty());
    let [material] = &paint.materials[..] else {
        panic!("one material");
    };
    assert_eq!(material.base_colour, Vec4::new(0.5, 0.25, 0.0, 0.5));
    assert_eq!((material.metallic, material.roughness), (0.0, 0.75));
    assert_eq!(material.alpha, Alpha::Blend);
}

#[test]
fn materials_are_numbered_in_each_place() {
    let mut made = painted();
    made.add("nodes", json!({ "mesh": 0, "scale": [2, 2, 2] }));
    let (paint, _) = paint(&made);
    assert_eq!(paint.triangle_materials, [1, 1, 0, 0, 0, 0].repeat(2));
    assert_eq!(paint.colours.len(), 30);
}

#[test]
fn broken_paint_is_remarked_on_and_the_surface_is_read() {
    let whole = painted().read().mesh;
    let image = |uri: Value| {
        let mut made = painted();
        made.json["images"][0] = uri;
        made
    };
    let with = |path: &[&str], value: Value| {
        let mut made = painted();
        *path
            .iter()
            .fold(&mut made.json, |json, name| match name.parse::<usize>() {
                Ok(at) => &mut json[at],
                Err(_) => &mut json[name],
            }) = value;
        made
    };
    let table = [
        (
            image(json!({ "uri": "data:;base64,AAAA" })),
            "neither PNG nor JPEG",
        ),
        (
            image(json!({ "uri": "data:;base64,iVBORw0KGgo=" })),
            "damaged",
        ),
        (image(json!({ "uri": "data:;base64,*" })), "base64"),
        (image(json!({ "uri": "data:,x" })), "base64"),
        (
            image(json!({ "uri": "../moss.png" })),
            "own bytes are at hand",
        ),
        (image(json!({ "bufferView": 99 })), "buffer view 99"),
        (image(json!({})), "no bytes"),
        (
            with(&["textures", "0", "source"], json!(5)),
            "no image as PNG or JPEG",
        ),
        (
            with(
                &["textures", "0"],
                json!({ "extensions": { "EXT_texture_webp": { "source": 0 } } }),
            ),
            "no image as PNG or JPEG",
        ),
        (
            with(
                &["materials", "1", "pbrMetallicRoughness", "baseColorTexture"],
                json!({ "index": 3, "texCoord": 1 }),
            ),
            "texture 3 is not there",
        ),
        (
            with(&["accessors", "1", "count"], json!(4)),
            "texture coordinates in accessor 1",
        ),
        (
            with(&["accessors", "2", "count"], json!(99)),
            "colours in accessor 2",
        ),
        (
            with(&["accessors", "2", "type"], json!("VEC2")),
            "colours in accessor 2",
        ),
        (
            with(&["meshes", "0", "primitives", "2", "material"], json!(8)),
            "the plain one is shown",
        ),
    ];
    for (made, told) in table {
        let model = made.read();
        assert_eq!(model.mesh, whole, "{told}");
        assert_eq!(model.remarks.len(), 1, "{told}: {:?}", model.remarks);
        assert!(model.remarks[0].contains(told), "{:?}", model.remarks);
    }
    let bad = with(&["accessors", "1", "componentType"], json!(UNSIGNED_INT));
    assert_eq!(bad.read().remarks.len(), 1);
}

#[test]
fn images_of_the_same_bytes_are_taken_once_and_remarks_come_to_an_end() {
    let mut made = Made::new();
    let points = made.points();
    let view = made.view(&png());
    let primitives: Vec<Value> = (0..40)
        .map(|material| json!({ "attributes": { "POSITION": points }, "material": material }))
        .collect();
    for number in 0..40 {
        made.add("images", json!({ "bufferView": view }));
        made.add("textures", json!({ "source": number }));
        made.add(
            "materials",
            json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": number } } }),
        );
    }
    let mut made = one_mesh(made, &primitives);
    let (paint, remarks) = paint(&made);
    assert_eq!((paint.images.len(), remarks.len()), (40, 0));
    let first = &paint.images[0].encoded;
    assert!(
        paint
            .images
            .iter()
            .all(|image| std::sync::Arc::ptr_eq(first, &image.encoded))
    );
    for number in 0..40 {
        made.json["images"][number]["bufferView"] = json!(number + 100);
    }
    assert_eq!(made.read().remarks.len(), 13);
}

#[test]
fn all_images_of_a_material_are_read_where_they_lie_alike() {
    let all = |normals: Value| {
        let mut made = Made::with_pyramid();
        made.json["meshes"][0]["primitives"][0]["material"] = json!(0);
        let view = made.view(&png());
        for number in 0..4 {
            made.add("images", json!({ "bufferView": view }));
            made.add("textures", json!({ "source": number }));
        }
        made.add(
            "materials",
            json!({
                "pbrMetallicRoughness": {
                    "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 2 },
                },
                "emissiveTexture": { "index": 1 }, "emissiveFactor": [1, 0.5, 0],
                "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 4 } },
                "normalTexture": normals,
            }),
        );
        paint(&made)
    };
    let (found, remarks) = all(json!({ "index": 3, "scale": 0.5 }));
    assert!(remarks.is_empty(), "{remarks:?}");
    let material = &found.materials[0];
    let images = material.images().map(|image| image.map(|of| of.image));
    assert_eq!(images, [Some(0), Some(1), Some(2), Some(3)]);
    assert_eq!(material.normal_scale, 0.5);
    assert_eq!(material.emission.to_array(), [4.0, 2.0, 0.0]);
    for elsewhere in [
        json!({ "index": 3, "texCoord": 1 }),
        json!({ "index": 3, "extensions": { "KHR_texture_transform": { "offset": [0.5, 0] } } }),
    ] {
        let (found, remarks) = all(elsewhere);
        assert!(found.materials[0].normal_image.is_none());
        assert!(remarks[0].contains("does not lie"), "{remarks:?}");
    }
}
