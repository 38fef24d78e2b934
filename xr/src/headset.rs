//! [`Headset`]: any device that shows both eyes and tracks both hands.

use std::time::Duration;

use ash::vk;

use crate::frame::{Frame, Pulse, View};
use crate::mask::VisibilityMask;
use crate::profiles::Profile;
use crate::quad::{QuadId, QuadImages, QuadPlace};
use crate::session::SessionError;
use crate::vulkan::Swapchain;

/// What [`Headset::wait`] found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "one value a frame, on the stack")]
pub enum Tick {
    /// A frame to show: call `begin`, draw, then `end`.
    Frame(Frame),
    /// No session is running now (not yet visible, or put aside): poll again soon.
    Idle,
    /// The person or the runtime ended the session in good order.
    Exit,
}

/// Which swapchain images to draw into this frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acquired {
    /// Index into [`Swapchain::color`].
    pub color: usize,
    /// Index into [`Swapchain::depth`], where there are depth images.
    pub depth: Option<usize>,
}

/// Why a headset cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum HeadsetError {
    /// The runtime died or the session was lost; work must be saved and the headset made anew.
    #[error("the OpenXR runtime ended the session ({0}): start the runtime again, then Ramus")]
    Lost(String),
    /// The session file that is being played is broken.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A call failed for another reason.
    #[error("the headset failed: {0}")]
    Failed(String),
}

/// A headset, from the application's side. Order of calls in each round:
/// `wait`, then, if it gave a frame, `begin`, drawing, `end`.
pub trait Headset {
    /// One line for people: runtime and device.
    fn describe(&self) -> String;
    /// Pixels of one eye.
    fn extent(&self) -> vk::Extent2D;
    /// The runtime's images; `None` where the application draws into its own.
    fn swapchain(&self) -> Option<&Swapchain>;
    /// Polls events, waits for the next frame and reads the input for it.
    ///
    /// # Errors
    /// [`HeadsetError`] when the session cannot go on.
    fn wait(&mut self) -> Result<Tick, HeadsetError>;
    /// Begins the frame and acquires its images (`None`: nothing to draw into, or the images are the application's).
    ///
    /// # Errors
    /// [`HeadsetError`] when the session cannot go on.
    fn begin(&mut self) -> Result<Option<Acquired>, HeadsetError>;
    /// Views for the frame begun, located as late as possible; they are the ones that `end` submits.
    ///
    /// # Errors
    /// [`HeadsetError`] when the session cannot go on.
    fn views(&mut self) -> Result<[View; 2], HeadsetError>;
    /// Releases the images and ends the frame; `rendered` false submits no layer.
    ///
    /// # Errors
    /// [`HeadsetError`] when the session cannot go on.
    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError>;
    /// Vibrates a controller; silent while unfocused.
    fn vibrate(&mut self, pulse: Pulse);
    /// What the left and the right hand hold, as far as it is known.
    fn controllers(&self) -> [Option<&'static Profile>; 2] {
        [None; 2]
    }
    /// Whether somebody wears the headset, as far as the device knows. While nobody does, its frames have neither focus
    /// nor hands; what was made should be saved when it is taken off.
    fn worn(&self) -> bool {
        true
    }
    /// What the eyes cannot see of their pictures; none where all is seen or nothing is known.
    fn visibility_mask(&self) -> Option<&VisibilityMask> {
        None
    }
    /// Makes a flat picture of so many pixels that the runtime shows by itself (see [`crate::quad`]); none where the
    /// headset has no room for one: then the application draws it into the scene.
    ///
    /// # Errors
    /// [`HeadsetError`] when the session cannot go on.
    fn make_quad(&mut self, _extent: vk::Extent2D) -> Result<Option<QuadId>, HeadsetError> {
        Ok(None)
    }
    /// The images of a quad; none for a quad of another headset.
    fn quad_images(&self, _quad: QuadId) -> Option<&QuadImages> {
        None
    }
    /// Acquires a quad's next image, between `begin` and `end`, and says which it is; `end` releases it.
    ///
    /// # Errors
    /// [`HeadsetError`] when the session cannot go on.
    fn acquire_quad(&mut self, _quad: QuadId) -> Result<Option<usize>, HeadsetError> {
        Ok(None)
    }
    /// How long each picture is shown, where somebody sees it as it is drawn: pictures that take longer come late. None where the session is one that was
    /// recorded, or nobody waits.
    fn period(&self) -> Option<Duration> {
        None
    }
    /// From the next `end` on only so many pixels of each eye's picture were drawn, and are shown as large as all of it: from the first on. Until then, all.
    fn show_part(&mut self, _extent: vk::Extent2D) {}
    /// Where a quad is from the next `end` on; none hides it. One whose place is not sane is hidden too.
    fn place_quad(&mut self, _quad: QuadId, _place: Option<QuadPlace>) {}
    /// Asks the session to end in good order; [`Tick::Exit`] follows.
    fn request_exit(&mut self);
}

