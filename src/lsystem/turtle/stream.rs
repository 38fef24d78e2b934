//! Drawing modules from wherever they come, at a memory that does not depend on how many they are.

use std::sync::atomic::AtomicBool;

use super::super::derive::interpreted;
use super::super::error::DeriveError;
use super::super::grammar::{Grammar, Role, RuleSet};
use super::super::string::{Module, ModuleString};
use super::{Canvas, Turtle, TurtleParams};

/// Modules that the `interpret` block is shown at once.
const AT_ONCE: usize = 1 << 16;

/// Whether a grammar's string can be drawn piece by piece: what its `interpret` block makes of a module must depend neither on where the
/// module stands, as random draws do, nor on others, as with `%`.
#[must_use]
pub fn streams(grammar: &Grammar) -> bool {
    let drawn = grammar.interpret.as_ref().is_some_and(RuleSet::draws);
    grammar.interpret.is_none() || !(drawn || grammar.roles.contains(&Role::Cut))
}

/// Draws modules on a canvas, as [`super::draw_on`] draws those of a string; of a grammar that [`streams`].
///
/// # Errors
/// As [`super::draw_on`].
pub fn stream_on<'m, C: Canvas>(
    grammar: &Grammar,
    mut modules: impl Iterator<Item = Module<'m>>,
    params: &TurtleParams,
    cancel: &AtomicBool,
    canvas: C,
) -> Result<C, DeriveError> {
    let mut turtle = Turtle::new(grammar, params, canvas);
    if grammar.interpret.is_none() {
        turtle.read_modules(modules, cancel)?;
        return turtle.finish();
    }
    loop {
        let mut piece = ModuleString::up_to(u32::from(u16::MAX), u32::MAX, &grammar.arity);
        for module in modules.by_ref().take(AT_ONCE) {
            piece.push(&module);
        }
        if piece.is_empty() {
            return turtle.finish();
        }
        let shown = interpreted(grammar, &piece, &params.limits, cancel)?;
        turtle.read(shown.as_ref().unwrap_or(&piece), cancel)?;
    }
}
