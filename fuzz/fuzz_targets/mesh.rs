//! The readers of models, whichever the bytes are for: no bytes may stop them, and what they read is whole.
#![no_main]

use std::sync::atomic::AtomicBool;

use libfuzzer_sys::fuzz_target;
use ramus::mesh::{ReadLimits, read_bytes};

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
    // A file shorter than any of ours for what it holds would be a reader that takes more than it was given.
    assert!(vertices <= bytes.len(), "each vertex takes a byte or more");
    assert!(
        mesh.triangles.len() <= bytes.len(),
        "each triangle takes a byte or more"
    );
});
