//! `ramus analyze`: a model's centerlines, measured.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result, anyhow, bail};
use clap::Args as ClapArgs;
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::DVec3;

use super::inspect::{Drawn, Loaded, Up, draw_xray};
use super::outputs::{check_places, not_over_each_other, picture_file};
use super::print_result;
use super::progress::Progress;
use crate::app::{centerlines, ends};
use crate::centerline::analysis::{Analysis, ModelFacts};
use crate::centerline::{Centerline, Params, centerline};
use crate::mesh::endpoints::{Endpoint, Kind, propose};
use crate::mesh::pick::Picker;
use crate::mesh::report::{ReportParams, report};
use crate::mesh::surface::Surface;
use crate::mesh::unit::{Scale, Unit};

mod text;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The model: a surface, or a skeleton (SWC) or centerlines (VTP), which are measured as they are
    model: PathBuf,
    /// Where centerlines begin, in the model's coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    source: Option<DVec3>,
    /// Where they end: a .csv or .json file of endpoints; it may hold the source, too
    #[arg(long, value_name = "FILE", conflicts_with = "auto")]
    targets: Option<PathBuf>,
    /// Find the endpoints, which is done for those that are not given, too
    #[arg(long)]
    auto: bool,
    /// Bridge parts that are apart by no more than this, in the model's unit
    #[arg(long, value_name = "GAP", value_parser = gap)]
    bridge: Option<f64>,
    /// Let lines go on to the middles of open ends, which are closed flat, and not end a radius before them
    #[arg(long)]
    cap: bool,
    /// Print all that is known as one JSON object on one line
    #[arg(long)]
    json: bool,
    /// Write the branches and centerlines as a table
    #[arg(long, value_name = "FILE", value_parser = table_file())]
    csv: Option<PathBuf>,
    /// Write the centerlines as .swc, .vtp or .glb
    #[arg(long, value_name = "FILE", value_parser = centerline_file())]
    export: Option<PathBuf>,
    /// Draw the model with its centerlines into a PNG picture
    #[arg(long, value_name = "FILE", value_parser = picture_file())]
    png: Option<PathBuf>,
    /// Which of the file's axes points up in the picture; without it the second of glTF, OBJ and SWC files, the third of others
    #[arg(long, value_enum, value_name = "AXIS", requires = "png")]
    up: Option<Up>,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, requires = "png", value_parser = clap::value_parser!(u32).range(1..))]
    size: u32,
}

fn point(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|one| one.trim().parse()).collect();
    match numbers.as_deref() {
        Ok([x, y, z]) if [x, y, z].iter().all(|one| one.is_finite()) => Ok(DVec3::new(*x, *y, *z)),
        _ => Err("three numbers with commas between are asked for, such as 1.5,-2,30".to_owned()),
    }
}

fn gap(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(gap) if gap.is_finite() && gap >= 0.0 => Ok(gap),
        _ => Err("a length that is not below zero is asked for".to_owned()),
    }
}

fn table_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("csv") => Ok(path),
        _ => Err(format!(
            "{}: tables are written as CSV; use the ending .csv",
            path.display()
        )),
    })
}

fn centerline_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| centerlines::Format::of(&path).map(|_| path))
}

