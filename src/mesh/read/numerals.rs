//! Numbers as text, parted by blanks and ends of lines, read by all threads.

use rayon::prelude::*;

use super::cursor::Cursor;
use super::points::{is_coordinate, no_coordinate};
use super::{Stop, Task};

/// Length of a piece that a thread reads, in bytes: some milliseconds of work.
const PIECE: usize = 256 << 10;
/// Pieces for each thread that are read before they are put together.
const PIECES: usize = 4;

/// What is made of a file's numbers.
pub(super) trait Value: Copy + Default + Send + Sync {
    /// Made of a number, where it may be one.
    fn of_real(value: f64) -> Option<Self>;

    /// Made of a whole number, where it may be one.
    fn of_whole(value: i64) -> Option<Self>;

    /// Made of a number in single precision, and 0; of one that may be none anything, and not 0: so many are made at once.
    #[inline]
    fn of_single_at_once(value: f32) -> (Self, u32) {
        at_once(Self::of_real(value.into()))
    }

    /// The same of a whole number.
    #[inline]
    fn of_whole_at_once(value: i64) -> (Self, u32) {
        at_once(Self::of_whole(value))
    }

    /// The same of a whole number of which the highest byte comes first.
    #[inline]
    fn of_big_at_once(number: [u8; 8]) -> (Self, u32) {
        Self::of_whole_at_once(i64::from_be_bytes(number))
    }

    /// The number that stands in a text and ends at a blank, where it may be one; else the cursor may stand anywhere.
    fn of_text(cursor: &mut Cursor<'_>) -> Option<Self>;

    /// The fault of a number that is none.
    fn refused(at: usize, value: f64) -> Stop;
}

/// A value, where there is one, and whether there is none.
#[inline]
pub(super) fn at_once<V: Default>(value: Option<V>) -> (V, u32) {
    let is_none = u32::from(value.is_none());
    (value.unwrap_or_default(), is_none)
}

/// A coordinate is within its bounds.
macro_rules! coordinate_value {
    ($float:ty) => {
        impl Value for $float {
            #[inline]
            #[allow(
                clippy::cast_possible_truncation,
                trivial_numeric_casts,
                reason = "the nearest is what is wanted"
            )]
            fn of_real(value: f64) -> Option<Self> {
                is_coordinate(value).then_some(value as $float)
            }

            #[inline]
            #[allow(clippy::cast_precision_loss, reason = "the nearest is what is wanted")]
            fn of_whole(value: i64) -> Option<Self> {
                Self::of_real(value as f64)
            }

            #[inline]
            fn of_text(cursor: &mut Cursor<'_>) -> Option<Self> {
                Self::of_real(cursor.number()?)
            }

            fn refused(at: usize, value: f64) -> Stop {
                no_coordinate(at, value)
            }
        }
    };
}
coordinate_value!(f32);
coordinate_value!(f64);

/// A count, or the number of a point.
impl Value for u32 {
    #[inline]
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the lower half, and the upper one, which is 0"
    )]
    fn of_whole_at_once(value: i64) -> (Self, u32) {
        (value as u32, (value >> 32) as u32)
    }

    /// Only the lower half is turned round.
    #[inline]
    fn of_big_at_once([a, b, c, d, e, f, g, h]: [u8; 8]) -> (Self, u32) {
        let upper = Self::from_ne_bytes([a, b, c, d]);
        (Self::from_be_bytes([e, f, g, h]), upper)
    }

    #[inline]
    fn of_real(_: f64) -> Option<Self> {
        None
    }

    #[inline]
    fn of_whole(value: i64) -> Option<Self> {
        Self::try_from(value).ok()
    }

    #[inline]
    fn of_text(cursor: &mut Cursor<'_>) -> Option<Self> {
        let value = cursor.integer()?;
        let ends = cursor.peek().is_none_or(|byte| byte.is_ascii_whitespace());
        Self::of_whole(value).filter(|_| ends)
    }

    fn refused(at: usize, value: f64) -> Stop {
        let problem = format!(
            "has {value} where a cell's end or the number of a point stands, which is a whole number from 0 on: save the file again"
        );
        Stop::fault(at, problem)
    }
}

/// Reads as many numbers as there are places for, from a byte of a text on, and returns where the text after them begins.
pub(super) fn read<V: Value>(
    text: &[u8],
    at: usize,
    to: &mut [V],
    task: &Task<'_>,
) -> Result<usize, Stop> {
    each(text, at, to.len(), task, |from, values: &[V]| {
        to[from..from + values.len()].copy_from_slice(values);
        Ok(())
    })
}

/// Reads so many numbers, from a byte of a text on, and returns where the text after them begins. They are handed on in order, some at
/// once, with the number of those before them.
pub(super) fn each<V: Value>(
    text: &[u8],
    at: usize,
    count: usize,
    task: &Task<'_>,
    mut take: impl FnMut(usize, &[V]) -> Result<(), Stop>,
) -> Result<usize, Stop> {
    let mut done = 0;
    let mut at = at;
    while done < count {
        let pieces = pieces(text, at);
        let parts = pieces.par_iter().map(|&[from, end]| {
            task.go_on()?;
            Ok(Part::<V>::read(text, from, end, count - done))
        });
        let parts: Result<Vec<_>, Stop> = parts.collect();
        for part in parts? {
            let taken = part.values.len().min(count - done);
            take(done, &part.values[..taken])?;
            done += taken;
            if done == count {
                // A piece that holds more is gone through again for where the last one ends.
                return Ok(match taken == part.values.len() {
                    true => part.end,
                    false => Part::<V>::read(text, part.from, text.len(), taken).end,
                });
            }
            at = part.end;
            if part.is_stopped {
                return Err(no_number::<V>(text, at));
            }
        }
    }
    Ok(at)
}

