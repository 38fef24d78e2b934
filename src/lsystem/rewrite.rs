//! One round of parallel rewriting.
//!
//! A round has two passes over chunks of the string. The count pass chooses a production for each module and
//! adds up how large the chunk's successor is; prefix sums say where each chunk writes; the fill pass writes symbols,
//! births and parameters into slices of their own. Draws depend on (seed, step, round, position) alone and chunks are fixed in
//! size, so the result is the same on any number of threads, and so is the error: the first in the string.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::choice::{Worker, near};
use super::column::{Cell, Column, Narrow, bytes_up_to};
use super::context::{ContextIndex, Indexed};
use super::derive::Limits;
use super::error::{DeriveError, DeriveProblem, ValueProblem};
use super::grammar::{Grammar, Plan, Rule, RuleSet};
use super::names::Symbol;
use super::output::{MOST_TEMPLATES, Output, Spare, TEMPLATE, Template, reused};
use super::string::{ModuleString, parameters_of, string_bytes};

/// Modules of a chunk.
const CHUNK: usize = 8192;
/// Strings shorter than this are rewritten on the calling thread.
const PARALLEL_FROM: usize = 4 * CHUNK;
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
struct Task<'s, S, B> {
    from: usize,
    parameters_from: usize,
    choices: &'s [S],
    out: Output<'s, S, B>,
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
            let results: Vec<Result<R, DeriveError>> = items.into_par_iter().map(work).collect();
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
            ContextIndex::new(self.grammar, self.rules, symbols, self.cancel)
                .ok_or_else(|| self.cancelled())?
        } else {
            ContextIndex::default()
        };
        let indexed = Indexed {
            symbols,
            parameters: &string.parameters,
            arity: &string.arity,
            index,
        };
        let parameter_starts = parameter_starts(&indexed);
        let start_of = |chunk: usize| parameter_starts.get(chunk).copied().unwrap_or(0);

        // Each is written before it is read.
        let old = S::into_cells(std::mem::take(&mut spare.choices));
        let mut choices = reused(old, symbols.len()).ok_or_else(|| DeriveProblem::Memory {
            step: self.step,
            bytes: size_of_val(symbols) as u64,
        })?;
        let chunks: Vec<(usize, &mut [S])> = choices.chunks_mut(CHUNK).enumerate().collect();
        let sizes = Self::each(parallel, chunks, |(chunk, choices)| {
            self.count(&indexed, chunk * CHUNK, start_of(chunk), choices)
        })?;
        spare.rewritten = sizes.iter().map(|s| s.rewritten).sum();
        if spare.rewritten == 0 {
            spare.choices = S::column(choices);
            return Ok(None);
        }
        let modules = sizes
            .iter()
            .fold(0_u64, |sum, s| sum.saturating_add(s.modules));
        let parameters = sizes
            .iter()
            .fold(0_u64, |sum, s| sum.saturating_add(s.parameters));
        self.check_size(string, modules, parameters)?;

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
        let mut next_symbols = reused(S::into_cells(old.symbols), modules).ok_or_else(memory)?;
        let mut next_births = reused(B::into_cells(old.births), modules).ok_or_else(memory)?;
        let mut next_parameters = reused(old.parameters, parameters).ok_or_else(memory)?;
        let mut tasks = Vec::with_capacity(sizes.len());
        {
            let mut out = Output {
                symbols: &mut next_symbols,
                births: &mut next_births,
                parameters: &mut next_parameters,
            };
            for (chunk, (size, choices)) in sizes.iter().zip(choices.chunks(CHUNK)).enumerate() {
                // The sums above fit usize, so their parts do.
                let fitting = |n: u64| usize::try_from(n).unwrap_or(usize::MAX);
                tasks.push(Task {
                    from: chunk * CHUNK,
                    parameters_from: start_of(chunk),
                    choices,
                    out: out.take(fitting(size.modules), fitting(size.parameters)),
                });
            }
        }
        let templates = self.templates(string);
        Self::each(parallel || pays_in_parallel(modules), tasks, |task| {
            self.fill(&indexed, births, templates.as_deref(), task)
        })?;
        spare.choices = S::column(choices);
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
            index: ContextIndex::default(), // decomposition has no contexts
        };
        let mut choices = vec![S::of(u32::from(STAYS)); symbols.len()];
        self.count(&indexed, 0, 0, &mut choices)?;
        Ok(choices.iter().find_map(|c| self.rule((*c).into())))
    }

    fn check_size(
        &self,
        string: &ModuleString,
        modules: u64,
        parameters: u64,
    ) -> Result<(), DeriveError> {
        let index = if self.rules.has_context {
            ContextIndex::bytes(self.rules, string.len() as u64)
        } else {
            0
        };
        let symbol = string.symbols.cell_bytes();
        let choices = symbol * string.len() as u64;
        let birth = bytes_up_to(self.step).max(string.births.cell_bytes());
        let bytes = string_bytes(symbol + birth, modules, parameters)
            .saturating_add(string.bytes())
            .saturating_add(index + choices);
        let limit = if modules > self.limits.modules.min(u64::from(u32::MAX)) {
            format!("{} modules", self.limits.modules.min(u64::from(u32::MAX)))
        } else if bytes > self.limits.bytes {
            format!("{} bytes", self.limits.bytes)
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
        if self.cancel.load(Ordering::Relaxed) {
            return Err(self.cancelled());
        }
        let mut work = Worker::new(self, indexed);
        let mut size = Size::default();
        let mut offset = parameters_from;
        let symbols = indexed.symbols.get(from..).unwrap_or(&[]);
        for (at, (cell, choice)) in (from..).zip(symbols.iter().zip(choices.iter_mut())) {
            let symbol: Symbol = (*cell).into();
            let arity = indexed.arity(*cell);
            let chosen = match self.rules.plan(symbol) {
                Plan::Stay => STAYS,
                Plan::Always(number) => number + 1,
                Plan::Near => near(indexed, self.rules.near(symbol), at),
                Plan::Draw => work.pick(self.rules.weighted(symbol), at),
                Plan::Choose => {
                    let own = indexed.parameters.get(offset..offset + arity);
                    work.choose(symbol, at, offset, own.unwrap_or(&[]))?
                }
            };
            *choice = S::of(u32::from(chosen));
            offset += arity;
            if let Some(rule) = self.rule(chosen) {
                size.rewritten += 1;
                size.modules += rule.successor.len() as u64;
                size.parameters += rule.arguments.len() as u64;
            } else {
                size.parameters += arity as u64;
            }
        }
        size.modules += (choices.len() - size.rewritten) as u64;
        Ok(size)
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

    /// Writes what the chosen productions make of a chunk.
    fn fill<S: Narrow, B: Cell>(
        &self,
        indexed: &Indexed<'_, S>,
        births: &[B],
        templates: Option<&[Template<S>]>,
        task: Task<'_, S, B>,
    ) -> Result<(), DeriveError> {
        if self.cancel.load(Ordering::Relaxed) {
            return Err(self.cancelled());
        }
        if let Some(templates) = templates {
            return self.fill_plain(indexed.symbols, births, templates, task);
        }
        let mut work = Worker::new(self, indexed);
        let mut out = task.out;
        let (mut at, mut offset) = (task.from, task.parameters_from);
        // What stays is copied in whole stretches.
        let stays = S::of(u32::from(STAYS));
        for stretch in task.choices.chunk_by(|a, b| *a == stays && *b == stays) {
            let end = at + stretch.len();
            let symbols = indexed.symbols.get(at..end).unwrap_or(&[]);
            let births = births.get(at..end).unwrap_or(&[]);
            let parameters = match indexed.parameters.is_empty() {
                true => 0,
                false => parameters_of(indexed.arity, symbols),
            };
            let own = indexed.parameters.get(offset..offset + parameters);
            let own = own.unwrap_or(&[]);
            let made = match stretch.first().and_then(|c| self.rule((*c).into())) {
                None => {
                    let target = out.take(symbols.len(), parameters);
                    target.symbols.copy_from_slice(symbols);
                    target.births.copy_from_slice(births);
                    target.parameters.copy_from_slice(own);
                    symbols.len()
                }
                Some(rule) => {
                    let target = out.take(rule.successor.len(), rule.arguments.len());
                    work.evaluate(rule, at, offset, own, target.parameters)?;
                    for (cell, symbol) in target.symbols.iter_mut().zip(&rule.successor) {
                        *cell = S::of(u32::from(*symbol));
                    }
                    let birth = births.first().copied().unwrap_or_default();
                    self.date(rule, own, birth, target.parameters, target.births);
                    rule.successor.len()
                }
            };
            (at, offset) = (end, offset + parameters);
            if !work.matcher.go_on(u32::try_from(made).unwrap_or(u32::MAX)) {
                return Err(self.cancelled());
            }
        }
        Ok(())
    }
}

impl Round<'_> {
    /// The productions' successors for [`Self::fill_plain`]; none where modules have parameters.
    fn templates<S: Cell>(&self, string: &ModuleString) -> Option<Vec<Template<S>>> {
        let rules = &self.rules.rules;
        let plain = rules.len() <= MOST_TEMPLATES
            && self.births == Births::Step
            && string.parameters.is_empty()
            && rules.iter().all(|rule| rule.arguments.is_empty());
        plain.then(|| rules.iter().map(Template::of).collect())
    }

    /// [`Self::fill`] where no module has parameters. A short successor is written as a whole template, whose excess
    /// the next module overwrites: a copy of fixed length costs next to nothing.
    fn fill_plain<S: Narrow, B: Cell>(
        &self,
        old_symbols: &[S],
        old_births: &[B],
        templates: &[Template<S>],
        task: Task<'_, S, B>,
    ) -> Result<(), DeriveError> {
        let Output {
            symbols, births, ..
        } = task.out;
        let (mut out, mut checked) = (0, 0);
        let step = B::of(self.step);
        let old = old_symbols.iter().zip(old_births).skip(task.from);
        for ((symbol, birth), choice) in old.zip(task.choices) {
            let choice: u16 = (*choice).into();
            let template = match choice.checked_sub(1) {
                None => {
                    if let (Some(s), Some(b)) = (symbols.get_mut(out), births.get_mut(out)) {
                        (*s, *b) = (*symbol, *birth);
                    }
                    out += 1;
                    continue;
                }
                Some(rule) => templates.get(usize::from(rule)),
            };
            let Some(template) = template else { continue };
            let length = template.length;
            if length == 1
                && let (Some(s), Some(b)) = (symbols.get_mut(out), births.get_mut(out))
            {
                (*s, *b) = (template.symbols[0], step);
            } else if let (Some(s), Some(b)) = (
                symbols.get_mut(out..out + TEMPLATE),
                births.get_mut(out..out + TEMPLATE),
            ) && length <= TEMPLATE
            {
                s.copy_from_slice(&template.symbols);
                b.fill(step);
            } else if let (Some(s), Some(b), Some(rule)) = (
                symbols.get_mut(out..out + length),
                births.get_mut(out..out + length),
                self.rule(choice),
            ) {
                for (cell, symbol) in s.iter_mut().zip(&rule.successor) {
                    *cell = S::of(u32::from(*symbol));
                }
                b.fill(step);
                if out - checked > WRITTEN_AT_ONCE {
                    checked = out;
                    if self.cancel.load(Ordering::Relaxed) {
                        return Err(self.cancelled());
                    }
                }
            }
            if let Some(same) = template.heir.and_then(|heir| births.get_mut(out + heir)) {
                *same = *birth;
            }
            out += length;
        }
        Ok(())
    }
}

/// Modules written between two looks at the cancel flag where successors are long.
const WRITTEN_AT_ONCE: usize = 1 << 20;
/// Where the parameters of each chunk begin; empty where there are none.
fn parameter_starts<S: Narrow>(indexed: &Indexed<'_, S>) -> Vec<usize> {
    if indexed.parameters.is_empty() {
        return Vec::new();
    }
    let mut offset = 0;
    let mut starts = Vec::with_capacity(indexed.symbols.len() / CHUNK + 1);
    for chunk in indexed.symbols.chunks(CHUNK) {
        starts.push(offset);
        offset += parameters_of(indexed.arity, chunk);
    }
    starts
}
