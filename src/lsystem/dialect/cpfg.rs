//! cpfg's L-system files.
//!
//! A statement is a line; a line that begins with a tab (or with blanks, where it is no statement of its own) continues the one before, and so does what
//! stands in braces. Statements of assignment are carried over: those of `Start` as constants, those of a production by replacing the names
//! by their values. All other code is named.

use std::collections::HashMap;

use super::Dialect;
use super::expression::{Expr, Kind, Node};
use super::model::{Block, Model, Module, Rule, Valued, formals};
use super::preprocess::CONSTANT_MARK;
use super::reader::Reader;
use super::statements::{Values, assignments, printing_block, start_block, substitute, value_of};
use super::text::Fault;

/// cpfg's turn where its view file states none.
const ANGLE: &str = "45";

/// Labels as they are compared: small letters, no blanks.
const LABELS: [&str; 15] = [
    "lsystem:",
    "seed:",
    "derivationlength:",
    "maximumdepth:",
    "consider:",
    "ignore:",
    "axiom:",
    "define:",
    "startblock:",
    "starteach:",
    "start:",
    "endeach:",
    "endlsystem",
    "end:",
    "ringl-system",
];

pub(super) fn read(text: &str, model: &mut Model) {
    let mut cpfg = Cpfg {
        text,
        block: Block::Main,
        systems: 0,
        brackets_considered: true,
    };
    if let Ok(value) = Node::number(0, ANGLE) {
        model.angle = Some(Valued { at: 0, value });
    }
    for (start, end) in lines(text) {
        let result = cpfg.line(start, end, model);
        model.kept(result);
    }
    cpfg.finish(model);
}

/// Logical lines: first and last byte.
fn lines(text: &str) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    let mut at = 0;
    // Of the statement so far: whether braces hold code, and how many are open.
    let (mut code, mut open) = (false, 0_usize);
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        if line.trim().is_empty() {
            continue;
        }
        let arrow = line.contains("-->") || line.contains("-o>");
        let label = label(line.trim_start());
        let indented =
            line.starts_with('\t') || (line.starts_with(' ') && label.is_none() && !arrow);
        match found.last_mut().filter(|_| indented || open > 0) {
            Some(last) => last.1 = start + line.trim_end().len(),
            None => {
                found.push((start, start + line.trim_end().len()));
                // Braces of an axiom are a polygon; those of a production hold code before its arrow.
                let strings = matches!(label, Some(("axiom:" | "ignore:" | "consider:", _)));
                code = !strings && (label.is_some() || line.contains(':'));
                open = 0;
            }
        }
        if arrow {
            (code, open) = (false, 0);
        } else if code {
            let count = |c| line.bytes().filter(|b| *b == c).count();
            open = (open + count(b'{')).saturating_sub(count(b'}'));
        }
    }
    found
}

/// The label at the beginning of a line, and its length.
fn label(line: &str) -> Option<(&'static str, usize)> {
    let mut seen = String::new();
    for (i, c) in line.char_indices().take(40) {
        if !c.is_whitespace() {
            seen.push(c.to_ascii_lowercase());
        }
        if let Some(found) = LABELS.iter().find(|l| **l == seen) {
            return Some((found, i + c.len_utf8()));
        }
        let section = ["homomorphism", "decomposition"]
            .into_iter()
            .find(|l| *l == seen);
        if let Some(found) = section {
            return Some((found, i + c.len_utf8()));
        }
    }
    None
}

struct Cpfg<'a> {
    text: &'a str,
    block: Block,
    systems: usize,
    /// Whether `consider` lists the brackets, or is not there.
    brackets_considered: bool,
}

