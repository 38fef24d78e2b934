//! What each statement says, taken into the [`Parser`].

use std::collections::BTreeSet;

use glam::DVec3;

use super::{Brackets, Parser, parameters};
use crate::lsystem::column::Column;
use crate::lsystem::dialect::Dialect;
use crate::lsystem::error::{GrammarError, nearest};
use crate::lsystem::expression;
use crate::lsystem::grammar::Order;
use crate::lsystem::growth;
use crate::lsystem::look;
use crate::lsystem::names::{Names, Symbol};
use crate::lsystem::number::write_general;
use crate::lsystem::rules;
use crate::lsystem::shape::{self, Wrap};
use crate::lsystem::source::{Block, Cursor, KEYWORDS, Statement};
use crate::lsystem::string::ModuleString;

/// Rounds of decomposition where the file states none.
const DECOMPOSE_DEPTH: u32 = 100;
/// Rounds of interpretation where the file states none: each module is replaced once, as L-Py does.
const INTERPRET_DEPTH: u32 = 1;

/// One of a statement's words.
fn word_of<T: Copy>(cursor: &mut Cursor<'_>, words: [(&str, T); 2]) -> Result<T, GrammarError> {
    let mut ahead = cursor.clone();
    let word = ahead.identifier().unwrap_or("");
    let [(first, _), (second, _)] = words;
    if let Some((_, meant)) = words.iter().find(|(known, _)| *known == word) {
        *cursor = ahead;
        return Ok(*meant);
    }
    let hint = nearest(word, [first, second].into_iter())
        .map_or(String::new(), |near| format!("; the nearest is `{near}`"));
    Err(cursor.expected(&format!("`{first}` or `{second}`{hint}")))
}

impl Parser {
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

