//! What stands on stage and what each tool does: pure logic, no GPU, no OpenXR, no threads.
//!
//! In: an [`Input`] a frame. Out: edits of the document, vibrations, wishes for
//! a tree, and a [`Scene`]. [`tools`] turns button edges into edits, [`history`]
//! keeps them, `miniature` and [`stage`] make the picture, `growth` lets
//! the full-size tree grow on the eye, [`board`] says it all in text.
//!
//! A frame in which nothing happens allocates nothing; `tests/world_alloc.rs` holds that.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use crate::sketch::{Grown, Sketch};
use crate::tree::foliage::Bare;

pub mod abstracting;
mod at_hand;
pub mod board;
pub mod branches;
pub mod comparing;
pub mod document;
#[cfg(test)]
mod document_tests;
mod grip;
pub mod grove;
mod growth;
pub mod handles;
pub mod hands;
mod haptics;
pub mod history;
mod hold;
pub mod hover;
pub mod input;
pub mod journal;
pub mod lesson;
pub mod likeness;
pub mod lines;
mod marking;
pub mod marks;
mod meant;
mod miniature;
pub mod model;
pub mod models;
pub mod panels;
pub mod planted;
mod planting;
mod play;
pub mod project;
pub mod room;
mod scanned;
pub mod scene;
pub mod settings;
mod signs;
mod snap;
pub mod species;
pub mod stage;
mod stroke;
pub mod study;
pub mod taken;
pub mod tools;
mod tried;

use board::{BoardParams, Buttons, Facts, LiveBoard};
use document::{Document, Edit, EditError};
use growth::Growth;
use handles::{HandleId, Says};
use history::{Action, History};
use input::Input;
use lesson::Course;
use panels::{PanelId, PanelPointer};
use play::Player;
use room::{Rig, RoomParams, RoomSettings};
use scene::{Ball, Controller, Rod, Scene};
use stage::{Palette, StageParams};
use study::flow::Study;
use tools::{Hover, Tools};

pub use grip::GripParams;
pub use growth::{GrowthParams, TreeRequest};
pub use hold::HoldParams;
pub use planting::PlantParams;
pub use play::PlayParams;
pub use settings::{DrawSettings, DrawTool};
pub use tools::{Haptic, Met, ToolParams};

/// Everything about the world that can be set.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldParams {
    /// Sizes and places.
    pub stage: StageParams,
    /// Colours.
    pub palette: Palette,
    /// How the tools act.
    pub tools: ToolParams,
    /// How growth is shown.
    pub growth: GrowthParams,
    /// How playback runs.
    pub play: PlayParams,
    /// How people move about.
    pub room: RoomParams,
    /// How much text the board takes.
    pub board: BoardParams,
    /// Seconds for which a message stays.
    pub message_seconds: f32,
    /// Longest time by which one frame moves the picture on, seconds.
    pub longest_frame: f64,
}

impl Default for WorldParams {
    fn default() -> Self {
        Self {
            stage: StageParams::default(),
            palette: Palette::default(),
            tools: ToolParams::default(),
            growth: GrowthParams::default(),
            play: PlayParams::default(),
            room: RoomParams::default(),
            board: BoardParams::default(),
            message_seconds: 8.0,
            longest_frame: 0.1,
        }
    }
}

/// Something to be told, and for how much longer.
#[derive(Debug)]
struct Message {
    text: String,
    seconds: f32,
}

/// The stage with all that stands on it, the tools, and the document in their hands.
#[derive(Debug)]
pub struct World {
    params: WorldParams,
    history: History,
    tools: Tools,
    growth: Growth,
    player: Player,
    rig: Rig,
    course: Course,
    /// The sitting of a study, if this is one.
    study: Option<Study>,
    /// How many edits there were when its task began.
    before_task: usize,
    /// The sketch as it was when its rules were looked at last.
    ruled: Arc<Sketch>,
    board: LiveBoard,
    /// The grown string, perhaps cut.
    string: String,
    string_revision: u64,
    message: Option<Message>,
    /// Time of the last frame.
    clock: Option<f64>,
}

