//! What the textured look of a mesh is drawn with: its file's [paint](super::paint), decoded and in the form that devices take.
//!
//! All images of a model are layers of one array of one size, so that one draw shows triangles of all materials; smaller ones are stretched, and all
//! of them are halved until they fit [`LayerLimits`]. A model with one image, as scans mostly have it, keeps that as it is. What is beyond an image's
//! edges is the material's matter, so nothing has to be repeated within a layer. *Left*: an array of images of different sizes, which not every device
//! indexes by a number that differs from pixel to pixel.

mod layers;
mod moved;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec2;
use rayon::prelude::*;

pub use self::layers::{LayerLimits, Layers, Part};
pub use self::moved::moved;
use super::Mesh;
use super::colour::Colour;
use super::paint::{Alpha, Image, ImageLimits, Material, Paint, Pixels, VertexColour};
use super::report::NONE;
use super::srgb::byte;

/// Looks that one place may have before its vertices are not compared any more: a file may have all its vertices in one place.
const MOST_LOOKS: usize = 64;

/// How a mesh looks as its file colours it.
#[derive(Clone, Debug, PartialEq)]
pub struct Textured {
    /// For each vertex, where it is in an image, (0, 0) the upper left corner; empty where none has any.
    pub coordinates: Vec<Vec2>,
    /// For each vertex, what its material's colour is multiplied by: sRGB with alpha. Empty where no vertex has any.
    pub colours: Vec<Colour>,
    /// For each triangle the number of its material. Empty where all have the first.
    pub triangle_materials: Vec<u16>,
    /// Materials, one at least; each [`Texture::image`](super::paint::Texture::image) is a layer.
    pub materials: Vec<Material>,
    /// The images.
    pub layers: Layers,
}

impl Textured {
    /// Decodes a model's paint; none where it has no colour. With it, in a sentence each, what is not shown of it. `None` when somebody asked to stop.
    pub fn new(
        paint: Paint,
        limits: &LayerLimits,
        cancel: &AtomicBool,
    ) -> Option<(Option<Self>, Vec<String>)> {
        if paint.materials.is_empty() && paint.colours.is_empty() {
            return Some((None, Vec::new()));
        }
        let mut materials = paint.materials;
        if materials.is_empty() {
            materials.push(painted_only());
        }
        let Decoded {
            images,
            places,
            remarks,
        } = decoded(&paint.images, limits, cancel)?;
        for image in materials.iter_mut().flat_map(Material::images_mut) {
            *image = image.and_then(|mut texture| {
                texture.image = places.get(texture.image as usize).copied().flatten()?;
                Some(texture)
            });
        }
        Some((
            Some(Self {
                layers: Layers::new(images, limits, cancel)?,
                coordinates: paint.texture_coordinates,
                colours: paint.colours.par_iter().map(srgb).collect(),
                triangle_materials: paint.triangle_materials,
                materials,
            }),
            remarks,
        ))
    }

    /// For each vertex the first that it can be taken for: of the same place, the same place in images and the same colour. `places` has for each vertex
    /// the one that stands for its place.
    pub(super) fn joined(&self, places: &[u32]) -> Vec<u32> {
        if self.coordinates.is_empty() && self.colours.is_empty() {
            return places.to_vec();
        }
        let look = |vertex: u32| {
            let at = self.coordinate(vertex);
            (at.x.to_bits(), at.y.to_bits(), self.colour(vertex))
        };
        // Of each place, the vertices found so far, from the newest to the oldest.
        let mut newest = vec![NONE; places.len()];
        let mut older = vec![NONE; places.len()];
        let one = |(vertex, place): (u32, &u32)| {
            let start = newest.get_mut(*place as usize)?;
            let known = std::iter::successors(Some(*start), |at| older.get(*at as usize).copied());
            let mut known = known.take_while(|at| *at != NONE).take(MOST_LOOKS);
            if let Some(same) = known.find(|at| look(*at) == look(vertex)) {
                return Some(same);
            }
            *older.get_mut(vertex as usize)? = *start;
            *start = vertex;
            Some(vertex)
        };
        let numbered = (0_u32..).zip(places);
        numbered.map(one).map(Option::unwrap_or_default).collect()
    }

