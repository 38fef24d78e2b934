//! `ramus replay`: a recorded session played through the workshop, and what it made kept as files.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use ash::vk;
use clap::{Args as ClapArgs, ValueEnum};
use ramus_xr::Frame;
use ramus_xr::simulated::Simulated;

use super::outputs::{check_places, light, not_over_each_other, set_aside, tree_file};
use super::progress::Progress;
use crate::app::album::{Album, OnFrame};
use crate::app::film::Film;
use crate::app::headset::{self, Opened};
use crate::app::opening::Opening;
use crate::app::picture::Picture;
use crate::app::session::{SessionEnd, Watcher};
use crate::app::store::Store;
use crate::app::workshop::{Workshop, WorkshopParams};
use crate::app::{portrait, session, take_home, window};
use crate::ui::Settings;
use crate::world::World;
use crate::world::document::Document;
use crate::world::history::History;
use crate::world::scene::weather::Light;

/// Pixels of one eye of the simulated headset.
pub(super) const EXTENT: vk::Extent2D = vk::Extent2D {
    width: 1024,
    height: 1024,
};

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The recorded session (.session)
    session: PathBuf,
    /// What plays it: the simulated headset, the one behind the OpenXR runtime, or a window at the recorded speed (head and hands come from the session)
    #[arg(long, value_enum, default_value_t = Which::Simulated, value_name = "WHICH")]
    headset: Which,
    /// Write the project that the session made; an older one there is replaced when the session is over, and stays where it fails
    #[arg(long, value_name = "FILE.ramus")]
    project: Option<PathBuf>,
    /// Write a stereo picture of every growth step into this folder
    #[arg(long, value_name = "DIR")]
    png: Option<PathBuf>,
    /// What lights pictures, headset or window; without it what whoever recorded had set
    #[arg(long, value_name = "LIGHT", value_parser = light())]
    light: Option<Light>,
    /// Write frames of a video into that folder instead, so many a second of the session: frame-000001.png …, what the left eye sees
    #[arg(long, value_name = "RATE", requires = "png", value_parser = clap::value_parser!(u32).range(1..=240))]
    fps: Option<u32>,
    /// Write the grammar that the sketch became
    #[arg(long, value_name = "FILE.lsys")]
    lsys: Option<PathBuf>,
    /// Write the tree that the session ended with; the ending tells the format: .glb, .usda, .ply, .obj or .swc
    #[arg(long, value_name = "FILE", value_parser = tree_file())]
    glb: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Which {
    /// Built in, needs no device
    Simulated,
    /// The runtime's
    Openxr,
    /// A window on the desktop
    Window,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let path = &args.session;
    let name = path.display();
    // Read whole before anything is changed: a broken session makes no project.
    let frames =
        ramus_xr::session::read_file(path).with_context(|| format!("cannot play {name}"))?;
    let opening = Opening::of_session(path).with_context(|| format!("cannot play {name}"))?;
    let total = frames.len();
    let journal = args.project.as_deref().map(Store::journal_of);
    let outputs = [&args.project, &journal, &args.glb, &args.lsys];
    not_over_each_other(
        Some(path),
        outputs.into_iter().flatten().map(PathBuf::as_path),
        args.png.as_deref(),
    )?;
    // Whatever may be missing is asked for before the project is touched.
    let stage = Stage::open(args, frames.first())?;
    let mut progress = Progress::new("playing");
    let mut pictures = Pictures::new(args, Box::new(|frame| progress.show(frame, total)))?;
    // Behind the pictures' folder, which is made and may hold them.
    check_places(args.glb.iter().chain(&args.lsys))?;
    let mut workshop = open(args.project.as_deref(), opening.document())?;
    opening.apply(&mut workshop);
    if let Some(light) = args.light {
        workshop.set(Settings {
            light,
            ..workshop.settings()
        });
    }
    workshop.stay_with_models_of(path.parent().unwrap_or(Path::new("")));
    let outcome = match stage {
        Stage::Simulated(mut picture, extent) => {
            let mut simulated = Simulated::new(frames, extent);
            session::run(
                &mut simulated,
                &mut workshop,
                picture.as_deref_mut(),
                pictures.watcher(),
            )
        }
        Stage::Openxr(opened) => headset::play(*opened, frames, &mut workshop, pictures.watcher()),
        Stage::Window(opened) => {
            let whole = args.png.is_some();
            window::play(*opened, frames, whole, &mut workshop, pictures.watcher())
        }
    };
    let (played, told) = (pictures.frames(), pictures.told());
    drop(pictures);
    drop(progress);
    let wanted = [&args.project, &args.png, &args.lsys, &args.glb];
    // Whoever only watches may leave.
    let watches = args.headset == Which::Window && wanted.iter().all(|file| file.is_none());
    if watches && matches!(outcome, Err(SessionEnd::Early)) {
        tell!("stopped after {played} of {total} frames of {name}");
        return Ok(());
    }
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
        tell!("  pictures  {} ({told})", folder.display());
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

/// The pictures that are kept: of growth steps, or of all that happens.
enum Pictures<'a> {
    Album(Album<'a>),
    Film(Film<'a>, u32),
}

impl<'a> Pictures<'a> {
    fn new(args: &Args, on_frame: OnFrame<'a>) -> Result<Self> {
        Ok(match (args.png.as_deref(), args.fps) {
            (Some(folder), Some(rate)) => Self::Film(Film::new(folder, rate, on_frame)?, rate),
            (folder, _) => Self::Album(Album::new(folder, on_frame)?),
        })
    }

    fn watcher(&mut self) -> &mut dyn Watcher {
        match self {
            Self::Album(album) => album,
            Self::Film(film, _) => film,
        }
    }

    fn frames(&self) -> usize {
        match self {
            Self::Album(album) => album.frames(),
            Self::Film(film, _) => film.frames(),
        }
    }

    /// What they are.
    fn told(&self) -> String {
        match self {
            Self::Album(album) => format!("stereo, {} growth steps", album.steps().len()),
            Self::Film(film, rate) => format!("{} frames, {rate} a second", film.pictures()),
        }
    }
}

/// Pixels of one eye that suit what it sees: as high as [`EXTENT`], and as wide as its field of view is.
fn extent_of(frame: Option<&Frame>) -> vk::Extent2D {
    let Some(frame) = frame else { return EXTENT };
    let fov = frame.views[0].fov;
    let width = fov.right.tan() - fov.left.tan();
    let height = fov.up.tan() - fov.down.tan();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "from 16 to 256; a NaN gives 0, which is clamped too"
    )]
    let blocks = (width / height * 64.0).round().clamp(16.0, 256.0) as u32;
    vk::Extent2D {
        width: blocks.max(16) * EXTENT.height / 64,
        height: EXTENT.height,
    }
}

