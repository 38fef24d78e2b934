//! The JSON (§3): read by the crate `gltf` once it is known not to become too large in memory and to ask for nothing that is unknown.
//!
//! Each object of JSON, `{}`, may become half a kilobyte, so objects are counted before they are made. The version and the extensions
//! are looked at first, since a file of another version or with compressed buffers does not fit the structures that follow, and
//! would be told to be damaged.

use serde::Deserialize;

use ::gltf::json::Root;

use super::super::{Stop, Task};
use super::container::Parts;
use super::shown;

/// Objects of JSON: a hundred thousand meshes, each with its node, primitive and accessors.
const OBJECTS_MOST: usize = 1 << 20;
/// Values of JSON.
const VALUES_MOST: usize = 1 << 24;
/// Bytes between two looks at whether to go on.
const PIECE: usize = 1 << 22;

/// Extensions that may be required: those that are read, and those that change no place and no triangle.
const KNOWN: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_lights_punctual",
    "KHR_texture_basisu",
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "EXT_texture_avif",
];
/// How extensions of materials begin; none of them moves a vertex.
const OF_MATERIALS: &str = "KHR_materials_";
/// Compression of meshes, and how it is undone.
const COMPRESSION: &[&str] = &[
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
];
pub(super) const UNCOMPRESSED: &str = "export the model without compression";

/// What is looked at first.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Version,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
struct Version {
    version: String,
}

/// Reads the JSON.
pub(super) fn read(parts: &Parts<'_>, task: &Task<'_>) -> Result<Root, Stop> {
    check_size(parts, task)?;
    let fault = |error: &serde_json::Error| fault(parts, error);
    let head: Head = serde_json::from_slice(parts.json).map_err(|error| fault(&error))?;
    let version = head.asset.version;
    if version.split('.').next() != Some("2") {
        let problem = format!(
            "begins a description in glTF {}, and 2.0 is read: save the model as glTF 2.0",
            shown(&version)
        );
        return Err(Stop::fault(parts.json_at, problem));
    }
    for name in head.extensions_required {
        if COMPRESSION.contains(&name.as_str()) {
            return Err(compressed(name));
        }
        if !KNOWN.contains(&name.as_str()) && !name.starts_with(OF_MATERIALS) {
            return Err(Stop::Extension {
                name: shown(&name),
                mend: "export the model without it",
            });
        }
    }
    task.go_on()?;
    ::gltf::json::deserialize::from_slice(parts.json).map_err(|error| fault(&error))
}

/// The refusal of something compressed.
pub(super) fn compressed(name: impl Into<String>) -> Stop {
    Stop::Extension {
        name: name.into(),
        mend: UNCOMPRESSED,
    }
}

/// The compression among these extensions, if one is.
pub(super) fn compression<'a>(names: impl IntoIterator<Item = &'a String>) -> Option<&'a str> {
    let mut names = names.into_iter().map(String::as_str);
    names.find(|name| COMPRESSION.contains(name))
}

fn fault(parts: &Parts<'_>, error: &serde_json::Error) -> Stop {
    let mut lines = parts.json.split_inclusive(|&byte| byte == b'\n');
    let before: usize = lines
        .by_ref()
        .take(error.line().saturating_sub(1))
        .map(<[u8]>::len)
        .sum();
    let at = (before + error.column().saturating_sub(1)).min(parts.json.len());
    let told = error.to_string();
    // The place is told in our own way.
    let told = told.split(" at line ").next().unwrap_or_default();
    let problem = format!("is no JSON of a glTF file ({}): save it again", shown(told));
    Stop::fault(parts.json_at + at, problem)
}

/// That what is between strings becomes no more than memory is likely to hold.
fn check_size(parts: &Parts<'_>, task: &Task<'_>) -> Result<(), Stop> {
    let (mut objects, mut values) = (0, 0);
    let mut bytes = parts.json.iter().enumerate();
    let mut next = 0;
    while let Some((at, byte)) = bytes.next() {
        match byte {
            b'{' => objects += 1,
            b',' | b'[' => values += 1,
            b'"' => {
                // To its end; a backslash keeps what follows it.
                while let Some((_, byte)) = bytes.find(|(_, byte)| matches!(byte, b'"' | b'\\')) {
                    if *byte == b'"' {
                        break;
                    }
                    bytes.next();
                }
            }
            _ => {}
        }
        if at >= next {
            task.go_on()?;
            next = at + PIECE;
        }
        if objects > OBJECTS_MOST || values > VALUES_MOST {
            let problem = format!(
                "is where the description has more than {OBJECTS_MOST} objects or {VALUES_MOST} values: join meshes and nodes"
            );
            return Err(Stop::fault(parts.json_at + at, problem));
        }
    }
    Ok(())
}
