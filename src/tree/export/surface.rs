//! The triangles of a drawing, in groups of one material, made part by part.
//!
//! Bark comes first: tubes without a colour of their own, with texture coordinates. Then, for each material, painted tubes and organs, with
//! a colour at each vertex.

use std::collections::BTreeSet;
use std::io;

use glam::Vec3;

use super::instances::{Run, runs};
use super::unfold::Unfolding;
use super::wind::Bending;
use super::{ExportParams, Extras, Individual, MOST_BYTES, PART, Place, Stand};
use crate::tree::mesh::{SIDES, TubeMesh, mesh, vertices_per_segment};
use crate::tree::organs::{
    Colour, LookTable, Numbers, OrganMesh, Organist, Organs, look_of, paint_segments, refined,
    refined_len,
};
use crate::tree::tubes::{self, CAPPED, STARTS, TubeSegment};
use crate::tree::{Tree, TreeError};

/// Vertices of organs that are in memory at a time: so many that they stay near the processor.
const ORGAN_PART: usize = 1 << 14;
/// Tubes that may have so many vertices are made once and kept: some forty megabytes, since most segments have half as many as they may.
const KEPT: u64 = 1 << 20;

/// What a group's triangles are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Matter {
    /// With texture coordinates.
    Bark,
    /// The material of this index, with colours.
    Painted(u16),
}

/// Triangles of one material.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    pub(super) matter: Matter,
    pub(super) vertices: usize,
    pub(super) indices: usize,
    /// Smallest and largest coordinates.
    pub(super) bounds: [[f32; 3]; 2],
}

/// Some of a group's triangles: what of them was asked for, at least.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part<'a> {
    pub(super) vertices: usize,
    pub(super) positions: &'a [[f32; 3]],
    pub(super) normals: &'a [[f32; 3]],
    /// Of bark only.
    pub(super) uvs: &'a [[f32; 2]],
    /// Of painted things only; linear.
    pub(super) colours: &'a [Colour],
    /// From the part's own first vertex on.
    pub(super) indices: &'a [u32],
}

/// Tubes of one material.
#[derive(Debug)]
struct Tubes {
    mesh: TubeMesh,
    /// Of painted ones.
    colours: Vec<Colour>,
}

impl Tubes {
    fn part(&self) -> Part<'_> {
        Part {
            vertices: self.mesh.positions.len(),
            positions: &self.mesh.positions,
            normals: &self.mesh.normals,
            uvs: &self.mesh.uvs,
            colours: &self.colours,
            indices: &self.mesh.indices,
        }
    }
}

fn part_of(mesh: &OrganMesh) -> Part<'_> {
    Part {
        vertices: mesh.vertices,
        positions: &mesh.positions,
        normals: &mesh.normals,
        uvs: &[],
        colours: &mesh.colours,
        indices: &mesh.indices,
    }
}

/// A tree's surface, and where in a file it stands.
#[derive(Debug)]
pub(super) struct Standing<'a> {
    /// At least one.
    pub(super) places: Vec<Place>,
    pub(super) surface: Surface<'a>,
}

impl Standing<'_> {
    /// The name of the tree, which is that of its first place.
    pub(super) fn name(&self) -> &str {
        self.places.first().map_or("", |place| &place.name)
    }
}

/// Each tree with each of its places.
pub(super) fn everywhere<'a, 'b>(
    trees: &'b [Standing<'a>],
) -> impl Iterator<Item = (&'b Standing<'a>, &'b Place)> {
    let trees = trees.iter();
    trees.flat_map(|one| one.places.iter().map(move |place| (one, place)))
}

/// What things take in a file at most, bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Costs {
    pub(super) vertex: u64,
    /// What is placed and has no triangles of its own; 0 where the format has no such.
    pub(super) instance: u64,
    /// Whether a tree that stands in several places is written once.
    pub(super) once: bool,
}

/// Bytes that all trees of a file take at most.
pub(super) fn most_bytes(stand: &Stand<'_>, costs: Costs) -> u64 {
    let instances = stand.extras.instances && costs.instance > 0;
    let of = |one: &Individual<'_>| {
        let organist = Organist::new(one.organs);
        let apart = if instances {
            one.organs.placed.len()
        } else {
            0
        };
        let loose = 0..one.organs.len() - apart;
        let carried: u64 = loose.map(|index| organist.size(index).0 as u64).sum();
        let vertices = tube_vertices(one).saturating_add(carried);
        let instances = costs.instance.saturating_mul(apart as u64);
        let bytes = vertices
            .saturating_mul(costs.vertex)
            .saturating_add(instances);
        let times = if costs.once { 1 } else { one.places.len() };
        bytes.saturating_mul(times as u64)
    };
    stand.trees.iter().map(of).fold(0, u64::saturating_add)
}

