//! What `ramus export` grows: the individuals of a sketch or of a grammar.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};

use anyhow::{Context as _, Result, anyhow, bail, ensure};

use super::super::inputs::grammar_text;
use super::super::outputs::tell_bare;
use super::{Args, Plan, Shoot};
use crate::app::store::read_project;
use crate::app::trees;
use crate::lsystem::Grammar;
use crate::sketch::{self, Grower, Grown};
use crate::tree::Drawing;
use crate::tree::vary::{Spread, varied};
use crate::world::document::Document;

/// What is grown.
pub(super) enum Source {
    Grammar(Box<Grammar>, String),
    Sketch(Box<Document>, Box<Grower>),
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
    let sketch = args.season.map_or_else(
        || sketch::Sketch::clone(&document.sketch),
        |season| document.sketch.in_season(season),
    );
    let grower = Grower::of_individuals(&sketch).with_context(|| format!("cannot grow {name}"))?;
    let document = Document {
        sketch: Arc::new(sketch),
        step,
        ..document
    };
    Ok(Source::Sketch(Box::new(document), Box::new(grower)))
}

/// How far individuals differ besides what a grammar draws.
pub(super) fn spread(args: &Args, source: &Source) -> Spread {
    let own = match source {
        // Where its laws draw by the seed, they make the individuals.
        Source::Sketch(document, _)
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
            Self::Sketch(document, _) => Some(document.step),
        };
        let name = args.file.display();
        stated.ok_or_else(|| anyhow!("{name} states no number of steps: give --steps"))
    }

    /// Whether all seeds grow the same tree, leaves and all.
    pub(super) fn has_one_individual(&self, spread: Spread) -> bool {
        let draws = match self {
            Self::Grammar(grammar, _) => grammar.has_chance(),
            Self::Sketch(..) => true,
        };
        !draws && spread == Spread::NONE
    }

    /// The seed of its first individual, where none is asked for: a sketch alone is its own, several are those from 0 on.
    pub(super) fn seed(&self, args: &Args) -> u64 {
        match self {
            Self::Grammar(grammar, _) => grammar.seed(),
            Self::Sketch(document, _) if args.count == 1 => document.sketch.habit.seed.into(),
            Self::Sketch(..) => 0,
        }
    }
}

/// The individual of a seed.
pub(super) fn grown(plan: &Plan<'_>, shoot: Shoot) -> Result<Arc<Drawing>> {
    let Plan {
        args,
        source,
        spread,
        shoots,
    } = *plan;
    let Shoot { seed, step } = shoot;
    let name = args.file.display().to_string();
    let drawing = match source {
        Source::Grammar(grammar, _) => {
            let mut grammar = (**grammar).clone().with_seed(seed);
            if let Some(season) = args.season {
                grammar = grammar.with_season(season);
            }
            // Steps of a sequence grow beside each other, as individuals do.
            let beside = rayon::current_num_threads().min(shoots.len());
            let (drawing, factor) = trees::grown(&grammar, step.or(args.steps), &name, beside)?;
            if let Some(factor) = factor {
                // Once, not for each individual.
                static SAID: Once = Once::new();
                SAID.call_once(|| {
                    whisper!(
                        "the widths of {name} are far too large for metres and were multiplied by {factor:.2e}"
                    );
                });
            }
            drawing
        }
        Source::Sketch(document, grower) => {
            let Grown { tree, organs, .. } = Grower::clone(grower)
                .grow(
                    &individual(args, document, seed),
                    step.unwrap_or(document.step),
                    &AtomicBool::new(false),
                )
                .with_context(|| format!("cannot grow {name}"))?;
            Drawing { tree, organs }
        }
    };
    // What is bare at an early step of a sequence is no more so at the last.
    if step.is_none_or(|step| shoots.iter().all(|other| other.step <= Some(step))) {
        tell_bare(&drawing.organs);
    }
    let drawing = Arc::new(varied(&drawing, seed, spread));
    // A sequence may begin before there is anything.
    ensure!(
        !drawing.is_empty() || step.is_some(),
        "{name} draws nothing after its steps, so there is no file to write"
    );
    Ok(drawing)
}

/// A sketch alone is its own individual.
fn individual(args: &Args, document: &Document, seed: u64) -> sketch::Sketch {
    let sketch = &document.sketch;
    let one_of_many = args.count > 1 || args.seed.is_some();
    if one_of_many && sketch.habit.has_chance() {
        sketch.with_seed(folded(seed))
    } else {
        sketch::Sketch::clone(sketch)
    }
}

/// The grammar that grows the individual of a seed again.
pub(super) fn grammar_of(plan: &Plan<'_>, Shoot { seed, step }: Shoot) -> String {
    let Plan { args, source, .. } = *plan;
    match source {
        Source::Grammar(grammar, text) => {
            let mut text = text.clone();
            if seed != grammar.seed() {
                text = stating(&text, "seed", seed);
            }
            let asked = step.or(args.steps);
            if let Some(steps) = asked.filter(|steps| grammar.steps() != Some(*steps)) {
                text = stating(&text, "steps", u64::from(steps));
            }
            match args.season {
                Some(season) => stating(&text, "season", season.name()),
                None => text,
            }
        }
        Source::Sketch(document, _) => {
            // Step 1 shows the axiom.
            let steps = u64::from(step.unwrap_or(document.step).saturating_sub(1));
            let text = individual(args, document, seed).grammar_text();
            stating(&text, "steps", steps)
        }
    }
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
