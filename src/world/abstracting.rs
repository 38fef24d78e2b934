//! Abstractions of models on the stage: for which one is looked for, what was found so far, and the trees that stand beside their models.
//!
//! Nothing of it is kept in the project but the trees that a person stands there ([`Likeness`]).

use std::sync::Arc;

use super::World;
use super::branches::LineKey;
use super::document::{Document, Edit, EditError};
use super::likeness::{self, Likeness};
use super::lines::Lines;
use super::model::Model;
use crate::abstraction::{Candidate, Table, presets};
use crate::tree::Tree;

/// Trees like a model, as far as they were looked for.
#[derive(Clone, Debug)]
pub struct Abstraction {
    /// What the model's centerlines have.
    pub target: Table,
    /// The nearest first, each with its tree.
    pub ranked: Vec<(Candidate, Arc<Tree>)>,
    /// What the source's own rules make; none where that grows without bounds, or nobody knows yet.
    pub by_rules: Option<Candidate>,
    /// How many trees were drawn, of how many.
    pub drawn: [usize; 2],
}

/// The search for a model's abstraction.
#[derive(Clone, Debug)]
pub struct Search {
    /// One seed gives one result.
    pub seed: u64,
    /// Whether it goes on.
    pub goes_on: bool,
    /// What was found so far, or why nothing can be.
    pub found: Option<Result<Arc<Abstraction>, String>>,
}

/// Iterations a second of a tree that grows by itself.
const SPEED: f64 = 2.5;
/// Where it takes longer until that is seen, it grows by no more than in so many seconds.
const LONGEST: f64 = 0.25;

/// All searches that are known.
#[derive(Debug, Default)]
pub(super) struct Store {
    searches: Vec<(LineKey, Search)>,
    /// The model that grows by itself, and the seconds since it was seen to have grown.
    grows: Option<(usize, f64)>,
}

impl Store {
    /// Forgets those of models that are gone or have other centerlines.
    pub(super) fn keep(&mut self, document: &Document) {
        self.searches.retain(|(key, _)| {
            let mut models = document.models.iter();
            models.any(|model| model.lines.is_some() && key.is_of(model))
        });
    }

    fn get(&self, model: &Model) -> Option<&Search> {
        let (_, search) = self.searches.iter().find(|(key, _)| key.is_of(model))?;
        Some(search)
    }

    fn get_mut(&mut self, model: &Model) -> Option<&mut Search> {
        let (_, search) = self.searches.iter_mut().find(|(key, _)| key.is_of(model))?;
        Some(search)
    }
}

impl World {
    /// Looks for trees like a model; those that were found with another seed are forgotten.
    pub fn abstract_model(&mut self, at: usize, seed: u64) {
        let Some(model) = self.history.committed().models.get(at) else {
            return;
        };
        let store = &mut self.tools.models.abstractions;
        store.searches.retain(|(key, _)| !key.is_of(model));
        let search = Search {
            seed,
            goes_on: true,
            found: None,
        };
        store.searches.push((LineKey::of(model), search));
        self.tools.models.changes += 1;
    }

    /// Stops looking; what was found stays.
    pub fn stop_abstracting(&mut self, model: &Model) {
        if let Some(search) = self.tools.models.abstractions.get_mut(model) {
            search.goes_on = false;
            self.tools.models.changes += 1;
        }
    }

    /// A model for which trees like it are looked for, its centerlines, and the seed; [`Self::give_abstraction`] brings them.
    #[must_use]
    pub fn wanted_abstraction(&self) -> Option<(&Model, Arc<Lines>, u64)> {
        self.document().models.iter().find_map(|model| {
            let search = self.abstraction(model).filter(|search| search.goes_on)?;
            let lines = self.lines(model)?.ok()?;
            Some((model, Arc::clone(lines), search.seed))
        })
    }

    /// Whether trees like a model are still looked for with a seed.
    #[must_use]
    pub fn wants_abstraction(&self, model: &Model, seed: u64) -> bool {
        let search = self.tools.models.abstractions.get(model);
        search.is_some_and(|search| search.goes_on && search.seed == seed)
    }

