//! `ramus inspect`: files as a person has them, good and bad.

use super::*;

/// A tetrahedron whose last triangle is missing.
const OPEN: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 3\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n30 0 0\n0 30 0\n0 0 30\n3 0 2 1\n3 0 1 3\n3 0 3 2\n";

#[test]
fn a_model_is_told_on_one_screen_and_as_json() {
    let folder = folder();
    // Its name lies.
    let model = folder.path().join("bone.stl");
    fs::write(&model, OPEN).unwrap();
    let screen = succeed(ramus().arg("inspect").arg(&model));
    for told in [
        "ASCII PLY, 3 triangles",
        "! 1 open end",
        "millimetres (guessed by size)",
        "open, area",
    ] {
        assert!(screen.contains(told), "{told}\n{screen}");
    }
    let json = succeed(ramus().arg("inspect").arg(&model).arg("--json"));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["triangles"], 3);
    assert_eq!(json["watertight"], false);
    assert_eq!(json["open_ends"][0]["edges"], 3);
}

#[test]
fn a_skeleton_is_told_with_its_unit() {
    let folder = folder();
    let model = folder.path().join("neuron.txt");
    fs::write(&model, "1 1 0 0 0 4 -1\n2 3 0 60 0 3 1\n3 3 0 90 9 2 2\n").unwrap();
    let screen = succeed(ramus().arg("inspect").arg(&model));
    for told in [
        "SWC, ",
        "Skeleton  3 nodes",
        "micrometres (by the format's custom)",
        "watertight",
    ] {
        assert!(screen.contains(told), "{told}\n{screen}");
    }
}

fn inspect(model: &Path) -> Output {
    ramus().arg("inspect").arg(model).output().unwrap()
}

#[test]
fn what_is_no_model_is_refused_in_one_sentence() {
    let folder = folder();
    let announced = OPEN.replace("vertex 4", "vertex 4000000000");
    let out_of_range = OPEN.replace("3 0 3 2", "3 0 3 7");
    let cases: [(&str, &[u8], &str); 6] = [
        ("empty.ply", b"", "empty"),
        (
            "letter.obj",
            b"Dear Sir or Madam,\n",
            "no format that is known",
        ),
        ("scan.glb", b"glTF\x02\0\0\0", "byte 8 of the GLB file"),
        ("huge.ply", announced.as_bytes(), "4000000000"),
        ("wrong.ply", out_of_range.as_bytes(), "line 16"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\n", "no triangle"),
    ];
    for (name, bytes, told) in cases {
        let model = folder.path().join(name);
        fs::write(&model, bytes).unwrap();
        refused(&inspect(&model), &[told, name]);
    }
    refused(&inspect(&folder.path().join("none.stl")), &["none.stl"]);
    refused(&inspect(folder.path()), &["plain file"]);
}

/// Each real model there is, as the list of models has it.
#[test]
fn real_models_are_told_about() {
    let Ok(shared) = std::env::var("RAMUS_SHARED") else {
        eprintln!("skipped: RAMUS_SHARED is not set");
        return;
    };
    for (name, triangles, told) in [
        ("truth/c_y60.ply", 62_484, ""),
        (
            "real/vmtk_aorta-surface-open-ends.stl",
            11_887,
            "3 open ends",
        ),
        ("real/blood_vessels_mc.ply", 30_536, ""),
        ("real/vmtk_aorta-surface.vtp", 12_932, "watertight"),
        (
            "real/vmtk_aorta-surface-two-segments.vtp",
            37_304,
            "2 parts",
        ),
        ("real/skeletor_722817260.obj", 13_772, "non-manifold"),
        (
            "real/eztree_ash_small.ply",
            5_616,
            "pass through each other",
        ),
    ] {
        let model = Path::new(&shared).join("models").join(name);
        let json = succeed(ramus().arg("inspect").arg(&model).arg("--json"));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["triangles"], triangles, "{name}");
        let screen = succeed(ramus().arg("inspect").arg(&model));
        assert!(screen.contains(told), "{name}: {screen}");
    }
}

#[test]
fn a_model_is_mended_by_a_list_and_written_in_each_format() {
    let folder = folder();
    let model = folder.path().join("duct.ply");
    fs::write(&model, OPEN).unwrap();
    for name in ["duct.glb", "closed.PLY", "closed.stl", "closed.obj"] {
        let out = folder.path().join(name);
        let mut inspect = ramus();
        inspect.arg("inspect").arg(&model).arg("--out").arg(&out);
        let told = succeed(inspect.args(["--repair", "weld, orient, close=flat"]));
        for words in [
            "* weld=0: nothing to do",
            "* orient: nothing to do",
            "* close=flat: 1 open end closed (1 flat, 0 by least area, 0 by a fan); 3 → 4 triangles",
            "watertight",
        ] {
            assert!(told.contains(words), "{words}\n{told}");
        }
        let told = succeed(ramus().arg("inspect").arg(&out));
        assert!(told.contains("watertight"), "{told}");
    }
    // Without a list it is converted, without a place it is only told.
    let out = folder.path().join("open.stl");
    succeed(ramus().arg("inspect").arg(&model).arg("--out").arg(&out));
    assert!(succeed(ramus().arg("inspect").arg(&out)).contains("1 open end"));
    let json = ["--repair", "close=smooth", "--json"];
    let json = succeed(ramus().arg("inspect").arg(&model).args(json));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["repairs"][0]["mend"], "close=smooth");
    assert_eq!(json["watertight"], true);
    assert_eq!(fs::read_to_string(&model).unwrap(), OPEN);
}

