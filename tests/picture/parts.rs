//! Fewer pixels of a picture are the picture of a smaller one.

use ash::vk;
use ramus::render::{Gpu, Offscreen, Renderer, RendererParams, StereoMode};
use ramus::world::scene::Scene;

use super::support::{device, mode, silent, stage, standing};

fn part(width: u32, height: u32) -> vk::Extent2D {
    vk::Extent2D { width, height }
}

/// What a renderer shows that has drawn a scene in pictures of these sizes, one after the other.
fn drawn(
    gpu: &Gpu,
    scene: &Scene,
    size: vk::Extent2D,
    mode: StereoMode,
    parts: &[vk::Extent2D],
) -> [image::RgbaImage; 2] {
    let params = RendererParams::new(size.width, size.height, mode);
    let offscreen = Offscreen::new(gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(gpu, &params).unwrap();
    for part in parts {
        renderer.set_part(*part);
        for _ in 0..3 {
            let target = offscreen.target();
            renderer.draw(scene, &standing(), &target).unwrap();
        }
    }
    renderer.wait().unwrap();
    offscreen.read_color().unwrap()
}

#[test]
fn a_part_shows_what_a_smaller_picture_does() {
    let Some(gpu) = device() else { return };
    let scene = stage();
    let both = mode(&gpu);
    let (all, few) = (part(192, 160), part(120, 100));
    for mode in [both, StereoMode::PerEye] {
        let small = drawn(&gpu, &scene, few, mode, &[few]);
        // Smaller, and larger again.
        let shrunk = drawn(&gpu, &scene, all, mode, &[all, few]);
        let grown = drawn(&gpu, &scene, all, mode, &[few, part(9999, 0), all]);
        let whole = drawn(&gpu, &scene, all, mode, &[all]);
        for eye in 0..2 {
            let cut = image::imageops::crop_imm(&shrunk[eye], 0, 0, few.width, few.height);
            assert!(cut.to_image() == small[eye], "{mode:?} eye {eye}");
            assert!(grown[eye] == whole[eye], "{mode:?} eye {eye}");
        }
        assert!(small[0] != small[1]);
    }
    silent(&gpu);
}

#[test]
fn the_device_says_how_long_it_worked() {
    let Some(gpu) = device() else { return };
    let params = RendererParams::new(64, 64, mode(&gpu));
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let mut told = Vec::new();
    for _ in 0..5 {
        let target = offscreen.target();
        let report = renderer.draw(&stage(), &standing(), &target).unwrap();
        told.push(report.device);
    }
    assert_eq!(told[..2], [None; 2], "no frame is known to be done yet");
    for worked in &told[2..] {
        let seconds = worked.unwrap().as_secs_f64();
        assert!(seconds > 1e-5 && seconds < 60.0, "{seconds}");
    }
    silent(&gpu);
}
