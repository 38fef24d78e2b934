//! The things on the platform that hands turn: the lever, the wheel and the stump.
//!
//! They stand around the platform and go with it. The *lever* shows the divergence angle as it lies around the
//! trunk, and turns it, live, with snaps at the angles that plants are known for. The *wheel* turns growth forward and back,
//! without jumps. The *stump* clears the sketch, when it is asked twice. Trigger and grip do the same here.
//!
//! A turn is measured about the handle's own axis from where the hand took it, so taking it changes nothing. What took
//! it, the tip or the ray, measures it until it is let go: where one took over from the other, it would jump.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec3};

use super::{
    document::{Document, Edit, Placement},
    hands::{Sample, wrapped},
    history::History,
    hover::{self, Pointer},
    scene::{Ball, Color, Plate, Rod, Scene},
    tools::{Hold, Hover, Tools},
};

/// A thing to turn or press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandleId {
    /// The divergence angle.
    Lever,
    /// Growth.
    Wheel,
    /// Clears the sketch.
    Stump,
}

impl HandleId {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Lever, Self::Wheel, Self::Stump];
}

/// What the line beside a handle says; `ui` has the words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Says {
    /// The divergence angle, degrees.
    Divergence(f64),
    /// How far the tree has grown, steps.
    Moment(f64),
    /// What the stump does.
    Clear,
    /// The stump was pulled once and asks for the second time.
    ClearAgain,
    /// The name of a model's endpoint.
    End {
        /// The model's number.
        model: usize,
        /// The endpoint's.
        at: usize,
    },
    /// What is known of a branch of a model's centerlines.
    Branch {
        /// The model's number.
        model: usize,
        /// The branch's.
        branch: usize,
    },
}

/// Sizes and ways of the handles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandleParams {
    /// Where each stands in the platform's frame (its top's centre, turned with it, not scaled), metres, as [`HandleId::ALL`].
    pub places: [Vec3; 3],
    /// Radius of the dials, metres.
    pub radius: f32,
    /// Radius of the knobs, metres.
    pub knob: f32,
    /// Radius and height of the stump, metres.
    pub stump: [f32; 2],
    /// The angles at which the lever snaps, degrees.
    pub snaps_deg: [f64; 4],
    /// How near it must come to snap, degrees.
    pub snap_within_deg: f64,
    /// How far the wheel turns in a step, radians.
    pub step_turn: f32,
    /// For how long the stump waits for the second pull, seconds.
    pub patience: f64,
    /// How high the line of text stands above a handle, metres.
    pub label: f32,
}

impl Default for HandleParams {
    fn default() -> Self {
        Self {
            // Below the rim and before it, so that neither the rim nor the sketch is in a hand's way.
            places: [
                Vec3::new(0.24, -0.06, 0.27),
                Vec3::new(-0.24, -0.06, 0.27),
                Vec3::new(0.0, -0.06, 0.36),
            ],
            radius: 0.06,
            knob: 0.014,
            stump: [0.032, 0.05],
            snaps_deg: [crate::sketch::GOLDEN_DEG, 180.0, 120.0, 90.0],
            snap_within_deg: 3.0,
            step_turn: TAU / 6.0,
            patience: 4.0,
            label: 0.09,
        }
    }
}

/// How a hand holds a handle.
#[derive(Clone, Copy, Debug, Default)]
struct Grasp {
    /// Where the hand was about the axis in the last frame, radians.
    angle: f32,
    /// The tip measures it, not the ray.
    by_tip: bool,
    /// The grip holds it, not the trigger.
    by_grip: bool,
}

/// What the handles remember between frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Handles {
    /// Of each hand that holds one.
    grasps: [Grasp; 2],
    /// The lever's angle before snapping, degrees.
    lever_deg: f64,
    /// How far the tree has grown, steps, while a hand has the wheel.
    pub(super) moment: f64,
    /// Whether the lever lies in a snap.
    snapped: bool,
    /// How long the stump still waits for its second pull, seconds.
    waiting: f64,
    /// The wheel moved the moment in this frame.
    pub(super) moved: bool,
}

/// Where a handle stands.
fn place(id: HandleId, platform: &Placement, params: &HandleParams) -> Vec3 {
    platform.position + Quat::from_rotation_y(platform.yaw()) * params.places[id as usize]
}

/// The direction of an angle on a dial, from above counted against the clock, as branches follow each other.
fn on_dial(angle: f32, platform: &Placement) -> Vec3 {
    Quat::from_rotation_y(platform.yaw() + angle) * Vec3::Z
}

/// Where the knob of a handle is.
fn knob(id: HandleId, document: &Document, moment: f64, params: &HandleParams) -> Vec3 {
    let center = place(id, &document.platform, params);
    #[expect(clippy::cast_possible_truncation, reason = "angles on a dial")]
    let angle = match id {
        HandleId::Lever => document.sketch.divergence_deg.to_radians() as f32,
        HandleId::Wheel => (moment.rem_euclid(6.0) as f32) * params.step_turn,
        HandleId::Stump => return center + Vec3::Y * (params.stump[1] * 0.5),
    };
    center + on_dial(angle, &document.platform) * params.radius + Vec3::Y * params.knob
}

