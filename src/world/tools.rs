//! The tools: what each button of either hand does.
//!
//! The hand that acts is the hand whose button was pressed. Everything that
//! changes the document happens at a button's edge and looks at nothing but the
//! document and the poses of that frame, so the document is a function of the
//! sequence of edges: not of time, frame rate, or how often a frame was shown.
//! The one exception is a node that is let go before it has reached the hand
//! ([`super::HoldParams`]): it stays where it is seen then, which the input's time decides.
//!
//! While a hand holds something, `Tools::shown` is the document as it would
//! be if the hand let go now; it becomes an edit when it does. Both hands may
//! hold at once. When the input goes to someone else in the middle, what is held
//! returns to where it was: an accident must not become an edit. A controller that loses tracking
//! drops what it holds where it was last seen, because that is where the person put it.

use glam::Vec3;

use crate::sketch::{BOUNDS, MAX_SEGMENTS, NodeRef, Predictor, SketchError, point};

use super::{
    document::{Document, Edit},
    grip::PlatformGrip,
    handles::{HandleId, HandleParams, Handles},
    hands::{Buttons, Edge, Edges, HandParams, Sample, checked, sample},
    history::History,
    hold::{Held, HoldParams},
    hover::{self, HoverParams, Pointer},
    input::{HandInput, Input, Pose},
    miniature::Miniature,
    panels::{OnPanel, PanelId, PanelParams, Panels},
    stage::{Palette, StageParams, rim},
    tried::Tried,
};

/// A vibration of one controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Haptic {
    /// 0 left, 1 right.
    pub hand: usize,
    /// How long, seconds.
    pub seconds: f32,
    /// How strong, 0 to 1.
    pub amplitude: f32,
}

/// Length in seconds and strength (0 to 1) of each vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HapticParams {
    /// A node comes under the hand.
    pub hover: [f32; 2],
    /// Something was chosen, gripped or dropped.
    pub choose: [f32; 2],
    /// A segment was made.
    pub create: [f32; 2],
    /// Something was deleted.
    pub delete: [f32; 2],
    /// The tree grew or stepped back, an edit was undone or redone.
    pub grow: [f32; 2],
    /// Nothing was done, because it cannot be.
    pub limit: [f32; 2],
}

impl Default for HapticParams {
    fn default() -> Self {
        Self {
            hover: [0.015, 0.25],
            choose: [0.02, 0.5],
            create: [0.05, 0.6],
            delete: [0.08, 0.8],
            grow: [0.04, 0.5],
            limit: [0.12, 1.0],
        }
    }
}

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
    /// Holding a node.
    pub hold: HoldParams,
    /// Moving the platform.
    pub grip: super::grip::GripParams,
    /// Panels.
    pub panels: PanelParams,
    /// The lever, the wheel and the stump.
    pub handles: HandleParams,
}

/// How drawing acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawParams {
    /// Longest segment that is drawn at once, metres on the stage: a hand that hangs down draws nothing.
    pub reach: f32,
    /// Growth beyond this many segments is refused.
    pub max_segments: u64,
}

impl Default for DrawParams {
    fn default() -> Self {
        Self {
            reach: 0.5,
            max_segments: MAX_SEGMENTS,
        }
    }
}

/// What a hand is at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Hover {
    #[default]
    Nothing,
    /// A node, so many metres along the ray (0: touched).
    Node { at: NodeRef, along: f32 },
    /// The platform's rim, so many metres along the ray (0: touched).
    Rim { along: f32 },
    /// A panel.
    Panel(OnPanel),
    /// The lever, the wheel or the stump, so many metres along the ray (0: touched).
    Handle { id: HandleId, along: f32 },
}

/// What a hand holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Hold {
    #[default]
    Nothing,
    Node(NodeRef),
    Platform,
    /// A panel, pressed by the trigger or by the tip.
    Panel {
        id: PanelId,
        poked: bool,
    },
    /// A panel that is carried, with its centre in the hand's frame, metres.
    Carried {
        id: PanelId,
        offset: Vec3,
    },
    /// The lever or the wheel.
    Handle(HandleId),
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
}

/// The next segment, as the trigger would make it now, in the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ghost {
    pub(super) from: Vec3,
    pub(super) to: Vec3,
}

impl Hover {
    /// Metres along the ray; none where there is nothing.
    fn along(self) -> Option<f32> {
        match self {
            Self::Nothing => None,
            Self::Node { along, .. } | Self::Rim { along } | Self::Handle { along, .. } => {
                Some(along)
            }
            Self::Panel(on) => Some(on.along),
        }
    }
}

