//! A table of raw answers, one sitting a row: entered from paper, or of all sittings of a folder.
//!
//! Columns are found by their names, in any order: `participant`, `condition`, `order`, `sus_1` to `sus_10`, `own_1`, …, `ssq_before_1` to
//! `ssq_before_16`, `ssq_after_1` to `ssq_after_16`, and of each task `task_NAME_seconds` and `task_NAME_outcome`. What is written has the scores
//! too, which are passed over when it is read: they are made of the answers anew.

use std::path::Path;

use anyhow::{Context as _, Result, anyhow, bail, ensure};

use super::{
    Answer, Outcome, SITTINGS_MOST, Sitting, Study, TASKS_MOST, TaskResult, answers, check_name,
    check_sitting,
};
use crate::app::cohort::entries::text_of;
use crate::world::study::score::{Factor, OWN_ITEMS_MOST, Part, Ssq, sus};

/// What is under a condition that has no name.
const ONE: &str = "all";
/// Columns whose names are told where they are passed over.
const TOLD_MOST: usize = 8;

/// What a column of a table is.
#[derive(Clone, Debug, PartialEq)]
enum Column {
    Participant,
    Condition,
    Order,
    Answer(Part, usize),
    Seconds(String),
    Outcome(String),
    /// A score of ours.
    Score,
    Other,
}

impl Column {
    /// # Errors
    /// It is nearly one of ours.
    fn named(name: &str) -> Result<Self> {
        let lower = name.to_ascii_lowercase();
        match lower.as_str() {
            "participant" => return Ok(Self::Participant),
            "condition" => return Ok(Self::Condition),
            "order" => return Ok(Self::Order),
            _ if score_names().contains(&lower) => return Ok(Self::Score),
            _ => {}
        }
        if let Some(task) = lower.strip_prefix("task_") {
            // Names of tasks have small and large letters.
            let own = name.get("task_".len()..).unwrap_or_default();
            let without = |end: &str| {
                let kept = task.strip_suffix(end).map(str::len)?;
                own.get(..kept).map(str::to_owned)
            };
            return match (without("_seconds"), without("_outcome")) {
                (Some(task), _) => Ok(Self::Seconds(task)),
                (_, Some(task)) => Ok(Self::Outcome(task)),
                _ => bail!(
                    "the column {name:?} is no column of a task: write task_NAME_seconds or task_NAME_outcome"
                ),
            };
        }
        for part in Part::ALL {
            let Some(item) = lower.strip_prefix(part.name()) else {
                continue;
            };
            let most = part.items().unwrap_or(OWN_ITEMS_MOST);
            let number = item.strip_prefix('_').and_then(|item| item.parse().ok());
            let number = number.filter(|number| (1..=most).contains(number));
            let Some(number) = number else {
                bail!(
                    "the column {name:?} is no answer to the {}: they are {part}_1 to {part}_{most}",
                    part.title(),
                    part = part.name()
                );
            };
            return Ok(Self::Answer(part, number - 1));
        }
        ensure!(
            !lower.starts_with("ssq"),
            "the column {name:?} does not say whether it was asked before or after: write ssq_before_1 or ssq_after_1"
        );
        Ok(Self::Other)
    }
}

/// What scores are called that are written beside answers.
fn score_names() -> Vec<String> {
    let of = |part: Part| Factor::ALL.map(|factor| format!("{}_{}", part.name(), factor.name()));
    let ssq = [Part::SsqBefore, Part::SsqAfter].into_iter().flat_map(of);
    std::iter::once("sus_score".to_owned()).chain(ssq).collect()
}

/// Reads a table.
///
/// # Errors
/// What is wrong with it, and in which line.
pub(super) fn read(path: &Path, from_one: bool) -> Result<Study> {
    let text = text_of(path, "folder of a study or a table of its answers")?;
    from_text(&text, from_one, &path.display().to_string())
        .with_context(|| path.display().to_string())
}

