//! Which controllers a runtime knows: those of its version, and those of the extensions that it offers.

use ::openxr as xr;

use crate::profiles::{PROFILES, Profile};

/// The extension that is named so; none for one that no profile asks for.
fn extension<'e>(set: &'e mut xr::ExtensionSet, name: &str) -> Option<&'e mut bool> {
    Some(match name {
        "XR_FB_touch_controller_pro" => &mut set.fb_touch_controller_pro,
        "XR_META_touch_controller_plus" => &mut set.meta_touch_controller_plus,
        "XR_HTC_vive_cosmos_controller_interaction" => {
            &mut set.htc_vive_cosmos_controller_interaction
        }
        "XR_HTC_vive_focus3_controller_interaction" => {
            &mut set.htc_vive_focus3_controller_interaction
        }
        "XR_EXT_samsung_odyssey_controller" => &mut set.ext_samsung_odyssey_controller,
        "XR_EXT_hp_mixed_reality_controller" => &mut set.ext_hp_mixed_reality_controller,
        "XR_BD_controller_interaction" => &mut set.bd_controller_interaction,
        "XR_BD_ultra_controller_interaction" => &mut set.bd_ultra_controller_interaction,
        "XR_ML_ml2_controller_interaction" => &mut set.ml_ml2_controller_interaction,
        "XR_VARJO_xr4_controller_interaction" => &mut set.varjo_xr4_controller_interaction,
        "XR_YVR_controller_interaction" => &mut set.yvr_controller_interaction,
        "XR_OPPO_controller_interaction" => &mut set.oppo_controller_interaction,
        "XR_KHR_generic_controller" => &mut set.khr_generic_controller,
        "XR_EXT_hand_interaction" => &mut set.ext_hand_interaction,
        "XR_LOGITECH_mx_ink_stylus_interaction" => &mut set.logitech_mx_ink_stylus_interaction,
        _ => return None,
    })
}

/// Asks for what of the offered extensions knows controllers.
pub(super) fn ask_for(wanted: &mut xr::ExtensionSet, mut offered: xr::ExtensionSet) {
    for name in PROFILES.iter().flat_map(|profile| profile.provided_by) {
        if let (Some(wanted), Some(offered)) =
            (extension(wanted, name), extension(&mut offered, name))
        {
            *wanted = *offered;
        }
    }
}

/// The profiles that an instance of version 1.1 or 1.0 with these extensions knows. To suggest another is an error.
pub(super) fn known(core_1_1: bool, mut made_with: xr::ExtensionSet) -> Vec<&'static Profile> {
    let mut provides = |name: &str| match name {
        "XR_VERSION_1_0" => true,
        "XR_VERSION_1_1" => core_1_1,
        name => extension(&mut made_with, name).is_some_and(|on| *on),
    };
    PROFILES
        .iter()
        .filter(|profile| profile.provided_by.iter().any(|name| provides(name)))
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]
    use super::*;

    #[test]
    fn each_extension_of_a_profile_can_be_asked_for() {
        for name in PROFILES.iter().flat_map(|profile| profile.provided_by) {
            let core = name.starts_with("XR_VERSION_");
            let mut set = xr::ExtensionSet::default();
            assert_eq!(extension(&mut set, name).is_some(), !core, "{name}");
            if let Some(on) = extension(&mut set, name) {
                *on = true;
                // The field is that of the extension: the crate says its name.
                let names: Vec<_> = set.names().iter().map(|n| n.to_vec()).collect();
                let wanted = name.as_bytes();
                assert!(
                    names
                        .iter()
                        .any(|n| n.strip_suffix(b"\0").unwrap_or(n) == wanted),
                    "{name}"
                );
            }
        }
    }

    #[test]
    fn a_profile_is_known_by_version_or_extension() {
        let has = |profiles: &[&Profile], end: &str| profiles.iter().any(|p| p.path.ends_with(end));
        let none = xr::ExtensionSet::default;
        let old = known(false, none());
        assert!(has(&old, "touch_controller") && has(&old, "vive_controller"));
        assert!(!has(&old, "pico4_controller") && !has(&old, "hand_interaction_ext"));
        let new = known(true, none());
        assert!(has(&new, "pico4_controller") && !has(&new, "hand_interaction_ext"));
        let mut offered = none();
        offered.bd_controller_interaction = true;
        offered.ext_hand_interaction = true;
        offered.ext_eye_gaze_interaction = true;
        let mut wanted = none();
        ask_for(&mut wanted, offered);
        assert!(wanted.ext_hand_interaction && !wanted.ext_eye_gaze_interaction);
        let extended = known(false, wanted);
        assert!(has(&extended, "pico4_controller") && has(&extended, "hand_interaction_ext"));
        assert!(!has(&extended, "ml2_controller"));
    }
}