impl Tools {
    /// The handle that a hand is at, and metres along its ray.
    pub(super) fn handle_at(&self, pointer: &Pointer) -> Option<(HandleId, f32)> {
        let params = &self.params.handles;
        let knobs = HandleId::ALL.map(|id| self.knob(id));
        let hit = hover::ball(knobs.into_iter(), params.knob, pointer, &self.params.hover)?;
        let id = *HandleId::ALL.get(hit.index)?;
        let taken = self.hands.iter().any(|hand| hand.hold == Hold::Handle(id));
        (!taken).then_some((id, hit.along))
    }

    fn knob(&self, id: HandleId) -> Vec3 {
        knob(id, &self.shown, self.handles.moment, &self.params.handles)
    }

    /// Takes the lever or the wheel, or presses the stump, by the trigger or by the grip.
    pub(super) fn take_handle(
        &mut self,
        hand: usize,
        id: HandleId,
        by_grip: bool,
        history: &mut History,
    ) {
        if id == HandleId::Stump {
            return self.press_stump(hand, history);
        }
        self.hands[hand].hold = Hold::Handle(id);
        self.handles.lever_deg = self.shown.sketch.divergence_deg;
        let by_tip = self.is_in_reach(id, hand);
        self.handles.grasps[hand] = Grasp {
            angle: self.angle_about(id, hand, by_tip).unwrap_or(0.0),
            by_tip,
            by_grip,
        };
        self.pulse(hand, self.params.haptics.choose);
    }

    /// Trigger or grip come up: a handle is let go by what took it.
    pub(super) fn let_go_of_handle(&mut self, hand: usize, by_grip: bool, history: &mut History) {
        let held = matches!(self.hands[hand].hold, Hold::Handle(_));
        if held && self.handles.grasps[hand].by_grip == by_grip {
            self.release(hand, history);
        }
    }

    fn press_stump(&mut self, hand: usize, history: &mut History) {
        if history.committed().sketch.is_empty() {
            return self.refuse(hand, "There is nothing to clear.".into());
        }
        if self.handles.waiting > 0.0 {
            self.handles.waiting = 0.0;
            // A step that is still tried out would come back over the empty sketch.
            self.settle(history);
            self.apply(hand, Edit::Clear, self.params.haptics.delete, history);
            return;
        }
        self.handles.waiting = self.params.handles.patience;
        self.pulse(hand, self.params.haptics.limit);
    }

    /// Lets the stump's patience run out.
    pub(super) fn wait_at_stump(&mut self, seconds: f64) {
        self.handles.waiting = (self.handles.waiting - seconds).max(0.0);
    }

    fn is_in_reach(&self, id: HandleId, hand: usize) -> bool {
        let center = place(id, &self.shown.platform, &self.params.handles);
        let reach = self.params.handles.radius * 2.0;
        let sample = self.hands[hand].sample;
        sample.is_some_and(|sample| sample.tip.distance(center) <= reach)
    }

    /// The angle about a handle's axis at which a hand's tip is or its ray meets the dial's plane, radians. `None`: straight
    /// at the axis, or away.
    fn angle_about(&self, id: HandleId, hand: usize, by_tip: bool) -> Option<f32> {
        let sample = self.hands[hand].sample?;
        let center = place(id, &self.shown.platform, &self.params.handles);
        let at = match by_tip {
            true => sample.tip,
            false => on_level(&sample, center.y)?,
        };
        let away = at - center;
        (away.x.hypot(away.z) > 1e-3).then(|| away.x.atan2(away.z))
    }

    /// Turns what the hands hold.
    pub(super) fn follow_handles(&mut self, history: &History) {
        self.handles.moved = false;
        for hand in 0..self.hands.len() {
            let Hold::Handle(id) = self.hands[hand].hold else {
                continue;
            };
            let by_tip = self.handles.grasps[hand].by_tip;
            let Some(angle) = self.angle_about(id, hand, by_tip) else {
                continue;
            };
            let before = std::mem::replace(&mut self.handles.grasps[hand].angle, angle);
            let turned = wrapped(angle - before);
            match id {
                HandleId::Lever => self.turn_lever(hand, turned, history),
                HandleId::Wheel => {
                    let steps = f64::from(turned / self.params.handles.step_turn);
                    self.handles.moment = (self.handles.moment + steps).max(0.0);
                    self.handles.moved = turned != 0.0;
                }
                HandleId::Stump => {}
            }
        }
    }

