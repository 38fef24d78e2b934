//! `assets/sessions/first-tree.session`: what it holds, and the puppet that made it.
//!
//! The session is made by rule, not recorded, so that everybody sees where it comes from and the
//! file can be made anew when the stage changes: `UPDATE_SNAPSHOTS=1 cargo test --test first_tree`. Hands move as
//! hands do (eased, on arcs, with a pause before each press), and every place where something is
//! made lies on a whole millimetre of the sketch: far from where rounding to the document's 0.1 mm
//! could go one way on one headset and the other way on another.

#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    reason = "a test that fails shows the line; numbers are small"
)]

mod person;

use std::path::PathBuf;

use glam::{Quat, Vec2, Vec3};
use person::serve;
use ramus::{
    sketch::{Letter, NodeRef, predict_segments_within},
    world::{
        World,
        document::{Document, Placement},
        hands::HandParams,
        history::{Action, History},
        input::{self, HandInput, Input},
        scene::Scene,
        stage::{Palette, stage_from_sketch},
    },
};
use ramus_xr::{Fov, Frame, Hand, Pose, View, session};

const LEFT: usize = 0;
const RIGHT: usize = 1;
/// Frames a second.
const RATE: f64 = 72.0;

/// The trunk's nodes, metres in the sketch: a gentle S that ends about as it begins, so that its repeats stay upright.
const TRUNK: [Vec3; 4] = [
    Vec3::new(-0.016, 0.270, 0.008),
    Vec3::new(0.010, 0.540, 0.018),
    Vec3::new(0.022, 0.805, 0.000),
    Vec3::new(0.004, 1.070, -0.012),
];
/// The branch, drawn from the trunk's first node: out to the left, away from the board, then up to the light. It carries copies of itself at
/// each of its nodes too.
const BRANCH: [Vec3; 3] = [
    Vec3::new(-0.136, 0.450, 0.048),
    Vec3::new(-0.225, 0.650, 0.075),
    Vec3::new(-0.280, 0.870, 0.085),
];
/// Where the trunk's apex is moved to at last.
const MOVED: Vec3 = Vec3::new(0.018, 1.085, 0.008);
/// Where the head is while the tree grows, and what it looks at.
const BACK: Vec3 = Vec3::new(0.0, 1.6, 0.9);
const OVERVIEW: Vec3 = Vec3::new(0.36, 1.46, -1.4);
/// Growth steps.
const STEPS: u32 = 10;
/// Half the simulated headset's field of view, radians: narrower than a real one's, so that its pictures are not stretched.
const HALF_FIELD: f32 = 0.68;

/// Something on its way from one value to another.
#[derive(Clone, Copy)]
struct Way<T> {
    from: T,
    to: T,
    start: f64,
    seconds: f64,
}

impl<T: Copy> Way<T> {
    fn resting(at: T) -> Self {
        Self {
            from: at,
            to: at,
            start: 0.0,
            seconds: 0.0,
        }
    }

    /// 0 to 1, with neither speed nor acceleration at the ends: how an arm moves (Flash and Hogan 1985).
    fn part(&self, time: f64) -> f32 {
        if self.seconds <= 0.0 {
            return 1.0;
        }
        let t = ((time - self.start) / self.seconds).clamp(0.0, 1.0);
        (t * t * t * (10.0 + t * (6.0 * t - 15.0))) as f32
    }
}

/// Where a hand's tip is and where it points.
#[derive(Clone, Copy)]
struct Held {
    tip: Vec3,
    direction: Vec3,
}

/// Where the head is and what it looks at.
#[derive(Clone, Copy)]
struct Look {
    eye: Vec3,
    at: Vec3,
}

/// Moves a head and two hands and notes every frame.
struct Puppet {
    frames: Vec<Frame>,
    hands: [Way<Held>; 2],
    head: Way<Look>,
    /// Triggers, squeezes, sticks and face buttons.
    now: [Hand; 2],
}

fn rounded(value: f32, steps: f32) -> f32 {
    // Adding 0 makes a negative zero a positive one.
    (value * steps).round() / steps + 0.0
}

fn rounded_turn(turn: Quat) -> Quat {
    Quat::from_array(turn.to_array().map(|value| rounded(value, 1e4)))
}

/// The pose that has its tip there, in numbers that are short to write.
fn pose_of(held: Held) -> Pose {
    let orientation = rounded_turn(Quat::from_rotation_arc(
        Vec3::NEG_Z,
        held.direction.normalize(),
    ));
    let ahead = orientation.normalize() * Vec3::NEG_Z * HandParams::default().tip;
    let position = (held.tip - ahead)
        .to_array()
        .map(|value| rounded(value, 1e6));
    Pose {
        orientation,
        position: Vec3::from_array(position),
    }
}

