//! The C preprocessor as far as cpfg's files use it: comments, `#define` of constants and simple macros, `#include` of a file in the
//! grammar's folder, `#ifdef`.
//!
//! A macro that is a plain number stays a name, which becomes a constant of the grammar; others are replaced where they stand. `//` begins
//! a comment at the beginning of a line or between blanks only, since it is two rolls elsewhere.

use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use super::text::{Fault, Foreign, MAX_FOREIGN_BYTES};
use crate::lsystem::error::GrammarErrors;
use crate::lsystem::include::read_included;
use crate::lsystem::source::Source;

/// `#if` within `#if`.
const MAX_CONDITIONS: usize = 64;
/// Bytes of macros that are looked at for one file.
const BUDGET: usize = 16 << 20;
/// Bytes of a macro's arguments.
const MAX_ARGUMENT_BYTES: usize = 1024;
/// Macros within macros.
const MAX_DEPTH: usize = 16;
/// What marks a constant for the reader: one line for each, before everything else.
pub(super) const CONSTANT_MARK: char = '\u{1}';

#[derive(Clone, Debug)]
struct Macro {
    formals: Option<Vec<String>>,
    body: String,
}

struct Preprocessor<'a> {
    foreign: Foreign,
    macros: HashMap<String, Macro>,
    /// Names that are plain numbers.
    constants: HashSet<String>,
    faults: &'a mut GrammarErrors,
    folder: Option<&'a Path>,
    chain: Vec<PathBuf>,
    /// In a `/*` comment.
    comment: bool,
    /// For each `#if` whether its part is read.
    conditions: Vec<bool>,
    /// Bytes of macros that may still be looked at.
    budget: Cell<usize>,
}

/// The text that is read behind the preprocessor; `text` is the file's, of the same length.
pub(super) fn preprocess(
    source: Source,
    text: &str,
    folder: Option<&Path>,
    faults: &mut GrammarErrors,
) -> Foreign {
    let mut chain = Vec::new();
    chain.extend(Path::new(&source.name).canonicalize());
    let mut preprocessor = Preprocessor {
        foreign: Foreign::default(),
        macros: HashMap::new(),
        constants: HashSet::new(),
        budget: Cell::new(BUDGET),
        faults,
        folder,
        chain,
        comment: false,
        conditions: Vec::new(),
    };
    preprocessor.file(source, text);
    preprocessor.foreign
}

