//! Organs as triangles: one way for pictures and files.

use glam::{Mat3, Vec3};

use super::look::{BROWN, Colour, Paint, Palette, from_bytes};
use super::polygon::Triangulator;
use super::surface::{GREEN, sphere_indices, unit_sphere};
use super::{Organs, Placed, Sphere, Surface};

/// Sides and rows of a sphere.
const BALL: (u32, u32) = (16, 8);

/// Which numbers of triangles are asked for: of each kind that is not, a mesh has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Numbers {
    /// [`OrganMesh::positions`].
    pub positions: bool,
    /// [`OrganMesh::normals`].
    pub normals: bool,
    /// [`OrganMesh::colours`].
    pub colours: bool,
    /// [`OrganMesh::indices`].
    pub indices: bool,
}

impl Numbers {
    /// How many vertices there are and nothing else.
    pub const NONE: Self = Self {
        positions: false,
        normals: false,
        colours: false,
        indices: false,
    };
    /// Where vertices are.
    pub const POSITIONS: Self = Self {
        positions: true,
        ..Self::NONE
    };
    /// Where they look.
    pub const NORMALS: Self = Self {
        normals: true,
        ..Self::NONE
    };
    /// What colours they have.
    pub const COLOURS: Self = Self {
        colours: true,
        ..Self::NONE
    };
    /// Which three are a triangle.
    pub const INDICES: Self = Self {
        indices: true,
        ..Self::NONE
    };
    /// All that a vertex has.
    pub const VERTICES: Self = Self {
        positions: true,
        normals: true,
        colours: true,
        indices: false,
    };
    /// All.
    pub const ALL: Self = Self {
        indices: true,
        ..Self::VERTICES
    };
}

/// Triangles with normals and colours; all vertex arrays that were asked for have one length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrganMesh {
    /// How many vertices there are.
    pub vertices: usize,
    /// Metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit vectors.
    pub normals: Vec<[f32; 3]>,
    /// Linear red, green and blue.
    pub colours: Vec<Colour>,
    /// Three a triangle, counter-clockwise seen against the normals.
    pub indices: Vec<u32>,
}

impl OrganMesh {
    /// Empties it and keeps its memory.
    pub fn clear(&mut self) {
        self.vertices = 0;
        self.positions.clear();
        self.normals.clear();
        self.colours.clear();
        self.indices.clear();
    }
}

/// What all vertices of one organ have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Organ {
    /// Colour and material.
    pub paint: Paint,
    /// The node it hangs on, or `NO_PARENT`.
    pub node: u32,
    /// The step in which it appeared.
    pub birth: u32,
    /// A sheet with two sides.
    pub thin: bool,
}

/// A surface's vertices, all x in a row, then y, then z: a processor works out several of them at once.
struct Columns {
    places: [Vec<f32>; 3],
    normals: [Vec<f32>; 3],
}

impl Columns {
    fn of(surface: &Surface) -> Self {
        let column = |of: &[Vec3], part: usize| of.iter().map(|at| at[part]).collect();
        let columns = |of: &[Vec3]| [0, 1, 2].map(|part| column(of, part));
        let mut normals = surface.normals.clone();
        // A surface that has too few says nothing of the others.
        normals.resize(surface.positions.len(), Vec3::Z);
        Self {
            places: columns(&surface.positions),
            normals: columns(&normals),
        }
    }
}

/// Makes triangles, keeping its scratch memory.
pub struct Organist<'a> {
    organs: &'a Organs,
    /// Of each of the organs' surfaces.
    columns: Vec<Columns>,
    triangulator: Triangulator,
    ball: Vec<Vec3>,
    ball_indices: Vec<u32>,
    cut: Vec<u32>,
}

impl<'a> Organist<'a> {
    /// For valid organs.
    #[must_use]
    pub fn new(organs: &'a Organs) -> Self {
        let (sides, rows) = BALL;
        Self {
            organs,
            columns: organs.surfaces.iter().map(Columns::of).collect(),
            triangulator: Triangulator::default(),
            ball: unit_sphere(sides, rows).map(|(point, _)| point).collect(),
            ball_indices: sphere_indices(sides, rows).collect(),
            cut: Vec::new(),
        }
    }

