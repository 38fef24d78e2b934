//! One level up: neighbouring clusters in groups, each simplified to half within its border, and cut into clusters anew.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{Vec3, Vec4};
use meshopt::SimplifyOptions;
use rayon::prelude::*;

use super::local::{Clustered, Local, adapter};
use super::{Cluster, Joined, Levels, holding, wider};
use crate::mesh::Mesh;
use crate::mesh::display::direction;

/// Clusters of a group, about: the more, the more of it lies within its border and can be simplified.
const GROUP: usize = 16;
/// A group that keeps more than this share of its triangles stays as it is, and is grouped with others in the next level.
const WORTH_IT: f32 = 0.85;
/// How much a normal's turn counts beside a vertex's move, in parts of a group's size: scans have fine relief that is seen by its shading alone. By
/// pictures: with 0.05 relief of some pixels went, with 0.4 it was seen to go, with this it is not (`tests/picture/levels.rs`).
const NORMAL_WEIGHT: f32 = 1.0;

/// What levels are built of.
pub(super) struct Source<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) joined: Joined<'a>,
    /// Packed normals.
    pub(super) normals: &'a [u32],
}

impl Source<'_> {
    /// A triangle by joined vertices; none where it cannot be seen.
    pub(super) fn seen(&self, number: u32) -> Option<[u32; 3]> {
        let triangle = self.mesh.triangles.get(number as usize)?;
        let [a, b, c] = *triangle;
        let joined = |vertex: u32| {
            let joined = *self.joined.vertices.get(vertex as usize)?;
            let position = self.mesh.positions.get(joined as usize)?;
            position.is_finite().then_some(joined)
        };
        let corners = [joined(a)?, joined(b)?, joined(c)?];
        let [a, b, c] = corners.map(|vertex| self.joined.place(vertex));
        (a != b && b != c && c != a).then_some(corners)
    }

    pub(super) fn position(&self, vertex: u32) -> Vec3 {
        self.mesh
            .positions
            .get(vertex as usize)
            .copied()
            .unwrap_or_default()
    }
}

/// A group of clusters that became coarser.
struct Coarser {
    clustered: Clustered,
    /// What its clusters have in common.
    made: Cluster,
}

/// Makes the next level of these clusters, and returns the clusters that it consists of: new ones, and those that stay.
pub(super) fn coarser(
    levels: &mut Levels,
    source: &Source<'_>,
    pending: &[u32],
    at_any_cost: bool,
    cancel: &AtomicBool,
) -> Option<Vec<u32>> {
    let groups = groups(levels, source.mesh, pending);
    let owners = owners(levels, source, &groups);
    let mut next = Vec::new();
    // So many groups at a time, so that they do not stand beside the result all at once.
    for some in groups.chunks(4096) {
        let simplify = |group: &Vec<u32>| {
            (!cancel.load(Ordering::Relaxed))
                .then(|| simplified(levels, source, &owners, group, at_any_cost))
        };
        let done: Option<Vec<Option<Coarser>>> = some.par_iter().map(simplify).collect();
        for (group, coarser) in some.iter().zip(done?) {
            match coarser {
                Some(coarser) => next.extend(replace(levels, group, &coarser)),
                None => next.extend_from_slice(group),
            }
        }
    }
    Some(next)
}

/// Clusters that lie together, many vertices shared; in the order of their first clusters.
fn groups(levels: &Levels, mesh: &Mesh, pending: &[u32]) -> Vec<Vec<u32>> {
    let mut corners = Vec::new();
    let mut counts = Vec::with_capacity(pending.len());
    for cluster in pending {
        let triangles = triangles_of(levels, *cluster);
        corners.extend_from_slice(triangles.as_flattened());
        counts.push(u32::try_from(triangles.len() * 3).unwrap_or(u32::MAX));
    }
    let mut numbers = vec![0; pending.len()];
    let Some(adapter) = adapter(&mesh.positions) else {
        return Vec::new();
    };
    let count = meshopt::partition_clusters_with_positions(
        &mut numbers,
        &corners,
        &counts,
        &adapter,
        GROUP,
    );
    let mut groups = vec![Vec::new(); count];
    for (cluster, number) in pending.iter().zip(numbers) {
        if let Some(group) = groups.get_mut(number as usize) {
            group.push(*cluster);
        }
    }
    groups.retain(|group| !group.is_empty());
    groups
}

