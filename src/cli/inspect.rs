//! `ramus inspect`: what a scanned model is like and what is wrong with it, and what of that is mended when it is asked for.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, anyhow};
use clap::Args as ClapArgs;

use self::facts::Facts;
pub(super) use self::pictured::Up;
use self::pictured::{Look, Subject};
use super::outputs::{check_places, endpoints_file, model_file, not_over_each_other, picture_file};
use super::print_result;
use super::progress::Progress;
use crate::app::ends;
use crate::app::scans::stands_on_its_third_axis;
use crate::mesh::endpoints::{Endpoint, propose};
use crate::mesh::intersect::{IntersectParams, Intersections, intersections};
use crate::mesh::mend::Account;
use crate::mesh::paint::Paint;
use crate::mesh::pick::Picker;
use crate::mesh::report::{Report, ReportParams, report};
use crate::mesh::surface::Surface;
use crate::mesh::unit::{Rounded, Scale, Unit};
use crate::mesh::{Mesh, ReadLimits, read};
use crate::tree::Tree;

mod facts;
mod pictured;
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
    /// Draw the model, mended where --repair is given, into a PNG picture
    #[arg(long, value_name = "FILE", value_parser = picture_file())]
    png: Option<PathBuf>,
    /// What the picture shows, separated by commas
    #[arg(
        long,
        value_enum,
        value_name = "LOOKS",
        value_delimiter = ',',
        requires = "png"
    )]
    look: Vec<Look>,
    /// Propose ends of the model, mended where --repair is given, and write them as .csv or .json; the picture shows them
    #[arg(long, value_name = "FILE", value_parser = endpoints_file())]
    propose: Option<PathBuf>,
    /// Show these endpoints in the picture, from a .csv or .json file
    #[arg(
        long,
        value_name = "FILE",
        requires = "png",
        conflicts_with = "propose"
    )]
    endpoints: Option<PathBuf>,
    /// Which of the file's axes points up in the picture; without it the second of glTF, OBJ and SWC files, the third of others
    #[arg(long, value_enum, value_name = "AXIS", requires = "png")]
    up: Option<Up>,
    /// Width and height of the picture in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1024, requires = "png", value_parser = clap::value_parser!(u32).range(1..))]
    size: u32,
}

/// A model as its file has it.
pub(super) struct Loaded {
    pub(super) mesh: Mesh,
    /// What the format is called.
    pub(super) format: String,
    /// What the format says of the unit, if it does.
    pub(super) scale: Option<Scale>,
    pub(super) beside: Beside,
    /// What colours its surface.
    pub(super) paint: Option<Paint>,
    /// What the surface was made around.
    pub(super) skeleton: Option<Tree>,
    /// What of the file is not shown as it was meant.
    pub(super) remarks: Vec<String>,
    /// Whether its third axis points up in pictures.
    pub(super) z_up: bool,
}

/// What a file holds beside its surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Beside {
    /// Faces of fewer than three corners, which were left out.
    pub(super) skipped_faces: usize,
    /// Lines and points, which were left out.
    pub(super) skipped_lines: usize,
    pub(super) skipped_points: usize,
    /// Bytes behind its end.
    pub(super) surplus_bytes: usize,
    /// Nodes of the skeleton that the surface was made of.
    pub(super) skeleton_nodes: Option<usize>,
}

/// Reads a model from its file.
pub(super) fn load(path: &Path, cancel: &AtomicBool) -> Result<Loaded> {
    let model = read(path, &ReadLimits::default(), cancel)?;
    Ok(Loaded {
        scale: model.scale(),
        z_up: stands_on_its_third_axis(model.format),
        format: model.format.to_string(),
        beside: Beside {
            skipped_faces: model.skipped_faces,
            skipped_lines: model.skipped_lines,
            skipped_points: model.skipped_points,
            surplus_bytes: model.surplus_bytes,
            skeleton_nodes: model.skeleton.as_ref().map(Tree::len),
        },
        mesh: model.mesh,
        paint: model.paint,
        skeleton: model.skeleton,
        remarks: model.remarks,
    })
}

