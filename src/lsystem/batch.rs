//! Productions tried and evaluated for batches of modules, whose expressions are computed in columns.
//!
//! Modules that wait for their production are gathered by symbol, those that wait for their successor's parameters by production.
//! A full batch is worked on at once, what is left over at the end of the chunk. Each module keeps its place to write to, so the
//! order in which batches are worked on shows nowhere: a fault is looked for module by module and kept only where it stands before
//! the others of the chunk.

use super::choice::Worker;
use super::code::Expression;
use super::column::{Cell, Narrow};
use super::context::{Base, Indexed};
use super::error::DeriveError;
use super::grammar::{Order, Pattern, Rule};
use super::lanes::{LANES, Values};
use super::names::Symbol;
use super::neighbours::Side;
use super::output::Output;
use super::rewrite::{Round, STAYS};

/// Shorter strings are not worth gathering.
const SHORTEST: usize = 64;

/// Modules in the order of the string: where each stands, and where its parameters begin.
#[derive(Default)]
struct Places {
    at: Vec<usize>,
    offset: Vec<usize>,
}

impl Places {
    fn len(&self) -> usize {
        self.at.len()
    }

    fn clear(&mut self) {
        self.at.clear();
        self.offset.clear();
    }

    /// Makes room for a whole batch, where there is none yet.
    #[inline]
    fn make_room(&mut self) {
        if self.at.capacity() == 0 {
            self.at.reserve_exact(LANES);
            self.offset.reserve_exact(LANES);
        }
    }

    #[inline]
    fn push(&mut self, at: usize, offset: usize) {
        self.at.push(at);
        self.offset.push(offset);
    }

    /// Takes over those of the others that are wanted.
    fn choose(&mut self, others: &Self, wanted: &[usize]) {
        let pick = |from: &[usize], into: &mut Vec<usize>| {
            into.clear();
            if wanted.len() == from.len() {
                into.extend_from_slice(from);
            } else {
                into.extend(wanted.iter().filter_map(|lane| from.get(*lane)));
            }
        };
        pick(&others.at, &mut self.at);
        pick(&others.offset, &mut self.offset);
    }

    fn iter(&self) -> impl Iterator<Item = (usize, usize)> {
        self.at.iter().copied().zip(self.offset.iter().copied())
    }
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
struct Batch<'r, 'a, S> {
    round: &'r Round<'a>,
    work: Worker<'r, 'a, Indexed<'r, S>>,
    indexed: &'r Indexed<'r, S>,
    values: Values,
    /// Modules that contexts have reached, and the far edge of their parameters.
    reached: Places,
    faults: Faults,
}

impl<'r, 'a, S: Narrow> Batch<'r, 'a, S> {
    fn new(round: &'r Round<'a>, indexed: &'r Indexed<'r, S>) -> Option<Self> {
        let (slots, depth) = round.rules.columns?;
        (indexed.symbols.len() >= SHORTEST).then(|| Self {
            round,
            work: Worker::new(round, indexed),
            indexed,
            values: Values::new(slots, depth),
            reached: Places::default(),
            faults: Faults::default(),
        })
    }

    /// The parameters of a module.
    fn own(&self, offset: usize, symbol: Symbol) -> &'r [f64] {
        let arity = self.indexed.arity_of(symbol);
        let own = self.indexed.parameters.get(offset..offset + arity);
        own.unwrap_or(&[])
    }

    /// Keeps those of the modules whose contexts match.
    fn fit(&mut self, rule: &Rule, modules: &Places, fitting: &mut Vec<usize>) {
        if rule.looks.into_branches {
            let work = &mut self.work;
            fitting.retain(|lane| {
                let (Some(&at), Some(&offset)) = (modules.at.get(*lane), modules.offset.get(*lane))
                else {
                    return false;
                };
                work.matcher.base = Base { at, offset };
                work.matcher.matches(rule, at, &mut work.bound)
            });
            return;
        }
        let indexed = self.indexed;
        for side in [Side::Left, Side::Right] {
            let pattern = side.of(rule);
            if pattern.is_empty() || indexed.fits_all(pattern, side, &modules.at) {
                continue;
            }
            fitting.retain(|lane| {
                let at = modules.at.get(*lane);
                at.is_some_and(|at| indexed.fits(pattern, side, *at))
            });
        }
    }

