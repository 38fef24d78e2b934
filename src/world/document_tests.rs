//! Any sequence of edits: the document stays whole, undo and redo are exact, files and journals
//! give the same document back, and no damage to them makes a panic.
#![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]

mod curves;
mod files;

use glam::Vec3;
use proptest::prelude::*;

use super::{
    document::{Document, Edit, EditError, Placement},
    history::{Action, History},
    journal::{self, Damage, Journal, JournalError},
    project::{self, ProjectError},
};
use crate::sketch::{BOUNDS, Letter, NodeRef, SelfSimilar, SketchError, Symmetry, Wrap};

fn a(node: u32) -> NodeRef {
    NodeRef::new(Letter::TRUNK, node)
}

fn letter(index: u16) -> Letter {
    Letter::from_index(index)
}

fn apply_all(edits: &[Edit]) -> History {
    let mut history = History::default();
    for edit in edits {
        history.apply(edit.clone()).unwrap();
    }
    history
}

fn up(y: f32) -> Edit {
    Edit::AddSegment {
        to: Vec3::new(0.0, y, 0.0),
    }
}

/// A trunk of four segments, C on node 2 with two segments, D on C's node 1, E on A's node 2.
fn example() -> Vec<Edit> {
    vec![
        up(0.1),
        up(0.2),
        up(0.3),
        up(0.4),
        Edit::Select { at: a(2) },
        Edit::AddSegment {
            to: Vec3::new(0.1, 0.3, 0.0),
        },
        Edit::AddSegment {
            to: Vec3::new(0.2, 0.35, 0.0),
        },
        Edit::Select {
            at: NodeRef::new(letter(1), 1),
        },
        Edit::AddSegment {
            to: Vec3::new(0.1, 0.4, 0.1),
        },
        Edit::Select {
            at: NodeRef::new(letter(3 - 1), 0),
        },
        Edit::Select { at: a(2) },
        Edit::AddSegment {
            to: Vec3::new(-0.1, 0.3, 0.0),
        },
    ]
}

fn drawn(document: &Document) -> String {
    let stroke = |s: &std::sync::Arc<crate::sketch::Stroke>| {
        let at = s
            .attachment
            .map_or(String::new(), |at| format!("@{}{}", at.letter, at.node));
        format!("{}{}{at}", s.letter, s.segments())
    };
    document
        .sketch
        .strokes
        .iter()
        .map(stroke)
        .collect::<Vec<_>>()
        .join(" ")
}

#[test]
fn drawing_deleting_and_clearing() {
    let node = NodeRef::new;
    let table: Vec<(&str, Vec<Edit>, &str, NodeRef)> = vec![
        ("drawn", vec![], "A4 C2@A2 D1@C1 E1@A2", node(letter(3), 1)),
        (
            "a node high up takes only its line's end",
            vec![Edit::DeleteNode { at: a(3) }],
            "A2 C2@A2 D1@C1 E1@A2",
            a(2),
        ),
        (
            "at the attachment, all that hangs there goes",
            vec![Edit::DeleteNode { at: a(2) }],
            "A1",
            a(1),
        ),
        (
            "below it too",
            vec![Edit::DeleteNode { at: a(1) }],
            "A0",
            a(0),
        ),
        (
            "a branch's first node takes the branch and its branches",
            vec![Edit::DeleteNode {
                at: node(letter(1), 1),
            }],
            "A4 E1@A2",
            a(2),
        ),
        (
            "a branch's end leaves what hangs below",
            vec![Edit::DeleteNode {
                at: node(letter(1), 2),
            }],
            "A4 C1@A2 D1@C1 E1@A2",
            node(letter(1), 1),
        ),
        (
            "clearing clears",
            vec![Edit::SetStep { step: 7 }, Edit::Clear],
            "A0",
            a(0),
        ),
        (
            "a freed letter is used again",
            vec![
                Edit::DeleteNode {
                    at: node(letter(1), 1),
                },
                Edit::AddSegment {
                    to: Vec3::new(0.3, 0.3, 0.3),
                },
            ],
            "A4 E1@A2 C1@A2",
            node(letter(1), 1),
        ),
        (
            "a branch's start is its parent's node",
            vec![
                Edit::Select {
                    at: node(letter(2), 0),
                },
                Edit::AddSegment {
                    to: Vec3::new(0.3, 0.3, 0.3),
                },
            ],
            "A4 C2@A2 D1@C1 E1@A2 H1@C1",
            node(letter(4), 1),
        ),
    ];
    for (what, more, expected, selected) in table {
        let mut history = apply_all(&example());
        for edit in more {
            history.apply(edit).unwrap();
        }
        assert_eq!(drawn(history.committed()), expected, "{what}");
        assert_eq!(history.committed().selected, selected, "{what}");
        history.committed().validate().unwrap();
    }
}

