//! Proposals for where a branching shape begins and ends.
//!
//! ```text
//! open ends ─▶ is it the end of a tube, or a hole in a wall? ──────────────────────┐
//! surface ─▶ farthest place ─▶ distances from there ─▶ arms ─▶ tips with one side ─┴▶ ends ─▶ the widest is the source
//! ```
//!
//! The place farthest from any is a tip, and seen from a tip all others are ends of arms ([`super::arms`]). Two things that look like it are none.
//! Where a network of vessels closes to a loop, distances meet from both sides: a piece around such a peak ends in two loops, one around a
//! tip in one. And an arm's peak at an open end is that open end.
//!
//! An open end is the end of a tube if the surface within one radius of it has the area of a tube (2π r²) and not that of a plate around a hole
//! (3π r²). Tried instead and left: local maxima of the distance alone (each bump is one), sums of distances to all places (short branches near the
//! middle are lost), and skeletons (they are the next room's, and need ends to start from).

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::{PI, TAU};
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};

use super::arms::{Arm, arms};
use super::{Endpoint, Kind, Snapped};
use crate::mesh::measure::inscribed;
use crate::mesh::report::NONE;
use crate::mesh::surface::Surface;
use crate::mesh::surface::graph::{Field, Graph, field};

/// Parts of the surface below this part of the largest one's area have no ends.
const DEBRIS: f64 = 1e-3;

/// Area within one radius of an open end, in π · radius², above which it is a hole in a wall: tubes have 2, plates 3.
const PLATE: f64 = 2.6;

/// How many radii below a peak it is looked at whether it is a tip.
const TIP: f64 = 3.0;

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
    /// How thick it is, by the area around it, which is less rough than a ball: what the source is chosen by.
    radius: f64,
}

/// Proposes ends: the source first, then targets with the longest arms first. None when `cancel` was set.
pub fn propose(surface: &Surface, cancel: &AtomicBool) -> Option<Vec<Proposal>> {
    let (graph, areas) = (surface.graph(), surface.vertex_areas());
    let Some(start) = farthest(surface, graph, &areas, cancel)? else {
        return Some(Vec::new());
    };
    let sources: Vec<(u32, u32)> = start.iter().copied().zip(0..).collect();
    let from_tips = field(surface, graph, &sources, |_| f64::INFINITY, cancel)?;
    let shape = Shape {
        surface,
        graph,
        field: &from_tips,
    };
    let open = shape.open_ends(&areas, cancel)?;
    Some(named(surface, shape.ends(&start, &areas, open)))
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

/// An open end that a tube has.
struct Open {
    centre: DVec3,
    radius: f64,
}

struct Shape<'a> {
    surface: &'a Surface,
    graph: &'a Graph,
    field: &'a Field,
}

