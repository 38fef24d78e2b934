//! Query modules: `?P ?H ?U ?L`, into whose parameters the turtle writes where it stands and how it is turned (Prusinkiewicz, James and
//! Měch 1994, "Synthetic topiary"), and `?S`, which is told how much of the sky's light reaches it through the leaves of all (Měch and Prusinkiewicz
//! 1996, "Visual models of plants interacting with their environment"; the light is that of [`Light`]).
//!
//! After each step the turtle goes over the string, as it would be drawn, and the answers are written before anybody reads it. So
//! a string with queries is derived step by step, never by blocks.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::derive::Limits;
use super::error::{DeriveError, DeriveProblem};
use super::grammar::Grammar;
use super::names::Symbol;
use super::string::ModuleString;
use super::turtle::{Canvas, Drawn, Pen, TurtleParams, draw_on};
use crate::tree::foliage::light::Light;

/// What a query asks for, by the module's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Query {
    Position,
    Heading,
    Up,
    Left,
    /// The light among all of its kind; the second parameter is the area of leaves, square metres.
    Shade,
}

impl Query {
    pub(super) fn of(name: &str) -> Option<Self> {
        match name {
            "?P" => Some(Self::Position),
            "?H" => Some(Self::Heading),
            "?U" => Some(Self::Up),
            "?L" => Some(Self::Left),
            "?S" => Some(Self::Shade),
            _ => None,
        }
    }

    fn answer(self, pen: &Pen) -> DVec3 {
        match self {
            Self::Position | Self::Shade => pen.position,
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
    let mut asked = Vec::with_capacity(answers.len());
    let mut offset = 0;
    for module in string.iter() {
        if let Some(query) = Query::of(grammar.name(module.symbol)) {
            asked.push((query, offset..offset + module.parameters.len()));
        }
        offset += module.parameters.len();
    }
    let light = light(&string, asked.iter().zip(&answers));
    for ((query, place), answer) in asked.into_iter().zip(answers) {
        let Some(parameters) = string.parameters.get_mut(place) else {
            continue;
        };
        if query == Query::Shade {
            let told = light
                .as_ref()
                .map_or(1.0, |light| light.at(answer.as_vec3()));
            parameters
                .iter_mut()
                .take(1)
                .for_each(|parameter| *parameter = f64::from(told));
            continue;
        }
        for (parameter, value) in parameters.iter_mut().zip(answer.to_array()) {
            *parameter = value;
        }
    }
    Ok(string)
}

/// The light among the leaves that stand at all `?S`.
fn light<'a>(
    string: &ModuleString,
    asked: impl Iterator<Item = (&'a (Query, Range<usize>), &'a DVec3)>,
) -> Option<Light> {
    let area = |place: &Range<usize>| {
        string
            .parameters
            .get(place.start + 1)
            .copied()
            .unwrap_or(0.0)
    };
    #[expect(
        clippy::cast_possible_truncation,
        reason = "areas are as rough as that"
    )]
    let leaves: Vec<_> = asked
        .filter(|((query, _), _)| *query == Query::Shade)
        .map(|((_, place), at)| (at.as_vec3(), area(place) as f32))
        .collect();
    Light::among(&leaves)
}
