//! What is told of models and of branches, measure by measure: each is a column, with its unit and its meaning.
//!
//! Names are those of the analysis (`ramus-analysis/1`), made flat: `branch_length.mean` is `branch_length_mean`. What follows VMTK's definition
//! of a branch begins with `vmtk_`: `table_vmtk.branch_length.mean` is `vmtk_branch_length_mean`.

use super::told::{Branch, CountsVmtk, Definition, Facts, Junction, Measured, Spread};
use crate::app::table::{Cell, Column, Kind};
use crate::tree::measure::spread;

/// The model's own unit of length, which `unit` tells where it is known.
pub(super) const LENGTH: &str = "length";
const AREA: &str = "length²";
const VOLUME: &str = "length³";
const PER_LENGTH: &str = "1/length";
const DEGREES: &str = "degrees";
pub(super) const NOTHING: &str = "";

/// A column of values that are taken of something.
pub(super) struct Measure<T: ?Sized> {
    /// The column.
    pub column: Column,
    /// Whether groups are compared by it.
    pub compared: bool,
    /// Its value.
    pub of: Box<dyn Fn(&T) -> Cell<'_> + Send + Sync>,
}

impl<T: ?Sized> Measure<T> {
    fn new(
        name: impl Into<String>,
        kind: Kind,
        unit: &'static str,
        meaning: impl Into<String>,
        of: impl Fn(&T) -> Cell<'_> + Send + Sync + 'static,
    ) -> Self {
        Self {
            column: Column {
                name: name.into(),
                kind,
                unit,
                meaning: meaning.into(),
                definition: NOTHING,
            },
            compared: false,
            of: Box::new(of),
        }
    }

    fn compared(mut self) -> Self {
        self.compared = true;
        self
    }

    /// Of whole branches.
    fn whole(mut self) -> Self {
        self.column.definition = Definition::Whole.name();
        self
    }

    /// Its value as a number, where it is one.
    pub(super) fn number(&self, of: &T) -> Option<f64> {
        match (self.of)(of) {
            Cell::Real(number) => number.is_finite().then_some(number),
            Cell::Whole(number) => Some(number as f64),
            _ => None,
        }
    }
}

fn real(value: Option<f64>) -> Cell<'static> {
    Cell::or_empty(value, Cell::Real)
}

fn count(name: &'static str, meaning: &'static str, of: fn(&Facts) -> usize) -> Measure<Facts> {
    Measure::new(name, Kind::Whole, NOTHING, meaning, move |facts| {
        Cell::whole(of(facts))
    })
}

fn number<T: 'static>(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    of: fn(&T) -> Option<f64>,
) -> Measure<T> {
    Measure::new(name, Kind::Real, unit, meaning, move |one| real(of(one)))
}

/// Five columns of a spread; what is compared of it is named.
fn spread_of<T: 'static>(
    name: &str,
    unit: &'static str,
    meaning: &str,
    compared: &[&str],
    of: fn(&T) -> Spread,
) -> Vec<Measure<T>> {
    let n = Measure::new(
        format!("{name}_n"),
        Kind::Whole,
        NOTHING,
        format!("{meaning}: how many"),
        move |one: &T| Cell::whole(of(one).n),
    );
    type Part = fn(&Spread) -> Option<f64>;
    let parts: [(&str, &str, Part); 4] = [
        ("mean", "mean", |spread| spread.mean),
        ("std", "standard deviation (of the population)", |spread| {
            spread.std
        }),
        ("min", "smallest", |spread| spread.min),
        ("max", "largest", |spread| spread.max),
    ];
    let numbers = parts.into_iter().map(|(part, words, value)| {
        let measure = Measure::new(
            format!("{name}_{part}"),
            Kind::Real,
            unit,
            format!("{meaning}: {words}"),
            move |one: &T| {
                let spread = of(one);
                // Of nothing there is no mean, though the analysis says 0.
                real(value(&spread).filter(|_| spread.n > 0))
            },
        );
        match compared.contains(&part) {
            true => measure.compared(),
            false => measure,
        }
    });
    std::iter::once(n).chain(numbers).collect()
}

/// The sum over branches.
fn total(facts: &Facts, of: fn(&Branch) -> Option<f64>) -> Option<f64> {
    facts.branches.iter().map(of).sum::<Option<f64>>()
}

fn over_junctions(facts: &Facts, of: impl Fn(&Junction) -> Option<f64>) -> Spread {
    spread(facts.junctions.iter().filter_map(of)).into()
}

fn angles_to_parents(facts: &Facts) -> Spread {
    let angles = facts
        .junctions
        .iter()
        .flat_map(|junction| &junction.parent_angles_deg);
    spread(angles.copied().flatten()).into()
}

