//! What `ramus inspect` tells, under the names of its JSON object; `docs/src/model-report.md` says what each means.

use serde::Serialize;

use super::Inspected;
use crate::mesh::mend::Account;
use crate::mesh::paint::{Image, Material, Paint};
use crate::mesh::problem::{Problem, problems};
use crate::mesh::report::{BoundaryLoop, Component};
use crate::mesh::unit::Scale;

/// Components and open ends that are listed at most; counts are of all.
const LISTED_MOST: usize = 1000;

#[derive(Debug, Serialize)]
pub(super) struct Facts {
    pub(super) file: String,
    pub(super) format: String,
    pub(super) triangles: usize,
    pub(super) vertices: usize,
    pub(super) skipped_faces: usize,
    pub(super) skipped_lines: usize,
    pub(super) skipped_points: usize,
    pub(super) surplus_bytes: usize,
    /// Null where the file has a surface.
    pub(super) skeleton_nodes: Option<usize>,
    pub(super) has_colours: bool,
    pub(super) has_texture_coordinates: bool,
    pub(super) material_count: usize,
    pub(super) materials: Vec<String>,
    pub(super) image_count: usize,
    pub(super) images: Vec<ImageFacts>,
    pub(super) remarks: Vec<String>,
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
    pub(super) size: [f64; 3],
    /// Null where it cannot even be guessed.
    pub(super) scale: Option<Scale>,
    pub(super) watertight: bool,
    pub(super) manifold: bool,
    pub(super) orientable: bool,
    pub(super) euler_characteristic: i64,
    pub(super) area: f64,
    /// Null where no component is closed.
    pub(super) volume: Option<f64>,
    pub(super) component_count: usize,
    pub(super) components: Vec<ComponentFacts>,
    pub(super) open_end_count: usize,
    pub(super) open_ends: Vec<OpenEnd>,
    pub(super) problems: Vec<Problem>,
    /// What was mended, where that was asked for; all else is of the result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) repairs: Option<Vec<Account>>,
}

#[derive(Debug, Serialize)]
pub(super) struct ComponentFacts {
    pub(super) first_triangle: u32,
    pub(super) triangles: u32,
    pub(super) vertices: u32,
    pub(super) edges: u32,
    pub(super) boundary_loops: u32,
    pub(super) euler_characteristic: i64,
    pub(super) genus: Option<u32>,
    pub(super) closed: bool,
    pub(super) orientable: bool,
    pub(super) inside_out: bool,
    pub(super) hollow: bool,
    pub(super) area: f64,
    pub(super) volume: Option<f64>,
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
}

#[derive(Debug, Serialize)]
pub(super) struct ImageFacts {
    pub(super) name: String,
    pub(super) format: String,
    pub(super) width_px: u32,
    pub(super) height_px: u32,
}

#[derive(Debug, Serialize)]
pub(super) struct OpenEnd {
    pub(super) component: u32,
    pub(super) edges: usize,
    pub(super) closed: bool,
    pub(super) length: f64,
    pub(super) centre: [f64; 3],
}

impl Facts {
    pub(super) fn new(inspected: &Inspected) -> Self {
        let report = &inspected.report;
        let nothing = Paint::default();
        let paint = inspected.paint.unwrap_or(&nothing);
        Self {
            file: inspected.path.display().to_string(),
            format: inspected.format.to_owned(),
            triangles: report.triangles,
            vertices: report.vertices,
            skipped_faces: inspected.beside.skipped_faces,
            skipped_lines: inspected.beside.skipped_lines,
            skipped_points: inspected.beside.skipped_points,
            surplus_bytes: inspected.beside.surplus_bytes,
            skeleton_nodes: inspected.beside.skeleton_nodes,
            has_colours: !paint.colours.is_empty(),
            has_texture_coordinates: !paint.texture_coordinates.is_empty(),
            material_count: paint.materials.len(),
            materials: listed(&paint.materials),
            image_count: paint.images.len(),
            images: listed(&paint.images),
            remarks: inspected.remarks.to_vec(),
            min: report.min.to_array(),
            max: report.max.to_array(),
            size: report.size().to_array(),
            scale: inspected.scale,
            watertight: report.is_watertight(),
            manifold: report.is_manifold(),
            orientable: report.is_orientable(),
            euler_characteristic: report.euler_characteristic(),
            area: report.area(),
            volume: report.volume(),
            component_count: report.components.len(),
            components: listed(&report.components),
            open_end_count: report.boundary_loops.len(),
            open_ends: listed(&report.boundary_loops),
            problems: problems(report, Some(&inspected.intersections)),
            repairs: inspected.repairs.clone(),
        }
    }
}

impl From<&Material> for String {
    fn from(material: &Material) -> Self {
        material.name.clone()
    }
}

impl From<&Image> for ImageFacts {
    fn from(image: &Image) -> Self {
        let [width_px, height_px] = image.size_px;
        Self {
            name: image.name.clone(),
            format: image.kind.to_string(),
            width_px,
            height_px,
        }
    }
}

fn listed<'a, T, Told: From<&'a T>>(all: &'a [T]) -> Vec<Told> {
    all.iter().take(LISTED_MOST).map(Told::from).collect()
}

impl From<&Component> for ComponentFacts {
    fn from(component: &Component) -> Self {
        Self {
            first_triangle: component.first_triangle,
            triangles: component.triangles,
            vertices: component.vertices,
            edges: component.edges,
            boundary_loops: component.boundary_loops,
            euler_characteristic: component.euler_characteristic(),
            genus: component.genus(),
            closed: component.is_closed(),
            orientable: component.orientable,
            inside_out: component.is_inside_out(),
            hollow: component.hollow,
            area: component.area,
            volume: component.signed_volume.map(f64::abs),
            min: component.min.to_array(),
            max: component.max.to_array(),
        }
    }
}

impl From<&BoundaryLoop> for OpenEnd {
    fn from(end: &BoundaryLoop) -> Self {
        Self {
            component: end.component,
            edges: end.edges(),
            closed: end.closed,
            length: end.length,
            centre: end.centre.to_array(),
        }
    }
}
