//! `ramus derive --explain`: what a step did.

use std::io::Write as _;
use std::sync::atomic::AtomicBool;

use anyhow::{Result, ensure};
use clap::builder::{StringValueParser, TypedValueParser};

use super::print_result;
use super::progress::Progress;
use crate::lsystem::{DeriveError, ExplainParams, Explanation, Grammar, Limits};

/// A step to explain. What is no number is most likely the grammar file, which then stood behind the option.
pub(super) fn step() -> impl TypedValueParser<Value = u32> {
    StringValueParser::new().try_map(|text| match text.parse() {
        Ok(0) => Err("the axiom is not derived; the first step is 1".to_owned()),
        Ok(step) => Ok(step),
        Err(_) => Err("no number of a step (a grammar file stands before `--explain`)".to_owned()),
    })
}

/// Explains a step.
pub(super) fn explained(
    grammar: &Grammar,
    step: u32,
    params: &ExplainParams,
    limits: &Limits,
) -> Result<Result<Explanation, DeriveError>> {
    ensure!(
        step > 0,
        "there is no step to explain after 0 steps: say which with --steps N or --explain STEP"
    );
    let never = AtomicBool::new(false);
    let mut progress = Progress::new("deriving");
    let before = grammar.derive_watched(step - 1, limits, &never, &mut |done| {
        progress.show(done as usize, step as usize);
    });
    let before = match before {
        Ok(before) => before,
        Err(error) => return Ok(Err(error)),
    };
    ensure!(
        params.from == 0 || params.from < before.len(),
        "there is no module {} to explain: the string before step {step} has {} modules, counted from 0",
        params.from,
        before.len()
    );
    Ok(grammar.explain(&before, step, params, limits, &never))
}

pub(super) fn print(explanation: &Explanation, json: bool) -> Result<()> {
    let text = match json {
        true => serde_json::to_string(explanation)? + "\n",
        false => explanation.to_text(),
    };
    print_result("the explanation", |out| out.write_all(text.as_bytes()))
}
