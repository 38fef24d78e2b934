//! Positions and triangles of all meshes in all their places.
//!
//! Two passes: the first finds the box of all positions in double precision, and with it where to count from; the second writes
//! positions in single precision where they stay. So nothing stands in memory twice, and what is tightly packed and not moved costs
//! little more than its copy.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use ::gltf::json::accessor::ComponentType;
use glam::{DAffine3, DVec3, Vec3};

use super::super::points::{LARGEST, is_coordinate, narrow, origin_of};
use super::super::{Stop, Task, with_room};
use super::elements::{Accessors, Counting, Elements, Number, by_number};
use super::rows::{Box3, all_rows, extend, extend_packed, largest_packed, packed_bounds, words};
use super::scene::Placement;
use super::shape::{Block, Join, Part, Shape};
use crate::mesh::Mesh;

/// Places between two looks.
const PLACES: usize = 1 << 10;

/// How much all meshes are in all their places.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    pub(super) skipped: usize,
}

/// Counts, and refuses more than is read.
pub(super) fn size(
    scene: &[Placement<'_>],
    shapes: &BTreeMap<usize, Shape>,
    task: &Task<'_>,
) -> Result<Size, Stop> {
    let mut size = Size::default();
    for placement in scene {
        let Some(shape) = shapes.get(&placement.mesh) else {
            continue;
        };
        let add = |sum: &mut usize, of_one: usize| {
            *sum = sum.saturating_add(of_one.saturating_mul(placement.count()));
        };
        add(&mut size.vertices, shape.vertices);
        add(&mut size.triangles, shape.triangles);
        add(&mut size.skipped, shape.skipped);
    }
    task.check_vertices(size.vertices)?;
    task.check_triangles(size.triangles)?;
    Ok(size)
}

/// A shape with its bytes.
pub(super) struct Ready<'a> {
    pub(super) shape: &'a Shape,
    /// For each block.
    positions: Vec<Arc<Elements<'a>>>,
    /// For each part.
    indices: Vec<Option<Arc<Elements<'a>>>>,
}

/// All that a surface is made of, with all ranges and vertex numbers checked.
pub(super) struct Source<'a> {
    scene: &'a [Placement<'a>],
    shapes: BTreeMap<usize, Ready<'a>>,
    pub(super) size: Size,
    pub(super) task: &'a Task<'a>,
}

impl<'a> Source<'a> {
    pub(super) fn new(
        scene: &'a [Placement<'a>],
        shapes: &'a BTreeMap<usize, Shape>,
        accessors: &Accessors<'a>,
        size: Size,
        task: &'a Task<'a>,
    ) -> Result<Self, Stop> {
        let mut ready = BTreeMap::new();
        for (&mesh, shape) in shapes.iter().filter(|(_, shape)| shape.triangles > 0) {
            let positions = shape.blocks.iter();
            let positions = positions.map(|block| accessors.get(block.positions));
            let mut indices = Vec::with_capacity(shape.parts.len());
            for part in &shape.parts {
                let elements = part
                    .indices
                    .map(|number| accessors.get(number))
                    .transpose()?;
                if let Some(elements) = &elements {
                    check_indices(elements, part, &shape.blocks[part.block], task)?;
                }
                indices.push(elements);
            }
            let shape = Ready {
                shape,
                positions: positions.collect::<Result<_, _>>()?,
                indices,
            };
            ready.insert(mesh, shape);
        }
        Ok(Self {
            scene,
            shapes: ready,
            size,
            task,
        })
    }

    /// Shapes that are shown.
    pub(super) fn shapes(&self) -> impl Iterator<Item = &Shape> {
        self.shapes.values().map(|ready| ready.shape)
    }

    /// Goes through all shapes in all their places, in the file's order.
    pub(super) fn each(
        &self,
        mut visit: impl FnMut(&Ready<'a>, DAffine3) -> Result<(), Stop>,
    ) -> Result<(), Stop> {
        let mut places = 0;
        for placement in self.scene {
            let Some(ready) = self.shapes.get(&placement.mesh) else {
                continue;
            };
            for number in 0..placement.count() {
                if places % PLACES == 0 {
                    self.task.go_on()?;
                }
                places += 1;
                visit(ready, placement.place(number))?;
            }
        }
        Ok(())
    }

    /// Positions and triangles.
    pub(super) fn mesh(&self) -> Result<Mesh, Stop> {
        let task = self.task;
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.each(|ready, place| {
            for (elements, block) in ready.positions.iter().zip(&ready.shape.blocks) {
                let kind = elements.layout.kind;
                let (low, high) = by_number!(kind, bounds::<_>(elements, place, task))?
                    .ok_or_else(|| no_coordinate(elements, block, place))?;
                least = least.min(low);
                most = most.max(high);
            }
            Ok(())
        })?;
        let origin = origin_of(least, most);
        let mut positions: Vec<Vec3> = with_room(self.size.vertices)?;
        let mut triangles: Vec<[u32; 3]> = with_room(self.size.triangles)?;
        self.each(|ready, place| {
            let mut starts = Vec::with_capacity(ready.positions.len());
            for elements in &ready.positions {
                starts.push(u32::try_from(positions.len()).unwrap_or(u32::MAX));
                let kind = elements.layout.kind;
                by_number!(
                    kind,
                    put::<_>(elements, place, origin, &mut positions, task)
                )?;
            }
            let is_mirrored = place.matrix3.determinant() < 0.0;
            for (part, indices) in ready.shape.parts.iter().zip(&ready.indices) {
                let start = starts.get(part.block).copied().unwrap_or_default();
                join(
                    part,
                    indices.as_deref(),
                    start,
                    is_mirrored,
                    &mut triangles,
                    task,
                )?;
            }
            Ok(())
        })?;
        Ok(Mesh {
            origin,
            positions,
            triangles,
        })
    }
}

