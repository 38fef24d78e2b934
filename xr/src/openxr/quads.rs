//! Quads: flat pictures with swapchains of their own, shown by the compositor above the scene.

use ::openxr as xr;
use ash::vk;

use super::space::raw_from_pose;
use super::swapchain::Chain;
use crate::headset::HeadsetError;
use crate::quad::{MOST_QUADS, QuadId, QuadImages, QuadPlace};

struct Quad {
    chain: Chain,
    images: QuadImages,
    place: Option<QuadPlace>,
    /// Whether there is a picture: before the first release there is nothing to show.
    painted: bool,
}

/// What a system has room for.
#[derive(Clone, Copy, Debug)]
pub(super) struct QuadRoom {
    /// Quads at a time.
    most: usize,
    /// Pixels of one.
    largest: vk::Extent2D,
}

impl QuadRoom {
    pub(super) fn new(properties: &xr::sys::SystemGraphicsProperties) -> Self {
        // One layer is the scene.
        let layers = properties.max_layer_count.saturating_sub(1);
        Self {
            most: usize::try_from(layers).map_or(MOST_QUADS, |layers| layers.min(MOST_QUADS)),
            largest: vk::Extent2D {
                width: properties.max_swapchain_image_width,
                height: properties.max_swapchain_image_height,
            },
        }
    }

    fn fits(&self, extent: vk::Extent2D) -> bool {
        (1..=self.largest.width).contains(&extent.width)
            && (1..=self.largest.height).contains(&extent.height)
    }
}

/// A headset's quads.
pub(super) struct Quads {
    all: Vec<Quad>,
    room: QuadRoom,
}

/// The structs of those that are shown, to be submitted behind the projection.
pub(super) type QuadLayers = [Option<xr::sys::CompositionLayerQuad>; MOST_QUADS];

impl Quads {
    pub(super) fn new(room: QuadRoom) -> Self {
        Self {
            all: Vec::new(),
            room,
        }
    }

    pub(super) fn make(
        &mut self,
        session: &xr::Session<xr::Vulkan>,
        format: vk::Format,
        extent: vk::Extent2D,
    ) -> Result<Option<QuadId>, HeadsetError> {
        if self.all.len() >= self.room.most || !self.room.fits(extent) {
            return Ok(None);
        }
        let usage = xr::SwapchainUsageFlags::COLOR_ATTACHMENT
            | xr::SwapchainUsageFlags::TRANSFER_SRC
            | xr::SwapchainUsageFlags::TRANSFER_DST
            | xr::SwapchainUsageFlags::SAMPLED;
        let chain = match Chain::new(session, format, usage, extent, 1) {
            Err(HeadsetError::Failed(why)) => {
                // The application draws the panel into the scene instead.
                tracing::warn!("no quad of {} × {}: {why}", extent.width, extent.height);
                return Ok(None);
            }
            made => made?,
        };
        // SAFETY: the swapchain was just made so, and is dropped with the headset.
        let images = unsafe { QuadImages::new(chain.images.clone(), format, extent) };
        self.all.push(Quad {
            chain,
            images,
            place: None,
            painted: false,
        });
        Ok(Some(QuadId::new(self.all.len() - 1)))
    }

    pub(super) fn images(&self, quad: QuadId) -> Option<&QuadImages> {
        self.all.get(quad.number()).map(|quad| &quad.images)
    }

    pub(super) fn acquire(&mut self, quad: QuadId) -> Result<Option<usize>, HeadsetError> {
        self.all
            .get_mut(quad.number())
            .map(|quad| quad.chain.acquire())
            .transpose()
    }

    pub(super) fn place(&mut self, quad: QuadId, place: Option<QuadPlace>) {
        if let Some(quad) = self.all.get_mut(quad.number()) {
            quad.place = place.filter(QuadPlace::is_sane);
        }
    }

    /// Gives all images that were acquired to the compositor.
    pub(super) fn release(&mut self) -> Result<(), HeadsetError> {
        for quad in &mut self.all {
            quad.painted |= quad.chain.release()?;
        }
        Ok(())
    }

    /// What is shown now, in `space`.
    pub(super) fn layers(&self, space: &xr::Space) -> QuadLayers {
        let mut layers = [None; MOST_QUADS];
        for (layer, quad) in layers.iter_mut().zip(&self.all) {
            *layer = quad.layer(space);
        }
        layers
    }
}

impl Quad {
    fn layer(&self, space: &xr::Space) -> Option<xr::sys::CompositionLayerQuad> {
        let place = self.place.filter(|_| self.painted)?;
        let [width, height] = place.size;
        Some(xr::sys::CompositionLayerQuad {
            ty: xr::sys::CompositionLayerQuad::TYPE,
            next: std::ptr::null(),
            layer_flags: xr::CompositionLayerFlags::BLEND_TEXTURE_SOURCE_ALPHA,
            space: space.as_raw(),
            eye_visibility: xr::EyeVisibility::BOTH,
            sub_image: self.chain.part(0, self.images.extent()),
            pose: raw_from_pose(place.pose.settled()),
            size: xr::Extent2Df { width, height },
        })
    }
}
