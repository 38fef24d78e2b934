//! Trees in the wind: what moves, what does not, and that no part of a tree parts from another.

use glam::{Affine3A, Quat, Vec3};
use image::RgbaImage;
use ramus::render::{
    Backdrop, Eye, Fov, Gpu, Offscreen, Renderer, RendererParams, StereoMode, TreeState,
};
use ramus::tree::{NO_PARENT, Node, Tree};
use ramus::world::scene::weather::{Light, Sway, Wind};
use ramus::world::scene::{PlacedTree, Scene};

use super::lights::{leafy, params};
use super::support::{SIDE, device, field, grove, mode, placed, silent};

const STRONG: Sway = Sway {
    strength: 1.0,
    clock: 0.2437,
};

fn before() -> [Eye; 2] {
    Eye::looking_at(Vec3::new(0.3, 1.4, 4.0), Vec3::new(0.0, 1.1, 0.0), field()).pair(0.064)
}

fn dark(params: RendererParams) -> RendererParams {
    RendererParams {
        backdrop: Backdrop::Plain([0.0, 0.0, 0.0, 1.0]),
        ..params
    }
}

/// What is seen of a tree as it sways like this.
fn seen(
    gpu: &Gpu,
    params: &RendererParams,
    tree: &PlacedTree,
    eyes: &[Eye; 2],
    sway: Sway,
) -> [RgbaImage; 2] {
    let offscreen = Offscreen::new(gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(gpu, params).unwrap();
    renderer.set_sway(sway);
    let scene = Scene {
        tree: Some(tree.clone()),
        ..Scene::default()
    };
    while renderer
        .draw(&scene, eyes, &offscreen.target())
        .unwrap()
        .tree
        != TreeState::Shown
    {}
    offscreen.read_color().unwrap()
}

/// Pixels that differ by more than a shade.
fn differing(a: &RgbaImage, b: &RgbaImage) -> usize {
    let differ = |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 6)
    };
    a.pixels()
        .zip(b.pixels())
        .filter(|pair| differ(*pair))
        .count()
}

/// Means over a picture's lit pixels: where they are, by rows in eighths from the top.
fn middles(picture: &RgbaImage) -> [f64; 8] {
    let mut sums = [(0.0, 0.0); 8];
    for (x, y, pixel) in picture.enumerate_pixels() {
        let light: f64 = pixel.0[..3].iter().map(|part| f64::from(*part)).sum();
        let sum = &mut sums[(y * 8 / picture.height()) as usize];
        *sum = (sum.0 + light * f64::from(x), sum.1 + light);
    }
    sums.map(|(place, light)| place / light.max(1.0))
}

#[test]
fn still_air_changes_nothing_and_a_breeze_does() {
    let Some(gpu) = device() else { return };
    let params = params(mode(&gpu), SIDE, Light::Day);
    let tree = leafy();
    let still = seen(&gpu, &params, &tree, &before(), Sway::default());
    let clock = Sway {
        strength: 0.0,
        clock: 0.7,
    };
    assert!(
        still == seen(&gpu, &params, &tree, &before(), clock),
        "time alone moves nothing"
    );
    let breeze = |clock| Sway {
        strength: Wind::Breeze.strength(),
        clock,
    };
    let [first, second] =
        [0.1, 0.1 + 0.5 / 256.0].map(|clock| seen(&gpu, &params, &tree, &before(), breeze(clock)));
    let [moved, on] = [
        differing(&still[0], &first[0]),
        differing(&first[0], &second[0]),
    ];
    assert!(moved > 2000, "{moved} pixels");
    assert!(on > 1000, "half a second later: {on} pixels");
    // A hundredth of a second later nearly nothing has moved: it is no jitter.
    let soon = seen(&gpu, &params, &tree, &before(), breeze(0.1 + 0.01 / 256.0));
    let jitter = differing(&first[0], &soon[0]);
    assert!(jitter * 5 < on, "{jitter} of {on}");
    silent(&gpu);
}

