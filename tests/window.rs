//! The workshop in a real window, under a real X server, with a real pointer and keyboard: Xvfb and xdotool.
//!
//! What is clicked is computed with the window's own camera, so the test says "click on this point of the stage" and the project says whether
//! the program understood. Pictures are checked twice: as the program keeps them, and as they stand on the server's screen.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

mod window {
    pub(crate) mod desktop;
}

use std::{fs, path::Path, process::Command};

use glam::{Vec2, Vec3};
use image::{Rgb, RgbImage};
use ramus::{
    app::{store::read_project, window::camera::Camera},
    world::{World, history::History},
};

use window::desktop::{Desktop, until};

const SIZE: Vec2 = Vec2::new(1280.0, 800.0);

/// The sketch's first colour (Okabe and Ito's orange), as a lit line may show it.
fn is_orange(&Rgb([red, green, blue]): &Rgb<u8>) -> bool {
    red > 120 && green > red / 3 && green < red - red / 5 && blue < red / 3
}

/// Where a point of the stage is seen, pixels.
fn seen(camera: &Camera, point: Vec3) -> Vec2 {
    let pose = camera.pose();
    let at = pose.orientation.inverse() * (point - pose.position);
    let fov = camera.fov(SIZE);
    let part = Vec2::new(at.x / -at.z / fov.right.tan(), -at.y / -at.z / fov.up.tan());
    (part + 1.0) * 0.5 * SIZE
}

/// Lines of the journal: a head and one for each action.
fn actions(project: &Path) -> usize {
    let mut journal = project.as_os_str().to_owned();
    journal.push(".journal");
    fs::read_to_string(journal).map_or(0, |text| text.lines().count().saturating_sub(1))
}

fn coverage(picture: &RgbImage, wanted: impl Fn(&Rgb<u8>) -> bool) -> usize {
    picture.pixels().filter(|pixel| wanted(pixel)).count()
}

