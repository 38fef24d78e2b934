//! The command line: one file a subcommand; argument parsing and printing only.

/// Tells the person something on standard output. Nobody listening (a closed pipe, a full disk) must not end the work.
macro_rules! tell {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($part)*);
    }};
}

/// The same on standard error: remarks that are not the result.
macro_rules! whisper {
    ($($part:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($part)*);
    }};
}

mod abstraction;
mod analyze;
mod cohort;
mod compare;
mod derive;
mod doctor;
mod explain;
mod export;
mod fmt;
mod import;
mod inputs;
mod inspect;
mod moment;
mod outputs;
mod progress;
mod replay;
mod study;
mod trees;
mod unwritten;
mod workshop;

use std::io::{BufWriter, ErrorKind, IsTerminal as _, StdoutLock, Write as _};
use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::{Parser, Subcommand};

use crate::app::sentence;

/// What `ramus` is asked to do.
#[derive(Debug, Parser)]
#[command(
    name = "ramus",
    version,
    args_conflicts_with_subcommands = true,
    about = "The VR workshop for branching structures: sketch a tree, watch it grow as an L-system, take it home.",
    after_help = "Without a subcommand the workshop starts: in the headset where an OpenXR runtime answers,\n\
        else in a window where there is a desktop, else on the built-in simulated headset, which plays a recorded session and leaves pictures,\n\
        the project file, its grammar and a GLB in out/. A project there that differs is kept beside the new one.\n\n\
        Examples:\n  \
        ramus                                         start the workshop\n  \
        ramus --project oak.ramus                     go on with a project\n  \
        ramus --headset window                        with mouse and keyboard, even where there is a headset\n  \
        ramus replay assets/sessions/first-tree.session --png out\n  \
        ramus derive assets/grammars/honda.lsys --steps 10 --export tree.glb\n  \
        ramus fmt *.lsys                              lay grammars out in the canonical way\n  \
        ramus inspect duct.ply                        what a scanned model is like and what is wrong with it\n  \
        ramus analyze duct.ply --png duct.png         its centerlines, measured and drawn\n  \
        ramus cohort models --groups groups.csv --out results\n  \
        ramus compare duct.ply duct.lsys --png both.png   how alike they are\n  \
        ramus abstract duct.ply --grammar duct.lsys   an L-system whose trees have its statistics\n  \
        ramus export tree.ramus --format glb --count 20 --out grove   twenty of a kind\n  \
        ramus doctor                                  what this machine has and what it lacks"
)]
struct Cli {
    #[command(flatten)]
    workshop: workshop::Args,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Starts the workshop and records its session; the same as --record.
    Record(workshop::RecordArgs),
    /// Plays a recorded session through the workshop and keeps what it made.
    Replay(replay::Args),
    /// Derives a grammar file and prints or exports what grew.
    Derive(derive::Args),
    /// Lays grammar files out in the canonical way.
    Fmt(fmt::Args),
    /// Writes a grammar of cpfg, L-Py or Houdini in the notation of Ramus.
    Import(import::Args),
    /// Says what a scanned model is like and what is wrong with it.
    Inspect(inspect::Args),
    /// Finds a scanned model's centerlines and measures them.
    Analyze(analyze::Args),
    /// Analyzes several models into one table and compares groups of them.
    Cohort(cohort::Args),
    /// Compares trees: scans, skeletons, grammars, sketches.
    Compare(compare::Args),
    /// Makes an L-system whose trees have a model's statistics.
    Abstract(abstraction::Args),
    /// Writes a project's or a grammar's tree for other programs, in levels of detail and many individuals.
    Export(export::Args),
    /// Runs a study with participants: what they answered, scored and compared.
    Study(study::Args),
    /// Says what this machine has for Ramus and how to mend what is missing.
    Doctor,
}

/// Runs the program and returns its exit code: 0 done, 1 the input or the
/// machine is at fault (one sentence on standard error), 2 wrong usage.
pub fn run() -> ExitCode {
    ramus_xr::openxr::quiet_loader();
    log_to_standard_error();
    let cli = Cli::parse();
    let result = check_threads().and_then(|()| started(cli));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // A closed pipe on standard error leaves nobody to tell.
            let _ = writeln!(std::io::stderr(), "ramus: {}", sentence(&error));
            ExitCode::FAILURE
        }
    }
}

/// Threads that may be asked for: each takes time and memory to begin, and hundreds of thousands take all of it.
const THREADS_MOST: usize = 1024;

fn check_threads() -> Result<()> {
    let asked = std::env::var("RAYON_NUM_THREADS").unwrap_or_default();
    let asked: usize = asked.parse().unwrap_or(0);
    ensure!(
        asked <= THREADS_MOST,
        "RAYON_NUM_THREADS asks for {asked} threads: set it to {THREADS_MOST} at most, or leave it unset for as many as there are cores"
    );
    Ok(())
}

fn started(cli: Cli) -> Result<()> {
    match cli.command {
        None => workshop::run(&cli.workshop),
        Some(Command::Record(args)) => workshop::record(args),
        Some(Command::Replay(args)) => replay::run(&args),
        Some(Command::Derive(args)) => derive::run(&args),
        Some(Command::Fmt(args)) => fmt::run(&args),
        Some(Command::Import(args)) => import::run(&args),
        Some(Command::Inspect(args)) => inspect::run(&args, inspect::load),
        Some(Command::Analyze(args)) => analyze::run(&args, inspect::load),
        Some(Command::Cohort(args)) => cohort::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Abstract(args)) => abstraction::run(&args, inspect::load),
        Some(Command::Export(args)) => export::run(&args),
        Some(Command::Study(args)) => study::run(&args),
        Some(Command::Doctor) => doctor::run(),
    }
}

/// Prints what was asked for on standard output. That nobody reads on (a closed pipe, as `head` leaves it) is no fault.
///
/// # Errors
/// Whatever else standard output fails in; `what` says what was printed.
fn print_result(
    what: &str,
    write: impl FnOnce(&mut BufWriter<StdoutLock<'_>>) -> std::io::Result<()>,
) -> Result<()> {
    let mut out = BufWriter::new(std::io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            // What is left in the buffer is not tried again when it is dropped.
            let _ = out.into_parts();
            Err(anyhow::anyhow!(
                "standard output does not take {what} ({error}): free some space or send it elsewhere"
            ))
        }
        _ => Ok(()),
    }
}

/// Warnings go to standard error; `RAMUS_LOG` (as `RUST_LOG`) asks for more or less.
fn log_to_standard_error() {
    let filter = tracing_subscriber::EnvFilter::try_from_env("RAMUS_LOG")
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("warn,winit=error"));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_target(false)
        .init();
}
