//! Workshops with large trees, for the tests and the benchmark of the frame loop.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "shared by binaries that use parts of it; one that stops says enough by stopping"
)]

use glam::Vec3;
use ramus::app::workshop::Workshop;
use ramus::sketch::{Letter, NodeRef};
use ramus::world::World;
use ramus::world::document::Edit;
use ramus::world::history::History;

/// A trunk of so many segments, at step 0.
fn trunk(segments: u8) -> Vec<Edit> {
    let end = |n: u8| Vec3::new(0.0, 0.1 * f32::from(n), 0.0);
    (1..=segments)
        .map(|n| Edit::AddSegment { to: end(n) })
        .collect()
}

/// A branch of one segment at a node of the trunk.
fn branch(node: u8) -> [Edit; 2] {
    let at = NodeRef::new(Letter::TRUNK, u32::from(node));
    let to = Vec3::new(0.05, 0.1 * f32::from(node) + 0.05, 0.0);
    [Edit::Select { at }, Edit::AddSegment { to }]
}

fn after(edits: impl IntoIterator<Item = Edit>) -> Workshop {
    let mut history = History::default();
    for edit in edits {
        history.apply(edit).unwrap();
    }
    Workshop::unsaved(World::new(history)).unwrap()
}

/// A trunk and a branch at its first node, which carries copies of itself: Fib(step + 2) − 1 segments, 75,024 at
/// step 23.
pub fn bushy(step: u32) -> Workshop {
    let mut edits = trunk(2);
    edits.extend(branch(1));
    edits.push(Edit::SetStep { step });
    after(edits)
}

/// A tall trunk with a branch at every node and another at every `second` one, without copies of themselves. The step
/// is set before the last branch is drawn. With 4: 100,001 segments at step 401; with 2: 99,920 at step 366.
pub fn tall(second: u8, step: u32) -> Workshop {
    let mut edits = trunk(5);
    edits.push(Edit::SetSelfSimilarBranches { on: false });
    edits.extend(branch(1));
    edits.push(Edit::SetStep { step });
    edits.extend(branch(second));
    after(edits)
}
