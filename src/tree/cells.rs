//! Flat arrays of numbers, large ones in pages of their own that are as large as the system has them.
//!
//! To touch memory for the first time costs a fault for each page: with pages of 4 KiB that is most of the time that a string of
//! a billion modules takes, and the faults of two threads wait for each other. So large arrays are mapped, and the system is asked
//! for huge pages (2 MiB), where it has them to give.

use std::collections::TryReserveError;
use std::fmt::{Debug, Formatter};
use std::ops::{Deref, DerefMut};

use super::pages::{HUGE_PAGE, Pages};
use bytemuck::Pod;

/// Arrays of so many bytes are mapped.
const MAPPED_FROM: usize = HUGE_PAGE;

/// An array of numbers, used as a slice is. One that is large from the start lies in huge pages; one that grows by what is added to
/// it is a vector.
pub struct Cells<T>(Memory<T>);

enum Memory<T> {
    Heap(Vec<T>),
    /// Numbers in pages of their own, of which so many count.
    Mapped(Pages, usize),
}

use Memory::{Heap, Mapped};

impl<T: Pod> Cells<T> {
    /// So many numbers that will all be written, and are anything before; `None` where the memory is not there.
    #[must_use]
    pub fn unwritten(length: usize) -> Option<Self> {
        let bytes = length.checked_mul(size_of::<T>())?;
        if bytes >= MAPPED_FROM {
            return Some(Self(Mapped(Pages::unwritten(bytes)?, length)));
        }
        // Asked for first, since `vec!` would end the program; its zeros are the system's, not written once more.
        Vec::<T>::new().try_reserve_exact(length).ok()?;
        Some(vec![T::zeroed(); length].into())
    }

    /// So many numbers, which will all be written, in the memory of these where it has the right size; `None` where there is not
    /// enough.
    #[must_use]
    pub fn renewed(self, length: usize) -> Option<Self> {
        // Never much more than is needed: a string may shrink.
        if self.capacity() < length || self.capacity() / 2 > length {
            drop(self);
            return Self::unwritten(length);
        }
        Some(Self(match self.0 {
            Heap(mut own) => {
                own.resize(length, T::zeroed());
                Heap(own)
            }
            Mapped(pages, _) => Mapped(pages, length),
        }))
    }

    /// The numbers.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        self
    }

    /// Numbers for which there is room.
    #[must_use]
    pub fn capacity(&self) -> usize {
        match &self.0 {
            Heap(own) => own.capacity(),
            Mapped(pages, _) => pages.len() / size_of::<T>().max(1),
        }
    }

    /// An empty array with room for so many.
    #[must_use]
    pub fn with_capacity(room: usize) -> Self {
        Vec::with_capacity(room).into()
    }

    /// Makes room for so many more.
    ///
    /// # Errors
    /// Where the machine does not give the memory; the array is as it was.
    pub fn try_reserve_exact(&mut self, more: usize) -> Result<(), TryReserveError> {
        self.vector().try_reserve_exact(more)
    }

    /// Adds a number at the end.
    #[inline]
    pub fn push(&mut self, one: T) {
        self.vector().push(one);
    }

    /// Adds numbers at the end.
    pub fn extend(&mut self, more: impl IntoIterator<Item = T>) {
        self.vector().extend(more);
    }

    /// Leaves out all numbers from this one on.
    pub fn truncate(&mut self, length: usize) {
        match &mut self.0 {
            Heap(own) => own.truncate(length),
            Mapped(_, own) => *own = length.min(*own),
        }
    }

    /// Makes it so long, with this value where it is longer than before.
    pub fn resize(&mut self, length: usize, value: T) {
        if self.len() != length {
            self.vector().resize(length, value);
        }
    }

    /// The numbers as a vector, which can grow.
    #[inline]
    fn vector(&mut self) -> &mut Vec<T> {
        if let Mapped(..) = self.0 {
            *self = self.to_vec().into();
        }
        match &mut self.0 {
            Heap(own) => own,
            Mapped(..) => unreachable!("it was just replaced"),
        }
    }
}

impl<T> Default for Cells<T> {
    fn default() -> Self {
        Vec::new().into()
    }
}

