//! How far a derivation stays as it is when its grammar is edited.
//!
//! Both grammars are compared as what they were checked to be, not as texts: a string stays where the axiom is the same and
//! no production that differs could have applied to any string before it. Whether it could is told by the symbols of
//! those strings: its predecessor and all modules of its contexts must stand there. Conditions are not asked. So the answer is safe, and an
//! edit of what grows late leaves early strings alone.
//!
//! Symbols are numbered in the order of the text, so the same symbol may have another number after an edit; modules are the same where name and
//! number of parameters are.

use super::code::{Expression, Op};
use super::grammar::{Grammar, Pattern, Rule, RuleSet};
use super::names::{Names, Symbol};
use super::string::ModuleString;

/// The symbols that stand in a string, by number.
pub(super) type Present = Box<[bool]>;

/// The symbols of a string.
pub(super) fn present(grammar: &Grammar, string: &ModuleString) -> Present {
    let mut present = vec![false; grammar.names.symbols().len()].into_boxed_slice();
    for symbol in string.symbols() {
        if let Some(place) = present.get_mut(usize::from(symbol)) {
            *place = true;
        }
    }
    present
}

/// What an edit made of a grammar.
pub(super) struct Edit<'g> {
    old: &'g Grammar,
    new: &'g Grammar,
    /// For each symbol its number in the new grammar,
    renumbered: Vec<Option<Symbol>>,
    /// and for each of the new grammar's its number in the old one.
    numbered: Vec<Option<Symbol>>,
    /// Contexts see the same modules as before.
    same_contexts: bool,
    /// Symbols, by number, whose productions are not the same as before.
    changed: Vec<Symbol>,
}

impl<'g> Edit<'g> {
    /// The edit from one grammar to another; none where already the first strings differ.
    pub(super) fn new(old: &'g Grammar, new: &'g Grammar) -> Option<Self> {
        let number = |index: usize| Symbol::try_from(index).unwrap_or(Symbol::MAX);
        let find = |from: &Names, to: &Names| -> Vec<Option<Symbol>> {
            let symbols = from.symbols().iter().enumerate();
            symbols
                .map(|(index, info)| to.find(from.name(number(index)), info.arity))
                .collect()
        };
        let mut edit = Self {
            old,
            new,
            renumbered: find(&old.names, &new.names),
            numbered: find(&new.names, &old.names),
            same_contexts: false,
            changed: Vec::new(),
        };
        edit.same_contexts = old.literal == new.literal && edit.same_roles();
        // The turtle's answers depend on the whole grammar.
        if old.has_queries || new.has_queries || !edit.same_axiom() || !edit.same_decomposition() {
            return None;
        }
        edit.changed = (0..edit.renumbered.len())
            .map(number)
            .filter(|symbol| !edit.same_productions(&old.rules, &new.rules, *symbol, |_| true))
            .collect();
        Some(edit)
    }

    /// Whether a step from a string of these symbols makes the same as before.
    pub(super) fn same_step(&self, present: &[bool]) -> bool {
        let is_present = |symbol: Symbol| present.get(usize::from(symbol)) == Some(&true);
        self.changed.iter().all(|symbol| {
            let (old, new) = (&self.old.rules, &self.new.rules);
            !is_present(*symbol) || self.same_productions(old, new, *symbol, is_present)
        })
    }

    /// Symbols that may stand in the first string.
    pub(super) fn first(&self) -> Present {
        self.decomposed(present(self.old, &self.old.axiom))
    }

    /// Symbols that may stand in the string after one of these symbols.
    pub(super) fn after(&self, before: &[bool]) -> Present {
        let mut after: Present = before.into();
        add_successors(&self.old.rules, before, &mut after);
        self.decomposed(after)
    }

    fn decomposed(&self, mut symbols: Present) -> Present {
        if let Some(rules) = &self.old.decompose {
            let mut before = symbols.clone();
            while add_successors(rules, &before, &mut symbols) {
                before.clone_from(&symbols);
            }
        }
        symbols
    }

    /// Whether the new grammar has all of these symbols.
    pub(super) fn has_all(&self, symbols: &[bool]) -> bool {
        let symbols = symbols.iter().zip(&self.renumbered);
        symbols
            .into_iter()
            .all(|(is_there, new)| !is_there || new.is_some())
    }

    /// For each symbol its number in the new grammar; none where all stay as they are.
    pub(super) fn renumbered(&self) -> Option<&[Option<Symbol>]> {
        let stays = |(index, new): (usize, &Option<Symbol>)| new.map(usize::from) == Some(index);
        let all = self.renumbered.iter().enumerate().all(stays);
        (!all).then_some(&self.renumbered)
    }

    fn same_symbol(&self, old: Symbol, new: Symbol) -> bool {
        self.renumbered.get(usize::from(old)) == Some(&Some(new))
    }

    fn same_roles(&self) -> bool {
        let roles = self.renumbered.iter().zip(&self.old.roles);
        roles.into_iter().all(|(new, role)| {
            // What is no longer there has a say where it stands only, and there the productions differ.
            new.is_none_or(|new| self.new.role(new) == *role)
        })
    }

    fn same_axiom(&self) -> bool {
        let (old, new) = (&self.old.axiom, &self.new.axiom);
        old.len() == new.len()
            && old.iter().zip(new.iter()).all(|(a, b)| {
                self.same_symbol(a.symbol, b.symbol) && same_values(a.parameters, b.parameters)
            })
    }