fn triangles_of(levels: &Levels, cluster: u32) -> &[[u32; 3]] {
    let cluster = levels.clusters.get(cluster as usize);
    cluster
        .and_then(|cluster| levels.triangles.get(cluster.triangles()))
        .unwrap_or_default()
}

const NOBODY: u32 = u32::MAX;
const SEVERAL: u32 = u32::MAX - 1;

/// For each place the group that has it, or [`SEVERAL`]: those may not move.
fn owners(levels: &Levels, source: &Source<'_>, groups: &[Vec<u32>]) -> Vec<u32> {
    let mut owners = vec![NOBODY; source.mesh.positions.len()];
    for (number, group) in (0_u32..).zip(groups) {
        for cluster in group {
            for vertex in triangles_of(levels, *cluster).as_flattened() {
                let place = source.joined.place(*vertex);
                if let Some(owner) = owners.get_mut(place as usize) {
                    *owner = match *owner {
                        NOBODY => number,
                        same if same == number => number,
                        _ => SEVERAL,
                    };
                }
            }
        }
    }
    owners
}

/// A group with about half as many triangles; none where that does not go.
fn simplified(
    levels: &Levels,
    source: &Source<'_>,
    owners: &[u32],
    group: &[u32],
    at_any_cost: bool,
) -> Option<Coarser> {
    let members = || {
        let cluster = |cluster: &u32| levels.clusters.get(*cluster as usize);
        group.iter().filter_map(cluster)
    };
    let mut triangles = Vec::new();
    let mut stood_for = Vec::new();
    for cluster in members() {
        triangles.extend_from_slice(levels.triangles.get(cluster.triangles())?);
        stood_for.extend_from_slice(levels.stands_for.get(cluster.triangles())?);
    }
    let local = Local::new(source.mesh, &triangles);
    let own = holding(members().map(|cluster| cluster.own));
    let (indices, error) = fewer(&local, source, owners)
        .or_else(|| at_any_cost.then(|| far_fewer(&local, own.w)).flatten())?;
    let most = |of: fn(&Cluster) -> f32| members().map(of).fold(0.0, f32::max);
    let own_error = wider(most(|cluster| cluster.own_error) + error);
    let own_grain = wider(most(|cluster| cluster.own_grain))
        .max(grain(&local, &indices))
        .max(own_error);
    if !(own.is_finite() && own_grain.is_finite()) {
        return None;
    }
    let stands_for = stand_ins(&local, &indices, &stood_for);
    Some(Coarser {
        clustered: local.clusters(&indices, &stands_for),
        made: Cluster {
            own,
            parent: own,
            own_error,
            own_grain,
            parent_error: -1.0,
            parent_grain: -1.0,
            ..Cluster::default()
        },
    })
}

/// Simplifies without tearing anything; the triangles and how far they are off.
fn fewer(local: &Local, source: &Source<'_>, owners: &[u32]) -> Option<(Vec<u32>, f32)> {
    let adapter = local.adapter()?;
    let locks: Vec<bool> = local
        .vertices
        .iter()
        .map(|vertex| {
            let place = source.joined.place(*vertex);
            owners.get(place as usize) == Some(&SEVERAL) || source.joined.is_border(*vertex)
        })
        .collect();
    let normal = |vertex: &u32| {
        let packed = source.normals.get(*vertex as usize).copied();
        direction(packed.unwrap_or(0)).to_array()
    };
    let normals: Vec<[f32; 3]> = local.vertices.iter().map(normal).collect();
    let mut error = 0.0;
    let indices = meshopt::simplify_with_attributes_and_locks(
        &local.indices,
        &adapter,
        normals.as_flattened(),
        &[NORMAL_WEIGHT; 3],
        size_of::<[f32; 3]>(),
        &locks,
        half(&local.indices),
        f32::MAX,
        SimplifyOptions::ErrorAbsolute,
        Some(&mut error),
    );
    is_worth_it(&indices, &local.indices).then_some((indices, error))
}

/// What is left where a mesh is mostly border, as loose triangles are: shapes are merged, or the smaller half of the triangles goes. Such a level is off
/// by as much as it is large, so it is drawn where it is a dot, or where a frame can hold no more.
fn far_fewer(local: &Local, radius: f32) -> Option<(Vec<u32>, f32)> {
    let adapter = local.adapter()?;
    let target = half(&local.indices);
    let merged = meshopt::simplify_sloppy(&local.indices, &adapter, target, f32::MAX, None);
    if !merged.is_empty() && is_worth_it(&merged, &local.indices) {
        return Some((merged, radius));
    }
    let (triangles, _) = local.indices.as_chunks::<3>();
    let mut by_size: Vec<_> = triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|vertex| local.position(vertex));
            ((b - a).cross(c - a).length(), *triangle)
        })
        .collect();
    by_size.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let kept: Vec<_> = by_size.iter().map(|(_, triangle)| *triangle).collect();
    let kept = kept.get(..(target / 3).max(1))?.as_flattened().to_vec();
    is_worth_it(&kept, &local.indices).then_some((kept, radius))
}

