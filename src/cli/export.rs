//! `ramus export`: a project's tree or a grammar's as files for other programs, in levels of detail and many individuals.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Once};
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use clap::{Args as ClapArgs, ValueEnum};
use rayon::prelude::*;
use serde::Serialize;

use super::inputs::grammar_text;
use super::outputs::{check_places, not_over_each_other, picture_file};
use super::print_result;
use super::progress::{Progress, start_watch};
use crate::app::store::read_project;
use crate::app::trees;
use crate::app::{export, portrait};
use crate::lsystem::Grammar;
use crate::sketch::{self, Grown};
use crate::tree::Drawing;
use crate::tree::detail::{Detail, coarser, triangles_of};
use crate::tree::export::{ExportParams, Swc};
use crate::tree::file::write_atomically;
use crate::tree::foliage::Season;
use crate::tree::organs::refined_len;
use crate::tree::vary::{Spread, varied};

/// How far the individuals of a sketch differ where nothing else is said: degrees and percent.
const OWN_SPREAD: [f32; 2] = [12.0, 15.0];
/// Files, and individuals in one picture, at most.
const FILES_MOST: u64 = 100_000;
const SHEET_MOST: u32 = 400;
/// Pixels of one picture at most: half a gigabyte.
const PIXELS_MOST: u64 = 1 << 27;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The project (.ramus), at the step that it was left at, or the grammar (.lsys)
    file: PathBuf,
    /// What to write; several with commas between them
    #[arg(
        long,
        value_enum,
        value_name = "FORMAT",
        required_unless_present = "sheet",
        value_delimiter = ','
    )]
    format: Vec<Format>,
    /// Draw all individuals into one picture (.png)
    #[arg(long, value_name = "FILE", value_parser = picture_file())]
    sheet: Option<PathBuf>,
    /// Width and height of each individual in that picture, pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=2048))]
    size: u32,
    /// The time of the year, in the place of the project's or the grammar's
    #[arg(long, value_name = "SEASON", value_parser = season)]
    season: Option<Season>,
    /// The folder to write to, which is made if it is not there
    #[arg(long, value_name = "FOLDER", default_value = ".")]
    out: PathBuf,
    /// Levels of detail, from 0, the tree as it is, to 4; several with commas between them
    #[arg(long, value_name = "LEVEL", value_delimiter = ',', default_value = "0", conflicts_with = "triangles",
        value_parser = clap::value_parser!(u32).range(0..i64::from(Detail::LEVELS)))]
    lod: Vec<u32>,
    /// As much detail as so many triangles allow
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    triangles: Option<u64>,
    /// Steps to derive or grow, in place of the file's own
    #[arg(long, value_name = "N")]
    steps: Option<u32>,
    /// Seed of the first individual
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Individuals, of as many seeds one after the other
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    count: u32,
    /// Degrees that branches of individuals are turned at most; of a sketch 12 where it has a seed or a count, else 0
    #[arg(long, value_name = "DEGREES", value_parser = up_to_90)]
    angles: Option<f32>,
    /// Percent that segments of individuals are longer or shorter at most; of a sketch 15 where it has a seed or a count, else 0
    #[arg(long, value_name = "PERCENT", value_parser = up_to_90)]
    lengths: Option<f32>,
    /// Only tell what would be written, with triangles and bytes
    #[arg(long)]
    dry_run: bool,
    /// Tell what was written as one JSON object on one line
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Binary glTF: surface, bark, colours, materials
    Glb,
    /// Universal Scene Description as text
    Usda,
    /// Stanford PLY, binary
    Ply,
    /// Wavefront OBJ
    Obj,
    /// The skeleton with radii
    Swc,
    /// The grammar
    Lsys,
}

impl Format {
    fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Usda => "usda",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Swc => "swc",
            Self::Lsys => "lsys",
        }
    }

    /// Whether it has triangles, which levels of detail are about.
    fn is_surface(self) -> bool {
        !matches!(self, Self::Swc | Self::Lsys)
    }
}

/// A seed of a sketch's laws: seeds one after the other stay different.
fn folded(seed: u64) -> u32 {
    let [a, b, c, d, e, f, g, h] = seed.to_le_bytes();
    u32::from_le_bytes([a, b, c, d]) ^ u32::from_le_bytes([e, f, g, h])
}

/// A time of the year by its name.
fn season(text: &str) -> Result<Season, String> {
    let known = Season::ALL.into_iter().find(|season| season.name() == text);
    known.ok_or_else(|| "expected spring, summer, autumn or winter".to_owned())
}

