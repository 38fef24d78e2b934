//! Derivation of context-free deterministic systems by blocks: what a module becomes in a number of steps is worked out once
//! and copied wherever the same module stands at the same step.
//!
//! Such a module develops alone. So the derivation is a graph, and a small one: for each step the distinct modules that
//! it rewrites, each with its successor, whose modules stay as they are or are rewritten by the next step. Honda's
//! tree of 1.8 million modules has some 1,200 blocks. The sizes of the strings, their growth function, follow from the
//! graph alone (Prusinkiewicz and Lindenmayer 1990, §1.8), and so do all counts (`count`). The modules can be walked through
//! without being written down (`walk`); the string is written in slices, by a walk each, where a block that was written before is copied
//! from there (`write`).
//!
//! One module of a successor may be the same as the one it replaces ([`Round::heir`]) and keeps its birth; so each block knows where
//! the module that it stands for ends up.

mod count;
mod walk;
mod write;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::choice::Worker;
use super::column::bytes_up_to;
use super::context::Alone;
use super::derive::{Limits, productions};
use super::error::DeriveError;
use super::grammar::{Grammar, Role};
use super::names::Symbol;
use super::rewrite::{Round, STAYS};
use super::string::ModuleString;
use walk::Walk;

/// Where a step rewrites more distinct modules than this,
const MANY: usize = 1 << 12;
/// there must be so many times as many modules: else nearly each is a stranger, and the rounds are quicker.
const SHARED: u128 = 8;
/// The graph may take so much of what the strings may.
const SHARE_OF_BYTES: u64 = 4;
/// Modules worked on between two looks at the cancel flag.
const BETWEEN_CHECKS: usize = 1 << 10;

/// What a module has become at the end.
#[derive(Clone, Debug)]
struct Block {
    /// Its successor, a range of the pieces.
    pieces: Range<usize>,
    /// The step in which its successor is born.
    step: u32,
    /// Modules and parameters at the end.
    size: Size,
    /// The piece that is the module itself and keeps its birth,
    same: Option<usize>,
    /// and where the module ends up.
    heir: Option<u128>,
}

/// A module of a successor.
#[derive(Clone, Copy, Debug)]
enum Piece {
    /// It stays: its symbol and the first of its parameters.
    Module(Symbol, usize),
    /// It is rewritten by the next step.
    Block(usize),
}

/// Modules and parameters of a string or of a part of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) modules: u128,
    pub(crate) parameters: u128,
}

impl Size {
    pub(crate) fn of(string: &ModuleString) -> Self {
        Self {
            modules: string.len() as u128,
            parameters: string.parameters.len() as u128,
        }
    }

    fn add(&mut self, times: u128, modules: u128, parameters: u128) {
        let more = |sum: u128, one: u128| sum.saturating_add(times.saturating_mul(one));
        self.modules = more(self.modules, modules);
        self.parameters = more(self.parameters, parameters);
    }
}

/// A derivation as a graph. The first block is the axiom.
#[derive(Debug)]
pub(crate) struct Blocks {
    blocks: Vec<Block>,
    pieces: Vec<Piece>,
    /// Of the modules that stay.
    parameters: Vec<f64>,
    arity: Arc<[u8]>,
    /// No symbol is larger.
    most_symbol: u32,
    /// Of each step's string, the axiom's first. Where it ends early, the string stays as it is.
    sizes: Vec<Size>,
    /// Pieces up to there.
    made: Vec<usize>,
}

/// The grammar is not one of those, its modules are too different, or a step cannot be made: the rounds say why.
pub(crate) struct Unfit;

impl From<DeriveError> for Unfit {
    fn from(_: DeriveError) -> Self {
        Self
    }
}

/// A module that the next step rewrites.
struct Growing {
    parameters: Vec<f64>,
    /// The production.
    choice: u16,
    /// How often the module stands in the string.
    times: u128,
    block: usize,
}

/// A module by its bits.
type Key = (Symbol, Vec<u64>);

impl Blocks {
    /// The graph of a derivation from the axiom, which ends at the first step whose string is too large.
    pub(crate) fn new(
        grammar: &Grammar,
        steps: u32,
        limits: &Limits,
        cancel: &AtomicBool,
        too_large: impl Fn(u32, Size) -> bool,
    ) -> Result<Self, Unfit> {
        // Answers to queries depend on all of the string before them.
        let alone =
            !grammar.rules.has_context && grammar.decompose.is_none() && !grammar.has_queries;
        if !alone || grammar.rules.draws() || grammar.roles.contains(&Role::Cut) {
            return Err(Unfit);
        }
        let mut making = Making {
            round: productions(grammar, 1, limits, cancel),
            steps,
            graph: Self {
                blocks: Vec::new(),
                pieces: Vec::new(),
                parameters: Vec::new(),
                arity: Arc::clone(&grammar.arity),
                most_symbol: grammar.axiom.symbols.most(),
                sizes: Vec::new(),
                made: Vec::new(),
            },
            found: HashMap::new(),
            next: Vec::new(),
            staying: Size::default(),
            added: 0,
        };
        let mut growing = making.axiom(&grammar.axiom)?;
        for step in 1..=steps {
            // Nothing is asked for beyond it.
            if growing.is_empty() || too_large(step - 1, making.graph.size(step - 1)) {
                break;
            }
            growing = making.step(step, &growing)?;
        }
        let mut graph = making.graph;
        graph.measure();
        Ok(graph)
    }

