//! The trigger that stays pulled: free-hand strokes, and the eraser.
//!
//! A pull makes a segment or chooses a node at once. If the tip then leaves the ball of
//! [`super::tools::DrawParams::threshold`] around the place of the pull with the trigger still down, it was the
//! beginning of a free-hand stroke: what the pull did is taken back, the hand holds a stroke from the same node, and
//! *one* edit is made when the trigger comes up, or the controller or the input is lost. (Rejected: going on from the
//! segment's end would have left two steps to undo, and taking back only at the end would have let the
//! other hand's edits come between.) Until then [`Tools::shown`] has the stroke as it would be if the hand let go now.
//!
//! A node that is pointed at from afar is chosen and no more: the hand is on its way there, and no line
//! should follow it. From a node that is touched, the stroke starts.
//!
//! The path is sampled by distance ([`Freehand`]), never by frames, and a frame looks at the latest samples
//! alone; placing the nodes costs what moving one in the hand does.

use glam::Vec3;

use crate::sketch::{Freehand, NodeRef, Sketch, SketchError, Symmetry, point};

use super::{
    document::Edit,
    history::History,
    hover::near_line,
    settings::{DrawSettings, DrawTool},
    tools::{Hand, Hold, Hover, Tools},
};

/// Most nodes erased in one frame by one hand: more than a hand can meet.
const ERASED_MOST: usize = 64;

/// What the trigger of a hand has begun.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum State {
    #[default]
    Nothing,
    /// It was pulled with the tip at `tip` (stage), and has not moved far since. `taken` is the state of the history
    /// after the edit that the pull made, if it made one.
    Pulled { tip: Vec3, taken: Option<u64> },
    /// A stroke is in the hand.
    Drawing,
    /// Nodes are erased; the tip was here in the last frame (stage).
    Erasing { tip: Vec3 },
}

/// One hand's pen between frames.
#[derive(Debug)]
pub(super) struct Pen {
    state: State,
    from: NodeRef,
    /// Where the pull put the end of a first, straight segment; metres in the sketch.
    first: Option<Vec3>,
    path: Freehand,
    symmetry: Symmetry,
    /// Grows with each change of the path.
    version: u64,
}

impl Default for Pen {
    fn default() -> Self {
        Self {
            state: State::Nothing,
            from: NodeRef::ROOT,
            first: None,
            path: Freehand::default(),
            symmetry: Symmetry::OFF,
            version: 0,
        }
    }
}

impl Pen {
    /// Which path it is that a hand draws now, for telling whether it has changed.
    pub(super) fn version(&self) -> Option<u64> {
        (self.state == State::Drawing).then_some(self.version)
    }

    fn rest(&mut self) {
        self.state = State::Nothing;
    }

    /// The edit that is made if the hand lets go now.
    pub(super) fn edit(&self) -> Option<Edit> {
        if self.state != State::Drawing {
            return None;
        }
        let spans = self.path.spans();
        let (mut through, mut segments) = (spans.through, spans.segments);
        if let Some(first) = self.first {
            through.insert(0, first);
            segments.insert(0, 1);
        }
        (!through.is_empty()).then_some(Edit::DrawCurve {
            from: self.from,
            through,
            segments,
            symmetry: self.symmetry,
        })
    }

    /// The sketch with the stroke in the hand, and its apex.
    pub(super) fn drawn_on(&self, sketch: &Sketch) -> Option<(Sketch, NodeRef)> {
        let Edit::DrawCurve {
            from,
            through,
            segments,
            symmetry,
        } = self.edit()?.quantized()
        else {
            return None;
        };
        // A stroke that cannot be drawn is not shown; the person is told why when it ends.
        sketch.draw_curve(from, &through, &segments, symmetry).ok()
    }

    /// Takes in where the tip is, metres in the sketch.
    fn go_on(&mut self, tip: Vec3) {
        if self.path.push(tip) {
            self.version += 1;
        }
    }
}

impl Tools {
    /// Notes a pull that may become a free-hand stroke from `from`; `before` is the state of the history before it.
    pub(super) fn pulled(
        &mut self,
        hand: usize,
        from: NodeRef,
        first: Option<Vec3>,
        before: u64,
        history: &History,
    ) {
        let Some(sample) = self.hands[hand].sample else {
            return;
        };
        let made = history.changes();
        let pen = &mut self.pens[hand];
        pen.state = State::Pulled {
            tip: sample.tip,
            taken: (made != before).then_some(made),
        };
        (pen.from, pen.first) = (from, first);
    }

    /// Lets the pen of each hand follow the hand; `let_go` are those whose trigger has come up.
    pub(super) fn follow_pens(&mut self, let_go: [bool; 2], history: &mut History) {
        for (hand, let_go) in let_go.into_iter().enumerate() {
            let Some(sample) = self.hands[hand].sample else {
                continue;
            };
            match self.pens[hand].state {
                State::Nothing | State::Erasing { .. } => {}
                State::Drawing => {
                    let tip = self.in_sketch(sample.tip);
                    self.pens[hand].go_on(tip);
                }
                State::Pulled { .. } if let_go || self.hands[hand].hold != Hold::Nothing => {
                    self.pens[hand].rest();
                }
                State::Pulled { tip, taken } => {
                    if tip.distance(sample.tip) > self.params.draw.threshold {
                        self.begin_stroke(hand, taken, history);
                    }
                }
            }
        }
    }

