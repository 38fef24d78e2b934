//! Pictures between two steps: one step is derived with a record of it, and every picture in between is drawn from that.
//!
//! At the time n − 1 + age, with an age in 0…1, the string is that of step n, in which each rewritten module's successor is partly grown. With
//! f the growth curve of a module's name, at this age:
//!
//! ```text
//! the first module of the successor with the predecessor's name and number of parameters,
//!   outside of branches where there is one       its parameters go from the predecessor's to its own: a + f·(b − a)
//! no such module, but the predecessor draws      the first that draws goes from the predecessor's length to its own
//! every other module of the successor            f of its length, angle, width, radius or scale
//! what the step left as it was                   whole
//! ```
//!
//! So the picture at age 0 is that of the step before wherever new modules are next to nothing when they are of no size; the picture at age 1 is that
//! of step n bit for bit, since it is drawn from the string itself.

use std::sync::atomic::AtomicBool;

use super::column::Column;
use super::derive::{Limits, interpreted};
use super::error::{DeriveError, DeriveProblem, Limit};
use super::grammar::{Grammar, Role};
use super::names::Symbol;
use super::record::Recorded;
use super::string::{Module, ModuleString};
use super::turtle::{
    Canvas, Grown, TreeCanvas, Turtle, TurtleParams, draw_on, interpret, is_index, length_of,
};
use crate::tree::Tree;

/// What becomes of a module of the string after the step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    /// It was there before.
    Whole,
    /// It is new.
    New,
    /// Its parameters go from those of the string before that begin here.
    From(u32),
    /// Its length goes from this.
    Length(f64),
}

/// The growth of one step.
#[derive(Clone, Debug)]
pub struct Growing {
    step: u32,
    before: ModuleString,
    after: ModuleString,
    /// For each module of `after`.
    changes: Vec<Change>,
}

