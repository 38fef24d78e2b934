//! The sketch as an L-system that a person can read, edit and save.
//!
//! The rules are those of the thesis, written out for the letters there are, with X, Y letters:
//!
//! 1. growth: `X(x) > B -> X(x) X(x+1)`;
//! 2. branching: `X(x) > X(y)` gets a branch `[ /(divergence·k) Y(0) B ]` behind every n-th segment.
//!
//! Where branches of several rates sit on one letter, each has a helper module `Y_on_X`, which a
//! decomposition rule turns into the branch or into nothing, in the order drawn; so one production a letter is
//! enough and no combination of rates needs its own. A letter with a depth limit has the depth of
//! its nesting as second parameter.
//!
//! The polylines follow as shapes: at full size, each branch in the frame of the segment it
//! sits on, so that its first copy (k = 0) stands exactly where it was drawn. The text needs nothing
//! else: `ramus derive` makes the same branching from it.

use std::{fmt::Write as _, sync::Arc};

use glam::DVec3;

use super::{
    Letter, Sketch, Stroke, Wrap,
    dictionary::{Dictionary, number},
    habit::leafage,
    own_rules::with_own,
    quantize,
};

/// A new segment's bend, drawn once.
const BEND: &str = "normal(0, wander)";

/// Displacements on one line of a shape.
const PER_LINE: usize = 4;

/// A branch letter on a letter, as rule 2 sees it.
struct Branching<'a> {
    parent: &'a Stroke,
    child: &'a Stroke,
    /// A copy sits at every `rate`-th node.
    rate: u32,
}

impl Sketch {
    /// The grammar of this sketch, in the language of `docs/src/language.md`.
    #[must_use]
    pub fn grammar_text(&self) -> String {
        let mut text = self.rules_text();
        if !self.is_empty() {
            self.push_shapes(&mut text);
        }
        text
    }

    /// The grammar without its shapes: all that the string depends on.
    #[must_use]
    pub fn rules_text(&self) -> String {
        with_own(self.generated_rules(), &self.own_rules)
    }

    /// Whether another sketch has the same [`Self::rules_text`]: then at most its nodes and radii are others.
    #[must_use]
    pub fn has_rules_of(&self, other: &Self) -> bool {
        let says = |stroke: &Stroke| (stroke.letter, stroke.attachment, stroke.self_similar);
        let pairs = || self.strokes.iter().zip(&other.strokes);
        self.strokes.len() == other.strokes.len()
            && self.is_empty() == other.is_empty()
            && self.divergence_deg == other.divergence_deg
            && self.scale == other.scale
            && self.wrap == other.wrap
            && pairs().all(|(own, theirs)| Arc::ptr_eq(own, theirs) || says(own) == says(theirs))
            && self.own_rules == other.own_rules
            && (Arc::ptr_eq(&self.habit, &other.habit) || self.habit == other.habit)
            && (!self.habit.has_tropism() || self.is_above_ground() == other.is_above_ground())
            && (self.habit.starve == 0.0 || leafage(self.usual()) == leafage(other.usual()))
            && (self.habit.crowd == 0.0 || self.usual() == other.usual())
    }

