//! Edits that are tried out: what a slider, the lever, the wheel or playback shows before it is let go.
//!
//! Nothing is written to the history meanwhile; letting go makes one edit of all that was tried, so that one
//! movement is one step of undo. What is tried lies over the committed document and is made anew when
//! that changes; an edit that is refused then is dropped.

use std::{borrow::Cow, mem::discriminant};

use super::{
    document::{Document, Edit, EditError},
    history::History,
    tools::Tools,
};

/// What is tried, at most one edit of a kind, and what it makes of the document.
#[derive(Debug, Default)]
pub(super) struct Tried {
    edits: Vec<Edit>,
    /// The committed document and what the edits make of it.
    made: Option<(Document, Document)>,
}

impl Tried {
    /// Tries an edit in place of the last of its kind.
    ///
    /// # Errors
    /// Where it is refused; the last one stays.
    fn set(&mut self, edit: Edit, committed: &Document) -> Result<(), EditError> {
        let edit = edit.quantized();
        if self.edits.contains(&edit) {
            return Ok(());
        }
        committed.after(&edit)?;
        let kind = discriminant(&edit);
        match self.edits.iter_mut().find(|old| discriminant(*old) == kind) {
            Some(old) => *old = edit,
            None => self.edits.push(edit),
        }
        self.made = None;
        Ok(())
    }

    /// The document with what is tried.
    pub(super) fn over<'a>(&mut self, committed: &'a Document) -> Cow<'a, Document> {
        if self.edits.is_empty() {
            return Cow::Borrowed(committed);
        }
        if let Some((of, made)) = &self.made
            && same(of, committed)
        {
            return Cow::Owned(made.clone());
        }
        let mut made = committed.clone();
        self.edits.retain(|edit| match made.after(edit) {
            Ok(next) => {
                made = next;
                true
            }
            Err(_) => false,
        });
        self.made = Some((committed.clone(), made.clone()));
        Cow::Owned(made)
    }
}

/// Whether two documents are the same value, without looking into the sketch.
fn same(a: &Document, b: &Document) -> bool {
    std::sync::Arc::ptr_eq(&a.sketch, &b.sketch)
        && std::sync::Arc::ptr_eq(&a.models, &b.models)
        && std::sync::Arc::ptr_eq(&a.grove, &b.grove)
        && (a.step, a.platform, a.selected, a.linked) == (b.step, b.platform, b.selected, b.linked)
}

impl Tools {
    /// Shows the document as it would be after an edit, in place of the last one of its kind that is tried.
    ///
    /// # Errors
    /// Where the edit is refused; what was tried stays.
    pub(super) fn try_out(&mut self, edit: Edit, history: &History) -> Result<(), EditError> {
        self.tried.set(edit, history.committed())
    }

    /// Makes edits of what is tried.
    pub(super) fn settle(&mut self, history: &mut History) {
        self.tried.made = None;
        for edit in std::mem::take(&mut self.tried.edits) {
            // What could be tried on this document can be done to it; where it changed meanwhile, the edit is void.
            let _ = history.apply(edit);
        }
    }

    /// Forgets what is tried.
    pub(super) fn untry(&mut self) {
        self.tried = Tried::default();
    }
}
