//! `ramus compare`: what it says of trees that are the same, alike and different, and of what cannot be compared.

use std::path::PathBuf;

use serde_json::Value;

use super::cohort::{tree, write};
use super::*;

const GRAMMARS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/grammars");

fn compare(files: &[&Path]) -> Command {
    let mut command = ramus();
    command.arg("compare").args(files);
    command
}

fn output(command: &mut Command) -> (bool, String, String) {
    let done = command.output().unwrap();
    (
        done.status.success(),
        text(&done.stdout),
        text(&done.stderr),
    )
}

fn told(files: &[&Path]) -> Value {
    serde_json::from_str(&succeed(compare(files).arg("--json"))).unwrap()
}

fn verdict(files: &[&Path]) -> (String, String) {
    let told = told(files);
    let verdict = &told["pairs"][0]["verdict"];
    let of = |name: &str| verdict[name].as_str().unwrap().to_owned();
    (of("kind"), of("words"))
}

/// A skeleton of so many generations of forks, drawn by a seed: branches that much shorter from one to the next, `spread` apart.
fn plant(generations: u32, spread: f64, seed: u64) -> Vec<(i64, [f64; 3])> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut draw = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        f64::from(u32::try_from(state >> 33).unwrap()) / f64::from(1_u32 << 31)
    };
    let mut nodes = vec![(-1, [0.0; 3]), (1, [0.0, 40.0, 0.0])];
    let mut tips = vec![(2_i64, 0.0_f64, 0.0_f64, 30.0)];
    for _ in 0..generations {
        let mut next = Vec::new();
        for (at, lean, turn, length) in tips {
            for side in [-1.0, 1.0] {
                let length = length * (0.8 + 0.4 * draw());
                let (lean, turn) = (
                    lean + side * spread * (0.7 + 0.6 * draw()),
                    turn + 2.4 * draw(),
                );
                let [x, y, z] = nodes[usize::try_from(at).unwrap() - 1].1;
                let step = [lean.sin() * turn.cos(), lean.cos(), lean.sin() * turn.sin()]
                    .map(|part| part * length);
                nodes.push((at, [x + step[0], y + step[1], z + step[2]]));
                next.push((
                    i64::try_from(nodes.len()).unwrap(),
                    lean,
                    turn,
                    0.8 * length,
                ));
            }
        }
        tips = next;
    }
    nodes
}

/// As SWC, each place brought somewhere else, and so many times as thick.
fn swc(nodes: &[(i64, [f64; 3])], thick: f64, to: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let row = |(number, (parent, at)): (usize, &(i64, [f64; 3]))| {
        let [x, y, z] = to(*at);
        let radius = thick * (3.0 - 0.01 * number as f64);
        format!("{} 3 {x} {y} {z} {radius} {parent}\n", number + 1)
    };
    nodes.iter().enumerate().map(row).collect()
}

struct Plants {
    folder: TempDir,
}

