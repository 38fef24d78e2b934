//! Query modules: `?P ?H ?U ?L`, into whose parameters the turtle writes where it stands and how it is turned (Prusinkiewicz, James and
//! Měch 1994, "Synthetic topiary"), and `?S`, which is told how much of the sky's light reaches it through the leaves of all (Měch and Prusinkiewicz
//! 1996, "Visual models of plants interacting with their environment"; the light is that of [`Light`]), and `?C`, which is told how far other wood is
//! ([`Wood`]).
//!
//! After each step the turtle goes over the string, as it would be drawn, and the answers are written before anybody reads it. So
//! a string with queries is derived step by step, never by blocks.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::clearance::{Kin, Wood};
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
    /// How far other wood is; the second parameter is how far it looks, metres.
    Clearance,
}

impl Query {
    pub(super) fn of(name: &str) -> Option<Self> {
        match name {
            "?P" => Some(Self::Position),
            "?H" => Some(Self::Heading),
            "?U" => Some(Self::Up),
            "?L" => Some(Self::Left),
            "?S" => Some(Self::Shade),
            "?C" => Some(Self::Clearance),
            _ => None,
        }
    }

    fn answer(self, pen: &Pen) -> DVec3 {
        match self {
            Self::Position | Self::Shade | Self::Clearance => pen.position,
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
    /// Where some ask how far other wood is: what is drawn, and whom each does not mean.
    wood: Option<(Wood, Vec<Kin>)>,
}

impl Answers<'_> {
    fn too_far(&self, by: Drawn) -> DeriveError {
        let module = self.grammar.name(by.symbol).to_owned();
        let position = by.position;
        DeriveProblem::TooFar { position, module }.into()
    }
}

impl Canvas for Answers<'_> {
    fn root(&mut self, pen: &Pen, _: Drawn, _: f32) -> Result<u32, DeriveError> {
        Ok(self.wood.as_mut().map_or(0, |(wood, _)| wood.root(pen)))
    }

    fn segment(&mut self, pen: &Pen, by: Drawn, end: DVec3, _: f32) -> Result<u32, DeriveError> {
        let Some((wood, _)) = &mut self.wood else {
            return Ok(0);
        };
        wood.segment(pen, end).ok_or_else(|| self.too_far(by))
    }

    fn query(&mut self, pen: &Pen, by: Drawn) -> Result<(), DeriveError> {
        let name = self.grammar.name(by.symbol);
        if let Some(query) = Query::of(name) {
            let answer = query.answer(pen);
            if !answer.is_finite() {
                return Err(self.too_far(by));
            }
            self.answers.push(answer);
            if let Some((wood, kin)) = &mut self.wood
                && query == Query::Clearance
            {
                kin.push(wood.kin(pen));
            }
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
    let asks = |what: fn(Query) -> bool| {
        let query = |symbol: Symbol| Query::of(grammar.name(symbol));
        string
            .iter()
            .filter_map(|module| query(module.symbol))
            .any(what)
    };
    if !grammar.has_queries || !asks(|_| true) {
        return Ok(string);
    }
    let params = TurtleParams {
        limits: *limits,
        ..TurtleParams::default()
    };
    let wood = asks(|query| query == Query::Clearance).then(Default::default);
    let canvas = |_: &TurtleParams| Answers {
        grammar,
        answers: Vec::new(),
        wood,
    };
    let Answers { answers, wood, .. } = draw_on(grammar, &string, &params, cancel, canvas)?;
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
    let mut clearances = match wood {
        Some((wood, kin)) => clearances(&string, asked.iter().zip(&answers), wood, kin, cancel)?,
        None => Vec::new(),
    }
    .into_iter();
    for ((query, place), answer) in asked.into_iter().zip(answers) {
        let Some(parameters) = string.parameters.get_mut(place) else {
            continue;
        };
        let values = match query {
            Query::Shade => {
                let light = light.as_ref();
                let told = light.map_or(1.0, |light| light.at(answer.as_vec3()));
                vec![f64::from(told)]
            }
            Query::Clearance => clearances.next().into_iter().collect(),
            _ => answer.to_array().to_vec(),
        };
        for (parameter, value) in parameters.iter_mut().zip(values) {
            *parameter = value;
        }
    }
    Ok(string)
}

/// The second parameter of a query.
fn second(string: &ModuleString, place: &Range<usize>) -> f64 {
    let number = string.parameters.get(place.start + 1);
    number.copied().unwrap_or(0.0)
}

/// How far other wood is from each `?C`.
fn clearances<'a>(
    string: &ModuleString,
    asked: impl Iterator<Item = (&'a (Query, Range<usize>), &'a DVec3)>,
    wood: Wood,
    kin: Vec<Kin>,
    cancel: &AtomicBool,
) -> Result<Vec<f64>, DeriveError> {
    let those = asked.filter(|((query, _), _)| *query == Query::Clearance);
    let asked: Vec<_> = those
        .zip(kin)
        .map(|(((_, place), at), kin)| (*at, kin, second(string, place)))
        .collect();
    let step = string.iter().map(|module| module.birth).max();
    let cancelled = DeriveProblem::Cancelled {
        step: step.unwrap_or(0),
    };
    wood.clearances(&asked, cancel)
        .ok_or_else(|| cancelled.into())
}

/// The light among the leaves that stand at all `?S`.
fn light<'a>(
    string: &ModuleString,
    asked: impl Iterator<Item = (&'a (Query, Range<usize>), &'a DVec3)>,
) -> Option<Light> {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "areas are as rough as that"
    )]
    let leaves: Vec<_> = asked
        .filter(|((query, _), _)| *query == Query::Shade)
        .map(|((_, place), at)| (at.as_vec3(), second(string, place) as f32))
        .collect();
    Light::among(&leaves)
}
