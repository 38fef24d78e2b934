//! `ramus compare`: trees side by side, in numbers, distributions, branching and space, with a verdict in words.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, anyhow, ensure};
use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args as ClapArgs, ValueEnum};
use rayon::prelude::*;

use super::outputs::{check_places, not_over_each_other, picture_file};
use super::print_result;
use super::progress::Progress;
use super::trees::held;
use crate::app::compared::{self, Laid, Shown};
use crate::app::export;
use crate::app::table::Format;
use crate::app::trees::Held;
use crate::tree::compare::numbers::Difference;
use crate::tree::compare::told::{About, Told};
use crate::tree::compare::{Pair, Studied, compare};
use crate::tree::file::write_atomically;

mod text;

/// Trees that are compared at once, at most: their pairs are 66.
const TREES_MOST: usize = 12;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// Two files or more: models, whose centerlines are found; skeletons (SWC, VTP); grammars (.lsys), which are grown; projects (.ramus), whose sketches are
    #[arg(required = true, num_args = 2.., value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Print all that is known as one JSON object on one line
    #[arg(long)]
    json: bool,
    /// Write the numbers of all trees as a table
    #[arg(long, value_name = "FILE", value_parser = ending("csv", "tables are written as CSV"))]
    csv: Option<PathBuf>,
    /// Draw how their quantities are spread, and their barcodes, one over the other
    #[arg(long, value_name = "FILE", value_parser = ending("svg", "plots are written as SVG"))]
    svg: Option<PathBuf>,
    /// Draw the trees beside each other and over each other into a PNG picture
    #[arg(long, value_name = "FILE", value_parser = picture_file())]
    png: Option<PathBuf>,
    /// How they are laid over each other in it
    #[arg(long, value_enum, default_value_t = Overlay::Rooted, value_name = "HOW", requires = "png")]
    overlay: Overlay,
    /// Width and height of each tree's part of it in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 512, requires = "png", value_parser = clap::value_parser!(u32).range(64..=4096))]
    size: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Overlay {
    /// As their files have them
    AsIs,
    /// Root to root, each upright, as large as it is
    Rooted,
    /// Moved, scaled and turned so that they lie upon the first
    Fitted,
}

impl Overlay {
    fn drawn(self) -> compared::Overlay {
        match self {
            Self::AsIs => compared::Overlay::AsIs,
            Self::Rooted => compared::Overlay::Rooted,
            Self::Fitted => compared::Overlay::Fitted,
        }
    }
}

fn ending(wanted: &'static str, why: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case(wanted) => Ok(path),
        _ => Err(format!(
            "{}: {why}; use the ending .{wanted}",
            path.display()
        )),
    })
}

/// All that was found.
struct Found {
    about: Vec<About>,
    trees: Vec<Studied>,
    pairs: Vec<Pair>,
}

pub(super) fn run(args: &Args) -> Result<()> {
    // All that can be refused is, before any work.
    let outputs = || args.csv.iter().chain(&args.svg).chain(&args.png);
    for file in &args.files {
        not_over_each_other(Some(file), outputs().map(PathBuf::as_path), None)?;
    }
    check_places(outputs())?;
    ensure!(
        args.files.len() <= TREES_MOST,
        "{} trees are more than are compared at once: name {TREES_MOST} at most, or put them into one table with ramus cohort",
        args.files.len()
    );
    let mut all: Vec<Held> = Vec::with_capacity(args.files.len());
    for path in &args.files {
        let one = held(path)?;
        one.remarks.iter().for_each(|remark| whisper!("{remark}"));
        ensure!(
            one.tree.segment_count() > 0,
            "{} has no branch, so there is nothing to compare",
            path.display()
        );
        one.tree
            .validate()
            .with_context(|| format!("{} cannot be compared", path.display()))?;
        all.push(one);
    }
    let found = studied(args, &all)?;
    remark_on_units(&found.about);
    write(args, &all, &found)?;
    let text = match args.json {
        true => serde_json::to_string(&Told::new(&found.about, &found.trees, &found.pairs))? + "\n",
        false => text::screen(&found.about, &found.trees, &found.pairs),
    };
    print_result("the comparison", |out| out.write_all(text.as_bytes()))
}

