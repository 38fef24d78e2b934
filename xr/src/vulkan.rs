//! Vulkan between a headset and whoever draws for it: handles only, nothing of OpenXR.
//!
//! `XR_KHR_vulkan_enable2` wants the runtime in between for three calls, and then draws on the application's
//! device itself. The renderer knows no OpenXR and the application must not vouch for raw
//! handles, so both sides meet in these traits: [`VulkanHost`] makes the objects (a runtime, or plain Vulkan),
//! [`VulkanDevice`] is the device that was made, kept alive by the headset that uses it.

use std::error::Error;

use ash::vk;

use crate::openxr::System;

/// Why a host gave no Vulkan object: a sentence for people.
pub type HostError = Box<dyn Error + Send + Sync>;

/// Makes the Vulkan instance and device, and says which physical device it must be.
pub trait VulkanHost {
    /// The Vulkan version to ask for, given the loader's and the one that the program would like.
    fn api_version(&self, loader: u32, wanted: u32) -> u32 {
        loader.min(wanted)
    }

    /// Makes the instance.
    ///
    /// # Errors
    /// [`HostError`] when the host or the driver refuses.
    ///
    /// # Safety
    /// `info` must be valid for `vkCreateInstance`, and `get_instance_proc_addr` the loader's.
    unsafe fn create_instance(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<vk::Instance, HostError>;

    /// Chooses the physical device.
    ///
    /// # Errors
    /// [`HostError`] when there is none.
    ///
    /// # Safety
    /// `instance` must come from this host's `create_instance`.
    unsafe fn physical_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
    ) -> Result<vk::PhysicalDevice, HostError>;

    /// Makes the device.
    ///
    /// # Errors
    /// [`HostError`] when the host or the driver refuses.
    ///
    /// # Safety
    /// The handles must come from this host, and `info` be valid for `vkCreateDevice`.
    unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, HostError>;
}

/// A device that a headset may draw on.
///
/// # Safety
/// The handles must be valid, and were made by the host whose headset is started on them, for as long as the value
/// lives. Nothing may use the queue while the headset's `begin` and `end` run: keep both on one thread.
pub unsafe trait VulkanDevice {
    /// The handles.
    fn handles(&self) -> VulkanHandles;

    /// Waits until the device has nothing to do; called before the headset's images go.
    fn wait_idle(&self);
}

/// Vulkan's objects for a session. They must stay alive until the headset is dropped.
#[derive(Clone, Copy, Debug)]
pub struct VulkanHandles {
    /// From [`VulkanHost::create_instance`].
    pub instance: vk::Instance,
    /// From [`VulkanHost::physical_device`].
    pub physical_device: vk::PhysicalDevice,
    /// From [`VulkanHost::create_device`].
    pub device: vk::Device,
    /// Family of the queue that draws.
    pub queue_family: u32,
    /// The queue within its family.
    pub queue_index: u32,
}

/// The runtime's images for both eyes: arrays of two layers, left eye first. Only a headset makes one, so whoever
/// draws may rely on its images: they live as long as the headset.
#[derive(Debug)]
pub struct Swapchain {
    pub(crate) color: Vec<vk::Image>,
    pub(crate) color_format: vk::Format,
    pub(crate) depth: Vec<vk::Image>,
    pub(crate) depth_format: vk::Format,
    pub(crate) extent: vk::Extent2D,
}

impl Swapchain {
    /// Colour images (two layers each; attachment, transfer source and destination).
    #[must_use]
    pub fn color(&self) -> &[vk::Image] {
        &self.color
    }

    /// Colour format, an 8-bit sRGB one.
    #[must_use]
    pub fn color_format(&self) -> vk::Format {
        self.color_format
    }

    /// Depth images (as the colour's), empty where the runtime takes no depth layer.
    #[must_use]
    pub fn depth(&self) -> &[vk::Image] {
        &self.depth
    }

    /// Depth format, `UNDEFINED` where there are no depth images.
    #[must_use]
    pub fn depth_format(&self) -> vk::Format {
        self.depth_format
    }

    /// Width and height of one eye in pixels.
    pub fn extent(&self) -> vk::Extent2D {
        self.extent
    }
}

impl VulkanHost for System {
    fn api_version(&self, loader: u32, wanted: u32) -> u32 {
        // The runtime wants to be asked before the instance is made; where it cannot say, making it will.
        let highest = self
            .vulkan_versions()
            .map_or(wanted, |(_, highest)| highest);
        loader.min(wanted).min(highest)
    }

    unsafe fn create_instance(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<vk::Instance, HostError> {
        // SAFETY: the caller vouches for the same.
        Ok(unsafe { System::create_instance(self, get_instance_proc_addr, info) }?)
    }

    unsafe fn physical_device(
        &self,
        _get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
    ) -> Result<vk::PhysicalDevice, HostError> {
        // SAFETY: the caller vouches for the same.
        Ok(unsafe { self.graphics_device(instance) }?)
    }

    unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        _instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, HostError> {
        // SAFETY: the caller vouches for the same.
        Ok(unsafe { System::create_device(self, get_instance_proc_addr, physical_device, info) }?)
    }
}

/// The images of a quad: one layer each. Only a headset makes them, and they live as long as it.
#[derive(Debug)]
pub struct QuadImages {
    color: Vec<vk::Image>,
    format: vk::Format,
    extent: vk::Extent2D,
}

impl QuadImages {
    /// Images of a headset's quad.
    ///
    /// # Safety
    /// They must be live images of one layer, level and sample at least, of this format (an 8-bit sRGB one) and extent, usable as
    /// colour attachment and as transfer source and destination, and live as long as the headset.
    #[must_use]
    pub unsafe fn new(color: Vec<vk::Image>, format: vk::Format, extent: vk::Extent2D) -> Self {
        Self {
            color,
            format,
            extent,
        }
    }

    /// Colour images (colour attachment, transfer source and destination, sampled). Draw premultiplied alpha, and leave an
    /// image in `COLOR_ATTACHMENT_OPTIMAL`.
    #[must_use]
    pub fn color(&self) -> &[vk::Image] {
        &self.color
    }

    /// Their format, an 8-bit sRGB one.
    #[must_use]
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Width and height in pixels.
    pub fn extent(&self) -> vk::Extent2D {
        self.extent
    }
}
