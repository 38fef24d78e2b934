//! Where leaves stand, which twigs bear them, and what they are like.

#![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]

use super::*;
use crate::tree::Node;

/// A trunk of four metres with a twig of two to each side at its top.
fn fork() -> Tree {
    let mut tree = Tree {
        letters: vec!["F".to_owned()],
        ..Tree::default()
    };
    let nodes = [
        (NO_PARENT, [0.0, 0.0, 0.0], 0.2, 0),
        (0, [0.0, 4.0, 0.0], 0.2, 0),
        (1, [2.0, 4.0, 0.0], 0.01, 1),
        (1, [-2.0, 4.0, 0.0], 0.01, 1),
    ];
    for (birth, (parent, place, radius, order)) in (0..).zip(nodes) {
        tree.push(Node {
            parent,
            position: Vec3::from(place),
            radius,
            letter: 0,
            order,
            birth,
        });
    }
    tree
}

fn worn(bearing: Bearing, season: Season, seed: u64) -> Organs {
    let mut organs = Organs::default();
    let dress = Dress {
        bark: Bark::Oak,
        season,
        bears: vec![bearing],
        ..Dress::default()
    };
    let tree = fork();
    dress.put_on(&tree, &mut organs, seed, None);
    organs.validate(&tree).unwrap();
    organs
}

fn oak() -> Bearing {
    let mut oak = Bearing::of(kind("oak").unwrap());
    oak.set("twig", 0.05);
    oak.set("light", 0.0);
    oak
}

#[test]
fn leaves_stand_at_equal_distances_on_twigs_alone() {
    let organs = worn(oak(), Season::Summer, 3);
    // Two metres each at 5 cm, and one at each end.
    assert!(
        (80..=84).contains(&organs.placed.len()),
        "{}",
        organs.placed.len()
    );
    assert_eq!(organs.bark, Bark::Oak);
    let mut along: Vec<f32> = organs
        .placed
        .iter()
        .filter(|leaf| leaf.node == 2)
        .map(|leaf| leaf.position.x)
        .collect();
    along.sort_by(f32::total_cmp);
    for (at, place) in along.iter().enumerate() {
        assert!(
            (place - 0.05 * (at + 1) as f32).abs() < 0.02 || (place - 2.0).abs() < 1e-3,
            "{at} {place}"
        );
    }
    for leaf in &organs.placed {
        assert!(leaf.node >= 2 && (leaf.position.y - 4.0).abs() < 0.02);
        assert!((leaf.scale - 0.12).abs() <= 0.12 * 0.25 + 1e-5);
    }
}

#[test]
fn upper_sides_look_up_and_drooping_leaves_hang() {
    let mean = |droop: f32| {
        let mut oak = oak();
        oak.set("droop", droop);
        let placed = worn(oak, Season::Summer, 1).placed;
        let of = |part: &dyn Fn(&Placed) -> f32| {
            placed.iter().map(part).sum::<f32>() / placed.len() as f32
        };
        [
            of(&|leaf| (leaf.orientation * Vec3::Z).y),
            of(&|leaf| (leaf.orientation * Vec3::Y).y),
        ]
    };
    let [up, ahead] = mean(0.0);
    assert!(up > 0.6 && ahead.abs() < 0.25, "{up} {ahead}");
    assert!(mean(1.0)[1] < -0.7);
}

#[test]
fn order_radius_age_light_and_season_choose() {
    let count = |change: &dyn Fn(&mut Bearing), season| {
        let mut oak = oak();
        change(&mut oak);
        worn(oak, season, 9).placed.len()
    };
    let all = count(&|_| (), Season::Summer);
    assert!(count(&|b| b.set("twig", 1.0), Season::Summer) > all);
    assert_eq!(count(&|b| b.set("order", 2.0), Season::Summer), 0);
    let young = count(&|b| b.set("young", 1.0), Season::Summer);
    assert!((40..=42).contains(&young), "the newest twig alone: {young}");
    assert_eq!(count(&|b| b.tips = true, Season::Summer), 2);
    assert_eq!(count(&|b| b.set("whorl", 2.0), Season::Summer), 2 * all - 2);
    assert!(count(&|b| b.set("light", 1.0), Season::Summer) < all);
    assert_eq!(count(&|_| (), Season::Winter), 0);
    assert_eq!(
        count(&|b| b.seasons = [false, false, false, true], Season::Winter),
        all
    );
}

#[test]
fn a_seed_is_an_individual_and_autumn_is_not_green() {
    assert_eq!(
        worn(oak(), Season::Summer, 3),
        worn(oak(), Season::Summer, 3)
    );
    assert_ne!(
        worn(oak(), Season::Summer, 3),
        worn(oak(), Season::Summer, 4)
    );
    let mean = |season| {
        let organs = worn(oak(), season, 3);
        let colours = organs
            .placed
            .iter()
            .filter_map(|leaf| organs.palette.colour(leaf.paint.colour));
        colours.fold([0.0; 3], |sum: [f32; 3], one| {
            std::array::from_fn(|i| sum[i] + one[i])
        })
    };
    let [summer, autumn] = [Season::Summer, Season::Autumn].map(mean);
    assert!(
        summer[1] > summer[0] && autumn[0] > 1.3 * autumn[1],
        "{summer:?} {autumn:?}"
    );
}

