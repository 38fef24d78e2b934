//! The person in the room: where they stand on the stage, and what helps them there.
//!
//! A headset speaks of the real room. The rig says where that room stands on the stage: it is lifted for people who
//! sit, turned by snaps and set elsewhere by teleport, so the person moves and the stage never does. All of it is
//! off until it is asked for. A snap and a teleport are one jump each, never a ride; with the vignette on the
//! edge of the view is dark for a moment, which calms those whom jumps make sick.
//!
//! With turning on, the left stick (the right one for left-handed people) turns to its sides and, pushed forward,
//! shows a place on the ground, where letting go sets the person. The other stick undoes and redoes as ever.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::{
    input::{HandInput, Input, Pose},
    scene::{Ball, Color, Rod, Scene},
};

/// How finely everything is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Quality {
    /// For headsets that draw by themselves.
    Light,
    /// For a computer.
    #[default]
    Full,
    /// For a fast one, and for pictures.
    High,
}

impl Quality {
    /// All, from the lightest on.
    pub const ALL: [Self; 3] = [Self::Light, Self::Full, Self::High];

    /// Triangles and points of all trees and models together that a frame has at most.
    #[must_use]
    pub fn primitives(self) -> u32 {
        // With what else stands on the stage 750,000, 1.5 million and 4 million.
        match self {
            Self::Light => 650_000,
            Self::Full => 1_400_000,
            Self::High => 3_900_000,
        }
    }

    /// What levels of detail may be off by where that allows it, pixels.
    #[must_use]
    pub fn error_px(self) -> f32 {
        match self {
            Self::Light => 1.5,
            Self::Full => 1.0,
            Self::High => 0.5,
        }
    }
}

/// What a person has set about themselves in the room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RoomSettings {
    /// How far the person is lifted, metres: for those who sit.
    pub lift: f32,
    /// Whether a stick turns and teleports.
    pub turning: bool,
    /// Whether the edge of the view is dark for a moment after a jump.
    pub vignette: bool,
    /// Whether a figure of a grown person stands by the tree.
    pub figure: bool,
    /// Whether the sticks change places.
    pub left_handed: bool,
}

/// Sizes and times of moving about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoomParams {
    /// Least and most lift, metres.
    pub lift: [f32; 2],
    /// A snap turn, radians.
    pub snap: f32,
    /// The stick acts beyond this, and is at rest within the second.
    pub stick: [f32; 2],
    /// How far one can be set from the stage's origin, metres.
    pub farthest: f32,
    /// Speed of the ball that shows where a teleport goes, metres a second: it flies as a ball is thrown.
    pub throw: f32,
    /// Seconds for which the vignette stays after a jump.
    pub dark_seconds: f32,
    /// Where the figure stands, metres, and how tall it is.
    pub figure: (Vec3, f32),
}

impl Default for RoomParams {
    fn default() -> Self {
        Self {
            lift: [-0.5, 1.0],
            snap: TAU / 12.0,
            stick: [0.7, 0.3],
            farthest: 50.0,
            throw: 7.0,
            dark_seconds: 0.35,
            figure: (Vec3::new(1.1, 0.0, -5.6), 1.75),
        }
    }
}

/// What the moving stick is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Stick {
    /// Must be seen at rest first.
    #[default]
    Blocked,
    Rest,
    /// It has turned and waits for its rest.
    Turned,
    /// It is pushed forward.
    Aiming,
}

/// Where the room stands on the stage. See the module.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rig {
    pub(super) settings: RoomSettings,
    params: RoomParams,
    /// About the vertical, radians.
    yaw: f32,
    /// Where the room's origin is, metres; level.
    origin: Vec3,
    stick: Stick,
    /// Where a teleport would go.
    target: Option<Vec3>,
    /// Where the ball is thrown from, and how fast.
    thrown: Option<(Vec3, Vec3)>,
    /// Seconds for which it is still dark.
    dark: f32,
    head: Option<Pose>,
}

impl Rig {
    pub(super) fn new(params: RoomParams) -> Self {
        Self {
            settings: RoomSettings::default(),
            params,
            yaw: 0.0,
            origin: Vec3::ZERO,
            stick: Stick::default(),
            target: None,
            thrown: None,
            dark: 0.0,
            head: None,
        }
    }

