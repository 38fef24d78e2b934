//! The program as a person runs it: what it makes, what it says, and what it says when something is wrong.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output};

use glam::{Quat, Vec3};
use ramus::app::store::{Store, read_project};
use ramus_xr::{Frame, Pose, session};
use tempfile::TempDir;

mod abstracted;
mod analyze;
mod cohort;
mod compared;
mod disk;
mod doctor;
mod exact;
mod explain;
mod export;
mod fmt;
mod inspect;
mod joined;
mod memory;
mod odd;
mod older;
mod opening;
mod outputs;
mod project;
mod refusals;
mod study;
mod time;
mod widths;

const FIRST_TREE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/assets/sessions/first-tree.session"
);
const HONDA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/grammars/honda.lsys");

fn ramus() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ramus"));
    // No runtime and no desktop is looked for: what this machine has must not change the test.
    command
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env("XR_RUNTIME_JSON", "/nonexistent/runtime.json")
        .env_remove("RAMUS_LOG");
    command
}

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[track_caller]
fn succeed(command: &mut Command) -> String {
    let output = command.output().unwrap();
    assert!(
        output.status.success(),
        "{command:?}\n{}{}",
        text(&output.stdout),
        text(&output.stderr)
    );
    text(&output.stdout)
}

#[test]
fn a_replayed_session_gives_project_and_tree_and_always_the_same_bytes() {
    let folder = folder();
    let run = |name: &str| {
        // A GLB names its tree as its file is named.
        let folder = folder.path().join(name);
        fs::create_dir(&folder).unwrap();
        let [project, glb] = ["a.ramus", "a.glb"].map(|name| folder.join(name));
        let said = succeed(
            ramus()
                .args(["replay", FIRST_TREE])
                .arg("--project")
                .arg(&project)
                .arg("--glb")
                .arg(&glb),
        );
        assert!(said.contains("2 lines of 7 segments drawn"), "{said}");
        (fs::read(project).unwrap(), fs::read(glb).unwrap())
    };
    let (first, second) = (run("first"), run("second"));
    assert!(first == second, "the same session made different files");
    let gltf = gltf::Gltf::from_slice(&first.1).unwrap();
    let mesh = gltf.meshes().next().unwrap();
    let primitive = mesh.primitives().next().unwrap();
    let reader = primitive.reader(|_| gltf.blob.as_deref());
    let heights: Vec<f32> = reader
        .read_positions()
        .unwrap()
        .map(|[_, y, _]| y)
        .collect();
    let highest = heights.iter().copied().fold(f32::MIN, f32::max);
    assert!(
        (1.0..20.0).contains(&highest),
        "a tree is metres high, this one {highest}"
    );
    assert!(reader.read_normals().is_some() && reader.read_tex_coords(0).is_some());
    let left: Vec<_> = ["first", "second"]
        .iter()
        .flat_map(|name| fs::read_dir(folder.path().join(name)).unwrap())
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(
        left.len(),
        4,
        "neither journal nor temporary files stay: {left:?}"
    );
}

/// A session of many growth steps forward and back, so that a replay takes some seconds.
fn long_session(path: &Path, presses: usize) {
    let mut frames = session::read_file(Path::new(FIRST_TREE)).unwrap();
    let mut frame = *frames.last().unwrap();
    for press in 0..presses {
        for down in [true, false] {
            frame.time += 0.011;
            frame.hands[1].lower = down && press % 2 == 0;
            frame.hands[1].upper = down && press % 2 == 1;
            frames.push(frame);
        }
    }
    fs::write(path, session::to_bytes(&frames).unwrap()).unwrap();
}

