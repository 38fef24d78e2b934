//! What Ramus remembers of a person between sessions: what they set, how far they are in the tutorial, their projects.
//!
//! It is kept in one small file in the person's own folder for settings, never in a project, so that a project
//! is the same for everybody. A file that makes no sense is put aside and told; one that cannot be read is told and left as it
//! is, and nothing is kept in that session. Nothing depends on it.

use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};

use crate::app::workshop::Workshop;
use crate::app::{export, portrait};
use crate::sketch;
use crate::tree::file::write_atomically;
use crate::tree::{Drawing, Organs};
use crate::ui::{Recent, Settings, Thumbnail};

/// Longest file that is read, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Most projects that are remembered.
const MOST_RECENT: usize = 12;

/// Width and height of a project's picture, pixels.
const PICTURE: u32 = 128;

/// What is kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
struct Kept {
    settings: Settings,
    /// Newest first.
    recent: Vec<PathBuf>,
}

/// A person, and where they are remembered.
#[derive(Clone, Debug, Default)]
pub struct Person {
    kept: Kept,
    path: Option<PathBuf>,
    /// Whether Ramus has not met them.
    new: bool,
    message: Option<String>,
}

/// `RAMUS_CONFIG`, else `ramus` in `XDG_CONFIG_HOME`, else in `~/.config` (XDG Base Directory Specification); none where there is no home.
fn folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    set("RAMUS_CONFIG")
        .map(PathBuf::from)
        .or_else(|| set("XDG_CONFIG_HOME").map(|home| Path::new(&home).join("ramus")))
        .or_else(|| set("HOME").map(|home| Path::new(&home).join(".config/ramus")))
}

impl Person {
    /// Whoever uses this account.
    #[must_use]
    pub fn here() -> Self {
        folder().map_or_else(Self::default, |folder| {
            Self::from(folder.join("person.json"))
        })
    }

    fn from(path: PathBuf) -> Self {
        let mut person = Self {
            path: Some(path.clone()),
            ..Self::default()
        };
        match read(&path) {
            Ok(Some(mut kept)) => {
                // A number of any size can stand there, and an endless one could not be written again.
                let lift = &mut kept.settings.room.lift;
                *lift = if lift.is_finite() { *lift } else { 0.0 };
                person.kept = kept;
            }
            Ok(None) => person.new = true,
            Err(Unread::Closed(problem)) => {
                person.path = None;
                person.message = Some(format!(
                    "Your settings could not be read ({problem}), so Ramus begins with its own and keeps none of this session: {}",
                    path.display()
                ));
            }
            Err(Unread::Nonsense(problem)) => person.put_aside(&path, &problem),
        }
        person
    }

    /// Begins anew beside a file that says nothing.
    fn put_aside(&mut self, path: &Path, problem: &str) {
        let aside = path.with_extension("json.unreadable");
        let moved = std::fs::rename(path, &aside).is_ok();
        if !moved {
            // It stays, and is not written over.
            self.path = None;
        }
        let place = if moved { &aside } else { path };
        self.message = Some(format!(
            "Your settings could not be read ({problem}), so Ramus begins with its own: {}",
            place.display()
        ));
    }

    /// Projects they worked on, newest first, that are still there, with their pictures.
    pub fn recent(&self) -> impl Iterator<Item = Recent> {
        let there = self.kept.recent.iter().filter(|path| path.is_file());
        there.map(|project| Recent {
            project: project.clone(),
            picture: self
                .picture_of(project)
                .and_then(|path| small_picture(&path)),
        })
    }

    /// Where the picture of a project is kept: beside the person's file, under a name that its path gives.
    fn picture_of(&self, project: &Path) -> Option<PathBuf> {
        // FNV-1a: two projects with one name in different folders have two pictures.
        let hash = project.as_os_str().as_encoded_bytes().iter();
        let hash = hash.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
        });
        Some(
            self.path
                .as_ref()?
                .with_file_name(format!("{hash:016x}.png")),
        )
    }

    /// What they have set.
    #[must_use]
    pub fn settings(&self) -> Settings {
        self.kept.settings
    }

    /// Brings the person in: the workshop is as they set it, and who is new is shown around.
    pub fn enter(&mut self, workshop: &mut Workshop) {
        workshop.set(self.kept.settings);
        workshop.offer(self.recent().collect());
        if self.new {
            workshop.teach(0);
        }
        if let Some(message) = self.message.take() {
            workshop.show_message(message);
        }
    }

    /// Remembers them for the next time.
    ///
    /// # Errors
    /// In a sentence, where their file cannot be written; the session's work is not concerned.
    pub fn leave(mut self, workshop: &Workshop, project: &Path) -> Result<(), String> {
        self.kept.settings = workshop.settings();
        let project = std::path::absolute(project).unwrap_or_else(|_| project.to_owned());
        if let Some(path) = self.picture_of(&project) {
            keep_picture(workshop, &path);
        }
        self.kept.recent.retain(|other| *other != project);
        self.kept.recent.insert(0, project);
        self.kept.recent.truncate(MOST_RECENT);
        let Some(path) = &self.path else {
            return Ok(());
        };
        let write = || -> std::io::Result<()> {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)?;
            }
            let text = serde_json::to_vec_pretty(&self.kept)?;
            write_atomically(path, &text).map_err(std::io::Error::other)
        };
        write().map_err(|error| {
            format!(
                "your settings could not be kept ({error}): {}",
                path.display()
            )
        })
    }
}

