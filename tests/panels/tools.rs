//! What each tool looks like in the hand: strips of stills, of which the guide's page on controls is made.
//!
//! Numbers first: in each still the hand is in sight, and something happened since the one before. Then the guide's own
//! pictures are compared; `UPDATE_SNAPSHOTS=1` draws them anew: look at them before you commit them.

use glam::{Mat3, Quat, Vec2, Vec3};
use image::RgbImage;
use ramus::app::picture::Picture;
use ramus::app::portrait::{self, looking_at};
use ramus::world::{hands::HandParams, panels::PanelId};
use ramus_xr::View;

use super::guide::{compare, far, strip};
use super::visitor::{LEFT, RIGHT, Visitor};

/// Side of a still, pixels.
const SIDE: u32 = 300;

const ROOT: Vec3 = Vec3::new(0.0, 0.9, -0.55);
/// From the right and from below, as an arm comes that draws.
const FROM_THE_RIGHT: Vec3 = Vec3::new(-0.7, 0.35, -0.5);
const FROM_THE_LEFT: Vec3 = Vec3::new(0.7, 0.1, -0.6);

/// A person with a tool, and who takes the pictures.
struct Show<'a> {
    visitor: Visitor,
    picture: &'a mut Picture,
    view: View,
    stills: Vec<RgbImage>,
    /// Whether some still showed where a hand's tip is.
    hand_in_sight: bool,
}

impl<'a> Show<'a> {
    fn new(picture: &'a mut Picture) -> Self {
        Self {
            visitor: Visitor::new(),
            picture,
            view: looking_at(
                Vec3::new(-0.2, 1.22, 0.05),
                ROOT + Vec3::new(0.03, 0.13, 0.0),
                0.7,
            ),
            stills: Vec::new(),
            hand_in_sight: false,
        }
    }

    fn seen_from(&mut self, eye: Vec3, at: Vec3, field: f32) {
        self.view = looking_at(eye, at, field);
    }

    /// Holds the tip at a place above the platform's middle.
    fn reach(&mut self, tip: Vec3) {
        self.hold(RIGHT, ROOT + tip, FROM_THE_RIGHT);
    }

    fn hold(&mut self, hand: usize, tip: Vec3, direction: Vec3) {
        // The grip lies behind where a controller points from, and its handle hangs down.
        let direction = direction.normalize();
        let aim = Quat::from_rotation_arc(Vec3::NEG_Z, direction);
        let held = &mut self.visitor.frame.hands[hand];
        held.aim.orientation = aim;
        held.aim.position = tip - direction * HandParams::default().tip;
        held.grip.orientation = aim * Quat::from_rotation_x(0.6);
        held.grip.position = held.aim.position - direction * 0.06;
        self.visitor.frame();
    }

    fn pull(&mut self, pulled: bool) {
        self.visitor.pull(RIGHT, pulled);
    }

    fn click(&mut self, tip: Vec3) {
        self.reach(tip);
        self.pull(true);
        self.pull(false);
    }

    /// A trunk of three pieces.
    fn trunk(&mut self) {
        for tip in TRUNK {
            self.click(tip);
        }
    }

    /// The trunk and a branch from its first node.
    fn branched(&mut self) {
        self.trunk();
        self.click(TRUNK[0]);
        self.click(BRANCH);
    }

    fn away(&mut self) {
        for hand in [LEFT, RIGHT] {
            self.visitor.rest(hand);
        }
        self.visitor.frame();
    }

    /// Sets something on the bench, as a person does.
    fn set(&mut self, text: &str) {
        self.visitor.click(LEFT, PanelId::Bench, text);
    }

    /// Sets the slider for copies around the trunk to five.
    fn five_around(&mut self) {
        self.visitor
            .point_on(LEFT, PanelId::Bench, Vec2::splat(0.2));
        self.visitor.frame.hands[LEFT].stick.y = -1.0;
        self.visitor.wait(1.0);
        self.visitor.frame.hands[LEFT].stick.y = 0.0;
        self.visitor.frame();
        let row = self
            .visitor
            .find(PanelId::Bench, "branches around the trunk");
        for x in 0..40_u8 {
            let at = row.with_x(0.03 + 0.004 * f32::from(x)) + Vec2::Y * 0.028;
            self.visitor.point_on(LEFT, PanelId::Bench, at);
            self.visitor.frame();
            self.visitor.pull(LEFT, true);
            self.visitor.pull(LEFT, false);
            if self.visitor.workshop.world().settings().symmetry == 5 {
                return;
            }
        }
        panic!("the slider has no five");
    }

