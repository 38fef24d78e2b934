//! The sketch as it stands on the platform: its nodes, lines and marks in stage metres.
//!
//! Kept between frames and made anew only when the sketch or the platform
//! changes, because hover asks for every node in every frame. The vectors keep
//! their capacity, so following a hand allocates nothing here.

use std::{ops::Range, sync::Arc};

use glam::{Affine3A, Vec3};

use crate::sketch::{Letter, NodeRef, Sketch};

use super::{
    document::{Document, Placement},
    scene::{Ball, Color, Rod, Scene},
    stage::{Palette, StageParams, faded, stage_from_sketch},
};

/// A node of the sketch on the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) at: NodeRef,
    /// Metres in the stage.
    pub(super) position: Vec3,
}

/// A node where branches of one letter start.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mark {
    position: Vec3,
    color: Color,
    /// False: drawn here. True: growth repeats it here.
    repeat: bool,
}

/// See the module.
#[derive(Debug, Default)]
pub(super) struct Miniature {
    of: Option<(Arc<Sketch>, Placement)>,
    pub(super) stage_from_sketch: Affine3A,
    pub(super) sketch_from_stage: Affine3A,
    /// The root, then each line's nodes 1, 2, ….
    pub(super) nodes: Vec<Node>,
    /// Each line's share of `nodes`.
    ranges: Vec<(Letter, Range<usize>)>,
    lines: Vec<Rod>,
    marks: Vec<Mark>,
}

impl Miniature {
    /// Follows the document; gives whether anything changed.
    pub(super) fn follow(
        &mut self,
        document: &Document,
        params: &StageParams,
        palette: &Palette,
    ) -> bool {
        if let Some((sketch, placement)) = &self.of
            && Arc::ptr_eq(sketch, &document.sketch)
            && *placement == document.platform
        {
            return false;
        }
        self.of = Some((Arc::clone(&document.sketch), document.platform));
        self.stage_from_sketch = stage_from_sketch(&document.platform);
        self.sketch_from_stage = self.stage_from_sketch.inverse();
        let (stage, sketch) = (self.stage_from_sketch, &*document.sketch);
        self.nodes.clear();
        self.nodes.extend(sketch.nodes().map(|(at, position)| Node {
            at,
            position: stage.transform_point3(position),
        }));
        self.ranges.clear();
        let mut next = 1;
        self.ranges.extend(sketch.strokes.iter().map(|stroke| {
            let first = next;
            next += stroke.points.len();
            (stroke.letter, first..next)
        }));
        self.lines.clear();
        self.lines
            .extend(sketch.segments().map(|(at, from, to)| Rod {
                from: stage.transform_point3(from),
                to: stage.transform_point3(to),
                radius: params.line_radius,
                color: palette.letter(at.letter.index()),
            }));
        self.mark(sketch, palette);
        true
    }

    /// Marks each attachment, and the nodes where growth will repeat it: every n-th of its line.
    fn mark(&mut self, sketch: &Sketch, palette: &Palette) {
        self.marks.clear();
        for stroke in &sketch.strokes {
            let color = palette.letter(stroke.letter.index());
            let own = stroke
                .self_similar
                .map(|own| NodeRef::new(stroke.letter, own.rate));
            let repeats_alone = [false, true];
            for (first, copy) in [stroke.attachment, own].into_iter().zip(repeats_alone) {
                let Some(first) = first.filter(|first| first.node > 0) else {
                    continue;
                };
                let on_line = self.on_line(first.letter);
                let marked = self.nodes.get(on_line).unwrap_or_default().iter();
                let every = marked
                    .skip(first.node as usize - 1)
                    .step_by(first.node as usize);
                self.marks.extend(every.enumerate().map(|(k, node)| Mark {
                    position: node.position,
                    color,
                    repeat: copy || k > 0,
                }));
            }
        }
    }

    /// Which of `nodes` are a letter's nodes 1, 2, …: they stand together, in order.
    fn on_line(&self, letter: Letter) -> Range<usize> {
        let line = self.ranges.iter().find(|(of, _)| *of == letter);
        line.map_or(0..0, |(_, range)| range.clone())
    }

    /// Where a node stands, named as the sketch's own nodes are.
    pub(super) fn position(&self, at: NodeRef) -> Option<Vec3> {
        if at == NodeRef::ROOT {
            return self.nodes.first().map(|root| root.position);
        }
        let index = self
            .on_line(at.letter)
            .nth(at.node.checked_sub(1)? as usize)?;
        self.nodes.get(index).map(|node| node.position)
    }

