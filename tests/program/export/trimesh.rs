//! Files as PyPI's trimesh reads them: which triangles, how large, which way up, under which names.

use super::home::species;
use super::*;

/// The Python that has trimesh: `RAMUS_TRIMESH`, which `scripts/test.sh` sets.
fn python() -> Option<PathBuf> {
    let python = std::env::var_os("RAMUS_TRIMESH").map(PathBuf::from);
    if python.is_none() {
        assert!(
            std::env::var_os("CI").is_none(),
            "CI installs trimesh first"
        );
        println!(
            "skipped: RAMUS_TRIMESH names no Python with trimesh in it (`make test STAGES=\"trimesh tests\"` makes one)"
        );
    }
    python
}

/// What trimesh finds in files.
fn read(python: &Path, files: &[PathBuf]) -> Vec<Value> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python/read.py");
    let output = Command::new(python).arg(script).args(files).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines = text(&output.stdout);
    let found = lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap());
    found.collect()
}

#[test]
fn trimesh_reads_what_was_written() {
    let Some(python) = python() else {
        return;
    };
    let folder = folder();
    let mut files = Vec::new();
    for name in ["oak", "spruce", "apple", "cactus"] {
        for (out, options) in [
            ("alone", ["--lod=2", "--season=summer"].as_slice()),
            (
                "winter",
                &["--lod=3", "--season=winter", "--wind", "--texture=64"],
            ),
            ("grove", &["--lod=4", "--grove", "--count=3"]),
        ] {
            let options = [&["--format=glb,obj,ply"], options].concat();
            let out = folder.path().join(out);
            files.extend(told(&mut export(&species(name), &out, &options)));
        }
    }
    let paths: Vec<PathBuf> = files.iter().map(path).collect();
    let found = read(&python, &paths);
    assert_eq!(found.len(), files.len());
    for ((file, path), found) in files.iter().zip(&paths).zip(&found) {
        let at = path.display();
        assert_eq!(count(found, "triangles"), count(file, "triangles"), "{at}");
        assert_eq!(found["finite"], true, "{at}");
        // Leaves are meshes: nothing is seen through.
        assert_eq!(found["alpha"], serde_json::json!(["OPAQUE"]), "{at}");
        // As large, and as Y says up, as our own reader finds it; the ground is at 0.
        let own = succeed(ramus().arg("inspect").arg(path).arg("--json"));
        let own: Value = serde_json::from_str(&own).unwrap();
        let number = |of: &Value| of.as_f64().unwrap();
        for axis in 0..3 {
            for corner in ["min", "max"] {
                let [a, b] = [&own, found].map(|of| number(&of[corner][axis]));
                assert!((a - b).abs() < 1e-4, "{at}: {corner} {axis}: {a}, {b}");
            }
        }
        let [low, high] = ["min", "max"].map(|corner| number(&found[corner][1]));
        assert!(
            low.abs() < 0.5 && high > 1.5,
            "{at}: from {low} to {high} m"
        );
        let [a, b] = [&own, found].map(|of| number(&of["area"]));
        assert!((a - b).abs() < 1e-4 * a, "{at}: {a}, {b} square metres");
    }
    // Names and the picture of the bark, where the format has them.
    let of = |ending: &str| {
        let at = paths.iter().position(|path| path.ends_with(ending));
        &found[at.unwrap()]
    };
    let oak = of("alone/oak.glb");
    assert_eq!(oak["names"], serde_json::json!(["oak-leaves", "oak-wood"]));
    assert_eq!(oak["pictured"], 1);
    assert_eq!(
        of("winter/oak.glb")["names"],
        serde_json::json!(["oak-wood"])
    );
    assert_eq!(of("grove/oak-grove.glb")["pictured"], 3);
}
