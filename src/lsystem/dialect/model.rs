//! What a foreign grammar says, before it is written in our notation: modules under the names that their program gives them.

use std::collections::HashSet;
use std::rc::Rc;

use super::Dialect;
use super::expression::{Binary, Expr, Kind, Node};
use super::reader::Reader;
use super::text::Fault;

/// Modules of a production that becomes several.
const MAX_COPIED: usize = 10_000;
/// Productions that one of another program may become.
const MAX_ALTERNATIVES: usize = 64;
/// Remarks kept; more would not be read.
const MAX_REMARKS: usize = 50;
/// Faults kept; more are cut off by what shows them.
const MAX_FAULTS: usize = 1000;

/// One module as written.
#[derive(Clone, Debug)]
pub(super) struct Module {
    /// Its symbol as the program calls it; other names for the same are replaced.
    pub(super) key: String,
    pub(super) at: usize,
    /// Parameters; in a head each is a name.
    pub(super) arguments: Vec<Expr>,
}

/// Which list a production belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Block {
    Main,
    Decompose,
    Interpret,
}

/// One production.
#[derive(Clone, Debug)]
pub(super) struct Rule {
    pub(super) block: Block,
    pub(super) left: Vec<Module>,
    pub(super) predecessor: Module,
    pub(super) right: Vec<Module>,
    pub(super) condition: Option<Expr>,
    pub(super) weight: Option<Expr>,
    pub(super) successor: Vec<Module>,
}

/// A statement with a value.
#[derive(Clone, Debug)]
pub(super) struct Valued {
    pub(super) at: usize,
    pub(super) value: Expr,
}

/// A declared module with the names of its parameters.
#[derive(Clone, Debug)]
pub(super) struct Declared {
    pub(super) name: String,
    pub(super) formals: Vec<String>,
}

/// What a foreign grammar says.
#[derive(Debug)]
pub(super) struct Model {
    pub(super) dialect: Dialect,
    pub(super) constants: Vec<(String, Valued)>,
    /// Their names.
    known: HashSet<String>,
    pub(super) axiom: Option<(usize, Vec<Module>)>,
    pub(super) steps: Option<Valued>,
    pub(super) seed: Option<Valued>,
    pub(super) angle: Option<Valued>,
    pub(super) ignored: Vec<Module>,
    pub(super) considered: Option<Vec<Module>>,
    pub(super) declared: Vec<Declared>,
    pub(super) rules: Vec<Rule>,
    pub(super) decompose_depth: Option<Valued>,
    pub(super) interpret_depth: Option<Valued>,
    /// Faults: what cannot be carried over and would change the string, and what cannot be understood.
    pub(super) faults: Vec<Fault>,
    /// What cannot be carried over and leaves the string alone.
    pub(super) remarks: Vec<Fault>,
}

impl Model {
    pub(super) fn new(dialect: Dialect) -> Self {
        Self {
            dialect,
            constants: Vec::new(),
            known: HashSet::new(),
            axiom: None,
            steps: None,
            seed: None,
            angle: None,
            ignored: Vec::new(),
            considered: None,
            declared: Vec::new(),
            rules: Vec::new(),
            decompose_depth: None,
            interpret_depth: None,
            faults: Vec::new(),
            remarks: Vec::new(),
        }
    }

    pub(super) fn fault(&mut self, fault: Fault) {
        if self.faults.len() < MAX_FAULTS {
            self.faults.push(fault);
        }
    }

    /// Notes what came out well; faults are kept.
    pub(super) fn kept<T>(&mut self, result: Result<T, Fault>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(fault) => {
                self.fault(fault);
                None
            }
        }
    }

    /// Names something that is not carried over, once.
    pub(super) fn remark(&mut self, at: usize, message: impl Into<String>) {
        let message = message.into();
        if self.remarks.len() < MAX_REMARKS && self.remarks.iter().all(|r| r.message != message) {
            self.remarks.push(Fault { at, message });
        }
    }

    pub(super) fn is_constant(&self, name: &str) -> bool {
        self.known.contains(name)
    }

    pub(super) fn constant(&mut self, name: String, value: Valued) {
        self.known.insert(name.clone());
        self.constants.push((name, value));
    }

    /// Takes a production: choices between two values become productions of their own.
    pub(super) fn add(&mut self, rule: Rule) {
        match without_choices(rule) {
            Ok(rules) => self.rules.extend(rules),
            Err(fault) => self.fault(fault),
        }
    }
}

