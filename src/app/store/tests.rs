//! Sessions that end in good order, that are killed, and that find what others left.
#![allow(clippy::missing_assert_message, clippy::unwrap_used, reason = "tests")]

use std::fs;

use glam::Vec3;

use super::*;
use crate::world::document::Edit;

fn draw(opened: &mut Opened, heights: &[f32]) {
    for &height in heights {
        draw_anyway(opened, height).unwrap();
    }
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// Ends a session as `kill -9` does: nothing more is written, the lock goes.
fn kill(opened: Opened) -> Document {
    opened.history.committed().clone()
}

#[test]
fn a_closed_project_opens_as_it_was_and_leaves_no_journal() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let mut opened = Store::open(&path).unwrap();
    draw(&mut opened, &[0.1, 0.2, 0.3]);
    let document = opened.history.committed().clone();
    opened.store.close(&document).unwrap();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let again = Store::open(&path).unwrap();
    assert_eq!(*again.history.committed(), document);
    assert_eq!(again.message, None);
}

#[test]
fn a_killed_session_is_recovered_with_its_undo_history() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let mut opened = Store::open(&path).unwrap();
    draw(&mut opened, &[0.1, 0.2]);
    opened
        .store
        .save(&opened.history.committed().clone())
        .unwrap();
    draw(&mut opened, &[0.3, 0.4]);
    let document = kill(opened);
    let mut again = Store::open(&path).unwrap();
    assert_eq!(*again.history.committed(), document);
    assert!(
        again
            .message
            .as_ref()
            .unwrap()
            .contains("recovered 4 actions")
    );
    assert_eq!(again.history.undo_count(), 4);
    // The recovered session goes on in the same journal.
    draw(&mut again, &[0.5]);
    let document = kill(again);
    assert_eq!(*Store::open(&path).unwrap().history.committed(), document);
}

#[test]
fn an_undo_behind_the_last_save_survives_a_kill() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let mut opened = Store::open(&path).unwrap();
    draw(&mut opened, &[0.1, 0.2]);
    let saved = opened.history.committed().clone();
    opened.store.save(&saved).unwrap();
    assert!(opened.history.undo() && opened.history.undo());
    let log = opened.history.take_log();
    opened.store.append(&log).unwrap();
    assert!(kill(opened).sketch.is_empty());
    let again = Store::open(&path).unwrap();
    assert!(again.history.committed().sketch.is_empty());
    assert_eq!(again.history.redo_count(), 2);
}

#[test]
fn a_journal_of_another_project_is_kept_aside() {
    let folder = folder();
    let [path, other] = ["tree.ramus", "other.ramus"].map(|name| folder.path().join(name));
    for (path, height) in [(&path, 0.1), (&other, 0.7)] {
        let mut opened = Store::open(path).unwrap();
        draw(&mut opened, &[height]);
        let document = opened.history.committed().clone();
        opened.store.close(&document).unwrap();
    }
    let mut opened = Store::open(&path).unwrap();
    draw(&mut opened, &[0.2]);
    let work = kill(opened);
    fs::copy(&other, &path).unwrap();
    let opened = Store::open(&path).unwrap();
    assert_eq!(*opened.history.committed(), read_project(&other).unwrap());
    assert_eq!(
        read_project(&beside(&path, ".recovered.ramus")).unwrap(),
        work
    );
}

#[test]
fn a_journal_cut_anywhere_gives_a_prefix_of_the_work() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let mut opened = Store::open(&path).unwrap();
    draw(&mut opened, &[0.1, 0.2, 0.3]);
    kill(opened);
    let journal = fs::read(beside(&path, ".journal")).unwrap();
    let mut most = 0;
    for cut in 0..=journal.len() {
        let elsewhere = folder.path().join(format!("cut{cut}.ramus"));
        fs::write(beside(&elsewhere, ".journal"), &journal[..cut]).unwrap();
        let opened = Store::open(&elsewhere).unwrap();
        let segments = opened.history.committed().sketch.segments().count();
        assert!(segments >= most, "more of the journal never gives less");
        most = segments;
    }
    assert_eq!(most, 3);
}

#[test]
fn damage_and_strangers_are_put_aside_and_nothing_is_thrown_away() {
    let strange = b"{\"format\":\"ramus-journal\",\"version\":1,\"base\":\"0123456789abcdef\"}\n";
    for (name, bytes) in [
        ("noise", &b"\x00\xff noise\nmore\n"[..]),
        ("other base", &[&strange[..], b"{}\n"].concat()),
    ] {
        let folder = folder();
        let path = folder.path().join("tree.ramus");
        fs::write(beside(&path, ".journal"), bytes).unwrap();
        let opened = Store::open(&path).unwrap();
        if opened.message.is_some() {
            assert_eq!(
                fs::read(beside(&path, ".journal.damaged")).unwrap(),
                bytes,
                "{name}"
            );
        }
    }
}

