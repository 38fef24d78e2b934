//! `ramus export`: a project's tree or a grammar's as files for other programs, in levels of detail and many individuals.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use anyhow::{Context as _, Result, bail, ensure};
use clap::Args as ClapArgs;

use super::outputs::{check_places, light, not_over_each_other, picture_file};
use super::print_result;
use super::progress::{Progress, start_watch};
use crate::app::export;
use crate::app::portrait::{self, Scenery};
use crate::render::Backdrop;
use crate::tree::Drawing;
use crate::tree::detail::Detail;
use crate::tree::foliage::Season;
use crate::tree::vary::Spread;
use crate::world::scene::weather::Light;
use extras::{ExtraArgs, Growth};
use files::{All, File, Format, Told, counted, files};
use source::{Source, source, spread};

mod coarse;
mod estimate;
mod extras;
mod files;
mod grove;
mod single;
mod source;
mod wood;

/// Files, and individuals in one picture, at most.
const FILES_MOST: u64 = 100_000;
const SHEET_MOST: usize = 400;
/// Trees of a grove at most: it lies in memory whole.
const GROVE_MOST: u32 = 1000;
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
    #[arg(long, value_name = "PIXELS", requires = "sheet", default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=2048))]
    size: u32,
    /// What lights that picture: each stands on the ground under its sky then, and not on paper
    #[arg(long, value_name = "LIGHT", requires = "sheet", value_parser = light())]
    light: Option<Light>,
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
    /// All individuals in one file, side by side on the ground, with materials and pictures in common; of a project with planted trees, and no count or seed, these where they stand
    #[arg(long)]
    grove: bool,
    /// Degrees that branches of individuals are turned at most; of a sketch 12 where it has a seed or a count, else 0
    #[arg(long, value_name = "DEGREES", value_parser = up_to_90)]
    angles: Option<f32>,
    /// Percent that segments of individuals are longer or shorter at most; of a sketch 15 where it has a seed or a count, else 0
    #[arg(long, value_name = "PERCENT", value_parser = up_to_90)]
    lengths: Option<f32>,
    #[command(flatten)]
    extra: ExtraArgs,
    /// Only tell what would be written, with triangles and bytes
    #[arg(long)]
    dry_run: bool,
    /// Tell what was written as one JSON object on one line
    #[arg(long)]
    json: bool,
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

pub(super) fn run(args: &Args) -> Result<()> {
    let source = source(args)?;
    let spread = spread(args, &source);
    let (shoots, files) = planned(args, &source, spread)?;
    start_watch();
    let began = Instant::now();
    let plan = Plan {
        args,
        source: &source,
        spread,
        shoots: &shoots,
    };
    let first = files.first().map_or(&[][..], Vec::as_slice);
    let done = match (args.grove, wood::of(args, &source)) {
        (true, Some(planted)) => wood::write(&plan, planted, first)?,
        (true, None) => grove::write(&plan, first)?,
        (false, _) => single::write(&plan, &files)?,
    };
    if let Some(path) = args.sheet.as_ref().filter(|_| !args.dry_run) {
        let scenery = args.light.map_or(portrait::PAPER.into(), |light| Scenery {
            backdrop: Backdrop::Stage,
            light,
        });
        let draw = || portrait::sheet(&done.drawings, args.size, scenery);
        let picture = Progress::during("drawing", draw).context("cannot draw the individuals")?;
        export::png(&picture, path)?;
    }
    finish(args, done, began.elapsed().as_secs_f64())
}

/// What is to be grown.
struct Plan<'a> {
    args: &'a Args,
    source: &'a Source,
    spread: Spread,
    shoots: &'a [Shoot],
}

/// An individual, at a step where it is one of several.
#[derive(Clone, Copy, Debug)]
struct Shoot {
    seed: u64,
    step: Option<u32>,
}

/// What was written.
struct Done {
    told: Vec<Told>,
    /// Where a picture is to be drawn of them.
    drawings: Vec<Arc<Drawing>>,
    /// Trees that draw something, whether they are kept here or not.
    drawn: usize,
    /// Whether the list could be.
    printed: Result<()>,
}

