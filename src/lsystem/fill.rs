//! The fill pass of a round: writes what the chosen productions make of a chunk of the string.

use std::hint::select_unpredictable;
use std::sync::atomic::Ordering;

use super::batch::{Filling, Source};
use super::choice::Worker;
use super::column::{Cell, Narrow};
use super::context::Indexed;
use super::error::DeriveError;
use super::grammar::Rule;
use super::output::{MOST_TEMPLATES, Output, TEMPLATE, Template};
use super::rewrite::{Births, Round, Task};
use super::string::{ModuleString, parameters_of};

/// Modules written between two looks at the cancel flag where successors are long.
const WRITTEN_AT_ONCE: usize = 1 << 20;

impl Round<'_> {
    /// Computes the parameters and births of the successors of modules in a row, one by one.
    fn rewrite<S: Narrow, B: Cell>(
        &self,
        work: &mut Worker<'_, '_, Indexed<'_, S>>,
        rule: &Rule,
        source: Source<'_, B>,
        mut target: Output<'_, S, B>,
    ) -> Result<(), DeriveError> {
        let arity = source.own.len() / source.births.len().max(1);
        for (number, birth) in source.births.iter().enumerate() {
            let offset = number * arity;
            let own = source.own.get(offset..offset + arity).unwrap_or(&[]);
            let one = target.take(rule.successor.len(), rule.arguments.len());
            let (at, offset) = (source.at + number, source.offset + offset);
            work.evaluate(rule, at, offset, own, one.parameters)?;
            self.date(rule, own, *birth, one.parameters, one.births);
        }
        Ok(())
    }

    /// Writes what the chosen productions make of a chunk.
    pub(super) fn fill<S: Narrow, B: Cell>(
        &self,
        indexed: &Indexed<'_, S>,
        births: &[B],
        templates: Option<&[Template<S>]>,
        task: Task<'_, S, B>,
    ) -> Result<(), DeriveError> {
        if self.cancel.load(Ordering::Relaxed) {
            return Err(self.cancelled());
        }
        if let Some(templates) = templates {
            return self.fill_plain(indexed.symbols, births, templates, task);
        }
        let mut work = Worker::new(self, indexed);
        let mut filling = Filling::new(self, indexed);
        let mut out = task.out;
        let (mut at, mut offset) = (task.from, task.parameters_from);
        // Neighbours of which becomes the same are worked on in whole stretches.
        let mut rest = task.choices;
        while let Some(&choice) = rest.first() {
            let alike = rest.iter().take_while(|other| **other == choice).count();
            let (stretch, after) = rest.split_at(alike);
            rest = after;
            let symbols = indexed.symbols.get(at..at + stretch.len()).unwrap_or(&[]);
            let births = births.get(at..at + stretch.len()).unwrap_or(&[]);
            let choice: u16 = choice.into();
            let rule = self.rule(choice);
            let parameters = match (indexed.parameters.is_empty(), rule, symbols.first()) {
                (true, ..) | (.., None) => 0,
                (_, Some(_), Some(first)) => indexed.arity(*first) * stretch.len(),
                (_, None, _) => parameters_of(indexed.arity, symbols),
            };
            let own = indexed.parameters.get(offset..offset + parameters);
            let source = Source {
                at,
                offset,
                own: own.unwrap_or(&[]),
                births,
            };
            let made = match rule {
                None => {
                    let target = out.take(symbols.len(), parameters);
                    target.symbols.copy_from_slice(symbols);
                    target.births.copy_from_slice(births);
                    target.parameters.copy_from_slice(source.own);
                    symbols.len()
                }
                Some(rule) => {
                    let (length, count) = (rule.successor.len(), rule.arguments.len());
                    let mut target = out.take(alike * length, alike * count);
                    target.tile(&rule.successor);
                    match &mut filling {
                        Some(filling) if count > 0 => {
                            filling.add(usize::from(choice - 1), source, target)?;
                        }
                        _ => self.rewrite(&mut work, rule, source, target)?,
                    }
                    alike * length
                }
            };
            (at, offset) = (at + alike, offset + parameters);
            if !work.matcher.go_on(u32::try_from(made).unwrap_or(u32::MAX)) {
                return Err(self.cancelled());
            }
        }
        filling.map_or(Ok(()), Filling::finish)
    }
}

