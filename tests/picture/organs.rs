//! Polygons, spheres, surfaces and colours in pictures: where they are, how large, in which colour, and their shadow.

use std::sync::{Arc, atomic::AtomicBool};

use glam::{Affine3A, Quat, Vec3};
use image::Rgba;
use ramus::{
    lsystem::{Grammar, Limits, TurtleParams, draw},
    render::{Eye, Offscreen, Renderer, RendererParams},
    tree::{
        NO_PARENT, Node, Organs, Tree,
        bark::Bark,
        organs::{Paint, Placed, Polygon, Smooth, Sphere, Surface},
    },
    world::scene::{PlacedTree, Scene},
};

use super::snapshots::snapshot;
use super::support::{
    SIDE, ahead, blob, device, field, mode, pixels_per_tangent, plain, shoot, silent,
};

fn paint(colour: u16) -> Paint {
    Paint {
        colour,
        material: 0,
    }
}

/// A root alone: no segment.
fn nothing() -> Tree {
    let mut tree = Tree {
        letters: vec!["F".into()],
        ..Tree::default()
    };
    tree.push(Node {
        parent: NO_PARENT,
        position: Vec3::ZERO,
        radius: 0.05,
        letter: 0,
        order: 0,
        birth: 0,
    });
    tree
}

fn scene(tree: Tree, organs: Organs) -> Scene {
    organs.validate(&tree).unwrap();
    Scene {
        tree: Some(PlacedTree {
            tree: Arc::new(tree),
            organs: Arc::new(organs),
            radius_before: Arc::default(),
            revision: 1,
            world_from_tree: Affine3A::IDENTITY,
            growth: 1.0,
            newest: u32::MAX,
        }),
        ..Scene::default()
    }
}

/// A square of half a metre about a point, seen from +Z, its corners in either order.
fn square(at: Vec3, colour: u16, clockwise: bool) -> Organs {
    let mut corners = [[-0.25, -0.25], [0.25, -0.25], [0.25, 0.25], [-0.25, 0.25]]
        .map(|[x, y]| at + Vec3::new(x, y, 0.0))
        .to_vec();
    if clockwise {
        corners.reverse();
    }
    Organs {
        polygons: vec![Polygon {
            first: 0,
            paint: paint(colour),
            birth: 0,
            node: 0,
        }],
        corners,
        ..Organs::default()
    }
}

fn sphere(center: Vec3, radius: f32, colour: u16) -> Organs {
    Organs {
        spheres: vec![Sphere {
            center,
            radius,
            paint: paint(colour),
            birth: 0,
            node: NO_PARENT,
        }],
        ..Organs::default()
    }
}

#[test]
fn organs_cover_what_they_should_in_their_colour() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let background = Rgba([0, 0, 0, 255]);
    let per_metre = pixels_per_tangent() / 2.0;
    let middle = SIDE as f32 / 2.0;
    let side = (0.5 * per_metre).powi(2);
    let disc = std::f32::consts::PI * (0.3 * per_metre).powi(2);
    let up = Vec3::new(0.0, 0.3, 0.0);
    for (name, organs, area, at, strongest) in [
        ("red square", square(up, 3, false), side, 0.3, 0),
        ("its other side", square(up, 3, true), side, 0.3, 0),
        ("blue ball", sphere(Vec3::ZERO, 0.3, 5), disc, 0.0, 2),
        ("green ball", sphere(Vec3::ZERO, 0.3, 2), disc, 0.0, 1),
    ] {
        let shot = shoot(&gpu, &params, &scene(nothing(), organs), &ahead(2.0));
        let (x, y, count) = blob(&shot.color[0], background);
        // The left eye stands 32 mm to the left.
        assert!(
            (x - (middle + 0.032 * per_metre)).abs() < 1.5,
            "{name}: x {x}"
        );
        assert!((y - (middle - at * per_metre)).abs() < 1.5, "{name}: y {y}");
        let share = count as f32 / area;
        assert!((0.96..1.08).contains(&share), "{name}: {share} of its area");
        let Rgba([r, g, b, _]) = *shot.color[0].get_pixel(x as u32, y as u32);
        let rgb = [r, g, b];
        let others = (0..3).filter(|i| *i != strongest).map(|i| rgb[i]);
        let most = others.max().unwrap_or(0);
        assert!(rgb[strongest] > most + 25, "{name}: {rgb:?}");
    }
    silent(&gpu);
}

/// The trunk of three metres of which one is red.
fn striped(cylinder: bool) -> (Tree, Organs) {
    let mut tree = nothing();
    for node in 0..3_u8 {
        tree.push(Node {
            parent: u32::from(node),
            position: Vec3::Y * f32::from(node + 1),
            radius: 0.05,
            letter: 0,
            order: 0,
            birth: 0,
        });
    }
    let mut organs = Organs::default();
    organs.set_paint(2, paint(3));
    if cylinder {
        tree.position[2].x = 0.3;
        organs.smooth = (1..=3).map(|node| Smooth { node, cylinder: 1 }).collect();
    }
    (tree, organs)
}

