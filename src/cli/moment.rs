//! What `ramus derive` shows: the string of a whole step, or the growth between two.

use std::sync::atomic::AtomicBool;

use crate::lsystem::{
    DeriveError, DrawingCanvas, Grammar, Growing, Limits, ModuleString, TurtleParams, draw,
};
use crate::tree::Drawing;

/// A moment of a grammar's growth.
pub(super) enum Moment {
    Whole(ModuleString),
    /// So far into a step, between 0 and 1.
    Between(Box<Growing>, f64),
}

/// The step that a time in steps belongs to, and how far it is grown: 3.25 is a quarter of step 4, 4 all of it.
pub(super) fn step_at(time: f64) -> (u32, f64) {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a time is neither negative nor beyond u32, which its option rules out"
    )]
    let step = time.ceil() as u32;
    match step {
        0 => (0, 1.0),
        _ => (step, time - f64::from(step - 1)),
    }
}

/// A time in steps, from 0.
pub(super) fn time(text: &str) -> Result<f64, String> {
    let time: f64 = text.parse().map_err(|_| "no number".to_owned())?;
    if (0.0..f64::from(u32::MAX)).contains(&time) {
        Ok(time)
    } else {
        Err("expected a number of steps from 0 on, such as 3.5".to_owned())
    }
}

impl Moment {
    /// Derives it; `progress` is told the steps made.
    pub(super) fn new(
        grammar: &Grammar,
        (step, age): (u32, f64),
        limits: &Limits,
        cancel: &AtomicBool,
        progress: &mut dyn FnMut(u32),
    ) -> Result<Self, DeriveError> {
        if age >= 1.0 {
            return Ok(Self::Whole(
                grammar.derive_watched(step, limits, cancel, progress)?,
            ));
        }
        let before = grammar.derive_watched(step - 1, limits, cancel, progress)?;
        let growing = Growing::after(grammar, before, step, limits, cancel)?;
        Ok(Self::Between(Box::new(growing), age))
    }

    /// The modules, all of them whole.
    pub(super) fn string(&self) -> &ModuleString {
        match self {
            Self::Whole(string) => string,
            Self::Between(growing, _) => growing.string(),
        }
    }

    /// Bytes that it takes while it is drawn.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Whole(string) => string.bytes(),
            Self::Between(growing, _) => growing.bytes(),
        }
    }

    /// Draws it.
    pub(super) fn drawing(
        &self,
        grammar: &Grammar,
        params: &TurtleParams,
        cancel: &AtomicBool,
    ) -> Result<Drawing, DeriveError> {
        match self {
            Self::Whole(string) => draw(grammar, string, params, cancel),
            Self::Between(growing, age) => {
                let make = |params: &TurtleParams| DrawingCanvas::new(grammar, params);
                let canvas = growing.draw_on(grammar, *age, params, cancel, make)?;
                Ok(canvas.finish())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_steps() {
        for (written, expected) in [
            ("0", Some((0, 1.0))),
            ("3", Some((3, 1.0))),
            ("3.25", Some((4, 0.25))),
            ("0.5", Some((1, 0.5))),
            ("-0", Some((0, 1.0))),
            ("-1", None),
            ("NaN", None),
            ("1e300", None),
            ("x", None),
        ] {
            let found = time(written).ok().map(step_at);
            assert_eq!(found, expected, "{written}");
        }
    }
}
