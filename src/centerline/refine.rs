//! Long triangles cut into shorter ones, so that there are balls and points to fit tubes to all along a tube of few sides and rings.
//!
//! Nothing is moved: new corners lie on the edges' middles. An edge that is longer than so many radii of the largest ball at its ends is cut in
//! two, again and again, in both of its triangles, so that the wall stays closed.

use glam::Vec3;
use hashbrown::HashMap;

use super::skin::Skin;
use crate::mesh::Mesh;
use crate::mesh::report::union::Sets;

/// A triangle with an edge longer than so many radii is coarse.
const COARSE: f32 = 3.0;
/// One between the rims of the solid, as lids are made of, already so: a line ends before its middle. On rims normals lean by more than this cosine.
const COARSE_LID: f32 = 1.5;
const RIM: f64 = 0.8;
/// Edges of coarse triangles are cut until they are not longer than this.
const FINE: f32 = 0.8;
/// The same on lids that are cut before there are balls: along a rim these are smaller than the lid is wide.
const FINE_LID: f32 = 0.4;
/// Rounds at most: an edge is cut in so many powers of two.
const ROUNDS: usize = 8;
/// Triangles at most: as many times as there were and so many more, but in all no more than this.
const TIMES: usize = 12;
const MORE: usize = 1 << 6;
const MOST: usize = 1 << 21;
/// Where it is thinner than this part of the median, as towards a tip, triangles need not be shorter.
const THIN: f32 = 0.5;

/// The wall of a solid with its long triangles cut; `radii` are those of the balls at its vertices, zero where none is known. None where all
/// triangles are short, or no radius is known.
pub(super) fn refined(skin: &Skin<'_>, mut radii: Vec<f32>) -> Option<Mesh> {
    let mut known: Vec<f32> = radii.iter().copied().filter(|one| *one > 0.0).collect();
    known.sort_by(f32::total_cmp);
    let least = THIN * known.get(known.len() / 2).copied()?;
    radii
        .iter_mut()
        .for_each(|radius| *radius = radius.max(least));
    let faces = skin.surface.triangles().map(|(_, face)| face);
    let is_lid = |face: &[u32; 3]| face.iter().all(|one| skin.leans[*one as usize] < RIM);
    let most = |face: &[u32; 3]| if is_lid(face) { COARSE_LID } else { COARSE };
    cut_finer(skin.surface.mesh(), faces, radii, most, FINE)
}

/// A mesh whose triangles from `first` on are lids that close its open ends, with the long ones among those cut. The radius is that of a disc of a
/// lid's area, which is known before there are balls: what is cut here needs not be covered twice.
#[allow(
    clippy::cast_possible_truncation,
    reason = "the mesh is in single precision"
)]
pub(super) fn with_finer_lids(mesh: Mesh, first: usize) -> Mesh {
    let lids = mesh.triangles.get(first..).unwrap_or_default();
    let mut lid_of = Sets::new(mesh.positions.len());
    for [a, b, c] in lids {
        lid_of.join(*a, *b);
        lid_of.join(*b, *c);
    }
    let mut areas: HashMap<u32, f64> = HashMap::new();
    for face in lids {
        let [a, b, c] = face.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
        *areas.entry(lid_of.find(face[0])).or_default() += (b - a).cross(c - a).length() / 2.0;
    }
    let mut radii = vec![0.0; mesh.positions.len()];
    for vertex in lids.iter().flatten() {
        let area = areas.get(&lid_of.find(*vertex)).copied().unwrap_or(0.0);
        radii[*vertex as usize] = (area / std::f64::consts::PI).sqrt() as f32;
    }
    let on_lid: Vec<bool> = radii.iter().map(|radius| *radius > 0.0).collect();
    let is_lid = |face: &[u32; 3]| face.iter().all(|one| on_lid[*one as usize]);
    let most = |face: &[u32; 3]| {
        if is_lid(face) {
            FINE_LID
        } else {
            f32::INFINITY
        }
    };
    let faces = mesh.triangles.iter().copied();
    cut_finer(&mesh, faces, radii, most, FINE_LID).unwrap_or(mesh)
}

/// The triangles with an edge longer than `most` says, in radii of its ends, are cut until none of their edges is longer than `enough`.
fn cut_finer(
    whole: &Mesh,
    faces: impl Iterator<Item = [u32; 3]>,
    mut radii: Vec<f32>,
    most: impl Fn(&[u32; 3]) -> f32,
    enough: f32,
) -> Option<Mesh> {
    let mut positions = whole.positions.clone();
    let is_coarse =
        |face: &[u32; 3]| edges(*face).any(|edge| is_long(&positions, &radii, edge, most(face)));
    let (mut coarse, mut fine): (Vec<[u32; 3]>, Vec<[u32; 3]>) = faces.partition(is_coarse);
    if coarse.is_empty() {
        return None;
    }
    let most = (TIMES * (coarse.len() + fine.len()) + MORE).min(MOST);
    for _ in 0..ROUNDS {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        for edge in coarse.iter().flat_map(|face| edges(*face)) {
            if !middles.contains_key(&edge) && is_long(&positions, &radii, edge, enough) {
                let [one, other] = edge.map(|vertex| vertex as usize);
                let middle = u32::try_from(positions.len()).ok()?;
                middles.insert(edge, middle);
                positions.push(positions[one].midpoint(positions[other]));
                radii.push(f32::midpoint(radii[one], radii[other]));
            }
        }
        // Each edge that is cut makes two triangles more.
        if middles.is_empty() || coarse.len() + fine.len() + 2 * middles.len() > most {
            break;
        }
        coarse = cut_all(&coarse, &middles);
        // What is fine is cut only where its neighbours are, and stays fine.
        fine = cut_all(&fine, &middles);
    }
    coarse.extend(fine);
    Some(Mesh {
        origin: whole.origin,
        positions,
        triangles: coarse,
    })
}