/// Kills a session once it has got so far.
fn kill_when(child: &mut Child, is_far: impl Fn() -> bool) {
    while !is_far() {
        assert!(
            child.try_wait().unwrap().is_none(),
            "the session ended before it was killed"
        );
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_killed_session_is_recovered_to_its_last_finished_action() {
    let folder = folder();
    let [session, project] = ["long.session", "tree.ramus"].map(|name| folder.path().join(name));
    long_session(&session, 40_000);
    let mut child = ramus()
        .arg("replay")
        .arg(&session)
        .arg("--project")
        .arg(&project)
        .spawn()
        .unwrap();
    let journal = folder.path().join("tree.ramus.journal");
    let lines = || {
        fs::read(&journal)
            .unwrap_or_default()
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count()
    };
    kill_when(&mut child, || lines() >= 300);
    assert!(
        !project.exists(),
        "nothing was saved: all is in the journal"
    );
    let finished = lines() - 1;

    let opened = Store::open(&project).unwrap();
    assert!(
        opened
            .message
            .unwrap()
            .contains(&format!("recovered {finished} actions"))
    );
    assert!(opened.history.undo_count() > 0);
    let recovered = opened.history.committed().clone();
    assert_eq!(recovered.sketch.segments().count(), 7);
    drop(opened.store);

    // The program's next start recovers the same, saves it, and takes the journal away.
    if !can_draw() {
        return;
    }
    let out = folder.path().join("out");
    let said = succeed(
        ramus()
            .arg("--project")
            .arg(&project)
            .args(["--headset", "simulated", "--out"])
            .arg(&out),
    );
    assert!(said.contains("recovered"), "{said}");
    assert_eq!(read_project(&project).unwrap(), recovered);
    assert!(!journal.exists());
}

/// Whether pictures can be drawn here; CI must be able to.
fn can_draw() -> bool {
    match ramus::app::portrait::open_gpu() {
        Ok(_) => true,
        Err(error) if std::env::var("CI").is_ok_and(|value| value == "true") => {
            panic!("CI must have a Vulkan device: {error}")
        }
        Err(error) => {
            println!("skipped: {error}");
            false
        }
    }
}

#[test]
fn without_a_headset_the_workshop_shows_itself() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let said = succeed(ramus().current_dir(folder.path()));
    for word in [
        "No headset",
        "simulated headset",
        "pictures",
        "project",
        "tree",
    ] {
        assert!(said.contains(word), "{word} is not in:\n{said}");
    }
    let out = folder.path().join("out");
    let step = read_project(&out.join("first-tree.ramus")).unwrap().step;
    assert!(gltf::Gltf::from_slice(&fs::read(out.join("first-tree.glb")).unwrap()).is_ok());
    for step in 0..=step {
        let picture = image::open(out.join(format!("step-{step:02}.png")))
            .unwrap()
            .into_rgb8();
        let (width, height) = picture.dimensions();
        assert_eq!(width, 2 * height, "left and right eye");
        let half = |x| image::imageops::crop_imm(&picture, x, 0, height, height).to_image();
        assert_ne!(half(0), half(height), "the eyes see different pictures");
    }
}

#[test]
fn derive_draws_a_picture() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let png = folder.path().join("honda.png");
    succeed(
        ramus()
            .args(["derive", HONDA, "--size", "256", "--png"])
            .arg(&png),
    );
    let picture = image::open(png).unwrap().into_luma8();
    assert_eq!(picture.dimensions(), (256, 256));
    // Wood is darker than the sky behind it: the upper half must show a fair amount of it.
    let dark = picture
        .enumerate_pixels()
        .filter(|(_, y, pixel)| *y < 128 && pixel.0[0] < 110)
        .count();
    assert!(
        (100..20_000).contains(&dark),
        "{dark} dark pixels in the upper half"
    );
}

