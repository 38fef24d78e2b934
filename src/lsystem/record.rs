//! One step with a record of it: which production rewrote each module, and where in the next string its successor stands.
//!
//! The string comes from the same rounds as every derivation ([`super::rewrite`]), which leave the choices they made; the
//! record is worked out from these and from the lengths of successors, round by round. So it costs a few bytes a module and
//! no derivation keeps one unless it is asked for: it serves explanations and drawings between two steps.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use super::choices::Choices;
use super::derive::{self, Limits};
use super::error::{DeriveError, DeriveProblem};
use super::grammar::{Grammar, RuleSet};
use super::output::Spare;
use super::query::answered;
use super::string::ModuleString;

/// A step as it was made.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// The string after the step.
    pub string: ModuleString,
    /// For each module of the string before, its production's number from 1; 0: it stays.
    choices: Choices,
    /// Where in `string` the successor of each module of the string before begins, and after them its end.
    starts: Vec<u32>,
    /// How often each production of the `decompose` block applied.
    pub(super) decomposed: Vec<u64>,
}

impl Recorded {
    /// Bytes of the places where successors begin in the record of a string's next step.
    pub(super) fn starts_bytes(before: &ModuleString) -> u64 {
        (before.len() as u64 + 1).saturating_mul(size_of::<u32>() as u64)
    }

    /// Bytes that it takes besides its string.
    pub(super) fn bytes(&self) -> u64 {
        self.choices.bytes() + (self.starts.len() * size_of::<u32>()) as u64
    }

    /// Modules of the string before the step.
    #[must_use]
    pub fn len(&self) -> usize {
        self.choices.len()
    }

    /// Whether the string before the step was empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.choices.len() == 0
    }

    /// The production that rewrote the module at `position` of the string before, as its index in
    /// [`Grammar::productions`]; `None`: it stays as it is.
    #[must_use]
    pub fn production(&self, position: usize) -> Option<usize> {
        usize::from(self.choices.get(position)?).checked_sub(1)
    }

    /// Where in [`Self::string`] the successor of the module at `position` stands, decomposed and cut. The ranges of all
    /// modules in their order cover the string without gaps.
    #[must_use]
    pub fn successor(&self, position: usize) -> Range<usize> {
        let place = |at: usize| self.starts.get(at).map_or(0, |start| *start as usize);
        place(position)..place(position.saturating_add(1))
    }
}

/// Makes the step `step` from the string before it, with its record.
pub(crate) fn recorded(
    grammar: &Grammar,
    string: &ModuleString,
    step: u32,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<Recorded, DeriveError> {
    let mut spare = Spare::default();
    let round = derive::productions(grammar, step, limits, cancel);
    let following = match round.apply(string, &mut spare)? {
        Some(following) => following,
        None => string.clone(),
    };
    let choices = std::mem::take(&mut spare.choices);
    let mut places = starts(&grammar.rules, &choices, step)?;
    let mut decomposed = vec![0; grammar.decompose.as_ref().map_or(0, |set| set.rules.len())];
    let mut watch = |rules: &RuleSet, choices: &Choices| {
        for choice in choices.iter() {
            let production = usize::from(choice).checked_sub(1);
            if let Some(count) = production.and_then(|at| decomposed.get_mut(at)) {
                *count += 1;
            }
        }
        follow(&mut places, &starts(rules, choices, step)?);
        Ok(())
    };
    let following =
        derive::decomposed_watched(grammar, following, step, limits, cancel, &mut watch)?;
    if derive::has_cut(grammar, &following) {
        let mut kept = 0;
        let before = derive::kept_by_cuts(grammar, &following).map(|keep| {
            let place = kept;
            kept += u32::from(keep);
            place
        });
        let mut moved: Vec<u32> = before.collect();
        moved.push(kept);
        follow(&mut places, &moved);
    }
    let string = derive::cut_owned(grammar, following);
    Ok(Recorded {
        string: answered(grammar, string, &mut spare.answers, limits, cancel)?,
        choices,
        starts: places,
        decomposed,
    })
}

/// Where the successor of each module begins, and the length of them all.
fn starts(rules: &RuleSet, choices: &Choices, step: u32) -> Result<Vec<u32>, DeriveError> {
    let mut starts = Vec::new();
    let bytes = 4 * choices.len() as u64;
    starts
        .try_reserve_exact(choices.len() + 1)
        .map_err(|_| DeriveProblem::Memory { step, bytes })?;
    let mut at = 0_usize;
    // A string has fewer than 2^32 modules: the round has checked it.
    let narrow = |at: usize| u32::try_from(at).unwrap_or(u32::MAX);
    for choice in choices.iter() {
        starts.push(narrow(at));
        at += usize::from(choice)
            .checked_sub(1)
            .and_then(|number| rules.rules.get(number))
            .map_or(1, |rule| rule.successor.len());
    }
    starts.push(narrow(at));
    Ok(starts)
}

/// Moves places on by a further round.
fn follow(places: &mut [u32], moved: &[u32]) {
    for place in places {
        *place = moved.get(*place as usize).copied().unwrap_or(*place);
    }
}
