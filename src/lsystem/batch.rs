//! Productions tried and evaluated for batches of modules, whose expressions are computed in columns.
//!
//! Modules that wait for their production are gathered by symbol, those that wait for their successor's parameters by production.
//! A full batch is worked on at once, what is left over at the end of the chunk. Each module keeps its place to write to, so the
//! order in which batches are worked on shows nowhere: a fault is looked for module by module and kept only where it stands before
//! the others of the chunk.

use super::choice::Worker;
use super::code::Expression;
use super::context::{Base, Indexed, Modules as _, Side};
use super::error::DeriveError;
use super::grammar::{Order, Pattern, Rule};
use super::lanes::{LANES, Values};
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
    indexed: &'r Indexed<'r>,
    /// Modules that contexts have reached, and where their parameters begin (to the left) or end (to the right).
    reached: Vec<(usize, usize)>,
    values: Values,
    faults: Faults,
}

impl<'r, 'a> Batch<'r, 'a> {
    fn new(round: &'r Round<'a>, indexed: &'r Indexed<'r>) -> Option<Self> {
        let (slots, depth) = round.rules.columns?;
        (indexed.string.len() >= SHORTEST).then(|| Self {
            round,
            work: Worker::new(round, indexed),
            indexed,
            reached: Vec::new(),
            values: Values::new(slots, depth),
            faults: Faults::default(),
        })
    }

    /// The parameters of a module.
    fn own(&self, offset: usize, symbol: Symbol) -> &'r [f64] {
        let arity = self.indexed.string.arity(symbol);
        let own = self.indexed.string.parameters.get(offset..offset + arity);
        own.unwrap_or(&[])
    }

    /// Keeps those of the modules whose contexts match.
    fn fit(
        &mut self,
        rule: &Rule,
        fitting: &mut Vec<usize>,
        place: impl Fn(usize) -> (usize, usize),
    ) {
        if rule.looks.into_branches {
            let work = &mut self.work;
            fitting.retain(|lane| {
                let (at, offset) = place(*lane);
                work.matcher.base = Base { at, offset };
                work.matcher.matches(rule, at, &mut work.bound)
            });
        } else {
            let indexed = self.indexed;
            let fits = |pattern: &[Pattern], at, next: fn(&Indexed<'r>, usize) -> Option<usize>| {
                let mut at = Some(at);
                pattern.iter().all(|wanted| {
                    at = at.and_then(|at| next(indexed, at));
                    let found = at.and_then(|at| indexed.symbol(at));
                    found.is_some() && found == wanted.symbol()
                })
            };
            if !rule.left.is_empty() {
                fitting.retain(|lane| fits(&rule.left, place(*lane).0, Indexed::left));
            }
            if !rule.right.is_empty() {
                fitting.retain(|lane| fits(&rule.right, place(*lane).0, Indexed::right));
            }
        }
    }

    /// Puts what a production binds for modules at places (and where their parameters begin) into the columns.
    fn bind(&mut self, rule: &Rule, places: impl Iterator<Item = (usize, usize)> + Clone) {
        let indexed = self.indexed;
        let parameters = &indexed.string.parameters;
        let arity = |symbol| indexed.string.arity(symbol);
        let own = arity(rule.predecessor);
        for slot in 0..own {
            let starts = places.clone().map(|(_, offset)| offset + slot);
            self.values.gather(slot, parameters, starts);
        }
        if rule.slots == own {
            return;
        }
        if rule.looks.into_branches {
            for (lane, (at, offset)) in places.enumerate() {
                self.work.matcher.base = Base { at, offset };
                self.work.matcher.matches(rule, at, &mut self.work.bound);
                let bound = self.work.bound.get(..rule.slots).unwrap_or(&[]);
                for (slot, value) in bound.iter().enumerate().skip(own) {
                    self.values.set(slot, lane, *value);
                }
            }
            return;
        }
        let mut reached = std::mem::take(&mut self.reached);
        for side in [Side::Left, Side::Right] {
            let pattern = side.of(rule);
            let binds = |item: &Pattern| item.symbol().is_some_and(|symbol| arity(symbol) > 0);
            if !pattern.iter().any(binds) {
                continue;
            }
            reached.clear();
            reached.extend(places.clone().map(|(at, offset)| match side {
                Side::Left => (at, offset),
                Side::Right => (at, offset + own),
            }));
            for item in pattern {
                let Pattern::Module { symbol, slot } = item else {
                    continue;
                };
                let arity = arity(*symbol);
                for place in &mut reached {
                    *place = indexed.beside(*place, side, arity);
                }
                let back = if side == Side::Left { 0 } else { arity };
                for number in 0..arity {
                    let starts = reached
                        .iter()
                        .map(|(_, edge)| (edge + number).saturating_sub(back));
                    self.values
                        .gather(usize::from(*slot) + number, parameters, starts);
                }
            }
        }
        self.reached = reached;
    }

    /// Looks now and then whether to go on; a batch of modules was matched with the contexts of a production.
    fn go_on(&mut self, rule: &Rule, modules: usize) -> Result<(), DeriveError> {
        let visits = modules.saturating_mul(rule.left.len() + rule.right.len());
        let matcher = &mut self.work.matcher;
        if matcher.go_on(u32::try_from(visits).unwrap_or(u32::MAX)) {
            Ok(())
        } else {
            Err(self.round.cancelled())
        }
    }
}

