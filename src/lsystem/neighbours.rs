//! The modules that contexts see beside each other, found for one chunk of the string at a time.
//!
//! What a context sees next to a module may stand far away: behind whole branches and ignored modules. Inside a chunk it is found in
//! one pass over the chunk, given what is seen from its ends: beside these themselves, and outside each branch that reaches beyond them. These seams
//! are found first. Each chunk says by itself what it shows to others, and one walk over
//! the chunks puts that together. So any thread finds a chunk's neighbours when it works on the chunk and forgets
//! them afterwards; to hold those of the whole string took four times the memory of a string without parameters.
//!
//! A context of several modules goes on from a neighbour to that one's neighbour. Where this leaves the chunk, it does so by a module that
//! stands beside a seam: the neighbours of these are noted on the way ([`Seams::beyond`]).
//!
//! To the left a branch goes on with what it stands on; to the right the end of a branch has nothing beside it.
//!
//! Tried: a pass for each side, and passes without branches of the program's own, which keep what is seen in a list by depth. Half of a
//! plant's brackets are guessed wrong by the processor, so one pass is better than two; but the list's values are read right
//! after they were written, and waiting for them takes longer still.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::column::Narrow;
use super::grammar::{Grammar, Pattern, Role, Rule};
use super::rewrite::TOGETHER;

/// No module on that side.
pub(super) const NOTHING: u32 = u32::MAX;

/// The side of a module on which a context stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

impl Side {
    /// The context that a production has on this side.
    pub(super) fn of(self, rule: &Rule) -> &[Pattern] {
        match self {
            Self::Left => &rule.left,
            Self::Right => &rule.right,
        }
    }

    /// The place next to another; past all places before the first.
    #[inline]
    pub(super) fn next(self, place: usize) -> usize {
        match self {
            Self::Left => place.wrapping_sub(1),
            Self::Right => place.wrapping_add(1),
        }
    }
}

/// A value for each side.
#[derive(Clone, Debug, Default)]
pub(super) struct Sides<T> {
    pub(super) left: T,
    pub(super) right: T,
}

impl<T> Sides<T> {
    pub(super) fn get(&self, side: Side) -> &T {
        match side {
            Side::Left => &self.left,
            Side::Right => &self.right,
        }
    }
}

/// What a chunk knows by itself of what is seen from one of its places.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    /// The module at this place of the string.
    At(u32),
    /// No module.
    Nothing,
    /// What is seen from the chunk's end on that side, so many branches further out.
    Outside(u32),
}

/// What a chunk shows to those behind it on one side.
#[derive(Debug)]
struct Chunk {
    /// Branches that it leaves.
    left: usize,
    /// What is seen outside each branch that it leaves open,
    open: Vec<Seen>,
    /// and from its end.
    last: Seen,
    /// What is seen from modules that these name, by their places.
    links: Vec<(u32, Seen)>,
}

/// What is seen on one side where chunks begin.
#[derive(Clone, Debug, Default)]
struct Seam {
    /// What is seen from each chunk's beginning, and then outside each branch that it leaves,
    outside: Vec<u32>,
    /// and where in it each chunk's are.
    places: Vec<Range<usize>>,
    /// What is seen from modules that are seen from chunks behind them.
    beyond: HashMap<u32, u32>,
}

impl Seam {
    /// Puts together what the chunks show, the first that is passed first; `number` says which chunk that is.
    fn joined(chunks: &[Chunk], number: impl Fn(usize) -> usize) -> Self {
        let mut seam = Self {
            outside: Vec::new(),
            places: vec![0..0; chunks.len()],
            beyond: HashMap::new(),
        };
        // What is seen outside each open branch, and last what is seen here.
        let mut seen = vec![NOTHING];
        for (passed, chunk) in chunks.iter().enumerate() {
            // Strings are balanced: the parser has checked the axiom and every successor.
            let outside = seen.split_off(seen.len().saturating_sub(chunk.left + 1));
            let start = seam.outside.len();
            seam.outside.extend(outside.iter().rev());
            if let Some(places) = seam.places.get_mut(number(passed)) {
                *places = start..seam.outside.len();
            }
            let place = |what: &Seen| match *what {
                Seen::At(place) => place,
                Seen::Nothing => NOTHING,
                Seen::Outside(branches) => {
                    let from_end = outside.len().checked_sub(branches as usize + 1);
                    let place = from_end.and_then(|at| outside.get(at));
                    place.copied().unwrap_or(NOTHING)
                }
            };
            seen.extend(chunk.open.iter().map(place));
            seen.push(place(&chunk.last));
            let links = chunk.links.iter().map(|(from, to)| (*from, place(to)));
            seam.beyond.extend(links);
        }
        seam
    }