/// A model and all that was found out about it.
struct Inspected<'a> {
    path: &'a Path,
    format: &'a str,
    scale: Option<Scale>,
    beside: Beside,
    paint: Option<&'a Paint>,
    remarks: &'a [String],
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
    let outputs = || args.out.iter().chain(&args.png).chain(&args.propose);
    not_over_each_other(Some(&args.model), outputs().map(PathBuf::as_path), None)?;
    check_places(outputs())?;
    let read_ends = args.endpoints.as_deref().map(ends::read);
    let mut endpoints = read_ends
        .transpose()
        .map_err(anyhow::Error::msg)?
        .unwrap_or_default();
    let mut loaded = Progress::during("reading", || read(&args.model, &never))?;
    // Mends join and replace the vertices that colours are put on by.
    let before = (mends.is_some() && loaded.paint.is_some() && args.png.is_some())
        .then(|| loaded.mesh.clone());
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
        if loaded.paint.is_some() {
            whisper!(
                "what colours the model is not written into {}",
                out.display()
            );
        }
    }
    let mut inspected = inspect(&args.model, &loaded, &never)?;
    inspected.repairs = repairs;
    let facts = Facts::new(&inspected);
    let text = match args.json {
        true => serde_json::to_string(&facts)? + "\n",
        false => text::screen(&facts),
    };
    let unit = inspected.scale.map_or(Unit::Metres, |scale| scale.unit);
    let Inspected {
        report,
        intersections,
        ..
    } = inspected;
    let printed = print_result("the report", |out| out.write_all(text.as_bytes()));
    let Loaded {
        mesh,
        z_up,
        paint,
        skeleton,
        ..
    } = loaded;
    let mesh = Arc::new(mesh);
    let mut surface = None;
    if let Some(path) = &args.propose {
        let surface = surface.insert(with_surface(&mesh)?);
        endpoints = propose_into(surface, path)?;
    }
    if let Some(path) = &args.png {
        let colours = pictured::colours(&args.look, &mesh, &report, &intersections);
        let subject = Subject {
            looks: &args.look,
            z_up: args.up.map_or(z_up, |up| up == Up::Z),
            pixels: args.size,
            unit,
            endpoints,
            skeleton,
        };
        let surface = || surface.map_or_else(|| with_surface(&mesh), Ok);
        let range = pictured::draw(
            surface,
            &mesh,
            paint.map(|paint| (paint, before)),
            colours,
            subject,
            path,
        )
        .with_context(|| format!("cannot draw {}", args.model.display()))?;
        if let Some([low, high]) = range {
            let [low, high] = [low, high].map(|end| Rounded(end.into()));
            whisper!("the colours run from {low} to {high}, in the file's unit");
        }
    }
    printed
}

/// What goes into the picture of a model that is seen through.
pub(super) struct Drawn {
    pub(super) unit: Unit,
    pub(super) z_up: bool,
    pub(super) pixels: u32,
    pub(super) endpoints: Vec<Endpoint>,
    /// From the mesh's origin.
    pub(super) skeleton: Tree,
}

/// Draws a model that is seen through, with what lies inside it.
pub(super) fn draw_xray(mesh: &Arc<Mesh>, drawn: Drawn, path: &Path) -> Result<()> {
    let subject = Subject {
        looks: &[Look::XRay],
        z_up: drawn.z_up,
        pixels: drawn.pixels,
        unit: drawn.unit,
        endpoints: drawn.endpoints,
        skeleton: Some(drawn.skeleton),
    };
    pictured::draw(|| with_surface(mesh), mesh, None, Vec::new(), subject, path).map(|_| ())
}

/// Where a mesh is measured.
fn with_surface(mesh: &Arc<Mesh>) -> Result<Surface> {
    let never = AtomicBool::new(false);
    let mut progress = Progress::new("preparing");
    let mut show = |done, of| progress.show(done, of);
    let picker = Picker::new(Arc::clone(mesh), &never, &mut show);
    let surface = picker.and_then(|picker| Surface::new(picker, &never));
    surface.ok_or_else(|| anyhow!("the preparing of the model was cancelled"))
}

/// Proposes ends and writes them.
fn propose_into(surface: &Surface, path: &Path) -> Result<Vec<Endpoint>> {
    let never = AtomicBool::new(false);
    let proposals = Progress::during("proposing ends", || propose(surface, &never));
    let endpoints: Vec<Endpoint> = proposals
        .unwrap_or_default()
        .into_iter()
        .map(|proposal| proposal.endpoint)
        .collect();
    ends::write(path, &endpoints).map_err(anyhow::Error::msg)?;
    whisper!("proposed ends: {}, in {}", endpoints.len(), path.display());
    Ok(endpoints)
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
    Ok(Inspected {
        path,
        format: &loaded.format,
        beside: loaded.beside,
        paint: loaded.paint.as_ref(),
        remarks: &loaded.remarks,
        scale: loaded
            .scale
            .or_else(|| Scale::guessed(report.size().max_element())),
        report,
        intersections,
        repairs: None,
    })
}

#[cfg(test)]
mod tests;
