//! Non-manifold vertices: those whose triangles are more than one fan.
//!
//! From one triangle of a vertex one goes on over its edges to the neighbours until the way ends or is round; if that was not every
//! triangle of the vertex there is another fan. Ends of non-manifold edges are left out: there the edge is what is wrong.

use rayon::prelude::*;

use super::{Face, NONE, is_left_out};

/// Vertices of more than one fan, sorted.
pub(super) fn non_manifold_vertices(
    faces: &[Face],
    twins: &[u32],
    vertices: usize,
    left_out: &[u32],
) -> Vec<u32> {
    let mut degree = vec![0_u32; vertices];
    let mut corner_of = vec![NONE; vertices];
    for (triangle, face) in (0_u32..).zip(faces) {
        if is_left_out(face) {
            continue;
        }
        for (corner, vertex) in (3 * triangle..).zip(face) {
            degree[*vertex as usize] += 1;
            corner_of[*vertex as usize] = corner;
        }
    }
    for vertex in left_out {
        degree[*vertex as usize] = 0;
    }
    (0..u32::try_from(vertices).unwrap_or(NONE))
        .into_par_iter()
        .filter(|vertex| {
            let degree = degree[*vertex as usize];
            degree > 1 && fan(faces, twins, corner_of[*vertex as usize]) < degree
        })
        .collect()
}

/// Triangles of the fan that this corner is in.
fn fan(faces: &[Face], twins: &[u32], corner: u32) -> u32 {
    let (triangle, at) = (corner as usize / 3, corner as usize % 3);
    let vertex = faces[triangle][at];
    let (forward, round) = walk(faces, twins, vertex, triangle, at);
    match round {
        true => forward + 1,
        false => forward + 1 + walk(faces, twins, vertex, triangle, (at + 2) % 3).0,
    }
}

/// Goes round a vertex, leaving a triangle by an edge; the triangles that were entered before the way ended, and whether it came back.
fn walk(faces: &[Face], twins: &[u32], vertex: u32, start: usize, edge: usize) -> (u32, bool) {
    let (mut triangle, mut edge) = (start, edge);
    for entered in 0.. {
        let twin = twins[3 * triangle + edge];
        if twin == NONE {
            return (entered, false);
        }
        triangle = twin as usize / 3;
        if triangle == start {
            return (entered, true);
        }
        // By its other edge at the vertex, whichever way round the triangle is.
        let came_by = twin as usize % 3;
        let begins_here = faces[triangle][came_by] == vertex;
        edge = (came_by + if begins_here { 2 } else { 1 }) % 3;
    }
    (NONE, true)
}
