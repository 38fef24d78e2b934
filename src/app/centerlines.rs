//! Centerlines and their measures as files.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::export::ExportError;
use crate::centerline::Centerline;
use crate::centerline::analysis::Analysis;
use crate::mesh::unit::Unit;
use crate::tree::export::{ExportParams, Glb, Swc, Vtp};
use crate::tree::file::{write_atomically, write_atomically_with};
use crate::tree::{Organs, Tree, TreeError};

/// Formats of centerlines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// SWC: nodes with radii, as neurons are exchanged.
    Swc,
    /// VTP: lines with radii, as VMTK and 3D Slicer read them.
    Vtp,
    /// Binary glTF: tubes.
    Glb,
}

/// The ending tells no format.
#[derive(Debug, thiserror::Error)]
#[error("{path}: the ending tells no format of centerlines; use .swc, .vtp or .glb", path = .0.display())]
pub struct NoFormat(PathBuf);

impl Format {
    /// The format that a path's ending tells.
    ///
    /// # Errors
    /// [`NoFormat`].
    pub fn of(path: &Path) -> Result<Self, NoFormat> {
        let ending = path.extension().and_then(|ending| ending.to_str());
        match ending.unwrap_or_default().to_ascii_lowercase().as_str() {
            "swc" => Ok(Self::Swc),
            "vtp" => Ok(Self::Vtp),
            "glb" => Ok(Self::Glb),
            _ => Err(NoFormat(path.to_owned())),
        }
    }
}

/// Writes centerlines in the model's coordinates, whole or not at all.
///
/// # Errors
/// [`ExportError`].
pub fn write(found: &Centerline, path: &Path) -> Result<(), ExportError> {
    let format = Format::of(path).map_err(|_| ExportError::Format {
        path: path.to_owned(),
    })?;
    match format {
        Format::Vtp => {
            let file = Vtp::new(&found.tree, found.origin)?;
            write_atomically_with(path, |out| file.write(out))?;
        }
        Format::Swc => {
            let tree = in_model(found)?;
            let file = Swc::new(&tree)?.in_unit("that of the model; its axes, too");
            write_atomically_with(path, |out| file.write(out))?;
        }
        Format::Glb => {
            let tree = in_model(found)?;
            let (organs, params) = (Organs::default(), ExportParams::default());
            let file = Glb::new(&tree, &organs, &params)?;
            write_atomically_with(path, |out| file.write(out))?;
        }
    }
    Ok(())
}

/// The tree in the model's coordinates, as single precision has them.
#[allow(
    clippy::cast_possible_truncation,
    reason = "these formats' readers have single precision"
)]
fn in_model(found: &Centerline) -> Result<Tree, TreeError> {
    let mut tree = found.tree.clone();
    for position in tree.position.iter_mut() {
        let there = position.as_dvec3() + found.origin;
        *position = Vec3::new(there.x as f32, there.y as f32, there.z as f32);
    }
    tree.validate()?;
    Ok(tree)
}

/// Writes all that is told as one JSON object, as a model counts that stands in the workshop.
///
/// # Errors
/// Where the disk does not take it.
pub fn write_analysis(analysis: &Analysis, unit: Unit, path: &Path) -> Result<(), TreeError> {
    let mut analysis = analysis.clone();
    analysis.model.unit = Some(unit.name());
    analysis.model.scale = Some(unit.metres());
    write_atomically_with(path, |out| {
        serde_json::to_writer(&mut *out, &analysis)?;
        out.write_all(b"\n")
    })
}

/// Writes a table of branches, one a row.
///
/// # Errors
/// Where the disk does not take it.
pub fn write_branches(analysis: &Analysis, path: &Path) -> Result<(), TreeError> {
    let columns = [
        "id",
        "parent",
        "order",
        "strahler",
        "horsfield",
        "tips",
        "length",
        "chord",
        "tortuosity",
        "curvature",
        "torsion",
        "radius_mean",
        "radius_min",
        "radius_max",
        "radius_start",
        "radius_end",
        "taper",
        "volume",
        "area",
        "first_node",
        "last_node",
    ];
    let mut text = columns.join(",") + "\n";
    let or_empty = |value: Option<String>| value.unwrap_or_default();
    for one in &analysis.branches {
        let radius = one.radius;
        let finite = |value: f64| {
            if value.is_finite() {
                format!("{value:?}")
            } else {
                String::new()
            }
        };
        let cells = [
            one.id.to_string(),
            or_empty(one.parent.map(|parent| parent.to_string())),
            one.order.to_string(),
            one.strahler.to_string(),
            one.horsfield.to_string(),
            one.tips.to_string(),
            finite(one.length),
            finite(one.chord),
            finite(one.tortuosity),
            finite(one.curvature),
            or_empty(one.torsion.map(finite)),
            finite(radius.along.mean),
            finite(radius.along.min),
            finite(radius.along.max),
            finite(radius.along.start),
            finite(radius.along.end),
            finite(radius.taper),
            finite(one.volume),
            finite(one.area),
            one.nodes[0].to_string(),
            one.nodes[1].to_string(),
        ];
        text += &(cells.join(",") + "\n");
    }
    write_atomically(path, text.as_bytes())
}
