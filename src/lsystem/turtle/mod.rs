//! The turtle: a state machine that reads modules from front to back and draws on a [`Canvas`].
//!
//! ```text
//! ModuleString, a part of one, any iterator of modules ─▶ Turtle (a Pen, a stack of them) ─▶ Canvas: TreeCanvas ─▶ Tree
//!                                                                                                   Extent ─▶ counts and bounds
//! ```
//!
//! What a symbol does is in `action`, where the turtle stands and how it turns in `pen`, the reading in `walk`. A tree is counted first (`plan`, simpler `spans`) and drawn in parts beside each other (`parts`). What is nowhere written down is drawn as it comes (`stream`). Who goes over the strings of one step after the other need not read again what stays (`trail`). The turtle
//! itself holds a pen for each open bracket and the vertices of open outlines, whatever the length of the string; the stack is on the heap.
//! `docs/src/language.md` lists each symbol.

use std::sync::atomic::AtomicBool;

use super::derive::{Limits, interpreted};
use super::error::DeriveError;
use super::grammar::Grammar;
use super::string::ModuleString;
use crate::tree::Tree;

mod action;
mod canvas;
mod drawing;
mod extent;
mod grown;
mod parts;
mod pen;
mod plan;
mod spans;
mod stream;
mod trail;
mod tree;
mod walk;

pub use canvas::{Canvas, Drawn, Outline};
pub use drawing::{DrawingCanvas, draw};
pub use extent::Extent;
pub(super) use grown::{Grown, is_index, length_of};
pub use pen::{Cylinder, Pen};
pub(in crate::lsystem) use plan::{Lines, lines_of};
pub use stream::{stream_on, streams};
pub(super) use trail::{Again, Trail};
pub use tree::TreeCanvas;
pub use walk::Turtle;

/// What the turtle takes where the string says nothing, and how far it may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurtleParams {
    /// Length of `F` and `f` without a parameter, metres.
    pub length: f64,
    /// Width (diameter) before the first `!`, metres.
    pub width: f64,
    /// What `!` without a parameter multiplies the width by.
    pub narrow: f64,
    /// Degrees of a turn without a parameter, where the grammar has no `angle`.
    pub angle: f64,
    /// Brackets within brackets; no more than half of `limits.bytes` holds.
    pub max_depth: usize,
    /// Nodes of the tree; at most 2^32 − 2, and no more than `limits.bytes` holds. Vertices of open outlines, too.
    pub max_nodes: u64,
    /// Limits of the string that the `interpret` block makes, and of the tree's bytes.
    pub limits: Limits,
}

impl Default for TurtleParams {
    /// A step of 1 m, a width of 0.1 m that `!` divides by √2 (two such branches have the parent's cross-section), turns
    /// of 60° as in L-Py, 12 million brackets within brackets, 512 million nodes.
    fn default() -> Self {
        Self {
            length: 1.0,
            width: 0.1,
            narrow: std::f64::consts::FRAC_1_SQRT_2,
            angle: 60.0,
            max_depth: 12_000_000,
            max_nodes: 1 << 29,
            limits: Limits::default(),
        }
    }
}

/// Draws a string: one segment for each drawing module, under a root node at the turtle's start. A move without drawing
/// begins a new root.
///
/// # Errors
/// The turtle's limits, positions beyond f32, outlines that do not close, or `cancel` being set.
pub fn interpret(
    grammar: &Grammar,
    string: &ModuleString,
    params: &TurtleParams,
    cancel: &AtomicBool,
) -> Result<Tree, DeriveError> {
    let (shown, params) = shown(grammar, string, params, cancel)?;
    parts::tree(grammar, shown.as_ref().unwrap_or(string), &params, cancel)
}

/// What is drawn where that is not the string itself, and what is left of the memory.
fn shown(
    grammar: &Grammar,
    string: &ModuleString,
    params: &TurtleParams,
    cancel: &AtomicBool,
) -> Result<(Option<ModuleString>, TurtleParams), DeriveError> {
    let shown = interpreted(grammar, string, &params.limits, cancel)?;
    let mut params = *params;
    let shown_bytes = shown.as_ref().map_or(0, ModuleString::bytes);
    params.limits.bytes = params.limits.bytes.saturating_sub(shown_bytes);
    Ok((shown, params))
}

/// Draws a string on the canvas that `make` makes, which may take the memory that its parameters say: the string that is shown lies
/// in the same.
///
/// # Errors
/// As [`interpret`], and what the canvas refuses.
pub fn draw_on<C: Canvas>(
    grammar: &Grammar,
    string: &ModuleString,
    params: &TurtleParams,
    cancel: &AtomicBool,
    make: impl FnOnce(&TurtleParams) -> C,
) -> Result<C, DeriveError> {
    let (shown, params) = shown(grammar, string, params, cancel)?;
    let canvas = make(&params);
    let mut turtle = Turtle::new(grammar, &params, canvas);
    turtle.read(shown.as_ref().unwrap_or(string), cancel)?;
    turtle.finish()
}