impl Preprocessor<'_> {
    fn is_spent(&self) -> bool {
        self.foreign.text.len() > MAX_FOREIGN_BYTES || self.budget.get() == 0
    }

    fn fault(&mut self, file: usize, fault: Fault) {
        if let Some(source) = self.foreign.file(file) {
            let error = source.error(fault.at, fault.message);
            self.faults.push(error);
        }
    }

    fn file(&mut self, source: Source, text: &str) {
        let file = self.foreign.add_file(source);
        let open = self.conditions.len();
        let mut at = 0;
        let mut lines = text.split_inclusive('\n').peekable();
        while let Some(line) = lines.next() {
            let start = at;
            at += line.len();
            let mut whole = vec![(start, line)];
            let mut last = line;
            let joins = |next: &&str| directive(line).is_some() || goes_on(next);
            while ends_in_backslash(last)
                && let Some(next) = lines.next_if(joins)
            {
                whole.push((at, next));
                at += next.len();
                last = next;
            }
            if let Err(fault) = self.line(file, &whole) {
                self.fault(file, fault);
            }
            if self.is_spent() {
                let message = "the macros and includes of this file make it too long";
                self.fault(file, Fault::new(start, message));
                return;
            }
        }
        if self.conditions.len() > open {
            self.conditions.truncate(open);
            self.fault(
                file,
                Fault::new(text.len(), "an `#if` is not closed; expected `#endif`"),
            );
        }
    }

    /// A line, with those that a `\` at the end joins to it.
    fn line(&mut self, file: usize, whole: &[(usize, &str)]) -> Result<(), Fault> {
        let Some((start, first)) = whole.first().copied() else {
            return Ok(());
        };
        if !self.comment
            && let Some((word, length)) = directive(first)
        {
            let mut rest = first.get(length..).unwrap_or("").to_owned();
            for (_, next) in whole.iter().skip(1) {
                rest = rest.trim_end().trim_end_matches('\\').to_owned();
                rest.push_str(next);
            }
            self.directive(file, start, word, &without_comments(&rest))?;
            self.foreign
                .copy("\n", file, start + first.len().saturating_sub(1));
            return Ok(());
        }
        if self.conditions.contains(&false) {
            return Ok(());
        }
        for (i, (at, part)) in whole.iter().enumerate() {
            let part = match i + 1 < whole.len() {
                true => part.trim_end().strip_suffix('\\').unwrap_or(part),
                false => part,
            };
            self.text(file, *at, part)?;
        }
        Ok(())
    }

    fn directive(&mut self, file: usize, at: usize, word: &str, rest: &str) -> Result<(), Fault> {
        let name = rest.trim();
        if self.conditions.len() >= MAX_CONDITIONS && word.starts_with("if") {
            let message = format!("`#{word}` nests deeper than {MAX_CONDITIONS}");
            return Err(Fault::new(at, message));
        }
        match word {
            "ifdef" | "ifndef" => {
                let known = self.macros.contains_key(name) || self.constants.contains(name);
                self.conditions.push(known == (word == "ifdef"));
            }
            "if" => match name {
                "0" => self.conditions.push(false),
                "1" => self.conditions.push(true),
                _ => {
                    self.conditions.push(true);
                    return Err(Fault::new(
                        at,
                        "expected `#if 0`, `#if 1`, `#ifdef NAME` or `#ifndef NAME`",
                    ));
                }
            },
            "else" => match self.conditions.last_mut() {
                Some(condition) => *condition = !*condition,
                None => return Err(Fault::new(at, "this `#else` has no `#if` before it")),
            },
            "endif" => {
                if self.conditions.pop().is_none() {
                    return Err(Fault::new(at, "this `#endif` has no `#if` before it"));
                }
            }
            _ if self.conditions.contains(&false) => {}
            "define" => return self.define(file, at, rest.trim()),
            "undef" => {
                self.macros.remove(name);
            }
            "include" => return self.include(at, name),
            "line" | "pragma" => {}
            _ => return Err(Fault::new(at, format!("`#{word}` cannot be carried over"))),
        }
        Ok(())
    }

    fn define(&mut self, file: usize, at: usize, rest: &str) -> Result<(), Fault> {
        let length = word_length(rest);
        let (name, after) = rest.split_at(length);
        if name.is_empty() {
            return Err(Fault::new(at, "expected a name after `#define`"));
        }
        let (formals, body) = match after.strip_prefix('(') {
            Some(list) => {
                let Some((list, body)) = list.split_once(')') else {
                    return Err(Fault::new(
                        at,
                        "expected `)` after the names of the macro's arguments",
                    ));
                };
                let formals = list.split(',').map(|f| f.trim().to_owned()).collect();
                (Some(formals), body.trim())
            }
            None => (None, after.trim()),
        };
        let number = body.trim_matches(['(', ')', ' ']);
        let signed = number.strip_prefix('-').unwrap_or(number);
        let plain = formals.is_none()
            && signed.starts_with(|c: char| c.is_ascii_digit() || c == '.')
            && signed.parse::<f64>().is_ok();
        let known = self.macros.contains_key(name) || self.constants.contains(name);
        if known && (plain || self.constants.contains(name)) {
            return Err(Fault::new(
                at,
                format!("`{name}` is defined twice; expected it once"),
            ));
        }
        if plain {
            self.constants.insert(name.to_owned());
            let line = format!("{CONSTANT_MARK}{name} {number}");
            self.foreign.replace(&line, file, at);
        } else {
            let body = body.to_owned();
            self.macros.insert(name.to_owned(), Macro { formals, body });
        }
        Ok(())
    }

    fn include(&mut self, at: usize, name: &str) -> Result<(), Fault> {
        let Some(name) = name.strip_prefix('"').and_then(|n| n.strip_suffix('"')) else {
            return Err(Fault::new(
                at,
                "expected a file name in quotes after `#include`",
            ));
        };
        match read_included(name, self.folder, &self.chain) {
            Ok((path, source)) => {
                self.chain.push(path);
                let text = source.text.clone();
                self.file(source, &text);
                self.chain.pop();
                Ok(())
            }
            Err(message) => Err(Fault::new(at, message)),
        }
    }

    /// Text that is no directive: without comments, with macros replaced.
    fn text(&mut self, file: usize, start: usize, line: &str) -> Result<(), Fault> {
        let mut at = 0;
        // Where what is not yet written begins.
        let mut from = 0;
        while let Some(rest) = line.get(at..).filter(|rest| !rest.is_empty()) {
            if self.is_spent() {
                return Ok(());
            }
            if self.comment {
                let Some(end) = rest.find("*/") else {
                    // A comment takes the end of its line with it.
                    return Ok(());
                };
                self.comment = false;
                at += end + 2;
                from = at;
                continue;
            }
            let lone = rest.starts_with("//") && {
                let before = line.get(..at).unwrap_or("");
                let after = rest.get(2..).unwrap_or("");
                before.trim().is_empty()
                    || (before.ends_with(char::is_whitespace)
                        && after.starts_with(char::is_whitespace))
            };
            if lone {
                self.foreign
                    .copy(line.get(from..at).unwrap_or(""), file, start + from);
                self.foreign.replace("\n", file, start + at);
                return Ok(());
            }
            if rest.starts_with("/*") {
                self.foreign
                    .copy(line.get(from..at).unwrap_or(""), file, start + from);
                self.foreign.replace(" ", file, start + at);
                self.comment = true;
                at += 2;
                continue;
            }
            let length = word_length(rest);
            if length == 0 {
                at += rest.chars().next().map_or(1, char::len_utf8);
                continue;
            }
            let word = rest.get(..length).unwrap_or("");
            let replaced = self.expansion(word, rest.get(length..).unwrap_or(""), start + at, 0)?;
            if let Some((text, taken)) = replaced {
                self.foreign
                    .copy(line.get(from..at).unwrap_or(""), file, start + from);
                self.foreign.replace(&text, file, start + at);
                at += length + taken;
                from = at;
            } else {
                at += length;
            }
        }
        self.foreign
            .copy(line.get(from..).unwrap_or(""), file, start + from);
        Ok(())
    }

    /// What a word is replaced by, if it is a macro, and the bytes after it that belong to it.
    fn expansion(
        &self,
        word: &str,
        after: &str,
        at: usize,
        depth: usize,
    ) -> Result<Option<(String, usize)>, Fault> {
        let Some(found) = self.macros.get(word) else {
            return Ok(None);
        };
        if depth >= MAX_DEPTH {
            return Err(Fault::new(
                at,
                format!("the macro `{word}` goes on for ever, or nests deeper than {MAX_DEPTH}"),
            ));
        }
        let left = self.budget.get().saturating_sub(found.body.len() + 1);
        self.budget.set(left);
        if left == 0 {
            return Err(Fault::new(at, "the macros of this file take too long"));
        }
        let (body, taken) = match &found.formals {
            None => (found.body.clone(), 0),
            Some(formals) => {
                let Some((arguments, taken)) = arguments(after) else {
                    return Ok(None);
                };
                if arguments.len() != formals.len() {
                    return Err(Fault::new(
                        at,
                        format!(
                            "the macro `{word}` takes {} arguments; found {}",
                            formals.len(),
                            arguments.len()
                        ),
                    ));
                }
                let value_of = |name: &str, _: &str| -> Result<Option<(String, usize)>, Fault> {
                    let index = formals.iter().position(|f| f == name);
                    let value = index.and_then(|i| arguments.get(i));
                    Ok(value.map(|v| ((*v).to_owned(), 0)))
                };
                (replaced(&found.body, at, &value_of)?, taken)
            }
        };
        let again = |name: &str, after: &str| self.expansion(name, after, at, depth + 1);
        Ok(Some((replaced(&body, at, &again)?, taken)))
    }
}

