//! The modules of a graph's string in order, at the cost of a stack as deep as the derivation has steps.

use super::{Blocks, Piece};
use crate::lsystem::string::Module;

/// A block that the walk is in.
#[derive(Clone, Copy, Debug)]
struct Open {
    block: usize,
    /// Its next piece.
    piece: usize,
    /// The birth of the module that it stands for.
    birth: u32,
}

/// What a walk comes to.
pub(super) enum Met<'g> {
    Module(Module<'g>),
    /// A block, and the birth of the module that it stands for. It is passed over unless it is entered.
    Block(usize, u32),
    /// The end of the block entered last.
    End,
}

/// A walk through the modules of a string that is nowhere written down.
#[derive(Clone, Debug)]
pub(crate) struct Walk<'g> {
    graph: &'g Blocks,
    open: Vec<Open>,
}

impl<'g> Walk<'g> {
    /// A walk from the first module on.
    pub(super) fn new(graph: &'g Blocks) -> Self {
        let mut walk = Self {
            graph,
            open: Vec::new(),
        };
        walk.enter(0, 0);
        walk
    }

    /// Goes on inside a block.
    pub(super) fn enter(&mut self, block: usize, birth: u32) {
        self.open.push(Open {
            block,
            piece: 0,
            birth,
        });
    }

    /// The next thing to come to; `None` at the end of the string.
    #[inline]
    pub(super) fn meet(&mut self) -> Option<Met<'g>> {
        let open = self.open.last_mut()?;
        let graph = self.graph;
        let block = graph.blocks.get(open.block)?;
        let Some(piece) = graph.pieces_of(block).get(open.piece) else {
            self.open.pop();
            return Some(Met::End);
        };
        let birth = match block.same == Some(open.piece) {
            true => open.birth,
            false => block.step,
        };
        open.piece += 1;
        Some(match *piece {
            Piece::Module(symbol, from) => Met::Module(Module {
                symbol,
                birth,
                parameters: match graph.arity(symbol) {
                    0 => &[],
                    arity => graph.parameters.get(from..from + arity)?,
                },
            }),
            Piece::Block(inner) => Met::Block(inner, birth),
        })
    }

    /// Passes over so many modules, whole blocks at a time. Gives the number of their parameters.
    pub(crate) fn skip_modules(&mut self, mut modules: u128) -> u128 {
        let mut parameters = 0;
        while modules > 0 {
            match self.meet() {
                None => break,
                Some(Met::End) => {}
                Some(Met::Module(module)) => {
                    modules -= 1;
                    parameters += module.parameters.len() as u128;
                }
                Some(Met::Block(block, birth)) => {
                    let size = self.graph.blocks.get(block).map(|b| b.size);
                    let size = size.unwrap_or_default();
                    if size.modules > modules {
                        self.enter(block, birth);
                    } else {
                        modules -= size.modules;
                        parameters = parameters.saturating_add(size.parameters);
                    }
                }
            }
        }
        parameters
    }

    /// Blocks that the walk is in.
    pub(super) fn depth(&self) -> usize {
        self.open.len()
    }
}

impl<'g> Iterator for Walk<'g> {
    type Item = Module<'g>;

    fn next(&mut self) -> Option<Module<'g>> {
        loop {
            match self.meet()? {
                Met::Module(module) => return Some(module),
                Met::Block(block, birth) => self.enter(block, birth),
                Met::End => {}
            }
        }
    }
}
