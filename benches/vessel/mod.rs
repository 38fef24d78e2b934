//! A branching vessel of known axis and radii, as one closed surface of any fineness, which the benches here and beside VMTK share.
//!
//! Its ends are spread over a part of a ball, and halved again and again: a fork for each half. The surface is where the distance to the nearest
//! axis is the radius there, sampled on a lattice (surface nets) and moved onto it.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec3, IVec3};
use ramus::mesh::Mesh;

/// From the source to each end.
const REACH: f64 = 100.0;
/// The height, of 1, above which the ends are on their ball.
const LOWEST: f64 = 0.26;
/// Lengths of the thinnest branches in their radii.
const SLENDER: f64 = 8.0;
/// How much thicker branches are one fork nearer to the source.
const THICKER: f64 = 1.12;
/// Triangles for a square of the lattice's edge, in all directions alike.
const TRIANGLES: f64 = 2.78;

/// Nodes with radii, each but the first with a parent before it.
pub(crate) struct Vessel {
    pub(crate) nodes: Vec<DVec3>,
    pub(crate) parents: Vec<Option<usize>>,
    pub(crate) radii: Vec<f64>,
    tips: Vec<usize>,
}

impl Vessel {
    /// One of so many ends.
    pub(crate) fn new(tips: u32) -> Self {
        let forks = tips.next_power_of_two().ilog2();
        let step = REACH / f64::from(forks + 1);
        let thinnest = step / SLENDER;
        let radius = |depth: u32| thinnest * THICKER.powf(f64::from(forks + 1 - depth));
        let mut vessel = Self {
            nodes: vec![DVec3::ZERO],
            parents: vec![None],
            radii: vec![radius(0)],
            tips: Vec::new(),
        };
        let mut open = vec![(0, 1, directions(tips))];
        while let Some((parent, depth, mut ends)) = open.pop() {
            let middle = ends.iter().sum::<DVec3>().normalize();
            let is_tip = ends.len() == 1;
            let reach = if is_tip {
                REACH
            } else {
                step * f64::from(depth)
            };
            let node = vessel.nodes.len();
            vessel.nodes.push(reach * middle);
            vessel.parents.push(Some(parent));
            vessel.radii.push(radius(depth));
            if is_tip {
                vessel.tips.push(node);
                continue;
            }
            let extent = spread(&ends);
            let axis = (0..3)
                .max_by(|a, b| extent[*a].total_cmp(&extent[*b]))
                .unwrap();
            ends.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
            let others = ends.split_off(ends.len() / 2);
            open.extend([(node, depth + 1, ends), (node, depth + 1, others)]);
        }
        vessel
    }

    /// Where the surface is below the root.
    pub(crate) fn source(&self) -> DVec3 {
        self.nodes[0] - self.radii[0] * (self.nodes[1] - self.nodes[0]).normalize()
    }

    /// Where the surface is beyond each tip.
    pub(crate) fn targets(&self) -> Vec<DVec3> {
        let beyond = |tip: &usize| {
            let parent = self.nodes[self.parents[*tip].unwrap()];
            self.nodes[*tip] + self.radii[*tip] * (self.nodes[*tip] - parent).normalize()
        };
        self.tips.iter().map(beyond).collect()
    }

    /// Its surface in about so many triangles.
    pub(crate) fn mesh(&self, triangles: u32) -> Mesh {
        let cones: Vec<Cone> = (1..self.nodes.len()).map(|node| self.cone(node)).collect();
        let area: f64 = cones.iter().map(Cone::area).sum();
        let step = (TRIANGLES * area / f64::from(triangles)).sqrt();
        let mut lattice = Lattice {
            step,
            cones,
            cells: Vec::new(),
            mesh: Mesh::default(),
        };
        // No row of points is where the surface is flat.
        let half = (1.3 * REACH / step) as i32;
        let size = (2 * half).cast_unsigned().next_power_of_two();
        let all: Vec<usize> = (0..lattice.cones.len()).collect();
        lattice.divide(IVec3::splat(-size.cast_signed() / 2), size, &all);
        lattice.join();
        lattice.mesh
    }

