//! Centerlines and their measures as files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::Vec3;

use super::export::ExportError;
use crate::centerline::Centerline;
use crate::centerline::analysis::{
    Analysis, BranchFacts, BranchVmtkFacts, CenterlineFacts, RadiusFacts,
};
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

/// Columns of the table; each row has those that it is of.
const COLUMNS: [&str; 27] = [
    "table",
    "id",
    "name",
    "parent",
    "order",
    "strahler",
    "horsfield",
    "tips",
    "length",
    "length_without_stem",
    "root_to_surface",
    "tip_to_surface",
    "length_to_surface",
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

/// A row: the cells that it has, by their columns.
type Row = Vec<(&'static str, String)>;

/// Writes what was measured as one CSV table: whole branches, branches by VMTK's definition, and centerlines, which the first column tells apart
/// by the names that JSON has for them.
///
/// # Errors
/// What the disk does not take.
pub fn write_tables(analysis: &Analysis, path: &Path) -> Result<(), TreeError> {
    let mut rows: Vec<Row> = analysis.branches.iter().map(whole_row).collect();
    let junctions = analysis.junctions_vmtk.iter();
    let parents: BTreeMap<usize, Option<usize>> = junctions
        .map(|junction| (junction.group, junction.parent))
        .collect();
    let parent = |branch: &BranchVmtkFacts| parents.get(&branch.upstream?).copied().flatten();
    rows.extend(
        analysis
            .branches_vmtk
            .iter()
            .map(|branch| vmtk_row(branch, parent(branch))),
    );
    rows.extend(analysis.centerlines.iter().map(line_row));
    let mut out = csv::Writer::from_writer(Vec::new());
    // Writing to memory does not fail.
    let _ = out.write_record(COLUMNS);
    for row in &rows {
        let cell = |column: &&str| {
            let found = row.iter().find(|(name, _)| name == column);
            found.map_or("", |(_, cell)| cell.as_str())
        };
        let _ = out.write_record(COLUMNS.iter().map(cell));
    }
    write_atomically(path, &out.into_inner().unwrap_or_default())
}

/// A number with all its digits; nothing for what is none.
fn number(value: impl Into<Option<f64>>) -> String {
    let value: Option<f64> = value.into();
    let value = value.filter(|value| value.is_finite());
    value.map_or_else(String::new, |value| format!("{value:?}"))
}

fn whole(value: Option<usize>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

fn radius_cells(radius: &RadiusFacts) -> Row {
    let along = radius.along;
    vec![
        ("radius_mean", number(along.mean)),
        ("radius_min", number(along.min)),
        ("radius_max", number(along.max)),
        ("radius_start", number(along.start)),
        ("radius_end", number(along.end)),
        ("taper", number(radius.taper)),
    ]
}

fn whole_row(one: &BranchFacts) -> Row {
    let mut row = vec![
        ("table", "branches".to_owned()),
        ("id", one.id.to_string()),
        ("parent", whole(one.parent)),
        ("order", one.order.to_string()),
        ("strahler", one.strahler.to_string()),
        ("horsfield", one.horsfield.to_string()),
        ("tips", one.tips.to_string()),
        ("length", number(one.length)),
        ("chord", number(one.chord)),
        ("tortuosity", number(one.tortuosity)),
        ("curvature", number(one.curvature)),
        ("torsion", number(one.torsion)),
        ("volume", number(one.volume)),
        ("area", number(one.area)),
        ("first_node", one.nodes[0].to_string()),
        ("last_node", one.nodes[1].to_string()),
    ];
    row.extend(radius_cells(&one.radius));
    row
}

fn vmtk_row(one: &BranchVmtkFacts, parent: Option<usize>) -> Row {
    let mut row = vec![
        ("table", "branches_vmtk".to_owned()),
        ("id", one.group.to_string()),
        ("parent", whole(parent)),
        ("tips", one.lines.to_string()),
        ("length", number(one.length)),
        ("chord", number(one.first.distance(one.last))),
        ("tortuosity", number(one.tortuosity)),
        ("curvature", number(one.curvature)),
        ("torsion", number(one.torsion)),
    ];
    row.extend(radius_cells(&one.radius));
    row
}

fn line_row(one: &CenterlineFacts) -> Row {
    vec![
        ("table", "centerlines".to_owned()),
        ("id", whole(one.target)),
        ("name", one.name.clone()),
        ("length", number(one.length)),
        ("length_without_stem", number(one.length_without_stem)),
        ("root_to_surface", number(one.root_to_surface)),
        ("tip_to_surface", number(one.tip_to_surface)),
        ("length_to_surface", number(one.length_to_surface)),
        ("last_node", one.node.to_string()),
    ]
}
