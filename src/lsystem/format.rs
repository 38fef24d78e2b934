//! The canonical layout of a grammar's text: `ramus fmt`.
//!
//! Line by line, since lines and their indentation mean something in this language: every line stays a line, with its comment;
//! its statement's tokens are spaced anew, continuations are indented alike, and neighbouring productions have
//! their conditions and arrows below each other where that costs few blanks. What comes out is read again and
//! compared, so that no layout ever changes what a grammar means.

mod tokens;

use std::collections::BTreeMap;
use std::ops::Range;

use thiserror::Error;

use super::error::GrammarErrors;
use super::grammar::Grammar;
use super::parse;
use super::source::{Block, Cursor, Source, Statement, code_of, is_blank, keyword_of, statements};
use tokens::{Part, Token};

/// Blanks before a statement in a block.
const BLOCK_INDENT: usize = 2;
/// Further blanks before a line that continues a statement.
const CONTINUED_INDENT: usize = 4;
/// Blanks that a production may get for the sake of the next one, and for all its neighbours: with more, the eye loses
/// the line.
const MOST_STEP: usize = 6;
const MOST_PADDING: usize = 12;
/// Blanks that may stand before a comment for the sake of its neighbours.
const MOST_BEFORE_COMMENT: usize = 20;

/// Why a text could not be laid out.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum FormatError {
    /// It is no grammar.
    #[error(transparent)]
    Grammar(#[from] GrammarErrors),
    /// The new text would mean another thing: a fault of the formatter.
    #[error(
        "{0} would mean something else when laid out, a fault of the formatter: it is left as it is"
    )]
    Meaning(String),
}

/// Lays a grammar out in the canonical way. `file` names the text in messages, and its folder is the one of what it includes,
/// as for [`Grammar::parse`]; a part that is included elsewhere needs no axiom.
///
/// The result means the same, and is its own canonical layout.
///
/// # Errors
/// The faults of a text that is no grammar.
pub fn format(text: &str, file: &str) -> Result<String, FormatError> {
    let (grammar, source) = parse::with_text(text, file)?;
    let laid_out = Layout::new(&grammar, &source).text();
    let again = parse::with_text(&laid_out, file).map(|(again, _)| again.meaning());
    match again.as_ref() == Ok(&grammar.meaning()) {
        true => Ok(laid_out),
        false => Err(FormatError::Meaning(file.to_owned())),
    }
}

/// One line of the new text.
#[derive(Debug, Default)]
struct Line {
    indent: usize,
    /// A production's modules before the arrow,
    head: String,
    /// its condition or weight, from `:` on,
    condition: String,
    /// and what follows; all of another line.
    rest: String,
    /// From `#` on.
    comment: String,
    /// Whether it begins a production.
    production: bool,
    /// Whether it goes on a production.
    continues: bool,
    /// Columns of head and condition, once it is known what the neighbours need.
    columns: [usize; 2],
}

/// Characters of a text, each taken as one column.
fn width(text: &str) -> usize {
    text.chars().count()
}

impl Line {
    fn is_blank(&self) -> bool {
        self.head.is_empty() && self.rest.is_empty() && self.comment.is_empty()
    }

    /// The line without its comment.
    fn code(&self) -> String {
        let mut code = " ".repeat(self.indent);
        if self.production {
            let padded = |text: &str, columns: usize| {
                let missing = columns.saturating_sub(width(text));
                format!("{text}{}", " ".repeat(missing))
            };
            let head = match self.condition.is_empty() {
                true => self.head.clone(),
                false => format!("{} {}", padded(&self.head, self.columns[0]), self.condition),
            };
            code.push_str(&padded(&head, self.columns[1]));
            code.push(' ');
        }
        code.push_str(&self.rest);
        code
    }
}

struct Layout<'a> {
    grammar: &'a Grammar,
    source: &'a Source,
    /// First byte of each line of the source, and its end.
    starts: Vec<usize>,
    /// Lines of the source that belong to statements, with what stands on them.
    lines: BTreeMap<usize, Line>,
}

