//! The headset against the fake runtime: everything that a real one does only once in a while.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "tests say what they expect by their names"
)]

mod again;
#[path = "../../../tests/counting/mod.rs"]
mod counting;
mod extensions;
mod quads;

use std::time::Duration;

use ::openxr as xr;
use ash::vk;
use xr::SessionState as S;
use xr::sys::Result as Code;

use super::fake::{self, Ended, FakeEvent, with};
use super::{ConnectError, OpenXrHeadset, StartParams};
use crate::frame::{Frame, Hand, LONGEST_STEP, Pulse};
use crate::headset::{Headset as _, HeadsetError, Tick};
use crate::vulkan::VulkanHandles;

const NEAR: f32 = 0.05;

fn start() -> Result<OpenXrHeadset, ConnectError> {
    start_with(StartParams::new(NEAR))
}

fn start_with(params: StartParams) -> Result<OpenXrHeadset, ConnectError> {
    let handles = VulkanHandles {
        instance: vk::Instance::null(),
        physical_device: vk::PhysicalDevice::null(),
        device: vk::Device::null(),
        queue_family: 0,
        queue_index: 0,
    };
    // SAFETY: the fake runtime looks at none of the handles.
    unsafe { fake::connect()?.start(handles, params) }
}

fn states(states: &[S]) {
    with(|fake| {
        fake.events
            .extend(states.iter().copied().map(FakeEvent::State))
    });
}

const TO_FOCUS: [S; 5] = [S::IDLE, S::READY, S::SYNCHRONIZED, S::VISIBLE, S::FOCUSED];

/// One round, as an application does it.
fn round(headset: &mut OpenXrHeadset) -> Result<Tick, HeadsetError> {
    let tick = headset.wait()?;
    if let Tick::Frame(frame) = tick {
        headset.vibrate(Pulse {
            hand: 0,
            duration: 0.01,
            amplitude: 0.5,
        });
        let acquired = headset.begin()?;
        assert_eq!(acquired.is_some(), frame.should_render);
        if acquired.is_some() {
            headset.views()?;
        }
        headset.end(acquired.is_some())?;
    }
    Ok(tick)
}

fn frame(headset: &mut OpenXrHeadset) -> Frame {
    match round(headset).unwrap() {
        Tick::Frame(frame) => frame,
        tick => panic!("{tick:?}"),
    }
}

fn focused() -> OpenXrHeadset {
    let headset = start().unwrap();
    states(&TO_FOCUS);
    headset
}

#[track_caller]
fn no_objections() {
    with(|fake| assert_eq!(fake.objections, [""; 0]));
}

#[test]
fn a_part_of_a_picture_is_shown_from_then_on() {
    let mut headset = focused();
    assert_eq!(headset.period(), None, "not known before the first frame");
    frame(&mut headset);
    assert_eq!(headset.period(), Some(Duration::from_millis(11)));
    for (width, height, shown) in [
        (320, 2048, [320, 2048]),
        (9999, 9999, [640, 4096]),
        (0, 0, [1, 1]),
    ] {
        with(|fake| fake.shown.clear());
        headset.show_part(vk::Extent2D { width, height });
        frame(&mut headset);
        frame(&mut headset);
        with(|fake| assert_eq!(fake.shown, [shown; 4]));
    }
    no_objections();
}

#[test]
fn a_whole_session_breaks_no_rule() {
    let mut headset = start().unwrap();
    assert_eq!(headset.describe(), "Cardboard on Fake 1.2.3");
    assert_eq!(
        headset.extent(),
        vk::Extent2D {
            width: 640,
            height: 4096
        },
        "no larger than allowed"
    );
    let chain = headset.swapchain().unwrap();
    assert_eq!(
        (chain.color_format, chain.depth_format),
        (vk::Format::B8G8R8A8_SRGB, vk::Format::D32_SFLOAT)
    );
    assert_eq!((chain.color.len(), chain.depth.len()), (3, 3));
    assert_eq!(round(&mut headset).unwrap(), Tick::Idle);
    states(&TO_FOCUS);
    let first = frame(&mut headset);
    assert!(first.focused && first.time == 0.0);
    let hand = first.hands[1];
    assert!(
        hand.tracked && hand.lower && hand.upper && hand.trigger == 0.5 && hand.stick.y == -0.5
    );
    assert!(frame(&mut headset).time > first.time);
    headset.request_exit();
    assert_eq!(round(&mut headset).unwrap(), Tick::Exit);
    no_objections();
    with(|fake| {
        let picture = Ended {
            layers: 1,
            depth: Some([f32::INFINITY, NEAR]),
            quad: None,
        };
        assert_eq!(fake.ended, [picture; 2]);
        assert_eq!(fake.haptics, 2);
        let touch = &fake.bound["/interaction_profiles/oculus/touch_controller"];
        let is_bound = |path: &str| touch.iter().any(|(_, bound)| bound == path);
        assert!(is_bound("/user/hand/left/input/x/click"));
        assert!(is_bound("/user/hand/right/input/a/click"));
    });
}

