//! What the shaders read, byte for byte, and how a [`Scene`] becomes it.
//!
//! All of it is rewritten every frame into buffers that already exist; nothing here allocates.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4, Vec3, Vec4};

use super::{eye::Eye, light::LightData};
use crate::world::scene::{
    Ball, Color, Controller, MOST_PANELS, PlacedPanel, PlacedTree, Plate, Rod, Scene,
};

/// `View` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct ViewData {
    clip_from_world: Mat4,
    eye: Vec4,
    ray: Vec4,
    ray_x: Vec4,
    ray_y: Vec4,
}

/// How many contact shadows the ground takes.
const SPOTS: usize = 8;

/// `Frame` of shaders/shared/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct FrameData {
    pub(crate) views: [ViewData; 2],
    pub(crate) sun: Vec4,
    pub(crate) backdrop: Vec4,
    pub(crate) world_from_tree: Mat4,
    pub(crate) tree: Vec4,
    pub(crate) shadow_from_world: Mat4,
    pub(crate) spots: [Vec4; SPOTS],
    pub(crate) light: LightData,
    pub(crate) wind: Vec4,
    pub(crate) root: Vec4,
    pub(crate) wood_from_world: Mat4,
    pub(crate) wood: Vec4,
}

const _: () = assert!(
    size_of::<FrameData>() == 912,
    "shaders/shared/frame.wgsl reads 912 bytes"
);

/// `Rod` of shaders/rod.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct RodData {
    start: Vec3,
    radius: f32,
    end: Vec3,
    pad: f32,
    color: Color,
}

const _: () = assert!(
    size_of::<RodData>() == 48,
    "shaders/rod.wgsl reads 48 bytes"
);

/// `Solid` of shaders/solid.wgsl and board.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct SolidData {
    rows: [Vec4; 3],
    color: Color,
    kind: Vec4,
}

const _: () = assert!(
    size_of::<SolidData>() == 80,
    "shaders/solid.wgsl reads 80 bytes"
);

impl ViewData {
    pub(crate) fn new(eye: &Eye, width_px: u32) -> Self {
        let [left, right, up, down] = eye.fov.tangents();
        let pose = eye.pose();
        let axis = |v: Vec3| pose.orientation * v;
        let (x, y) = ((right + left) / 2.0, (up + down) / 2.0);
        // A picture is at most some thousands of pixels wide: exact in f32.
        #[allow(clippy::cast_precision_loss, reason = "widths are small")]
        let pixel = (right - left) / width_px.max(1) as f32;
        Self {
            clip_from_world: eye.clip_from_world(),
            eye: pose.position.extend(pixel),
            ray: axis(Vec3::new(x, y, -1.0)).extend(0.0),
            ray_x: axis(Vec3::X * ((right - left) / 2.0)).extend(0.0),
            // The picture's y runs down.
            ray_y: axis(Vec3::NEG_Y * ((up - down) / 2.0)).extend(0.0),
        }
    }
}

impl RodData {
    fn rod(rod: &Rod) -> Self {
        Self {
            start: rod.from,
            radius: rod.radius,
            end: rod.to,
            pad: 0.0,
            color: rod.color,
        }
    }

    fn ball(ball: &Ball) -> Self {
        Self {
            start: ball.center,
            radius: ball.radius,
            end: ball.center,
            pad: 0.0,
            color: ball.color,
        }
    }
}

pub(crate) fn rows(map: &Affine3A) -> [Vec4; 3] {
    let m = Mat4::from(*map).transpose();
    [m.x_axis, m.y_axis, m.z_axis]
}

impl SolidData {
    fn plate(plate: &Plate) -> Self {
        Self {
            rows: rows(&plate.world_from_plate),
            color: plate.color,
            kind: Vec4::ZERO,
        }
    }

    fn controller(controller: &Controller) -> Self {
        let mirrored = if controller.hand == 0 { 1.0 } else { 0.0 };
        Self {
            rows: rows(&controller.world_from_grip),
            color: [0.60, 0.61, 0.62, 1.0],
            kind: Vec4::new(1.0, controller.trigger.clamp(0.0, 1.0), mirrored, 0.0),
        }
    }

