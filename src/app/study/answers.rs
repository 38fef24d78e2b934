//! The file of a sitting, `answers.json`, and the folder of a study, `DIR/PARTICIPANT/CONDITION/answers.json`.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, ensure};
use serde::{Deserialize, Serialize};

use super::{Answer, SITTINGS_MOST, Sitting, Study, TaskResult, check_sitting};
use crate::app::cohort::entries::bytes_of;
use crate::app::sentence;
use crate::tree::TreeError;
use crate::tree::file::write_atomically;
use crate::world::study::score::Part;

/// What a file of answers says it is.
pub const FORMAT: &str = "ramus-study/1";
/// The name of a sitting's file.
pub const ANSWERS: &str = "answers.json";
/// Longest file that is read, in bytes.
const BYTES_MOST: u64 = 1 << 20;

/// A file of answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Form {
    /// [`FORMAT`].
    pub format: String,
    /// The participant's code.
    pub participant: String,
    /// What was worked with.
    pub condition: String,
    /// Whether it was their first sitting (1), their second one, ….
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<u32>,
    /// The page that comes next, from 0; none where all were gone through.
    #[serde(default)]
    pub page: Option<usize>,
    /// Seconds that the task of that page took already.
    #[serde(default)]
    pub under_way: f64,
    /// Answers, 0 none to 3 severe; null where there is none.
    #[serde(default)]
    pub ssq_before: Vec<Option<f64>>,
    /// Answers, 1 strongly disagree to 5 strongly agree.
    #[serde(default)]
    pub sus: Vec<Option<f64>>,
    /// Answers in the same scale.
    #[serde(default)]
    pub own: Vec<Option<f64>>,
    /// As those before.
    #[serde(default)]
    pub ssq_after: Vec<Option<f64>>,
    /// What became of tasks.
    #[serde(default)]
    pub tasks: Vec<TaskResult>,
}

/// What a file says it is, before anything else of it is looked at.
#[derive(Deserialize)]
struct Said {
    format: Option<String>,
}

impl Form {
    /// Reads a file's bytes.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let no_json = |error: serde_json::Error| anyhow!("no answers can be read there ({error})");
        let said: Said = serde_json::from_slice(bytes).map_err(no_json)?;
        let format = said.format.unwrap_or_default();
        ensure!(
            format == FORMAT,
            "its format is {:?} and not {FORMAT:?}: it is of another program or a newer Ramus",
            format.chars().take(40).collect::<String>()
        );
        serde_json::from_slice(bytes).map_err(no_json)
    }

    /// The sitting that it is of.
    ///
    /// # Errors
    /// What in it is of no sitting. Answers that are missing or not on their scale are no error: scores say what became of them.
    pub fn sitting(&self, source: String) -> Result<Sitting> {
        let mut sitting = Sitting::new(self.participant.clone(), self.condition.clone(), source);
        sitting.order = self.order;
        sitting.tasks.clone_from(&self.tasks);
        let given = [&self.ssq_before, &self.sus, &self.own, &self.ssq_after];
        for (part, given) in Part::ALL.into_iter().zip(given) {
            let answers = given.iter().map(|one| answer(part, *one));
            let mut answers: Vec<Answer> = answers.collect();
            // Nobody answered what is not there.
            let items = part.items().unwrap_or(0).max(answers.len());
            answers.resize(items, Answer::Missing);
            sitting.answers[part as usize] = answers;
        }
        check_sitting(&sitting)?;
        Ok(sitting)
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// Where the disk does not take it.
    pub fn write(&self, path: &Path) -> Result<(), TreeError> {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        write_atomically(path, text.as_bytes())
    }
}

/// A number as an answer.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a whole number between 0 and 5"
)]
pub(super) fn answer(part: Part, given: Option<f64>) -> Answer {
    let [least, most] = part.range().map(f64::from);
    match given {
        None => Answer::Missing,
        Some(number) if number.fract() == 0.0 && (least..=most).contains(&number) => {
            Answer::Given(number as u8)
        }
        Some(number) => Answer::Strange(number.to_string()),
    }
}

/// Reads a file of answers.
///
/// # Errors
/// What is wrong with it.
pub fn read(path: &Path) -> Result<Form> {
    let name = path.display();
    let bytes = bytes_of(path, BYTES_MOST, "file of answers")?;
    Form::from_bytes(&bytes).with_context(|| name.to_string())
}

/// The sittings of a study's folder. What cannot be read costs nobody the rest.
///
/// # Errors
/// No folder, or none with answers.
pub(super) fn in_folder(folder: &Path) -> Result<Study> {
    let mut study = Study::default();
    let mut found = 0_usize;
    for participant in folders(folder)? {
        for condition in folders(&participant)? {
            let file = condition.join(ANSWERS);
            if !file.exists() {
                continue;
            }
            found += 1;
            ensure!(
                found <= SITTINGS_MOST,
                "{} has more than {SITTINGS_MOST} sittings: split it",
                folder.display()
            );
            match sitting_at(&file, [&participant, &condition]) {
                Ok((sitting, page)) => {
                    study.remarks.extend(page.map(|page| {
                        let Sitting {
                            participant,
                            condition,
                            ..
                        } = &sitting;
                        format!("{participant} under {condition} has not finished: it stands at page {}", page.saturating_add(1))
                    }));
                    study.sittings.push(sitting);
                }
                Err(error) => study.failed.push(sentence(&error)),
            }
        }
    }
    ensure!(
        found > 0,
        "{} has no answers: they are in PARTICIPANT/CONDITION/{ANSWERS} under it, where `ramus study run` writes them",
        folder.display()
    );
    Ok(study)
}

/// A file's sitting, where it says that it is of the folders that it lies in, and its page, where that is not the last.
fn sitting_at(file: &Path, folders: [&Path; 2]) -> Result<(Sitting, Option<usize>)> {
    let name = file.display();
    let form = read(file)?;
    let sitting = form.sitting(name.to_string());
    let sitting = sitting.with_context(|| name.to_string())?;
    for (what, says, folder) in [
        ("participant", &sitting.participant, folders[0]),
        ("condition", &sitting.condition, folders[1]),
    ] {
        ensure!(
            folder
                .file_name()
                .is_some_and(|folder| folder == says.as_str()),
            "{name} is of the {what} {says} and lies in the folder {}: one of the names is wrong",
            folder.display()
        );
    }
    Ok((sitting, form.page))
}

/// The folders in a folder, by name.
fn folders(folder: &Path) -> Result<Vec<PathBuf>> {
    let unreadable = |error: std::io::Error| {
        anyhow!(
            "{} cannot be read ({error}): check that it is there and may be read",
            folder.display()
        )
    };
    let mut found = Vec::new();
    for entry in folder.read_dir().map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.is_dir() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Whether a participant had sittings under other conditions before: the place of a new one, from 1.
pub fn place_of_next(folder: &Path, participant: &str, condition: &str) -> u32 {
    let others = folders(&folder.join(participant)).unwrap_or_default();
    let others = others.iter().filter(|other| {
        other.join(ANSWERS).exists() && other.file_name().is_none_or(|name| name != condition)
    });
    u32::try_from(others.count()).map_or(u32::MAX, |count| count.saturating_add(1))
}
