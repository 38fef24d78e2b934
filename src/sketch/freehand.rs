//! From the path of a hand to the handles of a curve.
//!
//! Four steps, each a pure function and each done while the path grows:
//!
//! 1. [`Freehand::push`] takes places and keeps samples at equal distances. A sample is where the path leaves
//!    the ball around the one before, so a hand that trembles in place adds nothing, and how often it was
//!    looked at on the way changes little.
//! 2. [`smoothed`]: a mean with triangular weights over the neighbouring samples. It narrows
//!    towards the ends, which stay where they are.
//! 3. [`simplify`]: the fewest of these samples whose polyline keeps within a tolerance, after Ramer, "An
//!    iterative procedure for the polygonal approximation of plane curves" (1972), and Douglas
//!    and Peucker, "Algorithms for the reduction of the number of points required to represent a digitized line
//!    or its caricature" (1973). Those are the handles.
//! 4. Each span between two handles gets as many segments as its length has spacings;
//!    [`super::curve`] places the nodes.
//!
//! A long stroke costs no more in a frame than a short one: the latest 256 samples are worked on anew,
//! and as they grow more, the older part is settled: its handles stay from then on, and its samples are
//! forgotten. So the work of a stroke is in proportion to its length, and what was drawn a while ago does not
//! flicker under the hand.

use glam::{DVec3, Vec3};

use super::BOUNDS;

/// Samples that are worked on anew (the module's docs name the number); beyond these the older part is settled.
const WINDOW: usize = 256;
/// Most samples of one straight move: a hand that jumps across the room is a line, not a thousand samples.
const SAMPLES_OF_A_MOVE: f64 = 256.0;
/// Widest smoothing, samples to either side.
const RADIUS_MOST: usize = 64;
/// Handles keep at least this many shortest segments apart, so that rounding to the grid makes none too short.
const APART: f32 = 1.2;
/// A span has at most as many segments as the straight line between its handles has lengths of so many shortest
/// segments: on a bend, nodes are nearer to each other than along the curve.
const ROOM: f32 = 3.0;

/// How a path becomes a curve. Lengths are metres of the path's own space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreehandParams {
    /// Distance between samples, at least one and a half shortest segments of a sketch.
    pub sample: f32,
    /// Distance between nodes along the curve, about; at least twice `sample`.
    pub spacing: f32,
    /// How far the handles' polyline may be from the smoothed path.
    pub tolerance: f32,
    /// How much is smoothed, 0 (nothing) to 1.
    pub smoothing: f32,
    /// How far to either side smoothing reaches at its strongest.
    pub reach: f32,
    /// Places within this of the plane x = 0 are drawn onto it; 0: none.
    pub snap: f32,
    /// Most nodes of a stroke, at most 2,000, so that placing them all takes a small part of a frame; the path ends
    /// there.
    pub nodes: u32,
}

impl Default for FreehandParams {
    /// For a sketch at a quarter of its size: samples 2 mm and nodes 4 cm apart in the hand.
    fn default() -> Self {
        Self {
            sample: 0.008,
            spacing: 0.16,
            tolerance: 0.016,
            smoothing: 0.5,
            reach: 0.12,
            snap: 0.0,
            nodes: 2_000,
        }
    }
}

impl FreehandParams {
    /// These, with every number brought to where it makes sense; what is no number becomes the default.
    #[must_use]
    pub fn checked(&self) -> Self {
        let or = |value: f32, default: f32| if value.is_finite() { value } else { default };
        let default = Self::default();
        let most = BOUNDS.coordinate;
        let sample = or(self.sample, default.sample).clamp(BOUNDS.segment * 1.5, most);
        Self {
            sample,
            spacing: or(self.spacing, default.spacing).clamp(sample * 2.0, most * 2.0),
            tolerance: or(self.tolerance, default.tolerance).clamp(0.0, most),
            smoothing: or(self.smoothing, default.smoothing).clamp(0.0, 1.0),
            reach: or(self.reach, default.reach).clamp(0.0, most),
            snap: or(self.snap, default.snap).clamp(0.0, most),
            nodes: self.nodes.clamp(1, default.nodes),
        }
    }

    /// How many samples to either side are smoothed over.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked: a small number, 0 or more"
    )]
    fn radius(&self) -> usize {
        ((self.smoothing * self.reach / self.sample).round() as usize).min(RADIUS_MOST)
    }
}

/// The smoothed sample `index`: a mean of its neighbours, as many on either side, at most `radius`.
#[must_use]
pub fn smoothed(samples: &[Vec3], index: usize, radius: usize) -> Option<Vec3> {
    let own = samples.get(index)?;
    let radius = radius.min(index).min(samples.len() - 1 - index);
    if radius == 0 {
        return Some(*own);
    }
    let around = samples.get(index - radius..=index + radius)?;
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for (place, sample) in around.iter().enumerate() {
        let weight = (radius + 1 - place.abs_diff(radius)) as f64;
        sum += sample.as_dvec3() * weight;
        weights += weight;
    }
    Some((sum / weights).as_vec3())
}

