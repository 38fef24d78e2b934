//! Context matching: the search of both contexts, and the index of brackets and parameters that it needs in a packed string.
//!
//! The index holds, for each bracket, its partner, so that a whole branch is passed in one step however long it is, and
//! the start of every 64th module's parameters, so that any module's are found by adding up at most 63 counts.

use std::sync::atomic::{AtomicBool, Ordering};

use super::grammar::{Grammar, Pattern, Role, Rule};
use super::names::Symbol;
use super::string::ModuleString;

/// Modules between two entries of the index of parameters.
const BLOCK: usize = 64;
/// Modules that may be visited between two looks at the cancel flag.
const VISITS_BETWEEN_CHECKS: u32 = 1 << 16;

/// Index over one string.
#[derive(Debug, Default)]
pub(crate) struct ContextIndex {
    /// For each bracket the index of its partner (empty where the string has no brackets).
    partner: Vec<u32>,
    /// Where the parameters of every `BLOCK`th module begin (empty where there are none).
    blocks: Vec<u64>,
}

impl ContextIndex {
    /// Bytes that the index of a string of so many modules takes.
    pub(crate) fn bytes(modules: u64) -> u64 {
        modules
            .saturating_mul(4)
            .saturating_add(modules / BLOCK as u64 * 8)
    }

    /// `None`: cancelled.
    pub(crate) fn new(
        grammar: &Grammar,
        string: &ModuleString,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let mut index = Self::default();
        let brackets = |s: &Symbol| matches!(grammar.role(*s), Role::Open | Role::Close);
        if !grammar.literal && string.symbols.iter().any(brackets) {
            index.partner = vec![0; string.len()];
            let mut open: Vec<u32> = Vec::new();
            for (chunk_index, chunk) in string.symbols.chunks(1 << 16).enumerate() {
                if cancel.load(Ordering::Relaxed) {
                    return None;
                }
                for (i, symbol) in chunk.iter().enumerate() {
                    let at = (chunk_index << 16) + i;
                    let Ok(here) = u32::try_from(at) else {
                        continue;
                    };
                    match grammar.role(*symbol) {
                        Role::Open => open.push(here),
                        Role::Close => {
                            // Strings are balanced: the parser has checked the axiom and every successor.
                            let start = open.pop().unwrap_or(here);
                            if let Some(p) = index.partner.get_mut(start as usize) {
                                *p = here;
                            }
                            if let Some(p) = index.partner.get_mut(at) {
                                *p = start;
                            }
                        }
                        _ => {}
                    }
                }
            }
        }
        if !string.parameters.is_empty() {
            let mut offset = 0_u64;
            index.blocks.reserve_exact(string.len() / BLOCK + 1);
            for block in string.symbols.chunks(BLOCK) {
                index.blocks.push(offset);
                offset += block
                    .iter()
                    .map(|s| u64::from(string.arity.get(usize::from(*s)).copied().unwrap_or(0)))
                    .sum::<u64>();
            }
        }
        Some(index)
    }
}

/// A string as contexts see it: modules at places, with neighbours.
pub(crate) trait Modules {
    /// The module at a place; `None` past the end.
    fn symbol(&self, at: usize) -> Option<Symbol>;
    /// The place to the left; `None` at the start.
    fn before(&self, at: usize) -> Option<usize>;
    /// The place to the right, perhaps past the end.
    fn after(&self, at: usize) -> usize;
    /// For a bracket the place of its partner.
    fn partner(&self, at: usize) -> usize;
    /// The parameters of the module at a place, whose symbol this is.
    fn parameters(&self, at: usize, symbol: Symbol) -> &[f64];
}

/// A packed string with its index: places are positions.
pub(crate) struct Indexed<'a> {
    pub(crate) string: &'a ModuleString,
    pub(crate) index: ContextIndex,
}

impl Indexed<'_> {
    /// Where the parameters of the module at `at` begin.
    fn offset(&self, at: usize) -> usize {
        let block = at / BLOCK;
        let start = self
            .index
            .blocks
            .get(block)
            .map_or(0, |o| usize::try_from(*o).unwrap_or(usize::MAX));
        let before = self.string.symbols.get(block * BLOCK..at).unwrap_or(&[]);
        start + before.iter().map(|s| self.string.arity(*s)).sum::<usize>()
    }
}

