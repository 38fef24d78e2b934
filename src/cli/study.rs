//! `ramus study`: what a study with participants comes to.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::{Args as ClapArgs, Subcommand};

use super::outputs::not_over_each_other;
use super::print_result;
use crate::app::study::report::report;
use crate::app::study::told::told;
use crate::app::study::{Study, paper};
use crate::tree::file::{check_place, write_atomically};

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Prints the scores of a study and what they differ in.
    Report(ReportArgs),
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
    /// In the table, answers to the SSQ are 1 none to 4 severe, not 0 to 3
    #[arg(long)]
    ssq_from_one: bool,
}

pub(super) fn run(args: &Args) -> Result<()> {
    match &args.command {
        Command::Report(args) => print_report(args),
    }
}

fn print_report(args: &ReportArgs) -> Result<()> {
    if let Some(csv) = &args.csv {
        not_over_each_other(Some(&args.source), [csv.as_path()], None)?;
        check_place(csv)?;
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