    /// The rules as the strokes make them.
    pub(super) fn generated_rules(&self) -> String {
        let mut text =
            String::from("# A sketch, written by Ramus: A is the trunk, B a growing end.\n");
        if self.is_empty() {
            text.push_str("# Nothing is drawn yet.\naxiom B\n");
            return text;
        }
        let branchings: Vec<Vec<Branching<'_>>> = self
            .strokes
            .iter()
            .map(|stroke| self.branchings_on(stroke))
            .collect();
        self.push_declarations(&mut text, &branchings);
        let habit = &*self.habit;
        let trunk = self.strokes.first().map_or("A(0)".to_owned(), |trunk| {
            self.first_module(trunk, "length")
        });
        let turned = if habit.has_tropism() { "T(light) " } else { "" };
        let _ = writeln!(text, "\naxiom {turned}{trunk} {}", habit.end());
        text.push_str("\n# Growth: an end moves on by one segment.\n");
        for (number, stroke) in self.strokes.iter().enumerate() {
            self.push_growth(&mut text, stroke, number > 0);
        }
        habit.push_ends(&mut text);
        if branchings.iter().any(|on| !on.is_empty()) {
            text.push_str("\n# Branching: the first one stands where it was drawn, each further one is turned about its parent.\n");
        }
        branchings
            .iter()
            .filter(|on| !on.is_empty())
            .for_each(|on| self.push_branching(&mut text, on));
        let decomposed: Vec<&Branching<'_>> = branchings
            .iter()
            .filter(|on| !is_direct(on))
            .flatten()
            .collect();
        if !decomposed.is_empty() {
            text.push_str("\ndecompose {\n");
            for branching in decomposed {
                let (helper, here) = (branching.helper(), self.parameters(branching.parent));
                let (condition, bracket) = (branching.condition(), self.bracket(branching));
                let _ = writeln!(text, "  {helper}({here}) : {condition} -> {bracket}");
                let _ = writeln!(text, "  {helper}({here}) -> *");
            }
            text.push_str("}\n");
        }
        if habit.has_bends() {
            text.push_str(
                "\n# Bends: each segment's own two angles turn what follows.\ninterpret {\n",
            );
            for stroke in &self.strokes {
                let (name, here) = (stroke.letter, self.parameters(stroke));
                let straight = self.with_more(stroke, "x", "d", "n", ["0"; 2]);
                let _ = writeln!(text, "  {name}({here}) -> +(p) &(q) {name}({straight})");
            }
            text.push_str("}\n");
        }
        text
    }

    /// Growth of one letter, with the rests that dominance makes: of branches, or of the trunk.
    fn push_growth(&self, text: &mut String, stroke: &Stroke, is_branch: bool) {
        let (name, here, next) = (
            stroke.letter,
            self.parameters(stroke),
            self.next_parameters(stroke),
        );
        if let Some(crowded) = self.habit.crowded_context() {
            let _ = writeln!(text, "{name}({here}) > {crowded} -> {name}({here})");
        }
        let rests = if is_branch {
            self.habit.dominance > 0.0
        } else {
            self.habit.dominance < 0.0
        };
        let grows = match (self.habit.has_length(), rests) {
            (false, false) => "",
            (true, false) => " : x+1 < n",
            (false, true) => " : weight 1 - dominance",
            (true, true) => " : x+1 < n, weight 1 - dominance",
        };
        let _ = writeln!(
            text,
            "{name}({here}) > B{grows} -> {name}({here}) {name}({next})"
        );
        if rests {
            let _ = writeln!(
                text,
                "{name}({here}) > B : x >= 0, weight dominance -> {name}({here})"
            );
        }
    }

