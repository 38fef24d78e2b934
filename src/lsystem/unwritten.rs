//! A derived string that is not written down: its graph of blocks, which counts it, walks through it and prints it at the
//! cost of what differs in it, not of its length.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

use super::blocks::Blocks;
use super::derive::Limits;
use super::error::{DeriveError, DeriveProblem};
use super::grammar::Grammar;
use super::report::Counts;
use super::string::{Module, write_modules};

/// The string of a grammar whose modules each develop alone and without chance, after a number of steps.
///
/// ```
/// use std::sync::atomic::AtomicBool;
/// use ramus::lsystem::{Grammar, Limits};
///
/// let algae = Grammar::parse("axiom b\na -> ab\nb -> a\n", "algae").unwrap();
/// let string = algae.unwritten(58, &Limits::default(), &AtomicBool::new(false)).unwrap().unwrap();
/// assert_eq!(string.modules(), 956_722_026_041); // the 59th number of Fibonacci
/// assert!(string.growth().take(6).eq([1, 1, 2, 3, 5, 8]));
/// let module = string.iter_from(600_000_000_000).next().unwrap();
/// assert_eq!((algae.name(module.symbol), module.birth), ("a", 55));
/// ```
#[derive(Debug)]
pub struct Unwritten {
    graph: Blocks,
    steps: u32,
}

impl Unwritten {
    /// `None`: the grammar is not one of those, or its modules differ too much; such a string has to be derived.
    pub(super) fn new(
        grammar: &Grammar,
        steps: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Option<Self>, DeriveError> {
        let graph = Blocks::new(grammar, steps, limits, cancel, |_, size| {
            size.modules == u128::MAX
        });
        let Ok(graph) = graph else {
            return match cancel.load(Ordering::Relaxed) {
                true => Err(DeriveProblem::Cancelled { step: 1 }.into()),
                false => Ok(None),
            };
        };
        let countless = (0..=steps)
            .take(graph.steps() + 1)
            .find(|step| graph.size(*step).modules == u128::MAX);
        match countless {
            Some(step) => Err(DeriveProblem::Countless { step }.into()),
            None => Ok(Some(Self { graph, steps })),
        }
    }

    /// Modules of the string.
    #[must_use]
    pub fn modules(&self) -> u128 {
        self.graph.size(self.steps).modules
    }

    /// Modules after each step, the axiom's first.
    pub fn growth(&self) -> impl Iterator<Item = u128> + '_ {
        (0..=self.steps).map(|step| self.graph.size(step).modules)
    }

    /// Bytes that the string would take.
    #[must_use]
    pub fn bytes(&self) -> u128 {
        self.graph.string_bytes()
    }

    /// What the string holds. `grammar` is the one that it is of.
    #[must_use]
    pub fn counts(&self, grammar: &Grammar) -> Counts {
        self.graph.counts(grammar, self.steps)
    }

    /// The modules in order, at the memory of a stack as deep as there are steps.
    pub fn iter(&self) -> impl Iterator<Item = Module<'_>> + Clone + Send {
        self.graph.walk()
    }

    /// The modules from a position on; to find it takes no longer than the derivation has steps.
    pub fn iter_from(&self, position: u128) -> impl Iterator<Item = Module<'_>> + Clone + Send {
        let mut walk = self.graph.walk();
        walk.skip_modules(position);
        walk
    }

    /// Writes the text, as `ramus derive --print string` prints it.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_text(&self, grammar: &Grammar, out: &mut dyn io::Write) -> io::Result<()> {
        write_modules(self.iter(), grammar, out)
    }
}
