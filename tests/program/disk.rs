//! Disks that are full or may not be written to: nothing that was made is lost.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use ramus::app::store::{Store, read_project};
use ramus::app::workshop::Workshop;
use ramus::world::{World, history::History};

use super::{HONDA, folder, long_session, ramus, refused, succeed, text};

/// Growth steps forward and back: they fill the journal, and the project stays small.
const PRESSES: usize = 400;

/// Bytes of the shortest line of a journal, at least.
const LINE: u64 = 40;

/// Runs `script` in a mount namespace of its own, where it may mount a disk on its `$1`; `$2` is the program, the rest are
/// `args`. Nothing where the system does not allow that.
pub(super) fn with_a_disk(folder: &Path, script: &str, args: &[&str]) -> Option<Output> {
    let program = ramus();
    let mut command = Command::new("unshare");
    command
        .args([
            "--mount",
            "--propagation",
            "private",
            "sh",
            "-c",
            script,
            "sh",
        ])
        .arg(folder)
        .arg(program.get_program())
        .args(args);
    for (name, value) in program.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    let Ok(output) = command.output() else {
        println!("skipped: there is no unshare here to make a small disk with");
        return None;
    };
    let said = text(&output.stderr);
    if said.contains("unshare:") || said.contains("mount:") {
        println!(
            "skipped: no mount namespace may be made here ({})",
            said.trim()
        );
        return None;
    }
    Some(output)
}

#[test]
fn a_full_disk_leaves_the_old_file_and_says_so() {
    let folder = folder();
    let script = "mount -t tmpfs -o size=256k none \"$1\" && cd \"$1\" && echo old > tree.glb \
        && \"$2\" derive \"$3\" --export tree.glb; code=$?; cat tree.glb; ls -A; exit $code";
    let Some(output) = with_a_disk(folder.path(), script, &[HONDA]) else {
        return;
    };
    refused(&output, &["tree.glb", "full"]);
    assert!(
        text(&output.stdout).ends_with("old\ntree.glb\n"),
        "the old file stays, and nothing else"
    );
}

#[test]
fn a_folder_that_can_only_be_read_is_refused_before_the_session() {
    let folder = folder();
    let script = "mount -t tmpfs -o ro none \"$1\" && cd \"$1\" && \"$2\" replay \"$3\" --project tree.ramus";
    if let Some(output) = with_a_disk(folder.path(), script, &[super::FIRST_TREE]) {
        refused(&output, &["tree.ramus", "folder that you may write to"]);
        assert_eq!(text(&output.stdout), "", "nothing was played");
    }
}

/// The journal fills the disk, so there is no room for the project: it is saved elsewhere.
#[test]
fn a_project_without_room_is_saved_elsewhere_and_the_person_is_told_where() {
    let [folder, rescue] = [folder(), folder()];
    let session = rescue.path().join("long.session");
    long_session(&session, PRESSES);
    let [session, rescue] = [&session, rescue.path()].map(|path| path.to_str().unwrap());
    let script = "mount -t tmpfs -o size=16k none \"$1\" && cd \"$1\" && \
        TMPDIR=\"$4\" exec \"$2\" replay \"$3\" --project tree.ramus";
    let Some(output) = with_a_disk(folder.path(), script, &[session, rescue]) else {
        return;
    };
    let rescued = Path::new(rescue).join("tree.ramus.rescued.ramus");
    refused(
        &output,
        &[
            "the disk is full",
            "all of the work was saved",
            "tree.ramus.rescued.ramus",
        ],
    );
    let whole = Path::new(rescue).join("whole.ramus");
    succeed(ramus().args(["replay", session, "--project"]).arg(&whole));
    assert_eq!(
        read_project(&rescued).unwrap(),
        read_project(&whole).unwrap()
    );
}

