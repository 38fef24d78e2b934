//! Drawing a string in parts beside each other, into one tree whose nodes have their places beforehand.
//!
//! A branch depends on what is before it by the pen at its opening bracket alone. So whoever draws a part of the string gives each
//! large branch on its way to another thread, together with the nodes' places that the plan counted for it, and goes on
//! behind it. The tree is that of the string read in one go, bit for bit.

use std::iter::Zip;
use std::ops::Range;
use std::slice::IterMut;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use glam::{DVec3, Vec3};
use rayon::Scope;

use super::super::error::{DeriveError, DeriveProblem};
use super::super::grammar::Grammar;
use super::super::rewrite::pays_in_parallel;
use super::super::string::ModuleString;
use super::action::{Action, actions};
use super::canvas::{Canvas, Drawn, narrow, narrowed};
use super::pen::Pen;
use super::plan::{Branch, CHUNK, Plan};
use super::tree::{letter_name, most_nodes};
use super::walk::Turtle;
use super::{TreeCanvas, TurtleParams};
use crate::tree::{Cells, NO_PARENT, Tree};

/// The part of a stretch through which the pen runs ahead, 7 of 10: the pen alone takes more than half of the time of drawing.
const RUN_AHEAD: [usize; 2] = [7, 10];

/// The tree of a string.
pub(super) fn tree(
    grammar: &Grammar,
    string: &ModuleString,
    params: &TurtleParams,
    cancel: &AtomicBool,
) -> Result<Tree, DeriveError> {
    let actions = actions(grammar, params);
    let plan = Plan::new(grammar, &actions, string, cancel);
    let within = |plan: &Plan| (plan.nodes as u64) < most_nodes(params);
    let Some(mut plan) = plan.filter(within) else {
        // There is a fault in it, and reading it in one go finds the first.
        let mut turtle = Turtle::new(grammar, params, TreeCanvas::new(grammar, params));
        turtle.read(string, cancel)?;
        return Ok(turtle.finish()?.finish());
    };
    if !pays_in_parallel(string.len()) {
        plan.branches.clear();
        plan.chunks.clear();
    }
    let nodes = plan.nodes + 1;
    let mut tree = empty(nodes).ok_or_else(|| {
        let nodes = nodes as u64;
        DeriveError::from(DeriveProblem::DrawingMemory { nodes })
    })?;
    let letter_of = letters(grammar, &plan, &mut tree);
    let work = Work {
        grammar,
        params,
        actions: &actions,
        letter_of: &letter_of,
        string,
        branches: &plan.branches,
        chunks: &plan.chunks,
        cancel,
        failed: Mutex::new(None),
    };
    let mut places = Places::of(&mut tree);
    let _start = places.take(1);
    let whole = Part {
        modules: [0, string.len()],
        parameters: 0,
        pen: Pen::new(params.width),
        depth: 0,
        places,
    };
    if plan.chunks.is_empty() {
        work.draw(None, whole);
    } else {
        rayon::scope(|scope| work.draw(Some(scope), whole));
    }
    let failed = work.failed.into_inner();
    if let Some((_, error)) = failed.unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    begin(&mut tree, params);
    Ok(tree)
}

/// The start is as thick as the first segment that leaves it, and has its letter.
fn begin(tree: &mut Tree, params: &TurtleParams) {
    fn set<T: Copy>(all: &mut [T], start: T) {
        if let Some(place) = all.first_mut() {
            *place = start;
        }
    }
    let first = tree.parent.iter().skip(1).position(|parent| *parent == 0);
    let (radius, letter) = match first.map(|at| at + 1) {
        Some(first) => (
            tree.radius.get(first).copied(),
            tree.letter.get(first).copied(),
        ),
        None if tree.len() == 1 => (Some(narrow(params.width.abs() / 2.0)), None),
        None => (None, None),
    };
    set(&mut tree.parent, NO_PARENT);
    set(&mut tree.position, Vec3::ZERO);
    set(&mut tree.radius, radius.unwrap_or(0.0));
    set(&mut tree.letter, letter.unwrap_or(0));
    set(&mut tree.order, 0);
    set(&mut tree.birth, 0);
}

/// A tree of so many nodes that are yet to be written; none where the memory is not there.
fn empty(nodes: usize) -> Option<Tree> {
    Some(Tree {
        parent: Cells::unwritten(nodes)?,
        position: Cells::unwritten(nodes)?,
        radius: Cells::unwritten(nodes)?,
        letter: Cells::unwritten(nodes)?,
        order: Cells::unwritten(nodes)?,
        birth: Cells::unwritten(nodes)?,
        letters: Vec::new(),
    })
}

