//! Instances, wind, growth and smaller pictures, as readers of others find them.

use glam::Vec3;
use gltf::Semantic;

use super::home::{below, json, read, root, species};
use super::*;

/// What `ramus inspect` says of a file.
fn inspection(path: &Path) -> Value {
    let told = succeed(ramus().arg("inspect").arg(path).arg("--json"));
    serde_json::from_str(&told).unwrap()
}

#[test]
fn leaves_as_instances_are_the_same_leaves_in_fewer_bytes() {
    let folder = folder();
    for (name, times) in [("oak", 3), ("apple", 2)] {
        let of = |out: &str, more: &[&str]| {
            let options = ["--format=glb,usda", "--season=autumn"];
            let out = folder.path().join(out);
            told(&mut export(
                &species(name),
                &out,
                &[&options, more].concat(),
            ))
        };
        let [plain, instanced] = [of("plain", &[]), of("instances", &["--instances"])];
        let triangles = count(&plain[0], "triangles");
        assert_eq!(count(&instanced[0], "triangles"), triangles);
        assert!(count(&instanced[0], "instances") > 5000);
        for file in 0..2 {
            let [large, small] = [&plain, &instanced].map(|files| count(&files[file], "bytes"));
            assert!(small * times < large, "{name}: {small} of {large}");
        }
        // Our own reader sets each leaf where it was.
        let [one, other] = [&plain[0], &instanced[0]].map(|file| inspection(&path(file)));
        assert_eq!(count(&other, "triangles"), triangles);
        for corner in ["min", "max"] {
            for axis in 0..3 {
                let [a, b] = [&one, &other].map(|of| of[corner][axis].as_f64().unwrap());
                assert!((a - b).abs() < 2e-4, "{name} {corner} {a} {b}");
            }
        }
        let [a, b] = [&one, &other].map(|of| of["area"].as_f64().unwrap());
        assert!((a - b).abs() < 1e-3 * a, "{name}: area {a} {b}");

        let file = json(&path(&instanced[0]));
        assert_eq!(file["extensionsRequired"][0], "EXT_mesh_gpu_instancing");
        let file = read(&instanced[0]);
        let leaves = root(&file)
            .children()
            .find(|node| node.name() == Some("leaves"))
            .unwrap();
        let looks = below(&leaves);
        assert!(leaves.mesh().is_none() && looks.len() > 4 && looks[0] == "leaves-look-1");
        let usd = fs::read_to_string(path(&instanced[1])).unwrap();
        assert!(usd.contains("    def PointInstancer \"leaves\"\n"));
        let length = |name: &str| -> usize { lists(&usd, name).iter().map(Vec::len).sum() };
        let instances = usize::try_from(count(&instanced[1], "instances")).unwrap();
        assert_eq!(length("int[] protoIndices"), instances);
        assert_eq!(length("point3f[] positions"), 3 * instances);
        assert_eq!(length("quath[] orientations"), 4 * instances);
    }
}

#[test]
fn trees_of_a_grove_share_the_meshes_of_their_leaves() {
    let folder = folder();
    let options = ["--format=glb", "--instances", "--grove", "--count=3"];
    let files = told(&mut export(&species("birch"), folder.path(), &options));
    assert_eq!(inspected(&path(&files[0])), count(&files[0], "triangles"));
    let alone = ["--format=glb", "--instances", "--seed=1"];
    let alone = told(&mut export(&species("birch"), folder.path(), &alone));
    let meshes = |told: &Value| read(told).meshes().count();
    assert_eq!(meshes(&files[0]), meshes(&alone[0]) + 2, "two more of wood");
}

