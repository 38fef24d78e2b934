//! The text of a grammar cut into statements, and a cursor that reads one of them.
//!
//! A statement is a line; an indented line that has no arrow and does not begin with a
//! keyword continues the line before (so does a line that begins with `]`). Statements carry
//! byte ranges into their file, so every error can point at its place.

use std::sync::OnceLock;

use super::dialect::Origin;
use super::error::{GrammarError, GrammarErrors, nearest};

/// Bytes of grammar text accepted in all, includes counted.
pub(crate) const MAX_SOURCE_BYTES: usize = 256 << 20;

/// The words that begin a statement.
pub(crate) const KEYWORDS: [&str; 26] = [
    "angle",
    "axiom",
    "bark",
    "bears",
    "colour",
    "consider",
    "const",
    "context",
    "decompose",
    "dialect",
    "ground",
    "growth",
    "ignore",
    "include",
    "interpret",
    "material",
    "module",
    "order",
    "season",
    "seed",
    "shape",
    "steps",
    "surface",
    "tropism",
    "widths",
    "wrap",
];

/// One file's text.
#[derive(Debug, Default)]
pub(crate) struct Source {
    pub(crate) name: String,
    pub(crate) text: String,
    /// Where each line begins, once somebody asked: every production notes its line.
    lines: OnceLock<Vec<usize>>,
    /// The foreign text that this one is a translation of.
    origin: Option<Box<Origin>>,
}

impl Source {
    pub(crate) fn new(name: String, text: String) -> Self {
        Self {
            name,
            text,
            lines: OnceLock::new(),
            origin: None,
        }
    }

    /// A translation, whose faults are told where the foreign text has them.
    pub(crate) fn translated(name: String, text: String, origin: Origin) -> Self {
        Self {
            origin: Some(Box::new(origin)),
            ..Self::new(name, text)
        }
    }

    /// The line of the byte `at`, from 1, and the line's first byte.
    fn line(&self, at: usize) -> [usize; 2] {
        let starts = self.lines.get_or_init(|| {
            let ends = self.text.match_indices('\n').map(|(end, _)| end + 1);
            std::iter::once(0).chain(ends).collect()
        });
        let line = starts.partition_point(|&start| start <= at);
        [line, starts.get(line.wrapping_sub(1)).copied().unwrap_or(0)]
    }

    /// An error at the byte `at`.
    pub(crate) fn error(&self, at: usize, message: String) -> GrammarError {
        match &self.origin {
            Some(origin) => origin.error(at, message),
            None => GrammarError::on_line(&self.name, &self.text, at, self.line(at), message),
        }
    }

    /// File and line of the byte `at`.
    pub(crate) fn location(&self, at: usize) -> String {
        match &self.origin {
            Some(origin) => origin.location(at),
            None => format!("{}:{}", self.name, self.line(at)[0]),
        }
    }
}

/// Which block a statement stands in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Block {
    Main,
    Decompose,
    Interpret,
}

/// One statement: its keyword (empty: a production) and the rest of its text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Statement {
    pub(crate) file: usize,
    /// The keyword, or nothing for a production.
    pub(crate) keyword: &'static str,
    /// First byte, the keyword included.
    pub(crate) start: usize,
    /// First byte after the keyword.
    pub(crate) body: usize,
    pub(crate) end: usize,
    pub(crate) block: Block,
}

/// Blanks, and the mark that some editors put before a text, which is left inside where texts were joined.
pub(super) fn is_blank(c: char) -> bool {
    c.is_whitespace() || c == '\u{feff}'
}

/// Where the keyword at the beginning of `line` ends, if it begins with one.
pub(super) fn keyword_of(line: &str) -> Option<&'static str> {
    let length = line
        .find(|c: char| !c.is_ascii_lowercase())
        .unwrap_or(line.len());
    let (word, rest) = line.split_at(length);
    let ends = rest
        .chars()
        .next()
        .is_none_or(|c| is_blank(c) || matches!(c, '{' | '"' | '#'));
    if ends {
        KEYWORDS.iter().copied().find(|k| *k == word)
    } else {
        None
    }
}