    /// A walk through the modules.
    pub(crate) fn walk(&self) -> Walk<'_> {
        Walk::new(self)
    }

    /// Steps after which the string stays as it is, at most those asked for.
    pub(crate) fn steps(&self) -> usize {
        self.sizes.len().saturating_sub(1)
    }

    /// The size of the string after a step.
    pub(crate) fn size(&self, step: u32) -> Size {
        let at = usize::try_from(step).ok().and_then(|s| self.sizes.get(s));
        at.or(self.sizes.last()).copied().unwrap_or_default()
    }

    /// Pieces of the graph of so many steps.
    pub(crate) fn pieces_at(&self, step: u32) -> usize {
        let at = usize::try_from(step).ok().and_then(|s| self.made.get(s));
        at.or(self.made.last()).copied().unwrap_or_default()
    }

    /// Bytes of the string.
    pub(crate) fn string_bytes(&self) -> u128 {
        let newest = u32::try_from(self.steps()).unwrap_or(u32::MAX);
        let module = bytes_up_to(self.most_symbol) + bytes_up_to(newest);
        let Size {
            modules,
            parameters,
        } = self.size(u32::MAX);
        modules
            .saturating_mul(u128::from(module))
            .saturating_add(parameters.saturating_mul(size_of::<f64>() as u128))
    }

    fn bytes(&self) -> u64 {
        let blocks = self.blocks.len() * size_of::<Block>();
        let pieces = self.pieces.len() * size_of::<Piece>();
        (blocks + pieces + self.parameters.len() * size_of::<f64>()) as u64
    }

    /// Adds up the blocks, those of the last step first.
    fn measure(&mut self) {
        for index in (0..self.blocks.len()).rev() {
            let Some(block) = self.blocks.get(index) else {
                continue;
            };
            let mut size = Size::default();
            let mut heir = None;
            for (number, piece) in self.pieces_of(block).iter().enumerate() {
                let (own, own_heir) = match *piece {
                    Piece::Module(symbol, _) => {
                        let mut one = Size::default();
                        one.add(1, 1, self.arity(symbol) as u128);
                        (one, Some(0))
                    }
                    Piece::Block(inner) => self
                        .blocks
                        .get(inner)
                        .map_or((Size::default(), None), |b| (b.size, b.heir)),
                };
                if block.same == Some(number) {
                    heir = own_heir.map(|at| size.modules.saturating_add(at));
                }
                size.add(1, own.modules, own.parameters);
            }
            if let Some(block) = self.blocks.get_mut(index) {
                (block.size, block.heir) = (size, heir);
            }
        }
    }

    fn arity(&self, symbol: Symbol) -> usize {
        self.arity
            .get(usize::from(symbol))
            .map_or(0, |a| usize::from(*a))
    }

    fn pieces_of(&self, block: &Block) -> &[Piece] {
        self.pieces.get(block.pieces.clone()).unwrap_or(&[])
    }
}

/// A graph while it is made, one step's blocks after the other.
struct Making<'a> {
    round: Round<'a>,
    steps: u32,
    graph: Blocks,
    /// Where the modules of `next` stand in it.
    found: HashMap<Key, usize>,
    /// What the next step rewrites.
    next: Vec<Growing>,
    /// What no step rewrites.
    staying: Size,
    /// Modules so far.
    added: usize,
}

