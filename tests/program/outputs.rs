//! Where results go: never over what they are made from, and never lost because nobody listens.

use std::fs;
use std::path::Path;
use std::process::Stdio;

use ramus_xr::session;

use super::{FIRST_TREE, HONDA, folder, ramus, refused, succeed, text};

#[test]
fn nothing_is_written_over_what_it_is_made_from() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("sub")).unwrap();
    for name in ["tree.swc", "tree.png"] {
        fs::copy(HONDA, at(name)).unwrap();
    }
    for name in [
        "tree.session",
        "tree.ramus",
        "other.ramus.journal",
        "step-00.png",
    ] {
        fs::copy(FIRST_TREE, at(name)).unwrap();
    }
    #[cfg(unix)]
    for (real, link) in [("tree.swc", "link.swc"), ("tree.session", "link.session")] {
        std::os::unix::fs::symlink(at(real), at(link)).unwrap();
    }
    let before = |name: &str| fs::read(at(name)).unwrap();
    let cases: &[(&str, &[&str])] = &[
        ("tree.swc", &["derive", "tree.swc", "--export", "tree.swc"]),
        (
            "tree.swc",
            &[
                "derive",
                "tree.swc",
                "--export",
                "good.glb",
                "--export",
                "sub/../tree.swc",
            ],
        ),
        ("tree.png", &["derive", "tree.png", "--png", "./tree.png"]),
        #[cfg(unix)]
        ("tree.swc", &["derive", "tree.swc", "--export", "link.swc"]),
        #[cfg(unix)]
        ("tree.swc", &["derive", "link.swc", "--export", "tree.swc"]),
        (
            "tree.session",
            &["replay", "tree.session", "--project", "tree.session"],
        ),
        (
            "tree.session",
            &["replay", "./tree.session", "--lsys", "sub/../tree.session"],
        ),
        (
            "tree.session",
            &["replay", "tree.session", "--lsys", "tree.session"],
        ),
        #[cfg(unix)]
        (
            "tree.session",
            &["replay", "tree.session", "--lsys", "link.session"],
        ),
        (
            "tree.ramus",
            &["replay", "tree.ramus", "--project", "tree.ramus"],
        ),
        (
            "other.ramus.journal",
            &["replay", "other.ramus.journal", "--project", "other.ramus"],
        ),
        ("step-00.png", &["replay", "step-00.png", "--png", "sub/.."]),
        (
            "tree.ramus",
            &["--project", "tree.ramus", "--record", "./tree.ramus"],
        ),
        ("step-00.png", &["--project", "step-00.png", "--out", "."]),
    ];
    for (input, args) in cases {
        let whole = before(input);
        let output = ramus()
            .current_dir(folder.path())
            .args(*args)
            .output()
            .unwrap();
        refused(&output, &["would be overwritten", "choose another name"]);
        assert!(before(input) == whole, "{args:?} changed its input");
        assert!(!at("good.glb").exists(), "{args:?} wrote before it looked");
    }
    // The absolute path is another spelling of the same.
    let output = ramus()
        .current_dir(folder.path())
        .args(["derive", "tree.swc", "--export"])
        .arg(at("tree.swc"))
        .output()
        .unwrap();
    refused(&output, &["would be overwritten"]);
}

/// A session's end is too late to refuse: the tree of `x.glb` would go to `x.glb`.
#[test]
fn a_project_never_has_the_name_of_what_is_made_from_it() {
    let folder = folder();
    for name in ["tree.glb", "tree.lsys", "out/tree.glb"] {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        succeed(ramus().args(["replay", FIRST_TREE, "--project"]).arg(&path));
        let whole = fs::read(&path).unwrap();
        let output = ramus()
            .current_dir(folder.path())
            .args(["--headset", "simulated", "--project", name])
            .output()
            .unwrap();
        refused(&output, &["would be overwritten", name]);
        assert!(fs::read(&path).unwrap() == whole, "{name}");
    }
}

