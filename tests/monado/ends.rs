//! Sessions that the runtime ends while the program is in the middle of its work: killed, ended politely, told to end, told to be lost.

use std::ffi::OsString;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use ramus::app::{demonstration, store::Store};
use ramus_monado::{
    service::{Service, ServiceParams},
    teller,
};
use ramus_xr::Frame;

use super::super::{bytes, staged, workshop};

/// Actions after which the session ends under the program: some segments are drawn, most are to come.
const ACTIONS: u64 = 3;

/// Starts the workshop on a project and waits until it is in the headset; gives its output and what it said so far.
pub(crate) fn in_the_headset(
    mut program: Command,
    file: &Path,
) -> (Child, BufReader<ChildStdout>, String) {
    let mut child = program
        .args(["--headset", "openxr", "--project"])
        .arg(file)
        .current_dir(file.parent().unwrap())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let mut said = String::new();
    said_until(&mut output, &mut said, "In the headset: ");
    (child, output, said)
}

/// Reads on until the program says `words`.
pub(crate) fn said_until(output: &mut BufReader<ChildStdout>, said: &mut String, words: &str) {
    while !said.contains(words) {
        assert!(output.read_line(said).unwrap() > 0, "it ended: {said}");
    }
}

/// A program that cannot go on ends with exit code 1 and one sentence that holds `words`.
pub(crate) fn says_once(child: &mut Child, words: &str) {
    let mut errors = String::new();
    let mut stderr = child.stderr.take().unwrap();
    stderr.read_to_string(&mut errors).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{errors}");
    let said: Vec<&str> = errors
        .lines()
        .filter(|line| line.starts_with("ramus: "))
        .collect();
    assert!(said.len() == 1 && said[0].contains(words), "{errors}");
    assert!(!errors.contains("panicked"), "{errors}");
}

/// What the simulated headset makes of the first frames, for each number of frames, with its number of actions.
fn prefixes(frames: &[Frame]) -> Vec<(u64, String)> {
    let mut workshop = workshop();
    let mut made = |frame: Option<&Frame>| {
        if let Some(frame) = frame {
            workshop.update(frame);
        }
        (
            workshop.edits(),
            String::from_utf8(bytes(&workshop)).unwrap(),
        )
    };
    let mut all = vec![made(None)];
    all.extend(frames.iter().map(|frame| made(Some(frame))));
    all
}

