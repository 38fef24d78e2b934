//! The readers of models, whichever the bytes are for: no bytes may stop them, and what they read is whole.
#![no_main]

use std::sync::atomic::AtomicBool;

use libfuzzer_sys::fuzz_target;
use ramus::mesh::{Format, ReadLimits, read_bytes};

fuzz_target!(|bytes: &[u8]| {
    let never = AtomicBool::new(false);
    let Ok(model) = read_bytes(bytes, &ReadLimits::default(), &never) else {
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
    // What is made of a byte at most; more would be a reader that takes more than it was given. Blocks of zlib hold a thousand times
    // their length, and a node of a skeleton gets rings around it.
    let most = match model.format {
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
