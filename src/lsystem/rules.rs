//! Reads one production: `left < predecessor > right : condition -> successor`.

use super::code::Expression;
use super::error::{GrammarError, nearest};
use super::expression::{self, Scope};
use super::grammar::{Looks, Pattern, Rule};
use super::parse::{Brackets, Parser, end, parameters};
use super::source::Cursor;

/// Parameters that one production may bind.
const MAX_SLOTS: usize = 256;
/// Branches within branches in a right context.
const MAX_PATTERN_DEPTH: usize = 32;
/// Characters of a production kept for messages.
const SHOWN_CHARS: usize = 80;

/// A module of a production's head as written.
struct Head {
    name: String,
    at: usize,
    /// Its parameters, each with its place.
    formals: Vec<(String, usize)>,
}

/// Reads a production; `inner` in a `decompose` or `interpret` block, where contexts mean nothing.
pub(crate) fn production(
    parser: &mut Parser,
    cursor: &mut Cursor<'_>,
    inner: bool,
) -> Result<Rule, GrammarError> {
    cursor.skip_blank();
    let start = cursor.pos();
    let text: String = cursor
        .rest()
        .chars()
        .take(SHOWN_CHARS)
        .map(|c| if c.is_whitespace() { ' ' } else { c })
        .collect();
    let mut left = Vec::new();
    let mut heads = modules(parser, cursor)?;
    if cursor.take("<") {
        left = heads;
        heads = modules(parser, cursor)?;
        if left.is_empty() {
            return Err(cursor.error_at(
                start,
                "the left context is empty; expected a module before `<`".into(),
            ));
        }
    }
    let mut right = Vec::new();
    cursor.skip_blank();
    let right_at = cursor.pos();
    if cursor.take(">") {
        right = modules(parser, cursor)?;
        if right.is_empty() {
            return Err(cursor.expected("a module of the right context"));
        }
    }
    if inner && !(left.is_empty() && right.is_empty()) {
        let at = if left.is_empty() { right_at } else { start };
        return Err(cursor.error_at(
            at,
            "found a context; productions in `decompose` and `interpret` have none".into(),
        ));
    }
    let mut heads = heads.into_iter();
    let (Some(predecessor), second) = (heads.next(), heads.next()) else {
        return Err(cursor.expected("the module that is replaced, before `->`"));
    };
    if let Some(second) = second {
        if let Some(label) = label(cursor.between(start, cursor.pos())) {
            let message = format!(
                "found the label `{label}:`; productions have none, expected the production alone"
            );
            return Err(cursor.error_at(start, message));
        }
        let message = format!(
            "found `{}`; expected one predecessor only (contexts stand before `<` and after `>`)",
            second.name
        );
        return Err(cursor.error_at(second.at, message));
    }
    if matches!(predecessor.name.as_str(), "[" | "]" | "%") {
        return Err(cursor.error_at(
            predecessor.at,
            format!("`{}` cannot be replaced by a production", predecessor.name),
        ));
    }

    // Slots: predecessor, left context, right context.
    let mut slots: Vec<String> = Vec::new();
    let symbol = bind(parser, cursor, &predecessor, &mut slots)?.0;
    let mut left_pattern = Vec::new();
    for head in &left {
        if matches!(head.name.as_str(), "[" | "]") {
            let message =
                "a left context is the path to the root and has no brackets; expected modules only"
                    .into();
            return Err(cursor.error_at(head.at, message));
        }
        let (symbol, slot) = bind_seen(parser, cursor, head, &mut slots)?;
        left_pattern.push(Pattern::Module { symbol, slot });
    }
    left_pattern.reverse();
    let right_pattern = right_context(parser, cursor, &right, &mut slots)?;
    let context_length = left_pattern.len()
        + right_pattern
            .iter()
            .filter(|p| matches!(p, Pattern::Module { .. }))
            .count();

    let (condition, weight) = if cursor.take(":") {
        conditions(parser, cursor, &slots)?
    } else {
        (None, None)
    };
    if !(cursor.take("-->") || cursor.take("->")) {
        let mut ahead = cursor.clone();
        let instead = match ahead.identifier() {
            Some("and") => "`->` or `&&`",
            Some("or") => "`->` or `||`",
            _ => "`->`",
        };
        return Err(cursor.expected(instead));
    }
    let location = cursor.location(start);
    let into_branches = right_pattern
        .iter()
        .any(|item| matches!(item, Pattern::Open { .. }));
    let looks = Looks {
        left: !left_pattern.is_empty(),
        right: !right_pattern.is_empty() && !into_branches,
        into_branches,
        binds: slots.len() > predecessor.formals.len(),
    };
    let mut rule = Rule {
        text: text.trim_end().to_owned(),
        location,
        predecessor: symbol,
        left: left_pattern,
        right: right_pattern,
        looks,
        context_length,
        slots: slots.len(),
        condition,
        weight,
        successor: Vec::new(),
        arguments: Vec::new(),
        heirs: Vec::new(),
    };
    successor(parser, cursor, &slots, &mut rule)?;
    Ok(rule)
}

