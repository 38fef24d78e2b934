//! From a mesh to a tree with radii: centerlines from one source to any number of targets.
//!
//! ```text
//! mesh ─▶ closed, oriented ─▶ solids, a skin each ─▶ balls that cover them and are linked (cover)
//!                                                              │ cheapest ways from ball to ball (route)
//! endpoints ─▶ balls (ends) ───────────────────────────────────┤
//!                                                              ▼
//!               tubes fitted along the ways (tube, line) ─▶ forks solved, lines led there (fork, spline) ─▶ Tree
//! ```
//!
//! Topology and geometry are found apart. Ways run through the largest balls that touch the wall, which hang together wherever the wall
//! does, at a cost that keeps them in the middle: so a target is reached wherever there is a way, and nothing depends on how fine the mesh
//! is. Where the line lies is then found from the wall about it, by fitting a tube to some hundred vertices at once.
//!
//! Tried and left: the Voronoi diagram of the vertices, as VMTK has it (it loses what touches, what is open and what is coarse, and a
//! Delaunay triangulation of a million points takes longer than all of this); balls alone, without tubes (their middles are off by the
//! sagitta of the triangles, a hundredth of a radius and more, and in forks by a fifth); and the largest ball within triangles for the
//! radius (too small by the sagitta).

pub mod analysis;
mod ball;
mod cover;
mod ends;
mod error;
mod fork;
mod line;
mod reach;
mod refine;
mod route;
mod skin;
mod solids;
mod spline;
mod tube;

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use self::cover::Cover;
pub use self::error::CenterlineError;
use self::fork::{Fork, Line, Network};
use self::line::centred;
use self::route::Skeleton;
use self::skin::Ball;
use self::solids::Solids;
use crate::mesh::endpoints::{Endpoint, Kind};
use crate::mesh::mend::{Close, Mend, Weld, mend_all};
use crate::mesh::report::NONE;
use crate::mesh::surface::Surface;
use crate::tree::{NO_PARENT, Node, Tree};

/// Triangles of a model at most.
pub const TRIANGLES_MOST: usize = 20_000_000;
/// Stages of the work, as progress counts them.
pub const STAGES: usize = 6;

/// How centerlines are found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Params {
    /// Parts that do not hang together are bridged where they are not farther apart than this, in the model's unit.
    pub bridge: Option<f64>,
    /// The endpoints are [proposals](crate::mesh::endpoints::propose()) for the surface: those that are inside other parts of it are none, and which
    /// is the source does not matter: where more of them hang together than with it, the first of those takes its place.
    pub proposed: bool,
    /// Lines that begin or end at an open end go on to its middle, with the radius of their last ball.
    pub cap: bool,
}

/// Why no way leads to a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Why {
    /// It is in another part.
    Gap {
        /// How wide the narrowest gap is between what it is in and what the source is in, in the model's unit.
        gap: f64,
        /// Where that is, in the model's coordinates.
        near: DVec3,
    },
    /// There is no inside where it is.
    NoInside,
}

/// A target that no way leads to.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreached {
    /// Its place among the targets, from 0.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// Where it is, in the model's coordinates.
    pub point: DVec3,
    /// The reason.
    pub why: Why,
}

impl std::fmt::Display for Unreached {
    /// The reason, without the target's name.
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.why {
            Why::Gap { gap, near } => write!(
                to,
                "not connected to the source: gap of {gap:.3} near ({:.3}, {:.3}, {:.3})",
                near.x, near.y, near.z
            ),
            Why::NoInside => to.write_str("where the model has no inside"),
        }
    }
}

/// Centerlines as one tree.
#[derive(Clone, Debug, Default)]
pub struct Centerline {
    /// Nodes from the source on: positions from [`Centerline::origin`] and radii of the balls there, both in the model's unit.
    pub tree: Tree,
    /// Where positions are counted from, in the model's coordinates.
    pub origin: DVec3,
    /// Where it begins and ends: the source first, then the targets.
    pub endpoints: Vec<Endpoint>,
    /// The node of each target, in their order; None where no way leads there.
    pub ends: Vec<Option<u32>>,
    /// Targets that no way leads to.
    pub unreached: Vec<Unreached>,
    /// How far the surface is from each end, straight on: from the source, then from each target. None where there is no line, and where others go on.
    pub to_surface: Vec<Option<f64>>,
    /// At how many ends lines go on to the middle of an open end.
    pub capped: usize,
}