/// Reads the text of a table. `from_one`: answers to the SSQ are 1 none to 4 severe there.
///
/// # Errors
/// What is wrong with it, and in which line.
pub fn from_text(text: &str, from_one: bool, name: &str) -> Result<Study> {
    let mut table = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.as_bytes());
    let no_table = |error: csv::Error| anyhow!("no table can be read there ({error})");
    let header = table.headers().map_err(no_table)?.clone();
    let columns = columns(&header)?;
    let mut study = Study::default();
    let passed: Vec<&str> = header
        .iter()
        .zip(&columns)
        .filter(|(_, column)| **column == Column::Other)
        .map(|(name, _)| name)
        .collect();
    if !passed.is_empty() {
        let more = if passed.len() > TOLD_MOST {
            ", …"
        } else {
            ""
        };
        let told = passed[..passed.len().min(TOLD_MOST)].join(", ");
        study.remarks.push(format!(
            "{name}: columns that are passed over: {told}{more}"
        ));
    }
    for row in table.records() {
        let row = row.map_err(no_table)?;
        let line = row.position().map_or(0, |begins| line_of(text, begins));
        if row.iter().all(str::is_empty) {
            continue;
        }
        let source = format!("line {line}");
        let sitting = sitting(&row, &columns, from_one, source);
        study
            .sittings
            .push(sitting.with_context(|| format!("line {line}"))?);
        ensure!(
            study.sittings.len() <= SITTINGS_MOST,
            "line {line} is of one sitting more than {SITTINGS_MOST}: split the table"
        );
    }
    ensure!(!study.sittings.is_empty(), "there are no answers in it");
    study.check_conditions()?;
    study
        .remarks
        .extend(begins_with_one(&study, from_one).map(|remark| format!("{name}: {remark}")));
    Ok(study)
}

/// The line of a row: its reader begins it with the empty lines and comments before it.
fn line_of(text: &str, begins: &csv::Position) -> u64 {
    let start = usize::try_from(begins.byte()).unwrap_or(usize::MAX);
    let rest = text.get(start..).unwrap_or_default();
    let passed = rest
        .lines()
        .take_while(|line| line.trim().is_empty() || line.starts_with('#'));
    begins.line() + passed.count() as u64
}

/// What looks as if the SSQ was answered from 1 on: its scores would be far too large.
fn begins_with_one(study: &Study, from_one: bool) -> Option<&'static str> {
    let parts = [Part::SsqBefore, Part::SsqAfter];
    let sittings = study.sittings.iter();
    let mut given = sittings
        .flat_map(|sitting| parts.iter().flat_map(|part| sitting.part(*part)))
        .filter(|answer| **answer != Answer::Missing)
        .peekable();
    let suspect = !from_one && given.peek().is_some() && given.all(|one| *one != Answer::Given(0));
    suspect.then_some("no answer to the SSQ is 0: if 1 is none there, add --ssq-from-one")
}

/// What the columns of a table are.
fn columns(header: &csv::StringRecord) -> Result<Vec<Column>> {
    let mut columns = Vec::new();
    let mut tasks = 0_usize;
    for name in header {
        let column = Column::named(name)?;
        ensure!(
            column == Column::Other || column == Column::Score || !columns.contains(&column),
            "the column {name} is there twice: leave one of them"
        );
        if let Column::Seconds(task) | Column::Outcome(task) = &column {
            check_name("task", task)?;
            tasks += 1;
            ensure!(
                tasks <= 2 * TASKS_MOST,
                "there are columns of more than {TASKS_MOST} tasks"
            );
        }
        columns.push(column);
    }
    ensure!(
        columns.contains(&Column::Participant),
        "the column participant is missing"
    );
    let answered = columns
        .iter()
        .any(|column| matches!(column, Column::Answer(..) | Column::Seconds(_)));
    ensure!(
        answered,
        "there is no column of answers, such as sus_1, ssq_before_1 or task_NAME_seconds"
    );
    Ok(columns)
}

fn sitting(
    row: &csv::StringRecord,
    columns: &[Column],
    from_one: bool,
    source: String,
) -> Result<Sitting> {
    let mut sitting = Sitting::new(String::new(), ONE.to_owned(), source);
    let own = columns.iter().filter_map(|column| match column {
        Column::Answer(Part::Own, place) => Some(place + 1),
        _ => None,
    });
    let own = own.max().unwrap_or(0);
    sitting.answers[Part::Own as usize] = vec![Answer::Missing; own];
    let mut outcomes: Vec<(&str, Outcome)> = Vec::new();
    for (cell, column) in row.iter().zip(columns) {
        match column {
            Column::Participant => sitting.participant = cell.to_owned(),
            Column::Condition if !cell.is_empty() => sitting.condition = cell.to_owned(),
            Column::Order if !cell.is_empty() => {
                let order = cell.parse().ok().filter(|order| *order > 0);
                let order =
                    order.with_context(|| format!("the order {cell:?} is no number from 1 on"));
                sitting.order = Some(order?);
            }
            Column::Answer(part, place) => {
                let answers = &mut sitting.answers[*part as usize];
                if let Some(answer) = answers.get_mut(*place) {
                    *answer = given(*part, cell, from_one);
                }
            }
            Column::Seconds(task) if !cell.is_empty() => {
                let seconds: f64 = cell
                    .parse()
                    .map_err(|_| anyhow!("the seconds of {task}, {cell:?}, are no number"))?;
                sitting.tasks.push(TaskResult {
                    task: task.clone(),
                    seconds,
                    outcome: Outcome::Done,
                });
            }
            Column::Outcome(task) if !cell.is_empty() => {
                let outcome = Outcome::ALL.into_iter().find(|one| one.name() == cell);
                let outcome = outcome.with_context(|| {
                    format!("the outcome of {task}, {cell:?}, is not done, time-over or left")
                });
                outcomes.push((task, outcome?));
            }
            _ => {}
        }
    }
    for (task, outcome) in outcomes {
        let result = sitting.tasks.iter_mut().find(|result| result.task == task);
        let result =
            result.with_context(|| format!("the task {task} has an outcome and no seconds"));
        result?.outcome = outcome;
    }
    check_sitting(&sitting)?;
    Ok(sitting)
}