    /// Room to stage.
    pub(super) fn stage_from_room(&self) -> Affine3A {
        let [least, most] = self.params.lift;
        let lift = if self.settings.lift.is_finite() {
            self.settings.lift.clamp(least, most)
        } else {
            0.0
        };
        Affine3A::from_rotation_translation(
            Quat::from_rotation_y(self.yaw),
            self.origin + Vec3::Y * lift,
        )
    }

    fn is_home(&self) -> bool {
        self.yaw == 0.0 && self.origin == Vec3::ZERO && self.settings.lift == 0.0
    }

    /// The input as it is on the stage, after this frame's turns and jumps; the moving stick is taken out of it, unless its
    /// hand is on a panel, where it scrolls.
    pub(super) fn follow(&mut self, input: &Input, seconds: f32, on_panel: [bool; 2]) -> Input {
        self.dark = (self.dark - seconds).max(0.0);
        let mut input = *input;
        if self.settings.turning {
            self.travel(&mut input, on_panel);
        } else {
            (self.stick, self.target, self.thrown) = (Stick::Blocked, None, None);
        }
        if !self.is_home() {
            let place = self.stage_from_room();
            input.head = moved(&place, input.head);
            for hand in &mut input.hands {
                hand.aim = moved(&place, hand.aim);
                hand.grip = moved(&place, hand.grip);
            }
        }
        self.head = sound(&input.head).then_some(input.head);
        input
    }

    /// Turns and teleports by the moving hand's stick.
    fn travel(&mut self, input: &mut Input, on_panel: [bool; 2]) {
        let head = input.head;
        let moving = usize::from(self.settings.left_handed);
        if on_panel[moving] {
            (self.stick, self.target, self.thrown) = (Stick::Blocked, None, None);
            return;
        }
        let hand = &mut input.hands[moving];
        let usable = input.focused && hand.tracked && hand.stick.is_finite();
        let stick = std::mem::replace(&mut hand.stick, Vec2::ZERO);
        if !usable || !sound(&head) || !sound(&hand.aim) {
            (self.stick, self.target, self.thrown) = (Stick::Blocked, None, None);
            return;
        }
        let [beyond, rest] = self.params.stick;
        match self.stick {
            _ if stick.length() < rest => {
                if self.stick == Stick::Aiming {
                    self.teleport(&head);
                }
                self.stick = Stick::Rest;
            }
            Stick::Rest if stick.x.abs() > beyond => {
                self.turn(-stick.x.signum() * self.params.snap, &head);
                self.stick = Stick::Turned;
            }
            Stick::Rest if stick.y > beyond => self.stick = Stick::Aiming,
            _ => {}
        }
        self.target = None;
        self.thrown = None;
        if self.stick == Stick::Aiming {
            self.aim(hand);
        }
    }

    /// Turns the person about where they stand.
    fn turn(&mut self, angle: f32, head: &Pose) {
        let before = self.stage_from_room().transform_point3(head.position);
        self.yaw = (self.yaw + angle + PI).rem_euclid(TAU) - PI;
        if self.yaw.abs() < 1e-4 {
            // Twelve snaps are none.
            self.yaw = 0.0;
        }
        let after = self.stage_from_room().transform_point3(head.position);
        self.origin += (before - after).with_y(0.0);
        self.dark = self.params.dark_seconds;
    }

    /// Sets the person where the ball fell.
    fn teleport(&mut self, head: &Pose) {
        let Some(target) = self.target.take() else {
            return;
        };
        let at = self.stage_from_room().transform_point3(head.position);
        self.origin += (target - at).with_y(0.0);
        self.dark = self.params.dark_seconds;
    }

    /// Throws the ball: a parabola down to the ground.
    fn aim(&mut self, hand: &HandInput) {
        const GRAVITY: f32 = 9.81;
        let aim = moved(&self.stage_from_room(), hand.aim);
        let speed = aim.orientation * Vec3::NEG_Z * self.params.throw;
        let height = aim.position.y.max(0.0);
        let seconds = (speed.y + (speed.y * speed.y + 2.0 * GRAVITY * height).sqrt()) / GRAVITY;
        let at = (aim.position + speed * seconds).with_y(0.0);
        let near = at.is_finite() && at.abs().max_element() <= self.params.farthest;
        self.target = near.then_some(at);
        self.thrown = Some((aim.position, speed));
    }

    /// Describes where a teleport goes, the figure, and the dark edge.
    pub(super) fn draw(&self, color: Color, scene: &mut Scene) {
        if let (Some((from, speed)), Some(target)) = (self.thrown, self.target) {
            draw_throw(from, speed, target, color, scene);
        }
        if self.settings.figure {
            let (feet, tall) = self.params.figure;
            draw_figure(feet, tall, scene);
        }
        if self.settings.vignette
            && self.dark > 0.0
            && let Some(head) = self.head
        {
            draw_vignette(&head, scene);
        }
    }
}