/// Analyzes a model that `read` reads.
pub(super) fn run(
    args: &Args,
    read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>,
) -> Result<()> {
    let never = AtomicBool::new(false);
    // All that can be refused is, before any work.
    let outputs = || args.csv.iter().chain(&args.export).chain(&args.png);
    not_over_each_other(Some(&args.model), outputs().map(PathBuf::as_path), None)?;
    check_places(outputs())?;
    let given = args
        .targets
        .as_deref()
        .map(ends::read)
        .transpose()
        .map_err(anyhow::Error::msg)?;
    let started = Instant::now();
    let loaded = Progress::during("reading", || read(&args.model, &never))?;
    let load = milliseconds(started);
    let name = args.model.display();
    let cannot = || format!("cannot analyze {name}");
    let (mut analysis, found) = match &loaded.skeleton {
        Some(skeleton) => {
            let is_sought = args.source.is_some() || given.is_some() || args.auto;
            if is_sought || args.bridge.is_some() || args.cap {
                bail!(
                    "{name} is a skeleton already: leave out --source, --targets, --auto, --bridge and --cap, and it is measured as it is"
                );
            }
            let found = Centerline {
                tree: skeleton.clone(),
                origin: loaded.mesh.origin,
                ..Centerline::default()
            };
            let model = ModelFacts {
                file: name.to_string(),
                unit: loaded.scale.map(|scale| scale.unit.name()),
                ..ModelFacts::default()
            };
            let measuring = Instant::now();
            let mut analysis = Analysis::new(model, &found, false, 0);
            analysis.timing_ms.measure = milliseconds(measuring);
            (analysis, found)
        }
        None => of_surface(args, &loaded, given).with_context(cannot)?,
    };
    analysis.timing_ms.load = load;
    if let Some(path) = &args.csv {
        centerlines::write_tables(&analysis, path)?;
    }
    if let Some(path) = &args.export {
        centerlines::write(&found, path)?;
    }
    let text = match args.json {
        true => serde_json::to_string(&analysis)? + "\n",
        false => text::screen(&analysis),
    };
    let printed = print_result("the analysis", |out| out.write_all(text.as_bytes()));
    if let Some(path) = &args.png {
        let drawn = Drawn {
            unit: loaded.scale.map_or(Unit::Metres, |scale| scale.unit),
            z_up: args.up.map_or(loaded.z_up, |up| up == Up::Z),
            pixels: args.size,
            endpoints: found.endpoints,
            skeleton: found.tree,
        };
        draw_xray(&Arc::new(loaded.mesh), drawn, path)
            .with_context(|| format!("cannot draw {name}"))?;
    }
    printed
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Finds endpoints where they are not given, the centerlines, and measures them.
fn of_surface(
    args: &Args,
    loaded: &Loaded,
    given: Option<Vec<Endpoint>>,
) -> Result<(Analysis, Centerline)> {
    let never = AtomicBool::new(false);
    let stopped = || anyhow!("it was cancelled");
    let repairing = Instant::now();
    let mut progress = Progress::new("checking");
    let report = report(
        &loaded.mesh,
        &ReportParams::default(),
        &never,
        &mut |done, of| progress.show(done, of),
    )?;
    let mut progress = Progress::new("preparing");
    let picker = Picker::new(Arc::new(loaded.mesh.clone()), &never, &mut |done, of| {
        progress.show(done, of)
    });
    let surface = picker
        .and_then(|picker| Surface::new(picker, &never))
        .ok_or_else(stopped)?;
    let repair = milliseconds(repairing);
    let finding = Instant::now();
    let endpoints = endpoints(args, given, &surface)?;
    let mut progress = Progress::new("looking for centerlines");
    let params = Params {
        bridge: args.bridge,
        proposed: args.source.is_none() && args.targets.is_none(),
        cap: args.cap,
    };
    let found = centerline(&surface, &endpoints, &params, &never, &mut |done, of| {
        progress.show(done, of)
    })?;
    let finding = milliseconds(finding);
    if args.cap && found.capped == 0 {
        whisper!("no line begins or ends at an open end: --cap changes nothing");
    }
    for one in &found.unreached {
        whisper!("{} is {one}", one.name);
    }
    let scale = loaded
        .scale
        .or_else(|| Scale::guessed(report.size().max_element()));
    let model = ModelFacts::new(args.model.display().to_string(), &report, scale);
    let loops = report
        .components
        .iter()
        .filter_map(|component| component.genus())
        .sum::<u32>();
    let measuring = Instant::now();
    let automatic = args.targets.is_none();
    let mut analysis = Analysis::new(model, &found, automatic, loops as usize);
    analysis.timing_ms.repair = repair;
    analysis.timing_ms.centerline = finding;
    analysis.timing_ms.measure = milliseconds(measuring);
    Ok((analysis, found))
}

/// What was given, and what is found for what was not.
fn endpoints(
    args: &Args,
    given: Option<Vec<Endpoint>>,
    surface: &Surface,
) -> Result<Vec<Endpoint>> {
    let source = args.source.map(|point| Endpoint {
        point,
        name: "source".to_owned(),
        kind: Kind::Source,
        snapped: None,
    });
    let mut ends = match given {
        Some(given) => given,
        None => {
            let never = AtomicBool::new(false);
            let found =
                Progress::during("proposing ends", || propose(surface, &never)).unwrap_or_default();
            let mut found: Vec<Endpoint> = found.into_iter().map(|one| one.endpoint).collect();
            if found.len() < 2 {
                bail!("no ends were found on its surface: give some with --source and --targets");
            }
            if let Some(source) = &source {
                // The end that the source stands for is not a target of its own.
                let distance = |end: &Endpoint| end.point.distance(source.point);
                let nearest = found
                    .iter()
                    .enumerate()
                    .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
                let nearest = nearest.map(|(place, _)| place);
                nearest.map(|place| found.remove(place));
                found.iter_mut().for_each(|end| end.kind = Kind::Target);
            }
            found
        }
    };
    if let Some(source) = source {
        ends.retain(|end| end.kind == Kind::Target);
        ends.insert(0, source);
    }
    Ok(ends)
}
