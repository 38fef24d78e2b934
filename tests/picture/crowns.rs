//! Trees in levels of detail: what the device chooses, and that nobody sees it.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3};
use image::{DynamicImage, RgbaImage};
use ramus::render::{
    Backdrop, Chosen, DrawReport, Eye, Gpu, Offscreen, Renderer, RendererParams, StereoMode,
    TreeState, TreeUpload,
};
use ramus::tree::axes::axis_children;
use ramus::tree::foliage::{Bearing, Dress, kind};
use ramus::tree::levels::kinds::{kind_of, of_tubes, triangles};
use ramus::tree::levels::{Levels, along_axes, cut};
use ramus::tree::tubes::{self, TubeSegment};
use ramus::tree::{Organs, Tree};
use ramus::world::room::Quality;
use ramus::world::scene::weather::{Sway, Wind};
use ramus::world::scene::{PlacedTree, Scene};

use super::support::{device, field, grove, mode, placed, silent};

/// Pixels of these pictures' sides: as fine to the eye as a headset's.
const FINE: u32 = 512;

pub(super) fn params(mode: StereoMode) -> RendererParams {
    RendererParams {
        backdrop: Backdrop::Plain([0.0, 0.0, 0.0, 1.0]),
        direct_segments: usize::MAX,
        direct_levels: usize::MAX,
        ..RendererParams::new(FINE, FINE, mode)
    }
}

/// All of it, whatever that takes.
fn full(mode: StereoMode) -> RendererParams {
    RendererParams {
        error_px: 0.0,
        primitives: 20_000_000,
        ..params(mode)
    }
}

/// 79,000 segments, two metres high.
pub(super) fn large() -> PlacedTree {
    let (tree, before) = grove(10, 99);
    assert!(tree.segment_count() > 30_000);
    placed(tree, before, 99, Affine3A::IDENTITY)
}

/// The same with leaves, some 30,000.
pub(super) fn leafy() -> PlacedTree {
    let (tree, before) = grove(7, 99);
    let mut organs = Organs::default();
    let bears = [("maple", 0.06), ("apple", 0.04)].map(|(name, size)| Bearing {
        size,
        every: 0.05,
        ..Bearing::of(kind(name).unwrap())
    });
    let dress = Dress {
        bears: bears.to_vec(),
        ..Dress::default()
    };
    dress.put_on(&tree, &mut organs, 7, None);
    PlacedTree {
        organs: Arc::new(organs),
        revision: 2,
        ..placed(tree, before, 99, Affine3A::IDENTITY)
    }
}

pub(super) fn from(distance: f32) -> [Eye; 2] {
    let middle = Vec3::new(0.0, 1.2, 0.0);
    let away = Vec3::new(0.3, 0.1, 1.0).normalize() * distance;
    Eye::looking_at(middle + away, middle, field()).pair(0.064)
}

pub(super) fn scene(tree: &PlacedTree) -> Scene {
    Scene {
        tree: Some(tree.clone()),
        ..Scene::default()
    }
}

/// A renderer with something to draw into.
pub(super) struct Stage {
    pub(super) offscreen: Offscreen,
    pub(super) renderer: Renderer,
}

impl Stage {
    pub(super) fn new(gpu: &Gpu, params: &RendererParams) -> Self {
        Self {
            offscreen: Offscreen::new(gpu, params.extent).unwrap(),
            renderer: Renderer::new(gpu, params).unwrap(),
        }
    }

    /// Draws until all is there.
    pub(super) fn draw(&mut self, scene: &Scene, eyes: &[Eye; 2]) -> (DrawReport, Chosen) {
        loop {
            let target = self.offscreen.target();
            let report = self.renderer.draw(scene, eyes, &target).unwrap();
            if report.tree == TreeState::Shown {
                return (report, self.renderer.chosen().unwrap());
            }
        }
    }

    pub(super) fn picture(&self) -> RgbaImage {
        let [left, _] = self.offscreen.read_color().unwrap();
        left
    }
}

