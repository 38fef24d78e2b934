//! Expressions: text → flat postfix code on a bounded stack → value.
//!
//! The parser is precedence climbing and emits code as it goes, folding what is constant; its recursion is bounded by
//! [`MAX_DEPTH`], the code's stack by [`MAX_STACK`]. `&&` and `||` jump, so `x != 0 && 1/x > 2` never divides by zero.
//! No NaN ever stays on the stack: the operation that makes one is the error.

use super::error::{GrammarError, GrammarErrors, ValueProblem, nearest};
use super::random::Draws;
use super::source::Cursor;

/// Nesting of parentheses and signs in one expression.
const MAX_DEPTH: usize = 100;
/// Values on the stack while an expression is computed.
pub(crate) const MAX_STACK: usize = 128;

/// A function of the language and how many arguments it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Sqrt,
    Exp,
    Log,
    Abs,
    Min,
    Max,
    Floor,
    Ceil,
    Round,
    Sign,
    Clamp,
    Mix,
    Uniform,
    Normal,
    Lognormal,
    Integer,
    Chance,
}

use Function as Fun;

const FUNCTIONS: [(&str, Function, usize); 24] = [
    ("sin", Fun::Sin, 1),
    ("cos", Fun::Cos, 1),
    ("tan", Fun::Tan, 1),
    ("asin", Fun::Asin, 1),
    ("acos", Fun::Acos, 1),
    ("atan", Fun::Atan, 1),
    ("atan2", Fun::Atan2, 2),
    ("sqrt", Fun::Sqrt, 1),
    ("exp", Fun::Exp, 1),
    ("log", Fun::Log, 1),
    ("abs", Fun::Abs, 1),
    ("min", Fun::Min, 2),
    ("max", Fun::Max, 2),
    ("floor", Fun::Floor, 1),
    ("ceil", Fun::Ceil, 1),
    ("round", Fun::Round, 1),
    ("sign", Fun::Sign, 1),
    ("clamp", Fun::Clamp, 3),
    ("mix", Fun::Mix, 3),
    ("uniform", Fun::Uniform, 2),
    ("normal", Fun::Normal, 2),
    ("lognormal", Fun::Lognormal, 2),
    ("integer", Fun::Integer, 2),
    ("chance", Fun::Chance, 1),
];

/// One operation on the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Op {
    Push(f64),
    Load(u16),
    Negate,
    Not,
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
    Power,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
    /// If the top is false, leave 0 and jump; else drop it.
    And(u32),
    /// If the top is true, leave 1 and jump; else drop it.
    Or(u32),
    /// Any true value becomes 1.
    Truth,
    Call(Function),
}

/// A compiled expression. The two commonest kinds need no code.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expression {
    Constant(f64),
    /// The bound parameter in this slot.
    Slot(u16),
    Code(Box<[Op2]>),
}

/// Opaque to other modules: one operation of the code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Op2(Op);

/// What names mean where an expression stands.
pub(crate) struct Scope<'a> {
    /// Bound parameters, their slot is their index.
    pub(crate) parameters: &'a [String],
    /// Constants of the grammar.
    pub(crate) constants: &'a std::collections::BTreeMap<String, f64>,
    /// Whether random draws are allowed here.
    pub(crate) draws: bool,
}

/// Reads one expression; unknown names are put into `errors` and read as 0, other faults end it.
pub(crate) fn parse(
    cursor: &mut Cursor<'_>,
    scope: &Scope<'_>,
    errors: &mut GrammarErrors,
) -> Result<Expression, GrammarError> {
    let mut parser = Parser {
        cursor,
        scope,
        errors,
        code: Vec::new(),
        depth: 0,
        stack: 0,
    };
    parser.binary(0)?;
    let code = parser.code;
    Ok(match code.as_slice() {
        [Op::Push(value)] => Expression::Constant(*value),
        [Op::Load(slot)] => Expression::Slot(*slot),
        _ => Expression::Code(code.into_iter().map(Op2).collect()),
    })
}

/// Reads an expression of constants alone and computes it.
pub(crate) fn parse_constant(
    cursor: &mut Cursor<'_>,
    constants: &std::collections::BTreeMap<String, f64>,
    errors: &mut GrammarErrors,
) -> Result<f64, GrammarError> {
    cursor.skip_blank();
    let start = cursor.pos();
    let scope = Scope {
        parameters: &[],
        constants,
        draws: false,
    };
    let expression = parse(cursor, &scope, errors)?;
    let mut draws = super::random::PassKey::new(0, 0, 0).at(0);
    expression
        .finite(&[], &mut draws)
        .map_err(|problem| cursor.error_at(start, format!("this has no value: {problem}")))
}

