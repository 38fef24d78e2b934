//! The board beside the platform: step and counts, the string, the rules, what the buttons do.
//!
//! Live, because cause and effect shall be seen: each edit shows in the string
//! at once. The text is composed only when what it says has changed; a warm
//! frame compares a few numbers.

use std::{fmt::Write as _, sync::Arc};

use crate::sketch::{NodeRef, Sketch};

use super::{
    document::Document,
    scene::{Board, BoardContent, new_revision},
    stage::{StageParams, stage_from_board},
};

/// How much text a board takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BoardParams {
    /// Characters of a line.
    pub columns: usize,
    /// Most lines of the string.
    pub string_lines: usize,
    /// Most lines of the rules.
    pub rule_lines: usize,
}

/// Lines of facts and blank ones between, and the most that say what buttons do.
const FACT_LINES: usize = 5;
const HINT_LINES: usize = 8;

impl BoardParams {
    /// Most lines of a whole board.
    #[must_use]
    pub fn lines(&self) -> usize {
        FACT_LINES + self.string_lines + self.rule_lines + HINT_LINES
    }
}

impl Default for BoardParams {
    fn default() -> Self {
        Self {
            columns: 54,
            string_lines: 5,
            rule_lines: 8,
        }
    }
}

/// What people call the parts of the controllers in hand; none where there is no such part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Buttons {
    /// Draws.
    pub draw: Option<String>,
    /// Grabs.
    pub grab: Option<String>,
    /// Grows.
    pub grow: Option<String>,
    /// Steps back.
    pub back: Option<String>,
    /// Undoes to the left and redoes to the right, unless there is something that redoes.
    pub undo: Option<String>,
    /// Redoes.
    pub redo: Option<String>,
    /// Mouse and keyboard, and no controllers in hand.
    pub desk: bool,
    /// Whatever else there is: its name and what it does.
    pub others: Vec<[String; 2]>,
}

impl Default for Buttons {
    /// Those of the controllers that most people have.
    fn default() -> Self {
        let some = |name: &str| Some(name.to_owned());
        Self {
            draw: some("trigger"),
            grab: some("grip"),
            grow: some("A or X"),
            back: some("B or Y"),
            undo: some("stick"),
            redo: None,
            desk: false,
            others: Vec::new(),
        }
    }
}

impl Buttons {
    /// What they do, one line each.
    fn hints(&self) -> Vec<String> {
        let delete = match &self.draw {
            Some(_) if self.desk => "move a node; with left too: delete it".to_owned(),
            Some(draw) => format!("move a node; with the {draw}: delete it"),
            None => "move a node".to_owned(),
        };
        let rim = self.grab.as_ref().map(|grab| match self.desk {
            true => "at the rim".to_owned(),
            false => format!("{grab} rim"),
        });
        let moves = match self.desk {
            true => "move the platform",
            false => "move and turn the platform; both: scale",
        };
        let undoes = match &self.redo {
            Some(_) => "undo",
            None => "left: undo   right: redo",
        };
        let lines = [
            (&self.draw, "draw; on a node: choose it, branch there"),
            (&self.grab, &delete),
            (&rim, moves),
            (&self.grow, "grow one step"),
            (&self.back, "step back"),
            (&self.undo, undoes),
            (&self.redo, "redo"),
        ];
        let named = lines
            .iter()
            .filter_map(|(name, does)| Some((name.as_ref()?, *does)));
        let others = self.others.iter().map(|[name, does]| (name, does.as_str()));
        let all = named.chain(others);
        let names = all.clone().map(|(name, _)| name.chars().count());
        let longest = names.max().unwrap_or(0);
        all.map(|(name, does)| format!("{name:longest$}  {does}"))
            .collect()
    }
}

/// What stands for text that was cut off.
const ELLIPSIS: char = '…';

/// What the board says besides the document.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facts<'a> {
    /// The string, perhaps cut.
    pub(super) string: &'a str,
    /// Segments of the tree.
    pub(super) segments: usize,
    /// Whether the tree is still being grown.
    pub(super) waiting: bool,
    /// How often can be undone and redone.
    pub(super) undo: [usize; 2],
    /// What the person is to be told.
    pub(super) message: Option<&'a str>,
    /// Counts up whenever the string changed.
    pub(super) string_revision: u64,
}

/// What the present text was composed from.
#[derive(Debug)]
struct Composed {
    sketch: Arc<Sketch>,
    step: u32,
    selected: NodeRef,
    /// Whether that is the end of its line.
    at_apex: bool,
    segments: usize,
    waiting: bool,
    undo: [usize; 2],
    string_revision: u64,
    /// The rules as the board has them.
    rules: Vec<String>,
}

/// See the module.
#[derive(Debug, Default)]
pub(super) struct LiveBoard {
    of: Option<Composed>,
    content: Arc<BoardContent>,
    revision: u64,
    buttons: Buttons,
}

