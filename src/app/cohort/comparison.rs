//! Groups of models compared, measure by measure and pair by pair.
//!
//! What is compared is one value a model: a model is what was drawn from a population, and its branches are no more independent of each
//! other than the leaves of one tree. A test that took them as such would find differences where there are none.

use super::Cohort;
use super::measures::{Measure, of_models};
use super::told::Facts;
use crate::app::table::{Cell, Column, Kind, Table};
use crate::tree::measure::compare::{
    DeltaSize, KolmogorovSmirnov, MannWhitney, benjamini_hochberg, cliffs_delta, hedges_g, holm,
    kolmogorov_smirnov, mann_whitney,
};
use crate::tree::measure::{quantile, spread};

/// Values of a group from which on it is compared.
const VALUES_LEAST: usize = 2;

/// Two groups by one measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The measure's column.
    pub measure: Column,
    /// The groups' numbers.
    pub groups: [usize; 2],
    /// Their values.
    pub sides: [Side; 2],
    /// The test; None where it was not made.
    pub tested: Option<Tested>,
    /// Why it was not made.
    pub remark: Option<String>,
}

/// A group's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// How many models have one.
    pub n: usize,
    /// Their median.
    pub median: Option<f64>,
    /// Their mean.
    pub mean: Option<f64>,
}

/// What tests tell. Signs: above zero where the first group has the larger values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    /// By ranks.
    pub ranks: MannWhitney,
    /// Its p, corrected by Holm and by Benjamini and Hochberg.
    pub ranks_corrected: [f64; 2],
    /// By distributions.
    pub apart: KolmogorovSmirnov,
    /// Its p, corrected in the same ways.
    pub apart_corrected: [f64; 2],
    /// Cliff's delta.
    pub delta: f64,
    /// Hedges' g.
    pub g: Option<f64>,
}

/// Compares all pairs of groups by all measures that groups are compared by.
pub(super) fn comparisons(cohort: &Cohort) -> Vec<Comparison> {
    let measures = of_models();
    let groups = cohort.groups.len();
    let mut all: Vec<Comparison> = measures
        .iter()
        .filter(|measure| measure.compared)
        .flat_map(|measure| {
            let values: Vec<Vec<f64>> = (0..groups)
                .map(|group| values(cohort, Some(group), measure))
                .collect();
            let pairs = (0..groups).flat_map(|a| (a + 1..groups).map(move |b| [a, b]));
            pairs
                .map(|pair| {
                    compared(
                        cohort,
                        measure,
                        pair,
                        pair.map(|one| values[one].as_slice()),
                    )
                })
                .collect::<Vec<_>>()
        })
        .collect();
    correct(&mut all);
    all
}

/// The values of a group's models, of those that have one; of all models where no group is asked for.
pub(super) fn values(cohort: &Cohort, group: Option<usize>, measure: &Measure<Facts>) -> Vec<f64> {
    cohort
        .models
        .iter()
        .filter(|model| group.is_none() || model.group == group)
        .filter_map(|model| measure.number(model.facts()?))
        .collect()
}

fn side(values: &[f64]) -> Side {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let mean = spread(sorted.iter().copied()).mean;
    Side {
        n: values.len(),
        median: quantile(&sorted, 0.5),
        mean: (!values.is_empty()).then_some(mean),
    }
}

fn compared(
    cohort: &Cohort,
    measure: &Measure<Facts>,
    groups: [usize; 2],
    [a, b]: [&[f64]; 2],
) -> Comparison {
    let remark = untestable(cohort, groups, [a, b]);
    let both = mann_whitney(a, b).zip(kolmogorov_smirnov(a, b));
    let tested = both
        .filter(|_| remark.is_none())
        .map(|(ranks, apart)| Tested {
            ranks,
            ranks_corrected: [ranks.p; 2],
            apart,
            apart_corrected: [apart.p; 2],
            delta: cliffs_delta(ranks.u, a.len(), b.len()),
            g: hedges_g(a, b),
        });
    Comparison {
        measure: measure.column.clone(),
        groups,
        sides: [side(a), side(b)],
        tested,
        remark,
    }
}

/// Why two groups cannot be compared.
fn untestable(cohort: &Cohort, groups: [usize; 2], values: [&[f64]; 2]) -> Option<String> {
    for (group, values) in groups.into_iter().zip(values) {
        let name = &cohort.groups[group];
        match values.len() {
            0 => return Some(format!("not tested: no model of {name} has it")),
            1 => return Some(format!("not tested: one model of {name} alone has it")),
            _ => {}
        }
        debug_assert!(values.len() >= VALUES_LEAST, "two values are compared");
    }
    let [a, b] = values;
    let first = a.first()?;
    let same = a.iter().chain(b).all(|value| value == first);
    same.then(|| "not tested: it is the same in all models".to_owned())
}

/// Corrects the p of each test for all measures and pairs that were tested. Those of both definitions count: whoever looks at both for what
/// differs has as many chances.
fn correct(all: &mut [Comparison]) {
    let mut tested: Vec<&mut Tested> = all
        .iter_mut()
        .filter_map(|one| one.tested.as_mut())
        .collect();
    let ranks: Vec<f64> = tested.iter().map(|one| one.ranks.p).collect();
    let apart: Vec<f64> = tested.iter().map(|one| one.apart.p).collect();
    let by = [holm, benjamini_hochberg];
    let [ranks, apart] = [ranks, apart].map(|values| by.map(|correct| correct(&values)));
    for (place, one) in tested.iter_mut().enumerate() {
        one.ranks_corrected = [ranks[0][place], ranks[1][place]];
        one.apart_corrected = [apart[0][place], apart[1][place]];
    }
}

/// What a column of the comparison takes.
type Taken = for<'a> fn(&'a Cohort, &'a Comparison) -> Cell<'a>;