#[test]
fn a_warm_frame_allocates_nothing() {
    const WARM: usize = 4;
    const FRAMES: usize = 100;
    let mut headset = focused();
    for _ in 0..WARM {
        frame(&mut headset);
    }
    // The fake's notes have their room beforehand: what is counted is the headset's own.
    with(|fake| fake.make_room(FRAMES));
    let before = counting::allocations();
    assert!(before > 0, "the counter counts: the start allocates");
    for _ in 0..FRAMES {
        frame(&mut headset);
    }
    let counted = counting::allocations() - before;
    no_objections();
    with(|fake| {
        assert_eq!(fake.haptics, WARM + FRAMES, "each frame was a whole one");
        assert!(fake.ended.iter().all(|ended| ended.layers == 1));
    });
    assert_eq!(counted, 0, "allocations in {FRAMES} warm frames");
}

#[test]
fn a_session_put_aside_is_taken_up_again_with_the_same_images() {
    let mut headset = focused();
    frame(&mut headset);
    states(&[S::VISIBLE, S::SYNCHRONIZED, S::STOPPING, S::IDLE]);
    assert_eq!(round(&mut headset).unwrap(), Tick::Idle);
    states(&[S::READY, S::READY, S::SYNCHRONIZED, S::VISIBLE]);
    let images = headset.swapchain().unwrap().color.clone();
    assert!(!frame(&mut headset).focused);
    assert_eq!(headset.swapchain().unwrap().color, images);
    no_objections();
}

/// Every call of a running session.
const RUNNING: [&str; 16] = [
    "xrPollEvent",
    "xrWaitFrame",
    "xrSyncActions",
    "xrLocateViews",
    "xrLocateSpace",
    "xrGetActionStateFloat",
    "xrGetActionStateVector2f",
    "xrGetActionStateBoolean",
    "xrBeginFrame",
    "xrAcquireSwapchainImage",
    "xrWaitSwapchainImage",
    "xrReleaseSwapchainImage",
    "xrEndFrame",
    "xrApplyHapticFeedback",
    "xrBeginSession",
    "xrEndSession",
];

#[test]
fn a_loss_at_any_call_is_an_error_and_never_a_panic() {
    for call in RUNNING {
        for code in [Code::ERROR_SESSION_LOST, Code::ERROR_INSTANCE_LOST] {
            with(|fake| *fake = fake::Fake::default());
            let mut headset = focused();
            if call != "xrBeginSession" {
                frame(&mut headset);
            }
            if call == "xrEndSession" {
                states(&[S::STOPPING]);
            }
            with(|fake| fake.fail = Some((call, code)));
            let error = round(&mut headset).unwrap_err();
            assert!(matches!(error, HeadsetError::Lost(_)), "{call}: {error}");
            assert!(error.to_string().contains(call), "{error}");
            // The application may go on calling; it gets errors, or an end, and nothing worse.
            for _ in 0..3 {
                let _ = round(&mut headset);
            }
            headset.request_exit();
            let _ = round(&mut headset);
        }
    }
}

#[test]
fn a_success_that_announces_a_loss_is_one() {
    for call in [
        "xrWaitFrame",
        "xrSyncActions",
        "xrBeginFrame",
        "xrEndFrame",
        "xrLocateViews",
        "xrBeginSession",
    ] {
        with(|fake| *fake = fake::Fake::default());
        let mut headset = focused();
        with(|fake| fake.fail = Some((call, Code::SESSION_LOSS_PENDING)));
        assert!(
            matches!(round(&mut headset), Err(HeadsetError::Lost(_))),
            "{call}"
        );
    }
    for event in [FakeEvent::State(S::LOSS_PENDING), FakeEvent::InstanceLoss] {
        with(|fake| *fake = fake::Fake::default());
        let mut headset = focused();
        frame(&mut headset);
        with(|fake| fake.events.push_back(event));
        assert!(matches!(round(&mut headset), Err(HeadsetError::Lost(_))));
    }
}

#[test]
fn an_image_that_never_comes_back_is_a_loss_and_no_hang() {
    let mut headset = focused();
    with(|fake| fake.fail = Some(("xrWaitSwapchainImage", Code::TIMEOUT_EXPIRED)));
    assert!(matches!(round(&mut headset), Err(HeadsetError::Lost(_))));
}

