//! How each class is written: as one level of a production that calls itself or others a level lower, as a number of repetitions, or as a
//! production of its own.
//!
//! A *family* is a set of classes of different heights, each the one above with its tips cut off: all branches stand alike and lead into families at
//! the same number of levels below. Its tallest member's production makes all of them. What Honda's tree grows by comes back so: `A` is a
//! family of ten, `B` and `C` are two that call each other. Families are found from the lowest class up; a single segment is the lowest of any.
//!
//! A *run* is a class whose branch at one place is the same class again with one repetition less, until something else ends it, and whose other
//! branches are the same each time or one level lower each time.

use hashbrown::HashMap;

use super::classes::{Class, Classes, Entry, LEAF, NONE, Roll};

/// Families of one kind that a class is compared with, and runs begin with so many repetitions.
const COMPARED: usize = 8;
const REPETITIONS: u32 = 3;

/// How a class is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// A segment.
    Leaf,
    /// A production of its own, or what stands in it.
    Plain,
    /// A level of a family: one of single segments, two of a fork.
    Level { family: u32, level: u32 },
    /// So many repetitions.
    Run { run: u32, count: u32 },
}

/// What stands at a branch of a family's production.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// One member does not tell.
    Open,
    /// A family's level.
    Level,
    /// The same class at each level.
    Same,
}

/// A branch of a family's production.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub(super) roll: Roll,
    kind: Kind,
    /// [`NONE`] as long as single segments alone stood there.
    family: u32,
    /// Levels that it is lower.
    pub(super) below: u32,
    /// What stands there in the member that was looked at first.
    class: u32,
}

impl Slot {
    /// The family whose level stands there, if one does.
    pub(super) fn level(&self) -> Option<u32> {
        (self.kind != Kind::Same && self.family != NONE).then_some(self.family)
    }

    /// Both at once, if they agree.
    fn and(&self, other: &Self, fixed: bool) -> Option<Self> {
        let roll = self.roll.and(other.roll)?;
        let kind = match self.kind {
            Kind::Open if fixed && self.class == other.class => Kind::Same,
            Kind::Open => Kind::Level,
            known => known,
        };
        if kind == Kind::Same {
            let agree = self.class == other.class && self.roll == other.roll;
            return agree.then_some(Self { kind, ..*self });
        }
        let family = match (self.family, other.family) {
            (NONE, family) | (family, NONE) => family,
            (one, other) if one == other => one,
            _ => return None,
        };
        let agree = self.below == other.below;
        agree.then_some(Self {
            roll,
            kind,
            family,
            ..*self
        })
    }
}

#[derive(Clone, Debug, Default)]
pub(super) struct Family {
    pub(super) slots: Vec<Slot>,
    /// By level.
    members: HashMap<u32, u32>,
    /// The tallest class.
    pub(super) top: u32,
    /// The lowest member's level.
    pub(super) lowest: u32,
    /// What stands below the lowest member where that is no single segment, and the level that it has there.
    base: Option<Base>,
}

/// A class, and which level of a family it stands for.
type Base = (u32, u32);

/// A branch of a run that is not what repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Beside {
    Same(u32),
    /// A family's level, as many above the repetition's number.
    Level {
        family: u32,
        above: i64,
    },
}

#[derive(Clone, Debug)]
pub(super) struct Run {
    /// Where the branch is that repeats it.
    pub(super) place: usize,
    /// The class that ends it.
    pub(super) tail: u32,
    /// None at `place`.
    pub(super) beside: Vec<Option<Beside>>,
    /// The tallest class.
    pub(super) top: u32,
}

pub(super) struct Forms {
    pub(super) of: Vec<Form>,
    pub(super) families: Vec<Family>,
    pub(super) runs: Vec<Run>,
}

