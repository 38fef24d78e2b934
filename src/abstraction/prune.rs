//! Algorithm 2: segments that run into what was built before, or leave an ellipsoid, are not built, and nothing grows from them.
//!
//! In the source pieces that grow from what was left out stay and float. Segments are capsules here: two intersect where their axes are nearer to each other
//! than the sum of their radii, which is exact. Their boxes stand in a hierarchy that grows with the tree, so each is tried against those about it alone.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;

use crate::tree::{NO_PARENT, Node, Tree};

/// A segment as it is tried.
#[derive(Clone, Copy, Debug)]
struct Capsule {
    from: DVec3,
    to: DVec3,
    radius: f64,
    /// The nodes that it begins and ends at.
    nodes: [u32; 2],
}

impl Capsule {
    /// Whether it runs into one that is neither its parent nor a sibling.
    fn runs_into(&self, other: &Self) -> bool {
        if other.nodes.contains(&self.nodes[0]) {
            return false;
        }
        let apart = distance_squared([self.from, self.to], [other.from, other.to]);
        apart < (self.radius + other.radius).powi(2)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "the box is made larger by what rounding may take"
    )]
    fn bounds(&self) -> Aabb {
        let around = DVec3::splat(self.radius * (1.0 + 1e-6));
        let [low, high] = [
            self.from.min(self.to) - around,
            self.from.max(self.to) + around,
        ];
        let low = Vec3A::new(low.x as f32, low.y as f32, low.z as f32);
        let high = Vec3A::new(high.x as f32, high.y as f32, high.z as f32);
        Aabb {
            min: low.map(f32::next_down),
            max: high.map(f32::next_up),
        }
    }
}

/// A tree without the segments that run into others (where `intersections`), other than into their parent and the siblings that begin where they do, or that
/// leave the ellipsoid about the root with these radii, and without what grows from them.
pub fn pruned(tree: &Tree, intersections: bool, ellipsoid: Option<[f64; 3]>) -> Tree {
    let mut kept = Tree {
        letters: tree.letters.clone(),
        ..Tree::default()
    };
    let mut places = vec![NO_PARENT; tree.len()];
    let mut built = Built::default();
    let place = |node: u32| tree.position[node as usize].as_dvec3();
    let root = if tree.is_empty() {
        DVec3::ZERO
    } else {
        place(0)
    };
    let leaves = |point: DVec3| {
        ellipsoid.is_some_and(|radii| ((point - root) / DVec3::from(radii)).length_squared() > 1.0)
    };
    for node in (0_u32..).take(tree.len()) {
        let parent = tree.parent[node as usize];
        let mut kept_parent = NO_PARENT;
        if parent != NO_PARENT {
            kept_parent = places[parent as usize];
            if kept_parent == NO_PARENT || leaves(place(node)) {
                continue;
            }
            let capsule = Capsule {
                from: place(parent),
                to: place(node),
                radius: f64::from(tree.radius[node as usize]),
                nodes: [kept_parent, next(&kept)],
            };
            if intersections && !built.add(capsule) {
                continue;
            }
        }
        let at = node as usize;
        places[at] = kept.push(Node {
            parent: kept_parent,
            position: tree.position[at],
            radius: tree.radius[at],
            letter: tree.letter[at],
            order: tree.order[at],
            birth: tree.birth[at],
        });
    }
    kept
}

/// The number of the node that is pushed next.
fn next(tree: &Tree) -> u32 {
    u32::try_from(tree.len()).unwrap_or(NO_PARENT)
}

/// What was built.
#[derive(Default)]
struct Built {
    capsules: Vec<Capsule>,
    hierarchy: Bvh2,
}

impl Built {
    /// Adds a segment, unless it runs into another. Whether it was.
    fn add(&mut self, capsule: Capsule) -> bool {
        let mut is_free = true;
        let bounds = capsule.bounds();
        self.hierarchy.aabb_traverse(bounds, |hierarchy, node| {
            let node = &hierarchy.nodes[node as usize];
            let first = node.first_index as usize;
            let others = &hierarchy.primitive_indices[first..first + node.prim_count as usize];
            is_free = others
                .iter()
                .all(|other| !capsule.runs_into(&self.capsules[*other as usize]));
            is_free
        });
        if is_free {
            let number = u32::try_from(self.capsules.len()).unwrap_or(NO_PARENT);
            self.hierarchy.insert_primitive(bounds, number);
            self.capsules.push(capsule);
        }
        is_free
    }
}

/// The square of the distance between two straight pieces (Ericson 2005, "Real-Time Collision Detection", 5.1.9).
fn distance_squared([from, to]: [DVec3; 2], [other_from, other_to]: [DVec3; 2]) -> f64 {
    let (along, other_along) = (to - from, other_to - other_from);
    let apart = from - other_from;
    let (length, other_length) = (along.length_squared(), other_along.length_squared());
    let (here, there) = (along.dot(apart), other_along.dot(apart));
    let part_of = |number: f64, of: f64| {
        if of > 0.0 {
            (number / of).clamp(0.0, 1.0)
        } else {
            0.0
        }
    };
    let both = along.dot(other_along);
    let square = length * other_length - both * both;
    let mut s = part_of(both * there - here * other_length, square);
    let mut t = (both * s + there) / other_length;
    // Where the nearest of the other's line is beyond its end, the nearest of this one is that end's.
    if t.is_nan() || t < 0.0 {
        t = 0.0;
        s = part_of(-here, length);
    } else if t > 1.0 {
        t = 1.0;
        s = part_of(both - here, length);
    }
    (from + s * along).distance_squared(other_from + t * other_along)
}