#[test]
fn segments_show_their_colours() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    for cylinder in [false, true] {
        let (tree, organs) = striped(cylinder);
        let middle = Vec3::Y * 1.5;
        let eyes = Eye::looking_at(middle + Vec3::Z * 4.0, middle, field()).pair(0.064);
        let shot = shoot(&gpu, &params, &scene(tree, organs), &eyes);
        let red = |y: u32| {
            (0..SIDE)
                .filter(|x| {
                    let [r, g, _, a] = shot.color[0].get_pixel(*x, y).0;
                    a > 0 && i32::from(r) > 2 * i32::from(g) + 20
                })
                .count()
        };
        let [below, within, above] = [190, 128, 60].map(red);
        assert!(
            within >= 4,
            "red in the middle: {within} (cylinder: {cylinder})"
        );
        assert_eq!(
            (below, above),
            (0, 0),
            "and there only (cylinder: {cylinder})"
        );
    }
    silent(&gpu);
}

#[test]
fn a_ball_throws_its_shadow() {
    let Some(gpu) = device() else { return };
    let lit = |shadows: bool| {
        let params = RendererParams {
            shadows,
            // From straight above.
            sun: Vec3::new(0.0, 1.0, 0.001),
            ..RendererParams::new(SIDE, SIDE, mode(&gpu))
        };
        let scene = scene(nothing(), sphere(Vec3::Y * 1.5, 0.4, 3));
        let eyes = Eye::looking_at(Vec3::new(0.0, 3.0, 3.0), Vec3::ZERO, field()).pair(0.064);
        let shot = shoot(&gpu, &params, &scene, &eyes);
        let [r, g, b, _] = shot.color[0].get_pixel(SIDE / 2, SIDE / 2 + 4).0;
        u32::from(r) + u32::from(g) + u32::from(b)
    };
    let (with, without) = (lit(true), lit(false));
    assert!(
        with * 10 < without * 9,
        "the ground below is darker: {with} {without}"
    );
    silent(&gpu);
}

#[test]
fn leaves_unfold_with_the_step_that_made_them() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let organs = Organs {
        surfaces: vec![Surface::built_in("leaf").unwrap()],
        placed: vec![Placed {
            surface: 0,
            paint: paint(0),
            position: Vec3::ZERO,
            orientation: Quat::IDENTITY,
            scale: 0.6,
            birth: 3,
            node: 0,
            light: 1.0,
        }],
        ..Organs::default()
    };
    let area = |growth: f32, newest: u32| {
        let mut scene = scene(nothing(), organs.clone());
        let tree = scene.tree.as_mut().unwrap();
        (tree.growth, tree.newest) = (growth, newest);
        let shot = shoot(&gpu, &params, &scene, &ahead(2.0));
        blob(&shot.color[0], Rgba([0, 0, 0, 255])).2 as f32
    };
    let whole = area(1.0, 3);
    assert!(whole > 500.0, "{whole}");
    assert_eq!(area(0.0, 3), 0.0);
    let half = area(0.5, 3) / whole;
    assert!((half - 0.25).abs() < 0.03, "half as long and wide: {half}");
    assert_eq!(area(0.5, 4), whole, "an older leaf stands");
    silent(&gpu);
}

#[test]
fn organs_come_and_go_with_their_trees() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let mut first = scene(nothing(), sphere(Vec3::ZERO, 0.3, 3));
    let (tree, organs) = striped(true);
    let mut second = scene(tree, organs);
    let mut seen = Vec::new();
    for revision in 1..6 {
        let scene = if revision % 2 == 0 {
            &mut second
        } else {
            &mut first
        };
        scene.tree.as_mut().unwrap().revision = revision;
        let report = renderer
            .draw(scene, &ahead(4.0), &offscreen.target())
            .unwrap();
        seen.push(report.segments);
        let picture = &offscreen.read_color().unwrap()[0];
        assert!(blob(picture, Rgba([0, 0, 0, 255])).2 > 200, "{revision}");
    }
    assert!(seen[0] == 0 && seen[1] > 3 && seen[2] == 0, "{seen:?}");
    drop(renderer);
    silent(&gpu);
}

/// Bells on an arched stalk before two leaves, as they were when they were looked at.
#[test]
fn a_lily_of_the_valley() {
    let Some(gpu) = device() else { return };
    let text = include_str!("../../assets/grammars/lily-of-the-valley.lsys");
    let grammar = Grammar::parse(text, "lily.lsys").unwrap();
    let never = AtomicBool::new(false);
    let string = grammar
        .derive(grammar.steps().unwrap(), &Limits::default(), &never)
        .unwrap();
    let drawing = draw(&grammar, &string, &TurtleParams::default(), &never).unwrap();
    let params = RendererParams::new(200, 200, mode(&gpu));
    let middle = Vec3::new(0.2, 0.9, 0.0);
    let eyes = Eye::looking_at(middle + Vec3::new(0.0, 0.3, 2.6), middle, field()).pair(0.063);
    let shot = shoot(&gpu, &params, &scene(drawing.tree, drawing.organs), &eyes);
    snapshot("lily", &shot.color[0]);
    silent(&gpu);
}

