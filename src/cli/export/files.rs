//! The files that `ramus export` writes: what they are called, and what is told of them.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use serde::Serialize;

use super::Args;
use super::estimate::Holds;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// Binary glTF: surface, bark, colours, materials
    Glb,
    /// Universal Scene Description as text
    Usda,
    /// Stanford PLY, binary
    Ply,
    /// Wavefront OBJ
    Obj,
    /// The skeleton with radii
    Swc,
    /// The grammar
    Lsys,
}

impl Format {
    pub(super) fn ending(self) -> &'static str {
        match self {
            Self::Glb => "glb",
            Self::Usda => "usda",
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Swc => "swc",
            Self::Lsys => "lsys",
        }
    }

    /// Whether it has triangles, which levels of detail are about.
    pub(super) fn is_surface(self) -> bool {
        !matches!(self, Self::Swc | Self::Lsys)
    }
}

/// One file.
#[derive(Clone, Debug)]
pub(super) struct File {
    pub(super) path: PathBuf,
    pub(super) format: Format,
    pub(super) level: Option<u32>,
}

/// What is told of a file.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Told {
    pub(super) file: PathBuf,
    /// Of the tree, in a grove of the first.
    pub(super) seed: u64,
    /// Trees of a grove.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) trees: Option<u32>,
    /// Of a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) step: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) level: Option<u32>,
    pub(super) segments: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) triangles: Option<u64>,
    /// How far the surface is off at most, metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) bound: Option<f32>,
    #[serde(flatten)]
    pub(super) holds: Holds,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) bytes: Option<u64>,
}

/// All that is told, `ramus-export/1`.
#[derive(Serialize)]
pub(super) struct All<'a> {
    pub(super) format: &'static str,
    pub(super) files: &'a [Told],
    /// The picture of all individuals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) sheet: Option<&'a Path>,
    pub(super) triangles: u64,
    pub(super) seconds: f64,
}

/// A line of what is told.
pub(super) fn line(told: &Told) -> String {
    let mut line = format!("{}: ", told.file.display());
    if let Some(trees) = told.trees {
        line += &format!("{}, ", counted(trees.into(), "tree"));
    }
    line += &counted(told.segments as u64, "segment");
    if let (Some(triangles), Some(bound)) = (told.triangles, told.bound) {
        line += &format!(
            ", {}, off by {:.2} mm at most",
            counted(triangles, "triangle"),
            1e3 * bound
        );
    }
    line += &told.holds.line();
    if let Some(bytes) = told.bytes {
        line += &format!(", about {} kB", bytes.div_ceil(1000));
    }
    line
}

/// The files of an individual, or of a grove.
/// A step of a sequence stands with as many digits as the last one's, two at least.
pub(super) fn files(args: &Args, seed: u64, step: Option<u32>, last: Option<u32>) -> Vec<File> {
    let stem = args.file.file_stem().unwrap_or_default().to_string_lossy();
    let one = match args.seed.is_some() || args.count > 1 {
        _ if args.grove => "-grove".to_owned(),
        true => format!("-{seed}"),
        false => String::new(),
    };
    let digits = last.unwrap_or(0).to_string().len().max(2);
    let step = step.map_or_else(String::new, |step| format!("-step-{step:0digits$}"));
    let mut files: Vec<File> = Vec::new();
    let mut levels = args.lod.clone();
    levels.sort_unstable();
    levels.dedup();
    if args.triangles.is_some() {
        levels = vec![0];
    }
    let mut formats = Vec::new();
    for format in &args.format {
        // What is named twice is written once.
        if formats.contains(format) {
            continue;
        }
        formats.push(*format);
        let mut add = |level: Option<u32>, part: String| {
            let name = format!("{stem}{one}{step}{part}.{}", format.ending());
            let path = args.out.join(name);
            files.push(File {
                path,
                format: *format,
                level,
            });
        };
        if !format.is_surface() {
            add(None, String::new());
            continue;
        }
        for level in &levels {
            let part = match levels.as_slice() {
                [_] => String::new(),
                _ => format!("-lod{level}"),
            };
            add(args.triangles.is_none().then_some(*level), part);
        }
    }
    files
}

/// So many of them, in words.
pub(super) fn counted(number: u64, what: &str) -> String {
    let several = if number == 1 { "" } else { "s" };
    format!("{number} {what}{several}")
}