#[test]
fn a_moved_node_takes_its_branches_along_and_nothing_else() {
    let mut history = apply_all(&example());
    let before = history.committed().clone();
    let to = Vec3::new(0.05, 0.22, -0.03);
    history.apply(Edit::MoveNode { at: a(2), to }).unwrap();
    let after = history.committed();
    let shift = to - before.sketch.position(a(2)).unwrap();
    for ((node, old), (_, new)) in before.sketch.nodes().zip(after.sketch.nodes()) {
        let expected = match (node.letter == Letter::TRUNK, node.node) {
            (true, 2) | (false, _) => old + shift,
            (true, _) => old,
        };
        assert!(
            (new - expected).length() < 1e-6,
            "{node:?} {new} {expected}"
        );
    }
    assert!(
        std::sync::Arc::ptr_eq(&before.sketch.strokes[1], &after.sketch.strokes[1]),
        "shared"
    );
}

#[test]
fn edits_that_would_break_the_document_are_refused() {
    let here = Vec3::new(0.1, 0.1, 0.1);
    let platform = |position, yaw_deg, scale| Edit::SetPlatform {
        to: Placement {
            position,
            yaw_deg,
            scale,
        },
    };
    let own = |rate, depth_limit| Edit::SetSelfSimilar {
        letter: letter(1),
        to: Some(SelfSimilar { rate, depth_limit }),
    };
    let table: Vec<(Edit, &str)> = vec![
        (up(f32::NAN), "finite"),
        (up(f32::INFINITY), "finite"),
        (up(1000.1), "between -1000 and 1000"),
        (
            Edit::MoveNode {
                at: a(1),
                to: Vec3::NEG_INFINITY,
            },
            "finite",
        ),
        (
            Edit::MoveNode {
                at: a(2),
                to: Vec3::new(999.95, 0.0, 0.0),
            },
            "between -1000 and 1000",
        ),
        (
            Edit::MoveNode {
                at: a(2),
                to: Vec3::new(0.0, 0.100_04, 0.0),
            },
            "shorter than 1 mm",
        ),
        (
            Edit::MoveNode {
                at: a(2),
                to: Vec3::new(0.0, 0.3, 0.0),
            },
            "shorter than 1 mm",
        ),
        (Edit::MoveNode { at: a(0), to: here }, "root stays"),
        (Edit::MoveNode { at: a(5), to: here }, "its last one is 4"),
        (
            Edit::MoveNode {
                at: NodeRef::new(letter(1), 0),
                to: here,
            },
            "node 2 of `A`",
        ),
        (
            Edit::MoveNode {
                at: NodeRef::new(letter(9), 1),
                to: here,
            },
            "no stroke",
        ),
        (Edit::DeleteNode { at: a(0) }, "root stays"),
        (
            Edit::DeleteNode {
                at: NodeRef::new(letter(1), 0),
            },
            "node 2 of `A`",
        ),
        (Edit::DeleteNode { at: a(u32::MAX) }, "its last one is 4"),
        (
            Edit::Select {
                at: NodeRef::new(letter(u16::MAX), 0),
            },
            "no stroke",
        ),
        (Edit::AddStroke { to: vec![] }, "at least one segment"),
        (
            Edit::AddStroke {
                to: vec![here, here],
            },
            "shorter than 1 mm",
        ),
        (
            Edit::SetStep {
                step: BOUNDS.step + 1,
            },
            "too far",
        ),
        (Edit::SetDivergence { degrees: f64::NAN }, "finite"),
        (
            Edit::SetDivergence {
                degrees: f64::INFINITY,
            },
            "finite",
        ),
        (
            Edit::SetDivergence { degrees: 1e120 },
            "between -360000 and 360000",
        ),
        (platform(Vec3::ZERO, 1e300, 1.0), "platform"),
        (platform(Vec3::NAN, 0.0, 1.0), "platform"),
        (platform(Vec3::splat(1001.0), 0.0, 1.0), "platform"),
        (platform(Vec3::ZERO, f64::NAN, 1.0), "platform"),
        (platform(Vec3::ZERO, 0.0, f32::NAN), "scale"),
        (platform(Vec3::ZERO, 0.0, 0.0), "scale"),
        (own(0, None), "rate"),
        (own(1, Some(BOUNDS.depth + 1)), "depth"),
        (
            Edit::SetSizes {
                scale: f32::NAN,
                tip_radius: 0.01,
                radius_exponent: 2.0,
            },
            "finite",
        ),
        (
            Edit::SetSizes {
                scale: 2.0,
                tip_radius: 0.0,
                radius_exponent: 2.0,
            },
            "the tip radius in metres must lie between 0.0001 and 1, not 0",
        ),
        (
            Edit::SetSizes {
                scale: 0.001,
                tip_radius: 0.01,
                radius_exponent: 2.0,
            },
            "the scale must lie between 0.01 and 1000, not 0.001",
        ),
        (
            Edit::SetSizes {
                scale: 2.0,
                tip_radius: 0.01,
                radius_exponent: 9.0,
            },
            "exponent",
        ),
    ];
    for (edit, reason) in table {
        let mut history = apply_all(&example());
        let before = history.committed().clone();
        history.take_log();
        let message = history.apply(edit.clone()).unwrap_err().to_string();
        assert!(message.contains(reason), "{edit:?}: {message}");
        assert_eq!(*history.committed(), before, "{edit:?}");
        assert!(history.take_log().is_empty(), "{edit:?}");
    }
    let mut history = apply_all(&example());
    history.apply(Edit::Select { at: a(0) }).unwrap();
    let refused = history.apply(Edit::AddSegment { to: here });
    assert_eq!(
        refused,
        Err(EditError::Sketch(SketchError::BranchAtRoot)),
        "a tree has one trunk"
    );
}

