//! From the statistics of a measured model to a stochastic L-system whose trees have them.
//!
//! ```text
//! models ─▶ one table (pooled) ─▶ table
//! table ─▶ parameters by the source's rules (rules) ─┐
//!      └─▶ parameters that fit (fit) ────────────────┴─▶ grammar ─▶ lsystem ─▶ Tree ─▶ pruned ─▶ measured, compared (difference)
//! ```
//!
//! Source: van Nielen, Verbeek and Cao, "Visualizing, Analyzing and Constructing L-system from Arborized 3D Model Using a Web
//! Application": Algorithm 1 is [`grammar`], Algorithm 2 [`pruned`]. `docs/src/abstraction.md` is the user's page.

mod by_order;
mod difference;
mod error;
pub mod exact;
mod fit;
mod grammar;
mod grow;
mod params;
mod pooled;
mod presets;
mod prune;
pub mod rules;
mod solving;
mod table;
mod told;
mod variants;

pub use by_order::{ByOrder, OfOrder, OrderDifference};
pub use difference::{Difference, OF_DEVIATIONS, OF_MEANS, differences, distance};
pub use error::AbstractionError;
pub use fit::{Candidate, Fit, FitParams, fit};
pub use grammar::{grammar, steps, text};
pub use grow::{Grower, blunt, grow};
pub use params::{ITERATIONS_MOST, ORDERS_MOST, Params, STEM_MOST};
pub use pooled::{Part, pooled};
pub use presets::{Preset, presets};
pub use prune::pruned;
pub use table::{Counts, FORMAT, MeanStd, Orders, Quantities, Table};
pub use told::Told;
pub use variants::{DRAWS, variants};

#[cfg(test)]
mod by_order_tests;
#[cfg(test)]
mod tests;
