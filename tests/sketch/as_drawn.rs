//! The first copy of each branch stands where it was drawn, whatever the strokes look like.

use super::super::*;

/// Every node of the sketch is found in the tree, at scale, on the first copy of its branch.
fn first_copies_are_as_drawn(sketch: &Sketch, step: u32) {
    let tree = grown(sketch, step).tree;
    // The node that each node of the tree is the first copy of; none: it is a repeat, or stands on one.
    let mut first: Vec<Option<NodeRef>> = Vec::with_capacity(tree.parent.len());
    for (index, &parent) in tree.parent.iter().enumerate() {
        if parent == NO_PARENT {
            first.push(Some(NodeRef::ROOT));
            continue;
        }
        let parent = parent as usize;
        let letter: Letter = tree.letters[usize::from(tree.letter[index])]
            .parse()
            .unwrap();
        let stroke = sketch.stroke(letter).unwrap();
        let same_line = tree.order[parent] == tree.order[index];
        let node = first[parent].and_then(|below| {
            if same_line {
                (below.node < stroke.segments()).then(|| NodeRef::new(letter, below.node + 1))
            } else {
                (stroke.attachment == Some(below)).then_some(NodeRef::new(letter, 1))
            }
        });
        if let Some(node) = node {
            let drawn = sketch.position(node).unwrap() * sketch.scale;
            let gap = (tree.position[index] - drawn).length();
            assert!(
                gap < 1e-5,
                "{node:?} stands {gap} m off\n{}",
                sketch.grammar_text()
            );
        }
        first.push(node);
    }
    let found = first.iter().flatten().count() - 1;
    let segments: usize = sketch
        .strokes
        .iter()
        .map(|stroke| stroke.points.len())
        .sum();
    assert_eq!(
        found,
        segments,
        "every drawn segment has grown\n{}",
        sketch.grammar_text()
    );
}

#[test]
fn upright_hanging_and_folded_strokes_stand_as_drawn() {
    let (up, down, side) = (Vec3::Y * 0.1, Vec3::NEG_Y * 0.1, Vec3::X * 0.1);
    for trunk in [
        [up, up, up],
        [down, down, down],
        [up, down, side],
        [side, -side, up],
    ] {
        for branch in [
            [up, up],
            [down, down],
            [down, up],
            [side, -side],
            [-side, down],
        ] {
            let line = |start: Vec3, moves: &[Vec3]| -> Vec<Vec3> {
                // 2 mm aside at each step, so that folded strokes have no node twice.
                let at = |n: usize| moves[..=n].iter().sum::<Vec3>() + Vec3::Z * 0.002 * n as f32;
                (0..moves.len()).map(|n| start + at(n)).collect()
            };
            let (sketch, _) = Sketch::default()
                .add_segments(NodeRef::ROOT, &line(Vec3::ZERO, &trunk))
                .unwrap();
            let from = NodeRef::new(Letter::TRUNK, 2);
            let start = sketch.position(from).unwrap();
            let (sketch, apex) = sketch.add_segments(from, &line(start, &branch)).unwrap();
            let from = NodeRef::new(apex.letter, 1);
            let start = sketch.position(from).unwrap();
            let (mut sketch, _) = sketch.add_segments(from, &line(start, &branch)).unwrap();
            for index in [1, 2] {
                sketch = sketch.with_self_similar(letter(index), None).unwrap();
            }
            first_copies_are_as_drawn(&sketch, 12);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(64) })]

    #[test]
    fn the_first_branch_stands_where_it_was_drawn(sketch in sketches(), scale in 0.5_f32..4.0) {
        let sketch = sketch.with_sizes(scale, 0.01, 2.0).unwrap();
        // Copies of copies only make it long; those of a first letter stand elsewhere anyway.
        let plain = sketch.strokes.iter().fold(sketch.clone(), |sketch, stroke| {
            sketch.with_self_similar(stroke.letter, None).unwrap()
        });
        first_copies_are_as_drawn(&plain, 24);
    }
}
