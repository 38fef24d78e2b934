//! What is told of a model whose centerlines were found and measured: the JSON object `ramus-analysis/1`.
//!
//! Positions are in the model's own coordinates and unit, lengths in that unit, angles in degrees where a name says so. Branches are
//! whole, from junction to junction, or to the root or a tip; and where a name ends in `_vmtk` they are as [VMTK defines
//! them](crate::tree::measure::vmtk).

mod lines;
mod vmtk;

use glam::DVec3;
use serde::{Serialize, Serializer};

pub use self::lines::CenterlineFacts;
pub use self::vmtk::{BranchVmtkFacts, CountsVmtk, JunctionVmtkFacts, TractFacts};
use super::{Centerline, Unreached};
use crate::mesh::endpoints::Kind;
use crate::mesh::report::Report;
use crate::mesh::unit::Scale;
use crate::tree::measure::{
    Branch, Direction, Frame, Junction, Measures, OfOrder, Order, RadiusAlong, Spread, Table,
};
use crate::tree::{NO_PARENT, Tree};

/// The format's name.
pub const FORMAT: &str = "ramus-analysis/1";

/// Everything that is told.
#[derive(Clone, Debug, Serialize)]
pub struct Analysis {
    /// [`FORMAT`].
    pub format: &'static str,
    /// What was measured.
    pub model: ModelFacts,
    /// Where centerlines begin and end.
    pub endpoints: EndpointFacts,
    /// How many there are of everything.
    pub counts: Counts,
    /// How many there are of what VMTK's definition of a branch has; null where balls overlap too much for it.
    pub counts_vmtk: Option<CountsVmtk>,
    /// Means and deviations, of whole branches.
    pub table: TableFacts,
    /// The same by VMTK's definition of a branch; null where balls overlap too much for it.
    pub table_vmtk: Option<TableFacts>,
    /// Each way from the source to a target, or from the root to a tip.
    pub centerlines: Vec<CenterlineFacts>,
    /// By Strahler's orders.
    pub orders: OrderFacts,
    /// Each branch.
    pub branches: Vec<BranchFacts>,
    /// Each branch by VMTK's definition.
    pub branches_vmtk: Vec<BranchVmtkFacts>,
    /// Each junction.
    pub junctions: Vec<JunctionFacts>,
    /// Each bifurcation, of any number of daughters, by VMTK's definition.
    pub junctions_vmtk: Vec<JunctionVmtkFacts>,
    /// The tree.
    pub nodes: Nodes,
    /// How long the stages took.
    pub timing_ms: Timing,
}

/// The model.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ModelFacts {
    /// Its file.
    pub file: String,
    /// Triangles of the file.
    pub triangles: usize,
    /// Vertices of the file.
    pub vertices: usize,
    /// What a number of it most likely stands for.
    pub unit: Option<&'static str>,
    /// How many metres one is.
    pub scale: Option<f64>,
    /// Parts that hang together.
    pub components: usize,
    /// Closed lines along which it is open.
    pub open_ends: usize,
    /// Whether it encloses a space.
    pub watertight: bool,
    /// The box around it.
    pub bounds: Bounds,
}

/// A box.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Bounds {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

/// Where centerlines begin and end.
#[derive(Clone, Debug, Default, Serialize)]
pub struct EndpointFacts {
    /// The source; null for trees that were read.
    pub source: Option<DVec3>,
    /// The targets, in their order.
    pub targets: Vec<DVec3>,
    /// Whether they were found and not given.
    pub automatic: bool,
    /// At how many of them the lines go on to the middle of the open end.
    pub capped: usize,
    /// Targets that no way leads to.
    pub unreached: Vec<UnreachedFacts>,
}

/// A target that no way leads to.
#[derive(Clone, Debug, Serialize)]
pub struct UnreachedFacts {
    /// Its place among the targets, from 0.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// Where it is.
    pub point: DVec3,
    /// Why.
    pub reason: String,
}

/// How many there are of everything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Ways from the source to a target, or from the root to a tip.
    pub centerlines: usize,
    /// Branches.
    pub branches: usize,
    /// Nodes with two daughters or more.
    pub junctions: usize,
    /// Those with two.
    pub bifurcations: usize,
    /// Those with more.
    pub multifurcations: usize,
    /// Ends.
    pub tips: usize,
    /// Loops of the surface, of which the tree has one side.
    pub loops_left_out: usize,
}

