//! Lines cut into tracts: of branches, and of the bifurcations between them (blanked ones, as VMTK says).
//!
//! From one sphere upstream of where a line leaves another's tube to there it is blanked; runs that overlap are one. Lines that are the
//! same up to a node have the same runs so far, so runs are kept once for all of them, each with the run before it: a tree of runs,
//! followed from tips to the root.

use std::collections::BTreeMap;

use super::leave::Exits;
use super::lines::{Lines, Place};
use super::ranges::Ranges;

/// No run, fork or group.
const NONE: u32 = u32::MAX;

/// A stretch of some lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tract {
    /// Where it begins.
    pub from: Place,
    /// Where it ends.
    pub to: Place,
    /// How many lines have it.
    pub lines: u32,
}

impl Tract {
    /// Its length.
    pub fn length(&self) -> f64 {
        self.to.along - self.from.along
    }
}

/// What a branch ends in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Down {
    Bifurcation(u32),
    Tip(u32),
}

/// Tracts in groups; bifurcations by one of their forks.
#[derive(Debug, Default)]
pub(super) struct Groups {
    /// Of branches, by the bifurcation that they begin in (none at the root) and what they end in.
    pub(super) branches: BTreeMap<(Option<u32>, Down), Vec<Tract>>,
    /// Of bifurcations, with their forks.
    pub(super) bifurcations: BTreeMap<u32, (Vec<u32>, Vec<Tract>)>,
    /// Tips of lines that never leave another's tube.
    pub(super) swallowed: Vec<u32>,
}

/// A blanked stretch.
#[derive(Clone, Copy)]
struct Run {
    from: Place,
    to: Place,
    fork: u32,
    before: u32,
    lines: u32,
}

/// Forks in sets.
struct Sets(Vec<u32>);

impl Sets {
    fn of(&mut self, fork: u32) -> u32 {
        let mut at = fork;
        while self.0[at as usize] != at {
            let next = self.0[at as usize];
            self.0[at as usize] = self.0[next as usize];
            at = next;
        }
        at
    }

    fn join(&mut self, one: u32, other: u32) {
        let [one, other] = [self.of(one), self.of(other)];
        self.0[one.max(other) as usize] = one.min(other);
    }
}

/// Cuts lines by where they leave each other's tubes.
pub(super) fn groups(lines: &Lines<'_>, exits: &Exits) -> Groups {
    let kept = kept(lines, exits);
    let mut sets = Sets((0..).take(lines.tree.len()).collect());
    let (mut runs, last) = runs(lines, exits, &kept, &mut sets);
    let mut groups = Groups::default();
    for (tip, node) in (0_u32..).zip(&lines.nodes) {
        if lines.parent(*node).is_none() {
            continue;
        }
        if !kept.has([tip, tip + 1]) {
            groups.swallowed.push(*node);
            continue;
        }
        let run = last[tip as usize];
        if run != NONE {
            runs[run as usize].lines += 1;
        }
    }
    for place in (0..runs.len()).rev() {
        let Run { before, lines, .. } = runs[place];
        if before != NONE {
            runs[before as usize].lines += lines;
        }
    }
    merge(&mut runs, &mut sets);
    for run in runs.iter().filter(|run| run.lines > 0) {
        let group = sets.of(run.fork);
        let (_, tracts) = groups.bifurcations.entry(group).or_default();
        add(tracts, run.from, run.to, run.lines);
        let (up, from) = above(lines, &runs, &mut sets, run.before, run.to.node);
        let tracts = groups.branches.entry((up, Down::Bifurcation(group)));
        add(tracts.or_default(), from, run.from, run.lines);
    }
    for (tip, node) in (0_u32..).zip(&lines.nodes) {
        if kept.has([tip, tip + 1]) && lines.parent(*node).is_some() {
            let (up, from) = above(lines, &runs, &mut sets, last[tip as usize], *node);
            let tracts = groups.branches.entry((up, Down::Tip(*node)));
            add(tracts.or_default(), from, lines.on(*node, 1.0), 1);
        }
    }
    // A root in a bifurcation has no branch before that.
    groups
        .branches
        .retain(|_, tracts| tracts.iter().any(|tract| tract.length() > 0.0));
    for fork in 0..u32::try_from(sets.0.len()).unwrap_or(NONE) {
        if lines.children.of(fork).len() > 1
            && let Some((forks, _)) = groups.bifurcations.get_mut(&sets.of(fork))
        {
            forks.push(fork);
        }
    }
    groups
}