impl Rule {
    fn expressions(&self) -> impl Iterator<Item = &Expr> {
        let parameters = self.successor.iter().flat_map(|m| m.arguments.iter());
        self.condition
            .iter()
            .chain(self.weight.iter())
            .chain(parameters)
    }

    fn map(&self, change: &dyn Fn(&Expr) -> Result<Expr, Fault>) -> Result<Self, Fault> {
        let mut rule = self.clone();
        for part in rule.condition.iter_mut().chain(rule.weight.iter_mut()) {
            *part = change(part)?;
        }
        for module in &mut rule.successor {
            for argument in &mut module.arguments {
                *argument = change(argument)?;
            }
        }
        Ok(rule)
    }

    /// The production with each name replaced that `value_of` knows.
    pub(super) fn substituted(
        &self,
        value_of: &dyn Fn(&str) -> Option<Expr>,
    ) -> Result<Self, Fault> {
        self.map(&|e| Node::substitute(e, value_of))
    }

    /// A draw that would be made twice where the original makes it once.
    pub(super) fn repeated_draw(&self) -> Option<usize> {
        let mut seen = HashSet::new();
        let mut repeated = None;
        for expression in self.expressions().filter(|e| e.draws) {
            Node::visit(expression, &mut |node| {
                let draw = node.draws && matches!(node.kind, Kind::Call(..));
                if draw && !seen.insert(Rc::as_ptr(node)) {
                    repeated = Some(node.at);
                }
            });
        }
        repeated
    }
}

/// `F(c ? a : b)` as two productions, `c` and not `c`, until there is no choice left.
fn without_choices(rule: Rule) -> Result<Vec<Rule>, Fault> {
    let mut done = Vec::new();
    let mut open = vec![rule];
    while let Some(rule) = open.pop() {
        let mut choice = None;
        let in_condition = |choice: &Expr| {
            let mut found = false;
            if let Some(condition) = &rule.condition {
                Node::visit(condition, &mut |node| found |= Rc::ptr_eq(node, choice));
            }
            found
        };
        for expression in rule.expressions() {
            Node::visit(expression, &mut |node| {
                if choice.is_none() && matches!(node.kind, Kind::If(..)) {
                    choice = Some(Rc::clone(node));
                }
            });
        }
        let Some(choice) = choice else {
            done.push(rule);
            continue;
        };
        let Kind::If(condition, then, otherwise) = &choice.kind else {
            continue;
        };
        if done.len() + open.len() >= MAX_ALTERNATIVES || rule.successor.len() > MAX_COPIED {
            return Err(Fault::new(
                choice.at,
                "this production would become too many; write it as several with a condition each",
            ));
        }
        let not = Node::make(condition.at, Kind::Not(Rc::clone(condition)))?;
        // The last pushed is taken first, so that the order is that of the text.
        for (value, holds) in [(otherwise, &not), (then, condition)] {
            let mut one = rule.map(&|e| Node::with(e, &choice, value))?;
            // What a condition chooses by is computed before the rest of it.
            one.condition = Some(match &one.condition {
                Some(rest) if in_condition(&choice) => both(Some(holds), rest)?,
                rest => both(rest.as_ref(), holds)?,
            });
            open.push(one);
        }
    }
    Ok(done)
}

/// A condition and another.
pub(super) fn both(first: Option<&Expr>, second: &Expr) -> Result<Expr, Fault> {
    match first {
        None => Ok(Rc::clone(second)),
        Some(first) => Node::binary(second.at, Binary::And, first, second),
    }
}

/// The parameters of a module in a head, which must be names.
pub(super) fn formals(reader: &mut Reader<'_>) -> Result<Vec<Expr>, Fault> {
    let list = reader.arguments()?;
    for argument in &list {
        if !matches!(argument.kind, Kind::Name(_)) {
            return Err(Fault::new(
                argument.at,
                "found a value; expected the name of a parameter, which a condition can test",
            ));
        }
    }
    Ok(list)
}
