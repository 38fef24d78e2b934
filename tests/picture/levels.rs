//! Models in levels of detail: what the device chooses, and that nobody sees it.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Vec3, Vec4};
use image::{DynamicImage, RgbaImage};
use ramus::mesh::Mesh;
use ramus::mesh::display::Display;
use ramus::mesh::levels::Levels;
use ramus::render::{
    Backdrop, Chosen, Eye, Gpu, ModelUpload, Offscreen, Renderer, RendererParams, StereoMode,
};
use ramus::tree::levels::cut;
use ramus::world::scene::{ModelLook, PlacedModel, Scene, SurfaceLook, new_revision};

use super::support::{ahead, device, mode, silent};

/// Pixels of these pictures' sides: as fine to the eye as a headset's.
const FINE: u32 = 512;
const RADIUS: f32 = 0.3;
const DISTANCE: f32 = 1.0;

/// A ball with lumps and fine relief, of `rows` × 2 `rows` quads.
fn lumpy(rows: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..2 * rows {
            let down = PI * row as f32 / rows as f32;
            let round = TAU * column as f32 / (2 * rows) as f32;
            let away = Vec3::new(
                down.sin() * round.sin(),
                down.cos(),
                down.sin() * round.cos(),
            );
            let lump = (7.0 * away.x).sin() * (9.0 * away.y).sin() * (8.0 * away.z).sin();
            let fine = (90.0 * away.x).sin() * (80.0 * away.y).sin();
            let radius = RADIUS * (1.0 + 0.1 * lump + 0.002 * fine);
            mesh.positions.push(away * radius);
        }
    }
    let at = |row: u32, column: u32| row * 2 * rows + column % (2 * rows);
    for row in 0..rows {
        for column in 0..2 * rows {
            let (a, b) = (at(row, column), at(row, column + 1));
            let (c, d) = (at(row + 1, column), at(row + 1, column + 1));
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    mesh
}

/// One of 2.25 million triangles, made once.
fn large() -> &'static Arc<Display> {
    static LARGE: OnceLock<Arc<Display>> = OnceLock::new();
    LARGE.get_or_init(|| display(lumpy(750)))
}

/// One of 144,000 triangles.
fn small() -> &'static Arc<Display> {
    static SMALL: OnceLock<Arc<Display>> = OnceLock::new();
    SMALL.get_or_init(|| display(lumpy(190)))
}

fn display(mesh: Mesh) -> Arc<Display> {
    Arc::new(Display::new(Arc::new(mesh), None, &AtomicBool::new(false)).unwrap())
}

/// The same without coarser levels: all triangles are drawn.
fn whole(display: &Display) -> Arc<Display> {
    let levels = &display.levels;
    let mut clusters = levels.clusters[..levels.finest].to_vec();
    for cluster in &mut clusters {
        (cluster.parent_error, cluster.parent_grain) = (-1.0, -1.0);
    }
    let count = clusters.last().map_or(0, |last| last.triangles().end);
    Arc::new(Display {
        levels: Arc::new(Levels {
            triangles: levels.triangles[..count].to_vec(),
            stands_for: levels.stands_for[..count].to_vec(),
            finest: clusters.len(),
            clusters,
        }),
        ..display.clone()
    })
}

fn placed(display: &Arc<Display>, change: impl FnOnce(&mut ModelLook)) -> PlacedModel {
    let mut look = ModelLook::default();
    change(&mut look);
    PlacedModel {
        display: Arc::clone(display),
        revision: new_revision(),
        world_from_model: Affine3A::IDENTITY,
        look,
    }
}

fn scene(models: impl IntoIterator<Item = PlacedModel>) -> Scene {
    Scene {
        models: models.into_iter().collect(),
        ..Scene::default()
    }
}

fn params(mode: StereoMode) -> RendererParams {
    RendererParams {
        backdrop: Backdrop::Plain([0.0, 0.0, 0.0, 1.0]),
        direct_triangles: usize::MAX,
        primitives: 3_000_000,
        ..RendererParams::new(FINE, FINE, mode)
    }
}

/// A renderer with something to draw into.
struct Stage {
    offscreen: Offscreen,
    renderer: Renderer,
}

impl Stage {
    fn new(gpu: &Gpu, params: &RendererParams) -> Self {
        Self {
            offscreen: Offscreen::new(gpu, params.extent).unwrap(),
            renderer: Renderer::new(gpu, params).unwrap(),
        }
    }

