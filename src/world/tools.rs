//! The tools: what each button of either hand does.
//!
//! The hand that acts is the hand whose button was pressed. Everything that
//! changes the document happens at a button's edge and looks at nothing but the
//! document and the poses of that frame, so the document is a function of the
//! sequence of edges: not of time, frame rate, or how often a frame was shown.
//! There are two exceptions. A node that is let go before it has reached the hand
//! ([`super::HoldParams`]) stays where it is seen then, which the input's time decides. And a trigger that stays pulled
//! while the hand moves draws a free-hand stroke or erases (see `stroke`): the hand's path decides, not how often it was looked at.
//!
//! While a hand holds something, `Tools::shown` is the document as it would
//! be if the hand let go now; it becomes an edit when it does. Both hands may
//! hold at once. When the input goes to someone else in the middle, what is held
//! returns to where it was: an accident must not become an edit. A stroke in the hand is no accident and is
//! kept as far as it was drawn. A controller that loses tracking
//! drops what it holds where it was last seen, because that is where the person put it.

use glam::Vec3;

use crate::sketch::{BOUNDS, MAX_SEGMENTS, NodeRef, Predictor, SketchError, point};

pub use super::at_hand::Met;
pub(super) use super::at_hand::{Hold, Hover};
pub use super::haptics::{Haptic, HapticParams};

use super::{
    document::{Document, Edit},
    grip::PlatformGrip,
    handles::{HandleParams, Handles},
    hands::{Buttons, Edge, Edges, HandParams, Sample, checked, sample},
    history::History,
    hold::{Held, HoldParams},
    hover::{HoverParams, Pointer},
    input::{HandInput, Input, Pose},
    miniature::Miniature,
    models::Models,
    panels::{PanelParams, Panels},
    planted::Planted,
    planting::{Brush, PlantParams},
    settings::{DrawSettings, DrawTool},
    snap,
    stage::{Palette, StageParams},
    stroke::Pen,
    tried::Tried,
};

/// How the tools act.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToolParams {
    /// Buttons and poses.
    pub hands: HandParams,
    /// Pointing and touching.
    pub hover: HoverParams,
    /// Vibrations.
    pub haptics: HapticParams,
    /// Drawing.
    pub draw: DrawParams,
    /// What a person sets about drawing, at first.
    pub settings: DrawSettings,
    /// Holding a node.
    pub hold: HoldParams,
    /// Moving the platform.
    pub grip: super::grip::GripParams,
    /// Panels.
    pub panels: PanelParams,
    /// The lever, the wheel and the stump.
    pub handles: HandleParams,
    /// Planting.
    pub plant: PlantParams,
}

/// How drawing acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawParams {
    /// Longest segment that is drawn at once, metres on the stage: a hand that hangs down draws nothing.
    pub reach: f32,
    /// With the trigger held, a tip that goes farther than this from where it was pulled draws free-hand, metres on the
    /// stage.
    pub threshold: f32,
    /// Distance between the samples of a free-hand path, metres on the stage.
    pub sample: f32,
    /// How far along the path to either side smoothing reaches at its strongest, metres on the stage.
    pub smoothing_reach: f32,
    /// A segment is turned by this at most when it snaps to an angle, degrees.
    pub snap_turn_deg: f32,
    /// A node is moved by this at most when it snaps onto the mirror plane, metres on the stage.
    pub snap_distance: f32,
    /// Growth beyond this many segments is refused.
    pub max_segments: u64,
}

impl Default for DrawParams {
    fn default() -> Self {
        Self {
            reach: 0.5,
            threshold: 0.02,
            sample: 0.002,
            smoothing_reach: 0.03,
            snap_turn_deg: 4.0,
            snap_distance: 0.015,
            max_segments: MAX_SEGMENTS,
        }
    }
}

/// One hand between frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hand {
    buttons: Buttons,
    /// `None` while the hand is untracked or the input is not ours.
    pub(super) sample: Option<Sample>,
    pub(super) hold: Hold,
    /// For how long it has held that, seconds of the input's clock.
    pub(super) held_seconds: f64,
    pub(super) hover: Hover,
    /// The stick, up positive, −1 to 1.
    pub(super) scroll: f32,
    /// Whether what it would draw is snapped to an angle or a plane.
    snapped: bool,
}

/// The next segment, as the trigger would make it now, in the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ghost {
    pub(super) from: Vec3,
    pub(super) to: Vec3,
    snapped: bool,
}

