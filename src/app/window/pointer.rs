//! Mouse and keyboard as the right hand of a headset, and as what moves the eye.
//!
//! Pure: [`Act`]s in, a [`Hand`] a frame out. Tools see edges of buttons with the pose of that very frame, and a mouse can do more
//! between two frames than one frame can say: so acts wait in a queue, and a frame takes either all movements up to the next
//! button or one button. A button's frame therefore has the cursor of the frame before it, for which it is
//! known what lies under it ([`Facts`]).
//!
//! The hand is on the cursor's ray. Where a node or a panel lies there, the hand points from the eye itself, so that it means just what
//! the eye sees; else its tip lies in a plane through the selected node, upright and across the line of sight (level
//! where the eye looks down steeply, or across an axis while its key is held): there the trigger draws. What the grip holds
//! moves in the plane where it was taken.

use std::collections::VecDeque;

use glam::{Vec2, Vec3};
use ramus_xr::{Hand, Pose};

use super::camera::{Camera, Ray, pointing};
use crate::ui::sheet::{LONGEST, SCROLL_POINTS};
use crate::world::Met;
use crate::world::hands::HandParams;

/// Something that mouse or keyboard did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act {
    /// The cursor is here, pixels from the left upper corner.
    Moved(Vec2),
    /// The wheel, notches; away from the person is positive.
    Wheel(f32),
    /// A button went down or up.
    Button(Button, bool),
    /// A drag moves the eye, or no longer.
    Drag(Option<Drag>),
    /// A key of an axis: the plane across it, or the usual one again.
    Across(Option<Axis>),
    /// A tap that a controller's button stands for.
    Tap(Tap),
    /// The window has the keyboard or not.
    Focus(bool),
    /// Another eye.
    Look(Camera),
}

/// A button that is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Draws, chooses, presses.
    Trigger,
    /// Grips.
    Squeeze,
}

/// How a drag moves the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drag {
    /// Round the focus.
    Orbit,
    /// With the focus.
    Pan,
}

/// An axis of the stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// To the right.
    X,
    /// Up.
    Y,
    /// Towards the person.
    Z,
}

/// A short press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tap {
    /// One step on.
    Grow,
    /// One step back.
    Back,
    /// Takes the last action back.
    Undo,
    /// Does it again.
    Redo,
}

/// What the pointer is told of the stage after each frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facts {
    /// The selected node, metres on the stage.
    pub selected: Option<Vec3>,
    /// What lies under the cursor.
    pub met: Option<Met>,
    /// The left hand's stick undoes and redoes: the right one's turns the person.
    pub left_undoes: bool,
}

/// A plane on the stage.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plane {
    through: Vec3,
    /// Unit vector.
    normal: Vec3,
}

impl Plane {
    /// Where a ray meets it, before the eye and not absurdly far.
    fn meet(&self, ray: &Ray) -> Option<Vec3> {
        let along = (self.through - ray.origin).dot(self.normal) / ray.direction.dot(self.normal);
        // A ray beside the plane gives ±∞ or NaN, which fails here.
        (along > NEAREST && along < FARTHEST).then(|| ray.at(along))
    }
}

/// Nearest and farthest place to draw from the eye, metres.
const NEAREST: f32 = 0.07;
const FARTHEST: f32 = 30.0;

/// Looking down by more than this the usual plane is level: the sine of 55°.
const STEEP: f32 = 0.82;

/// Points that a panel scrolls for a notch of the wheel: three lines of text, as on desktops.
const NOTCH_POINTS: f32 = 54.0;

/// Most points that still wait to be scrolled: a wheel that was spun does not run on for long.
const MOST_POINTS: f32 = 600.0;

/// Where the hand itself is, from its tip, metres: out of sight, since it would hide what it works at.
const GRIP_FROM_TIP: Vec3 = Vec3::new(0.0, 50.0, 0.0);

/// What the grip holds: its plane, and how far it is from where the cursor's ray met that.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Holding {
    plane: Plane,
    offset: Vec3,
}

/// Most acts that wait; movements and taps beyond are dropped, which takes a person many seconds of stalled frames.
const MOST_WAITING: usize = 512;

/// Mouse and keyboard between frames.
#[derive(Clone, Debug)]
pub struct Pointer {
    /// The eye that drags move.
    pub camera: Camera,
    waiting: VecDeque<Act>,
    cursor: Vec2,
    focused: bool,
    trigger: bool,
    squeeze: bool,
    drag: Option<Drag>,
    across: Option<Axis>,
    /// What the last frame tapped; the next one shows it released.
    tap: Option<Tap>,
    /// Points that still wait to be scrolled.
    scroll: f32,
    /// How far the stick is pushed for it in this frame.
    pushed: f32,
    holding: Option<Holding>,
}