    /// The tip has gone far: takes the pull's edit back and puts a stroke into the hand.
    fn begin_stroke(&mut self, hand: usize, taken: Option<u64>, history: &mut History) {
        self.pens[hand].rest();
        let Some(sample) = self.hands[hand].sample else {
            return;
        };
        // Another edit came between, so the segment stays a segment.
        if taken.is_some_and(|taken| history.changes() != taken) {
            return;
        }
        let from = self.pens[hand].from;
        let there = history.committed().sketch.position(from);
        let Some(start) = there else { return };
        if taken.is_some() {
            history.take_back();
            // The other hand may hold what has just gone.
            self.check_holds(history);
        }
        let settings = self.params.settings;
        let scale = self.shown.platform.scale;
        let params = settings.freehand(&self.params.draw, scale);
        let tip = self.in_sketch(sample.tip);
        let pen = &mut self.pens[hand];
        // A first segment far shorter than the others is none: the path starts at the node.
        pen.first = pen
            .first
            .filter(|first| first.distance(start) >= 0.5 * params.spacing);
        pen.path.begin(params);
        // A first segment that has snapped does not end where the hand was: the path goes on from its end.
        pen.path.push(pen.first.unwrap_or(start));
        pen.go_on(tip);
        pen.version += 1;
        pen.symmetry = settings.copies();
        pen.state = State::Drawing;
        self.hands[hand].hold = Hold::Stroke;
        self.pulse(hand, self.params.haptics.choose);
    }

    /// Ends the stroke in a hand where it is now, of the pen or of the brush that plants: one edit.
    pub(super) fn finish_stroke(&mut self, hand: usize, history: &mut History) {
        self.finish_brush(hand, history);
        let edit = self.pens[hand].edit();
        let full = self.pens[hand].path.is_full();
        self.pens[hand].rest();
        if self.hands[hand].hold == Hold::Stroke {
            self.hands[hand].hold = Hold::Nothing;
        }
        let Some(edit) = edit else { return };
        self.apply(hand, edit, self.params.haptics.create, history);
        if full {
            self.refuse(hand, "A stroke holds no more nodes: it ends where it was full. Let go and draw on from there.".into());
        }
    }

    /// Ends the strokes in the hands where they are now.
    pub(super) fn finish_strokes(&mut self, history: &mut History) {
        for hand in 0..self.hands.len() {
            if matches!(
                self.hands[hand].hold,
                Hold::Stroke | Hold::Planting | Hold::Uprooting
            ) {
                self.finish_stroke(hand, history);
            }
        }
    }

    /// Ends the strokes in the hands, and whatever else their triggers have begun.
    pub(super) fn rest_pens(&mut self, history: &mut History) {
        for hand in 0..self.pens.len() {
            self.finish_stroke(hand, history);
        }
    }

    /// Strokes whose first node is no more go with it.
    pub(super) fn check_pens(&mut self, sketch: &Sketch) {
        for (hand, pen) in self.hands.iter_mut().zip(&mut self.pens) {
            if hand.hold == Hold::Stroke && sketch.check_node(pen.from).is_err() {
                hand.hold = Hold::Nothing;
                pen.rest();
            }
        }
    }

    /// Sets how drawing acts. Another tool ends the strokes in the hands.
    pub(super) fn set_settings(&mut self, settings: DrawSettings, history: &mut History) {
        let settings = settings.checked();
        if settings.tool != self.params.settings.tool {
            self.rest_pens(history);
        }
        self.params.settings = settings;
        self.show(history);
    }

    /// The trigger is pulled with the eraser in the hand: what the hand is at goes.
    pub(super) fn begin_erasing(&mut self, hand: usize, history: &mut History) {
        let Hand {
            sample: Some(sample),
            hover,
            ..
        } = self.hands[hand]
        else {
            return;
        };
        match hover {
            Hover::Node {
                at: NodeRef::ROOT, ..
            } => self.refuse(hand, SketchError::Root.to_string()),
            Hover::Node { at, .. } => self.erase(hand, at, history),
            _ => {}
        }
        self.pens[hand].state = State::Erasing { tip: sample.tip };
    }

    /// Deletes the nodes that the tip has touched since the last frame, also those it has passed between two frames.
    pub(super) fn go_on_erasing(&mut self, hand: usize, history: &mut History) {
        let (State::Erasing { tip: from }, Some(sample)) =
            (self.pens[hand].state, self.hands[hand].sample)
        else {
            return;
        };
        if self.params.settings.tool != DrawTool::Erase || self.hands[hand].hold != Hold::Nothing {
            self.pens[hand].rest();
            return;
        }
        for _ in 0..ERASED_MOST {
            let touch = self.params.hover.touch;
            let others = self.hands.map(|other| other.hold);
            let free =
                self.miniature.nodes.iter().filter(|node| {
                    node.at != NodeRef::ROOT && !others.contains(&Hold::Node(node.at))
                });
            let met = free
                .filter_map(|node| {
                    Some((node.at, near_line(node.position, from, sample.tip, touch)?))
                })
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((at, _)) = met else { break };
            let before = history.changes();
            self.erase(hand, at, history);
            if history.changes() == before {
                break;
            }
        }
        self.pens[hand].state = State::Erasing { tip: sample.tip };
    }

    fn erase(&mut self, hand: usize, at: NodeRef, history: &mut History) {
        self.apply(
            hand,
            Edit::DeleteNode { at },
            self.params.haptics.delete,
            history,
        );
    }

    /// A place of the stage in the sketch, on the grid.
    pub(super) fn in_sketch(&self, on_stage: Vec3) -> Vec3 {
        point(self.miniature.sketch_from_stage.transform_point3(on_stage))
    }
}
