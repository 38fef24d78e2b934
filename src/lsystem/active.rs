//! Derivation that visits active modules only, for strings of which most rests.
//!
//! A growing plant is busy at its ends; nearly every module is what it will stay. A module that no production rewrote
//! can only be rewritten later once its contexts change, where nothing is drawn at random. So each step looks
//! at those modules alone that are new or have a new module within reach of their contexts, and a whole derivation takes
//! time in proportion to all modules ever made, not to steps × length: the string of a tall trunk is as cheap as that of
//! a bush.
//!
//! The modules stand in a doubly linked list, so that a successor is put in without moving the others. This is for
//! grammars without contexts or with plain neighbours as contexts (as sketches have), without draws, without `%`. What
//! it gives is what the rounds of [`super::rewrite`] give; where a step cannot be made, those say why.

use std::sync::atomic::{AtomicBool, Ordering};

use super::choice::Worker;
use super::column::{Cell, for_width};
use super::context::{Base, Modules};
use super::derive::{Limits, decomposed, productions};
use super::error::DeriveError;
use super::grammar::{Grammar, Role, Rule, RuleSet};
use super::names::Symbol;
use super::rewrite::Round;
use super::string::{Module, ModuleString};

/// No module: before the first and behind the last one, and between the successors of a step.
const SEAM: Symbol = Symbol::MAX;
/// Place of the seam in the list: the list is a ring through it.
const ENDS: u32 = 0;
/// Strings longer than this are worth the list only while most modules rest:
const SHORT: usize = 256;
/// one of so many may be active. Visiting one in the list takes as long as a round takes for so many.
const RESTING: usize = 4;
/// Active modules for each one that a step rewrites: it, its successors, what stands before it.
const WOKEN: usize = 3;
/// Strings longer than this would take too much memory as a list.
const LONG: usize = 1 << 20;
/// Places that are no longer in the list, for each that is, beyond which the list is packed.
const WASTE: usize = 2;

/// A place in the list.
#[derive(Clone, Copy)]
struct Place {
    next: u32,
    previous: u32,
    birth: u32,
    /// Where its parameters begin.
    parameters: u32,
    /// The step that last found it active.
    woken: u32,
    symbol: Symbol,
}

/// A string as a list, with those modules that the next step may rewrite.
pub(crate) struct Chain<'g> {
    grammar: &'g Grammar,
    places: Vec<Place>,
    parameters: Vec<f64>,
    /// In the string's order.
    active: Vec<u32>,
    /// Modules in the list.
    live: usize,
    /// Modules to the left and to the right that a production reads.
    reach: (usize, usize),
    /// The largest birth.
    newest: u32,
}

/// A step could not be made this way; nothing was changed.
pub(crate) struct Unfit;

impl From<DeriveError> for Unfit {
    fn from(_: DeriveError) -> Self {
        Self
    }
}

impl<'g> Chain<'g> {
    /// The list of a string, all of it active; `None` where the grammar is not one of those.
    pub(crate) fn new(grammar: &'g Grammar, string: &ModuleString) -> Option<Self> {
        if !Self::fits(grammar) || string.len() > LONG {
            return None;
        }
        let reads = |side: fn(&Rule) -> usize| grammar.rules.rules.iter().map(side).max();
        let mut chain = Self {
            grammar,
            places: Vec::new(),
            parameters: Vec::new(),
            active: Vec::new(),
            live: 0,
            reach: (
                reads(|rule| rule.left.len()).unwrap_or(0),
                reads(|rule| rule.right.len()).unwrap_or(0),
            ),
            newest: string.births().max().unwrap_or(0),
        };
        chain.places.push(Place {
            next: ENDS,
            previous: ENDS,
            birth: 0,
            parameters: 0,
            woken: 0,
            symbol: SEAM,
        });
        let mut last = ENDS;
        for module in string.iter() {
            last = chain.insert(last, module.symbol, module.birth, module.parameters)?;
            if chain.is_rewritten(module.symbol) {
                chain.active.push(last);
            }
        }
        Some(chain)
    }

    /// [`Self::new`] for an axiom; `None`, too, where the list would be busy at once.
    pub(crate) fn start(grammar: &'g Grammar, axiom: &ModuleString) -> Option<Self> {
        if !Self::fits(grammar) || axiom.len() > LONG {
            return None;
        }
        let is_active: Vec<bool> = grammar
            .rules
            .by_symbol
            .iter()
            .map(|rules| !rules.is_empty())
            .collect();
        let active = |symbol: usize| is_active.get(symbol) == Some(&true);
        let active = for_width!(&axiom.symbols, symbols => symbols.iter().filter(|s| active(s.index())).count());
        let is_busy = axiom.len() > SHORT && active > axiom.len() / RESTING;
        if is_busy {
            None
        } else {
            Self::new(grammar, axiom)
        }
    }