/// The next segment, as the trigger would make it now.
struct Next {
    /// Its start on the stage.
    from: Vec3,
    /// Its end in the sketch.
    to: Vec3,
    snapped: bool,
}

/// The head, if it is somewhere.
fn head_of(input: &Input, params: &HandParams) -> Option<Pose> {
    checked(&input.head, params)
}

/// A hand as the search for what it means sees it.
pub(super) fn pointer(sample: &Sample) -> Pointer {
    Pointer {
        origin: sample.aim.position,
        direction: sample.direction,
        tip: sample.tip,
        hand: sample.grip.position,
    }
}

/// See the module.
#[derive(Debug)]
pub(super) struct Tools {
    pub(super) params: ToolParams,
    pub(super) stage: StageParams,
    pub(super) palette: Palette,
    pub(super) hands: [Hand; 2],
    pub(super) pens: [Pen; 2],
    pub(super) brushes: [Brush; 2],
    pub(super) platform: Option<PlatformGrip>,
    /// The document with what the hands hold.
    pub(super) shown: Document,
    pub(super) held: Option<Held>,
    pub(super) miniature: Miniature,
    pub(super) panels: Panels,
    pub(super) handles: Handles,
    pub(super) models: Models,
    pub(super) planted: Planted,
    /// An edit that is tried out, and the document as it would be: a slider that is dragged, the lever, a tree that plays.
    pub(super) tried: Tried,
    pub(super) haptics: Vec<Haptic>,
    /// How large trees would be; asked before each wish for one.
    pub(super) predictor: Predictor,
    message: Option<String>,
    /// Where the person's head was last, metres on the stage: signs turn there.
    pub(super) head: Vec3,
}

impl Tools {
    pub(super) fn new(
        document: &Document,
        params: ToolParams,
        stage: StageParams,
        palette: Palette,
    ) -> Self {
        let params = ToolParams {
            settings: params.settings.checked(),
            ..params
        };
        let mut miniature = Miniature::default();
        miniature.follow(document, &stage, &palette);
        Self {
            params,
            stage,
            palette,
            hands: [Hand::default(); 2],
            pens: Default::default(),
            brushes: Default::default(),
            platform: None,
            shown: document.clone(),
            held: None,
            miniature,
            panels: Panels::new(params.panels, &stage),
            handles: Handles::default(),
            models: Models::default(),
            planted: Planted::default(),
            tried: Tried::default(),
            haptics: Vec::new(),
            predictor: Predictor::default(),
            message: None,
            head: stage.board_faces,
        }
    }

    /// What a person should be told about this frame, if anything.
    pub(super) fn take_message(&mut self) -> Option<String> {
        self.message.take()
    }

    /// Acts on one frame; `passed` are the seconds since the one before, 0 or more.
    pub(super) fn update(&mut self, input: &Input, passed: f64, history: &mut History) {
        self.haptics.clear();
        if !input.focused {
            self.settle(history);
            self.rest_pens(history);
            self.let_go();
            for hand in &mut self.hands {
                *hand = Hand::default();
            }
            self.show(history);
            return;
        }
        let before = self.hands.map(|hand| hand.hover);
        for (hand, input) in input.hands.iter().enumerate() {
            self.read(hand, input, history);
        }
        for hand in &mut self.hands {
            hand.held_seconds += passed;
        }
        self.follow_panels(head_of(input, &self.params.hands));
        self.follow_handles(history);
        self.wait_at_stump(passed);
        let edges = [0, 1].map(|hand| {
            let Hand {
                sample, buttons, ..
            } = &mut self.hands[hand];
            match sample {
                Some(_) => buttons.step(&input.hands[hand], &self.params.hands),
                None => Edges::default(),
            }
        });
        self.follow_pens(edges.map(|edges| edges.trigger == Edge::Up), history);
        self.follow_brushes(history);
        self.show(history);
        for (hand, edges) in edges.into_iter().enumerate() {
            self.hands[hand].hover = self.find(hand);
            if self.hands[hand].sample.is_some() {
                self.hands[hand].scroll = input.hands[hand].stick.y.clamp(-1.0, 1.0);
                self.poke(hand, before[hand]);
                self.act(hand, edges, history);
            }
        }
        for (hand, before) in before.into_iter().enumerate() {
            self.hands[hand].hover = self.find(hand);
            self.tick(hand, before);
        }
        self.own_panels(before);
        let head = head_of(input, &self.params.hands);
        self.place_label(head);
        if let Some(head) = head {
            self.head = head.position;
        }
    }