impl Round<'_> {
    /// The productions' successors, and behind them each symbol as what stays, for [`Self::fill_plain`]; none where modules have
    /// parameters.
    pub(super) fn templates<S: Cell>(&self, string: &ModuleString) -> Option<Vec<Template<S>>> {
        let rules = &self.rules.rules;
        let symbols = string.arity.len();
        let plain = rules.len() + symbols <= MOST_TEMPLATES
            && self.births == Births::Step
            && string.parameters.is_empty()
            && rules.iter().all(|rule| rule.arguments.is_empty());
        let staying = (0..).take(symbols).map(Template::staying);
        plain.then(|| rules.iter().map(Template::of).chain(staying).collect())
    }

    /// [`Self::fill`] where no module has parameters. A short successor is written as a whole template, whose excess
    /// the next module overwrites: a copy of fixed length costs next to nothing. A module that stays is its own successor, so that
    /// there is no branch of the program's to be guessed wrong.
    fn fill_plain<S: Narrow, B: Cell>(
        &self,
        old_symbols: &[S],
        old_births: &[B],
        templates: &[Template<S>],
        task: Task<'_, S, B>,
    ) -> Result<(), DeriveError> {
        let mut out = task.out;
        let mut written = 0;
        let old = |from: usize| {
            let symbols = old_symbols.get(from..).unwrap_or(&[]);
            symbols.iter().zip(old_births.get(from..).unwrap_or(&[]))
        };
        for (number, choices) in task.choices.chunks(TEMPLATE).enumerate() {
            let from = task.from + number * TEMPLATE;
            let stay = choices.iter().fold(true, |all, c| all & (*c == S::default()));
            let end = from + choices.len();
            if stay
                && let (Some(symbols), Some(births)) =
                    (old_symbols.get(from..end), old_births.get(from..end))
            {
                let target = out.take(choices.len(), 0);
                target.symbols.copy_from_slice(symbols);
                target.births.copy_from_slice(births);
                continue;
            }
            for ((symbol, birth), choice) in old(from).zip(choices) {
                let (symbol, choice): (usize, usize) = ((*symbol).into(), (*choice).into());
                let rules = self.rules.rules.len();
                let template = select_unpredictable(choice == 0, rules + symbol, choice.wrapping_sub(1));
                let Some(template) = templates.get(template) else {
                    continue;
                };
                let length = template.length;
                if length < TEMPLATE
                    && let (Some(s), Some(b)) =
                        (out.symbols.get_mut(..TEMPLATE), out.births.get_mut(..TEMPLATE))
                {
                    s.copy_from_slice(&template.symbols);
                    b.fill(B::of(self.step));
                    // Where no module is the same, the birth is written behind the successor, where it counts for nothing.
                    if let Some(same) = b.get_mut(template.heir.min(length)) {
                        *same = *birth;
                    }
                } else {
                    written += length;
                    self.fill_long(template, choice, *birth, &mut out);
                }
                out.skip(length);
            }
            if written > WRITTEN_AT_ONCE {
                written = 0;
                if self.cancel.load(Ordering::Relaxed) {
                    return Err(self.cancelled());
                }
            }
        }
        Ok(())
    }

    /// Writes a successor that is longer than a template, or the places that are left.
    #[cold]
    fn fill_long<S: Narrow, B: Cell>(
        &self,
        template: &Template<S>,
        choice: usize,
        birth: B,
        out: &mut Output<'_, S, B>,
    ) {
        let length = template.length;
        let (Some(symbols), Some(births)) =
            (out.symbols.get_mut(..length), out.births.get_mut(..length))
        else {
            return;
        };
        let rule = choice.checked_sub(1).and_then(|at| self.rules.rules.get(at));
        match rule {
            Some(rule) => symbols.iter_mut().zip(&rule.successor).for_each(|(cell, symbol)| {
                *cell = S::of(u32::from(*symbol));
            }),
            None => symbols.iter_mut().zip(&template.symbols).for_each(|(cell, s)| *cell = *s),
        }
        births.fill(B::of(self.step));
        if let Some(same) = births.get_mut(template.heir) {
            *same = birth;
        }
    }
}
