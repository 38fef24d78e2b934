//! Headsets: what a frame of virtual reality is, whichever device gives it.
//!
//! [`Headset`] hides which one is there: an OpenXR runtime ([`openxr`]), the
//! built-in simulated one ([`simulated`]) that plays a recorded session, or a
//! recording around either ([`record`]). The application cannot tell them apart.

pub mod bindings;
mod directions;
pub mod frame;
pub mod headset;
pub mod joints;
pub mod lifecycle;
pub mod mask;
pub mod openxr;
pub mod profiles;
pub mod quad;
pub mod record;
pub mod refresh;
pub mod session;
pub mod simulated;
pub mod vulkan;

/// For [`forward_headset`], whose users need not name it.
#[doc(hidden)]
pub use ash;
pub use frame::{Fov, Frame, Hand, Pose, Pulse, View};
pub use headset::{Acquired, Headset, HeadsetError, Tick};
pub use mask::VisibilityMask;
pub use vulkan::Swapchain;
