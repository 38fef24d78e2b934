//! How a sitting goes: pages one after the other, answers, and tasks against the clock. Events in, state out; nothing here knows a panel or a file.

use serde::{Deserialize, Serialize};

use super::score::{OWN_ITEMS_MOST, Part};

/// Symptoms on a page.
const SSQ_ON_PAGE: usize = 8;
/// Statements on a page, those of the SUS and own ones, which may be longer.
const SUS_ON_PAGE: usize = 5;
const OWN_ON_PAGE: usize = 4;
/// Longest time between two frames that counts, seconds: what is longer, nobody was there.
const LONGEST: f64 = 1.0;
/// How often the time of a task that is under way is kept, seconds.
const KEPT_EVERY: f64 = 5.0;
/// Longest time for a task, seconds.
pub const SECONDS_MOST: f64 = 24.0 * 3600.0;

/// How a task ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The participant said that it is done.
    Done,
    /// The time was over.
    TimeOver,
    /// It was left without being done.
    Left,
}

impl Outcome {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Done, Self::TimeOver, Self::Left];

    /// Its name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Done => "done",
            Self::TimeOver => "time-over",
            Self::Left => "left",
        }
    }
}

/// What became of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskResult {
    /// Its name.
    pub task: String,
    /// How long it took, seconds.
    pub seconds: f64,
    /// How it ended.
    pub outcome: Outcome,
}

/// Something to be made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Task {
    /// Its name in files.
    pub name: String,
    /// What is to be done.
    pub text: String,
    /// The same in German.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub german: Option<String>,
    /// How long there is for it, seconds.
    pub seconds: f64,
    /// A picture of what is to be made: a file beside that of the tasks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
}

/// What a sitting is of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// In their order.
    pub tasks: Vec<Task>,
    /// Statements of the study itself, answered as those of the SUS.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statements: Vec<String>,
}

/// What is asked at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// What comes.
    Welcome,
    /// Some questions of a part: from this one on, up to but not with that one.
    Questions(Part, usize, usize),
    /// A task.
    Task(usize),
    /// It is over.
    Thanks,
}

/// What the participant does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Answers an item of a part, from 0.
    Answer(Part, usize, u8),
    /// Goes on.
    Next,
    /// Goes back.
    Back,
    /// Begins the task, or goes on with it.
    Begin,
    /// Says that the task is done.
    Done,
    /// Leaves the task.
    Leave,
}

/// How far somebody has come: what is kept of a sitting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The page, from 0.
    pub page: usize,
    /// Seconds that the page's task took already.
    pub under_way: f64,
    /// In the order of [`Part::ALL`].
    pub answers: [Vec<Option<u8>>; 4],
    /// What became of the tasks that are over.
    pub tasks: Vec<TaskResult>,
}

/// See the module.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    plan: Plan,
    pages: Vec<Page>,
    progress: Progress,
    /// The task's time runs.
    running: bool,
    /// It was told that answers of this page are missing.
    warned: bool,
    /// Goes up with everything that is seen.
    seen: u64,
    /// Goes up with everything that is to be kept.
    kept: u64,
}

impl Study {
    /// Goes on where somebody stopped; whatever in it fits no such plan is left out. With the default it begins.
    #[must_use]
    pub fn resume(plan: Plan, mut progress: Progress) -> Self {
        let pages = pages(&plan);
        progress.page = progress.page.min(pages.len().saturating_sub(1));
        for (part, answers) in Part::ALL.into_iter().zip(&mut progress.answers) {
            let [least, most] = part.range();
            answers.resize(items(&plan, part), None);
            for answer in answers {
                *answer = answer.filter(|value| (least..=most).contains(value));
            }
        }
        let mut tasks: Vec<TaskResult> = Vec::new();
        for task in &plan.tasks {
            let found = progress.tasks.iter().find(|result| {
                result.task == task.name && (0.0..=SECONDS_MOST).contains(&result.seconds)
            });
            tasks.extend(found.cloned());
        }
        progress.tasks = tasks;
        let mut study = Self {
            plan,
            pages,
            progress,
            running: false,
            warned: false,
            seen: 0,
            kept: 0,
        };
        let limit = study.task_open().map_or(0.0, |task| task.seconds);
        let under_way = &mut study.progress.under_way;
        let fits = (0.0..limit).contains(under_way);
        *under_way = if fits { *under_way } else { 0.0 };
        study
    }

