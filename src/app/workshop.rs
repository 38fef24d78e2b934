//! The session without its headset and its picture: world, project on disk, growing trees.
//!
//! A frame's order: input to the world, where hands point to the panels, what they want to the world, its edits to the
//! journal, its request for a tree to [`Grower`]. Trees of up to [`WorkshopParams::at_once`] segments grow within the frame, so an
//! edit shows in the next picture; larger ones grow on the worker and are swapped in when ready.

mod projects;
mod scanned;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use ramus_xr::profiles::Profile;
use ramus_xr::{Frame, Hand, Pulse, View};

use crate::app::abstracting::Abstracting;
use crate::app::comparing::Comparing;
use crate::app::convert::{buttons, input_from_frame};
use crate::app::finding::Finding;
use crate::app::planting::Planter;
use crate::app::previews::Previews;
use crate::app::scans::Scans;
use crate::app::store::{Opened, Store, StoreError};
use crate::app::studies::Studies;
use crate::app::study::sitting::{Keeper, Sitting};
use crate::app::takeaway::{Takeaway, Taken};
use crate::app::worker::Worker;
use crate::sketch::{Grower, Grown, Sketch};
use crate::ui::sheet::Tick;
use crate::ui::{CompareWish, Painted, Panels, Recent, Settings, Wish};
use crate::world::World;
use crate::world::board::Buttons;
use crate::world::document::Document;
use crate::world::panels::PanelId;
use crate::world::scene::Scene;
use crate::world::study::flow::Study;

/// How the workshop works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkshopParams {
    /// Trees with no more segments than this grow within the frame.
    pub at_once: u64,
    /// Length in seconds and strength (0 to 1) of the vibration when the pointer comes onto a part of a panel, and when it is pressed.
    pub ticks: [[f32; 2]; 2],
}

impl Default for WorkshopParams {
    /// 100,000 segments, as the specification of the sketch asks.
    fn default() -> Self {
        Self {
            at_once: 100_000,
            ticks: [[0.01, 0.2], [0.02, 0.5]],
        }
    }
}

/// A tree to grow on the worker, and what became of it.
type Wanted = (u64, Arc<Sketch>, u32);
type Ready = (u64, Result<Grown, String>);

/// What is told where something is to be written and nothing is kept.
const NO_PROJECT: &str = "There is no project to write beside: start Ramus with --project.";

/// World, project and trees of one session.
pub struct Workshop {
    world: World,
    panels: Panels,
    settings: Settings,
    takeaway: Takeaway,
    scans: Scans,
    studies: Studies,
    finding: Finding,
    abstracting: Abstracting,
    comparing: Comparing,
    planter: Planter,
    previews: Previews,
    /// Time of the last frame.
    clock: Option<f64>,
    store: Option<Store>,
    params: WorkshopParams,
    /// Grows what is small enough within the frame; both growers keep their last string.
    grower: Grower,
    worker: Worker<Wanted, Ready>,
    /// The request that the worker is busy with.
    growing: Option<u64>,
    /// Actions so far.
    edits: u64,
    scene: Scene,
    pulses: Vec<Pulse>,
    /// Paths of what both hands hold.
    held: [Option<&'static str>; 2],
    /// The last frame.
    last: Option<Frame>,
    /// The actions up to the last save.
    saved: u64,
    /// No other project is taken up: a recording holds one.
    stays: bool,
    /// Brings the sitting of a study to the disk.
    keeper: Option<Keeper>,
    /// Where models are, if not beside the project.
    models_in: Option<PathBuf>,
}

fn grow(grower: &mut Grower, (id, sketch, step): &Wanted, cancel: &AtomicBool) -> Ready {
    let grown = grower.grow(sketch, *step, cancel);
    (*id, grown.map_err(|error| error.to_string()))
}

/// The thread that grows what does not grow within a frame.
fn grow_worker() -> std::io::Result<Worker<Wanted, Ready>> {
    let mut grower = Grower::default();
    Worker::start("ramus-grow", move |wanted: &Wanted, cancel: &AtomicBool| {
        grow(&mut grower, wanted, cancel)
    })
}

impl Workshop {
    /// A session on an opened project.
    ///
    /// # Errors
    /// Where the system gives no thread for the worker.
    pub fn new(opened: Opened, params: WorkshopParams) -> std::io::Result<Self> {
        let mut world = World::new(opened.history);
        if let Some(message) = opened.message {
            world.show_message(message);
        }
        Self::with_world(world, Some(opened.store), params)
    }

