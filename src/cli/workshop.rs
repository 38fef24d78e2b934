//! `ramus`: the workshop, in the headset that answers, else as a demonstration on the simulated one.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use clap::{Args as ClapArgs, ValueEnum};
use ramus_xr::Headset;
use ramus_xr::record::Recorder;
use ramus_xr::simulated::Simulated;

use super::not_over_each_other;
use super::progress::Progress;
use super::replay::EXTENT;
use crate::app::album::Album;
use crate::app::headset::{self, Opened};
use crate::app::picture::Picture;
use crate::app::session::{self, Nobody};
use crate::app::store::{Store, read_project};
use crate::app::workshop::{Workshop, WorkshopParams};
use crate::app::{demonstration, portrait, take_home};
use crate::world::World;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The project to go on with, or to begin
    #[arg(long, value_name = "FILE.ramus")]
    project: Option<PathBuf>,
    /// Where pictures and exports go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Record the session into this file, to be played by `ramus replay`
    #[arg(long, value_name = "FILE.session")]
    record: Option<PathBuf>,
    /// Which headset to use
    #[arg(long, value_enum, default_value_t = Which::Auto, value_name = "WHICH")]
    headset: Which,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Which {
    /// The one behind the OpenXR runtime, else the simulated one
    Auto,
    /// The one behind the OpenXR runtime, or an error
    Openxr,
    /// The built-in one, which needs no device
    Simulated,
}

pub(super) fn run(args: &Args) -> Result<()> {
    if let Some(project) = &args.project {
        // Before anything starts: a session's end is too late to refuse its files.
        let made = ["glb", "lsys"].map(|ending| project.with_extension(ending));
        let looked_at = tree_of(project, &args.out);
        not_over_each_other(Some(project), made.iter().map(PathBuf::as_path))?;
        not_over_each_other(Some(project), [looked_at.as_path()])?;
    }
    if args.headset != Which::Simulated {
        match headset::connect() {
            Ok(system) => return in_headset(Opened::start(system)?, args),
            Err(error) if args.headset == Which::Openxr => return Err(error.into()),
            Err(error) => tell!("No headset: {error}."),
        }
    }
    make_folder(&args.out)?;
    match &args.project {
        Some(_) if args.record.is_some() => {
            bail!(
                "a project is only looked at without a headset, so there is no session to record: leave --record out"
            )
        }
        Some(project) => look_at(project, &args.out),
        None => demonstrate(&args.out, args.record.as_deref()),
    }
}

fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))
}

/// The workshop itself.
fn in_headset(opened: Opened, args: &Args) -> Result<()> {
    let default = || args.out.join("workshop.ramus");
    let project = args.project.clone().unwrap_or_else(default);
    if args.project.is_none() {
        make_folder(&args.out)?;
    }
    tell!("In the headset: {}.", opened.describe());
    let store = Store::open(&project)?;
    if let Some(message) = &store.message {
        tell!("{message}");
    }
    let mut workshop = Workshop::new(store, WorkshopParams::default())?;
    let outcome = match &args.record {
        None => opened.run(|headset| headset, &mut workshop, &mut Nobody).1,
        Some(path) => {
            let output = recording(path)?;
            let record = |headset| Recorder::new(headset, output);
            let (recorder, outcome) = opened.run(record, &mut workshop, &mut Nobody);
            tell_recording(recorder, path);
            outcome
        }
    };
    // However the session ended, the work is saved first.
    workshop.finish_tree();
    let world = workshop.close()?;
    tell!(
        "Saved {}: {}.",
        project.display(),
        take_home::summary(&world)
    );
    if world.document().step > 0 {
        let glb = project.with_extension("glb");
        take_home::export(&world, &glb)?;
        tell!("The tree is in {}.", glb.display());
        let lsys = project.with_extension("lsys");
        take_home::grammar(&world, &lsys)?;
        tell!("Its grammar is in {}.", lsys.display());
    }
    Ok(outcome?)
}

/// A recording that is being written.
type Recording = BufWriter<File>;

fn recording(path: &Path) -> Result<Recording> {
    // Sessions are not made again: an older one is never written over.
    let file = File::create_new(path)
        .with_context(|| format!("cannot record the session into {}", path.display()))?;
    Ok(BufWriter::new(file))
}