    /// The organ of an index: first the polygons, then the spheres, then the placed surfaces.
    #[must_use]
    pub fn organ(&self, index: usize) -> Option<Organ> {
        let organs = self.organs;
        if let Some(polygon) = organs.polygons.get(index) {
            return Some(Organ {
                paint: polygon.paint,
                node: polygon.node,
                birth: polygon.birth,
                thin: true,
            });
        }
        let index = index - organs.polygons.len();
        if let Some(sphere) = organs.spheres.get(index) {
            return Some(Organ {
                paint: sphere.paint,
                node: sphere.node,
                birth: sphere.birth,
                thin: false,
            });
        }
        let placed = organs.placed.get(index - organs.spheres.len())?;
        let surface = organs.surfaces.get(usize::from(placed.surface))?;
        Some(Organ {
            paint: placed.paint,
            node: placed.node,
            birth: placed.birth,
            thin: surface.thin,
        })
    }

    /// Most vertices and indices that an organ takes.
    #[must_use]
    pub fn size(&self, index: usize) -> (usize, usize) {
        let organs = self.organs;
        if index < organs.polygons.len() {
            let corners = organs.corners_of(index).len();
            return (corners, 3 * corners.saturating_sub(2));
        }
        let index = index - organs.polygons.len();
        if index < organs.spheres.len() {
            return (self.ball.len(), self.ball_indices.len());
        }
        let placed = organs.placed.get(index - organs.spheres.len());
        let surface = placed.and_then(|p| organs.surfaces.get(usize::from(p.surface)));
        surface.map_or((0, 0), |s| (s.positions.len(), s.indices.len()))
    }

    /// Adds the triangles of an organ.
    pub fn add(&mut self, index: usize, into: &mut OrganMesh) {
        self.add_only(index, Numbers::ALL, into);
    }

    /// Adds of the triangles of an organ what is asked for.
    pub fn add_only(&mut self, index: usize, numbers: Numbers, into: &mut OrganMesh) {
        let organs = self.organs;
        if index < organs.polygons.len() {
            return self.add_polygon(index, numbers, into);
        }
        let index = index - organs.polygons.len();
        if let Some(sphere) = organs.spheres.get(index) {
            return self.add_sphere(sphere, numbers, into);
        }
        let placed = organs.placed.get(index - organs.spheres.len());
        let shape = placed.map(|placed| usize::from(placed.surface));
        if let Some((placed, shape)) = placed.zip(shape)
            && let Some(surface) = organs.surfaces.get(shape)
            && let Some(columns) = self.columns.get(shape)
        {
            self.add_placed(placed, (surface, columns), numbers, into);
        }
    }

    fn add_polygon(&mut self, index: usize, numbers: Numbers, into: &mut OrganMesh) {
        let corners = self.organs.corners_of(index);
        self.cut.clear();
        let Some(normal) = self.triangulator.add(corners, &mut self.cut) else {
            return;
        };
        let paint = self.organs.polygons.get(index).map(|polygon| polygon.paint);
        let given = paint.and_then(|paint| self.organs.palette.colour(paint.colour));
        let colour = given.unwrap_or_else(|| from_bytes(GREEN));
        let first = next(into);
        into.vertices += corners.len();
        if numbers.positions {
            let places = corners.iter().map(|corner| corner.to_array());
            into.positions.extend(places);
        }
        if numbers.normals {
            into.normals.resize(into.vertices, normal.to_array());
        }
        if numbers.colours {
            into.colours.resize(into.vertices, colour);
        }
        if numbers.indices {
            into.indices.extend(self.cut.iter().map(|at| first + at));
        }
    }

    fn add_sphere(&self, sphere: &Sphere, numbers: Numbers, into: &mut OrganMesh) {
        let given = self.organs.palette.colour(sphere.paint.colour);
        let colour = given.unwrap_or_else(|| from_bytes(BROWN));
        let first = next(into);
        into.vertices += self.ball.len();
        if numbers.positions {
            let place = |unit: &Vec3| (sphere.center + *unit * sphere.radius).to_array();
            into.positions.extend(self.ball.iter().map(place));
        }
        if numbers.normals {
            let units = self.ball.iter().map(|unit| unit.to_array());
            into.normals.extend(units);
        }
        if numbers.colours {
            into.colours.resize(into.vertices, colour);
        }
        if numbers.indices {
            let own = self.ball_indices.iter().map(|at| first + at);
            into.indices.extend(own);
        }
    }

