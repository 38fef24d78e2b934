//! Expressions: text → the code of [`super::code`].
//!
//! The parser is precedence climbing and emits code as it goes, folding what is constant; its recursion is bounded by
//! [`MAX_DEPTH`], the code's stack by [`MAX_STACK`]. `&&` and `||` jump, so `x != 0 && 1/x > 2` never divides by zero.

use super::code::{Expression, FUNCTIONS, MAX_STACK, Op, PICK, binary_value};
use super::error::{GrammarError, GrammarErrors, nearest};
use super::source::Cursor;

/// Values that `pick` picks from at most: the stack has room for them and for what is around.
const PICKED_MOST: usize = 100;
/// Nesting of parentheses and signs in one expression.
const MAX_DEPTH: usize = 100;

/// What names mean where an expression stands.
pub(crate) struct Scope<'a> {
    /// Bound parameters, their slot is their index.
    pub(crate) parameters: &'a [String],
    /// Constants of the grammar.
    pub(crate) constants: &'a std::collections::BTreeMap<String, f64>,
    /// Whether random draws are allowed here.
    pub(crate) draws: bool,
    /// What a name may mean here, for messages.
    pub(crate) names: &'static str,
}

/// Names in a production's condition, weight and parameters.
pub(crate) const IN_PRODUCTIONS: &str = "a parameter of this production or a constant";

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
        deepest: 0,
    };
    parser.binary(0)?;
    let (code, depth) = (parser.code, parser.deepest);
    Ok(match code.as_slice() {
        [Op::Push(value)] => Expression::Constant(*value),
        [Op::Load(slot)] => Expression::Slot(*slot),
        _ => Expression::Code {
            code: code.into_boxed_slice(),
            depth,
        },
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
        names: "a number or a constant given above",
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
    deepest: usize,
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
        self.deepest = self.deepest.max(self.stack);
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
        self.cursor.skip_blank();
        let arrow = self.cursor.rest().starts_with("->");
        if !arrow && self.cursor.take("-") {
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
            if self.cursor.peek().is_some_and(char::is_alphabetic) {
                let factor = self.cursor.found();
                return Err(self
                    .cursor
                    .expected(&format!("an operator before {factor}, as in `2*x`")));
            }
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
        if self.errors.is_full() {
            self.errors.more += 1;
            return self.push(Op::Push(0.0));
        }
        let known = self
            .scope
            .parameters
            .iter()
            .chain(self.scope.constants.keys())
            .map(String::as_str);
        let message = if name == PICK || FUNCTIONS.iter().any(|f| f.0 == name) {
            format!("found `{name}` without its arguments; expected `{name}(…)`")
        } else {
            let hint = nearest(name, known).map_or(String::new(), |n| {
                format!("; the nearest known name is `{n}`")
            });
            format!("unknown name `{name}`; expected {}{hint}", self.scope.names)
        };
        self.errors.push(self.cursor.error_at(start, message));
        self.push(Op::Push(0.0))
    }

    fn call(&mut self, name: &str, start: usize) -> Result<(), GrammarError> {
        if name == PICK {
            return self.pick(start);
        }
        let Some((_, function, arity)) = FUNCTIONS.iter().find(|f| f.0 == name).copied() else {
            let known = FUNCTIONS.iter().map(|f| f.0).chain([PICK]);
            let hint = nearest(name, known)
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
        let count = self.arguments(arity)?;
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

    /// Reads arguments up to the closing parenthesis, or one more than there may be; how many.
    fn arguments(&mut self, most: usize) -> Result<usize, GrammarError> {
        let mut count = 0;
        if self.cursor.take(")") {
            return Ok(count);
        }
        while count <= most {
            self.binary(0)?;
            count += 1;
            if self.cursor.take(")") {
                break;
            }
            if !self.cursor.take(",") {
                return Err(self.cursor.expected("`,` or `)`"));
            }
        }
        Ok(count)
    }

    /// `pick(i, a, b, …)`.
    fn pick(&mut self, start: usize) -> Result<(), GrammarError> {
        let count = self.arguments(PICKED_MOST + 1)?;
        if count > PICKED_MOST + 1 {
            return Err(self.cursor.error_at(
                start,
                format!("`{PICK}` takes {PICKED_MOST} values at most to pick from"),
            ));
        }
        let values = match u16::try_from(count.saturating_sub(1)) {
            Ok(values) if values > 0 => values,
            _ => {
                let s = if count == 1 { "" } else { "s" };
                return Err(self.cursor.error_at(
                    start,
                    format!("`{PICK}` takes a place and the values to pick from, as in `{PICK}(i, 1, 0.8)`; found {count} argument{s}"),
                ));
            }
        };
        self.stack -= usize::from(values);
        self.code.push(Op::Pick(values));
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

/// A number with a sign.
pub(crate) fn signed(cursor: &mut Cursor<'_>) -> Result<f64, GrammarError> {
    let negative = cursor.take("-");
    if !negative {
        cursor.take("+");
    }
    let value = number(cursor)?;
    Ok(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests may fail by panic")]
    use std::collections::BTreeMap;

    use super::super::error::ValueProblem;
    use super::super::random::PassKey;
    use super::super::source::Source;
    use super::*;

    fn compile(text: &str) -> Result<Expression, String> {
        let source = Source::new("t".into(), text.into());
        let mut cursor = Cursor::new(&source, 0, text.len());
        let constants = BTreeMap::from([("pi".to_owned(), std::f64::consts::PI)]);
        let parameters = ["x".to_owned(), "y".to_owned()];
        let mut errors = GrammarErrors::default();
        let scope = Scope {
            parameters: &parameters,
            constants: &constants,
            draws: true,
            names: IN_PRODUCTIONS,
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
            ("pick(0, 7, 8, 9) + pick(1.9, 7, 8, 9) * 10", 87.0),
            ("pick(y, 7, 8, 9) + pick(x * 1e300, 7, 8, 9)", 16.0),
            ("pick(x, 5)", 5.0),
            (&format!("1 + pick(99{})", ", 2".repeat(100)), 3.0),
            ("2 * pick(1, x, pick(0, y, x))", -4.0),
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
            (
                "pick(1)",
                "values to pick from, as in `pick(i, 1, 0.8)`; found 1 argument",
            ),
            ("pick()", "found 0 arguments"),
            (
                &format!("pick(x{})", ", 1".repeat(101)),
                "100 values at most",
            ),
            ("pick", "without its arguments"),
            ("pik(1, 2)", "nearest known is `pick`"),
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
            ("pick(0, 1, sqrt(y))", "not a number"),
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
            "pick(1,".repeat(100_000),
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
