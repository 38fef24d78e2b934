//! Reads a stretch of foreign text: words, numbers and expressions in the grammar of each program.
//!
//! Precedence climbing with a table for each dialect. Recursion is bounded by [`MAX_NESTING`], and the trees that come out by
//! their own limits.

use super::Dialect;
use super::expression::{Binary, Expr, Kind, Node};
use super::functions;
use super::text::Fault;

/// Parentheses within parentheses.
const MAX_NESTING: usize = 60;
/// Arguments of one function or module.
pub(super) const MAX_ARGUMENTS: usize = 64;

/// Reads the bytes from `pos` to `end`.
#[derive(Clone, Debug)]
pub(super) struct Reader<'a> {
    text: &'a str,
    pos: usize,
    end: usize,
    pub(super) dialect: Dialect,
    nesting: usize,
}

impl<'a> Reader<'a> {
    pub(super) fn new(text: &'a str, dialect: Dialect, start: usize, end: usize) -> Self {
        Self {
            text,
            pos: start,
            end,
            dialect,
            nesting: 0,
        }
    }

    /// A reader of another stretch of the same text.
    pub(super) fn within(&self, start: usize, end: usize) -> Self {
        Self::new(self.text, self.dialect, start, end)
    }

    pub(super) fn pos(&self) -> usize {
        self.pos
    }

