//! A string of modules, packed: mostly 2 bytes a module plus its parameters.
//!
//! Symbols, births and parameters stand in three flat arrays, symbols and births as narrow as grammar and number of steps
//! allow: a byte each for up to 256 symbols and 255 steps. How many parameters a module has is a property of its symbol,
//! so reading from the front needs no offsets; only context lookups do, and they make their own index.

use std::io;
use std::sync::Arc;

use super::column::{Cell, Column, Narrow};
use super::grammar::Grammar;
use super::names::Symbol;
use super::number::write_general;
use crate::tree::Cells;

/// A derived string.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModuleString {
    pub(crate) symbols: Column,
    pub(crate) births: Column,
    pub(crate) parameters: Cells<f64>,
    /// Number of parameters of each symbol.
    pub(crate) arity: Arc<[u8]>,
}

/// One module of a string.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Module<'a> {
    /// Its symbol; `Grammar::name` gives the name.
    pub symbol: Symbol,
    /// The step in which it appeared (0: it stands in the axiom).
    pub birth: u32,
    /// Its parameters.
    pub parameters: &'a [f64],
}

impl ModuleString {
    /// Number of modules, brackets included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.symbols.len()
    }

    /// True for the empty string.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The symbols in order.
    pub fn symbols(&self) -> impl ExactSizeIterator<Item = Symbol> + '_ {
        self.symbols.iter().map(Symbol::of)
    }

    /// The step of birth of each module.
    pub fn births(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.births.iter()
    }

    /// All parameters one after the other.
    #[must_use]
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Bytes that the modules take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        let module = self.symbols.cell_bytes() + self.births.cell_bytes();
        string_bytes(module, self.len() as u64, self.parameters.len() as u64)
    }

    /// The modules in order.
    pub fn iter(&self) -> impl Iterator<Item = Module<'_>> {
        let mut rest = &self.parameters[..];
        self.symbols()
            .zip(self.births())
            .map(move |(symbol, birth)| {
                let arity = arity_of(&self.arity, symbol);
                let (parameters, after) = rest.split_at(arity.min(rest.len()));
                rest = after;
                Module {
                    symbol,
                    birth,
                    parameters,
                }
            })
    }

    /// The same modules in the numbers of another grammar, whose symbols and choices go up to `most`; none where one has no number.
    pub(super) fn renumbered(
        self,
        numbers: Option<&[Option<Symbol>]>,
        most: u32,
        arity: &Arc<[u8]>,
    ) -> Option<Self> {
        let symbols = match numbers {
            None if self.symbols.most() == most => self.symbols,
            None => Column::from_numbers(most, self.symbols.iter()),
            Some(numbers) => {
                let number = |symbol: Symbol| numbers.get(usize::from(symbol)).copied().flatten();
                if !self.symbols().all(|symbol| number(symbol).is_some()) {
                    return None;
                }
                let renumbered = self.symbols().map(|s| number(s).map_or(0, u32::from));
                Column::from_numbers(most, renumbered)
            }
        };
        Some(Self {
            symbols,
            arity: Arc::clone(arity),
            ..self
        })
    }

    /// An empty string for modules with symbols and births up to these.
    pub(super) fn up_to(symbol: u32, birth: u32, arity: &Arc<[u8]>) -> Self {
        Self {
            symbols: Column::up_to(symbol),
            births: Column::up_to(birth),
            parameters: Cells::default(),
            arity: Arc::clone(arity),
        }
    }

    /// An empty string for modules of this one's symbols and births.
    pub(super) fn empty_like(&self) -> Self {
        Self::up_to(self.symbols.most(), self.births.most(), &self.arity)
    }

    /// Adds a module, which the columns must hold.
    pub(super) fn push(&mut self, module: &Module<'_>) {
        self.symbols.push(u32::from(module.symbol));
        self.births.push(module.birth);
        self.parameters.extend(module.parameters.iter().copied());
    }

    /// The text, as `ramus derive --print string` prints it: no blanks, parameters as `%.10g`.
    #[must_use]
    pub fn to_text(&self, grammar: &Grammar) -> String {
        self.to_text_within(grammar, usize::MAX)
    }

    /// The text, ended with `…` before the module that would make it longer than `max_bytes`.
    #[must_use]
    pub fn to_text_within(&self, grammar: &Grammar, max_bytes: usize) -> String {
        let mut text = String::new();
        for module in self.iter() {
            let before = text.len();
            push_module(&mut text, grammar, &module);
            if text.len() > max_bytes {
                text.truncate(before);
                text.push('…');
                break;
            }
        }
        text
    }

    /// Writes the text without ever holding all of it.
    pub fn write_text(&self, grammar: &Grammar, out: &mut dyn io::Write) -> io::Result<()> {
        write_modules(self.iter(), grammar, out)
    }
}

/// Writes modules as text without ever holding all of it.
pub(super) fn write_modules<'m>(
    modules: impl Iterator<Item = Module<'m>>,
    grammar: &Grammar,
    out: &mut dyn io::Write,
) -> io::Result<()> {
    const BUFFER: usize = 1 << 16;
    let mut text = String::with_capacity(BUFFER + 1024);
    for module in modules {
        push_module(&mut text, grammar, &module);
        if text.len() >= BUFFER {
            out.write_all(text.as_bytes())?;
            text.clear();
        }
    }
    out.write_all(text.as_bytes())
}

/// How many parameters a module of this symbol has.
#[inline]
pub(super) fn arity_of(arity: &[u8], symbol: impl Into<usize>) -> usize {
    arity.get(symbol.into()).map_or(0, |a| usize::from(*a))
}

/// How many parameters modules of these symbols have.
pub(super) fn parameters_of<S: Narrow>(arity: &[u8], symbols: &[S]) -> usize {
    symbols.iter().map(|s| arity_of(arity, *s)).sum()
}

/// Bytes of a string of so many modules and parameters, where a module without its parameters takes so many.
pub(super) fn string_bytes(module: u64, modules: u64, parameters: u64) -> u64 {
    modules
        .saturating_mul(module)
        .saturating_add(parameters.saturating_mul(size_of::<f64>() as u64))
}

pub(super) fn push_module(text: &mut String, grammar: &Grammar, module: &Module<'_>) {
    text.push_str(grammar.name(module.symbol));
    for (i, value) in module.parameters.iter().enumerate() {
        text.push(if i == 0 { '(' } else { ',' });
        write_general(text, *value);
    }
    if !module.parameters.is_empty() {
        text.push(')');
    }
}
