//! One picture of one tree, without a headset: for the command line and the docs.

use std::sync::Arc;

use anyhow::{Result, bail};
use glam::{Affine3A, Quat, Vec3};
use image::RgbaImage;
use ramus_xr::{Fov, Pose, View};

use crate::app::picture::Picture;
use crate::render::{Gpu, GpuParams, Headless};
use crate::tree::Tree;
use crate::world::scene::{PlacedTree, Scene};

/// How a tree is placed for its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PortraitParams {
    /// Half the largest extent that the tree is brought to, metres: grammars have no common unit.
    pub radius: f32,
    /// The eye's height above the tree's middle, as a part of the distance.
    pub rise: f32,
    /// Vertical field of view, radians.
    pub field: f32,
    /// How much room is left round the tree: 1 fills the picture.
    pub room: f32,
}

impl Default for PortraitParams {
    fn default() -> Self {
        Self {
            radius: 1.5,
            rise: 0.12,
            field: 0.7,
            room: 1.15,
        }
    }
}

/// Opens the device for pictures without a headset.
///
/// # Errors
/// Where there is no Vulkan device that can draw.
pub fn open_gpu() -> Result<Gpu> {
    Ok(Gpu::new(&Headless::default(), &GpuParams::from_env())?)
}

/// Draws a tree of any size on the stage's ground, as seen from before it; `pixels` wide and high.
///
/// # Errors
/// Where the tree has no segment or no device can draw it.
pub fn of_tree(tree: Arc<Tree>, pixels: u32) -> Result<RgbaImage> {
    let params = PortraitParams::default();
    if tree.segment_count() == 0 {
        bail!(
            "the tree has no segment, so there is nothing to draw: segments are drawn by `F` and by the letters of shapes"
        );
    }
    let Some((low, high)) = tree.bounds() else {
        bail!("the tree has no node, so there is nothing to draw");
    };
    let half = ((high - low) * 0.5).max_element();
    if half < f32::MIN_POSITIVE {
        bail!(
            "the tree's nodes all stand in one place, so there is nothing to draw: give its segments a length"
        );
    }
    let scale = params.radius / half;
    let middle = (low + high) * 0.5;
    // What is lowest touches the ground.
    let foot = Vec3::new(middle.x, low.y, middle.z);
    let world_from_tree = Affine3A::from_scale_rotation_translation(
        Vec3::splat(scale),
        Quat::IDENTITY,
        -foot * scale,
    );
    let extent = (high - low) * scale;
    let target = Vec3::new(0.0, extent.y * 0.5, 0.0);
    let reach = extent.length() * 0.5 * params.room;
    let distance = reach / (params.field * 0.5).sin();
    let eye = target + Vec3::new(0.0, params.rise, 1.0).normalize() * distance;
    let scene = Scene {
        tree: Some(PlacedTree {
            tree,
            radius_before: Arc::default(),
            revision: 1,
            world_from_tree,
            growth: 1.0,
            newest: u32::MAX,
        }),
        ..Scene::default()
    };
    let view = looking_at(eye, target, params.field);
    let gpu = open_gpu()?;
    let mut picture = Picture::offscreen(&gpu, pixels, pixels)?;
    picture.draw_whole(&scene, &[view, view], None)?;
    let [left, _] = picture.read(None)?;
    Ok(left)
}

/// A view from `eye` towards `target`, upright, `field` radians wide and high.
#[must_use]
pub fn looking_at(eye: Vec3, target: Vec3, field: f32) -> View {
    let ahead = (target - eye).normalize_or(Vec3::NEG_Z);
    let yaw = (-ahead.x).atan2(-ahead.z);
    let pitch = ahead.y.clamp(-1.0, 1.0).asin();
    let half = field * 0.5;
    View {
        pose: Pose {
            orientation: Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch),
            position: eye,
        },
        fov: Fov {
            left: -half,
            right: half,
            up: half,
            down: -half,
        },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::*;
    use crate::tree::NO_PARENT;

    /// Nodes in a row, so far from each other.
    fn row(nodes: u16, apart: f32) -> Tree {
        let count = usize::from(nodes);
        Tree {
            parent: (0..u32::from(nodes))
                .map(|node| node.checked_sub(1).unwrap_or(NO_PARENT))
                .collect(),
            position: (0..nodes)
                .map(|node| Vec3::new(10.0, apart * f32::from(node), 0.0))
                .collect(),
            radius: vec![0.01; count],
            letter: vec![0; count],
            order: vec![0; count],
            birth: vec![0; count],
            letters: vec!["F".to_owned()],
        }
    }

    #[test]
    fn a_tree_without_extent_is_refused_before_any_device_is_asked() {
        for (what, tree, expected) in [
            ("nothing", row(0, 0.0), "no segment"),
            ("the root alone", row(1, 0.0), "no segment"),
            ("all in one place", row(3, 0.0), "in one place"),
        ] {
            let error = of_tree(Arc::new(tree), 16).unwrap_err().to_string();
            assert!(error.contains(expected), "{what}: {error}");
        }
    }
}
