//! A drawing with fewer segments, as a coarser level of detail: what is short goes, what is nearly straight becomes one.
//!
//! **The bound.** No point of the full tree's wood is farther from the coarser one's than [`Detail::bound`], nor the other way round: `within`, and what a
//! ring of so few corners lacks of its circle. Each of four things takes a fourth of `within` at most: a branch goes that reaches no farther from the node it
//! grows from; a chord stands for the nodes of a branch that are no farther from it; radii, of which a chord's change evenly, are off by no more; and no bend,
//! old or new, thins a tube by more (see [`super::tubes`]) where one tree has it and the other has not, nor does an end lean by more. What continues an axis still does; where the wood
//! is thicker than a fourth, a tip, which narrows to a point, keeps its last segment. What the tree carries stays where it is.

use std::f32::consts::PI;

use glam::Vec3;

use super::axes::axis_children;
use super::foliage::thin;
use super::organs::{Organist, Paint, refined};
use super::tubes::{CAPPED, SHARP_BEND_COSINE, STARTS, segments};
use super::{Drawing, NO_PARENT, Node, Tree};

/// Nodes that one chord stands for at most: what bounds the time.
const CHORD: u32 = 64;

/// How exactly a drawing is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detail {
    /// How far the surface may be off, besides what rings of few corners lack; metres.
    pub within: f32,
    /// Corners of each ring, 3 to 64.
    pub sides: u32,
}

/// Corners of rings, and parts of the tree's size that the surface may be off by, of each level.
const LEVELS: [(u32, f32); Detail::LEVELS as usize] =
    [(8, 0.0), (5, 0.0005), (4, 0.002), (3, 0.008), (3, 0.03)];

impl Detail {
    /// How many levels there are; 0 is the tree as it is.
    pub const LEVELS: u32 = 5;

    /// A level of detail of a tree; levels beyond the last are the last.
    #[must_use]
    pub fn level(tree: &Tree, level: u32) -> Self {
        let (sides, part) = LEVELS[(level as usize).min(LEVELS.len() - 1)];
        Self {
            within: part * size(tree),
            sides,
        }
    }

    /// How far the surface may be off, for tubes no thicker than a radius; metres.
    #[must_use]
    pub fn bound(&self, radius: f32) -> f32 {
        #[allow(clippy::cast_precision_loss, reason = "at most 64")]
        let half_corner = PI / self.sides.max(3) as f32;
        self.within + (radius + self.within / 4.0) * (1.0 - half_corner.cos())
    }

    /// The finest detail whose drawing has no more triangles than a budget, with that drawing.
    ///
    /// # Errors
    /// How many the coarsest has, where not even that is within the budget.
    pub fn of_budget(drawing: &Drawing, triangles: u64) -> Result<(Self, Drawing), u64> {
        let size = size(&drawing.tree);
        let fits = |detail: &Self| {
            let coarse = coarser(drawing, detail.within);
            (triangles_of(&coarse, detail.sides) <= triangles).then_some((*detail, coarse))
        };
        for sides in [8, 6, 5] {
            if let Some(fine) = fits(&Self { within: 0.0, sides }) {
                return Ok(fine);
            }
        }
        let mut best = None;
        // Of the tree's size, as powers of two.
        const COARSEST: f32 = 8.0;
        let (mut fine, mut coarse) = (-20.0_f32, COARSEST);
        for _ in 0..18 {
            let middle = f32::midpoint(fine, coarse);
            let within = size * middle.exp2();
            match fits(&Self { within, sides: 4 }).or_else(|| fits(&Self { within, sides: 3 })) {
                Some(found) => (best, coarse) = (Some(found), middle),
                None => fine = middle,
            }
        }
        best.ok_or_else(|| triangles_of(&coarser(drawing, size * COARSEST.exp2()), 3))
    }
}