    /// Grows by the button, and waits until it is seen.
    fn steps(&mut self, count: u8) {
        for _ in 0..count {
            for pressed in [true, false] {
                self.visitor.frame.hands[RIGHT].lower = pressed;
                self.visitor.frame();
            }
            self.visitor.wait(1.5);
        }
    }

    fn still(&mut self) {
        for (slot, painted) in self.visitor.workshop.take_painted() {
            self.picture.paint(slot, painted).unwrap();
        }
        let scene = self.visitor.workshop.scene();
        self.picture
            .draw_whole(scene, &[self.view; 2], None)
            .unwrap();
        let in_sight = |hand| self.tip(hand).abs().max_element() < 0.9;
        self.hand_in_sight |= [LEFT, RIGHT].into_iter().any(in_sight);
        let [still, _] = self.picture.read(None).unwrap();
        self.stills
            .push(image::DynamicImage::ImageRgba8(still).to_rgb8());
    }

    /// Where a hand's tip is in the picture: −1 to 1 to the right and up.
    fn tip(&self, hand: usize) -> Vec2 {
        let aim = self.visitor.frame.hands[hand].aim;
        let tip = aim.position + aim.orientation * Vec3::NEG_Z * HandParams::default().tip;
        let from_eye = Mat3::from_quat(self.view.pose.orientation).transpose();
        let at = from_eye * (tip - self.view.pose.position);
        at.truncate() / (-at.z * self.view.fov.right.tan())
    }
}

const TRUNK: [Vec3; 3] = [
    Vec3::new(0.0, 0.08, 0.0),
    Vec3::new(0.005, 0.16, 0.0),
    Vec3::new(0.015, 0.24, 0.0),
];

const BRANCH: Vec3 = Vec3::new(-0.1, 0.15, 0.02);

fn draw(show: &mut Show<'_>) {
    show.click(TRUNK[0]);
    show.reach(TRUNK[1]);
    show.still();
    show.pull(true);
    show.pull(false);
    show.reach(TRUNK[2]);
    show.still();
    show.pull(true);
    show.pull(false);
    show.reach(Vec3::new(0.09, 0.28, 0.0));
    show.still();
}

fn free_hand(show: &mut Show<'_>) {
    show.click(TRUNK[0]);
    show.reach(Vec3::new(0.0, 0.12, 0.0));
    show.visitor.frame.hands[RIGHT].trigger = 1.0;
    for n in 0..=24_u8 {
        let along = f32::from(n) / 24.0;
        let tip = Vec3::new(0.06 * (along * 6.0).sin(), 0.12 + 0.17 * along, 0.0);
        show.reach(tip);
        if n == 10 || n == 24 {
            show.still();
        }
    }
    show.pull(false);
    show.away();
    show.still();
}

fn branch(show: &mut Show<'_>) {
    show.trunk();
    let node = ROOT + TRUNK[0];
    let tip = node + Vec3::new(0.09, 0.05, 0.06);
    show.hold(RIGHT, tip, node - tip);
    show.still();
    show.pull(true);
    show.pull(false);
    show.reach(Vec3::new(0.1, 0.15, 0.0));
    show.still();
    show.pull(true);
    show.pull(false);
    show.away();
    show.still();
}

fn move_node(show: &mut Show<'_>) {
    show.branched();
    show.reach(TRUNK[1]);
    show.still();
    show.visitor.grip(RIGHT, true);
    show.reach(Vec3::new(0.07, 0.19, 0.0));
    show.visitor.wait(0.3);
    show.still();
    show.visitor.grip(RIGHT, false);
    show.away();
    show.still();
}

fn delete(show: &mut Show<'_>) {
    show.branched();
    show.reach(TRUNK[1]);
    show.visitor.grip(RIGHT, true);
    show.visitor.wait(0.3);
    show.still();
    show.pull(true);
    show.pull(false);
    show.visitor.grip(RIGHT, false);
    show.away();
    show.still();
}

