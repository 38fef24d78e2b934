//! One round of parallel rewriting.
//!
//! A round has two passes over chunks of the string. The count pass chooses a production for each module and
//! adds up how large the chunk's successor is; prefix sums say where each chunk writes; the fill pass writes symbols,
//! births and parameters into slices of their own. Draws depend on (seed, step, round, position) alone and chunks are fixed in
//! size, so the result is the same on any number of threads, and so is the error: the first in the string.

use std::borrow::Cow;
use std::slice::from_mut;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::batch::Choosing;
use super::chances::Chances;
use super::choice::{Worker, near};
use super::choices::{Choices, pack, unpack};
use super::column::{Cell, Column, Narrow, bytes_up_to};
use super::context::{ContextIndex, Indexed, Window, sums_before};
use super::derive::Limits;
use super::error::{DeriveError, DeriveProblem, Limit, ValueProblem};
use super::grammar::{Grammar, NearTable, Plan, Rule, RuleSet};
use super::names::Symbol;
use super::output::{Output, Spare};
use super::random::PassKey;
use super::string::{ModuleString, parameters_of, string_bytes};

/// Modules of a chunk.
const CHUNK: usize = 8192;
/// Chunks that a thread takes at most at once: with more, one that is slower keeps the others waiting in the end.
pub(super) const TOGETHER: usize = 2;
/// Strings shorter than this are rewritten on the calling thread.
const PARALLEL_FROM: usize = 2 * CHUNK;
/// Modules that are looked at together, to see whether they are all alike.
const RUN: usize = 16;
/// Choice of a module that stays as it is; productions are numbered from 1.
pub(super) const STAYS: u16 = 0;
/// Whether work on so many modules is worth handing to other threads: waking them takes as long as thousands of modules.
pub(super) fn pays_in_parallel(modules: usize) -> bool {
    modules >= PARALLEL_FROM && rayon::current_num_threads() > 1
}

/// How old the modules of a successor are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Births {
    /// New modules are born in the step.
    Step,
    /// New modules are as old as the module they stand for.
    Inherit,
}

/// One round of rewriting.
#[derive(Clone)]
pub(super) struct Round<'a> {
    pub(super) grammar: &'a Grammar,
    pub(super) rules: &'a RuleSet,
    /// For messages and births.
    pub(super) step: u32,
    /// What the draws depend on besides the seed: the step, or another number where there is none.
    pub(super) stream: u32,
    /// 0 for the productions, else the round of a block.
    pub(super) number: u32,
    pub(super) births: Births,
    pub(super) limits: &'a Limits,
    pub(super) cancel: &'a AtomicBool,
}

/// Sizes of what a chunk becomes.
#[derive(Clone, Copy, Default)]
struct Size {
    modules: u64,
    parameters: u64,
    rewritten: usize,
}

/// A stretch of the string to read and the stretch of the next to write.
pub(super) struct Task<'s, S, B> {
    pub(super) from: usize,
    pub(super) parameters_from: usize,
    pub(super) choices: &'s [S],
    pub(super) out: Output<'s, S, B>,
}

impl<'a> Round<'a> {
    pub(super) fn cancelled(&self) -> DeriveError {
        DeriveProblem::Cancelled { step: self.step }.into()
    }

    pub(super) fn failed(
        &self,
        rule: &Rule,
        position: usize,
        problem: ValueProblem,
    ) -> DeriveError {
        DeriveProblem::Value {
            step: self.step,
            production: rule.text.clone(),
            location: rule.location.clone(),
            position: position as u64,
            problem,
        }
        .into()
    }

    /// Runs `work` over the items, in parallel where `parallel`, and returns the first error in their order.
    fn each<T: Send, R: Send>(
        parallel: bool,
        items: Vec<T>,
        work: impl Fn(T) -> Result<R, DeriveError> + Sync + Send,
    ) -> Result<Vec<R>, DeriveError> {
        if parallel {
            let items = items.into_par_iter().with_max_len(TOGETHER);
            let results: Vec<Result<R, DeriveError>> = items.map(work).collect();
            results.into_iter().collect()
        } else {
            items.into_iter().map(work).collect()
        }
    }

