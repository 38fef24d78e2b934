//! `ramus inspect`: what a scanned model is like and what is wrong with it, and what of that is mended when it is asked for.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, anyhow};
use clap::Args as ClapArgs;

use self::facts::Facts;
use super::outputs::{check_places, model_file, not_over_each_other};
use super::print_result;
use super::progress::Progress;
use crate::mesh::intersect::{IntersectParams, Intersections, intersections};
use crate::mesh::mend::Account;
use crate::mesh::report::{Report, ReportParams, report};
use crate::mesh::unit::{Scale, Unit};
use crate::mesh::{Mesh, ReadLimits, read};

mod facts;
mod repair;
mod text;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The model
    model: PathBuf,
    /// Print all that is known as one JSON object on one line
    #[arg(long)]
    json: bool,
    /// Mend the model by a list, in its order, and report on the result: weld, debris, largest, orient, close, smooth, decimate, remesh
    #[arg(long, value_name = "LIST")]
    repair: Option<String>,
    /// Write the model, mended where --repair is given, as .glb, .ply, .stl or .obj
    #[arg(short, long, value_name = "FILE", value_parser = model_file())]
    out: Option<PathBuf>,
}

/// A model as its file has it.
pub(super) struct Loaded {
    pub(super) mesh: Mesh,
    /// What the format is called.
    pub(super) format: String,
    /// The unit that the format prescribes, if it does.
    pub(super) unit: Option<Unit>,
    /// Faces of fewer than three corners, which were left out.
    pub(super) skipped_faces: usize,
}

/// Reads a model from its file.
pub(super) fn load(path: &Path, cancel: &AtomicBool) -> Result<Loaded> {
    let model = read(path, &ReadLimits::default(), cancel)?;
    Ok(Loaded {
        mesh: model.mesh,
        format: model.format.to_string(),
        unit: None,
        skipped_faces: model.skipped_faces,
    })
}

/// A model and all that was found out about it.
struct Inspected<'a> {
    path: &'a Path,
    format: &'a str,
    scale: Option<Scale>,
    skipped_faces: usize,
    report: Report,
    intersections: Intersections,
    /// What was mended; None where nothing was asked for.
    repairs: Option<Vec<Account>>,
}

/// Inspects a model that `read` reads.
pub(super) fn run(
    args: &Args,
    read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>,
) -> Result<()> {
    let never = AtomicBool::new(false);
    // All that can be refused is, before any work.
    let mends = args.repair.as_deref().map(repair::mends).transpose()?;
    let outputs = args.out.iter().map(PathBuf::as_path);
    not_over_each_other(Some(&args.model), outputs, None)?;
    check_places(&args.out)?;
    let mut loaded = Progress::during("reading", || read(&args.model, &never))?;
    let repairs = match &mends {
        Some(mends) => Some(repair::mended(
            &mut loaded.mesh,
            mends,
            &never,
            &args.model,
        )?),
        None => None,
    };
    if let Some(out) = &args.out {
        repair::write(&loaded.mesh, out)?;
    }
    let mut inspected = inspect(&args.model, &loaded, &never)?;
    inspected.repairs = repairs;
    let facts = Facts::new(&inspected);
    let text = match args.json {
        true => serde_json::to_string(&facts)? + "\n",
        false => text::screen(&facts),
    };
    print_result("the report", |out| out.write_all(text.as_bytes()))
}

fn inspect<'a>(path: &'a Path, loaded: &'a Loaded, cancel: &AtomicBool) -> Result<Inspected<'a>> {
    let mut progress = Progress::new("checking");
    let mut show = |done, of| progress.show(done, of);
    let report = report(&loaded.mesh, &ReportParams::default(), cancel, &mut show)
        .with_context(|| format!("cannot check {}", path.display()))?;
    let mut progress = Progress::new("looking for self-intersections");
    let mut show = |done, of| progress.show(done, of);
    let intersections = intersections(&loaded.mesh, &IntersectParams::default(), cancel, &mut show)
        .ok_or_else(|| anyhow!("the check of {} was cancelled", path.display()))?;
    let stated = loaded.unit.map(Scale::stated);
    Ok(Inspected {
        path,
        format: &loaded.format,
        skipped_faces: loaded.skipped_faces,
        scale: stated.or_else(|| Scale::guessed(report.size().max_element())),
        report,
        intersections,
        repairs: None,
    })
}

#[cfg(test)]
mod tests;
