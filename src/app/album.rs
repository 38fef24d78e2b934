//! Stereo pictures of every growth step of a session, as PNG files.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use glam::Vec3;
use ramus_xr::{Acquired, Frame, Headset};

use crate::app::export;
use crate::app::picture::{Picture, side_by_side};
use crate::app::session::Watcher;
use crate::app::workshop::Workshop;
use crate::tree::file::check_place;

/// Called after each frame with the number of frames so far.
pub type OnFrame<'a> = Box<dyn FnMut(usize) + 'a>;

/// Hands that move less than this in a frame are at rest, metres: 4 cm in a second.
const STILL: f32 = 0.000_5;

/// Keeps a picture of each growth step, taken when the step has grown whole; a step that is shown again
/// (after an undo, say) is pictured again, so that the newest stands. A picture with hands at work is taken again when
/// they rest, since they hide what they work at.
pub struct Album<'a> {
    folder: Option<PathBuf>,
    /// Tree and step of the last picture.
    last: Option<(u64, u32)>,
    /// Whether hands were at rest in the last picture.
    last_rested: bool,
    /// Where hands were in the last frame, and whether they rest now.
    hands: Option<[Vec3; 2]>,
    resting: bool,
    steps: BTreeSet<u32>,
    frames: usize,
    on_frame: OnFrame<'a>,
}

impl<'a> Album<'a> {
    /// Pictures go to `folder`, which is made; without one nothing is drawn.
    ///
    /// # Errors
    /// Where the folder cannot be made or takes no pictures.
    pub fn new(folder: Option<&Path>, on_frame: OnFrame<'a>) -> Result<Self> {
        if let Some(folder) = folder {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make the folder {}", folder.display()))?;
            check_place(&folder.join(Self::file_name(0)))?;
        }
        Ok(Self {
            folder: folder.map(Path::to_owned),
            last: None,
            last_rested: false,
            hands: None,
            resting: false,
            steps: BTreeSet::new(),
            frames: 0,
            on_frame,
        })
    }

    /// The steps that were pictured.
    #[must_use]
    pub fn steps(&self) -> &BTreeSet<u32> {
        &self.steps
    }

    /// Frames of the session so far.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The file of a step's picture.
    #[must_use]
    pub fn file_name(step: u32) -> String {
        format!("step-{step:02}.png")
    }

    /// Whether [`Self::file_name`] gives this name to some step's picture.
    #[must_use]
    pub fn is_file_name(name: &OsStr) -> bool {
        name.to_str()
            .and_then(|name| name.strip_prefix("step-")?.strip_suffix(".png"))
            .and_then(|step| step.parse().ok())
            .is_some_and(|step| name == Self::file_name(step).as_str())
    }

    fn is_due(&self, workshop: &Workshop) -> bool {
        self.folder.is_some()
            && (self.last != Some(Self::key(workshop)) || self.resting && !self.last_rested)
            && !workshop.world().is_growing()
            && !workshop.is_busy()
    }

    fn key(workshop: &Workshop) -> (u64, u32) {
        (workshop.edits(), workshop.document().step)
    }
}

impl Watcher for Album<'_> {
    /// A picture is due when something changed and nothing moves by itself any more.
    fn wants(&mut self, workshop: &Workshop, frame: &Frame) -> bool {
        let hands = frame.hands.map(|hand| hand.grip.position);
        let still = |hand: usize| {
            let moved = |before: [Vec3; 2]| hands[hand].distance(before[hand]) >= STILL;
            !frame.hands[hand].tracked || !self.hands.is_some_and(moved)
        };
        self.resting = still(0) && still(1) && !workshop.world().is_touched();
        self.hands = Some(hands);
        self.is_due(workshop)
    }

    fn drawn(
        &mut self,
        workshop: &Workshop,
        picture: &Picture,
        acquired: Option<Acquired>,
    ) -> Result<()> {
        let key = Self::key(workshop);
        let Some(folder) = self.folder.as_ref().filter(|_| self.is_due(workshop)) else {
            return Ok(());
        };
        self.last = Some(key);
        self.last_rested = self.resting;
        let both = side_by_side(&picture.read(acquired)?);
        export::png(&both, &folder.join(Self::file_name(key.1)))?;
        self.steps.insert(key.1);
        Ok(())
    }

    fn ended(&mut self, _headset: &mut dyn Headset) {
        self.frames += 1;
        (self.on_frame)(self.frames);
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::world::World;
    use crate::world::history::History;

    #[test]
    fn a_picture_with_hands_at_work_is_taken_again_when_they_rest() {
        let folder = tempfile::tempdir().unwrap();
        let workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        let mut album = Album::new(Some(folder.path()), Box::new(|_| {})).unwrap();
        let mut frame = Frame::start();
        frame.hands[1].tracked = true;
        let mut wants = |album: &mut Album<'_>, move_by: f32| {
            frame.hands[1].grip.position.x += move_by;
            album.wants(&workshop, &frame)
        };
        let taken = |album: &mut Album<'_>| {
            album.last = Some(Album::key(&workshop));
            album.last_rested = album.resting;
        };
        assert!(wants(&mut album, 0.0), "the first one");
        assert!(wants(&mut album, 0.01), "until it is taken");
        taken(&mut album);
        assert!(!wants(&mut album, 0.01), "the hand still moves");
        assert!(wants(&mut album, 0.000_1), "it rests");
        taken(&mut album);
        assert!(!wants(&mut album, 0.0) && !wants(&mut album, 0.01) && !wants(&mut album, 0.0));
    }
}
