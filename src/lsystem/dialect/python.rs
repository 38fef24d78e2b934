//! The Python of a rule: which modules it produces under which conditions.
//!
//! A rule's code is followed along every way through its `if`s. Each way that produces something becomes a production; names that were given
//! a value on the way are replaced by it. A way that produces nothing lets the next rule try, as in L-Py. `if random() < p` becomes two weights.

use std::collections::HashMap;
use std::rc::Rc;

use super::expression::{Binary, Expr, Kind, Node};
use super::lpy;
use super::model::{Model, Module, Rule, both};
use super::reader::Reader;
use super::text::Fault;
use super::words::Words;

/// Ways through one rule's code.
const MAX_WAYS: usize = 64;
/// Modules that are copied from way to way.
const MAX_COPIED: usize = 10_000;
/// Blocks within blocks.
const MAX_NESTING: usize = 20;

/// One statement.
enum Statement {
    /// Conditions with what follows on each, and what follows otherwise.
    If(Vec<(Expr, Vec<Self>)>, Vec<Self>),
    /// Modules, and whether the rule ends there.
    Produce(Vec<Module>, bool),
    Assign(String, Expr),
    Return,
}

/// A logical line.
#[derive(Clone, Copy, Debug)]
struct Line {
    indent: usize,
    start: usize,
    end: usize,
}

/// Reads the code behind a rule's colon and adds its productions.
pub(super) fn rules(
    reader: Reader<'_>,
    words: &Words,
    rule: &Rule,
    model: &mut Model,
) -> Result<(), Fault> {
    let mut code = Code {
        lines: lines(&reader),
        next: 0,
        reader,
        words,
    };
    let statements = code.block(0, 0)?;
    let random = chances(&statements);
    let way = Way {
        condition: None,
        weight: None,
        values: HashMap::new(),
        made: Vec::new(),
        produced: false,
        done: false,
    };
    let ways = run(&statements, way, random)?;
    for way in ways {
        if !way.produced {
            if random {
                return Err(Fault::new(
                    rule.predecessor.at,
                    "with chances, each way through the code must produce something to be carried over",
                ));
            }
            continue;
        }
        model.add(Rule {
            condition: way.condition,
            weight: way.weight,
            successor: way.made,
            ..rule.clone()
        });
    }
    Ok(())
}

/// Logical lines: a line goes on after a `\` and while a parenthesis is open.
fn lines(reader: &Reader<'_>) -> Vec<Line> {
    let mut found: Vec<Line> = Vec::new();
    let mut at = reader.pos();
    let mut open = 0_usize;
    let mut goes_on = false;
    let mut first = true;
    for line in reader.rest().split_inclusive('\n') {
        let start = at;
        at += line.len();
        let code = line.trim_end();
        let trimmed = code.trim_start();
        if !goes_on && (trimmed.is_empty() || trimmed.starts_with('#')) {
            first = false;
            continue;
        }
        let end = start + code.len();
        let begin = end - trimmed.len();
        // What follows the colon on the rule's own line is a block of its own.
        let indent = match first {
            true => usize::MAX,
            false => code.len() - trimmed.len(),
        };
        match found.last_mut().filter(|_| goes_on || open > 0) {
            Some(last) => last.end = end,
            None => {
                open = 0;
                found.push(Line {
                    indent,
                    start: begin,
                    end,
                });
            }
        }
        first = false;
        for c in trimmed.split('#').next().unwrap_or("").bytes() {
            match c {
                b'(' => open += 1,
                b')' => open = open.saturating_sub(1),
                _ => {}
            }
        }
        goes_on = trimmed.ends_with('\\');
    }
    found
}

struct Code<'a, 'w> {
    reader: Reader<'a>,
    words: &'w Words,
    lines: Vec<Line>,
    next: usize,
}

