//! Components: triangles that hang together by shared vertices, and what each is like.

use glam::{DVec3, Vec3};

use super::hollow;
use super::union::Sets;
use super::{Face, NONE, is_left_out};
use crate::mesh::Mesh;

/// Triangles that hang together by shared vertices. Measures are in the file's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Its first triangle.
    pub first_triangle: u32,
    /// How many triangles it has, without degenerate and duplicate ones.
    pub triangles: u32,
    /// How many vertices it has; those of equal coordinates are one where the report welds.
    pub vertices: u32,
    /// How many edges it has.
    pub edges: u32,
    /// How many edges have one triangle only.
    pub boundary_edges: u32,
    /// How many open ends it has.
    pub boundary_loops: u32,
    /// How many edges have more than two triangles.
    pub non_manifold_edges: u32,
    /// How many vertices have more than one fan of triangles.
    pub non_manifold_vertices: u32,
    /// How many triangles face against most of their neighbours.
    pub turned_triangles: u32,
    /// Whether its triangles can be turned so that neighbours show the same side.
    pub orientable: bool,
    /// Surface area.
    pub area: f64,
    /// What it encloses, once its triangles are turned to agree; below zero where they show their backs to the outside. None where it is
    /// open, has non-manifold edges or cannot be oriented.
    pub signed_volume: Option<f64>,
    /// It is inside out but inside the largest component: the wall of a hollow, which is right.
    pub hollow: bool,
    /// Smallest corner of its box.
    pub min: DVec3,
    /// Largest corner of its box.
    pub max: DVec3,
}

impl Component {
    /// Euler characteristic V − E + F.
    pub fn euler_characteristic(&self) -> i64 {
        i64::from(self.vertices) - i64::from(self.edges) + i64::from(self.triangles)
    }

    /// Every edge has exactly two triangles.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0 && self.non_manifold_edges == 0
    }

    /// Handles: 0 of a sphere or a tube, 1 of a torus; from 2 − 2 g − b = V − E + F with b boundary loops. None where the surface is not
    /// manifold or not orientable.
    pub fn genus(&self) -> Option<u32> {
        let manifold = self.non_manifold_edges == 0 && self.non_manifold_vertices == 0;
        let doubled = 2 - i64::from(self.boundary_loops) - self.euler_characteristic();
        match manifold && self.orientable && doubled % 2 == 0 {
            true => u32::try_from(doubled / 2).ok(),
            false => None,
        }
    }

    /// It is closed and shows the backs of its triangles to the outside, and is no hollow in another.
    pub fn is_inside_out(&self) -> bool {
        !self.hollow && self.signed_volume.is_some_and(|volume| volume < 0.0)
    }

    /// The box has another wholly inside.
    pub(super) fn surrounds(&self, other: &Self) -> bool {
        self.min.cmplt(other.min).all() && self.max.cmpgt(other.max).all()
    }
}

/// Corners of a triangle, from the mesh's origin.
pub(super) fn corners(mesh: &Mesh, triangle: usize) -> [Vec3; 3] {
    mesh.triangles[triangle].map(|vertex| mesh.positions[vertex as usize])
}

/// Twice the area, as a vector that stands on the triangle.
fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The component of each triangle, [`NONE`] of those that are left out, and the areas; larger areas first, then smaller first triangles.
pub(super) fn numbers(mesh: &Mesh, faces: &[Face]) -> (Vec<u32>, Vec<f64>) {
    let mut sets = Sets::new(mesh.positions.len());
    for face in faces.iter().filter(|face| !is_left_out(face)) {
        sets.join(face[0], face[1]);
        sets.join(face[0], face[2]);
    }
    let mut number_of_root = vec![NONE; mesh.positions.len()];
    let mut areas: Vec<f64> = Vec::new();
    let mut of_triangle = vec![NONE; faces.len()];
    for (triangle, face) in faces.iter().enumerate() {
        if is_left_out(face) {
            continue;
        }
        let number = &mut number_of_root[sets.find(face[0]) as usize];
        if *number == NONE {
            *number = u32::try_from(areas.len()).unwrap_or(NONE);
            areas.push(0.0);
        }
        of_triangle[triangle] = *number;
        let area = cross(corners(mesh, triangle).map(Vec3::as_dvec3)).length() / 2.0;
        areas[*number as usize] += area;
    }
    (by_area(of_triangle, &areas), sorted(areas))
}

fn sorted(mut areas: Vec<f64>) -> Vec<f64> {
    areas.sort_by(|a, b| b.total_cmp(a));
    areas
}

/// Numbers components anew, the largest first.
fn by_area(mut of_triangle: Vec<u32>, areas: &[f64]) -> Vec<u32> {
    let mut order: Vec<usize> = (0..areas.len()).collect();
    order.sort_by(|a, b| areas[*b].total_cmp(&areas[*a]));
    let mut place = vec![NONE; areas.len()];
    for (new, old) in (0_u32..).zip(order) {
        place[old] = new;
    }
    for number in of_triangle.iter_mut().filter(|number| **number != NONE) {
        *number = place[*number as usize];
    }
    of_triangle
}

