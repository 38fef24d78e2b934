//! How much memory large trees take: so many bytes a segment and a leaf, however many there are.
#![allow(clippy::unwrap_used, reason = "tests")]

mod weighing;

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use ramus::{
    render::{Gpu, GpuParams, Headless, TreeUpload},
    tree::{
        NO_PARENT, Node, Organs, Tree,
        foliage::{Bearing, kind},
        organs::{Paint, Placed},
    },
    world::scene::PlacedTree,
};
use weighing::heaviest;

/// A tree of so many segments, each branch of ten standing on an earlier one, with a leaf on one in five.
fn tree(segments: u32) -> PlacedTree {
    let mut tree = Tree {
        letters: vec!["A".to_owned()],
        ..Tree::default()
    };
    let mut placed = Vec::new();
    for node in 0..=segments {
        let parent = match node {
            0 => NO_PARENT,
            _ if node % 10 == 1 && node > 10 => node / 10,
            _ => node - 1,
        };
        let part = f64::from(node) * 2.4;
        #[allow(clippy::cast_possible_truncation, reason = "-1 to 1")]
        let turned = Vec3::new(part.sin() as f32, 1.0, part.cos() as f32) * 0.02;
        let foot = tree.position.get(parent as usize).copied();
        let position = foot.unwrap_or_default() + turned;
        tree.push(Node {
            parent,
            position,
            radius: 0.004,
            order: 0,
            letter: 0,
            birth: node % 5,
        });
        if node % 5 == 0 {
            placed.push(Placed {
                surface: 0,
                paint: Paint::default(),
                position,
                orientation: Quat::IDENTITY,
                scale: 0.05,
                birth: 0,
                node,
                light: 0.7,
            });
        }
    }
    PlacedTree {
        tree: Arc::new(tree),
        organs: Arc::new(Organs {
            surfaces: vec![Bearing::of(kind("maple").unwrap()).surface],
            placed,
            ..Organs::default()
        }),
        radius_before: Arc::default(),
        revision: 1,
        world_from_tree: Affine3A::IDENTITY,
        growth: 1.0,
        newest: 5,
    }
}

/// `cargo bench --bench frame` draws ten million and says what they take; here are enough for the number to be the same.
#[test]
fn a_large_tree_takes_so_many_bytes_a_segment() {
    let gpu = match Gpu::new(&Headless::default(), &GpuParams::default()) {
        Ok(gpu) => gpu,
        Err(error) => {
            assert!(
                std::env::var("CI").is_err(),
                "CI needs a Vulkan device: {error}"
            );
            eprintln!("skipped: {error}");
            return;
        }
    };
    let mut each = Vec::new();
    for segments in [200_000_u32, 800_000] {
        let tree = tree(segments);
        let (upload, heap) = heaviest(|| TreeUpload::new(&gpu, &tree, None).unwrap());
        let (heap, device) = (heap as u64, upload.bytes());
        let count = u64::from(segments);
        eprintln!(
            "{segments} segments: {} bytes of heap each, {} on the device, as many again on their way there",
            heap / count,
            device / count
        );
        // A segment has 80 bytes and a fifth of a leaf 10, in all levels twice that, and clusters.
        assert!(device < 190 * count, "{device} bytes on the device");
        each.push(heap / count);
    }
    assert!(
        each.iter().all(|each| *each < 600),
        "{each:?} bytes of heap"
    );
    assert!(
        each[1] < each[0] + each[0] / 10,
        "no more for more: {each:?}"
    );
}
