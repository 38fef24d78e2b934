//! `ramus abstract`: a measured model as an L-system whose trees have the same statistics.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use clap::Args as ClapArgs;
use clap::builder::{PathBufValueParser, TypedValueParser};

use super::inspect::Loaded;
use super::outputs::{check_places, not_over_each_other, picture_file, tree_file};
use super::print_result;
use super::progress::{Progress, start_watch};
use super::trees::{held, of_loaded};
use crate::abstraction::{
    Candidate, Fit, FitParams, Params, Table, Told, blunt, fit, grow, pooled, text as grammar_text,
    variants as variants_of,
};
use crate::app::cohort::cohort;
use crate::app::cohort::entries::{entries, text_of};
use crate::app::cohort::pooled::parts;
use crate::app::{export, portrait};
use crate::lsystem::Limits;
use crate::mesh::unit::Rounded;
use crate::tree::file::write_atomically;
use crate::tree::measure::Measures;
use crate::tree::{Drawing, Organs};

mod exact;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The model, which is measured between ends that are found on it; or a table: a .json file that says "ramus-table/1", or what ramus analyze --json printed;
    /// or a grammar (.lsys) or a project (.ramus), which is grown and measured; or a group of models: a folder, or a list (.csv) as ramus cohort takes them
    model: PathBuf,
    /// Write the very tree as a compact grammar that draws it again, nowhere off by more than a length in the model's unit, or a part of its size such as 0.5%
    #[arg(long, value_name = "TOLERANCE", value_parser = exact::tolerance, allow_hyphen_values = true, conflicts_with_all = ["candidates", "seed", "variants"])]
    exact: Option<exact::Tolerance>,
    /// Tell how large the grammar is for tolerances from 0.01 % to 5 %, and draw that as an .svg file where one is named
    #[arg(long, value_name = "FILE", num_args = 0..=1, requires = "exact", value_parser = exact::curve_file())]
    curve: Option<Option<PathBuf>>,
    /// How many trees to draw
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    candidates: u32,
    /// One seed gives one result
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u64,
    /// Print the best, the ranked list and what the source's own rules make as one JSON object on one line
    #[arg(long)]
    json: bool,
    /// Write the best tree as .glb, .usda, .ply, .obj or .swc
    #[arg(long, value_name = "FILE", value_parser = tree_file())]
    export: Option<PathBuf>,
    /// Write the best one's grammar as .lsys
    #[arg(long, value_name = "FILE", value_parser = grammar_file())]
    grammar: Option<PathBuf>,
    /// Draw so many more trees of the best one's parameters, of other seeds: with --export and --grammar each is written beside the best, numbered
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000))]
    variants: Option<u16>,
    /// Draw the best tree into a PNG picture
    #[arg(long, value_name = "FILE", value_parser = picture_file())]
    png: Option<PathBuf>,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, requires = "png", value_parser = clap::value_parser!(u32).range(1..))]
    size: u32,
}

fn grammar_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("lsys") => Ok(path),
        _ => Err(format!("{}: grammars are written as .lsys", path.display())),
    })
}

