//! What a person can do with a controller, and how its buttons say so. Which controllers there are is in [`crate::profiles`].
//!
//! Every profile reaches what it can. Where there are no buttons beside the stick, the stick grows and steps back ([`Action::Step`]); where
//! there is a touchpad instead, its edges do, when they are pressed ([`Action::Press`]).

/// What a person can do with a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// Draws: `Hand::trigger`.
    Draw,
    /// Grabs: `Hand::squeeze`.
    Grab,
    /// Undoes and redoes: `Hand::stick`.
    Stick,
    /// Grows: `Hand::lower`.
    Lower,
    /// Steps back: `Hand::upper`.
    Upper,
    /// Grows where it is pushed up, steps back where it is pulled down: for controllers without buttons for these.
    Step,
    /// Is pressed, where a touch alone is to do nothing: stick and step count while it is held.
    Press,
    /// Where the hand points: `Hand::aim`.
    Aim,
    /// Where the hand is: `Hand::grip`.
    Grip,
    /// Vibrates.
    Haptic,
}

/// What kind of value an action takes; a runtime turns a click into 0 or 1 where a number is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// 0 to 1, or −1 to 1.
    Number,
    /// Two numbers, −1 to 1.
    Vector,
    /// Yes or no.
    Button,
    /// A pose.
    Pose,
    /// An output.
    Vibration,
}

impl Action {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Draw,
        Self::Grab,
        Self::Stick,
        Self::Lower,
        Self::Upper,
        Self::Step,
        Self::Press,
        Self::Aim,
        Self::Grip,
        Self::Haptic,
    ];

    /// Name for the runtime: lower case, stable, since people's own bindings are stored under it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Draw => "draw",
            Self::Grab => "grab",
            Self::Stick => "undo_redo",
            Self::Lower => "grow",
            Self::Upper => "step_back",
            Self::Step => "grow_or_step_back",
            Self::Press => "press",
            Self::Aim => "aim",
            Self::Grip => "grip",
            Self::Haptic => "haptic",
        }
    }

    /// What a runtime's settings show to people.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Draw => "Draw",
            Self::Grab => "Grab and move",
            Self::Stick => "Undo and redo",
            Self::Lower => "Grow a step",
            Self::Upper => "Step back",
            Self::Step => "Grow a step (up) or step back (down)",
            Self::Press => "Press the touchpad",
            Self::Aim => "Point",
            Self::Grip => "Hand",
            Self::Haptic => "Vibration",
        }
    }

    /// The kind of its value.
    #[must_use]
    pub const fn kind(self) -> Kind {
        match self {
            Self::Draw | Self::Grab | Self::Step => Kind::Number,
            Self::Stick => Kind::Vector,
            Self::Lower | Self::Upper | Self::Press => Kind::Button,
            Self::Aim | Self::Grip => Kind::Pose,
            Self::Haptic => Kind::Vibration,
        }
    }
}

/// Top-level paths of the left and the right hand.
pub const HANDS: [&str; 2] = ["/user/hand/left", "/user/hand/right"];

