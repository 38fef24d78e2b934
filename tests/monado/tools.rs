//! The recorded session of each tool (`assets/sessions/tools`) through the real runtime, and panels that the runtime shows by
//! itself.

use std::path::Path;

use ramus::app::headset::connect;
use ramus::app::picture::Picture;
use ramus::app::session::{self, Nobody};
use ramus::render::{Gpu, GpuParams, NEAR};
use ramus::world::lesson::Lesson;
use ramus_monado::{feed::Fed, remote::Remote};
use ramus_xr::openxr::{OpenXrHeadset, StartParams};
use ramus_xr::quad::{QuadId, QuadImages, QuadPlace};
use ramus_xr::{Frame, Headset, HeadsetError, Tick, VisibilityMask, profiles::Profile};

use super::super::{bytes, runtime, staged, workshop};

/// A tool's session, and the project that the simulated headset makes of it.
fn recorded(lesson: Lesson) -> (Vec<Frame>, String) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/sessions/tools");
    let name = format!("{lesson:?}").to_lowercase();
    let frames = ramus_xr::session::read_file(&folder.join(format!("{name}.session"))).unwrap();
    let project = std::fs::read_to_string(folder.join(format!("{name}.ramus"))).unwrap();
    (frames, project)
}

/// Whether grip and aim of each hand are the same in all frames.
fn has_one_pose(frames: &[Frame]) -> bool {
    let mut hands = frames.iter().flat_map(|frame| &frame.hands);
    hands.all(|hand| !hand.tracked || hand.grip == hand.aim)
}

/// A headset that is fed with one session after the other, each of which ends for itself.
struct InTurn<I> {
    inner: Fed<OpenXrHeadset, I>,
    /// Frames to the present session's end.
    left: usize,
    /// How often a quad was filled, and where each was placed last.
    filled: usize,
    places: Vec<Option<QuadPlace>>,
}

impl<I: Iterator<Item = Frame>> Headset for InTurn<I> {
    ramus_xr::forward_headset!(inner: describe, extent, swapchain, begin, views, end, vibrate, request_exit);

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        if self.left == 0 {
            return Ok(Tick::Exit);
        }
        let tick = self.inner.wait()?;
        self.left -= usize::from(matches!(tick, Tick::Frame(_)));
        Ok(tick)
    }

    fn controllers(&self) -> [Option<&'static Profile>; 2] {
        self.inner.controllers()
    }

    fn worn(&self) -> bool {
        self.inner.worn()
    }

    fn visibility_mask(&self) -> Option<&VisibilityMask> {
        self.inner.visibility_mask()
    }

    fn make_quad(&mut self, extent: ash::vk::Extent2D) -> Result<Option<QuadId>, HeadsetError> {
        self.places.push(None);
        self.inner.make_quad(extent)
    }

    fn quad_images(&self, quad: QuadId) -> Option<&QuadImages> {
        self.inner.quad_images(quad)
    }

    fn acquire_quad(&mut self, quad: QuadId) -> Result<Option<usize>, HeadsetError> {
        self.filled += 1;
        self.inner.acquire_quad(quad)
    }

    fn place_quad(&mut self, quad: QuadId, place: Option<QuadPlace>) {
        self.places[quad.number()] = place;
        self.inner.place_quad(quad, place);
    }
}

/// Plays the sessions of these lessons, with their panels in the scene or as layers; `played` looks after each.
fn play(lessons: &[Lesson], layers: bool, mut played: impl FnMut(usize, &[Option<QuadPlace>])) {
    let service = runtime();
    let remote = Remote::connect(service.port()).unwrap();
    let system = connect().unwrap();
    let gpu = Gpu::new(&system, &GpuParams::from_env()).unwrap();
    let headset = system
        .start_on(Box::new(gpu.clone()), StartParams::new(NEAR))
        .unwrap();
    let mut picture = Picture::in_headset(&gpu, headset.swapchain().unwrap()).unwrap();
    let sessions: Vec<_> = lessons.iter().map(|lesson| recorded(*lesson)).collect();
    let frames: Vec<Frame> = (sessions.iter())
        .flat_map(|(frames, _)| frames.iter().copied())
        .collect();
    println!("{} frames", frames.len());
    let mut headset = InTurn {
        inner: Fed::new(headset, remote, frames.into_iter()),
        left: 0,
        filled: 0,
        places: Vec::new(),
    };
    for (lesson, (frames, project)) in lessons.iter().zip(&sessions) {
        headset.left = frames.len();
        let mut workshop = workshop();
        let number = Lesson::ALL.iter().position(|other| other == lesson);
        workshop.teach(number.unwrap());
        let mut settings = workshop.settings();
        settings.layers = layers;
        workshop.set(settings);
        session::run(&mut headset, &mut workshop, Some(&mut picture), &mut Nobody).unwrap();
        assert_eq!(headset.left, 0, "{lesson:?}: all of it was played");
        assert_eq!(
            String::from_utf8(bytes(&workshop)).as_deref(),
            Ok(project.as_str()),
            "{lesson:?}: left: through the runtime, right: simulated"
        );
        played(headset.filled, &headset.places);
    }
    // The session ends in good order.
    headset.left = usize::MAX;
    let rest = session::run(&mut headset, &mut workshop(), None, &mut Nobody);
    rest.unwrap();
    drop(picture);
    drop(headset);
    drop(gpu);
    service.stop().unwrap();
}

#[test]
fn tools_do_on_the_runtime_what_they_do_on_the_simulated_headset() {
    staged(
        "monado::tools::tools_do_on_the_runtime_what_they_do_on_the_simulated_headset",
        || {
            // The remote driver has one pose a hand: it cannot turn the back of a hand to the eyes and point ahead.
            let (shown, unshown): (Vec<Lesson>, Vec<Lesson>) =
                (Lesson::ALL.into_iter()).partition(|lesson| has_one_pose(&recorded(*lesson).0));
            assert_eq!(unshown, [Lesson::Wrist]);
            play(&shown, false, |filled, places| {
                assert_eq!((filled, places.len()), (0, 0), "panels are in the scene");
            });
        },
    );
}

#[test]
fn panels_that_the_runtime_shows_by_itself_are_used_as_those_in_the_scene() {
    staged(
        "monado::tools::panels_that_the_runtime_shows_by_itself_are_used_as_those_in_the_scene",
        || {
            let mut before = 0;
            play(&[Lesson::Draw, Lesson::Panel], true, |filled, places| {
                // The board and the tutorial are there in any case.
                let shown = places.iter().flatten().count();
                assert!(shown >= 2, "{places:?}");
                assert!(filled >= before + shown, "each was filled: {filled}");
                before = filled;
            });
        },
    );
}
