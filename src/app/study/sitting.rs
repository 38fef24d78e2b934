//! A sitting that goes on: where it is kept, and how what was answered comes to the disk while the session runs.
//!
//! Answers are written on a worker, whole or not at all, with every page that is turned, every task that ends and every few seconds of one.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context as _, Result, bail, ensure};

use super::answers::{self, ANSWERS, FORMAT, Form, answer};
use super::plan::{TASKS, Told};
use super::{Answer, check_name};
use crate::app::queue::Queue;
use crate::tree::file::write_atomically;
use crate::world::World;
use crate::world::document::Document;
use crate::world::project;
use crate::world::study::flow::{Progress, Study};
use crate::world::study::score::Part;

/// A sitting that is about to begin, or to go on.
#[derive(Clone, Debug, PartialEq)]
pub struct Sitting {
    /// The folder that it is kept in.
    pub folder: PathBuf,
    /// The participant's code.
    pub participant: String,
    /// What is worked with.
    pub condition: String,
    /// Which of the participant's sittings it is, from 1.
    pub order: u32,
    /// Tasks and pictures.
    pub told: Told,
    /// How far it has come.
    pub progress: Progress,
    /// Whether it was begun before.
    pub goes_on: bool,
}

impl Sitting {
    /// The sitting of a participant under a condition in a study's folder: the one that was begun, else a new one. Nothing is written.
    ///
    /// # Errors
    /// Names that are none, a sitting that is over, tasks that are not those it was begun with.
    pub fn of(
        study: &Path,
        participant: &str,
        condition: &str,
        tasks: Option<&Path>,
    ) -> Result<Self> {
        check_name("participant", participant)?;
        check_name("condition", condition)?;
        ensure!(
            !study.exists() || study.is_dir(),
            "{} is no folder: choose another one for the study",
            study.display()
        );
        let given = tasks.map(Told::read).transpose()?;
        let folder = study.join(participant).join(condition);
        let file = folder.join(ANSWERS);
        let mut sitting = Self {
            told: given.clone().map_or_else(Told::own, Ok)?,
            participant: participant.to_owned(),
            condition: condition.to_owned(),
            order: answers::place_of_next(study, participant, condition),
            progress: Progress::default(),
            goes_on: file.exists(),
            folder,
        };
        if sitting.goes_on {
            sitting.go_on_from(&file, given.as_ref())?;
        }
        Ok(sitting)
    }

    fn go_on_from(&mut self, file: &Path, given: Option<&Told>) -> Result<()> {
        let name = file.display();
        let form = answers::read(file)?;
        ensure!(
            (&form.participant, &form.condition) == (&self.participant, &self.condition),
            "{name} is of the participant {} under {}: choose another code",
            form.participant,
            form.condition
        );
        let Some(page) = form.page else {
            bail!(
                "{} has finished under the condition {} already ({name}): choose another code or condition",
                self.participant,
                self.condition
            );
        };
        self.told = Told::read(&self.folder.join(TASKS))
            .context("the tasks that the sitting was begun with are not there")?;
        ensure!(
            given.is_none_or(|given| given.asks_as(&self.told)),
            "{} has begun with other tasks, which are in {}: leave --tasks out to go on",
            self.participant,
            self.folder.join(TASKS).display()
        );
        let given = [&form.ssq_before, &form.sus, &form.own, &form.ssq_after];
        let on_scale = |part: Part, given: &Vec<Option<f64>>| -> Vec<Option<u8>> {
            let value = |one: &Option<f64>| match answer(part, *one) {
                Answer::Given(value) => Some(value),
                Answer::Missing | Answer::Strange(_) => None,
            };
            given.iter().map(value).collect()
        };
        self.order = form.order.unwrap_or(self.order);
        self.progress = Progress {
            page,
            under_way: form.under_way,
            answers: Part::ALL.map(|part| on_scale(part, given[part as usize])),
            tasks: form.tasks,
        };
        Ok(())
    }

    /// The state of it.
    pub fn study(&self) -> Study {
        Study::resume(self.told.plan.clone(), self.progress.clone())
    }