/// Abstracts a model that `read` reads.
pub(super) fn run(
    args: &Args,
    read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>,
) -> Result<()> {
    let never = AtomicBool::new(false);
    let more = usize::from(args.variants.unwrap_or(0));
    let written: Vec<PathBuf> = args.export.iter().chain(&args.grammar).cloned().collect();
    let variants =
        (1..=more).flat_map(|number| written.iter().map(move |path| numbered(path, number)));
    let outputs: Vec<PathBuf> = written
        .iter()
        .chain(&args.png)
        .chain(args.curve.iter().flatten())
        .cloned()
        .chain(variants)
        .collect();
    not_over_each_other(
        Some(&args.model),
        outputs.iter().map(PathBuf::as_path),
        None,
    )?;
    check_places(&outputs)?;
    if let Some(tolerance) = args.exact {
        return exact::run(args, tolerance);
    }
    let name = args.model.display();
    let is = |wanted: &str| {
        let ending = args.model.extension();
        ending.is_some_and(|ending| ending.eq_ignore_ascii_case(wanted))
    };
    let mut models = None;
    let target = match is("json") {
        true => table(&args.model)?,
        false if args.model.is_dir() || is("csv") => {
            let (table, count) = of_group(&args.model)?;
            models = Some(count);
            table
        }
        false => measured(&args.model, read)?,
    };
    let params = FitParams {
        candidates: args.candidates as usize,
        seed: args.seed,
        ..FitParams::default()
    };
    let started = Instant::now();
    let mut progress = Progress::new("drawing trees");
    let fit = fit(&target, &params, &never, &mut |done, of, _| {
        progress.show(done, of);
    })
    .with_context(|| format!("cannot abstract {name}"))?;
    let seconds = started.elapsed().as_secs_f64();
    let Some(best) = fit.ranked.first() else {
        bail!("cannot abstract {name}: no tree was drawn");
    };
    write(args, &best.params, Path::to_owned)?;
    let others = Progress::during("drawing variants", || {
        variants_of(&best.params, &target, more, &never)
    });
    if others.len() < more {
        whisper!("{} of {more} variants grow within bounds", others.len());
    }
    for (place, one) in others.iter().enumerate() {
        write(args, &one.params, |path| numbered(path, place + 1))?;
    }
    if args.png.is_some() {
        let tree = grow(&best.params, &Limits::default(), &never)?;
        if let Some(path) = &args.png {
            let drawing = Drawing {
                tree: blunt(&tree),
                organs: Organs::default(),
            };
            let draw = || portrait::of_drawing(drawing, args.size, false, portrait::PAPER);
            let picture = Progress::during("drawing", draw)
                .with_context(|| format!("cannot draw the abstraction of {name}"))?;
            export::png(&picture, path)?;
        }
    }
    let text = match args.json {
        true => {
            let told = Told::new(&target, &fit, seconds).with_variants(&others);
            serde_json::to_string(&told.of_models(models))? + "\n"
        }
        false => screen(&called(&name.to_string(), models), &fit, seconds) + &ranked(&others),
    };
    print_result("the abstraction", |out| out.write_all(text.as_bytes()))
}

/// Writes the tree and the grammar of some parameters, where they are asked for, under other names.
fn write(args: &Args, params: &Params, place: impl Fn(&Path) -> PathBuf) -> Result<()> {
    if let Some(path) = &args.grammar {
        write_atomically(&place(path), grammar_text(params).as_bytes())?;
    }
    let Some(path) = &args.export else {
        return Ok(());
    };
    let tree = grow(params, &Limits::default(), &AtomicBool::new(false))?;
    // A skeleton is measured, and is as it grew.
    let tree = match export::Format::of(path)? {
        export::Format::Swc => tree,
        _ => blunt(&tree),
    };
    Ok(export::drawing(&tree, &Organs::default(), &place(path))?)
}

/// `best.swc` as `best-2.swc`.
fn numbered(path: &Path, number: usize) -> PathBuf {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_owned();
    let mut name = part(path.file_stem());
    name.push(format!("-{number}."));
    name.push(part(path.extension()));
    path.with_file_name(name)
}

/// The table of a group's models together, and how many they are. A model that fails costs nobody the rest.
fn of_group(models: &Path) -> Result<(Table, usize)> {
    let name = models.display();
    let entries = entries(models)?;
    start_watch();
    let mut progress = Progress::new("analyzing models");
    let cohort = cohort(&entries, None, false, &mut |done, of| {
        progress.show(done, of)
    })?;
    drop(progress);
    for (model, reason) in cohort.failed() {
        whisper!("{model} failed: {reason}");
    }
    if cohort.units().len() > 1 {
        whisper!(
            "models are most likely in different units: their lengths are put together as they are"
        );
    }
    let parts = parts(&cohort);
    let table = pooled(&parts).with_context(|| format!("cannot abstract {name}"))?;
    Ok((table, parts.len()))
}

