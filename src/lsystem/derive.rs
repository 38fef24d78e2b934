//! Derivation: step after step, each a few rounds of [`super::rewrite`].
//!
//! A step is: one round of the productions, rounds of decomposition until nothing changes, then cut what `%` cuts. So the
//! string never holds a `%` where it is read or where the next step begins.
//!
//! Where most of the string rests and the grammar allows it, [`super::active`] makes the steps instead, with the same result.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::active::Chain;
use super::error::{DeriveError, DeriveProblem};
use super::grammar::{Grammar, Role};
use super::rewrite::{Births, Round};
use super::string::ModuleString;

/// How large a derivation may become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Modules of a string. At most 2^32 − 1 are possible.
    pub modules: u64,
    /// Bytes of two successive strings and the index between them.
    pub bytes: u64,
}

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
) -> Result<ModuleString, DeriveError> {
    let mut string = cut(grammar, &grammar.axiom);
    check(&string, 0, limits)?;
    string = cut_owned(grammar, decomposed(grammar, string, 0, limits, cancel)?);
    let mut chain = Chain::new(grammar, &string);
    for step in 1..=steps {
        if let Some(list) = &mut chain {
            if list.rests() {
                break;
            }
            let made = list.step(step, limits, cancel).is_ok();
            if made && !list.is_busy() {
                continue;
            }
            // Where it could not be made, the rounds find the same fault and say where it is.
            string = list.string();
            chain = None;
            if made {
                continue;
            }
        }
        match next(grammar, &string, step, limits, cancel) {
            Ok(following) => string = following,
            Err(mut error) => {
                error.last = Some(Box::new((step - 1, string)));
                return Err(error);
            }
        }
    }
    Ok(chain.map_or(string, |list| list.string()))
}

/// One step, whose number is `step`.
pub(crate) fn next(
    grammar: &Grammar,
    string: &ModuleString,
    step: u32,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    if cancel.load(Ordering::Relaxed) {
        return Err(DeriveProblem::Cancelled { step }.into());
    }
    let round = productions(grammar, step, limits, cancel);
    let following = match round.apply(string)? {
        Some(following) => following,
        None => string.clone(),
    };
    let following = decomposed(grammar, following, step, limits, cancel)?;
    Ok(cut_owned(grammar, following))
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
    mut string: ModuleString,
    step: u32,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    let Some(rules) = &grammar.decompose else {
        return Ok(string);
    };
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
        if number > grammar.decompose_depth {
            let Some(rule) = round.first_applied(&string)? else {
                return Ok(string);
            };
            return Err(DeriveProblem::Decomposition {
                step,
                depth: grammar.decompose_depth,
                production: rule.text.clone(),
                location: rule.location.clone(),
            }
            .into());
        }
        match round.apply(&string)? {
            Some(following) => string = following,
            None => break,
        }
    }
    Ok(string)
}

/// What the turtle is shown: the interpretation productions applied, the string itself unchanged (`None`: it is shown as it is).
pub(crate) fn interpreted(
    grammar: &Grammar,
    string: &ModuleString,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<Option<ModuleString>, DeriveError> {
    let Some(rules) = &grammar.interpret else {
        return Ok(None);
    };
    let step = string.births.iter().copied().max().unwrap_or(0);
    let mut shown: Option<ModuleString> = None;
    for number in 1..=grammar.interpret_depth {
        // Interpretation draws from a stream of its own.
        let round = Round {
            grammar,
            rules,
            step,
            stream: u32::MAX,
            number,
            births: Births::Inherit,
            limits,
            cancel,
        };
        match round.apply(shown.as_ref().unwrap_or(string))? {
            Some(following) => shown = Some(following),
            None => break,
        }
    }
    Ok(shown.map(|s| cut_owned(grammar, s)))
}

fn check(string: &ModuleString, step: u32, limits: &Limits) -> Result<(), DeriveError> {
    let (modules, bytes) = (string.len() as u64, string.bytes());
    let limit = if modules > limits.modules {
        format!("{} modules", limits.modules)
    } else if bytes > limits.bytes {
        format!("{} bytes", limits.bytes)
    } else {
        return Ok(());
    };
    Err(DeriveProblem::Limit {
        step,
        modules,
        bytes,
        limit,
    }
    .into())
}

fn cut_owned(grammar: &Grammar, string: ModuleString) -> ModuleString {
    if has_cut(grammar, &string) {
        cut(grammar, &string)
    } else {
        string
    }
}

fn has_cut(grammar: &Grammar, string: &ModuleString) -> bool {
    grammar.roles.contains(&Role::Cut)
        && string.symbols.iter().any(|s| grammar.role(*s) == Role::Cut)
}

/// The string without each `%` and what follows it in its branch.
fn cut(grammar: &Grammar, string: &ModuleString) -> ModuleString {
    if !has_cut(grammar, string) {
        return string.clone();
    }
    let mut kept = ModuleString {
        arity: Arc::clone(&string.arity),
        ..ModuleString::default()
    };
    // While cutting: branches open since the `%`.
    let mut cutting: Option<usize> = None;
    for module in string.iter() {
        let role = grammar.role(module.symbol);
        match (cutting, role) {
            (None, Role::Cut) => cutting = Some(0),
            (Some(depth), Role::Open) => cutting = Some(depth + 1),
            (Some(0), Role::Close) => cutting = None,
            (Some(depth), Role::Close) => cutting = Some(depth - 1),
            _ => {}
        }
        if cutting.is_none() {
            kept.symbols.push(module.symbol);
            kept.births.push(module.birth);
            kept.parameters.extend_from_slice(module.parameters);
        }
    }
    kept
}
