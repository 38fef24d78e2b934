//! `ramus abstract`: a table or a model as an L-system whose trees have the same statistics.

use std::path::PathBuf;

use serde_json::Value;

use super::cohort::{tree, write};
use super::*;

const DUCT: &str = "tests/data/tables/duct.json";

fn abstracted(model: &Path, candidates: &str) -> Command {
    let mut command = ramus();
    command.arg("abstract").arg(model);
    command.args(["--candidates", candidates, "--seed", "4"]);
    command
}

fn output(command: &mut Command) -> (bool, String, String) {
    let done = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (done.status.success(), text(done.stdout), text(done.stderr))
}

#[test]
fn a_table_becomes_a_grammar_a_tree_and_a_report_that_agree() {
    let folder = tempfile::tempdir().unwrap();
    let [grammar, swc, glb] =
        ["best.lsys", "best.swc", "best.glb"].map(|name| folder.path().join(name));
    let mut command = abstracted(Path::new(DUCT), "1500");
    command
        .arg("--json")
        .arg("--grammar")
        .arg(&grammar)
        .arg("--export")
        .arg(&swc);
    let (good, printed, said) = output(&mut command);
    assert!(good, "{said}");
    let told: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(told["format"], "ramus-abstraction/1");
    assert_eq!(told["target"]["table"]["branch_length"]["mean"], 63.96);
    let best = &told["best"];
    assert_eq!(best["counts"]["centerlines"], 13);
    assert_eq!(told["candidates"], 1500);
    assert_eq!(told["ranked"][0]["seed"], best["seed"]);
    assert_eq!(told["source_rules"]["parameters"]["iterations"], 10.0);
    let off = &best["differences"]["point_radius.mean"];
    assert!(off["relative"].as_f64().unwrap().abs() < 0.05, "{off}");

    // The exported tree, measured, has the table that was told; so has the tree of the grammar.
    let measured = |path: &Path| -> Value {
        let (good, printed, said) = output(ramus().arg("analyze").arg(path).arg("--json"));
        assert!(good, "{said}");
        serde_json::from_str(&printed).unwrap()
    };
    let grown = folder.path().join("grown.swc");
    let mut derive = ramus();
    derive
        .arg("derive")
        .arg(&grammar)
        .arg("--export")
        .arg(&grown)
        .args(["--widths", "metres"]);
    let (good, _, said) = output(&mut derive);
    assert!(good, "{said}");
    for path in [&swc, &grown] {
        let table = measured(path);
        assert_eq!(table["counts"]["tips"], 13);
        for name in [
            "branch_length",
            "centerline_length",
            "bifurcation_angle_deg",
            "point_radius",
        ] {
            for of in ["mean", "std"] {
                let [told, found] = [&best["table"], &table["table"]]
                    .map(|table| table[name][of].as_f64().unwrap());
                assert!(
                    (told / found - 1.0).abs() < 1e-3,
                    "{}: {name} {of}: {told} {found}",
                    path.display()
                );
            }
        }
    }
    // What was measured is a table, too.
    let table = folder.path().join("measured.json");
    let (_, printed, _) = output(ramus().arg("analyze").arg(&swc).arg("--json"));
    fs::write(&table, printed).unwrap();
    let (good, printed, said) = output(abstracted(&table, "500").arg("--export").arg(&glb));
    assert!(good && glb.exists(), "{said}");
    assert!(
        printed.contains("centerlines") && printed.contains("by rules"),
        "{printed}"
    );
    // It says what branches are like by order, of which the published table says nothing.
    assert!(printed.contains("\norder 1 "), "{printed}");
    assert!(best["by_order"].is_null() && best["parameters"]["length_by_order"].is_null());
    let (good, printed, said) = output(abstracted(&table, "500").arg("--json"));
    assert!(good, "{said}");
    let told: Value = serde_json::from_str(&printed).unwrap();
    let rows = told["target"]["orders"]["centrifugal"].as_array().unwrap();
    assert!(rows.len() > 2 && rows[0]["branches"] == 1);
    let of_stem = &told["best"]["by_order"][0];
    assert_eq!(
        (&of_stem["order"], &of_stem["name"]),
        (&0.into(), &"branch_length".into())
    );
    assert_eq!(of_stem["target"], rows[0]["branch_length"]["mean"]);
}

#[test]
fn the_same_seed_tells_the_same() {
    let once = || {
        let (_, printed, _) = output(abstracted(Path::new(DUCT), "500").arg("--json"));
        let mut told: Value = serde_json::from_str(&printed).unwrap();
        told["seconds"] = Value::Null;
        told
    };
    assert_eq!(once(), once());
}

#[test]
fn a_skeleton_is_abstracted_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), "young.swc", &tree(1.0, 20.0));
    let (good, printed, said) = output(&mut abstracted(&path, "500"));
    assert!(good, "{said}");
    assert!(
        printed.starts_with(&format!("{}: 500 trees drawn", path.display())),
        "{printed}"
    );
}