/// Finds the centerlines of a model from its source to its targets. `progress` gets how many of [`STAGES`] are done.
///
/// # Errors
/// [`CenterlineError`]: cancelled, no inside, endpoints that do not fit, or no target that can be reached.
pub fn centerline(
    surface: &Surface,
    endpoints: &[Endpoint],
    params: &Params,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Centerline, CenterlineError> {
    let mut stage = {
        let mut done = 0;
        move || {
            progress(done, STAGES);
            done += 1;
            match cancel.load(Ordering::Relaxed) {
                true => Err(CenterlineError::Cancelled),
                false => Ok(()),
            }
        }
    };
    stage()?;
    let mut endpoints = source_first(endpoints)?;
    let given = surface;
    let surface = prepared(surface, cancel)?;
    stage()?;
    let origin = surface.mesh().origin;
    // A closed surface has its balls inside; from what could not be closed they may have got out.
    let unsure = !is_closed(&surface);
    let skins = solids::skins(surface, cancel).ok_or(CenterlineError::Cancelled)?;
    stage()?;
    let (skins, mut cover) = Cover::new(skins, unsure, cancel).ok_or(CenterlineError::Cancelled)?;
    let solids = Solids::new(&skins);
    cover
        .join(&solids, cancel)
        .ok_or(CenterlineError::Cancelled)?;
    if params.proposed {
        ends::leave_out_buried(&solids, &mut endpoints, origin)?;
    }
    let mut balls = endpoints
        .iter()
        .map(|endpoint| {
            match ends::ball_of(&mut cover, &solids, endpoint, origin) {
                // Nobody set it there: where it is, the outer wall is not.
                Err(CenterlineError::OffSurface { .. }) if params.proposed => Ok(None),
                found => found,
            }
        })
        .collect::<Result<Vec<Option<u32>>, _>>()?;
    if let Some(most) = params.bridge {
        cover
            .bridge(most, |gap, _| gap <= most, cancel)
            .ok_or(CenterlineError::Cancelled)?;
    }
    if params.proposed {
        ends::choose_source(&cover, &mut endpoints, &mut balls);
    }
    let start = balls[0].ok_or(CenterlineError::NoInside)?;
    ends::apart(&cover, start, &endpoints[1..], &balls[1..])?;
    stage()?;
    let skeleton =
        Skeleton::new(&cover, start, &balls[1..], cancel).ok_or(CenterlineError::Cancelled)?;
    let unreached = ends::unreached(
        &cover,
        start,
        &endpoints[1..],
        &balls[1..],
        &skeleton.ends,
        origin,
    );
    if let (true, Some(first)) = (skeleton.ends.iter().all(Option::is_none), unreached.first()) {
        return Err(CenterlineError::NothingReached(format!(
            "{} is {first}",
            first.name
        )));
    }
    stage()?;
    let chains = skeleton.chains();
    let lines: Vec<Line> = chains
        .par_iter()
        .map(|chain| {
            let balls: Vec<Ball> = chain
                .iter()
                .map(|node| skeleton.balls[*node as usize])
                .collect();
            Line {
                from: chain.first().copied().unwrap_or(NONE),
                to: chain.last().copied().unwrap_or(NONE),
                samples: centred(&solids, &balls),
            }
        })
        .collect();
    stage()?;
    let network = network(&skeleton, lines, &solids);
    stage()?;
    let (tree, ends) = gathered(&network, &skeleton);
    let mut found = Centerline {
        to_surface: reach::to_surface(&tree, &ends, &solids),
        tree,
        origin,
        endpoints,
        ends,
        unreached,
        capped: 0,
    };
    if params.cap {
        reach::to_caps(&mut found, given);
    }
    Ok(found)
}

/// The endpoints with the source first.
fn source_first(endpoints: &[Endpoint]) -> Result<Vec<Endpoint>, CenterlineError> {
    let (sources, targets): (Vec<&Endpoint>, Vec<&Endpoint>) =
        endpoints.iter().partition(|one| one.kind == Kind::Source);
    match (sources.len(), targets.is_empty()) {
        (0, _) => Err(CenterlineError::NoSource),
        (1, true) => Err(CenterlineError::NoTarget),
        (1, false) => Ok(sources.into_iter().chain(targets).cloned().collect()),
        (many, _) => Err(CenterlineError::ManySources(many)),
    }
}

/// The surface, closed and turned outwards where it was not.
fn prepared<'a>(
    surface: &'a Surface,
    cancel: &AtomicBool,
) -> Result<Cow<'a, Surface>, CenterlineError> {
    let triangles = surface.mesh().triangles.len();
    if triangles > TRIANGLES_MOST {
        return Err(CenterlineError::TooLarge {
            triangles,
            most: TRIANGLES_MOST,
        });
    }
    if !surface.vertex_areas().iter().any(|area| *area > 0.0) {
        return Err(CenterlineError::NoSurface);
    }
    if is_closed(surface) {
        return Ok(Cow::Borrowed(surface));
    }
    let mends = [
        Mend::Weld(Weld::default()),
        Mend::Orient,
        Mend::Close(Close::default()),
    ];
    let mesh = surface.mesh().as_ref().clone();
    let (mesh, _) =
        mend_all(mesh, &mends, cancel, &mut |_, _, _| {}).map_err(|error| match error {
            crate::mesh::mend::MendError::Cancelled => CenterlineError::Cancelled,
            other => other.into(),
        })?;
    let closed = solids::surface_of(mesh, cancel).ok_or(CenterlineError::Cancelled)?;
    Ok(Cow::Owned(closed))
}