/// A tree's size: the diagonal of the box that holds its nodes.
#[must_use]
pub fn size(tree: &Tree) -> f32 {
    // In double precision, where squares of large numbers are none too large.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "a length among single numbers, as they are"
    )]
    tree.bounds().map_or(0.0, |(low, high)| {
        (low.as_dvec3().distance(high.as_dvec3()) as f32).min(f32::MAX)
    })
}

/// Triangles of a drawing whose tubes have so many sides.
#[must_use]
pub fn triangles_of(drawing: &Drawing, sides: u32) -> u64 {
    segments_and_triangles(drawing, sides).1
}

/// Segments that a drawing's branches are drawn as, and triangles of all of it where tubes have so many sides.
#[must_use]
pub fn segments_and_triangles(drawing: &Drawing, sides: u32) -> (usize, u64) {
    let fine = refined(&drawing.tree, &drawing.organs, &[]);
    let tree = fine.as_ref().map_or(&drawing.tree, |fine| &fine.tree);
    let mut records = Vec::new();
    segments(tree, &[], u32::MAX, &mut records);
    let of = |flags: u32| 2 + u64::from(flags & CAPPED != 0) + u64::from(flags & STARTS != 0);
    let tubes: u64 = records.iter().map(|record| of(record.flags)).sum();
    let organist = Organist::new(&drawing.organs);
    let organs = (0..drawing.organs.len()).map(|index| organist.size(index).1 as u64 / 3);
    let triangles = u64::from(sides) * tubes + organs.sum::<u64>();
    (records.len(), triangles)
}

/// The drawing with fewer segments, whose surface is nowhere off by more than `within`, metres; 0 leaves all.
#[must_use]
pub fn coarser(drawing: &Drawing, within: f32) -> Drawing {
    if within.is_nan() || within <= 0.0 || drawing.tree.segment_count() == 0 {
        return drawing.clone();
    }
    let fine = refined(&drawing.tree, &drawing.organs, &[]);
    let tree = fine.as_ref().map_or(&drawing.tree, |fine| &fine.tree);
    let paints = match &fine {
        Some(fine) => &fine.paints,
        None => &drawing.organs.paints,
    };
    let merged = Merged::new(tree, paints, within / 4.0);
    let kept = |node: u32| {
        let number = match &fine {
            Some(fine) => fine.number.get(node as usize).copied(),
            None => Some(node),
        };
        let known = number.and_then(|number| merged.now.get(number as usize).copied());
        known.unwrap_or(NO_PARENT)
    };
    let mut organs = drawing.organs.clone();
    let polygons = organs.polygons.iter_mut().map(|one| &mut one.node);
    let spheres = organs.spheres.iter_mut().map(|one| &mut one.node);
    let placed = organs.placed.iter_mut().map(|one| &mut one.node);
    polygons
        .chain(spheres)
        .chain(placed)
        .for_each(|node| *node = kept(*node));
    thin(&mut organs, within);
    organs.smooth.clear();
    // The finer tree's radii have it.
    organs.flare = 0.0;
    organs.paints = merged.paints;
    Drawing {
        tree: merged.tree,
        organs,
    }
}

/// A tree whose short branches are gone and whose chords are segments.
#[derive(Default)]
struct Merged {
    tree: Tree,
    /// Of each node; empty where there were none.
    paints: Vec<Paint>,
    /// For each node of the full tree its number here, or [`NO_PARENT`].
    now: Vec<u32>,
}