/// No file may grow beyond so many blocks of 512 bytes: a full disk that needs no disk of its own.
#[test]
fn a_journal_that_cannot_be_written_ends_no_session() {
    let folder = folder();
    let session = folder.path().join("long.session");
    long_session(&session, PRESSES);
    succeed(ramus().current_dir(folder.path()).args([
        "replay",
        "long.session",
        "--project",
        "whole.ramus",
    ]));
    let whole = fs::read(folder.path().join("whole.ramus")).unwrap();
    let room = whole.len() as u64 + 2048;
    let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
    for frame in &ramus_xr::session::read_file(&session).unwrap() {
        workshop.update(frame);
    }
    assert!(
        workshop.edits() * LINE > 2 * room,
        "the journal of {} actions may have room",
        workshop.edits()
    );
    let program = ramus();
    let mut command = Command::new("sh");
    command
        .args(["-c", "trap '' XFSZ; ulimit -f \"$0\" && exec \"$@\""])
        .arg((room / 512).to_string())
        .arg(program.get_program())
        .args(["replay", "long.session", "--project", "tree.ramus"])
        .env("XR_RUNTIME_JSON", "/nonexistent/runtime.json")
        .current_dir(folder.path());
    succeed(&mut command);
    assert!(
        fs::read(folder.path().join("tree.ramus")).unwrap() == whole,
        "the project is another one than with room for the journal"
    );
    assert!(!folder.path().join("tree.ramus.journal").exists());
}

#[test]
fn a_project_that_cannot_be_saved_is_in_its_journal() {
    let folder = folder();
    let [session, project, whole] =
        ["long.session", "tree.ramus", "whole.ramus"].map(|name| folder.path().join(name));
    long_session(&session, 4000);
    let journal = Store::journal_of(&project);
    let child = ramus()
        .arg("replay")
        .arg(&session)
        .arg("--project")
        .arg(&project)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !journal.exists() {
        std::thread::yield_now();
    }
    // The project is written at the end alone: a folder takes its name meanwhile.
    fs::create_dir(&project).unwrap();
    let output = child.wait_with_output().unwrap();
    refused(
        &output,
        &[
            "was not saved",
            "a folder has this name",
            "tree.ramus.journal",
            "next start",
        ],
    );
    fs::remove_dir(&project).unwrap();
    succeed(
        ramus()
            .arg("replay")
            .arg(&session)
            .arg("--project")
            .arg(&whole),
    );
    let recovered = Store::open(&project).unwrap();
    assert_eq!(
        *recovered.history.committed(),
        read_project(&whole).unwrap()
    );
}

#[test]
fn a_session_that_replaces_a_project_keeps_the_older_one_until_it_is_over() {
    let folder = folder();
    let [session, project] = ["long.session", "tree.ramus"].map(|name| folder.path().join(name));
    let older = super::older::changed(&project);
    long_session(&session, 40_000);
    let mut child = ramus()
        .arg("replay")
        .arg(&session)
        .arg("--project")
        .arg(&project)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let journal = Store::journal_of(&project);
    let has_begun = || fs::metadata(&journal).is_ok_and(|data| data.len() > 4096);
    super::kill_when(&mut child, has_begun);
    assert!(fs::read(&project).unwrap() == older);
    // The next start finds both.
    let opened = Store::open(&project).unwrap();
    assert_eq!(*opened.history.committed(), read_project(&project).unwrap());
    let kept = folder.path().join("tree.ramus.recovered.ramus");
    assert!(opened.message.unwrap().contains(kept.to_str().unwrap()));
    assert!(!read_project(&kept).unwrap().sketch.is_empty());
}

/// The recording lies on a disk of its own, so that it alone finds no room.
#[test]
fn a_recording_without_room_is_an_error_and_all_else_is_there() {
    if !super::can_draw() {
        return;
    }
    let [disk, here] = [folder(), folder()];
    let out = here.path().join("out");
    let script = "mount -t tmpfs -o size=16k none \"$1\" \
        && exec \"$2\" --headset simulated --out \"$3\" --record \"$1/mine.session\"";
    let Some(output) = with_a_disk(disk.path(), script, &[out.to_str().unwrap()]) else {
        return;
    };
    refused(
        &output,
        &[
            "mine.session is not whole",
            "No space left",
            "free some space",
        ],
    );
    assert_eq!(text(&output.stderr).matches("ramus:").count(), 1);
    for name in ["first-tree.ramus", "first-tree.glb", "first-tree.lsys"] {
        assert!(out.join(name).exists(), "{name}");
        assert!(text(&output.stdout).contains(name), "{name}");
    }
}