fn tested(comparison: &Comparison, of: fn(&Tested) -> Cell<'static>) -> Cell<'static> {
    comparison.tested.as_ref().map_or(Cell::Empty, of)
}

fn real(value: Option<f64>) -> Cell<'static> {
    Cell::or_empty(value, Cell::Real)
}

const COLUMNS: [(&str, Kind, &str, Taken); 26] = [
    (
        "measure",
        Kind::Text,
        "the column of the table of models",
        |_, one| Cell::Text(&one.measure.name),
    ),
    (
        "definition",
        Kind::Text,
        "the definition of a branch that it follows: whole or vmtk; empty where it follows none",
        |_, one| match one.measure.definition {
            "" => Cell::Empty,
            definition => Cell::Text(definition),
        },
    ),
    (
        "unit",
        Kind::Text,
        "what medians and means are counted in",
        |_, one| match one.measure.unit {
            "" => Cell::Empty,
            unit => Cell::Text(unit),
        },
    ),
    ("group_a", Kind::Text, "the first group", |cohort, one| {
        Cell::Text(&cohort.groups[one.groups[0]])
    }),
    ("group_b", Kind::Text, "the second group", |cohort, one| {
        Cell::Text(&cohort.groups[one.groups[1]])
    }),
    (
        "n_a",
        Kind::Whole,
        "models of the first group that have a value",
        |_, one| Cell::whole(one.sides[0].n),
    ),
    (
        "n_b",
        Kind::Whole,
        "models of the second group that have a value",
        |_, one| Cell::whole(one.sides[1].n),
    ),
    (
        "median_a",
        Kind::Real,
        "median of the first group",
        |_, one| real(one.sides[0].median),
    ),
    (
        "median_b",
        Kind::Real,
        "median of the second group",
        |_, one| real(one.sides[1].median),
    ),
    ("mean_a", Kind::Real, "mean of the first group", |_, one| {
        real(one.sides[0].mean)
    }),
    (
        "mean_b",
        Kind::Real,
        "mean of the second group",
        |_, one| real(one.sides[1].mean),
    ),
    (
        "mann_whitney_u",
        Kind::Real,
        "pairs of models in which the first group's is larger; equal ones count half",
        |_, one| tested(one, |one| Cell::Real(one.ranks.u)),
    ),
    (
        "mann_whitney_p",
        Kind::Real,
        "p of it, two-sided",
        |_, one| tested(one, |one| Cell::Real(one.ranks.p)),
    ),
    (
        "mann_whitney_method",
        Kind::Text,
        "exact, or by the normal distribution (limit)",
        |_, one| tested(one, |one| Cell::Text(one.ranks.method.name())),
    ),
    (
        "mann_whitney_p_holm",
        Kind::Real,
        "p corrected by Holm for all rows that were tested, of both definitions",
        |_, one| tested(one, |one| Cell::Real(one.ranks_corrected[0])),
    ),
    (
        "mann_whitney_p_bh",
        Kind::Real,
        "p corrected by Benjamini and Hochberg for all rows that were tested, of both definitions",
        |_, one| tested(one, |one| Cell::Real(one.ranks_corrected[1])),
    ),
    (
        "ks_d",
        Kind::Real,
        "largest difference between the distributions (Kolmogorov, Smirnov), 0 to 1",
        |_, one| tested(one, |one| Cell::Real(one.apart.d)),
    ),
    ("ks_p", Kind::Real, "p of it, two-sided", |_, one| {
        tested(one, |one| Cell::Real(one.apart.p))
    }),
    (
        "ks_method",
        Kind::Text,
        "exact, or by Kolmogorov's distribution (limit)",
        |_, one| tested(one, |one| Cell::Text(one.apart.method.name())),
    ),
    (
        "ks_p_holm",
        Kind::Real,
        "p corrected by Holm for all rows that were tested, of both definitions",
        |_, one| tested(one, |one| Cell::Real(one.apart_corrected[0])),
    ),
    (
        "ks_p_bh",
        Kind::Real,
        "p corrected by Benjamini and Hochberg for all rows that were tested, of both definitions",
        |_, one| tested(one, |one| Cell::Real(one.apart_corrected[1])),
    ),
    (
        "cliffs_delta",
        Kind::Real,
        "Cliff's delta (rank-biserial correlation): 1 where all of the first group are larger, -1 where all are smaller",
        |_, one| tested(one, |one| Cell::Real(one.delta)),
    ),
    (
        "cliffs_delta_size",
        Kind::Text,
        "negligible below 0.147, small below 0.33, medium below 0.474, else large",
        |_, one| tested(one, |one| Cell::Text(DeltaSize::of(one.delta).name())),
    ),
    (
        "hedges_g",
        Kind::Real,
        "Hedges' g: mean of the first group less that of the second, in standard deviations",
        |_, one| one.tested.map_or(Cell::Empty, |one| real(one.g)),
    ),
    ("tested", Kind::Flag, "whether it was tested", |_, one| {
        Cell::Flag(one.tested.is_some())
    }),
    ("remark", Kind::Text, "why it was not tested", |_, one| {
        Cell::or_empty(one.remark.as_deref(), Cell::Text)
    }),
];

/// One row a measure and a pair of groups.
pub(super) fn table<'a>(cohort: &'a Cohort, comparisons: &'a [Comparison]) -> Table<'a> {
    let columns = COLUMNS.map(|(name, kind, meaning, _)| Column {
        name: name.to_owned(),
        kind,
        unit: "",
        meaning: meaning.to_owned(),
        definition: "",
    });
    Table {
        columns: columns.to_vec(),
        rows: comparisons.len(),
        cells: Box::new(|row, column| (COLUMNS[column].3)(cohort, &comparisons[row])),
    }
}
