//! Reaching a runtime and its headset, or saying why there is none.

use ::openxr as xr;

use super::controllers;
use super::system::{Offer, System};

/// Why there is no headset. Each is one sentence with the way out.
#[derive(Debug, thiserror::Error)]
pub enum ConnectError {
    /// The loader library is not installed.
    #[error(
        "the OpenXR loader (libopenxr_loader.so.1) is not installed; on Debian: apt-get install libopenxr-loader1"
    )]
    NoLoader,
    /// There is a loader and no runtime that answers.
    #[error(
        "no OpenXR runtime answers: start your headset's software (SteamVR, Monado, WiVRn, …) and make it the active runtime"
    )]
    NoRuntime,
    /// The runtime sees no headset.
    #[error("the OpenXR runtime {0} finds no headset: connect it and switch it on")]
    NoHeadset(String),
    /// The runtime cannot work with Vulkan as Ramus does.
    #[error(
        "the OpenXR runtime {0} does not offer XR_KHR_vulkan_enable2, which Ramus needs: update it or take another runtime"
    )]
    NoVulkan(String),
    /// The headset has no view for each of two eyes.
    #[error("the headset {0} does not show two eyes, which Ramus needs")]
    NoStereo(String),
    /// The runtime offers no picture format that Ramus draws.
    #[error(
        "the OpenXR runtime offers no 8-bit sRGB picture format, which Ramus needs: update it or take another runtime"
    )]
    NoFormat,
    /// Vulkan refused what the runtime asked of it.
    #[error("Vulkan refused the OpenXR runtime's {call}: {result}")]
    Vulkan {
        /// The call.
        call: &'static str,
        /// What Vulkan said.
        result: ash::vk::Result,
    },
    /// Anything else.
    #[error("the OpenXR runtime failed in {call}: {code:?}")]
    Failed {
        /// The call.
        call: &'static str,
        /// The runtime's code.
        code: xr::sys::Result,
    },
    /// The session failed while it was set up.
    #[error(transparent)]
    Headset(#[from] crate::HeadsetError),
}

/// Our name in the runtime's settings.
const APPLICATION: &str = "Ramus";

/// Keeps the OpenXR loader from writing its own lines to the error output when there is no runtime: the program says
/// it in one sentence. What a person has set in `XR_LOADER_DEBUG` stays. Call it first thing in `main`: once there are
/// other threads, or where it cannot be known (elsewhere than on Linux), it does nothing.
pub fn quiet_loader() {
    const VARIABLE: &str = "XR_LOADER_DEBUG";
    let alone = std::fs::read_dir("/proc/self/task").is_ok_and(|threads| threads.count() == 1);
    if alone && std::env::var_os(VARIABLE).is_none() {
        // SAFETY: no other thread runs that could read the environment.
        unsafe { std::env::set_var(VARIABLE, "none") };
    }
}

/// Reaches the active runtime and its headset. `version` is the application's, as one number.
///
/// # Errors
/// [`ConnectError`] saying what is missing.
pub fn connect(version: u32) -> Result<System, ConnectError> {
    // SAFETY: the loader is the system's own; there is nothing to check beyond its name.
    let entry = unsafe { xr::Entry::load(&()) }.map_err(|error| match error {
        xr::EntryError::Load(_) => ConnectError::NoLoader,
        xr::EntryError::Xr(code) => ConnectError::Failed {
            call: "xrInitializeLoaderKHR",
            code,
        },
    })?;
    connect_through(&entry, version)
}

