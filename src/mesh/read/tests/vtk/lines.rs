//! Centerlines in VTP files: as VMTK and VTK write them, cut and merged, in all encodings, damaged; and what VMTK makes of them, by its
//! own filters, beside what Ramus does (`benches/peers/branches.py` wrote the files).

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;
use proptest::prelude::*;
use serde_json::Value;

use super::*;
use crate::tree::export::Vtp;
use crate::tree::measure::Measures;
use crate::tree::measure::vmtk::Split;
use crate::tree::{NO_PARENT, Node, Tree};

fn file(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/vmtk");
    std::fs::read(folder.join(name)).unwrap()
}

/// A file's tree, its positions as the file has them.
fn tree(name: &str) -> Tree {
    let model = read(&file(name)).unwrap();
    let mut tree = model.skeleton.unwrap();
    for position in tree.position.iter_mut() {
        *position += model.mesh.origin.as_vec3();
    }
    tree
}

#[test]
fn lines_are_one_tree_however_they_are_written() {
    let plain = tree("ascii.vtp");
    // Two lines of 21 points that have those up to the last before the fork in common.
    assert_eq!((plain.root_count(), plain.tips().len()), (1, 2));
    assert_eq!(plain.len(), 42 - 10);
    for name in [
        "inline.vtp",
        "inline-zlib.vtp",
        "raw.vtp",
        "base64-zlib.vtp",
        "big.vtp",
        "lz4.vtp",
        "single.vtp",
    ] {
        let other = tree(name);
        assert_eq!(other.parent, plain.parent, "{name}");
        for (a, b) in other.position.iter().zip(&plain.position) {
            assert!(a.distance(*b) < 1e-4, "{name}: {a} {b}");
        }
        for (a, b) in other.radius.iter().zip(&plain.radius) {
            assert!((a - b).abs() < 1e-5, "{name}: {a} {b}");
        }
    }
}

#[test]
fn tracts_and_merged_branches_hang_together_again() {
    // Merged ones have the fork where the bifurcation's origin is, as lines in small steps have it.
    for (name, of, within) in [
        ("split.vtp", "ascii.vtp", 0.5),
        ("merged.vtp", "y60.vtp", 2.0),
    ] {
        let [other, whole] = [name, of].map(tree);
        assert_eq!((other.root_count(), other.tips().len()), (1, 2), "{name}");
        let off = (other.total_length() - whole.total_length()).abs();
        assert!(off < within, "{name}: {off}");
    }
}

#[test]
fn what_is_written_is_read_back() {
    let mut tree = Tree {
        letters: vec!["centerline".to_owned()],
        ..Tree::default()
    };
    let mut push = |parent: u32, x: f32, y: f32| {
        tree.push(Node {
            parent,
            position: Vec3::new(x, y, 0.5),
            radius: 1.0 + 0.1 * x,
            letter: 0,
            order: 0,
            birth: 0,
        })
    };
    let root = push(NO_PARENT, 0.0, 0.0);
    let fork = push(root, 5.0, 0.0);
    let side = push(fork, 8.0, 4.0);
    push(fork, 9.0, -3.0);
    push(side, 9.0, 9.0);
    push(side, 15.0, 4.0);
    let file = Vtp::new(&tree, DVec3::new(1000.0, 0.0, 0.0)).unwrap();
    let mut bytes = Vec::new();
    file.write(&mut bytes).unwrap();
    let back = read(&bytes).unwrap();
    let skeleton = back.skeleton.unwrap();
    assert_eq!(skeleton.tips().len(), 3);
    assert_eq!(skeleton.len(), tree.len());
    assert!((skeleton.total_length() - tree.total_length()).abs() < 1e-3);
}

#[test]
fn lines_that_are_none_are_told() {
    let good = String::from_utf8(file("ascii.vtp")).unwrap();
    let swapped = |from: &str, to: &str| {
        assert!(good.contains(from), "{from}");
        good.replace(from, to).into_bytes()
    };
    for (bytes, told) in [
        (
            swapped(
                "Name=\"MaximumInscribedSphereRadius\"",
                "Name=\"Thickness\"",
            ),
            "has 2 lines and no triangle, as centerlines and skeletons have, but no radii",
        ),
        (
            swapped("Name=\"offsets\"", "Name=\"ends\""),
            "has not both their arrays, connectivity and offsets",
        ),
        (
            swapped("NumberOfLines=\"2\"", "NumberOfLines=\"3\""),
            "of the VTP file is the end, amid numbers",
        ),
        (
            swapped("          20 19 ", "          2000 19 "),
            "names the point 2000, but there are 42",
        ),
        (
            swapped(
                "          4.633651735961806",
                "          -4.633651735961806",
            ),
            "the radius -4.6336517",
        ),
    ] {
        let said = fault(&bytes);
        assert!(said.contains(told), "{said}");
        assert!(said.lines().count() == 1, "{said}");
    }
}

