//! The picture of a model.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Result, anyhow};
use clap::ValueEnum;

use super::super::progress::Progress;
use crate::app::model_portrait::{ModelPortrait, of_model};
use crate::app::studies::coloured;
use crate::app::{export, portrait};
use crate::mesh::Mesh;
use crate::mesh::colour::{Colour, by_parts, by_problems};
use crate::mesh::display::Display;
use crate::mesh::endpoints::Endpoint;
use crate::mesh::intersect::Intersections;
use crate::mesh::line::along;
use crate::mesh::paint::Paint;
use crate::mesh::report::Report;
use crate::mesh::surface::Surface;
use crate::mesh::textured::{LayerLimits, Textured, moved};
use crate::mesh::unit::Unit;
use crate::tree::Tree;
use crate::world::model::Colouring;
use crate::world::scene::{ModelLook, SurfaceLook};

/// What a picture of a model shows; several go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Look {
    /// As the file colours it: materials, images, colours of vertices; what is shown where nothing else is asked for
    Textured,
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
    /// How much the surface bends: blue hollow, red bulging
    Curvature,
    /// The largest ball inside at each place: blue thin, yellow thick
    Radius,
    /// How thick it is at each place: blue thin, yellow thick
    Thickness,
}

impl Look {
    /// What it colours by, where that is a number at each vertex.
    fn numbers(self) -> Option<Colouring> {
        match self {
            Self::Curvature => Some(Colouring::Curvature),
            Self::Radius => Some(Colouring::Radius),
            Self::Thickness => Some(Colouring::Thickness),
            _ => None,
        }
    }
}

/// What of a model is drawn, and how.
pub(super) struct Subject<'a> {
    pub(super) looks: &'a [Look],
    pub(super) z_up: bool,
    pub(super) pixels: u32,
    pub(super) unit: Unit,
    pub(super) endpoints: Vec<Endpoint>,
    /// What the surface was made around.
    pub(super) skeleton: Option<Tree>,
}

/// An axis of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Up {
    /// The second
    Y,
    /// The third
    Z,
}

/// Seen from a corner: shapes are told apart, radians.
const TURN: f32 = 0.5;

/// How a list of looks shows a model; nothing asked for: textured, which is shaded where the file says nothing of colours.
fn portrait(subject: &Subject<'_>) -> ModelPortrait {
    let looks = subject.looks;
    let has = |look| looks.contains(&look);
    let numbers = looks.iter().any(|look| look.numbers().is_some());
    let coloured = has(Look::Parts) || has(Look::Problems) || numbers;
    let alone = (has(Look::Edges) || has(Look::Vertices)) && !coloured;
    let surface = if has(Look::XRay) {
        Some(SurfaceLook::XRay)
    } else if has(Look::Matte) {
        Some(SurfaceLook::Matte)
    } else if has(Look::Shaded) || coloured {
        Some(SurfaceLook::Shaded)
    } else if alone && !has(Look::Textured) {
        None
    } else {
        Some(SurfaceLook::Textured)
    };
    ModelPortrait {
        look: ModelLook {
            surface,
            wireframe: has(Look::Edges),
            vertices: has(Look::Vertices),
            ..ModelLook::default()
        },
        boxed: has(Look::Box),
        unit: subject.unit,
        endpoints: subject.endpoints.clone(),
        centerline: None,
        z_up: subject.z_up,
        turn: TURN,
        backdrop: portrait::PAPER,
        pixels: subject.pixels,
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

/// Draws a model into a file, with its file's paint and, where it was mended, the mesh that this is for; gives the numbers between which the colours run, where they show numbers.
pub(super) fn draw(
    surface: impl FnOnce() -> Result<Surface>,
    mesh: &Arc<Mesh>,
    paint: Option<(Paint, Option<Mesh>)>,
    colours: Vec<Colour>,
    subject: Subject<'_>,
    path: &Path,
) -> Result<Option<[f32; 2]>> {
    let never = AtomicBool::new(false);
    let stopped = || anyhow!("the drawing of the model was cancelled");
    let numbers = subject.looks.iter().find_map(|look| look.numbers());
    let (picture, range) = Progress::during("drawing", || {
        let mut how = portrait(&subject);
        if let Some(skeleton) = &subject.skeleton {
            let line = Arc::new(along(skeleton));
            let line = Display::for_picture(line, None, &never).ok_or_else(stopped)?;
            how.centerline = Some(Arc::new(line));
        }
        let paint = paint.filter(|_| how.look.surface == Some(SurfaceLook::Textured));
        let mut mesh = Arc::clone(mesh);
        let mut textured = None;
        if let Some((mut paint, before)) = paint {
            if let Some(before) = before {
                let parted = moved(&paint, before, &mesh, &never).ok_or_else(stopped)?;
                (mesh, paint) = (Arc::new(parted.0), parted.1);
            }
            let limits = LayerLimits::default();
            let (found, remarks) = Textured::new(paint, &limits, &never).ok_or_else(stopped)?;
            remarks.iter().for_each(|remark| whisper!("{remark}"));
            textured = found;
        }
        let display = Display::for_picture(mesh, textured.as_ref(), &never).ok_or_else(stopped)?;
        let (display, range) = match (numbers, textured) {
            (Some(by), _) => {
                let (colours, range) = coloured(&surface()?, by, &never).ok_or_else(stopped)?;
                (display.painted(colours), range)
            }
            (None, Some(textured)) => (display.textured(Arc::new(textured)), None),
            (None, None) => (display.coloured(colours), None),
        };
        anyhow::Ok((of_model(display, &how)?, range))
    })?;
    Progress::during("writing", || export::png(&picture, path))?;
    Ok(range)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn looks_go_together() {
        let look = |looks: &[Look]| {
            let how = portrait(&Subject {
                looks,
                z_up: true,
                pixels: 64,
                unit: Unit::Metres,
                endpoints: Vec::new(),
                skeleton: None,
            });
            (how.look.surface, how.look.wireframe, how.boxed)
        };
        let shaded = Some(SurfaceLook::Shaded);
        for (looks, expected) in [
            (&[][..], (Some(SurfaceLook::Textured), false, false)),
            (&[Look::Shaded], (shaded, false, false)),
            (
                &[Look::Textured, Look::Edges],
                (Some(SurfaceLook::Textured), true, false),
            ),
            (&[Look::Edges], (None, true, false)),
            (&[Look::Vertices, Look::Box], (None, false, true)),
            (&[Look::Shaded, Look::Edges], (shaded, true, false)),
            (&[Look::Parts, Look::Edges], (shaded, true, false)),
            (&[Look::Thickness, Look::Vertices], (shaded, false, false)),
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
