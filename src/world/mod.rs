//! What stands on stage and what each tool does: pure logic, no GPU, no OpenXR, no threads.

pub mod document;
#[cfg(test)]
mod document_tests;
pub mod history;
pub mod input;
pub mod journal;
pub mod project;
pub mod scene;
