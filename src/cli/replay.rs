//! `ramus replay`: a recorded session played through the workshop, and what it made kept as files.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use ash::vk;
use clap::{Args as ClapArgs, ValueEnum};
use ramus_xr::simulated::Simulated;

use super::outputs::{check_places, not_over_each_other, set_aside, tree_file};
use super::progress::Progress;
use crate::app::album::Album;
use crate::app::headset::{self, Opened};
use crate::app::picture::Picture;
use crate::app::store::Store;
use crate::app::workshop::{Workshop, WorkshopParams};
use crate::app::{portrait, session, take_home};
use crate::world::World;
use crate::world::history::History;

/// Pixels of one eye of the simulated headset.
pub(super) const EXTENT: vk::Extent2D = vk::Extent2D {
    width: 1024,
    height: 1024,
};

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The recorded session (.session)
    session: PathBuf,
    /// Which headset plays it: the simulated one, or the one behind the OpenXR runtime (head and hands come from the session)
    #[arg(long, value_enum, default_value_t = Which::Simulated, value_name = "WHICH")]
    headset: Which,
    /// Write the project that the session made; an older one there is replaced when the session is over, and stays where it fails
    #[arg(long, value_name = "FILE.ramus")]
    project: Option<PathBuf>,
    /// Write a stereo picture of every growth step into this folder
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
    /// Write the grammar that the sketch became
    #[arg(long, value_name = "FILE.lsys")]
    lsys: Option<PathBuf>,
    /// Write the tree that the session ended with; the ending tells the format: .glb, .obj or .swc
    #[arg(long, value_name = "FILE", value_parser = tree_file())]
    glb: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Which {
    /// Built in, needs no device
    Simulated,
    /// The runtime's
    Openxr,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let path = &args.session;
    let name = path.display();
    // Read whole before anything is changed: a broken session makes no project.
    let frames =
        ramus_xr::session::read_file(path).with_context(|| format!("cannot play {name}"))?;
    let total = frames.len();
    let journal = args.project.as_deref().map(Store::journal_of);
    let outputs = [&args.project, &journal, &args.glb, &args.lsys];
    not_over_each_other(
        Some(path),
        outputs.into_iter().flatten().map(PathBuf::as_path),
        args.png.as_deref(),
    )?;
    // Whatever may be missing is asked for before the project is touched.
    let stage = Stage::open(args)?;
    let mut progress = Progress::new("playing");
    let mut album = Album::new(
        args.png.as_deref(),
        Box::new(|frame| progress.show(frame, total)),
    )?;
    // Behind the pictures' folder, which is made and may hold them.
    check_places(args.glb.iter().chain(&args.lsys))?;
    let mut workshop = open(args.project.as_deref())?;
    let outcome = match stage {
        Stage::Simulated(mut picture) => {
            let mut simulated = Simulated::new(frames, EXTENT);
            session::run(
                &mut simulated,
                &mut workshop,
                picture.as_deref_mut(),
                &mut album,
            )
        }
        Stage::Openxr(opened) => headset::play(*opened, frames, &mut workshop, &mut album),
    };
    let steps = album.steps().len();
    let played = album.frames();
    drop(album);
    drop(progress);
    if let Err(error) = outcome {
        return Err(set_aside(workshop, args.project.as_deref(), &error.into()));
    }
    workshop.finish_tree();
    let world = workshop.close()?;
    tell!(
        "played {played} frames of {name}: {}",
        take_home::summary(&world)
    );
    if let Some(project) = &args.project {
        tell!("  project   {}", project.display());
    }
    if let Some(folder) = &args.png {
        tell!(
            "  pictures  {} (stereo, {steps} growth steps)",
            folder.display()
        );
    }
    if let Some(lsys) = &args.lsys {
        take_home::grammar(world.document(), lsys)?;
        tell!("  grammar   {}", lsys.display());
    }
    if let Some(glb) = &args.glb {
        // What was told above is there; this alone is not.
        ensure!(
            world.document().step > 0,
            "{} was not written: the session ends at step 0, where no tree has grown yet; all else that was asked for is written",
            glb.display()
        );
        take_home::export(world.document(), glb)?;
        tell!("  tree      {}", glb.display());
    }
    Ok(())
}

/// What plays the session and draws it.
enum Stage {
    Simulated(Option<Box<Picture>>),
    Openxr(Box<Opened>),
}

impl Stage {
    fn open(args: &Args) -> Result<Self> {
        Ok(match (args.headset, &args.png) {
            (Which::Openxr, _) => Self::Openxr(Box::new(Opened::connect()?)),
            (Which::Simulated, None) => Self::Simulated(None),
            (Which::Simulated, Some(_)) => {
                let gpu = portrait::open_gpu()?;
                let picture = Picture::offscreen(&gpu, EXTENT.width, EXTENT.height)?;
                Self::Simulated(Some(Box::new(picture)))
            }
        })
    }
}

fn open(project: Option<&Path>) -> Result<Workshop> {
    let params = WorkshopParams::default();
    Ok(match project {
        None => Workshop::unsaved(World::new(History::default()))?,
        Some(path) => {
            let opened = Store::begin(path)?;
            if let Some(message) = &opened.message {
                whisper!("ramus: {message}");
            }
            Workshop::new(opened, params)?
        }
    })
}
