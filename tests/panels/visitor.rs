//! Somebody in the workshop, frame by frame: points at panels, presses, and is told what hands felt.

use glam::{Affine3A, Quat, Vec2, Vec3};
use ramus::{
    app::workshop::Workshop,
    world::{
        World, document::Document, hands::HandParams, history::History, panels::PanelId,
        scene::Scene,
    },
};
use ramus_xr::{Frame, Hand, Pose, Pulse};

pub(crate) const LEFT: usize = 0;
pub(crate) const RIGHT: usize = 1;

pub(crate) struct Visitor {
    pub(crate) workshop: Workshop,
    pub(crate) frame: Frame,
    pub(crate) frames: Vec<Frame>,
    pub(crate) felt: Vec<Pulse>,
}

fn resting(hand: usize) -> Hand {
    let x = if hand == LEFT { -0.25 } else { 0.25 };
    let pose = Pose {
        position: Vec3::new(x, 0.4, 0.4),
        ..Pose::IDENTITY
    };
    Hand {
        tracked: true,
        aim: pose,
        grip: pose,
        ..Hand::ABSENT
    }
}

impl Visitor {
    /// Nobody has done anything yet, not even come in.
    pub(crate) fn blank() -> Self {
        Self::coming(Workshop::unsaved(World::new(History::default())).unwrap())
    }

    /// In a workshop of one's own.
    pub(crate) fn at(workshop: Workshop) -> Self {
        let mut visitor = Self::coming(workshop);
        visitor.frame();
        visitor.frame();
        visitor
    }

    fn coming(mut workshop: Workshop) -> Self {
        workshop.keep_texts();
        Self {
            workshop,
            frame: Frame {
                hands: [resting(LEFT), resting(RIGHT)],
                ..Frame::start()
            },
            frames: Vec::new(),
            felt: Vec::new(),
        }
    }

    pub(crate) fn new() -> Self {
        Self::at(Workshop::unsaved(World::new(History::default())).unwrap())
    }

    /// With a trunk of two segments and a branch.
    pub(crate) fn with_tree() -> Self {
        let mut visitor = Self::new();
        visitor.draw_tree();
        visitor
    }

    pub(crate) fn draw_tree(&mut self) {
        let visitor = self;
        let root = Vec3::new(0.0, 0.9, -0.55);
        for tip in [Vec3::Y * 0.08, Vec3::new(0.01, 0.16, 0.0)] {
            visitor.tip_to(RIGHT, root + tip);
            visitor.pull(RIGHT, true);
            visitor.pull(RIGHT, false);
        }
        visitor.tip_to(RIGHT, root + Vec3::Y * 0.08);
        visitor.pull(RIGHT, true);
        visitor.pull(RIGHT, false);
        visitor.tip_to(RIGHT, root + Vec3::new(0.07, 0.12, 0.02));
        visitor.pull(RIGHT, true);
        visitor.pull(RIGHT, false);
        visitor.frame.hands[RIGHT] = resting(RIGHT);
        visitor.frame();
        assert_eq!(visitor.document().sketch.strokes.len(), 2);
    }

    pub(crate) fn document(&self) -> &Document {
        self.workshop.document()
    }

    pub(crate) fn frame(&mut self) {
        self.frame.time += 1.0 / 90.0;
        self.frames.push(self.frame);
        let felt = self.workshop.update(&self.frame).to_vec();
        self.felt.extend(felt);
        self.workshop.finish_tree();
        self.workshop.finish_planted();
    }

    pub(crate) fn place(&mut self, id: PanelId) -> (Affine3A, Vec2) {
        let scene: &Scene = self.workshop.scene();
        let panel = scene
            .panels
            .iter()
            .find(|panel| panel.slot == id.slot())
            .unwrap();
        (panel.world_from_panel, Vec2::from(panel.size))
    }

    pub(crate) fn normal(&mut self, id: PanelId) -> Vec3 {
        self.place(id).0.matrix3.z_axis.into()
    }

    pub(crate) fn center(&mut self, id: PanelId) -> Vec3 {
        self.place(id).0.translation.into()
    }

