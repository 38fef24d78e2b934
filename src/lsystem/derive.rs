//! Derivation: step after step, each a few rounds of [`super::rewrite`].
//!
//! A step is: one round of the productions, rounds of decomposition until nothing changes, then cut what `%` cuts. So the
//! string never holds a `%` where it is read or where the next step begins.
//!
//! Two others give the same result sooner where they can: [`super::blocks`] where each module develops alone and many alike,
//! [`super::active`] where most of the string rests.

use std::sync::atomic::{AtomicBool, Ordering};

use super::active::Chain;
use super::blocks::{Blocks, Size};
use super::choices::Choices;
use super::column::bytes_up_to;
use super::endless::cycle;
use super::error::{DeriveError, DeriveProblem, Limit};
use super::grammar::{Grammar, Role, Rule, RuleSet};
use super::names::Symbol;
use super::output::Spare;
use super::query::{Memory, answered};
use super::rewrite::{Births, Round};
use super::string::{ModuleString, string_bytes};

/// How large a derivation may become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Modules of a string. At most 2^32 − 1 are possible.
    pub modules: u64,
    /// Bytes of two successive strings and the index between them.
    pub bytes: u64,
}

/// A string of so many modules is made again to be kept, where a larger one is cancelled or passes a limit: a matter of
/// milliseconds.
const QUICK_MODULES: u128 = 1 << 21;
/// So is a graph of so many pieces.
const QUICK_PIECES: usize = 1 << 16;

impl Default for Limits {
    /// 2^31 modules in 4 GiB.
    fn default() -> Self {
        Self {
            modules: 1 << 31,
            bytes: 4 << 30,
        }
    }
}

pub(crate) fn derive(
    grammar: &Grammar,
    steps: u32,
    limits: &Limits,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(u32),
) -> Result<ModuleString, DeriveError> {
    derive_on(grammar, None, steps, limits, cancel, progress, None)
}

/// The string of step 0.
fn start(
    grammar: &Grammar,
    spare: &mut Spare,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    let string = cut(grammar, &grammar.axiom);
    if let Some(problem) = past(grammar, Size::of(&string), 0, limits) {
        return Err(problem.into());
    }
    let string = cut_owned(grammar, decomposed(grammar, string, 0, limits, cancel)?);
    answered(grammar, string, &mut spare.answers, limits, cancel)
}

/// Where a list becomes a string before the last step, to be shown: the last few.
const SHOWN_OF_LIST: u32 = 4;

/// Is shown strings and their steps.
pub(super) type See<'s> = dyn FnMut(u32, &ModuleString) + 's;

/// [`derive`] from a string on, whose step is given, or else from the axiom. Shows `see` the strings on the way that are made as such.
pub(super) fn derive_on(
    grammar: &Grammar,
    from: Option<(u32, &ModuleString)>,
    steps: u32,
    limits: &Limits,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(u32),
    mut see: Option<&mut See<'_>>,
) -> Result<ModuleString, DeriveError> {
    let mut spare = Spare {
        answers: Memory::of_several(),
        ..Spare::default()
    };
    let (first, mut string) = match from {
        Some((step, string)) => (step, string.clone()),
        None => (0, start(grammar, &mut spare, limits, cancel)?),
    };
    if steps > first
        && let Ok(graph) = Blocks::new(grammar, steps, limits, cancel, |step, size| {
            past(grammar, size, step, limits).is_some()
        })
    {
        return by_blocks(grammar, &graph, steps, limits, cancel);
    }
    let mut chain = Chain::start(grammar, &string);
    for step in first + 1..=steps {
        progress(step - 1);
        if let Some(list) = &mut chain {
            if list.rests() {
                break;
            }
            let made = list.step(step, limits, cancel).is_ok();
            if made && !list.is_busy() {
                if let Some(see) = &mut see
                    && steps - step < SHOWN_OF_LIST
                {
                    see(step, &list.string());
                }
                continue;
            }
            // Where it could not be made, the rounds find the same fault and say where it is.
            string = list.string();
            chain = None;
            if made {
                if let Some(see) = &mut see {
                    see(step, &string);
                }
                continue;
            }
        }
        match next(grammar, &string, step, &mut spare, limits, cancel) {
            Ok(following) => {
                spare.string = std::mem::replace(&mut string, following);
                if let Some(see) = &mut see {
                    see(step, &string);
                }
                if Chain::would_pay(string.len(), spare.rewritten) {
                    chain = Chain::new(grammar, &string);
                }
            }
            Err(mut error) => {
                error.last = Some(Box::new((step - 1, string)));
                return Err(error);
            }
        }
    }
    Ok(chain.map_or(string, |list| list.string()))
}

