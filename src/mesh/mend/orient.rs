//! Triangles turned so that neighbours agree and faces show outwards.
//!
//! The [report](crate::mesh::report) says which triangles of a patch (what hangs together by edges with two triangles) face against the others.
//! Then each patch as a whole is turned outwards by the sign of its volume. An open patch has one, too, once each of its ends is
//! closed by a cone to the centre of the end: for tubes cut open that is the volume they had, and it needs no ray that might slip
//! through an open end. (Casting rays from both sides of samples, Takayama et al. 2014, was considered: it needs a hierarchy and random
//! samples, and differs only for sheets, which have no outside anyway.) Sheets whose volume is next to nothing are left and told.
//!
//! Hollows, walls inside the largest component that show their backs to it, stay as they are: they are right.

use glam::DVec3;

use super::{MendError, Work, cross};
use crate::mesh::Mesh;
use crate::mesh::report::edges::{Edges, from_to};
use crate::mesh::report::union::Sets;
use crate::mesh::report::{NONE, Report};

/// Patches whose volume is less than this share of a ball's of the same area have no outside. A tube a million times as long as wide has 10⁻³.
const FLAT: f64 = 1e-4;

/// Volumes that are less than this share of what was summed for them are rounding.
const ROUNDING: f64 = 1e-12;

pub(super) fn orient(mut mesh: Mesh, work: &mut Work) -> Result<Mesh, MendError> {
    let report = work.report(&mesh)?;
    for triangle in &report.turned_triangles {
        mesh.triangles[*triangle as usize].swap(1, 2);
    }
    work.step(1, 2)?;
    let patches = Patches::new(&mesh);
    let (mut outwards, mut flat) = (0, 0);
    let turns: Vec<bool> = patches
        .measures(&mesh)
        .into_iter()
        .enumerate()
        .map(|(root, measure)| {
            let Some(measure) = measure else { return false };
            let (stays, is_flat) = (is_settled(&report, root), measure.is_flat());
            flat += usize::from(!stays && is_flat);
            let turns = !stays && !is_flat && measure.sixfold < 0.0;
            outwards += usize::from(turns);
            turns
        })
        .collect();
    for (triangle, root) in mesh.triangles.iter_mut().zip(&patches.root) {
        if turns.get(*root as usize).copied().unwrap_or(false) {
            triangle.swap(1, 2);
        }
    }
    remarks(&report, outwards, flat, work);
    Ok(mesh)
}

/// Hollows are right as they are, and nothing can be said of what has only one side.
fn is_settled(report: &Report, triangle: usize) -> bool {
    let number = report.component_of_triangle[triangle] as usize;
    let component = &report.components[number];
    component.hollow || !component.orientable
}

fn remarks(report: &Report, outwards: usize, flat: usize, work: &mut Work) {
    work.remark(
        report.turned_triangles.len(),
        "triangle turned to agree with its neighbours",
        "triangles turned to agree with their neighbours",
    );
    work.remark(
        outwards,
        "part turned to face outwards",
        "parts turned to face outwards",
    );
    work.remark(
        flat,
        "part left as it faced, since it is a sheet without an outside",
        "parts left as they faced, since they are sheets without an outside",
    );
    let one_sided = report.components.iter().filter(|one| !one.orientable);
    work.remark(
        one_sided.count(),
        "component left, since it has only one side",
        "components left, since they have only one side",
    );
}

/// What a patch encloses, and how large it is.
#[derive(Clone, Copy, Default)]
struct Measure {
    /// Six times the volume.
    sixfold: f64,
    /// Twice the area.
    double_area: f64,
    /// What was summed without regard to signs, of which rounding is a part.
    summed: f64,
}

impl Measure {
    fn is_flat(self) -> bool {
        // A ball of area A has the volume A^1.5 / (6 √π).
        let ball = (self.double_area / 2.0).powf(1.5) / std::f64::consts::PI.sqrt();
        self.sixfold.abs() <= (FLAT * ball).max(ROUNDING * self.summed)
    }