fn erase(show: &mut Show<'_>) {
    show.branched();
    show.set("Draw");
    show.set("Eraser");
    show.reach(TRUNK[2]);
    show.still();
    show.visitor.frame.hands[RIGHT].trigger = 1.0;
    show.reach(TRUNK[2]);
    show.reach(TRUNK[1]);
    show.still();
    show.reach(BRANCH);
    show.away();
    show.still();
}

fn snap(show: &mut Show<'_>) {
    show.seen_from(
        Vec3::new(0.05, 1.2, 0.15),
        ROOT + Vec3::new(0.12, 0.13, 0.0),
        0.75,
    );
    show.click(Vec3::new(0.0, 0.16, 0.0));
    let askew = Vec3::new(0.25, 0.174, 0.0);
    show.reach(askew);
    show.still();
    show.set("Draw");
    show.set("snap to angles");
    show.reach(askew);
    show.still();
}

fn copies(show: &mut Show<'_>) {
    show.trunk();
    show.set("Draw");
    show.set("draw branches with their mirror image");
    show.click(TRUNK[1]);
    show.reach(Vec3::new(0.09, 0.22, 0.03));
    show.still();
    show.pull(true);
    show.pull(false);
    show.set("draw branches with their mirror image");
    show.five_around();
    show.click(TRUNK[0]);
    show.reach(Vec3::new(0.13, 0.1, 0.03));
    show.still();
    show.pull(true);
    show.pull(false);
    show.still();
}

fn undo(show: &mut Show<'_>) {
    show.seen_from(
        Vec3::new(-0.1, 1.4, 0.65),
        Vec3::new(0.05, 1.02, -0.4),
        0.75,
    );
    show.branched();
    show.reach(Vec3::new(0.17, 0.1, 0.5));
    show.still();
    for x in [-1.0, 1.0] {
        for pushed in [x, 0.0] {
            show.visitor.frame.hands[RIGHT].stick.x = pushed;
            show.visitor.frame();
        }
        show.still();
    }
}

fn grow(show: &mut Show<'_>) {
    show.seen_from(Vec3::new(-0.2, 1.6, 0.8), Vec3::new(0.05, 1.2, -2.0), 0.8);
    show.branched();
    show.reach(Vec3::new(0.1, 0.28, 0.5));
    show.steps(2);
    for _ in 0..2 {
        show.still();
        show.steps(1);
    }
    show.still();
}

fn platform(show: &mut Show<'_>) {
    show.seen_from(Vec3::new(-0.2, 1.5, 0.5), ROOT + Vec3::Y * 0.05, 0.95);
    show.branched();
    let rim = |x: f32, y: f32, z: f32| ROOT + Vec3::new(0.255 * x, y, 0.255 * z);
    show.hold(RIGHT, rim(0.8, 0.0, 0.6), FROM_THE_RIGHT);
    show.still();
    show.visitor.grip(RIGHT, true);
    show.hold(RIGHT, rim(0.8, 0.15, 0.6), FROM_THE_RIGHT);
    show.visitor.wait(0.2);
    show.still();
    show.hold(RIGHT, rim(0.8, 0.0, 0.6), FROM_THE_RIGHT);
    show.hold(LEFT, rim(-0.8, 0.0, 0.6), FROM_THE_LEFT);
    show.visitor.grip(LEFT, true);
    show.hold(RIGHT, rim(1.4, 0.0, 0.45), FROM_THE_RIGHT);
    show.hold(LEFT, rim(-1.4, 0.0, 0.8), FROM_THE_LEFT);
    show.visitor.wait(0.2);
    show.still();
}

/// A place on the dial of the lever or the wheel.
fn on_dial(side: f32, degrees: f32) -> Vec3 {
    let angle = degrees.to_radians();
    Vec3::new(0.24 * side, 0.84, -0.28) + Vec3::new(angle.sin(), 0.25, angle.cos()) * 0.06
}

