//! Trees on the stage, compared: which ones, what was found, and how they are laid over each other.
//!
//! A model is compared by its centerlines, an L-system's tree and a skeleton as they are, the sketch as far as it has grown. Nothing of it is kept in the
//! project; what changes on the stage is compared anew.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};

use super::World;
use super::document::Document;
use super::lines::Lines;
use super::model::up;
use super::models::Models;
use super::scene::{ModelLook, PlacedModel, Scene, SurfaceLook};
use crate::mesh::display::Display;
use crate::mesh::srgb::light;
use crate::tree::Tree;
use crate::tree::compare::Pair;
use crate::tree::compare::numbers::Number;

/// Trees that a model is compared with at once, at most: their numbers stand beside each other.
pub const OTHERS_MOST: usize = 3;

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The model of this number.
    Model(usize),
    /// The sketch as it has grown.
    Sketch,
}

/// Whose tree it is.
#[derive(Clone, Debug)]
enum Owner {
    Lines(Arc<Lines>),
    Tree(Arc<Tree>),
}

/// A tree that is compared.
#[derive(Clone, Debug)]
pub struct Compared {
    /// What it is of.
    pub subject: Subject,
    /// How many metres its unit has.
    pub metres: f64,
    /// Whether its third axis points up; else its second does.
    pub z_up: bool,
    owner: Owner,
}

impl Compared {
    /// A tree that stands upright, of a unit of so many metres.
    #[must_use]
    pub fn of(subject: Subject, tree: Arc<Tree>, metres: f64) -> Self {
        Self {
            subject,
            metres,
            z_up: false,
            owner: Owner::Tree(tree),
        }
    }

    /// The tree, in its own unit.
    #[must_use]
    pub fn tree(&self) -> &Tree {
        match &self.owner {
            Owner::Lines(lines) => &lines.centerline.tree,
            Owner::Tree(tree) => tree,
        }
    }

    /// Whether it is the same tree of the same thing.
    fn is(&self, other: &Self) -> bool {
        let is_same = match (&self.owner, &other.owner) {
            (Owner::Lines(one), Owner::Lines(other)) => Arc::ptr_eq(one, other),
            (Owner::Tree(one), Owner::Tree(other)) => Arc::ptr_eq(one, other),
            _ => false,
        };
        let of = |one: &Self| (one.subject, one.metres, one.z_up);
        is_same && of(self) == of(other)
    }
}

/// How a quantity is spread in each tree: curves over each other, all of one area.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// Its name in tables.
    pub name: &'static str,
    /// Of each tree: places from left to right, 0 to 1, and how high there, 0 to 1.
    pub curves: Vec<Vec<[f64; 2]>>,
    /// Places along, and what stands there.
    pub marks: Vec<(f64, String)>,
}

/// Trees, compared: all in the first one's unit.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// What each tree is like in numbers.
    pub numbers: Vec<Vec<Number>>,
    /// All others with the first, in their order.
    pub pairs: Vec<Pair>,
    /// Quantities.
    pub plots: Vec<Plot>,
    /// Tubes along each tree from its root, and their numbers for the renderer.
    pub axes: Vec<(Arc<Display>, u64)>,
    /// The trees' colours.
    pub colours: Vec<[u8; 3]>,
}

/// How other trees are laid over the first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlay {
    /// They are not.
    #[default]
    None,
    /// Root to root, each upright, as large as it is.
    Rooted,
    /// Moved, scaled and turned so that they lie upon the first.
    Fitted,
}

/// Trees, and what was found of them or why nothing can be.
type Found = (Vec<Compared>, Result<Arc<Comparison>, String>);

/// What is compared on the stage, and what was found.
#[derive(Debug, Default)]
pub(super) struct Store {
    /// A model, and what it is compared with.
    chosen: Option<(usize, Vec<Subject>)>,
    found: Option<Found>,
    overlay: Overlay,
    /// How many models there were.
    models: usize,
}

impl Store {
    /// Models are told by their numbers: where one comes or goes, what was chosen is no more.
    pub(super) fn keep(&mut self, document: &Document) {
        if self.models != document.models.len() {
            *self = Self {
                models: document.models.len(),
                ..Self::default()
            };
        }
    }
}

