//! What can be mended on request: functions from a mesh to a mesh, each with an account of what it changed.
//!
//! ```text
//! mesh ─▶ clean (join equal vertices, leave out what is no surface) ─▶ weld | debris | … | remesh ─▶ mesh, account
//! ```
//!
//! A mend is a small value with a [textual form](Mend::parse), so a project records the list of mends and not the mended mesh: the model and
//! the list give the same mesh again, to the bit and on any number of threads, and undo takes the last one off the list.
//!
//! Every mend looks at vertices of exactly equal coordinates as one, as the [report] does, and so joins them first; it
//! also leaves out what no surface has: triangles with a vertex that is not there, not finite or there twice, triangles that are there
//! already, vertices that no triangle uses. The account says how many of each, so nothing is changed silently.

mod buckets;
mod clean;
mod close;
mod decimate;
mod error;
mod nearest;
mod orient;
mod parts;
mod remesh;
mod smooth;
mod surface;
#[cfg(test)]
mod tests;
mod text;
mod weld;

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

pub use self::error::MendError;
pub use self::text::{MendSyntax, list_from_text, text_from_list};
use super::Mesh;
use super::problem::grouped;
use super::report::{self, Report, ReportParams};

/// What a triangle takes while a mesh is mended, about, where that takes most: decimating.
const BYTES: usize = 160;

/// A length in the file's unit, or as a part of the model's size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Length {
    /// In the file's unit.
    Units(f64),
    /// In hundredths of the diagonal of the box around all triangles.
    Percent(f64),
}

/// A number of triangles, or a share of something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// So many triangles.
    Triangles(u32),
    /// From 0 to 1.
    Share(f64),
}

/// Vertices near each other become one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weld {
    /// How near, at most; 0 joins those of the same place only.
    pub distance: Length,
}

impl Default for Weld {
    fn default() -> Self {
        let distance = Length::Units(0.0);
        Self { distance }
    }
}

/// Small components are dropped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Debris {
    /// Those with fewer triangles, or with less than a share of the largest component's area.
    pub below: Amount,
}

impl Default for Debris {
    fn default() -> Self {
        let below = Amount::Share(0.01);
        Self { below }
    }
}

/// How a hole is covered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cap {
    /// Without new vertices, flat where the loop is.
    #[default]
    Flat,
    /// As the surface around goes on, in triangles as large as those around.
    Smooth,
}

/// Open ends are closed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Close {
    /// With what.
    pub cap: Cap,
    /// Loops that are longer stay open; None closes all.
    pub longest: Option<Length>,
}

/// Noise is taken off, volume kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Smooth {
    /// How often, from 1 to [`Smooth::PASSES_MOST`].
    pub passes: u32,
}

impl Smooth {
    /// More would let the lowest frequencies grow by more than a sixth.
    pub const PASSES_MOST: u32 = 200;
}

impl Default for Smooth {
    fn default() -> Self {
        Self { passes: 10 }
    }
}

/// Fewer triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimate {
    /// How many are left, of all.
    pub to: Amount,
}

impl Default for Decimate {
    fn default() -> Self {
        let to = Amount::Share(0.5);
        Self { to }
    }
}

/// Triangles of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remesh {
    /// The length of edges; above 0.
    pub edge: Length,
}

impl Remesh {
    /// Triangles that are made at most; while they are made each takes about 200 bytes.
    pub const TRIANGLES_MOST: usize = 20_000_000;
}

impl Default for Remesh {
    fn default() -> Self {
        let edge = Length::Percent(1.0);
        Self { edge }
    }
}

/// Something that can be mended; written as [`Mend::parse`] reads it, also by serde.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Mend {
    /// `weld[=distance]`
    Weld(Weld),
    /// `debris[=share]`
    Debris(Debris),
    /// `largest`: the component with the largest area stays. Area, since scans are open where vessels were cut, and open surfaces have no
    /// volume.
    Largest,
    /// `orient`: triangles agree with their neighbours and face outwards.
    Orient,
    /// `close[=flat|smooth[:longest loop]]`
    Close(Close),
    /// `smooth[=passes]`
    Smooth(Smooth),
    /// `decimate[=triangles or share]`
    Decimate(Decimate),
    /// `remesh[=edge length]`
    Remesh(Remesh),
}

/// What a mend changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Account {
    /// The mend.
    pub mend: Mend,
    /// Vertices before and after.
    pub vertices: [usize; 2],
    /// Triangles before and after.
    pub triangles: [usize; 2],
    /// What was done and what could not be, a clause each.
    pub remarks: Vec<String>,
}

impl std::fmt::Display for Account {
    /// One line.
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(to, "{}: ", self.mend)?;
        for (at, remark) in self.remarks.iter().enumerate() {
            write!(to, "{}{remark}", if at == 0 { "" } else { ", " })?;
        }
        let counts = [("vertices", self.vertices), ("triangles", self.triangles)];
        let changed = counts
            .into_iter()
            .filter(|(_, [before, after])| before != after);
        let mut parted = !self.remarks.is_empty();
        for (what, [before, after]) in changed {
            let part = if parted { "; " } else { "" };
            write!(to, "{part}{} → {} {what}", grouped(before), grouped(after))?;
            parted = true;
        }
        match parted {
            true => Ok(()),
            false => to.write_str("nothing to do"),
        }
    }
}

