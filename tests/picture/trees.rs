//! Trees: joints, growth, and the way of large ones to the device.

use glam::{Affine3A, Vec3};
use ramus::{
    render::{Backdrop, Eye, Offscreen, Renderer, RendererParams, TreeState, TreeUpload},
    tree::{NO_PARENT, Tree, axes::axis_children, levels::along_axes, tubes::TubeSegment},
    world::scene::{PlacedTree, Scene},
};

use super::support::{SIDE, ahead, device, field, grove, mode, placed, plain, shoot, silent};

/// A trunk that bends and tapers; every row of the picture crosses it once.
fn bent(newest: u32) -> PlacedTree {
    let mut tree = Tree {
        letters: vec!["A".to_owned()],
        ..Tree::default()
    };
    for i in 0..9_u32 {
        let t = i as f32 / 8.0;
        tree.parent.push(if i == 0 { NO_PARENT } else { i - 1 });
        tree.position.push(Vec3::new(
            if i % 2 == 0 { -0.11 } else { 0.11 },
            -0.45 + 0.9 * t,
            0.08 * (t * 9.0).sin(),
        ));
        tree.radius.push(0.10 - 0.055 * t);
        tree.letter.push(0);
        tree.order.push(0);
        tree.birth.push(i);
    }
    let before = tree.radius.iter().map(|radius| radius * 0.6).collect();
    placed(tree, before, newest, Affine3A::IDENTITY)
}

#[test]
fn joints_have_no_cracks() {
    let Some(gpu) = device() else { return };
    let magenta = [1.0, 0.0, 1.0, 1.0];
    for (newest, growth) in [(99, 1.0), (5, 1.0), (5, 0.5), (1, 0.37)] {
        let mut tree = bent(newest);
        tree.growth = growth;
        let scene = Scene {
            tree: Some(tree),
            ..Scene::default()
        };
        let params = RendererParams {
            backdrop: Backdrop::Plain(magenta),
            ..RendererParams::new(SIDE, SIDE, mode(&gpu))
        };
        let shot = shoot(&gpu, &params, &scene, &ahead(1.2));
        for picture in &shot.color {
            let mut rows = 0;
            for y in 0..SIDE {
                // Anything that the background shines through counts as a hole: bark is less blue than green, magenta is not.
                let bark = |x: &u32| {
                    i32::from(picture.get_pixel(*x, y).0[2])
                        - i32::from(picture.get_pixel(*x, y).0[1])
                        < 30
                };
                let solid: Vec<u32> = (0..SIDE).filter(bark).collect();
                let (Some(first), Some(last)) = (solid.first(), solid.last()) else {
                    continue;
                };
                rows += 1;
                assert_eq!(
                    solid.len() as u32,
                    last - first + 1,
                    "a hole in row {y} at growth {growth} (newest {newest})"
                );
            }
            assert!(rows > 20, "{rows} rows of trunk");
        }
    }
    silent(&gpu);
}

/// Pixels whose depths differ by more than rounding.
fn differing(a: &[f32], b: &[f32]) -> usize {
    a.iter()
        .zip(b)
        .filter(|(a, b)| (*a - *b).abs() > 1e-6 + a.abs() * 1e-5)
        .count()
}