impl<'a> Layout<'a> {
    fn new(grammar: &'a Grammar, source: &'a Source) -> Self {
        let ends = source.text.match_indices('\n').map(|(end, _)| end + 1);
        let mut layout = Self {
            grammar,
            source,
            starts: std::iter::once(0).chain(ends).collect(),
            lines: BTreeMap::new(),
        };
        for statement in statements(0, source, &mut GrammarErrors::default()) {
            layout.statement(&statement);
        }
        layout
    }

    /// The line, from 0, of the byte `at`.
    fn line_of(&self, at: usize) -> usize {
        self.starts.partition_point(|&start| start <= at) - 1
    }

    fn line_range(&self, line: usize) -> Range<usize> {
        let end = self.starts.get(line + 1).copied();
        self.starts.get(line).copied().unwrap_or(0)..end.unwrap_or(self.source.text.len())
    }

    fn statement(&mut self, statement: &Statement) {
        let cursor = Cursor::new(self.source, statement.body, statement.end);
        let first = self.line_of(statement.start);
        let last = self.line_of(statement.end.saturating_sub(1));
        let Some(tokens) = tokens::tokens(&self.grammar.names, cursor, statement) else {
            return self.verbatim(first..=last);
        };
        let indent = match statement.block {
            Block::Main => 0,
            _ => BLOCK_INDENT,
        };
        let mut rest = tokens.as_slice();
        while let Some(token) = rest.first() {
            let number = self.line_of(token.at);
            let end = self.line_range(number).end;
            let (on_line, after) = rest.split_at(rest.partition_point(|token| token.at < end));
            rest = after;
            let mut line = laid_out(on_line, statement.keyword);
            line.continues = number > first && statement.keyword.is_empty();
            line.indent = indent;
            // `]` alone continues a statement without being indented.
            if number > first && !line.rest.starts_with(']') {
                line.indent += CONTINUED_INDENT;
            }
            self.lines.insert(number, line);
        }
    }

    /// Lines whose tokens are not understood stay as they are, but for blanks at their ends.
    fn verbatim(&mut self, lines: std::ops::RangeInclusive<usize>) {
        for number in lines {
            let text = self.source.text.get(self.line_range(number)).unwrap_or("");
            let line = Line {
                rest: code_of(text).trim_end().to_owned(),
                ..Line::default()
            };
            self.lines.insert(number, line);
        }
    }

    fn text(mut self) -> String {
        let mut lines: Vec<Line> = Vec::with_capacity(self.starts.len());
        for number in 0..self.starts.len() {
            let text = self.source.text.get(self.line_range(number)).unwrap_or("");
            let code = code_of(text);
            let mut line = self.lines.remove(&number).unwrap_or_else(|| Line {
                // What no statement claims is the end of a block, or nothing.
                rest: if code.trim_matches(is_blank) == "}" {
                    "}".into()
                } else {
                    String::new()
                },
                ..Line::default()
            });
            line.comment = text.get(code.len()..).unwrap_or("").trim_end().to_owned();
            let blank = line.is_blank();
            if !blank || lines.last().is_some_and(|last| !last.is_blank()) {
                lines.push(line);
            }
        }
        while lines.last().is_some_and(Line::is_blank) {
            lines.pop();
        }
        indent_comments(&mut lines);
        align(&mut lines);
        written(&lines)
    }
}

