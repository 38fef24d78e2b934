//! Sessions that follow each other: a runtime that is lost may come back, and the work goes on in the headset.
//!
//! What was lost (instance, session, images, the graphics device) is dropped whole and made anew; the workshop outlives it.
//! The runtime is asked for at a gentle interval, for a bounded time, and a runtime that is lost again at once does not get
//! that time anew.

use std::thread::sleep;
use std::time::{Duration, Instant};

use ramus_xr::HeadsetError;

use crate::app::session::SessionEnd;
use crate::render::RenderError;

/// How long a runtime is waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// How long it may stay away; zero: it is not waited for.
    pub longest: Duration,
    /// The pause before each try.
    pub pause: Duration,
    /// A session that lasted this long was a good one: after it the runtime may stay away for `longest` again.
    pub settled: Duration,
}

impl Patience {
    /// Waits so long in all, and tries once a second.
    #[must_use]
    pub fn of(longest: Duration) -> Self {
        Self {
            longest,
            pause: Duration::from_secs(1),
            settled: Duration::from_secs(10),
        }
    }
}

/// Whether what ended a session may be gone when everything is made anew.
#[must_use]
pub fn may_come_back(end: &SessionEnd) -> bool {
    matches!(
        end,
        SessionEnd::Headset(HeadsetError::Lost(_)) | SessionEnd::Render(RenderError::DeviceLost(_))
    )
}

/// Runs a session, and another one after each loss for as long as `open` gives one in time. `lost` is called after each
/// loss with the time for which the runtime is waited for.
///
/// # Errors
/// The end of the last session, where it was no good one.
pub fn run_again<S, E: std::fmt::Display>(
    first: S,
    patience: &Patience,
    mut run: impl FnMut(S) -> Result<(), SessionEnd>,
    mut open: impl FnMut() -> Result<S, E>,
    mut lost: impl FnMut(&SessionEnd, Duration),
) -> Result<(), SessionEnd> {
    let mut session = first;
    let mut left = patience.longest;
    loop {
        let began = Instant::now();
        let end = match run(session) {
            Err(end) if may_come_back(&end) => end,
            ended => return ended,
        };
        if began.elapsed() >= patience.settled {
            left = patience.longest;
        }
        if left.is_zero() {
            return Err(end);
        }
        lost(&end, left);
        let Some(next) = wait_for(&mut left, patience.pause, &mut open) else {
            return Err(end);
        };
        session = next;
    }
}

/// Tries until there is a session or no time left.
fn wait_for<S, E: std::fmt::Display>(
    left: &mut Duration,
    pause: Duration,
    open: &mut impl FnMut() -> Result<S, E>,
) -> Option<S> {
    let began = Instant::now();
    let all = *left;
    while !left.is_zero() {
        sleep(pause.min(*left));
        let opened = open();
        *left = all.saturating_sub(began.elapsed());
        match opened {
            Ok(session) => return Some(session),
            Err(error) => tracing::debug!("not yet: {error}"),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use super::*;

    fn loss() -> SessionEnd {
        HeadsetError::Lost("it is gone".to_owned()).into()
    }

    const QUICK: Patience = Patience {
        longest: Duration::from_millis(60),
        pause: Duration::from_millis(5),
        settled: Duration::from_secs(60),
    };

    #[test]
    fn the_next_session_goes_on_where_the_lost_one_was() {
        let (mut ran, mut tries, mut told) = (Vec::new(), 0, 0);
        let outcome = run_again(
            0,
            &QUICK,
            |session| {
                ran.push(session);
                if session < 2 { Err(loss()) } else { Ok(()) }
            },
            || {
                tries += 1;
                // Every second try finds the runtime.
                if tries % 2 == 0 {
                    Ok(tries / 2)
                } else {
                    Err("no runtime answers")
                }
            },
            |_, _| told += 1,
        );
        assert!(outcome.is_ok());
        assert_eq!((ran, tries, told), (vec![0, 1, 2], 4, 2));
    }

    #[test]
    fn a_runtime_that_stays_away_is_given_up() {
        let (mut ran, mut tries) = (0, 0);
        let began = Instant::now();
        let outcome = run_again(
            (),
            &QUICK,
            |()| {
                ran += 1;
                Err(loss())
            },
            || {
                tries += 1;
                Err("no runtime answers")
            },
            |end, left| {
                assert!(end.to_string().contains("it is gone"));
                assert_eq!(left, QUICK.longest);
            },
        );
        assert!(matches!(
            outcome,
            Err(SessionEnd::Headset(HeadsetError::Lost(_)))
        ));
        assert!(ran == 1 && tries > 1, "{ran} {tries}");
        assert!(began.elapsed() >= QUICK.longest);
    }

    #[test]
    fn a_runtime_that_dies_again_at_once_does_not_go_on_for_ever() {
        let mut ran = 0;
        let outcome = run_again(
            (),
            &QUICK,
            |()| {
                ran += 1;
                Err(loss())
            },
            || Ok::<_, String>(()),
            |_, _| {},
        );
        assert!(outcome.is_err());
        // Each time took a pause of the sixty milliseconds.
        assert!((2..=13).contains(&ran), "{ran}");
    }

    #[test]
    fn a_session_that_lasted_gives_the_time_anew() {
        let patience = Patience {
            settled: Duration::ZERO,
            ..QUICK
        };
        let mut ran = 0;
        let outcome = run_again(
            (),
            &patience,
            |()| {
                ran += 1;
                if ran < 40 { Err(loss()) } else { Ok(()) }
            },
            || Ok::<_, String>(()),
            |_, left| assert_eq!(left, patience.longest),
        );
        assert!(outcome.is_ok() && ran == 40);
    }

    #[test]
    fn what_cannot_come_back_is_not_waited_for() {
        let ends: [fn() -> Result<(), SessionEnd>; 3] = [
            || Ok(()),
            || Err(SessionEnd::Early),
            || Err(HeadsetError::Failed("broken".to_owned()).into()),
        ];
        for end in ends {
            let outcome = run_again(
                (),
                &QUICK,
                |()| end(),
                || -> Result<(), String> { panic!("nothing is to be opened") },
                |_, _| panic!("nothing is lost"),
            );
            assert_eq!(outcome.is_ok(), end().is_ok());
        }
        let nothing = Patience::of(Duration::ZERO);
        let outcome = run_again(
            (),
            &nothing,
            |()| Err(loss()),
            || -> Result<(), String> { panic!("nobody waits") },
            |_, _| panic!("nobody waits"),
        );
        assert!(outcome.is_err());
        let device = RenderError::DeviceLost("drawing");
        assert!(may_come_back(&device.into()), "a graphics device too");
    }
}