fn lever(show: &mut Show<'_>) {
    show.seen_from(
        Vec3::new(-0.02, 1.35, 0.3),
        Vec3::new(0.18, 0.92, -0.4),
        0.72,
    );
    show.branched();
    show.away();
    show.hold(RIGHT, on_dial(1.0, 137.508), FROM_THE_RIGHT);
    show.still();
    show.visitor.grip(RIGHT, true);
    for degrees in [120.0, 90.0, 60.0, 30.0] {
        show.hold(RIGHT, on_dial(1.0, degrees), FROM_THE_RIGHT);
    }
    show.still();
}

fn wheel(show: &mut Show<'_>) {
    show.seen_from(Vec3::new(0.1, 1.6, 0.7), Vec3::new(-0.1, 1.05, -1.0), 0.9);
    show.branched();
    show.away();
    show.steps(3);
    show.hold(LEFT, on_dial(-1.0, 180.0), FROM_THE_LEFT);
    show.still();
    show.visitor.grip(LEFT, true);
    for n in 1..=20_u8 {
        show.hold(
            LEFT,
            on_dial(-1.0, 180.0 + f32::from(n) * 7.0),
            FROM_THE_LEFT,
        );
        if n == 8 || n == 20 {
            show.still();
        }
    }
}

fn stump(show: &mut Show<'_>) {
    show.seen_from(
        Vec3::new(-0.1, 1.4, 0.35),
        Vec3::new(0.03, 0.95, -0.4),
        0.75,
    );
    show.branched();
    show.hold(RIGHT, Vec3::new(0.0, 0.865, -0.19), FROM_THE_RIGHT);
    show.still();
    show.pull(true);
    show.pull(false);
    show.still();
    show.pull(true);
    show.pull(false);
    show.still();
}

fn panel(show: &mut Show<'_>) {
    show.branched();
    show.away();
    let center = show.visitor.center(PanelId::Bench);
    let normal = show.visitor.normal(PanelId::Bench);
    show.seen_from(
        center + normal * 1.1 + Vec3::new(-0.1, 0.1, 0.25),
        center + Vec3::Y * 0.03,
        0.6,
    );
    let tab = show.visitor.find(PanelId::Bench, "Shape");
    let tab = show.visitor.on(PanelId::Bench, tab);
    let tip = tab + normal * 0.2 + Vec3::new(0.02, -0.2, 0.0);
    show.hold(RIGHT, tip, tab - tip);
    show.visitor.frame();
    show.still();
    show.pull(true);
    show.pull(false);
    let button = show.visitor.find(PanelId::Bench, "alternate");
    let button = show.visitor.on(PanelId::Bench, button);
    for above in [0.06, 0.03, 0.01, -0.005] {
        show.hold(
            RIGHT,
            button + normal * above,
            Vec3::new(-0.3, 1.0, 0.0) - normal * 0.5,
        );
    }
    show.still();
    let tip = center + normal * 0.15 + Vec3::new(0.1, -0.05, 0.0);
    show.hold(RIGHT, tip, center - tip);
    show.visitor.grip(RIGHT, true);
    show.hold(RIGHT, tip + Vec3::new(0.1, 0.08, 0.0), center - tip);
    show.visitor.frame();
    show.still();
}

/// Its picture's name, and how it is used.
type Tool = (&'static str, fn(&mut Show<'_>));

const TOOLS: &[Tool] = &[
    ("draw", draw),
    ("free-hand", free_hand),
    ("branch", branch),
    ("move", move_node),
    ("delete", delete),
    ("erase", erase),
    ("snap", snap),
    ("copies", copies),
    ("undo", undo),
    ("grow", grow),
    ("platform", platform),
    ("lever", lever),
    ("wheel", wheel),
    ("stump", stump),
    ("panel", panel),
];

#[test]
fn each_tool_is_seen_in_the_hand() {
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, SIDE, SIDE).unwrap();
    for (name, tool) in TOOLS {
        let mut show = Show::new(&mut picture);
        tool(&mut show);
        assert!(show.stills.len() > 1 && show.hand_in_sight, "{name}");
        for pair in show.stills.windows(2) {
            let far = far(&pair[0], &pair[1]);
            assert!(
                far > 150,
                "{name}: nothing is seen to happen ({far} pixels)"
            );
        }
        compare(&format!("tools/{name}"), &strip(&show.stills));
    }
    assert_eq!(gpu.messages().count(), 0, "validation is silent");
}