impl LiveBoard {
    /// Tells what is in hand; the text says so when it is composed next, which is at once.
    pub(super) fn take_buttons(&mut self, buttons: Buttons) {
        if self.buttons != buttons {
            self.buttons = buttons;
            self.of = None;
        }
    }

    /// What is in hand.
    pub(super) fn buttons(&self) -> &Buttons {
        &self.buttons
    }

    /// Makes the text follow; composes it only where something changed.
    pub(super) fn follow(&mut self, document: &Document, facts: &Facts<'_>, params: &BoardParams) {
        let sketch = &document.sketch;
        let at_apex = sketch.is_apex(document.selected);
        let before = self.of.take();
        let before =
            before.filter(|of| Arc::ptr_eq(&of.sketch, sketch) || of.sketch.has_rules_of(sketch));
        let same = before.as_ref().is_some_and(|of| {
            (of.step, of.selected, of.at_apex) == (document.step, document.selected, at_apex)
                && (of.segments, of.waiting, of.undo) == (facts.segments, facts.waiting, facts.undo)
                && of.string_revision == facts.string_revision
        });
        if same && self.content.message.as_deref() == facts.message {
            self.of = before;
            return;
        }
        // Without the shapes, which no board has room for and which a long sketch takes its time to write.
        let rules = before.map_or_else(
            || rules(&sketch.rules_text(), params.columns, params.rule_lines),
            |of| of.rules,
        );
        self.content = Arc::new(compose(document, facts, &rules, &self.buttons, params));
        self.of = Some(Composed {
            sketch: Arc::clone(sketch),
            step: document.step,
            selected: document.selected,
            at_apex,
            segments: facts.segments,
            waiting: facts.waiting,
            undo: facts.undo,
            string_revision: facts.string_revision,
            rules,
        });
        self.revision = new_revision();
    }

    /// The board on the stage.
    pub(super) fn placed(&self, params: &StageParams) -> Board {
        Board {
            world_from_board: stage_from_board(params),
            size: params.board_size,
            revision: self.revision,
            content: Arc::clone(&self.content),
        }
    }
}

fn compose(
    document: &Document,
    facts: &Facts<'_>,
    rules: &[String],
    buttons: &Buttons,
    params: &BoardParams,
) -> BoardContent {
    let mut lines = Vec::new();
    let mut line = |text: &str| lines.push(fitted(text, params.columns));
    line(&status(document, facts));
    line(&selection(document));
    line("");
    let string = if facts.string.is_empty() {
        "(nothing has grown yet)"
    } else {
        facts.string
    };
    for row in wrapped(string, params.columns, params.string_lines) {
        line(&row);
    }
    line("");
    for row in rules {
        line(row);
    }
    line("");
    for hint in buttons.hints() {
        line(&hint);
    }
    BoardContent {
        title: "Ramus".into(),
        lines,
        message: facts.message.map(str::to_owned),
    }
}

/// Step, counts, and how far one can go back and forth.
fn status(document: &Document, facts: &Facts<'_>) -> String {
    let mut text = format!("step {}", document.step);
    // Writing to a String cannot fail.
    if facts.waiting {
        let _ = write!(text, "   growing{ELLIPSIS}");
    } else {
        let _ = write!(text, "   {} segments", facts.segments);
    }
    let lines = document.sketch.strokes.len();
    let [undo, redo] = facts.undo;
    let _ = write!(
        text,
        "   {lines} {}   undo {undo} redo {redo}",
        if lines == 1 { "line" } else { "lines" }
    );
    text
}

/// Where the trigger draws.
fn selection(document: &Document) -> String {
    let at = document.selected;
    if document.sketch.is_apex(at) {
        format!("drawing on line {}, from node {}", at.letter, at.node)
    } else {
        format!("a branch starts at node {} of line {}", at.node, at.letter)
    }
}

/// The lines of a grammar that begin or rewrite, in rows; a last row says how many found no room.
fn rules(grammar: &str, columns: usize, most: usize) -> Vec<String> {
    let rules = grammar.lines().map(str::trim).filter(|line| {
        let comment = line.starts_with('#');
        !comment && (line.contains("->") || line.starts_with("axiom"))
    });
    let mut rows = Vec::new();
    let mut left = 0_usize;
    for rule in rules {
        if left > 0 {
            left += 1;
            continue;
        }
        let mut more = by_words(rule, columns);
        // One row stays free to say that there is more.
        if rows.len() + more.len() < most {
            rows.append(&mut more);
        } else {
            left = 1;
        }
    }
    if left > 0 {
        rows.push(format!("{ELLIPSIS} and {left} more"));
    }
    rows
}

