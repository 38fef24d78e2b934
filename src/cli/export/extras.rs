//! What `ramus export` writes besides: instances, wind, growth, smaller pictures.

use anyhow::{Result, bail, ensure};
use clap::{Args as ClapArgs, ValueEnum};

use super::Args;
use super::files::Format;
use crate::tree::export::Extras;
use crate::tree::vary::Spread;

/// Morph targets where nothing is said.
const MORPHS: u32 = 4;

#[derive(Debug, ClapArgs)]
pub(super) struct ExtraArgs {
    /// Leaves and all else that is placed as instances of small meshes, in glb (EXT_mesh_gpu_instancing) and usda (PointInstancer)
    #[arg(long)]
    instances: bool,
    /// How far each vertex goes with trunk, branch and leaf in the wind, as texture coordinates 1 and 2 of glb
    #[arg(long)]
    wind: bool,
    /// How the tree grew
    #[arg(long, value_enum, value_name = "HOW")]
    pub(super) growth: Option<Growth>,
    /// The last steps that --growth shows; of morphs 4 and of a sequence all, if nothing is said
    #[arg(long, value_name = "N", requires = "growth", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) growth_steps: Option<u32>,
    /// Pixels that a side of a picture has at most, in glb
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=4096))]
    texture: Option<u32>,
}

/// How growth is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Growth {
    /// The last steps as morph targets of glb, with an animation that unfolds one a second
    Morphs,
    /// A file for each step
    Sequence,
}

impl ExtraArgs {
    /// As files are written with them.
    pub(super) fn extras(&self) -> Extras {
        Extras {
            instances: self.instances,
            wind: self.wind,
            morphs: match self.growth {
                Some(Growth::Morphs) => self.growth_steps.unwrap_or(MORPHS),
                _ => 0,
            },
            texture: self.texture,
        }
    }
}

/// Refuses what no file that is asked for can hold.
pub(super) fn check(args: &Args, spread: Spread) -> Result<()> {
    let extras = args.extra.extras();
    let has = |format: Format| args.format.contains(&format);
    let of_glb = [
        (extras.wind, "--wind is"),
        (extras.morphs > 0, "morph targets are"),
        (extras.texture.is_some(), "--texture is"),
    ];
    for (_, what) in of_glb.iter().filter(|(asked, _)| *asked) {
        ensure!(
            has(Format::Glb),
            "{what} for glb alone: add glb to --format, or leave it out"
        );
    }
    ensure!(
        !extras.instances || has(Format::Glb) || has(Format::Usda),
        "--instances is for glb and usda: add one of them to --format, or leave it out"
    );
    ensure!(
        !(extras.instances && extras.morphs > 0),
        "instances have no vertices of their own that morph targets could move: leave --instances out, or take --growth sequence"
    );
    let most = Extras::MORPHS_MOST;
    ensure!(
        extras.morphs <= most,
        "{} steps are too many for morph targets, of which a file has {most} at most: take fewer --growth-steps, or --growth sequence",
        extras.morphs
    );
    if args.extra.growth != Some(Growth::Sequence) {
        return Ok(());
    }
    if args.grove {
        bail!("a grove does not grow step by step: leave --grove out, or --growth sequence");
    }
    ensure!(
        spread == Spread::NONE,
        "--angles and --lengths make another tree at each step of a sequence: set both to 0"
    );
    Ok(())
}