impl Making<'_> {
    fn axiom(&mut self, axiom: &ModuleString) -> Result<Vec<Growing>, Unfit> {
        let round = self.round.clone();
        let mut work = Worker::new(&round, &Alone);
        self.graph.blocks.push(Block {
            pieces: 0..axiom.len(),
            step: 0,
            size: Size::default(),
            same: None,
            heir: None,
        });
        for module in axiom.iter() {
            self.add(&mut work, module.symbol, module.parameters, 0, 1)?;
        }
        Ok(self.turn())
    }

    /// Works out the successors of what a step rewrites.
    fn step(&mut self, step: u32, growing: &[Growing]) -> Result<Vec<Growing>, Unfit> {
        self.round.step = step;
        let round = self.round.clone();
        let mut work = Worker::new(&round, &Alone);
        let mut written = Vec::new();
        for one in growing {
            let rule = round.rule(one.choice).ok_or(Unfit)?;
            written.clear();
            written.resize(rule.arguments.len(), 0.0);
            work.evaluate(rule, 0, 0, &one.parameters, &mut written)?;
            let first = self.graph.pieces.len();
            let mut rest = written.as_slice();
            for symbol in &rule.successor {
                let arity = self.graph.arity(*symbol).min(rest.len());
                let (own, after) = rest.split_at(arity);
                self.add(&mut work, *symbol, own, step, one.times)?;
                rest = after;
            }
            let pieces = first..self.graph.pieces.len();
            if let Some(block) = self.graph.blocks.get_mut(one.block) {
                block.pieces = pieces;
                block.step = step;
                block.same = Round::heir(rule, &one.parameters, &written);
            }
        }
        let next = self.turn();
        let modules = self.graph.size(step).modules;
        if next.len() > MANY && (next.len() as u128).saturating_mul(SHARED) > modules {
            return Err(Unfit);
        }
        Ok(next)
    }

    /// Adds a module of the string of a step, which stands in it so many times.
    fn add(
        &mut self,
        work: &mut Worker<'_, '_, Alone>,
        symbol: Symbol,
        parameters: &[f64],
        step: u32,
        times: u128,
    ) -> Result<(), Unfit> {
        self.added += 1;
        let stops = || {
            self.round.cancel.load(Ordering::Relaxed)
                || self.graph.bytes() > self.round.limits.bytes / SHARE_OF_BYTES
        };
        if self.added.is_multiple_of(BETWEEN_CHECKS) && stops() {
            return Err(Unfit);
        }
        // The last string is only read: its productions are not looked for.
        let choice = if step < self.steps {
            work.choose(symbol, 0, 0, parameters)?
        } else {
            STAYS
        };
        if choice == STAYS {
            self.staying.add(times, 1, parameters.len() as u128);
            let from = self.graph.parameters.len();
            self.graph.parameters.extend_from_slice(parameters);
            self.graph.pieces.push(Piece::Module(symbol, from));
            return Ok(());
        }
        let bits = parameters.iter().map(|value| value.to_bits()).collect();
        let new = self.next.len();
        let place = *self.found.entry((symbol, bits)).or_insert(new);
        if place == new {
            self.next.push(Growing {
                parameters: parameters.to_vec(),
                choice,
                times: 0,
                block: self.graph.blocks.len(),
            });
            self.graph.blocks.push(Block {
                pieces: 0..0,
                step: 0,
                size: Size::default(),
                same: None,
                heir: None,
            });
        }
        let same = self.next.get_mut(place).ok_or(Unfit)?;
        same.times = same.times.saturating_add(times);
        self.graph.pieces.push(Piece::Block(same.block));
        Ok(())
    }

    /// Ends a step: what the next one rewrites.
    fn turn(&mut self) -> Vec<Growing> {
        self.found.clear();
        let mut size = self.staying;
        for one in &self.next {
            size.add(one.times, 1, one.parameters.len() as u128);
        }
        self.graph.sizes.push(size);
        self.graph.made.push(self.graph.pieces.len());
        std::mem::take(&mut self.next)
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::lsystem::derive::past;

    fn graph(text: &str, steps: u32, limits: &Limits) -> Option<Blocks> {
        let grammar = Grammar::parse(text, "test").unwrap();
        let never = AtomicBool::new(false);
        let too_large = |step, size| past(&grammar, size, step, limits).is_some();
        Blocks::new(&grammar, steps, limits, &never, too_large).ok()
    }

    #[test]
    fn the_growth_function_needs_no_string() {
        let algae = graph("axiom b\na -> ab\nb -> a\n", 40, &Limits::default()).unwrap();
        let (mut last, mut size) = (1, 1);
        for step in 0..=40 {
            assert_eq!(algae.size(step).modules, size, "step {step}");
            if step > 0 {
                (last, size) = (size, last + size);
            }
        }
        assert!(algae.blocks.len() <= 2 * 40 + 1);
    }

    #[test]
    fn a_tree_of_literature_has_few_blocks() {
        let honda = include_str!("../../assets/grammars/honda.lsys");
        let tree = graph(honda, 18, &Limits::default()).unwrap();
        assert_eq!(tree.size(18).modules, 1_835_002);
        assert!(tree.blocks.len() < 1500, "{}", tree.blocks.len());
    }

    #[test]
    fn what_it_is_not_for() {
        for text in [
            "axiom A\nA < B -> A\n",
            "axiom A\nA -> A%\n",
            "axiom A\nA : weight 1 -> A\n",
            "axiom A\nA -> A(uniform(0,1))\n",
            "axiom A\nA -> B\ndecompose {\nB -> A\n}\n",
            // Each is another.
            "axiom A(1)\nA(x) -> A(2*x) A(2*x+1)\n",
        ] {
            assert!(graph(text, 20, &Limits::default()).is_none(), "{text}");
        }
    }

    #[test]
    fn the_graph_is_bounded_too() {
        let eight = "A(2*x)".repeat(8) + &"A(2*x+1)".repeat(8);
        let text = format!("axiom A(1)\nA(x) -> {eight}\n");
        let limits = Limits {
            modules: u64::MAX,
            bytes: 1 << 20,
        };
        // It ends at the first string that is too large, or where the graph itself is.
        let made = graph(&text, 1000, &limits);
        assert!(made.is_none_or(|graph| graph.steps() < 10));
    }
}