    /// Draws until all is there; what was chosen, and what else was drawn.
    fn draw(&mut self, scene: &Scene, eyes: &[Eye; 2]) -> (Chosen, u64) {
        loop {
            let target = self.offscreen.target();
            let report = self.renderer.draw(scene, eyes, &target).unwrap();
            if self.renderer.has_models(scene) {
                return (self.renderer.chosen().unwrap(), report.triangles);
            }
        }
    }

    fn picture(&mut self, scene: &Scene, eyes: &[Eye; 2]) -> RgbaImage {
        self.draw(scene, eyes);
        let [left, _] = self.offscreen.read_color().unwrap();
        left
    }
}

fn covered(picture: &RgbaImage) -> usize {
    let is = |pixel: &&image::Rgba<u8>| pixel.0[..3].iter().any(|&part| part > 6);
    picture.pixels().filter(is).count()
}

/// Mean difference of all channels of all pixels, in steps of 255.
fn mean_difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let sum: u64 = a
        .as_raw()
        .iter()
        .zip(b.as_raw())
        .map(|(a, b)| u64::from(a.abs_diff(*b)))
        .sum();
    sum as f64 / a.as_raw().len() as f64
}

/// 1 where two pictures look the same.
fn likeness(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let [a, b] = [a, b].map(|picture| DynamicImage::ImageRgba8(picture.clone()).to_rgb8());
    image_compare::rgb_hybrid_compare(&a, &b).unwrap().score
}

#[test]
fn a_large_model_is_drawn_with_few_triangles_and_looks_the_same() {
    let Some(gpu) = device() else { return };
    let mut stage = Stage::new(&gpu, &params(mode(&gpu)));
    let eyes = ahead(DISTANCE);
    let triangles = large().mesh.triangles.len() as u64;
    assert!(triangles > 2_000_000);
    let shaded = scene([placed(large(), |_| ())]);
    let (chosen, others) = stage.draw(&shaded, &eyes);
    let [levelled, _] = stage.offscreen.read_color().unwrap();
    let depth = stage.offscreen.read_depth().unwrap();
    assert!(
        chosen.triangles > 1_000 && chosen.triangles + others < 200_000,
        "{chosen:?}"
    );
    assert_eq!(chosen.error_px, 1.0);
    let all = scene([placed(&whole(large()), |_| ())]);
    let (every, _) = stage.draw(&all, &eyes);
    let [full, _] = stage.offscreen.read_color().unwrap();
    let full_depth = stage.offscreen.read_depth().unwrap();
    assert!(
        every.triangles > 3 * triangles / 4,
        "what is in sight: {every:?}"
    );
    let (a, b) = (covered(&levelled) as f64, covered(&full) as f64);
    eprintln!(
        "{} of {} triangles; likeness {:.4}, mean difference {:.3}, covered {a} and {b}",
        chosen.triangles,
        every.triangles,
        likeness(&levelled, &full),
        mean_difference(&levelled, &full)
    );
    if let Some(folder) = std::env::var_os("RAMUS_PICTURES") {
        let folder = std::path::Path::new(&folder);
        levelled.save(folder.join("levelled.png")).unwrap();
        full.save(folder.join("full.png")).unwrap();
    }
    assert!((a / b - 1.0).abs() < 0.002, "{a} {b}");
    assert!(likeness(&levelled, &full) > 0.985);
    assert!(mean_difference(&levelled, &full) < 0.6);
    // No hole: each pixel shows what all triangles show there or beside it.
    let at = |x: i32, y: i32| {
        let inside = |v: i32| usize::try_from(v.clamp(0, FINE as i32 - 1)).unwrap();
        full_depth[0][inside(y) * FINE as usize + inside(x)]
    };
    for (number, there) in (0..).zip(&depth[0]) {
        let (x, y) = (number % FINE as i32, number / FINE as i32);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        let (low, high) = around
            .map(|(x, y)| at(x, y))
            .fold((f32::MAX, 0.0_f32), |(low, high), d| {
                (low.min(d), high.max(d))
            });
        let fits = (0.99 * low..=1.01 * high).contains(there);
        assert!(fits, "{x} {y}: {there} of {low} to {high}");
    }
    silent(&gpu);
}

