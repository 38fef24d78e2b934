//! The session's states and the order of frame calls, as pure logic.
//!
//! OpenXR tells an application its state by events and is strict about which call is allowed in which
//! state. What to do is decided here, without any call, so that it can be tested as a table;
//! `openxr::OpenXrHeadset` only does it. The rules (OpenXR 1.1, "Session Lifecycle"):
//!
//! - READY asks for xrBeginSession, STOPPING for xrEndSession, EXITING ends the program, LOSS_PENDING
//!   loses the session. A state that is told twice asks for nothing twice.
//! - Frame calls are allowed between begin and end of the session: whether it runs is a flag of its own
//!   and is not guessed from the state.
//! - Each wait has one begin and each begin one end.

use crate::frame::LONGEST_STEP;

/// States of a session, as the runtime tells them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Nothing to do.
    Idle,
    /// The runtime wants the session to begin.
    Ready,
    /// Frames run, nothing is seen.
    Synchronized,
    /// Seen, but the input is somebody else's.
    Visible,
    /// Seen, and the input is ours.
    Focused,
    /// The runtime wants the session to end.
    Stopping,
    /// The runtime is about to lose the session.
    LossPending,
    /// The person wants the program to end.
    Exiting,
}

/// What a new state asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// Nothing.
    Nothing,
    /// xrBeginSession; then call [`Lifecycle::begun`].
    Begin,
    /// xrEndSession; then call [`Lifecycle::ended`].
    End,
    /// Leave in good order.
    Exit,
    /// The session is lost.
    Lose,
}

/// How far the present frame is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// No frame is open: xrWaitFrame is next.
    Closed,
    /// Waited for: xrBeginFrame is next.
    Waited,
    /// Begun: xrEndFrame is next.
    Begun,
}

/// A frame call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameCall {
    /// xrWaitFrame.
    Wait,
    /// xrBeginFrame.
    Begin,
    /// xrEndFrame.
    End,
}

/// A frame call that is not allowed now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a frame call was made out of order ({call:?} while the frame is {stage:?}, session running: {running}); this is a fault of the program, please report it"
)]
pub struct OutOfOrder {
    call: FrameCall,
    stage: Stage,
    running: bool,
}

/// Where the session is.
#[derive(Clone, Copy, Debug)]
pub struct Lifecycle {
    state: State,
    running: bool,
    stage: Stage,
}

impl Default for Lifecycle {
    fn default() -> Self {
        Self {
            state: State::Idle,
            running: false,
            stage: Stage::Closed,
        }
    }
}

impl Lifecycle {
    /// The runtime told a state; says what it asks for.
    pub fn enter(&mut self, state: State) -> Demand {
        self.state = state;
        match state {
            State::Ready if !self.running => Demand::Begin,
            State::Stopping if self.running => Demand::End,
            State::Exiting => Demand::Exit,
            State::LossPending => Demand::Lose,
            _ => Demand::Nothing,
        }
    }

    /// xrBeginSession succeeded.
    pub fn begun(&mut self) {
        self.running = true;
        self.stage = Stage::Closed;
    }

    /// xrEndSession succeeded.
    pub fn ended(&mut self) {
        self.running = false;
        self.stage = Stage::Closed;
    }

    /// Whether frames may be waited for.
    #[must_use]
    pub fn running(&self) -> bool {
        self.running
    }

    /// Whether the input is ours.
    #[must_use]
    pub fn focused(&self) -> bool {
        self.running && self.state == State::Focused
    }

    /// How far the present frame is.
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Whether `call` is allowed now.
    ///
    /// # Errors
    /// [`OutOfOrder`] when it is not.
    pub fn allow(&self, call: FrameCall) -> Result<(), OutOfOrder> {
        let wanted = match call {
            FrameCall::Wait => Stage::Closed,
            FrameCall::Begin => Stage::Waited,
            FrameCall::End => Stage::Begun,
        };
        if self.running && self.stage == wanted {
            Ok(())
        } else {
            Err(OutOfOrder {
                call,
                stage: self.stage,
                running: self.running,
            })
        }
    }

    /// `call` succeeded.
    pub fn done(&mut self, call: FrameCall) {
        self.stage = match call {
            FrameCall::Wait => Stage::Waited,
            FrameCall::Begin => Stage::Begun,
            FrameCall::End => Stage::Closed,
        };
    }
}

/// Turns predicted display times into [`Frame::time`](crate::Frame::time).
///
/// Runtimes have given negative, repeated and absurd times; whatever they say, the frame's time never goes back
/// and never jumps. The raw time still goes to the runtime's own calls.
#[derive(Clone, Copy, Debug, Default)]
pub struct FrameClock {
    last: Option<i64>,
    /// Kept whole, so that times are short numbers in a recorded session.
    nanoseconds: i64,
}

impl FrameClock {
    /// The same clock for a session after this one: it goes on where it stands, whatever time the runtime begins with.
    #[must_use]
    pub fn resumed(self) -> Self {
        Self { last: None, ..self }
    }