fn pose_of_head(look: Look) -> Pose {
    let ahead = (look.at - look.eye).normalize();
    let yaw = (-ahead.x).atan2(-ahead.z);
    let pitch = ahead.y.asin();
    Pose {
        orientation: rounded_turn(Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch)),
        position: Vec3::from_array(look.eye.to_array().map(|value| rounded(value, 1e4))),
    }
}

impl Puppet {
    fn new() -> Self {
        let rest = |x: f32| Held {
            tip: Vec3::new(x, 0.95, -0.1),
            direction: Vec3::new(0.0, -0.45, -1.0),
        };
        let start = Look {
            eye: Vec3::new(0.0, 1.6, 0.12),
            at: Vec3::new(0.0, 1.2, -1.0),
        };
        Self {
            frames: Vec::new(),
            hands: [Way::resting(rest(-0.26)), Way::resting(rest(0.26))],
            head: Way::resting(start),
            now: [Hand {
                tracked: true,
                ..Hand::ABSENT
            }; 2],
        }
    }

    fn time(&self) -> f64 {
        self.frames.len() as f64 / RATE
    }

    fn held(&self, hand: usize, time: f64) -> Held {
        let way = self.hands[hand];
        let part = way.part(time);
        // A way of some length bends towards the person, as an arm's does.
        let bend = part * (1.0 - part) * way.from.tip.distance(way.to.tip);
        Held {
            tip: way.from.tip.lerp(way.to.tip, part) + Vec3::new(0.0, 0.1, 0.35) * bend,
            direction: way
                .from
                .direction
                .normalize()
                .lerp(way.to.direction.normalize(), part),
        }
    }

    fn frame(&mut self) {
        let time = self.time();
        let part = self.head.part(time);
        let (from, to) = (self.head.from, self.head.to);
        let head = pose_of_head(Look {
            eye: from.eye.lerp(to.eye, part),
            at: from.at.lerp(to.at, part),
        });
        let mut frame = Frame {
            time: rounded_time(time),
            head,
            hands: self.now,
            ..Frame::start()
        };
        frame.views = Frame::eyes().map(|eye| View {
            pose: head * eye.pose,
            fov: Fov {
                left: -HALF_FIELD,
                right: HALF_FIELD,
                up: HALF_FIELD,
                down: -HALF_FIELD,
            },
        });
        for (hand, shown) in frame.hands.iter_mut().enumerate() {
            let pose = pose_of(self.held(hand, time));
            (shown.aim, shown.grip) = (pose, pose);
        }
        self.frames.push(frame);
    }

    fn wait(&mut self, seconds: f64) {
        for _ in 0..(seconds * RATE).round() as usize {
            self.frame();
        }
    }

    /// Sends a hand on its way; it arrives while others act.
    fn send(&mut self, hand: usize, tip: Vec3, direction: Vec3, seconds: f64) {
        let from = self.held(hand, self.time());
        self.hands[hand] = Way {
            from,
            to: Held { tip, direction },
            start: self.time(),
            seconds,
        };
    }

    /// Moves a hand and waits until it is there and still.
    fn go(&mut self, hand: usize, tip: Vec3, direction: Vec3, seconds: f64) {
        self.send(hand, tip, direction, seconds);
        self.wait(seconds + 0.08);
    }

    fn look(&mut self, eye: Vec3, at: Vec3, seconds: f64) {
        let part = self.head.part(self.time());
        let Look {
            eye: from_eye,
            at: from_at,
        } = self.head.from;
        let from = Look {
            eye: from_eye.lerp(self.head.to.eye, part),
            at: from_at.lerp(self.head.to.at, part),
        };
        self.head = Way {
            from,
            to: Look { eye, at },
            start: self.time(),
            seconds,
        };
    }

    /// A finger's pull or its letting go, in 0.08 s.
    fn squeeze(&mut self, finger: fn(&mut Hand) -> &mut f32, hand: usize, to: f32) {
        let from = *finger(&mut self.now[hand]);
        for n in 1..=6_u8 {
            *finger(&mut self.now[hand]) = rounded(from + (to - from) * f32::from(n) / 6.0, 100.0);
            self.frame();
        }
    }

    fn pull(&mut self, hand: usize) {
        let trigger: fn(&mut Hand) -> &mut f32 = |hand| &mut hand.trigger;
        self.squeeze(trigger, hand, 1.0);
        self.wait(0.06);
        self.squeeze(trigger, hand, 0.0);
        self.wait(0.05);
    }

    fn press_lower(&mut self, hand: usize) {
        self.now[hand].lower = true;
        self.wait(0.11);
        self.now[hand].lower = false;
        self.wait(0.76);
    }

    fn flick(&mut self, hand: usize, to: f32) {
        for x in [0.3, 0.8, 1.0, 1.0, 1.0, 0.6, 0.2, 0.0] {
            self.now[hand].stick = Vec2::new(x * to + 0.0, 0.0);
            self.frame();
        }
        self.wait(0.75);
    }
}

