//! A kept derivation under random edits and steps against fresh derivations.

use std::sync::atomic::AtomicBool;

use proptest::prelude::*;
use ramus::lsystem::{Grammar, History, Limits};

use super::oracle::{Rule, Spec, rule, spec};
use super::parse;

/// What a person does next.
#[derive(Clone, Debug)]
enum Deed {
    Look(u32),
    /// Puts a production in the place of another one,
    Replace(usize, Rule),
    /// or behind them all.
    Add(Rule),
    Remove(usize),
    Swap(usize),
    Order,
    Axiom,
    /// Says the same in other words, so that symbols are numbered anew.
    Words(bool),
}

fn deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        6 => (0..7_u32).prop_map(Deed::Look),
        2 => (0..6_usize, rule(true)).prop_map(|(at, rule)| Deed::Replace(at, rule)),
        1 => rule(true).prop_map(Deed::Add),
        1 => (0..6_usize).prop_map(Deed::Remove),
        1 => (0..6_usize).prop_map(Deed::Swap),
        1 => Just(Deed::Order),
        1 => Just(Deed::Axiom),
        1 => any::<bool>().prop_map(Deed::Words),
    ]
}

fn grammar(spec: &Spec, words: bool) -> Grammar {
    let before = if words {
        "interpret {\nD -> CBA(1)\n}\n"
    } else {
        ""
    };
    parse(&format!("{before}{}", spec.text()))
}

fn change(spec: &mut Spec, words: &mut bool, deed: &Deed) {
    let count = spec.rules.len();
    match deed {
        Deed::Look(_) => {}
        Deed::Replace(at, rule) if *at < count => spec.rules[*at] = rule.clone(),
        Deed::Replace(_, rule) | Deed::Add(rule) => spec.rules.push(rule.clone()),
        Deed::Remove(at) if *at < count && count > 1 => drop(spec.rules.remove(*at)),
        Deed::Swap(at) if at + 1 < count => spec.rules.swap(*at, at + 1),
        Deed::Remove(_) | Deed::Swap(_) => {}
        Deed::Order => spec.specific = !spec.specific,
        Deed::Axiom => spec.times = spec.times % 3 + 1,
        Deed::Words(more) => *words = *more,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn whatever_is_edited_the_strings_are_those_of_a_fresh_derivation(
        spec in spec(),
        deeds in prop::collection::vec(deed(), 1..12),
        budget in prop::sample::select(vec![0_u64, 300, 1 << 20]),
    ) {
        let mut spec = spec;
        // Productions that come later may name any module in their contexts.
        spec.ignored.clear();
        spec.times = spec.times.min(40);
        let mut words = false;
        // What a person would see as too much is an error both ways.
        let limits = Limits { modules: 5000, ..Limits::default() };
        let cancel = AtomicBool::new(false);
        let mut history = History::new(grammar(&spec, words), budget);
        for deed in &deeds {
            change(&mut spec, &mut words, deed);
            let Deed::Look(step) = deed else {
                history.edit(grammar(&spec, words));
                continue;
            };
            let fresh = grammar(&spec, words).derive(*step, &limits, &cancel);
            match (history.at(*step, &limits, &cancel), fresh) {
                (Ok(kept), Ok(fresh)) => prop_assert_eq!(&*kept, &fresh, "step {} of\n{}", step, spec.text()),
                (Err(kept), Err(fresh)) => prop_assert_eq!(kept.to_string(), fresh.to_string()),
                (kept, fresh) => prop_assert!(false, "step {step}: {kept:?}, not {fresh:?}"),
            }
        }
    }
}
