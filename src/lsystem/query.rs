//! Query modules: `?P ?H ?U ?L`, into whose parameters the turtle writes where it stands and how it is turned (Prusinkiewicz, James and
//! Měch 1994, "Synthetic topiary").
//!
//! After each step the turtle goes over the string, as it would be drawn, and the answers are written before anybody reads it. So
//! a string with queries is derived step by step, never by blocks.

use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::derive::Limits;
use super::error::{DeriveError, DeriveProblem};
use super::grammar::Grammar;
use super::names::Symbol;
use super::string::ModuleString;
use super::turtle::{Canvas, Drawn, Pen, TurtleParams, draw_on};

/// What a query asks for, by the module's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Query {
    Position,
    Heading,
    Up,
    Left,
}

impl Query {
    pub(super) fn of(name: &str) -> Option<Self> {
        match name {
            "?P" => Some(Self::Position),
            "?H" => Some(Self::Heading),
            "?U" => Some(Self::Up),
            "?L" => Some(Self::Left),
            _ => None,
        }
    }

    fn answer(self, pen: &Pen) -> DVec3 {
        match self {
            Self::Position => pen.position,
            Self::Heading => pen.heading(),
            Self::Up => pen.up(),
            Self::Left => pen.left(),
        }
    }
}

/// Numbers of parameters that a query may have: x and y, or x, y and z.
pub(super) const ANSWERS: std::ops::RangeInclusive<usize> = 2..=3;

/// The canvas that draws nothing and takes down the answers.
struct Answers<'a> {
    grammar: &'a Grammar,
    answers: Vec<DVec3>,
}

impl Canvas for Answers<'_> {
    fn root(&mut self, _: &Pen, _: Drawn, _: f32) -> Result<u32, DeriveError> {
        Ok(0)
    }

    fn segment(&mut self, _: &Pen, _: Drawn, _: DVec3, _: f32) -> Result<u32, DeriveError> {
        Ok(0)
    }

    fn query(&mut self, pen: &Pen, by: Drawn) -> Result<(), DeriveError> {
        let name = self.grammar.name(by.symbol);
        if let Some(query) = Query::of(name) {
            let answer = query.answer(pen);
            if !answer.is_finite() {
                let (position, module) = (by.position, name.to_owned());
                return Err(DeriveProblem::TooFar { position, module }.into());
            }
            self.answers.push(answer);
        }
        Ok(())
    }
}

/// The string with its queries answered.
pub(super) fn answered(
    grammar: &Grammar,
    mut string: ModuleString,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    let is_query = |symbol: Symbol| Query::of(grammar.name(symbol)).is_some();
    if !grammar.has_queries || !string.iter().any(|module| is_query(module.symbol)) {
        return Ok(string);
    }
    let params = TurtleParams {
        limits: *limits,
        ..TurtleParams::default()
    };
    let answers = Vec::new();
    let canvas = |_: &TurtleParams| Answers { grammar, answers };
    let answers = draw_on(grammar, &string, &params, cancel, canvas)?.answers;
    // The interpretation neither adds queries nor takes any away, so they come in the same order.
    let mut places = Vec::with_capacity(answers.len());
    let mut offset = 0;
    for module in string.iter() {
        if is_query(module.symbol) {
            places.push(offset..offset + module.parameters.len());
        }
        offset += module.parameters.len();
    }
    for (place, answer) in places.into_iter().zip(answers) {
        if let Some(parameters) = string.parameters.get_mut(place) {
            for (parameter, value) in parameters.iter_mut().zip(answer.to_array()) {
                *parameter = value;
            }
        }
    }
    Ok(string)
}
