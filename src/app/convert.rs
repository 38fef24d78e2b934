//! Between rooms that do not know each other: what a headset says, as the world hears it.

use ramus_xr::{Frame, Hand, Pose};

use crate::world::input;

/// A headset's frame as the world's input.
#[must_use]
pub fn input_from_frame(frame: &Frame) -> input::Input {
    input::Input {
        time: frame.time,
        focused: frame.focused,
        head: pose(frame.head),
        hands: frame.hands.map(hand),
    }
}

fn pose(from: Pose) -> input::Pose {
    input::Pose {
        orientation: from.orientation,
        position: from.position,
    }
}

fn hand(from: Hand) -> input::HandInput {
    input::HandInput {
        tracked: from.tracked,
        aim: pose(from.aim),
        grip: pose(from.grip),
        trigger: from.trigger,
        squeeze: from.squeeze,
        stick: from.stick,
        lower: from.lower,
        upper: from.upper,
    }
}