/// What a piece holds.
struct Part<V> {
    from: usize,
    values: Vec<V>,
    /// Behind its last number.
    end: usize,
    /// Whether something else stands there.
    is_stopped: bool,
}

impl<V: Value> Part<V> {
    fn read(text: &[u8], from: usize, end: usize, most: usize) -> Self {
        let mut cursor = Cursor::new(&text[..end], from);
        let mut values = Vec::new();
        while values.len() < most {
            let before = cursor.at;
            cursor.skip_space();
            let at = cursor.at;
            if at == end {
                // Unless the text ends, too, the next piece goes on.
                let is_stopped = end == text.len();
                return Self {
                    from,
                    values,
                    end,
                    is_stopped,
                };
            }
            let Some(value) = V::of_text(&mut cursor) else {
                return Self {
                    from,
                    values,
                    end: before,
                    is_stopped: true,
                };
            };
            values.push(value);
        }
        Self {
            from,
            values,
            end: cursor.at,
            is_stopped: false,
        }
    }
}

/// Where the next pieces begin and end: between numbers.
fn pieces(text: &[u8], mut at: usize) -> Vec<[usize; 2]> {
    let mut pieces = Vec::new();
    for _ in 0..PIECES * rayon::current_num_threads() {
        let least = text.len().min(at.saturating_add(PIECE));
        let rest = &text[least..];
        let blank = rest.iter().position(u8::is_ascii_whitespace);
        let end = least + blank.unwrap_or(rest.len());
        pieces.push([at, end]);
        at = end;
        if at == text.len() {
            break;
        }
    }
    pieces
}

/// The fault of what stands where a number should.
fn no_number<V: Value>(text: &[u8], at: usize) -> Stop {
    let mut cursor = Cursor::new(text, at);
    cursor.skip_space();
    let at = cursor.at;
    if cursor.peek().is_none() {
        let problem = "is the end, amid numbers: the file is cut short, save it again";
        return Stop::fault(at, problem);
    }
    let shown = cursor.shown();
    match cursor.number() {
        Some(value) => V::refused(at, value),
        None => {
            let problem = format!("has {shown} where a number stands: save the file again");
            Stop::fault(at, problem)
        }
    }
}

/// Passes over so many words, and returns where the text after them begins.
pub(super) fn skip(text: &[u8], at: usize, count: usize, task: &Task<'_>) -> Result<usize, Stop> {
    let mut cursor = Cursor::new(text, at);
    for skipped in 0..count {
        if skipped % PIECE == 0 {
            task.go_on()?;
        }
        cursor.skip_space();
        if cursor.word().is_empty() {
            let problem = "is the end, amid numbers: the file is cut short, save it again";
            return Err(Stop::fault(text.len(), problem));
        }
    }
    Ok(cursor.at)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::sync::atomic::AtomicBool;

    use super::super::ReadLimits;
    use super::*;

    fn numbers<V: Value>(text: &str, count: usize) -> Result<(Vec<V>, usize), String> {
        let task = Task {
            limits: &ReadLimits::default(),
            cancel: &AtomicBool::new(false),
            folder: None,
        };
        let mut values = vec![V::default(); count];
        match read(text.as_bytes(), 0, &mut values, &task) {
            Ok(end) => Ok((values, end)),
            Err(Stop::Fault { at, problem }) => Err(format!("{at} {problem}")),
            Err(other) => Err(format!("{other:?}")),
        }
    }

    #[test]
    fn as_many_are_read_as_are_asked_for() {
        assert_eq!(numbers(" 1 2\n3 4", 3), Ok((vec![1_u32, 2, 3], 6)));
        assert_eq!(numbers("1.5e0 -2 WORD", 2), Ok((vec![1.5_f32, -2.0], 8)));
        assert_eq!(numbers::<u32>("WORD", 0), Ok((vec![], 0)));
        for (text, told) in [
            ("1 2", "3 is the end"),
            ("1 2 \n", "5 is the end"),
            ("1 two 3", "2 has `two` where a number"),
            ("1 -2 3", "2 has -2 where"),
            ("1 2.5 3", "2 has 2.5 where"),
            ("", "0 is the end"),
        ] {
            let fault = numbers::<u32>(text, 3).unwrap_err();
            assert!(fault.starts_with(told), "{fault}");
        }
        let fault = numbers::<f64>("1 nan 2", 3).unwrap_err();
        assert!(fault.starts_with("2 has the coordinate NaN"), "{fault}");
    }

    #[test]
    fn long_text_is_read_in_pieces() {
        let count = 1_200_000;
        let text: String = (0..count).map(|number| format!("{number}\n")).collect();
        let expected: Vec<u32> = (0..count).collect();
        for most in [count as usize, 700_000, 3, 40_000] {
            let (read, end) = numbers::<u32>(&format!("{text}END"), most).unwrap();
            assert_eq!(read, expected[..most]);
            let before: usize = (0..most).map(|number| number.to_string().len() + 1).sum();
            assert_eq!(end, before - 1);
        }
        let fault = numbers::<u32>(&format!("{text}END"), count as usize + 1).unwrap_err();
        assert!(
            fault.starts_with(&format!("{} has `END`", text.len())),
            "{fault}"
        );
    }
}
