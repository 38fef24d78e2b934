//! Which production rewrote each module of a step, and why: what `ramus derive --explain` tells.
//!
//! The step is made once more with a record ([`super::record`]); what the record does not hold (the contexts that matched, the
//! weights among which one was drawn) is worked out anew for the modules that are shown, by the engine's own
//! choice, so that an explanation cannot differ from what was derived.

mod text;

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use serde::Serialize;

use super::choice::Worker;
use super::column::{Column, Narrow};
use super::context::{ContextIndex, Indexed, Modules, Window};
use super::derive::{self, Limits};
use super::error::DeriveError;
use super::grammar::{Grammar, Pattern, Role, Rule};
use super::names::Symbol;
use super::record::{Recorded, recorded};
use super::rewrite::Round;
use super::string::{Module, ModuleString, push_module};

/// What is shown of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExplainParams {
    /// The position in the string before the step from which modules are shown.
    pub from: usize,
    /// Entries shown at most; neighbours that stay are one entry.
    pub entries: usize,
    /// Bytes of a successor shown at most.
    pub text_bytes: usize,
}

impl Default for ExplainParams {
    /// The first 40 entries.
    fn default() -> Self {
        Self {
            from: 0,
            entries: 40,
            text_bytes: 400,
        }
    }
}

/// Format `ramus-explain/1`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// `ramus-explain/1`.
    pub format: &'static str,
    /// The step that is explained: from the string of the step before.
    pub step: u32,
    /// Modules before the step.
    pub modules_before: usize,
    /// Modules after it.
    pub modules_after: usize,
    /// The productions in the order of the file.
    pub productions: Vec<ProductionUse>,
    /// Modules that stayed as they are.
    pub stayed: usize,
    /// The productions of the `decompose` block, which then worked on what those above made.
    pub decomposition: Vec<ProductionUse>,
    /// What became of the modules, in their order.
    pub modules: Vec<Fate>,
    /// Modules after those shown.
    pub more: usize,
}

/// A production and how much it did.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ProductionUse {
    /// Its text.
    pub production: String,
    /// Its file and line.
    pub location: String,
    /// Modules that it rewrote.
    pub modules: usize,
}

/// What became of a module, or of neighbours that stayed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fate {
    /// Position in the string before the step, from 0.
    pub position: usize,
    /// How many modules: 1, but where neighbours stayed.
    pub count: usize,
    /// The module with its parameters.
    pub module: String,
    /// The production that rewrote it, as its index in `productions`; `None`: it stayed.
    pub production: Option<usize>,
    /// What it became (after decomposition and cuts).
    pub successor: String,
    /// Where that begins in the string after the step.
    pub successor_position: usize,
    /// Modules of the left context, the nearest first.
    pub left: Vec<Seen>,
    /// Modules of the right context.
    pub right: Vec<Seen>,
    /// Where the production was drawn: its weight and its probability.
    pub drawn: Option<Chance>,
}

/// A module that a context matched.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Seen {
    /// Its position in the string before the step.
    pub position: usize,
    /// The module with its parameters.
    pub module: String,
}

/// A production drawn from several.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Chance {
    /// Its weight.
    pub weight: f64,
    /// The weights of all that matched.
    pub total: f64,
    /// How many matched.
    pub among: usize,
}

impl Chance {
    /// How probable it was.
    #[must_use]
    pub fn probability(&self) -> f64 {
        self.weight / self.total
    }
}