/// Which points to keep so that the others are within `tolerance` of the polyline through the kept: always the first and
/// the last. At worst in time of the square of the number of points; without recursion.
#[must_use]
pub fn simplify(points: &[Vec3], tolerance: f32) -> Vec<usize> {
    let Some(last) = points.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut kept = vec![0];
    // Stretches still to be looked at, the next one last: so what is kept comes in order.
    let mut open = vec![(0, last)];
    while let Some((start, end)) = open.pop() {
        match farthest(points, start, end) {
            Some((index, distance)) if distance > f64::from(tolerance) => {
                open.push((index, end));
                open.push((start, index));
            }
            _ if end > start => kept.push(end),
            _ => {}
        }
    }
    kept
}

/// The point strictly between two others that is farthest from the straight line between them, and how far.
fn farthest(points: &[Vec3], start: usize, end: usize) -> Option<(usize, f64)> {
    let (from, to) = (points.get(start)?, points.get(end)?);
    let mut found: Option<(usize, f64)> = None;
    for index in start + 1..end {
        let distance = from_line(*points.get(index)?, *from, *to);
        if found.is_none_or(|(_, most)| distance > most) {
            found = Some((index, distance));
        }
    }
    found
}

/// Distance of a point from a straight line between two others.
fn from_line(point: Vec3, from: Vec3, to: Vec3) -> f64 {
    let [point, from, to] = [point, from, to].map(|at| at.as_dvec3());
    let along = to - from;
    let length_squared = along.length_squared();
    if length_squared <= 0.0 {
        return point.distance(from);
    }
    let part = ((point - from).dot(along) / length_squared).clamp(0.0, 1.0);
    point.distance(from + along * part)
}

/// The handles of a path behind its start, and the segments that lead to each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spans {
    /// Where the curve goes through.
    pub through: Vec<Vec3>,
    /// How many segments lead to each of these.
    pub segments: Vec<u32>,
    /// Their sum.
    nodes: u32,
}

impl Spans {
    /// Adds the kept of `path`, whose first point is where the curve is by now. Of handles too near to each other only the
    /// first is taken, but the path's end always, if any.
    fn gather(&mut self, path: &[Vec3], kept: &[usize], params: &FreehandParams) {
        let Some(&start) = path.first() else { return };
        let place = |index: usize| path.get(index).copied().unwrap_or(start);
        let apart = BOUNDS.segment * APART;
        let near = |ends: &[usize], index: usize| {
            let before = ends.last().map_or(start, |&end| place(end));
            before.distance(place(index)) < apart
        };
        let mut ends: Vec<usize> = Vec::with_capacity(kept.len());
        for &index in kept.iter().skip(1) {
            let is_end = index + 1 == path.len();
            while is_end && near(&ends, index) && ends.pop().is_some() {}
            if !near(&ends, index) {
                ends.push(index);
            }
        }
        let mut behind = 0;
        for end in ends {
            let part = path.get(behind..=end).unwrap_or_default();
            let length: f32 = part.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
            // A path that trembles within the tolerance is longer than its curve.
            let most = place(behind).distance(place(end)) / (BOUNDS.segment * ROOM);
            self.add(place(end), (length / params.spacing).min(most), params);
            behind = end;
        }
    }

    /// Adds a handle and about so many segments on the way to it.
    fn add(&mut self, place: Vec3, segments: f32, params: &FreehandParams) {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "bounded by the most nodes, and a length is 0 or more"
        )]
        let count = segments.round().clamp(1.0, params.nodes as f32) as u32;
        let count = count.min(params.nodes.saturating_sub(self.nodes));
        if count > 0 {
            self.through.push(place);
            self.segments.push(count);
            self.nodes += count;
        }
    }
}

/// A path that is being drawn.
#[derive(Clone, Debug)]
pub struct Freehand {
    params: FreehandParams,
    radius: usize,
    /// The latest place, on the way from the latest sample to the next.
    latest: Option<Vec3>,
    /// The samples that smoothing still needs.
    samples: Vec<Vec3>,
    /// How many of `samples` have been smoothed for good.
    done: usize,
    /// Smoothed samples since the last settled handle, which is the first.
    tail: Vec<Vec3>,
    settled: Spans,
}

impl Default for Freehand {
    fn default() -> Self {
        Self::new(FreehandParams::default())
    }
}

impl Freehand {
    /// An empty path.
    #[must_use]
    pub fn new(params: FreehandParams) -> Self {
        let params = params.checked();
        Self {
            params,
            radius: params.radius(),
            latest: None,
            samples: Vec::new(),
            done: 0,
            tail: Vec::new(),
            settled: Spans::default(),
        }
    }

