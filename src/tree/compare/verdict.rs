//! A verdict on two trees, in words, by thresholds that are said.
//!
//! | verdict | where |
//! |---|---|
//! | the same | counts are equal, the papers' numbers and totals are within 1 % at one size, and barcodes differ by less than 0.2 % of their bars |
//! | of the same kind | no quantity is told apart, barcodes differ by no more than a third of their bars, and neither has more than one and a half times as many branches as the other |
//! | alike in part | the same, but that quantities are told apart that do not make a kind: how branches run and taper, how junctions share |
//! | too few to tell | where nothing else is against the same kind, and one tree has fewer branches than tests take |
//! | different | else |
//!
//! Trees are of one kind as they are, or at one size: they are judged the way in which fewer quantities that make a kind are told apart.

use super::numbers::Difference;
use super::samples::{Apart, VALUES_LEAST};
use super::{Pair, Topology};

/// Up to what part numbers of the same tree differ.
pub const SAME_NUMBERS: f64 = 0.01;
/// Up to what share of bars barcodes of the same tree differ, and places by the trees' reach.
pub const SAME_BARS: f64 = 0.002;
/// Up to what share of bars barcodes of trees of the same kind differ.
pub const KIND_BARS: f64 = 1.0 / 3.0;
/// Up to how many times as many branches one has as the other.
pub const KIND_BRANCHES: f64 = 1.5;
/// Differences that are named.
const NAMED: usize = 3;

/// What two trees are to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One tree, wherever it stands.
    Same,
    /// As alike as two of one kind are.
    SameKind,
    /// Of one kind by sizes, angles and branching, and not by all that is looked at.
    InPart,
    /// Too few branches to say.
    TooFew,
    /// Not of one kind.
    Different,
}

impl Kind {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::SameKind => "same_kind",
            Self::InPart => "alike_in_part",
            Self::TooFew => "too_few",
            Self::Different => "different",
        }
    }
}

/// A verdict.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// What they are.
    pub kind: Kind,
    /// In a sentence or two, without a full stop at the end.
    pub words: String,
    /// Whether they are judged at one size.
    pub at_one_size: bool,
    /// How many numbers of the papers' table are within tolerance, of how many.
    pub within: [usize; 2],
    /// How many distributions are told apart, of how many that can be tested.
    pub told_apart: [usize; 2],
}

/// Judges a pair whose verdict is not there yet.
pub(super) fn verdict(pair: &Pair) -> Verdict {
    let kind = kind(pair);
    let words = match kind {
        Kind::Same => same(pair),
        Kind::SameKind => format!("of the same kind{}: {}", sized(pair), alike(pair)),
        Kind::InPart => {
            let other = not_of_kind(pair);
            format!(
                "alike in sizes, angles and branching{}, and not in all: {}; {}",
                sized(pair),
                named(other),
                alike(pair)
            )
        }
        Kind::TooFew => format!(
            "not told apart{}, of too few branches to tell ({} and {}; tests take {VALUES_LEAST} or more): {}",
            sized(pair),
            pair.branches[0],
            pair.branches[1],
            alike(pair)
        ),
        Kind::Different => format!("different: {}", different(pair)),
    };
    Verdict {
        kind,
        words,
        at_one_size: at_one_size(pair),
        within: within(pair),
        told_apart: told_apart(pair),
    }
}

fn kind(pair: &Pair) -> Kind {
    if is_same(pair) {
        return Kind::Same;
    }
    if !against(pair).is_empty() {
        return Kind::Different;
    }
    if pair
        .branches
        .iter()
        .any(|branches| *branches < VALUES_LEAST)
    {
        return Kind::TooFew;
    }
    if !not_of_kind(pair).is_empty() {
        return Kind::InPart;
    }
    Kind::SameKind
}

fn is_same(pair: &Pair) -> bool {
    let near = |one: &Difference| {
        let relative = one
            .relative_scale_free
            .unwrap_or_else(|| if one.a == one.b { 0.0 } else { 1.0 });
        let is_count = ["centerlines", "junctions", "branches"].contains(&one.name);
        relative.abs() <= if is_count { 0.0 } else { SAME_NUMBERS }
    };
    let looked_at = |one: &&Difference| one.of_papers || one.name.starts_with("total_");
    let Topology { path, radial, .. } = &pair.topology;
    pair.differences.iter().filter(looked_at).all(near)
        && [path, radial]
            .iter()
            .all(|bars| bars.scale_free.share <= SAME_BARS)
        && pair.branches[0] > 0
}

/// Whether they are judged at one size: where fewer quantities that make a kind are told apart then than as they are.
fn at_one_size(pair: &Pair) -> bool {
    let count = |all: &[Apart]| {
        all.iter()
            .filter(|one| one.of_kind && one.is_told())
            .count()
    };
    count(&pair.scale_free) < count(&pair.distributions)
}

/// Of a size that differs.
fn sized(pair: &Pair) -> String {
    match at_one_size(pair) {
        false => String::new(),
        true => format!(", the second {} times as large", rounded(pair.scale)),
    }
}

