//! The few meshes that are drawn many times: rods' and balls' spheres, plates, controllers, tube batches.
//!
//! All are made once at start from formulas. Triangles run counter-clockwise seen from outside.

use std::f32::consts::{PI, TAU};

use ash::vk;
use bytemuck::{Pod, Zeroable};
use glam::{Quat, Vec3, Vec4};
use gpu_allocator::MemoryLocation;

use super::{error::RenderError, gpu::Gpu, memory::Buffer};
use crate::tree::levels::{
    BATCH,
    kinds::{ENDS, KINDS, SIDES},
};

/// A vertex of a solid: place and part of the model, normal.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Vertex {
    /// xyz, and the part: 0 body, 1 trigger, 2 dark, 3 light.
    place: Vec4,
    normal: Vec4,
}

/// A run of indices.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Run {
    pub(crate) first: u32,
    pub(crate) count: u32,
    /// Added to each index.
    pub(crate) vertex: i32,
}

/// Everything in three buffers.
pub(crate) struct Meshes {
    pub(crate) spheres: Buffer,
    pub(crate) solids: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) rod: Run,
    pub(crate) ball: Run,
    pub(crate) plate: Run,
    pub(crate) left: Run,
    pub(crate) right: Run,
}

impl Meshes {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let mut indices = tube_batches();
        let mut spheres: Vec<Vec4> = Vec::new();
        let mut add = |made: (Vec<Vec4>, Vec<u16>)| {
            let run = Run {
                first: index(indices.len()),
                count: index(made.1.len()),
                vertex: offset(spheres.len()),
            };
            indices.extend(made.1);
            spheres.extend(made.0);
            run
        };
        let rod = add(sphere(12, 3));
        let ball = add(sphere(24, 7));

        let mut solids: Vec<Vertex> = Vec::new();
        let mut add = |made: Solid, mirrored: bool| {
            let run = Run {
                first: index(indices.len()),
                count: index(made.indices.len()),
                vertex: offset(solids.len()),
            };
            // The left hand's model is the right one mirrored by the shader, so its triangles turn round.
            indices.extend(made.indices.chunks_exact(3).flat_map(|t| {
                if mirrored {
                    [t[0], t[2], t[1]]
                } else {
                    [t[0], t[1], t[2]]
                }
            }));
            solids.extend(made.vertices);
            run
        };
        let plate = add(plate(), false);
        let left = add(controller(), true);
        let right = add(controller(), false);

        let vertex = vk::BufferUsageFlags::VERTEX_BUFFER;
        Ok(Self {
            spheres: filled(gpu, "the spheres", vertex, &spheres)?,
            solids: filled(gpu, "the solids", vertex, &solids)?,
            indices: filled(
                gpu,
                "the indices",
                vk::BufferUsageFlags::INDEX_BUFFER,
                &indices,
            )?,
            rod,
            ball,
            plate,
            left,
            right,
        })
    }
}

/// A small buffer, which stays where the processor wrote it.
pub(crate) fn filled<T: bytemuck::NoUninit>(
    gpu: &Gpu,
    name: &'static str,
    usage: vk::BufferUsageFlags,
    data: &[T],
) -> Result<Buffer, RenderError> {
    let mut buffer = Buffer::new(
        gpu,
        name,
        size_of_val(data) as u64,
        usage,
        MemoryLocation::CpuToGpu,
    )?;
    buffer.write(0, data);
    Ok(buffer)
}

