//! `ramus export`: files for other programs, in levels of detail and many individuals, read back by readers of others and by our own.

use std::path::PathBuf;

use serde_json::Value;

use super::cohort::write;
use super::*;

mod extras;
mod home;
mod planted;
mod trimesh;
mod whole;

const LILY: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/assets/grammars/lily-of-the-valley.lsys"
);

fn export(file: &Path, out: &Path, options: &[&str]) -> Command {
    let mut command = ramus();
    command.arg("export").arg(file).arg("--out").arg(out);
    command.args(options);
    command
}

/// The files that are told of.
fn told(command: &mut Command) -> Vec<Value> {
    let told: Value = serde_json::from_str(&succeed(command.arg("--json"))).unwrap();
    assert_eq!(told["format"], "ramus-export/1");
    let files = told["files"].as_array().unwrap().clone();
    let triangles: u64 = files
        .iter()
        .filter_map(|one| one["triangles"].as_u64())
        .sum();
    assert_eq!(told["triangles"], triangles);
    files
}

fn path(told: &Value) -> PathBuf {
    PathBuf::from(told["file"].as_str().unwrap())
}

fn count(told: &Value, name: &str) -> u64 {
    told[name].as_u64().unwrap()
}

/// Triangles that `ramus inspect` finds in a file.
fn inspected(path: &Path) -> u64 {
    let told = succeed(ramus().arg("inspect").arg(path).arg("--json"));
    let told: Value = serde_json::from_str(&told).unwrap();
    told["triangles"].as_u64().unwrap()
}

/// The numbers between the brackets of each list of a name in a USD text.
fn lists<'a>(text: &'a str, name: &str) -> Vec<Vec<&'a str>> {
    let head = format!("{name} = [");
    let parts = text.split(&head).skip(1);
    let inside = parts.map(|part| part.split_once(']').unwrap().0);
    inside
        .map(|list| list.split(',').map(str::trim).collect())
        .collect()
}

#[test]
fn a_grammar_is_written_in_each_format_and_read_again() {
    let folder = folder();
    for grammar in [HONDA, LILY] {
        let all = ["--format", "glb,usda,ply,obj,swc,lsys"];
        let files = told(&mut export(Path::new(grammar), folder.path(), &all));
        assert_eq!(files.len(), 6);
        let triangles = count(&files[0], "triangles");
        assert!(triangles > 5000);
        for file in &files {
            assert_eq!(file["bytes"], fs::metadata(path(file)).unwrap().len());
            assert_eq!(file.get("triangles").is_some(), file.get("bound").is_some());
        }
        for surface in [&files[0], &files[2], &files[3]] {
            assert_eq!(count(surface, "triangles"), triangles);
            assert_eq!(inspected(&path(surface)), triangles, "{surface}");
        }
        let usd = fs::read_to_string(path(&files[1])).unwrap();
        assert!(usd.starts_with("#usda 1.0\n") && usd.contains("upAxis = \"Y\""));
        let [counts, indices, points, normals] = [
            "int[] faceVertexCounts",
            "int[] faceVertexIndices",
            "point3f[] points",
            "normal3f[] normals",
        ]
        .map(|name| lists(&usd, name));
        let faces: usize = counts.iter().map(Vec::len).sum();
        assert_eq!(faces as u64, triangles);
        for mesh in 0..counts.len() {
            assert!(counts[mesh].iter().all(|corners| *corners == "3"));
            assert_eq!(indices[mesh].len(), 3 * counts[mesh].len());
            // Each vertex is three numbers.
            let vertices = points[mesh].len() / 3;
            assert_eq!(normals[mesh].len() / 3, vertices);
            let largest = indices[mesh]
                .iter()
                .map(|index| index.parse::<usize>().unwrap());
            assert_eq!(largest.max().unwrap(), vertices - 1, "none is left over");
        }
        assert_eq!(
            fs::read_to_string(path(&files[5])).unwrap(),
            fs::read_to_string(grammar).unwrap()
        );
    }
    // The skeleton and the grammar say the same tree.
    let derived = folder.path().join("derived.swc");
    succeed(ramus().args(["derive", HONDA, "--export"]).arg(&derived));
    let [own, other] =
        [&derived, &folder.path().join("honda.swc")].map(|path| fs::read(path).unwrap());
    assert!(own == other);
}