#[test]
fn wind_moves_tips_and_leaves_and_not_the_foot() {
    let folder = folder();
    let options = ["--format=glb", "--wind", "--lod=1"];
    let files = told(&mut export(&species("maple"), folder.path(), &options));
    let file = read(&files[0]);
    let mut most = [0.0_f32; 4];
    for mesh in file.meshes() {
        let primitive = mesh.primitives().next().unwrap();
        let reader = primitive.reader(|_| file.blob.as_deref());
        let positions: Vec<_> = reader.read_positions().unwrap().map(Vec3::from).collect();
        let set = |number| reader.read_tex_coords(number).unwrap().into_f32();
        assert!(set(0).all(|[u, v]| u.is_finite() && v.is_finite()));
        let wind: Vec<[f32; 4]> = set(1)
            .zip(set(2))
            .map(|([a, b], [c, d])| [a, b, c, d])
            .collect();
        assert_eq!(wind.len(), positions.len());
        assert_eq!(set(0).len(), positions.len());
        let is_wood = mesh.name() == Some("maple-wood");
        for (place, wind) in positions.iter().zip(&wind) {
            assert!(wind.iter().all(|part| (0.0..=1.0).contains(part)));
            let [sway, _, branch, flutter] = *wind;
            assert!(!is_wood || flutter == 0.0);
            if is_wood && place.y < 0.05 {
                assert!(sway < 1e-3 && branch == 0.0, "{place} {wind:?}");
            }
            most = std::array::from_fn(|at| most[at].max(wind[at]));
        }
        // Vertices that lie in one place move as one, so that no tube tears.
        let mut known = std::collections::HashMap::new();
        for (place, wind) in positions.iter().zip(&wind).filter(|_| is_wood) {
            let one = *known
                .entry(place.to_array().map(f32::to_bits))
                .or_insert(*wind);
            let apart = (0..3)
                .map(|at| (one[at] - wind[at]).abs())
                .fold(0.0, f32::max);
            assert!(
                apart < 1e-3 || one[2] == 0.0 || wind[2] == 0.0,
                "{place}: {one:?} {wind:?}"
            );
        }
    }
    assert!(most.iter().all(|part| *part > 0.9), "{most:?}");
    // Each instance has what its leaf would have.
    let options = ["--format=glb", "--wind", "--instances"];
    let files = told(&mut export(
        &species("maple"),
        &folder.path().join("of"),
        &options,
    ));
    let file = json(&path(&files[0]));
    let nodes = file["nodes"].as_array().unwrap();
    let instances = nodes.iter().filter_map(|node| node.get("extensions"));
    for one in instances {
        let attributes = &one["EXT_mesh_gpu_instancing"]["attributes"];
        let count_of = |name: &str| {
            let accessor = attributes[name].as_u64().unwrap();
            count(
                &file["accessors"][usize::try_from(accessor).unwrap()],
                "count",
            )
        };
        assert_eq!(count_of("_WIND"), count_of("TRANSLATION"));
    }
}

