//! The runtime's images: one array of two layers for colour, one for depth, and one layer for each quad.

use std::ptr;

use ::openxr as xr;
use ash::vk::{self, Handle as _};

use super::call::{Called as _, check};
use super::connect::ConnectError;
use crate::headset::HeadsetError;

/// Left and right eye.
pub(super) const BOTH_EYES: u32 = 2;

/// One wait for an image, in nanoseconds, and how many are tried before the runtime counts as lost.
const WAIT: i64 = 1_000_000_000;
const WAITS: u32 = 10;

/// Colour formats that Ramus draws, all 8-bit sRGB: what is drawn is linear, what is stored is encoded by the GPU.
const COLORS: [vk::Format; 2] = [vk::Format::R8G8B8A8_SRGB, vk::Format::B8G8R8A8_SRGB];

/// The depth format that Ramus draws: reversed depth needs floats.
const DEPTH: vk::Format = vk::Format::D32_SFLOAT;

/// The formats for colour, and for depth where `depth` asks for it: the first of the runtime's list, which is in its
/// order of preference, that we draw.
pub(super) fn choose_formats(
    session: &xr::Session<xr::Vulkan>,
    depth: bool,
) -> Result<(vk::Format, Option<vk::Format>), ConnectError> {
    let offered = session
        .enumerate_swapchain_formats()
        .called("xrEnumerateSwapchainFormats")?;
    choose(&offered, depth).ok_or(ConnectError::NoFormat)
}

fn choose(offered: &[u32], depth: bool) -> Option<(vk::Format, Option<vk::Format>)> {
    let first = |wanted: &[vk::Format]| {
        let mut formats = offered
            .iter()
            .filter_map(|&format| i32::try_from(format).ok())
            .map(vk::Format::from_raw);
        formats.find(|format| wanted.contains(format))
    };
    Some((first(&COLORS)?, if depth { first(&[DEPTH]) } else { None }))
}

/// A swapchain and which of its images is ours now.
pub(super) struct Chain {
    swapchain: xr::Swapchain<xr::Vulkan>,
    session: xr::Session<xr::Vulkan>,
    pub(super) images: Vec<vk::Image>,
    acquired: Option<usize>,
}

impl Chain {
    pub(super) fn new(
        session: &xr::Session<xr::Vulkan>,
        format: vk::Format,
        usage: xr::SwapchainUsageFlags,
        extent: vk::Extent2D,
        layers: u32,
    ) -> Result<Self, HeadsetError> {
        let swapchain = session
            .create_swapchain(&xr::SwapchainCreateInfo {
                create_flags: xr::SwapchainCreateFlags::EMPTY,
                usage_flags: usage,
                format: u32::try_from(format.as_raw()).unwrap_or_default(),
                sample_count: 1,
                width: extent.width,
                height: extent.height,
                face_count: 1,
                array_size: layers,
                mip_count: 1,
            })
            .called("xrCreateSwapchain")?;
        let images = swapchain
            .enumerate_images()
            .called("xrEnumerateSwapchainImages")?;
        let images = images.into_iter().map(vk::Image::from_raw).collect();
        Ok(Self {
            swapchain,
            session: session.clone(),
            images,
            acquired: None,
        })
    }

    /// Acquires the next image and waits until the compositor has finished with it.
    pub(super) fn acquire(&mut self) -> Result<usize, HeadsetError> {
        if let Some(image) = self.acquired {
            return Ok(image);
        }
        let fp = self.session.instance().fp();
        let mut index = 0;
        // SAFETY: the swapchain is alive and `index` is written to.
        let code = unsafe {
            (fp.acquire_swapchain_image)(self.swapchain.as_raw(), ptr::null(), &mut index)
        };
        check("xrAcquireSwapchainImage", code)?;
        let image = index as usize;
        if image >= self.images.len() {
            return Err(HeadsetError::Failed(format!(
                "the runtime gave image {image} of {}",
                self.images.len()
            )));
        }
        let info = xr::sys::SwapchainImageWaitInfo {
            ty: xr::sys::SwapchainImageWaitInfo::TYPE,
            next: ptr::null(),
            timeout: xr::Duration::from_nanos(WAIT),
        };
        for _ in 0..WAITS {
            // SAFETY: the swapchain is alive and the struct is initialised.
            let code = unsafe { (fp.wait_swapchain_image)(self.swapchain.as_raw(), &info) };
            if check("xrWaitSwapchainImage", code)? != xr::sys::Result::TIMEOUT_EXPIRED {
                self.acquired = Some(image);
                return Ok(image);
            }
        }
        Err(HeadsetError::Lost(String::from(
            "it did not give an image back within 10 s",
        )))
    }

    /// Gives the image to the compositor; false where there was none.
    pub(super) fn release(&mut self) -> Result<bool, HeadsetError> {
        let acquired = self.acquired.take().is_some();
        if acquired {
            let fp = self.session.instance().fp();
            // SAFETY: the swapchain is alive, and an image was acquired and waited for.
            let code =
                unsafe { (fp.release_swapchain_image)(self.swapchain.as_raw(), ptr::null()) };
            check("xrReleaseSwapchainImage", code)?;
        }
        Ok(acquired)
    }

    /// One eye's part, for a layer; of a quad's images all.
    pub(super) fn part(&self, eye: u32, extent: vk::Extent2D) -> xr::sys::SwapchainSubImage {
        xr::sys::SwapchainSubImage {
            swapchain: self.swapchain.as_raw(),
            image_rect: xr::Rect2Di {
                offset: xr::Offset2Di { x: 0, y: 0 },
                extent: xr::Extent2Di {
                    width: i32::try_from(extent.width).unwrap_or(i32::MAX),
                    height: i32::try_from(extent.height).unwrap_or(i32::MAX),
                },
            },
            image_array_index: eye,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the table says it")]

    use super::*;

    fn raw(formats: &[vk::Format]) -> Vec<u32> {
        formats
            .iter()
            .map(|format| format.as_raw().unsigned_abs())
            .collect()
    }

    #[test]
    fn the_runtimes_first_good_format_is_taken() {
        use vk::Format as F;
        let (rgba, bgra) = (F::R8G8B8A8_SRGB, F::B8G8R8A8_SRGB);
        let hdr = F::R16G16B16A16_SFLOAT;
        for (offered, depth, chosen) in [
            (
                &[hdr, bgra, rgba, F::D32_SFLOAT][..],
                true,
                Some((bgra, Some(F::D32_SFLOAT))),
            ),
            (&[F::D16_UNORM, rgba, bgra], true, Some((rgba, None))),
            (&[rgba, F::D32_SFLOAT], false, Some((rgba, None))),
            (&[hdr, F::R8G8B8A8_UNORM], true, None),
            (&[], true, None),
        ] {
            assert_eq!(choose(&raw(offered), depth), chosen, "{offered:?}");
        }
        assert_eq!(choose(&[u32::MAX], true), None);
    }
}