/// The group of a run and where it ends, or where the line of a node begins.
fn above(
    lines: &Lines<'_>,
    runs: &[Run],
    sets: &mut Sets,
    run: u32,
    node: u32,
) -> (Option<u32>, Place) {
    if let Some(run) = runs.get(run as usize) {
        return (Some(sets.of(run.fork)), run.to);
    }
    let mut root = node;
    while let Some(parent) = lines.parent(root) {
        root = parent;
    }
    (None, lines.on(root, 1.0))
}

/// Adds a stretch to tracts; where there is one of the same ends, its lines to that.
fn add(tracts: &mut Vec<Tract>, from: Place, to: Place, lines: u32) {
    let same = tracts
        .iter_mut()
        .find(|tract| tract.from == from && tract.to == to);
    match same {
        Some(tract) => tract.lines += lines,
        None => tracts.push(Tract { from, to, lines }),
    }
}

/// Which lines are branches: those that leave all others' tubes. Of lines that never leave each other's those are left out first that go on least by themselves.
fn kept(lines: &Lines<'_>, exits: &Exits) -> Kept {
    let own = |tip: usize| {
        let node = lines.nodes[tip];
        let mut at = lines.parent(node);
        while let Some(above) = at.filter(|above| lines.children.of(*above).len() < 2) {
            at = lines.parent(above);
        }
        lines.along[node as usize] - at.map_or(0.0, |fork| lines.along[fork as usize])
    };
    let inside = exits.never.iter().enumerate();
    let mut inside: Vec<(f64, usize)> = inside
        .filter(|(_, never)| !never.is_empty())
        .map(|(tip, _)| (own(tip), tip))
        .collect();
    inside.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut kept = Kept::new(lines.nodes.len());
    for (_, tip) in inside {
        let mut others = exits.never[tip].iter().flat_map(Ranges::iter);
        if others.any(|range| kept.has(range)) {
            kept.leave_out(tip);
        }
    }
    kept
}

/// Tips that are left, as sums over stretches (Fenwick).
struct Kept(Vec<u32>);

impl Kept {
    fn new(count: usize) -> Self {
        // All are there: each sum is as long as its stretch.
        let length = |place: usize| u32::try_from(place & place.wrapping_neg()).unwrap_or(0);
        Self((0..=count).map(length).collect())
    }

    fn before(&self, mut place: usize) -> u32 {
        let mut sum = 0;
        while place > 0 {
            sum += self.0[place];
            place &= place - 1;
        }
        sum
    }

    fn has(&self, [from, to]: [u32; 2]) -> bool {
        self.before(to as usize) > self.before(from as usize)
    }

    fn leave_out(&mut self, tip: usize) {
        let mut place = tip + 1;
        while place < self.0.len() {
            self.0[place] -= 1;
            place += place & place.wrapping_neg();
        }
    }
}

/// The runs of all lines, and each tip's last.
fn runs(lines: &Lines<'_>, exits: &Exits, kept: &Kept, sets: &mut Sets) -> (Vec<Run>, Vec<u32>) {
    let mut runs: Vec<Run> = Vec::new();
    let mut last = vec![NONE; lines.nodes.len()];
    let mut of_node = vec![NONE; lines.tree.len()];
    let mut exits = exits.all.iter().peekable();
    for node in &lines.order {
        let mut top = lines
            .parent(*node)
            .map_or(NONE, |parent| of_node[parent as usize]);
        let is_kept = kept.has(lines.tips[*node as usize]);
        while let Some(exit) = exits.next_if(|exit| exit.at.node == *node) {
            if !is_kept || !exit.left.iter().any(|range| kept.has(range)) {
                continue;
            }
            let mut from = lines.touching_above(exit.at);
            while top != NONE && runs[top as usize].to.along > from.along {
                let run = runs[top as usize];
                sets.join(exit.fork, run.fork);
                if run.from.along < from.along {
                    from = run.from;
                }
                top = run.before;
            }
            runs.push(Run {
                from,
                to: exit.at,
                fork: exit.fork,
                before: top,
                lines: 0,
            });
            top = u32::try_from(runs.len() - 1).unwrap_or(NONE);
        }
        of_node[*node as usize] = top;
        if lines.children.of(*node).is_empty() {
            last[lines.tips[*node as usize][0] as usize] = top;
        }
    }
    (runs, last)
}

/// Runs of a line that other lines hold together are one, with what is between them.
fn merge(runs: &mut [Run], sets: &mut Sets) {
    for place in 0..runs.len() {
        let Run {
            before,
            fork,
            lines,
            ..
        } = runs[place];
        // Those before are merged with those before them by now.
        if before != NONE && sets.of(runs[before as usize].fork) == sets.of(fork) {
            let above = runs[before as usize];
            runs[before as usize].lines -= lines;
            runs[place].from = above.from;
            runs[place].before = above.before;
        }
    }
}