#[test]
fn morph_targets_fold_the_tree_back_to_its_earlier_steps() {
    let folder = folder();
    let at = |steps: &str, more: &[&str]| {
        let options = ["--format=glb", "--steps", steps];
        let out = folder.path().join(steps);
        told(&mut export(
            Path::new(HONDA),
            &out,
            &[&options, more].concat(),
        ))
    };
    let whole = at("7", &["--growth=morphs", "--growth-steps=3"]);
    assert_eq!(count(&whole[0], "morphs"), 3);
    let file = read(&whole[0]);
    let mesh = file.meshes().next().unwrap();
    assert_eq!(
        mesh.weights(),
        Some([0.0; 3].as_slice()),
        "the whole tree at rest"
    );
    let primitive = mesh.primitives().next().unwrap();
    let reader = primitive.reader(|_| file.blob.as_deref());
    let mut positions: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
    let targets: Vec<Vec<Vec3>> = reader
        .read_morph_targets()
        .map(|(places, ..)| places.unwrap().map(Vec3::from).collect())
        .collect();
    let bounds = |points: &[Vec3]| {
        points
            .iter()
            .fold((Vec3::MAX, Vec3::MIN), |(low, high), p| {
                (low.min(*p), high.max(*p))
            })
    };
    // From the newest step back, each time the tree of a step fewer.
    for (target, steps) in targets.iter().rev().zip(["6", "5", "4"]) {
        for (place, by) in positions.iter_mut().zip(target) {
            *place += *by;
        }
        let (low, high) = bounds(&positions);
        let earlier = read(&at(steps, &[])[0]);
        let mesh = earlier.meshes().next().unwrap();
        let bounding = mesh.primitives().next().unwrap().bounding_box();
        let size = Vec3::from(bounding.max).distance(Vec3::from(bounding.min));
        let off = low
            .distance(bounding.min.into())
            .max(high.distance(bounding.max.into()));
        assert!(off < 0.01 * size, "{steps}: off by {off} of {size}");
    }
    let animation = file.animations().next().unwrap();
    let channel = animation.channels().next().unwrap();
    assert_eq!(channel.target().node().name(), Some("wood"));
    let reader = channel.reader(|_| file.blob.as_deref());
    assert_eq!(
        reader.read_inputs().unwrap().collect::<Vec<_>>(),
        [0.0, 1.0, 2.0, 3.0]
    );
    let Some(gltf::animation::util::ReadOutputs::MorphTargetWeights(weights)) =
        reader.read_outputs()
    else {
        panic!("weights")
    };
    let weights: Vec<f32> = weights.into_f32().collect();
    assert_eq!(weights, [1., 1., 1., 0., 1., 1., 0., 0., 1., 0., 0., 0.]);
    assert_eq!(
        json(&path(&whole[0]))["meshes"][0]["extras"]["targetNames"][0],
        "step-5"
    );
    // A tree has no more steps than it has; with leaves each part has its targets.
    let birch = [
        "--format=glb",
        "--lod=3",
        "--growth=morphs",
        "--growth-steps=2",
    ];
    let birch = read(&told(&mut export(&species("birch"), folder.path(), &birch))[0]);
    for mesh in birch.meshes() {
        let primitive = mesh.primitives().next().unwrap();
        assert_eq!(primitive.morph_targets().count(), 2);
        assert!(primitive.get(&Semantic::Positions).is_some());
    }
    let few = [
        "--format=glb",
        "--steps=2",
        "--growth=morphs",
        "--growth-steps=9",
    ];
    let few = told(&mut export(Path::new(HONDA), folder.path(), &few));
    assert_eq!(count(&few[0], "morphs"), 2);
}

#[test]
fn a_sequence_is_a_file_for_each_step() {
    let folder = folder();
    let options = ["--format=glb,swc", "--growth=sequence", "--steps=6"];
    let files = told(&mut export(Path::new(HONDA), folder.path(), &options));
    let names: Vec<PathBuf> = files.iter().map(path).collect();
    assert!(names[0].ends_with("honda-step-01.glb") && names[11].ends_with("honda-step-06.swc"));
    let triangles: Vec<u64> = files
        .iter()
        .step_by(2)
        .map(|one| count(one, "triangles"))
        .collect();
    assert!(
        triangles.windows(2).all(|pair| pair[0] < pair[1]),
        "{triangles:?}"
    );
    // The last is the tree, and the last ones alone are the same.
    let alone = folder.path().join("alone");
    let whole = ["--format=swc", "--steps=6"];
    let whole = told(&mut export(Path::new(HONDA), &alone, &whole));
    assert!(fs::read(path(&whole[0])).unwrap() == fs::read(&names[11]).unwrap());
    let few = [
        "--format=swc",
        "--growth=sequence",
        "--steps=6",
        "--growth-steps=2",
    ];
    let few = told(&mut export(Path::new(HONDA), &alone, &few));
    let steps: Vec<u64> = few.iter().map(|one| count(one, "step")).collect();
    assert_eq!(steps, [5, 6]);
    assert!(fs::read(path(&few[0])).unwrap() == fs::read(&names[9]).unwrap());
    let oak = ["--format=glb", "--growth=sequence", "--lod=3", "--dry-run"];
    let printed = succeed(&mut export(&species("oak"), folder.path(), &oak));
    let lines = printed
        .lines()
        .filter(|line| line.contains("oak-step-"))
        .count();
    assert!(lines > 3, "{printed}");
}