    /// A place on a panel (metres right of and below its upper left corner) in the stage.
    pub(crate) fn on(&mut self, id: PanelId, at: Vec2) -> Vec3 {
        let (place, size) = self.place(id);
        let from_middle = at - size * 0.5;
        place.transform_point3(Vec3::new(from_middle.x, -from_middle.y, 0.0))
    }

    /// Points a hand from where it is.
    pub(crate) fn point(&mut self, hand: usize, to: Vec3) {
        let held = &mut self.frame.hands[hand];
        let direction = (to - held.aim.position).normalize();
        held.aim.orientation = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
        held.grip.orientation = held.aim.orientation;
    }

    pub(crate) fn point_on(&mut self, hand: usize, id: PanelId, at: Vec2) {
        // From before the panel, so that nothing else is in the way.
        let normal = self.normal(id);
        let to = self.on(id, at);
        let held = &mut self.frame.hands[hand];
        held.aim.position = to + normal * 0.3 + Vec3::new(0.0, 0.05, 0.0);
        held.grip.position = held.aim.position;
        self.point(hand, to);
    }

    pub(crate) fn tip_to(&mut self, hand: usize, tip: Vec3) {
        self.tip_to_along(hand, tip, Vec3::NEG_Z);
    }

    pub(crate) fn tip_to_along(&mut self, hand: usize, tip: Vec3, direction: Vec3) {
        let held = &mut self.frame.hands[hand];
        held.aim.orientation = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
        held.aim.position = tip - direction * HandParams::default().tip;
        held.grip = held.aim;
        self.frame();
    }

    /// Pulls the trigger or lets it go, and lets two frames pass.
    pub(crate) fn pull(&mut self, hand: usize, pulled: bool) {
        self.frame.hands[hand].trigger = if pulled { 1.0 } else { 0.0 };
        self.frame();
        self.frame();
    }

    /// Closes the hand or opens it.
    pub(crate) fn grip(&mut self, hand: usize, closed: bool) {
        self.frame.hands[hand].squeeze = if closed { 1.0 } else { 0.0 };
        self.frame();
        self.frame();
    }

    /// Lets the hand hang.
    pub(crate) fn rest(&mut self, hand: usize) {
        self.frame.hands[hand] = resting(hand);
    }

    pub(crate) fn find(&self, id: PanelId, text: &str) -> Vec2 {
        self.find_nth(id, text, 1)
    }

    fn find_nth(&self, id: PanelId, text: &str, nth: usize) -> Vec2 {
        let found = self.workshop.find_text(id, text, nth);
        found.unwrap_or_else(|| panic!("no {text} on {id:?}"))
    }

    /// Whether a text that begins so stands on a panel.
    pub(crate) fn says(&self, id: PanelId, beginning: &str) -> bool {
        self.workshop
            .texts(id)
            .any(|text| text.starts_with(beginning))
    }

    pub(crate) fn wait(&mut self, seconds: f64) {
        let end = self.frame.time + seconds;
        while self.frame.time < end {
            self.frame();
        }
    }

    pub(crate) fn click(&mut self, hand: usize, id: PanelId, text: &str) {
        self.click_nth(hand, id, text, 1);
    }

    /// Scrolls a panel by the stick, down and then up, until a text is seen on it.
    pub(crate) fn scroll_to(&mut self, hand: usize, id: PanelId, text: &str) {
        let resting = self.frame.hands[hand];
        for stick in [-1.0, 1.0] {
            for _ in 0..600 {
                if self.workshop.find_text(id, text, 1).is_some() {
                    self.frame.hands[hand] = resting;
                    return self.frame();
                }
                let (_, size) = self.place(id);
                self.point_on(hand, id, size * 0.5);
                self.frame.hands[hand].stick.y = stick;
                self.frame();
            }
        }
        panic!("no {text} on {id:?}, however far it is scrolled");
    }

    pub(crate) fn click_nth(&mut self, hand: usize, id: PanelId, text: &str, nth: usize) {
        let at = self.find_nth(id, text, nth);
        let resting = self.frame.hands[hand];
        self.point_on(hand, id, at);
        self.frame();
        self.pull(hand, true);
        self.pull(hand, false);
        self.frame.hands[hand] = resting;
        self.frame();
    }
}
