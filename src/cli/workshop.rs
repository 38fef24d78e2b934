//! `ramus`: the workshop, in the headset that answers, else in a window on the desktop, else as a demonstration on the
//! simulated headset.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use clap::{Args as ClapArgs, ValueEnum};
use ramus_xr::Headset;
use ramus_xr::record::Tape;
use ramus_xr::session::SessionError;
use ramus_xr::simulated::Simulated;

use super::outputs::{both, check_places, not_over_each_other, set_aside};
use super::progress::Progress;
use super::replay::EXTENT;
use crate::app::again::Patience;
use crate::app::album::Album;
use crate::app::headset::{self, News};
use crate::app::opening::Opening;
use crate::app::person::Person;
use crate::app::picture::Picture;
use crate::app::session::{self, Nobody, SessionEnd};
use crate::app::store::{Store, keep_older, older_one, read_project};
use crate::app::study::sitting::Sitting;
use crate::app::takeaway::free_name;
use crate::app::workshop::{Workshop, WorkshopParams};
use crate::app::{demonstration, portrait, take_home, window};
use crate::ui::words::Language;
use crate::world::World;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The project to go on with, or to begin (which takes a headset or a window)
    #[arg(long, value_name = "FILE.ramus")]
    project: Option<PathBuf>,
    /// A scanned model to bring onto the stage (may be given more than once; takes a headset or a window)
    #[arg(long, value_name = "FILE")]
    model: Vec<PathBuf>,
    /// Where pictures and exports go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Record the session into this new file, to be played by `ramus replay`
    #[arg(long, value_name = "FILE.session")]
    record: Option<PathBuf>,
    /// Which headset to use, or a window instead
    #[arg(long, value_enum, default_value_t = Which::Auto, value_name = "WHICH")]
    headset: Which,
    /// How long to wait for a runtime that is lost in the middle of the work, which is saved first; 0: not at all
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u64).range(..=86_400))]
    patience: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Which {
    /// The one behind the OpenXR runtime, else a window where there is a desktop, else the simulated one
    Auto,
    /// The one behind the OpenXR runtime, or an error
    Openxr,
    /// A window on the desktop, with mouse and keyboard, or an error
    Window,
    /// The built-in one, which needs no device
    Simulated,
}

/// `ramus record FILE`: the workshop with a recording, which `--record` asks for too.
#[derive(Debug, ClapArgs)]
pub(super) struct RecordArgs {
    /// The session is recorded into this new file, to be played by `ramus replay`
    #[arg(value_name = "FILE.session")]
    session: PathBuf,
    /// The project to go on with, or to begin (which takes a headset or a window)
    #[arg(long, value_name = "FILE.ramus")]
    project: Option<PathBuf>,
    /// A scanned model to bring onto the stage (may be given more than once; takes a headset or a window)
    #[arg(long, value_name = "FILE")]
    model: Vec<PathBuf>,
    /// Where pictures and exports go
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Which headset to use, or a window instead
    #[arg(long, value_enum, default_value_t = Which::Auto, value_name = "WHICH")]
    headset: Which,
    /// How long to wait for a runtime that is lost in the middle of the work, which is saved first; 0: not at all
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u64).range(..=86_400))]
    patience: u64,
}

pub(super) fn record(args: RecordArgs) -> Result<()> {
    run(&Args {
        project: args.project,
        model: args.model,
        out: args.out,
        record: Some(args.session),
        headset: args.headset,
        patience: args.patience,
    })
}

pub(super) fn run(args: &Args) -> Result<()> {
    keep_apart(args)?;
    if let Some(door) = door(args)? {
        return at_work(door, args, None);
    }
    ensure!(
        args.model.is_empty(),
        "models are brought onto the stage in a headset or a window, and there is neither: `ramus inspect` looks at a model without"
    );
    match &args.project {
        Some(_) if args.record.is_some() => {
            bail!(
                "a project is only looked at without a headset, so there is no session to record: leave --record out"
            )
        }
        Some(project) => look_at(project, &args.out),
        None => demonstrate(&args.out, args.record.as_deref()),
    }
}

