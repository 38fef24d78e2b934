//! What not every runtime offers: masks, refresh rates, presence, palms, bare hands.

use super::*;
use crate::refresh::RefreshWish;

fn offering(extension: &'static std::ffi::CStr) {
    with(|fake| {
        *fake = fake::Fake::default();
        fake.extensions.push(extension);
    });
}

const MASK: &std::ffi::CStr = c"XR_KHR_visibility_mask";
const RATES: &std::ffi::CStr = c"XR_FB_display_refresh_rate";
const PRESENCE: &std::ffi::CStr = c"XR_EXT_user_presence";
const JOINTS: &std::ffi::CStr = c"XR_EXT_hand_tracking";

const CORNER: [[f32; 2]; 3] = [[-1.2, 0.9], [-0.9, 0.9], [-1.2, 0.6]];

#[test]
fn the_mask_is_asked_for_and_again_when_it_changes() {
    let mut headset = focused();
    assert_eq!(headset.visibility_mask(), None, "without the extension");
    frame(&mut headset);
    offering(MASK);
    with(|fake| fake.more.masks[1] = (CORNER.to_vec(), vec![0, 1, 2, 0, 1, 9]));
    let mut headset = focused();
    let mask = headset.visibility_mask().unwrap().clone();
    assert_eq!(
        mask.hidden,
        [Vec::new(), CORNER.to_vec()],
        "what is whole of it"
    );
    frame(&mut headset);
    assert_eq!(headset.visibility_mask(), Some(&mask));
    // An event for each view; a view that does not exist, and one whose mask is as it was, change nothing.
    with(|fake| {
        fake.more.masks[0] = (CORNER.to_vec(), vec![2, 1, 0]);
        for view in [7, 1, 0] {
            fake.events.push_back(FakeEvent::Mask(view));
        }
    });
    frame(&mut headset);
    let changed = headset.visibility_mask().unwrap();
    assert!(changed.revision > mask.revision);
    assert_eq!(changed.hidden[0], [CORNER[2], CORNER[1], CORNER[0]]);
    assert_eq!(changed.hidden[1], mask.hidden[1]);
    let revision = changed.revision;
    with(|fake| fake.events.push_back(FakeEvent::Mask(0)));
    frame(&mut headset);
    assert_eq!(headset.visibility_mask().unwrap().revision, revision);
    // It may also go.
    with(|fake| {
        fake.more.masks = Default::default();
        fake.events.push_back(FakeEvent::Mask(0));
        fake.events.push_back(FakeEvent::Mask(1));
    });
    frame(&mut headset);
    let gone = headset.visibility_mask().unwrap();
    assert!(gone.revision > revision && gone.hidden.iter().all(Vec::is_empty));
    no_objections();
}

#[test]
fn a_mask_that_cannot_be_had_hides_nothing() {
    for code in [
        Code::ERROR_RUNTIME_FAILURE,
        Code::ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED,
    ] {
        offering(MASK);
        with(|fake| {
            fake.more.masks[0] = (CORNER.to_vec(), vec![0, 1, 2]);
            fake.fail = Some(("xrGetVisibilityMaskKHR", code));
        });
        assert_eq!(focused().visibility_mask(), None);
    }
    offering(MASK);
    with(|fake| fake.more.masks[0] = (CORNER.to_vec(), vec![0; 1_000_000]));
    let mut headset = focused();
    assert_eq!(headset.visibility_mask(), None, "absurdly large");
    // The loss of the session is one here too.
    frame(&mut headset);
    with(|fake| {
        fake.events.push_back(FakeEvent::Mask(0));
        fake.fail = Some(("xrGetVisibilityMaskKHR", Code::ERROR_SESSION_LOST));
    });
    assert!(matches!(round(&mut headset), Err(HeadsetError::Lost(_))));
}

#[test]
fn a_refresh_rate_is_asked_for_where_there_is_a_choice() {
    let _ = focused();
    with(|fake| assert!(fake.more.asked_rates.is_empty(), "without the extension"));
    let absurd = [f32::NAN, -90.0, 0.0, f32::INFINITY, 1000.0];
    for (offered, asked) in [
        (&[][..], &[][..]),
        (&absurd, &[]),
        (&[72.0, 1000.0, f32::NAN], &[]), // it runs at 72 already
        (&[60.0, 72.0, 80.0, 90.0, 120.0], &[90.0]),
        (&[72.0, 120.0], &[120.0]),
        (&[60.0, 80.0, 144.0], &[80.0]),
    ] {
        offering(RATES);
        with(|fake| fake.more.rates = offered.to_vec());
        let mut headset = focused();
        assert_eq!(headset.refresh_rate(), Some(72.0), "until it changes");
        frame(&mut headset);
        with(|fake| assert_eq!(fake.more.asked_rates, asked, "{offered:?}"));
        no_objections();
    }
    offering(RATES);
    let wish = RefreshWish {
        enough: 60.0,
        highest: 60.0,
    };
    let calm = StartParams {
        refresh: wish,
        ..StartParams::new(NEAR)
    };
    let mut headset = start_with(calm).unwrap();
    states(&TO_FOCUS);
    with(|fake| assert_eq!(fake.more.asked_rates, [60.0]));
    for (told, known) in [
        (60.0, Some(60.0)),
        (f32::NAN, None),
        (-1.0, None),
        (90.0, Some(90.0)),
    ] {
        with(|fake| fake.events.push_back(FakeEvent::Rate(told)));
        frame(&mut headset);
        assert_eq!(headset.refresh_rate(), known, "{told}");
    }
}

