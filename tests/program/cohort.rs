//! `ramus cohort`: several models at once, groups of them compared, and what is said where that cannot be.

use std::collections::BTreeMap;
use std::path::PathBuf;

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use serde_json::Value;

use super::*;

/// A skeleton of a stem and two daughters; `size` scales it, `turn` spreads the daughters.
pub(super) fn tree(size: f64, turn: f64) -> String {
    let nodes = [
        [0.0, 0.0, 0.0, 4.0],
        [0.0, 60.0, 0.0, 3.0],
        [turn, 100.0, 0.0, 2.0],
        [-turn, 90.0, turn / 2.0, 2.0],
    ];
    let row = |(place, [x, y, z, radius]): (usize, [f64; 4])| {
        let parent = [-1, 1, 2, 2][place];
        let [x, y, z, radius] = [x, y, z, radius].map(|number| number * size);
        format!("{} 3 {x} {y} {z} {radius} {parent}\n", place + 1)
    };
    nodes.into_iter().enumerate().map(row).collect()
}

pub(super) fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, text).unwrap();
    path
}

/// Five young trees, five old ones that are larger and wider, and their groups.
fn two_groups(folder: &Path) -> (PathBuf, PathBuf) {
    let mut groups = "model,group\n".to_owned();
    for one in 0..5_u32 {
        let part = f64::from(one) / 10.0;
        write(
            folder,
            &format!("models/young{one}.swc"),
            &tree(1.0 + part, 20.0),
        );
        write(
            folder,
            &format!("models/old{one}.swc"),
            &tree(2.0 + part, 40.0 + part),
        );
        groups += &format!("young{one},young\nold{one}.swc,old\n");
    }
    (folder.join("models"), write(folder, "groups.csv", &groups))
}

pub(super) fn cohort(models: &Path, out: &Path) -> Command {
    let mut command = ramus();
    command.arg("cohort").arg(models).arg("--out").arg(out);
    command
}

pub(super) fn json(path: &Path) -> Vec<Value> {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// The rows of a CSV file by their columns; empty cells are left out.
fn csv_rows(path: &Path) -> Vec<BTreeMap<String, String>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    // No cell here has a comma in it.
    lines
        .map(|line| {
            let cells = names.iter().zip(line.split(','));
            let there = cells.filter(|(_, cell)| !cell.is_empty());
            there
                .map(|(name, cell)| ((*name).to_owned(), cell.to_owned()))
                .collect()
        })
        .collect()
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, fs::read(path).unwrap())
        })
        .collect()
}