    fn panel(panel: &PlacedPanel, painted: bool) -> Self {
        Self {
            rows: rows(&panel.world_from_panel),
            color: [if painted { 1.0 } else { 0.0 }, 0.0, 0.0, 0.0],
            kind: Vec4::new(panel.size[0].max(1e-3), panel.size[1].max(1e-3), 0.0, 0.0),
        }
    }
}

/// Ranges of instances in the buffers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Opaque rods, then opaque balls, ghost rods, ghost balls: where each ends.
    pub(crate) rods: u32,
    pub(crate) balls: u32,
    pub(crate) ghost_rods: u32,
    pub(crate) ghost_balls: u32,
    /// Plates, then each hand's controllers, then the board and the panels.
    pub(crate) plates: u32,
    pub(crate) left: u32,
    pub(crate) right: u32,
    pub(crate) panels: u32,
    /// Which picture each panel shows, from instance `right` on.
    pub(crate) pictures: [usize; MOST_PANELS],
}

/// How many records a scene needs: rods and solids.
pub(crate) fn room(scene: &Scene) -> (usize, usize) {
    (
        scene.rods.len() + scene.balls.len(),
        scene.plates.len() + scene.controllers.len() + MOST_PANELS,
    )
}

fn index(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

/// The board and the panels, as many as have a picture.
pub(crate) fn panels(scene: &Scene) -> impl Iterator<Item = PlacedPanel> {
    let board = scene.board.as_ref().map(|board| PlacedPanel {
        slot: 0,
        world_from_panel: board.world_from_board,
        size: board.size,
    });
    let others = scene.panels.iter().copied();
    let known = |panel: &PlacedPanel| (1..MOST_PANELS).contains(&panel.slot);
    board
        .into_iter()
        .chain(others.filter(known).take(MOST_PANELS - 1))
}

/// Writes all instances; what does not fit is left out (the caller made room). `painted` says of which slots there is a picture; none: that panel
/// is not in the scene.
pub(crate) fn fill(
    scene: &Scene,
    painted: impl Fn(usize) -> Option<bool>,
    rods: &mut [RodData],
    solids: &mut [SolidData],
) -> Counts {
    let mut counts = Counts::default();
    let mut at = 0;
    let mut put = |data: RodData| {
        if data.radius > 0.0
            && data.start.is_finite()
            && data.end.is_finite()
            && let Some(place) = rods.get_mut(at)
        {
            *place = data;
            at += 1;
        }
        index(at)
    };
    let opaque = |color: &Color| color[3] >= 1.0;
    for (ghost, ends) in [
        (false, [&mut counts.rods, &mut counts.balls]),
        (true, [&mut counts.ghost_rods, &mut counts.ghost_balls]),
    ] {
        let [rods_end, balls_end] = ends;
        *rods_end = scene
            .rods
            .iter()
            .filter(|rod| opaque(&rod.color) != ghost)
            .fold(put(ZERO), |_, rod| put(RodData::rod(rod)));
        *balls_end = scene
            .balls
            .iter()
            .filter(|ball| opaque(&ball.color) != ghost)
            .fold(put(ZERO), |_, ball| put(RodData::ball(ball)));
    }

    let mut at = 0;
    let mut put = |data: Option<SolidData>| {
        if let Some(data) = data.filter(|data| data.rows.iter().all(|row| row.is_finite()))
            && let Some(place) = solids.get_mut(at)
        {
            *place = data;
            at += 1;
        }
        index(at)
    };
    counts.plates = scene
        .plates
        .iter()
        .fold(0, |_, plate| put(Some(SolidData::plate(plate))));
    let hand = |hand: usize| {
        scene
            .controllers
            .iter()
            .filter(move |controller| (controller.hand == 0) == (hand == 0))
    };
    counts.left = hand(0).fold(put(None), |_, controller| {
        put(Some(SolidData::controller(controller)))
    });
    counts.right = hand(1).fold(put(None), |_, controller| {
        put(Some(SolidData::controller(controller)))
    });
    let mut end = counts.right;
    let mut pictures = counts.pictures.iter_mut();
    for panel in panels(scene) {
        let Some(painted) = painted(panel.slot) else {
            continue;
        };
        let before = end;
        end = put(Some(SolidData::panel(&panel, painted)));
        if end > before
            && let Some(picture) = pictures.next()
        {
            *picture = panel.slot;
        }
    }
    counts.panels = end;
    counts
}

/// A record that `fill` leaves out: no radius.
const ZERO: RodData = RodData {
    start: Vec3::ZERO,
    radius: 0.0,
    end: Vec3::ZERO,
    pad: 0.0,
    color: [0.0; 4],
};

/// The tree's root as the ground's contact shadow needs it: radius at the foot, in the tree's own metres.
pub(crate) fn spots(scene: &Scene, tree: Option<(&PlacedTree, f32)>) -> [Vec4; SPOTS] {
    let mut spots = [Vec4::ZERO; SPOTS];
    let tree = tree.map(|(placed, foot)| {
        let scale = placed.world_from_tree.x_axis.length();
        let at = placed.world_from_tree.translation;
        Vec4::new(
            at.x,
            at.z,
            (foot * scale * 3.0).max(0.05),
            0.55 * near_ground(at.y),
        )
    });
    let plates = scene.plates.iter().map(|plate| {
        let map = &plate.world_from_plate;
        let (at, under) = (map.translation, map.translation - map.matrix3.y_axis);
        Vec4::new(
            at.x,
            at.z,
            map.matrix3.x_axis.length(),
            0.5 * near_ground(under.y.min(at.y)),
        )
    });
    for (place, spot) in spots.iter_mut().zip(
        tree.into_iter()
            .chain(plates)
            .filter(|spot| spot.is_finite() && spot.w > 0.0),
    ) {
        *place = spot;
    }
    spots
}

/// 1 for what touches the ground, 0 from a metre and a half above it.
fn near_ground(height: f32) -> f32 {
    (1.0 - height.max(0.0) / 1.5).max(0.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;

    fn rod(alpha: f32, radius: f32) -> Rod {
        Rod {
            from: Vec3::ZERO,
            to: Vec3::Y,
            radius,
            color: [1.0, 0.0, 0.0, alpha],
        }
    }

    #[test]
    fn instances_are_sorted_into_runs_and_nonsense_is_left_out() {
        let mut scene = Scene::default();
        scene.rods.extend([
            rod(1.0, 0.1),
            rod(0.5, 0.1),
            rod(1.0, f32::NAN),
            rod(1.0, 0.0),
            rod(1.0, 0.2),
        ]);
        scene.rods.push(Rod {
            from: Vec3::NAN,
            ..rod(1.0, 0.1)
        });
        scene.balls.push(Ball {
            center: Vec3::X,
            radius: 0.3,
            color: [1.0; 4],
        });
        scene.balls.push(Ball {
            center: Vec3::X,
            radius: 0.4,
            color: [0.2; 4],
        });
        for hand in [1, 0, 1] {
            scene.controllers.push(Controller {
                world_from_grip: Affine3A::IDENTITY,
                hand,
                trigger: 2.0,
            });
        }
        scene.plates.push(Plate {
            world_from_plate: Affine3A::IDENTITY,
            color: [0.5; 4],
        });
        let mut rods = [ZERO; 16];
        let mut solids = [SolidData::zeroed(); 8];
        let counts = fill(&scene, |_| Some(false), &mut rods, &mut solids);
        assert_eq!(
            (
                counts.rods,
                counts.balls,
                counts.ghost_rods,
                counts.ghost_balls
            ),
            (2, 3, 4, 5)
        );
        assert_eq!(
            (counts.plates, counts.left, counts.right, counts.panels),
            (1, 2, 4, 4)
        );
        assert_eq!(
            rods.map(|rod| rod.radius)[..6],
            [0.1, 0.2, 0.3, 0.1, 0.4, 0.0]
        );
        assert_eq!(solids[1].kind.z, 1.0, "the left hand is mirrored");
        assert_eq!(solids[2].kind.y, 1.0, "the trigger is clamped");
        // Too little room is no crash.
        assert_eq!(
            fill(&scene, |_| Some(false), &mut rods[..1], &mut []).ghost_balls,
            1
        );
    }
}