/// The individuals and the files of each, if all may be asked for and written.
fn planned(args: &Args, source: &Source, spread: Spread) -> Result<(Vec<Shoot>, Vec<Vec<File>>)> {
    let first = args.seed.unwrap_or_else(|| source.seed(args));
    let Some(last) = first.checked_add(u64::from(args.count) - 1) else {
        bail!(
            "seeds end at {}: take a smaller --seed or --count",
            u64::MAX
        );
    };
    let steps = steps(args, source)?;
    let each = files(args, first, None, None).len() as u64;
    let all = match args.grove {
        true => each,
        false => u64::from(args.count) * each * steps.len() as u64,
    };
    ensure!(
        all <= FILES_MOST,
        "{all} files are too many for one command: take a smaller --count, or fewer --growth-steps"
    );
    check_detail(args)?;
    check_grove(args)?;
    if args.count > 1 && source.has_one_individual(spread) {
        whisper!(
            "nothing in {} is left to chance, so its {} individuals are the same tree: give --angles and --lengths",
            args.file.display(),
            args.count
        );
    }
    wood::check(args, source)?;
    extras::check(args, spread)?;
    ensure!(
        spread == Spread::NONE || !args.format.contains(&Format::Lsys),
        "a grammar does not say how its individuals are turned and longer by --angles and --lengths: leave lsys out, or set both to 0"
    );
    let shoots: Vec<Shoot> = (first..=last)
        .flat_map(|seed| steps.iter().map(move |step| Shoot { seed, step: *step }))
        .collect();
    let last_step = steps.last().copied().flatten();
    let files_of = |shoot: &Shoot| files(args, shoot.seed, shoot.step, last_step);
    let files: Vec<Vec<File>> = match args.grove {
        true => shoots.iter().take(1).map(files_of).collect(),
        false => shoots.iter().map(files_of).collect(),
    };
    let all = || files.iter().flatten().map(|file| &file.path);
    let pixels = shoots.len() as u64 * u64::from(args.size).pow(2);
    ensure!(
        args.sheet.is_none() || shoots.len() <= SHEET_MOST && pixels <= PIXELS_MOST,
        "one picture of {} individuals of {} pixels is too large: take a smaller --count or --size",
        shoots.len(),
        args.size
    );
    let all = || all().chain(&args.sheet);
    not_over_each_other(Some(&args.file), all().map(PathBuf::as_path), None)?;
    if !args.dry_run {
        ensure!(
            args.out.is_dir() || !args.out.exists(),
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
    Ok((shoots, files))
}

/// The steps that are written: the last alone, which need not be known before, or a sequence.
fn steps(args: &Args, source: &Source) -> Result<Vec<Option<u32>>> {
    if args.extra.growth != Some(Growth::Sequence) {
        return Ok(vec![None]);
    }
    let last = source.steps(args)?;
    let count = args.extra.growth_steps.unwrap_or(u32::MAX).min(last).max(1);
    let first = (last - last.min(count - 1)).max(1).min(last);
    // So many are refused before they are files.
    let steps = (first..=last).take(usize::try_from(FILES_MOST + 1).unwrap_or(usize::MAX));
    Ok(steps.map(Some).collect())
}

/// Refuses a detail of which no file would have any.
fn check_detail(args: &Args) -> Result<()> {
    let asks = args.triangles.is_some() || args.lod != [0];
    ensure!(
        !asks || args.format.iter().any(|format| format.is_surface()),
        "--lod and --triangles are about surfaces, and none is to be written: name glb, usda, ply or obj with --format, or leave them out"
    );
    Ok(())
}

/// Refuses what a grove cannot be.
fn check_grove(args: &Args) -> Result<()> {
    if !args.grove {
        return Ok(());
    }
    let skeleton = args.format.iter().find(|format| !format.is_surface());
    if let Some(format) = skeleton {
        bail!(
            "a {} file holds one tree: leave {} out, or --grove",
            format.ending(),
            format.ending()
        );
    }
    ensure!(
        args.count <= GROVE_MOST,
        "{} trees are too many for one file, which holds {GROVE_MOST}: take a smaller --count",
        args.count
    );
    Ok(())
}

/// What is told at the end.
fn finish(args: &Args, done: Done, seconds: f64) -> Result<()> {
    let Done {
        told,
        drawn,
        printed,
        ..
    } = done;
    let triangles = told.iter().filter_map(|one| one.triangles).sum();
    if args.json {
        let all = All {
            format: "ramus-export/1",
            files: &told,
            sheet: args.sheet.as_deref().filter(|_| !args.dry_run),
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
    let files = counted(told.len() as u64, "file");
    let triangles = counted(triangles, "triangle");
    let sheet = args.sheet.as_ref().map_or_else(String::new, |path| {
        let shown = match args.extra.growth {
            Some(Growth::Sequence) => "step",
            _ => "individual",
        };
        let shown = counted(drawn as u64, shown);
        format!(" and a picture of {shown}, {},", path.display())
    });
    tell!("{files} of {triangles}{sheet} {what} in {seconds:.1} s");
    Ok(())
}