/// A triangle's edges, each from the smaller vertex.
fn edges(face: [u32; 3]) -> impl Iterator<Item = [u32; 2]> {
    (0..3).map(move |corner| edge(face[corner], face[(corner + 1) % 3]))
}

fn edge(one: u32, other: u32) -> [u32; 2] {
    [one.min(other), one.max(other)]
}

fn is_long(positions: &[Vec3], radii: &[f32], edge: [u32; 2], radii_long: f32) -> bool {
    let [one, other] = edge.map(|vertex| vertex as usize);
    let radius = radii[one].max(radii[other]);
    positions[one].distance(positions[other]) > radii_long * radius
}

/// Triangles, cut at the middles of those of their edges that have one.
fn cut_all(faces: &[[u32; 3]], middles: &HashMap<[u32; 2], u32>) -> Vec<[u32; 3]> {
    let last = middles.keys().map(|edge| edge[1]).max().unwrap_or(0);
    let mut at_cut = vec![false; last as usize + 1];
    let ends = middles.keys().flatten();
    ends.for_each(|vertex| at_cut[*vertex as usize] = true);
    let is_at_cut = |vertex: &&u32| at_cut.get(**vertex as usize).copied().unwrap_or(false);
    let mut all = Vec::with_capacity(faces.len() + 2 * middles.len());
    for face in faces {
        // Most have none, and need not be looked up.
        match face.iter().filter(is_at_cut).count() {
            0 | 1 => all.push(*face),
            _ => cut(*face, middles, &mut all),
        }
    }
    all
}

/// A triangle cut at the middles of its edges that have one.
fn cut([a, b, c]: [u32; 3], middles: &HashMap<[u32; 2], u32>, into: &mut Vec<[u32; 3]>) {
    let middle = |one, other| middles.get(&edge(one, other)).copied();
    let pieces: &[[u32; 3]] = match [middle(a, b), middle(b, c), middle(c, a)] {
        [None, None, None] => &[[a, b, c]],
        [Some(p), None, None] => &[[a, p, c], [p, b, c]],
        [None, Some(q), None] => &[[b, q, a], [q, c, a]],
        [None, None, Some(r)] => &[[c, r, b], [r, a, b]],
        [Some(p), Some(q), None] => &[[p, b, q], [a, p, q], [a, q, c]],
        [None, Some(q), Some(r)] => &[[q, c, r], [b, q, r], [b, r, a]],
        [Some(p), None, Some(r)] => &[[r, a, p], [c, r, p], [c, p, b]],
        [Some(p), Some(q), Some(r)] => &[[a, p, r], [p, b, q], [r, q, c], [p, q, r]],
    };
    into.extend_from_slice(pieces);
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]
mod tests {
    use super::*;
    use crate::mesh::report::{ReportParams, report};
    use std::sync::atomic::AtomicBool;

    const SIDES: u32 = 16;
    const ROWS: u32 = 4;

    /// A tube of radius 1 along z, four long, closed by fans of triangles between corners of its rims, which come last.
    fn tube() -> Mesh {
        let corner = |n: u32| {
            let turn = std::f32::consts::TAU * (n % SIDES) as f32 / SIDES as f32;
            Vec3::new(turn.cos(), turn.sin(), (n / SIDES) as f32)
        };
        let walls = (0..ROWS * SIDES).flat_map(|n| {
            let next = n - n % SIDES + (n + 1) % SIDES;
            [[n, next, next + SIDES], [n, next + SIDES, n + SIDES]]
        });
        let top = ROWS * SIDES;
        let lids = (1..SIDES - 1).flat_map(|n| [[0, n + 1, n], [top, top + n, top + n + 1]]);
        Mesh {
            positions: (0..top + SIDES).map(corner).collect(),
            triangles: walls.chain(lids).collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn lids_are_cut_and_stay_closed() {
        let first = (2 * ROWS * SIDES) as usize;
        let finer = with_finer_lids(tube(), first);
        let on_lid = |face: &&[u32; 3]| {
            let z = face.map(|one| finer.positions[one as usize].z);
            z[0] == z[1] && z[1] == z[2]
        };
        let lids: Vec<&[u32; 3]> = finer.triangles.iter().filter(on_lid).collect();
        assert!(lids.len() > 100, "{}", lids.len());
        for edge in lids.iter().flat_map(|face| edges(**face)) {
            let [one, other] = edge.map(|vertex| finer.positions[vertex as usize]);
            assert!(one.distance(other) <= FINE_LID);
        }
        let never = AtomicBool::new(false);
        let told = report(
            &finer,
            &ReportParams { weld: false },
            &never,
            &mut |_, _| {},
        )
        .unwrap();
        assert!(told.boundary_loops.is_empty());
        let volume = |mesh: &Mesh| -> f32 {
            let corners = |face: &[u32; 3]| face.map(|one| mesh.positions[one as usize]);
            let sixfold = mesh
                .triangles
                .iter()
                .map(corners)
                .map(|[a, b, c]| a.dot(b.cross(c)));
            sixfold.sum::<f32>() / 6.0
        };
        assert!((volume(&finer) - volume(&tube())).abs() < 1e-4);
        assert!(volume(&finer) > 12.0);
    }
}
