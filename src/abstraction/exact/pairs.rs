//! What is repeated within the axiom, in the midst of branches too: words that stand beside each other more than once become a production.
//!
//! Larsson and Moffat's Re-Pair (2000), as Lohrey, Maneth and Mennicke carry it over to trees (2013): equal branches are one first, then the pair of
//! neighbours that saves most is replaced, again and again. A branch is one word here, so what is replaced never cuts a bracket, and stands for what it
//! says wherever the turtle is. Edges that are rewritten, as `F -> F[+F]F[-F]F` does, leave such repeats, which are no equal subtrees.

use hashbrown::{HashMap, HashSet};

use super::plan::{Plan, Word};

/// Rounds at most, and looks at words in all of them.
const ROUNDS: usize = 400;
const LOOKS: usize = 4_000_000;
/// Pairs that are replaced in one round at most, where they have nothing in common, and save no less than a part of the most.
const AT_ONCE: usize = 32;
const OF_MOST: i64 = 4;

/// A part of the axiom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Symbol {
    /// One of [`Pairs::words`].
    Word(u32),
    /// One of [`Pairs::lines`] in brackets.
    Branch(u32),
    /// One of [`Pairs::lines`] that a production makes.
    Line(u32),
}

/// An axiom in parts.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    pub(super) words: Vec<Word>,
    /// Words beside each other.
    pub(super) lines: Vec<Vec<Symbol>>,
    /// The line that is the axiom.
    pub(super) axiom: u32,
    /// Whether a line has a production of its own.
    pub(super) named: Vec<bool>,
}

