//! The strings of a derivation, kept while a person goes back and forth between its steps and edits its grammar.
//!
//! A step that was seen is there at once; the next one is one rewriting away. An edit keeps every string that it
//! cannot have changed ([`super::edit`]), so only what must be is derived again. What [`History::at`] gives is what
//! [`Grammar::derive`] gives.
//!
//! Strings are kept within a budget of bytes; those farthest from the step that is looked at go first. Derivation in rounds keeps
//! all strings on its way, derivation at the growing ends the last few, and derivation by blocks is quick enough to keep none.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::derive::{Limits, See, derive_on};
use super::edit::{Edit, Present, present};
use super::error::DeriveError;
use super::grammar::Grammar;
use super::string::ModuleString;

/// A kept string.
#[derive(Clone, Debug)]
struct Kept {
    string: Arc<ModuleString>,
    /// The symbols that stand in it.
    symbols: Present,
}

impl Kept {
    fn of(grammar: &Grammar, string: Arc<ModuleString>) -> Self {
        let symbols = present(grammar, &string);
        Self { string, symbols }
    }

    fn bytes(&self) -> u64 {
        self.string.bytes() + self.symbols.len() as u64
    }
}

/// Strings by step.
#[derive(Clone, Debug)]
struct Shelf {
    kept: BTreeMap<u32, Kept>,
    /// Bytes that they take,
    bytes: u64,
    /// and may take.
    budget: u64,
}

impl Shelf {
    /// Puts a string on the shelf and takes others off where there are too many, those farthest from the step that is looked
    /// at first.
    fn put(&mut self, step: u32, kept: Kept, looked_at: u32) {
        self.bytes += kept.bytes();
        if let Some(old) = self.kept.insert(step, kept) {
            self.bytes -= old.bytes();
        }
        while self.bytes > self.budget {
            let ends = [self.kept.first_key_value(), self.kept.last_key_value()];
            let ends = ends.into_iter().flatten().map(|(step, _)| *step);
            let farthest = ends.max_by_key(|step| step.abs_diff(looked_at));
            let Some(farthest) = farthest.filter(|step| *step != looked_at) else {
                break;
            };
            self.take(farthest);
        }
    }

    fn take(&mut self, step: u32) -> Option<Kept> {
        let taken = self.kept.remove(&step)?;
        self.bytes -= taken.bytes();
        Some(taken)
    }
}

/// A derivation whose strings are kept.
#[derive(Clone, Debug)]
pub struct History {
    grammar: Grammar,
    shelf: Shelf,
}

impl History {
    /// The derivation of a grammar, whose strings may take `budget` bytes (that of the step looked at is kept in any case).
    #[must_use]
    pub fn new(grammar: Grammar, budget: u64) -> Self {
        let shelf = Shelf {
            kept: BTreeMap::new(),
            bytes: 0,
            budget,
        };
        Self { grammar, shelf }
    }

    /// The grammar as it is now.
    #[must_use]
    pub fn grammar(&self) -> &Grammar {
        &self.grammar
    }

    /// The steps whose strings are kept, in order.
    pub fn kept(&self) -> impl Iterator<Item = u32> + '_ {
        self.shelf.kept.keys().copied()
    }

    /// The string after so many steps.
    ///
    /// # Errors
    /// As [`Grammar::derive`], without the last whole step; what was kept stays.
    pub fn at(
        &mut self,
        step: u32,
        limits: &Limits,
        cancel: &AtomicBool,
    ) -> Result<Arc<ModuleString>, DeriveError> {
        let Self { grammar, shelf } = self;
        let before = shelf.kept.range(..=step).next_back();
        let before = before.map(|(step, kept)| (*step, Arc::clone(&kept.string)));
        let string = match &before {
            Some((last, string)) if *last == step => return Ok(Arc::clone(string)),
            Some((last, string)) if last + 1 == step => {
                grammar.derive_next(string, step, limits, cancel)?
            }
            before => {
                let from = before.as_ref().map(|(last, string)| (*last, &**string));
                let keeps = shelf.budget > 0;
                let mut see = |at: u32, string: &ModuleString| {
                    if string.bytes() <= shelf.budget && at < step {
                        shelf.put(at, Kept::of(grammar, Arc::new(string.clone())), step);
                    }
                };
                let see: Option<&mut See<'_>> = if keeps { Some(&mut see) } else { None };
                derive_on(grammar, from, step, limits, cancel, &mut |_| {}, see)?
            }
        };
        let string = Arc::new(string);
        shelf.put(step, Kept::of(grammar, Arc::clone(&string)), step);
        Ok(string)
    }

    /// Gives shapes of the grammar, by name, other displacements ([`Grammar::set_shape`]). Strings stay, but where the turtle answers
    /// queries in them.
    pub fn reshape<'s, S: AsRef<str>>(
        &mut self,
        shapes: impl IntoIterator<Item = (S, &'s [DVec3])>,
    ) {
        for (name, displacements) in shapes {
            self.grammar.set_shape(name.as_ref(), displacements);
        }
        if self.grammar.has_queries {
            self.shelf.kept.clear();
            self.shelf.bytes = 0;
        }
    }

    /// Goes on with another grammar, such as the same one with a production edited. Every kept string that is surely the same
    /// by it stays.
    pub fn edit(&mut self, grammar: Grammar) {
        let Self {
            grammar: old,
            shelf,
        } = self;
        let edit = Edit::new(old, &grammar);
        let first_changed = edit.as_ref().map_or(0, |edit| first_changed(edit, shelf));
        let numbers = edit.as_ref().and_then(Edit::renumbered);
        let most = grammar.axiom.symbols.most();
        let as_before =
            numbers.is_none() && most == old.axiom.symbols.most() && old.arity == grammar.arity;
        let steps: Vec<u32> = shelf.kept.keys().copied().collect();
        for step in steps {
            if step < first_changed && as_before {
                continue;
            }
            let Some(kept) = shelf.take(step).filter(|_| step < first_changed) else {
                continue;
            };
            let string = Arc::unwrap_or_clone(kept.string);
            if let Some(string) = string.renumbered(numbers, most, &grammar.arity) {
                shelf.put(step, Kept::of(&grammar, Arc::new(string)), step);
            }
        }
        self.grammar = grammar;
    }
}

