//! Times of centerlines: found in vessels of several sizes, and a large tree measured. `cargo bench --bench centerline [-- NAME]`
//!
//! The vessels are made by code; where `RAMUS_SHARED` points the models with a known truth are timed, too. What the whole program takes,
//! reading and measuring included, and beside VMTK, `scripts/peers.sh centerlines` says.
#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "Criterion's macros make undocumented functions; a bench may end on an error"
)]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};
use glam::{DVec3, Quat, Vec3};
use ramus::centerline::{Centerline, Params, centerline};
use ramus::mesh::endpoints::{Endpoint, Kind};
use ramus::mesh::pick::Picker;
use ramus::mesh::surface::Surface;
use ramus::mesh::{self, Mesh, ReadLimits};
use ramus::tree::measure::Measures;
use ramus::tree::{NO_PARENT, Node, Tree};

mod vessel;

use vessel::Vessel;

/// Ends, triangles, and what the vessel is called.
const VESSELS: [(u32, u32, &str); 4] = [
    (40, 60_000, "40_ends_60k"),
    (40, 240_000, "40_ends_240k"),
    (40, 960_000, "40_ends_960k"),
    (300, 1_000_000, "300_ends_1M"),
];

/// Models with a known truth, and whose ends they have.
const TRUTH: [(&str, &str); 3] = [
    ("d_duct13", "d_duct13"),
    ("e_artery40_50k", "e_artery40"),
    ("lungnoodle_airway60_80k", "lungnoodle_airway60"),
];

fn endpoints(source: DVec3, targets: Vec<DVec3>) -> Vec<Endpoint> {
    let one = |place: usize, point| Endpoint {
        point,
        name: format!("end {place}"),
        kind: match place {
            0 => Kind::Source,
            _ => Kind::Target,
        },
        snapped: None,
    };
    let all = std::iter::once(source).chain(targets).enumerate();
    all.map(|(place, point)| one(place, point)).collect()
}

fn surface(mesh: Mesh) -> Surface {
    let never = AtomicBool::new(false);
    let picker = Picker::new(Arc::new(mesh), &never, &mut |_, _| {}).unwrap();
    Surface::new(picker, &never).unwrap()
}

fn found(surface: &Surface, ends: &[Endpoint]) -> Centerline {
    let never = AtomicBool::new(false);
    centerline(surface, ends, &Params::default(), &never, &mut |_, _| {}).unwrap()
}

fn find(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, mesh: Mesh, ends: &[Endpoint]) {
    let triangles = mesh.triangles.len();
    let surface = surface(mesh);
    let first = found(&surface, ends);
    assert!(first.unreached.is_empty(), "every end of {name} is reached");
    group
        .throughput(Throughput::Elements(triangles as u64))
        .bench_function(name, |b| b.iter(|| found(&surface, ends)));
}

fn benches_of_vessels(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("find");
    group
        .sample_size(10)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(Duration::from_millis(1))
        .measurement_time(Duration::from_secs(1));
    for (tips, triangles, name) in VESSELS {
        let vessel = Vessel::new(tips);
        let ends = endpoints(vessel.source(), vessel.targets());
        find(&mut group, name, vessel.mesh(triangles), &ends);
    }
    if let Some(shared) = std::env::var_os("RAMUS_SHARED") {
        for (name, ends) in TRUTH {
            truth(
                &mut group,
                &Path::new(&shared).join("models/truth"),
                name,
                ends,
            );
        }
    }
    group.finish();
}

fn truth(group: &mut BenchmarkGroup<'_, WallTime>, folder: &Path, name: &str, ends: &str) {
    let never = AtomicBool::new(false);
    let path = folder.join(format!("{name}.ply"));
    let mesh = mesh::read(&path, &ReadLimits::default(), &never)
        .unwrap()
        .mesh;
    let seeds = std::fs::read_to_string(folder.join(format!("{ends}.seeds.json"))).unwrap();
    let seeds: serde_json::Value = serde_json::from_str(&seeds).unwrap();
    let point = |of: &serde_json::Value| serde_json::from_value::<DVec3>(of.clone()).unwrap();
    let targets = seeds["targets"].as_array().unwrap().iter().map(point);
    let ends = endpoints(point(&seeds["source"]), targets.collect());
    find(group, name, mesh, &ends);
}

/// A tree of so many nodes: branches of 50 in gentle curves, two at the end of each.
fn tree(nodes: usize) -> Tree {
    let mut tree = Tree {
        letters: vec!["centerline".to_owned()],
        ..Tree::with_capacity(nodes)
    };
    let mut add = |parent, position, radius, order| {
        tree.push(Node {
            parent,
            position,
            radius,
            letter: 0,
            order,
            birth: 0,
        })
    };
    let root = add(NO_PARENT, Vec3::ZERO, 1.0, 0);
    let mut open = std::collections::VecDeque::from([(root, Vec3::ZERO, Vec3::Y, 0_u16)]);
    let mut count = 1;
    while let Some((mut parent, mut place, mut direction, order)) = open.pop_front() {
        let radius = 0.8_f32.powi(i32::from(order));
        let turn = Quat::from_axis_angle(direction.any_orthonormal_vector(), 0.01);
        for _ in 0..50 {
            if count == nodes {
                return tree;
            }
            direction = turn * direction;
            place += 0.25 * radius * direction;
            parent = add(parent, place, radius, order);
            count += 1;
        }
        let across = Quat::from_axis_angle(direction, 2.4 * f32::from(order))
            * direction.any_orthonormal_vector();
        for angle in [-0.5, 0.5] {
            let direction = Quat::from_axis_angle(across, angle) * direction;
            open.push_back((parent, place, direction, order + 1));
        }
    }
    tree
}

fn benches_of_measures(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("measure");
    group
        .sample_size(10)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_secs(1));
    for (name, nodes) in [("10k_nodes", 10_000), ("100k_nodes", 100_000)] {
        let tree = tree(nodes);
        group
            .throughput(Throughput::Elements(nodes as u64))
            .bench_function(name, |b| b.iter(|| Measures::new(&tree)));
    }
    group.finish();
}

criterion_group!(benches, benches_of_vessels, benches_of_measures);
criterion_main!(benches);