#[test]
fn too_much_is_refused() {
    let mut history = apply_all(&[up(0.1), up(0.2)]);
    for number in 0..BOUNDS.strokes - 1 {
        history.apply(Edit::Select { at: a(1) }).unwrap();
        #[allow(clippy::cast_precision_loss, reason = "small")]
        let x = 0.1 + number as f32 * 0.01;
        history
            .apply(Edit::AddSegment {
                to: Vec3::new(x, 0.1, 0.0),
            })
            .unwrap();
    }
    history.apply(Edit::Select { at: a(1) }).unwrap();
    let message = history.apply(up(0.5)).unwrap_err().to_string();
    assert!(message.contains("at most 512 strokes"), "{message}");
    #[allow(clippy::cast_precision_loss, reason = "small")]
    let long: Vec<Vec3> = (1..=BOUNDS.points)
        .map(|n| Vec3::new(1.0, n as f32 * 0.002, 0.0))
        .collect();
    history.apply(Edit::Select { at: a(2) }).unwrap();
    let message = history
        .apply(Edit::AddStroke { to: long })
        .unwrap_err()
        .to_string();
    assert!(message.contains("at most 100000 nodes"), "{message}");
}

#[test]
fn numbers_lie_on_the_grid() {
    let mut history = apply_all(&[Edit::AddSegment {
        to: Vec3::new(0.000_04, 0.123_456, -0.000_04),
    }]);
    assert_eq!(
        history.committed().sketch.strokes[0].points,
        [Vec3::new(0.0, 0.1235, 0.0)]
    );
    history
        .apply(Edit::SetDivergence { degrees: -90.000_4 })
        .unwrap();
    assert_eq!(history.committed().sketch.divergence_deg, 270.0);
    history
        .apply(Edit::SetDivergence { degrees: 359.9999 })
        .unwrap();
    assert_eq!(
        history.committed().sketch.divergence_deg,
        0.0,
        "rounded before the turn is taken off"
    );
    let log = history.take_log();
    let expected = Action::Edit(Edit::SetDivergence { degrees: 360.0 });
    assert_eq!(
        log.last(),
        Some(&expected),
        "the log holds what was applied"
    );
}

#[test]
fn an_edit_that_changes_nothing_is_none() {
    let mut history = apply_all(&example());
    history.undo();
    history.take_log();
    let (undone, redo) = (history.undo_count(), history.redo_count());
    let degrees = history.committed().sketch.divergence_deg;
    history.apply(Edit::SetDivergence { degrees }).unwrap();
    assert!(
        history
            .apply(Edit::SetDivergence { degrees: f64::NAN })
            .is_err()
    );
    assert_eq!((history.undo_count(), history.redo_count()), (undone, redo));
    assert!(redo > 0 && history.take_log().is_empty());
}

fn place() -> impl Strategy<Value = Vec3> {
    let near = (-2.0_f32..2.0, -2.0_f32..2.0, -2.0_f32..2.0).prop_map(Vec3::from);
    let any = (any::<f32>(), any::<f32>(), any::<f32>()).prop_map(Vec3::from);
    prop_oneof![20 => near, 1 => any]
}

fn node() -> impl Strategy<Value = NodeRef> {
    (0..6_u16, 0..6_u32).prop_map(|(index, node)| NodeRef::new(letter(index), node))
}

