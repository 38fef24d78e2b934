//! What hands hold: gripping, following, letting go.
//!
//! While a hand holds something, [`Tools::shown`] is the document as it would be
//! if the hand let go now; it becomes an edit when it does. What is shown is made anew from the
//! committed document in each frame that moves a hand, never from the frame before,
//! so what a frame showed leaves no trace.
//!
//! A node that is gripped from afar flies to the hand ([`HoldParams`]) and then follows it. Let go on the
//! way, it stays where it is seen.

use std::sync::Arc;

use glam::Vec3;

use crate::sketch::{NodeRef, Sketch, SketchError, point};

use super::{
    document::{Edit, Placement},
    grip::PlatformGrip,
    growth::eased,
    history::History,
    input::Pose,
    tools::{Hand, Hold, Hover, Tools},
};

/// How a node comes to the hand that grips it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoldParams {
    /// Seconds in which it flies there; none: it jumps. Short, so that it is with the hand before the hand moves on.
    pub flight_seconds: f64,
}

impl Default for HoldParams {
    fn default() -> Self {
        Self {
            flight_seconds: 0.15,
        }
    }
}

impl HoldParams {
    /// How much of its way a node has flown, 0 to 1, so many seconds after the grip.
    fn flown(&self, held_seconds: f64) -> f32 {
        if held_seconds >= self.flight_seconds {
            return 1.0;
        }
        #[expect(clippy::cast_possible_truncation, reason = "0 to 1")]
        let part = (held_seconds / self.flight_seconds) as f32;
        eased(part)
    }
}

/// What `Tools::shown` was made from: unchanged, it need not be made again.
#[derive(Debug)]
pub(super) struct Held {
    /// The sketch without what is held.
    sketch: Arc<Sketch>,
    /// The nodes in the hands and where they are, metres in the sketch.
    nodes: [Option<(NodeRef, Vec3)>; 2],
    /// The strokes in the hands.
    strokes: [Option<u64>; 2],
    /// The apex of the latest of them.
    apex: Option<NodeRef>,
}

impl Tools {
    /// Takes hold of what the hand is at.
    pub(super) fn grip(&mut self, hand: usize, history: &mut History) {
        match self.hands[hand].hover {
            Hover::Node {
                at: NodeRef::ROOT, ..
            } => self.refuse(hand, SketchError::Root.to_string()),
            Hover::Node { at, .. } => {
                self.hands[hand].hold = Hold::Node(at);
                self.hands[hand].held_seconds = 0.0;
                self.pulse(hand, self.params.haptics.choose);
            }
            Hover::Rim { .. } => {
                self.hands[hand].hold = Hold::Platform;
                self.grip_anew();
                self.pulse(hand, self.params.haptics.choose);
            }
            Hover::Model { at, .. } | Hover::Branch { model: at, .. } => {
                self.take_model(hand, at);
            }
            Hover::End { model, at, .. } => {
                let taken = Hold::End { model, at };
                // One hand an endpoint.
                if self.hands.iter().all(|other| other.hold != taken) {
                    self.hands[hand].hold = taken;
                    self.pulse(hand, self.params.haptics.choose);
                }
            }
            Hover::Panel(on) => self.carry(hand, on.id),
            Hover::Handle { id, .. } => self.take_handle(hand, id, true, history),
            Hover::Ground(on) => {
                // What the other hand has changed gets its numbers first.
                self.finish_strokes(history);
                self.begin_uprooting(hand, on);
            }
            Hover::Nothing => return,
        }
        self.show(history);
    }

    /// The grip comes up: what it holds is let go; what the trigger holds is not.
    pub(super) fn open(&mut self, hand: usize, history: &mut History) {
        match self.hands[hand].hold {
            Hold::Stroke | Hold::Planting | Hold::Panel { .. } => {}
            Hold::Handle(_) => self.let_go_of_handle(hand, true, history),
            _ => self.release(hand, history),
        }
    }

    /// Lets go of what a hand holds, where it is now.
    pub(super) fn release(&mut self, hand: usize, history: &mut History) {
        match self.hands[hand].hold {
            Hold::Nothing => return,
            Hold::Panel { .. } | Hold::Carried { .. } => self.hands[hand].hold = Hold::Nothing,
            Hold::Handle(_) => {
                self.hands[hand].hold = Hold::Nothing;
                self.settle(history);
            }
            Hold::Stroke | Hold::Planting | Hold::Uprooting => self.finish_stroke(hand, history),
            Hold::Node(_) => {
                let held = self.node_in(hand, &history.committed().sketch);
                self.hands[hand].hold = Hold::Nothing;
                let Some((at, to)) = held else { return };
                self.apply(
                    hand,
                    Edit::MoveNode { at, to },
                    self.params.haptics.choose,
                    history,
                );
            }
            Hold::Model(at) => self.release_model(hand, at, history),
            Hold::End { .. } => self.release_end(hand, history),
            Hold::Platform => {
                let to = self.held_placement();
                let committed = history.committed();
                let edit = if committed.linked {
                    self.arrangement(committed)
                } else {
                    Edit::SetPlatform { to }
                };
                self.hands[hand].hold = Hold::Nothing;
                if self.hands.iter().any(|other| other.hold == Hold::Platform) {
                    // The other hand carries on from here; one grip is one action.
                    self.shown.platform = to;
                    self.grip_anew();
                } else {
                    self.platform = None;
                    self.apply(hand, edit, self.params.haptics.choose, history);
                }
            }
        }
        self.show(history);
    }

