//! What `ramus derive` makes of a string that is not written down: counts, growth, the text of one that does not fit, a drawing.

use std::io::Write as _;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, bail};

use super::print_result;
use super::progress::Progress;
use crate::lsystem::report::Report;
use crate::lsystem::turtle::{stream_on, streams};
use crate::lsystem::{DeriveError, DrawingCanvas, Grammar, Limits, TurtleParams};
use crate::tree::Drawing;

/// What is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    Counts,
    Growth,
    Text,
}

/// Prints it. False: the string has to be derived first, because only then is it known, or because it fits.
pub(super) fn print(
    wanted: Wanted,
    grammar: &Grammar,
    steps: u32,
    limits: &Limits,
    explain: impl Fn(DeriveError) -> anyhow::Error,
) -> Result<bool> {
    let never = AtomicBool::new(false);
    let unwritten = grammar.unwritten(steps, limits, &never);
    match (wanted, unwritten) {
        (Wanted::Counts, Ok(Some(string))) => {
            let text = string.counts(grammar).text();
            print_result("the counts", |out| out.write_all(text.as_bytes()))?;
        }
        (Wanted::Growth, Ok(Some(string))) => {
            print_result("the growth", |out| {
                (0..)
                    .zip(string.growth())
                    .try_for_each(|one| line(out, one))
            })?;
        }
        (Wanted::Growth, Ok(None)) => growth(grammar, steps, limits, explain)?,
        (Wanted::Text, Ok(Some(string)))
            if string.modules() <= u128::from(limits.modules)
                && string.bytes() > u128::from(limits.bytes) =>
        {
            print_result("the string", |out| {
                string.write_text(grammar, out)?;
                writeln!(out)
            })?;
        }
        // A string of so many modules is past other limits, too.
        (Wanted::Text, _) | (_, Ok(None)) => return Ok(false),
        (_, Err(error)) => return Err(explain(error)),
    }
    Ok(true)
}

/// Draws a string as it comes: prints its JSON object, and gives what is drawn, where each is asked for. Whether the printing failed is
/// told with the drawing: a full standard output must not cost the files.
pub(super) fn stream(
    grammar: &Grammar,
    steps: u32,
    limits: &Limits,
    (json, drawing): (bool, bool),
    name: &str,
    explain: impl Fn(DeriveError) -> anyhow::Error,
) -> Result<(Result<()>, Option<Drawing>)> {
    let never = AtomicBool::new(false);
    let unwritten = grammar.unwritten(steps, limits, &never).map_err(&explain)?;
    let Some(string) = unwritten.filter(|_| streams(grammar)) else {
        bail!(
            "{name}: the modules of this grammar do not each develop alone and without chance (or its `interpret` block draws or cuts), so its string has to be derived: leave out --stream"
        );
    };
    let params = TurtleParams {
        limits: *limits,
        ..TurtleParams::default()
    };
    let mut printed = Ok(());
    if json {
        let report = Progress::during("measuring with the turtle", || {
            Report::streamed(grammar, string.iter(), steps, &params, &never)
        });
        let json = report.map_err(&explain)?.to_json();
        let json = json.with_context(|| name.to_owned())?;
        printed = print_result("the JSON", |out| writeln!(out, "{json}"));
    }
    if !drawing {
        return Ok((printed, None));
    }
    let canvas = DrawingCanvas::new(grammar, &params);
    let drawn = Progress::during("drawing with the turtle", || {
        stream_on(grammar, string.iter(), &params, &never, canvas)
    });
    let drawing = drawn.map_err(&explain)?.finish();
    Ok((printed, Some(drawing)))
}

/// Prints the modules of each step as soon as it is derived, for as long as somebody reads them.
fn growth(
    grammar: &Grammar,
    steps: u32,
    limits: &Limits,
    explain: impl Fn(DeriveError) -> anyhow::Error,
) -> Result<()> {
    let never = AtomicBool::new(false);
    let mut string = grammar.derive(0, limits, &never).map_err(&explain)?;
    let mut failed = None;
    print_result("the growth", |out| {
        line(out, (0, string.len() as u128))?;
        for step in 1..=steps {
            match grammar.derive_next(&string, step, limits, &never) {
                Ok(following) => string = following,
                Err(error) => {
                    failed = Some(explain(error));
                    break;
                }
            }
            line(out, (step, string.len() as u128))?;
            out.flush()?;
        }
        Ok(())
    })?;
    failed.map_or(Ok(()), Err)
}

fn line(out: &mut dyn std::io::Write, (step, modules): (u32, u128)) -> std::io::Result<()> {
    writeln!(out, "{step} {modules}")
}
