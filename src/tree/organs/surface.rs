//! Surfaces that a grammar places with `~`: shapes made here from formulas, and outlines that a grammar draws itself.
//!
//! A surface lies in the turtle's own axes, x right, y ahead, z up, and is about 1 long: the turtle stands at its foot.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

use super::look::{BROWN, Colour, from_bytes};
use super::polygon::Triangulator;

/// Names of the shapes that need no outline.
pub const BUILT_IN: [&str; 18] = [
    "leaf", "needle", "petal", "flower", "bell", "disc", "sphere", "cone", "maple", "oak", "birch",
    "willow", "ovate", "needles", "pinnule", "spines", "blossom", "fruit",
];

/// Leaf green, sRGB: the own colour of leaves and polygons.
pub(super) const GREEN: [u8; 3] = [92, 146, 52];

/// The colour of a part of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Its own colour, linear.
    pub colour: Colour,
    /// It keeps its colour whatever the turtle's is (a flower's heart).
    pub fixed: bool,
}

/// A surface in the turtle's axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Vertices.
    pub positions: Vec<Vec3>,
    /// Unit normals, one a vertex.
    pub normals: Vec<Vec3>,
    /// Index into `tones`, one a vertex.
    pub tone: Vec<u8>,
    /// Three a triangle, counter-clockwise seen against the normals.
    pub indices: Vec<u32>,
    /// Colours.
    pub tones: Vec<Tone>,
    /// A sheet with two sides, such as a leaf; else it is closed.
    pub thin: bool,
    /// How far its normals are those of the crown that it stands in, 0 to 1.
    pub rounded: f32,
}

