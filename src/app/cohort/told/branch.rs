//! Branches as analyses tell them: whole ones, and those of VMTK's definition, of which fewer measures are told.

use serde::Deserialize;

use super::Radius;

/// What a branch is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Definition {
    /// From junction to junction, or to the root or a tip.
    Whole,
    /// As VMTK has it: outside bifurcations, which begin one sphere before a line leaves another's tube.
    Vmtk,
}

impl Definition {
    /// Both, in the order of tables.
    pub const ALL: [Self; 2] = [Self::Whole, Self::Vmtk];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole",
            Self::Vmtk => "vmtk",
        }
    }

    /// What names of columns begin with that are of it.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::Whole => "",
            Self::Vmtk => "vmtk_",
        }
    }
}

/// A branch, by either definition; what one does not tell is not there.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "named as what is read")]
pub struct Branch {
    pub definition: Definition,
    /// Its number; VMTK's group.
    pub id: usize,
    pub parent: Option<usize>,
    pub upstream: Option<usize>,
    pub downstream: Option<usize>,
    pub order: Option<u32>,
    pub strahler: Option<u32>,
    pub horsfield: Option<u32>,
    pub tips: u32,
    pub length: Option<f64>,
    pub chord: Option<f64>,
    pub tortuosity: Option<f64>,
    pub curvature: Option<f64>,
    pub torsion: Option<f64>,
    pub radius: Radius,
    pub volume: Option<f64>,
    pub area: Option<f64>,
    pub nodes: Option<[u32; 2]>,
}

/// As [`BranchFacts`](crate::centerline::analysis::BranchFacts).
#[derive(Deserialize)]
pub(super) struct Whole {
    id: usize,
    parent: Option<usize>,
    order: u32,
    strahler: u32,
    horsfield: u32,
    tips: u32,
    length: Option<f64>,
    chord: Option<f64>,
    tortuosity: Option<f64>,
    curvature: Option<f64>,
    torsion: Option<f64>,
    radius: Radius,
    volume: Option<f64>,
    area: Option<f64>,
    nodes: [u32; 2],
}

/// As [`BranchVmtkFacts`](crate::centerline::analysis::BranchVmtkFacts).
#[derive(Deserialize)]
pub(super) struct Vmtk {
    group: usize,
    upstream: Option<usize>,
    downstream: Option<usize>,
    lines: u32,
    length: Option<f64>,
    tortuosity: Option<f64>,
    curvature: Option<f64>,
    torsion: Option<f64>,
    radius: Radius,
    first: [Option<f64>; 3],
    last: [Option<f64>; 3],
}

impl From<Whole> for Branch {
    fn from(one: Whole) -> Self {
        Self {
            definition: Definition::Whole,
            id: one.id,
            parent: one.parent,
            upstream: None,
            downstream: None,
            order: Some(one.order),
            strahler: Some(one.strahler),
            horsfield: Some(one.horsfield),
            tips: one.tips,
            length: one.length,
            chord: one.chord,
            tortuosity: one.tortuosity,
            curvature: one.curvature,
            torsion: one.torsion,
            radius: one.radius,
            volume: one.volume,
            area: one.area,
            nodes: Some(one.nodes),
        }
    }
}

impl From<Vmtk> for Branch {
    fn from(one: Vmtk) -> Self {
        Self {
            definition: Definition::Vmtk,
            id: one.group,
            parent: None,
            upstream: one.upstream,
            downstream: one.downstream,
            order: None,
            strahler: None,
            horsfield: None,
            tips: one.lines,
            length: one.length,
            chord: apart(one.first, one.last),
            tortuosity: one.tortuosity,
            curvature: one.curvature,
            torsion: one.torsion,
            radius: one.radius,
            volume: None,
            area: None,
            nodes: None,
        }
    }
}

/// The distance of two places, where both are known.
fn apart(a: [Option<f64>; 3], b: [Option<f64>; 3]) -> Option<f64> {
    let mut squares = 0.0;
    for (a, b) in a.into_iter().zip(b) {
        squares += (a? - b?).powi(2);
    }
    Some(squares.sqrt()).filter(|distance: &f64| distance.is_finite())
}
