//! Reading sessions, one frame at a time.

use std::io::{self, BufRead, Read as _};

use glam::{Quat, Vec2, Vec3};

use super::{Eye, MAGIC, MAX_FRAMES, MAX_LINE, SIDES, SessionError, VERSION, follows};
use crate::frame::{Fov, Frame, Hand, LATEST, Pose, View};

/// Reads a session frame by frame; an error ends it.
pub struct SessionReader<R> {
    lines: Lines<R>,
    /// The frame being put together; what is not said stays as in the frame before.
    frame: Frame,
    eyes: [Eye; 2],
    /// Which parts the present frame has said, a bit each.
    said: u32,
    /// Line of the present `frame`; 0 before the first.
    frame_line: u64,
    frames: usize,
    ended: bool,
}

impl<R: BufRead> SessionReader<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// [`SessionError`] where the input is not a session of this version.
    pub fn new(input: R) -> Result<Self, SessionError> {
        let mut lines = Lines {
            input,
            buffer: Vec::with_capacity(MAX_LINE),
            number: 0,
        };
        if !lines.advance()? {
            return Err(lines.fault_at(
                1,
                format!("the file is empty: a session begins with `{MAGIC} {VERSION}`"),
            ));
        }
        let mut words = lines.words()?;
        words.literal(MAGIC)?;
        let version = words.next("the number of the format's version")?;
        if version.text.parse::<u32>().ok() != Some(VERSION) {
            return Err(words.fault(
                version.column,
                format!(
                    "format {} is not known here: this Ramus reads format {VERSION}",
                    quoted(version.text)
                ),
            ));
        }
        words.end()?;
        Ok(Self {
            lines,
            frame: Frame::start(),
            eyes: Frame::eyes().map(Eye::Relative),
            said: 0,
            frame_line: 0,
            frames: 0,
            ended: false,
        })
    }

    fn next_frame(&mut self) -> Result<Option<Frame>, SessionError> {
        while self.lines.advance()? {
            let mut words = self.lines.words()?;
            let Some(first) = words.peek() else { continue };
            if first.text.starts_with('#') {
                continue;
            }
            if first.text == "frame" {
                words.skip();
                let before = (self.frame_line > 0).then_some(self.frame.time);
                let time = words.time(before)?;
                words.end()?;
                self.frames += 1;
                if self.frames > MAX_FRAMES {
                    return Err(words.fault(
                        first.column,
                        format!("more than {MAX_FRAMES} frames: split the session into parts"),
                    ));
                }
                let done = before.map(|_| self.finished()).transpose()?;
                self.frame.time = time;
                self.frame_line = self.lines.number;
                self.said = 0;
                if done.is_some() {
                    return Ok(done);
                }
                continue;
            }
            if self.frame_line == 0 {
                return Err(words.fault(
                    first.column,
                    "a session's first frame begins with a line `frame 0`".into(),
                ));
            }
            let part = read_part(&mut words, &mut self.frame, &mut self.eyes)?;
            words.end()?;
            if self.said & part != 0 {
                return Err(words.fault(
                    first.column,
                    "this frame has said that already: leave one of the lines out".into(),
                ));
            }
            self.said |= part;
        }
        self.ended = true;
        if self.frame_line == 0 {
            Ok(None)
        } else {
            self.finished().map(Some)
        }
    }

    /// The frame that has been read, with its views worked out.
    fn finished(&self) -> Result<Frame, SessionError> {
        let mut frame = self.frame;
        frame.views = self.eyes.map(|eye| eye.view(frame.head).settled());
        frame.check().map_err(|fault| SessionError::Syntax {
            line: self.frame_line,
            column: 1,
            message: fault.to_string(),
        })?;
        Ok(frame)
    }
}

impl<R: BufRead> Iterator for SessionReader<R> {
    type Item = Result<Frame, SessionError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let result = self.next_frame();
        if result.is_err() {
            self.ended = true;
        }
        result.transpose()
    }
}