/// Writes those methods of [`Headset`] that a headset around a headset leaves to the one inside, which is its field
/// `$inner`; `device` stands for all that only a device knows: controllers, whether it is worn, mask and quads; `rate` for what holds its rate. What it
/// does itself stands beside them:
///
/// ```
/// use ramus_xr::{Frame, Headset, HeadsetError, Tick};
///
/// struct Counted<H> {
///     inner: H,
///     frames: usize,
/// }
///
/// impl<H: Headset> Headset for Counted<H> {
///     ramus_xr::forward_headset!(inner: describe, extent, swapchain, begin, views, end, vibrate, device, request_exit);
///
///     fn wait(&mut self) -> Result<Tick, HeadsetError> {
///         let tick = self.inner.wait()?;
///         self.frames += usize::from(matches!(tick, Tick::Frame(_)));
///         Ok(tick)
///     }
/// }
/// ```
#[macro_export]
macro_rules! forward_headset {
    (@ $inner:ident describe) => {
        fn describe(&self) -> String {
            $crate::Headset::describe(&self.$inner)
        }
    };
    (@ $inner:ident extent) => {
        fn extent(&self) -> $crate::ash::vk::Extent2D {
            $crate::Headset::extent(&self.$inner)
        }
    };
    (@ $inner:ident swapchain) => {
        fn swapchain(&self) -> Option<&$crate::Swapchain> {
            $crate::Headset::swapchain(&self.$inner)
        }
    };
    (@ $inner:ident wait) => {
        fn wait(&mut self) -> Result<$crate::Tick, $crate::HeadsetError> {
            $crate::Headset::wait(&mut self.$inner)
        }
    };
    (@ $inner:ident begin) => {
        fn begin(&mut self) -> Result<Option<$crate::Acquired>, $crate::HeadsetError> {
            $crate::Headset::begin(&mut self.$inner)
        }
    };
    (@ $inner:ident views) => {
        fn views(&mut self) -> Result<[$crate::View; 2], $crate::HeadsetError> {
            $crate::Headset::views(&mut self.$inner)
        }
    };
    (@ $inner:ident end) => {
        fn end(&mut self, rendered: bool) -> Result<(), $crate::HeadsetError> {
            $crate::Headset::end(&mut self.$inner, rendered)
        }
    };
    (@ $inner:ident vibrate) => {
        fn vibrate(&mut self, pulse: $crate::Pulse) {
            $crate::Headset::vibrate(&mut self.$inner, pulse);
        }
    };
    (@ $inner:ident device) => {
        fn controllers(&self) -> [Option<&'static $crate::profiles::Profile>; 2] {
            $crate::Headset::controllers(&self.$inner)
        }
        fn worn(&self) -> bool {
            $crate::Headset::worn(&self.$inner)
        }
        fn visibility_mask(&self) -> Option<&$crate::VisibilityMask> {
            $crate::Headset::visibility_mask(&self.$inner)
        }
        fn make_quad(
            &mut self,
            extent: $crate::ash::vk::Extent2D,
        ) -> Result<Option<$crate::quad::QuadId>, $crate::HeadsetError> {
            $crate::Headset::make_quad(&mut self.$inner, extent)
        }
        fn quad_images(&self, quad: $crate::quad::QuadId) -> Option<&$crate::quad::QuadImages> {
            $crate::Headset::quad_images(&self.$inner, quad)
        }
        fn acquire_quad(
            &mut self,
            quad: $crate::quad::QuadId,
        ) -> Result<Option<usize>, $crate::HeadsetError> {
            $crate::Headset::acquire_quad(&mut self.$inner, quad)
        }
        fn place_quad(&mut self, quad: $crate::quad::QuadId, place: Option<$crate::quad::QuadPlace>) {
            $crate::Headset::place_quad(&mut self.$inner, quad, place);
        }
    };
    (@ $inner:ident rate) => {
        fn period(&self) -> Option<std::time::Duration> {
            $crate::Headset::period(&self.$inner)
        }
        fn show_part(&mut self, extent: $crate::ash::vk::Extent2D) {
            $crate::Headset::show_part(&mut self.$inner, extent);
        }
    };
    (@ $inner:ident request_exit) => {
        fn request_exit(&mut self) {
            $crate::Headset::request_exit(&mut self.$inner);
        }
    };
    ($inner:ident: $($method:ident),+) => {
        $($crate::forward_headset!(@ $inner $method);)+
    };
}

/// A headset that is chosen while the program runs can be recorded and played as any other.
impl<H: Headset + ?Sized> Headset for Box<H> {
    fn describe(&self) -> String {
        (**self).describe()
    }

    fn extent(&self) -> vk::Extent2D {
        (**self).extent()
    }

    fn swapchain(&self) -> Option<&Swapchain> {
        (**self).swapchain()
    }

    fn wait(&mut self) -> Result<Tick, HeadsetError> {
        (**self).wait()
    }

    fn begin(&mut self) -> Result<Option<Acquired>, HeadsetError> {
        (**self).begin()
    }

    fn views(&mut self) -> Result<[View; 2], HeadsetError> {
        (**self).views()
    }

    fn end(&mut self, rendered: bool) -> Result<(), HeadsetError> {
        (**self).end(rendered)
    }

    fn vibrate(&mut self, pulse: Pulse) {
        (**self).vibrate(pulse);
    }

    fn controllers(&self) -> [Option<&'static Profile>; 2] {
        (**self).controllers()
    }

    fn worn(&self) -> bool {
        (**self).worn()
    }

    fn visibility_mask(&self) -> Option<&VisibilityMask> {
        (**self).visibility_mask()
    }

    fn make_quad(&mut self, extent: vk::Extent2D) -> Result<Option<QuadId>, HeadsetError> {
        (**self).make_quad(extent)
    }

    fn quad_images(&self, quad: QuadId) -> Option<&QuadImages> {
        (**self).quad_images(quad)
    }

    fn acquire_quad(&mut self, quad: QuadId) -> Result<Option<usize>, HeadsetError> {
        (**self).acquire_quad(quad)
    }

    fn period(&self) -> Option<Duration> {
        (**self).period()
    }

    fn show_part(&mut self, extent: vk::Extent2D) {
        (**self).show_part(extent);
    }

    fn place_quad(&mut self, quad: QuadId, place: Option<QuadPlace>) {
        (**self).place_quad(quad, place);
    }

    fn request_exit(&mut self) {
        (**self).request_exit();
    }
}
