//! Tests of organs: invariants, triangles, cylinders, colours.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::float_cmp,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "tests"
)]

use glam::{Quat, Vec3, vec3};
use proptest::prelude::*;

use super::*;
use crate::tree::Node;

fn chain(points: &[Vec3]) -> Tree {
    let mut tree = Tree {
        letters: vec!["F".into()],
        ..Tree::default()
    };
    for (at, position) in (0..).zip(points) {
        tree.push(Node {
            parent: u32::checked_sub(at, 1).unwrap_or(NO_PARENT),
            position: *position,
            radius: 0.1,
            letter: 0,
            order: 0,
            birth: at,
        });
    }
    tree
}

fn polygon(corners: &[Vec3]) -> Organs {
    Organs {
        polygons: vec![Polygon {
            first: 0,
            paint: Paint::default(),
            birth: 0,
            node: 0,
        }],
        corners: corners.to_vec(),
        ..Organs::default()
    }
}

fn area(corners: &[Vec3], triangles: &[u32]) -> Vec3 {
    let at = |i: u32| corners[i as usize];
    triangles
        .chunks_exact(3)
        .map(|t| (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])) * 0.5)
        .sum()
}

#[test]
fn polygons_of_every_kind_are_cut() {
    let flat = |points: &[[f32; 2]]| -> Vec<Vec3> {
        points.iter().map(|[x, y]| vec3(*x, *y, 0.0)).collect()
    };
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let arrow = [[0.0, 0.0], [2.0, 0.0], [0.5, 0.5], [0.0, 2.0]];
    let clockwise = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let bow = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    let line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]];
    for (name, corners, triangles, size) in [
        ("triangle", flat(&square[..3]), 1, Some(0.5)),
        ("square", flat(&square), 2, Some(1.0)),
        ("concave", flat(&arrow), 2, Some(1.0)),
        ("clockwise", flat(&clockwise), 2, Some(1.0)),
        ("crossing itself", flat(&bow), 1, None),
        ("on a line", flat(&line), 0, None),
        ("one point", vec![Vec3::ONE; 5], 0, None),
        ("nothing", Vec::new(), 0, None),
        (
            "huge",
            square.map(|[x, y]| vec3(x, y, 0.0) * 3e37).to_vec(),
            2,
            None,
        ),
        (
            "tiny",
            square.map(|[x, y]| vec3(x, y, 0.0) * 1e-20).to_vec(),
            2,
            None,
        ),
    ] {
        let mut cut = Vec::new();
        let normal = Triangulator::default().add(&corners, &mut cut);
        assert_eq!(normal.is_some(), triangles > 0, "{name}");
        assert!(cut.len() / 3 >= triangles, "{name}: {cut:?}");
        assert!(cut.iter().all(|i| (*i as usize) < corners.len()), "{name}");
        let Some(normal) = normal else { continue };
        assert!((normal.length() - 1.0).abs() < 1e-5, "{name}");
        if let Some(size) = size {
            let found = area(&corners, &cut).dot(normal);
            assert!((found - size).abs() < 1e-5, "{name}: {found}");
        }
    }
}

proptest! {
    #[test]
    fn a_turned_star_keeps_its_area(
        reach in proptest::collection::vec(0.2_f32..2.0, 3..40),
        turn in -3.0_f32..3.0,
        tilt in -1.5_f32..1.5,
    ) {
        // Star-shaped about the origin: concave, and never crossing itself.
        let sides = reach.len() as f32;
        let spin = Quat::from_rotation_y(turn) * Quat::from_rotation_x(tilt);
        let angle = |i: usize| std::f32::consts::TAU * i as f32 / sides;
        let corners: Vec<Vec3> = reach.iter().enumerate()
            .map(|(i, r)| spin * (vec3(angle(i).cos(), angle(i).sin(), 0.0) * *r))
            .collect();
        let expected: f32 = (0..reach.len())
            .map(|i| corners[i].cross(corners[(i + 1) % reach.len()]).length() * 0.5)
            .sum();
        prop_assume!(reach.len() > 4);
        let mut cut = Vec::new();
        let normal = Triangulator::default().add(&corners, &mut cut).unwrap();
        let total: f32 = cut.chunks_exact(3)
            .map(|t| {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| corners[i as usize]);
                let part = (b - a).cross(c - a) * 0.5;
                assert!(part.dot(normal) > -1e-4, "no triangle lies over another");
                part.length()
            })
            .sum();
        prop_assert!((total - expected).abs() < 1e-3 * expected, "{} {}", total, expected);
        prop_assert!(normal.dot(spin * Vec3::Z) > 0.999);
    }
}

