//! Trees on the stage, compared on a worker.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use crate::app::compared::{colour, curves, tubes_along};
use crate::app::queue::Queue;
use crate::mesh::display::Display;
use crate::tree::Tree;
use crate::tree::compare::{Studied, compare_with_first};
use crate::world::World;
use crate::world::comparing::{Compared, Comparison};
use crate::world::scene::new_revision;

/// Tubes along trees that are laid over each other are as thick as this part of their radius, and so thick at least and at most, in parts of the first one's
/// reach: each is seen beside the others.
const THIN: f32 = 0.3;
const THICK: [f32; 2] = [0.004, 0.01];

/// Larger trees are not compared while somebody waits.
const SEGMENTS_MOST: usize = 200_000;

/// What was found of trees, or why nothing can be.
type Done = (Vec<Compared>, Result<Arc<Comparison>, String>);

/// Compares what is wanted.
pub(super) struct Comparing {
    queue: Queue<Vec<Compared>, Done>,
}

impl Comparing {
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start() -> std::io::Result<Self> {
        let job =
            |trees: &Vec<Compared>, cancel: &AtomicBool| (trees.clone(), compared(trees, cancel));
        Ok(Self {
            queue: Queue::start("ramus-comparing", job)?,
        })
    }

    /// Stops what nobody wants any more, and begins what the world wants next, unless something is under way. Whether something is.
    pub(super) fn follow(&mut self, world: &World) -> bool {
        let at_work = self.queue.open().next();
        if at_work.is_some_and(|trees| !world.wants_comparison(trees)) {
            self.queue.stop();
        }
        if !self.queue.is_busy()
            && let Some(trees) = world.wanted_comparison()
        {
            // The line is empty.
            let _ = self.queue.ask(trees);
        }
        self.queue.is_busy()
    }

    pub(super) fn poll(&mut self) -> Option<Done> {
        self.queue.poll()
    }

    pub(super) fn wait(&mut self) -> Option<Done> {
        self.queue.wait()
    }
}

/// Compares trees, all in the first one's unit.
fn compared(trees: &[Compared], cancel: &AtomicBool) -> Result<Arc<Comparison>, String> {
    let stopped = || "The comparison was stopped.".to_owned();
    let Some(first) = trees.first() else {
        return Err(stopped());
    };
    let sized: Vec<Tree> = trees.iter().map(|one| sized(one, first.metres)).collect();
    for tree in &sized {
        let segments = tree.segment_count();
        if segments > SEGMENTS_MOST {
            return Err(format!(
                "A tree of {segments} segments is not compared here: write it as a file and give it to `ramus compare`."
            ));
        }
        tree.validate()
            .map_err(|error| format!("A tree cannot be compared: {error}."))?;
    }
    let study = |tree| {
        let goes_on = !cancel.load(Ordering::Relaxed);
        goes_on.then(|| Studied::new(tree, DVec3::ZERO))
    };
    let studied: Option<Vec<Studied>> = sized.par_iter().map(study).collect();
    let studied = studied.ok_or_else(stopped)?;
    let pairs = compare_with_first(&studied, cancel).ok_or_else(stopped)?;
    let reach = studied[0].axis.as_ref().map_or(1.0, |axis| axis.reach);
    let axes: Option<Vec<(Arc<Display>, u64)>> = sized
        .into_iter()
        .map(|tree| axis(tree, reach, cancel))
        .collect();
    let samples = 0..studied[0].samples.len();
    let plots = samples.filter_map(|place| curves(&studied, place));
    Ok(Arc::new(Comparison {
        plots: plots.collect(),
        numbers: studied.iter().map(|one| one.numbers.clone()).collect(),
        pairs,
        axes: axes.ok_or_else(stopped)?,
        colours: (0..trees.len()).map(colour).collect(),
    }))
}

/// A tree in a unit of so many metres.
fn sized(one: &Compared, metres: f64) -> Tree {
    let mut tree = one.tree().clone();
    #[allow(clippy::cast_possible_truncation, reason = "trees are single")]
    let scale = (one.metres / metres) as f32;
    if scale != 1.0 {
        tree.position.iter_mut().for_each(|at| *at *= scale);
        tree.radius.iter_mut().for_each(|radius| *radius *= scale);
    }
    tree
}

/// Thin tubes along a tree, from its root.
fn axis(mut tree: Tree, reach: f64, cancel: &AtomicBool) -> Option<(Arc<Display>, u64)> {
    let root = tree.position.first().copied().unwrap_or_default();
    tree.position.iter_mut().for_each(|at| *at -= root);
    #[allow(clippy::cast_possible_truncation, reason = "as exact as what is drawn")]
    let [least, most] = THICK.map(|part| part * reach as f32);
    tree.radius
        .iter_mut()
        .for_each(|radius| *radius = (THIN * *radius).clamp(least, most));
    let display = Display::new(Arc::new(tubes_along(&tree)), None, cancel)?;
    Some((Arc::new(display), new_revision()))
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::sync::Arc;

    use super::*;
    use crate::world::comparing::Subject;

    #[test]
    fn trees_of_other_units_are_made_one() {
        let mut tree = Tree {
            letters: vec!["F".to_owned()],
            ..Tree::default()
        };
        for (parent, y) in [(crate::tree::NO_PARENT, 0.0), (0, 2.0), (1, 5.0)] {
            tree.push(crate::tree::Node {
                parent,
                position: glam::Vec3::new(1.0, y, 0.0),
                radius: 0.1,
                letter: 0,
                order: 0,
                birth: 0,
            });
        }
        let tree = Arc::new(tree);
        let of = |metres| Compared::of(Subject::Sketch, Arc::clone(&tree), metres);
        let found = compared(&[of(0.001), of(1.0)], &AtomicBool::new(false)).unwrap();
        let total = |place: usize| {
            let numbers: &Vec<_> = &found.numbers[place];
            let total = numbers.iter().find(|one| one.name == "total_length");
            total.unwrap().value.unwrap()
        };
        assert!((total(0) - 5.0).abs() < 1e-6 && (total(1) - 5000.0).abs() < 1e-2);
        assert_eq!(found.axes.len(), 2);
        assert!(compared(&[of(1.0), of(1.0)], &AtomicBool::new(true)).is_err());
    }
}