/// The text in rows, broken at blanks, the further ones indented.
fn by_words(text: &str, columns: usize) -> Vec<String> {
    const INDENT: &str = "    ";
    let mut rows = vec![String::new()];
    for word in text.split_whitespace() {
        let Some(row) = rows.last_mut() else { break };
        let blank = usize::from(!row.trim_start().is_empty());
        if blank == 1 && row.chars().count() + blank + word.chars().count() > columns {
            rows.push(format!("{INDENT}{word}"));
        } else {
            row.push_str(&" "[..blank]);
            row.push_str(word);
        }
    }
    rows
}

/// The text cut to a number of characters.
fn fitted(text: &str, columns: usize) -> String {
    if text.chars().nth(columns).is_none() {
        return text.to_owned();
    }
    let kept = text.chars().take(columns.saturating_sub(1));
    kept.chain(std::iter::once(ELLIPSIS)).collect()
}

/// The string in rows of a number of characters, broken between modules and never within a number; the last row says
/// where more was cut off.
fn wrapped(text: &str, columns: usize, rows: usize) -> Vec<String> {
    let columns = columns.max(1);
    let mut found: Vec<String> = Vec::new();
    let mut room = 0;
    for module in modules(text) {
        let length = module.chars().count();
        if length > room {
            if found.len() == rows {
                if let Some(last) = found.last_mut() {
                    mark_cut(last, columns);
                }
                break;
            }
            found.push(String::new());
            room = columns;
        }
        if let Some(row) = found.last_mut() {
            row.push_str(&fitted(module, columns));
        }
        room = room.saturating_sub(length);
    }
    found
}

/// Puts the sign that there is more behind a row, in the place of its last modules where there is no room.
fn mark_cut(row: &mut String, columns: usize) {
    while row.chars().count() >= columns
        && let Some(last) = modules(row).last()
    {
        row.truncate(row.len() - last.len());
    }
    row.push(ELLIPSIS);
}

