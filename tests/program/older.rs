//! Older projects: whatever fails, and whatever a person changed, they are not lost.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use ramus::app::store::read_project;
use ramus_xr::session;

#[cfg(target_os = "linux")]
use super::disk::with_a_disk;
use super::{FIRST_TREE, can_draw, folder, ramus, refused, succeed, text};

/// A project that a person changed.
pub(super) fn changed(path: &Path) -> Vec<u8> {
    succeed(ramus().args(["replay", FIRST_TREE, "--project"]).arg(path));
    let text = fs::read_to_string(path).unwrap();
    let other = text.replacen("137.508", "90", 1);
    assert_ne!(other, text);
    fs::write(path, &other).unwrap();
    other.into_bytes()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn blind(mut command: Command) -> Command {
    command
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent");
    command
}

#[test]
fn a_session_that_cannot_begin_touches_nothing() {
    let folder = folder();
    let out = folder.path().join("out");
    fs::create_dir(&out).unwrap();
    let project = out.join("first-tree.ramus");
    let older = changed(&project);
    let replay = |more: &[&str]| {
        let mut command = ramus();
        command.args(["replay", FIRST_TREE, "--project"]);
        command.arg(&project).args(more);
        command.current_dir(folder.path());
        command
    };
    let mut shown = ramus();
    shown.current_dir(folder.path());
    for (mut command, word) in [
        (replay(&["--headset", "openxr"]), "OpenXR"),
        (blind(replay(&["--png", "out"])), "Vulkan"),
        (blind(shown), "Vulkan"),
        (replay(&["--png", "out/first-tree.ramus"]), "folder"),
        (replay(&["--glb", "none/tree.glb"]), "folder does not exist"),
        (replay(&["--lsys", "out"]), "a folder has this name"),
    ] {
        refused(&command.output().unwrap(), &[word]);
        assert!(fs::read(&project).unwrap() == older, "{command:?}");
        assert_eq!(names(&out), ["first-tree.ramus"], "{command:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn pictures_that_cannot_be_written_are_refused_before_the_session() {
    if !can_draw() {
        return;
    }
    let [disk, here] = [folder(), folder()];
    let project = here.path().join("tree.ramus");
    let older = changed(&project);
    let script = "mount -t tmpfs -o ro none \"$1\" \
        && exec \"$2\" replay \"$3\" --png \"$1\" --project \"$4\"";
    let args = [FIRST_TREE, project.to_str().unwrap()];
    if let Some(output) = with_a_disk(disk.path(), script, &args) {
        refused(&output, &["only be read", "step-00.png"]);
        assert!(fs::read(&project).unwrap() == older);
        assert_eq!(names(here.path()), ["tree.ramus"]);
    }
}

/// A disk that has room for one picture: the second one, of the first stroke, ends the session.
#[cfg(target_os = "linux")]
#[test]
fn a_session_that_fails_leaves_the_older_project_and_keeps_what_was_made() {
    if !can_draw() {
        return;
    }
    let [disk, here] = [folder(), folder()];
    let at = |name: &str| here.path().join(name);
    let frames = session::read_file(Path::new(FIRST_TREE)).unwrap();
    fs::write(
        at("still.session"),
        session::to_bytes(&frames[..3]).unwrap(),
    )
    .unwrap();
    succeed(ramus().current_dir(here.path()).args([
        "replay",
        "still.session",
        "--png",
        "one",
        "--lsys",
        "one/still.lsys",
    ]));
    let bytes = fs::metadata(at("one/step-00.png")).unwrap().len();
    let project = at("tree.ramus");
    let older = changed(&project);
    let script = "mount -t tmpfs -o size=\"$4\" none \"$1\" \
        && exec \"$2\" replay \"$3\" --png \"$1\" --project \"$5\"";
    let run = |project: &PathBuf| {
        let room = format!("{}k", bytes * 3 / 2 / 1024);
        let args = [FIRST_TREE, &room, project.to_str().unwrap()];
        with_a_disk(disk.path(), script, &args)
    };
    let Some(output) = run(&project) else {
        return;
    };
    let kept = at("tree.ramus.unfinished.ramus");
    let said = [
        "the disk is full",
        "what was made by then is in",
        kept.to_str().unwrap(),
        "tree.ramus is as it was",
    ];
    refused(&output, &said);
    assert!(fs::read(&project).unwrap() == older);
    let made = read_project(&kept).unwrap();
    assert!(!made.sketch.is_empty());
    // Where there is no older one the work is the project.
    let new = at("new.ramus");
    refused(
        &run(&new).unwrap(),
        &["what was made by then is in", "new.ramus"],
    );
    assert_eq!(read_project(&new).unwrap(), made);
    assert!(
        !names(here.path())
            .iter()
            .any(|name| name.ends_with(".journal"))
    );
}

#[test]
fn the_demonstration_keeps_a_project_that_was_changed() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let project = folder.path().join("out/first-tree.ramus");
    fs::create_dir(project.parent().unwrap()).unwrap();
    let older = changed(&project);
    let said = succeed(ramus().current_dir(folder.path()));
    let kept = "out/first-tree.ramus.before.ramus";
    assert!(said.contains(&format!("it is kept as {kept}.")), "{said}");
    assert!(fs::read(folder.path().join(kept)).unwrap() == older);
    assert!(fs::read(&project).unwrap() != older);
}

#[test]
fn a_project_that_is_not_there_needs_a_headset() {
    let folder = folder();
    let output = ramus()
        .current_dir(folder.path())
        .args(["--project", "new.ramus"])
        .output()
        .unwrap();
    let words = [
        "no project new.ramus",
        "headset",
        "ramus doctor",
        "--project",
    ];
    refused(&output, &words);
    assert!(text(&output.stdout).contains("No headset"));
    assert_eq!(names(folder.path()), [""; 0]);
}

/// As an earlier Ramus left it that was ended in a bad moment.
#[test]
fn an_empty_project_beside_an_older_one_says_where_that_is() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    changed(&at("tree.ramus.before.ramus"));
    let frames = session::read_file(Path::new(FIRST_TREE)).unwrap();
    fs::write(
        at("still.session"),
        session::to_bytes(&frames[..3]).unwrap(),
    )
    .unwrap();
    succeed(ramus().current_dir(folder.path()).args([
        "replay",
        "still.session",
        "--project",
        "tree.ramus",
    ]));
    let said = succeed(ramus().current_dir(folder.path()).args([
        "--headset",
        "simulated",
        "--project",
        "tree.ramus",
    ]));
    assert!(
        said.contains("nothing is in tree.ramus") && said.contains("tree.ramus.before.ramus"),
        "{said}"
    );
}