/// The head, if it is somewhere.
fn head_of(input: &Input, params: &HandParams) -> Option<Pose> {
    checked(&input.head, params)
}

/// See the module.
#[derive(Debug)]
pub(super) struct Tools {
    pub(super) params: ToolParams,
    pub(super) stage: StageParams,
    pub(super) palette: Palette,
    pub(super) hands: [Hand; 2],
    pub(super) platform: Option<PlatformGrip>,
    /// The document with what the hands hold.
    pub(super) shown: Document,
    pub(super) held: Option<Held>,
    pub(super) miniature: Miniature,
    pub(super) panels: Panels,
    pub(super) handles: Handles,
    /// An edit that is tried out, and the document as it would be: a slider that is dragged, the lever, a tree that plays.
    pub(super) tried: Tried,
    pub(super) haptics: Vec<Haptic>,
    /// How large trees would be; asked before each wish for one.
    pub(super) predictor: Predictor,
    message: Option<String>,
}

impl Tools {
    pub(super) fn new(
        document: &Document,
        params: ToolParams,
        stage: StageParams,
        palette: Palette,
    ) -> Self {
        let mut miniature = Miniature::default();
        miniature.follow(document, &stage, &palette);
        Self {
            params,
            stage,
            palette,
            hands: [Hand::default(); 2],
            platform: None,
            shown: document.clone(),
            held: None,
            miniature,
            panels: Panels::new(params.panels, &stage),
            handles: Handles::default(),
            tried: Tried::default(),
            haptics: Vec::new(),
            predictor: Predictor::default(),
            message: None,
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
        self.show(history);
        for (hand, input) in input.hands.iter().enumerate() {
            self.hands[hand].hover = self.find(hand);
            if self.hands[hand].sample.is_some() {
                let edges = self.hands[hand].buttons.step(input, &self.params.hands);
                self.hands[hand].scroll = input.stick.y.clamp(-1.0, 1.0);
                self.poke(hand, before[hand]);
                self.act(hand, edges, history);
            }
        }
        for (hand, before) in before.into_iter().enumerate() {
            self.hands[hand].hover = self.find(hand);
            self.tick(hand, before);
        }
        self.own_panels(before);
        self.place_label(head_of(input, &self.params.hands));
    }

    /// Takes in a hand's pose; a hand that is lost drops what it holds where it was last seen.
    fn read(&mut self, hand: usize, input: &HandInput, history: &mut History) {
        let found = sample(input, &self.params.hands);
        if found.is_none() && self.hands[hand].sample.is_some() {
            self.release(hand, history);
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
        let pointer = Pointer {
            origin: sample.aim.position,
            direction: sample.direction,
            tip: sample.tip,
            hand: sample.grip.position,
        };
        let params = &self.params.hover;
        let taken = |at: NodeRef| self.hands.iter().any(|other| other.hold == Hold::Node(at));
        let free = self.miniature.nodes.iter().filter(|node| !taken(node.at));
        let hit = hover::ball(
            free.clone().map(|node| node.position),
            self.stage.node_radius,
            &pointer,
            params,
        );
        let node = hit.and_then(|hit| free.clone().nth(hit.index).map(|node| (node.at, hit)));
        let rim = hover::ring(&rim(&self.shown.platform, &self.stage), &pointer, params);
        let found = self.nearest(node, rim);
        let mut along = found.along();
        let mut nearest = found;
        if let Some((id, at)) = self.handle_at(&pointer)
            && along.is_none_or(|along| at <= along)
        {
            nearest = Hover::Handle { id, along: at };
            along = Some(at);
        }
        match self.panels.find(hand, &sample) {
            Some(on) if along.is_none_or(|along| on.along <= along) => Hover::Panel(on),
            _ => nearest,
        }
    }

    /// The node or the rim, whichever the hand means.
    fn nearest(&self, node: Option<(NodeRef, hover::Hit)>, rim: Option<f32>) -> Hover {
        match (node, rim) {
            (Some((at, hit)), rim) if hit.touched || rim.is_none_or(|rim| hit.along <= rim) => {
                Hover::Node {
                    at,
                    along: hit.along,
                }
            }
            (_, Some(along)) => Hover::Rim { along },
            (Some((at, hit)), None) => Hover::Node {
                at,
                along: hit.along,
            },
            (None, None) => Hover::Nothing,
        }
    }

    /// A short tick when a node comes under the hand, unless the hand was told something stronger.
    fn tick(&mut self, hand: usize, before: Hover) {
        let Hover::Node { at, .. } = self.hands[hand].hover else {
            return;
        };
        let was_there = matches!(before, Hover::Node { at: before, .. } if before == at);
        let told = self.haptics.iter().any(|haptic| haptic.hand == hand);
        if !was_there && !told {
            self.pulse(hand, self.params.haptics.hover);
        }
    }

    fn act(&mut self, hand: usize, edges: Edges, history: &mut History) {
        if edges.trigger == Edge::Up {
            self.let_off(hand, history);
        }
        if edges.squeeze == Edge::Up {
            self.release(hand, history);
        }
        if edges.squeeze == Edge::Down {
            self.grip(hand, history);
        }
        if edges.trigger == Edge::Down {
            self.pull(hand, history);
        }
        if edges.lower == Edge::Down {
            self.grow(hand, history);
        }
        if edges.upper == Edge::Down {
            self.step_back(hand, history);
        }
        // On a panel the stick scrolls.
        if edges.flick != 0 && !matches!(self.hands[hand].hover, Hover::Panel(_)) {
            self.undo_or_redo(hand, edges.flick, history);
        }
    }

    fn pull(&mut self, hand: usize, history: &mut History) {
        let Hand {
            sample: Some(sample),
            hold,
            hover,
            ..
        } = self.hands[hand]
        else {
            return;
        };
        match (hold, hover) {
            (Hold::Platform | Hold::Panel { .. } | Hold::Carried { .. } | Hold::Handle(_), _) => {}
            (Hold::Nothing, Hover::Panel(on)) => self.press(hand, on.id, false),
            (Hold::Nothing, Hover::Handle { id, .. }) => self.take_handle(hand, id, history),
            (Hold::Node(at), _) => {
                self.hands[hand].hold = Hold::Nothing;
                self.apply(
                    hand,
                    Edit::DeleteNode { at },
                    self.params.haptics.delete,
                    history,
                );
            }
            (Hold::Nothing, Hover::Node { at, .. }) => {
                let branches_at_root = at == NodeRef::ROOT && !self.shown.sketch.is_apex(at);
                if branches_at_root {
                    self.refuse(hand, SketchError::BranchAtRoot.to_string());
                } else {
                    self.apply(
                        hand,
                        Edit::Select { at },
                        self.params.haptics.choose,
                        history,
                    );
                }
            }
            (Hold::Nothing, Hover::Nothing | Hover::Rim { .. }) => match self.next_segment(&sample)
            {
                Some((_, to)) => {
                    self.apply(
                        hand,
                        Edit::AddSegment { to },
                        self.params.haptics.create,
                        history,
                    );
                }
                None => {
                    let reach = self.params.draw.reach;
                    self.refuse(
                        hand,
                        format!("Too far from the selected node to draw: come within {reach} m of it, or select another."),
                    );
                }
            },
        }
    }

    fn grow(&mut self, hand: usize, history: &mut History) {
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
        match history.committed().step.checked_sub(1) {
            Some(step) => self.apply(
                hand,
                Edit::SetStep { step },
                self.params.haptics.grow,
                history,
            ),
            None => self.refuse(hand, "This is step 0, the root alone.".into()),
        }
    }

    fn undo_or_redo(&mut self, hand: usize, flick: i8, history: &mut History) {
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

    /// Applies an edit; says why where it is refused.
    pub(super) fn apply(
        &mut self,
        hand: usize,
        edit: Edit,
        haptic: [f32; 2],
        history: &mut History,
    ) {
        match history.apply(edit) {
            Ok(()) => self.pulse(hand, haptic),
            Err(error) => self.refuse(hand, error.to_string()),
        }
        self.check_holds(history);
        self.show(history);
    }

    /// The trigger comes up: presses and turns end.
    fn let_off(&mut self, hand: usize, history: &mut History) {
        match self.hands[hand].hold {
            Hold::Panel { poked: false, .. } => self.hands[hand].hold = Hold::Nothing,
            Hold::Handle(_) => self.release(hand, history),
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

    /// Start of the next segment on the stage and its end in the sketch; `None` where it cannot be drawn.
    fn next_segment(&self, sample: &Sample) -> Option<(Vec3, Vec3)> {
        let from = self.miniature.position(self.shown.selected)?;
        let to = point(
            self.miniature
                .sketch_from_stage
                .transform_point3(sample.tip),
        );
        (from.distance(sample.tip) <= self.params.draw.reach).then_some((from, to))
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
        let selected = self.shown.selected;
        let refused = selected == NodeRef::ROOT && !self.shown.sketch.is_apex(selected);
        let draws = matches!(hover, Hover::Nothing | Hover::Rim { .. });
        if refused || !draws {
            return None;
        }
        let (from, to) = self.next_segment(&sample)?;
        let to = self.miniature.stage_from_sketch.transform_point3(to);
        Some(Ghost { from, to })
    }
}
