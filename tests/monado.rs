//! The main job against a real OpenXR runtime: the recorded session, pushed into Monado packet by packet, makes the
//! same project as on the simulated headset, and the pictures in the runtime's own images show the tree to both
//! eyes; and what happens when the focus goes, or the runtime itself.
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

mod monado {
    pub(crate) mod back;
    pub(crate) mod ends;
    pub(crate) mod hurried;
    pub(crate) mod robbed;
    pub(crate) mod sight;
    pub(crate) mod study;
    pub(crate) mod tools;
}

#[allow(dead_code, reason = "tests of panels use all of it")]
#[path = "panels/visitor.rs"]
mod visitor;

use std::{cell::RefCell, path::Path, rc::Rc};

use ash::vk;
use ramus::{
    app::{
        demonstration,
        headset::{Opened, connect},
        session::{self, Nobody, SessionEnd},
        workshop::Workshop,
    },
    world::{World, history::History, project},
};
use ramus_monado::{
    feed::Fed,
    remote::Remote,
    rival::Rival,
    service::{Service, ServiceParams},
    stage, verdict,
};
use ramus_xr::{Frame, Hand, HeadsetError, record::Recorder, simulated::Simulated};

use monado::{
    ends,
    hurried::Hurried,
    robbed::{Beat, Robbed},
    sight::{Seen, Sight},
};

/// Frames of the recorded session that draw its first three segments; enough where growth does not matter.
const FIRST_STROKES: usize = 230;

/// Runs a test where the runtime is, and fails it for whatever the runtime or a layer complained about.
fn staged(test: &str, body: impl FnOnce()) {
    staged_with(test, "\0", body);
}

/// As [`staged`], where complaints with `expected` in them belong to the test.
fn staged_with(test: &str, expected: &str, body: impl FnOnce()) {
    let output = stage::run(test, || {
        // What the validation layers say reaches the output by the log.
        tracing_subscriber::fmt()
            .with_max_level(tracing::Level::WARN)
            .with_ansi(false)
            .init();
        body();
    })
    .unwrap();
    let mut complaints = verdict::complaints(&output);
    complaints.retain(|line| !line.contains(expected));
    assert_eq!(complaints, [""; 0], "the runtime or a layer complained");
}

/// Starts the runtime and makes this process find it.
fn runtime() -> Service {
    let service = Service::start(ServiceParams::default()).unwrap();
    for (name, value) in service.environment() {
        // SAFETY: inside the stage this test is alone in its process and has started no thread yet.
        unsafe { std::env::set_var(name, value) };
    }
    service
}

fn workshop() -> Workshop {
    Workshop::unsaved(World::new(History::default())).unwrap()
}

fn bytes(workshop: &Workshop) -> Vec<u8> {
    project::to_bytes(workshop.document())
}

/// The project that the simulated headset makes of these frames.
fn simulated(frames: &[Frame]) -> Vec<u8> {
    let mut headset = Simulated::new(
        frames.to_vec(),
        vk::Extent2D {
            width: 64,
            height: 64,
        },
    );
    let mut workshop = workshop();
    session::run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
    bytes(&workshop)
}

/// The session with fewer frames: of those in which only poses change one in four, of the rest all. The null compositor
/// shows 20 frames a second, whatever the session's own rate is; the whole takes two minutes and more.
fn thinned(frames: &[Frame]) -> Vec<Frame> {
    let said = |at: usize| {
        let frame = &frames[at];
        let hand = |hand: &Hand| {
            let buttons = (hand.lower, hand.upper, hand.tracked);
            (hand.trigger, hand.squeeze, hand.stick, buttons)
        };
        (frame.focused, frame.hands.each_ref().map(hand))
    };
    let last = frames.len() - 1;
    (0..=last)
        .filter(|&at| {
            let changes = |at: usize| at > 0 && at <= last && said(at) != said(at - 1);
            at % 4 == 0 || at == last || changes(at) || changes(at + 1)
        })
        .map(|at| frames[at])
        .collect()
}

#[test]
fn a_session_pushed_into_the_runtime_makes_the_same_project_and_shows_the_tree() {
    staged(
        "a_session_pushed_into_the_runtime_makes_the_same_project_and_shows_the_tree",
        || {
            let whole = demonstration::first_tree().unwrap();
            let frames = thinned(&whole);
            println!("{} of {} frames", frames.len(), whole.len());
            let expected = simulated(&frames);
            assert!(
                expected == simulated(&whole),
                "nothing was left out that matters"
            );
            let service = runtime();
            let remote = Remote::connect(service.port()).unwrap();
            let opened = Opened::start(connect().unwrap()).unwrap();
            let mut workshop = workshop();
            let views = Rc::new(RefCell::new(None));
            let mut sight = Sight::new(Rc::clone(&views));
            let total = frames.len();
            opened
                .run(
                    |headset| {
                        Seen::new(
                            Fed::new(headset, remote, frames.into_iter()),
                            Rc::clone(&views),
                        )
                    },
                    &mut workshop,
                    &mut sight,
                )
                .1
                .unwrap();
            assert_eq!(
                sight.frames(),
                total,
                "each frame of the session was shown once"
            );
            assert_eq!(
                String::from_utf8(bytes(&workshop)),
                String::from_utf8(expected),
                "left: through the runtime, right: simulated"
            );
            sight.shows_the_tree_to_both_eyes(&mut workshop);
            service.stop().unwrap();
        },
    );
}

