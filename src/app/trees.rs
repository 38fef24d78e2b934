//! The tree of whatever a file holds: a surface's centerlines, a skeleton, a grammar grown, a project's sketch grown.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, anyhow, ensure};
use glam::DVec3;

use super::analysis::{Wanted, checked, endpoints, found, prepared};
use super::cohort::entries::bytes_of;
use super::memory;
use super::store::read_project;
use crate::centerline::Centerline;
use crate::lsystem::{Grammar, Limits, TurtleParams, draw};
use crate::mesh::unit::Unit;
use crate::mesh::{Mesh, ReadLimits};
use crate::sketch;
use crate::tree::{Drawing, Tree, import};

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// A surface, whose centerlines were found.
    Model,
    /// A skeleton or centerlines.
    Skeleton,
    /// A grammar, which was derived and drawn.
    Grammar,
    /// A project, whose sketch was grown.
    Project,
}

impl Holds {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Skeleton => "skeleton",
            Self::Grammar => "grammar",
            Self::Project => "project",
        }
    }
}

/// A tree and where it is from.
#[derive(Clone, Debug)]
pub struct Held {
    /// The tree.
    pub tree: Tree,
    /// Where its positions are counted from, in the file's coordinates.
    pub origin: DVec3,
    /// What the file holds.
    pub holds: Holds,
    /// What its numbers most likely are in.
    pub unit: Option<Unit>,
    /// Whether its third axis points up; else its second does.
    pub z_up: bool,
    /// What of it a person should know.
    pub remarks: Vec<String>,
}

/// The centerlines of a surface between ends that are found on it.
///
/// # Errors
/// What makes it no surface, or why there are no centerlines.
pub fn of_surface(mesh: &Mesh) -> Result<Centerline> {
    let wanted = Wanted::default();
    let silent = &mut |_, _| {};
    let report = checked(mesh, silent)?;
    let on = prepared(mesh, report, silent)?;
    let ends = endpoints(&wanted, &on)?;
    found(&wanted, &on, &ends, silent)
}

/// The skeleton of an SWC file as it is, without the surface of tubes that other commands look at it by.
///
/// # Errors
/// Why it cannot be read, or what is no skeleton in it.
pub fn of_swc(path: &Path) -> Result<Held> {
    let name = path.display();
    let cannot = || format!("cannot read {name}");
    let bytes = bytes_of(path, ReadLimits::default().bytes, "skeleton")?;
    Ok(Held {
        tree: import::swc(&bytes).with_context(cannot)?,
        origin: DVec3::ZERO,
        holds: Holds::Skeleton,
        // By custom.
        unit: Some(Unit::Micrometres),
        z_up: false,
        remarks: Vec::new(),
    })
}

/// The tree of a grammar's text after the number of steps that it states. Widths that are far too large for metres are scaled, as `ramus derive` does it.
///
/// # Errors
/// What is wrong with the grammar, or why it cannot be grown.
pub fn of_grammar(text: &str, name: &str) -> Result<Held> {
    let grammar = Grammar::parse(text, name).map_err(|errors| anyhow!("{errors}"))?;
    let (Drawing { tree, .. }, factor) = grown(&grammar, None, name, 1)?;
    let mut remarks: Vec<String> = grammar.remarks().iter().map(ToString::to_string).collect();
    if let Some(factor) = factor {
        remarks.push(format!(
            "the widths of {name} are far too large for metres and were multiplied by {factor:.2e}"
        ));
    }
    Ok(Held {
        tree,
        origin: DVec3::ZERO,
        holds: Holds::Grammar,
        unit: None,
        z_up: false,
        remarks,
    })
}

/// What a grammar draws after so many steps, or the number that it states, and by what its widths were multiplied, where they were far too large for metres.
/// So many share the memory, being grown beside each other.
///
/// # Errors
/// That no number of steps is stated, or why it cannot be grown.
pub fn grown(
    grammar: &Grammar,
    steps: Option<u32>,
    name: &str,
    beside: usize,
) -> Result<(Drawing, Option<f32>)> {
    let never = AtomicBool::new(false);
    let steps = steps.or(grammar.steps()).ok_or_else(|| {
        anyhow!("{name} states no number of steps: write one into it, such as `steps 5`")
    })?;
    // An eighth of what is free is left to everybody else.
    let room = memory::room().map_or(u64::MAX, |room| room / 8 * 7 / beside.max(1) as u64);
    let limits = Limits {
        bytes: Limits::default().bytes.min(room),
        ..Limits::default()
    };
    let string = grammar
        .derive(steps, &limits, &never)
        .map_err(|error| anyhow!("{name}: {error}"))?;
    let turtle = TurtleParams {
        limits: Limits {
            bytes: limits.bytes.saturating_sub(string.bytes()),
            ..limits
        },
        ..TurtleParams::default()
    };
    let mut drawing =
        draw(grammar, &string, &turtle, &never).map_err(|error| anyhow!("{name}: {error}"))?;
    let factor = grammar.finish(&mut drawing);
    Ok((drawing, factor))
}

/// The tree of a project's sketch at the step at which it was left.
///
/// # Errors
/// Why the project cannot be read, or that nothing has grown in it.
pub fn of_project(path: &Path) -> Result<Held> {
    let name = path.display();
    let document = read_project(path)?;
    ensure!(
        document.step > 0,
        "{name} was left at step 0, where no tree has grown yet: grow it in the workshop first"
    );
    let never = AtomicBool::new(false);
    let grown = sketch::grow(&document.sketch, document.step, &never)
        .with_context(|| format!("cannot grow {name}"))?;
    Ok(Held {
        tree: grown.tree,
        origin: DVec3::ZERO,
        holds: Holds::Project,
        unit: Some(Unit::Metres),
        z_up: false,
        remarks: Vec::new(),
    })
}