#[test]
fn levels_have_fewer_triangles_and_are_off_by_more_and_budgets_are_held() {
    let folder = folder();
    let levels = ["--format", "ply", "--lod", "0,1,2,3,4"];
    let files = told(&mut export(Path::new(HONDA), folder.path(), &levels));
    for (level, pair) in files.windows(2).enumerate() {
        assert_eq!(count(&pair[1], "level"), level as u64 + 1);
        assert!(count(&pair[1], "triangles") < count(&pair[0], "triangles"));
        assert!(pair[1]["bound"].as_f64() > pair[0]["bound"].as_f64());
    }
    for file in &files {
        assert_eq!(inspected(&path(file)), count(file, "triangles"));
    }
    for most in [20_000, 5000, 1000, 100] {
        let files = told(&mut export(
            Path::new(HONDA),
            folder.path(),
            &["--format", "ply", "--triangles", &most.to_string()],
        ));
        let triangles = inspected(&path(&files[0]));
        assert_eq!(count(&files[0], "triangles"), triangles);
        assert!((most / 4..=most).contains(&triangles), "{most} {triangles}");
    }
}

#[test]
fn individuals_differ_by_their_seeds_and_a_seed_is_one_of_them() {
    let folder = folder();
    let project = folder.path().join("tree.ramus");
    succeed(
        ramus()
            .args(["replay", FIRST_TREE, "--project"])
            .arg(&project),
    );
    let chance = write(
        folder.path(),
        "chance.lsys",
        "steps 5\nseed 3\naxiom !(0.1) A\nA -> F(1) [ +(uniform(20, 50)) A ] -(uniform(10, 40)) A\n",
    );
    for file in [&project, &chance] {
        let into = |name: &str| folder.path().join(name);
        let options = ["--format", "glb", "--seed", "4", "--count", "5"];
        let files = told(&mut export(file, &into("first"), &options));
        let again = told(&mut export(file, &into("second"), &options));
        let bytes = |files: &[Value]| -> Vec<Vec<u8>> {
            files
                .iter()
                .map(|file| fs::read(path(file)).unwrap())
                .collect()
        };
        let [first, second] = [bytes(&files), bytes(&again)];
        assert!(first == second, "the same each time");
        let different: std::collections::HashSet<&Vec<u8>> = first.iter().collect();
        assert_eq!(different.len(), 5);
        let seeds: Vec<u64> = files.iter().map(|file| count(file, "seed")).collect();
        assert_eq!(seeds, [4, 5, 6, 7, 8]);
        let alone = ["--format", "glb", "--seed", "6"];
        let alone = told(&mut export(file, &into("alone"), &alone));
        assert!(
            fs::read(path(&alone[0])).unwrap() == first[2],
            "the same alone"
        );
        let stem = file.file_stem().unwrap().to_str().unwrap();
        assert!(into("first").join(format!("{stem}-8.glb")).is_file());
    }
    // A grammar with its seed and its steps written into it grows the same individual, and so does a sketch's.
    let seeded = ["--format", "lsys,swc", "--seed", "9", "--steps", "6"];
    let spread = ["--format", "lsys,swc", "--steps", "7"];
    for (file, options) in [(&chance, seeded.as_slice()), (&project, &spread)] {
        let files = told(&mut export(file, &folder.path().join("seeded"), options));
        let derived = folder.path().join("derived.swc");
        let mut derive = ramus();
        derive.arg("derive").arg(path(&files[0])).arg("--export");
        derive.arg(&derived);
        if file == &project {
            derive.args(["--widths", "da-vinci"]);
        }
        succeed(&mut derive);
        assert!(fs::read(&derived).unwrap() == fs::read(path(&files[1])).unwrap());
    }
    // What is named twice is written once.
    let twice = ["--format", "ply,ply", "--lod", "2,2"];
    let files = told(&mut export(&chance, &folder.path().join("twice"), &twice));
    assert_eq!(files.len(), 1);
}