/// Every action of the journal is recovered or lies in the file that is put aside, wherever the damage is and whatever
/// project is found beside it.
#[test]
fn lines_behind_a_damaged_one_are_put_aside() {
    for (line, another_project) in [(1, false), (2, false), (1, true), (2, true)] {
        let what = format!("line {line}, another project: {another_project}");
        let folder = folder();
        let path = folder.path().join("tree.ramus");
        let mut opened = Store::open(&path).unwrap();
        draw(&mut opened, &[0.1, 0.2, 0.3, 0.4]);
        kill(opened);
        let journal = beside(&path, ".journal");
        let text = fs::read_to_string(&journal).unwrap();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines[line] = lines[line].replacen("check", "chock", 1);
        let damaged = lines.join("\n") + "\n";
        fs::write(&journal, &damaged).unwrap();
        if another_project {
            let other = Document {
                step: 7,
                ..Document::default()
            };
            fs::write(&path, project::to_bytes(&other)).unwrap();
        }
        let opened = Store::open(&path).unwrap();
        let message = opened.message.unwrap();
        assert!(message.contains(".journal.damaged"), "{what}: {message}");
        let aside = fs::read_to_string(beside(&path, ".journal.damaged")).unwrap();
        assert_eq!(aside, damaged, "{what}");
        let recovered = match another_project {
            false => opened.history.committed().clone(),
            true if line == 1 => Document::default(), // none was recovered
            true => read_project(&beside(&path, ".recovered.ramus")).unwrap(),
        };
        assert_eq!(recovered.sketch.segments().count(), line - 1, "{what}");
        assert_eq!(opened.history.committed().step == 7, another_project);
    }
}

#[test]
fn beginning_anew_saves_what_a_killed_session_left() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let mut opened = Store::begin(&path).unwrap();
    draw(&mut opened, &[0.1, 0.2]);
    let document = kill(opened);
    let opened = Store::begin(&path).unwrap();
    assert!(opened.history.committed().sketch.is_empty());
    let aside = beside(&path, ".recovered.ramus");
    assert!(opened.message.as_ref().unwrap().contains("recovered.ramus"));
    assert_eq!(read_project(&aside).unwrap(), document);
}

/// A project of one segment, closed in good order.
fn finished(path: &Path, height: f32) -> Document {
    let mut opened = Store::open(path).unwrap();
    draw(&mut opened, &[height]);
    let document = opened.history.committed().clone();
    opened.store.close(&document).unwrap();
    document
}

#[test]
fn a_new_session_on_an_old_project_that_is_killed_costs_neither() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let old = finished(&path, 0.9);
    // Twice, so that the second does not replace what the first one made.
    for (height, name) in [(0.1, ".recovered.ramus"), (0.2, ".recovered.ramus.2")] {
        let mut opened = Store::begin(&path).unwrap();
        draw(&mut opened, &[height]);
        let document = kill(opened);
        let opened = Store::open(&path).unwrap();
        assert_eq!(*opened.history.committed(), old);
        let message = opened.message.unwrap();
        let aside = beside(&path, name);
        assert!(message.contains(aside.to_str().unwrap()), "{message}");
        assert_eq!(read_project(&aside).unwrap(), document);
    }
}

#[test]
fn a_project_put_in_the_place_of_a_killed_new_one_is_not_overwritten() {
    let folder = folder();
    let [path, other] = ["tree.ramus", "other.ramus"].map(|name| folder.path().join(name));
    let mut opened = Store::open(&other).unwrap();
    draw(&mut opened, &[0.7]);
    let theirs = opened.history.committed().clone();
    opened.store.close(&theirs).unwrap();
    for begin in [Store::begin as fn(&Path) -> _, Store::open] {
        let mut opened: Opened = begin(&path).unwrap();
        draw(&mut opened, &[0.1]);
        let work = kill(opened);
        fs::copy(&other, &path).unwrap();
        let opened = Store::open(&path).unwrap();
        assert_eq!(*opened.history.committed(), theirs);
        let aside = beside(&path, ".recovered.ramus");
        assert_eq!(read_project(&aside).unwrap(), work);
        drop(opened);
        for left in [aside, path.clone(), beside(&path, ".journal")] {
            let _ = fs::remove_file(left);
        }
    }
}

