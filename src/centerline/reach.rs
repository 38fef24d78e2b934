//! From the last ball of a line on to the surface: how far it is, straight on, and lines that go on to the middles of open ends.

use glam::{DVec3, Vec3};

use super::Centerline;
use super::solids::Solids;
use crate::mesh::surface::Surface;
use crate::tree::{NO_PARENT, Node, Tree};

/// How far back from its end a line's direction is looked for, in radii.
const BACK: f64 = 1.0;
/// The surface is not looked for farther than so many radii.
const FAR: f64 = 8.0;
/// Steps back at most.
const STEPS_MOST: usize = 4096;

/// How far the closed surface is from each end of a tree, straight on: the root's, then those of `ends`. None where there is nothing, and where other lines go on.
pub(super) fn to_surface(
    tree: &Tree,
    ends: &[Option<u32>],
    solids: &Solids<'_>,
) -> Vec<Option<f64>> {
    let next = next(tree);
    let root = (!tree.is_empty()).then_some(0);
    let reach = |end: Option<u32>, is_root: bool| {
        let way = way(tree, &next, end?, is_root)?;
        let place = tree.position[end? as usize];
        let radius = f64::from(tree.radius[end? as usize]);
        distance(solids, place, way, FAR * radius)
    };
    let ends = ends.iter().map(|end| reach(*end, false));
    std::iter::once(reach(root, true)).chain(ends).collect()
}

/// A child of each node, the first.
fn next(tree: &Tree) -> Vec<u32> {
    let mut next = vec![NO_PARENT; tree.len()];
    for (node, parent) in (0_u32..).zip(&tree.parent) {
        if let Some(child) = next.get_mut(*parent as usize)
            && *child == NO_PARENT
        {
            *child = node;
        }
    }
    next
}

/// The direction in which a line ends, or comes from at its root.
fn way(tree: &Tree, next: &[u32], end: u32, is_root: bool) -> Option<DVec3> {
    let place = |node: u32| tree.position[node as usize].as_dvec3();
    if !is_root && next[end as usize] != NO_PARENT {
        return None;
    }
    let enough = BACK * f64::from(tree.radius[end as usize]);
    let mut at = end;
    for _ in 0..STEPS_MOST {
        let step = if is_root {
            next[at as usize]
        } else {
            tree.parent[at as usize]
        };
        if step == NO_PARENT {
            break;
        }
        at = step;
        if place(at).distance(place(end)) >= enough {
            break;
        }
    }
    (place(end) - place(at)).try_normalize()
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "the mesh is in single precision"
)]
fn distance(solids: &Solids<'_>, from: Vec3, way: DVec3, most: f64) -> Option<f64> {
    let (skin, _) = solids.deepest(from.as_dvec3(), None)?;
    let picker = skin.surface.picker();
    let hit = picker.ray_to(from, way.as_vec3(), most as f32, picker.inner_sides())?;
    Some(f64::from(hit.distance))
}

/// Lets lines that begin or end at an open end of a surface go on to its middle, with the radius of their last ball, as VMTK does.
#[allow(
    clippy::cast_possible_truncation,
    reason = "trees are in single precision"
)]
pub(super) fn to_caps(found: &mut Centerline, surface: &Surface) {
    let middles: Vec<(DVec3, f64)> = surface
        .open_ends()
        .iter()
        .map(|line| middle(surface, line))
        .collect();
    let shift = surface.mesh().origin - found.origin;
    let ends: Vec<(usize, Option<u32>)> = std::iter::once(Some(0))
        .chain(found.ends.iter().copied())
        .enumerate()
        .collect();
    let mut root = None;
    for (place, end) in ends {
        let (Some(end), Some(endpoint)) = (end, found.endpoints.get(place)) else {
            continue;
        };
        let point = endpoint.point - surface.mesh().origin;
        let own = middles
            .iter()
            .filter(|(middle, radius)| middle.distance(point) <= *radius)
            .min_by(|a, b| a.0.distance(point).total_cmp(&b.0.distance(point)));
        // Lines that go on to others do not end there.
        let is_end = found.to_surface.get(place).is_some_and(Option::is_some);
        let (Some((middle, _)), true) = (own, is_end) else {
            continue;
        };
        let position = (*middle + shift).as_vec3();
        found.capped += 1;
        found.to_surface[place] = Some(0.0);
        if place == 0 {
            root = Some(position);
            continue;
        }
        let last = end as usize;
        let node = found.tree.push(Node {
            parent: end,
            position,
            radius: found.tree.radius[last],
            letter: found.tree.letter[last],
            order: found.tree.order[last],
            birth: found.tree.birth[last],
        });
        found.ends[place - 1] = Some(node);
    }
    if let Some(position) = root {
        from_root(found, position);
    }
}

/// The middle of an open end's vertices, as VMTK has the middles of caps, and how far the farthest is.
fn middle(surface: &Surface, line: &[u32]) -> (DVec3, f64) {
    let points = || line.iter().map(|vertex| surface.position(*vertex));
    let middle = points().sum::<DVec3>() / line.len().max(1) as f64;
    let radius = points().map(|point| point.distance(middle));
    (middle, radius.fold(0.0, f64::max))
}

/// The same tree from a new root on, which stands before the old one.
fn from_root(found: &mut Centerline, position: Vec3) {
    let old = std::mem::take(&mut found.tree);
    let mut tree = Tree::with_capacity(old.len() + 1);
    tree.letters = old.letters.clone();
    tree.push(Node {
        parent: NO_PARENT,
        position,
        radius: old.radius[0],
        letter: old.letter[0],
        order: old.order[0],
        birth: old.birth[0],
    });
    for node in 0..old.len() {
        tree.push(Node {
            parent: match old.parent[node] {
                NO_PARENT => 0,
                parent => parent + 1,
            },
            position: old.position[node],
            radius: old.radius[node],
            letter: old.letter[node],
            order: old.order[node],
            birth: old.birth[node],
        });
    }
    found.tree = tree;
    for end in found.ends.iter_mut().flatten() {
        *end += 1;
    }
}