impl Grammar {
    /// Explains the step `step` from the string before it.
    ///
    /// # Errors
    /// As [`Grammar::derive_next`].
    pub fn explain(
        &self,
        before: &ModuleString,
        step: u32,
        params: &ExplainParams,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Explanation, DeriveError> {
        let record = recorded(self, before, step, limits, cancel)?;
        let round = derive::productions(self, step, limits, cancel);
        let (modules, shown) = match &before.symbols {
            Column::Byte(symbols) => fates_in(&round, before, symbols, &record, params)?,
            Column::Half(symbols) => fates_in(&round, before, symbols, &record, params)?,
            Column::Word(_) => (Vec::new(), 0), // no symbol is as large
        };
        let (productions, stayed) = uses(self, &record);
        Ok(Explanation {
            format: "ramus-explain/1",
            step,
            modules_before: before.len(),
            modules_after: record.string.len(),
            productions,
            stayed,
            decomposition: decomposition(self, &record),
            modules,
            more: before.len().saturating_sub(shown),
        })
    }
}

/// [`fates`] for one width of symbols.
fn fates_in<S: Narrow>(
    round: &Round<'_>,
    before: &ModuleString,
    symbols: &[S],
    record: &Recorded,
    params: &ExplainParams,
) -> Result<(Vec<Fate>, usize), DeriveError> {
    // Fates are told of any part of the string: all of it is one chunk.
    let (grammar, chunks) = (round.grammar, (symbols.len(), false));
    let index = ContextIndex::new(grammar, round.rules, symbols, chunks, round.cancel)
        .ok_or_else(|| round.cancelled())?;
    let indexed = Indexed {
        symbols,
        parameters: &before.parameters,
        arity: &before.arity,
        index: &index,
        window: Window::new(grammar, &index, symbols, (0, 0)),
    };
    fates(round, before, &indexed, record, params)
}

/// How many modules each production rewrote, and how many none did.
fn uses(grammar: &Grammar, record: &Recorded) -> (Vec<ProductionUse>, usize) {
    let mut counts = vec![0; grammar.rules.rules.len()];
    let mut stayed = 0;
    for position in 0..record.len() {
        match record
            .production(position)
            .and_then(|at| counts.get_mut(at))
        {
            Some(count) => *count += 1,
            None => stayed += 1,
        }
    }
    let rules = grammar.rules.rules.iter().zip(counts);
    (
        rules.map(|(rule, count)| used(rule, count)).collect(),
        stayed,
    )
}

fn decomposition(grammar: &Grammar, record: &Recorded) -> Vec<ProductionUse> {
    let rules = grammar.decompose.iter().flat_map(|set| &set.rules);
    let narrow = |count: u64| usize::try_from(count).unwrap_or(usize::MAX);
    rules
        .zip(&record.decomposed)
        .map(|(rule, count)| used(rule, narrow(*count)))
        .collect()
}

fn used(rule: &Rule, modules: usize) -> ProductionUse {
    ProductionUse {
        production: rule.text.clone(),
        location: rule.location.clone(),
        modules,
    }
}

/// What became of the modules from the one asked for on, and the position after them.
fn fates(
    round: &Round<'_>,
    before: &ModuleString,
    indexed: &impl Modules,
    record: &Recorded,
    params: &ExplainParams,
) -> Result<(Vec<Fate>, usize), DeriveError> {
    let grammar = round.grammar;
    let mut work = Worker::new(round, indexed);
    let places = Places::new(before, indexed);
    let mut fates: Vec<Fate> = Vec::new();
    let mut following = record.string.iter();
    let mut passed = 0; // modules of the string after the step that were read
    let mut offset = 0;
    for (position, module) in before.iter().enumerate() {
        let own = offset;
        offset += module.parameters.len();
        let production = record.production(position);
        let Range { start, end } = record.successor(position);
        if position < params.from {
            continue;
        }
        // Neighbours that stay, or that all are cut, are told together.
        let like = |last: &Fate| {
            production.is_none()
                && last.production.is_none()
                && last.successor.is_empty() == (start == end)
        };
        let goes_on = fates.last().is_some_and(like);
        if fates.len() >= params.entries && !goes_on {
            return Ok((fates, position));
        }
        let skipped = following.by_ref().take(start - passed).count();
        let successor = text_of(
            grammar,
            following.by_ref().take(end - start),
            params.text_bytes,
        );
        passed += skipped + (end - start);
        let module_text = text_of(grammar, std::iter::once(module), usize::MAX);
        if let Some(last) = fates.last_mut().filter(|_| goes_on) {
            last.count += 1;
            for (text, more) in [
                (&mut last.module, module_text),
                (&mut last.successor, successor),
            ] {
                if text.len() + more.len() <= params.text_bytes {
                    text.push_str(&more);
                } else if !text.ends_with('…') {
                    text.push('…');
                }
            }
            continue;
        }
        let mut fate = Fate {
            position,
            count: 1,
            module: module_text,
            production,
            successor,
            successor_position: start,
            left: Vec::new(),
            right: Vec::new(),
            drawn: None,
        };
        if let Some(rule) = production.and_then(|at| grammar.rules.rules.get(at)) {
            let seen =
                |all: Vec<usize>| all.into_iter().map(|at| places.seen(grammar, at)).collect();
            (fate.left, fate.right) = (
                seen(left_of(rule, indexed, position)),
                seen(right_of(grammar, rule, indexed, position)),
            );
            if rule.weight.is_some() {
                work.choose(module.symbol, position, own, module.parameters)?;
                fate.drawn = drawn(work.drawn(), production);
            }
        }
        fates.push(fate);
    }
    Ok((fates, before.len()))
}

/// The weight of the production among those that matched, which are numbered from 1.
fn drawn(weights: &[(u16, f64)], production: Option<usize>) -> Option<Chance> {
    let chosen = |one: &&(u16, f64)| usize::from(one.0).checked_sub(1) == production;
    Some(Chance {
        weight: weights.iter().find(chosen)?.1,
        total: weights.iter().map(|one| one.1).sum(),
        among: weights.len(),
    })
}

/// The text of modules, ended with `…` where it would be longer than `most` bytes.
fn text_of<'m>(
    grammar: &Grammar,
    modules: impl Iterator<Item = Module<'m>>,
    most: usize,
) -> String {
    let mut text = String::new();
    let mut full = false;
    for module in modules {
        if full {
            continue; // all of them are read, so that the iterator stands behind them
        }
        let before = text.len();
        push_module(&mut text, grammar, &module);
        if text.len() > most {
            text.truncate(before);
            text.push('…');
            full = true;
        }
    }
    text
}

