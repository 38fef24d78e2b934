//! Centerlines as lines of the sketch: a branch of a scanned model as a brush, or the whole tree to be edited.
//!
//! A line goes on where the way to the farthest tip does; every other branch is a line of its own that starts there. Longer lines come first, so that
//! what a sketch has no room for is what is shortest. Radii are taken with them; a person can have them follow from what grows instead, as in any sketch.

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::document::Edit;
use crate::sketch::BOUNDS;
use crate::tree::{NO_PARENT, Tree};

/// Height of a whole tree in the sketch, and the least length of a branch, metres.
const WHOLE: f32 = 2.0;
const BRUSH: f32 = 0.5;
/// Nodes of a line are at least so far apart, metres, and all lines together have no more of them than this.
const APART: f32 = 0.02;
const NODES: f32 = 20_000.0;
/// Nearer than this a node is on the one before.
const TINY: f32 = 0.002;

/// A line that is taken into the sketch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TakenLine {
    /// The line that it starts at, by its place in the list, and the node of it from 1; none: at the selected node.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<[u32; 2]>,
    /// Where each segment ends, metres in the sketch's axes.
    pub to: Vec<Vec3>,
    /// The radius there, metres, one for each; none: as thick as what grows makes it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub radii: Vec<f32>,
}

/// Where what is taken goes: turned upright, made so many times as large, and put there.
#[derive(Clone, Copy, Debug)]
struct Map {
    from: Vec3,
    turn: Quat,
    scale: f32,
    to: Vec3,
}

impl Map {
    fn of(&self, place: Vec3) -> Vec3 {
        self.to + self.turn * (place - self.from) * self.scale
    }

    /// Where a node of a tree comes to be, and how thick it is there.
    fn node(&self, tree: &Tree, node: u32) -> Option<(Vec3, f32)> {
        let place = self.of(*tree.position.get(node as usize)?);
        let [least, most] = BOUNDS.radius;
        let radius = tree.radius.get(node as usize)? * self.scale;
        Some((place, radius.clamp(least, most)))
    }
}

/// The longest side of the box around places.
fn side(places: impl Iterator<Item = Vec3> + Clone) -> f32 {
    let low = places.clone().fold(Vec3::INFINITY, Vec3::min);
    let high = places.fold(Vec3::NEG_INFINITY, Vec3::max);
    (high - low).max_element()
}

/// A branch from its first node on, standing at a place of the sketch: as large as the whole tree would be, but large enough to draw with. None where it
/// has no length.
#[must_use]
pub(super) fn branch(tree: &Tree, nodes: &[u32], turn: Quat, to: Vec3) -> Option<Edit> {
    let place = |node: &u32| tree.position.get(*node as usize).copied();
    let first = place(nodes.first()?)?;
    let whole = side(tree.position.iter().copied());
    let own = side(nodes.iter().filter_map(place));
    let scale = (WHOLE / whole).max(BRUSH / own);
    let map = Map {
        from: first,
        turn,
        scale,
        to,
    };
    let mut line = Line::new(to);
    for node in nodes {
        line.push(map.node(tree, *node)?, APART);
    }
    line.end(map.node(tree, *nodes.last()?)?);
    let line = line.taken(None);
    (scale.is_finite() && !line.to.is_empty()).then(|| Edit::TakeLines { lines: vec![line] })
}

/// A whole tree, standing at a place of the sketch, of at most so many lines; how many were left out. None where it has no length.
#[must_use]
pub(super) fn whole(tree: &Tree, turn: Quat, to: Vec3, most: usize) -> Option<(Edit, usize)> {
    let scale = WHOLE / side(tree.position.iter().copied());
    let root = tree.position.first().copied()?;
    if !scale.is_finite() {
        return None;
    }
    let map = Map {
        from: root,
        turn,
        scale,
        to,
    };
    let ways = ways(tree);
    let total: f32 = ways.iter().map(|way| way.length).sum::<f32>() * scale;
    let apart = APART.max(total / NODES);
    let left_out = ways.len().saturating_sub(most);
    let mut lines: Vec<TakenLine> = Vec::new();
    // Of each node of the tree the line that it is on, and the node of that.
    let mut place_of = vec![[u32::MAX, 0]; tree.len()];
    for way in ways.into_iter().take(most) {
        let number = u32::try_from(lines.len()).unwrap_or(u32::MAX);
        let from = way.from.map(|node| place_of[node as usize]);
        let start = match from {
            Some([line, node]) => lines
                .get(line as usize)?
                .to
                .get(node as usize - 1)
                .copied()?,
            None => to,
        };
        let mut line = Line::new(start);
        for node in &way.nodes {
            line.push(
                map.node(tree, *node)?,
                if way.forks.contains(node) {
                    TINY
                } else {
                    apart
                },
            );
            let node_of_line = u32::try_from(line.nodes.len()).unwrap_or(u32::MAX).max(1);
            place_of[*node as usize] = [number, node_of_line];
        }
        line.end(map.node(tree, *way.nodes.last()?)?);
        if line.nodes.is_empty() {
            continue;
        }
        // Lines go on at their last node: what starts there starts one before, where there is one.
        let last = u32::try_from(line.nodes.len()).unwrap_or(u32::MAX);
        for node in &way.nodes {
            let place = &mut place_of[*node as usize];
            place[1] = place[1].min(last.saturating_sub(1)).max(1);
        }
        lines.push(line.taken(from));
    }
    (!lines.is_empty()).then_some((Edit::TakeLines { lines }, left_out))
}

