//! A runtime that dies and is started again: the work goes on in the headset.

use std::cell::{Cell, RefCell};
use std::io::Read as _;
use std::rc::Rc;
use std::time::Duration;

use ramus::app::again::{Patience, run_again};
use ramus::app::headset::{OpenError, Opened, connect};
use ramus::app::session::{Nobody, SessionEnd};
use ramus::app::{demonstration, store::Store};
use ramus_monado::remote::Remote;
use ramus_monado::service::{Service, ServiceParams};
use ramus_monado::teller;
use ramus_xr::lifecycle::FrameClock;
use ramus_xr::{Frame, Hand};

use super::super::{FIRST_STROKES, bytes, runtime, simulated, staged_with, workshop};
use super::ends::{in_the_headset, said_until};
use super::robbed::{Beat, Robbed};

/// What the lost runtime's own code says of the loss.
const EXPECTED: &str = "XR_ERROR_INSTANCE_LOST";

#[test]
fn a_runtime_killed_in_the_middle_and_started_again_makes_the_same_project() {
    staged_with(
        "monado::back::a_runtime_killed_in_the_middle_and_started_again_makes_the_same_project",
        EXPECTED,
        || {
            let frames = &demonstration::first_tree().unwrap()[..FIRST_STROKES];
            // In the middle of the second pull of the trigger: one segment is drawn, another is under way.
            let pulls: Vec<usize> = (1..frames.len())
                .filter(|&at| {
                    let pulled = |at: usize| frames[at].hands[1].trigger > 0.9;
                    pulled(at) && !pulled(at - 1)
                })
                .collect();
            let middle = pulls[1] + 3;
            // The same on the simulated headset: a frame without hands in between.
            let mut told = frames[..=middle].to_vec();
            told.push(Frame {
                focused: false,
                hands: [Hand::ABSENT; 2],
                ..frames[middle]
            });
            told.extend_from_slice(&frames[middle + 1..]);
            for (number, frame) in (0_u32..).zip(&mut told) {
                frame.time = f64::from(number) / 72.0;
            }
            let expected = simulated(&told);

            let service = RefCell::new(runtime());
            let clock: Rc<Cell<FrameClock>> = Rc::default();
            let open =
                || -> Result<Opened, OpenError> { Opened::start_by(connect()?, Rc::clone(&clock)) };
            let workshop = RefCell::new(workshop());
            let parts = [&frames[..=middle], &frames[middle + 1..]];
            let mut next = parts.into_iter();
            let patience = Patience {
                pause: Duration::from_millis(100),
                ..Patience::of(Duration::from_secs(30))
            };
            let run = |opened: Opened| -> Result<(), SessionEnd> {
                let remote = Remote::connect(service.borrow().port()).unwrap();
                let part = next.next().unwrap();
                let mut beats: Vec<Beat<'_>> = part.iter().map(Beat::show).collect();
                if next.len() > 0 {
                    beats.push(Beat::Do(Box::new(|| service.borrow_mut().kill().unwrap())));
                    beats.push(Beat::Until("nothing: it is dead", Box::new(|_| false)));
                }
                let wrap = |headset| Robbed::new(headset, remote, beats);
                opened.run(wrap, &mut workshop.borrow_mut(), &mut Nobody).1
            };
            run_again(open().unwrap(), &patience, run, open, |_, _| {
                workshop.borrow_mut().let_go();
                service.borrow_mut().start_again().unwrap();
            })
            .unwrap();
            assert_eq!(
                String::from_utf8(bytes(&workshop.borrow())),
                String::from_utf8(expected),
                "left: through a runtime that died, right: simulated"
            );
        },
    );
}

#[test]
fn the_program_goes_on_when_the_runtime_is_back_and_gives_up_when_it_is_not() {
    staged_with(
        "monado::back::the_program_goes_on_when_the_runtime_is_back_and_gives_up_when_it_is_not",
        EXPECTED,
        || {
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("kept.ramus");
            let record = folder.path().join("whole.session");
            let mut service = Service::start(ServiceParams::default()).unwrap();
            let mut program = service.command(env!("CARGO_BIN_EXE_ramus"));
            program
                .envs(teller::environment(folder.path()).unwrap())
                .args(["--patience", "20", "--record"])
                .arg(&record);
            let (child, mut output, mut said) = in_the_headset(program, &file);
            service.kill().unwrap();
            said_until(&mut output, &mut said, "Lost: ");
            assert!(said.contains("your work is saved in"), "{said}");
            service.start_again().unwrap();
            said_until(&mut output, &mut said, "In the headset again: ");
            teller::tell(folder.path(), "exit").unwrap();
            output.read_to_string(&mut said).unwrap();
            let ended = child.wait_with_output().unwrap();
            let errors = String::from_utf8_lossy(&ended.stderr).into_owned();
            assert_eq!(ended.status.code(), Some(0), "{said}{errors}");
            assert!(!errors.contains("panicked"), "{errors}");
            assert!(!Store::journal_of(&file).exists());
            // One recording of both sessions, whole and in order.
            ramus_xr::session::read_file(&record).unwrap();

            let mut program = service.command(env!("CARGO_BIN_EXE_ramus"));
            program.args(["--patience", "2"]);
            let (mut child, mut output, mut said) = in_the_headset(program, &file);
            service.kill().unwrap();
            super::ends::says_once(&mut child, "your work is saved");
            output.read_to_string(&mut said).unwrap();
            assert!(
                said.contains("within 2 s") && !said.contains("again"),
                "{said}"
            );
        },
    );
}
