//! A project with planted trees: written where they stand, each individual once where a file can say so, and told of where they are left out.

use glam::{Mat4, Quat, Vec2};
use ramus::world::document::{Document, Edit};
use ramus::world::grove::Plant;
use ramus::world::project;
use ramus::world::species::SPECIES;

use super::home::{below, json, positions, read, root};
use super::*;

fn species(name: &str) -> &'static ramus::world::species::Species {
    SPECIES.iter().find(|one| one.name == name).unwrap()
}

fn plant(x: f32, individual: u8, yaw_deg: f64, size: f32) -> Plant {
    Plant {
        at: Vec2::new(x, -9.0),
        yaw_deg,
        size,
        individual,
        kind: None,
    }
}

fn planted(document: &Document, trees: Vec<Plant>) -> Document {
    document.after(&Edit::Plant { trees }).unwrap()
}

/// Three planted cactuses, two of them the same individual, and a fern on the platform with one beside it.
fn wood(folder: &Path) -> PathBuf {
    let cactus = species("cactus").document();
    let trees = vec![
        plant(3.0, 1, 40.0, 1.25),
        plant(6.0, 4, 0.0, 0.8),
        plant(9.0, 1, 200.0, 1.0),
    ];
    let wood = planted(&cactus, trees);
    let wood = wood.after(&species("fern").edit()).unwrap();
    let wood = planted(&wood, vec![plant(-4.0, 2, 90.0, 1.5)]);
    let path = folder.join("wood.ramus");
    fs::write(&path, project::to_bytes(&wood)).unwrap();
    path
}

#[test]
fn planted_trees_stand_in_a_file_as_on_the_stage() {
    let folder = folder();
    let wood = wood(folder.path());
    let options = ["--grove", "--format=glb,usda,ply,obj", "--lod=2"];
    let files = told(&mut export(&wood, folder.path(), &options));
    assert_eq!(files.len(), 4);
    let triangles = count(&files[0], "triangles");
    for file in &files {
        assert_eq!(
            (count(file, "trees"), count(file, "triangles")),
            (5, triangles)
        );
        assert_eq!(file["bytes"], fs::metadata(path(file)).unwrap().len());
    }
    for file in [&files[0], &files[2], &files[3]] {
        assert_eq!(inspected(&path(file)), triangles, "{file}");
    }
    assert!(path(&files[0]).ends_with("wood-grove.glb"));

    // The tree on the platform at zero; the others from there, turned and sized.
    let file = read(&files[0]);
    let root = root(&file);
    assert_eq!(
        below(&root),
        ["tree-1", "tree-2", "tree-4", "tree-3", "tree-5"]
    );
    let tree = |name: &str| {
        root.children()
            .find(|node| node.name() == Some(name))
            .unwrap()
    };
    let (at, turn, size) = tree("tree-2").transform().decomposed();
    assert_eq!((at, size), ([3.0, 0.0, -3.0], [1.25; 3]));
    let expected = Quat::from_rotation_y(40.0_f32.to_radians());
    assert!(Quat::from_array(turn).abs_diff_eq(expected, 1e-5));
    assert_eq!(tree("tree-1").transform().decomposed().0, [0.0; 3]);
    // One mesh for both cactuses of one individual, another one for the other.
    let mesh = |name: &str| {
        tree(name)
            .children()
            .next()
            .unwrap()
            .mesh()
            .unwrap()
            .index()
    };
    assert_eq!(mesh("tree-2"), mesh("tree-4"));
    assert_ne!(mesh("tree-2"), mesh("tree-3"));
    // A file that knows no places has the same vertices where they are to be.
    let of_glb = positions(&file, &root, Mat4::IDENTITY);
    let ply = fs::read_to_string(path(&files[3])).unwrap();
    let of_obj: Vec<Vec3> = ply
        .lines()
        .filter_map(|line| line.strip_prefix("v "))
        .map(|line| {
            let mut numbers = line.split(' ').map(|number| number.parse().unwrap());
            Vec3::from_array([(); 3].map(|()| numbers.next().unwrap()))
        })
        .collect();
    assert_eq!(of_glb.len(), of_obj.len());
    let apart = of_glb.iter().zip(&of_obj).map(|(a, b)| a.distance(*b));
    assert!(apart.fold(0.0, f32::max) < 1e-4);

    let usd = fs::read_to_string(path(&files[1])).unwrap();
    assert_eq!(usd.matches("    def Xform \"tree_").count(), 5);
    let again = "    def Xform \"tree_4\" (\n        instanceable = true\n        kind = \"component\"\n        prepend references = </wood_grove/tree_2>\n    )";
    assert!(usd.contains(again));
    assert!(
        usd.contains(
            "float xformOp:rotateY = 40\n        float3 xformOp:scale = (1.25, 1.25, 1.25)"
        )
    );
    // Where it is once, a file is smaller than where it is twice.
    assert!(json(&path(&files[0]))["meshes"].as_array().unwrap().len() < 12);
}

