//! Two questionnaires and their scores.
//!
//! The **System Usability Scale** (J. Brooke, "SUS: a quick and dirty usability scale", 1996): ten statements, 1 strongly disagree to 5 strongly
//! agree. Odd ones count what is above 1, even ones what is below 5, and the sum of 0 to 40 is multiplied by 2.5. Who forgets
//! to take 1 from the odd ones gets 12.5 too much.
//!
//! The **Simulator Sickness Questionnaire** (R. S. Kennedy, N. E. Lane, K. S. Berbaum, M. G. Lilienthal, "Simulator sickness questionnaire: an enhanced
//! method for quantifying simulator sickness", 1993): sixteen symptoms, 0 none to 3 severe. Seven of them are of each factor, five of two factors. A factor is the sum of
//! its symptoms times its weight; the total is the sum of the three sums (which counts those five twice) times 3.74.
//!
//! What is not answered is in no score: there is no way to it that is not a guess.

use serde::{Deserialize, Serialize};

/// Statements of the System Usability Scale.
pub const SUS_ITEMS: usize = 10;
/// Symptoms of the Simulator Sickness Questionnaire.
pub const SSQ_ITEMS: usize = 16;
/// Own statements at most.
pub const OWN_ITEMS_MOST: usize = 20;

/// The symptoms in the order of the questionnaire.
pub const SYMPTOMS: [&str; SSQ_ITEMS] = [
    "general discomfort",
    "fatigue",
    "headache",
    "eye strain",
    "difficulty focusing",
    "increased salivation",
    "sweating",
    "nausea",
    "difficulty concentrating",
    "fullness of head",
    "blurred vision",
    "dizziness (eyes open)",
    "dizziness (eyes closed)",
    "vertigo",
    "stomach awareness",
    "burping",
];

/// What the statements of the System Usability Scale are about, in a few words.
pub const STATEMENTS: [&str; SUS_ITEMS] = [
    "would use it frequently",
    "unnecessarily complex",
    "easy to use",
    "would need support",
    "functions well integrated",
    "too much inconsistency",
    "most would learn it quickly",
    "cumbersome to use",
    "felt confident",
    "had to learn a lot first",
];

/// What people answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// The Simulator Sickness Questionnaire before the work.
    SsqBefore,
    /// The System Usability Scale.
    Sus,
    /// Statements of the study itself, answered as those of the SUS.
    Own,
    /// The Simulator Sickness Questionnaire after the work.
    SsqAfter,
}

impl Part {
    /// All of them, in the order in which they are asked.
    pub const ALL: [Self; 4] = [Self::SsqBefore, Self::Sus, Self::Own, Self::SsqAfter];

    /// Its name in files, and how its columns begin.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SsqBefore => "ssq_before",
            Self::Sus => "sus",
            Self::Own => "own",
            Self::SsqAfter => "ssq_after",
        }
    }

    /// What people call it.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::SsqBefore => "SSQ before",
            Self::Sus => "SUS",
            Self::Own => "own statements",
            Self::SsqAfter => "SSQ after",
        }
    }

    /// How many answers it takes; none where that is the study's choice.
    #[must_use]
    pub const fn items(self) -> Option<usize> {
        match self {
            Self::SsqBefore | Self::SsqAfter => Some(SSQ_ITEMS),
            Self::Sus => Some(SUS_ITEMS),
            Self::Own => None,
        }
    }

    /// The smallest and the largest answer.
    #[must_use]
    pub const fn range(self) -> [u8; 2] {
        match self {
            Self::SsqBefore | Self::SsqAfter => [0, 3],
            Self::Sus | Self::Own => [1, 5],
        }
    }
}

/// The score of the System Usability Scale, 0 to 100, of answers from 1 to 5. None where there are not ten, or one is not on the scale.
#[must_use]
pub fn sus(answers: &[u8]) -> Option<f64> {
    let fits = answers.len() == SUS_ITEMS && answers.iter().all(|one| (1..=5).contains(one));
    let part = |(place, answer): (usize, &u8)| match place % 2 {
        0 => answer - 1,
        _ => 5 - answer,
    };
    fits.then(|| f64::from(answers.iter().enumerate().map(part).sum::<u8>()) * 2.5)
}

/// A factor of the Simulator Sickness Questionnaire, or its total.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Factor {
    /// Nausea.
    Nausea,
    /// Oculomotor.
    Oculomotor,
    /// Disorientation.
    Disorientation,
    /// All of them.
    Total,
}

impl Factor {
    /// All of them, the total last.
    pub const ALL: [Self; 4] = [
        Self::Nausea,
        Self::Oculomotor,
        Self::Disorientation,
        Self::Total,
    ];

    /// Its name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nausea => "nausea",
            Self::Oculomotor => "oculomotor",
            Self::Disorientation => "disorientation",
            Self::Total => "total",
        }
    }

    /// What its sum is multiplied by (Kennedy et al. 1993, table 3).
    #[must_use]
    pub const fn weight(self) -> f64 {
        match self {
            Self::Nausea => 9.54,
            Self::Oculomotor => 7.58,
            Self::Disorientation => 13.92,
            Self::Total => 3.74,
        }
    }

    /// The symptoms that it sums, from 0 (Kennedy et al. 1993, table 3); the total has those of two factors twice.
    #[must_use]
    pub const fn symptoms(self) -> &'static [usize] {
        match self {
            Self::Nausea => &[0, 5, 6, 7, 8, 14, 15],
            Self::Oculomotor => &[0, 1, 2, 3, 4, 8, 10],
            Self::Disorientation => &[4, 7, 9, 10, 11, 12, 13],
            Self::Total => &[
                0, 5, 6, 7, 8, 14, 15, 0, 1, 2, 3, 4, 8, 10, 4, 7, 9, 10, 11, 12, 13,
            ],
        }
    }
}

