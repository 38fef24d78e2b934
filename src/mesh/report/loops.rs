//! Boundary loops: where a surface ends.
//!
//! Edges of one triangle are strung together end to end. Where more than two of them meet in a vertex, a way that comes back to a vertex
//! is cut off there as a loop, so every loop passes each of its vertices once.

use std::ops::Range;

use glam::DVec3;

use crate::mesh::Mesh;

/// An open end: edges with one triangle, strung together.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundaryLoop {
    /// Its vertices in [`super::Report::loop_vertices`], in the direction of the first edge's triangle.
    pub vertices: Range<usize>,
    /// Whether it comes back to where it began; else non-manifold edges interrupt it, and it has one edge fewer than vertices.
    pub closed: bool,
    /// How long it is, in the file's unit.
    pub length: f64,
    /// Centre of the line (not of what it encloses), in the file's unit.
    pub centre: DVec3,
    /// The component that it is of, as in [`super::Report::components`].
    pub component: u32,
}

impl BoundaryLoop {
    /// How many edges it has.
    pub fn edges(&self) -> usize {
        self.vertices.len() - usize::from(!self.closed)
    }
}

/// A way along boundary edges.
#[derive(Debug, PartialEq)]
pub(super) struct Way {
    pub(super) vertices: Vec<u32>,
    pub(super) closed: bool,
    /// One of its edges.
    pub(super) edge: usize,
}

/// Length and centre of a way, in the file's unit.
pub(super) fn length_and_centre(mesh: &Mesh, way: &Way) -> (f64, DVec3) {
    let point = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
    let start = way.vertices.first().copied();
    let ends = way.vertices[1..].iter().copied();
    let ends = ends.chain(start.filter(|_| way.closed));
    let (mut length, mut moment) = (0.0, DVec3::ZERO);
    for (from, to) in way.vertices.iter().zip(ends) {
        let (from, to) = (point(*from), point(to));
        length += from.distance(to);
        moment += from.distance(to) * from.midpoint(to);
    }
    let centre = match length > 0.0 {
        true => moment / length,
        false => start.map_or(DVec3::ZERO, point),
    };
    (length, mesh.origin + centre)
}

/// Strings edges together. The ways come in the order of their first edges.
pub(super) fn ways(edges: &[[u32; 2]]) -> Vec<Way> {
    Walker::new(edges).ways()
}

struct Walker<'a> {
    edges: &'a [[u32; 2]],
    /// Every vertex that edges end in, sorted.
    vertices: Vec<u32>,
    /// Where the ends at each vertex begin in `ends`.
    starts: Vec<usize>,
    /// Edges by vertex.
    ends: Vec<usize>,
    walked: Vec<bool>,
    /// From where on in `ends` each vertex may have an edge that is not walked.
    fresh: Vec<usize>,
    /// Where in the present way each vertex stands.
    place: Vec<Option<usize>>,
}

impl<'a> Walker<'a> {
    fn new(edges: &'a [[u32; 2]]) -> Self {
        let mut by_vertex: Vec<(u32, usize)> = edges
            .iter()
            .enumerate()
            .flat_map(|(edge, ends)| ends.map(|vertex| (vertex, edge)))
            .collect();
        by_vertex.sort_unstable();
        let (mut vertices, mut starts) = (Vec::new(), Vec::new());
        for (at, (vertex, _)) in by_vertex.iter().enumerate() {
            if vertices.last() != Some(vertex) {
                vertices.push(*vertex);
                starts.push(at);
            }
        }
        starts.push(by_vertex.len());
        Self {
            edges,
            walked: vec![false; edges.len()],
            place: vec![None; vertices.len()],
            vertices,
            fresh: starts.clone(),
            starts,
            ends: by_vertex.into_iter().map(|(_, edge)| edge).collect(),
        }
    }

    fn ways(&mut self) -> Vec<Way> {
        let mut found = Vec::new();
        for edge in 0..self.edges.len() {
            if !self.walked[edge] {
                self.walk(edge, &mut found);
            }
        }
        found
    }

