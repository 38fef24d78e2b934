//! Brings a test to where Monado is.
//!
//! A test calls [`run`] with its own name and its body. Outside, the test's binary is started again by
//! `enter.sh`, for this one test, and its verdict is passed on; inside, the body runs. So `cargo nextest run`
//! runs and counts these tests like any others. Where there is no runtime a test says why it is skipped;
//! under `CI=true` that is a failure.

use std::{
    env, fmt,
    path::{Path, PathBuf},
    process::Command,
};

/// Set by `enter.sh` in everything that it runs.
const ENTERED: &str = "RAMUS_ENTERED";

/// Exit code of `enter.sh` where there is no runtime.
const NO_RUNTIME: i32 = 3;

/// Why a test could not be brought to the runtime.
#[derive(thiserror::Error)]
pub enum StageError {
    /// The script or the test's own binary could not be started.
    #[error("cannot start {}: {source}", program.display())]
    Start {
        /// What was to be started.
        program: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is no runtime although CI must have one.
    #[error(
        "there is no Monado here, and CI must not skip the real-runtime tests: xr/monado/make-root.sh makes it"
    )]
    NoRuntime,
    /// The test failed inside.
    #[error("{test} failed inside the stage ({status}):\n{output}")]
    Failed {
        /// Its name.
        test: String,
        /// How it ended.
        status: std::process::ExitStatus,
        /// What it printed.
        output: String,
    },
    /// No test of that name ran inside.
    #[error(
        "no test named {test} ran inside the stage: `run` must be given the test's full name\n{output}"
    )]
    NoTest {
        /// The name.
        test: String,
        /// What was printed.
        output: String,
    },
}

/// As for people: `unwrap` in a test shows it, and the output in it must keep its lines.
impl fmt::Debug for StageError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// Whether this process is already where Monado is.
pub fn is_inside() -> bool {
    env::var_os(ENTERED).is_some()
}

/// Runs `body` where Monado is; `test` is the full name of the calling test within its binary
/// (`module::name`, or just the name in a file of `tests/`). Gives what the test printed inside, so that what the
/// runtime's library and the layers said in the test's own process can be judged ([`crate::verdict`]); nothing when
/// already inside or skipped.
///
/// # Errors
/// [`StageError`] when the test failed inside, did not run, or could not run in CI.
pub fn run(test: &str, body: impl FnOnce()) -> Result<String, StageError> {
    if is_inside() {
        body();
        return Ok(String::new());
    }
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("enter.sh");
    let binary = env::current_exe().map_err(|source| StageError::Start {
        program: PathBuf::from(test),
        source,
    })?;
    let output = Command::new(&script)
        .arg(binary)
        .args(["--exact", test, "--nocapture"])
        .output()
        .map_err(|source| StageError::Start {
            program: script,
            source,
        })?;
    let text = format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    if output.status.code() == Some(NO_RUNTIME) {
        if env::var("CI").is_ok_and(|value| value == "true") {
            return Err(StageError::NoRuntime);
        }
        println!("skipped: {}", text.trim());
        return Ok(String::new());
    }
    if !output.status.success() {
        return Err(StageError::Failed {
            test: test.to_owned(),
            status: output.status,
            output: text,
        });
    }
    if !text.contains("1 passed") {
        return Err(StageError::NoTest {
            test: test.to_owned(),
            output: text,
        });
    }
    print!("{text}");
    Ok(text)
}
