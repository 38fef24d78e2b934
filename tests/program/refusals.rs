//! Input that cannot be used: one clear sentence, exit code 1, and nothing changed.

use std::fs;
use std::path::PathBuf;

use super::{FIRST_TREE, HONDA, folder, ramus, refused, succeed, text};

#[test]
fn what_cannot_be_derived_is_told_with_what_can() {
    let folder = folder();
    let wide = format!("axiom F\nF -> {}\n", "F".repeat(100));
    for (grammar, args, words, memory) in [
        (
            "axiom A(2)\nA(x) -> A(x-1/x*x)F(1/x)\n",
            &["--steps", "9"][..],
            "step 3, production",
            false,
        ),
        (
            &wide,
            &["--steps", "99"],
            "2147483648 modules; take fewer steps; steps up to 4 can",
            false,
        ),
        (
            "axiom F\nF -> FF\n",
            &["--steps", "99", "--memory", "16"],
            "than 16 MiB with --memory; steps up to 23 can",
            true,
        ),
    ] {
        let path = folder.path().join("a.lsys");
        fs::write(&path, grammar).unwrap();
        let output = ramus().arg("derive").arg(&path).args(args).output();
        let output = output.unwrap();
        refused(&output, &[words, "; steps up to ", ": give --steps "]);
        let said = text(&output.stderr);
        assert_eq!(said.contains("--memory"), memory, "{said}");
        let last = said.trim_end().rsplit(' ').next().unwrap();
        if !grammar.starts_with("axiom F") {
            succeed(ramus().arg("derive").arg(&path).args(["--steps", last]));
        }
    }
}

#[test]
fn bad_grammars_and_options_get_one_clear_sentence() {
    let folder = folder();
    let file = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let cases: Vec<(PathBuf, &[&str], &[&str])> = vec![
        (
            folder.path().join("none.lsys"),
            &["--steps", "1"],
            &["none.lsys", "cannot read"],
        ),
        (
            folder.path().to_owned(),
            &["--steps", "1"],
            &["cannot read"],
        ),
        (
            file("oak.ramus", b"{}"),
            &["--steps", "1"],
            &["oak.ramus is a project", "ramus export", "--format lsys"],
        ),
        (file("empty.lsys", b""), &["--steps", "1"], &["empty.lsys"]),
        (
            file("syntax.lsys", b"axiom A\nA -> [B\n"),
            &["--steps", "1"],
            &["syntax.lsys:2"],
        ),
        (
            file("latin.lsys", b"axiom A # \xe9\n"),
            &["--steps", "1"],
            &["UTF-8"],
        ),
        (
            file("nul.lsys", &[0; 4096]),
            &["--steps", "1"],
            &["nul.lsys"],
        ),
        (
            file("zero.lsys", b"axiom A(1)\nA(x) -> A(x/0)\n"),
            &["--steps", "1"],
            &["division by zero", "A(x/0)"],
        ),
        (
            file("explode.lsys", b"axiom F\nF -> FFFFFFFFFFFFFFFF\n"),
            &["--steps", "60", "--memory", "64"],
            &["step", "limit", "--memory"],
        ),
        (
            file("leaf.lsys", b"axiom A\nA -> [{.+f.-f.}]A\n"),
            &["--steps", "6", "--export", "leaf.swc"],
            &[
                "after 6 steps draws no segment",
                "leaf.swc holds segments only",
                "GLB",
            ],
        ),
        (
            file("bare.lsys", b"axiom A\n"),
            &["--steps", "6", "--png", "bare.png"],
            &["after 6 steps draws no segment", "`F`"],
        ),
        (file("nosteps.lsys", b"axiom A\n"), &[], &["--steps"]),
        (
            file("undrawn.lsys", b"axiom A\n"),
            &["--steps", "1", "--export", "tree.glb"],
            &["no segment"],
        ),
        (
            file("where.lsys", b"axiom F\n"),
            &["--steps", "1", "--export", "/nonexistent/tree.glb"],
            &["/nonexistent"],
        ),
    ];
    for (path, args, words) in cases {
        let output = ramus()
            .current_dir(folder.path())
            .arg("derive")
            .arg(&path)
            .args(args)
            .output()
            .unwrap();
        refused(&output, words);
    }
}