/// Vertices that a tree's tubes may have.
fn tube_vertices(one: &Individual<'_>) -> u64 {
    let nodes = refined_len(one.tree, one.organs);
    let segments = nodes.saturating_sub(one.tree.root_count() as u64);
    segments.saturating_mul(vertices_per_segment(one.params.sides))
}

/// Refuses a tree that breaks an invariant or has nothing to draw, and tubes of too few or too many sides.
fn check(one: &Individual<'_>, format: &'static str) -> Result<(), TreeError> {
    one.tree.validate()?;
    one.organs.validate(one.tree)?;
    let sides = one.params.sides;
    if !SIDES.contains(&sides) {
        let [value, least, most] = [sides, *SIDES.start(), *SIDES.end()].map(f64::from);
        return Err(TreeError::Parameter {
            name: "the number of sides",
            value,
            least,
            most,
        });
    }
    if one.tree.segment_count() == 0 && one.organs.is_bare() {
        return Err(TreeError::Empty(format));
    }
    Ok(())
}

/// Refuses what no file can be made of, and what may become too large a one.
pub(super) fn fits(stand: &Stand<'_>, format: &'static str, costs: Costs) -> Result<(), TreeError> {
    stand.trees.iter().try_for_each(|one| check(one, format))?;
    match most_bytes(stand, costs) {
        bytes if bytes > MOST_BYTES => Err(TreeError::TooLarge { format, bytes }),
        _ => Ok(()),
    }
}

/// The surfaces of all trees of a file, or why they cannot be written.
pub(super) fn standing<'a>(
    stand: &Stand<'a>,
    format: &'static str,
    costs: Costs,
) -> Result<Vec<Standing<'a>>, TreeError> {
    let mut extras = stand.extras;
    extras.instances &= costs.instance > 0;
    fits(stand, format, costs)?;
    let mut room = KEPT;
    let made = stand.trees.iter().map(|one| {
        let mut surface = Surface::new(one, extras)?;
        surface.measure(&mut room)?;
        let standing = Standing {
            places: one.places.clone(),
            surface,
        };
        let groups = standing.surface.groups.iter();
        let mut corners = groups.flat_map(|group| group.bounds);
        let is_finite = |corner: [f32; 3]| {
            let mut places = standing.places.iter();
            places.all(|place| Vec3::from(place.placed(corner)).is_finite())
        };
        match corners.all(is_finite) {
            true => Ok(standing),
            false => Err(TreeError::TooWide),
        }
    });
    let made: Vec<Standing<'_>> = made.collect::<Result<_, TreeError>>()?;
    let is_bare = |one: &Standing<'_>| one.surface.groups.is_empty() && one.surface.runs.is_empty();
    // Corners on a line make no triangle.
    if made.iter().all(is_bare) {
        return Err(TreeError::Empty(format));
    }
    Ok(made)
}

/// All that is to be written of a tree.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    pub(super) tree: &'a Tree,
    /// Of the tubes, one for each node that has a parent.
    pub(super) records: Vec<TubeSegment>,
    pub(super) sides: u32,
    pub(super) organs: &'a Organs,
    looks: LookTable,
    /// Organs, the first ones, that are triangles of their own.
    pub(super) loose: usize,
    /// The others.
    pub(super) runs: Vec<Run>,
    pub(super) bending: Option<Bending>,
    pub(super) unfolding: Option<Unfolding>,
    /// Vertices that its tubes may have.
    tube_vertices: u64,
    /// All tubes where they are kept.
    kept: Vec<(Matter, Tubes)>,
    /// In the order in which they are written; none is empty.
    pub(super) groups: Vec<Group>,
}

