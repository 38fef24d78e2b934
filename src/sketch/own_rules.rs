//! Productions that a person wrote in the place of the generated ones.
//!
//! The sketch's grammar stays the one that grows and the one that is read: a rule of one's own stands in its text where the
//! generated one stood, and further lines (constants, productions) before the axiom. Its name is the left side's letters:
//! conditions and parameters change as the person draws on and sets depths, and a rule outlasts that. A rule whose
//! letters are not generated any more, because its line was deleted, goes with it; a change that would make the
//! grammar unreadable, or leave a letter with other parameters than a rule says, is refused with the grammar's own message.
//! So sketch and grammar cannot disagree.

use std::collections::BTreeMap;

use super::{Letter, Sketch, SketchError};
use crate::lsystem::Grammar;

/// Texts by the name ([`name_of`]) of the production that they stand for; `""` names the further lines.
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
    /// Its name.
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

/// The name of the production with this left side: its letters, and `:` where there is a condition, which keeps the
/// two of a helper apart. `A(x) > A(y) : (x+1) % 2 == 0` is `A > A :`. A name is its own name.
#[must_use]
pub fn name_of(left: &str) -> String {
    let (modules, condition) = match left.split_once(" :") {
        // A weight alone is no condition: a branch's growth has one where branches rest.
        Some((modules, says)) if says.trim_start().starts_with("weight") => (modules, ""),
        Some((modules, _)) => (modules, " :"),
        None => (left, ""),
    };
    let mut depth = 0_usize;
    let mut name = String::with_capacity(left.len());
    for letter in modules.chars() {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ if depth == 0 => name.push(letter),
            _ => {}
        }
    }
    name + condition
}