/// The first step whose string may be another after an edit.
fn first_changed(edit: &Edit<'_>, shelf: &Shelf) -> u32 {
    let mut step = 0;
    let mut symbols = edit.first();
    loop {
        if let Some(kept) = shelf.kept.get(&step) {
            symbols.clone_from(&kept.symbols);
        }
        if !edit.has_all(&symbols) {
            return step;
        }
        if !edit.same_step(&symbols) {
            return step + 1;
        }
        let Some((next, _)) = shelf.kept.range(step + 1..).next() else {
            return step + 1; // nothing is kept from there on
        };
        // What is not kept is worked out from what it comes from, until that says nothing new.
        let after = edit.after(&symbols);
        step = if after == symbols { *next } else { step + 1 };
        symbols = after;
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    fn at(history: &mut History, step: u32) -> String {
        let cancel = AtomicBool::new(false);
        let string = history.at(step, &Limits::default(), &cancel).unwrap();
        string.to_text(history.grammar())
    }

    /// Each step, and the steps that stay after each edit of the one before.
    #[test]
    fn an_edit_keeps_what_it_cannot_change() {
        let grammar = |text: &str| Grammar::parse(text, "edited").unwrap();
        let text = "seed 1\naxiom A(0) X\nA(x) : x < 3 -> A(x+1)\nA(x) : x >= 3 -> B(x)\nB(x) > X -> B(x+uniform(0,1))C\nC -> D\n";
        for (from, to, stays) in [
            ("B(x+uniform", "B(x-uniform", 5),
            ("seed 1", "seed 2", 5),
            ("C -> D", "C -> DD", 6),
            ("x < 3", "x < 2", 1),
            ("x >= 3", "x >= 4", 1),
            // What is not there yet, though its predecessor is.
            ("C -> D", "C -> D\nA(x) < X -> XX", 1),
            ("C -> D", "C -> D\nD < X -> XX", 7),
            ("C -> D", "C -> D\nE -> F", 99),
            ("X\n", "XX\n", 0),
            ("C -> D", "C -> D\ndecompose {\nD -> E\n}", 0),
            ("axiom", "order specific\naxiom", 99),
            // Other numbers of the symbols, the same strings.
            (
                "axiom A(0) X",
                "const k = 0\ninterpret {\nQ -> P\n}\naxiom A(k) X",
                99,
            ),
            ("axiom", "ignore C\naxiom", 5),
            ("axiom", "# nothing\naxiom", 99),
        ] {
            let mut history = History::new(grammar(text), 1 << 20);
            for step in 0..9 {
                at(&mut history, step);
            }
            assert_eq!(history.kept().count(), 9);
            let edited = grammar(&text.replacen(from, to, 1));
            history.edit(edited.clone());
            let kept: Vec<u32> = (0..9).take_while(|step| *step < stays).collect();
            assert_eq!(history.kept().collect::<Vec<_>>(), kept, "{from}: {to}");
            for step in 0..9 {
                let fresh = edited.derive(step, &Limits::default(), &AtomicBool::new(false));
                let string = history.at(step, &Limits::default(), &AtomicBool::new(false));
                assert_eq!(*string.unwrap(), fresh.unwrap(), "{from}: {to}");
            }
        }
    }

    /// Another shape is another drawing of the same strings, unless they hold what the turtle answered.
    #[test]
    fn other_shapes_keep_strings_without_queries() {
        let with = |rest: &str, shape: &str| {
            let text = format!("axiom A(0)\nA(x) -> A(x+1){rest}\nshape A = [(0 {shape} 0)]\n");
            Grammar::parse(&text, "shaped").unwrap()
        };
        for (rest, kept) in [("B", 5), ("?P(0,0,0)", 0)] {
            let mut history = History::new(with(rest, "1"), 1 << 20);
            (0..5).for_each(|step| _ = at(&mut history, step));
            let nothing: [(&str, &[DVec3]); 1] = [("Z", &[])];
            history.reshape(nothing);
            history.reshape([("A", [DVec3::Y * 2.0].as_slice())]);
            assert_eq!(history.kept().count(), kept, "{rest}");
            assert_eq!(*history.grammar(), with(rest, "2"));
            let fresh = with(rest, "2").derive(4, &Limits::default(), &AtomicBool::new(false));
            let string = history.at(4, &Limits::default(), &AtomicBool::new(false));
            assert_eq!(*string.unwrap(), fresh.unwrap(), "{rest}");
        }
    }

    #[test]
    fn the_budget_is_kept() {
        let grammar = Grammar::parse("axiom A(1)\nA(x) -> A(x)A(x+1)\n", "grows").unwrap();
        let mut history = History::new(grammar, 4096);
        for step in (0..12).chain((3..9).rev()) {
            at(&mut history, step);
            let kept: Vec<u32> = history.kept().collect();
            assert!(kept.contains(&step), "{kept:?}");
            assert!(history.shelf.bytes <= 4096 || kept == [step], "{kept:?}");
            let sum: u64 = history.shelf.kept.values().map(Kept::bytes).sum();
            assert_eq!(sum, history.shelf.bytes);
        }
    }
}
