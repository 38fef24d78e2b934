//! Vertices of equal coordinates made one, for files that have no vertex numbers.
//!
//! An open table of vertex numbers, probed in a row; keys are the coordinates themselves, which stand in the vertices' own pages, so
//! that a slot takes four bytes. Pages, since a vector that grows holds what it has twice, and half as much again for what may come. Vertices are numbered as they first come, so the hash decides nothing that is seen, and it is
//! seeded anew each time: a file cannot be made that fills one place of the table.

use std::hash::{BuildHasher as _, RandomState};

use super::points::Coordinate;
use super::{MOST_VERTICES, Stop, Task};

/// No vertex.
pub(super) const NONE: u32 = u32::MAX;

/// Vertices of a page, as bits.
const PAGE_BITS: u32 = 12;
const PAGE: usize = 1 << PAGE_BITS;

/// Vertices in pages of one length, so that none is moved when more come.
#[derive(Default)]
pub(super) struct Pages<C> {
    pages: Vec<Vec<[C; 3]>>,
    count: usize,
}

impl<C: Coordinate> Pages<C> {
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The vertex of a number that is there.
    #[inline]
    pub(super) fn get(&self, number: usize) -> [C; 3] {
        self.pages[number >> PAGE_BITS][number & (PAGE - 1)]
    }

    fn push(&mut self, point: [C; 3]) -> Result<(), Stop> {
        match self.pages.last_mut() {
            Some(page) if page.len() < PAGE => page.push(point),
            _ => {
                let mut page = super::with_room(PAGE)?;
                page.push(point);
                self.pages.push(page);
            }
        }
        self.count += 1;
        Ok(())
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = [C; 3]> {
        self.pages.iter().flatten().copied()
    }

    /// The pages, to be given back one by one.
    pub(super) fn into_pages(self) -> impl Iterator<Item = Vec<[C; 3]>> {
        self.pages.into_iter()
    }
}

/// Vertices, each of its own coordinates.
pub(super) struct Joiner<C> {
    points: Pages<C>,
    slots: Vec<u32>,
    seeds: [u64; 2],
}

impl<C: Coordinate> Joiner<C> {
    /// With room for so many vertices; more come in, too.
    pub(super) fn with_room(vertices: usize) -> Result<Self, Stop> {
        let random = RandomState::new();
        let mut joiner = Self {
            points: Pages {
                pages: super::with_room(vertices / PAGE + 1)?,
                count: 0,
            },
            slots: Vec::new(),
            // Odd, so never zero.
            seeds: [random.hash_one(0) | 1, random.hash_one(1) | 1],
        };
        // Half of them empty at first: most vertices are then found where they are looked for.
        joiner.place(vertices.saturating_mul(2).max(16))?;
        Ok(joiner)
    }

    /// The number of the vertex with these coordinates.
    #[inline]
    pub(super) fn number(&mut self, point: [C; 3]) -> Result<u32, Stop> {
        let mut slot = self.slot(point);
        loop {
            let number = self.slots[slot];
            if number == NONE {
                return self.add(point, slot);
            }
            if self.points.get(number as usize) == point {
                return Ok(number);
            }
            slot += 1;
            if slot == self.slots.len() {
                slot = 0;
            }
        }
    }

    fn add(&mut self, point: [C; 3], slot: usize) -> Result<u32, Stop> {
        let number = u32::try_from(self.points.len()).ok();
        let number = number.filter(|&number| number != NONE);
        let number = number.ok_or(Stop::TooMany {
            what: "vertices",
            most: MOST_VERTICES,
        })?;
        self.points.push(point)?;
        self.slots[slot] = number;
        if self.points.len() > self.slots.len() / 4 * 3 {
            self.place(self.slots.len() / 2 * 3)?;
        }
        Ok(number)
    }

    /// Puts all vertices into so many slots.
    fn place(&mut self, slots: usize) -> Result<(), Stop> {
        self.slots = Vec::new(); // given back before more is taken
        let mut fresh = super::with_room(slots)?;
        fresh.resize(slots, NONE);
        self.slots = fresh;
        for (number, point) in (0_u32..).zip(self.points.iter()) {
            let mut slot = self.slot(point);
            while self.slots[slot] != NONE {
                slot += 1;
                if slot == slots {
                    slot = 0;
                }
            }
            self.slots[slot] = number;
        }
        Ok(())
    }

    #[inline]
    fn slot(&self, point: [C; 3]) -> usize {
        let [x, y, z] = point.map(C::bits);
        let [first, second] = self.seeds;
        let hash = folded(folded(x ^ first, y ^ second) ^ first, z ^ second);
        scaled(hash, self.slots.len())
    }

    pub(super) fn check(&self, task: &Task<'_>) -> Result<(), Stop> {
        task.check_vertices(self.points.len())
    }

    /// The vertices in the order in which they came.
    pub(super) fn into_points(self) -> Pages<C> {
        self.points
    }
}

/// A hash as a number below another, by its upper bits.
#[inline]
#[allow(
    clippy::cast_possible_truncation,
    reason = "the upper half of the product is less than the second factor"
)]
fn scaled(hash: u64, most: usize) -> usize {
    ((u128::from(hash) * most as u128) >> 64) as usize
}

/// Both halves of the product, each bit of which depends on all bits below it.
#[inline]
#[allow(
    clippy::cast_possible_truncation,
    reason = "the halves of the product are wanted"
)]
pub(super) fn folded(left: u64, right: u64) -> u64 {
    let product = u128::from(left) * u128::from(right);
    product as u64 ^ (product >> 64) as u64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails shows the line")]
    use std::collections::HashMap;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_map_joins_the_same(points in proptest::collection::vec(proptest::array::uniform3(-3_i8..3), 0..3000), room in 0_usize..100) {
            let mut joiner = Joiner::with_room(room).unwrap();
            let mut map = HashMap::new();
            for point in points {
                // −0 for 0 now and then.
                let point = point.map(|value| f32::from(value) / 7.0 * if value % 2 == 0 { -1.0 } else { 1.0 });
                let fresh = u32::try_from(map.len()).unwrap();
                let expected = *map.entry(point.map(|value| (value + 0.0).to_bits())).or_insert(fresh);
                prop_assert_eq!(joiner.number(point).unwrap(), expected);
            }
            prop_assert_eq!(joiner.into_points().len(), map.len());
        }
    }

    #[test]
    fn the_table_grows() {
        let mut joiner = Joiner::with_room(0).unwrap();
        for round in 0..2 {
            for value in 0..50_000_u32 {
                let number = joiner.number([f64::from(value), 0.0, 1.0]).unwrap();
                assert_eq!(number, value, "round {round}");
            }
        }
    }
}