#[test]
fn two_results_never_share_a_file() {
    let folder = folder();
    for args in [
        &[
            "replay",
            FIRST_TREE,
            "--project",
            "same.obj",
            "--glb",
            "./same.obj",
        ][..],
        &[
            "replay", FIRST_TREE, "--lsys", "same.glb", "--glb", "same.glb",
        ],
        &[
            "replay",
            FIRST_TREE,
            "--png",
            "same",
            "--lsys",
            "same/step-07.png",
        ],
        &[
            "replay",
            FIRST_TREE,
            "--png",
            "same",
            "--project",
            "same/step-100.png",
        ],
        &["--out", "same", "--record", "same/first-tree.ramus"],
        &["--out", "same", "--record", "same/first-tree.ramus.journal"],
        &[
            "--out",
            "same",
            "--record",
            "./same/none/../first-tree.lsys",
        ],
        &["--out", "same", "--record", "same/first-tree.glb"],
        &["--out", "same", "--record", "same/step-03.png"],
        &["--out", "same", "--record", "same/workshop.ramus"],
        &[
            "derive",
            HONDA,
            "--export",
            "same.obj",
            "--export",
            "./same.obj",
        ],
    ] {
        let output = ramus()
            .current_dir(folder.path())
            .args(args)
            .output()
            .unwrap();
        refused(&output, &["two results would be written to", "same"]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{args:?}");
    }
}

/// Files are replaced whole, so another name of the same file keeps the old text.
#[cfg(unix)]
#[test]
fn a_hard_link_to_the_input_leaves_the_input() {
    let folder = folder();
    let [grammar, link] = ["tree.lsys", "link.swc"].map(|name| folder.path().join(name));
    fs::copy(HONDA, &grammar).unwrap();
    fs::hard_link(&grammar, &link).unwrap();
    succeed(
        ramus()
            .arg("derive")
            .arg(&grammar)
            .arg("--export")
            .arg(&link),
    );
    assert!(fs::read(&grammar).unwrap() == fs::read(HONDA).unwrap());
    assert!(ramus::tree::import::swc(&fs::read(&link).unwrap()).is_ok());
}

#[test]
fn a_recording_never_goes_over_an_existing_file() {
    if !super::can_draw() {
        return;
    }
    let folder = folder();
    let mine = folder.path().join("mine.session");
    fs::copy(FIRST_TREE, &mine).unwrap();
    let output = ramus()
        .current_dir(folder.path())
        .arg("--record")
        .arg(&mine)
        .output()
        .unwrap();
    refused(
        &output,
        &["cannot record the session into", "mine.session", "exists"],
    );
    assert!(fs::read(&mine).unwrap() == fs::read(FIRST_TREE).unwrap());
}

/// A pipe whose reader leaves is no fault, and ends no work.
#[test]
fn nobody_needs_to_read_to_the_end() {
    let folder = folder();
    let grammar = folder.path().join("long.lsys");
    fs::write(&grammar, "axiom F\nF -> FF\n").unwrap();
    let glb = folder.path().join("tree.glb");
    let mut child = ramus()
        .arg("derive")
        .arg(&grammar)
        .args(["--steps", "20", "--print", "string", "--memory", "512"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 8];
    std::io::Read::read_exact(child.stdout.as_mut().unwrap(), &mut first).unwrap();
    assert_eq!(&first, b"FFFFFFFF");
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "");
    // The same where there is more to do than to print.
    let mut child = ramus()
        .arg("derive")
        .arg(&grammar)
        .args(["--steps", "9", "--print", "string", "--export"])
        .arg(&glb)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    assert!(gltf::Gltf::from_slice(&fs::read(&glb).unwrap()).is_ok());
    // And a session's remarks.
    let project = folder.path().join("tree.ramus");
    let mut child = ramus()
        .args(["replay", FIRST_TREE, "--project"])
        .arg(&project)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    assert!(project.exists());
}

/// What was asked for on a full standard output is missed, so it is told; files that were asked for too are there.
#[cfg(target_os = "linux")]
#[test]
fn a_full_output_is_told_after_the_rest_of_the_work() {
    let folder = folder();
    let full = || {
        fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap()
    };
    for (args, what) in [
        (&["--print", "string"][..], "the string"),
        (&["--print", "counts"], "the counts"),
        (&["--json"], "the JSON"),
    ] {
        let output = ramus()
            .current_dir(folder.path())
            .args(["derive", HONDA, "--steps", "3"])
            .args(args)
            .args(["--export", "tree.glb"])
            .stdout(full())
            .output()
            .unwrap();
        let said = format!("standard output does not take {what}");
        refused(&output, &[&said, "No space left"]);
        fs::remove_file(folder.path().join("tree.glb")).unwrap();
    }
    // Remarks are not the result: nobody misses them.
    let output = ramus()
        .current_dir(folder.path())
        .args(["replay", FIRST_TREE, "--project", "tree.ramus"])
        .stdout(full())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(folder.path().join("tree.ramus").exists());
}

/// A session in which nothing was drawn: everything but the tree is made, and the sentence says so.
#[test]
fn a_session_without_a_tree_says_what_was_written_and_what_not() {
    let folder = folder();
    let frames = session::read_file(Path::new(FIRST_TREE)).unwrap();
    let short = folder.path().join("short.session");
    fs::write(&short, session::to_bytes(&frames[..3]).unwrap()).unwrap();
    let output = ramus()
        .current_dir(folder.path())
        .args([
            "replay",
            "short.session",
            "--project",
            "t.ramus",
            "--lsys",
            "t.lsys",
        ])
        .args(["--glb", "t.glb"])
        .output()
        .unwrap();
    refused(&output, &["t.glb was not written", "step 0", "all else"]);
    let said = text(&output.stdout);
    for name in ["t.ramus", "t.lsys"] {
        assert!(said.contains(name), "{said}");
        assert!(folder.path().join(name).exists(), "{name}");
    }
    assert!(!said.contains("t.glb") && !folder.path().join("t.glb").exists());
}

/// JSON has no infinity, and `null` would say that there is no sum.
#[test]
fn a_sum_beyond_all_numbers_is_an_error_in_json_and_text_elsewhere() {
    let folder = folder();
    let grammar = folder.path().join("huge.lsys");
    // The second parameter's sum overflows on the way and is 1e308 at the end.
    fs::write(
        &grammar,
        "axiom A(1e308, 1e308) A(1e308, 1e308) A(1, -1e308)\n",
    )
    .unwrap();
    let derive = |args: &[&str]| {
        ramus()
            .arg("derive")
            .arg(&grammar)
            .args(["--steps", "0"])
            .args(args)
            .output()
            .unwrap()
    };
    refused(
        &derive(&["--json"]),
        &["huge.lsys", "the sum of `A.0`", "1.8e308"],
    );
    let counts = derive(&["--print", "counts"]);
    assert!(
        text(&counts.stdout).contains("A 3 sums inf 1e+308"),
        "{}",
        text(&counts.stdout)
    );
    fs::write(&grammar, "axiom A(1e308) A(1e308) A(-1e308)\n").unwrap();
    let json: serde_json::Value = serde_json::from_slice(&derive(&["--json"]).stdout).unwrap();
    assert_eq!(json["param_sums"]["A.0"], 1e308);
}

/// Where the turtle only moved nothing stands.
#[test]
fn bounds_hold_what_was_drawn_and_nothing_else() {
    let folder = folder();
    let grammar = folder.path().join("gap.lsys");
    fs::write(&grammar, "axiom f(100) F(1) f(50) F(2) f(1000)\n").unwrap();
    let said = succeed(
        ramus()
            .arg("derive")
            .arg(&grammar)
            .args(["--steps", "0", "--json"]),
    );
    let report: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!(
        report["bounds"]["min"],
        serde_json::json!([0.0, 100.0, 0.0])
    );
    assert_eq!(
        report["bounds"]["max"],
        serde_json::json!([0.0, 153.0, 0.0])
    );
    assert_eq!(report["segments"], 2);
    // Such a tree has two roots, and an SWC file one.
    let output = ramus()
        .current_dir(folder.path())
        .args(["derive", "gap.lsys", "--steps", "0", "--export", "gap.swc"])
        .output()
        .unwrap();
    refused(&output, &["3 roots", "drawn with gaps", "GLB or OBJ"]);
}

/// What is counted or told by its growth is not made, and what does not fit is printed all the same.
#[test]
fn a_string_need_not_be_written_down() {
    let folder = folder();
    let path = folder.path();
    let derive = |grammar: &str, args: &[&str]| {
        fs::write(path.join("a.lsys"), grammar).unwrap();
        let mut command = ramus();
        command.current_dir(path).args(["derive", "a.lsys"]);
        let output = command.args(args).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let algae = "axiom b\na -> ab\nb -> a\n";
    assert_eq!(
        derive(algae, &["--steps", "58", "--print", "counts"]),
        "a 591286729879\nb 365435296162\nmodules 956722026041, segments 0, depth 0\n"
    );
    let growth = derive(algae, &["--steps", "180", "--print", "growth"]);
    assert!(growth.starts_with("0 1\n1 1\n2 2\n3 3\n4 5\n"), "{growth}");
    assert!(
        growth.contains("\n179 18547707689471986212190138521399707760\n180 ")
            && growth.lines().count() == 181
    );
    // One that has to be derived.
    let signal = derive(
        "axiom BA A\nB < A -> B B\n",
        &["--steps", "2", "--print", "growth"],
    );
    assert_eq!(signal, "0 3\n1 4\n2 5\n");
    // Lines come as they are known, and nobody waits for those that nobody reads.
    let file = folder.path().join("signal.lsys");
    fs::write(&file, "axiom A B\nA < B -> B\n").unwrap();
    let mut child = ramus()
        .arg("derive")
        .arg(&file)
        .args(["--steps", "4000000000", "--print", "growth"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = [0; 8];
    std::io::Read::read_exact(child.stdout.as_mut().unwrap(), &mut first).unwrap();
    assert_eq!(&first, b"0 2\n1 2\n");
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
    let long = derive(
        "axiom F\nF -> FF\n",
        &["--steps", "20", "--print", "string", "--memory", "1"],
    );
    assert_eq!(long.len(), (1 << 20) + 1);
}

/// Leaves and flowers are in pictures and in GLB and OBJ files, also where there is no segment at all.
#[test]
fn organs_are_written_and_pictured() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(
        at("leaf.lsys"),
        "steps 0\naxiom '(3) {.f.+(120)f.} ~L @O(0.2) ~K\nsurface K = flower\n",
    )
    .unwrap();
    let said = succeed(ramus().current_dir(folder.path()).args([
        "derive",
        "leaf.lsys",
        "--export",
        "leaf.glb",
        "--export",
        "leaf.obj",
        "--png",
        "leaf.png",
        "--size",
        "128",
    ]));
    assert!(
        said.contains("0 segments, 1 polygons, 1 spheres, 2 surfaces"),
        "{said}"
    );
    let glb = gltf::Gltf::from_slice(&fs::read(at("leaf.glb")).unwrap()).unwrap();
    assert_eq!(glb.materials().count(), 1);
    let obj = fs::read_to_string(at("leaf.obj")).unwrap();
    let vertex = obj.lines().find(|line| line.starts_with("v ")).unwrap();
    assert_eq!(vertex.split(' ').count(), 7, "with a colour: {vertex}");
    let picture = image::open(at("leaf.png")).unwrap().to_rgb8();
    let red = |pixel: &image::Rgb<u8>| u16::from(pixel.0[0]) > 2 * u16::from(pixel.0[1]);
    assert!(picture.pixels().filter(|p| red(p)).count() > 100);
    let small = ["derive", "leaf.lsys", "--png", "leaf.png", "--memory", "1"];
    let crowd = format!("steps 0\naxiom {}\n", "~L".repeat(4000));
    fs::write(at("leaf.lsys"), crowd).unwrap();
    let output = ramus().current_dir(folder.path()).args(small).output();
    refused(&output.unwrap(), &["4000 surfaces", "--memory"]);
}
