//! Generalized cylinders: the segments between `@Gs` and `@Ge` as one smooth tube.
//!
//! The skeleton keeps one segment a drawing module. For the picture and the files a finer tree is made, in which each such segment is cut
//! along a Hermite curve; tubes, rings, growth and files then go their usual way, with frames that turn no more than the curve. The tangent
//! where two segments of a cylinder meet is half-way between their directions (the turtle's headings), at both ends it is the segment's own,
//! its length the segment's: a cubic that never bulges beyond what its headings say. A bend sharper than tubes join is left as it is.

use glam::Vec3;

use super::super::tubes::SHARP_BEND_COSINE;
use super::super::{NO_PARENT, Node, Tree};
use super::collar::Collars;
use super::{Organs, Paint};

/// A piece turns by no more than this, radians.
const TURN: f32 = 0.12;
/// Pieces of one segment.
const MOST_PIECES: u16 = 16;

/// A finer tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Refined {
    /// The tree.
    pub tree: Tree,
    /// Each node's radius one step earlier, where that was given.
    pub radius_before: Vec<f32>,
    /// Each node's colour and material, where there are any.
    pub paints: Vec<Paint>,
    /// For each node of the coarse tree its number in the finer one.
    pub number: Vec<u32>,
}

/// One segment of a cylinder as a curve.
struct Curve {
    from: Vec3,
    to: Vec3,
    /// Tangents, as long as the segment.
    start: Vec3,
    end: Vec3,
    pieces: u16,
}

impl Curve {
    fn at(&self, t: f32) -> Vec3 {
        let (t2, t3) = (t * t, t * t * t);
        self.from * (2.0 * t3 - 3.0 * t2 + 1.0)
            + self.start * (t3 - 2.0 * t2 + t)
            + self.to * (3.0 * t2 - 2.0 * t3)
            + self.end * (t3 - t2)
    }
}

/// What is known of each segment of a cylinder.
struct Cylinders<'a> {
    tree: &'a Tree,
    organs: &'a Organs,
    /// For each entry of `smooth` the direction of the segment that goes on in the same cylinder.
    onward: Vec<Option<Vec3>>,
}

impl<'a> Cylinders<'a> {
    fn new(tree: &'a Tree, organs: &'a Organs) -> Self {
        let mut made = Self {
            tree,
            organs,
            onward: vec![None; organs.smooth.len()],
        };
        for entry in &organs.smooth {
            let below = made.parent(entry.node);
            if let Some(at) = made.entry(below)
                && organs.smooth[at].cylinder == entry.cylinder
                && let Some(direction) = made.direction(entry.node)
                && let Some(slot) = made.onward.get_mut(at)
            {
                *slot = Some(direction);
            }
        }
        made
    }

    fn parent(&self, node: u32) -> u32 {
        self.tree
            .parent
            .get(node as usize)
            .copied()
            .unwrap_or(NO_PARENT)
    }

    fn entry(&self, node: u32) -> Option<usize> {
        let smooth = &self.organs.smooth;
        smooth.binary_search_by_key(&node, |entry| entry.node).ok()
    }

    fn entry_at(&self, node: usize) -> Option<usize> {
        self.entry(u32::try_from(node).ok()?)
    }

    fn direction(&self, node: u32) -> Option<Vec3> {
        let from = self.tree.position.get(self.parent(node) as usize)?;
        let way = *self.tree.position.get(node as usize)? - *from;
        way.try_normalize()
    }

    /// The curve of the segment that ends at a node.
    fn curve(&self, at: usize) -> Option<Curve> {
        let entry = self.organs.smooth.get(at)?;
        let below = self.parent(entry.node);
        let from = *self.tree.position.get(below as usize)?;
        let to = *self.tree.position.get(entry.node as usize)?;
        let along = self.direction(entry.node)?;
        let length = from.distance(to);
        let before = self
            .entry(below)
            .filter(|at| self.organs.smooth[*at].cylinder == entry.cylinder)
            .and_then(|_| self.direction(below));
        let start = tangent(before, Some(along)).unwrap_or(along);
        let onward = self.onward.get(at).copied().flatten();
        let end = tangent(Some(along), onward).unwrap_or(along);
        let turn = along.angle_between(start) + along.angle_between(end);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "0 to 2π in steps of TURN, and `as` saturates"
        )]
        let pieces = ((2.0 * turn / TURN).ceil() as u16).clamp(1, MOST_PIECES);
        Some(Curve {
            from,
            to,
            start: start * length,
            end: end * length,
            pieces,
        })
    }
}

/// The direction half-way between two that meet; `None` where there is only one or the bend is too sharp.
fn tangent(before: Option<Vec3>, after: Option<Vec3>) -> Option<Vec3> {
    let (before, after) = (before?, after?);
    (before.dot(after) > SHARP_BEND_COSINE)
        .then(|| before + after)?
        .try_normalize()
}

/// How many nodes the finer tree has.
#[must_use]
pub fn refined_len(tree: &Tree, organs: &Organs) -> u64 {
    let cylinders = Cylinders::new(tree, organs);
    let more = |at| cylinders.curve(at).map_or(0, |curve| curve.pieces - 1);
    let more: u64 = (0..organs.smooth.len()).map(|at| u64::from(more(at))).sum();
    let collars = Collars::of(tree, organs).map_or(0, |collars| {
        let cut = (0..tree.len()).filter(|node| cylinders.entry_at(*node).is_none());
        cut.map(|node| collars.nodes(node)).sum()
    });
    tree.len() as u64 + more + collars
}

