//! What is told of models and of branches, measure by measure: each is a column, with its unit and its meaning.
//!
//! Names are those of the analysis (`ramus-analysis/1`), made flat: `branch_length.mean` is `branch_length_mean`.

use super::told::{Branch, Facts, Junction, Measured, Spread};
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
            },
            compared: false,
            of: Box::new(of),
        }
    }

    fn compared(mut self) -> Self {
        self.compared = true;
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

fn number(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    of: fn(&Facts) -> Option<f64>,
) -> Measure<Facts> {
    Measure::new(name, Kind::Real, unit, meaning, move |facts| {
        real(of(facts))
    })
}

/// Five columns of a spread; what is compared of it is named.
fn spread_of(
    name: &str,
    unit: &'static str,
    meaning: &str,
    compared: &[&str],
    of: fn(&Facts) -> Spread,
) -> Vec<Measure<Facts>> {
    let n = Measure::new(
        format!("{name}_n"),
        Kind::Whole,
        NOTHING,
        format!("{meaning}: how many"),
        move |facts: &Facts| Cell::whole(of(facts).n),
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
            move |facts: &Facts| {
                let spread = of(facts);
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
    all.extend([
        count(
            "centerlines",
            "ways from the source to a target, or from the root to a tip",
            |facts| facts.counts.centerlines,
        ),
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
        count(
            "loops_left_out",
            "loops of the surface, of which the tree has one side",
            |facts| facts.counts.loops_left_out,
        ),
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
    ]);
    all.extend(from_table());
    all.extend([
        Measure::new(
            "strahler_max",
            Kind::Whole,
            NOTHING,
            "highest of Strahler's orders",
            |facts: &Facts| {
                let highest = facts.branches.iter().map(|branch| branch.strahler).max();
                Cell::or_empty(highest, |order| Cell::Whole(order.into()))
            },
        )
        .compared(),
        number(
            "branching_ratio",
            NOTHING,
            "branches of one of Strahler's orders to those of the next",
            |facts| facts.orders.branching_ratio,
        )
        .compared(),
        number(
            "length_ratio",
            NOTHING,
            "length of one of Strahler's orders to that of the one before",
            |facts| facts.orders.length_ratio,
        )
        .compared(),
        number(
            "radius_ratio",
            NOTHING,
            "radius of one of Strahler's orders to that of the one before",
            |facts| facts.orders.radius_ratio,
        )
        .compared(),
    ]);
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
        count("unreached", "targets that no way leads to", |facts| {
            facts.endpoints.unreached()
        }),
    ]
}

/// The table of the source papers.
fn from_table() -> Vec<Measure<Facts>> {
    fn table(facts: &Facts) -> &Measured {
        &facts.table
    }
    let mut all = spread_of(
        "branch_length",
        LENGTH,
        "lengths of branches",
        &["mean", "std"],
        |facts| table(facts).branch_length,
    );
    all.extend(spread_of(
        "point_radius",
        LENGTH,
        "radii at equally spaced points",
        &["mean", "std"],
        |facts| table(facts).point_radius,
    ));
    all.extend(spread_of(
        "centerline_length",
        LENGTH,
        "ways from root to tip",
        &["mean", "max"],
        |facts| table(facts).centerline_length,
    ));
    all.extend([
        number(
            "stem_length",
            LENGTH,
            "from the root to the first junction",
            |facts| table(facts).stem_length,
        )
        .compared(),
        number(
            "stem_iterations",
            NOTHING,
            "the same in mean branch lengths",
            |facts| table(facts).stem_iterations,
        ),
        number(
            "iterations_mean",
            NOTHING,
            "ways without the stem in mean branch lengths: mean",
            |facts| table(facts).iterations.mean,
        )
        .compared(),
        number(
            "iterations_std",
            NOTHING,
            "ways without the stem in mean branch lengths: standard deviation",
            |facts| table(facts).iterations.std,
        ),
    ]);
    all.extend(spread_of(
        "bifurcation_angle_deg",
        DEGREES,
        "angles between daughters",
        &["mean", "std"],
        |facts| table(facts).bifurcation_angle_deg,
    ));
    all.extend([
        number(
            "upwards_angle_deg_mean",
            DEGREES,
            "turns of branches towards the stem's direction: mean",
            |facts| table(facts).upwards_angle_deg.mean,
        )
        .compared(),
        number(
            "upwards_angle_deg_std",
            DEGREES,
            "turns of branches towards the stem's direction: standard deviation",
            |facts| table(facts).upwards_angle_deg.std,
        ),
    ]);
    all.extend(spread_of(
        "curvature",
        PER_LENGTH,
        "mean curvatures of branches",
        &["mean"],
        |facts| table(facts).curvature,
    ));
    all.extend(spread_of(
        "torsion",
        PER_LENGTH,
        "mean torsions of branches",
        &["mean"],
        |facts| table(facts).torsion,
    ));
    all.extend(spread_of(
        "tortuosity",
        NOTHING,
        "length over chord, less 1, of branches",
        &["mean"],
        |facts| table(facts).tortuosity,
    ));
    all
}

/// What is told of a branch.
pub(super) fn of_branches() -> Vec<Measure<Branch>> {
    fn whole(name: &'static str, meaning: &'static str, of: fn(&Branch) -> u32) -> Measure<Branch> {
        Measure::new(name, Kind::Whole, NOTHING, meaning, move |one| {
            Cell::Whole(of(one).into())
        })
    }
    fn number(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        of: fn(&Branch) -> Option<f64>,
    ) -> Measure<Branch> {
        Measure::new(name, Kind::Real, unit, meaning, move |one| real(of(one)))
    }
    vec![
        Measure::new(
            "id",
            Kind::Whole,
            NOTHING,
            "number within its model",
            |one: &Branch| Cell::whole(one.id),
        ),
        Measure::new(
            "parent",
            Kind::Whole,
            NOTHING,
            "number of the branch that it grows from",
            |one: &Branch| Cell::or_empty(one.parent, Cell::whole),
        ),
        whole("order", "generation, 0 at the root", |one| one.order),
        whole("strahler", "Strahler's order", |one| one.strahler),
        whole("horsfield", "Horsfield's order", |one| one.horsfield),
        whole("tips", "tips at its end", |one| one.tips),
        number("length", LENGTH, "along it", |one| one.length).compared(),
        number("chord", LENGTH, "between its ends, straight", |one| {
            one.chord
        }),
        number("tortuosity", NOTHING, "length over chord, less 1", |one| {
            one.tortuosity
        })
        .compared(),
        number("curvature", PER_LENGTH, "mean curvature", |one| {
            one.curvature
        })
        .compared(),
        number(
            "torsion",
            PER_LENGTH,
            "mean torsion; above zero as right-handed helices have it",
            |one| one.torsion,
        )
        .compared(),
        number("radius_mean", LENGTH, "mean radius by length", |one| {
            one.radius.mean
        })
        .compared(),
        number("radius_min", LENGTH, "smallest radius", |one| {
            one.radius.min
        }),
        number("radius_max", LENGTH, "largest radius", |one| one.radius.max),
        number(
            "radius_start",
            LENGTH,
            "radius at the end nearer to the root",
            |one| one.radius.start,
        ),
        number("radius_end", LENGTH, "radius at the other end", |one| {
            one.radius.end
        }),
        number(
            "taper",
            NOTHING,
            "how much the radius shrinks per length",
            |one| one.radius.taper,
        ),
        number("volume", VOLUME, "of the balls along it", |one| one.volume).compared(),
        number(
            "area",
            AREA,
            "lateral surface of the balls along it",
            |one| one.area,
        ),
        whole("first_node", "its first node in the analysis", |one| {
            one.nodes[0]
        }),
        whole("last_node", "its last node in the analysis", |one| {
            one.nodes[1]
        }),
    ]
}
