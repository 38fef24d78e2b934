//! The planted trees of a project in one file, where they stand.

use std::io::Write as _;
use std::sync::Arc;

use anyhow::{Result, ensure};
use rayon::prelude::*;

use super::coarse::{Coarse, coarse};
use super::estimate::{Holds, pictures, surface};
use super::files::{File, Format, Told, counted, line};
use super::single::size_of_file;
use super::source::Source;
use super::{Args, Done, Plan};
use crate::app::export;
use crate::app::wood::{self, Standing};
use crate::cli::outputs::tell_bare;
use crate::cli::print_result;
use crate::cli::progress::Progress;
use crate::tree::bark::Bark;
use crate::tree::export::Place;
use crate::world::document::Document;

/// The project whose planted trees are written, if they are.
pub(super) fn of<'a>(args: &Args, source: &'a Source) -> Option<&'a Document> {
    let one = args.count == 1 && args.seed.is_none();
    planted(source).filter(|_| args.grove && one)
}

fn planted(source: &Source) -> Option<&Document> {
    match source {
        Source::Sketch(document, _) if !document.grove.is_empty() => Some(&**document),
        _ => None,
    }
}

/// Refuses what planted trees cannot be; says when they, or some of them, are left out.
pub(super) fn check(args: &Args, source: &Source) -> Result<()> {
    let Some(document) = planted(source) else {
        return Ok(());
    };
    if of(args, source).is_none() {
        whisper!(
            "the {} planted trees of {} are left out: --grove, without --count and --seed, writes them where they stand",
            document.grove.plants.len(),
            args.file.display()
        );
        return Ok(());
    }
    match wood::ungrown(document) {
        0 => {}
        number => whisper!(
            "of {}, {} left at step 0, where nothing has grown yet, can not be written",
            args.file.display(),
            counted(number as u64, "planted tree")
        ),
    }
    ensure!(
        args.angles.is_none() && args.lengths.is_none(),
        "planted trees stay what was planted: leave --angles and --lengths out"
    );
    ensure!(
        args.extra.growth.is_none(),
        "planted trees do not grow in a file: leave --growth out, or --grove"
    );
    Ok(())
}

/// Writes them in each format and level.
pub(super) fn write(plan: &Plan<'_>, document: &Document, files: &[File]) -> Result<Done> {
    let args = plan.args;
    let grown = Progress::during("growing", || wood::grown(document, args.season))?;
    let (drawings, places): (Vec<_>, Vec<_>) = grown
        .into_iter()
        .map(|Standing { drawing, places }| {
            tell_bare(&drawing.organs);
            (Arc::new(drawing), places)
        })
        .unzip();
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
        let mut told = told(plan, file, &trees, &places);
        let name = file.path.file_stem().unwrap_or_default().to_string_lossy();
        let all = trees.iter().zip(&places).map(|(one, places)| {
            let drawing = &one.drawing;
            (&drawing.tree, &drawing.organs, one.sides, places.as_slice())
        });
        let stand = wood::stand(&name, all, args.extra.extras());
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

fn told(plan: &Plan<'_>, file: &File, trees: &[Coarse], places: &[Vec<Place>]) -> Told {
    let extras = plan.args.extra.extras();
    let holds = trees
        .iter()
        .map(|one| Holds::of(file.format, &one.drawing, &extras))
        .fold(Holds::default(), Holds::and);
    // One that stands in several places is in these files once.
    let is_once = matches!(file.format, Format::Glb | Format::Usda);
    let each = || trees.iter().zip(places.iter().map(Vec::len));
    // What is larger is off by more.
    let bounds = trees.iter().zip(places).map(|(one, places)| {
        let largest = places.iter().map(|place| place.size).fold(0.0, f32::max);
        one.bound * largest
    });
    let surfaces = each().map(|(one, times)| {
        surface(file.format, one, &extras) * if is_once { 1 } else { times as u64 }
    });
    let barks = trees.iter().map(|one| {
        (
            one.drawing.organs.bark,
            pictures(file.format, &one.drawing, &extras),
        )
    });
    let mut shared: Vec<(Bark, u64)> = barks.collect();
    shared.sort_unstable_by_key(|(bark, bytes)| (*bark as u8, std::cmp::Reverse(*bytes)));
    shared.dedup_by_key(|(bark, _)| *bark);
    Told {
        file: file.path.clone(),
        seed: plan.shoots.first().map_or(0, |one| one.seed),
        trees: u32::try_from(each().map(|(_, times)| times).sum::<usize>()).ok(),
        step: None,
        level: file.level,
        segments: each().map(|(one, times)| one.segments * times).sum(),
        triangles: Some(
            each()
                .map(|(one, times)| one.triangles * times as u64)
                .sum(),
        ),
        bound: Some(bounds.fold(0.0, f32::max)),
        holds,
        bytes: Some(surfaces.sum::<u64>() + shared.iter().map(|(_, bytes)| bytes).sum::<u64>()),
    }
}