struct Parser<'p, 'a, 's> {
    cursor: &'p mut Cursor<'a>,
    scope: &'p Scope<'s>,
    errors: &'p mut GrammarErrors,
    code: Vec<Op>,
    depth: usize,
    stack: usize,
}

#[derive(Clone, Copy)]
enum Infix {
    Plain(Op),
    And,
    Or,
}

const COMPARISON: u8 = 3;
const POWER: u8 = 7;

impl Parser<'_, '_, '_> {
    fn enter(&mut self) -> Result<(), GrammarError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            let at = self.cursor.pos();
            return Err(self.cursor.error_at(at, format!("this expression nests deeper than {MAX_DEPTH}; give parts of it a name with `const`")));
        }
        Ok(())
    }

    /// The infix operator that stands here, with its length and how strongly it binds.
    fn infix(&mut self) -> Result<Option<(Infix, usize, u8)>, GrammarError> {
        self.cursor.skip_blank();
        let rest = self.cursor.rest();
        if rest.starts_with("->") || rest.starts_with("-->") {
            return Ok(None);
        }
        for (token, infix, binds) in [
            ("||", Infix::Or, 1),
            ("&&", Infix::And, 2),
            ("==", Infix::Plain(Op::Equal), COMPARISON),
            ("!=", Infix::Plain(Op::NotEqual), COMPARISON),
            ("<=", Infix::Plain(Op::LessEqual), COMPARISON),
            (">=", Infix::Plain(Op::GreaterEqual), COMPARISON),
            ("<", Infix::Plain(Op::Less), COMPARISON),
            (">", Infix::Plain(Op::Greater), COMPARISON),
            ("+", Infix::Plain(Op::Add), 4),
            ("-", Infix::Plain(Op::Subtract), 4),
            ("*", Infix::Plain(Op::Multiply), 5),
            ("/", Infix::Plain(Op::Divide), 5),
            ("%", Infix::Plain(Op::Remainder), 5),
            ("^", Infix::Plain(Op::Power), POWER),
        ] {
            if rest.starts_with(token) {
                return Ok(Some((infix, token.len(), binds)));
            }
        }
        if rest.starts_with('=') {
            return Err(self
                .cursor
                .expected("a comparison; equality is written `==`"));
        }
        Ok(None)
    }

    /// An expression of operators that bind more strongly than `above`.
    fn binary(&mut self, above: u8) -> Result<(), GrammarError> {
        self.enter()?;
        self.unary()?;
        let mut compared = false;
        while let Some((infix, length, binds)) = self.infix()? {
            if binds <= above {
                break;
            }
            if binds == COMPARISON {
                if compared {
                    return Err(self
                        .cursor
                        .expected("one comparison; join two with `&&`, as in `0 < x && x < 1`"));
                }
                compared = true;
            }
            self.cursor.advance(length);
            match infix {
                Infix::Plain(op) => {
                    // Power binds to the right: 2^3^2 is 2^9.
                    self.binary(if binds == POWER { binds - 1 } else { binds })?;
                    self.stack -= 1;
                    self.emit_binary(op);
                }
                Infix::And | Infix::Or => {
                    let at = self.code.len();
                    self.code.push(Op::Truth);
                    self.stack -= 1;
                    self.binary(binds)?;
                    self.code.push(Op::Truth);
                    let Ok(target) = u32::try_from(self.code.len()) else {
                        return Err(self.cursor.expected("a shorter expression"));
                    };
                    if let Some(op) = self.code.get_mut(at) {
                        *op = if matches!(infix, Infix::And) {
                            Op::And(target)
                        } else {
                            Op::Or(target)
                        };
                    }
                }
            }
        }
        self.depth -= 1;
        Ok(())
    }

    fn push(&mut self, op: Op) -> Result<(), GrammarError> {
        self.stack += 1;
        if self.stack > MAX_STACK {
            let at = self.cursor.pos();
            return Err(self.cursor.error_at(
                at,
                "this expression is too deep; give parts of it a name with `const`".into(),
            ));
        }
        self.code.push(op);
        Ok(())
    }

    fn unary(&mut self) -> Result<(), GrammarError> {
        self.enter()?;
        if self.cursor.take("-") {
            self.binary(POWER - 1)?;
            if let Some(Op::Push(value)) = self.code.last_mut() {
                *value = -*value;
            } else {
                self.code.push(Op::Negate);
            }
        } else if self.cursor.take("!") {
            self.unary()?;
            self.code.push(Op::Not);
        } else if self.cursor.take("+") {
            self.binary(POWER - 1)?;
        } else {
            self.primary()?;
        }
        self.depth -= 1;
        Ok(())
    }

    fn primary(&mut self) -> Result<(), GrammarError> {
        if self.cursor.take("(") {
            self.binary(0)?;
            return self.cursor.expect(")");
        }
        let start = self.cursor.pos();
        if let Some(name) = self.cursor.identifier() {
            if self.cursor.take("(") {
                return self.call(name, start);
            }
            return self.name(name, start);
        }
        if self
            .cursor
            .peek()
            .is_some_and(|c| c.is_ascii_digit() || c == '.')
        {
            let value = number(self.cursor)?;
            return self.push(Op::Push(value));
        }
        Err(self.cursor.expected("a number, a name or `(`"))
    }

    fn name(&mut self, name: &str, start: usize) -> Result<(), GrammarError> {
        if let Some(slot) = self.scope.parameters.iter().position(|p| p == name) {
            return self.push(Op::Load(u16::try_from(slot).unwrap_or(u16::MAX)));
        }
        if let Some(value) = self.scope.constants.get(name) {
            return self.push(Op::Push(*value));
        }
        let known = self
            .scope
            .parameters
            .iter()
            .chain(self.scope.constants.keys())
            .map(String::as_str);
        let message = if FUNCTIONS.iter().any(|f| f.0 == name) {
            format!("found `{name}` without its arguments; expected `{name}(…)`")
        } else {
            let hint = nearest(name, known).map_or(String::new(), |n| {
                format!("; the nearest known name is `{n}`")
            });
            format!(
                "unknown name `{name}`; expected a parameter of this production or a constant{hint}"
            )
        };
        self.errors.push(self.cursor.error_at(start, message));
        self.push(Op::Push(0.0))
    }

    fn call(&mut self, name: &str, start: usize) -> Result<(), GrammarError> {
        let Some((_, function, arity)) = FUNCTIONS.iter().find(|f| f.0 == name).copied() else {
            let hint = nearest(name, FUNCTIONS.iter().map(|f| f.0))
                .map_or(String::new(), |n| format!("; the nearest known is `{n}`"));
            return Err(self
                .cursor
                .error_at(start, format!("unknown function `{name}`{hint}")));
        };
        if function.draws() && !self.scope.draws {
            return Err(self.cursor.error_at(
                start,
                format!("`{name}` draws at random, which only a successor's parameters may; found it elsewhere"),
            ));
        }
        let mut count = 0;
        if !self.cursor.take(")") {
            loop {
                self.binary(0)?;
                count += 1;
                if self.cursor.take(")") {
                    break;
                }
                if !self.cursor.take(",") {
                    return Err(self.cursor.expected("`,` or `)`"));
                }
                if count > arity {
                    break;
                }
            }
        }
        if count != arity {
            let s = if arity == 1 { "" } else { "s" };
            return Err(self.cursor.error_at(
                start,
                format!("`{name}` takes {arity} argument{s}; found {count}"),
            ));
        }
        self.stack -= arity - 1;
        self.code.push(Op::Call(function));
        Ok(())
    }

    /// Emits a binary operator; two constants are computed at once unless that is an error, which then comes when it is used.
    fn emit_binary(&mut self, op: Op) {
        if let [.., Op::Push(a), Op::Push(b)] = self.code.as_slice()
            && let Ok(value) = binary_value(op, *a, *b)
        {
            self.code.truncate(self.code.len() - 2);
            self.code.push(Op::Push(value));
        } else {
            self.code.push(op);
        }
    }
}

