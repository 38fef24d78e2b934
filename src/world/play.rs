//! The moment that is seen: growth by the wheel, the slider or playback, between whole steps too.
//!
//! The document knows whole steps only. While the moment is moved, the step it lies in is tried out, and the newest
//! segments are shown as far as they have grown; when it is let go, that step is one edit, and the picture stays at
//! the moment until the step changes otherwise. So a whole playback is one step of undo.

use super::{World, document::Edit, tools::Hold};

/// How playback runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayParams {
    /// Steps a second at first.
    pub speed: f64,
    /// Slowest and fastest.
    pub speeds: [f64; 2],
}

impl Default for PlayParams {
    fn default() -> Self {
        Self {
            speed: 1.0,
            speeds: [0.1, 10.0],
        }
    }
}

/// Playback and the moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Player {
    pub(super) playing: bool,
    pub(super) speed: f64,
    /// Steps; none: the document's whole step.
    pub(super) moment: Option<f64>,
}

impl Player {
    pub(super) fn new(params: &PlayParams) -> Self {
        Self {
            playing: false,
            speed: params.speed,
            moment: None,
        }
    }
}

/// What is said where there is no sketch.
const NOTHING: &str = "Nothing to grow yet: pull the trigger to draw the trunk.";

/// The step that a moment lies in: the one that is growing.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "held within 0 and the largest step, and saturating beyond"
)]
fn step_of(moment: f64) -> u32 {
    moment.max(0.0).ceil() as u32
}

impl World {
    /// Whether the tree plays.
    #[must_use]
    pub fn is_playing(&self) -> bool {
        self.player.playing
    }

    /// Steps a second of playback.
    #[must_use]
    pub fn speed(&self) -> f64 {
        self.player.speed
    }

    /// Sets the steps a second of playback, held within [`PlayParams::speeds`].
    pub fn set_speed(&mut self, speed: f64) {
        let [slowest, fastest] = self.params.play.speeds;
        if speed.is_finite() {
            self.player.speed = speed.clamp(slowest, fastest);
        }
    }

    /// How far the tree has grown, steps; between two whole ones the newest segments are on their way.
    #[must_use]
    pub fn moment(&self) -> f64 {
        self.player
            .moment
            .unwrap_or_else(|| f64::from(self.tools.shown.step))
    }

    /// Starts playback or ends it; ending is one edit.
    pub fn play(&mut self, on: bool) {
        if on && self.document().sketch.is_empty() {
            return self.show_message(NOTHING.into());
        }
        if self.player.playing && !on {
            self.settle();
        }
        self.player.playing = on;
    }

    /// Grows by so many steps, or back, as far as trees are not too large.
    pub fn step_by(&mut self, steps: i32) {
        self.play(false);
        self.settle();
        let from = self.document().step;
        let step = from.saturating_add_signed(steps);
        if steps > 0 && self.document().sketch.is_empty() {
            return self.show_message(NOTHING.into());
        }
        let step = if steps > 0 { self.furthest(step) } else { step };
        if step == from {
            let told = if steps > 0 {
                "One more step would be too large to be shown: this tree is full-grown."
            } else {
                "This is step 0, the root alone."
            };
            return self.show_message(told.into());
        }
        // The step was found to fit just now.
        let _ = self.apply(Edit::SetStep { step });
    }

    /// Shows the tree at a moment, steps; [`Self::settle`] makes it an edit. Where the tree would be too large, at the last moment before.
    pub fn scrub(&mut self, moment: f64) {
        if !moment.is_finite() {
            return;
        }
        let moment = moment.max(0.0);
        let moment = moment.min(f64::from(self.furthest(step_of(moment))));
        self.player.moment = Some(moment);
        let step = step_of(moment);
        // The step was found to fit just now.
        let _ = self.tools.try_out(Edit::SetStep { step }, &self.history);
        self.growth.set_moment(Some(moment));
        self.follow_history();
    }

    /// The largest step up to `step` whose tree is not too large.
    fn furthest(&mut self, step: u32) -> u32 {
        let most = self.params.growth.max_segments;
        let sketch = &self.tools.shown.sketch;
        let predictor = &mut self.tools.predictor;
        let mut fits = |step| predictor.within(sketch, step, most).is_some();
        let step = step.min(crate::sketch::BOUNDS.step);
        if fits(step) {
            return step;
        }
        // Larger steps have larger trees: halve between one that fits and one that does not.
        let (mut low, mut high) = (0, step);
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if fits(middle) {
                low = middle
            } else {
                high = middle
            }
        }
        low
    }

    /// Makes one edit of everything that is tried out: sliders let go, playback ended.
    pub fn settle(&mut self) {
        self.tools.settle(&mut self.history);
        self.tools.check_holds(&self.history);
        self.follow_history();
    }

    /// Moves the moment by the wheel or by playback.
    pub(super) fn follow_moment(&mut self, seconds: f64) {
        if let Some(moment) = self.player.moment
            && step_of(moment) != self.tools.shown.step
        {
            // The step was changed otherwise, so playback and moment are over.
            self.player.moment = None;
            self.player.playing = false;
            self.growth.set_moment(None);
        }
        let turns = |hand: &super::tools::Hand| hand.hold == Hold::Handle(super::HandleId::Wheel);
        let turning = self.tools.hands.iter().any(turns);
        if turning {
            self.player.playing = false;
            if self.tools.handles.moved {
                self.scrub(self.tools.handles.moment);
            }
        } else if self.player.playing {
            let before = self.moment();
            self.scrub(before + seconds * self.player.speed);
            if seconds > 0.0 && self.moment() <= before {
                self.play(false);
                self.show_message("This tree is full-grown: playback ends here.".into());
            }
        }
        if !turning || self.player.moment.is_some() {
            self.tools.handles.moment = self.moment();
        }
    }
}
