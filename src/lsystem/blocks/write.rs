//! The string of a graph, written in slices that know nothing of each other: each by a walk from its own beginning.
//!
//! Within a slice a block that was written before is copied from there. A slice is as large as the caches are, so that what is
//! copied is read from them; and memory that is fresh from the system is first touched by all threads, which is most of the time
//! that a string of a billion modules takes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::walk::{Met, Walk};
use super::{BETWEEN_CHECKS, Blocks};
use crate::lsystem::column::{Cell, Narrow, bytes_up_to};
use crate::lsystem::output::Output;
use crate::lsystem::rewrite::pays_in_parallel;
use crate::lsystem::string::ModuleString;
use crate::tree::Cells;

/// Modules of a slice at most,
const LONGEST: usize = 1 << 20;
/// at least, so that its beginning, where nothing can be copied yet, does not count,
const SHORTEST: usize = 1 << 14;
/// slices for each thread where the string allows,
const SLICES: usize = 4;
/// and modules for each open block of a slice, whose walk remembers them.
const FOR_EACH_OPEN: usize = 256;

/// A slice to write, with its walk.
type Slice<'s, 'g, S, B> = (Walk<'g>, Output<'s, S, B>);

impl Blocks {
    /// Writes the string. `None`: cancelled, or the memory is not there.
    pub(crate) fn string(&self, cancel: &AtomicBool) -> Option<ModuleString> {
        let newest = u32::try_from(self.steps()).unwrap_or(u32::MAX);
        match (bytes_up_to(self.most_symbol), bytes_up_to(newest)) {
            (1, 1) => self.written::<u8, u8>(LONGEST, cancel),
            (1, 2) => self.written::<u8, u16>(LONGEST, cancel),
            (1, _) => self.written::<u8, u32>(LONGEST, cancel),
            (_, 1) => self.written::<u16, u8>(LONGEST, cancel),
            (_, 2) => self.written::<u16, u16>(LONGEST, cancel),
            (_, _) => self.written::<u16, u32>(LONGEST, cancel),
        }
    }

    fn written<S: Narrow, B: Cell>(
        &self,
        longest: usize,
        cancel: &AtomicBool,
    ) -> Option<ModuleString> {
        let root = self.blocks.first()?;
        let modules = usize::try_from(root.size.modules).ok()?;
        let parameters = usize::try_from(root.size.parameters).ok()?;
        let mut symbols = Cells::<S>::unwritten(modules)?;
        let mut births = Cells::<B>::unwritten(modules)?;
        let mut values = Cells::<f64>::unwritten(parameters)?;
        let out = Output {
            symbols: &mut symbols,
            births: &mut births,
            parameters: &mut values,
        };
        let slices = self.slices(out, longest)?;
        let write = |(walk, out)| {
            Slices {
                graph: self,
                cancel,
            }
            .write(walk, out)
        };
        let whole = if pays_in_parallel(modules) && slices.len() > 1 {
            slices.into_par_iter().with_max_len(1).map(write).collect()
        } else {
            slices.into_iter().map(write).collect::<Option<()>>()
        };
        let string = ModuleString {
            symbols: S::column(symbols),
            births: B::column(births),
            parameters: values,
            arity: Arc::clone(&self.arity),
        };
        if whole.is_none() {
            // To give back gigabytes takes the system longer than a person who cancels should wait.
            rayon::spawn(move || drop(string));
            return None;
        }
        Some(string)
    }

    /// Cuts the string into slices, and finds where in the graph each begins.
    fn slices<'s, S, B>(
        &self,
        mut out: Output<'s, S, B>,
        longest: usize,
    ) -> Option<Vec<Slice<'s, '_, S, B>>> {
        let modules = out.symbols.len();
        let threads = rayon::current_num_threads();
        let shared = if threads > 1 {
            modules.div_ceil(SLICES * threads)
        } else {
            modules
        };
        let mut walk = Walk::new(self);
        let mut slices = Vec::new();
        while !out.symbols.is_empty() {
            let deep = walk.depth().max(self.steps()).saturating_mul(FOR_EACH_OPEN);
            let length = shared.clamp(SHORTEST.min(longest), longest).max(deep);
            let length = length.min(out.symbols.len());
            let start = walk.clone();
            let parameters = usize::try_from(walk.skip_modules(length as u128)).ok()?;
            slices.push((start, out.take(length, parameters)));
        }
        Some(slices)
    }
}

/// Modules and parameters before a place in a slice.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    module: usize,
    parameter: usize,
}