#[test]
fn a_refresh_rate_that_is_refused_stays_and_a_loss_is_one() {
    for call in [
        "xrEnumerateDisplayRefreshRatesFB",
        "xrGetDisplayRefreshRateFB",
        "xrRequestDisplayRefreshRateFB",
    ] {
        offering(RATES);
        with(|fake| fake.fail = Some((call, Code::ERROR_RUNTIME_FAILURE)));
        let mut headset = focused();
        assert_eq!(headset.refresh_rate(), None);
        assert!(frame(&mut headset).focused);
        offering(RATES);
        with(|fake| fake.fail = Some((call, Code::ERROR_SESSION_LOST)));
        assert!(matches!(
            start(),
            Err(ConnectError::Headset(HeadsetError::Lost(_)))
        ));
    }
}

#[test]
fn a_headset_that_is_taken_off_has_no_hands_until_it_is_worn_again() {
    offering(PRESENCE);
    let mut headset = focused();
    assert!(frame(&mut headset).focused && headset.worn());
    let felt = with(|fake| fake.haptics);
    with(|fake| fake.events.push_back(FakeEvent::Worn(false)));
    for _ in 0..3 {
        let off = frame(&mut headset);
        assert!(!headset.worn() && !off.focused && off.hands == [Hand::ABSENT; 2]);
        assert!(off.should_render, "what is shown is the runtime's to say");
    }
    assert_eq!(with(|fake| fake.haptics), felt, "and nothing vibrates");
    with(|fake| fake.events.push_back(FakeEvent::Worn(true)));
    let on = frame(&mut headset);
    assert!(headset.worn() && on.focused && on.hands[0].tracked);
    no_objections();
}

#[test]
fn the_palm_stands_in_for_a_grip_that_is_not_known() {
    const PALM: &std::ffi::CStr = c"XR_EXT_palm_pose";
    let grip = |unknown: &'static str| {
        let mut headset = focused();
        with(|fake| fake.unknown = unknown);
        let seen = frame(&mut headset);
        no_objections();
        let heights = seen.hands.map(|hand| (hand.tracked, hand.grip.position.y));
        assert_eq!(heights[0], heights[1]);
        heights[0]
    };
    // With the extension: every profile is asked for it, and the grip counts where it is known.
    offering(PALM);
    assert_eq!(grip(""), (true, 1.0));
    with(|fake| {
        let has =
            |bound: &Vec<(u64, String)>| bound.iter().any(|(_, p)| p.ends_with("palm_ext/pose"));
        assert!(fake.bound.values().all(has));
    });
    offering(PALM);
    assert_eq!(grip("grip"), (true, 1.25));
    // Neither: the hand is where it points from. Without an aim there is no hand.
    with(|fake| *fake = fake::Fake::default());
    assert_eq!(grip("grip"), (true, 1.0));
    offering(PALM);
    assert_eq!(grip("aim"), (false, 0.0));
    // A runtime that does not take the binding gets the profile without it.
    offering(PALM);
    with(|fake| fake.more.refuses_palms = true);
    assert_eq!(grip("grip"), (true, 1.0));
}

/// Joints of a hand whose thumb and index finger are `pinch` metres apart and whose other tips are `fist` from the palm.
fn joints(pinch: f32, fist: f32) -> [[f32; 3]; xr::HAND_JOINT_COUNT] {
    let mut joints = [[0.0, 1.0, -0.45]; xr::HAND_JOINT_COUNT];
    joints[crate::joints::PALM] = [0.0, 1.0, -0.4];
    joints[crate::joints::WRIST] = [0.0, 1.0, -0.33];
    joints[crate::joints::INDEX_PROXIMAL] = [0.0, 1.0, -0.43];
    joints[crate::joints::THUMB_TIP] = [-pinch / 2.0, 1.0, -0.48];
    joints[crate::joints::INDEX_TIP] = [pinch / 2.0, 1.0, -0.48];
    for tip in crate::joints::FIST_TIPS {
        joints[tip] = [0.0, 1.0, -0.4 - fist];
    }
    joints
}

/// A runtime that tracks bare hands; nothing is held, so no action has a pose.
fn bare() {
    offering(JOINTS);
    with(|fake| (fake.held, fake.more.joints) = ("", Some(joints(0.06, 0.1))));
}

