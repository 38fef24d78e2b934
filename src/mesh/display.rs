//! A mesh as it is drawn: its box, its [levels of detail](super::levels), a normal for each vertex and, where they are wanted, colours or
//! [materials](super::textured).
//!
//! A vertex's normal is the sum of its triangles' normals, each as long as its triangle is large: what voxels stepped and scanners left uneven
//! is shaded as one surface. Vertices of equal coordinates share it, since files part vertices at seams and STL files everywhere.
//! *Tried*: weighting by angles, as Thürmer and Wüthrich 1998 have it, is right where a corner is cut into few triangles; scans are cut evenly, and
//! it takes three arc cosines a triangle.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{BVec3, Vec3};
use rayon::prelude::*;

use super::Mesh;
use super::levels::{Joined, Levels};
use super::report::representatives;
use super::textured::Textured;

/// Triangles worked on between two looks at whether to go on.
const BETWEEN_CHECKS: usize = 1 << 16;

/// Triangles that one picture shows without levels of detail; what frames draw of all models is more.
const ONE_PICTURE: usize = 1_000_000;

/// What a picture of a mesh needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Display {
    /// The mesh.
    pub mesh: Arc<Mesh>,
    /// The vertices' normals, as [`octahedral`] packs them; up where a vertex has no triangle with an area.
    pub normals: Arc<Vec<u32>>,
    /// The mesh in all levels of detail. Two displays that share these (by [`Arc`]) differ in nothing but colours.
    pub levels: Arc<Levels>,
    /// The triangles' colours: sRGB with alpha, or empty.
    pub colours: Vec<[u8; 4]>,
    /// The vertices' colours: sRGB with alpha, or empty; where there are some, those of triangles are not looked at. Between vertices they run into
    /// each other; alpha 0 is the model's own colour.
    pub vertex_colours: Vec<[u8; 4]>,
    /// How it looks as its file colours it; where there is this, colours are not looked at.
    pub textured: Option<Arc<Textured>>,
    /// Smallest corner of the box around all vertices of triangles, from the mesh's origin.
    pub low: Vec3,
    /// Its largest corner.
    pub high: Vec3,
}

impl Display {
    /// Prepares a mesh in all levels of detail; `textured`: how its file colours it, which the levels keep apart where it changes. It is in its own
    /// colour until [`Self::textured`] says otherwise. `None` when somebody asked to stop.
    pub fn new(mesh: Arc<Mesh>, textured: Option<&Textured>, cancel: &AtomicBool) -> Option<Self> {
        Self::with_levels(mesh, textured, cancel, Levels::new)
    }

    /// Prepares a mesh for one picture: a single level of what is not larger than frames may be, since making others takes longer than drawing it does.
    /// `None` when somebody asked to stop.
    pub fn for_picture(
        mesh: Arc<Mesh>,
        textured: Option<&Textured>,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let small = mesh.triangles.len() <= ONE_PICTURE;
        let levels = if small { Levels::finest } else { Levels::new };
        Self::with_levels(mesh, textured, cancel, levels)
    }

    /// Prepares a mesh without levels: joined vertices, normals and the box. It can be measured and asked, and not be drawn. `None` when somebody asked to stop.
    pub fn bare(mesh: Arc<Mesh>, cancel: &AtomicBool) -> Option<Self> {
        Self::with_levels(mesh, None, cancel, |_, _, _, _| Some(Levels::default()))
    }