/// The table.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TableFacts {
    /// What a branch is here.
    pub definition: &'static str,
    /// Lengths of branches.
    pub branch_length: Spread,
    /// Radii at equally spaced points.
    pub point_radius: Spread,
    /// Ways from root to tip.
    pub centerline_length: Spread,
    /// From the root to the first junction.
    pub stem_length: f64,
    /// In mean branch lengths.
    pub stem_iterations: f64,
    /// Ways without the stem in mean branch lengths.
    pub iterations: MeanStd,
    /// Between daughters, in space.
    pub bifurcation_angle_deg: Spread,
    /// Between daughters, in the plane in which they branch.
    pub bifurcation_angle_in_plane_deg: Spread,
    /// Of branches towards the stem's direction.
    pub upwards_angle_deg: MeanStd,
    /// Mean curvatures of branches.
    pub curvature: Spread,
    /// Mean torsions of branches.
    pub torsion: Spread,
    /// Length over chord, less 1.
    pub tortuosity: Spread,
}

/// Two numbers.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct MeanStd {
    /// The mean.
    pub mean: f64,
    /// The population's standard deviation.
    pub std: f64,
}

/// Orders and their ratios.
#[derive(Clone, Debug, Default, Serialize)]
pub struct OrderFacts {
    /// Of each of Strahler's orders.
    pub strahler: Vec<Order>,
    /// Of each centrifugal order, from the stem's on.
    pub centrifugal: Vec<CentrifugalFacts>,
    /// Branches of an order to those of the next.
    pub branching_ratio: Option<f64>,
    /// Length of an order to that of the one before.
    pub length_ratio: Option<f64>,
    /// Radius of an order to that of the one before.
    pub radius_ratio: Option<f64>,
}

/// The branches of a centrifugal order.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct CentrifugalFacts {
    /// Which: 0 is the stem's, and each junction begins one more.
    pub order: u32,
    /// How many branches it has.
    pub branches: usize,
    /// Their lengths.
    pub branch_length: MeanStd,
    /// Radii along them.
    pub point_radius: Mean,
    /// Between those that leave the same junction; null of the stem.
    pub bifurcation_angle_deg: Option<MeanStd>,
}

/// One number.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
}

/// A branch.
#[derive(Clone, Debug, Serialize)]
pub struct BranchFacts {
    /// Its number.
    pub id: usize,
    /// The number of the branch that it grows from.
    pub parent: Option<usize>,
    /// Generation: 0 at the root.
    pub order: u32,
    /// Strahler's order.
    pub strahler: u32,
    /// Horsfield's order.
    pub horsfield: u32,
    /// Tips at its end.
    pub tips: u32,
    /// Along it.
    pub length: f64,
    /// Between its ends, straight.
    pub chord: f64,
    /// Length over chord, less 1.
    #[serde(serialize_with = "finite")]
    pub tortuosity: f64,
    /// Mean.
    pub curvature: f64,
    /// Mean; null where it is too straight to have one.
    pub torsion: Option<f64>,
    /// Along it.
    pub radius: RadiusFacts,
    /// Of the balls along it.
    pub volume: f64,
    /// Lateral.
    pub area: f64,
    /// The first and the last node.
    pub nodes: [u32; 2],
}

/// The radius along a branch.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RadiusFacts {
    /// Mean, extremes and both ends.
    #[serde(flatten)]
    pub along: RadiusAlong,
    /// How much it shrinks per length.
    pub taper: f64,
}

/// A junction.
#[derive(Clone, Debug, Serialize)]
pub struct JunctionFacts {
    /// Its node.
    pub node: u32,
    /// How many branches begin there.
    pub degree: usize,
    /// Their numbers.
    pub daughters: Vec<usize>,
    /// Between daughters: 1 and 2, 1 and 3, … 2 and 3, and so on.
    pub angles_deg: Vec<f64>,
    /// Between the parent's direction and each daughter's.
    pub parent_angles_deg: Vec<f64>,
    /// Between daughters in the plane in which they branch, as `angles_deg`.
    pub angles_in_plane_deg: Vec<f64>,
    /// From the way through the junction, in the plane: of the parent, then of each daughter; null of what has no direction.
    pub in_plane_deg: Vec<Option<f64>>,
    /// Out of the plane, likewise.
    pub out_of_plane_deg: Vec<Option<f64>>,
    /// The reference system of these angles.
    pub frame: Option<FrameFacts>,
    /// With which exponent the daughters' radii add up to the parent's.
    pub murray: Option<f64>,
    /// How unequally tips are shared.
    pub asymmetry: Option<f64>,
    /// The parent's direction, then the daughters'.
    pub vectors: Vec<DVec3>,
}

