//! The string of a graph, written from front to back; a block that was written before is copied from there.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::{BETWEEN_CHECKS, Block, Blocks, Piece};
use crate::lsystem::column::{Cell, Narrow, bytes_up_to};
use crate::lsystem::names::Symbol;
use crate::lsystem::output::zeroed;
use crate::lsystem::string::ModuleString;

/// Modules copied between two looks at the cancel flag.
const COPIED_AT_ONCE: usize = 1 << 22;

impl Blocks {
    /// Writes the string. `None`: cancelled, or the memory is not there.
    pub(crate) fn string(&self, cancel: &AtomicBool) -> Option<ModuleString> {
        let newest = u32::try_from(self.steps()).unwrap_or(u32::MAX);
        match (bytes_up_to(self.most_symbol), bytes_up_to(newest)) {
            (1, 1) => self.written::<u8, u8>(cancel),
            (1, 2) => self.written::<u8, u16>(cancel),
            (1, _) => self.written::<u8, u32>(cancel),
            (_, 1) => self.written::<u16, u8>(cancel),
            (_, 2) => self.written::<u16, u16>(cancel),
            (_, _) => self.written::<u16, u32>(cancel),
        }
    }

    fn written<S: Narrow, B: Cell>(&self, cancel: &AtomicBool) -> Option<ModuleString> {
        let root = self.blocks.first()?;
        let modules = usize::try_from(root.size.modules).ok()?;
        let parameters = usize::try_from(root.size.parameters).ok()?;
        let writing = Writing::<S, B> {
            graph: self,
            symbols: zeroed(modules)?,
            births: zeroed(modules)?,
            parameters: zeroed(parameters)?,
            at: Place::default(),
            written: vec![None; self.blocks.len()],
        };
        writing.all(cancel)
    }
}

/// Modules and parameters before a place in a string.
#[derive(Clone, Copy, Default)]
struct Place {
    module: usize,
    parameter: usize,
}

/// A string while it is written.
struct Writing<'a, S, B> {
    graph: &'a Blocks,
    symbols: Vec<S>,
    births: Vec<B>,
    parameters: Vec<f64>,
    at: Place,
    /// Where each block was first written.
    written: Vec<Option<Place>>,
}

impl<S: Narrow, B: Cell> Writing<'_, S, B> {
    fn all(mut self, cancel: &AtomicBool) -> Option<ModuleString> {
        // Blocks that are being written: the block, its next piece, its start.
        let mut open = vec![(0, 0, Place::default())];
        let mut since_check = 0;
        while let Some((index, number, start)) = open.pop() {
            let block = self.graph.blocks.get(index)?;
            let Some(piece) = self.graph.pieces_of(block).get(number) else {
                if let Some(written) = self.written.get_mut(index) {
                    *written = Some(start);
                }
                self.date(block, start);
                continue;
            };
            open.push((index, number + 1, start));
            match *piece {
                Piece::Module(symbol, from) => self.module(symbol, from, block.step)?,
                Piece::Block(inner) => match self.written.get(inner).copied().flatten() {
                    Some(source) => self.copy(inner, source, cancel)?,
                    None => open.push((inner, 0, self.at)),
                },
            }
            since_check += 1;
            if since_check >= BETWEEN_CHECKS {
                since_check = 0;
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
            }
        }
        Some(ModuleString {
            symbols: S::column(self.symbols),
            births: B::column(self.births),
            parameters: self.parameters,
            arity: Arc::clone(&self.graph.arity),
        })
    }

    fn module(&mut self, symbol: Symbol, from: usize, birth: u32) -> Option<()> {
        let arity = self.graph.arity(symbol);
        let Place { module, parameter } = self.at;
        *self.symbols.get_mut(module)? = S::of(u32::from(symbol));
        *self.births.get_mut(module)? = B::of(birth);
        let own = self.graph.parameters.get(from..from + arity)?;
        let target = self.parameters.get_mut(parameter..parameter + arity)?;
        target.copy_from_slice(own);
        self.at = Place {
            module: module + 1,
            parameter: parameter + arity,
        };
        Some(())
    }

    /// Repeats a block that was written before.
    fn copy(&mut self, index: usize, source: Place, cancel: &AtomicBool) -> Option<()> {
        let block = self.graph.blocks.get(index)?;
        let modules = usize::try_from(block.size.modules).ok()?;
        let parameters = usize::try_from(block.size.parameters).ok()?;
        let start = self.at;
        let (from, to) = (source.module, start.module);
        repeat(&mut self.symbols, from, to, modules, cancel)?;
        repeat(&mut self.births, from, to, modules, cancel)?;
        let (from, to) = (source.parameter, start.parameter);
        repeat(&mut self.parameters, from, to, parameters, cancel)?;
        self.at = Place {
            module: start.module + modules,
            parameter: start.parameter + parameters,
        };
        self.date(block, start);
        Some(())
    }

    /// Gives the module that a block stands for its own birth: it was born one step before its successor. Where it is
    /// older, the block around knows.
    fn date(&mut self, block: &Block, start: Place) {
        let heir = block.heir.and_then(|at| usize::try_from(at).ok());
        if let Some(birth) = heir.and_then(|at| self.births.get_mut(start.module + at)) {
            *birth = B::of(block.step.saturating_sub(1));
        }
    }
}

/// Copies `length` values from one place to another further on. `None`: cancelled.
fn repeat<T: Copy>(
    values: &mut [T],
    from: usize,
    to: usize,
    length: usize,
    cancel: &AtomicBool,
) -> Option<()> {
    let end = to.checked_add(length)?;
    let (before, target) = values.get_mut(..end)?.split_at_mut_checked(to)?;
    let source = before.get(from..from.checked_add(length)?)?;
    let parts = source.chunks(COPIED_AT_ONCE);
    for (part, copy) in parts.zip(target.chunks_mut(COPIED_AT_ONCE)) {
        if length > COPIED_AT_ONCE && cancel.load(Ordering::Relaxed) {
            return None;
        }
        copy.copy_from_slice(part);
    }
    Some(())
}
