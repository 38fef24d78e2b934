//! What the two eyes see in the runtime's images, measured against the scene.

use std::{cell::RefCell, rc::Rc};

use glam::Vec3;
use image::RgbaImage;
use ramus::app::{picture::Picture, portrait, session::Watcher, workshop::Workshop};
use ramus_xr::{Acquired, Frame, Headset, HeadsetError, View};

/// The views that were drawn last.
pub(crate) type Views = Rc<RefCell<Option<[View; 2]>>>;

/// How much a channel must differ (of 255) to count as something else seen.
const DIFFERENT: u8 = 12;

/// A headset around a headset that notes the views it gave.
pub(crate) struct Seen<H> {
    inner: H,
    views: Views,
}

impl<H: Headset> Seen<H> {
    pub(crate) fn new(inner: H, views: Views) -> Self {
        Self { inner, views }
    }
}

impl<H: Headset> Headset for Seen<H> {
    ramus_xr::forward_headset!(inner: describe, extent, swapchain, wait, begin, end, vibrate, device, request_exit);

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        let views = self.inner.views()?;
        self.views.replace(Some(views));
        Ok(views)
    }
}

/// Watches a session and keeps the newest picture of a grown tree, with the views it was drawn for.
pub(crate) struct Sight {
    views: Views,
    frames: usize,
    newest: Option<([RgbaImage; 2], [View; 2])>,
    last: Frame,
}

impl Sight {
    pub(crate) fn new(views: Views) -> Self {
        Self {
            views,
            frames: 0,
            newest: None,
            last: Frame::start(),
        }
    }

    /// Frames of the session so far.
    pub(crate) fn frames(&self) -> usize {
        self.frames
    }

    /// The newest picture, against pictures of the session's last scene drawn by ourselves for the same views,
    /// with the tree and without it.
    pub(crate) fn shows_the_tree_to_both_eyes(&self, workshop: &mut Workshop) {
        let (seen, views) = self.newest.as_ref().unwrap();
        let (width, height) = seen[0].dimensions();
        // The panels were painted for the runtime's picture; ours wants them too.
        workshop.show_anew();
        workshop.update(&self.last);
        let mut scene = workshop.scene().clone();
        let gpu = portrait::open_gpu().unwrap();
        let mut picture = Picture::offscreen(&gpu, width, height).unwrap();
        for (slot, painted) in workshop.take_painted() {
            picture.paint(slot, painted).unwrap();
        }
        picture.draw_whole(&scene, views, None).unwrap();
        let expected = picture.read(None).unwrap();
        let placed = scene.tree.take().unwrap();
        picture.draw_whole(&scene, views, None).unwrap();
        let without = picture.read(None).unwrap();

        // What the runtime's images show is what the scene is.
        for eye in 0..2 {
            let off = differing(&seen[eye], &expected[eye]).len();
            assert!(
                off * 200 < (width * height) as usize,
                "eye {eye}: {off} pixels differ from our own picture"
            );
        }
        // The tree covers something in both eyes, at the same height and at another place in each.
        let covered = [0, 1].map(|eye| differing(&seen[eye], &without[eye]));
        for (eye, pixels) in covered.iter().enumerate() {
            assert!(
                pixels.len() > 200,
                "eye {eye}: the tree covers {} pixels",
                pixels.len()
            );
        }
        assert_ne!(seen[0].as_raw(), seen[1].as_raw(), "both eyes see the same");
        let middle = covered.map(|pixels| mean(&pixels));
        assert!(
            (middle[0].1 - middle[1].1).abs() < 1.0,
            "the eyes see the tree at different heights: {middle:?}"
        );
        // Nearer things lie further right in the left eye's picture; by how much, the tree's own points say.
        let nodes = placed
            .tree
            .position
            .iter()
            .map(|point| placed.world_from_tree.transform_point3(*point));
        let disparities: Vec<f32> = nodes
            .filter_map(|point| {
                Some(column(&views[0], point, width)? - column(&views[1], point, width)?)
            })
            .collect();
        let expected = disparities.iter().sum::<f32>() / disparities.len() as f32;
        let disparity = middle[0].0 - middle[1].0;
        println!("disparity of the tree: {disparity:.2} pixels, expected {expected:.2}");
        assert!(
            expected > 0.5,
            "the tree is too far away for this test: {expected}"
        );
        assert!(
            (disparity - expected).abs() < 0.25 * expected + 0.5,
            "{disparity} instead of {expected} pixels"
        );
    }
}

impl Watcher for Sight {
    fn drawn(
        &mut self,
        workshop: &Workshop,
        picture: &Picture,
        acquired: Option<Acquired>,
    ) -> anyhow::Result<()> {
        let grown =
            workshop.document().step > 0 && !workshop.world().is_growing() && !workshop.is_busy();
        if let (true, Some(views)) = (grown, *self.views.borrow()) {
            self.newest = Some((picture.read(acquired)?, views));
        }
        Ok(())
    }

    fn ended(&mut self, _headset: &mut dyn Headset) {
        self.frames += 1;
    }

    fn wants(&mut self, _workshop: &Workshop, frame: &Frame) -> bool {
        self.last = *frame;
        true
    }
}

/// Places where two pictures differ by more than noise.
fn differing(a: &RgbaImage, b: &RgbaImage) -> Vec<(u32, u32)> {
    a.enumerate_pixels()
        .filter(|(x, y, pixel)| {
            let other = b.get_pixel(*x, *y);
            pixel
                .0
                .iter()
                .zip(other.0)
                .any(|(a, b)| a.abs_diff(b) > DIFFERENT)
        })
        .map(|(x, y, _)| (x, y))
        .collect()
}

fn mean(pixels: &[(u32, u32)]) -> (f32, f32) {
    let count = pixels.len() as f32;
    let sum = |part: fn(&(u32, u32)) -> u32| {
        pixels.iter().map(|pixel| part(pixel) as f32).sum::<f32>() / count
    };
    (sum(|pixel| pixel.0), sum(|pixel| pixel.1))
}

/// The column of the picture in which a view shows a point; `None` where it is behind or outside.
fn column(view: &View, point: Vec3, width: u32) -> Option<f32> {
    let local = view.pose.orientation.inverse() * (point - view.pose.position);
    if local.z > -0.05 {
        return None;
    }
    let (left, right) = (view.fov.left.tan(), view.fov.right.tan());
    let (down, up) = (view.fov.down.tan(), view.fov.up.tan());
    let (x, y) = (local.x / -local.z, local.y / -local.z);
    let inside = (left..right).contains(&x) && (down..up).contains(&y);
    inside.then(|| (x - left) / (right - left) * width as f32)
}
