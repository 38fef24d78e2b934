//! Fewer segments: neighbours along an axis become one, and where that is not enough thin twigs go while others grow wider.
//!
//! A segment that stands for two has the outer ring of each, as they were, so it joins whatever level its own neighbours have (but for what has grown wider, by
//! less than can be seen). What is off is how far the
//! middle was from the chord, what the radius there differs from the chord's, and by how much rings that lean towards each other thin a tube.
//!
//! A piece of an axis that is one segment already can only go. Its neighbour in the cluster takes its width: a twig that is a quarter of a pixel wide
//! covers a quarter of its pixels, so two of them are as dark as one of twice the width (shaders/tree.wgsl draws what is thinner than a pixel faint). What
//! is off is the width of what has grown.

use glam::Vec3;

use super::super::tubes::{
    CAPPED, GROWING, LETTER_SHIFT, PAINTED, STARTS, TubeSegment, WIDER_SHIFT, unpack_frame,
};
use super::{Record, mark};

/// How much of the surplus goes in one round, after which costs are worked out anew: one part in so many.
const SHARE: usize = 2;

impl Record for TubeSegment {
    fn corners(&self) -> [Vec3; 2] {
        let [from, to, base] = [self.from, self.to, self.base].map(Vec3::from);
        let base = if self.flags & GROWING == 0 { to } else { base };
        let radius = self.size() / 2.0;
        [
            from.min(to).min(base) - radius,
            from.max(to).max(base) + radius,
        ]
    }

    fn size(&self) -> f32 {
        2.0 * self.radii.iter().copied().fold(0.0, f32::max)
    }

    fn ends(&self) -> bool {
        self.flags & CAPPED != 0
    }

    fn mark(&self) -> u64 {
        mark(self.to)
    }

    /// How far it is off, metres.
    const NOTE: f32 = 0.0;

    fn halve(run: &mut Vec<(Self, f32)>, most: usize) -> f32 {
        let mut worst = 0.0_f32;
        let mut steps: Vec<Option<Step>> = (0..run.len()).map(|at| Step::of(run, at)).collect();
        let mut order: Vec<u64> = Vec::with_capacity(run.len());
        let mut touched = vec![false; run.len()];
        while run.len() > most {
            let surplus = (run.len() - most).div_ceil(SHARE);
            order.clear();
            let numbered = (0_u32..).zip(&steps);
            order.extend(numbered.filter_map(|(at, step)| Some(step.as_ref()?.key(at))));
            order.sort_unstable();
            touched.fill(false);
            let mut gone = 0;
            for key in &order {
                if gone == surplus {
                    break;
                }
                #[allow(
                    clippy::cast_possible_truncation,
                    reason = "the place is in the lower half"
                )]
                let at = *key as u32 as usize;
                if let Some(step) = steps[at].filter(|step| step.apply(run, at, &mut touched)) {
                    worst = worst.max(step.off);
                    gone += 1;
                }
            }
            if gone == 0 {
                break;
            }
            close_up(run, &mut steps, &mut touched);
        }
        worst
    }
}

/// Flags that no record has: it was left out.
const GONE: u32 = u32::MAX;

/// Takes what is gone out of a run, and works out anew what may be done where something changed.
fn close_up(
    run: &mut Vec<(TubeSegment, f32)>,
    steps: &mut Vec<Option<Step>>,
    touched: &mut Vec<bool>,
) {
    let count = run.len();
    let mut left = 0;
    let mut changed = [false, touched.first().copied().unwrap_or(false)];
    for at in 0..count {
        // What can be done with a segment hangs on its neighbours.
        let [before, own] = changed;
        let after = touched.get(at + 1).copied().unwrap_or(false);
        changed = [own, after];
        if run[at].0.flags != GONE {
            run[left] = run[at];
            steps[left] = steps[at];
            touched[left] = before || own || after;
            left += 1;
        }
    }
    run.truncate(left);
    steps.truncate(left);
    touched.truncate(left);
    for at in 0..left {
        if touched[at] {
            steps[at] = Step::of(run, at);
        }
    }
}

/// One segment less, at a place of a run.
#[derive(Clone, Copy)]
struct Step {
    /// How far what is left is off, metres.
    off: f32,
    way: Way,
}

/// What becomes of the segment there.
#[derive(Clone, Copy)]
enum Way {
    /// It takes the next one over, which goes.
    Joins,
    /// It goes, and the one before takes its width,
    Before,
    /// or the one after.
    After,
}

impl Step {
    /// The best way to do without a segment; `None` where its predecessor can take it over as well.
    fn of(run: &[(TubeSegment, f32)], at: usize) -> Option<Self> {
        let after = run.get(at + 1);
        if let Some(next) = after.filter(|next| goes_on(&run[at].0, &next.0)) {
            return Some(Self {
                off: chord_is_off(&run[at].0, &next.0) + run[at].1.max(next.1),
                way: Way::Joins,
            });
        }
        let before = at.checked_sub(1).and_then(|before| run.get(before));
        if before.is_some_and(|before| goes_on(&before.0, &run[at].0)) {
            return None;
        }
        let neighbours = [(before, Way::Before), (after, Way::After)];
        let takers = neighbours.into_iter().filter_map(|(taker, way)| {
            let (segment, off) = taker?;
            Some(Self {
                off: widened(segment, &run[at].0).max(*off),
                way,
            })
        });
        takers.min_by(|a, b| a.off.total_cmp(&b.off))
    }