impl<'a> Surface<'a> {
    /// The surface of a whole drawing, not measured yet.
    fn new(one: &Individual<'a>, extras: Extras) -> Result<Self, TreeError> {
        let Individual {
            tree,
            organs,
            params,
            ..
        } = *one;
        let ExportParams { sides } = params;
        let segments = tree.segment_count();
        let nodes = refined_len(tree, organs);
        let apart = match extras.instances {
            true => organs.placed.len(),
            false => 0,
        };
        let loose = organs.len() - apart;
        // Asked for once before it is needed in several pieces: those end the program where they are not given.
        let bytes = usize::try_from(nodes)
            .unwrap_or(usize::MAX)
            .saturating_mul(tubes::NODE_BYTES);
        if Vec::<u8>::new().try_reserve_exact(bytes).is_err() {
            return Err(TreeError::Memory(segments));
        }
        let mut records = Vec::new();
        let fine = refined(tree, organs, &[]);
        let drawn = fine.as_ref().map_or(tree, |fine| &fine.tree);
        // Growth 1 is the whole tree whatever was newest.
        tubes::segments(drawn, &[], u32::MAX, &mut records);
        let mut looks = LookTable::default();
        paint_segments(tree, organs, fine.as_ref(), &mut records, &mut looks);
        let runs = match extras.instances {
            true => runs(organs).ok_or(TreeError::TooWide)?,
            false => Vec::new(),
        };
        let bending = extras.wind.then(|| Bending::of(tree, fine.as_ref()));
        let morphs = extras.morphs.min(Extras::MORPHS_MOST);
        let unfolding = (morphs > 0).then(|| Unfolding::of(tree, fine, morphs));
        Ok(Self {
            tree,
            runs,
            loose,
            bending,
            unfolding,
            records,
            sides,
            organs,
            looks,
            tube_vertices: tube_vertices(one),
            kept: Vec::new(),
            groups: Vec::new(),
        })
    }

    /// Finds what there is of each group, and keeps what tubes are made for that where there is room for so many vertices.
    fn measure(&mut self, room: &mut u64) -> Result<(), TreeError> {
        let matters = self.matters();
        if let Some(left) = room.checked_sub(self.tube_vertices) {
            *room = left;
            let mut kept = Vec::new();
            for matter in &matters {
                // Nothing is written, so nothing can fail.
                let _ = self.make_tubes(*matter, |tubes| {
                    kept.push((*matter, tubes));
                    Ok(())
                });
            }
            self.kept = kept;
        }
        let numbers = Numbers {
            indices: true,
            ..Numbers::POSITIONS
        };
        let mut groups = Vec::new();
        for matter in matters {
            let (mut vertices, mut indices) = (0, 0);
            let mut extent = Extent::new();
            let _ = self.each(matter, numbers, |part, _| {
                vertices += part.vertices;
                indices += part.indices.len();
                extent.take(part.positions);
                Ok(())
            });
            let bounds = extent.bounds().ok_or(TreeError::TooWide)?;
            if indices > 0 {
                groups.push(Group {
                    matter,
                    vertices,
                    indices,
                    bounds,
                });
            }
        }
        self.groups = groups;
        Ok(())
    }

    /// All that it is made of, in order.
    fn matters(&self) -> BTreeSet<Matter> {
        let records = self.records.iter().map(|record| self.matter(record));
        let mut matters: BTreeSet<Matter> = records.collect();
        let organist = Organist::new(self.organs);
        let organs = (0..self.loose).filter_map(|index| organist.organ(index));
        matters.extend(organs.map(|organ| Matter::Painted(organ.paint.material)));
        matters
    }

    pub(super) fn matter(&self, record: &TubeSegment) -> Matter {
        look_of(record).map_or(Matter::Bark, |look| {
            Matter::Painted(self.looks.look(look).1)
        })
    }