/// A line of one statement from its tokens.
fn laid_out(tokens: &[Token<'_>], keyword: &str) -> Line {
    let arrow = tokens.iter().position(|token| token.part == Part::Arrow);
    let colon = tokens.iter().position(|token| token.part == Part::Colon);
    let joined = |tokens: &[Token<'_>]| {
        let mut text = String::new();
        for token in tokens {
            if token.blank && !text.is_empty() {
                text.push(' ');
            }
            text.push_str(token.text);
        }
        text
    };
    let Some(arrow) = arrow else {
        return Line {
            rest: unlike_keywords(joined(tokens), keyword),
            ..Line::default()
        };
    };
    let whole = joined(tokens);
    if keyword_of(&whole).is_some() {
        return Line {
            rest: unlike_keywords(whole, keyword),
            ..Line::default()
        };
    }
    let (before, after) = tokens.split_at(arrow);
    let (head, condition) = before.split_at(colon.unwrap_or(arrow).min(arrow));
    Line {
        head: joined(head),
        condition: joined(condition),
        rest: joined(after),
        production: true,
        ..Line::default()
    }
}

/// A line that would begin with a keyword by its new blanks, as `seed*2` would, without the blank that does it.
fn unlike_keywords(line: String, keyword: &str) -> String {
    match keyword_of(&line) {
        Some(word) if word != keyword => {
            let (word, rest) = line.split_at(word.len());
            format!("{word}{}", rest.trim_start())
        }
        _ => line,
    }
}

/// Lines of comments stand as far in as the line of code that follows.
fn indent_comments(lines: &mut [Line]) {
    let mut indent = 0;
    for line in lines.iter_mut().rev() {
        let has_code = !(line.head.is_empty() && line.rest.is_empty());
        if has_code {
            // What stands before the end of a block stands in it.
            indent = if line.rest == "}" {
                BLOCK_INDENT
            } else {
                line.indent
            };
        } else if !line.comment.is_empty() {
            line.indent = indent;
        }
    }
}

/// Puts the conditions and arrows of neighbouring productions below each other, and the comments of neighbouring lines.
fn align(lines: &mut [Line]) {
    for group in lines.chunk_by_mut(|a, b| {
        (a.production || a.continues)
            && (b.production || b.continues)
            && a.indent_of() == b.indent_of()
    }) {
        column(group, 0, |line| {
            (line.production && !line.condition.is_empty()).then(|| width(&line.head))
        });
        column(group, 1, |line| {
            line.production.then(|| match line.condition.is_empty() {
                true => width(&line.head),
                false => line.columns[0].max(width(&line.head)) + 1 + width(&line.condition),
            })
        });
    }
}

impl Line {
    /// How far in its statement stands.
    fn indent_of(&self) -> usize {
        self.indent
            - if self.continues && self.indent >= CONTINUED_INDENT {
                CONTINUED_INDENT
            } else {
                0
            }
    }
}

/// Gives the lines of a group the same column, from one to the next as long as neither gets too many blanks for it.
fn column(group: &mut [Line], column: usize, needed: impl Fn(&Line) -> Option<usize>) {
    let needed: Vec<(usize, usize)> = (0..)
        .zip(group.iter().map(needed))
        .filter_map(|(at, width)| Some((at, width?)))
        .collect();
    for run in needed.chunk_by(|a, b| a.1.abs_diff(b.1) <= MOST_STEP) {
        let widths = || run.iter().map(|(_, width)| *width);
        let (Some(least), Some(most)) = (widths().min(), widths().max()) else {
            continue;
        };
        if most - least > MOST_PADDING {
            continue;
        }
        for (at, _) in run {
            if let Some(place) = group
                .get_mut(*at)
                .and_then(|line| line.columns.get_mut(column))
            {
                *place = most;
            }
        }
    }
}

/// The text of all lines.
fn written(lines: &[Line]) -> String {
    let mut text = String::new();
    let codes: Vec<String> = lines.iter().map(Line::code).collect();
    let mut all: Vec<(&str, &str)> = Vec::new();
    all.extend(
        codes
            .iter()
            .map(String::as_str)
            .zip(lines.iter().map(|line| line.comment.as_str())),
    );
    // Comments beside neighbouring lines of code stand below each other.
    let beside = |(code, comment): &(&str, &str)| !comment.is_empty() && !code.trim().is_empty();
    for group in all.chunk_by(|a, b| beside(a) && beside(b)) {
        let widths = || group.iter().map(|(code, _)| width(code));
        let most = widths().max().unwrap_or(0);
        let near = most - widths().min().unwrap_or(0) <= MOST_BEFORE_COMMENT;
        for (code, comment) in group {
            text.push_str(code);
            if !comment.is_empty() && !code.trim().is_empty() {
                let padding = if near { most - width(code) } else { 0 };
                text.push_str(&" ".repeat(padding + 2));
            }
            text.push_str(comment);
            text.push('\n');
        }
    }
    text
}

#[cfg(test)]
mod tests;
