//! `ramus fmt`: grammar files in the canonical layout.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use clap::Args as ClapArgs;

use super::inputs::{grammar_text, standard_input};
use super::{print_result, sentence};
use crate::lsystem::format;
use crate::tree::file::write_atomically;

/// What messages call standard input.
const STANDARD_INPUT: &str = "standard input";

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// Grammar files (.lsys), or `-` for standard input, which is written to standard output
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write nothing; name the files that would change, and end with 1 if there are any
    #[arg(long)]
    check: bool,
}

/// What became of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Outcome {
    AsItWas,
    Changed,
}

pub(super) fn run(args: &Args) -> Result<()> {
    let (mut faults, mut changed) = (Vec::new(), 0);
    for path in &args.files {
        match lay_out(path, args.check) {
            Ok(Outcome::AsItWas) => {}
            Ok(Outcome::Changed) => changed += 1,
            Err(error) => faults.push(sentence(&error)),
        }
    }
    if args.check && changed > 0 {
        let (are, lays) = match changed {
            1 => ("file is", "`ramus fmt` lays it out"),
            _ => ("files are", "`ramus fmt` lays them out"),
        };
        faults.push(format!(
            "{changed} {are} not in the canonical layout; {lays}"
        ));
    }
    match faults.is_empty() {
        true => Ok(()),
        false => Err(anyhow!(faults.join("\nramus: "))),
    }
}

/// Lays one file out; with `check` it is only named where it would change.
fn lay_out(path: &Path, check: bool) -> Result<Outcome> {
    let piped = path == Path::new("-");
    let name = match piped {
        true => STANDARD_INPUT.to_owned(),
        false => path.display().to_string(),
    };
    let text = match piped {
        true => standard_input(&name)?,
        false => grammar_text(path)?,
    };
    let laid_out = format(&text, &name)?;
    let outcome = match laid_out == text {
        true => Outcome::AsItWas,
        false => Outcome::Changed,
    };
    if check {
        if outcome == Outcome::Changed {
            print_result("the names", |out| writeln!(out, "{name}"))?;
        }
    } else if piped {
        print_result("the grammar", |out| out.write_all(laid_out.as_bytes()))?;
    } else if outcome == Outcome::Changed {
        write_atomically(path, laid_out.as_bytes())?;
        tell!("{name}");
    }
    Ok(outcome)
}