/// In still air the sun's map is drawn once, whatever the wind's clock says; in a breeze with each frame.
#[test]
fn a_tree_in_still_air_throws_its_shadow_without_being_drawn_again() {
    let Some(gpu) = device() else { return };
    let params = params(mode(&gpu), SIDE, Light::Day);
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let scene = Scene {
        tree: Some(leafy()),
        ..Scene::default()
    };
    let mut draws = |strength: f32, clock: f32| {
        renderer.set_sway(Sway { strength, clock });
        let report = renderer.draw(&scene, &before(), &offscreen.target());
        report.unwrap().draws
    };
    let first = draws(0.0, 0.0);
    let rest = draws(0.0, 0.1);
    assert!(rest < first, "{rest} of {first}");
    assert_eq!(draws(0.0, 0.2), rest);
    assert_eq!([draws(0.35, 0.2), draws(0.35, 0.3)], [first; 2]);
    draws(0.0, 0.3);
    assert_eq!(draws(0.0, 0.4), rest);
    silent(&gpu);
}

#[test]
fn the_crown_leans_the_foot_stays_and_the_shadow_goes_along() {
    let Some(gpu) = device() else { return };
    let (tree, radii) = grove(6, 99);
    let tree = placed(tree, radii, 99, Affine3A::IDENTITY);
    let alone = dark(params(mode(&gpu), SIDE, Light::Day));
    let [rest, swayed] = [Sway::default(), STRONG]
        .map(|sway| middles(&seen(&gpu, &alone, &tree, &before(), sway)[0]));
    // Downwind is to the right.
    let moved: Vec<f64> = swayed.iter().zip(rest).map(|(a, b)| a - b).collect();
    assert!(moved[2] > 4.0 && moved[2] > 2.0 * moved[4], "{moved:?}");
    assert!(moved[6].abs() < 0.5, "{moved:?}");
    // From above: the shadow on the ground, without the tree in the way, moves as far as the crown.
    let ground = params(mode(&gpu), SIDE, Light::Day);
    let away = -ground.sun.normalize();
    let eye = Vec3::new(away.x, 0.0, away.z) * 2.6;
    let eyes = Eye::looking_at(
        eye + Vec3::new(0.0, 1.0, 0.0),
        eye * 0.8,
        Fov::symmetric(0.9, 1.0),
    )
    .pair(0.064);
    let [rest, swayed] =
        [Sway::default(), STRONG].map(|sway| seen(&gpu, &ground, &tree, &eyes, sway)[0].clone());
    let changed = differing(&rest, &swayed);
    assert!(changed > 1000, "{changed} pixels of its shadow");
    silent(&gpu);
}

/// Small things all over a tree, each seen from two sides through a keyhole where [`Sway::at`] says that it is now.
#[test]
fn what_sways_is_where_its_twin_says() {
    let Some(gpu) = device() else { return };
    let root = Vec3::new(0.2, 0.1, -0.3);
    let params = dark(params(mode(&gpu), SIDE, Light::Day));
    let mut moved = 0.0_f32;
    for (place, clock) in [
        (Vec3::new(0.0, 0.4, 0.0), 0.1),
        (Vec3::new(1.5, 2.0, 0.4), 0.2437),
        (Vec3::new(-1.0, 3.0, 2.0), 0.5),
        (Vec3::new(0.3, 6.0, -2.5), 0.77),
        (Vec3::new(4.0, 5.0, 3.0), 0.999),
    ] {
        // The root is a point, and the thing a short piece of its own.
        let mut tree = Tree {
            letters: vec!["F".to_owned()],
            ..Tree::default()
        };
        let half = Vec3::Y * 0.01;
        for (parent, position) in [
            (NO_PARENT, root),
            (NO_PARENT, root + place - half),
            (1, root + place + half),
        ] {
            tree.push(Node {
                parent,
                position,
                radius: 0.02,
                letter: 0,
                order: 0,
                birth: 0,
            });
        }
        let tree = placed(tree, Vec::new(), 0, Affine3A::IDENTITY);
        let sway = Sway {
            strength: 1.0,
            clock,
        };
        let by = sway.at(root + place, root);
        moved = moved.max(by.length());
        let now = root + place + by;
        for side in [Vec3::X, Vec3::Z] {
            // 1.2 mm a pixel.
            let field = Fov::symmetric(0.3, 1.0);
            let eyes = Eye::looking_at(now + side, now, field).pair(0.0);
            let picture = &seen(&gpu, &params, &tree, &eyes, sway)[0];
            let lit = picture.enumerate_pixels();
            let lit = lit.filter(|(.., pixel)| pixel.0[..3].iter().any(|part| *part > 12));
            let (mut count, mut middle) = (0.0, [0.0; 2]);
            for (x, y, _) in lit {
                count += 1.0;
                middle = [middle[0] + f64::from(x), middle[1] + f64::from(y)];
            }
            assert!(count > 200.0, "{place}: {count} pixels");
            let off = middle.map(|sum| sum / count + 0.5 - f64::from(SIDE / 2));
            assert!(off.iter().all(|off| off.abs() < 2.0), "{place}: {off:?}");
        }
    }
    assert!(moved > 0.3, "{moved} m");
    silent(&gpu);
}