    /// Whether contexts are plain neighbours and nothing is drawn by chance, cut or asked of the turtle.
    fn fits(grammar: &Grammar) -> bool {
        let plain = grammar.literal
            || !grammar.rules.has_context
            || grammar.roles.iter().all(|role| *role == Role::Module);
        let drawn = grammar.rules.draws() || grammar.decompose.as_ref().is_some_and(RuleSet::draws);
        plain && !drawn && !grammar.roles.contains(&Role::Cut) && !grammar.has_queries
    }

    /// Whether too little of the string rests for the list to pay, or it is too long.
    pub(crate) fn is_busy(&self) -> bool {
        let busy = self.live > SHORT && self.active.len() > self.live / RESTING;
        busy || self.live > LONG
    }

    /// Whether the list would pay for a string of so many modules, of which the last step rewrote so many. Half of what would make
    /// it busy, so that it is not made in vain.
    pub(crate) fn would_pay(modules: usize, rewritten: usize) -> bool {
        (SHORT..LONG).contains(&modules) && rewritten < modules / (2 * RESTING * WOKEN)
    }

    /// Whether no further step would change anything.
    pub(crate) fn rests(&self) -> bool {
        self.active.is_empty()
    }

    /// The string.
    pub(crate) fn string(&self) -> ModuleString {
        let axiom = &self.grammar.axiom;
        let mut string = ModuleString::up_to(axiom.symbols.most(), self.newest, &axiom.arity);
        let mut at = self.next(ENDS);
        while let Some(place) = self.module(at) {
            string.push(&Module {
                symbol: place.symbol,
                birth: place.birth,
                parameters: self.own(at),
            });
            at = place.next;
        }
        string
    }

