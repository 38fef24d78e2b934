//! Levels of detail of an individual.

use std::sync::Arc;

use anyhow::{Result, anyhow};

use super::Args;
use crate::tree::Drawing;
use crate::tree::detail::{Detail, coarser, triangles_of};
use crate::tree::organs::refined_len;

/// A level of detail of an individual.
pub(super) struct Coarse {
    pub(super) drawing: Arc<Drawing>,
    pub(super) sides: u32,
    pub(super) segments: usize,
    pub(super) triangles: u64,
    pub(super) bound: f32,
}

/// A level of detail, or what a number of triangles allows.
pub(super) fn coarse(args: &Args, drawing: &Drawing, level: Option<u32>) -> Result<Coarse> {
    let name = args.file.display();
    let (detail, coarse) = match args.triangles {
        Some(budget) => Detail::of_budget(drawing, budget).ok_or_else(|| {
            anyhow!("{name}: no tree has so few triangles as {budget}: give a larger --triangles")
        })?,
        None => {
            let detail = Detail::level(&drawing.tree, level.unwrap_or(0));
            (detail, coarser(drawing, detail.within))
        }
    };
    let thickest = drawing.tree.radius.iter().copied().fold(0.0, f32::max);
    let nodes = usize::try_from(refined_len(&coarse.tree, &coarse.organs)).unwrap_or(usize::MAX);
    Ok(Coarse {
        sides: detail.sides,
        segments: nodes.saturating_sub(coarse.tree.root_count()),
        triangles: triangles_of(&coarse, detail.sides),
        bound: detail.bound(thickest),
        drawing: Arc::new(coarse),
    })
}
