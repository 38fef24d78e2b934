//! Query modules: `?P ?H ?U ?L`, into whose parameters the turtle writes where it stands and how it is turned (Prusinkiewicz, James and
//! Měch 1994, "Synthetic topiary"), and `?S`, which is told how much of the sky's light reaches it through the leaves of all (Měch and Prusinkiewicz
//! 1996, "Visual models of plants interacting with their environment"; the light is that of [`Light`]), and `?C`, which is told how far other wood is
//! ([`Wood`]).
//!
//! After each step the turtle goes over the string, as it would be drawn, and the answers are written before anybody reads it. So
//! a string with queries is derived step by step, never by blocks. What the turtle read in the step before it need not read again ([`Trail`]).

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::clearance::{Kin, Wood};
use super::column::{Cell, for_width};
use super::derive::Limits;
use super::error::{DeriveError, DeriveProblem};
use super::grammar::Grammar;
use super::string::{ModuleString, arity_of};
use super::turtle::{Again, Canvas, Drawn, Pen, Trail, TurtleParams, draw_on};
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
    /// What symbols ask for.
    queries: &'a [Option<Query>],
    answers: Vec<DVec3>,
    /// Where some may ask how far other wood is: what is drawn, and whom each does not mean.
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
        let query = self.queries.get(usize::from(by.symbol)).copied().flatten();
        let Some(query) = query else {
            return Ok(());
        };
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
        Ok(())
    }
}

impl Again for Answers<'_> {
    fn drawn(&self) -> u32 {
        self.wood.as_ref().map_or(0, |(wood, _)| wood.drawn())
    }

    fn again(&mut self, drawn: Range<u32>) -> bool {
        let wood = self.wood.as_mut();
        wood.is_none_or(|(wood, _)| wood.again(drawn))
    }
}

/// What is kept from the answers of one step for those of the next.
#[derive(Default)]
pub(super) struct Memory {
    trail: Trail,
    wood: Wood,
}

impl Memory {
    /// Memory that is worth filling: several steps will be answered.
    pub(super) fn of_several() -> Self {
        Self {
            trail: Trail::Fresh,
            wood: Wood::default(),
        }
    }
}

/// A query of a string: what it asks for, and where its parameters are.
type Asked = (Query, Range<usize>);

/// The queries of a string.
fn asked<S: Cell>(symbols: &[S], arity: &[u8], queries: &[Option<Query>]) -> Vec<Asked> {
    let mut asked = Vec::new();
    let mut offset = 0;
    for symbol in symbols {
        let own = offset..offset + arity_of(arity, symbol.index());
        offset = own.end;
        if let Some(query) = queries.get(symbol.index()).copied().flatten() {
            asked.push((query, own));
        }
    }
    asked
}

/// The string with its queries answered.
pub(super) fn answered(
    grammar: &Grammar,
    mut string: ModuleString,
    memory: &mut Memory,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<ModuleString, DeriveError> {
    if !grammar.has_queries {
        return Ok(string);
    }
    let symbols = (0..).take(grammar.arity.len());
    let queries: Vec<Option<Query>> = symbols.map(|s| Query::of(grammar.name(s))).collect();
    let asked = for_width!(&string.symbols, symbols => asked(symbols, &string.arity, &queries));
    if asked.is_empty() {
        return Ok(string);
    }
    let Answers { answers, wood, .. } = read(grammar, &string, &queries, memory, limits, cancel)?;
    // The interpretation neither adds queries nor takes any away, so they come in the same order.
    let mut light = light(&string, asked.iter().zip(&answers)).into_iter();
    let mut clearances = Vec::new();
    if let Some((mut wood, kin)) = wood {
        clearances = self::clearances(&string, asked.iter().zip(&answers), &mut wood, kin, cancel)?;
        memory.wood = wood;
    }
    let mut clearances = clearances.into_iter();
    for ((query, place), answer) in asked.into_iter().zip(answers) {
        let Some(parameters) = string.parameters.get_mut(place) else {
            continue;
        };
        let alone = match query {
            Query::Shade => light.next().map(f64::from),
            Query::Clearance => clearances.next(),
            _ => {
                let values = answer.to_array();
                parameters.iter_mut().zip(values).for_each(|(p, v)| *p = v);
                continue;
            }
        };
        if let (Some(parameter), Some(value)) = (parameters.first_mut(), alone) {
            *parameter = value;
        }
    }
    Ok(string)
}

/// Has the turtle go over a string: on the trail of the step before, else from the beginning.
fn read<'a>(
    grammar: &'a Grammar,
    string: &ModuleString,
    queries: &'a [Option<Query>],
    memory: &mut Memory,
    limits: &Limits,
    cancel: &AtomicBool,
) -> Result<Answers<'a>, DeriveError> {
    let params = TurtleParams {
        limits: *limits,
        ..TurtleParams::default()
    };
    let looks_for_wood = queries.contains(&Some(Query::Clearance));
    let canvas = |wood: Wood| Answers {
        grammar,
        queries,
        answers: Vec::new(),
        wood: looks_for_wood.then(|| (wood, Vec::new())),
    };
    let mut wood = std::mem::take(&mut memory.wood);
    wood.begin_anew();
    let followed = memory
        .trail
        .follow(grammar, string, &params, cancel, canvas(wood));
    match followed {
        Some(answers) => Ok(answers),
        None => draw_on(
            grammar,
            string,
            &params,
            cancel,
            |_| canvas(Wood::default()),
        ),
    }
}

