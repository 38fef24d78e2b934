//! Text of a grammar as it is put together, with what it holds counted.

use std::fmt::Write as _;

use serde::Serialize;

/// A line is broken behind so many letters.
const LINE: usize = 110;

/// How large a grammar is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Size {
    /// Productions.
    pub productions: usize,
    /// Modules of the axiom and on both sides of productions, brackets among them.
    pub modules: usize,
    /// Parameters of these modules, and conditions.
    pub parameters: usize,
    /// Bytes of the text.
    pub bytes: usize,
}

impl Size {
    /// What is made small: modules and parameters.
    pub fn symbols(&self) -> usize {
        self.modules + self.parameters
    }
}

/// The text.
#[derive(Debug, Default)]
pub(super) struct Out {
    text: String,
    line: usize,
    size: Size,
}

impl Out {
    pub(super) fn raw(&mut self, text: &str) {
        self.text.push_str(text);
        self.line = match text.rfind('\n') {
            Some(at) => text.len() - at - 1,
            None => self.line + text.len(),
        };
    }

    /// A module with its parameters.
    pub(super) fn module(&mut self, name: &str, parameters: &[String]) {
        if self.line > LINE {
            self.raw("\n  ");
        } else if self.line > 2 {
            self.raw(" ");
        }
        self.raw(name);
        if !parameters.is_empty() {
            self.raw(&format!("({})", parameters.join(", ")));
        }
        self.size.modules += 1;
        self.size.parameters += parameters.len();
    }

    /// The left side of a production.
    pub(super) fn head(&mut self, name: &str, parameters: &[&str], condition: Option<&str>) {
        let own: Vec<String> = parameters.iter().map(|one| (*one).to_owned()).collect();
        self.raw("\n");
        self.module(name, &own);
        if let Some(condition) = condition {
            self.raw(" : ");
            self.raw(condition);
            self.size.parameters += 1;
        }
        self.raw(" ->");
        self.size.productions += 1;
    }

    pub(super) fn finish(mut self) -> (String, Size) {
        self.raw("\n");
        self.size.bytes = self.text.len();
        (self.text, self.size)
    }
}

/// A parameter times a number.
pub(super) fn times(name: &str, number: f64) -> String {
    // Products of numbers with few digits have many, which say nothing.
    let short = super::number::shortest(number, number.abs() * 1e-8);
    match short {
        1.0 => name.to_owned(),
        short => format!("{name}*{short}"),
    }
}

/// A parameter and a whole number.
pub(super) fn plus(name: &str, number: i64) -> String {
    match number {
        0 => name.to_owned(),
        number if number > 0 => format!("{name}+{number}"),
        number => format!("{name}{number}"),
    }
}

/// The names that productions take, one after the other: capitals that mean nothing to the turtle, then with subscripts.
pub(super) fn name(number: usize) -> String {
    const LETTERS: &[u8] = b"ABCDEHIJKLMNOPQRUVWXYZ";
    let mut name = String::from(char::from(LETTERS[number % LETTERS.len()]));
    let round = number / LETTERS.len();
    if round > 0 {
        let digits = round.to_string();
        let lowered = digits
            .bytes()
            .map(|digit| char::from_u32(0x2080 + u32::from(digit - b'0')));
        for letter in lowered.flatten() {
            let _ = write!(name, "{letter}"); // Writing into a string cannot fail.
        }
    }
    name
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn names_differ_and_are_none_of_the_turtles() {
        let names: Vec<String> = (0..1000).map(name).collect();
        let different: std::collections::HashSet<&String> = names.iter().collect();
        assert_eq!(different.len(), names.len());
        assert_eq!(
            [&names[0], &names[22], &names[22 * 12 + 1]],
            ["A", "A₁", "B₁₂"]
        );
        assert!(
            names
                .iter()
                .all(|name| !name.starts_with(['F', 'G', 'S', 'T']))
        );
    }

    #[test]
    fn parameters_say_no_more_than_they_must() {
        assert_eq!(times("l", 1.0), "l");
        assert_eq!(times("l", 0.9 * 0.7), "l*0.63");
        assert_eq!(
            [plus("n", 0), plus("n", 2), plus("n", -1)],
            ["n", "n+2", "n-1"]
        );
    }
}
