//! Models with a known truth: how far lines are off, and how far VMTK's are on the same meshes.

use std::collections::BTreeMap;

use super::*;
use crate::mesh::endpoints::propose;
use crate::mesh::truth::{Seeds, Skeleton, model, model_of, seeds, skeleton};
use crate::tree::measure::{Junction, Measures};

/// What VMTK reaches, and what is asked for.
struct Bar {
    mesh: &'static str,
    truth: &'static str,
    /// VMTK's mean distance from the axis, in radii.
    vmtk_mean: f64,
    /// How far half of the points may be off at most, in radii.
    median: f64,
    /// How far half of the radii may be off at most, as a part.
    radius: f64,
    /// How many degrees angles may be off in the mean.
    angle: f64,
    /// Junctions by their number of daughters.
    junctions: &'static [(usize, usize)],
}

const BARS: &[Bar] = &[
    bar("a_tapered_tube", "a_tapered_tube", 0.0049, 0.0012, &[]),
    bar("b_helix", "b_helix", 0.0015, 0.0012, &[]),
    bar("c_y60", "c_y60", 0.0019, 0.0012, &[(2, 1)]),
    bar("d_duct13", "d_duct13", 0.0097, 0.0012, &[(2, 10), (3, 1)]),
    bar(
        "e_artery40_50k",
        "e_artery40",
        0.0131,
        0.0012,
        &[(2, 25), (3, 7)],
    ),
    Bar {
        // Its vertices are outside of what it stands for by 0.009 radii, its triangles' middles inside by 0.015: `coarse_walls_are_off` measures that.
        radius: 0.0075,
        ..bar(
            "e_artery40_10k",
            "e_artery40",
            0.0208,
            0.0069,
            &[(2, 25), (3, 7)],
        )
    },
    bar(
        "lungnoodle_airway60_80k",
        "lungnoodle_airway60",
        0.0060,
        0.0012,
        &[(2, 59)],
    ),
];

const fn bar(
    mesh: &'static str,
    truth: &'static str,
    vmtk_mean: f64,
    median: f64,
    junctions: &'static [(usize, usize)],
) -> Bar {
    Bar {
        mesh,
        truth,
        vmtk_mean,
        median,
        radius: 0.003,
        angle: 1.5,
        junctions,
    }
}

/// Distances from the axis in radii, and how far radii are off, at points along each way.
fn errors(found: &Centerline, truth: &Skeleton, step: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut distances, mut radii) = (Vec::new(), Vec::new());
    for end in found.ends.iter().flatten() {
        let mut way = vec![*end as usize];
        while let Some(parent) = way
            .last()
            .map(|node| found.tree.parent[*node])
            .filter(|parent| *parent != NO_PARENT)
        {
            way.push(parent as usize);
        }
        let (mut done, mut next) = (0.0, 0.0);
        for pair in way.windows(2) {
            let [from, to] =
                [pair[0], pair[1]].map(|node| found.tree.position[node].as_dvec3() + found.origin);
            let [thick, thin] = [pair[0], pair[1]].map(|node| f64::from(found.tree.radius[node]));
            let length = from.distance(to);
            while next <= done + length {
                let part = (next - done) / length.max(1e-300);
                let (distance, radius) = truth.nearest(from.lerp(to, part));
                distances.push(distance / radius);
                radii.push(((thick + part * (thin - thick)) / radius - 1.0).abs());
                next += step;
            }
            done += length;
        }
    }
    (distances, radii)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The nodes from an end to the root.
fn way(tree: &Tree, end: u32) -> Vec<u32> {
    let mut way = vec![end];
    while let Some(parent) = way
        .last()
        .map(|node| tree.parent[*node as usize])
        .filter(|parent| *parent != NO_PARENT)
    {
        way.push(parent);
    }
    way
}

fn place(tree: &Tree, node: u32) -> DVec3 {
    tree.position[node as usize].as_dvec3()
}

