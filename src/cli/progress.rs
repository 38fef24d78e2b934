//! Progress on standard error for whatever takes longer than a second.

use std::io::{IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

/// Nothing is said before this long: short work stays silent.
const PATIENCE: Duration = Duration::from_secs(1);
/// Between two lines on a terminal, and between two in a log.
const TERMINAL_PAUSE: Duration = Duration::from_millis(100);
const LOG_PAUSE: Duration = Duration::from_secs(5);

/// A progress line: rewritten in place on a terminal, now and then a new line in a log.
pub(super) struct Progress {
    what: &'static str,
    started: Instant,
    last: Option<Instant>,
    terminal: bool,
}

impl Progress {
    pub(super) fn new(what: &'static str) -> Self {
        let terminal = std::io::stderr().is_terminal();
        Self {
            what,
            started: Instant::now(),
            last: None,
            terminal,
        }
    }

    /// Says that `done` of `total` is done, if it is time to.
    pub(super) fn show(&mut self, done: usize, total: usize) {
        let now = Instant::now();
        let pause = if self.terminal {
            TERMINAL_PAUSE
        } else {
            LOG_PAUSE
        };
        let due = self.last.is_none_or(|last| now - last >= pause);
        if now - self.started < PATIENCE || !due {
            return;
        }
        self.last = Some(now);
        let percent = done * 100 / total.max(1);
        let line = format!("{}: {percent} % ({done} of {total})", self.what);
        self.write(&line);
    }

    fn write(&self, line: &str) {
        // Progress is a courtesy: a closed standard error must not end the work.
        let mut err = std::io::stderr().lock();
        let _ = if self.terminal {
            write!(err, "\r{line}\x1b[K")
        } else {
            writeln!(err, "{line}")
        };
        let _ = err.flush();
    }
}

impl Drop for Progress {
    /// Takes the line away, so that the next one starts clean.
    fn drop(&mut self) {
        if self.terminal && self.last.is_some() {
            self.write("");
        }
    }
}