    /// Metres that a usual segment is long at full size.
    fn usual(&self) -> f64 {
        let lengths = self
            .segments()
            .map(|(_, from, to)| f64::from(from.distance(to) * self.scale));
        let (count, sum) = lengths.fold((0.0, 0.0), |(count, sum), length| {
            (count + 1.0, sum + length)
        });
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// Whether nothing is drawn below where the trunk begins.
    fn is_above_ground(&self) -> bool {
        self.nodes().all(|(_, place)| place.y >= 0.0)
    }

    /// A letter's formal parameters: the segment, the depth of its nesting where that is limited, its
    /// line's segments where these are, its bends where shoots wander.
    fn parameters(&self, stroke: &Stroke) -> String {
        self.with_more(stroke, "x", "d", "n", ["p", "q"])
    }

    /// Those of the letter after it.
    fn parameters_above(&self, stroke: &Stroke) -> String {
        self.with_more(stroke, "y", "e", "m", ["r", "s"])
    }

    fn next_parameters(&self, stroke: &Stroke) -> String {
        self.with_more(stroke, "x+1", "d", "n", [BEND; 2])
    }

    /// The module that a line of this letter begins with.
    fn first_module(&self, stroke: &Stroke, length: &str) -> String {
        let parameters = self.with_more(stroke, "0", "0", length, ["0"; 2]);
        format!("{}({parameters})", stroke.letter)
    }

    fn with_more(
        &self,
        stroke: &Stroke,
        segment: &str,
        depth: &str,
        length: &str,
        bends: [&str; 2],
    ) -> String {
        let mut parameters = segment.to_owned();
        if depth_limit(stroke).is_some() {
            parameters = format!("{parameters}, {depth}");
        }
        if self.habit.has_length() {
            parameters = format!("{parameters}, {length}");
        }
        if self.habit.has_bends() {
            parameters = format!("{parameters}, {}, {}", bends[0], bends[1]);
        }
        parameters
    }

    /// How many strokes a stroke hangs on: 0 for the trunk.
    fn order_of(&self, stroke: &Stroke) -> usize {
        let on = |stroke: &Stroke| self.stroke(stroke.attachment?.letter);
        std::iter::successors(on(stroke), |below| on(below))
            .take(self.strokes.len())
            .count()
    }

    /// A branch itself.
    fn bracket(&self, branching: &Branching<'_>) -> String {
        let child = branching.child;
        let length = self.habit.branch_length();
        let first = if branching.is_copy() && depth_limit(child).is_some() {
            let parameters = self.with_more(child, "0", "d+1", length, ["0"; 2]);
            format!("{}({parameters})", child.letter)
        } else {
            self.first_module(child, length)
        };
        let turn = format!("divergence * ((x+1)/{} - 1)", branching.rate);
        let mut turns = format!("/({turn})");
        if self.habit.spread_deg > 0.0 {
            turns = format!("/({turn} + normal(0, spread)) &(normal(0, spread))");
        }
        if self.habit.has_tropism() {
            let own = self.order_of(child);
            let order = match depth_limit(child).filter(|_| branching.is_copy()) {
                Some(_) => format!("(d+{})", own + 1),
                None if branching.is_copy() => (own + 1).to_string(),
                None => own.to_string(),
            };
            turns = format!("{turns} T(light - gravity * {order})");
        }
        if self.habit.shrink > 0.0 {
            turns.push_str(" @l(1 - shrink)");
        }
        format!("[ {turns} {first} {} ]", self.habit.end())
    }

    /// The branches on a letter, in the order drawn; its copies of itself count as drawn with it.
    fn branchings_on<'a>(&'a self, parent: &'a Stroke) -> Vec<Branching<'a>> {
        let rate_of = |child: &Stroke| -> Option<u32> {
            if child.letter == parent.letter {
                return depth_limit(child)
                    .is_none_or(|limit| limit > 0)
                    .then_some(child.self_similar?.rate);
            }
            child
                .attachment
                .filter(|at| at.letter == parent.letter)
                .map(|at| at.node)
        };
        let branching = |child: &'a Stroke| {
            Some(Branching {
                parent,
                child,
                rate: rate_of(child)?,
            })
        };
        self.strokes
            .iter()
            .filter_map(|child| branching(child))
            .collect()
    }