/// Reads an unsigned decimal number.
pub(crate) fn number(cursor: &mut Cursor<'_>) -> Result<f64, GrammarError> {
    cursor.skip_blank();
    let start = cursor.pos();
    let rest = cursor.rest().as_bytes();
    let digits = |from: usize| {
        rest.iter()
            .skip(from)
            .take_while(|b| b.is_ascii_digit())
            .count()
    };
    let mut length = digits(0);
    if rest.get(length) == Some(&b'.') {
        length += 1;
        length += digits(length);
    }
    if matches!(rest.get(length), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(rest.get(length + 1), Some(b'+' | b'-')));
        let exponent = digits(length + 1 + sign);
        if exponent > 0 {
            length += 1 + sign + exponent;
        }
    }
    let text = cursor.between(start, start + length);
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => {
            cursor.advance(length);
            Ok(value)
        }
        Ok(_) => Err(cursor.error_at(
            start,
            "this number is larger than a number can be (1.8e308)".into(),
        )),
        Err(_) => Err(cursor.expected("a number")),
    }
}

fn truth(value: bool) -> f64 {
    if value { 1.0 } else { 0.0 }
}

#[expect(
    clippy::float_cmp,
    reason = "the language compares IEEE values exactly, as its specification says"
)]
fn binary_value(op: Op, a: f64, b: f64) -> Result<f64, ValueProblem> {
    let value = match op {
        Op::Add => a + b,
        Op::Subtract => a - b,
        Op::Multiply => a * b,
        Op::Divide | Op::Remainder if b == 0.0 => return Err(ValueProblem::DivisionByZero),
        Op::Divide => a / b,
        Op::Remainder => a % b,
        Op::Power if a == 0.0 && b < 0.0 => return Err(ValueProblem::DivisionByZero),
        Op::Power => a.powf(b),
        Op::Less => truth(a < b),
        Op::LessEqual => truth(a <= b),
        Op::Greater => truth(a > b),
        Op::GreaterEqual => truth(a >= b),
        Op::Equal => truth(a == b),
        _ => truth(a != b),
    };
    if value.is_nan() {
        Err(ValueProblem::NotANumber)
    } else {
        Ok(value)
    }
}

