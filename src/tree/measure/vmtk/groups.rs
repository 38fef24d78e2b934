//! What is measured on branches and bifurcations.

use std::collections::BTreeMap;

use glam::DVec3;

use super::super::branch::RadiusAlong;
use super::super::course::Course;
use super::super::frame::{Daughter, Direction, Frame, apart, middle};
use super::super::junction::angle;
use super::super::statistics::spread;
use super::super::table::{Parts, Table, point_radii};
use super::Split;
use super::lines::{Ball, HALVINGS, Lines};
use super::tracts::{Down, Groups, Tract};

/// A branch: what of its lines is outside bifurcations. Lengths are in the tree's unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Branch {
    /// Its number among branches and bifurcations together, as VMTK's group ids.
    pub group: usize,
    /// The place among bifurcations of the one that it begins in; None at the root.
    pub up: Option<usize>,
    /// The place among bifurcations of the one that it ends in; None at a tip.
    pub down: Option<usize>,
    /// The node of the tip.
    pub tip: Option<u32>,
    /// Its tracts; lines differ in where it begins and ends.
    pub tracts: Vec<Tract>,
    /// Mean over its lines.
    pub length: f64,
    /// Length over the distance of its mean ends, less 1.
    pub tortuosity: f64,
    /// Mean curvature, by steps of a ball. None with fewer than three of these.
    pub curvature: Option<f64>,
    /// Mean torsion, by steps of a ball. None with fewer than five.
    pub torsion: Option<f64>,
    /// The radius along its longest tract.
    pub radius: RadiusAlong,
    /// Mean first and last point, by the square of the radius.
    pub ends: [DVec3; 2],
    /// Directions where it begins and ends, of length 1, of its longest tract.
    pub tangents: [DVec3; 2],
    /// Lines in it: tips at its end that are branches.
    pub tips: u32,
}

/// The direction of a branch at a bifurcation, with the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector {
    /// The place of the branch.
    pub branch: usize,
    /// Over one sphere, as long as that.
    pub vector: DVec3,
    /// Whether the branch is shorter than that, and this is all of it.
    pub is_short: bool,
    /// Its angles in the frame.
    pub direction: Direction,
}

/// A bifurcation, of any number of daughters. Angles are in radians.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bifurcation {
    /// Its number among branches and bifurcations together, as VMTK's group ids.
    pub group: usize,
    /// The forks of the tree that are in it.
    pub forks: Vec<u32>,
    /// The blanked tracts.
    pub tracts: Vec<Tract>,
    /// Its reference system.
    pub frame: Frame,
    /// The branch that leads to it; None where the tree begins in it.
    pub parent: Option<Vector>,
    /// The branches that begin in it.
    pub daughters: Vec<Vector>,
    /// Angles between daughters' vectors: of the first and second, the first and third, … the second and third, and so on.
    pub angles: Vec<f64>,
    /// Differences of the angles in the plane, likewise, 0 to π.
    pub in_plane: Vec<f64>,
}

/// Measures groups.
pub(super) fn split(lines: &Lines<'_>, groups: Groups) -> Split {
    let mut split = Split {
        swallowed: groups.swallowed,
        ..Split::default()
    };
    let order = |tracts: &[Tract]| {
        let first = tracts.iter().map(|tract| tract.from);
        let key = first.map(|from| (lines.place[from.node as usize], from.along));
        key.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)))
            .unwrap_or_default()
    };
    let mut bifurcations: Vec<_> = groups.bifurcations.into_iter().collect();
    bifurcations.sort_by(|(_, a), (_, b)| by(order(&a.1), order(&b.1)));
    let place: BTreeMap<u32, usize> = bifurcations
        .iter()
        .enumerate()
        .map(|(place, (fork, _))| (*fork, place))
        .collect();
    let mut branches: Vec<_> = groups.branches.into_iter().collect();
    branches.sort_by(|(_, a), (_, b)| by(order(a), order(b)));
    for ((up, down), tracts) in branches {
        let mut branch = measured(lines, tracts);
        branch.up = up.and_then(|fork| place.get(&fork).copied());
        (branch.down, branch.tip) = match down {
            Down::Bifurcation(fork) => (place.get(&fork).copied(), None),
            Down::Tip(node) => (None, Some(node)),
        };
        split.branches.push(branch);
    }
    let mut neighbours = vec![(None, Vec::new()); bifurcations.len()];
    for (number, branch) in split.branches.iter().enumerate() {
        if let Some(up) = branch.up {
            neighbours[up].1.push(number);
        }
        if let Some(down) = branch.down {
            neighbours[down].0 = Some(number);
        }
    }
    for ((_, (forks, tracts)), (parent, daughters)) in bifurcations.into_iter().zip(neighbours) {
        let found = bifurcation(lines, &split.branches, (forks, tracts), parent, &daughters);
        split.bifurcations.push(found);
    }
    number(&mut split, &order);
    split.table = table(lines, &split);
    split
}

