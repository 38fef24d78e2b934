//! What a string will draw, counted before it is drawn: how many nodes, and where its large branches begin and end. So the tree's memory is
//! asked for once, and branches can be drawn beside each other.
//!
//! Each chunk of the string is counted by itself. What it cannot know is whether the turtle comes to it, or back to a branch that began
//! before it, with its pen up (then the next segment needs a root). Nodes that depend on that are counted apart, for each of these branches:
//! `cond`; going over the chunks' sums from front to back settles them. Outlines draw no nodes, and how many are open at a chunk's beginning
//! is counted beforehand.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::super::column::{Cell, for_width};
use super::super::grammar::Grammar;
use super::super::rewrite::{TOGETHER, pays_in_parallel};
use super::super::string::ModuleString;
use super::TurtleParams;
use super::action::{Action, actions};
use super::spans;

/// Modules counted by themselves.
pub(super) const CHUNK: usize = 1 << 14;
/// Branches of so many modules are drawn beside others.
pub(super) const LARGE: usize = 1 << 12;

/// What a symbol counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Nothing,
    /// Draws from where the turtle is, and goes on from there.
    Draws,
    /// Draws and comes back.
    Places,
    Push,
    Pop,
    /// Moves with the pen up.
    Lifts,
    Begin,
    End,
}

/// The same with its number of nodes and of parameters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counted {
    pub(super) kind: Kind,
    pub(super) arity: u8,
    pub(super) nodes: u16,
}

fn counted(grammar: &Grammar, actions: &[Action]) -> Vec<Counted> {
    let length = |shape: u16| {
        let shape = grammar.shapes.get(usize::from(shape));
        shape.map_or(0, |s| u16::try_from(s.segments.len()).unwrap_or(u16::MAX))
    };
    let of = |(action, arity): (&Action, &u8)| {
        let (kind, nodes) = match action {
            Action::Draw | Action::DrawWithin => (Kind::Draws, 1),
            Action::Follow(shape) if *arity == 0 => (Kind::Draws, length(*shape)),
            Action::Follow(_) => (Kind::Draws, 1),
            Action::Place(shape) => (Kind::Places, length(*shape)),
            Action::Push => (Kind::Push, 0),
            Action::Pop => (Kind::Pop, 0),
            Action::Move | Action::MoveWithin => (Kind::Lifts, 0),
            Action::BeginPolygon => (Kind::Begin, 0),
            Action::EndPolygon => (Kind::End, 0),
            _ => (Kind::Nothing, 0),
        };
        let arity = *arity;
        Counted { kind, arity, nodes }
    };
    actions.iter().zip(grammar.arity.iter()).map(of).collect()
}

/// What a module adds to the number of segments.
pub(in crate::lsystem) enum Lines {
    Segments(u16),
    /// An outline begins, in which nothing draws segments,
    Begin,
    /// and ends.
    End,
}

/// What each symbol's modules add to the number of segments.
pub(in crate::lsystem) fn lines_of(grammar: &Grammar) -> Vec<Lines> {
    let lines = |one: &Counted| match one.kind {
        Kind::Draws | Kind::Places => Lines::Segments(one.nodes),
        Kind::Begin => Lines::Begin,
        Kind::End => Lines::End,
        _ => Lines::Segments(0),
    };
    let actions = actions(grammar, &TurtleParams::default());
    counted(grammar, &actions).iter().map(lines).collect()
}

/// A branch large enough to be drawn beside others. No outline is open at either end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Branch {
    /// Index of its `[`.
    pub(super) open: usize,
    /// Index of its `]`.
    pub(super) close: usize,
    /// Parameters before its first module, and before its `]`.
    pub(super) parameters: [usize; 2],
    /// Nodes before its first module, and between its brackets.
    pub(super) before: usize,
    pub(super) nodes: usize,
}

/// What a string will draw.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Plan {
    /// Nodes beside the start.
    pub(super) nodes: usize,
    /// In the order of their openings.
    pub(super) branches: Vec<Branch>,
    /// Parameters and nodes before every `CHUNK`th module.
    pub(super) chunks: Vec<[usize; 2]>,
    /// Symbols that draw, in the order in which each draws for the first time.
    pub(super) drawing: Vec<u16>,
}

/// A place in a chunk.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    module: usize,
    parameters: usize,
    /// Nodes before it in the chunk that are certain,
    nodes: usize,
    /// and those that depend on how the turtle comes to the branch `level`.
    cond: usize,
    level: usize,
    outlines: usize,
}

/// Whether the pen is up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Up {
    No,
    Yes,
    /// As it was when the turtle came to the branch.
    #[default]
    AsItCame,
}

impl Up {
    fn settled(self, came: bool) -> bool {
        match self {
            Self::No => false,
            Self::Yes => true,
            Self::AsItCame => came,
        }
    }
}

/// A chunk's sums.
#[derive(Debug, Default)]
struct Chunk {
    /// Its end.
    here: Place,
    up: Up,
    /// Nodes that depend on how the turtle comes to the chunk, back to the branch round it, and so on.
    cond: Vec<usize>,
    /// Brackets that close what opened before,
    closed: Vec<Place>,
    /// and that close later.
    open: Vec<(Place, Up)>,
    /// Large branches of its own.
    branches: Vec<[Place; 2]>,
    /// By symbol: where it draws first.
    first: Vec<usize>,
}