#[test]
fn individuals_are_drawn_into_one_picture() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let picture = folder.path().join("sheet.png");
    let out = folder.path().join("out");
    let mut command = export(
        Path::new(HONDA),
        &out,
        &["--count", "5", "--angles", "15", "--size", "64"],
    );
    succeed(command.arg("--sheet").arg(&picture));
    let sheet = image::open(&picture).unwrap().into_rgb8();
    assert_eq!(sheet.dimensions(), (3 * 64, 2 * 64));
    let dark = |column: u32, row: u32| {
        let cell = image::imageops::crop_imm(&sheet, 64 * column, 64 * row, 64, 64).to_image();
        let pixels = cell.pixels().filter(|pixel| pixel.0[1] < 150).count();
        (pixels, cell.into_raw())
    };
    let cells: Vec<_> = (0..5).map(|at| dark(at % 3, at / 3)).collect();
    for (at, (pixels, cell)) in cells.iter().enumerate() {
        assert!((60..1500).contains(pixels), "{at}: {pixels}");
        assert!(cells[..at].iter().all(|(_, other)| other != cell), "{at}");
    }
    assert_eq!(dark(2, 1).0, 0, "nothing stands in the sixth place");
    assert_eq!(fs::read_dir(&out).unwrap().count(), 0);
}

#[test]
fn numbers_are_told_before_anything_is_written() {
    let folder = folder();
    let out = folder.path().join("out");
    let options = ["--format", "glb,swc", "--dry-run"];
    let printed = succeed(&mut export(Path::new(HONDA), &out, &options));
    let lines: Vec<&str> = printed.lines().collect();
    assert!(
        lines[0].contains("honda.glb: 1023 segments, 24560 triangles, off by "),
        "{printed}"
    );
    assert!(lines[0].contains(" kB"), "{printed}");
    assert!(
        lines[2].starts_with("2 files of 24560 triangles would be written"),
        "{printed}"
    );
    assert!(!out.exists());
    succeed(&mut export(
        Path::new(HONDA),
        &out,
        &["--format", "glb,swc"],
    ));
    let names = fs::read_dir(&out).unwrap().count();
    assert_eq!(names, 2, "nothing else is left there");
}