fn curve() -> impl Strategy<Value = Edit> {
    let spans = proptest::collection::vec((place(), 0..9_u32), 0..4);
    (node(), spans, 0..4_u32, any::<bool>()).prop_map(|(from, spans, turns, mirror)| {
        let (through, segments) = spans.into_iter().unzip();
        Edit::DrawCurve {
            from,
            through,
            segments,
            symmetry: Symmetry { turns, mirror },
        }
    })
}

fn edit() -> impl Strategy<Value = Edit> {
    prop_oneof![
        6 => place().prop_map(|to| Edit::AddSegment { to }),
        2 => proptest::collection::vec(place(), 0..4).prop_map(|to| Edit::AddStroke { to }),
        3 => curve(),
        5 => node().prop_map(|at| Edit::Select { at }),
        3 => (node(), place()).prop_map(|(at, to)| Edit::MoveNode { at, to }),
        2 => node().prop_map(|at| Edit::DeleteNode { at }),
        1 => Just(Edit::Clear),
        2 => (0..20_000_u32).prop_map(|step| Edit::SetStep { step }),
        2 => any::<f64>().prop_map(|degrees| Edit::SetDivergence { degrees }),
        2 => (place(), -1e4_f64..1e4, -1.0_f32..30.0).prop_map(|(position, yaw_deg, scale)| {
            Edit::SetPlatform { to: Placement { position, yaw_deg, scale } }
        }),
        2 => (0..6_u16, proptest::option::of((0..5_u32, proptest::option::of(0..80_u32)))).prop_map(
            |(index, own)| Edit::SetSelfSimilar {
                letter: letter(index),
                to: own.map(|(rate, depth_limit)| SelfSimilar { rate, depth_limit }),
            }
        ),
        1 => any::<bool>().prop_map(|on| Edit::SetSelfSimilarBranches { on }),
        1 => (0.0_f32..5.0, 0.0_f32..0.1, 0.5_f32..4.5).prop_map(|(scale, tip_radius, radius_exponent)| {
            Edit::SetSizes { scale, tip_radius, radius_exponent }
        }),
        1 => any::<bool>().prop_map(|on| Edit::SetWrap {
            to: if on { Wrap::Restart } else { Wrap::CarryHeading },
        }),
    ]
}

#[derive(Clone, Debug)]
enum Event {
    Apply(Edit),
    Undo,
    Redo,
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        8 => edit().prop_map(Event::Apply),
        2 => Just(Event::Undo),
        1 => Just(Event::Redo),
    ]
}

