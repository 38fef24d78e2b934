//! Progress on standard error for whatever takes longer than a second.

use std::io::{IsTerminal as _, Write as _};
use std::sync::{Mutex, MutexGuard, Once, PoisonError, mpsc};
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
        let percent = done * 100 / total.max(1);
        self.say(|_| format!("{percent} % ({done} of {total})"));
    }

    /// Does work whose parts cannot be counted, and says now and then how long it has taken.
    pub(super) fn during<T>(what: &'static str, work: impl FnOnce() -> T) -> T {
        /// Takes the line away, even from work that panics.
        struct Told;
        impl Drop for Told {
            fn drop(&mut self) {
                drop(watched().take());
            }
        }
        start_watch();
        *watched() = Some(Self::new(what));
        let _told = Told;
        work()
    }

    /// Shows a line, if it is time to; says whether it was.
    fn say(&mut self, line: impl FnOnce(Duration) -> String) -> bool {
        let now = Instant::now();
        let pause = if self.terminal {
            TERMINAL_PAUSE
        } else {
            LOG_PAUSE
        };
        let due = self.last.is_none_or(|last| now - last >= pause);
        if now - self.started < PATIENCE || !due {
            return false;
        }
        self.last = Some(now);
        let line = line(now - self.started);
        self.write(&format!("{}: {line}", self.what));
        true
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

/// The work that [`Progress::during`] does now.
fn watched() -> MutexGuard<'static, Option<Progress>> {
    static WATCHED: Mutex<Option<Progress>> = Mutex::new(None);
    WATCHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Starts the thread that tells of work whose parts cannot be counted, once for the process, and waits until it runs. Without a thread for
/// it the work goes on in silence.
///
/// Large work calls it before it asks how much memory there is: a thread that starts while memory runs out ends the program.
pub(super) fn start_watch() {
    static STARTED: Once = Once::new();
    STARTED.call_once(|| {
        let (running, runs) = mpsc::channel();
        let started = std::thread::Builder::new()
            .name("ramus-progress".to_owned())
            .spawn(move || {
                let _ = running.send(());
                loop {
                    std::thread::sleep(TERMINAL_PAUSE);
                    if let Some(progress) = watched().as_mut() {
                        progress.say(|taken| format!("{} s so far", taken.as_secs()));
                    }
                }
            });
        if started.is_ok() {
            let _ = runs.recv();
        }
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn short_work_is_silent_and_long_work_is_told_now_and_then() {
        let line = |_| "half of it".to_owned();
        let mut progress = Progress::new("testing");
        assert!(!progress.say(line), "too early");
        progress.started -= 2 * PATIENCE;
        assert!(progress.say(line), "late enough");
        assert!(!progress.say(line), "too soon after the last line");
        progress.last = Some(Instant::now() - 2 * LOG_PAUSE);
        assert!(progress.say(line));
    }

    #[test]
    fn work_that_cannot_be_counted_gives_its_result() {
        assert_eq!(Progress::during("testing", || 7), 7);
    }
}
