//! Centerlines of a scanned model, found and measured, as they are seen and asked: thin tubes with a sphere at each fork and end, the largest balls
//! within, and numbers for branches and places.
//!
//! The project keeps only that a model shows its centerlines, and by what they are coloured ([`LineLook`]); they are found anew whenever a project is
//! opened, and whenever the model's mends or endpoints change. So nothing that is shown is out of date, undo needs no care, and a project stays small.

mod quantity;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

pub use self::quantity::{Dimension, Quantity};
use super::scene::new_revision;
use crate::centerline::analysis::{Analysis, BranchFacts};
use crate::centerline::{Centerline, Params, Why};
use crate::mesh::Mesh;
use crate::mesh::colour::{Colour, Ramp};
use crate::mesh::display::Display;
use crate::mesh::endpoints::Proposal;
use crate::tree::{NO_PARENT, Tree};

/// Of the balls' own radius, so that a line lies inside whatever it belongs to.
const THIN: f32 = 0.3;
/// Thickest line, in parts of the model's longest side.
const THICKEST: f32 = 0.005;
/// Corners of a ring.
const SIDES: u16 = 6;
/// Most rings of all lines together: what has more nodes is drawn with every n-th of them.
const RINGS_MOST: usize = 60_000;
/// A sphere at a fork or an end is so many times as thick as the line there.
const SPHERE: f32 = 2.0;
/// Most balls that are shown; where there would be more, those between forks are farther apart.
const BALLS_MOST: usize = 600;
/// How far balls between forks are apart, in their radii: they touch.
const BALLS_APART: f32 = 2.0;

/// How a model's centerlines are seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineLook {
    /// By what they are coloured; all have one colour where by nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<Quantity>,
    /// Whether the largest balls within are shown, too.
    #[serde(default, skip_serializing_if = "is_not")]
    pub balls: bool,
    /// Whether lines that begin or end at an open end go on to its middle.
    #[serde(default, skip_serializing_if = "is_not")]
    pub caps: bool,
    /// Parts that are apart by no more than so many thousandths of the model's longest side are bridged; none where it does not say.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bridge: Option<u16>,
}

impl LineLook {
    /// How lines are found that are to be seen like this in a model whose longest side is so long, in its unit.
    #[must_use]
    pub fn params(&self, longest: f32) -> Params {
        Params {
            cap: self.caps,
            bridge: self
                .bridge
                .map(|gap| f64::from(gap) / 1e3 * f64::from(longest)),
            ..Params::default()
        }
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks with a reference"
)]
fn is_not(on: &bool) -> bool {
    !on
}

/// A branch as it runs.
#[derive(Clone, Debug)]
struct Run {
    /// Where its nodes are among all runs' nodes.
    nodes: Range<usize>,
    /// A ball around it: centre and radius.
    around: (Vec3, f32),
}

/// Centerlines in their colours, and what these mean.
#[derive(Clone, Debug)]
pub struct Shading {
    /// By what they are coloured.
    pub by: Option<Quantity>,
    /// What is drawn.
    pub display: Arc<Display>,
    /// Its number for the renderer.
    pub revision: u64,
    /// The numbers at both ends of the scale; none where there are none.
    pub range: Option<[f32; 2]>,
}

/// Centerlines of a model. Places are from the mesh's origin, in the file's unit.
#[derive(Debug)]
pub struct Lines {
    /// As they were found.
    pub centerline: Centerline,
    /// What is told of them.
    pub analysis: Analysis,
    /// The ends that were proposed and taken, where none were set.
    pub proposals: Vec<Proposal>,
    /// Lines and spheres in one colour.
    bare: Display,
    /// Branch and node of each of their vertices.
    vertices: Vec<[u32; 2]>,
    /// The largest balls within, and their number for the renderer.
    pub balls: (Arc<Display>, u64),
    /// Where nodes are.
    places: Vec<Vec3>,
    /// Thickness of the line at each.
    thick: Vec<f32>,
    runs: Vec<Run>,
    /// Nodes of all runs.
    nodes: Vec<u32>,
    /// Where targets are that no way leads to, and where the gaps on their way are.
    unreached: Vec<(Vec3, Option<Vec3>)>,
}