/// A production's label as other programs write it: `p1` of `p1: A -> B`.
fn label(head: &str) -> Option<&str> {
    let head = head.trim();
    let number = head.strip_prefix(['p', 'P'])?;
    let is_number = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
    is_number.then_some(head)
}

/// Modules with parameter names, up to `<`, `>`, `:` or the arrow.
fn modules(parser: &mut Parser, cursor: &mut Cursor<'_>) -> Result<Vec<Head>, GrammarError> {
    let mut heads = Vec::new();
    loop {
        cursor.skip_blank();
        let rest = cursor.rest();
        // `- -> +` and `-->+`: where nothing stands before, the first `-` of a longer arrow is the module.
        let arrow = if heads.is_empty() {
            rest.starts_with("->")
        } else {
            rest.starts_with("->") || rest.starts_with("-->")
        };
        if arrow || rest.is_empty() || rest.starts_with(['<', '>', ':']) {
            return Ok(heads);
        }
        let at = cursor.pos();
        let name = parser.read_name(cursor)?.to_owned();
        let mut formals = Vec::new();
        let brackets = matches!(name.as_str(), "[" | "]");
        parameters(cursor, |c| {
            if brackets {
                return Err(c.error_at(at, format!("`{name}` takes no parameters")));
            }
            c.skip_blank();
            let at = c.pos();
            let formal = c.identifier().ok_or_else(|| {
                c.expected("the name of a parameter; a value is tested in the condition, as in `A(x) : x == 0 -> …`")
            })?;
            formals.push((formal.to_owned(), at));
            Ok(())
        })?;
        heads.push(Head { name, at, formals });
    }
}

/// Gives the parameters of a module their slots.
fn bind(
    parser: &mut Parser,
    cursor: &Cursor<'_>,
    head: &Head,
    slots: &mut Vec<String>,
) -> Result<(u16, u16), GrammarError> {
    let slot = u16::try_from(slots.len()).unwrap_or(u16::MAX);
    for (formal, at) in &head.formals {
        if slots.contains(formal) {
            return Err(cursor.error_at(*at, format!("the parameter `{formal}` is bound twice in this production; give one another name")));
        }
        slots.push(formal.clone());
    }
    if slots.len() > MAX_SLOTS {
        return Err(cursor.error_at(
            head.at,
            format!("this production binds more than {MAX_SLOTS} parameters"),
        ));
    }
    let symbol = parser.symbol(cursor, &head.name, head.at, head.formals.len())?;
    Ok((symbol, slot))
}

/// The same for a module of a context, which must be one that contexts see.
fn bind_seen(
    parser: &mut Parser,
    cursor: &Cursor<'_>,
    head: &Head,
    slots: &mut Vec<String>,
) -> Result<(u16, u16), GrammarError> {
    if let Some(message) = parser.unseen(&head.name) {
        parser.errors.push(cursor.error_at(head.at, message));
    }
    bind(parser, cursor, head, slots)
}

