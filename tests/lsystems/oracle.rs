//! A slow, simple interpreter of random small grammars against the engine: strings and births, both orders, both kinds of
//! context, any number of threads.

use std::fmt::Write as _;

use proptest::prelude::*;
use ramus::lsystem::{DeriveProblem, ModuleString};

use super::{derive, draw, parse};

/// A module: name, at most one parameter, birth.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mod {
    name: char,
    value: Option<i64>,
    birth: u32,
}

/// A successor's module: its parameter is a bound one (counted over predecessor, left, right) plus a number.
#[derive(Clone, Debug)]
struct Template {
    name: char,
    from: usize,
    plus: i64,
    /// `6 % (the bound parameter - this)` is added, which may divide by zero.
    faulty: Option<i64>,
}

impl Template {
    fn plain(name: char, plus: i64) -> Self {
        Self {
            name,
            from: 0,
            plus,
            faulty: None,
        }
    }

    /// `None`: division by zero.
    fn value(&self, bound: &[i64]) -> Option<i64> {
        let Some(value) = bound.get(self.from) else {
            return Some(self.plus);
        };
        let more = match self.faulty {
            Some(zero) => 6_i64.checked_rem(value - zero)?,
            None => 0,
        };
        Some(value + self.plus + more)
    }
}

#[derive(Clone, Debug)]
pub(super) struct Rule {
    pred: char,
    left: Vec<char>,
    right: Vec<char>,
    /// The first bound parameter is at least this.
    at_least: Option<i64>,
    /// `6 % (that parameter - this) < 4`, too, which may divide by zero; asked for second.
    faulty: Option<i64>,
    successor: Vec<Template>,
}

#[derive(Clone, Debug)]
pub(super) struct Spec {
    pub(super) rules: Vec<Rule>,
    axiom: Vec<Template>,
    /// The axiom stands so often in a row.
    pub(super) times: usize,
    pub(super) ignored: Vec<char>,
    literal: bool,
    pub(super) specific: bool,
}

struct ZeroDivision;

/// A and C have a parameter, the others none.
fn has_parameter(name: char) -> bool {
    matches!(name, 'A' | 'C')
}

fn bound_names(rule: &Rule) -> Vec<String> {
    let all = std::iter::once(rule.pred)
        .chain(rule.left.iter().copied())
        .chain(rule.right.iter().copied());
    all.filter(|n| has_parameter(*n))
        .enumerate()
        .map(|(i, _)| format!("p{i}"))
        .collect()
}

impl Spec {
    pub(super) fn text(&self) -> String {
        let mut text = String::new();
        if self.literal {
            text += "context literal\n";
        } else if !self.ignored.is_empty() {
            writeln!(text, "ignore {}", self.ignored.iter().collect::<String>()).unwrap();
        }
        if self.specific {
            text += "order specific\n";
        }
        let axiom = templates(&self.axiom, &[]).repeat(self.times);
        writeln!(text, "axiom {axiom}").unwrap();
        for rule in &self.rules {
            let names = bound_names(rule);
            let mut next = names.iter();
            let mut written = |list: &[char]| -> String {
                list.iter()
                    .map(|n| {
                        if has_parameter(*n) {
                            format!("{n}({})", next.next().unwrap())
                        } else {
                            n.to_string()
                        }
                    })
                    .collect()
            };
            let (pred, left, right) = (
                written(&[rule.pred]),
                written(&rule.left),
                written(&rule.right),
            );
            if !left.is_empty() {
                write!(text, "{left} < ").unwrap();
            }
            text += &pred;
            if !right.is_empty() {
                write!(text, " > {right}").unwrap();
            }
            if let (Some(least), Some(name)) = (rule.at_least, names.first()) {
                write!(text, " : {name} >= {least}").unwrap();
                if let Some(zero) = rule.faulty {
                    write!(text, " && 6 % ({name} - {zero}) < 4").unwrap();
                }
            }
            writeln!(text, " -> {}", templates(&rule.successor, &names)).unwrap();
        }
        text
    }

    fn has_condition(rule: &Rule) -> bool {
        rule.at_least.is_some() && !bound_names(rule).is_empty()
    }

    fn ordered(&self) -> Vec<&Rule> {
        let mut rules: Vec<&Rule> = self.rules.iter().collect();
        if self.specific {
            let length =
                |r: &Rule| r.left.len() + r.right.iter().filter(|c| !"[]".contains(**c)).count();
            rules.sort_by_key(|r| std::cmp::Reverse((length(r), Self::has_condition(r))));
        }
        rules
    }

