//! What a study comes to: scores, and tests of pairs. Nothing is put in place of an answer that is missing: who lacks one is left out of
//! the scores that take it, and the report says so.

use serde::Serialize;

use super::summary::{Paired, Summary, corrected, paired};
use super::{Answer, Outcome, Sitting, Study};
use crate::world::study::score::{Factor, Part, SUS_ITEMS, Ssq, acceptability, adjective, sus};

/// What a report says it is.
pub const FORMAT: &str = "ramus-study-report/1";

/// See the module.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// [`FORMAT`].
    pub format: &'static str,
    /// The participants.
    pub participants: Vec<String>,
    /// By their names.
    pub conditions: Vec<Condition>,
    /// Every two conditions that somebody worked under both.
    pub pairs: Vec<Pair>,
    /// Who is left out of what, and why.
    pub left_out: Vec<LeftOut>,
    /// Files that could not be read, each in a sentence.
    pub failed: Vec<String>,
}

/// What was found under a condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// Its name.
    pub condition: String,
    /// How many sittings there were.
    pub sittings: usize,
    /// The System Usability Scale.
    pub sus: Option<Sus>,
    /// Own statements, each with its answers.
    pub own: Vec<Option<Summary>>,
    /// The Simulator Sickness Questionnaire; empty where nobody was asked.
    pub ssq: Vec<Sickness>,
    /// In the order in which they are first met.
    pub tasks: Vec<Task>,
}

/// Scores of usability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sus {
    /// Their spread.
    pub summary: Summary,
    /// What people call systems with such a mean.
    pub adjective: &'static str,
    /// Whether it is acceptable.
    pub acceptability: &'static str,
    /// Each participant's score.
    pub scores: Vec<Scored>,
    /// Each statement with its answers.
    pub items: Vec<Option<Summary>>,
    /// By the place of the sitting among the participant's, where that is known.
    pub by_order: Vec<ByOrder>,
}

/// A participant's score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scored {
    /// The participant.
    pub participant: String,
    /// The score.
    pub score: f64,
}

/// Scores of sittings that were the first of their participants, the second, ….
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ByOrder {
    /// The place, from 1.
    pub order: u32,
    /// The scores.
    pub summary: Summary,
}

/// A factor of sickness.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sickness {
    /// Which.
    pub factor: Factor,
    /// Before the work.
    pub before: Option<Summary>,
    /// After it.
    pub after: Option<Summary>,
    /// After less before, of those who answered both.
    pub change: Option<Paired>,
}

/// What became of a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Task {
    /// Its name.
    pub task: String,
    /// How many tried it.
    pub n: usize,
    /// How many said that it is done.
    pub done: usize,
    /// How many ran out of time.
    pub time_over: usize,
    /// How many left it.
    pub left: usize,
    /// Seconds of those who did it.
    pub seconds: Option<Summary>,
}

/// Two conditions, compared by those who worked under both.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// The first.
    pub first: String,
    /// The second.
    pub second: String,
    /// Scores of usability.
    pub sus: Option<Paired>,
    /// Each statement of it.
    pub items: Vec<Option<Paired>>,
    /// Each own statement.
    pub own: Vec<Option<Paired>>,
}

/// Somebody whose answers are in no score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LeftOut {
    /// Who.
    pub participant: String,
    /// Under which condition.
    pub condition: String,
    /// Of what.
    pub part: Part,
    /// Why.
    pub reason: String,
}

/// What a study comes to.
pub fn report(study: &Study) -> Report {
    let names = study.conditions();
    let under = |name: &str| -> Vec<&Sitting> {
        let all = study.sittings.iter();
        all.filter(|sitting| sitting.condition == name).collect()
    };
    let mut pairs = Vec::new();
    for (place, first) in names.iter().enumerate() {
        for second in &names[place + 1..] {
            pairs.extend(pair(&under(first), &under(second)));
        }
    }
    Report {
        format: FORMAT,
        participants: study
            .participants()
            .into_iter()
            .map(str::to_owned)
            .collect(),
        conditions: names
            .iter()
            .map(|name| condition(name, &under(name)))
            .collect(),
        pairs,
        left_out: names
            .iter()
            .flat_map(|name| left_out(&under(name)))
            .collect(),
        failed: study.failed.clone(),
    }
}

/// Who lacks answers to something that others of a condition were asked.
fn left_out(sittings: &[&Sitting]) -> Vec<LeftOut> {
    let parts = [Part::SsqBefore, Part::Sus, Part::SsqAfter];
    let asked = parts
        .into_iter()
        .filter(|part| sittings.iter().any(|sitting| sitting.has(*part)));
    let lacks = asked.flat_map(|part| {
        sittings.iter().filter_map(move |sitting| {
            Some(LeftOut {
                participant: sitting.participant.clone(),
                condition: sitting.condition.clone(),
                part,
                reason: sitting.whole(part).err()?,
            })
        })
    });
    let mut all: Vec<LeftOut> = lacks.collect();
    // Each own statement is a score of its own.
    for sitting in sittings.iter().filter(|sitting| sitting.has(Part::Own)) {
        if let Err(reason) = sitting.whole(Part::Own) {
            all.push(LeftOut {
                participant: sitting.participant.clone(),
                condition: sitting.condition.clone(),
                part: Part::Own,
                reason,
            });
        }
    }
    all
}

fn sus_of(sitting: &Sitting) -> Option<f64> {
    sus(&sitting.whole(Part::Sus).ok()?)
}

fn ssq_of(sitting: &Sitting, part: Part) -> Option<Ssq> {
    Ssq::of(&sitting.whole(part).ok()?)
}