/// Names the tree's letters, in the order in which they first draw; returns them by symbol.
fn letters(grammar: &Grammar, plan: &Plan, tree: &mut Tree) -> Vec<u16> {
    let mut letter_of = vec![0; grammar.names.symbols().len()];
    for symbol in &plan.drawing {
        let name = letter_name(grammar, *symbol);
        let known = tree.letters.iter().position(|l| l == name);
        let index = known.unwrap_or_else(|| {
            tree.letters.push(name.to_owned());
            tree.letters.len() - 1
        });
        if let Some(letter) = letter_of.get_mut(usize::from(*symbol)) {
            *letter = u16::try_from(index).unwrap_or(0);
        }
    }
    if tree.letters.is_empty() {
        tree.letters.push(String::new());
    }
    letter_of
}

/// What all parts share.
struct Work<'w> {
    grammar: &'w Grammar,
    params: &'w TurtleParams,
    actions: &'w [Action],
    /// By symbol.
    letter_of: &'w [u16],
    string: &'w ModuleString,
    branches: &'w [Branch],
    /// Parameters and nodes before every `CHUNK`th module.
    chunks: &'w [[usize; 2]],
    cancel: &'w AtomicBool,
    /// The first fault of the string, and the module that it was found at.
    failed: Mutex<Option<(u64, DeriveError)>>,
}

/// A part of the string.
struct Part<'w> {
    /// Its first module and the one behind it.
    modules: [usize; 2],
    /// Parameters before it.
    parameters: usize,
    pen: Pen,
    /// Brackets round it.
    depth: usize,
    places: Places<'w>,
}

impl Work<'_> {
    fn draw<'s>(&'s self, scope: Option<&Scope<'s>>, part: Part<'s>) {
        let canvas = Placed::new(self.letter_of, part.places);
        let mut turtle = Turtle::within(self.grammar, self.params, self.actions.to_vec(), canvas);
        turtle.go_to(part.pen, part.depth);
        let read = self.read(scope, &mut turtle, part.modules, part.parameters);
        if let Err(error) = read {
            let at = turtle.position();
            let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
            if failed.as_ref().is_none_or(|(first, _)| at < *first) {
                *failed = Some((at, error));
            }
        }
    }

    fn read<'s>(
        &'s self,
        scope: Option<&Scope<'s>>,
        turtle: &mut Turtle<'_, Placed<'s>>,
        [mut from, end]: [usize; 2],
        mut parameters: usize,
    ) -> Result<(), DeriveError> {
        let mut branches = self.branches;
        loop {
            let passed = branches.partition_point(|branch| branch.open < from);
            branches = branches.get(passed..).unwrap_or(&[]);
            let next = branches.first().filter(|branch| branch.open < end);
            turtle.set_position(from as u64);
            let until = next.map_or(end, |branch| branch.open);
            if let Some(scope) = scope
                && turtle.is_level()
                && let Some((chunk, before)) = self.split(from..until)
            {
                let part = Part {
                    modules: [from, chunk],
                    parameters,
                    pen: *turtle.pen(),
                    depth: turtle.depth(),
                    places: turtle.canvas_mut().leave(before[1]),
                };
                scope.spawn(move |_| self.draw(None, part));
                turtle.read_part(self.string, from..chunk, parameters, self.cancel)?;
                (from, parameters) = (chunk, before[0]);
                continue;
            }
            turtle
                .canvas_mut()
                .stretch(next.map(|branch| branch.before));
            turtle.read_part(self.string, from..until, parameters, self.cancel)?;
            debug_assert!(turtle.canvas_mut().nodes.len() == 0, "each node is written");
            let (Some(branch), Some(scope)) = (next, scope) else {
                return Ok(());
            };
            let (pen, depth) = turtle.inside()?;
            let part = Part {
                modules: [branch.open + 1, branch.close],
                parameters: branch.parameters[0],
                pen,
                depth,
                places: turtle.canvas_mut().places.take(branch.nodes),
            };
            scope.spawn(move |scope| self.draw(Some(scope), part));
            from = branch.close + 1;
            parameters = branch.parameters[1];
        }
    }

    /// Where a stretch without large branches is to be cut, and the parameters and nodes before that: where most of the string is in one
    /// piece, whoever comes to it runs ahead with the pen alone and draws the end, while another thread draws the beginning.
    fn split(&self, stretch: Range<usize>) -> Option<(usize, [usize; 2])> {
        let length = stretch.len();
        if length.saturating_mul(rayon::current_num_threads()) <= self.string.len() {
            return None;
        }
        let chunk = (stretch.start + length / RUN_AHEAD[1] * RUN_AHEAD[0]) / CHUNK;
        let before = self.chunks.get(chunk)?;
        (chunk * CHUNK > stretch.start).then_some((chunk * CHUNK, *before))
    }
}

