//! What a frame did.

use std::time::Duration;

use crate::render::Chosen;

/// Which tree a frame showed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TreeState {
    /// The scene has none.
    None,
    /// The scene's own.
    Shown,
    /// The last one, while the scene's is being copied.
    Copying,
    /// The last one: the scene's is too large to build within a frame; give [`Renderer::set_tree`](crate::render::Renderer::set_tree) a
    /// [`TreeUpload`](crate::render::TreeUpload) of this revision made on a worker.
    Wanted(u64),
}

/// What a frame did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawReport {
    /// Draw calls.
    pub draws: u32,
    /// Triangles handed over but for those that the device chose, each counted once for both eyes.
    pub triangles: u64,
    /// What the device chose of trees and of models' faces in the last frame that is known to be done: two frames ago. See [`Renderer::chosen`](crate::render::Renderer::chosen).
    pub chosen: Chosen,
    /// Segments of the tree that was shown.
    pub segments: u32,
    /// Bytes that were sent to the device for a tree that is shown for the first time; 0 in other frames.
    pub sent: u64,
    /// How long the device worked on the last frame that is known to be done, where it tells the time: two frames ago.
    pub device: Option<Duration>,
    /// The tree.
    pub tree: TreeState,
    /// The shown tree has no levels of detail and has been at rest for a while: give [`Renderer::set_tree`](crate::render::Renderer::set_tree) a [`TreeUpload`](crate::render::TreeUpload) of this revision, which has,
    /// and takes its place unseen.
    pub plain: Option<u64>,
    /// The first model that is too large to prepare within a frame: give [`Renderer::set_model`](crate::render::Renderer::set_model) a [`ModelUpload`](crate::render::ModelUpload) of this revision
    /// made on a worker; of its colours alone, where [`Renderer::has_shape`](crate::render::Renderer::has_shape) says so.
    pub model: Option<u64>,
}
