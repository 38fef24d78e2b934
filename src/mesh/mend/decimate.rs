//! Fewer triangles by quadric error: edges are collapsed, the cheapest first (Garland and Heckbert, *Surface simplification using quadric error
//! metrics*, SIGGRAPH 1997).
//!
//! Topology stays as it is (see [`Surface::can_collapse`]), no triangle folds over, and vertices on a boundary stay where they are or go away
//! along it: an open end keeps its line, in fewer pieces. Non-manifold edges and vertices stay with all their triangles.
//!
//! meshoptimizer (crate `meshopt`) was tried and is faster, but it needs a C++ compiler, cannot be stopped in the middle, and has
//! no link condition: it made non-manifold edges of a ring of 3,200 triangles on the way to 32, and nothing at all of one of 180.

use glam::{DMat3, DVec3};

use super::buckets::Buckets;
use super::surface::{Neighbour, Surface};
use super::{Amount, Decimate, MendError, Work};
use crate::mesh::Mesh;
use crate::mesh::problem::grouped;

/// How much more the planes that stand on boundary edges weigh than triangles.
const BOUNDARY: f64 = 100.0;

/// How much of an edge's length is added to its error, so that of equal errors, as on planes, the shortest edges go first.
const SHORTNESS: f64 = 1e-4;

/// Collapses between two looks at whether to go on.
const BLOCK: usize = 1 << 10;

pub(super) fn decimate(
    mesh: Mesh,
    decimate: &Decimate,
    work: &mut Work,
) -> Result<Mesh, MendError> {
    let before = mesh.triangles.len();
    let target = match decimate.to {
        Amount::Triangles(triangles) => triangles as usize,
        Amount::Share(share) => share_of(before, share),
    };
    if before <= target {
        return Ok(mesh);
    }
    let report = work.report(&mesh)?;
    let mut surface = Surface::new(&mesh);
    surface.lock(&report);
    drop((mesh, report));
    let mut queue = Queue::new(surface);
    // Edges that could not be collapsed may be once others around them have been.
    while queue.fill(target, work)? && queue.drain(target, before, work)? {}
    let surface = queue.surface;
    if surface.live() > target {
        work.say(format!(
            "no fewer than {} triangles, since its form would be another",
            grouped(surface.live())
        ));
    }
    Ok(surface.into_mesh())
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a share of a count is a count"
)]
fn share_of(count: usize, share: f64) -> usize {
    (count as f64 * share).ceil().max(1.0) as usize
}

/// The sum of squared distances from planes, by area: pᵀ A p + 2 bᵀ p + c. Counted from a vertex of its own, so that what lies far from the
/// origin loses nothing to rounding.
#[derive(Clone, Copy, Default)]
struct Quadric {
    /// xx, xy, xz, yy, yz, zz.
    a: [f64; 6],
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// The plane through a point.
    fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let DVec3 { x, y, z } = normal;
        let offset = -normal.dot(point);
        Self {
            a: [x * x, x * y, x * z, y * y, y * z, z * z].map(|one| weight * one),
            b: weight * offset * normal,
            c: weight * offset * offset,
        }
    }

    fn add(&mut self, other: &Self) {
        for (one, other) in self.a.iter_mut().zip(other.a) {
            *one += other;
        }
        self.b += other.b;
        self.c += other.c;
    }

    fn matrix(&self) -> DMat3 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
    }

    fn at(&self, point: DVec3) -> f64 {
        (point.dot(self.matrix() * point) + 2.0 * self.b.dot(point) + self.c).max(0.0)
    }

    /// Where it is least, if that is one point.
    fn least(&self) -> Option<DVec3> {
        let matrix = self.matrix();
        let size = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
        let determinant = matrix.determinant();
        (determinant > 1e-6 * size.powi(3)).then(|| matrix.inverse() * -self.b)
    }
}

/// An edge that may be collapsed.
struct Candidate {
    edge: [u32; 2],
    /// How often its ends had changed when it was put in.
    stamps: [u32; 2],
}

struct Queue {
    surface: Surface,
    /// Where coordinates are counted from in quadrics.
    middle: DVec3,
    quadrics: Vec<Quadric>,
    stamps: Vec<u32>,
    rim: Vec<bool>,
    candidates: Buckets<Candidate>,
    rings: [Vec<Neighbour>; 2],
}

impl Queue {
    fn new(surface: Surface) -> Self {
        let len = surface.points.len();
        let sum: DVec3 = surface.points.iter().sum();
        let mut queue = Self {
            middle: sum / len.max(1) as f64,
            quadrics: vec![Quadric::default(); len],
            stamps: vec![0; len],
            rim: vec![false; len],
            candidates: Buckets::new(),
            rings: Default::default(),
            surface,
        };
        queue.measure();
        queue
    }