/// Draws the full-size tree for the list of projects. Without a tree or a device there is none: nothing depends on it.
fn keep_picture(workshop: &Workshop, path: &Path) {
    let document = workshop.document();
    if document.step == 0 || document.sketch.is_empty() {
        return;
    }
    let drawn = || -> anyhow::Result<()> {
        let grown = sketch::grow(&document.sketch, document.step, &AtomicBool::new(false))?;
        let drawing = Drawing {
            tree: grown.tree,
            organs: Organs::default(),
        };
        let picture = portrait::of_drawing(drawing, PICTURE, true, portrait::PAPER)?;
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)?;
        }
        export::png(&picture, path)?;
        Ok(())
    };
    if let Err(error) = drawn() {
        tracing::debug!("no picture of the project: {error:#}");
    }
}

/// A picture that this program drew; none where it is anything else.
fn small_picture(path: &Path) -> Option<Thumbnail> {
    let mut reader = image::ImageReader::open(path).ok()?;
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(PICTURE);
    limits.max_image_height = Some(PICTURE);
    reader.limits(limits);
    reader.set_format(image::ImageFormat::Png);
    let picture = reader.decode().ok()?.into_rgba8();
    let whole = picture.width() == PICTURE && picture.height() == PICTURE;
    whole.then(|| Thumbnail {
        side: PICTURE as usize,
        rgba: picture.into_raw(),
    })
}

/// Why a file said nothing.
enum Unread {
    /// It cannot be read: it may hold everything.
    Closed(String),
    /// It was read, and makes no sense.
    Nonsense(String),
}

/// What is kept in a file; none where there is no file.
fn read(path: &Path) -> Result<Option<Kept>, Unread> {
    let bytes = match bytes_of(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Unread::Closed(error.to_string())),
    };
    if bytes.len() as u64 > MAX_BYTES {
        let problem = format!("it is longer than {MAX_BYTES} bytes");
        return Err(Unread::Nonsense(problem));
    }
    let kept = serde_json::from_slice(&bytes);
    kept.map(Some)
        .map_err(|error| Unread::Nonsense(error.to_string()))
}

/// What is in a file, one byte more than there may be at most.
fn bytes_of(path: &Path) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = File::open(path)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::ui::words::Language;
    use crate::world::{
        World,
        history::History,
        scene::weather::{Light, Wind},
    };

    fn workshop() -> Workshop {
        Workshop::unsaved(World::new(History::default())).unwrap()
    }

    #[test]
    fn a_person_is_remembered() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/person.json");
        let mut person = Person::from(path.clone());
        let mut first = workshop();
        person.enter(&mut first);
        assert!(
            first.world().lesson().is_some(),
            "who is new is shown around"
        );
        let mut settings = first.settings();
        settings.language = Language::German;
        settings.room.lift = 0.3;
        settings.light = Light::Evening;
        settings.wind = Wind::Breeze;
        first.set(settings);
        let project = folder.path().join("oak.ramus");
        std::fs::write(&project, "").unwrap();
        person.leave(&first, &project).unwrap();

        let mut person = Person::from(path);
        let recent: Vec<_> = person.recent().map(|recent| recent.project).collect();
        assert_eq!(recent, [project]);
        let mut second = workshop();
        person.enter(&mut second);
        assert_eq!(second.settings(), settings);
        assert!(second.world().lesson().is_none());
        assert_eq!(second.world().room().lift, 0.3);
    }

    #[test]
    fn what_cannot_be_read_is_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        // Whoever runs the tests may read everything, but nobody reads a folder.
        let path = folder.path().join("person.json");
        std::fs::create_dir(&path).unwrap();
        let mut person = Person::from(path.clone());
        let message = person.message.clone().unwrap();
        assert!(message.contains("keeps none"), "{message}");
        let mut workshop = workshop();
        person.enter(&mut workshop);
        let project = folder.path().join("oak.ramus");
        assert!(person.leave(&workshop, &project).is_ok());
        let there = std::fs::read_dir(folder.path()).unwrap();
        let there: Vec<_> = there.map(|entry| entry.unwrap().path()).collect();
        assert_eq!(there, [path], "nothing moved, nothing written");
    }

    #[test]
    fn what_makes_no_sense_is_put_aside() {
        let folder = tempfile::tempdir().unwrap();
        for bytes in [
            &b"{"[..],
            b"[1]",
            b"\xff\xfe",
            &vec![b' '; usize::try_from(MAX_BYTES).unwrap() + 2],
        ] {
            let path = folder.path().join("person.json");
            std::fs::write(&path, bytes).unwrap();
            let person = Person::from(path.clone());
            assert_eq!(person.kept, Kept::default());
            assert!(person.message.is_some() && !path.exists());
        }
    }

    #[test]
    fn no_more_projects_than_a_hand_can_choose_from() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("person.json");
        for n in 0..20 {
            let person = Person::from(path.clone());
            person
                .leave(&workshop(), &folder.path().join(format!("{n}.ramus")))
                .unwrap();
        }
        let person = Person::from(path);
        assert_eq!(person.kept.recent.len(), MOST_RECENT);
        assert!(person.kept.recent[0].ends_with("19.ramus"));
    }
}
