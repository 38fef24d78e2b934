//! The choices that a round made, a few bits each: they are kept for as long as both strings are, and most grammars have few
//! productions.
//!
//! Eight choices are eight bytes in a word, and three shifts push them together or draw them apart.

use super::column::Narrow;
use crate::tree::Cells;

/// Choices that are packed together; chunks begin at multiples of it.
const GROUP: usize = 8;

/// Choices in order, packed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Choices {
    packed: Cells<u8>,
    length: usize,
    bits: usize,
}

impl Choices {
    /// Bits of a choice among so many productions, or to stay.
    pub(super) fn bits_among(productions: usize) -> usize {
        match productions {
            0..2 => 1,
            2..4 => 2,
            4..16 => 4,
            16..256 => 8,
            _ => 16,
        }
    }

    /// Room for as many, in the memory of earlier ones; `None` where there is not enough.
    pub(super) fn renewed(self, length: usize, productions: usize) -> Option<Self> {
        let bits = Self::bits_among(productions);
        Some(Self {
            packed: self.packed.renewed(length.div_ceil(GROUP) * bits)?,
            length,
            bits,
        })
    }

    pub(super) fn len(&self) -> usize {
        self.length
    }

    /// Bytes that they take.
    pub(super) fn bytes(&self) -> u64 {
        self.packed.len() as u64
    }

    /// One after the other.
    pub(super) fn iter(&self) -> impl Iterator<Item = u16> + '_ {
        (0..self.length).map(|at| self.get(at).unwrap_or(0))
    }

    pub(super) fn get(&self, at: usize) -> Option<u16> {
        if at >= self.length {
            return None;
        }
        let group = at / GROUP * self.bits;
        let mut all = [0_u16; GROUP];
        unpack(
            self.bits,
            self.packed.get(group..group + self.bits)?,
            &mut all,
        );
        all.get(at % GROUP).copied()
    }

    /// The places of chunks of so many choices, to [`pack`] into.
    pub(super) fn chunks_mut(&mut self, chunk: usize) -> impl Iterator<Item = &mut [u8]> {
        self.packed.chunks_mut(chunk / GROUP * self.bits.max(1))
    }

    /// The packed chunks.
    pub(super) fn chunks(&self, chunk: usize) -> impl Iterator<Item = &[u8]> {
        self.packed.chunks(chunk / GROUP * self.bits.max(1))
    }

    /// Bits of each.
    pub(super) fn bits(&self) -> usize {
        self.bits
    }
}

/// Packs choices of so many bits.
pub(super) fn pack<S: Narrow>(bits: usize, choices: &[S], packed: &mut [u8]) {
    match bits {
        1 => pack_in::<1, S>(choices, packed),
        2 => pack_in::<2, S>(choices, packed),
        4 => pack_in::<4, S>(choices, packed),
        8 => pack_in::<8, S>(choices, packed),
        _ => {
            for (choice, place) in choices.iter().zip(packed.as_chunks_mut::<2>().0) {
                let choice: u16 = (*choice).into();
                *place = choice.to_le_bytes();
            }
        }
    }
}

/// The reverse of [`pack`].
pub(super) fn unpack<S: Narrow>(bits: usize, packed: &[u8], choices: &mut [S]) {
    match bits {
        1 => unpack_in::<1, S>(packed, choices),
        2 => unpack_in::<2, S>(packed, choices),
        4 => unpack_in::<4, S>(packed, choices),
        8 => unpack_in::<8, S>(packed, choices),
        _ => {
            for (choice, place) in choices.iter_mut().zip(packed.as_chunks::<2>().0) {
                *choice = S::of(u32::from(u16::from_le_bytes(*place)));
            }
        }
    }
}

fn pack_in<const BITS: usize, S: Narrow>(choices: &[S], packed: &mut [u8]) {
    let (places, _) = packed.as_chunks_mut::<BITS>();
    let (groups, rest) = choices.as_chunks::<GROUP>();
    for (group, place) in groups.iter().zip(&mut *places) {
        *place = squeezed::<BITS, S>(group);
    }
    if !rest.is_empty()
        && let Some(place) = places.get_mut(groups.len())
    {
        let mut group = [S::default(); GROUP];
        for (cell, choice) in group.iter_mut().zip(rest) {
            *cell = *choice;
        }
        *place = squeezed::<BITS, S>(&group);
    }
}

