//! `ramus analyze`: centerlines as a person finds them, and what is said where there are none.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::*;

/// A tube of radius 2 from 0 to 40 along x, open at both ends, as OBJ.
pub(super) fn tube() -> String {
    let (round, rows) = (36_u32, 41_u32);
    let mut text = String::new();
    for row in 0..rows {
        for column in 0..round {
            let (sin, cos) = (f64::from(column) / f64::from(round) * TAU).sin_cos();
            writeln!(text, "v {row} {} {}", 2.0 * cos, 2.0 * sin).unwrap();
        }
    }
    let vertex = |column: u32, row: u32| row * round + column % round + 1;
    for row in 0..rows - 1 {
        for column in 0..round {
            let [a, b] = [vertex(column, row), vertex(column + 1, row)];
            let [c, d] = [vertex(column + 1, row + 1), vertex(column, row + 1)];
            writeln!(text, "f {a} {b} {c} {d}").unwrap();
        }
    }
    text
}

fn number(json: &serde_json::Value, of: &str) -> f64 {
    let value = json.pointer(of).and_then(serde_json::Value::as_f64);
    value.unwrap_or_else(|| panic!("no number at {of}: {json}"))
}

#[test]
fn a_tube_is_measured_and_exported() {
    let folder = folder();
    let model = folder.path().join("tube.obj");
    fs::write(&model, tube()).unwrap();
    let [swc, vtp, csv] =
        ["line.swc", "line.vtp", "branches.csv"].map(|name| folder.path().join(name));
    let analyze = |ending: &Path| {
        let mut command = ramus();
        command
            .arg("analyze")
            .arg(&model)
            .arg("--export")
            .arg(ending);
        command
    };
    let json = succeed(analyze(&swc).arg("--json").arg("--csv").arg(&csv));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["format"], "ramus-analysis/1");
    assert_eq!(json["endpoints"]["automatic"], true);
    assert_eq!(
        (
            json["counts"]["branches"].as_u64(),
            json["counts"]["tips"].as_u64()
        ),
        (Some(1), Some(1))
    );
    // From the ball that touches one end's cap to the one that touches the other's.
    let length = number(&json, "/branches/0/length");
    assert!((length - 36.0).abs() < 0.3, "{length}");
    assert!(
        (number(&json, "/table/point_radius/mean") - 2.0).abs() < 0.02,
        "{json}"
    );
    assert_eq!(json["nodes"]["parent"][0], -1);
    let radius = number(&json, "/branches/0/radius/mean");
    assert!((radius - 2.0).abs() < 0.02 && json["branches"][0]["radius"]["taper"].is_number());
    assert_eq!(json["orders"]["strahler"][0]["order"], 1);
    let stem = &json["orders"]["centrifugal"][0];
    assert_eq!((&stem["order"], &stem["branches"]), (&0.into(), &1.into()));
    assert_eq!(stem["branch_length"]["mean"], json["branches"][0]["length"]);
    assert!(stem["bifurcation_angle_deg"].is_null(), "it leaves no fork");
    let rows = fs::read_to_string(&csv).unwrap();
    assert!(rows.starts_with("table,id,name,parent,order,"), "{rows}");
    // One branch, whole and by VMTK's definition, and one centerline.
    let tables: Vec<&str> = rows
        .lines()
        .skip(1)
        .filter_map(|row| row.split(',').next())
        .collect();
    assert_eq!(tables, ["branches", "branches_vmtk", "centerlines"]);
    // From surface to surface it is as long as the tube.
    let line = &json["centerlines"][0];
    assert_eq!(line["target"], 0);
    assert!(
        (number(line, "/length_to_surface") - 40.0).abs() < 0.05,
        "{line}"
    );
    assert!((number(line, "/tip_to_surface") - 2.0).abs() < 0.2);
    assert!((number(line, "/root_to_surface") - 2.0).abs() < 0.2);
    assert_eq!(number(line, "/length_without_stem"), 0.0);
    assert!(
        json["table"]["definition"]
            .as_str()
            .unwrap()
            .contains("whole")
            && json["table_vmtk"]["definition"]
                .as_str()
                .unwrap()
                .contains("VMTK")
    );
    assert!((number(&json, "/table_vmtk/branch_length/mean") - length).abs() < 1e-3);
    succeed(&mut analyze(&vtp));
    let lines = fs::read_to_string(&vtp).unwrap();
    assert!(
        lines.contains("Name=\"MaximumInscribedSphereRadius\"")
            && lines.contains("NumberOfLines=\"1\""),
        "{lines}"
    );
    // What was written is a skeleton, and is measured alike.
    for skeleton in [&swc, &vtp] {
        let again = succeed(ramus().arg("analyze").arg(skeleton).arg("--json"));
        let again: serde_json::Value = serde_json::from_str(&again).unwrap();
        assert!(
            (number(&again, "/branches/0/length") / length - 1.0).abs() < 1e-6,
            "{again}"
        );
        assert_eq!(again["centerlines"][0]["name"], "tip 1");
        assert!(again["centerlines"][0]["length_to_surface"].is_null());
    }
}