/// Many leaves of several kinds, each once: as many pixels as when they stand alone, in both eyes, with no message.
#[test]
fn leaves_of_many_kinds_stand_where_they_are_placed() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let kinds = [
        "maple", "oak", "birch", "willow", "ovate", "needles", "pinnule", "spines", "blossom",
        "fruit",
    ];
    let leaf = |surface: u16, at: Vec3| Placed {
        surface,
        paint: paint(0),
        position: at,
        orientation: Quat::IDENTITY,
        scale: 0.25,
        birth: 0,
        node: 0,
        light: 1.0,
    };
    let surfaces: Vec<_> = kinds
        .iter()
        .map(|name| Surface::built_in(name).unwrap())
        .collect();
    let covered = |placed: Vec<Placed>| {
        let organs = Organs {
            surfaces: surfaces.clone(),
            placed,
            ..Organs::default()
        };
        let shot = shoot(&gpu, &params, &scene(nothing(), organs), &ahead(2.0));
        shot.color.map(|eye| blob(&eye, Rgba([0, 0, 0, 255])).2)
    };
    let place = |at: usize| {
        Vec3::new(
            (at % 4) as f32 * 0.3 - 0.45,
            (at / 4) as f32 * 0.3 - 0.45,
            0.0,
        )
    };
    let mut alone = 0;
    for (surface, kind) in kinds.iter().enumerate() {
        let index = u16::try_from(surface).unwrap();
        let [left, right] = covered(vec![leaf(index, place(surface))]);
        assert!(left > 40 && right > 40, "{}: {left} {right}", kind);
        alone += left;
    }
    let all = (0..kinds.len())
        .map(|at| leaf(u16::try_from(at).unwrap(), place(at)))
        .collect();
    let [left, _] = covered(all);
    assert!(left.abs_diff(alone) * 20 < alone, "{left} of {alone}");
    silent(&gpu);
}

/// A leaf deep in the crown is darker than one at its rim, and a trunk of birch is lighter than one of oak.
#[test]
fn leaves_in_the_dark_are_darker_and_barks_differ() {
    let Some(gpu) = device() else { return };
    let params = plain(mode(&gpu), 0.0);
    let brightness = |light: f32| {
        let organs = Organs {
            surfaces: vec![Surface::built_in("oak").unwrap()],
            placed: vec![Placed {
                surface: 0,
                paint: paint(0),
                position: Vec3::new(0.0, -0.3, 0.0),
                orientation: Quat::IDENTITY,
                scale: 0.8,
                birth: 0,
                node: 0,
                light,
            }],
            ..Organs::default()
        };
        let shot = shoot(&gpu, &params, &scene(nothing(), organs), &ahead(2.0));
        let pixels = shot.color[0]
            .pixels()
            .filter(|pixel| pixel.0[..3] != [0; 3]);
        let (sum, count) = pixels.fold((0_u64, 0_u64), |(sum, count), pixel| {
            (sum + u64::from(pixel.0[1]), count + 1)
        });
        sum / count.max(1)
    };
    let (open, dark) = (brightness(1.0), brightness(0.0));
    assert!(dark + 15 < open, "{dark} {open}");
    let bark = |bark: Bark| {
        let mut tree = nothing();
        tree.push(Node {
            parent: 0,
            position: Vec3::Y * 0.8,
            radius: 0.2,
            letter: 0,
            order: 0,
            birth: 0,
        });
        tree.radius[0] = 0.2;
        let shot = shoot(
            &gpu,
            &params,
            &scene(
                tree,
                Organs {
                    bark,
                    ..Organs::default()
                },
            ),
            &ahead(2.0),
        );
        let pixels = shot.color[0]
            .pixels()
            .filter(|pixel| pixel.0[..3] != [0; 3]);
        let sums = pixels.fold([0_u64; 4], |sums, p| {
            [
                sums[0] + u64::from(p.0[0]),
                sums[1] + u64::from(p.0[1]),
                sums[2] + u64::from(p.0[2]),
                sums[3] + 1,
            ]
        });
        [0, 1, 2].map(|i| sums[i] / sums[3].max(1))
    };
    let [birch, oak, cactus] = [Bark::Birch, Bark::Oak, Bark::Cactus].map(bark);
    assert!(birch[0] > oak[0] + 40, "{birch:?} {oak:?}");
    assert!(cactus[1] > cactus[0] + 5, "{cactus:?}");
    silent(&gpu);
}
