//! Models with known skeletons, for tests, where `RAMUS_SHARED` names the folder with `models/MODELS.md`.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "a test that stops says enough by stopping, and trees are in single precision"
)]

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use serde::Deserialize;

use super::{Mesh, MeshError, ReadLimits, read};
use crate::tree::{NO_PARENT, Node, Tree};

fn folder() -> Option<PathBuf> {
    let shared =
        std::env::var_os("RAMUS_SHARED").map(|shared| PathBuf::from(shared).join("models"));
    let found = shared.filter(|folder| folder.is_dir());
    if found.is_none() {
        eprintln!("skipped: RAMUS_SHARED does not name the folder with models");
    }
    found
}

/// A model by its name in a folder of models; None, told, where it is not there or its format is not read.
pub(crate) fn model_of(folder_name: &str, name: &str) -> Option<Mesh> {
    let path = folder()?.join(folder_name).join(name);
    match read(&path, &ReadLimits::default(), &AtomicBool::new(false)) {
        Ok(model) => Some(model.mesh),
        Err(MeshError::In { fault, .. }) if matches!(*fault, MeshError::Unsupported(_)) => {
            eprintln!("skipped: {name}: {fault}");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// A model with a known skeleton.
pub(crate) fn model(name: &str) -> Option<Mesh> {
    model_of("truth", name)
}

fn json<T: for<'a> Deserialize<'a>>(name: &str) -> T {
    let path = folder().unwrap().join("truth").join(name);
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

#[derive(Deserialize)]
pub(crate) struct Skeleton {
    nodes: Vec<DVec3>,
    parent: Vec<i32>,
    radius: Vec<f64>,
}

#[derive(Deserialize)]
pub(crate) struct Seeds {
    pub(crate) source: DVec3,
    pub(crate) targets: Vec<DVec3>,
}

/// The skeleton of a model.
pub(crate) fn skeleton(name: &str) -> Skeleton {
    json(&format!("{name}.skeleton.json"))
}

/// Where its ends are.
pub(crate) fn seeds(name: &str) -> Seeds {
    json(&format!("{name}.seeds.json"))
}

impl Skeleton {
    /// The smallest radius.
    pub(crate) fn thinnest(&self) -> f64 {
        self.radius.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// As a tree; the root is its first node.
    pub(crate) fn tree(&self) -> Tree {
        let mut tree = Tree {
            letters: vec!["truth".to_owned()],
            ..Tree::default()
        };
        let roots = (0..self.nodes.len()).filter(|node| self.parent[*node] < 0);
        let mut open: Vec<(usize, u32)> = roots.map(|root| (root, NO_PARENT)).collect();
        while let Some((node, parent)) = open.pop() {
            let place = tree.push(Node {
                parent,
                position: self.nodes[node].as_vec3(),
                radius: self.radius[node] as f32,
                letter: 0,
                order: 0,
                birth: 0,
            });
            let children = (0..self.nodes.len())
                .filter(|child| usize::try_from(self.parent[*child]) == Ok(node));
            open.extend(children.map(|child| (child, place)));
        }
        tree
    }

    /// How far a point is from the skeleton, and the radius there.
    pub(crate) fn nearest(&self, point: DVec3) -> (f64, f64) {
        let segments = self.parent.iter().enumerate().filter_map(|(node, parent)| {
            let parent = usize::try_from(*parent).ok()?;
            let (from, to) = (self.nodes[parent], self.nodes[node]);
            let along = to - from;
            let part =
                ((point - from).dot(along) / along.length_squared().max(1e-30)).clamp(0.0, 1.0);
            let radius = self.radius[parent] + part * (self.radius[node] - self.radius[parent]);
            Some(((from + part * along).distance(point), radius))
        });
        segments.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }
}
