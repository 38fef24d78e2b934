//! Names of modules: how they are read from text, and the table of symbols.
//!
//! A symbol is a name together with a number of parameters, so that `F` and `F(l)` are two symbols of one name: productions
//! tell them apart by one comparison, and a packed string needs no count of parameters for each module.

use std::collections::{BTreeMap, HashMap};

use super::error::{GrammarError, is_misspelt};
use super::source::Cursor;

/// Index into the symbol table.
pub type Symbol = u16;

/// Parameters that one module may have.
pub(crate) const MAX_PARAMETERS: usize = 32;
/// Characters of a declared name.
const MAX_NAME_CHARS: usize = 64;
/// Signs that are modules by themselves, besides letters and digits.
const SIGNS: &str = "+-&^\\/|$![]%{}.',;";
/// Modules of the turtle that have two or three characters.
const LONG_SIGNS: [&str; 12] = [
    "@Gs", "@Ge", "@O", "?P", "?H", "?U", "?L", "?S", "?C", "@l", "@a", "@w",
];

/// One symbol.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SymbolInfo {
    /// Index of the name.
    pub(crate) name: u16,
    /// Number of parameters.
    pub(crate) arity: u8,
}

/// All names and symbols that a grammar uses.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Names {
    names: Vec<String>,
    name_of: HashMap<String, u16>,
    symbols: Vec<SymbolInfo>,
    symbol_of: HashMap<(u16, u8), Symbol>,
    /// Declared modules and their parameters.
    declared: BTreeMap<String, Vec<String>>,
    /// For a declared name's first character the lengths in bytes of such names, longest first.
    lengths: HashMap<char, Vec<usize>>,
}

impl Names {
    pub(crate) fn symbols(&self) -> &[SymbolInfo] {
        &self.symbols
    }

    /// The name of a symbol.
    pub(crate) fn name(&self, symbol: Symbol) -> &str {
        self.symbols
            .get(usize::from(symbol))
            .and_then(|s| self.names.get(usize::from(s.name)))
            .map_or("", String::as_str)
    }

    /// The symbol of a name with so many parameters.
    pub(crate) fn find(&self, name: &str, arity: u8) -> Option<Symbol> {
        let name = self.name_of.get(name)?;
        self.symbol_of.get(&(*name, arity)).copied()
    }

