//! The turtle's way through a string, kept for the string of the next step: what was read before is not read again.
//!
//! How the turtle stands behind a module depends on how it stood before it and on the module alone. So its states are a tree: from each go those modules on
//! which it was ever led from there, each with the state behind it. Going over a string is a walk in that tree, a comparison of a few numbers a module; only
//! where it leaves the tree are modules interpreted and read, and the tree grows. A plant changes at its ends and where branches
//! appear; all the rest is found.
//!
//! This is for interpretations of modules one by one, without contexts, draws or `%`, and without outlines, whose vertices are no part of a pen. Where most of a
//! string is new after each step the tree is given up. What is found is what reading finds, bit for bit.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::super::choice::Worker;
use super::super::column::{Cell, for_width};
use super::super::context::{Base, Modules};
use super::super::derive::interpretation;
use super::super::grammar::{Grammar, Plan, Role, Rule, RuleSet};
use super::super::names::Symbol;
use super::super::rewrite::Round;
use super::super::string::{Module, ModuleString, arity_of};
use super::TurtleParams;
use super::action::{Action, actions};
use super::canvas::{Canvas, Drawn};
use super::pen::Pen;
use super::walk::Turtle;

/// Longer strings are read by several threads, which is as fast.
const LONG: usize = 1 << 18;
/// States for each that a string needs, beyond which most of them are of the past.
const WASTE: usize = 2;
/// So many states are no waste.
const FEW: usize = 1 << 12;
/// Ways from one state, which are looked at one after the other: where there are more, some thing has hundreds of branches.
const MOST_WAYS: u32 = 256;
/// An interpretation of more rounds is not followed.
const DEEP: u32 = 64;
/// Modules between two looks at the cancel flag.
const CHECK_EVERY: usize = 1 << 14;
/// No state.
const NONE: u32 = u32::MAX;
/// The turtle's start.
const START: u32 = 0;

/// A canvas that keeps what it was shown, so that it need not be shown again.
pub(in crate::lsystem) trait Again: Canvas {
    /// How much it has been shown.
    fn drawn(&self) -> u32;
    /// That part of it is there in this string, too; false where it cannot be.
    fn again(&mut self, drawn: Range<u32>) -> bool;
}

/// What a symbol is to the walk.
#[derive(Clone, Copy, PartialEq)]
enum Step {
    /// It changes nothing.
    Nothing,
    Open,
    Close,
    Query,
    /// It leads to another state.
    On,
}

/// How the turtle may stand.
struct State {
    /// The module that leads to it, by its symbol and where its parameters begin.
    symbol: Symbol,
    parameters: u32,
    /// The first state to which a module leads from here,
    first: u32,
    /// and the one to which another module leads from where this one's does.
    other: u32,
    /// What of the canvas the module drew.
    drawn: Range<u32>,
}

/// All ways that were gone.
pub(in crate::lsystem) struct Known {
    /// By symbol.
    steps: Vec<Step>,
    actions: Vec<Action>,
    states: Vec<State>,
    /// Of each state.
    pens: Vec<Pen>,
    parameters: Vec<f64>,
}

/// The way through a string.
#[derive(Default)]
pub(in crate::lsystem) enum Trail {
    /// None has been gone yet.
    Fresh,
    Kept(Box<Known>),
    /// It is not worth keeping one.
    #[default]
    Lost,
}

impl Trail {
    /// Goes over a string, whose grammar is the same each time, on a canvas that has what it was shown before. `None` where the string is to be read from
    /// the beginning, with a canvas that knows nothing: there may be a fault in it, which that finds.
    pub(in crate::lsystem) fn follow<C: Again>(
        &mut self,
        grammar: &Grammar,
        string: &ModuleString,
        params: &TurtleParams,
        cancel: &AtomicBool,
        canvas: C,
    ) -> Option<C> {
        let mut known = match std::mem::replace(self, Self::Lost) {
            Self::Kept(known) => known,
            Self::Fresh => Box::new(Known::new(grammar, params)?),
            Self::Lost => return None,
        };
        if string.len() > LONG {
            return None;
        }
        let (canvas, needed) = known.walk(grammar, string, params, cancel, canvas)?;
        if known.states.len() <= FEW.max(WASTE * needed) {
            *self = Self::Kept(known);
        }
        Some(canvas)
    }
}