impl<'a> Cpfg<'a> {
    fn line(&mut self, start: usize, end: usize, model: &mut Model) -> Result<(), Fault> {
        let line = self.text.get(start..end).unwrap_or("");
        if let Some(rest) = line.strip_prefix(CONSTANT_MARK) {
            return constant(start, rest, model);
        }
        let indent = line.len() - line.trim_start().len();
        let start = start + indent;
        let Some((label, length)) = label(line.trim_start()) else {
            let reader = Reader::new(self.text, Dialect::Cpfg, start, end);
            return self.production(reader, model);
        };
        let mut reader = Reader::new(self.text, Dialect::Cpfg, start + length, end);
        match label {
            "lsystem:" => {
                self.systems += 1;
                if self.systems > 1 {
                    return Err(Fault::new(
                        start,
                        "sub-L-systems cannot be carried over; expected one L-system in the file",
                    ));
                }
            }
            "seed:" if self.block == Block::Interpret => {
                model.remark(
                    start,
                    "the seed of the homomorphism; the grammar's own is used",
                );
            }
            "seed:" => model.seed = Some(valued(&mut reader)?),
            "derivationlength:" => model.steps = Some(valued(&mut reader)?),
            "maximumdepth:" => {
                let depth = Some(valued(&mut reader)?);
                match self.block {
                    Block::Decompose => model.decompose_depth = depth,
                    _ => model.interpret_depth = depth,
                }
            }
            "consider:" | "ignore:" => return self.listed(label, reader, model),
            "axiom:" => {
                let axiom = match reader.take("*") {
                    true => Vec::new(),
                    false => strings(&mut reader)?,
                };
                model.axiom = Some((start, axiom));
                return end_of(&mut reader);
            }
            "define:" => {
                return Err(Fault::new(
                    start,
                    "arrays cannot be carried over; expected constants",
                ));
            }
            "start:" | "startblock:" => return start_block(&mut reader, model),
            "starteach:" | "endeach:" | "end:" => return printing_block(&mut reader, start, model),
            "homomorphism" => self.block = Block::Interpret,
            "decomposition" => self.block = Block::Decompose,
            "ringl-system" => {
                return Err(Fault::new(
                    start,
                    "a ring, whose end is the neighbour of its beginning, cannot be carried over",
                ));
            }
            _ => {}
        }
        Ok(())
    }

    fn listed(
        &mut self,
        label: &str,
        mut reader: Reader<'a>,
        model: &mut Model,
    ) -> Result<(), Fault> {
        let mut list = Vec::new();
        let mut brackets = false;
        while !reader.at_end() {
            let module = symbol(&mut reader)?;
            match module.key.as_str() {
                "[" | "]" if label == "ignore:" => {
                    return Err(Fault::new(
                        module.at,
                        "contexts always see brackets; expected other symbols",
                    ));
                }
                "[" | "]" => brackets = true,
                _ => list.push(module),
            }
        }
        if label == "ignore:" {
            model.ignored = list;
        } else {
            self.brackets_considered = brackets;
            model.considered = Some(list);
        }
        Ok(())
    }