    /// Follows unwalked edges from this one until there are none.
    fn walk(&mut self, edge: usize, found: &mut Vec<Way>) {
        let [from, _] = self.edges[edge];
        // Vertices, each with the edge that led to it.
        let mut way = vec![(from, edge)];
        let mut at = self.number(from);
        self.place[at] = Some(0);
        let mut next = Some(edge);
        while let Some(edge) = next {
            self.walked[edge] = true;
            let [a, b] = self.edges[edge];
            let to = if a == self.vertices[at] { b } else { a };
            at = self.number(to);
            match self.place[at] {
                Some(place) => found.push(Way {
                    vertices: self.cut(&mut way, place),
                    closed: true,
                    edge,
                }),
                None => {
                    self.place[at] = Some(way.len());
                    way.push((to, edge));
                }
            }
            next = self.fresh_edge(at);
        }
        for (vertex, _) in &way {
            let at = self.number(*vertex);
            self.place[at] = None;
        }
        if let [_, (_, edge), ..] = way[..] {
            found.push(Way {
                vertices: way.into_iter().map(|(vertex, _)| vertex).collect(),
                closed: false,
                edge,
            });
        }
    }

    /// An edge at a vertex that was not walked.
    fn fresh_edge(&mut self, at: usize) -> Option<usize> {
        while self.fresh[at] < self.starts[at + 1] {
            let edge = self.ends[self.fresh[at]];
            if !self.walked[edge] {
                return Some(edge);
            }
            self.fresh[at] += 1;
        }
        None
    }

    /// Takes a loop off the end of a way; its first vertex stays on the way too.
    fn cut(&mut self, way: &mut Vec<(u32, usize)>, place: usize) -> Vec<u32> {
        let round = way.split_off(place);
        for (vertex, _) in &round[1..] {
            let at = self.number(*vertex);
            self.place[at] = None;
        }
        way.push(round[0]);
        round.into_iter().map(|(vertex, _)| vertex).collect()
    }

    fn number(&self, vertex: u32) -> usize {
        self.vertices.partition_point(|other| *other < vertex)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use proptest::prelude::*;

    use super::*;

    /// Edges, and the ways along them with whether each is closed.
    type Case = (&'static [[u32; 2]], &'static [(&'static [u32], bool)]);

    #[test]
    fn loops_are_cut_where_they_touch() {
        let table: &[Case] = &[
            (&[], &[]),
            (&[[5, 7], [7, 9], [9, 5]], &[(&[5, 7, 9], true)]),
            // A figure of eight, begun away from its waist.
            (
                &[[1, 0], [0, 2], [2, 1], [0, 3], [3, 4], [4, 0]],
                &[(&[1, 0, 2], true), (&[0, 3, 4], true)],
            ),
            (
                &[[1, 0], [0, 3], [3, 4], [4, 0], [0, 2], [2, 1]],
                &[(&[0, 3, 4], true), (&[1, 0, 2], true)],
            ),
            (&[[1, 2], [2, 3]], &[(&[1, 2, 3], false)]),
            (&[[1, 2], [3, 4], [3, 2], [4, 1]], &[(&[1, 2, 3, 4], true)]),
        ];
        for (edges, expected) in table {
            let found: Vec<_> = ways(edges)
                .into_iter()
                .map(|way| (way.vertices, way.closed))
                .collect();
            let expected: Vec<_> = expected.iter().map(|(w, c)| (w.to_vec(), *c)).collect();
            assert_eq!(found, expected, "{edges:?}");
        }
    }

    proptest! {
        #[test]
        fn every_edge_is_walked_once_and_no_vertex_twice(
            edges in prop::collection::btree_set((0_u32..12, 0_u32..12), 0..40)
        ) {
            let edges: Vec<[u32; 2]> = edges.into_iter().filter(|(a, b)| a < b).map(|(a, b)| [a, b]).collect();
            let mut walked = Vec::new();
            for Way { vertices: way, closed, edge } in ways(&edges) {
                prop_assert!(edges[edge].iter().all(|end| way.contains(end)));
                let round = way.iter().copied().chain(closed.then_some(way[0]));
                let round: Vec<u32> = round.collect();
                walked.extend(round.windows(2).map(|e| [e[0].min(e[1]), e[0].max(e[1])]));
                let mut once = way.clone();
                once.sort_unstable();
                once.dedup();
                prop_assert_eq!(once.len(), way.len());
            }
            walked.sort_unstable();
            prop_assert_eq!(walked, edges);
        }
    }
}
