//! What each symbol makes the turtle do, known before the first module is read.

use super::super::grammar::Grammar;
use super::super::names::Symbol;
use super::TurtleParams;

/// One of the turtle's own axes. The frame's own X is −L, its Y the heading H, its Z is U.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    X,
    Heading,
    Up,
}

/// Half the angle of a turn: sine and cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Half {
    pub(super) sin: f64,
    pub(super) cos: f64,
}

impl Half {
    pub(super) fn of_degrees(degrees: f64) -> Self {
        let (sin, cos) = (degrees.to_radians() * 0.5).sin_cos();
        Self { sin, cos }
    }
}

/// A symbol's turn, with the last angle that it turned by: strings say the same few angles again and again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turn {
    pub(super) axis: Axis,
    sign: f64,
    /// Where the module has no parameter.
    default: Half,
    last_degrees: f64,
    last: Half,
    /// Degrees where the module has no parameter.
    pub(super) default_degrees: f64,
}

impl Turn {
    fn new(axis: Axis, sign: f64, default: f64) -> Self {
        let default_half = Half::of_degrees(sign * default);
        Self {
            axis,
            sign,
            default: default_half,
            last_degrees: default,
            last: default_half,
            default_degrees: default,
        }
    }

    /// Half of the turn by so many degrees.
    #[expect(
        clippy::float_cmp,
        reason = "the very same angle has the same sine; another is worked out"
    )]
    #[inline(always)]
    pub(super) fn half(&mut self, degrees: Option<f64>) -> Half {
        let Some(degrees) = degrees else {
            return self.default;
        };
        if degrees != self.last_degrees {
            self.last = Half::of_degrees(self.sign * degrees);
            self.last_degrees = degrees;
        }
        self.last
    }
}

/// What a symbol makes the turtle do. Its tag is a number of its own, which is read at once.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
pub(super) enum Action {
    Nothing,
    /// Forward, drawing; an outline gets a vertex.
    Draw,
    /// The same, and no vertex.
    DrawWithin,
    /// Forward without drawing; an outline gets a vertex.
    Move,
    /// The same, and no vertex.
    MoveWithin,
    Turn(Turn),
    TurnAround,
    Level,
    Width,
    /// Multiplies the width,
    ScaleWidth,
    /// the step without a parameter,
    ScaleLength,
    /// or the turn without one.
    ScaleAngle,
    Push,
    Pop,
    BeginPolygon,
    Vertex,
    EndPolygon,
    NextColour,
    LastColour,
    Material,
    Sphere,
    /// What the name behind a `~` names, where it is no shape.
    Surface,
    Query,
    BeginCylinder,
    EndCylinder,
    Tropism,
    /// Follow the shape of this index,
    Follow(u16),
    /// or draw it and come back.
    Place(u16),
}

/// The actions by symbol.
pub(super) fn actions(grammar: &Grammar, params: &TurtleParams) -> Vec<Action> {
    let angle = grammar.angle.unwrap_or(params.angle);
    let symbols = 0..u16::try_from(grammar.names.symbols().len()).unwrap_or(u16::MAX);
    symbols.map(|s| action(grammar, s, angle)).collect()
}

/// Whether any symbol draws more than a skeleton: organs, colours, materials, cylinders.
pub(super) fn draws_organs(grammar: &Grammar, params: &TurtleParams) -> bool {
    let more = |action: &Action| {
        matches!(
            action,
            Action::BeginPolygon
                | Action::NextColour
                | Action::LastColour
                | Action::Material
                | Action::Sphere
                | Action::Surface
                | Action::BeginCylinder
        )
    };
    actions(grammar, params).iter().any(more)
}

fn action(grammar: &Grammar, symbol: Symbol, angle: f64) -> Action {
    if let Some(shape) = grammar.shape_of.get(usize::from(symbol)).copied().flatten() {
        return Action::Follow(shape);
    }
    let turn = |axis, sign| Action::Turn(Turn::new(axis, sign, angle));
    // Right-handed turns: X is −L, so a positive turn about L is a negative one about X.
    match grammar.name(symbol) {
        "F" => Action::Draw,
        "G" => Action::DrawWithin,
        "f" => Action::Move,
        "g" => Action::MoveWithin,
        "+" => turn(Axis::Up, 1.0),
        "-" => turn(Axis::Up, -1.0),
        "&" => turn(Axis::X, -1.0),
        "^" => turn(Axis::X, 1.0),
        "/" => turn(Axis::Heading, 1.0),
        "\\" => turn(Axis::Heading, -1.0),
        "|" => Action::TurnAround,
        "$" => Action::Level,
        "!" => Action::Width,
        "@w" => Action::ScaleWidth,
        "@l" => Action::ScaleLength,
        "@a" => Action::ScaleAngle,
        "[" => Action::Push,
        "]" => Action::Pop,
        "{" => Action::BeginPolygon,
        "." => Action::Vertex,
        "}" => Action::EndPolygon,
        "'" => Action::NextColour,
        "," => Action::LastColour,
        ";" => Action::Material,
        "@O" => Action::Sphere,
        "@Gs" => Action::BeginCylinder,
        "@Ge" => Action::EndCylinder,
        "T" => Action::Tropism,
        "?P" | "?H" | "?U" | "?L" | "?S" | "?C" => Action::Query,
        name => name.strip_prefix('~').map_or(Action::Nothing, |placed| {
            let shape = grammar.shapes.iter().position(|s| s.name == placed);
            let index = shape.and_then(|index| u16::try_from(index).ok());
            index.map_or(Action::Surface, Action::Place)
        }),
    }
}