    /// The strings between two rounds of decomposition are not kept, so all of it must be the same.
    fn same_decomposition(&self) -> bool {
        match (&self.old.decompose, &self.new.decompose) {
            (None, None) => true,
            (Some(old), Some(new)) => {
                self.old.decompose_depth == self.new.decompose_depth
                    && old.rules.len() == new.rules.len()
                    && (0..self.renumbered.len()).all(|index| {
                        let symbol = Symbol::try_from(index).unwrap_or(Symbol::MAX);
                        self.same_productions(old, new, symbol, |_| true)
                    })
            }
            _ => false,
        }
    }

    /// Whether a symbol has the same productions in the same order, of those whose modules are all there.
    fn same_productions(
        &self,
        old: &RuleSet,
        new: &RuleSet,
        symbol: Symbol,
        is_there: impl Fn(Symbol) -> bool,
    ) -> bool {
        fn of(set: &RuleSet, symbol: Option<Symbol>) -> impl Iterator<Item = &Rule> {
            let numbers = symbol.and_then(|symbol| set.by_symbol.get(usize::from(symbol)));
            let numbers = numbers.map_or(&[][..], Vec::as_slice);
            let rule = |number: &u16| set.rules.get(usize::from(*number));
            numbers.iter().filter_map(rule)
        }
        let wanted = |rule: &Rule| -> Vec<Symbol> {
            let patterns = rule.left.iter().chain(&rule.right);
            patterns.filter_map(Pattern::symbol).collect()
        };
        // A module of the new grammar alone is nowhere.
        let old_number = |new: Symbol| self.numbered.get(usize::from(new)).copied().flatten();
        let could_before = |rule: &&Rule| wanted(rule).into_iter().all(&is_there);
        let can_now = |rule: &&Rule| {
            let mut all = wanted(rule).into_iter().map(old_number);
            all.all(|symbol| symbol.is_some_and(&is_there))
        };
        let new_symbol = self.renumbered.get(usize::from(symbol)).copied().flatten();
        let before: Vec<&Rule> = of(old, Some(symbol)).filter(could_before).collect();
        let now: Vec<&Rule> = of(new, new_symbol).filter(can_now).collect();
        // Among which productions chance decides depends on the order.
        let ordered = old.order == new.order || before.iter().all(|rule| rule.weight.is_none());
        ordered
            && before.len() == now.len()
            && before
                .into_iter()
                .zip(now)
                .all(|(a, b)| self.same_rule(a, b))
    }

    /// Whether two productions of the same predecessor do the same.
    fn same_rule(&self, a: &Rule, b: &Rule) -> bool {
        let optional = |a: &Option<Expression>, b: &Option<Expression>| match (a, b) {
            (None, None) => true,
            (Some(a), Some(b)) => same_expression(a, b),
            _ => false,
        };
        let draws = a.weight.is_some() || a.arguments.iter().any(Expression::draws);
        (self.same_contexts || !a.has_context())
            && (self.old.seed == self.new.seed || !draws)
            && self.same_pattern(&a.left, &b.left)
            && self.same_pattern(&a.right, &b.right)
            && optional(&a.condition, &b.condition)
            && optional(&a.weight, &b.weight)
            && a.successor.len() == b.successor.len()
            && a.arguments.len() == b.arguments.len()
            && (a.successor.iter().zip(&b.successor)).all(|(a, b)| self.same_symbol(*a, *b))
            && (a.arguments.iter().zip(&b.arguments)).all(|(a, b)| same_expression(a, b))
    }

    fn same_pattern(&self, a: &[Pattern], b: &[Pattern]) -> bool {
        a.len() == b.len()
            && a.iter().zip(b).all(|pair| match pair {
                (
                    Pattern::Module { symbol: a, slot },
                    Pattern::Module {
                        symbol: b,
                        slot: other,
                    },
                ) => self.same_symbol(*a, *b) && slot == other,
                (a, b) => a == b,
            })
    }
}

/// Adds what the productions make of these symbols; whether that is anything new.
fn add_successors(rules: &RuleSet, of: &[bool], to: &mut Present) -> bool {
    let mut more = false;
    let applies = |rule: &&Rule| of.get(usize::from(rule.predecessor)) == Some(&true);
    for symbol in rules
        .rules
        .iter()
        .filter(applies)
        .flat_map(|r| &r.successor)
    {
        if let Some(place) = to.get_mut(usize::from(*symbol)) {
            more |= !*place;
            *place = true;
        }
    }
    more
}

fn same_values(a: &[f64], b: &[f64]) -> bool {
    let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    bits(a) == bits(b)
}

/// Whether two expressions have the same value whatever is bound, bit for bit: 0 and -0 are not the same.
fn same_expression(a: &Expression, b: &Expression) -> bool {
    let same_op = |(a, b): (&Op, &Op)| match (a, b) {
        (Op::Push(a), Op::Push(b)) => a.to_bits() == b.to_bits(),
        (a, b) => a == b,
    };
    match (a, b) {
        (Expression::Constant(a), Expression::Constant(b)) => a.to_bits() == b.to_bits(),
        (Expression::Code { code: a, .. }, Expression::Code { code: b, .. }) => {
            a.len() == b.len() && a.iter().zip(b).all(same_op)
        }
        (a, b) => a == b,
    }
}
