//! A headset behind an OpenXR runtime.
//!
//! ```text
//! connect ─▶ System ── its three Vulkan calls (XR_KHR_vulkan_enable2) ─▶ the application's device
//!               └────── start(handles) ─▶ OpenXrHeadset: the `Headset` trait
//! ```
//!
//! [`connect`] says in one sentence what is missing, so that the program can go on without a headset.
//! [`System`] stands between the application and Vulkan while instance and device are made, as the
//! extension wants it. [`OpenXrHeadset`] then walks through the session's states (decided in
//! [`crate::lifecycle`]) and runs the frames.
//!
//! The `openxr` crate is used for what it keeps safe (handles, actions, events). Frame calls, action sync and
//! locating views go through the raw function pointers: the crate drops success codes such as
//! `SESSION_LOSS_PENDING` and allocates in each `locate_views`; here every code is looked at and a warm frame
//! allocates nothing.
//!
//! One thread: the runtime uses the application's Vulkan queue inside start, begin and end, so nothing else may
//! submit to it meanwhile. `Headset` takes `&mut self`, so keep headset and queue on the same thread.

mod call;
mod connect;
mod controllers;
mod events;
#[cfg(test)]
mod fake;
mod frames;
mod hands;
mod headset;
mod input;
mod mask;
mod quads;
mod refresh;
mod space;
mod swapchain;
mod system;
#[cfg(test)]
mod tests;
mod view;

pub use connect::{ConnectError, connect, quiet_loader};
pub use headset::OpenXrHeadset;
pub use system::{StartParams, System};