/// The same with any entry, so that a test can bring a runtime of its own.
pub(super) fn connect_through(entry: &xr::Entry, version: u32) -> Result<System, ConnectError> {
    let offered = entry
        .enumerate_extensions()
        .map_err(|code| refused("xrEnumerateInstanceExtensionProperties", code))?;
    let mut extensions = xr::ExtensionSet::default();
    extensions.khr_vulkan_enable2 = offered.khr_vulkan_enable2;
    extensions.khr_composition_layer_depth = offered.khr_composition_layer_depth;
    extensions.ext_local_floor = offered.ext_local_floor;
    extensions.khr_visibility_mask = offered.khr_visibility_mask;
    extensions.fb_display_refresh_rate = offered.fb_display_refresh_rate;
    extensions.ext_user_presence = offered.ext_user_presence;
    extensions.ext_palm_pose = offered.ext_palm_pose;
    // Gestures of bare hands are the runtime's to see where it can.
    extensions.ext_hand_tracking = offered.ext_hand_tracking && !offered.ext_hand_interaction;
    let vulkan = offered.khr_vulkan_enable2;
    controllers::ask_for(&mut extensions, offered);
    if !vulkan {
        return Err(ConnectError::NoVulkan(String::from("that is active")));
    }
    let create = |api| {
        entry.create_instance(
            &xr::ApplicationInfo {
                application_name: APPLICATION,
                application_version: version,
                engine_name: APPLICATION,
                engine_version: version,
                api_version: api,
            },
            &extensions,
            &[],
            &(),
        )
    };
    // 1.1 has LOCAL_FLOOR in its core; loaders and runtimes older than it refuse the number.
    let newest = xr::Version::new(1, 1, 0);
    let (instance, core_1_1) = match create(newest) {
        Err(xr::sys::Result::ERROR_API_VERSION_UNSUPPORTED) => {
            (create(xr::Version::new(1, 0, 0)), false)
        }
        made => (made, true),
    };
    let instance = instance.map_err(|code| refused("xrCreateInstance", code))?;
    let runtime = instance.properties().map_or_else(
        |_| String::from("(unknown)"),
        |runtime| format!("{} {}", runtime.runtime_name, runtime.runtime_version),
    );
    let system = instance
        .system(xr::FormFactor::HEAD_MOUNTED_DISPLAY)
        .map_err(|code| match code {
            xr::sys::Result::ERROR_FORM_FACTOR_UNAVAILABLE
            | xr::sys::Result::ERROR_FORM_FACTOR_UNSUPPORTED => {
                ConnectError::NoHeadset(runtime.clone())
            }
            code => refused("xrGetSystem", code),
        })?;
    let joints = extensions.ext_hand_tracking && tracks_hands(&instance, system);
    System::new(
        instance,
        system,
        runtime,
        Offer {
            mask: extensions.khr_visibility_mask,
            refresh: extensions.fb_display_refresh_rate,
            joints,
            palm: extensions.ext_palm_pose,
            local_floor: core_1_1 || extensions.ext_local_floor,
            depth: extensions.khr_composition_layer_depth,
            profiles: controllers::known(core_1_1, extensions),
        },
    )
}

/// Whether the device has eyes for hands; where it cannot say, it has none.
fn tracks_hands(instance: &xr::Instance, system: xr::SystemId) -> bool {
    instance
        .supports_hand_tracking(system)
        .inspect_err(|code| tracing::warn!("no bare hands: xrGetSystemProperties gave {code:?}"))
        .unwrap_or(false)
}

/// What it means that the runtime refused a call made before there was a session.
pub(super) fn refused(call: &'static str, code: xr::sys::Result) -> ConnectError {
    match code {
        // The loader says the last two when the active runtime's manifest names files that are not there.
        xr::sys::Result::ERROR_RUNTIME_UNAVAILABLE
        | xr::sys::Result::ERROR_FILE_ACCESS_ERROR
        | xr::sys::Result::ERROR_FILE_CONTENTS_INVALID => ConnectError::NoRuntime,
        code => ConnectError::Failed { call, code },
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "the one case prints what it found"
    )]

    use super::*;

    #[test]
    fn without_a_runtime_one_sentence_says_so() {
        match connect(1) {
            Ok(system) => eprintln!("skipped: a runtime answers here: {}", system.describe()),
            Err(error @ (ConnectError::NoLoader | ConnectError::NoRuntime)) => {
                let text = error.to_string();
                assert!(!text.contains('\n') && text.len() < 160, "{text}");
            }
            Err(error @ (ConnectError::NoHeadset(_) | ConnectError::NoVulkan(_))) => {
                eprintln!("skipped: a runtime answers here: {error}");
            }
            Err(error) => panic!("{error}"),
        }
    }
}
