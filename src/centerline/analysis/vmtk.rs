//! What is told of branches and bifurcations by VMTK's definition. They have numbers in common, which VMTK calls group ids.

use glam::DVec3;
use serde::Serialize;

use super::super::Centerline;
use super::{FrameFacts, RadiusFacts, finite, frame};
use crate::tree::NO_PARENT;
use crate::tree::Tree;
use crate::tree::measure::Direction;
use crate::tree::measure::vmtk::{Bifurcation, Branch, Place, Split, Tract, Vector};

/// How many there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CountsVmtk {
    /// Branches.
    pub branches: usize,
    /// Bifurcations of two daughters.
    pub bifurcations: usize,
    /// Those of more.
    pub multifurcations: usize,
    /// Branches that end in a tip.
    pub tips: usize,
    /// Tips whose lines never leave another's tube: they are no branches by this definition.
    pub swallowed: usize,
}

/// A branch.
#[derive(Clone, Debug, Serialize)]
pub struct BranchVmtkFacts {
    /// Its number.
    pub group: usize,
    /// The number of the bifurcation that it begins in; null at the root.
    pub upstream: Option<usize>,
    /// The number of the bifurcation that it ends in; null at a tip.
    pub downstream: Option<usize>,
    /// The node of the tip.
    pub tip: Option<u32>,
    /// How many centerlines run in it.
    pub lines: u32,
    /// Mean of its lines.
    pub length: f64,
    /// Length over the distance of its mean ends, less 1.
    #[serde(serialize_with = "finite")]
    pub tortuosity: f64,
    /// Mean, in steps of a ball; null where it has too few of them.
    pub curvature: Option<f64>,
    /// Likewise.
    pub torsion: Option<f64>,
    /// Along its longest tract.
    pub radius: RadiusFacts,
    /// The mean of where it begins.
    pub first: DVec3,
    /// The mean of where it ends.
    pub last: DVec3,
    /// What each line has of it.
    pub tracts: Vec<TractFacts>,
}

/// A stretch of some lines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct TractFacts {
    /// Whether it is in a bifurcation and not in a branch.
    pub blanked: bool,
    /// How many lines have it.
    pub lines: u32,
    /// Its length.
    pub length: f64,
    /// Where it begins.
    pub first: DVec3,
    /// Where it ends.
    pub last: DVec3,
}

/// A bifurcation, of any number of daughters.
#[derive(Clone, Debug, Serialize)]
pub struct JunctionVmtkFacts {
    /// Its number.
    pub group: usize,
    /// The forks of the tree that are in it, by their nodes.
    pub nodes: Vec<u32>,
    /// How many branches begin in it.
    pub degree: usize,
    /// The number of the branch that leads to it; null where the tree begins in it.
    pub parent: Option<usize>,
    /// The numbers of the branches that begin in it.
    pub daughters: Vec<usize>,
    /// Between daughters in space: 1 and 2, 1 and 3, … 2 and 3, and so on.
    pub angles_deg: Vec<f64>,
    /// Between daughters in the plane in which they branch, likewise.
    pub angles_in_plane_deg: Vec<f64>,
    /// From the way through it, in the plane: of the parent, then of each daughter; null of what is not there.
    pub in_plane_deg: Vec<Option<f64>>,
    /// Out of the plane, likewise.
    pub out_of_plane_deg: Vec<Option<f64>>,
    /// The parent's vector, then the daughters', with the flow, as long as the sphere that they go over; zero of what is not there.
    pub vectors: Vec<DVec3>,
    /// Whether each of these branches is shorter than a sphere, and its vector all of it.
    pub short: Vec<bool>,
    /// The reference system.
    pub frame: FrameFacts,
    /// What each line has of it.
    pub tracts: Vec<TractFacts>,
}

pub(super) fn counts(split: &Split) -> CountsVmtk {
    let bifurcations = split.bifurcations.iter();
    let bifurcations = bifurcations.filter(|one| one.daughters.len() == 2).count();
    CountsVmtk {
        branches: split.branches.len(),
        bifurcations,
        multifurcations: split.bifurcations.len() - bifurcations,
        tips: split
            .branches
            .iter()
            .filter(|one| one.tip.is_some())
            .count(),
        swallowed: split.swallowed.len(),
    }
}

fn position(tree: &Tree, place: Place) -> DVec3 {
    let to = tree.position[place.node as usize].as_dvec3();
    match tree.parent[place.node as usize] {
        NO_PARENT => to,
        parent => tree.position[parent as usize]
            .as_dvec3()
            .lerp(to, place.part),
    }
}

fn tracts(tracts: &[Tract], found: &Centerline, blanked: bool) -> Vec<TractFacts> {
    let place = |place: Place| position(&found.tree, place) + found.origin;
    let facts = tracts.iter().map(|tract| TractFacts {
        blanked,
        lines: tract.lines,
        length: tract.length(),
        first: place(tract.from),
        last: place(tract.to),
    });
    facts.collect()
}

pub(super) fn branches(split: &Split, found: &Centerline) -> Vec<BranchVmtkFacts> {
    let group = |place: Option<usize>| place.map(|place| split.bifurcations[place].group);
    let facts = |branch: &Branch| BranchVmtkFacts {
        group: branch.group,
        upstream: group(branch.up),
        downstream: group(branch.down),
        tip: branch.tip,
        lines: branch.tips,
        length: branch.length,
        tortuosity: branch.tortuosity,
        curvature: branch.curvature,
        torsion: branch.torsion,
        radius: RadiusFacts {
            along: branch.radius,
            taper: branch.radius.taper(branch.length),
        },
        first: branch.ends[0] + found.origin,
        last: branch.ends[1] + found.origin,
        tracts: tracts(&branch.tracts, found, false),
    };
    split.branches.iter().map(facts).collect()
}

pub(super) fn junctions(split: &Split, found: &Centerline) -> Vec<JunctionVmtkFacts> {
    let facts = |one: &Bifurcation| {
        let group = |vector: &Vector| split.branches[vector.branch].group;
        let in_degrees = |angles: &[f64]| angles.iter().map(|angle| angle.to_degrees()).collect();
        let all = || std::iter::once(one.parent).chain(one.daughters.iter().copied().map(Some));
        let angles = |of: fn(Direction) -> f64| {
            let angles = all().map(|one| one.map(|one| of(one.direction).to_degrees()));
            angles.collect()
        };
        JunctionVmtkFacts {
            group: one.group,
            nodes: one.forks.clone(),
            degree: one.daughters.len(),
            parent: one.parent.as_ref().map(group),
            daughters: one.daughters.iter().map(group).collect(),
            angles_deg: in_degrees(&one.angles),
            angles_in_plane_deg: in_degrees(&one.in_plane),
            in_plane_deg: angles(|one| one.in_plane),
            out_of_plane_deg: angles(|one| one.out_of_plane),
            vectors: all()
                .map(|one| one.map_or(DVec3::ZERO, |one| one.vector))
                .collect(),
            short: all()
                .map(|one| one.is_some_and(|one| one.is_short))
                .collect(),
            frame: frame(one.frame, found.origin),
            tracts: tracts(&one.tracts, found, true),
        }
    };
    split.bifurcations.iter().map(facts).collect()
}