impl World {
    /// What a model can be compared with: everything else on the stage that has a tree.
    #[must_use]
    pub fn comparable(&self, at: usize) -> Vec<Subject> {
        let models = (0..self.document().models.len()).map(Subject::Model);
        let all = models.chain([Subject::Sketch]);
        all.filter(|one| *one != Subject::Model(at) && self.compared(*one).is_some())
            .collect()
    }

    /// Whether a model has a tree to be compared.
    #[must_use]
    pub fn has_tree(&self, at: usize) -> bool {
        self.compared(Subject::Model(at)).is_some()
    }

    /// Compares a model with others, [`OTHERS_MOST`] at most; with none not at all.
    pub fn compare(&mut self, at: usize, mut with: Vec<Subject>) {
        with.truncate(OTHERS_MOST);
        let models = self.document().models.len();
        let store = &mut self.tools.models.comparing;
        store.chosen = (!with.is_empty()).then_some((at, with));
        store.found.take_if(|_| store.chosen.is_none());
        store.models = models;
        self.tools.models.changes += 1;
    }

    /// What a model is compared with, as far as that has a tree.
    #[must_use]
    pub fn compared_with(&self, at: usize) -> Vec<Subject> {
        let trees = self.chosen_trees().unwrap_or_default();
        let of = |one: &Compared| one.subject == Subject::Model(at);
        match trees.split_first() {
            Some((first, others)) if of(first) => others.iter().map(|one| one.subject).collect(),
            _ => Vec::new(),
        }
    }

    /// Trees that are to be compared, the first with the others, where nobody has yet; [`Self::give_comparison`] brings what is found.
    #[must_use]
    pub fn wanted_comparison(&self) -> Option<Vec<Compared>> {
        let wanted = self.chosen_trees()?;
        let found = self.tools.models.comparing.found.as_ref();
        let is_found = found.is_some_and(|(known, _)| {
            known.len() == wanted.len() && known.iter().zip(&wanted).all(|(a, b)| a.is(b))
        });
        (!is_found).then_some(wanted)
    }

    /// Whether these are trees of what is to be compared, though they may have changed since.
    #[must_use]
    pub fn wants_comparison(&self, trees: &[Compared]) -> bool {
        self.chosen_trees().is_some_and(|chosen| {
            let subjects = chosen.iter().map(|one| one.subject);
            subjects.eq(trees.iter().map(|one| one.subject))
        })
    }

    /// Gives what was found of trees, or why nothing can be. What nobody wants any more is dropped.
    pub fn give_comparison(
        &mut self,
        trees: Vec<Compared>,
        found: Result<Arc<Comparison>, String>,
    ) {
        if self.wants_comparison(&trees) {
            self.tools.models.comparing.found = Some((trees, found));
            self.tools.models.changes += 1;
        }
    }

    /// What was found of a model and what it is compared with, and whether that is of the trees as they are now.
    #[must_use]
    pub fn comparison(&self, at: usize) -> Option<(Result<&Arc<Comparison>, &str>, bool)> {
        let (trees, found) = self.tools.models.comparing.found.as_ref()?;
        let is_of = trees.first()?.subject == Subject::Model(at) && self.wants_comparison(trees);
        let is_new = self.wanted_comparison().is_none();
        is_of.then(|| (found.as_ref().map_err(String::as_str), is_new))
    }

    /// How other trees are laid over the first.
    #[must_use]
    pub fn overlay(&self) -> Overlay {
        self.tools.models.comparing.overlay
    }

    /// Lays other trees over the first, or not.
    pub fn lay_over(&mut self, how: Overlay) {
        self.tools.models.comparing.overlay = how;
        self.tools.models.changes += 1;
    }

    /// The model that was chosen and what it is compared with, as far as they have trees; none where there are no two.
    fn chosen_trees(&self) -> Option<Vec<Compared>> {
        let (at, with) = self.tools.models.comparing.chosen.as_ref()?;
        let first = self.compared(Subject::Model(*at))?;
        let others = with.iter().filter_map(|one| self.compared(*one));
        let trees: Vec<Compared> = std::iter::once(first).chain(others).collect();
        (trees.len() > 1).then_some(trees)
    }

