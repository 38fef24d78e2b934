//! glTF 2.0 and GLB: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html>.
//!
//! ```text
//! bytes ─▶ container ─▶ document ─┬▶ scene: which meshes stand where ─┐
//!                                 ├▶ shape: what each mesh takes ─────┼▶ limits ─▶ surface ─▶ Mesh
//!          buffers, folder ───────┴▶ elements: checked ranges ────────┘
//!                                                  material, colours ─▶ Paint
//! ```
//!
//! The crate `gltf` understands the JSON. Its readers of accessors are not used: they trust the numbers in the file and may read
//! beyond a buffer; here every range is checked once, before anything of it is read, and then all threads copy. A mesh that stands in
//! many places is repeated in each, the only case in which a file makes more than it holds, so what all places take is counted
//! first. What only colours the surface never makes a model unreadable: it is left out and remarked on.

mod buffers;
mod colours;
mod container;
mod document;
mod elements;
mod folder;
mod images;
mod material;
mod rows;
mod scene;
mod shape;
mod surface;

use super::{Stop, Surface, Task};

/// Remarks on one file; more of them would hide the others.
const REMARKS_MOST: usize = 12;

/// Reads a `.gltf` file.
pub(super) fn read(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    let at = if bytes.starts_with(b"\xEF\xBB\xBF") {
        3
    } else {
        0
    };
    let parts = container::Parts {
        json: bytes.get(at..).unwrap_or_default(),
        json_at: at,
        binary: None,
    };
    read_parts(&parts, bytes.len(), task)
}

/// Reads a `.glb` file.
pub(super) fn read_binary(bytes: &[u8], task: &Task<'_>) -> Result<Surface, Stop> {
    read_parts(&container::parts(bytes)?, bytes.len(), task)
}

fn read_parts(
    parts: &container::Parts<'_>,
    file_bytes: usize,
    task: &Task<'_>,
) -> Result<Surface, Stop> {
    let mut remarks = Remarks::default();
    let mut root = document::read(parts, task)?;
    let folder = folder::Folder::new(task, file_bytes);
    let buffers = buffers::Buffers::new(&mut root, parts.binary, &folder, file_bytes);
    let accessors = elements::Accessors::new(&root, &buffers, task);
    let scene = scene::read(&root, &accessors, task, &mut remarks)?;
    let shapes = shape::of_scene(&root, &scene, task, &mut remarks)?;
    // Nothing of the surface is taken memory for before this.
    let size = surface::size(&scene, &shapes, task)?;
    let source = surface::Source::new(&scene, &shapes, &accessors, size, task)?;
    let mesh = source.mesh()?;
    let images = images::Images::new(&root, &buffers, &folder);
    let paint = material::paint(&root, &source, &accessors, images, &mut remarks)?;
    Ok(Surface {
        mesh,
        skipped_faces: size.skipped,
        paint,
        remarks: remarks.0,
        ..Surface::default()
    })
}

/// What is not shown as it was meant, each said once.
#[derive(Debug, Default)]
struct Remarks(Vec<String>);

impl Remarks {
    fn add(&mut self, remark: impl Into<String>) {
        let remark = remark.into();
        match self.0.len() {
            _ if self.0.contains(&remark) => {}
            0..REMARKS_MOST => self.0.push(remark),
            REMARKS_MOST => self.0.push("there is more of the kind".into()),
            _ => {}
        }
    }
}

/// A word of the file that is fit for a message.
fn shown(word: &str) -> String {
    const LONGEST: usize = 80;
    let plain = |c: char| if c.is_control() { '?' } else { c };
    let mut text: String = word.chars().take(LONGEST).map(plain).collect();
    if word.chars().nth(LONGEST).is_some() {
        text.push('…');
    }
    text
}
