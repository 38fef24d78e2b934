//! What is drawn where: the tree from its root on, each segment aimed from where the turtle really is, so that rounded numbers do not add up; and a part
//! that has a production left to it, if all of it comes out near enough.

use std::f64::consts::PI;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DQuat, DVec3};

use super::classes::{Classes, NONE, Roll};
use super::error::ExactError;
use super::frames::{Turn, levelled, roll_to};
use super::number::{shortest, thickness};
use super::shape::Shape;

/// Segments that productions are tried on, for each segment of the tree: what bounds the time where many almost fit.
const TRIED_PER_SEGMENT: usize = 16;
/// Nodes between two looks at whether it was stopped.
const LOOK_EVERY: usize = 1 << 12;
/// The turtle's width before the first `!`, a diameter.
const FIRST_WIDTH: f64 = 0.1;

/// How far what is drawn may be from the shape's nodes, lengths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Room {
    /// Of numbers that are rounded.
    pub(super) rounding: f64,
    /// Of a part that a production draws.
    pub(super) part: f64,
    /// Of radii.
    pub(super) radius: f64,
    /// Of a root's radius.
    pub(super) root: f64,
}

/// What the axiom is made of; angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Word {
    Push,
    Pop,
    Width(f64),
    /// Without drawing: `+` by `yaw`, `&` by `pitch`, then on.
    Move {
        yaw: f64,
        pitch: f64,
        length: f64,
    },
    Segment {
        yaw: f64,
        pitch: f64,
        length: f64,
    },
    /// A part: where its first segment leads, how it is rolled (by `$` or `/`), its class, and that segment's length and width.
    Part {
        turn: [f64; 2],
        level: bool,
        roll: f64,
        class: u32,
        length: f64,
        width: f64,
    },
}

/// A way to draw a shape.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    pub(super) words: Vec<Word>,
    /// The shape's nodes in the order in which they are drawn; a root that is given its own radius comes twice.
    pub(super) drawn: Vec<u32>,
}

/// Where the turtle is.
#[derive(Clone, Copy)]
struct At {
    place: DVec3,
    frame: DQuat,
    width: f64,
}

impl At {
    const START: Self = Self {
        place: DVec3::ZERO,
        frame: DQuat::IDENTITY,
        width: FIRST_WIDTH,
    };

    /// After `/` and `&`.
    fn turned(self, roll: f64, pitch: f64) -> Self {
        let turn = Turn {
            roll: roll.to_radians(),
            pitch: pitch.to_radians(),
        };
        self.by(turn.rotation())
    }

    /// After `+` and `&`: what stays in a plane needs the first alone.
    fn steered(self, yaw: f64, pitch: f64) -> Self {
        let yawed = DQuat::from_rotation_z(yaw.to_radians());
        self.by(yawed * DQuat::from_rotation_x(-pitch.to_radians()))
    }

    fn by(self, rotation: DQuat) -> Self {
        Self {
            frame: (self.frame * rotation).normalize(),
            ..self
        }
    }

    fn ahead(self, length: f64) -> Self {
        Self {
            place: self.place + self.frame * DVec3::Y * length,
            ..self
        }
    }

    /// The turn and length that lead to a place, with numbers so short that what is `reach` away is no farther off than `within`.
    fn aim(self, to: DVec3, reach: f64, within: f64) -> (f64, f64, f64) {
        let away = to - self.place;
        let length = away.length();
        let part = within / 3.0;
        if length <= f64::EPSILON {
            return (0.0, 0.0, 0.0);
        }
        let own = self.frame.inverse() * away / length;
        let degrees = |angle: f64, arm: f64| {
            let within = (part / arm.max(f64::MIN_POSITIVE)).to_degrees();
            shortest(angle.to_degrees(), within.min(90.0))
        };
        let pitch = degrees(-own.z.clamp(-1.0, 1.0).asin(), reach);
        let level = own.x.hypot(own.y);
        let yaw = degrees((-own.x).atan2(own.y), reach * level);
        let along = away.dot(self.steered(yaw, pitch).frame * DVec3::Y);
        (
            yaw,
            pitch,
            shortest(along, part * (length / reach).min(1.0)),
        )
    }
}