/// That all corners are vertices.
fn check_indices(
    elements: &Elements<'_>,
    part: &Part,
    block: &Block,
    task: &Task<'_>,
) -> Result<(), Stop> {
    fn largest<C: Counting>(elements: &Elements<'_>, task: &Task<'_>) -> Result<u32, Stop> {
        let of_rows = |rows: Range<usize>| {
            let corners = rows.map(|row| elements.count::<C>(row));
            corners.fold(0, u32::max)
        };
        all_rows(elements.layout.rows, task, of_rows, u32::max, || 0)
    }
    let largest = match elements.layout.kind {
        ComponentType::U8 => largest::<u8>(elements, task),
        ComponentType::U16 => largest::<u16>(elements, task),
        _ => match elements.packed(ComponentType::U32, 1) {
            Some(bytes) => largest_packed(bytes, task),
            None => largest::<u32>(elements, task),
        },
    }?;
    if largest as usize >= block.vertices {
        let problem = format!(
            "names the vertex {largest}, but there are {}, counted from 0: the file is damaged, save it again",
            block.vertices
        );
        return Err(Stop::item(
            "accessor",
            part.indices.unwrap_or_default(),
            problem,
        ));
    }
    Ok(())
}

/// A position in the scene.
#[inline]
fn point<N: Number>(elements: &Elements<'_>, row: usize, place: Option<DAffine3>) -> DVec3 {
    let point = DVec3::from_array(elements.row::<N, 3>(row));
    place.map_or(point, |place| place.transform_point3(point))
}

/// A place that moves something.
fn moving(place: DAffine3) -> Option<DAffine3> {
    (place != DAffine3::IDENTITY).then_some(place)
}

/// The box of all positions; None where a coordinate is none.
fn bounds<N: Number>(
    elements: &Elements<'_>,
    place: DAffine3,
    task: &Task<'_>,
) -> Result<Box3, Stop> {
    let place = moving(place);
    let unite = |left: Box3, right: Box3| {
        let (left, right) = left.zip(right)?;
        Some((left.0.min(right.0), left.1.max(right.1)))
    };
    let nothing = || Some((DVec3::INFINITY, DVec3::NEG_INFINITY));
    if let (None, Some(bytes)) = (place, elements.packed(ComponentType::F32, 3)) {
        let of_rows = |rows: Range<usize>| {
            packed_bounds(
                bytes
                    .get(12 * rows.start..12 * rows.end)
                    .unwrap_or_default(),
            )
        };
        return all_rows(elements.layout.rows, task, of_rows, unite, nothing);
    }
    let of_rows = |rows: Range<usize>| {
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut all = true;
        for row in rows {
            let point = point::<N>(elements, row, place);
            all &= point.abs().cmple(DVec3::splat(LARGEST)).all();
            least = least.min(point);
            most = most.max(point);
        }
        all.then_some((least, most))
    };
    all_rows(elements.layout.rows, task, of_rows, unite, nothing)
}

