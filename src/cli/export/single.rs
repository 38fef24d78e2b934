//! Individuals written each for itself.

use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, ensure};
use rayon::prelude::*;

use super::coarse::{Coarse, coarse};
use super::estimate::{Holds, estimated, pictures};
use super::files::{File, Format, Told, line};
use super::source::{grammar_of, grown};
use super::{Args, Done, Plan, Shoot};
use crate::app::export;
use crate::cli::print_result;
use crate::cli::progress::Progress;
use crate::tree::Drawing;
use crate::tree::export::{ExportParams, Stand, Swc};
use crate::tree::file::write_atomically;

/// Individuals of each thread that are in memory at a time, where they are small: of no more nodes and leaves than this, some thirty megabytes.
const A_FEW: usize = 4;
const SMALL: usize = 1 << 19;

fn is_small(drawing: &Drawing) -> bool {
    drawing.tree.len() + drawing.organs.len() <= SMALL
}

/// Bytes below glibc's largest threshold, 32 MiB.
const LARGE: usize = 24 << 20;

/// Lets the next individual have the memory of the one before: glibc gives what is free at the end of a heap back to the system, which hands it out again page
/// by page, unless a larger block has been freed before (mallopt(3), dynamic thresholds). A tenth of the time of large files, a seventh of small ones;
/// nothing of the block is touched, and elsewhere nothing comes of it.
fn keep_freed_memory() {
    drop(std::hint::black_box(Vec::<u8>::with_capacity(LARGE)));
}

/// Writes the files of each individual.
pub(super) fn write(plan: &Plan<'_>, files: &[Vec<File>]) -> Result<Done> {
    let args = plan.args;
    let mut done = Done {
        told: Vec::new(),
        drawings: Vec::new(),
        drawn: 0,
        printed: Ok(()),
    };
    keep_freed_memory();
    let mut progress = Progress::new("exporting");
    let mut count = 0;
    // As many at a time as there are threads, so that memory is bounded and the numbers come in order, before the files; of small ones a few for each thread,
    // so that none waits long for another's last one. (Writing these while the next ones grow was tried: what is long begins last then, and one thread waits.)
    let threads = rayon::current_num_threads();
    let mut rest = (plan.shoots, files);
    let mut some = threads;
    while !(rest.0.is_empty() || rest.1.is_empty()) {
        let (shoots, files);
        (shoots, rest.0) = rest.0.split_at(some.min(rest.0.len()));
        (files, rest.1) = rest.1.split_at(some.min(rest.1.len()));
        let made: Vec<Arc<Drawing>> = shoots
            .par_iter()
            .map(|shoot| grown(plan, *shoot))
            .collect::<Result<_>>()?;
        let are_small = made.iter().all(|one| is_small(one));
        some = if are_small { A_FEW * threads } else { threads };
        // Bark is painted by all threads, so it must not be painted first where one of them may come upon another tree that waits for it.
        for format in &args.format {
            for drawing in &made {
                pictures(*format, drawing, &args.extra.extras());
            }
        }
        let ready: Vec<Vec<Ready>> = made
            .par_iter()
            .zip(shoots.par_iter().zip(files))
            .map(|(drawing, (shoot, files))| ready(plan, *shoot, files, drawing))
            .collect::<Result<_>>()?;
        let drawings = made.into_iter().filter(|one| !one.is_empty());
        let drawings: Vec<Arc<Drawing>> = drawings.collect();
        done.drawn += drawings.len();
        if args.sheet.is_some() && !args.dry_run {
            done.drawings.extend(drawings);
        }
        if !args.json {
            done.printed = done.printed.and(print_result("the list", |out| {
                let mut lines = ready.iter().flatten();
                lines.try_for_each(|one| writeln!(out, "{}", line(&one.told)))
            }));
        }
        let written: Vec<Vec<Told>> = ready
            .into_par_iter()
            .map(|files| {
                let files = files.into_iter();
                files.map(|file| written(args, file)).collect::<Result<_>>()
            })
            .collect::<Result<_>>()?;
        done.told.extend(written.into_iter().flatten());
        count += shoots.len();
        progress.show(count, plan.shoots.len());
    }
    ensure!(
        done.drawn > 0,
        "{} draws nothing at any step of the sequence, so there is no file to write: give more --steps",
        args.file.display()
    );
    Ok(done)
}