#[test]
fn a_frame_never_hands_over_more_than_its_budget() {
    let Some(gpu) = device() else { return };
    // As the workshop has it.
    let params = RendererParams {
        primitives: RendererParams::new(1, 1, StereoMode::Multiview).primitives,
        ..params(mode(&gpu))
    };
    let mut stage = Stage::new(&gpu, &params);
    // Each triangle counts where edges are drawn, so near to the eye a large model would be drawn whole.
    let everything = |look: &mut ModelLook| (look.wireframe, look.vertices) = (true, true);
    let mut most = 0;
    for distance in [0.31, 0.5, 1.0, 3.0, 30.0] {
        let (chosen, others) = stage.draw(&scene([placed(large(), everything)]), &ahead(distance));
        assert!(
            chosen.triangles + others <= 1_500_000,
            "{distance}: {chosen:?} {others}"
        );
        most = most.max(chosen.triangles);
    }
    assert!(
        most > 300_000,
        "the budget is used where it is wanted: {most}"
    );
    // Eight of them, and a budget that they must share.
    let mut few = Stage::new(
        &gpu,
        &RendererParams {
            primitives: 60_000,
            ..params
        },
    );
    let eight = (0..8).map(|number| {
        let mut model = placed(small(), |look| look.wireframe = true);
        model.world_from_model.translation.x = 0.2 * number as f32 - 0.7;
        model
    });
    let (chosen, _) = few.draw(&scene(eight), &ahead(DISTANCE));
    assert!((20_000..=60_000).contains(&chosen.triangles), "{chosen:?}");
    assert!(chosen.error_px > 1.0);
    silent(&gpu);
}

#[test]
fn the_device_chooses_what_its_twin_chooses() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        primitives: 30_000,
        ..params(mode(&gpu))
    };
    let mut stage = Stage::new(&gpu, &params);
    let cut_open = |look: &mut ModelLook| look.cut = Some(Vec4::new(0.6, 0.0, 0.8, 0.1));
    let mut edged = placed(small(), |look| look.wireframe = true);
    edged.world_from_model = Affine3A::from_scale_rotation_translation(
        Vec3::splat(2.0),
        glam::Quat::from_rotation_y(1.0),
        Vec3::new(0.5, 0.1, -1.0),
    );
    // Of one mesh and one look, farther away: one draw shows both.
    let open = placed(small(), cut_open);
    let behind = PlacedModel {
        world_from_model: Affine3A::from_translation(Vec3::new(-0.6, 0.2, -3.0)),
        ..open.clone()
    };
    let shown = scene([open, behind, edged]);
    for distance in [0.35, 0.9, 6.0] {
        let eyes = ahead(distance);
        let (chosen, _) = stage.draw(&shown, &eyes);
        let found = stage.renderer.chosen_triangles(&shown).unwrap();
        let drawn: usize = found.iter().map(Vec::len).sum();
        assert_eq!(drawn as u64, chosen.triangles);
        let mut counted = Vec::new();
        for placed in &shown.models {
            let (standing, views) = stage.renderer.choice_of(placed, &eyes);
            let levels = &placed.display.levels;
            counted.extend(levels.clusters.iter().map(|cluster| {
                let bins = cluster.bins(&standing, &views);
                (bins.unwrap_or([255, 255]), cluster.count)
            }));
        }
        let threshold = cut::threshold(counted.iter().copied(), params.primitives);
        let mut expected = counted
            .iter()
            .map(|(bins, _)| cut::is_drawn(*bins, threshold));
        let mut differing = 0;
        for (placed, found) in shown.models.iter().zip(found) {
            // In the order of clusters, each whole.
            let mut found = found.into_iter().peekable();
            for cluster in &placed.display.levels.clusters {
                let is = found.peek() == Some(&cluster.first);
                if is {
                    let run = found.by_ref().take(cluster.count as usize);
                    assert!(run.eq(cluster.first..cluster.first + cluster.count));
                }
                differing += usize::from(is != expected.next().unwrap());
            }
            assert_eq!(found.next(), None, "nothing else is drawn");
        }
        // Where a number lies at a bin's edge the last bit may differ.
        assert!(differing <= 4, "{differing} at {distance}");
        assert_eq!(chosen.error_px, cut::pixels(threshold), "{distance}");
    }
    silent(&gpu);
}

#[test]
fn coming_nearer_slowly_shows_no_step() {
    let Some(gpu) = device() else { return };
    let mut stage = Stage::new(&gpu, &params(mode(&gpu)));
    let levelled = scene([placed(small(), |_| ())]);
    let full = scene([placed(&whole(small()), |_| ())]);
    // Both stay on the device in turn: two renderers, so that nothing is uploaded again.
    let mut other = Stage::new(&gpu, &params(mode(&gpu)));
    let mut worst: f64 = 0.0;
    let mut changes = 0;
    // From afar to close by, here and there a step that only somebody who runs makes in a frame.
    for stop in 0..16 {
        let distance = 6.0 * 0.84_f32.powi(stop);
        let mut at = |distance: f32| {
            let eyes = ahead(distance);
            let pictures = [stage.picture(&levelled, &eyes), other.picture(&full, &eyes)];
            (pictures, stage.renderer.chosen().unwrap().triangles)
        };
        let ([before, full_before], count_before) = at(distance);
        let ([now, full_now], count) = at(0.97 * distance);
        changes += usize::from(count != count_before);
        let step = mean_difference(&now, &before);
        let whole_step = mean_difference(&full_now, &full_before);
        eprintln!("{distance}: {count_before} → {count}: {step:.3} {whole_step:.3}");
        worst = worst.max(step - whole_step);
        assert!(step < whole_step + 0.06, "{distance}: {step} {whole_step}");
    }
    eprintln!("worst step over that of all triangles: {worst:.4}; {changes} changes");
    assert!(changes >= 4, "the choice changes on the way: {changes}");
    silent(&gpu);
}