impl Plants {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let one = plant(4, 0.5, 1);
        let place = |name: &str, text: &str| write(folder.path(), name, text);
        place("one.swc", &swc(&one, 1.0, |at| at));
        place(
            "moved.swc",
            &swc(&one, 1.0, |[x, y, z]| [x + 90.0, y - 4.0, z]),
        );
        place("turned.swc", &swc(&one, 1.0, |[x, y, z]| [z, x, y]));
        place("mirrored.swc", &swc(&one, 1.0, |[x, y, z]| [-x, y, z]));
        place("twice.swc", &swc(&one, 2.0, |at| at.map(|part| 2.0 * part)));
        place("sister.swc", &swc(&plant(4, 0.5, 2), 1.0, |at| at));
        place("wide.swc", &swc(&plant(4, 1.1, 3), 1.0, |at| at));
        place("large.swc", &swc(&plant(6, 0.5, 4), 1.0, |at| at));
        // Siblings in the other order: the rows of the last generation backwards.
        let mut other: Vec<String> = swc(&one, 1.0, |at| at).lines().map(str::to_owned).collect();
        let last = other.len() - 16;
        other[last..].reverse();
        place("siblings.swc", &(other.join("\n") + "\n"));
        Self { folder }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

#[test]
fn verdicts_are_what_a_person_would_say() {
    let plants = Plants::new();
    let one = plants.at("one.swc");
    for (other, kind, words) in [
        ("one.swc", "same", "the same tree at the same place"),
        ("siblings.swc", "same", "the same tree at the same place"),
        ("moved.swc", "same", "the same tree at another place"),
        ("turned.swc", "same", "the same tree turned"),
        ("mirrored.swc", "same", "the same tree mirrored"),
        ("twice.swc", "same", "the same tree 2.00 times as large"),
        ("sister.swc", "same_kind", "of the same kind"),
        (
            "wide.swc",
            "different",
            "bifurcation angle is larger in the second",
        ),
        ("large.swc", "different", "31 and 127 branches"),
    ] {
        let found = verdict(&[&one, &plants.at(other)]);
        assert_eq!(found.0, kind, "{other}: {found:?}");
        assert!(found.1.contains(words), "{other}: {found:?}");
    }
}

#[test]
fn the_same_tree_is_no_distance_away_and_a_scaled_one_only_in_size() {
    let plants = Plants::new();
    let [one, twice] = ["one.swc", "twice.swc"].map(|name| plants.at(name));
    let number = |value: &Value| value.as_f64().unwrap();
    let same = &told(&[&one, &one])["pairs"][0];
    for way in ["path", "radial"] {
        assert_eq!(number(&same["topology"]["tmd"][way]["wasserstein"]), 0.0);
        assert!(number(&same["topology"]["tmd"][way]["sliced_wasserstein"]) < 1e-9);
    }
    assert_eq!(same["topology"]["edits"]["branches"], 0);
    assert!(number(&same["space"]["as_is"]["max"]) < 1e-9);
    for (name, difference) in same["differences"].as_object().unwrap() {
        assert!(
            difference["relative"].is_null() || number(&difference["relative"]) == 0.0,
            "{name}"
        );
    }
    let scaled = &told(&[&one, &twice])["pairs"][0];
    assert!((number(&scaled["scale"]) - 2.0).abs() < 1e-5);
    // As they are, most bars of the second are beyond all of the first.
    let path = &scaled["topology"]["tmd"]["path"];
    assert!(number(&path["share"]) > 0.5, "{path}");
    assert!(number(&path["scale_free"]["share"]) < 1e-5);
    for (name, power) in [
        ("total_length", 1),
        ("total_volume", 3),
        ("bifurcation_angle_deg_mean", 0),
    ] {
        let difference = &scaled["differences"][name];
        let expected = 2.0_f64.powi(power) - 1.0;
        assert!(
            (number(&difference["relative"]) - expected).abs() < 1e-3,
            "{difference}"
        );
        assert!(
            number(&difference["relative_scale_free"]).abs() < 1e-3,
            "{difference}"
        );
    }
    assert!(number(&scaled["space"]["fitted"]["max_of_reach"]) < 1e-3);
    assert!((number(&scaled["space"]["fitted"]["scale"]) - 0.5).abs() < 1e-3);
}

#[test]
fn several_trees_are_told_pair_by_pair_and_always_the_same() {
    let plants = Plants::new();
    let files = ["one.swc", "sister.swc", "wide.swc"].map(|name| plants.at(name));
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let once = |threads: &str| {
        succeed(
            compare(&files)
                .arg("--json")
                .env("RAYON_NUM_THREADS", threads),
        )
    };
    let first = once("1");
    assert_eq!(first, once("3"));
    assert_eq!(first.lines().count(), 1);
    let told: Value = serde_json::from_str(&first).unwrap();
    assert_eq!(told["format"], "ramus-comparison/1");
    let pairs = told["pairs"].as_array().unwrap();
    let names: Vec<[&str; 2]> = pairs
        .iter()
        .map(|pair| ["a", "b"].map(|side| pair[side].as_str().unwrap()))
        .collect();
    assert_eq!(
        names,
        [
            ["one.swc", "sister.swc"],
            ["one.swc", "wide.swc"],
            ["sister.swc", "wide.swc"]
        ]
    );
    // The triangle's longest side is no longer than both others.
    let far = |pair: usize| {
        pairs[pair]["topology"]["tmd"]["path"]["wasserstein"]
            .as_f64()
            .unwrap()
    };
    assert!(far(1) <= far(0) + far(2) + 1e-9);
    let said = succeed(&mut compare(&files));
    for part in [
        "sister.swc to one.swc: of the same kind",
        "wide.swc to one.swc: different",
        "branch_length_mean",
        "bars without counterpart",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn tables_and_plots_are_written() {
    let plants = Plants::new();
    let [one, wide] = ["one.swc", "wide.swc"].map(|name| plants.at(name));
    let [csv, svg] = ["both.csv", "both.svg"].map(|name| plants.at(name));
    succeed(
        compare(&[&one, &wide])
            .arg("--csv")
            .arg(&csv)
            .arg("--svg")
            .arg(&svg),
    );
    let table = fs::read_to_string(csv).unwrap();
    let mut rows = table.lines();
    assert_eq!(
        rows.next().unwrap(),
        "number,unit,one.swc,wide.swc,wide.swc relative to one.swc"
    );
    assert_eq!(rows.next().unwrap(), "centerlines,,16.0,16.0,0.0");
    assert!(table.contains("\ntotal_volume,length³,"), "{table}");
    let page = fs::read_to_string(svg).unwrap();
    assert!(page.starts_with("<svg ") && page.trim_end().ends_with("</svg>"));
    for part in [
        "Branch length",
        "Barcode of one.swc",
        "told apart",
        "#d55e00",
    ] {
        assert!(page.contains(part), "{part}");
    }
    // Both trees' curves in each of eleven plots.
    assert!(
        page.matches("<polygon").count() >= 16,
        "{}",
        page.matches("<polygon").count()
    );
}

#[test]
fn grammars_sketches_and_surfaces_are_compared_as_trees() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = Path::new(GRAMMARS).join("honda.lsys");
    let grown = folder.path().join("honda.swc");
    succeed(
        ramus()
            .arg("derive")
            .arg(&grammar)
            .arg("--export")
            .arg(&grown),
    );
    assert_eq!(verdict(&[&grammar, &grown]).0, "same");
    let project = folder.path().join("first.ramus");
    succeed(
        ramus()
            .args(["replay", FIRST_TREE])
            .arg("--project")
            .arg(&project),
    );
    let both = told(&[&project, &grammar]);
    assert_eq!(both["trees"][0]["kind"], "project");
    assert_eq!(both["trees"][1]["kind"], "grammar");
    assert_eq!(both["pairs"][0]["verdict"]["kind"], "different");
    // A surface, and the centerline that was found of it.
    let surface = write(folder.path(), "tube.obj", &analyze::tube());
    let [swc, vtp] = ["line.swc", "line.vtp"].map(|name| folder.path().join(name));
    for line in [&swc, &vtp] {
        succeed(
            ramus()
                .arg("analyze")
                .arg(&surface)
                .arg("--export")
                .arg(line),
        );
    }
    for line in [&swc, &vtp] {
        let found = verdict(&[&surface, line]);
        assert_eq!(found.0, "same", "{found:?}");
        assert!(found.1.contains("at the same place"), "{found:?}");
    }
    assert_eq!(told(&[&surface, &swc])["trees"][0]["kind"], "model");
}

#[test]
fn a_picture_shows_both_trees_in_their_colours_and_both_over_each_other() {
    if !can_draw() {
        return;
    }
    let plants = Plants::new();
    let [one, wide] = ["one.swc", "wide.swc"].map(|name| plants.at(name));
    let png = plants.at("both.png");
    succeed(
        compare(&[&one, &wide])
            .arg("--png")
            .arg(&png)
            .args(["--size", "200"]),
    );
    let picture = image::open(&png).unwrap().into_rgb8();
    assert_eq!(picture.width(), 600);
    assert!(picture.height() > 200);
    // Blue on the left, orange in the middle, both on the right; each as far up as the trees' cells go.
    let count = |from: u32, is: fn([i32; 3]) -> bool| {
        let pixels = picture.enumerate_pixels();
        let within =
            pixels.filter(|(x, y, _)| (from..from + 200).contains(x) && (30..210).contains(y));
        within
            .filter(|(.., pixel)| is(pixel.0.map(i32::from)))
            .count()
    };
    let blue = |[r, _, b]: [i32; 3]| b > r + 40;
    let orange = |[r, _, b]: [i32; 3]| r > b + 60;
    assert!(
        count(0, blue) > 100 && count(0, orange) == 0,
        "{} {}",
        count(0, blue),
        count(0, orange)
    );
    assert!(
        count(200, orange) > 100 && count(200, blue) == 0,
        "{} {}",
        count(200, orange),
        count(200, blue)
    );
    assert!(count(400, blue) > 50 && count(400, orange) > 50);
}

#[test]
fn what_cannot_be_compared_is_said_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str, text: &str| write(folder.path(), name, text);
    let good_tree = at("good.swc", &tree(1.0, 20.0));
    let point = at("point.swc", "1 1 0 0 0 1 -1\n");
    let nan = at("nan.swc", "1 1 0 0 0 1 -1\n2 1 NaN 0 0 1 1\n");
    let table = at("table.json", "{\"format\": \"ramus-table/1\"}");
    let blank = at("blank.lsys", "steps 1\naxiom A\nA -> A\n");
    let endless = at("endless.lsys", "axiom F\nF -> FF\n");
    let notes = at("notes.txt", "a tree");
    let broken = at("broken.ramus", "{");
    for (file, part) in [
        (folder.path().join("missing.swc"), "missing.swc"),
        (folder.path().join("missing.lsys"), "cannot read"),
        (folder.path().join("missing.ramus"), "missing.ramus"),
        (point, "has no branch"),
        (nan, "nan.swc"),
        (table, "is no tree"),
        (blank, "has no branch"),
        (endless, "states no number of steps"),
        (notes, "notes.txt"),
        (broken, "broken.ramus"),
    ] {
        let (good, printed, said) = output(&mut compare(&[&good_tree, &file]));
        assert!(!good && printed.is_empty(), "{}", file.display());
        assert!(
            said.starts_with("ramus: ") && said.contains(part),
            "{}: {said}",
            file.display()
        );
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
    // One tree alone, and more than are compared, are refused before any work.
    let (good, _, said) = output(&mut compare(&[&good_tree]));
    assert!(!good && said.contains("2 values"), "{said}");
    let (good, _, said) = output(&mut compare(&[good_tree.as_path(); 13]));
    assert!(!good && said.contains("12 at most"), "{said}");
    let (good, _, said) = output(
        compare(&[&good_tree, &good_tree])
            .arg("--csv")
            .arg(&good_tree),
    );
    assert!(!good && said.contains(".csv"), "{said}");
    let csv = at("a.csv", "");
    let (good, _, said) = output(compare(&[&good_tree, &csv]).arg("--csv").arg(&csv));
    assert!(!good && said.contains("would be overwritten"), "{said}");
}

#[test]
fn different_units_are_remarked_on() {
    let folder = tempfile::tempdir().unwrap();
    // One in metres or so by its size, the other in micrometres.
    let small = write(folder.path(), "small.swc", &tree(0.01, 20.0));
    let large = write(folder.path(), "large.swc", &tree(100.0, 20.0));
    let (good, _, said) = output(&mut compare(&[&small, &large]));
    assert!(good, "{said}");
    let grammar = Path::new(GRAMMARS).join("honda.lsys");
    let (good, _, said) = output(&mut compare(&[&small, &grammar]));
    assert!(good && said.contains("different units"), "{said}");
}

#[test]
fn a_quarter_of_a_million_nodes_are_compared_in_seconds() {
    let folder = tempfile::tempdir().unwrap();
    // A comb: each node of a long stem has a twig.
    let comb = |bend: f64| {
        let mut text = String::from("1 3 0 0 0 1 -1\n");
        let mut stem = 1;
        for number in 0..125_000_u32 {
            let along = f64::from(number);
            let (next, twig) = (2 * number + 2, 2 * number + 3);
            let x = (along * bend).sin() * 50.0;
            text += &format!(
                "{next} 3 {x} {along} 0 1 {stem}\n{twig} 3 {} {along} {} 0.5 {next}\n",
                x + 3.0,
                along % 7.0
            );
            stem = next;
        }
        text
    };
    let one = write(folder.path(), "one.swc", &comb(0.001));
    let other = write(folder.path(), "other.swc", &comb(0.0011));
    let started = std::time::Instant::now();
    let told = told(&[&one, &other]);
    let pair = &told["pairs"][0];
    assert!(pair["topology"]["edits"]["branches"].is_null());
    assert!(pair["topology"]["tmd"]["path"]["wasserstein"].is_null());
    assert!(
        pair["topology"]["tmd"]["path"]["sliced_wasserstein"]
            .as_f64()
            .unwrap()
            > 0.0
    );
    // Far more than it takes on a machine that is busy: against hanging alone.
    assert!(started.elapsed().as_secs() < 300, "{:?}", started.elapsed());
}