    /// The model over which others are laid.
    fn laid_over(&self) -> Option<usize> {
        let store = &self.tools.models.comparing;
        let (trees, found) = store.found.as_ref()?;
        let (at, _) = store.chosen.as_ref()?;
        let is_laid = store.overlay != Overlay::None && found.is_ok();
        (is_laid && self.wants_comparison(trees)).then_some(*at)
    }

    /// The document with the model seen through over which others are laid.
    pub(super) fn seen_through<'a>(&self, document: &'a Document) -> Cow<'a, Document> {
        let Some(at) = self.laid_over() else {
            return Cow::Borrowed(document);
        };
        let mut seen = document.clone();
        if let Some(model) = Arc::make_mut(&mut seen.models).get_mut(at) {
            model.surface = model.surface.and(Some(SurfaceLook::XRay));
        }
        Cow::Owned(seen)
    }

    /// Describes trees that are laid over a model.
    pub(super) fn draw_overlay(&self, document: &Document, scene: &mut Scene) {
        if let Some(at) = self.laid_over() {
            self.tools.models.draw_overlay(at, document, scene);
        }
    }

    /// The tree of something, where it has one.
    fn compared(&self, subject: Subject) -> Option<Compared> {
        let Subject::Model(at) = subject else {
            // Step 0 shows the root alone.
            let tree = self.growth.tree().filter(|tree| tree.len() > 1)?;
            return Some(Compared::of(subject, Arc::clone(tree), 1.0));
        };
        let model = self.document().models.get(at)?;
        // While another one grows the one before is still seen.
        let models = &self.tools.models;
        let loaded = models.loaded(model).filter(|_| models.is_read(model));
        let skeleton = loaded.and_then(|loaded| loaded.skeleton.as_ref());
        let owner = match skeleton {
            Some(tree) => Owner::Tree(Arc::clone(tree)),
            None => Owner::Lines(Arc::clone(self.lines(model)?.ok()?)),
        };
        Some(Compared {
            subject,
            metres: model.unit.metres(),
            z_up: model.z_up,
            owner,
        })
    }
}

impl Models {
    fn draw_overlay(&self, at: usize, document: &Document, scene: &mut Scene) {
        let store = &self.comparing;
        let Some((trees, Ok(found))) = &store.found else {
            return;
        };
        let (Some(model), Some(first)) = (document.models.get(at), trees.first()) else {
            return;
        };
        let Some(loaded) = self.loaded(model) else {
            return;
        };
        // From the root of the first tree to the stage.
        let root = match &first.owner {
            Owner::Lines(lines) => loaded.from_origin(lines.centerline.origin),
            Owner::Tree(_) => Vec3::ZERO,
        };
        let root = root + first.tree().position.first().copied().unwrap_or_default();
        let stage = loaded.stage_from_model(model) * Affine3A::from_translation(root);
        for (place, (display, revision)) in found.axes.iter().enumerate() {
            let laid = match place
                .checked_sub(1)
                .and_then(|other| found.pairs.get(other))
            {
                Some(pair) => laid(pair, [first, &trees[place]], store.overlay),
                None => Affine3A::IDENTITY,
            };
            scene.models.push(PlacedModel {
                display: Arc::clone(display),
                revision: *revision,
                world_from_model: stage * laid,
                look: ModelLook {
                    surface: Some(SurfaceLook::Matte),
                    color: light(found.colours[place]),
                    cut: self.plane,
                    lamp: self.lamp,
                    ..ModelLook::default()
                },
            });
        }
    }
}

/// How a tree comes to lie over the first, both counted from their roots, in the first one's unit.
fn laid(pair: &Pair, [first, other]: [&Compared; 2], how: Overlay) -> Affine3A {
    let upright = up(first.z_up).inverse() * up(other.z_up);
    let rooted = Affine3A::from_quat(upright);
    match (how, &pair.space) {
        (Overlay::Fitted, Some(space)) => {
            let fitted = space.fitted;
            let turn: Mat3 = fitted.turn.as_mat3();
            #[expect(clippy::cast_possible_truncation, reason = "as exact as what is drawn")]
            let scale = fitted.scale as f32;
            Affine3A::from_mat3(turn * scale)
        }
        _ => rooted,
    }
}