    fn cone(&self, node: usize) -> Cone {
        let parent = self.parents[node].unwrap();
        Cone {
            ends: [self.nodes[parent], self.nodes[node]],
            radii: [self.radii[parent], self.radii[node]],
        }
    }
}

/// Spread evenly over the part of the ball.
fn directions(tips: u32) -> Vec<DVec3> {
    let golden = TAU * (3.0 - 5.0_f64.sqrt()) / 2.0;
    let direction = |tip: u32| {
        let z = 1.0 - (1.0 - LOWEST) * (f64::from(tip) + 0.5) / f64::from(tips);
        let (sin, cos) = (golden * f64::from(tip)).sin_cos();
        DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
    };
    (0..tips).map(direction).collect()
}

fn spread(points: &[DVec3]) -> DVec3 {
    let lowest = points.iter().copied().reduce(DVec3::min).unwrap();
    points.iter().copied().reduce(DVec3::max).unwrap() - lowest
}

/// A round cone.
struct Cone {
    ends: [DVec3; 2],
    radii: [f64; 2],
}

impl Cone {
    fn area(&self) -> f64 {
        TAU / 2.0 * (self.radii[0] + self.radii[1]) * self.ends[0].distance(self.ends[1])
    }

    /// How far outside a point is, and the way out.
    fn distance(&self, point: DVec3) -> (f64, DVec3) {
        let along = self.ends[1] - self.ends[0];
        let part = ((point - self.ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let out = point - self.ends[0] - part * along;
        let radius = self.radii[0] + part * (self.radii[1] - self.radii[0]);
        (out.length() - radius, out.normalize_or_zero())
    }
}

/// A cell that the surface goes through.
struct Cell {
    corner: IVec3,
    /// A bit for each corner that is inside.
    inside: u8,
    /// Its first vertex: there is one for each group of inner corners.
    vertex: u32,
}

struct Lattice {
    step: f64,
    cones: Vec<Cone>,
    cells: Vec<Cell>,
    mesh: Mesh,
}

impl Lattice {
    fn place(&self, corner: DVec3) -> DVec3 {
        self.step * (corner + DVec3::new(0.137, 0.291, 0.413))
    }

    fn distance(&self, point: DVec3, cones: &[usize]) -> (f64, DVec3) {
        let all = cones.iter().map(|cone| self.cones[*cone].distance(point));
        all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    /// Cells of a cube that the surface goes through; `cones` are those that are nearest anywhere in it.
    fn divide(&mut self, corner: IVec3, size: u32, cones: &[usize]) {
        let middle = self.place(corner.as_dvec3() + f64::from(size) / 2.0);
        // A little more than half a diagonal, since cones widen.
        let reach = 0.88 * f64::from(size) * self.step;
        let distances: Vec<f64> = cones
            .iter()
            .map(|cone| self.cones[*cone].distance(middle).0)
            .collect();
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        if nearest.abs() > reach {
            return;
        }
        let near = |(cone, distance): (&usize, &f64)| {
            (*distance <= nearest + 2.0 * reach).then_some(*cone)
        };
        let near: Vec<usize> = cones.iter().zip(&distances).filter_map(near).collect();
        if size == 1 {
            return self.cell(corner, &near);
        }
        for part in 0..8 {
            let half = size / 2;
            self.divide(corner + offset(part) * half.cast_signed(), half, &near);
        }
    }

    fn cell(&mut self, corner: IVec3, cones: &[usize]) {
        let values: [f64; 8] = std::array::from_fn(|part| {
            let place = self.place((corner + offset(part)).as_dvec3());
            self.distance(place, cones).0
        });
        let inside = (0..8).filter(|part| values[*part] < 0.0);
        let inside = inside.fold(0, |mask, part| mask | 1_u8 << part);
        if inside == 0 || inside == u8::MAX {
            return;
        }
        let vertex = u32::try_from(self.mesh.positions.len()).unwrap();
        for group in groups(inside) {
            let point = self.vertex(corner, &values, group, cones);
            self.mesh.positions.push(point.as_vec3());
        }
        self.cells.push(Cell {
            corner,
            inside,
            vertex,
        });
    }

    /// In the middle of where edges from a group of corners leave, and from there onto the surface.
    fn vertex(&self, corner: IVec3, values: &[f64; 8], group: u8, cones: &[usize]) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for (a, b) in (0..8).flat_map(|a| [1, 2, 4].map(|bit| (a, a ^ bit))) {
            if group & 1 << a != 0 && values[b] >= 0.0 {
                let part = values[a] / (values[a] - values[b]);
                let [from, to] = [a, b].map(|part| (corner + offset(part)).as_dvec3());
                sum += from.lerp(to, part);
                count += 1.0;
            }
        }
        let mut point = self.place(sum / count);
        for _ in 0..2 {
            let (distance, out) = self.distance(point, cones);
            point -= distance.clamp(-0.5 * self.step, 0.5 * self.step) * out;
        }
        point
    }

    /// Two triangles about each edge of the lattice that the surface goes through.
    fn join(&mut self) {
        let numbers: HashMap<IVec3, usize> = (0..self.cells.len())
            .map(|cell| (self.cells[cell].corner, cell))
            .collect();
        for cell in &self.cells {
            for axis in 0..3 {
                let along = IVec3::AXES[axis];
                let [second, third] =
                    [(axis + 1) % 3, (axis + 2) % 3].map(|axis| IVec3::AXES[axis]);
                let ends = [0, 1 << axis].map(|corner| cell.inside & 1 << corner != 0);
                if ends[0] == ends[1] {
                    continue;
                }
                let inner = if ends[0] {
                    cell.corner
                } else {
                    cell.corner + along
                };
                let around = [IVec3::ZERO, -second, -second - third, -third].map(|by| {
                    let cell = &self.cells[numbers[&(cell.corner + by)]];
                    cell.vertex_of(inner)
                });
                let [a, b, c, d] = if ends[0] {
                    around
                } else {
                    [around[0], around[3], around[2], around[1]]
                };
                let length = |from: u32, to: u32| {
                    let [from, to] = [from, to].map(|v| self.mesh.positions[v as usize]);
                    from.distance_squared(to)
                };
                self.mesh.triangles.extend(if length(a, c) <= length(b, d) {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                });
            }
        }
    }
}

impl Cell {
    /// The vertex before an inner corner.
    fn vertex_of(&self, corner: IVec3) -> u32 {
        let from = corner - self.corner;
        let bit = 1_u8 << (from.x | from.y << 1 | from.z << 2);
        let place = groups(self.inside)
            .iter()
            .position(|group| group & bit != 0);
        self.vertex + u32::try_from(place.unwrap()).unwrap()
    }
}

fn offset(part: usize) -> IVec3 {
    let bit = |axis: usize| i32::from(part >> axis & 1 == 1);
    IVec3::new(bit(0), bit(1), bit(2))
}

/// Inner corners of a cell that hang together by its edges.
fn groups(inside: u8) -> Vec<u8> {
    let (mut left, mut groups) = (inside, Vec::new());
    while left != 0 {
        let mut group = 1 << left.trailing_zeros();
        loop {
            // Each corner's neighbours along the three axes.
            let x = (group & 0x55) << 1 | (group & 0xaa) >> 1;
            let y = (group & 0x33) << 2 | (group & 0xcc) >> 2;
            let z = u8::rotate_left(group, 4);
            let grown = group | (x | y | z) & inside;
            if grown == group {
                break;
            }
            group = grown;
        }
        left &= !group;
        groups.push(group);
    }
    groups
}