    /// Shows a group's parts one after the other; each is given with the number of the group's vertices before it. Of what is not kept the numbers that are not
    /// asked for are not made.
    pub(super) fn each(
        &self,
        matter: Matter,
        numbers: Numbers,
        mut take: impl FnMut(Part<'_>, u32) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut before = 0;
        let mut give = |part: Part<'_>| {
            take(part, before)?;
            #[allow(
                clippy::cast_possible_truncation,
                reason = "`new` refuses more vertices than fit u32"
            )]
            let vertices = part.vertices as u32;
            before += vertices;
            Ok::<(), io::Error>(())
        };
        if self.kept.is_empty() {
            self.make_tubes(matter, |tubes| give(tubes.part()))?;
        }
        for (_, tubes) in self.kept.iter().filter(|(of, _)| *of == matter) {
            give(tubes.part())?;
        }
        self.make_organs(matter, numbers, give)
    }

    /// Makes a group's tubes.
    fn make_tubes(
        &self,
        matter: Matter,
        mut take: impl FnMut(Tubes) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut of_matter = self
            .records
            .iter()
            .filter(|record| self.matter(record) == matter)
            .copied()
            .peekable();
        while of_matter.peek().is_some() {
            let records: Vec<TubeSegment> = of_matter.by_ref().take(PART).collect();
            let mut mesh = mesh(&records, 1.0, self.sides);
            let mut colours = Vec::new();
            if matter != Matter::Bark {
                mesh.uvs = Vec::new();
                for record in &records {
                    let (colour, _) = self.looks.look(look_of(record).unwrap_or(0));
                    let vertices = colours.len() + vertices_of(record, self.sides);
                    colours.resize(vertices, colour);
                }
            }
            take(Tubes { mesh, colours })?;
        }
        Ok(())
    }

    /// Makes what is asked for of a group's organs.
    fn make_organs(
        &self,
        matter: Matter,
        numbers: Numbers,
        mut give: impl FnMut(Part<'_>) -> io::Result<()>,
    ) -> io::Result<()> {
        let Matter::Painted(material) = matter else {
            return Ok(());
        };
        let mut organist = Organist::new(self.organs);
        let mut mesh = OrganMesh::default();
        for index in 0..self.loose {
            if organist.organ(index).map(|organ| organ.paint.material) == Some(material) {
                organist.add_only(index, numbers, &mut mesh);
            }
            if mesh.vertices >= ORGAN_PART {
                give(part_of(&mesh))?;
                mesh.clear();
            }
        }
        if mesh.vertices == 0 {
            return Ok(());
        }
        give(part_of(&mesh))
    }
}

/// Smallest and largest coordinates, of four places side by side.
struct Extent {
    low: [f32; 12],
    high: [f32; 12],
    /// 0 as long as all is finite.
    nought: [f32; 12],
}

impl Extent {
    fn new() -> Self {
        Self {
            low: [f32::INFINITY; 12],
            high: [f32::NEG_INFINITY; 12],
            nought: [0.0; 12],
        }
    }

    fn take(&mut self, places: &[[f32; 3]]) {
        let (fours, rest) = places.as_flattened().as_chunks::<12>();
        for four in fours {
            self.add(four);
        }
        for place in rest.as_chunks::<3>().0 {
            let [x, y, z] = *place;
            self.add(&[x, y, z, x, y, z, x, y, z, x, y, z]);
        }
    }

    #[inline]
    fn add(&mut self, four: &[f32; 12]) {
        for (lane, at) in four.iter().enumerate() {
            self.low[lane] = if *at < self.low[lane] {
                *at
            } else {
                self.low[lane]
            };
            self.high[lane] = if *at > self.high[lane] {
                *at
            } else {
                self.high[lane]
            };
            // What is infinite, or no number, times 0 is no number.
            self.nought[lane] += *at * 0.0;
        }
    }

    /// None where a coordinate was not finite.
    fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let of = |lanes: &[f32; 12], least: fn(f32, f32) -> f32| {
            let axis = |axis| {
                [3, 6, 9]
                    .iter()
                    .fold(lanes[axis], |all, more| least(all, lanes[axis + more]))
            };
            [axis(0), axis(1), axis(2)]
        };
        let is_finite = self.nought.iter().all(|nought| *nought == 0.0);
        is_finite.then(|| [of(&self.low, f32::min), of(&self.high, f32::max)])
    }
}

/// Vertices that a segment's mesh has.
pub(super) fn vertices_of(record: &TubeSegment, sides: u32) -> usize {
    let sides = sides as usize;
    let has = |flag, vertices| {
        if record.flags & flag == 0 {
            0
        } else {
            vertices
        }
    };
    2 * (sides + 1) + has(CAPPED, sides) + has(STARTS, sides + 1)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "tests")]
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn an_extent_is_that_of_each_coordinate(places in prop::collection::vec(prop::array::uniform3(-9.0_f32..9.0), 1..40), cut in 0_usize..40, wrong in 0_usize..80) {
            let mut places = places;
            let wrong_value = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][wrong % 3];
            let is_wrong = wrong < places.len();
            if is_wrong {
                places[wrong][wrong % 3] = wrong_value;
            }
            let mut extent = Extent::new();
            let (one, other) = places.split_at(cut.min(places.len()));
            extent.take(one);
            extent.take(other);
            let all = |axis: usize| places.iter().map(move |place| place[axis]);
            let bounds = [0, 1, 2].map(|axis| {
                (all(axis).fold(f32::INFINITY, f32::min), all(axis).fold(f32::NEG_INFINITY, f32::max))
            });
            let expected = [bounds.map(|(low, _)| low), bounds.map(|(_, high)| high)];
            prop_assert_eq!(extent.bounds(), (!is_wrong).then_some(expected));
        }
    }
}
