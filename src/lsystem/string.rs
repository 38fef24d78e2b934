//! A string of modules, packed: 6 bytes a module plus its parameters.
//!
//! Symbols, births and parameters stand in three flat arrays. How many parameters a module has is a property of its symbol,
//! so reading from the front needs no offsets; only context lookups do, and they make their own index.

use std::io;
use std::sync::Arc;

use super::grammar::Grammar;
use super::names::Symbol;
use super::number::write_general;

/// A derived string.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModuleString {
    pub(crate) symbols: Vec<Symbol>,
    pub(crate) births: Vec<u32>,
    pub(crate) parameters: Vec<f64>,
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
        self.symbols.is_empty()
    }

    /// The symbols in order.
    #[must_use]
    pub fn symbols(&self) -> &[Symbol] {
        &self.symbols
    }

    /// The step of birth of each module.
    #[must_use]
    pub fn births(&self) -> &[u32] {
        &self.births
    }

    /// All parameters one after the other.
    #[must_use]
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Bytes that the modules take.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        string_bytes(self.symbols.len() as u64, self.parameters.len() as u64)
    }

    /// How many parameters a module of this symbol has.
    pub(super) fn arity(&self, symbol: Symbol) -> usize {
        self.arity
            .get(usize::from(symbol))
            .map_or(0, |a| usize::from(*a))
    }

    /// The modules in order.
    pub fn iter(&self) -> impl Iterator<Item = Module<'_>> {
        let mut rest = self.parameters.as_slice();
        self.symbols
            .iter()
            .zip(&self.births)
            .map(move |(&symbol, &birth)| {
                let arity = self.arity(symbol);
                let (parameters, after) = rest.split_at(arity.min(rest.len()));
                rest = after;
                Module {
                    symbol,
                    birth,
                    parameters,
                }
            })
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
        const BUFFER: usize = 1 << 16;
        let mut text = String::with_capacity(BUFFER + 1024);
        for module in self.iter() {
            push_module(&mut text, grammar, &module);
            if text.len() >= BUFFER {
                out.write_all(text.as_bytes())?;
                text.clear();
            }
        }
        out.write_all(text.as_bytes())
    }
}

/// Bytes of a string of so many modules and parameters.
pub(crate) fn string_bytes(modules: u64, parameters: u64) -> u64 {
    let module = (size_of::<Symbol>() + size_of::<u32>()) as u64;
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