    /// Gives what was found so far, or why nothing can be; with it the search ends where it is `done`. What nobody wants any more is dropped.
    pub fn give_abstraction(
        &mut self,
        model: &Model,
        seed: u64,
        found: Result<Arc<Abstraction>, String>,
        done: bool,
    ) {
        if !self.wants_abstraction(model, seed) {
            return;
        }
        if let Some(search) = self.tools.models.abstractions.get_mut(model) {
            search.found = Some(found);
            search.goes_on = !done;
            self.tools.models.changes += 1;
        }
    }

    /// The search for a model's abstraction, if there was one.
    #[must_use]
    pub fn abstraction(&self, model: &Model) -> Option<&Search> {
        self.tools.models.abstractions.get(model)
    }

    /// Stands a tree that was found beside its model: the one of this place in the list.
    ///
    /// # Errors
    /// Where the project has no room for it.
    pub fn stand_beside(&mut self, at: usize, place: usize) -> Result<(), EditError> {
        let Some(model) = self.history.committed().models.get(at) else {
            return Ok(());
        };
        let found = self.abstraction(model).and_then(|one| one.found.as_ref());
        let one = found.and_then(|found| found.as_ref().ok()?.ranked.get(place));
        let (Some((candidate, tree)), Some(loaded)) = (one, self.loaded_model(model)) else {
            return Ok(());
        };
        let sides = [loaded.side(), likeness::side(tree)];
        let params = candidate.params.clone();
        match likeness::beside(self.history.committed(), at, params, sides) {
            Some(edit) => self.apply(edit),
            None => Ok(()),
        }
    }

    /// Stands a tree of a preset's numbers on the stage.
    ///
    /// # Errors
    /// Where the project has no room for it.
    pub fn plant(&mut self, preset: usize) -> Result<(), EditError> {
        let presets = presets();
        let Some(preset) = presets.get(preset) else {
            return Ok(());
        };
        let document = self.history.committed();
        let mut models = document.models.to_vec();
        let mut model = Model::new(preset.name.to_owned(), preset.unit, false, models.len());
        model.likeness = Some(Likeness::whole(preset.params.clone()));
        models.push(model);
        let edit = Edit::Arrange {
            models,
            platform: document.platform,
            linked: document.linked,
        };
        self.apply(edit)
    }

    /// Whether a tree grows by itself.
    #[must_use]
    pub fn grows_on(&self, at: usize) -> bool {
        matches!(self.tools.models.abstractions.grows, Some((model, _)) if model == at)
    }

    /// Lets a tree grow by itself from where it is, or from the beginning where it is whole; or not.
    pub fn grow_on(&mut self, at: usize, on: bool) {
        self.settle();
        self.tools.models.abstractions.grows = on.then_some((at, 0.0));
        self.tools.models.changes += 1;
        let begins = on.then(|| self.with_moment(at, |_, moment| Some(moment.unwrap_or(0.0))));
        if let Some(edit) = begins.flatten() {
            // What it may not be it does not become.
            let _ = self.try_out(edit);
        }
    }

    /// Goes on with the tree that grows by itself after so many seconds, once it is seen as it was.
    pub fn grow_likeness(&mut self, seconds: f64) {
        let Some((at, since)) = self.tools.models.abstractions.grows else {
            return;
        };
        let since = (since + seconds).clamp(0.0, LONGEST);
        let is_seen = self.wanted_model().is_none();
        let rest = if is_seen { 0.0 } else { since };
        self.tools.models.abstractions.grows = Some((at, rest));
        if !is_seen {
            return;
        }
        let edit = self.with_moment(at, |likeness, moment| {
            let next = moment? + SPEED * since;
            (next < f64::from(likeness.last())).then_some(next)
        });
        let goes_on = edit.is_some_and(|edit| {
            let is_whole = |model: &Model| model.likeness.as_ref()?.moment;
            self.try_out(edit).is_ok() && self.shown().models.get(at).and_then(is_whole).is_some()
        });
        if !goes_on {
            self.grow_on(at, false);
        }
    }

    /// The edit that lets a tree have grown otherwise.
    fn with_moment(
        &self,
        at: usize,
        to: impl FnOnce(&Likeness, Option<f64>) -> Option<f64>,
    ) -> Option<Edit> {
        let document = self.shown();
        let mut models = document.models.to_vec();
        let likeness = models.get_mut(at)?.likeness.as_mut()?;
        likeness.moment = to(likeness, likeness.moment);
        Some(Edit::Arrange {
            models,
            platform: document.platform,
            linked: document.linked,
        })
    }
}