    /// A session that keeps nothing on disk.
    ///
    /// # Errors
    /// Where the system gives no thread for the worker.
    pub fn unsaved(world: World) -> std::io::Result<Self> {
        Self::with_world(world, None, WorkshopParams::default())
    }

    fn with_world(
        world: World,
        store: Option<Store>,
        params: WorkshopParams,
    ) -> std::io::Result<Self> {
        Ok(Self {
            panels: Panels::new(&world),
            settings: Settings::default(),
            takeaway: Takeaway::start()?,
            scans: Scans::start()?,
            studies: Studies::start()?,
            finding: Finding::start()?,
            abstracting: Abstracting::start()?,
            comparing: Comparing::start()?,
            planter: Planter::start()?,
            previews: Previews::start()?,
            clock: None,
            world,
            store,
            params,
            worker: grow_worker()?,
            grower: Grower::default(),
            growing: None,
            edits: 0,
            scene: Scene::default(),
            pulses: Vec::new(),
            held: [None; 2],
            last: None,
            saved: 0,
            stays: false,
            keeper: None,
            models_in: None,
        })
    }

    /// Tells what both hands hold: the board says what its buttons do.
    pub fn hold(&mut self, controllers: [Option<&'static Profile>; 2]) {
        let held = controllers.map(|controller| controller.map(|profile| profile.path));
        if self.held != held {
            self.held = held;
            self.world.take_buttons(buttons(controllers));
        }
    }

    /// Tells what the board calls the buttons, where nothing is held in hands.
    pub fn name_buttons(&mut self, buttons: Buttons) {
        self.world.take_buttons(buttons);
    }

    /// Takes one frame of input and brings everything up to it; gives the vibrations to send.
    pub fn update(&mut self, frame: &Frame) -> &[Pulse] {
        self.last = Some(*frame);
        self.pulses.clear();
        let haptics = self.world.update(&input_from_frame(frame));
        self.pulses.extend(haptics.iter().map(|haptic| Pulse {
            hand: haptic.hand,
            duration: haptic.seconds,
            amplitude: haptic.amplitude,
        }));
        self.use_panels(frame.time);
        self.follow_scans();
        self.keep_journal();
        self.keep_sitting();
        self.grow_tree();
        self.planter.follow(&mut self.world);
        self.previews
            .follow(&mut self.panels, self.world.document());
        &self.pulses
    }

    /// Looks at the panels and does what is wanted there.
    fn use_panels(&mut self, time: f64) {
        let before = self.clock.replace(time).unwrap_or(time);
        // Nonsense moves no clock.
        let passed = Some(time - before).filter(|passed| passed.is_finite());
        let passed = passed.unwrap_or(0.0);
        let (wishes, ticks) = self.panels.look(&self.world, self.settings, passed);
        let [hover, click] = self.params.ticks;
        self.pulses.extend(ticks.iter().map(|&(hand, tick)| {
            let [duration, amplitude] = match tick {
                Tick::Hover => hover,
                Tick::Click => click,
            };
            Pulse {
                hand,
                duration,
                amplitude,
            }
        }));
        if !wishes.is_empty() {
            for wish in std::mem::take(wishes) {
                self.carry_out(wish);
            }
        }
        if let Some(told) = self.takeaway.poll() {
            self.world.show_message(told);
        }
        self.world.grow_likeness(passed);
    }

    fn carry_out(&mut self, wish: Wish) {
        let world = &mut self.world;
        let mut done = Ok(());
        match wish {
            Wish::Edit(edit) => done = world.apply(edit),
            Wish::TryOut(edit) => done = world.try_out(edit),
            Wish::Settle => world.settle(),
            Wish::Undo => _ = world.undo(),
            Wish::Redo => _ = world.redo(),
            Wish::Step(steps) => world.step_by(steps),
            Wish::Play(on) => world.play(on),
            Wish::Speed(speed) => world.set_speed(speed),
            Wish::Scrub(moment) => world.scrub(moment),
            Wish::Show(panel, shown) => world.show_panel(panel, shown),
            Wish::Set(settings) => self.set(settings),
            Wish::Export(ending) => self.take_home(ending),
            Wish::Open(project) => self.go_on_with(&project),
            Wish::TakeSketch(project) => self.take_sketch(&project),
            Wish::Draw(settings) => world.set_settings(settings),
            Wish::Look(looking) => world.look(looking),
            Wish::Bring(file) => self.bring_named(&file),
            Wish::Mark(mark) => done = world.mark(mark),
            Wish::WriteEnds(model, ending) => self.write_ends(model, ending),
            Wish::ReadEnds(model, file) => self.read_ends(model, &file),
            Wish::FindModels => {
                self.world.try_models_again();
                self.offer_models();
            }
            Wish::Line(wish) => self.do_with_lines(wish),
            Wish::Abstraction(wish) => self.do_with_abstraction(wish),
            Wish::Compare(CompareWish::With(at, with)) => world.compare(at, with),
            Wish::Compare(CompareWish::LayOver(how)) => world.lay_over(how),
            Wish::StopReading => self.stop_reading(),
            Wish::Teach(lesson) => world.teach(lesson),
            Wish::Study(event) => done = world.act_in_study(event),
        }
        if let Err(error) = done {
            self.world.show_message(error.to_string());
        }
    }

    /// Takes what the person has set.
    pub fn set(&mut self, settings: Settings) {
        self.settings = settings;
        self.world.set_room(settings.room);
    }

    /// Begins the tutorial with a lesson.
    pub fn teach(&mut self, lesson: usize) {
        self.world.teach(Some(lesson));
    }

    /// Begins the sitting of a study or goes on with it; what is answered is written as it is answered.
    ///
    /// # Errors
    /// Where the system gives no thread for that.
    pub fn sit(&mut self, sitting: Sitting) -> std::io::Result<()> {
        self.world.begin_study(sitting.study());
        self.panels.give_pictures(sitting.told.pictures.clone());
        self.keeper = Some(Keeper::start(sitting)?);
        Ok(())
    }

    /// Begins a sitting of which nothing is written, as a recording tells it.
    pub fn sit_unkept(&mut self, study: Study) {
        self.world.begin_study(study);
    }

    /// Ends a sitting: all of it is written.
    ///
    /// # Errors
    /// Where the disk does not take it.
    pub fn rise(&mut self) -> anyhow::Result<()> {
        let keeper = self.keeper.take();
        keeper.map_or(Ok(()), |keeper| keeper.finish(&self.world))
    }

    fn keep_sitting(&mut self) {
        let keeper = self.keeper.as_mut();
        if let Some(told) = keeper.and_then(|keeper| keeper.follow(&self.world)) {
            self.world.show_message(told);
        }
    }

    /// What the person has set.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// The project that is worked on.
    #[must_use]
    pub fn project(&self) -> Option<&Path> {
        self.store.as_ref().map(Store::project)
    }

    /// Shows a panel or hides it.
    pub fn show_panel(&mut self, panel: PanelId, shown: bool) {
        self.world.show_panel(panel, shown);
    }

    /// Offers projects to go on with.
    pub fn offer(&mut self, recent: Vec<Recent>) {
        self.panels.offer(recent);
    }

    /// From now on no other project is taken up.
    pub fn stay_in_project(&mut self) {
        self.stays = true;
    }

    /// Writes the tree, or its grammar, beside the project.
    fn take_home(&mut self, ending: &str) {
        let Some(store) = &self.store else {
            return self.world.show_message(NO_PROJECT.into());
        };
        let project = store.project().to_owned();
        let what = Taken::Tree(self.world.document().clone());
        self.take_away(what, &project, ending);
    }

    fn take_away(&mut self, what: Taken, name: &Path, ending: &str) {
        if !self.takeaway.ask(what, name, ending) {
            let told = "So many files wait to be written that this one is left out: ask again when they are there.";
            self.world.show_message(told.into());
        }
    }

    /// Where the n-th text (from 1) that is this one stands on a panel, metres right of and below its upper left corner; for lessons and tests, which ask with
    /// [`Self::keep_texts`] that texts are kept.
    #[must_use]
    pub fn find_text(&self, panel: PanelId, text: &str, nth: usize) -> Option<glam::Vec2> {
        self.panels.find_text(panel, text, nth)
    }

    /// The texts on a panel, where they are kept.
    pub fn texts(&self, panel: PanelId) -> impl Iterator<Item = &str> {
        self.panels.texts(panel)
    }

    /// Keeps where texts stand on panels from now on.
    pub fn keep_texts(&mut self) {
        self.panels.keep_texts();
    }

    /// Says that no picture is drawn: panels are used all the same.
    pub fn unseen(&mut self) {
        self.panels.unseen();
    }

    /// What panels show, with their slots, where it changed since it was taken last.
    pub fn take_painted(&mut self) -> impl Iterator<Item = (usize, Painted)> {
        self.panels.take_painted()
    }

    /// Where the eyes are on the stage.
    #[must_use]
    pub fn on_stage(&self, views: [View; 2]) -> [View; 2] {
        let (_, orientation, position) =
            self.world.stage_from_room().to_scale_rotation_translation();
        let room = ramus_xr::Pose {
            orientation,
            position,
        };
        views.map(|view| View {
            pose: room * view.pose,
            ..view
        })
    }

    /// What is to be seen now.
    pub fn scene(&mut self) -> &Scene {
        self.world.scene(&mut self.scene);
        &self.scene
    }

    /// Shows a sentence on the board.
    pub fn show_message(&mut self, text: String) {
        self.world.show_message(text);
    }

    /// The world, to ask it.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The document as it would be saved.
    #[must_use]
    pub fn document(&self) -> &Document {
        self.world.document()
    }

    /// How many actions there were in this session.
    #[must_use]
    pub fn edits(&self) -> u64 {
        self.edits
    }

    /// Whether a tree is growing on a worker, or is being drawn for a panel.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        self.growing.is_some() || self.planter.is_busy() || self.previews.is_busy()
    }

