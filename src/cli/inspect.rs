//! `ramus inspect`: what a scanned model is like and what is wrong with it.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, anyhow};
use clap::Args as ClapArgs;

use self::facts::Facts;
use super::print_result;
use super::progress::Progress;
use crate::mesh::intersect::{IntersectParams, Intersections, intersections};
use crate::mesh::paint::Paint;
use crate::mesh::report::{Report, ReportParams, report};
use crate::mesh::unit::{Scale, Unit};
use crate::mesh::{Mesh, ReadLimits, read};

mod facts;
mod text;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The model
    model: PathBuf,
    /// Print all that is known as one JSON object on one line
    #[arg(long)]
    json: bool,
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
    /// What colours its surface.
    pub(super) paint: Option<Paint>,
    /// What of the file is not shown as it was meant.
    pub(super) remarks: Vec<String>,
}

/// Reads a model from its file.
pub(super) fn load(path: &Path, cancel: &AtomicBool) -> Result<Loaded> {
    let model = read(path, &ReadLimits::default(), cancel)?;
    Ok(Loaded {
        mesh: model.mesh,
        format: model.format.to_string(),
        unit: model.format.unit(),
        skipped_faces: model.skipped_faces,
        paint: model.paint,
        remarks: model.remarks,
    })
}

/// A model and all that was found out about it.
struct Inspected<'a> {
    path: &'a Path,
    format: &'a str,
    scale: Option<Scale>,
    skipped_faces: usize,
    paint: Option<&'a Paint>,
    remarks: &'a [String],
    report: Report,
    intersections: Intersections,
}

/// Inspects a model that `read` reads.
pub(super) fn run(
    args: &Args,
    read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>,
) -> Result<()> {
    let never = AtomicBool::new(false);
    let loaded = Progress::during("reading", || read(&args.model, &never))?;
    let inspected = inspect(&args.model, &loaded, &never)?;
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
        paint: loaded.paint.as_ref(),
        remarks: &loaded.remarks,
        scale: stated.or_else(|| Scale::guessed(report.size().max_element())),
        report,
        intersections,
    })
}

#[cfg(test)]
mod tests;
