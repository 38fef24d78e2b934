//! Grammar text → [`Grammar`]: includes, declarations, statements, checks. What each statement says is read by
//! `statements`, productions by `rules`.
//!
//! Three passes over the statements, so that order in the file matters little: declarations of modules, then
//! constants, then everything else. Every statement is tried, so that several faults are told at once.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::column::Column;
use super::dialect::{self, Remark};
use super::endless::endless;
use super::error::{GrammarError, GrammarErrors};
use super::grammar::{Grammar, Order, Role, Rule, RuleSet};
use super::growth::Curves;
use super::include::{folder_of, gather};
use super::look::{self, NamedSurface, Widths};
use super::names::{MAX_PARAMETERS, Names, Symbol};
use super::query::{ANSWERS, Query};
use super::shape::{Shape, Wrap};
use super::source::{Block, Cursor, Source, Statement};
use super::string::ModuleString;
use crate::tree::foliage::Dress;
use crate::tree::organs::Palette;

mod statements;

/// What the passes gather.
#[derive(Default)]
pub(crate) struct Parser {
    pub(crate) names: Names,
    pub(crate) constants: BTreeMap<String, f64>,
    pub(crate) errors: GrammarErrors,
    pub(crate) literal: bool,
    rules: Vec<Rule>,
    decompose: Option<(Vec<Rule>, u32)>,
    interpret: Option<(Vec<Rule>, u32)>,
    axiom: Option<ModuleString>,
    order: Order,
    ignored: BTreeSet<String>,
    considered: Option<BTreeSet<String>>,
    steps: Option<u32>,
    seed: Option<u64>,
    angle: Option<f64>,
    tropism: Option<DVec3>,
    ground: Option<f64>,
    curves: Curves,
    shapes: Vec<Shape>,
    shape_names: BTreeSet<String>,
    surfaces: Vec<NamedSurface>,
    dress: Dress,
    widths: Widths,
    palette: Palette,
    wrap: Wrap,
    /// Statements that may stand only once.
    seen: BTreeSet<&'static str>,
    /// Comparisons of words with declared names that were made.
    compared: usize,
    /// What was left out when the text was translated.
    remarks: Vec<Remark>,
}

/// Comparisons of words with declared names, so that a long text of single letters is read no slower.
const MOST_COMPARISONS: usize = 200_000;
/// Letters of a word that may be a declared name misspelt.
const MISSPELT_LETTERS: std::ops::RangeInclusive<usize> = 4..=24;

pub(crate) fn grammar(text: &str, file: &str) -> Result<Grammar, GrammarErrors> {
    let (source, remarks) = dialect::opened(Source::new(file.to_owned(), text.to_owned()))?;
    of_source(source, remarks)
}

/// The grammar of a text in our notation, and what was left out when it was translated into it.
pub(crate) fn of_source(source: Source, remarks: Vec<Remark>) -> Result<Grammar, GrammarErrors> {
    let (mut parser, sources) = read(source);
    parser.remarks = remarks;
    parser.finish(&sources, true)
}

/// A grammar, or a part of one to be included, with its own text as it was cut.
pub(super) fn with_text(text: &str, file: &str) -> Result<(Grammar, Source), GrammarErrors> {
    let source = Source::new(file.to_owned(), text.to_owned());
    if let Some(dialect) = dialect::named(text) {
        let message = format!(
            "this is a file of {dialect}, whose layout is its own; bring it over with `ramus import`"
        );
        let mut errors = GrammarErrors::default();
        errors.push(source.error(0, message));
        return Err(errors);
    }
    let (parser, sources) = read(source);
    let grammar = parser.finish(&sources, false)?;
    Ok((grammar, sources.into_iter().next().unwrap_or_default()))
}

