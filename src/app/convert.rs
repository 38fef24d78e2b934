//! Between rooms that do not know each other: what a headset says, as the world hears it.

use ramus_xr::bindings::Action;
use ramus_xr::profiles::Profile;
use ramus_xr::{Frame, Hand, Pose};

use crate::world::board::Buttons;
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

/// What people call the parts of the controllers in hand. Of two that differ the one that can do more is told of; where none is known, those
/// that most people have.
#[must_use]
pub fn buttons(controllers: [Option<&Profile>; 2]) -> Buttons {
    let held = controllers.into_iter().flatten();
    // The right hand's, where both can do as much.
    let Some(told) = held.max_by_key(|profile| profile.bindings.len()) else {
        return Buttons::default();
    };
    Buttons {
        draw: told.part(Action::Draw),
        grab: told.part(Action::Grab),
        grow: told.part(Action::Lower),
        back: told.part(Action::Upper),
        undo: told.part(Action::Stick),
        redo: None,
        desk: false,
        others: Vec::new(),
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "the profiles are there")]
    use ramus_xr::profiles::PROFILES;

    use super::*;

    #[test]
    fn the_controller_that_can_do_more_is_told_of() {
        let profile = |end: &str| PROFILES.iter().find(|p| p.path.ends_with(end));
        let (touch, pen) = (
            profile("oculus/touch_controller"),
            profile("mx_ink_stylus_logitech"),
        );
        for (held, grow) in [
            ([None, None], Some("A or X")),
            ([touch, pen], Some("A or X")),
            ([pen, touch], Some("A or X")),
            ([pen, None], Some("front")),
            ([profile("index_controller"); 2], Some("A")),
            ([None, profile("hand_interaction_ext")], None),
        ] {
            assert_eq!(buttons(held).grow.as_deref(), grow, "{held:?}");
        }
        assert_eq!(buttons([touch; 2]), Buttons::default());
    }
}
