//! What colours a model's surface: materials, colours and texture coordinates at the vertices, and images.
//!
//! Flat arrays beside those of [`super::Mesh`], each empty where the file has nothing of the kind, so that a scan without colours takes
//! no memory for them. Materials are glTF's (metallic and rough, §3.9 of its specification), as far as they are drawn here: all
//! but occlusion, which other light than the stage's makes, and images that do not lie as the base colour's does. Images stay as the file has them, PNG or JPEG, and are decoded when somebody wants to show them: a model of
//! a gigabyte of textures is measured without looking at one. Colours are linear; 16 bits a channel, since eight would show bands
//! in the dark, and floats would take twice as much.

use std::io::Cursor;
use std::sync::Arc;

use glam::{Affine2, Vec2, Vec3, Vec4};
use image::{ImageFormat, ImageReader};

use super::MeshError;

/// A colour, linear and not multiplied by its alpha, 65535 for 1.
pub type VertexColour = [u16; 4];

/// White that hides what is behind it.
pub const WHITE: VertexColour = [u16::MAX; 4];

/// What colours a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paint {
    /// For each vertex, where it is in an image: (0, 0) is the upper left corner, (1, 1) the lower right one. Empty where no vertex has any.
    pub texture_coordinates: Vec<Vec2>,
    /// For each vertex, what its material's colour is multiplied by. Empty where no vertex has any.
    pub colours: Vec<VertexColour>,
    /// For each triangle the number of its material. Empty where all have the first.
    pub triangle_materials: Vec<u16>,
    /// Materials; empty where there are only colours.
    pub materials: Vec<Material>,
    /// Images that materials name.
    pub images: Vec<Image>,
}

/// How a surface looks.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// As the file calls it, or nothing.
    pub name: String,
    /// Linear colour and alpha, by which the image is multiplied.
    pub base_colour: Vec4,
    /// The image, where it has one.
    pub base_colour_image: Option<Texture>,
    /// What it shines by itself, linear; by this its image is multiplied.
    pub emission: Vec3,
    /// Where it shines, and in which colour.
    pub emission_image: Option<Texture>,
    /// Green is by how much roughness, blue by how much metal is multiplied.
    pub metal_roughness_image: Option<Texture>,
    /// Where normals point: red to the image's right, green to its top, blue outwards, from 0 for −1 to 1.
    pub normal_image: Option<Texture>,
    /// What red and green of those are multiplied by.
    pub normal_scale: f32,
    /// From 0, as stone, to 1, as metal.
    pub metallic: f32,
    /// From 0, as a mirror, to 1, dull.
    pub roughness: f32,
    /// What alpha means.
    pub alpha: Alpha,
    /// Whether its back is seen, too.
    pub is_double_sided: bool,
    /// Whether it has its colour in any light.
    pub is_unlit: bool,
}

impl Default for Material {
    /// glTF's: white, and metal where it is lit.
    fn default() -> Self {
        Self {
            name: String::new(),
            base_colour: Vec4::ONE,
            base_colour_image: None,
            emission: Vec3::ZERO,
            emission_image: None,
            metal_roughness_image: None,
            normal_image: None,
            normal_scale: 1.0,
            metallic: 1.0,
            roughness: 1.0,
            alpha: Alpha::Opaque,
            is_double_sided: false,
            is_unlit: false,
        }
    }
}

impl Material {
    /// Its images: base colour, emission, metal and roughness, normals. Where there are several, they lie as the first does.
    #[must_use]
    pub fn images(&self) -> [Option<Texture>; 4] {
        [
            self.base_colour_image,
            self.emission_image,
            self.metal_roughness_image,
            self.normal_image,
        ]
    }

    pub(super) fn images_mut(&mut self) -> [&mut Option<Texture>; 4] {
        [
            &mut self.base_colour_image,
            &mut self.emission_image,
            &mut self.metal_roughness_image,
            &mut self.normal_image,
        ]
    }
}

/// What alpha means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Alpha {
    /// Nothing: all is seen.
    Opaque,
    /// What has less than this is not there at all.
    Mask(f32),
    /// As much as it says lets what is behind shine through.
    Blend,
}

