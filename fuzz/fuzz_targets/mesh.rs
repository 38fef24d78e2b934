//! The readers of models, whichever the bytes are for: no bytes may stop them, and what they read is whole.
#![no_main]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use libfuzzer_sys::fuzz_target;
use ramus::mesh::display::Display;
use ramus::mesh::paint::{ImageLimits, Paint};
use ramus::mesh::textured::{LayerLimits, Textured};
use ramus::mesh::{Format, Mesh, Model, ReadLimits, read_bytes};

/// What is read at most: a glTF scene may repeat a mesh as often as it likes.
const LIMITS: ReadLimits = ReadLimits {
    bytes: 1 << 30,
    vertices: 1 << 18,
    triangles: 1 << 18,
};

/// Larger ones take too long for a fuzzer to be drawn, too.
const MOST_DRAWN: usize = 1 << 12;

const LAYERS: LayerLimits = LayerLimits {
    count: 2,
    side_px: 16,
    bytes: 1 << 12,
};

/// Small, so that time is spent on models and not on pictures.
const IMAGES: ImageLimits = ImageLimits {
    side_px: 256,
    bytes: 1 << 16,
};

fuzz_target!(|bytes: &[u8]| {
    let never = AtomicBool::new(false);
    let Ok(model) = read_bytes(bytes, &LIMITS, &never) else {
        return;
    };
    let mesh = &model.mesh;
    assert!(!mesh.triangles.is_empty(), "no model without triangles");
    let vertices = mesh.positions.len();
    assert!(
        mesh.triangles
            .as_flattened()
            .iter()
            .all(|&vertex| (vertex as usize) < vertices),
        "all vertices are there"
    );
    assert!(
        mesh.origin.is_finite() && mesh.positions.iter().all(|point| point.is_finite()),
        "all coordinates are finite"
    );
    if let Some(paint) = &model.paint {
        check_paint(paint, mesh);
    }
    if vertices <= MOST_DRAWN && mesh.triangles.len() <= MOST_DRAWN {
        check_display(&model);
    }
    // What is made of a byte at most; more would be a reader that takes more than it was given. Blocks of zlib hold a thousand times
    // their length, and a node of a skeleton gets rings around it.
    let most = match model.format {
        // It may repeat a mesh as often as the limits let it.
        Format::Gltf | Format::Glb => return,
        Format::Vtp => 1100,
        Format::Swc => 4,
        _ => 1,
    };
    let most = bytes.len() * most;
    assert!(vertices <= most, "each vertex takes its share of the file");
    assert!(
        mesh.triangles.len() <= most,
        "each triangle takes its share of the file"
    );
    let skeleton = model.skeleton.as_ref();
    assert!(
        skeleton.is_none_or(|tree| tree.validate().is_ok()),
        "a skeleton is a tree"
    );
});

/// That it can be made ready to be drawn, whatever its triangles and materials are.
fn check_display(model: &Model) {
    let never = AtomicBool::new(false);
    let paint = model.paint.clone().unwrap_or_default();
    let (textured, _) = Textured::new(paint, &LAYERS, &never).expect("nobody stops it");
    let mesh = Arc::new(model.mesh.clone());
    let display = Display::new(mesh, textured.as_ref(), &never).expect("nobody stops it");
    let vertices = display.mesh.positions.len();
    let corners = display.levels.triangles.as_flattened();
    assert!(
        corners.iter().all(|vertex| (*vertex as usize) < vertices),
        "what is drawn is there"
    );
}

fn check_paint(paint: &Paint, mesh: &Mesh) {
    let is_all = |length: usize, all: usize| length == 0 || length == all;
    let vertices = mesh.positions.len();
    assert!(
        is_all(paint.texture_coordinates.len(), vertices)
            && is_all(paint.colours.len(), vertices)
            && is_all(paint.triangle_materials.len(), mesh.triangles.len()),
        "all vertices and triangles are painted or none"
    );
    assert!(
        paint
            .texture_coordinates
            .iter()
            .all(|place| place.is_finite()),
        "all texture coordinates are finite"
    );
    let mut materials = paint.triangle_materials.iter();
    assert!(
        materials.all(|&material| usize::from(material) < paint.materials.len().max(1)),
        "all materials are there"
    );
    for material in &paint.materials {
        let image = material.base_colour_image.map(|texture| texture.image);
        assert!(
            image.is_none_or(|image| (image as usize) < paint.images.len()),
            "all images are there"
        );
    }
    for image in &paint.images {
        // It may be damaged, which is said.
        let _ = image.decode(&IMAGES);
    }
}