/// The table of branches by this definition.
fn table(lines: &Lines<'_>, split: &Split) -> Table {
    let branches = &split.branches;
    let mut first = (0..branches.len()).filter(|place| branches[*place].up.is_none());
    // Where trees begin with more than one there is no stem.
    let stem = first.next().filter(|_| first.next().is_none());
    let longest = branches.iter().map(|branch| {
        let tracts = branch.tracts.iter();
        tracts.max_by(|a, b| a.length().total_cmp(&b.length()))
    });
    let lines_of = longest.flatten().map(|tract| {
        let balls = lines.balls(tract.from, tract.to);
        balls.into_iter().map(|ball| (ball.centre, ball.radius))
    });
    let smallest = branches.iter().map(|branch| branch.radius.min);
    let total = branches.iter().map(|branch| branch.length).sum();
    let tips = lines
        .nodes
        .iter()
        .filter(|node| lines.parent(**node).is_some());
    Parts {
        lengths: branches.iter().map(|branch| branch.length).collect(),
        tangents: branches.iter().map(|branch| branch.tangents).collect(),
        point_radius: point_radii(lines_of, smallest, total),
        centerline_length: spread(tips.map(|node| lines.along[*node as usize])),
        stem,
        angles: spread(
            split
                .bifurcations
                .iter()
                .flat_map(|one| one.angles.iter().copied()),
        ),
        in_plane: spread(
            split
                .bifurcations
                .iter()
                .flat_map(|one| one.in_plane.iter().copied()),
        ),
        curvature: spread(branches.iter().filter_map(|branch| branch.curvature)),
        torsion: spread(branches.iter().filter_map(|branch| branch.torsion)),
        tortuosity: spread(branches.iter().map(|branch| branch.tortuosity)),
    }
    .table()
}

fn by(a: (u32, f64), b: (u32, f64)) -> std::cmp::Ordering {
    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
}

/// Numbers branches and bifurcations together, each behind what it grows from.
fn number(split: &mut Split, order: &dyn Fn(&[Tract]) -> (u32, f64)) {
    let (mut branch, mut bifurcation) = (0, 0);
    for group in 0..split.branches.len() + split.bifurcations.len() {
        let of_branch = split.branches.get(branch).map(|one| order(&one.tracts));
        let of_bifurcation = split.bifurcations.get(bifurcation);
        let of_bifurcation = of_bifurcation.map(|one| order(&one.tracts));
        let is_branch = match (of_branch, of_bifurcation) {
            (Some(one), Some(other)) => by(one, other).is_le(),
            (one, _) => one.is_some(),
        };
        if is_branch {
            split.branches[branch].group = group;
            branch += 1;
        } else {
            split.bifurcations[bifurcation].group = group;
            bifurcation += 1;
        }
    }
}

