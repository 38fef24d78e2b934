//! Parts of the tree that are alike, found from the tips down: a part is known by how its branches stand to its first segment and by what parts they
//! are, with lengths and radii as multiples of that segment's, so that a smaller copy is the same part.
//!
//! Angles and multiples that are alike are one number (`number::groups`). Equal parts are one class, as in the sharing of equal subtrees of a
//! tree by hashing (Downey, Sethi and Tarjan 1980).

use hashbrown::HashMap;

use super::frames::{Frames, Rolled, Turn, frame, roll_to, wrapped};
use super::number::{Sample, groups, shortest};
use super::shape::Shape;
use crate::tree::NO_PARENT;

/// No class: a part with a segment without length or radius, of which there are no multiples.
pub(super) const NONE: u32 = u32::MAX;

/// The class of a single segment.
pub(super) const LEAF: u32 = 0;

/// How a branch's frame is rolled behind its turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Roll {
    /// It looks the same however it is.
    Any,
    /// By `$`.
    Level,
    /// By one of the angles.
    By(u32),
}

impl Roll {
    /// Both at once, if they agree.
    pub(super) fn and(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Any, one) | (one, Self::Any) => Some(one),
            (one, other) => (one == other).then_some(one),
        }
    }
}

/// A branch of a part; numbers stand for places in [`Numbers`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Entry {
    pub(super) turn_roll: u32,
    pub(super) pitch: u32,
    /// Its first segment's length and radius as multiples.
    pub(super) length: u32,
    pub(super) radius: u32,
    pub(super) roll: Roll,
    pub(super) class: u32,
}

impl Entry {
    /// What it is without what grows there.
    pub(super) fn stance(&self) -> [u32; 4] {
        [self.turn_roll, self.pitch, self.length, self.radius]
    }
}

/// A part of the tree, as often as it is there.
#[derive(Clone, Debug, Default)]
pub(super) struct Class {
    pub(super) entries: Vec<Entry>,
    /// Segments on its longest way, less one.
    pub(super) height: u32,
    /// Parts of this class.
    pub(super) uses: u32,
}

/// What the numbers of entries are: degrees and multiples.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub(super) rolls: Vec<f64>,
    pub(super) pitches: Vec<f64>,
    pub(super) lengths: Vec<f64>,
    pub(super) radii: Vec<f64>,
}

/// All classes of a shape.
pub(super) struct Classes {
    pub(super) all: Vec<Class>,
    pub(super) numbers: Numbers,
    /// By node of the shape.
    pub(super) of: Vec<u32>,
    pub(super) frames: Frames,
}

/// How classes are told apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Alike {
    pub(super) rolled: Rolled,
    /// Angles in radians, and logarithms of multiples, are the same when they are no farther apart.
    pub(super) apart: f64,
    /// All radii are one, so that none is told.
    pub(super) one_radius: bool,
}

/// Parts of `apart` that numbers are rounded by.
const ROUNDED: f64 = 0.125;

impl Classes {
    pub(super) fn new(shape: &Shape, alike: Alike) -> Self {
        let frames = Frames::new(shape, alike.rolled, alike.apart);
        let mut measured = Measured::new(shape, &frames, alike);
        let (numbers, entries) = measured.grouped(shape, &frames, alike);
        let mut classes = Self {
            all: vec![Class::default()],
            numbers,
            of: vec![NONE; shape.len()],
            frames,
        };
        classes.hash(shape, &entries);
        classes
    }

    /// Gives each part its class.
    fn hash(&mut self, shape: &Shape, entries: &[Option<Entry>]) {
        let mut known: HashMap<Vec<Entry>, u32> = HashMap::new();
        let mut key = Vec::new();
        for node in (0..shape.len()).rev() {
            if shape.parent[node] == NO_PARENT || self.frames.heading[node] == glam::DVec3::ZERO {
                continue;
            }
            key.clear();
            let children = shape.children(u32::try_from(node).unwrap_or(NO_PARENT));
            for child in children {
                let class = self.of[*child as usize];
                let entry = entries[*child as usize].filter(|_| class != NONE);
                key.extend(entry.map(|entry| Entry { class, ..entry }));
            }
            if key.len() < children.len() {
                continue;
            }
            let class = match known.get(&key) {
                _ if key.is_empty() => LEAF,
                Some(class) => *class,
                None => {
                    let class = u32::try_from(self.all.len()).unwrap_or(NONE);
                    let below = key
                        .iter()
                        .map(|entry| self.all[entry.class as usize].height);
                    self.all.push(Class {
                        height: below.max().unwrap_or(0).saturating_add(1),
                        entries: key.clone(),
                        uses: 0,
                    });
                    known.insert(key.clone(), class);
                    class
                }
            };
            self.all[class as usize].uses += 1;
            self.of[node] = class;
        }
    }
}

/// What is measured of each segment that grows from another.
struct Measured {
    turns: Vec<Turn>,
    lengths: Vec<f64>,
    radii: Vec<f64>,
    /// None where multiples are not finite.
    usable: Vec<bool>,
}

