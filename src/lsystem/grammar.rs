//! A checked grammar: everything that derivation and the turtle need, with no text left to look at.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::code::Expression;
use super::derive::{self, Limits};
use super::error::{DeriveError, GrammarErrors};
use super::names::{Names, Symbol};
use super::parse;
use super::shape::Shape;
use super::string::ModuleString;

/// A grammar that has been read and checked.
#[derive(Clone, Debug)]
pub struct Grammar {
    pub(crate) names: Names,
    pub(crate) arity: Arc<[u8]>,
    pub(crate) roles: Vec<Role>,
    pub(crate) axiom: ModuleString,
    pub(crate) rules: RuleSet,
    /// Applied after each step until nothing changes.
    pub(crate) decompose: Option<RuleSet>,
    pub(crate) decompose_depth: u32,
    /// Applied to what the turtle draws, never to the string.
    pub(crate) interpret: Option<RuleSet>,
    pub(crate) interpret_depth: u32,
    /// Contexts are plain neighbours.
    pub(crate) literal: bool,
    pub(crate) steps: Option<u32>,
    pub(crate) seed: u64,
    pub(crate) angle: Option<f64>,
    pub(crate) tropism: Option<DVec3>,
    pub(crate) shapes: Vec<Shape>,
    /// For each symbol its dictionary entry.
    pub(crate) shape_of: Vec<Option<u16>>,
}

/// What a symbol is to the rewriting.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Role {
    /// Seen by contexts.
    #[default]
    Module,
    /// `[`
    Open,
    /// `]`
    Close,
    /// `%`
    Cut,
    /// Skipped by contexts.
    Ignored,
}

/// Which of several matching productions applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Order {
    /// The first in the file.
    #[default]
    First,
    /// Longer contexts first, then those with a condition, then the first in the file.
    Specific,
}

/// One module of a context pattern.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Pattern {
    /// A module whose parameters go into the slots from `slot` on.
    Module {
        /// Name and number of parameters in one.
        symbol: Symbol,
        /// First slot.
        slot: u16,
    },
    /// A branch: so many items of the pattern stand in it, then its `Close`.
    Open {
        /// Items between this and its `Close`.
        inside: usize,
    },
    /// End of a branch.
    Close,
}

/// One production.
#[derive(Clone, Debug)]
pub(crate) struct Rule {
    /// Its text, for messages.
    pub(crate) text: String,
    /// File and line.
    pub(crate) location: String,
    pub(crate) predecessor: Symbol,
    /// Nearest module first; no brackets.
    pub(crate) left: Vec<Pattern>,
    pub(crate) right: Vec<Pattern>,
    /// Modules of both contexts.
    pub(crate) context_length: usize,
    /// Parameters bound by the predecessor and by both contexts.
    pub(crate) slots: usize,
    pub(crate) condition: Option<Expression>,
    pub(crate) weight: Option<Expression>,
    pub(crate) successor: Vec<Symbol>,
    /// Parameters of all successor modules, one after the other.
    pub(crate) arguments: Vec<Expression>,
    /// Successor modules of the predecessor's own symbol, with their first argument: one of them may be the same module.
    pub(crate) heirs: Vec<(usize, usize)>,
}

impl Rule {
    /// Whether it applies to every module of its predecessor's symbol.
    pub(crate) fn unconditional(&self) -> bool {
        self.left.is_empty()
            && self.right.is_empty()
            && self.condition.is_none()
            && self.weight.is_none()
    }

    pub(crate) fn has_context(&self) -> bool {
        !(self.left.is_empty() && self.right.is_empty())
    }

    /// Rank under [`Order::Specific`]: larger goes first.
    pub(crate) fn rank(&self) -> (usize, bool) {
        (self.context_length, self.condition.is_some())
    }
}

/// Productions, found by symbol.
#[derive(Clone, Debug, Default)]
pub(crate) struct RuleSet {
    pub(crate) rules: Vec<Rule>,
    /// For each symbol its productions, best first.
    pub(crate) by_symbol: Vec<Vec<u16>>,
    pub(crate) order: Order,
    pub(crate) has_context: bool,
}

impl RuleSet {
    pub(crate) fn new(rules: Vec<Rule>, symbols: usize, order: Order) -> Self {
        let mut by_symbol: Vec<Vec<u16>> = vec![Vec::new(); symbols];
        for (index, rule) in rules.iter().enumerate() {
            if let (Some(list), Ok(index)) = (
                by_symbol.get_mut(usize::from(rule.predecessor)),
                u16::try_from(index),
            ) {
                list.push(index);
            }
        }
        if order == Order::Specific {
            let rank = |index: &u16| {
                rules
                    .get(usize::from(*index))
                    .map(|r| std::cmp::Reverse(r.rank()))
            };
            for list in &mut by_symbol {
                list.sort_by_key(rank); // stable: file order among equals
            }
        }
        let has_context = rules.iter().any(Rule::has_context);
        Self {
            rules,
            by_symbol,
            order,
            has_context,
        }
    }

    /// Whether anything is left to chance: which production applies, or a parameter.
    pub(crate) fn draws(&self) -> bool {
        let drawn =
            |rule: &Rule| rule.weight.is_some() || rule.arguments.iter().any(Expression::draws);
        self.rules.iter().any(drawn)
    }
}

impl Grammar {
    /// Reads a grammar. `file` names the text in messages; where it is a file that exists, `include` reads from its folder.
    ///
    /// # Errors
    /// All faults found, each with its line and column.
    pub fn parse(source: &str, file: &str) -> Result<Self, GrammarErrors> {
        parse::grammar(source, file)
    }

    /// The string after `steps` steps.
    ///
    /// # Errors
    /// A limit, a value that cannot be computed, or `cancel` being set (seen within a few milliseconds); the last whole
    /// step is in the error.
    pub fn derive(
        &self,
        steps: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<ModuleString, DeriveError> {
        derive::derive(self, steps, limits, cancel)
    }

    /// One step on: the string of step `step` from that of step `step − 1`.
    ///
    /// # Errors
    /// As [`Grammar::derive`]; the error carries no string, since the caller has it.
    pub fn derive_next(
        &self,
        string: &ModuleString,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<ModuleString, DeriveError> {
        derive::next(self, string, step, limits, cancel)
    }

    /// The number of steps that the file states.
    #[must_use]
    pub fn steps(&self) -> Option<u32> {
        self.steps
    }

    /// The seed of the random draws.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// The same grammar with another seed: another individual of the same kind.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// The turn in degrees of `+ - & ^ \ /` without a parameter, where the file states it.
    #[must_use]
    pub fn angle(&self) -> Option<f64> {
        self.angle
    }

    /// The name of a symbol of a string of this grammar.
    #[must_use]
    pub fn name(&self, symbol: Symbol) -> &str {
        self.names.name(symbol)
    }

    pub(crate) fn role(&self, symbol: Symbol) -> Role {
        self.roles
            .get(usize::from(symbol))
            .copied()
            .unwrap_or_default()
    }
}
