//! Context matching: the search of both contexts, and the index of a packed string that makes each look O(1).
//!
//! What a context sees next to a module may stand far away: behind whole branches and ignored modules. [`super::neighbours`] finds that
//! for a chunk at a time, on the sides that productions look at. Where nothing is to be skipped, it is simply the next
//! module and nothing is looked for. Productions whose right context has branches in it look into the branches, for which the
//! index holds the partner of each bracket. The start of every 8th module's parameters says where any module's are.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::column::Narrow;
use super::grammar::{Grammar, Pattern, Role, Rule, RuleSet};
use super::names::Symbol;
use super::neighbours::{NOTHING, Seams, Side, Sides};
use super::rewrite::TOGETHER;
use super::string::{arity_of, parameters_of};

/// Modules between two entries of the index of parameters,
const BLOCK: usize = 8;
/// and of a stretch, at whose beginning they count anew.
const STRETCH: usize = 8192;
/// Modules that may be visited between two looks at the cancel flag.
const VISITS_BETWEEN_CHECKS: u32 = 1 << 16;
/// Modules between two looks at the cancel flag while an index is made.
const INDEXED_AT_ONCE: usize = 1 << 16;

/// Index over one string; what is not needed is empty.
#[derive(Debug, Default)]
pub(crate) struct ContextIndex {
    /// Whence it is found what contexts see; none where that is the module next to each.
    pub(super) seams: Option<Seams>,
    /// For each bracket the place of its partner.
    partner: Vec<u32>,
    /// Where the parameters of any module begin.
    starts: Starts,
}

/// Where the parameters of every `BLOCK`th module begin: in its stretch of `STRETCH` modules,
#[derive(Debug, Default)]
struct Starts {
    within: Vec<u32>,
    /// and where those of each stretch begin.
    stretches: Vec<usize>,
}

impl Starts {
    fn new<S: Narrow>(arity: &[u8], symbols: &[S], parallel: bool) -> Self {
        let mut within = vec![0; symbols.len().div_ceil(BLOCK)];
        let fill = |(starts, symbols): (&mut [u32], &[S])| {
            let mut offset = 0;
            for (start, block) in starts.iter_mut().zip(symbols.chunks(BLOCK)) {
                *start = u32::try_from(offset).unwrap_or(u32::MAX);
                offset += parameters_of(arity, block);
            }
            offset
        };
        let lengths: Vec<usize> = if parallel {
            let starts = within.par_chunks_mut(STRETCH / BLOCK);
            let stretches = starts.zip(symbols.par_chunks(STRETCH));
            stretches.with_max_len(TOGETHER).map(fill).collect()
        } else {
            let starts = within.chunks_mut(STRETCH / BLOCK);
            starts.zip(symbols.chunks(STRETCH)).map(fill).collect()
        };
        let stretches = sums_before(lengths);
        Self { within, stretches }
    }

    /// The start of a block.
    fn of(&self, block: usize) -> usize {
        let stretch = self.stretches.get(block / (STRETCH / BLOCK));
        let within = self.within.get(block).map_or(0, |start| *start as usize);
        stretch.copied().unwrap_or(0) + within
    }
}

/// For each length the sum of those before it.
pub(super) fn sums_before(mut lengths: Vec<usize>) -> Vec<usize> {
    let mut sum = 0;
    for length in &mut lengths {
        sum += std::mem::replace(length, sum);
    }
    lengths
}

impl ContextIndex {
    /// Bytes that it takes.
    pub(crate) fn bytes(&self) -> u64 {
        let arrays = 4 * (self.partner.len() + self.starts.within.len());
        self.seams.as_ref().map_or(0, Seams::bytes) + arrays as u64
    }

    /// The index of a string that is worked on in chunks of so many modules, by several threads where `parallel`. `None`: cancelled.
    pub(crate) fn new<S: Narrow>(
        grammar: &Grammar,
        rules: &RuleSet,
        symbols: &[S],
        chunks: (usize, bool),
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let mut index = Self::default();
        let looks = rules.looks;
        let skipped = |symbol: &S| grammar.role((*symbol).into()) != Role::Module;
        // The string is not looked through where the grammar has nothing to skip.
        let skips = !grammar.literal && grammar.roles.iter().any(|role| *role != Role::Module);
        if skips && symbols.iter().any(skipped) {
            if looks.left || looks.right {
                let lengths = rules
                    .rules
                    .iter()
                    .map(|rule| rule.left.len().max(rule.right.len()));
                let reach = lengths.max().unwrap_or(0);
                index.seams = Some(Seams::new(grammar, symbols, reach, chunks, cancel)?);
            }
            if looks.into_branches {
                index.partner = partners(grammar, symbols, cancel)?;
            }
        }
        if looks.binds {
            index.starts = Starts::new(&grammar.arity, symbols, chunks.1);
        }
        Some(index)
    }
}