    /// Makes one step.
    pub(crate) fn step(
        &mut self,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<(), Unfit> {
        if cancel.load(Ordering::Relaxed) {
            return Err(Unfit);
        }
        let round = productions(self.grammar, step, limits, cancel);
        let (rewritten, successors) = self.successors(&round)?;
        if rewritten.is_empty() {
            self.active.clear();
            return Ok(());
        }
        let successors = decomposed(self.grammar, successors, step, limits, cancel)?;
        if !self.has_room(&successors, limits) {
            return Err(Unfit);
        }
        let changes = self.replace(&rewritten, &successors).ok_or(Unfit)?;
        self.newest = step;
        self.wake(&changes, step);
        if self.places.len() > WASTE * self.live.max(SHORT) {
            self.pack();
        }
        Ok(())
    }

    /// The modules that are rewritten, and their successors with a seam behind each.
    fn successors(&self, round: &Round<'_>) -> Result<(Vec<u32>, ModuleString), Unfit> {
        let mut work = Worker::new(round, self);
        let mut chosen: Vec<(u32, &Rule)> = Vec::new();
        for &at in &self.active {
            let Some(place) = self.module(at) else {
                continue;
            };
            let own = self.own(at);
            let choice = work.choose(place.symbol, at as usize, 0, own)?;
            if let Some(rule) = round.rule(choice) {
                chosen.push((at, rule));
            }
            if !work.matcher.go_on(1) {
                return Err(Unfit);
            }
        }
        let mut made = ModuleString::up_to(u32::from(SEAM), round.step, &self.grammar.arity);
        let mut written = Vec::new();
        let mut births: Vec<u32> = Vec::new();
        for &(at, rule) in &chosen {
            let Some(place) = self.module(at) else {
                continue;
            };
            let own = self.own(at);
            written.clear();
            written.resize(rule.arguments.len(), 0.0);
            work.evaluate(rule, at as usize, 0, own, &mut written)?;
            births.clear();
            births.resize(rule.successor.len(), 0);
            round.date(rule, own, place.birth, &written, &mut births);
            for (symbol, birth) in rule.successor.iter().zip(&births) {
                made.symbols.push(u32::from(*symbol));
                made.births.push(*birth);
            }
            made.parameters.extend(written.iter().copied());
            made.symbols.push(u32::from(SEAM));
            made.births.push(0);
        }
        let rewritten = chosen.into_iter().map(|(at, _)| at).collect();
        Ok((rewritten, made))
    }

    /// Whether the limits allow the list with these modules in it.
    fn has_room(&self, more: &ModuleString, limits: &Limits) -> bool {
        let places = (self.places.len() + more.len()) as u64;
        let values = (self.parameters.len() + more.parameters.len()) as u64;
        let bytes = places * size_of::<Place>() as u64 + values * size_of::<f64>() as u64;
        let numbers = u64::from(u32::MAX);
        places.max(values) < numbers
            && (self.live + more.len()) as u64 <= limits.modules
            && bytes <= limits.bytes
    }

    /// Puts the successors in the places of the rewritten modules. Gives for each the place before its successor and
    /// the last of it (the same where it is empty).
    fn replace(&mut self, rewritten: &[u32], successors: &ModuleString) -> Option<Vec<(u32, u32)>> {
        let mut changes = Vec::with_capacity(rewritten.len());
        let mut modules = successors.iter();
        for &at in rewritten {
            let before = self.remove(at)?;
            let mut last = before;
            for module in modules.by_ref().take_while(|m| m.symbol != SEAM) {
                last = self.insert(last, module.symbol, module.birth, module.parameters)?;
            }
            changes.push((before, last));
        }
        Some(changes)
    }

    /// Finds the modules that the next step may rewrite: the new ones and those whose contexts reach a change.
    fn wake(&mut self, changes: &[(u32, u32)], step: u32) {
        let (left, right) = self.reach;
        self.active.clear();
        for &(before, last) in changes {
            let mut at = self.next(before);
            let after_new = self.next(last);
            // What stands before a change has it in its right context.
            let mut reader = before;
            for _ in 0..right {
                if reader == ENDS {
                    break;
                }
                at = reader;
                reader = self.previous(reader);
            }
            while at != after_new {
                self.wake_one(at, step);
                at = self.next(at);
            }
            for _ in 0..left {
                if at == ENDS {
                    break;
                }
                self.wake_one(at, step);
                at = self.next(at);
            }
        }
    }

    fn wake_one(&mut self, at: u32, step: u32) {
        let rewritten = self
            .module(at)
            .is_some_and(|place| self.is_rewritten(place.symbol));
        if let Some(place) = self.places.get_mut(at as usize)
            && rewritten
            && place.woken != step
        {
            place.woken = step;
            self.active.push(at);
        }
    }

    /// Drops the places that are no longer in the list.
    fn pack(&mut self) {
        let mut moved = vec![ENDS; self.places.len()];
        let mut places = Vec::with_capacity(self.live + 1);
        let mut parameters = Vec::new();
        let mut at = ENDS;
        while let Some(place) = self.places.get(at as usize) {
            // No more places than before, whose numbers fit.
            let here = u32::try_from(places.len()).unwrap_or(u32::MAX);
            let start = u32::try_from(parameters.len()).unwrap_or(u32::MAX);
            parameters.extend_from_slice(self.own(at));
            places.push(Place {
                previous: here.saturating_sub(1),
                next: here.saturating_add(1),
                parameters: start,
                ..*place
            });
            if let Some(new) = moved.get_mut(at as usize) {
                *new = here;
            }
            at = place.next;
            if at == ENDS {
                break;
            }
        }
        let last = u32::try_from(places.len().saturating_sub(1)).unwrap_or(u32::MAX);
        if let Some(place) = places.last_mut() {
            place.next = ENDS;
        }
        if let Some(ends) = places.first_mut() {
            ends.previous = last;
        }
        for at in &mut self.active {
            *at = moved.get(*at as usize).copied().unwrap_or(ENDS);
        }
        self.places = places;
        self.parameters = parameters;
    }

    /// Puts a module behind the place `before`; gives its own.
    fn insert(
        &mut self,
        before: u32,
        symbol: Symbol,
        birth: u32,
        parameters: &[f64],
    ) -> Option<u32> {
        let at = u32::try_from(self.places.len()).ok()?;
        let next = self.next(before);
        self.places.push(Place {
            next,
            previous: before,
            birth,
            parameters: u32::try_from(self.parameters.len()).ok()?,
            woken: 0,
            symbol,
        });
        self.parameters.extend_from_slice(parameters);
        self.places.get_mut(before as usize)?.next = at;
        self.places.get_mut(next as usize)?.previous = at;
        self.live += 1;
        Some(at)
    }

    /// Takes a module out of the list; gives the place before it.
    fn remove(&mut self, at: u32) -> Option<u32> {
        let Place { next, previous, .. } = *self.module(at)?;
        self.places.get_mut(previous as usize)?.next = next;
        self.places.get_mut(next as usize)?.previous = previous;
        self.live -= 1;
        Some(previous)
    }

    /// The module at a place; `None` at the ends.
    fn module(&self, at: u32) -> Option<&Place> {
        self.places
            .get(at as usize)
            .filter(|place| place.symbol != SEAM)
    }

    /// The parameters of the module at a place.
    fn own(&self, at: u32) -> &[f64] {
        let symbol = self.module(at).map_or(SEAM, |place| place.symbol);
        Modules::parameters(self, at as usize, symbol, Base::default())
    }

    fn next(&self, at: u32) -> u32 {
        self.places.get(at as usize).map_or(ENDS, |p| p.next)
    }

    fn previous(&self, at: u32) -> u32 {
        self.places.get(at as usize).map_or(ENDS, |p| p.previous)
    }

    fn is_rewritten(&self, symbol: Symbol) -> bool {
        let productions = self.grammar.rules.by_symbol.get(usize::from(symbol));
        productions.is_some_and(|rules| !rules.is_empty())
    }
}

impl Modules for Chain<'_> {
    fn symbol(&self, at: usize) -> Option<Symbol> {
        // The seam is no production's module, so no context goes on past the ends.
        self.places.get(at).map(|place| place.symbol)
    }