fn number(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// A word as something that can be compared.
fn bits(word: &Word) -> [u64; 7] {
    let of = |kind: u64, numbers: [f64; 3]| {
        let [a, b, c] = numbers.map(f64::to_bits);
        [kind, a, b, c, 0, 0, 0]
    };
    match *word {
        Word::Push => of(0, [0.0; 3]),
        Word::Pop => of(1, [0.0; 3]),
        Word::Width(width) => of(2, [width, 0.0, 0.0]),
        Word::Move { yaw, pitch, length } => of(3, [yaw, pitch, length]),
        Word::Segment { yaw, pitch, length } => of(4, [yaw, pitch, length]),
        Word::Part {
            turn: [yaw, pitch],
            level,
            roll,
            class,
            length,
            width,
        } => {
            let [yaw, pitch, roll, length, width] =
                [yaw, pitch, roll, length, width].map(f64::to_bits);
            let kind = 5 + u64::from(level);
            [kind, yaw, pitch, roll, u64::from(class), length, width]
        }
    }
}

impl Pairs {
    /// The axiom of a plan, of which only equal branches are one.
    pub(super) fn of(plan: &Plan) -> Self {
        let mut pairs = Self::default();
        let mut known_words: HashMap<[u64; 7], u32> = HashMap::new();
        let mut known_lines: HashMap<Vec<Symbol>, u32> = HashMap::new();
        let mut open = vec![Vec::new()];
        for word in &plan.words {
            let symbol = match word {
                Word::Push => {
                    open.push(Vec::new());
                    continue;
                }
                Word::Pop => {
                    let line = open.pop().unwrap_or_default();
                    let next = number(pairs.lines.len());
                    let place = *known_lines.entry(line.clone()).or_insert(next);
                    if place == next {
                        pairs.lines.push(line);
                    }
                    Symbol::Branch(place)
                }
                word => {
                    let next = number(pairs.words.len());
                    let place = *known_words.entry(bits(word)).or_insert(next);
                    if place == next {
                        pairs.words.push(*word);
                    }
                    Symbol::Word(place)
                }
            };
            if let Some(line) = open.last_mut() {
                line.push(symbol);
            }
        }
        pairs.axiom = number(pairs.lines.len());
        pairs.lines.push(open.pop().unwrap_or_default());
        pairs.named = vec![false; pairs.lines.len()];
        pairs
    }

    /// Replaces what pays: `cost` says how many modules and parameters a word takes.
    pub(super) fn shorten(&mut self, cost: &dyn Fn(&Word) -> i64) {
        let costs: Vec<i64> = self.words.iter().map(cost).collect();
        let mut looks = LOOKS;
        for _ in 0..ROUNDS {
            let length: usize = self.lines.iter().map(Vec::len).sum();
            if looks < length {
                break;
            }
            looks -= length;
            let chosen = self.chosen(&costs);
            if chosen.is_empty() {
                break;
            }
            self.replace(&chosen);
        }
        self.name(&costs);
    }

    /// What a symbol takes where it stands: branches that are there once are never half of a pair that is there twice.
    fn cost(symbol: Symbol, costs: &[i64]) -> i64 {
        match symbol {
            Symbol::Word(word) => costs.get(word as usize).copied().unwrap_or(0),
            Symbol::Branch(_) => 3,
            Symbol::Line(_) => 1,
        }
    }

    /// The pairs that save most and have nothing in common.
    fn chosen(&self, costs: &[i64]) -> Vec<[Symbol; 2]> {
        let mut counts: HashMap<[Symbol; 2], i64> = HashMap::new();
        for line in &self.lines {
            let mut at = 0;
            while let (Some(first), Some(second)) = (line.get(at), line.get(at + 1)) {
                *counts.entry([*first, *second]).or_insert(0) += 1;
                // Of three alike the middle one is in one pair only.
                let alike = first == second && line.get(at + 2) == Some(first);
                at += if alike { 2 } else { 1 };
            }
        }
        let saved = |pair: &[Symbol; 2], count: i64| {
            let [first, second] = pair.map(|symbol| Self::cost(symbol, costs));
            (count - 1) * (first + second) - count - 1
        };
        let mut all: Vec<(i64, [Symbol; 2])> = counts
            .into_iter()
            .map(|(pair, count)| (saved(&pair, count), pair))
            .filter(|(saved, _)| *saved > 0)
            .collect();
        all.sort_unstable_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        let most = all.first().map_or(0, |(saved, _)| *saved);
        let mut taken = HashSet::new();
        let mut chosen = Vec::new();
        for (saved, pair) in all {
            if chosen.len() >= AT_ONCE || saved * OF_MOST < most {
                break;
            }
            if pair.iter().all(|symbol| !taken.contains(symbol)) {
                taken.extend(pair);
                chosen.push(pair);
            }
        }
        chosen
    }

    fn replace(&mut self, chosen: &[[Symbol; 2]]) {
        let first = number(self.lines.len());
        let places: HashMap<[Symbol; 2], u32> = chosen.iter().copied().zip(first..).collect();
        for line in &mut self.lines {
            let mut short = Vec::with_capacity(line.len());
            let mut at = 0;
            while let Some(symbol) = line.get(at) {
                let place = line
                    .get(at + 1)
                    .and_then(|next| places.get(&[*symbol, *next]));
                short.push(place.map_or(*symbol, |place| Symbol::Line(*place)));
                at += if place.is_some() { 2 } else { 1 };
            }
            *line = short;
        }
        self.lines.extend(chosen.iter().map(|pair| pair.to_vec()));
        self.named.resize(self.lines.len(), true);
    }

    /// Gives productions to what is called more than once, if that pays.
    fn name(&mut self, costs: &[i64]) {
        let mut calls = vec![0_i64; self.lines.len()];
        for symbol in self.lines.iter().flatten() {
            if let Symbol::Branch(line) | Symbol::Line(line) = symbol {
                calls[*line as usize] += 1;
            }
        }
        for (line, calls) in calls.into_iter().enumerate() {
            let body: i64 = self.lines[line]
                .iter()
                .map(|symbol| Self::cost(*symbol, costs))
                .sum();
            // Called as a module, against written out at each place.
            self.named[line] = calls > 1 && (calls - 1) * body > calls + 1;
        }
    }

    /// Words as often as they are written.
    pub(super) fn written(&self) -> impl Iterator<Item = &Word> {
        // A line without a production is there once, or as good as nothing is saved by one.
        let symbols = self.lines.iter().flatten();
        symbols.filter_map(|symbol| match symbol {
            Symbol::Word(word) => self.words.get(*word as usize),
            _ => None,
        })
    }

    /// Lines with productions, in the order in which they are met.
    pub(super) fn rules(&self) -> Vec<u32> {
        let mut rules = Vec::new();
        let mut met = vec![false; self.lines.len()];
        let mut open = vec![self.axiom];
        while let Some(line) = open.pop() {
            if std::mem::replace(&mut met[line as usize], true) {
                continue;
            }
            if self.named[line as usize] && line != self.axiom {
                rules.push(line);
            }
            let within = self.lines[line as usize].iter().rev();
            open.extend(within.filter_map(|symbol| match symbol {
                Symbol::Word(_) => None,
                Symbol::Branch(line) | Symbol::Line(line) => Some(*line),
            }));
        }
        rules
    }

    /// Steps until all lines are written out.
    pub(super) fn steps(&self) -> u32 {
        // Branches stand behind what they hold, and lines of pairs behind the pairs in them: not so those that pairs were replaced in.
        let mut steps: Vec<Option<u32>> = vec![None; self.lines.len()];
        let mut open = vec![(self.axiom, false)];
        while let Some((line, is_known)) = open.pop() {
            let within = || {
                self.lines[line as usize]
                    .iter()
                    .filter_map(|symbol| match symbol {
                        Symbol::Word(_) => None,
                        Symbol::Branch(line) | Symbol::Line(line) => Some(*line),
                    })
            };
            if is_known {
                let most = within().filter_map(|line| steps[line as usize]).max();
                let own = u32::from(self.named[line as usize] && line != self.axiom);
                steps[line as usize] = Some(most.unwrap_or(0) + own);
            } else if steps[line as usize].is_none() {
                open.push((line, true));
                open.extend(within().map(|line| (line, false)));
            }
        }
        steps[self.axiom as usize].unwrap_or(0)
    }
}