/// The finer tree of a valid tree with valid organs; `None` where there is neither a cylinder that bends nor a branch with a collar, or where the finer one would
/// have more nodes than 32-bit indices count.
#[must_use]
pub fn refined(tree: &Tree, organs: &Organs, radius_before: &[f32]) -> Option<Refined> {
    let collars = Collars::of(tree, organs);
    if organs.smooth.is_empty() && collars.is_none() {
        return None;
    }
    let nodes = usize::try_from(refined_len(tree, organs)).ok()?;
    let same = nodes == tree.len() && collars.is_none();
    if same || nodes >= NO_PARENT as usize {
        return None;
    }
    let cylinders = Cylinders::new(tree, organs);
    let mut fine = Refined {
        tree: Tree::with_capacity(nodes),
        number: Vec::with_capacity(tree.len()),
        ..Refined::default()
    };
    fine.tree.letters.clone_from(&tree.letters);
    let mut entries = organs.smooth.iter().enumerate().peekable();
    for (node, &parent) in tree.parent.iter().enumerate() {
        let entry = entries.next_if(|(_, entry)| entry.node as usize == node);
        let under = fine
            .number
            .get(parent as usize)
            .copied()
            .unwrap_or(NO_PARENT);
        let old = Old {
            tree,
            radius_before,
            node,
            paint: organs.paint(node),
        };
        let curve = entry.and_then(|(at, _)| cylinders.curve(at));
        let begins = entry.is_some_and(|(_, entry)| entry.cylinder as usize == node);
        let number = match curve.filter(|curve| curve.pieces > 1) {
            Some(curve) => fine.add_curve(&old, &curve, under, begins),
            None => fine.add_straight(&old, under, collars.as_ref().filter(|_| entry.is_none())),
        };
        fine.number.push(number);
    }
    Some(fine)
}

/// A node of the coarse tree.
struct Old<'a> {
    tree: &'a Tree,
    radius_before: &'a [f32],
    node: usize,
    paint: Paint,
}

impl Old<'_> {
    fn position(&self) -> Vec3 {
        self.tree.position[self.node]
    }

    /// Now and one step earlier.
    fn radii_of(&self, node: usize) -> [f32; 2] {
        let now = self.tree.radius[node];
        [now, self.radius_before.get(node).copied().unwrap_or(now)]
    }

    fn radii(&self) -> [f32; 2] {
        self.radii_of(self.node)
    }
}

impl Refined {
    fn add(&mut self, old: &Old<'_>, parent: u32, position: Vec3, radii: [f32; 2]) -> u32 {
        let number = self.tree.push(Node {
            parent,
            position,
            radius: radii[0],
            letter: old.tree.letter[old.node],
            order: old.tree.order[old.node],
            birth: old.tree.birth[old.node],
        });
        if !old.radius_before.is_empty() {
            self.radius_before.push(radii[1]);
        }
        if old.paint != Paint::default() {
            self.paints.resize(number as usize, Paint::default());
            self.paints.push(old.paint);
        }
        number
    }

    /// The segment that ends at a node, cut where a collar or the root's flare is on it.
    fn add_straight(
        &mut self,
        old: &Old<'_>,
        mut under: u32,
        collars: Option<&Collars<'_>>,
    ) -> u32 {
        let (end, radii) = (old.position(), old.radii());
        let Some(collars) = collars else {
            return self.add(old, under, end, radii);
        };
        if let Some(from) = old
            .tree
            .parent
            .get(old.node)
            .filter(|parent| **parent != NO_PARENT)
        {
            let (start, below) = (
                old.tree.position[*from as usize],
                old.radii_of(*from as usize),
            );
            for cut in collars.cuts(old.node) {
                let thin = if cut.is_lateral {
                    radii
                } else {
                    [0, 1].map(|i| below[i] + (radii[i] - below[i]) * cut.at)
                };
                let thick = thin.map(|radius| cut.thickened(radius));
                let place = start.lerp(end, cut.at);
                under = self.add(old, under, place, thick);
                if let Some(knot) = cut.knot {
                    let along = (end - start).normalize_or_zero();
                    let now = knot.stub(place, along, thin[0]);
                    let before = knot.stub(place, along, thin[1]);
                    let mut stub = under;
                    for ((place, radius), (_, before)) in now.into_iter().zip(before) {
                        stub = self.add(old, stub, place, [radius, before]);
                        self.tree.order[stub as usize] = old.tree.order[old.node].saturating_add(1);
                    }
                }
            }
        }
        let thicker = collars.at_end(old.node);
        self.add(old, under, end, radii.map(|radius| radius * thicker))
    }

    fn add_curve(&mut self, old: &Old<'_>, curve: &Curve, mut under: u32, begins: bool) -> u32 {
        let end = old.radii();
        // A cylinder that begins on a thicker stem is no thicker for it.
        let start = match old.tree.parent[old.node] {
            NO_PARENT => end,
            parent => {
                let below = old.radii_of(parent as usize);
                [0, 1].map(|i| {
                    if begins {
                        below[i].min(end[i])
                    } else {
                        below[i]
                    }
                })
            }
        };
        for piece in 1..=curve.pieces {
            let t = f32::from(piece) / f32::from(curve.pieces);
            let radii = [0, 1].map(|i| start[i] + (end[i] - start[i]) * t);
            let (at, radii) = if piece == curve.pieces {
                (old.position(), end)
            } else {
                (curve.at(t), radii)
            };
            under = self.add(old, under, at, radii);
        }
        under
    }
}
