//! Productions tried and evaluated for batches of modules, whose expressions are computed in columns.
//!
//! Modules that wait for their production are gathered by symbol, those that wait for their successor's parameters by production.
//! A full batch is worked on at once, what is left over at the end of the chunk. Each module keeps its place to write to, so the
//! order in which batches are worked on shows nowhere: a fault is looked for module by module and kept only where it stands before
//! the others of the chunk.

use super::choice::Worker;
use super::columns::{Columns, LANES};
use super::context::{Base, Indexed};
use super::error::DeriveError;
use super::grammar::{Order, Rule};
use super::names::Symbol;
use super::rewrite::{Round, STAYS};

/// Shorter strings are not worth gathering.
const SHORTEST: usize = 64;

/// A module whose production is looked for.
struct Undecided<'s> {
    at: usize,
    /// Where its parameters begin.
    offset: usize,
    choice: &'s mut u16,
}

/// A module whose successor has its place, without values.
pub(super) struct Unwritten<'s> {
    pub(super) at: usize,
    /// Where its parameters begin.
    pub(super) offset: usize,
    pub(super) own: &'s [f64],
    pub(super) birth: u32,
    /// The successor's.
    pub(super) parameters: &'s mut [f64],
    pub(super) births: &'s mut [u32],
}

/// The fault that stands first in the string.
#[derive(Default)]
struct Faults(Option<(usize, DeriveError)>);

impl Faults {
    fn add(&mut self, at: usize, error: DeriveError) {
        if self.0.as_ref().is_none_or(|(first, _)| at < *first) {
            self.0 = Some((at, error));
        }
    }

    fn result(self) -> Result<(), DeriveError> {
        self.0.map_or(Ok(()), |(_, error)| Err(error))
    }
}

/// What both passes over a chunk need.
struct Batch<'r, 'a> {
    round: &'r Round<'a>,
    work: Worker<'r, 'a, Indexed<'r>>,
    own: &'r [f64],
    columns: Columns,
    faults: Faults,
}

impl<'r, 'a> Batch<'r, 'a> {
    fn new(round: &'r Round<'a>, indexed: &'r Indexed<'r>) -> Option<Self> {
        let (slots, depth) = round.rules.columns?;
        (indexed.string.len() >= SHORTEST).then(|| Self {
            round,
            work: Worker::new(round, indexed),
            own: &indexed.string.parameters,
            columns: Columns::new(slots, depth),
            faults: Faults::default(),
        })
    }

    /// Puts the parameters that a production binds for a module into a row of the columns.
    #[inline]
    fn put(&mut self, rule: &Rule, offset: usize, arity: usize, lane: usize) {
        let own = self.own.get(offset..offset + arity).unwrap_or(&[]);
        let contexts = self.work.bound.get(arity..rule.slots).unwrap_or(&[]);
        for (slot, value) in own.iter().chain(contexts).enumerate() {
            if let Some(place) = self.columns.slot_mut(slot).get_mut(lane) {
                *place = *value;
            }
        }
    }

    /// Whether the contexts of a production match; those are bound then.
    #[inline]
    fn matches(&mut self, rule: &Rule, at: usize, offset: usize) -> bool {
        self.work.matcher.base = Base { at, offset };
        let matcher = &mut self.work.matcher;
        !rule.has_context() || matcher.matches(rule, at, &mut self.work.bound)
    }
}

/// The pass that chooses productions, over one chunk.
pub(super) struct Choosing<'r, 'a, 's> {
    batch: Batch<'r, 'a>,
    /// By the first production of their symbol.
    waiting: Vec<Vec<Undecided<'s>>>,
    /// Where the productions of the batch's modules were found.
    weights: Vec<f64>,
}

impl<'r, 'a, 's> Choosing<'r, 'a, 's> {
    /// Nothing, where modules are better asked one by one.
    pub(super) fn new(round: &'r Round<'a>, indexed: &'r Indexed<'r>) -> Option<Self> {
        let mut waiting = Vec::new();
        waiting.resize_with(round.rules.rules.len(), Vec::new);
        Some(Self {
            batch: Batch::new(round, indexed)?,
            waiting,
            weights: Vec::new(),
        })
    }

    /// Has the production of a module looked for, of which the first is given.
    #[inline]
    pub(super) fn add(
        &mut self,
        first: u16,
        symbol: Symbol,
        at: usize,
        offset: usize,
        choice: &'s mut u16,
    ) -> Result<(), DeriveError> {
        let Some(waiting) = self.waiting.get_mut(usize::from(first)) else {
            return Ok(());
        };
        waiting.push(Undecided { at, offset, choice });
        if waiting.len() >= LANES {
            let mut full = std::mem::take(waiting);
            self.decide(symbol, &mut full)?;
            full.clear();
            if let Some(waiting) = self.waiting.get_mut(usize::from(first)) {
                *waiting = full;
            }
        }
        Ok(())
    }

    /// Decides what is left.
    pub(super) fn finish(mut self) -> Result<(), DeriveError> {
        for (rule, mut left) in std::mem::take(&mut self.waiting).into_iter().enumerate() {
            if let Some(rule) = self.batch.round.rules.rules.get(rule)
                && !left.is_empty()
            {
                self.decide(rule.predecessor, &mut left)?;
            }
        }
        self.batch.faults.result()
    }

    /// Chooses for a batch of modules of one symbol.
    fn decide(&mut self, symbol: Symbol, modules: &mut [Undecided<'s>]) -> Result<(), DeriveError> {
        if self.decided(symbol, modules)?.is_some() {
            return Ok(());
        }
        // Something went wrong: each for itself.
        let batch = &mut self.batch;
        for module in modules {
            let (at, offset) = (module.at, module.offset);
            let arity = batch.round.grammar.arity(symbol);
            let own = batch.own.get(offset..offset + arity).unwrap_or(&[]);
            match batch.work.choose(symbol, at, offset, own) {
                Ok(choice) => *module.choice = choice,
                Err(error) => batch.faults.add(at, error),
            }
        }
        Ok(())
    }
}