    /// Begins anew, keeping the memory.
    pub fn begin(&mut self, params: FreehandParams) {
        self.params = params.checked();
        self.radius = self.params.radius();
        self.latest = None;
        self.done = 0;
        self.samples.clear();
        self.tail.clear();
        self.settled.through.clear();
        self.settled.segments.clear();
        self.settled.nodes = 0;
    }

    /// Goes on to a place, in a straight line. A place that is no number or beyond a sketch's bounds is left out.
    /// Gives whether anything changed.
    pub fn push(&mut self, place: Vec3) -> bool {
        // NaN fails the test too.
        let within = place.abs().max_element() <= BOUNDS.coordinate && place.is_finite();
        if !within || self.is_full() {
            return false;
        }
        let mut place = place;
        if place.x.abs() <= self.params.snap {
            place.x = 0.0;
        }
        let Some(latest) = self.latest.replace(place) else {
            self.take(place);
            return true;
        };
        self.walk(latest, place);
        latest != place
    }

    /// Whether the path has as many nodes as a stroke may have; what comes is left out.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.settled.nodes >= self.params.nodes
    }

    /// Takes the samples of a straight way.
    fn walk(&mut self, from: Vec3, to: Vec3) {
        let Some(&anchor) = self.samples.last() else {
            return self.take(to);
        };
        let step = f64::from(self.params.sample);
        let [anchor, from, to] = [anchor, from, to].map(|at| at.as_dvec3());
        if anchor.distance(to) < step || from == to {
            return;
        }
        // Where the line leaves the ball around the latest sample: |from + t·way − anchor| = step.
        let (way, aside) = (to - from, from - anchor);
        let (a, b) = (way.length_squared(), way.dot(aside));
        let c = (aside.length_squared() - step * step).min(0.0);
        let root = (b * b - a * c).max(0.0).sqrt();
        let first = from + way * ((root - b) / a).clamp(0.0, 1.0);
        self.take(first.as_vec3());
        let rest = first.distance(to);
        let step = step.max(rest / SAMPLES_OF_A_MOVE);
        let steps = (rest / step).floor();
        let mut taken = 1.0;
        while taken <= steps {
            self.take((first + (to - first) * (taken * step / rest)).as_vec3());
            taken += 1.0;
        }
    }

    /// Takes a sample, smooths what has all its neighbours now, and settles what is old.
    fn take(&mut self, sample: Vec3) {
        self.samples.push(sample);
        while self.done + self.radius < self.samples.len() {
            let smoothed = smoothed(&self.samples, self.done, self.radius);
            self.tail.extend(smoothed);
            self.done += 1;
        }
        // Only the neighbours of what is still to be smoothed are needed; they are moved down rarely.
        let needless = self.done.saturating_sub(self.radius);
        if needless > WINDOW {
            self.samples.drain(..needless);
            self.done -= needless;
        }
        if self.tail.len() >= WINDOW {
            self.settle();
        }
    }

    /// Settles the older part of the tail: up to a handle of the whole tail if one lies in its second quarter, so that the
    /// cut is seldom seen; at half of it otherwise.
    fn settle(&mut self) {
        let half = self.tail.len() / 2;
        let kept = simplify(&self.tail, self.params.tolerance);
        let cut = kept.into_iter().rev().find(|&index| index <= half);
        let cut = cut.filter(|&index| index >= half / 2).unwrap_or(half);
        let Some(old) = self.tail.get(..=cut) else {
            return;
        };
        let kept = simplify(old, self.params.tolerance);
        let before = self.settled.through.len();
        self.settled.gather(old, &kept, &self.params);
        if self.settled.through.len() > before {
            self.tail.drain(..cut);
        } else {
            // The path stayed in one place; only its end is of use.
            self.tail.drain(1..cut);
        }
    }

    /// The curve as it is if the path ends here.
    #[must_use]
    pub fn spans(&self) -> Spans {
        let mut spans = self.settled.clone();
        let mut path = self.tail.clone();
        let mut rest = self.samples.clone();
        if let Some(latest) = self.latest.filter(|latest| rest.last() != Some(latest)) {
            rest.push(latest);
        }
        path.extend((self.done..rest.len()).filter_map(|at| smoothed(&rest, at, self.radius)));
        let kept = simplify(&path, self.params.tolerance);
        spans.gather(&path, &kept, &self.params);
        spans
    }
}

/// The curve of a whole path.
#[must_use]
pub fn fit(path: impl IntoIterator<Item = Vec3>, params: &FreehandParams) -> Spans {
    let mut freehand = Freehand::new(*params);
    for place in path {
        freehand.push(place);
    }
    freehand.spans()
}

#[cfg(test)]
#[path = "freehand_tests.rs"]
mod tests;
