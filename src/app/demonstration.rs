//! What Ramus shows where there is no headset: the recorded first session, and the steps of a project.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};
use ramus_xr::Frame;

use crate::app::album::Album;
use crate::app::export;
use crate::app::picture::{Picture, side_by_side};
use crate::app::workshop::Workshop;
use crate::sketch::predict_segments_within;
use crate::world::document::Document;
use crate::world::history::History;
use crate::world::{GrowthParams, World};

/// `assets/sessions/first-tree.session`, built in so that the program works from any folder.
const FIRST_TREE: &[u8] = include_bytes!("../../assets/sessions/first-tree.session");

/// Growth steps that are pictured at most, the last ones: a project may be at step 10,000.
const MOST_STEPS: u32 = 60;

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

/// Pictures each growth step of a document as a person at the platform sees it; gives how many.
///
/// # Errors
/// Where a step cannot be grown, drawn or written.
pub fn every_step(
    document: &Document,
    picture: &mut Picture,
    folder: &Path,
    mut progress: impl FnMut(usize, usize),
) -> Result<usize> {
    let frame = Frame::start();
    let first = document.step.saturating_sub(MOST_STEPS - 1);
    let steps = first..=document.step;
    let most = (document.step - first + 1) as usize;
    for (done, step) in steps.enumerate() {
        progress(done, most);
        let document = Document {
            step,
            ..document.clone()
        };
        let mut workshop = Workshop::unsaved(World::new(History::new(document)))?;
        let mut frame = frame;
        // A second of standing still: the newest step has grown whole then.
        while {
            workshop.update(&frame);
            workshop.finish_tree();
            frame.time < 1.0
        } {
            frame.time += 0.1;
        }
        picture.draw_whole(workshop.scene(), &frame.views, None)?;
        let both = side_by_side(&picture.read(None)?);
        export::png(&both, &folder.join(Album::file_name(step)))?;
    }
    Ok(most)
}