    /// Puts what the hands hold back where it was.
    pub(super) fn let_go(&mut self) {
        for hand in &mut self.hands {
            hand.hold = Hold::Nothing;
        }
        self.platform = None;
        self.let_go_of_models(|_| true);
    }

    /// Hands let go of nodes that are no more.
    pub(super) fn check_holds(&mut self, history: &History) {
        let sketch = &history.committed().sketch;
        for hand in &mut self.hands {
            if let Hold::Node(at) = hand.hold
                && sketch
                    .apex(at.letter)
                    .is_none_or(|apex| at.node > apex.node)
            {
                hand.hold = Hold::Nothing;
            }
        }
        self.check_pens(sketch);
        let models = &history.committed().models;
        self.check_models(models);
        for hand in &mut self.hands {
            if let Hold::End { model, at } = hand.hold
                && models
                    .get(model)
                    .is_none_or(|model| at >= model.endpoints.len())
            {
                hand.hold = Hold::Nothing;
            }
        }
    }

    /// Makes `shown` and the miniature follow the history and the hands.
    pub(super) fn show(&mut self, history: &History) {
        let committed = &*self.tried.over(history.committed());
        self.models.seen = Arc::clone(&history.committed().models);
        self.planted.follow(history.committed());
        let (models, platform) = self.arranged(committed, self.platform_in_hand());
        self.shown.models = models;
        self.shown.linked = committed.linked;
        self.shown.grove = self.grove_in_hand(committed);
        if platform != self.shown.platform {
            self.shown.platform = platform;
            self.miniature
                .follow(&self.shown, &self.stage, &self.palette);
        }
        let nodes = [0, 1].map(|hand| self.node_in(hand, &committed.sketch));
        let strokes = [0, 1].map(|hand| self.pens[hand].version());
        let same = |held: &Held| {
            held.nodes == nodes
                && held.strokes == strokes
                && Arc::ptr_eq(&held.sketch, &committed.sketch)
        };
        if !self.held.as_ref().is_some_and(same) {
            self.shown.sketch = Arc::clone(&committed.sketch);
            for (at, to) in nodes.into_iter().flatten() {
                // A place where the node cannot be: it is seen where it was.
                if let Ok(moved) = self.shown.sketch.move_node(at, to) {
                    self.shown.sketch = Arc::new(moved);
                }
            }
            let mut apex = None;
            for pen in &self.pens {
                if let Some((drawn, end)) = pen.drawn_on(&self.shown.sketch) {
                    self.shown.sketch = Arc::new(drawn);
                    apex = Some(end);
                }
            }
            self.held = Some(Held {
                sketch: Arc::clone(&committed.sketch),
                nodes,
                strokes,
                apex,
            });
        }
        let apex = self.held.as_ref().and_then(|held| held.apex);
        self.shown.step = committed.step;
        self.shown.selected = apex.unwrap_or(committed.selected);
        self.miniature
            .follow(&self.shown, &self.stage, &self.palette);
    }

    /// The node in a hand and where it is now, metres in the sketch: on its way from where it was to the hand's tip,
    /// then with the tip.
    fn node_in(&self, hand: usize, committed: &Sketch) -> Option<(NodeRef, Vec3)> {
        let Hand {
            hold: Hold::Node(at),
            held_seconds,
            sample: Some(sample),
            ..
        } = *self.hands.get(hand)?
        else {
            return None;
        };
        let tip = self.in_sketch(sample.tip);
        let tip = self.onto_plane(tip).unwrap_or(tip);
        let flown = self.params.hold.flown(held_seconds);
        if flown >= 1.0 {
            return Some((at, tip));
        }
        let from = committed.position(at)?;
        Some((at, point(from.lerp(tip, flown))))
    }

    /// Begins the platform's grip anew, from where it is seen now, with the hands that hold it.
    fn grip_anew(&mut self) {
        let poses = self.platform_poses();
        self.platform = Some(PlatformGrip::new(self.shown.platform, poses));
    }

    /// The poses of the hands that hold the platform.
    fn platform_poses(&self) -> [Option<Pose>; 2] {
        self.hands.map(|hand| match hand {
            Hand {
                hold: Hold::Platform,
                sample: Some(sample),
                ..
            } => Some(sample.grip),
            _ => None,
        })
    }

    /// Where the platform is in the hands, if it is.
    pub(super) fn platform_in_hand(&self) -> Option<Placement> {
        self.platform.as_ref().map(|_| self.held_placement())
    }

    /// Where the hands hold the platform now.
    fn held_placement(&self) -> Placement {
        match &self.platform {
            Some(grip) => grip.placement(self.platform_poses(), &self.params.grip),
            None => self.shown.platform,
        }
    }
}