fn covered(picture: &RgbaImage) -> f64 {
    let light = |pixel: &image::Rgba<u8>| {
        pixel.0[..3]
            .iter()
            .map(|part| f64::from(*part))
            .sum::<f64>()
    };
    picture.pixels().map(light).sum::<f64>() / (765.0 * f64::from(FINE * FINE))
}

/// 1 where two pictures look the same.
fn likeness(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let [a, b] = [a, b].map(|picture| DynamicImage::ImageRgba8(picture.clone()).to_rgb8());
    image_compare::rgb_hybrid_compare(&a, &b).unwrap().score
}

fn keep(picture: &RgbaImage, name: &str) {
    if let Some(folder) = std::env::var_os("RAMUS_PICTURES") {
        picture
            .save(std::path::Path::new(&folder).join(name))
            .unwrap();
    }
}

fn ordered(tree: &Tree, before: &[f32]) -> Vec<TubeSegment> {
    let mut segments = Vec::new();
    tubes::segments(tree, before, 99, &mut segments);
    let order = along_axes(tree, &axis_children(tree));
    order.iter().map(|at| segments[*at as usize]).collect()
}

#[test]
fn a_large_tree_is_drawn_with_few_triangles_and_looks_the_same() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    let (mut levelled, mut whole) = (
        Stage::new(&gpu, &params(mode)),
        Stage::new(&gpu, &full(mode)),
    );
    for (name, tree, parts) in [
        ("bare", large(), [3, 12, 60]),
        ("leafy", leafy(), [1, 3, 30]),
    ] {
        for (distance, part) in [1.5, 5.0, 40.0].into_iter().zip(parts) {
            let (_, few) = levelled.draw(&scene(&tree), &from(distance));
            let (_, every) = whole.draw(&scene(&tree), &from(distance));
            let (a, b) = (levelled.picture(), whole.picture());
            keep(&a, &format!("{name}-{distance}-levels.png"));
            keep(&b, &format!("{name}-{distance}-full.png"));
            let light = covered(&a) / covered(&b);
            let like = likeness(&a, &b);
            eprintln!(
                "{name} from {distance} m: {} of {} triangles, likeness {like:.4}, light {light:.4}",
                few.triangles, every.triangles
            );
            assert!(
                few.triangles > 0 && few.triangles * part <= every.triangles,
                "{few:?} of {every:?}"
            );
            assert_eq!(few.error_px, 1.0);
            // Leaves of two thirds of a pixel are seen one by one, or eight as one: the crown is some brighter so.
            let most = if distance > 10.0 { 0.10 } else { 0.05 };
            assert!((light - 1.0).abs() < most, "{name} {distance}: {light}");
            assert!(like > 0.95, "{name} {distance}: {like}");
        }
    }
    silent(&gpu);
}

