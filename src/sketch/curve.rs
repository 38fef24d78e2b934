//! Curved strokes: some nodes are handles, and the nodes between them lie on the curve through the
//! handles.
//!
//! The curve is the centripetal Catmull–Rom spline (Catmull and Rom, "A class of local interpolating
//! splines", 1974): it goes through each handle, a handle shapes two spans to either side and no
//! more, and with centripetal knots a span has neither cusps nor loops (Yuksel, Schaefer and Keyser,
//! "Parameterization and applications of Catmull–Rom curves", 2011, section 3). It is evaluated by
//! the pyramid of Barry and Goldman, "A recursive evaluation algorithm for a class of Catmull–Rom
//! splines", 1988. Bézier handles beside each node were not taken: a hand in the air would have to
//! find three things for each node where one says enough.
//!
//! Growth and attachments count nodes, so a handle that moves leaves the number of nodes in each span
//! as it is and only places them anew, at equal distances along the curve. Drawing on does not
//! touch what is drawn: the preview shows exactly what is made.

use glam::{DVec3, Vec3};

use super::{Stroke, quantize};

/// Steps in which a span's length is measured for each of its segments, at least [`STEPS_LEAST`]
/// and at most [`STEPS_MOST`] in all.
const STEPS_PER_SEGMENT: u32 = 8;
const STEPS_LEAST: u32 = 16;
const STEPS_MOST: u32 = 1 << 16;
/// Shortest interval between two knots, square root of metres: far below the grid, so that handles
/// that coincide divide by no zero.
const KNOT_LEAST: f64 = 1e-6;

/// One span of the curve, from the second of four points to the third.
struct Span {
    points: [DVec3; 4],
    knots: [f64; 4],
}

impl Span {
    /// The span between two handles; where the curve ends, its missing neighbour is the reflected other end.
    fn new(before: Option<DVec3>, from: DVec3, to: DVec3, after: Option<DVec3>) -> Self {
        let points = [
            before.unwrap_or(2.0 * from - to),
            from,
            to,
            after.unwrap_or(2.0 * to - from),
        ];
        let [p0, p1, p2, p3] = points;
        let interval = |a: DVec3, b: DVec3| a.distance(b).sqrt().max(KNOT_LEAST);
        let first = interval(p0, p1);
        let second = first + interval(p1, p2);
        let knots = [0.0, first, second, second + interval(p2, p3)];
        Self { points, knots }
    }

    /// A place of the span, `part` from 0 to 1.
    fn at(&self, part: f64) -> DVec3 {
        let ([p0, p1, p2, p3], [k0, k1, k2, k3]) = (self.points, self.knots);
        let t = k1 + (k2 - k1) * part;
        let between = |a: DVec3, b: DVec3, from: f64, to: f64| {
            a * ((to - t) / (to - from)) + b * ((t - from) / (to - from))
        };
        let a = [
            between(p0, p1, k0, k1),
            between(p1, p2, k1, k2),
            between(p2, p3, k2, k3),
        ];
        let b = [between(a[0], a[1], k0, k2), between(a[1], a[2], k1, k3)];
        between(b[0], b[1], k1, k2)
    }

    /// The span's nodes behind its start, `segments` of them at equal distances along the curve; the last is
    /// its end itself.
    fn nodes(&self, segments: u32, mut node: impl FnMut(Vec3)) {
        if segments > 1 {
            self.inner_nodes(segments, &mut node);
        }
        if segments > 0 {
            node(on_grid(self.points[2]));
        }
    }

    fn inner_nodes(&self, segments: u32, node: &mut impl FnMut(Vec3)) {
        let steps = segments
            .saturating_mul(STEPS_PER_SEGMENT)
            .clamp(STEPS_LEAST, STEPS_MOST);
        let part = |step: f64| step / f64::from(steps);
        let mut total = 0.0;
        let mut last = self.at(0.0);
        for step in 1..=steps {
            let here = self.at(part(step.into()));
            total += here.distance(last);
            last = here;
        }
        let (mut made, mut walked) = (1, 0.0);
        let mut last = self.at(0.0);
        for step in 1..=steps {
            let here = self.at(part(step.into()));
            let length = here.distance(last);
            while made < segments {
                let ahead = total * (f64::from(made) / f64::from(segments)) - walked;
                // The last step takes what rounding left over.
                if ahead > length && step < steps {
                    break;
                }
                let share = if length > 0.0 { ahead / length } else { 1.0 };
                node(on_grid(
                    self.at(part(f64::from(step - 1) + share.clamp(0.0, 1.0))),
                ));
                made += 1;
            }
            walked += length;
            last = here;
        }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "positions are f32")]
fn on_grid(at: DVec3) -> Vec3 {
    quantize::point(Vec3::new(at.x as f32, at.y as f32, at.z as f32))
}

impl Stroke {
    /// Whether some nodes lie between handles: without handles listed, each node is its own.
    #[must_use]
    pub fn is_curve(&self) -> bool {
        !self.handles.is_empty()
    }

    /// Whether a node, 1 or more, is one that the curve was drawn through.
    #[must_use]
    pub fn is_handle(&self, node: u32) -> bool {
        !self.is_curve() || self.handles.binary_search(&node).is_ok()
    }