#[test]
fn models_and_branches_are_told_in_three_formats_that_agree() {
    let folder = folder();
    let (models, groups) = two_groups(folder.path());
    let out = folder.path().join("new/out");
    let said = succeed(cohort(&models, &out).arg("--groups").arg(&groups));
    assert!(
        said.contains("10 models, 30 branches, 30 by VMTK's definition"),
        "{said}"
    );
    assert!(said.contains("groups: young (5), old (5)"), "{said}");
    let rows = json(&out.join("models.json"));
    assert_eq!(
        (rows.len(), rows[0]["model"].as_str()),
        (10, Some("old0.swc"))
    );
    assert_eq!(
        (rows[0]["group"].as_str(), rows[0]["branches"].as_u64()),
        (Some("old"), Some(3))
    );
    // As `ramus analyze` tells it of one model.
    let one = succeed(
        ramus()
            .arg("analyze")
            .arg(models.join("old0.swc"))
            .arg("--json"),
    );
    let one: Value = serde_json::from_str(&one).unwrap();
    for (column, place) in [
        ("branch_length_mean", "/table/branch_length/mean"),
        ("point_radius_std", "/table/point_radius/std"),
        ("stem_length", "/table/stem_length"),
        (
            "bifurcation_angle_deg_mean",
            "/table/bifurcation_angle_deg/mean",
        ),
        ("tips", "/counts/tips"),
        (
            "bifurcation_angle_in_plane_deg_mean",
            "/table/bifurcation_angle_in_plane_deg/mean",
        ),
        ("vmtk_branches", "/counts_vmtk/branches"),
        ("vmtk_branch_length_mean", "/table_vmtk/branch_length/mean"),
        ("vmtk_stem_length", "/table_vmtk/stem_length"),
        (
            "vmtk_bifurcation_angle_in_plane_deg_mean",
            "/table_vmtk/bifurcation_angle_in_plane_deg/mean",
        ),
    ] {
        assert_eq!(rows[0][column], *one.pointer(place).unwrap(), "{column}");
    }
    let branches = json(&out.join("branches.json"));
    assert_eq!(branches.len(), 60);
    assert_eq!(rows[0]["definitions"], "whole and vmtk");
    let vmtk = one["branches_vmtk"].as_array().unwrap();
    let of_both = [
        ("whole", "id", one["branches"].as_array().unwrap()),
        ("vmtk", "group", vmtk),
    ];
    let of_both = of_both
        .iter()
        .flat_map(|(definition, id, all)| all.iter().map(move |branch| (definition, id, branch)));
    let mut compared = 0;
    for (row, (definition, id, branch)) in branches.iter().zip(of_both) {
        assert_eq!(
            (&row["model"], &row["definition"], &row["id"]),
            (
                &Value::from("old0.swc"),
                &Value::from(*definition),
                &branch[id]
            )
        );
        for (column, place) in [
            ("length", "/length"),
            ("tortuosity", "/tortuosity"),
            ("curvature", "/curvature"),
            ("radius_mean", "/radius/mean"),
            ("upstream", "/upstream"),
        ] {
            let told = branch.pointer(place).unwrap_or(&Value::Null);
            assert_eq!(&row[column], told, "{column} of {definition} {}", row["id"]);
        }
        assert_eq!(row["volume"].is_null(), *definition == "vmtk");
        compared += 1;
    }
    assert_eq!(compared, 6);
    // The branches of both are not the same ones.
    assert!(branches[1]["length"].as_f64() > branches[4]["length"].as_f64());
    for name in ["models", "branches", "comparison"] {
        let rows = json(&out.join(format!("{name}.json")));
        let of_csv = csv_rows(&out.join(format!("{name}.csv")));
        let file = fs::File::open(out.join(format!("{name}.parquet"))).unwrap();
        let parquet = SerializedFileReader::new(file).unwrap();
        let of_parquet: Vec<Value> = parquet
            .get_row_iter(None)
            .unwrap()
            .map(|row| {
                row.unwrap()
                    .get_column_iter()
                    .map(|(name, field)| (name.clone(), value(field)))
                    .collect()
            })
            .collect();
        assert!(rows == of_parquet, "{name}");
        assert_eq!(rows.len(), of_csv.len());
        for (row, cells) in rows.iter().zip(of_csv) {
            for (column, value) in row.as_object().unwrap() {
                let told = match value {
                    Value::Null => None,
                    Value::String(text) => Some(text.clone()),
                    other => Some(other.to_string()),
                };
                let cell = cells.get(column);
                let same = cell == told.as_ref()
                    || cell
                        .zip(told)
                        .is_some_and(|(a, b)| a.parse::<f64>() == b.parse::<f64>());
                assert!(same, "{name}, {column}: {cell:?} and {value}");
            }
        }
        // Every column is explained.
        let explained = csv::Reader::from_path(out.join("columns.csv"))
            .unwrap()
            .into_records()
            .filter(|row| row.as_ref().unwrap()[0] == *name)
            .count();
        assert_eq!(explained, rows[0].as_object().unwrap().len(), "{name}");
    }
}

/// A cell of Parquet as JSON has it.
fn value(field: &parquet::record::Field) -> Value {
    use parquet::record::Field;
    match field {
        Field::Null => Value::Null,
        Field::Bool(yes) => (*yes).into(),
        Field::Long(number) => (*number).into(),
        Field::Double(number) => (*number).into(),
        Field::Str(text) => text.as_str().into(),
        other => panic!("{other:?}"),
    }
}