/// Degrees or percent that individuals may differ by.
fn up_to_90(text: &str) -> Result<f32, String> {
    let number: f32 = text.parse().map_err(|_| "no number".to_owned())?;
    match (0.0..=90.0).contains(&number) {
        true => Ok(number),
        false => Err("expected a number from 0 to 90".to_owned()),
    }
}

/// What is grown.
enum Source {
    Grammar(Box<Grammar>, String),
    Sketch(Arc<sketch::Sketch>, u32),
}

/// One file.
#[derive(Clone, Debug)]
struct File {
    path: PathBuf,
    format: Format,
    level: Option<u32>,
}

/// What is told of a file.
#[derive(Clone, Debug, Serialize)]
struct Told {
    file: PathBuf,
    seed: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    level: Option<u32>,
    segments: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    triangles: Option<u64>,
    /// How far the surface is off at most, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    bound: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes: Option<u64>,
}

/// All that is told, `ramus-export/1`.
#[derive(Serialize)]
struct All<'a> {
    format: &'static str,
    files: &'a [Told],
    triangles: u64,
    seconds: f64,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let source = source(args)?;
    let spread = spread(args, &source);
    let (seeds, files) = planned(args, &source, spread)?;
    start_watch();
    let began = Instant::now();
    let (mut told, mut sheet) = (Vec::<Told>::new(), Vec::new());
    let mut done = 0;
    let mut progress = Progress::new("exporting");
    let mut printed = Ok(());
    // As many at a time as there are threads, so that memory is bounded and the numbers come in order, before the files.
    for (seeds, files) in seeds
        .chunks(rayon::current_num_threads())
        .zip(files.chunks(rayon::current_num_threads()))
    {
        let made: Vec<(Vec<Ready>, Arc<Drawing>)> = seeds
            .par_iter()
            .zip(files)
            .map(|(seed, files)| ready(args, &source, *seed, spread, files))
            .collect::<Result<_>>()?;
        let (ready, drawings): (Vec<Vec<Ready>>, Vec<Arc<Drawing>>) = made.into_iter().unzip();
        if args.sheet.is_some() && !args.dry_run {
            sheet.extend(drawings);
        }
        if !args.json {
            printed = printed.and(print_result("the list", |out| {
                let mut lines = ready.iter().flatten();
                lines.try_for_each(|one| writeln!(out, "{}", line(&one.told)))
            }));
        }
        let written: Vec<Vec<Told>> = ready
            .into_par_iter()
            .map(|files| {
                let files = files.into_iter();
                files.map(|file| written(args, file)).collect::<Result<_>>()
            })
            .collect::<Result<_>>()?;
        told.extend(written.into_iter().flatten());
        done += seeds.len();
        progress.show(done, args.count as usize);
    }
    drop(progress);
    if let Some(path) = args.sheet.as_ref().filter(|_| !args.dry_run) {
        let draw = || portrait::sheet(&sheet, args.size, portrait::PAPER);
        let picture = Progress::during("drawing", draw).context("cannot draw the individuals")?;
        export::png(&picture, path)?;
    }
    finish(args, &told, began.elapsed().as_secs_f64(), printed)
}

/// The seeds and the files of each, if all may be asked for and written.
fn planned(args: &Args, source: &Source, spread: Spread) -> Result<(Vec<u64>, Vec<Vec<File>>)> {
    let first = args.seed.unwrap_or(match source {
        Source::Grammar(grammar, _) => grammar.seed(),
        Source::Sketch(..) => 0,
    });
    let Some(last) = first.checked_add(u64::from(args.count) - 1) else {
        bail!(
            "seeds end at {}: take a smaller --seed or --count",
            u64::MAX
        );
    };
    let each = files(args, first).len() as u64;
    ensure!(
        u64::from(args.count) * each <= FILES_MOST,
        "{} files are too many for one command: take a smaller --count",
        u64::from(args.count) * each
    );
    ensure!(
        spread == Spread::NONE || !args.format.contains(&Format::Lsys),
        "a grammar does not say how its individuals are turned and longer by --angles and --lengths: leave lsys out, or set both to 0"
    );
    let seeds: Vec<u64> = (first..=last).collect();
    let files: Vec<Vec<File>> = seeds.iter().map(|seed| files(args, *seed)).collect();
    let all = || files.iter().flatten().map(|file| &file.path);
    let pixels = u64::from(args.count) * u64::from(args.size).pow(2);
    ensure!(
        args.sheet.is_none() || args.count <= SHEET_MOST && pixels <= PIXELS_MOST,
        "one picture of {} individuals of {} pixels is too large: take a smaller --count or --size",
        args.count,
        args.size
    );
    let all = || all().chain(&args.sheet);
    not_over_each_other(Some(&args.file), all().map(PathBuf::as_path), None)?;
    if !args.dry_run {
        ensure!(
            !args.out.is_file(),
            "{} is a file: name a folder with --out",
            args.out.display()
        );
        std::fs::create_dir_all(&args.out).with_context(|| {
            format!(
                "cannot make the folder {}: check that it may be written",
                args.out.display()
            )
        })?;
        check_places(all())?;
    }
    Ok((seeds, files))
}