/// The second parameter of a query.
fn second(string: &ModuleString, place: &Range<usize>) -> f64 {
    let number = string.parameters.get(place.start + 1);
    number.copied().unwrap_or(0.0)
}

/// How far other wood is from each `?C`.
fn clearances<'a>(
    string: &ModuleString,
    asked: impl Iterator<Item = (&'a Asked, &'a DVec3)>,
    wood: &mut Wood,
    kin: Vec<Kin>,
    cancel: &AtomicBool,
) -> Result<Vec<f64>, DeriveError> {
    let those = asked.filter(|((query, _), _)| *query == Query::Clearance);
    let asked: Vec<_> = those
        .zip(kin)
        .map(|(((_, place), at), kin)| (*at, kin, second(string, place)))
        .collect();
    if asked.is_empty() {
        return Ok(Vec::new());
    }
    wood.clearances(&asked, cancel).ok_or_else(|| {
        let step = string.births().max().unwrap_or(0);
        DeriveProblem::Cancelled { step }.into()
    })
}

/// The light at each `?S`, among the leaves that stand at them all.
fn light<'a>(
    string: &ModuleString,
    asked: impl Iterator<Item = (&'a Asked, &'a DVec3)>,
) -> Vec<f32> {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "areas are as rough as that"
    )]
    let leaves: Vec<_> = asked
        .filter(|((query, _), _)| *query == Query::Shade)
        .map(|((_, place), at)| (at.as_vec3(), second(string, place) as f32))
        .collect();
    Light::on_each(&leaves)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    /// Ends that starve and are crowded, on bent segments.
    const PLANT: &str = "seed 3\ncontext literal\ntropism 0 1 0\nground 0.5\naxiom T(0.1) A(0, 0) B ?S(1, 0.2) ?C(0.3, 0.3)\n\
        A(x, p) > B ?S(l, a) ?C(c, r) : c < r && x > 9 -> A(x, p)\n\
        A(x, p) > B : x < 14 -> A(x, p) A(x+1, normal(0, 9))\n\
        A(x, p) > A(y, q) : x % 2 == 1 -> A(x, p) [ /(137*x + normal(0, 5)) &(60) A(x+2, 0) B ?S(1, 0.2) ?C(0.3, 0.3) ]\n\
        B > ?S(l, a) : l < 0.1 -> *\n?S(l, a) : l < 0.1 -> *\n\
        interpret depth 2 {\n  A(x, p) -> +(p) D(x)\n  D(x) -> F(0.2)\n}\n";

    /// What is kept of a step for the next is what reading anew finds, where it is kept and where it is not.
    #[test]
    fn steps_in_a_row_are_as_each_for_itself() {
        for (what, text, steps) in [
            ("plant", PLANT, 17),
            (
                "longer and longer",
                "axiom F(1) ?P(0, 0, 0)\nF(l) -> F(l*1.1) +(9) F(0.1)\n",
                9,
            ),
            (
                "lines in one place",
                "axiom F(1) A ?C(0, 9)\nA -> [ +(40) F(1) ?C(0, 9) ] [ +(40) F(1) ?C(0, 9) ] F(1) A\n",
                6,
            ),
            (
                "wood that falls",
                "axiom A ?C(0, 9)\nA -> [ +(50) D(0) ] F(1) A\nD(n) : n < 3 -> D(n+1)\nD(n) : n >= 3 -> *\ninterpret {\n  D(n) -> F(1)\n}\n",
                8,
            ),
            (
                "an outline",
                "axiom A\nA -> F(1) { F(1) +(90) F(1) +(90) F(1) } ?H(0, 0, 0) A\n",
                5,
            ),
            (
                "by chance",
                "seed 1\naxiom A\nA -> D ?P(0, 0) A\ninterpret {\n  D -> +(uniform(0, 9)) F(1)\n}\n",
                6,
            ),
        ] {
            let grammar = Grammar::parse(text, what).unwrap();
            let (limits, never) = (Limits::default(), AtomicBool::new(false));
            let mut string = grammar.derive(0, &limits, &never).unwrap();
            for step in 1..=steps {
                string = grammar.derive_next(&string, step, &limits, &never).unwrap();
                let in_a_row = grammar.derive(step, &limits, &never).unwrap();
                assert_eq!(in_a_row, string, "{what}, step {step}");
            }
            assert!(string.len() > 12, "{what}: {}", string.to_text(&grammar));
        }
    }
}
