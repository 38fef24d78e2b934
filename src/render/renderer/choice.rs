//! Which triangles of the models a frame draws: what is handed to the [`Selection`](crate::render::selection::Selection), and what comes back.

use ash::vk;

use super::{Chosen, Garbage, Renderer, SLOTS};
use crate::mesh::levels::cut::{Standing, Views};
use crate::render::{
    error::RenderError,
    eye::Eye,
    selection::{standing, views},
};
use crate::world::scene::{PlacedModel, Scene};

/// A frame shows so many vertices as points, of larger models each second, third and so on.
const MOST_POINTS: u32 = 250_000;

impl Renderer {
    /// Lists the models' chunks; what the slot's last frame chose.
    pub(super) fn gather(&mut self, scene: &Scene, slot: usize) -> Result<Chosen, RenderError> {
        let chosen = self.selection.begin(slot);
        for (number, placed) in scene.models.iter().enumerate() {
            let at = self.is_chosen(placed).and_then(|shape| {
                let mut shapes = self.shapes.iter();
                shapes.position(|other| std::ptr::eq(other, shape))
            });
            if let Some(shape) = at.and_then(|at| self.shapes.get(at)) {
                self.selection.add(number, placed, shape);
            }
        }
        if let Some(old) = self.selection.make_room()? {
            self.garbage.push((self.frame, Garbage::Room(old)));
        }
        Ok(chosen)
    }

    /// Of so many vertices one is shown.
    pub(super) fn points_each(&self, scene: &Scene) -> u32 {
        self.points(scene)
            .div_ceil(MOST_POINTS.min(self.params.model_primitives / 4).max(1))
            .max(1)
    }

    /// Vertices of all models that show theirs.
    fn points(&self, scene: &Scene) -> u32 {
        let shown = scene.models.iter().filter(|placed| placed.look.vertices);
        let points = shown.filter_map(|placed| Some(self.shown(placed)?.0.points));
        points.fold(0, u32::saturating_add)
    }

    /// Records the choice; `each`: of so many vertices one is shown.
    pub(super) fn choose(
        &mut self,
        scene: &Scene,
        eyes: &[Eye; 2],
        commands: vk::CommandBuffer,
        slot: usize,
        each: u32,
    ) {
        let points = 2 * (self.points(scene) / each.max(1));
        let budget = self.params.model_primitives.saturating_sub(points);
        let width = self.params.extent.width;
        self.selection.record(commands, slot, eyes, width, budget);
    }

    fn last_slot(&self) -> usize {
        usize::try_from(self.frame.saturating_sub(1) % SLOTS as u64).unwrap_or(0)
    }

    /// Waits for the last frame, and says what was chosen of models' faces in it, as the draws say it that the device made. For tests and benchmarks:
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
        let lists = self.selection.read(slot)?;
        let mut all = vec![Vec::new(); scene.models.len()];
        for (item, list) in self.selection.items.iter().zip(lists) {
            let placed = scene.models.get(item.model);
            let shape = placed.and_then(|placed| self.is_chosen(placed));
            let chunk = shape.and_then(|shape| shape.chunks.get(item.chunk));
            let first = chunk.map_or(0, |chunk| chunk.first_triangle);
            if let Some(model) = all.get_mut(item.model) {
                model.extend(list.iter().map(|number| first + number));
            }
        }
        Ok(all)
    }

    /// What the choice is worked out from, for its twin in [`crate::mesh::levels::cut`].
    #[must_use]
    pub fn choice_of(&self, placed: &PlacedModel, eyes: &[Eye; 2]) -> (Standing, Views) {
        (standing(placed), views(eyes, self.params.extent.width))
    }
}