impl World {
    /// A world with this document and its past.
    #[must_use]
    pub fn new(history: History) -> Self {
        Self::with_params(history, WorldParams::default())
    }

    /// A world that is set differently.
    #[must_use]
    pub fn with_params(history: History, params: WorldParams) -> Self {
        let tools = Tools::new(
            history.committed(),
            params.tools,
            params.stage,
            params.palette,
        );
        let ruled = Arc::clone(&history.committed().sketch);
        let mut world = Self {
            params,
            history,
            tools,
            growth: Growth::default(),
            player: Player::new(&params.play),
            rig: Rig::new(params.room),
            course: Course::default(),
            study: None,
            before_task: 0,
            ruled,
            board: LiveBoard::default(),
            string: String::new(),
            string_revision: 0,
            message: None,
            clock: None,
        };
        world.wish();
        world.compose();
        world
    }

    /// Acts on one frame; gives the vibrations that belong to it.
    pub fn update(&mut self, input: &Input) -> &[Haptic] {
        let passed = self.pass(input.time);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "at most a tenth of a second"
        )]
        let seconds = passed.min(self.params.longest_frame) as f32;
        if !input.focused {
            // What is tried out becomes an edit then, and playback would make one of every step.
            self.player.playing = false;
        } else if let Some(study) = &mut self.study {
            // Nobody works while the system's menu is before their eyes.
            study.pass(passed);
        }
        let on_panel = self
            .tools
            .hands
            .map(|hand| matches!(hand.hover, Hover::Panel(_)));
        let input = &self.rig.follow(input, seconds, on_panel);
        self.tools.update(input, passed, &mut self.history);
        let cutting = usize::from(self.rig.settings.left_handed);
        self.tools.follow_looking(cutting);
        if let Some(text) = self.tools.take_message() {
            self.show_message(text);
        }
        self.follow_moment(f64::from(seconds));
        self.growth.advance(seconds, &self.params.growth);
        if let Some(message) = &mut self.message {
            message.seconds -= seconds;
            if message.seconds <= 0.0 {
                self.message = None;
            }
        }
        self.wish();
        self.compose();
        &self.tools.haptics
    }

    /// Seconds since the last frame; none where the clock stands still, goes back or says nonsense.
    fn pass(&mut self, time: f64) -> f64 {
        if !time.is_finite() {
            return 0.0;
        }
        let passed = self.clock.map_or(0.0, |before| time - before);
        self.clock = Some(time);
        passed.max(0.0)
    }

    /// Wishes for the tree of what is seen, unless it is there or would be too large.
    fn wish(&mut self) {
        let document = &self.tools.shown;
        if !self.growth.is_new(document) {
            return;
        }
        let most = self.params.growth.max_segments;
        let predictor = &mut self.tools.predictor;
        if let Some(segments) = predictor.within(&document.sketch, document.step, most) {
            self.growth.wish(document, segments);
            return;
        }
        self.growth.note(document);
        let step = document.step;
        self.show_message(format!(
            "At step {step} this sketch has more than {most} segments: the tree shown is an earlier one; step back to see it again."
        ));
    }

    fn compose(&mut self) {
        let facts = Facts {
            string: &self.string,
            segments: self.growth.segments(),
            waiting: self.growth.is_waiting(),
            undo: [self.undo_count(), self.history.redo_count()],
            message: self.message.as_ref().map(|message| &*message.text),
            string_revision: self.string_revision,
        };
        self.board
            .follow(self.history.committed(), &facts, &self.params.board);
    }

    /// What is kept: without what hands are still holding.
    #[must_use]
    pub fn document(&self) -> &Document {
        self.history.committed()
    }

    /// What is seen: with what hands are holding where they hold it.
    #[must_use]
    pub fn shown(&self) -> &Document {
        &self.tools.shown
    }

    /// Where the selected node is on the stage, metres.
    #[must_use]
    pub fn selected_position(&self) -> Option<Vec3> {
        self.tools.miniature.position(self.tools.shown.selected)
    }

    /// What a hand would mean that points along a ray from `origin`, on the stage; `direction` is a unit vector. For pointers
    /// that have no place in the room of their own, such as a mouse.
    #[must_use]
    pub fn met(&self, origin: Vec3, direction: Vec3) -> Option<Met> {
        self.tools.met(origin, direction)
    }

    /// Whether a message stands on the board, which goes by itself.
    #[must_use]
    pub fn has_message(&self) -> bool {
        self.message.is_some()
    }

    /// The document's past and future.
    #[must_use]
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Applies an edit that comes from a panel. Hands let go of what it takes away.
    ///
    /// # Errors
    /// Where the edit is refused; nothing changes then.
    pub fn apply(&mut self, edit: Edit) -> Result<(), EditError> {
        if matches!(edit, Edit::Clear | Edit::SetStep { .. }) {
            // A step that is still tried out would lie over the new one.
            self.tools.settle(&mut self.history);
        }
        self.history.apply(edit)?;
        self.tools.check_holds(&self.history);
        self.follow_history();
        Ok(())
    }

    /// Shows the document as it would be after an edit that a panel is making, in place of the last one of its kind;
    /// [`Self::settle`] makes it an edit.
    ///
    /// # Errors
    /// Where the edit is refused; what was shown stays.
    pub fn try_out(&mut self, edit: Edit) -> Result<(), EditError> {
        self.tools.try_out(edit, &self.history)?;
        self.follow_history();
        Ok(())
    }

    /// What the person has set about themselves in the room.
    #[must_use]
    pub fn room(&self) -> RoomSettings {
        self.rig.settings
    }

    /// Sets that.
    pub fn set_room(&mut self, settings: RoomSettings) {
        self.rig.settings = settings;
    }

    /// The real room, which headsets speak of, to the stage: where the person was set, turned and lifted.
    #[must_use]
    pub fn stage_from_room(&self) -> Affine3A {
        self.rig.stage_from_room()
    }

    /// Where a hand is on a panel.
    #[must_use]
    pub fn pointer(&self, id: PanelId) -> Option<PanelPointer> {
        self.tools.pointer(id)
    }

    /// Whether a panel is there.
    #[must_use]
    pub fn has_panel(&self, id: PanelId) -> bool {
        self.tools.panels.is_shown(id)
    }

    /// Shows a panel or hides it.
    pub fn show_panel(&mut self, id: PanelId, shown: bool) {
        self.tools.panels.show(id, shown);
    }

    /// Width and height of a panel, metres.
    #[must_use]
    pub fn panel_size(&self, id: PanelId) -> [f32; 2] {
        self.tools.panels.size(id).to_array()
    }

    /// What is to be said beside the handle that a hand is at.
    #[must_use]
    pub fn says(&self) -> Option<Says> {
        self.tools.says().map(|(says, _)| says)
    }

    /// How drawing acts.
    #[must_use]
    pub fn settings(&self) -> DrawSettings {
        self.tools.params.settings
    }

    /// Sets how drawing acts, brought within its bounds. Strokes in the hands go on as they began; another tool ends
    /// them.
    pub fn set_settings(&mut self, settings: DrawSettings) {
        self.tools.set_settings(settings, &mut self.history);
        self.follow_history();
    }

    /// Undoes the last edit; hands let go of everything, and a stroke in the hand is the last edit. False: there was none.
    pub fn undo(&mut self) -> bool {
        self.player.playing = false;
        self.tools.untry();
        self.tools.finish_strokes(&mut self.history);
        self.tools.let_go();
        let done = self.undo_count() > 0 && self.history.undo();
        self.follow_history();
        done
    }

    /// How many edits can be undone: in the task of a study those of the task alone.
    #[must_use]
    pub fn undo_count(&self) -> usize {
        let begun = self.study.as_ref().is_some_and(Study::is_begun);
        let before = if begun { self.before_task } else { 0 };
        self.history.undo_count().saturating_sub(before)
    }

    /// Redoes the last edit undone; hands let go of everything. False: there was none.
    pub fn redo(&mut self) -> bool {
        self.player.playing = false;
        self.tools.untry();
        self.tools.finish_strokes(&mut self.history);
        self.tools.let_go();
        let done = self.history.redo();
        self.follow_history();
        done
    }

    fn follow_history(&mut self) {
        self.tools.show(&self.history);
        let seen = &self.tools.shown;
        self.tools.models.keep([self.history.committed(), seen]);
        self.wish();
        self.compose();
    }

    /// What was done since the last call, in order, for the journal.
    #[must_use = "an action that is not written down is lost"]
    pub fn take_edits(&mut self) -> Vec<Action> {
        let actions = self.history.take_log();
        self.learn(&actions);
        self.tell_of_rules(&actions);
        actions
    }

    /// Says when a rule of a person's own went with the line it stood for, and when one keeps a new branch from growing.
    fn tell_of_rules(&mut self, actions: &[Action]) {
        let now = Arc::clone(&self.document().sketch);
        let before = std::mem::replace(&mut self.ruled, Arc::clone(&now));
        let meant = |action: &Action| !matches!(action, Action::Edit(edit) if !matches!(edit, Edit::SetRule { .. }));
        if actions.is_empty() || actions.iter().any(meant) {
            return;
        }
        if now.own_rules.len() < before.own_rules.len() {
            self.show_message(
                "A rule of yours went with the one it stood for: undo brings both back.".into(),
            );
        } else if now.has_branch_left_to_rules(&before) {
            self.show_message(
                "A rule of yours says what branches there: the new branch grows when that rule names it, or is as drawn."
                    .into(),
            );
        }
    }

    /// The tree that the world would like to show next, if it has not been taken yet. A newer wish replaces
    /// an older one that nobody took.
    pub fn tree_request(&mut self) -> Option<TreeRequest> {
        self.growth.take_request()
    }

    /// Gives the tree of a [`TreeRequest`], or a sentence that says why there is none. A tree that is older than
    /// the one shown is dropped.
    pub fn set_tree(&mut self, id: u64, grown: Result<Grown, String>) {
        match grown {
            Ok(grown) => {
                if let Some(string) = self.growth.give(id, grown)
                    && string != self.string
                {
                    self.string = string;
                    self.string_revision += 1;
                }
            }
            Err(text) => {
                if self.growth.fail(id) {
                    self.show_message(text);
                }
            }
        }
        self.compose();
    }

    /// What the tree that is shown should bear and does not.
    #[must_use]
    pub fn bare(&self) -> &[Bare] {
        self.growth.bare()
    }

    /// Whether the picture moves by itself now: a step is growing or shrinking, or the tree plays.
    #[must_use]
    pub fn is_growing(&self) -> bool {
        self.growth.is_moving() || self.player.playing
    }

    /// Whether a hand holds or points at something.
    #[must_use]
    pub fn is_touched(&self) -> bool {
        self.tools
            .hands
            .iter()
            .any(|hand| hand.hold != tools::Hold::Nothing || hand.hover != Hover::Nothing)
    }

    /// What people call the parts of the controllers in hand.
    #[must_use]
    pub fn buttons(&self) -> &Buttons {
        self.board.buttons()
    }

    /// Says on the board what the buttons of these controllers do.
    pub fn take_buttons(&mut self, buttons: Buttons) {
        self.board.take_buttons(buttons);
        self.compose();
    }

    /// Shows a sentence on the board for some seconds.
    pub fn show_message(&mut self, text: String) {
        self.message = Some(Message {
            text,
            seconds: self.params.message_seconds,
        });
        self.compose();
    }

    /// Describes this frame's picture. The scene's vectors keep their capacity.
    pub fn scene(&self, scene: &mut Scene) {
        let WorldParams { stage, palette, .. } = &self.params;
        scene.rods.clear();
        scene.balls.clear();
        scene.plates.clear();
        scene.controllers.clear();
        scene.panels.clear();
        scene.models.clear();
        self.tools.panels.draw(scene);
        self.tools.draw_handles(scene);
        self.rig.draw(palette.ghost, scene);
        let hovers = self.tools.hands.map(|hand| hand.hover);
        let rim_held = self
            .tools
            .hands
            .iter()
            .any(|hand| hand.hold == tools::Hold::Platform);
        let rim_hovered = rim_held
            || hovers
                .iter()
                .any(|hover| matches!(hover, Hover::Rim { .. }));
        let document = &self.tools.shown;
        stage::furniture(
            &document.platform,
            rim_hovered,
            stage,
            palette,
            &mut scene.plates,
        );
        let meant = |at| self.tools.means_model(at);
        let (models, head) = (&self.tools.models, self.tools.head);
        let seen = self.seen_through(document);
        models.draw(&seen, meant, stage, palette, head, scene);
        let lit = [0, 1].map(|hand| self.tools.end_meant(hand));
        models.draw_marks(document, lit, head, scene);
        let both = [document, self.history.committed()];
        let branches = [0, 1].map(|hand| self.tools.branch_meant(hand));
        models.draw_lines(both, branches, head, scene);
        self.draw_overlay(document, scene);
        self.tools.draw_grove(palette, stage, scene);
        let highlights = self.tools.hands.map(|hand| match (hand.hold, hand.hover) {
            (tools::Hold::Node(at), _) | (_, Hover::Node { at, .. }) => Some(at),
            _ => None,
        });
        self.tools
            .miniature
            .draw(document.selected, highlights, stage, palette, scene);
        for hand in 0..self.tools.hands.len() {
            self.draw_hand(hand, scene);
        }
        scene.tree = self.growth.placed(Affine3A::from_translation(stage.tree));
        scene.board = Some(self.board.placed(stage));
    }

    /// What a hand's trigger would make: a pale piece, and its copies.
    fn draw_ghost(&self, hand: usize, scene: &mut Scene) {
        let WorldParams { stage, palette, .. } = &self.params;
        let Some(ghost) = self.tools.ghost(hand) else {
            return;
        };
        let mut piece = |from, to| {
            scene.rods.push(Rod {
                from,
                to,
                radius: stage.line_radius,
                color: palette.ghost,
            });
            scene.balls.push(Ball {
                center: to,
                radius: stage.selected_radius,
                color: palette.ghost,
            });
        };
        piece(ghost.from, ghost.to);
        let (document, miniature) = (self.shown(), &self.tools.miniature);
        let to = miniature.sketch_from_stage.transform_point3(ghost.to);
        let symmetry = self.tools.params.settings.copies();
        let copies = document
            .sketch
            .copies_of_segment(document.selected, to, symmetry);
        for ends in copies {
            let [from, to] = ends.map(|at| miniature.stage_from_sketch.transform_point3(at));
            piece(from, to);
        }
    }

    /// A controller, its ray, and what its trigger would make.
    fn draw_hand(&self, hand: usize, scene: &mut Scene) {
        let WorldParams { stage, palette, .. } = &self.params;
        let Some(state) = self.tools.hands.get(hand) else {
            return;
        };
        let Some(sample) = state.sample else { return };
        scene.controllers.push(Controller {
            world_from_grip: Affine3A::from_rotation_translation(
                sample.grip.orientation,
                sample.grip.position,
            ),
            hand,
            trigger: sample.trigger,
        });
        self.draw_ghost(hand, scene);
        let on_panel = matches!(state.hold, tools::Hold::Panel { .. });
        if state.hold != tools::Hold::Nothing && !on_panel {
            return;
        }
        let (length, color) = match state.hover {
            Hover::Node { along, .. }
            | Hover::Rim { along }
            | Hover::Model { along, .. }
            | Hover::End { along, .. }
            | Hover::Branch { along, .. }
            | Hover::Handle { along, .. } => (along, palette.ray_hit),
            Hover::Ground(on) => (on.along, palette.ray_hit),
            Hover::Panel(on) => (on.along, palette.ray_hit),
            Hover::Nothing => (stage.ray_length, palette.ray),
        };
        if let Hover::Model {
            at,
            spot: Some(spot),
            ..
        } = state.hover
            && self.tools.is_marking()
            && let Some(place) = self.tools.on_stage(at, spot.point)
        {
            scene.balls.push(Ball {
                center: place,
                radius: stage.node_radius,
                color: palette.ghost,
            });
        }
        if length > 0.0 {
            let from = sample.aim.position;
            scene.rods.push(Rod {
                from,
                to: from + sample.direction * length,
                radius: stage.ray_radius,
                color,
            });
        }
    }
}
