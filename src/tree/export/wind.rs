//! How each vertex moves in the wind, as four numbers from 0 to 1 that a shader multiplies its own waves with.
//!
//! - *sway*: how far it goes with the bending trunk: of a place on the trunk, δ(x) of the way along it; all that a branch carries has that of the place where
//!   the branch leaves the trunk, so that it moves as one.
//! - *phase*: of a branch on the trunk and all that it carries, drawn by chance from its place, so that no two swing together.
//! - *branch*: how far it goes with its branch: δ(x) of the way along to the farthest tip, times the branch's length in that of the longest; 0 on the trunk.
//! - *flutter*: how far it goes with its leaf: 0 at the foot, 1 at the tip; 0 on wood.
//!
//! δ(x) = x²(6 − 4x + x²)/3 is how a beam that is held at one end bends under an even load (Euler and Bernoulli), 0 at its foot and 1 at its tip.

use glam::Vec3;

use super::instances::length;
use super::surface::{Matter, Surface, vertices_of};
use crate::tree::axes::axis_children;
use crate::tree::draws::Draws;
use crate::tree::organs::{self, Numbers, OrganMesh, Organist, Placed, Refined};
use crate::tree::tubes::CAPPED;
use crate::tree::{NO_PARENT, Tree};

/// Of a node: sway, phase, branch.
type Wind = [f32; 3];

/// How the wood of a tree bends.
#[derive(Debug)]
pub(super) struct Bending {
    /// At the start and the end of each tube's record.
    records: Vec<[Wind; 2]>,
    /// At each node of the tree.
    nodes: Vec<Wind>,
}

impl Bending {
    /// Of a tree that is drawn as a finer one, where there is one.
    pub(super) fn of(tree: &Tree, fine: Option<&Refined>) -> Self {
        let drawn = fine.map_or(tree, |fine| &fine.tree);
        let winds = winds(drawn);
        let ends = drawn.parent.iter().zip(&winds);
        let ends = ends.filter(|(parent, _)| **parent != NO_PARENT);
        let records = ends.map(|(parent, end)| [winds[*parent as usize], *end]);
        Self {
            records: records.collect(),
            nodes: match fine {
                Some(fine) => fine.number.iter().map(|at| winds[*at as usize]).collect(),
                None => winds,
            },
        }
    }

    /// At a place that hangs on a node.
    pub(super) fn at(&self, tree: &Tree, node: u32, place: Vec3) -> Wind {
        let node = node as usize;
        let Some(end) = self.nodes.get(node).copied() else {
            return [0.0; 3];
        };
        let parent = tree.parent[node] as usize;
        let Some(start) = self.nodes.get(parent).copied() else {
            return end;
        };
        let from = tree.position[parent];
        let way = tree.position[node] - from;
        let part = (place - from).dot(way) / way.length_squared().max(f32::MIN_POSITIVE);
        let part = part.clamp(0.0, 1.0);
        let between = |at: usize| start[at] + part * (end[at] - start[at]);
        // A phase is of the whole branch.
        [between(0), end[1], between(2)]
    }
}