#[test]
fn a_focus_lost_in_the_middle_of_a_stroke_ends_it_cleanly() {
    staged(
        "a_focus_lost_in_the_middle_of_a_stroke_ends_it_cleanly",
        || {
            let frames = &demonstration::first_tree().unwrap()[..FIRST_STROKES];
            // In the middle of the first pull of the trigger.
            let pulled = frames
                .iter()
                .position(|frame| frame.hands[1].trigger > 0.9)
                .unwrap();
            let service = runtime();
            let remote = Remote::connect(service.port()).unwrap();
            let opened = Opened::start(connect().unwrap()).unwrap();
            let rival = RefCell::new(None);
            let mut beats: Vec<Beat<'_>> = frames[..=pulled].iter().map(Beat::show).collect();
            beats.push(Beat::Do(Box::new(|| {
                rival.replace(Some(Rival::start(&service).unwrap()));
            })));
            beats.push(Beat::Until(
                "another program is there",
                Box::new(|_| Rival::is_there(&service).unwrap()),
            ));
            beats.push(Beat::Do(Box::new(|| Rival::take_focus(&service).unwrap())));
            beats.push(Beat::Until(
                "the focus is gone",
                Box::new(|frame| !frame.focused),
            ));
            beats.push(Beat::Until(
                "nothing is to be drawn",
                Box::new(|frame| !frame.should_render),
            ));
            beats.push(Beat::Do(Box::new(|| drop(rival.take()))));
            beats.push(Beat::Until(
                "the focus is back",
                Box::new(|frame| frame.focused),
            ));
            beats.extend(frames[pulled + 1..].iter().map(Beat::show));

            // The same on the simulated headset: frames without the focus in the same place.
            let away = Frame {
                focused: false,
                hands: [Hand::ABSENT; 2],
                ..frames[pulled]
            };
            let mut told: Vec<Frame> = frames[..=pulled].to_vec();
            told.extend([away; 3]);
            told.extend_from_slice(&frames[pulled + 1..]);
            // Times of the session go on, whatever stands in between.
            for (number, frame) in (0_u32..).zip(&mut told) {
                frame.time = f64::from(number) / 72.0;
            }
            let expected = simulated(&told);

            let mut workshop = workshop();
            opened
                .run(
                    |headset| Robbed::new(headset, remote, beats),
                    &mut workshop,
                    &mut Nobody,
                )
                .1
                .unwrap();
            assert_eq!(
                String::from_utf8(bytes(&workshop)),
                String::from_utf8(expected)
            );
            service.stop().unwrap();
        },
    );
}

#[test]
fn a_killed_runtime_loses_nothing_that_was_made() {
    staged_with(
        "a_killed_runtime_loses_nothing_that_was_made",
        "XR_ERROR_INSTANCE_LOST",
        || {
            let frames = &demonstration::first_tree().unwrap()[..FIRST_STROKES];
            let expected = simulated(frames);
            let service = RefCell::new(runtime());
            let remote = Remote::connect(service.borrow().port()).unwrap();
            let opened = Opened::start(connect().unwrap()).unwrap();
            let mut beats: Vec<Beat<'_>> = frames.iter().map(Beat::show).collect();
            beats.push(Beat::Do(Box::new(|| service.borrow_mut().kill().unwrap())));
            beats.push(Beat::Until(
                "nothing: the runtime is dead",
                Box::new(|_| false),
            ));
            let mut workshop = workshop();
            let end = opened.run(
                |headset| Robbed::new(headset, remote, beats),
                &mut workshop,
                &mut Nobody,
            );
            match end.1 {
                Err(SessionEnd::Headset(HeadsetError::Lost(_))) => {}
                other => panic!("{other:?}"),
            }
            assert_eq!(
                String::from_utf8(bytes(&workshop)),
                String::from_utf8(expected)
            );
        },
    );
}

#[test]
fn the_program_says_in_one_sentence_that_the_runtime_died() {
    staged(
        "the_program_says_in_one_sentence_that_the_runtime_died",
        || {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("kept.ramus");
            let mut service = Service::start(ServiceParams::default()).unwrap();
            let mut program = service.command(env!("CARGO_BIN_EXE_ramus"));
            program.args(["--patience", "0"]);
            let (mut child, _output, _) = ends::in_the_headset(program, &file);
            service.kill().unwrap();
            ends::says_once(&mut child, "your work is saved");
            project::from_bytes(&std::fs::read(&file).unwrap()).unwrap();
        },
    );
}