/// What contexts see beside the modules of one chunk.
#[derive(Default)]
pub(super) struct Window {
    /// Its first module.
    from: usize,
    /// For each the place of the module that contexts see to its left, and to its right in its own branch; empty where that is the
    /// next one.
    places: Sides<Vec<u32>>,
}

impl Window {
    /// Of a chunk, given its number and its first module.
    pub(super) fn new<S: Narrow>(
        grammar: &Grammar,
        index: &ContextIndex,
        symbols: &[S],
        (number, from): (usize, usize),
    ) -> Self {
        let seams = index.seams.as_ref();
        Self {
            from,
            places: seams.map_or_else(Sides::default, |seams| {
                seams.places(grammar, symbols, number)
            }),
        }
    }
}

/// For each bracket the place of its partner. `None`: cancelled.
fn partners<S: Narrow>(grammar: &Grammar, symbols: &[S], cancel: &AtomicBool) -> Option<Vec<u32>> {
    let mut partner = vec![0; symbols.len()];
    let mut open: Vec<u32> = Vec::new();
    for (at, symbol) in symbols.iter().enumerate() {
        if at % INDEXED_AT_ONCE == 0 && cancel.load(Ordering::Relaxed) {
            return None;
        }
        let Ok(here) = u32::try_from(at) else {
            continue;
        };
        match grammar.role((*symbol).into()) {
            Role::Open => open.push(here),
            Role::Close => {
                let start = open.pop().unwrap_or(here);
                if let Some(p) = partner.get_mut(start as usize) {
                    *p = here;
                }
                if let Some(p) = partner.get_mut(at) {
                    *p = start;
                }
            }
            _ => {}
        }
    }
    Some(partner)
}

/// A string as contexts see it: modules at places, with neighbours.
pub(crate) trait Modules {
    /// The module at a place; `None` past the end.
    fn symbol(&self, at: usize) -> Option<Symbol>;
    /// The place of the module that contexts see to the left; `None` where there is none.
    fn left(&self, at: usize) -> Option<usize>;
    /// The place of the module that contexts see to the right in the same branch.
    fn right(&self, at: usize) -> Option<usize>;
    /// For a bracket the place of its partner, where productions look into branches.
    fn partner(&self, at: usize) -> usize;
    /// The parameters of the module at a place, whose symbol this is.
    fn parameters(&self, at: usize, symbol: Symbol, base: Base) -> &[f64];
}

/// A place whose parameters are known to begin there, to find those of its neighbours.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Base {
    pub(crate) at: usize,
    pub(crate) offset: usize,
}

/// Copies parameters into the slots from `slot` on.
#[inline]
pub(crate) fn bind(bound: &mut [f64], slot: usize, source: &[f64]) {
    match (bound.get_mut(slot..slot + source.len()), source) {
        // The commonest length needs no call.
        (Some([target]), [value]) => *target = *value,
        (Some(target), _) => target.copy_from_slice(source),
        (None, _) => {}
    }
}

/// A packed string with its index: places are positions.
pub(crate) struct Indexed<'a, S> {
    pub(super) symbols: &'a [S],
    pub(super) parameters: &'a [f64],
    /// Number of parameters of each symbol.
    pub(super) arity: &'a [u8],
    pub(super) index: &'a ContextIndex,
    /// What contexts see beside the modules that are worked on.
    pub(super) window: Window,
}