/// The size is what is too large, not the tree. A graphics card may be able to.
#[test]
fn a_picture_too_large_for_the_device_names_its_option() {
    if !can_draw() || std::env::var_os("RAMUS_TEST_GPU").is_some() {
        return;
    }
    let folder = folder();
    let output = ramus()
        .args(["derive", HONDA, "--size", "16384", "--png", "large.png"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    refused(&output, &["16384", "--size"]);
}

/// What `replay` and the workshop write as a grammar gives the same tree, thickness included.
#[test]
fn the_grammar_of_a_sketch_gives_its_tree() {
    let folder = folder();
    // A GLB names its tree as its file is named.
    fs::create_dir(folder.path().join("b")).unwrap();
    let [project, lsys, glb, again] =
        ["a.ramus", "a.lsys", "a.glb", "b/a.glb"].map(|name| folder.path().join(name));
    let mut replay = ramus();
    replay.args(["replay", FIRST_TREE]);
    for (option, path) in [("--project", &project), ("--lsys", &lsys), ("--glb", &glb)] {
        replay.arg(option).arg(path);
    }
    succeed(&mut replay);
    // The workshop's first step shows the axiom.
    let steps = read_project(&project).unwrap().step - 1;
    succeed(
        ramus()
            .arg("derive")
            .arg(&lsys)
            .args(["--steps", &steps.to_string(), "--widths", "da-vinci"])
            .arg("--export")
            .arg(&again),
    );
    assert!(fs::read(glb).unwrap() == fs::read(again).unwrap());
}

#[test]
fn derive_prints_strings_counts_and_json() {
    let folder = folder();
    let grammar = folder.path().join("growth.lsys");
    fs::write(&grammar, "axiom A(0) B\nA(x) > B -> A(x) A(x+1)\n").unwrap();
    let derive = |args: &[&str]| succeed(ramus().arg("derive").arg(&grammar).args(args));
    assert_eq!(
        derive(&["--steps", "3", "--print", "string"]),
        "A(0)A(1)A(2)A(3)B\n"
    );
    assert!(derive(&["--steps", "3", "--print", "counts"]).contains("A 4 sums 6"));
    let json = derive(&["--steps", "3", "--json"]);
    assert_eq!(json.lines().count(), 1);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["format"], "ramus-derive/1");
    assert_eq!(report["modules"], 5);
    assert_eq!(report["param_sums"]["A.0"], 6.0);
}

#[test]
fn derive_exports_every_format_and_reads_the_steps_of_the_file() {
    let folder = folder();
    let files =
        ["glb", "obj", "swc"].map(|ending| folder.path().join("honda").with_extension(ending));
    let mut command = ramus();
    command.args(["derive", HONDA]);
    for file in &files {
        command.arg("--export").arg(file);
    }
    let said = succeed(&mut command);
    assert!(said.contains("after 10 steps"), "{said}");
    assert!(gltf::Gltf::from_slice(&fs::read(&files[0]).unwrap()).is_ok());
    let (models, _) = tobj::load_obj(&files[1], &tobj::GPU_LOAD_OPTIONS).unwrap();
    assert!(models.iter().any(|model| model.mesh.indices.len() > 1000));
    let tree = ramus::tree::import::swc(&fs::read(&files[2]).unwrap()).unwrap();
    assert!(tree.segment_count() > 1000);
}

#[test]
fn help_teaches_every_command() {
    for (args, words) in [
        (
            &["--help"][..],
            &["replay", "derive", "doctor", "Examples", "--project"][..],
        ),
        (
            &["replay", "--help"],
            &["--headset", "--png", "--glb", ".obj or .swc", "session"],
        ),
        (
            &["derive", "--help"],
            &["--steps", "--print", "--json", "--export", "--png"],
        ),
    ] {
        let said = succeed(ramus().args(args));
        for word in words {
            assert!(
                said.contains(word),
                "{args:?} does not name {word}:\n{said}"
            );
        }
    }
}

/// One sentence on standard error and exit code 1.
#[track_caller]
fn refused(output: &Output, words: &[&str]) {
    let said = text(&output.stderr);
    // On a busy machine there may be lines on the progress before it.
    let said = said
        .lines()
        .filter(|line| !line.ends_with(" s so far") && !line.contains(" % ("))
        .collect::<Vec<_>>()
        .join("\n");
    assert_eq!(
        output.status.code(),
        Some(1),
        "{said}{}",
        text(&output.stdout)
    );
    for word in words {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
    assert!(
        said.starts_with("ramus: ") && !said.contains("panicked"),
        "{said}"
    );
}

/// The recorded session with a left hand at `place` that pulls its trigger: before it, in the middle, and after it.
fn with_a_pulling_hand(frames: &[Frame], place: Vec3) -> Vec<Frame> {
    let hands_rest = |frame: &Frame| {
        frame
            .hands
            .iter()
            .all(|hand| hand.trigger == 0.0 && hand.squeeze == 0.0 && !hand.lower && !hand.upper)
    };
    let middle = (frames.len() / 2..)
        .find(|&at| hands_rest(&frames[at]))
        .unwrap();
    let mut told = Vec::new();
    for (number, frame) in frames.iter().enumerate() {
        told.push(*frame);
        if [0, middle, frames.len() - 1].contains(&number) {
            for trigger in [0.0, 1.0, 0.0] {
                let mut odd = *frame;
                let hand = &mut odd.hands[0];
                hand.tracked = true;
                hand.aim = Pose {
                    orientation: Quat::IDENTITY,
                    position: place,
                };
                hand.grip = hand.aim;
                hand.trigger = trigger;
                told.push(odd);
            }
            told.push(*frame);
        }
    }
    told
}

#[test]
fn a_hand_absurdly_far_away_changes_nothing_that_is_made() {
    let folder = folder();
    let frames = session::read_file(Path::new(FIRST_TREE)).unwrap();
    let made = |name: &str, frames: &[Frame]| {
        let [path, project] =
            ["session", "ramus"].map(|ending| folder.path().join(name).with_extension(ending));
        fs::write(&path, session::to_bytes(frames).unwrap()).unwrap();
        succeed(
            ramus()
                .arg("replay")
                .arg(&path)
                .arg("--project")
                .arg(&project),
        );
        fs::read_to_string(project).unwrap()
    };
    let plain = made("plain", &frames);
    // Nobody's arm is so long, but a runtime may say so, and the format admits it.
    for (name, place) in [
        ("aside", Vec3::new(95.0, 1.0, 0.0)),
        ("corner", Vec3::splat(-95.0)),
        ("ahead", Vec3::new(0.0, 95.0, -95.0)),
        ("kilometres", Vec3::new(9000.0, -9000.0, 9000.0)),
    ] {
        assert_eq!(
            made(name, &with_a_pulling_hand(&frames, place)),
            plain,
            "{name}"
        );
    }
    // The same hand within reach does draw, or none of this would be a test.
    let near = frames
        .iter()
        .find(|frame| frame.hands[1].trigger == 1.0)
        .unwrap()
        .hands[1]
        .aim
        .position;
    assert_ne!(made("near", &with_a_pulling_hand(&frames, near)), plain);
}

#[test]
fn a_recorded_session_replays_to_the_same_project() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let session = folder.path().join("mine.session");
    let said = succeed(
        ramus()
            .current_dir(folder.path())
            .arg("--record")
            .arg(&session),
    );
    assert!(said.contains("mine.session"), "{said}");
    let project = folder.path().join("again.ramus");
    succeed(
        ramus()
            .arg("replay")
            .arg(&session)
            .arg("--project")
            .arg(&project),
    );
    assert_eq!(
        fs::read_to_string(project).unwrap(),
        fs::read_to_string(folder.path().join("out/first-tree.ramus")).unwrap()
    );
}