impl Growing {
    /// The growth of the step `step`, from 1, whose string before it is derived here; of step 0 there is none, so its picture is always whole.
    ///
    /// # Errors
    /// As [`Grammar::derive`].
    pub fn new(
        grammar: &Grammar,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Self, DeriveError> {
        let before = grammar.derive(step.saturating_sub(1), limits, cancel)?;
        if step == 0 {
            return Self::of(grammar, 0, before, None);
        }
        Self::after(grammar, before, step, limits, cancel)
    }

    /// The growth of the step `step` from the string before it.
    ///
    /// # Errors
    /// As [`Grammar::derive_next`].
    pub fn after(
        grammar: &Grammar,
        before: ModuleString,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Self, DeriveError> {
        match Self::recorded(grammar, &before, step, limits, cancel) {
            Ok(recorded) => Self::of(grammar, step, before, Some(recorded)),
            Err(mut error) => {
                error.last = Some(Box::new((step.saturating_sub(1), before)));
                Err(error)
            }
        }
    }

    /// The step's record, where the limits also hold what is made from it.
    fn recorded(
        grammar: &Grammar,
        before: &ModuleString,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Recorded, DeriveError> {
        let starts = Recorded::starts_bytes(before);
        let room = Limits {
            bytes: limits.bytes.saturating_sub(starts),
            ..*limits
        };
        let recorded = grammar.derive_recorded(before, step, &room, cancel);
        let recorded = recorded.map_err(|mut error| {
            // What the record takes is told with the rest, and the limit as it was given.
            if let DeriveProblem::Limit {
                bytes,
                limit: Limit::Bytes(limit),
                ..
            } = error.problem.as_mut()
            {
                *bytes = bytes.saturating_add(starts);
                *limit = limits.bytes;
            }
            error
        })?;
        let after = &recorded.string;
        let bytes = (recorded.bytes() + bytes_between(before, after)).saturating_add(after.bytes());
        if bytes > limits.bytes {
            let (modules, limit) = (after.len() as u64, Limit::Bytes(limits.bytes));
            return Err(DeriveProblem::Limit {
                step,
                modules,
                bytes,
                limit,
            }
            .into());
        }
        Ok(recorded)
    }

    fn of(
        grammar: &Grammar,
        step: u32,
        before: ModuleString,
        mut recorded: Option<Recorded>,
    ) -> Result<Self, DeriveError> {
        let after = match &mut recorded {
            Some(recorded) => std::mem::take(&mut recorded.string),
            None => before.clone(),
        };
        let mut changes = Vec::new();
        let bytes = (size_of::<Change>() * after.len()) as u64;
        changes
            .try_reserve_exact(after.len())
            .map_err(|_| DeriveProblem::Memory { step, bytes })?;
        changes.resize(after.len(), Change::Whole);
        let mut growing = Self {
            step,
            before,
            after,
            changes,
        };
        if let Some(recorded) = recorded {
            growing.find_changes(grammar, &recorded);
        }
        Ok(growing)
    }

    /// The step that grows.
    #[must_use]
    pub fn step(&self) -> u32 {
        self.step
    }

    /// The string of the step, which is that of every picture after the step before.
    #[must_use]
    pub fn string(&self) -> &ModuleString {
        &self.after
    }

    /// Bytes that both strings and the changes between them take, and a picture's own parameters.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        bytes_between(&self.before, &self.after) + self.after.bytes()
    }

    /// The string of the step before.
    #[must_use]
    pub fn before(&self) -> &ModuleString {
        &self.before
    }

    fn find_changes(&mut self, grammar: &Grammar, recorded: &Recorded) {
        let mut symbols: Vec<Symbol> = Vec::new();
        let mut offset = 0_u32;
        for (position, module) in self.before.iter().enumerate() {
            let range = recorded.successor(position);
            let (start, Some(changes)) = (range.start, self.changes.get_mut(range)) else {
                continue;
            };
            symbols.resize(changes.len(), 0);
            self.after.symbols.read(start, &mut symbols);
            if recorded.production(position).is_some() || symbols != [module.symbol] {
                change(grammar, module, offset, &symbols, changes);
            }
            offset += u32::try_from(module.parameters.len()).unwrap_or(0);
        }
    }

    /// Draws the picture at an age of 0 to 1 on the canvas that `make` makes, as [`draw_on`] does.
    ///
    /// # Errors
    /// As [`draw_on`].
    pub fn draw_on<C: Canvas>(
        &self,
        grammar: &Grammar,
        age: f64,
        params: &TurtleParams,
        cancel: &AtomicBool,
        make: impl FnOnce(&TurtleParams) -> C,
    ) -> Result<C, DeriveError> {
        if age >= 1.0 || self.changes.iter().all(|change| *change == Change::Whole) {
            return draw_on(grammar, &self.after, params, cancel, make);
        }
        let names = (0..)
            .take(grammar.arity.len())
            .map(|symbol| grammar.name(symbol));
        let curves = grammar.curves.at(age, names);
        let curve = |symbol: Symbol| curves.get(usize::from(symbol)).copied().unwrap_or(1.0);
        let mut grown = self.after.clone();
        self.grow_parameters(&mut grown, curve);
        let growth = |index: usize, symbol: Symbol| match self.changes.get(index) {
            Some(Change::New) => Grown::new(curve(symbol)),
            Some(Change::Length(from)) => Grown::from(*from, curve(symbol)),
            _ => Grown::WHOLE,
        };
        let own = |index: usize| {
            self.after
                .symbols
                .get(index)
                .and_then(|s| Symbol::try_from(s).ok())
        };

        if grammar.interpret.is_none() {
            let canvas = make(params);
            let mut turtle = Turtle::new(grammar, params, canvas);
            let modules = grown.iter().enumerate();
            let modules = modules.map(|(at, module)| (module, growth(at, module.symbol)));
            turtle.read_grown(modules, cancel)?;
            return turtle.finish();
        }
        // Parts that the block draws know from which module they come by what stands in the place of their births.
        let births = std::mem::take(&mut grown.births);
        let last = u32::try_from(grown.len()).unwrap_or(u32::MAX);
        grown.births = Column::from_numbers(last, 0..last);
        let shown = interpreted(grammar, &grown, &params.limits, cancel);
        let shown = shown.map_err(|error| self.in_step(error))?.unwrap_or(grown);
        let mut params = *params;
        params.limits.bytes = params.limits.bytes.saturating_sub(shown.bytes());
        let canvas = make(&params);
        let mut turtle = Turtle::new(grammar, &params, canvas);
        let modules = shown.iter().map(|module| {
            let index = module.birth as usize;
            let growth = own(index).map_or(Grown::WHOLE, |symbol| growth(index, symbol));
            let birth = births.get(index).unwrap_or(0);
            (Module { birth, ..module }, growth)
        });
        turtle.read_grown(modules, cancel)?;
        turtle.finish()
    }

    /// An error of the interpretation, which takes the newest birth for the step.
    fn in_step(&self, mut error: DeriveError) -> DeriveError {
        if let DeriveProblem::Value { step, .. } | DeriveProblem::Cancelled { step } =
            error.problem.as_mut()
        {
            *step = self.step;
        }
        error
    }

    /// The tree at an age of 0 to 1.
    ///
    /// # Errors
    /// As [`super::interpret`].
    pub fn tree(
        &self,
        grammar: &Grammar,
        age: f64,
        params: &TurtleParams,
        cancel: &AtomicBool,
    ) -> Result<Tree, DeriveError> {
        if age >= 1.0 {
            return interpret(grammar, &self.after, params, cancel);
        }
        let canvas = |params: &TurtleParams| TreeCanvas::new(grammar, params);
        Ok(self.draw_on(grammar, age, params, cancel, canvas)?.finish())
    }

    /// Parameters on their way.
    fn grow_parameters(&self, grown: &mut ModuleString, curve: impl Fn(Symbol) -> f64) {
        let mut offset = 0;
        for (module, change) in self.after.iter().zip(&self.changes) {
            let end = offset + module.parameters.len();
            if let Change::From(from) = change {
                let from = *from as usize;
                let old = self
                    .before
                    .parameters()
                    .get(from..from + module.parameters.len());
                let f = curve(module.symbol);
                let places = grown.parameters.get_mut(offset..end).unwrap_or(&mut []);
                for (value, old) in places.iter_mut().zip(old.unwrap_or(&[])) {
                    // The difference of two large numbers may be none.
                    let between = old + f * (*value - old);
                    *value = if between.is_finite() { between } else { *value };
                }
            }
            offset = end;
        }
    }
}

/// Bytes of two strings and of the changes between them.
fn bytes_between(before: &ModuleString, after: &ModuleString) -> u64 {
    let changes = (size_of::<Change>() as u64).saturating_mul(after.len() as u64);
    before.bytes() + after.bytes() + changes
}

/// What becomes of a module's successor.
fn change(
    grammar: &Grammar,
    module: Module<'_>,
    parameters: u32,
    symbols: &[Symbol],
    changes: &mut [Change],
) {
    changes.fill(Change::New);
    let mut depth = 0_usize;
    let (mut outside, mut inside) = (None, None);
    for (at, symbol) in symbols.iter().enumerate() {
        match grammar.role(*symbol) {
            Role::Open => depth += 1,
            Role::Close => depth = depth.saturating_sub(1),
            _ if *symbol == module.symbol => {
                let place = if depth == 0 {
                    &mut outside
                } else {
                    &mut inside
                };
                place.get_or_insert(at);
            }
            _ => {}
        }
    }
    let heir = outside.or(inside);
    if let Some(place) = heir.and_then(|heir| changes.get_mut(heir)) {
        // A dictionary letter's parameter says which segment it draws, and there is none between two.
        *place = match is_index(grammar, module.symbol) {
            true => Change::Whole,
            false => Change::From(parameters),
        };
    } else if let Some(length) = length_of(grammar, module.symbol, module.parameters) {
        let draws = |symbol: &Symbol| length_of(grammar, *symbol, &[]).is_some();
        let first = symbols.iter().position(draws);
        if let Some(place) = first.and_then(|first| changes.get_mut(first)) {
            *place = Change::Length(length);
        }
    }
}
