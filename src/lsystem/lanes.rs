//! Expressions computed for many modules at once: each operation runs down a column of values, one for each module.
//!
//! The work of finding out what an operation is happens once a column, and what is left are loops over plain arrays. Every value is
//! what [`Expression::value`] gives for that module alone, bit for bit, since both do the same IEEE operations in the
//! same order. What is an error there is NaN here, and NaN stays NaN to the end of the expression: so one look at the
//! finished column says whether anything went wrong. Of `a && b` and `a || b` both sides are computed, and an error on the right
//! counts where the left leaves it to the right, as ever.

use super::code::{Expression, MAX_STACK, Op, picked, truth};
use super::random::Draws;

/// Modules in a column.
pub(super) const LANES: usize = 256;
/// Columns that a production may need to be computed this way: they are to stay near the processor.
const MOST_COLUMNS: usize = 64;

type Column = [f64; LANES];

/// The values of bound parameters and of what is computed from them.
pub(super) struct Values {
    /// One for each slot.
    slots: Vec<Column>,
    stack: Vec<Column>,
    /// Draws of each module, where any are made.
    draws: Vec<Draws>,
    /// Where `&&` and `||` end, and whether it is `||`: a stack.
    joins: Vec<(usize, bool)>,
}

impl Values {
    /// Room for expressions that need no more slots and no more of the stack.
    pub(super) fn new(slots: usize, depth: usize) -> Self {
        Self {
            slots: vec![[0.0; LANES]; slots],
            stack: vec![[0.0; LANES]; depth.max(1)],
            draws: Vec::new(),
            joins: Vec::new(),
        }
    }

    /// Whether columns of these numbers are worth having.
    pub(super) fn fits(slots: usize, depth: usize) -> bool {
        slots + depth <= MOST_COLUMNS
    }

    /// Sets the parameter that is bound to a slot for one module.
    pub(super) fn set(&mut self, slot: usize, lane: usize, value: f64) {
        if let Some(place) = self.slots.get_mut(slot).and_then(|c| c.get_mut(lane)) {
            *place = value;
        }
    }

    /// Binds to a slot, for one module after the other, the parameter with this number of those that begin at `starts`,
    /// `arity` for each module.
    #[inline]
    pub(super) fn gather(
        &mut self,
        slot: usize,
        parameters: &[f64],
        starts: &[usize],
        number: usize,
        arity: usize,
    ) {
        let (Some(column), Some(&first)) = (self.slots.get_mut(slot), starts.first()) else {
            return;
        };
        // Without an early end the comparison is done for several at once.
        let follow = |all, (a, b): (&usize, usize)| all & (*a == b);
        let next_to_each_other = arity == 1 && starts.iter().zip(first..).fold(true, follow);
        if next_to_each_other
            && let Some(values) = parameters.get(first..first + starts.len())
            && let Some(column) = column.get_mut(..starts.len())
        {
            column.copy_from_slice(values);
            return;
        }
        for (value, start) in column.iter_mut().zip(starts) {
            *value = parameters.get(start + number).copied().unwrap_or(0.0);
        }
    }

    /// The draws of the modules, in their order.
    pub(super) fn set_draws(&mut self, draws: impl Iterator<Item = Draws>) {
        self.draws.clear();
        self.draws.extend(draws);
    }

    /// The values of an expression for the first `lanes` modules: NaN where there is none.
    pub(super) fn compute(&mut self, expression: &Expression, lanes: usize) -> &[f64] {
        let lanes = lanes.min(LANES);
        match expression {
            Expression::Slot(slot) => {
                return self
                    .slots
                    .get(usize::from(*slot))
                    .map_or(&[], |c| &c[..lanes]);
            }
            Expression::Constant(value) => {
                if let Some(first) = self.stack.first_mut() {
                    first[..lanes].fill(*value);
                }
            }
            Expression::Code { code, .. } => self.run(code, lanes),
        }
        self.stack.first().map_or(&[], |c| &c[..lanes])
    }