/// A beam's bend.
fn bend(along: f32, length: f32) -> f32 {
    let x = (along / length.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    x * x * (6.0 - 4.0 * x + x * x) / 3.0
}

/// Where a node is: on the beam that begins with a node, so many metres from its start.
#[derive(Clone, Copy, Default)]
struct Way {
    beam: u32,
    along: f32,
    is_trunk: bool,
}

/// The way to each node, and how long the beam is that begins with it.
fn ways(tree: &Tree) -> (Vec<Way>, Vec<f32>) {
    let axis = axis_children(tree);
    let mut ways: Vec<Way> = Vec::with_capacity(tree.len());
    let mut longest = vec![0.0_f32; tree.len()];
    for (node, (&parent, place)) in (0_u32..).zip(tree.parent.iter().zip(&tree.position)) {
        let mut way = Way {
            beam: node,
            along: 0.0,
            is_trunk: true,
        };
        if parent != NO_PARENT {
            let below = ways[parent as usize];
            let step = place.distance(tree.position[parent as usize]);
            let leaves_trunk = below.is_trunk && axis[parent as usize] != node;
            way = match leaves_trunk {
                true => Way {
                    along: step,
                    is_trunk: false,
                    ..way
                },
                false => Way {
                    along: below.along + step,
                    ..below
                },
            };
        }
        let most = &mut longest[way.beam as usize];
        *most = most.max(way.along);
        ways.push(way);
    }
    (ways, longest)
}

fn winds(tree: &Tree) -> Vec<Wind> {
    let (ways, longest) = ways(tree);
    let of_branches = ways.iter().filter(|way| !way.is_trunk);
    let most = of_branches
        .map(|way| longest[way.beam as usize])
        .fold(f32::MIN_POSITIVE, f32::max);
    let wind = |way: &Way| -> Wind {
        let length = longest[way.beam as usize];
        if way.is_trunk {
            return [bend(way.along, length), 0.0, 0.0];
        }
        let trunk = ways[tree.parent[way.beam as usize] as usize];
        let sway = bend(trunk.along, longest[trunk.beam as usize]);
        let start = tree.position[way.beam as usize].to_array();
        let [x, y, z] = start.map(|part| u64::from(part.to_bits()));
        #[allow(clippy::cast_possible_truncation, reason = "0 to 1")]
        let phase = Draws::new(x << 32 | y, z).uniform(0.0, 1.0) as f32;
        [sway, phase, bend(way.along, length) * (length / most)]
    };
    ways.iter().map(wind).collect()
}

/// Sway, phase, branch and flutter of each vertex of a group, in their order.
pub(super) fn each(surface: &Surface<'_>, matter: Matter, mut take: impl FnMut([f32; 4])) {
    let Some(bending) = &surface.bending else {
        return;
    };
    let ring = surface.sides as usize + 1;
    let own = surface.records.iter().zip(&bending.records);
    for (record, [from, to]) in own.filter(|(record, _)| surface.matter(record) == matter) {
        let cap = match record.flags & CAPPED {
            0 => 0,
            _ => ring - 1,
        };
        let disc = vertices_of(record, surface.sides) - 2 * ring - cap;
        for (count, [sway, phase, branch]) in [(ring, from), (ring + cap, to), (disc, from)] {
            (0..count).for_each(|_| take([*sway, *phase, *branch, 0.0]));
        }
    }
    let leaves: Vec<Vec<f32>> = surface.organs.surfaces.iter().map(flutter_of).collect();
    carried(surface, matter, Numbers::POSITIONS, |node, mesh, placed| {
        let leaf = placed.and_then(|placed| leaves.get(usize::from(placed.surface)));
        for (vertex, place) in mesh.positions.iter().enumerate() {
            // A leaf goes with the place where it is held.
            let held = placed.map_or(Vec3::from(*place), |placed| placed.position);
            let [sway, phase, branch] = bending.at(surface.tree, node, held);
            let flutter = leaf.and_then(|leaf| leaf.get(vertex).copied());
            take([sway, phase, branch, flutter.unwrap_or(0.0)]);
        }
    });
}

/// Texture coordinates of each vertex of a painted group, in their order: those of leaves, (0, 0) elsewhere.
pub(super) fn coordinates(surface: &Surface<'_>, matter: Matter, mut take: impl FnMut([f32; 2])) {
    for record in &surface.records {
        if surface.matter(record) == matter {
            (0..vertices_of(record, surface.sides)).for_each(|_| take([0.0; 2]));
        }
    }
    let leaves: Vec<Vec<[f32; 2]>> = surface.organs.surfaces.iter().map(coordinates_of).collect();
    carried(surface, matter, Numbers::NONE, |_, mesh, placed| {
        let leaf = placed.and_then(|placed| leaves.get(usize::from(placed.surface)));
        for vertex in 0..mesh.vertices {
            let place = leaf.and_then(|leaf| leaf.get(vertex).copied());
            take(place.unwrap_or([0.0; 2]));
        }
    });
}

/// Shows what is asked for of each organ of a group, the node that it hangs on, and where it is placed if it is.
fn carried(
    surface: &Surface<'_>,
    matter: Matter,
    numbers: Numbers,
    mut show: impl FnMut(u32, &OrganMesh, Option<&Placed>),
) {
    let organs = surface.organs;
    let before = organs.polygons.len() + organs.spheres.len();
    let mut organist = Organist::new(organs);
    let mut mesh = OrganMesh::default();
    for index in 0..surface.loose {
        let organ = organist.organ(index);
        let organ = organ.filter(|organ| matter == Matter::Painted(organ.paint.material));
        if let Some(organ) = organ {
            mesh.clear();
            organist.add_only(index, numbers, &mut mesh);
            let placed = index
                .checked_sub(before)
                .and_then(|at| organs.placed.get(at));
            show(organ.node, &mesh, placed);
        }
    }
}

/// How far each vertex of a leaf flutters.
pub(super) fn flutter_of(leaf: &organs::Surface) -> Vec<f32> {
    let length = length(leaf).max(f32::MIN_POSITIVE);
    let parts = leaf.positions.iter().map(|place| place.length() / length);
    parts.collect()
}

/// Texture coordinates of a leaf's vertices: across and along it, 0 to 1 where it lies flat.
pub(super) fn coordinates_of(leaf: &organs::Surface) -> Vec<[f32; 2]> {
    let length = length(leaf).max(f32::MIN_POSITIVE);
    let places = leaf.positions.iter();
    places
        .map(|place| [0.5 + place.x / length, place.y / length])
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;
    use crate::tree::Node;

    #[test]
    fn a_branch_moves_with_its_trunk_where_it_leaves_it_and_most_at_its_tip() {
        let mut tree = Tree {
            letters: vec!["F".to_owned()],
            ..Tree::default()
        };
        for (parent, place, order) in [
            (NO_PARENT, [0.0, 0.0, 0.0], 0),
            (0, [0.0, 1.0, 0.0], 0),
            (1, [0.0, 2.0, 0.0], 0),
            (1, [1.0, 1.0, 0.0], 1),
            (3, [2.0, 1.0, 0.0], 1),
            (3, [1.0, 1.5, 0.0], 2),
            (1, [0.0, 1.0, 0.5], 1),
        ] {
            tree.push(Node {
                parent,
                position: Vec3::from(place),
                radius: 0.1,
                letter: 0,
                order,
                birth: 0,
            });
        }
        let winds = winds(&tree);
        // Half-way up a beam.
        let half = 0.25 * 4.25 / 3.0;
        let near = |a: f32, b: f32| (a - b).abs() < 1e-6;
        assert_eq!(winds[0], [0.0; 3]);
        assert!(near(winds[2][0], 1.0) && near(winds[1][0], half));
        for node in [3, 4, 5, 6] {
            assert!(near(winds[node][0], winds[1][0]), "as its fork does");
        }
        assert!(near(winds[3][2], half) && near(winds[4][2], 1.0));
        assert!(near(winds[6][2], 0.25), "a quarter as long");
        assert!(near(winds[3][1], winds[5][1]) && !near(winds[3][1], winds[6][1]));
        // Between two nodes it is between theirs; nothing hangs on none.
        let bending = Bending::of(&tree, None);
        let [_, phase, branch] = bending.at(&tree, 4, Vec3::new(1.5, 1.1, 0.0));
        assert!(near(phase, winds[4][1]) && winds[3][2] < branch && branch < 1.0);
        assert_eq!(bending.at(&tree, NO_PARENT, Vec3::ONE), [0.0; 3]);
    }
}
