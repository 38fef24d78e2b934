//! Ties everything together: the frame loop, the workers, the project on disk, and messages to the person.
//!
//! ```text
//! headset ─ frame ─▶ workshop (world, journal, tree) ─ scene ─▶ picture (renderer, board) ─▶ headset, PNG
//!            session::run is the loop; album watches it; store keeps the project
//! ```

mod abstracting;
pub mod again;
pub mod album;
pub mod analysis;
pub mod centerlines;
pub mod cohort;
pub mod compared;
mod comparing;
pub mod convert;
pub mod demonstration;
pub mod doctor;
pub mod ends;
pub mod export;
pub mod film;
mod finding;
mod flat;
pub mod headset;
pub mod individuals;
mod layers;
pub mod memory;
pub mod model_portrait;
pub mod opening;
pub mod person;
pub mod picture;
mod planting;
mod plot;
pub mod portrait;
mod previews;
mod queue;
mod rate;
pub(crate) mod scans;
pub mod session;
pub mod store;
pub mod studies;
pub mod study;
pub mod table;
pub mod take_home;
pub(crate) mod takeaway;
pub mod tradeoff;
pub mod trees;
pub mod window;
pub mod wood;
pub mod worker;
pub mod workshop;

/// An error with its causes in one line; a cause that the text says already is not said twice.
pub fn sentence(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |said, cause| {
        let cause = cause.to_string();
        match said.is_empty() {
            true => cause,
            false if said.contains(&cause) => said,
            false => format!("{said}: {cause}"),
        }
    })
}