#[test]
fn frames_that_are_not_to_be_drawn_are_begun_and_ended_empty() {
    let mut headset = focused();
    with(|fake| fake.should_render = false);
    for _ in 0..5 {
        assert!(!frame(&mut headset).should_render);
    }
    with(|fake| {
        assert_eq!(fake.ended, [Ended::default(); 5]);
        assert!(!fake.calls.contains(&"xrAcquireSwapchainImage"));
    });
    no_objections();
}

#[test]
fn a_frame_that_the_application_drops_is_closed() {
    let mut headset = focused();
    for _ in 0..3 {
        assert!(matches!(headset.wait().unwrap(), Tick::Frame(_)));
    }
    headset.begin().unwrap();
    assert!(matches!(headset.wait().unwrap(), Tick::Frame(_)));
    headset.begin().unwrap();
    headset.end(true).unwrap();
    assert!(headset.begin().is_err() && headset.end(true).is_err() && headset.views().is_err());
    no_objections();
    with(|fake| {
        assert_eq!(
            fake.ended
                .iter()
                .map(|ended| ended.layers)
                .collect::<Vec<_>>(),
            [0, 0, 0, 1]
        )
    });
}

#[test]
fn absurd_display_times_reach_the_runtime_and_not_the_application() {
    let mut headset = focused();
    let times = [
        5_000_000_000,
        -7,
        i64::MIN,
        i64::MAX,
        0,
        4_000_000_000,
        4_011_000_000,
        4_011_000_000,
    ];
    with(|fake| fake.times.extend(times));
    let mut last = 0.0;
    for _ in times {
        let time = frame(&mut headset).time;
        assert!(
            time >= last && time - last <= LONGEST_STEP + 1e-9,
            "{last} {time}"
        );
        last = time;
    }
    no_objections();
}

#[test]
fn hands_show_only_while_focused_tracked_and_sane() {
    let mut headset = focused();
    assert!(frame(&mut headset).hands.iter().all(|hand| hand.tracked));
    let hidden = |headset: &mut OpenXrHeadset| frame(headset).hands == [Hand::ABSENT; 2];
    with(|fake| fake.hands_known = xr::SpaceLocationFlags::ORIENTATION_VALID);
    assert!(hidden(&mut headset), "no position");
    with(|fake| fake.hands_known = fake::Fake::default().hands_known);
    for orientation in [[0.0; 4], [f32::NAN; 4], [0.0, 0.0, 0.0, 2.0]] {
        with(|fake| fake.orientation = orientation);
        assert!(hidden(&mut headset), "{orientation:?}");
    }
    with(|fake| fake.orientation = [0.0, 0.0, 0.0, 1.0]);
    for (number, trigger) in [
        (f32::NAN, 0.0),
        (f32::INFINITY, 0.0),
        (7.0, 1.0),
        (-3.0, 0.0),
    ] {
        with(|fake| fake.number = number);
        let frame = frame(&mut headset);
        assert_eq!(frame.hands[0].trigger, trigger, "{number}");
        assert_eq!(frame.check(), Ok(()), "{number}");
    }
    let felt = with(|fake| fake.haptics);
    states(&[S::VISIBLE]);
    let unfocused = frame(&mut headset);
    assert!(!unfocused.focused && unfocused.should_render && unfocused.hands == [Hand::ABSENT; 2]);
    assert_eq!(with(|fake| fake.haptics), felt, "silent while unfocused");
}

#[test]
fn nothing_is_drawn_until_the_eyes_are_known() {
    let mut headset = focused();
    with(|fake| fake.views_known = xr::ViewStateFlags::EMPTY);
    assert!(!frame(&mut headset).should_render);
    with(|fake| fake.views_known = xr::ViewStateFlags::ORIENTATION_VALID);
    let turned = frame(&mut headset);
    assert!(turned.should_render && turned.views[0].pose.position.y == crate::frame::EYE_HEIGHT);
    with(|fake| fake.views_known = fake::Fake::default().views_known);
    assert_eq!(frame(&mut headset).views[1].pose.position.y, 1.7);
    with(|fake| fake.fov = xr::Fovf::default());
    assert!(
        !frame(&mut headset).should_render,
        "a field of view of nothing"
    );
}