#[test]
fn a_replaced_project_stays_until_the_new_one_is_whole() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let old = finished(&path, 0.7);
    let mut opened = Store::begin(&path).unwrap();
    draw(&mut opened, &[0.1, 0.2]);
    let new = opened.history.committed().clone();
    // Nor does a save on the way touch it: the new one's work is in the journal.
    opened.store.save(&new).unwrap();
    assert_eq!(read_project(&path).unwrap(), old);
    opened.store.close(&new).unwrap();
    assert_eq!(read_project(&path).unwrap(), new);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_failed_session_leaves_the_older_project_and_saves_what_it_made() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let aside = beside(&path, ".unfinished.ramus");
    let count = || fs::read_dir(folder.path()).unwrap().count();
    // Nothing made leaves nothing.
    let opened = Store::begin(&path).unwrap();
    let none = opened.store.set_aside(&Document::default()).unwrap();
    assert_eq!((none, count()), (None, 0));
    // No older project: what was made is the project.
    let mut opened = Store::begin(&path).unwrap();
    draw(&mut opened, &[0.1]);
    let old = opened.history.committed().clone();
    let saved = opened.store.set_aside(&old).unwrap();
    assert_eq!((saved, count()), (Some(path.clone()), 1));
    assert_eq!(read_project(&path).unwrap(), old);
    // The same again needs no second file.
    let opened = Store::begin(&path).unwrap();
    let saved = opened.store.set_aside(&old).unwrap();
    assert_eq!((saved, count()), (Some(path.clone()), 1));
    let mut opened = Store::begin(&path).unwrap();
    draw(&mut opened, &[0.2, 0.3]);
    let new = opened.history.committed().clone();
    let saved = opened.store.set_aside(&new).unwrap();
    assert_eq!((saved, count()), (Some(aside.clone()), 2));
    assert_eq!(read_project(&aside).unwrap(), new);
    assert_eq!(read_project(&path).unwrap(), old);
}

/// A project that cannot be replaced at the session's end, because it was protected meanwhile.
#[test]
fn a_new_project_that_cannot_be_saved_is_saved_beside_the_older_one_by_the_next_start() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let old = finished(&path, 0.7);
    let mut opened = Store::begin(&path).unwrap();
    draw(&mut opened, &[0.1, 0.2]);
    let new = opened.history.committed().clone();
    let ordinary = fs::metadata(&path).unwrap().permissions();
    let mut protected = ordinary.clone();
    protected.set_readonly(true);
    fs::set_permissions(&path, protected).unwrap();
    let message = opened.store.close(&new).unwrap_err().to_string();
    assert!(
        message.contains("saves it beside the older one"),
        "{message}"
    );
    // A protected project is refused at once, and the journal stays.
    assert!(Store::begin(&path).is_err());
    fs::set_permissions(&path, ordinary).unwrap();
    assert_eq!(*Store::open(&path).unwrap().history.committed(), old);
    let aside = beside(&path, ".recovered.ramus");
    assert_eq!(read_project(&aside).unwrap(), new);
}

#[test]
fn a_project_is_kept_only_where_another_takes_its_place() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let new = finished(&folder.path().join("new.ramus"), 0.5);
    assert_eq!(keep_older(&path, &new).unwrap(), None);
    for (height, name) in [(0.1, ".before.ramus"), (0.2, ".before.ramus.2")] {
        let old = finished(&path, height);
        assert_eq!(keep_older(&path, &old).unwrap(), None);
        let kept = keep_older(&path, &new).unwrap().unwrap();
        assert_eq!(kept, beside(&path, name));
        assert_eq!(read_project(&kept).unwrap(), old);
        fs::remove_file(&path).unwrap();
    }
    // Nothing is there now: whoever opens it is told of the newest of them.
    let message = Store::open(&path).unwrap().message.unwrap();
    assert!(message.ends_with(".before.ramus.2"), "{message}");
    finished(&path, 0.3);
    assert_eq!(Store::open(&path).unwrap().message, None);
}

#[test]
fn two_sessions_never_share_a_project() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let first = Store::open(&path).unwrap();
    assert!(matches!(Store::open(&path), Err(StoreError::Busy { .. })));
    drop(first);
    assert!(Store::open(&path).is_ok());
}

#[test]
fn what_cannot_be_opened_says_so_and_stays() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    for broken in [&b"not a project"[..], b"{", b"", b"\xff\xfe\x00"] {
        fs::write(&path, broken).unwrap();
        let Err(error) = Store::open(&path) else {
            panic!("opened {broken:?}")
        };
        assert!(error.to_string().contains("tree.ramus"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), broken);
    }
    let Err(error) = Store::open(&folder.path().join("none/tree.ramus")) else {
        panic!("opened")
    };
    assert!(
        error.to_string().contains("folder that you may write to"),
        "{error}"
    );
}

/// Puts another file in the place of the journal that is open.
fn swap(store: &mut Store, file: File) -> Arc<File> {
    std::mem::replace(&mut store.file, Arc::new(file))
}