/// Reads the rest of a line that says one part of a frame; gives that part's bit.
fn read_part(
    words: &mut Words<'_>,
    frame: &mut Frame,
    eyes: &mut [Eye; 2],
) -> Result<u32, SessionError> {
    /// Bits that a hand takes.
    const HAND_BITS: u32 = 10;
    let word = words.next("a part of the frame")?;
    let Some(side) = SIDES.iter().position(|&side| side == word.text) else {
        return Ok(match word.text {
            "focused" => {
                frame.focused = words.yes()?;
                1
            }
            "render" => {
                frame.should_render = words.yes()?;
                1 << 1
            }
            "head" => {
                frame.head = words.pose()?;
                1 << 2
            }
            other => {
                return Err(words.fault(
                    word.column,
                    format!("{} is unknown: a line begins with frame, focused, render, head, left or right", quoted(other)),
                ));
            }
        });
    };
    let word = words.next("what of that side is meant, such as aim or trigger")?;
    let hand: &mut Hand = &mut frame.hands[side];
    let bit = match word.text {
        "eye" => {
            eyes[side] = Eye::Relative(words.view()?);
            0
        }
        "view" => {
            eyes[side] = Eye::Absolute(words.view()?);
            0
        }
        "tracked" => {
            hand.tracked = words.yes()?;
            1
        }
        "aim" => {
            hand.aim = words.pose()?;
            2
        }
        "grip" => {
            hand.grip = words.pose()?;
            3
        }
        "trigger" => {
            hand.trigger = words.number(0.0, 1.0)?;
            4
        }
        "squeeze" => {
            hand.squeeze = words.number(0.0, 1.0)?;
            5
        }
        "stick" => {
            hand.stick = Vec2::new(words.number(-1.0, 1.0)?, words.number(-1.0, 1.0)?);
            6
        }
        "lower" => {
            hand.lower = words.yes()?;
            7
        }
        "upper" => {
            hand.upper = words.yes()?;
            8
        }
        other => {
            return Err(words.fault(
                word.column,
                format!(
                    "{} is unknown: a side has eye, view, tracked, aim, grip, trigger, squeeze, stick, lower and upper",
                    quoted(other)
                ),
            ));
        }
    };
    Ok(if side == 0 {
        1 << (3 + bit)
    } else {
        1 << (3 + HAND_BITS + bit)
    })
}

/// The input, a bounded line at a time.
struct Lines<R> {
    input: R,
    buffer: Vec<u8>,
    number: u64,
}

impl<R: BufRead> Lines<R> {
    /// Reads the next line into the buffer; false at the end of the input.
    fn advance(&mut self) -> Result<bool, SessionError> {
        self.buffer.clear();
        self.number += 1;
        let limit = MAX_LINE as u64 + 1;
        let read = loop {
            match self
                .input
                .by_ref()
                .take(limit)
                .read_until(b'\n', &mut self.buffer)
            {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                result => break result?,
            }
        };
        if self.buffer.last() == Some(&b'\n') {
            self.buffer.pop();
        }
        if self.buffer.len() > MAX_LINE {
            return Err(self.fault_at(
                MAX_LINE + 1,
                format!("the line is longer than {MAX_LINE} bytes"),
            ));
        }
        Ok(read > 0)
    }

    fn words(&self) -> Result<Words<'_>, SessionError> {
        match std::str::from_utf8(&self.buffer) {
            Ok(text) => Ok(Words {
                text,
                at: 0,
                line: self.number,
            }),
            Err(error) => Err(self.fault_at(
                error.valid_up_to() + 1,
                "this is not text: a session is UTF-8".into(),
            )),
        }
    }

    fn fault_at(&self, column: usize, message: String) -> SessionError {
        SessionError::Syntax {
            line: self.number,
            column,
            message,
        }
    }
}

/// A word of a line and where it stands.
#[derive(Clone, Copy)]
struct Word<'a> {
    text: &'a str,
    column: usize,
}

/// The words of one line.
struct Words<'a> {
    text: &'a str,
    /// Byte at which the next word is looked for.
    at: usize,
    line: u64,
}