/// A graph whose string is written in slices.
struct Slices<'g> {
    graph: &'g Blocks,
    cancel: &'g AtomicBool,
}

impl Slices<'_> {
    /// Writes one. `None`: cancelled.
    fn write<S: Narrow, B: Cell>(&self, mut walk: Walk<'_>, out: Output<'_, S, B>) -> Option<()> {
        if self.cancel.load(Ordering::Relaxed) {
            return None;
        }
        // Where each block was first written in this slice.
        let mut written: Vec<Option<Place>> = vec![None; self.graph.blocks.len()];
        // Blocks that began in this slice and have not ended.
        let mut begun: Vec<(usize, Place)> = Vec::new();
        let mut at = Place::default();
        let mut since_check = 0;
        while at.module < out.symbols.len() {
            match walk.meet()? {
                Met::Module(module) => {
                    *out.symbols.get_mut(at.module)? = S::of(u32::from(module.symbol));
                    *out.births.get_mut(at.module)? = B::of(module.birth);
                    at.module += 1;
                    if !module.parameters.is_empty() {
                        let end = at.parameter + module.parameters.len();
                        let target = out.parameters.get_mut(at.parameter..end)?;
                        target.copy_from_slice(module.parameters);
                        at.parameter = end;
                    }
                }
                Met::Block(index, birth) => {
                    let block = self.graph.blocks.get(index)?;
                    let left = out.symbols.len() - at.module;
                    let source = written.get(index).copied().flatten();
                    if let Some(source) = source.filter(|_| block.size.modules <= left as u128) {
                        let modules = usize::try_from(block.size.modules).ok()?;
                        let parameters = usize::try_from(block.size.parameters).ok()?;
                        repeat(out.symbols, source.module, at.module, modules)?;
                        repeat(out.births, source.module, at.module, modules)?;
                        repeat(out.parameters, source.parameter, at.parameter, parameters)?;
                        let heir = block.heir.and_then(|heir| usize::try_from(heir).ok());
                        if let Some(own) = heir.and_then(|h| out.births.get_mut(at.module + h)) {
                            *own = B::of(birth);
                        }
                        at.module += modules;
                        at.parameter += parameters;
                    } else {
                        walk.enter(index, birth);
                        begun.push((index, at));
                    }
                }
                Met::End => {
                    if let Some((index, start)) = begun.pop() {
                        *written.get_mut(index)? = Some(start);
                    }
                }
            }
            since_check += 1;
            if since_check >= BETWEEN_CHECKS {
                since_check = 0;
                if self.cancel.load(Ordering::Relaxed) {
                    return None;
                }
            }
        }
        Some(())
    }
}

/// Copies `length` values from one place to another further on.
fn repeat<T: Copy>(values: &mut [T], from: usize, to: usize, length: usize) -> Option<()> {
    let end = to.checked_add(length)?;
    let (before, target) = values.get_mut(..end)?.split_at_mut_checked(to)?;
    let source = before.get(from..from.checked_add(length)?)?;
    target.copy_from_slice(source);
    Some(())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::lsystem::derive::Limits;
    use crate::lsystem::grammar::Grammar;

    #[test]
    fn slices_of_any_length_make_the_walked_string() {
        let honda = include_str!("../../../assets/grammars/honda.lsys");
        for (text, steps) in [
            ("axiom b\na -> ab\nb -> a\n", 12),
            ("axiom A\nA -> AB\nB -> *\n", 9),
            ("axiom A\nA -> BAA\nB -> B\n", 6),
            ("axiom A F(1) A\nA -> F(2)[A]F(3,4)\nF(x) -> F(x+1)A\n", 5),
            ("axiom A\nA -> *\n", 3),
            ("axiom A\nA -> AB\n", 300),
            (honda, 6),
        ] {
            let grammar = Grammar::parse(text, "test").unwrap();
            let never = AtomicBool::new(false);
            let limits = Limits::default();
            let graph = Blocks::new(&grammar, steps, &limits, &never, |_, _| false);
            let graph = graph.ok().unwrap();
            let mut walked = ModuleString::up_to(u32::from(u16::MAX), steps, &grammar.arity);
            graph.walk().for_each(|module| walked.push(&module));
            for longest in [1, 2, 7, 100, LONGEST] {
                let string = graph.written::<u8, u16>(longest, &never).unwrap();
                assert_eq!(string, walked, "{text} {longest}");
            }
            assert!(
                walked.is_empty()
                    || graph
                        .written::<u8, u16>(7, &AtomicBool::new(true))
                        .is_none()
            );
        }
    }
}
