//! The finest level: the mesh itself in clusters.
//!
//! Triangles are sorted along a curve that fills space (Morton 1966) and cut into blocks, which all threads cluster at once: blocks have neighbours
//! on few sides, so few clusters are smaller for it.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::group::Source;
use super::local::{Clustered, Local};
use super::{Cluster, Levels};

/// Triangles of a block.
const BLOCK: usize = 1 << 14;
/// Steps of the curve along each axis: 2 to the power of this.
const BITS: u32 = 16;

pub(super) fn leaves(source: &Source<'_>, cancel: &AtomicBool) -> Option<Levels> {
    let order = order(source);
    if cancel.load(Ordering::Relaxed) {
        return None;
    }
    let block = |numbers: &[(u64, u32)]| {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let seen = |(_, number): &(u64, u32)| source.seen(*number).unwrap_or_default();
        let triangles: Vec<[u32; 3]> = numbers.iter().map(seen).collect();
        let original: Vec<u32> = numbers.iter().map(|(_, number)| *number).collect();
        let local = Local::new(source.mesh, &triangles);
        Some(local.clusters(&local.indices, &original))
    };
    let mut levels = Levels {
        triangles: Vec::with_capacity(2 * order.len()),
        stands_for: Vec::with_capacity(2 * order.len()),
        ..Levels::default()
    };
    // So many blocks at a time, so that they do not stand beside the result all at once.
    for blocks in order.chunks(BLOCK * 64) {
        let done: Vec<Option<Clustered>> = blocks.par_chunks(BLOCK).map(block).collect();
        for clustered in done.into_iter().collect::<Option<Vec<_>>>()? {
            levels.push_all(&clustered, |sphere| Cluster {
                sphere,
                own: sphere,
                parent: sphere,
                parent_error: -1.0,
                parent_grain: -1.0,
                ..Cluster::default()
            });
        }
    }
    Some(levels)
}

impl Levels {
    /// Adds clusters.
    pub(super) fn push_all(&mut self, clustered: &Clustered, cluster: impl Fn(Vec4) -> Cluster) {
        let mut first = self.triangles.len();
        self.triangles.extend_from_slice(&clustered.triangles);
        self.stands_for.extend_from_slice(&clustered.stands_for);
        for (count, sphere) in &clustered.clusters {
            self.clusters.push(Cluster {
                first: u32::try_from(first).unwrap_or(u32::MAX),
                count: u32::try_from(*count).unwrap_or(u32::MAX),
                ..cluster(*sphere)
            });
            first += count;
        }
    }
}

/// The triangles that can be seen along the curve, each with its place on it.
fn order(source: &Source<'_>) -> Vec<(u64, u32)> {
    let count = u32::try_from(source.mesh.triangles.len()).unwrap_or(u32::MAX);
    let middle = |number: u32| {
        let triangle = source.seen(number)?;
        let corner = |vertex: u32| source.position(vertex).as_dvec3() / 3.0;
        Some(triangle.map(corner).into_iter().sum::<DVec3>().as_vec3())
    };
    let middles = (0..count).into_par_iter().filter_map(middle);
    let (low, high) = middles.map(|at| (at, at)).reduce(
        || (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(low, high), (least, most)| (low.min(least), high.max(most)),
    );
    let size = (high.as_dvec3() - low.as_dvec3()).max_element();
    let scale = f64::from((1_u32 << BITS) - 1) / size.max(f64::MIN_POSITIVE);
    let place = |number: u32| {
        let step = (middle(number)?.as_dvec3() - low.as_dvec3()) * scale;
        // Casts saturate; what is no number becomes 0.
        #[expect(clippy::cast_possible_truncation, reason = "at most 65,535")]
        #[expect(clippy::cast_sign_loss, reason = "counted from the smallest")]
        let [x, y, z] = step.to_array().map(|part| spread(part as u16));
        Some((x | y << 1 | z << 2, number))
    };
    let mut order: Vec<_> = (0..count).into_par_iter().filter_map(place).collect();
    order.par_sort_unstable();
    order
}

/// The bits of a number, two free ones after each.
fn spread(part: u16) -> u64 {
    (0..BITS).fold(0, |spread, bit| {
        spread | u64::from(part >> bit & 1) << (3 * bit)
    })
}