/// How much light a picture has, 0 to 1.
fn light(picture: &RgbaImage) -> f64 {
    let sum: f64 = picture
        .pixels()
        .flat_map(|pixel| pixel.0[..3].iter().map(|part| f64::from(*part)))
        .sum();
    sum / (765.0 * f64::from(picture.width() * picture.height()))
}

#[test]
fn all_levels_of_a_tree_sway_alike() {
    let Some(gpu) = device() else { return };
    let (tree, radii) = grove(9, 99);
    let bare = placed(tree, radii, 99, Affine3A::IDENTITY);
    for (name, tree) in [("bare", bare), ("leafy", leafy())] {
        let fine = RendererParams {
            error_px: 0.0,
            primitives: 20_000_000,
            ..dark(params(mode(&gpu), 384, Light::Day))
        };
        // So coarse that all of it is merged segments and ribbons.
        let coarse = RendererParams {
            error_px: 3.0,
            primitives: 60_000,
            ..fine
        };
        let pictures = [&fine, &coarse].map(|params| {
            [Sway::default(), STRONG]
                .map(|sway| seen(&gpu, params, &tree, &before(), sway)[0].clone())
        });
        let moved = pictures.each_ref().map(|[rest, swayed]| {
            let (rest, swayed) = (middles(rest), middles(swayed));
            [1, 2, 3, 4].map(|row| swayed[row] - rest[row])
        });
        eprintln!("{name}: moved {:?} and {:?} pixels", moved[0], moved[1]);
        for (a, b) in moved[0].iter().zip(moved[1]) {
            // Fewer and larger leaves have their middle elsewhere.
            assert!((a - b).abs() < 0.3 + 0.1 * a.abs(), "{name}: {moved:?}");
        }
        assert!(moved[0][1] > 5.0, "{name}: {moved:?}");
        // Nothing gets lost.
        let [[rest, swayed], _] = &pictures;
        let kept = light(swayed) / light(rest);
        assert!((kept - 1.0).abs() < 0.08, "{name}: {kept}");
    }
    silent(&gpu);
}

