//! A study with participants: what they answered and how long they worked, and what that comes to.
//!
//! ```text
//! folder: DIR/PARTICIPANT/CONDITION/answers.json ─┐
//!                                                 ├─▶ sittings ─▶ report ─▶ told ─▶ screen, picture (SVG)
//! table of raw answers (CSV) ─────────────────────┘       └──────────▶ table of all (CSV)
//! plan: tasks and pictures ─▶ sitting: a session in the headset ─▶ answers.json
//! ```
//!
//! (`app::studies` is another thing: what is worked out of models in the background.)

pub mod answers;
pub mod paper;
pub mod picture;
pub mod plan;
pub mod report;
pub mod sitting;
pub mod summary;
pub mod told;

use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail, ensure};

pub use crate::world::study::flow::{Outcome, TaskResult};
use crate::world::study::score::{OWN_ITEMS_MOST, Part};

/// Sittings of a study at most.
pub const SITTINGS_MOST: usize = 10_000;
/// Conditions of a study at most: every two are compared.
pub const CONDITIONS_MOST: usize = 24;
/// Tasks of a sitting at most.
pub const TASKS_MOST: usize = 50;
/// Longest name of a participant, a condition or a task, in letters.
pub const NAME_MOST: usize = 40;

/// What stands where an answer is to be.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// Nothing.
    Missing,
    /// An answer on its scale.
    Given(u8),
    /// Something that is no answer.
    Strange(String),
}

/// A participant under a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Sitting {
    /// The participant's code.
    pub participant: String,
    /// What was worked with.
    pub condition: String,
    /// Whether it was their first sitting (1), their second one, ….
    pub order: Option<u32>,
    /// In the order of [`Part::ALL`]; own statements may be none.
    pub answers: [Vec<Answer>; 4],
    /// In their order.
    pub tasks: Vec<TaskResult>,
    /// Where it was read: a file, or a line of one.
    pub source: String,
}

impl Sitting {
    /// Nothing answered.
    pub fn new(participant: String, condition: String, source: String) -> Self {
        let nothing = |part: Part| vec![Answer::Missing; part.items().unwrap_or(0)];
        Self {
            participant,
            condition,
            order: None,
            answers: Part::ALL.map(nothing),
            tasks: Vec::new(),
            source,
        }
    }

    /// What was answered to a part.
    pub fn part(&self, part: Part) -> &[Answer] {
        &self.answers[part as usize]
    }

    /// Whether anything stands where answers to a part are to be.
    pub fn has(&self, part: Part) -> bool {
        self.part(part)
            .iter()
            .any(|answer| *answer != Answer::Missing)
    }

    /// The answers to a part, all of them.
    ///
    /// # Errors
    /// Which of them are missing or none, in a few words.
    pub fn whole(&self, part: Part) -> Result<Vec<u8>, String> {
        let answers = self.part(part);
        let (mut given, mut missing, mut strange) = (Vec::new(), Vec::new(), Vec::new());
        for (place, answer) in answers.iter().enumerate() {
            match answer {
                Answer::Given(value) => given.push(*value),
                Answer::Missing => missing.push((place + 1).to_string()),
                Answer::Strange(text) => strange.push(format!("{} is {text}", place + 1)),
            }
        }
        let mut faults = Vec::new();
        if given.is_empty() && strange.is_empty() {
            faults.push("no answers".to_owned());
        } else if !missing.is_empty() {
            faults.push(format!("no answer to {}", missing.join(", ")));
        }
        if !strange.is_empty() {
            let [least, most] = part.range();
            let strange = strange.join(", ");
            faults.push(format!("answers that are not {least} to {most}: {strange}"));
        }
        match faults.is_empty() {
            true => Ok(given),
            false => Err(faults.join("; ")),
        }
    }
}

/// What was read of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Study {
    /// By participant and condition.
    pub sittings: Vec<Sitting>,
    /// What could not be read, each in a sentence.
    pub failed: Vec<String>,
    /// What a person should know of the rest.
    pub remarks: Vec<String>,
}

