//! A runtime that is lost and comes back: a new session takes the place of the old one.

use super::*;

/// Plays until the loss, drops all, and gives the error; `params` keep the clock.
fn lost_at(call: &'static str, code: Code, params: &StartParams) -> HeadsetError {
    let mut headset = start_with(params.clone()).unwrap();
    states(&TO_FOCUS);
    if call != "xrBeginSession" {
        frame(&mut headset);
        frame(&mut headset);
    }
    if call == "xrEndSession" {
        states(&[S::STOPPING]);
    }
    with(|fake| fake.fail = Some((call, code)));
    round(&mut headset).unwrap_err()
}

#[test]
fn after_a_loss_at_any_call_a_new_session_goes_on() {
    for call in RUNNING {
        with(|fake| *fake = fake::Fake::default());
        let params = StartParams::new(NEAR);
        let error = lost_at(call, Code::ERROR_INSTANCE_LOST, &params);
        assert!(matches!(error, HeadsetError::Lost(_)), "{call}: {error}");
        let before = params.clock.get().advance(0);
        // The runtime that comes back knows nothing of the old one, and counts its time from somewhere else.
        with(|fake| {
            *fake = fake::Fake::default();
            fake.times.extend([9_000_000_000_000, 9_000_020_000_000]);
        });
        let mut headset = start_with(params).unwrap();
        states(&TO_FOCUS);
        let [first, second] = [frame(&mut headset), frame(&mut headset)];
        assert!(first.focused && first.hands[0].tracked, "{call}");
        assert_eq!(first.time, before, "{call}: time goes on where it stood");
        assert!((second.time - before - 0.02).abs() < 1e-9, "{call}");
        no_objections();
    }
}

#[test]
fn a_loss_while_the_session_is_made_is_an_error_and_it_can_be_made_again() {
    let calls = [
        "xrEnumerateInstanceExtensionProperties",
        "xrCreateInstance",
        "xrGetSystem",
        "xrGetSystemProperties",
        "xrEnumerateViewConfigurationViews",
        "xrEnumerateEnvironmentBlendModes",
        "xrGetVulkanGraphicsRequirements2KHR",
        "xrCreateSession",
        "xrEnumerateReferenceSpaces",
        "xrCreateReferenceSpace",
        "xrStringToPath",
        "xrCreateActionSet",
        "xrCreateAction",
        "xrAttachSessionActionSets",
        "xrCreateActionSpace",
        "xrEnumerateSwapchainFormats",
        "xrCreateSwapchain",
        "xrEnumerateSwapchainImages",
    ];
    for call in calls {
        with(|fake| {
            *fake = fake::Fake::default();
            fake.fail = Some((call, Code::ERROR_INSTANCE_LOST));
        });
        assert!(start().is_err(), "{call}");
        with(|fake| assert!(fake.calls.contains(&call), "{call} was never made"));
        with(|fake| *fake = fake::Fake::default());
        let mut headset = focused();
        assert!(frame(&mut headset).focused, "{call}");
        no_objections();
    }
}