impl Lines {
    /// Prepares what was found of a model to be seen; `None` when somebody asked to stop.
    #[must_use]
    pub fn new(
        centerline: Centerline,
        analysis: Analysis,
        proposals: Vec<Proposal>,
        model: &Display,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let origin = model.mesh.origin;
        let shift = (centerline.origin - origin).as_vec3();
        let tree = &centerline.tree;
        let places: Vec<Vec3> = tree.position.iter().map(|at| *at + shift).collect();
        let most = THICKEST * model.size().max_element();
        let radii = tree.radius.iter();
        let thick = radii.map(|radius| (radius * THIN).min(most)).collect();
        let (runs, nodes) = runs(tree, &analysis.branches, &places);
        let from_origin = |place: glam::DVec3| (place - origin).as_vec3();
        let unreached = centerline.unreached.iter().map(|one| match one.why {
            Why::Gap { near, .. } => (from_origin(one.point), Some(from_origin(near))),
            Why::NoInside => (from_origin(one.point), None),
        });
        let unreached = unreached.collect();
        let mut lines = Self {
            analysis,
            proposals,
            bare: Display::default(),
            vertices: Vec::new(),
            balls: (Arc::default(), new_revision()),
            places,
            thick,
            runs,
            nodes,
            unreached,
            centerline,
        };
        let (mut tubes, vertices) = lines.tubes();
        tubes.origin = origin;
        lines.bare = Display::new(Arc::new(tubes), None, cancel)?;
        lines.vertices = vertices;
        let mut balls = lines.largest_balls();
        balls.origin = origin;
        lines.balls.0 = Arc::new(Display::new(Arc::new(balls), None, cancel)?);
        Some(lines)
    }

