//! The canvas that becomes a [`Tree`].

use glam::{DVec3, Vec3};

use super::super::error::{DeriveError, DeriveProblem};
use super::super::grammar::Grammar;
use super::super::names::Symbol;
use super::TurtleParams;
use super::canvas::{Canvas, Drawn, narrow, narrowed};
use super::pen::Pen;
use crate::tree::{NO_PARENT, Node, Tree};

/// Bytes of a node in all arrays of a tree.
const NODE_BYTES: u64 = 28;

/// Nodes that room is made for at least.
const LEAST_ROOM: usize = 64;

/// Nodes that a tree may have.
pub(super) fn most_nodes(params: &TurtleParams) -> u64 {
    params
        .max_nodes
        .min(params.limits.bytes / NODE_BYTES)
        .min(u64::from(NO_PARENT) - 1)
}

/// The name of the letter that a symbol draws: a shape that is placed is the shape.
pub(super) fn letter_name(grammar: &Grammar, symbol: Symbol) -> &str {
    let name = grammar.name(symbol);
    name.strip_prefix('~').unwrap_or(name)
}

/// A node for the start, for each root and for each segment's end. What is no skeleton (polygons, spheres, surfaces) is left out.
pub struct TreeCanvas<'a> {
    grammar: &'a Grammar,
    tree: Tree,
    /// By symbol: the tree's letter, once it has drawn.
    letters: Vec<Option<u16>>,
    /// Nodes that there may be.
    limit: u64,
    /// Radius of a start that nothing leaves.
    bare: f32,
    /// Whether a segment has left the start.
    started: bool,
}

impl<'a> TreeCanvas<'a> {
    /// A canvas with the turtle's start.
    #[must_use]
    pub fn new(grammar: &'a Grammar, params: &TurtleParams) -> Self {
        let mut tree = Tree::default();
        tree.push(Node {
            parent: NO_PARENT,
            position: Vec3::ZERO,
            radius: 0.0,
            letter: 0,
            order: 0,
            birth: 0,
        });
        Self {
            grammar,
            tree,
            letters: vec![None; grammar.names.symbols().len()],
            limit: most_nodes(params),
            bare: narrow(params.width.abs() / 2.0),
            started: false,
        }
    }

    /// The tree.
    #[must_use]
    pub fn finish(mut self) -> Tree {
        if self.tree.len() == 1
            && let Some(root) = self.tree.radius.first_mut()
        {
            *root = self.bare;
        }
        if self.tree.letters.is_empty() {
            self.tree.letters.push(String::new());
        }
        self.tree
    }

    #[inline]
    fn add(&mut self, node: Node) -> Result<u32, DeriveError> {
        if self.tree.parent.len() == self.tree.parent.capacity()
            || self.tree.parent.len() as u64 >= self.limit
        {
            self.room()?;
        }
        Ok(self.tree.push(node))
    }

    /// Makes room for more nodes: by half of what is there, so that little of the memory stays unused.
    #[cold]
    fn room(&mut self) -> Result<(), DeriveError> {
        let (have, limit) = (self.tree.len(), self.limit);
        let left = usize::try_from(limit)
            .unwrap_or(usize::MAX)
            .saturating_sub(have);
        if left == 0 {
            return Err(DeriveProblem::TooManyNodes { limit }.into());
        }
        let more = (have / 2).max(LEAST_ROOM).min(left);
        if self.tree.try_reserve(more).is_err() {
            let nodes = have as u64;
            return Err(DeriveProblem::DrawingMemory { nodes }.into());
        }
        Ok(())
    }

    /// The tree's number for a symbol's name; symbols of one name share it.
    #[inline]
    fn letter(&mut self, symbol: Symbol) -> u16 {
        match self.letters.get(usize::from(symbol)) {
            Some(Some(known)) => *known,
            _ => self.new_letter(symbol),
        }
    }

    #[cold]
    fn new_letter(&mut self, symbol: Symbol) -> u16 {
        let name = letter_name(self.grammar, symbol);
        let known = self.tree.letters.iter().position(|l| l == name);
        let index = known.unwrap_or_else(|| {
            self.tree.letters.push(name.to_owned());
            self.tree.letters.len() - 1
        });
        let index = u16::try_from(index).unwrap_or(0);
        if let Some(slot) = self.letters.get_mut(usize::from(symbol)) {
            *slot = Some(index);
        }
        index
    }
}

impl Canvas for TreeCanvas<'_> {
    fn root(&mut self, pen: &Pen, by: Drawn, radius: f32) -> Result<u32, DeriveError> {
        let letter = self.letter(by.symbol);
        self.add(Node {
            parent: NO_PARENT,
            position: narrowed(pen.position),
            radius,
            letter,
            order: pen.order,
            birth: by.birth,
        })
    }

    #[inline]
    fn segment(
        &mut self,
        pen: &Pen,
        by: Drawn,
        end: DVec3,
        radius: f32,
    ) -> Result<u32, DeriveError> {
        let letter = self.letter(by.symbol);
        if pen.node == 0 && !self.started {
            // The start is as thick as the first segment that leaves it.
            if let (Some(r), Some(l)) = (self.tree.radius.first_mut(), self.tree.letter.first_mut())
            {
                (*r, *l) = (radius, letter);
            }
            self.started = true;
        }
        self.add(Node {
            parent: pen.node,
            position: narrowed(end),
            radius,
            letter,
            order: pen.order,
            birth: by.birth,
        })
    }
}