/// A bent trunk that fills the picture: no background shows through its joints, however it sways.
#[test]
fn joints_do_not_open_in_the_wind() {
    let Some(gpu) = device() else { return };
    let (tree, radii) = grove(3, 99);
    let tree = placed(
        tree,
        radii,
        99,
        Affine3A::from_scale_rotation_translation(Vec3::splat(3.0), Quat::IDENTITY, Vec3::ZERO),
    );
    let params = RendererParams {
        backdrop: Backdrop::Plain([1.0, 0.0, 1.0, 1.0]),
        ..params(mode(&gpu), 512, Light::Day)
    };
    let mut covered = 0;
    for clock in [0.0, 0.21, 0.47, 0.83] {
        let sway = Sway {
            strength: 1.0,
            clock,
        };
        // Joints halfway up the trunk, which the eye follows.
        let root = Vec3::ZERO;
        let at = tree.world_from_tree.transform_point3(tree.tree.position[2]);
        let at = at + sway.at(at, root);
        let eyes = Eye::looking_at(at + Vec3::new(0.0, 0.0, 0.8), at, Fov::symmetric(0.5, 1.0))
            .pair(0.064);
        for picture in seen(&gpu, &params, &tree, &eyes, sway) {
            let magenta = |x: u32, y: u32| {
                let [red, green, blue, _] = picture.get_pixel(x, y).0;
                red > 200 && blue > 200 && green < 120
            };
            // In each row all pixels between the trunk's sides are covered.
            for y in 0..512 {
                let inside: Vec<u32> = (0..512).filter(|x| !magenta(*x, y)).collect();
                let (Some(first), Some(last)) = (inside.first(), inside.last()) else {
                    panic!("the trunk is not in row {y}");
                };
                assert_eq!(
                    (last - first + 1) as usize,
                    inside.len(),
                    "row {y} at {clock}"
                );
                covered += inside.len();
            }
        }
    }
    assert!(covered > 100_000, "{covered}");
    silent(&gpu);
}

#[test]
fn one_pass_and_one_an_eye_draw_the_same_swaying_tree() {
    let Some(gpu) = device() else { return };
    if mode(&gpu) != StereoMode::Multiview {
        eprintln!("skipped: this driver's multiview is broken");
        return;
    }
    let tree = leafy();
    let [both, each] = [StereoMode::Multiview, StereoMode::PerEye].map(|mode| {
        seen(
            &gpu,
            &params(mode, SIDE, Light::Evening),
            &tree,
            &before(),
            STRONG,
        )
    });
    assert!(both == each);
    silent(&gpu);
}

/// What sways into the picture from beside it is drawn: culling counts on it.
#[test]
fn what_sways_into_sight_is_seen() {
    let Some(gpu) = device() else { return };
    let (tree, radii) = grove(6, 99);
    let tree = placed(tree, radii, 99, Affine3A::IDENTITY);
    let params = dark(params(mode(&gpu), SIDE, Light::Day));
    let whole = |eyes: &[Eye; 2]| seen(&gpu, &params, &tree, eyes, STRONG);
    // The right half of what a wider picture shows, whose left edge cuts the crown.
    let straight = |left: f32, right: f32| Eye {
        fov: Fov {
            left,
            right,
            up: 0.4,
            down: -0.4,
        },
        ..before()[0]
    };
    for edge in [-0.12_f32, -0.04, 0.04, 0.10] {
        let wide = whole(&straight((edge.tan() - 0.6).atan(), (edge.tan() + 0.6).atan()).pair(0.0));
        let cut = whole(&straight(edge, (edge.tan() + 1.2).atan()).pair(0.0));
        let half = SIDE / 2;
        let part = |picture: &RgbaImage, x| {
            image::imageops::crop_imm(picture, x, 0, half, SIDE).to_image()
        };
        let off = differing(&part(&wide[0], half), &part(&cut[0], 0));
        let all = light(&part(&cut[0], 0));
        assert!(
            off * 100 < (half * SIDE) as usize && all > 0.0,
            "{edge}: {off}"
        );
    }
    silent(&gpu);
}

/// Pictures to be looked at: `cargo test --test picture -- --ignored look_at_wind`.
#[test]
#[ignore = "makes large pictures for people"]
fn look_at_wind() {
    let Some(gpu) = device() else { return };
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("target/pictures");
    std::fs::create_dir_all(&folder).unwrap();
    let params = params(mode(&gpu), 720, Light::Day);
    for wind in Wind::ALL {
        let sway = Sway {
            strength: wind.strength(),
            clock: 0.31,
        };
        let pictures = seen(&gpu, &params, &leafy(), &before(), sway);
        pictures[0]
            .save(folder.join(format!("wind-{wind:?}.png")))
            .unwrap();
    }
    silent(&gpu);
}
