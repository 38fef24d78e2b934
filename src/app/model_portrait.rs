//! Pictures of scanned models without a headset.

use std::sync::Arc;

use anyhow::{Result, bail};
use glam::{Affine3A, DVec3, Quat, Vec3};
use image::RgbaImage;
use rayon::prelude::*;

use super::picture::Picture;
use super::portrait::{PortraitParams, before_box, looking_at, open_gpu};
use crate::mesh::display::Display;
use crate::mesh::endpoints::Endpoint;
use crate::mesh::unit::Unit;
use crate::render::Backdrop;
use crate::world::marks::{color_of, pin};
use crate::world::model::up;
use crate::world::models::{box_rods, box_signs, centerline_look};
use crate::world::scene::{ModelLook, PlacedModel, Scene, SurfaceLook};

/// How a model is shown.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelPortrait {
    /// What of it is to be seen.
    pub look: ModelLook,
    /// Whether its box is drawn round it.
    pub boxed: bool,
    /// What its numbers count, which is written on the box.
    pub unit: Unit,
    /// What lies inside and is seen where the surface hides nothing.
    pub centerline: Option<Arc<Display>>,
    /// Endpoints that are shown on it, in the file's coordinates.
    pub endpoints: Vec<Endpoint>,
    /// Whether the file's third axis points up; else its second does.
    pub z_up: bool,
    /// Turn about the vertical, radians: seen from a corner, shapes are told apart.
    pub turn: f32,
    /// What stands behind it.
    pub backdrop: Backdrop,
    /// Pixels of the picture's side.
    pub pixels: u32,
}

/// Draws a model of any size, as seen from before it.
///
/// # Errors
/// Where there is nothing to see or no device can draw it.
pub fn of_model(display: Display, how: &ModelPortrait) -> Result<RgbaImage> {
    let params = PortraitParams::default();
    let size = display.size();
    let half = size.max_element() * 0.5;
    if !half.is_finite() || half < f32::MIN_POSITIVE {
        bail!("the model has no extent, so there is nothing to draw");
    }
    let turn = Quat::from_rotation_y(how.turn) * up(how.z_up);
    let scale = params.radius / half;
    let middle = (display.low + display.high) * 0.5;
    let turned = Affine3A::from_scale_rotation_translation(Vec3::splat(scale), turn, Vec3::ZERO);
    let placed = |at| turned.transform_point3(at - middle);
    let (low, high) = if how.boxed {
        box_extent(&display, placed)
    } else {
        extent(&display, placed)
    };
    // What is lowest touches the ground.
    let lift = Vec3::Y * -low.y;
    let world_from_model =
        Affine3A::from_translation(lift) * turned * Affine3A::from_translation(-middle);
    let target = (low + high) * 0.5 + lift;
    let eye = before_box(target, high - low, &params);
    let mut scene = Scene::default();
    if how.boxed {
        let radius = eye.distance(target) * 0.0012;
        box_rods(&display, &world_from_model, radius, &mut scene.rods);
        box_signs(&display, &world_from_model, how.unit, eye, &mut scene);
    }
    let origin = display.mesh.origin;
    let on_stage = |place: DVec3| world_from_model.transform_point3((place - origin).as_vec3());
    for endpoint in &how.endpoints {
        let radius = eye.distance(target) * 0.006;
        pin(
            endpoint,
            on_stage,
            radius,
            color_of(endpoint.kind),
            &mut scene,
        );
    }
    scene.models.push(PlacedModel {
        display: Arc::new(display),
        revision: 1,
        world_from_model,
        look: how.look,
    });
    let seen_through = matches!(how.look.surface, None | Some(SurfaceLook::XRay));
    if let Some(line) = how.centerline.as_ref().filter(|_| seen_through) {
        scene.models.push(PlacedModel {
            display: Arc::clone(line),
            revision: 2,
            world_from_model,
            look: centerline_look(),
        });
    }
    let view = looking_at(eye, target, params.field);
    let gpu = open_gpu()?;
    let mut picture = Picture::before(&gpu, how.pixels, how.pixels, how.backdrop)?;
    picture.draw_whole(&scene, &[view, view], None)?;
    if let Some(trouble) = picture.take_trouble() {
        bail!("{trouble}");
    }
    let [left, _] = picture.read(None)?;
    Ok(left)
}

/// The box around the file's box, as it is placed.
fn box_extent(display: &Display, placed: impl Fn(Vec3) -> Vec3) -> (Vec3, Vec3) {
    let corners = display.corners().into_iter().map(placed);
    corners.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| {
        (low.min(at), high.max(at))
    })
}

/// The box around what triangles use, as it is placed: seldom as large as the one around the file's box.
fn extent(display: &Display, placed: impl Fn(Vec3) -> Vec3 + Sync) -> (Vec3, Vec3) {
    let mesh = &display.mesh;
    let vertices = mesh.triangles.par_iter().flatten_iter();
    let points = vertices.filter_map(|&vertex| mesh.positions.get(vertex as usize));
    points.map(|&at| (placed(at), placed(at))).reduce(
        || (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |a, b| (a.0.min(b.0), a.1.max(b.1)),
    )
}