    /// What is seen where a chunk begins, and outside each branch that it leaves; nothing at the string's own ends.
    fn outside(&self, number: usize) -> &[u32] {
        let places = self.places.get(number).cloned();
        let outside = places.and_then(|places| self.outside.get(places));
        outside.filter(|all| !all.is_empty()).unwrap_or(&[NOTHING])
    }

    fn bytes(&self) -> usize {
        self.outside.len() * size_of::<u32>()
            + self.places.len() * size_of::<Range<usize>>()
            + self.beyond.capacity() * size_of::<(u32, u32)>()
    }
}

/// What is seen where chunks begin and end.
#[derive(Debug)]
pub(super) struct Seams {
    /// Modules of a chunk.
    chunk: usize,
    sides: Sides<Seam>,
}

impl Seams {
    /// Of a string in chunks of so many modules, worked on by several threads where `parallel`, for contexts of up to `reach` modules.
    /// `None`: cancelled.
    pub(super) fn new<S: Narrow>(
        grammar: &Grammar,
        symbols: &[S],
        reach: usize,
        (chunk, parallel): (usize, bool),
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let chunk = chunk.max(1);
        let mut seams = Self {
            chunk,
            sides: Sides::default(),
        };
        if symbols.len() <= chunk {
            return Some(seams);
        }
        let shown = |(number, symbols): (usize, &[S])| {
            let goes_on = !cancel.load(Ordering::Relaxed);
            goes_on.then(|| shown(grammar, symbols, number * chunk, reach))
        };
        let chunks: Option<Vec<(Chunk, Chunk)>> = if parallel {
            let chunks = symbols.par_chunks(chunk).enumerate();
            chunks.with_max_len(TOGETHER).map(shown).collect()
        } else {
            symbols.chunks(chunk).enumerate().map(shown).collect()
        };
        let (left, mut right): (Vec<_>, Vec<_>) = chunks?.into_iter().unzip();
        right.reverse();
        let last = right.len().saturating_sub(1);
        seams.sides = Sides {
            left: Seam::joined(&left, |passed| passed),
            right: Seam::joined(&right, |passed| last - passed),
        };
        Some(seams)
    }

    /// Bytes that it takes.
    pub(super) fn bytes(&self) -> u64 {
        (self.sides.left.bytes() + self.sides.right.bytes()) as u64
    }

    /// What is seen beside each module of a chunk. `value` says what is told of a module: its place, its symbol; `nothing` is told where
    /// there is none.
    pub(super) fn beside<S: Narrow, T: Copy>(
        &self,
        grammar: &Grammar,
        symbols: &[S],
        number: usize,
        value: impl Fn(usize, S) -> T,
        nothing: T,
    ) -> Sides<Vec<T>> {
        let from = (number * self.chunk).min(symbols.len());
        let end = (from + self.chunk).min(symbols.len());
        let outside = |seam: &Seam| -> Vec<T> {
            let told = |place: &u32| {
                let symbol = symbols.get(*place as usize);
                symbol.map_or(nothing, |symbol| value(*place as usize, *symbol))
            };
            seam.outside(number).iter().map(told).collect()
        };
        let outside = Sides {
            left: outside(&self.sides.left),
            right: outside(&self.sides.right),
        };
        let own = symbols.get(from..end).unwrap_or(&[]);
        let value = |at: usize, symbol: S| value(from + at, symbol);
        beside(grammar, own, &outside, value, nothing)
    }

    /// The places that are seen beside those of a chunk.
    pub(super) fn places<S: Narrow>(
        &self,
        grammar: &Grammar,
        symbols: &[S],
        number: usize,
    ) -> Sides<Vec<u32>> {
        let place = |at: usize, _: S| u32::try_from(at).unwrap_or(NOTHING);
        self.beside(grammar, symbols, number, place, NOTHING)
    }

    /// What is seen from a module outside of the chunk that is worked on, where a context has come to it.
    pub(super) fn beyond(&self, side: Side, place: usize) -> u32 {
        let place = u32::try_from(place).ok();
        let seen = place.and_then(|place| self.sides.get(side).beyond.get(&place));
        seen.copied().unwrap_or(NOTHING)
    }
}

/// What a chunk, whose first module has the place `from`, shows to those behind it (for their left contexts) and before it.
fn shown<S: Narrow>(grammar: &Grammar, symbols: &[S], from: usize, reach: usize) -> (Chunk, Chunk) {
    let ends = Ends::of(grammar, symbols, from);
    let (mut left, mut right) = (ends.to_the_left(), ends.to_the_right());
    if reach > 1 {
        let outside = |chunk: &Chunk| (0..).take(chunk.left + 1).map(Seen::Outside).collect();
        let outside: Sides<Vec<Seen>> = Sides {
            left: outside(&left),
            right: outside(&right),
        };
        let value = |at, _| Seen::At(u32::try_from(from + at).unwrap_or(NOTHING));
        let seen = beside(grammar, symbols, &outside, value, Seen::Nothing);
        left.follow(&seen.left, from, reach);
        right.follow(&seen.right, from, reach);
    }
    (left, right)
}

