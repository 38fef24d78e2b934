//! A model's centerlines, found and measured: the steps that every command that analyzes takes, so that all of them tell the same.
//!
//! ```text
//! surface ─▶ checked ─▶ prepared ─▶ endpoints, given or proposed ─▶ centerlines ─▶ Analysis
//! skeleton ────────────────────────────────────────────────────────────────────────▶ Analysis
//! ```

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use anyhow::{Result, anyhow, bail};
use glam::DVec3;

use crate::centerline::analysis::{Analysis, ModelFacts};
use crate::centerline::{Centerline, Params, centerline};
use crate::mesh::Mesh;
use crate::mesh::endpoints::{Endpoint, Kind, propose};
use crate::mesh::mend::{Mend, mend_all};
use crate::mesh::pick::Picker;
use crate::mesh::report::{Report, ReportParams, report};
use crate::mesh::surface::Surface;
use crate::mesh::unit::Scale;
use crate::tree::Tree;

/// What is asked for besides the model.
#[derive(Clone, Debug, Default)]
pub struct Wanted {
    /// Where centerlines begin, in the model's coordinates.
    pub source: Option<DVec3>,
    /// Where they end; the source may be among them. Proposed where nothing is given.
    pub endpoints: Option<Vec<Endpoint>>,
    /// Parts that are apart by no more than this, in the model's unit, are bridged.
    pub bridge: Option<f64>,
    /// Lines go on to the middles of open ends.
    pub cap: bool,
}

impl Wanted {
    /// Whether it says nothing, as it must of a skeleton.
    pub fn is_nothing(&self) -> bool {
        self.source.is_none() && self.endpoints.is_none() && self.bridge.is_none() && !self.cap
    }
}

/// A surface that is ready to be measured.
pub struct Prepared {
    report: Report,
    surface: Surface,
}

/// Checks a mesh. `progress` gets what is done of how much.
///
/// # Errors
/// What makes it no surface.
pub fn checked(mesh: &Mesh, progress: &mut dyn FnMut(usize, usize)) -> Result<Report> {
    let never = AtomicBool::new(false);
    Ok(report(mesh, &ReportParams::default(), &never, progress)?)
}

