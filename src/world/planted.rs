//! The meshes of planted trees: which ones a grove needs, and where each of them stands.
//!
//! The world grows none of them: it says which individual it wants next ([`PlantRequest`]), and shows what it is given, so that frames wait for none. All that a
//! kind's plants need are its [`INDIVIDUALS`]; every plant is one of their meshes in another place. When the tree on the platform changes, its plants are seen as
//! they were until each of its individuals has grown anew.

use std::sync::Arc;

use super::{
    World,
    document::Document,
    grove::{Grove, INDIVIDUALS, Kind, Plant},
    scene::{ModelLook, PlacedModel, Scene, SurfaceLook, new_revision},
};
use crate::mesh::display::Display;
use crate::sketch::Sketch;

const MANY: usize = INDIVIDUALS as usize;

/// An individual that is to be grown.
#[derive(Clone, Debug)]
pub struct PlantRequest {
    /// What grows.
    pub sketch: Arc<Sketch>,
    /// How far.
    pub step: u32,
    /// Which of its individuals.
    pub individual: u8,
}

impl PlantRequest {
    /// Whether another one is the same.
    #[must_use]
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.sketch, &other.sketch)
            && (self.step, self.individual) == (other.step, other.individual)
    }
}

/// A kind, and those of its individuals that have grown.
#[derive(Clone, Debug)]
struct Stock {
    kind: Kind,
    /// Which ones plants are.
    wanted: [bool; MANY],
    /// Mesh and revision of each.
    seen: [Option<(Arc<Display>, u64)>; MANY],
    /// Whether that is of this very kind, or known not to grow.
    is_done: [bool; MANY],
}

impl Stock {
    fn new(kind: Kind) -> Self {
        Self {
            kind,
            wanted: [false; MANY],
            seen: [const { None }; MANY],
            is_done: [false; MANY],
        }
    }

    fn is_of(&self, kind: &Kind) -> bool {
        let same = Arc::ptr_eq(&self.kind.sketch, &kind.sketch);
        self.kind.step == kind.step && (same || self.kind.sketch == kind.sketch)
    }

    /// Of this kind from now on, and until its own have grown with the meshes of the one before.
    fn standing_in(mut self, kind: Kind) -> Self {
        self.is_done = [false; MANY];
        self.kind = kind;
        self
    }
}

/// See the module.
#[derive(Debug, Default)]
pub(super) struct Planted {
    /// That of the tree on the platform, then those that the grove keeps; empty where nothing is planted.
    stocks: Vec<Stock>,
    /// The plants' numbers in the grove, those of one mesh one after the other: these are drawn as one.
    order: Vec<usize>,
    /// What they are for.
    of: Option<(Arc<Grove>, Arc<Sketch>, u32)>,
}

impl Planted {
    /// Follows the document: forgets what no plant needs any more.
    pub(super) fn follow(&mut self, document: &Document) {
        let Document {
            grove,
            sketch,
            step,
            ..
        } = document;
        if let Some((of, own, at)) = &self.of
            && Arc::ptr_eq(of, grove)
            && (grove.is_empty() || Arc::ptr_eq(own, sketch) && at == step)
        {
            return;
        }
        self.of = Some((Arc::clone(grove), Arc::clone(sketch), *step));
        self.order = (0..grove.plants.len()).collect();
        self.order
            .sort_by_key(|number| grove.plants.get(*number).map(mesh));
        let mut before = std::mem::take(&mut self.stocks);
        if grove.is_empty() {
            return;
        }
        let living = Kind {
            sketch: Arc::clone(sketch),
            step: *step,
        };
        let was_living = before.first().map(|stock| stock.kind.clone());
        let mut stocks: Vec<Stock> = std::iter::once(&living)
            .chain(&grove.kinds)
            .map(
                |kind| match before.iter().position(|stock| stock.is_of(kind)) {
                    Some(at) => before.swap_remove(at),
                    None => Stock::new(kind.clone()),
                },
            )
            .collect();
        let has_grown = living.step > 0 && !living.sketch.is_empty();
        if let Some(was) = was_living
            && has_grown
            && grove.is_living()
            && stocks
                .first()
                .is_some_and(|stock| stock.seen.iter().all(Option::is_none))
            && let Some(at) = before.iter().position(|stock| stock.is_of(&was))
        {
            stocks[0] = before.swap_remove(at).standing_in(living);
        }
        for (number, stock) in stocks.iter_mut().enumerate() {
            stock.wanted = [false; MANY];
            for plant in grove.plants.iter().filter(|plant| place(plant) == number) {
                if let Some(wanted) = stock.wanted.get_mut(usize::from(plant.individual)) {
                    *wanted = stock.kind.step > 0 && !stock.kind.sketch.is_empty();
                }
            }
            for (seen, wanted) in stock.seen.iter_mut().zip(stock.wanted) {
                if !wanted {
                    *seen = None;
                }
            }
            for (done, wanted) in stock.is_done.iter_mut().zip(stock.wanted) {
                *done &= wanted;
            }
        }
        self.stocks = stocks;
    }

