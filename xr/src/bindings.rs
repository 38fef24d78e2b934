//! Which button of which controller does what: one table for all interaction profiles.
//!
//! A runtime takes all suggestions for a profile or, if one path is wrong, none, so each path here is
//! checked by a test against the OpenXR registry. A new controller is a new [`Profile`]; nothing else changes.
//! Runtimes map the profiles they know onto controllers they do not find here.
//!
//! Every profile reaches what it can. The simple controller has two buttons: select draws and menu grows, so a
//! person can make a tree with it, but not move or step back.

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
    /// 0 to 1.
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
    pub const ALL: [Self; 8] = [
        Self::Draw,
        Self::Grab,
        Self::Stick,
        Self::Lower,
        Self::Upper,
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
            Self::Aim => "Point",
            Self::Grip => "Hand",
            Self::Haptic => "Vibration",
        }
    }

    /// The kind of its value.
    #[must_use]
    pub const fn kind(self) -> Kind {
        match self {
            Self::Draw | Self::Grab => Kind::Number,
            Self::Stick => Kind::Vector,
            Self::Lower | Self::Upper => Kind::Button,
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

/// One kind of controller.
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    /// The profile's path.
    pub path: &'static str,
    /// What people call it.
    pub title: &'static str,
    /// Versions and extensions that know the profile; one is enough.
    pub provided_by: &'static [&'static str],
    /// What its buttons do.
    pub bindings: &'static [Binding],
}

const fn both(action: Action, path: &'static str) -> Binding {
    Binding {
        action,
        paths: [Some(path), Some(path)],
    }
}

const fn each(action: Action, left: &'static str, right: &'static str) -> Binding {
    Binding {
        action,
        paths: [Some(left), Some(right)],
    }
}

const AIM: Binding = both(Action::Aim, "/input/aim/pose");
const GRIP: Binding = both(Action::Grip, "/input/grip/pose");
const HAPTIC: Binding = both(Action::Haptic, "/output/haptic");

/// The profiles that Ramus suggests bindings for.
pub const PROFILES: &[Profile] = &[
    Profile {
        path: "/interaction_profiles/khr/simple_controller",
        title: "simple controller",
        provided_by: &["XR_VERSION_1_0"],
        bindings: &[
            both(Action::Draw, "/input/select/click"),
            both(Action::Lower, "/input/menu/click"),
            AIM,
            GRIP,
            HAPTIC,
        ],
    },
    Profile {
        path: "/interaction_profiles/oculus/touch_controller",
        title: "Touch controller",
        provided_by: &["XR_VERSION_1_0"],
        bindings: &[
            both(Action::Draw, "/input/trigger/value"),
            both(Action::Grab, "/input/squeeze/value"),
            both(Action::Stick, "/input/thumbstick"),
            each(Action::Lower, "/input/x/click", "/input/a/click"),
            each(Action::Upper, "/input/y/click", "/input/b/click"),
            AIM,
            GRIP,
            HAPTIC,
        ],
    },
    Profile {
        path: "/interaction_profiles/valve/index_controller",
        title: "Index controller",
        provided_by: &["XR_VERSION_1_0"],
        bindings: &[
            both(Action::Draw, "/input/trigger/value"),
            both(Action::Grab, "/input/squeeze/value"),
            both(Action::Stick, "/input/thumbstick"),
            both(Action::Lower, "/input/a/click"),
            both(Action::Upper, "/input/b/click"),
            AIM,
            GRIP,
            HAPTIC,
        ],
    },
];

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

    #[test]
    fn each_profile_says_each_action_once_and_can_draw_grow_and_point() {
        for profile in PROFILES {
            for action in Action::ALL {
                let count = profile
                    .bindings
                    .iter()
                    .filter(|binding| binding.action == action)
                    .count();
                let needed = matches!(
                    action,
                    Action::Draw | Action::Lower | Action::Aim | Action::Grip
                );
                assert!(
                    count <= 1 && (!needed || count == 1),
                    "{}: {action:?}",
                    profile.path
                );
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
