//! Proposals for where a branching shape begins and ends.
//!
//! ```text
//! open ends ─▶ is it the end of a tube, or a hole in a wall? ──────────────────────┐
//! surface ─▶ farthest place ─▶ distances from there ─▶ arms ─▶ tips with one side ─┴▶ ends ─▶ the widest is the source
//! ```
//!
//! The place farthest from any is a tip, and seen from a tip all others are ends of arms ([`super::arms`]); that first tip is looked at as
//! the end of an arm as seen from the farthest of the others. Bumps make arms too; how long an
//! arm must be is measured by the largest balls inside its tip and where it begins. Two things that look like it are none.
//! Where a network of vessels closes to a loop, distances meet from both sides: a piece around such a peak ends in two loops, one around a
//! tip in one. And an arm's peak at an open end is that open end.
//!
//! Tried instead and left: local maxima of the distance alone (each bump is one), sums of distances to all places (short branches near the
//! middle are lost), and skeletons (they are the next room's, and need ends to start from).

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};

use super::arms::{Arm, Arms, arms};
use super::open::{Open, open_ends};
use super::{Endpoint, Kind, Snapped};
use crate::mesh::measure::inscribed_at;
use crate::mesh::report::NONE;
use crate::mesh::surface::Surface;
use crate::mesh::surface::graph::{Field, Graph, field};

/// Parts of the surface below this part of the largest one's area have no ends.
const DEBRIS: f64 = 1e-3;

/// An arm must be longer than so many radii of the largest ball in its tip, and of half the ball where it begins. On the seven models of
/// known ends the shortest true arm has 0.89 and the longest bump 0.12.
const SHORT: f64 = 0.7;

/// The longest arm of a part must be longer than so many radii: from pole to pole a ball has 3.1.
const SHORT_WHOLE: f64 = 4.0;

/// How many radii below a peak it is looked at whether it is a tip: fronts that come from both sides of a tube meet around it within four, half its
/// circumference, and ways along edges are longer than straight ones.
const TIP: f64 = 5.0;

/// How many radii below a peak an open end is that the arm ends in.
const NEAR: f64 = 1.5;

/// Why an end is proposed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// The surface is open there, as a tube that was cut.
    OpenEnd,
    /// A closed arm of the surface ends there.
    Tip,
}

impl Reason {
    /// As a person reads it.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::OpenEnd => "open end",
            Self::Tip => "tip of an arm",
        }
    }
}

/// An end that can be taken or refused.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// The end, with a name.
    pub endpoint: Endpoint,
    /// Why.
    pub reason: Reason,
    /// How far it is along the surface to where its arm meets a longer one; for the longest, to the other end of the whole. Zero where an
    /// open end is not at the end of an arm.
    pub arm: f64,
    /// How many times as long as thick the arm is: the more, the surer.
    pub slenderness: f64,
}

/// An end before it has a name.
struct End {
    place: Vec3,
    snapped: Option<(Vec3, f64)>,
    reason: Reason,
    arm: f64,
    radius: f64,
    slenderness: f64,
}

/// Proposes ends: the source first, then targets with the longest arms first. None when `cancel` was set.
pub fn propose(surface: &Surface, cancel: &AtomicBool) -> Option<Vec<Proposal>> {
    let (graph, areas) = (surface.graph(), surface.vertex_areas());
    let Some(starts) = farthest(surface, graph, &areas, cancel)? else {
        return Some(Vec::new());
    };
    let open = open_ends(surface, &areas, cancel)?;
    let sweep = |starts: &[u32]| Sweep::new(surface, &areas, starts, cancel);
    let first = sweep(&starts)?;
    let peaks: Vec<u32> = first.arms.whole.iter().map(|arm| arm.peak).collect();
    let second = sweep(&peaks)?;
    let mut tips = Tips::new(surface, open);
    first.arms.all().for_each(|arm| tips.add(&first, arm));
    // Where the first distances are counted from is a tip, too, and the peak of an arm as seen from another.
    for part in 0..u32::try_from(peaks.len()).unwrap_or(NONE) {
        let to_start = |arm: &Arm| first.field.distances[arm.peak as usize];
        let of_part = second.arms.all().filter(|arm| second.part(arm) == part);
        let nearest = of_part.min_by(|a, b| to_start(a).total_cmp(&to_start(b)));
        if let Some(arm) = nearest.filter(|arm| to_start(arm) < arm.length) {
            tips.add(&second, arm);
        }
    }
    Some(named(surface, tips.finish()))
}