#[test]
fn bad_lists_and_places_are_refused_before_the_work() {
    let folder = folder();
    let model = folder.path().join("duct.ply");
    fs::write(&model, OPEN).unwrap();
    let out = folder.path().join("out.ply");
    let nowhere = folder.path().join("none").join("out.ply");
    for (list, out, told) in [
        (
            "weld,wedl",
            &out,
            "mend 2 of the list, `wedl`: there is no such mend; `weld` is near",
        ),
        (
            "smooth=0",
            &out,
            "`smooth=0`: this takes a number of passes from 1 to 200",
        ),
        ("weld", &nowhere, "none"),
        ("weld", &model, "would be overwritten"),
        ("remesh=0.0001", &out, "can be made"),
        ("debris=1000", &out, "would leave no triangle"),
    ] {
        let mut inspect = ramus();
        inspect.arg("inspect").arg(&model).arg("--out").arg(out);
        refused(&inspect.args(["--repair", list]).output().unwrap(), &[told]);
        assert!(!folder.path().join("out.ply").exists());
    }
    let mut inspect = ramus();
    inspect
        .arg("inspect")
        .arg(&model)
        .args(["--out", "out.vtk"]);
    let output = inspect.output().unwrap();
    assert_eq!(
        output.status.code(),
        Some(2),
        "an ending that tells no format is wrong usage"
    );
}

#[test]
fn a_picture_is_drawn_with_the_looks_that_are_asked_for() {
    let folder = folder();
    let model = folder.path().join("bone.ply");
    fs::write(&model, OPEN).unwrap();
    let drawn = |looks: &str| {
        let png = folder.path().join(format!("{looks}.png"));
        let mut program = ramus();
        program.arg("inspect").arg(&model).args(["--size", "96"]);
        let told = succeed(program.arg("--png").arg(&png).args(["--look", looks]));
        assert!(told.contains("ASCII PLY, 3 triangles"), "{told}");
        let picture = image::open(&png).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (96, 96));
        // What is not paper.
        let ink = picture.pixels().filter(|pixel| pixel.0[2] < 200);
        ink.count()
    };
    let (whole, edges) = (drawn("shaded"), drawn("edges"));
    assert!(
        whole > 500 && edges > 30 && edges < whole,
        "{whole} {edges}"
    );
    // All its triangles are at the open end, so all are blue there.
    let blue = image::open(folder.path().join("problems.png"));
    assert!(blue.is_err(), "not asked for yet");
    drawn("problems,box");
    let picture = image::open(folder.path().join("problems,box.png"))
        .unwrap()
        .to_rgb8();
    let blue = picture
        .pixels()
        .filter(|pixel| i32::from(pixel.0[2]) > i32::from(pixel.0[0]) + 40);
    assert!(blue.count() > 200);
    // Nothing is written over the model, and looks have names.
    let mut over = ramus();
    let png = folder.path().join("bone.png");
    fs::copy(&model, &png).unwrap();
    let over = over
        .arg("inspect")
        .arg(&png)
        .arg("--png")
        .arg(&png)
        .output()
        .unwrap();
    refused(&over, &["would be overwritten"]);
    let mut unknown = ramus();
    unknown
        .arg("inspect")
        .arg(&model)
        .args(["--png", "a.png", "--look", "pretty"]);
    let unknown = unknown.output().unwrap();
    assert_eq!(unknown.status.code(), Some(2));
    assert!(
        text(&unknown.stderr).contains("x-ray"),
        "{}",
        text(&unknown.stderr)
    );
}

/// An open tube of 30 rows as an OBJ file: 12 thick and 100 long.
fn tube() -> String {
    use std::fmt::Write as _;
    let mut text = String::new();
    for row in 0..30 {
        for column in 0..12 {
            let turn = f64::from(column) / 12.0 * std::f64::consts::TAU;
            let (x, z) = (6.0 * turn.cos(), 6.0 * turn.sin());
            writeln!(text, "v {x} {} {z}", f64::from(row) * 100.0 / 29.0).unwrap();
        }
    }
    for row in 0..29 {
        for column in 0..12 {
            let [a, b] = [column, (column + 1) % 12].map(|column| row * 12 + column + 1);
            writeln!(text, "f {a} {} {} {b}", a + 12, b + 12).unwrap();
        }
    }
    text
}

#[test]
fn ends_are_proposed_written_and_shown() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("tube.obj"), tube()).unwrap();
    for name in ["ends.csv", "ends.json"] {
        let proposing = ramus()
            .args(["inspect", "--propose"])
            .arg(at(name))
            .arg(at("tube.obj"))
            .output()
            .unwrap();
        assert!(proposing.status.success());
        let said = String::from_utf8(proposing.stderr).unwrap();
        assert!(said.contains("proposed ends: 2"), "{said}");
    }
    let table = fs::read_to_string(at("ends.csv")).unwrap();
    assert_eq!(table.lines().count(), 3, "{table}");
    assert!(
        table.contains("source,source,") && table.contains("target 1,target,"),
        "{table}"
    );
    // A name that tells no format is wrong usage, before any work.
    let wrong = ramus()
        .args(["inspect", "none.obj", "--propose", "ends.txt"])
        .output()
        .unwrap();
    assert_eq!(wrong.status.code(), Some(2));
    let told = String::from_utf8(wrong.stderr).unwrap();
    assert!(told.contains(".csv or .json"), "{told}");
    // What cannot be read of them is told with its line, before the model is looked at.
    fs::write(at("bad.csv"), "x,y,z\n1,2,three\n").unwrap();
    let mut showing = ramus();
    showing.arg("inspect").arg(at("tube.obj"));
    showing.arg("--endpoints").arg(at("bad.csv"));
    showing.arg("--png").arg(at("bad.png"));
    refused(&showing.output().unwrap(), &["bad.csv", "line 2", "three"]);
    assert!(!at("bad.png").exists());
}