/// Says what became of a recording; the session itself is not touched by its failure.
fn tell_recording<H: Headset>(recorder: Recorder<H, Recording>, path: &Path) {
    let (_headset, written) = recorder.finish();
    match written {
        Ok(_) => tell!("  session   {}", path.display()),
        Err(error) => whisper!(
            "ramus: the recording {} is not whole: {error}",
            path.display()
        ),
    }
}

/// Without a headset and without a project: a recorded session shows what the workshop is.
fn demonstrate(out: &Path, record: Option<&Path>) -> Result<()> {
    tell!("Playing the recorded session first-tree on the built-in simulated headset …");
    let frames = demonstration::first_tree()?;
    let total = frames.len();
    let project = out.join("first-tree.ramus");
    let opened = Store::begin(&project)?;
    if let Some(message) = &opened.message {
        tell!("{message}");
    }
    let mut workshop = Workshop::new(opened, WorkshopParams::default())?;
    let gpu = portrait::open_gpu()?;
    let mut picture = Picture::offscreen(&gpu, EXTENT.width, EXTENT.height)?;
    let mut headset = Simulated::new(frames, EXTENT);
    let mut progress = Progress::new("playing");
    let mut album = Album::new(Some(out), Box::new(|frame| progress.show(frame, total)))?;
    let mut play = |headset: &mut dyn Headset| {
        session::run(headset, &mut workshop, Some(&mut picture), &mut album)
    };
    let outcome = match record {
        None => play(&mut headset),
        Some(path) => {
            let mut recorder = Recorder::new(headset, recording(path)?);
            let outcome = play(&mut recorder);
            tell_recording(recorder, path);
            outcome
        }
    };
    let steps = album.steps().clone();
    drop(album);
    drop(progress);
    workshop.finish_tree();
    let world = workshop.close()?;
    outcome?;
    let glb = out.join("first-tree.glb");
    take_home::export(&world, &glb)?;
    let lsys = out.join("first-tree.lsys");
    take_home::grammar(&world, &lsys)?;
    tell!(
        "A tree was drawn with two controllers and grown: {}.",
        take_home::summary(&world)
    );
    tell(out, steps.len(), Some(&project), &glb);
    tell!("  grammar   {}", lsys.display());
    tell!(
        "With a headset the same command starts the workshop in it; `ramus doctor` says what is missing."
    );
    Ok(())
}

/// Where the tree of a project goes that is only looked at.
fn tree_of(project: &Path, out: &Path) -> PathBuf {
    out.join(project.file_stem().unwrap_or_default())
        .with_extension("glb")
}

/// Without a headset, a project: every growth step pictured, and the tree exported. The project stays as it
/// is, but for what a killed session left in its journal.
fn look_at(project: &Path, out: &Path) -> Result<()> {
    let glb = tree_of(project, out);
    let document = if Store::has_journal(project) {
        let opened = Store::open(project)?;
        if let Some(message) = &opened.message {
            tell!("{message}");
        }
        let document = opened.history.committed().clone();
        opened.store.close(&document)?;
        document
    } else {
        read_project(project)?
    };
    demonstration::check_size(&document)?;
    let gpu = portrait::open_gpu()?;
    let mut picture = Picture::offscreen(&gpu, EXTENT.width, EXTENT.height)?;
    let mut progress = Progress::new("drawing");
    let steps = demonstration::every_step(&document, &mut picture, out, |step, most| {
        progress.show(step, most);
    })?;
    drop(progress);
    let world = World::new(crate::world::history::History::new(document));
    tell!("{}: {}.", project.display(), take_home::summary(&world));
    if world.document().step > 0 {
        take_home::export(&world, &glb)?;
        tell(out, steps, None, &glb);
    } else {
        tell!("It has not grown yet: pictures are in {}.", out.display());
    }
    Ok(())
}

fn tell(out: &Path, steps: usize, project: Option<&Path>, glb: &Path) {
    tell!(
        "  pictures  {} ({steps} growth steps, left and right eye)",
        out.join("step-*.png").display()
    );
    if let Some(project) = project {
        tell!("  project   {}", project.display());
    }
    tell!("  tree      {}", glb.display());
}