/// Five against five that are apart: `scipy.stats.mannwhitneyu(range(5), range(5, 10)).pvalue` is 2 / 252, and so is that of `ks_2samp`.
#[test]
fn groups_are_compared_by_models() {
    let folder = folder();
    let (models, groups) = two_groups(folder.path());
    let out = folder.path().join("out");
    succeed(cohort(&models, &out).arg("--groups").arg(&groups));
    let rows = json(&out.join("comparison.json"));
    let of = |measure: &str| rows.iter().find(|row| row["measure"] == measure).unwrap();
    let number = |row: &Value, column: &str| row[column].as_f64().unwrap();
    let length = of("total_length");
    assert_eq!(
        (length["group_a"].as_str(), length["group_b"].as_str()),
        (Some("young"), Some("old"))
    );
    for column in ["mann_whitney_p", "ks_p"] {
        assert!(
            (number(length, column) - 2.0 / 252.0).abs() < 1e-15,
            "{length}"
        );
    }
    assert_eq!(
        (number(length, "mann_whitney_u"), number(length, "ks_d")),
        (0.0, 1.0)
    );
    assert_eq!(
        (
            number(length, "cliffs_delta"),
            length["mann_whitney_method"].as_str()
        ),
        (-1.0, Some("exact"))
    );
    assert!(number(length, "hedges_g") < -2.0 && length["cliffs_delta_size"] == "large");
    assert!(number(length, "median_a") < number(length, "median_b"));
    // Each row says of which branches it is, and both definitions are compared and count in the corrections.
    for (measure, definition) in [
        ("branch_length_mean", Some("whole")),
        ("vmtk_branch_length_mean", Some("vmtk")),
    ] {
        assert_eq!(of(measure)["definition"].as_str(), definition);
        assert_eq!(
            (&of(measure)["tested"], number(of(measure), "cliffs_delta")),
            (&Value::from(true), -1.0)
        );
    }
    assert!(
        !rows
            .iter()
            .any(|row| row["measure"] == "vmtk_centerline_length_mean")
    );
    // What is the same in all is not tested, and costs the others nothing.
    let tips = of("tips");
    assert!(tips["mann_whitney_p"].is_null() && tips["tested"] == false);
    assert_eq!(tips["remark"], "not tested: it is the same in all models");
    let tested: Vec<&Value> = rows.iter().filter(|row| row["tested"] == true).collect();
    let smallest = tested
        .iter()
        .map(|row| number(row, "mann_whitney_p"))
        .fold(1.0, f64::min);
    let holm = (smallest * tested.len() as f64).min(1.0);
    assert!(
        (number(length, "mann_whitney_p_holm") - holm).abs() < 1e-15,
        "{length}"
    );
    assert!(number(length, "mann_whitney_p_bh") <= holm);
    for picture in ["models.svg", "branches.svg"] {
        let text = fs::read_to_string(out.join(picture)).unwrap();
        assert!(
            text.starts_with("<svg")
                && text.contains(">young</text>")
                && text.ends_with("</svg>\n")
        );
    }
    let text = fs::read_to_string(out.join("models.svg")).unwrap();
    assert!(
        text.contains(">Total length (µm)</text>") && text.contains("δ = −1.00, p = "),
        "{text}"
    );
}