/// The sitting of a study: a session in its folder, recorded there.
#[derive(Debug)]
pub(super) struct StudyArgs {
    /// The sitting.
    pub(super) sitting: Sitting,
    /// In which language, where not in the person's who has set this machine up.
    pub(super) language: Option<Language>,
    /// Which headset to use, or a window instead.
    pub(super) headset: Which,
    /// How long a runtime is waited for that is lost, seconds.
    pub(super) patience: u64,
}

/// The project and the recording of a sitting, in its folder.
const PROJECT: &str = "project.ramus";
const SESSION: &str = "session";

pub(super) fn sit(study: StudyArgs) -> Result<()> {
    let folder = &study.sitting.folder;
    let args = Args {
        project: Some(folder.join(PROJECT)),
        model: Vec::new(),
        out: folder.clone(),
        record: Some(free_name(&folder.join(SESSION), "session", |_| false)),
        headset: study.headset,
        patience: study.patience,
    };
    // Before anything is written: without a door there is no sitting.
    let door = door(&args)?;
    let Some(door) = door else {
        bail!(
            "a study takes a headset or a window, and there is neither: `ramus doctor` says what is missing"
        );
    };
    study.sitting.make_folder()?;
    at_work(door, &args, Some(study))
}

/// Where a person works: in a headset or at a window.
enum Door {
    Headset(Box<headset::Opened>),
    Window(Box<window::Opened>),
}

/// The door that was asked for, or the best that opens; none: the simulated headset.
fn door(args: &Args) -> Result<Option<Door>> {
    let which = args.headset;
    if matches!(which, Which::Auto | Which::Openxr) {
        match headset::connect() {
            Ok(system) => {
                let opened = headset::Opened::start(system)?;
                return Ok(Some(Door::Headset(Box::new(opened))));
            }
            Err(error) if which == Which::Openxr => return Err(error.into()),
            Err(error) => tell!("No headset: {error}."),
        }
    }
    let desktop = ["DISPLAY", "WAYLAND_DISPLAY"]
        .map(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()));
    if which == Which::Window || which == Which::Auto && desktop.contains(&true) {
        match open_window(args) {
            Ok(opened) => return Ok(Some(Door::Window(Box::new(opened)))),
            Err(error) if which == Which::Window => return Err(error.into()),
            Err(error) => tell!("No window: {error}."),
        }
    }
    Ok(None)
}

/// The project that is worked on.
fn worked_on(args: &Args) -> PathBuf {
    let default = || args.out.join(WORKSHOP);
    args.project.clone().unwrap_or_else(default)
}

fn open_window(args: &Args) -> Result<window::Opened, window::OpenError> {
    let project = worked_on(args);
    let name = project.file_name().unwrap_or_default().to_string_lossy();
    let [glb, ..] = beside(&project);
    let files = window::Files {
        picture: args.out.join(project.file_stem().unwrap_or_default()),
        tree: Some(glb),
    };
    window::Opened::open(&format!("{name} – Ramus"), files)
}

/// Refuses names that a session would write over each other, with a headset and without one.
fn keep_apart(args: &Args) -> Result<()> {
    let (project, out) = (args.project.as_deref(), &args.out);
    let record = args.record.as_deref();
    let worn = project.map_or_else(|| out.join(WORKSHOP), Path::to_owned);
    let mut made = beside(&worn).to_vec();
    made.extend(project.is_none().then_some(worn));
    not_over_each_other(
        project,
        made.iter().map(PathBuf::as_path).chain(record),
        None,
    )?;
    let mut shown = match project {
        Some(project) => vec![tree_of(project, out), Store::journal_of(project)],
        None => beside(&out.join(FIRST_TREE)).to_vec(),
    };
    shown.extend(project.is_none().then(|| out.join(FIRST_TREE)));
    let shown = shown.iter().map(PathBuf::as_path).chain(record);
    not_over_each_other(project, shown, Some(out))
}

/// What a session writes beside its project: the tree, its grammar, and the journal.
fn beside(project: &Path) -> [PathBuf; 3] {
    let [glb, lsys] = ["glb", "lsys"].map(|ending| project.with_extension(ending));
    [glb, lsys, Store::journal_of(project)]
}

