//! `ramus cohort`: several models at once, in one table, and groups of them compared.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use clap::Args as ClapArgs;

use super::print_result;
use super::progress::{Progress, start_watch};
use crate::app::cohort::comparison::Comparison;
use crate::app::cohort::entries::{Entry, entries, plan};
use crate::app::cohort::groups::Groups;
use crate::app::cohort::told::Definition;
use crate::app::cohort::{Cohort, cohort, file_names, write};
use crate::mesh::unit::Rounded;
use crate::tree::file::check_place;
use crate::tree::measure::compare::DeltaSize;

/// Differences that are named on the screen at most.
const TOLD_MOST: usize = 10;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// A folder of models, or a list with one a line: path, then if wanted a file of endpoints and a source "X,Y,Z"; .json files of
    /// `ramus analyze --json` are models that were analyzed already
    models: PathBuf,
    /// Which group each model is of: a table with the columns model and group
    #[arg(long, value_name = "FILE")]
    groups: Option<PathBuf>,
    /// The folder for tables and pictures; it is made where there is none
    #[arg(long, value_name = "DIR", required_unless_present = "plan")]
    out: Option<PathBuf>,
    /// Let lines go on to the middles of surfaces' open ends, which are closed flat, and not end a radius before them; analyses that are
    /// there already stay as they are
    #[arg(long)]
    cap: bool,
    /// Analyze nothing: print the models with their endpoints as a list, which this command reads, too
    #[arg(long, conflicts_with_all = ["groups", "out", "cap"])]
    plan: bool,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let entries = entries(&args.models)?;
    let Some(out) = &args.out else {
        let list = plan(&entries)?;
        return print_result("the list", |to| to.write_all(list.as_bytes()));
    };
    // All that can be refused is, before any work.
    let groups = args.groups.as_deref().map(Groups::read).transpose()?;
    folder(out)?;
    check_outputs(args, &entries, out)?;
    start_watch();
    let mut progress = Progress::new("analyzing models");
    let cohort = cohort(&entries, groups.as_ref(), args.cap, &mut |done, of| {
        progress.show(done, of);
    })?;
    drop(progress);
    remarks(&cohort, args);
    let comparisons = cohort.comparisons();
    Progress::during("writing", || write(&cohort, &comparisons, out))?;
    let said = screen(&cohort, &comparisons, out);
    print_result("the summary", |to| to.write_all(said.as_bytes()))?;
    let failed = cohort.failed().count();
    ensure!(
        failed == 0,
        "{failed} of {} could not be analyzed; {} says why",
        many(cohort.models.len(), "model", "models"),
        out.join("models.csv").display()
    );
    Ok(())
}

/// Makes the folder where there is none.
fn folder(out: &Path) -> Result<()> {
    let name = out.display();
    if out.exists() && !out.is_dir() {
        bail!("{name} is no folder: choose another name for the results");
    }
    std::fs::create_dir_all(out)
        .with_context(|| format!("the folder {name} cannot be made: choose another"))
}

/// Results never go over what they are made from, and can be written.
fn check_outputs(args: &Args, entries: &[Entry], out: &Path) -> Result<()> {
    let names = file_names();
    let results = out.canonicalize().unwrap_or_else(|_| out.to_owned());
    let models = entries.iter().map(|entry| &entry.path);
    let ends = entries.iter().filter_map(|entry| entry.endpoints.as_ref());
    for input in models.chain(ends).chain([&args.models]).chain(&args.groups) {
        let is_name = input
            .file_name()
            .is_some_and(|name| names.iter().any(|other| name == other.as_str()));
        // Nothing else in that folder is written to.
        if is_name
            && input
                .canonicalize()
                .is_ok_and(|place| place.parent() == Some(&results))
        {
            return Err(anyhow!(
                "{} would be overwritten by what is made from it: choose another folder",
                input.display()
            ));
        }
    }
    for name in names {
        check_place(&out.join(name))?;
    }
    Ok(())
}

/// What a person should know of the tables.
fn remarks(cohort: &Cohort, args: &Args) {
    for (model, reason) in cohort.failed() {
        whisper!("{model} failed: {reason}");
    }
    let file = args.groups.as_deref().map(Path::display);
    if let Some(file) = file {
        for name in &cohort.unknown {
            whisper!("{file}: there is no model {name}");
        }
        for model in cohort.groupless() {
            whisper!("{file}: {model} is of no group");
        }
        if cohort.groups.len() < 2 {
            whisper!("{file}: there is one group alone, so nothing is compared");
        }
    }
    let units = cohort.units();
    if units.len() > 1 {
        let told: Vec<String> = units
            .iter()
            .map(|(unit, count)| format!("{count} in {unit}"))
            .collect();
        whisper!(
            "models are most likely in different units ({}): compare no lengths before that is looked into",
            told.join(", ")
        );
    }
}

fn many(count: usize, one: &str, more: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { more })
}

/// A few lines.
fn screen(cohort: &Cohort, comparisons: &[Comparison], out: &Path) -> String {
    let failed = match cohort.failed().count() {
        0 => String::new(),
        failed => format!(" ({failed} failed)"),
    };
    let mut lines = vec![format!(
        "{}{failed}, {}, {} by VMTK's definition, in {}",
        many(cohort.models.len(), "model", "models"),
        many(cohort.branches(Definition::Whole), "branch", "branches"),
        cohort.branches(Definition::Vmtk),
        out.display()
    )];
    if !cohort.groups.is_empty() {
        let sizes = cohort.groups.iter().enumerate().map(|(place, name)| {
            let models = cohort
                .models
                .iter()
                .filter(|model| model.group == Some(place));
            format!("{name} ({})", models.count())
        });
        lines.push(format!("groups: {}", sizes.collect::<Vec<_>>().join(", ")));
        lines.extend(differences(cohort, comparisons));
    }
    lines.join("\n") + "\n"
}

/// What groups differ in, as far as many tests tell.
fn differences(cohort: &Cohort, comparisons: &[Comparison]) -> Vec<String> {
    let mut differ: Vec<_> = comparisons
        .iter()
        .filter_map(|one| Some((one, one.tested?)))
        .filter(|(_, tested)| tested.ranks_corrected[0] < 0.05)
        .collect();
    differ.sort_by(|a, b| a.1.ranks.p.total_cmp(&b.1.ranks.p));
    let tests = comparisons
        .iter()
        .filter(|one| one.tested.is_some())
        .count();
    let mut lines = vec![format!(
        "{} of {} differ by the Mann–Whitney test with p below 0.05, corrected by Holm",
        differ.len(),
        many(tests, "comparison", "comparisons")
    )];
    for (one, tested) in differ.iter().take(TOLD_MOST) {
        let [a, b] = one.groups.map(|group| &cohort.groups[group]);
        let [of_a, of_b] = one.sides.map(|side| {
            side.median
                .map_or_else(String::new, |median| Rounded(median).to_string())
        });
        lines.push(format!(
            "  {}: {a} {of_a}, {b} {of_b} (medians), p {:.2e}, Cliff's delta {:.2} ({})",
            one.measure.name,
            tested.ranks_corrected[0],
            tested.delta,
            DeltaSize::of(tested.delta).name()
        ));
    }
    if differ.len() > TOLD_MOST {
        lines.push(format!("  and {} more", differ.len() - TOLD_MOST));
    }
    lines
}
