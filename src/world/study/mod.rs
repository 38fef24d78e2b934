//! A study: what a person is asked before, at and after their work, and what the answers come to.
//!
//! ```text
//! SSQ ─▶ tasks, each with a picture and a time ─▶ SUS, own statements ─▶ SSQ ─▶ thanks
//!                                                       └──────────▶ score
//! ```

pub mod flow;
pub mod score;

use flow::{Event, Study};

use super::World;
use super::document::{Document, Edit, EditError};
use super::panels::PanelId;

impl World {
    /// Begins a sitting or goes on with one; its panel comes.
    pub fn begin_study(&mut self, study: Study) {
        self.study = Some(study);
        self.tools.panels.show(PanelId::Study, true);
    }

    /// The sitting, if there is one.
    #[must_use]
    pub fn study(&self) -> Option<&Study> {
        self.study.as_ref()
    }

    /// Does what the participant wants. A task begins with an empty stage.
    ///
    /// # Errors
    /// Where the stage cannot be cleared.
    pub fn act_in_study(&mut self, event: Event) -> Result<(), EditError> {
        let Some(study) = &mut self.study else {
            return Ok(());
        };
        let begun = study.is_begun();
        study.act(event);
        let begins = study.is_running() && !begun;
        let made = |document: &Document| !document.sketch.is_empty() || document.step > 0;
        match begins && made(self.document()) {
            true => self.apply(Edit::Clear),
            false => Ok(()),
        }
    }
}
