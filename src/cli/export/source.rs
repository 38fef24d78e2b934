//! What `ramus export` grows: the individuals of a sketch or of a grammar.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};

use anyhow::{Context as _, Result, anyhow, bail, ensure};

use super::super::inputs::grammar_text;
use super::{Args, Plan, Shoot};
use crate::app::store::read_project;
use crate::app::trees;
use crate::lsystem::Grammar;
use crate::sketch::{self, Grown};
use crate::tree::Drawing;
use crate::tree::vary::{Spread, varied};
use crate::world::document::Document;

/// What is grown.
pub(super) enum Source {
    Grammar(Box<Grammar>, String),
    Sketch(Box<Document>),
}

/// Reads the file.
pub(super) fn source(args: &Args) -> Result<Source> {
    let name = args.file.display();
    let is = |wanted: &str| {
        let ending = args.file.extension();
        ending.is_some_and(|ending| ending.eq_ignore_ascii_case(wanted))
    };
    if is("lsys") {
        let text = grammar_text(&args.file)?;
        let grammar =
            Grammar::parse(&text, &name.to_string()).map_err(|errors| anyhow!("{errors}"))?;
        grammar
            .remarks()
            .iter()
            .for_each(|remark| whisper!("{remark}"));
        return Ok(Source::Grammar(Box::new(grammar), text));
    }
    if !is("ramus") {
        bail!("{name} is neither a project (.ramus) nor a grammar (.lsys): name one of these");
    }
    let document = read_project(&args.file)?;
    let step = args.steps.unwrap_or(document.step);
    ensure!(
        step > 0,
        "{name} was left at step 0, where no tree has grown yet: give --steps, or grow it in the workshop first"
    );
    Ok(Source::Sketch(Box::new(Document { step, ..document })))
}

/// How far individuals differ besides what a grammar draws.
pub(super) fn spread(args: &Args, source: &Source) -> Spread {
    let own = match source {
        // Where its laws draw by the seed, they make the individuals.
        Source::Sketch(document)
            if !document.sketch.habit.has_chance() && (args.count > 1 || args.seed.is_some()) =>
        {
            Spread::USUAL
        }
        _ => Spread::NONE,
    };
    Spread {
        angle: args.angles.map_or(own.angle, f32::to_radians),
        length: args.lengths.map_or(own.length, |percent| percent / 100.0),
    }
}

impl Source {
    /// Steps that it grows.
    pub(super) fn steps(&self, args: &Args) -> Result<u32> {
        let stated = match self {
            Self::Grammar(grammar, _) => args.steps.or(grammar.steps()),
            Self::Sketch(document) => Some(document.step),
        };
        let name = args.file.display();
        stated.ok_or_else(|| anyhow!("{name} states no number of steps: give --steps"))
    }

    /// The seed of its first individual, where none is asked for: a sketch alone is its own, several are those from 0 on.
    pub(super) fn seed(&self, args: &Args) -> u64 {
        match self {
            Self::Grammar(grammar, _) => grammar.seed(),
            Self::Sketch(document) if args.count == 1 => document.sketch.habit.seed.into(),
            Self::Sketch(_) => 0,
        }
    }
}

/// The individual of a seed, and the grammar that grows it again.
pub(super) fn grown(
    plan: &Plan<'_>,
    Shoot { seed, step }: Shoot,
) -> Result<(Arc<Drawing>, String)> {
    let Plan {
        args,
        source,
        spread,
        shoots,
    } = *plan;
    let name = args.file.display().to_string();
    let asked = step.or(args.steps);
    let (drawing, grammar) = match source {
        Source::Grammar(grammar, text) => {
            let mut text = text.clone();
            if seed != grammar.seed() {
                text = stating(&text, "seed", seed);
            }
            if let Some(steps) = asked.filter(|steps| grammar.steps() != Some(*steps)) {
                text = stating(&text, "steps", u64::from(steps));
            }
            let mut grammar = (**grammar).clone().with_seed(seed);
            if let Some(season) = args.season {
                text = stating(&text, "season", season.name());
                grammar = grammar.with_season(season);
            }
            // Steps of a sequence grow beside each other, as individuals do.
            let beside = rayon::current_num_threads().min(shoots.len());
            let (drawing, factor) = trees::grown(&grammar, asked, &name, beside)?;
            if let Some(factor) = factor {
                // Once, not for each individual.
                static SAID: Once = Once::new();
                SAID.call_once(|| {
                    whisper!(
                        "the widths of {name} are far too large for metres and were multiplied by {factor:.2e}"
                    );
                });
            }
            (drawing, text)
        }
        Source::Sketch(document) => {
            let (sketch, step) = (&document.sketch, &step.unwrap_or(document.step));
            let one_of_many = args.count > 1 || args.seed.is_some();
            let individual = if one_of_many && sketch.habit.has_chance() {
                sketch.with_seed(folded(seed))
            } else {
                sketch::Sketch::clone(sketch)
            };
            let sketch = &match args.season {
                Some(season) => individual.in_season(season),
                None => individual,
            };
            let grown = sketch::grow(sketch, *step, &AtomicBool::new(false))
                .with_context(|| format!("cannot grow {name}"))?;
            // Step 1 shows the axiom.
            let steps = u64::from(step.saturating_sub(1));
            let text = stating(&sketch.grammar_text(), "steps", steps);
            let Grown { tree, organs, .. } = grown;
            (Drawing { tree, organs }, text)
        }
    };
    let drawing = Arc::new(varied(&drawing, seed, spread));
    // A sequence may begin before there is anything.
    ensure!(
        !drawing.is_empty() || step.is_some(),
        "{name} draws nothing after its steps, so there is no file to write"
    );
    Ok((drawing, grammar))
}

/// A seed of a sketch's laws: seeds one after the other stay different.
fn folded(seed: u64) -> u32 {
    let [a, b, c, d, e, f, g, h] = seed.to_le_bytes();
    u32::from_le_bytes([a, b, c, d]) ^ u32::from_le_bytes([e, f, g, h])
}

/// A grammar's text that states another number.
fn stating(text: &str, word: &str, number: impl std::fmt::Display) -> String {
    let states = |line: &str, word: &str| line.split_whitespace().next() == Some(word);
    let own = format!("{word} {number}\n");
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    match lines.iter().position(|line| states(line, word)) {
        Some(at) => {
            // A statement goes on in lines that begin with a space.
            let more = lines[at + 1..].iter();
            let more =
                more.take_while(|line| line.starts_with([' ', '\t']) && !line.trim().is_empty());
            let end = at + 1 + more.count();
            lines.splice(at..end, [own.as_str()]);
        }
        None => {
            let axiom = lines.iter().position(|line| states(line, "axiom"));
            lines.insert(axiom.unwrap_or(0), &own);
        }
    }
    lines.concat()
}
