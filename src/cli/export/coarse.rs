//! Levels of detail of an individual.

use std::sync::Arc;

use anyhow::{Result, anyhow};

use super::Args;
use crate::tree::Drawing;
use crate::tree::detail::{Detail, coarser, segments_and_triangles};

/// A level of detail of an individual.
pub(super) struct Coarse {
    pub(super) drawing: Arc<Drawing>,
    pub(super) sides: u32,
    pub(super) segments: usize,
    pub(super) triangles: u64,
    pub(super) bound: f32,
}

/// A level of detail, or what a number of triangles allows.
pub(super) fn coarse(args: &Args, drawing: &Arc<Drawing>, level: Option<u32>) -> Result<Coarse> {
    let name = args.file.display();
    let (detail, coarse) = match args.triangles {
        Some(budget) => {
            let (detail, coarse) = Detail::of_budget(drawing, budget).map_err(|least| {
                anyhow!(
                    "{name}: it has {least} triangles at least, and {budget} were asked for: give --triangles {least} or more"
                )
            })?;
            (detail, Arc::new(coarse))
        }
        None => match Detail::level(&drawing.tree, level.unwrap_or(0)) {
            // Most files are of the tree as it is.
            detail if detail.within <= 0.0 => (detail, Arc::clone(drawing)),
            detail => (detail, Arc::new(coarser(drawing, detail.within))),
        },
    };
    let thickest = drawing.tree.radius.iter().copied().fold(0.0, f32::max);
    let (segments, triangles) = segments_and_triangles(&coarse, detail.sides);
    Ok(Coarse {
        sides: detail.sides,
        segments,
        triangles,
        bound: detail.bound(thickest),
        drawing: coarse,
    })
}