/// What was found in the whole mesh, to be counted for each component.
pub(super) struct Findings<'a> {
    pub(super) faces: &'a [Face],
    pub(super) of_triangle: &'a [u32],
    pub(super) areas: &'a [f64],
    /// Half-edges.
    pub(super) boundary: &'a [u32],
    /// Half-edges, and how many there are on the edge.
    pub(super) non_manifold: &'a [(u32, u32)],
    /// A triangle of each boundary loop.
    pub(super) loops: &'a [u32],
    pub(super) non_manifold_vertices: &'a [u32],
    pub(super) turned: &'a [u32],
    /// A triangle of each patch with one side only.
    pub(super) one_sided: &'a [u32],
}

/// The components with all that they are.
pub(super) fn components(mesh: &Mesh, findings: &Findings) -> Vec<Component> {
    let mut all: Vec<Component> = findings.areas.iter().map(|area| empty(*area)).collect();
    let of = |half_edge: u32| findings.of_triangle[half_edge as usize / 3] as usize;
    // Twice the edges: each triangle has three half of them, but boundaries have no other half and non-manifold edges too many.
    let mut doubled: Vec<i64> = vec![0; all.len()];
    for half_edge in findings.boundary {
        all[of(*half_edge)].boundary_edges += 1;
        doubled[of(*half_edge)] += 1;
    }
    for (half_edge, count) in findings.non_manifold {
        all[of(*half_edge)].non_manifold_edges += 1;
        doubled[of(*half_edge)] += 2 - i64::from(*count);
    }
    for triangle in findings.loops {
        all[findings.of_triangle[*triangle as usize] as usize].boundary_loops += 1;
    }
    for triangle in findings.turned {
        all[findings.of_triangle[*triangle as usize] as usize].turned_triangles += 1;
    }
    for triangle in findings.one_sided {
        all[findings.of_triangle[*triangle as usize] as usize].orientable = false;
    }
    count_vertices(mesh, findings, &mut all);
    add_triangles(mesh, findings, &mut all);
    for (component, doubled) in all.iter_mut().zip(doubled) {
        let doubled = doubled + 3 * i64::from(component.triangles);
        component.edges = u32::try_from(doubled / 2).unwrap_or(NONE);
        let has_volume = component.is_closed() && component.orientable;
        component.signed_volume = component
            .signed_volume
            .filter(|_| has_volume)
            .map(|sum| sum / 6.0);
    }
    hollow::mark(mesh, findings.of_triangle, &mut all);
    all
}

fn empty(area: f64) -> Component {
    Component {
        first_triangle: NONE,
        triangles: 0,
        vertices: 0,
        edges: 0,
        boundary_edges: 0,
        boundary_loops: 0,
        non_manifold_edges: 0,
        non_manifold_vertices: 0,
        turned_triangles: 0,
        orientable: true,
        area,
        signed_volume: Some(0.0),
        hollow: false,
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    }
}

fn count_vertices(mesh: &Mesh, findings: &Findings, all: &mut [Component]) {
    let mut of_vertex = vec![NONE; mesh.positions.len()];
    for (face, number) in findings.faces.iter().zip(findings.of_triangle) {
        for vertex in face.iter().filter(|_| *number != NONE) {
            if of_vertex[*vertex as usize] == NONE {
                of_vertex[*vertex as usize] = *number;
                all[*number as usize].vertices += 1;
            }
        }
    }
    for vertex in findings.non_manifold_vertices {
        all[of_vertex[*vertex as usize] as usize].non_manifold_vertices += 1;
    }
}

/// Counts, boxes and sixfold volumes. Volumes are of pyramids with their tips in the first corner of the component, so that what lies far from the
/// origin loses nothing to rounding.
fn add_triangles(mesh: &Mesh, findings: &Findings, all: &mut [Component]) {
    let mut turned = findings.turned.iter().peekable();
    let mut tips = vec![DVec3::ZERO; all.len()];
    for (triangle, number) in (0_u32..).zip(findings.of_triangle) {
        if *number == NONE {
            continue;
        }
        let number = *number as usize;
        let component = &mut all[number];
        let points = corners(mesh, triangle as usize).map(Vec3::as_dvec3);
        if component.triangles == 0 {
            component.first_triangle = triangle;
            tips[number] = points[0];
        }
        component.triangles += 1;
        for point in points {
            component.min = component.min.min(mesh.origin + point);
            component.max = component.max.max(mesh.origin + point);
        }
        let sixfold = (points[0] - tips[number]).dot(cross(points));
        let sixfold = match turned.next_if_eq(&&triangle) {
            Some(_) => -sixfold,
            None => sixfold,
        };
        component.signed_volume = component.signed_volume.map(|sum| sum + sixfold);
    }
}