    /// The next individual that plants lack, if they lack one.
    pub(super) fn request(&self) -> Option<PlantRequest> {
        self.stocks.iter().find_map(|stock| {
            let lacks = stock.wanted.iter().zip(stock.is_done);
            let lacks = (0..)
                .zip(lacks)
                .find(|(_, (wanted, done))| **wanted && !done);
            lacks.map(|(individual, _)| PlantRequest {
                sketch: Arc::clone(&stock.kind.sketch),
                step: stock.kind.step,
                individual,
            })
        })
    }

    /// Takes the mesh of an individual, or with none that it cannot be grown; what nobody waits for any more is dropped.
    pub(super) fn give(&mut self, request: &PlantRequest, display: Option<Arc<Display>>) {
        let of = |stock: &&mut Stock| {
            Arc::ptr_eq(&stock.kind.sketch, &request.sketch) && stock.kind.step == request.step
        };
        let at = usize::from(request.individual);
        for stock in self.stocks.iter_mut().filter(of) {
            if stock.wanted.get(at) == Some(&true) {
                stock.seen[at] = display.clone().map(|display| (display, new_revision()));
                stock.is_done[at] = true;
            }
        }
    }

    /// A plant's mesh and its revision, if it has grown.
    pub(super) fn display(&self, plant: &Plant) -> Option<&(Arc<Display>, u64)> {
        let stock = self.stocks.get(place(plant))?;
        stock.seen.get(usize::from(plant.individual))?.as_ref()
    }

    /// Describes the plants that have grown.
    pub(super) fn draw(&self, grove: &Grove, scene: &mut Scene) {
        let look = ModelLook {
            surface: Some(SurfaceLook::Shaded),
            shadow: true,
            ..ModelLook::default()
        };
        let plants = self.order.iter();
        for plant in plants.filter_map(|number| grove.plants.get(*number)) {
            let Some((display, revision)) = self.display(plant) else {
                continue;
            };
            scene.models.push(PlacedModel {
                display: Arc::clone(display),
                revision: *revision,
                world_from_model: plant.stage_from_tree(),
                look,
            });
        }
    }
}

impl World {
    /// The individual that planted trees lack next, if they lack one.
    #[must_use]
    pub fn plant_request(&self) -> Option<PlantRequest> {
        self.tools.planted.request()
    }

    /// Gives the mesh of an individual, or a sentence that says why there is none.
    pub fn set_plant(&mut self, request: &PlantRequest, grown: Result<Arc<Display>, String>) {
        self.tools
            .planted
            .give(request, grown.as_ref().ok().cloned());
        if let Err(text) = grown {
            self.show_message(text);
        }
    }
}

/// Where a plant's mesh is: its stock, and which of its individuals.
fn mesh(plant: &Plant) -> (usize, u8) {
    (place(plant), plant.individual)
}

/// Where a plant's stock is.
fn place(plant: &Plant) -> usize {
    plant.kind.map_or(0, |kind| usize::from(kind) + 1)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use glam::{Affine3A, Vec2, Vec3};

    use super::*;
    use crate::sketch::NodeRef;

    /// As many trees of as many kinds as there may be, planted one kind after the other.
    fn mixed() -> Document {
        let sketch = |height: f32| {
            let drawn = Sketch::default().add_segment(NodeRef::ROOT, Vec3::Y * height);
            Arc::new(drawn.unwrap().0)
        };
        let mut document = Document {
            step: 3,
            ..Document::default()
        };
        let mut grove = Grove::default();
        for (kind, trees) in (0_u8..).zip([43, 43, 43, 43, 42, 42]) {
            document.sketch = sketch(0.1 + 0.1 * f32::from(kind));
            let trees: Vec<Plant> = (0..trees)
                .map(|number| Plant {
                    at: Vec2::new(f32::from(number), f32::from(kind)),
                    yaw_deg: 0.0,
                    size: 1.0,
                    individual: number * 5 % INDIVIDUALS,
                    kind: None,
                })
                .collect();
            grove = grove.with(&trees).unwrap();
            if kind < 5 {
                grove = grove.kept(&document.sketch, document.step);
            }
        }
        document.grove = Arc::new(grove);
        document
    }

    #[test]
    fn trees_of_one_mesh_follow_each_other_so_that_a_wood_has_as_many_draws_as_meshes() {
        let document = mixed();
        let mut planted = Planted::default();
        planted.follow(&document);
        let mut meshes = 0;
        while let Some(request) = planted.request() {
            planted.give(&request, Some(Arc::default()));
            meshes += 1;
        }
        assert_eq!(meshes, 48);
        let mut scene = Scene::default();
        planted.draw(&document.grove, &mut scene);
        let foot = |at: Affine3A| (at.translation.x, at.translation.z);
        let mut stand: Vec<_> = scene
            .models
            .iter()
            .map(|placed| foot(placed.world_from_model))
            .collect();
        stand.sort_by(|a, b| a.partial_cmp(b).unwrap());
        let mut expected: Vec<_> = document
            .grove
            .plants
            .iter()
            .map(|plant| (plant.at.x, plant.at.y))
            .collect();
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert_eq!(stand, expected);
        let runs = scene.models.chunk_by(PlacedModel::is_drawn_as).count();
        assert_eq!(runs, meshes);
    }
}