/// Sums of symptoms, in the order of [`Factor::ALL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ssq(pub [u8; 4]);

impl Ssq {
    /// The sums of answers from 0 to 3. None where there are not sixteen, or one is not on the scale.
    #[must_use]
    pub fn of(answers: &[u8]) -> Option<Self> {
        let fits = answers.len() == SSQ_ITEMS && answers.iter().all(|one| *one <= 3);
        let sum = |factor: Factor| factor.symptoms().iter().map(|place| answers[*place]).sum();
        fits.then(|| Self(Factor::ALL.map(sum)))
    }

    /// The sum of a factor's symptoms.
    #[must_use]
    pub fn sum(self, factor: Factor) -> u8 {
        self.0[factor as usize]
    }

    /// A factor's score.
    #[must_use]
    pub fn score(self, factor: Factor) -> f64 {
        f64::from(self.sum(factor)) * factor.weight()
    }
}

/// What people call systems with such a score: the adjective whose mean score is nearest (A. Bangor, P. Kortum, J. Miller, "Determining what
/// individual SUS scores mean: adding an adjective rating scale", 2009).
#[must_use]
pub fn adjective(score: f64) -> &'static str {
    const MEANS: [(f64, &str); 7] = [
        (12.5, "worst imaginable"),
        (20.3, "awful"),
        (35.7, "poor"),
        (50.9, "OK"),
        (71.4, "good"),
        (85.5, "excellent"),
        (90.9, "best imaginable"),
    ];
    let away = |mean: f64| (score - mean).abs();
    let nearest = MEANS
        .into_iter()
        .min_by(|a, b| away(a.0).total_cmp(&away(b.0)));
    nearest.map_or("", |(_, adjective)| adjective)
}

/// Whether a score is acceptable (A. Bangor, P. Kortum, J. Miller, "An empirical evaluation of the System Usability Scale", 2008).
#[must_use]
pub fn acceptability(score: f64) -> &'static str {
    match score {
        score if score > 70.0 => "acceptable",
        score if score >= 50.0 => "marginal",
        _ => "not acceptable",
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn sus_goes_from_nothing_to_a_hundred() {
        for (answers, score) in [
            ([1, 5, 1, 5, 1, 5, 1, 5, 1, 5], 0.0),
            ([5, 1, 5, 1, 5, 1, 5, 1, 5, 1], 100.0),
            ([3; 10], 50.0),
            ([1; 10], 50.0),
            // The first participant of the published study, on both systems.
            ([1, 5, 1, 5, 2, 1, 1, 5, 1, 4], 15.0),
            ([4, 2, 4, 1, 5, 1, 4, 1, 4, 3], 82.5),
        ] {
            assert_eq!(sus(&answers), Some(score));
        }
        for wrong in [
            &[3; 9][..],
            &[3; 11],
            &[0, 3, 3, 3, 3, 3, 3, 3, 3, 3],
            &[6; 10],
        ] {
            assert_eq!(sus(wrong), None);
        }
    }

    /// The table of the paper, symptom by symptom: which factors it is of.
    #[test]
    fn symptoms_are_of_the_factors_that_the_paper_gives() {
        let table = [
            "NO", "O", "O", "O", "OD", "N", "N", "ND", "NO", "D", "OD", "D", "D", "D", "N", "N",
        ];
        for (place, factors) in table.iter().enumerate() {
            let mut answers = [0; SSQ_ITEMS];
            answers[place] = 3;
            let found = Ssq::of(&answers).unwrap();
            for (factor, letter) in Factor::ALL.into_iter().zip(["N", "O", "D"]) {
                let expected = if factors.contains(letter) { 3 } else { 0 };
                assert_eq!(
                    found.sum(factor),
                    expected,
                    "{} in {letter}",
                    SYMPTOMS[place]
                );
            }
            assert_eq!(usize::from(found.sum(Factor::Total)), 3 * factors.len());
        }
    }

    /// All severe: the largest scores that there are, 200.34, 159.18, 292.32 and 235.62.
    #[test]
    fn ssq_ends_where_the_paper_says() {
        let worst = Ssq::of(&[3; SSQ_ITEMS]).unwrap();
        let scores = Factor::ALL.map(|factor| (worst.score(factor) * 100.0).round() / 100.0);
        assert_eq!(scores, [200.34, 159.18, 292.32, 235.62]);
        assert_eq!(Ssq::of(&[0; SSQ_ITEMS]), Some(Ssq([0; 4])));
        for wrong in [&[0; 15][..], &[0; 17], &[4; 16]] {
            assert_eq!(Ssq::of(wrong), None);
        }
    }

    #[test]
    fn scores_have_adjectives() {
        for (score, name, accepted) in [
            (0.0, "worst imaginable", "not acceptable"),
            (50.0, "OK", "marginal"),
            (73.57, "good", "acceptable"),
            (86.0, "excellent", "acceptable"),
            (100.0, "best imaginable", "acceptable"),
        ] {
            assert_eq!((adjective(score), acceptability(score)), (name, accepted));
        }
    }
}
