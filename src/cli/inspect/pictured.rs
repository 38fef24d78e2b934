//! The picture of a model.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Result, anyhow};
use clap::ValueEnum;

use super::super::progress::Progress;
use crate::app::model_portrait::{ModelPortrait, of_model};
use crate::app::{export, portrait};
use crate::mesh::Mesh;
use crate::mesh::colour::{Colour, by_parts, by_problems};
use crate::mesh::display::Display;
use crate::mesh::intersect::Intersections;
use crate::mesh::report::Report;
use crate::world::scene::{ModelLook, SurfaceLook};

/// What a picture of a model shows; several go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Look {
    /// Faces with gloss, lit by the sun
    Shaded,
    /// Faces lit by the sky alone
    Matte,
    /// Faces that are seen through
    XRay,
    /// Edges; without a look of faces they stand alone
    Edges,
    /// Vertices; without a look of faces they stand alone
    Vertices,
    /// The box around it
    Box,
    /// Each part in a colour of its own
    Parts,
    /// What is wrong, in the colour of the fault
    Problems,
}

/// An axis of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Up {
    /// The second
    Y,
    /// The third
    Z,
}

/// Seen from a corner: shapes are told apart, radians.
const TURN: f32 = 0.5;

/// How a list of looks shows a model; nothing asked for: shaded.
fn portrait(looks: &[Look], z_up: bool, pixels: u32) -> ModelPortrait {
    let has = |look| looks.contains(&look);
    let coloured = has(Look::Parts) || has(Look::Problems);
    let alone = (has(Look::Edges) || has(Look::Vertices)) && !coloured;
    let surface = if has(Look::XRay) {
        Some(SurfaceLook::XRay)
    } else if has(Look::Matte) {
        Some(SurfaceLook::Matte)
    } else if alone && !has(Look::Shaded) {
        None
    } else {
        Some(SurfaceLook::Shaded)
    };
    ModelPortrait {
        look: ModelLook {
            surface,
            wireframe: has(Look::Edges),
            vertices: has(Look::Vertices),
            ..ModelLook::default()
        },
        boxed: has(Look::Box),
        z_up,
        turn: TURN,
        backdrop: portrait::PAPER,
        pixels,
    }
}

/// The colours of the triangles, where a look has them.
pub(super) fn colours(
    looks: &[Look],
    mesh: &Mesh,
    report: &Report,
    found: &Intersections,
) -> Vec<Colour> {
    if looks.contains(&Look::Problems) {
        by_problems(mesh, report, found)
    } else if looks.contains(&Look::Parts) {
        by_parts(report)
    } else {
        Vec::new()
    }
}

/// Draws a model into a file.
pub(super) fn draw(
    mesh: Mesh,
    colours: Vec<Colour>,
    looks: &[Look],
    z_up: bool,
    pixels: u32,
    path: &Path,
) -> Result<()> {
    let never = AtomicBool::new(false);
    let picture = Progress::during("drawing", || {
        let display = Display::new(Arc::new(mesh), &never)
            .ok_or_else(|| anyhow!("the drawing of the model was cancelled"))?;
        of_model(display.coloured(colours), &portrait(looks, z_up, pixels))
    })?;
    Progress::during("writing", || export::png(&picture, path))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn looks_go_together() {
        let look = |looks: &[Look]| {
            let how = portrait(looks, true, 64);
            (how.look.surface, how.look.wireframe, how.boxed)
        };
        let shaded = Some(SurfaceLook::Shaded);
        for (looks, expected) in [
            (&[][..], (shaded, false, false)),
            (&[Look::Edges], (None, true, false)),
            (&[Look::Vertices, Look::Box], (None, false, true)),
            (&[Look::Shaded, Look::Edges], (shaded, true, false)),
            (&[Look::Parts, Look::Edges], (shaded, true, false)),
            (&[Look::Matte], (Some(SurfaceLook::Matte), false, false)),
            (
                &[Look::XRay, Look::Edges],
                (Some(SurfaceLook::XRay), true, false),
            ),
        ] {
            assert_eq!(look(looks), expected, "{looks:?}");
        }
    }
}
