//! Undo and redo of every edit, without limit.
//!
//! The history keeps whole documents, not inverse edits: nothing has to know how to undo itself,
//! and undo gives back the very value that was there. Documents share the sketch, and sketches
//! their strokes, so a step of history costs one small allocation and what the edit really changed.
//! The price is memory that grows with the session: some hundred bytes an edit.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::document::{Document, Edit, EditError};

/// One line of the journal: what was done, in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// An edit, its numbers on the grid.
    Edit(Edit),
    /// Undo of the last edit not undone.
    Undo,
    /// Redo of the last edit undone.
    Redo,
}

/// The document with its past and its undone future.
#[derive(Clone, Debug)]
pub struct History {
    past: Vec<Arc<Document>>,
    present: Arc<Document>,
    /// The next one to redo is the last.
    future: Vec<Arc<Document>>,
    log: Vec<Action>,
    /// How often the document was replaced.
    changes: u64,
}

impl Default for History {
    fn default() -> Self {
        Self::new(Document::default())
    }
}

impl History {
    /// A history that begins with `document`.
    #[must_use]
    pub fn new(document: Document) -> Self {
        Self {
            past: Vec::new(),
            present: Arc::new(document),
            future: Vec::new(),
            log: Vec::new(),
            changes: 0,
        }
    }

    /// The document as it is to be saved: without what hands are still holding, which the tools show.
    #[must_use]
    pub fn committed(&self) -> &Document {
        &self.present
    }

    /// Applies an edit. One that changes nothing is not recorded.
    ///
    /// # Errors
    /// Where the edit is refused: nothing changes then.
    pub fn apply(&mut self, edit: Edit) -> Result<(), EditError> {
        let edit = edit.quantized();
        let next = self.present.after(&edit)?;
        if next == *self.present {
            return Ok(());
        }
        self.past
            .push(std::mem::replace(&mut self.present, Arc::new(next)));
        self.future.clear();
        self.changes += 1;
        self.log.push(Action::Edit(edit));
        Ok(())
    }

    /// Undoes the last edit. False: there is none.
    pub fn undo(&mut self) -> bool {
        let Some(document) = self.past.pop() else {
            return false;
        };
        self.future
            .push(std::mem::replace(&mut self.present, document));
        self.changes += 1;
        self.log.push(Action::Undo);
        true
    }

    /// What was undone cannot be redone any more.
    pub fn forget_undone(&mut self) {
        self.future.clear();
    }

    /// Takes the last edit back, because it goes on as another: it cannot be redone. In the journal that is an undo, with
    /// whatever comes next behind it. False: there is none.
    pub fn take_back(&mut self) -> bool {
        let done = self.undo();
        if done {
            self.future.pop();
        }
        done
    }

    /// How often the document was replaced so far, by an edit, an undo or a redo.
    #[must_use]
    pub fn changes(&self) -> u64 {
        self.changes
    }

    /// Redoes the last edit undone. False: there is none.
    pub fn redo(&mut self) -> bool {
        let Some(document) = self.future.pop() else {
            return false;
        };
        self.past
            .push(std::mem::replace(&mut self.present, document));
        self.changes += 1;
        self.log.push(Action::Redo);
        true
    }

    /// How many edits can be undone.
    #[must_use]
    pub fn undo_count(&self) -> usize {
        self.past.len()
    }

    /// How many edits can be redone.
    #[must_use]
    pub fn redo_count(&self) -> usize {
        self.future.len()
    }

    /// Repeats an action of a journal.
    ///
    /// # Errors
    /// Where an edit is refused, and where there is nothing to undo or redo: only what was done is
    /// ever written down, so the journal does not belong to this history then.
    pub fn repeat(&mut self, action: Action) -> Result<(), EditError> {
        let repeated = match action {
            Action::Edit(edit) => {
                self.apply(edit)?;
                true
            }
            Action::Undo => self.undo(),
            Action::Redo => self.redo(),
        };
        if repeated {
            Ok(())
        } else {
            Err(EditError::NothingToRepeat)
        }
    }

    /// Takes what was done since the last call, in order, for the journal.
    pub fn take_log(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.log)
    }
}