/// Rules as a file holds them, under their names: once they were kept by the whole left side.
#[must_use]
pub fn by_name(rules: OwnRules) -> OwnRules {
    let named = rules.into_iter().map(|(of, to)| (name_of(&of), to));
    named.collect()
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
        let rule = left_side(line).and_then(|left| own.get(&name_of(left)));
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
                let of = name_of(left_side(line)?);
                Some(Production {
                    generated: line.trim().to_owned(),
                    own: self.own_rules.get(&of).cloned(),
                    of,
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
            Some(text) => rules.insert(name_of(of), text.to_owned()),
            None => rules.remove(&name_of(of)),
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
        let lefts = generated.lines().filter_map(left_side);
        let known: std::collections::BTreeSet<String> = lefts.map(name_of).collect();
        std::sync::Arc::make_mut(&mut self.own_rules)
            .retain(|of, _| of == FURTHER || known.contains(of));
    }

    /// Whether rules of one's own may draw by the sketch's seed: where there are some, and they state none.
    pub(super) fn own_rules_may_draw(&self) -> bool {
        !self.own_rules.is_empty() && !self.own_rules_state_a_seed()
    }

    /// Whether a person's further lines state the seed: a grammar has one.
    pub(super) fn own_rules_state_a_seed(&self) -> bool {
        let states = |line: &str| line.split_whitespace().next() == Some("seed");
        let further = self.own_rules.get(FURTHER);
        further.is_some_and(|text| text.lines().any(states))
    }

    /// Whether a branch was drawn since then on a line whose branching a person wrote: it grows once that rule names it.
    pub(crate) fn has_branch_left_to_rules(&self, before: &Self) -> bool {
        let new = self.strokes.iter().skip(before.strokes.len());
        new.filter_map(|stroke| stroke.attachment).any(|at| {
            let branching = format!("{0} > {0} :", at.letter);
            self.own_rules.contains_key(&branching)
        })
    }

    /// Checks that a person's rules give a letter the parameters that it has now. The grammar would take one with others
    /// for another module, and the tree would stop growing without a word.
    ///
    /// # Errors
    /// [`SketchError::Rule`] with the grammar's message.
    pub(super) fn check_parameters(&self, letter: Letter) -> Result<(), SketchError> {
        match self.declaration(letter) {
            // Longer names are declared as it is.
            Some(declaration) if !letter.is_word() && !self.own_rules.is_empty() => {
                check(&(self.grammar_text() + &declaration))
            }
            _ => Ok(()),
        }
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
        check(&self.grammar_text())
    }
}

fn check(text: &str) -> Result<(), SketchError> {
    let checked = Grammar::parse(text, "the sketch");
    checked.map_err(|faults| SketchError::Rule(faults.to_string()))?;
    Ok(())
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
    use crate::sketch::{GROW, GrowParams, Grower, Habit, Letter, NodeRef, SelfSimilar, grow};
    use crate::tree::bark::Bark;

    const TRUNK_BRANCHES: &str = "A > A :";

    fn sketch() -> Sketch {
        let (sketch, _) = Sketch::default()
            .add_segments(
                NodeRef::ROOT,
                &[Vec3::Y * 0.1, Vec3::Y * 0.2, Vec3::Y * 0.3],
            )
            .unwrap();
        branched(&sketch, 1)
    }

    fn branched(sketch: &Sketch, node: u32) -> Sketch {
        let at = NodeRef::new(Letter::TRUNK, node);
        sketch.add_segment(at, Vec3::new(0.1, 0.15, 0.0)).unwrap().0
    }

    fn nested(depth_limit: Option<u32>) -> Option<SelfSimilar> {
        Some(SelfSimilar {
            rate: 2,
            depth_limit,
        })
    }

    #[test]
    fn a_rule_stands_where_the_generated_one_stood() {
        let sketch = sketch();
        let productions = sketch.productions();
        assert!(productions.len() >= 4, "{productions:?}");
        let own = "A(x) > B : x < 2 -> A(x) A(x+1)";
        let with = sketch.with_rule("A > B", Some(own)).unwrap();
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
        assert_eq!(with.with_rule("A > B", None).unwrap(), sketch);
    }

    #[test]
    fn further_lines_come_before_the_axiom() {
        let with = sketch()
            .with_rule(FURTHER, Some("const longest = 3\n# mine"))
            .unwrap()
            .with_rule("A > B", Some("A(x) > B : x < longest -> A(x) A(x+1)"))
            .unwrap();
        let text = with.rules_text();
        assert!(text.find("const longest").unwrap() < text.find("axiom").unwrap());
        assert!(grow(&with, 5, &AtomicBool::new(false)).is_ok());
    }

    #[test]
    fn rules_that_draw_draw_by_the_sketchs_seed_unless_they_state_one() {
        let rests = "A(x) > B : weight 1 -> A(x) A(x+1)\nA(x) > B : weight 1 -> A(x)";
        let with = sketch().with_rule("A > B", Some(rests)).unwrap();
        assert!(!with.rules_text().contains("\nseed"));
        let nodes = |sketch: &Sketch| {
            let grown = grow(sketch, 12, &AtomicBool::new(false)).unwrap();
            grown.tree.len()
        };
        let of_seeds = |sketch: &Sketch| -> std::collections::BTreeSet<usize> {
            (1..9).map(|seed| nodes(&sketch.with_seed(seed))).collect()
        };
        assert!(of_seeds(&with).len() > 2);
        assert_eq!(of_seeds(&sketch()).len(), 1);
        let stated = with.with_rule(FURTHER, Some("seed 5")).unwrap();
        assert_eq!(of_seeds(&stated).len(), 1);
        // A grammar states its seed once, whatever else stands in it.
        const OAK: Option<Bark> = Some(Bark::Oak);
        for (bark, shrink) in [(OAK, 0.0), (None, 0.1), (OAK, 0.1)] {
            for sketch in [&with, &stated] {
                let habit = Habit {
                    bark,
                    shrink,
                    seed: 3,
                    ..Habit::default()
                };
                let dressed = sketch.with_habit(habit).unwrap();
                assert_eq!(dressed.grammar_text().matches("\nseed ").count(), 1);
                assert!(nodes(&dressed) > 1, "{bark:?} {shrink}");
            }
        }
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
            let refused = sketch.with_rule("A > B", Some(bad)).unwrap_err();
            assert!(
                refused.to_string().contains("the sketch"),
                "{bad}: {refused}"
            );
        }
        let long = "A".repeat(RULE_BYTES + 1);
        assert!(sketch.with_rule("A > B", Some(&long)).is_err());
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
    fn a_tree_of_too_many_segments_is_refused_as_one_without_own_rules() {
        let twice = "A(x) > B -> A(x) A(x+1) [ A(0) B ]";
        let with = sketch().with_rule("A > B", Some(twice)).unwrap();
        let most = 50;
        let mut grower = Grower::new(GrowParams {
            segments: most,
            ..GROW
        });
        let mut grown = |step| grower.grow(&with, step, &AtomicBool::new(false));
        assert!(grown(3).is_ok());
        let refused = SketchError::TooLarge { step: 9, most };
        assert_eq!(grown(9).err(), Some(refused));
    }

    #[test]
    fn a_letter_has_one_shape() {
        let twice = Some("shape A = [(0 1 0)]");
        assert!(sketch().with_rule(FURTHER, twice).is_err());
    }

    #[test]
    fn a_production_is_named_by_its_letters() {
        for (left, name) in [
            ("A(x) > B", "A > B"),
            ("C1(x, d) > B", "C1 > B"),
            (
                "A(x) > A(y) : (x+1) % 2 == 0 || (x+1) % 3 == 0",
                TRUNK_BRANCHES,
            ),
            ("C(x, d) > C(y, e) : (x+1) % 2 == 0 && d < 1", "C > C :"),
            ("D_on_A(x) : (x+1) % 3 == 0", "D_on_A :"),
            ("D_on_A(x)", "D_on_A"),
            (FURTHER, FURTHER),
            ("A)(", "A"),
        ] {
            assert_eq!(name_of(left), name, "{left}");
            assert_eq!(name_of(name), name, "a name is its own name");
        }
    }

    #[test]
    fn no_two_productions_have_one_name() {
        let sketch = branched(&branched(&sketch(), 2), 1);
        let names: Vec<String> = sketch.productions().into_iter().map(|it| it.of).collect();
        let distinct: std::collections::BTreeSet<&String> = names.iter().collect();
        assert!(names.iter().any(|name| name == "D_on_A :"), "{names:?}");
        assert_eq!(distinct.len(), names.len(), "{names:?}");
    }

    #[test]
    fn a_rule_outlasts_other_conditions_of_the_one_it_stands_for() {
        let own = "A(x) > A(y) : x < 1 -> A(x) [ +(40) C(0) B ]";
        let with = sketch().with_rule(TRUNK_BRANCHES, Some(own)).unwrap();
        let letter = Letter::from_index(1);
        let branch = branched(&with, 2);
        let nested = with.with_self_similar(letter, nested(None)).unwrap();
        for (mut next, left_to_rules) in [(branch, true), (nested, false)] {
            next.prune_rules();
            assert_eq!(next.own_rules, with.own_rules);
            assert!(next.check_own_rules().is_ok());
            assert!(next.rules_text().contains(own));
            assert_eq!(next.has_branch_left_to_rules(&with), left_to_rules);
        }
    }

    #[test]
    fn a_letter_keeps_the_parameters_that_rules_give_it() {
        let letter = Letter::from_index(1);
        let nested_anew = |sketch: &Sketch| sketch.with_self_similar(letter, nested(Some(1)));
        assert!(nested_anew(&sketch()).is_ok(), "nothing is in the way");
        for (of, own) in [
            ("C > B", "C(x) > B : x < 4 -> C(x) C(x+1)"),
            (TRUNK_BRANCHES, "A(x) > A(y) : x < 1 -> A(x) [ C(0) B ]"),
            (FURTHER, "C(x) < C(y) : y > 9 -> *"),
        ] {
            let with = sketch().with_rule(of, Some(own)).unwrap();
            let refused = nested_anew(&with).unwrap_err().to_string();
            assert!(
                refused.contains("`C` is declared with 2"),
                "{own}: {refused}"
            );
            let other = with.with_self_similar(letter, nested(None));
            assert!(other.is_ok(), "a rate changes no parameters");
            let as_drawn = with.with_rule(of, None).unwrap();
            assert!(nested_anew(&as_drawn).is_ok(), "{own}");
        }
    }

    #[test]
    fn a_rule_goes_with_its_line() {
        let with = sketch()
            .with_rule("C > B", Some("C(x) > B : x < 1 -> C(x) C(x+1)"))
            .unwrap();
        let (mut gone, _) = with
            .delete_node(NodeRef::new(Letter::from_index(1), 1))
            .unwrap();
        gone.prune_rules();
        assert!(gone.own_rules.is_empty());
        assert!(gone.check_own_rules().is_ok());
    }
}
