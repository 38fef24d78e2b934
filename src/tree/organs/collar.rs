//! Collars and the root's flare: wood is thicker where a branch leaves its parent and where the trunk meets the ground.
//!
//! Old wood has knots besides ([`super::knot`]), and barks with round tips end in domes.
//!
//! Only what is drawn and meshed has them; the tree's own radii stay da Vinci's. A branch thickens towards the skin of its parent as
//! exp(−d/0.9 r), d from the skin, by [`Organs::flare`] of its radius r, never beyond its parent; the trunk towards the ground as exp(−d/1.6 r). So a tube
//! is cut near its start at a few places whose distances grow, and joins there without an edge (branch collars: Shigo, *Tree Anatomy*, 1994).

use super::super::axes::axis_children;
use super::super::{NO_PARENT, Tree};
use super::Organs;
use super::knot::{self, Knot};

/// Branches thinner than this part of the thickest wood have no collar that anybody sees, those twice as thick all of it.
const LEAST: f32 = 1.0 / 40.0;
/// A collar dies away over so many radii, and the flare at the root.
const FADE: f32 = 0.9;
const ROOT_FADE: f32 = 1.6;
/// Where a branch's tube is cut, in its radii from its parent's skin, and the trunk's in its own from the ground.
const CUTS: [f32; 4] = [0.0, 0.6, 1.5, 3.0];
const ROOT_CUTS: [f32; 5] = [0.35, 0.8, 1.5, 2.5, 4.2];

/// Wood as thick as this part of the thickest begins to have knots, and half as thick again has them as large as they are.
const KNOTTED: f32 = 0.14;
/// No knots so near to the ground, in radii.
const ROOT_CLEAR: f32 = 4.0;
/// Where a round tip is cut, in its radii from its end. The end itself narrows as all tips do.
const DOME: [f32; 4] = [1.0, 0.6, 0.3, 0.1];
const DOME_END: f32 = 0.7;

/// A place where a tube is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cut {
    /// Part of the segment, from its start, 0 to 1.
    pub(super) at: f32,
    /// Times the radius there.
    times: f32,
    /// And no more than this.
    most: f32,
    /// The segment begins with its end's radius.
    pub(super) is_lateral: bool,
    /// What stands out there.
    pub(super) knot: Option<Knot>,
}

impl Cut {
    pub(super) fn thickened(&self, radius: f32) -> f32 {
        (radius * self.times).min(self.most.max(radius))
    }
}

/// Which segments of a tree have collars.
pub(super) struct Collars<'a> {
    tree: &'a Tree,
    flare: f32,
    /// By node: the child that goes on.
    axis: Vec<u32>,
    /// By node of an axis that begins at a root: metres along it; else infinite.
    above_ground: Vec<f32>,
    least: f32,
    /// Knots in ten radii of old wood.
    often: f32,
    is_round: bool,
    knotted: f32,
}

impl<'a> Collars<'a> {
    pub(super) fn of(tree: &'a Tree, organs: &Organs) -> Option<Self> {
        let is_wood = tree.radius.iter().any(|radius| *radius > 0.0);
        let is_flared = organs.flare > 0.0;
        if !is_flared || tree.segment_count() == 0 || !is_wood {
            return None;
        }
        let axis = axis_children(tree);
        let mut above_ground = vec![f32::INFINITY; tree.len()];
        for (node, &parent) in tree.parent.iter().enumerate() {
            above_ground[node] = match parent {
                NO_PARENT => 0.0,
                parent if axis[parent as usize] as usize == node => {
                    let length = tree.position[node].distance(tree.position[parent as usize]);
                    above_ground[parent as usize] + length
                }
                _ => f32::INFINITY,
            };
        }
        let thickest = tree.radius.iter().copied().fold(0.0, f32::max);
        Some(Self {
            tree,
            flare: organs.flare.min(4.0),
            axis,
            above_ground,
            least: LEAST * thickest,
            often: organs.bark.knots(),
            is_round: organs.bark.is_round_tipped(),
            knotted: KNOTTED * thickest,
        })
    }

