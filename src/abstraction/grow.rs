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
    let tree = grow_up(params, usize::MAX, limits, cancel)?;
    Ok(tree.unwrap_or_default())
}

/// The same, and none as soon as there are more tips than so many.
pub(super) fn grow_up(
    params: &Params,
    tips: usize,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<Option<Tree>, AbstractionError> {
    let grammar = grammar(params)?;
    let mut string = grammar.derive(0, limits, cancel)?;
    for step in 1..=steps(params) {
        let (mut live, mut dead) = (0, 0);
        for symbol in string.symbols() {
            match grammar.name(symbol) {
                "B" => live += 1,
                "D" => dead += 1,
                _ => {}
            }
        }
        if live + dead > tips {
            return Ok(None);
        }
        // What else there is thickens in every iteration.
        if live == 0 && params.radial_increment == 0.0 {
            break;
        }
        string = grammar.derive_next(&string, step, limits, cancel)?;
    }
    drawn(&grammar, &string, params, limits, cancel).map(Some)
}

fn drawn(
    grammar: &Grammar,
    string: &ModuleString,
    params: &Params,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<Tree, AbstractionError> {
    let turtle = TurtleParams {
        limits: *limits,
        ..TurtleParams::default()
    };
    let tree = interpret(grammar, string, &turtle, cancel)?;
    let (intersections, ellipsoid) = (params.prune_intersections, params.bounding_ellipsoid);
    if intersections || ellipsoid.is_some() {
        return Ok(pruned(&tree, intersections, ellipsoid));
    }
    Ok(tree)
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