type Replacement<'a> = &'a dyn Fn(&str, &str) -> Result<Option<(String, usize)>, Fault>;

/// A text with its words replaced.
fn replaced(text: &str, fault_at: usize, value_of: Replacement<'_>) -> Result<String, Fault> {
    let mut out = String::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        let length = word_length(rest);
        let word = rest.get(..length).unwrap_or("");
        match value_of(word, rest.get(length..).unwrap_or(""))? {
            Some((value, taken)) if length > 0 => {
                out.push_str(&value);
                at += length + taken;
            }
            _ => {
                let step = match length {
                    0 => rest.chars().next().map_or(1, char::len_utf8),
                    _ => length,
                };
                out.push_str(rest.get(..step).unwrap_or(""));
                at += step;
            }
        }
        if out.len() > MAX_FOREIGN_BYTES / 16 {
            return Err(Fault::new(fault_at, "this macro becomes too long"));
        }
    }
    Ok(out)
}

/// Arguments in parentheses, and the bytes that they take.
fn arguments(after: &str) -> Option<(Vec<&str>, usize)> {
    let open = after.len() - after.trim_start().len();
    let inner = after.trim_start().strip_prefix('(')?;
    let (mut depth, mut from, mut list) = (0_usize, 0, Vec::new());
    for (i, c) in inner.char_indices().take(MAX_ARGUMENT_BYTES) {
        match c {
            '(' => depth += 1,
            ')' if depth == 0 => {
                list.push(inner.get(from..i)?.trim());
                return Some((list, open + i + 2));
            }
            ')' => depth -= 1,
            ',' if depth == 0 => {
                list.push(inner.get(from..i)?.trim());
                from = i + 1;
            }
            _ => {}
        }
    }
    None
}