fn sound(pose: &Pose) -> bool {
    const FARTHEST: f32 = 100.0;
    // Written so that NaN fails.
    (pose.orientation.length_squared() - 1.0).abs() < 0.01
        && pose.position.abs().max_element() <= FARTHEST
}

fn moved(place: &Affine3A, pose: Pose) -> Pose {
    let (_, turn, _) = place.to_scale_rotation_translation();
    Pose {
        orientation: turn * pose.orientation,
        position: place.transform_point3(pose.position),
    }
}

fn draw_throw(from: Vec3, speed: Vec3, target: Vec3, color: Color, scene: &mut Scene) {
    const PIECES: u8 = 12;
    const FALL: Vec3 = Vec3::new(0.0, -9.81 * 0.5, 0.0);
    let level = speed.with_y(0.0).length().max(1e-3);
    let seconds = (target - from).with_y(0.0).length() / level;
    let at = |piece: u8| {
        let time = seconds * f32::from(piece) / f32::from(PIECES);
        from + speed * time + FALL * (time * time)
    };
    scene.rods.extend((0..PIECES).map(|piece| Rod {
        from: at(piece),
        to: at(piece + 1),
        radius: 0.006,
        color,
    }));
    scene.balls.push(Ball {
        center: target,
        radius: 0.12,
        color,
    });
}

/// A grown person in a few strokes, to be measured by.
fn draw_figure(feet: Vec3, tall: f32, scene: &mut Scene) {
    const COLOR: Color = [0.16, 0.2, 0.24, 1.0];
    // In heights of the figure: from, to, radius.
    const PARTS: [([f32; 3], [f32; 3], f32); 7] = [
        ([-0.06, 0.02, 0.0], [-0.05, 0.48, 0.0], 0.038),
        ([0.06, 0.02, 0.0], [0.05, 0.48, 0.0], 0.038),
        ([0.0, 0.5, 0.0], [0.0, 0.78, 0.0], 0.085),
        ([-0.11, 0.8, 0.0], [0.11, 0.8, 0.0], 0.032),
        ([-0.12, 0.8, 0.0], [-0.15, 0.44, 0.02], 0.026),
        ([0.12, 0.8, 0.0], [0.15, 0.44, 0.02], 0.026),
        ([0.0, 0.8, 0.0], [0.0, 0.88, 0.0], 0.03),
    ];
    let place = |[x, y, z]: [f32; 3]| feet + Vec3::new(x, y, z) * tall;
    for (from, to, radius) in PARTS {
        scene.rods.push(Rod {
            from: place(from),
            to: place(to),
            radius: radius * tall,
            color: COLOR,
        });
        for end in [from, to] {
            scene.balls.push(Ball {
                center: place(end),
                radius: radius * tall,
                color: COLOR,
            });
        }
    }
    scene.balls.push(Ball {
        center: place([0.0, 0.935, 0.0]),
        radius: 0.065 * tall,
        color: COLOR,
    });
}

