//! Light and wind as the renderer takes them.

use glam::{Affine3A, Vec3, Vec4};

use super::{Renderer, RendererParams, record::Pass};
use crate::render::{data::FrameData, light, shadow::ShadowKey};
use crate::world::scene::{
    PlacedTree,
    weather::{Light, Sway},
};

impl RendererParams {
    /// The same, lit by this.
    #[must_use]
    pub fn lit(self, light: Light) -> Self {
        Self {
            light,
            sun: light::sun(light),
            ..self
        }
    }
}

impl Renderer {
    /// Lights everything like this from the next draw on.
    pub fn set_light(&mut self, light: Light) {
        if self.params.light != light {
            self.params = self.params.lit(light);
            self.params.sun = self.params.sun.normalize_or(Vec3::Y);
        }
    }

    /// Shows trees as the wind moves them at such a moment, in the next draws.
    pub fn set_sway(&mut self, sway: Sway) {
        // In still air time changes nothing, so the sun's map needs not be drawn anew.
        self.sway = if sway.moves() { sway } else { Sway::default() };
    }

    /// What the shadow map must have been drawn for.
    pub(super) fn shadow_key(
        &self,
        placed: Option<&PlacedTree>,
        numbers: &FrameData,
    ) -> Option<ShadowKey> {
        let tree = self.tree.as_ref()?;
        let placed = placed?;
        (numbers.tree.z > 0.0).then_some(ShadowKey {
            revision: tree.revision,
            growth: numbers.tree.x,
            world_from_tree: placed.world_from_tree,
            sun: self.params.sun,
            sway: self.sway,
        })
    }

    /// No place of the shown tree is farther than this from where it rests, metres.
    pub(super) fn sway_of(&self, placed: &PlacedTree) -> f32 {
        let Some(tree) = self.tree.as_ref().filter(|_| self.sway.moves()) else {
            return 0.0;
        };
        let place = placed.world_from_tree;
        let root = self.root_of(placed);
        let radius = tree.bounds.radius * place.x_axis.length();
        let middle = place.transform_point3(tree.bounds.center) - root;
        let most = self
            .sway
            .most(middle.y + radius, middle.with_y(0.0).length() + radius);
        if most.is_finite() { most } else { 0.0 }
    }

    /// The same of corners of its leaves, which flutter besides.
    pub(super) fn stir_of(&self, placed: &PlacedTree) -> f32 {
        let leaves = self.tree.iter().flat_map(|tree| &tree.leaves);
        let longest = leaves.map(|leaf| leaf.crown.size).fold(0.0, f32::max);
        let flutter = longest * placed.world_from_tree.x_axis.length() * self.sway.flutter();
        self.sway_of(placed) + if flutter.is_finite() { flutter } else { 0.0 }
    }

    /// Where the shown tree stands: its first node. It is that of before as long as another is on its way.
    pub(super) fn root_of(&self, placed: &PlacedTree) -> Vec3 {
        let tree = self.tree.as_ref();
        let root = tree.map(|tree| placed.world_from_tree.transform_point3(tree.bounds.root));
        root.filter(|root| root.is_finite()).unwrap_or_default()
    }
}

/// A sphere around a tree where it stands.
pub(super) fn sphere_of(pass: &Pass<'_>, world_from_tree: Affine3A) -> Vec4 {
    let bounds = pass.tree.map(|tree| tree.bounds).unwrap_or_default();
    let scale = world_from_tree.x_axis.length();
    let middle = world_from_tree.transform_point3(bounds.center);
    middle.extend(bounds.radius * scale)
}