#[test]
fn what_cannot_be_exported_is_said_in_a_sentence() {
    let folder = folder();
    let at = |name: &str, text: &str| write(folder.path(), name, text);
    let taken = at("taken", "a file");
    let out = folder.path().join("out");
    let swc = at("young.swc", "1 3 0 0 0 1 -1\n2 3 0 9 0 1 1\n");
    let endless = at("endless.lsys", "axiom A\nA -> F A\n");
    let nothing = at("nothing.lsys", "steps 2\naxiom A\n");
    let wrong = at("wrong.lsys", "axiom [ F\n");
    let huge = at("huge.lsys", "steps 60\naxiom F\nF -> F F F\n");
    let gaps = at("gaps.lsys", "steps 0\naxiom F(1) [ f(1) F(1) ] F(1)\n");
    for (file, out, options, part) in [
        (
            folder.path().join("none.lsys"),
            &out,
            ["--format", "glb"],
            "check that it is there",
        ),
        (
            folder.path().join("none.ramus"),
            &out,
            ["--format", "glb"],
            "none.ramus",
        ),
        (
            swc,
            &out,
            ["--format", "glb"],
            "neither a project (.ramus) nor a grammar",
        ),
        (
            endless,
            &out,
            ["--format", "glb"],
            "states no number of steps",
        ),
        (nothing, &out, ["--format", "glb"], "draws nothing"),
        (wrong, &out, ["--format", "glb"], "wrong.lsys"),
        (huge, &out, ["--format", "glb"], "huge.lsys"),
        (
            PathBuf::from(HONDA),
            &out,
            ["--format=glb", "--triangles=3"],
            "it has 12 triangles at least, and 3 were asked for",
        ),
        (
            PathBuf::from(HONDA),
            &taken,
            ["--format", "glb"],
            "taken is a file",
        ),
        (gaps.clone(), &out, ["--format", "glb,swc"], "gaps.swc"),
        (gaps, &out, ["--dry-run", "--format=swc"], "gaps.swc"),
        (
            PathBuf::from(HONDA),
            &out,
            ["--format=lsys", "--angles=5"],
            "leave lsys out",
        ),
        (
            PathBuf::from(HONDA),
            &out,
            ["--format=glb", "--count=4294967295"],
            "are too many",
        ),
        (
            PathBuf::from(HONDA),
            &out,
            ["--format=swc,lsys", "--triangles=5000"],
            "--lod and --triangles are about surfaces, and none is to be written",
        ),
    ] {
        let done = export(&file, out, &options).output().unwrap();
        let said = text(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{said}");
        let lines: Vec<&str> = said
            .lines()
            .filter(|line| line.starts_with("ramus: "))
            .collect();
        assert!(
            lines.len() == 1 && lines[0].contains(part),
            "{part}: {said}"
        );
        assert!(!out.join("gaps.glb").exists(), "all or nothing of a tree");
    }
    let last = ["--format=glb", "--seed=18446744073709551615", "--count=2"];
    let done = export(Path::new(HONDA), &out, &last).output().unwrap();
    assert!(!done.status.success() && text(&done.stderr).contains("seeds end at"));
    // Wrong usage is told as such.
    for options in [
        ["--format", "stl"],
        ["--lod", "9"],
        ["--angles", "-3"],
        ["--format=glb", "--size=64"],
    ] {
        let done = export(Path::new(HONDA), &out, &options).output().unwrap();
        assert_eq!(done.status.code(), Some(2), "{options:?}");
    }
    // Nothing is written over the grammar itself.
    let own = at("own.lsys", "steps 1\naxiom F\nF -> F F\n");
    let done = export(&own, folder.path(), &["--format", "lsys"])
        .output()
        .unwrap();
    assert!(!done.status.success() && text(&done.stderr).contains("would be overwritten"));
}

/// Individuals of a grammar that draws nothing are told to be one and the same; those of others are not.
#[test]
fn individuals_that_are_the_same_are_told() {
    let folder = folder();
    let said = |text: &str, more: &[&str]| {
        let path = folder.path().join("one.lsys");
        fs::write(&path, text).unwrap();
        let options = [&["--format=ply", "--count=2"], more].concat();
        let done = export(&path, folder.path(), &options).output().unwrap();
        assert!(done.status.success());
        String::from_utf8(done.stderr).unwrap()
    };
    let alike =
        "is left to chance, so its 2 individuals are the same tree: give --angles and --lengths";
    assert!(said("steps 3\naxiom F\nF -> F[+F]F\n", &[]).contains(alike));
    for (text, more) in [
        ("steps 3\naxiom F\nF -> F[+F]F\n", &["--angles=5"][..]),
        ("steps 3\naxiom F\nF -> F[+(normal(30, 5))F]F\n", &[]),
        (
            "steps 3\naxiom F\nF : weight 1 -> F[+F]F\nF : weight 1 -> F\n",
            &[],
        ),
        (
            "steps 3\naxiom F\ninterpret {\n  F -> +(uniform(0, 9))F(1)\n}\n",
            &[],
        ),
        ("bears oak\nsteps 3\naxiom F\nF -> F[+F]F\n", &[]),
    ] {
        let told = said(text, more);
        assert!(!told.contains("the same tree"), "{text}: {told}");
    }
}

/// A species in a season: leaves, fruit and bark with names and pictures, other leaves in winter, and a grammar that grows the same tree.
#[test]
fn a_species_is_taken_home_with_its_leaves_and_bark() {
    let folder = folder();
    let apple = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/species/apple.ramus");
    let of = |season: &str, out: &str| {
        let out = folder.path().join(out);
        let options = ["--format", "glb,usda,lsys", "--season", season];
        told(&mut export(Path::new(apple), &out, &options))
    };
    let autumn = of("autumn", "autumn");
    let triangles = count(&autumn[0], "triangles");
    assert!((200_000..900_000).contains(&triangles), "{triangles}");
    assert_eq!(inspected(&path(&autumn[0])), triangles);
    let bytes = fs::read(path(&autumn[0])).unwrap();
    let file = gltf::Gltf::from_slice(&bytes).unwrap();
    let names: Vec<_> = file
        .materials()
        .map(|one| one.name().unwrap().to_owned())
        .collect();
    assert_eq!(names, ["bark apple", "apple", "fruit"]);
    let bark = file.materials().next().unwrap();
    assert!(bark.normal_texture().is_some() && bark.occlusion_texture().is_some());
    let pbr = bark.pbr_metallic_roughness();
    assert!(pbr.base_color_texture().is_some() && pbr.metallic_roughness_texture().is_some());
    assert_eq!(file.images().count(), 3);

    let winter = of("winter", "winter");
    assert!(count(&winter[0], "triangles") * 2 < triangles, "bare");
    // The grammar is the tree: the same segments, the same season.
    let grammar = fs::read_to_string(path(&autumn[2])).unwrap();
    assert!(
        grammar.contains("\nseason autumn\n") && grammar.contains("\nbark apple"),
        "{grammar}"
    );
    let again = told(&mut export(
        &path(&autumn[2]),
        &folder.path().join("again"),
        &["--format", "glb"],
    ));
    assert_eq!(again[0]["segments"], autumn[0]["segments"]);
    assert_eq!(again[0]["triangles"], autumn[0]["triangles"]);

    // As all words that an option does not know.
    let fall = export(
        Path::new(apple),
        folder.path(),
        &["--format", "glb", "--season", "fall"],
    )
    .output()
    .unwrap();
    assert_eq!(fall.status.code(), Some(2));
    assert!(text(&fall.stderr).contains("expected spring, summer, autumn or winter"));
}

/// The individuals of a species differ by its laws, and the tree of one seed is the same alone and among others.
#[test]
fn individuals_of_a_species_are_those_of_its_seeds() {
    let folder = folder();
    let birch = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/species/birch.ramus");
    let swc = |options: &[&str], out: &str| {
        let out = folder.path().join(out);
        let files = told(&mut export(
            Path::new(birch),
            &out,
            &[&["--format", "swc"], options].concat(),
        ));
        files
            .iter()
            .map(|file| fs::read(path(file)).unwrap())
            .collect::<Vec<_>>()
    };
    let three = swc(&["--seed", "4", "--count", "3"], "three");
    assert_eq!(three.len(), 3);
    assert!(three[0] != three[1] && three[1] != three[2]);
    assert_eq!(swc(&["--seed", "5"], "one"), [three[1].clone()]);
}

#[test]
fn a_sketch_alone_is_told_with_its_own_seed_which_grows_it_again() {
    let folder = folder();
    let oak = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/species/oak.ramus");
    let of = |options: &[&str]| {
        let options: Vec<&str> = ["--format", "glb", "--dry-run"]
            .iter()
            .chain(options)
            .copied()
            .collect();
        let told = told(&mut export(Path::new(oak), folder.path(), &options));
        (count(&told[0], "seed"), count(&told[0], "triangles"))
    };
    let (seed, triangles) = of(&[]);
    assert!(seed != 0);
    assert_eq!(of(&["--seed", &seed.to_string()]), (seed, triangles));
    assert!(of(&["--seed", "0"]).1 != triangles);
}

#[test]
fn files_that_would_be_too_large_are_refused_before_anything_is_written() {
    let folder = folder();
    let out = folder.path().join("out");
    let ternary = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/grammars/ternary.lsys");
    let oak = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/species/oak.ramus");
    for (file, options) in [
        (ternary, &["--steps", "12"][..]),
        (oak, &["--count", "25", "--grove"]),
    ] {
        for dry in [&["--dry-run"][..], &[]] {
            let mut command = export(Path::new(file), &out, &["--format", "usda"]);
            let output = command.args(options).args(dry).output().unwrap();
            refused(
                &output,
                &[
                    "a USD file of this may take up to ",
                    "written up to 4.3 GB",
                    "a coarser level of detail",
                ],
            );
        }
    }
    assert_eq!(fs::read_dir(&out).unwrap().count(), 0);
}

#[test]
fn a_mark_of_the_encoding_is_no_damage_and_the_fewest_triangles_are_told() {
    let folder = folder();
    let fern = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/species/fern.ramus");
    let marked = folder.path().join("fern.ramus");
    let project = fs::read_to_string(fern).unwrap();
    fs::write(&marked, format!("\u{feff}{project}")).unwrap();
    let out = folder.path().join("out");
    let of = |triangles: &str| {
        let options = ["--format", "glb", "--dry-run", "--triangles", triangles];
        export(&marked, &out, &options).output().unwrap()
    };
    let few = of("2");
    refused(
        &few,
        &["triangles at least, and 2 were asked for: give --triangles"],
    );
    let said = text(&few.stderr);
    let least = said.split("it has ").nth(1).unwrap();
    let least = least.split(' ').next().unwrap();
    assert!(of(least).status.success(), "{least}");
}