    /// Makes its folder, with tasks and answers, where it is new.
    ///
    /// # Errors
    /// Where the disk does not take it.
    pub fn make_folder(&self) -> Result<()> {
        if self.goes_on {
            return Ok(());
        }
        std::fs::create_dir_all(&self.folder)
            .with_context(|| format!("cannot make the folder {}", self.folder.display()))?;
        self.told.write(&self.folder)?;
        Ok(self.form(&self.study()).write(&self.folder.join(ANSWERS))?)
    }

    /// What is written of a state.
    fn form(&self, study: &Study) -> Form {
        let Progress {
            page,
            under_way,
            answers,
            tasks,
        } = study.progress();
        let written = |part: Part| -> Vec<Option<f64>> {
            let answers = answers[part as usize].iter();
            answers.map(|one| one.map(f64::from)).collect()
        };
        Form {
            format: FORMAT.to_owned(),
            participant: self.participant.clone(),
            condition: self.condition.clone(),
            order: Some(self.order),
            page: (!study.is_over()).then_some(*page),
            under_way: *under_way,
            ssq_before: written(Part::SsqBefore),
            sus: written(Part::Sus),
            own: written(Part::Own),
            ssq_after: written(Part::SsqAfter),
            tasks: tasks.clone(),
        }
    }
}

/// What is written.
#[derive(Clone)]
enum Job {
    Answers(Box<Form>),
    /// What a task came to.
    Made(String, Box<Document>),
}

/// Brings a sitting to the disk.
pub(in crate::app) struct Keeper {
    sitting: Sitting,
    queue: Queue<Job, Result<(), Unwritten>>,
    /// Which state was given to be written last.
    kept: u64,
    /// Tasks whose results are written.
    tasks: usize,
    /// What was made in a task and could not be written.
    lost: Option<String>,
}

/// Why something is not on the disk.
enum Unwritten {
    /// Answers, which are written again with the next page.
    Answers(String),
    /// What a task came to, which is not.
    Made(String),
}

impl Keeper {
    /// # Errors
    /// Where the system gives no thread.
    pub(in crate::app) fn start(sitting: Sitting) -> std::io::Result<Self> {
        let folder = sitting.folder.clone();
        let job = move |job: &Job, _: &AtomicBool| write(job, &folder);
        Ok(Self {
            queue: Queue::start("ramus-study", job)?,
            kept: 0,
            tasks: sitting.study().progress().tasks.len(),
            lost: None,
            sitting,
        })
    }

    /// Writes what is new; gives what could not be written.
    pub(in crate::app) fn follow(&mut self, world: &World) -> Option<String> {
        let study = world.study()?;
        if study.kept() != self.kept {
            let form = self.sitting.form(study);
            // Where too much waits, the next frame asks again.
            if self.queue.ask(Job::Answers(Box::new(form))) {
                self.kept = study.kept();
            }
        }
        if let Some(result) = study.progress().tasks.get(self.tasks) {
            let made = Job::Made(result.task.clone(), Box::new(world.document().clone()));
            self.tasks += usize::from(self.queue.ask(made));
        }
        let failed = self.queue.poll()?.err()?;
        Some(self.told(failed))
    }

    fn told(&mut self, failed: Unwritten) -> String {
        match failed {
            Unwritten::Answers(error) => {
                format!("{error}. The answers are kept in memory and written with the next page.")
            }
            Unwritten::Made(error) => {
                self.lost = Some(error.clone());
                format!("{error}. What was made in the task is in the recording alone.")
            }
        }
    }

    /// Writes all that is not written yet. That answers could not be written before does not matter if they can now.
    pub(in crate::app) fn finish(mut self, world: &World) -> Result<()> {
        self.follow(world);
        while let Some(done) = self.queue.wait() {
            if let Err(failed) = done {
                self.told(failed);
            }
        }
        if let Some(study) = world.study() {
            let form = self.sitting.form(study);
            form.write(&self.sitting.folder.join(ANSWERS))?;
        }
        self.lost.map_or(Ok(()), |lost| bail!(lost))
    }
}

