//! Wavefront OBJ: positions, texture coordinates, normals, triangles, and colours where something is painted.
//!
//! Colours stand behind the positions (`v x y z r g b`, sRGB as MeshLab and Blender write and read them), once one thing is painted on all
//! vertices, since readers take colours for all or none. No material: an OBJ would need a second file (`.mtl`) and a third (the
//! picture) beside it, and a reader that finds a material named but not its file warns or fails. Who wants bark and
//! materials takes the GLB; the texture coordinates are here too.

use std::io::{self, Write};

use super::surface::{Costs, Group, Matter, Standing, everywhere, fits, standing};
use super::{ExportParams, Place, Stand, TREE};
use crate::tree::organs::{Numbers, Organs, bark_colour, srgb};
use crate::tree::{Tree, TreeError};

/// What the text of one vertex with its share of the faces takes at most, roughly.
const COSTS: Costs = Costs {
    vertex: 65 + 40 + 30 + 2 * 60,
    instance: 0,
    once: false,
};

/// The tree as an OBJ file, in metres, Y up.
///
/// # Errors
/// As [`Obj::new`].
pub fn obj(tree: &Tree, params: &ExportParams) -> Result<Vec<u8>, TreeError> {
    let organs = Organs::default();
    let file = Obj::new(tree, &organs, params)?;
    let mut text = Vec::new();
    let _ = file.write(&mut text); // Writing into a vector cannot fail.
    Ok(text)
}

/// An OBJ file that is checked and not written yet.
#[derive(Debug)]
pub struct Obj<'a> {
    trees: Vec<Standing<'a>>,
    segments: usize,
}

impl<'a> Obj<'a> {
    /// Checks a tree and what it carries.
    ///
    /// # Errors
    /// A tree that breaks an invariant, has nothing to draw or is too large; sides outside 3 to 64.
    pub fn new(
        tree: &'a Tree,
        organs: &'a Organs,
        params: &ExportParams,
    ) -> Result<Self, TreeError> {
        Self::of(&Stand::of(TREE, tree, organs, params))
    }

    /// Whether there is room in such a file for all that stands in it, before any surface is made.
    ///
    /// # Errors
    /// [`TreeError::TooLarge`].
    pub fn check(stand: &Stand<'_>) -> Result<(), TreeError> {
        fits(stand, "OBJ", COSTS)
    }

    /// The same of all that stands in a file, each tree an object.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(stand: &Stand<'a>) -> Result<Self, TreeError> {
        Ok(Self {
            trees: standing(stand, "OBJ", COSTS)?,
            segments: stand.segments(),
        })
    }

    /// Writes the file, part by part.
    ///
    /// # Errors
    /// What `out` fails in.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let what = match everywhere(&self.trees).count() {
            1 => "a tree".to_owned(),
            trees => format!("{trees} trees"),
        };
        writeln!(
            out,
            "# Ramus {}: {what} of {} segments; metres, Y up",
            env!("CARGO_PKG_VERSION"),
            self.segments
        )?;
        let mut groups = self.trees.iter().flat_map(|one| &one.surface.groups);
        let painted = groups.any(|group| group.matter != Matter::Bark);
        let mut first = First {
            vertex: 1,
            coordinate: 1,
        };
        for (one, place) in everywhere(&self.trees) {
            // One word, since some readers end a name at the first space.
            let name = place
                .name
                .replace(|c: char| c.is_whitespace() || c.is_control(), "_");
            writeln!(out, "o {name}")?;
            vertices(one, place, painted, out)?;
            for group in &one.surface.groups {
                faces(one, group, &first, out)?;
                first.vertex += group.vertices as u64;
                if group.matter == Matter::Bark {
                    first.coordinate += group.vertices as u64;
                }
            }
        }
        Ok(())
    }
}

/// The numbers of the next vertex and the next texture coordinates.
struct First {
    vertex: u64,
    coordinate: u64,
}

fn vertices(
    one: &Standing<'_>,
    place: &Place,
    painted: bool,
    out: &mut dyn Write,
) -> io::Result<()> {
    let surface = &one.surface;
    for group in &surface.groups {
        let numbers = Numbers {
            colours: painted,
            ..Numbers::POSITIONS
        };
        surface.each(group.matter, numbers, |part, _| {
            for (at, position) in part.positions.iter().enumerate() {
                let [x, y, z] = place.placed(*position);
                if !painted {
                    writeln!(out, "v {x} {y} {z}")?;
                    continue;
                }
                let colour = part.colours.get(at).copied().unwrap_or_else(bark_colour);
                let [r, g, b] = colour.map(srgb);
                writeln!(out, "v {x} {y} {z} {r:.4} {g:.4} {b:.4}")?;
            }
            Ok(())
        })?;
    }
    for group in &surface.groups {
        surface.each(group.matter, Numbers::NONE, |part, _| {
            let mut lines = part.uvs.iter();
            lines.try_for_each(|[u, v]| writeln!(out, "vt {u} {v}"))
        })?;
    }
    // Five digits are finer than any shading shows and halve the file.
    for group in &surface.groups {
        surface.each(group.matter, Numbers::NORMALS, |part, _| {
            let mut lines = part.normals.iter().map(|normal| place.turned(*normal));
            lines.try_for_each(|[x, y, z]| writeln!(out, "vn {x:.5} {y:.5} {z:.5}"))
        })?;
    }
    Ok(())
}

fn faces(one: &Standing<'_>, group: &Group, first: &First, out: &mut dyn Write) -> io::Result<()> {
    let has_uvs = group.matter == Matter::Bark;
    one.surface
        .each(group.matter, Numbers::INDICES, |part, before| {
            part.indices.chunks_exact(3).try_for_each(|triangle| {
                let corners = [triangle[0], triangle[1], triangle[2]]
                    .map(|index| u64::from(index) + u64::from(before));
                let [a, b, c] = corners.map(|corner| corner + first.vertex);
                if has_uvs {
                    let [u, v, w] = corners.map(|corner| corner + first.coordinate);
                    writeln!(out, "f {a}/{u}/{a} {b}/{v}/{b} {c}/{w}/{c}")
                } else {
                    writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")
                }
            })
        })
}