fn full() -> File {
    OpenOptions::new().write(true).open("/dev/full").unwrap()
}

/// Draws without asking whether the journal took it.
fn draw_anyway(opened: &mut Opened, height: f32) -> Result<(), StoreError> {
    opened
        .history
        .apply(Edit::AddSegment {
            to: Vec3::new(0.0, height, 0.0),
        })
        .unwrap();
    let log = opened.history.take_log();
    opened.store.append(&log)
}

#[cfg(target_os = "linux")]
#[test]
fn what_a_full_disk_did_not_take_is_written_with_the_next_action() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let mut opened = Store::open(&path).unwrap();
    draw(&mut opened, &[0.1]);
    let real = swap(&mut opened.store, full());
    for height in [0.2, 0.3, 0.4] {
        let message = draw_anyway(&mut opened, height).unwrap_err().to_string();
        assert!(
            message.contains("tree.ramus.journal") && message.contains("room"),
            "{message}"
        );
    }
    let lines = || {
        fs::read_to_string(Store::journal_of(&path))
            .unwrap()
            .lines()
            .count()
    };
    assert_eq!(lines(), 2, "the header and the first action");
    // There is room again; half a line of the last try may stand there.
    drop(swap(&mut opened.store, real.try_clone().unwrap()));
    (&*real).write_all(b"{\"n\":2,\"che").unwrap();
    drop(real);
    draw_anyway(&mut opened, 0.5).unwrap();
    assert_eq!(lines(), 6);
    let document = kill(opened);
    let again = Store::open(&path).unwrap();
    assert_eq!(*again.history.committed(), document);
    assert_eq!(document.sketch.segments().count(), 5);
    assert!(again.message.unwrap().contains("recovered 5 actions"));
}

#[cfg(target_os = "linux")]
#[test]
fn a_project_that_cannot_be_saved_leaves_a_whole_journal_or_is_saved_elsewhere() {
    for journal_too in [false, true] {
        let folder = folder();
        // A name that no other test rescues by.
        let name = format!("store-{}-{journal_too}.ramus", std::process::id());
        let path = folder.path().join(name);
        let mut opened = Store::open(&path).unwrap();
        draw(&mut opened, &[0.1]);
        let real = swap(&mut opened.store, full());
        assert!(draw_anyway(&mut opened, 0.2).is_err());
        if !journal_too {
            opened.store.file = real;
        }
        let document = opened.history.committed().clone();
        fs::create_dir(&path).unwrap();
        let message = opened.store.close(&document).unwrap_err().to_string();
        assert!(message.contains("a folder has this name"), "{message}");
        fs::remove_dir(&path).unwrap();
        if journal_too {
            let at = message.find("saved as ").unwrap() + "saved as ".len();
            let (rescued, _) = message[at..].split_once(" instead").unwrap();
            assert_eq!(read_project(Path::new(rescued)).unwrap(), document);
            fs::remove_file(rescued).unwrap();
        } else {
            assert!(message.contains("the next start"), "{message}");
            assert_eq!(*Store::open(&path).unwrap().history.committed(), document);
        }
    }
}

#[test]
fn a_journal_whose_name_is_taken_by_a_folder_is_refused_before_the_session() {
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    fs::create_dir(Store::journal_of(&path)).unwrap();
    for begin in [Store::begin as fn(&Path) -> _, Store::open] {
        let Err(error) = begin(&path) else {
            panic!("opened")
        };
        let message = error.to_string();
        assert!(message.contains("cannot keep a journal at"), "{message}");
        assert!(!path.exists());
    }
}

/// The whole workshop on a disk that is full from the first action on: it goes on, says so on the board, and all is there
/// once there is room.
#[cfg(target_os = "linux")]
#[test]
fn a_session_on_a_full_disk_goes_on_and_says_so_on_the_board() {
    use crate::app::workshop::{Workshop, WorkshopParams};
    let folder = folder();
    let path = folder.path().join("tree.ramus");
    let mut opened = Store::open(&path).unwrap();
    swap(&mut opened.store, full());
    let mut workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
    let mut said = None;
    for frame in crate::app::demonstration::first_tree().unwrap() {
        workshop.update(&frame);
        let board = workshop.scene().board.as_ref();
        said = said.or_else(|| board.and_then(|board| board.content.message.clone()));
    }
    workshop.finish_tree();
    let said = said.unwrap();
    assert!(
        said.contains("tree.ramus.journal") && said.contains("kept in memory"),
        "{said}"
    );
    let document = workshop.document().clone();
    assert_eq!(document.sketch.segments().count(), 7);
    workshop.close().unwrap();
    assert_eq!(read_project(&path).unwrap(), document);
}
