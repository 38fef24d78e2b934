//! The stage: where things stand, how large they are, and their colours.
//!
//! The platform is the world in miniature and stands within reach; the same
//! sketch at full size stands on the ground behind it, so cause and effect are
//! seen in one look. Only hands move anything here, and only the platform.

use glam::{Affine3A, Quat, Vec3};

use super::{
    document::Placement,
    hover::Ring,
    scene::{Color, Plate},
};

/// Sizes and places on the stage, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageParams {
    /// Radius of the platform's top; it stays the same at every scale, so that the rim can always be gripped.
    pub platform_radius: f32,
    /// Thickness of the platform's top.
    pub platform_thickness: f32,
    /// Width of the rim around the top.
    pub rim_width: f32,
    /// How far the rim lies below the top, so that the two never flicker.
    pub rim_drop: f32,
    /// Radius of the pedestal's column.
    pub column_radius: f32,
    /// Radius of the pedestal's foot.
    pub foot_radius: f32,
    /// Height of the pedestal's foot.
    pub foot_height: f32,
    /// Where the full-size tree stands.
    pub tree: Vec3,
    /// Centre of the board.
    pub board: Vec3,
    /// The point that the board faces: about where a head is.
    pub board_faces: Vec3,
    /// Width and height of the board.
    pub board_size: [f32; 2],
    /// Radius of a node's ball.
    pub node_radius: f32,
    /// Radius of a sketch line.
    pub line_radius: f32,
    /// Radius of the ghost around the selected node, and of the ball that the trigger will make.
    pub selected_radius: f32,
    /// Radius of the mark around an attachment.
    pub attachment_radius: f32,
    /// Radius of the mark around a node where an attachment repeats.
    pub repeat_radius: f32,
    /// Radius of a ray.
    pub ray_radius: f32,
    /// How far a ray is drawn that meets nothing.
    pub ray_length: f32,
}

impl Default for StageParams {
    fn default() -> Self {
        Self {
            platform_radius: 0.24,
            platform_thickness: 0.02,
            rim_width: 0.03,
            rim_drop: 0.004,
            column_radius: 0.045,
            foot_radius: 0.17,
            foot_height: 0.03,
            tree: Vec3::new(0.0, 0.0, -6.0),
            // Below the horizon and beside the platform: it hides neither the tree nor what is drawn.
            // As near as its smallest text needs: a degree high from 1.35 m.
            board: Vec3::new(0.874, 0.998, -0.782),
            board_faces: Vec3::new(0.0, 1.55, 0.0),
            board_size: [0.92, 0.92],
            node_radius: 0.008,
            line_radius: 0.004,
            selected_radius: 0.014,
            attachment_radius: 0.012,
            repeat_radius: 0.010,
            ray_radius: 0.0012,
            ray_length: 0.35,
        }
    }
}

/// Every colour on the stage, linear. Hues are Okabe and Ito's (<https://jfly.uni-koeln.de/color/>), which people with
/// any colour vision tell apart; marks also differ in size, never in hue alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Palette {
    /// Sketch lines by letter, in the order of the letters; begins again after the last.
    pub letters: [Color; 6],
    /// A node.
    pub node: Color,
    /// The node under the hand.
    pub hovered: Color,
    /// Around the selected node.
    pub selected: Color,
    /// What the trigger will make.
    pub ghost: Color,
    /// A ray that meets nothing.
    pub ray: Color,
    /// A ray that meets something.
    pub ray_hit: Color,
    /// The platform's top.
    pub platform: Color,
    /// The platform's rim.
    pub rim: Color,
    /// The rim under a hand.
    pub rim_hovered: Color,
    /// The pedestal.
    pub pedestal: Color,
    /// The stump's bark.
    pub stump: Color,
    /// The stump's cut.
    pub stump_top: Color,
    /// How much of a letter's colour its attachment's mark has, 0 to 1.
    pub attachment_alpha: f32,
    /// How much of it the mark of a repeat has, 0 to 1.
    pub repeat_alpha: f32,
}

impl Default for Palette {
    fn default() -> Self {
        let orange = linear(0xE6_9F_00);
        let sky_blue = linear(0x56_B4_E9);
        let bluish_green = linear(0x00_9E_73);
        let yellow = linear(0xF0_E4_42);
        let blue = linear(0x00_72_B2);
        let vermilion = linear(0xD5_5E_00);
        let reddish_purple = linear(0xCC_79_A7);
        Self {
            letters: [
                orange,
                sky_blue,
                bluish_green,
                reddish_purple,
                blue,
                vermilion,
            ],
            node: linear(0xF2_F0_EA),
            hovered: yellow,
            selected: faded(yellow, 0.45),
            ghost: faded(linear(0xFF_FF_FF), 0.5),
            ray: faded(linear(0xFF_FF_FF), 0.25),
            ray_hit: faded(yellow, 0.8),
            platform: linear(0x8B_84_79),
            rim: linear(0x4A_46_40),
            rim_hovered: yellow,
            pedestal: linear(0x5C_57_50),
            stump: linear(0x6B_4A_2E),
            stump_top: linear(0xC9_A2_6B),
            attachment_alpha: 0.55,
            repeat_alpha: 0.3,
        }
    }
}

