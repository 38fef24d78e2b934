//! Panels that the headset's runtime shows by itself, at its own resolution (see [`ramus_xr::quad`]): text in them is sharper.
//!
//! A panel is lifted out of the scene when the headset has a quad of its picture's size for it. The picture is copied into the
//! quad only after it was painted, and the quad follows the panel in every frame. A panel that is seen from behind, one that has no
//! picture yet and one for which there is no quad stay in the scene, so that all panels are there in any case.
//!
//! Quads belong to a session of the runtime: a [`Layers`] is dropped with the picture that it lifts panels out of.

use glam::{Affine3A, Vec3};
use ramus_xr::quad::{QuadId, QuadPlace};
use ramus_xr::{Headset, HeadsetError, Pose, View, ash::vk};

use crate::render::{LayerImage, Renderer, panels};
use crate::world::scene::{MOST_PANELS, PlacedPanel, Scene};

/// The quad of a panel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Quad {
    /// Not asked for yet.
    #[default]
    Unasked,
    /// The headset has none for it.
    Refused,
    /// Of so many pixels.
    Made(QuadId, vk::Extent2D),
}

/// A panel's quad, and whether it shows all that was painted.
#[derive(Clone, Copy, Debug, Default)]
struct Layer {
    quad: Quad,
    copied: bool,
}

/// See the module.
#[derive(Debug, Default)]
pub(super) struct Layers {
    /// By the panels' slots.
    all: [Layer; MOST_PANELS],
}

impl Layers {
    /// What a panel shows has changed.
    pub(super) fn painted(&mut self, slot: usize) {
        if let Some(layer) = self.all.get_mut(slot) {
            layer.copied = false;
        }
    }

    /// Lifts all panels that can be lifted out of the next draw, and shows them by the headset, in a frame that has begun;
    /// without a place of the room (on the stage) it puts them back.
    pub(super) fn lift(
        &mut self,
        headset: &mut dyn Headset,
        renderer: &mut Renderer,
        scene: &Scene,
        room: Option<&Affine3A>,
        views: &[View; 2],
    ) -> Result<(), HeadsetError> {
        let eye = (views[0].pose.position + views[1].pose.position) * 0.5;
        let mut places = [None; MOST_PANELS];
        for panel in room.is_some().then(|| panels(scene)).into_iter().flatten() {
            if let (Some(place), Some(room)) = (places.get_mut(panel.slot), room) {
                *place = in_room(&panel, room, eye);
            }
        }
        for (slot, (layer, place)) in self.all.iter_mut().zip(places).enumerate() {
            let extent = renderer.panel_extent(slot);
            let shown = match place.zip(extent) {
                Some((place, extent)) => layer
                    .fill(headset, renderer, slot, extent)?
                    .then_some(place),
                None => None,
            };
            if let Quad::Made(quad, _) = layer.quad {
                headset.place_quad(quad, shown);
            }
            renderer.lift_panel(slot, shown.is_some());
        }
        Ok(())
    }
}

impl Layer {
    /// Makes the quad show the panel's picture; false where it cannot.
    fn fill(
        &mut self,
        headset: &mut dyn Headset,
        renderer: &mut Renderer,
        slot: usize,
        extent: vk::Extent2D,
    ) -> Result<bool, HeadsetError> {
        if self.quad == Quad::Unasked {
            self.quad = headset
                .make_quad(extent)?
                .map_or(Quad::Refused, |quad| Quad::Made(quad, extent));
        }
        // One whose picture has got another size goes back into the scene: quads are made for good.
        let Quad::Made(quad, size) = self.quad else {
            return Ok(false);
        };
        if size != extent {
            return Ok(false);
        }
        if !self.copied
            && let Some(index) = headset.acquire_quad(quad)?
            && let Some(images) = headset.quad_images(quad)
            && let Some(image) = LayerImage::of_quad(images, index)
        {
            renderer.copy_panel(slot, image);
            self.copied = true;
        }
        Ok(self.copied)
    }
}

