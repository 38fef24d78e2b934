//! Numbers of any type as bytes, and what they may become: coordinates and point numbers.
//!
//! Files of plain numbers are read about as fast as memory is, so each is looked at once: in one pass all threads turn bytes, narrow,
//! check and write what the mesh keeps. Places of triangles in a list are compared with what they must be, and never stored. *Tried*: zeroed
//! vectors, filled, then checked for points that are not there; a way out of the loop at the first number that is none, with which each is
//! made by itself: both together took half as long again.

use rayon::prelude::*;

use super::super::cursor::Cursor;
use super::super::numerals::{Value, at_once};
use super::super::stretch::{Stretch, Window};
use super::super::{Stop, Task, made};

/// Numbers that a thread takes at once.
pub(super) const NUMBERS: usize = 1 << 16;

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether its values count things.
    pub(super) fn is_whole(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Whether single precision may round its values.
    pub(super) fn is_wide(self) -> bool {
        !matches!(
            self,
            Self::I8 | Self::U8 | Self::I16 | Self::U16 | Self::F32
        )
    }
}

/// Goes through numbers of one length.
#[inline]
fn each<const LENGTH: usize, V: Default>(
    bytes: &[u8],
    to: &mut [V],
    is_big: bool,
    value: impl Fn([u8; LENGTH]) -> (V, u32),
) -> Result<(), usize> {
    let (numbers, _) = bytes.as_chunks::<LENGTH>();
    let of = |number: &[u8; LENGTH]| {
        let mut number = *number;
        if is_big {
            number.reverse();
        }
        value(number)
    };
    // Without a way out of the loop, so that several are made at once.
    let mut wrong = 0;
    for (to, number) in to.iter_mut().zip(numbers) {
        let (value, none) = of(number);
        wrong |= none;
        *to = value;
    }
    if wrong == 0 {
        return Ok(());
    }
    let mut all = numbers.iter().take(to.len());
    let first = all.position(|number| of(number).1 != 0);
    first.map_or(Ok(()), Err)
}

/// Makes values of the numbers that bytes hold, as many as are asked for and there; fails with the place of the first that is none.
pub(super) fn fill<V: Value>(
    bytes: &[u8],
    kind: Kind,
    is_big: bool,
    to: &mut [V],
) -> Result<(), usize> {
    macro_rules! of_kind {
        ($kind:ty, $made:expr) => {
            each(bytes, to, is_big, |number| {
                $made(<$kind>::from_le_bytes(number))
            })
        };
    }
    match kind {
        Kind::I8 => of_kind!(i8, |value: i8| V::of_whole_at_once(value.into())),
        Kind::U8 => of_kind!(u8, |value: u8| V::of_whole_at_once(value.into())),
        Kind::I16 => of_kind!(i16, |value: i16| V::of_whole_at_once(value.into())),
        Kind::U16 => of_kind!(u16, |value: u16| V::of_whole_at_once(value.into())),
        Kind::I32 => of_kind!(i32, |value: i32| V::of_whole_at_once(value.into())),
        Kind::U32 => of_kind!(u32, |value: u32| V::of_whole_at_once(value.into())),
        Kind::I64 if is_big => each(bytes, to, false, V::of_big_at_once),
        Kind::I64 => of_kind!(i64, V::of_whole_at_once),
        // Beyond i64 nothing is counted, and no coordinate is.
        Kind::U64 => of_kind!(u64, |value: u64| {
            at_once(i64::try_from(value).ok().and_then(V::of_whole))
        }),
        Kind::F32 => of_kind!(f32, V::of_single_at_once),
        Kind::F64 => of_kind!(f64, |value: f64| at_once(V::of_real(value))),
    }
}

/// A number as it stands in bytes, for messages.
#[allow(
    clippy::cast_precision_loss,
    reason = "the nearest is near enough to be told"
)]
pub(super) fn shown(bytes: &[u8], kind: Kind, is_big: bool) -> f64 {
    /// Any number at all.
    #[derive(Clone, Copy, Default)]
    struct Any(f64);
    impl Value for Any {
        fn of_real(value: f64) -> Option<Self> {
            Some(Self(value))
        }
        fn of_whole(value: i64) -> Option<Self> {
            Some(Self(value as f64))
        }
        fn of_text(cursor: &mut Cursor<'_>) -> Option<Self> {
            cursor.number().map(Self)
        }
        fn refused(at: usize, _: f64) -> Stop {
            Stop::fault(at, "")
        }
    }
    let mut value = [Any::default()];
    match fill(bytes, kind, is_big, &mut value) {
        Ok(()) => value[0].0,
        // Only a whole number beyond i64 is refused.
        Err(_) => u64::MAX as f64,
    }
}

/// Numbers that stand in a file as they are.
#[derive(Clone, Copy)]
pub(super) struct Plain<'a> {
    /// As long as all of them.
    pub(super) bytes: Stretch<'a>,
    pub(super) kind: Kind,
    pub(super) is_big: bool,
    /// Where they begin in the file, or what begins the array.
    pub(super) at: usize,
    /// Whether faults are told of the number itself, else of what begins the array.
    pub(super) is_placed: bool,
}