    /// The time in seconds of a frame that is shown at `predicted` nanoseconds.
    pub fn advance(&mut self, predicted: i64) -> f64 {
        const SECOND: f64 = 1e9;
        #[allow(clippy::cast_possible_truncation, reason = "0.1 s in nanoseconds")]
        const LONGEST: i64 = (LONGEST_STEP * SECOND) as i64;
        if let Some(last) = self.last {
            // Saturating: the difference of two absurd times does not fit either.
            self.nanoseconds = self
                .nanoseconds
                .saturating_add(predicted.saturating_sub(last).clamp(0, LONGEST));
        }
        self.last = Some(predicted);
        self.nanoseconds as f64 / SECOND
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use proptest::prelude::*;

    use super::*;

    /// Does what is demanded, as the headset does when every call succeeds.
    fn enter(lifecycle: &mut Lifecycle, state: State) -> Demand {
        let demand = lifecycle.enter(state);
        match demand {
            Demand::Begin => lifecycle.begun(),
            Demand::End => lifecycle.ended(),
            _ => {}
        }
        demand
    }

    #[test]
    fn each_walk_demands_what_the_specification_says() {
        use Demand::{Begin, End, Exit, Lose, Nothing};
        use State::{Exiting, Focused, Idle, LossPending, Ready, Stopping, Synchronized, Visible};
        let walks: &[(&str, &[(State, Demand)])] = &[
            (
                "the whole walk",
                &[
                    (Idle, Nothing),
                    (Ready, Begin),
                    (Synchronized, Nothing),
                    (Visible, Nothing),
                    (Focused, Nothing),
                    (Visible, Nothing),
                    (Synchronized, Nothing),
                    (Stopping, End),
                    (Idle, Nothing),
                    (Exiting, Exit),
                ],
            ),
            (
                "ready twice",
                &[
                    (Ready, Begin),
                    (Ready, Nothing),
                    (Synchronized, Nothing),
                    (Ready, Nothing),
                ],
            ),
            (
                "stopping twice",
                &[(Ready, Begin), (Stopping, End), (Stopping, Nothing)],
            ),
            (
                "stopping before it began",
                &[(Idle, Nothing), (Stopping, Nothing), (Ready, Begin)],
            ),
            (
                "put aside and taken up again",
                &[
                    (Ready, Begin),
                    (Stopping, End),
                    (Idle, Nothing),
                    (Ready, Begin),
                    (Focused, Nothing),
                ],
            ),
            ("never seen and ended", &[(Idle, Nothing), (Exiting, Exit)]),
            ("lost while idle", &[(Idle, Nothing), (LossPending, Lose)]),
            (
                "lost while focused",
                &[(Ready, Begin), (Focused, Nothing), (LossPending, Lose)],
            ),
            (
                "exit without stopping",
                &[(Ready, Begin), (Focused, Nothing), (Exiting, Exit)],
            ),
        ];
        for (name, walk) in walks {
            let mut lifecycle = Lifecycle::default();
            for (at, &(state, demand)) in walk.iter().enumerate() {
                assert_eq!(enter(&mut lifecycle, state), demand, "{name}, state {at}");
            }
        }
    }

    #[test]
    fn a_begin_that_failed_is_demanded_again() {
        let mut lifecycle = Lifecycle::default();
        assert_eq!(lifecycle.enter(State::Ready), Demand::Begin);
        assert!(!lifecycle.running());
        assert_eq!(lifecycle.enter(State::Ready), Demand::Begin);
    }

    #[test]
    fn input_is_ours_only_while_focused_and_running() {
        let mut lifecycle = Lifecycle::default();
        lifecycle.enter(State::Focused);
        assert!(
            !lifecycle.focused(),
            "a session that never began has no focus"
        );
        lifecycle.begun();
        for (state, focused) in [
            (State::Synchronized, false),
            (State::Visible, false),
            (State::Focused, true),
            (State::Visible, false),
        ] {
            lifecycle.enter(state);
            assert_eq!(lifecycle.focused(), focused, "{state:?}");
        }
    }

    #[test]
    fn frame_calls_keep_their_order() {
        use FrameCall::{Begin, End, Wait};
        let mut lifecycle = Lifecycle::default();
        let allowed =
            |lifecycle: &Lifecycle| [Wait, Begin, End].map(|call| lifecycle.allow(call).is_ok());
        assert_eq!(allowed(&lifecycle), [false; 3], "not running");
        lifecycle.begun();
        for (call, then) in [
            (Wait, [false, true, false]),
            (Begin, [false, false, true]),
            (End, [true, false, false]),
        ] {
            assert_eq!(lifecycle.allow(call), Ok(()));
            lifecycle.done(call);
            assert_eq!(allowed(&lifecycle), then, "after {call:?}");
        }
        lifecycle.done(Wait);
        lifecycle.ended();
        assert_eq!(
            allowed(&lifecycle),
            [false; 3],
            "ended in the middle of a frame"
        );
        lifecycle.begun();
        assert_eq!(
            allowed(&lifecycle),
            [true, false, false],
            "a new run begins with a new frame"
        );
    }

    #[test]
    fn frame_times_are_those_of_the_display() {
        let mut clock = FrameClock::default();
        let times: Vec<f64> = [7_000_000_000, 7_011_000_000, 7_022_000_000]
            .map(|time| clock.advance(time))
            .to_vec();
        assert_eq!(times, [0.0, 0.011, 0.022]);
    }

    proptest! {
        #[test]
        fn frame_times_never_go_back_and_never_jump(times in proptest::collection::vec(any::<i64>(), 0..50)) {
            let mut clock = FrameClock::default();
            let mut last = 0.0;
            for time in times {
                let now = clock.advance(time);
                prop_assert!(now >= last && now - last <= LONGEST_STEP + 1e-9);
                last = now;
            }
        }
    }
}