fn measured(lines: &Lines<'_>, tracts: Vec<Tract>) -> Branch {
    let all: f64 = tracts.iter().map(|tract| f64::from(tract.lines)).sum();
    let part = |tract: &Tract| f64::from(tract.lines) / all;
    let length: f64 = tracts.iter().map(|one| part(one) * one.length()).sum();
    let ends = [false, true].map(|is_last| {
        let balls = tracts.iter().map(|tract| Ball {
            centre: lines
                .ball_at(if is_last { tract.to } else { tract.from })
                .centre,
            // So that its square is the weight.
            radius: lines
                .ball_at(if is_last { tract.to } else { tract.from })
                .radius
                * f64::from(tract.lines).sqrt(),
        });
        middle(&balls.collect::<Vec<_>>())
    });
    let mut bends = [(0.0, 0.0); 2];
    for tract in &tracts {
        let stepped = steps(&lines.balls(tract.from, tract.to));
        for (sum, found) in bends.iter_mut().zip(bends_of(&stepped)) {
            if let Some(found) = found {
                *sum = (sum.0 + part(tract) * found, sum.1 + part(tract));
            }
        }
    }
    let [curvature, torsion] = bends.map(|(sum, parts)| (parts > 0.0).then(|| sum / parts));
    let longest = tracts
        .iter()
        .max_by(|a, b| a.length().total_cmp(&b.length()));
    let balls = longest.map_or_else(Vec::new, |tract| lines.balls(tract.from, tract.to));
    let points: Vec<DVec3> = balls.iter().map(|ball| ball.centre).collect();
    let radius = radius_along(&balls);
    Branch {
        length,
        tortuosity: length / ends[0].distance(ends[1]) - 1.0,
        curvature,
        torsion,
        radius,
        ends,
        tangents: Course::new(&points, radius.mean).end_tangents(),
        tips: tracts.iter().map(|tract| tract.lines).sum(),
        tracts,
        ..Branch::default()
    }
}

fn radius_along(balls: &[Ball]) -> RadiusAlong {
    let (mut length, mut weighted) = (0.0, 0.0);
    for pair in balls.windows(2) {
        let step = pair[0].centre.distance(pair[1].centre);
        length += step;
        weighted += step * f64::midpoint(pair[0].radius, pair[1].radius);
    }
    let all = || balls.iter().map(|ball| ball.radius);
    let [start, end] = [all().next(), all().next_back()].map(Option::unwrap_or_default);
    RadiusAlong {
        mean: if length > 0.0 {
            weighted / length
        } else {
            start
        },
        min: all().fold(f64::INFINITY, f64::min),
        max: all().fold(0.0, f64::max),
        start,
        end,
    }
}

/// The last point in order whose ball still reaches a point of the line, from there on without a gap; with the place of the ball behind it.
fn reaching(balls: &[Ball], from: Ball, behind: usize) -> Option<(Ball, usize)> {
    let mut within = from;
    for (place, ball) in balls.iter().enumerate().skip(behind) {
        if !ball.reaches(from.centre) {
            let (mut least, mut most) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let middle = f64::midpoint(least, most);
                *(if within.lerp(*ball, middle).reaches(from.centre) {
                    &mut least
                } else {
                    &mut most
                }) = middle;
            }
            return Some((within.lerp(*ball, least), place));
        }
        within = *ball;
    }
    None
}

/// Points of a line one ball apart, with its ends.
fn steps(balls: &[Ball]) -> Vec<DVec3> {
    let (Some(first), Some(last)) = (balls.first(), balls.last()) else {
        return Vec::new();
    };
    let mut points = vec![first.centre];
    let (mut at, mut behind) = (*first, 1);
    while let Some((next, place)) = reaching(balls, at, behind) {
        // Balls without a radius reach nothing but themselves.
        let next = if next.centre == at.centre {
            balls[place]
        } else {
            next
        };
        behind = if next == balls[place] {
            place + 1
        } else {
            place
        };
        at = next;
        points.push(at.centre);
    }
    if at.centre != last.centre {
        points.push(last.centre);
    }
    points
}

/// Points at which a line turns by less, in radians, are in a line: positions in single precision are off by as much.
const STRAIGHT: f64 = 1e-5;