impl Measured {
    fn new(shape: &Shape, frames: &Frames, alike: Alike) -> Self {
        let count = shape.len();
        let mut measured = Self {
            turns: vec![Turn::default(); count],
            lengths: vec![0.0; count],
            radii: vec![0.0; count],
            usable: vec![false; count],
        };
        for (place, node) in (0..count).zip(0_u32..) {
            let parent = shape.parent[place];
            if parent == NO_PARENT || shape.parent[parent as usize] == NO_PARENT {
                continue;
            }
            let [from, to] = [frames.heading[parent as usize], frames.heading[place]];
            if from == glam::DVec3::ZERO || to == glam::DVec3::ZERO {
                continue;
            }
            let own = frames.frame(parent).inverse() * to;
            let mut turn = Turn::to(own);
            if turn.pitch < alike.apart {
                turn = Turn::default();
            }
            measured.turns[place] = turn;
            let [long, before] = [node, parent].map(|node| shape.step(node).length());
            measured.lengths[place] = (long / before).ln();
            let [thick, thicker] = [place, parent as usize].map(|node| shape.radius[node]);
            measured.radii[place] = match alike.one_radius {
                true => 0.0,
                false => (thick / thicker).ln(),
            };
            let multiples = [measured.lengths[place], measured.radii[place]];
            measured.usable[place] = multiples.iter().all(|one| one.is_finite());
        }
        measured
    }

    /// Numbers that are alike put together, and the entries in them.
    fn grouped(
        &mut self,
        shape: &Shape,
        frames: &Frames,
        alike: Alike,
    ) -> (Numbers, Vec<Option<Entry>>) {
        let places: Vec<usize> = (0..shape.len()).filter(|at| self.usable[*at]).collect();
        let weight =
            |place: usize| shape.point[place].distance(shape.point[shape.parent[place] as usize]);
        let of = |value: &dyn Fn(usize) -> f64, apart: f64| {
            let samples: Vec<Sample> = places
                .iter()
                .map(|at| Sample {
                    value: value(*at),
                    weight: weight(*at),
                })
                .collect();
            groups(&samples, apart)
        };
        let apart = alike.apart.to_degrees();
        // The angle at which the circle is cut is none that is likely.
        let cut = |angle: f64| {
            let degrees = wrapped(angle).to_degrees();
            if degrees < -179.0 {
                degrees + 360.0
            } else {
                degrees
            }
        };
        let (pitch_of, pitches) = of(&|at| self.turns[at].pitch.to_degrees(), apart);
        let (length_of, lengths) = of(&|at| self.lengths[at], alike.apart);
        let (radius_of, radii) = of(&|at| self.radii[at], alike.apart);
        let (roll_of, rolls) = of(&|at| cut(self.turns[at].roll), apart);
        let degrees = |all: Vec<f64>| -> Vec<f64> {
            let short = |one| shortest(one, apart * ROUNDED);
            all.into_iter().map(short).collect()
        };
        let multiples = |all: Vec<f64>| -> Vec<f64> {
            let short = |one: f64| shortest(one.exp(), one.exp() * alike.apart * ROUNDED);
            all.into_iter().map(short).collect()
        };
        let mut numbers = Numbers {
            rolls: degrees(rolls),
            pitches: degrees(pitches),
            lengths: multiples(lengths),
            radii: multiples(radii),
        };
        let mut entries = vec![None; shape.len()];
        let mut own_rolls = Vec::new();
        for (at, place) in places.iter().enumerate() {
            let mut entry = Entry {
                turn_roll: roll_of[at],
                pitch: pitch_of[at],
                length: length_of[at],
                radius: radius_of[at],
                roll: Roll::Any,
                class: NONE,
            };
            match frames.up[*place] {
                None => {}
                Some(_) if frames.is_level[*place] => entry.roll = Roll::Level,
                Some(up) => {
                    // From where the very turn leads, which is not yet rounded.
                    let parent = frames.frame(shape.parent[*place]);
                    let turned = parent * self.turns[*place].rotation();
                    let ahead = frame(frames.heading[*place], turned * glam::DVec3::Z);
                    own_rolls.push((
                        *place,
                        Sample {
                            value: cut(roll_to(ahead, up)),
                            weight: shape.reach[*place],
                        },
                    ));
                }
            }
            entries[*place] = Some(entry);
        }
        let samples: Vec<Sample> = own_rolls.iter().map(|(_, sample)| *sample).collect();
        let (of, rolls) = groups(&samples, apart);
        let before = u32::try_from(numbers.rolls.len()).unwrap_or(NONE);
        numbers.rolls.extend(degrees(rolls));
        for ((place, _), group) in own_rolls.iter().zip(of) {
            if let Some(entry) = &mut entries[*place] {
                entry.roll = Roll::By(before + group);
            }
        }
        (numbers, entries)
    }
}