    /// A number that is larger where more is off, and where as much is, farther along the run; its lower half is the place.
    fn key(&self, at: u32) -> u64 {
        let bits = self.off.to_bits();
        // As `total_cmp` orders them.
        let above = if bits >> 31 == 0 {
            bits | 1 << 31
        } else {
            !bits
        };
        u64::from(above) << 32 | u64::from(at)
    }

    /// Does it, unless one of the two has changed in this round.
    fn apply(&self, run: &mut [(TubeSegment, f32)], at: usize, touched: &mut [bool]) -> bool {
        let (goes, takes) = match self.way {
            Way::Joins => (at + 1, at),
            Way::Before => (at, at - 1),
            Way::After => (at, at + 1),
        };
        if touched[goes] || touched[takes] {
            return false;
        }
        (touched[goes], touched[takes]) = (true, true);
        let gone = run[goes].0;
        let (segment, note) = &mut run[takes];
        if goes_on(segment, &gone) {
            *segment = joined(segment, &gone);
            // A wide tube may be off by less than what it stands for.
            *note = note.max(self.off);
        } else {
            widen(segment, wider(segment, &gone));
            *note = self.off;
        }
        run[goes].0.flags = GONE;
        true
    }
}

/// Bits that say how much wider a segment is than its twig.
const WIDER: u32 = 0xff << WIDER_SHIFT;

/// Makes a segment wider, and notes it; one of no width stays as it is.
fn widen(segment: &mut TubeSegment, factor: f32) {
    if !factor.is_finite() {
        return;
    }
    segment.radii = segment.radii.map(|radius| radius * factor);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a factor is 1 at least, and `as` saturates"
    )]
    let more = (16.0 * factor.log2()).round() as u32;
    let all = ((segment.flags & WIDER) >> WIDER_SHIFT).saturating_add(more);
    segment.flags = segment.flags & !WIDER | all.min(0xff) << WIDER_SHIFT;
}

/// Whether a segment continues another's tube, and grows and looks as it does.
fn goes_on(first: &TubeSegment, second: &TubeSegment) -> bool {
    first.to == second.from
        && first.flags & CAPPED == 0
        && second.flags & STARTS == 0
        && look(first) == look(second)
        && first.flags & GROWING == second.flags & GROWING
        && (first.flags & GROWING == 0 || first.base == second.base)
}

/// What a segment looks like: letters are not to be seen.
fn look(segment: &TubeSegment) -> Option<u32> {
    (segment.flags & PAINTED != 0).then_some(segment.flags >> LETTER_SHIFT)
}

/// One segment for two that follow each other.
fn joined(first: &TubeSegment, second: &TubeSegment) -> TubeSegment {
    TubeSegment {
        to: second.to,
        v_to: second.v_to,
        to_frame: second.to_frame,
        base: second.base,
        flags: first.flags | second.flags & CAPPED,
        radii: [
            first.radii[0],
            first.radii[1],
            second.radii[2],
            second.radii[3],
        ],
        ..*first
    }
}

/// How far two segments are from the one that stands for them.
fn chord_is_off(first: &TubeSegment, second: &TubeSegment) -> f32 {
    let [from, middle, to] = [first.from, first.to, second.to].map(Vec3::from);
    let chord = to - from;
    let along = (middle - from).dot(chord) / chord.length_squared();
    let along = if along.is_finite() {
        along.clamp(0.0, 1.0)
    } else {
        0.0
    };
    let away = middle.distance(from + chord * along);
    let radius = |now: usize| {
        let even = first.radii[now] + along * (second.radii[2 + now] - first.radii[now]);
        (first.radii[2 + now] - even).abs()
    };
    let turned = unpack_frame(first.from_frame)
        .dot(unpack_frame(second.to_frame))
        .abs();
    let widest = first.size().max(second.size()) / 2.0;
    away + radius(0).max(radius(1)) + widest * (1.0 - turned.min(1.0))
}

/// How much wider a segment gets that takes another's width; infinitely where it has none itself.
fn wider(takes: &TubeSegment, goes: &TubeSegment) -> f32 {
    let shown = |segment: &TubeSegment| {
        let length = Vec3::from(segment.from).distance(Vec3::from(segment.to));
        length * (segment.radii[1] + segment.radii[3])
    };
    match (shown(takes), shown(goes)) {
        (_, 0.0) => 1.0,
        (takes, goes) => 1.0 + goes / takes,
    }
}

/// How wide it is then; no narrower than what goes.
fn widened(takes: &TubeSegment, goes: &TubeSegment) -> f32 {
    let factor = wider(takes, goes);
    if factor.is_finite() {
        (takes.size() * factor).max(goes.size())
    } else {
        f32::INFINITY
    }
}
