//! Recorded sessions with a scanned model that lies beside them: brought, pulled large, cut open, marked, measured, and its centerline found. Played on the simulated headset,
//! each makes the project that lies beside it.
//!
//! `UPDATE_SESSIONS=1` records them anew, and the model with them; look at what changed.

use std::f32::consts::TAU;
use std::fmt::Write as _;
use std::path::PathBuf;

use ash::vk::Extent2D;
use glam::Vec3;
use ramus::app::picture::Picture;
use ramus::app::portrait;
use ramus::app::session::{self, Nobody};
use ramus::app::workshop::Workshop;
use ramus::mesh::endpoints::Kind;
use ramus::mesh::unit::Rounded;
use ramus::world::marks::Found;
use ramus::world::models::Cut;
use ramus::world::panels::PanelId;
use ramus::world::{World, history::History, project};
use ramus_xr::session as recorded;
use ramus_xr::simulated::Simulated;

use super::lessons::rest;
use super::pictures::views;
use super::visitor::{LEFT, RIGHT, Visitor};

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets/sessions/models")
}

/// A bent tube of 100 mm, open at both ends.
fn duct() -> String {
    const ROUND: usize = 16;
    const ALONG: usize = 24;
    let mut text = String::new();
    for row in 0..=ALONG {
        let t = row as f32 / ALONG as f32;
        let middle = Vec3::new(10.0 * (t * 3.0).sin(), 100.0 * t, 0.0);
        for column in 0..ROUND {
            let turn = TAU * column as f32 / ROUND as f32;
            let at = middle + Vec3::new(turn.cos(), 0.0, turn.sin()) * 12.0;
            writeln!(text, "v {:.2} {:.2} {:.2}", at.x, at.y, at.z).unwrap();
        }
    }
    for row in 0..ALONG {
        for column in 0..ROUND {
            let at = |row: usize, column: usize| 1 + row * ROUND + column % ROUND;
            let [a, b] = [at(row, column), at(row, column + 1)];
            let [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
            writeln!(text, "f {a} {c} {d} {b}").unwrap();
        }
    }
    text
}

fn workshop() -> Workshop {
    let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
    workshop.stay_with_models_of(&folder());
    workshop
}

fn press(visitor: &mut Visitor, text: &str) {
    visitor.scroll_to(RIGHT, PanelId::Bench, text);
    visitor.click(RIGHT, PanelId::Bench, text);
}

/// Where the duct's pedestal is, and a place on its front so high above it, metres.
fn front(visitor: &Visitor, height: f32) -> Vec3 {
    let place = visitor.document().models[0].place.position;
    place + Vec3::new(0.0, height, 0.03)
}

fn brings(visitor: &mut Visitor) {
    press(visitor, "Models");
    press(visitor, "duct.obj");
}

/// Both hands at the pedestal's rim, and apart.
fn pulls(visitor: &mut Visitor) {
    brings(visitor);
    let place = visitor.document().models[0].place.position;
    for (hand, side) in [(LEFT, -0.12), (RIGHT, 0.12)] {
        visitor.tip_to(hand, place + Vec3::X * side);
        visitor.grip(hand, true);
    }
    for part in 1..=10_u8 {
        for (hand, side) in [(LEFT, -0.12), (RIGHT, 0.12)] {
            let apart = side * (1.0 + f32::from(part) * 0.2);
            visitor.tip_to(hand, place + Vec3::new(apart, 0.1, 0.0));
        }
    }
    visitor.grip(LEFT, false);
    visitor.grip(RIGHT, false);
}

fn cuts(visitor: &mut Visitor) {
    brings(visitor);
    press(visitor, "by the left hand");
    let into = front(visitor, 0.2) - Vec3::Z * 0.03;
    visitor.tip_to(LEFT, into);
    visitor.frame();
    press(visitor, "where it is");
}

/// Two endpoints, the second carried on, then a distance and a way along.
fn marks(visitor: &mut Visitor) {
    brings(visitor);
    press(visitor, "Places");
    press(visitor, "sets endpoints");
    let pull_at = |visitor: &mut Visitor, height: f32| {
        let tip = front(visitor, height) + Vec3::Z * 0.4;
        visitor.tip_to(RIGHT, tip);
        visitor.pull(RIGHT, true);
        visitor.pull(RIGHT, false);
    };
    pull_at(visitor, 0.05);
    pull_at(visitor, 0.25);
    visitor.grip(RIGHT, true);
    let tip = front(visitor, 0.35) + Vec3::Z * 0.4;
    visitor.tip_to(RIGHT, tip);
    visitor.grip(RIGHT, false);
    for what in ["distance", "along the surface"] {
        press(visitor, what);
        pull_at(visitor, 0.1);
        pull_at(visitor, 0.3);
    }
}

/// The only model's centerlines, and the length of the first branch as the table has it.
fn length(workshop: &Workshop) -> String {
    let model = &workshop.document().models[0];
    let lines = workshop.world().lines(model).unwrap().unwrap();
    Rounded(lines.analysis.branches[0].length).to_string()
}

/// The centerline, its row, and then the line itself, which lets the light go out and lights it again.
fn finds(visitor: &mut Visitor) {
    brings(visitor);
    press(visitor, "Centerlines");
    press(visitor, "Find centerlines");
    visitor.frame();
    let row = length(&visitor.workshop);
    press(visitor, &row);
    press(visitor, "chooses branches");
    for _ in 0..2 {
        let tip = front(visitor, 0.2) + Vec3::new(0.02, 0.0, 0.37);
        visitor.tip_to(RIGHT, tip);
        visitor.pull(RIGHT, true);
        visitor.pull(RIGHT, false);
    }
}

/// What a person does.
type Hands = fn(&mut Visitor);

/// What it makes.
type Made = fn(&mut Workshop) -> bool;

const SESSIONS: [(&str, Hands, Made); 5] = [
    ("brings", brings, |workshop| {
        let models = workshop.scene().models.len();
        models == 1 && workshop.document().models[0].file == "duct.obj"
    }),
    ("pulls", pulls, |workshop| {
        let scale = workshop.document().models[0].place.scale;
        (scale - 1.2).abs() < 0.02
    }),
    ("cuts", cuts, |workshop| {
        let looking = workshop.world().looking();
        looking.cut == Cut::Stays && workshop.scene().models[0].look.cut.is_some()
    }),
    ("finds", finds, |workshop| {
        let model = workshop.document().models[0].clone();
        let world = workshop.world();
        let lines = world.lines(&model).unwrap().unwrap();
        let length = lines.analysis.table.branch_length.mean;
        // From the last ball of the tube to that of its other end.
        lines.len() == 1 && (75.0..104.0).contains(&length) && world.lit_branch(&model) == Some(0)
    }),
    ("marks", marks, |workshop| {
        let [source, target] = &workshop.document().models[0].endpoints[..] else {
            return false;
        };
        // 0.4 m of the stage are the duct's 100 mm.
        let snapped = source.snapped.unwrap();
        let middle = snapped.centre.z.abs() < 0.5 && (snapped.radius - 12.0).abs() < 0.5;
        let height = (target.point.y - 87.5).abs() < 1.0;
        let long =
            |found: &Found| matches!(found, Found::Length(length) if (49.0..54.0).contains(length));
        let measures = workshop.world().measures();
        middle
            && height
            && (source.kind, target.kind) == (Kind::Source, Kind::Target)
            && measures.len() == 2
            && measures.iter().all(|measure| long(&measure.found))
    }),
];

#[test]
fn sessions_with_a_model_do_what_they_did_when_they_were_recorded() {
    let update = std::env::var_os("UPDATE_SESSIONS").is_some();
    let named = |name: &str, ending: &str| folder().join(format!("{name}.{ending}"));
    if update {
        std::fs::create_dir_all(folder()).unwrap();
        std::fs::write(folder().join("duct.obj"), duct()).unwrap();
    }
    for (name, hands, made) in SESSIONS {
        if update {
            let mut visitor = Visitor::at(workshop());
            hands(&mut visitor);
            rest(&mut visitor);
            let bytes = recorded::to_bytes(&visitor.frames).unwrap();
            std::fs::write(named(name, "session"), bytes).unwrap();
        }
        let frames = recorded::read_file(&named(name, "session")).unwrap();
        let mut workshop = workshop();
        let extent = Extent2D {
            width: 64,
            height: 64,
        };
        let mut headset = Simulated::new(frames, extent);
        session::run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
        assert!(
            made(&mut workshop),
            "{name}: {:?} {:?}",
            workshop.document().models,
            workshop.world().measures()
        );
        let bytes = project::to_bytes(workshop.document());
        if update {
            std::fs::write(named(name, "ramus"), &bytes).unwrap();
        }
        let expected = std::fs::read(named(name, "ramus")).unwrap();
        assert!(bytes == expected, "{name} makes another project");
    }
}

/// Resident memory of this process, bytes.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/statm").unwrap();
    status.split(' ').nth(1).unwrap().parse::<u64>().unwrap() * 4096
}

