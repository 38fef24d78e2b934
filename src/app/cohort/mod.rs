//! Several models at once: one table of models, one of branches, and groups of them compared.
//!
//! ```text
//! folder or list ─▶ entries ─┬─ analyzed already (JSON) ───────────┐
//!                            └─ run: several at a time ─▶ Analysis ─┴─▶ told ─▶ tables ─────▶ CSV, JSON, Parquet
//! table of groups ─▶ groups ────────────────────────────────────────────────┴─▶ comparison ─┬─▶ the same
//!                                                                                           └─▶ picture ─▶ SVG
//! ```
//!
//! Rows are in the order of the models' names, so that neither the order of a list nor the number of threads changes a byte.

pub mod comparison;
pub mod entries;
pub mod groups;
mod measures;
pub(in crate::app) mod picture;
mod run;
mod tables;
pub mod told;

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use rayon::prelude::*;

use self::comparison::{Comparison, comparisons};
use self::entries::Entry;
use self::groups::{Groups, Named};
use self::told::{Definition, Facts, Told};
use crate::app::sentence;
use crate::app::table::{Column, Format, Table};
use crate::tree::TreeError;
use crate::tree::file::write_atomically;

/// Branches of a cohort at most, of both definitions together.
const BRANCHES_MOST: usize = 10_000_000;
/// Analyses that are read between two looks at the progress.
const READ_TOGETHER: usize = 64;

/// Names of tables, without their endings.
const TABLES: [&str; 3] = ["branches", "comparison", "models"];
/// What else is written.
const OTHERS: [&str; 3] = ["columns.csv", "models.svg", "branches.svg"];

/// A model of a cohort.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// What it is called in tables.
    pub label: String,
    /// The number of its group.
    pub group: Option<usize>,
    /// What is known of it.
    pub told: Told,
}

impl Model {
    /// What was found, if it was.
    pub fn facts(&self) -> Option<&Facts> {
        match &self.told {
            Told::Found(facts) => Some(facts),
            Told::Failed(..) => None,
        }
    }
}

/// Models and their groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cohort {
    /// By their names.
    pub models: Vec<Model>,
    /// The groups' names, in the order in which they are compared.
    pub groups: Vec<String>,
    /// Names in the table of groups that no model has.
    pub unknown: Vec<String>,
}