    /// Adds spans behind the apex: a handle at each place (metres from the stroke's start) and so many segments
    /// on the way to it. What is there stays.
    pub(super) fn append_curve(&mut self, through: &[Vec3], segments: &[u32]) {
        self.list_handles();
        let mut before = self.handles.len().checked_sub(1).and_then(|last| {
            // The handle before the apex, or the start.
            let node = last.checked_sub(1).and_then(|at| self.handles.get(at));
            self.offset(node.copied().unwrap_or(0)).map(quantize::exact)
        });
        let mut from = quantize::exact(self.points.last().copied().unwrap_or(Vec3::ZERO));
        for (index, (&to, &count)) in through.iter().zip(segments).enumerate() {
            let to = quantize::exact(to);
            let after = through.get(index + 1).copied().map(quantize::exact);
            let span = Span::new(before, from, to, after);
            span.nodes(count, |node| self.points.push(node));
            self.handles.push(self.segments());
            (before, from) = (Some(from), to);
        }
        self.tidy_handles();
        self.go_on_without_radii();
    }

    /// Adds plain segments; on a curve, each of their nodes is a handle.
    pub(super) fn append_plain(&mut self, added: impl IntoIterator<Item = Vec3>) {
        for point in added {
            self.points.push(point);
            if self.is_curve() {
                self.handles.push(self.segments());
            }
        }
        self.go_on_without_radii();
    }

    /// Nodes that are drawn behind those that have radii have none.
    fn go_on_without_radii(&mut self) {
        if !self.radii.is_empty() {
            self.radii.resize(self.points.len(), 0.0);
        }
    }

    /// A stroke of whose nodes none has a radius lists none, so that equal strokes are equal data.
    pub(crate) fn tidy_radii(&mut self) {
        if self.radii.iter().all(|radius| *radius == 0.0) {
            self.radii = Vec::new();
        }
    }

    /// Moves node `node` (1 or more) to a place relative to the stroke's start. On a curve it becomes a
    /// handle if it was none, and the nodes in the two spans to either side are placed anew.
    pub(super) fn move_own_node(&mut self, node: u32, to: Vec3) {
        let index = node.saturating_sub(1) as usize;
        let Some(point) = self.points.get_mut(index) else {
            return;
        };
        *point = quantize::point(to);
        if !self.is_curve() {
            return;
        }
        let handle = match self.handles.binary_search(&node) {
            Ok(handle) => handle,
            Err(place) => {
                self.handles.insert(place, node);
                place
            }
        };
        for span in handle.saturating_sub(1)..=handle + 2 {
            self.place_span(span);
        }
        self.tidy_handles();
    }

    /// Places the nodes anew that lie between handle `span` and the one before it.
    fn place_span(&mut self, span: usize) {
        // Handle −1 is the stroke's start.
        let node_of = |handle: Option<usize>| match handle {
            None => Some(0),
            Some(handle) => self.handles.get(handle).copied(),
        };
        let place = |node: u32| self.offset(node).map(quantize::exact);
        let before = span.checked_sub(1).and_then(|at| {
            let node = node_of(at.checked_sub(1))?;
            place(node)
        });
        let after = node_of(Some(span + 1)).and_then(place);
        let (Some(from_node), Some(to_node)) = (node_of(span.checked_sub(1)), node_of(Some(span)))
        else {
            return;
        };
        let (Some(from), Some(to)) = (place(from_node), place(to_node)) else {
            return;
        };
        let count = to_node.saturating_sub(from_node);
        let between = self.points.get_mut(from_node as usize..to_node as usize);
        let mut between = between.unwrap_or_default().iter_mut();
        Span::new(before, from, to, after).nodes(count, |node| {
            if let Some(point) = between.next() {
                *point = node;
            }
        });
    }

    /// Cuts the stroke behind its first `nodes` nodes; the last one left is a handle.
    pub(super) fn truncate(&mut self, nodes: usize) {
        self.points.truncate(nodes);
        self.radii.truncate(nodes);
        self.tidy_radii();
        let apex = self.segments();
        let was_curve = self.is_curve();
        self.handles.retain(|&handle| handle < apex);
        if was_curve && apex > 0 {
            self.handles.push(apex);
        }
        self.tidy_handles();
    }

    /// Writes out the handles of a plain stroke: all its nodes.
    fn list_handles(&mut self) {
        if !self.is_curve() {
            self.handles = (1..=self.segments()).collect();
        }
    }

    /// A stroke whose nodes are all handles lists none, so that equal strokes are equal data.
    pub(super) fn tidy_handles(&mut self) {
        if self.handles.len() == self.points.len() {
            self.handles = Vec::new();
        }
    }

    /// Whether the handles rise from 1 or more and end at the apex, and not all nodes are listed.
    pub(super) fn handles_are_sound(&self) -> bool {
        let rising = self.handles.windows(2).all(|pair| pair[0] < pair[1]);
        let apex = self
            .handles
            .last()
            .is_none_or(|&last| last == self.segments());
        let first = self.handles.first().is_none_or(|&first| first > 0);
        let fewer = self.handles.is_empty() || self.handles.len() < self.points.len();
        rising && apex && first && fewer
    }
}

#[cfg(test)]
#[path = "curve_tests.rs"]
mod tests;
