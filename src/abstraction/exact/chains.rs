//! Productions that are each the one before with another called in its place: `A -> … B … B`, `B -> … C … C`. They are one, which counts down to the last.
//!
//! Families are told class by class; here whole productions are compared, with all that stands written out in them, so that a rule of several forks that
//! repeats itself is found whatever it ends in.

use hashbrown::HashMap;

use super::classes::{Entry, Roll};
use super::write::{Rule, Target, Writer};

/// Modules and parameters that counting takes besides those of calls: two conditions, another head with its parameters.
const OVERHEAD: u64 = 8;

/// Classes from the last one on: each is called by the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Chains {
    pub(super) all: Vec<Vec<u32>>,
    /// The chain of a class, and its place there.
    of: HashMap<u32, (u32, u32)>,
}

/// What a production is made of, as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Branch([u32; 4], Roll),
    End,
    Segment,
    /// A call of a plain class,
    Class(u32),
    /// or of another rule, of some level.
    Rule(Rule, i64),
}

impl Chains {
    pub(super) fn of(&self, class: u32) -> Option<(u32, u32)> {
        self.of.get(&class).copied()
    }

    /// The chains among the rules that are needed.
    pub(super) fn new(writer: &Writer<'_>, rules: &[Rule]) -> Self {
        let mut plain: Vec<u32> = rules
            .iter()
            .filter_map(|rule| match rule {
                Rule::Plain(class) => Some(*class),
                _ => None,
            })
            .collect();
        // Classes stand behind what they are made of.
        plain.sort_unstable();
        let parts: HashMap<u32, Vec<Part>> = plain
            .iter()
            .map(|class| (*class, parts(writer, *class)))
            .collect();
        let mut links: HashMap<u32, u32> = HashMap::new();
        let mut is_below: HashMap<u32, u32> = HashMap::new();
        for class in &plain {
            let called = parts
                .get(class)
                .into_iter()
                .flatten()
                .filter_map(|part| match part {
                    Part::Class(called) => Some(*called),
                    _ => None,
                });
            let mut tried: Vec<u32> = called.collect();
            tried.sort_unstable_by(|a, b| b.cmp(a));
            tried.dedup();
            let next = tried.into_iter().take(4).find(|below| {
                !is_below.contains_key(below) && repeats(&parts, *class, *below, links.get(below))
            });
            if let Some((below, tail)) = next.and_then(|below| {
                let tail = replaced(&parts, *class, below)?;
                Some((below, tail))
            }) {
                links.insert(*class, below);
                is_below.insert(below, *class);
                links.entry(below).or_insert(tail);
                is_below.entry(tail).or_insert(below);
            }
        }
        let mut chains = Self::default();
        for top in plain
            .iter()
            .rev()
            .filter(|class| !is_below.contains_key(*class))
        {
            let mut members = vec![*top];
            while let Some(below) = members.last().and_then(|last| links.get(last)) {
                members.push(*below);
            }
            members.reverse();
            let body = parts.get(top).map_or(0, Vec::len) as u64;
            let saved = (members.len() as u64).saturating_sub(2) * body;
            if members.len() < 3
                || saved <= OVERHEAD
                || members.iter().any(|one| chains.of.contains_key(one))
            {
                continue;
            }
            let number = u32::try_from(chains.all.len()).unwrap_or(u32::MAX);
            chains.of.extend(
                members
                    .iter()
                    .copied()
                    .zip((0..).map(|place| (number, place))),
            );
            chains.all.push(members);
        }
        chains
    }
}

/// Whether a class is another with that one called where that one calls a third, which is known if that is a link already.
fn repeats(parts: &HashMap<u32, Vec<Part>>, class: u32, below: u32, known: Option<&u32>) -> bool {
    let third = replaced(parts, class, below);
    third.is_some_and(|third| known.is_none_or(|known| *known == third))
}

/// The class that another calls wherever the first calls that other; none where they differ in more.
fn replaced(parts: &HashMap<u32, Vec<Part>>, class: u32, below: u32) -> Option<u32> {
    let (upper, lower) = (parts.get(&class)?, parts.get(&below)?);
    if upper.len() != lower.len() {
        return None;
    }
    let mut third = None;
    for pair in upper.iter().zip(lower) {
        let agree = match pair {
            (Part::Class(called), Part::Class(instead)) if *called == below => {
                *third.get_or_insert(*instead) == *instead
            }
            (upper, lower) => upper == lower,
        };
        if !agree {
            return None;
        }
    }
    third.filter(|third| parts.contains_key(third))
}

/// What a plain class's production is made of.
fn parts(writer: &Writer<'_>, class: u32) -> Vec<Part> {
    let mut parts = vec![Part::Segment];
    let mut open = vec![(class, 0)];
    while let Some((class, at)) = open.last_mut() {
        let entries: &[Entry] = &writer.classes.all[*class as usize].entries;
        let Some(entry) = entries.get(*at) else {
            open.pop();
            parts.push(Part::End);
            continue;
        };
        *at += 1;
        parts.push(Part::Branch(entry.stance(), entry.roll));
        match writer.target(entry.class) {
            Target::Call(Rule::Plain(class), _) => parts.push(Part::Class(class)),
            Target::Call(rule, _) => {
                let level = writer.rule(entry.class).and_then(|(_, level)| level);
                parts.push(Part::Rule(rule, level.unwrap_or(0)));
            }
            Target::Inline(class) => {
                parts.push(Part::Segment);
                open.push((class, 0));
            }
        }
    }
    parts
}
