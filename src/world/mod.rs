//! What stands on stage and what each tool does: pure logic, no GPU, no OpenXR, no threads.

pub mod document;
pub mod history;
pub mod input;
pub mod scene;
