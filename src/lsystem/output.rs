//! What rounds write into: places of the next string, successors as templates, memory that is used again.

use super::choices::Choices;
use super::column::Cell;
use super::grammar::Rule;
use super::names::Symbol;
use super::query::Memory;
use super::rewrite::Round;
use super::string::ModuleString;

/// Places for modules that are written one after the other.
#[derive(Default)]
pub(super) struct Output<'s, S, B> {
    pub(super) symbols: &'s mut [S],
    pub(super) births: &'s mut [B],
    pub(super) parameters: &'s mut [f64],
}

impl<'s, S, B> Output<'s, S, B> {
    /// The next places; fewer where the count was wrong, which cannot be.
    pub(super) fn take(&mut self, modules: usize, parameters: usize) -> Self {
        fn front<'s, T>(rest: &mut &'s mut [T], length: usize) -> &'s mut [T] {
            let all = std::mem::take(rest);
            let (taken, left) = all.split_at_mut(length.min(all.len()));
            *rest = left;
            taken
        }
        Self {
            symbols: front(&mut self.symbols, modules),
            births: front(&mut self.births, modules),
            parameters: front(&mut self.parameters, parameters),
        }
    }
}

impl<S: Cell, B> Output<'_, S, B> {
    /// Writes a successor's modules over and over.
    pub(super) fn tile(&mut self, successor: &[Symbol]) {
        for place in self.symbols.chunks_exact_mut(successor.len().max(1)) {
            for (cell, symbol) in place.iter_mut().zip(successor) {
                *cell = S::of(u32::from(*symbol));
            }
        }
    }
}

/// Modules of a template.
pub(super) const TEMPLATE: usize = 16;
/// Grammars with more productions do without templates.
pub(super) const MOST_TEMPLATES: usize = 256;

/// A successor without parameters, to be written at once.
pub(super) struct Template<S> {
    /// Its first modules, then zeros.
    pub(super) symbols: [S; TEMPLATE],
    pub(super) length: usize,
    pub(super) heir: Option<usize>,
}

impl<S: Cell> Template<S> {
    pub(super) fn of(rule: &Rule) -> Self {
        let mut symbols = [S::default(); TEMPLATE];
        for (place, symbol) in symbols.iter_mut().zip(&rule.successor) {
            *place = S::of(u32::from(*symbol));
        }
        Self {
            symbols,
            length: rule.successor.len(),
            heir: Round::heir(rule, &[], &[]),
        }
    }
}

/// Memory of earlier rounds for the next one: fresh memory costs more than filling it.
#[derive(Default)]
pub(super) struct Spare {
    /// A string that is no longer needed.
    pub(super) string: ModuleString,
    pub(super) choices: Choices,
    /// Modules that the last round rewrote.
    pub(super) rewritten: usize,
    /// What the answers to queries leave for those of the next step.
    pub(super) answers: Memory,
}
