//! What becomes of one module: which production applies, and the parameters of its successor.

use super::chances::{BITS, Bound};
use super::context::{Base, Matcher, Modules, bind};
use super::error::{DeriveError, ValueProblem};
use super::grammar::{Near, Order, Rule};
use super::names::Symbol;
use super::random::{Draws, PassKey};
use super::rewrite::{Round, STAYS};

/// Draws of a rewritten module: one stream for the choice of a production, another for its parameters.
const CHOICE_STREAM: u32 = 1 << 31;

/// What one thread needs for a stretch of the string.
pub(super) struct Worker<'r, 'a, M> {
    round: &'r Round<'a>,
    pub(super) matcher: Matcher<'r, M>,
    pub(super) key: PassKey,
    pub(super) choice_key: PassKey,
    /// Parameters bound by the production that is tried.
    pub(super) bound: Vec<f64>,
    /// Productions that matched, with their weights.
    pub(super) drawn: Vec<(u16, f64)>,
}

impl<'r, 'a, M: Modules> Worker<'r, 'a, M> {
    pub(super) fn new(round: &'r Round<'a>, modules: &'r M) -> Self {
        let slots = round.rules.rules.iter().map(|r| r.slots).max().unwrap_or(0);
        Self {
            round,
            matcher: Matcher::new(round.grammar, modules, round.cancel),
            key: PassKey::new(round.grammar.seed, round.stream, round.number),
            choice_key: PassKey::new(
                round.grammar.seed,
                round.stream,
                round.number | CHOICE_STREAM,
            ),
            bound: vec![0.0; slots],
            drawn: Vec::new(),
        }
    }

    /// The productions with weights that matched the module of the last [`Self::choose`], numbered from 1.
    pub(super) fn drawn(&self) -> &[(u16, f64)] {
        &self.drawn
    }

    fn bind_own(&mut self, own: &[f64]) {
        bind(&mut self.bound, 0, own);
    }

    /// The production for a module: its number, or `STAYS`.
    #[inline]
    pub(super) fn choose(
        &mut self,
        symbol: Symbol,
        at: usize,
        offset: usize,
        own: &[f64],
    ) -> Result<u16, DeriveError> {
        let round = self.round;
        self.matcher.base = Base { at, offset };
        let Some(candidates) = round.rules.by_symbol.get(usize::from(symbol)) else {
            return Ok(STAYS);
        };
        let mut rank = None;
        self.drawn.clear();
        self.bind_own(own);
        for number in candidates {
            let Some(rule) = round.rules.rules.get(usize::from(*number)) else {
                continue;
            };
            let choice = number + 1;
            if rule.unconditional() && rank.is_none() {
                return Ok(choice);
            }
            if let Some(rank) = rank {
                // A production with a weight was found: only its equals are of interest now.
                if rule.weight.is_none() {
                    continue;
                }
                if round.rules.order == Order::Specific && rule.rank() != rank {
                    break;
                }
            }
            if rule.has_context() && !self.matcher.matches(rule, at, &mut self.bound) {
                if self.matcher.cancelled {
                    return Err(round.cancelled());
                }
                continue;
            }
            let mut draws = self.choice_key.at(at);
            if let Some(condition) = &rule.condition {
                let holds = condition
                    .value(&self.bound, &mut draws)
                    .map_err(|problem| round.failed(rule, at, problem))?;
                if holds == 0.0 {
                    continue;
                }
            }
            let Some(weight) = &rule.weight else {
                return Ok(choice);
            };
            let weight = weight
                .finite(&self.bound, &mut draws)
                .map_err(|problem| round.failed(rule, at, problem))?;
            if weight < 0.0 {
                return Err(round.failed(rule, at, ValueProblem::BadWeight));
            }
            rank.get_or_insert(rule.rank());
            self.drawn.push((choice, weight));
        }
        self.draw(at)
    }

    /// One of the weighted productions.
    pub(super) fn draw(&mut self, at: usize) -> Result<u16, DeriveError> {
        let Some((first, _)) = self.drawn.first().copied() else {
            return Ok(STAYS);
        };
        let total: f64 = self.drawn.iter().map(|d| d.1).sum();
        if total.partial_cmp(&0.0) != Some(std::cmp::Ordering::Greater) || !total.is_finite() {
            let round = self.round;
            return round.rule(first).map_or(Ok(STAYS), |rule| {
                Err(round.failed(rule, at, ValueProblem::BadWeight))
            });
        }
        let drawn = self.choice_key.choice(at) as f64 / (1_u64 << BITS) as f64;
        let mut left = drawn * total;
        let mut chosen = STAYS;
        for (choice, weight) in &self.drawn {
            if *weight > 0.0 {
                chosen = *choice; // the last one takes what rounding leaves
                if left < *weight {
                    break;
                }
            }
            left -= weight;
        }
        Ok(chosen)
    }

    /// The choice that a draw means, of those that are known beforehand: without a branch, which would be guessed wrong.
    #[inline]
    pub(super) fn pick(&self, weighted: &[Bound], at: usize) -> u16 {
        let drawn = self.choice_key.choice(at);
        let passed = |one: &Bound| usize::from(drawn >= one.1);
        let index: usize = weighted.iter().map(passed).sum();
        weighted.get(index).map_or(STAYS, |one| one.0)
    }

    /// Computes the parameters of a successor.
    pub(super) fn evaluate(
        &mut self,
        rule: &Rule,
        at: usize,
        offset: usize,
        own: &[f64],
        out: &mut [f64],
    ) -> Result<(), DeriveError> {
        if rule.arguments.is_empty() {
            return Ok(());
        }
        self.matcher.base = Base { at, offset };
        self.bind_own(own);
        if rule.slots > own.len()
            && !self.matcher.matches(rule, at, &mut self.bound)
            && self.matcher.cancelled
        {
            return Err(self.round.cancelled());
        }
        let mut draws: Draws = self.key.at(at);
        for (argument, value) in rule.arguments.iter().zip(out) {
            *value = argument
                .finite(&self.bound, &mut draws)
                .map_err(|problem| self.round.failed(rule, at, problem))?;
        }
        Ok(())
    }
}

/// The production for a module whose neighbours decide.
#[inline]
pub(super) fn near(modules: &impl Modules, productions: &[Near], at: usize) -> u16 {
    let symbol = |place: Option<usize>| place.and_then(|place| modules.symbol(place));
    let (left, right) = (symbol(modules.left(at)), symbol(modules.right(at)));
    let fits = |wanted: Option<Symbol>, found| wanted.is_none() || wanted == found;
    productions
        .iter()
        .find(|near| fits(near.left, left) && fits(near.right, right))
        .map_or(STAYS, |near| near.number + 1)
}
