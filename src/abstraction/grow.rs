//! From parameters to a tree: the grammar derived, drawn, and pruned where it is asked for.

use std::sync::atomic::AtomicBool;

use super::error::AbstractionError;
use super::grammar::{grammar, steps};
use super::params::Params;
use super::prune::pruned;
use crate::lsystem::{Grammar, Limits, ModuleString, TurtleParams, interpret};
use crate::tree::{NO_PARENT, Node, Tree};

/// The tree of some parameters after all of its iterations.
///
/// # Errors
/// A parameter beyond its limits, a tree beyond `limits`, or `cancel` being set.
pub fn grow(
    params: &Params,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<Tree, AbstractionError> {
    Grower::new(params)?.tree(params.seed, limits, cancel)
}

/// What grows trees of some parameters, one for each seed. Their grammar is read once.
#[derive(Clone, Debug)]
pub struct Grower {
    grammar: Grammar,
    params: Params,
}

impl Grower {
    /// Of parameters, whose seed does not matter.
    ///
    /// # Errors
    /// A parameter beyond its limits.
    pub fn new(params: &Params) -> Result<Self, AbstractionError> {
        Ok(Self {
            grammar: grammar(params)?,
            params: params.clone(),
        })
    }

    /// The tree of a seed after all of its iterations.
    ///
    /// # Errors
    /// A tree beyond `limits`, or `cancel` being set.
    pub fn tree(
        &mut self,
        seed: u64,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Tree, AbstractionError> {
        self.tree_at(steps(&self.params), seed, limits, cancel)
    }

    /// The tree of a seed after so many iterations: those of a longer run have it at that iteration, too.
    ///
    /// # Errors
    /// As [`Self::tree`].
    pub fn tree_at(
        &mut self,
        iterations: u32,
        seed: u64,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Tree, AbstractionError> {
        let tree = self.up_to([iterations as usize, usize::MAX], seed, limits, cancel)?;
        Ok(tree.unwrap_or_default())
    }

    /// The iteration after which no tip of a seed's tree lives: it thickens at most from there on. None where that is beyond `limits` or `cancel` is set.
    pub fn ends(&mut self, seed: u64, limits: &Limits, cancel: &AtomicBool) -> Option<u32> {
        self.grammar.set_seed(seed);
        let mut string = self.grammar.derive(0, limits, cancel).ok()?;
        let last = steps(&self.params);
        for step in 0..last {
            let [live, _] = self.tips(&string);
            if live == 0 {
                return Some(step);
            }
            let next = self.grammar.derive_next(&string, step + 1, limits, cancel);
            string = next.ok()?;
        }
        Some(last)
    }

    /// As [`Self::tree_at`], and none as soon as there are more tips than so many.
    pub(super) fn up_to(
        &mut self,
        [iterations, tips]: [usize; 2],
        seed: u64,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Option<Tree>, AbstractionError> {
        self.grammar.set_seed(seed);
        let mut string = self.grammar.derive(0, limits, cancel)?;
        for step in (1..=steps(&self.params)).take(iterations) {
            let [live, dead] = self.tips(&string);
            if live + dead > tips {
                return Ok(None);
            }
            // What else there is thickens in every iteration.
            if live == 0 && self.params.radial_increment == 0.0 {
                break;
            }
            string = self.grammar.derive_next(&string, step, limits, cancel)?;
        }
        self.drawn(&string, limits, cancel).map(Some)
    }

    /// How many live and dead tips a string has.
    fn tips(&self, string: &ModuleString) -> [usize; 2] {
        let mut counts = [0; 2];
        for symbol in string.symbols() {
            match self.grammar.name(symbol) {
                "B" => counts[0] += 1,
                "D" => counts[1] += 1,
                _ => {}
            }
        }
        counts
    }

    fn drawn(
        &self,
        string: &ModuleString,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Tree, AbstractionError> {
        let turtle = TurtleParams {
            limits: *limits,
            ..TurtleParams::default()
        };
        let tree = interpret(&self.grammar, string, &turtle, cancel)?;
        let Params {
            prune_intersections,
            bounding_ellipsoid,
            ..
        } = self.params;
        if prune_intersections || bounding_ellipsoid.is_some() {
            return Ok(pruned(&tree, prune_intersections, bounding_ellipsoid));
        }
        Ok(tree)
    }
}

/// The same tree to look at: tips are drawn pointed, as twigs are, so each gets a node a radius before it, and is as thick as it is up to there.
pub fn blunt(tree: &Tree) -> Tree {
    let mut blunt = Tree {
        letters: tree.letters.clone(),
        ..Tree::with_capacity(tree.len())
    };
    let mut is_tip = vec![false; tree.len()];
    for tip in tree.tips() {
        is_tip[tip as usize] = true;
    }
    let mut places = Vec::with_capacity(tree.len());
    for (at, is_tip) in is_tip.into_iter().enumerate() {
        let mut node = Node {
            parent: tree.parent[at],
            position: tree.position[at],
            radius: tree.radius[at],
            letter: tree.letter[at],
            order: tree.order[at],
            birth: tree.birth[at],
        };
        if node.parent != NO_PARENT {
            let from = tree.position[node.parent as usize];
            node.parent = places[node.parent as usize];
            let length = from.distance(node.position);
            if is_tip && length > node.radius {
                let position = node.position.lerp(from, node.radius / length);
                node.parent = blunt.push(Node { position, ..node });
            }
        }
        places.push(blunt.push(node));
    }
    blunt
}
