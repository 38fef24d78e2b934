//! Each mend on meshes whose facts are known, told by the report before and after; any meshes at all; files of other programs.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

mod any;
mod coarser;
mod ends;
mod lists;
mod models;
mod parts;

use std::sync::atomic::AtomicBool;

use super::*;
use crate::mesh::made;

/// The mesh mended by a list, and the accounts as lines.
fn mended(mesh: &Mesh, list: &str) -> (Mesh, Vec<String>) {
    let (mesh, accounts) = try_mended(mesh, list).unwrap();
    (mesh, accounts.iter().map(Account::to_string).collect())
}

fn try_mended(mesh: &Mesh, list: &str) -> Result<(Mesh, Vec<Account>), MendError> {
    let mends = list_from_text(list).unwrap();
    let never = AtomicBool::new(false);
    mend_all(mesh.clone(), &mends, &never, &mut |_, _, _| {})
}

/// The report on a mesh that needs no joining.
fn look(mesh: &Mesh) -> Report {
    let params = ReportParams { weld: false };
    report::report(mesh, &params, &AtomicBool::new(false), &mut |_, _| {}).unwrap()
}

/// Watertight, manifold, genus of the first component, components, boundary loops.
fn facts(mesh: &Mesh) -> (bool, bool, Option<u32>, usize, usize) {
    let report = look(mesh);
    (
        report.is_watertight(),
        report.is_manifold(),
        report.components.first().and_then(|first| first.genus()),
        report.components.len(),
        report.boundary_loops.len(),
    )
}

/// Nothing is wrong with it that the report knows of: vertex numbers, finite numbers, agreeing triangles.
fn is_clean(mesh: &Mesh) -> bool {
    let report = look(mesh);
    report.unusable_triangles.is_empty()
        && report.degenerate_triangles.is_empty()
        && report.duplicate_triangles.is_empty()
        && report.unused_vertices.is_empty()
        && mesh.positions.iter().all(|position| position.is_finite())
}

/// How far the vertices of one are from the other's surface at most.
fn off(one: &Mesh, other: &Mesh) -> f64 {
    let nearest = nearest::Nearest::new(other);
    let far = one.positions.iter().map(|position| {
        let point = position.as_dvec3();
        nearest.point(point).unwrap().distance(point)
    });
    far.fold(0.0, f64::max)
}
