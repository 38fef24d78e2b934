//! The axiom of a plan, with modules for segments and for what is repeated in it.

use super::out::{Out, name};
use super::pairs::{Pairs, Symbol};
use super::plan::{Plan, Word};

/// Segments that turn both ways, and that turn one way, from which on a module for them is shorter than they are.
const BOTH_FROM: usize = 6;
const ONE_FROM: usize = 8;

/// Which kinds of segments have a module `S` of their own, told apart by how many parameters it has.
#[derive(Clone, Copy, Debug, Default)]
struct Short {
    /// `S(a, b, l) -> +(a) &(b) F(l)`
    both: bool,
    /// `S(a, l) -> +(a) F(l)`
    one: bool,
}

impl Short {
    /// What pays of so many segments that turn both ways and one way.
    fn of<'a>(words: impl Iterator<Item = &'a Word>) -> Self {
        let [mut both, mut one] = [0, 0];
        for word in words {
            if let Word::Segment { yaw, pitch, .. } = word {
                both += usize::from(*yaw != 0.0 && *pitch != 0.0);
                one += usize::from(*yaw != 0.0 && *pitch == 0.0);
            }
        }
        Self {
            both: both >= BOTH_FROM,
            one: one >= ONE_FROM,
        }
    }

    fn is_any(self) -> bool {
        self.both || self.one
    }

    /// Modules and parameters of a word.
    fn cost(self, word: &Word) -> i64 {
        let turns = |yaw: f64, pitch: f64| 2 * (i64::from(yaw != 0.0) + i64::from(pitch != 0.0));
        match *word {
            Word::Push | Word::Pop => 1,
            Word::Width(_) => 2,
            Word::Segment { yaw, pitch, .. } if yaw != 0.0 && pitch != 0.0 && self.both => 4,
            Word::Segment { yaw, pitch, .. } if yaw != 0.0 && pitch == 0.0 && self.one => 3,
            Word::Segment { yaw, pitch, .. } | Word::Move { yaw, pitch, .. } => {
                turns(yaw, pitch) + 2
            }
            Word::Part {
                turn: [yaw, pitch],
                level,
                roll,
                ..
            } => turns(yaw, pitch) + turns(roll, 0.0) + i64::from(level) + 4,
        }
    }
}

/// An axiom on its way.
pub(super) struct Axiom {
    pairs: Pairs,
    short: Short,
    /// Lines with productions.
    pub(super) rules: Vec<u32>,
}

impl Axiom {
    pub(super) fn new(plan: &Plan, shorten: bool, short: bool) -> Self {
        let mut pairs = Pairs::of(plan);
        let mut kinds = Short::default();
        if short {
            kinds = Short::of(plan.words.iter());
        }
        if shorten {
            pairs.shorten(&|word| kinds.cost(word));
            // Words that are repeated are written fewer times.
            let kept = Short::of(pairs.written());
            kinds = Short {
                both: kinds.both && kept.both,
                one: kinds.one && kept.one,
            };
        }
        let rules = pairs.rules();
        Self {
            pairs,
            short: kinds,
            rules,
        }
    }

    /// Writes steps, axiom and its productions; `steps` are those of its parts, which `part` writes, and `names` are taken.
    pub(super) fn write(
        &self,
        out: &mut Out,
        steps: u32,
        names: usize,
        part: &mut dyn FnMut(&mut Out, u32, f64, f64),
    ) {
        let own = self.pairs.steps();
        let steps = own + steps.max(u32::from(self.short.is_any()));
        out.raw(&format!("steps {steps}\naxiom"));
        if self.pairs.lines[self.pairs.axiom as usize].is_empty() {
            out.raw(" *");
        }
        let numbers = self.rules.iter().copied().zip(names..);
        let numbers: hashbrown::HashMap<u32, usize> = numbers.collect();
        self.line(out, self.pairs.axiom, &numbers, part);
        for rule in &self.rules {
            out.head(&name(numbers.get(rule).copied().unwrap_or(0)), &[], None);
            self.line(out, *rule, &numbers, part);
        }
        let turns = [
            (self.short.one, ["a", "l"].as_slice(), ["+"].as_slice()),
            (self.short.both, &["a", "b", "l"], &["+", "&"]),
        ];
        for (_, parameters, turns) in turns.into_iter().filter(|(there, _, _)| *there) {
            out.head("S", parameters, None);
            for (sign, angle) in turns.iter().zip(parameters) {
                out.module(sign, &[(*angle).to_owned()]);
            }
            out.module("F", &["l".to_owned()]);
        }
    }

    /// Writes a line; what has a production is called.
    fn line(
        &self,
        out: &mut Out,
        line: u32,
        numbers: &hashbrown::HashMap<u32, usize>,
        part: &mut dyn FnMut(&mut Out, u32, f64, f64),
    ) {
        // Lines within lines: which, how far, and whether a bracket closes behind it.
        let mut open = vec![(line, 0, false)];
        while let Some((line, at, closes)) = open.last_mut() {
            let Some(symbol) = self.pairs.lines[*line as usize].get(*at) else {
                if *closes {
                    out.module("]", &[]);
                }
                open.pop();
                continue;
            };
            *at += 1;
            let (within, is_branch) = match *symbol {
                Symbol::Word(word) => {
                    self.word(out, self.pairs.words[word as usize], part);
                    continue;
                }
                Symbol::Branch(line) => (line, true),
                Symbol::Line(line) => (line, false),
            };
            if is_branch {
                out.module("[", &[]);
            }
            match numbers.get(&within) {
                Some(number) => {
                    out.module(&name(*number), &[]);
                    if is_branch {
                        out.module("]", &[]);
                    }
                }
                None => open.push((within, 0, is_branch)),
            }
        }
    }

    fn word(&self, out: &mut Out, word: Word, part: &mut dyn FnMut(&mut Out, u32, f64, f64)) {
        let turn = |out: &mut Out, sign: &str, degrees: f64| {
            if degrees != 0.0 {
                out.module(sign, &[degrees.to_string()]);
            }
        };
        match word {
            Word::Push | Word::Pop => {}
            Word::Width(width) => out.module("!", &[width.to_string()]),
            Word::Segment { yaw, pitch, length }
                if yaw != 0.0 && pitch != 0.0 && self.short.both =>
            {
                out.module("S", &[yaw, pitch, length].map(|one| one.to_string()));
            }
            Word::Segment { yaw, pitch, length }
                if yaw != 0.0 && pitch == 0.0 && self.short.one =>
            {
                out.module("S", &[yaw, length].map(|one| one.to_string()));
            }
            Word::Segment { yaw, pitch, length } | Word::Move { yaw, pitch, length } => {
                turn(out, "+", yaw);
                turn(out, "&", pitch);
                let draws = matches!(word, Word::Segment { .. });
                out.module(if draws { "F" } else { "f" }, &[length.to_string()]);
            }
            Word::Part {
                turn: [yaw, pitch],
                level,
                roll,
                class,
                length,
                width,
            } => {
                turn(out, "+", yaw);
                turn(out, "&", pitch);
                match level {
                    true => out.module("$", &[]),
                    false => turn(out, "/", roll),
                }
                part(out, class, length, width);
            }
        }
    }
}
