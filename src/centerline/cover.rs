//! Balls that cover the wall, and which are next to each other.
//!
//! From each vertex that no ball has yet, the largest ball inside that touches it; what else of the wall that ball all but touches, as far
//! as it hangs together, is its. Two balls are linked where they have a vertex in common or an edge of the wall leads from the one's to
//! the other's. A tube of any number of triangles becomes a chain of some four balls to a radius, a sheet a net, and what hangs together
//! as a surface hangs together as balls, however thin a neck is. Centres are on the medial structure (the poles of Amenta, Choi and
//! Kolluri 2001), so ways from ball to ball run in the middle.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use hashbrown::HashMap;
use rayon::prelude::*;

use super::refine::refined;
use super::skin::{Ball, Skin};
use super::solids::{Solids, surface_of};
use crate::mesh::pick::Winding;
use crate::mesh::report::NONE;

/// How much farther than the ball, in radii, the wall is still its: so much that balls on a tube are a quarter of a radius apart.
const SLACK: f64 = 0.03;

/// How far out of a neighbour, in its radii, a ball may stick that is none of its own.
const BUMP: f64 = 0.1;

/// Balls of parts that were apart are linked where they overlap by this part of the smaller one's radius.
const OVERLAP: f64 = 0.5;

/// Vertices between two looks at whether to stop.
const STEPS: u32 = 1 << 8;

/// Balls and their links.
#[derive(Clone, Debug, Default)]
pub(super) struct Cover {
    pub(super) balls: Vec<Ball>,
    /// The first ball of each vertex, part after part, [`NONE`] where it has none.
    of_vertex: Vec<u32>,
    /// Where each part's vertices begin there.
    firsts: Vec<usize>,
    /// Balls next to each ball, sorted.
    pub(super) links: Vec<Vec<u32>>,
}

