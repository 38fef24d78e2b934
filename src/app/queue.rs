//! Work that waits in line for a thread, none of it dropped: first come, first served.

use std::collections::VecDeque;
use std::sync::atomic::AtomicBool;

use super::worker::Worker;

/// Most that waits at a time: a person who presses on and on does not fill the memory.
pub(super) const MOST_WAITING: usize = 16;

/// A line of work, and the thread that does it.
pub(super) struct Queue<Input, Output> {
    worker: Worker<(u64, Input), (u64, Output)>,
    waiting: VecDeque<Input>,
    /// What the thread is at.
    at: Option<Input>,
    /// Its number: what was stopped in the moment in which it was done is told from it by another one.
    number: u64,
}

impl<Input: Clone + Send + 'static, Output: Send + 'static> Queue<Input, Output> {
    /// A thread of this name that does such work; the work looks at its flag often and gives up when it is set.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub(super) fn start(
        name: &str,
        mut job: impl FnMut(&Input, &AtomicBool) -> Output + Send + 'static,
    ) -> std::io::Result<Self> {
        let numbered = move |(number, input): &(u64, Input), cancel: &AtomicBool| {
            (*number, job(input, cancel))
        };
        Ok(Self {
            worker: Worker::start(name, numbered)?,
            waiting: VecDeque::new(),
            at: None,
            number: 0,
        })
    }

    /// Puts something into the line. False: too much waits already.
    #[must_use]
    pub(super) fn ask(&mut self, input: Input) -> bool {
        let room = self.waiting.len() < MOST_WAITING;
        if room {
            self.waiting.push_back(input);
        }
        room
    }

    /// All that is not done, what the thread is at first.
    pub(super) fn open(&self) -> impl Iterator<Item = &Input> {
        self.at.iter().chain(&self.waiting)
    }

    /// Goes on; gives what was done since.
    pub(super) fn poll(&mut self) -> Option<Output> {
        let done = self.at.as_ref().and_then(|_| self.worker.poll());
        // What was stopped as it ended is nobody's.
        let done = done.filter(|(number, _)| *number == self.number);
        self.go_on(done.is_some());
        done.map(|(_, output)| output)
    }

    /// Waits for the next that is not done, if there is one.
    pub(super) fn wait(&mut self) -> Option<Output> {
        self.go_on(false);
        self.at.as_ref()?;
        let done = loop {
            match self.worker.wait() {
                Some((number, _)) if number != self.number => {}
                done => break done.map(|(_, output)| output),
            }
        };
        self.go_on(true);
        done
    }

    fn go_on(&mut self, is_done: bool) {
        if is_done {
            self.at = None;
        }
        if self.at.is_none()
            && let Some(next) = self.waiting.pop_front()
        {
            self.at = Some(next.clone());
            self.number += 1;
            self.worker.ask((self.number, next));
        }
    }

    /// Stops what the thread is at, and gives it back; the line goes on with the next.
    pub(super) fn stop(&mut self) -> Option<Input> {
        let stopped = self.at.take()?;
        self.worker.cancel();
        self.go_on(false);
        Some(stopped)
    }

    /// Whether something is not done.
    pub(super) fn is_busy(&self) -> bool {
        self.at.is_some() || !self.waiting.is_empty()
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::sync::atomic::Ordering;

    use super::*;

    #[test]
    fn what_is_stopped_says_nothing_and_the_next_is_done() {
        let job = |number: &usize, cancel: &AtomicBool| {
            while *number == 0 && !cancel.load(Ordering::Relaxed) {
                std::thread::yield_now();
            }
            *number
        };
        let mut queue = Queue::start("test", job).unwrap();
        assert!(queue.stop().is_none());
        assert!(queue.ask(0) && queue.ask(7));
        assert!(queue.poll().is_none());
        assert_eq!(queue.stop(), Some(0));
        assert_eq!(queue.wait(), Some(7));
        assert!(queue.wait().is_none() && !queue.is_busy());
    }

    #[test]
    fn what_was_stopped_as_it_ended_is_not_taken_for_the_next() {
        let (began, begins) = std::sync::mpsc::channel();
        let (lets, waits) = std::sync::mpsc::channel::<()>();
        // It looks at its flag no more, as work does in its last moment.
        let job = move |number: &usize, _: &AtomicBool| {
            began.send(()).unwrap();
            waits.recv().unwrap();
            *number
        };
        let mut queue = Queue::start("test", job).unwrap();
        for _ in 0..200 {
            assert!(queue.ask(1) && queue.poll().is_none());
            begins.recv().unwrap();
            // From here on it ends in any moment.
            lets.send(()).unwrap();
            assert_eq!(queue.stop(), Some(1));
            assert!(queue.ask(2));
            lets.send(()).unwrap();
            assert_eq!(queue.wait(), Some(2));
            begins.recv().unwrap();
        }
    }

    #[test]
    fn all_is_done_in_order_and_the_line_has_an_end() {
        let mut queue = Queue::start("test", |number: &usize, _: &AtomicBool| number * 2).unwrap();
        assert!(queue.wait().is_none() && queue.poll().is_none() && !queue.is_busy());
        for number in 0..MOST_WAITING {
            assert!(queue.ask(number));
        }
        assert!(!queue.ask(99), "the line is full");
        assert!(queue.open().copied().eq(0..MOST_WAITING));
        let done: Vec<usize> = std::iter::from_fn(|| queue.wait()).collect();
        assert!(
            done.into_iter()
                .eq((0..MOST_WAITING).map(|number| number * 2))
        );
        assert!(!queue.is_busy());
    }
}