    /// What it is of.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What is to be kept.
    #[must_use]
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Where it is.
    #[must_use]
    pub fn page(&self) -> Page {
        let page = self.pages.get(self.progress.page);
        page.copied().unwrap_or(Page::Thanks)
    }

    /// The page's number from 1, and how many there are.
    #[must_use]
    pub fn place(&self) -> [usize; 2] {
        [self.progress.page + 1, self.pages.len()]
    }

    /// Whether all pages were gone through.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.page() == Page::Thanks
    }

    /// What was answered to an item.
    #[must_use]
    pub fn answer(&self, part: Part, item: usize) -> Option<u8> {
        self.progress.answers[part as usize].get(item).copied()?
    }

    /// How many questions of this page have no answer, where that was told.
    #[must_use]
    pub fn missing_told(&self) -> Option<usize> {
        self.warned.then(|| self.missing())
    }

    /// Goes up with everything that is seen.
    #[must_use]
    pub fn seen(&self) -> u64 {
        self.seen
    }

    /// Goes up with everything that is to be kept: pages, tasks that end, and every few seconds of one.
    #[must_use]
    pub fn kept(&self) -> u64 {
        self.kept
    }

    /// The page's task and what became of it.
    #[must_use]
    pub fn task(&self) -> Option<(&Task, Option<&TaskResult>)> {
        let Page::Task(number) = self.page() else {
            return None;
        };
        let task = self.plan.tasks.get(number)?;
        let mut results = self.progress.tasks.iter();
        Some((task, results.find(|result| result.task == task.name)))
    }

    /// The page's task, where it is not over.
    fn task_open(&self) -> Option<&Task> {
        let (task, result) = self.task()?;
        result.is_none().then_some(task)
    }

    /// Whether a task's time runs.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.running
    }

    /// Whether the page's task was begun and not ended.
    #[must_use]
    pub fn is_begun(&self) -> bool {
        self.running || self.progress.under_way > 0.0
    }

    /// Seconds that are left for the page's task.
    #[must_use]
    pub fn seconds_left(&self) -> Option<f64> {
        let task = self.task_open()?;
        Some((task.seconds - self.progress.under_way).max(0.0))
    }

    /// Whether one can go back: not from a task that has begun.
    #[must_use]
    pub fn can_go_back(&self) -> bool {
        self.progress.page > 0 && !self.is_begun()
    }

    /// Whether one can go on: a task ends first.
    #[must_use]
    pub fn can_go_on(&self) -> bool {
        !self.is_over() && self.task_open().is_none()
    }

    fn missing(&self) -> usize {
        let Page::Questions(part, from, to) = self.page() else {
            return 0;
        };
        let open = |item: &usize| self.answer(part, *item).is_none();
        (from..to).filter(open).count()
    }

    /// Does what the participant wants; what cannot be done is not.
    pub fn act(&mut self, event: Event) {
        let warned = std::mem::take(&mut self.warned);
        self.seen += 1;
        match event {
            Event::Answer(part, item, value) => {
                // Of this page alone: nobody answers what they do not see.
                let here = matches!(self.page(), Page::Questions(other, from, to) if other == part && (from..to).contains(&item));
                let [least, most] = part.range();
                if here
                    && (least..=most).contains(&value)
                    && let Some(answer) = self.progress.answers[part as usize].get_mut(item)
                {
                    *answer = Some(value);
                }
            }
            Event::Next if self.can_go_on() => match self.missing() {
                // An answer may be refused, and is not forgotten unseen.
                missing if missing > 0 && !warned => self.warned = true,
                _ => self.turn(self.progress.page + 1),
            },
            Event::Back if self.can_go_back() => self.turn(self.progress.page - 1),
            Event::Begin if self.task_open().is_some() => {
                self.running = true;
                self.kept += 1;
            }
            Event::Done if self.running => self.end_task(Outcome::Done),
            Event::Leave if self.running => self.end_task(Outcome::Left),
            _ => {}
        }
    }

    fn turn(&mut self, page: usize) {
        self.progress.page = page.min(self.pages.len().saturating_sub(1));
        self.kept += 1;
    }

    fn end_task(&mut self, outcome: Outcome) {
        if let Some(task) = self.task_open() {
            let result = TaskResult {
                task: task.name.clone(),
                seconds: self.progress.under_way.min(task.seconds),
                outcome,
            };
            self.progress.tasks.push(result);
        }
        self.running = false;
        self.progress.under_way = 0.0;
        self.seen += 1;
        self.kept += 1;
    }

    /// Lets time pass.
    pub fn pass(&mut self, seconds: f64) {
        if !self.running || !seconds.is_finite() || seconds <= 0.0 {
            return;
        }
        let before = self.progress.under_way;
        let after = before + seconds.min(LONGEST);
        self.progress.under_way = after;
        // Nothing allocates in a frame in which a second goes by.
        self.seen += u64::from(before.floor() != after.floor());
        self.kept += u64::from((before / KEPT_EVERY).floor() != (after / KEPT_EVERY).floor());
        if self.seconds_left() == Some(0.0) {
            self.end_task(Outcome::TimeOver);
        }
    }
}

