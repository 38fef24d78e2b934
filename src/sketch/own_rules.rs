//! Productions that a person wrote in the place of the generated ones.
//!
//! The sketch's grammar stays the one that grows and the one that is read: a rule of one's own stands in its text where the
//! generated one stood, named by its left side, and further lines (constants, productions) before the axiom. A rule
//! whose left side is not generated any more, because its line was deleted, goes with it; one that makes the
//! grammar unreadable is refused with the grammar's own message. So sketch and grammar cannot disagree.

use std::collections::BTreeMap;

use super::{Sketch, SketchError};
use crate::lsystem::Grammar;

/// Texts by the left side that they stand for; `""` names the further lines.
pub type OwnRules = BTreeMap<String, String>;

/// Under this name are the further lines.
pub const FURTHER: &str = "";

/// Most rules of one's own, and the longest text of one, bytes.
pub const OWN_RULES: usize = 256;
/// Longest text of a rule, bytes.
pub const RULE_BYTES: usize = 4096;

/// What separates the sides of a production.
const ARROW: &str = " -> ";

/// A production as it is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Production {
    /// Its left side, which names it.
    pub of: String,
    /// What the sketch makes of it.
    pub generated: String,
    /// What a person wrote in its place.
    pub own: Option<String>,
}

/// The left side of a line of the grammar that is a production.
fn left_side(line: &str) -> Option<&str> {
    let line = line.trim();
    let (left, _) = line.split_once(ARROW)?;
    (!line.starts_with('#')).then(|| left.trim())
}

/// The generated text with a person's rules in it.
pub(super) fn with_own(generated: String, own: &OwnRules) -> String {
    if own.is_empty() {
        return generated;
    }
    let mut text = String::with_capacity(generated.len());
    for line in generated.lines() {
        if line.starts_with("axiom ")
            && let Some(further) = own.get(FURTHER)
        {
            push_lines(&mut text, "", further);
        }
        let rule = left_side(line).and_then(|left| own.get(left));
        match rule {
            Some(rule) => push_lines(&mut text, indent(line), rule),
            None => push_lines(&mut text, "", line),
        }
    }
    text
}

fn indent(line: &str) -> &str {
    &line[..line.len() - line.trim_start().len()]
}

fn push_lines(text: &mut String, indent: &str, lines: &str) {
    // An empty line is one, too.
    for line in lines.split('\n') {
        text.push_str(indent);
        text.push_str(line.trim_end());
        text.push('\n');
    }
}

impl Sketch {
    /// Every production of the grammar, in its order, and what a person wrote in its place.
    #[must_use]
    pub fn productions(&self) -> Vec<Production> {
        let generated = self.generated_rules();
        let lines = generated.lines();
        lines
            .filter_map(|line| {
                let of = left_side(line)?;
                Some(Production {
                    of: of.to_owned(),
                    generated: line.trim().to_owned(),
                    own: self.own_rules.get(of).cloned(),
                })
            })
            .collect()
    }

    /// Puts a person's text in the place of a production, or (under [`FURTHER`]) beside them; none: the generated one is back.
    ///
    /// # Errors
    /// [`SketchError::Rule`] with the grammar's message where it cannot be read so, [`SketchError::TooMany`] beyond the bounds.
    pub fn with_rule(&self, of: &str, to: Option<&str>) -> Result<Self, SketchError> {
        let mut next = self.clone();
        let rules = std::sync::Arc::make_mut(&mut next.own_rules);
        match to.map(str::trim_end).filter(|text| !text.is_empty()) {
            Some(text) => rules.insert(of.to_owned(), text.to_owned()),
            None => rules.remove(of),
        };
        next.check_own_rules()?;
        Ok(next)
    }

    /// Drops rules of lines that are no more; where nothing is drawn, all of them: further lines may name what is gone,
    /// and would stand in the way of clearing and of drawing anew.
    pub(crate) fn prune_rules(&mut self) {
        if self.own_rules.is_empty() {
            return;
        }
        if self.is_empty() {
            self.own_rules = std::sync::Arc::default();
            return;
        }
        let generated = self.generated_rules();
        let known: std::collections::BTreeSet<&str> =
            generated.lines().filter_map(left_side).collect();
        std::sync::Arc::make_mut(&mut self.own_rules)
            .retain(|of, _| of == FURTHER || known.contains(of.as_str()));
    }

