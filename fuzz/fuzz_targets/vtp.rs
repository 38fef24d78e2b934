//! Centerlines in VTP files: no bytes may stop their reader, and what it read is a tree that can be measured and written.
#![no_main]

use std::sync::atomic::AtomicBool;

use libfuzzer_sys::fuzz_target;
use ramus::mesh::{ReadLimits, read_bytes};
use ramus::tree::export::Vtp;
use ramus::tree::measure::Measures;

const LIMITS: ReadLimits = ReadLimits {
    bytes: 1 << 30,
    vertices: 1 << 16,
    triangles: 1 << 18,
};

/// Larger trees take too long to be measured here.
const MOST_MEASURED: usize = 1 << 10;

fuzz_target!(|bytes: &[u8]| {
    let never = AtomicBool::new(false);
    let Ok(model) = read_bytes(bytes, &LIMITS, &never) else {
        return;
    };
    let origin = model.mesh.origin;
    let Some(tree) = model.skeleton else { return };
    tree.validate().expect("what was read is a whole tree");
    if tree.len() > MOST_MEASURED {
        return;
    }
    let measures = Measures::new(&tree);
    if let Some(split) = measures.vmtk {
        let lines: u32 = split.branches.iter().filter(|one| one.tip.is_some()).map(|one| one.tips).sum();
        assert!(lines as usize <= measures.tips, "no line is there twice");
    }
    let mut written = Vec::new();
    let file = Vtp::new(&tree, origin).expect("a tree with a segment can be written");
    file.write(&mut written).expect("memory takes it");
});
