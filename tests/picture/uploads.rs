//! What goes to the device when a tree changes: what changed.

use std::sync::Arc;

use glam::Vec3;
use ramus::render::{Gpu, RendererParams, TreeState, TreeUpload};
use ramus::tree::{Node, Tree};
use ramus::world::scene::PlacedTree;

use super::crowns::{Stage, from, large, leafy, params, scene};
use super::support::{device, mode, silent};

/// The next tree.
fn after(tree: &PlacedTree, change: impl Fn(&mut Tree)) -> PlacedTree {
    let mut changed = (*tree.tree).clone();
    change(&mut changed);
    changed.validate().unwrap();
    let mut before = (*tree.radius_before).clone();
    before.extend(changed.radius.iter().skip(before.len()));
    PlacedTree {
        tree: Arc::new(changed),
        radius_before: Arc::new(before),
        revision: tree.revision + 1,
        ..tree.clone()
    }
}

/// Branches of so many new segments each on nodes all over a tree.
fn branches(tree: &mut Tree, on: impl Iterator<Item = u32>, segments: u32, birth: u32) {
    for mut parent in on {
        for _ in 0..segments {
            let foot = tree.position[parent as usize];
            tree.push(Node {
                parent,
                position: foot + Vec3::new(0.01, 0.02, 0.005),
                radius: 0.002,
                order: 3,
                letter: 0,
                birth,
            });
            parent = tree.len() as u32 - 1;
        }
    }
}

/// What is seen of a tree by a renderer that never saw another one.
fn anew(gpu: &Gpu, params: &RendererParams, tree: &PlacedTree) -> image::RgbaImage {
    let mut stage = Stage::new(gpu, params);
    stage.draw(&scene(tree), &from(4.0));
    stage.picture()
}

#[test]
fn an_edit_sends_what_changed() {
    let Some(gpu) = device() else { return };
    let params = params(mode(&gpu));
    // Of a small tree, a run of clusters is a large part.
    for (name, tree, part) in [("bare", large(), 10), ("leafy", leafy(), 3)] {
        let mut stage = Stage::new(&gpu, &params);
        let all = stage.draw(&scene(&tree), &from(4.0)).0.sent;
        assert_eq!(stage.draw(&scene(&tree), &from(4.0)).0.sent, 0);
        let middle = tree.tree.len() as u32 / 2;
        let moved = after(&tree, |tree| {
            tree.position[middle as usize] += Vec3::new(0.05, 0.0, 0.0);
        });
        let longer = after(&moved, |tree| {
            branches(tree, std::iter::once(middle), 30, 0)
        });
        let back = PlacedTree {
            revision: 100,
            ..tree.clone()
        };
        for (what, tree) in [("moved", moved), ("longer", longer), ("back", back)] {
            let sent = stage.draw(&scene(&tree), &from(4.0)).0.sent;
            eprintln!("{name}, {what}: {sent} of {all} bytes");
            assert!(
                sent > 0 && sent * part < all,
                "{name} {what}: {sent} of {all}"
            );
            assert!(
                stage.picture() == anew(&gpu, &params, &tree),
                "{name} {what}"
            );
        }
    }
    silent(&gpu);
}

/// Where a step makes nothing thicker, it sends what is new.
#[test]
fn a_step_of_growth_sends_what_is_new() {
    let Some(gpu) = device() else { return };
    let params = params(mode(&gpu));
    let mut stage = Stage::new(&gpu, &params);
    let tree = PlacedTree {
        growth: 0.5,
        ..large()
    };
    let all = stage.draw(&scene(&tree), &from(4.0)).0.sent;
    let last = tree.tree.len() as u32;
    let grown = after(&tree, |tree| branches(tree, last - 300..last, 2, 99));
    let sent = stage.draw(&scene(&grown), &from(4.0)).0.sent;
    eprintln!("{sent} of {all} bytes");
    assert!(sent * 8 < all, "{sent} of {all}");
    assert!(stage.picture() == anew(&gpu, &params, &grown));
    silent(&gpu);
}

/// Levels that follow a tree which was shown without send these alone; and a worker may be late with them.
#[test]
fn levels_that_follow_send_themselves_alone() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        direct_levels: 4_000,
        ..params(mode(&gpu))
    };
    let mut stage = Stage::new(&gpu, &params);
    let tree = large();
    let plain = stage.draw(&scene(&tree), &from(4.0)).0.sent;
    let levels = TreeUpload::new(&gpu, &tree, stage.renderer.resident()).unwrap();
    let alone = TreeUpload::new(&gpu, &tree, None).unwrap().sent();
    // Coarser levels are as much again, and clusters go as a whole.
    assert!(
        levels.sent() < alone * 11 / 20,
        "{} of {alone}",
        levels.sent()
    );
    assert!(plain < alone * 11 / 20, "{plain} of {alone}");
    // Meanwhile others were shown, and the one that it is copied from is gone.
    let other = leafy();
    for _ in 0..4 {
        stage.draw(&scene(&other), &from(4.0));
    }
    let again = PlacedTree {
        revision: levels.revision(),
        ..tree
    };
    stage.renderer.set_tree(levels);
    let (report, _) = stage.draw(&scene(&again), &from(4.0));
    assert_eq!(report.tree, TreeState::Shown);
    let params = RendererParams {
        direct_levels: usize::MAX,
        ..params
    };
    assert!(stage.picture() == anew(&gpu, &params, &again));
    silent(&gpu);
}
