//! Decompositions that never end, whatever the parameters: found in the productions, before rounds make a string of them that no
//! machine holds.

use super::grammar::{Plan, Rule, RuleSet};
use super::names::Symbol;

/// The production of a symbol to which it always applies.
fn always(rules: &RuleSet, symbol: usize) -> Option<&Rule> {
    match rules.plan(Symbol::try_from(symbol).ok()?) {
        Plan::Always(number) => rules.rules.get(usize::from(number)),
        _ => None,
    }
}

/// For each symbol whether its modules are rewritten forever: a production that always applies makes it again, at once or
/// by way of others. Empty where there are none.
pub(super) fn endless(rules: &RuleSet, symbols: usize) -> Vec<bool> {
    // Successors of each symbol that have not been seen to end, and whose successors it stands in.
    let mut left = vec![0_usize; symbols];
    let mut makers: Vec<Vec<usize>> = vec![Vec::new(); symbols];
    for (maker, left) in left.iter_mut().enumerate() {
        for made in always(rules, maker).iter().flat_map(|r| &r.successor) {
            if let Some(makers) = makers.get_mut(usize::from(*made)) {
                makers.push(maker);
                *left += 1;
            }
        }
    }
    let mut ending: Vec<usize> = (0..symbols).filter(|s| left.get(*s) == Some(&0)).collect();
    while let Some(symbol) = ending.pop() {
        for maker in makers.get(symbol).into_iter().flatten() {
            if let Some(left) = left.get_mut(*maker) {
                *left -= 1;
                if *left == 0 {
                    ending.push(*maker);
                }
            }
        }
    }
    if left.iter().all(|left| *left == 0) {
        return Vec::new();
    }
    left.iter().map(|left| *left > 0).collect()
}

/// A production of the cycle that an endless symbol comes to.
pub(super) fn cycle<'r>(rules: &'r RuleSet, endless: &[bool], from: Symbol) -> Option<&'r Rule> {
    let goes_on = |symbol: &Symbol| endless.get(usize::from(*symbol)) == Some(&true);
    let mut rule = always(rules, usize::from(from))?;
    // After as many productions as there are symbols, one has come again.
    for _ in endless {
        let next = rule.successor.iter().copied().find(goes_on)?;
        rule = always(rules, usize::from(next))?;
    }
    Some(rule)
}