    /// The string, or the step and the position of the first module that cannot be computed.
    fn derive(&self, steps: u32) -> Result<Vec<Mod>, (u32, usize)> {
        let axiom = self.axiom.iter().map(|t| Mod {
            name: t.name,
            value: has_parameter(t.name).then_some(t.plus),
            birth: 0,
        });
        let mut string: Vec<Mod> = axiom.collect::<Vec<_>>().repeat(self.times);
        let ordered = self.ordered();
        for step in 1..=steps {
            string = cut(&string);
            let mut next = Vec::new();
            // A production is found for each before any is applied.
            let mut chosen = Vec::new();
            for at in 0..string.len() {
                let mut found = None;
                for rule in &ordered {
                    let matched = self.matches(rule, &string, at);
                    if let Some(bound) = matched.map_err(|ZeroDivision| (step, at))? {
                        found = Some((*rule, bound));
                        break;
                    }
                }
                chosen.push(found);
            }
            for (at, found) in chosen.into_iter().enumerate() {
                let Some((rule, bound)) = found else {
                    next.push(string[at]);
                    continue;
                };
                let mut inherited = false;
                for t in &rule.successor {
                    let value = match has_parameter(t.name) {
                        true => Some(t.value(&bound).ok_or((step, at))?),
                        false => None,
                    };
                    let same = !inherited && t.name == string[at].name && value == string[at].value;
                    inherited |= same;
                    next.push(Mod {
                        name: t.name,
                        value,
                        birth: if same { string[at].birth } else { step },
                    });
                }
            }
            string = next;
        }
        Ok(cut(&string))
    }

    fn matches(
        &self,
        rule: &Rule,
        string: &[Mod],
        at: usize,
    ) -> Result<Option<Vec<i64>>, ZeroDivision> {
        let Some(bound) = self.bound(rule, string, at) else {
            return Ok(None);
        };
        if let (Some(least), Some(first)) = (rule.at_least, bound.first()) {
            if first < &least {
                return Ok(None);
            }
            if let Some(zero) = rule.faulty
                && 6_i64.checked_rem(first - zero).ok_or(ZeroDivision)? >= 4
            {
                return Ok(None);
            }
        }
        Ok(Some(bound))
    }

    /// What the production binds where its contexts match.
    fn bound(&self, rule: &Rule, string: &[Mod], at: usize) -> Option<Vec<i64>> {
        if string[at].name != rule.pred {
            return None;
        }
        let mut bound: Vec<i64> = string[at].value.into_iter().collect();
        // Left: nearest first, then turned round.
        let mut left = Vec::new();
        let mut here = at;
        for wanted in rule.left.iter().rev() {
            here = self.left_of(string, here)?;
            if string[here].name != *wanted {
                return None;
            }
            left.splice(0..0, string[here].value);
        }
        bound.extend(left);
        if self.literal {
            for (i, wanted) in rule.right.iter().enumerate() {
                let found = string.get(at + 1 + i)?;
                if found.name != *wanted {
                    return None;
                }
                bound.extend(found.value);
            }
        } else {
            bound.extend(self.right(&rule.right, string, at + 1)?);
        }
        Some(bound)
    }

    fn left_of(&self, string: &[Mod], mut at: usize) -> Option<usize> {
        loop {
            at = at.checked_sub(1)?;
            match string[at].name {
                '[' | ']' if self.literal => return None,
                ']' => {
                    let mut depth = 1;
                    while depth > 0 {
                        at = at.checked_sub(1)?;
                        depth +=
                            i32::from(string[at].name == ']') - i32::from(string[at].name == '[');
                    }
                }
                '[' => {}
                n if !self.literal && self.ignored.contains(&n) => {}
                _ => return Some(at),
            }
        }
    }

    fn right(&self, pattern: &[char], string: &[Mod], mut at: usize) -> Option<Vec<i64>> {
        let mut bound = Vec::new();
        let mut k = 0;
        while k < pattern.len() {
            let found = string.get(at)?;
            if found.name == ']' {
                return None;
            }
            if self.ignored.contains(&found.name) {
                at += 1;
                continue;
            }
            if pattern[k] == '[' {
                if found.name != '[' {
                    return None;
                }
                let close = partner(|i| pattern.get(i).copied(), k);
                if let Some(inner) = self.right(&pattern[k + 1..close], string, at + 1) {
                    bound.extend(inner);
                    k = close + 1;
                }
                at = partner(|i| string.get(i).map(|m| m.name), at) + 1;
                continue;
            }
            if found.name == '[' {
                at = partner(|i| string.get(i).map(|m| m.name), at) + 1;
            } else if found.name == pattern[k] {
                bound.extend(found.value);
                k += 1;
                at += 1;
            } else {
                return None;
            }
        }
        Some(bound)
    }
}