impl Modules for Indexed<'_> {
    fn symbol(&self, at: usize) -> Option<Symbol> {
        self.string.symbols.get(at).copied()
    }

    fn before(&self, at: usize) -> Option<usize> {
        at.checked_sub(1)
    }

    fn after(&self, at: usize) -> usize {
        at + 1
    }

    fn partner(&self, at: usize) -> usize {
        self.index.partner.get(at).map_or(at, |p| *p as usize)
    }

    fn parameters(&self, at: usize, symbol: Symbol) -> &[f64] {
        let arity = self.string.arity(symbol);
        if arity == 0 {
            return &[];
        }
        let from = self.offset(at);
        self.string
            .parameters
            .get(from..from + arity)
            .unwrap_or(&[])
    }
}

/// A module without neighbours, where no production has a context.
pub(crate) struct Alone;

impl Modules for Alone {
    fn symbol(&self, _at: usize) -> Option<Symbol> {
        None
    }

    fn before(&self, _at: usize) -> Option<usize> {
        None
    }

    fn after(&self, at: usize) -> usize {
        at
    }

    fn partner(&self, at: usize) -> usize {
        at
    }

    fn parameters(&self, _at: usize, _symbol: Symbol) -> &[f64] {
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
        let source = self.modules.parameters(at, symbol);
        let slot = usize::from(slot);
        if let Some(target) = bound.get_mut(slot..slot + source.len()) {
            target.copy_from_slice(source);
        }
    }

    /// Whether both contexts of `rule` match the module at `at`; binds their parameters.
    pub(crate) fn matches(&mut self, rule: &Rule, at: usize, bound: &mut [f64]) -> bool {
        self.left(&rule.left, at, bound) && self.right(&rule.right, self.modules.after(at), bound)
    }

    fn left(&mut self, pattern: &[Pattern], mut at: usize, bound: &mut [f64]) -> bool {
        for item in pattern {
            let Pattern::Module { symbol, slot } = item else {
                return false;
            };
            loop {
                let Some(before) = self.modules.before(at) else {
                    return false;
                };
                at = before;
                let Some(found) = self.modules.symbol(at) else {
                    return false;
                };
                if !self.go_on(1) {
                    return false;
                }
                match self.grammar.role(found) {
                    Role::Open | Role::Close if self.grammar.literal => return false,
                    Role::Close => at = self.modules.partner(at),
                    Role::Open => {}
                    Role::Ignored if !self.grammar.literal => {}
                    _ if found == *symbol => {
                        self.bind(at, found, *slot, bound);
                        break;
                    }
                    _ => return false,
                }
            }
        }
        true
    }

    /// Matches a right context from `at` on. A branch in the pattern matches a prefix of a branch in the string;
    /// recursion is bounded by the parser's bound on branches in a pattern.
    fn right(&mut self, pattern: &[Pattern], mut at: usize, bound: &mut [f64]) -> bool {
        let mut next = 0;
        while let Some(item) = pattern.get(next) {
            let Some(found) = self.modules.symbol(at) else {
                return false;
            };
            if !self.go_on(1) {
                return false;
            }
            let role = self.grammar.role(found);
            if self.grammar.literal {
                match item {
                    Pattern::Module { symbol, slot }
                        if found == *symbol && role != Role::Open && role != Role::Close =>
                    {
                        self.bind(at, found, *slot, bound);
                        next += 1;
                        at = self.modules.after(at);
                        continue;
                    }
                    _ => return false,
                }
            }
            match (item, role) {
                (_, Role::Close) => return false,
                (_, Role::Ignored) => at = self.modules.after(at),
                (Pattern::Open { inside }, Role::Open) => {
                    let inner = pattern.get(next + 1..=next + inside).unwrap_or(&[]);
                    if self.right(inner, self.modules.after(at), bound) {
                        next += inside + 2;
                    }
                    at = self.modules.after(self.modules.partner(at));
                }
                (Pattern::Module { .. }, Role::Open) => {
                    at = self.modules.after(self.modules.partner(at))
                }
                (Pattern::Module { symbol, slot }, _) if found == *symbol => {
                    self.bind(at, found, *slot, bound);
                    next += 1;
                    at = self.modules.after(at);
                }
                _ => return false,
            }
        }
        true
    }
}