/// A line that is being made.
struct Line {
    last: Vec3,
    nodes: Vec<Vec3>,
    radii: Vec<f32>,
}

impl Line {
    fn new(start: Vec3) -> Self {
        Self {
            last: start,
            nodes: Vec::new(),
            radii: Vec::new(),
        }
    }

    /// Adds a node that is far enough from the last.
    fn push(&mut self, (at, radius): (Vec3, f32), apart: f32) {
        if at.distance(self.last) >= apart {
            self.last = at;
            self.nodes.push(at);
            self.radii.push(radius);
        }
    }

    /// Adds the end, in the place of a node that is next to it.
    fn end(&mut self, (at, radius): (Vec3, f32)) {
        if self.nodes.len() > 1 && at.distance(self.last) < APART / 2.0 {
            self.nodes.pop();
            self.radii.pop();
            self.last = self.nodes.last().copied().unwrap_or(self.last);
        }
        self.push((at, radius), TINY);
    }

    fn taken(self, from: Option<[u32; 2]>) -> TakenLine {
        TakenLine {
            from,
            to: self.nodes,
            radii: self.radii,
        }
    }
}

/// A way through a tree that becomes a line.
struct Way {
    /// The node that it starts at, which is another way's; none for those from a root.
    from: Option<u32>,
    nodes: Vec<u32>,
    /// Nodes of it at which others start.
    forks: Vec<u32>,
    length: f32,
}

/// A tree's ways, the longest first, each behind the one that it starts at.
fn ways(tree: &Tree) -> Vec<Way> {
    let step = |node: usize| {
        let parent = tree.parent[node];
        tree.position[node].distance(tree.position[parent as usize])
    };
    // How far the farthest tip is, and which child leads there: parents stand before their children.
    let mut far = vec![0.0_f32; tree.len()];
    let mut next = vec![NO_PARENT; tree.len()];
    let numbers: Vec<u32> = (0_u32..).take(tree.len()).collect();
    for number in numbers.iter().rev() {
        let node = *number as usize;
        let parent = tree.parent[node];
        if parent == NO_PARENT {
            continue;
        }
        let reach = far[node] + step(node);
        if next[parent as usize] == NO_PARENT || reach >= far[parent as usize] {
            far[parent as usize] = reach;
            next[parent as usize] = *number;
        }
    }
    let mut ways = Vec::new();
    for number in numbers {
        let node = number as usize;
        let parent = tree.parent[node];
        let goes_on = parent != NO_PARENT && next[parent as usize] == number;
        if goes_on {
            continue;
        }
        let length = match parent {
            NO_PARENT => far[node],
            _ => far[node] + step(node),
        };
        let mut nodes = vec![number];
        while next[nodes[nodes.len() - 1] as usize] != NO_PARENT {
            nodes.push(next[nodes[nodes.len() - 1] as usize]);
        }
        ways.push(Way {
            from: (parent != NO_PARENT).then_some(parent),
            nodes,
            forks: Vec::new(),
            length,
        });
    }
    let mut way_of = vec![0; tree.len()];
    for (place, way) in ways.iter().enumerate() {
        way.nodes
            .iter()
            .for_each(|node| way_of[*node as usize] = place);
    }
    for place in 0..ways.len() {
        if let Some(node) = ways[place].from {
            ways[way_of[node as usize]].forks.push(node);
        }
    }
    // Those that start at a way are no longer than what is left of it, and stand behind it where they are as long.
    ways.sort_by(|a, b| b.length.total_cmp(&a.length));
    ways
}

