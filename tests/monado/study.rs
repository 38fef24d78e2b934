//! A participant of a study in the headset: the program as it is started, hands on its panel, ended by the runtime and gone on with.

use std::io::{BufReader, Read as _};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use ramus::app::study::sitting::Sitting;
use ramus::app::workshop::Workshop;
use ramus::world::{World, history::History, panels::PanelId};
use ramus_monado::remote::{Packet, Remote};
use ramus_monado::service::{Service, ServiceParams};
use ramus_monado::teller;
use ramus_xr::Frame;

use super::super::staged;
use super::super::visitor::{RIGHT, Visitor};
use super::ends::said_until;

/// The null compositor shows 20 frames a second: what is sent stays for two of them.
const LOOK: Duration = Duration::from_millis(100);

/// What hands do to turn the first page, seen on the simulated headset.
fn next_page() -> Vec<Frame> {
    let folder = tempfile::tempdir().unwrap();
    let sitting = Sitting::of(folder.path(), "P1", "ramus", None).unwrap();
    sitting.make_folder().unwrap();
    let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
    workshop.sit(sitting).unwrap();
    let mut visitor = Visitor::at(workshop);
    visitor.frames.clear();
    visitor.click(RIGHT, PanelId::Study, "Next");
    visitor.frames
}

/// Holds a sitting until `done`, then lets the runtime end it; what the program said.
fn sit(service: &Service, folder: &Path, done: impl FnOnce()) -> String {
    let mut child = service
        .command(env!("CARGO_BIN_EXE_ramus"))
        .envs(teller::environment(folder).unwrap())
        .args(["study", "run", "trial", "--participant", "P1"])
        .args(["--language", "english", "--headset", "openxr"])
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let mut said = String::new();
    said_until(&mut output, &mut said, "answers are kept in");
    done();
    teller::tell(folder, "exit").unwrap();
    output.read_to_string(&mut said).unwrap();
    let ended = child.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(0), "{said}{errors}");
    assert!(!errors.contains("ramus: "), "{errors}");
    said
}

#[test]
fn a_participant_turns_a_page_in_the_headset_and_goes_on_there() {
    staged(
        "monado::study::a_participant_turns_a_page_in_the_headset_and_goes_on_there",
        || {
            let frames = next_page();
            let folder = tempfile::tempdir().unwrap();
            let service = Service::start(ServiceParams::default()).unwrap();
            let answers = folder.path().join("trial/P1/ramus/answers.json");
            let page = || -> u64 {
                let text = std::fs::read_to_string(&answers).unwrap_or_default();
                let told: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
                told["page"].as_u64().unwrap_or(0)
            };
            let said = sit(&service, folder.path(), || {
                let mut remote = Remote::connect(service.port()).unwrap();
                for _ in 0..20 {
                    for frame in &frames {
                        remote.send(&Packet::from_frame(frame).unwrap()).unwrap();
                        std::thread::sleep(LOOK);
                        if page() > 0 {
                            return;
                        }
                    }
                }
                panic!("the page was never turned");
            });
            assert!(said.contains("page 1 of 11"), "{said}");
            // Whoever comes again goes on there.
            let said = sit(&service, folder.path(), || ());
            assert!(said.contains("page 2 of 11"), "{said}");
            let recorded = std::fs::read_dir(answers.parent().unwrap())
                .unwrap()
                .filter(|file| {
                    let path = file.as_ref().unwrap().path();
                    path.extension().is_some_and(|ending| ending == "session")
                });
            assert_eq!(recorded.count(), 2, "both sittings are recorded");
            service.stop().unwrap();
        },
    );
}
