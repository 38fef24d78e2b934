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
        let root = root_of(Some(placed));
        let radius = tree.bounds.radius * place.x_axis.length();
        let middle = place.transform_point3(tree.bounds.center) - root;
        let most = self
            .sway
            .most(middle.y + radius, middle.with_y(0.0).length() + radius);
        if most.is_finite() { most } else { 0.0 }
    }
}

/// A sphere around a tree where it stands.
pub(super) fn sphere_of(pass: &Pass<'_>, world_from_tree: Affine3A) -> Vec4 {
    let bounds = pass.tree.map(|tree| tree.bounds).unwrap_or_default();
    let scale = world_from_tree.x_axis.length();
    let middle = world_from_tree.transform_point3(bounds.center);
    middle.extend(bounds.radius * scale)
}

/// Where a tree stands: its first node.
pub(super) fn root_of(placed: Option<&PlacedTree>) -> Vec3 {
    let root = placed.and_then(|placed| {
        let first = placed.tree.position.first()?;
        Some(placed.world_from_tree.transform_point3(*first))
    });
    root.filter(|root| root.is_finite()).unwrap_or_default()
}
