//! What a file will hold and about how long it will be, told before it is written.

use serde::Serialize;

use super::coarse::Coarse;
use super::files::Format;
use crate::tree::export::Extras;
use crate::tree::organs::Organist;
use crate::tree::{Drawing, NO_PARENT};

/// What a file holds besides triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Holds {
    /// Things that stand as instances.
    #[serde(skip_serializing_if = "Option::is_none")]
    instances: Option<u64>,
    /// Steps that are morph targets.
    #[serde(skip_serializing_if = "Option::is_none")]
    morphs: Option<u32>,
    /// Pixels of a picture's side.
    #[serde(skip_serializing_if = "Option::is_none")]
    texture: Option<u32>,
    /// Bytes of all pictures.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture_bytes: Option<u64>,
}

impl Holds {
    pub(super) fn of(format: Format, drawing: &Drawing, extras: &Extras) -> Self {
        let Drawing { tree, organs } = drawing;
        let is_asked = extras.texture.is_some();
        let is_glb = format == Format::Glb;
        let instanced = extras.instances && (is_glb || format == Format::Usda);
        let newest = tree.birth.iter().copied().max().unwrap_or(0);
        let morphs = extras.morphs.min(newest);
        let pictures = shown(format, drawing, extras).filter(|_| is_asked);
        // Where a PNG keeps its width.
        let side = pictures.and_then(|[colour, ..]| colour.get(16..).and_then(<[u8]>::first_chunk));
        Self {
            instances: instanced.then_some(organs.placed.len() as u64),
            morphs: (is_glb && morphs > 0).then_some(morphs),
            texture: side.map(|side| u32::from_be_bytes(*side)),
            picture_bytes: pictures.map(bytes_of),
        }
    }

    /// Of two trees in one file.
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            instances: match (self.instances, other.instances) {
                (Some(one), Some(another)) => Some(one + another),
                (one, another) => one.or(another),
            },
            morphs: self.morphs.max(other.morphs),
            // They share their pictures.
            texture: self.texture.max(other.texture),
            picture_bytes: self.picture_bytes.max(other.picture_bytes),
        }
    }

    /// As part of a line.
    pub(super) fn line(&self) -> String {
        let mut line = String::new();
        if let Some(instances) = self.instances {
            line += &format!(", {instances} instances");
        }
        if let Some(morphs) = self.morphs {
            line += &format!(", {morphs} morph targets");
        }
        if let (Some(side), Some(bytes)) = (self.texture, self.picture_bytes) {
            line += &format!(", pictures of {side} pixels in {} kB", bytes.div_ceil(1000));
        }
        line
    }
}

/// The pictures that a file has of a tree's bark; `None` where it shows none.
fn shown(format: Format, drawing: &Drawing, extras: &Extras) -> Option<&'static [Vec<u8>; 3]> {
    let Drawing { tree, organs } = drawing;
    let is_bark = |node: usize| {
        let paint = organs.paints.get(node).copied().unwrap_or_default();
        organs.palette.is_bark(paint)
    };
    let mut segments = (0..tree.len()).filter(|node| tree.parent[*node] != NO_PARENT);
    if format != Format::Glb || !segments.any(is_bark) {
        return None;
    }
    match extras.texture {
        Some(most) => organs.bark.pngs_within(most).ok(),
        None => organs.bark.pngs().ok(),
    }
}

fn bytes_of(pictures: &[Vec<u8>; 3]) -> u64 {
    pictures.iter().map(|one| one.len() as u64).sum()
}

/// Bytes that a file has of pictures, once for all trees of one bark.
pub(super) fn pictures(format: Format, drawing: &Drawing, extras: &Extras) -> u64 {
    shown(format, drawing, extras).map_or(0, bytes_of)
}

/// Bytes that a tree takes as a file, about.
pub(super) fn estimated(format: Format, coarse: &Coarse, extras: &Extras) -> u64 {
    surface(format, coarse, extras) + pictures(format, &coarse.drawing, extras)
}

/// The same without pictures.
pub(super) fn surface(format: Format, coarse: &Coarse, extras: &Extras) -> u64 {
    let organs = &coarse.drawing.organs;
    let holds = Holds::of(format, &coarse.drawing, extras);
    let instances = holds.instances.unwrap_or(0);
    let organist = Organist::new(organs);
    let (mut vertices, mut carried, mut apart) = (0, 0, 0);
    for index in 0..organs.len() {
        let (own, corners) = organist.size(index);
        let is_placed = index >= organs.polygons.len() + organs.spheres.len();
        if is_placed && instances > 0 {
            apart += corners as u64 / 3;
        } else {
            vertices += own as u64;
            carried += corners as u64 / 3;
        }
    }
    // Tubes have a corner more in each ring than sides, for the texture's seam.
    let tubes = coarse.triangles.saturating_sub(carried + apart);
    vertices += tubes + tubes / u64::from(coarse.sides);
    let triangles = tubes + carried;
    match format {
        Format::Glb => {
            let wind = if extras.wind { 12 } else { 0 };
            let morphs = 12 * u64::from(holds.morphs.unwrap_or(0));
            (32 + wind + morphs) * vertices + 12 * triangles + 32 * instances
        }
        Format::Ply => 35 * vertices + 13 * triangles,
        Format::Usda => 97 * vertices + 30 * triangles + 105 * instances,
        Format::Obj => 86 * vertices + 51 * triangles,
        Format::Swc | Format::Lsys => 0,
    }
}