/// Prepares a mesh with its report: triangles that face against the others are turned.
///
/// # Errors
/// It cannot be mended.
pub fn prepared(
    mesh: &Mesh,
    report: Report,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Prepared> {
    let never = AtomicBool::new(false);
    let mut mesh = mesh.clone();
    if !report.turned_triangles.is_empty() {
        (mesh, _) = mend_all(mesh, &[Mend::Orient], &never, &mut |_, _, _| {})?;
    }
    let picker = Picker::new(Arc::new(mesh), &never, progress);
    let surface = picker.and_then(|picker| Surface::new(picker, &never));
    let surface = surface.ok_or_else(|| anyhow!("it was cancelled"))?;
    Ok(Prepared { report, surface })
}

/// What was given, and what is found for what was not.
///
/// # Errors
/// No ends were found.
pub fn endpoints(wanted: &Wanted, on: &Prepared) -> Result<Vec<Endpoint>> {
    let source = wanted.source.map(|point| Endpoint {
        point,
        name: "source".to_owned(),
        kind: Kind::Source,
        snapped: None,
    });
    let mut ends = match &wanted.endpoints {
        Some(given) => named(given.clone()),
        None => {
            let never = AtomicBool::new(false);
            let found = propose(&on.surface, &never).unwrap_or_default();
            let mut found: Vec<Endpoint> = found.into_iter().map(|one| one.endpoint).collect();
            if found.len() < 2 {
                bail!("no ends were found on its surface: give some with --source and --targets");
            }
            if let Some(source) = &source {
                // The end that the source stands for is not a target of its own.
                let distance = |end: &Endpoint| end.point.distance(source.point);
                let nearest = found
                    .iter()
                    .enumerate()
                    .min_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
                let nearest = nearest.map(|(place, _)| place);
                nearest.map(|place| found.remove(place));
                found.iter_mut().for_each(|end| end.kind = Kind::Target);
            }
            found
        }
    };
    if let Some(source) = source {
        ends.retain(|end| end.kind == Kind::Target);
        ends.insert(0, source);
    }
    Ok(ends)
}

/// Gives names to those that have none, by their places, so that messages and tables can call them.
fn named(mut ends: Vec<Endpoint>) -> Vec<Endpoint> {
    let mut taken: HashSet<String> = ends.iter().map(|end| end.name.clone()).collect();
    let [mut sources, mut targets] = [0_usize; 2];
    for end in &mut ends {
        let number = match end.kind {
            Kind::Source => &mut sources,
            Kind::Target => &mut targets,
        };
        *number += 1;
        while end.name.is_empty() {
            let name = match (end.kind, *number) {
                (Kind::Source, 1) => "source".to_owned(),
                (kind, number) => format!("{} {number}", kind.as_str()),
            };
            match taken.insert(name.clone()) {
                true => end.name = name,
                false => *number += 1,
            }
        }
    }
    ends
}

/// Finds the centerlines between endpoints.
///
/// # Errors
/// Why there are none.
pub fn found(
    wanted: &Wanted,
    on: &Prepared,
    endpoints: &[Endpoint],
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Centerline> {
    let never = AtomicBool::new(false);
    let params = Params {
        bridge: wanted.bridge,
        proposed: wanted.source.is_none() && wanted.endpoints.is_none(),
        cap: wanted.cap,
    };
    Ok(centerline(
        &on.surface,
        endpoints,
        &params,
        &never,
        progress,
    )?)
}

/// Measures what was found in a model of a name. `scale`: what its format says of the unit.
pub fn measured(
    wanted: &Wanted,
    on: &Prepared,
    found: &Centerline,
    name: String,
    scale: Option<Scale>,
) -> Analysis {
    let report = &on.report;
    let scale = scale.or_else(|| Scale::guessed(report.size().max_element()));
    let model = ModelFacts::new(name, report, scale);
    let loops = report
        .components
        .iter()
        .filter_map(|component| component.genus())
        .sum::<u32>();
    let automatic = wanted.endpoints.is_none();
    Analysis::new(model, found, automatic, loops as usize)
}

/// Measures a skeleton of a name as it is. `origin`: where its positions are counted from.
///
/// # Errors
/// Something was asked for that only a surface takes.
pub fn skeleton(
    wanted: &Wanted,
    skeleton: &Tree,
    origin: DVec3,
    name: &str,
    scale: Option<Scale>,
) -> Result<(Analysis, Centerline)> {
    if !wanted.is_nothing() {
        return Err(given_to_skeleton(name));
    }
    let found = Centerline {
        tree: skeleton.clone(),
        origin,
        ..Centerline::default()
    };
    let model = ModelFacts {
        file: name.to_owned(),
        unit: scale.map(|scale| scale.unit.name()),
        ..ModelFacts::default()
    };
    Ok((Analysis::new(model, &found, false, 0), found))
}

/// Nothing can be given to a skeleton.
pub fn given_to_skeleton(name: &str) -> anyhow::Error {
    anyhow!(
        "{name} is a skeleton already: leave out --source, --targets, --auto, --bridge and --cap, and it is measured as it is"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nameless_are_called_by_their_places_and_nobody_twice() {
        let end = |name: &str, kind| Endpoint {
            point: DVec3::ZERO,
            name: name.to_owned(),
            kind,
            snapped: None,
        };
        let given = [
            ("", Kind::Target),
            ("", Kind::Source),
            ("left", Kind::Target),
            ("", Kind::Target),
            ("target 4", Kind::Target),
            ("", Kind::Target),
            ("", Kind::Source),
        ];
        let ends = named(given.map(|(name, kind)| end(name, kind)).to_vec());
        let names: Vec<&str> = ends.iter().map(|end| end.name.as_str()).collect();
        let expected = [
            "target 1", "source", "left", "target 3", "target 4", "target 5", "source 2",
        ];
        assert_eq!(names, expected, "{ends:?}");
    }
}