/// What is abstracted, with how many models it is of.
fn called(name: &str, models: Option<usize>) -> String {
    match models {
        None => name.to_owned(),
        Some(1) => format!("{name} (1 model)"),
        Some(models) => format!("{name} ({models} models together)"),
    }
}

/// Variants as a person reads them.
fn ranked(variants: &[Candidate]) -> String {
    let mut text = String::new();
    for (place, one) in variants.iter().enumerate() {
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "variant {}: seed {}, {} centerlines, {} of {} numbers (distance {:.4})",
            place + 1,
            one.params.seed,
            one.table.counts.centerlines.unwrap_or(0),
            one.matching(),
            one.differences.len(),
            one.distance
        );
    }
    text
}

/// Reads a table.
fn table(path: &Path) -> Result<Table> {
    let text = text_of(path, "table")?;
    Table::read(&text).with_context(|| format!("cannot take {} for a table", path.display()))
}

/// The table of a model between ends that are found on it; of a skeleton, and of what a grammar or a sketch grows, as it is.
fn measured(path: &Path, read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>) -> Result<Table> {
    let grows = path.extension().is_some_and(|ending| {
        ending.eq_ignore_ascii_case("lsys") || ending.eq_ignore_ascii_case("ramus")
    });
    let held = match grows {
        true => held(path)?,
        false => of_loaded(path, read)?,
    };
    held.remarks.iter().for_each(|remark| whisper!("{remark}"));
    Ok(Table::of(&Measures::new(&held.tree)))
}

/// The fit as a person reads it.
fn screen(name: &str, fit: &Fit, seconds: f64) -> String {
    let mut text = String::new();
    let Some(best) = fit.ranked.first() else {
        return text;
    };
    let (matches, of) = (best.matching(), best.differences.len());
    let mut line = |said: String| {
        let _ = writeln!(text, "{said}"); // Writing into a string cannot fail.
    };
    line(format!(
        "{name}: {} trees drawn in {seconds:.1} s; the best, of seed {}, has {matches} of {of} numbers as the model has them (distance {:.4})",
        fit.candidates, best.params.seed, best.distance
    ));
    let ruled = fit.by_rules.as_ref();
    line(match ruled {
        Some(ruled) => format!(
            "the source's own rules have {} of them, in the middle one of their trees (distance {:.4})\n",
            ruled.matching(),
            ruled.distance
        ),
        None => "the source's own rules make trees without bounds of it\n".to_owned(),
    });
    line(format!(
        "{:<30}{:>11}{:>11}{:>9}   {:>11}",
        "", "model", "best", "off by", "by rules"
    ));
    for (place, one) in best.differences.iter().enumerate() {
        let ruled = ruled.and_then(|ruled| ruled.differences.get(place));
        line(format!(
            "{:<30}{:>11}{:>11}{:>8.1}% {} {:>11}",
            one.name,
            Rounded(one.target).to_string(),
            Rounded(one.got).to_string(),
            100.0 * one.relative,
            if one.matches() { ' ' } else { '!' },
            ruled.map_or("–".to_owned(), |one| Rounded(one.got).to_string()),
        ));
    }
    line(format!("{:<30}{:>11}{:>11}", "segments", "", best.segments));
    by_order(&mut text, best);
    text
}

/// What branches are like by order, where the model's are known.
fn by_order(text: &mut String, best: &Candidate) {
    for rows in best.by_order.chunk_by(|a, b| a.order == b.order) {
        for (place, one) in rows.iter().enumerate() {
            let difference = &one.difference;
            // Writing into a string cannot fail.
            let _ = writeln!(
                text,
                "{:<8}{:<22}{:>11}{:>11}{:>8.1}% {}",
                match place {
                    0 => format!("order {}", one.order),
                    _ => String::new(),
                },
                difference.name,
                Rounded(difference.target).to_string(),
                Rounded(difference.got).to_string(),
                100.0 * difference.relative,
                if difference.matches() { "" } else { "!" },
            );
        }
    }
}
