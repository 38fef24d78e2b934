//! A session as numbered pictures at a steady rate: the frames of a video.
//!
//! Sessions have the rate of their headset, or of a window none at all, since a window rests while nothing happens. A video's
//! frames come at a steady rate instead: picture n shows the first frame of the session at or after n / rate seconds. Where that is
//! the frame of the picture before, its file is copied. One eye, the left: a video for people without a headset.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use ramus_xr::{Acquired, Frame, Headset};

use crate::app::album::OnFrame;
use crate::app::export;
use crate::app::picture::Picture;
use crate::app::session::Watcher;
use crate::app::workshop::Workshop;
use crate::tree::file::check_place;

/// Keeps the pictures of a session at a steady rate.
pub struct Film<'a> {
    folder: PathBuf,
    /// Pictures a second.
    rate: u32,
    /// The session's time at its first frame, seconds.
    begun: Option<f64>,
    /// Seconds since then.
    time: f64,
    pictures: u64,
    frames: usize,
    on_frame: OnFrame<'a>,
}

impl<'a> Film<'a> {
    /// Pictures go to `folder`, which is made, at `rate` a second.
    ///
    /// # Errors
    /// Where the folder cannot be made, takes no pictures, or holds those of another film, which would get mixed with it.
    pub fn new(folder: &Path, rate: u32, on_frame: OnFrame<'a>) -> Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        let first = folder.join(Self::file_name(1));
        ensure!(
            !first.exists(),
            "{} is there already, and the frames of two sessions would get mixed: choose another folder",
            first.display()
        );
        check_place(&first)?;
        Ok(Self {
            folder: folder.to_owned(),
            rate: rate.max(1),
            begun: None,
            time: 0.0,
            pictures: 0,
            frames: 0,
            on_frame,
        })
    }

    /// Pictures so far.
    #[must_use]
    pub fn pictures(&self) -> u64 {
        self.pictures
    }

    /// Frames of the session so far.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The file of a picture; the first is 1, as makers of videos expect.
    #[must_use]
    pub fn file_name(number: u64) -> String {
        format!("frame-{number:06}.png")
    }

    /// Whether [`Self::file_name`] gives this name to some picture.
    #[must_use]
    pub fn is_file_name(name: &OsStr) -> bool {
        name.to_str()
            .and_then(|name| name.strip_prefix("frame-")?.strip_suffix(".png"))
            .and_then(|number| number.parse().ok())
            .is_some_and(|number| name == Self::file_name(number).as_str())
    }

    /// Whether the next picture's time has come.
    fn is_due(&self) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "no film has 2⁵² pictures")]
        let due = self.pictures as f64 / f64::from(self.rate);
        // A rounding of the recorded time must not shift a picture by a frame.
        due <= self.time + 1e-6
    }
}

impl Watcher for Film<'_> {
    fn wants(&mut self, _workshop: &Workshop, frame: &Frame) -> bool {
        self.time = frame.time - *self.begun.get_or_insert(frame.time);
        self.is_due()
    }

    fn drawn(
        &mut self,
        _workshop: &Workshop,
        picture: &Picture,
        acquired: Option<Acquired>,
    ) -> Result<()> {
        if !self.is_due() {
            return Ok(());
        }
        let [left, _] = picture.read(acquired)?;
        self.pictures += 1;
        let path = self.folder.join(Self::file_name(self.pictures));
        export::png(&left, &path)?;
        while self.is_due() {
            self.pictures += 1;
            let copy = self.folder.join(Self::file_name(self.pictures));
            std::fs::copy(&path, &copy)
                .with_context(|| format!("cannot write {}", copy.display()))?;
        }
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
    use crate::world::{World, history::History};

    #[test]
    fn pictures_come_at_their_rate_whatever_the_sessions() {
        let folder = tempfile::tempdir().unwrap();
        let workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        for (session_rate, rate, seconds) in [(72, 30, 2), (20, 30, 2), (90, 90, 1), (72, 24, 3)] {
            let mut film = Film::new(folder.path(), rate, Box::new(|_| {})).unwrap();
            for at in 0..=session_rate * seconds {
                let frame = Frame {
                    time: 5.0 + f64::from(at) / f64::from(session_rate),
                    ..Frame::start()
                };
                if film.wants(&workshop, &frame) {
                    while film.is_due() {
                        film.pictures += 1;
                    }
                }
            }
            let expected = u64::from(rate * seconds) + 1;
            assert_eq!(film.pictures(), expected, "{session_rate} Hz to {rate}");
        }
    }

    #[test]
    fn two_films_do_not_mix() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(Film::file_name(1)), "").unwrap();
        let error = Film::new(folder.path(), 30, Box::new(|_| {}))
            .err()
            .unwrap();
        assert!(error.to_string().contains("choose another folder"));
        assert!(Film::is_file_name(OsStr::new("frame-000012.png")));
        assert!(!Film::is_file_name(OsStr::new("frame-12.png")));
    }
}
