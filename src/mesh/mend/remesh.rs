//! Triangles of one size (Botsch and Kobbelt, *A remeshing approach to multiresolution modeling*, SGP 2004): edges longer than 4/3 of the
//! length are split, those shorter than 4/5 collapsed, others flipped so that vertices have six triangles (three on a boundary), vertices moved to the
//! middle of their neighbours along the surface and back onto the surface as it was; and all that a few times.
//!
//! Boundaries and creases (edges at which the surface bends by more than [`CREASE`]) stay lines of edges: their vertices are not moved, and
//! edges go only along them. Where three such lines meet or one ends, and at non-manifold vertices, all stays. Topology stays as it is.

use std::collections::HashSet;

use glam::DVec3;

use super::nearest::Nearest;
use super::surface::{Neighbour, Surface};
use super::{Mend, MendError, Remesh, Work};
use crate::mesh::Mesh;
use crate::mesh::report::NONE;

/// Rounds of all steps.
const ROUNDS: usize = 6;

/// Rounds of splitting in one round: each halves what is too long.
const SPLITS: usize = 40;

/// The cosine of the angle from which on an edge is a crease: 60°. Less would keep the steps of voxels.
const CREASE: f64 = 0.5;

/// Edges between two looks at whether to go on.
const BLOCK: usize = 1 << 9;

pub(super) fn remesh(mesh: Mesh, remesh: &Remesh, work: &mut Work) -> Result<Mesh, MendError> {
    let length = remesh.edge.of(&mesh);
    let report = work.report(&mesh)?;
    check(remesh, length, report.area())?;
    let mut surface = Surface::new(&mesh);
    surface.lock(&report);
    drop(report);
    let nearest = Nearest::new(&mesh);
    drop(mesh);
    work.go_on()?;
    let mut remesher = Remesher {
        creases: HashSet::new(),
        lines: vec![0; surface.points.len()],
        rim: vec![false; surface.points.len()],
        surface,
        length,
        rings: Default::default(),
    };
    remesher.find_creases();
    let creases = remesher.creases.len();
    let steps = 4 * ROUNDS;
    for round in 0..ROUNDS {
        work.step(4 * round, steps)?;
        remesher.split(remesh, work)?;
        work.step(4 * round + 1, steps)?;
        remesher.collapse(work)?;
        work.step(4 * round + 2, steps)?;
        remesher.flip(work)?;
        work.step(4 * round + 3, steps)?;
        remesher.relax(&nearest, work)?;
    }
    work.say(format!("edges made about {length:.3} long"));
    work.remark(
        creases,
        "edge at a boundary or crease kept as a line",
        "edges at boundaries and creases kept as lines",
    );
    Ok(remesher.surface.into_mesh())
}

