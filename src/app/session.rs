//! The frame loop: wait, input, world, draw, submit, on whatever headset there is.

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
    /// The person or the runtime ended a session that was being played.
    #[error(
        "the OpenXR runtime ended the session before all of it was played: play it again to see the rest"
    )]
    Early,
    /// Whoever watches.
    #[error("{0:#}")]
    Watcher(#[from] anyhow::Error),
}

/// Somebody who watches a session: keeps pictures, counts frames, asks it to end.
pub trait Watcher {
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
    let acquired = headset.begin()?;
    // Images that were acquired are released by `end`; with none of the runtime's, ours are drawn into on demand.
    let ready = frame.should_render && (acquired.is_some() || headset.swapchain().is_none());
    let rendered = match picture {
        Some(picture) if ready && (watcher.wants(workshop, frame) || acquired.is_some()) => {
            let views = headset.views()?;
            picture.mask(headset.visibility_mask())?;
            let scene = workshop.scene();
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
            true
        }
        _ => false,
    };
    headset.end(rendered)?;
    Ok(())
}