/// Lines that a sketch with so many has room for.
pub(super) fn room(lines: usize) -> usize {
    BOUNDS.strokes.saturating_sub(lines)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::super::document::Document;
    use super::super::lines::tests::tree;
    use super::*;
    use crate::sketch::{Letter, NodeRef};

    /// Where lines end in the sketch.
    fn apexes(document: &Document) -> Vec<Vec3> {
        let strokes = document.sketch.strokes.iter();
        let of = |letter: Letter| {
            let apex = document.sketch.apex(letter).unwrap();
            document.sketch.position(apex).unwrap()
        };
        strokes.map(|stroke| of(stroke.letter)).collect()
    }

    #[test]
    fn a_tree_becomes_a_sketch_with_its_forks_and_tips() {
        let document = Document::default();
        let (edit, left_out) = whole(&tree(), Quat::IDENTITY, Vec3::ZERO, 512).unwrap();
        assert_eq!(left_out, 0);
        let taken = document.after(&edit).unwrap();
        taken.validate().unwrap();
        // A stem of 2 that forks into 1 and 3, and that into 4 and 1: 6 high.
        let expected = [(3.0, 6.0), (-1.0, 2.0), (3.0, 1.0)];
        let expected = expected.map(|(x, y)| Vec3::new(x, y, 0.0) * WHOLE / 6.0);
        let found = apexes(&taken);
        assert_eq!(found.len(), 3);
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.distance(expected) < 1e-3, "{found} {expected}");
        }
        let starts: Vec<NodeRef> = taken.sketch.strokes[1..]
            .iter()
            .map(|stroke| stroke.attachment.unwrap())
            .collect();
        for (at, expected) in starts.iter().zip([(0.0, 2.0), (3.0, 2.0)]) {
            let expected = Vec3::new(expected.0, expected.1, 0.0) * WHOLE / 6.0;
            let found = taken.sketch.position(*at).unwrap();
            assert!(found.distance(expected) < 1e-3, "{found} {expected}");
        }
        assert!(
            taken
                .sketch
                .strokes
                .iter()
                .all(|one| one.self_similar.is_none())
        );
        assert_eq!(
            taken.sketch.self_similar_branches,
            document.sketch.self_similar_branches
        );
        // As thick as the tree is.
        let scale = WHOLE / 6.0;
        let thick = |stroke: usize| taken.sketch.strokes[stroke].radii.clone();
        assert_eq!(thick(0).len(), taken.sketch.strokes[0].points.len());
        let expected = scale * tree().radius[0];
        assert!((thick(0)[0] - expected).abs() < 1e-5, "{:?}", thick(0));
        // What there is no room for is what is shortest.
        let (edit, left_out) = whole(&tree(), Quat::IDENTITY, Vec3::ZERO, 2).unwrap();
        assert_eq!(left_out, 1);
        assert_eq!(document.after(&edit).unwrap().sketch.strokes.len(), 2);
    }

    #[test]
    fn a_branch_becomes_a_line_from_the_selected_node() {
        let up = Edit::AddStroke {
            to: vec![Vec3::Y * 0.5, Vec3::Y],
        };
        let at = NodeRef::new(Letter::TRUNK, 1);
        let document = Document::default().after(&up).unwrap();
        let document = document.after(&Edit::Select { at }).unwrap();
        let from = Vec3::Y * 0.5;
        // The branch of length 4.
        let edit = branch(&tree(), &[4, 5], Quat::IDENTITY, from).unwrap();
        let taken = document.after(&edit).unwrap();
        assert_eq!(taken.sketch.strokes.len(), 2);
        let end = taken.sketch.position(taken.selected).unwrap();
        let expected = from + Vec3::Y * 4.0 * WHOLE / 6.0;
        assert!(end.distance(expected) < 1e-3, "{end}");
        assert_eq!(taken.sketch.strokes[1].attachment, Some(at));
        // A short one is made large enough.
        let edit = branch(&tree(), &[2, 3], Quat::IDENTITY, from).unwrap();
        let taken = document.after(&edit).unwrap();
        let end = taken.sketch.position(taken.selected).unwrap();
        assert!(end.distance(from) > BRUSH - 1e-3, "{end}");
        assert!(branch(&tree(), &[2], Quat::IDENTITY, from).is_none());
        assert!(branch(&tree(), &[], Quat::IDENTITY, from).is_none());
    }

    #[test]
    fn what_names_no_line_before_it_is_refused() {
        let line = |from| TakenLine {
            from,
            to: vec![Vec3::Y],
            radii: Vec::new(),
        };
        for lines in [
            vec![line(Some([0, 1]))],
            vec![line(None), line(Some([1, 1]))],
            vec![line(None), line(Some([0, 7]))],
            vec![],
        ] {
            let edit = Edit::TakeLines { lines };
            assert!(Document::default().after(&edit).is_err(), "{edit:?}");
        }
    }
}