/// The pass that chooses productions, over one chunk.
pub(super) struct Choosing<'r, 'a, 's> {
    batch: Batch<'r, 'a>,
    /// By the first production of their symbol.
    waiting: Vec<Vec<Undecided<'s>>>,
    /// Modules of a batch, by number, without a production yet,
    open: Vec<usize>,
    /// and those of them whose contexts match.
    fitting: Vec<usize>,
    /// The rank of the first production with a weight that matched each.
    ranks: Vec<Option<(usize, bool)>>,
    /// For each module and candidate the weight; NaN: it does not match.
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
            open: Vec::new(),
            fitting: Vec::new(),
            ranks: Vec::new(),
            weights: Vec::new(),
        })
    }

    /// Has the production of a module looked for, of which the first candidate is given.
    #[inline]
    pub(super) fn add(
        &mut self,
        first: u16,
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
            self.decide(first, &mut full)?;
            full.clear();
            if let Some(waiting) = self.waiting.get_mut(usize::from(first)) {
                *waiting = full;
            }
        }
        Ok(())
    }

    /// Decides what is left.
    pub(super) fn finish(mut self) -> Result<(), DeriveError> {
        for (first, mut left) in (0..).zip(std::mem::take(&mut self.waiting)) {
            if !left.is_empty() {
                self.decide(first, &mut left)?;
            }
        }
        self.batch.faults.result()
    }

    /// Chooses for a batch of modules of one symbol.
    fn decide(&mut self, first: u16, modules: &mut [Undecided<'s>]) -> Result<(), DeriveError> {
        let round = self.batch.round;
        let Some(symbol) = round
            .rules
            .rules
            .get(usize::from(first))
            .map(|r| r.predecessor)
        else {
            return Ok(());
        };
        if self.decided(symbol, modules)?.is_some() {
            return Ok(());
        }
        // Something went wrong: each for itself.
        let batch = &mut self.batch;
        for module in modules {
            let (at, offset) = (module.at, module.offset);
            let own = batch.own(offset, symbol);
            match batch.work.choose(symbol, at, offset, own) {
                Ok(choice) => *module.choice = choice,
                Err(error) => batch.faults.add(at, error),
            }
        }
        Ok(())
    }

    /// [`Self::decide`] in columns; nothing where a value cannot be computed.
    fn decided(
        &mut self,
        symbol: Symbol,
        modules: &mut [Undecided<'s>],
    ) -> Result<Option<()>, DeriveError> {
        let rules = self.batch.round.rules;
        let candidates = rules.by_symbol.get(usize::from(symbol));
        let candidates = candidates.map_or(&[][..], Vec::as_slice);
        let rule = |number: &u16| rules.rules.get(usize::from(*number));
        let weighted = candidates
            .iter()
            .filter_map(rule)
            .any(|r| r.weight.is_some());
        self.open.clear();
        self.open.extend(0..modules.len());
        self.ranks.clear();
        self.ranks.resize(modules.len(), None);
        self.weights.clear();
        if weighted {
            self.weights
                .resize(modules.len() * candidates.len(), f64::NAN);
        }
        for module in modules.iter_mut() {
            *module.choice = STAYS;
        }
        for (number, candidate) in candidates.iter().enumerate() {
            let Some(rule) = rule(candidate) else {
                continue;
            };
            if self.open.is_empty() {
                break;
            }
            self.fit(rule, modules)?;
            if self
                .hold(rule, (number, *candidate), candidates.len(), modules)
                .is_none()
            {
                return Ok(None);
            }
            let undecided = |lane: &usize| modules.get(*lane).is_some_and(|m| *m.choice == STAYS);
            self.open.retain(undecided);
        }
        if weighted {
            self.draw(candidates, modules)
        } else {
            Ok(Some(()))
        }
    }

    /// Notes of which fitting modules the condition of a production holds; nothing where a value cannot be computed.
    fn hold(
        &mut self,
        rule: &Rule,
        (number, candidate): (usize, u16),
        candidates: usize,
        modules: &mut [Undecided<'s>],
    ) -> Option<()> {
        let values = &mut self.batch.values;
        let lanes = self.fitting.len();
        let mut held = [1.0; LANES];
        if let Some(condition) = &rule.condition {
            let computed = values.compute(condition, lanes);
            if computed.iter().any(|value| value.is_nan()) {
                return None;
            }
            held.get_mut(..lanes)?.copy_from_slice(computed);
        }
        let weights = rule.weight.as_ref().map(|w| values.compute(w, lanes));
        for (place, &lane) in self.fitting.iter().enumerate() {
            if held.get(place) == Some(&0.0) {
                continue;
            }
            let Some(weights) = weights else {
                *modules.get_mut(lane)?.choice = candidate + 1;
                continue;
            };
            let weight = *weights.get(place)?;
            if !weight.is_finite() || weight < 0.0 {
                return None;
            }
            self.ranks.get_mut(lane)?.get_or_insert(rule.rank());
            *self.weights.get_mut(lane * candidates + number)? = weight;
        }
        Some(())
    }

    /// Finds the open modules whose contexts match a production, with what it binds in columns.
    fn fit(&mut self, rule: &Rule, modules: &[Undecided<'s>]) -> Result<(), DeriveError> {
        let rules = self.batch.round.rules;
        let ranks = &self.ranks;
        let rank = |lane: &usize| ranks.get(*lane).copied().flatten();
        // Once a production with a weight matched, only its equals are of interest.
        if rule.weight.is_some() && rules.order == Order::Specific {
            self.open
                .retain(|lane| rank(lane).is_none_or(|r| r == rule.rank()));
        }
        let asked = |lane: &&usize| rule.weight.is_some() || rank(lane).is_none();
        self.fitting.clear();
        self.fitting.extend(self.open.iter().filter(asked));
        let place = |lane: usize| modules.get(lane).map_or((0, 0), |m| (m.at, m.offset));
        if rule.has_context() {
            self.batch.fit(rule, &mut self.fitting, place);
        }
        if rule.condition.is_some() || rule.weight.is_some() {
            let places = self.fitting.iter().map(|lane| place(*lane));
            self.batch.bind(rule, places);
        }
        self.batch.go_on(rule, self.open.len())
    }

    /// Draws among the productions with weights that matched.
    fn draw(
        &mut self,
        candidates: &[u16],
        modules: &mut [Undecided<'s>],
    ) -> Result<Option<()>, DeriveError> {
        let rows = self.weights.chunks(candidates.len());
        for ((module, rank), row) in modules.iter_mut().zip(&self.ranks).zip(rows) {
            if rank.is_none() {
                continue;
            }
            let weights = candidates
                .iter()
                .zip(row)
                .filter(|(_, weight)| !weight.is_nan());
            let drawn = &mut self.batch.work.drawn;
            drawn.clear();
            drawn.extend(weights.map(|(candidate, weight)| (candidate + 1, *weight)));
            match self.batch.work.draw(module.at) {
                Ok(choice) => *module.choice = choice,
                Err(_) => return Ok(None),
            }
        }
        Ok(Some(()))
    }
}

/// The pass that computes the parameters of successors, over one chunk.
pub(super) struct Filling<'r, 'a, 's> {
    batch: Batch<'r, 'a>,
    /// By production.
    waiting: Vec<Vec<Unwritten<'s>>>,
}

impl<'r, 'a, 's> Filling<'r, 'a, 's> {
    /// Nothing, where modules are better worked on one by one.
    pub(super) fn new(round: &'r Round<'a>, indexed: &'r Indexed<'r>) -> Option<Self> {
        let mut waiting = Vec::new();
        waiting.resize_with(round.rules.rules.len(), Vec::new);
        Some(Self {
            batch: Batch::new(round, indexed)?,
            waiting,
        })
    }

    /// Has the successor of a module written, which the production with this number makes.
    #[inline]
    pub(super) fn add(&mut self, rule: usize, module: Unwritten<'s>) -> Result<(), DeriveError> {
        let Some(waiting) = self.waiting.get_mut(rule) else {
            return Ok(());
        };
        waiting.push(module);
        if waiting.len() >= LANES {
            let mut full = std::mem::take(waiting);
            self.write(rule, &mut full)?;
            full.clear();
            if let Some(waiting) = self.waiting.get_mut(rule) {
                *waiting = full;
            }
        }
        Ok(())
    }

    /// Writes what is left.
    pub(super) fn finish(mut self) -> Result<(), DeriveError> {
        for (rule, mut left) in std::mem::take(&mut self.waiting).into_iter().enumerate() {
            if !left.is_empty() {
                self.write(rule, &mut left)?;
            }
        }
        self.batch.faults.result()
    }

    /// Writes the successors of a batch that one production makes.
    fn write(&mut self, rule: usize, modules: &mut [Unwritten<'s>]) -> Result<(), DeriveError> {
        let batch = &mut self.batch;
        let Some(rule) = batch.round.rules.rules.get(rule) else {
            return Ok(());
        };
        // Contexts match, as they did before.
        batch.bind(
            rule,
            modules.iter().map(|module| (module.at, module.offset)),
        );
        batch.go_on(rule, modules.len())?;
        if !Self::evaluated(batch, rule, modules) {
            // Something went wrong: each for itself.
            for module in modules.iter_mut() {
                let Unwritten {
                    at, offset, own, ..
                } = *module;
                let written = batch
                    .work
                    .evaluate(rule, at, offset, own, module.parameters);
                if let Err(error) = written {
                    batch.faults.add(at, error);
                }
            }
        }
        for module in modules {
            let Unwritten { own, birth, .. } = *module;
            batch
                .round
                .date(rule, own, birth, module.parameters, module.births);
        }
        Ok(())
    }

    /// Computes the parameters in columns; false where one cannot be computed.
    fn evaluated(batch: &mut Batch<'r, 'a>, rule: &Rule, modules: &mut [Unwritten<'s>]) -> bool {
        if rule.arguments.iter().any(Expression::draws) {
            let draws = modules.iter().map(|module| batch.work.key.at(module.at));
            batch.values.set_draws(draws);
        }
        let mut finite = true;
        for (number, argument) in rule.arguments.iter().enumerate() {
            let computed = batch.values.compute(argument, modules.len());
            finite &= computed.iter().fold(true, |all, v| all & v.is_finite());
            for (module, value) in modules.iter_mut().zip(computed) {
                if let Some(place) = module.parameters.get_mut(number) {
                    *place = *value;
                }
            }
        }
        finite
    }
}