    pub(super) fn module(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
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

    pub(super) fn constant(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        loop {
            cursor.skip_blank();
            let at = cursor.pos();
            let name = cursor
                .identifier()
                .ok_or_else(|| cursor.expected("the name of a constant"))?;
            let value = cursor.expect("=").and_then(|()| {
                expression::parse_constant(cursor, &self.constants, &mut self.errors)
            });
            let value = match value {
                Ok(value) => value,
                Err(fault) => {
                    // It is known all the same: where it is used there is no other fault.
                    self.constants.entry(name.to_owned()).or_insert(1.0);
                    return Err(fault);
                }
            };
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

    pub(super) fn context(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        self.once(cursor, "context")?;
        self.literal = word_of(cursor, [("literal", true), ("branches", false)])?;
        Ok(())
    }

    pub(super) fn statement(
        &mut self,
        cursor: &mut Cursor<'_>,
        statement: &Statement,
    ) -> Result<(), GrammarError> {
        let keyword = statement.keyword;
        if !matches!(
            keyword,
            "" | "ignore" | "shape" | "surface" | "colour" | "material" | "growth" | "bears"
        ) {
            self.once(cursor, keyword)?;
        }
        match keyword {
            "axiom" => self.axiom(cursor),
            "ignore" => {
                self.lists(cursor, statement, self.considered.is_some())?;
                let names = self.list(cursor)?;
                self.ignored.extend(names);
                Ok(())
            }
            "consider" => {
                self.lists(cursor, statement, !self.ignored.is_empty())?;
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
                let words = [("first", Order::First), ("specific", Order::Specific)];
                self.order = word_of(cursor, words)?;
                Ok(())
            }
            "wrap" => {
                let words = [("carry", Wrap::Carry), ("restart", Wrap::Restart)];
                self.wrap = word_of(cursor, words)?;
                Ok(())
            }
            "dialect" => {
                match cursor.identifier() {
                    Some("ramus") => Ok(()),
                    Some(name) if name.parse::<Dialect>().is_ok() => {
                        let at = cursor.pos().saturating_sub(name.len());
                        let message = match statement.file {
                            0 => format!(
                                "the dialect `{name}` is told too late; expected it before everything else"
                            ),
                            _ => format!(
                                "a file of the dialect `{name}` cannot be included; bring it over with `ramus import` and include that"
                            ),
                        };
                        Err(cursor.error_at(at, message))
                    }
                    Some(name) => {
                        let at = cursor.pos().saturating_sub(name.len());
                        let name: String = name.chars().take(40).collect();
                        Err(cursor.error_at(
                        at,
                        format!("the dialect `{name}` is not known; expected `ramus`, `cpfg`, `lpy` or `houdini`"),
                    ))
                    }
                    None => Err(cursor
                        .expected("the name of a dialect: `ramus`, `cpfg`, `lpy` or `houdini`")),
                }
            }
            "tropism" => {
                let mut axis = [0.0; 3];
                for value in &mut axis {
                    *value = expression::signed(cursor)?;
                }
                self.tropism = Some(DVec3::from(axis));
                Ok(())
            }
            "ground" => {
                self.ground = Some(expression::signed(cursor)?);
                Ok(())
            }
            "shape" => {
                cursor.skip_blank();
                let at = cursor.pos();
                let shape = shape::read(&self.names, cursor)?;
                if !self.shape_names.insert(shape.name.clone()) {
                    let message = format!("`{}` is a shape or surface already", shape.name);
                    return Err(cursor.error_at(at, message));
                }
                self.shapes.push(shape);
                Ok(())
            }
            "colour" => look::colour(&mut self.palette, cursor),
            "material" => look::material(&mut self.palette, cursor),
            "bark" => look::bark(&mut self.dress, cursor),
            "season" => {
                self.dress.season = look::season(cursor)?;
                Ok(())
            }
            "bears" => look::bears(&mut self.dress, &self.surfaces, cursor),
            "widths" => {
                self.widths = look::widths(cursor)?;
                Ok(())
            }
            "surface" => {
                cursor.skip_blank();
                let at = cursor.pos();
                let named = look::surface(&self.names, cursor)?;
                if !self.shape_names.insert(named.name.clone()) {
                    let message = format!("`{}` is a shape or surface already", named.name);
                    return Err(cursor.error_at(at, message));
                }
                self.surfaces.push(named);
                Ok(())
            }
            "growth" => self.growth(cursor),
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

    /// `growth F linear`, `growth default once`.
    fn growth(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        cursor.skip_blank();
        let at = cursor.pos();
        let mut ahead = cursor.clone();
        let twice = if ahead.identifier() == Some("default") {
            *cursor = ahead;
            let curve = growth::curve(cursor)?;
            self.curves.default.replace(curve).is_some()
        } else {
            let name = self.names.read(cursor)?.to_owned();
            let curve = growth::curve(cursor)?;
            if !self.names.is_used(&name) {
                let known = nearest(&name, self.names.used());
                let hint = known.map_or(String::new(), |n| {
                    format!("; the nearest known one is `{n}`")
                });
                let message = format!("no module of this grammar is called `{name}`{hint}");
                return Err(cursor.error_at(at, message));
            }
            self.curves.of.insert(name, curve).is_some()
        };
        if twice {
            let message = "this module's growth is given a second time; expected it once";
            return Err(cursor.error_at(at, message.into()));
        }
        Ok(())
    }

    fn production(
        &mut self,
        cursor: &mut Cursor<'_>,
        statement: &Statement,
    ) -> Result<(), GrammarError> {
        if !cursor.rest().contains("->") {
            return Err(self.no_production(cursor));
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

    /// Both lists of what contexts see, or one where they see everything, mean nothing.
    fn lists(
        &self,
        cursor: &Cursor<'_>,
        statement: &Statement,
        other: bool,
    ) -> Result<(), GrammarError> {
        let message = if self.literal {
            "`context literal` sees every module, so `ignore` and `consider` mean nothing with it; remove one of them"
        } else if other {
            "found both `ignore` and `consider`; expected one of them"
        } else {
            return Ok(());
        };
        Err(cursor.error_at(statement.start, message.into()))
    }

    /// What is wrong with a statement that has neither a known word nor an arrow.
    fn no_production(&mut self, cursor: &mut Cursor<'_>) -> GrammarError {
        cursor.skip_blank();
        let start = cursor.pos();
        let text = cursor.rest();
        if text.starts_with('}') {
            return cursor.error_at(start, "this `}` closes no block".into());
        }
        for arrow in ["→", "⟶", "=>", "- >"] {
            if let Some(at) = text.find(arrow) {
                return cursor.error_at(start + at, format!("found `{arrow}`; expected `->`"));
            }
        }
        let word: String = text
            .chars()
            .take_while(|c| c.is_alphanumeric())
            .take(40)
            .collect();
        if word == "derivation" || word == "iterations" {
            return cursor.expected("a statement; the number of steps is said by `steps 5`");
        }
        let near = nearest(&word, KEYWORDS.iter().copied());
        if near == Some("axiom") {
            self.seen.insert("axiom"); // it is not missing, too
        }
        let after = text.get(word.len()..).unwrap_or("").trim_start();
        if near == Some(word.as_str()) && after.starts_with([':', '=']) {
            let sign = if after.starts_with(':') { ':' } else { '=' };
            return cursor.error_at(
                start,
                format!("found `{word}{sign}`; expected a blank after `{word}`, as in `{word} …`"),
            );
        }
        let hint = near.map_or(String::new(), |near| {
            format!("; the nearest known word is `{near}`")
        });
        if hint.is_empty() && (word.chars().count() < 2 || after.starts_with(['(', ':'])) {
            cursor.advance(text.trim_end().len());
            return cursor.expected("`->` and a successor");
        }
        cursor.expected(&format!("a statement or a production with `->`{hint}"))
    }

    fn axiom(&mut self, cursor: &mut Cursor<'_>) -> Result<(), GrammarError> {
        let mut axiom = ModuleString {
            symbols: Column::up_to(u32::from(Symbol::MAX)),
            ..ModuleString::default()
        };
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
            let name = self.read_name(cursor)?;
            let (constants, errors) = (&self.constants, &mut self.errors);
            let arity = parameters(cursor, |c| {
                let value = expression::parse_constant(c, constants, errors)?;
                axiom.parameters.extend([value]);
                Ok(())
            })?;
            brackets.module(cursor, name, at, arity)?;
            let symbol = self.symbol(cursor, name, at, arity)?;
            axiom.symbols.push(u32::from(symbol));
        }
        brackets.end(cursor)?;
        axiom.births = Column::from_numbers(0, axiom.symbols.iter().map(|_| 0));
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
}