    fn with_levels(
        mesh: Arc<Mesh>,
        textured: Option<&Textured>,
        cancel: &AtomicBool,
        levels: impl FnOnce(&Mesh, &Joined<'_>, &[u32], &AtomicBool) -> Option<Levels>,
    ) -> Option<Self> {
        let used = vec![true; mesh.positions.len()];
        let places = representatives(&mesh.positions, &used);
        let normals = normals(&mesh, &places, cancel)?;
        let levels = match textured {
            Some(textured) => {
                let joined = Joined {
                    vertices: &textured.joined(&places),
                    places: &places,
                    borders: &textured.borders(&mesh, &places),
                };
                levels(&mesh, &joined, &normals, cancel)
            }
            None => levels(&mesh, &Joined::by_place(&places), &normals, cancel),
        }?;
        let (low, high) = extent(&mesh);
        // No triangle: no box.
        let (low, high) = if low.cmple(high).all() {
            (low, high)
        } else {
            (Vec3::ZERO, Vec3::ZERO)
        };
        Some(Self {
            mesh,
            normals: Arc::new(normals),
            levels: Arc::new(levels),
            low,
            high,
            ..Self::default()
        })
    }

    /// The same with a colour for each triangle, and nothing else.
    #[must_use]
    pub fn coloured(&self, colours: Vec<[u8; 4]>) -> Self {
        Self {
            colours,
            ..self.plain()
        }
    }

    /// The same with a colour for each vertex, and nothing else.
    #[must_use]
    pub fn painted(&self, vertex_colours: Vec<[u8; 4]>) -> Self {
        Self {
            vertex_colours,
            ..self.plain()
        }
    }

    /// The same as its file colours it. Its levels must have been made with this.
    #[must_use]
    pub fn textured(&self, textured: Arc<Textured>) -> Self {
        Self {
            textured: Some(textured),
            ..self.plain()
        }
    }

    /// The same shape in its own colour.
    fn plain(&self) -> Self {
        Self {
            mesh: Arc::clone(&self.mesh),
            normals: Arc::clone(&self.normals),
            levels: Arc::clone(&self.levels),
            low: self.low,
            high: self.high,
            ..Self::default()
        }
    }

    /// Whether it has colours of its own.
    #[must_use]
    pub fn has_colours(&self) -> bool {
        !(self.colours.is_empty() && self.vertex_colours.is_empty() && self.textured.is_none())
    }

    /// The box's corners: the bits of a corner's number say on which axes it is at the larger end.
    #[must_use]
    pub fn corners(&self) -> [Vec3; 8] {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: u8| {
            let larger = BVec3::new(corner & 1 != 0, corner & 2 != 0, corner & 4 != 0);
            Vec3::select(larger, self.high, self.low)
        })
    }

    /// Width, height and depth of the box.
    #[must_use]
    pub fn size(&self) -> Vec3 {
        self.high - self.low
    }
}

/// The box around all vertices that triangles name.
fn extent(mesh: &Mesh) -> (Vec3, Vec3) {
    const NOTHING: (Vec3, Vec3) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let wider = |(low, high): (Vec3, Vec3), at: Vec3| (low.min(at), high.max(at));
    let of = |triangles: &[[u32; 3]]| {
        let corners = triangles.as_flattened().iter();
        let places = corners.filter_map(|&vertex| mesh.positions.get(vertex as usize));
        places.fold(NOTHING, |extent, at| wider(extent, *at))
    };
    let parts = mesh.triangles.par_chunks(BETWEEN_CHECKS).map(of);
    parts.reduce(|| NOTHING, |a, b| (a.0.min(b.0), a.1.max(b.1)))
}

fn normals(mesh: &Mesh, shared: &[u32], cancel: &AtomicBool) -> Option<Vec<u32>> {
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for part in mesh.triangles.chunks(BETWEEN_CHECKS) {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        for triangle in part {
            let corner = |at: usize| mesh.positions.get(triangle[at] as usize).copied();
            let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else {
                continue;
            };
            let normal = (b - a).cross(c - a);
            for vertex in triangle {
                let shared = shared.get(*vertex as usize);
                if let Some(sum) = shared.and_then(|&at| sums.get_mut(at as usize)) {
                    *sum += normal;
                }
            }
        }
    }
    let normal = |&shared: &u32| {
        let sum = sums.get(shared as usize).copied().unwrap_or_default();
        octahedral(sum.try_normalize().unwrap_or_else(|| tiny(sum)))
    };
    Some(shared.par_iter().map(normal).collect())
}

/// The direction of a sum that is too small or too large to be normalised as it is.
fn tiny(sum: Vec3) -> Vec3 {
    let scaled = sum / sum.abs().max_element();
    scaled.try_normalize().unwrap_or(Vec3::Y)
}