#[test]
fn a_sequence_that_draws_nothing_is_an_error_and_its_picture_tells_its_steps() {
    let folder = folder();
    let bare = write(folder.path(), "bare.lsys", "steps 3\naxiom A\nA -> A\n");
    let options = ["--format=glb", "--growth=sequence"];
    let done = export(&bare, folder.path(), &options).output().unwrap();
    let said = text(&done.stderr);
    assert_eq!(done.status.code(), Some(1), "{said}");
    assert!(said.contains("draws nothing at any step"), "{said}");
    let sheet = folder.path().join("sheet.png");
    let options = ["--growth=sequence", "--steps=3", "--dry-run"];
    let mut command = export(Path::new(HONDA), folder.path(), &options);
    let done = command.arg("--sheet").arg(sheet).output().unwrap();
    let said = text(&done.stdout) + &text(&done.stderr);
    assert!(said.contains(" and a picture of 3 steps, "), "{said}");
}

#[test]
fn what_has_no_triangle_is_no_file() {
    let folder = folder();
    let flat = write(
        folder.path(),
        "flat.lsys",
        "steps 0\naxiom { . f(1) . f(1) . }\n",
    );
    for format in ["--format=glb", "--format=usda"] {
        let done = export(&flat, folder.path(), &[format]).output().unwrap();
        let said = text(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{said}");
        assert!(said.contains("nothing to write as"), "{said}");
    }
}

#[test]
fn pictures_are_as_small_as_asked() {
    let folder = folder();
    let options = ["--format=glb", "--lod=4", "--texture=100"];
    let dry = succeed(export(&species("oak"), folder.path(), &options).arg("--dry-run"));
    assert!(dry.contains(", pictures of 64 pixels in "), "{dry}");
    let files = told(&mut export(&species("oak"), folder.path(), &options));
    assert_eq!(count(&files[0], "texture"), 64);
    let file = read(&files[0]);
    let blob = file.blob.as_deref().unwrap();
    let mut bytes = 0;
    for image in file.images() {
        let gltf::image::Source::View { view, .. } = image.source() else {
            panic!("within the file")
        };
        let png = &blob[view.offset()..][..view.length()];
        bytes += png.len() as u64;
        let picture = image::load_from_memory(png).unwrap();
        assert_eq!((picture.width(), picture.height()), (64, 64));
    }
    assert_eq!(count(&files[0], "picture_bytes"), bytes);
}

#[test]
fn what_no_file_can_hold_is_refused_in_a_sentence() {
    let folder = folder();
    for (options, part) in [
        (
            vec!["--format=ply", "--wind"],
            "--wind is for glb alone: add glb to --format",
        ),
        (
            vec!["--format=obj", "--texture=64"],
            "--texture is for glb alone",
        ),
        (
            vec!["--format=usda", "--growth=morphs"],
            "morph targets are for glb alone",
        ),
        (
            vec!["--format=obj", "--instances"],
            "--instances is for glb and usda",
        ),
        (
            vec!["--format=glb", "--instances", "--growth=morphs"],
            "instances have no vertices of their own",
        ),
        (
            vec!["--format=glb", "--growth=morphs", "--growth-steps=33"],
            "33 steps are too many",
        ),
        (
            vec!["--format=glb", "--growth=sequence", "--grove"],
            "a grove does not grow step by step",
        ),
        (
            vec!["--format=glb", "--growth=sequence", "--angles=5"],
            "set both to 0",
        ),
        (
            vec!["--format=glb", "--growth=sequence", "--steps=4294967295"],
            "too many",
        ),
    ] {
        let done = export(Path::new(HONDA), folder.path(), &options)
            .output()
            .unwrap();
        let said = text(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{said}");
        assert!(said.contains(part), "{part}: {said}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
    for options in [
        ["--texture=0", "--wind"],
        ["--growth-steps=3", "--wind"],
        ["--growth=years", "--wind"],
    ] {
        let done = export(Path::new(HONDA), folder.path(), &options)
            .arg("--format=glb")
            .output()
            .unwrap();
        assert_eq!(done.status.code(), Some(2), "{options:?}");
    }
}
