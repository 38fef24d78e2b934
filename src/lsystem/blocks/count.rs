//! What a graph's string holds, counted without writing it: how often each block stands in it says how often each module does.

use super::{Blocks, Piece};
use crate::lsystem::grammar::{Grammar, Role};
use crate::lsystem::report::{Counts, Sum, by_name};
use crate::lsystem::turtle::{Lines, lines_of};

/// What a block adds to a measure that depends on where in the string it stands.
#[derive(Clone, Copy, Default)]
struct Within {
    /// Deepest bracket.
    depth: u64,
    /// Segments, where no outline is open round it.
    segments: u128,
}

impl Blocks {
    /// Counts the modules of the string after these steps, which were all made.
    pub(crate) fn counts(&self, grammar: &Grammar, steps: u32) -> Counts {
        let (modules, sums) = self.by_symbol(grammar);
        let within = self.within(grammar);
        let (counts, param_sums) = by_name(grammar, &modules, &sums);
        Counts {
            steps,
            modules: self.size(steps).modules,
            counts,
            param_sums,
            max_depth: within.depth,
            // What an `interpret` block draws is not in the string.
            segments: grammar.interpret.is_none().then_some(within.segments),
        }
    }

    /// For each symbol its modules and the sums of their parameters.
    fn by_symbol(&self, grammar: &Grammar) -> (Vec<u128>, Vec<Vec<Sum>>) {
        let mut counts = vec![0_u128; grammar.arity.len()];
        let sums = |arity: &u8| vec![Sum::default(); usize::from(*arity)];
        let mut sums: Vec<Vec<Sum>> = grammar.arity.iter().map(sums).collect();
        // A block stands behind those that it is a piece of.
        let mut times = vec![0_u128; self.blocks.len()];
        if let Some(axiom) = times.first_mut() {
            *axiom = 1;
        }
        for (index, block) in self.blocks.iter().enumerate() {
            let own = times.get(index).copied().unwrap_or(0);
            for piece in self.pieces_of(block) {
                match *piece {
                    Piece::Block(inner) => {
                        if let Some(times) = times.get_mut(inner) {
                            *times = times.saturating_add(own);
                        }
                    }
                    Piece::Module(symbol, from) => {
                        let symbol = usize::from(symbol);
                        if let Some(count) = counts.get_mut(symbol) {
                            *count = count.saturating_add(own);
                        }
                        let values = self.parameters.get(from..).unwrap_or(&[]);
                        let sums = sums.get_mut(symbol).into_iter().flatten();
                        for (sum, value) in sums.zip(values) {
                            sum.add_times(*value, own);
                        }
                    }
                }
            }
        }
        (counts, sums)
    }

    /// Depth and segments of the whole string. Brackets and outlines match in each successor, so a block begins and ends
    /// at the same depth.
    fn within(&self, grammar: &Grammar) -> Within {
        let lines = lines_of(grammar);
        let mut all = vec![Within::default(); self.blocks.len()];
        for (index, block) in self.blocks.iter().enumerate().rev() {
            let mut sum = Within::default();
            let (mut depth, mut outlines) = (0_u64, 0_u64);
            for piece in self.pieces_of(block) {
                let own = match *piece {
                    Piece::Block(inner) => all.get(inner).copied().unwrap_or_default(),
                    Piece::Module(symbol, _) => {
                        match grammar.role(symbol) {
                            Role::Open => depth += 1,
                            Role::Close => depth = depth.saturating_sub(1),
                            _ => {}
                        }
                        let segments = match lines.get(usize::from(symbol)) {
                            Some(Lines::Begin) => {
                                outlines += 1;
                                0
                            }
                            Some(Lines::End) => {
                                outlines = outlines.saturating_sub(1);
                                0
                            }
                            Some(Lines::Segments(number)) => u128::from(*number),
                            None => 0,
                        };
                        Within { depth: 0, segments }
                    }
                };
                sum.depth = sum.depth.max(depth + own.depth);
                if outlines == 0 {
                    sum.segments = sum.segments.saturating_add(own.segments);
                }
            }
            if let Some(within) = all.get_mut(index) {
                *within = sum;
            }
        }
        all.first().copied().unwrap_or_default()
    }
}