    /// Takes in a hand's pose; a hand that is lost drops what it holds where it was last seen.
    fn read(&mut self, hand: usize, input: &HandInput, history: &mut History) {
        let found = sample(input, &self.params.hands);
        if found.is_none() && self.hands[hand].sample.is_some() {
            self.release(hand, history);
            self.finish_stroke(hand, history);
            self.hands[hand] = Hand::default();
        }
        self.hands[hand].sample = found;
    }

    /// What a hand is at. A hand that holds something is at nothing else; what another hand holds is out of reach.
    fn find(&self, hand: usize) -> Hover {
        let Hand {
            sample: Some(sample),
            hold: Hold::Nothing,
            ..
        } = self.hands[hand]
        else {
            return Hover::Nothing;
        };
        self.meant(Some(hand), &pointer(&sample))
    }

    /// A short tick when a node comes under the hand or the preview snaps, unless the hand was told something stronger.
    fn tick(&mut self, hand: usize, before: Hover) {
        let snapped = self.ghost(hand).is_some_and(|ghost| ghost.snapped);
        let was_snapped = std::mem::replace(&mut self.hands[hand].snapped, snapped);
        let found = match self.hands[hand].hover {
            Hover::Node { at, .. } => {
                !matches!(before, Hover::Node { at: before, .. } if before == at)
            }
            Hover::Handle { id, .. } => {
                !matches!(before, Hover::Handle { id: before, .. } if before == id)
            }
            Hover::End { model, at, .. } => {
                !matches!(before, Hover::End { model: other, at: before, .. } if (other, before) == (model, at))
            }
            Hover::Branch { model, branch, .. } => {
                !matches!(before, Hover::Branch { model: other, branch: before, .. } if (other, before) == (model, branch))
            }
            // Panels tick by themselves.
            Hover::Panel(_)
            | Hover::Rim { .. }
            | Hover::Model { .. }
            | Hover::Ground(_)
            | Hover::Nothing => false,
        };
        let told = self.haptics.iter().any(|haptic| haptic.hand == hand);
        if (found || snapped && !was_snapped) && !told {
            self.pulse(hand, self.params.haptics.hover);
        }
    }

    fn act(&mut self, hand: usize, edges: Edges, history: &mut History) {
        if edges.trigger == Edge::Up {
            self.let_off(hand, history);
        }
        if edges.squeeze == Edge::Up {
            self.open(hand, history);
        }
        if edges.squeeze == Edge::Down {
            self.grip(hand, history);
        }
        self.go_on_erasing(hand, history);
        match edges.trigger {
            Edge::Down => self.pull(hand, history),
            // A stroke has been followed up to here.
            Edge::Up => self.finish_stroke(hand, history),
            Edge::None => {}
        }
        if edges.lower == Edge::Down {
            self.grow(hand, history);
        }
        if edges.upper == Edge::Down {
            self.step_back(hand, history);
        }
        // On a panel the stick scrolls; a hand that presses one or carries it is at nothing else.
        let Hand { hold, hover, .. } = self.hands[hand];
        let on_panel = matches!(hover, Hover::Panel(_))
            || matches!(hold, Hold::Panel { .. } | Hold::Carried { .. });
        if edges.flick != 0 && !on_panel {
            self.undo_or_redo(hand, edges.flick, history);
        }
    }