/// The project of a headset's session, in the folder for results, where none was named.
const WORKSHOP: &str = "workshop.ramus";

/// The demonstration's project, in the same folder.
const FIRST_TREE: &str = "first-tree.ramus";

fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))
}

/// The workshop itself.
fn at_work(door: Door, args: &Args, study: Option<StudyArgs>) -> Result<()> {
    let project = worked_on(args);
    if args.project.is_none() {
        make_folder(&args.out)?;
    }
    let [glb, lsys, _] = beside(&project);
    check_places([&project, &glb, &lsys])?;
    check_recording(args.record.as_deref())?;
    match &door {
        Door::Headset(opened) => tell!("In the headset: {}.", opened.describe()),
        Door::Window(opened) => tell!(
            "In {}: left button draws, right moves, middle turns the view, G grows, H tells the rest, Esc saves and ends.",
            opened.describe()
        ),
    }
    let store = Store::open(&project)?;
    if let Some(message) = &store.message {
        tell!("{message}");
    }
    let mut workshop = Workshop::new(store, WorkshopParams::default())?;
    let mut person = Person::here();
    let is_study = study.is_some();
    match study {
        None => person.enter(&mut workshop),
        Some(study) => begin_sitting(study, &person, &mut workshop)?,
    }
    workshop.offer_models();
    for model in &args.model {
        workshop.bring_model(model);
    }
    if args.record.is_some() {
        // What a recording begins with is all there.
        workshop.finish_models();
    }
    let tape = args.record.as_deref().map(recording).transpose()?;
    let mut tape = tape.map(|tape| begin_recording(tape, &mut workshop));
    let patience = Patience::of(Duration::from_secs(args.patience));
    let outcome = door.run(&mut tape, &mut workshop, &project, &patience);
    let recorded = match (tape, &args.record) {
        (Some(tape), Some(path)) => end_recording(tape.finish(), path),
        _ => Ok(()),
    };
    // However the session and its recording ended, the work is saved first.
    workshop.finish_tree();
    let answered = workshop.rise();
    // Another one may have been taken up meanwhile.
    let project = workshop.project().map_or(project, Path::to_owned);
    // What a participant set and made is the study's, and not of whoever set this machine up.
    if !is_study && let Err(problem) = person.leave(&workshop, &project) {
        tell!("{problem}");
    }
    let kept = both(answered, take_home_all(workshop, &project));
    let outcome = outcome.map_err(|error| match kept {
        Ok(()) => anyhow!("{error}; your work is saved in {}", project.display()),
        Err(_) => error.into(),
    });
    both(kept, both(outcome, recorded))
}

/// A participant sits down: the room is as it was set here, and the pages begin or go on.
fn begin_sitting(study: StudyArgs, person: &Person, workshop: &mut Workshop) -> Result<()> {
    let mut settings = person.settings();
    settings.language = study.language.unwrap_or(settings.language);
    workshop.set(settings);
    let [page, pages] = study.sitting.study().place();
    tell!(
        "{} under {}, page {page} of {pages}; answers are kept in {}.",
        study.sitting.participant,
        study.sitting.condition,
        study.sitting.folder.display()
    );
    Ok(workshop.sit(study.sitting)?)
}

/// Says what the recording begins with; it stays with that project.
fn begin_recording(tape: Tape<Recording>, workshop: &mut Workshop) -> Tape<Recording> {
    workshop.stay_in_project();
    let comments = Opening::of(workshop).comments();
    comments.iter().fold(tape, |tape, it| tape.with_comment(it))
}

impl Door {
    /// Runs a session to its end, whatever comes and goes meanwhile.
    fn run(
        self,
        tape: &mut Option<Tape<Recording>>,
        workshop: &mut Workshop,
        project: &Path,
        patience: &Patience,
    ) -> Result<(), SessionEnd> {
        match self {
            Self::Headset(opened) => {
                let told = |news| tell_news(&news, project);
                headset::keep_going(*opened, tape, workshop, patience, told)
            }
            Self::Window(opened) => {
                window::Opened::welcome(workshop);
                let Some(rolling) = tape.take() else {
                    return opened.run(|window| window, workshop, &mut Nobody).1;
                };
                let around = |window| rolling.around(window);
                let (recorder, outcome) = opened.run(around, workshop, &mut Nobody);
                *tape = Some(recorder.take_off().1);
                outcome
            }
        }
    }
}