/// Microseconds are enough, and short to write.
fn rounded_time(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}

/// The whole session.
fn perform() -> Vec<Frame> {
    let stage = stage_from_sketch(&Placement::default());
    let on_stage = |place: Vec3| stage.transform_point3(place);
    let ahead = Vec3::new(-0.18, -0.1, -1.0);
    let rest = |x: f32| (Vec3::new(x, 0.95, 0.0), Vec3::new(0.0, -0.4, -1.0));
    let mut puppet = Puppet::new();

    // The right hand draws the trunk, node by node, upwards.
    puppet.wait(0.4);
    puppet.look(Vec3::new(0.0, 1.58, 0.1), Vec3::new(0.0, 1.08, -0.6), 0.9);
    for place in TRUNK {
        puppet.go(RIGHT, on_stage(place), ahead, 0.55);
        puppet.pull(RIGHT);
    }
    // It points at the first node from a little way off and draws the branch there.
    puppet.look(Vec3::new(0.04, 1.58, 0.1), Vec3::new(0.06, 1.1, -0.6), 0.8);
    let from = on_stage(Vec3::new(0.7, 0.53, 1.0));
    let fork = on_stage(TRUNK[0]);
    puppet.go(RIGHT, from, fork - from, 0.7);
    puppet.pull(RIGHT);
    for place in BRANCH {
        puppet.go(RIGHT, on_stage(place), ahead, 0.5);
        puppet.pull(RIGHT);
    }

    // A step back, so that the platform, the tree behind it and the board are in view; both thumbs let it grow.
    puppet.look(BACK, OVERVIEW, 0.9);
    let (tip, direction) = rest(0.3);
    puppet.send(LEFT, Vec3::new(-0.3, tip.y, tip.z), direction, 0.9);
    puppet.go(RIGHT, tip, direction, 0.9);
    for step in 0..STEPS {
        puppet.press_lower(if step % 3 == 2 { LEFT } else { RIGHT });
    }
    puppet.flick(RIGHT, -1.0);
    puppet.flick(RIGHT, 1.0);

    // The left hand takes the trunk's end and puts it a little aside.
    let mirrored = Vec3::new(-ahead.x, ahead.y, ahead.z);
    puppet.go(LEFT, on_stage(TRUNK[3]), mirrored, 0.7);
    let grip: fn(&mut Hand) -> &mut f32 = |hand| &mut hand.squeeze;
    puppet.squeeze(grip, LEFT, 1.0);
    puppet.go(LEFT, on_stage(MOVED), mirrored, 0.5);
    puppet.squeeze(grip, LEFT, 0.0);
    puppet.wait(0.1);

    // Both hands rest.
    puppet.go(LEFT, Vec3::new(-0.3, tip.y, tip.z), direction, 0.7);
    puppet.wait(0.3);
    puppet.frames
}

fn file() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/sessions/first-tree.session")
}

fn input(frame: &Frame) -> Input {
    let pose = |pose: Pose| input::Pose {
        orientation: pose.orientation,
        position: pose.position,
    };
    Input {
        time: frame.time,
        focused: frame.focused,
        head: pose(frame.head),
        hands: frame.hands.map(|hand| HandInput {
            tracked: hand.tracked,
            aim: pose(hand.aim),
            grip: pose(hand.grip),
            trigger: hand.trigger,
            squeeze: hand.squeeze,
            stick: hand.stick,
            lower: hand.lower,
            upper: hand.upper,
        }),
    }
}

#[test]
fn the_file_is_what_the_puppet_does() {
    let made = session::to_bytes(&perform()).unwrap();
    if std::env::var_os("UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(file(), &made).unwrap();
    }
    let kept = std::fs::read(file()).unwrap();
    assert!(
        kept == made,
        "make it anew: UPDATE_SNAPSHOTS=1 cargo test --test first_tree"
    );
}

