//! Where models and trees stand, and which parts of them a dispatch looks at: as shaders/select.wgsl, crown.wgsl and model.wgsl read it.

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use crate::render::data::rows;
use crate::tree::levels::cut::Standing;

/// `Standing` of shaders/shared/standing.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct StandingData {
    rows: [Vec4; 3],
    cut: Vec4,
    scale: f32,
    near: f32,
    by_grain: u32,
    pad: u32,
}

impl From<&Standing> for StandingData {
    fn from(standing: &Standing) -> Self {
        Self {
            rows: rows(&standing.world_from_model),
            cut: standing.cut,
            scale: standing.scale,
            near: standing.near,
            by_grain: u32::from(standing.by_grain),
            pad: 0,
        }
    }
}

/// `Item` of shaders/shared/choice.wgsl: a dispatch's immediates.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct ItemData {
    pub(super) clusters: u32,
    /// The first of its groups among all, and how many each model has.
    pub(super) first_group: u32,
    pub(super) groups: u32,
    pub(super) models: u32,
    /// The first model's number among all that stand.
    pub(super) standing: u32,
    pub(super) draw: u32,
    pub(super) budget: u32,
    /// 1: it is not drawn in this pass.
    pub(super) absent: u32,
    /// What the wind may move it by, metres.
    pub(super) sway: f32,
}

impl ItemData {
    /// The first group after its own.
    pub(super) fn end(&self) -> u32 {
        self.first_group + self.groups * self.models
    }
}

const _: () = assert!(
    size_of::<StandingData>() == 80 && size_of::<ItemData>() == 36,
    "shaders/shared/standing.wgsl and choice.wgsl read 80 and 36 bytes"
);