#[test]
fn the_largest_polygon_is_cut_in_bounded_time() {
    // The worst that ear clipping meets: a random scribble.
    let mut seed = 1_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 16_777_216.0
    };
    let corners: Vec<Vec3> = (0..MOST_CORNERS)
        .map(|_| vec3(random(), random(), 0.0))
        .collect();
    let began = cpu_time::ThreadTime::now();
    Triangulator::default().add(&corners, &mut Vec::new());
    let took = began.elapsed();
    println!("{took:?}");
    assert!(took.as_secs() < 20, "{took:?}");
    let one_more = vec![Vec3::ZERO; MOST_CORNERS + 1];
    assert_eq!(
        Triangulator::default().add(&one_more, &mut Vec::new()),
        None
    );
}

#[test]
fn what_does_not_fit_the_tree_is_refused() {
    let tree = chain(&[Vec3::ZERO, Vec3::Y]);
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let good = polygon(&triangle);
    good.validate(&tree).unwrap();
    let ball = |center, radius, node| Organs {
        spheres: vec![Sphere {
            center,
            radius,
            paint: Paint::default(),
            birth: 0,
            node,
        }],
        ..Organs::default()
    };
    let leaf = |orientation, surface, surfaces: usize| Organs {
        surfaces: vec![Surface::built_in("leaf").unwrap(); surfaces],
        placed: vec![Placed {
            surface,
            paint: Paint::default(),
            position: Vec3::ZERO,
            orientation,
            scale: 1.0,
            birth: 0,
            node: NO_PARENT,
            light: 1.0,
        }],
        ..Organs::default()
    };
    let smooth = |nodes: &[u32]| Organs {
        smooth: nodes
            .iter()
            .map(|node| Smooth {
                node: *node,
                cylinder: 1,
            })
            .collect(),
        ..Organs::default()
    };
    leaf(Quat::IDENTITY, 0, 1).validate(&tree).unwrap();
    ball(Vec3::ZERO, 1.0, NO_PARENT).validate(&tree).unwrap();
    for (organs, said) in [
        (polygon(&triangle[..2]), "has 2 corners"),
        (polygon(&[Vec3::ZERO, Vec3::X, Vec3::NAN]), "not finite"),
        (ball(Vec3::ZERO, 1.0, 2), "node 2 of a tree of 2"),
        (ball(Vec3::ZERO, f32::INFINITY, 0), "not finite"),
        (ball(Vec3::ZERO, -1.0, 0), "not finite"),
        (ball(Vec3::NAN, 1.0, 0), "not finite"),
        (
            leaf(Quat::from_xyzw(0.0, 0.0, 0.0, 2.0), 0, 1),
            "not finite",
        ),
        (
            leaf(Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0), 0, 1),
            "not finite",
        ),
        (leaf(Quat::IDENTITY, 1, 1), "number 1 of 1"),
        (smooth(&[1, 1]), "out of order"),
        (smooth(&[7]), "node 7 of a tree of 2"),
    ] {
        let error = organs.validate(&tree).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn built_in_surfaces_are_whole_and_about_one_long() {
    for name in BUILT_IN {
        let surface = Surface::built_in(name).unwrap();
        let vertices = surface.positions.len();
        assert_eq!(surface.normals.len(), vertices, "{name}");
        assert_eq!(surface.tone.len(), vertices, "{name}");
        assert!(surface.indices.len() >= 12 && surface.indices.len().is_multiple_of(3));
        assert!(
            surface.indices.iter().all(|i| (*i as usize) < vertices),
            "{name}"
        );
        assert!(
            surface
                .tone
                .iter()
                .all(|t| usize::from(*t) < surface.tones.len()),
            "{name}"
        );
        assert!(
            surface
                .normals
                .iter()
                .all(|n| (n.length() - 1.0).abs() < 1e-4),
            "{name}"
        );
        let reach = surface
            .positions
            .iter()
            .map(|p| p.length())
            .fold(0.0, f32::max);
        assert!((0.4..1.3).contains(&reach), "{name} reaches {reach}");
        for triangle in surface.indices.chunks_exact(3) {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]].map(|i| i as usize);
            let p = &surface.positions;
            let flat = (p[b] - p[a]).cross(p[c] - p[a]);
            let mean = surface.normals[a] + surface.normals[b] + surface.normals[c];
            assert!(
                flat.length() < 1e-6 || flat.dot(mean) > 0.0,
                "{name}: a triangle turns against its normals"
            );
        }
    }
    assert_eq!(Surface::built_in("tree"), None);
}