impl Pointer {
    /// Nothing pressed, the cursor in the middle of a window of so many pixels.
    #[must_use]
    pub fn new(camera: Camera, size_px: Vec2) -> Self {
        Self {
            camera,
            waiting: VecDeque::with_capacity(MOST_WAITING),
            cursor: size_px * 0.5,
            focused: true,
            trigger: false,
            squeeze: false,
            drag: None,
            across: None,
            tap: None,
            scroll: 0.0,
            pushed: 0.0,
            holding: None,
        }
    }

    /// Takes an act in its turn.
    pub fn take(&mut self, act: Act) {
        let full = self.waiting.len() >= MOST_WAITING;
        match (self.waiting.back_mut(), act) {
            (Some(Act::Moved(last)), Act::Moved(to)) => *last = to,
            (Some(Act::Wheel(sum)), Act::Wheel(more)) => *sum += more,
            // A button that came up must never be missed.
            (_, Act::Button(..) | Act::Drag(_) | Act::Across(_) | Act::Focus(_)) => {
                self.waiting.push_back(act);
            }
            _ if !full => self.waiting.push_back(act),
            _ => {}
        }
    }

    /// Whether the next frame will say something new.
    #[must_use]
    pub fn is_busy(&self) -> bool {
        !self.waiting.is_empty() || self.tap.is_some() || self.scroll != 0.0
    }

    /// Whether something is held, so that the picture may move by itself.
    #[must_use]
    pub fn is_holding(&self) -> bool {
        self.squeeze
    }

    /// Whether the window has the keyboard.
    #[must_use]
    pub fn is_focused(&self) -> bool {
        self.focused
    }

    /// The ray under the cursor.
    #[must_use]
    pub fn ray(&self, size_px: Vec2) -> Ray {
        self.camera.ray(self.cursor, size_px)
    }

    /// The right hand in the next frame, which comes so many seconds after the last one.
    pub fn step(&mut self, seconds: f64, size_px: Vec2, facts: &Facts) -> Hand {
        let rests = self.tap.take().is_some();
        self.go_on_scrolling(seconds, facts);
        let mut moved = false;
        while let Some(&act) = self.waiting.front() {
            if Self::is_press(&act) {
                // A press waits for the frame that knows what is under the cursor, and until the last tap was released.
                if !moved && !rests && self.pushed == 0.0 {
                    self.waiting.pop_front();
                    return self.press(act, size_px, facts);
                }
                break;
            }
            self.waiting.pop_front();
            self.move_by(act, size_px, facts);
            moved = true;
        }
        self.hand(size_px, facts, false)
    }

    /// The left hand in that frame: its stick alone, far away from everything, and only where that undoes.
    #[must_use]
    pub fn left(&self, facts: &Facts) -> Hand {
        if !self.focused || !facts.left_undoes {
            return Hand::ABSENT;
        }
        let away = Pose {
            orientation: pointing(Vec3::Y),
            position: GRIP_FROM_TIP,
        };
        Hand {
            tracked: true,
            aim: away,
            grip: away,
            stick: Vec2::new(self.flick(), 0.0),
            ..Hand::ABSENT
        }
    }

    /// Pushes the stick as far as the rest of a notch wants it in a frame of so many seconds.
    fn go_on_scrolling(&mut self, seconds: f64, facts: &Facts) {
        if !facts.met.is_some_and(|met| met.scrolls) {
            self.scroll = 0.0;
        }
        #[expect(clippy::cast_possible_truncation, reason = "a frame's seconds")]
        let most = SCROLL_POINTS * seconds.clamp(0.0, LONGEST) as f32;
        let points = self.scroll.clamp(-most, most);
        self.scroll -= points;
        self.pushed = if points == 0.0 { 0.0 } else { points / most };
    }

    /// Whether an act wants a frame of its own.
    fn is_press(act: &Act) -> bool {
        match act {
            Act::Button(..) | Act::Tap(_) | Act::Focus(_) => true,
            Act::Wheel(_) | Act::Moved(_) | Act::Drag(_) | Act::Across(_) | Act::Look(_) => false,
        }
    }

