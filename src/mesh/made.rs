//! Meshes made by formula, whose facts are known, for tests.

use std::collections::BTreeMap;
use std::f32::consts::TAU;

use glam::{DVec3, Vec3};

use super::Mesh;

fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh {
        origin: DVec3::ZERO,
        positions,
        triangles,
    }
}

/// A sphere of radius 1: an icosahedron whose triangles are divided `times` times into four. 20·4ⁿ triangles, 10·4ⁿ + 2 vertices.
pub(crate) fn sphere(times: u32) -> Mesh {
    let golden = (1.0 + 5.0_f32.sqrt()) / 2.0;
    let mut positions = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (-1.0, golden),
        (1.0, -golden),
        (-1.0, -golden),
    ] {
        positions.extend([
            Vec3::new(0.0, a, b),
            Vec3::new(a, b, 0.0),
            Vec3::new(b, 0.0, a),
        ]);
    }
    // All triples at the edge's length, turned outwards.
    let mut triangles = Vec::new();
    for a in 0..12_u32 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let [p, q, r] = [a, b, c].map(|v| positions[v as usize]);
                let near = |p: Vec3, q: Vec3| (p.distance(q) - 2.0).abs() < 0.1;
                if near(p, q) && near(q, r) && near(r, p) {
                    let outwards = (q - p).cross(r - p).dot(p) > 0.0;
                    triangles.push(if outwards { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    for _ in 0..times {
        triangles = divided(&mut positions, &triangles);
    }
    mesh(
        positions.into_iter().map(Vec3::normalize).collect(),
        triangles,
    )
}

fn divided(positions: &mut Vec<Vec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
            positions.push(
                (positions[a as usize].normalize() + positions[b as usize].normalize()) / 2.0,
            );
            u32::try_from(positions.len() - 1).unwrap_or(u32::MAX)
        })
    };
    triangles
        .iter()
        .flat_map(|[a, b, c]| {
            let [ab, bc, ca] = [middle(*a, *b), middle(*b, *c), middle(*c, *a)];
            [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]]
        })
        .collect()
}

/// A grid of squares, each cut in two, `round` columns and `rows` rows of vertices; the last column is joined to the first, and the last row
/// to the first where `closed`.
fn grid(round: u32, rows: u32, closed: bool, point: impl Fn(u32, u32) -> Vec3) -> Mesh {
    let number = |column: u32, row: u32| (row % rows) * round + column % round;
    let positions = (0..rows).flat_map(|row| (0..round).map(move |column| (column, row)));
    let squares = (0..if closed { rows } else { rows - 1 })
        .flat_map(|row| (0..round).map(move |column| (column, row)));
    let triangles = squares.flat_map(|(column, row)| {
        let [a, b] = [number(column, row), number(column + 1, row)];
        let [c, d] = [number(column + 1, row + 1), number(column, row + 1)];
        [[a, b, c], [a, c, d]]
    });
    mesh(
        positions.map(|(column, row)| point(column, row)).collect(),
        triangles.collect(),
    )
}

fn turn(part: u32, of: u32) -> (f32, f32) {
    let part = u16::try_from(part % of).map_or(0.0, f32::from);
    (part / u16::try_from(of).map_or(1.0, f32::from) * TAU).sin_cos()
}

/// A ring with a hole: genus 1, 2·round·rows triangles. Its circles have radii 2 and 0.5.
pub(crate) fn torus(round: u32, rows: u32) -> Mesh {
    grid(round, rows, true, |column, row| {
        let ((sin, cos), (sin_tube, cos_tube)) = (turn(column, round), turn(row, rows));
        let radius = 2.0 + 0.5 * cos_tube;
        Vec3::new(radius * cos, radius * sin, 0.5 * sin_tube)
    })
}