#[test]
fn edges_colours_and_flat_faces_are_coarser_only_where_triangles_are_dots() {
    let Some(gpu) = device() else { return };
    let mut stage = Stage::new(&gpu, &params(mode(&gpu)));
    let count = small().mesh.triangles.len();
    let stripes = (0..count).map(|n| [[230, 40, 40, 255], [40, 60, 230, 255]][n / 3_000 % 2]);
    let coloured = Arc::new(small().coloured(stripes.collect()));
    let plain = |_: &mut ModelLook| ();
    let flat = |look: &mut ModelLook| look.flat = true;
    let edged = |look: &mut ModelLook| look.wireframe = true;
    let mut chosen = |model: PlacedModel, distance: f32| {
        let scene = scene([model]);
        let chosen = stage.draw(&scene, &ahead(distance)).0;
        (chosen.triangles, stage.offscreen.read_color().unwrap())
    };
    let smooth = chosen(placed(small(), plain), 1.0).0;
    for model in [
        placed(small(), flat),
        placed(small(), edged),
        placed(&coloured, plain),
    ] {
        let all = PlacedModel {
            display: whole(&model.display),
            revision: new_revision(),
            ..model.clone()
        };
        let (near, near_picture) = chosen(model.clone(), 0.42);
        let (every, every_picture) = chosen(all.clone(), 0.42);
        assert!(
            near == every && near_picture == every_picture,
            "{near} {every}"
        );
        let (middle, picture) = chosen(model.clone(), 2.5);
        let (every, every_picture) = chosen(all, 2.5);
        assert!(middle < every, "{middle} {every}");
        let like = likeness(&picture[0], &every_picture[0]);
        eprintln!("{middle} of {every}: {like}");
        assert!(like > 0.97, "{like}");
        let (far, _) = chosen(model.clone(), 8.0);
        assert!(far < middle / 3, "{far} {middle}");
        assert!(chosen(model, 1.0).0 > 2 * smooth);
    }
    silent(&gpu);
}

#[test]
fn one_pass_and_one_an_eye_choose_the_same_and_what_is_seen_through_is_the_same_each_time() {
    let Some(gpu) = device() else { return };
    let x_ray = |look: &mut ModelLook| look.surface = Some(SurfaceLook::XRay);
    let mut beside = placed(small(), |look| {
        (look.wireframe, look.vertices) = (true, true)
    });
    beside.world_from_model.translation.x = 0.4;
    let shown = scene([placed(small(), x_ray), beside]);
    let eyes = ahead(DISTANCE);
    let draw = |mode: StereoMode| {
        let mut stage = Stage::new(&gpu, &params(mode));
        stage.draw(&shown, &eyes);
        stage.draw(&shown, &eyes);
        stage.offscreen.read_color().unwrap()
    };
    let one = draw(mode(&gpu));
    assert!(one == draw(mode(&gpu)), "twice the same");
    assert!(one == draw(StereoMode::PerEye), "one pass an eye");
    silent(&gpu);
}

#[test]
fn what_neither_eye_sees_or_is_cut_away_is_not_handed_over() {
    let Some(gpu) = device() else { return };
    let mut stage = Stage::new(&gpu, &params(mode(&gpu)));
    let mut count = |cut: Option<Vec4>, eyes: [Eye; 2]| {
        let model = placed(&whole(small()), |look| look.cut = cut);
        stage.draw(&scene([model]), &eyes).0.triangles
    };
    // Those at the poles are points, which nobody sees.
    let all = whole(small()).levels.triangles.len() as u64;
    assert_eq!(count(None, ahead(2.0)), all);
    let half = count(Some(Vec4::new(0.0, 0.0, 1.0, 0.0)), ahead(2.0));
    assert!((45..60).contains(&(100 * half / all)), "{half}");
    assert_eq!(count(Some(Vec4::new(0.0, 1.0, 0.0, -2.0)), ahead(2.0)), 0);
    let away = Eye::looking_at(Vec3::Z, 5.0 * Vec3::Z, super::support::field()).pair(0.064);
    assert_eq!(count(None, away), 0);
    // Close up a part of it is beyond the picture's edge.
    let near = count(None, ahead(0.4));
    assert!(near < all * 9 / 10, "{near}");
    silent(&gpu);
}

