//! Which modules rest whatever their parameters are: those whose productions all want another module to their right.
//!
//! Most of a grown plant is wood that its productions leave alone: an end moves on where a bud follows, a branch appears between two segments. One look into
//! a table says so of a module and its neighbour, which is neither gathered with others nor compared with contexts then.

use super::column::Narrow;
use super::grammar::{Pattern, Plan, Rule};

/// There is no table for more symbols.
const MOST_SYMBOLS: usize = 256;

/// Which modules may be rewritten.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Rests {
    /// Places of a row: for each symbol, for the end of the string, and for what is not known.
    width: usize,
    /// By symbol and what is next to it: whether a production may apply. Empty where there are too many symbols.
    open: Vec<bool>,
}

impl Rests {
    /// Of productions, which are found by symbol.
    pub(crate) fn new(plans: &[Plan], by_symbol: &[Vec<u16>], rules: &[Rule]) -> Self {
        let symbols = plans.len();
        let width = symbols + 2;
        if symbols > MOST_SYMBOLS {
            return Self::default();
        }
        let mut open = vec![false; symbols * width];
        for ((row, plan), numbers) in open.chunks_mut(width).zip(plans).zip(by_symbol) {
            if *plan == Plan::Stay {
                continue;
            }
            let rules = numbers.iter().map(|number| rules.get(usize::from(*number)));
            for rule in rules.flatten() {
                match rule.right.first().map(Pattern::symbol) {
                    Some(Some(next)) => {
                        for place in [usize::from(next), width - 1] {
                            row[place] = true;
                        }
                    }
                    // Any neighbour does, or a branch.
                    Some(None) | None => row.fill(true),
                }
            }
        }
        Self { width, open }
    }

    /// How many of the modules at the beginning of `symbols` rest, up to `most`. Contexts see the module next to each where `plain`; behind `symbols` the string
    /// ends.
    pub(super) fn resting<S: Narrow>(&self, symbols: &[S], most: usize, plain: bool) -> usize {
        if self.open.is_empty() {
            return 0;
        }
        let [end, unknown] = [self.width.wrapping_sub(2), self.width.wrapping_sub(1)];
        let rests = |symbol: S, next: usize| {
            let symbol: usize = symbol.into();
            self.open.get(symbol * self.width + next) == Some(&false)
        };
        let most = symbols.get(..most).unwrap_or(symbols);
        if !plain {
            let woken = most.iter().position(|symbol| !rests(*symbol, unknown));
            return woken.unwrap_or(most.len());
        }
        let following = symbols.get(1..).unwrap_or(&[]);
        let mut pairs = most.iter().zip(following);
        if let Some(woken) = pairs.position(|(symbol, next)| !rests(*symbol, (*next).into())) {
            return woken;
        }
        // The last one of the string has nothing behind it.
        let last = most.get(following.len());
        most.len() - usize::from(last.is_some_and(|symbol| !rests(*symbol, end)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::super::column::Column;
    use super::super::grammar::Grammar;

    #[test]
    fn modules_rest_where_no_production_wants_their_neighbour() {
        // Of each module of ACADBCBAC: A before B or D, B always, C never, D before the end.
        let text = "context literal\naxiom A(0)CA(0)DBCBA(0)CD\nA(x) > B : x > 0 -> A(x)\nA(x) > D : x > 0 -> A(x)\nB : 1 > 0 -> B\nD > E : 1 > 0 -> D\n";
        let grammar = Grammar::parse(text, "rests").unwrap();
        let Column::Byte(symbols) = &grammar.axiom.symbols else {
            panic!("few symbols are bytes");
        };
        let rests = &grammar.rules.rests;
        let alone = |plain: bool| -> String {
            let rests = (0..symbols.len()).map(|at| rests.resting(&symbols[at..], 1, plain) == 1);
            rests.map(|rests| if rests { '-' } else { 'o' }).collect()
        };
        assert_eq!(alone(true), "--o-o-o---");
        assert_eq!(alone(false), "o-ooo-oo-o");
        assert_eq!(rests.resting(symbols, 9, true), 2);
        assert_eq!(rests.resting(&symbols[7..], 3, true), 3);
        assert_eq!(rests.resting(&symbols[7..], 1, true), 1);
    }
}
