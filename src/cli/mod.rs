//! The command line: one file a subcommand; argument parsing and printing only.

use std::process::ExitCode;

/// Runs the program and returns its exit code: 0 done, 1 the input or the
/// machine is at fault (one sentence on standard error), 2 wrong usage.
pub fn run() -> ExitCode {
    ExitCode::SUCCESS
}
