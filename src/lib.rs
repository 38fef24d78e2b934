//! Ramus: the VR workshop for branching structures.
//!
//! One idea holds the house together: everything is a [`tree::Tree`]. Strokes
//! become a [`sketch`], the sketch a grammar, the [`lsystem`] engine derives and
//! interprets it; a scanned [`mesh`] becomes a [`centerline`]; and the resulting tree is shown by [`render`] and measured and exported by
//! [`tree`]. Rooms import only rooms below them; `tests/layering.rs` holds that.

#[forbid(unsafe_code)]
pub mod abstraction;
pub mod app;
#[forbid(unsafe_code)]
pub mod centerline;
pub mod cli;
#[forbid(unsafe_code)]
pub mod lsystem;
#[forbid(unsafe_code)]
pub mod mesh;
pub mod render;
#[forbid(unsafe_code)]
pub mod sketch;
#[forbid(unsafe_code)]
pub mod tree;
#[forbid(unsafe_code)]
pub mod ui;
#[forbid(unsafe_code)]
pub mod world;