/// What is told of a model.
pub(super) fn of_models() -> Vec<Measure<Facts>> {
    let mut all = about_models();
    let whole = counts().into_iter().chain(of_table(Definition::Whole));
    all.extend(whole.chain(of_junctions()).map(Measure::whole));
    all.extend(counts_vmtk());
    all.extend(of_table(Definition::Vmtk));
    all
}

/// How many there are, and their sums.
fn counts() -> Vec<Measure<Facts>> {
    vec![
        count(
            "branches",
            "branches, from junction to junction or to the root or a tip",
            |facts| facts.counts.branches,
        )
        .compared(),
        count("junctions", "nodes with two daughters or more", |facts| {
            facts.counts.junctions
        }),
        count("bifurcations", "those with two", |facts| {
            facts.counts.bifurcations
        }),
        count("multifurcations", "those with more", |facts| {
            facts.counts.multifurcations
        }),
        count("tips", "ends", |facts| facts.counts.tips).compared(),
        number("total_length", LENGTH, "length of all branches", |facts| {
            total(facts, |one| one.length)
        })
        .compared(),
        number(
            "total_area",
            AREA,
            "lateral surface of all branches",
            |facts| total(facts, |one| one.area),
        ),
        number("total_volume", VOLUME, "volume of all branches", |facts| {
            total(facts, |one| one.volume)
        })
        .compared(),
    ]
}

/// How many there are by VMTK's definition.
fn counts_vmtk() -> Vec<Measure<Facts>> {
    type Of = fn(&CountsVmtk) -> usize;
    let counts: [(&str, &str, bool, Of); 5] = [
        (
            "branches",
            "VMTK's branches: outside bifurcations",
            true,
            |counts| counts.branches,
        ),
        (
            "bifurcations",
            "VMTK's bifurcations of two daughters",
            false,
            |counts| counts.bifurcations,
        ),
        (
            "multifurcations",
            "VMTK's bifurcations of more",
            false,
            |counts| counts.multifurcations,
        ),
        (
            "tips",
            "VMTK's branches that end in a tip",
            true,
            |counts| counts.tips,
        ),
        (
            "swallowed",
            "tips whose lines never leave another's tube, and that VMTK has no branch of",
            false,
            |counts| counts.swallowed,
        ),
    ];
    let measures = counts.map(|(name, meaning, compared, of)| {
        let name = format!("{}{name}", Definition::Vmtk.prefix());
        let mut measure =
            Measure::new(name, Kind::Whole, NOTHING, meaning, move |facts: &Facts| {
                Cell::or_empty(facts.counts_vmtk, |counts| Cell::whole(of(&counts)))
            });
        measure.column.definition = Definition::Vmtk.name();
        measure.compared = compared;
        measure
    });
    measures.into()
}

/// The table of the source papers by a definition.
fn of_table(definition: Definition) -> Vec<Measure<Facts>> {
    let of_facts = |measure: Measure<Measured>| {
        let Measure {
            mut column,
            mut compared,
            of,
        } = measure;
        // Whole ways are the same by both: they are compared once.
        compared &= definition == Definition::Whole || !column.name.starts_with("centerline_");
        column.name.insert_str(0, definition.prefix());
        column.definition = definition.name();
        if definition == Definition::Vmtk {
            column.meaning.push_str(" (by VMTK's definition)");
        }
        Measure {
            column,
            compared,
            of: Box::new(move |facts: &Facts| match facts.table_of(definition) {
                Some(table) => of(table),
                None => Cell::Empty,
            }),
        }
    };
    table().into_iter().map(of_facts).collect()
}

/// Orders, and junctions one by one.
fn of_junctions() -> Vec<Measure<Facts>> {
    let mut all = vec![
        Measure::new(
            "strahler_max",
            Kind::Whole,
            NOTHING,
            "highest of Strahler's orders",
            |facts: &Facts| {
                let orders = facts.branches.iter().filter_map(|branch| branch.strahler);
                Cell::or_empty(orders.max(), |order| Cell::Whole(order.into()))
            },
        )
        .compared(),
        number(
            "branching_ratio",
            NOTHING,
            "branches of one of Strahler's orders to those of the next",
            |facts: &Facts| facts.orders.branching_ratio,
        )
        .compared(),
        number(
            "length_ratio",
            NOTHING,
            "length of one of Strahler's orders to that of the one before",
            |facts: &Facts| facts.orders.length_ratio,
        )
        .compared(),
        number(
            "radius_ratio",
            NOTHING,
            "radius of one of Strahler's orders to that of the one before",
            |facts: &Facts| facts.orders.radius_ratio,
        )
        .compared(),
    ];
    all.extend(spread_of(
        "parent_angle_deg",
        DEGREES,
        "angles between a branch and its daughters",
        &["mean"],
        angles_to_parents,
    ));
    all.extend(spread_of(
        "murray",
        NOTHING,
        "exponents with which daughters' radii add up to the parent's",
        &["mean"],
        |facts| over_junctions(facts, |junction| junction.murray),
    ));
    all.extend(spread_of(
        "asymmetry",
        NOTHING,
        "how unequally tips are shared at junctions, 0 to 1",
        &["mean"],
        |facts| over_junctions(facts, |junction| junction.asymmetry),
    ));
    all
}

