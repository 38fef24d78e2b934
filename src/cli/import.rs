//! `ramus import`: a grammar of another program written in the notation of Ramus.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::{Result, anyhow};
use clap::Args as ClapArgs;

use super::inputs::grammar_text;
use super::outputs::{check_places, not_over_each_other};
use super::print_result;
use crate::lsystem::dialect::{self, Dialect};
use crate::tree::file::write_atomically;

#[derive(Debug, ClapArgs)]
pub(super) struct Args {
    /// The grammar file of cpfg (.l), L-Py (.lpy) or Houdini (rules and parameters as text)
    file: PathBuf,
    /// The program that it is of; without it the file's first line (`dialect houdini`) or its ending tells
    #[arg(long, value_name = "DIALECT")]
    dialect: Option<Dialect>,
    /// The grammar file to write; without it the text is printed
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

pub(super) fn run(args: &Args) -> Result<()> {
    not_over_each_other(
        Some(&args.file),
        args.output.iter().map(PathBuf::as_path),
        None,
    )?;
    let text = grammar_text(&args.file)?;
    let told = args.dialect.or_else(|| dialect::named(&text));
    let dialect = told
        .or_else(|| Dialect::of_ending(&args.file))
        .ok_or_else(|| {
            anyhow!(
                "{} does not tell which program it is of: give --dialect cpfg, lpy or houdini",
                args.file.display()
            )
        })?;
    let name = args.file.display().to_string();
    let imported = dialect::import(&text, &name, dialect).map_err(|errors| anyhow!("{errors}"))?;
    for remark in &imported.remarks {
        whisper!("{remark}");
    }
    match &args.output {
        Some(path) => {
            check_places([path])?;
            Ok(write_atomically(path, imported.text.as_bytes())?)
        }
        None => print_result("the grammar", |out| out.write_all(imported.text.as_bytes())),
    }
}
