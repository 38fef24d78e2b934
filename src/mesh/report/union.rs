//! Union–find: sets that grow together. The smaller number leads, so that results depend on nothing else.
//!
//! Path halving alone keeps the ways short enough (Tarjan and van Leeuwen 1984); ranks would cost memory.

/// Sets of numbers.
pub(in crate::mesh) struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// Each number below `len` alone.
    pub(in crate::mesh) fn new(len: usize) -> Self {
        Self {
            parent: (0_u32..).take(len).collect(),
        }
    }

    /// The smallest number of the set.
    pub(in crate::mesh) fn find(&mut self, mut one: u32) -> u32 {
        loop {
            let parent = self.parent[one as usize];
            if parent == one {
                return one;
            }
            let above = self.parent[parent as usize];
            self.parent[one as usize] = above;
            one = above;
        }
    }

    pub(in crate::mesh) fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.find(one), self.find(other));
        self.parent[one.max(other) as usize] = one.min(other);
    }
}

/// Sets of numbers of which any two are of the same side or of different sides. The side towards the parent is the lowest bit.
pub(in crate::mesh) struct Sides {
    parent: Vec<u32>,
}

impl Sides {
    /// Each number below `len`, which is below 2³¹, alone.
    pub(super) fn new(len: usize) -> Self {
        Self {
            parent: (0_u32..).step_by(2).take(len).collect(),
        }
    }

    /// The smallest number of the set, and whether this one is on the other side.
    pub(super) fn find(&mut self, mut one: u32) -> (u32, bool) {
        let mut side = 0;
        loop {
            let up = self.parent[one as usize];
            if up >> 1 == one {
                return (one, side == 1);
            }
            let above = self.parent[(up >> 1) as usize];
            let halved = above ^ (up & 1);
            self.parent[one as usize] = halved;
            side ^= halved & 1;
            one = halved >> 1;
        }
    }

    /// Says that the two are on the same or on different sides; false where that cannot be.
    pub(super) fn join(&mut self, one: u32, other: u32, different: bool) -> bool {
        let ((one, side), (other, other_side)) = (self.find(one), self.find(other));
        let different = different ^ side ^ other_side;
        if one == other {
            return !different;
        }
        self.parent[one.max(other) as usize] = one.min(other) << 1 | u32::from(different);
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn sets_are_those_of_a_flood(pairs in prop::collection::vec((0_u32..20, 0_u32..20), 0..30)) {
            let mut label: Vec<u32> = (0..20).collect();
            let mut sets = Sets::new(20);
            for (one, other) in pairs {
                sets.join(one, other);
                let (from, to) = (label[one as usize], label[other as usize]);
                label.iter_mut().filter(|l| **l == from).for_each(|l| *l = to);
            }
            for one in 0..20 {
                let first = label.iter().position(|l| *l == label[one as usize]);
                prop_assert_eq!(Some(sets.find(one) as usize), first);
            }
        }

        #[test]
        fn sides_that_were_chosen_are_found(
            sides in prop::collection::vec(any::<bool>(), 20),
            pairs in prop::collection::vec((0_u32..20, 0_u32..20), 0..40),
        ) {
            let differ = |one: u32, other: u32| sides[one as usize] != sides[other as usize];
            let mut found = Sides::new(20);
            for (one, other) in &pairs {
                prop_assert!(found.join(*one, *other, differ(*one, *other)));
            }
            for one in 0..20 {
                let (root, side) = found.find(one);
                prop_assert_eq!(side, differ(one, root));
                prop_assert!(found.join(one, root, side) && !found.join(one, root, !side));
            }
        }
    }
}