/// Places for a tree's nodes one after the other.
#[derive(Default)]
struct Places<'w> {
    /// The number of the first.
    first: usize,
    parent: &'w mut [u32],
    position: &'w mut [Vec3],
    radius: &'w mut [f32],
    letter: &'w mut [u16],
    order: &'w mut [u16],
    birth: &'w mut [u32],
}

impl<'w> Places<'w> {
    fn of(tree: &'w mut Tree) -> Self {
        Self {
            first: 0,
            parent: &mut tree.parent,
            position: &mut tree.position,
            radius: &mut tree.radius,
            letter: &mut tree.letter,
            order: &mut tree.order,
            birth: &mut tree.birth,
        }
    }

    /// The next places, for so many nodes.
    fn take(&mut self, nodes: usize) -> Self {
        fn next<'w, T>(all: &mut &'w mut [T], nodes: usize) -> &'w mut [T] {
            let whole = std::mem::take(all);
            let (taken, left) = whole.split_at_mut(nodes.min(whole.len()));
            *all = left;
            taken
        }
        let first = self.first;
        self.first += nodes;
        Self {
            first,
            parent: next(&mut self.parent, nodes),
            position: next(&mut self.position, nodes),
            radius: next(&mut self.radius, nodes),
            letter: next(&mut self.letter, nodes),
            order: next(&mut self.order, nodes),
            birth: next(&mut self.birth, nodes),
        }
    }
}

/// Iterates over two arrays at once, and so over more: one look at the end does for all.
type Both<'w, A, T> = Zip<A, IterMut<'w, T>>;
type Skeleton<'w> = Both<'w, Both<'w, IterMut<'w, u32>, Vec3>, f32>;
type Nodes<'w> = Both<'w, Both<'w, Both<'w, Skeleton<'w>, u16>, u16>, u32>;

/// The canvas of one part.
struct Placed<'w> {
    /// By symbol.
    letter_of: &'w [u16],
    /// Places of the stretch that is drawn, and the number of the next node.
    nodes: Nodes<'w>,
    number: u32,
    /// Those behind it.
    places: Places<'w>,
}

impl<'w> Placed<'w> {
    fn new(letter_of: &'w [u16], places: Places<'w>) -> Self {
        Self {
            letter_of,
            nodes: nodes(Places::default()),
            number: 0,
            places,
        }
    }

    /// The places up to the one with so many nodes before it, or all that are left. The start is a node that is not counted.
    fn up_to(&mut self, before: Option<usize>) -> Places<'w> {
        let left = self.places.parent.len();
        let first = self.places.first;
        let places = before.map_or(left, |before| (before + 1).saturating_sub(first));
        // A tree has fewer than 2^32 nodes.
        self.number = u32::try_from(first).unwrap_or(u32::MAX);
        self.places.take(places)
    }

    /// Goes on with a stretch that another thread draws in the places given: here its nodes are but numbered.
    fn leave(&mut self, before: usize) -> Places<'w> {
        self.nodes = nodes(Places::default());
        self.up_to(Some(before))
    }

    /// Goes on with a stretch up to the place with so many nodes before it, or with all that is left.
    fn stretch(&mut self, before: Option<usize>) {
        self.nodes = nodes(self.up_to(before));
    }

    #[inline(always)]
    fn add(&mut self, parent: u32, position: Vec3, radius: f32, pen: &Pen, by: Drawn) -> u32 {
        if let Some((((((p, x), r), l), o), b)) = self.nodes.next() {
            let letter = self.letter_of.get(usize::from(by.symbol));
            (*p, *x, *r) = (parent, position, radius);
            (*l, *o, *b) = (letter.copied().unwrap_or(0), pen.order, by.birth);
        }
        let number = self.number;
        self.number = number.wrapping_add(1);
        number
    }
}

fn nodes(places: Places<'_>) -> Nodes<'_> {
    let skeleton = places.parent.iter_mut().zip(places.position);
    let skeleton = skeleton.zip(places.radius);
    skeleton
        .zip(places.letter)
        .zip(places.order)
        .zip(places.birth)
}

impl Canvas for Placed<'_> {
    fn root(&mut self, pen: &Pen, by: Drawn, radius: f32) -> Result<u32, DeriveError> {
        Ok(self.add(NO_PARENT, narrowed(pen.position), radius, pen, by))
    }

    #[inline]
    fn segment(
        &mut self,
        pen: &Pen,
        by: Drawn,
        end: DVec3,
        radius: f32,
    ) -> Result<u32, DeriveError> {
        Ok(self.add(pen.node, narrowed(end), radius, pen, by))
    }
}