/// Trees of two sizes and one that is no tree.
/// What a grammar grows is measured as its skeleton in a file would be.
#[test]
fn what_a_grammar_grows_is_abstracted() {
    let folder = tempfile::tempdir().unwrap();
    let text = "steps 4\naxiom !(0.1) A(1)\nA(l) -> F(l) [ +(35) /(40) A(l*0.8) ] -(25) A(l*0.9)\n";
    let grammar = write(folder.path(), "fork.lsys", text);
    let (good, told, said) = output(abstracted(&grammar, "300").arg("--json"));
    assert!(good, "{said}");
    let told: Value = serde_json::from_str(&told).unwrap();
    let skeleton = folder.path().join("fork.swc");
    let derived = Command::new(env!("CARGO_BIN_EXE_ramus"))
        .args(["derive", "--export"])
        .args([&skeleton, &grammar])
        .output()
        .unwrap();
    assert!(derived.status.success());
    let (good, of_skeleton, said) = output(abstracted(&skeleton, "300").arg("--json"));
    assert!(good, "{said}");
    let of_skeleton: Value = serde_json::from_str(&of_skeleton).unwrap();
    assert_eq!(told["target"]["counts"], of_skeleton["target"]["counts"]);
    assert_eq!(told["target"]["counts"]["centerlines"], 8);
}

fn group(folder: &Path) -> PathBuf {
    for (name, size) in [("a", 1.0), ("b", 1.0), ("c", 1.6)] {
        write(folder, &format!("group/{name}.swc"), &tree(size, 20.0));
    }
    folder.join("group")
}

#[test]
fn a_group_is_abstracted_as_one_and_variants_are_written_beside_the_best() {
    let folder = tempfile::tempdir().unwrap();
    let group = group(folder.path());
    let [swc, lsys] = ["best.swc", "best.lsys"].map(|name| folder.path().join(name));
    let mut command = abstracted(&group, "500");
    command.args(["--variants", "2", "--json"]);
    let (good, printed, said) = output(
        command
            .arg("--export")
            .arg(&swc)
            .arg("--grammar")
            .arg(&lsys),
    );
    assert!(good, "{said}");
    let told: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(told["models"], 3);
    // Three branches each; lengths of the third 1.6 times as large.
    assert_eq!(told["target"]["counts"]["centerlines"], 2);
    assert_eq!(told["target"]["counts"]["branches"], 3);
    let measured = |path: &Path| -> Value {
        let (_, printed, _) = output(ramus().arg("analyze").arg(path).arg("--json"));
        serde_json::from_str(&printed).unwrap()
    };
    let one = measured(&group.join("a.swc"))["table"]["branch_length"]["mean"]
        .as_f64()
        .unwrap();
    let mean = told["target"]["table"]["branch_length"]["mean"]
        .as_f64()
        .unwrap();
    assert!((mean / one - 3.6 / 3.0).abs() < 1e-5, "{mean} {one}");
    let variants = told["variants"].as_array().unwrap();
    assert_eq!(variants.len(), 2);
    for (number, variant) in (1..).zip(variants) {
        let at = |ending: &str| folder.path().join(format!("best-{number}.{ending}"));
        let tips = &measured(&at("swc"))["counts"]["tips"];
        assert_eq!(tips, &variant["counts"]["centerlines"], "variant {number}");
        let grammar = fs::read_to_string(at("lsys")).unwrap();
        let seed = variant["seed"].as_u64().unwrap();
        assert!(grammar.contains(&seed.to_string()), "{seed}: {grammar}");
    }
    assert!(!folder.path().join("best-3.swc").exists() && swc.exists());
    // The same models as a list, one of which fails: told, and left out.
    write(folder.path(), "group/bad.swc", "no skeleton");
    let list = write(
        folder.path(),
        "group.csv",
        "group/a.swc\ngroup/b.swc\ngroup/c.swc\ngroup/bad.swc\n",
    );
    let (good, printed, said) = output(&mut abstracted(&list, "500"));
    assert!(good && said.contains("bad.swc failed"), "{said}");
    assert!(
        printed.contains("(3 models together): 500 trees drawn"),
        "{printed}"
    );
    // A variant is never written over what it is made from.
    let source = write(folder.path(), "kin-1.swc", &tree(1.0, 20.0));
    let mut command = abstracted(&source, "50");
    let (good, _, said) = output(
        command
            .args(["--variants", "1", "--export"])
            .arg(folder.path().join("kin.swc")),
    );
    assert!(!good && said.contains("would be overwritten"), "{said}");
}

#[test]
fn what_cannot_be_abstracted_is_said_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| write(folder.path(), name, text);
    let line = "1 3 0 0 0 1 -1\n2 3 0 9 0 1 1\n";
    let few = r#"{"format": "ramus-table/1", "counts": {"centerlines": 3}, "table": {}}"#;
    for (path, part) in [
        (folder.path().join("missing.json"), "check that it is there"),
        (folder.path().join("missing.ply"), "cannot be read"),
        (at("empty.json", ""), "it is no table"),
        (at("few.json", few), "how long branches are"),
        (at("line.swc", line), "there are no forks"),
        (
            at("empty/notes.md", "").parent().unwrap().to_owned(),
            "has no models",
        ),
        (at("empty.csv", ""), "has no models"),
        (at("notes.txt", "a tree"), "notes.txt"),
    ] {
        let (good, printed, said) = output(&mut abstracted(&path, "50"));
        assert!(!good && printed.is_empty(), "{}", path.display());
        assert!(said.starts_with("ramus: ") && said.contains(part), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    // A name that is refused is refused before any work.
    let (good, _, said) = output(abstracted(Path::new(DUCT), "50").args(["--grammar", "best.txt"]));
    assert!(!good && said.contains(".lsys"), "{said}");
}
