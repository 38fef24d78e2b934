//! A plan and its productions as a grammar's text.

use hashbrown::HashMap;

use super::axiom::Axiom;
use super::chains::Chains;
use super::classes::{Classes, Entry, LEAF, Roll};
use super::forms::{Beside, Form, Forms};
use super::out::{Out, Size, name, plus, times};
use super::plan::{Plan, Word};

/// What a production makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Rule {
    Plain(u32),
    Family(u32),
    Run(u32),
    Chain(u32),
}

/// Which productions there are, and how often each is called.
#[derive(Debug, Default)]
pub(super) struct Needed {
    /// In the order in which they are met.
    pub(super) rules: Vec<Rule>,
    pub(super) calls: HashMap<Rule, u64>,
}

/// What productions are made of.
#[derive(Clone, Copy)]
pub(super) struct Writer<'a> {
    pub(super) classes: &'a Classes,
    pub(super) forms: &'a Forms,
    /// Whether a class that is written plainly has a production of its own.
    pub(super) named: &'a [bool],
    pub(super) chains: &'a Chains,
    /// The class that a chain's own production has in place of what it calls one lower.
    pub(super) next: Option<u32>,
    pub(super) one_radius: bool,
}

/// What stands at a branch.
pub(super) enum Target {
    /// A module of a rule, with its level.
    Call(Rule, Option<String>),
    /// What the class is made of.
    Inline(u32),
}

/// A class whose branches are being written.
struct Level {
    class: u32,
    length: f64,
    radius: f64,
    next: usize,
    /// Which rule's own branches these are.
    of: Option<Rule>,
}