/// What plays the session and draws it.
enum Stage {
    Simulated(Option<Box<Picture>>, vk::Extent2D),
    Openxr(Box<Opened>),
    Window(Box<window::Opened>),
}

impl Stage {
    fn open(args: &Args, first: Option<&Frame>) -> Result<Self> {
        let extent = extent_of(first);
        Ok(match (args.headset, &args.png) {
            (Which::Window, _) => Self::Window(Box::new(open_window(&args.session)?)),
            (Which::Openxr, _) => Self::Openxr(Box::new(Opened::connect()?)),
            (Which::Simulated, None) => Self::Simulated(None, extent),
            (Which::Simulated, Some(_)) => {
                let gpu = portrait::open_gpu()?;
                let picture = Picture::offscreen(&gpu, extent.width, extent.height)?;
                Self::Simulated(Some(Box::new(picture)), extent)
            }
        })
    }
}

fn open_window(session: &Path) -> Result<window::Opened> {
    let name = session.file_name().unwrap_or_default().to_string_lossy();
    let files = window::Files {
        picture: PathBuf::from(session.file_stem().unwrap_or_default()),
        tree: None,
    };
    Ok(window::Opened::open(&format!("{name} – Ramus"), files)?)
}

fn open(project: Option<&Path>, document: &Document) -> Result<Workshop> {
    let params = WorkshopParams::default();
    let document = document.clone();
    Ok(match project {
        None => Workshop::unsaved(World::new(History::new(document)))?,
        Some(path) => {
            let opened = Store::begin_with(path, document)?;
            if let Some(message) = &opened.message {
                whisper!("ramus: {message}");
            }
            Workshop::new(opened, params)?
        }
    })
}