/// The block that a line seems to open whose first word is no keyword.
fn misspelt_block(line: &str) -> Option<Block> {
    let word = line.strip_suffix('{')?.split_whitespace().next()?;
    if line.contains("->") || !word.bytes().all(|b| b.is_ascii_alphabetic()) {
        return None;
    }
    match nearest(word, ["decompose", "interpret"].into_iter())? {
        "decompose" => Some(Block::Decompose),
        _ => Some(Block::Interpret),
    }
}

/// The line without its comment.
pub(super) fn code_of(line: &str) -> &str {
    line.split('#').next().unwrap_or("")
}

/// Cuts a file into statements and tells them by keyword and block.
pub(crate) fn statements(
    file: usize,
    source: &Source,
    errors: &mut GrammarErrors,
) -> Vec<Statement> {
    let mut found: Vec<Statement> = Vec::new();
    let mut block = Block::Main;
    let mut block_at = 0;
    let mut at = 0;
    for line in source.text.split_inclusive('\n') {
        let line_start = at;
        at += line.len();
        let code = code_of(line);
        let trimmed = code.trim_matches(is_blank);
        if trimmed.is_empty() {
            continue;
        }
        let indent = code.len() - code.trim_start_matches(is_blank).len();
        let start = line_start + indent;
        let end = start + trimmed.len();
        if block != Block::Main && trimmed == "}" {
            block = Block::Main;
            continue;
        }
        let keyword = keyword_of(trimmed);
        let indented = code.starts_with(char::is_whitespace);
        let continues =
            (indented || trimmed.starts_with(']')) && keyword.is_none() && !trimmed.contains("->");
        if continues
            && let Some(last) = found.last_mut()
            && last.block == block
        {
            last.end = end;
            continue;
        }
        let keyword = keyword.unwrap_or("");
        let stands_in = block;
        if keyword.is_empty() && block == Block::Main {
            // A misspelt block is a fault, but what stands in it is none.
            if let Some(meant) = misspelt_block(trimmed) {
                block = meant;
                block_at = start;
            }
        }
        found.push(Statement {
            file,
            keyword,
            start,
            body: start + keyword.len(),
            end,
            block: stands_in,
        });
        if matches!(keyword, "decompose" | "interpret") {
            // One inside another is told when the statements are read.
            if block == Block::Main && trimmed.ends_with('{') {
                block = if keyword == "decompose" {
                    Block::Decompose
                } else {
                    Block::Interpret
                };
                block_at = start;
            }
        }
    }
    if block != Block::Main {
        errors.push(source.error(
            block_at,
            "this block is not closed; expected `}` on its own line".into(),
        ));
    }
    found
}

