//! Draws a [`Scene`](crate::world::scene::Scene) with Vulkan, for two eyes.
//!
//! ```text
//! VulkanHost (Headless, WindowHost, or an OpenXR runtime)
//!     └▶ Gpu ── probe::multiview ──▶ StereoMode
//!          ├▶ Renderer::draw(scene, eyes, target) ──▶ StereoImage: a headset's swapchain image, or
//!          ├▶ Offscreen ──▶ read_color, read_depth
//!          └▶ Surface ──▶ a window
//! ```
//!
//! Knows scenes, trees, models and egui's triangles; never tools; of headsets only the handles in `ramus_xr::vulkan`. The frame's path and what its
//! synchronisation covers are written down in `docs/src/rendering.md`.

mod clock;
mod crown_upload;
mod data;
mod error;
mod eye;
mod frame;
mod gpu;
mod hidden;
mod host;
mod leaf_upload;
mod light;
mod memory;
mod meshes;
mod model_upload;
mod offscreen;
mod organ_upload;
mod panel;
mod pipelines;
pub mod probe;
mod renderer;
mod resident;
mod selection;
mod shade;
mod shadow;
mod staging;
mod surface;
mod target;
mod texture;
mod tree_upload;
mod validation;
mod window;

/// SPIR-V of `shaders/`, made by build.rs.
mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

pub(crate) use data::panels;
pub use error::RenderError;
pub use eye::{Eye, Fov, NEAR, Pose};
pub use gpu::{DeviceInfo, Gpu, GpuInner, GpuParams};
pub use host::Headless;
pub use model_upload::ModelUpload;
pub use offscreen::{COLOR_FORMAT, DEPTH_FORMAT, Offscreen, read_color, read_depth};
pub use panel::LayerImage;
#[cfg(test)]
pub(crate) use panel::layer::tests as layer_tests;
pub use probe::Multiview;
pub use renderer::{Backdrop, DrawReport, Renderer, RendererParams, StereoMode, TreeState};
pub use resident::Resident;
pub use selection::Chosen;
pub use surface::Surface;
pub use target::{StereoImage, Target};
pub use tree_upload::TreeUpload;
pub use validation::Messages;
pub use window::{DrawnWindow, WindowHost};
