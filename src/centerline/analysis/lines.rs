//! What is told of each centerline.

use serde::Serialize;

use super::super::Centerline;
use crate::mesh::endpoints::Kind;
use crate::tree::NO_PARENT;

/// A way from the source to a target, or from the root to a tip.
#[derive(Clone, Debug, Serialize)]
pub struct CenterlineFacts {
    /// The target's place among the targets, from 0; null for trees that were read.
    pub target: Option<usize>,
    /// The target's name, or which tip it is.
    pub name: String,
    /// The node that it ends in.
    pub node: u32,
    /// From the first ball to the last; to the middles of open ends where lines go on to them.
    pub length: f64,
    /// The same without the stem: from the first junction on.
    pub length_without_stem: f64,
    /// How far the surface is before the source's ball, straight on; null where it is not known.
    pub root_to_surface: Option<f64>,
    /// How far it is behind the last ball; null where it is not known, and where other lines go on from there.
    pub tip_to_surface: Option<f64>,
    /// From surface to surface; null where one of these is.
    pub length_to_surface: Option<f64>,
}

/// All that lead somewhere, in the order of the targets.
pub(super) fn centerlines(found: &Centerline, stem: f64) -> Vec<CenterlineFacts> {
    let tree = &found.tree;
    let mut along = vec![0.0; tree.len()];
    for node in 0..tree.len() {
        let parent = tree.parent[node];
        if parent != NO_PARENT {
            let [from, to] = [parent as usize, node].map(|one| tree.position[one].as_dvec3());
            along[node] = along[parent as usize] + from.distance(to);
        }
    }
    let row = |target: Option<usize>, name: String, node: u32| {
        let length = along[node as usize];
        let reach = |place: usize| found.to_surface.get(place).copied().flatten();
        let [root, tip] = match target {
            Some(target) => [reach(0), reach(target + 1)],
            None => [None, None],
        };
        CenterlineFacts {
            target,
            name,
            node,
            length,
            length_without_stem: (length - stem).max(0.0),
            root_to_surface: root,
            tip_to_surface: tip,
            length_to_surface: root.zip(tip).map(|(root, tip)| length + root + tip),
        }
    };
    if found.ends.is_empty() {
        let tips = tree.tips().into_iter();
        let tips = tips.filter(|tip| tree.parent[*tip as usize] != NO_PARENT);
        return tips
            .enumerate()
            .map(|(place, tip)| row(None, format!("tip {}", place + 1), tip))
            .collect();
    }
    let targets = found
        .endpoints
        .iter()
        .filter(|endpoint| endpoint.kind == Kind::Target);
    let rows = targets.zip(&found.ends).enumerate();
    rows.filter_map(|(place, (target, end))| Some(row(Some(place), target.name.clone(), (*end)?)))
        .collect()
}