/// A reference system.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct FrameFacts {
    /// Its middle.
    pub origin: DVec3,
    /// Of the plane in which it branches; the thickest daughter is at the largest angle in it.
    pub normal: DVec3,
    /// The way through it, with the flow.
    pub up: DVec3,
}

/// The tree.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Nodes {
    /// Where nodes are.
    pub position: Vec<DVec3>,
    /// Their parents, −1 for the root.
    pub parent: Vec<i64>,
    /// The balls' radii.
    pub radius: Vec<f64>,
}

/// Milliseconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Timing {
    /// To read the file.
    pub load: f64,
    /// To check and prepare it.
    pub repair: f64,
    /// To find the centerlines.
    pub centerline: f64,
    /// To measure them.
    pub measure: f64,
}

/// JSON has no infinity: null.
fn finite<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
    value.is_finite().then_some(*value).serialize(to)
}

impl ModelFacts {
    /// Of a model by its report.
    pub fn new(file: String, report: &Report, scale: Option<Scale>) -> Self {
        Self {
            file,
            triangles: report.triangles,
            vertices: report.vertices,
            unit: scale.map(|scale| scale.unit.name()),
            scale: scale.map(|scale| scale.unit.metres()),
            components: report.components.len(),
            open_ends: report
                .boundary_loops
                .iter()
                .filter(|line| line.closed)
                .count(),
            watertight: report.is_watertight(),
            bounds: Bounds {
                min: report.min,
                max: report.max,
            },
        }
    }
}

impl Analysis {
    /// Tells of a tree. `automatic`: whether the endpoints were found; `loops`: how many handles the surface has.
    pub fn new(model: ModelFacts, found: &Centerline, automatic: bool, loops: usize) -> Self {
        let measures = Measures::new(&found.tree);
        let of = |kind: Kind| {
            found
                .endpoints
                .iter()
                .filter(move |end| end.kind == kind)
                .map(|end| end.point)
        };
        let bifurcations = measures.bifurcations();
        let centerlines = lines::centerlines(found, measures.table.stem_length);
        let vmtk = measures.vmtk.as_ref();
        Self {
            format: FORMAT,
            model,
            endpoints: EndpointFacts {
                source: of(Kind::Source).next(),
                targets: of(Kind::Target).collect(),
                automatic,
                capped: found.capped,
                unreached: found.unreached.iter().map(unreached).collect(),
            },
            counts: Counts {
                centerlines: centerlines.len(),
                branches: measures.branches.len(),
                junctions: measures.junctions.len(),
                bifurcations,
                multifurcations: measures.junctions.len() - bifurcations,
                tips: measures.tips,
                loops_left_out: loops,
            },
            counts_vmtk: vmtk.map(vmtk::counts),
            table: table(&measures.table, WHOLE),
            table_vmtk: vmtk.map(|split| table(&split.table, VMTK)),
            centerlines,
            orders: orders(&measures),
            branches: measures
                .branches
                .iter()
                .enumerate()
                .map(|(id, one)| branch(id, one))
                .collect(),
            branches_vmtk: vmtk.map_or_else(Vec::new, |split| vmtk::branches(split, found)),
            junctions: measures
                .junctions
                .iter()
                .map(|one| junction(one, found.origin))
                .collect(),
            junctions_vmtk: vmtk.map_or_else(Vec::new, |split| vmtk::junctions(split, found)),
            nodes: nodes(&found.tree, found.origin),
            timing_ms: Timing::default(),
        }
    }
}

fn unreached(one: &Unreached) -> UnreachedFacts {
    UnreachedFacts {
        index: one.index,
        name: one.name.clone(),
        point: one.point,
        reason: one.to_string(),
    }
}

fn degrees(spread: Spread) -> Spread {
    Spread {
        n: spread.n,
        mean: spread.mean.to_degrees(),
        std: spread.std.to_degrees(),
        min: spread.min.to_degrees(),
        max: spread.max.to_degrees(),
    }
}

