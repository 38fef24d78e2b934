//! Which triangles of the models a frame draws: what is handed to the [`Selection`](crate::render::selection::Selection), and what comes back.

use glam::{Affine3A, Vec4};

use super::{Chosen, Garbage, Renderer, SLOTS};
use crate::render::{
    error::RenderError,
    eye::{Eye, NEAR},
    selection::{entry_parts, is_seen, standing, views},
};
use crate::tree::levels::cut::{Standing, Views};
use crate::world::scene::{PlacedModel, PlacedTree, Scene};

/// A frame shows so many vertices as points, of larger models each second, third and so on.
const MOST_POINTS: u32 = 250_000;

/// Pixels that levels of detail are never asked to be better than.
const FINEST: f32 = 1e-6;

impl Renderer {
    /// Lists the models' and the tree's chunks; what the slot's last frame chose.
    pub(super) fn gather(
        &mut self,
        scene: &Scene,
        tree: Option<&PlacedTree>,
        views: &Views,
        slot: usize,
    ) -> Result<Chosen, RenderError> {
        let chosen = self.selection.begin(slot);
        self.gather_models(scene, views);
        if let (Some(upload), Some(placed)) = (&self.tree, tree) {
            let place = placed.world_from_tree;
            let place = if place.is_finite() {
                place
            } else {
                Affine3A::default()
            };
            let standing = Standing {
                sway: self.sway_of(placed),
                ..Standing::new(place, Vec4::ZERO, false, NEAR)
            };
            let branches = upload.chunks.iter().map(|chunk| (chunk, 0.0));
            let flutter = self.sway.flutter();
            let leaves = upload.leaves.iter().map(|chunk| (&chunk.crown, flutter));
            let crowns = &mut self.selection.crowns;
            crowns.add(slot, standing, views, branches.chain(leaves));
        }
        let (models, crowns) = self.selection.make_room(slot)?;
        let old = models.map(Garbage::Room).into_iter();
        let old = old.chain(crowns.map(Garbage::Crowns));
        self.garbage.extend(old.map(|old| (self.frame, old)));
        Ok(chosen)
    }

    /// Lists what of the models is in sight, and what throws a shadow that must be drawn.
    fn gather_models(&mut self, scene: &Scene, views: &Views) {
        let wood_is_due = self.wood.is_due();
        let is_due = |placed: &PlacedModel| {
            // A wood is mostly behind one's back.
            placed.world_from_model.is_finite()
                && (wood_is_due && placed.look.shadow || is_seen(placed, views))
        };
        self.selection.stand(&scene.models, is_due);
        let mut first = 0;
        while let Some((run, placed)) = self.selection.run_from(first, &scene.models) {
            first = run.end;
            let shape = self.shown(placed).map(|(shape, _)| shape);
            let at = shape.and_then(|shape| {
                let mut shapes = self.shapes.iter();
                shapes.position(|other| std::ptr::eq(other, shape))
            });
            if let Some(shape) = at.and_then(|at| self.shapes.get(at)) {
                self.selection.add(run, &placed.look, shape);
            }
        }
    }

    /// Of so many vertices one is shown.
    pub(super) fn points_each(&self, scene: &Scene) -> u32 {
        self.points(scene)
            .div_ceil(MOST_POINTS.min(self.params.primitives / 4).max(1))
            .max(1)
    }

    /// Vertices of all models that show theirs.
    fn points(&self, scene: &Scene) -> u32 {
        let shown = scene.models.iter().filter(|placed| placed.look.vertices);
        let points = shown.filter_map(|placed| Some(self.shown(placed)?.0.points));
        points.fold(0, u32::saturating_add)
    }

    /// Triangles of trees and models that a frame may have; `each`: of so many vertices one is shown.
    pub(super) fn budget(&self, scene: &Scene, each: u32) -> u32 {
        let points = 2 * (self.points(scene) / each.max(1));
        self.params.primitives.saturating_sub(points)
    }

    /// Both eyes as the choice takes them.
    pub(super) fn views_of(&self, eyes: &[Eye; 2]) -> Views {
        let params = &self.params;
        views(eyes, self.part.width, params.error_px.max(FINEST))
    }

    fn last_slot(&self) -> usize {
        usize::try_from(self.frame.saturating_sub(1) % SLOTS as u64).unwrap_or(0)
    }

    /// Waits for the last frame, and says what was chosen of trees and models' faces in it, as the draws say it that the device made. For tests and benchmarks:
    /// frames do without waiting.
    ///
    /// # Errors
    /// [`RenderError`] when the device fails.
    pub fn chosen(&mut self) -> Result<Chosen, RenderError> {
        self.wait()?;
        let slot = self.last_slot();
        Ok(self.selection.chosen(slot))
    }

    /// Waits for the last frame of this scene, and says which triangles of each model were chosen in it: by their numbers among those of all levels, as
    /// they were drawn. For tests.
    ///
    /// # Errors
    /// [`RenderError`] when the device fails.
    pub fn chosen_triangles(&mut self, scene: &Scene) -> Result<Vec<Vec<u32>>, RenderError> {
        self.wait()?;
        let slot = self.last_slot();
        let mut all = vec![Vec::new(); scene.models.len()];
        for listed in self.selection.read(slot)? {
            for entry in listed.entries {
                let (which, triangle) = entry_parts(entry);
                let Some(number) = listed.models.get(which).copied() else {
                    continue;
                };
                let placed = scene.models.get(number);
                let shape = placed.and_then(|placed| self.is_chosen(placed));
                let chunk = shape.and_then(|shape| shape.chunks.get(listed.chunk));
                let first = chunk.map_or(0, |chunk| chunk.first_triangle);
                if let Some(model) = all.get_mut(number) {
                    model.push(first + triangle);
                }
            }
        }
        Ok(all)
    }

    /// What the choice is worked out from, for its twin in [`crate::tree::levels::cut`].
    #[must_use]
    pub fn choice_of(&self, placed: &PlacedModel, eyes: &[Eye; 2]) -> (Standing, Views) {
        (standing(placed), self.views_of(eyes))
    }

    /// Waits for the last frame, and says which batches of the tree's records were chosen in it: of each chunk, branches and then each surface's leaves, a list of
    /// numbers with the [kind](crate::tree::levels::kinds) in the bits from 28 on. For tests.
    ///
    /// # Errors
    /// [`RenderError`] when the device fails.
    pub fn chosen_batches(&mut self) -> Result<Vec<Vec<u32>>, RenderError> {
        self.wait()?;
        let slot = self.last_slot();
        self.selection.crowns.read(slot)
    }

    /// What the choice of the shown tree's branches is worked out from, for its twin in [`crate::tree::levels`].
    #[must_use]
    pub fn choice_of_tree(&self, placed: &PlacedTree, eyes: &[Eye; 2]) -> (Standing, Views) {
        let standing = Standing {
            sway: self.sway_of(placed),
            ..Standing::new(placed.world_from_tree, Vec4::ZERO, false, NEAR)
        };
        (standing, self.views_of(eyes))
    }
}
