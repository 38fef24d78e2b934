//! A quad as a headset would make it, and what is copied into it.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::sync::Arc;

use ash::vk;
use glam::{Affine3A, Vec3};
use image::RgbaImage;
use ramus_xr::vulkan::QuadImages;

use super::LayerImage;
use crate::render::{
    Backdrop, Eye, Fov, Gpu, GpuParams, Headless, Offscreen, Renderer, RendererParams, StereoImage,
    memory::{Image, ImageDesc},
    probe, read_color,
};
use crate::world::scene::{Board, Scene};

#[path = "../../../tests/counting/mod.rs"]
pub(crate) mod counting;

/// A device under the validation layer, or none (said aloud) where there is no Vulkan; CI must have one.
pub(crate) fn device() -> Option<Gpu> {
    Gpu::new(&Headless::default(), &GpuParams::checked())
        .inspect_err(|error| {
            assert!(std::env::var("CI").is_err(), "CI needs a device: {error}");
            eprintln!("skipped: {error}");
        })
        .ok()
}

/// A quad of one image that can be read.
pub(crate) struct Readable {
    gpu: Gpu,
    // The view before its image.
    picture: StereoImage,
    _image: Image,
    pub(crate) images: QuadImages,
}

impl Readable {
    pub(crate) fn new(gpu: &Gpu, format: vk::Format, extent: vk::Extent2D) -> Self {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        // Of two layers, as what reads it wants them: the first is the quad's.
        let desc = ImageDesc::stereo("a quad's image", format, extent, usage);
        let image = Image::new(gpu, desc).unwrap();
        Self {
            gpu: gpu.clone(),
            // SAFETY: the image is kept beside its view.
            picture: unsafe { StereoImage::new(gpu, image.handle, format, extent) }.unwrap(),
            // SAFETY: the image is so and is kept beside it.
            images: unsafe { QuadImages::new(vec![image.handle], format, extent) },
            _image: image,
        }
    }

    /// What was copied into it; waits for the device.
    pub(crate) fn read(&self) -> RgbaImage {
        let [picture, _] = read_color(&self.gpu, &self.picture).unwrap();
        picture
    }
}

/// A square of egui's.
fn square(x: f32, y: f32, color: egui::Color32) -> egui::ClippedPrimitive {
    let mut mesh = egui::Mesh::default();
    let rect = egui::Rect::from_min_size(egui::pos2(x, y), egui::vec2(20.0, 20.0));
    mesh.add_colored_rect(rect, color);
    egui::ClippedPrimitive {
        clip_rect: egui::Rect::EVERYTHING,
        primitive: egui::epaint::Primitive::Mesh(mesh),
    }
}

#[test]
fn a_layer_shows_the_panels_own_pixels_and_the_scene_has_none_of_it() {
    let Some(gpu) = device() else { return };
    let params = RendererParams {
        backdrop: Backdrop::Plain([0.1, 0.2, 0.3, 1.0]),
        ..RendererParams::new(64, 64, probe::multiview(&gpu).unwrap().mode(&gpu))
    };
    let offscreen = Offscreen::new(&gpu, params.extent).unwrap();
    let mut renderer = Renderer::new(&gpu, &params).unwrap();
    let scene = Scene {
        board: Some(Board {
            world_from_board: Affine3A::IDENTITY,
            size: [0.4, 0.3],
            revision: 1,
            content: Arc::default(),
        }),
        ..Scene::default()
    };
    let eyes = Eye::looking_at(Vec3::Z, Vec3::ZERO, Fov::symmetric(1.0, 1.0)).pair(0.06);
    let look = |renderer: &mut Renderer, scene: &Scene| {
        renderer.draw(scene, &eyes, &offscreen.target()).unwrap();
        offscreen.read_color().unwrap()
    };
    let empty = look(&mut renderer, &Scene::default());
    assert_eq!(renderer.panel_extent(0), None, "never painted");

    // Left and right two opaque colours, below a half transparent one and nothing.
    let colors = [
        ([0.0, 0.0], egui::Color32::from_rgb(200, 101, 50)),
        ([20.0, 0.0], egui::Color32::from_rgb(1, 2, 255)),
        (
            [0.0, 20.0],
            egui::Color32::from_rgba_premultiplied(64, 32, 7, 128),
        ),
    ];
    let squares = colors.map(|([x, y], color)| square(x, y, color));
    let mut textures = egui::TexturesDelta::default();
    textures.push(
        egui::TextureId::default(),
        egui::epaint::ImageDelta::full(
            egui::ColorImage::filled([2, 2], egui::Color32::WHITE),
            egui::TextureOptions::LINEAR,
        ),
    );
    renderer
        .paint_panel(0, &squares, &mut textures, [80, 60], 2.0)
        .unwrap();
    let extent = renderer.panel_extent(0).unwrap();
    assert_eq!((extent.width, extent.height), (80, 60));
    let with = look(&mut renderer, &scene);
    assert_ne!(with, empty);

    for format in [vk::Format::R8G8B8A8_SRGB, vk::Format::B8G8R8A8_SRGB] {
        let quad = Readable::new(&gpu, format, extent);
        assert!(
            LayerImage::of_quad(&quad.images, 1).is_none(),
            "it has one image"
        );
        renderer.lift_panel(0, true);
        renderer.copy_panel(0, LayerImage::of_quad(&quad.images, 0).unwrap());
        assert_eq!(look(&mut renderer, &scene), empty, "lifted out of it");
        let copied = quad.read();
        for (x, y, pixel) in copied.enumerate_pixels() {
            let inside = |[left, top]: [f32; 2]| {
                let (x, y) = (x as f32 / 2.0 - left, y as f32 / 2.0 - top);
                (0.0..20.0).contains(&x) && (0.0..20.0).contains(&y)
            };
            let color = colors.iter().find(|(at, _)| inside(*at));
            let expected = color.map_or([0; 4], |(_, color)| color.to_array());
            assert_eq!(pixel.0, expected, "{format:?} at {x}, {y}");
        }
        renderer.lift_panel(0, false);
        assert_eq!(look(&mut renderer, &scene), with, "back in the scene");
    }
    // An image of another size is left alone, and a panel that there is not.
    let other = vk::Extent2D {
        width: 81,
        ..extent
    };
    let quad = Readable::new(&gpu, vk::Format::R8G8B8A8_SRGB, other);
    let image = LayerImage::of_quad(&quad.images, 0).unwrap();
    renderer.copy_panel(0, image);
    renderer.copy_panel(5, image);
    renderer.lift_panel(5, true);
    assert_eq!(look(&mut renderer, &scene), with);
    drop(renderer);
    assert_eq!(gpu.messages().list(), Vec::<String>::new(), "validation");
}