    pub(super) fn rest(&self) -> &'a str {
        self.text.get(self.pos..self.end).unwrap_or("")
    }

    pub(super) fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    pub(super) fn bump(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.pos += c.len_utf8();
        Some(c)
    }

    pub(super) fn advance(&mut self, bytes: usize) {
        self.pos = (self.pos + bytes).min(self.end);
    }

    /// Skips blanks, line ends, and in Python comments.
    pub(super) fn skip_blank(&mut self) {
        while let Some(c) = self.peek() {
            if c.is_whitespace() || c == '\u{feff}' {
                self.bump();
            } else if c == '#' && self.dialect == Dialect::Lpy {
                let rest = self.rest();
                self.advance(rest.find('\n').unwrap_or(rest.len()));
            } else if c == '\\' && self.dialect == Dialect::Lpy && self.rest().starts_with("\\\n") {
                self.advance(2);
            } else {
                break;
            }
        }
    }

    pub(super) fn at_end(&mut self) -> bool {
        self.skip_blank();
        self.pos >= self.end
    }

    /// Skips blanks, then `token` if it stands there.
    pub(super) fn take(&mut self, token: &str) -> bool {
        self.skip_blank();
        let here = self.rest().starts_with(token);
        if here {
            self.advance(token.len());
        }
        here
    }

    /// The same for a word, which must end there.
    pub(super) fn take_word(&mut self, word: &str) -> bool {
        let mut ahead = self.clone();
        let here = ahead.word() == Some(word);
        if here {
            *self = ahead;
        }
        here
    }

    /// Skips blanks, then reads letters, digits and `_`, not beginning with a digit.
    pub(super) fn word(&mut self) -> Option<&'a str> {
        self.skip_blank();
        let rest = self.rest();
        let first = rest.chars().next()?;
        if !(first.is_alphabetic() || first == '_') {
            return None;
        }
        let length = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        self.advance(length);
        rest.get(..length)
    }

    /// A fault here: what was found and what was expected.
    pub(super) fn expected(&mut self, what: &str) -> Fault {
        self.skip_blank();
        let found = match self.peek() {
            None => "the end of the line".to_owned(),
            Some(c) if c.is_alphanumeric() || c == '_' => {
                let word: String = self
                    .rest()
                    .chars()
                    .take_while(|c| c.is_alphanumeric() || *c == '_')
                    .take(40)
                    .collect();
                format!("`{word}`")
            }
            Some(c) if c.is_control() => format!("the control character U+{:04X}", u32::from(c)),
            Some(c) => format!("`{c}`"),
        };
        Fault::new(self.pos, format!("found {found}; expected {what}"))
    }

    /// An expression.
    pub(super) fn expression(&mut self) -> Result<Expr, Fault> {
        self.enter()?;
        let value = self.binary(0)?;
        let choice = match self.dialect {
            Dialect::Lpy => self.take_word("if").then_some("else"),
            _ => self.take("?").then_some(":"),
        };
        let whole = match choice {
            None => value,
            Some("else") => {
                let condition = self.binary(0)?;
                if !self.take_word("else") {
                    return Err(self.expected("`else`"));
                }
                let otherwise = self.expression()?;
                Node::make(value.at, Kind::If(condition, value, otherwise))?
            }
            Some(token) => {
                let then = self.expression()?;
                if !self.take(token) {
                    return Err(self.expected("`:`"));
                }
                let otherwise = self.expression()?;
                Node::make(value.at, Kind::If(value, then, otherwise))?
            }
        };
        self.nesting -= 1;
        Ok(whole)
    }

    fn enter(&mut self) -> Result<(), Fault> {
        self.nesting += 1;
        if self.nesting > MAX_NESTING {
            return Err(Fault::new(
                self.pos,
                format!("this expression nests deeper than {MAX_NESTING}"),
            ));
        }
        Ok(())
    }

    /// The operator that stands here, its length and how strongly it binds.
    fn infix(&mut self) -> Result<Option<(Infix, usize, u8)>, Fault> {
        self.skip_blank();
        let rest = self.rest();
        if rest.starts_with("-->") || rest.starts_with("-o>") || rest.starts_with("-static->") {
            return Ok(None);
        }
        let table: &[(&str, Infix, u8)] = match self.dialect {
            Dialect::Lpy => PYTHON,
            Dialect::Cpfg => C_LIKE,
            Dialect::Houdini => HOUDINI,
        };
        for (token, infix, binds) in table {
            if !rest.starts_with(token) {
                continue;
            }
            let goes_on = rest
                .get(token.len()..)
                .and_then(|after| after.chars().next())
                .is_some_and(|c| c.is_alphanumeric() || c == '_');
            if token.chars().all(char::is_alphabetic) && goes_on {
                continue;
            }
            if *infix == Infix::Refused {
                return Err(Fault::new(
                    self.pos,
                    format!("the operator `{token}` cannot be carried over"),
                ));
            }
            return Ok(Some((*infix, token.len(), *binds)));
        }
        Ok(None)
    }

    /// An expression of operators that bind more strongly than `above`.
    fn binary(&mut self, above: u8) -> Result<Expr, Fault> {
        self.enter()?;
        let mut left = self.prefix()?;
        // For Python's `a < b < c`: the last thing compared, and how strongly a comparison binds.
        let mut compared: Option<Expr> = None;
        while let Some((infix, length, binds)) = self.infix()? {
            if binds <= above {
                break;
            }
            let at = self.pos;
            self.advance(length);
            let to_the_right = infix == Plain(Binary::Power) && self.dialect != Dialect::Cpfg;
            if to_the_right && self.dialect == Dialect::Houdini && is_power_or_sign(&left) {
                return Err(Fault::new(
                    at,
                    "it is not told which of these goes first; put parentheses round one of them",
                ));
            }
            let right = self.binary(if to_the_right { binds - 1 } else { binds })?;
            left = match infix {
                Plain(op) if self.dialect == Dialect::Lpy && is_comparison(op) => {
                    let first = compared.replace(std::rc::Rc::clone(&right));
                    match first {
                        None => Node::binary(at, op, &left, &right)?,
                        Some(middle) => {
                            let next = Node::binary(at, op, &middle, &right)?;
                            Node::binary(at, Binary::And, &left, &next)?
                        }
                    }
                }
                Plain(Binary::Remainder) => functions::remainder(self.dialect, at, &left, &right)?,
                Plain(op) => Node::binary(at, op, &left, &right)?,
                Infix::FloorDivide => {
                    let quotient = Node::binary(at, Binary::Divide, &left, &right)?;
                    Node::call(at, "floor", &[&quotient])?
                }
                Infix::Refused => return Err(Fault::new(at, "this cannot be carried over")),
            };
        }
        self.nesting -= 1;
        Ok(left)
    }

    /// Signs and `!` or `not` with what they belong to.
    fn prefix(&mut self) -> Result<Expr, Fault> {
        self.skip_blank();
        let at = self.pos;
        let python = self.dialect == Dialect::Lpy;
        if python && self.take_word("not") {
            let value = self.binary(PYTHON_NOT)?;
            return Node::make(at, Kind::Not(value));
        }
        if self.take("-") {
            let value = match self.dialect {
                // Python and Houdini: a power first, then the sign.
                Dialect::Lpy | Dialect::Houdini => self.binary(SIGN)?,
                Dialect::Cpfg => self.nested_prefix()?,
            };
            return Node::make(at, Kind::Negate(value));
        }
        if python && self.take("+") {
            return self.binary(SIGN);
        }
        if !python && !self.rest().starts_with("!=") && self.take("!") {
            let value = self.nested_prefix()?;
            return Node::make(at, Kind::Not(value));
        }
        self.primary()
    }

    fn nested_prefix(&mut self) -> Result<Expr, Fault> {
        self.enter()?;
        let value = self.prefix()?;
        self.nesting -= 1;
        Ok(value)
    }

    fn primary(&mut self) -> Result<Expr, Fault> {
        if self.take("(") {
            let inner = self.expression()?;
            if !self.take(")") {
                return Err(self.expected("`)`"));
            }
            return Ok(inner);
        }
        let at = self.pos;
        if let Some(name) = self.name() {
            if self.take("(") {
                let list = self.arguments()?;
                return functions::call(self.dialect, at, &name, &list);
            }
            return functions::name(self.dialect, at, name);
        }
        match self.peek() {
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(quote @ ('"' | '\'')) => self.quoted(quote),
            Some('[' | '{') if self.dialect == Dialect::Lpy => Err(Fault::new(
                at,
                "lists, tuples and dictionaries cannot be carried over; every value is a number here",
            )),
            _ => Err(self.expected("a number, a name or `(`")),
        }
    }

    /// A name, in Python with the names before its dots.
    fn name(&mut self) -> Option<String> {
        let mut name = self.word()?.to_owned();
        while self.dialect == Dialect::Lpy && self.rest().starts_with('.') {
            let mut ahead = self.clone();
            ahead.advance(1);
            let Some(part) = ahead.word() else { break };
            name.push('.');
            name.push_str(part);
            *self = ahead;
        }
        Some(name)
    }

    /// What stands between parentheses, the closing one taken too.
    pub(super) fn arguments(&mut self) -> Result<Vec<Expr>, Fault> {
        let mut list = Vec::new();
        if self.take(")") {
            return Ok(list);
        }
        loop {
            if list.len() >= MAX_ARGUMENTS {
                return Err(self.expected("`)`, since there are too many values already"));
            }
            list.push(self.expression()?);
            if self.take(")") {
                return Ok(list);
            }
            if !self.take(",") {
                return Err(self.expected("`,` or `)`"));
            }
        }
    }

    fn quoted(&mut self, quote: char) -> Result<Expr, Fault> {
        let at = self.pos;
        self.bump();
        let rest = self.rest();
        let closed = |length: &usize| rest.as_bytes().get(*length) != Some(&b'\n');
        let Some(length) = rest.find([quote, '\n']).filter(closed) else {
            return Err(Fault::new(
                at,
                format!("this text is not closed; expected `{quote}`"),
            ));
        };
        let text = rest.get(..length).unwrap_or("").to_owned();
        self.advance(length + 1);
        Node::make(at, Kind::Text(text))
    }

    fn number(&mut self) -> Result<Expr, Fault> {
        let at = self.pos;
        let rest = self.rest();
        let bytes = rest.as_bytes();
        let python = self.dialect == Dialect::Lpy;
        let digits = |from: usize| {
            bytes
                .iter()
                .skip(from)
                .take_while(|b| b.is_ascii_digit() || (python && **b == b'_'))
                .count()
        };
        let mut length = digits(0);
        if bytes.get(length) == Some(&b'.') {
            length += 1;
            length += digits(length);
        }
        if matches!(bytes.get(length), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(length + 1), Some(b'+' | b'-')));
            let exponent = digits(length + 1 + sign);
            if exponent > 0 {
                length += 1 + sign + exponent;
            }
        }
        let text: String = rest.chars().take(length).filter(|c| *c != '_').collect();
        self.advance(length);
        let known = text.parse::<f64>().is_ok_and(f64::is_finite);
        if !known || self.peek().is_some_and(|c| c.is_alphanumeric() || c == '_') {
            return Err(Fault::new(at, "this is no decimal number"));
        }
        Node::number(at, &text)
    }
}