fn right_context(
    parser: &mut Parser,
    cursor: &Cursor<'_>,
    right: &[Head],
    slots: &mut Vec<String>,
) -> Result<Vec<Pattern>, GrammarError> {
    let mut pattern: Vec<Pattern> = Vec::with_capacity(right.len());
    let mut open: Vec<(usize, usize)> = Vec::new();
    for head in right {
        match head.name.as_str() {
            "[" | "]" if parser.literal => {
                let message =
                    "with `context literal` a bracket ends the context; expected modules only"
                        .into();
                return Err(cursor.error_at(head.at, message));
            }
            "[" => {
                open.push((pattern.len(), head.at));
                if open.len() > MAX_PATTERN_DEPTH {
                    return Err(cursor.error_at(
                        head.at,
                        format!("branches nest deeper than {MAX_PATTERN_DEPTH} in this context"),
                    ));
                }
                pattern.push(Pattern::Open { inside: 0 });
            }
            "]" => {
                let Some((start, _)) = open.pop() else {
                    return Err(cursor.error_at(
                        head.at,
                        "this `]` closes nothing; expected a `[` before it".into(),
                    ));
                };
                let end = pattern.len();
                if let Some(Pattern::Open { inside }) = pattern.get_mut(start) {
                    *inside = end - start - 1;
                }
                pattern.push(Pattern::Close);
            }
            _ => {
                let (symbol, slot) = bind_seen(parser, cursor, head, slots)?;
                pattern.push(Pattern::Module { symbol, slot });
            }
        }
    }
    match open.last() {
        Some((_, at)) => Err(cursor.error_at(*at, "this `[` is not closed; expected a `]`".into())),
        None => Ok(pattern),
    }
}

/// `condition`, `weight w` or `condition, weight w`.
fn conditions(
    parser: &mut Parser,
    cursor: &mut Cursor<'_>,
    slots: &[String],
) -> Result<(Option<Expression>, Option<Expression>), GrammarError> {
    let scope = Scope {
        parameters: slots,
        constants: &parser.constants,
        draws: false,
        names: expression::IN_PRODUCTIONS,
    };
    let mut condition = None;
    if !takes_weight(cursor) {
        if cursor.take("*") {
            return Ok((None, None)); // `: *` is ABOP's condition that always holds
        }
        cursor.skip_blank();
        let start = cursor.pos();
        misspelt_weight(cursor, &scope)?;
        condition = Some(expression::parse(cursor, &scope, &mut parser.errors)?);
        let written = cursor.between(start, cursor.pos()).trim();
        if written
            .parse::<f64>()
            .is_ok_and(|number| number != 0.0 && (number - 1.0).abs() > 0.0)
        {
            let message = format!(
                "found the number `{written}` as a condition, which always holds; a weight is written `weight {written}`"
            );
            return Err(cursor.error_at(start, message));
        }
        if !cursor.take(",") {
            return Ok((condition, None));
        }
        if !takes_weight(cursor) {
            return Err(cursor.expected("`weight`"));
        }
    }
    let weight = expression::parse(cursor, &scope, &mut parser.errors)?;
    Ok((condition, Some(weight)))
}

/// A word like `weight` that nothing else is named by.
fn misspelt_weight(cursor: &Cursor<'_>, scope: &Scope<'_>) -> Result<(), GrammarError> {
    let mut ahead = cursor.clone();
    let Some(word) = ahead.identifier() else {
        return Ok(());
    };
    let known = scope.constants.contains_key(word) || scope.parameters.iter().any(|p| p == word);
    let number = ahead.at_number();
    match nearest(word, std::iter::once("weight")) {
        Some(meant) if !known && number => Err(cursor.error_at(
            cursor.pos(),
            format!(
                "found `{word}`; expected a condition or `{meant}`, which is the nearest known word"
            ),
        )),
        _ => Ok(()),
    }
}

fn takes_weight(cursor: &mut Cursor<'_>) -> bool {
    let mut ahead = cursor.clone();
    let here = ahead.identifier() == Some("weight");
    if here {
        *cursor = ahead;
    }
    here
}

fn successor(
    parser: &mut Parser,
    cursor: &mut Cursor<'_>,
    slots: &[String],
    rule: &mut Rule,
) -> Result<(), GrammarError> {
    if cursor.take("*") {
        return end(cursor);
    }
    if cursor.at_end() {
        return Err(cursor.expected("the successor, or `*` for none"));
    }
    let mut brackets = Brackets::default();
    while !cursor.at_end() {
        let at = cursor.pos();
        let name = parser.read_name(cursor)?;
        let first = rule.arguments.len();
        let scope = Scope {
            parameters: slots,
            constants: &parser.constants,
            draws: true,
            names: expression::IN_PRODUCTIONS,
        };
        let errors = &mut parser.errors;
        let arity = parameters(cursor, |c| {
            rule.arguments.push(expression::parse(c, &scope, errors)?);
            Ok(())
        })?;
        brackets.module(cursor, name, at, arity)?;
        let symbol = parser.symbol(cursor, name, at, arity)?;
        if symbol == rule.predecessor {
            rule.heirs.push((rule.successor.len(), first));
        }
        rule.successor.push(symbol);
    }
    brackets.end(cursor)
}
