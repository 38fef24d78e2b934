//! What other programs find in the files: names, groves.

use std::collections::BTreeSet;

use glam::{Mat4, Vec3};
use gltf::Gltf;

use super::*;

pub(super) fn species(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("assets/species")
        .join(format!("{name}.ramus"))
}

pub(super) fn read(told: &Value) -> Gltf {
    // It knows no instances, which such files require.
    Gltf::from_slice_without_validation(&fs::read(path(told)).unwrap()).unwrap()
}

/// The JSON of a GLB file.
pub(super) fn json(path: &Path) -> Value {
    let bytes = fs::read(path).unwrap();
    let length = u32::from_le_bytes(*bytes[12..].first_chunk().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// Names of what is below a node.
pub(super) fn below(node: &gltf::Node<'_>) -> Vec<String> {
    node.children()
        .map(|child| child.name().unwrap().to_owned())
        .collect()
}

pub(super) fn root(file: &Gltf) -> gltf::Node<'_> {
    let mut nodes = file.default_scene().unwrap().nodes();
    let root = nodes.next().unwrap();
    assert!(nodes.next().is_none(), "one node on top");
    root
}

/// All positions of a node and of what is below it.
pub(super) fn positions(file: &Gltf, node: &gltf::Node<'_>, above: Mat4) -> Vec<Vec3> {
    let place = above * Mat4::from_cols_array_2d(&node.transform().matrix());
    let mut all = Vec::new();
    for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
        let reader = primitive.reader(|_| file.blob.as_deref());
        let own = reader.read_positions().unwrap();
        all.extend(own.map(|p| place.transform_point3(Vec3::from(p))));
    }
    for child in node.children() {
        all.extend(positions(file, &child, place));
    }
    all
}

#[test]
fn nodes_are_called_what_an_artist_looks_for() {
    let folder = folder();
    for (name, season, parts) in [
        ("oak", "summer", vec!["wood", "leaves"]),
        ("spruce", "winter", vec!["wood", "needles", "cone"]),
        ("apple", "spring", vec!["wood", "leaves", "blossom"]),
        ("apple", "winter", vec!["wood"]),
    ] {
        let options = ["--format=glb,usda", "--lod=2", "--season", season];
        let out = folder.path().join(season);
        let files = told(&mut export(&species(name), &out, &options));
        let file = read(&files[0]);
        assert_eq!(root(&file).name(), Some(name));
        assert_eq!(below(&root(&file)), parts);
        for (mesh, part) in file.meshes().zip(&parts) {
            assert_eq!(mesh.name(), Some(format!("{name}-{part}").as_str()));
            assert_eq!(mesh.primitives().count(), 1);
        }
        let usd = fs::read_to_string(path(&files[1])).unwrap();
        assert!(usd.contains(&format!("\ndef Xform \"{name}\" (")));
        for part in parts {
            assert!(
                usd.contains(&format!("\n    def Mesh \"{part}\" (")),
                "{part}"
            );
        }
    }
}

#[test]
fn a_grove_is_one_file_whose_crowns_stand_apart() {
    let folder = folder();
    let options = ["--grove", "--count=5", "--seed=3", "--lod=2"];
    let formats = "--format=glb,ply,obj,usda";
    let of = |out: &str| {
        let out = folder.path().join(out);
        told(&mut export(
            &species("birch"),
            &out,
            &[&options[..], &[formats]].concat(),
        ))
    };
    let files = of("first");
    assert_eq!(files.len(), 4);
    let triangles = count(&files[0], "triangles");
    for (file, again) in files.iter().zip(&of("second")) {
        assert_eq!(
            (count(file, "trees"), count(file, "triangles")),
            (5, triangles)
        );
        assert!(fs::read(path(file)).unwrap() == fs::read(path(again)).unwrap());
    }
    for file in &files[..3] {
        assert_eq!(inspected(&path(file)), triangles);
    }
    assert!(path(&files[0]).ends_with("birch-grove.glb"));

    let file = read(&files[0]);
    let (materials, images) = (file.materials().count(), file.images().count());
    assert_eq!((materials, images), (2, 3), "shared by all trees");
    let root = root(&file);
    assert_eq!(root.name(), Some("birch-grove"));
    assert_eq!(
        below(&root),
        ["tree-1", "tree-2", "tree-3", "tree-4", "tree-5"]
    );
    let crowns: Vec<(Vec3, f32)> = root
        .children()
        .map(|tree| {
            assert_eq!(below(&tree), ["wood", "leaves"]);
            let (translation, ..) = tree.transform().decomposed();
            let foot = Vec3::from(translation);
            let level = |p: Vec3| (p - foot).with_y(0.0).length();
            let all = positions(&file, &tree, Mat4::IDENTITY);
            let low = all.iter().map(|p| p.y).fold(f32::MAX, f32::min);
            assert!((-0.2..0.05).contains(&low), "on the ground: {low}");
            (foot, all.into_iter().map(level).fold(0.0, f32::max))
        })
        .collect();
    for (at, (foot, reach)) in crowns.iter().enumerate() {
        for (other, far) in &crowns[..at] {
            assert!(foot.distance(*other) >= reach + far);
        }
    }
    // They are individuals, those of their seeds alone.
    let nodes = json(&path(&files[0]))["nodes"].clone();
    let nodes = nodes.as_array().unwrap();
    let trees = nodes
        .iter()
        .filter(|node| node.get("translation").is_some());
    let segments: BTreeSet<u64> = trees
        .map(|tree| count(&tree["extras"], "segments"))
        .collect();
    assert!(segments.len() > 2, "{segments:?}");
    let alone = ["--format=ply", "--seed=3", "--count=5", "--lod=2"];
    let alone = told(&mut export(&species("birch"), folder.path(), &alone));
    let sum: u64 = alone.iter().map(|one| count(one, "triangles")).sum();
    assert_eq!(sum, triangles);

    let obj = fs::read_to_string(path(&files[2])).unwrap();
    let objects: Vec<&str> = obj.lines().filter(|line| line.starts_with("o ")).collect();
    assert_eq!(
        objects,
        ["o tree-1", "o tree-2", "o tree-3", "o tree-4", "o tree-5"]
    );
    let usd = fs::read_to_string(path(&files[3])).unwrap();
    for part in [
        "    def Xform \"tree_5\" (",
        "xformOp:translate",
        "        def Mesh \"leaves\" (",
    ] {
        assert!(usd.contains(part), "{part}");
    }
    assert_eq!(usd.matches("def Material ").count(), 2);
}

#[test]
fn a_grove_that_cannot_be_is_refused_in_a_sentence() {
    let folder = folder();
    for (options, part) in [
        (
            ["--format=glb,swc", "--count=2"],
            "a swc file holds one tree: leave swc out, or --grove",
        ),
        (["--format=lsys", "--count=2"], "a lsys file holds one tree"),
        (
            ["--format=glb", "--count=1001"],
            "1001 trees are too many for one file",
        ),
    ] {
        let mut command = export(Path::new(HONDA), folder.path(), &options);
        let done = command.arg("--grove").output().unwrap();
        let said = text(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{said}");
        assert!(said.contains(part), "{said}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    let dry = ["--format=glb", "--grove", "--count=3", "--dry-run"];
    let printed = succeed(&mut export(Path::new(HONDA), folder.path(), &dry));
    let lines: Vec<&str> = printed.lines().collect();
    assert!(
        lines[0].contains("honda-grove.glb: 3 trees, 3069 segments, 73680 triangles"),
        "{printed}"
    );
}