    /// All names of modules that the grammar uses.
    pub(crate) fn used(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    pub(crate) fn is_used(&self, name: &str) -> bool {
        self.name_of.contains_key(name)
    }

    /// Declares a module; false if it is already declared.
    pub(crate) fn declare(&mut self, name: &str, parameters: Vec<String>) -> bool {
        if self.declared.contains_key(name) {
            return false;
        }
        if let Some(first) = name.chars().next() {
            let lengths = self.lengths.entry(first).or_default();
            if !lengths.contains(&name.len()) {
                lengths.push(name.len());
                lengths.sort_unstable_by(|a, b| b.cmp(a));
            }
        }
        self.declared.insert(name.to_owned(), parameters);
        true
    }

    pub(crate) fn declared(&self, name: &str) -> Option<&[String]> {
        self.declared.get(name).map(Vec::as_slice)
    }

    /// The declared name that a word is nearly, unless it holds one as it is; comparisons are counted.
    pub(crate) fn misspelt(&self, word: &str, compared: &mut usize) -> Option<&str> {
        let letters = word.chars().count();
        let mut near = None;
        for name in self.declared.keys().take(1000) {
            *compared += 1;
            if word.contains(name.as_str()) {
                return None;
            }
            let others = name.chars().count();
            if others >= 4 && letters.abs_diff(others) <= 1 && is_misspelt(word, name) {
                near.get_or_insert(name.as_str());
            }
        }
        near
    }

    /// The symbol of a name with a number of parameters, made if it is new. `None`: there are too many.
    pub(crate) fn intern(&mut self, name: &str, arity: usize) -> Option<Symbol> {
        let arity = u8::try_from(arity).ok()?;
        let name = if let Some(known) = self.name_of.get(name) {
            *known
        } else {
            let index = u16::try_from(self.names.len())
                .ok()
                .filter(|i| *i < u16::MAX)?;
            self.names.push(name.to_owned());
            self.name_of.insert(name.to_owned(), index);
            index
        };
        if let Some(symbol) = self.symbol_of.get(&(name, arity)) {
            return Some(*symbol);
        }
        let symbol = Symbol::try_from(self.symbols.len())
            .ok()
            .filter(|s| *s < Symbol::MAX)?;
        self.symbols.push(SymbolInfo { name, arity });
        self.symbol_of.insert((name, arity), symbol);
        Some(symbol)
    }

    /// Reads the name of one module: a declared word (the longest that fits), else one of the turtle's long signs, else a single
    /// character with the subscripts and primes (₀, ′) that follow it.
    pub(crate) fn read<'a>(&self, cursor: &mut Cursor<'a>) -> Result<&'a str, GrammarError> {
        cursor.skip_blank();
        let start = cursor.pos();
        let rest = cursor.rest();
        let Some(first) = rest.chars().next() else {
            return Err(cursor.expected("a module"));
        };
        if let Some(lengths) = self.lengths.get(&first) {
            for length in lengths {
                if let Some(word) = rest.get(..*length)
                    && self.declared.contains_key(word)
                {
                    cursor.advance(*length);
                    return Ok(word);
                }
            }
        }
        if let Some(sign) = LONG_SIGNS.iter().find(|s| rest.starts_with(**s)) {
            cursor.advance(sign.len());
            return Ok(cursor.between(start, cursor.pos()));
        }
        if first == '~' {
            cursor.bump();
            if !cursor.peek().is_some_and(char::is_alphabetic) {
                return Err(cursor.expected("the name of a shape after `~`"));
            }
            self.read(cursor)?;
            return Ok(cursor.between(start, cursor.pos()));
        }
        if first.is_alphanumeric() && !is_subscript(first) {
            cursor.bump();
            while cursor
                .peek()
                .is_some_and(|c| is_subscript(c) || is_prime(c))
            {
                cursor.bump();
            }
            return Ok(cursor.between(start, cursor.pos()));
        }
        if SIGNS.contains(first) {
            cursor.bump();
            return Ok(cursor.between(start, cursor.pos()));
        }
        Err(match first {
            '@' => cursor.expected("one of the turtle's `@O`, `@Gs`, `@Ge`, `@l`, `@a`, `@w`"),
            '?' => cursor.expected("one of the turtle's `?P`, `?H`, `?U`, `?L`, `?S`, `?C`"),
            '(' => cursor.expected("a module; parameters follow a module's name"),
            '*' => cursor.expected("a module; `*` means no module at all and stands alone"),
            _ => cursor.expected("a module"),
        })
    }

    /// Reads the name in a `module` declaration.
    pub(crate) fn read_declared<'a>(cursor: &mut Cursor<'a>) -> Result<&'a str, GrammarError> {
        cursor.skip_blank();
        let start = cursor.pos();
        let rest = cursor.rest();
        if !rest.chars().next().is_some_and(char::is_alphabetic) {
            return Err(cursor.expected("the name of a module, beginning with a letter"));
        }
        let length = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '\'' || is_prime(c)))
            .unwrap_or(rest.len());
        let name = rest.get(..length).unwrap_or("");
        if name.chars().count() > MAX_NAME_CHARS {
            return Err(cursor.error_at(
                start,
                format!("this name is longer than {MAX_NAME_CHARS} characters"),
            ));
        }
        cursor.advance(length);
        Ok(name)
    }
}

/// Unicode subscripts, which belong to the letter before them.
fn is_subscript(c: char) -> bool {
    ('\u{2080}'..='\u{209c}').contains(&c)
}

/// Unicode primes, which belong to the letter before them (the ASCII `'` is the turtle's colour).
fn is_prime(c: char) -> bool {
    ('\u{2032}'..='\u{2034}').contains(&c)
}