/// Whether each triangle has a neighbour at each edge that shows the same side.
fn is_closed(surface: &Surface) -> bool {
    // Neighbours that agree lead along their edge in opposite directions.
    let has_neighbour = |half_edge: u32| {
        let twin = surface.twin(half_edge);
        let ends = |half_edge: u32| surface.ends(half_edge).map(|[from, _]| from);
        twin.is_some_and(|twin| ends(twin) != ends(half_edge))
    };
    let mut half_edges = surface
        .triangles()
        .flat_map(|(triangle, _)| 3 * triangle..3 * triangle + 3);
    half_edges.all(has_neighbour)
}

/// Lines and forks, led to each other.
fn network(skeleton: &Skeleton, lines: Vec<Line>, solids: &Solids<'_>) -> Network {
    let forks = skeleton.balls.iter().map(|ball| Fork {
        ball: *ball,
        lines: 0,
    });
    let mut forks: Vec<Fork> = forks.collect();
    for line in &lines {
        forks[line.from as usize].lines += 1;
        forks[line.to as usize].lines += 1;
    }
    let mut network = Network { forks, lines };
    network.join(solids);
    network
}

/// The tree of a network whose first fork is the source, and the node of each end.
#[allow(
    clippy::cast_possible_truncation,
    reason = "trees are in single precision, as meshes are"
)]
fn gathered(network: &Network, skeleton: &Skeleton) -> (Tree, Vec<Option<u32>>) {
    let mut tree = Tree {
        letters: vec!["centerline".to_owned()],
        ..Tree::default()
    };
    let mut nodes = vec![NO_PARENT; network.forks.len()];
    for line in &network.lines {
        let mut parent = nodes[line.from as usize];
        let order = if parent == NO_PARENT {
            0
        } else {
            tree.order[parent as usize]
        };
        let order =
            order + u16::from(parent != NO_PARENT && network.forks[line.from as usize].lines > 2);
        let skipped = usize::from(parent != NO_PARENT);
        for sample in line.samples.iter().skip(skipped) {
            parent = tree.push(Node {
                parent,
                position: sample.point.as_vec3(),
                radius: sample.radius.max(0.0) as f32,
                letter: 0,
                order,
                birth: 0,
            });
            if nodes[line.from as usize] == NO_PARENT {
                nodes[line.from as usize] = parent;
            }
        }
        nodes[line.to as usize] = parent;
    }
    let node_of = |end: u32| match nodes[end as usize] {
        // A target on the way to others.
        NO_PARENT => {
            let place = skeleton.balls[end as usize].centre.as_vec3();
            let squared = |node: &u32| tree.position[*node as usize].distance_squared(place);
            let all = (0_u32..).take(tree.len());
            all.min_by(|a, b| squared(a).total_cmp(&squared(b)))
        }
        node => Some(node),
    };
    let ends = skeleton.ends.iter().map(|end| end.and_then(node_of));
    let ends = ends.collect();
    (tree, ends)
}

#[cfg(test)]
mod tests;