    fn production(&self, mut reader: Reader<'a>, model: &mut Model) -> Result<(), Fault> {
        let start = reader.pos();
        let mut left = Vec::new();
        let mut heads = heads(&mut reader)?;
        if reader.take("<") {
            left = heads;
            heads = self::heads(&mut reader)?;
        }
        let mut right = Vec::new();
        if reader.take(">") {
            right = branches(self::heads(&mut reader)?, model)?;
            let first = right.first().map_or(start, |m: &Module| m.at);
            if !self.brackets_considered && !right.is_empty() {
                return Err(Fault::new(
                    first,
                    "with a `consider` that does not list `[ ]`, cpfg's right contexts walk into branches; expected `consider: … [ ]`",
                ));
            }
        }
        if self.block != Block::Main && !(left.is_empty() && right.is_empty()) {
            return Err(Fault::new(
                start,
                "contexts of decompositions and homomorphisms cannot be carried over",
            ));
        }
        let mut heads = heads.into_iter();
        let Some(predecessor) = heads.next() else {
            return Err(reader.expected("a statement of cpfg, or a production with `-->`"));
        };
        if let Some(second) = heads.next() {
            return Err(Fault::new(
                second.at,
                format!(
                    "found `{}`; a production of several modules at once cannot be carried over",
                    second.key
                ),
            ));
        }
        let mut values = Values::new();
        let mut condition = None;
        if reader.take(":") {
            if reader.take("{") {
                assignments(&mut reader, model, &mut values)?;
            }
            let here = reader.clone();
            if reader.take("*") {
                // A condition that always holds.
            } else if !(reader.take("-->") || reader.take("-o>") || reader.take("{")) {
                condition = Some(substitute(&reader.expression()?, &values)?);
            } else {
                reader = here;
            }
            if reader.take("{") {
                assignments(&mut reader, model, &mut values)?;
            }
        }
        let holds = |e: &Expr| matches!(&e.kind, Kind::Number(n) if n.parse::<f64>().is_ok_and(|v| v != 0.0));
        if condition.as_ref().is_some_and(holds) {
            condition = None;
        }
        if reader.take("-o>") {
            model.remark(start, "objects, `-o>`, are plain productions");
        } else if !reader.take("-->") {
            return Err(reader.expected("`-->`"));
        }
        let successor = match reader.take("*") {
            true => Vec::new(),
            false => strings(&mut reader)?,
        };
        let mut weight = None;
        if reader.take(":") {
            weight = Some(reader.expression()?);
        }
        end_of(&mut reader)?;
        let rule = Rule {
            block: self.block,
            left,
            predecessor,
            right,
            condition,
            weight,
            successor,
        };
        let rule = rule.substituted(&|name| value_of(&values, name))?;
        model.add(rule);
        Ok(())
    }

    /// What is known only at the end.
    fn finish(&self, model: &mut Model) {
        // One round, as cpfg takes it.
        if model.decompose_depth.is_none() {
            let one = Node::number(0, "1").ok();
            model.decompose_depth = one.map(|value| Valued { at: 0, value });
        }
        let stochastic = model.seed.is_some();
        let mut count = HashMap::new();
        for rule in model.rules.iter().filter(|r| r.block == Block::Main) {
            let symbol = (
                rule.predecessor.key.clone(),
                rule.predecessor.arguments.len(),
            );
            *count.entry(symbol).or_insert(0_usize) += 1;
        }
        let mut dropped = None;
        for rule in &mut model.rules {
            let at = rule.predecessor.at;
            let symbol = (
                rule.predecessor.key.clone(),
                rule.predecessor.arguments.len(),
            );
            let drawn = stochastic && rule.block == Block::Main;
            if !drawn {
                dropped = dropped.or(rule.weight.take().map(|w| w.at));
            } else if rule.weight.is_none() && count.get(&symbol).is_some_and(|n| *n > 1) {
                rule.weight = Node::number(at, "1").ok();
            }
        }
        if let Some(at) = dropped {
            model.remark(
                at,
                "probabilities without a `seed:`, or in a homomorphism or decomposition; the first production that matches applies, as in cpfg",
            );
        }
        if let Some(steps) = model.steps.clone()
            && uses(model, "Z")
            && !model.is_constant("Z")
        {
            model.constant("Z".to_owned(), steps);
        }
    }
}

/// Whether a production names this.
fn uses(model: &Model, name: &str) -> bool {
    let mut found = false;
    for rule in &model.rules {
        let parameters = rule.successor.iter().flat_map(|m| &m.arguments);
        for part in rule.condition.iter().chain(&rule.weight).chain(parameters) {
            Node::visit(part, &mut |node| {
                found |= matches!(&node.kind, Kind::Name(n) if n == name);
            });
        }
    }
    found
}

/// A `#define` of a number.
fn constant(at: usize, rest: &str, model: &mut Model) -> Result<(), Fault> {
    let Some((name, value)) = rest.trim().split_once(' ') else {
        return Ok(());
    };
    let value = match value.strip_prefix('-') {
        Some(size) => Node::make(at, Kind::Negate(Node::number(at, size)?))?,
        None => Node::number(at, value)?,
    };
    model
        .constants
        .push((name.to_owned(), Valued { at, value }));
    Ok(())
}

