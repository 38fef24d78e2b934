//! Files that a model names, such as `tree.bin` or `bark.png`: only plain files in the model's own folder and below it.
//!
//! A file comes from anywhere and could name any other: so no absolute path, no `..`, no address, and no symbolic link that leads out
//! of the folder. Each file is read once, however often it is named, and all of them count for the limit of the model's length.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use percent_encoding::percent_decode_str;

use super::super::{ReadLimits, Task, load, open};
use super::shown;
use crate::mesh::MeshError;
use crate::tree::Cells;

/// Where a model's other files are.
pub(super) struct Folder<'a> {
    task: &'a Task<'a>,
    /// Bytes that may still be read.
    left: Cell<u64>,
    files: RefCell<BTreeMap<PathBuf, Arc<Cells<u8>>>>,
}

/// Why a file is not read.
pub(super) enum Refusal {
    Cancelled,
    /// The rest of a sentence about what names it.
    Problem(String),
}

impl<'a> Folder<'a> {
    pub(super) fn new(task: &'a Task<'a>, file_bytes: usize) -> Self {
        Self {
            task,
            left: Cell::new(task.limits.bytes.saturating_sub(file_bytes as u64)),
            files: RefCell::default(),
        }
    }

    /// The file that a URI names.
    pub(super) fn file(&self, uri: &str) -> Result<Arc<Cells<u8>>, Refusal> {
        let path = self.path(uri).map_err(Refusal::Problem)?;
        if let Some(bytes) = self.files.borrow().get(&path) {
            return Ok(bytes.clone());
        }
        let limits = ReadLimits {
            bytes: self.left.get(),
            ..*self.task.limits
        };
        let bytes = open(&path, &limits)
            .and_then(|(file, length)| load(file, length, &limits, self.task.cancel));
        let bytes = bytes.map_err(|fault| match fault {
            MeshError::Cancelled => Refusal::Cancelled,
            MeshError::TooLong { .. } => Refusal::Problem(format!(
                "names the file {}, with which the model has more than the {} bytes that are read: simplify it",
                shown(uri),
                self.task.limits.bytes
            )),
            fault => Refusal::Problem(format!(
                "names the file {}, which cannot be read ({fault})",
                shown(uri)
            )),
        })?;
        self.left.set(self.left.get() - bytes.len() as u64);
        let bytes = Arc::new(bytes);
        self.files.borrow_mut().insert(path, bytes.clone());
        Ok(bytes)
    }

    /// The path of a file that is there, in the folder.
    fn path(&self, uri: &str) -> Result<PathBuf, String> {
        let name = shown(uri);
        let Some(folder) = self.task.folder else {
            return Err(format!(
                "is in the file {name}, and only the model's own bytes are at hand: save it as GLB, or open it from its folder"
            ));
        };
        let first = uri.split('/').next().unwrap_or_default();
        if first.contains(':') {
            return Err(format!(
                "is at the address {name}, and only files in the model's own folder are opened: put it there and name it"
            ));
        }
        let outside = || {
            format!(
                "names {name}, which is outside of the model's own folder: put it there and name it without a path"
            )
        };
        let relative = percent_decode_str(uri).decode_utf8();
        let relative =
            relative.map_err(|_| format!("names {name}, which is no text: rename it"))?;
        let relative = Path::new(relative.as_ref());
        let mut components = relative.components();
        if !components.all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
            return Err(outside());
        }
        let here = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            folder
        };
        let missing =
            |_| format!("names the file {name}, which is not there: put it beside the model");
        let folder = here.canonicalize().map_err(missing)?;
        // Links are followed, and must not lead out.
        let path = folder.join(relative).canonicalize().map_err(missing)?;
        if !path.starts_with(&folder) {
            return Err(outside());
        }
        Ok(path)
    }
}