#[test]
fn it_draws_a_trunk_and_a_branch_and_lets_them_grow() {
    let frames = session::read_file(&file()).unwrap();
    let seconds = frames.last().unwrap().time;
    assert!((12.0..=22.0).contains(&seconds), "{seconds} s");
    let mut world = World::new(History::default());
    let mut largest = 0;
    for frame in &frames {
        world.update(&input(frame));
        serve(&mut world);
        largest = largest.max(world.document().step);
    }
    let mut scene = Scene::default();
    world.scene(&mut scene);
    let ghosts = scene
        .balls
        .iter()
        .filter(|ball| ball.color == Palette::default().ghost);
    assert_eq!(
        (ghosts.count(), scene.controllers.len()),
        (0, 2),
        "hands at rest are about to draw nothing"
    );
    let Document {
        sketch,
        step,
        platform,
        ..
    } = world.document();
    let trunk = [TRUNK[0], TRUNK[1], TRUNK[2], MOVED];
    assert_eq!(
        sketch.stroke(Letter::TRUNK).unwrap().points,
        trunk,
        "to the bit"
    );
    let branch = sketch.strokes.get(1).unwrap();
    assert_eq!(branch.attachment, Some(NodeRef::new(Letter::TRUNK, 1)));
    assert_eq!(
        branch.points,
        BRANCH.map(|place| ramus::sketch::point(place - TRUNK[0]))
    );
    assert_eq!((sketch.strokes.len(), *step, largest), (2, STEPS, STEPS));
    assert_eq!(*platform, Placement::default());
    assert_eq!(
        predict_segments_within(sketch, 7, 100),
        Some(33),
        "spec/sketch.md: n = 1 gives 33 segments at w6"
    );
    let actions = world.take_edits();
    let is = |wanted: &Action| actions.iter().filter(|action| *action == wanted).count();
    assert_eq!((is(&Action::Undo), is(&Action::Redo)), (1, 1));
    let used = |hand: usize| {
        frames
            .iter()
            .any(|frame| frame.hands[hand].trigger + frame.hands[hand].squeeze > 0.6)
    };
    assert!(used(LEFT) && used(RIGHT));
}

/// A headset that reports every pose a hundredth of a millimetre and a hundredth of a degree off makes the same document.
#[test]
fn a_slightly_different_headset_makes_the_same() {
    let frames = session::read_file(&file()).unwrap();
    let kept = |nudge: f32| {
        let inputs = frames.iter().map(|frame| {
            let mut input = input(frame);
            for hand in &mut input.hands {
                for pose in [&mut hand.aim, &mut hand.grip] {
                    pose.position += Vec3::new(nudge, -nudge, nudge) * 4e-6;
                    pose.orientation = Quat::from_rotation_y(nudge * 2e-5) * pose.orientation;
                }
            }
            input
        });
        person::replay(inputs)
    };
    assert_eq!(kept(0.0), kept(1.0));
    assert_eq!(kept(0.0), kept(-1.0));
}

/// Where a view shows a point: −1 to 1 from left to right and from the bottom to the top.
fn in_view(view: &View, point: Vec3) -> Vec2 {
    let at = view.pose.orientation.conjugate() * (point - view.pose.position);
    assert!(at.z < -0.1, "{point} is not before the eye");
    Vec2::new(at.x, at.y) / (-at.z * HALF_FIELD.tan())
}

/// From the step back on, the board, the platform's top and the tree are whole in both eyes, and the board hides nothing of
/// either.
#[test]
fn everything_is_in_the_pictures_and_the_board_hides_none_of_it() {
    let frames = session::read_file(&file()).unwrap();
    let first = frames
        .iter()
        .position(|frame| frame.hands.iter().any(|hand| hand.lower));
    let mut world = World::new(History::default());
    let mut scene = Scene::default();
    let mut largest = 0;
    for (number, frame) in frames.iter().enumerate() {
        world.update(&input(frame));
        serve(&mut world);
        if Some(number) < first || number % 10 != 0 && number + 1 != frames.len() {
            continue;
        }
        world.scene(&mut scene);
        let board = scene.board.as_ref().unwrap();
        let half = Vec2::from(board.size) * 0.5;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| {
            board
                .world_from_board
                .transform_point3(Vec3::new(x * half.x, y * half.y, 0.0))
        });
        let rim = (0..12_u8).map(|hour| {
            let angle = f32::from(hour) * std::f32::consts::TAU / 12.0;
            scene.plates[1].world_from_plate.transform_point3(Vec3::new(
                angle.cos(),
                0.0,
                angle.sin(),
            ))
        });
        let seen: Vec<Vec3> = scene
            .tree
            .iter()
            .flat_map(|placed| {
                let place = |&point: &Vec3| placed.world_from_tree.transform_point3(point);
                placed.tree.position.iter().map(place)
            })
            .chain(scene.balls.iter().map(|ball| ball.center))
            .chain(rim)
            .collect();
        largest = largest.max(seen.len());
        for view in &frame.views {
            let corners = corners.map(|corner| in_view(view, corner));
            for corner in corners {
                assert!(
                    corner.abs().max_element() < 0.99,
                    "frame {number}: the board's corner is at {corner}"
                );
            }
            for point in seen.iter().map(|&point| in_view(view, point)) {
                assert!(point.abs().max_element() < 0.99, "frame {number}: {point}");
                let inside = (0..4).all(|side| {
                    let edge = corners[(side + 1) % 4] - corners[side];
                    edge.perp_dot(point - corners[side]) > 0.0
                });
                assert!(
                    !inside,
                    "frame {number}: the board hides or is hidden at {point}"
                );
            }
        }
    }
    assert!(largest > 150, "{largest} points were looked at");
}