    /// Waits for the pictures of individuals that are looked at; the next frame shows them.
    pub fn finish_previews(&mut self) {
        self.previews
            .finish(&mut self.panels, self.world.document());
    }

    /// Waits for trees that are growing on workers and for files that are being written, if any.
    pub fn finish_tree(&mut self) {
        for told in self.takeaway.finish() {
            self.world.show_message(told);
        }
        while self.growing.is_some()
            && let Some((id, grown)) = self.worker.wait()
        {
            self.take_tree(id, grown);
        }
    }

    /// Waits until all planted trees have grown.
    pub fn finish_planted(&mut self) {
        self.planter.finish(&mut self.world);
    }

    /// The headset is gone: strokes and drags that are under way end where they are, as when the focus goes, and the next
    /// picture is told all that panels show.
    pub fn let_go(&mut self) {
        self.show_anew();
        if let Some(last) = self.last {
            self.update(&Frame {
                focused: false,
                hands: [Hand::ABSENT; 2],
                ..last
            });
        }
    }

    /// The picture is made anew: panels are laid out again with the next frame, so that all of what they show reaches it.
    pub fn show_anew(&mut self) {
        self.panels.show_anew();
    }

    /// Saves the project as it is, if there was an edit since it was saved last; the session goes on.
    ///
    /// # Errors
    /// Where the project cannot be written; the journal still holds everything.
    pub fn save(&mut self) -> Result<(), StoreError> {
        if let Some(store) = self.store.as_mut().filter(|_| self.saved != self.edits) {
            store.save(self.world.document())?;
            self.saved = self.edits;
        }
        Ok(())
    }