/// The bracket that closes the one at `at`.
fn partner(name: impl Fn(usize) -> Option<char>, mut at: usize) -> usize {
    let mut depth = 0;
    loop {
        match name(at) {
            Some('[') => depth += 1,
            Some(']') => depth -= 1,
            Some(_) => {}
            None => return at,
        }
        if depth == 0 {
            return at;
        }
        at += 1;
    }
}

fn cut(string: &[Mod]) -> Vec<Mod> {
    let mut kept = Vec::new();
    let mut at = 0;
    while at < string.len() {
        if string[at].name == '%' {
            while at < string.len() && string[at].name != ']' {
                at = partner(|i| string.get(i).map(|m| m.name), at) + 1;
            }
        } else {
            kept.push(string[at]);
            at += 1;
        }
    }
    kept
}

fn templates(list: &[Template], names: &[String]) -> String {
    if list.is_empty() {
        return "*".into();
    }
    list.iter()
        .map(|t| match names.get(t.from) {
            _ if !has_parameter(t.name) => t.name.to_string(),
            Some(name) => match t.faulty {
                Some(zero) => format!("{}({name} + {} + 6 % ({name} - {zero}))", t.name, t.plus),
                None => format!("{}({name} + {})", t.name, t.plus),
            },
            None => format!("{}({})", t.name, t.plus),
        })
        .collect()
}

fn of_engine(grammar: &ramus::lsystem::Grammar, string: &ModuleString) -> Vec<Mod> {
    string
        .iter()
        .map(|m| Mod {
            name: grammar.name(m.symbol).chars().next().unwrap(),
            value: m.parameters.first().map(|v| *v as i64),
            birth: m.birth,
        })
        .collect()
}

/// Mostly nothing, else a number that a parameter may become.
fn rarely() -> impl Strategy<Value = Option<i64>> {
    prop_oneof![8 => Just(None), 1 => (3..40_i64).prop_map(Some)]
}

/// Balanced successors: a list of modules, some of them in branches.
fn successor() -> impl Strategy<Value = Vec<Template>> {
    let one = (
        prop::sample::select(vec!['A', 'B', 'C', 'D', 'F', '%']),
        0..3_usize,
        0..3_i64,
        rarely(),
    )
        .prop_map(|(name, from, plus, faulty)| Template {
            name,
            from,
            plus,
            faulty,
        });
    let leaf = prop::collection::vec(one, 0..3);
    leaf.prop_recursive(2, 8, 3, |inner| {
        prop::collection::vec((inner, any::<bool>()), 1..3).prop_map(|parts| {
            let bracket = |name| Template::plain(name, 0);
            let mut list = Vec::new();
            for (part, branch) in parts {
                if branch {
                    list.push(bracket('['));
                    list.extend(part);
                    list.push(bracket(']'));
                } else {
                    list.extend(part);
                }
            }
            list
        })
    })
}

fn letters(least: usize) -> impl Strategy<Value = Vec<char>> {
    prop::collection::vec(
        prop::sample::select(vec!['A', 'B', 'C', 'D', 'F']),
        least..3,
    )
}

pub(super) fn rule(literal: bool) -> impl Strategy<Value = Rule> {
    let inner = (letters(1), letters(1), any::<bool>()).prop_map(|(mut outer, inner, nested)| {
        if nested {
            let at = outer.len().min(1);
            outer.splice(
                at..at,
                std::iter::once('[')
                    .chain(inner)
                    .chain(std::iter::once(']')),
            );
        }
        outer
    });
    let right = (letters(0), inner, any::<bool>(), 0..3_usize).prop_map(
        move |(plain, inner, branch, at)| {
            let mut right = plain;
            if branch && !literal {
                let at = at.min(right.len());
                right.splice(
                    at..at,
                    std::iter::once('[')
                        .chain(inner)
                        .chain(std::iter::once(']')),
                );
            }
            right
        },
    );
    let right = prop_oneof![2 => Just(Vec::new()), 3 => right];
    (
        prop::sample::select(vec!['A', 'B', 'C', 'D']),
        prop_oneof![2 => Just(Vec::new()), 2 => letters(0)],
        right,
        (prop::option::of(0..4_i64), rarely()),
        successor(),
    )
        .prop_map(|(pred, left, right, (at_least, faulty), successor)| Rule {
            pred,
            left,
            right,
            at_least,
            faulty,
            successor,
        })
}