    /// By place, whether triangles of several materials meet there; empty where all have one.
    pub(super) fn borders(&self, mesh: &Mesh, places: &[u32]) -> Vec<bool> {
        if self.triangle_materials.is_empty() {
            return Vec::new();
        }
        let mut borders = vec![false; places.len()];
        let mut materials = vec![NONE; places.len()];
        for (number, triangle) in (0_u32..).zip(&mesh.triangles) {
            let material = self.material_of(number);
            for vertex in triangle {
                let place = places.get(*vertex as usize).copied().unwrap_or(0) as usize;
                if let (Some(known), Some(border)) =
                    (materials.get_mut(place), borders.get_mut(place))
                {
                    *border |= *known != NONE && *known != material;
                    *known = material;
                }
            }
        }
        borders
    }

    /// The number of a triangle's material.
    #[must_use]
    pub fn material_of(&self, triangle: u32) -> u32 {
        let number = self.triangle_materials.get(triangle as usize);
        let known = number.filter(|&&number| usize::from(number) < self.materials.len());
        known.copied().map_or(0, u32::from)
    }

    /// Where a vertex is in an image.
    #[must_use]
    pub fn coordinate(&self, vertex: u32) -> Vec2 {
        let known = self.coordinates.get(vertex as usize);
        known.copied().unwrap_or_default()
    }

    /// What a vertex's material is multiplied by.
    #[must_use]
    pub fn colour(&self, vertex: u32) -> Colour {
        let known = self.colours.get(vertex as usize);
        known.copied().unwrap_or([u8::MAX; 4])
    }
}

/// Images of a model, the same ones once.
#[derive(Default)]
struct Decoded {
    images: Vec<Pixels>,
    /// For each that was given which of them it is; none where it cannot be shown.
    places: Vec<Option<u32>>,
    remarks: Vec<String>,
}

/// Decodes images. `None` when somebody asked to stop.
fn decoded(given: &[Image], limits: &LayerLimits, cancel: &AtomicBool) -> Option<Decoded> {
    // By number the first of the same bytes: files may name one image by the hundred.
    let same = |image: &Image| {
        given
            .iter()
            .position(|other| other.encoded == image.encoded)
    };
    let firsts: Vec<Option<usize>> = given.iter().map(same).collect();
    let is_first = |number: usize| firsts.get(number) == Some(&Some(number));
    let count = (0..given.len()).filter(|number| is_first(*number)).count();
    let mut all = Decoded::default();
    for ((number, image), first) in given.iter().enumerate().zip(&firsts) {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let place = if is_first(number) {
            all.decode(image, limits, count)
        } else {
            first.and_then(|first| all.places.get(first).copied().flatten())
        };
        all.places.push(place);
    }
    Some(all)
}

impl Decoded {
    /// Decodes one of so many, and says which it has become. Decoded ones wait for each other: as many as the layers may hold, each made as small as
    /// those are.
    fn decode(&mut self, image: &Image, limits: &LayerLimits, count: usize) -> Option<u32> {
        let place = u32::try_from(self.images.len()).ok();
        let place = place.filter(|place| *place < limits.count);
        let decoded = match place {
            Some(_) => image
                .decode(&ImageLimits::default())
                .map_err(|fault| fault.to_string()),
            None => Err(format!("more than {} images are not shown", limits.count)),
        };
        match decoded {
            Ok(pixels) => {
                self.images.push(limits.fitted(pixels, count));
                place
            }
            Err(remark) => {
                if !self.remarks.contains(&remark) {
                    self.remarks.push(remark);
                }
                None
            }
        }
    }
}

/// What has colours at its vertices and no word on its matter: as scans are, dull, and painted on both sides.
fn painted_only() -> Material {
    Material {
        metallic: 0.0,
        roughness: 0.9,
        alpha: Alpha::Opaque,
        is_double_sided: true,
        ..Material::default()
    }
}

/// A linear colour in eight bits a channel: by the eye's measure, so that the dark has steps enough.
fn srgb(&[red, green, blue, alpha]: &VertexColour) -> Colour {
    let [alpha, _] = alpha.to_be_bytes();
    [byte(red), byte(green), byte(blue), alpha]
}

#[cfg(test)]
mod tests;