fn index(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

fn offset(n: usize) -> i32 {
    i32::try_from(n).unwrap_or(i32::MAX)
}

/// A mesh of at most 65,536 vertices.
fn short(n: u32) -> u16 {
    u16::try_from(n).unwrap_or(u16::MAX)
}

#[allow(clippy::cast_precision_loss, reason = "small counts")]
fn ratio(part: u32, whole: u32) -> f32 {
    part as f32 / whole as f32
}

/// Two triangles between neighbouring columns of two rows; see the module for the turn.
fn quad(low: u32, low_next: u32, high: u32, high_next: u32) -> [u16; 6] {
    [low_next, low, high, low_next, high, high_next].map(short)
}

/// A unit sphere whose equator is doubled: the upper half has w = 1 (sits at a rod's end), the lower w = 0.
fn sphere(sides: u32, rows: u32) -> (Vec<Vec4>, Vec<u16>) {
    let mut points = Vec::new();
    let mut indices = Vec::new();
    for row in 0..=2 * rows + 1 {
        let upper = row > rows;
        let step = if upper { row - 1 } else { row };
        let latitude = (ratio(step, 2 * rows) - 0.5) * PI;
        for side in 0..sides {
            let angle = TAU * ratio(side, sides);
            let reach = latitude.cos();
            points.push(Vec4::new(
                angle.cos() * reach,
                latitude.sin(),
                angle.sin() * reach,
                if upper { 1.0 } else { 0.0 },
            ));
            if row > 0 {
                let next = (side + 1) % sides;
                let (low, high) = ((row - 1) * sides, row * sides);
                indices.extend(quad(low + side, low + next, high + side, high + next));
            }
        }
    }
    (points, indices)
}

/// The indices of a batch of segments as each kind: tubes of each number of sides, then the ends of those that have some, as
/// [`of_tubes`](crate::tree::levels::kinds::of_tubes) counts them. They are the first of [`Meshes::indices`].
fn tube_batches() -> Vec<u16> {
    let tubes = SIDES.into_iter().flat_map(tube_indices);
    let ends = SIDES.into_iter().take(KINDS - ENDS);
    tubes.chain(ends.flat_map(cap_indices)).collect()
}

/// Indices of a batch of tubes, two rings of vertices each; of two sides: ribbons.
fn tube_indices(sides: u32) -> Vec<u16> {
    let quads = if sides == 2 { 1 } else { sides };
    (0..index(BATCH))
        .flat_map(|segment| {
            let first = segment * 2 * sides;
            (0..quads).flat_map(move |side| {
                let next = (side + 1) % sides;
                quad(
                    first + side,
                    first + next,
                    first + sides + side,
                    first + sides + next,
                )
            })
        })
        .collect()
}

/// Indices of a batch of ends: a ring and a tip each.
fn cap_indices(sides: u32) -> Vec<u16> {
    (0..index(BATCH))
        .flat_map(|cap| {
            let first = cap * (sides + 1);
            (0..sides).flat_map(move |side| {
                [first + (side + 1) % sides, first + side, first + sides].map(short)
            })
        })
        .collect()
}

#[derive(Default)]
struct Solid {
    vertices: Vec<Vertex>,
    indices: Vec<u16>,
}

impl Solid {
    fn vertex(&mut self, place: Vec3, normal: Vec3, part: f32) -> u32 {
        self.vertices.push(Vertex {
            place: place.extend(part),
            normal: normal.extend(0.0),
        });
        index(self.vertices.len() - 1)
    }

    /// Rows of points round an axis along the turned y: (radius, height, normal outward, normal upward).
    fn lathe(&mut self, profile: &[[f32; 4]], sides: u32, at: Vec3, turned: Quat, part: f32) {
        for (row, [radius, height, outward, upward]) in profile.iter().enumerate() {
            for side in 0..sides {
                let angle = TAU * ratio(side, sides);
                let around = Vec3::new(angle.cos(), 0.0, angle.sin());
                let place = at + turned * (around * *radius + Vec3::Y * *height);
                let normal = (turned * (around * *outward + Vec3::Y * *upward)).normalize_or_zero();
                let high = self.vertex(place, normal, part);
                if row > 0 {
                    let next = if side + 1 == sides {
                        high + 1 - sides
                    } else {
                        high + 1
                    };
                    self.indices
                        .extend(quad(high - sides, next - sides, high, next));
                }
            }
        }
        // The last ring's quads used `next` before it was there; indices do not mind.
    }

    fn ellipsoid(&mut self, center: Vec3, radii: Vec3, turned: Quat, part: f32) {
        let first = index(self.vertices.len());
        let (points, indices) = sphere(28, 8);
        for point in points {
            let unit = point.truncate();
            self.vertex(
                center + turned * (unit * radii),
                (turned * (unit / radii)).normalize_or_zero(),
                part,
            );
        }
        self.indices
            .extend(indices.into_iter().map(|i| short(u32::from(i) + first)));
    }

    /// A rounded cone along the turned y.
    fn capsule(&mut self, from: Vec3, to: Vec3, radii: [f32; 2], part: f32) {
        let axis = (to - from).normalize_or(Vec3::Y);
        let turned = Quat::from_rotation_arc(Vec3::Y, axis);
        let length = from.distance(to);
        let mut profile = Vec::new();
        for (end, base, radius) in [(0, 0.0, radii[0]), (1, length, radii[1])] {
            for step in 0..=4 {
                let latitude = (ratio(step, 4) - if end == 0 { 1.0 } else { 0.0 }) * PI / 2.0;
                let (sin, cos) = latitude.sin_cos();
                profile.push([cos * radius, base + sin * radius, cos, sin]);
            }
        }
        self.lathe(&profile, 16, from, turned, part);
    }

    fn torus(&mut self, center: Vec3, turned: Quat, radius: f32, tube: f32, part: f32) {
        let profile: Vec<[f32; 4]> = (0..=10)
            .map(|step| {
                let (sin, cos) = (TAU * ratio(step, 10) - PI).sin_cos();
                [radius + cos * tube, sin * tube, cos, sin]
            })
            .collect();
        self.lathe(&profile, 32, center, turned, part);
    }
}

/// The unit cylinder of `Plate`: radius 1, y from −1 to 0, with flat faces.
fn plate() -> Solid {
    let mut solid = Solid::default();
    let profile = [
        [0.0, -1.0, 0.0, -1.0],
        [1.0, -1.0, 0.0, -1.0],
        [1.0, -1.0, 1.0, 0.0],
        [1.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    solid.lathe(&profile, 72, Vec3::ZERO, Quat::IDENTITY, 0.0);
    solid
}

/// The right hand's controller about its grip pose: the handle along z, its head towards −Z, thumb on top (+Y).
fn controller() -> Solid {
    const BODY: f32 = 0.0;
    const TRIGGER: f32 = 1.0;
    const DARK: f32 = 2.0;
    const LIGHT: f32 = 3.0;
    let mut solid = Solid::default();
    let tilt = Quat::from_rotation_x(0.35);
    solid.capsule(
        Vec3::new(0.0, -0.004, 0.060),
        Vec3::new(0.0, 0.003, -0.030),
        [0.0145, 0.0185],
        BODY,
    );
    solid.ellipsoid(
        Vec3::new(0.0, 0.012, -0.048),
        Vec3::new(0.026, 0.015, 0.030),
        tilt,
        BODY,
    );
    solid.ellipsoid(
        Vec3::new(0.0, 0.0215, -0.048),
        Vec3::new(0.0185, 0.0085, 0.0215),
        tilt,
        DARK,
    );
    solid.torus(
        Vec3::new(0.0, 0.006, -0.070),
        Quat::from_rotation_x(0.75),
        0.044,
        0.0042,
        DARK,
    );
    solid.capsule(
        Vec3::new(-0.007, 0.024, -0.055),
        Vec3::new(-0.007, 0.0365, -0.0585),
        [0.0035, 0.0035],
        LIGHT,
    );
    solid.ellipsoid(
        Vec3::new(-0.007, 0.0375, -0.0590),
        Vec3::new(0.0075, 0.0026, 0.0075),
        tilt,
        LIGHT,
    );
    for (x, z) in [(0.009, -0.044), (0.010, -0.058)] {
        solid.ellipsoid(
            Vec3::new(x, 0.0292 - (z + 0.044) * 0.3, z),
            Vec3::new(0.0042, 0.0018, 0.0042),
            tilt,
            LIGHT,
        );
    }
    solid.ellipsoid(
        Vec3::new(0.0, -0.010, -0.046),
        Vec3::new(0.0085, 0.0100, 0.0150),
        Quat::from_rotation_x(-0.5),
        TRIGGER,
    );
    solid.capsule(
        Vec3::new(-0.013, -0.004, 0.010),
        Vec3::new(-0.015, -0.004, 0.026),
        [0.0055, 0.0055],
        DARK,
    );
    solid
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;
    use crate::tree::levels::kinds::{NONE, of_tubes};

    /// Volume by the divergence theorem: positive when the triangles turn outwards everywhere.
    fn volume(points: &[Vec3], indices: &[u16]) -> f32 {
        let at = |i: u16| points[usize::from(i)];
        indices
            .chunks_exact(3)
            .map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0)
            .sum()
    }

    #[test]
    fn meshes_are_closed_and_turn_outwards() {
        let (points, indices) = sphere(24, 8);
        let points: Vec<Vec3> = points.iter().map(|p| p.truncate()).collect();
        let found = volume(&points, &indices);
        assert!(
            (found - 4.0 / 3.0 * PI).abs() < 0.15,
            "a sphere's volume: {found}"
        );
        let made = plate();
        let points: Vec<Vec3> = made.vertices.iter().map(|v| v.place.truncate()).collect();
        let found = volume(&points, &made.indices);
        assert!((found - PI).abs() < 0.02, "a cylinder's volume: {found}");
        for made in [plate(), controller()] {
            for t in made.indices.chunks_exact(3) {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| made.vertices[usize::from(i)]);
                let p = |v: Vertex| v.place.truncate();
                let flat = (p(b) - p(a)).cross(p(c) - p(a));
                let mean = (a.normal + b.normal + c.normal).truncate();
                assert!(
                    flat.length() < 1e-12 || flat.dot(mean) > -1e-9,
                    "normals point to the outside"
                );
            }
        }
    }

    #[test]
    fn batches_stay_within_their_vertices() {
        let indices = tube_batches();
        let kinds = of_tubes();
        let sides = [16, 8, 5, 3, 2, 16, 8, 5];
        for (number, (kind, sides)) in kinds.iter().zip(sides).enumerate() {
            let run = kind.first as usize..(kind.first + kind.indices) as usize;
            let most = u32::from(*indices[run].iter().max().unwrap());
            let (vertices, triangles) = match number {
                4 => (4, 2),
                0..4 => (2 * sides, 2 * sides),
                _ => (sides + 1, sides),
            };
            assert_eq!((most, kind.indices), (8 * vertices - 1, 8 * 3 * triangles));
            assert_eq!(kind.ends, if number < 3 { index(number) + 5 } else { NONE });
        }
        assert_eq!(
            indices.len(),
            kinds
                .iter()
                .map(|kind| kind.indices as usize)
                .sum::<usize>()
        );
    }
}
