//! A person in front of the stage, for tests: moves hands, presses buttons, one frame at a time.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "shared by test binaries that use parts of it; a test that fails shows the line"
)]

use std::sync::atomic::AtomicBool;

use glam::{Quat, Vec3};
use ramus::{
    sketch::{self, Letter, NodeRef},
    world::{
        Haptic, World,
        document::Document,
        hands::HandParams,
        history::History,
        input::{HandInput, Input, Pose},
        project,
        scene::Scene,
        stage::stage_from_sketch,
    },
};

pub const LEFT: usize = 0;
pub const RIGHT: usize = 1;

/// A controller's button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    Trigger,
    Squeeze,
    Lower,
    Upper,
}

pub struct Person {
    pub world: World,
    pub input: Input,
    /// The vibrations of the last frame.
    pub haptics: Vec<Haptic>,
    /// Every frame so far.
    pub frames: Vec<Input>,
}

pub fn resting(hand: usize) -> HandInput {
    let x = if hand == LEFT { -0.25 } else { 0.25 };
    HandInput::at(Pose {
        orientation: Quat::IDENTITY,
        position: Vec3::new(x, 0.4, 0.3),
    })
}

pub fn start() -> Input {
    Input {
        time: 0.0,
        focused: true,
        head: Pose {
            orientation: Quat::IDENTITY,
            position: Vec3::new(0.0, 1.6, 0.0),
        },
        hands: [resting(LEFT), resting(RIGHT)],
    }
}

/// Lets the application's part happen: every tree that is wished for is grown at once.
pub fn serve(world: &mut World) {
    while let Some(request) = world.tree_request() {
        let grown = sketch::grow(&request.sketch, request.step, &AtomicBool::new(false));
        world.set_tree(request.id, grown.map_err(|error| error.to_string()));
    }
}

/// The project file after these frames, from an empty document.
pub fn replay(frames: impl IntoIterator<Item = Input>) -> Vec<u8> {
    let mut world = World::new(History::default());
    for frame in frames {
        world.update(&frame);
    }
    project::to_bytes(world.document())
}

impl Person {
    pub fn new() -> Self {
        Self::with(Document::default())
    }

    pub fn with(document: Document) -> Self {
        let mut person = Self {
            world: World::new(History::new(document)),
            input: start(),
            haptics: Vec::new(),
            frames: Vec::new(),
        };
        person.frame();
        person
    }

    /// One frame of 1/72 s.
    pub fn frame(&mut self) {
        self.input.time += 1.0 / 72.0;
        self.frames.push(self.input);
        self.haptics.clear();
        self.haptics
            .extend_from_slice(self.world.update(&self.input));
        serve(&mut self.world);
    }

    /// Frames that last so many seconds or a little longer.
    pub fn wait(&mut self, seconds: f64) {
        let end = self.input.time + seconds;
        while self.input.time < end {
            self.frame();
        }
    }

    /// Holds the controller with its tip at a place of the stage, pointing along `direction`.
    pub fn aim(&mut self, hand: usize, tip: Vec3, direction: Vec3) {
        let orientation = Quat::from_rotation_arc(Vec3::NEG_Z, direction.normalize());
        let position = tip - orientation * Vec3::NEG_Z * HandParams::default().tip;
        let pose = Pose {
            orientation,
            position,
        };
        self.input.hands[hand].aim = pose;
        self.input.hands[hand].grip = pose;
    }

    /// Brings the tip to a place of the stage, pointing up and ahead, in one frame.
    pub fn reach(&mut self, hand: usize, tip: Vec3) {
        self.aim(hand, tip, Vec3::new(0.0, 0.2, -1.0));
        self.frame();
    }

    /// Points at a place of the stage from 0.6 m in front of it, in one frame.
    pub fn point(&mut self, hand: usize, at: Vec3) {
        let tip = at + Vec3::new(0.05, 0.1, 0.5);
        self.aim(hand, tip, at - tip);
        self.frame();
    }

    pub fn set(&mut self, hand: usize, button: Button, down: bool) {
        let value = if down { 1.0 } else { 0.0 };
        let hand = &mut self.input.hands[hand];
        match button {
            Button::Trigger => hand.trigger = value,
            Button::Squeeze => hand.squeeze = value,
            Button::Lower => hand.lower = down,
            Button::Upper => hand.upper = down,
        }
    }

    pub fn press(&mut self, hand: usize, button: Button) {
        self.set(hand, button, true);
        self.frame();
    }

    pub fn release(&mut self, hand: usize, button: Button) {
        self.set(hand, button, false);
        self.frame();
    }

    pub fn click(&mut self, hand: usize, button: Button) {
        self.press(hand, button);
        self.release(hand, button);
    }

    /// Flicks the stick and lets it go.
    pub fn flick(&mut self, hand: usize, x: f32) {
        self.input.hands[hand].stick.x = x;
        self.frame();
        self.input.hands[hand].stick.x = 0.0;
        self.frame();
    }

    /// A place of the sketch on the stage.
    pub fn on_stage(&self, in_sketch: Vec3) -> Vec3 {
        stage_from_sketch(&self.world.document().platform).transform_point3(in_sketch)
    }

    /// A node's place on the stage.
    pub fn node(&self, letter: Letter, node: u32) -> Vec3 {
        self.on_stage(self.in_sketch(letter, node))
    }

    pub fn in_sketch(&self, letter: Letter, node: u32) -> Vec3 {
        self.world
            .document()
            .sketch
            .position(NodeRef::new(letter, node))
            .unwrap()
    }

    /// Draws segments to places of the sketch, then takes the hand away.
    pub fn draw(&mut self, hand: usize, places: &[Vec3]) {
        for &place in places {
            let tip = self.on_stage(place);
            self.reach(hand, tip);
            self.click(hand, Button::Trigger);
        }
        self.rest(hand);
    }

    /// The hand goes down, its buttons free.
    pub fn rest(&mut self, hand: usize) {
        self.input.hands[hand] = resting(hand);
        self.frame();
    }

    pub fn bytes(&self) -> Vec<u8> {
        project::to_bytes(self.world.document())
    }

    pub fn scene(&self) -> Scene {
        let mut scene = Scene::default();
        self.world.scene(&mut scene);
        scene
    }

    pub fn message(&self) -> Option<String> {
        self.scene().board.unwrap().content.message.clone()
    }

    /// Strongest vibration of a hand in the last frame.
    pub fn felt(&self, hand: usize) -> f32 {
        self.haptics
            .iter()
            .filter(|haptic| haptic.hand == hand)
            .map(|haptic| haptic.seconds)
            .fold(0.0, f32::max)
    }
}