impl Function {
    fn draws(self) -> bool {
        matches!(
            self,
            Fun::Uniform | Fun::Normal | Fun::Lognormal | Fun::Integer | Fun::Chance
        )
    }

    /// The value for up to three arguments (unused ones are 0).
    fn value(self, [a, b, c]: [f64; 3], draws: &mut Draws) -> Result<f64, ValueProblem> {
        let value = match self {
            Fun::Sin => a.to_radians().sin(),
            Fun::Cos => a.to_radians().cos(),
            Fun::Tan => a.to_radians().tan(),
            Fun::Asin => a.asin().to_degrees(),
            Fun::Acos => a.acos().to_degrees(),
            Fun::Atan => a.atan().to_degrees(),
            Fun::Atan2 => a.atan2(b).to_degrees(),
            Fun::Sqrt => a.sqrt(),
            Fun::Exp => a.exp(),
            Fun::Log => a.ln(),
            Fun::Abs => a.abs(),
            Fun::Min => a.min(b),
            Fun::Max => a.max(b),
            Fun::Floor => a.floor(),
            Fun::Ceil => a.ceil(),
            Fun::Round => a.round(),
            Fun::Sign => truth(a > 0.0) - truth(a < 0.0),
            Fun::Clamp => a.max(b).min(c),
            Fun::Mix => a + (b - a) * c,
            Fun::Uniform if a <= b => a + (b - a) * draws.unit(),
            Fun::Normal if b >= 0.0 => a + b * draws.normal(),
            Fun::Lognormal if a > 0.0 && b >= 0.0 => {
                // Parameters of the underlying normal that give the result this mean and spread.
                let ratio = b / a;
                let variance = (ratio * ratio).ln_1p();
                (a.ln() - variance / 2.0 + variance.sqrt() * draws.normal()).exp()
            }
            Fun::Integer if a.ceil() <= b.floor() && a.abs().max(b.abs()) < 9e15 => {
                let (low, high) = (a.ceil(), b.floor());
                (low + (draws.unit() * (high - low + 1.0)).floor()).min(high)
            }
            Fun::Chance if (0.0..=1.0).contains(&a) => truth(draws.unit() < a),
            _ => return Err(ValueProblem::BadDraw),
        };
        if value.is_nan() {
            Err(ValueProblem::NotANumber)
        } else {
            Ok(value)
        }
    }

    fn arity(self) -> usize {
        match self {
            Fun::Clamp | Fun::Mix => 3,
            Fun::Atan2
            | Fun::Min
            | Fun::Max
            | Fun::Uniform
            | Fun::Normal
            | Fun::Lognormal
            | Fun::Integer => 2,
            _ => 1,
        }
    }
}

impl Expression {
    /// The value, which may be infinite but is a number.
    #[inline]
    pub(crate) fn value(&self, bound: &[f64], draws: &mut Draws) -> Result<f64, ValueProblem> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Slot(slot) => Ok(bound.get(usize::from(*slot)).copied().unwrap_or(0.0)),
            Self::Code(code) => run(code, bound, draws),
        }
    }

    /// The value as a module's parameter: finite.
    #[inline]
    pub(crate) fn finite(&self, bound: &[f64], draws: &mut Draws) -> Result<f64, ValueProblem> {
        let value = self.value(bound, draws)?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(ValueProblem::Overflow)
        }
    }
}