impl<'a> Words<'a> {
    fn peek(&self) -> Option<Word<'a>> {
        let rest = self.text.get(self.at..)?;
        let trimmed = rest.trim_ascii_start();
        let text = trimmed.split_ascii_whitespace().next()?;
        Some(Word {
            text,
            column: self.at + rest.len() - trimmed.len() + 1,
        })
    }

    fn skip(&mut self) {
        if let Some(word) = self.peek() {
            self.at = word.column - 1 + word.text.len();
        }
    }

    fn next(&mut self, wanted: &str) -> Result<Word<'a>, SessionError> {
        let word = self.peek().ok_or_else(|| {
            self.fault(
                self.text.len() + 1,
                format!("the line ends too early: here stands {wanted}"),
            )
        })?;
        self.skip();
        Ok(word)
    }

    fn literal(&mut self, wanted: &str) -> Result<(), SessionError> {
        let word = self.next(&quoted(wanted))?;
        if word.text == wanted {
            Ok(())
        } else {
            Err(self.fault(
                word.column,
                format!("this is no session: it would begin with {}", quoted(wanted)),
            ))
        }
    }

    fn end(&self) -> Result<(), SessionError> {
        match self.peek() {
            Some(word) => Err(self.fault(
                word.column,
                format!("{} is one word too many", quoted(word.text)),
            )),
            None => Ok(()),
        }
    }

    fn yes(&mut self) -> Result<bool, SessionError> {
        let word = self.next("yes or no")?;
        match word.text {
            "yes" => Ok(true),
            "no" => Ok(false),
            other => Err(self.fault(
                word.column,
                format!("{} is neither yes nor no", quoted(other)),
            )),
        }
    }

    fn number(&mut self, from: f32, to: f32) -> Result<f32, SessionError> {
        let word = self.next("a number")?;
        match word.text.parse::<f32>() {
            // A NaN is in no range.
            Ok(value) if (from..=to).contains(&value) => Ok(value),
            Ok(_) => Err(self.fault(
                word.column,
                format!("{} is not between {from} and {to}", quoted(word.text)),
            )),
            Err(_) => Err(self.fault(
                word.column,
                format!("{} is no number: write one such as 0.25", quoted(word.text)),
            )),
        }
    }

    fn finite(&mut self) -> Result<f32, SessionError> {
        let word = self.peek();
        match self.number(f32::MIN, f32::MAX) {
            Err(SessionError::Syntax { column, .. })
                if word.is_some_and(|word| word.text.parse::<f32>().is_ok()) =>
            {
                Err(self.fault(column, "a number here is finite".into()))
            }
            result => result,
        }
    }

    fn time(&mut self, before: Option<f64>) -> Result<f64, SessionError> {
        let word = self.next("the frame's time in seconds")?;
        let time = word
            .text
            .parse::<f64>()
            .ok()
            .filter(|time| (0.0..=LATEST).contains(time))
            .ok_or_else(|| {
                self.fault(
                    word.column,
                    format!(
                        "{} is no time: write seconds between 0 and {LATEST}",
                        quoted(word.text)
                    ),
                )
            })?;
        match before {
            Some(before) if !follows(before, time) => Err(self.fault(
                word.column,
                format!(
                    "a frame follows the one before, at {before}, by 0 to 0.1 s: {} does not",
                    quoted(word.text)
                ),
            )),
            _ => Ok(time),
        }
    }

    fn pose(&mut self) -> Result<Pose, SessionError> {
        let column = self.peek().map_or(self.text.len() + 1, |word| word.column);
        let mut values = [0.0; 7];
        for value in &mut values {
            *value = self.finite()?;
        }
        let [x, y, z, qx, qy, qz, qw] = values;
        let pose = Pose {
            orientation: Quat::from_xyzw(qx, qy, qz, qw),
            position: Vec3::new(x, y, z),
        };
        if pose.is_sane() {
            Ok(pose.settled())
        } else {
            Err(self.fault(
                column,
                "a pose is a position within 10 km and a unit quaternion: X Y Z, then QX QY QZ QW"
                    .into(),
            ))
        }
    }

    fn view(&mut self) -> Result<View, SessionError> {
        let column = self.peek().map_or(self.text.len() + 1, |word| word.column);
        let mut values = [0.0; 4];
        for value in &mut values {
            *value = self.finite()?;
        }
        let [left, right, up, down] = values;
        let fov = Fov {
            left,
            right,
            up,
            down,
        };
        if !fov.is_sane() {
            return Err(self.fault(
                column,
                "a field of view is LEFT RIGHT UP DOWN in radians, each within 1.56, right above left and up above down".into(),
            ));
        }
        Ok(View {
            pose: self.pose()?,
            fov,
        })
    }

    fn fault(&self, column: usize, message: String) -> SessionError {
        SessionError::Syntax {
            line: self.line,
            column,
            message,
        }
    }
}

/// A word as an error shows it: bounded, with nothing that a terminal would obey.
fn quoted(word: &str) -> String {
    const SHOWN: usize = 24;
    let mut shown: String = word
        .chars()
        .take(SHOWN)
        .flat_map(char::escape_debug)
        .collect();
    if word.chars().nth(SHOWN).is_some() {
        shown.push('…');
    }
    format!("`{shown}`")
}