/// Mean curvature and torsion of points as VMTK takes them: differences of neighbours, weighted by length.
fn bends_of(points: &[DVec3]) -> [Option<f64>; 2] {
    let steps: Vec<[f64; 2]> = points
        .windows(3)
        .map(|three| [three[0].distance(three[1]), three[1].distance(three[2])])
        .collect();
    let second = |place: usize| {
        let [a, b] = steps[place];
        let three = &points[place..place + 3];
        ((three[2] - three[1]) / b - (three[1] - three[0]) / a) / f64::midpoint(a, b)
    };
    let first =
        |place: usize| (points[place + 2] - points[place]) / (steps[place][0] + steps[place][1]);
    let mut sums = [(0.0, 0.0); 2];
    let mut add = |which: usize, value: f64, weight: f64| {
        if value.is_finite() {
            let sum: &mut (f64, f64) = &mut sums[which];
            *sum = (sum.0 + weight * value, sum.1 + weight);
        }
    };
    for place in 0..steps.len() {
        let weight = f64::midpoint(steps[place][0], steps[place][1]);
        let across = first(place).cross(second(place));
        add(0, across.length() / first(place).length().powi(3), weight);
        if place > 0 && place + 1 < steps.len() {
            let third = (second(place + 1) - second(place - 1)) / (2.0 * weight);
            // Where points are in a line, all but for rounding, nothing is twisted.
            let torsion = if across.length() * weight < STRAIGHT {
                0.0
            } else {
                across.dot(third) / across.length_squared()
            };
            add(1, torsion, weight);
        }
    }
    sums.map(|(sum, weights)| (weights > 0.0).then(|| sum / weights))
}

fn bifurcation(
    lines: &Lines<'_>,
    branches: &[Branch],
    (forks, tracts): (Vec<u32>, Vec<Tract>),
    parent: Option<usize>,
    daughters: &[usize],
) -> Bifurcation {
    let ways: Vec<[Ball; 2]> = tracts
        .iter()
        .map(|tract| [tract.from, tract.to].map(|place| lines.ball_at(place)))
        .collect();
    let frame = Frame::new(&ways).unwrap_or_default();
    let vector = |place: usize, is_up: bool| {
        let (vector, is_short) = vector(lines, &branches[place], is_up);
        Vector {
            branch: place,
            vector,
            is_short,
            direction: Direction::default(),
        }
    };
    let mut parent = parent.map(|place| vector(place, true));
    let mut daughters: Vec<Vector> = daughters
        .iter()
        .map(|place| vector(*place, false))
        .collect();
    let kinds = daughters.iter().map(|one| Daughter {
        vector: one.vector,
        radius: branches[one.branch].radius.mean,
        tips: branches[one.branch].tips,
        length: branches[one.branch].length,
    });
    let frame = frame.turned(&kinds.collect::<Vec<_>>());
    for one in parent.iter_mut().chain(&mut daughters) {
        one.direction = frame.direction(one.vector).unwrap_or_default();
    }
    let (mut angles, mut in_plane) = (Vec::new(), Vec::new());
    for (place, one) in daughters.iter().enumerate() {
        for other in &daughters[place + 1..] {
            angles.push(angle(one.vector, other.vector));
            in_plane.push(apart((one.direction, other.direction)));
        }
    }
    Bifurcation {
        group: 0,
        forks,
        tracts,
        frame,
        parent,
        daughters,
        angles,
        in_plane,
    }
}

/// The vector of a branch where it ends (`is_up`) or begins, and whether the branch is shorter than a sphere.
fn vector(lines: &Lines<'_>, branch: &Branch, is_up: bool) -> (DVec3, bool) {
    let mut is_short = false;
    let (mut near, mut far) = (Vec::new(), Vec::new());
    for tract in &branch.tracts {
        let mut balls = lines.balls(tract.from, tract.to);
        if is_up {
            balls.reverse();
        }
        let (Some(first), Some(last)) = (balls.first(), balls.last()) else {
            continue;
        };
        near.push(*first);
        far.push(match reaching(&balls, *first, 1) {
            Some((ball, _)) => ball,
            None => {
                is_short = true;
                *last
            }
        });
    }
    let away = middle(&far) - middle(&near);
    (if is_up { -away } else { away }, is_short)
}