    fn push_declarations(&self, text: &mut String, branchings: &[Vec<Branching<'_>>]) {
        let _ = writeln!(
            text,
            "# Lengths are metres at full size: {} times the sketch.",
            self.scale
        );
        let _ = writeln!(text, "const divergence = {}", self.divergence_deg);
        self.habit.push_laws(
            text,
            self.usual(),
            !self.own_rules_state_a_seed(),
            self.is_above_ground(),
        );
        if self.habit.is_lawless() && self.habit.seed != 0 && self.own_rules_may_draw() {
            let _ = writeln!(text, "seed {}", self.habit.seed);
        }
        text.push_str("context literal\n");
        text.push_str(match self.wrap {
            Wrap::CarryHeading => "wrap carry\n",
            Wrap::Restart => "wrap restart\n",
        });
        let words = self.strokes.iter().map(|stroke| stroke.letter);
        let words = words.filter(|letter| letter.is_word());
        text.extend(words.filter_map(|letter| self.declaration(letter)));
        for branching in branchings.iter().filter(|on| !is_direct(on)).flatten() {
            let _ = writeln!(
                text,
                "module {}({})",
                branching.helper(),
                self.parameters(branching.parent)
            );
        }
    }

    /// What says how many parameters a letter has; a grammar needs it of longer names alone.
    pub(super) fn declaration(&self, letter: Letter) -> Option<String> {
        let stroke = self.stroke(letter)?;
        Some(format!("module {letter}({})\n", self.parameters(stroke)))
    }

    /// How thick the tree is, and what it wears.
    fn push_looks(&self, text: &mut String) {
        let is_dressed = self.habit.bark.is_some() || !self.habit.bears.is_empty();
        if !is_dressed {
            return;
        }
        text.push_str("\n# What it wears.\n");
        if self.habit.is_lawless() && self.habit.seed != 0 && self.own_rules.is_empty() {
            // Laws and rules of one's own have it above, or state their own.
            let _ = writeln!(text, "seed {}", self.habit.seed);
        }
        if self.strokes.iter().all(|one| one.radii.is_empty()) {
            let _ = writeln!(
                text,
                "widths da-vinci tip {} exponent {}",
                self.tip_radius, self.radius_exponent
            );
        }
        self.habit.push_dress(text);
    }

    /// The drawn lines, behind [`Self::rules_text`].
    pub(super) fn push_shapes(&self, text: &mut String) {
        self.push_looks(text);
        text.push_str("\n# The strokes: one displacement (x y z) a segment; a branch is given in its parent segment's frame.\n");
        if self.strokes.iter().any(|one| !one.radii.is_empty()) {
            text.push_str("# The fourth number is the radius, where a stroke has its own.\n");
        }
        for (letter, displacements) in Dictionary::of(self).iter() {
            let radii = self.stroke(letter).map_or(&[][..], |one| &one.radii);
            let _ = write!(text, "shape {letter} = [");
            for (index, [x, y, z]) in displacements.iter().map(DVec3::to_array).enumerate() {
                let gap = if index == 0 {
                    ""
                } else if index % PER_LINE == 0 {
                    "\n  "
                } else {
                    " "
                };
                let _ = write!(text, "{gap}({} {} {}", number(x), number(y), number(z));
                match radii.get(index).filter(|radius| **radius > 0.0) {
                    Some(radius) => {
                        let thick = quantize::exact_radius(*radius) * f64::from(self.scale);
                        let _ = write!(text, " {})", number(thick));
                    }
                    None => text.push(')'),
                }
            }
            text.push_str("]\n");
        }
    }
}

impl Branching<'_> {
    fn helper(&self) -> String {
        format!("{}_on_{}", self.child.letter, self.parent.letter)
    }

    fn is_copy(&self) -> bool {
        self.child.letter == self.parent.letter
    }

    /// When the segment of `parameters` carries this branch.
    fn condition(&self) -> String {
        let at_node = format!("(x+1) % {} == 0", self.rate);
        match depth_limit(self.child).filter(|_| self.is_copy()) {
            Some(limit) => format!("{at_node} && d < {limit}"),
            None => at_node,
        }
    }
}

/// Whether one production without helper modules says it all: every branch at the same segments.
fn is_direct(on: &[Branching<'_>]) -> bool {
    on.windows(2)
        .all(|pair| pair[0].condition() == pair[1].condition())
}

impl Sketch {
    fn push_branching(&self, text: &mut String, on: &[Branching<'_>]) {
        let Some(first) = on.first() else { return };
        let (name, here) = (first.parent.letter, self.parameters(first.parent));
        let above = self.parameters_above(first.parent);
        let direct = is_direct(on);
        let mut conditions: Vec<String> = Vec::new();
        for condition in on.iter().map(Branching::condition) {
            if !conditions.contains(&condition) {
                conditions.push(condition);
            }
        }
        let _ = write!(
            text,
            "{name}({here}) > {name}({above}) : {}",
            conditions.join(" || ")
        );
        let _ = write!(text, " -> {name}({here})");
        for branching in on {
            let _ = match direct {
                true => write!(text, " {}", self.bracket(branching)),
                false => write!(text, " {}({here})", branching.helper()),
            };
        }
        text.push('\n');
    }
}

fn depth_limit(stroke: &Stroke) -> Option<u32> {
    stroke.self_similar?.depth_limit
}