#[test]
fn the_device_chooses_the_clusters_that_its_twin_chooses() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        primitives: 60_000,
        ..params(mode(&gpu))
    };
    let mut stage = Stage::new(&gpu, &params);
    let mut tree = large();
    tree.world_from_tree = Affine3A::from_scale_rotation_translation(
        Vec3::splat(0.8),
        Quat::from_rotation_y(1.0),
        Vec3::new(0.1, 0.1, -0.2),
    );
    let levels = Levels::new(&ordered(&tree.tree, &tree.radius_before));
    let kinds = of_tubes();
    let strong = Wind::Strong.strength();
    for (distance, strength) in [
        (0.4, 0.0),
        (1.0, 0.0),
        (1.0, strong),
        (3.0, 0.0),
        (20.0, 0.0),
        (300.0, strong),
    ] {
        let eyes = from(distance);
        let clock = 0.3;
        stage.renderer.set_sway(Sway { strength, clock });
        let (report, chosen) = stage.draw(&scene(&tree), &eyes);
        assert!(report.draws < 40, "{report:?}");
        let (standing, views) = stage.renderer.choice_of_tree(&tree, &eyes);
        assert_eq!(standing.sway > 0.0, strength > 0.0);
        let looked = |cluster: &ramus::tree::levels::Cluster| {
            let bins = cluster.bins(&standing, &views).unwrap_or([255, 255]);
            let kind = kind_of(
                &kinds,
                standing.pixels(cluster.sphere, cluster.size, &views),
            );
            (bins, kind, triangles(&kinds, cluster, kind))
        };
        let all: Vec<_> = levels.clusters.iter().map(looked).collect();
        let counted = all.iter().map(|(bins, _, triangles)| (*bins, *triangles));
        let threshold = cut::threshold(counted, params.primitives);
        assert_eq!(chosen.error_px, cut::pixels(threshold), "{distance}");
        assert!(chosen.triangles <= u64::from(params.primitives));
        // Kind by kind, in the order of clusters, each whole; then the ends.
        let found = stage.renderer.chosen_batches().unwrap();
        let mut expected: Vec<Vec<u32>> = vec![Vec::new(); kinds.len()];
        for (cluster, (bins, kind, _)) in levels.clusters.iter().zip(&all) {
            if cut::is_drawn(*bins, threshold) {
                let ends = kinds[*kind as usize].ends;
                let runs = [(*kind, cluster.batches), (ends, cluster.ends)];
                for (kind, count) in runs {
                    if let Some(of) = expected.get_mut(kind as usize) {
                        of.extend((cluster.first..cluster.first + count).map(|at| at | kind << 28));
                    }
                }
            }
        }
        let expected: Vec<u32> = expected.concat();
        assert_eq!(found.len(), 1);
        let differing =
            |a: &[u32], b: &[u32]| a.iter().filter(|one| b.binary_search(one).is_err()).count();
        let sorted = |list: &[u32]| {
            let mut list = list.to_vec();
            list.sort_unstable();
            list
        };
        let (a, b) = (sorted(&found[0]), sorted(&expected));
        // Where a number lies at a bin's edge the last bit may differ: a cluster is 8 batches, and its ends.
        assert!(differing(&a, &b) + differing(&b, &a) <= 64, "{distance}");
        assert!(found[0].len() >= 8);
        if differing(&a, &b) == 0 {
            assert_eq!(found[0], expected, "{distance}");
        }
    }
    silent(&gpu);
}

#[test]
fn a_frame_has_no_more_triangles_of_trees_than_its_budget() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    for (tree, primitives) in [(large(), 20_000), (leafy(), 30_000)] {
        let mut stage = Stage::new(
            &gpu,
            &RendererParams {
                primitives,
                ..params(mode)
            },
        );
        for distance in [0.6, 1.5, 3.0] {
            let (_, chosen) = stage.draw(&scene(&tree), &from(distance));
            assert!(
                chosen.triangles <= u64::from(primitives) && chosen.triangles > 2_000,
                "{chosen:?}"
            );
            assert!(chosen.error_px > 1.0);
        }
        // Far enough it does with less.
        let (_, chosen) = stage.draw(&scene(&tree), &from(500.0));
        assert!(
            chosen.triangles < 8_000 && chosen.error_px == 1.0,
            "{chosen:?}"
        );
    }
    silent(&gpu);
}

/// A tree that a frame waits for is shown as it is, and its levels follow, unseen.
#[test]
fn levels_follow_a_tree_that_was_shown_at_once() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        direct_levels: 4_000,
        ..params(mode(&gpu))
    };
    let mut stage = Stage::new(&gpu, &params);
    let tree = large();
    let eyes = from(12.0);
    let (first, whole) = stage.draw(&scene(&tree), &eyes);
    let before = stage.picture();
    assert_eq!(first.plain, None, "it may change again");
    let asked = (0..30).find_map(|_| stage.draw(&scene(&tree), &eyes).0.plain);
    assert_eq!(asked, Some(tree.revision));
    stage
        .renderer
        .set_tree(TreeUpload::new(&gpu, &tree, None).unwrap());
    let target = stage.offscreen.target();
    let report = stage.renderer.draw(&scene(&tree), &eyes, &target).unwrap();
    assert_eq!((report.tree, report.plain), (TreeState::Shown, None));
    let (report, levelled) = stage.draw(&scene(&tree), &eyes);
    assert_eq!((report.tree, report.plain), (TreeState::Shown, None));
    assert!(
        2 * levelled.triangles < whole.triangles,
        "{levelled:?} {whole:?}"
    );
    assert!(likeness(&before, &stage.picture()) > 0.95);
    // Another tree in the meantime: what was prepared for the last one is not wanted any more.
    let other = leafy();
    stage.draw(&scene(&other), &eyes);
    stage
        .renderer
        .set_tree(TreeUpload::new(&gpu, &tree, None).unwrap());
    assert_eq!(
        stage.draw(&scene(&other), &eyes).0.segments,
        other.tree.segment_count() as u32
    );
    silent(&gpu);
}