/// Tries all statements of a text and of what it includes.
fn read(source: Source) -> (Parser, Vec<Source>) {
    let file = source.name.clone();
    let mut parser = Parser::default();
    let mut sources = Vec::new();
    let mut all = Vec::new();
    let folder = folder_of(&file);
    let mut chain = Vec::new();
    if let Some(path) = Path::new(&file)
        .canonicalize()
        .ok()
        .filter(|_| folder.is_some())
    {
        chain.push(path);
    }
    gather(
        &mut parser.errors,
        &mut sources,
        &mut all,
        source,
        folder.as_deref(),
        &mut chain,
    );
    for statement in all.iter().filter(|s| s.keyword == "module") {
        parser.try_statement(&sources, statement, Parser::module);
    }
    for statement in all.iter().filter(|s| s.keyword == "const") {
        parser.try_statement(&sources, statement, Parser::constant);
    }
    // `context literal` changes what a pattern may hold, so it is known before the productions are read.
    for statement in all.iter().filter(|s| s.keyword == "context") {
        parser.try_statement(&sources, statement, Parser::context);
    }
    // As do `ignore` and `consider`.
    let lists = |s: &&Statement| matches!(s.keyword, "ignore" | "consider");
    for statement in all.iter().filter(lists) {
        parser.try_statement(&sources, statement, |p, cursor| {
            p.statement(cursor, statement)
        });
    }
    let other = |s: &&Statement| {
        !lists(s)
            && !matches!(
                s.keyword,
                "module" | "const" | "include" | "context" | "growth"
            )
    };
    // Growth is that of modules that the grammar has.
    let growth = all.iter().filter(|s| s.keyword == "growth");
    for statement in all.iter().filter(other).chain(growth) {
        parser.try_statement(&sources, statement, |p, cursor| {
            p.statement(cursor, statement)
        });
    }
    (parser, sources)
}

/// Nothing may be left of the statement.
pub(crate) fn end(cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
    if cursor.at_end() {
        Ok(())
    } else {
        Err(cursor.expected("the end of the line"))
    }
}