    /// Puts what a production binds for modules, whose contexts match, into the columns; from contexts only where these expressions
    /// read it.
    fn bind<'e>(
        &mut self,
        rule: &Rule,
        modules: &Places,
        mut read_by: impl Iterator<Item = &'e Expression>,
    ) {
        let indexed = self.indexed;
        let parameters = indexed.parameters;
        let own = indexed.arity_of(rule.predecessor);
        for slot in 0..own {
            self.values
                .gather(slot, parameters, &modules.offset, slot, own);
        }
        if rule.slots == own || !read_by.any(|expression| expression.reads_from(own)) {
            return;
        }
        if rule.looks.into_branches {
            for (lane, (at, offset)) in modules.iter().enumerate() {
                self.work.matcher.base = Base { at, offset };
                self.work.matcher.matches(rule, at, &mut self.work.bound);
                let bound = self.work.bound.get(..rule.slots).unwrap_or(&[]);
                for (slot, value) in bound.iter().enumerate().skip(own) {
                    self.values.set(slot, lane, *value);
                }
            }
            return;
        }
        for side in [Side::Left, Side::Right] {
            let pattern = side.of(rule);
            let arity = |item: &Pattern| item.symbol().map_or(0, |s| indexed.arity_of(s));
            if pattern.iter().all(|item| arity(item) == 0) {
                continue;
            }
            let edge = if side == Side::Left { 0 } else { own };
            self.reached.clear();
            self.reached.at.extend_from_slice(&modules.at);
            let edges = modules.offset.iter().map(|offset| offset + edge);
            self.reached.offset.extend(edges);
            for item in pattern {
                let Pattern::Module { slot, .. } = item else {
                    continue;
                };
                let arity = arity(item);
                indexed.step(side, arity, &mut self.reached.at, &mut self.reached.offset);
                for number in 0..arity {
                    let slot = usize::from(*slot) + number;
                    self.values
                        .gather(slot, parameters, &self.reached.offset, number, arity);
                }
                if side == Side::Right {
                    // From the start of their parameters to the end.
                    for edge in &mut self.reached.offset {
                        *edge += arity;
                    }
                }
            }
        }
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

/// Modules of one symbol whose production is looked for.
#[derive(Default)]
struct Undecided<'s, S> {
    places: Places,
    choices: Vec<&'s mut S>,
}

/// The pass that chooses productions, over one chunk.
pub(super) struct Choosing<'r, 'a, 's, S> {
    batch: Batch<'r, 'a, S>,
    /// By the first production of their symbol.
    waiting: Vec<Undecided<'s, S>>,
    /// Modules of a batch, by number, without a production yet,
    open: Vec<usize>,
    /// and those of them whose contexts match,
    fitting: Vec<usize>,
    /// with their places.
    places: Places,
    /// The rank of the first production with a weight that matched each.
    ranks: Vec<Option<(usize, bool)>>,
    /// For each module and candidate the weight; NaN: it does not match.
    weights: Vec<f64>,
}

impl<'r, 'a, 's, S: Narrow> Choosing<'r, 'a, 's, S> {
    /// Nothing, where modules are better asked one by one.
    pub(super) fn new(round: &'r Round<'a>, indexed: &'r Indexed<'r, S>) -> Option<Self> {
        let batch = Batch::new(round, indexed)?;
        let mut waiting = Vec::new();
        waiting.resize_with(round.rules.rules.len(), Undecided::default);
        Some(Self {
            batch,
            waiting,
            open: Vec::new(),
            fitting: Vec::new(),
            places: Places::default(),
            ranks: Vec::new(),
            weights: Vec::new(),
        })
    }