impl Palette {
    /// The colour of a letter's lines.
    #[must_use]
    pub fn letter(&self, index: u16) -> Color {
        let place = usize::from(index) % self.letters.len();
        self.letters.get(place).copied().unwrap_or(self.node)
    }
}

/// A colour written as sRGB `0xRRGGBB`, opaque.
fn linear(srgb: u32) -> Color {
    let [_, red, green, blue] = srgb.to_be_bytes();
    let [red, green, blue] = [red, green, blue].map(|byte| {
        let value = f32::from(byte) / 255.0;
        // IEC 61966-2-1.
        if value <= 0.040_45 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    });
    [red, green, blue, 1.0]
}

/// The colour with this alpha.
pub(super) fn faded([red, green, blue, _]: Color, alpha: f32) -> Color {
    [red, green, blue, alpha]
}

/// Sketch (metres from its root) to stage.
#[must_use]
pub fn stage_from_sketch(placement: &Placement) -> Affine3A {
    Affine3A::from_scale_rotation_translation(
        Vec3::splat(placement.scale),
        Quat::from_rotation_y(placement.yaw()),
        placement.position,
    )
}

/// The platform's rim.
#[must_use]
pub fn rim(placement: &Placement, params: &StageParams) -> Ring {
    Ring {
        center: placement.position - Vec3::Y * params.rim_drop,
        inner: params.platform_radius,
        outer: params.platform_radius + params.rim_width,
    }
}

/// The platform and its pedestal.
pub(super) fn furniture(
    placement: &Placement,
    rim_hovered: bool,
    params: &StageParams,
    palette: &Palette,
    plates: &mut Vec<Plate>,
) {
    let turn = Quat::from_rotation_y(placement.yaw());
    let mut plate = |radius: f32, thickness: f32, top: Vec3, color: Color| {
        let size = Vec3::new(radius, thickness.max(f32::MIN_POSITIVE), radius);
        plates.push(Plate {
            world_from_plate: Affine3A::from_scale_rotation_translation(size, turn, top),
            color,
        });
    };
    let top = placement.position;
    let rim_color = if rim_hovered {
        palette.rim_hovered
    } else {
        palette.rim
    };
    plate(
        params.platform_radius,
        params.platform_thickness,
        top,
        palette.platform,
    );
    let rim_top = top - Vec3::Y * params.rim_drop;
    plate(
        params.platform_radius + params.rim_width,
        params.platform_thickness,
        rim_top,
        rim_color,
    );
    let column = top.y - params.platform_thickness;
    if column > 0.0 {
        plate(
            params.column_radius,
            column,
            Vec3::new(top.x, column, top.z),
            palette.pedestal,
        );
        plate(
            params.foot_radius,
            params.foot_height,
            Vec3::new(top.x, params.foot_height, top.z),
            palette.pedestal,
        );
    }
}

/// The board to the stage: level, tilted so that its front is towards [`StageParams::board_faces`].
#[must_use]
pub fn stage_from_board(params: &StageParams) -> Affine3A {
    let facing = params.board_faces - params.board;
    let yaw = facing.x.atan2(facing.z);
    let pitch = facing.y.atan2(facing.x.hypot(facing.z));
    let turn = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(-pitch);
    Affine3A::from_rotation_translation(turn, params.board)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn grey_is_linear() {
        let [red, _, _, alpha] = linear(0xBC_BC_BC);
        assert!(
            (red - 0.503).abs() < 1e-3 && alpha == 1.0,
            "sRGB 188 is half of white's light"
        );
    }

    #[test]
    fn a_turned_platform_turns_the_sketch_about_its_root() {
        let placement = Placement {
            position: Vec3::new(0.1, 0.9, -0.5),
            yaw_deg: 90.0,
            scale: 0.5,
        };
        let at = stage_from_sketch(&placement).transform_point3(Vec3::new(0.2, 0.4, 0.0));
        // A quarter turn about +Y takes +X to −Z.
        assert!(at.distance(Vec3::new(0.1, 1.1, -0.6)) < 1e-6, "{at}");
    }

    #[test]
    fn the_board_faces_the_head() {
        let params = StageParams::default();
        let stage = stage_from_board(&params);
        let wanted = params.board_faces - params.board;
        assert!(
            stage
                .transform_vector3(Vec3::Z)
                .distance(wanted.normalize())
                < 1e-5
        );
        assert!(
            stage.transform_vector3(Vec3::X).y.abs() < 1e-5,
            "its lines are level"
        );
        assert!(stage.transform_vector3(Vec3::Y).y > 0.9, "its top is up");
    }

    #[test]
    fn furniture_stands_on_the_floor_and_shows_the_rim() {
        let (params, palette) = (StageParams::default(), Palette::default());
        for (y, expected) in [(0.9, 4), (0.0, 2), (-1.0, 2)] {
            let placement = Placement {
                position: Vec3::new(0.0, y, 0.0),
                ..Placement::default()
            };
            let mut plates = Vec::new();
            furniture(&placement, true, &params, &palette, &mut plates);
            assert_eq!(plates.len(), expected, "{y}");
            assert!(
                plates
                    .iter()
                    .any(|plate| plate.color == palette.rim_hovered)
            );
            for plate in plates.iter().skip(2) {
                let foot = plate.world_from_plate.transform_point3(Vec3::NEG_Y).y;
                assert!(foot.abs() < 1e-6, "{foot}");
            }
        }
    }
}