/// A file whose contents are made and which is not written yet.
struct Ready {
    told: Told,
    sides: u32,
    drawing: Arc<Drawing>,
    grammar: Option<String>,
}

impl Ready {
    /// With what is to stand in its file.
    fn with_stand<T>(&self, args: &Args, then: impl FnOnce(&Stand<'_>) -> T) -> T {
        let Drawing { tree, organs } = &*self.drawing;
        let name = self.told.file.file_stem().unwrap_or_default();
        let params = ExportParams { sides: self.sides };
        let mut stand = Stand::of(&name.to_string_lossy(), tree, organs, &params);
        stand.extras = args.extra.extras();
        then(&stand)
    }
}

/// All files of an individual.
fn ready(
    plan: &Plan<'_>,
    shoot: Shoot,
    files: &[File],
    drawing: &Arc<Drawing>,
) -> Result<Vec<Ready>> {
    let args = plan.args;
    if drawing.is_empty() {
        let step = shoot.step.unwrap_or_default();
        whisper!(
            "step {step} of {} draws nothing and is left out",
            args.file.display()
        );
        return Ok(Vec::new());
    }
    let Shoot { seed, step } = shoot;
    let extras = args.extra.extras();
    let mut levels: Vec<(Option<u32>, Coarse)> = Vec::new();
    let mut ready = Vec::new();
    for file in files {
        let of = |coarse: &Coarse| Ready {
            told: Told {
                file: file.path.clone(),
                seed,
                trees: None,
                step,
                level: file.level,
                segments: coarse.segments,
                triangles: Some(coarse.triangles),
                bound: Some(coarse.bound),
                holds: Holds::of(file.format, &coarse.drawing, &extras),
                bytes: Some(estimated(file.format, coarse, &extras)),
            },
            sides: coarse.sides,
            drawing: Arc::clone(&coarse.drawing),
            grammar: None,
        };
        if file.format.is_surface() {
            if !levels.iter().any(|(level, _)| *level == file.level) {
                levels.push((file.level, coarse(args, drawing, file.level)?));
            }
            let known = levels.iter().find(|(level, _)| *level == file.level);
            let made = known.map(|(_, coarse)| of(coarse));
            if let Some(one) = &made {
                one.with_stand(args, |stand| export::check(stand, &file.path))?;
            }
            ready.extend(made);
            continue;
        }
        if file.format == Format::Swc {
            // What it cannot hold is said before anything is written.
            Swc::new(&drawing.tree)
                .with_context(|| format!("cannot write {}", file.path.display()))?;
        }
        let grammar = (file.format == Format::Lsys).then(|| grammar_of(plan, shoot));
        let segments = drawing.tree.segment_count();
        let lines = 55 * segments as u64;
        ready.push(Ready {
            told: Told {
                file: file.path.clone(),
                seed,
                trees: None,
                step,
                level: None,
                segments,
                triangles: None,
                bound: None,
                holds: Holds::default(),
                bytes: Some(grammar.as_ref().map_or(lines, |text| text.len() as u64)),
            },
            sides: 3,
            drawing: Arc::clone(drawing),
            grammar,
        });
    }
    Ok(ready)
}

/// Writes a file, if anything is to be written.
fn written(args: &Args, file: Ready) -> Result<Told> {
    if args.dry_run {
        return Ok(file.told);
    }
    let path = &file.told.file;
    match &file.grammar {
        Some(text) => write_atomically(path, text.as_bytes())?,
        None => file.with_stand(args, |stand| export::stand(stand, path))?,
    }
    let bytes = size_of_file(path);
    let mut told = file.told;
    told.bytes = bytes;
    Ok(told)
}

/// Bytes of a file that is there.
pub(super) fn size_of_file(path: &Path) -> Option<u64> {
    std::fs::metadata(path).ok().map(|file| file.len())
}