#[test]
fn a_recentring_hides_the_hands_for_the_frame_in_which_it_comes() {
    let mut headset = focused();
    with(|fake| fake.times.extend([1_000, 2_000, 3_000, 4_000, 5_000]));
    with(|fake| {
        // One of a space that is not the stage's comes after it and means nothing.
        for (kind, at) in [
            (xr::ReferenceSpaceType::LOCAL_FLOOR, 3_000),
            (xr::ReferenceSpaceType::STAGE, 4_000),
        ] {
            fake.events.push_back(FakeEvent::Recentre(kind, at));
        }
        fake.events.push_back(FakeEvent::Profile);
    });
    let tracked: Vec<bool> = (0..5)
        .map(|_| frame(&mut headset).hands[0].tracked)
        .collect();
    assert_eq!(tracked, [true, true, false, true, true]);
}

#[test]
fn the_stage_is_the_best_space_that_there_is() {
    use xr::ReferenceSpaceType as R;
    let eyes = -crate::frame::EYE_HEIGHT;
    for (knows_1_1, extension, offered, made) in [
        (
            true,
            true,
            &[R::VIEW, R::LOCAL, R::STAGE, R::LOCAL_FLOOR][..],
            (R::LOCAL_FLOOR, 0.0),
        ),
        (
            false,
            true,
            &[R::VIEW, R::LOCAL, R::LOCAL_FLOOR],
            (R::LOCAL_FLOOR, 0.0),
        ),
        (
            false,
            false,
            &[R::VIEW, R::LOCAL, R::STAGE],
            (R::STAGE, 0.0),
        ),
        (false, false, &[R::VIEW, R::LOCAL], (R::LOCAL, eyes)),
    ] {
        with(|fake| {
            *fake = fake::Fake::default();
            fake.knows_1_1 = knows_1_1;
            fake.spaces = offered.to_vec();
            fake.extensions
                .retain(|name| extension || *name != c"XR_EXT_local_floor");
        });
        drop(start().unwrap());
        with(|fake| {
            assert_eq!(fake.made[0], made);
            assert_eq!(fake.api.map(xr::Version::minor), Some(u16::from(knows_1_1)));
        });
    }
}

#[test]
fn without_depth_the_picture_goes_alone() {
    let cases: [fn(&mut fake::Fake); 3] = [
        |fake| fake.formats.retain(|format| *format != 126),
        |fake| {
            fake.extensions
                .retain(|name| *name != c"XR_KHR_composition_layer_depth")
        },
        |fake| fake.formats = vec![43],
    ];
    for case in cases {
        with(|fake| *fake = fake::Fake::default());
        with(case);
        let mut headset = focused();
        assert!(headset.swapchain().unwrap().depth.is_empty());
        frame(&mut headset);
        with(|fake| {
            assert_eq!(
                fake.ended,
                [Ended {
                    layers: 1,
                    ..Ended::default()
                }]
            )
        });
    }
}

#[test]
fn what_is_missing_is_said() {
    type Case = (fn(&mut fake::Fake), &'static str);
    let cases: [Case; 8] = [
        (
            |fake| fake.extensions.clear(),
            "does not offer XR_KHR_vulkan_enable2",
        ),
        (
            |fake| fake.formats = vec![97],
            "no 8-bit sRGB picture format",
        ),
        (
            |fake| fake.fail = Some(("xrGetSystem", Code::ERROR_FORM_FACTOR_UNAVAILABLE)),
            "finds no headset",
        ),
        (
            |fake| fake.fail = Some(("xrCreateInstance", Code::ERROR_RUNTIME_UNAVAILABLE)),
            "no OpenXR runtime answers",
        ),
        (
            |fake| fake.fail = Some(("xrCreateSession", Code::ERROR_GRAPHICS_DEVICE_INVALID)),
            "xrCreateSession",
        ),
        (
            |fake| {
                fake.fail = Some((
                    "xrEnumerateViewConfigurationViews",
                    Code::ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
                ));
            },
            "does not show two eyes",
        ),
        (
            |fake| {
                fake.fail = Some((
                    "xrSuggestInteractionProfileBindings",
                    Code::ERROR_PATH_UNSUPPORTED,
                ))
            },
            "no controller bindings",
        ),
        (
            |fake| fake.fail = Some(("xrCreateSwapchain", Code::ERROR_OUT_OF_MEMORY)),
            "xrCreateSwapchain",
        ),
    ];
    for (case, said) in cases {
        with(|fake| *fake = fake::Fake::default());
        with(case);
        let error = start()
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default();
        assert!(
            error.contains(said) && !error.contains('\n'),
            "{said:?}: {error:?}"
        );
    }
}

#[test]
fn the_views_that_are_submitted_are_the_ones_that_were_drawn() {
    let mut headset = focused();
    for located_late in [true, false, true] {
        let Tick::Frame(early) = headset.wait().unwrap() else {
            panic!("no frame");
        };
        headset.begin().unwrap();
        let drawn = if located_late {
            headset.views().unwrap()
        } else {
            early.views
        };
        // The head has moved on between the two.
        assert_eq!(drawn != early.views, located_late);
        headset.end(true).unwrap();
        let submitted = with(|fake| *fake.submitted.last().unwrap());
        assert_eq!(submitted, drawn.map(|view| view.pose.position.z));
    }
    no_objections();
}

#[test]
fn leaving_before_the_session_ran_needs_no_consent() {
    let mut headset = start().unwrap();
    headset.request_exit();
    assert_eq!(headset.wait().unwrap(), Tick::Exit);
    no_objections();
}

/// What the hand of a headset says, whose controllers are of a profile and say this.
fn held(profile: &'static str, parts: &[(&'static str, f32)]) -> Hand {
    with(|fake| *fake = fake::Fake::default());
    let mut headset = focused();
    with(|fake| {
        (fake.held, fake.number, fake.button) = (profile, 0.0, false);
        fake.parts = parts.iter().copied().collect();
    });
    let hand = frame(&mut headset).hands[0];
    no_objections();
    hand
}