fn length(tree: &Tree, end: u32) -> f64 {
    let way = way(tree, end);
    way.windows(2)
        .map(|pair| place(tree, pair[0]).distance(place(tree, pair[1])))
        .sum()
}

/// By how much ways are longer or shorter than the true ones, each with what is left to where those begin and end.
fn off_in_length(found: &Centerline, truth: &Tree, seeds: &Seeds) -> Vec<f64> {
    let ends = found.ends.iter().flatten().zip(&seeds.targets);
    ends.map(|(end, target)| {
        let to = |node: &u32| place(truth, *node).distance_squared(*target);
        let tips = truth.tips();
        let tip = tips.iter().min_by(|a, b| to(a).total_cmp(&to(b))).unwrap();
        let at = |node: u32| place(&found.tree, node) + found.origin;
        let [first, last] = [at(*way(&found.tree, *end).last().unwrap()), at(*end)];
        let left = last.distance(place(truth, *tip)) + first.distance(place(truth, 0));
        (length(&found.tree, *end) + left) / length(truth, *tip) - 1.0
    })
    .collect()
}

/// By how many degrees angles between daughters are off, each pair with the true one whose daughters point the same ways.
fn off_in_angle(found: &Centerline, truth: &Tree) -> Vec<f64> {
    let (ours, theirs) = (Measures::new(&found.tree), Measures::new(truth));
    let mut off = Vec::new();
    for junction in &ours.junctions {
        let here = place(&found.tree, junction.node) + found.origin;
        let to = |other: &&Junction| place(truth, other.node).distance(here);
        let other = theirs
            .junctions
            .iter()
            .min_by(|a, b| to(a).total_cmp(&to(b)));
        let others = &other.unwrap().vectors;
        let same = |vector: &DVec3| {
            let along = |other: &&DVec3| other.dot(*vector);
            *others
                .iter()
                .max_by(|a, b| along(a).total_cmp(&along(b)))
                .unwrap()
        };
        for (number, one) in junction.vectors.iter().enumerate() {
            for other in &junction.vectors[number + 1..] {
                let true_angle = same(one).angle_between(same(other));
                off.push((one.angle_between(*other) - true_angle).to_degrees());
            }
        }
    }
    off
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn ends(seeds: &Seeds) -> Vec<Endpoint> {
    let targets = seeds
        .targets
        .iter()
        .map(|target| end(Kind::Target, *target));
    std::iter::once(end(Kind::Source, seeds.source))
        .chain(targets)
        .collect()
}

#[test]
fn lines_are_nearer_to_the_axis_than_vmtks_and_junctions_are_exact() {
    for bar in BARS {
        let Some(mesh) = model(&format!("{}.ply", bar.mesh)) else {
            return;
        };
        let (truth, seeds) = (skeleton(bar.truth), seeds(bar.truth));
        let never = AtomicBool::new(false);
        let found = centerline(
            &surface(mesh),
            &ends(&seeds),
            &Params::default(),
            &never,
            &mut |_, _| {},
        )
        .unwrap();
        assert!(
            found.unreached.is_empty() && found.ends.iter().all(Option::is_some),
            "{}",
            bar.mesh
        );
        let measures = Measures::new(&found.tree);
        let mut junctions: BTreeMap<usize, usize> = BTreeMap::new();
        measures
            .junctions
            .iter()
            .for_each(|one| *junctions.entry(one.degree()).or_default() += 1);
        assert_eq!(
            junctions.into_iter().collect::<Vec<_>>(),
            bar.junctions,
            "{}",
            bar.mesh
        );
        assert_eq!(measures.tips, seeds.targets.len(), "{}", bar.mesh);
        let tree = truth.tree();
        let mut lengths = off_in_length(&found, &tree, &seeds);
        lengths.iter_mut().for_each(|off| *off = off.abs());
        let angles = off_in_angle(&found, &tree);
        let turned: Vec<f64> = angles.iter().map(|off| off.abs()).collect();
        let branches = measures.table.branch_length.mean;
        let branches = branches / Measures::new(&tree).table.branch_length.mean - 1.0;
        assert!(mean(&lengths) < 0.01, "{}: {lengths:?}", bar.mesh);
        assert!(branches.abs() < 0.01, "{}: branches {branches}", bar.mesh);
        assert!(mean(&turned) < bar.angle, "{}: {angles:?}", bar.mesh);
        let (mut distances, mut radii) = errors(&found, &truth, 0.25 * truth.thinnest());
        let far = mean(&distances);
        assert!(
            far <= bar.vmtk_mean,
            "{}: mean distance {far}, VMTK {}",
            bar.mesh,
            bar.vmtk_mean
        );
        let distance = median(&mut distances);
        assert!(
            distance <= bar.median,
            "{}: median distance {distance}",
            bar.mesh
        );
        let radius = median(&mut radii);
        assert!(radius <= bar.radius, "{}: median radius {radius}", bar.mesh);
        eprintln!(
            "{}: distance mean {far:.5} median {distance:.5}, radius {radius:.5}, lengths {:.5}, branches {branches:.5}, angles {:.2} degrees, {:.2} in the mean",
            bar.mesh,
            mean(&lengths),
            mean(&turned),
            mean(&angles),
        );
    }
}

/// Why radii on the coarse artery are not within 0.003: its own mesh is not, away from forks and ends, and on both sides.
#[test]
fn coarse_walls_are_off() {
    let Some(mesh) = model("e_artery40_10k.ply") else {
        return;
    };
    let truth = skeleton("e_artery40");
    let tree = truth.tree();
    let mut children = vec![0; tree.len()];
    for parent in tree.parent.iter().filter(|parent| **parent != NO_PARENT) {
        children[*parent as usize] += 1;
    }
    let is_of_tube = |point: &DVec3| {
        (0_u32..).zip(&children).all(|(node, children)| {
            let near = 3.5 * f64::from(tree.radius[node as usize]);
            *children == 1 || place(&tree, node).distance(*point) > near
        })
    };
    let off = |points: Vec<DVec3>| {
        let tube = points
            .into_iter()
            .filter(is_of_tube)
            .map(|point| truth.nearest(point));
        let mut offs: Vec<f64> = tube
            .map(|(distance, radius)| distance / radius - 1.0)
            .collect();
        median(&mut offs)
    };
    let corner = |vertex: u32| mesh.positions[vertex as usize].as_dvec3() + mesh.origin;
    let vertices = (0_u32..).take(mesh.positions.len());
    let vertices = off(vertices.map(corner).collect());
    let middle = |face: &[u32; 3]| face.map(corner).iter().sum::<DVec3>() / 3.0;
    let middles = off(mesh.triangles.iter().map(middle).collect());
    eprintln!("e_artery40_10k: vertices {vertices:.4}, middles of triangles {middles:.4}");
    assert!(vertices > 0.006 && middles < -0.006, "{vertices} {middles}");
}

#[test]
fn lengths_and_bends_are_true() {
    for (name, length, bends) in [
        ("a_tapered_tube", 100.0, None),
        ("b_helix", 210.744, Some((0.04, 0.02))),
    ] {
        let Some(mesh) = model(&format!("{name}.ply")) else {
            return;
        };
        let never = AtomicBool::new(false);
        let found = centerline(
            &surface(mesh),
            &ends(&seeds(name)),
            &Params::default(),
            &never,
            &mut |_, _| {},
        )
        .unwrap();
        let measures = Measures::new(&found.tree);
        let branch = &measures.branches[0];
        assert!(
            (branch.length / length - 1.0).abs() < 0.002,
            "{name}: {}",
            branch.length
        );
        if let Some((curvature, torsion)) = bends {
            assert!(
                (branch.curvature / curvature - 1.0).abs() < 0.03,
                "{name}: {}",
                branch.curvature
            );
            assert!(
                (branch.torsion.unwrap() / torsion - 1.0).abs() < 0.03,
                "{name}: {:?}",
                branch.torsion
            );
        }
    }
}

#[test]
fn the_same_lines_come_of_proposed_ends_and_of_a_turned_and_scaled_model() {
    let Some(mesh) = model("c_y60.ply") else {
        return;
    };
    let never = AtomicBool::new(false);
    let lines = |mesh: Mesh| {
        let surface = surface(mesh);
        let ends: Vec<Endpoint> = propose(&surface, &never)
            .unwrap()
            .into_iter()
            .map(|one| one.endpoint)
            .collect();
        let found =
            centerline(&surface, &ends, &Params::default(), &never, &mut |_, _| {}).unwrap();
        Measures::new(&found.tree).table
    };
    let turn = glam::Quat::from_rotation_x(0.7) * glam::Quat::from_rotation_z(0.4);
    let mut other = mesh.clone();
    other
        .positions
        .iter_mut()
        .for_each(|one| *one = 0.001 * (turn * *one));
    other.positions.reverse();
    let last = u32::try_from(other.positions.len() - 1).unwrap();
    other
        .triangles
        .iter_mut()
        .flatten()
        .for_each(|vertex| *vertex = last - *vertex);
    let (one, other) = (lines(mesh), lines(other));
    for (one, other) in [
        (one.branch_length.mean, 1000.0 * other.branch_length.mean),
        (one.point_radius.mean, 1000.0 * other.point_radius.mean),
        (one.bifurcation_angle.mean, other.bifurcation_angle.mean),
    ] {
        assert!((one / other - 1.0).abs() < 0.01, "{one} {other}");
    }
}

fn between_proposed_ends(mesh: Mesh) -> Centerline {
    let never = AtomicBool::new(false);
    let surface = surface(mesh);
    let proposals = propose(&surface, &never).unwrap().into_iter();
    let ends: Vec<Endpoint> = proposals.map(|one| one.endpoint).collect();
    let params = Params {
        proposed: true,
        ..Params::default()
    };
    centerline(&surface, &ends, &params, &never, &mut |_, _| {}).unwrap()
}

#[test]
fn ends_that_are_found_lead_to_every_tip_and_no_other() {
    for bar in BARS {
        let Some(mesh) = model(&format!("{}.ply", bar.mesh)) else {
            return;
        };
        let found = between_proposed_ends(mesh);
        let measures = Measures::new(&found.tree);
        let branches: usize = bar.junctions.iter().map(|(_, count)| count).sum();
        assert_eq!(
            measures.tips,
            seeds(bar.truth).targets.len(),
            "{}",
            bar.mesh
        );
        assert_eq!(measures.junctions.len(), branches, "{}", bar.mesh);
        assert!(found.unreached.is_empty(), "{}", bar.mesh);
    }
}

#[test]
fn tubes_of_a_games_tree_and_a_neuron_of_scraps_are_found_whole() {
    // Tubes, tips reached, and junctions: one where each tube but the first begins; where two begin in one place they are one.
    for (name, tips, junctions) in [
        ("eztree_ash_small.ply", 44, 43..=43),
        ("eztree_oak_medium.ply", 138, 120..=139),
        ("skeletor_722817260.obj", 290, 240..=330),
        ("vmtk_aorta-surface-two-segments.vtp", 2, 1..=1),
    ] {
        let Some(mesh) = model_of("real", name) else {
            return;
        };
        let found = between_proposed_ends(mesh);
        let measures = Measures::new(&found.tree);
        assert!(found.unreached.is_empty(), "{name}: {:?}", found.unreached);
        assert!(measures.tips >= tips, "{name}: {}", measures.tips);
        let count = measures.junctions.len();
        assert!(junctions.contains(&count), "{name}: {count} junctions");
    }
}