impl Plain<'_> {
    /// Makes values of those from one on, as many as are asked for.
    pub(super) fn fill<V: Value>(
        &self,
        window: &mut Window,
        first: usize,
        to: &mut [V],
    ) -> Result<(), Stop> {
        let word = self.kind.bytes();
        let bytes = self.bytes.get(first * word, to.len() * word, window);
        let bytes = bytes.ok_or_else(|| {
            let problem = "begins an array of which the bytes cannot be read any more: the file has changed meanwhile, read it again";
            Stop::fault(self.at, problem)
        })?;
        fill(bytes, self.kind, self.is_big, to).map_err(|place| {
            let number = first + place;
            let at = self.at + if self.is_placed { number * word } else { 0 };
            let rest = bytes.get(place * word..).unwrap_or_default();
            V::refused(at, shown(rest, self.kind, self.is_big))
        })
    }

    /// The same by all threads, of all from the first on.
    pub(super) fn fill_all<V: Value>(&self, to: &mut [V], task: &Task<'_>) -> Result<(), Stop> {
        let chunks = to.par_chunks_mut(NUMBERS).enumerate();
        chunks.try_for_each_init(Window::default, |window, (chunk, to)| {
            task.go_on()?;
            self.fill(window, chunk * NUMBERS, to)
        })
    }

    /// Points of this kind of numbers, three a point.
    pub(super) fn points<V: Value>(
        &self,
        count: usize,
        task: &Task<'_>,
    ) -> Result<Vec<[V; 3]>, Stop> {
        made::rows_by(count, task, |window, first, to: &mut [[V; 3]]| {
            self.fill(window, 3 * first, to.as_flattened_mut())
        })
    }

    /// Whether so many are the places before or behind triangles in a list of their points: the first is as it is given, each other is by 3 more.
    pub(super) fn are_threes(&self, first: u32, count: usize, task: &Task<'_>) -> bool {
        /// Numbers that are looked at together.
        const SOME: usize = 4096;
        let is_good = |window: &mut Window, block: usize| {
            let mut values = [0_u32; SOME];
            let from = block * SOME;
            let values = &mut values[..SOME.min(count - from)];
            let is_read = task.go_on().is_ok() && self.fill(window, from, values).is_ok();
            let expected = u32::try_from(3 * from as u64 + u64::from(first));
            is_read
                && expected.is_ok_and(|expected| {
                    let expected = (0_u32..).map(|step| expected.wrapping_add(3 * step));
                    // Without a way out of the loop, as above.
                    let pairs = values.iter().zip(expected);
                    pairs.fold(0, |all, (value, other)| all | (value ^ other)) == 0
                })
        };
        let blocks = (0..count.div_ceil(SOME)).into_par_iter();
        let blocks = blocks.with_min_len(NUMBERS / SOME);
        blocks
            .map_init(Window::default, is_good)
            .all(|is_good| is_good)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn numbers_of_all_types_are_read_in_both_orders() {
        for (kind, bytes, value) in [
            (Kind::I8, &[0xFE_u8][..], -2.0),
            (Kind::U8, &[0xFE], 254.0),
            (Kind::I16, &[0xFE, 0xFF], -2.0),
            (Kind::U16, &[2, 1], 258.0),
            (Kind::I32, &(-7_i32).to_le_bytes(), -7.0),
            (Kind::U32, &u32::MAX.to_le_bytes(), 4_294_967_295.0),
            (Kind::I64, &(1_i64 << 40).to_le_bytes(), 1_099_511_627_776.0),
            (Kind::U64, &9_u64.to_le_bytes(), 9.0),
            (Kind::F32, &(-0.5_f32).to_le_bytes(), -0.5),
            (Kind::F64, &0.1_f64.to_le_bytes(), 0.1),
        ] {
            assert_eq!(kind.bytes(), bytes.len());
            let big: Vec<u8> = bytes.iter().rev().copied().collect();
            for (bytes, is_big) in [(bytes, false), (&big, true)] {
                let mut wide = [0.0_f64];
                assert_eq!(fill(bytes, kind, is_big, &mut wide), Ok(()));
                assert_eq!(wide[0], value, "{kind:?}");
                let mut whole = [0_u32];
                let is_whole = (0.0..=4_294_967_295.0).contains(&value) && value.fract() == 0.0;
                assert_eq!(fill(bytes, kind, is_big, &mut whole).is_ok(), is_whole);
                assert!(!is_whole || f64::from(whole[0]) == value);
            }
        }
    }

    #[test]
    fn the_first_that_is_none_is_told() {
        let bytes: Vec<u8> = [1.0_f32, f32::NAN, 1e30]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let mut values = [0.0_f32; 3];
        assert_eq!(fill(&bytes, Kind::F32, false, &mut values), Err(1));
        assert!(shown(&bytes[4..], Kind::F32, false).is_nan());
    }
}
