//! Sets of tips: stretches of their numbers.

/// Stretches from one number up to before another, in order, without common numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Ranges(Vec<[u32; 2]>);

impl Ranges {
    /// A stretch without a part of it.
    pub(super) fn without([from, to]: [u32; 2], part: [u32; 2]) -> Self {
        let both = [[from, part[0]], [part[1], to]];
        Self(
            both.into_iter()
                .filter(|range| range[0] < range[1])
                .collect(),
        )
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = [u32; 2]> {
        self.0.iter().copied()
    }

    /// What it has in common with a stretch.
    pub(super) fn common(&self, [from, to]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
        let first = self.0.partition_point(|range| range[1] <= from);
        let ranges = self.0[first..].iter();
        ranges
            .take_while(move |range| range[0] < to)
            .map(move |range| [range[0].max(from), range[1].min(to)])
    }

    /// Adds stretches.
    pub(super) fn add(&mut self, more: impl Iterator<Item = [u32; 2]>) {
        for [from, to] in more {
            // Those that it touches become one with it.
            let first = self.0.partition_point(|range| range[1] < from);
            let last = self.0.partition_point(|range| range[0] <= to);
            let touched = &self.0[first..last];
            let from = touched.first().map_or(from, |range| range[0].min(from));
            let to = touched.last().map_or(to, |range| range[1].max(to));
            self.0.splice(first..last, [[from, to]]);
        }
    }

    /// What is in this and not in another.
    pub(super) fn minus(&self, other: &Self) -> Self {
        let mut left = Vec::new();
        for [mut from, to] in self.iter() {
            for [out, back] in other.common([from, to]) {
                if from < out {
                    left.push([from, out]);
                }
                from = back;
            }
            if from < to {
                left.push([from, to]);
            }
        }
        Self(left)
    }
}
