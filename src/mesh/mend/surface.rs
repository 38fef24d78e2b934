//! A surface whose triangles change: edges are collapsed, split and flipped, triangles added.
//!
//! Each vertex knows its corners by a linked list through the corners, so that any triangles at all, non-manifold ones too, can be held in
//! 28 bytes a triangle and 28 a vertex. (Half-edges hold only manifold surfaces, and scans are none.) Lists hold no dead
//! corners, so a walk is as long as the vertex has triangles.
//!
//! An edge is collapsed only where that leaves the topology as it is: where the two ends' links meet in the edge's link and nothing else
//! (Dey, Edelsbrunner, Guha and Nekhayev 1999), with all boundary edges taken as triangles to one more vertex outside.

use glam::DVec3;

use super::cross;
use crate::mesh::Mesh;
use crate::mesh::report::{Face, NONE, Report};

/// Normals that turn by more than this cosine when a vertex moves are taken as folded over.
const FOLDED: f64 = 0.2;

/// A surface whose triangles change.
pub(super) struct Surface {
    origin: DVec3,
    /// Places of vertices.
    pub(super) points: Vec<DVec3>,
    /// Triangles; [`NONE`] three times where one was taken away.
    pub(super) faces: Vec<Face>,
    /// Vertices that stay as they are, with all their triangles: the surface is not manifold there.
    pub(super) locked: Vec<bool>,
    /// The first corner of each vertex.
    first: Vec<u32>,
    /// The next corner of the same vertex.
    next: Vec<u32>,
    live: usize,
}

/// A neighbour, and how many triangles are at the edge to it.
pub(super) type Neighbour = (u32, u32);

fn number(of: usize) -> u32 {
    u32::try_from(of).unwrap_or(NONE)
}

