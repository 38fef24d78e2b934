//! Looks of segments: their numbers written into the tubes' records.

use super::super::tubes::{LETTER_SHIFT, PAINTED, TubeSegment};
use super::super::{NO_PARENT, Tree};
use super::{LookTable, Organs, Paint, Refined};

/// Gives each painted segment the number of its look in the place of its letter. `segments` are those of `tree`, or of the
/// finer tree where there is one.
pub fn paint_segments(
    tree: &Tree,
    organs: &Organs,
    fine: Option<&Refined>,
    segments: &mut [TubeSegment],
    looks: &mut LookTable,
) {
    // Colour 0 may be the grammar's own too.
    if organs.paints.is_empty() && organs.palette.is_bark(Paint::default()) {
        return;
    }
    let (tree, paints) = fine.map_or((tree, &organs.paints), |fine| (&fine.tree, &fine.paints));
    // One record for each node that has a parent.
    let nodes = (0..tree.len()).filter(|node| tree.parent[*node] != NO_PARENT);
    for (node, segment) in nodes.zip(segments) {
        let paint = paints.get(node).copied().unwrap_or_default();
        if organs.palette.is_bark(paint) {
            continue;
        }
        let number = looks.segment(&organs.palette, paint);
        let flags = segment.flags & ((1 << LETTER_SHIFT) - 1);
        segment.flags = flags | PAINTED | number << LETTER_SHIFT;
    }
}

/// The number of a segment's look; `None` where it is bark.
#[must_use]
pub fn look_of(segment: &TubeSegment) -> Option<u32> {
    let number = segment.flags >> LETTER_SHIFT;
    (segment.flags & PAINTED != 0 && number != 0).then_some(number)
}
