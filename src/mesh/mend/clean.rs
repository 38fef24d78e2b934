//! What every mend begins with: vertices of equal coordinates joined, and what no surface has left out.

use rayon::prelude::*;

use super::Work;
use crate::mesh::Mesh;
use crate::mesh::report::edges::Edges;
use crate::mesh::report::{Face, NONE, weld};

/// The mesh with vertices of equal coordinates as one, without unusable, degenerate and duplicate triangles and unused vertices.
pub(super) fn clean(mut mesh: Mesh, work: &mut Work) -> Mesh {
    let before = mesh.triangles.len();
    let positions = &mesh.positions;
    mesh.triangles.retain(|triangle| {
        let mut vertices = triangle.iter();
        vertices.all(|v| positions.get(*v as usize).is_some_and(|p| p.is_finite()))
    });
    work.remark(
        before - mesh.triangles.len(),
        "triangle with a vertex that is not there or not finite dropped",
        "triangles with a vertex that is not there or not finite dropped",
    );
    let used = used(&mesh);
    let first = weld::representatives(&mesh.positions, &used);
    joined(mesh, &first, work)
}

/// The mesh with each vertex replaced by another, without the degenerate and duplicate triangles and unused vertices that leaves. All
/// vertices of triangles are there.
pub(super) fn joined(mut mesh: Mesh, other: &[u32], work: &mut Work) -> Mesh {
    let moved = (0_u32..)
        .zip(other)
        .filter(|(vertex, other)| vertex != *other);
    work.remark(moved.count(), "vertex joined", "vertices joined");
    mesh.triangles.par_iter_mut().for_each(|triangle| {
        *triangle = triangle.map(|vertex| other[vertex as usize]);
    });
    let before = mesh.triangles.len();
    mesh.triangles
        .retain(|[a, b, c]| a != b && b != c && c != a);
    work.remark(
        before - mesh.triangles.len(),
        "degenerate triangle dropped",
        "degenerate triangles dropped",
    );
    let duplicates = Edges::new(&mesh.triangles, mesh.positions.len()).duplicates();
    without(&mut mesh.triangles, &duplicates);
    work.remark(
        duplicates.len(),
        "triangle that was there already dropped",
        "triangles that were there already dropped",
    );
    // Those that were joined have been told.
    let used = used(&mesh);
    let unused = (0_u32..)
        .zip(other.iter().zip(&used))
        .filter(|(vertex, (other, used))| !**used && vertex == *other);
    work.remark(
        unused.count(),
        "unused vertex dropped",
        "unused vertices dropped",
    );
    compact(mesh, &used)
}

/// Leaves out some triangles, given sorted.
fn without(triangles: &mut Vec<Face>, left_out: &[u32]) {
    if left_out.is_empty() {
        return;
    }
    let mut number = 0_u32;
    let mut left_out = left_out.iter().peekable();
    triangles.retain(|_| {
        let stays = left_out.next_if_eq(&&number).is_none();
        number += 1;
        stays
    });
}

/// Which vertices triangles use.
fn used(mesh: &Mesh) -> Vec<bool> {
    let mut used = vec![false; mesh.positions.len()];
    for vertex in mesh.triangles.as_flattened() {
        used[*vertex as usize] = true;
    }
    used
}

/// The mesh without vertices that no triangle uses; the others stay in order.
pub(super) fn without_unused(mesh: Mesh) -> Mesh {
    let used = used(&mesh);
    compact(mesh, &used)
}

fn compact(mut mesh: Mesh, used: &[bool]) -> Mesh {
    if used.iter().all(|used| *used) {
        return mesh;
    }
    let mut number = vec![NONE; used.len()];
    let stay = number.iter_mut().zip(used).filter(|(_, used)| **used);
    for ((number, _), next) in stay.zip(0_u32..) {
        *number = next;
    }
    let mut at = used.iter();
    mesh.positions
        .retain(|_| at.next().copied().unwrap_or(false));
    mesh.triangles.par_iter_mut().for_each(|triangle| {
        *triangle = triangle.map(|vertex| number[vertex as usize]);
    });
    mesh
}