#[test]
fn leaves_beyond_the_bound_are_fewer_and_larger() {
    let mut oak = oak();
    oak.set("every", 1e-4);
    oak.set("whorl", 12.0);
    let mut tree = fork();
    let ends = [tree.position[2] * 60.0, tree.position[3] * 60.0];
    tree.position[2] = ends[0];
    tree.position[3] = ends[1];
    let mut organs = Organs::default();
    Dress {
        bears: vec![oak],
        ..Dress::default()
    }
    .put_on(&tree, &mut organs, 0, None);
    let most = usize::try_from(MOST_LEAVES).unwrap();
    assert!(
        (most / 100 * 99..most / 100 * 101).contains(&organs.placed.len()),
        "{}",
        organs.placed.len()
    );
    let mean =
        organs.placed.iter().map(|leaf| leaf.scale).sum::<f32>() / organs.placed.len() as f32;
    assert!(mean > 0.3, "{mean}");
}

/// A kind says what differs from its usual. (That a grammar reads it again: `lsystem::look`.)
#[test]
fn every_kind_says_itself() {
    for kind in kinds() {
        let mut bearing = Bearing::of(kind);
        assert_eq!(bearing.to_string(), kind.name);
        assert!(!bearing.surface.indices.is_empty(), "{}", kind.name);
        bearing.set("size", 0.5);
        bearing.set("young", 4.0);
        bearing.seasons = [true, false, false, true];
        assert_eq!(
            bearing.to_string(),
            format!("{} size 0.5 young 4 in spring winter", kind.name)
        );
        for season in Season::ALL {
            assert!(!kind.colours(season).is_empty());
        }
    }
}

/// What stood a step ago wears the same leaves, whatever numbers its nodes have now.
#[test]
fn old_twigs_keep_their_leaves() {
    let young = fork();
    let mut old = Tree {
        letters: young.letters.clone(),
        ..Tree::default()
    };
    // A new twig before the others, as the turtle writes it depth first.
    let extra = Node {
        parent: 0,
        position: Vec3::new(0.0, 1.0, 2.0),
        radius: 0.01,
        letter: 0,
        order: 1,
        birth: 9,
    };
    for node in 0..young.len() {
        if node == 1 {
            old.push(extra);
        }
        let parent = match young.parent[node] {
            0 | NO_PARENT => young.parent[node],
            parent => parent + 1,
        };
        old.push(Node {
            parent,
            position: young.position[node],
            radius: young.radius[node],
            letter: 0,
            order: young.order[node],
            birth: young.birth[node],
        });
    }
    old.validate().unwrap();
    let places = |tree: &Tree| {
        let mut organs = Organs::default();
        Dress {
            bears: vec![oak()],
            ..Dress::default()
        }
        .put_on(tree, &mut organs, 5, None);
        let of_old = organs.placed.iter().filter(|leaf| leaf.birth < 9);
        of_old
            .map(|leaf| {
                (
                    leaf.position.to_array().map(f32::to_bits),
                    leaf.scale.to_bits(),
                    leaf.paint.colour,
                )
            })
            .collect::<std::collections::BTreeSet<_>>()
    };
    assert_eq!(places(&young), places(&old));
}

#[test]
fn hostile_trees_are_no_panic() {
    // Very many leaves along very long twigs.
    let mut tree = fork();
    for place in tree.position.iter_mut() {
        *place *= 1e6;
    }
    tree.push(Node {
        parent: 2,
        position: tree.position[2] + Vec3::X,
        radius: 0.01,
        letter: 0,
        order: 1,
        birth: 0,
    });
    let mut dense = oak();
    dense.set("every", 1e-4);
    let mut organs = Organs::default();
    Dress {
        bears: vec![dense],
        ..Dress::default()
    }
    .put_on(&tree, &mut organs, 0, None);
    assert!(organs.placed.len() as u64 <= MOST_LEAVES + 10);

    for place in [Vec3::ZERO, Vec3::splat(f32::MAX), Vec3::Y * 1e-30] {
        let mut tree = fork();
        tree.position[2] = place;
        let mut organs = Organs::default();
        Dress {
            bears: vec![oak()],
            ..Dress::default()
        }
        .put_on(&tree, &mut organs, 0, None);
        assert!(organs.placed.iter().all(|leaf| leaf.scale.is_finite()));
    }
}

/// A trunk of four metres with so many twigs of a metre about its top.
fn besom(twigs: u8) -> Tree {
    let mut tree = fork();
    for twig in 0..twigs {
        let turn = GOLDEN * f32::from(twig);
        tree.push(Node {
            parent: 1,
            position: Vec3::new(turn.cos(), 4.2 + 0.01 * f32::from(twig), turn.sin()),
            radius: 0.01,
            letter: 0,
            order: 1,
            birth: 4,
        });
    }
    tree
}

