//! Trees and pictures as files, the format told by the file's ending.

use std::path::{Path, PathBuf};

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, RgbaImage};

use crate::tree::export::{self, ExportParams, Stand};
use crate::tree::file::{write_atomically, write_atomically_with};
use crate::tree::{Organs, Tree, TreeError};

/// Why nothing was exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The ending tells no format.
    #[error("{path}: the ending tells no format; use .glb, .usda, .ply, .obj or .swc", path = path.display())]
    Format {
        /// The path asked for.
        path: PathBuf,
    },
    /// The ending tells another format than the only one for pictures.
    #[error("{path}: pictures are written as PNG; use the ending .png", path = path.display())]
    PictureFormat {
        /// The path asked for.
        path: PathBuf,
    },
    /// The tree or the disk is at fault.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The picture could not be encoded.
    #[error("cannot make the PNG {path}: {source}", path = path.display())]
    Picture {
        /// What went wrong.
        source: image::ImageError,
        /// The path asked for.
        path: PathBuf,
    },
}

/// Formats of trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary glTF: a surface with bark, colours and materials.
    Glb,
    /// Universal Scene Description as text: a surface with colours and materials.
    Usd,
    /// Stanford PLY: a surface with colours.
    Ply,
    /// Wavefront OBJ: a surface with colours.
    Obj,
    /// SWC: the skeleton with radii.
    Swc,
}

impl Format {
    /// The format that a path's ending tells.
    ///
    /// # Errors
    /// [`ExportError::Format`].
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        let ending = path
            .extension()
            .and_then(|ending| ending.to_str())
            .unwrap_or_default();
        match ending.to_ascii_lowercase().as_str() {
            "glb" => Ok(Self::Glb),
            "usda" => Ok(Self::Usd),
            "ply" => Ok(Self::Ply),
            "obj" => Ok(Self::Obj),
            "swc" => Ok(Self::Swc),
            _ => Err(ExportError::Format {
                path: path.to_owned(),
            }),
        }
    }
}

/// Writes a tree and what it carries, whole or not at all.
///
/// # Errors
/// [`ExportError`].
pub fn drawing(tree: &Tree, organs: &Organs, path: &Path) -> Result<(), ExportError> {
    drawing_with(tree, organs, &ExportParams::default(), path)
}

/// The same, its tubes with so many sides.
///
/// # Errors
/// [`ExportError`].
pub fn drawing_with(
    tree: &Tree,
    organs: &Organs,
    params: &ExportParams,
    path: &Path,
) -> Result<(), ExportError> {
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    stand(&Stand::of(&name, tree, organs, params), path)
}

/// Whether a file can be made of all that is to stand in it, asked before anything is written.
///
/// # Errors
/// [`ExportError`].
pub fn check(stand: &Stand<'_>, path: &Path) -> Result<(), ExportError> {
    match Format::of(path)? {
        Format::Glb => export::Glb::check(stand)?,
        Format::Usd => export::Usd::check(stand)?,
        Format::Ply => export::Ply::check(stand)?,
        Format::Obj => export::Obj::check(stand)?,
        Format::Swc => {
            if let Some(one) = stand.trees.first() {
                export::Swc::new(one.tree)?;
            }
        }
    }
    Ok(())
}

/// Writes all that is to stand in one file, whole or not at all. SWC holds the first tree alone.
///
/// # Errors
/// [`ExportError`].
pub fn stand(stand: &Stand<'_>, path: &Path) -> Result<(), ExportError> {
    match Format::of(path)? {
        Format::Glb => {
            let file = export::Glb::of(stand)?;
            write_atomically_with(path, |out| file.write(out))?;
        }
        Format::Usd => {
            let file = export::Usd::of(stand)?;
            write_atomically_with(path, |out| file.write(out))?;
        }
        Format::Ply => {
            let file = export::Ply::of(stand)?;
            write_atomically_with(path, |out| file.write(out))?;
        }
        Format::Obj => {
            let file = export::Obj::of(stand)?;
            write_atomically_with(path, |out| file.write(out))?;
        }
        Format::Swc => {
            if let Some(one) = stand.trees.first() {
                let file = export::Swc::new(one.tree)?;
                write_atomically_with(path, |out| file.write(out))?;
            }
        }
    }
    Ok(())
}

/// Refuses a path for a picture whose ending tells another format.
///
/// # Errors
/// [`ExportError::PictureFormat`].
pub fn check_picture(path: &Path) -> Result<(), ExportError> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("png") => Ok(()),
        _ => Err(ExportError::PictureFormat {
            path: path.to_owned(),
        }),
    }
}

/// Writes a picture as PNG, whole or not at all.
///
/// # Errors
/// [`ExportError`].
pub fn png(picture: &RgbaImage, path: &Path) -> Result<(), ExportError> {
    let mut bytes = Vec::new();
    // Nothing is seen through a picture, so its alpha would say nothing.
    let opaque = DynamicImage::ImageRgba8(picture.clone()).into_rgb8();
    let encoder =
        PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
    opaque
        .write_with_encoder(encoder)
        .map_err(|source| ExportError::Picture {
            source,
            path: path.to_owned(),
        })?;
    Ok(write_atomically(path, &bytes)?)
}