    fn turn_lever(&mut self, hand: usize, turned: f32, history: &History) {
        let params = self.params.handles;
        self.handles.lever_deg =
            (self.handles.lever_deg + f64::from(turned).to_degrees()).rem_euclid(360.0);
        let free = self.handles.lever_deg;
        let near = |snap: &f64| (free - snap).abs() <= params.snap_within_deg;
        let snap = params.snaps_deg.into_iter().find(near);
        if snap.is_some() && !self.handles.snapped {
            self.pulse(hand, self.params.haptics.choose);
        }
        self.handles.snapped = snap.is_some();
        let degrees = snap.unwrap_or(free);
        // An angle within 0…360 is always taken.
        let _ = self.try_out(Edit::SetDivergence { degrees }, history);
    }

    /// What the line beside a handle says, and where the handle is.
    pub(super) fn says(&self) -> Option<(Says, Vec3)> {
        let end = [0, 1].into_iter().find_map(|hand| self.end_meant(hand));
        if let Some((model, at)) = end {
            let above = Vec3::Y * self.params.handles.label * 0.5;
            return Some((Says::End { model, at }, self.end_place(model, at)? + above));
        }
        let branch = [0, 1].into_iter().find_map(|hand| {
            let (model, branch) = self.branch_meant(hand)?;
            Some((Says::Branch { model, branch }, self.branch_place(hand)?))
        });
        if let Some((says, at)) = branch {
            return Some((says, at + Vec3::Y * self.params.handles.label * 0.5));
        }
        let id = self
            .hands
            .iter()
            .find_map(|hand| match (hand.hold, hand.hover) {
                (Hold::Handle(id), _) | (Hold::Nothing, Hover::Handle { id, .. }) => Some(id),
                _ => None,
            })?;
        let says = match id {
            HandleId::Lever => Says::Divergence(self.shown.sketch.divergence_deg),
            HandleId::Wheel => Says::Moment(self.handles.moment),
            HandleId::Stump if self.handles.waiting > 0.0 => Says::ClearAgain,
            HandleId::Stump => Says::Clear,
        };
        let above = Vec3::Y * self.params.handles.label;
        let at = place(id, &self.shown.platform, &self.params.handles) + above;
        Some((says, at))
    }

    /// Describes the handles.
    pub(super) fn draw_handles(&self, scene: &mut Scene) {
        let (params, palette) = (&self.params.handles, &self.palette);
        for id in HandleId::ALL {
            let lit = self.hands.iter().any(|hand| {
                hand.hold == Hold::Handle(id)
                    || matches!(hand.hover, Hover::Handle { id: at, .. } if at == id)
            });
            let color = if lit { palette.hovered } else { palette.node };
            let center = place(id, &self.shown.platform, params);
            if id == HandleId::Stump {
                let [radius, height] = params.stump;
                let color = if lit { palette.hovered } else { palette.stump };
                scene
                    .plates
                    .push(disc(center + Vec3::Y * height, radius, height, color));
                scene.plates.push(disc(
                    center + Vec3::Y * (height + 0.001),
                    radius * 0.8,
                    0.001,
                    palette.stump_top,
                ));
                continue;
            }
            self.draw_dial(id, center, color, scene);
        }
    }

    fn draw_dial(&self, id: HandleId, center: Vec3, color: Color, scene: &mut Scene) {
        let (params, palette, stage) = (&self.params.handles, &self.palette, &self.stage);
        let platform = &self.shown.platform;
        scene
            .plates
            .push(disc(center, params.radius, 0.006, palette.rim));
        let at = self.knob(id);
        scene.rods.push(Rod {
            from: center + Vec3::Y * params.knob,
            to: at,
            radius: stage.line_radius,
            color,
        });
        scene.balls.push(Ball {
            center: at,
            radius: params.knob,
            color,
        });
        #[expect(clippy::cast_possible_truncation, reason = "angles on a dial")]
        let marks = match id {
            HandleId::Lever => params.snaps_deg.map(|degrees| degrees.to_radians() as f32),
            // Six steps go round; four marks of them, the first where step 0 is.
            _ => [0.0, 1.0, 2.0, 3.0].map(|step| step * params.step_turn),
        };
        for (number, angle) in marks.into_iter().enumerate() {
            scene.balls.push(Ball {
                center: center + on_dial(angle, platform) * (params.radius * 0.86),
                radius: params.knob * if number == 0 { 0.36 } else { 0.25 },
                color: palette.letter(0),
            });
        }
    }
}

/// A level disc with its top at a place.
fn disc(top: Vec3, radius: f32, height: f32, color: Color) -> Plate {
    let size = Vec3::new(radius, height, radius);
    Plate {
        world_from_plate: Affine3A::from_scale_rotation_translation(size, Quat::IDENTITY, top),
        color,
    }
}

/// Where a ray meets the level plane at a height.
fn on_level(sample: &Sample, height: f32) -> Option<Vec3> {
    let along = (height - sample.aim.position.y) / sample.direction.y;
    (along > 0.0 && along < 10.0).then(|| sample.aim.position + sample.direction * along)
}