/// What goes with the work of a mend: whether to stop, whom to tell of progress, and what to tell in the end.
struct Work<'a> {
    cancel: &'a AtomicBool,
    progress: &'a mut dyn FnMut(usize, usize),
    remarks: Vec<String>,
}

impl Work<'_> {
    /// Tells how much is done, and ends the work where that is asked for.
    fn step(&mut self, done: usize, of: usize) -> Result<(), MendError> {
        self.go_on()?;
        (self.progress)(done, of);
        Ok(())
    }

    fn go_on(&self) -> Result<(), MendError> {
        match self.cancel.load(Ordering::Relaxed) {
            true => Err(MendError::Cancelled),
            false => Ok(()),
        }
    }

    /// Remarks on a number of things, unless it is none.
    fn remark(&mut self, count: usize, one: &str, many: &str) {
        if count > 0 {
            let words = if count == 1 { one } else { many };
            self.remarks.push(format!("{} {words}", grouped(count)));
        }
    }

    fn say(&mut self, remark: impl Into<String>) {
        self.remarks.push(remark.into());
    }

    fn report(&self, mesh: &Mesh) -> Result<Report, MendError> {
        let params = ReportParams { weld: false };
        Ok(report::report(mesh, &params, self.cancel, &mut |_, _| {})?)
    }
}

/// Mends a mesh. `progress` gets how many steps of how many are done; `cancel` is looked at every few milliseconds, or between the stages of a
/// report.
///
/// # Errors
/// [`MendError`]: cancelled, too large, nothing left, or a parameter that does not fit the mesh.
pub fn mend(
    mesh: Mesh,
    mend: &Mend,
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<(Mesh, Account), MendError> {
    let (triangles, vertices) = (mesh.triangles.len(), mesh.positions.len());
    let most = report::TRIANGLES_MOST;
    if triangles.max(vertices) > most {
        let most = most as u64;
        return Err(MendError::TooLarge {
            triangles,
            vertices,
            most,
        });
    }
    // Asked for once before it is needed in several pieces: those end the program where they are not given.
    let bytes = BYTES.saturating_mul(triangles.max(vertices));
    if Vec::<u8>::new().try_reserve_exact(bytes).is_err() {
        return Err(MendError::Memory(bytes));
    }
    let mut work = Work {
        cancel,
        progress,
        remarks: Vec::new(),
    };
    work.step(0, 1)?;
    let clean = clean::clean(mesh, &mut work);
    if clean.triangles.is_empty() {
        return Err(MendError::Nothing);
    }
    let mended = match mend {
        Mend::Weld(weld) => weld::weld(clean, weld, &mut work),
        Mend::Debris(debris) => parts::debris(clean, debris, &mut work),
        Mend::Largest => parts::largest(clean, &mut work),
        Mend::Orient => orient::orient(clean, &mut work),
        Mend::Close(close) => close::close(clean, close, &mut work),
        Mend::Smooth(smooth) => smooth::smooth(clean, smooth, &mut work),
        Mend::Decimate(decimate) => decimate::decimate(clean, decimate, &mut work),
        Mend::Remesh(remesh) => remesh::remesh(clean, remesh, &mut work),
    }?;
    if mended.triangles.is_empty() {
        return Err(MendError::NothingLeft(*mend));
    }
    (work.progress)(1, 1);
    let account = Account {
        mend: *mend,
        vertices: [vertices, mended.positions.len()],
        triangles: [triangles, mended.triangles.len()],
        remarks: work.remarks,
    };
    Ok((mended, account))
}

/// Mends a mesh by all mends of a list, in order, with an account of each. `progress` also gets which mend is at work.
///
/// # Errors
/// As [`mend`], of the first that fails.
pub fn mend_all(
    mut mesh: Mesh,
    mends: &[Mend],
    cancel: &AtomicBool,
    progress: &mut dyn FnMut(&Mend, usize, usize),
) -> Result<(Mesh, Vec<Account>), MendError> {
    let mut accounts = Vec::with_capacity(mends.len());
    for one in mends {
        let (mended, account) = mend(mesh, one, cancel, &mut |done, of| progress(one, done, of))?;
        mesh = mended;
        accounts.push(account);
    }
    Ok((mesh, accounts))
}

impl Length {
    /// In the file's unit.
    fn of(self, mesh: &Mesh) -> f64 {
        match self {
            Self::Units(length) => length,
            Self::Percent(percent) => percent / 100.0 * diagonal(mesh),
        }
    }
}

/// The diagonal of the box around all vertices.
fn diagonal(mesh: &Mesh) -> f64 {
    let bounds = |of: fn(Vec3, Vec3) -> Vec3| mesh.positions.iter().copied().reduce(of);
    match (bounds(Vec3::min), bounds(Vec3::max)) {
        (Some(min), Some(max)) => min.as_dvec3().distance(max.as_dvec3()),
        _ => 0.0,
    }
}

/// Twice the area, as a vector that stands on the triangle.
fn cross([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