fn is_comparison(op: Binary) -> bool {
    use Binary::{Equal, Greater, GreaterEqual, Less, LessEqual, NotEqual};
    matches!(
        op,
        Equal | NotEqual | Less | LessEqual | Greater | GreaterEqual
    )
}

fn is_power_or_sign(left: &Expr) -> bool {
    matches!(left.kind, Kind::Binary(Binary::Power, ..) | Kind::Negate(_))
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Infix {
    Plain(Binary),
    FloorDivide,
    /// Known, and not to be had here.
    Refused,
}

use Infix::Plain;

/// What binds more strongly than Python's `not`, and than a sign.
const PYTHON_NOT: u8 = 2;
const SIGN: u8 = 9;

/// Longer tokens first.
const PYTHON: &[(&str, Infix, u8)] = &[
    ("or", Plain(Binary::Or), 1),
    ("and", Plain(Binary::And), 2),
    ("==", Plain(Binary::Equal), 3),
    ("!=", Plain(Binary::NotEqual), 3),
    ("<<", Infix::Refused, 3),
    (">>", Infix::Refused, 3),
    ("<=", Plain(Binary::LessEqual), 3),
    (">=", Plain(Binary::GreaterEqual), 3),
    ("<", Plain(Binary::Less), 3),
    (">", Plain(Binary::Greater), 3),
    ("in", Infix::Refused, 3),
    ("is", Infix::Refused, 3),
    ("+", Plain(Binary::Add), 7),
    ("-", Plain(Binary::Subtract), 7),
    ("**", Plain(Binary::Power), 10),
    ("//", Infix::FloorDivide, 8),
    ("*", Plain(Binary::Multiply), 8),
    ("/", Plain(Binary::Divide), 8),
    ("%", Plain(Binary::Remainder), 8),
    ("@", Infix::Refused, 8),
    ("^", Infix::Refused, 5),
    ("|", Infix::Refused, 4),
    ("&", Infix::Refused, 6),
    ("[", Infix::Refused, 10),
    (".", Infix::Refused, 10),
];

/// cpfg's: a power groups to the left and binds less strongly than a sign.
const C_LIKE: &[(&str, Infix, u8)] = &[
    ("||", Plain(Binary::Or), 1),
    ("&&", Plain(Binary::And), 2),
    ("==", Plain(Binary::Equal), 3),
    ("!=", Plain(Binary::NotEqual), 3),
    ("<>", Plain(Binary::NotEqual), 3),
    ("<=", Plain(Binary::LessEqual), 4),
    (">=", Plain(Binary::GreaterEqual), 4),
    ("<", Plain(Binary::Less), 4),
    (">", Plain(Binary::Greater), 4),
    ("+", Plain(Binary::Add), 5),
    ("-", Plain(Binary::Subtract), 5),
    ("*", Plain(Binary::Multiply), 6),
    ("/", Plain(Binary::Divide), 6),
    ("%", Plain(Binary::Remainder), 6),
    ("^", Plain(Binary::Power), 7),
    ("[", Infix::Refused, 9),
];

const HOUDINI: &[(&str, Infix, u8)] = &[
    ("||", Plain(Binary::Or), 1),
    ("&&", Plain(Binary::And), 2),
    ("|", Plain(Binary::Or), 1),
    ("&", Plain(Binary::And), 2),
    ("==", Plain(Binary::Equal), 3),
    ("!=", Plain(Binary::NotEqual), 3),
    ("<=", Plain(Binary::LessEqual), 3),
    (">=", Plain(Binary::GreaterEqual), 3),
    ("<", Plain(Binary::Less), 3),
    (">", Plain(Binary::Greater), 3),
    ("+", Plain(Binary::Add), 7),
    ("-", Plain(Binary::Subtract), 7),
    ("*", Plain(Binary::Multiply), 8),
    ("/", Plain(Binary::Divide), 8),
    ("%", Plain(Binary::Remainder), 8),
    ("^", Plain(Binary::Power), 10),
];