#[test]
fn another_colouring_goes_up_alone_and_the_last_one_stays_until_it_is_there() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        direct_triangles: 0,
        ..params(mode(&gpu))
    };
    let mut stage = Stage::new(&gpu, &params);
    let eyes = ahead(DISTANCE);
    let plain = placed(small(), |_| ());
    stage
        .renderer
        .set_model(ModelUpload::new(&gpu, &plain).unwrap());
    let shown = scene([plain.clone()]);
    let plain_picture = stage.picture(&shown, &eyes);
    assert_eq!(stage.renderer.colour_bytes(), 0);
    // Right half red, left half as it is; the colours run into each other.
    let colour = |at: &Vec3| [230, 20, 20, if at.x > 0.0 { 255 } else { 0 }];
    let painted = small().painted(small().mesh.positions.iter().map(colour).collect());
    let painted = PlacedModel {
        display: Arc::new(painted),
        revision: new_revision(),
        ..plain.clone()
    };
    let other = scene([painted.clone()]);
    let target = stage.offscreen.target();
    let report = stage.renderer.draw(&other, &eyes, &target).unwrap();
    assert_eq!(report.model, Some(painted.revision));
    assert!(stage.renderer.has_shape(&painted) && !stage.renderer.has_models(&other));
    let [meanwhile, _] = stage.offscreen.read_color().unwrap();
    // It does not go away, though it is drawn in the detail that its new colours want.
    assert!(mean_difference(&meanwhile, &plain_picture) < 0.5);
    assert!(covered(&meanwhile).abs_diff(covered(&plain_picture)) < 100);
    stage
        .renderer
        .set_model(ModelUpload::colours(&gpu, &painted).unwrap());
    let picture = stage.picture(&other, &eyes);
    let vertices = small().mesh.positions.len() as u64;
    let bytes = stage.renderer.colour_bytes();
    assert!((3 * vertices..6 * vertices).contains(&bytes), "{bytes}");
    let red = |x: u32| {
        let [red, green, ..] = picture.get_pixel(x, FINE / 2).0;
        i32::from(red) - i32::from(green)
    };
    assert!(red(FINE / 2 + 60) > 60, "{}", red(FINE / 2 + 60));
    assert!(red(FINE / 2 - 40) < 40, "{}", red(FINE / 2 - 40));
    // Back at no colours: those that went up are let go of.
    stage
        .renderer
        .set_model(ModelUpload::colours(&gpu, &plain).unwrap());
    stage.draw(&shown, &eyes);
    stage.draw(&shown, &eyes);
    assert_eq!(stage.renderer.colour_bytes(), 0);
    silent(&gpu);
}

#[test]
fn vertices_and_their_colours_are_the_same_in_many_chunks() {
    let Some(gpu) = device() else { return };
    let plain = display(lumpy(60));
    let colours = |part: f32| (127.0 + 120.0 * (30.0 * part).sin()) as u8;
    let painted = plain.mesh.positions.iter();
    let painted = painted.map(|at| [colours(at.x), colours(at.y), colours(at.z), 255]);
    let painted = Arc::new(plain.painted(painted.collect()));
    let model = placed(&painted, |look| look.vertices = true);
    let shown = scene([model.clone()]);
    let eyes = ahead(DISTANCE);
    let mut one = Stage::new(&gpu, &params(mode(&gpu)));
    let whole = one.picture(&shown, &eyes);
    let points = one.draw(&shown, &eyes).1;
    let mut many = Stage::new(&gpu, &params(mode(&gpu)));
    let upload = ModelUpload::in_chunks(&gpu, &model, 16_384).unwrap();
    many.renderer.set_model(upload);
    assert!(whole == many.picture(&shown, &eyes));
    // Each vertex is one point, in whichever chunk: two triangles each, and the sky.
    let vertices = plain.levels.triangles.as_flattened();
    let vertices: std::collections::BTreeSet<u32> = vertices.iter().copied().collect();
    let others = points - 2 * vertices.len() as u64;
    assert!(others < 10, "{others}");
    assert_eq!(many.draw(&shown, &eyes).1, points);
    silent(&gpu);
}
