//! The fill pass of a round: writes what the chosen productions make of a chunk of the string.

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
    /// The productions' successors for [`Self::fill_plain`]; none where modules have parameters.
    pub(super) fn templates<S: Cell>(&self, string: &ModuleString) -> Option<Vec<Template<S>>> {
        let rules = &self.rules.rules;
        let plain = rules.len() <= MOST_TEMPLATES
            && self.births == Births::Step
            && string.parameters.is_empty()
            && rules.iter().all(|rule| rule.arguments.is_empty());
        plain.then(|| rules.iter().map(Template::of).collect())
    }

    /// [`Self::fill`] where no module has parameters. A short successor is written as a whole template, whose excess
    /// the next module overwrites: a copy of fixed length costs next to nothing.
    fn fill_plain<S: Narrow, B: Cell>(
        &self,
        old_symbols: &[S],
        old_births: &[B],
        templates: &[Template<S>],
        task: Task<'_, S, B>,
    ) -> Result<(), DeriveError> {
        let Output {
            symbols, births, ..
        } = task.out;
        let (mut out, mut checked) = (0, 0);
        let step = B::of(self.step);
        let end = task.from + task.choices.len();
        let old_symbols = old_symbols.get(task.from..end).unwrap_or(&[]);
        let old_births = old_births.get(task.from..end).unwrap_or(&[]);
        let groups = old_symbols
            .chunks(TEMPLATE)
            .zip(old_births.chunks(TEMPLATE));
        for ((own, own_births), choices) in groups.zip(task.choices.chunks(TEMPLATE)) {
            let stay = choices
                .iter()
                .fold(true, |all, c| all & (*c == S::default()));
            if stay
                && let (Some(s), Some(b)) = (
                    symbols.get_mut(out..out + own.len()),
                    births.get_mut(out..out + own.len()),
                )
            {
                s.copy_from_slice(own);
                b.copy_from_slice(own_births);
                out += own.len();
                continue;
            }
            for ((symbol, birth), choice) in own.iter().zip(own_births).zip(choices) {
                let choice: u16 = (*choice).into();
                let template = match choice.checked_sub(1) {
                    None => {
                        if let (Some(s), Some(b)) = (symbols.get_mut(out), births.get_mut(out)) {
                            (*s, *b) = (*symbol, *birth);
                        }
                        out += 1;
                        continue;
                    }
                    Some(rule) => templates.get(usize::from(rule)),
                };
                let Some(template) = template else { continue };
                let length = template.length;
                if length == 1
                    && let (Some(s), Some(b)) = (symbols.get_mut(out), births.get_mut(out))
                {
                    (*s, *b) = (template.symbols[0], step);
                } else if let (Some(s), Some(b)) = (
                    symbols.get_mut(out..out + TEMPLATE),
                    births.get_mut(out..out + TEMPLATE),
                ) && length <= TEMPLATE
                {
                    s.copy_from_slice(&template.symbols);
                    b.fill(step);
                } else if let (Some(s), Some(b), Some(rule)) = (
                    symbols.get_mut(out..out + length),
                    births.get_mut(out..out + length),
                    self.rule(choice),
                ) {
                    for (cell, symbol) in s.iter_mut().zip(&rule.successor) {
                        *cell = S::of(u32::from(*symbol));
                    }
                    b.fill(step);
                    if out - checked > WRITTEN_AT_ONCE {
                        checked = out;
                        if self.cancel.load(Ordering::Relaxed) {
                            return Err(self.cancelled());
                        }
                    }
                }
                if let Some(same) = template.heir.and_then(|heir| births.get_mut(out + heir)) {
                    *same = *birth;
                }
                out += length;
            }
        }
        Ok(())
    }
}