/// What is told at the end.
fn finish(args: &Args, told: &[Told], seconds: f64, printed: Result<()>) -> Result<()> {
    let triangles = told.iter().filter_map(|one| one.triangles).sum();
    if args.json {
        let all = All {
            format: "ramus-export/1",
            files: told,
            triangles,
            seconds,
        };
        let json = serde_json::to_string(&all)?;
        return print_result("the JSON", |out| writeln!(out, "{json}"));
    }
    printed?;
    let what = if args.dry_run {
        "would be written"
    } else {
        "written"
    };
    let several = if told.len() == 1 { "file" } else { "files" };
    let sheet = args.sheet.as_ref().map_or_else(String::new, |path| {
        format!(
            " and a picture of {} individuals, {},",
            args.count,
            path.display()
        )
    });
    tell!(
        "{} {several} of {triangles} triangles{sheet} {what} in {seconds:.1} s",
        told.len()
    );
    Ok(())
}

fn line(told: &Told) -> String {
    let mut line = format!("{}: {} segments", told.file.display(), told.segments);
    if let (Some(triangles), Some(bound)) = (told.triangles, told.bound) {
        line += &format!(
            ", {triangles} triangles, off by {:.2} mm at most",
            1e3 * bound
        );
    }
    if let Some(bytes) = told.bytes {
        line += &format!(", about {} kB", bytes.div_ceil(1000));
    }
    line
}

fn source(args: &Args) -> Result<Source> {
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
    Ok(Source::Sketch(document.sketch, step))
}

/// How far individuals differ besides what a grammar draws.
fn spread(args: &Args, source: &Source) -> Spread {
    let own = match source {
        // Where its laws draw by the seed, they make the individuals.
        Source::Sketch(sketch, _)
            if sketch.habit.is_lawless() && (args.count > 1 || args.seed.is_some()) =>
        {
            OWN_SPREAD
        }
        _ => [0.0, 0.0],
    };
    Spread {
        angle: args.angles.unwrap_or(own[0]).to_radians(),
        length: args.lengths.unwrap_or(own[1]) / 100.0,
    }
}

/// The files of an individual.
fn files(args: &Args, seed: u64) -> Vec<File> {
    let stem = args.file.file_stem().unwrap_or_default().to_string_lossy();
    let one = match args.seed.is_some() || args.count > 1 {
        true => format!("-{seed}"),
        false => String::new(),
    };
    let mut files: Vec<File> = Vec::new();
    let mut levels = args.lod.clone();
    levels.sort_unstable();
    levels.dedup();
    if args.triangles.is_some() {
        levels = vec![0];
    }
    let mut formats = Vec::new();
    for format in &args.format {
        // What is named twice is written once.
        if formats.contains(format) {
            continue;
        }
        formats.push(*format);
        let mut add = |level: Option<u32>, part: String| {
            let name = format!("{stem}{one}{part}.{}", format.ending());
            let path = args.out.join(name);
            files.push(File {
                path,
                format: *format,
                level,
            });
        };
        if !format.is_surface() {
            add(None, String::new());
            continue;
        }
        for level in &levels {
            let part = match levels.as_slice() {
                [_] => String::new(),
                _ => format!("-lod{level}"),
            };
            add(args.triangles.is_none().then_some(*level), part);
        }
    }
    files
}

/// A file whose contents are made and which is not written yet.
struct Ready {
    told: Told,
    format: Format,
    sides: u32,
    drawing: Arc<Drawing>,
    grammar: Option<String>,
}