fn unpack_in<const BITS: usize, S: Narrow>(packed: &[u8], choices: &mut [S]) {
    let (places, _) = packed.as_chunks::<BITS>();
    let (groups, rest) = choices.as_chunks_mut::<GROUP>();
    for (group, place) in groups.iter_mut().zip(places) {
        *group = spread::<BITS, S>(place);
    }
    let left = places.get(groups.len()).map(spread::<BITS, S>);
    for (choice, cell) in rest.iter_mut().zip(left.unwrap_or_default()) {
        *choice = cell;
    }
}

/// The lowest bits of each lane of so many bits.
const fn lanes(lane: usize, bits: usize) -> u64 {
    let low = if bits == 64 {
        u64::MAX
    } else {
        (1 << bits) - 1
    };
    let (mut all, mut at) = (0, 0);
    while at < 64 {
        all |= low << at;
        at += lane;
    }
    all
}

#[inline]
fn squeezed<const BITS: usize, S: Narrow>(group: &[S; GROUP]) -> [u8; BITS] {
    let mut bytes = [0_u8; GROUP];
    for (byte, choice) in bytes.iter_mut().zip(group) {
        // A choice has no more bits.
        let choice: u16 = (*choice).into();
        [*byte, _] = choice.to_le_bytes();
    }
    let mut word = u64::from_le_bytes(bytes);
    word = (word | word >> (8 - BITS)) & lanes(16, 2 * BITS);
    word = (word | word >> (16 - 2 * BITS)) & lanes(32, 4 * BITS);
    word = (word | word >> (32 - 4 * BITS)) & lanes(64, 8 * BITS);
    let mut packed = [0; BITS];
    for (place, byte) in packed.iter_mut().zip(word.to_le_bytes()) {
        *place = byte;
    }
    packed
}

#[inline]
fn spread<const BITS: usize, S: Narrow>(packed: &[u8; BITS]) -> [S; GROUP] {
    let mut bytes = [0_u8; GROUP];
    for (byte, place) in bytes.iter_mut().zip(packed) {
        *byte = *place;
    }
    let mut word = u64::from_le_bytes(bytes);
    word = (word | word << (32 - 4 * BITS)) & lanes(32, 4 * BITS);
    word = (word | word << (16 - 2 * BITS)) & lanes(16, 2 * BITS);
    word = (word | word << (8 - BITS)) & lanes(8, BITS);
    let mut group = [S::default(); GROUP];
    for (choice, byte) in group.iter_mut().zip(word.to_le_bytes()) {
        *choice = S::of(u32::from(byte));
    }
    group
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "the table says it"
    )]
    use super::*;

    #[test]
    fn what_is_packed_comes_out_again() {
        for (productions, bits) in [
            (1, 1),
            (3, 2),
            (4, 4),
            (15, 4),
            (16, 8),
            (255, 8),
            (256, 16),
            (65_534, 16),
        ] {
            for length in [0, 1, 7, 8, 9, 64, 8192, 8200] {
                // Every choice that there is, in no order.
                let all: Vec<u16> = (0..length)
                    .map(|at| u16::try_from(at * 7919 % (productions + 1)).unwrap())
                    .collect();
                let mut choices = Choices::default().renewed(length, productions).unwrap();
                assert_eq!(choices.bits(), bits);
                let chunks = all.chunks(64).zip(choices.chunks_mut(64));
                chunks.for_each(|(chunk, place)| pack(bits, chunk, place));
                assert!(
                    choices.iter().eq(all.iter().copied()),
                    "{productions} {length}"
                );
                assert_eq!(choices.get(length), None);
                for (chunk, place) in all.chunks(64).zip(choices.chunks(64)) {
                    let mut out = vec![0_u16; chunk.len()];
                    unpack(bits, place, &mut out);
                    assert_eq!(out, chunk);
                }
            }
        }
    }
}