    /// How many times thicker the trunk is so far above the ground.
    fn flared(&self, above: f32, radius: f32) -> f32 {
        if radius > 0.0 && above.is_finite() {
            1.0 + 1.6 * self.flare * (-above / (ROOT_FADE * radius)).exp()
        } else {
            1.0
        }
    }

    /// How many times thicker the tube is at a node.
    pub(super) fn at_end(&self, node: usize) -> f32 {
        let is_dome = self.is_round && self.axis[node] == NO_PARENT;
        let narrows = if is_dome { DOME_END } else { 1.0 };
        narrows * self.flared(self.above_ground[node], self.tree.radius[node])
    }

    /// How many nodes the segment that ends at a node has more.
    pub(super) fn nodes(&self, node: usize) -> u64 {
        let of = |cut: &Cut| 1 + cut.knot.map_or(0, |_| knot::NODES);
        self.cuts(node).iter().map(of).sum()
    }

    /// Where a round tip is cut: its radius falls as a sphere's.
    fn dome(&self, radius: f32, length: f32) -> impl Iterator<Item = Cut> {
        let of = move |away: f32| Cut {
            at: 1.0 - away * radius / length,
            times: (1.0 - (1.0 - away).powi(2)).sqrt(),
            most: f32::INFINITY,
            is_lateral: false,
            knot: None,
        };
        let is_on = move |away: &f32| away * radius < 0.95 * length;
        DOME.into_iter().filter(is_on).map(of)
    }

    /// Where old wood is cut for a knot, if it has one: before the swelling, at it and behind it.
    fn knot(&self, node: usize, ends: [glam::Vec3; 2]) -> Vec<Cut> {
        let own = self.tree.radius[node];
        let shown = (2.0 * (own / self.knotted.max(f32::MIN_POSITIVE) - 1.0)).clamp(0.0, 1.0);
        let Some(knot) = Knot::of(ends, own, self.often, shown) else {
            return Vec::new();
        };
        let part = knot.swelling(own) / ends[0].distance(ends[1]);
        let cut = |at: f32, times: f32, knot: Option<Knot>| Cut {
            at,
            times,
            most: f32::INFINITY,
            is_lateral: false,
            knot,
        };
        let cuts = [
            cut(knot.at - part, 1.0, None),
            cut(knot.at, knot::SWELLS, Some(knot)),
            cut(knot.at + part, 1.0, None),
        ];
        let is_within = |cut: &Cut| (0.02..0.98).contains(&cut.at);
        cuts.into_iter().filter(is_within).collect()
    }

