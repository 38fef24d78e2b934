//! The frame loop: wait, input, world, draw, submit, on whatever headset there is.

use std::path::PathBuf;
use std::time::Duration;

use ramus_xr::{Acquired, Frame, Headset, HeadsetError, Tick};

use crate::app::picture::Picture;
use crate::app::workshop::Workshop;
use crate::render::{RenderError, TreeState};

/// How long the loop rests while the runtime shows us nothing.
const IDLE_PAUSE: Duration = Duration::from_millis(10);

/// Why a session ended before its end.
#[derive(Debug, thiserror::Error)]
pub enum SessionEnd {
    /// The headset.
    #[error(transparent)]
    Headset(#[from] HeadsetError),
    /// The picture.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The person, the window or the runtime ended a session that was being played.
    #[error(
        "the person, the window or the OpenXR runtime ended the session before all of it was played: play it again to see the rest"
    )]
    Early,
    /// Whoever watches.
    #[error("{0:#}")]
    Watcher(#[from] anyhow::Error),
}

/// Somebody who watches a session: keeps pictures, counts frames, asks it to end.
pub trait Watcher {
    /// After the workshop has taken in a frame, which may be drawn or not.
    fn updated(&mut self, _workshop: &Workshop) {}

    /// Whether a frame without a headset must be drawn; on a headset every frame is.
    fn wants(&mut self, _workshop: &Workshop, _frame: &Frame) -> bool {
        true
    }

    /// After a frame was drawn and before it is shown: its picture can be read (which waits for it).
    ///
    /// # Errors
    /// Whatever it fails in; the session ends then.
    fn drawn(
        &mut self,
        _workshop: &Workshop,
        _picture: &Picture,
        _acquired: Option<Acquired>,
    ) -> anyhow::Result<()> {
        Ok(())
    }

    /// Files of models that are to come onto the stage, once.
    fn take_files(&mut self) -> Vec<PathBuf> {
        Vec::new()
    }

    /// A sentence for the board, once.
    fn take_message(&mut self) -> Option<String> {
        None
    }

    /// After each frame.
    fn ended(&mut self, _headset: &mut dyn Headset) {}
}

/// Nobody.
pub struct Nobody;

impl Watcher for Nobody {}

/// Runs a session to its end. Without a picture nothing is drawn and frames are ended empty.
///
/// # Errors
/// [`SessionEnd`]; the workshop is as it was after the last whole frame and can be saved.
pub fn run(
    headset: &mut dyn Headset,
    workshop: &mut Workshop,
    mut picture: Option<&mut Picture>,
    watcher: &mut dyn Watcher,
) -> Result<(), SessionEnd> {
    if picture.is_none() {
        workshop.unseen();
    }
    // Whether somebody was at work since the project was saved last.
    let mut at_work = false;
    loop {
        let there = match headset.wait()? {
            Tick::Exit => return Ok(()),
            Tick::Idle => {
                std::thread::sleep(IDLE_PAUSE);
                false
            }
            Tick::Frame(frame) => {
                one_frame(headset, workshop, picture.as_deref_mut(), watcher, &frame)?;
                watcher.ended(headset);
                headset.worn()
            }
        };
        if at_work && !there {
            put_aside(workshop);
        }
        at_work = there;
    }
}

/// The headset was taken off or put aside: what was made is saved, since nobody knows who comes back, and when.
fn put_aside(workshop: &mut Workshop) {
    if let Err(error) = workshop.save() {
        workshop.show_message(format!("{error}. Your work is kept in the journal."));
    }
}

fn one_frame(
    headset: &mut dyn Headset,
    workshop: &mut Workshop,
    picture: Option<&mut Picture>,
    watcher: &mut dyn Watcher,
    frame: &Frame,
) -> Result<(), SessionEnd> {
    workshop.hold(headset.controllers());
    for pulse in workshop.update(frame) {
        headset.vibrate(*pulse);
    }
    watcher.updated(workshop);
    let acquired = headset.begin()?;
    // Images that were acquired are released by `end`; with none of the runtime's, ours are drawn into on demand.
    let ready = frame.should_render && (acquired.is_some() || headset.swapchain().is_none());
    let rendered = match picture {
        Some(picture) if ready && (watcher.wants(workshop, frame) || acquired.is_some()) => {
            draw(headset, workshop, picture, watcher, acquired, frame.time)?
        }
        _ => false,
    };
    headset.end(rendered)?;
    Ok(())
}

