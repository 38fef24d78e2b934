//! Flat pictures that the runtime shows by itself.

use glam::{Quat, Vec3};

use super::*;
use crate::frame::Pose;
use crate::quad::{MOST_QUADS, QuadId, QuadPlace};

const SIZE: vk::Extent2D = vk::Extent2D {
    width: 800,
    height: 500,
};

fn place(x: f32) -> QuadPlace {
    QuadPlace {
        pose: Pose {
            orientation: Quat::from_rotation_y(0.3),
            position: Vec3::new(x, 1.3, -1.2),
        },
        size: [0.8, 0.5],
    }
}

/// A round in which these quads are painted; what came with the end.
fn painted(headset: &mut OpenXrHeadset, quads: &[QuadId], rendered: bool) -> Ended {
    assert!(matches!(headset.wait().unwrap(), Tick::Frame(_)));
    let acquired = headset.begin().unwrap();
    for quad in quads {
        assert_eq!(headset.acquire_quad(*quad).unwrap(), Some(1));
    }
    headset.end(rendered && acquired.is_some()).unwrap();
    with(|fake| *fake.ended.last().unwrap())
}

#[test]
fn a_quad_is_shown_where_it_is_placed_once_it_was_painted() {
    let mut headset = focused();
    frame(&mut headset);
    let quad = headset.make_quad(SIZE).unwrap().unwrap();
    let images = headset.quad_images(quad).unwrap();
    assert_eq!((images.color().len(), images.extent()), (3, SIZE));
    assert_eq!(images.format(), headset.swapchain().unwrap().color_format());
    assert_eq!(
        painted(&mut headset, &[], true).quad,
        None,
        "not yet placed"
    );
    headset.place_quad(quad, Some(place(0.2)));
    assert_eq!(painted(&mut headset, &[], true).layers, 1, "never painted");
    let shown = Ended {
        layers: 2,
        depth: Some([f32::INFINITY, NEAR]),
        quad: Some([0.2, 0.8]),
    };
    assert_eq!(painted(&mut headset, &[quad], true), shown);
    assert_eq!(
        painted(&mut headset, &[], true),
        shown,
        "its newest picture stays"
    );
    assert_eq!(
        painted(&mut headset, &[quad], false).layers,
        0,
        "nothing without the scene"
    );
    let nowhere = QuadPlace {
        size: [0.8, f32::NAN],
        ..place(0.0)
    };
    for hidden in [None, Some(nowhere)] {
        headset.place_quad(quad, hidden);
        assert_eq!(painted(&mut headset, &[quad], true).layers, 1);
    }
    no_objections();
}

#[test]
fn quads_lie_above_each_other_in_their_order_and_their_number_is_bounded() {
    let mut headset = focused();
    frame(&mut headset);
    let quads: Vec<QuadId> = (0..MOST_QUADS)
        .map(|_| headset.make_quad(SIZE).unwrap().unwrap())
        .collect();
    assert_eq!(headset.make_quad(SIZE).unwrap(), None, "one too many");
    for (quad, x) in quads.iter().zip(0_u8..) {
        headset.place_quad(*quad, Some(place(f32::from(x))));
    }
    let ended = painted(&mut headset, &quads, true);
    assert_eq!(ended.layers, 9);
    assert_eq!(ended.quad, Some([7.0, 0.8]), "the newest is on top");
    // One that is hidden leaves no hole.
    headset.place_quad(quads[7], None);
    let ended = painted(&mut headset, &[], true);
    assert_eq!((ended.layers, ended.quad), (8, Some([6.0, 0.8])));
    no_objections();
}

#[test]
fn a_runtime_of_few_layers_has_few_quads() {
    for (layers, most) in [(0, 0), (1, 0), (3, 2), (u32::MAX, MOST_QUADS)] {
        with(|fake| fake.most_layers = layers);
        let mut headset = focused();
        let made = (0..=MOST_QUADS).filter(|_| headset.make_quad(SIZE).unwrap().is_some());
        assert_eq!(made.count(), most, "{layers} layers");
    }
    no_objections();
}

#[test]
fn quads_that_cannot_be_had_are_drawn_otherwise_and_a_loss_is_one() {
    let mut headset = focused();
    frame(&mut headset);
    let nothing = vk::Extent2D {
        width: 0,
        height: 5,
    };
    let huge = vk::Extent2D {
        width: 800,
        height: 4097,
    };
    for extent in [nothing, huge] {
        assert_eq!(headset.make_quad(extent).unwrap(), None);
    }
    with(|fake| fake.fail = Some(("xrCreateSwapchain", Code::ERROR_LIMIT_REACHED)));
    assert_eq!(headset.make_quad(SIZE).unwrap(), None);
    with(|fake| fake.fail = Some(("xrCreateSwapchain", Code::ERROR_SESSION_LOST)));
    assert!(matches!(
        headset.make_quad(SIZE),
        Err(HeadsetError::Lost(_))
    ));
    with(|fake| fake.fail = None);
    let quad = headset.make_quad(SIZE).unwrap().unwrap();
    assert!(headset.acquire_quad(quad).is_err(), "outside a frame");
    let stranger = QuadId::new(5);
    assert!(headset.quad_images(stranger).is_none());
    headset.place_quad(stranger, Some(place(0.0)));
    assert!(matches!(headset.wait().unwrap(), Tick::Frame(_)));
    headset.begin().unwrap();
    assert_eq!(headset.acquire_quad(stranger).unwrap(), None);
    with(|fake| fake.fail = Some(("xrAcquireSwapchainImage", Code::ERROR_SESSION_LOST)));
    assert!(matches!(
        headset.acquire_quad(quad),
        Err(HeadsetError::Lost(_))
    ));
    no_objections();
}

#[test]
fn a_warm_frame_with_quads_allocates_nothing() {
    let mut headset = focused();
    frame(&mut headset);
    let quads = [0, 1].map(|_| headset.make_quad(SIZE).unwrap().unwrap());
    for quad in quads {
        headset.place_quad(quad, Some(place(0.5)));
    }
    for _ in 0..4 {
        painted(&mut headset, &quads, true);
    }
    with(|fake| fake.make_room(50));
    let before = counting::allocations();
    for _ in 0..50 {
        painted(&mut headset, &quads, true);
    }
    assert_eq!(counting::allocations() - before, 0);
    assert_eq!(with(|fake| fake.ended.last().unwrap().layers), 3);
}