    /// Adds the pyramid of a triangle over a point.
    fn add(&mut self, tip: DVec3, corners: [DVec3; 3]) -> f64 {
        let [a, b, c] = corners;
        let across = cross(corners);
        self.sixfold += (a - tip).dot(across);
        self.summed += a.distance(tip) * a.distance(b) * a.distance(c);
        across.length()
    }
}

/// Triangles that hang together by edges with two triangles.
struct Patches {
    /// The first triangle of each triangle's patch.
    root: Vec<u32>,
    /// Half-edges without a neighbour in the patch.
    rim: Vec<u32>,
}

impl Patches {
    fn new(mesh: &Mesh) -> Self {
        let twins = Edges::new(&mesh.triangles, mesh.positions.len())
            .kinds()
            .twins;
        let mut sets = Sets::new(mesh.triangles.len());
        let mut rim = Vec::new();
        for (half_edge, twin) in (0_u32..).zip(&twins) {
            match *twin {
                NONE => rim.push(half_edge),
                twin => sets.join(half_edge / 3, twin / 3),
            }
        }
        let triangles = (0_u32..).take(mesh.triangles.len());
        Self {
            root: triangles.map(|triangle| sets.find(triangle)).collect(),
            rim,
        }
    }

    /// The measure of each patch, at the place of its first triangle.
    fn measures(&self, mesh: &Mesh) -> Vec<Option<Measure>> {
        let point = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
        let mut all: Vec<Option<Measure>> = vec![None; mesh.triangles.len()];
        // Pyramids over the triangles have their tips in the patch, so that what lies far from the origin loses nothing to rounding.
        let tip = |root: u32| point(mesh.triangles[root as usize][0]);
        for (triangle, root) in mesh.triangles.iter().zip(&self.root) {
            let corners = triangle.map(point);
            let measure = all[*root as usize].get_or_insert_default();
            measure.double_area += measure.add(tip(*root), corners);
        }
        for (half_edge, centre) in self.rims(mesh) {
            let root = self.root[half_edge as usize / 3];
            let [from, to] = from_to(&mesh.triangles, half_edge).map(point);
            // The cone's triangle runs the other way along the edge.
            let measure = all[root as usize].get_or_insert_default();
            measure.add(tip(root), [centre, to, from]);
        }
        all
    }

    /// The half-edges of rims with the centre of each rim: the mean of its edges that hang together within a patch.
    fn rims(&self, mesh: &Mesh) -> Vec<(u32, DVec3)> {
        let point = |vertex: u32| mesh.positions[vertex as usize].as_dvec3();
        // A vertex may be on the rims of several patches.
        let mut ends: Vec<(u32, u32, u32)> = (0_u32..)
            .zip(&self.rim)
            .flat_map(|(place, half_edge)| {
                let root = self.root[*half_edge as usize / 3];
                from_to(&mesh.triangles, *half_edge).map(|vertex| (root, vertex, place))
            })
            .collect();
        ends.sort_unstable();
        let mut sets = Sets::new(self.rim.len());
        for pair in ends.windows(2) {
            if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
                sets.join(pair[0].2, pair[1].2);
            }
        }
        let mut sums = vec![(DVec3::ZERO, 0.0); self.rim.len()];
        let roots: Vec<u32> = (0_u32..)
            .take(self.rim.len())
            .map(|place| sets.find(place))
            .collect();
        for (half_edge, root) in self.rim.iter().zip(&roots) {
            let [from, to] = from_to(&mesh.triangles, *half_edge).map(point);
            let (sum, count) = &mut sums[*root as usize];
            *sum += from.midpoint(to);
            *count += 1.0;
        }
        let centre = |root: &u32| {
            let (sum, count) = sums[*root as usize];
            sum / count
        };
        let half_edges = self.rim.iter().copied();
        half_edges.zip(roots.iter().map(centre)).collect()
    }
}