impl Writer<'_> {
    /// The rule that a class is made by, if it is by one, and its level.
    pub(super) fn rule(&self, class: u32) -> Option<(Rule, Option<i64>)> {
        match self.forms.of[class as usize] {
            Form::Leaf => None,
            Form::Plain => match self.chains.of(class) {
                Some((chain, place)) => Some((Rule::Chain(chain), Some(i64::from(place)))),
                None => self.named[class as usize].then_some((Rule::Plain(class), None)),
            },
            Form::Level { family, level } => Some((Rule::Family(family), Some(i64::from(level)))),
            Form::Run { run, count } => Some((Rule::Run(run), Some(i64::from(count)))),
        }
    }

    /// What a class's module stands for.
    pub(super) fn target(&self, class: u32) -> Target {
        match self.rule(class) {
            Some((rule, Some(_))) if self.next == Some(class) => {
                Target::Call(rule, Some("n-1".to_owned()))
            }
            Some((rule, level)) => Target::Call(rule, level.map(|level| level.to_string())),
            None => Target::Inline(class),
        }
    }

    /// What stands at a branch of a rule's own.
    fn branch(&self, of: Option<Rule>, place: usize, entry: &Entry) -> Target {
        match of {
            Some(Rule::Family(family)) => {
                let slot = self.forms.families[family as usize].slots[place];
                match slot.level() {
                    None => self.target(entry.class),
                    Some(family) => Target::Call(
                        Rule::Family(family),
                        Some(plus("n", -i64::from(slot.below))),
                    ),
                }
            }
            Some(Rule::Run(run)) => match self.forms.runs[run as usize].beside[place] {
                None => Target::Call(Rule::Run(run), Some("n-1".to_owned())),
                Some(Beside::Same(class)) => self.target(class),
                Some(Beside::Level { family, above }) => {
                    Target::Call(Rule::Family(family), Some(plus("n", above)))
                }
            },
            _ => self.target(entry.class),
        }
    }

    /// The class whose branches a rule's production has.
    fn model(&self, rule: Rule) -> u32 {
        match rule {
            Rule::Plain(class) => class,
            Rule::Family(family) => self.forms.families[family as usize].top,
            Rule::Run(run) => self.forms.runs[run as usize].top,
            Rule::Chain(chain) => {
                let members = &self.chains.all[chain as usize];
                members.last().copied().unwrap_or(LEAF)
            }
        }
    }

    /// What a rule ends with instead of its own branches, and the level at which it does.
    fn end(&self, rule: Rule) -> Option<(u32, u32)> {
        match rule {
            Rule::Plain(_) => None,
            Rule::Family(family) => {
                let base = self.forms.families[family as usize].base();
                base.map(|(class, level)| (level, class))
            }
            Rule::Run(run) => Some((0, self.forms.runs[run as usize].tail)),
            Rule::Chain(chain) => {
                let members = &self.chains.all[chain as usize];
                members.first().map(|last| (0, *last))
            }
        }
    }

    /// What stands at a rule's end: that of a chain is its own.
    fn at_end(&self, rule: Rule, class: u32) -> Target {
        match rule {
            Rule::Chain(_) => Target::Inline(class),
            _ => self.target(class),
        }
    }

    /// All rules that are called from these classes.
    pub(super) fn needed(&self, parts: &[u32]) -> Needed {
        let mut needed = Needed::default();
        let mut open = Vec::new();
        for class in parts {
            open.extend(self.rule(*class).map(|(rule, _)| rule));
        }
        open.reverse();
        while let Some(rule) = open.pop() {
            let calls = needed.calls.entry(rule).or_insert(0);
            *calls += 1;
            if *calls > 1 {
                continue;
            }
            needed.rules.push(rule);
            let mut called = Vec::new();
            self.walk(rule, &mut |target| {
                if let Target::Call(rule, _) = target {
                    called.push(*rule);
                }
            });
            open.extend(called.into_iter().rev());
        }
        needed
    }

    /// Shows all that stands in a rule's productions, what is written out too.
    fn walk(&self, rule: Rule, see: &mut dyn FnMut(&Target)) {
        let mut open = vec![(self.model(rule), Some(rule))];
        if let Some((_, class)) = self.end(rule) {
            let end = self.at_end(rule, class);
            see(&end);
            if let Target::Inline(class) = end {
                open.push((class, None));
            }
        }
        while let Some((class, of)) = open.pop() {
            let entries = &self.classes.all[class as usize].entries;
            for (place, entry) in entries.iter().enumerate() {
                let target = self.branch(of, place, entry);
                see(&target);
                if let Target::Inline(class) = target {
                    open.push((class, None));
                }
            }
        }
    }

    /// Modules and parameters that a class takes where it is written out, its named parts called.
    pub(super) fn costs(&self) -> Vec<u64> {
        let mut costs = Vec::with_capacity(self.classes.all.len());
        for class in &self.classes.all {
            let branches = class.entries.iter().map(|entry| {
                let numbers = &self.classes.numbers;
                let turns = [
                    numbers.rolls[entry.turn_roll as usize] != 0.0,
                    numbers.pitches[entry.pitch as usize] != 0.0,
                    entry.roll != Roll::Any,
                ];
                let turns: u64 = turns.into_iter().map(|turn| 2 * u64::from(turn)).sum();
                let own = match self.rule(entry.class) {
                    Some((_, level)) => self.call_cost() + u64::from(level.is_some()),
                    // Classes stand behind what they are made of.
                    None => costs.get(entry.class as usize).copied().unwrap_or(0),
                };
                turns + own
            });
            let sum = branches.fold(0_u64, u64::saturating_add);
            let brackets = 2 * (class.entries.len() as u64).saturating_sub(1);
            costs.push(sum.saturating_add(brackets + self.segment_cost()));
        }
        costs
    }

    /// Of `!(w) F(l)`.
    fn segment_cost(&self) -> u64 {
        if self.one_radius { 2 } else { 4 }
    }

    /// Of `A(l, w)`.
    pub(super) fn call_cost(&self) -> u64 {
        if self.one_radius { 2 } else { 3 }
    }

    /// Whether all parts are levels of families that are one lower at each branch, and of one level: then steps count the levels.
    fn counted_by_steps(&self, parts: &[u32], needed: &Needed) -> Option<u32> {
        let level = |class: &u32| match self.forms.of[*class as usize] {
            Form::Level { level, .. } => Some(level),
            _ => None,
        };
        let first = parts.first().and_then(level)?;
        let same = parts.iter().all(|class| level(class) == Some(first));
        let one_lower = needed.rules.iter().all(|rule| match rule {
            Rule::Family(family) => {
                let slots = &self.forms.families[*family as usize].slots;
                let is_plain = self.end(*rule).is_none();
                is_plain
                    && slots
                        .iter()
                        .all(|slot| slot.below == 1 && slot.level().is_some())
            }
            _ => false,
        });
        (same && one_lower).then_some(first)
    }

    /// Steps after which all is written out, at most.
    fn steps(&self, parts: &[u32]) -> u32 {
        let mut steps: Vec<u32> = Vec::with_capacity(self.classes.all.len());
        for (class, form) in self.classes.all.iter().zip(&self.forms.of) {
            let below = class
                .entries
                .iter()
                .map(|entry| steps.get(entry.class as usize));
            let most = below.flatten().max().copied().unwrap_or(0);
            // What ends a rule takes a step more.
            let ends = match *form {
                Form::Run { count, .. } => count == 1,
                Form::Level { family, level } => {
                    let family = &self.forms.families[family as usize];
                    level == family.lowest && family.base().is_some()
                }
                Form::Leaf | Form::Plain => false,
            };
            steps.push(most.saturating_add(1 + u32::from(ends)));
        }
        let of = |class: &u32| steps[*class as usize];
        parts.iter().map(of).max().unwrap_or(0)
    }

    /// The chains among the rules that a plan calls.
    pub(super) fn chained(&self, plan: &Plan) -> Chains {
        let parts: Vec<u32> = plan.words.iter().filter_map(part_of).collect();
        Chains::new(self, &self.needed(&parts).rules)
    }

    /// The grammar; `shorten`: with productions for what is repeated in the axiom.
    pub(super) fn write(&self, plan: &Plan, chains: &Chains, shorten: bool) -> (String, Size) {
        let parts: Vec<u32> = plan.words.iter().filter_map(part_of).collect();
        let chained = Writer { chains, ..*self };
        let needed = chained.needed(&parts);
        chained.written(plan, shorten, &parts, needed)
    }

    fn written(&self, plan: &Plan, shorten: bool, parts: &[u32], needed: Needed) -> (String, Size) {
        let axiom = Axiom::new(plan, shorten, true);
        let by_steps = self
            .counted_by_steps(parts, &needed)
            .filter(|_| axiom.rules.is_empty());
        let numbers = needed.rules.iter().copied().zip(0..);
        let mut text = Text {
            out: Out::default(),
            writer: *self,
            names: numbers.collect(),
            with_levels: by_steps.is_none(),
        };
        let steps = by_steps.unwrap_or_else(|| self.steps(parts));
        let mut part = |out: &mut Out, class, length: f64, width: f64| {
            if let Some((rule, level)) = self.rule(class) {
                let level = level.map(|level| level.to_string());
                let (name, parameters) = call(
                    &text.names,
                    rule,
                    level.filter(|_| text.with_levels),
                    length.to_string(),
                    (!self.one_radius).then(|| width.to_string()),
                );
                out.module(&name, &parameters);
            }
        };
        axiom.write(&mut text.out, steps, needed.rules.len(), &mut part);
        for rule in needed.rules {
            text.rule(rule);
        }
        text.out.finish()
    }
}