impl<'a> Code<'a, '_> {
    fn at(&self, line: Line) -> Reader<'a> {
        self.reader.within(line.start, line.end)
    }

    /// Statements that are indented at least so far.
    fn block(&mut self, least: usize, depth: usize) -> Result<Vec<Statement>, Fault> {
        let mut list = Vec::new();
        let mut own = None;
        while let Some(line) = self.lines.get(self.next).copied() {
            let indent = *own.get_or_insert(line.indent);
            if line.indent < least || line.indent < indent {
                break;
            }
            if line.indent > indent {
                return Err(Fault::new(
                    line.start,
                    "this line is indented further than the one before",
                ));
            }
            if depth > MAX_NESTING {
                return Err(Fault::new(
                    line.start,
                    format!("this code nests deeper than {MAX_NESTING}"),
                ));
            }
            self.next += 1;
            self.statement(line, depth, &mut list)?;
        }
        Ok(list)
    }

    fn statement(
        &mut self,
        line: Line,
        depth: usize,
        list: &mut Vec<Statement>,
    ) -> Result<(), Fault> {
        let mut reader = self.at(line);
        if !reader.take_word("if") {
            return simple(&mut reader, self.words, list);
        }
        let mut cases = Vec::new();
        let condition = reader.expression()?;
        let body = self.body(reader, line, depth)?;
        cases.push((condition, body));
        let mut otherwise = Vec::new();
        while let Some(next) = self
            .lines
            .get(self.next)
            .copied()
            .filter(|n| n.indent == line.indent)
        {
            let mut reader = self.at(next);
            if reader.take_word("elif") {
                self.next += 1;
                let condition = reader.expression()?;
                let body = self.body(reader, next, depth)?;
                cases.push((condition, body));
            } else if reader.take_word("else") {
                self.next += 1;
                otherwise = self.body(reader, next, depth)?;
                break;
            } else {
                break;
            }
        }
        list.push(Statement::If(cases, otherwise));
        Ok(())
    }

    /// What stands behind a colon: on the same line, or indented below.
    fn body(
        &mut self,
        mut reader: Reader<'a>,
        line: Line,
        depth: usize,
    ) -> Result<Vec<Statement>, Fault> {
        if !reader.take(":") {
            return Err(reader.expected("`:`"));
        }
        if reader.at_end() {
            let body = self.block(line.indent.saturating_add(1), depth + 1)?;
            return match body.is_empty() {
                true => Err(reader.expected("an indented block")),
                false => Ok(body),
            };
        }
        let mut list = Vec::new();
        simple(&mut reader, self.words, &mut list)?;
        Ok(list)
    }
}

/// A statement without a block.
fn simple(reader: &mut Reader<'_>, words: &Words, list: &mut Vec<Statement>) -> Result<(), Fault> {
    reader.skip_blank();
    let at = reader.pos();
    let code = || {
        Fault::new(
            at,
            "this Python code cannot be carried over; expected `if`, `produce` and assignments of numbers",
        )
    };
    for (word, ends) in [("produce", true), ("nproduce", false)] {
        if reader.take_word(word) {
            list.push(Statement::Produce(lpy::string(reader, words)?, ends));
            return Ok(());
        }
    }
    if reader.take_word("pass") {
        return Ok(());
    }
    if reader.take_word("return") {
        if !(reader.at_end() || reader.take_word("None")) {
            return Err(code());
        }
        list.push(Statement::Return);
        return Ok(());
    }
    let name = reader.word().ok_or_else(code)?.to_owned();
    let own = Node::make(at, Kind::Name(name.clone()))?;
    for (token, op) in [
        ("+=", Binary::Add),
        ("-=", Binary::Subtract),
        ("*=", Binary::Multiply),
        ("/=", Binary::Divide),
    ] {
        if reader.take(token) {
            let value = Node::binary(at, op, &own, &reader.expression()?)?;
            list.push(Statement::Assign(name, value));
            return ended(reader);
        }
    }
    if !reader.take("=") || reader.rest().starts_with('=') {
        return Err(code());
    }
    list.push(Statement::Assign(name, reader.expression()?));
    ended(reader)
}

fn ended(reader: &mut Reader<'_>) -> Result<(), Fault> {
    match reader.at_end() {
        true => Ok(()),
        false => Err(reader.expected("the end of the line")),
    }
}

/// Whether chance decides somewhere.
fn chances(statements: &[Statement]) -> bool {
    statements.iter().any(|s| match s {
        Statement::If(cases, otherwise) => {
            cases
                .iter()
                .any(|(c, body)| chance(c).is_some() || chances(body))
                || chances(otherwise)
        }
        _ => false,
    })
}

