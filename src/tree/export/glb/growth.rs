//! Growth in a GLB: morph targets of the last steps, and an animation that unfolds one step a second.
//!
//! At rest, all weights 0, the mesh is the whole tree, so that a program that knows no targets shows it. Key *i* of the animation has weight 1 for all steps that are
//! still to come; between two keys one of them falls to 0. Specification: glTF 2.0, §3.7.2.2 and §3.11.

use bytemuck::cast_slice;
use glam::Vec3;
use serde_json::{Value, json};

use super::super::surface::{Group, Surface};
use super::super::unfold;
use super::document::{ARRAY_BUFFER, Document, FLOAT, add};
use super::{Piece, What};

/// An animation's nodes: each with how many targets its mesh has.
#[derive(Default)]
pub(super) struct Animated(Vec<(usize, usize)>);

impl Document {
    /// The targets of a group, and their names.
    pub(super) fn targets(
        &mut self,
        tree: usize,
        surface: &Surface<'_>,
        group: &Group,
    ) -> (Vec<Value>, Vec<String>) {
        let matter = group.matter;
        let Some(unfolding) = &surface.unfolding else {
            return (Vec::new(), Vec::new());
        };
        let mut targets = Vec::new();
        for step in unfolding.steps() {
            let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            unfold::moved(surface, matter, step, |by| {
                (low, high) = (low.min(Vec3::from(by)), high.max(Vec3::from(by)));
            });
            let accessor = json!({
                "componentType": FLOAT, "count": group.vertices, "type": "VEC3",
                "min": low.to_array(), "max": high.to_array(),
            });
            let what = What::Moved(step);
            let piece = Piece::Group { tree, matter, what };
            let column = self.column(piece, 12 * group.vertices, Some(ARRAY_BUFFER), accessor);
            targets.push(json!({ "POSITION": column }));
        }
        let names = unfolding.steps().map(|step| format!("step-{step}"));
        (targets, names.collect())
    }

    /// Says that a node's mesh has so many targets.
    pub(super) fn animates(&mut self, node: usize, targets: usize) {
        if targets > 0 {
            self.animated.0.push((node, targets));
        }
    }

    /// Lets a node move as another one, where that moves.
    pub(super) fn animates_as(&mut self, other: usize, node: usize) {
        let known = self.animated.0.iter().find(|(of, _)| *of == other);
        if let Some((_, targets)) = known.copied() {
            self.animates(node, targets);
        }
    }

    /// The animation of all nodes, if there is any.
    pub(super) fn animation(&mut self) {
        let animated = std::mem::take(&mut self.animated.0);
        let (mut samplers, mut channels): (Vec<Value>, Vec<Value>) = (Vec::new(), Vec::new());
        // Meshes with as many targets share what drives them.
        let mut known: Vec<(usize, usize)> = Vec::new();
        for (node, targets) in animated {
            let sampler = known.iter().find(|(of, _)| *of == targets);
            let sampler = match sampler {
                Some((_, sampler)) => *sampler,
                None => {
                    let sampler = self.sampler(targets);
                    known.push((targets, samplers.len()));
                    add(&mut samplers, sampler)
                }
            };
            channels
                .push(json!({ "sampler": sampler, "target": { "node": node, "path": "weights" } }));
        }
        if !channels.is_empty() {
            self.animations
                .push(json!({ "name": "growth", "samplers": samplers, "channels": channels }));
        }
    }

    /// Weights at whole seconds.
    fn sampler(&mut self, targets: usize) -> Value {
        #[allow(clippy::cast_precision_loss, reason = "few steps")]
        let times: Vec<f32> = (0..=targets).map(|second| second as f32).collect();
        let weights = (0..=targets).flat_map(|key| {
            (0..targets).map(move |target| if target >= key { 1.0_f32 } else { 0.0 })
        });
        let weights: Vec<f32> = weights.collect();
        let scalars =
            |count: usize| json!({ "componentType": FLOAT, "count": count, "type": "SCALAR" });
        let mut input = scalars(times.len());
        input["min"] = json!([0.0]);
        input["max"] = json!(times.last().map(|last| [*last]));
        let bytes = cast_slice(&times).to_vec();
        let input = self.column(Piece::Bytes(bytes), 4 * times.len(), None, input);
        let output = scalars(weights.len());
        let bytes = cast_slice(&weights).to_vec();
        let output = self.column(Piece::Bytes(bytes), 4 * weights.len(), None, output);
        json!({ "input": input, "output": output, "interpolation": "LINEAR" })
    }
}
