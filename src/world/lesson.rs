//! The tutorial: every control, learnt by doing it.
//!
//! A lesson is over when what it teaches was done, however it was done. None can be stuck in: one that needs something
//! that is not there (a node to move, an edit to redo) shows the lesson that makes it instead, and each can be skipped
//! or gone back from. Where a person stopped, they go on.

use crate::sketch::Sketch;

use super::{
    World,
    document::{Document, Edit},
    handles::HandleId,
    history::Action,
    panels::PanelId,
    tools::{Hold, Tools},
};

/// What is learnt, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Lesson {
    /// The first piece of the trunk.
    Draw,
    /// A second one.
    DrawOn,
    /// A free-hand stroke.
    FreeHand,
    /// A branch from a node.
    Branch,
    /// Growth, a step.
    Grow,
    /// A step back.
    Back,
    /// A node moved.
    Move,
    /// A node deleted.
    Delete,
    /// The last edit undone.
    Undo,
    /// And redone.
    Redo,
    /// The platform taken by its rim.
    Platform,
    /// The lever.
    Lever,
    /// The wheel.
    Wheel,
    /// A panel pressed.
    Panel,
    /// The panel on the back of a hand.
    Wrist,
    /// The stump.
    Stump,
}

/// What of a controller a lesson is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// What draws.
    Draw,
    /// What grabs.
    Grab,
    /// What grows.
    Grow,
    /// What steps back.
    Back,
    /// What undoes and redoes.
    Undo,
    /// The hand as a whole.
    Hand,
}

impl Lesson {
    /// All of them.
    pub const ALL: [Self; 16] = [
        Self::Draw,
        Self::DrawOn,
        Self::FreeHand,
        Self::Branch,
        Self::Grow,
        Self::Back,
        Self::Move,
        Self::Delete,
        Self::Undo,
        Self::Redo,
        Self::Platform,
        Self::Lever,
        Self::Wheel,
        Self::Panel,
        Self::Wrist,
        Self::Stump,
    ];

    /// The part of the controller that it takes.
    #[must_use]
    pub fn part(self) -> Part {
        match self {
            Self::Draw
            | Self::DrawOn
            | Self::FreeHand
            | Self::Branch
            | Self::Panel
            | Self::Stump => Part::Draw,
            Self::Move | Self::Delete | Self::Platform | Self::Lever | Self::Wheel => Part::Grab,
            Self::Grow => Part::Grow,
            Self::Back => Part::Back,
            Self::Undo | Self::Redo => Part::Undo,
            Self::Wrist => Part::Hand,
        }
    }

    /// The lesson that is shown for this one: itself, or the one that makes what it needs.
    fn shown(self, document: &Document, [undo, redo]: [usize; 2]) -> Self {
        let drawn = !document.sketch.is_empty();
        let can = match self {
            Self::Draw | Self::FreeHand | Self::Platform | Self::Panel | Self::Wrist => true,
            Self::Back => document.step > 0,
            Self::Redo => redo > 0,
            Self::Undo => undo > 0,
            Self::Branch => document
                .sketch
                .strokes
                .iter()
                .any(|stroke| stroke.segments() > 1),
            _ => drawn,
        };
        match self {
            _ if can => self,
            Self::Redo if undo > 0 => Self::Undo,
            Self::Back if drawn => Self::Grow,
            Self::Branch if drawn => Self::DrawOn,
            _ => Self::Draw,
        }
    }