/// What the command line alone shows: exit code 2, and nothing is begun.
#[test]
fn wrong_usage_is_refused_before_any_work() {
    let folder = folder();
    let derive = ["derive", HONDA, "--print", "string"];
    let replay = ["replay", FIRST_TREE, "--project", "tree.ramus"];
    let cases: [(&[&str], &[&str], &str); 10] = [
        (&[], &["fly"], "fly"),
        (&derive, &["--steps", "many"], "many"),
        (
            &derive,
            &["--export", "tree.xyz"],
            ".glb, .usda, .ply, .obj or .swc",
        ),
        (
            &derive,
            &["--export", "tree"],
            ".glb, .usda, .ply, .obj or .swc",
        ),
        (&derive, &["--size", "0", "--png", "x.png"], "--size"),
        (&derive, &["--memory", "0"], "--memory"),
        (&derive, &["--png", "tree.jpg"], "use the ending .png"),
        (&derive, &["--widths", "da-vinci", "--tip", "0"], "--tip"),
        (
            &replay,
            &["--glb", "tree.txt"],
            ".glb, .usda, .ply, .obj or .swc",
        ),
        (
            &replay,
            &["--glb", "glb"],
            ".glb, .usda, .ply, .obj or .swc",
        ),
    ];
    for (command, args, word) in cases {
        let output = ramus()
            .current_dir(folder.path())
            .args(command)
            .args(args)
            .output()
            .unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
        assert!(said.contains(word), "{args:?}: {said}");
        assert_eq!(text(&output.stdout), "", "{args:?}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{args:?}");
    }
}

#[test]
fn names_that_nothing_can_be_written_to_are_refused_before_the_work() {
    let folder = folder();
    for (command, args) in [
        ("derive", &["--png", "none/x.png"][..]),
        ("derive", &["--export", "x.glb", "--export", "none/x.obj"]),
        ("replay", &["--project", "x.ramus", "--lsys", "none/x.lsys"]),
    ] {
        let input = if command == "derive" {
            HONDA
        } else {
            FIRST_TREE
        };
        let output = ramus()
            .current_dir(folder.path())
            .args([command, input])
            .args(args)
            .output()
            .unwrap();
        refused(&output, &["the folder does not exist", "none/x."]);
        assert_eq!(text(&output.stdout), "", "{args:?}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{args:?}");
    }
}

#[test]
fn bad_sessions_make_no_project() {
    let folder = folder();
    let whole = fs::read(FIRST_TREE).unwrap();
    let with = |from: &str, to: &str| text(&whole).replacen(from, to, 1).into_bytes();
    let cases: [(&str, Vec<u8>, &[&str]); 6] = [
        ("empty", Vec::new(), &["empty.session"]),
        (
            "noise",
            b"\x00\xff\x12 noise".to_vec(),
            &["noise.session", "line 1"],
        ),
        ("truncated", whole[..whole.len() / 2].to_vec(), &[]),
        (
            "version",
            with("ramus-session 1", "ramus-session 99"),
            &["line 1"],
        ),
        ("nan", with("trigger 1", "trigger NaN"), &["line"]),
        (
            "long",
            [b"ramus-session 1\n".to_vec(), vec![b'x'; 1 << 20]].concat(),
            &["line"],
        ),
    ];
    for (name, bytes, words) in cases {
        let path = folder.path().join(format!("{name}.session"));
        fs::write(&path, &bytes).unwrap();
        let project = folder.path().join(format!("{name}.ramus"));
        let output = ramus()
            .arg("replay")
            .arg(&path)
            .arg("--project")
            .arg(&project)
            .output()
            .unwrap();
        if name == "truncated" {
            // Cut within a frame it is refused; cut between two it is a shorter session. Neither is a panic.
            assert!(
                matches!(output.status.code(), Some(0 | 1)),
                "{}",
                text(&output.stderr)
            );
            continue;
        }
        refused(&output, words);
        assert!(!project.exists(), "{name} made a project");
    }
    let output = ramus()
        .args(["replay", "/nonexistent/a.session"])
        .output()
        .unwrap();
    refused(&output, &["/nonexistent/a.session"]);
}