    /// Has the productions of modules in a row looked for, of which the first candidate is given, and where the parameters of the first
    /// begin and how many each has.
    #[inline]
    pub(super) fn add(
        &mut self,
        first: u16,
        mut at: usize,
        (mut offset, arity): (usize, usize),
        mut row: &'s mut [S],
    ) -> Result<(), DeriveError> {
        while !row.is_empty() {
            let Some(waiting) = self.waiting.get_mut(usize::from(first)) else {
                return Ok(());
            };
            let count = row.len().min(LANES.saturating_sub(waiting.choices.len()));
            let own;
            (own, row) = row.split_at_mut(count);
            waiting.places.make_room();
            if waiting.choices.capacity() == 0 {
                waiting.choices.reserve_exact(LANES);
            }
            waiting.places.at.extend(at..at + count);
            let offsets = (0..count).map(|number| offset + number * arity);
            waiting.places.offset.extend(offsets);
            waiting.choices.extend(own);
            (at, offset) = (at + count, offset + count * arity);
            if waiting.choices.len() >= LANES {
                let mut full = std::mem::take(waiting);
                self.decide(first, &mut full)?;
                full.places.clear();
                full.choices.clear();
                if let Some(waiting) = self.waiting.get_mut(usize::from(first)) {
                    *waiting = full;
                }
            }
        }
        Ok(())
    }

    /// Decides what is left.
    pub(super) fn finish(mut self) -> Result<(), DeriveError> {
        for (first, mut left) in (0..).zip(std::mem::take(&mut self.waiting)) {
            if !left.choices.is_empty() {
                self.decide(first, &mut left)?;
            }
        }
        self.batch.faults.result()
    }

    /// Chooses for a batch of modules of one symbol.
    fn decide(&mut self, first: u16, modules: &mut Undecided<'s, S>) -> Result<(), DeriveError> {
        let rules = self.batch.round.rules;
        let Some(rule) = rules.rules.get(usize::from(first)) else {
            return Ok(());
        };
        let symbol = rule.predecessor;
        if self.decided(symbol, modules)?.is_some() {
            return Ok(());
        }
        // Something went wrong: each for itself.
        let batch = &mut self.batch;
        for ((at, offset), choice) in modules.places.iter().zip(&mut modules.choices) {
            let own = batch.own(offset, symbol);
            match batch.work.choose(symbol, at, offset, own) {
                Ok(chosen) => **choice = S::of(u32::from(chosen)),
                Err(error) => batch.faults.add(at, error),
            }
        }
        Ok(())
    }

    /// [`Self::decide`] in columns; nothing where a value cannot be computed.
    fn decided(
        &mut self,
        symbol: Symbol,
        modules: &mut Undecided<'s, S>,
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
        self.open.extend(0..modules.choices.len());
        if weighted {
            self.ranks.clear();
            self.ranks.resize(modules.choices.len(), None);
            self.weights.clear();
            let all = modules.choices.len() * candidates.len();
            self.weights.resize(all, f64::NAN);
        }
        for choice in &mut modules.choices {
            **choice = S::of(u32::from(STAYS));
        }
        for (number, candidate) in candidates.iter().enumerate() {
            let Some(rule) = rule(candidate) else {
                continue;
            };
            if self.open.is_empty() {
                break;
            }
            self.fit(rule, weighted, &modules.places)?;
            let which = (number, *candidate, candidates.len());
            if self.hold(rule, which, &mut modules.choices).is_none() {
                return Ok(None);
            }
            let (choices, stays) = (&modules.choices, S::of(u32::from(STAYS)));
            self.open
                .retain(|lane| choices.get(*lane).is_some_and(|choice| **choice == stays));
        }
        Ok(match weighted {
            true => self.draw(candidates, modules),
            false => Some(()),
        })
    }

    /// Finds the open modules whose contexts match a production, with what it binds in columns.
    fn fit(&mut self, rule: &Rule, weighted: bool, modules: &Places) -> Result<(), DeriveError> {
        self.fitting.clear();
        if weighted {
            // Once a production with a weight matched, only its equals are of interest.
            let ranks = &self.ranks;
            let rank = |lane: &usize| ranks.get(*lane).copied().flatten();
            if rule.weight.is_some() && self.batch.round.rules.order == Order::Specific {
                self.open
                    .retain(|lane| rank(lane).is_none_or(|r| r == rule.rank()));
            }
            let asked = |lane: &&usize| rule.weight.is_some() || rank(lane).is_none();
            self.fitting.extend(self.open.iter().filter(asked));
        } else {
            self.fitting.extend_from_slice(&self.open);
        }
        if rule.has_context() {
            self.batch.fit(rule, modules, &mut self.fitting);
        }
        if rule.condition.is_some() || rule.weight.is_some() {
            self.places.choose(modules, &self.fitting);
            let read_by = rule.condition.iter().chain(&rule.weight);
            self.batch.bind(rule, &self.places, read_by);
        }
        self.batch.go_on(rule, self.open.len())
    }