/// An image on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Which of [`Paint::images`].
    pub image: u32,
    /// What texture coordinates are turned, scaled and moved by (`KHR_texture_transform`).
    pub image_from_texture: Affine2,
    /// What is beyond the image's edges, across and down.
    pub wrap: [Wrap; 2],
}

/// What is beyond an image's edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The same again.
    Repeat,
    /// The same again, mirrored each second time.
    Mirror,
    /// Its edge.
    Clamp,
}

/// How an image is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageKind {
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

impl ImageKind {
    /// What bytes are by their first ones; files' own words on it are not looked at.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        match bytes {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [0xFF, 0xD8, 0xFF, ..] => Some(Self::Jpeg),
            _ => None,
        }
    }

    fn format(self) -> ImageFormat {
        match self {
            Self::Png => ImageFormat::Png,
            Self::Jpeg => ImageFormat::Jpeg,
        }
    }
}

impl std::fmt::Display for ImageKind {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str(match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
        })
    }
}

/// An image as the file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// As the file calls it, else its number.
    pub name: String,
    /// How it is written.
    pub kind: ImageKind,
    /// Width and height, as its first bytes say.
    pub size_px: [u32; 2],
    /// Its bytes.
    pub encoded: Arc<Vec<u8>>,
}

/// How large an image may be; larger ones are refused before memory is taken.
#[derive(Clone, Copy, Debug)]
pub struct ImageLimits {
    /// Width and height.
    pub side_px: u32,
    /// Bytes of the decoded image, four a pixel.
    pub bytes: u64,
}

impl Default for ImageLimits {
    /// What graphics cards take: 16,384 a side, and 256 MiB, which is 8,192 × 8,192.
    fn default() -> Self {
        Self {
            side_px: 16_384,
            bytes: 256 << 20,
        }
    }
}

/// A decoded image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Width and height.
    pub size_px: [u32; 2],
    /// Red, green, blue (sRGB) and alpha, row after row from the top.
    pub rgba: Vec<u8>,
}

impl Image {
    /// Looks at an image's first bytes.
    ///
    /// # Errors
    /// Bytes that are neither PNG nor JPEG, or do not even begin as such; images beyond the limits.
    pub fn new(
        name: String,
        encoded: Arc<Vec<u8>>,
        limits: &ImageLimits,
    ) -> Result<Self, MeshError> {
        let fault = |problem: String| MeshError::Image {
            name: name.clone(),
            problem,
        };
        let Some(kind) = ImageKind::of(&encoded) else {
            return Err(fault("it is neither PNG nor JPEG: save it as one".into()));
        };
        let reader = ImageReader::with_format(Cursor::new(encoded.as_slice()), kind.format());
        let (width, height) = reader
            .into_dimensions()
            .map_err(|error| fault(damaged(kind, &error)))?;
        let size_px = [width, height];
        check_size(size_px, limits).map_err(&fault)?;
        Ok(Self {
            name,
            kind,
            size_px,
            encoded,
        })
    }

    /// Decodes the image.
    ///
    /// # Errors
    /// An image beyond the limits, or a damaged one.
    pub fn decode(&self, limits: &ImageLimits) -> Result<Pixels, MeshError> {
        self.decoded(limits).map_err(|problem| MeshError::Image {
            name: self.name.clone(),
            problem,
        })
    }

    fn decoded(&self, limits: &ImageLimits) -> Result<Pixels, String> {
        check_size(self.size_px, limits)?;
        let mut reader =
            ImageReader::with_format(Cursor::new(self.encoded.as_slice()), self.kind.format());
        let mut most = image::Limits::no_limits();
        most.max_image_width = Some(limits.side_px);
        most.max_image_height = Some(limits.side_px);
        // Images of 16 bits a channel take twice as much on the way.
        most.max_alloc = Some(limits.bytes.saturating_mul(2));
        reader.limits(most);
        let image = reader
            .decode()
            .map_err(|error| damaged(self.kind, &error))?;
        let image = image.into_rgba8();
        Ok(Pixels {
            size_px: [image.width(), image.height()],
            rgba: image.into_raw(),
        })
    }
}

fn damaged(kind: ImageKind, error: &image::ImageError) -> String {
    if let image::ImageError::Limits(_) = error {
        return "it has more pixels than are shown: make it smaller".into();
    }
    format!("the {kind} image is damaged ({error}): save it again")
}