/// An action and its path below the left and the right hand.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// What it does.
    pub action: Action,
    /// Left, right; `None` where that hand has no such button.
    pub paths: [Option<&'static str>; 2],
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use std::path::Path;

    use serde_json::Value;

    use super::*;
    use crate::profiles::{PROFILES, Profile};

    /// Our own extract of the registry: the components of each profile in the table.
    const EXTRACT: &str = include_str!("../tests/data/interaction-profiles.json");

    /// What of the registry's component types an action of this kind can be bound to.
    fn fits(kind: Kind, component: &str) -> bool {
        match kind {
            Kind::Number => matches!(component, "float_input" | "boolean_input"),
            Kind::Vector => component == "vector2f_input",
            Kind::Button => component == "boolean_input",
            Kind::Pose => component == "pose_input",
            Kind::Vibration => component == "vibration_output",
        }
    }

    fn check(registry: &str) {
        let registry: Value = serde_json::from_str(registry).unwrap();
        for profile in PROFILES {
            let known = &registry["profiles"][profile.path];
            assert!(known.is_object(), "{} is no profile", profile.path);
            let provided: Vec<&str> = known["provided_by"]
                .as_array()
                .unwrap()
                .iter()
                .map(|by| by.as_str().unwrap())
                .collect();
            assert_eq!(profile.provided_by, provided, "{}", profile.path);
            for binding in profile.bindings {
                for (hand, path) in HANDS.iter().zip(binding.paths) {
                    let Some(path) = path else { continue };
                    let users = known["user_paths"].as_array().unwrap();
                    assert!(
                        users.iter().any(|user| user == hand),
                        "{} has no {hand}",
                        profile.path
                    );
                    let component =
                        known["components"]
                            .as_array()
                            .unwrap()
                            .iter()
                            .find(|component| {
                                component["path"] == path
                                    && component.get("needs").is_none()
                                    && component.get("only").is_none_or(|only| only == hand)
                            });
                    let component =
                        component.unwrap_or_else(|| panic!("{} has no {hand}{path}", profile.path));
                    let kind = component["type"].as_str().unwrap();
                    assert!(
                        fits(binding.action.kind(), kind),
                        "{} {hand}{path} is a {kind}",
                        profile.path
                    );
                }
            }
        }
    }

    #[test]
    fn every_path_is_in_the_extract_for_that_profile_and_hand() {
        check(EXTRACT);
    }

    #[test]
    fn every_path_is_in_the_registry_for_that_profile_and_hand() {
        let Ok(shared) = std::env::var("RAMUS_SHARED") else {
            eprintln!("skipped: RAMUS_SHARED is not set");
            return;
        };
        check(
            &std::fs::read_to_string(
                Path::new(&shared).join("reference/interaction-profiles.json"),
            )
            .unwrap(),
        );
    }

    #[test]
    fn the_check_notices_a_path_of_the_other_hand() {
        let swapped = EXTRACT.replace(
            "\"only\":\"/user/hand/left\"",
            "\"only\":\"/user/hand/right\"",
        );
        assert_ne!(swapped, EXTRACT);
        assert!(std::panic::catch_unwind(|| check(&swapped)).is_err());
    }

    /// What a profile can do.
    fn reaches(profile: &Profile, action: Action) -> bool {
        let has = |wanted| profile.bindings.iter().any(|b| b.action == wanted);
        has(action) || matches!(action, Action::Lower | Action::Upper) && has(Action::Step)
    }

    /// What each profile cannot do, which is to be known and told (`docs/src/controls.md`).
    #[test]
    fn each_profile_reaches_all_but_what_it_has_no_part_for() {
        use Action::{Haptic, Lower, Stick, Upper};
        for profile in PROFILES {
            let missing: &[Action] = match profile.path.rsplit('/').next().unwrap() {
                "simple_controller" => &[Stick, Lower, Upper],
                "hand_interaction_ext" => &[Stick, Lower, Upper, Haptic],
                "mx_ink_stylus_logitech" => &[Stick, Upper],
                _ => &[],
            };
            for action in Action::ALL {
                if matches!(action, Action::Step | Action::Press) {
                    continue; // ways to reach others
                }
                let (path, found) = (profile.path, reaches(profile, action));
                assert_eq!(found, !missing.contains(&action), "{path}: {action:?}");
            }
        }
    }

    #[test]
    fn each_profile_is_told_once_and_each_path_does_one_thing() {
        for (at, profile) in PROFILES.iter().enumerate() {
            assert!(
                PROFILES[..at]
                    .iter()
                    .all(|other| other.path != profile.path)
            );
            for hand in 0..HANDS.len() {
                let mut paths: Vec<_> = profile
                    .bindings
                    .iter()
                    .filter_map(|b| b.paths[hand])
                    .collect();
                let all = paths.len();
                paths.sort_unstable();
                paths.dedup();
                assert_eq!(paths.len(), all, "{}", profile.path);
            }
        }
    }

    #[test]
    fn names_are_what_a_runtime_takes() {
        for action in Action::ALL {
            assert!(
                action
                    .name()
                    .bytes()
                    .all(|byte| byte.is_ascii_lowercase() || byte == b'_')
            );
            assert!(!action.title().is_empty());
        }
    }
}