/// The places that the left context matched, the nearest first.
fn left_of(rule: &Rule, indexed: &impl Modules, mut at: usize) -> Vec<usize> {
    let next = |_: &Pattern| {
        at = indexed.left(at)?;
        Some(at)
    };
    rule.left.iter().map_while(next).collect()
}

/// The places of modules that the right context matched.
fn right_of(grammar: &Grammar, rule: &Rule, indexed: &impl Modules, mut at: usize) -> Vec<usize> {
    if rule.looks.into_branches {
        let mut seen = Vec::new();
        branches(grammar, indexed, &rule.right, at + 1, &mut seen);
        return seen;
    }
    let next = |_: &Pattern| {
        at = indexed.right(at)?;
        Some(at)
    };
    rule.right.iter().map_while(next).collect()
}

/// As the search of contexts goes ([`super::context`]), with the places kept; recursion is bounded by the parser's bound on
/// branches in a pattern.
fn branches(
    grammar: &Grammar,
    indexed: &impl Modules,
    pattern: &[Pattern],
    mut at: usize,
    seen: &mut Vec<usize>,
) -> bool {
    let mut next = 0;
    while let Some(item) = pattern.get(next) {
        let Some(found) = indexed.symbol(at) else {
            return false;
        };
        match (item, grammar.role(found)) {
            (_, Role::Close) => return false,
            (_, Role::Ignored) => at += 1,
            (Pattern::Open { inside }, Role::Open) => {
                let inner = pattern.get(next + 1..=next + inside).unwrap_or(&[]);
                let before = seen.len();
                if branches(grammar, indexed, inner, at + 1, seen) {
                    next += inside + 2;
                } else {
                    seen.truncate(before);
                }
                at = indexed.partner(at) + 1;
            }
            (Pattern::Module { .. }, Role::Open) => at = indexed.partner(at) + 1,
            (Pattern::Module { symbol, .. }, _) if found == *symbol => {
                seen.push(at);
                next += 1;
                at += 1;
            }
            _ => return false,
        }
    }
    true
}

/// Modules between two places whose parameters are known to begin there.
const BLOCK: usize = 64;

/// Where the parameters of modules anywhere in the string are.
struct Places<'a, M> {
    string: &'a ModuleString,
    indexed: &'a M,
    starts: Vec<usize>,
}

impl<'a, M: Modules> Places<'a, M> {
    fn new(string: &'a ModuleString, indexed: &'a M) -> Self {
        let mut starts = Vec::new();
        let mut offset = 0;
        for (at, module) in string.iter().enumerate() {
            if at % BLOCK == 0 {
                starts.push(offset);
            }
            offset += module.parameters.len();
        }
        Self {
            string,
            indexed,
            starts,
        }
    }

    /// The module at a place.
    fn seen(&self, grammar: &Grammar, at: usize) -> Seen {
        let symbol = self.indexed.symbol(at).unwrap_or(Symbol::MAX);
        let arity = |symbol: Symbol| {
            let arity = grammar.arity.get(usize::from(symbol));
            arity.map_or(0, |arity| usize::from(*arity))
        };
        let block = at / BLOCK;
        let within = (block * BLOCK..at).filter_map(|at| self.indexed.symbol(at));
        let start = self.starts.get(block).copied().unwrap_or(0) + within.map(arity).sum::<usize>();
        let parameters = self.string.parameters();
        let module = Module {
            symbol,
            birth: 0,
            parameters: parameters.get(start..start + arity(symbol)).unwrap_or(&[]),
        };
        Seen {
            position: at,
            module: text_of(grammar, std::iter::once(module), usize::MAX),
        }
    }
}