/// How many items a part has.
fn items(plan: &Plan, part: Part) -> usize {
    let own = plan.statements.len().min(OWN_ITEMS_MOST);
    part.items().unwrap_or(own)
}

/// All pages.
fn pages(plan: &Plan) -> Vec<Page> {
    let questions = |part: Part| {
        let on_page = match part {
            Part::SsqBefore | Part::SsqAfter => SSQ_ON_PAGE,
            Part::Sus => SUS_ON_PAGE,
            Part::Own => OWN_ON_PAGE,
        };
        let items = items(plan, part);
        (0..items)
            .step_by(on_page)
            .map(move |from| Page::Questions(part, from, (from + on_page).min(items)))
    };
    let mut pages = vec![Page::Welcome];
    pages.extend(questions(Part::SsqBefore));
    pages.extend((0..plan.tasks.len()).map(Page::Task));
    pages.extend(questions(Part::Sus));
    pages.extend(questions(Part::Own));
    pages.extend(questions(Part::SsqAfter));
    pages.push(Page::Thanks);
    pages
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use proptest::prelude::*;

    use super::*;

    fn plan() -> Plan {
        let task = |name: &str, seconds| Task {
            name: name.to_owned(),
            text: String::new(),
            german: None,
            seconds,
            picture: None,
        };
        Plan {
            tasks: vec![task("a", 3.0), task("b", 60.0)],
            statements: vec!["It was fun.".to_owned(); 6],
        }
    }

    pub(crate) fn begun() -> Study {
        Study::resume(plan(), Progress::default())
    }

    /// Answers everything on the page with the largest answer.
    fn answer_all(study: &mut Study) {
        if let Page::Questions(part, from, to) = study.page() {
            for item in from..to {
                study.act(Event::Answer(part, item, part.range()[1]));
            }
        }
    }

    #[test]
    fn a_sitting_goes_from_page_to_page() {
        let mut study = begun();
        let mut pages = Vec::new();
        while !study.is_over() {
            pages.push(study.page());
            answer_all(&mut study);
            if study.task().is_some() {
                study.act(Event::Next);
                assert_eq!(Some(&study.page()), pages.last(), "a task ends first");
                study.act(Event::Begin);
                study.pass(0.5);
                study.act(Event::Done);
            }
            study.act(Event::Next);
        }
        let expected = [
            Page::Welcome,
            Page::Questions(Part::SsqBefore, 0, 8),
            Page::Questions(Part::SsqBefore, 8, 16),
            Page::Task(0),
            Page::Task(1),
            Page::Questions(Part::Sus, 0, 5),
            Page::Questions(Part::Sus, 5, 10),
            Page::Questions(Part::Own, 0, 4),
            Page::Questions(Part::Own, 4, 6),
            Page::Questions(Part::SsqAfter, 0, 8),
            Page::Questions(Part::SsqAfter, 8, 16),
        ];
        assert_eq!(pages, expected);
        for (part, answers) in Part::ALL.into_iter().zip(&study.progress().answers) {
            assert!(
                answers
                    .iter()
                    .all(|answer| *answer == Some(part.range()[1]))
            );
        }
        let seconds: Vec<f64> = study
            .progress()
            .tasks
            .iter()
            .map(|one| one.seconds)
            .collect();
        assert_eq!(seconds, [0.5, 0.5]);
    }

    /// A page with a gap says so once, and then is left with it.
    #[test]
    fn an_answer_can_be_refused_and_is_not_forgotten() {
        let mut study = begun();
        study.act(Event::Next);
        study.act(Event::Answer(Part::SsqBefore, 3, 2));
        study.act(Event::Next);
        assert_eq!(study.missing_told(), Some(7));
        study.act(Event::Answer(Part::SsqBefore, 4, 0));
        assert_eq!(study.missing_told(), None);
        study.act(Event::Next);
        study.act(Event::Next);
        assert_eq!(study.page(), Page::Questions(Part::SsqBefore, 8, 16));
        study.act(Event::Back);
        assert_eq!(study.answer(Part::SsqBefore, 3), Some(2));
        // Another page's items, other parts and what is on no scale.
        for (part, item, value) in [
            (Part::SsqBefore, 9, 1),
            (Part::Sus, 0, 3),
            (Part::SsqBefore, 0, 4),
        ] {
            study.act(Event::Answer(part, item, value));
            assert_eq!(study.answer(part, item), None);
        }
    }

    #[test]
    fn a_task_ends_by_itself_when_its_time_is_over() {
        let mut study = Study::resume(
            plan(),
            Progress {
                page: 3,
                ..Progress::default()
            },
        );
        study.pass(1.0);
        assert_eq!(study.seconds_left(), Some(3.0), "it has not begun");
        study.act(Event::Begin);
        assert!(!study.can_go_back());
        // A headset that was put down for a minute: a second counts.
        study.pass(60.0);
        assert_eq!(study.seconds_left(), Some(2.0));
        for _ in 0..25 {
            study.pass(0.1);
        }
        let (_, result) = study.task().unwrap();
        let result = result.unwrap();
        assert_eq!((result.seconds, result.outcome), (3.0, Outcome::TimeOver));
        study.act(Event::Begin);
        assert!(!study.is_running(), "it is over");
        study.act(Event::Next);
        study.act(Event::Begin);
        study.act(Event::Leave);
        assert_eq!(study.progress().tasks[1].outcome, Outcome::Left);
    }

    /// Whoever was killed in the middle of a task goes on with it, with the time that was left.
    #[test]
    fn what_was_kept_is_gone_on_with() {
        let mut study = Study::resume(
            plan(),
            Progress {
                page: 4,
                ..Progress::default()
            },
        );
        study.act(Event::Begin);
        for _ in 0..12 {
            study.pass(0.5);
        }
        let again = Study::resume(plan(), study.progress().clone());
        assert_eq!(again.seconds_left(), Some(54.0));
        assert!(again.is_begun() && !again.is_running() && !again.can_go_back());
        assert_eq!(study.kept(), 2, "its beginning, and five seconds later");
        let odd = Progress {
            page: usize::MAX,
            under_way: f64::NAN,
            answers: [vec![Some(9); 99], vec![Some(0)], vec![], vec![Some(3)]],
            tasks: vec![TaskResult {
                task: "z".into(),
                seconds: -1.0,
                outcome: Outcome::Done,
            }],
        };
        let odd = Study::resume(plan(), odd);
        assert!(odd.is_over() && odd.progress().tasks.is_empty());
        let given = odd.progress().answers.iter().flatten().flatten();
        assert_eq!(given.collect::<Vec<_>>(), [&3]);
    }

    fn event() -> impl Strategy<Value = Option<Event>> {
        let part = prop::sample::select(Part::ALL.to_vec());
        prop_oneof![
            4 => (part, 0_usize..20, any::<u8>()).prop_map(|(part, item, value)| Some(Event::Answer(part, item, value % 8))),
            4 => prop::sample::select(vec![Event::Next, Event::Back, Event::Begin, Event::Done, Event::Leave]).prop_map(Some),
            1 => Just(None),
        ]
    }

    proptest! {
        /// Any order of events: answers stay on their scales, tasks within their times, and what is kept comes back as it was.
        #[test]
        fn any_order_of_events_keeps_everything_in_range(events in prop::collection::vec(event(), 0..300), passed in -1.0..4.0_f64) {
            let mut study = begun();
            for event in events {
                match event {
                    Some(event) => study.act(event),
                    None => study.pass(passed),
                }
                let progress = study.progress();
                for (part, answers) in Part::ALL.into_iter().zip(&progress.answers) {
                    let [least, most] = part.range();
                    prop_assert!(answers.iter().flatten().all(|one| (least..=most).contains(one)));
                }
                prop_assert!(progress.tasks.len() <= 2);
                for result in &progress.tasks {
                    let limit = if result.task == "a" { 3.0 } else { 60.0 };
                    prop_assert!((0.0..=limit).contains(&result.seconds));
                }
                prop_assert!(study.place()[0] <= study.place()[1]);
                let again = Study::resume(plan(), progress.clone());
                prop_assert_eq!(again.progress(), progress);
            }
        }
    }
}
