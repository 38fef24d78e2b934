//! Expressions of another program as a tree, and their print in our notation.
//!
//! Programs differ in how strongly operators bind (cpfg reads `-2^2` as 4), so what is read becomes a tree and is printed with the
//! parentheses that our notation needs: every operation is computed in the order of the original. Trees share parts where a name was
//! replaced by its value; depth and size are bounded when a node is made, so every walk over a tree is.

use std::rc::Rc;

use super::text::{Fault, Writer};

/// Nodes within nodes.
const MAX_DEPTH: u16 = 120;
/// Nodes of one expression, shared ones counted as often as they stand in it.
const MAX_SIZE: u32 = 20_000;

pub(super) type Expr = Rc<Node>;

/// One node of an expression.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) at: usize,
    pub(super) kind: Kind,
    depth: u16,
    size: u32,
    /// Whether there is a random draw in it.
    pub(super) draws: bool,
}

#[derive(Debug)]
pub(super) enum Kind {
    /// As our notation writes it.
    Number(String),
    Name(String),
    /// A text in quotes, which only some turtle commands take.
    Text(String),
    Negate(Expr),
    Not(Expr),
    Binary(Binary, Expr, Expr),
    /// One of our functions.
    Call(&'static str, Vec<Expr>),
    /// Condition, value where it holds, value otherwise.
    If(Expr, Expr, Expr),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Binary {
    Or,
    And,
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
    Power,
}

/// How strongly a comparison binds in our notation, a sign, a power and whatever needs no parentheses.
const COMPARISON: u8 = 3;
const SIGN: u8 = 6;
const POWER: u8 = 7;
const WHOLE: u8 = 9;

impl Binary {
    fn token(self) -> &'static str {
        match self {
            Self::Or => " || ",
            Self::And => " && ",
            Self::Equal => " == ",
            Self::NotEqual => " != ",
            Self::Less => " < ",
            Self::LessEqual => " <= ",
            Self::Greater => " > ",
            Self::GreaterEqual => " >= ",
            Self::Add => " + ",
            Self::Subtract => " - ",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Remainder => " % ",
            Self::Power => "^",
        }
    }

    fn binds(self) -> u8 {
        match self {
            Self::Or => 1,
            Self::And => 2,
            Self::Add | Self::Subtract => 4,
            Self::Multiply | Self::Divide | Self::Remainder => 5,
            Self::Power => POWER,
            _ => COMPARISON,
        }
    }
}

/// Functions of our notation that draw at random.
const DRAWS: [&str; 5] = ["uniform", "normal", "lognormal", "integer", "chance"];

impl Kind {
    fn parts(&self) -> Vec<&Expr> {
        match self {
            Self::Number(_) | Self::Name(_) | Self::Text(_) => Vec::new(),
            Self::Negate(a) | Self::Not(a) => vec![a],
            Self::Binary(_, a, b) => vec![a, b],
            Self::If(a, b, c) => vec![a, b, c],
            Self::Call(_, list) => list.iter().collect(),
        }
    }
}

impl Node {
    /// A node of bounded depth and size.
    pub(super) fn make(at: usize, kind: Kind) -> Result<Expr, Fault> {
        let (mut depth, mut size, mut draws) = (0_u16, 1_u32, false);
        for part in kind.parts() {
            depth = depth.max(part.depth);
            size = size.saturating_add(part.size);
            draws |= part.draws;
        }
        if let Kind::Call(name, _) = &kind {
            draws |= DRAWS.contains(name);
        }
        if depth >= MAX_DEPTH || size > MAX_SIZE {
            return Err(Fault::new(
                at,
                "this expression is too long to be carried over; give parts of it a name",
            ));
        }
        let depth = depth + 1;
        Ok(Rc::new(Self {
            at,
            kind,
            depth,
            size,
            draws,
        }))
    }

    pub(super) fn number(at: usize, value: &str) -> Result<Expr, Fault> {
        Self::make(at, Kind::Number(value.to_owned()))
    }

    pub(super) fn binary(at: usize, op: Binary, a: &Expr, b: &Expr) -> Result<Expr, Fault> {
        Self::make(at, Kind::Binary(op, Rc::clone(a), Rc::clone(b)))
    }