#[test]
fn neither_threads_nor_the_order_of_a_list_nor_files_of_analyses_change_a_byte() {
    let folder = folder();
    let (models, groups) = two_groups(folder.path());
    // A surface, too, with its endpoints beside it, and one without.
    write(&models, "tube.obj", &analyze::tube());
    write(
        &models,
        "tube.endpoints.csv",
        "kind,x,y,z\nsource,0,0,0\ntarget,40,0,0\n",
    );
    write(&models, "other.obj", &analyze::tube());
    write(&models, "broken.obj", "v 1 2\n");
    let run = |models: &Path, name: &str, threads: &str| {
        let out = folder.path().join(name);
        let mut command = cohort(models, &out);
        command
            .arg("--groups")
            .arg(&groups)
            .env("RAYON_NUM_THREADS", threads);
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
        assert!(text(&output.stderr).contains("1 of 13 models could not be analyzed"));
        files(&out)
    };
    let first = run(&models, "one", "1");
    assert_eq!(first.len(), 12, "{:?}", first.keys());
    assert!(first == run(&models, "many", "7"));
    let rows = json(&folder.path().join("one/models.json"));
    let of = |name: &str| rows.iter().find(|row| row["model"] == name).unwrap();
    assert_eq!(
        (&of("tube.obj")["automatic"], &of("other.obj")["automatic"]),
        (&Value::from(false), &Value::from(true))
    );
    let reason = of("broken.obj")["failed"].as_str().unwrap();
    assert!(
        reason.contains("broken.obj") && !reason.contains('/'),
        "{reason}"
    );
    assert!(of("broken.obj")["branches"].is_null() && of("tube.obj")["failed"].is_null());
    // What --plan prints is a list that is read alike, from its end, too.
    let plan = succeed(ramus().arg("cohort").arg(&models).arg("--plan"));
    let mut lines: Vec<&str> = plan.lines().skip(1).collect();
    lines.reverse();
    assert_eq!(lines.len(), 13);
    let list = write(
        folder.path(),
        "list.csv",
        &format!("{}\n{}\n", "path,endpoints,source", lines.join("\n")),
    );
    assert!(first == run(&list, "listed", "2"));
    // Each model as a job of its own, as a cluster does it.
    let analyses = folder.path().join("analyses");
    fs::create_dir(&analyses).unwrap();
    for (place, line) in lines.iter().enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let mut command = ramus();
        command.arg("analyze").arg(cells[0]).arg("--json");
        if !cells[1].is_empty() {
            command.arg("--targets").arg(cells[1]);
        }
        let output = command.output().unwrap();
        let told = match output.status.success() {
            true => text(&output.stdout),
            false => serde_json::json!({
                "format": "ramus-analysis/1",
                "model": {"file": cells[0]},
                "failed": text(&output.stderr).trim_end().strip_prefix("ramus: ").unwrap(),
            })
            .to_string(),
        };
        write(&analyses, &format!("{place}.json"), &told);
    }
    write(
        &analyses,
        "other.json",
        "{\"format\":\"ramus-endpoints/1\",\"endpoints\":[]}",
    );
    assert!(first == run(&analyses, "joined", "2"));
}

#[test]
fn small_groups_and_many_are_told_what_they_can_be() {
    let folder = folder();
    let (models, _) = two_groups(folder.path());
    let out = folder.path().join("out");
    let run = |groups: &str| {
        let groups = write(folder.path(), "g.csv", groups);
        let output = cohort(&models, &out)
            .arg("--groups")
            .arg(&groups)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        (json(&out.join("comparison.json")), text(&output.stderr))
    };
    // Three groups have three pairs; one of them has one model.
    let (rows, said) =
        run("model,group\nyoung0,a\nyoung1,a\nold0,b\nold1,b\nold2,<c>&\nnobody,a\n");
    let length: Vec<&Value> = rows
        .iter()
        .filter(|row| row["measure"] == "total_length")
        .collect();
    let pairs: Vec<_> = length
        .iter()
        .map(|row| {
            (
                row["group_a"].as_str().unwrap(),
                row["group_b"].as_str().unwrap(),
            )
        })
        .collect();
    assert_eq!(pairs, [("a", "b"), ("a", "<c>&"), ("b", "<c>&")]);
    assert!((length[0]["mann_whitney_p"].as_f64().unwrap() - 1.0 / 3.0).abs() < 1e-15);
    assert_eq!(
        length[1]["remark"],
        "not tested: one model of <c>& alone has it"
    );
    assert!(
        length[1]["n_b"] == 1 && length[1]["median_b"].is_number() && length[1]["ks_p"].is_null()
    );
    assert!(
        said.contains("there is no model nobody") && said.contains("young4.swc is of no group"),
        "{said}"
    );
    let picture = fs::read_to_string(out.join("models.svg")).unwrap();
    assert!(
        picture.contains("&lt;c&gt;&amp;") && !picture.contains("<c>"),
        "{picture}"
    );
    // One group has nothing to be compared with, and no group none at all.
    let (rows, said) = run("model,group\nyoung0,a\n");
    assert!(
        rows.is_empty() && said.contains("there is one group alone"),
        "{said}"
    );
    succeed(&mut cohort(&models, &out));
    assert!(!out.join("comparison.csv").exists(), "of an older run");
    assert!(
        json(&out.join("models.json"))
            .iter()
            .all(|row| row["group"].is_null())
    );
    let explained = fs::read_to_string(out.join("columns.csv")).unwrap();
    assert!(!explained.contains("comparison"), "{explained}");
}

