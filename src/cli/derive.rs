//! `ramus derive`: a grammar file grown, printed, drawn and exported.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow, bail};
use clap::{Args as ClapArgs, ValueEnum};

use super::outputs::{check_places, not_over_each_other, tree_file};
use super::print_result;
use super::progress::Progress;
use crate::app::{export, portrait};
use crate::lsystem::report::Report;
use crate::lsystem::{Grammar, Limits, TurtleParams, interpret};
use crate::tree::Tree;
use crate::tree::radii::{self, FitParams};

/// Larger files are no grammars.
const MAX_GRAMMAR_BYTES: u64 = 64 << 20;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The grammar file (.lsys)
    file: PathBuf,
    /// Steps to derive; without it the number that the file states
    #[arg(long, value_name = "N")]
    steps: Option<u32>,
    /// What to print
    #[arg(long, value_enum, value_name = "WHAT")]
    print: Option<Print>,
    /// Print counts, sums and bounds as one JSON object on one line
    #[arg(long)]
    json: bool,
    /// Write the tree; the ending tells the format: .glb, .obj or .swc (may be given more than once)
    #[arg(long, value_name = "FILE", value_parser = tree_file())]
    export: Vec<PathBuf>,
    /// Draw the tree into a PNG picture
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..))]
    size: u32,
    /// How the grammar's widths are meant in exports and pictures
    #[arg(long, value_enum, default_value_t = Widths::Auto, value_name = "HOW")]
    widths: Widths,
    /// Seed of the random draws, in place of the file's
    #[arg(long, value_name = "SEED")]
    seed: Option<u64>,
    /// Most memory that the strings may take, in MiB
    #[arg(long, value_name = "MIB", default_value_t = 4096, value_parser = clap::value_parser!(u64).range(1..))]
    memory: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Print {
    /// The modules with their parameters
    String,
    /// How many of each name, and their parameters' sums
    Counts,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Widths {
    /// In metres, unless the trunk would be thicker than a fifth of the tree: then scaled to fit, as ABOP means them
    Auto,
    /// In metres, whatever comes of it
    Metres,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let outputs = || args.export.iter().chain(&args.png);
    not_over_each_other(Some(&args.file), outputs().map(PathBuf::as_path), None)?;
    let grammar = read(args)?;
    check_places(outputs())?;
    let steps = args.steps.or(grammar.steps()).ok_or_else(|| {
        anyhow!(
            "{} states no number of steps: give one with --steps N",
            args.file.display()
        )
    })?;
    let limits = Limits {
        bytes: args.memory.saturating_mul(1 << 20),
        ..Limits::default()
    };
    let never = AtomicBool::new(false);

    let began = Instant::now();
    let mut progress = Progress::new("deriving");
    let named = || args.file.display().to_string();
    let string = grammar
        .derive_watched(steps, &limits, &never, &mut |done| {
            progress.show(done as usize, steps as usize);
        })
        .with_context(named)?;
    drop(progress);
    let derive_ms = began.elapsed().as_secs_f64() * 1e3;

    // A full standard output must not cost the files: it is told at the end.
    let mut printed = Ok(());
    if args.print == Some(Print::String) {
        printed = print_result("the string", |out| {
            string.write_text(&grammar, out)?;
            writeln!(out)
        });
        if !args.json && args.export.is_empty() && args.png.is_none() {
            return printed;
        }
    }
    let began = Instant::now();
    let tree = interpret(
        &grammar,
        &string,
        &TurtleParams {
            limits,
            ..TurtleParams::default()
        },
        &never,
    )
    .with_context(named)?;
    let turtle_ms = began.elapsed().as_secs_f64() * 1e3;
    let report = Report::new(&grammar, &string, &tree, steps, derive_ms, turtle_ms);
    drop(string);
    if args.print == Some(Print::Counts) {
        let counts = report.counts_text();
        printed = printed.and(print_result("the counts", |out| {
            out.write_all(counts.as_bytes())
        }));
    }
    if args.json {
        let json = report.to_json().with_context(named);
        printed = printed
            .and(json.and_then(|json| print_result("the JSON", |out| writeln!(out, "{json}"))));
    } else if args.print.is_none() {
        tell!(
            "{}: {} modules and {} segments after {steps} steps",
            args.file.display(),
            report.modules,
            report.segments
        );
    }
    write_files(args, tree)?;
    printed
}

fn read(args: &Args) -> Result<Grammar> {
    let path = &args.file;
    let name = path.display().to_string();
    let failed = || format!("cannot read {name}");
    let file = File::open(path).with_context(failed)?;
    let mut bytes = Vec::new();
    file.take(MAX_GRAMMAR_BYTES + 1)
        .read_to_end(&mut bytes)
        .with_context(failed)?;
    if bytes.len() as u64 > MAX_GRAMMAR_BYTES {
        bail!("{name} is longer than {MAX_GRAMMAR_BYTES} bytes, and no grammar is");
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        anyhow!("{name} is no UTF-8 text (byte {at}): save the grammar as UTF-8")
    })?;
    let grammar = Grammar::parse(&text, &name).map_err(|errors| anyhow!("{errors}"))?;
    Ok(match args.seed {
        Some(seed) => grammar.with_seed(seed),
        None => grammar,
    })
}

fn write_files(args: &Args, mut tree: Tree) -> Result<()> {
    if args.export.is_empty() && args.png.is_none() {
        return Ok(());
    }
    let factor = match args.widths {
        Widths::Auto => radii::fit(&mut tree, &FitParams::default()),
        Widths::Metres => None,
    };
    for path in &args.export {
        export::tree(&tree, path)?;
    }
    if let Some(path) = &args.png {
        let picture = portrait::of_tree(Arc::new(tree), args.size)?;
        export::png(&picture, path)?;
    }
    if let Some(factor) = factor {
        whisper!(
            "ramus: the widths are far too large for metres and were multiplied by {factor:.2e}; --widths metres leaves them"
        );
    }
    Ok(())
}
