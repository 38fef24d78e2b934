//! Long triangles cut into shorter ones, so that there are balls and points to fit tubes to all along a tube of few sides and rings.
//!
//! Nothing is moved: new corners lie on the edges' middles. An edge that is longer than so many radii of the largest ball at its ends is cut in
//! two, again and again, in both of its triangles, so that the wall stays closed.

use glam::Vec3;
use hashbrown::HashMap;

use super::skin::Skin;
use crate::mesh::Mesh;

/// A triangle with an edge longer than so many radii is coarse.
const COARSE: f32 = 3.0;
/// One between the rims of the solid, as lids are made of, already so: a line ends before its middle. On rims normals lean by more than this cosine.
const COARSE_LID: f32 = 1.5;
const RIM: f64 = 0.8;
/// Edges of coarse triangles are cut until they are not longer than this.
const FINE: f32 = 0.8;
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
    let whole = skin.surface.mesh();
    let mut positions = whole.positions.clone();
    let faces = skin.surface.triangles().map(|(_, face)| face);
    let is_lid = |face: &[u32; 3]| face.iter().all(|one| skin.leans[*one as usize] < RIM);
    let is_coarse = |face: &[u32; 3]| {
        let most = if is_lid(face) { COARSE_LID } else { COARSE };
        edges(*face).any(|edge| is_long(&positions, &radii, edge, most))
    };
    let (mut coarse, mut fine): (Vec<[u32; 3]>, Vec<[u32; 3]>) = faces.partition(is_coarse);
    if coarse.is_empty() {
        return None;
    }
    let most = (TIMES * (coarse.len() + fine.len()) + MORE).min(MOST);
    for _ in 0..ROUNDS {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        for edge in coarse.iter().flat_map(|face| edges(*face)) {
            if !middles.contains_key(&edge) && is_long(&positions, &radii, edge, FINE) {
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
        // What is fine is cut only where its neighbours are, and stays fine.
        coarse = all_cut(&coarse, &middles, positions.len());
        fine = all_cut(&fine, &middles, positions.len());
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

/// Triangles cut at the middles of their edges that have one; there are so many vertices.
fn all_cut(faces: &[[u32; 3]], middles: &HashMap<[u32; 2], u32>, vertices: usize) -> Vec<[u32; 3]> {
    // Most triangles have none: what no edge with a middle ends at is not looked up.
    let mut ends = vec![false; vertices];
    for vertex in middles.keys().flatten() {
        ends[*vertex as usize] = true;
    }
    let mut all = Vec::with_capacity(faces.len() + 3 * middles.len());
    for face in faces {
        if face.iter().filter(|one| ends[**one as usize]).count() < 2 {
            all.push(*face);
        } else {
            cut(*face, middles, &mut all);
        }
    }
    all
}

/// A triangle cut at the middles of its edges that have one.
fn cut([a, b, c]: [u32; 3], middles: &HashMap<[u32; 2], u32>, into: &mut Vec<[u32; 3]>) {
    let middle = |one, other| middles.get(&edge(one, other)).copied();
    match [middle(a, b), middle(b, c), middle(c, a)] {
        [None, None, None] => into.push([a, b, c]),
        [Some(p), None, None] => into.extend([[a, p, c], [p, b, c]]),
        [None, Some(q), None] => into.extend([[b, q, a], [q, c, a]]),
        [None, None, Some(r)] => into.extend([[c, r, b], [r, a, b]]),
        [Some(p), Some(q), None] => into.extend([[p, b, q], [a, p, q], [a, q, c]]),
        [None, Some(q), Some(r)] => into.extend([[q, c, r], [b, q, r], [b, r, a]]),
        [Some(p), None, Some(r)] => into.extend([[r, a, p], [c, r, p], [c, p, b]]),
        [Some(p), Some(q), Some(r)] => {
            into.extend([[a, p, r], [p, b, q], [r, q, c], [p, q, r]]);
        }
    }
}