/// What plans are made of.
pub(super) struct Planner<'a> {
    pub(super) shape: &'a Shape,
    pub(super) classes: Option<&'a Classes>,
    pub(super) room: Room,
    /// The width of all, where one does.
    pub(super) one_width: Option<f64>,
}

enum Work {
    Node(u32, bool),
    Pop,
}

impl Planner<'_> {
    /// A plan that leaves to productions what `has_production` says of classes.
    pub(super) fn plan(
        &self,
        has_production: &dyn Fn(u32) -> bool,
        cancel: &AtomicBool,
    ) -> Result<Plan, ExactError> {
        let mut plan = Plan::default();
        let mut tries = TRIED_PER_SEGMENT.saturating_mul(self.shape.len());
        let roots: Vec<u32> = self.shape.roots().collect();
        let mut start = At::START;
        if let Some(width) = self.one_width {
            start.width = width;
            plan.words.push(Word::Width(width));
        }
        for (place, root) in roots.iter().enumerate() {
            let alone = place + 1 == roots.len();
            plan.words.extend((!alone).then_some(Word::Push));
            let at = self.root(*root, start, &mut plan);
            self.branches(*root, at, has_production, &mut tries, &mut plan, cancel)?;
            plan.words.extend((!alone).then_some(Word::Pop));
        }
        Ok(plan)
    }

    /// Goes to a root, and gives it its radius where the first segment has another.
    fn root(&self, root: u32, mut at: At, plan: &mut Plan) -> At {
        let place = root as usize;
        let is_first = plan.drawn.is_empty();
        if is_first {
            plan.drawn.push(root);
        } else {
            let to = self.shape.point[place];
            let (yaw, pitch, length) = at.aim(to, to.length(), self.room.rounding);
            at = at.steered(yaw, pitch).ahead(length);
            plan.words.push(Word::Move { yaw, pitch, length });
            plan.drawn.push(root);
        }
        let own = self.shape.radius[place];
        // Behind a move the first segment makes the root, and each bracket would make another.
        let as_first = match self.shape.children(root) {
            [first, rest @ ..] => {
                let thick = self.shape.radius[*first as usize];
                (is_first || rest.is_empty()) && (thick - own).abs() <= self.room.root
            }
            [] => false,
        };
        if !as_first {
            self.widen(own, &mut at, plan);
            plan.words.push(Word::Segment {
                yaw: 0.0,
                pitch: 0.0,
                length: 0.0,
            });
            plan.drawn.push(root);
        }
        at
    }

    /// Sets the width where it is not near enough.
    fn widen(&self, radius: f64, at: &mut At, plan: &mut Plan) {
        if self.one_width.is_none() && (at.width / 2.0 - radius).abs() > self.room.radius {
            at.width = self.width(radius);
            plan.words.push(Word::Width(at.width));
        }
    }

    fn width(&self, radius: f64) -> f64 {
        self.one_width
            .unwrap_or_else(|| thickness(2.0 * radius, self.room.radius))
    }

    /// All that grows from a root.
    fn branches(
        &self,
        root: u32,
        mut at: At,
        has_production: &dyn Fn(u32) -> bool,
        tries: &mut usize,
        plan: &mut Plan,
        cancel: &AtomicBool,
    ) -> Result<(), ExactError> {
        let mut saved = Vec::new();
        let mut work = Vec::new();
        self.open(root, &mut work);
        while let Some(next) = work.pop() {
            let (node, bracketed) = match next {
                Work::Pop => {
                    at = saved.pop().unwrap_or(at);
                    plan.words.push(Word::Pop);
                    continue;
                }
                Work::Node(node, bracketed) => (node, bracketed),
            };
            if plan.drawn.len().is_multiple_of(LOOK_EVERY) && cancel.load(Ordering::Relaxed) {
                return Err(ExactError::Cancelled);
            }
            if bracketed {
                saved.push(at);
                work.push(Work::Pop);
                plan.words.push(Word::Push);
            }
            let class = self
                .classes
                .map_or(NONE, |classes| classes.of[node as usize]);
            if class != NONE && has_production(class) && self.part(node, class, at, tries, plan) {
                plan.drawn.extend(node..self.shape.end[node as usize]);
                continue;
            }
            self.widen(self.shape.radius[node as usize], &mut at, plan);
            let to = self.shape.point[node as usize];
            let reach = to.distance(at.place);
            let (yaw, pitch, length) = at.aim(to, reach, self.room.rounding);
            at = at.steered(yaw, pitch).ahead(length);
            plan.words.push(Word::Segment { yaw, pitch, length });
            plan.drawn.push(node);
            self.open(node, &mut work);
        }
        Ok(())
    }

    /// Puts a node's branches where the next one to draw is last.
    fn open(&self, node: u32, work: &mut Vec<Work>) {
        let children = self.shape.children(node);
        let last = children.len().saturating_sub(1);
        let all = children.iter().enumerate().rev();
        work.extend(all.map(|(place, child)| Work::Node(*child, place < last)));
    }

    /// Leaves a part to its production, if that comes near enough.
    fn part(&self, node: u32, class: u32, at: At, tries: &mut usize, plan: &mut Plan) -> bool {
        let Some(classes) = self.classes else {
            return false;
        };
        let place = node as usize;
        let to = self.shape.point[place];
        let reach = to.distance(at.place) + self.shape.reach[place];
        let fine = self.room.part / 8.0;
        let (yaw, pitch, length) = at.aim(to, reach, fine);
        if length <= 0.0 {
            return false;
        }
        let mut ahead = at.steered(yaw, pitch);
        let mut own_roll = 0.0;
        let level = classes.frames.is_level[place];
        if level {
            ahead.frame = levelled(ahead.frame);
        } else if let Some(up) = classes.frames.up[place] {
            let by = roll_to(ahead.frame, up).to_degrees();
            let short = (fine / self.shape.reach[place].max(f64::MIN_POSITIVE)).min(PI);
            own_roll = shortest(by, short.to_degrees());
            ahead.frame *= DQuat::from_rotation_y(own_roll.to_radians());
        }
        let width = match self.one_width {
            Some(width) => width,
            None => thickness(2.0 * self.shape.radius[place], self.room.radius / 4.0),
        };
        ahead.width = width;
        if !self.comes_near(node, class, ahead, length, classes, tries) {
            return false;
        }
        plan.words.push(Word::Part {
            turn: [yaw, pitch],
            level,
            roll: own_roll,
            class,
            length,
            width,
        });
        true
    }

    /// Whether all that a class's production draws from here is near the shape.
    fn comes_near(
        &self,
        node: u32,
        class: u32,
        at: At,
        length: f64,
        classes: &Classes,
        tries: &mut usize,
    ) -> bool {
        let numbers = &classes.numbers;
        let mut open = vec![(node, class, at, length)];
        while let Some((node, class, at, length)) = open.pop() {
            if *tries == 0 {
                return false;
            }
            *tries -= 1;
            let place = node as usize;
            let here = at.ahead(length);
            let off = here.place.distance(self.shape.point[place]);
            let radius = (at.width / 2.0 - self.shape.radius[place]).abs();
            if !(off <= self.room.part && (self.one_width.is_some() || radius <= self.room.radius))
            {
                return false;
            }
            let entries = &classes.all[class as usize].entries;
            for (entry, child) in entries.iter().zip(self.shape.children(node)) {
                let (roll, pitch) = (
                    numbers.rolls[entry.turn_roll as usize],
                    numbers.pitches[entry.pitch as usize],
                );
                let mut ahead = here.turned(roll, pitch);
                match entry.roll {
                    Roll::Any => {}
                    Roll::Level => ahead.frame = levelled(ahead.frame),
                    Roll::By(by) => {
                        ahead.frame *=
                            DQuat::from_rotation_y(numbers.rolls[by as usize].to_radians())
                    }
                }
                if self.one_width.is_none() {
                    ahead.width *= numbers.radii[entry.radius as usize];
                }
                let length = length * numbers.lengths[entry.length as usize];
                open.push((*child, entry.class, ahead, length));
            }
        }
        true
    }
}