    /// Notes of which fitting modules the condition of a production holds, given its number among so many candidates.
    /// Nothing where a value cannot be computed.
    fn hold(
        &mut self,
        rule: &Rule,
        (number, candidate, candidates): (usize, u16, usize),
        choices: &mut [&'s mut S],
    ) -> Option<()> {
        let values = &mut self.batch.values;
        let lanes = self.fitting.len();
        let mut held = [1.0; LANES];
        if let Some(condition) = &rule.condition {
            let computed = values.compute(condition, lanes);
            if computed
                .iter()
                .fold(false, |any, value| any | value.is_nan())
            {
                return None;
            }
            held.get_mut(..lanes)?.copy_from_slice(computed);
        }
        let held = self.fitting.iter().zip(&held);
        let Some(weight) = &rule.weight else {
            for (&lane, held) in held {
                let choice = choices.get_mut(lane)?;
                let chosen = if *held == 0.0 { STAYS } else { candidate + 1 };
                **choice = S::of(u32::from(chosen));
            }
            return Some(());
        };
        let weights = values.compute(weight, lanes);
        for ((&lane, held), weight) in held.zip(weights) {
            if *held == 0.0 {
                continue;
            }
            if !weight.is_finite() || *weight < 0.0 {
                return None;
            }
            self.ranks.get_mut(lane)?.get_or_insert(rule.rank());
            *self.weights.get_mut(lane * candidates + number)? = *weight;
        }
        Some(())
    }

    /// Draws among the productions with weights that matched; nothing where their weights are wrong.
    fn draw(&mut self, candidates: &[u16], modules: &mut Undecided<'s, S>) -> Option<()> {
        let rows = self.weights.chunks(candidates.len());
        let choices = modules.places.at.iter().zip(&mut modules.choices);
        for (((at, choice), rank), row) in choices.zip(&self.ranks).zip(rows) {
            if rank.is_none() {
                continue;
            }
            let matched = candidates.iter().zip(row).filter(|(_, w)| !w.is_nan());
            let drawn = &mut self.batch.work.drawn;
            drawn.clear();
            drawn.extend(matched.map(|(candidate, weight)| (candidate + 1, *weight)));
            **choice = S::of(u32::from(self.batch.work.draw(*at).ok()?));
        }
        Some(())
    }
}

/// Modules in a row that one production rewrites.
pub(super) struct Source<'s, B> {
    /// The first of them,
    pub(super) at: usize,
    /// and where its parameters begin.
    pub(super) offset: usize,
    /// The parameters of them all.
    pub(super) own: &'s [f64],
    pub(super) births: &'s [B],
}

/// Modules that one production rewrites.
#[derive(Default)]
struct Unwritten<'s, S, B> {
    places: Places,
    /// Those in a row, and where their successors have their places, without parameters yet.
    rows: Vec<(Source<'s, B>, Output<'s, S, B>)>,
}

/// The pass that computes the parameters of successors, over one chunk.
pub(super) struct Filling<'r, 'a, 's, S, B> {
    batch: Batch<'r, 'a, S>,
    /// By production.
    waiting: Vec<Unwritten<'s, S, B>>,
}

impl<'r, 'a, 's, S: Narrow, B: Cell> Filling<'r, 'a, 's, S, B> {
    /// Nothing, where modules are better worked on one by one.
    pub(super) fn new(round: &'r Round<'a>, indexed: &'r Indexed<'r, S>) -> Option<Self> {
        let batch = Batch::new(round, indexed)?;
        let mut waiting = Vec::new();
        waiting.resize_with(round.rules.rules.len(), Unwritten::default);
        Some(Self { batch, waiting })
    }

