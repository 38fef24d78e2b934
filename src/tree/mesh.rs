//! The CPU twin of the tree's vertex shader: tube segments expanded to triangles.
//!
//! **The formula** (`shaders/tree.wgsl` repeats it). For a segment, growth g, n sides:
//!
//! ```text
//! grow(a, b)  = b if g ≥ 1 else a + g·(b − a)
//! center(p)   = grow(base, p) if GROWING else p                  for p = from, to
//! r0, r1      = grow(radii.x, radii.y), grow(radii.z, radii.w)
//! q(frame)    = normalize(frame / 32767)                          quaternion x y z w
//! slope       = clamp((r0 − r1) / max(|center(to) − center(from)|, 1e-9), −1, 1)
//!
//! side vertex, ring j = 0 or 1, corner s = 0…n, angle φ = 2π·(s mod n)/n:
//!   out       = q(frame_j)·(cos φ, 0, sin φ)
//!   along     = q(frame_j)·(0, 1, 0)
//!   position  = center_j + r_j·out
//!   normal    = normalize(out + slope·along)
//!   uv        = (AROUND·s/n, AROUND·v_j)
//! side triangles, s = 0…n−1, a = (0,s), b = (0,s+1), c = (1,s), d = (1,s+1):  a c b,  b c d
//!
//! end cap, where CAPPED, corner s = 0…n−1 (the side vertices of ring 1 and n apex vertices):
//!   apex      = center_1 + CAP_HEIGHT·r1·along,  normal = along,  uv = (AROUND·(s + ½)/n, AROUND·(v_1 + CAP_HEIGHT/2π))
//!   triangle    (1,s+1)  (1,s)  apex_s
//! start disc, where STARTS (n + 1 vertices of its own):
//!   middle    = center_0, corners as ring 0;  normal = −along;  uv = (½ + ½·cos φ, ½ + ½·sin φ)
//!   triangle    corner_s  corner_s+1  middle
//! ```
//!
//! Corner n is corner 0 again with another u (the texture's seam), at bit-equal position. Triangles are counter-clockwise
//! from outside. The normal of corners on a shared ring differs between its two segments only by the
//! taper's `slope`, so tubes look smooth. The slope is 1e-9-guarded because at g = 0 new segments have no length.

use std::f32::consts::TAU;

use glam::{DVec3, Quat, Vec3};

use super::growth::{clamp_growth, grow, grow_point};
use super::tubes::{CAPPED, GROWING, STARTS, TubeSegment, unpack_frame};

/// How often the bark's texture repeats around a tube (and so in each circumference along it).
pub const AROUND: f32 = 2.0;

/// Height of the cone that closes a tube, in radii.
pub const CAP_HEIGHT: f32 = 0.75;

/// Fewest and most corners of a ring.
pub const SIDES: std::ops::RangeInclusive<u32> = 3..=64;

/// Triangles with smooth normals and texture coordinates; all vertex arrays have one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TubeMesh {
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors, outward.
    pub normals: Vec<[f32; 3]>,
    /// u around the tube, v along it, in repeats of the texture (not flipped: v grows towards the tip).
    pub uvs: Vec<[f32; 2]>,
    /// Three a triangle, counter-clockwise from outside.
    pub indices: Vec<u32>,
}

/// Most vertices that a segment of a mesh with so many sides can need.
pub fn vertices_per_segment(sides: u32) -> u64 {
    let sides = u64::from(sides);
    2 * (sides + 1) + sides + (sides + 1)
}

/// Expands segments at a growth in 0…1 with `sides` corners a ring (clamped to [`SIDES`]).
///
/// Stops before a vertex index would not fit u32 (238 million segments of 8 sides); the exporters refuse such trees before.
pub fn mesh(segments: &[TubeSegment], growth: f32, sides: u32) -> TubeMesh {
    let sides = sides.clamp(*SIDES.start(), *SIDES.end());
    let growth = clamp_growth(growth);
    let circle = Circle::new(sides);
    let mut mesh = TubeMesh::default();
    let corners = sides as usize + 1;
    let [starts, caps] = [STARTS, CAPPED].map(|flag| {
        segments
            .iter()
            .filter(|segment| segment.flags & flag != 0)
            .count()
    });
    let vertices = segments.len() * 2 * corners + caps * (corners - 1) + starts * corners;
    mesh.positions.reserve_exact(vertices);
    mesh.normals.reserve_exact(vertices);
    mesh.uvs.reserve_exact(vertices);
    mesh.indices
        .reserve_exact(3 * (corners - 1) * (2 * segments.len() + caps + starts));
    for segment in segments {
        if mesh.positions.len() as u64 + vertices_per_segment(sides) > u64::from(u32::MAX) {
            break;
        }
        mesh.add_segment(segment, growth, &circle);
    }
    mesh
}

/// The corners' directions in a ring's own frame, 0 to n − 1.
struct Circle {
    sides: u32,
    corners: Vec<Vec3>,
}