/// The string of a graph. Its sizes are known before anything of it is written.
fn by_blocks(
    grammar: &Grammar,
    graph: &Blocks,
    steps: u32,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    let too_large = (1..=steps)
        .take(graph.steps())
        .find_map(|step| Some((step, past(grammar, graph.size(step), step, limits)?)));
    let (kept, problem) = match too_large {
        Some((step, problem)) => (kept_before(graph, step), problem),
        None => match graph.string(cancel) {
            Some(string) => return Ok(string),
            None if cancel.load(Ordering::Relaxed) => {
                let kept = kept_before(graph, steps);
                (kept, DeriveProblem::Cancelled { step: kept + 1 })
            }
            None => {
                let bytes = bytes_of(grammar, graph.size(steps), steps);
                let problem = DeriveProblem::Memory { step: steps, bytes };
                (kept_before(graph, steps), problem)
            }
        },
    };
    let mut error = DeriveError::from(problem);
    let go_on = AtomicBool::new(false);
    error.last = Blocks::new(grammar, kept, limits, &go_on, |_, _| false)
        .ok()
        .and_then(|graph| graph.string(&go_on))
        .map(|string| Box::new((kept, string)));
    Err(error)
}

/// The last step before this one whose string is soon made, and the graph of it.
fn kept_before(graph: &Blocks, step: u32) -> u32 {
    let quick = |step: &u32| {
        graph.size(*step).modules <= QUICK_MODULES && graph.pieces_at(*step) <= QUICK_PIECES
    };
    // From its end on, the graph's string stays as it is.
    let end = u32::try_from(graph.steps()).unwrap_or(u32::MAX);
    (0..step.min(end.saturating_add(1)))
        .rev()
        .find(quick)
        .unwrap_or(0)
}

/// Bytes of a string of this size after a step.
fn bytes_of(grammar: &Grammar, size: Size, step: u32) -> u64 {
    let number = |n: u128| u64::try_from(n).unwrap_or(u64::MAX);
    let module = grammar.axiom.symbols.cell_bytes() + bytes_up_to(step);
    string_bytes(module, number(size.modules), number(size.parameters))
}

/// What is wrong with a string of this size.
pub(super) fn past(
    grammar: &Grammar,
    size: Size,
    step: u32,
    limits: &Limits,
) -> Option<DeriveProblem> {
    let modules = u64::try_from(size.modules).unwrap_or(u64::MAX);
    let bytes = bytes_of(grammar, size, step);
    let most = limits.modules.min(u64::from(u32::MAX));
    let limit = if modules > most {
        Limit::Modules(most)
    } else if bytes > limits.bytes {
        Limit::Bytes(limits.bytes)
    } else {
        return None;
    };
    Some(DeriveProblem::Limit {
        step,
        modules,
        bytes,
        limit,
    })
}

/// One step, whose number is `step`.
pub(crate) fn next(
    grammar: &Grammar,
    string: &ModuleString,
    step: u32,
    spare: &mut Spare,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    if cancel.load(Ordering::Relaxed) {
        return Err(DeriveProblem::Cancelled { step }.into());
    }
    let round = productions(grammar, step, limits, cancel);
    let following = match round.apply(string, spare)? {
        Some(following) => following,
        None => string.clone(),
    };
    let following = decomposed(grammar, following, step, limits, cancel)?;
    let following = cut_owned(grammar, following);
    answered(grammar, following, &mut spare.answers, limits, cancel)
}

/// The round of the productions.
pub(crate) fn productions<'a>(
    grammar: &'a Grammar,
    step: u32,
    limits: &'a Limits,
    cancel: &'a AtomicBool,
) -> Round<'a> {
    Round {
        grammar,
        rules: &grammar.rules,
        step,
        stream: step,
        number: 0,
        births: Births::Step,
        limits,
        cancel,
    }
}

/// The string with the decomposition productions applied until nothing changes.
pub(crate) fn decomposed(
    grammar: &Grammar,
    string: ModuleString,
    step: u32,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    decomposed_watched(grammar, string, step, limits, cancel, &mut |_, _| Ok(()))
}

/// Is shown the productions of a round that changed something, and the choices that it made.
pub(super) type Watch<'w> = dyn FnMut(&RuleSet, &Choices) -> Result<(), DeriveError> + 'w;