    fn pull(&mut self, hand: usize, history: &mut History) {
        // One hand draws at a time: the other's stroke ends here, where this one's preview starts.
        self.finish_strokes(history);
        let Hand { hold, hover, .. } = self.hands[hand];
        match (hold, hover) {
            (
                Hold::Platform
                | Hold::Model(_)
                | Hold::Stroke
                | Hold::Planting
                | Hold::Uprooting
                | Hold::Panel { .. }
                | Hold::Carried { .. }
                | Hold::Handle(_),
                _,
            ) => {}
            (Hold::Nothing, Hover::Panel(on)) => self.press(hand, on.id, false),
            (Hold::Nothing, Hover::Handle { id, .. }) => self.take_handle(hand, id, false, history),
            (Hold::Node(at), _) => {
                self.hands[hand].hold = Hold::Nothing;
                let haptic = self.params.haptics.delete;
                self.apply(hand, Edit::DeleteNode { at }, haptic, history);
            }
            (Hold::End { model, at }, _) => self.delete_end(hand, model, at, history),
            (Hold::Nothing, Hover::End { model, at, .. })
                if self.params.settings.tool == DrawTool::Erase =>
            {
                self.delete_end(hand, model, at, history);
            }
            (Hold::Nothing, Hover::Ground(on)) => self.use_ground(hand, on, history),
            (Hold::Nothing, hover) if self.is_marking() => self.pull_at(hand, hover, history),
            (Hold::Nothing, hover) if self.params.settings.tool == DrawTool::Branch => {
                self.pull_at_branch(hand, hover);
            }
            (Hold::Nothing, _) if self.params.settings.tool == DrawTool::Erase => {
                self.begin_erasing(hand, history);
            }
            (Hold::Nothing, Hover::Node { at, along }) => {
                self.choose(hand, at, along <= 0.0, history);
            }
            (
                Hold::Nothing,
                Hover::Nothing
                | Hover::Rim { .. }
                | Hover::Model { .. }
                | Hover::End { .. }
                | Hover::Branch { .. },
            ) if self.params.settings.tool == DrawTool::Plant => self.miss_ground(hand),
            (Hold::Nothing, _) => self.draw(hand, history),
        }
    }

    /// The trigger of a hand that marks places of models.
    fn pull_at(&mut self, hand: usize, hover: Hover, history: &mut History) {
        let measures = matches!(self.params.settings.tool, DrawTool::Measure(_));
        match hover {
            Hover::Model { at, spot: Some(place), .. } => self.mark(hand, at, &place, history),
            Hover::End { model, at, .. } if !measures => self.turn_end(hand, model, at, history),
            _ => self.refuse(
                hand,
                "The trigger marks places on scanned models: point at one, or take the pen on the bench to draw.".into(),
            ),
        }
    }

    /// Selects a node; from one that is touched a stroke may follow.
    fn choose(&mut self, hand: usize, at: NodeRef, touched: bool, history: &mut History) {
        if at == NodeRef::ROOT && !self.shown.sketch.is_apex(at) {
            return self.refuse(hand, SketchError::BranchAtRoot.to_string());
        }
        let before = history.changes();
        let haptic = self.params.haptics.choose;
        if self.apply(hand, Edit::Select { at }, haptic, history) && touched {
            self.pulled(hand, at, None, before, history);
        }
    }

    /// Makes the next segment; a stroke may follow.
    fn draw(&mut self, hand: usize, history: &mut History) {
        let next = self.hands[hand]
            .sample
            .and_then(|at| self.next_segment(&at));
        let Some(Next { to, .. }) = next else {
            let reach = self.params.draw.reach;
            return self.refuse(
                hand,
                format!("Too far from the selected node to draw: come within {reach} m of it, or select another."),
            );
        };
        let (from, before) = (history.committed().selected, history.changes());
        let symmetry = self.params.settings.copies();
        let edit = match symmetry.is_off() {
            true => Edit::AddSegment { to },
            false => Edit::DrawCurve {
                from,
                through: vec![to],
                segments: vec![1],
                symmetry,
            },
        };
        if self.apply(hand, edit, self.params.haptics.create, history) {
            self.pulled(hand, from, Some(to), before, history);
        }
    }

    fn grow(&mut self, hand: usize, history: &mut History) {
        // From what is seen: a moment that is tried out is an edit before the next step is.
        self.settle(history);
        let document = history.committed();
        let step = document.step.saturating_add(1);
        let most = self.params.draw.max_segments;
        if document.sketch.is_empty() {
            return self.refuse(
                hand,
                "Nothing to grow yet: pull the trigger to draw the trunk.".into(),
            );
        }
        let within = self.predictor.within(&document.sketch, step, most);
        if within.is_none() && step <= BOUNDS.step {
            return self.refuse(
                hand,
                format!(
                    "Step {step} would have more than {most} segments: this tree is full-grown."
                ),
            );
        }
        self.apply(
            hand,
            Edit::SetStep { step },
            self.params.haptics.grow,
            history,
        );
    }

    fn step_back(&mut self, hand: usize, history: &mut History) {
        self.settle(history);
        let Some(step) = history.committed().step.checked_sub(1) else {
            return self.refuse(hand, "This is step 0, the root alone.".into());
        };
        let haptic = self.params.haptics.grow;
        self.apply(hand, Edit::SetStep { step }, haptic, history);
    }