    pub(super) fn call(at: usize, name: &'static str, list: &[&Expr]) -> Result<Expr, Fault> {
        Self::make(
            at,
            Kind::Call(name, list.iter().map(|e| Rc::clone(e)).collect()),
        )
    }

    /// The same with each name replaced that `value_of` knows.
    pub(super) fn substitute(
        this: &Expr,
        value_of: &dyn Fn(&str) -> Option<Expr>,
    ) -> Result<Expr, Fault> {
        Self::map(this, &|node| match &node.kind {
            Kind::Name(name) => value_of(name),
            _ => None,
        })
    }

    /// The same with the node `of` replaced.
    pub(super) fn with(this: &Expr, of: &Expr, by: &Expr) -> Result<Expr, Fault> {
        Self::map(this, &|node| Rc::ptr_eq(node, of).then(|| Rc::clone(by)))
    }

    fn map(this: &Expr, change: &dyn Fn(&Expr) -> Option<Expr>) -> Result<Expr, Fault> {
        if let Some(changed) = change(this) {
            return Ok(changed);
        }
        let map = |part: &Expr| Self::map(part, change);
        let kind = match &this.kind {
            Kind::Number(_) | Kind::Name(_) | Kind::Text(_) => return Ok(Rc::clone(this)),
            Kind::Negate(a) => Kind::Negate(map(a)?),
            Kind::Not(a) => Kind::Not(map(a)?),
            Kind::Binary(op, a, b) => Kind::Binary(*op, map(a)?, map(b)?),
            Kind::If(a, b, c) => Kind::If(map(a)?, map(b)?, map(c)?),
            Kind::Call(name, list) => {
                Kind::Call(name, list.iter().map(map).collect::<Result<_, _>>()?)
            }
        };
        Self::make(this.at, kind)
    }

    /// Visits all nodes, shared ones as often as they stand in it.
    pub(super) fn visit(this: &Expr, see: &mut dyn FnMut(&Expr)) {
        see(this);
        for part in this.kind.parts() {
            Self::visit(part, see);
        }
    }

    fn binds(&self) -> u8 {
        match &self.kind {
            Kind::Negate(_) => SIGN,
            Kind::Binary(op, ..) => op.binds(),
            Kind::Not(_) => POWER + 1,
            _ => WHOLE,
        }
    }

    /// Writes the expression.
    pub(super) fn write(&self, out: &mut Writer) -> Result<(), Fault> {
        self.write_at(out, 0)
    }

    /// With parentheses if it binds less strongly than `least`.
    fn write_at(&self, out: &mut Writer, least: u8) -> Result<(), Fault> {
        let wrapped = self.binds() < least;
        if wrapped {
            out.put("(", self.at);
        }
        match &self.kind {
            Kind::Number(text) | Kind::Name(text) => out.put(text, self.at),
            Kind::Text(_) => {
                return Err(Fault::new(
                    self.at,
                    "found a text; expected a number, which every parameter is here",
                ));
            }
            Kind::Negate(a) => {
                out.put("-", self.at);
                a.write_at(out, POWER)?;
            }
            Kind::Not(a) => {
                out.put("!", self.at);
                a.write_at(out, WHOLE)?;
            }
            Kind::Binary(op, a, b) => {
                let binds = op.binds();
                let left = match op {
                    Binary::Power => WHOLE,
                    _ if binds == COMPARISON => binds + 1,
                    _ => binds,
                };
                a.write_at(out, left)?;
                out.put(op.token(), self.at);
                b.write_at(out, if binds == POWER { POWER } else { binds + 1 })?;
            }
            Kind::Call(name, list) => {
                out.put(name, self.at);
                for (i, part) in list.iter().enumerate() {
                    out.put(if i == 0 { "(" } else { ", " }, part.at);
                    part.write_at(out, 0)?;
                }
                out.put(")", self.at);
            }
            Kind::If(..) => {
                return Err(Fault::new(
                    self.at,
                    "a choice between two values cannot stand here; write two productions with a condition each",
                ));
            }
        }
        if wrapped {
            out.put(")", self.at);
        }
        Ok(())
    }
}