#[test]
fn what_is_left_out_or_cannot_be_is_said_in_a_sentence() {
    let folder = folder();
    let wood = wood(folder.path());
    for options in [
        &["--format=glb"][..],
        &["--format=glb", "--grove", "--count=2"],
    ] {
        let done = export(&wood, folder.path(), &[options, &["--lod=4"]].concat())
            .output()
            .unwrap();
        assert!(done.status.success());
        let told = String::from_utf8(done.stderr).unwrap();
        let sentence = "the 4 planted trees of ";
        assert!(
            told.contains(sentence) && told.contains("--grove, without --count"),
            "{told}"
        );
    }
    for (option, sentence) in [
        ("--angles=10", "planted trees stay what was planted"),
        ("--growth=morphs", "planted trees do not grow in a file"),
    ] {
        let options = ["--format=glb", "--grove", option];
        let done = export(&wood, folder.path(), &options).output().unwrap();
        let told = String::from_utf8(done.stderr).unwrap();
        assert!(!done.status.success() && told.contains(sentence), "{told}");
    }
    // What was left before anything grew is not forgotten without a word.
    let mut document = project::from_bytes(&fs::read(&wood).unwrap()).unwrap();
    let kinds = &mut std::sync::Arc::make_mut(&mut document.grove).kinds;
    kinds[0].step = 0;
    fs::write(&wood, project::to_bytes(&document)).unwrap();
    let done = export(
        &wood,
        folder.path(),
        &["--format=glb", "--grove", "--lod=4"],
    )
    .output()
    .unwrap();
    let told = String::from_utf8(done.stderr).unwrap();
    let sentence = "left at step 0, where nothing has grown yet, can not be written";
    assert!(done.status.success() && told.contains(sentence), "{told}");
    // A project without planted trees is told nothing.
    let fern = folder.path().join("fern.ramus");
    fs::write(&fern, project::to_bytes(&species("fern").document())).unwrap();
    let done = export(&fern, folder.path(), &["--format=swc"])
        .output()
        .unwrap();
    let told = String::from_utf8(done.stderr).unwrap();
    assert!(!told.contains("planted"), "{told}");
}

#[test]
fn a_session_takes_the_planted_trees_home() {
    use ramus::app::take_home;
    let folder = folder();
    let wood = project::from_bytes(&fs::read(wood(folder.path())).unwrap()).unwrap();
    let glb = folder.path().join("home.glb");
    take_home::export(&wood, &glb).unwrap();
    let file = json(&glb);
    let names = file["nodes"].as_array().unwrap().iter();
    let trees = names.filter(|node| node["name"].as_str().unwrap().starts_with("tree-"));
    assert_eq!(trees.count(), 5);
    let swc = folder.path().join("home.swc");
    take_home::export(&wood, &swc).unwrap();
    assert!(
        !take_home::holds_planted(&wood, &swc),
        "a skeleton is of one tree"
    );
}