    /// The string after this round; `None` where no production applied.
    pub(super) fn apply(
        &self,
        string: &ModuleString,
        spare: &mut Spare,
    ) -> Result<Option<ModuleString>, DeriveError> {
        let newest = if self.births == Births::Step {
            self.step
        } else {
            0
        };
        let births = match string.births.holds(newest) {
            true => Cow::Borrowed(&string.births),
            false => Cow::Owned(string.births.widened(newest)),
        };
        let births: &Column = &births;
        match (&string.symbols, births) {
            (Column::Byte(s), Column::Byte(b)) => self.apply_to(string, s, b, spare),
            (Column::Byte(s), Column::Half(b)) => self.apply_to(string, s, b, spare),
            (Column::Byte(s), Column::Word(b)) => self.apply_to(string, s, b, spare),
            (Column::Half(s), Column::Byte(b)) => self.apply_to(string, s, b, spare),
            (Column::Half(s), Column::Half(b)) => self.apply_to(string, s, b, spare),
            (Column::Half(s), Column::Word(b)) => self.apply_to(string, s, b, spare),
            (Column::Word(_), _) => Ok(None), // no symbol is as large
        }
    }

    /// [`Self::apply`] for one width of symbols, which is that of the choices, and one of births.
    fn apply_to<S: Narrow, B: Cell>(
        &self,
        string: &ModuleString,
        symbols: &[S],
        births: &[B],
        spare: &mut Spare,
    ) -> Result<Option<ModuleString>, DeriveError> {
        let parallel = pays_in_parallel(string.len());
        let index = if self.rules.has_context {
            let chunks = (CHUNK, parallel);
            ContextIndex::new(self.grammar, self.rules, symbols, chunks, self.cancel)
                .ok_or_else(|| self.cancelled())?
        } else {
            ContextIndex::default()
        };
        // What contexts see beside the modules of a chunk, where it is asked for.
        let indexed = |chunk: usize, asked: bool| Indexed {
            symbols,
            parameters: &string.parameters,
            arity: &string.arity,
            index: &index,
            window: match asked {
                true => Window::new(self.grammar, &index, symbols, (chunk, chunk * CHUNK)),
                false => Window::default(),
            },
        };
        let parameter_starts = parameter_starts(string, symbols, parallel);
        let start_of = |chunk: usize| parameter_starts.get(chunk).copied().unwrap_or(0);

        let choices = std::mem::take(&mut spare.choices);
        let productions = self.rules.rules.len();
        let choices = choices.renewed(symbols.len(), productions);
        let mut choices = choices.ok_or_else(|| DeriveProblem::Memory {
            step: self.step,
            bytes: self.choices_bytes(symbols.len() as u64),
        })?;
        let bits = choices.bits();
        let chunks = symbols.chunks(CHUNK).zip(choices.chunks_mut(CHUNK));
        let sizes = Self::each(parallel, chunks.enumerate().collect(), |(chunk, places)| {
            let (own, packed) = places;
            let mut choices = [S::default(); CHUNK];
            let choices = choices.get_mut(..own.len()).unwrap_or(&mut []);
            if self.cancel.load(Ordering::Relaxed) {
                return Err(self.cancelled());
            }
            let from = chunk * CHUNK;
            let size = match &self.rules.table {
                Some(table) if string.parameters.is_empty() => {
                    self.count_near(table, &index, symbols, (chunk, from), choices)
                }
                _ => self.count(&indexed(chunk, true), from, start_of(chunk), choices)?,
            };
            pack(bits, choices, packed);
            Ok(size)
        })?;
        spare.rewritten = sizes.iter().map(|s| s.rewritten).sum();
        spare.choices = choices;
        if spare.rewritten == 0 {
            return Ok(None);
        }
        let choices = &spare.choices;
        let modules = sizes
            .iter()
            .fold(0_u64, |sum, s| sum.saturating_add(s.modules));
        let parameters = sizes
            .iter()
            .fold(0_u64, |sum, s| sum.saturating_add(s.parameters));
        self.check_size(string, index.bytes(), modules, parameters)?;

        let bytes = string_bytes(
            (size_of::<S>() + size_of::<B>()) as u64,
            modules,
            parameters,
        );
        let memory = || {
            DeriveError::from(DeriveProblem::Memory {
                step: self.step,
                bytes,
            })
        };
        let (Ok(modules), Ok(parameters)) = (usize::try_from(modules), usize::try_from(parameters))
        else {
            return Err(memory());
        };
        let old = std::mem::take(&mut spare.string);
        let next_symbols = S::into_cells(old.symbols).renewed(modules);
        let mut next_symbols = next_symbols.ok_or_else(memory)?;
        let next_births = B::into_cells(old.births).renewed(modules);
        let mut next_births = next_births.ok_or_else(memory)?;
        let mut next_parameters = old.parameters.renewed(parameters).ok_or_else(memory)?;
        let mut tasks = Vec::with_capacity(sizes.len());
        {
            let mut out = Output {
                symbols: &mut next_symbols,
                births: &mut next_births,
                parameters: &mut next_parameters,
            };
            for (chunk, (size, packed)) in sizes.iter().zip(choices.chunks(CHUNK)).enumerate() {
                // The sums above fit usize, so their parts do.
                let fitting = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
                let places = out.take(fitting(size.modules), fitting(size.parameters));
                tasks.push((chunk, packed, places));
            }
        }
        let templates = self.templates(string);
        Self::each(parallel || pays_in_parallel(modules), tasks, |task| {
            let (chunk, packed, out) = task;
            let from = chunk * CHUNK;
            let mut choices = [S::default(); CHUNK];
            let length = CHUNK.min(symbols.len() - from.min(symbols.len()));
            let choices = choices.get_mut(..length).unwrap_or(&mut []);
            unpack(bits, packed, choices);
            let task = Task {
                from,
                parameters_from: start_of(chunk),
                choices,
                out,
            };
            self.fill(
                &indexed(chunk, self.rules.looks.binds),
                births,
                templates.as_deref(),
                task,
            )
        })?;
        Ok(Some(ModuleString {
            symbols: S::column(next_symbols),
            births: B::column(next_births),
            parameters: next_parameters,
            arity: Arc::clone(&string.arity),
        }))
    }

