//! What Ramus shows where there is no headset: the recorded first session, and the steps of a project.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use ramus_xr::Frame;

use crate::app::album::Album;
use crate::app::export;
use crate::app::picture::{Picture, side_by_side};
use crate::app::portrait;
use crate::app::workshop::Workshop;
use crate::sketch::predict_segments_within;
use crate::world::document::Document;
use crate::world::history::History;
use crate::world::panels::PanelId;
use crate::world::{GrowthParams, World};

/// `assets/sessions/first-tree.session`, built in so that the program works from any folder.
const FIRST_TREE: &[u8] = include_bytes!("../../assets/sessions/first-tree.session");

/// Growth steps that are pictured at most: a project may be at step 10,000.
pub const MOST_PICTURES: u32 = 60;

/// The frames of the recorded first session.
///
/// # Errors
/// Where the built-in session is broken, which a test excludes.
pub fn first_tree() -> Result<Vec<Frame>> {
    ramus_xr::session::from_bytes(FIRST_TREE).context("the built-in session cannot be played")
}

/// Refuses a document whose tree is larger than the workshop shows, before anything is drawn.
///
/// # Errors
/// In a sentence that says how to mend it.
pub fn check_size(document: &Document) -> Result<()> {
    let most = GrowthParams::default().max_segments;
    ensure!(
        predict_segments_within(&document.sketch, document.step, most).is_some(),
        "at step {} this project has more than {most} segments, which cannot be shown: set a lower step in its file",
        document.step
    );
    Ok(())
}

/// The steps that are pictured of a document at this one: all of them, or, where those are more than
/// [`MOST_PICTURES`], so many from the first to the last, evenly chosen.
#[must_use]
pub fn pictured_steps(last: u32) -> Vec<u32> {
    let most = MOST_PICTURES - 1;
    if last <= most {
        return (0..=last).collect();
    }
    let chosen = |n: u32| u64::from(n) * u64::from(last) / u64::from(most);
    (0..=most)
        .filter_map(|n| u32::try_from(chosen(n)).ok())
        .collect()
}

/// Pictures the [`pictured_steps`] of a document, whose scanned models are named from the folder `models`, all from the place that shows the last one whole; gives how many.
///
/// # Errors
/// Where a step cannot be grown, drawn or written.
pub fn every_step(
    document: &Document,
    models: &Path,
    picture: &mut Picture,
    folder: &Path,
    mut progress: impl FnMut(usize, usize),
) -> Result<usize> {
    let steps = pictured_steps(document.step);
    let mut views = None;
    // The last one first: the largest tree says where the person stands.
    for (done, &step) in steps.iter().rev().enumerate() {
        progress(done, steps.len());
        let document = Document {
            step,
            ..document.clone()
        };
        let mut workshop = Workshop::unsaved(World::new(History::new(document)))?;
        workshop.stay_with_models_of(models);
        // Nobody is there, and the newest step has grown whole at once: one frame is enough.
        workshop.update(&Frame::start());
        workshop.finish_tree();
        // Nobody is there to use it.
        workshop.show_panel(PanelId::Bench, false);
        let scene = workshop.scene();
        let views = views.get_or_insert_with(|| portrait::of_stage(scene));
        picture.draw_whole(scene, views, None)?;
        let both = side_by_side(&picture.read(None)?);
        export::png(&both, &folder.join(Album::file_name(step)))?;
    }
    Ok(steps.len())
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn steps_are_chosen_evenly_from_the_first_to_the_last() {
        for last in [0, 1, 7, 59, 60, 61, 70, 119, 10_000, u32::MAX] {
            let steps = pictured_steps(last);
            let all = u64::from(last) + 1;
            assert_eq!(
                steps.len() as u64,
                all.min(u64::from(MOST_PICTURES)),
                "{last}"
            );
            assert_eq!((steps.first(), steps.last()), (Some(&0), Some(&last)));
            let gaps: Vec<u32> = steps.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let [least, most] =
                [gaps.iter().min(), gaps.iter().max()].map(|gap| gap.copied().unwrap_or(0));
            assert!(last == 0 || (least >= 1 && most - least <= 1), "{last}");
        }
    }
}