#[test]
fn the_joint_numbers_are_those_of_the_specification() {
    use crate::joints as ours;
    for (number, joint) in [
        (ours::PALM, xr::HandJoint::PALM),
        (ours::WRIST, xr::HandJoint::WRIST),
        (ours::THUMB_TIP, xr::HandJoint::THUMB_TIP),
        (ours::INDEX_PROXIMAL, xr::HandJoint::INDEX_PROXIMAL),
        (ours::INDEX_TIP, xr::HandJoint::INDEX_TIP),
        (ours::FIST_TIPS[0], xr::HandJoint::MIDDLE_TIP),
        (ours::FIST_TIPS[1], xr::HandJoint::RING_TIP),
        (ours::FIST_TIPS[2], xr::HandJoint::LITTLE_TIP),
    ] {
        assert_eq!(i32::try_from(number), Ok(joint.into_raw()));
    }
    assert_eq!(ours::JOINTS, xr::HAND_JOINT_COUNT);
}

#[test]
fn bare_hands_draw_and_grab_where_only_joints_are_told() {
    bare();
    let mut headset = focused();
    for (pinch, fist, drawn, grabbed) in [
        (0.06, 0.1, false, false),
        (0.01, 0.1, true, false),
        (0.025, 0.1, true, false),
        (0.06, 0.1, false, false),
        (0.06, 0.04, false, true),
    ] {
        with(|fake| fake.more.joints = Some(joints(pinch, fist)));
        let seen = frame(&mut headset);
        assert_eq!(seen.check(), Ok(()));
        for hand in seen.hands {
            assert!(hand.tracked && hand.aim.position.y == 1.0);
            assert_eq!(
                (hand.trigger >= 0.6, hand.squeeze >= 0.6),
                (drawn, grabbed),
                "{pinch} {fist}"
            );
        }
    }
    // Out of the cameras' sight, or without the focus, they are gone, and so is what they did.
    let joints_are = |headset: &mut OpenXrHeadset, joints| {
        with(|fake| fake.more.joints = joints);
        frame(headset).hands[0]
    };
    let away: [fn(&mut OpenXrHeadset); 2] = [
        |headset| {
            with(|fake| fake.more.joints = None);
            assert_eq!(frame(headset).hands, [Hand::ABSENT; 2]);
        },
        |headset| {
            states(&[S::VISIBLE]);
            assert_eq!(frame(headset).hands, [Hand::ABSENT; 2]);
            states(&[S::FOCUSED]);
        },
    ];
    for go in away {
        let pinched = joints_are(&mut headset, Some(joints(0.01, 0.1)));
        assert_eq!(pinched.trigger, 1.0);
        go(&mut headset);
        let half = joints_are(&mut headset, Some(joints(0.025, 0.1)));
        assert!(
            half.tracked && half.trigger < 0.6,
            "no pinch goes on unseen"
        );
    }
    no_objections();
}

#[test]
fn what_is_held_counts_before_bare_hands() {
    // A bound profile, tracked or not.
    bare();
    with(|fake| {
        fake.held = "/interaction_profiles/htc/vive_controller";
        fake.more.joints = Some(joints(0.01, 0.1));
        fake.events.push_back(FakeEvent::Profile);
    });
    let mut headset = focused();
    assert_eq!(
        frame(&mut headset).hands[0].trigger,
        0.5,
        "the controller's"
    );
    with(|fake| fake.controllers_lost = true);
    assert_eq!(
        frame(&mut headset).hands,
        [Hand::ABSENT; 2],
        "lost for a moment"
    );
    // Put down: the runtime unbinds it.
    with(|fake| {
        fake.held = "";
        fake.events.push_back(FakeEvent::Profile);
    });
    assert_eq!(frame(&mut headset).hands[0].trigger, 1.0, "the hand's");
    no_objections();
}

#[test]
fn joints_are_not_asked_for_where_the_runtime_sees_gestures_or_no_hands() {
    let cases: [fn(&mut fake::Fake); 3] = [
        |fake| fake.extensions.push(c"XR_EXT_hand_interaction"),
        |fake| fake.more.sees_hands = false,
        |fake| fake.fail = Some(("xrCreateHandTrackerEXT", Code::ERROR_FEATURE_UNSUPPORTED)),
    ];
    for case in cases {
        bare();
        with(case);
        let mut headset = focused();
        assert_eq!(frame(&mut headset).hands, [Hand::ABSENT; 2]);
        with(|fake| assert!(!fake.calls.contains(&"xrLocateHandJointsEXT")));
    }
    bare();
    let mut headset = focused();
    frame(&mut headset);
    with(|fake| fake.fail = Some(("xrLocateHandJointsEXT", Code::ERROR_SESSION_LOST)));
    assert!(matches!(round(&mut headset), Err(HeadsetError::Lost(_))));
}