/// All files of an individual, and what it is.
fn ready(
    args: &Args,
    source: &Source,
    seed: u64,
    spread: Spread,
    files: &[File],
) -> Result<(Vec<Ready>, Arc<Drawing>)> {
    let name = args.file.display().to_string();
    let (drawing, grammar) = match source {
        Source::Grammar(grammar, text) => {
            let mut text = text.clone();
            if seed != grammar.seed() {
                text = stating(&text, "seed", seed);
            }
            if let Some(steps) = args.steps.filter(|steps| grammar.steps() != Some(*steps)) {
                text = stating(&text, "steps", u64::from(steps));
            }
            let mut grammar = (**grammar).clone().with_seed(seed);
            if let Some(season) = args.season {
                text = stating(&text, "season", season.name());
                grammar = grammar.with_season(season);
            }
            let beside = rayon::current_num_threads().min(args.count as usize);
            let (drawing, factor) = trees::grown(&grammar, args.steps, &name, beside)?;
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
        Source::Sketch(sketch, step) => {
            let one_of_many = args.count > 1 || args.seed.is_some();
            let individual = if one_of_many && !sketch.habit.is_lawless() {
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
    ensure!(
        !drawing.is_empty(),
        "{name} draws nothing after its steps, so there is no file to write"
    );
    let mut levels: Vec<(Option<u32>, Coarse)> = Vec::new();
    let mut ready = Vec::new();
    for file in files {
        let of = |coarse: &Coarse| Ready {
            told: Told {
                file: file.path.clone(),
                seed,
                level: file.level,
                segments: coarse.segments,
                triangles: Some(coarse.triangles),
                bound: Some(coarse.bound),
                bytes: Some(estimated(file.format, coarse)),
            },
            format: file.format,
            sides: coarse.sides,
            drawing: Arc::clone(&coarse.drawing),
            grammar: None,
        };
        if file.format.is_surface() {
            if !levels.iter().any(|(level, _)| *level == file.level) {
                levels.push((file.level, coarse(args, &name, &drawing, file.level)?));
            }
            let known = levels.iter().find(|(level, _)| *level == file.level);
            ready.extend(known.map(|(_, coarse)| of(coarse)));
            continue;
        }
        if file.format == Format::Swc {
            // What it cannot hold is said before anything is written.
            Swc::new(&drawing.tree)
                .with_context(|| format!("cannot write {}", file.path.display()))?;
        }
        let segments = drawing.tree.segment_count();
        let lines = 55 * segments as u64;
        ready.push(Ready {
            told: Told {
                file: file.path.clone(),
                seed,
                level: None,
                segments,
                triangles: None,
                bound: None,
                bytes: Some(match file.format {
                    Format::Lsys => grammar.len() as u64,
                    _ => lines,
                }),
            },
            format: file.format,
            sides: 3,
            drawing: Arc::clone(&drawing),
            grammar: Some(grammar.clone()),
        });
    }
    Ok((ready, drawing))
}

/// A level of detail of an individual.
struct Coarse {
    drawing: Arc<Drawing>,
    sides: u32,
    segments: usize,
    triangles: u64,
    bound: f32,
}

/// A level of detail, or what a number of triangles allows.
fn coarse(args: &Args, name: &str, drawing: &Drawing, level: Option<u32>) -> Result<Coarse> {
    let (detail, coarse) = match args.triangles {
        Some(budget) => Detail::of_budget(drawing, budget).ok_or_else(|| {
            anyhow!("{name}: no tree has so few triangles as {budget}: give a larger --triangles")
        })?,
        None => {
            let detail = Detail::level(&drawing.tree, level.unwrap_or(0));
            (detail, coarser(drawing, detail.within))
        }
    };
    let thickest = drawing.tree.radius.iter().copied().fold(0.0, f32::max);
    let nodes = usize::try_from(refined_len(&coarse.tree, &coarse.organs)).unwrap_or(usize::MAX);
    Ok(Coarse {
        sides: detail.sides,
        segments: nodes.saturating_sub(coarse.tree.root_count()),
        triangles: triangles_of(&coarse, detail.sides),
        bound: detail.bound(thickest),
        drawing: Arc::new(coarse),
    })
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

/// Bytes that a surface takes as a file, about.
fn estimated(format: Format, coarse: &Coarse) -> u64 {
    let triangles = coarse.triangles;
    // Tubes have a corner more in each ring than sides, for the texture's seam.
    let vertices = triangles + triangles / u64::from(coarse.sides);
    match format {
        Format::Glb => 32 * vertices + 12 * triangles + 119_000,
        Format::Ply => 35 * vertices + 13 * triangles,
        Format::Usda => 88 * vertices + 27 * triangles,
        Format::Obj => 75 * vertices + 45 * triangles,
        Format::Swc | Format::Lsys => 0,
    }
}

/// Writes a file, if anything is to be written.
fn written(args: &Args, file: Ready) -> Result<Told> {
    let Ready {
        mut told,
        format,
        sides,
        drawing,
        grammar,
    } = file;
    let Drawing { tree, organs } = &*drawing;
    if args.dry_run {
        return Ok(told);
    }
    match (format, grammar) {
        (Format::Lsys, Some(text)) => write_atomically(&told.file, text.as_bytes())?,
        _ => export::drawing_with(tree, organs, &ExportParams { sides }, &told.file)?,
    }
    told.bytes = size_of_file(&told.file);
    Ok(told)
}

fn size_of_file(path: &Path) -> Option<u64> {
    std::fs::metadata(path).ok().map(|file| file.len())
}