#[test]
fn a_touchpad_counts_where_it_is_pressed() {
    const WAND: &str = "/interaction_profiles/htc/vive_controller";
    let pad = |x, y, pressed| {
        held(
            WAND,
            &[
                ("/input/trackpad/x", x),
                ("/input/trackpad/y", y),
                ("/input/trackpad/click", pressed),
            ],
        )
    };
    let touched = pad(0.1, 0.9, 0.0);
    assert!(!touched.lower && !touched.upper && touched.stick.x == 0.0);
    assert!(pad(0.1, 0.9, 1.0).lower);
    assert!(pad(0.1, -0.9, 1.0).upper);
    let sideways = pad(-0.9, 0.1, 1.0);
    assert!(sideways.stick.x < -0.8 && !sideways.lower && !sideways.upper);
    let squeezed = held(
        WAND,
        &[("/input/squeeze/click", 1.0), ("/input/trigger/value", 0.7)],
    );
    assert!(squeezed.squeeze == 1.0 && squeezed.trigger == 0.7);
}

#[test]
fn a_stick_without_buttons_beside_it_grows() {
    const MOTION: &str = "/interaction_profiles/microsoft/motion_controller";
    let up = [("/input/thumbstick/x", 0.0), ("/input/thumbstick/y", 0.9)];
    assert!(held(MOTION, &up).lower);
    // Beside buttons it does not.
    let touch = held("/interaction_profiles/oculus/touch_controller", &up);
    assert!(!touch.lower && touch.stick.y == 0.9);
}

#[test]
fn hands_and_pens_draw() {
    // Neither is known to this runtime of version 1.1 before it offers the extensions.
    let bare = "/interaction_profiles/ext/hand_interaction_ext";
    let _ = focused();
    with(|fake| assert!(!fake.bound.contains_key(bare)));
    for (extension, profile, part) in [
        (c"XR_EXT_hand_interaction", bare, "/input/pinch_ext/value"),
        (
            c"XR_LOGITECH_mx_ink_stylus_interaction",
            "/interaction_profiles/logitech/mx_ink_stylus_logitech",
            "/input/cluster_middle_logitech/force",
        ),
    ] {
        with(|fake| {
            *fake = fake::Fake::default();
            fake.extensions.push(extension);
        });
        let mut headset = focused();
        with(|fake| {
            (fake.held, fake.number, fake.button) = (profile, 0.0, false);
            fake.parts = [(part, 0.8)].into_iter().collect();
        });
        let hand = frame(&mut headset).hands[1];
        assert!(
            hand.trigger == 0.8 && hand.squeeze == 0.0 && !hand.lower,
            "{profile}"
        );
        no_objections();
    }
}

#[test]
fn a_change_of_controllers_is_told() {
    with(|fake| *fake = fake::Fake::default());
    let mut headset = focused();
    frame(&mut headset);
    assert!(headset.controllers().iter().all(Option::is_none));
    for held in [
        "/interaction_profiles/htc/vive_controller",
        "/interaction_profiles/nobody/knows_it",
    ] {
        with(|fake| {
            fake.held = held;
            fake.events.push_back(FakeEvent::Profile);
        });
        frame(&mut headset);
        for controller in headset.controllers() {
            let known = controller.map(|profile| profile.path);
            assert_eq!(known, held.contains("vive").then_some(held));
        }
    }
    no_objections();
}