    /// Saves the project and ends the session; gives the world back for exports.
    ///
    /// # Errors
    /// Where the project cannot be written; the journal still holds everything.
    pub fn close(mut self) -> Result<World, StoreError> {
        // A stroke in the hand and what is tried out are work, too.
        self.let_go();
        if let Some(store) = self.store.take() {
            store.close(self.world.document())?;
        }
        Ok(self.world)
    }

    /// Ends a session that failed; gives the file that what was made is saved in. See [`Store::set_aside`].
    ///
    /// # Errors
    /// As [`Self::close`].
    pub fn set_aside(mut self) -> Result<Option<PathBuf>, StoreError> {
        self.let_go();
        match self.store.take() {
            Some(store) => store.set_aside(self.world.document()),
            None => Ok(None),
        }
    }

    fn keep_journal(&mut self) {
        let actions = self.world.take_edits();
        if let Some((lesson, _)) = self.world.lesson() {
            self.settings.lesson = lesson;
        }
        self.edits += actions.len() as u64;
        let Some(store) = &mut self.store else { return };
        // A warm frame without edits neither writes nor allocates.
        let kept = if actions.is_empty() {
            store.check()
        } else {
            store.append(&actions)
        };
        if let Err(error) = kept {
            self.world.show_message(format!(
                "{error}. Your work is kept in memory and written with the next edit."
            ));
        }
    }