/// Draws a frame that has been begun; false where there is nothing to draw into.
fn draw(
    headset: &mut dyn Headset,
    workshop: &mut Workshop,
    picture: &mut Picture,
    watcher: &mut dyn Watcher,
    acquired: Option<Acquired>,
    time: f64,
) -> Result<bool, SessionEnd> {
    if !picture.fit(headset.extent())? {
        return Ok(false);
    }
    picture.mask(headset.visibility_mask())?;
    let views = workshop.on_stage(headset.views()?);
    picture.speak(workshop.settings().language);
    for (slot, painted) in workshop.take_painted() {
        picture.paint(slot, painted)?;
    }
    let settings = workshop.settings();
    picture.set_quality(settings.quality);
    picture.hold_rate(headset, !settings.sharp);
    picture.set_weather(settings.light, settings.wind, time);
    let layers = workshop.settings().layers;
    let room = layers.then(|| workshop.world().stage_from_room());
    let scene = workshop.scene();
    picture.lift(headset, scene, room.as_ref(), &views)?;
    let report = if acquired.is_none() {
        // Nobody waits for a picture without a headset: it is drawn when all of it is there.
        picture.draw_whole(scene, &views, acquired)?
    } else {
        picture.draw(scene, &views, acquired)?
    };
    if let Some(trouble) = picture.take_trouble() {
        workshop.show_message(trouble);
    }
    if acquired.is_some() || !matches!(report.tree, TreeState::Wanted(_)) {
        watcher.drawn(workshop, picture, acquired)?;
    }
    for file in watcher.take_files() {
        workshop.drop_model(&file);
    }
    if let Some(text) = watcher.take_message() {
        workshop.show_message(text);
    }
    picture.present()?;
    Ok(true)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use std::ops::Range;
    use std::path::PathBuf;

    use ash::vk;
    use ramus_xr::simulated::Simulated;

    use super::*;
    use crate::app::demonstration;
    use crate::app::store::Store;
    use crate::app::workshop::WorkshopParams;
    use crate::world::project;

    /// A headset that lies on the table for some frames, or puts the session aside before them, and looks at the
    /// project's file before each.
    struct Left {
        inner: Simulated,
        off: Range<usize>,
        aside: bool,
        seen: usize,
        file: PathBuf,
        found: Vec<Option<Vec<u8>>>,
    }

    impl Headset for Left {
        ramus_xr::forward_headset!(inner: describe, extent, swapchain, begin, views, end, vibrate, request_exit);

        fn wait(&mut self) -> Result<Tick, HeadsetError> {
            self.found.push(std::fs::read(&self.file).ok());
            if std::mem::take(&mut self.aside) {
                return Ok(Tick::Idle);
            }
            self.aside = self.seen + 1 == self.off.end && self.off.is_empty();
            self.seen += 1;
            self.inner.wait()
        }

        fn worn(&self) -> bool {
            !self.off.contains(&self.seen)
        }
    }

    /// Plays the recorded session to its 230th frame; what the project's file held before each wait.
    fn played(off: Range<usize>) -> (Vec<Option<Vec<u8>>>, Vec<u8>) {
        let frames = demonstration::first_tree().unwrap()[..230].to_vec();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("kept.ramus");
        let opened = Store::open(&file).unwrap();
        let mut workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
        let extent = vk::Extent2D {
            width: 8,
            height: 8,
        };
        let mut headset = Left {
            inner: Simulated::new(frames, extent),
            off,
            aside: false,
            seen: 0,
            file,
            found: Vec::new(),
        };
        run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
        assert!(workshop.edits() > 1);
        (headset.found, project::to_bytes(workshop.document()))
    }

    #[test]
    fn the_project_is_saved_when_the_headset_is_taken_off() {
        let (found, end) = played(220..225);
        assert!(found[..220].iter().all(Option::is_none), "not before");
        // With the 220th frame somebody took it off.
        assert!(found[220].is_some());
        assert_eq!(found[220], found[229], "and once");
        assert_eq!(
            found[220].as_deref(),
            Some(&*end),
            "all of it, since nothing was drawn behind"
        );
        let (never, _) = played(500..500);
        assert!(never.iter().all(Option::is_none));
    }

    #[test]
    fn the_project_is_saved_when_the_session_is_put_aside() {
        let (found, _) = played(200..200);
        assert!(found[..201].iter().all(Option::is_none));
        assert!(found[201..].iter().all(Option::is_some));
    }
}