/// An answer, where it is one.
fn item(sitting: &Sitting, part: Part, place: usize) -> Option<f64> {
    match sitting.part(part).get(place)? {
        Answer::Given(value) => Some(f64::from(*value)),
        Answer::Missing | Answer::Strange(_) => None,
    }
}

fn items(sittings: &[&Sitting], part: Part) -> Vec<Option<Summary>> {
    let most = sittings
        .iter()
        .map(|sitting| sitting.part(part).len())
        .max();
    let of = |place| Summary::of(sittings.iter().filter_map(|one| item(one, part, place)));
    let mut items: Vec<Option<Summary>> = (0..most.unwrap_or(0)).map(of).collect();
    while part.items().is_none() && items.last().is_some_and(Option::is_none) {
        items.pop();
    }
    items
}

fn condition(name: &str, sittings: &[&Sitting]) -> Condition {
    Condition {
        condition: name.to_owned(),
        sittings: sittings.len(),
        sus: usability(sittings),
        own: items(sittings, Part::Own),
        ssq: sickness(sittings),
        tasks: tasks(sittings),
    }
}

fn usability(sittings: &[&Sitting]) -> Option<Sus> {
    let scored: Vec<(&Sitting, f64)> = sittings
        .iter()
        .filter_map(|sitting| Some((*sitting, sus_of(sitting)?)))
        .collect();
    let summary = Summary::of(scored.iter().map(|(_, score)| *score))?;
    let mut orders: Vec<u32> = scored.iter().filter_map(|(one, _)| one.order).collect();
    orders.sort_unstable();
    orders.dedup();
    let by_order = orders.into_iter().filter_map(|order| {
        let of = scored.iter().filter(|(one, _)| one.order == Some(order));
        let summary = Summary::of(of.map(|(_, score)| *score))?;
        Some(ByOrder { order, summary })
    });
    Some(Sus {
        adjective: adjective(summary.mean),
        acceptability: acceptability(summary.mean),
        items: items(sittings, Part::Sus),
        by_order: by_order.collect(),
        scores: scored
            .iter()
            .map(|(sitting, score)| Scored {
                participant: sitting.participant.clone(),
                score: *score,
            })
            .collect(),
        summary,
    })
}

fn sickness(sittings: &[&Sitting]) -> Vec<Sickness> {
    let of = |part: Part| -> Vec<Option<Ssq>> {
        sittings
            .iter()
            .map(|sitting| ssq_of(sitting, part))
            .collect()
    };
    let [before, after] = [Part::SsqBefore, Part::SsqAfter].map(of);
    if before.iter().chain(&after).all(Option::is_none) {
        return Vec::new();
    }
    let factor = |factor: Factor| {
        let scores =
            |all: &[Option<Ssq>]| Summary::of(all.iter().flatten().map(|sums| sums.score(factor)));
        let sum = |sums: Ssq| f64::from(sums.sum(factor));
        let both = before.iter().zip(&after);
        let pairs: Vec<[f64; 2]> = both
            .filter_map(|(before, after)| Some([sum((*before)?), sum((*after)?)]))
            .collect();
        Sickness {
            factor,
            before: scores(&before),
            after: scores(&after),
            change: paired(&pairs, factor.weight()),
        }
    };
    Factor::ALL.map(factor).to_vec()
}

fn tasks(sittings: &[&Sitting]) -> Vec<Task> {
    let mut names: Vec<&str> = Vec::new();
    let results = || sittings.iter().flat_map(|sitting| &sitting.tasks);
    for result in results() {
        if !names.contains(&result.task.as_str()) {
            names.push(&result.task);
        }
    }
    let task = |name: &str| {
        let of = || results().filter(|result| result.task == name);
        let count = |outcome| of().filter(|result| result.outcome == outcome).count();
        let done = of().filter(|result| result.outcome == Outcome::Done);
        Task {
            task: name.to_owned(),
            n: of().count(),
            done: count(Outcome::Done),
            time_over: count(Outcome::TimeOver),
            left: count(Outcome::Left),
            seconds: Summary::of(done.map(|result| result.seconds)),
        }
    };
    names.into_iter().map(task).collect()
}

/// Two conditions; none where nobody worked under both.
fn pair(first: &[&Sitting], second: &[&Sitting]) -> Option<Pair> {
    let both: Vec<[&Sitting; 2]> = first
        .iter()
        .filter_map(|one| {
            let mut others = second.iter();
            let other = others.find(|other| other.participant == one.participant)?;
            Some([*one, *other])
        })
        .collect();
    let [one, other] = *both.first()?;
    let compared = |of: &dyn Fn(&Sitting) -> Option<f64>| {
        let pairs: Vec<[f64; 2]> = both
            .iter()
            .filter_map(|[one, other]| Some([of(one)?, of(other)?]))
            .collect();
        // Scores are halves and wholes, whose differences are exact.
        paired(&pairs, 1.0)
    };
    let each = |part: Part, many: usize| {
        let mut all: Vec<Option<Paired>> = (0..many)
            .map(|place| compared(&|sitting| item(sitting, part, place)))
            .collect();
        corrected(&mut all);
        all
    };
    let own = both.iter().flatten().map(|one| one.part(Part::Own).len());
    let own = own.max().unwrap_or(0);
    Some(Pair {
        first: one.condition.clone(),
        second: other.condition.clone(),
        sus: compared(&sus_of),
        items: each(Part::Sus, SUS_ITEMS),
        own: each(Part::Own, own),
    })
}
