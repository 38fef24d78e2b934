//! Grammar text → checked rules → derivation on packed modules → turtle → [`crate::tree::Tree`].
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use ramus::lsystem::{Grammar, Limits, TurtleParams, interpret};
//!
//! let grammar = Grammar::parse("axiom A(0) B\nA(x) > B -> A(x) A(x+1)\n", "growth.lsys").unwrap();
//! let cancel = AtomicBool::new(false);
//! let string = grammar.derive(3, &Limits::default(), &cancel).unwrap();
//! assert_eq!(string.to_text(&grammar), "A(0)A(1)A(2)A(3)B");
//! let tree = interpret(&grammar, &string, &TurtleParams::default(), &cancel).unwrap();
//! assert_eq!(tree.parent.len(), 1); // nothing drawn: A and B are no symbols of the turtle
//! ```
//!
//! The language is described in `docs/src/language.md`. Data flow: `source` cuts the text into statements, `parse` and `rules` read them into
//! a [`Grammar`] (names in `names`, expressions in `expression`), `derive` rewrites a [`ModuleString`] with the help of `context` and `neighbours` (`rewrite` and `fill` all of it, with `choice` for each module, `chances` where no more than a draw decides, or `batch` and `lanes` for many at once, `blocks` what is alike once, `active` what may change, `rests` what cannot; `record` keeps which production did it, `explain` tells it; `history` keeps the strings, `edit` says which of them an edit changes),
//! `turtle` draws it and answers what `query` asks, `report` says what `ramus derive` prints, `format` lays the text out.

mod active;
mod batch;
mod blocks;
mod chances;
mod choice;
mod choices;
mod clearance;
mod code;
mod column;
mod context;
mod derive;
pub mod dialect;
mod edit;
mod endless;
mod error;
mod explain;
mod expression;
mod fill;
mod format;
mod grammar;
mod growing;
mod growth;
mod history;
mod include;
mod lanes;
mod look;
mod names;
mod neighbours;
mod number;
mod output;
mod parse;
mod query;
mod random;
mod record;
pub mod report;
mod rests;
mod rewrite;
mod rules;
mod shape;
mod source;
mod string;
pub mod turtle;
mod unwritten;

pub use derive::Limits;
pub use error::{DeriveError, DeriveProblem, GrammarError, GrammarErrors, Limit, ValueProblem};
pub use explain::{Chance, ExplainParams, Explanation, Fate, ProductionUse, Seen};
pub use format::{FormatError, format};
pub use grammar::Grammar;
pub use growing::Growing;
pub use history::History;
pub use look::bearing;
pub use names::Symbol;
pub use record::Recorded;
pub use shape::shape_frames;
pub use string::{Module, ModuleString};
pub use turtle::{DrawingCanvas, TurtleParams, draw, draw_on, interpret};
pub use unwritten::Unwritten;