impl<S: Narrow> Indexed<'_, S> {
    /// The module that contexts see beside another on a side; past the end or before the beginning where there is none.
    #[inline]
    fn beside(&self, side: Side, at: usize) -> usize {
        let Some(seams) = &self.index.seams else {
            return side.next(at);
        };
        let near = self.window.places.get(side);
        let near = near.get(at.wrapping_sub(self.window.from));
        let place = near.copied().unwrap_or_else(|| seams.beyond(side, at));
        if place == NOTHING {
            usize::MAX
        } else {
            place as usize
        }
    }

    #[inline]
    pub(super) fn arity(&self, symbol: S) -> usize {
        arity_of(self.arity, symbol)
    }

    /// The number of parameters of a symbol that is asked for by its number.
    #[inline]
    pub(super) fn arity_of(&self, symbol: Symbol) -> usize {
        arity_of(self.arity, symbol)
    }

    /// Where the parameters of the module at `at` begin.
    fn offset(&self, at: usize) -> usize {
        let block = at / BLOCK;
        let before = self.symbols.get(block * BLOCK..at).unwrap_or(&[]);
        self.index.starts.of(block) + parameters_of(self.arity, before)
    }
}

impl<S: Narrow> Indexed<'_, S> {
    /// Whether a context without branches stands beside the module at a place.
    #[inline]
    pub(super) fn fits(&self, pattern: &[Pattern], side: Side, mut at: usize) -> bool {
        pattern.iter().all(|wanted| {
            at = self.beside(side, at);
            let found = self.symbol(at);
            found.is_some() && found == wanted.symbol()
        })
    }

    /// Whether the context surely stands beside each of the modules, which can be told where these stand next to each
    /// other.
    pub(super) fn fits_all(&self, pattern: &[Pattern], side: Side, at: &[usize]) -> bool {
        let (Some(&first), Some(&last)) = (at.first(), at.last()) else {
            return true;
        };
        if self.index.seams.is_some() || last - first + 1 != at.len() {
            return false;
        }
        (1..).zip(pattern).all(|(distance, wanted)| {
            let stretch = match side {
                Side::Left => first.checked_sub(distance).zip(last.checked_sub(distance)),
                Side::Right => Some((first + distance, last + distance)),
            };
            let stretch = stretch.and_then(|(first, last)| self.symbols.get(first..=last));
            let wanted = wanted.symbol().map(|symbol| S::of(u32::from(symbol)));
            wanted.is_some_and(|wanted| {
                stretch.is_some_and(|all| all.iter().fold(true, |fit, s| fit & (*s == wanted)))
            })
        })
    }

    /// Goes from places to those that contexts see beside them, where modules with `arity` parameters stand; and from the near
    /// edge of the former's parameters to the start of theirs.
    pub(super) fn step(&self, side: Side, arity: usize, at: &mut [usize], edge: &mut [usize]) {
        let back = if side == Side::Left { arity } else { 0 };
        if self.index.seams.is_none() {
            for (at, edge) in at.iter_mut().zip(edge) {
                *at = side.next(*at);
                *edge = edge.saturating_sub(back);
            }
            return;
        }
        for (at, edge) in at.iter_mut().zip(edge) {
            let place = self.beside(side, *at);
            *edge = if place == side.next(*at) {
                edge.saturating_sub(back)
            } else {
                self.offset(place)
            };
            *at = place;
        }
    }
}

impl<S: Narrow> Modules for Indexed<'_, S> {
    #[inline]
    fn symbol(&self, at: usize) -> Option<Symbol> {
        self.symbols.get(at).copied().map(Into::into)
    }

    #[inline]
    fn left(&self, at: usize) -> Option<usize> {
        Some(self.beside(Side::Left, at)).filter(|place| *place != usize::MAX)
    }

    #[inline]
    fn right(&self, at: usize) -> Option<usize> {
        Some(self.beside(Side::Right, at)).filter(|place| *place != usize::MAX)
    }

    fn partner(&self, at: usize) -> usize {
        self.index.partner.get(at).map_or(at, |p| *p as usize)
    }

    fn parameters(&self, at: usize, symbol: Symbol, base: Base) -> &[f64] {
        let arity = arity_of(self.arity, symbol);
        if arity == 0 {
            return &[];
        }
        let from = if at + 1 == base.at {
            base.offset.saturating_sub(arity)
        } else if at == base.at + 1 {
            let own = self.symbol(base.at);
            base.offset + own.map_or(0, |own| arity_of(self.arity, own))
        } else {
            self.offset(at)
        };
        self.parameters.get(from..from + arity).unwrap_or(&[])
    }
}

/// A module without neighbours, where no production has a context.
pub(crate) struct Alone;