impl Cover {
    /// The balls of all solids; those whose middles are not inside are none where that is `unsure`. Skins of few sides and rings are made finer.
    /// None when `cancel` was set.
    pub(super) fn new<'a>(
        skins: Vec<Skin<'a>>,
        unsure: bool,
        cancel: &AtomicBool,
    ) -> Option<(Vec<Skin<'a>>, Self)> {
        let of_skin = |skin: Skin<'a>| {
            let mut known = HashMap::new();
            let cover = Self::of_skin(&skin, &mut known, unsure, cancel)?;
            let Some(mesh) = refined(&skin, cover.radii()) else {
                return Some((skin, cover));
            };
            let skin = Skin::new(Cow::Owned(surface_of(mesh, cancel)?), skin.part);
            let cover = Self::of_skin(&skin, &mut known, unsure, cancel)?;
            Some((skin, cover))
        };
        let parts: Option<Vec<(Skin<'a>, Self)>> = skins.into_par_iter().map(of_skin).collect();
        let mut cover = Self::default();
        let mut skins = Vec::new();
        for (skin, part) in parts? {
            skins.push(skin);
            cover.append(part);
        }
        Some((skins, cover))
    }

    /// The radius of the ball at each vertex, zero where there is none.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "the mesh is in single precision"
    )]
    fn radii(&self) -> Vec<f32> {
        let radius = |ball: &u32| {
            self.balls
                .get(*ball as usize)
                .map_or(0.0, |ball| ball.radius as f32)
        };
        self.of_vertex.iter().map(radius).collect()
    }

    /// Adds the balls of the next part.
    fn append(&mut self, part: Self) {
        let first = u32::try_from(self.balls.len()).unwrap_or(NONE);
        let of = |ball: u32| if ball == NONE { NONE } else { first + ball };
        self.firsts.push(self.of_vertex.len());
        self.of_vertex.extend(part.of_vertex.into_iter().map(of));
        self.balls.extend(part.balls);
        let links = part.links.into_iter();
        self.links
            .extend(links.map(|links| links.into_iter().map(of).collect()));
    }

    /// The ball of a part's vertex.
    pub(super) fn ball_of(&self, part: u32, vertex: u32) -> Option<u32> {
        let first = *self.firsts.get(part as usize)?;
        let ball = *self.of_vertex.get(first + vertex as usize)?;
        (ball != NONE).then_some(ball)
    }

    /// The balls of a solid. Those at vertices that are `known` are not looked for again, and those that are found go there.
    fn of_skin(
        skin: &Skin<'_>,
        known: &mut HashMap<u32, Ball>,
        unsure: bool,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let winding = unsure.then(|| Winding::new(skin.surface.picker()));
        let is_inside = |ball: &Ball| {
            let winding = winding.as_ref();
            winding.is_none_or(|winding| winding.is_inside(ball.centre))
        };
        let graph = skin.surface.graph();
        let mut cover = Self {
            of_vertex: vec![NONE; skin.normals.len()],
            ..Self::default()
        };
        let mut seen = vec![NONE; skin.normals.len()];
        for vertex in 0..graph.vertices() {
            if vertex.is_multiple_of(STEPS) && cancel.load(Ordering::Relaxed) {
                return None;
            }
            if cover.of_vertex[vertex as usize] == NONE
                && !graph.neighbours(vertex).is_empty()
                && let Some(ball) = known
                    .get(&vertex)
                    .copied()
                    .or_else(|| skin.ball_at(vertex).filter(is_inside))
            {
                known.insert(vertex, ball);
                cover.add(skin, vertex, ball, &mut seen);
            }
        }
        cover.fill(skin);
        cover.link_across_edges(skin);
        Some(cover.without_bumps())
    }

    /// Adds a ball and gives it what it touches, from a vertex on.
    fn add(&mut self, skin: &Skin<'_>, vertex: u32, ball: Ball, seen: &mut [u32]) {
        let number = self.push(ball);
        let reach = ball.radius * (1.0 + SLACK);
        self.of_vertex[vertex as usize] = number;
        seen[vertex as usize] = number;
        let mut open = vec![vertex];
        while let Some(at) = open.pop() {
            for next in skin.surface.graph().neighbours(at) {
                let place = *next as usize;
                if seen[place] == number {
                    continue;
                }
                let from_centre = skin.surface.position(*next) - ball.centre;
                let is_touched = from_centre.length() * skin.leans[place] <= reach
                    && from_centre.dot(skin.normals[place]) > 0.0;
                if !is_touched {
                    continue;
                }
                seen[place] = number;
                open.push(*next);
                match self.of_vertex[place] {
                    NONE => self.of_vertex[place] = number,
                    other => self.links[number as usize].push(other),
                }
            }
        }
    }

    /// Gives vertices without a ball that of the nearest that has one, so that what hangs together as a surface does as balls.
    fn fill(&mut self, skin: &Skin<'_>) {
        let graph = skin.surface.graph();
        let with_ball = (0..graph.vertices()).filter(|one| self.of_vertex[*one as usize] != NONE);
        let mut open: VecDeque<u32> = with_ball.collect();
        while let Some(at) = open.pop_front() {
            for next in graph.neighbours(at) {
                if self.of_vertex[*next as usize] == NONE {
                    self.of_vertex[*next as usize] = self.of_vertex[at as usize];
                    open.push_back(*next);
                }
            }
        }
    }

    /// Adds a ball without links.
    pub(super) fn push(&mut self, ball: Ball) -> u32 {
        let number = u32::try_from(self.balls.len()).unwrap_or(NONE);
        self.balls.push(ball);
        self.links.push(Vec::new());
        number
    }

    /// Links two balls.
    pub(super) fn link(&mut self, one: u32, other: u32) {
        for (from, to) in [(one, other), (other, one)] {
            let links = &mut self.links[from as usize];
            if let Err(place) = links.binary_search(&to) {
                links.insert(place, to);
            }
        }
    }

    /// Balls that lie within a neighbour, but for a little, are of bumps, folds and slivers: the neighbour takes their place.
    fn without_bumps(self) -> Self {
        let count = self.balls.len();
        let mut order: Vec<u32> = (0_u32..).take(count).collect();
        let radius = |ball: &u32| self.balls[*ball as usize].radius;
        order.sort_by(|a, b| radius(b).total_cmp(&radius(a)).then(a.cmp(b)));
        // Larger balls first, so that who takes a ball's place stays.
        let mut place: Vec<u32> = (0_u32..).take(count).collect();
        for one in &order {
            let ball = self.balls[*one as usize];
            let holds = |other: &&u32| {
                let there = self.balls[**other as usize];
                (there.radius > ball.radius || there.radius == ball.radius && *other < one)
                    && there.centre.distance(ball.centre) + ball.radius
                        <= (1.0 + BUMP) * there.radius
            };
            let largest = self.links[*one as usize]
                .iter()
                .filter(holds)
                .max_by(|a, b| radius(a).total_cmp(&radius(b)).then(b.cmp(a)));
            if let Some(larger) = largest {
                place[*one as usize] = place[*larger as usize];
            }
        }
        let mut number = vec![NONE; count];
        let mut cover = Self::default();
        for one in (0_u32..)
            .take(count)
            .filter(|one| place[*one as usize] == *one)
        {
            number[one as usize] = cover.push(self.balls[one as usize]);
        }
        let of = |ball: u32| {
            if ball == NONE {
                NONE
            } else {
                number[place[ball as usize] as usize]
            }
        };
        for (one, links) in (0_u32..).zip(&self.links) {
            let others = links
                .iter()
                .map(|other| of(*other))
                .filter(|other| *other != of(one));
            cover.links[of(one) as usize].extend(others);
        }
        for links in &mut cover.links {
            links.sort_unstable();
            links.dedup();
        }
        cover.of_vertex = self.of_vertex.iter().map(|ball| of(*ball)).collect();
        cover
    }

    /// The set of balls that hang together which each ball is in, by its first ball.
    pub(super) fn sets(&self) -> Vec<u32> {
        let mut sets = vec![NONE; self.balls.len()];
        let mut open = Vec::new();
        for first in (0_u32..).take(self.balls.len()) {
            if sets[first as usize] != NONE {
                continue;
            }
            sets[first as usize] = first;
            open.push(first);
            while let Some(at) = open.pop() {
                for next in &self.links[at as usize] {
                    if sets[*next as usize] == NONE {
                        sets[*next as usize] = first;
                        open.push(*next);
                    }
                }
            }
        }
        sets
    }

    /// Links balls that do not hang together where `near` says so of their distance, surface to surface, and the smaller radius; it must not
    /// for distances above `most`. None when `cancel` was set.
    pub(super) fn bridge(
        &mut self,
        most: f64,
        near: impl Fn(f64, f64) -> bool,
        cancel: &AtomicBool,
    ) -> Option<()> {
        let sets = self.sets();
        if sets.iter().all(|set| *set == 0) {
            return Some(());
        }
        let axis = self.longest_axis();
        let first = |ball: &Ball| ball.centre[axis] - ball.radius;
        let mut order: Vec<u32> = (0_u32..).take(self.balls.len()).collect();
        order.sort_by(|a, b| {
            let [one, other] = [a, b].map(|ball| first(&self.balls[*ball as usize]));
            one.total_cmp(&other).then(a.cmp(b))
        });
        let mut bridges = Vec::new();
        for (place, one) in order.iter().enumerate() {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let ball = self.balls[*one as usize];
            let last = ball.centre[axis] + ball.radius + most;
            for other in &order[place + 1..] {
                let there = self.balls[*other as usize];
                if first(&there) > last {
                    break;
                }
                let gap = ball.centre.distance(there.centre) - ball.radius - there.radius;
                if sets[*one as usize] != sets[*other as usize]
                    && near(gap, ball.radius.min(there.radius))
                {
                    bridges.push((*one, *other));
                }
            }
        }
        bridges
            .into_iter()
            .for_each(|(one, other)| self.link(one, other));
        Some(())
    }

    /// The axis along which balls are spread most.
    fn longest_axis(&self) -> usize {
        let centres = || self.balls.iter().map(|ball| ball.centre);
        let size = centres().fold(DVec3::NEG_INFINITY, DVec3::max)
            - centres().fold(DVec3::INFINITY, DVec3::min);
        let most = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b]).then(b.cmp(a)));
        most.unwrap_or(0)
    }

    /// Links what overlaps: balls of parts that lie in each other, and those at walls that pass through each other. None when `cancel` was set.
    pub(super) fn join(&mut self, solids: &Solids<'_>, cancel: &AtomicBool) -> Option<()> {
        let crossings = solids.crossings(cancel)?;
        self.bridge(0.0, |gap, radius| gap < -OVERLAP * radius, cancel)?;
        for pair in crossings {
            if let [Some(one), Some(other)] = pair.map(|(part, vertex)| self.ball_of(part, vertex))
            {
                self.link(one, other);
            }
        }
        Some(())
    }

    fn link_across_edges(&mut self, skin: &Skin<'_>) {
        let graph = skin.surface.graph();
        for vertex in 0..graph.vertices() {
            let one = self.of_vertex[vertex as usize];
            for next in graph.neighbours(vertex) {
                let other = self.of_vertex[*next as usize];
                if one != NONE && other != NONE && one != other {
                    self.links[one as usize].push(other);
                }
            }
        }
        // What was found from one side only is told to the other.
        let one_way: Vec<(u32, u32)> = (0_u32..)
            .zip(&self.links)
            .flat_map(|(from, links)| links.iter().map(move |to| (*to, from)))
            .collect();
        one_way
            .into_iter()
            .for_each(|(from, to)| self.links[from as usize].push(to));
        for links in &mut self.links {
            links.sort_unstable();
            links.dedup();
        }
    }
}
