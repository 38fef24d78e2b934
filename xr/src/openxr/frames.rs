//! The three calls of a frame.

use std::ptr;
use std::time::Duration;

use ::openxr as xr;
use ash::vk;

use super::call::check;
use super::quads::QuadLayers;
use super::space::raw_from_pose;
use super::swapchain::Chain;
use super::view::raw_from_fov;
use crate::frame::View;
use crate::headset::HeadsetError;
use crate::quad::MOST_QUADS;

/// What the runtime says of the next frame.
pub(super) struct Next {
    /// When it is shown,
    pub(super) display_time: xr::Time,
    /// and for how long.
    pub(super) period: Duration,
    /// Whether it is worth drawing.
    pub(super) should_render: bool,
}

/// Waits until the runtime wants the next frame.
pub(super) fn wait(session: &xr::Session<xr::Vulkan>) -> Result<Next, HeadsetError> {
    let mut state = xr::sys::FrameState {
        ty: xr::sys::FrameState::TYPE,
        next: ptr::null_mut(),
        predicted_display_time: xr::Time::from_nanos(0),
        predicted_display_period: xr::Duration::from_nanos(0),
        should_render: xr::sys::FALSE,
    };
    // SAFETY: the session is alive and the struct initialised; null asks for no options.
    let code =
        unsafe { (session.instance().fp().wait_frame)(session.as_raw(), ptr::null(), &mut state) };
    check("xrWaitFrame", code)?;
    let nanos = state.predicted_display_period.as_nanos();
    Ok(Next {
        display_time: state.predicted_display_time,
        period: Duration::from_nanos(u64::try_from(nanos).unwrap_or(0)),
        should_render: state.should_render.into(),
    })
}

/// Says that drawing begins.
pub(super) fn begin(session: &xr::Session<xr::Vulkan>) -> Result<(), HeadsetError> {
    // SAFETY: the session is alive; null asks for no options. The queue is not in use: this thread is its only one.
    let code = unsafe { (session.instance().fp().begin_frame)(session.as_raw(), ptr::null()) };
    // FRAME_DISCARDED is a success: the frame before was dropped, this one begins.
    check("xrBeginFrame", code).map(|_| ())
}

/// What a frame shows.
pub(super) struct Picture<'a> {
    /// The stage.
    pub(super) space: &'a xr::Space,
    /// The views that were drawn.
    pub(super) views: &'a [View; 2],
    pub(super) color: &'a Chain,
    pub(super) depth: Option<&'a Chain>,
    /// Pixels that were drawn of each eye's.
    pub(super) extent: vk::Extent2D,
    /// Distance of the near plane in metres.
    pub(super) near: f32,
    /// Flat pictures above it.
    pub(super) quads: QuadLayers,
}

/// Ends the frame with the picture as a projection layer and the quads behind it in the list, which lie above it; or with nothing. `display_time` is the very one that the
/// runtime told for this frame.
pub(super) fn end(
    session: &xr::Session<xr::Vulkan>,
    display_time: xr::Time,
    blend: xr::EnvironmentBlendMode,
    picture: Option<&Picture<'_>>,
) -> Result<(), HeadsetError> {
    let Some(picture) = picture else {
        return submit(session, display_time, blend, &[]);
    };
    // Depth is reversed and reaches to infinity: 0 is infinitely far and 1 the near plane. XR_KHR_composition_layer_depth
    // says it so: nearZ belongs to minDepth, may be infinite, and nearZ > farZ means reversed.
    let depth = picture.depth.map(|chain| {
        EYES.map(|(_, layer)| xr::sys::CompositionLayerDepthInfoKHR {
            ty: xr::sys::CompositionLayerDepthInfoKHR::TYPE,
            next: ptr::null(),
            sub_image: chain.part(layer, picture.extent),
            min_depth: 0.0,
            max_depth: 1.0,
            near_z: f32::INFINITY,
            far_z: picture.near,
        })
    });
    let views = EYES.map(|(eye, layer)| xr::sys::CompositionLayerProjectionView {
        ty: xr::sys::CompositionLayerProjectionView::TYPE,
        next: depth
            .as_ref()
            .map_or(ptr::null(), |depth| ptr::from_ref(&depth[eye]).cast()),
        pose: raw_from_pose(picture.views[eye].pose),
        fov: raw_from_fov(picture.views[eye].fov),
        sub_image: picture.color.part(layer, picture.extent),
    });
    let projection = xr::sys::CompositionLayerProjection {
        ty: xr::sys::CompositionLayerProjection::TYPE,
        next: ptr::null(),
        layer_flags: xr::CompositionLayerFlags::EMPTY,
        space: picture.space.as_raw(),
        view_count: 2,
        views: views.as_ptr(),
    };
    let mut layers = [ptr::null::<xr::sys::CompositionLayerBaseHeader>(); 1 + MOST_QUADS];
    let shown = std::iter::once(ptr::from_ref(&projection).cast())
        .chain((picture.quads.iter().flatten()).map(|quad| ptr::from_ref(quad).cast()));
    let mut count = 0;
    for (layer, pointer) in layers.iter_mut().zip(shown) {
        *layer = pointer;
        count += 1;
    }
    let layers = layers.get(..count).unwrap_or_default();
    submit(session, display_time, blend, layers)
}

/// Each eye's place in our arrays and its layer in the images.
const EYES: [(usize, u32); 2] = [(0, 0), (1, 1)];

/// The layers' structs must outlive the call.
fn submit(
    session: &xr::Session<xr::Vulkan>,
    display_time: xr::Time,
    blend: xr::EnvironmentBlendMode,
    layers: &[*const xr::sys::CompositionLayerBaseHeader],
) -> Result<(), HeadsetError> {
    let info = xr::sys::FrameEndInfo {
        ty: xr::sys::FrameEndInfo::TYPE,
        next: ptr::null(),
        display_time,
        environment_blend_mode: blend,
        layer_count: u32::try_from(layers.len()).unwrap_or_default(),
        layers: if layers.is_empty() {
            ptr::null()
        } else {
            layers.as_ptr()
        },
    };
    // SAFETY: session, swapchains and space are alive; every struct is initialised and outlives the call.
    let code = unsafe { (session.instance().fp().end_frame)(session.as_raw(), &info) };
    check("xrEndFrame", code).map(|_| ())
}
