//! What chance alone decides, as a table: for each symbol its choices and the draws up to which each is meant.
//!
//! With few choices for each symbol, a module's is found without a branch of the program's, which the processor would guess wrong as
//! often as chance has it: by counting the bounds that a draw has reached. Symbols that always become the same, or stay, have one choice.

use super::names::Symbol;

/// Choices of a symbol at most.
const MOST: usize = 4;
/// No draw reaches it.
const NEVER: u64 = u64::MAX;
/// Draws have so many bits.
pub(super) const BITS: u32 = 53;

/// One of the choices of a symbol and the draw up to which it is meant.
pub(crate) type Bound = (u16, u64);

/// The choices of one symbol.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    /// Draws from each of these on mean the next choice.
    bounds: [u64; MOST - 1],
    choices: [u16; MOST],
}

/// The choices by symbol.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chances {
    rows: Vec<Row>,
    /// Whether any symbol has more than one.
    pub(crate) draws: bool,
}

impl Chances {
    /// The table of these choices; `None` where a symbol has too many.
    pub(crate) fn new<'b>(symbols: impl Iterator<Item = &'b [Bound]>) -> Option<Self> {
        let row = |all: &[Bound]| {
            let mut row = Row {
                bounds: [NEVER; MOST - 1],
                choices: [0; MOST],
            };
            if all.len() > MOST {
                return None;
            }
            for (place, (choice, _)) in row.choices.iter_mut().zip(all) {
                *place = *choice;
            }
            // The last bound is beyond all draws.
            let bounds = all.iter().take(all.len().saturating_sub(1));
            for (place, (_, bound)) in row.bounds.iter_mut().zip(bounds) {
                *place = *bound;
            }
            Some(row)
        };
        let rows: Option<Vec<Row>> = symbols.map(row).collect();
        let rows = rows?;
        let draws = rows.iter().any(|row| row.bounds != [NEVER; MOST - 1]);
        Some(Self { rows, draws })
    }

    /// The choice of a symbol that a draw means.
    #[inline]
    pub(crate) fn choice(&self, symbol: Symbol, draw: u64) -> u16 {
        let Some(row) = self.rows.get(usize::from(symbol)) else {
            return 0;
        };
        let reached: usize = row.bounds.iter().map(|b| usize::from(draw >= *b)).sum();
        row.choices.get(reached).copied().unwrap_or(0)
    }
}

/// The choices of a symbol with the draws up to which each is meant, by their weights; the last takes what rounding leaves. Empty where
/// the sum of the weights is no number.
pub(crate) fn bounds(weighted: &[(u16, f64)]) -> Vec<Bound> {
    let total: f64 = weighted.iter().map(|one| one.1).sum();
    if !total.is_finite() {
        return Vec::new();
    }
    let mut sum = 0.0;
    let mut bounds: Vec<Bound> = weighted
        .iter()
        .map(|(choice, weight)| {
            sum += *weight;
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a part of 1 in 53 bits"
            )]
            let bound = (sum / total * (1_u64 << BITS) as f64).ceil() as u64;
            (*choice, bound)
        })
        .collect();
    if let Some((_, last)) = bounds.last_mut() {
        *last = NEVER;
    }
    bounds
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::*;

    #[test]
    fn draws_mean_choices_in_the_proportion_of_their_weights() {
        for weights in [
            vec![1.0],
            vec![1.0, 1.0],
            vec![0.33, 0.33, 0.34],
            vec![1e-300, 3.0, 1e-9, 2.0],
        ] {
            let weighted: Vec<(u16, f64)> = (1..).zip(weights.iter().copied()).collect();
            let bounds = bounds(&weighted);
            let table = Chances::new([bounds.as_slice(), &[(9, NEVER)]].into_iter()).unwrap();
            let total: f64 = weights.iter().sum();
            for step in 0..1000 {
                let draw = step * ((1 << BITS) / 1000);
                let part = draw as f64 / (1_u64 << BITS) as f64;
                let mut sum = 0.0;
                let up_to = |one: &&(u16, f64)| {
                    sum += one.1;
                    part < sum / total
                };
                let expected = weighted
                    .iter()
                    .find(up_to)
                    .unwrap_or(weighted.last().unwrap());
                assert_eq!(table.choice(0, draw), expected.0, "{weights:?} {part}");
                assert_eq!(table.choice(1, draw), 9);
            }
            assert_eq!(
                table.choice(0, (1 << BITS) - 1),
                u16::try_from(weights.len()).unwrap()
            );
        }
        let many = bounds(&[(1, 1.0), (2, 1.0), (3, 1.0), (4, 1.0), (5, 1.0)]);
        assert!(Chances::new([many.as_slice()].into_iter()).is_none());
        assert!(bounds(&[(1, f64::MAX), (2, f64::MAX)]).is_empty());
    }
}