#[test]
fn growth_runs_from_the_step_before_to_the_whole_tree() {
    let Some(gpu) = device() else { return };
    // In full detail: levels differ where other segments grow.
    let params = RendererParams {
        error_px: 0.0,
        backdrop: Backdrop::Plain([0.3, 0.3, 0.3, 1.0]),
        ..RendererParams::new(2 * SIDE, 2 * SIDE, mode(&gpu))
    };
    let eyes =
        Eye::looking_at(Vec3::new(0.6, 1.0, 2.2), Vec3::new(0.0, 1.0, 0.0), field()).pair(0.064);
    let depth = |tree: PlacedTree| {
        shoot(
            &gpu,
            &params,
            &Scene {
                tree: Some(tree),
                ..Scene::default()
            },
            &eyes,
        )
        .depth
    };
    let at = |growth: f32| {
        let (tree, before) = grove(4, 4);
        PlacedTree {
            growth,
            ..placed(tree, before, 4, Affine3A::IDENTITY)
        }
    };
    // One step earlier: the nodes born before, at the radii they had.
    let (mut earlier, before) = grove(4, 4);
    let kept: Vec<usize> = (0..earlier.len())
        .filter(|node| earlier.birth[*node] < 4)
        .collect();
    let number = |node: u32| {
        kept.iter()
            .position(|old| *old == node as usize)
            .map_or(NO_PARENT, |new| new as u32)
    };
    earlier = Tree {
        parent: kept
            .iter()
            .map(|node| {
                if earlier.parent[*node] == NO_PARENT {
                    NO_PARENT
                } else {
                    number(earlier.parent[*node])
                }
            })
            .collect(),
        position: kept.iter().map(|node| earlier.position[*node]).collect(),
        radius: kept.iter().map(|node| before[*node]).collect(),
        letter: kept.iter().map(|node| earlier.letter[*node]).collect(),
        order: kept.iter().map(|node| earlier.order[*node]).collect(),
        birth: kept.iter().map(|node| earlier.birth[*node]).collect(),
        letters: earlier.letters,
    };
    earlier.validate().unwrap();
    let earlier = depth(placed(earlier, Vec::new(), 99, Affine3A::IDENTITY));
    let begun = depth(at(0.0));
    let half = depth(at(0.5));
    let whole = depth(at(1.0));
    let (tree, _) = grove(4, 4);
    let still = depth(placed(tree, Vec::new(), 99, Affine3A::IDENTITY));
    for eye in 0..2 {
        // Shared rings bend towards the segments that are about to grow, and tips lose their caps: a few pixels.
        let differ = differing(&begun[eye], &earlier[eye]);
        let trunk = earlier[eye].iter().filter(|depth| **depth > 0.0).count();
        assert!(
            trunk > 300 && differ * 50 < trunk,
            "growth 0: {differ} of {trunk} pixels differ from the step before"
        );
        assert_eq!(
            differing(&whole[eye], &still[eye]),
            0,
            "growth 1 is the whole tree"
        );
        let covered = |depth: &[f32]| depth.iter().filter(|depth| **depth > 0.0).count();
        let [a, b, c] = [
            covered(&begun[eye]),
            covered(&half[eye]),
            covered(&whole[eye]),
        ];
        assert!(a < b && b < c, "it grows: {a} {b} {c}");
    }
    silent(&gpu);
}

#[test]
fn large_trees_come_from_a_worker_and_in_chunks() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    let (tree, before) = grove(5, 5);
    let scene = Scene {
        tree: Some(placed(tree, before, 5, Affine3A::IDENTITY)),
        ..Scene::default()
    };
    let tree = scene.tree.clone().unwrap();
    let eyes =
        Eye::looking_at(Vec3::new(0.0, 1.4, 4.0), Vec3::new(0.0, 1.3, 0.0), field()).pair(0.064);
    let whole = shoot(&gpu, &plain(mode, 0.3), &scene, &eyes);

    let params = RendererParams {
        direct_segments: 10,
        ..plain(mode, 0.3)
    };
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let draw = |renderer: &mut Renderer, scene: &Scene| {
        renderer.draw(scene, &eyes, &offscreen.target()).unwrap()
    };
    let report = draw(&mut renderer, &scene);
    assert_eq!((report.tree, report.segments), (TreeState::Wanted(1), 0));

    let worker = gpu.clone();
    let upload = std::thread::spawn(move || {
        let mut segments = Vec::new();
        ramus::tree::tubes::segments(&tree.tree, &tree.radius_before, tree.newest, &mut segments);
        let order = along_axes(&tree.tree, &axis_children(&tree.tree));
        let ordered: Vec<TubeSegment> = order.iter().map(|at| segments[*at as usize]).collect();
        // 1,000 bytes: one cluster a chunk.
        TreeUpload::in_chunks(&worker, &ordered, tree.revision, 1000).unwrap()
    });
    renderer.set_tree(upload.join().unwrap());
    let report = draw(&mut renderer, &scene);
    assert_eq!(report.tree, TreeState::Shown);
    assert!(
        report.segments > 300 && report.draws > 4 * report.segments.div_ceil(64),
        "{report:?}"
    );
    let chunked = offscreen.read_color().unwrap();
    assert!(
        chunked[0] == whole.color[0] && chunked[1] == whole.color[1],
        "chunks change nothing"
    );

    // A new revision that is not there yet: the old tree stays; without a tree it goes.
    let mut later = scene.clone();
    later.tree.as_mut().unwrap().revision = 2;
    let report = draw(&mut renderer, &later);
    assert_eq!(report.tree, TreeState::Wanted(2));
    assert!(
        report.segments > 300,
        "the last tree is shown until the next is there"
    );
    let report = draw(&mut renderer, &Scene::default());
    assert_eq!((report.tree, report.segments), (TreeState::None, 0));
    drop(renderer);
    silent(&gpu);
}