/// A black ring about the line of sight: what lies more than some 25° aside is dark. Rods and balls that are wholly black are
/// drawn without light.
fn draw_vignette(head: &Pose, scene: &mut Scene) {
    const PIECES: u8 = 64;
    const BLACK: Color = [0.0, 0.0, 0.0, 1.0];
    let at = |piece: u8| {
        let angle = f32::from(piece % PIECES) / f32::from(PIECES) * TAU;
        let aside = Vec3::new(angle.cos() * 0.38, angle.sin() * 0.38, -0.4);
        head.position + head.orientation * aside
    };
    for piece in 0..PIECES {
        scene.rods.push(Rod {
            from: at(piece),
            to: at(piece + 1),
            radius: 0.19,
            color: BLACK,
        });
        scene.balls.push(Ball {
            center: at(piece),
            radius: 0.19,
            color: BLACK,
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;

    fn standing() -> Input {
        let pose = |x: f32, y: f32| Pose {
            orientation: Quat::IDENTITY,
            position: Vec3::new(x, y, 0.3),
        };
        Input {
            time: 0.0,
            focused: true,
            head: pose(0.1, 1.6),
            hands: [
                HandInput::at(pose(-0.2, 1.1)),
                HandInput::at(pose(0.3, 1.1)),
            ],
        }
    }

    fn turning(left_handed: bool) -> Rig {
        let mut rig = Rig::new(RoomParams::default());
        rig.settings = RoomSettings {
            turning: true,
            left_handed,
            vignette: true,
            ..RoomSettings::default()
        };
        rig.follow(&standing(), 0.01, [false; 2]);
        rig
    }

    #[test]
    fn at_home_nothing_is_changed() {
        let mut rig = Rig::new(RoomParams::default());
        assert_eq!(rig.follow(&standing(), 0.01, [false; 2]), standing());
    }

    #[test]
    fn a_flick_turns_once_about_the_head() {
        for left_handed in [false, true] {
            let mut rig = turning(left_handed);
            let hand = usize::from(left_handed);
            let mut input = standing();
            input.hands[hand].stick = Vec2::new(1.0, 0.0);
            input.hands[1 - hand].stick = Vec2::new(-1.0, 0.0);
            let mut last = input;
            for _ in 0..3 {
                last = rig.follow(&input, 0.01, [false; 2]);
            }
            assert!(
                last.head.position.distance(input.head.position) < 1e-5,
                "{last:?}"
            );
            let ahead = last.head.orientation * Vec3::NEG_Z;
            let snap = RoomParams::default().snap;
            assert!((ahead - Vec3::new(snap.sin(), 0.0, -snap.cos())).length() < 1e-5);
            assert_eq!(last.hands[hand].stick, Vec2::ZERO, "taken out");
            assert_eq!(last.hands[1 - hand].stick.x, -1.0, "left in");
            // Back by the other way.
            for x in [0.0, -1.0, 0.0] {
                input.hands[hand].stick.x = x;
                last = rig.follow(&input, 0.01, [false; 2]);
            }
            assert!(last.head.orientation.dot(Quat::IDENTITY).abs() > 0.999_99);
            assert!(last.head.position.distance(input.head.position) < 1e-5);
        }
    }

    #[test]
    fn on_a_panel_the_stick_stays_with_the_hand() {
        let mut rig = turning(false);
        let mut input = standing();
        input.hands[0].stick = Vec2::new(0.0, 1.0);
        assert_eq!(rig.follow(&input, 0.01, [true, false]), input);
        // Off the panel it must be seen at rest first.
        assert_eq!(
            rig.follow(&input, 0.01, [false; 2]).hands[0].stick,
            Vec2::ZERO
        );
        assert!(rig.target.is_none());
    }

    #[test]
    fn a_teleport_sets_the_person_where_the_ball_fell() {
        let mut rig = turning(false);
        let mut input = standing();
        input.hands[0].stick.y = 1.0;
        rig.follow(&input, 0.01, [false; 2]);
        let target = rig.target;
        let mut scene = Scene::default();
        rig.draw([1.0; 4], &mut scene);
        assert!(!scene.rods.is_empty());
        input.hands[0].stick.y = 0.0;
        let there = rig.follow(&input, 0.01, [false; 2]);
        let Some(target) = target else {
            panic!("no target")
        };
        assert!((there.head.position - target).with_y(0.0).length() < 1e-4);
        assert!(
            (there.head.position.y - input.head.position.y).abs() < 1e-6,
            "no rise, no fall"
        );
        scene.rods.clear();
        rig.draw([1.0; 4], &mut scene);
        assert!(!scene.rods.is_empty(), "the edge is dark");
        rig.follow(&input, 1.0, [false; 2]);
        scene.rods.clear();
        rig.draw([1.0; 4], &mut scene);
        assert!(scene.rods.is_empty());
    }

    #[test]
    fn nonsense_moves_nobody() {
        for spoil in [
            |input: &mut Input| input.focused = false,
            |input: &mut Input| input.hands[0].tracked = false,
            |input: &mut Input| input.hands[0].stick.x = f32::NAN,
            |input: &mut Input| input.head.position.y = f32::INFINITY,
            |input: &mut Input| {
                input.hands[0].aim.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)
            },
        ] {
            let mut rig = turning(false);
            let mut input = standing();
            input.hands[0].stick = Vec2::new(1.0, 0.0);
            spoil(&mut input);
            rig.follow(&input, 0.01, [false; 2]);
            assert!(rig.is_home());
        }
        let mut rig = Rig::new(RoomParams::default());
        rig.settings.lift = f32::NAN;
        assert!(rig.stage_from_room().is_finite());
    }
}