fn check_size([width, height]: [u32; 2], limits: &ImageLimits) -> Result<(), String> {
    let side = limits.side_px;
    let bytes = 4 * u64::from(width) * u64::from(height);
    if bytes == 0 {
        return Err("it has no pixels: save it again".into());
    }
    if width > side || height > side || bytes > limits.bytes {
        return Err(format!(
            "it has {width} × {height} pixels, more than {side} a side or {} in all: make it smaller",
            limits.bytes / 4
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    fn encoded(width: u32, height: u32, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Vec::new();
        let image = image::RgbImage::from_pixel(width, height, image::Rgb([200, 100, 50]));
        image
            .write_to(&mut Cursor::new(&mut bytes), format)
            .unwrap();
        bytes
    }

    fn look(bytes: &[u8]) -> Result<Image, MeshError> {
        Image::new(
            "bark".into(),
            Arc::new(bytes.to_vec()),
            &ImageLimits::default(),
        )
    }

    #[test]
    fn images_are_told_by_content_and_decoded() {
        for (format, kind) in [
            (ImageFormat::Png, ImageKind::Png),
            (ImageFormat::Jpeg, ImageKind::Jpeg),
        ] {
            let image = look(&encoded(20, 10, format)).unwrap();
            assert_eq!((image.kind, image.size_px), (kind, [20, 10]));
            let pixels = image.decode(&ImageLimits::default()).unwrap();
            assert_eq!(pixels.size_px, [20, 10]);
            assert_eq!(pixels.rgba.len(), 800);
            let [red, green, blue, alpha] = *pixels.rgba.first_chunk().unwrap();
            for (found, expected) in [(red, 200), (green, 100), (blue, 50)] {
                assert!(u8::abs_diff(found, expected) <= 3, "{kind}: {found}");
            }
            assert_eq!(alpha, 255);
        }
    }

    #[test]
    fn bombs_and_broken_images_are_refused_in_a_sentence() {
        let png = encoded(4, 4, ImageFormat::Png);
        // Width and height stand behind the signature and the header's length and name.
        let announced = |width: u32, height: u32| {
            let mut bytes = png.clone();
            bytes[16..20].copy_from_slice(&width.to_be_bytes());
            bytes[20..24].copy_from_slice(&height.to_be_bytes());
            let sum = crc(&bytes[12..29]);
            bytes[29..33].copy_from_slice(&sum.to_be_bytes());
            bytes
        };
        assert!(look(&announced(4, 4)).is_ok(), "the sum is right");
        assert!(look(&announced(8192, 8192)).is_ok());
        for (bytes, told) in [
            (b"RIFF....WEBP".to_vec(), "neither PNG nor JPEG"),
            (png[..20].to_vec(), "damaged"),
            (vec![0xFF, 0xD8, 0xFF, 0xE0], "damaged"),
            (announced(16_385, 1), "16385 × 1 pixels"),
            (announced(16_384, 16_384), "16384 × 16384 pixels"),
            (announced(u32::MAX >> 1, u32::MAX >> 1), "pixels"),
        ] {
            let fault = look(&bytes).unwrap_err().to_string();
            assert!(fault.starts_with("the image bark cannot be shown"));
            assert!(fault.contains(told), "{fault}");
        }
        let cut = look(&png[..png.len() - 20]).unwrap();
        let fault = cut.decode(&ImageLimits::default()).unwrap_err();
        assert!(fault.to_string().contains("damaged"), "{fault}");
        let small = ImageLimits {
            side_px: 3,
            bytes: 1 << 20,
        };
        assert!(look(&png).unwrap().decode(&small).is_err());
    }

    #[test]
    fn images_of_no_pixels_are_refused() {
        for size_px in [[0, 0], [0, 5], [5, 0]] {
            let fault = check_size(size_px, &ImageLimits::default()).unwrap_err();
            assert!(fault.contains("no pixels"), "{fault}");
        }
    }

    /// The sum that ends a PNG chunk, bit by bit.
    fn crc(bytes: &[u8]) -> u32 {
        let sum = bytes.iter().fold(u32::MAX, |sum, byte| {
            (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
                sum >> 1 ^ (0xEDB8_8320 & (sum & 1).wrapping_neg())
            })
        });
        !sum
    }
}