#[test]
fn a_session_recorded_on_the_runtime_replays_to_the_same_project() {
    staged(
        "a_session_recorded_on_the_runtime_replays_to_the_same_project",
        || {
            let frames = demonstration::first_tree().unwrap()[..FIRST_STROKES].to_vec();
            let service = runtime();
            let remote = Remote::connect(service.port()).unwrap();
            let opened = Opened::start(connect().unwrap()).unwrap();
            let mut workshop = workshop();
            let (recorder, outcome) = opened.run(
                |headset| {
                    let fed = Fed::new(headset, remote, frames.into_iter());
                    Recorder::new(fed, Vec::new())
                },
                &mut workshop,
                &mut Nobody,
            );
            outcome.unwrap();
            let recorded = recorder.finish().1.unwrap();
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("recorded.session");
            std::fs::write(&file, recorded).unwrap();
            let played = ramus_xr::session::read_file(&file).unwrap();
            assert!(played.len() >= FIRST_STROKES, "{} frames", played.len());
            assert!(workshop.edits() > 0, "something was drawn");
            assert_eq!(
                String::from_utf8(bytes(&workshop)),
                String::from_utf8(simulated(&played)),
                "left: on the runtime, right: its recording"
            );
            service.stop().unwrap();
        },
    );
}

#[test]
fn the_program_replays_a_session_on_the_runtime() {
    staged("the_program_replays_a_session_on_the_runtime", || {
        let session =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/sessions/first-tree.session");
        let frames = ramus_xr::session::read_file(&session).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let short = folder.path().join("short.session");
        std::fs::write(
            &short,
            ramus_xr::session::to_bytes(&frames[..FIRST_STROKES]).unwrap(),
        )
        .unwrap();
        let file = folder.path().join("replayed.ramus");
        let service = Service::start(ServiceParams::default()).unwrap();
        let output = service
            .command(env!("CARGO_BIN_EXE_ramus"))
            .arg("replay")
            .arg(&short)
            .args(["--headset", "openxr", "--project"])
            .arg(&file)
            .output()
            .unwrap();
        let text = format!(
            "{}{}",
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr)
        );
        println!("{text}");
        assert!(output.status.success());
        assert_eq!(
            String::from_utf8(std::fs::read(&file).unwrap()),
            String::from_utf8(simulated(&frames[..FIRST_STROKES]))
        );
        service.stop().unwrap();
    });
}

#[test]
fn doctor_finds_the_runtime_and_names_its_command_when_it_is_gone() {
    staged(
        "doctor_finds_the_runtime_and_names_its_command_when_it_is_gone",
        || {
            let mut service = Service::start(ServiceParams::default()).unwrap();
            let doctor = |service: &Service| {
                let mut doctor = service.command(env!("CARGO_BIN_EXE_ramus"));
                // What the layer says about an instance that cannot be made is not ours to judge.
                let output = doctor
                    .env_remove("XR_ENABLE_API_LAYERS")
                    .arg("doctor")
                    .output();
                String::from_utf8(output.unwrap().stdout).unwrap()
            };
            let said = doctor(&service);
            assert!(said.contains("Remote HMD"), "{said}");
            assert!(said.contains("Ramus can start in the headset"), "{said}");
            service.kill().unwrap();
            let said = doctor(&service);
            let commands = ["systemctl --user start monado.socket", "monado-service &"];
            assert!(
                commands.iter().any(|command| said.contains(command)),
                "{said}"
            );
        },
    );
}

/// Pictures that take too long get fewer pixels, down to a bound; the runtime takes them so.
#[test]
fn a_device_that_is_late_draws_fewer_pixels() {
    staged("a_device_that_is_late_draws_fewer_pixels", || {
        let _service = runtime();
        let opened = Opened::start(connect().unwrap()).unwrap();
        let parts = Rc::new(RefCell::new(Vec::new()));
        let mut workshop = workshop();
        let kept = Rc::clone(&parts);
        let hurried = |inner| Hurried {
            inner,
            frames: 40,
            parts: kept,
        };
        opened.run(hurried, &mut workshop, &mut Nobody).1.unwrap();
        let parts = parts.borrow();
        assert!(parts.len() > 20, "{} frames were drawn", parts.len());
        let (first, last) = (parts[0], parts[parts.len() - 1]);
        let fewer = |pixels: u32| (pixels * 10).div_ceil(16);
        let expected = (fewer(first.width), fewer(first.height));
        assert_eq!((last.width, last.height), expected);
        assert!(parts.is_sorted_by_key(|part| std::cmp::Reverse(part.width)));
    });
}