#[test]
fn models_of_the_same_name_are_told_apart_by_their_folders() {
    let folder = folder();
    for name in ["1/a.swc", "2/a.swc"] {
        write(folder.path(), name, &tree(1.0, 20.0));
    }
    let list = write(folder.path(), "list.txt", "2/a.swc\n1/a.swc\n");
    let groups = write(
        folder.path(),
        "g.csv",
        "model,group\n1/a.swc,x\n2/a.swc,y\n",
    );
    let out = folder.path().join("out");
    succeed(cohort(&list, &out).arg("--groups").arg(&groups));
    let rows = json(&out.join("models.json"));
    let told: Vec<_> = rows
        .iter()
        .map(|row| {
            (
                row["model"].as_str().unwrap(),
                row["group"].as_str().unwrap(),
            )
        })
        .collect();
    assert_eq!(told, [("1/a.swc", "x"), ("2/a.swc", "y")]);
    // The same stem twice is no fault where nobody calls a model by it.
    let both = folder.path().join("both");
    write(&both, "a.swc", &tree(1.0, 20.0));
    write(&both, "a.obj", &analyze::tube());
    succeed(&mut cohort(&both, &out));
    let output = cohort(&both, &out)
        .arg("--groups")
        .arg(write(folder.path(), "g.csv", "model,group\na,x\n"))
        .output()
        .unwrap();
    refused(
        &output,
        &["g.csv, line 2: a stands for 2 models, a.obj and a.swc"],
    );
}

#[test]
fn what_cannot_be_a_cohort_is_said_in_one_sentence() {
    let folder = folder();
    let (models, groups) = two_groups(folder.path());
    let file = |name: &str, text: &str| write(folder.path(), name, text);
    let empty = folder.path().join("empty");
    fs::create_dir(&empty).unwrap();
    let out = folder.path().join("out");
    let model = models.join("old0.swc");
    let taken = file("taken", "");
    write(folder.path(), "twice/a.swc", &tree(1.0, 20.0));
    write(folder.path(), "twice/a.endpoints.csv", "x,y,z\n");
    write(folder.path(), "twice/a.endpoints.json", "{}");
    let own = file("own/models.csv", "../models/old0.swc\n");
    let table: Vec<(PathBuf, &Path, Option<PathBuf>, &str)> = vec![
        (
            folder.path().join("none"),
            &out,
            None,
            "none cannot be read",
        ),
        (empty, &out, None, "has no models"),
        (file("list.txt", "# nothing\n"), &out, None, "has no models"),
        (
            file("bad.txt", "a.obj,,1 2\n"),
            &out,
            None,
            "bad.txt: line 1: the source",
        ),
        (
            file("again.txt", "models/old0.swc\nmodels/../models/old0.swc\n"),
            &out,
            None,
            "old0.swc is there twice",
        ),
        (
            model.clone(),
            &out,
            None,
            "is a model: `ramus analyze` measures one",
        ),
        (folder.path().join("twice"), &out, None, "both lie beside"),
        (models.clone(), &taken, None, "taken is no folder"),
        (
            own.clone(),
            own.parent().unwrap(),
            None,
            "would be overwritten",
        ),
        (
            models.clone(),
            &out,
            Some(folder.path().join("no.csv")),
            "no.csv cannot be read",
        ),
        (models.clone(), &out, Some(models.clone()), "is no file"),
        (
            models.clone(),
            &out,
            Some(file("g1.csv", "a,b\n")),
            "g1.csv: the column model is missing",
        ),
        (
            models.clone(),
            &out,
            Some(file("g2.csv", "model,group\nx,y\n")),
            "g2.csv names none of the models",
        ),
        (
            models.clone(),
            &out,
            Some(file("g3.csv", "model,group\nold0,y\nold0.swc,x\n")),
            "g3.csv, line 3: old0.swc is of two groups",
        ),
    ];
    for (models, out, groups, expected) in table {
        let mut command = cohort(&models, out);
        if let Some(groups) = &groups {
            command.arg("--groups").arg(groups);
        }
        let output = command.output().unwrap();
        refused(&output, &[expected]);
        assert!(!out.join("models.json").exists());
    }
    for args in [
        &["--out", "x", "--plan"][..],
        &[],
        &["--plan", "--groups", groups.to_str().unwrap()],
        &["--plan", "--cap"],
    ] {
        let output = ramus()
            .arg("cohort")
            .arg(&models)
            .args(args)
            .output()
            .unwrap();
        assert_eq!(
            output.status.code(),
            Some(2),
            "{args:?}: {}",
            text(&output.stderr)
        );
    }
}