#[test]
fn bad_projects_are_refused_and_stay_as_they_are() {
    let folder = folder();
    for (name, bytes) in [
        ("noise", &b"\x00\x01\x02"[..]),
        ("empty", b""),
        ("later", br#"{"format":"ramus-project","version":999}"#),
    ] {
        let path = folder.path().join(format!("{name}.ramus"));
        fs::write(&path, bytes).unwrap();
        let output = ramus()
            .current_dir(folder.path())
            .args(["--headset", "simulated", "--project"])
            .arg(&path)
            .output()
            .unwrap();
        refused(&output, &[name]);
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }
    let output = ramus()
        .args(["replay", FIRST_TREE, "--project", "/nonexistent/tree.ramus"])
        .output()
        .unwrap();
    refused(
        &output,
        &["/nonexistent/tree.ramus", "folder that you may write to"],
    );
}

#[test]
fn without_vulkan_pictures_are_refused_and_everything_else_works() {
    let folder = folder();
    let blind = || {
        let mut command = ramus();
        command
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .current_dir(folder.path());
        command
    };
    let png = folder.path().join("tree.png");
    refused(
        &blind()
            .args(["derive", HONDA, "--png"])
            .arg(&png)
            .output()
            .unwrap(),
        &["Vulkan", "install"],
    );
    assert!(!png.exists());
    succeed(blind().args(["derive", HONDA, "--export", "tree.glb"]));
    succeed(blind().args(["replay", FIRST_TREE, "--project", "tree.ramus"]));
}

/// The documents of the built-in session, at a step whose tree is larger than the workshop shows.
#[test]
fn a_project_too_large_to_show_is_refused_before_anything_is_drawn() {
    let folder = folder();
    let project = folder.path().join("large.ramus");
    succeed(
        ramus()
            .args(["replay", FIRST_TREE, "--project"])
            .arg(&project),
    );
    let whole = fs::read_to_string(&project).unwrap();
    let (_, rest) = whole.split_once("\"step\": ").unwrap();
    let (step, _) = rest.split_once(',').unwrap();
    let large = whole.replacen(&format!("\"step\": {step},"), "\"step\": 9000,", 1);
    fs::write(&project, &large).unwrap();
    let out = folder.path().join("out");
    let output = ramus()
        .args(["--headset", "simulated", "--project"])
        .arg(&project)
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    refused(&output, &["step 9000", "segments", "set a lower step"]);
    assert_eq!(fs::read_dir(&out).unwrap().count(), 0, "nothing was drawn");
    assert_eq!(fs::read_to_string(&project).unwrap(), large);
}

#[test]
fn options_of_the_workshop_do_not_mix_with_other_commands() {
    for args in [
        &["--project", "oak.ramus", "doctor"][..],
        &["--headset", "simulated", "replay", FIRST_TREE],
        &["--out", "here", "derive", HONDA],
    ] {
        let output = ramus().args(args).output().unwrap();
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
        assert!(said.contains("cannot be used with"), "{args:?}: {said}");
    }
}

#[test]
fn more_threads_than_machines_have_are_refused() {
    let with = |threads: &str| {
        let mut command = ramus();
        command.arg("derive").arg(HONDA).args(["--steps", "4"]);
        command.env("RAYON_NUM_THREADS", threads);
        command
    };
    let output = with("99999999").output().unwrap();
    refused(
        &output,
        &["RAYON_NUM_THREADS asks for 99999999 threads: set it to 1024 at most"],
    );
    // What is no number counts for nothing, as ever.
    for threads in ["3", "0", "", "many"] {
        succeed(&mut with(threads));
    }
}

/// What a tree should bear and does not is said once, whatever is made of it.
#[test]
fn a_tree_that_stays_bare_says_so() {
    let folder = folder();
    let path = folder.path().join("bare.lsys");
    let grammar = "bears oak order 9\nbears fruit twig 1\nsteps 3\naxiom A\nA -> F(0.4) [ +(35) A ] [ -(40) A ]\n";
    fs::write(&path, grammar).unwrap();
    let sentence = "`bears oak order 9`: no twig bears any; see what `twig`, `order`, `young` and `every` ask for\n";
    let [file, out] = ["bare.glb", "out"].map(|name| folder.path().join(name));
    for command in [
        ramus().arg("derive").arg(&path).arg("--export").arg(&file),
        ramus()
            .arg("export")
            .arg(&path)
            .args(["--format", "glb,ply", "--count", "3", "--out"])
            .arg(&out),
    ] {
        let output = command.output().unwrap();
        let said = text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert_eq!(said.matches(sentence).count(), 1, "{said}");
        assert!(!said.contains("bears fruit"), "{said}");
    }
}