impl Modules for Alone {
    fn symbol(&self, _at: usize) -> Option<Symbol> {
        None
    }

    fn left(&self, _at: usize) -> Option<usize> {
        None
    }

    fn right(&self, _at: usize) -> Option<usize> {
        None
    }

    fn partner(&self, at: usize) -> usize {
        at
    }

    fn parameters(&self, _at: usize, _symbol: Symbol, _base: Base) -> &[f64] {
        &[]
    }
}

/// Matches contexts in one string.
pub(crate) struct Matcher<'a, M> {
    grammar: &'a Grammar,
    modules: &'a M,
    cancel: &'a AtomicBool,
    /// Modules visited since the last look at the cancel flag.
    visits: u32,
    /// The module whose contexts are searched.
    pub(crate) base: Base,
    /// Set once the flag was seen: every search then fails, and the caller asks why.
    pub(crate) cancelled: bool,
}

impl<'a, M: Modules> Matcher<'a, M> {
    pub(crate) fn new(grammar: &'a Grammar, modules: &'a M, cancel: &'a AtomicBool) -> Self {
        Self {
            grammar,
            modules,
            cancel,
            visits: 0,
            base: Base::default(),
            cancelled: false,
        }
    }

    /// Counts `work` and looks at the cancel flag now and then; true while the work may go on.
    #[inline]
    pub(crate) fn go_on(&mut self, work: u32) -> bool {
        self.visits = self.visits.saturating_add(work);
        if self.visits >= VISITS_BETWEEN_CHECKS {
            self.visits = 0;
            self.cancelled |= self.cancel.load(Ordering::Relaxed);
        }
        !self.cancelled
    }

    /// Copies the parameters of the module at `at` into the slots from `slot` on.
    fn bind(&self, at: usize, symbol: Symbol, slot: u16, bound: &mut [f64]) {
        let source = self.modules.parameters(at, symbol, self.base);
        bind(bound, usize::from(slot), source);
    }

    /// Whether both contexts of `rule` match the module at `at`; binds their parameters.
    #[inline]
    pub(crate) fn matches(&mut self, rule: &Rule, at: usize, bound: &mut [f64]) -> bool {
        let right_has_branches = rule.looks.into_branches;
        self.line(&rule.left, at, M::left, bound)
            && if right_has_branches {
                self.branches(&rule.right, at + 1, bound)
            } else {
                self.line(&rule.right, at, M::right, bound)
            }
    }

    /// Matches modules one after the other on a side.
    #[inline]
    fn line(
        &mut self,
        pattern: &[Pattern],
        mut at: usize,
        next: fn(&M, usize) -> Option<usize>,
        bound: &mut [f64],
    ) -> bool {
        for item in pattern {
            let Pattern::Module { symbol, slot } = item else {
                return false;
            };
            let Some(place) = next(self.modules, at) else {
                return false;
            };
            if self.modules.symbol(place) != Some(*symbol) {
                return false;
            }
            at = place;
            self.bind(at, *symbol, *slot, bound);
            if !self.go_on(1) {
                return false;
            }
        }
        true
    }

    /// Matches a right context that has branches, from `at` on. A branch in the pattern matches a prefix of a branch in the
    /// string; recursion is bounded by the parser's bound on branches in a pattern.
    fn branches(&mut self, pattern: &[Pattern], mut at: usize, bound: &mut [f64]) -> bool {
        let mut next = 0;
        while let Some(item) = pattern.get(next) {
            let Some(found) = self.modules.symbol(at) else {
                return false;
            };
            if !self.go_on(1) {
                return false;
            }
            match (item, self.grammar.role(found)) {
                (_, Role::Close) => return false,
                (_, Role::Ignored) => at += 1,
                (Pattern::Open { inside }, Role::Open) => {
                    let inner = pattern.get(next + 1..=next + inside).unwrap_or(&[]);
                    if self.branches(inner, at + 1, bound) {
                        next += inside + 2;
                    }
                    at = self.modules.partner(at) + 1;
                }
                (Pattern::Module { .. }, Role::Open) => at = self.modules.partner(at) + 1,
                (Pattern::Module { symbol, slot }, _) if found == *symbol => {
                    self.bind(at, found, *slot, bound);
                    next += 1;
                    at += 1;
                }
                _ => return false,
            }
        }
        true
    }
}