/// Where a panel is in the room, of which the stage knows the place; none where the eye sees its back, which quads do not have.
fn in_room(panel: &PlacedPanel, stage_from_room: &Affine3A, eye: Vec3) -> Option<QuadPlace> {
    let eye = panel.world_from_panel.inverse().transform_point3(eye);
    let room_from_panel = stage_from_room.inverse() * panel.world_from_panel;
    let (scale, orientation, position) = room_from_panel.to_scale_rotation_translation();
    let place = QuadPlace {
        pose: Pose {
            orientation,
            position,
        },
        size: [panel.size[0] * scale.x, panel.size[1] * scale.y],
    };
    (eye.z > 0.0 && place.is_sane()).then_some(place)
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that stops says enough by stopping"
    )]

    use ramus_xr::quad::QuadImages;
    use ramus_xr::simulated::Simulated;
    use ramus_xr::{Frame, Tick};

    use super::*;
    use crate::app::again::may_come_back;
    use crate::app::demonstration;
    use crate::app::picture::Picture;
    use crate::app::session::{self, Nobody, SessionEnd};
    use crate::app::workshop::Workshop;
    use crate::render::Gpu;
    use crate::render::layer_tests::counting::allocations;
    use crate::render::layer_tests::{Readable, device};
    use crate::world::{World, history::History};

    const EYE: vk::Extent2D = vk::Extent2D {
        width: 96,
        height: 96,
    };

    /// What a runtime keeps of its quads.
    struct Runtime {
        gpu: Gpu,
        most: usize,
        quads: Vec<(Readable, Option<QuadPlace>)>,
        acquired: usize,
        /// How many more frames there are before it is lost.
        left: Option<usize>,
        /// Allocations of this thread up to each frame.
        allocated: Vec<u64>,
    }

    impl Runtime {
        fn new(gpu: Gpu, most: usize) -> Self {
            Self {
                gpu,
                most,
                quads: Vec::new(),
                acquired: 0,
                left: None,
                allocated: Vec::with_capacity(1000),
            }
        }
    }

    /// The simulated headset with quads.
    struct WithQuads<'a> {
        inner: Simulated,
        runtime: &'a mut Runtime,
    }

    impl Headset for WithQuads<'_> {
        ramus_xr::forward_headset!(inner: describe, extent, swapchain, begin, views, end, vibrate, request_exit);

        fn wait(&mut self) -> Result<Tick, HeadsetError> {
            self.runtime.allocated.push(allocations());
            if let Some(left) = &mut self.runtime.left {
                let lost = || HeadsetError::Lost("it is gone".to_owned());
                *left = left.checked_sub(1).ok_or_else(lost)?;
            }
            self.inner.wait()
        }

        fn make_quad(&mut self, extent: vk::Extent2D) -> Result<Option<QuadId>, HeadsetError> {
            let quads = &mut self.runtime.quads;
            if quads.len() == self.runtime.most {
                return Ok(None);
            }
            let format = vk::Format::R8G8B8A8_SRGB;
            quads.push((Readable::new(&self.runtime.gpu, format, extent), None));
            Ok(Some(QuadId::new(quads.len() - 1)))
        }

        fn quad_images(&self, quad: QuadId) -> Option<&QuadImages> {
            Some(&self.runtime.quads.get(quad.number())?.0.images)
        }

        fn acquire_quad(&mut self, _quad: QuadId) -> Result<Option<usize>, HeadsetError> {
            self.runtime.acquired += 1;
            Ok(Some(0))
        }

        fn place_quad(&mut self, quad: QuadId, place: Option<QuadPlace>) {
            self.runtime.quads[quad.number()].1 = place;
        }
    }

    /// The board, the bench and the tutorial in a room.
    struct Room {
        workshop: Workshop,
        picture: Picture,
        runtime: Runtime,
        frame: Frame,
    }

    impl Room {
        fn new(most: usize) -> Option<Self> {
            let gpu = device()?;
            let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
            workshop.teach(0);
            Some(Self {
                workshop,
                picture: Picture::offscreen(&gpu, EYE.width, EYE.height).unwrap(),
                runtime: Runtime::new(gpu, most),
                frame: demonstration::first_tree().unwrap()[0],
            })
        }

        /// Some frames with the panels as layers or in the scene, lifted by so many metres; what is seen then.
        fn see(&mut self, layers: bool, lift: f32) -> [image::RgbaImage; 2] {
            let mut settings = self.workshop.settings();
            settings.layers = layers;
            settings.room.lift = lift;
            self.workshop.set(settings);
            self.play(10).unwrap();
            self.picture.read(None).unwrap()
        }

        /// So many frames in which the head moves about a little.
        fn play(&mut self, count: u8) -> Result<(), SessionEnd> {
            let frames = (1..=count).map(|number| {
                let mut frame = self.frame;
                frame.time += f64::from(number) / 72.0;
                let last = number == count;
                frame.head.position.x += if last { 0.0 } else { 0.001 * f32::from(number) };
                frame
            });
            let frames: Vec<_> = frames.collect();
            self.frame.time = frames[frames.len() - 1].time;
            let mut headset = WithQuads {
                inner: Simulated::new(frames, EYE),
                runtime: &mut self.runtime,
            };
            let picture = Some(&mut self.picture);
            session::run(&mut headset, &mut self.workshop, picture, &mut Nobody)
        }

        /// What a lost session does to the workshop, and everything that belongs to the runtime made anew.
        fn come_back(&mut self) {
            self.workshop.let_go();
            let gpu = self.runtime.gpu.clone();
            self.picture = Picture::offscreen(&gpu, EYE.width, EYE.height).unwrap();
            self.runtime = Runtime::new(gpu, self.runtime.most);
        }

        /// How much of each quad is painted, from 0 to 1.
        fn paper(&self) -> Vec<f64> {
            let painted = self.runtime.quads.iter().map(|(quad, _)| {
                let picture = quad.read();
                let paper = picture.pixels().filter(|pixel| pixel.0[3] == 255).count();
                #[allow(clippy::cast_precision_loss, reason = "few pixels")]
                let part = paper as f64 / picture.pixels().len() as f64;
                part
            });
            painted.collect()
        }

        /// The same scene without its panels, drawn by a picture of its own.
        fn bare(&mut self) -> [image::RgbaImage; 2] {
            let views = self.workshop.on_stage(self.frame.views);
            let mut scene = self.workshop.scene().clone();
            scene.board = None;
            scene.panels.clear();
            let gpu = &self.runtime.gpu;
            let mut picture = Picture::offscreen(gpu, EYE.width, EYE.height).unwrap();
            picture.draw_whole(&scene, &views, None).unwrap();
            picture.read(None).unwrap()
        }

        fn shown(&self) -> Vec<Vec3> {
            let places = self.runtime.quads.iter().filter_map(|(_, place)| *place);
            places.map(|place| place.pose.position).collect()
        }

        fn silent(self) {
            drop(self.picture);
            let gpu = &self.runtime.gpu;
            assert_eq!(gpu.messages().list(), Vec::<String>::new(), "validation");
        }
    }

    #[test]
    fn panels_leave_the_scene_for_layers_and_come_back() {
        let Some(mut room) = Room::new(8) else { return };
        let with = room.see(false, 0.0);
        assert!(room.runtime.quads.is_empty(), "off until it is asked for");
        let bare = room.bare();
        assert_ne!(with, bare);

        let without = room.see(true, 0.0);
        assert_eq!(without, room.bare(), "no slab is left in the scene");
        let stage = room.workshop.scene().clone();
        let centers: Vec<Vec3> = panels(&stage)
            .map(|panel| panel.world_from_panel.translation.into())
            .collect();
        assert_eq!(centers.len(), 3, "board, bench and tutorial");
        assert_eq!(room.shown(), centers, "where they stood");
        assert!(
            room.paper().iter().all(|&part| part > 0.9),
            "{:?}",
            room.paper()
        );
        let acquired = room.runtime.acquired;
        assert!(acquired < 10, "copied when painted only: {acquired} times");

        // People who are lifted see them lower in their room.
        room.see(true, 0.25);
        for (shown, center) in room.shown().into_iter().zip(&centers) {
            assert!((shown - (*center - Vec3::Y * 0.25)).length() < 1e-5);
        }

        let again = room.see(false, 0.0);
        assert_eq!(room.shown(), [], "hidden");
        assert_eq!(again, with);
        assert_eq!(room.runtime.quads.len(), 3, "kept");
        room.see(true, 0.0);
        assert_eq!(room.shown(), centers);
        assert_eq!(room.runtime.quads.len(), 3, "and used again");
        room.silent();
    }

    #[test]
    fn after_a_loss_layers_are_made_anew_and_show_the_panels() {
        let Some(mut room) = Room::new(8) else { return };
        let seen = room.see(true, 0.0);
        let (shown, paper) = (room.shown(), room.paper());
        assert_eq!(shown.len(), 3);
        for at in [0, 1, 5] {
            room.runtime.left = Some(at);
            let end = room.play(20).unwrap_err();
            assert!(may_come_back(&end), "{end}");
            room.come_back();
            assert_eq!(room.see(true, 0.0), seen, "the scene without panels");
            assert_eq!((room.shown(), room.paper()), (shown.clone(), paper.clone()));
        }
        room.silent();
    }

    #[test]
    fn a_warm_frame_with_layers_allocates_nothing() {
        let Some(mut room) = Room::new(8) else { return };
        room.see(true, 0.0);
        assert_eq!(room.shown().len(), 3);
        room.runtime.allocated.clear();
        room.play(60).unwrap();
        let warm = &room.runtime.allocated[20..60];
        assert_eq!(warm[39] - warm[0], 0, "allocations in 39 frames");
        let before = allocations();
        drop(std::hint::black_box(Box::new(before)));
        assert!(allocations() > before, "the counter counts");
        room.silent();
    }

    #[test]
    fn panels_for_which_there_is_no_quad_stay_in_the_scene() {
        for most in [0, 1] {
            let Some(mut room) = Room::new(most) else {
                return;
            };
            let seen = room.see(true, 0.0);
            assert_eq!(room.shown().len(), most);
            assert_ne!(seen, room.bare());
            let all = room.see(false, 0.0);
            assert_eq!(all == seen, most == 0);
            room.silent();
        }
    }

    #[test]
    fn a_panel_is_placed_in_the_room_and_only_for_who_sees_its_face() {
        let panel = PlacedPanel {
            slot: 1,
            world_from_panel: Affine3A::from_translation(Vec3::new(0.0, 1.0, -1.0)),
            size: [0.6, 0.4],
        };
        // The room is turned to the left and stands aside.
        let turn = glam::Quat::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let room = Affine3A::from_rotation_translation(turn, Vec3::new(2.0, 0.5, 0.0));
        let place = in_room(&panel, &room, Vec3::new(0.0, 1.6, 0.0)).unwrap();
        assert_eq!(place.size, [0.6, 0.4]);
        let back = room.transform_point3(place.pose.position);
        assert!(back.distance(Vec3::new(0.0, 1.0, -1.0)) < 1e-6);
        let face = turn * (place.pose.orientation * Vec3::Z);
        assert!(face.distance(Vec3::Z) < 1e-6);
        assert!(in_room(&panel, &room, Vec3::new(0.0, 1.6, -1.2)).is_none());
        let nowhere = PlacedPanel {
            world_from_panel: Affine3A::from_translation(Vec3::NAN),
            ..panel
        };
        assert!(in_room(&nowhere, &room, Vec3::ZERO).is_none());
    }
}
