//! Ties everything together: the frame loop, the worker, autosave and messages to the person.

pub mod convert;
pub mod worker;