/// Runs postfix code. The parser has bounded the stack; a slot past it (which cannot be) reads 0.
fn run(code: &[Op2], bound: &[f64], draws: &mut Draws) -> Result<f64, ValueProblem> {
    let mut stack = [0.0_f64; MAX_STACK + 1];
    let mut top = 0_usize; // number of values; the last is at top − 1
    let mut at = 0;
    while let Some(Op2(op)) = code.get(at) {
        at += 1;
        match *op {
            Op::Push(value) => {
                stack[top.min(MAX_STACK)] = value;
                top += 1;
            }
            Op::Load(slot) => {
                stack[top.min(MAX_STACK)] = bound.get(usize::from(slot)).copied().unwrap_or(0.0);
                top += 1;
            }
            Op::Negate => {
                let last = &mut stack[top.saturating_sub(1).min(MAX_STACK)];
                *last = -*last;
            }
            Op::Not => {
                let last = &mut stack[top.saturating_sub(1).min(MAX_STACK)];
                *last = truth(*last == 0.0);
            }
            Op::Truth => {
                let last = &mut stack[top.saturating_sub(1).min(MAX_STACK)];
                *last = truth(*last != 0.0);
            }
            Op::And(target) | Op::Or(target) => {
                let last = &mut stack[top.saturating_sub(1).min(MAX_STACK)];
                let jumps = matches!(op, Op::Or(_)) == (*last != 0.0);
                if jumps {
                    *last = truth(*last != 0.0);
                    at = target as usize;
                } else {
                    top = top.saturating_sub(1);
                }
            }
            Op::Call(function) => {
                let arity = function.arity();
                let first = top.saturating_sub(arity).min(MAX_STACK - 3);
                let mut arguments = [0.0; 3];
                arguments[..arity].copy_from_slice(&stack[first..first + arity]);
                stack[first] = function.value(arguments, draws)?;
                top = first + 1;
            }
            binary => {
                let second = top.saturating_sub(1).min(MAX_STACK);
                let first = second.saturating_sub(1);
                stack[first] = binary_value(binary, stack[first], stack[second])?;
                top = second;
            }
        }
    }
    Ok(stack[0])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests may fail by panic")]
    use std::collections::BTreeMap;

    use super::super::random::PassKey;
    use super::super::source::Source;
    use super::*;

    fn compile(text: &str) -> Result<Expression, String> {
        let source = Source {
            name: "t".into(),
            text: text.into(),
        };
        let mut cursor = Cursor::new(&source, 0, text.len());
        let constants = BTreeMap::from([("pi".to_owned(), std::f64::consts::PI)]);
        let parameters = ["x".to_owned(), "y".to_owned()];
        let mut errors = GrammarErrors::default();
        let scope = Scope {
            parameters: &parameters,
            constants: &constants,
            draws: true,
        };
        let expression = parse(&mut cursor, &scope, &mut errors).map_err(|e| e.message)?;
        if let Some(error) = errors.errors.first() {
            return Err(error.message.clone());
        }
        if !cursor.at_end() {
            return Err(format!("left: {}", cursor.rest()));
        }
        Ok(expression)
    }

    fn value(text: &str) -> Result<f64, String> {
        let mut draws = PassKey::new(1, 1, 0).at(0);
        compile(text)?
            .value(&[3.0, -2.0], &mut draws)
            .map_err(|e| e.to_string())
    }

    #[test]
    fn values() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("2^3^2", 512.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("-x + -y", -1.0),
            ("- - x", 3.0),
            ("10 - 4 - 3", 3.0),
            ("7 % 4 * 2", 6.0),
            ("-7 % 4", -3.0),
            ("x - 1 > 1 && y < 0", 1.0),
            ("x == 3 || 1/0 > 1", 1.0),
            ("x != 3 && 1/0 > 1", 0.0),
            ("x == 3 && 5", 1.0),
            ("0 || 0 || 7", 1.0),
            ("!x", 0.0),
            ("!(x > 5)", 1.0),
            ("!0 + 1", 2.0),
            ("1 - 1 && 1", 0.0),
            ("1 + (x && y) * 4", 5.0),
            ("x<-1", 0.0),
            ("1e3 + .5 + 2.", 1002.5),
            ("atan2(1, 0)", 90.0),
            ("acos(0)", 90.0),
            ("floor(2.7) + ceil(2.1) + round(2.5)", 8.0),
            ("round(-2.5)", -3.0),
            ("sign(y) + sign(0)", -1.0),
            ("clamp(9, 0, x)", 3.0),
            ("mix(x, y, 0.5)", 0.5),
            ("min(x, y) + max(x, y)", 1.0),
            ("log(exp(1))", 1.0),
            ("abs(y) * sqrt(16)", 8.0),
            ("integer(4, 4)", 4.0),
            ("uniform(2, 2)", 2.0),
            ("normal(5, 0)", 5.0),
            ("chance(1) + chance(0)", 1.0),
        ] {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
        for (text, expected) in [
            ("sin(30)", 0.5),
            ("cos(60)", 0.5),
            ("tan(45)", 1.0),
            ("lognormal(2, 0)", 2.0),
            ("asin(0.5)", 30.0),
            ("atan(1)", 45.0),
        ] {
            assert!((value(text).unwrap() - expected).abs() < 1e-12, "{text}");
        }
    }

    #[test]
    fn faults_in_text() {
        for (text, part) in [
            ("1 +", "expected a number"),
            ("zz + 1", "unknown name `zz`"),
            ("p1", "nearest known name is `pi`"),
            ("sine(1)", "nearest known is `sin`"),
            ("sin", "without its arguments"),
            ("min(1)", "takes 2 arguments; found 1"),
            ("sin(1,2)", "takes 1 argument; found 2"),
            ("1 = 2", "`==`"),
            ("1 < 2 < 3", "join two"),
            ("(1", "expected `)`"),
            ("1e999", "larger than"),
        ] {
            let message = compile(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn faults_in_values() {
        for (text, part) in [
            ("1 / (x - 3)", "division by zero"),
            ("x % 0", "division by zero"),
            ("(x-3) ^ -1", "division by zero"),
            ("sqrt(y)", "not a number"),
            ("max(sqrt(y), 1)", "not a number"),
            ("log(-1)", "not a number"),
            ("y ^ 0.5", "not a number"),
            ("uniform(2, 1)", "impossible"),
            ("normal(0, -1)", "impossible"),
            ("lognormal(0, 1)", "impossible"),
            ("chance(2)", "impossible"),
        ] {
            let message = value(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
        let mut draws = PassKey::new(1, 1, 0).at(0);
        assert_eq!(
            compile("10 ^ 400 * x").unwrap().finite(&[1.0], &mut draws),
            Err(ValueProblem::Overflow),
            "overflow"
        );
    }

    #[test]
    fn hostile_depth_is_refused() {
        for text in [
            "(".repeat(100_000),
            "-".repeat(100_000),
            "!".repeat(100_000),
            "2^".repeat(100_000),
            "min(1,".repeat(100_000),
        ] {
            assert!(
                compile(&text).unwrap_err().contains("nests deeper"),
                "bounded recursion"
            );
        }
        let long = format!("x{}", "+1".repeat(500_000));
        assert_eq!(value(&long), Ok(500_003.0), "long is fine");
        let anded = format!("1{}", "&& x".repeat(200_000));
        assert_eq!(value(&anded), Ok(1.0), "long conjunction");
    }

    #[test]
    fn random_draws_have_the_stated_moments() {
        for (text, mean, spread) in [
            ("uniform(1, 3)", 2.0, 2.0 / 12.0_f64.sqrt()),
            ("normal(5, 2)", 5.0, 2.0),
            ("lognormal(3, 1.5)", 3.0, 1.5),
            ("integer(1, 6)", 3.5, (35.0_f64 / 12.0).sqrt()),
            ("chance(0.3)", 0.3, 0.21_f64.sqrt()),
        ] {
            let expression = compile(text).unwrap();
            let key = PassKey::new(7, 1, 0);
            let values: Vec<f64> = (0..100_000)
                .map(|i| expression.value(&[], &mut key.at(i)).unwrap())
                .collect();
            let n = 100_000.0;
            let average = values.iter().sum::<f64>() / n;
            let deviation = (values.iter().map(|v| (v - average).powi(2)).sum::<f64>() / n).sqrt();
            assert!(
                (average - mean).abs() < 4.0 * spread / n.sqrt(),
                "{text}: mean {average}"
            );
            assert!(
                (deviation / spread - 1.0).abs() < 0.03,
                "{text}: spread {deviation}"
            );
        }
    }
}