    /// Takes a tree from the worker; an older one than the newest asked for leaves it busy.
    fn take_tree(&mut self, id: u64, grown: Result<Grown, String>) {
        self.growing = self.growing.filter(|&newest| newest != id);
        self.world.set_tree(id, grown);
    }

    fn grow_tree(&mut self) {
        if let Some((id, grown)) = self.worker.poll() {
            self.take_tree(id, grown);
        }
        let Some(request) = self.world.tree_request() else {
            return;
        };
        let wanted = (request.id, Arc::clone(&request.sketch), request.step);
        if request.segments <= self.params.at_once {
            let (id, grown) = grow(&mut self.grower, &wanted, &AtomicBool::new(false));
            self.growing = None;
            self.world.set_tree(id, grown);
        } else {
            self.growing = Some(wanted.0);
            self.worker.ask(wanted);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use super::*;
    use crate::app::demonstration;
    use crate::world::history::History;
    use crate::world::project;

    fn made(frames: &[Frame], mut before_each: impl FnMut(usize, &mut Workshop)) -> Vec<u8> {
        let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        for (at, frame) in frames.iter().enumerate() {
            before_each(at, &mut workshop);
            workshop.update(frame);
        }
        project::to_bytes(workshop.document())
    }

    #[test]
    fn a_headset_that_is_gone_ends_a_drag_as_a_lost_focus_does() {
        let frames = demonstration::first_tree().unwrap();
        // The left hand grips the platform, moves it and lets it go.
        let squeezed = |frame: &Frame| frame.hands[0].squeeze > 0.9;
        let gripped = frames.iter().position(squeezed).unwrap();
        let last = frames.iter().rposition(squeezed).unwrap();
        let middle = gripped.midpoint(last);
        let frames = &frames[..last + 20];
        let project = |made: Vec<u8>| String::from_utf8(made).unwrap();
        let whole = project(made(frames, |_, _| {}));
        let let_go = project(made(frames, |at, workshop| {
            if at == middle {
                workshop.let_go();
            }
        }));
        let unfocused = project(made(frames, |at, workshop| {
            if at == middle {
                workshop.update(&Frame {
                    focused: false,
                    hands: [Hand::ABSENT; 2],
                    ..frames[middle - 1]
                });
            }
        }));
        assert_eq!(let_go, unfocused);
        assert_ne!(let_go, whole, "the drag ended there");
        // Before the first frame there is nothing to let go.
        Workshop::unsaved(World::new(History::default()))
            .unwrap()
            .let_go();
    }

    #[test]
    fn a_picture_that_is_made_anew_gets_all_that_panels_show() {
        let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        workshop.carry_out(Wish::Show(PanelId::Bench, true));
        let mut frame = Frame::start();
        // The slots that are painted with a frame, those with a font among them.
        let mut painted = |workshop: &mut Workshop| {
            frame.time += 0.011;
            workshop.update(&frame);
            let mut slots = Vec::new();
            for (slot, mut painted) in workshop.take_painted() {
                if !painted.textures.set.is_empty() {
                    slots.push(slot);
                }
                painted.textures.clear();
            }
            slots
        };
        let first = painted(&mut workshop);
        assert!(first.contains(&PanelId::Bench.slot()), "{first:?}");
        for _ in 0..20 {
            painted(&mut workshop);
        }
        assert!(painted(&mut workshop).is_empty(), "nothing changes");
        workshop.show_anew();
        assert_eq!(painted(&mut workshop), first);
    }
}