/// What a branch is in each table.
const WHOLE: &str = "whole branches: from junction to junction, or to the root or a tip";
const VMTK: &str = "VMTK's branches: outside bifurcations, which begin one sphere before a line leaves another's tube";

fn table(table: &Table, definition: &'static str) -> TableFacts {
    let upwards = degrees(table.upwards_angle);
    TableFacts {
        definition,
        branch_length: table.branch_length,
        point_radius: table.point_radius,
        centerline_length: table.centerline_length,
        stem_length: table.stem_length,
        stem_iterations: table.stem_iterations,
        iterations: MeanStd {
            mean: table.iterations[0],
            std: table.iterations[1],
        },
        bifurcation_angle_deg: degrees(table.bifurcation_angle),
        bifurcation_angle_in_plane_deg: degrees(table.in_plane_angle),
        upwards_angle_deg: MeanStd {
            mean: upwards.mean,
            std: upwards.std,
        },
        curvature: table.curvature,
        torsion: table.torsion,
        tortuosity: table.tortuosity,
    }
}

fn orders(measures: &Measures) -> OrderFacts {
    OrderFacts {
        strahler: measures.orders.clone(),
        centrifugal: measures.by_order.iter().map(centrifugal).collect(),
        branching_ratio: measures.ratios.branching,
        length_ratio: measures.ratios.length,
        radius_ratio: measures.ratios.radius,
    }
}

fn centrifugal(of: &OfOrder) -> CentrifugalFacts {
    let mean_std = |spread: Spread| MeanStd {
        mean: spread.mean,
        std: spread.std,
    };
    CentrifugalFacts {
        order: of.order,
        branches: of.length.n,
        branch_length: mean_std(of.length),
        point_radius: Mean { mean: of.radius },
        bifurcation_angle_deg: (of.angle.n > 0).then(|| mean_std(degrees(of.angle))),
    }
}

fn branch(id: usize, branch: &Branch) -> BranchFacts {
    let radius = branch.radius;
    BranchFacts {
        id,
        parent: branch.parent,
        order: branch.order,
        strahler: branch.strahler,
        horsfield: branch.horsfield,
        tips: branch.tips,
        length: branch.length,
        chord: branch.chord,
        tortuosity: branch.tortuosity(),
        curvature: branch.curvature,
        torsion: branch.torsion,
        radius: RadiusFacts {
            along: radius,
            taper: radius.taper(branch.length),
        },
        volume: branch.volume,
        area: branch.area,
        nodes: branch.ends(),
    }
}

fn frame(frame: Frame, origin: DVec3) -> FrameFacts {
    FrameFacts {
        origin: frame.origin + origin,
        normal: frame.normal,
        up: frame.up,
    }
}

fn junction(junction: &Junction, origin: DVec3) -> JunctionFacts {
    let in_degrees = |angles: &[f64]| angles.iter().map(|angle| angle.to_degrees()).collect();
    let directions = std::iter::once(junction.parent_direction);
    let directions = directions.chain(junction.directions.iter().copied());
    let angles = |of: fn(Direction) -> f64| {
        let directions = directions.clone();
        directions
            .map(|one| one.map(|one| of(one).to_degrees()))
            .collect()
    };
    let vectors = std::iter::once(junction.parent_vector).chain(junction.vectors.iter().copied());
    JunctionFacts {
        node: junction.node,
        degree: junction.degree(),
        daughters: junction.daughters.clone(),
        angles_deg: in_degrees(&junction.angles),
        parent_angles_deg: in_degrees(&junction.parent_angles),
        angles_in_plane_deg: in_degrees(&junction.in_plane),
        in_plane_deg: angles(|one| one.in_plane),
        out_of_plane_deg: angles(|one| one.out_of_plane),
        frame: junction.frame.map(|one| frame(one, origin)),
        murray: junction.exponent,
        asymmetry: junction.asymmetry,
        vectors: vectors.collect(),
    }
}

fn nodes(tree: &Tree, origin: DVec3) -> Nodes {
    Nodes {
        position: tree
            .position
            .iter()
            .map(|one| one.as_dvec3() + origin)
            .collect(),
        parent: tree
            .parent
            .iter()
            .map(|parent| {
                if *parent == NO_PARENT {
                    -1
                } else {
                    i64::from(*parent)
                }
            })
            .collect(),
        radius: tree
            .radius
            .iter()
            .map(|radius| f64::from(*radius))
            .collect(),
    }
}