    fn run(&mut self, code: &[Op], lanes: usize) {
        let mut top = 0_usize; // number of values; the last is at top − 1
        let mut at = 0;
        self.joins.clear();
        loop {
            while let Some(&(target, is_or)) = self.joins.last()
                && target == at
            {
                self.joins.pop();
                top = top.saturating_sub(1);
                if let Some((left, right)) = self.pair(top, lanes) {
                    join(left, right, is_or);
                }
            }
            let Some(op) = code.get(at) else { break };
            let following = code.get(at + 1).copied().filter(|op| op.is_binary());
            at += 1;
            match *op {
                // The second operand of what follows need not be copied.
                Op::Push(value) if let Some(next) = following => {
                    at += 1;
                    if let Some(left) = last(&mut self.stack, top, lanes) {
                        binary(next, left, std::iter::repeat(value));
                    }
                }
                Op::Load(slot) if let Some(next) = following => {
                    at += 1;
                    let right = self.slots.get(usize::from(slot));
                    if let (Some(left), Some(right)) = (last(&mut self.stack, top, lanes), right) {
                        binary(next, left, right.iter().copied());
                    }
                }
                Op::Push(value) => {
                    top += 1;
                    if let Some(new) = last(&mut self.stack, top, lanes) {
                        new.fill(value);
                    }
                }
                Op::Load(slot) => {
                    top += 1;
                    let value = self.slots.get(usize::from(slot));
                    if let (Some(new), Some(value)) = (last(&mut self.stack, top, lanes), value) {
                        new.copy_from_slice(&value[..lanes]);
                    }
                }
                Op::And(target) | Op::Or(target) => {
                    // The value stays below what the right side gives.
                    self.joins.push((target as usize, matches!(op, Op::Or(_))));
                }
                Op::Call(function) => {
                    let arity = function.arity();
                    let first = top.saturating_sub(arity);
                    self.call(first, arity, lanes, |arguments, draws| {
                        function.value(arguments, draws).unwrap_or(f64::NAN)
                    });
                    top = first + 1;
                }
                Op::Pick(count) => {
                    let first = top.saturating_sub(usize::from(count) + 1);
                    if let Some(columns) = self.stack.get_mut(first..top) {
                        pick(columns, lanes);
                    }
                    top = first + 1;
                }
                Op::Negate | Op::Not | Op::Truth => {
                    if let Some(values) = last(&mut self.stack, top, lanes) {
                        unary(*op, values);
                    }
                }
                operation => {
                    top = top.saturating_sub(1);
                    if let Some((left, right)) = self.pair(top, lanes) {
                        binary(operation, left, right.iter().copied());
                    }
                }
            }
        }
    }

    /// The column at `second` of the stack and the one below it.
    fn pair(&mut self, second: usize, lanes: usize) -> Option<(&mut [f64], &[f64])> {
        let (below, from) = self.stack.split_at_mut_checked(second)?;
        Some((&mut below.last_mut()?[..lanes], &from.first()?[..lanes]))
    }

    /// Computes a function of `arity` columns from `first` on, into the first of them.
    fn call(
        &mut self,
        first: usize,
        arity: usize,
        lanes: usize,
        value: impl Fn([f64; 3], &mut Draws) -> f64,
    ) {
        let mut none = Draws::default();
        let Some(columns) = self.stack.get_mut(first..first + arity) else {
            return;
        };
        for lane in 0..lanes {
            let mut arguments = [0.0; 3];
            for (argument, column) in arguments.iter_mut().zip(columns.iter()) {
                *argument = column[lane];
            }
            let draws = self.draws.get_mut(lane).unwrap_or(&mut none);
            let wrong = arguments.iter().any(|a| a.is_nan());
            if let Some(result) = columns.first_mut() {
                result[lane] = if wrong {
                    f64::NAN
                } else {
                    value(arguments, draws)
                };
            }
        }
    }
}

/// Columns that the code needs at once: as many as values on the stack, and one for each `&&` and `||` that is open.
pub(super) fn depth(expression: &Expression) -> usize {
    let Expression::Code { code, depth } = expression else {
        return 1;
    };
    let mut open: Vec<u32> = Vec::new();
    let mut most = 0;
    for (at, op) in (0_u32..).zip(code.iter()) {
        open.retain(|target| *target > at);
        if let Op::And(target) | Op::Or(target) = op {
            open.push(*target);
            most = most.max(open.len());
            if most > MAX_STACK {
                break;
            }
        }
    }
    depth + most
}