    /// Draws lines, nodes and marks; `highlights` are the nodes under the hands.
    pub(super) fn draw(
        &self,
        selected: NodeRef,
        highlights: [Option<NodeRef>; 2],
        params: &StageParams,
        palette: &Palette,
        scene: &mut Scene,
    ) {
        scene.rods.extend_from_slice(&self.lines);
        scene.balls.extend(self.nodes.iter().map(|node| Ball {
            center: node.position,
            radius: params.node_radius,
            color: if highlights.contains(&Some(node.at)) {
                palette.hovered
            } else {
                palette.node
            },
        }));
        scene.balls.extend(self.marks.iter().map(|mark| Ball {
            center: mark.position,
            radius: if mark.repeat {
                params.repeat_radius
            } else {
                params.attachment_radius
            },
            color: faded(
                mark.color,
                if mark.repeat {
                    palette.repeat_alpha
                } else {
                    palette.attachment_alpha
                },
            ),
        }));
        if let Some(center) = self.position(selected) {
            scene.balls.push(Ball {
                center,
                radius: params.selected_radius,
                color: palette.selected,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    /// A trunk of seven segments with a branch of three at node 2.
    fn document() -> Document {
        let mut sketch = Sketch::default();
        let mut apex = NodeRef::ROOT;
        for y in 1..=7_u8 {
            (sketch, apex) = sketch
                .add_segment(apex, Vec3::Y * f32::from(y) * 0.1)
                .unwrap();
        }
        let mut at = NodeRef::new(Letter::TRUNK, 2);
        for x in 1..=3_u8 {
            (sketch, at) = sketch
                .add_segment(at, Vec3::new(f32::from(x) * 0.1, 0.2, 0.0))
                .unwrap();
        }
        Document {
            sketch: Arc::new(sketch),
            ..Document::default()
        }
    }

    #[test]
    fn marks_stand_at_attachments_and_their_repeats() {
        let (params, palette) = (StageParams::default(), Palette::default());
        let document = document();
        let mut miniature = Miniature::default();
        assert!(miniature.follow(&document, &params, &palette));
        assert!(
            !miniature.follow(&document, &params, &palette),
            "nothing changed"
        );
        let root = document.platform.position;
        let scale = document.platform.scale;
        let found: Vec<(Vec3, bool)> = miniature
            .marks
            .iter()
            .map(|mark| (mark.position, mark.repeat))
            .collect();
        let expected = [
            (Vec3::new(0.0, 0.2, 0.0), false),
            (Vec3::new(0.0, 0.4, 0.0), true),
            (Vec3::new(0.0, 0.6, 0.0), true),
            // The branch carries itself at its own second node.
            (Vec3::new(0.2, 0.2, 0.0), true),
        ];
        assert_eq!(found.len(), expected.len());
        for ((position, repeat), (wanted, wanted_repeat)) in found.into_iter().zip(expected) {
            assert!(
                position.distance(root + wanted * scale) < 1e-6,
                "{position}"
            );
            assert_eq!(repeat, wanted_repeat, "{position}");
        }
    }

    #[test]
    fn each_node_is_found_by_its_name() {
        let (document, mut miniature) = (document(), Miniature::default());
        miniature.follow(&document, &StageParams::default(), &Palette::default());
        for node in &miniature.nodes {
            assert_eq!(
                miniature.position(node.at),
                Some(node.position),
                "{:?}",
                node.at
            );
        }
        let branch = Letter::from_index(1);
        for none in [
            NodeRef::new(Letter::TRUNK, 8),
            NodeRef::new(branch, 0),
            NodeRef::new(Letter::from_index(2), 1),
        ] {
            assert_eq!(miniature.position(none), None, "{none:?}");
        }
    }

    #[test]
    fn everything_drawn_is_seen() {
        let (params, palette) = (StageParams::default(), Palette::default());
        let document = document();
        let mut miniature = Miniature::default();
        miniature.follow(&document, &params, &palette);
        let mut scene = Scene::default();
        let hovered = NodeRef::new(Letter::TRUNK, 5);
        miniature.draw(
            document.selected,
            [None, Some(hovered)],
            &params,
            &palette,
            &mut scene,
        );
        assert_eq!(scene.rods.len(), 10, "one rod a segment");
        let plain = |color: Color| {
            scene
                .balls
                .iter()
                .filter(|ball| ball.color == color)
                .count()
        };
        assert_eq!(
            (
                plain(palette.node),
                plain(palette.hovered),
                plain(palette.selected)
            ),
            (10, 1, 1)
        );
        assert_ne!(
            scene.rods[0].color, scene.rods[9].color,
            "letters differ in colour"
        );
    }
}