impl Surface {
    /// One of [`BUILT_IN`], by its name.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        Some(match name {
            "leaf" => Self::leaf(),
            "needle" => Self::needle(),
            "petal" => Self::petal(),
            "flower" => Self::flower(),
            "bell" => Self::bell(),
            "disc" => Self::disc(),
            "sphere" => {
                let mut made = Self::new([186, 40, 32], false);
                made.ball(Vec3::Y * 0.5, Vec3::splat(0.5), 16, 10, 0);
                made
            }
            "cone" => Self::cone(),
            "maple" => Self::maple(),
            "oak" => Self::oak(),
            "birch" => Self::birch(),
            "willow" => Self::willow(),
            "ovate" => Self::ovate(),
            "needles" => Self::needles(),
            "pinnule" => Self::pinnule(),
            "spines" => Self::spines(),
            "blossom" => Self::blossom(),
            "fruit" => Self::fruit(),
            _ => return None,
        })
    }

    /// A flat outline; `None` where its corners span no area.
    #[must_use]
    pub fn outline(corners: &[Vec3]) -> Option<Self> {
        let mut made = Self::new(GREEN, true);
        let normal = Triangulator::default().add(corners, &mut made.indices)?;
        made.positions.extend_from_slice(corners);
        made.normals.resize(corners.len(), normal);
        made.tone.resize(corners.len(), 0);
        Some(made)
    }

    pub(super) fn new(own: [u8; 3], thin: bool) -> Self {
        Self {
            tones: vec![Tone {
                colour: from_bytes(own),
                fixed: false,
            }],
            thin,
            ..Self::default()
        }
    }

    fn leaf() -> Self {
        let mut made = Self::new(GREEN, true);
        // Ovate: widest at a third of its length; folded along its rib, its tip drooping.
        made.blade(10, |t, side| {
            let half = 0.27 * (PI * t.powf(0.72)).sin().max(0.0).powf(0.85);
            let across = side * half;
            Vec3::new(across, t, 0.32 * across.abs() - 0.20 * t * t)
        });
        made
    }

    fn needle() -> Self {
        let mut made = Self::new([52, 104, 56], true);
        made.blade(4, |t, side| {
            let across = side * 0.022 * (PI * (0.08 + 0.92 * t)).sin().max(0.0);
            Vec3::new(across, t, 0.5 * across.abs() - 0.04 * t * t)
        });
        made
    }

    fn petal() -> Self {
        let mut made = Self::new([240, 160, 186], true);
        made.blade(8, |t, side| petal(t, side, 0.36));
        made
    }

    /// Five petals that open ahead, and a yellow heart.
    fn flower() -> Self {
        let mut made = Self::new([246, 222, 232], true);
        for turn in 0..5_u8 {
            let (sin, cos) = (TAU * f32::from(turn) / 5.0).sin_cos();
            made.blade(6, |t, side| {
                let p = petal(t, side, 0.40);
                // The petal's length leads outward and a little ahead; its face looks ahead.
                let out = 0.05 + 0.45 * p.y;
                let ahead = 0.12 + 0.16 * p.y + 0.45 * p.z;
                let across = 0.5 * p.x;
                Vec3::new(out * cos - across * sin, ahead, out * sin + across * cos)
            });
        }
        made.tones.push(Tone {
            colour: from_bytes([238, 188, 40]),
            fixed: true,
        });
        made.ball(Vec3::Y * 0.13, Vec3::new(0.105, 0.075, 0.105), 10, 6, 1);
        made
    }

    /// A bell with six lobes that opens ahead.
    fn bell() -> Self {
        let mut made = Self::new([246, 244, 234], true);
        let (rows, sides) = (8_u8, 24_u8);
        for row in 0..=rows {
            let t = f32::from(row) / f32::from(rows);
            let body = 0.36 * (1.0 - (1.0 - (t * 1.5).min(1.0)).powi(2)).sqrt();
            let flare = 0.14 * ((t - 0.7).max(0.0) / 0.3).powi(2);
            for side in 0..=sides {
                let angle = TAU * f32::from(side % sides) / f32::from(sides);
                let lobe = 0.10 * ((t - 0.7).max(0.0) / 0.3) * (6.0 * angle).cos();
                let radius = body + flare;
                made.positions.push(Vec3::new(
                    radius * angle.cos(),
                    0.85 * t + lobe,
                    radius * angle.sin(),
                ));
            }
        }
        made.grid(0, rows, sides + 1);
        made
    }

    /// A flat round plate round the turtle that faces ahead.
    fn disc() -> Self {
        let mut made = Self::new(GREEN, true);
        let sides = 32_u8;
        made.vertex(Vec3::ZERO, Vec3::Y, 0);
        for side in 0..sides {
            let angle = TAU * f32::from(side) / f32::from(sides);
            made.vertex(
                Vec3::new(0.5 * angle.cos(), 0.0, 0.5 * angle.sin()),
                Vec3::Y,
                0,
            );
            let (this, next) = (u32::from(side), u32::from((side + 1) % sides));
            made.indices.extend([0, next + 1, this + 1]);
        }
        made
    }

    fn cone() -> Self {
        let mut made = Self::new(BROWN, false);
        let sides = 20_u8;
        for side in 0..sides {
            let turn = |side: f32| TAU * side / f32::from(sides);
            let side = f32::from(side);
            let [a, b] = [turn(side), turn(side + 1.0)]
                .map(|angle| Vec3::new(0.25 * angle.cos(), 0.0, 0.25 * angle.sin()));
            let slope = |p: Vec3| (p * 4.0 + Vec3::Y * 0.25).normalize();
            made.triangle([(a, slope(a)), (Vec3::Y, slope(a + b)), (b, slope(b))]);
            made.triangle([
                (a, Vec3::NEG_Y),
                (b, Vec3::NEG_Y),
                (Vec3::ZERO, Vec3::NEG_Y),
            ]);
        }
        made
    }

    fn vertex(&mut self, position: Vec3, normal: Vec3, tone: u8) {
        self.positions.push(position);
        self.normals.push(normal);
        self.tone.push(tone);
    }

    fn triangle(&mut self, corners: [(Vec3, Vec3); 3]) {
        for (position, normal) in corners {
            self.indices.push(index(self.positions.len()));
            self.vertex(position, normal, 0);
        }
    }

    /// A sheet of five columns (side −1 … 1) from its foot (t = 0) to its tip (1).
    fn blade(&mut self, rows: u8, place: impl Fn(f32, f32) -> Vec3) {
        let first = self.positions.len();
        for row in 0..=rows {
            let t = f32::from(row) / f32::from(rows);
            for side in [-1.0, -0.5, 0.0, 0.5, 1.0] {
                self.positions.push(place(t, side));
            }
        }
        self.grid(first, rows, 5);
    }

    /// Triangles and smooth normals of a grid of positions from `first` on, of tone 0.
    fn grid(&mut self, first: usize, rows: u8, columns: u8) {
        let (start, width) = (index(first), u32::from(columns));
        let triangles = self.indices.len();
        for row in 0..u32::from(rows) {
            for column in 0..width - 1 {
                let a = start + row * width + column;
                let [b, c, d] = [a + 1, a + width, a + width + 1];
                self.indices.extend([a, b, c, c, b, d]);
            }
        }
        let mut normals = vec![Vec3::ZERO; self.positions.len() - first];
        let place = |i: u32| self.positions.get(i as usize).copied().unwrap_or_default();
        for corners in self.indices[triangles..].chunks_exact(3) {
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(place);
            for corner in corners {
                if let Some(normal) = normals.get_mut(*corner as usize - first) {
                    *normal += (b - a).cross(c - a);
                }
            }
        }
        // At a point where a whole row meets, the triangles have no area: the row before knows.
        let width = usize::from(columns);
        for at in 0..normals.len() {
            if normals[at].length_squared() < 1e-14 {
                let other = if at >= width { at - width } else { at + width };
                normals[at] = normals.get(other).copied().unwrap_or(Vec3::Z);
            }
            normals[at] = normals[at].normalize_or(Vec3::Z);
        }
        self.normals.extend(normals);
        self.tone.resize(self.positions.len(), 0);
    }

    /// One triangle of its own, its normal from [`Self::smooth`].
    pub(super) fn sheet(&mut self, corners: [Vec3; 3]) {
        for corner in corners {
            self.indices.push(index(self.positions.len()));
            self.positions.push(corner);
        }
    }

    /// A fan of triangles from `center` along an outline; the other way round where it is `mirrored`.
    pub(super) fn fan(&mut self, center: Vec3, outline: &[Vec3], mirrored: bool) {
        let first = index(self.positions.len());
        self.positions.push(center);
        self.positions.extend_from_slice(outline);
        for at in 1..index(outline.len()) {
            let [a, b] = if mirrored { [at + 1, at] } else { [at, at + 1] };
            self.indices.extend([first, first + a, first + b]);
        }
    }

    /// The triangles between two rows of rib and edge; those of no area are left out.
    pub(super) fn strip(&mut self, last: [Vec3; 2], next: [Vec3; 2], mirrored: bool) {
        let first = index(self.positions.len());
        self.positions.extend([last[0], last[1], next[0], next[1]]);
        let mut add = |[a, b, c]: [u32; 3]| {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            self.indices.extend(corners.map(|at| first + at));
        };
        if last[0] != last[1] {
            add([0, 1, 2]);
        }
        if next[0] != next[1] {
            add(if last[0] == last[1] {
                [0, 3, 2]
            } else {
                [1, 3, 2]
            });
        }
    }

    /// A flat heart of six corners that looks ahead, of a colour that stays.
    pub(super) fn heart(&mut self, colour: [u8; 3], ahead: f32, radius: f32) {
        self.smooth();
        self.tones.push(Tone {
            colour: from_bytes(colour),
            fixed: true,
        });
        let at = |side: u8| {
            let (sin, cos) = (TAU * f32::from(side) / 6.0).sin_cos();
            Vec3::new(radius * cos, ahead, -radius * sin)
        };
        self.fan(
            Vec3::Y * (ahead + 0.04),
            &(0..=6).map(at).collect::<Vec<_>>(),
            false,
        );
        self.tone.resize(self.positions.len(), 1);
    }

    /// Makes vertices that lie in one place with one normal and one tone one vertex.
    pub(super) fn weld(&mut self) {
        let mut number_of = std::collections::HashMap::new();
        let (positions, normals, tones) = (
            std::mem::take(&mut self.positions),
            std::mem::take(&mut self.normals),
            std::mem::take(&mut self.tone),
        );
        let mut numbers = Vec::with_capacity(positions.len());
        for ((position, normal), tone) in positions.iter().zip(&normals).zip(&tones) {
            let key =
                [position.to_array(), normal.to_array()].map(|v| v.map(|x| (x + 0.0).to_bits()));
            let next = index(self.positions.len());
            let number = *number_of.entry((key, *tone)).or_insert(next);
            if number == next {
                self.vertex(*position, *normal, *tone);
            }
            numbers.push(number);
        }
        for at in &mut self.indices {
            *at = numbers.get(*at as usize).copied().unwrap_or(0);
        }
    }

    /// Normals of what has none yet, the same at vertices that lie in one place; vertices nothing uses point up.
    pub(in crate::tree) fn smooth(&mut self) {
        let done = self.normals.len();
        let place = |i: u32| self.positions.get(i as usize).copied().unwrap_or_default();
        let mut sums: std::collections::HashMap<[u32; 3], Vec3> = std::collections::HashMap::new();
        let key = |p: Vec3| p.to_array().map(|x| (x + 0.0).to_bits());
        for corners in self.indices.chunks_exact(3) {
            if corners.iter().any(|i| (*i as usize) < done) {
                continue;
            }
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(place);
            let normal = (b - a).cross(c - a);
            for corner in [a, b, c] {
                *sums.entry(key(corner)).or_default() += normal;
            }
        }
        for position in &self.positions[done..] {
            let sum = sums.get(&key(*position)).copied().unwrap_or_default();
            self.normals.push(sum.normalize_or(Vec3::Z));
        }
        self.tone.resize(self.positions.len(), 0);
    }

    /// An ellipsoid.
    pub(super) fn ball(&mut self, center: Vec3, radii: Vec3, sides: u32, rows: u32, tone: u8) {
        let first = index(self.positions.len());
        for (unit, _) in unit_sphere(sides, rows) {
            self.vertex(center + unit * radii, (unit / radii).normalize(), tone);
        }
        self.indices
            .extend(sphere_indices(sides, rows).map(|i| first + i));
    }
}

