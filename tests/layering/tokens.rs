//! Source text as tokens: what is said, without comments, strings and characters.

/// A piece of source text that matters here, and the line it stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Token<'a> {
    pub(crate) text: &'a str,
    pub(crate) line: usize,
}

/// Splits source text into identifiers, `::` and single signs; comments, strings, characters and
/// lifetimes are left out.
pub(crate) fn tokens(source: &str) -> Vec<Token<'_>> {
    let bytes = source.as_bytes();
    let mut found = Vec::new();
    let mut line = 1;
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        let rest = &source[at..];
        if rest.starts_with("//") {
            at += rest.find('\n').unwrap_or(rest.len());
        } else if rest.starts_with("/*") {
            at += block_comment(rest);
        } else if let Some(length) = string(rest) {
            at += length;
        } else if bytes[at].is_ascii_alphabetic() || bytes[at] == b'_' {
            at += rest
                .find(|c: char| !c.is_alphanumeric() && c != '_')
                .unwrap_or(rest.len());
            found.push(Token {
                text: &source[start..at],
                line,
            });
        } else if rest.starts_with("::") {
            at += 2;
            found.push(Token { text: "::", line });
        } else {
            at += rest.chars().next().map_or(1, char::len_utf8);
            let sign = &source[start..at];
            if !sign.trim().is_empty() {
                found.push(Token { text: sign, line });
            }
        }
        line += source[start..at].matches('\n').count();
    }
    found
}

/// Length of the block comment that `rest` begins with; comments nest.
fn block_comment(rest: &str) -> usize {
    let mut depth = 0_usize;
    let mut at = 0;
    while at < rest.len() {
        if rest[at..].starts_with("/*") {
            depth += 1;
            at += 2;
        } else if rest[at..].starts_with("*/") {
            depth -= 1;
            at += 2;
            if depth == 0 {
                return at;
            }
        } else {
            at += rest[at..].chars().next().map_or(1, char::len_utf8);
        }
    }
    rest.len()
}

/// Length of the string, raw string, byte string, character or lifetime that `rest` begins with.
fn string(rest: &str) -> Option<usize> {
    let prefix = ["br", "cr", "b", "c", "r"].into_iter().find(|prefix| {
        rest.strip_prefix(prefix).is_some_and(|after| {
            after.starts_with('"') || (prefix.ends_with('r') && after.starts_with("#"))
        })
    });
    let raw = prefix.is_some_and(|prefix| prefix.ends_with('r'));
    let body = &rest[prefix.map_or(0, str::len)..];
    if raw {
        let hashes = body.len() - body.trim_start_matches('#').len();
        // `r#name` is an identifier, not a string.
        body[hashes..].strip_prefix('"')?;
        let close = format!("\"{}", "#".repeat(hashes));
        let inner = &body[hashes + 1..];
        let length = inner
            .find(&close)
            .map_or(inner.len(), |end| end + close.len());
        return Some(rest.len() - inner.len() + length);
    }
    let quote = body.chars().next()?;
    if quote == '\'' {
        let after = &body[1..];
        let mut signs = after.char_indices();
        let (_, first) = signs.next()?;
        let lifetime = first != '\\' && signs.next().is_none_or(|(_, second)| second != '\'');
        if lifetime {
            let name = after.find(|c: char| !c.is_alphanumeric() && c != '_');
            return Some(1 + name.unwrap_or(after.len()));
        }
    } else if quote != '"' {
        return None;
    }
    let mut escaped = false;
    for (at, sign) in body.char_indices().skip(1) {
        if escaped {
            escaped = false;
        } else if sign == '\\' {
            escaped = true;
        } else if sign == quote {
            return Some(rest.len() - body.len() + at + 1);
        }
    }
    Some(rest.len())
}