/// A unit vector as two snorm16: the octahedron's faces unfolded into a square (Cigolla et al. 2014, "A Survey of Efficient Representations for
/// Independent Unit Vectors").
#[must_use]
pub fn octahedral(normal: Vec3) -> u32 {
    let sum = normal.abs().element_sum().max(f32::MIN_POSITIVE);
    let p = normal / sum;
    let side = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let [x, y] = if p.z >= 0.0 {
        [p.x, p.y]
    } else {
        [(1.0 - p.y.abs()) * side(p.x), (1.0 - p.x.abs()) * side(p.y)]
    };
    #[allow(clippy::cast_possible_truncation, reason = "lies within ±32767")]
    let [x, y] = [x, y].map(|part| (part * f32::from(i16::MAX)).round() as i16);
    u32::from(x.cast_unsigned()) | u32::from(y.cast_unsigned()) << 16
}

/// The unit vector that [`octahedral`] packed.
#[must_use]
pub fn direction(packed: u32) -> Vec3 {
    let [low, high, further, highest] = packed.to_le_bytes();
    let [x, y] = [[low, high], [further, highest]]
        .map(|part| f32::from(i16::from_le_bytes(part)) / f32::from(i16::MAX));
    let z = 1.0 - x.abs() - y.abs();
    let side = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let [x, y] = if z >= 0.0 {
        [x, y]
    } else {
        [(1.0 - y.abs()) * side(x), (1.0 - x.abs()) * side(y)]
    };
    Vec3::new(x, y, z).normalize_or(Vec3::Y)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::mesh::made;

    fn display(mesh: Mesh) -> Display {
        Display::new(Arc::new(mesh), None, &AtomicBool::new(false)).unwrap()
    }

    #[test]
    fn a_balls_normals_point_away_from_its_middle() {
        let ball = display(made::sphere(4));
        let middle = (ball.low + ball.high) / 2.0;
        for (position, normal) in ball.mesh.positions.iter().zip(&*ball.normals) {
            let away = (*position - middle).normalize();
            assert!(direction(*normal).dot(away) > 0.99, "{position}");
        }
    }

    #[test]
    fn corners_that_a_file_parts_are_shaded_as_one() {
        let ball = made::sphere(2);
        let soup = made::soup(&ball);
        let (whole, parted) = (display(ball), display(soup));
        for (corner, vertex) in whole.mesh.triangles.iter().flatten().enumerate() {
            let difference = direction(whole.normals[*vertex as usize])
                .distance(direction(parted.normals[corner]));
            assert!(difference < 1e-3, "{corner}");
        }
        assert_eq!((whole.low, whole.high), (parted.low, parted.high));
    }

    #[test]
    fn what_has_no_area_and_no_triangle_is_no_trouble() {
        let point = Mesh {
            positions: vec![Vec3::splat(3.0); 3],
            triangles: vec![[0, 1, 2], [0, 7, 1]],
            ..Mesh::default()
        };
        let point = display(point);
        assert_eq!(direction(point.normals[0]), Vec3::Y);
        assert_eq!(point.size(), Vec3::ZERO);
        let nothing = display(Mesh::default());
        assert_eq!((nothing.low, nothing.high), (Vec3::ZERO, Vec3::ZERO));
        let cancelled = AtomicBool::new(true);
        assert!(Display::new(Arc::new(made::sphere(2)), None, &cancelled).is_none());
        // So small that squares vanish.
        let small = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X * 1e-18, Vec3::Y * 1e-18],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        assert!(direction(display(small).normals[0]).distance(Vec3::Z) < 1e-3);
    }

    #[test]
    fn packing_keeps_directions() {
        for towards in [
            Vec3::X,
            Vec3::NEG_Z,
            Vec3::new(1.0, -2.0, 3.0),
            Vec3::new(-1.0, -0.1, -0.2),
        ] {
            let towards = towards.normalize();
            assert!(direction(octahedral(towards)).distance(towards) < 1e-3);
        }
    }
}