fn on_besom(change: impl Fn(&mut Bearing), season: Season) -> Organs {
    let mut oak = Bearing::of(kind("oak").unwrap());
    oak.set("twig", 0.05);
    change(&mut oak);
    let mut organs = Organs::default();
    let dress = Dress {
        season,
        bears: vec![oak],
        ..Dress::default()
    };
    dress.put_on(&besom(100), &mut organs, 4, None);
    assert!(organs.placed.is_empty() || organs.bare.is_empty());
    organs
}

/// However many a twig bears: some of those on top stand.
#[test]
fn far_too_many_leave_no_tree_bare() {
    for (every, size) in [(1e-4, 0.1), (0.03, 30.0), (1e-4, 100.0)] {
        let change = |oak: &mut Bearing| {
            oak.set("every", every);
            oak.set("size", size);
        };
        let organs = on_besom(change, Season::Summer);
        let stand = organs.placed.len();
        assert!(stand > 100, "every {every} size {size}: {stand}");
    }
}

#[test]
fn what_is_borne_nowhere_is_told() {
    let told = |change: &dyn Fn(&mut Bearing), season| -> Vec<String> {
        let bare = on_besom(change, season).bare;
        bare.iter().map(ToString::to_string).collect()
    };
    assert_eq!(told(&|_| (), Season::Summer), [""; 0]);
    assert_eq!(told(&|_| (), Season::Winter), [""; 0], "it is the season");
    assert_eq!(
        told(&|oak| oak.set("order", 9.0), Season::Summer),
        [
            "`bears oak twig 0.05 order 9`: no twig bears any; see what `twig`, `order`, `young` and `every` ask for"
        ]
    );
    let dark = |oak: &mut Bearing| {
        oak.set("every", 1e-4);
        oak.set("light", 1.0);
    };
    assert_eq!(
        told(&dark, Season::Summer),
        [
            "`bears oak every 0.0001 twig 0.05 light 1`: none stands, as all would stand in the dark, with less than 1 of the sky's light; give fewer or smaller ones, or a lower `light`"
        ]
    );
}

/// Leaves do not hang into the ground, and above it they are as without one.
#[test]
fn leaves_know_the_ground() {
    let mut hanging = oak();
    hanging.set("droop", 1.0);
    hanging.set("size", 1.0);
    let of = |ground: Option<f32>| {
        let mut organs = Organs::default();
        let dress = Dress {
            bears: vec![hanging.clone()],
            ..Dress::default()
        };
        dress.put_on(&fork(), &mut organs, 2, ground);
        organs.placed
    };
    let tip = |leaf: &Placed| (leaf.position + leaf.orientation * Vec3::Y * leaf.scale).y;
    let free = of(None);
    assert!(free.iter().any(|leaf| tip(leaf) < 3.2));
    assert_eq!(of(Some(2.0)), free, "none comes near it");
    let lying = of(Some(3.7));
    assert_eq!(lying.len(), free.len());
    assert!(lying.iter().all(|leaf| tip(leaf) > 3.7 - 1e-5));
    // From below it they lie level.
    for leaf in of(Some(4.5)) {
        assert!(tip(&leaf) > leaf.position.y - 1e-5 && leaf.orientation.is_normalized());
    }
}

/// Spines stand on the bark, on the dome of a cactus, too; other trees end in points, and so do cactuses without a flare.
#[test]
fn spines_stand_on_the_dome() {
    let mut spines = Bearing::of(kind("spines").unwrap());
    spines.set("every", 0.05);
    spines.set("whorl", 12.0);
    let tops = |bark: Bark, flare: f32| -> Vec<[f32; 2]> {
        let mut tree = fork();
        tree.radius.iter_mut().for_each(|radius| *radius = 0.2);
        let mut organs = Organs::default();
        let dress = Dress {
            bark,
            flare,
            bears: vec![spines.clone()],
            ..Dress::default()
        };
        dress.put_on(&tree, &mut organs, 1, None);
        let on_twig = organs.placed.iter().filter(|one| one.node == 2);
        let near = on_twig.filter(|one| one.position.x > 1.81);
        near.map(|one| {
            let aside = (one.position - Vec3::Y * 4.0).reject_from(Vec3::X).length();
            [2.0 - one.position.x, aside]
        })
        .collect()
    };
    let domed = tops(Bark::Cactus, 0.1);
    assert!(domed.len() >= 36, "{}", domed.len());
    for [below, aside] in domed.iter().filter(|[below, _]| *below > 1e-4) {
        let round = (0.04 - (0.2 - below).powi(2)).sqrt();
        assert!(
            (aside - round).abs() < 1e-3,
            "{below}: {aside}, not {round}"
        );
    }
    for (bark, flare) in [(Bark::Cactus, 0.0), (Bark::Oak, 0.1)] {
        let straight = tops(bark, flare);
        assert!(
            straight
                .iter()
                .all(|[below, aside]| *below < 1e-4 || (aside - 0.2).abs() < 1e-4)
        );
    }
}