impl Known {
    /// Nothing but the start; none where modules cannot be read one by one.
    fn new(grammar: &Grammar, params: &TurtleParams) -> Option<Self> {
        let is_alone = |rules: &RuleSet| !rules.has_context && !rules.draws();
        let actions = actions(grammar, params);
        let is_outline = |action: &Action| {
            matches!(
                action,
                Action::BeginPolygon | Action::Vertex | Action::EndPolygon
            )
        };
        if !grammar.interpret.as_ref().is_none_or(is_alone)
            || grammar.interpret_depth > DEEP
            || grammar.roles.contains(&Role::Cut)
            || actions.iter().any(is_outline)
        {
            return None;
        }
        let plan = |symbol: Symbol| {
            let rules = grammar.interpret.as_ref();
            rules.map_or(Plan::Stay, |rules| rules.plan(symbol))
        };
        let step = |(symbol, action): (Symbol, &Action)| {
            let alone = plan(symbol) == Plan::Stay;
            match action {
                Action::Nothing if alone => Some(Step::Nothing),
                Action::Push | Action::Pop | Action::Query if !alone => None,
                Action::Push => Some(Step::Open),
                Action::Pop => Some(Step::Close),
                Action::Query => Some(Step::Query),
                _ => Some(Step::On),
            }
        };
        let steps: Option<Vec<Step>> = (0..).zip(&actions).map(step).collect();
        let start = State {
            symbol: 0,
            parameters: 0,
            first: NONE,
            other: NONE,
            drawn: 0..0,
        };
        Some(Self {
            steps: steps?,
            actions,
            states: vec![start],
            pens: vec![Pen::new(params.width)],
            parameters: Vec::new(),
        })
    }

    /// The canvas when all is gone over, and how many states that needed.
    fn walk<C: Again>(
        &mut self,
        grammar: &Grammar,
        string: &ModuleString,
        params: &TurtleParams,
        cancel: &AtomicBool,
        canvas: C,
    ) -> Option<(C, usize)> {
        let round = interpretation(grammar, 0, &params.limits, cancel);
        let mut reader = Reader {
            turtle: Turtle::within(grammar, params, self.actions.clone(), canvas),
            grammar,
            round: round.as_ref(),
            work: round.as_ref().map(|round| Worker::new(round, &Alone)),
            left: LONG,
        };
        let needed = for_width!(&string.symbols, symbols =>
            self.pass(symbols, string, &mut reader, cancel)?);
        Some((reader.turtle.finish().ok()?, needed))
    }

    /// Passes through all modules; how many states that needed.
    fn pass<S: Cell, C: Again>(
        &mut self,
        symbols: &[S],
        string: &ModuleString,
        reader: &mut Reader<'_, C>,
        cancel: &AtomicBool,
    ) -> Option<usize> {
        let mut open: Vec<u32> = Vec::new();
        let (mut at, mut needed) = (START, 0);
        let mut rest = string.parameters();
        for (number, symbol) in symbols.iter().enumerate() {
            if number % CHECK_EVERY == 0 && cancel.load(Ordering::Relaxed) {
                return None;
            }
            let own;
            (own, rest) = rest.split_at_checked(arity_of(&string.arity, symbol.index()))?;
            let step = *self.steps.get(symbol.index())?;
            let symbol = Symbol::try_from(symbol.index()).ok()?;
            match step {
                Step::Nothing => {}
                Step::Close => at = open.pop().unwrap_or(at),
                Step::Query => {
                    let pen = self.pens.get(at as usize)?;
                    let canvas = reader.turtle.canvas_mut();
                    canvas.query(pen, drawn(symbol)).ok()?;
                }
                Step::Open | Step::On => {
                    let depth = open.len();
                    if step == Step::Open {
                        open.push(at);
                    }
                    at = self.behind(at, module(symbol, own), depth, reader)?;
                    needed += 1;
                }
            }
        }
        Some(needed)
    }