/// Reads parameters in parentheses, `each` one of them; returns how many there are.
pub(crate) fn parameters(
    cursor: &mut Cursor<'_>,
    mut each: impl FnMut(&mut Cursor<'_>) -> Result<(), GrammarError>,
) -> Result<usize, GrammarError> {
    if !cursor.take("(") || cursor.take(")") {
        return Ok(0);
    }
    let mut count = 0;
    loop {
        if count == MAX_PARAMETERS {
            return Err(cursor.expected(&format!(
                "`)`, since a module has at most {MAX_PARAMETERS} parameters"
            )));
        }
        each(cursor)?;
        count += 1;
        if cursor.take(")") {
            return Ok(count);
        }
        if !cursor.take(",") {
            return Err(cursor.expected("`,` or `)`"));
        }
    }
}

/// Follows brackets and braces and says where they do not fit. A polygon's braces are counted apart from the
/// brackets, since ABOP's leaves begin an outline in a branch and end it outside: `[+A{.].C.}`. Their order is free, since its
/// rose (Fig. 5.8) ends in each segment the outline that the one before began: `.}][+B{.`; the turtle tells where that does not work out.
#[derive(Default)]
pub(crate) struct Brackets {
    open: Vec<usize>,
    polygons: Vec<usize>,
    ends: Vec<usize>,
}

impl Brackets {
    pub(crate) fn module(
        &mut self,
        cursor: &Cursor<'_>,
        name: &str,
        at: usize,
        arity: usize,
    ) -> Result<(), GrammarError> {
        match name {
            "[" | "]" if arity > 0 => {
                return Err(cursor.error_at(at, format!("`{name}` takes no parameters")));
            }
            "[" => self.open.push(at),
            "]" if self.open.pop().is_none() => {
                return Err(cursor.error_at(
                    at,
                    "this `]` closes nothing; expected a `[` before it".into(),
                ));
            }
            "{" => self.polygons.push(at),
            "}" => self.ends.push(at),
            _ => {}
        }
        Ok(())
    }

    pub(crate) fn end(&self, cursor: &Cursor<'_>) -> Result<(), GrammarError> {
        let (begun, ended) = (self.polygons.len(), self.ends.len());
        let unclosed = if let Some(at) = self.open.last() {
            Some((at, "this `[` is not closed; expected a `]`"))
        } else if begun > ended {
            let last = self.polygons.last();
            last.map(|at| (at, "this polygon's `{` is not closed; expected a `}`"))
        } else {
            let more = self.ends.get(begun);
            more.map(|at| (at, "this `}` closes no polygon; expected a `{` before it"))
        };
        unclosed.map_or(Ok(()), |(at, message)| {
            Err(cursor.error_at(*at, message.into()))
        })
    }
}

impl Parser {
    fn try_statement(
        &mut self,
        sources: &[Source],
        statement: &Statement,
        read: impl FnOnce(&mut Self, &mut Cursor<'_>) -> Result<(), GrammarError>,
    ) {
        let Some(source) = sources.get(statement.file) else {
            return;
        };
        let mut cursor = Cursor::new(source, statement.body, statement.end);
        let in_block = statement.block != Block::Main && !statement.keyword.is_empty();
        let result = if in_block {
            Err(cursor.error_at(
                statement.start,
                format!(
                    "found `{}` inside a block; expected a production or `}}`",
                    statement.keyword
                ),
            ))
        } else {
            read(self, &mut cursor).and_then(|()| end(&mut cursor))
        };
        if let Err(error) = result {
            self.errors.push(error);
        }
    }

    /// Reads a module's name; a word that is nearly a declared one is told.
    pub(crate) fn read_name<'a>(
        &mut self,
        cursor: &mut Cursor<'a>,
    ) -> Result<&'a str, GrammarError> {
        cursor.skip_blank();
        let at = cursor.pos();
        let rest = cursor.rest();
        let name = self.names.read(cursor)?;
        let first = name.chars().next().is_some_and(char::is_alphabetic);
        if !first || self.names.declared(name).is_some() || cursor.goes_on_a_word(at) {
            return Ok(name);
        }
        let length = rest
            .find(|c: char| !c.is_alphabetic())
            .unwrap_or(rest.len());
        let word = rest.get(..length.min(100)).unwrap_or("");
        if MISSPELT_LETTERS.contains(&word.chars().count())
            && self.compared < MOST_COMPARISONS
            && let Some(near) = self.names.misspelt(word, &mut self.compared)
        {
            let message = format!(
                "found `{word}`, which reads as one module for each letter; the nearest declared module is `{near}` (blanks between the letters say that they are meant)"
            );
            self.errors.push(cursor.error_at(at, message));
        }
        Ok(name)
    }

    /// The symbol of a module as used, checked against its declaration.
    pub(crate) fn symbol(
        &mut self,
        cursor: &Cursor<'_>,
        name: &str,
        at: usize,
        arity: usize,
    ) -> Result<Symbol, GrammarError> {
        if let Some(declared) = self.names.declared(name)
            && declared.len() != arity
        {
            let s = if declared.len() == 1 { "" } else { "s" };
            let listed = if declared.is_empty() {
                String::new()
            } else {
                format!(" ({})", declared.join(", "))
            };
            let message = format!(
                "`{name}` is declared with {} parameter{s}{listed}; found {arity}",
                declared.len()
            );
            self.errors.push(cursor.error_at(at, message));
        }
        if Query::of(name).is_some() && !ANSWERS.contains(&arity) {
            let message = format!(
                "found `{name}` with {arity} parameters; expected the two or three that the turtle writes its answer into, as in `{name}(0, 0, 0)`"
            );
            self.errors.push(cursor.error_at(at, message));
        }
        self.names.intern(name, arity).ok_or_else(|| {
            cursor.error_at(
                at,
                "this grammar has more than 65,000 different modules".into(),
            )
        })
    }

    /// Why a context never meets the module `name`, if it does not.
    pub(crate) fn unseen(&self, name: &str) -> Option<String> {
        if self.literal {
            return None; // `ignore` and `consider` are faults of their own then
        }
        if self.ignored.contains(name) {
            return Some(format!(
                "contexts skip `{name}`, so this one never matches; take `{name}` out of `ignore`, or out of the context"
            ));
        }
        if self.considered.as_ref().is_some_and(|c| !c.contains(name)) {
            return Some(format!(
                "contexts skip `{name}`, so this one never matches; add `{name}` to `consider`, or take it out of the context"
            ));
        }
        None
    }

    /// Checks what only the whole text shows. A part of a grammar needs no axiom.
    fn finish(mut self, sources: &[Source], whole: bool) -> Result<Grammar, GrammarErrors> {
        let index = |i: usize| Symbol::try_from(i).unwrap_or(Symbol::MAX);
        let mut general = |message: &str| {
            let message = message.to_owned();
            self.errors.push(match sources.first() {
                Some(source) => source.error(source.text.len(), message),
                None => GrammarError::new("", "", 0, message),
            });
        };
        if whole && self.axiom.is_none() && !self.seen.contains("axiom") {
            general("this grammar has no axiom; expected a line such as `axiom A`");
        }
        if self.shapes.len() >= usize::from(u16::MAX) {
            general("this grammar has more than 65,000 shapes");
        }
        let is_query = |symbol: Symbol| Query::of(self.names.name(symbol)).is_some();
        let has_queries = (0..self.names.symbols().len()).any(|i| is_query(index(i)));
        let shown = self.interpret.iter().flat_map(|(rules, _)| rules);
        let hides = |rule: &Rule| {
            let cuts = |symbol: &Symbol| self.names.name(*symbol) == "%";
            let queries = |symbol: &Symbol| is_query(*symbol);
            queries(&rule.predecessor) || rule.successor.iter().any(|s| queries(s) || cuts(s))
        };
        if has_queries && shown.into_iter().any(hides) {
            general(
                "a query (`?P`) is answered where it stands in the string, so the `interpret` block of a grammar with queries holds neither queries nor `%`; take them out of it",
            );
        }
        if !self.errors.errors.is_empty() {
            // Passes find faults out of order; a person reads a file from its top.
            let file_of = |name: &str| sources.iter().position(|s| s.name == name);
            self.errors
                .errors
                .sort_by_key(|e| (file_of(&e.file), e.line, e.column));
            return Err(self.errors);
        }
        let symbols = self.names.symbols();
        let arity: Arc<[u8]> = symbols.iter().map(|s| s.arity).collect();
        let roles = (0..symbols.len())
            .map(|i| match self.names.name(index(i)) {
                "[" => Role::Open,
                "]" => Role::Close,
                "%" => Role::Cut,
                name if self.ignored.contains(name) => Role::Ignored,
                name if self.considered.as_ref().is_some_and(|c| !c.contains(name)) => {
                    Role::Ignored
                }
                _ => Role::Module,
            })
            .collect();
        for shape in &mut self.shapes {
            shape.set_wrap(self.wrap);
        }
        let by_name: BTreeMap<&str, usize> = self
            .shapes
            .iter()
            .enumerate()
            .map(|(i, s)| (s.name.as_str(), i))
            .collect();
        let shape_of = (0..symbols.len())
            .map(|i| {
                by_name
                    .get(self.names.name(index(i)))
                    .and_then(|shape| u16::try_from(*shape).ok())
            })
            .collect();
        let names = &self.names;
        let surface_of =
            look::surfaces_by_symbol(names, &mut self.surfaces, |name| by_name.contains_key(name));
        let count = symbols.len();
        let mut axiom = self.axiom.unwrap_or_default();
        axiom.arity = Arc::clone(&arity);
        let (decompose, decompose_depth) = self.decompose.unwrap_or_default();
        let (interpret, interpret_depth) = self.interpret.unwrap_or_default();
        // The width of a string's symbols is that of its choices, too: productions are numbered from 1.
        let productions = [&self.rules, &decompose, &interpret].map(Vec::len);
        let most = productions
            .into_iter()
            .fold(count.saturating_sub(1), usize::max);
        let most = u32::try_from(most).unwrap_or(u32::MAX);
        axiom.symbols =
            Column::from_numbers(most.min(u32::from(Symbol::MAX)), axiom.symbols.iter());
        let set =
            |rules: Vec<Rule>| (!rules.is_empty()).then(|| RuleSet::new(rules, count, self.order));
        let decompose = set(decompose);
        let endless = decompose.as_ref().map(|set| endless(set, count));
        Ok(Grammar {
            arity,
            roles,
            axiom,
            rules: RuleSet::new(self.rules, count, self.order),
            decompose,
            endless: endless.unwrap_or_default(),
            decompose_depth,
            interpret: set(interpret),
            interpret_depth,
            literal: self.literal,
            steps: self.steps,
            seed: self.seed.unwrap_or(0),
            angle: self.angle,
            tropism: self.tropism,
            ground: self.ground,
            curves: self.curves,
            shapes: self.shapes,
            wrap: self.wrap,
            shape_of,
            palette: self.palette,
            surfaces: self.surfaces,
            dress: self.dress,
            widths: self.widths,
            surface_of,
            has_queries,
            names: self.names,
            remarks: self.remarks,
        })
    }
}