/// `p` of `random() < p` and `p > random()`.
fn chance(condition: &Expr) -> Option<&Expr> {
    let unit = |e: &Expr| {
        let Kind::Call("uniform", list) = &e.kind else {
            return false;
        };
        let is = |e: &Expr, value: &str| matches!(&e.kind, Kind::Number(n) if n == value);
        matches!(list.as_slice(), [a, b] if is(a, "0") && is(b, "1"))
    };
    match &condition.kind {
        Kind::Binary(Binary::Less | Binary::LessEqual, a, p) if unit(a) && !p.draws => Some(p),
        Kind::Binary(Binary::Greater | Binary::GreaterEqual, p, a) if unit(a) && !p.draws => {
            Some(p)
        }
        _ => None,
    }
}

/// One way through the code.
#[derive(Clone)]
struct Way {
    condition: Option<Expr>,
    weight: Option<Expr>,
    values: HashMap<String, Expr>,
    made: Vec<Module>,
    produced: bool,
    done: bool,
}

impl Way {
    fn value(&self, expression: &Expr) -> Result<Expr, Fault> {
        Node::substitute(expression, &|name| self.values.get(name).map(Rc::clone))
    }

    fn holding(&self, condition: &Expr) -> Result<Self, Fault> {
        let condition = Some(both(self.condition.as_ref(), condition)?);
        Ok(Self {
            condition,
            ..self.clone()
        })
    }

    fn weighted(&self, chance: &Expr) -> Result<Self, Fault> {
        let weight = match &self.weight {
            None => Rc::clone(chance),
            Some(weight) => Node::binary(chance.at, Binary::Multiply, weight, chance)?,
        };
        Ok(Self {
            weight: Some(weight),
            ..self.clone()
        })
    }

    /// Whether a production takes this way and nothing is left over for a later one.
    fn is_whole(&self) -> bool {
        self.done && self.produced
    }
}

/// All ways through statements, in the order in which their productions go.
fn run(statements: &[Statement], way: Way, random: bool) -> Result<Vec<Way>, Fault> {
    let mut ways = vec![way];
    for statement in statements {
        let mut next = Vec::new();
        for mut way in ways {
            if way.done {
                next.push(way);
                continue;
            }
            match statement {
                Statement::If(cases, otherwise) => {
                    next.extend(branch(cases, otherwise, way, random)?)
                }
                Statement::Produce(modules, ends) => {
                    for module in modules {
                        let mut module = module.clone();
                        for argument in &mut module.arguments {
                            *argument = way.value(argument)?;
                        }
                        way.made.push(module);
                    }
                    way.produced = true;
                    way.done = *ends;
                    next.push(way);
                }
                Statement::Assign(name, value) => {
                    let value = way.value(value)?;
                    way.values.insert(name.clone(), value);
                    next.push(way);
                }
                Statement::Return => {
                    way.done = true;
                    next.push(way);
                }
            }
            let copied: usize = next.iter().map(|w| w.made.len()).sum();
            if next.len() > MAX_WAYS || (next.len() > 1 && copied > MAX_COPIED) {
                return Err(Fault::new(
                    next.iter()
                        .find_map(|w| w.condition.as_ref())
                        .map_or(0, |c| c.at),
                    format!(
                        "there are more than {MAX_WAYS} ways through this code; expected fewer `if`s"
                    ),
                ));
            }
        }
        ways = next;
    }
    Ok(ways)
}

fn branch(
    cases: &[(Expr, Vec<Statement>)],
    otherwise: &[Statement],
    way: Way,
    random: bool,
) -> Result<Vec<Way>, Fault> {
    let mut ways = Vec::new();
    let mut pending = way;
    for (condition, body) in cases {
        let condition = pending.value(condition)?;
        if let Some(chance) = chance(&condition) {
            ways.extend(run(body, pending.weighted(chance)?, random)?);
            let one = Node::number(chance.at, "1")?;
            let rest = Node::binary(chance.at, Binary::Subtract, &one, chance)?;
            pending = pending.weighted(&rest)?;
            continue;
        }
        let taken = run(body, pending.holding(&condition)?, random)?;
        // Where the production before has taken all that the condition holds for, the next need not say so.
        let whole = !random && taken.iter().all(Way::is_whole);
        ways.extend(taken);
        if !whole {
            let not = Node::make(condition.at, Kind::Not(condition))?;
            pending = pending.holding(&not)?;
        }
        if ways.len() > MAX_WAYS {
            break;
        }
    }
    ways.extend(run(otherwise, pending, random)?);
    Ok(ways)
}