/// What may be left of a model that came and went: the edits that can be undone, far less than the mesh and what is made of it.
const LEFT_BEHIND: u64 = 64 << 10;

#[test]
fn two_hundred_models_come_and_go_and_leave_nothing() {
    const ROUNDS: u64 = 200;
    const FIRST: u64 = 20;
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, 64, 64).unwrap();
    let views = views(Vec3::new(0.0, 1.5, 0.3), Vec3::new(0.2, 1.1, -0.9));
    let mut visitor = Visitor::at(workshop());
    let mut draw = |visitor: &mut Visitor| {
        for _ in 0..4 {
            visitor.frame();
            picture
                .draw_whole(visitor.workshop.scene(), &views, None)
                .unwrap();
        }
    };
    press(&mut visitor, "Models");
    let mut first = None;
    for round in 0..=ROUNDS {
        press(&mut visitor, "duct.obj");
        draw(&mut visitor);
        assert_eq!(visitor.workshop.scene().models.len(), 1, "{round}");
        press(&mut visitor, "Take it away");
        draw(&mut visitor);
        assert!(visitor.workshop.scene().models.is_empty(), "{round}");
        visitor.frames.clear();
        if round == FIRST {
            first = Some((resident(), gpu.memory()));
        }
    }
    let (before, on_device) = first.unwrap();
    let grown = resident().saturating_sub(before);
    println!(
        "{ROUNDS} models: {} KiB more than after {FIRST}, on the device {:?} bytes",
        grown >> 10,
        gpu.memory()
    );
    assert_eq!(gpu.memory(), on_device, "memory of the device");
    assert!(grown < (ROUNDS - FIRST) * LEFT_BEHIND, "{grown} bytes");
    assert!(picture.take_trouble().is_none());
}