    fn move_by(&mut self, act: Act, size_px: Vec2, facts: &Facts) {
        match act {
            Act::Moved(to) => {
                let by = to - self.cursor;
                self.cursor = to;
                match self.drag {
                    Some(Drag::Orbit) => self.camera.orbit(by, size_px.y),
                    Some(Drag::Pan) => self.camera.pan(by, size_px.y),
                    None => {}
                }
            }
            Act::Wheel(notches) if facts.met.is_some_and(|met| met.scrolls) => {
                let points = self.scroll + notches * NOTCH_POINTS;
                self.scroll = points.clamp(-MOST_POINTS, MOST_POINTS);
            }
            Act::Wheel(notches) => self.camera.zoom(notches),
            Act::Drag(drag) => self.drag = drag,
            Act::Across(axis) => self.across = axis,
            Act::Look(camera) => self.camera = camera,
            Act::Button(..) | Act::Tap(_) | Act::Focus(_) => {}
        }
    }

    fn press(&mut self, act: Act, size_px: Vec2, facts: &Facts) -> Hand {
        let held_before = self.holding.is_some();
        match act {
            Act::Button(Button::Trigger, down) => self.trigger = down,
            Act::Button(Button::Squeeze, down) => {
                self.squeeze = down;
                if down {
                    self.grip(size_px, facts);
                }
            }
            Act::Tap(tap) => self.tap = Some(tap),
            Act::Focus(focused) => {
                self.focused = focused;
                // What was down is up by the time the window hears of keys and buttons again.
                (self.trigger, self.squeeze) = (false, false);
                (self.drag, self.across, self.holding) = (None, None, None);
            }
            Act::Wheel(_) | Act::Moved(_) | Act::Drag(_) | Act::Across(_) | Act::Look(_) => {}
        }
        let grips = self.holding.is_some() && !held_before;
        let hand = self.hand(size_px, facts, grips);
        if !self.squeeze {
            // The frame that lets go still has the pose of what was held.
            self.holding = None;
        }
        hand
    }

    fn grip(&mut self, size_px: Vec2, facts: &Facts) {
        let Some(met) = facts.met else { return };
        let plane = Plane {
            through: met.place,
            ..self.plane(met.place)
        };
        let point = plane.meet(&self.ray(size_px)).unwrap_or(met.place);
        self.holding = Some(Holding {
            plane,
            offset: met.place - point,
        });
    }

    /// The plane to draw in, through a point.
    fn plane(&self, through: Vec3) -> Plane {
        let forward = self.camera.forward();
        let normal = match self.across {
            Some(Axis::X) => Vec3::X,
            Some(Axis::Y) => Vec3::Y,
            Some(Axis::Z) => Vec3::Z,
            None if forward.y < -STEEP => Vec3::Y,
            None => Vec3::new(forward.x, 0.0, forward.z).normalize_or(Vec3::Z),
        };
        Plane { through, normal }
    }

    /// Where the hand works.
    fn point(&self, ray: &Ray, facts: &Facts) -> Vec3 {
        if let Some(Holding { plane, offset }) = &self.holding
            && let Some(point) = plane.meet(ray)
        {
            return point + offset;
        }
        let through = facts.selected.unwrap_or_else(|| ray.at(1.0));
        let plane = self.plane(through);
        plane.meet(ray).unwrap_or_else(|| {
            // The plane is seen from its edge: as far as the selected node is.
            ray.at((through - ray.origin).dot(ray.direction).max(NEAREST))
        })
    }

    /// The stick to its sides.
    fn flick(&self) -> f32 {
        match self.tap {
            Some(Tap::Undo) => -1.0,
            Some(Tap::Redo) => 1.0,
            _ => 0.0,
        }
    }

    /// The hand as it is now; `grips`: in this frame it takes what is under the cursor.
    fn hand(&self, size_px: Vec2, facts: &Facts, grips: bool) -> Hand {
        if !self.focused {
            return Hand::ABSENT;
        }
        let ray = self.ray(size_px);
        let point = self.point(&ray, facts);
        let uses = facts.met.is_some_and(|met| met.takes_trigger) && self.holding.is_none();
        let tip = HandParams::default().tip;
        let aim = Pose {
            orientation: pointing(ray.direction),
            position: if grips || uses {
                ray.origin
            } else {
                point - ray.direction * tip
            },
        };
        let full = |down: bool| if down { 1.0 } else { 0.0 };
        let flick = if facts.left_undoes { 0.0 } else { self.flick() };
        Hand {
            tracked: true,
            aim,
            grip: Pose {
                position: point + GRIP_FROM_TIP,
                ..Pose::IDENTITY
            },
            trigger: full(self.trigger),
            squeeze: full(self.squeeze),
            stick: Vec2::new(flick, self.pushed),
            lower: self.tap == Some(Tap::Grow),
            upper: self.tap == Some(Tap::Back),
        }
    }
}

#[cfg(test)]
mod tests;
