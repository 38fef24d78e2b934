//! The controllers that Ramus knows, and what their buttons do.
//!
//! A runtime takes all suggestions for a profile or, if one path is wrong, none, so each path here is checked by a test against the
//! OpenXR registry. A new controller is a new [`Profile`]; nothing else changes. Runtimes map the profiles they know onto controllers
//! they do not find here.

use crate::bindings::{Action, Binding};

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

impl Profile {
    /// What people call the parts of the controller that do something, in few words; none where it has no such part.
    #[must_use]
    pub fn part(&self, action: Action) -> Option<String> {
        let bound = |wanted| {
            self.bindings
                .iter()
                .find(|binding| binding.action == wanted)
        };
        let named = |binding: &Binding| {
            let mut names: Vec<&str> = binding
                .paths
                .iter()
                .rev()
                .flatten()
                .map(|path| name(path))
                .collect();
            names.dedup();
            names.join(" or ")
        };
        if let Some(binding) = bound(action) {
            return Some(named(binding));
        }
        // The stick or the touchpad stands in.
        let stick = named(bound(Action::Step)?);
        let ends = if bound(Action::Press).is_some() {
            ["top", "bottom"]
        } else {
            ["up", "down"]
        };
        match action {
            Action::Lower => Some(format!("{stick} {}", ends[0])),
            Action::Upper => Some(format!("{stick} {}", ends[1])),
            _ => None,
        }
    }
}

