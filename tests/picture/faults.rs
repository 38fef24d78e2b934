//! What goes wrong: nonsense in the scene, things that cannot be done, a broken driver.

use ash::vk;
use glam::{Affine3A, Vec3};
use image::Rgba;
use ramus::{
    render::{Gpu, GpuParams, Headless, Offscreen, RenderError, Renderer, RendererParams, probe},
    world::scene::{Ball, Rod, Scene},
};

use super::support::{
    ahead, ball, blob, device, disc, mode, plain, shoot, silent, stage, standing,
};

#[test]
fn nonsense_is_drawn_without_harm() {
    let Some(gpu) = device() else { return };
    let mut scene = stage();
    for (n, bad) in [f32::NAN, f32::INFINITY, -1.0, 1e30, 0.0]
        .into_iter()
        .enumerate()
    {
        scene.balls.push(Ball {
            center: Vec3::splat(bad),
            radius: bad,
            color: [bad; 4],
        });
        scene.rods.push(Rod {
            from: Vec3::splat(bad),
            to: Vec3::ZERO,
            radius: 0.01,
            color: [1.0; 4],
        });
        scene
            .plates
            .push(disc(Vec3::splat(bad), bad, bad, [bad; 4]));
        let tree = scene.tree.as_mut().unwrap();
        tree.growth = bad;
        tree.world_from_tree = Affine3A::from_scale(Vec3::splat(bad));
        tree.revision = n as u64;
        let mut eyes = standing();
        eyes[1].world_from_eye.position.x = bad;
        eyes[0].fov.left = bad;
        let shot = shoot(
            &gpu,
            &RendererParams::new(64, 64, mode(&gpu)),
            &scene,
            &eyes,
        );
        assert_eq!(shot.color[0].dimensions(), (64, 64));
    }
    silent(&gpu);
}

#[test]
fn what_cannot_be_done_is_said_in_a_sentence() {
    let nobody = Headless {
        device: Some("No Such Card 9000".to_owned()),
    };
    match Gpu::new(&nobody, &GpuParams::default()) {
        Err(RenderError::NoLoader(_)) => {}
        Err(error) => assert!(
            error.to_string().contains("No Such Card 9000")
                && error.to_string().contains("install"),
            "{error}"
        ),
        Ok(_) => panic!("there is no such card"),
    }
    let Some(gpu) = device() else { return };
    for (width, height) in [(0, 5), (5, 0), (1 << 20, 8)] {
        let Err(error) = Offscreen::new(&gpu, vk::Extent2D { width, height }) else {
            panic!("{width} × {height}")
        };
        assert!(
            error.to_string().contains("cannot be drawn here"),
            "{error}"
        );
    }
    let offscreen = Offscreen::new(
        &gpu,
        vk::Extent2D {
            width: 32,
            height: 32,
        },
    )
    .unwrap();
    let mut renderer = Renderer::new(&gpu, &plain(mode(&gpu), 0.0)).unwrap();
    let error = renderer
        .draw(&Scene::default(), &ahead(1.0), &offscreen.target())
        .unwrap_err();
    assert!(error.to_string().contains("make a new renderer"), "{error}");
    drop(renderer);
    silent(&gpu);
}

/// Run in a process of its own by the next test.
#[test]
#[ignore = "needs a driver whose multiview is broken"]
fn broken_multiview_is_found() {
    let gpu = device().unwrap();
    assert_eq!(
        probe::multiview(&gpu).unwrap(),
        probe::Multiview::Broken,
        "{:?}",
        gpu.info()
    );
    // The other way is right: each eye sees the ball, at its own place.
    let scene = ball(Vec3::ZERO, 0.2, [0.9, 0.2, 0.1, 1.0]);
    let shot = shoot(&gpu, &plain(mode(&gpu), 0.0), &scene, &ahead(2.0));
    let [left, right] = [0, 1].map(|eye| blob(&shot.color[eye], Rgba([0, 0, 0, 255])));
    assert!(
        left.2 > 500 && right.2 > 500 && left.0 > right.0 + 3.0,
        "{left:?} {right:?}"
    );
    silent(&gpu);
}

/// Where `RAMUS_BROKEN_DRIVER` names the ICD file of a driver with broken multiview (Mesa 22's lavapipe).
#[test]
fn a_broken_driver_falls_back_to_one_pass_an_eye() {
    let Some(file) = std::env::var_os("RAMUS_BROKEN_DRIVER") else {
        eprintln!("skipped: RAMUS_BROKEN_DRIVER names no driver");
        return;
    };
    let output = std::process::Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "picture::faults::broken_multiview_is_found",
            "--ignored",
        ])
        .env("VK_ICD_FILENAMES", &file)
        .env("VK_DRIVER_FILES", &file)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("1 passed"), "the child ran no test: {said}");
}