/// The same, round by round before the eyes of `watch`.
pub(super) fn decomposed_watched(
    grammar: &Grammar,
    mut string: ModuleString,
    step: u32,
    limits: &Limits,
    cancel: &AtomicBool,
    watch: &mut Watch<'_>,
) -> Result<ModuleString, DeriveError> {
    let Some(rules) = &grammar.decompose else {
        return Ok(string);
    };
    let endless = &grammar.endless;
    let goes_on = |s: &Symbol| endless.get(usize::from(*s)) == Some(&true);
    if !endless.is_empty()
        && let Some(symbol) = string.symbols().find(goes_on)
        && let Some(rule) = cycle(rules, endless, symbol)
    {
        return Err(not_ended(grammar, rule, step).into());
    }
    let mut spare = Spare::default();
    for number in 1..=grammar.decompose_depth.saturating_add(1) {
        let round = Round {
            grammar,
            rules,
            step,
            stream: step,
            number,
            births: Births::Step,
            limits,
            cancel,
        };
        if !rules.may_rewrite(&string.symbols) {
            break;
        }
        if number > grammar.decompose_depth {
            let Some(rule) = round.first_applied(&string)? else {
                return Ok(string);
            };
            return Err(not_ended(grammar, rule, step).into());
        }
        let made = round.apply(&string, &mut spare);
        match made.map_err(|error| too_large(&round, &spare.choices, error))? {
            Some(following) => spare.string = std::mem::replace(&mut string, following),
            None => break,
        }
        watch(rules, &spare.choices)?;
    }
    Ok(string)
}

/// A decomposition that goes on by this production.
fn not_ended(grammar: &Grammar, rule: &Rule, step: u32) -> DeriveProblem {
    DeriveProblem::Decomposition {
        step,
        depth: grammar.decompose_depth,
        production: rule.text.clone(),
        location: rule.location.clone(),
    }
}

/// Where a round of decomposition passes a limit: which production made it so large.
fn too_large(round: &Round<'_>, choices: &Choices, error: DeriveError) -> DeriveError {
    match (*error.problem, choices.iter().find_map(|c| round.rule(c))) {
        (DeriveProblem::Limit { limit, .. }, Some(rule)) => {
            let (step, round) = (round.step, round.number);
            DeriveProblem::DecompositionLimit {
                step,
                round,
                limit,
                production: rule.text.clone(),
                location: rule.location.clone(),
            }
            .into()
        }
        (problem, _) => problem.into(),
    }
}

/// The round of the interpretation, which draws from a stream of its own.
pub(super) fn interpretation<'a>(
    grammar: &'a Grammar,
    step: u32,
    limits: &'a Limits,
    cancel: &'a AtomicBool,
) -> Option<Round<'a>> {
    Some(Round {
        grammar,
        rules: grammar.interpret.as_ref()?,
        step,
        stream: u32::MAX,
        number: 1,
        births: Births::Inherit,
        limits,
        cancel,
    })
}

/// What the turtle is shown: the interpretation productions applied, the string itself unchanged (`None`: it is shown as it is).
pub(crate) fn interpreted(
    grammar: &Grammar,
    string: &ModuleString,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<Option<ModuleString>, DeriveError> {
    let step = string.births().max().unwrap_or(0);
    let Some(mut round) = interpretation(grammar, step, limits, cancel) else {
        return Ok(None);
    };
    let mut shown: Option<ModuleString> = None;
    for number in 1..=grammar.interpret_depth {
        round.number = number;
        match round.apply(shown.as_ref().unwrap_or(string), &mut Spare::default())? {
            Some(following) => shown = Some(following),
            None => break,
        }
    }
    Ok(shown.map(|s| cut_owned(grammar, s)))
}

pub(super) fn cut_owned(grammar: &Grammar, string: ModuleString) -> ModuleString {
    if has_cut(grammar, &string) {
        cut(grammar, &string)
    } else {
        string
    }
}

pub(super) fn has_cut(grammar: &Grammar, string: &ModuleString) -> bool {
    grammar.roles.contains(&Role::Cut) && string.symbols().any(|s| grammar.role(s) == Role::Cut)
}

/// The string without each `%` and what follows it in its branch.
fn cut(grammar: &Grammar, string: &ModuleString) -> ModuleString {
    if !has_cut(grammar, string) {
        return string.clone();
    }
    let mut kept = string.empty_like();
    for (module, keep) in string.iter().zip(kept_by_cuts(grammar, string)) {
        if keep {
            kept.push(&module);
        }
    }
    kept
}

/// For each module whether it stays when each `%` takes what follows it in its branch.
pub(super) fn kept_by_cuts<'s>(
    grammar: &'s Grammar,
    string: &'s ModuleString,
) -> impl Iterator<Item = bool> + 's {
    // While cutting: branches open since the `%`.
    let mut cutting: Option<usize> = None;
    string.iter().map(move |module| {
        match (cutting, grammar.role(module.symbol)) {
            (None, Role::Cut) => cutting = Some(0),
            (Some(depth), Role::Open) => cutting = Some(depth + 1),
            (Some(0), Role::Close) => cutting = None,
            (Some(depth), Role::Close) => cutting = Some(depth - 1),
            _ => {}
        }
        cutting.is_none()
    })
}