impl Merged {
    fn new(tree: &Tree, paints: &[Paint], within: f32) -> Self {
        let axis = axis_children(tree);
        let stays = staying(tree, &axis, within);
        let bears = bearing(tree, &stays);
        let near = Near {
            tree,
            axis: &axis,
            within,
        };
        let mut merged = Self {
            now: vec![NO_PARENT; tree.len()],
            ..Self::default()
        };
        merged.tree.letters.clone_from(&tree.letters);
        let paint = |node: usize| paints.get(node).copied().unwrap_or_default();
        let looks_alike = |one: usize, other: usize| {
            paint(one) == paint(other) && tree.letter[one] == tree.letter[other]
        };
        let mut chords = vec![Chord::default(); tree.len()];
        for (number, node) in (0..).zip(0..tree.len()).filter(|(_, node)| stays[*node]) {
            let mut made = of(tree, node, NO_PARENT);
            if let Some(parent) = parent_of(tree, node) {
                let chord = match merged.now[parent] {
                    NO_PARENT => chords[parent].on(),
                    _ => Chord::new(tree.parent[node], number),
                };
                chords[node] = chord;
                let begin = merged.now[chord.from as usize];
                let may_pass = |next: u32| {
                    // A tip narrows over its last segment.
                    let narrows =
                        bears[next as usize] == Bears::Nothing && tree.radius[node] > within;
                    chord.passed < CHORD && !narrows && looks_alike(node, next as usize)
                };
                if let Bears::One(next) = bears[node]
                    && may_pass(next)
                    && near.passes(chord, node, next, merged.arrives(begin))
                {
                    continue;
                }
                // The axis goes on in what it went on in.
                let is_axis = axis[chord.from as usize] == chord.first;
                let order = merged.tree.order[begin as usize];
                made.order = order.saturating_add(u16::from(!is_axis));
                made.parent = begin;
            }
            merged.now[node] = merged.tree.push(made);
            if !paints.is_empty() {
                merged.paints.push(paint(node));
            }
        }
        merged
    }

    /// In which direction the segment of a node arrives, if it has one.
    fn arrives(&self, node: u32) -> Option<Vec3> {
        let parent = parent_of(&self.tree, node as usize)?;
        Some(self.tree.position[node as usize] - self.tree.position[parent])
    }
}

/// Which of a node's children stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bears {
    Nothing,
    One(u32),
    Several,
}

/// What stays of each node's children.
fn bearing(tree: &Tree, stays: &[bool]) -> Vec<Bears> {
    let mut bears = vec![Bears::Nothing; tree.len()];
    for (number, node) in (0..).zip(0..tree.len()).filter(|(_, node)| stays[*node]) {
        if let Some(parent) = parent_of(tree, node) {
            bears[parent] = match bears[parent] {
                Bears::Nothing => Bears::One(number),
                Bears::One(_) | Bears::Several => Bears::Several,
            };
        }
    }
    bears
}

fn parent_of(tree: &Tree, node: usize) -> Option<usize> {
    let parent = tree.parent[node];
    (parent != NO_PARENT).then_some(parent as usize)
}

fn of(tree: &Tree, node: usize, parent: u32) -> Node {
    Node {
        parent,
        position: tree.position[node],
        radius: tree.radius[node],
        letter: tree.letter[node],
        order: tree.order[node],
        birth: tree.birth[node],
    }
}

/// Where a chord begins, the first node behind that, and how many nodes it has passed.
#[derive(Clone, Copy, Debug, Default)]
struct Chord {
    from: u32,
    first: u32,
    passed: u32,
}

impl Chord {
    fn new(from: u32, first: u32) -> Self {
        Self {
            from,
            first,
            passed: 0,
        }
    }

    /// One node farther.
    fn on(self) -> Self {
        Self {
            passed: self.passed + 1,
            ..self
        }
    }
}

/// What is near enough.
struct Near<'a> {
    tree: &'a Tree,
    axis: &'a [u32],
    within: f32,
}

