//! Headsets: what a frame of virtual reality is, whichever device gives it.
//!
//! [`Headset`] hides which one is there: an OpenXR runtime (`openxr`), the
//! built-in simulated one (`simulated`) that plays a recorded session, or a
//! recording around either. The application cannot tell them apart.

use ash::vk;
use glam::{Quat, Vec2, Vec3};

/// A position in metres and an orientation, in the stage's frame (Y up, −Z ahead, floor at 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Unit quaternion.
    pub orientation: Quat,
    /// Metres.
    pub position: Vec3,
}

impl Pose {
    /// At the origin, unturned.
    pub const IDENTITY: Self = Self {
        orientation: Quat::IDENTITY,
        position: Vec3::ZERO,
    };
}

/// Half angles of a view in radians; left and down are usually negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fov {
    /// Left edge.
    pub left: f32,
    /// Right edge.
    pub right: f32,
    /// Upper edge.
    pub up: f32,
    /// Lower edge.
    pub down: f32,
}

/// One eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The eye's pose in the stage's frame.
    pub pose: Pose,
    /// What it sees.
    pub fov: Fov,
}

/// One hand's controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Whether the controller is tracked now.
    pub tracked: bool,
    /// Pointing pose: the ray goes along −Z.
    pub aim: Pose,
    /// Centre of the hand.
    pub grip: Pose,
    /// 0 to 1.
    pub trigger: f32,
    /// 0 to 1.
    pub squeeze: f32,
    /// x right, y up, −1 to 1.
    pub stick: Vec2,
    /// A on the right, X on the left.
    pub lower: bool,
    /// B on the right, Y on the left.
    pub upper: bool,
}

/// Everything that a headset says of one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Predicted display time in seconds since the session began; never decreases, never jumps by more than 0.1 s.
    pub time: f64,
    /// Input is ours.
    pub focused: bool,
    /// False: begin and end the frame but draw nothing.
    pub should_render: bool,
    /// The head.
    pub head: Pose,
    /// Left eye, right eye.
    pub views: [View; 2],
    /// Left hand, right hand.
    pub hands: [Hand; 2],
}

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

/// The runtime's images for both eyes: arrays of two layers, left eye first.
#[derive(Clone, Debug)]
pub struct Swapchain {
    /// Colour images (two layers each).
    pub color: Vec<vk::Image>,
    /// Colour format, an 8-bit sRGB one.
    pub color_format: vk::Format,
    /// Depth images (two layers each), empty where the runtime takes no depth layer.
    pub depth: Vec<vk::Image>,
    /// Depth format, `UNDEFINED` where there are no depth images.
    pub depth_format: vk::Format,
    /// Width and height of one eye in pixels.
    pub extent: vk::Extent2D,
}

/// Which swapchain images to draw into this frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acquired {
    /// Index into [`Swapchain::color`].
    pub color: usize,
    /// Index into [`Swapchain::depth`], where there are depth images.
    pub depth: Option<usize>,
}

/// A vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pulse {
    /// 0 left, 1 right.
    pub hand: usize,
    /// Seconds.
    pub duration: f32,
    /// 0 to 1.
    pub amplitude: f32,
}

/// Why a headset cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum HeadsetError {
    /// The runtime died or the session was lost; work must be saved and the headset made anew.
    #[error(
        "the OpenXR runtime ended the session ({0}); your work is saved: start the runtime again, then Ramus"
    )]
    Lost(String),
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
    /// Asks the session to end in good order; [`Tick::Exit`] follows.
    fn request_exit(&mut self);
}
