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
        self.before_task = self.history.undo_count();
        self.tools.panels.show(PanelId::Study, true);
    }

    /// The sitting, if there is one.
    #[must_use]
    pub fn study(&self) -> Option<&Study> {
        self.study.as_ref()
    }

    /// Does what the participant wants. A task begins with an empty stage, and with nothing to undo or redo.
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
        if !begins {
            return Ok(());
        }
        if made(self.document()) {
            self.apply(Edit::Clear)?;
        }
        self.history.forget_undone();
        self.before_task = self.history.undo_count();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use glam::Vec3;

    use super::flow::Page;
    use super::*;
    use crate::world::history::History;

    fn at_the_first_task() -> World {
        let mut world = World::new(History::default());
        world.begin_study(flow::tests::begun());
        while !matches!(world.study().unwrap().page(), Page::Task(_)) {
            world.act_in_study(Event::Next).unwrap();
        }
        world
    }

    fn draw(world: &mut World, y: f32) {
        let to = Vec3::Y * y;
        world.apply(Edit::AddSegment { to }).unwrap();
    }

    #[test]
    fn in_a_task_nothing_of_before_is_undone_or_redone() {
        let mut world = at_the_first_task();
        draw(&mut world, 0.2);
        draw(&mut world, 0.4);
        assert!(world.undo() && world.undo_count() == 1);
        world.act_in_study(Event::Begin).unwrap();
        assert!(world.document().sketch.is_empty());
        assert!(world.undo_count() == 0 && !world.undo() && !world.redo());
        assert!(world.document().sketch.is_empty());
        draw(&mut world, 0.3);
        assert!(world.undo() && !world.undo() && world.redo());
        // When it is over all of it can be undone again.
        world.act_in_study(Event::Done).unwrap();
        assert!(world.undo_count() > 1);
    }
}
