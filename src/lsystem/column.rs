//! Columns of whole numbers, each as narrow as its largest value allows: symbols, births, choices.
//!
//! Derivation is bound by memory, so half the bytes are half the time. What loops over modules is generic over the
//! width of a column and chosen once for a string; only what is asked for one at a time decides at each value.

use std::fmt::Debug;

use bytemuck::Pod;

use crate::tree::Cells;

/// A number of a column.
pub(super) trait Cell:
    Pod + Copy + Default + PartialEq + Debug + Send + Sync + Into<u32> + TryFrom<u32> + 'static
{
    /// Its largest value.
    const MOST: u32;

    /// The number, or the largest where it is larger, which callers rule out by the column's width.
    fn of(number: u32) -> Self;
    /// The column's memory; none where it has another width.
    fn into_cells(column: Column) -> Cells<Self>;
    fn column(cells: Cells<Self>) -> Column;

    /// The number as an index.
    #[inline]
    fn index(self) -> usize {
        let number: u32 = self.into();
        number as usize
    }
}

/// A cell that holds symbols and choices.
pub(super) trait Narrow: Cell + Into<u16> + Into<usize> {}
impl Narrow for u8 {}
impl Narrow for u16 {}

/// Numbers of one width.
#[derive(Clone, Debug)]
pub(crate) enum Column {
    /// Up to 255,
    Byte(Cells<u8>),
    /// to 65,535,
    Half(Cells<u16>),
    /// and to 2^32 − 1.
    Word(Cells<u32>),
}

macro_rules! cell {
    ($cell:ty, $variant:ident) => {
        impl Cell for $cell {
            const MOST: u32 = <$cell>::MAX as u32;

            #[inline]
            fn of(number: u32) -> Self {
                Self::try_from(number).unwrap_or(Self::MAX)
            }

            fn into_cells(column: Column) -> Cells<Self> {
                match column {
                    Column::$variant(cells) => cells,
                    _ => Cells::default(),
                }
            }

            fn column(cells: Cells<Self>) -> Column {
                Column::$variant(cells)
            }
        }
    };
}
cell!(u8, Byte);
cell!(u16, Half);
cell!(u32, Word);

/// Runs an expression for whatever width a column has.
macro_rules! for_width {
    ($column:expr, $cells:ident => $work:expr) => {
        match $column {
            $crate::lsystem::column::Column::Byte($cells) => $work,
            $crate::lsystem::column::Column::Half($cells) => $work,
            $crate::lsystem::column::Column::Word($cells) => $work,
        }
    };
}
pub(super) use for_width;

impl Default for Column {
    fn default() -> Self {
        Self::Byte(Cells::default())
    }
}

impl PartialEq for Column {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Byte(own), Self::Byte(others)) => own == others,
            (Self::Half(own), Self::Half(others)) => own == others,
            (Self::Word(own), Self::Word(others)) => own == others,
            _ => self.iter().eq(other.iter()),
        }
    }
}

impl Column {
    /// An empty column for numbers up to this.
    pub(super) fn up_to(most: u32) -> Self {
        match bytes_up_to(most) {
            1 => Self::Byte(Cells::default()),
            2 => Self::Half(Cells::default()),
            _ => Self::Word(Cells::default()),
        }
    }

    /// These numbers, as narrow as they can be where none is larger than `most`.
    pub(crate) fn from_numbers(most: u32, numbers: impl Iterator<Item = u32>) -> Self {
        let mut column = Self::up_to(most);
        fn fill<T: Cell>(cells: &mut Cells<T>, numbers: impl Iterator<Item = u32>) {
            cells.extend(numbers.map(T::of));
        }
        for_width!(&mut column, cells => fill(cells, numbers));
        column
    }

    pub(crate) fn len(&self) -> usize {
        for_width!(self, cells => cells.len())
    }

    /// Bytes of one number.
    pub(super) fn cell_bytes(&self) -> u64 {
        match self {
            Self::Byte(_) => 1,
            Self::Half(_) => 2,
            Self::Word(_) => 4,
        }
    }

    /// The largest number that it can hold.
    pub(super) fn most(&self) -> u32 {
        match self {
            Self::Byte(_) => u8::MOST,
            Self::Half(_) => u16::MOST,
            Self::Word(_) => u32::MOST,
        }
    }

    #[inline]
    pub(crate) fn get(&self, at: usize) -> Option<u32> {
        match self {
            Self::Byte(cells) => cells.get(at).copied().map(u32::from),
            Self::Half(cells) => cells.get(at).copied().map(u32::from),
            Self::Word(cells) => cells.get(at).copied(),
        }
    }

    /// Copies numbers from a place on, as wide as the reader wants them; zeros where there are none.
    pub(super) fn read<T: Cell>(&self, from: usize, into: &mut [T]) {
        fn copy<C: Cell, T: Cell>(cells: &[C], from: usize, into: &mut [T]) {
            let cells = cells.get(from..).unwrap_or(&[]);
            let given = into.len().min(cells.len());
            let (full, empty) = into.split_at_mut(given);
            empty.fill(T::default());
            for (place, cell) in full.iter_mut().zip(cells) {
                *place = T::of((*cell).into());
            }
        }
        for_width!(self, cells => copy(cells, from, into));
    }

    /// The numbers in order.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        (0..self.len()).map(|at| self.get(at).unwrap_or(0))
    }

    /// Adds a number, which the column's width must hold.
    pub(super) fn push(&mut self, number: u32) {
        for_width!(self, cells => cells.extend([Cell::of(number)]));
    }

    /// Whether it holds numbers up to this.
    pub(super) fn holds(&self, most: u32) -> bool {
        most <= self.most()
    }

    /// The same numbers in wider cells, which hold numbers up to this.
    pub(super) fn widened(&self, most: u32) -> Self {
        Self::from_numbers(most, self.iter())
    }
}

/// Bytes of a number up to this in a column.
pub(super) fn bytes_up_to(most: u32) -> u64 {
    if most <= u8::MOST {
        1
    } else if most <= u16::MOST {
        2
    } else {
        4
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]
    use super::*;

    #[test]
    fn a_column_is_as_narrow_as_its_largest_number_allows() {
        for (most, bytes) in [
            (0, 1),
            (255, 1),
            (256, 2),
            (65_535, 2),
            (65_536, 4),
            (u32::MAX, 4),
        ] {
            let column = Column::from_numbers(most, [most, 0, most].into_iter());
            assert_eq!(column.cell_bytes(), bytes, "{most}");
            assert_eq!(column.iter().collect::<Vec<_>>(), [most, 0, most]);
            assert_eq!(column, column.widened(u32::MAX), "widths are no difference");
            assert_eq!(column.get(3), None);
            assert!(column.holds(most) && (bytes == 4 || !column.holds(u32::MAX)));
        }
    }
}