fn tell_news(news: &News, project: &Path) {
    let (why, saved, wait) = match news {
        News::Back(headset) => return tell!("In the headset again: {headset}."),
        News::Lost { why, saved, wait } => (why, saved, wait.as_secs()),
    };
    let kept = match saved {
        Ok(()) => format!("your work is saved in {}", project.display()),
        Err(error) => format!("your work is in the journal ({error})"),
    };
    tell!(
        "Lost: {why}; {kept}. Ramus goes on when the runtime is back within {wait} s (Ctrl-C ends it)."
    );
}

fn take_home_all(workshop: Workshop, project: &Path) -> Result<()> {
    let world = workshop.close()?;
    tell!(
        "Saved {}: {}.",
        project.display(),
        take_home::summary(&world)
    );
    if world.document().step > 0 {
        let [glb, lsys, _] = beside(project);
        take_home::export(world.document(), &glb)?;
        tell!("The tree is in {}.", glb.display());
        take_home::grammar(world.document(), &lsys)?;
        tell!("Its grammar is in {}.", lsys.display());
    }
    Ok(())
}

/// A recording that is being written.
type Recording = BufWriter<File>;

/// Sessions are not made again: an older one is never written over.
fn check_recording(path: Option<&Path>) -> Result<()> {
    let Some(path) = path else { return Ok(()) };
    ensure!(
        path.symlink_metadata().is_err(),
        "cannot record the session into {}: the file exists, and a session cannot be made again: choose another name",
        path.display()
    );
    check_places([&path.to_owned()])
}

fn recording(path: &Path) -> Result<Tape<Recording>> {
    let file = File::create_new(path)
        .with_context(|| format!("cannot record the session into {}", path.display()))?;
    Ok(Tape::new(BufWriter::new(file)))
}

/// Ends a recording. Its failure touches nothing else that the session makes, so it is told at the end.
fn end_recording(written: Result<Recording, SessionError>, path: &Path) -> Result<()> {
    if let Err(error) = written {
        let room = match error {
            SessionError::Io(_) => "free some space or choose another disk, and ",
            _ => "",
        };
        bail!(
            "the recording {} is not whole ({error}): {room}record again under another name",
            path.display()
        );
    }
    tell!("  session   {}", path.display());
    Ok(())
}

/// Without a headset and without a project: a recorded session shows what the workshop is.
fn demonstrate(out: &Path, record: Option<&Path>) -> Result<()> {
    tell!("Playing the recorded session first-tree on the built-in simulated headset …");
    let frames = demonstration::first_tree()?;
    let total = frames.len();
    let project = out.join(FIRST_TREE);
    let [glb, lsys, _] = beside(&project);
    // Whatever may be missing is asked for before the project is touched.
    let gpu = portrait::open_gpu()?;
    let mut picture = Picture::offscreen(&gpu, EXTENT.width, EXTENT.height)?;
    let mut headset = Simulated::new(frames, EXTENT);
    let mut progress = Progress::new("playing");
    let mut album = Album::new(Some(out), Box::new(|frame| progress.show(frame, total)))?;
    check_places([&glb, &lsys])?;
    check_recording(record)?;
    let opened = Store::begin(&project)?;
    if let Some(message) = &opened.message {
        tell!("{message}");
    }
    let mut workshop = Workshop::new(opened, WorkshopParams::default())?;
    let mut play = |headset: &mut dyn Headset| {
        let outcome = session::run(headset, &mut workshop, Some(&mut picture), &mut album);
        outcome.map_err(anyhow::Error::from)
    };
    let (outcome, recorded) = match record.map(|path| (path, recording(path))) {
        None => (play(&mut headset), Ok(())),
        Some((_, Err(error))) => (Err(error), Ok(())),
        Some((path, Ok(tape))) => {
            let mut recorder = tape.around(headset);
            let outcome = play(&mut recorder);
            (outcome, end_recording(recorder.finish().1, path))
        }
    };
    let steps = album.steps().clone();
    drop(album);
    drop(progress);
    workshop.finish_tree();
    let kept = outcome.and_then(|()| Ok(keep_older(&project, workshop.document())?));
    let older = match kept {
        Ok(older) => older,
        Err(error) => return both(Err(set_aside(workshop, Some(&project), &error)), recorded),
    };
    let shown = show(workshop, out, steps.len(), older.as_deref());
    both(shown, recorded)
}