impl Study {
    /// Reads a study's folder, or a table of raw answers, in which answers to the SSQ begin with 0, or with 1 where `from_one`.
    ///
    /// # Errors
    /// What keeps all of it from being read.
    pub fn read(source: &Path, from_one: bool) -> Result<Self> {
        let name = source.display();
        let known = source.metadata().map_err(|error| {
            anyhow!("{name} cannot be read ({error}): check that it is there and may be read")
        })?;
        let study = match known.is_dir() {
            true if from_one => {
                bail!("--ssq-from-one is of tables: in a folder none is 0 and severe is 3")
            }
            true => answers::in_folder(source)?,
            false => paper::read(source, from_one)?,
        };
        study.checked(source)
    }

    /// In order, and nothing twice.
    fn checked(mut self, source: &Path) -> Result<Self> {
        let name = source.display();
        ensure!(
            self.sittings.len() <= SITTINGS_MOST,
            "{name} has more than {SITTINGS_MOST} sittings: split it"
        );
        self.check_conditions().with_context(|| name.to_string())?;
        let key = |sitting: &Sitting| (sitting.participant.clone(), sitting.condition.clone());
        self.sittings.sort_by_key(key);
        for pair in self.sittings.windows(2) {
            if let [a, b] = pair
                && key(a) == key(b)
            {
                bail!(
                    "participant {} is there twice under the condition {}, in {} and in {}: leave one of them",
                    a.participant,
                    a.condition,
                    a.source,
                    b.source
                );
            }
        }
        Ok(self)
    }

    fn check_conditions(&self) -> Result<()> {
        let conditions = self.conditions().len();
        ensure!(
            conditions <= CONDITIONS_MOST,
            "there are {conditions} conditions, more than {CONDITIONS_MOST}: is something else in their place?"
        );
        Ok(())
    }

    /// The conditions, by name.
    pub fn conditions(&self) -> Vec<&str> {
        sorted(self.sittings.iter().map(|one| one.condition.as_str()))
    }

    /// The participants, by name.
    pub fn participants(&self) -> Vec<&str> {
        sorted(self.sittings.iter().map(|one| one.participant.as_str()))
    }
}

fn sorted<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Refuses names that are no names of folders everywhere: letters, digits, `-` and `_` are, and a letter or digit begins them.
///
/// # Errors
/// What is wrong; `what` says of what it is the name.
pub fn check_name(what: &str, name: &str) -> Result<()> {
    let shown: String = name.chars().take(NAME_MOST).collect();
    let fits = |letter: char| letter.is_ascii_alphanumeric() || letter == '-' || letter == '_';
    ensure!(!name.is_empty(), "the {what} has no name");
    ensure!(
        name.len() <= NAME_MOST,
        "the {what} {shown:?}… has more than {NAME_MOST} letters: shorten it"
    );
    ensure!(
        name.chars().all(fits) && name.starts_with(|first: char| first.is_ascii_alphanumeric()),
        "the {what} {shown:?} is not of letters, digits, - and _ alone, of which a letter or digit comes first: write P01, say"
    );
    Ok(())
}

/// Refuses what no sitting of ours has.
fn check_sitting(sitting: &Sitting) -> Result<()> {
    check_name("participant", &sitting.participant)?;
    check_name("condition", &sitting.condition)?;
    for part in Part::ALL {
        let (found, most) = (
            sitting.part(part).len(),
            part.items().unwrap_or(OWN_ITEMS_MOST),
        );
        ensure!(
            found <= most,
            "{found} answers to {} are more than {most}",
            part.title()
        );
    }
    ensure!(
        sitting.tasks.len() <= TASKS_MOST,
        "there are more than {TASKS_MOST} tasks"
    );
    for (place, result) in sitting.tasks.iter().enumerate() {
        let name = &result.task;
        check_name("task", name)?;
        ensure!(
            result.seconds.is_finite() && result.seconds >= 0.0,
            "the task {name} took {} seconds, which is no time",
            result.seconds
        );
        let is_twice = sitting.tasks[..place]
            .iter()
            .any(|other| other.task == *name);
        ensure!(!is_twice, "the task {name} is there twice");
    }
    Ok(())
}

#[cfg(test)]
mod tests;