#[test]
fn capped_lines_go_on_to_the_middles_of_open_ends() {
    let folder = folder();
    let model = folder.path().join("tube.obj");
    fs::write(&model, tube()).unwrap();
    let json = succeed(ramus().arg("analyze").arg(&model).args(["--cap", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["endpoints"]["capped"], 2);
    let line = &json["centerlines"][0];
    for of in ["/length", "/length_to_surface"] {
        assert!((number(line, of) - 40.0).abs() < 0.02, "{line}");
    }
    assert_eq!(number(line, "/tip_to_surface"), 0.0);
    // It begins in the middle of one open end and ends in that of the other.
    let nodes = json["nodes"]["position"].as_array().unwrap();
    for (node, x) in [(0, 0.0), (nodes.len() - 1, 40.0)] {
        let end = |axis: usize| nodes[node][axis].as_f64().unwrap();
        let x = if end(0) > 20.0 { 40.0_f64.max(x) } else { 0.0 };
        assert!(
            (end(0) - x).abs() < 1e-4 && end(1).abs() < 1e-4 && end(2).abs() < 1e-4,
            "{:?}",
            nodes[node]
        );
    }
    assert_eq!(json["nodes"]["parent"][0], -1);
    assert_eq!(json["nodes"]["parent"][1], 0);
}

#[test]
fn lines_leave_oblique_open_ends_straight() {
    // The aorta's upper end is cut obliquely: the wall and the flat cap make a sharp corner, through which no line should go.
    let Some(shared) = std::env::var_os("RAMUS_SHARED") else {
        println!("skipped: RAMUS_SHARED names no folder with models");
        return;
    };
    let model = Path::new(&shared).join("models/real/vmtk_aorta-surface-open-ends.stl");
    for cap in [&[][..], &["--cap"]] {
        let json = succeed(ramus().arg("analyze").arg(&model).arg("--json").args(cap));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let bent = number(&json, "/table/tortuosity/max");
        assert!(bent < 0.02, "{bent}");
        // VMTK has 30.43 ± 0.66 and a radius of 5.20, from its own ends.
        if cap.is_empty() {
            let length = number(&json, "/table_vmtk/branch_length/mean");
            assert!((length - 30.43).abs() < 0.66, "{length}");
        }
    }
}

#[test]
fn centerlines_of_vmtk_are_measured_by_both_definitions() {
    let lines = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/vmtk/duct.vtp");
    let json = succeed(ramus().arg("analyze").arg(lines).arg("--json"));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let count = |of: &str| json.pointer(of).and_then(serde_json::Value::as_u64);
    // A trifurcation is two forks of lines that part one after the other.
    assert_eq!(count("/counts/branches"), Some(25));
    assert_eq!(count("/counts_vmtk/branches"), Some(24));
    assert_eq!(count("/counts_vmtk/multifurcations"), Some(1));
    assert_eq!(count("/counts/centerlines"), Some(13));
    // What is blanked is missing from branches.
    let [whole, vmtk] = ["/table", "/table_vmtk"]
        .map(|table| number(&json, &format!("{table}/branch_length/mean")));
    assert!(vmtk < 0.9 * whole, "{vmtk} {whole}");
    let junctions = json["junctions_vmtk"].as_array().unwrap();
    let branches = json["branches_vmtk"].as_array().unwrap();
    assert_eq!((junctions.len(), branches.len()), (11, 24));
    for junction in junctions {
        let all = junction["daughters"].as_array().unwrap().len() + 1;
        for of in ["in_plane_deg", "out_of_plane_deg", "vectors", "short"] {
            assert_eq!(junction[of].as_array().unwrap().len(), all, "{of}");
        }
        assert_eq!(junction["tracts"][0]["blanked"], true);
        let parent = &junction["parent"];
        let ends_there = |branch: &&serde_json::Value| branch["group"] == *parent;
        let branch = branches.iter().find(ends_there).unwrap();
        assert_eq!(branch["downstream"], junction["group"]);
    }
    for junction in json["junctions"].as_array().unwrap() {
        assert!(junction["in_plane_deg"][0].is_number(), "{junction}");
        assert!(junction["frame"]["normal"].is_array());
    }
    let said = succeed(ramus().arg("analyze").arg(lines));
    assert!(
        said.contains("\nwhole branches") && said.contains("\nVMTK's branches"),
        "{said}"
    );
    assert!(said.contains("by VMTK's definition 24 branches, 11 bifurcations (10 of two)"));
}

#[test]
fn endpoints_are_given_by_point_and_file_and_bytes_are_the_same() {
    let folder = folder();
    let model = folder.path().join("tube.obj");
    fs::write(&model, tube()).unwrap();
    let targets = folder.path().join("ends.csv");
    fs::write(&targets, "name,x,y,z\nhalf,20,0,0\nend,40,0,0\n").unwrap();
    let run = |threads: &str| {
        let mut command = ramus();
        command.env("RAYON_NUM_THREADS", threads);
        command
            .arg("analyze")
            .arg(&model)
            .args(["--source", "0,0,0", "--json"])
            .arg("--targets")
            .arg(&targets);
        let mut json: serde_json::Value = serde_json::from_str(&succeed(&mut command)).unwrap();
        json["timing_ms"].take();
        json
    };
    let json = run("1");
    assert_eq!(
        (
            json["endpoints"]["automatic"].as_bool(),
            json["counts"]["centerlines"].as_u64()
        ),
        (Some(false), Some(2))
    );
    assert_eq!(json, run("2"));
}

#[test]
fn proposals_off_the_outer_wall_cost_nobody_the_rest() {
    // Our own branch: hundreds of open sheets and tubes, whose ends are proposed where the outer wall is not.
    let model = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models/branch.glb");
    let json = succeed(ramus().arg("analyze").arg(model).arg("--json"));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(number(&json, "/counts/centerlines") >= 1.0, "{json}");
    let unreached = json["endpoints"]["unreached"].as_array().unwrap();
    assert!(
        unreached.iter().all(|one| one["reason"].is_string()),
        "{unreached:?}"
    );
}

#[test]
fn what_cannot_be_analyzed_is_said_in_one_sentence() {
    let folder = folder();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let tube = file("tube.obj", &tube());
    let flat = file("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let skeleton = file("tree.swc", "1 1 0 0 0 4 -1\n2 3 0 60 0 3 1\n");
    let far = file("far.csv", "x,y,z\n40,90,0\n");
    let here = file("here.csv", "x,y,z\n0,0,0\n");
    let two = file("two.csv", "kind,x,y,z\nsource,0,0,0\nsource,40,0,0\n");
    let [far, here, two] = [&far, &here, &two].map(|path| path.to_str().unwrap());
    for (model, args, expected) in [
        (&flat, vec![], "no ends were found"),
        (&tube, vec!["--targets", far], "there is no source"),
        (
            &tube,
            vec!["--source", "0,0,0", "--targets", far],
            "off the surface",
        ),
        (
            &tube,
            vec!["--source", "0,0,0", "--targets", here],
            "is where the source is",
        ),
        (&tube, vec!["--targets", two], "there are 2 sources"),
        (&skeleton, vec!["--auto"], "is a skeleton already"),
        (&skeleton, vec!["--cap"], "is a skeleton already"),
    ] {
        let output = ramus()
            .arg("analyze")
            .arg(model)
            .args(&args)
            .output()
            .unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(
            said.contains(expected) && said.lines().count() == 1,
            "{said}, expected {expected}"
        );
    }
    for args in [
        ["--source", "1,2"],
        ["--bridge", "-1"],
        ["--export", "line.txt"],
        ["--csv", "line.txt"],
    ] {
        let output = ramus()
            .arg("analyze")
            .arg(&tube)
            .args(args)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    }
}

#[test]
fn ends_that_are_sought_are_drawn_and_exported_and_gaps_are_bridged_on_request() {
    let folder = folder();
    let [model, glb, png] =
        ["tube.obj", "line.glb", "seen.png"].map(|name| folder.path().join(name));
    fs::write(&model, tube()).unwrap();
    let mut command = ramus();
    command
        .arg("analyze")
        .arg(&model)
        .args(["--auto", "--size", "256"]);
    succeed(command.arg("--export").arg(&glb).arg("--png").arg(&png));
    assert!(fs::read(&glb).unwrap().starts_with(b"glTF"));
    // The line from the source, in orange and red, to the target, in blue, in the middle of the picture.
    let picture = image::open(&png).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (256, 256));
    let columns = |is: &dyn Fn([i32; 3]) -> bool| -> Vec<u32> {
        let pixels = picture.enumerate_pixels();
        let is = |(column, _, pixel): (u32, u32, &image::Rgb<u8>)| {
            is(pixel.0.map(i32::from)).then_some(column)
        };
        pixels.filter_map(is).collect()
    };
    let warm = columns(&|[r, g, b]| r > g + 40 && r > b + 40);
    let blue = columns(&|[r, _, b]| b > r + 40);
    // The line is as long as the tube but for a radius at each end; the target's ball is small, and behind the line's end.
    let (first, last) = (warm.iter().min().unwrap(), warm.iter().max().unwrap());
    assert!(warm.len() > 150 && last - first > 160, "{first} to {last}");
    assert!((6..100).contains(&blue.len()), "{blue:?}");
    assert!(blue.iter().all(|column| column > last), "{blue:?}, {last}");

    // Another tube, 2 behind the end of the first.
    let vertices = tube().lines().filter(|line| line.starts_with('v')).count();
    let mut both = tube();
    for line in tube().lines() {
        let mut words = line.split(' ');
        let kind = words.next().unwrap();
        let numbers: Vec<f64> = words.map(|word| word.parse().unwrap()).collect();
        match kind {
            "v" => writeln!(
                both,
                "v {} {} {}",
                numbers[0] + 42.0,
                numbers[1],
                numbers[2]
            ),
            _ => {
                let [a, b, c, d] = [0, 1, 2, 3].map(|corner| numbers[corner] + vertices as f64);
                writeln!(both, "f {a} {b} {c} {d}")
            }
        }
        .unwrap();
    }
    fs::write(&model, both).unwrap();
    let targets = folder.path().join("ends.csv");
    fs::write(&targets, "x,y,z\n82,0,0\n").unwrap();
    let analyze = || {
        let mut command = ramus();
        command.arg("analyze").arg(&model);
        command
            .args(["--source", "0,0,0", "--json", "--targets"])
            .arg(&targets);
        command
    };
    refused(&analyze().output().unwrap(), &["gap of 1.99", "near (41.0"]);
    let json = succeed(analyze().args(["--bridge", "2.5"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(
        (number(&json, "/branches/0/length") - 78.0).abs() < 1.0,
        "{json}"
    );
}
