//! Ties everything together: the frame loop, the workers, the project on disk, and messages to the person.
//!
//! ```text
//! headset ─ frame ─▶ workshop (world, journal, tree) ─ scene ─▶ picture (renderer, board) ─▶ headset, PNG
//!            session::run is the loop; album watches it; store keeps the project
//! ```

pub mod again;
pub mod album;
pub mod centerlines;
pub mod convert;
pub mod demonstration;
pub mod doctor;
pub mod ends;
pub mod export;
pub mod film;
mod finding;
pub mod headset;
mod layers;
pub mod memory;
pub mod model_portrait;
pub mod opening;
pub mod person;
pub mod picture;
pub mod portrait;
mod queue;
pub(crate) mod scans;
pub mod session;
pub mod store;
pub mod studies;
pub mod take_home;
mod takeaway;
pub mod window;
pub mod worker;
pub mod workshop;