#[test]
fn organs_become_triangles_where_they_stand() {
    let mut organs = polygon(&[Vec3::ZERO, Vec3::X, Vec3::ONE]);
    organs.spheres.push(Sphere {
        center: vec3(5.0, 0.0, 0.0),
        radius: 2.0,
        paint: Paint {
            colour: 3,
            material: 1,
        },
        birth: 4,
        node: 0,
    });
    organs.surfaces.push(Surface::built_in("flower").unwrap());
    organs.placed.push(Placed {
        surface: 0,
        paint: Paint {
            colour: 5,
            material: 0,
        },
        position: Vec3::Y * 10.0,
        orientation: Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2),
        scale: 2.0,
        birth: 1,
        node: NO_PARENT,
        light: 1.0,
    });
    let mut organist = Organist::new(&organs);
    let mut mesh = OrganMesh::default();
    for index in 0..organs.len() {
        let before = (mesh.positions.len(), mesh.indices.len());
        organist.add(index, &mut mesh);
        let (vertices, indices) = organist.size(index);
        assert_eq!(mesh.positions.len() - before.0, vertices);
        assert_eq!(mesh.indices.len() - before.1, indices);
    }
    assert_eq!(organist.organ(3), None);
    assert!(organist.organ(0).unwrap().thin && !organist.organ(1).unwrap().thin);
    let (sphere, flower) = (3, 3 + organist.size(1).0);
    for at in sphere..flower {
        let way = Vec3::from(mesh.positions[at]) - vec3(5.0, 0.0, 0.0);
        assert!((way.length() - 2.0).abs() < 1e-5);
        assert!(way.normalize().dot(Vec3::from(mesh.normals[at])) > 0.999);
        assert_eq!(mesh.colours[at], organs.palette.colour(3).unwrap());
    }
    // The flower looks along its heading, +X here; its petals are blue and its heart is not.
    let blue = organs.palette.colour(5).unwrap();
    let blues = mesh
        .colours
        .iter()
        .skip(flower)
        .filter(|c| **c == blue)
        .count();
    let others = mesh.colours.len() - flower - blues;
    assert!(blues > 50 && others > 50, "{blues} {others}");
    let low = organs.bounds().unwrap().0;
    assert!(low.x >= -0.1, "ahead of the turtle: {low}");
}

/// Points of the fine tree lie on a smooth curve through the old nodes.
#[test]
fn a_cylinder_is_one_smooth_curve_through_its_nodes() {
    let points = [
        Vec3::ZERO,
        Vec3::Y,
        vec3(0.8, 1.6, 0.0),
        vec3(1.8, 1.6, 0.5),
        vec3(1.8, 1.6, 1.5),
    ];
    let mut tree = chain(&points);
    tree.radius = vec![0.1, 0.08, 0.06, 0.04, 0.02].into();
    let mut organs = Organs {
        smooth: (1..5).map(|node| Smooth { node, cylinder: 1 }).collect(),
        ..Organs::default()
    };
    organs.set_paint(
        3,
        Paint {
            colour: 2,
            material: 0,
        },
    );
    let before = [0.05; 5];
    let fine = refined(&tree, &organs, &before).unwrap();
    fine.tree.validate().unwrap();
    assert_eq!(fine.tree.len() as u64, refined_len(&tree, &organs));
    assert_eq!(fine.radius_before.len(), fine.tree.len());
    for (old, new) in fine.number.iter().enumerate() {
        let new = *new as usize;
        assert_eq!(fine.tree.position[new], points[old], "nodes stay");
        assert_eq!(fine.tree.radius[new], tree.radius[old]);
        assert_eq!(fine.tree.birth[new], tree.birth[old]);
    }
    let directions: Vec<Vec3> = (1..fine.tree.len())
        .map(|node| {
            let below = fine.tree.parent[node] as usize;
            (fine.tree.position[node] - fine.tree.position[below]).normalize()
        })
        .collect();
    for pair in directions.windows(2) {
        let turn = pair[0].angle_between(pair[1]);
        assert!(turn < 0.2, "turns of {turn} rad; the coarse tree has 0.9");
    }
    assert!(fine.tree.radius.windows(2).all(|r| r[1] <= r[0]), "tapers");
    let painted = fine.paints.iter().filter(|p| p.colour == 2).count();
    let of_third = (fine.number[3] - fine.number[2]) as usize;
    assert_eq!(painted, of_third, "all pieces of the painted segment");

    // A straight one, one without entries and one that snaps back stay as they are.
    let straight = chain(&[Vec3::ZERO, Vec3::Y, Vec3::Y * 2.0]);
    let two = Organs {
        smooth: (1..3).map(|node| Smooth { node, cylinder: 1 }).collect(),
        ..Organs::default()
    };
    assert_eq!(refined(&straight, &two, &[]), None);
    assert_eq!(refined(&tree, &Organs::default(), &[]), None);
    let back = chain(&[Vec3::ZERO, Vec3::Y, Vec3::ZERO]);
    assert_eq!(refined(&back, &two, &[]), None);
    // Points in one place.
    let still = chain(&[Vec3::ZERO, Vec3::ZERO, Vec3::ZERO]);
    assert_eq!(refined(&still, &two, &[]), None);
}