/// Refuses lengths of which there would be too many triangles.
fn check(remesh: &Remesh, length: f64, area: f64) -> Result<(), MendError> {
    let mend = Mend::Remesh(*remesh);
    if length <= 0.0 {
        return Err(MendError::NoLength(mend));
    }
    let most = Remesh::TRIANGLES_MOST;
    let of_length = |length: f64| area / (0.75_f64.sqrt() / 2.0 * length * length);
    let triangles = of_length(length);
    if triangles > most as f64 {
        let least = length * (triangles / most as f64).sqrt();
        return Err(MendError::TooFine {
            mend,
            triangles,
            most,
            least,
        });
    }
    Ok(())
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

struct Remesher {
    surface: Surface,
    length: f64,
    /// Edges of boundaries and creases, the smaller end first.
    creases: HashSet<[u32; 2]>,
    /// How many of them each vertex has.
    lines: Vec<u32>,
    /// Vertices on a boundary.
    rim: Vec<bool>,
    rings: [Vec<Neighbour>; 2],
}

impl Remesher {
    fn find_creases(&mut self) {
        for edge in self.surface.edges() {
            let normals: Vec<DVec3> = self
                .surface
                .at_edge(edge)
                .map(|triangle| self.surface.normal(triangle).normalize_or_zero())
                .collect();
            let is_line = match normals[..] {
                // A triangle without area bends nothing.
                [one, other] => {
                    one.dot(other) < CREASE && one != DVec3::ZERO && other != DVec3::ZERO
                }
                _ => true,
            };
            if is_line {
                self.add_line(edge);
            }
            if normals.len() == 1 {
                edge.iter()
                    .for_each(|vertex| self.rim[*vertex as usize] = true);
            }
        }
    }

    fn add_line(&mut self, edge: [u32; 2]) {
        if self.creases.insert(sorted(edge)) {
            edge.iter()
                .for_each(|vertex| self.lines[*vertex as usize] += 1);
        }
    }

    fn remove_line(&mut self, edge: [u32; 2]) -> bool {
        let was = self.creases.remove(&sorted(edge));
        if was {
            edge.iter()
                .for_each(|vertex| self.lines[*vertex as usize] -= 1);
        }
        was
    }

    fn split(&mut self, remesh: &Remesh, work: &Work) -> Result<(), MendError> {
        let long = 4.0 / 3.0 * self.length;
        for _ in 0..SPLITS {
            let mut edges = self.surface.edges();
            edges.retain(|edge| self.surface.length(*edge) > long);
            if edges.is_empty() {
                break;
            }
            // The longest first, so that needles are cut across.
            edges.sort_by(|a, b| self.surface.length(*b).total_cmp(&self.surface.length(*a)));
            for (at, edge) in edges.into_iter().enumerate() {
                if at % BLOCK == 0 {
                    work.go_on()?;
                }
                if self.surface.live() >= 2 * Remesh::TRIANGLES_MOST {
                    // Needles have more triangles than their area tells.
                    return Err(MendError::TooFine {
                        mend: Mend::Remesh(*remesh),
                        triangles: self.surface.live() as f64,
                        most: Remesh::TRIANGLES_MOST,
                        least: 2.0 * self.length,
                    });
                }
                self.split_edge(edge);
            }
        }
        Ok(())
    }

    fn split_edge(&mut self, edge: [u32; 2]) {
        let [a, b] = edge;
        // Non-manifold vertices stay with all their triangles.
        if edge.iter().any(|v| self.surface.locked[*v as usize]) {
            return;
        }
        let [from, to] = edge.map(|vertex| self.surface.points[vertex as usize]);
        let middle = from.midpoint(to).as_vec3().as_dvec3();
        if middle == from || middle == to {
            return; // Coordinates have no place between the two.
        }
        self.rim.push(self.surface.at_edge(edge).nth(1).is_none());
        self.lines.push(0);
        let middle = self.surface.split(edge, middle);
        if self.remove_line(edge) {
            self.add_line([a, middle]);
            self.add_line([middle, b]);
        }
    }

    fn collapse(&mut self, work: &Work) -> Result<(), MendError> {
        let short = 4.0 / 5.0 * self.length;
        let mut edges = self.surface.edges();
        edges.retain(|edge| self.surface.length(*edge) < short);
        edges.sort_by(|a, b| self.surface.length(*a).total_cmp(&self.surface.length(*b)));
        for (at, edge) in edges.into_iter().enumerate() {
            if at % BLOCK == 0 {
                work.go_on()?;
            }
            let [a, b] = edge;
            // An end may be gone, or the edge longer by now.
            if self.surface.is_edge(edge) && self.surface.length(edge) < short {
                let _ = self.collapse_edge([a, b]) || self.collapse_edge([b, a]);
            }
        }
        Ok(())
    }

    /// Takes the first vertex away, if that is right.
    fn collapse_edge(&mut self, edge: [u32; 2]) -> bool {
        let [gone, kept] = edge;
        let on_line = self.creases.contains(&sorted(edge));
        let point = match (self.lines[gone as usize], self.lines[kept as usize]) {
            (0, 0) => {
                let [from, to] = edge.map(|vertex| self.surface.points[vertex as usize]);
                from.midpoint(to).as_vec3().as_dvec3()
            }
            (0, _) => self.surface.points[kept as usize],
            (2, _) if on_line => self.surface.points[kept as usize],
            _ => return false,
        };
        let [of_gone, of_kept] = &mut self.rings;
        self.surface.ring(gone, of_gone);
        self.surface.ring(kept, of_kept);
        let long = 4.0 / 3.0 * self.length;
        let reaches = |ring: &[Neighbour]| {
            ring.iter().any(|(other, _)| {
                let far = self.surface.points[*other as usize].distance(point);
                !edge.contains(other) && far > long
            })
        };
        let moves = point != self.surface.points[kept as usize];
        let stays = reaches(of_gone)
            || (moves && reaches(of_kept))
            || !self.surface.can_collapse(edge, [&*of_gone, &*of_kept])
            || self.surface.folds(gone, kept, point)
            || (moves && self.surface.folds(kept, gone, point));
        if stays {
            return false;
        }
        self.surface.collapse(edge, point);
        let ring = std::mem::take(&mut self.rings[0]);
        for (other, _) in &ring {
            if self.remove_line([gone, *other]) && *other != kept {
                self.add_line([kept, *other]);
            }
        }
        self.rings[0] = ring;
        true
    }

    fn flip(&mut self, work: &Work) -> Result<(), MendError> {
        for (at, edge) in self.surface.edges().into_iter().enumerate() {
            if at % BLOCK == 0 {
                work.go_on()?;
            }
            if self.creases.contains(&edge) {
                continue;
            }
            let Some(flip) = self.surface.across(edge) else {
                continue;
            };
            let vertices = [flip.edge[0], flip.edge[1], flip.apexes[0], flip.apexes[1]];
            if vertices.iter().any(|v| self.surface.locked[*v as usize]) {
                continue;
            }
            let excess = vertices.map(|vertex| {
                let wanted = if self.lines[vertex as usize] > 0 {
                    4
                } else {
                    6
                };
                i64::try_from(self.surface.degree(vertex)).unwrap_or(i64::MAX) - wanted
            });
            let [a, b, c, d] = excess.map(|one| one.saturating_mul(one));
            let [after_a, after_b] = [excess[0] - 1, excess[1] - 1].map(|one| one * one);
            let [after_c, after_d] = [excess[2] + 1, excess[3] + 1].map(|one| one * one);
            if after_a + after_b + after_c + after_d < a + b + c + d && self.stays_smooth(&flip) {
                self.surface.flip(&flip);
            }
        }
        Ok(())
    }

    /// The two new triangles agree with the two old ones.
    fn stays_smooth(&self, flip: &super::surface::Flip) -> bool {
        let ([a, b], [c, d]) = (flip.edge, flip.apexes);
        let normal = |face| super::cross(self.surface.corners(face)).normalize_or_zero();
        let before = [normal([a, b, c]), normal([b, a, d])];
        let after = flip.faces().map(normal);
        let all = before
            .iter()
            .flat_map(|one| after.map(|other| one.dot(other)));
        all.into_iter().all(|cosine| cosine > 0.7)
    }

    fn relax(&mut self, nearest: &Nearest, work: &Work) -> Result<(), MendError> {
        let mut ring = Vec::new();
        for vertex in (0_u32..).take(self.surface.points.len()) {
            if (vertex as usize).is_multiple_of(BLOCK) {
                work.go_on()?;
            }
            let fixed = self.lines[vertex as usize] > 0 || self.surface.locked[vertex as usize];
            self.surface.ring(vertex, &mut ring);
            if fixed || ring.is_empty() {
                continue;
            }
            let point = self.surface.points[vertex as usize];
            let sum: DVec3 = ring
                .iter()
                .map(|(other, _)| self.surface.points[*other as usize])
                .sum();
            let normals = self.surface.triangles(vertex);
            let normal: DVec3 = normals.map(|one| self.surface.normal(one)).sum();
            let normal = normal.normalize_or_zero();
            let move_by = sum / ring.len() as f64 - point;
            let along = point + move_by - normal * normal.dot(move_by);
            let Some(onto) = nearest.point(along) else {
                continue;
            };
            let onto = onto.as_vec3().as_dvec3();
            if !self.surface.folds(vertex, NONE, onto) {
                self.surface.points[vertex as usize] = onto;
            }
        }
        Ok(())
    }
}
