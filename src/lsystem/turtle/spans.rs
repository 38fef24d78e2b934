//! What a string will draw, where no module lifts the pen and none begins an outline: each module then draws so many nodes wherever it
//! stands, and a sum over blocks of modules says all that [`super::plan`] wants to know.
//!
//! A block knows its nodes and parameters, and how many branches it leaves and leaves open; most brackets have their partner in the
//! same block and are never looked at again. A branch as large as is asked for reaches over many blocks, and only its two brackets are looked for.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::column::{Cell, for_width};
use super::super::string::ModuleString;
use super::plan::{Branch, Counted, Kind, LARGE, Plan, each_chunk};

/// Modules of a block.
const BLOCK: usize = 64;

/// Parameters and nodes, 32 bits each, so that one addition adds both.
type Both = u64;

/// What a symbol adds.
#[derive(Clone, Copy, Default)]
struct Adds {
    both: Both,
    /// 1 for a bracket that opens, −1 for one that closes.
    depth: i8,
}

/// What a block adds.
#[derive(Clone, Copy, Default)]
struct Sum {
    /// At most 64 times what a symbol adds.
    both: Both,
    /// Brackets that close what opened before, and that close later.
    closing: u8,
    opening: u8,
}

/// Whether a string of these symbols can be counted so.
pub(super) fn serves(counted: &[Counted]) -> bool {
    let plain = |one: &Counted| !matches!(one.kind, Kind::Lifts | Kind::Begin | Kind::End);
    counted.iter().all(plain)
}

fn adds(counted: &[Counted]) -> Vec<Adds> {
    let of = |one: &Counted| Adds {
        both: Both::from(one.arity) | Both::from(one.nodes) << 32,
        depth: match one.kind {
            Kind::Push => 1,
            Kind::Pop => -1,
            _ => 0,
        },
    };
    counted.iter().map(of).collect()
}

fn halves(both: Both) -> [usize; 2] {
    [both & u64::from(u32::MAX), both >> 32].map(|half| usize::try_from(half).unwrap_or(usize::MAX))
}

/// Counts what a string will draw. None where it was cancelled.
pub(super) fn plan(
    counted: &[Counted],
    string: &ModuleString,
    cancel: &AtomicBool,
) -> Option<Plan> {
    for_width!(&string.symbols, symbols => plan_of(counted, symbols, cancel))
}

fn plan_of<S: Cell>(counted: &[Counted], symbols: &[S], cancel: &AtomicBool) -> Option<Plan> {
    let adds = adds(counted);
    let sums = each_chunk(symbols, |_, chunk| {
        let goes_on = !cancel.load(Ordering::Relaxed);
        goes_on
            .then(|| -> Vec<Sum> { chunk.chunks(BLOCK).map(|block| sum(&adds, block)).collect() })
    });
    let mut spans = Spans {
        adds: &adds,
        symbols,
        before: [0; 2],
        open: Vec::new(),
        branches: Vec::new(),
    };
    let mut number = 0;
    let mut chunks = Vec::with_capacity(sums.len());
    for chunk in sums {
        chunks.push(spans.before);
        for block in chunk? {
            spans.add(number, block);
            number += 1;
        }
    }
    let mut branches = spans.branches;
    branches.sort_unstable_by_key(|branch| branch.open);
    Some(Plan {
        nodes: spans.before[1],
        branches,
        chunks,
        drawing: drawing(counted, symbols),
    })
}

/// Symbols that draw, in the order in which each draws for the first time.
fn drawing<S: Cell>(counted: &[Counted], symbols: &[S]) -> Vec<u16> {
    let draws = |one: &Counted| matches!(one.kind, Kind::Draws | Kind::Places);
    // One pass, however many symbols there are: a sketch of many strokes has a thousand, most of which have not begun.
    let mut wanted: Vec<bool> = counted.iter().map(draws).collect();
    let mut left = wanted.iter().filter(|is_wanted| **is_wanted).count();
    let mut drawing = Vec::with_capacity(left);
    for symbol in symbols {
        if left == 0 {
            break;
        }
        let index = symbol.index();
        if wanted.get_mut(index).is_some_and(std::mem::take) {
            drawing.extend(u16::try_from(index));
            left -= 1;
        }
    }
    drawing
}

fn sum<S: Cell>(adds: &[Adds], block: &[S]) -> Sum {
    let (mut both, mut depth, mut least) = (0, 0_i8, 0_i8);
    for symbol in block {
        let own = adds.get(symbol.index()).copied().unwrap_or_default();
        both += own.both;
        depth += own.depth;
        least = least.min(depth);
    }
    Sum {
        both,
        closing: least.unsigned_abs(),
        opening: (depth - least).unsigned_abs(),
    }
}

/// A bracket without a partner in its block: the block, the how manieth of its kind, and parameters and nodes before the block.
#[derive(Clone, Copy)]
struct Bracket {
    block: usize,
    number: u8,
    before: [usize; 2],
}

/// The blocks so far.
struct Spans<'s, S> {
    adds: &'s [Adds],
    symbols: &'s [S],
    /// Parameters and nodes.
    before: [usize; 2],
    open: Vec<Bracket>,
    branches: Vec<Branch>,
}

impl<S: Cell> Spans<'_, S> {
    fn add(&mut self, block: usize, sum: Sum) {
        let bracket = |number: u8| Bracket {
            block,
            number,
            before: self.before,
        };
        for close in (0..sum.closing).map(bracket) {
            // Strings are balanced: the parser has checked the axiom and every successor.
            if let Some(open) = self.open.pop()
                && (block - open.block + 1) * BLOCK > LARGE
            {
                let branch = branch(self.place(open, 1), self.place(close, -1));
                self.branches.extend(branch);
            }
        }
        self.open.extend((0..sum.opening).map(bracket));
        let [parameters, nodes] = halves(sum.both);
        self.before[0] += parameters;
        self.before[1] += nodes;
    }

    /// The place of a bracket, and the parameters and nodes before it; `kind` is 1 for one that opens, −1 for one that closes.
    fn place(&self, bracket: Bracket, kind: i8) -> Option<(usize, [usize; 2])> {
        let start = bracket.block * BLOCK;
        let block: Range<usize> = start..(start + BLOCK).min(self.symbols.len());
        let symbols = self.symbols.get(block)?.iter();
        // Those that close count from the front, those that open from the back.
        let mut both: Both = 0;
        let mut open: Vec<(usize, Both)> = Vec::new();
        let mut closed = 0;
        for (at, symbol) in (start..).zip(symbols) {
            let own = self.adds.get(symbol.index()).copied().unwrap_or_default();
            match own.depth {
                // What a branch holds begins behind its bracket.
                1 => open.push((at, both + own.both)),
                -1 if open.pop().is_none() => {
                    if kind == -1 && closed == bracket.number {
                        open = vec![(at, both)];
                        break;
                    }
                    closed += 1;
                }
                _ => {}
            }
            both += own.both;
        }
        let number = if kind == 1 {
            usize::from(bracket.number)
        } else {
            0
        };
        let (at, both) = *open.get(number)?;
        let [parameters, nodes] = halves(both);
        let [before, nodes_before] = bracket.before;
        Some((at, [before + parameters, nodes_before + nodes]))
    }
}

/// The branch between two brackets, if it is large.
fn branch(open: Option<(usize, [usize; 2])>, close: Option<(usize, [usize; 2])>) -> Option<Branch> {
    let ((open, before), (close, behind)) = (open?, close?);
    (close - open >= LARGE).then_some(Branch {
        open,
        close,
        parameters: [before[0], behind[0]],
        before: before[1],
        nodes: behind[1] - before[1],
    })
}