/// A cell as an answer.
fn given(part: Part, cell: &str, from_one: bool) -> Answer {
    let shift = f64::from(u8::from(from_one && part.range() == [0, 3]));
    match cell.parse::<f64>() {
        _ if cell.is_empty() => Answer::Missing,
        Ok(number) => match answers::answer(part, Some(number - shift)) {
            // As it stands in the table.
            Answer::Strange(_) => Answer::Strange(cell.to_owned()),
            answer => answer,
        },
        Err(_) => {
            let shown: String = cell.chars().take(20).collect();
            Answer::Strange(format!("{shown:?}"))
        }
    }
}

/// What is no answer as a cell that is none either: a 0 where 1 was none would be one here.
fn strange(part: Part, text: &str) -> String {
    match given(part, text, false) {
        Answer::Strange(_) => text.to_owned(),
        Answer::Given(_) | Answer::Missing => format!("{text}?"),
    }
}

/// All sittings as a table, with their scores.
///
/// # Errors
/// None that a person could meet.
pub fn table(study: &Study) -> Result<Vec<u8>> {
    let mut tasks: Vec<&str> = Vec::new();
    for result in study.sittings.iter().flat_map(|sitting| &sitting.tasks) {
        if !tasks.contains(&result.task.as_str()) {
            tasks.push(&result.task);
        }
    }
    let own = study
        .sittings
        .iter()
        .map(|sitting| sitting.part(Part::Own).len());
    let own = own.max().unwrap_or(0);
    let items = |part: Part| part.items().unwrap_or(own);
    let mut out = csv::Writer::from_writer(Vec::new());
    let mut names: Vec<String> = ["participant", "condition", "order"]
        .map(str::to_owned)
        .into();
    for part in Part::ALL {
        names.extend((1..=items(part)).map(|item| format!("{}_{item}", part.name())));
    }
    names.extend(
        tasks
            .iter()
            .flat_map(|task| ["seconds", "outcome"].map(|what| format!("task_{task}_{what}"))),
    );
    names.extend(score_names());
    out.write_record(&names)?;
    for sitting in &study.sittings {
        out.write_record(cells(sitting, &tasks, &items))?;
    }
    Ok(out.into_inner()?)
}

/// A sitting's row.
fn cells(sitting: &Sitting, tasks: &[&str], items: &dyn Fn(Part) -> usize) -> Vec<String> {
    let order = sitting
        .order
        .map_or_else(String::new, |order| order.to_string());
    let mut cells = vec![
        sitting.participant.clone(),
        sitting.condition.clone(),
        order,
    ];
    for part in Part::ALL {
        let answers = sitting.part(part);
        cells.extend((0..items(part)).map(|place| match answers.get(place) {
            None | Some(Answer::Missing) => String::new(),
            Some(Answer::Given(value)) => value.to_string(),
            Some(Answer::Strange(text)) => strange(part, text.trim_matches('"')),
        }));
    }
    for task in tasks {
        match sitting.tasks.iter().find(|result| result.task == *task) {
            None => cells.extend([String::new(), String::new()]),
            Some(result) => cells.extend([
                format!("{:?}", result.seconds),
                result.outcome.name().to_owned(),
            ]),
        }
    }
    let shown = |score: Option<f64>| score.map_or_else(String::new, |score| format!("{score:.2}"));
    cells.push(shown(
        sitting
            .whole(Part::Sus)
            .ok()
            .and_then(|answers| sus(&answers)),
    ));
    for part in [Part::SsqBefore, Part::SsqAfter] {
        let sums = sitting
            .whole(part)
            .ok()
            .and_then(|answers| Ssq::of(&answers));
        cells.extend(Factor::ALL.map(|factor| shown(sums.map(|sums| sums.score(factor)))));
    }
    cells
}
