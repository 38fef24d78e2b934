//! `ramus cohort` on analyses that are there already: what is wrong with them, and what they do not tell; and lines that are capped.

use serde_json::Value;

use super::cohort::{cohort, json, tree, write};
use super::*;

#[test]
fn files_of_analyses_that_are_none_fail_alone() {
    let folder = folder();
    let good = write(folder.path(), "t.swc", &tree(1.0, 20.0));
    let good = succeed(ramus().arg("analyze").arg(good).arg("--json"));
    let table: Vec<(&str, String, &str)> = vec![
        ("cut", good[..good.len() / 2].to_owned(), "is no analysis"),
        (
            "older",
            good.replace("\"branches_vmtk\":", "\"was\":"),
            "branches by VMTK's definition are missing; write it anew",
        ),
        (
            "half",
            good.replace("\"table_vmtk\":", "\"table_vmtk\":null,\"was\":"),
            "has one half of what VMTK's definition tells",
        ),
        (
            "more",
            good.replace(
                "\"counts_vmtk\":{\"branches\":3",
                "\"counts_vmtk\":{\"branches\":9",
            ),
            "says that there are 9 branches of VMTK, and has 3",
        ),
        ("deep", "[".repeat(100_000), "is no analysis"),
        ("list", "[]".to_owned(), "is no analysis"),
        (
            "other",
            good.replace("ramus-analysis/1", "ramus-analysis/9"),
            "its format is not ramus-analysis/1",
        ),
        (
            "huge",
            good.replacen("\"mean\":", "\"mean\":1e999,\"a\":", 1),
            "is no analysis",
        ),
        (
            "count",
            good.replace("\"branches\":3", "\"branches\":4"),
            "says that there are 4 branches, and has 3",
        ),
        (
            "loop",
            good.replace("\"id\":1,\"parent\":0", "\"id\":1,\"parent\":1"),
            "before its parent",
        ),
        (
            "nobody",
            good.replacen("\"file\":\"", "\"file\":\"\",\"was\":\"", 1),
            "does not say of which file",
        ),
        (
            "part",
            "{\"format\":\"ramus-analysis/1\",\"model\":{\"file\":\"x\"}}".to_owned(),
            "branches are missing",
        ),
        (
            "long",
            format!(
                "{{\"format\":\"ramus-analysis/1\",\"model\":{{\"file\":\"{}\"}}}}",
                "x".repeat(99_999)
            ),
            "has a text of more than",
        ),
    ];
    let mut list = String::new();
    for (name, text, _) in &table {
        assert!(*text != good, "{name}");
        write(folder.path(), &format!("{name}.json"), text);
        list += &format!("{name}.json\n");
    }
    write(folder.path(), "good.json", &good);
    let list = write(folder.path(), "list.txt", &(list + "good.json\nnone.swc\n"));
    let out = folder.path().join("out");
    let output = cohort(&list, &out).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output.stderr);
    assert!(
        said.contains("14 of 15 models could not be analyzed"),
        "{said}"
    );
    let rows = json(&out.join("models.json"));
    for (name, _, expected) in table {
        let row = rows
            .iter()
            .find(|row| row["model"] == format!("{name}.json"))
            .unwrap();
        let reason = row["failed"].as_str().unwrap();
        assert!(
            reason.contains(expected) && reason.lines().count() == 1 && reason.len() < 400,
            "{name}: {reason}"
        );
    }
    let none = rows.iter().find(|row| row["model"] == "none.swc").unwrap();
    assert!(
        none["failed"].as_str().unwrap().ends_with(": none.swc"),
        "{none}"
    );
    let good = rows.iter().find(|row| row["model"] == "t.swc").unwrap();
    assert_eq!(
        (good["branches"].as_u64(), &good["failed"]),
        (Some(3), &Value::Null)
    );
    assert_eq!(json(&out.join("branches.json")).len(), 6);
}

#[test]
fn where_vmtks_definition_tells_nothing_nothing_stands() {
    let folder = folder();
    let models = folder.path().join("models");
    for name in ["has.json", "none.json"] {
        let model = write(
            folder.path(),
            &name.replace("json", "swc"),
            &tree(1.0, 20.0),
        );
        let told = succeed(ramus().arg("analyze").arg(model).arg("--json"));
        let mut told: Value = serde_json::from_str(&told).unwrap();
        if name == "none.json" {
            for key in ["table_vmtk", "counts_vmtk"] {
                told[key] = Value::Null;
            }
            for key in ["branches_vmtk", "junctions_vmtk"] {
                told[key] = Value::Array(Vec::new());
            }
        }
        write(&models, name, &told.to_string());
    }
    let out = folder.path().join("out");
    let list = write(&models, "list.txt", "has.json\nnone.json\n");
    let said = succeed(&mut cohort(&list, &out));
    assert!(
        said.contains("2 models, 6 branches, 3 by VMTK's definition"),
        "{said}"
    );
    let rows = json(&out.join("models.json"));
    let columns: Vec<&String> = rows[0].as_object().unwrap().keys().collect();
    let mut of_vmtk = 0;
    for column in columns {
        let [has, none] = [&rows[0][column], &rows[1][column]];
        match column.as_str() {
            "model" => {}
            "definitions" => assert_eq!(
                (has.as_str(), none.as_str()),
                (Some("whole and vmtk"), Some("whole"))
            ),
            _ if column.starts_with("vmtk_") => {
                assert!(none.is_null(), "{column}: {none}");
                of_vmtk += 1;
            }
            _ => assert_eq!(has, none, "{column}"),
        }
    }
    assert!(of_vmtk > 40 && rows[0]["vmtk_branch_length_mean"].is_number());
    // Which definition each column follows is told.
    for row in csv::Reader::from_path(out.join("columns.csv"))
        .unwrap()
        .into_records()
    {
        let row = row.unwrap();
        let expected = match &row[1] {
            name if name.starts_with("vmtk_") => "vmtk",
            "branches" | "tips" if &row[0] == "models" => "whole",
            "branch_length_mean" | "strahler_max" | "total_length" => "whole",
            "triangles" | "centerlines" | "length" | "definition" => "",
            _ => continue,
        };
        assert_eq!(&row[4], expected, "{row:?}");
    }
}

#[test]
fn lines_of_surfaces_are_capped_on_request() {
    let folder = folder();
    let models = folder.path().join("models");
    write(&models, "tube.obj", &analyze::tube());
    write(&models, "tree.swc", &tree(1.0, 20.0));
    let [plain, capped] = ["plain", "capped"].map(|name| folder.path().join(name));
    succeed(&mut cohort(&models, &plain));
    succeed(cohort(&models, &capped).arg("--cap"));
    let [plain, capped] = [plain, capped].map(|out| json(&out.join("models.json")));
    assert_eq!(plain[0], capped[0], "a skeleton has no open ends");
    assert_eq!(
        (&plain[1]["capped"], &capped[1]["capped"]),
        (&0.into(), &2.into())
    );
    let one = succeed(
        ramus()
            .arg("analyze")
            .arg(models.join("tube.obj"))
            .args(["--cap", "--json"]),
    );
    let one: Value = serde_json::from_str(&one).unwrap();
    assert_eq!(capped[1]["total_length"], one["branches"][0]["length"]);
    assert!(capped[1]["total_length"].as_f64() > plain[1]["total_length"].as_f64());
}