    fn left(&self, at: usize) -> Option<usize> {
        self.places.get(at).map(|place| place.previous as usize)
    }

    fn right(&self, at: usize) -> Option<usize> {
        self.places.get(at).map(|place| place.next as usize)
    }

    /// Plain neighbours never step over a branch.
    fn partner(&self, at: usize) -> usize {
        at
    }

    fn parameters(&self, at: usize, symbol: Symbol, _base: Base) -> &[f64] {
        let arity = self.grammar.arity.get(usize::from(symbol));
        let from = self.places.get(at).map_or(0, |p| p.parameters as usize);
        let to = from + arity.map_or(0, |a| usize::from(*a));
        self.parameters.get(from..to).unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    const PLANT: &str = "context literal\naxiom A(0) B\nA(x) > B -> A(x) A(x+1)\n\
                         A(x) > A(y) : y % 50 == 0 -> A(x) [ +(y) A(0) B ]\n";

    fn chain_after(grammar: &Grammar, steps: u32) -> Chain<'_> {
        let mut chain = Chain::new(grammar, &grammar.axiom).unwrap();
        for step in 1..=steps {
            let made = chain.step(step, &Limits::default(), &AtomicBool::new(false));
            assert!(made.is_ok() && !chain.is_busy(), "step {step}");
        }
        chain
    }

    #[test]
    fn a_tall_plant_is_visited_at_its_ends() {
        let grammar = Grammar::parse(PLANT, "plant").unwrap();
        let chain = chain_after(&grammar, 400);
        let string = chain.string();
        let ends = string.symbols().filter(|s| grammar.name(*s) == "B");
        // An end, what grew there and what stands before it; the end itself has no production.
        assert!(chain.active.len() <= 3 * ends.count());
        assert!(chain.live > 5_000 && chain.places.len() <= WASTE * chain.live);
    }

    #[test]
    fn places_are_packed() {
        let grammar = Grammar::parse("axiom A(0) F A(1)\nA(x) -> A(x+1)\n", "counter").unwrap();
        let chain = chain_after(&grammar, 100_000);
        assert_eq!(chain.string().to_text(&grammar), "A(100000)FA(100001)");
        assert!(
            chain.places.len() <= WASTE * SHORT + 8 && chain.parameters.len() <= WASTE * SHORT + 8
        );
    }

    #[test]
    fn what_it_is_not_for() {
        for text in [
            "axiom A[B]\nA < B -> A\n",
            "axiom A\nA -> A%\n",
            "axiom A\nA : weight 1 -> A\n",
            "axiom A\nA -> A(uniform(0,1))\n",
            "axiom A\nA -> A\ndecompose {\nA -> B(normal(0,1))\n}\n",
        ] {
            let grammar = Grammar::parse(text, "other").unwrap();
            assert!(Chain::new(&grammar, &grammar.axiom).is_none(), "{text}");
        }
    }

    #[test]
    fn a_step_that_cannot_be_made_changes_nothing() {
        let grammar = Grammar::parse("axiom A(3) F\nA(x) -> A(x-1) F(6/x)\n", "fault").unwrap();
        let mut chain = chain_after(&grammar, 3);
        let before = chain.string();
        for _ in 0..2 {
            assert!(
                chain
                    .step(4, &Limits::default(), &AtomicBool::new(false))
                    .is_err()
            );
            assert_eq!(chain.string(), before);
        }
        let cancelled = chain.step(4, &Limits::default(), &AtomicBool::new(true));
        assert!(cancelled.is_err());
    }
}
