//! `ramus abstract --exact`: a tree as a grammar that draws it again.

use serde_json::Value;

use super::cohort::{tree, write};
use super::*;

fn exact(model: &Path, tolerance: &str) -> Command {
    let mut command = ramus();
    command
        .arg("abstract")
        .arg(model)
        .args(["--exact", tolerance]);
    command
}

fn told(command: &mut Command) -> Value {
    serde_json::from_str(&succeed(command.arg("--json"))).unwrap()
}

/// Nodes of an SWC file: place, radius and how many nodes grow from it.
fn nodes(path: &Path) -> Vec<([f64; 3], f64, usize)> {
    let text = fs::read_to_string(path).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| {
            line.split_whitespace()
                .map(|word| word.parse().unwrap())
                .collect()
        })
        .collect();
    rows.iter()
        .map(|row| {
            let children = rows.iter().filter(|other| (other[6] - row[0]).abs() < 0.5);
            ([row[2], row[3], row[4]], row[5], children.count())
        })
        .collect()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

#[test]
fn hondas_tree_gives_hondas_grammar_which_grows_it_again() {
    let folder = folder();
    let [grown, grammar, again, exported, curve] = [
        "grown.swc",
        "found.lsys",
        "again.swc",
        "found.swc",
        "curve.svg",
    ]
    .map(|name| folder.path().join(name));
    let derive = |from: &Path, to: &Path| {
        let mut command = ramus();
        command.arg("derive").arg(from).arg("--export").arg(to);
        succeed(command.args(["--widths", "metres"]))
    };
    derive(Path::new(HONDA), &grown);
    let told = told(
        exact(&grown, "0.1%")
            .arg("--grammar")
            .arg(&grammar)
            .arg("--export")
            .arg(&exported)
            .arg("--curve")
            .arg(&curve),
    );
    assert_eq!(told["format"], "ramus-exact/1");
    assert_eq!(told["size"]["productions"], 3);
    assert_eq!(told["segments"]["grammar"], 1023);
    let number = |value: &Value| value.as_f64().unwrap();
    let tolerance = number(&told["tolerance"]);
    assert!((tolerance / number(&told["tree_size"]) - 0.001).abs() < 1e-12);
    for off in ["max", "mean", "radius"] {
        assert!(number(&told["error"][off]) <= tolerance, "{told}");
    }
    let symbols = |of: &Value| number(&of["modules"]) + number(&of["parameters"]);
    assert!(
        symbols(&told["plain"]) > 50.0 * symbols(&told["size"]),
        "{told}"
    );
    let text = fs::read_to_string(&grammar).unwrap();
    assert_eq!(told["grammar"], text.as_str());
    assert_eq!(number(&told["size"]["bytes"]), text.len() as f64);

    // Each point of the curve was measured, and the curve is drawn.
    let points = told["curve"].as_array().unwrap();
    assert!(points.len() >= 9);
    for point in points {
        assert!(number(&point["error"]["max"]) <= number(&point["tolerance"]));
    }
    let drawn = fs::read_to_string(&curve).unwrap();
    assert!(drawn.starts_with("<svg") && drawn.matches("<circle").count() == 2 * points.len());

    // The grammar, derived by the program, grows the tree: as many tips and forks, each in its place.
    derive(&grammar, &again);
    let tree = nodes(&grown);
    for path in [&again, &exported] {
        let drawn = nodes(path);
        assert_eq!(drawn.len(), tree.len());
        for (place, radius, children) in &tree {
            let near = drawn.iter().find(|(other, thick, count)| {
                distance(*place, *other) <= tolerance
                    && (radius - thick).abs() <= tolerance
                    && children == count
            });
            assert!(near.is_some(), "{place:?}");
        }
    }
}

#[test]
fn skeletons_grammars_and_projects_are_written_as_grammars() {
    let folder = folder();
    let skeleton = write(folder.path(), "young.swc", &tree(1.0, 20.0));
    let project = folder.path().join("tree.ramus");
    let mut replay = ramus();
    replay
        .args(["replay", FIRST_TREE, "--project"])
        .arg(&project);
    succeed(&mut replay);
    for model in [skeleton.as_path(), Path::new(HONDA), &project] {
        let printed = succeed(&mut exact(model, "1%"));
        let name = format!("{}: a grammar of ", model.display());
        assert!(printed.starts_with(&name), "{printed}");
        assert!(
            printed.contains("\naxiom ") && printed.contains("written out"),
            "{printed}"
        );
        // The same bytes each time.
        let [first, second] = [(), ()].map(|()| {
            let mut told = told(&mut exact(model, "1%"));
            told["seconds"] = Value::Null;
            told
        });
        assert_eq!(first, second);
    }
}

#[test]
fn what_cannot_be_written_exactly_is_said_in_a_sentence() {
    let folder = folder();
    let at = |name: &str, text: &str| write(folder.path(), name, text);
    let line = at("line.swc", "1 3 0 0 0 1 -1\n2 3 0 9 0 1 1\n");
    let table = at("table.json", "{}");
    let leaf = at("leaf.lsys", "axiom ~L\nsteps 0\n");
    let endless = at("endless.lsys", "axiom F\nF -> F F\n");
    let lone = at("lone.swc", "1 3 0 0 0 1 -1\n");
    let missing = folder.path().join("missing.swc");
    for (model, tolerance, part) in [
        (&line, "20", "no smaller than the tree"),
        (&line, "0.0000001", "single precision"),
        (&line, "150%", "no smaller than the tree"),
        (&table, "1%", "a table has no shape"),
        (&leaf, "1%", "no segment"),
        (&endless, "1%", "states no number of steps"),
        (&lone, "1%", "lone.swc"),
        (&missing, "1%", "missing.swc"),
    ] {
        let done = exact(model, tolerance).output().unwrap();
        let said = text(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{said}");
        assert!(said.starts_with("ramus: ") && said.contains(part), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    // Wrong usage.
    for tolerance in ["0", "-1", "nan", "inf", "0%", "much", "", "%"] {
        let done = exact(&line, tolerance).output().unwrap();
        assert_eq!(done.status.code(), Some(2), "{tolerance}");
        assert!(
            text(&done.stderr).contains("a length above 0"),
            "{tolerance}"
        );
    }
    for more in [["--seed", "1"], ["--candidates", "5"], ["--curve", "a.png"]] {
        let done = exact(&line, "1").args(more).output().unwrap();
        assert_eq!(done.status.code(), Some(2), "{more:?}");
    }
    let done = ramus()
        .arg("abstract")
        .arg(&line)
        .arg("--curve")
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(2));
}
