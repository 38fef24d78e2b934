//! All individuals in one file, side by side on the ground.

use std::io::Write as _;
use std::sync::Arc;

use anyhow::{Result, ensure};
use rayon::prelude::*;

use super::coarse::{Coarse, coarse};
use super::estimate::{Holds, pictures, surface};
use super::files::{File, Told, line};
use super::single::size_of_file;
use super::source::grown;
use super::{Done, Plan};
use crate::app::export;
use crate::cli::print_result;
use crate::cli::progress::Progress;
use crate::tree::Drawing;
use crate::tree::export::{ExportParams, Individual, Place, Stand, grove};

/// Bytes that the trees of a grove may take in memory, before there is any surface.
const BYTES_MOST: u64 = 2 << 30;

/// Writes a grove in each format and level.
pub(super) fn write(plan: &Plan<'_>, files: &[File]) -> Result<Done> {
    let args = plan.args;
    let drawings = all_grown(plan)?;
    let places = places(plan, &drawings);
    let mut done = Done {
        told: Vec::new(),
        drawings: Vec::new(),
        drawn: drawings.len(),
        printed: Ok(()),
    };
    for file in files {
        let trees: Vec<Coarse> = drawings
            .par_iter()
            .map(|drawing| coarse(args, drawing, file.level))
            .collect::<Result<_>>()?;
        let mut told = told(plan, file, &trees);
        let name = file.path.file_stem().unwrap_or_default().to_string_lossy();
        let stand = Stand {
            name: name.into_owned(),
            is_grove: true,
            extras: args.extra.extras(),
            trees: (1..)
                .zip(trees.iter().zip(&places))
                .map(|(number, (one, at))| Individual {
                    places: vec![Place::at(format!("tree-{number}"), *at)],
                    tree: &one.drawing.tree,
                    organs: &one.drawing.organs,
                    params: ExportParams { sides: one.sides },
                })
                .collect(),
        };
        export::check(&stand, &file.path)?;
        if !args.json {
            let line = line(&told);
            done.printed = done
                .printed
                .and(print_result("the list", |out| writeln!(out, "{line}")));
        }
        if !args.dry_run {
            Progress::during("writing", || export::stand(&stand, &file.path))?;
            told.bytes = size_of_file(&file.path);
        }
        done.told.push(told);
    }
    if args.sheet.is_some() && !args.dry_run {
        done.drawings = drawings;
    }
    Ok(done)
}

/// All trees, as many at a time as there are threads.
fn all_grown(plan: &Plan<'_>) -> Result<Vec<Arc<Drawing>>> {
    let mut drawings: Vec<Arc<Drawing>> = Vec::new();
    let mut progress = Progress::new("growing");
    let mut bytes = 0;
    for shoots in plan.shoots.chunks(rayon::current_num_threads()) {
        let made: Vec<Arc<Drawing>> = shoots
            .par_iter()
            .map(|shoot| grown(plan, *shoot))
            .collect::<Result<_>>()?;
        bytes += made.iter().map(|one| bytes_of(one)).sum::<u64>();
        ensure!(
            bytes <= BYTES_MOST,
            "{} trees of this size are too many for one file: take a smaller --count or fewer --steps",
            plan.args.count
        );
        drawings.extend(made);
        progress.show(drawings.len(), plan.shoots.len());
    }
    Ok(drawings)
}

fn bytes_of(drawing: &Drawing) -> u64 {
    /// A node: parent, position, radius, letter, order, birth.
    const NODE: u64 = 4 + 12 + 4 + 2 + 2 + 4;
    NODE * drawing.tree.len() as u64 + drawing.organs.bytes()
}

/// Where each tree's own zero comes to stand, so that its foot is on its place.
fn places(plan: &Plan<'_>, drawings: &[Arc<Drawing>]) -> Vec<glam::Vec3> {
    let crowns: Vec<(glam::Vec3, f32)> = drawings.par_iter().map(|one| grove::crown(one)).collect();
    let reaches: Vec<f32> = crowns.iter().map(|(_, reach)| *reach).collect();
    let seed = plan.shoots.first().map_or(0, |one| one.seed);
    let places = grove::places(&reaches, seed).into_iter();
    places
        .zip(&crowns)
        .map(|(place, (foot, _))| place - *foot)
        .collect()
}

fn told(plan: &Plan<'_>, file: &File, trees: &[Coarse]) -> Told {
    let extras = plan.args.extra.extras();
    let holds = trees
        .iter()
        .map(|one| Holds::of(file.format, &one.drawing, &extras))
        .fold(Holds::default(), Holds::and);
    let surfaces = trees.iter().map(|one| surface(file.format, one, &extras));
    // All of one source have one bark, whose pictures they share.
    let shared = trees
        .iter()
        .map(|one| pictures(file.format, &one.drawing, &extras))
        .max();
    Told {
        file: file.path.clone(),
        seed: plan.shoots.first().map_or(0, |one| one.seed),
        trees: u32::try_from(trees.len()).ok(),
        step: None,
        level: file.level,
        segments: trees.iter().map(|one| one.segments).sum(),
        triangles: Some(trees.iter().map(|one| one.triangles).sum()),
        bound: Some(trees.iter().map(|one| one.bound).fold(0.0, f32::max)),
        holds,
        bytes: Some(surfaces.sum::<u64>() + shared.unwrap_or(0)),
    }
}