/// The class of a part.
pub(super) fn part_of(word: &Word) -> Option<u32> {
    match word {
        Word::Part { class, .. } => Some(*class),
        _ => None,
    }
}

/// A plan without parts as a grammar; `short`: with modules for segments, `shorten`: and productions for what is repeated.
pub(super) fn plain(plan: &Plan, short: bool, shorten: bool) -> (String, Size) {
    let mut out = Out::default();
    let axiom = Axiom::new(plan, shorten, short);
    axiom.write(&mut out, 0, 0, &mut |_, _, _, _| {});
    out.finish()
}

/// The module of a rule.
fn call(
    names: &HashMap<Rule, usize>,
    rule: Rule,
    level: Option<String>,
    length: String,
    width: Option<String>,
) -> (String, Vec<String>) {
    let number = names.get(&rule).copied().unwrap_or(0);
    let parameters = level.into_iter().chain([length]).chain(width);
    (name(number), parameters.collect())
}

/// A grammar on its way.
struct Text<'a> {
    out: Out,
    writer: Writer<'a>,
    names: HashMap<Rule, usize>,
    with_levels: bool,
}

impl Text<'_> {
    fn rule(&mut self, rule: Rule) {
        let name = name(self.names.get(&rule).copied().unwrap_or(0));
        let leveled = self.with_levels && !matches!(rule, Rule::Plain(_));
        let mut parameters = vec!["l"];
        if leveled {
            parameters.insert(0, "n");
        }
        if !self.writer.one_radius {
            parameters.push("w");
        }
        let end = self.writer.end(rule);
        let condition = format!("n > {}", end.map_or(0, |(level, _)| level));
        self.out
            .head(&name, &parameters, leveled.then_some(condition.as_str()));
        if let Rule::Chain(chain) = rule {
            let members = &self.writer.chains.all[chain as usize];
            self.writer.next = members.iter().rev().nth(1).copied();
        }
        self.body(self.writer.model(rule), Some(rule));
        self.writer.next = None;
        if let Some((level, class)) = end {
            self.out
                .head(&name, &parameters, Some(&format!("n == {level}")));
            match self.writer.at_end(rule, class) {
                Target::Call(rule, level) => self.call(rule, level, [1.0, 1.0]),
                Target::Inline(class) => self.body(class, None),
            }
        }
    }

    fn call(&mut self, rule: Rule, level: Option<String>, [length, radius]: [f64; 2]) {
        let width = (!self.writer.one_radius).then(|| times("w", radius));
        let level = level.filter(|_| self.with_levels);
        let (name, parameters) = call(&self.names, rule, level, times("l", length), width);
        self.out.module(&name, &parameters);
    }

    fn segment(&mut self, [length, radius]: [f64; 2]) {
        if !self.writer.one_radius {
            self.out.module("!", &[times("w", radius)]);
        }
        self.out.module("F", &[times("l", length)]);
    }

    /// A class written out.
    fn body(&mut self, class: u32, of: Option<Rule>) {
        self.segment([1.0, 1.0]);
        let level = |class, [length, radius]: [f64; 2], of| Level {
            class,
            length,
            radius,
            next: 0,
            of,
        };
        let mut open = vec![level(class, [1.0, 1.0], of)];
        while let Some(top) = open.last_mut() {
            let entries = &self.writer.classes.all[top.class as usize].entries;
            let (place, count) = (top.next, entries.len());
            if place > 0 && place < count {
                self.out.module("]", &[]);
            }
            let Some(entry) = entries.get(place) else {
                open.pop();
                continue;
            };
            top.next += 1;
            if place + 1 < count {
                self.out.module("[", &[]);
            }
            let of = top.of;
            let numbers = &self.writer.classes.numbers;
            let factors = [
                top.length * numbers.lengths[entry.length as usize],
                top.radius * numbers.radii[entry.radius as usize],
            ];
            let roll = match of {
                Some(Rule::Family(family)) => {
                    self.writer.forms.families[family as usize].slots[place].roll
                }
                _ => entry.roll,
            };
            self.turns(entry, roll);
            match self.writer.branch(of, place, entry) {
                Target::Call(rule, n) => self.call(rule, n, factors),
                Target::Inline(class) => {
                    self.segment(factors);
                    if class != LEAF {
                        open.push(level(class, factors, None));
                    }
                }
            }
        }
    }

    fn turns(&mut self, entry: &Entry, own: Roll) {
        let numbers = &self.writer.classes.numbers;
        let mut roll = numbers.rolls[entry.turn_roll as usize];
        let pitch = numbers.pitches[entry.pitch as usize];
        let mut behind = match own {
            Roll::By(by) => numbers.rolls[by as usize],
            Roll::Any | Roll::Level => 0.0,
        };
        if pitch == 0.0 {
            (roll, behind) = (roll + behind, 0.0);
        }
        for (sign, degrees) in [("/", roll), ("&", pitch)] {
            if degrees != 0.0 {
                self.out.module(sign, &[degrees.to_string()]);
            }
        }
        if own == Roll::Level {
            self.out.module("$", &[]);
        }
        if behind != 0.0 {
            self.out.module("/", &[behind.to_string()]);
        }
    }
}