    /// Has the successors of modules in a row written, which the production with this number makes.
    #[inline]
    pub(super) fn add(
        &mut self,
        number: usize,
        mut source: Source<'s, B>,
        mut target: Output<'s, S, B>,
    ) -> Result<(), DeriveError> {
        let (Some(waiting), Some(rule)) = (
            self.waiting.get_mut(number),
            self.batch.round.rules.rules.get(number),
        ) else {
            return Ok(());
        };
        let arity = self.batch.indexed.arity_of(rule.predecessor);
        loop {
            let room = LANES - waiting.places.len().min(LANES);
            let count = source.births.len().min(room);
            waiting.places.make_room();
            for number in 0..count {
                waiting
                    .places
                    .push(source.at + number, source.offset + number * arity);
            }
            if source.births.len() < room {
                waiting.rows.push((source, target));
                return Ok(());
            }
            let (own, more) = source.own.split_at(count * arity);
            let (births, younger) = source.births.split_at(count);
            let row = Source {
                own,
                births,
                ..source
            };
            let places = target.take(count * rule.successor.len(), count * rule.arguments.len());
            waiting.rows.push((row, places));
            Self::write(&mut self.batch, rule, waiting)?;
            waiting.places.clear();
            waiting.rows.clear();
            if younger.is_empty() {
                return Ok(());
            }
            source = Source {
                at: source.at + count,
                offset: source.offset + count * arity,
                own: more,
                births: younger,
            };
        }
    }

    /// Writes what is left.
    pub(super) fn finish(mut self) -> Result<(), DeriveError> {
        let rules = &self.batch.round.rules.rules;
        for (rule, mut left) in rules.iter().zip(std::mem::take(&mut self.waiting)) {
            if !left.rows.is_empty() {
                Self::write(&mut self.batch, rule, &mut left)?;
            }
        }
        self.batch.faults.result()
    }

    /// Writes the successors of a batch that one production makes.
    fn write(
        batch: &mut Batch<'r, 'a, S>,
        rule: &Rule,
        modules: &mut Unwritten<'s, S, B>,
    ) -> Result<(), DeriveError> {
        batch.bind(rule, &modules.places, rule.arguments.iter());
        batch.go_on(rule, modules.places.len())?;
        let finite = Self::evaluated(batch, rule, modules);
        let arity = batch.indexed.arity_of(rule.predecessor);
        let (length, count) = (rule.successor.len(), rule.arguments.len());
        let mut places = modules.places.iter();
        for (source, target) in &mut modules.rows {
            let written = target.parameters.chunks_exact_mut(count);
            let births = source.births.iter().zip(target.births.chunks_mut(length));
            for (number, (parameters, (birth, births))) in written.zip(births).enumerate() {
                let own = source.own.get(number * arity..(number + 1) * arity);
                let own = own.unwrap_or(&[]);
                if !finite && let Some((at, offset)) = places.next() {
                    // Something went wrong: each for itself.
                    let written = batch.work.evaluate(rule, at, offset, own, parameters);
                    if let Err(error) = written {
                        batch.faults.add(at, error);
                    }
                }
                batch.round.date(rule, own, *birth, parameters, births);
            }
        }
        Ok(())
    }

    /// Computes the parameters in columns; false where one cannot be computed.
    fn evaluated(
        batch: &mut Batch<'r, 'a, S>,
        rule: &Rule,
        modules: &mut Unwritten<'s, S, B>,
    ) -> bool {
        if rule.arguments.iter().any(Expression::draws) {
            let draws = modules.places.at.iter().map(|at| batch.work.key.at(*at));
            batch.values.set_draws(draws);
        }
        let mut finite = true;
        let count = rule.arguments.len();
        for (number, argument) in rule.arguments.iter().enumerate() {
            let mut computed = batch.values.compute(argument, modules.places.len());
            finite &= computed.iter().fold(true, |all, v| all & v.is_finite());
            for (source, target) in &mut modules.rows {
                let (row, after) = computed.split_at(source.births.len().min(computed.len()));
                computed = after;
                let places = target.parameters.get_mut(number..).unwrap_or(&mut []);
                for (place, value) in places.iter_mut().step_by(count).zip(row) {
                    *place = *value;
                }
            }
        }
        finite
    }
}