/// Analyzes the models of a cohort, or reads what was told of them; a model that fails costs nobody the rest. `progress` gets how many are
/// done of how many. `cap`: lines go on to the middles of open ends, of surfaces that are analyzed now.
///
/// # Errors
/// What keeps all of them from being told: a model that is there twice, groups that do not fit, more branches than a table takes.
pub fn cohort(
    entries: &[Entry],
    groups: Option<&Groups>,
    cap: bool,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Cohort> {
    // What was analyzed already says of which file: names and groups are known before the long work.
    let ready = entries.iter().filter(|entry| entry.is_analyzed()).count();
    let mut told: Vec<Option<Told>> = Vec::with_capacity(entries.len());
    for some in entries.chunks(READ_TOGETHER) {
        let read = |entry: &Entry| entry.is_analyzed().then(|| read(&entry.path));
        told.par_extend(some.par_iter().map(read));
        progress(told.len().min(ready), entries.len());
    }
    let paths: Vec<PathBuf> = entries
        .iter()
        .zip(&told)
        .map(|(entry, told)| match told {
            Some(told) => PathBuf::from(told.file()),
            None => entry.path.clone(),
        })
        .collect();
    let labels = entries::labels(&paths)?;
    let named: Vec<Named<'_>> = labels
        .iter()
        .zip(&paths)
        .map(|(label, path)| Named { label, path })
        .collect();
    let grouped = groups.map(|groups| groups.of(&named)).transpose()?;
    let grouped = grouped.unwrap_or_default();
    let open = || (0..entries.len()).filter(|place| !entries[*place].is_analyzed());
    let left: Vec<&Entry> = open().map(|place| &entries[place]).collect();
    let results = run::analyzed(&left, cap, &mut |done, _| {
        progress(ready + done, entries.len())
    });
    for (place, result) in open().zip(results) {
        let failed = |reason| Told::Failed(paths[place].display().to_string(), reason);
        told[place] = Some(result.unwrap_or_else(failed));
    }
    let mut models: Vec<Model> = labels
        .into_iter()
        .zip(told)
        .enumerate()
        .filter_map(|(place, (label, told))| {
            Some(Model {
                told: named_alike(told?, &label),
                group: grouped.of.get(place).copied().flatten(),
                label,
            })
        })
        .collect();
    models.sort_by(|a, b| a.label.cmp(&b.label));
    let cohort = Cohort {
        models,
        groups: groups.map_or_else(Vec::new, |groups| groups.names.clone()),
        unknown: grouped.unknown,
    };
    let facts = cohort.models.iter().filter_map(Model::facts);
    let branches: usize = facts.map(Facts::branches_of_all).sum();
    ensure!(
        branches <= BRANCHES_MOST,
        "the models have {branches} branches, of both definitions together, more than {BRANCHES_MOST}: split the cohort"
    );
    Ok(cohort)
}

/// What a file tells, or that it tells nothing.
fn read(path: &Path) -> Told {
    Told::read(path).unwrap_or_else(|error| {
        // What it would be of is not known: it stands for itself.
        Told::Failed(path.display().to_string(), sentence(&error))
    })
}

/// A reason calls the model as tables do, from wherever it was analyzed.
fn named_alike(told: Told, label: &str) -> Told {
    match told {
        Told::Failed(file, reason) => {
            let reason = reason.replace(&file, label);
            Told::Failed(file, reason)
        }
        found => found,
    }
}

impl Cohort {
    /// How many branches of a definition all models have.
    pub fn branches(&self, definition: Definition) -> usize {
        let facts = self.models.iter().filter_map(Model::facts);
        facts.map(|facts| facts.branches_of(definition).len()).sum()
    }

    /// Models that could not be analyzed, with the reason.
    pub fn failed(&self) -> impl Iterator<Item = (&str, &str)> {
        self.models.iter().filter_map(|model| match &model.told {
            Told::Failed(_, reason) => Some((model.label.as_str(), reason.as_str())),
            Told::Found(_) => None,
        })
    }

    /// Models of no group, where there are groups.
    pub fn groupless(&self) -> impl Iterator<Item = &str> {
        let models = self.models.iter();
        models
            .filter(|model| !self.groups.is_empty() && model.group.is_none())
            .map(|model| model.label.as_str())
    }

    /// The units that models are most likely in, each with the number of its models.
    pub fn units(&self) -> Vec<(&'static str, usize)> {
        let mut units: Vec<(&'static str, usize)> = Vec::new();
        for facts in self.models.iter().filter_map(Model::facts) {
            let name = facts
                .model
                .unit
                .map_or("an unknown unit", |unit| unit.name());
            match units.iter_mut().find(|(other, _)| *other == name) {
                Some((_, count)) => *count += 1,
                None => units.push((name, 1)),
            }
        }
        units
    }

    /// What its groups differ in.
    pub fn comparisons(&self) -> Vec<Comparison> {
        comparisons(self)
    }
}

/// The files that are written into a folder, by their names.
pub fn file_names() -> Vec<String> {
    let tables = TABLES
        .iter()
        .flat_map(|table| Format::ALL.map(|format| format!("{table}.{}", format.ending())));
    tables.chain(OTHERS.map(str::to_owned)).collect()
}

/// The pictures of models and of branches, as SVG.
pub fn pictures(cohort: &Cohort, comparisons: &[Comparison]) -> [String; 2] {
    [
        picture::models(cohort, comparisons),
        picture::branches(cohort),
    ]
}

/// Writes tables and pictures into a folder that is there. Those of an older run are replaced, and what this one has none of is taken away.
/// `models.csv` is written last: where it is, all is.
///
/// # Errors
/// Where the disk does not take it.
pub fn write(cohort: &Cohort, comparisons: &[Comparison], folder: &Path) -> Result<(), TreeError> {
    let place = |name: &str| folder.join(name);
    let (branches, models) = (tables::branches(cohort), tables::models(cohort));
    let comparison = comparison::table(cohort, comparisons);
    let mut all: Vec<(&str, &Table<'_>)> = vec![("branches", &branches), ("models", &models)];
    match cohort.groups.is_empty() {
        true => {
            for format in Format::ALL {
                // Where there was none, that is as it should be.
                let _ = std::fs::remove_file(place(&format!("comparison.{}", format.ending())));
            }
        }
        false => all.insert(1, ("comparison", &comparison)),
    }
    let [of_models, of_branches] = pictures(cohort, comparisons);
    write_atomically(&place("branches.svg"), of_branches.as_bytes())?;
    write_atomically(&place("models.svg"), of_models.as_bytes())?;
    let columns: Vec<(&str, &[Column])> = all
        .iter()
        .map(|(name, table)| (*name, table.columns.as_slice()))
        .collect();
    tables::columns(&columns).write(&place("columns.csv"), Format::Csv)?;
    for (name, table) in all {
        for format in [Format::Parquet, Format::Json, Format::Csv] {
            table.write(&place(&format!("{name}.{}", format.ending())), format)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