/// What is seen of a chunk from outside.
#[derive(Debug)]
struct Ends {
    /// The module that is seen first behind the chunk's beginning, and behind each bracket that closes a branch which began before.
    first: Vec<u32>,
    /// The module that is seen last behind the last of these brackets, and behind each bracket that opens a branch which is left open.
    last: Vec<u32>,
}

impl Ends {
    fn of<S: Narrow>(grammar: &Grammar, symbols: &[S], from: usize) -> Self {
        let (mut first, mut last) = (Vec::new(), Vec::new());
        let (mut ahead, mut behind) = (NOTHING, NOTHING);
        let places = u32::try_from(from).unwrap_or(NOTHING)..;
        for (place, symbol) in places.zip(symbols) {
            match grammar.role((*symbol).into()) {
                Role::Module | Role::Cut => {
                    if ahead == NOTHING && last.is_empty() {
                        ahead = place;
                    }
                    behind = place;
                }
                Role::Open => last.push(std::mem::replace(&mut behind, NOTHING)),
                Role::Close => {
                    behind = last.pop().unwrap_or_else(|| {
                        first.push(std::mem::replace(&mut ahead, NOTHING));
                        NOTHING
                    });
                }
                Role::Ignored => {}
            }
        }
        first.push(ahead);
        last.push(behind);
        Self { first, last }
    }

    /// For contexts to the left of what is behind the chunk: a branch goes on with what it stands on.
    fn to_the_left(&self) -> Chunk {
        let left = self.first.len() - 1;
        let mut seen = outside(left);
        let mut open: Vec<Seen> = Vec::with_capacity(self.last.len());
        for place in &self.last {
            seen = at(*place).unwrap_or(seen);
            open.push(seen);
        }
        Chunk::new(left, open)
    }

    /// For contexts to the right of what is before the chunk: a branch ends.
    fn to_the_right(&self) -> Chunk {
        let left = self.last.len() - 1;
        let mut otherwise = outside(left);
        let mut open: Vec<Seen> = Vec::with_capacity(self.first.len());
        for place in self.first.iter().rev() {
            open.push(at(*place).unwrap_or(otherwise));
            otherwise = Seen::Nothing;
        }
        Chunk::new(left, open)
    }
}

fn at(place: u32) -> Option<Seen> {
    (place != NOTHING).then_some(Seen::At(place))
}

fn outside(branches: usize) -> Seen {
    Seen::Outside(u32::try_from(branches).unwrap_or(NOTHING))
}

impl Chunk {
    /// `open` ends with what is seen from the end.
    fn new(left: usize, mut open: Vec<Seen>) -> Self {
        let last = open.pop().unwrap_or(Seen::Nothing);
        Self {
            left,
            open,
            last,
            links: Vec::new(),
        }
    }

    /// Notes what is seen from the modules that it names, from those that are seen there, and so on, for contexts of so many modules;
    /// `seen` says it of each module of the chunk, whose first has the place `from`.
    fn follow(&mut self, seen: &[Seen], from: usize, reach: usize) {
        let mut before = Seen::Nothing;
        for named in self.open.iter().chain([&self.last]) {
            if std::mem::replace(&mut before, *named) == *named {
                continue;
            }
            let mut named = *named;
            for _ in 1..reach {
                let Seen::At(place) = named else { break };
                let at = (place as usize).checked_sub(from);
                let Some(next) = at.and_then(|at| seen.get(at)) else {
                    break;
                };
                self.links.push((place, *next));
                named = *next;
            }
        }
    }
}