impl Forms {
    /// `fixed`: branches of a family may also be the same at each level.
    pub(super) fn new(classes: &Classes, fixed: bool) -> Self {
        let mut forms = Self {
            of: vec![Form::Plain; classes.all.len()],
            families: Vec::new(),
            runs: Vec::new(),
        };
        let mut by_height: Vec<u32> = (0..).take(classes.all.len()).collect();
        by_height.sort_by_key(|class| classes.all[*class as usize].height);
        let homes = forms.find_families(&classes.all, &by_height, fixed);
        let counted = forms.counted();
        for (form, home) in forms.of.iter_mut().zip(&homes) {
            if let Some((family, level)) = *home
                && counted[family as usize]
            {
                *form = Form::Level { family, level };
            }
        }
        if let Some(leaf) = forms.of.first_mut() {
            *leaf = Form::Leaf;
        }
        forms.find_runs(&classes.all, &by_height);
        forms
    }

    /// The family and level of each class.
    fn find_families(
        &mut self,
        all: &[Class],
        by_height: &[u32],
        fixed: bool,
    ) -> Vec<Option<(u32, u32)>> {
        let mut homes: Vec<Option<(u32, u32)>> = vec![None; all.len()];
        let mut alike: HashMap<Vec<[u32; 4]>, Vec<u32>> = HashMap::new();
        for class in by_height.iter().copied().filter(|class| *class != LEAF) {
            let Class {
                entries, height, ..
            } = &all[class as usize];
            let level = height + 1;
            let slots: Vec<Slot> = entries
                .iter()
                .map(|entry| Slot {
                    roll: entry.roll,
                    kind: Kind::Open,
                    class: entry.class,
                    family: homes[entry.class as usize].map_or(NONE, |(family, _)| family),
                    below: level - (all[entry.class as usize].height + 1),
                })
                .collect();
            let known = alike
                .entry(entries.iter().map(Entry::stance).collect())
                .or_default();
            let joined = known.iter().take(COMPARED).find_map(|family| {
                let one = &self.families[*family as usize];
                let (slots, base) = match one.joined(&slots, fixed) {
                    Some(slots) => (slots, one.base),
                    None => one.joined_above(*family, &slots, fixed)?,
                };
                (!one.members.contains_key(&level)).then_some((*family, slots, base))
            });
            let family = match joined {
                Some((family, slots, base)) => {
                    let one = &mut self.families[family as usize];
                    (one.slots, one.base) = (slots, base);
                    family
                }
                None => {
                    let family = u32::try_from(self.families.len()).unwrap_or(NONE);
                    self.families.push(Family {
                        slots,
                        lowest: level,
                        ..Family::default()
                    });
                    known.push(family);
                    family
                }
            };
            let one = &mut self.families[family as usize];
            one.members.insert(level, class);
            one.top = class;
            homes[class as usize] = Some((family, level));
        }
        homes
    }

    /// Which families are written with levels: those of several classes, and those that they lead into.
    fn counted(&self) -> Vec<bool> {
        let mut counted = vec![false; self.families.len()];
        let several = |family: &u32| self.families[*family as usize].members.len() > 1;
        let families = (0_u32..).take(self.families.len());
        let mut open: Vec<u32> = families.filter(several).collect();
        while let Some(family) = open.pop() {
            if std::mem::replace(&mut counted[family as usize], true) {
                continue;
            }
            let into = self.families[family as usize].slots.iter();
            open.extend(into.filter_map(Slot::level));
        }
        counted
    }

    /// Whether branches of any family of several levels are the same at each.
    pub(super) fn has_fixed(&self) -> bool {
        let is_fixed = |slot: &Slot| slot.kind == Kind::Same;
        let mut families = self.families.iter();
        families.any(|one| one.members.len() > 2 && one.slots.iter().any(is_fixed))
    }