#[test]
fn a_lighter_picture_has_fewer_triangles() {
    let Some(gpu) = device() else { return };
    let most = Quality::High.primitives();
    let params = RendererParams {
        primitives: most,
        ..params(mode(&gpu))
    };
    let mut stage = Stage::new(&gpu, &params);
    let tree = large();
    let mut counts = Vec::new();
    for quality in Quality::ALL {
        stage
            .renderer
            .set_quality(quality.primitives(), quality.error_px());
        let (report, chosen) = stage.draw(&scene(&tree), &from(3.0));
        let all = chosen.triangles + report.triangles;
        let bound = [750_000, 1_500_000, 4_000_000][quality as usize];
        assert!(all <= bound, "{quality:?}: {all}");
        assert!(report.draws <= 100);
        counts.push(chosen.triangles);
    }
    assert!(
        counts.is_sorted() && counts[0] * 3 < counts[2] * 2,
        "{counts:?}"
    );
    // No more than there is room for.
    stage.renderer.set_quality(u32::MAX, 0.0);
    let (_, chosen) = stage.draw(&scene(&tree), &from(1.0));
    assert!(chosen.triangles <= u64::from(most));
    silent(&gpu);
}

#[test]
fn one_pass_and_one_an_eye_draw_the_same_tree() {
    let Some(gpu) = device() else { return };
    if mode(&gpu) != StereoMode::Multiview {
        eprintln!("skipped: this driver's multiview is broken");
        return;
    }
    let tree = leafy();
    let mut both = Stage::new(&gpu, &params(StereoMode::Multiview));
    let mut each = Stage::new(&gpu, &params(StereoMode::PerEye));
    for distance in [0.8, 6.0] {
        both.draw(&scene(&tree), &from(distance));
        each.draw(&scene(&tree), &from(distance));
        let [a, b] = [&both, &each].map(|stage| stage.offscreen.read_color().unwrap());
        assert!(a[0] == b[0] && a[1] == b[1], "{distance}");
        assert!(a[0] != a[1]);
    }
    silent(&gpu);
}

/// A step towards the tree changes the picture by little, whatever levels it crosses.
#[test]
fn walking_towards_a_tree_shows_no_step() {
    let Some(gpu) = device() else { return };
    let mode = mode(&gpu);
    let (mut levelled, mut whole) = (
        Stage::new(&gpu, &params(mode)),
        Stage::new(&gpu, &full(mode)),
    );
    let tree = leafy();
    let mean = |a: &RgbaImage, b: &RgbaImage| {
        let parts = a.as_raw().iter().zip(b.as_raw());
        parts.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.as_raw().len() as f64
    };
    let mut last: Option<[RgbaImage; 2]> = None;
    let mut chosen = Vec::new();
    let (mut worst, mut sum) = (0.0_f64, [0.0; 2]);
    for step in 0..12 {
        let distance = 8.0 * 0.97_f32.powi(step);
        let (_, few) = levelled.draw(&scene(&tree), &from(distance));
        whole.draw(&scene(&tree), &from(distance));
        chosen.push(few.triangles);
        let now = [levelled.picture(), whole.picture()];
        if let Some(last) = &last {
            let [a, b] = [0, 1].map(|which| mean(&now[which], &last[which]));
            worst = worst.max(a / b);
            sum = [sum[0] + a, sum[1] + b];
        }
        last = Some(now);
    }
    eprintln!(
        "a step changes {:.3} with levels, {:.3} without; at worst {worst:.3} as much; {chosen:?}",
        sum[0] / 11.0,
        sum[1] / 11.0
    );
    assert!(
        chosen.iter().max() > chosen.iter().min(),
        "levels were crossed"
    );
    assert!(worst < 1.3, "{worst}");
    silent(&gpu);
}