    /// Checks that the grammar can be read with the rules that a person wrote.
    ///
    /// # Errors
    /// As [`Self::with_rule`].
    pub(crate) fn check_own_rules(&self) -> Result<(), SketchError> {
        let rules = &*self.own_rules;
        if rules.is_empty() {
            return Ok(());
        }
        if rules.len() > OWN_RULES {
            return Err(SketchError::TooMany {
                what: "rules of your own",
                most: OWN_RULES,
            });
        }
        if rules
            .iter()
            .any(|(of, to)| of.len().max(to.len()) > RULE_BYTES)
        {
            return Err(SketchError::TooMany {
                what: "characters in a rule",
                most: RULE_BYTES,
            });
        }
        // With the shapes, as it grows: further lines might give a letter a second one.
        let checked = Grammar::parse(&self.grammar_text(), "the sketch");
        checked.map_err(|faults| SketchError::Rule(faults.to_string()))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::sync::atomic::AtomicBool;

    use glam::Vec3;

    use super::*;
    use crate::sketch::{Letter, NodeRef, grow};

    fn sketch() -> Sketch {
        let (sketch, _) = Sketch::default()
            .add_segments(NodeRef::ROOT, &[Vec3::Y * 0.1, Vec3::Y * 0.2])
            .unwrap();
        let at = NodeRef::new(Letter::TRUNK, 1);
        let (sketch, _) = sketch.add_segment(at, Vec3::new(0.1, 0.15, 0.0)).unwrap();
        sketch
    }

    #[test]
    fn a_rule_stands_where_the_generated_one_stood() {
        let sketch = sketch();
        let productions = sketch.productions();
        assert!(productions.len() >= 4, "{productions:?}");
        let own = "A(x) > B : x < 2 -> A(x) A(x+1)";
        let with = sketch.with_rule("A(x) > B", Some(own)).unwrap();
        let text = with.rules_text();
        assert!(
            text.contains(own) && !text.contains(&productions[0].generated),
            "{text}"
        );
        assert_eq!(with.productions()[0].own.as_deref(), Some(own));
        // The trunk stops after three segments.
        let height = |sketch: &Sketch| {
            let grown = grow(sketch, 9, &AtomicBool::new(false)).unwrap();
            grown
                .tree
                .letter
                .iter()
                .filter(|letter| **letter == 0)
                .count()
        };
        assert!(height(&with) < height(&sketch));
        assert_eq!(with.with_rule("A(x) > B", None).unwrap(), sketch);
    }

    #[test]
    fn further_lines_come_before_the_axiom() {
        let with = sketch()
            .with_rule(FURTHER, Some("const longest = 3\n# mine"))
            .unwrap()
            .with_rule("A(x) > B", Some("A(x) > B : x < longest -> A(x) A(x+1)"))
            .unwrap();
        let text = with.rules_text();
        assert!(text.find("const longest").unwrap() < text.find("axiom").unwrap());
        assert!(grow(&with, 5, &AtomicBool::new(false)).is_ok());
    }

    #[test]
    fn what_cannot_be_read_is_refused_with_the_place() {
        let sketch = sketch();
        for bad in [
            "A(x) > B -> A(x",
            "nonsense",
            "A(x) > B -> A(y)",
            "A(x) > B : -> A(x)",
        ] {
            let refused = sketch.with_rule("A(x) > B", Some(bad)).unwrap_err();
            assert!(
                refused.to_string().contains("the sketch"),
                "{bad}: {refused}"
            );
        }
        let long = "A".repeat(RULE_BYTES + 1);
        assert!(sketch.with_rule("A(x) > B", Some(&long)).is_err());
    }

    #[test]
    fn further_lines_do_not_stand_in_the_way_of_clearing() {
        let with = sketch()
            .with_rule(FURTHER, Some("const half = divergence / 2"))
            .unwrap();
        let (deleted, _) = with.delete_node(NodeRef::new(Letter::TRUNK, 1)).unwrap();
        for mut cleared in [with.clear(), deleted] {
            cleared.prune_rules();
            assert!(cleared.own_rules.is_empty());
            assert!(cleared.check_own_rules().is_ok());
        }
    }

    #[test]
    fn a_letter_has_one_shape() {
        let twice = Some("shape A = [(0 1 0)]");
        assert!(sketch().with_rule(FURTHER, twice).is_err());
    }

    #[test]
    fn a_rule_goes_with_its_line() {
        let with = sketch()
            .with_rule("C(x) > B", Some("C(x) > B : x < 1 -> C(x) C(x+1)"))
            .unwrap();
        let (mut gone, _) = with
            .delete_node(NodeRef::new(Letter::from_index(1), 1))
            .unwrap();
        gone.prune_rules();
        assert!(gone.own_rules.is_empty());
        assert!(gone.check_own_rules().is_ok());
    }
}