/// The modules of a string: each a name or sign with its parameters in parentheses.
fn modules(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let mut depth = 0_usize;
        let mut characters = rest.char_indices().skip(1).peekable();
        rest.chars().next()?;
        let end = loop {
            let Some((at, character)) = characters.next() else {
                break rest.len();
            };
            match character {
                '(' => depth += 1,
                ')' if depth == 1 => break at + 1,
                ')' => depth = depth.saturating_sub(1),
                _ if depth == 0 => break at,
                _ => {}
            }
        };
        let (module, after) = rest.split_at(end);
        rest = after;
        Some(module)
    })
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::sketch::Letter;

    const FACTS: Facts<'static> = Facts {
        string: "",
        segments: 0,
        waiting: false,
        undo: [0, 0],
        message: None,
        string_revision: 0,
    };

    #[test]
    fn text_is_cut_by_characters_and_says_so() {
        for (text, columns, expected) in [
            ("äöü", 3, "äöü"),
            ("äöüß", 3, "äö…"),
            ("", 3, ""),
            ("ab", 1, "…"),
        ] {
            assert_eq!(fitted(text, columns), expected);
        }
        assert_eq!(wrapped("A(0)A(1)B", 4, 3), ["A(0)", "A(1)", "B"]);
        assert_eq!(wrapped("A(0)A(1)B", 4, 2), ["A(0)", "…"]);
        assert_eq!(wrapped("AA(1)BCD", 5, 2), ["AA(1)", "BCD"]);
        assert_eq!(
            wrapped("A[/(137.508)C(0)B]A(1)", 11, 2),
            ["A[", "/(137.508)…"]
        );
        assert_eq!(wrapped("A(1.23456)B", 5, 2), ["A(1.…", "B"]);
        for odd in ["(", ")", "A(", "A(()", "A)B", "ä(ö)", "[[]]"] {
            assert_eq!(modules(odd).collect::<String>(), odd);
            assert_eq!(wrapped(odd, 9, 2).concat(), odd);
        }
        assert!(wrapped("", 4, 2).is_empty());
    }

    #[test]
    fn rules_are_picked_out_of_the_grammar() {
        let grammar = "# a -> comment\naxiom A(0) B\n  A(x) > B -> A(x) A(x+1)\nshape A = [(0 1 0)]\nC(x) -> C(x)\n";
        let all = ["axiom A(0) B", "A(x) > B -> A(x) A(x+1)", "C(x) -> C(x)"];
        assert_eq!(rules(grammar, 40, 4), all);
        assert_eq!(rules(grammar, 40, 3), [all[0], all[1], "… and 1 more"]);
        assert_eq!(
            rules(grammar, 12, 9),
            [
                "axiom A(0) B",
                "A(x) > B ->",
                "    A(x)",
                "    A(x+1)",
                "C(x) -> C(x)"
            ]
        );
        assert_eq!(
            by_words("one-long-word next", 5),
            ["one-long-word", "    next"],
            "cut later, where it is fitted"
        );
    }

    #[test]
    fn it_is_composed_only_when_something_changed() {
        let params = BoardParams::default();
        let mut board = LiveBoard::default();
        let document = Document::default();
        board.follow(&document, &FACTS, &params);
        let first = board.placed(&StageParams::default());
        board.follow(&document, &FACTS, &params);
        let again = board.placed(&StageParams::default());
        assert!(Arc::ptr_eq(&first.content, &again.content) && first.revision == again.revision);
        let mut last = first.revision;
        for facts in [
            Facts {
                message: Some("Look"),
                ..FACTS
            },
            Facts {
                message: Some("There"),
                ..FACTS
            },
            FACTS,
            Facts {
                segments: 3,
                ..FACTS
            },
            Facts {
                string: "A(0)B",
                string_revision: 1,
                ..FACTS
            },
            Facts {
                undo: [1, 0],
                ..FACTS
            },
        ] {
            board.follow(&document, &facts, &params);
            assert!(board.revision > last, "{facts:?}");
            last = board.revision;
        }
    }

    #[test]
    fn a_node_that_moves_writes_nothing_and_a_longer_line_does() {
        let params = BoardParams::default();
        let drawn = |points: &[glam::Vec3]| {
            let sketch = Sketch::default().add_segments(NodeRef::ROOT, points);
            Document {
                sketch: Arc::new(sketch.unwrap().0),
                selected: NodeRef::new(Letter::TRUNK, 1),
                ..Document::default()
            }
        };
        let up = glam::Vec3::Y * 0.1;
        let mut board = LiveBoard::default();
        board.follow(&drawn(&[up]), &FACTS, &params);
        let first = board.revision;
        board.follow(&drawn(&[up * 2.0]), &FACTS, &params);
        assert_eq!(board.revision, first);
        board.follow(&drawn(&[up, up * 2.0]), &FACTS, &params);
        assert!(board.revision > first, "node 1 is no apex any more");
        let branches = |line: &&String| line.starts_with("a branch starts at node 1");
        assert!(board.content.lines.iter().any(|line| branches(&line)));
    }

    #[test]
    fn no_number_is_broken() {
        let string = "A(0)[/(137.508)C(0)B]".repeat(9);
        let rows = wrapped(&string, 54, 5);
        assert_eq!(rows.concat(), string);
        for row in rows {
            assert!(
                row.matches('(').count() == row.matches(')').count(),
                "{row}"
            );
        }
    }

    #[test]
    fn every_line_fits() {
        let params = BoardParams::default();
        let long = "A(0)[/(137.508)C(0)B]".repeat(500);
        let facts = Facts {
            string: &long,
            segments: 1_999_999,
            undo: [123_456, 654_321],
            ..FACTS
        };
        let document = Document {
            step: 9999,
            ..Document::default()
        };
        let magic_leap = Buttons {
            grab: Some("shoulder".to_owned()),
            back: Some("pad bottom".to_owned()),
            undo: None,
            ..Buttons::default()
        };
        for (buttons, lines) in [(Buttons::default(), 6), (magic_leap, 5)] {
            let mut board = LiveBoard::default();
            board.take_buttons(buttons.clone());
            board.follow(&document, &facts, &params);
            let content = &board.content;
            let fits = |line: &String| line.chars().count() <= params.columns;
            assert!(content.lines.iter().all(fits));
            let hints = buttons.hints();
            assert_eq!(hints.len(), lines);
            let most = params.lines() + hints.len() - HINT_LINES;
            assert!(content.lines.len() <= most, "{}", content.lines.len());
            for hint in hints {
                assert!(content.lines.contains(&hint), "uncut: {hint}");
            }
        }
    }

    #[test]
    fn other_controllers_have_other_hints() {
        let mut board = LiveBoard::default();
        let (document, params) = (Document::default(), BoardParams::default());
        board.follow(&document, &FACTS, &params);
        assert!(
            board
                .content
                .lines
                .iter()
                .any(|l| l == "trigger   draw; on a node: choose it, branch there")
        );
        let before = board.revision;
        board.take_buttons(Buttons {
            draw: Some("pinch".to_owned()),
            grab: Some("fist".to_owned()),
            grow: None,
            back: None,
            undo: None,
            redo: None,
            desk: false,
            others: vec![["wheel".to_owned(), "zoom".to_owned()]],
        });
        board.follow(&document, &FACTS, &params);
        assert!(board.revision > before);
        let last = &board.content.lines[board.content.lines.len() - 4..];
        assert_eq!(
            last,
            [
                "pinch     draw; on a node: choose it, branch there",
                "fist      move a node; with the pinch: delete it",
                "fist rim  move and turn the platform; both: scale",
                "wheel     zoom",
            ]
        );
    }
}
