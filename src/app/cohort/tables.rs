//! The tables of a cohort: one row a model, one row a branch, and what their columns mean.

use super::Cohort;
use super::measures::{NOTHING, of_branches, of_models};
use super::told::{Facts, Told};
use crate::app::table::{Cell, Column, Kind, Table};

fn text(name: &str, meaning: &str) -> Column {
    Column {
        name: name.to_owned(),
        kind: Kind::Text,
        unit: NOTHING,
        meaning: meaning.to_owned(),
        definition: NOTHING,
    }
}

fn group_of(cohort: &Cohort, model: usize) -> Cell<'_> {
    let group = cohort.models[model].group;
    Cell::or_empty(group, |group| Cell::Text(&cohort.groups[group]))
}

/// One row a model; those that failed have a reason and nothing else.
pub(super) fn models(cohort: &Cohort) -> Table<'_> {
    let measures = of_models();
    let mut columns = vec![
        text(
            "model",
            "the model's file, with as many folders as tell all apart",
        ),
        text("group", "its group"),
        text("failed", "why it could not be analyzed; empty where it was"),
    ];
    columns.extend(measures.iter().map(|measure| measure.column.clone()));
    let cells = move |row: usize, column: usize| {
        let model = &cohort.models[row];
        match (column, &model.told) {
            (0, _) => Cell::Text(&model.label),
            (1, _) => group_of(cohort, row),
            (2, Told::Failed(_, reason)) => Cell::Text(reason),
            (2, Told::Found(_)) | (_, Told::Failed(..)) => Cell::Empty,
            (column, Told::Found(facts)) => (measures[column - 3].of)(facts),
        }
    };
    Table {
        columns,
        rows: cohort.models.len(),
        cells: Box::new(cells),
    }
}

/// One row a branch: of each model the whole ones, then those of VMTK's definition.
pub(super) fn branches(cohort: &Cohort) -> Table<'_> {
    let measures = of_branches();
    let mut columns = vec![
        text(
            "model",
            "the model's file, with as many folders as tell all apart",
        ),
        text("group", "its group"),
    ];
    columns.extend(measures.iter().map(|measure| measure.column.clone()));
    // Where the branches of each model begin.
    let mut starts = vec![0_usize];
    for model in &cohort.models {
        let rows = model.facts().map_or(0, Facts::branches_of_all);
        starts.push(starts[starts.len() - 1] + rows);
    }
    let rows = starts[starts.len() - 1];
    let cells = move |row: usize, column: usize| {
        let model = starts.partition_point(|start| *start <= row) - 1;
        match (column, cohort.models[model].facts()) {
            (0, _) => Cell::Text(&cohort.models[model].label),
            (1, _) => group_of(cohort, model),
            (column, Some(facts)) => {
                let place = row - starts[model];
                let branch = match place.checked_sub(facts.branches.len()) {
                    None => &facts.branches[place],
                    Some(place) => &facts.branches_vmtk[place],
                };
                (measures[column - 2].of)(branch)
            }
            (_, None) => Cell::Empty,
        }
    };
    Table {
        columns,
        rows,
        cells: Box::new(cells),
    }
}

/// What the columns of tables mean: a table, too.
pub(super) fn columns<'a>(tables: &[(&'a str, &'a [Column])]) -> Table<'a> {
    let columns = [
        ("table", "the table that has it"),
        ("column", "its name"),
        ("type", "what its cells are"),
        (
            "unit",
            "what its numbers are counted in; `length` is the model's own unit",
        ),
        (
            "definition",
            "the definition of a branch that it follows, whole or vmtk; empty where it follows none, or where rows tell",
        ),
        ("meaning", "what it says"),
    ];
    let rows: Vec<(&str, &Column)> = tables
        .iter()
        .flat_map(|(name, columns)| columns.iter().map(move |column| (*name, column)))
        .collect();
    Table {
        columns: columns.map(|(name, meaning)| text(name, meaning)).to_vec(),
        rows: rows.len(),
        cells: Box::new(move |row, place| {
            let (table, column) = rows[row];
            let words = match place {
                0 => table,
                1 => &column.name,
                2 => column.kind.name(),
                3 => column.unit,
                4 => column.definition,
                _ => &column.meaning,
            };
            match words.is_empty() {
                true => Cell::Empty,
                false => Cell::Text(words),
            }
        }),
    }
}