/// The fault of the first row with a coordinate that is none.
fn no_coordinate(elements: &Elements<'_>, block: &Block, place: DAffine3) -> Stop {
    let points = (0..elements.layout.rows).map(|row| {
        let point = DVec3::from_array(elements.any_row::<3>(row));
        moving(place).map_or(point, |place| place.transform_point3(point))
    });
    let values = points.map(|point| {
        point
            .to_array()
            .into_iter()
            .find(|&value| !is_coordinate(value))
    });
    let wrong = values
        .enumerate()
        .find_map(|(row, value)| Some((row, value?)));
    let (row, value) = wrong.unwrap_or_default();
    let problem = format!(
        "has the coordinate {value} in element {row}: coordinates are numbers up to ±{LARGEST:e}; mend or remove the vertex"
    );
    Stop::item("accessor", block.positions, problem)
}

/// Appends all positions, counted from an origin.
fn put<N: Number>(
    elements: &Elements<'_>,
    place: DAffine3,
    origin: DVec3,
    to: &mut Vec<Vec3>,
    task: &Task<'_>,
) -> Result<(), Stop> {
    let place = moving(place);
    let packed = elements.packed(ComponentType::F32, 3);
    if let (None, DVec3::ZERO, Some(bytes)) = (place, origin, packed) {
        return extend_packed(to, bytes, task, |row: &[u8; 12]| {
            Vec3::from(words(row, f32::from_le_bytes))
        });
    }
    extend(to, elements.layout.rows, task, |row| {
        let [x, y, z] = (point::<N>(elements, row, place) - origin).to_array();
        Vec3::new(narrow(x), narrow(y), narrow(z))
    })
}

/// Appends the triangles of a part, of which the first vertex has this number.
fn join(
    part: &Part,
    indices: Option<&Elements<'_>>,
    start: u32,
    is_mirrored: bool,
    to: &mut Vec<[u32; 3]>,
    task: &Task<'_>,
) -> Result<(), Stop> {
    let mut by = |corner: &(dyn Fn(usize) -> u32 + Sync)| {
        extend(to, part.triangles, task, |triangle| {
            turned(
                corners(part.join, triangle).map(|at| start + corner(at)),
                is_mirrored,
            )
        })
    };
    match indices {
        None => by(&|at| u32::try_from(at).unwrap_or_default()),
        Some(elements) => match elements.layout.kind {
            ComponentType::U8 => by(&|at| elements.count::<u8>(at)),
            ComponentType::U16 => by(&|at| elements.count::<u16>(at)),
            _ => match (part.join, elements.packed(ComponentType::U32, 1)) {
                // By far the most.
                (Join::List, Some(bytes)) => extend_packed(to, bytes, task, |row: &[u8; 12]| {
                    let corners = words(row, u32::from_le_bytes);
                    turned(corners.map(|corner| start + corner), is_mirrored)
                }),
                _ => by(&|at| elements.count::<u32>(at)),
            },
        },
    }
}

/// Which corners a triangle has; they turn the same way in all (§3.7.2.1).
#[inline]
fn corners(join: Join, triangle: usize) -> [usize; 3] {
    match join {
        Join::List => [3 * triangle, 3 * triangle + 1, 3 * triangle + 2],
        Join::Strip if triangle.is_multiple_of(2) => [triangle, triangle + 1, triangle + 2],
        Join::Strip => [triangle, triangle + 2, triangle + 1],
        Join::Fan => [triangle + 1, triangle + 2, 0],
    }
}

#[inline]
fn turned([a, b, c]: [u32; 3], is_mirrored: bool) -> [u32; 3] {
    if is_mirrored { [a, c, b] } else { [a, b, c] }
}