/// Passes over the modules of a chunk and tells what is seen beside each. `outside` is for each side what is seen from the chunk's
/// end there, and then outside of each branch that reaches beyond it.
///
/// What is seen to the right comes later: until then modules wait in places. Each module that is seen, and each bracket, is the place of
/// those behind it that are ignored.
fn beside<S: Narrow, T: Copy>(
    grammar: &Grammar,
    symbols: &[S],
    outside: &Sides<Vec<T>>,
    value: impl Fn(usize, S) -> T,
    nothing: T,
) -> Sides<Vec<T>> {
    let mut before = outside.left.iter().copied();
    let mut seen = before.next().unwrap_or(nothing);
    let mut left = vec![nothing; symbols.len()];
    let mut awaited = vec![nothing; symbols.len() + 1];
    let mut waits_at = vec![0_u32; symbols.len()];
    let number = |at: usize| u32::try_from(at).unwrap_or(NOTHING);
    // Those at the beginning wait at the end.
    let mut place = number(symbols.len());
    let come = |awaited: &mut [T], place: u32, value: T| {
        if let Some(cell) = awaited.get_mut(place as usize) {
            *cell = value;
        }
    };
    // What is seen where each branch begins, and the place that waits there.
    let mut open: Vec<(T, u32)> = Vec::new();
    let cells = left.iter_mut().zip(&mut waits_at);
    for ((at, symbol), (left, waits)) in symbols.iter().enumerate().zip(cells) {
        *left = seen;
        match grammar.role((*symbol).into()) {
            Role::Module | Role::Cut => {
                let own = value(at, *symbol);
                come(&mut awaited, place, own);
                (seen, place) = (own, number(at));
            }
            Role::Open => {
                open.push((seen, place));
                place = number(at);
            }
            Role::Close => {
                let outer = open.pop();
                let left = || (before.next().unwrap_or(nothing), number(at));
                (seen, place) = outer.unwrap_or_else(left);
            }
            Role::Ignored => {}
        }
        *waits = place;
    }
    let waiting = std::iter::once(place).chain(open.iter().rev().map(|(_, place)| *place));
    for (place, seen) in waiting.zip(&outside.right) {
        come(&mut awaited, place, *seen);
    }
    let came = |place: &u32| awaited.get(*place as usize).copied().unwrap_or(nothing);
    Sides {
        left,
        right: waits_at.iter().map(came).collect(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use proptest::prelude::*;

    use super::super::column::Column;
    use super::*;

    /// The place that is seen beside another, by the words of the specification.
    fn sought(grammar: &Grammar, symbols: &[u8], side: Side, from: usize) -> Option<usize> {
        let role = |at: usize| grammar.role(symbols[at].into());
        let mut at = from;
        let mut depth = 0;
        loop {
            at = side.next(at);
            if at >= symbols.len() {
                return None;
            }
            match (side, role(at)) {
                (_, Role::Module | Role::Cut) if depth == 0 => return Some(at),
                (Side::Left, Role::Close) | (Side::Right, Role::Open) => depth += 1,
                // To the left a branch goes on with its parent; to the right it ends.
                (Side::Right, Role::Close) if depth == 0 => return None,
                (Side::Left, Role::Open) | (Side::Right, Role::Close) if depth > 0 => depth -= 1,
                _ => {}
            }
        }
    }

    /// Balanced strings of `A`, `B`, the ignored `+`, and brackets.
    fn text() -> impl Strategy<Value = String> {
        proptest::collection::vec(0..8_u8, 0..60).prop_map(|tokens| {
            let (mut text, mut depth) = (String::new(), 0);
            for token in tokens {
                match token {
                    0 | 1 => {
                        depth += 1;
                        text.push('[');
                    }
                    2 | 3 if depth > 0 => {
                        depth -= 1;
                        text.push(']');
                    }
                    4 | 5 => text.push('+'),
                    6 => text.push('B'),
                    _ => text.push('A'),
                }
            }
            text.push_str(&"]".repeat(depth));
            text
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

        #[test]
        fn chunks_of_any_length_see_what_is_there(text in text(), chunk in 1..70_usize, parallel in any::<bool>()) {
            const REACH: usize = 4;
            let text = format!("ignore +\naxiom A{text}\nA < B > A -> B\n");
            let grammar = Grammar::parse(&text, "test").unwrap();
            let Column::Byte(symbols) = &grammar.axiom.symbols else {
                panic!("few symbols are bytes");
            };
            let never = AtomicBool::new(false);
            let seams = Seams::new(&grammar, symbols, REACH, (chunk, parallel), &never).unwrap();
            for number in 0..symbols.len().div_ceil(chunk) {
                let from = number * chunk;
                let places = seams.places(&grammar, symbols, number);
                for side in [Side::Left, Side::Right] {
                    for start in from..(from + chunk).min(symbols.len()) {
                        // As far as a context goes, through the chunk and beyond.
                        let (mut at, mut expected) = (start, Some(start));
                        for _ in 0..REACH {
                            let near = places.get(side).get(at.wrapping_sub(from)).copied();
                            let found = near.unwrap_or_else(|| seams.beyond(side, at));
                            expected = sought(&grammar, symbols, side, expected.unwrap());
                            let found = (found != NOTHING).then_some(found as usize);
                            prop_assert_eq!(found, expected, "{} {} {:?} {}", text, chunk, side, start);
                            match found {
                                Some(found) => at = found,
                                None => break,
                            }
                        }
                    }
                }
            }
        }
    }
}