#[test]
fn a_tree_is_drawn_with_the_mouse_and_its_session_replays() {
    let Some(desktop) = Desktop::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let project = place("oak.ramus");
    let mut program = desktop.program();
    program.arg("record").arg(place("oak.session"));
    program
        .args(["--headset", "window", "--project"])
        .arg(&project);
    program.arg("--out").arg(place("out"));
    let program = desktop.run(&mut program, "oak.ramus", &place("log"));

    // A trunk of three segments, upright before the person.
    let mut camera = Camera::at_work();
    let root = World::new(History::default()).selected_position().unwrap();
    let trunk = [0.10, 0.20, 0.30].map(|up| root + Vec3::new(0.01, up, 0.0));
    for (count, point) in trunk.into_iter().enumerate() {
        program.click(seen(&camera, point));
        until("a segment is drawn", || actions(&project) == count + 1);
    }
    // Its first node chosen, and a branch from there to the left.
    program.click(seen(&camera, trunk[0]));
    until("the node is chosen", || actions(&project) == 4);
    program.click(seen(&camera, trunk[0] + Vec3::new(-0.12, 0.1, 0.0)));
    until("the branch is drawn", || actions(&project) == 5);
    // The eye goes round; the next point is drawn across the new line of sight.
    let by = Vec2::new(160.0, 0.0);
    program.drag(2, SIZE * 0.5, SIZE * 0.5 + by);
    camera.orbit(by, SIZE.y);
    let across = trunk[0] + Vec3::new(-0.12, 0.1, 0.0);
    let right = camera.pose().orientation * Vec3::X;
    let aside = across - right * 0.1 + Vec3::Y * 0.05;
    program.click(seen(&camera, aside));
    until("the branch goes on", || actions(&project) == 6);
    // A node is taken by the right button and carried 60 pixels.
    let from = seen(&camera, trunk[2]);
    program.drag(3, from, from + Vec2::new(60.0, 0.0));
    until("the node is moved", || actions(&project) == 7);
    for count in 8..=11 {
        program.key("g");
        until("it grows", || actions(&project) == count);
    }
    program.key("ctrl+z");
    until("a step is undone", || actions(&project) == 12);
    program.key("ctrl+y");
    until("and done again", || actions(&project) == 13);
    program.key("shift+g");
    until("a step back", || actions(&project) == 14);

    let kept = program.picture(&place("out/oak-01.png"));
    assert_eq!(kept.dimensions(), (1280, 800));
    let lines = coverage(&kept, is_orange);
    assert!(
        (400..40_000).contains(&lines),
        "{lines} pixels of the trunk"
    );
    // The left half of the screen has no board, which has a message now.
    let screen = desktop.screen();
    let differs = |x: u32, y: u32| {
        let pair = [kept.get_pixel(x, y), screen.get_pixel(x, y)];
        (0..3).any(|channel| pair[0].0[channel].abs_diff(pair[1].0[channel]) > 8)
    };
    let wrong = (0..800).flat_map(|y| (0..560).map(move |x| (x, y)));
    let wrong = wrong.filter(|&(x, y)| differs(x, y)).count();
    assert!(
        wrong < 2_000,
        "{wrong} pixels of the screen are not the picture's"
    );

    program.resize(900, 600);
    until("the picture is as large as the window", || {
        let _ = fs::remove_file(place("out/oak-02.png"));
        program.picture(&place("out/oak-02.png")).dimensions() == (900, 600)
    });

    let idle = program.processor_seconds(3);
    assert!(idle < 0.5, "{idle} s of processor time in 3 s of rest");
    println!("at rest: {idle} s of processor time in 3 s");

    assert_eq!(program.end("Escape"), "", "validation layers or warnings");
    let document = read_project(&project).unwrap();
    assert_eq!(document.step, 3);
    let sketch = &document.sketch;
    let counts: Vec<usize> = sketch
        .strokes
        .iter()
        .map(|stroke| stroke.points.len())
        .collect();
    assert_eq!(counts, [3, 2], "a trunk of three, a branch of two");
    let nodes: Vec<Vec3> = sketch.nodes().map(|(_, position)| position).collect();
    // The default platform shows a metre of the sketch as so much of the stage.
    let world = World::new(History::new(document.clone()));
    let scale = (trunk[0] - root).length() / (nodes[1] - nodes[0]).length();
    assert!((0.05..1.0).contains(&scale), "{scale}");
    assert!(
        (nodes[2] * scale).distance(trunk[1] - root) < 0.003,
        "where it was clicked"
    );
    let end = nodes[5] * scale;
    // A pixel is 2 mm.
    assert!(end.distance(aside - root) < 0.006, "{end} {}", aside - root);
    assert!(
        (nodes[3] * scale).distance(trunk[2] - root) > 0.02,
        "the node was moved"
    );
    assert!(world.selected_position().is_some());
    for made in ["oak.glb", "oak.lsys"] {
        assert!(fs::metadata(place(made)).unwrap().len() > 100, "{made}");
    }

    // The same session, without the window and in it.
    let mut replay = Command::new(env!("CARGO_BIN_EXE_ramus"));
    replay.arg("replay").arg(place("oak.session"));
    replay.arg("--project").arg(place("again.ramus"));
    assert!(replay.output().unwrap().status.success());
    assert_eq!(
        read_project(&place("again.ramus")).unwrap().sketch,
        document.sketch
    );
    let mut replay = desktop.program();
    replay.arg("replay").arg(place("oak.session"));
    replay
        .args(["--headset", "window", "--project"])
        .arg(place("watched.ramus"));
    assert_eq!(
        desktop
            .run(&mut replay, "oak.session", &place("replay-log"))
            .ended(),
        ""
    );
    assert_eq!(
        read_project(&place("watched.ramus")).unwrap().sketch,
        document.sketch
    );
}

#[test]
fn without_a_display_the_error_is_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_ramus"))
        .args(["--headset", "window", "--project"])
        .arg(folder.path().join("a.ramus"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.starts_with("ramus: no desktop answers (") && said.lines().count() == 1,
        "{said}"
    );
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        0,
        "nothing is made"
    );
}