/// Measures and compares.
fn studied(args: &Args, all: &[Held]) -> Result<Found> {
    let names = names(&args.files);
    let about = names.into_iter().zip(&args.files).zip(all);
    let about = about.map(|((name, file), held)| About {
        name,
        file: file.display().to_string(),
        kind: held.holds.name(),
        unit: held.unit.map(crate::mesh::unit::Unit::name),
        nodes: held.tree.len(),
    });
    let trees = Progress::during("measuring", || {
        let one = |held: &Held| Studied::new(&held.tree, held.origin);
        all.par_iter().map(one).collect::<Vec<_>>()
    });
    let mut progress = Progress::new("comparing");
    let pairs = compare(&trees, &AtomicBool::new(false), &mut |done, of| {
        progress.show(done, of);
    });
    Ok(Found {
        about: about.collect(),
        trees,
        pairs: pairs.ok_or_else(|| anyhow!("the comparison was cancelled"))?,
    })
}

/// The files' names, with as many folders before as tell them apart; those of one file with numbers.
fn names(files: &[PathBuf]) -> Vec<String> {
    let parts: Vec<Vec<String>> = files
        .iter()
        .map(|file| {
            file.iter()
                .map(|part| part.to_string_lossy().into_owned())
                .collect()
        })
        .collect();
    let of = |depth: usize| -> Vec<String> {
        let name = |parts: &Vec<String>| parts[parts.len().saturating_sub(depth)..].join("/");
        parts.iter().map(name).collect()
    };
    let different = |names: &[String]| {
        names
            .iter()
            .collect::<std::collections::BTreeSet<_>>()
            .len()
    };
    let wanted = different(&of(usize::MAX));
    let most = parts.iter().map(Vec::len).max().unwrap_or(1);
    let depth = (1..=most).find(|depth| different(&of(*depth)) == wanted);
    let short = of(depth.unwrap_or(most));
    let numbered = |(place, name): (usize, &String)| {
        let before = short[..place].iter().filter(|other| *other == name).count();
        match before {
            0 => name.clone(),
            before => format!("{name} ({})", before + 1),
        }
    };
    short.iter().enumerate().map(numbered).collect()
}

/// Lengths of different units are not to be compared.
fn remark_on_units(about: &[About]) {
    let units: Vec<String> = about
        .iter()
        .map(|one| format!("{}: {}", one.name, one.unit.unwrap_or("unknown")))
        .collect();
    if about.iter().any(|one| one.unit != about[0].unit) {
        whisper!(
            "the files are most likely in different units ({}): lengths are told as each file has them, and only what is told at one size can be compared",
            units.join(", ")
        );
    }
}

/// Writes the files that are asked for.
fn write(args: &Args, all: &[Held], found: &Found) -> Result<()> {
    let Found {
        about,
        trees,
        pairs,
    } = found;
    if let Some(path) = &args.csv {
        let to_first = pairs.iter().filter(|pair| pair.places[0] == 0);
        let to_first: Vec<&[Difference]> =
            to_first.map(|pair| pair.differences.as_slice()).collect();
        compared::table(about, trees, &to_first).write(path, Format::Csv)?;
    }
    if let Some(path) = &args.svg {
        write_atomically(path, compared::page(about, trees, pairs).as_bytes())?;
    }
    if let Some(path) = &args.png {
        let shown = all.iter().map(|held| Shown {
            tree: &held.tree,
            origin: held.origin,
            z_up: held.z_up,
        });
        let laid = Laid {
            about,
            trees: &shown.collect::<Vec<_>>(),
            studied: trees,
            pairs,
            overlay: args.overlay.drawn(),
            pixels: args.size,
        };
        let picture = Progress::during("drawing", || compared::picture(&laid))
            .context("cannot draw the comparison")?;
        export::png(&picture, path)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn names_are_as_short_as_they_can_be_and_nobody_has_anothers() {
        for (files, expected) in [
            (vec!["a/one.swc", "b/two.swc"], vec!["one.swc", "two.swc"]),
            (
                vec!["a/one.swc", "b/one.swc"],
                vec!["a/one.swc", "b/one.swc"],
            ),
            (vec!["one.swc", "one.swc"], vec!["one.swc", "one.swc (2)"]),
            (
                vec!["a/one.swc", "one.swc", "one.swc"],
                vec!["a/one.swc", "one.swc", "one.swc (2)"],
            ),
        ] {
            let files: Vec<PathBuf> = files.into_iter().map(PathBuf::from).collect();
            assert_eq!(names(&files), expected);
        }
    }
}