fn valued(reader: &mut Reader<'_>) -> Result<Valued, Fault> {
    reader.skip_blank();
    let at = reader.pos();
    let value = reader.expression()?;
    end_of(reader)?;
    Ok(Valued { at, value })
}

pub(super) fn end_of(reader: &mut Reader<'_>) -> Result<(), Fault> {
    match reader.at_end() {
        true => Ok(()),
        false => Err(reader.expected("the end of the line")),
    }
}

/// A symbol without parameters.
fn symbol(reader: &mut Reader<'_>) -> Result<Module, Fault> {
    reader.skip_blank();
    let at = reader.pos();
    let Some(first) = reader.bump() else {
        return Err(reader.expected("a module"));
    };
    let mut key = first.to_string();
    let takes_more = match first {
        '~' => true,
        '?' => reader.peek() != Some('('),
        '@' => true,
        _ => false,
    };
    if takes_more && let Some(second) = reader.peek().filter(|c| !c.is_whitespace()) {
        key.push(second);
        reader.bump();
        // Functions of the turtle that have a second letter, unless parameters follow the first.
        let further = first == '@' && "PTGmDb".contains(second) && reader.peek() != Some('(');
        if further && let Some(third) = reader.peek().filter(|c| c.is_alphabetic()) {
            key.push(third);
            reader.bump();
        }
    }
    if matches!(first, '(' | ')') {
        return Err(Fault::new(
            at,
            format!("found `{first}`; expected a module"),
        ));
    }
    let arguments = Vec::new();
    Ok(Module { key, at, arguments })
}

/// Modules with values, up to `:` or the end.
fn strings(reader: &mut Reader<'_>) -> Result<Vec<Module>, Fault> {
    let mut list = Vec::new();
    while !reader.at_end() && reader.peek() != Some(':') {
        let mut module = symbol(reader)?;
        if reader.take("(") {
            module.arguments = reader.arguments()?;
        }
        list.push(module);
    }
    match list.is_empty() {
        true => Err(reader.expected("modules, or `*` for none")),
        false => Ok(list),
    }
}

/// Modules with names of parameters, up to `<`, `>`, `:` or the arrow; `*` is no context.
fn heads(reader: &mut Reader<'_>) -> Result<Vec<Module>, Fault> {
    let mut list = Vec::new();
    if reader.take("*") {
        return Ok(list);
    }
    loop {
        let rest = match reader.at_end() {
            true => return Ok(list),
            false => reader.rest(),
        };
        let arrow = rest.starts_with("-->") || rest.starts_with("-o>");
        if arrow || rest.starts_with(['<', '>', ':']) {
            return Ok(list);
        }
        let mut module = symbol(reader)?;
        if reader.take("(") {
            module.arguments = formals(reader)?;
        }
        list.push(module);
    }
}

/// A right context: `[H=]`, the beginning of a branch, is our `[H]`.
fn branches(context: Vec<Module>, model: &mut Model) -> Result<Vec<Module>, Fault> {
    let mut kept: Vec<Module> = Vec::with_capacity(context.len());
    let mut rest_skipped = false;
    for module in context {
        match module.key.as_str() {
            "=" => rest_skipped = true,
            "]" if !rest_skipped => {
                return Err(Fault::new(
                    module.at,
                    "a context of a whole branch cannot be carried over; expected `=]`, which leaves the branch's end open",
                ));
            }
            key => {
                if rest_skipped && key != "]" {
                    return Err(Fault::new(
                        module.at,
                        "found a module after `=`; expected `]`",
                    ));
                }
                rest_skipped = false;
                if key == "[" {
                    model.remark(
                        module.at,
                        "cpfg compares `[` in a context with the next branch alone; here one of the next branches may fit",
                    );
                }
                kept.push(module);
            }
        }
    }
    Ok(kept)
}
