//! Ramus: the VR workshop for branching structures.
//!
//! One idea holds the house together: everything is a [`tree::Tree`]. Strokes
//! become a [`sketch`], the sketch a grammar, the [`lsystem`] engine derives and
//! interprets it, and the resulting tree is shown by [`render`] and exported by
//! [`tree`]. Rooms import only rooms below them; `tests/layering.rs` holds that.

pub mod app;
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