    /// Where the segment that ends at a node is cut.
    pub(super) fn cuts(&self, node: usize) -> Vec<Cut> {
        let tree = self.tree;
        let parent = tree.parent[node];
        if parent == NO_PARENT {
            return Vec::new();
        }
        let below = parent as usize;
        let (own, thick) = (tree.radius[node], tree.radius[below]);
        let length = tree.position[node].distance(tree.position[below]);
        let is_long = length > 0.0;
        if !is_long || own < self.least || !own.is_finite() {
            return Vec::new();
        }
        let from_ground = self.above_ground[below];
        let cut = |way: f32, times, most, is_lateral| Cut {
            at: way / length,
            times,
            most,
            is_lateral,
            knot: None,
        };
        let is_tip = self.axis[node] == NO_PARENT;
        if self.axis[below] as usize == node {
            let near = ROOT_CUTS.iter().map(|radii| radii * thick - from_ground);
            let near = near.filter(|way| {
                from_ground.is_finite() && (0.1 * own..length - 0.1 * own).contains(way)
            });
            let of = |way| {
                cut(
                    way,
                    self.flared(from_ground + way, thick),
                    f32::INFINITY,
                    false,
                )
            };
            let mut cuts: Vec<Cut> = near.map(of).collect();
            if is_tip && self.is_round {
                cuts.extend(self.dome(own, length));
                cuts.sort_by(|a, b| a.at.total_cmp(&b.at));
            } else if !is_tip && cuts.is_empty() && from_ground >= ROOT_CLEAR * thick {
                cuts = self.knot(node, [below, node].map(|at| tree.position[at]));
            }
            return cuts;
        }
        // Out of the parent's tube it comes no sooner than after its radius.
        let ways = CUTS.iter().map(|radii| (*radii, 0.9 * thick + radii * own));
        let ways = ways.filter(|(_, way)| *way < 0.95 * length);
        // It comes little by little as the branch grows thick enough.
        let shown = self.flare * (own / self.least.max(f32::MIN_POSITIVE) - 1.0).clamp(0.0, 1.0);
        let of = |(radii, way): (f32, f32)| {
            let times = 1.0 + shown * (-radii / FADE).exp();
            cut(way, times, 0.98 * thick, true)
        };
        ways.map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use glam::Vec3;

    use super::super::{refined, refined_len};
    use super::*;
    use crate::tree::Node;
    use crate::tree::bark::Bark;

    fn branch() -> Tree {
        let mut tree = Tree {
            letters: vec!["F".to_owned()],
            ..Tree::default()
        };
        let nodes = [
            (NO_PARENT, [0.0, 0.0, 0.0], 0.3, 0),
            (0, [0.0, 3.0, 0.0], 0.3, 0),
            (1, [0.0, 5.0, 0.0], 0.25, 0),
            (1, [2.0, 4.0, 0.0], 0.1, 1),
            (1, [-1.0, 4.0, 0.0], 0.002, 1),
        ];
        for (parent, place, radius, order) in nodes {
            tree.push(Node {
                parent,
                position: Vec3::from(place),
                radius,
                letter: 0,
                order,
                birth: 0,
            });
        }
        tree
    }

    #[test]
    fn a_trunk_is_thickest_at_the_ground_and_a_branch_at_its_parent() {
        let tree = branch();
        let organs = Organs {
            flare: 0.5,
            ..Organs::default()
        };
        let fine = refined(&tree, &organs, &[]).unwrap();
        fine.tree.validate().unwrap();
        assert_eq!(fine.tree.len() as u64, refined_len(&tree, &organs));
        // Upwards the trunk only becomes thinner, to what it was.
        let trunk = fine.number[1] as usize;
        let radii: Vec<f32> = (0..=trunk).map(|node| fine.tree.radius[node]).collect();
        assert!(radii.windows(2).all(|pair| pair[0] > pair[1]), "{radii:?}");
        assert!((radii[0] - 0.3 * 1.8).abs() < 1e-5 && radii[trunk] < 0.301);
        // The branch begins thicker, ends as it was, and is nowhere thicker than the trunk; the thin one is left alone.
        let [foot, tip] = [fine.number[2] as usize + 1, fine.number[3] as usize];
        let radii: Vec<f32> = (foot..=tip).map(|node| fine.tree.radius[node]).collect();
        assert!(
            radii.len() > 3 && radii.windows(2).all(|pair| pair[0] > pair[1]),
            "{radii:?}"
        );
        assert!(radii[0] > 0.14 && radii[0] < 0.3 && (radii[radii.len() - 1] - 0.1).abs() < 1e-6);
        assert_eq!(fine.number[4], fine.number[3] + 1);
        // All nodes that there were stand where they stood.
        for (node, number) in fine.number.iter().enumerate() {
            assert_eq!(fine.tree.position[*number as usize], tree.position[node]);
        }
    }

    #[test]
    fn without_flare_there_is_nothing_to_do() {
        assert!(refined(&branch(), &Organs::default(), &[]).is_none());
        let mut tree = branch();
        for radius in tree.radius.iter_mut() {
            *radius = 0.0;
        }
        let organs = Organs {
            flare: 0.5,
            ..Organs::default()
        };
        assert!(refined(&tree, &organs, &[]).is_none());
    }

    /// A bough of so many segments, half a metre each.
    fn bough(segments: u16, radius: f32) -> Tree {
        let mut tree = Tree {
            letters: vec!["F".to_owned()],
            ..Tree::default()
        };
        for k in 0..=segments {
            tree.push(Node {
                parent: k.checked_sub(1).map_or(NO_PARENT, u32::from),
                position: Vec3::new(0.02 * f32::from(k % 3), 0.5 * f32::from(k), 0.0),
                radius,
                letter: 0,
                order: 0,
                birth: 0,
            });
        }
        tree
    }

    fn dressed(bark: Bark, flare: f32) -> Organs {
        Organs {
            flare,
            bark,
            ..Organs::default()
        }
    }

    #[test]
    fn old_wood_has_knots_where_its_bark_says_and_keeps_its_axis() {
        let tree = bough(200, 0.2);
        let knots = |bark: Bark| {
            let fine = refined(&tree, &dressed(bark, 0.5), &[]).unwrap();
            fine.tree.validate().unwrap();
            assert_eq!(
                fine.tree.len() as u64,
                refined_len(&tree, &dressed(bark, 0.5))
            );
            let axis = axis_children(&fine.tree);
            // From the ground to the tip the tube goes on as it was.
            let mut at = 0;
            while axis[at] != NO_PARENT {
                at = axis[at] as usize;
            }
            assert_eq!(fine.tree.position[at], tree.position[200]);
            let stubs = fine.tree.order.iter().filter(|order| **order == 1).count();
            assert_eq!(stubs as u64 % knot::NODES, 0);
            stubs as u64 / knot::NODES
        };
        assert_eq!([Bark::Plain, Bark::Stalk, Bark::Cactus].map(knots), [0; 3]);
        // A fifth and a tenth of the segments, by how often they are.
        assert!(
            (20..=60).contains(&knots(Bark::Oak)),
            "{}",
            knots(Bark::Oak)
        );
        assert!(
            (8..=32).contains(&knots(Bark::Birch)),
            "{}",
            knots(Bark::Birch)
        );
        // What grows on keeps those that there were, and young wood has none.
        let more = refined(&bough(240, 0.2), &dressed(Bark::Oak, 0.5), &[]).unwrap();
        let fine = refined(&tree, &dressed(Bark::Oak, 0.5), &[]).unwrap();
        let stubs = |tree: &Tree| -> Vec<Vec3> {
            let of = (0..tree.len())
                .filter(|node| tree.order[*node] == 1 && tree.position[*node].y < 99.0);
            of.map(|node| tree.position[node]).collect()
        };
        assert_eq!(stubs(&fine.tree), stubs(&more.tree));
        let mut young = tree.clone();
        young
            .radius
            .iter_mut()
            .skip(1)
            .for_each(|radius| *radius = 0.02);
        let fine = refined(&young, &dressed(Bark::Oak, 0.5), &[]).unwrap();
        assert!(fine.tree.order.iter().all(|order| *order == 0));
    }

    #[test]
    fn a_cactus_ends_in_a_dome() {
        let tree = bough(4, 0.2);
        let fine = refined(&tree, &dressed(Bark::Cactus, 0.05), &[]).unwrap();
        fine.tree.validate().unwrap();
        let top = fine.number[4] as usize;
        for node in (0..top).filter(|node| fine.tree.position[*node].y > 1.79) {
            let away = 2.0 - fine.tree.position[node].y;
            let round = (0.04 - (0.2 - away).powi(2)).max(0.0).sqrt();
            assert!(
                (fine.tree.radius[node] - round).abs() < 0.003,
                "{away}: {}",
                fine.tree.radius[node]
            );
        }
        let cuts = (0..top)
            .filter(|node| fine.tree.position[*node].y > 1.75)
            .count();
        assert_eq!(cuts, DOME.len());
        // One whose last segment is shorter than it is thick is cut where it can be.
        let mut short = tree.clone();
        short.position[4] = short.position[3] + Vec3::Y * 0.1;
        let fine = refined(&short, &dressed(Bark::Cactus, 0.05), &[]).unwrap();
        fine.tree.validate().unwrap();
        assert!((0..fine.tree.len()).all(|node| fine.tree.radius[node] > 0.0));
    }
}