    /// The state behind a module that stands in so many brackets.
    fn behind<C: Again>(
        &mut self,
        at: u32,
        module: Module<'_>,
        depth: usize,
        reader: &mut Reader<'_, C>,
    ) -> Option<u32> {
        let (mut state, mut last) = (self.states.get(at as usize)?.first, NONE);
        let mut others = 0;
        while let Some(known) = self.states.get(state as usize) {
            if known.symbol == module.symbol && self.has(known, module.parameters) {
                let drawn = known.drawn.clone();
                let again = drawn.is_empty() || reader.turtle.canvas_mut().again(drawn);
                return again.then_some(state);
            }
            (last, state) = (state, known.other);
            others += 1;
        }
        if others > MOST_WAYS {
            return None;
        }
        let pen = *self.pens.get(at as usize)?;
        let before = reader.turtle.canvas_mut().drawn();
        let is_open = self.steps.get(usize::from(module.symbol)) == Some(&Step::Open);
        let pen = reader.behind(pen, module, depth, is_open)?;
        let new = State {
            symbol: module.symbol,
            parameters: u32::try_from(self.parameters.len()).ok()?,
            first: NONE,
            other: NONE,
            drawn: before..reader.turtle.canvas_mut().drawn(),
        };
        let number = u32::try_from(self.states.len()).ok()?;
        // In the string's order, in which they are sought.
        match last {
            NONE => self.states.get_mut(at as usize)?.first = number,
            last => self.states.get_mut(last as usize)?.other = number,
        }
        self.states.push(new);
        self.pens.push(pen);
        self.parameters.extend_from_slice(module.parameters);
        Some(number)
    }

    /// Whether the module that leads to a state has these parameters, to the sign of a zero.
    fn has(&self, state: &State, parameters: &[f64]) -> bool {
        let own = self.parameters.get(state.parameters as usize..);
        let own = own.unwrap_or(&[]).iter().map(|value| value.to_bits());
        let given = parameters.iter().map(|value| value.to_bits());
        own.zip(given).fold(true, |all, (a, b)| all & (a == b))
    }
}

/// A module, where it does not matter when it was born.
fn module(symbol: Symbol, parameters: &[f64]) -> Module<'_> {
    Module {
        symbol,
        birth: 0,
        parameters,
    }
}

/// What draws, where that does not matter, nor where it stands.
fn drawn(symbol: Symbol) -> Drawn {
    Drawn {
        symbol,
        birth: 0,
        position: 0,
    }
}

/// Reads single modules.
struct Reader<'w, C> {
    turtle: Turtle<'w, C>,
    grammar: &'w Grammar,
    /// Where modules are interpreted.
    round: Option<&'w Round<'w>>,
    work: Option<Worker<'w, 'w, Alone>>,
    /// Modules that it may yet read: an interpretation may never end.
    left: usize,
}

impl<'w, C: Again> Reader<'w, C> {
    /// The pen behind a module, which stands in so many brackets; none where something is wrong.
    fn behind(&mut self, pen: Pen, module: Module<'_>, depth: usize, is_open: bool) -> Option<Pen> {
        self.turtle.go_to(pen, depth);
        if is_open {
            return self.turtle.inside().ok().map(|(pen, _)| pen);
        }
        self.read(module, self.grammar.interpret_depth)?;
        self.turtle.is_level().then(|| *self.turtle.pen())
    }

    /// Reads what a module is interpreted as in so many rounds.
    fn read(&mut self, module: Module<'_>, rounds: u32) -> Option<()> {
        let Some((rule, written)) = self.interpreted(module, rounds)? else {
            return self.turtle.step(module).ok();
        };
        let mut rest = written.as_slice();
        for symbol in &rule.successor {
            self.left = self.left.checked_sub(1)?;
            let (parameters, after) =
                rest.split_at_checked(arity_of(&self.grammar.arity, *symbol))?;
            rest = after;
            self.read(self::module(*symbol, parameters), rounds - 1)?;
        }
        Some(())
    }

    /// The production of a module and the parameters that it gives; an inner none where there is none.
    fn interpreted(
        &mut self,
        module: Module<'_>,
        rounds: u32,
    ) -> Option<Option<(&'w Rule, Vec<f64>)>> {
        let (Some(work), Some(round), 1..) = (&mut self.work, self.round, rounds) else {
            return Some(None);
        };
        let choice = work.choose(module.symbol, 0, 0, module.parameters).ok()?;
        let Some(rule) = round.rule(choice) else {
            return Some(None);
        };
        let mut written = vec![0.0; rule.arguments.len()];
        let own = module.parameters;
        work.evaluate(rule, 0, 0, own, &mut written).ok()?;
        Some(Some((rule, written)))
    }
}

/// A module without neighbours.
struct Alone;

impl Modules for Alone {
    fn symbol(&self, _: usize) -> Option<Symbol> {
        None
    }

    fn left(&self, _: usize) -> Option<usize> {
        None
    }

    fn right(&self, _: usize) -> Option<usize> {
        None
    }

    fn partner(&self, at: usize) -> usize {
        at
    }

    fn parameters(&self, _: usize, _: Symbol, _: Base) -> &[f64] {
        &[]
    }
}
