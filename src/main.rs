//! The `ramus` program: parses the command line and hands over to [`ramus::cli`].
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ramus::cli::run()
}
