//! A tree from whatever file a person names.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, bail};

use super::inputs::grammar_text;
use super::inspect::{self, Loaded};
use super::progress::Progress;
use crate::app::trees::{Held, Holds, of_grammar, of_project, of_surface, of_swc};
use crate::mesh::unit::Scale;

/// The tree of a model, a skeleton, a grammar (.lsys) or a project (.ramus).
pub(super) fn held(path: &Path) -> Result<Held> {
    let is = |ending: &str| {
        path.extension()
            .is_some_and(|one| one.eq_ignore_ascii_case(ending))
    };
    if is("lsys") {
        let text = grammar_text(path)?;
        let name = path.display().to_string();
        return Progress::during("growing", || of_grammar(&text, &name));
    }
    if is("ramus") {
        return Progress::during("growing", || of_project(path));
    }
    if is("swc") {
        return Progress::during("reading", || of_swc(path));
    }
    if is("json") {
        bail!(
            "{} is no tree: name the model that it was measured of",
            path.display()
        );
    }
    of_loaded(path, inspect::load)
}

/// The tree of a model that `read` reads: its centerlines, or of a skeleton itself.
pub(super) fn of_loaded(
    path: &Path,
    read: impl FnOnce(&Path, &AtomicBool) -> Result<Loaded>,
) -> Result<Held> {
    let never = AtomicBool::new(false);
    let loaded = Progress::during("reading", || read(path, &never))?;
    let origin = loaded.mesh.origin;
    let longest = || {
        let (low, high) = loaded.skeleton.as_ref()?.bounds()?;
        Scale::guessed(f64::from((high - low).max_element()))
    };
    if let Some(tree) = &loaded.skeleton {
        return Ok(Held {
            tree: tree.clone(),
            origin,
            holds: Holds::Skeleton,
            unit: loaded.scale.or_else(longest).map(|scale| scale.unit),
            z_up: loaded.z_up,
            remarks: Vec::new(),
        });
    }
    let found = Progress::during("looking for centerlines", || of_surface(&loaded.mesh))
        .with_context(|| format!("cannot analyze {}", path.display()))?;
    let unreached = found.unreached.iter();
    let unreached = unreached.map(|one| format!("{} is {one}", one.name));
    let (low, high) = found.tree.bounds().unwrap_or_default();
    let longest = f64::from((high - low).max_element());
    let scale = loaded.scale.or_else(|| Scale::guessed(longest));
    Ok(Held {
        origin: found.origin,
        holds: Holds::Model,
        unit: scale.map(|scale| scale.unit),
        z_up: loaded.z_up,
        remarks: unreached.collect(),
        tree: found.tree,
    })
}