impl Surface {
    /// The surface of a mesh that is clean.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut surface = Self {
            origin: mesh.origin,
            points: mesh.positions.iter().map(|p| p.as_dvec3()).collect(),
            faces: Vec::with_capacity(mesh.triangles.len()),
            locked: vec![false; mesh.positions.len()],
            first: vec![NONE; mesh.positions.len()],
            next: Vec::with_capacity(3 * mesh.triangles.len()),
            live: 0,
        };
        mesh.triangles.iter().for_each(|face| {
            surface.add(*face);
        });
        surface
    }

    /// Locks what the report says is not manifold.
    pub(super) fn lock(&mut self, report: &Report) {
        let ends = report.non_manifold_edges.as_flattened().iter();
        for vertex in ends.chain(&report.non_manifold_vertices) {
            self.locked[*vertex as usize] = true;
        }
    }

    /// The mesh of what is left; vertices in their order, without those that no triangle uses.
    pub(super) fn into_mesh(self) -> Mesh {
        let triangles = self.faces.into_iter().filter(|face| face[0] != NONE);
        super::clean::without_unused(Mesh {
            origin: self.origin,
            positions: self.points.into_iter().map(DVec3::as_vec3).collect(),
            triangles: triangles.collect(),
        })
    }

    /// Triangles that are there.
    pub(super) fn live(&self) -> usize {
        self.live
    }

    pub(super) fn add_vertex(&mut self, point: DVec3) -> u32 {
        self.points.push(point);
        self.locked.push(false);
        self.first.push(NONE);
        number(self.points.len() - 1)
    }

    pub(super) fn add(&mut self, face: Face) -> u32 {
        let triangle = number(self.faces.len());
        self.faces.push(face);
        self.next.extend([NONE; 3]);
        for (corner, vertex) in (3 * triangle..).zip(face) {
            self.hang(corner, vertex);
        }
        self.live += 1;
        triangle
    }

    fn hang(&mut self, corner: u32, vertex: u32) {
        self.next[corner as usize] = self.first[vertex as usize];
        self.first[vertex as usize] = corner;
    }

    /// The triangles of a vertex.
    pub(super) fn triangles(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let mut corner = self.first[vertex as usize];
        std::iter::from_fn(move || {
            let this = (corner != NONE).then_some(corner)?;
            corner = self.next[this as usize];
            Some(this / 3)
        })
    }

    /// Neighbours of a vertex, sorted.
    pub(super) fn ring(&self, vertex: u32, into: &mut Vec<Neighbour>) {
        into.clear();
        for triangle in self.triangles(vertex) {
            let others = self.faces[triangle as usize].iter();
            into.extend(others.filter(|v| **v != vertex).map(|v| (*v, 1)));
        }
        into.sort_unstable();
        into.dedup_by(|gone, kept| {
            let same = gone.0 == kept.0;
            kept.1 += u32::from(same) * gone.1;
            same
        });
    }

    /// The triangles at an edge.
    pub(super) fn at_edge(&self, [a, b]: [u32; 2]) -> impl Iterator<Item = u32> {
        self.triangles(a)
            .filter(move |triangle| self.faces[*triangle as usize].contains(&b))
    }

    pub(super) fn is_edge(&self, edge: [u32; 2]) -> bool {
        self.at_edge(edge).next().is_some()
    }

    pub(super) fn length(&self, [a, b]: [u32; 2]) -> f64 {
        self.points[a as usize].distance(self.points[b as usize])
    }

    pub(super) fn corners(&self, face: Face) -> [DVec3; 3] {
        face.map(|vertex| self.points[vertex as usize])
    }

    /// Twice the area of a triangle, as a vector that stands on it.
    pub(super) fn normal(&self, triangle: u32) -> DVec3 {
        cross(self.corners(self.faces[triangle as usize]))
    }

    /// All edges once, the smaller end first, in order.
    pub(super) fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.live * 3 / 2);
        let mut ring = Vec::new();
        for vertex in 0..number(self.points.len()) {
            self.ring(vertex, &mut ring);
            let larger = ring.iter().filter(|(other, _)| *other > vertex);
            edges.extend(larger.map(|(other, _)| [vertex, *other]));
        }
        edges
    }

    /// Whether the topology stays when the two become one. `rings` are theirs.
    pub(super) fn can_collapse(
        &self,
        [gone, kept]: [u32; 2],
        [of_gone, of_kept]: [&[Neighbour]; 2],
    ) -> bool {
        let Ok(at) = of_gone.binary_search_by_key(&kept, |(other, _)| *other) else {
            return false;
        };
        let triangles = of_gone[at].1;
        if triangles > 2 || self.locked[gone as usize] || self.locked[kept as usize] {
            return false;
        }
        let is_rim = |ring: &[Neighbour]| ring.iter().any(|(_, count)| *count == 1);
        if triangles == 2 && is_rim(of_gone) && is_rim(of_kept) {
            return false; // Two rims would touch.
        }
        let mut apexes = of_gone.iter().filter_map(|(vertex, count)| {
            let other = of_kept.binary_search_by_key(vertex, |(other, _)| *other);
            other.ok().map(|other| (*vertex, *count, of_kept[other].1))
        });
        let found = [apexes.next(), apexes.next(), apexes.next()];
        match (triangles, found) {
            // With both other edges on the rim the triangle is alone.
            (1, [Some((_, one, other)), None, None]) => one > 1 || other > 1,
            (2, [Some((a, ..)), Some((b, ..)), None]) => {
                let closes = |vertex| {
                    self.at_edge([vertex, a])
                        .any(|triangle| self.faces[triangle as usize].contains(&b))
                };
                !(closes(gone) && closes(kept)) // a tetrahedron
            }
            _ => false,
        }
    }

    /// Whether a triangle of `moved` folds over when that comes to stand at `point`; those that have `other` go away then. ([`NONE`]: none do.)
    pub(super) fn folds(&self, moved: u32, other: u32, point: DVec3) -> bool {
        self.triangles(moved).any(|triangle| {
            let face = self.faces[triangle as usize];
            if face.contains(&other) {
                return false;
            }
            let before = cross(self.corners(face));
            let after = cross(face.map(|vertex| {
                if vertex == moved {
                    point
                } else {
                    self.points[vertex as usize]
                }
            }));
            // What had no area may have any.
            before.dot(after) <= FOLDED * before.length() * after.length() && before != DVec3::ZERO
        })
    }

    /// Makes two vertices one, at a point; asked for only where [`Self::can_collapse`].
    pub(super) fn collapse(&mut self, [gone, kept]: [u32; 2], point: DVec3) {
        let mut corners = Vec::new();
        let mut apexes = Vec::new();
        for vertex in [gone, kept] {
            let mut corner = std::mem::replace(&mut self.first[vertex as usize], NONE);
            while corner != NONE {
                corners.push(corner);
                corner = self.next[corner as usize];
            }
        }
        for corner in &corners {
            let face = &mut self.faces[*corner as usize / 3];
            if face.contains(&gone) && face.contains(&kept) {
                apexes.extend(face.iter().filter(|v| **v != gone && **v != kept));
                *face = [NONE; 3];
                self.live -= 1;
            }
        }
        for corner in corners {
            let face = &mut self.faces[corner as usize / 3];
            if face[0] != NONE {
                face[corner as usize % 3] = kept;
                self.hang(corner, kept);
            }
        }
        apexes.into_iter().for_each(|apex| self.relink(apex));
        self.points[kept as usize] = point;
    }

    /// Takes corners off a vertex's list that are no longer its own.
    fn relink(&mut self, vertex: u32) {
        let mut corner = std::mem::replace(&mut self.first[vertex as usize], NONE);
        while corner != NONE {
            let following = self.next[corner as usize];
            if self.faces[corner as usize / 3][corner as usize % 3] == vertex {
                self.hang(corner, vertex);
            }
            corner = following;
        }
    }

    /// Puts a new vertex on an edge, which cuts all its triangles in two.
    pub(super) fn split(&mut self, [a, b]: [u32; 2], point: DVec3) -> u32 {
        let middle = self.add_vertex(point);
        let cut: Vec<u32> = self.at_edge([a, b]).collect();
        for triangle in cut {
            let face = self.faces[triangle as usize];
            let with = |old: u32| face.map(|vertex| if vertex == old { middle } else { vertex });
            let (near_a, near_b) = (with(b), with(a));
            self.faces[triangle as usize] = near_a;
            self.relink(b);
            let at = near_a.iter().position(|vertex| *vertex == middle);
            self.hang(3 * triangle + number(at.unwrap_or(0)), middle);
            self.add(near_b);
        }
        middle
    }

    /// Puts a new vertex into a triangle, which cuts it in three; gives the new triangles.
    pub(super) fn split_triangle(&mut self, triangle: u32, point: DVec3) -> [u32; 3] {
        let middle = self.add_vertex(point);
        let [a, b, c] = std::mem::replace(&mut self.faces[triangle as usize], [NONE; 3]);
        self.live -= 1;
        [a, b, c].into_iter().for_each(|vertex| self.relink(vertex));
        [[a, b, middle], [b, c, middle], [c, a, middle]].map(|face| self.add(face))
    }

    /// What an edge with two agreeing triangles would become if it were flipped: `[a, b]` and the two vertices across. None where it cannot be.
    pub(super) fn across(&self, [a, b]: [u32; 2]) -> Option<Flip> {
        let mut triangles = self.at_edge([a, b]);
        let (one, other) = (triangles.next()?, triangles.next()?);
        if triangles.next().is_some() {
            return None;
        }
        let triangles = match self.third(one, [a, b]) {
            Some(_) => [one, other],
            None => [other, one],
        };
        let apexes = [
            self.third(triangles[0], [a, b])?,
            self.third(triangles[1], [b, a])?,
        ];
        let free = apexes[0] != apexes[1] && !self.is_edge(apexes);
        let edge = [a, b];
        free.then_some(Flip {
            edge,
            apexes,
            triangles,
        })
    }

    /// The third vertex of a triangle that runs along an edge in its direction.
    fn third(&self, triangle: u32, [from, to]: [u32; 2]) -> Option<u32> {
        let face = self.faces[triangle as usize];
        (0..3)
            .find(|at| face[*at] == from && face[(at + 1) % 3] == to)
            .map(|at| face[(at + 2) % 3])
    }

    /// Flips an edge.
    pub(super) fn flip(&mut self, flip: &Flip) {
        let [one, other] = flip.faces();
        let [first, second] = flip.triangles;
        self.faces[first as usize] = [NONE; 3];
        self.faces[second as usize] = [NONE; 3];
        for vertex in flip.edge.into_iter().chain(flip.apexes) {
            self.relink(vertex);
        }
        for (triangle, face) in [(first, one), (second, other)] {
            self.faces[triangle as usize] = face;
            for (corner, vertex) in (3 * triangle..).zip(face) {
                self.hang(corner, vertex);
            }
        }
    }

    /// How many triangles a vertex has.
    pub(super) fn degree(&self, vertex: u32) -> usize {
        self.triangles(vertex).count()
    }
}

/// An edge between two triangles, and what they become when it is flipped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flip {
    /// The edge, in the direction of the first triangle.
    pub(super) edge: [u32; 2],
    /// The third vertices of the two triangles.
    pub(super) apexes: [u32; 2],
    /// The triangles.
    triangles: [u32; 2],
}

impl Flip {
    /// The triangles after it.
    pub(super) fn faces(&self) -> [Face; 2] {
        let ([a, b], [c, d]) = (self.edge, self.apexes);
        [[a, d, c], [d, b, c]]
    }
}
