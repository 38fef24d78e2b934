//! The main job works: the recorded session played on the simulated headset, and pushed packet by packet through a
//! real OpenXR runtime, makes the same project, byte for byte; and what the runtime's own images hold when the
//! session ends shows the tree in both eyes, where it must be.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    clippy::cast_possible_truncation,
    reason = "a test that stops says enough by stopping"
)]

use std::path::Path;

use glam::Vec3;
use image::{Rgba, RgbaImage};
use ramus::app::headset::{self, Opened};
use ramus::app::picture::Picture;
use ramus::app::session::{self, Nobody, Watcher};
use ramus::app::store::Store;
use ramus::app::workshop::{Workshop, WorkshopParams};
use ramus::app::{demonstration, portrait};
use ramus::render::{Eye, Fov, Pose};
use ramus::world::scene::Scene;
use ramus_monado::feed::Fed;
use ramus_monado::remote::{Packet, Remote};
use ramus_monado::service::{Service, ServiceParams};
use ramus_monado::{stage, verdict};
use ramus_xr::simulated::Simulated;
use ramus_xr::{Acquired, Frame, Headset, View};

fn workshop(project: &Path) -> Workshop {
    Workshop::new(Store::begin(project).unwrap(), WorkshopParams::default()).unwrap()
}

/// What the session makes on the simulated headset.
fn simulated(frames: &[Frame], project: &Path) -> Vec<u8> {
    let mut headset = Simulated::new(
        frames.to_vec(),
        ash::vk::Extent2D {
            width: 64,
            height: 64,
        },
    );
    let mut workshop = workshop(project);
    session::run(&mut headset, &mut workshop, None, &mut Nobody).unwrap();
    workshop.close().unwrap();
    std::fs::read(project).unwrap()
}

/// Keeps the newest picture of the last frames, with the views and the scene that it shows.
#[derive(Default)]
struct Eyes {
    frames: usize,
    last: usize,
    seen: Option<([RgbaImage; 2], [View; 2], Scene)>,
}

impl Watcher for Eyes {
    fn drawn(
        &mut self,
        workshop: &Workshop,
        picture: &Picture,
        views: &[View; 2],
        acquired: Option<Acquired>,
    ) -> anyhow::Result<()> {
        if self.frames + 1 >= self.last {
            let mut scene = Scene::default();
            workshop.world().scene(&mut scene);
            self.seen = Some((picture.read(acquired)?, *views, scene));
        }
        Ok(())
    }

    fn ended(&mut self, _headset: &mut dyn Headset) {
        self.frames += 1;
    }
}

/// Where a point of the stage is in an eye's picture, in pixels.
fn pixel(view: &View, point: Vec3, [width, height]: [u32; 2]) -> [f32; 2] {
    let eye = Eye {
        world_from_eye: Pose {
            orientation: view.pose.orientation,
            position: view.pose.position,
        },
        fov: Fov {
            left: view.fov.left,
            right: view.fov.right,
            up: view.fov.up,
            down: view.fov.down,
        },
    };
    let clip = eye.clip_from_world() * point.extend(1.0);
    [
        (clip.x / clip.w * 0.5 + 0.5) * width as f32,
        (clip.y / clip.w * 0.5 + 0.5) * height as f32,
    ]
}

/// Pixels where two pictures differ by more than noise.
fn difference(a: &RgbaImage, b: &RgbaImage) -> Vec<[f32; 2]> {
    let apart = |Rgba(a): &Rgba<u8>, Rgba(b): &Rgba<u8>| {
        (0..3).map(|i| a[i].abs_diff(b[i])).max().unwrap_or(0)
    };
    a.enumerate_pixels()
        .zip(b.pixels())
        .filter(|((_, _, a), b)| apart(a, b) > 20)
        .map(|((x, y, _), _)| [x as f32 + 0.5, y as f32 + 0.5])
        .collect()
}

fn mean(points: &[[f32; 2]], axis: usize) -> f32 {
    points.iter().map(|point| point[axis]).sum::<f32>() / points.len() as f32
}