impl Shape<'_> {
    /// The open ends; None for holes in walls.
    fn open_ends(&self, areas: &[f64], cancel: &AtomicBool) -> Option<Vec<Option<Open>>> {
        let loops = self.surface.open_ends();
        let ends: Vec<Open> = loops.iter().map(|line| self.measured(line)).collect();
        let sources: Vec<(u32, u32)> = (0_u32..)
            .zip(loops)
            .flat_map(|(number, line)| line.iter().map(move |vertex| (*vertex, number)))
            .collect();
        let radius = |number: u32| ends.get(number as usize).map_or(0.0, |end| end.radius);
        let near = field(self.surface, self.graph, &sources, radius, cancel)?;
        let mut around = vec![0.0; ends.len()];
        for (area, source) in areas.iter().zip(&near.sources) {
            if let Some(sum) = around.get_mut(*source as usize) {
                *sum += area;
            }
        }
        let ends = ends.into_iter().zip(around);
        Some(
            ends.map(|(end, area)| {
                let is_tube = area < PLATE * PI * end.radius * end.radius;
                (is_tube && self.is_of_interest(&end)).then_some(end)
            })
            .collect(),
        )
    }

    fn is_of_interest(&self, end: &Open) -> bool {
        end.radius > 0.0 && end.centre.is_finite()
    }

    /// Centre and radius of a loop, by its length.
    fn measured(&self, line: &[u32]) -> Open {
        let (mut length, mut moment) = (0.0, DVec3::ZERO);
        for (from, to) in line.iter().zip(line.iter().cycle().skip(1)) {
            let (from, to) = (self.surface.position(*from), self.surface.position(*to));
            length += from.distance(to);
            moment += from.distance(to) * from.midpoint(to);
        }
        Open {
            centre: moment / length,
            radius: length / TAU,
        }
    }

    fn ends(&self, start: &[u32], areas: &[f64], open: Vec<Option<Open>>) -> Vec<End> {
        let found = arms(self.graph, self.field, areas);
        let loop_of_vertex: BTreeMap<u32, usize> = self
            .surface
            .open_ends()
            .iter()
            .enumerate()
            .flat_map(|(number, line)| line.iter().map(move |vertex| (*vertex, number)))
            .collect();
        // Where distances are counted from, each whole part has an end too, as long and thick as the other.
        let from = found.whole.iter().map(|arm| Arm {
            peak: start[self.field.sources[arm.peak as usize] as usize],
            ..*arm
        });
        let mut arm_of_loop = vec![0.0; open.len()];
        let mut ends = Vec::new();
        let normals = self.surface.vertex_normals();
        for (arm, upwards) in found
            .side
            .iter()
            .chain(&found.whole)
            .map(|arm| (*arm, true))
            .chain(from.map(|arm| (arm, false)))
        {
            let piece = self.piece(&arm, upwards);
            let here = piece.iter();
            let at_loop = here.filter_map(|vertex| loop_of_vertex.get(vertex));
            if let Some(number) = at_loop.filter(|number| open[**number].is_some()).min() {
                arm_of_loop[*number] = f64::max(arm_of_loop[*number], arm.length);
            } else if self.lines_around(&piece) <= 1 {
                let area: f64 = piece.iter().map(|vertex| areas[*vertex as usize]).sum();
                ends.push(self.tip(&arm, area / (TAU * deep(&arm)), normals[arm.peak as usize]));
            }
        }
        let loops = open.into_iter().zip(arm_of_loop);
        ends.extend(loops.filter_map(|(end, arm)| {
            let end = end?;
            Some(End {
                place: end.centre.as_vec3(),
                snapped: Some((end.centre.as_vec3(), end.radius)),
                reason: Reason::OpenEnd,
                arm,
                radius: end.radius,
            })
        }));
        ends
    }

    fn tip(&self, arm: &Arm, radius: f64, normal: DVec3) -> End {
        let place = self.surface.position(arm.peak).as_vec3();
        let ball = inscribed(self.surface.picker(), place, normal.as_vec3());
        let snapped = ball.map(|ball| (ball.centre, f64::from(ball.radius)));
        End {
            place,
            radius,
            snapped,
            reason: Reason::Tip,
            arm: arm.length,
        }
    }

    /// What hangs together around a peak, down to some radii below it.
    fn piece(&self, arm: &Arm, upwards: bool) -> BTreeSet<u32> {
        let height = |vertex: u32| {
            let distance = self.field.distances[vertex as usize];
            if upwards { distance } else { -distance }
        };
        let level = height(arm.peak) - deep(arm);
        let mut vertices = BTreeSet::from([arm.peak]);
        let mut open = vec![arm.peak];
        while let Some(at) = open.pop() {
            for other in self.graph.neighbours(at) {
                if height(*other) >= level && vertices.insert(*other) {
                    open.push(*other);
                }
            }
        }
        vertices
    }

    /// How many closed lines part a piece from the rest: what hangs together of the vertices just outside it.
    fn lines_around(&self, piece: &BTreeSet<u32>) -> usize {
        let around = piece
            .iter()
            .flat_map(|vertex| self.graph.neighbours(*vertex));
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

/// How far below a peak it is looked at.
fn deep(arm: &Arm) -> f64 {
    (TIP * arm.radius).min(0.9 * arm.length)
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
        slenderness: end.arm / end.radius,
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
