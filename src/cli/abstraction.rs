//! `ramus abstract`: a measured model as an L-system whose trees have the same statistics.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use clap::Args as ClapArgs;
use clap::builder::{PathBufValueParser, TypedValueParser};

use super::inspect::Loaded;
use super::outputs::{check_places, not_over_each_other, picture_file, tree_file};
use super::print_result;
use super::progress::Progress;
use crate::abstraction::{
    Candidate, Fit, FitParams, Table, Told, blunt, fit, grow, text as grammar_text,
};
use crate::app::analysis::{Wanted, checked, endpoints, found, prepared};
use crate::app::{export, portrait};
use crate::lsystem::Limits;
use crate::mesh::unit::Rounded;
use crate::tree::file::write_atomically;
use crate::tree::measure::Measures;
use crate::tree::{Drawing, Organs};

mod exact;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The model, which is measured between ends that are found on it, or a table: a .json file that says "ramus-table/1", or what ramus analyze --json printed; with --exact also a grammar (.lsys) or a project (.ramus)
    model: PathBuf,
    /// Write the very tree as a compact grammar that draws it again, nowhere off by more than a length in the model's unit, or a part of its size such as 0.5%
    #[arg(long, value_name = "TOLERANCE", value_parser = exact::tolerance, allow_hyphen_values = true, conflicts_with_all = ["candidates", "seed"])]
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
    /// Write the best tree as .glb, .obj or .swc
    #[arg(long, value_name = "FILE", value_parser = tree_file())]
    export: Option<PathBuf>,
    /// Write the best one's grammar as .lsys
    #[arg(long, value_name = "FILE", value_parser = grammar_file())]
    grammar: Option<PathBuf>,
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

/// Larger files are no tables.
const TABLE_BYTES: u64 = 256 << 20;

/// Abstracts a model that `read` reads.
pub(super) fn run(
    args: &Args,
    read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>,
) -> Result<()> {
    let never = AtomicBool::new(false);
    let curve = args.curve.iter().flatten();
    let outputs = || {
        args.export
            .iter()
            .chain(&args.grammar)
            .chain(&args.png)
            .chain(curve.clone())
    };
    not_over_each_other(Some(&args.model), outputs().map(PathBuf::as_path), None)?;
    check_places(outputs())?;
    if let Some(tolerance) = args.exact {
        return exact::run(args, tolerance, read);
    }
    let name = args.model.display();
    let target = match args.model.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("json") => table(&args.model)?,
        _ => measured(&args.model, read)?,
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
    if let Some(path) = &args.grammar {
        write_atomically(path, grammar_text(&best.params).as_bytes())?;
    }
    if args.export.is_some() || args.png.is_some() {
        let tree = grow(&best.params, &Limits::default(), &never)?;
        // A skeleton is measured, and is as it grew.
        let shown = blunt(&tree);
        if let Some(path) = &args.export {
            let is_skeleton = export::Format::of(path)? == export::Format::Swc;
            let tree = if is_skeleton { &tree } else { &shown };
            export::drawing(tree, &Organs::default(), path)?;
        }
        if let Some(path) = &args.png {
            let drawing = Drawing {
                tree: shown,
                organs: Organs::default(),
            };
            let draw = || portrait::of_drawing(drawing, args.size, false, portrait::PAPER);
            let picture = Progress::during("drawing", draw)
                .with_context(|| format!("cannot draw the abstraction of {name}"))?;
            export::png(&picture, path)?;
        }
    }
    let text = match args.json {
        true => serde_json::to_string(&Told::new(&target, &fit, seconds))? + "\n",
        false => screen(&name.to_string(), &fit, seconds),
    };
    print_result("the abstraction", |out| out.write_all(text.as_bytes()))
}

/// Reads a table.
fn table(path: &Path) -> Result<Table> {
    let name = path.display();
    let mut text = String::new();
    let file = File::open(path).with_context(|| format!("cannot read {name}"))?;
    file.take(TABLE_BYTES + 1)
        .read_to_string(&mut text)
        .with_context(|| format!("cannot read {name}"))?;
    if text.len() as u64 > TABLE_BYTES {
        bail!("{name} is longer than {TABLE_BYTES} bytes, and no table is");
    }
    Table::read(&text).with_context(|| format!("cannot take {name} for a table"))
}

/// The table of a model between ends that are found on it; of a skeleton as it is.
fn measured(path: &Path, read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>) -> Result<Table> {
    let never = AtomicBool::new(false);
    let loaded = Progress::during("reading", || read(path, &never))?;
    if let Some(skeleton) = &loaded.skeleton {
        return Ok(Table::of(&Measures::new(skeleton)));
    }
    let wanted = Wanted::default();
    let of_surface = || -> Result<Table> {
        let report = checked(&loaded.mesh, &mut |_, _| {})?;
        let on = prepared(&loaded.mesh, report, &mut |_, _| {})?;
        let ends = endpoints(&wanted, &on)?;
        let found = found(&wanted, &on, &ends, &mut |_, _| {})?;
        for one in &found.unreached {
            whisper!("{} is {one}", one.name);
        }
        Ok(Table::of(&Measures::new(&found.tree)))
    };
    Progress::during("measuring", of_surface)
        .with_context(|| format!("cannot analyze {}", path.display()))
}

/// The fit as a person reads it.
fn screen(name: &str, fit: &Fit, seconds: f64) -> String {
    let mut text = String::new();
    let Some(best) = fit.ranked.first() else {
        return text;
    };
    let matching = |one: &Candidate| one.differences.iter().filter(|one| one.matches()).count();
    let (matches, of) = (matching(best), best.differences.len());
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
            matching(ruled),
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
    text
}