impl<T> From<Vec<T>> for Cells<T> {
    fn from(own: Vec<T>) -> Self {
        Self(Heap(own))
    }
}

impl<T> FromIterator<T> for Cells<T> {
    fn from_iter<I: IntoIterator<Item = T>>(numbers: I) -> Self {
        numbers.into_iter().collect::<Vec<T>>().into()
    }
}

impl<T: Pod> IntoIterator for Cells<T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(mut self) -> Self::IntoIter {
        std::mem::take(self.vector()).into_iter()
    }
}

impl<'c, T: Pod> IntoIterator for &'c Cells<T> {
    type Item = &'c T;
    type IntoIter = std::slice::Iter<'c, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'c, T: Pod> IntoIterator for &'c mut Cells<T> {
    type Item = &'c mut T;
    type IntoIter = std::slice::IterMut<'c, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl<T: Pod> Deref for Cells<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match &self.0 {
            Heap(own) => own,
            // Pages begin at multiples of more than any number needs.
            Mapped(pages, length) => bytemuck::cast_slice(&pages[..length * size_of::<T>()]),
        }
    }
}

impl<T: Pod> DerefMut for Cells<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        match &mut self.0 {
            Heap(own) => own,
            Mapped(pages, length) => {
                bytemuck::cast_slice_mut(&mut pages[..*length * size_of::<T>()])
            }
        }
    }
}

impl<T: Pod> Clone for Cells<T> {
    fn clone(&self) -> Self {
        let copied = Self::unwritten(self.len()).map(|mut copy| {
            copy.copy_from_slice(self);
            copy
        });
        // Memory that is not there ends the program, as with every other clone.
        copied.unwrap_or_else(|| self.to_vec().into())
    }
}

impl<T: Pod + PartialEq> PartialEq for Cells<T> {
    fn eq(&self, other: &Self) -> bool {
        self[..] == other[..]
    }
}

impl<T: Pod + PartialEq> PartialEq<Vec<T>> for Cells<T> {
    fn eq(&self, other: &Vec<T>) -> bool {
        self[..] == other[..]
    }
}

impl<T: Pod + PartialEq> PartialEq<Cells<T>> for Vec<T> {
    fn eq(&self, other: &Cells<T>) -> bool {
        self[..] == other[..]
    }
}

impl<T: Pod + PartialEq, const N: usize> PartialEq<[T; N]> for Cells<T> {
    fn eq(&self, other: &[T; N]) -> bool {
        self[..] == other[..]
    }
}

impl<T: Pod + Debug> Debug for Cells<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        self[..].fmt(f)
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    #[test]
    fn small_and_large_arrays_are_alike() {
        for length in [
            0,
            1,
            1000,
            MAPPED_FROM / 8 - 1,
            MAPPED_FROM / 8,
            MAPPED_FROM / 8 + 1,
        ] {
            let mut cells = Cells::<f64>::unwritten(length).unwrap();
            assert_eq!(matches!(cells.0, Mapped(..)), length * 8 >= MAPPED_FROM);
            assert_eq!(cells.len(), length);
            cells.fill(1.0);
            if let Some(last) = cells.last_mut() {
                *last = 7.0;
            }
            assert_eq!(cells.clone(), cells);
            let shorter = length - length / 3;
            let renewed = cells.clone().renewed(shorter).unwrap();
            assert_eq!(renewed.len(), shorter);
            assert_eq!(cells.clone().renewed(length * 3).unwrap().len(), length * 3);
            let mut shorter = cells.clone();
            shorter.truncate(length / 2);
            assert_eq!(shorter[..], cells[..length / 2]);
            shorter.truncate(length);
            assert_eq!(shorter.len(), length / 2);
            cells.extend([1.0, 2.0]);
            assert_eq!(cells.len(), length + 2);
            assert_eq!(cells[length..], [1.0, 2.0]);
            assert!(length == 0 || cells[length - 1] == 7.0);
        }
        assert!(Cells::<f64>::unwritten(usize::MAX / 8).is_none());
        assert!(Cells::<f64>::unwritten(usize::MAX).is_none());
    }
}