    fn undo_or_redo(&mut self, hand: usize, flick: i8, history: &mut History) {
        self.finish_strokes(history);
        // What is held or tried belongs to the document that goes away.
        self.untry();
        self.let_go();
        let (done, nothing) = if flick < 0 {
            (history.undo(), "Nothing to undo.")
        } else {
            (history.redo(), "Nothing to redo.")
        };
        self.show(history);
        if done {
            self.pulse(hand, self.params.haptics.grow);
        } else {
            self.refuse(hand, nothing.into());
        }
    }

    /// Applies an edit; says why where it is refused, and gives whether it was not.
    pub(super) fn apply(
        &mut self,
        hand: usize,
        edit: Edit,
        haptic: [f32; 2],
        history: &mut History,
    ) -> bool {
        let applied = history.apply(edit);
        match &applied {
            Ok(()) => self.pulse(hand, haptic),
            Err(error) => self.refuse(hand, error.to_string()),
        }
        self.check_holds(history);
        self.show(history);
        applied.is_ok()
    }

    /// The trigger comes up: presses and turns end.
    fn let_off(&mut self, hand: usize, history: &mut History) {
        match self.hands[hand].hold {
            Hold::Panel { poked: false, .. } => self.hands[hand].hold = Hold::Nothing,
            Hold::Handle(_) => self.let_go_of_handle(hand, false, history),
            _ => {}
        }
    }

    pub(super) fn refuse(&mut self, hand: usize, message: String) {
        self.message = Some(message);
        self.pulse(hand, self.params.haptics.limit);
    }

    pub(super) fn pulse(&mut self, hand: usize, [seconds, amplitude]: [f32; 2]) {
        self.haptics.push(Haptic {
            hand,
            seconds,
            amplitude,
        });
    }

    /// The next segment; `None` where it cannot be drawn.
    fn next_segment(&self, sample: &Sample) -> Option<Next> {
        let from = self.miniature.position(self.shown.selected)?;
        if from.distance(sample.tip) > self.params.draw.reach {
            return None;
        }
        let to = self.in_sketch(sample.tip);
        let turned = self.at_round_angle(to);
        let to = turned.unwrap_or(to);
        let in_plane = self.onto_plane(to);
        Some(Next {
            from,
            to: point(in_plane.unwrap_or(to)),
            snapped: turned.is_some() || in_plane.is_some(),
        })
    }

    /// The end of the next segment turned to a round angle, if that is on and near.
    fn at_round_angle(&self, to: Vec3) -> Option<Vec3> {
        let every = self.params.settings.snap_angle_deg?.to_radians();
        let within = self.params.draw.snap_turn_deg.to_radians();
        let (sketch, selected) = (&self.shown.sketch, self.shown.selected);
        let from = sketch.position(selected)?;
        let below = selected.node.checked_sub(1);
        let below = below.and_then(|node| sketch.position(NodeRef::new(selected.letter, node)));
        let axes = [below.map(|below| from - below), Some(Vec3::Y)];
        Some(from + snap::turned(to - from, axes, every, within)?)
    }

    /// A place of the sketch put onto the mirror plane, if that is on and near.
    pub(super) fn onto_plane(&self, place: Vec3) -> Option<Vec3> {
        let within = self.params.draw.snap_distance / self.shown.platform.scale;
        let on = self.params.settings.snap_mirror;
        on.then(|| snap::onto_plane(place, within)).flatten()
    }

    /// What the trigger of this hand would draw.
    pub(super) fn ghost(&self, hand: usize) -> Option<Ghost> {
        let Hand {
            sample: Some(sample),
            hold: Hold::Nothing,
            hover,
            ..
        } = self.hands[hand]
        else {
            return None;
        };
        if self.params.settings.tool != DrawTool::Draw {
            return None;
        }
        let selected = self.shown.selected;
        let refused = selected == NodeRef::ROOT && !self.shown.sketch.is_apex(selected);
        let draws = matches!(
            hover,
            Hover::Nothing | Hover::Rim { .. } | Hover::Model { .. } | Hover::End { .. }
        );
        if refused || !draws {
            return None;
        }
        let Next { from, to, snapped } = self.next_segment(&sample)?;
        let to = self.miniature.stage_from_sketch.transform_point3(to);
        Some(Ghost { from, to, snapped })
    }
}