    fn point(&self, vertex: u32) -> DVec3 {
        self.surface.points[vertex as usize] - self.middle
    }

    /// The quadrics of all vertices: of their triangles, and of planes that stand on boundary edges.
    fn measure(&mut self) {
        for face in self.surface.faces.clone() {
            let corners = face.map(|vertex| self.point(vertex));
            let across = super::cross(corners);
            let normal = across.normalize_or_zero();
            let plane = Quadric::plane(normal, corners[0], across.length() / 6.0);
            for vertex in face {
                self.quadrics[vertex as usize].add(&plane);
            }
            for at in 0..3 {
                let edge = [face[at], face[(at + 1) % 3]];
                if self.surface.at_edge(edge).nth(1).is_some() {
                    continue;
                }
                let [from, to] = edge.map(|vertex| self.point(vertex));
                let wall = (to - from).cross(normal).normalize_or_zero();
                let weight = BOUNDARY * from.distance_squared(to);
                let plane = Quadric::plane(wall, from, weight);
                for vertex in edge {
                    self.quadrics[vertex as usize].add(&plane);
                    self.rim[vertex as usize] = true;
                }
            }
        }
    }

    /// Puts all edges in; false where there is nothing more to do.
    fn fill(&mut self, target: usize, work: &Work) -> Result<bool, MendError> {
        if self.surface.live() <= target {
            return Ok(false);
        }
        for (at, edge) in self.surface.edges().into_iter().enumerate() {
            if at % BLOCK == 0 {
                work.go_on()?;
            }
            self.put(edge);
        }
        Ok(true)
    }

    fn put(&mut self, edge: [u32; 2]) {
        let [a, b] = edge.map(|vertex| vertex as usize);
        if self.surface.locked[a] || self.surface.locked[b] {
            return;
        }
        let (_, cost) = self.best(edge);
        let stamps = [self.stamps[a], self.stamps[b]];
        self.candidates.push(cost, Candidate { edge, stamps });
    }

    /// Where the vertex that an edge becomes stands, and what that costs.
    fn best(&self, edge: [u32; 2]) -> (DVec3, f64) {
        let [a, b] = edge.map(|vertex| vertex as usize);
        let mut quadric = self.quadrics[a];
        quadric.add(&self.quadrics[b]);
        let [from, to] = edge.map(|vertex| self.point(vertex));
        let length = from.distance(to);
        let middle = from.midpoint(to);
        let points = match [self.rim[a], self.rim[b]] {
            [true, false] => [from; 3],
            [false, true] => [to; 3],
            [true, true] => [from, to, to],
            [false, false] => {
                let least = quadric.least();
                match least.filter(|least| least.distance(middle) <= length) {
                    Some(least) => [least; 3],
                    None => [from, to, middle],
                }
            }
        };
        let costs = points.map(|point| (quadric.at(point), point));
        let cheapest = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let (cost, point) = cheapest.unwrap_or((0.0, middle));
        // A quadric is an area by the square of a length.
        (point, cost + (SHORTNESS * length * length).powi(2))
    }

    /// Collapses until there are few enough, or no edge is left; says whether any was.
    fn drain(&mut self, target: usize, before: usize, work: &mut Work) -> Result<bool, MendError> {
        let (start, mut tried) = (self.surface.live(), 0_usize);
        while self.surface.live() > target
            && let Some(candidate) = self.candidates.pop()
        {
            let [a, b] = candidate.edge.map(|vertex| self.stamps[vertex as usize]);
            if candidate.stamps == [a, b] {
                self.collapse(candidate.edge);
            }
            tried += 1;
            if tried.is_multiple_of(BLOCK) {
                work.step(before - self.surface.live(), before - target)?;
            }
        }
        Ok(self.surface.live() < start)
    }

    fn collapse(&mut self, [a, b]: [u32; 2]) {
        let [of_a, of_b] = &mut self.rings;
        self.surface.ring(a, of_a);
        self.surface.ring(b, of_b);
        if !self.surface.can_collapse([a, b], [&*of_a, &*of_b]) {
            return;
        }
        let (point, _) = self.best([a, b]);
        let point = point + self.middle;
        // As meshes hold it.
        let point = point.as_vec3().as_dvec3();
        if self.surface.folds(a, b, point) || self.surface.folds(b, a, point) {
            return;
        }
        self.surface.collapse([a, b], point);
        let gone = self.quadrics[a as usize];
        self.quadrics[b as usize].add(&gone);
        self.rim[b as usize] |= self.rim[a as usize];
        self.stamps[a as usize] += 1;
        self.stamps[b as usize] += 1;
        let mut ring = std::mem::take(&mut self.rings[0]);
        self.surface.ring(b, &mut ring);
        for (other, _) in &ring {
            self.put([b.min(*other), b.max(*other)]);
        }
        self.rings[0] = ring;
    }
}