#[test]
fn the_same_session_makes_the_same_project_and_both_eyes_see_the_tree() {
    let name = "the_same_session_makes_the_same_project_and_both_eyes_see_the_tree";
    let output = stage::run(name, body).unwrap();
    assert_eq!(
        verdict::complaints(&output),
        [""; 0],
        "the runtime complained"
    );
}

fn body() {
    let folder = tempfile::tempdir().unwrap();
    let frames = demonstration::first_tree().unwrap();
    let expected = simulated(&frames, &folder.path().join("simulated.ramus"));

    let service = Service::start(ServiceParams::default()).unwrap();
    for (name, value) in service.environment() {
        // SAFETY: inside the stage this test is alone in its process.
        unsafe { std::env::set_var(name, value) };
    }
    let mut remote = Remote::connect(service.port()).unwrap();
    remote
        .send(&Packet::from_frame(&frames[0]).unwrap())
        .unwrap();
    let opened = Opened::start(headset::connect().unwrap()).unwrap();
    println!("{}", opened.describe());
    let gpu = opened.gpu().clone();

    let project = folder.path().join("runtime.ramus");
    let mut workshop = workshop(&project);
    let mut eyes = Eyes {
        last: frames.len(),
        ..Eyes::default()
    };
    let fed = frames.clone().into_iter();
    opened
        .run(
            |inner| Fed::new(inner, remote, fed),
            &mut workshop,
            &mut eyes,
        )
        .unwrap();
    workshop.close().unwrap();
    assert_eq!(
        eyes.frames,
        frames.len(),
        "every recorded frame was shown once"
    );
    let made = std::fs::read(&project).unwrap();
    assert_eq!(
        String::from_utf8_lossy(&made),
        String::from_utf8_lossy(&expected)
    );
    assert_eq!(gpu.messages().list(), [""; 0], "Vulkan validation");
    drop(gpu);

    let (seen, views, scene) = eyes.seen.unwrap();
    check_eyes(&seen, &views, &scene);
    let log = service.stop().unwrap();
    assert_eq!(verdict::complaints(&log), [""; 0]);
}

/// The tree, and nothing else, is what a picture without it lacks; it stands where projection puts it, in both eyes.
fn check_eyes(seen: &[RgbaImage; 2], views: &[View; 2], scene: &Scene) {
    let size = [seen[0].width(), seen[0].height()];
    let gpu = portrait::open_gpu().unwrap();
    let mut picture = Picture::offscreen(&gpu, size[0], size[1]).unwrap();
    let mut bare = scene.clone();
    let placed = bare.tree.take().unwrap();
    picture.draw_whole(&bare, views, None).unwrap();
    let without = picture.read(None).unwrap();

    let tops = placed
        .tree
        .position
        .iter()
        .map(|at| placed.world_from_tree.transform_point3(*at));
    let apex = tops.max_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
    let mut columns = [0.0; 2];
    for eye in 0..2 {
        let tree = difference(&seen[eye], &without[eye]);
        println!(
            "eye {eye}: the tree covers {} pixels of {size:?}",
            tree.len()
        );
        assert!(tree.len() > 40, "eye {eye} sees no tree");
        // The uppermost part of what differs is the tree's tip.
        let [x, y] = pixel(&views[eye], apex, size);
        let highest = tree
            .iter()
            .map(|point| point[1])
            .fold(f32::INFINITY, f32::min);
        assert!(
            (highest - y).abs() < 6.0,
            "eye {eye}: the tip is in row {highest}, not {y}"
        );
        let tip: Vec<_> = tree
            .into_iter()
            .filter(|point| point[1] < highest + 6.0)
            .collect();
        columns[eye] = mean(&tip, 0);
        assert!(
            (columns[eye] - x).abs() < 3.0,
            "eye {eye}: the tip is in column {}, not {x}",
            columns[eye]
        );
    }
    let disparity = columns[0] - columns[1];
    let expected = pixel(&views[0], apex, size)[0] - pixel(&views[1], apex, size)[0];
    println!("disparity {disparity} px, by projection {expected} px");
    assert!(
        (disparity - expected).abs() < 1.5,
        "disparity {disparity}, by projection {expected}"
    );
    assert_ne!(seen[0], seen[1], "the eyes see different pictures");
}
