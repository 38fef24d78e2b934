//! What a participant of a study reads.
//!
//! The statements are Brooke's of 1996, with "cumbersome" for "awkward", which people knew better (Bangor, Kortum, Miller 2008); in German they are those of
//! B. Rummel's translation of 2013. Symptoms are named as Kennedy et al. (1993) name them.

use super::Language;
use crate::world::study::score::{SSQ_ITEMS, SUS_ITEMS};

/// All strings of a study; a language that lacks one does not compile.
#[allow(missing_docs, reason = "the names are the strings")]
#[derive(Clone, Copy, Debug)]
pub struct StudyWords {
    pub welcome: &'static str,
    pub welcome_text: &'static str,
    pub how_before: &'static str,
    pub how_after: &'static str,
    pub statements: &'static str,
    pub own_statements: &'static str,
    pub severity: [&'static str; 4],
    pub disagree: &'static str,
    pub agree: &'static str,
    pub symptoms: [&'static str; SSQ_ITEMS],
    pub sus: [&'static str; SUS_ITEMS],
    pub task: &'static str,
    pub time: &'static str,
    pub time_left: &'static str,
    pub begin: &'static str,
    pub go_on: &'static str,
    pub done: &'static str,
    pub leave: &'static str,
    pub is_done: &'static str,
    pub is_over: &'static str,
    pub is_left: &'static str,
    pub back: &'static str,
    pub next: &'static str,
    /// How many are missing goes into `{}`.
    pub missing: &'static str,
    pub thanks: &'static str,
    pub thanks_text: &'static str,
}

impl Language {
    /// Its strings of a study.
    #[must_use]
    pub fn study(self) -> &'static StudyWords {
        match self {
            Self::English => &ENGLISH,
            Self::German => &GERMAN,
        }
    }
}

const ENGLISH: StudyWords = StudyWords {
    welcome: "Welcome",
    welcome_text: "Thank you for taking part. First you are asked how you feel, then there are tasks, and then you are asked again. \
        Point at a button and pull the trigger, or poke it. You may leave any answer open, and stop whenever you want: take the headset off.",
    how_before: "How do you feel right now?",
    how_after: "How do you feel now, after the work?",
    statements: "How much do you agree? The system is what you have just worked with.",
    own_statements: "How much do you agree?",
    severity: ["none", "slight", "moderate", "severe"],
    disagree: "strongly disagree",
    agree: "strongly agree",
    symptoms: [
        "General discomfort",
        "Fatigue",
        "Headache",
        "Eye strain",
        "Difficulty focusing",
        "Increased salivation",
        "Sweating",
        "Nausea",
        "Difficulty concentrating",
        "Fullness of head",
        "Blurred vision",
        "Dizziness (eyes open)",
        "Dizziness (eyes closed)",
        "Vertigo",
        "Stomach awareness",
        "Burping",
    ],
    sus: [
        "I think that I would like to use this system frequently.",
        "I found the system unnecessarily complex.",
        "I thought the system was easy to use.",
        "I think that I would need the support of a technical person to be able to use this system.",
        "I found the various functions in this system were well integrated.",
        "I thought there was too much inconsistency in this system.",
        "I would imagine that most people would learn to use this system very quickly.",
        "I found the system very cumbersome to use.",
        "I felt very confident using the system.",
        "I needed to learn a lot of things before I could get going with this system.",
    ],
    task: "Task",
    time: "Time",
    time_left: "Time left",
    begin: "Begin",
    go_on: "Go on",
    done: "It is done",
    leave: "Leave it",
    is_done: "It is done.",
    is_over: "The time is over.",
    is_left: "It was left.",
    back: "Back",
    next: "Next",
    missing: "Without an answer: {}. Press Next again to leave that open.",
    thanks: "Thank you",
    thanks_text: "That was all. Everything is kept. You can take the headset off.",
};

const GERMAN: StudyWords = StudyWords {
    welcome: "Willkommen",
    welcome_text: "Danke fürs Mitmachen. Zuerst wird gefragt, wie es Ihnen geht, dann kommen Aufgaben, dann wieder Fragen. \
        Auf eine Taste zeigen und den Abzug ziehen, oder sie antippen. Sie können jede Antwort offen lassen und jederzeit aufhören: einfach das Headset abnehmen.",
    how_before: "Wie geht es Ihnen gerade?",
    how_after: "Wie geht es Ihnen jetzt, nach der Arbeit?",
    statements: "Wie sehr stimmen Sie zu? Das System ist das, womit Sie gerade gearbeitet haben.",
    own_statements: "Wie sehr stimmen Sie zu?",
    severity: ["gar nicht", "leicht", "mäßig", "stark"],
    disagree: "stimme überhaupt nicht zu",
    agree: "stimme voll zu",
    symptoms: [
        "Allgemeines Unwohlsein",
        "Ermüdung",
        "Kopfschmerzen",
        "Überanstrengte Augen",
        "Mühe, scharf zu sehen",
        "Vermehrter Speichelfluss",
        "Schwitzen",
        "Übelkeit",
        "Konzentrationsprobleme",
        "Druck im Kopf",
        "Verschwommenes Sehen",
        "Schwindel (Augen offen)",
        "Schwindel (Augen zu)",
        "Gleichgewichtsstörung",
        "Magen macht sich bemerkbar",
        "Aufstoßen",
    ],
    sus: [
        "Ich kann mir sehr gut vorstellen, das System regelmäßig zu nutzen.",
        "Ich empfinde das System als unnötig komplex.",
        "Ich empfinde das System als einfach zu nutzen.",
        "Ich denke, dass ich technischen Support brauchen würde, um das System zu nutzen.",
        "Ich finde, dass die verschiedenen Funktionen des Systems gut integriert sind.",
        "Ich finde, dass es im System zu viele Inkonsistenzen gibt.",
        "Ich kann mir vorstellen, dass die meisten Leute das System schnell zu beherrschen lernen.",
        "Ich empfinde die Bedienung als sehr umständlich.",
        "Ich habe mich bei der Nutzung des Systems sehr sicher gefühlt.",
        "Ich musste eine Menge Dinge lernen, bevor ich mit dem System arbeiten konnte.",
    ],
    task: "Aufgabe",
    time: "Zeit",
    time_left: "Zeit übrig",
    begin: "Anfangen",
    go_on: "Weitermachen",
    done: "Fertig",
    leave: "Aufgeben",
    is_done: "Sie ist fertig.",
    is_over: "Die Zeit ist um.",
    is_left: "Sie wurde aufgegeben.",
    back: "Zurück",
    next: "Weiter",
    missing: "Ohne Antwort: {}. Noch einmal Weiter lässt das offen.",
    thanks: "Danke",
    thanks_text: "Das war alles, und alles ist gesichert. Sie können das Headset abnehmen.",
};

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    fn all(words: &StudyWords) -> Vec<&'static str> {
        let StudyWords {
            welcome,
            welcome_text,
            how_before,
            how_after,
            statements,
            own_statements,
            severity,
            disagree,
            agree,
            symptoms,
            sus,
            task,
            time,
            time_left,
            begin,
            go_on,
            done,
            leave,
            is_done,
            is_over,
            is_left,
            back,
            next,
            missing,
            thanks,
            thanks_text,
        } = *words;
        let one = [
            welcome,
            welcome_text,
            how_before,
            how_after,
            statements,
            own_statements,
            disagree,
            agree,
            task,
            time,
            time_left,
            begin,
            go_on,
            done,
            leave,
            is_done,
            is_over,
            is_left,
            back,
            next,
            missing,
            thanks,
            thanks_text,
        ];
        let more = severity.into_iter().chain(symptoms).chain(sus);
        one.into_iter().chain(more).collect()
    }

    #[test]
    fn every_language_says_everything_in_its_own_words() {
        let [english, german] = Language::ALL.map(|language| all(language.study()));
        for (english, german) in english.iter().zip(&german) {
            assert_ne!(english, german, "not translated");
            for text in [english, german] {
                assert!(!text.trim().is_empty());
                let known = |c: char| c.is_ascii() || "äöüÄÖÜß".contains(c);
                assert!(
                    text.chars().all(known),
                    "{text} has a sign that the font may lack"
                );
                assert_eq!(english.contains("{}"), german.contains("{}"), "{text}");
            }
        }
    }
}