    /// The first production that would apply.
    pub(super) fn first_applied(
        &self,
        string: &ModuleString,
    ) -> Result<Option<&'a Rule>, DeriveError> {
        match &string.symbols {
            Column::Byte(symbols) => self.first_applied_to(string, symbols),
            Column::Half(symbols) => self.first_applied_to(string, symbols),
            Column::Word(_) => Ok(None),
        }
    }

    fn first_applied_to<S: Narrow>(
        &self,
        string: &ModuleString,
        symbols: &[S],
    ) -> Result<Option<&'a Rule>, DeriveError> {
        let indexed = Indexed {
            symbols,
            parameters: &string.parameters,
            arity: &string.arity,
            index: &ContextIndex::default(), // decomposition has no contexts
            window: Window::default(),
        };
        let mut parameters_from = 0;
        for (number, chunk) in symbols.chunks(CHUNK).enumerate() {
            let mut choices = [S::default(); CHUNK];
            let choices = choices.get_mut(..chunk.len()).unwrap_or(&mut []);
            self.count(&indexed, number * CHUNK, parameters_from, choices)?;
            if let Some(rule) = choices.iter().find_map(|c| self.rule((*c).into())) {
                return Ok(Some(rule));
            }
            parameters_from += parameters_of(indexed.arity, chunk);
        }
        Ok(None)
    }

    fn check_size(
        &self,
        string: &ModuleString,
        index: u64,
        modules: u64,
        parameters: u64,
    ) -> Result<(), DeriveError> {
        let symbol = string.symbols.cell_bytes();
        let choices = self.choices_bytes(string.len() as u64);
        let birth = bytes_up_to(self.step).max(string.births.cell_bytes());
        let own = string_bytes(symbol + birth, modules, parameters);
        let all = own
            .saturating_add(string.bytes())
            .saturating_add(index + choices);
        let most = self.limits.modules.min(u64::from(u32::MAX));
        let (limit, bytes) = if modules > most {
            // However the string is derived, this is said in the same words.
            (Limit::Modules(most), own)
        } else if all > self.limits.bytes {
            (Limit::Bytes(self.limits.bytes), all)
        } else {
            return Ok(());
        };
        Err(DeriveProblem::Limit {
            step: self.step,
            modules,
            bytes,
            limit,
        }
        .into())
    }

    /// Bytes of the choices for so many modules.
    fn choices_bytes(&self, modules: u64) -> u64 {
        modules.saturating_mul(Choices::bits_among(self.rules.rules.len()) as u64) / 8
    }

    pub(super) fn rule(&self, choice: u16) -> Option<&'a Rule> {
        self.rules.rules.get(usize::from(choice).checked_sub(1)?)
    }

    /// Chooses a production for each module of a chunk.
    fn count<S: Narrow>(
        &self,
        indexed: &Indexed<'_, S>,
        from: usize,
        parameters_from: usize,
        choices: &mut [S],
    ) -> Result<Size, DeriveError> {
        let mut work = Worker::new(self, indexed);
        if let Some(chances) = &self.rules.chances {
            return Ok(self.count_drawn(chances, work.choice_key, indexed, from, choices));
        }
        let mut choosing = Choosing::new(self, indexed);
        let (mut at, mut offset) = (from, parameters_from);
        let end = from + choices.len();
        let symbols = indexed.symbols.get(from..end).unwrap_or(&[]);
        let plain = indexed.index.seams.is_none() && !self.rules.looks.into_branches;
        // Neighbours of one symbol are worked on together.
        let (mut rest, mut places) = (symbols, &mut *choices);
        while let Some(&cell) = rest.first() {
            let following = indexed.symbols.get(at..).unwrap_or(&[]);
            let resting = self.rules.rests.resting(following, rest.len(), plain);
            if resting > 0 {
                let (row, own);
                (row, places) = places.split_at_mut(resting);
                (own, rest) = rest.split_at(resting);
                row.fill(S::of(u32::from(STAYS)));
                (at, offset) = (at + resting, offset + parameters_of(indexed.arity, own));
                continue;
            }
            let alike = rest.iter().take_while(|other| **other == cell).count();
            let row;
            (row, places) = places.split_at_mut(alike);
            rest = rest.get(alike..).unwrap_or(&[]);
            let (symbol, arity): (Symbol, usize) = (cell.into(), indexed.arity(cell));
            let numbered = (at..).zip(row.iter_mut());
            match self.rules.plan(symbol) {
                Plan::Stay => row.fill(S::of(u32::from(STAYS))),
                Plan::Always(number) => row.fill(S::of(u32::from(number + 1))),
                Plan::Near => numbered.for_each(|(at, choice)| {
                    *choice = S::of(u32::from(near(indexed, self.rules.near(symbol), at)));
                }),
                Plan::Draw => numbered.for_each(|(at, choice)| {
                    *choice = S::of(u32::from(work.pick(self.rules.weighted(symbol), at)));
                }),
                Plan::Choose(first) => match &mut choosing {
                    Some(choosing) => choosing.add(first, at, (offset, arity), row)?,
                    None => {
                        for (number, (at, choice)) in numbered.enumerate() {
                            let own = offset + number * arity;
                            let values = indexed.parameters.get(own..own + arity);
                            let chosen = work.choose(symbol, at, own, values.unwrap_or(&[]))?;
                            *choice = S::of(u32::from(chosen));
                        }
                    }
                },
            }
            (at, offset) = (at + alike, offset + alike * arity);
        }
        if let Some(choosing) = choosing {
            choosing.finish()?;
        }
        Ok(self.made(indexed, symbols, choices, offset - parameters_from))
    }

    /// Sizes of what a chunk becomes that has so many parameters, when all is chosen.
    fn made<S: Narrow>(
        &self,
        indexed: &Indexed<'_, S>,
        symbols: &[S],
        choices: &[S],
        parameters: usize,
    ) -> Size {
        let mut size = Size::default();
        let mut replaced = 0;
        let stays = S::of(u32::from(STAYS));
        let rewritten = symbols.iter().zip(choices);
        for (cell, choice) in rewritten.filter(|(_, choice)| **choice != stays) {
            let (modules, parameters) = self.rules.made((*choice).into());
            size.rewritten += 1;
            size.modules += u64::from(modules);
            size.parameters += u64::from(parameters);
            replaced += indexed.arity(*cell);
        }
        size.modules += (symbols.len() - size.rewritten) as u64;
        size.parameters += (parameters - replaced) as u64;
        size
    }

    /// [`Self::count`] where each module's symbol and, at most, a draw decide.
    fn count_drawn<S: Narrow>(
        &self,
        chances: &Chances,
        key: PassKey,
        indexed: &Indexed<'_, S>,
        from: usize,
        choices: &mut [S],
    ) -> Size {
        let mut size = Size::default();
        let has_parameters = !indexed.parameters.is_empty();
        let symbols = indexed.symbols.get(from..).unwrap_or(&[]);
        for (at, (cell, choice)) in (from..).zip(symbols.iter().zip(choices)) {
            let draw = if chances.draws { key.choice(at) } else { 0 };
            let chosen = chances.choice((*cell).into(), draw);
            *choice = S::of(u32::from(chosen));
            let (modules, parameters) = self.rules.made(chosen);
            let stays = chosen == STAYS;
            size.modules += u64::from(modules);
            size.parameters += u64::from(parameters);
            size.rewritten += usize::from(!stays);
            if has_parameters && stays {
                size.parameters += indexed.arity(*cell) as u64;
            }
        }
        size
    }

    /// [`Self::count`] where modules have no parameters, and their neighbours decide. The chunk is given by its number and its first
    /// module.
    fn count_near<S: Narrow>(
        &self,
        table: &NearTable,
        index: &ContextIndex,
        all: &[S],
        (number, from): (usize, usize),
        choices: &mut [S],
    ) -> Size {
        // There are few symbols where there is a table, so a cell holds each and this, which stands for none.
        let nothing = S::of(u32::try_from(table.neighbour(None)).unwrap_or(u32::MAX));
        let own = all.get(from..from + choices.len()).unwrap_or(&[]);
        let mut size = Size::default();
        let mut note = |left: S, own: S, right: S, places: &mut [S]| {
            let choice = table.choice(left.into(), own.into(), right.into());
            places.fill(S::of(u32::from(choice)));
            let (modules, parameters) = self.rules.made(choice);
            size.rewritten += places.len() * usize::from(choice != STAYS);
            size.modules += places.len() as u64 * u64::from(modules);
            size.parameters += places.len() as u64 * u64::from(parameters);
        };
        if let Some(seams) = &index.seams {
            let beside = seams.beside(self.grammar, all, number, |_, symbol| symbol, nothing);
            let beside = beside.left.iter().zip(&beside.right);
            for ((own, (left, right)), place) in own.iter().zip(beside).zip(choices) {
                note(*left, *own, *right, from_mut(place));
            }
            return size;
        }
        let before = from.checked_sub(1).and_then(|at| all.get(at));
        let mut left = before.copied().unwrap_or(nothing);
        let behind = all.get(from + own.len()).copied().unwrap_or(nothing);
        let firsts = own.iter().step_by(RUN).skip(1).copied().chain([behind]);
        let groups = own.chunks(RUN).zip(choices.chunks_mut(RUN));
        for ((group, places), right) in groups.zip(firsts) {
            // What stands among its like becomes the same all along.
            if left == right && group.iter().fold(true, |all, s| all & (*s == left)) {
                note(left, left, left, places);
                continue;
            }
            let following = group.iter().skip(1).chain([&right]);
            for ((own, right), place) in group.iter().zip(following).zip(places) {
                note(left, *own, *right, from_mut(place));
                left = *own;
            }
        }
        size
    }

    /// The module of a successor that is the same as the one it replaces: that of its name and parameters.
    pub(super) fn heir(rule: &Rule, own: &[f64], written: &[f64]) -> Option<usize> {
        let is_same =
            |(_, first): &&(usize, usize)| written.get(*first..*first + own.len()) == Some(own);
        rule.heirs.iter().find(is_same).map(|(module, _)| *module)
    }

    /// Says when the modules of a successor were born, whose parameters are `written`, in place of a module with the
    /// parameters `own`, born in the step `birth`.
    pub(super) fn date<B: Cell>(
        &self,
        rule: &Rule,
        own: &[f64],
        birth: B,
        written: &[f64],
        births: &mut [B],
    ) {
        if self.births == Births::Inherit {
            births.fill(birth);
            return;
        }
        births.fill(B::of(self.step));
        if let Some(same) = Self::heir(rule, own, written).and_then(|h| births.get_mut(h)) {
            *same = birth;
        }
    }
}

/// Where the parameters of each chunk begin; empty where there are none, or one chunk alone.
fn parameter_starts<S: Narrow>(string: &ModuleString, symbols: &[S], parallel: bool) -> Vec<usize> {
    if string.parameters.is_empty() || symbols.len() <= CHUNK {
        return Vec::new();
    }
    let length = |chunk: &[S]| parameters_of(&string.arity, chunk);
    sums_before(if parallel {
        symbols
            .par_chunks(CHUNK)
            .with_max_len(TOGETHER)
            .map(length)
            .collect()
    } else {
        symbols.chunks(CHUNK).map(length).collect()
    })
}