/// The surface and its endpoints.
fn about_models() -> Vec<Measure<Facts>> {
    vec![
        Measure::new(
            "unit",
            Kind::Text,
            NOTHING,
            "what the model's numbers are most likely in",
            |facts: &Facts| Cell::or_empty(facts.model.unit, |unit| Cell::Text(unit.name())),
        ),
        count(
            "triangles",
            "triangles of the file; 0 of skeletons",
            |facts| facts.model.triangles,
        ),
        count(
            "vertices",
            "vertices of the file; 0 of skeletons",
            |facts| facts.model.vertices,
        ),
        count("components", "parts that hang together", |facts| {
            facts.model.components
        }),
        count(
            "open_ends",
            "closed lines along which the surface is open",
            |facts| facts.model.open_ends,
        ),
        Measure::new(
            "watertight",
            Kind::Flag,
            NOTHING,
            "whether the surface encloses a space",
            |facts: &Facts| Cell::Flag(facts.model.watertight),
        ),
        Measure::new(
            "automatic",
            Kind::Flag,
            NOTHING,
            "whether the endpoints were found and not given",
            |facts: &Facts| Cell::Flag(facts.endpoints.automatic),
        ),
        count(
            "capped",
            "endpoints from where lines go on to the middle of the open end",
            |facts| facts.endpoints.capped,
        ),
        count("unreached", "targets that no way leads to", |facts| {
            facts.endpoints.unreached()
        }),
        count(
            "centerlines",
            "ways from the source to a target, or from the root to a tip",
            |facts| facts.counts.centerlines,
        ),
        count(
            "loops_left_out",
            "loops of the surface, of which the tree has one side",
            |facts| facts.counts.loops_left_out,
        ),
        Measure::new(
            "definitions",
            Kind::Text,
            NOTHING,
            "by which definitions its branches are told: columns that begin with vmtk_ follow VMTK's and are empty where balls overlap too much for it; all others of branches are of whole ones",
            |facts: &Facts| {
                Cell::Text(match facts.table_vmtk {
                    Some(_) => "whole and vmtk",
                    None => "whole",
                })
            },
        ),
    ]
}

/// The table of the source papers, whatever a branch is.
fn table() -> Vec<Measure<Measured>> {
    let mut all = spread_of(
        "branch_length",
        LENGTH,
        "lengths of branches",
        &["mean", "std"],
        |table: &Measured| table.branch_length,
    );
    all.extend(spread_of(
        "point_radius",
        LENGTH,
        "radii at equally spaced points",
        &["mean", "std"],
        |table: &Measured| table.point_radius,
    ));
    all.extend(spread_of(
        "centerline_length",
        LENGTH,
        "ways from root to tip",
        &["mean", "max"],
        |table: &Measured| table.centerline_length,
    ));
    all.extend([
        number(
            "stem_length",
            LENGTH,
            "from the root to the first junction",
            |table: &Measured| table.stem_length,
        )
        .compared(),
        number(
            "stem_iterations",
            NOTHING,
            "the same in mean branch lengths",
            |table: &Measured| table.stem_iterations,
        ),
        number(
            "iterations_mean",
            NOTHING,
            "ways without the stem in mean branch lengths: mean",
            |table: &Measured| table.iterations.mean,
        )
        .compared(),
        number(
            "iterations_std",
            NOTHING,
            "ways without the stem in mean branch lengths: standard deviation",
            |table: &Measured| table.iterations.std,
        ),
    ]);
    all.extend(spread_of(
        "bifurcation_angle_deg",
        DEGREES,
        "angles between daughters",
        &["mean", "std"],
        |table: &Measured| table.bifurcation_angle_deg,
    ));
    all.extend(spread_of(
        "bifurcation_angle_in_plane_deg",
        DEGREES,
        "angles between daughters in the plane in which they branch",
        &["mean"],
        |table: &Measured| table.bifurcation_angle_in_plane_deg,
    ));
    all.extend([
        number(
            "upwards_angle_deg_mean",
            DEGREES,
            "turns of branches towards the stem's direction: mean",
            |table: &Measured| table.upwards_angle_deg.mean,
        )
        .compared(),
        number(
            "upwards_angle_deg_std",
            DEGREES,
            "turns of branches towards the stem's direction: standard deviation",
            |table: &Measured| table.upwards_angle_deg.std,
        ),
    ]);
    all.extend(spread_of(
        "curvature",
        PER_LENGTH,
        "mean curvatures of branches",
        &["mean"],
        |table: &Measured| table.curvature,
    ));
    all.extend(spread_of(
        "torsion",
        PER_LENGTH,
        "mean torsions of branches",
        &["mean"],
        |table: &Measured| table.torsion,
    ));
    all.extend(spread_of(
        "tortuosity",
        NOTHING,
        "length over chord, less 1, of branches",
        &["mean"],
        |table: &Measured| table.tortuosity,
    ));
    all
}