    fn add_placed(
        &self,
        placed: &Placed,
        (surface, columns): (&Surface, &Columns),
        numbers: Numbers,
        into: &mut OrganMesh,
    ) {
        let first = next(into);
        let turn = Mat3::from_quat(placed.orientation);
        // A negative scale turns a surface inside out.
        let mirrored = placed.scale < 0.0;
        into.vertices += surface.positions.len();
        if numbers.positions {
            let sized = turn * placed.scale;
            place(sized, placed.position, &columns.places, &mut into.positions);
        }
        if numbers.normals {
            let side = if mirrored { -turn } else { turn };
            let outward = (placed.position - self.organs.crown).try_normalize();
            let share = surface.rounded;
            match outward.filter(|_| share > 0.0) {
                Some(out) => round(side, out, share, &columns.normals, &mut into.normals),
                None => place(side, Vec3::ZERO, &columns.normals, &mut into.normals),
            }
        }
        if numbers.colours {
            // Looked up once for all vertices.
            let given = self.organs.palette.colour(placed.paint.colour);
            let own = surface.tone.iter().map(|tone| surface.toned(*tone, given));
            into.colours.extend(own);
            into.colours.resize(into.vertices, surface.toned(0, given));
        }
        if numbers.indices {
            let (triangles, _) = surface.indices.as_chunks::<3>();
            // Three axes turned over turn a triangle over, and its normal with it.
            let (b, c) = if mirrored { (2, 1) } else { (1, 2) };
            let own = triangles
                .iter()
                .map(|corners| [first + corners[0], first + corners[b], first + corners[c]]);
            let before = into.indices.len();
            into.indices.resize(before + 3 * triangles.len(), 0);
            let (into, _) = into.indices[before..].as_chunks_mut::<3>();
            into.iter_mut().zip(own).for_each(|(into, own)| *into = own);
        }
    }
}

impl Surface {
    /// The colour of a vertex for the turtle's colour index.
    #[must_use]
    pub fn colour(&self, vertex: usize, palette: &Palette, index: u16) -> Colour {
        let tone = self.tone.get(vertex).copied().unwrap_or(0);
        self.toned(tone, palette.colour(index))
    }

    /// The colour of a tone where the turtle gives one, or none.
    fn toned(&self, tone: u8, given: Option<Colour>) -> Colour {
        match (self.tones.get(usize::from(tone)), given) {
            (None, _) => from_bytes(GREEN),
            (Some(tone), Some(colour)) if !tone.fixed => colour,
            (Some(tone), _) => tone.colour,
        }
    }
}

/// Adds vectors, turned and moved. Here and in [`round`] everything is said number by number, so that several vertices are worked out at once.
fn place(turn: Mat3, by: Vec3, [x, y, z]: &[Vec<f32>; 3], into: &mut Vec<[f32; 3]>) {
    let before = into.len();
    into.resize(before + x.len(), [0.0; 3]);
    for (((into, x), y), z) in into[before..].iter_mut().zip(x).zip(y).zip(z) {
        *into = turned(&turn, *x, *y, *z, by);
    }
}

#[inline(always)]
fn turned(turn: &Mat3, x: f32, y: f32, z: f32, by: Vec3) -> [f32; 3] {
    let (right, up, out) = (turn.x_axis, turn.y_axis, turn.z_axis);
    [
        right.x * x + up.x * y + out.x * z + by.x,
        right.y * x + up.y * y + out.y * z + by.y,
        right.z * x + up.z * y + out.z * z + by.z,
    ]
}

/// Adds leaves' normals with as much as `share` of their crown's in them, on the side that each is on; `outward`: the crown's.
fn round(
    side: Mat3,
    outward: Vec3,
    share: f32,
    [x, y, z]: &[Vec<f32>; 3],
    into: &mut Vec<[f32; 3]>,
) {
    let left = 1.0 - share;
    let before = into.len();
    into.resize(before + x.len(), [0.0; 3]);
    for (((into, x), y), z) in into[before..].iter_mut().zip(x).zip(y).zip(z) {
        let own = turned(&side, *x, *y, *z, Vec3::ZERO);
        let dot = own[0] * outward.x + own[1] * outward.y + own[2] * outward.z;
        // Without a branch, since it would go one way as often as the other. Two that do not point away from each other have a sum.
        let to = share.copysign(dot);
        let sum = [
            left * own[0] + to * outward.x,
            left * own[1] + to * outward.y,
            left * own[2] + to * outward.z,
        ];
        let length = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
        let one = 1.0 / length;
        *into = [sum[0] * one, sum[1] * one, sum[2] * one];
    }
}

fn next(mesh: &OrganMesh) -> u32 {
    // Callers cut meshes long before 2^32 vertices.
    u32::try_from(mesh.vertices).unwrap_or(u32::MAX)
}
