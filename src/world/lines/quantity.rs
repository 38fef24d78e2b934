//! What is known of branches in numbers: what panels list, and lines are coloured by.

use serde::{Deserialize, Serialize};

use crate::centerline::analysis::BranchFacts;
use crate::mesh::colour::Ramp;

/// What is known of each branch, and of each place along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// The radius at each place.
    RadiusHere,
    /// Length of a branch.
    Length,
    /// Its mean radius.
    Radius,
    /// Length over chord, less 1.
    Tortuosity,
    /// Mean curvature.
    Curvature,
    /// Mean torsion.
    Torsion,
    /// How much the radius shrinks per length.
    Taper,
    /// Of the balls along it.
    Volume,
    /// Its lateral surface.
    Area,
    /// Generation.
    Order,
    /// Strahler's order.
    Strahler,
    /// Horsfield's order.
    Horsfield,
    /// Tips at its end.
    Tips,
}

/// What a number of a quantity counts, in the model's unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// Nothing.
    Number,
    /// The unit to this power.
    Unit(i8),
}

impl Quantity {
    /// All of them, as panels list them.
    pub const ALL: [Self; 13] = [
        Self::RadiusHere,
        Self::Length,
        Self::Radius,
        Self::Tortuosity,
        Self::Curvature,
        Self::Torsion,
        Self::Taper,
        Self::Volume,
        Self::Area,
        Self::Order,
        Self::Strahler,
        Self::Horsfield,
        Self::Tips,
    ];

    /// Of a branch; NaN where it has none.
    #[must_use]
    pub fn of(self, branch: &BranchFacts) -> f64 {
        match self {
            Self::RadiusHere | Self::Radius => branch.radius.along.mean,
            Self::Length => branch.length,
            Self::Tortuosity => branch.tortuosity,
            Self::Curvature => branch.curvature,
            Self::Torsion => branch.torsion.unwrap_or(f64::NAN),
            Self::Taper => branch.radius.taper,
            Self::Volume => branch.volume,
            Self::Area => branch.area,
            Self::Order => branch.order.into(),
            Self::Strahler => branch.strahler.into(),
            Self::Horsfield => branch.horsfield.into(),
            Self::Tips => branch.tips.into(),
        }
    }

    /// What its numbers count.
    #[must_use]
    pub fn dimension(self) -> Dimension {
        match self {
            Self::RadiusHere | Self::Length | Self::Radius => Dimension::Unit(1),
            Self::Curvature | Self::Torsion => Dimension::Unit(-1),
            Self::Area => Dimension::Unit(2),
            Self::Volume => Dimension::Unit(3),
            _ => Dimension::Number,
        }
    }

    /// The colours of its numbers.
    #[must_use]
    pub fn ramp(self) -> Ramp {
        match self {
            Self::Torsion | Self::Taper => Ramp::AboutZero,
            _ => Ramp::Rising,
        }
    }
}