/// Two cylinders that meet at a node do not bend into each other.
#[test]
fn a_new_cylinder_begins_in_its_own_direction() {
    let tree = chain(&[Vec3::ZERO, Vec3::Y, vec3(1.0, 1.0, 0.0)]);
    let organs = Organs {
        smooth: vec![
            Smooth {
                node: 1,
                cylinder: 1,
            },
            Smooth {
                node: 2,
                cylinder: 2,
            },
        ],
        ..Organs::default()
    };
    assert_eq!(refined(&tree, &organs, &[]), None);
}

#[test]
fn paints_cost_nothing_where_there_are_none() {
    let mut organs = Organs::default();
    for node in 0..1000 {
        organs.set_paint(node, Paint::default());
    }
    assert_eq!(organs.bytes(), 0);
    let red = Paint {
        colour: 3,
        material: 0,
    };
    organs.set_paint(10, red);
    assert_eq!(organs.paints.len(), 11);
    assert_eq!(
        [organs.paint(9), organs.paint(10), organs.paint(11)],
        [Paint::default(), red, Paint::default()]
    );
}

#[test]
fn segments_that_nothing_paints_have_the_grammars_colour_0() {
    let tree = chain(&[Vec3::ZERO, Vec3::Y, Vec3::Y * 2.0]);
    let painted = |organs: &Organs| {
        let mut segments = Vec::new();
        crate::tree::tubes::segments(&tree, &[], u32::MAX, &mut segments);
        paint_segments(
            &tree,
            organs,
            None,
            &mut segments,
            &mut LookTable::default(),
        );
        segments.iter().filter(|s| look_of(s).is_some()).count()
    };
    let mut organs = Organs::default();
    assert_eq!(painted(&organs), 0);
    organs.palette.set_colour(0, [0.1, 0.2, 0.3]);
    assert_eq!(painted(&organs), 2);
}

#[test]
fn a_palette_has_a_colour_for_every_index_and_takes_those_that_are_given() {
    let mut palette = Palette::default();
    assert_eq!(palette.colour(0), None, "the thing's own");
    assert_eq!(palette.colour(1), palette.colour(16), "it begins again");
    let distinct: std::collections::BTreeSet<[u32; 3]> = (1..=15)
        .map(|index| palette.colour(index).unwrap().map(f32::to_bits))
        .collect();
    assert_eq!(distinct.len(), 15);
    assert!(palette.set_colour(0, [1.0, 0.5, 0.0]));
    assert!(!palette.set_colour(0, [1.0, 0.5, 0.0]), "twice");
    let [r, g, b] = palette.colour(0).unwrap();
    assert!(r == 1.0 && (g - 0.214).abs() < 1e-3 && b == 0.0, "linear");
    for part in [0.0, 0.01, 0.2, 0.7, 1.0] {
        assert!((srgb(linear(part)) - part).abs() < 1e-5);
    }
    assert!(!palette.is_bark(Paint::default()) && Palette::default().is_bark(Paint::default()));
}