/// Plays the recorded session on the runtime, disturbs it in the middle, and checks that the program says so in one sentence with
/// `words` and that the project holds what was drawn by then.
fn ended_in_the_middle(
    environment: impl Fn(&Path) -> Vec<(&'static str, OsString)>,
    disturb: impl FnOnce(&mut Service, &Path),
    words: &str,
) -> Service {
    let frames = demonstration::first_tree().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let session = folder.path().join("whole.session");
    std::fs::write(&session, ramus_xr::session::to_bytes(&frames).unwrap()).unwrap();
    let file = folder.path().join("ended.ramus");
    let journal = Store::journal_of(&file);
    // A journal is a line for what the session began with, and one for each action.
    let actions = || {
        let bytes = std::fs::read(&journal).unwrap_or_default();
        let lines = bytes.iter().filter(|&&byte| byte == b'\n').count();
        (lines as u64).saturating_sub(1)
    };
    let mut service = Service::start(ServiceParams::default()).unwrap();
    let mut child = service
        .command(env!("CARGO_BIN_EXE_ramus"))
        .envs(environment(folder.path()))
        .arg("replay")
        .arg(&session)
        .args(["--headset", "openxr", "--project"])
        .arg(&file)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while actions() < ACTIONS {
        assert!(
            child.try_wait().unwrap().is_none(),
            "the session ended before it drew {ACTIONS} segments"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    disturb(&mut service, folder.path());
    says_once(&mut child, words);

    let saved = std::fs::read_to_string(&file).unwrap();
    let prefixes = prefixes(&frames);
    let same = prefixes.iter().rposition(|(_, made)| *made == saved);
    let Some(shown) = same else {
        panic!("no part of the session makes what was saved:\n{saved}");
    };
    let made = prefixes[shown].0;
    println!("ended after {ACTIONS} actions; {made} are saved, of {shown} frames");
    assert!(
        made >= ACTIONS,
        "{made} actions of the {ACTIONS} before the end"
    );
    assert!(shown < frames.len(), "it was not in mid-session");
    assert!(
        !journal.exists(),
        "all is saved: nothing is to be recovered"
    );
    service
}

/// The environment that puts the layer under the program.
fn layer(folder: &Path) -> Vec<(&'static str, OsString)> {
    teller::environment(folder).unwrap()
}

#[test]
fn the_program_saves_what_was_drawn_when_the_runtime_dies() {
    staged(
        "monado::ends::the_program_saves_what_was_drawn_when_the_runtime_dies",
        || {
            ended_in_the_middle(
                |_| Vec::new(),
                |service, _| service.kill().unwrap(),
                "what was made by then is in",
            );
        },
    );
}

/// Asked to end in good order, Monado closes its sockets and announces nothing to its clients.
#[test]
fn the_program_saves_what_was_drawn_when_the_runtime_is_asked_to_end() {
    staged(
        "monado::ends::the_program_saves_what_was_drawn_when_the_runtime_is_asked_to_end",
        || {
            ended_in_the_middle(
                |_| Vec::new(),
                |service, _| service.ask_to_end().unwrap(),
                "what was made by then is in",
            );
        },
    );
}

/// STOPPING, IDLE and EXITING come from the real runtime, and by no wish of the program: a layer between them asked for them.
#[test]
fn the_program_saves_what_was_drawn_when_the_runtime_ends_the_session() {
    staged(
        "monado::ends::the_program_saves_what_was_drawn_when_the_runtime_ends_the_session",
        || {
            let service = ended_in_the_middle(
                layer,
                |_, folder| teller::tell(folder, "exit").unwrap(),
                "ended the session before all of it was played",
            );
            service.stop().unwrap();
        },
    );
}

/// Monado never announces a loss, so the layer does: the session is left and everything is saved.
#[test]
fn the_program_saves_what_was_drawn_when_the_loss_of_the_session_is_announced() {
    staged(
        "monado::ends::the_program_saves_what_was_drawn_when_the_loss_of_the_session_is_announced",
        || {
            let service = ended_in_the_middle(
                layer,
                |_, folder| teller::tell(folder, "loss").unwrap(),
                "it announced the loss of the session",
            );
            service.stop().unwrap();
        },
    );
}

/// A person who quits in the headset's own menu ends the workshop in good order: saved, said, exit code 0.
#[test]
fn a_workshop_that_the_runtime_ends_is_saved_and_no_error() {
    staged(
        "monado::ends::a_workshop_that_the_runtime_ends_is_saved_and_no_error",
        || {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("kept.ramus");
            let service = Service::start(ServiceParams::default()).unwrap();
            let mut program = service.command(env!("CARGO_BIN_EXE_ramus"));
            program.envs(layer(folder.path()));
            let (child, mut output, mut said) = in_the_headset(program, &file);
            teller::tell(folder.path(), "exit").unwrap();
            output.read_to_string(&mut said).unwrap();
            let ended = child.wait_with_output().unwrap();
            let errors = String::from_utf8_lossy(&ended.stderr).into_owned();
            assert_eq!(ended.status.code(), Some(0), "{said}{errors}");
            assert!(
                said.contains("Saved ") && said.contains("kept.ramus"),
                "{said}"
            );
            assert!(!errors.contains("ramus: "), "{errors}");
            ramus::world::project::from_bytes(&std::fs::read(&file).unwrap()).unwrap();
            assert!(!Store::journal_of(&file).exists());
            service.stop().unwrap();
        },
    );
}
