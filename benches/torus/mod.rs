//! A surface that several benches time their work on.

use glam::{DVec3, Vec3};
use ramus::mesh::Mesh;

/// A ring with a hole, of 2 · round · rows triangles.
pub(crate) fn torus(round: u32, rows: u32) -> Mesh {
    let angle =
        |part: u32, of: u32| (f64::from(part) / f64::from(of) * std::f64::consts::TAU).sin_cos();
    let point = |column, row| {
        let ((sin, cos), (sin_tube, cos_tube)) = (angle(column, round), angle(row, rows));
        let radius = 2.0 + 0.5 * cos_tube;
        DVec3::new(radius * cos, radius * sin, 0.5 * sin_tube).as_vec3()
    };
    let number = |column: u32, row: u32| row % rows * round + column % round;
    let squares = || (0..rows).flat_map(|row| (0..round).map(move |column| (column, row)));
    Mesh {
        origin: DVec3::ZERO,
        positions: squares().map(|(column, row)| point(column, row)).collect(),
        triangles: squares()
            .flat_map(|(column, row)| {
                let [a, b] = [number(column, row), number(column + 1, row)];
                let [c, d] = [number(column + 1, row + 1), number(column, row + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
    }
}

/// Three vertices for each triangle, as STL files have them.
pub(crate) fn soup(mesh: &Mesh) -> Mesh {
    let corners = mesh.triangles.as_flattened().iter();
    let positions: Vec<Vec3> = corners
        .map(|vertex| mesh.positions[*vertex as usize])
        .collect();
    let first = (0_u32..).step_by(3).take(mesh.triangles.len());
    Mesh {
        origin: mesh.origin,
        positions,
        triangles: first.map(|a| [a, a + 1, a + 2]).collect(),
    }
}
