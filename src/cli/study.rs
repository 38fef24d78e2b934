//! `ramus study`: a study with participants, held and scored.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::{Args as ClapArgs, Subcommand, ValueEnum};

use super::outputs::not_over_each_other;
use super::print_result;
use super::workshop::{StudyArgs, Which, sit};
use crate::app::study::answers::ANSWERS;
use crate::app::study::picture::picture;
use crate::app::study::report::report;
use crate::app::study::sitting::Sitting;
use crate::app::study::told::told;
use crate::app::study::{Study, paper};
use crate::tree::file::{check_place, write_atomically};
use crate::ui::words::Language;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Holds the sitting of a participant, in a headset or a window: questions, tasks, questions.
    Run(RunArgs),
    /// Prints the scores of a study and what they differ in.
    Report(ReportArgs),
}

#[derive(Debug, ClapArgs)]
struct RunArgs {
    /// The study's folder, which is made where there is none
    folder: PathBuf,
    /// The participant's code: letters, digits, - and _
    #[arg(long, value_name = "CODE")]
    participant: String,
    /// What is worked with, where the study compares several things
    #[arg(long, value_name = "NAME", default_value = "ramus")]
    condition: String,
    /// The tasks (ramus-study-tasks/1); without, three that Ramus brings along
    #[arg(long, value_name = "FILE.json")]
    tasks: Option<PathBuf>,
    /// The language of the panels; without, the one that was set last on this machine
    #[arg(long, value_name = "LANGUAGE")]
    language: Option<Tongue>,
    /// Which headset to use, or a window instead
    #[arg(long, value_enum, default_value_t = Which::Auto, value_name = "WHICH")]
    headset: Which,
    /// How long to wait for a runtime that is lost in the middle of the work, which is saved first; 0: not at all
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u64).range(..=86_400))]
    patience: u64,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Tongue {
    /// English
    English,
    /// German
    German,
}

#[derive(Debug, ClapArgs)]
struct ReportArgs {
    /// The study's folder, or a table of raw answers (CSV): participant, condition, sus_1 to sus_10, ssq_before_1 to ssq_before_16, ssq_after_1, …
    source: PathBuf,
    /// Print the report as JSON (ramus-study-report/1)
    #[arg(long)]
    json: bool,
    /// Write all answers and scores as one table, which this command reads, too
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Draw usability by conditions, and sickness before and after
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// In the table, answers to the SSQ are 1 none to 4 severe, not 0 to 3
    #[arg(long)]
    ssq_from_one: bool,
}

pub(super) fn run(args: &Args) -> Result<()> {
    match &args.command {
        Command::Run(args) => hold(args),
        Command::Report(args) => print_report(args),
    }
}

fn hold(args: &RunArgs) -> Result<()> {
    let tasks = args.tasks.as_deref();
    sit(StudyArgs {
        sitting: Sitting::of(&args.folder, &args.participant, &args.condition, tasks)?,
        language: args.language.map(|tongue| match tongue {
            Tongue::English => Language::English,
            Tongue::German => Language::German,
        }),
        headset: args.headset,
        patience: args.patience,
    })
}

fn print_report(args: &ReportArgs) -> Result<()> {
    let outputs = || args.csv.iter().chain(&args.svg).map(PathBuf::as_path);
    not_over_each_other(Some(&args.source), outputs(), None)?;
    for output in outputs() {
        ensure!(
            output.file_name().is_none_or(|name| name != ANSWERS),
            "{} would be written over a participant's answers: choose another name",
            output.display()
        );
        check_place(output)?;
    }
    let study = Study::read(&args.source, args.ssq_from_one)?;
    for remark in study.failed.iter().chain(&study.remarks) {
        whisper!("{remark}");
    }
    let failed = study.failed.len();
    ensure!(
        !study.sittings.is_empty(),
        "no answers in {} can be read",
        args.source.display()
    );
    if let Some(csv) = &args.csv {
        write_atomically(csv, &paper::table(&study)?)?;
    }
    let report = report(&study);
    if let Some(svg) = &args.svg {
        write_atomically(svg, picture(&study, &report).as_bytes())?;
    }
    let text = match args.json {
        true => serde_json::to_string_pretty(&report)? + "\n",
        false => told(&report),
    };
    print_result("the report", |to| to.write_all(text.as_bytes()))?;
    ensure!(
        failed == 0,
        "{failed} of {} files of answers could not be read and {} not in the report",
        failed + study.sittings.len(),
        if failed == 1 { "is" } else { "are" }
    );
    Ok(())
}
