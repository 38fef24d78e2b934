//! Numbers of any type as bytes, and what they may become: coordinates and point numbers.

use rayon::prelude::*;

use super::super::cursor::Cursor;
use super::super::numerals::Value;
use super::super::{Stop, Task};

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
fn each<const LENGTH: usize, V>(
    bytes: &[u8],
    to: &mut [V],
    is_big: bool,
    value: impl Fn([u8; LENGTH]) -> Option<V>,
) -> Result<(), usize> {
    let (numbers, _) = bytes.as_chunks::<LENGTH>();
    for (at, (to, number)) in to.iter_mut().zip(numbers).enumerate() {
        let mut number = *number;
        if is_big {
            number.reverse();
        }
        *to = value(number).ok_or(at)?;
    }
    Ok(())
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
        Kind::I8 => of_kind!(i8, |value: i8| V::of_whole(value.into())),
        Kind::U8 => of_kind!(u8, |value: u8| V::of_whole(value.into())),
        Kind::I16 => of_kind!(i16, |value: i16| V::of_whole(value.into())),
        Kind::U16 => of_kind!(u16, |value: u16| V::of_whole(value.into())),
        Kind::I32 => of_kind!(i32, |value: i32| V::of_whole(value.into())),
        Kind::U32 => of_kind!(u32, |value: u32| V::of_whole(value.into())),
        Kind::I64 => of_kind!(i64, V::of_whole),
        // Beyond i64 nothing is counted, and no coordinate is.
        Kind::U64 => of_kind!(u64, |value: u64| V::of_whole(i64::try_from(value).ok()?)),
        Kind::F32 => of_kind!(f32, |value: f32| V::of_real(value.into())),
        Kind::F64 => of_kind!(f64, V::of_real),
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

/// Makes values of numbers that stand in a file as they are, from a byte of it on, by all threads.
pub(super) fn fill_all<V: Value>(
    bytes: &[u8],
    at: usize,
    kind: Kind,
    is_big: bool,
    to: &mut [V],
    task: &Task<'_>,
) -> Result<(), Stop> {
    let chunks = to.par_chunks_mut(NUMBERS).enumerate();
    chunks.try_for_each(|(chunk, to)| {
        task.go_on()?;
        let from = chunk * NUMBERS * kind.bytes();
        let rest = bytes.get(from..).unwrap_or_default();
        fill(rest, kind, is_big, to).map_err(|place| {
            let from = from + place * kind.bytes();
            let value = shown(bytes.get(from..).unwrap_or_default(), kind, is_big);
            V::refused(at + from, value)
        })
    })
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
