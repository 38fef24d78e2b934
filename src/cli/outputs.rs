//! Where results go: looked at before the work that makes them, since its end is too late to refuse.

use std::collections::HashSet;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Result, anyhow, ensure};
use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};

use super::sentence;
use crate::app::album::Album;
use crate::app::ends;
use crate::app::export;
use crate::app::film::Film;
use crate::app::workshop::Workshop;
use crate::mesh::write::WriteFormat;
use crate::tree::Organs;
use crate::tree::file::check_place;
use crate::world::scene::weather::Light;

/// A name for a tree: an ending that tells no format is wrong usage.
pub(super) fn tree_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| export::Format::of(&path).map(|_| path))
}

/// A name for a model: an ending that tells no format is wrong usage.
pub(super) fn model_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| WriteFormat::of(&path).map(|_| path))
}

/// A name for endpoints: an ending that is neither csv nor json is wrong usage.
pub(super) fn endpoints_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| ends::check_name(&path).map(|()| path))
}

/// A name for a picture: an ending that tells another format is wrong usage.
pub(super) fn picture_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| export::check_picture(&path).map(|()| path))
}

/// A light by its name.
pub(super) fn light() -> impl TypedValueParser<Value = Light> {
    PossibleValuesParser::new(Light::ALL.map(Light::name)).map(|name| {
        let mut all = Light::ALL.into_iter();
        all.find(|light| light.name() == name).unwrap_or_default()
    })
}

/// Says what a tree should bear and does not, each once for all trees.
pub(super) fn tell_bare(organs: &Organs) {
    static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());
    for bare in &organs.bare {
        let sentence = bare.to_string();
        let mut said = SAID.lock().unwrap_or_else(PoisonError::into_inner);
        if !said.contains(&sentence) {
            whisper!("{sentence}");
            said.push(sentence);
        }
    }
}

/// Refuses results that would be written over what they are made from, or over each other, however their paths are
/// spelled; `pictures` is the folder of the growth steps' pictures. (Another hard link to the input is no danger: files
/// are replaced whole, and the input keeps its name.)
pub(super) fn not_over_each_other<'a>(
    input: Option<&Path>,
    outputs: impl IntoIterator<Item = &'a Path>,
    pictures: Option<&Path>,
) -> Result<()> {
    let pictures = pictures.map(place);
    let is_picture = |place: &Path| {
        pictures.is_some()
            && place.parent() == pictures.as_deref()
            && place
                .file_name()
                .is_some_and(|name| Album::is_file_name(name) || Film::is_file_name(name))
    };
    let overwritten = |path: &Path| {
        anyhow!(
            "{} would be overwritten by what is made from it: choose another name",
            path.display()
        )
    };
    let source = input.map(place);
    if let (Some(input), Some(source)) = (input, &source) {
        ensure!(!is_picture(source), overwritten(input));
    }
    let mut taken = HashSet::new();
    for output in outputs {
        let place = place(output);
        ensure!(Some(&place) != source.as_ref(), overwritten(output));
        ensure!(
            !is_picture(&place) && taken.insert(place),
            "two results would be written to {}: choose another name for one of them",
            output.display()
        );
    }
    Ok(())
}

/// Where a path leads: links followed as far as there is something, and the rest need not exist.
fn place(path: &Path) -> PathBuf {
    let mut place = PathBuf::new();
    for part in std::path::absolute(path)
        .unwrap_or_else(|_| path.to_owned())
        .components()
    {
        match part {
            Component::ParentDir => {
                place.pop();
            }
            part => place.push(part),
        }
        place = place.canonicalize().unwrap_or(place);
    }
    place
}

/// Refuses names that nothing can be written to.
pub(super) fn check_places<'a>(outputs: impl IntoIterator<Item = &'a PathBuf>) -> Result<()> {
    for output in outputs {
        check_place(output)?;
    }
    Ok(())
}

/// Ends a session that failed: an older project stays, and what was made is kept; the error says where.
pub(super) fn set_aside(
    workshop: Workshop,
    project: Option<&Path>,
    error: &anyhow::Error,
) -> anyhow::Error {
    let error = sentence(error);
    match (workshop.set_aside(), project) {
        (Ok(Some(kept)), Some(project)) if kept != project => anyhow!(
            "{error}; what was made by then is in {}, and {} is as it was",
            kept.display(),
            project.display()
        ),
        (Ok(Some(kept)), _) => anyhow!("{error}; what was made by then is in {}", kept.display()),
        (Ok(None), _) => anyhow!("{error}"),
        (Err(lost), _) => anyhow!("{error}; {lost}"),
    }
}

/// Two pieces of work that both may fail, in one sentence.
pub(super) fn both(first: Result<()>, second: Result<()>) -> Result<()> {
    match (first, second) {
        (Err(first), Err(second)) => Err(anyhow!("{}; {}", sentence(&first), sentence(&second))),
        (first, second) => first.and(second),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::missing_assert_message, reason = "tests")]
    use super::*;
    use crate::app::demonstration;
    use crate::app::session::SessionEnd;
    use crate::app::store::{Store, read_project};
    use crate::app::workshop::WorkshopParams;

    #[test]
    fn a_failed_session_that_keeps_nothing_does_not_say_that_it_does() {
        let world = crate::world::World::new(crate::world::history::History::default());
        let mut workshop = Workshop::unsaved(world).unwrap();
        for frame in &demonstration::first_tree().unwrap()[..230] {
            workshop.update(frame);
        }
        let lost = ramus_xr::HeadsetError::Lost("it is gone".to_owned());
        let said = set_aside(workshop, None, &SessionEnd::from(lost).into()).to_string();
        assert!(said.contains("it is gone"), "{said}");
        assert!(
            !said.contains("saved") && !said.contains("made by then"),
            "{said}"
        );
    }

    /// A runtime that ends the session after `frames`.
    fn ended_early(project: &Path, frames: usize) -> String {
        let opened = Store::begin(project).unwrap();
        let mut workshop = Workshop::new(opened, WorkshopParams::default()).unwrap();
        for frame in &demonstration::first_tree().unwrap()[..frames] {
            workshop.update(frame);
        }
        set_aside(workshop, Some(project), &SessionEnd::Early.into()).to_string()
    }

    #[test]
    fn a_session_that_ends_early_says_where_its_work_and_the_older_project_are() {
        let folder = tempfile::tempdir().unwrap();
        let project = folder.path().join("tree.ramus");
        let said = ended_early(&project, 2);
        assert!(said.ends_with("to see the rest"), "{said}");
        assert!(!project.exists());
        let said = ended_early(&project, 230);
        let place = format!("; what was made by then is in {}", project.display());
        assert!(said.ends_with(&place), "{said}");
        let older = read_project(&project).unwrap();
        assert!(!older.sketch.is_empty());
        let said = ended_early(&project, 400);
        let aside = folder.path().join("tree.ramus.unfinished.ramus");
        let places = format!(
            "; what was made by then is in {}, and {} is as it was",
            aside.display(),
            project.display()
        );
        assert!(said.ends_with(&places), "{said}");
        assert_eq!(read_project(&project).unwrap(), older);
        assert_ne!(read_project(&aside).unwrap(), older);
    }
}