impl Near<'_> {
    /// Whether a chord may pass a node on its way to the next; `arrives` is the direction in which the chord before it arrives.
    fn passes(&self, chord: Chord, node: usize, next: u32, arrives: Option<Vec3>) -> bool {
        let Self { tree, axis, within } = *self;
        let (from, next) = (chord.from as usize, next as usize);
        let [start, stop] = [from, next].map(|at| tree.position[at]);
        let is_axis = axis[from] == chord.first;
        let [mut thick, thin] = [from, next].map(|at| tree.radius[at]);
        if !is_axis {
            // As laterals begin.
            thick = thick.min(thin);
        }
        let along = stop - start;
        let step = |at: usize| {
            parent_of(tree, at).map_or(Vec3::ZERO, |before| {
                tree.position[at] - tree.position[before]
            })
        };
        let onward = axis[next];
        let bends = [
            (from, arrives.filter(|_| is_axis), along),
            (node, Some(step(node)), step(next)),
            (
                next,
                (onward != NO_PARENT).then_some(along),
                if onward == NO_PARENT {
                    along
                } else {
                    step(onward as usize)
                },
            ),
        ];
        // Where a tube begins its end is seen, which turns with the chord.
        let begins = !is_axis || arrives.is_none();
        let is_even = bends.iter().all(|(at, into, out)| {
            into.is_none_or(|into| thinned(tree.radius[*at], into, *out) <= within)
        }) && !(begins && leaned(thick, step(chord.first as usize), along) > within);
        let mut at = Some(node);
        let mut between = || {
            at.filter(|at| *at != from)
                .inspect(|now| at = parent_of(tree, *now))
        };
        is_even
            && std::iter::from_fn(&mut between).all(|between| {
                let (off, part) = from_chord(tree.position[between], start, stop);
                let radius = thick + (thin - thick) * part;
                off <= within && (tree.radius[between] - radius).abs() <= within
            })
    }
}

/// By how much a bend thins a tube of some radius, whose ring stands half-way; of a bend at which the tube ends and begins anew, by all of it.
fn thinned(radius: f32, into: Vec3, out: Vec3) -> f32 {
    let cosine = into.normalize_or_zero().dot(out.normalize_or_zero());
    match cosine > SHARP_BEND_COSINE {
        true => radius * (1.0 - f32::midpoint(1.0, cosine).max(0.0).sqrt()),
        false => radius,
    }
}

/// How far the edge of a tube's end is from where it was when the tube leaves in another direction.
fn leaned(radius: f32, before: Vec3, now: Vec3) -> f32 {
    let cosine = before.normalize_or_zero().dot(now.normalize_or_zero());
    radius * (1.0 - cosine.clamp(0.0, 1.0).powi(2)).sqrt()
}

/// How far a point is from a chord, and where along it is nearest, 0 to 1.
fn from_chord(point: Vec3, start: Vec3, stop: Vec3) -> (f32, f32) {
    let along = stop - start;
    let square = along.length_squared();
    let place = match square > 0.0 {
        true => ((point - start).dot(along) / square).clamp(0.0, 1.0),
        false => 0.0,
    };
    (point.distance(start + along * place), place)
}

/// Nodes that stay: those whose branches reach farther, their thickness included, and of axes what keeps tips and laterals as they are.
fn staying(tree: &Tree, axis: &[u32], within: f32) -> Vec<bool> {
    let mut reach = vec![0.0_f32; tree.len()];
    for node in (0..tree.len()).rev() {
        let own = reach[node].max(tree.radius[node]);
        if let Some(parent) = parent_of(tree, node) {
            let from_parent = own + tree.position[node].distance(tree.position[parent]);
            reach[node] = from_parent;
            reach[parent] = reach[parent].max(from_parent);
        }
    }
    let is_axis = |parent: usize, node: usize| axis[parent] as usize == node;
    // Where the next tip would narrow though the tree is thick, or a lateral would be an axis and begin as thick. Of no tree all goes.
    let mut needs_axis: Vec<bool> = (0..tree.len())
        .map(|node| tree.radius[node] > within || tree.parent[node] == NO_PARENT)
        .collect();
    for (node, reach) in reach.iter().enumerate() {
        if let Some(parent) = parent_of(tree, node).filter(|parent| !is_axis(*parent, node)) {
            let is_thinner = tree.radius[parent] - tree.radius[node] > within;
            needs_axis[parent] |= *reach > within && is_thinner;
        }
    }
    let mut stays = vec![false; tree.len()];
    for node in 0..tree.len() {
        stays[node] = parent_of(tree, node).is_none_or(|parent| {
            let goes_on = needs_axis[parent] && is_axis(parent, node);
            stays[parent] && (reach[node] > within || goes_on)
        });
    }
    stays
}

#[cfg(test)]
mod tests;