impl Plan {
    /// Counts what a string will draw. None where it cannot be drawn (outlines that do not close) or the counting was cancelled.
    pub(super) fn new(
        grammar: &Grammar,
        actions: &[Action],
        string: &ModuleString,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let counted = counted(grammar, actions);
        if spans::serves(&counted) {
            return spans::plan(&counted, string, cancel);
        }
        Self::by_chunks(&counted, string, cancel)
    }

    fn by_chunks(counted: &[Counted], string: &ModuleString, cancel: &AtomicBool) -> Option<Self> {
        let outlines = outlines_before(counted, string)?;
        let chunks = for_width!(&string.symbols, symbols => each_chunk(symbols, |number, symbols| {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            let outlines = outlines.get(number).copied().unwrap_or(0);
            Some(count(counted, symbols, number * CHUNK, outlines))
        }));
        let chunks: Option<Vec<Chunk>> = chunks.into_iter().collect();
        Some(Self::settled(&chunks?, counted.len()))
    }

    /// Puts the chunks' sums together.
    fn settled(chunks: &[Chunk], symbols: usize) -> Self {
        let mut first = vec![usize::MAX; symbols];
        let mut branches = Vec::new();
        let mut starts = Vec::with_capacity(chunks.len());
        // The turtle at a chunk's beginning: whether its pen is up, and for each open branch where it opened and whether the pen
        // was up there.
        let (mut before, mut up) = (Place::default(), false);
        let mut open: Vec<(Place, bool)> = Vec::new();
        for chunk in chunks {
            starts.push([before.parameters, before.nodes]);
            let came: Vec<bool> = (0..chunk.cond.len())
                .map(|level| match level {
                    0 => up,
                    _ => open
                        .len()
                        .checked_sub(level)
                        .and_then(|at| open.get(at))
                        .is_some_and(|o| o.1),
                })
                .collect();
            // Nodes of the levels before each.
            let mut sum = 0;
            let levels: Vec<usize> = (chunk.cond.iter().zip(&came))
                .map(|(cond, came)| {
                    let before = sum;
                    sum += if *came { *cond } else { 0 };
                    before
                })
                .collect();
            let came_at = |level: usize| came.get(level).copied().unwrap_or(false);
            let settle = |place: Place| Place {
                parameters: before.parameters + place.parameters,
                nodes: before.nodes
                    + place.nodes
                    + levels.get(place.level).copied().unwrap_or(0)
                    + if came_at(place.level) { place.cond } else { 0 },
                ..place
            };
            for place in &chunk.closed {
                if let Some((start, _)) = open.pop() {
                    branches.extend(branch(start, settle(*place)));
                }
            }
            branches.extend(
                chunk
                    .branches
                    .iter()
                    .filter_map(|ends| branch(settle(ends[0]), settle(ends[1]))),
            );
            open.extend(
                chunk
                    .open
                    .iter()
                    .map(|(place, up)| (settle(*place), up.settled(came_at(place.level)))),
            );
            up = chunk.up.settled(came_at(chunk.here.level));
            before = settle(chunk.here);
            for (all, own) in first.iter_mut().zip(&chunk.first) {
                *all = (*all).min(*own);
            }
        }
        branches.sort_unstable_by_key(|branch| branch.open);
        let mut drawing: Vec<u16> = (0..)
            .take(symbols)
            .filter(|s| first.get(usize::from(*s)) < Some(&usize::MAX))
            .collect();
        drawing.sort_by_key(|symbol| first.get(usize::from(*symbol)).copied());
        Self {
            nodes: before.nodes,
            branches,
            chunks: starts,
            drawing,
        }
    }
}

/// The branch between two brackets, if it is worth being drawn beside others and can be.
fn branch(open: Place, close: Place) -> Option<Branch> {
    let large = close.module - open.module >= LARGE;
    (large && open.outlines == 0 && close.outlines == 0).then_some(Branch {
        open: open.module,
        close: close.module,
        parameters: [open.parameters, close.parameters],
        before: open.nodes,
        nodes: close.nodes - open.nodes,
    })
}

/// Open outlines at the beginning of each chunk; none where they do not close, or close without being open.
fn outlines_before(counted: &[Counted], string: &ModuleString) -> Option<Vec<usize>> {
    let has = |kind: Kind| counted.iter().any(|c| c.kind == kind);
    if !has(Kind::Begin) && !has(Kind::End) {
        return Some(Vec::new());
    }
    let changes =
        for_width!(&string.symbols, symbols => each_chunk(symbols, |_, s| change(counted, s)));
    let mut before = Vec::with_capacity(changes.len());
    let mut open = 0_isize;
    for (sum, least) in changes {
        usize::try_from(open + least).ok()?;
        before.push(usize::try_from(open).ok()?);
        open += sum;
    }
    (open == 0).then_some(before)
}