/// A petal of length 1, `half` wide to each side, cupped, its tip bent back.
fn petal(t: f32, side: f32, half: f32) -> Vec3 {
    let width = half * (PI * (0.06 + 0.87 * t.powf(1.35))).sin().max(0.0).powf(0.6);
    let across = side * width;
    Vec3::new(
        across,
        t * (1.0 - 0.10 * side * side * t),
        0.45 * across * across + 0.22 * t - 0.24 * t * t,
    )
}

/// Points of a unit sphere, its poles on the y axis, row after row from below with the seam doubled.
#[allow(clippy::cast_precision_loss, reason = "small counts")]
pub(super) fn unit_sphere(sides: u32, rows: u32) -> impl Iterator<Item = (Vec3, u32)> {
    (0..=rows).flat_map(move |row| {
        let (height, reach) = (PI * (row as f32 / rows as f32 - 0.5)).sin_cos();
        (0..=sides).map(move |side| {
            let (sin, cos) = (TAU * (side % sides) as f32 / sides as f32).sin_cos();
            (Vec3::new(reach * cos, height, reach * sin), row)
        })
    })
}

/// Triangles between the points of [`unit_sphere`], those of no area at the poles left out.
pub(super) fn sphere_indices(sides: u32, rows: u32) -> impl Iterator<Item = u32> {
    (0..rows).flat_map(move |row| {
        (0..sides).flat_map(move |side| {
            let a = row * (sides + 1) + side;
            let [b, c, d] = [a + 1, a + sides + 1, a + sides + 2];
            let low = (row > 0).then_some([a, c, b]);
            let high = (row + 1 < rows).then_some([b, c, d]);
            low.into_iter().chain(high).flatten()
        })
    })
}

/// Built-in surfaces have hundreds of vertices, outlines no more than a polygon may.
fn index(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}