fn last(stack: &mut [Column], top: usize, lanes: usize) -> Option<&mut [f64]> {
    stack.get_mut(top.checked_sub(1)?).map(|c| &mut c[..lanes])
}

fn unary(op: Op, values: &mut [f64]) {
    let keep = |value: f64, result: f64| if value.is_nan() { value } else { result };
    match op {
        Op::Negate => values.iter_mut().for_each(|v| *v = -*v),
        Op::Not => values
            .iter_mut()
            .for_each(|v| *v = keep(*v, truth(*v == 0.0))),
        _ => values
            .iter_mut()
            .for_each(|v| *v = keep(*v, truth(*v != 0.0))),
    }
}

/// Of the columns behind the first, in each lane the value whose place the first says, into the first.
fn pick(columns: &mut [Column], lanes: usize) {
    let Some((places, values)) = columns.split_first_mut() else {
        return;
    };
    for (lane, place) in places.iter_mut().enumerate().take(lanes) {
        let wrong = place.is_nan() || values.iter().any(|column| column[lane].is_nan());
        *place = match values.get(picked(*place, values.len())) {
            Some(column) if !wrong => column[lane],
            _ => f64::NAN,
        };
    }
}

/// `left && right` or `left || right`, where the right is a truth value.
fn join(left: &mut [f64], right: &[f64], is_or: bool) {
    let decided = truth(is_or);
    for (left, right) in left.iter_mut().zip(right) {
        if left.is_nan() {
            continue;
        }
        *left = if (*left != 0.0) == is_or {
            decided
        } else {
            *right
        };
    }
}

/// Runs a binary operation down a column, which it replaces.
#[expect(
    clippy::float_cmp,
    reason = "the language compares IEEE values exactly, as its specification says"
)]
fn binary(op: Op, left: &mut [f64], right: impl Iterator<Item = f64>) {
    let compared = |a: f64, b: f64, holds: bool| {
        if a.is_nan() | b.is_nan() {
            f64::NAN
        } else {
            truth(holds)
        }
    };
    match op {
        Op::Add => each(left, right, |a, b| a + b),
        Op::Subtract => each(left, right, |a, b| a - b),
        Op::Multiply => each(left, right, |a, b| a * b),
        Op::Less => each(left, right, |a, b| compared(a, b, a < b)),
        Op::LessEqual => each(left, right, |a, b| compared(a, b, a <= b)),
        Op::Greater => each(left, right, |a, b| compared(a, b, a > b)),
        Op::GreaterEqual => each(left, right, |a, b| compared(a, b, a >= b)),
        Op::Equal => each(left, right, |a, b| compared(a, b, a == b)),
        Op::NotEqual => each(left, right, |a, b| compared(a, b, a != b)),
        Op::Divide => each(left, right, |a, b| if b == 0.0 { f64::NAN } else { a / b }),
        // A power of NaN may be a number.
        _ => each(left, right, |a, b| {
            let wrong = a.is_nan() || b.is_nan();
            let value = super::code::binary_value(op, a, b);
            value.ok().filter(|_| !wrong).unwrap_or(f64::NAN)
        }),
    }
}

