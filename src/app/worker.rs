//! One background thread for work that would hold up the frame loop.
//!
//! The newest job wins: whatever was asked for before is cancelled, because the
//! person has moved on. Results are fetched at a frame boundary, without waiting.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;

/// A thread that turns inputs into outputs, one at a time.
pub struct Worker<Input, Output> {
    jobs: Option<Sender<(Input, Arc<AtomicBool>)>>,
    results: Receiver<Output>,
    cancel: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl<Input: Send + 'static, Output: Send + 'static> Worker<Input, Output> {
    /// Starts the thread. The job looks at its flag often and gives up when it is set; it may keep what helps with the
    /// next input.
    ///
    /// # Errors
    /// Where the system gives no more threads.
    pub fn start(
        name: &str,
        mut job: impl FnMut(&Input, &AtomicBool) -> Output + Send + 'static,
    ) -> std::io::Result<Self> {
        Self::start_with(name, || (), move |(), input, cancel| job(input, cancel))
    }

    /// Starts the thread with something that it keeps from one job to the next and that never leaves it, such as a device.
    ///
    /// # Errors
    /// Where the system gives no more threads.
    pub fn start_with<Kept>(
        name: &str,
        begin: impl FnOnce() -> Kept + Send + 'static,
        mut job: impl FnMut(&mut Kept, &Input, &AtomicBool) -> Output + Send + 'static,
    ) -> std::io::Result<Self> {
        let (jobs, inbox) = channel::<(Input, Arc<AtomicBool>)>();
        let (outbox, results) = channel();
        let thread = std::thread::Builder::new()
            .name(name.to_owned())
            .spawn(move || {
                let mut kept = begin();
                while let Ok((input, cancel)) = inbox.recv() {
                    if cancel.load(Ordering::Relaxed) {
                        continue;
                    }
                    let output = job(&mut kept, &input, &cancel);
                    // A job that was cancelled on the way has nothing to say.
                    if !cancel.load(Ordering::Relaxed) && outbox.send(output).is_err() {
                        return;
                    }
                }
            })?;
        let cancel = Arc::new(AtomicBool::new(false));
        Ok(Self {
            jobs: Some(jobs),
            results,
            cancel,
            thread: Some(thread),
        })
    }

    /// Cancels what runs and asks for this instead.
    pub fn ask(&mut self, input: Input) {
        self.cancel.store(true, Ordering::Relaxed);
        self.cancel = Arc::new(AtomicBool::new(false));
        if let Some(jobs) = &self.jobs {
            // The thread ends only when this sender goes, so the job is always taken.
            let _ = jobs.send((input, Arc::clone(&self.cancel)));
        }
    }

    /// Cancels what runs: it will have nothing to say.
    pub fn cancel(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
    }

    /// The newest result that is ready, if any; never waits.
    pub fn poll(&mut self) -> Option<Output> {
        let mut newest = None;
        loop {
            match self.results.try_recv() {
                Ok(output) => newest = Some(output),
                Err(TryRecvError::Empty | TryRecvError::Disconnected) => return newest,
            }
        }
    }

    /// Waits for the next result; `None` where the thread is gone.
    pub fn wait(&mut self) -> Option<Output> {
        self.results.recv().ok()
    }
}

impl<Input, Output> Drop for Worker<Input, Output> {
    /// Cancels what runs and waits for the thread: at once where the job looks at its flag, else when it is done.
    fn drop(&mut self) {
        self.cancel.store(true, Ordering::Relaxed);
        self.jobs = None;
        if let Some(thread) = self.thread.take() {
            // A panic on the worker was reported by the runtime already.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, clippy::unwrap_used, reason = "tests")]
    use super::*;

    fn spin(input: &u32, cancel: &AtomicBool) -> u32 {
        while *input == 0 && !cancel.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
        *input * 2
    }

    #[test]
    fn the_newest_job_wins_and_cancels_the_others() {
        let mut worker = Worker::start("test", spin).unwrap();
        worker.ask(0);
        worker.ask(0);
        worker.ask(21);
        assert_eq!(worker.wait(), Some(42));
        assert_eq!(worker.poll(), None);
    }

    #[test]
    fn dropping_ends_an_endless_job() {
        let mut worker = Worker::start("test", spin).unwrap();
        worker.ask(0);
        drop(worker);
    }
}
