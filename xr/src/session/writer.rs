//! Writing sessions, one frame at a time.

use std::fmt::Write as _;
use std::io::Write;

use glam::{Quat, Vec3};

use super::{Eye, MAGIC, MAX_FRAMES, MAX_LINE, SIDES, SessionError, VERSION, follows};
use crate::frame::{Frame, Hand, Pose, View};

/// Writes a session frame by frame: only what changed.
pub struct SessionWriter<W> {
    output: W,
    /// One frame's text; kept, so that a warm writer allocates nothing.
    text: String,
    before: Frame,
    eyes: [Eye; 2],
    frames: usize,
}

impl<W: Write> SessionWriter<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// [`SessionError::Io`] where the output takes nothing.
    pub fn new(mut output: W) -> Result<Self, SessionError> {
        writeln!(output, "{MAGIC} {VERSION}")?;
        Ok(Self {
            output,
            text: String::with_capacity(1024),
            before: Frame::start(),
            eyes: Frame::eyes().map(Eye::Relative),
            frames: 0,
        })
    }

    /// Writes a comment: the first line of `text`, as much of it as a line holds. Readers leave it out.
    ///
    /// # Errors
    /// [`SessionError::Io`] where the output takes nothing.
    pub fn comment(&mut self, text: &str) -> Result<(), SessionError> {
        let line = text.lines().next().unwrap_or_default();
        let most = line.len().min(MAX_LINE - "# ".len());
        let end = (0..=most).rev().find(|&end| line.is_char_boundary(end));
        let fits = line.get(..end.unwrap_or(0)).unwrap_or_default();
        writeln!(self.output, "# {fits}")?;
        Ok(())
    }

    /// Writes one frame. A frame that is refused leaves the session as it was.
    ///
    /// # Errors
    /// [`SessionError`] where the frame is not sane, its time does not follow, or the output fails.
    pub fn write(&mut self, frame: &Frame) -> Result<(), SessionError> {
        let number = self.frames + 1;
        frame.check().map_err(|fault| SessionError::Fault {
            frame: number,
            fault,
        })?;
        if self.frames > 0 && !follows(self.before.time, frame.time) {
            return Err(SessionError::Time { frame: number });
        }
        if number > MAX_FRAMES {
            return Err(SessionError::TooLong);
        }
        self.text.clear();
        let text = &mut self.text;
        let before = &self.before;
        text.push_str("frame");
        push_time(text, frame.time);
        text.push('\n');
        push_yes(text, &["focused"], before.focused, frame.focused);
        push_yes(text, &["render"], before.should_render, frame.should_render);
        if !same_pose(before.head, frame.head) {
            text.push_str("head");
            push_pose(text, frame.head);
            text.push('\n');
        }
        let mut eyes = self.eyes;
        for (side, eye) in eyes.iter_mut().enumerate() {
            push_view(text, SIDES[side], eye, frame.head, frame.views[side]);
        }
        for (side, name) in SIDES.iter().enumerate() {
            push_hand(text, name, &before.hands[side], &frame.hands[side]);
        }
        self.output.write_all(text.as_bytes())?;
        self.before = *frame;
        self.eyes = eyes;
        self.frames = number;
        Ok(())
    }

    /// Writes out what is buffered and gives the output back.
    ///
    /// # Errors
    /// [`SessionError::Io`] where the output fails.
    pub fn finish(mut self) -> Result<W, SessionError> {
        self.output.flush()?;
        Ok(self.output)
    }
}

fn push_hand(text: &mut String, side: &str, before: &Hand, hand: &Hand) {
    push_yes(text, &[side, " tracked"], before.tracked, hand.tracked);
    for (name, old, new) in [
        (" aim", before.aim, hand.aim),
        (" grip", before.grip, hand.grip),
    ] {
        if !same_pose(old, new) {
            text.push_str(side);
            text.push_str(name);
            push_pose(text, new);
            text.push('\n');
        }
    }
    for (name, old, new) in [
        (" trigger", &[before.trigger][..], &[hand.trigger][..]),
        (" squeeze", &[before.squeeze][..], &[hand.squeeze][..]),
        (
            " stick",
            &before.stick.to_array()[..],
            &hand.stick.to_array()[..],
        ),
    ] {
        if !same(old, new) {
            text.push_str(side);
            text.push_str(name);
            for &value in new {
                push_number(text, value);
            }
            text.push('\n');
        }
    }
    push_yes(text, &[side, " lower"], before.lower, hand.lower);
    push_yes(text, &[side, " upper"], before.upper, hand.upper);
}

/// Says where an eye is, unless what was said of it still holds.
fn push_view(text: &mut String, side: &str, eye: &mut Eye, head: Pose, view: View) {
    if says(*eye, head, view) {
        return;
    }
    // An eye fixed to the head is said once; rounding finds the offset that the numbers came from.
    let offset = head.inverse() * view.pose;
    let fixed = View {
        pose: Pose {
            orientation: Quat::from_array(offset.orientation.to_array().map(rounded)),
            position: Vec3::from_array(offset.position.to_array().map(rounded)),
        },
        fov: view.fov,
    };
    let relative = Eye::Relative(fixed.settled());
    let (word, said) = if fixed.pose.is_sane() && says(relative, head, view) {
        *eye = relative;
        (" eye", fixed)
    } else {
        *eye = Eye::Absolute(view);
        (" view", view)
    };
    text.push_str(side);
    text.push_str(word);
    for value in [said.fov.left, said.fov.right, said.fov.up, said.fov.down] {
        push_number(text, value);
    }
    push_pose(text, said.pose);
    text.push('\n');
}

/// Whether the reader makes the same of `eye` as of `view` written out; it settles whatever it reads and works out.
/// Of a head that is not settled yet it is enough that the eye moves with it.
fn says(eye: Eye, head: Pose, view: View) -> bool {
    let settled = head.settled();
    same_view(eye.view(settled).settled(), view.settled())
        || (!same_pose(settled, head) && same_view(eye.view(head), view))
}

/// To a hundredth of a millimetre; never a negative zero.
fn rounded(value: f32) -> f32 {
    const STEPS: f32 = 1e5;
    (value * STEPS).round() / STEPS + 0.0
}

fn push_yes(text: &mut String, words: &[&str], old: bool, new: bool) {
    if old != new {
        for word in words {
            text.push_str(word);
        }
        text.push_str(if new { " yes\n" } else { " no\n" });
    }
}

fn push_pose(text: &mut String, pose: Pose) {
    for value in pose
        .position
        .to_array()
        .into_iter()
        .chain(pose.orientation.to_array())
    {
        push_number(text, value);
    }
}

/// `Debug` prints the shortest text that reads back to the same bits, with exponents where they are shorter.
fn push_number(text: &mut String, value: f32) {
    let _ = write!(text, " {value:?}");
    trim_point(text);
}

fn push_time(text: &mut String, time: f64) {
    let _ = write!(text, " {time:?}");
    trim_point(text);
}

fn trim_point(text: &mut String) {
    if text.ends_with(".0") {
        text.truncate(text.len() - 2);
    }
}

/// Same bits: −0 and 0 differ, so that a round trip is exact.
fn same(a: &[f32], b: &[f32]) -> bool {
    a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

fn same_pose(a: Pose, b: Pose) -> bool {
    same(&a.position.to_array(), &b.position.to_array())
        && same(&a.orientation.to_array(), &b.orientation.to_array())
}

fn same_view(a: View, b: View) -> bool {
    let angles = |view: View| [view.fov.left, view.fov.right, view.fov.up, view.fov.down];
    same_pose(a.pose, b.pose) && same(&angles(a), &angles(b))
}