fn play(history: &mut History, event: &Event) -> bool {
    match event {
        Event::Apply(edit) => history.apply(edit.clone()).is_ok(),
        Event::Undo => history.undo(),
        Event::Redo => history.redo(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_sequence_keeps_the_invariants(events in proptest::collection::vec(event(), 0..60)) {
        let mut history = History::default();
        for event in &events {
            let before = history.committed().clone();
            let done = play(&mut history, event);
            history.committed().validate().unwrap();
            if !done {
                prop_assert_eq!(history.committed(), &before, "what is refused changes nothing");
            }
        }
        let end = history.committed().clone();
        let mut undone = 0;
        while history.undo() {
            undone += 1;
        }
        prop_assert_eq!(history.committed(), &Document::default(), "undo to the start is the start");
        for _ in 0..undone {
            prop_assert!(history.redo());
        }
        prop_assert_eq!(history.committed(), &end, "redo again is the end");
    }

    #[test]
    fn files_and_journals_give_the_document_back(events in proptest::collection::vec(event(), 0..60), cut in 0..60_usize) {
        let mut history = History::default();
        let cut = cut.min(events.len());
        events[..cut].iter().for_each(|event| { play(&mut history, event); });

        let base = history.committed().clone(); // a session starts here, with nothing to undo
        let bytes = project::to_bytes(&base);
        let read = project::from_bytes(&bytes).unwrap();
        prop_assert_eq!(&read, &base, "{}", String::from_utf8_lossy(&bytes));
        prop_assert_eq!(project::to_bytes(&read), bytes, "same document, same bytes");

        let mut history = History::new(base);
        let (mut journal, mut text) = Journal::begin(&read);
        for event in &events[cut..] {
            play(&mut history, event);
            history.take_log().iter().for_each(|action| text.push_str(&journal.line(action)));
        }
        let decoded = journal::decode(text.as_bytes()).unwrap();
        prop_assert_eq!(decoded.damage, None);
        prop_assert_eq!(decoded.whole_bytes, text.len());
        prop_assert_eq!(&decoded.journal, &journal, "ready to go on");
        prop_assert_eq!(&decoded.project, &read);
        let mut recovered = journal::recover(&decoded);
        prop_assert_eq!(recovered.message, None);
        prop_assert_eq!(project::to_bytes(recovered.history.committed()), project::to_bytes(history.committed()));
        prop_assert_eq!(recovered.history.undo_count(), history.undo_count());
        prop_assert_eq!(recovered.history.redo_count(), history.redo_count());
        prop_assert!(recovered.history.take_log().is_empty());
    }
}

#[test]
fn a_long_history_is_cheap() {
    let mut history = History::default();
    let up: Vec<Vec3> = (1..=2000_u16)
        .map(|n| Vec3::new(0.0, f32::from(n) * 0.1, 0.0))
        .collect();
    history.apply(Edit::AddStroke { to: up }).unwrap();
    for step in 1..=1000 {
        history.apply(Edit::SetStep { step }).unwrap();
    }
    let sketch = std::sync::Arc::clone(&history.committed().sketch);
    assert_eq!(
        std::sync::Arc::strong_count(&sketch),
        1002,
        "one sketch in a thousand documents"
    );
    assert_eq!(history.undo_count(), 1001);
}

#[test]
fn rules_of_ones_own_come_back_from_file_and_journal_whatever_they_hold() {
    let text = "const a = 2\n# \u{7}\t\"\\ \u{2028} ü {\"format\":1}\r\n# more";
    let draw = Edit::AddStroke {
        to: vec![Vec3::Y * 0.2, Vec3::Y * 0.4],
    };
    let rule = Edit::SetRule {
        of: String::new(),
        to: Some(text.to_owned()),
    };
    let mut history = History::default();
    history.apply(draw).unwrap();
    history.apply(rule).unwrap();
    let bytes = project::to_bytes(history.committed());
    assert!(bytes.starts_with(b"{\n  \"format\": \"ramus-project\",\n  \"version\": 2,"));
    let read = project::from_bytes(&bytes).unwrap();
    assert_eq!(&read, history.committed());
    let (mut journal, header) = Journal::begin(&read);
    let mut lines = header;
    for action in history.take_log() {
        lines.push_str(&journal.line(&action));
    }
    let decoded = journal::decode(lines.as_bytes()).unwrap();
    assert_eq!((decoded.project, decoded.actions.len()), (read, 2));
    assert_eq!(decoded.damage, None);
}

#[test]
fn rules_kept_by_their_whole_left_side_still_open() {
    let text = r#"{
  "format": "ramus-project", "version": 2, "needs": "0.1.0", "step": 3,
  "selected": {"letter":"A","node":2},
  "platform": {"position":[0.0,0.9,-0.55],"yaw_deg":0.0,"scale":0.25},
  "divergence_deg": 137.508, "scale": 2.0, "tip_radius": 0.02, "radius_exponent": 2.0,
  "wrap": "carry-heading", "self_similar_branches": false,
  "own_rules": {
    "": "const half = divergence / 2",
    "A(x) > A(y) : (x+1) % 1 == 0 || (x+1) % 2 == 0": "A(x) > A(y) : x < 9 -> A(x) C_on_A(x) D_on_A(x)",
    "A(x) > B": "A(x) > B : x < 12 -> A(x) A(x+1)",
    "D_on_A(x)": "D_on_A(x) : x > 5 -> *",
    "D_on_A(x) : (x+1) % 2 == 0": "D_on_A(x) : x == 1 -> [ /(half) D(0) B ]"
  },
  "strokes": [
    {"letter": "A", "attachment": null, "self_similar": null, "points": [[0.0,0.15,0.0],[0.0,0.3,0.0]]},
    {"letter": "C", "attachment": {"letter":"A","node":1}, "self_similar": null, "points": [[0.1,0.1,0.0]]},
    {"letter": "D", "attachment": {"letter":"A","node":2}, "self_similar": null, "points": [[-0.1,0.1,0.0]]}
  ]
}"#;
    let read = project::from_bytes(text.as_bytes()).unwrap();
    let rules = read.sketch.rules_text();
    assert_eq!(read.sketch.own_rules.len(), 5);
    for own in read.sketch.own_rules.values() {
        assert!(rules.contains(own), "{own} in\n{rules}");
    }
    let again = project::from_bytes(&project::to_bytes(&read)).unwrap();
    assert_eq!(again, read);
    // An old journal's line, too.
    let as_drawn = Edit::SetRule {
        of: "D_on_A(x) : (x+1) % 2 == 0".into(),
        to: None,
    };
    let fewer = read.after(&as_drawn).unwrap();
    assert_eq!(fewer.sketch.own_rules.len(), 4);
}