/// A vertex of each part that is no debris, farthest from some vertex of it.
fn farthest(
    surface: &Surface,
    graph: &Graph,
    areas: &[f64],
    cancel: &AtomicBool,
) -> Option<Option<Vec<u32>>> {
    let mut part = vec![NONE; areas.len()];
    let mut firsts: Vec<(u32, f64)> = Vec::new();
    for vertex in 0..graph.vertices() {
        if part[vertex as usize] != NONE || graph.neighbours(vertex).is_empty() {
            continue;
        }
        let number = u32::try_from(firsts.len()).unwrap_or(NONE);
        let (mut area, mut open) = (0.0, vec![vertex]);
        part[vertex as usize] = number;
        while let Some(at) = open.pop() {
            area += areas[at as usize];
            for other in graph.neighbours(at) {
                if part[*other as usize] == NONE {
                    part[*other as usize] = number;
                    open.push(*other);
                }
            }
        }
        firsts.push((vertex, area));
    }
    let largest = firsts.iter().map(|(_, area)| *area).fold(0.0, f64::max);
    firsts.retain(|(_, area)| *area > DEBRIS * largest);
    if firsts.is_empty() {
        return Some(None);
    }
    let sources: Vec<(u32, u32)> = firsts.iter().map(|(first, _)| *first).zip(0..).collect();
    let found = field(surface, graph, &sources, |_| f64::INFINITY, cancel)?;
    let mut best: Vec<(u32, f64)> = firsts.iter().map(|(first, _)| (*first, 0.0)).collect();
    for (vertex, (distance, source)) in (0_u32..).zip(found.distances.iter().zip(&found.sources)) {
        if let Some(best) = best.get_mut(*source as usize)
            && *distance > best.1
        {
            *best = (vertex, *distance);
        }
    }
    Some(Some(best.into_iter().map(|(vertex, _)| vertex).collect()))
}

/// Distances from a place of each part, and the arms that they make.
struct Sweep<'a> {
    graph: &'a Graph,
    field: Field,
    arms: Arms,
}

impl<'a> Sweep<'a> {
    fn new(
        surface: &'a Surface,
        areas: &[f64],
        starts: &[u32],
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let graph = surface.graph();
        let sources: Vec<(u32, u32)> = starts.iter().copied().zip(0..).collect();
        let field = field(surface, graph, &sources, |_| f64::INFINITY, cancel)?;
        let arms = arms(graph, &field, areas, cancel)?;
        Some(Self { graph, field, arms })
    }

    /// Which of the places an arm is seen from.
    fn part(&self, arm: &Arm) -> u32 {
        self.field.sources[arm.peak as usize]
    }

    /// What hangs together around a peak, down to a depth below it.
    fn piece(&self, arm: &Arm, depth: f64) -> BTreeSet<u32> {
        let height = |vertex: u32| self.field.distances[vertex as usize];
        let level = height(arm.peak) - depth.min(0.9 * arm.length);
        let mut piece = BTreeSet::from([arm.peak]);
        let mut open = vec![arm.peak];
        while let Some(at) = open.pop() {
            for other in self.graph.neighbours(at) {
                if height(*other) >= level && piece.insert(*other) {
                    open.push(*other);
                }
            }
        }
        piece
    }

    /// How many closed lines part a piece from the rest: what hangs together of the vertices just outside it.
    fn lines_around(&self, piece: &BTreeSet<u32>) -> usize {
        let around = piece.iter().flat_map(|one| self.graph.neighbours(*one));
        let mut outside: BTreeSet<u32> =
            around.copied().filter(|one| !piece.contains(one)).collect();
        let mut lines = 0;
        while let Some(first) = outside.pop_first() {
            lines += 1;
            let mut open = vec![first];
            while let Some(at) = open.pop() {
                let others = self.graph.neighbours(at).iter();
                open.extend(others.filter(|other| outside.remove(other)));
            }
        }
        lines
    }
}

/// Ends as they are found.
struct Tips<'a> {
    surface: &'a Surface,
    normals: Vec<DVec3>,
    loop_of_vertex: BTreeMap<u32, usize>,
    /// Open ends of tubes, and the longest arm that ends in each.
    open: Vec<Option<(Open, f64)>>,
    ends: Vec<End>,
}