/// The directive that a line is, and its length with what stands before it.
fn directive(line: &str) -> Option<(&'static str, usize)> {
    let indent = line.len() - line.trim_start().len();
    let after = line.trim_start().strip_prefix('#')?;
    let blanks = after.len() - after.trim_start().len();
    let word = after.trim_start();
    let length = word_length(word);
    let known = [
        "define", "undef", "include", "ifdef", "ifndef", "if", "elif", "else", "endif", "line",
        "pragma", "error",
    ];
    let found = known.into_iter().find(|k| Some(*k) == word.get(..length))?;
    Some((found, indent + 1 + blanks + length))
}

fn without_comments(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("/*") {
        out.push_str(before);
        out.push(' ');
        rest = after.split_once("*/").map_or("", |(_, after)| after);
    }
    out.push_str(rest.split_once("//").map_or(rest, |(before, _)| before));
    out
}

/// Whether a line goes on the one before, which ends in `\`: where it is a statement of its own, that is a roll.
fn goes_on(line: &str) -> bool {
    !(line.trim().is_empty()
        || line.contains("-->")
        || line.contains(':')
        || line.contains("system"))
}

fn ends_in_backslash(line: &str) -> bool {
    line.ends_with('\n') && line.trim_end_matches(['\n', '\r']).ends_with('\\')
}

/// Bytes of the word that stands at the beginning.
fn word_length(text: &str) -> usize {
    if !text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
        return 0;
    }
    text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
        .unwrap_or(text.len())
}