/// Reads a stretch of one file, character by character.
#[derive(Clone, Debug)]
pub(crate) struct Cursor<'a> {
    source: &'a Source,
    pos: usize,
    end: usize,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(source: &'a Source, start: usize, end: usize) -> Self {
        Self {
            source,
            pos: start,
            end,
        }
    }

    pub(crate) fn pos(&self) -> usize {
        self.pos
    }

    /// Whether the letter at `at` stands in a word that begins before it.
    pub(crate) fn goes_on_a_word(&self, at: usize) -> bool {
        let before = self.source.text.get(..at).unwrap_or("");
        before
            .chars()
            .next_back()
            .is_some_and(char::is_alphanumeric)
    }

    /// The text not yet read.
    pub(crate) fn rest(&self) -> &'a str {
        self.source.text.get(self.pos..self.end).unwrap_or("")
    }

    pub(crate) fn between(&self, start: usize, end: usize) -> &'a str {
        self.source.text.get(start..end).unwrap_or("")
    }

    pub(crate) fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    pub(crate) fn bump(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.pos += c.len_utf8();
        Some(c)
    }

    pub(crate) fn advance(&mut self, bytes: usize) {
        self.pos = (self.pos + bytes).min(self.end);
    }

    /// Skips blanks, line ends and comments.
    pub(crate) fn skip_blank(&mut self) {
        while let Some(c) = self.peek() {
            if c == '#' {
                let rest = self.rest();
                self.advance(rest.find('\n').unwrap_or(rest.len()));
            } else if is_blank(c) {
                self.bump();
            } else {
                break;
            }
        }
    }

    /// Skips blanks and tells whether nothing is left.
    pub(crate) fn at_end(&mut self) -> bool {
        self.skip_blank();
        self.pos >= self.end
    }

    /// Skips blanks, then `token` if it stands there.
    pub(crate) fn take(&mut self, token: &str) -> bool {
        self.skip_blank();
        let here = self.rest().starts_with(token);
        if here {
            self.advance(token.len());
        }
        here
    }

    /// Skips blanks, then reads an identifier (letters, digits, `_`, subscripts; not beginning with a digit).
    pub(crate) fn identifier(&mut self) -> Option<&'a str> {
        self.skip_blank();
        let rest = self.rest();
        let first = rest.chars().next()?;
        if !(first.is_alphabetic() || first == '_') {
            return None;
        }
        let length = rest
            .find(|c: char| !(c.is_alphanumeric() || c == '_'))
            .unwrap_or(rest.len());
        self.advance(length);
        rest.get(..length)
    }

    /// Skips blanks and tells whether a number stands here.
    pub(crate) fn at_number(&mut self) -> bool {
        self.skip_blank();
        let number = |c: char| c.is_ascii_digit() || c == '.';
        self.peek().is_some_and(number)
    }

    /// What stands here, for a message.
    pub(crate) fn found(&mut self) -> String {
        self.skip_blank();
        let rest = self.rest();
        let Some(first) = rest.chars().next() else {
            return "the end of the line".into();
        };
        if first.is_alphanumeric() || first == '_' {
            let word: String = rest
                .chars()
                .take_while(|c| c.is_alphanumeric() || matches!(c, '_' | '.'))
                .take(40)
                .collect();
            return format!("`{word}`");
        }
        if first.is_control() {
            return format!("the control character U+{:04X}", u32::from(first));
        }
        format!("`{first}`")
    }

    /// File and line of the byte `at`.
    pub(crate) fn location(&self, at: usize) -> String {
        self.source.location(at)
    }

    /// An error at the byte `at`.
    pub(crate) fn error_at(&self, at: usize, message: String) -> GrammarError {
        self.source.error(at, message)
    }

    /// An error here: what was found and what was expected.
    pub(crate) fn expected(&mut self, what: &str) -> GrammarError {
        let found = self.found();
        self.error_at(self.pos, format!("found {found}; expected {what}"))
    }

    /// Takes `token` or says that it is missing.
    pub(crate) fn expect(&mut self, token: &str) -> Result<(), GrammarError> {
        if self.take(token) {
            Ok(())
        } else {
            Err(self.expected(&format!("`{token}`")))
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests may fail by panic")]
    use super::*;

    #[test]
    fn statements_continue_over_indented_lines() {
        let source = Source::new("t".into(), "# c\naxiom A # x\n  B\nA -> F\n   [A]\ndecompose {\n  A -> B\n}\nshape A = [\n (0 1 0)\n]\n".into());
        let mut errors = GrammarErrors::default();
        let found = statements(0, &source, &mut errors);
        let shown: Vec<(&str, &str, Block)> = found
            .iter()
            .map(|s| (s.keyword, source.text.get(s.body..s.end).unwrap(), s.block))
            .collect();
        assert_eq!(
            shown,
            [
                ("axiom", " A # x\n  B", Block::Main),
                ("", "A -> F\n   [A]", Block::Main),
                ("decompose", " {", Block::Main),
                ("", "A -> B", Block::Decompose),
                ("shape", " A = [\n (0 1 0)\n]", Block::Main),
            ],
            "statements"
        );
        assert!(errors.errors.is_empty(), "no errors");
    }
}