impl<'a> Tips<'a> {
    fn new(surface: &'a Surface, open: Vec<Option<Open>>) -> Self {
        let loops = surface.open_ends().iter().enumerate();
        Self {
            surface,
            normals: surface.vertex_normals(),
            loop_of_vertex: loops
                .flat_map(|(number, line)| line.iter().map(move |vertex| (*vertex, number)))
                .collect(),
            open: open.into_iter().map(|end| Some((end?, 0.0))).collect(),
            ends: Vec::new(),
        }
    }

    /// Looks at an arm: it is that of an open end, a tip, or nothing.
    fn add(&mut self, sweep: &Sweep, arm: &Arm) {
        let tip = self.tip(arm);
        let radius = tip.as_ref().map_or(0.0, |(tip, _)| tip.radius);
        let radius = radius.max(arm.radius);
        let at_loop = sweep.piece(arm, NEAR * radius).into_iter();
        let mut at_loop = at_loop.filter_map(|vertex| self.loop_of_vertex.get(&vertex));
        let number = at_loop.find(|number| self.open[**number].is_some());
        if let Some((_, longest)) = number.and_then(|number| self.open[*number].as_mut()) {
            *longest = longest.max(arm.length);
        } else if let Some((tip, true)) = tip
            && sweep.lines_around(&sweep.piece(arm, TIP * radius)) <= 1
        {
            self.ends.push(tip);
        }
    }

    /// The end of an arm, and whether the arm is long enough for its thickness and for that of what it stands on. None where it has no inside.
    fn tip(&self, arm: &Arm) -> Option<(End, bool)> {
        let ball = |vertex: u32| inscribed_at(self.surface, vertex, self.normals[vertex as usize]);
        let at_tip = ball(arm.peak)?;
        let radius = f64::from(at_tip.radius);
        let least = match arm.foot {
            Some(foot) => {
                let below = ball(foot).map_or(0.0, |ball| f64::from(ball.radius));
                SHORT * radius.max(below / 2.0)
            }
            None => SHORT_WHOLE * radius,
        };
        let end = End {
            place: self.surface.position(arm.peak).as_vec3(),
            snapped: Some((at_tip.centre, radius)),
            reason: Reason::Tip,
            arm: arm.length,
            radius,
            slenderness: arm.length / arm.radius,
        };
        Some((end, arm.length > least))
    }

    /// All ends, open ones too.
    fn finish(self) -> Vec<End> {
        let open = self.open.into_iter().flatten().map(|(end, arm)| End {
            place: end.centre.as_vec3(),
            snapped: Some((end.centre.as_vec3(), end.radius)),
            reason: Reason::OpenEnd,
            arm,
            radius: end.radius,
            slenderness: arm / end.radius,
        });
        self.ends.into_iter().chain(open).collect()
    }
}

/// Chooses the source and gives names.
fn named(surface: &Surface, mut ends: Vec<End>) -> Vec<Proposal> {
    // The widest open end, else the widest tip; then the longest arms. Places make the order one.
    let first = ends.iter().enumerate().max_by(|(_, a), (_, b)| {
        let open = |end: &End| end.reason == Reason::OpenEnd;
        open(a)
            .cmp(&open(b))
            .then(a.radius.total_cmp(&b.radius))
            .then_with(|| order(b, a))
    });
    if let Some((first, _)) = first {
        ends.swap(0, first);
        ends[1..].sort_by(order);
    }
    let origin = surface.mesh().origin;
    let in_model = |point: Vec3| origin + point.as_dvec3();
    let proposals = ends.into_iter().enumerate().map(|(number, end)| Proposal {
        endpoint: Endpoint {
            point: in_model(end.place),
            name: match number {
                0 => "source".to_owned(),
                _ => format!("target {number}"),
            },
            kind: if number == 0 {
                Kind::Source
            } else {
                Kind::Target
            },
            snapped: end.snapped.map(|(centre, radius)| Snapped {
                centre: in_model(centre),
                radius,
            }),
        },
        reason: end.reason,
        arm: end.arm,
        slenderness: end.slenderness,
    });
    proposals.collect()
}

fn order(one: &End, other: &End) -> std::cmp::Ordering {
    let place = |end: &End| end.place.to_array();
    let [a, b] = [place(one), place(other)];
    let by_place = a.iter().zip(&b).map(|(a, b)| a.total_cmp(b));
    let by_place = by_place.reduce(std::cmp::Ordering::then);
    (other.arm.total_cmp(&one.arm)).then(by_place.unwrap_or(std::cmp::Ordering::Equal))
}
