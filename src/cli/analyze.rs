//! `ramus analyze`: a model's centerlines, measured.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use anyhow::{Context as _, Result};
use clap::Args as ClapArgs;
use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::DVec3;

use super::inspect::{Drawn, Loaded, Up, draw_xray};
use super::outputs::{check_places, not_over_each_other, picture_file};
use super::print_result;
use super::progress::Progress;
use crate::app::analysis::{
    Wanted, checked, endpoints, found, given_to_skeleton, measured, prepared, skeleton,
};
use crate::app::{centerlines, ends};
use crate::centerline::Centerline;
use crate::centerline::analysis::Analysis;
use crate::mesh::unit::Unit;

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
    let wanted = Wanted {
        source: args.source,
        endpoints: given,
        bridge: args.bridge,
        cap: args.cap,
    };
    let (mut analysis, found) = match &loaded.skeleton {
        Some(_) if args.auto => return Err(given_to_skeleton(&name.to_string())),
        Some(tree) => {
            let measuring = Instant::now();
            let origin = loaded.mesh.origin;
            let name = name.to_string();
            let (mut analysis, found) = skeleton(&wanted, tree, origin, &name, loaded.scale)?;
            analysis.timing_ms.measure = milliseconds(measuring);
            (analysis, found)
        }
        None => of_surface(args, &loaded, &wanted).with_context(cannot)?,
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
fn of_surface(args: &Args, loaded: &Loaded, wanted: &Wanted) -> Result<(Analysis, Centerline)> {
    let repairing = Instant::now();
    let mut progress = Progress::new("checking");
    let report = checked(&loaded.mesh, &mut |done, of| progress.show(done, of))?;
    let mut progress = Progress::new("preparing");
    let prepared = prepared(&loaded.mesh, report, &mut |done, of| {
        progress.show(done, of)
    })?;
    let repair = milliseconds(repairing);
    let finding = Instant::now();
    let endpoints = Progress::during("proposing ends", || endpoints(wanted, &prepared))?;
    let mut progress = Progress::new("looking for centerlines");
    let found = found(wanted, &prepared, &endpoints, &mut |done, of| {
        progress.show(done, of)
    })?;
    let finding = milliseconds(finding);
    if args.cap && found.capped == 0 {
        whisper!("no line begins or ends at an open end: --cap changes nothing");
    }
    for one in &found.unreached {
        whisper!("{} is {one}", one.name);
    }
    let measuring = Instant::now();
    let name = args.model.display().to_string();
    let mut analysis = measured(wanted, &prepared, &found, name, loaded.scale);
    analysis.timing_ms.repair = repair;
    analysis.timing_ms.centerline = finding;
    analysis.timing_ms.measure = milliseconds(measuring);
    Ok((analysis, found))
}
