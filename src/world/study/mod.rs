//! A study: what a person is asked before, at and after their work, and what the answers come to.
//!
//! ```text
//! SSQ ─▶ tasks, each with a picture and a time ─▶ SUS, own statements ─▶ SSQ ─▶ thanks
//!                                                       └──────────▶ score
//! ```

pub mod score;