#[inline]
fn each(left: &mut [f64], right: impl Iterator<Item = f64>, operation: impl Fn(f64, f64) -> f64) {
    for (a, b) in left.iter_mut().zip(right) {
        *a = operation(*a, b);
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests may fail by panic"
    )]
    use proptest::prelude::*;

    use super::super::code::Function;
    use super::super::random::PassKey;
    use super::*;

    /// Values that expose what goes wrong: zeros of both signs, infinity on the way, steps of comparisons.
    const VALUES: [f64; 9] = [0.0, -0.0, 1.0, -1.0, 0.5, 3.0, 1e200, -1e300, 90.0];

    /// Code for one value.
    fn code() -> impl Strategy<Value = Vec<Op>> {
        let leaf = prop_oneof![
            prop::sample::select(VALUES.to_vec()).prop_map(|v| vec![Op::Push(v)]),
            (0..3_u16).prop_map(|slot| vec![Op::Load(slot)]),
        ];
        leaf.prop_recursive(5, 24, 3, |inner| {
            let binary = prop::sample::select(vec![
                Op::Add,
                Op::Subtract,
                Op::Multiply,
                Op::Divide,
                Op::Remainder,
                Op::Power,
                Op::Less,
                Op::LessEqual,
                Op::Greater,
                Op::GreaterEqual,
                Op::Equal,
                Op::NotEqual,
            ]);
            let unary = prop::sample::select(vec![
                Op::Negate,
                Op::Not,
                Op::Truth,
                Op::Call(Function::Sqrt),
                Op::Call(Function::Sin),
                Op::Call(Function::Sign),
            ]);
            let drawn = prop::sample::select(vec![Function::Uniform, Function::Max]);
            prop_oneof![
                4 => (inner.clone(), inner.clone(), binary)
                    .prop_map(|(a, b, op)| [a, b, vec![op]].concat()),
                1 => (inner.clone(), unary).prop_map(|(a, op)| [a, vec![op]].concat()),
                1 => (inner.clone(), inner.clone(), drawn)
                    .prop_map(|(a, b, f)| [a, b, vec![Op::Call(f)]].concat()),
                1 => prop::collection::vec(inner.clone(), 2..5).prop_map(|values| {
                    let count = u16::try_from(values.len() - 1).unwrap();
                    [values.concat(), vec![Op::Pick(count)]].concat()
                }),
                2 => (inner.clone(), inner, any::<bool>()).prop_map(|(a, b, is_or)| {
                    // Targets are counted from this operation until the code is whole.
                    let past = u32::try_from(b.len()).unwrap() + 2;
                    let jump = if is_or { Op::Or(past) } else { Op::And(past) };
                    [a, vec![jump], b, vec![Op::Truth]].concat()
                }),
            ]
        })
    }

    fn expression(mut code: Vec<Op>) -> Expression {
        for (at, op) in (0..).zip(&mut code) {
            if let Op::And(target) | Op::Or(target) = op {
                *target += at;
            }
        }
        let code = code.into_boxed_slice();
        Expression::Code { code, depth: 32 }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

        #[test]
        fn a_column_holds_what_each_module_gives_alone(code in code(), lanes in 1..40_usize) {
            let expression = expression(code);
            let drawn = expression.may_draw();
            let mut values = Values::new(3, depth(&expression));
            let bound = |lane: usize| [VALUES[lane % 9], VALUES[lane / 9 % 9], VALUES[lane * 7 % 9]];
            let draws = |lane| PassKey::new(1, 2, 3).at(lane);
            for slot in 0..3 {
                let column: Vec<f64> = (0..lanes).map(|lane| bound(lane)[slot]).collect();
                let starts: Vec<usize> = (0..lanes).collect();
                values.gather(slot, &column, &starts, 0, 1);
            }
            values.set_draws((0..lanes).map(draws));
            let computed = values.compute(&expression, lanes).to_vec();
            prop_assert_eq!(computed.len(), lanes);
            // Where draws depend on values, the engine does without columns.
            for (lane, computed) in computed.iter().enumerate().take_while(|_| !drawn) {
                match expression.value(&bound(lane), &mut draws(lane)) {
                    Ok(value) => prop_assert_eq!(computed.to_bits(), value.to_bits(), "lane {}", lane),
                    Err(problem) => prop_assert!(computed.is_nan(), "{problem}, not {computed}"),
                }
            }
        }
    }

    #[test]
    fn neighbours_and_others_are_gathered() {
        let mut values = Values::new(1, 1);
        let parameters = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        for (starts, number, arity, expected) in [
            (vec![1, 2, 3], 0, 1, vec![2.0, 3.0, 4.0]),
            (vec![0, 2, 4], 1, 2, vec![2.0, 4.0, 6.0]),
            (vec![0, 3, 5], 0, 1, vec![1.0, 4.0, 6.0]),
            (vec![5, 6], 0, 1, vec![6.0, 0.0]),
        ] {
            values.gather(0, &parameters, &starts, number, arity);
            let gathered = values.compute(&Expression::Slot(0), starts.len());
            assert_eq!(gathered, expected, "{starts:?}");
        }
    }
}
