//! An explanation as a person reads it.

use std::fmt::Write as _;

use super::{Chance, Explanation, Fate, ProductionUse, Seen};
use crate::lsystem::number::write_general;

impl Explanation {
    /// The explanation as lines of text: what became of the modules, then how much each production did.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        let modules = |count: usize| if count == 1 { "module" } else { "modules" };
        let (before, after) = (self.modules_before, self.modules_after);
        let _ = writeln!(
            text,
            "step {}: {before} {} → {after} {}\n",
            self.step,
            modules(before),
            modules(after)
        );
        let width = self
            .modules
            .iter()
            .map(|fate| place(fate).chars().count())
            .max()
            .unwrap_or(0);
        for fate in &self.modules {
            self.fate(&mut text, fate, width);
        }
        if self.more > 0 {
            let next = self.modules_before - self.more;
            let _ = writeln!(
                text,
                "… and {} more {} (--at {next} shows them from there, --entries sets how many)",
                self.more,
                modules(self.more)
            );
        }
        text.push_str("\nmodules  production\n");
        self.table(&mut text, &self.productions);
        let _ = writeln!(text, "{:>7}  none: they stay", self.stayed);
        if !self.decomposition.is_empty() {
            text.push_str("\nmodules  production of the decomposition that followed\n");
            self.table(&mut text, &self.decomposition);
        }
        text
    }

    fn fate(&self, text: &mut String, fate: &Fate, width: usize) {
        let _ = write!(text, "{:>width$}  {}", place(fate), fate.module);
        let production = fate.production.and_then(|at| self.productions.get(at));
        let Some(production) = production else {
            text.push_str(match (fate.successor.is_empty(), fate.count) {
                (true, _) => "  cut by a %\n",
                (false, 1) => "  stays\n",
                (false, _) => "  stay\n",
            });
            return;
        };
        let successor = match fate.successor.as_str() {
            "" => "nothing",
            successor => successor,
        };
        let _ = writeln!(text, " → {successor}");
        let indent = width + 4;
        let _ = writeln!(
            text,
            "{:indent$}{}  {}",
            "", production.location, production.production
        );
        for (side, seen) in [("left", &fate.left), ("right", &fate.right)] {
            if !seen.is_empty() {
                let _ = writeln!(text, "{:indent$}{side} context: {}", "", listed(seen));
            }
        }
        if let Some(drawn) = &fate.drawn {
            let _ = writeln!(text, "{:indent$}{}", "", chance(drawn));
        }
    }

    fn table(&self, text: &mut String, productions: &[ProductionUse]) {
        for used in productions {
            let _ = writeln!(
                text,
                "{:>7}  {}  {}",
                used.modules, used.location, used.production
            );
        }
    }
}

/// A position, or those of several.
fn place(fate: &Fate) -> String {
    match fate.count {
        1 => fate.position.to_string(),
        count => format!("{}–{}", fate.position, fate.position + count - 1),
    }
}

fn listed(seen: &[Seen]) -> String {
    let each = seen
        .iter()
        .map(|one| format!("{} at {}", one.module, one.position));
    each.collect::<Vec<_>>().join(", ")
}

/// `drawn with probability 0.33 (weight 1 of 3) from 3 that matched`.
fn chance(drawn: &Chance) -> String {
    let mut text = "drawn with probability ".to_owned();
    write_general(&mut text, (drawn.probability() * 1e4).round() / 1e4);
    text.push_str(" (weight ");
    write_general(&mut text, drawn.weight);
    text.push_str(" of ");
    write_general(&mut text, drawn.total);
    let _ = write!(text, ", {} matched)", drawn.among);
    text
}