fn write(job: &Job, folder: &Path) -> Result<(), Unwritten> {
    match job {
        Job::Answers(form) => form
            .write(&folder.join(ANSWERS))
            .map_err(|error| Unwritten::Answers(error.to_string())),
        Job::Made(task, document) => {
            let path = folder.join(format!("task-{task}.ramus"));
            write_atomically(&path, &project::to_bytes(document))
                .map_err(|error| Unwritten::Made(error.to_string()))
        }
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
    use crate::app::sentence;
    use crate::world::history::History;
    use crate::world::study::flow::Event;

    #[test]
    fn a_sitting_that_was_killed_goes_on_at_its_page() {
        let folder = tempfile::tempdir().unwrap();
        let of = || Sitting::of(folder.path(), "P1", "ramus", None);
        let first = of().unwrap();
        assert!(
            !first.goes_on && !first.folder.exists(),
            "nothing is written"
        );
        first.make_folder().unwrap();
        let mut world = World::new(History::default());
        world.begin_study(first.study());
        let mut keeper = Keeper::start(first).unwrap();
        world.act_in_study(Event::Next).unwrap();
        world
            .act_in_study(Event::Answer(Part::SsqBefore, 2, 3))
            .unwrap();
        world.act_in_study(Event::Next).unwrap();
        world.act_in_study(Event::Next).unwrap();
        assert_eq!(keeper.follow(&world), None);
        keeper.finish(&world).unwrap();
        let again = of().unwrap();
        assert!(again.goes_on);
        assert_eq!(again.study().progress(), world.study().unwrap().progress());
        assert_eq!(again.study().answer(Part::SsqBefore, 2), Some(3));
        assert_eq!(again.study().place()[0], 3);
    }

    /// A disk that takes nothing for a while costs no answer.
    #[test]
    fn answers_that_could_not_be_written_are_written_later() {
        let folder = tempfile::tempdir().unwrap();
        let sitting = Sitting::of(folder.path(), "P1", "ramus", None).unwrap();
        sitting.make_folder().unwrap();
        let at = sitting.folder.clone();
        let aside = at.with_extension("aside");
        let mut world = World::new(History::default());
        world.begin_study(sitting.study());
        let mut keeper = Keeper::start(sitting).unwrap();
        std::fs::rename(&at, &aside).unwrap();
        world.act_in_study(Event::Next).unwrap();
        let told = (0..1000).find_map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(5));
            keeper.follow(&world)
        });
        let told = told.unwrap();
        assert!(told.ends_with("written with the next page."), "{told}");
        std::fs::rename(&aside, &at).unwrap();
        keeper.finish(&world).unwrap();
        let again = Sitting::of(folder.path(), "P1", "ramus", None).unwrap();
        assert_eq!(again.progress.page, 1);
    }

    #[test]
    fn what_cannot_be_begun_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let of = |study: &Path, participant: &str, tasks: Option<&Path>| {
            sentence(&Sitting::of(study, participant, "ramus", tasks).unwrap_err())
        };
        let told = of(path, "../P1", None);
        assert!(told.contains("\"../P1\" is not of letters"), "{told}");
        let file = path.join("file");
        std::fs::write(&file, "x").unwrap();
        let told = of(&file, "P1", None);
        assert!(told.contains("is no folder"), "{told}");
        let sitting = Sitting::of(path, "P1", "ramus", None).unwrap();
        sitting.make_folder().unwrap();
        let tasks = path.join("other.json");
        std::fs::write(&tasks, "{\"format\":\"ramus-study-tasks/1\",\"tasks\":[]}").unwrap();
        let told = of(path, "P1", Some(&tasks));
        assert!(told.contains("P1 has begun with other tasks"), "{told}");
        let answers = sitting.folder.join(ANSWERS);
        let text = std::fs::read_to_string(&answers).unwrap();
        std::fs::write(&answers, text.replace("\"page\": 0", "\"page\": null")).unwrap();
        let told = of(path, "P1", None);
        assert!(
            told.contains("P1 has finished under the condition ramus"),
            "{told}"
        );
        std::fs::write(&answers, text.replace("P1", "P2")).unwrap();
        let told = of(path, "P1", None);
        assert!(told.contains("is of the participant P2"), "{told}");
        std::fs::write(&answers, text).unwrap();
        std::fs::remove_file(sitting.folder.join(TASKS)).unwrap();
        let told = of(path, "P1", None);
        assert!(
            told.contains("the tasks that the sitting was begun with are not there"),
            "{told}"
        );
    }
}