pub(super) fn spec() -> impl Strategy<Value = Spec> {
    let flags = (any::<bool>(), any::<bool>(), any::<bool>(), any::<bool>());
    flags.prop_flat_map(|(literal, specific, cuts, alone)| {
        let ignored = prop_oneof![Just(vec![]), Just(vec!['F']), Just(vec!['F', 'D'])];
        (
            prop::collection::vec(rule(literal), 1..6),
            successor(),
            ignored,
            // Short strings, and such as are worked on in batches.
            prop_oneof![3 => Just(1), 1 => 20..400_usize],
        )
            .prop_map(move |(mut rules, mut axiom, ignored, times)| {
                axiom.insert(0, Template::plain('A', 1));
                axiom.push(Template::plain('B', 0));
                let ignored = if literal { vec![] } else { ignored };
                if alone {
                    for rule in &mut rules {
                        rule.left.clear();
                        rule.right.clear();
                    }
                }
                if !cuts {
                    axiom.retain(|module| module.name != '%');
                    for rule in &mut rules {
                        rule.successor.retain(|module| module.name != '%');
                    }
                }
                // A context that names one that is skipped is an error.
                for rule in &mut rules {
                    rule.left.retain(|name| !ignored.contains(name));
                    rule.right.retain(|name| !ignored.contains(name));
                }
                Spec {
                    rules,
                    axiom,
                    times,
                    ignored,
                    literal,
                    specific,
                }
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6000, ..ProptestConfig::default() })]

    #[test]
    fn the_engine_does_what_the_slow_interpreter_does(spec in spec()) {
        let text = spec.text();
        let grammar = parse(&text);
        for steps in 0..8 {
            let slow = match spec.derive(steps) {
                Ok(slow) => slow,
                Err(fault) => {
                    prop_assert_eq!(fault_of(&grammar, steps), fault, "in\n{}", &text);
                    break;
                }
            };
            let fast = of_engine(&grammar, &derive(&grammar, steps));
            prop_assert_eq!(&fast, &slow, "after {} steps of\n{}", steps, &text);
            if slow.len() > 2000 {
                break;
            }
        }
    }
}

/// The step and the position of the module that cannot be computed.
fn fault_of(grammar: &ramus::lsystem::Grammar, steps: u32) -> (u32, usize) {
    let (limits, cancel) = (
        Default::default(),
        std::sync::atomic::AtomicBool::new(false),
    );
    let error = grammar.derive(steps, &limits, &cancel).unwrap_err();
    match *error.problem {
        DeriveProblem::Value { step, position, .. } => (step, position.try_into().unwrap()),
        other => panic!("another fault: {other}"),
    }
}

/// Strings, trees and errors do not depend on the number of threads.
#[test]
fn any_number_of_threads() {
    let text = "ignore +\naxiom A(1)[B]A(2)\nA(x) < B > A(y) -> B A(x+y)\nA(x) : x > 40 -> A(x/3)\n\
                A(x) : weight 1 -> A(x+1)[+B A(uniform(0, x))]F(x)\nA(x) : weight 2 -> A(x)B[A(normal(x, 0.1)*0.5+1)]A(1)\n\
                B > A(x) -> B\nB : weight 1 -> B+F(1)\nB : weight 1 -> F(2)B\n";
    let grammar = parse(text);
    let bad = parse(&text.replace("F(2)B", "F(1/0)B"));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let string = derive(&grammar, 12);
            let tree = draw(&grammar, &string);
            let error = bad
                .derive(
                    12,
                    &ramus::lsystem::Limits::default(),
                    &std::sync::atomic::AtomicBool::new(false),
                )
                .unwrap_err();
            (string, tree, error)
        })
    };
    let one = run(1);
    assert!(
        one.0.len() > 100_000,
        "{} modules: large enough for several chunks",
        one.0.len()
    );
    for threads in [2, 5] {
        assert!(run(threads) == one, "{threads} threads");
    }
}