impl Circle {
    fn new(sides: u32) -> Self {
        // In f64, so that f32 has the same bits on every machine, whatever the last digit of its sine.
        let corner = |s: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(s) / f64::from(sides)).sin_cos();
            DVec3::new(cos, 0.0, sin).as_vec3()
        };
        Self {
            sides,
            corners: (0..sides).map(corner).collect(),
        }
    }

    /// Corners 0 to n, the last being the first again, each with its part of a turn.
    fn seam(&self) -> impl Iterator<Item = (f32, Vec3)> {
        let sides = self.corners.len();
        #[allow(clippy::cast_precision_loss, reason = "at most 64")]
        (0..=sides).map(move |s| (s as f32 / sides as f32, self.corners[s % sides]))
    }
}

/// A ring at some growth.
struct Ring {
    center: Vec3,
    radius: f32,
    frame: Quat,
    v: f32,
}

impl TubeMesh {
    /// Smallest and largest coordinates; both 0 for an empty mesh.
    pub fn bounds(&self) -> ([f32; 3], [f32; 3]) {
        let first = self
            .positions
            .first()
            .copied()
            .map_or(Vec3::ZERO, Vec3::from);
        let (low, high) = self
            .positions
            .iter()
            .map(|&p| Vec3::from(p))
            .fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
        (low.to_array(), high.to_array())
    }

    fn add_segment(&mut self, segment: &TubeSegment, growth: f32, circle: &Circle) {
        let center = |point: [f32; 3]| match segment.flags & GROWING {
            0 => Vec3::from(point),
            _ => grow_point(segment.base.into(), point.into(), growth),
        };
        let [before_0, after_0, before_1, after_1] = segment.radii;
        let rings = [
            Ring {
                center: center(segment.from),
                radius: grow(before_0, after_0, growth),
                frame: unpack_frame(segment.from_frame),
                v: segment.v_from,
            },
            Ring {
                center: center(segment.to),
                radius: grow(before_1, after_1, growth),
                frame: unpack_frame(segment.to_frame),
                v: segment.v_to,
            },
        ];
        let length = rings[0].center.distance(rings[1].center);
        let slope = ((rings[0].radius - rings[1].radius) / length.max(1e-9)).clamp(-1.0, 1.0);

        let first = self.next_index();
        let sides = circle.sides;
        for ring in &rings {
            let along = ring.frame * Vec3::Y;
            for (turn, corner) in circle.seam() {
                let out = ring.frame * corner;
                self.vertex(
                    ring.center + ring.radius * out,
                    (out + slope * along).normalize(),
                    [AROUND * turn, AROUND * ring.v],
                );
            }
        }
        for s in first..first + sides {
            let [a, b, c, d] = [s, s + 1, s + sides + 1, s + sides + 2];
            self.indices.extend([a, c, b, b, c, d]);
        }
        if segment.flags & CAPPED != 0 {
            self.add_cap(&rings[1], first + sides + 1, circle);
        }
        if segment.flags & STARTS != 0 {
            self.add_disc(&rings[0], circle);
        }
    }

    /// A cone on a ring whose corners stand from index `corner` on.
    fn add_cap(&mut self, ring: &Ring, corner: u32, circle: &Circle) {
        let along = ring.frame * Vec3::Y;
        let top = ring.center + CAP_HEIGHT * ring.radius * along;
        #[allow(clippy::cast_precision_loss, reason = "at most 64")]
        let half_corner = 0.5 / circle.corners.len() as f32;
        let first = self.next_index();
        for (turn, _) in circle.seam().take(circle.corners.len()) {
            self.vertex(
                top,
                along,
                [
                    AROUND * (turn + half_corner),
                    AROUND * (ring.v + CAP_HEIGHT / TAU),
                ],
            );
        }
        for s in 0..circle.sides {
            self.indices.extend([corner + s + 1, corner + s, first + s]);
        }
    }

    /// A flat disc that closes a tube's first ring.
    fn add_disc(&mut self, ring: &Ring, circle: &Circle) {
        let normal = ring.frame * Vec3::NEG_Y;
        let first = self.next_index();
        for &corner in &circle.corners {
            self.vertex(
                ring.center + ring.radius * (ring.frame * corner),
                normal,
                [0.5 + 0.5 * corner.x, 0.5 + 0.5 * corner.z],
            );
        }
        self.vertex(ring.center, normal, [0.5, 0.5]);
        for s in 0..circle.sides {
            self.indices.extend([
                first + s,
                first + (s + 1) % circle.sides,
                first + circle.sides,
            ]);
        }
    }

    fn vertex(&mut self, position: Vec3, normal: Vec3, uv: [f32; 2]) {
        self.positions.push(position.to_array());
        self.normals.push(normal.to_array());
        self.uvs.push(uv);
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "`mesh` stops before indices leave u32"
    )]
    fn next_index(&self) -> u32 {
        self.positions.len() as u32
    }
}