/// A tube of radius 1 along z, a unit between two rows, open at both ends.
pub(crate) fn tube(round: u32, rows: u32) -> Mesh {
    grid(round, rows, false, |column, row| {
        let (sin, cos) = turn(column, round);
        Vec3::new(cos, sin, u16::try_from(row).map_or(0.0, f32::from))
    })
}

/// A Möbius strip of `round` squares.
pub(crate) fn moebius(round: u32) -> Mesh {
    let positions = (0..round).flat_map(|column| {
        let ((sin, cos), (half_sin, half_cos)) = (turn(column, round), turn(column, 2 * round));
        [-0.5, 0.5].map(|across| {
            let radius = 2.0 + across * half_cos;
            Vec3::new(radius * cos, radius * sin, across * half_sin)
        })
    });
    let triangles = (0..round).flat_map(|column| {
        let [a, b] = [2 * column, 2 * column + 1];
        let [c, d] = match column + 1 == round {
            true => [1, 0],
            false => [a + 2, a + 3],
        };
        [[a, c, b], [b, c, d]]
    });
    mesh(positions.collect(), triangles.collect())
}

/// Three squares on one edge, each of two triangles.
pub(crate) fn book() -> Mesh {
    let mut positions = vec![Vec3::ZERO, Vec3::Z];
    let mut triangles = Vec::new();
    for (page, number) in (0..3_u32).zip([2, 4, 6]) {
        let (sin, cos) = turn(page, 3);
        let out = Vec3::new(cos, sin, 0.0);
        positions.extend([out, out + Vec3::Z]);
        triangles.extend([[0, number, number + 1], [0, number + 1, 1]]);
    }
    mesh(positions, triangles)
}

/// Two triangles that share a vertex only.
pub(crate) fn bow_tie() -> Mesh {
    let corners = [[0, 0], [1, 1], [1, -1], [-1, 1], [-1, -1]];
    let positions = corners.map(|[x, y]: [i8; 2]| Vec3::new(f32::from(x), f32::from(y), 0.0));
    mesh(positions.to_vec(), vec![[0, 2, 1], [0, 3, 4]])
}

/// A cube from 0 to 1 of twelve triangles.
pub(crate) fn cube() -> Mesh {
    let positions = (0..8_u8)
        .map(|v| Vec3::new(f32::from(v & 1), f32::from(v >> 1 & 1), f32::from(v >> 2)))
        .collect();
    let sides = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles = sides
        .iter()
        .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    mesh(positions, triangles.collect())
}

/// One beside the other, with all vertices of both.
pub(crate) fn both(one: &Mesh, other: &Mesh) -> Mesh {
    let behind = u32::try_from(one.positions.len()).unwrap_or(u32::MAX);
    let mut all = one.clone();
    all.positions.extend(&other.positions);
    all.triangles.extend(
        other
            .triangles
            .iter()
            .map(|triangle| triangle.map(|vertex| vertex + behind)),
    );
    all
}

/// Larger and elsewhere.
pub(crate) fn placed(mut mesh: Mesh, scale: f32, by: Vec3) -> Mesh {
    mesh.positions
        .iter_mut()
        .for_each(|position| *position = scale * *position + by);
    mesh
}

/// Some triangles turned.
pub(crate) fn turned(mut mesh: Mesh, which: impl Fn(usize) -> bool) -> Mesh {
    for (triangle, vertices) in mesh.triangles.iter_mut().enumerate() {
        if which(triangle) {
            vertices.swap(1, 2);
        }
    }
    mesh
}

/// Three vertices for each triangle, as STL files have them.
pub(crate) fn soup(of: &Mesh) -> Mesh {
    let positions: Vec<Vec3> = of
        .triangles
        .as_flattened()
        .iter()
        .map(|vertex| of.positions[*vertex as usize])
        .collect();
    let triangles = (0_u32..).step_by(3).take(of.triangles.len());
    mesh(
        positions,
        triangles
            .map(|first| [first, first + 1, first + 2])
            .collect(),
    )
}