/// Writes and tells what a demonstration made.
fn show(workshop: Workshop, out: &Path, steps: usize, older: Option<&Path>) -> Result<()> {
    let project = out.join(FIRST_TREE);
    let [glb, lsys, _] = beside(&project);
    let world = workshop.close()?;
    if let Some(older) = older {
        tell!(
            "Another project was in {}: it is kept as {}.",
            project.display(),
            older.display()
        );
    }
    take_home::export(world.document(), &glb)?;
    take_home::grammar(world.document(), &lsys)?;
    tell!(
        "A tree was drawn with two controllers and grown: {}.",
        take_home::summary(&world)
    );
    tell(out, &format!("{steps} growth steps"), Some(&project), &glb);
    tell!("  grammar   {}", lsys.display());
    tell!(
        "With a headset or on a desktop the same command starts the workshop in it; `ramus doctor` says what is missing."
    );
    Ok(())
}

/// Where the tree of a project goes that is only looked at.
fn tree_of(project: &Path, out: &Path) -> PathBuf {
    out.join(project.file_stem().unwrap_or_default())
        .with_extension("glb")
}

/// Without a headset, a project: its growth steps pictured, and the tree exported. The project stays as it
/// is, but for what a killed session left in its journal.
fn look_at(project: &Path, out: &Path) -> Result<()> {
    ensure!(
        project.exists() || Store::has_journal(project),
        "there is no project {}, and it takes a headset or a window to begin one: start the headset's runtime (`ramus doctor` says what is missing), look at the name, or leave --project out to see what Ramus does",
        project.display()
    );
    let glb = tree_of(project, out);
    make_folder(out)?;
    check_places([&glb, &out.join(Album::file_name(0))])?;
    let document = if Store::has_journal(project) {
        let opened = Store::open(project)?;
        if let Some(message) = &opened.message {
            tell!("{message}");
        }
        let document = opened.history.committed().clone();
        opened.store.close(&document)?;
        document
    } else {
        let document = read_project(project)?;
        if let Some(message) = older_one(project, &document) {
            tell!("{message}");
        }
        document
    };
    demonstration::check_size(&document)?;
    let gpu = portrait::open_gpu()?;
    let mut picture = Picture::offscreen(&gpu, EXTENT.width, EXTENT.height)?;
    let mut progress = Progress::new("drawing");
    let models = project.parent().unwrap_or(Path::new(""));
    let pictures =
        demonstration::every_step(&document, models, &mut picture, out, |step, most| {
            progress.show(step, most);
        })?;
    drop(progress);
    let world = World::new(crate::world::history::History::new(document));
    tell!("{}: {}.", project.display(), take_home::summary(&world));
    if world.document().step > 0 {
        take_home::export(world.document(), &glb)?;
        let all = world.document().step as usize + 1;
        let of_them = if pictures == all {
            format!("{all} growth steps")
        } else {
            format!("{pictures} of {all} growth steps, evenly chosen")
        };
        tell(out, &of_them, None, &glb);
    } else {
        tell!("It has not grown yet: pictures are in {}.", out.display());
    }
    Ok(())
}

fn tell(out: &Path, steps: &str, project: Option<&Path>, glb: &Path) {
    tell!(
        "  pictures  {} ({steps}, left and right eye)",
        out.join("step-*.png").display()
    );
    if let Some(project) = project {
        tell!("  project   {}", project.display());
    }
    tell!("  tree      {}", glb.display());
}
