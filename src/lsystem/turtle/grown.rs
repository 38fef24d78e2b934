//! Modules that are only partly grown: what they measure is a part of what they say.

use super::super::error::DeriveError;
use super::super::grammar::Grammar;
use super::super::names::Symbol;
use super::super::string::Module;
use super::TurtleParams;
use super::action::{Action, Axis, Half};
use super::canvas::Canvas;
use super::walk::Turtle;

/// How far a module is grown: what it measures is `part` of what it says, plus `from`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grown {
    part: f64,
    from: f64,
}

impl Grown {
    pub(crate) const WHOLE: Self = Self {
        part: 1.0,
        from: 0.0,
    };

    /// A new module at this value of its curve.
    pub(crate) fn new(part: f64) -> Self {
        Self { part, from: 0.0 }
    }

    /// One that goes from a length to its own.
    pub(crate) fn from(length: f64, part: f64) -> Self {
        let from = length * (1.0 - part);
        Self { part, from }
    }

    fn of(self, value: f64) -> f64 {
        value * self.part + self.from
    }
}

/// The length that a module draws, metres; none where it draws no segment, or one that the dictionary measures.
pub(crate) fn length_of(grammar: &Grammar, symbol: Symbol, parameters: &[f64]) -> Option<f64> {
    let draws = matches!(grammar.name(symbol), "F" | "G") && !is_index(grammar, symbol);
    let length = parameters.first().copied();
    draws.then(|| length.unwrap_or(TurtleParams::default().length))
}

/// Whether a module's parameter says which segment of a shape it draws.
pub(crate) fn is_index(grammar: &Grammar, symbol: Symbol) -> bool {
    let shape = grammar.shape_of.get(usize::from(symbol));
    shape.is_some_and(Option::is_some)
}

impl<C: Canvas> Turtle<'_, C> {
    /// [`Turtle::step`] of a module that is partly grown. What has no size (brackets, colours, `$`) is there at once.
    pub(super) fn step_grown(
        &mut self,
        module: Module<'_>,
        grown: Grown,
    ) -> Result<(), DeriveError> {
        if grown == Grown::WHOLE {
            return self.step(module);
        }
        let first = module.parameters.first().copied();
        let measured = match self.action(module.symbol) {
            Action::Draw | Action::DrawWithin | Action::Move | Action::MoveWithin => {
                grown.of(first.unwrap_or(self.params.length * self.pen.length_scale))
            }
            Action::Turn(turn) => {
                grown.of(first.unwrap_or(turn.default_degrees * self.pen.angle_scale))
            }
            Action::TurnAround => {
                let half = Half::of_degrees(grown.of(180.0));
                self.pen.change(|stance| stance.turn_about(Axis::Up, half));
                return Ok(());
            }
            Action::Width => {
                let narrowed = 1.0 + (self.params.narrow - 1.0) * grown.part;
                first.map_or(self.pen.width * narrowed, |width| grown.of(width))
            }
            Action::Sphere => grown.of(first.unwrap_or(self.pen.width / 2.0)),
            Action::Surface | Action::Place(_) => grown.of(first.unwrap_or(1.0)),
            Action::Tropism => grown.of(first.unwrap_or(0.0)),
            Action::Follow(_) => {
                self.shape_scale = grown.part;
                let drawn = self.step(module);
                self.shape_scale = 1.0;
                return drawn;
            }
            _ => return self.step(module),
        };
        self.step(Module {
            parameters: &[measured],
            ..module
        })
    }
}