proptest! {
    #[test]
    fn damaged_lines_are_a_tree_or_a_fault(
        which in 0_usize..8,
        changes in prop::collection::vec((any::<usize>(), any::<u8>()), 1..8),
        cut in any::<usize>(),
    ) {
        let names = ["ascii.vtp", "inline-zlib.vtp", "raw.vtp", "base64-zlib.vtp", "big.vtp", "single.vtp", "split.vtp", "merged.vtp"];
        let mut bytes = file(names[which]);
        for (at, byte) in changes {
            let at = at % bytes.len();
            bytes[at] = byte;
        }
        if cut % 4 == 0 {
            bytes.truncate(cut % bytes.len());
        }
        match read(&bytes) {
            Ok(model) => {
                let skeleton = model.skeleton.as_ref();
                prop_assert!(skeleton.is_none_or(|tree| tree.validate().is_ok()));
            }
            Err(error) => prop_assert!(error.to_string().lines().count() == 1, "{}", error),
        }
    }
}

fn vector(value: &Value) -> DVec3 {
    let number = |place: usize| value[place].as_f64().unwrap();
    DVec3::new(number(0), number(1), number(2))
}

fn of_group<'a>(rows: &'a Value, name: &str, group: &Value) -> Vec<&'a Value> {
    let rows = rows.as_array().unwrap().iter();
    rows.filter(|row| row[name].as_f64() == group.as_f64())
        .collect()
}

fn nearest(rows: &[Value], distance: impl Fn(&Value) -> f64) -> &Value {
    let all = rows.iter();
    all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap()
}

/// Branches: as many, of the same length, bent alike.
fn compare_branches(split: &Split, vmtk: &Value) {
    let rows = vmtk["branches"].as_array().unwrap();
    assert_eq!(split.branches.len(), rows.len());
    let mut taken = BTreeSet::new();
    for branch in &split.branches {
        let off = |row: &Value| {
            let tracts = of_group(&vmtk["tracts"], "GroupIds", &row["GroupIds"]);
            let mean = |end: &str| {
                let ends = tracts.iter().map(|tract| vector(&tract[end]));
                ends.sum::<DVec3>() / tracts.len() as f64
            };
            let [first, last] = branch.ends;
            first.distance(mean("first")) + last.distance(mean("last"))
        };
        let row = nearest(rows, off);
        let radius = branch.radius.mean;
        // Its search goes in steps of a hundredth of a radius, and is at an end too early where segments are short.
        assert!(off(row) < 0.05 * radius, "{} {radius}", off(row));
        taken.insert(row["GroupIds"].to_string());
        let number = |name: &str| row[name].as_f64().unwrap();
        let longer = (branch.length - number("Length")).abs();
        assert!(longer < 0.025 * radius, "{longer} {radius}");
        let bent = (branch.curvature.unwrap() - number("Curvature")).abs() * radius;
        assert!(bent < 0.01, "{bent}");
        assert!((branch.tortuosity - number("Tortuosity")).abs() < 0.003);
    }
    assert_eq!(taken.len(), rows.len(), "each has its own");
}

/// Bifurcations: where they are, how they are turned, and where branches go.
fn compare_bifurcations(split: &Split, vmtk: &Value) {
    let frames = vmtk["frames"].as_array().unwrap();
    assert_eq!(split.bifurcations.len(), frames.len());
    for one in &split.bifurcations {
        let row = nearest(frames, |row| {
            vector(&row["origin"]).distance(one.frame.origin)
        });
        let radius = one.daughters[0].vector.length();
        assert!(vector(&row["origin"]).distance(one.frame.origin) < 0.02 * radius);
        let normal = vector(&row["Normal"]);
        let side = normal.dot(one.frame.normal).signum();
        let turned = normal.angle_between(side * one.frame.normal).to_degrees();
        // Of three daughters it is a sum of normals that lie apart.
        let within = if one.daughters.len() > 2 { 3.0 } else { 0.5 };
        assert!(turned < within, "{turned}");
        let vectors = of_group(&vmtk["vectors"], "BifurcationGroupIds", &row["GroupIds"]);
        assert_eq!(vectors.len(), 1 + one.daughters.len());
        for found in one.parent.iter().chain(&one.daughters) {
            let distance = |row: &Value| vector(&row["Vector"]).distance(found.vector);
            let rows: Vec<Value> = vectors.iter().map(|row| (*row).clone()).collect();
            let row = nearest(&rows, distance);
            assert!(distance(row) < 0.015 * found.vector.length());
            let angle = |name: &str| side * row[name].as_f64().unwrap();
            let in_plane = found.direction.in_plane - angle("InPlaneAngle");
            let out = found.direction.out_of_plane - angle("OutOfPlaneAngle");
            assert!(in_plane.abs().to_degrees() < 1.3, "{in_plane}");
            assert!(out.abs().to_degrees() < within, "{out}");
        }
    }
}

#[test]
fn vmtks_lines_are_split_as_vmtk_splits_them() {
    for (name, tips) in [("y60", 2), ("duct", 13)] {
        let found = tree(&format!("{name}.vtp"));
        let vmtk: Value = serde_json::from_slice(&file(&format!("{name}.json"))).unwrap();
        assert_eq!(found.tips().len(), tips);
        let split = Measures::new(&found).vmtk.unwrap();
        assert!(split.swallowed.is_empty());
        compare_branches(&split, &vmtk);
        compare_bifurcations(&split, &vmtk);
    }
}