    /// Runs among what is in no family.
    fn find_runs(&mut self, all: &[Class], by_height: &[u32]) {
        // By class: the run, how many repetitions, and how it stands beside the one below, before it is known whether the run is long.
        let mut found: Vec<Option<(u32, u32)>> = vec![None; all.len()];
        let mut runs: Vec<Run> = Vec::new();
        let mut taken: HashMap<(u32, u32), u32> = HashMap::new();
        for class in by_height.iter().copied() {
            if self.of[class as usize] != Form::Plain {
                continue;
            }
            let entries = &all[class as usize].entries;
            for place in (0..entries.len()).rev() {
                let below = entries[place].class;
                if self.of[below as usize] != Form::Plain {
                    continue;
                }
                let (run, count) = match found[below as usize] {
                    Some((run, count)) if runs[run as usize].place == place => (run, count),
                    Some(_) => continue,
                    None => (NONE, 1),
                };
                let Some(beside) = self.beside(all, [class, below], place, i64::from(count)) else {
                    continue;
                };
                let run = match run {
                    NONE => {
                        runs.push(Run {
                            place,
                            tail: all[below as usize].entries[place].class,
                            beside,
                            top: class,
                        });
                        let run = u32::try_from(runs.len() - 1).unwrap_or(NONE);
                        found[below as usize] = Some((run, 1));
                        run
                    }
                    run if runs[run as usize].beside == beside => run,
                    _ => continue,
                };
                if taken.contains_key(&(run, count + 1)) {
                    continue;
                }
                taken.insert((run, count + 1), class);
                runs[run as usize].top = class;
                found[class as usize] = Some((run, count + 1));
                break;
            }
        }
        let longest =
            |run: u32| found[runs[run as usize].top as usize].map_or(0, |(_, count)| count);
        for (form, found) in self.of.iter_mut().zip(&found) {
            if let Some((run, count)) = *found
                && longest(run) >= REPETITIONS
            {
                *form = Form::Run { run, count };
            }
        }
        self.runs = runs;
    }

    /// How the branches of a class that are not at a place stand to those of the class at that place, which has `count` repetitions.
    fn beside(
        &self,
        all: &[Class],
        [class, below]: [u32; 2],
        place: usize,
        count: i64,
    ) -> Option<Vec<Option<Beside>>> {
        let [upper, lower] = [class, below].map(|class| &all[class as usize].entries);
        if upper.len() != lower.len() {
            return None;
        }
        let mut beside = Vec::with_capacity(upper.len());
        for (at, (upper, lower)) in upper.iter().zip(lower).enumerate() {
            if upper.stance() != lower.stance() {
                return None;
            }
            if at == place {
                // What ends a run may look the same however it is rolled.
                upper
                    .roll
                    .and(lower.roll)
                    .filter(|roll| *roll == upper.roll)?;
                beside.push(None);
                continue;
            }
            if upper.class == lower.class && upper.roll == lower.roll {
                beside.push(Some(Beside::Same(upper.class)));
                continue;
            }
            let level = |entry: &Entry| match self.of[entry.class as usize] {
                Form::Level { family, level } => Some((family, level)),
                _ => None,
            };
            let ((family, high), (other, low)) = (level(upper)?, level(lower)?);
            if family != other || high != low + 1 || upper.roll != lower.roll {
                return None;
            }
            let above = i64::from(low) - count;
            beside.push(Some(Beside::Level { family, above }));
        }
        Some(beside)
    }
}

impl Family {
    /// The slots with those of another member, if they agree.
    fn joined(&self, slots: &[Slot], fixed: bool) -> Option<Vec<Slot>> {
        let both = self.slots.iter().zip(slots);
        both.map(|(one, other)| one.and(other, fixed)).collect()
    }

    /// The same with the first member that repeats the only one so far, below which something else stands.
    fn joined_above(
        &self,
        family: u32,
        slots: &[Slot],
        fixed: bool,
    ) -> Option<(Vec<Slot>, Option<Base>)> {
        if !fixed || self.members.len() != 1 {
            return None;
        }
        let mut base = None;
        let both = self.slots.iter().zip(slots);
        let joined = both.map(|(one, other)| {
            if one.class == other.class {
                return one.and(other, true);
            }
            let below = (one.class, self.lowest.checked_sub(one.below)?);
            let is_same = *base.get_or_insert(below) == below && one.below == other.below;
            (is_same && other.family == family && other.class == self.top).then_some(Slot {
                roll: one.roll.and(other.roll)?,
                kind: Kind::Level,
                family,
                ..*one
            })
        });
        let joined = joined.collect::<Option<Vec<Slot>>>()?;
        base.is_some().then_some((joined, base))
    }

    /// What its lowest level is made of where its production does not make it, and which level that is.
    pub(super) fn base(&self) -> Option<Base> {
        // A single segment has none of the branches that are the same at each level.
        let more = self.slots.iter().any(|slot| slot.level().is_none());
        self.base.or(more.then_some((LEAF, 1)))
    }
}