    /// Whether an action is what it teaches. `before`: the document's step and its strokes before the action.
    fn is_done_by(self, action: &Action, before: (u32, usize), after: &Sketch) -> bool {
        let drew = matches!(
            action,
            Action::Edit(Edit::AddSegment { .. } | Edit::AddStroke { .. } | Edit::DrawCurve { .. })
        );
        match (self, action) {
            (Self::Draw | Self::DrawOn, _) => drew,
            (Self::Branch, _) => drew && after.strokes.len() > before.1,
            (Self::Grow, Action::Edit(Edit::SetStep { step })) => *step > before.0,
            (Self::Back, Action::Edit(Edit::SetStep { step })) => *step < before.0,
            (Self::FreeHand, Action::Edit(Edit::DrawCurve { .. }))
            | (Self::Move, Action::Edit(Edit::MoveNode { .. }))
            | (Self::Delete, Action::Edit(Edit::DeleteNode { .. }))
            | (Self::Undo, Action::Undo)
            | (Self::Redo, Action::Redo)
            | (Self::Platform, Action::Edit(Edit::SetPlatform { .. }))
            | (Self::Lever, Action::Edit(Edit::SetDivergence { .. }))
            | (Self::Stump, Action::Edit(Edit::Clear)) => true,
            _ => false,
        }
    }

    /// Whether it is being done by what hands hold now.
    fn is_done_with(self, tools: &Tools) -> bool {
        let holds = |wanted: fn(Hold) -> bool| tools.hands.iter().any(|hand| wanted(hand.hold));
        match self {
            Self::Wheel => {
                holds(|hold| hold == Hold::Handle(HandleId::Wheel)) && tools.handles.moved
            }
            Self::Panel => {
                holds(|hold| matches!(hold, Hold::Panel { id, .. } if id != PanelId::Lesson))
            }
            Self::Wrist => tools.panels.is_shown(PanelId::Wrist),
            _ => false,
        }
    }
}

/// How far somebody has come; `None`: no tutorial is going on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Course {
    at: Option<usize>,
    /// Step and strokes when it was looked at last.
    before: (u32, usize),
}

impl World {
    /// The lesson that is going on: its number from 0, and what is to be done.
    #[must_use]
    pub fn lesson(&self) -> Option<(usize, Lesson)> {
        let at = self.course.at?;
        let undo = [self.history.undo_count(), self.history.redo_count()];
        let lesson = *Lesson::ALL.get(at)?;
        Some((at, lesson.shown(self.document(), undo)))
    }

    /// Begins or goes on with a lesson; beyond the last one, or with none, the tutorial ends.
    pub fn teach(&mut self, lesson: Option<usize>) {
        // Where there are no hands there is no back of one.
        let desk = self.buttons().desk;
        let has = |lesson: Lesson| !(desk && lesson == Lesson::Wrist);
        let lesson = lesson.map(|at| match Lesson::ALL.get(at) {
            Some(lesson) if !has(*lesson) => at + 1,
            _ => at,
        });
        self.course.at = lesson.filter(|at| *at < Lesson::ALL.len());
        self.course.before = self.now();
        self.tools
            .panels
            .show(PanelId::Lesson, self.course.at.is_some());
    }

    fn now(&self) -> (u32, usize) {
        let document = self.document();
        (document.step, document.sketch.strokes.len())
    }

    /// Looks whether the lesson was done by these actions or is being done by the hands.
    pub(super) fn learn(&mut self, actions: &[Action]) {
        let before = self.course.before;
        self.course.before = self.now();
        let Some((at, lesson)) = self.lesson_asked(actions) else {
            return;
        };
        let after = &self.document().sketch;
        // A stroke takes back the piece that it began as: only an undo with nothing behind it was meant.
        let meant = match lesson {
            Lesson::Undo => actions.last().map_or(&[][..], std::slice::from_ref),
            _ => actions,
        };
        let done = meant
            .iter()
            .any(|action| lesson.is_done_by(action, before, after))
            || lesson.is_done_with(&self.tools);
        let own = Lesson::ALL.get(at) == Some(&lesson);
        if done && own {
            self.teach(Some(at + 1));
        }
    }

    /// The lesson as it was before these actions: what they did may be what it needed.
    fn lesson_asked(&self, actions: &[Action]) -> Option<(usize, Lesson)> {
        let (at, shown) = self.lesson()?;
        let lesson = *Lesson::ALL.get(at)?;
        Some((at, if actions.is_empty() { shown } else { lesson }))
    }
}