/// What is told of a branch.
pub(super) fn of_branches() -> Vec<Measure<Branch>> {
    fn whole(
        name: &'static str,
        meaning: &'static str,
        of: fn(&Branch) -> Option<u32>,
    ) -> Measure<Branch> {
        Measure::new(name, Kind::Whole, NOTHING, meaning, move |one| {
            Cell::or_empty(of(one), |number| Cell::Whole(number.into()))
        })
    }
    fn group(
        name: &'static str,
        meaning: &'static str,
        of: fn(&Branch) -> Option<usize>,
    ) -> Measure<Branch> {
        Measure::new(name, Kind::Whole, NOTHING, meaning, move |one| {
            Cell::or_empty(of(one), Cell::whole)
        })
    }
    vec![
        Measure::new(
            "definition",
            Kind::Text,
            NOTHING,
            "what a branch is here: whole, from junction to junction or to the root or a tip; or as vmtk has it, outside bifurcations. Each model has rows of both, which are never to be mixed",
            |one: &Branch| Cell::Text(one.definition.name()),
        ),
        group(
            "id",
            "number within its model and definition; VMTK's numbers count bifurcations, too",
            |one| Some(one.id),
        ),
        group(
            "parent",
            "number of the branch that it grows from (whole)",
            |one| one.parent,
        ),
        group(
            "upstream",
            "number of the bifurcation that it begins in (vmtk)",
            |one| one.upstream,
        ),
        group(
            "downstream",
            "number of the bifurcation that it ends in (vmtk)",
            |one| one.downstream,
        ),
        whole("order", "generation, 0 at the root (whole)", |one| {
            one.order
        }),
        whole("strahler", "Strahler's order (whole)", |one| one.strahler),
        whole("horsfield", "Horsfield's order (whole)", |one| {
            one.horsfield
        }),
        whole(
            "tips",
            "tips at its end, to which as many centerlines run in it",
            |one| Some(one.tips),
        ),
        number("length", LENGTH, "along it", |one: &Branch| one.length).compared(),
        number(
            "chord",
            LENGTH,
            "between its ends, straight; of VMTK's branches, between the means of its lines' ends",
            |one: &Branch| one.chord,
        ),
        number(
            "tortuosity",
            NOTHING,
            "length over chord, less 1",
            |one: &Branch| one.tortuosity,
        )
        .compared(),
        number("curvature", PER_LENGTH, "mean curvature", |one: &Branch| {
            one.curvature
        })
        .compared(),
        number(
            "torsion",
            PER_LENGTH,
            "mean torsion; above zero as right-handed helices have it",
            |one: &Branch| one.torsion,
        )
        .compared(),
        number(
            "radius_mean",
            LENGTH,
            "mean radius by length",
            |one: &Branch| one.radius.mean,
        )
        .compared(),
        number("radius_min", LENGTH, "smallest radius", |one: &Branch| {
            one.radius.min
        }),
        number("radius_max", LENGTH, "largest radius", |one: &Branch| {
            one.radius.max
        }),
        number(
            "radius_start",
            LENGTH,
            "radius at the end nearer to the root",
            |one: &Branch| one.radius.start,
        ),
        number(
            "radius_end",
            LENGTH,
            "radius at the other end",
            |one: &Branch| one.radius.end,
        ),
        number(
            "taper",
            NOTHING,
            "how much the radius shrinks per length",
            |one: &Branch| one.radius.taper,
        ),
        number(
            "volume",
            VOLUME,
            "of the balls along it (whole)",
            |one: &Branch| one.volume,
        )
        .compared(),
        number(
            "area",
            AREA,
            "lateral surface of the balls along it (whole)",
            |one: &Branch| one.area,
        ),
        whole(
            "first_node",
            "its first node in the analysis (whole)",
            |one| Some(one.nodes?[0]),
        ),
        whole(
            "last_node",
            "its last node in the analysis (whole)",
            |one| Some(one.nodes?[1]),
        ),
    ]
}