fn half(indices: &[u32]) -> usize {
    indices.len() / 6 * 3
}

fn is_worth_it(now: &[u32], before: &[u32]) -> bool {
    #[expect(clippy::cast_precision_loss, reason = "a few thousand")]
    let [now, before] = [now, before].map(|indices| indices.len() as f32);
    now > 0.0 && now <= before * WORTH_IT
}

/// How long triangles' longest edges are, square mean. In double precision, since squares of large coordinates are none in single.
fn grain(local: &Local, indices: &[u32]) -> f32 {
    let (triangles, _) = indices.as_chunks::<3>();
    let longest = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| local.position(vertex).as_dvec3());
        a.distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a))
    };
    let sum: f64 = triangles.iter().map(longest).sum();
    #[expect(clippy::cast_precision_loss, reason = "a few thousand")]
    let count = triangles.len().max(1) as f64;
    #[expect(clippy::cast_possible_truncation, reason = "a length of the mesh")]
    let grain = (sum / count).sqrt() as f32;
    grain
}

/// For each coarse triangle, what the fine one that shares a corner with it and lies nearest stands for.
fn stand_ins(local: &Local, coarse: &[u32], stood_for: &[u32]) -> Vec<u32> {
    let (fine, _) = local.indices.as_chunks::<3>();
    let middle = |triangle: &[u32; 3]| {
        let corners = triangle.map(|vertex| local.position(vertex) / 3.0);
        corners.into_iter().sum::<Vec3>()
    };
    // By vertex, its triangles: each vertex's end where the next one's begin.
    let mut ends = vec![0_usize; local.vertices.len() + 1];
    for vertex in &local.indices {
        if let Some(end) = ends.get_mut(*vertex as usize + 1) {
            *end += 1;
        }
    }
    let mut sum = 0;
    for end in &mut ends {
        sum += *end;
        *end = sum;
    }
    let mut next = ends.clone();
    let mut around = vec![0_usize; local.indices.len()];
    for (number, triangle) in fine.iter().enumerate() {
        for vertex in triangle {
            if let Some(at) = next.get_mut(*vertex as usize) {
                if let Some(place) = around.get_mut(*at) {
                    *place = number;
                }
                *at += 1;
            }
        }
    }
    let middles: Vec<Vec3> = fine.iter().map(middle).collect();
    let (coarse, _) = coarse.as_chunks::<3>();
    coarse
        .iter()
        .map(|triangle| {
            let at = middle(triangle);
            let candidates = triangle.iter().flat_map(|vertex| {
                let vertex = *vertex as usize;
                let run = ends.get(vertex).copied().zip(ends.get(vertex + 1).copied());
                let (first, end) = run.unwrap_or_default();
                around.get(first..end).unwrap_or_default()
            });
            // Of equally near ones the first; distances that are no number are the largest.
            let mut best = (f32::INFINITY, usize::MAX);
            for &number in candidates {
                let far = middles
                    .get(number)
                    .map_or(f32::INFINITY, |m| m.distance_squared(at));
                if far < best.0 || (far == best.0 && number < best.1) {
                    best = (far, number);
                }
            }
            stood_for.get(best.1).copied().unwrap_or(0)
        })
        .collect()
}

/// Adds a group's new clusters, which from now on are its old ones' parents; their numbers.
fn replace(levels: &mut Levels, group: &[u32], coarser: &Coarser) -> std::ops::Range<u32> {
    let number = |levels: &Levels| u32::try_from(levels.clusters.len()).unwrap_or(u32::MAX);
    let first = number(levels);
    let made = coarser.made;
    let cluster = |sphere: Vec4| Cluster { sphere, ..made };
    levels.push_all(&coarser.clustered, cluster);
    for cluster in group {
        if let Some(cluster) = levels.clusters.get_mut(*cluster as usize) {
            cluster.parent = made.own;
            cluster.parent_error = made.own_error;
            cluster.parent_grain = made.own_grain;
        }
    }
    first..number(levels)
}
