//! Times of the tree's room: radii, segments, mesh, comparison, files. `cargo bench --bench tree [-- NAME]`
#![allow(
    missing_docs,
    clippy::unwrap_used,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::hint::black_box;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Quat, Vec3};
use ramus::tree::bark::Bark;
use ramus::tree::compare::{Studied, compare};
use ramus::tree::export::{self, ExportParams};
use ramus::tree::foliage::{Bearing, Dress, kind};
use ramus::tree::radii::{RadiusParams, da_vinci, da_vinci_into};
use ramus::tree::tubes::{SegmentBuilder, mesh};
use ramus::tree::{NO_PARENT, Node, Organs, Tree, growth, import};

/// A bush like those that sketches make: axes of twelve segments in gentle curves, a lateral at every third node, written axis by axis
/// as a turtle does, the last step's segments marked as newest (birth 9).
fn bush(segments: usize) -> Tree {
    let mut tree = Tree {
        letters: vec!["A".into(), "C".into()],
        ..Tree::with_capacity(segments + 1)
    };
    tree.push(Node {
        parent: NO_PARENT,
        position: Vec3::ZERO,
        radius: 0.0,
        letter: 0,
        order: 0,
        birth: 0,
    });
    let mut starts = std::collections::VecDeque::from([(0_u32, Vec3::Y, 0_u16)]);
    while let Some((mut parent, mut direction, order)) = starts.pop_front() {
        for step in 0..12_u32 {
            if tree.len() > segments {
                return tree;
            }
            let angle = 2.4 * f32::from(u16::try_from(parent % 1000).unwrap());
            direction =
                Quat::from_axis_angle(Vec3::new(angle.cos(), 0.0, angle.sin()), 0.15) * direction;
            let position = tree.position[parent as usize] + 0.1 * direction;
            let birth = if step == 11 {
                9
            } else {
                u32::from(order.min(8))
            };
            parent = tree.push(Node {
                parent,
                position,
                radius: 0.0,
                letter: u16::from(order > 0),
                order,
                birth,
            });
            if step % 3 == 2 && step < 11 {
                let side =
                    Quat::from_axis_angle(direction.any_orthonormal_vector(), 0.9) * direction;
                starts.push_back((
                    parent,
                    Quat::from_axis_angle(direction, angle) * side,
                    order + 1,
                ));
            }
        }
    }
    tree
}

fn tree_benches(criterion: &mut Criterion) {
    let params = RadiusParams::default();
    for (name, segments) in [("100k", 100_000_usize), ("1M", 1_000_000)] {
        let mut tree = bush(segments);
        let before = da_vinci(&mut tree, &params, 9);
        let mut group = criterion.benchmark_group(name);
        group.throughput(Throughput::Elements(segments as u64));
        group
            .sample_size(10)
            .warm_up_time(Duration::from_millis(500))
            .measurement_time(Duration::from_secs(2));

        let mut scratch = Vec::new();
        group.bench_function("da_vinci", |b| {
            b.iter(|| da_vinci_into(&mut tree, &params, 9, &mut scratch))
        });
        let mut builder = SegmentBuilder::default();
        let mut records = Vec::new();
        group.bench_function("segments", |b| {
            b.iter(|| builder.build(&tree, &before, 9, &mut records))
        });
        group.bench_function("grown", |b| {
            b.iter(|| growth::grown(&tree, &before, 9, black_box(0.5)))
        });
        group.bench_function("mesh_8_sides", |b| b.iter(|| mesh(&records, 1.0, 8)));
        group.bench_function("glb", |b| {
            b.iter(|| export::glb(&tree, &ExportParams::default()).unwrap())
        });
        group.bench_function("study", |b| b.iter(|| Studied::new(&tree, DVec3::ZERO)));
        let both = [&tree, &bush(segments / 2)].map(|tree| Studied::new(tree, DVec3::ZERO));
        group.bench_function("compare", |b| {
            b.iter(|| compare(&both, &AtomicBool::new(false), &mut |_, _| {}))
        });
        group.bench_function("swc_write", |b| b.iter(|| export::swc(&tree).unwrap()));
        let text = export::swc(&tree).unwrap();
        group.bench_function("swc_read", |b| b.iter(|| import::swc(&text).unwrap()));
        if segments <= 100_000 {
            group.bench_function("obj", |b| {
                b.iter(|| export::obj(&tree, &ExportParams::default()).unwrap())
            });
        }
        let dress = Dress {
            bark: Bark::Oak,
            flare: 0.5,
            bears: vec![Bearing::of(kind("oak").unwrap())],
            ..Dress::default()
        };
        group.bench_function("dress", |b| {
            b.iter(|| {
                let mut organs = Organs::default();
                dress.put_on(&tree, &mut organs, 1, None);
                organs.placed.len()
            });
        });
        group.finish();
    }
}

criterion_group!(benches, tree_benches);
criterion_main!(benches);
