//! The triangles of a drawing, in groups of one material, made part by part.
//!
//! Bark comes first: tubes without a colour of their own, with texture coordinates. Then, for each material, painted tubes and organs, with
//! a colour at each vertex.

use std::collections::BTreeSet;
use std::io;

use glam::Vec3;

use super::{ExportParams, MOST_BYTES, PART};
use crate::tree::mesh::{SIDES, TubeMesh, mesh, vertices_per_segment};
use crate::tree::organs::{
    Colour, LookTable, OrganMesh, Organist, Organs, look_of, paint_segments, refined, refined_len,
};
use crate::tree::tubes::{self, CAPPED, STARTS, TubeSegment};
use crate::tree::{Tree, TreeError};

/// Vertices of organs that are in memory at a time.
const ORGAN_PART: usize = 1 << 16;
/// Surfaces that may have so many vertices are made once and kept: some forty megabytes, since most segments have half as many as they may.
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

/// Some of a group's triangles.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Of bark only.
    pub(super) uvs: Vec<[f32; 2]>,
    /// Of painted things only; linear.
    pub(super) colours: Vec<Colour>,
    /// From the part's own first vertex on.
    pub(super) indices: Vec<u32>,
}

impl Part {
    fn bark(mesh: TubeMesh) -> Self {
        Self {
            positions: mesh.positions,
            normals: mesh.normals,
            uvs: mesh.uvs,
            colours: Vec::new(),
            indices: mesh.indices,
        }
    }

    fn organs(mesh: OrganMesh) -> Self {
        Self {
            positions: mesh.positions,
            normals: mesh.normals,
            uvs: Vec::new(),
            colours: mesh.colours,
            indices: mesh.indices,
        }
    }
}

/// All that is to be written.
#[derive(Debug)]
pub(super) struct Surface<'a> {
    records: Vec<TubeSegment>,
    sides: u32,
    organs: &'a Organs,
    looks: LookTable,
    /// All parts where they are kept, with the vertices of their group before them.
    kept: Vec<(Matter, u32, Part)>,
    /// In the order in which they are written; none is empty.
    pub(super) groups: Vec<Group>,
}

impl<'a> Surface<'a> {
    /// The surface of a whole drawing, or why it cannot be written; `vertex_bytes` is what one vertex takes at most.
    pub(super) fn new(
        tree: &Tree,
        organs: &'a Organs,
        params: &ExportParams,
        format: &'static str,
        vertex_bytes: u64,
    ) -> Result<Self, TreeError> {
        tree.validate()?;
        organs.validate(tree)?;
        let ExportParams { sides } = *params;
        if !SIDES.contains(&sides) {
            let [value, least, most] = [sides, *SIDES.start(), *SIDES.end()].map(f64::from);
            return Err(TreeError::Parameter {
                name: "the number of sides",
                value,
                least,
                most,
            });
        }
        let segments = tree.segment_count();
        if segments == 0 && organs.is_bare() {
            return Err(TreeError::Empty(format));
        }
        let nodes = refined_len(tree, organs);
        let tubes = (nodes - tree.root_count() as u64).saturating_mul(vertices_per_segment(sides));
        let organist = Organist::new(organs);
        let carried: u64 = (0..organs.len())
            .map(|index| organist.size(index).0 as u64)
            .sum();
        if (tubes + carried).saturating_mul(vertex_bytes) > MOST_BYTES {
            return Err(TreeError::TooLarge {
                format,
                segments,
                sides,
            });
        }
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
        let mut surface = Self {
            records,
            sides,
            organs,
            looks,
            kept: Vec::new(),
            groups: Vec::new(),
        };
        surface.groups = surface.measured(tubes + carried <= KEPT)?;
        Ok(surface)
    }

    /// What there is of each group; `keeps` what is made for it.
    fn measured(&mut self, keeps: bool) -> Result<Vec<Group>, TreeError> {
        let mut matters = BTreeSet::new();
        for record in &self.records {
            matters.insert(self.matter(record));
        }
        let organist = Organist::new(self.organs);
        for organ in (0..self.organs.len()).filter_map(|index| organist.organ(index)) {
            matters.insert(Matter::Painted(organ.paint.material));
        }
        let (mut groups, mut kept) = (Vec::new(), Vec::new());
        for matter in matters {
            let mut group = Group {
                matter,
                vertices: 0,
                indices: 0,
                bounds: [[0.0; 3]; 2],
            };
            let mut finite = true;
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            // What is counted is not written, so nothing can fail.
            let _ = self.make(matter, |part, before| {
                group.vertices += part.positions.len();
                group.indices += part.indices.len();
                for position in part.positions.iter().map(|p| Vec3::from(*p)) {
                    finite &= position.is_finite();
                    (low, high) = (low.min(position), high.max(position));
                }
                if keeps {
                    kept.push((matter, before, part));
                }
                Ok(())
            });
            if !finite {
                return Err(TreeError::TooWide);
            }
            group.bounds = [low.to_array(), high.to_array()];
            if group.indices > 0 {
                groups.push(group);
            }
        }
        self.kept = kept;
        Ok(groups)
    }

    fn matter(&self, record: &TubeSegment) -> Matter {
        look_of(record).map_or(Matter::Bark, |look| {
            Matter::Painted(self.looks.look(look).1)
        })
    }

    /// Shows a group's parts one after the other; each is given with the number of the group's vertices before it.
    pub(super) fn each(
        &self,
        matter: Matter,
        mut take: impl FnMut(&Part, u32) -> io::Result<()>,
    ) -> io::Result<()> {
        if self.kept.is_empty() {
            return self.make(matter, |part, before| take(&part, before));
        }
        let mut own = self.kept.iter().filter(|(of, ..)| *of == matter);
        own.try_for_each(|(_, before, part)| take(part, *before))
    }

    /// Makes a group's parts.
    fn make(
        &self,
        matter: Matter,
        mut take: impl FnMut(Part, u32) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut before = 0;
        let mut give = |part: Part| {
            #[allow(
                clippy::cast_possible_truncation,
                reason = "`new` refuses more vertices than fit u32"
            )]
            let vertices = part.positions.len() as u32;
            take(part, before)?;
            before += vertices;
            Ok::<(), io::Error>(())
        };
        let mut of_matter = self
            .records
            .iter()
            .filter(|record| self.matter(record) == matter)
            .copied()
            .peekable();
        while of_matter.peek().is_some() {
            let records: Vec<TubeSegment> = of_matter.by_ref().take(PART).collect();
            let mut part = Part::bark(mesh(&records, 1.0, self.sides));
            if matter != Matter::Bark {
                part.uvs = Vec::new();
                for record in &records {
                    let (colour, _) = self.looks.look(look_of(record).unwrap_or(0));
                    let vertices = part.colours.len() + vertices_of(record, self.sides);
                    part.colours.resize(vertices, colour);
                }
            }
            give(part)?;
        }
        let Matter::Painted(material) = matter else {
            return Ok(());
        };
        let mut organist = Organist::new(self.organs);
        let mut mesh = OrganMesh::default();
        for index in 0..self.organs.len() {
            if organist.organ(index).map(|organ| organ.paint.material) == Some(material) {
                organist.add(index, &mut mesh);
            }
            if mesh.positions.len() >= ORGAN_PART {
                give(Part::organs(std::mem::take(&mut mesh)))?;
            }
        }
        if mesh.positions.is_empty() {
            return Ok(());
        }
        give(Part::organs(mesh))
    }
}

/// Vertices that a segment's mesh has.
fn vertices_of(record: &TubeSegment, sides: u32) -> usize {
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