/// How many outlines a chunk leaves open, and how many at least it has open meanwhile.
fn change<S: Cell>(counted: &[Counted], symbols: &[S]) -> (isize, isize) {
    let (mut sum, mut least) = (0_isize, 0_isize);
    for symbol in symbols {
        match counted.get(symbol.index()).map(|c| c.kind) {
            Some(Kind::Begin) => sum += 1,
            Some(Kind::End) => {
                sum -= 1;
                least = least.min(sum);
            }
            _ => {}
        }
    }
    (sum, least)
}

/// Does a work for each chunk, in parallel where it pays.
pub(super) fn each_chunk<S: Cell, R: Send>(
    symbols: &[S],
    work: impl Fn(usize, &[S]) -> R + Sync + Send,
) -> Vec<R> {
    if pays_in_parallel(symbols.len()) {
        let chunks = symbols.par_chunks(CHUNK).enumerate();
        let chunks = chunks.with_max_len(TOGETHER);
        chunks.map(|(number, chunk)| work(number, chunk)).collect()
    } else {
        let chunks = symbols.chunks(CHUNK).enumerate();
        chunks.map(|(number, chunk)| work(number, chunk)).collect()
    }
}

fn count<S: Cell>(counted: &[Counted], symbols: &[S], from: usize, outlines: usize) -> Chunk {
    let mut chunk = Chunk {
        first: vec![usize::MAX; counted.len()],
        ..Chunk::default()
    };
    let mut here = Place {
        outlines,
        ..Place::default()
    };
    let mut up = Up::AsItCame;
    for (module, symbol) in (from..).zip(symbols) {
        let symbol = symbol.index();
        let Some(Counted { kind, arity, nodes }) = counted.get(symbol).copied() else {
            continue;
        };
        match kind {
            Kind::Nothing => {}
            Kind::Draws | Kind::Places if here.outlines == 0 => {
                here.nodes += usize::from(nodes);
                match up {
                    Up::No => {}
                    Up::Yes => here.nodes += 1,
                    Up::AsItCame => here.cond += 1,
                }
                if kind == Kind::Draws {
                    up = Up::No;
                }
                if let Some(first) = chunk.first.get_mut(symbol) {
                    *first = (*first).min(module);
                }
            }
            Kind::Draws | Kind::Lifts => up = Up::Yes,
            Kind::Places => {}
            Kind::Push => {
                let mut place = Place { module, ..here };
                place.parameters += usize::from(arity);
                chunk.open.push((place, up));
            }
            Kind::Pop => {
                let end = Place { module, ..here };
                if let Some((start, was_up)) = chunk.open.pop() {
                    up = was_up;
                    if module - start.module >= LARGE {
                        chunk.branches.push([start, end]);
                    }
                } else {
                    chunk.closed.push(end);
                    chunk.cond.push(here.cond);
                    here.cond = 0;
                    here.level += 1;
                    up = Up::AsItCame;
                }
            }
            Kind::Begin => here.outlines += 1,
            Kind::End => here.outlines = here.outlines.saturating_sub(1),
        }
        here.parameters += usize::from(arity);
    }
    chunk.cond.push(here.cond);
    (chunk.here, chunk.up) = (here, up);
    chunk
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails shows the line")]
    use std::fmt::Write as _;

    use super::*;

    /// A string of about so many modules, with branches of all sizes; `seed` says which.
    fn text(length: usize, seed: u64) -> String {
        let mut state = seed;
        let mut random = move |below: u64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) % below
        };
        let (mut text, mut depth) = (String::from("axiom A"), 0_usize);
        for at in 0..length {
            // Now a time of opening, now of closing: branches reach over many blocks.
            let opens = if at / 3000 % 2 == 0 { 3 } else { 1 };
            match random(20) {
                less if less < opens => {
                    depth += 1;
                    text.push('[');
                }
                less if less < 4 && depth > 0 => {
                    depth -= 1;
                    text.push(']');
                }
                4..8 => text.push('F'),
                8 => text.push('G'),
                9 => text.push('S'),
                10 => text.push_str("S(1)"),
                11 => {
                    let _ = write!(text, "+({at})");
                }
                _ => text.push('A'),
            }
        }
        text.push_str(&"]".repeat(depth));
        text + "\nshape S = [(0 1 0) (0 1 0) (0.1 1 0)]\n"
    }

    #[test]
    fn blocks_count_what_chunks_count() {
        let never = AtomicBool::new(false);
        let mut large = 0;
        for (seed, length) in [0, 1, 63, 64, 65, 5_000, 40_000, 100_000, 100_001]
            .iter()
            .enumerate()
        {
            let grammar = Grammar::parse(&text(*length, seed as u64), "random").unwrap();
            let counted = counted(&grammar, &actions(&grammar, &TurtleParams::default()));
            assert!(spans::serves(&counted), "nothing lifts the pen");
            let blocks = spans::plan(&counted, &grammar.axiom, &never).unwrap();
            let chunks = Plan::by_chunks(&counted, &grammar.axiom, &never).unwrap();
            assert_eq!(blocks, chunks, "{length} modules");
            large += blocks.branches.len();
        }
        assert!(large > 20, "there are large branches: {large}");
    }
}
