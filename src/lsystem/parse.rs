//! Grammar text → [`Grammar`]: includes, declarations, statements, checks. Productions are read by `rules`.
//!
//! Three passes over the statements, so that order in the file matters little: declarations of modules, then
//! constants, then everything else. Every statement is tried, so that several faults are told at once.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::error::{GrammarError, GrammarErrors, nearest};
use super::expression;
use super::grammar::{Grammar, Order, Role, Rule, RuleSet};
use super::include::{folder_of, gather};
use super::names::{MAX_PARAMETERS, Names, Symbol};
use super::number::write_general;
use super::rules;
use super::shape::{self, Shape, Wrap};
use super::source::{Block, Cursor, KEYWORDS, Source, Statement};
use super::string::ModuleString;

/// Rounds of decomposition where the file states none.
const DECOMPOSE_DEPTH: u32 = 100;
/// Rounds of interpretation where the file states none: each module is replaced once, as L-Py does.
const INTERPRET_DEPTH: u32 = 1;

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
    shapes: Vec<Shape>,
    shape_names: BTreeSet<String>,
    wrap: Wrap,
    /// Statements that may stand only once.
    seen: BTreeSet<&'static str>,
}

pub(crate) fn grammar(text: &str, file: &str) -> Result<Grammar, GrammarErrors> {
    let mut parser = Parser::default();
    let mut sources = Vec::new();
    let mut all = Vec::new();
    let folder = folder_of(file);
    let mut chain = Vec::new();
    if let Some(path) = Path::new(file)
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
        Source::new(file.to_owned(), text.to_owned()),
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
    for statement in all
        .iter()
        .filter(|s| !lists(s) && !matches!(s.keyword, "module" | "const" | "include" | "context"))
    {
        parser.try_statement(&sources, statement, |p, cursor| {
            p.statement(cursor, statement)
        });
    }
    parser.finish(&sources)
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
/// brackets, since ABOP's leaves begin an outline in a branch and end it outside: `[+A{.].C.}`.
#[derive(Default)]
pub(crate) struct Brackets {
    open: Vec<usize>,
    polygons: Vec<usize>,
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
            "}" if self.polygons.pop().is_none() => {
                return Err(cursor.error_at(
                    at,
                    "this `}` closes no polygon; expected a `{` before it".into(),
                ));
            }
            _ => {}
        }
        Ok(())
    }

    pub(crate) fn end(&self, cursor: &Cursor<'_>) -> Result<(), GrammarError> {
        let unclosed = match (self.open.last(), self.polygons.last()) {
            (Some(at), _) => Some((at, "this `[` is not closed; expected a `]`")),
            (None, Some(at)) => Some((at, "this polygon's `{` is not closed; expected a `}`")),
            (None, None) => None,
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
        if matches!(name, "?P" | "?H") {
            let message =
                format!("the query `{name}` cannot be answered yet; expected another module");
            self.errors.push(cursor.error_at(at, message));
        }
        self.names.intern(name, arity).ok_or_else(|| {
            cursor.error_at(
                at,
                "this grammar has more than 65,000 different modules".into(),
            )
        })
    }

    fn once(&mut self, cursor: &Cursor<'_>, keyword: &'static str) -> Result<(), GrammarError> {
        if self.seen.insert(keyword) {
            Ok(())
        } else {
            let at = cursor.pos().saturating_sub(keyword.len());
            Err(cursor.error_at(
                at,
                format!("`{keyword}` stands here a second time; expected it once"),
            ))
        }
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

    fn module(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        loop {
            cursor.skip_blank();
            let at = cursor.pos();
            let name = Names::read_declared(cursor)?;
            let mut listed: Vec<String> = Vec::new();
            parameters(cursor, |c| {
                let name = c
                    .identifier()
                    .ok_or_else(|| c.expected("the name of a parameter"))?;
                listed.push(name.to_owned());
                Ok(())
            })?;
            if !self.names.declare(name, listed) {
                return Err(cursor.error_at(at, format!("`{name}` is declared twice")));
            }
            if !cursor.take(",") {
                return Ok(());
            }
        }
    }

    fn constant(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        loop {
            cursor.skip_blank();
            let at = cursor.pos();
            let name = cursor
                .identifier()
                .ok_or_else(|| cursor.expected("the name of a constant"))?;
            cursor.expect("=")?;
            let value = expression::parse_constant(cursor, &self.constants, &mut self.errors)?;
            if self.constants.insert(name.to_owned(), value).is_some() {
                return Err(
                    cursor.error_at(at, format!("the constant `{name}` is given a value twice"))
                );
            }
            if !cursor.take(",") {
                return Ok(());
            }
        }
    }

    fn context(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        self.once(cursor, "context")?;
        match cursor.identifier() {
            Some("literal") => self.literal = true,
            Some("branches") => {}
            _ => return Err(cursor.expected("`literal` or `branches`")),
        }
        Ok(())
    }

    fn statement(
        &mut self,
        cursor: &mut Cursor<'_>,
        statement: &Statement,
    ) -> Result<(), GrammarError> {
        let keyword = statement.keyword;
        if !matches!(keyword, "" | "ignore" | "shape") {
            self.once(cursor, keyword)?;
        }
        match keyword {
            "axiom" => self.axiom(cursor),
            "ignore" => {
                let names = self.list(cursor)?;
                self.ignored.extend(names);
                Ok(())
            }
            "consider" => {
                self.considered = Some(self.list(cursor)?);
                Ok(())
            }
            "steps" => {
                self.steps = Some(self.whole(cursor)?);
                Ok(())
            }
            "seed" => {
                cursor.skip_blank();
                let digits = cursor.rest().bytes().take_while(u8::is_ascii_digit).count();
                let seed = cursor.rest().get(..digits).and_then(|t| t.parse().ok());
                self.seed = Some(seed.ok_or_else(|| cursor.expected("a whole number below 2^64"))?);
                cursor.advance(digits);
                Ok(())
            }
            "angle" => {
                self.angle = Some(expression::parse_constant(
                    cursor,
                    &self.constants,
                    &mut self.errors,
                )?);
                Ok(())
            }
            "order" => {
                self.order = match cursor.identifier() {
                    Some("first") => Order::First,
                    Some("specific") => Order::Specific,
                    _ => return Err(cursor.expected("`first` or `specific`")),
                };
                Ok(())
            }
            "wrap" => {
                self.wrap = match cursor.identifier() {
                    Some("carry") => Wrap::Carry,
                    Some("restart") => Wrap::Restart,
                    _ => return Err(cursor.expected("`carry` or `restart`")),
                };
                Ok(())
            }
            "dialect" => match cursor.identifier() {
                Some("ramus") => Ok(()),
                Some(name @ ("lpy" | "houdini" | "cpfg")) => {
                    let at = cursor.pos().saturating_sub(name.len());
                    Err(cursor.error_at(
                        at,
                        format!("the dialect `{name}` cannot be read yet; expected `ramus`, the only one that is read"),
                    ))
                }
                Some(name) => {
                    let at = cursor.pos().saturating_sub(name.len());
                    let name: String = name.chars().take(40).collect();
                    Err(cursor.error_at(
                        at,
                        format!("the dialect `{name}` is not known; expected `ramus`, the only one that is read (`lpy`, `houdini` and `cpfg` are known and cannot be read yet)"),
                    ))
                }
                None => Err(cursor.expected("the name of a dialect: `ramus`")),
            },
            "tropism" => {
                let mut axis = [0.0; 3];
                for value in &mut axis {
                    *value = expression::signed(cursor)?;
                }
                self.tropism = Some(DVec3::from(axis));
                Ok(())
            }
            "shape" => {
                cursor.skip_blank();
                let at = cursor.pos();
                let shape = shape::read(&self.names, cursor)?;
                if !self.shape_names.insert(shape.name.clone()) {
                    let message = format!("the shape `{}` is given twice", shape.name);
                    return Err(cursor.error_at(at, message));
                }
                self.shapes.push(shape);
                Ok(())
            }
            "decompose" => {
                let depth = self.block(cursor, DECOMPOSE_DEPTH)?;
                self.decompose.get_or_insert_with(|| (Vec::new(), 0)).1 = depth;
                Ok(())
            }
            "interpret" => {
                let depth = self.block(cursor, INTERPRET_DEPTH)?;
                self.interpret.get_or_insert_with(|| (Vec::new(), 0)).1 = depth;
                Ok(())
            }
            _ => self.production(cursor, statement),
        }
    }

    fn production(
        &mut self,
        cursor: &mut Cursor<'_>,
        statement: &Statement,
    ) -> Result<(), GrammarError> {
        if !cursor.rest().contains("->") {
            let word: String = cursor
                .rest()
                .chars()
                .take_while(|c| c.is_alphanumeric())
                .take(40)
                .collect();
            let hint = nearest(&word, KEYWORDS.iter().copied()).map_or(String::new(), |n| {
                format!("; the nearest known word is `{n}`")
            });
            return Err(cursor.expected(&format!("a statement or a production with `->`{hint}")));
        }
        let rule = rules::production(self, cursor, statement.block != Block::Main)?;
        let list = match statement.block {
            Block::Main => &mut self.rules,
            Block::Decompose => {
                &mut self
                    .decompose
                    .get_or_insert_with(|| (Vec::new(), DECOMPOSE_DEPTH))
                    .0
            }
            Block::Interpret => {
                &mut self
                    .interpret
                    .get_or_insert_with(|| (Vec::new(), INTERPRET_DEPTH))
                    .0
            }
        };
        if list.len() >= usize::from(u16::MAX) - 1 {
            return Err(cursor.error_at(
                statement.start,
                "this grammar has more than 65,000 productions".into(),
            ));
        }
        list.push(rule);
        Ok(())
    }

    fn axiom(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        let mut axiom = ModuleString::default();
        let mut brackets = Brackets::default();
        if cursor.take("*") {
            self.axiom = Some(axiom);
            return Ok(());
        }
        if cursor.at_end() {
            return Err(cursor.expected("modules, or `*` for none"));
        }
        while !cursor.at_end() {
            let at = cursor.pos();
            let name = self.names.read(cursor)?;
            let (constants, errors) = (&self.constants, &mut self.errors);
            let arity = parameters(cursor, |c| {
                axiom
                    .parameters
                    .push(expression::parse_constant(c, constants, errors)?);
                Ok(())
            })?;
            brackets.module(cursor, name, at, arity)?;
            axiom.symbols.push(self.symbol(cursor, name, at, arity)?);
        }
        brackets.end(cursor)?;
        axiom.births = vec![0; axiom.symbols.len()];
        self.axiom = Some(axiom);
        Ok(())
    }

    /// A list of module names.
    fn list(&mut self, cursor: &mut Cursor<'_>) -> Result<BTreeSet<String>, GrammarError> {
        let mut names = BTreeSet::new();
        while !cursor.at_end() {
            let at = cursor.pos();
            let name = self.names.read(cursor)?;
            if matches!(name, "[" | "]") {
                return Err(cursor.error_at(
                    at,
                    "brackets are always seen by contexts; expected other modules".into(),
                ));
            }
            names.insert(name.to_owned());
        }
        Ok(names)
    }

    fn whole(&mut self, cursor: &mut Cursor<'_>) -> Result<u32, GrammarError> {
        cursor.skip_blank();
        let at = cursor.pos();
        let value = expression::parse_constant(cursor, &self.constants, &mut self.errors)?;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole and in range"
        )]
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            return Ok(value as u32);
        }
        // As it is written, since a large number has other digits as a float; with its value where that is not plain.
        let written = cursor.between(at, cursor.pos()).trim_end();
        let mut found: String = written.chars().take(40).collect();
        if written.parse::<f64>().is_err() {
            found.push_str("`, which is `");
            write_general(&mut found, value);
        }
        Err(cursor.error_at(
            at,
            format!(
                "found `{found}`; expected a whole number from 0 to {}",
                u32::MAX
            ),
        ))
    }

    /// `depth N {` or `{`.
    fn block(&mut self, cursor: &mut Cursor<'_>, default: u32) -> Result<u32, GrammarError> {
        let depth = if cursor.take("depth") {
            self.whole(cursor)?
        } else {
            default
        };
        cursor.expect("{")?;
        Ok(depth)
    }

    fn finish(mut self, sources: &[Source]) -> Result<Grammar, GrammarErrors> {
        let first = sources.first();
        let (file, text) = first.map_or(("", ""), |s| (s.name.as_str(), s.text.as_str()));
        let mut general = |message: &str| {
            self.errors.push(GrammarError::new(
                file,
                text,
                text.len(),
                message.to_owned(),
            ))
        };
        if self.axiom.is_none() && !self.seen.contains("axiom") {
            general("this grammar has no axiom; expected a line such as `axiom A`");
        }
        if self.literal && (!self.ignored.is_empty() || self.considered.is_some()) {
            general(
                "`context literal` sees every module, so `ignore` and `consider` mean nothing with it; remove one of them",
            );
        }
        if self.considered.is_some() && !self.ignored.is_empty() {
            general("found both `ignore` and `consider`; expected one of them");
        }
        if self.shapes.len() >= usize::from(u16::MAX) {
            general("this grammar has more than 65,000 shapes");
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
        let index = |i: usize| Symbol::try_from(i).unwrap_or(Symbol::MAX);
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
        let count = symbols.len();
        let mut axiom = self.axiom.unwrap_or_default();
        axiom.arity = Arc::clone(&arity);
        let (decompose, decompose_depth) = self.decompose.unwrap_or_default();
        let (interpret, interpret_depth) = self.interpret.unwrap_or_default();
        let set =
            |rules: Vec<Rule>| (!rules.is_empty()).then(|| RuleSet::new(rules, count, self.order));
        Ok(Grammar {
            arity,
            roles,
            axiom,
            rules: RuleSet::new(self.rules, count, self.order),
            decompose: set(decompose),
            decompose_depth,
            interpret: set(interpret),
            interpret_depth,
            literal: self.literal,
            steps: self.steps,
            seed: self.seed.unwrap_or(0),
            angle: self.angle,
            tropism: self.tropism,
            shapes: self.shapes,
            shape_of,
            names: self.names,
        })
    }
}