/// Where the same tree stands.
fn same(pair: &Pair) -> String {
    let Some(space) = &pair.space else {
        return "the same tree".to_owned();
    };
    let near = |apart: super::space::Apart| apart.max <= 5.0 * SAME_BARS * space.reach;
    let scaled = (pair.scale - 1.0).abs() > SAME_NUMBERS;
    let size = match scaled {
        true => format!(" {} times as large", rounded(pair.scale)),
        false => String::new(),
    };
    if near(space.as_is) {
        "the same tree at the same place".to_owned()
    } else if near(space.rooted) {
        "the same tree at another place".to_owned()
    } else if near(space.fitted.apart) {
        let turned =
            space.fitted.turn.col(0).x < 0.999_999 || space.fitted.turn.col(1).y < 0.999_999;
        let and = if turned && scaled { ", and" } else { "" };
        let turned = if turned { " turned" } else { "" };
        format!("the same tree{size}{and}{turned}")
    } else if near(space.mirrored.apart) {
        format!(
            "the same tree mirrored{}",
            if scaled { format!(", and{size}") } else { size }
        )
    } else {
        format!(
            "the same measures and the same branching{}, laid out in another way in space",
            if scaled { format!(" {size}") } else { size }
        )
    }
}

/// The distributions that are judged.
fn judged(pair: &Pair) -> &[Apart] {
    match at_one_size(pair) {
        true => &pair.scale_free,
        false => &pair.distributions,
    }
}

/// Quantities that are told apart, those that make a kind or the others, each with how far.
fn told(pair: &Pair, of_kind: bool) -> Vec<(f64, String)> {
    let told = judged(pair)
        .iter()
        .filter(|one| one.of_kind == of_kind && one.is_told());
    told.map(|one| (one.d.unwrap_or_default(), in_words(one)))
        .collect()
}

/// What weighs most first.
fn by_weight(mut all: Vec<(f64, String)>) -> Vec<String> {
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, said)| said).collect()
}

/// Quantities that are told apart and do not make a kind.
fn not_of_kind(pair: &Pair) -> Vec<String> {
    by_weight(told(pair, false))
}

/// What keeps two trees from being of one kind, what weighs most first.
fn against(pair: &Pair) -> Vec<String> {
    let mut all = told(pair, true);
    let path = &pair.topology.path.scale_free;
    if path.share > KIND_BARS {
        let said = format!(
            "{} % of the branching (barcodes) has no counterpart",
            percent(path.share)
        );
        all.push((path.share, said));
    }
    let [a, b] = pair.branches.map(|branches| branches as f64);
    if a.max(b) > KIND_BRANCHES * a.min(b) {
        let share = (a - b).abs() / a.max(b);
        all.push((share, format!("{a} and {b} branches")));
    }
    by_weight(all)
}

/// A few of them in words, and how many more there are.
fn named(all: Vec<String>) -> String {
    let more = all.len().saturating_sub(NAMED);
    let said = all.into_iter().take(NAMED).collect::<Vec<_>>().join("; ");
    match more {
        0 => said,
        more => format!("{said}; and {more} more"),
    }
}

fn in_words(one: &Apart) -> String {
    let name = one.words.trim_end_matches(" (°)");
    let delta = one.tested.map_or(0.0, |tested| tested.delta);
    let way = match delta {
        _ if delta > 0.147 => "is smaller in the second",
        _ if delta < -0.147 => "is larger in the second",
        _ => "is spread in another way",
    };
    format!("{name} {way} (D {:.2})", one.d.unwrap_or_default())
}

fn different(pair: &Pair) -> String {
    let mut all = against(pair);
    all.extend(not_of_kind(pair));
    let said = named(all);
    match at_one_size(pair) {
        false => said,
        true => format!(
            "{said}; at one size, the second being {} times as large",
            rounded(pair.scale)
        ),
    }
}

/// What speaks for one kind.
fn alike(pair: &Pair) -> String {
    let ([within, of], [apart, tested]) = (within(pair), told_apart(pair));
    let share = percent(pair.topology.path.scale_free.share);
    let of_size = if at_one_size(pair) {
        " at one size"
    } else {
        ""
    };
    let told = match tested {
        0 => "no distribution can be tested".to_owned(),
        tested => format!("{apart} of {tested} distributions are told apart"),
    };
    format!(
        "{within} of {of} numbers of the papers' table are within tolerance{of_size}, {told}, and {share} % of the branching has no counterpart"
    )
}

/// How many numbers of the papers' table are within tolerance, of how many.
fn within(pair: &Pair) -> [usize; 2] {
    let scale_free = at_one_size(pair);
    let papers = || pair.differences.iter().filter(|one| one.of_papers);
    let within = papers().filter(|one| one.matches(scale_free));
    [within.count(), papers().count()]
}

/// How many distributions are told apart, of how many that can be tested.
fn told_apart(pair: &Pair) -> [usize; 2] {
    let tested = || judged(pair).iter().filter(|one| one.tested.is_some());
    let apart = tested().filter(|one| one.is_told());
    [apart.count(), tested().count()]
}

fn percent(share: f64) -> String {
    format!("{:.0}", 100.0 * share)
}

/// Three digits.
fn rounded(number: f64) -> String {
    let digits = match number {
        _ if number >= 100.0 => 0,
        _ if number >= 10.0 => 1,
        _ if number >= 0.1 => 2,
        _ => 4,
    };
    format!("{number:.digits$}")
}