/// What people call a part.
fn name(path: &str) -> &str {
    match path.split('/').nth(2).unwrap_or(path) {
        "squeeze" => "grip",
        "thumbstick" => "stick",
        "trackpad" => "pad",
        "pinch_ext" => "pinch",
        "grasp_ext" => "fist",
        "cluster_middle_logitech" => "middle",
        "cluster_front_logitech" => "front",
        "cluster_back_logitech" => "back",
        "primary" => "button 1",
        "secondary" => "button 2",
        "x" => "X",
        "y" => "Y",
        "a" => "A",
        "b" => "B",
        other => other,
    }
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
const TRIGGER: Binding = both(Action::Draw, "/input/trigger/value");
const SQUEEZE: Binding = both(Action::Grab, "/input/squeeze/value");
const SQUEEZE_CLICK: Binding = both(Action::Grab, "/input/squeeze/click");
const STICK: Binding = both(Action::Stick, "/input/thumbstick");
const LOWER: Binding = each(Action::Lower, "/input/x/click", "/input/a/click");
const UPPER: Binding = each(Action::Upper, "/input/y/click", "/input/b/click");

/// Two buttons: select draws, menu grabs; growing and undoing are on the bench, which select uses.
const SIMPLE: &[Binding] = &[
    both(Action::Draw, "/input/select/click"),
    both(Action::Grab, "/input/menu/click"),
    AIM,
    GRIP,
    HAPTIC,
];
/// X and Y on the left, A and B on the right.
const TOUCH: &[Binding] = &[TRIGGER, SQUEEZE, STICK, LOWER, UPPER, AIM, GRIP, HAPTIC];
/// The same with a grip that is pressed or not.
const TOUCH_CLICK: &[Binding] = &[
    TRIGGER,
    SQUEEZE_CLICK,
    STICK,
    LOWER,
    UPPER,
    AIM,
    GRIP,
    HAPTIC,
];
/// A and B on either side.
const INDEX: &[Binding] = &[
    TRIGGER,
    SQUEEZE,
    STICK,
    both(Action::Lower, "/input/a/click"),
    both(Action::Upper, "/input/b/click"),
    AIM,
    GRIP,
    HAPTIC,
];
const XR_4: &[Binding] = &[
    TRIGGER,
    SQUEEZE_CLICK,
    STICK,
    both(Action::Lower, "/input/a/click"),
    both(Action::Upper, "/input/b/click"),
    AIM,
    GRIP,
    HAPTIC,
];
/// A stick and no buttons beside it: pushed up it grows, pulled down it steps back.
const MOTION: &[Binding] = &[
    TRIGGER,
    SQUEEZE_CLICK,
    STICK,
    both(Action::Step, "/input/thumbstick/y"),
    AIM,
    GRIP,
    HAPTIC,
];
/// A touchpad, whose edges are pressed.
const VIVE: &[Binding] = &[
    TRIGGER,
    SQUEEZE_CLICK,
    both(Action::Stick, "/input/trackpad"),
    both(Action::Step, "/input/trackpad/y"),
    both(Action::Press, "/input/trackpad/click"),
    AIM,
    GRIP,
    HAPTIC,
];
/// The same, held by the button at its shoulder.
const MAGIC_LEAP: &[Binding] = &[
    TRIGGER,
    both(Action::Grab, "/input/shoulder/click"),
    both(Action::Stick, "/input/trackpad"),
    both(Action::Step, "/input/trackpad/y"),
    both(Action::Press, "/input/trackpad/click"),
    AIM,
    GRIP,
    HAPTIC,
];
const GENERIC: &[Binding] = &[
    TRIGGER,
    SQUEEZE,
    STICK,
    both(Action::Lower, "/input/primary/click"),
    both(Action::Upper, "/input/secondary/click"),
    AIM,
    GRIP,
    HAPTIC,
];
/// Bare hands: a pinch draws, a fist grabs.
const BARE: &[Binding] = &[
    both(Action::Draw, "/input/pinch_ext/value"),
    both(Action::Grab, "/input/grasp_ext/value"),
    AIM,
    GRIP,
];
/// A pen: pressed in the hand or on a table it draws, its front button grows, the back one grabs.
const PEN: &[Binding] = &[
    both(Action::Draw, "/input/cluster_middle_logitech/force"),
    both(Action::Draw, "/input/tip_logitech/force"),
    both(Action::Grab, "/input/cluster_back_logitech/click"),
    both(Action::Lower, "/input/cluster_front_logitech/click"),
    AIM,
    GRIP,
    HAPTIC,
];

/// A profile by the end of its path.
macro_rules! profile {
    ($path:literal, $title:literal, $bindings:ident, [$($by:literal),+]) => {
        Profile {
            path: concat!("/interaction_profiles/", $path),
            title: $title,
            provided_by: &[$(concat!("XR_", $by)),+],
            bindings: $bindings,
        }
    };
}

/// The profiles that Ramus suggests bindings for.
#[rustfmt::skip]
pub const PROFILES: &[Profile] = &[
    profile!("khr/simple_controller", "simple controller", SIMPLE, ["VERSION_1_0"]),
    profile!("oculus/touch_controller", "Touch controller", TOUCH, ["VERSION_1_0"]),
    profile!("facebook/touch_controller_pro", "Touch Pro controller", TOUCH, ["FB_touch_controller_pro"]),
    profile!("meta/touch_pro_controller", "Touch Pro controller", TOUCH, ["VERSION_1_1"]),
    profile!("meta/touch_controller_plus", "Touch Plus controller", TOUCH, ["META_touch_controller_plus"]),
    profile!("meta/touch_plus_controller", "Touch Plus controller", TOUCH, ["VERSION_1_1"]),
    profile!("meta/touch_controller_rift_cv1", "Rift's Touch controller", TOUCH, ["VERSION_1_1"]),
    profile!("meta/touch_controller_quest_1_rift_s", "Quest's first Touch controller", TOUCH, ["VERSION_1_1"]),
    profile!("meta/touch_controller_quest_2", "Quest 2's Touch controller", TOUCH, ["VERSION_1_1"]),
    profile!("valve/index_controller", "Index controller", INDEX, ["VERSION_1_0"]),
    profile!("htc/vive_controller", "Vive wand", VIVE, ["VERSION_1_0"]),
    profile!("htc/vive_cosmos_controller", "Vive Cosmos controller", TOUCH_CLICK,
        ["VERSION_1_1", "HTC_vive_cosmos_controller_interaction"]),
    profile!("htc/vive_focus3_controller", "Vive Focus 3 controller", TOUCH,
        ["VERSION_1_1", "HTC_vive_focus3_controller_interaction"]),
    profile!("microsoft/motion_controller", "Motion controller", MOTION, ["VERSION_1_0"]),
    profile!("samsung/odyssey_controller", "Odyssey controller", MOTION, ["VERSION_1_1", "EXT_samsung_odyssey_controller"]),
    profile!("hp/mixed_reality_controller", "HP Reverb controller", TOUCH, ["VERSION_1_1", "EXT_hp_mixed_reality_controller"]),
    profile!("bytedance/pico_neo3_controller", "Pico Neo 3 controller", TOUCH, ["VERSION_1_1", "BD_controller_interaction"]),
    profile!("bytedance/pico4_controller", "Pico 4 controller", TOUCH, ["VERSION_1_1", "BD_controller_interaction"]),
    profile!("bytedance/pico_ultra_controller_bd", "Pico 4 Ultra controller", TOUCH, ["BD_ultra_controller_interaction"]),
    profile!("ml/ml2_controller", "Magic Leap 2 controller", MAGIC_LEAP, ["VERSION_1_1", "ML_ml2_controller_interaction"]),
    profile!("varjo/xr-4_controller", "Varjo XR-4 controller", XR_4, ["VARJO_xr4_controller_interaction"]),
    profile!("yvr/touch_controller_yvr", "YVR controller", TOUCH_CLICK, ["YVR_controller_interaction"]),
    profile!("oppo/mr_controller_oppo", "Oppo MR controller", TOUCH, ["OPPO_controller_interaction"]),
    profile!("khr/generic_controller", "controller", GENERIC, ["KHR_generic_controller"]),
    profile!("ext/hand_interaction_ext", "bare hands", BARE, ["EXT_hand_interaction"]),
    profile!("logitech/mx_ink_stylus_logitech", "MX Ink pen", PEN, ["LOGITECH_mx_ink_stylus_interaction"]),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "the profiles are there")]
    use super::*;

    #[test]
    fn parts_are_called_as_people_call_them() {
        let parts = |path: &str| {
            let profile = PROFILES.iter().find(|p| p.path.ends_with(path)).unwrap();
            let actions = [
                Action::Draw,
                Action::Grab,
                Action::Lower,
                Action::Upper,
                Action::Stick,
            ];
            actions
                .map(|action| profile.part(action).unwrap_or_default())
                .join(", ")
        };
        for (profile, expected) in [
            (
                "oculus/touch_controller",
                "trigger, grip, A or X, B or Y, stick",
            ),
            ("index_controller", "trigger, grip, A, B, stick"),
            ("vive_controller", "trigger, grip, pad top, pad bottom, pad"),
            (
                "motion_controller",
                "trigger, grip, stick up, stick down, stick",
            ),
            (
                "ml2_controller",
                "trigger, shoulder, pad top, pad bottom, pad",
            ),
            (
                "generic_controller",
                "trigger, grip, button 1, button 2, stick",
            ),
            ("simple_controller", "select, menu, , , "),
            ("hand_interaction_ext", "pinch, fist, , , "),
            ("mx_ink_stylus_logitech", "middle, back, front, , "),
        ] {
            assert_eq!(parts(profile), expected, "{profile}");
        }
    }
}