    /// How many branches there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.runs.len()
    }

    /// Whether there is no branch.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// The nodes of a branch, from the one it shares with its parent on.
    #[must_use]
    pub fn nodes_of(&self, branch: usize) -> &[u32] {
        let run = self.runs.get(branch).map(|run| run.nodes.clone());
        self.nodes.get(run.unwrap_or(0..0)).unwrap_or_default()
    }

    /// Where a node is, and how thick the line is there.
    pub(super) fn place(&self, node: u32) -> Option<(Vec3, f32)> {
        let node = node as usize;
        Some((*self.places.get(node)?, *self.thick.get(node)?))
    }

    /// A ball around a branch: centre and radius.
    pub(super) fn around(&self, branch: usize) -> Option<(Vec3, f32)> {
        self.runs.get(branch).map(|run| run.around)
    }

    /// Where targets are that no way leads to, and where the gaps on their way are.
    pub(super) fn unreached(&self) -> &[(Vec3, Option<Vec3>)] {
        &self.unreached
    }

    /// The radius of the largest ball at a node.
    #[must_use]
    pub fn radius(&self, node: u32) -> f32 {
        let radii = &self.centerline.tree.radius;
        radii.get(node as usize).copied().unwrap_or_default()
    }

    /// The way from the root to the end of a branch, or on to the tip that is farthest from there: at each node the length up to it and its
    /// radius, and where in this list the branch begins and ends.
    #[must_use]
    pub fn path_through(&self, branch: usize) -> (Vec<[f64; 2]>, Range<usize>) {
        let facts = &self.analysis.branches;
        let mut way = Vec::new();
        let mut at = Some(branch);
        while let Some(one) = at.and_then(|at| facts.get(at)) {
            way.push(one.id);
            // Each stands behind its parent.
            at = one.parent.filter(|parent| *parent < one.id);
        }
        way.reverse();
        way.extend(self.farthest_from(branch));
        let mut path: Vec<[f64; 2]> = Vec::new();
        let mut within = 0..0;
        let mut last: Option<Vec3> = None;
        for one in way {
            let begins = path.len().saturating_sub(1);
            let skipped = usize::from(last.is_some());
            for node in self.nodes_of(one).iter().skip(skipped) {
                let place = self.places.get(*node as usize).copied();
                let place = place.unwrap_or_default();
                let length = path.last().map_or(0.0, |[length, _]| *length);
                let step = last.map_or(0.0, |last| f64::from(last.distance(place)));
                path.push([length + step, self.radius(*node).into()]);
                last = Some(place);
            }
            if one == branch {
                within = begins..path.len();
            }
        }
        (path, within)
    }

    /// The branches beyond a branch that lead to the tip that is farthest along them.
    fn farthest_from(&self, branch: usize) -> Vec<usize> {
        let facts = &self.analysis.branches;
        let mut beyond = vec![0.0; facts.len()];
        let mut next = vec![None; facts.len()];
        for one in facts.iter().rev() {
            let whole = one.length + beyond.get(one.id).copied().unwrap_or(0.0);
            if let Some(parent) = one.parent
                && let (Some(far), Some(next)) = (beyond.get_mut(parent), next.get_mut(parent))
                && whole >= *far
            {
                (*far, *next) = (whole, Some(one.id));
            }
        }
        let follow = |at: &usize| next.get(*at).copied().flatten();
        std::iter::successors(follow(&branch), follow).collect()
    }

    /// All numbers of a quantity: of branches, or of nodes.
    #[must_use]
    pub fn numbers(&self, of: Quantity) -> Vec<f32> {
        if of == Quantity::RadiusHere {
            return self.centerline.tree.radius.to_vec();
        }
        #[expect(clippy::cast_possible_truncation, reason = "colours and bars")]
        let number = |branch: &BranchFacts| of.of(branch) as f32;
        self.analysis.branches.iter().map(number).collect()
    }

    /// Lines and spheres in the colours of a quantity.
    #[must_use]
    pub fn shaded(&self, by: Option<Quantity>) -> Shading {
        let (display, range) = match by {
            None => (self.bare.clone(), None),
            Some(by) => {
                let (colours, range) = colours(&self.numbers(by), by.ramp());
                let place = usize::from(by == Quantity::RadiusHere);
                let vertices = self.vertices.iter();
                let of = vertices.map(|vertex| colours.get(vertex[place] as usize).copied());
                let of = of.map(Option::unwrap_or_default).collect();
                (self.bare.painted(of), range)
            }
        };
        Shading {
            by,
            display: Arc::new(display),
            revision: new_revision(),
            range,
        }
    }

    /// Thin tubes along all branches with spheres at their ends; branch and node of each vertex.
    fn tubes(&self) -> (Mesh, Vec<[u32; 2]>) {
        let mut mesh = Mesh::default();
        let mut vertices = Vec::new();
        let every = self.nodes.len().div_ceil(RINGS_MOST).max(1);
        let sphere = sphere();
        let mut has_sphere = vec![false; self.places.len()];
        for branch in (0_u32..).take(self.runs.len()) {
            let nodes = self.nodes_of(branch as usize);
            let last = nodes.len().saturating_sub(1);
            let rings: Vec<u32> = (0..nodes.len())
                .filter(|at| at % every == 0 || *at == last)
                .filter_map(|at| nodes.get(at).copied())
                .collect();
            self.tube(&rings, &mut mesh);
            let of_ring = |node: &u32| std::iter::repeat_n([branch, *node], SIDES.into());
            vertices.extend(rings.iter().flat_map(of_ring));
            for node in nodes.iter().take(1).chain(nodes.last()) {
                let Some(has) = has_sphere.get_mut(*node as usize) else {
                    continue;
                };
                if !std::mem::replace(has, true)
                    && let Some((place, thick)) = self.place(*node)
                {
                    put(&sphere, place, thick * SPHERE, &mut mesh);
                    let count = sphere.positions.len();
                    vertices.extend(std::iter::repeat_n([branch, *node], count));
                }
            }
        }
        (mesh, vertices)
    }

    /// A tube through nodes, with a frame that turns as little as it can.
    fn tube(&self, nodes: &[u32], mesh: &mut Mesh) {
        let first = u32::try_from(mesh.positions.len()).unwrap_or(u32::MAX);
        let places: Vec<(Vec3, f32)> = nodes.iter().filter_map(|node| self.place(*node)).collect();
        let mut side = None;
        for (at, (place, thick)) in places.iter().enumerate() {
            let neighbour = |at: usize| places.get(at).map_or(*place, |(place, _)| *place);
            let along = neighbour(at + 1) - neighbour(at.saturating_sub(1));
            let along = along.normalize_or(Vec3::Y);
            let kept = |side: Vec3| side.reject_from_normalized(along).try_normalize();
            let across = side.and_then(kept);
            let across = across.unwrap_or_else(|| along.any_orthonormal_vector());
            side = Some(across);
            let third = along.cross(across);
            for corner in 0..SIDES {
                let turn = std::f32::consts::TAU * f32::from(corner) / f32::from(SIDES);
                let out = across * turn.cos() + third * turn.sin();
                mesh.positions.push(*place + out * *thick);
            }
        }
        let sides = u32::from(SIDES);
        for ring in (1_u32..).take(places.len().saturating_sub(1)) {
            let row = first + (ring - 1) * sides;
            for corner in 0..sides {
                let [a, b] = [row + corner, row + (corner + 1) % sides];
                let [c, d] = [a + sides, b + sides];
                mesh.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }

    /// The largest balls at forks and ends, and between them as near to each other as touch, or as there may be.
    fn largest_balls(&self) -> Mesh {
        let mut apart = BALLS_APART;
        let mut balls = self.strung(apart);
        // Those at forks and ends alone cannot become fewer.
        while balls.len() > BALLS_MOST && apart < 1e6 {
            apart *= 2.0;
            balls = self.strung(apart);
        }
        let sphere = sphere();
        let mut mesh = Mesh::default();
        for ball in balls {
            put(&sphere, ball.truncate(), ball.w, &mut mesh);
        }
        mesh
    }

    fn strung(&self, apart: f32) -> Vec<Vec4> {
        let mut has = vec![false; self.places.len()];
        let mut balls = Vec::new();
        for branch in 0..self.runs.len() {
            let nodes = self.nodes_of(branch);
            let ends = [nodes.first(), nodes.last()];
            let (mut left, mut before) = (0.0, None::<Vec3>);
            for node in nodes {
                let Some((place, _)) = self.place(*node) else {
                    continue;
                };
                left -= before.map_or(0.0, |before| before.distance(place));
                before = Some(place);
                let is_end = ends.contains(&Some(node));
                if !(is_end || left <= 0.0) {
                    continue;
                }
                let radius = self.radius(*node);
                left = radius * apart;
                if let Some(has) = has.get_mut(*node as usize)
                    && !std::mem::replace(has, true)
                {
                    balls.push(place.extend(radius));
                }
            }
        }
        balls
    }
}

/// The nodes of each branch, one behind the other.
fn runs(tree: &Tree, branches: &[BranchFacts], places: &[Vec3]) -> (Vec<Run>, Vec<u32>) {
    let mut nodes: Vec<u32> = Vec::new();
    let of = |branch: &BranchFacts| {
        let [first, mut at] = branch.nodes;
        let begins = nodes.len();
        // No branch has more nodes than the tree.
        for _ in 0..tree.len() {
            nodes.push(at);
            let parent = tree.parent.get(at as usize).copied();
            match parent.filter(|parent| at != first && *parent != NO_PARENT) {
                Some(parent) => at = parent,
                None => break,
            }
        }
        let run = begins..nodes.len();
        let own = nodes.get_mut(run.clone()).unwrap_or_default();
        own.reverse();
        let own = || own.iter().filter_map(|node| places.get(*node as usize));
        let low = own().copied().fold(Vec3::INFINITY, Vec3::min);
        let high = own().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        let centre = (low + high) * 0.5;
        let far = own()
            .map(|place| place.distance(centre))
            .fold(0.0, f32::max);
        Run {
            nodes: run,
            around: (centre, far),
        }
    };
    let runs = branches.iter().map(of).collect();
    (runs, nodes)
}

/// The colour of each number, and the numbers at both ends of the scale.
fn colours(numbers: &[f32], ramp: Ramp) -> (Vec<Colour>, Option<[f32; 2]>) {
    let range = range(numbers, ramp);
    let [low, high] = range.unwrap_or_default();
    let width = high - low;
    let part = |number: &f32| match width > 0.0 {
        true => (number - low) / width,
        // All the same: in the middle, where it is a number.
        false => number * 0.0 + 0.5,
    };
    let colours = numbers.iter().map(|number| ramp.colour(part(number)));
    (colours.collect(), range)
}

/// Smallest and largest number; about zero as far up as down.
#[must_use]
pub fn range(numbers: &[f32], ramp: Ramp) -> Option<[f32; 2]> {
    let finite = || numbers.iter().copied().filter(|number| number.is_finite());
    let [low, high] = [
        finite().fold(f32::INFINITY, f32::min),
        finite().fold(f32::NEG_INFINITY, f32::max),
    ];
    if low > high {
        return None;
    }
    Some(match ramp {
        Ramp::Rising => [low, high],
        Ramp::AboutZero => {
            let most = low.abs().max(high.abs());
            [-most, most]
        }
    })
}

/// A sphere of radius 1: an octahedron whose triangles are divided twice into four.
fn sphere() -> Mesh {
    const TIMES: usize = 2;
    let mut positions = vec![
        Vec3::X,
        Vec3::NEG_X,
        Vec3::Y,
        Vec3::NEG_Y,
        Vec3::Z,
        Vec3::NEG_Z,
    ];
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for [a, b, c] in [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]] {
        triangles.push([a, b, c]);
        triangles.push([b, a, 5]);
    }
    for _ in 0..TIMES {
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        // Each edge's middle is made twice; a sphere is seen the same.
        for [a, b, c] in triangles {
            let at = |corner: u32| positions.get(corner as usize).copied();
            let (Some(p), Some(q), Some(r)) = (at(a), at(b), at(c)) else {
                continue;
            };
            let next = u32::try_from(positions.len()).unwrap_or(u32::MAX);
            positions.extend([p + q, q + r, r + p].map(Vec3::normalize_or_zero));
            let [d, e, f] = [next, next + 1, next + 2];
            finer.extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
        }
        triangles = finer;
    }
    Mesh {
        positions,
        triangles,
        ..Mesh::default()
    }
}

fn put(what: &Mesh, at: Vec3, scale: f32, into: &mut Mesh) {
    let first = u32::try_from(into.positions.len()).unwrap_or(u32::MAX);
    let places = what.positions.iter();
    into.positions
        .extend(places.map(|place| at + *place * scale));
    let triangles = what.triangles.iter();
    let moved = triangles.map(|triangle| triangle.map(|corner| corner.saturating_add(first)));
    into.triangles.extend(moved);
}

#[cfg(test)]
pub(crate) mod tests;
