//! What an expression is compiled to: flat postfix code on a bounded stack, and how it is run.
//!
//! No NaN ever stays on the stack: the operation that makes one is the error.

use super::error::ValueProblem;
use super::random::Draws;

use Function as Fun;

/// Values on the stack while an expression is computed; the parser keeps to it.
pub(super) const MAX_STACK: usize = 128;
/// Values of the stack that nearly all expressions need.
const SMALL_STACK: usize = 6;

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

/// The function that takes any number of arguments: a place, and the values of which it is one.
pub(super) const PICK: &str = "pick";

/// Name, function and number of arguments: the one place that says it.
pub(super) const FUNCTIONS: [(&str, Function, usize); 24] = [
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

// A function is found in the table by its number: the rows stand in the order of the enum, and their arguments fit in
// the three that `value` is given.
const _: () = {
    let mut row = 0;
    while row < FUNCTIONS.len() {
        assert!(FUNCTIONS[row].1 as usize == row, "in the order of the enum");
        assert!(FUNCTIONS[row].2 <= 3, "at most three arguments");
        row += 1;
    }
    assert!(
        Function::Chance as usize + 1 == FUNCTIONS.len(),
        "all of them"
    );
};

/// One operation on the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
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
    /// Of so many values at the top, the one at the place that the value below them says.
    Pick(u16),
}

impl Op {
    /// Whether it makes one value of two.
    #[inline]
    pub(super) fn is_binary(self) -> bool {
        !matches!(
            self,
            Self::Push(_)
                | Self::Load(_)
                | Self::Negate
                | Self::Not
                | Self::And(_)
                | Self::Or(_)
                | Self::Truth
                | Self::Call(_)
                | Self::Pick(_)
        )
    }
}

/// A compiled expression. The two commonest kinds need no code.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expression {
    Constant(f64),
    /// The bound parameter in this slot.
    Slot(u16),
    Code {
        /// Postfix operations.
        code: Box<[Op]>,
        /// Most values that are ever on the stack.
        depth: usize,
    },
}

#[inline]
pub(super) fn truth(value: bool) -> f64 {
    if value { 1.0 } else { 0.0 }
}

#[expect(
    clippy::float_cmp,
    reason = "the language compares IEEE values exactly, as its specification says"
)]
pub(super) fn binary_value(op: Op, a: f64, b: f64) -> Result<f64, ValueProblem> {
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

/// Which of so many values, at least one, a place means: from 0, the first below it and the last beyond.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "what is no place becomes the first or the last"
)]
#[inline]
pub(super) fn picked(place: f64, count: usize) -> usize {
    (place as usize).min(count.saturating_sub(1))
}

impl Function {
    pub(super) fn draws(self) -> bool {
        matches!(
            self,
            Fun::Uniform | Fun::Normal | Fun::Lognormal | Fun::Integer | Fun::Chance
        )
    }

    /// The value for up to three arguments (unused ones are 0).
    pub(super) fn value(self, [a, b, c]: [f64; 3], draws: &mut Draws) -> Result<f64, ValueProblem> {
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
            drawn => return Err(drawn.bad_draw()),
        };
        if value.is_nan() {
            Err(ValueProblem::NotANumber)
        } else {
            Ok(value)
        }
    }

    /// That its arguments describe no distribution.
    #[cold]
    fn bad_draw(self) -> ValueProblem {
        let wants = match self {
            Fun::Uniform => "its lower bound first",
            Fun::Normal => "a spread of 0 or more",
            Fun::Lognormal => "a mean above 0 and a spread of 0 or more",
            Fun::Integer => {
                "a whole number between its bounds, the lower one first, both below 9e15"
            }
            _ => "a number from 0 to 1",
        };
        ValueProblem::BadDraw(FUNCTIONS[self as usize].0, wants)
    }

    /// How many arguments it takes.
    pub(super) fn arity(self) -> usize {
        FUNCTIONS[self as usize].2
    }
}

impl Expression {
    /// Whether its value is left to chance.
    pub(crate) fn draws(&self) -> bool {
        let drawn = |op: &Op| matches!(op, Op::Call(function) if function.draws());
        matches!(self, Self::Code { code, .. } if code.iter().any(drawn))
    }

    /// Whether it reads a slot from this one on.
    pub(super) fn reads_from(&self, first: usize) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Slot(slot) => usize::from(*slot) >= first,
            Self::Code { code, .. } => code
                .iter()
                .any(|op| matches!(op, Op::Load(slot) if usize::from(*slot) >= first)),
        }
    }

    /// Whether it draws, and how often depends on the values.
    pub(super) fn may_draw(&self) -> bool {
        let jumps = |op: &Op| matches!(op, Op::And(_) | Op::Or(_));
        matches!(self, Self::Code { code, .. } if self.draws() && code.iter().any(jumps))
    }

    /// The value, which may be infinite but is a number.
    #[inline]
    pub(crate) fn value(&self, bound: &[f64], draws: &mut Draws) -> Result<f64, ValueProblem> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Slot(slot) => Ok(bound.get(usize::from(*slot)).copied().unwrap_or(0.0)),
            // A small stack is cleared for nothing, a large one costs more than most expressions.
            Self::Code { code, depth } if *depth <= SMALL_STACK => {
                run::<SMALL_STACK>(code, bound, draws)
            }
            Self::Code { code, .. } => run::<MAX_STACK>(code, bound, draws),
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

/// Runs postfix code on a stack of `N` values. The parser has bounded the stack; a slot past it (which cannot be) is the
/// last one.
fn run<const N: usize>(code: &[Op], bound: &[f64], draws: &mut Draws) -> Result<f64, ValueProblem> {
    let mut stack = [0.0_f64; N];
    let mut top = 0_usize; // number of values; the last is at top − 1
    let mut at = 0;
    while let Some(op) = code.get(at) {
        at += 1;
        match *op {
            Op::Push(value) => {
                stack[top.min(N - 1)] = value;
                top += 1;
            }
            Op::Load(slot) => {
                stack[top.min(N - 1)] = bound.get(usize::from(slot)).copied().unwrap_or(0.0);
                top += 1;
            }
            Op::Negate => {
                let last = &mut stack[top.saturating_sub(1).min(N - 1)];
                *last = -*last;
            }
            Op::Not => {
                let last = &mut stack[top.saturating_sub(1).min(N - 1)];
                *last = truth(*last == 0.0);
            }
            Op::Truth => {
                let last = &mut stack[top.saturating_sub(1).min(N - 1)];
                *last = truth(*last != 0.0);
            }
            Op::And(target) | Op::Or(target) => {
                let last = &mut stack[top.saturating_sub(1).min(N - 1)];
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
                let first = top.saturating_sub(arity).min(N - 3);
                let mut arguments = [0.0; 3];
                arguments[..arity].copy_from_slice(&stack[first..first + arity]);
                stack[first] = function.value(arguments, draws)?;
                top = first + 1;
            }
            Op::Pick(count) => {
                let count = usize::from(count).min(N - 1);
                let first = top.saturating_sub(count + 1).min(N - 1 - count);
                stack[first] = stack[first + 1 + picked(stack[first], count)];
                top = first + 1;
            }
            binary => {
                let second = top.saturating_sub(1).min(N - 1);
                let first = second.saturating_sub(1);
                stack[first] = binary_value(binary, stack[first], stack[second])?;
                top = second;
            }
        }
    }
    Ok(stack[0])
}
