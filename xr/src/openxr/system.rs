//! The headset before its session: what it is, and its say in making Vulkan's objects.

use std::cell::Cell;
use std::mem::transmute;
use std::rc::Rc;

use ::openxr as xr;
use ash::vk::{self, Handle as _};

use super::connect::{ConnectError, refused};
use super::headset::OpenXrHeadset;
use super::quads::QuadRoom;
use crate::lifecycle::FrameClock;
use crate::profiles::Profile;
use crate::refresh::RefreshWish;
use crate::vulkan::{VulkanDevice, VulkanHandles};

/// The one view configuration that Ramus draws.
pub(super) const STEREO: xr::ViewConfigurationType = xr::ViewConfigurationType::PRIMARY_STEREO;

/// A runtime and its headset, before a session is started.
pub struct System {
    pub(super) instance: xr::Instance,
    pub(super) id: xr::SystemId,
    /// Runtime and device, for people.
    pub(super) title: String,
    pub(super) offer: Offer,
    pub(super) blend: xr::EnvironmentBlendMode,
    pub(super) extent: vk::Extent2D,
    /// For quads.
    pub(super) room: QuadRoom,
}

/// What a runtime has that not each one has.
pub(super) struct Offer {
    /// The LOCAL_FLOOR space exists, in the core or as an extension.
    pub(super) local_floor: bool,
    /// Depth can be submitted beside colour.
    pub(super) depth: bool,
    /// It says what the lenses hide.
    pub(super) mask: bool,
    /// The refresh rate can be chosen.
    pub(super) refresh: bool,
    /// Joints of bare hands are tracked, and the gestures in them are ours to see.
    pub(super) joints: bool,
    /// Each controller has a pose in the palm of the hand.
    pub(super) palm: bool,
    /// The controllers that it knows.
    pub(super) profiles: Vec<&'static Profile>,
}

/// How to start a session.
#[derive(Clone, Debug)]
pub struct StartParams {
    /// Distance of the near plane in metres: depth 1. Depth is reversed, infinity is 0.
    pub near: f32,
    /// Pictures a second, where the runtime lets an application choose.
    pub refresh: RefreshWish,
    /// Tells the frames' times. A session that takes the place of one that was lost is given the same, so that time
    /// goes on and never back.
    pub clock: Rc<Cell<FrameClock>>,
}

impl StartParams {
    /// With the usual refresh rate and a clock of its own.
    #[must_use]
    pub fn new(near: f32) -> Self {
        Self {
            near,
            refresh: RefreshWish::default(),
            clock: Rc::default(),
        }
    }
}

impl System {
    pub(super) fn new(
        instance: xr::Instance,
        id: xr::SystemId,
        runtime: String,
        offer: Offer,
    ) -> Result<Self, ConnectError> {
        let properties = instance
            .system_properties(id)
            .map_err(|code| refused("xrGetSystemProperties", code))?;
        let name = properties.system_name;
        let views = match instance.enumerate_view_configuration_views(id, STEREO) {
            Err(xr::sys::Result::ERROR_VIEW_CONFIGURATION_TYPE_UNSUPPORTED) => {
                return Err(ConnectError::NoStereo(name));
            }
            views => views.map_err(|code| refused("xrEnumerateViewConfigurationViews", code))?,
        };
        let [left, right] = views[..] else {
            return Err(ConnectError::NoStereo(name));
        };
        let largest = properties.graphics_properties;
        let extent = vk::Extent2D {
            width: sized(
                left.recommended_image_rect_width
                    .max(right.recommended_image_rect_width),
                left.max_image_rect_width
                    .min(right.max_image_rect_width)
                    .min(largest.max_swapchain_image_width),
            ),
            height: sized(
                left.recommended_image_rect_height
                    .max(right.recommended_image_rect_height),
                left.max_image_rect_height
                    .min(right.max_image_rect_height)
                    .min(largest.max_swapchain_image_height),
            ),
        };
        let blends = instance
            .enumerate_environment_blend_modes(id, STEREO)
            .map_err(|code| refused("xrEnumerateEnvironmentBlendModes", code))?;
        // Opaque where it is offered; else the one that the runtime likes best.
        let blend = blends
            .iter()
            .copied()
            .find(|&blend| blend == xr::EnvironmentBlendMode::OPAQUE)
            .or_else(|| blends.first().copied())
            .unwrap_or(xr::EnvironmentBlendMode::OPAQUE);
        Ok(Self {
            instance,
            id,
            title: format!("{name} on {runtime}"),
            offer,
            blend,
            extent,
            room: QuadRoom::new(&largest),
        })
    }

    /// One line for people: device and runtime.
    #[must_use]
    pub fn describe(&self) -> &str {
        &self.title
    }

    /// Pixels of one eye, as the runtime recommends them.
    pub fn extent(&self) -> vk::Extent2D {
        self.extent
    }

    /// The lowest and the highest Vulkan version (as `vk::make_api_version` packs them) that the runtime works with.
    /// Must be called before [`System::create_instance`].
    ///
    /// # Errors
    /// [`ConnectError`] when the runtime refuses.
    pub fn vulkan_versions(&self) -> Result<(u32, u32), ConnectError> {
        let needed = self
            .instance
            .graphics_requirements::<xr::Vulkan>(self.id)
            .map_err(|code| refused("xrGetVulkanGraphicsRequirements2KHR", code))?;
        let packed = |version: xr::Version| {
            vk::make_api_version(
                0,
                version.major().into(),
                version.minor().into(),
                version.patch(),
            )
        };
        Ok((
            packed(needed.min_api_version_supported),
            packed(needed.max_api_version_supported),
        ))
    }

    /// Makes the Vulkan instance through the runtime, which adds the extensions that it needs.
    ///
    /// # Errors
    /// [`ConnectError`] when the runtime or Vulkan refuses.
    ///
    /// # Safety
    /// `info` and `get_instance_proc_addr` must be as `vkCreateInstance` wants them.
    pub unsafe fn create_instance(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<vk::Instance, ConnectError> {
        const CALL: &str = "xrCreateVulkanInstanceKHR";
        // SAFETY: the caller vouches for `info`; the pointer types name the same C function.
        let made = unsafe {
            self.instance.create_vulkan_instance(
                self.id,
                function(get_instance_proc_addr),
                std::ptr::from_ref(info).cast(),
            )
        };
        let handle = made_by_vulkan(CALL, made)?;
        Ok(vk::Instance::from_raw(handle as u64))
    }

    /// The physical device that the headset hangs on.
    ///
    /// # Errors
    /// [`ConnectError`] when the runtime refuses.
    ///
    /// # Safety
    /// `instance` must come from [`System::create_instance`].
    pub unsafe fn graphics_device(
        &self,
        instance: vk::Instance,
    ) -> Result<vk::PhysicalDevice, ConnectError> {
        // SAFETY: the caller vouches for the instance.
        let handle = unsafe {
            self.instance
                .vulkan_graphics_device(self.id, instance.as_raw() as _)
        }
        .map_err(|code| refused("xrGetVulkanGraphicsDevice2KHR", code))?;
        Ok(vk::PhysicalDevice::from_raw(handle as u64))
    }

    /// Makes the Vulkan device through the runtime, which adds the extensions that it needs. Chain the features one
    /// struct each: runtimes add theirs, and `PhysicalDeviceVulkan12Features` beside them is an error.
    ///
    /// # Errors
    /// [`ConnectError`] when the runtime or Vulkan refuses.
    ///
    /// # Safety
    /// `physical_device` must come from [`System::graphics_device`], the rest be as `vkCreateDevice` wants it.
    pub unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, ConnectError> {
        const CALL: &str = "xrCreateVulkanDeviceKHR";
        // SAFETY: the caller vouches for handles and `info`; the pointer types name the same C function.
        let made = unsafe {
            self.instance.create_vulkan_device(
                self.id,
                function(get_instance_proc_addr),
                physical_device.as_raw() as _,
                std::ptr::from_ref(info).cast(),
            )
        };
        let handle = made_by_vulkan(CALL, made)?;
        Ok(vk::Device::from_raw(handle as u64))
    }

    /// Starts the session and makes its images.
    ///
    /// # Errors
    /// [`ConnectError`] when the runtime refuses.
    ///
    /// # Safety
    /// The handles must come from this system and stay alive until the headset is dropped, and the device must be idle
    /// by then. Nothing else may use the queue while the headset's `begin` and `end` (or this call) run.
    pub unsafe fn start(
        self,
        vulkan: VulkanHandles,
        params: StartParams,
    ) -> Result<OpenXrHeadset, ConnectError> {
        // The runtime wants the versions asked for before a session is made, whoever made the device.
        self.vulkan_versions()?;
        // SAFETY: the caller vouches for the handles.
        unsafe { OpenXrHeadset::new(self, vulkan, params) }
    }
}

impl System {
    /// Starts the session on a device that the headset keeps alive, and makes its images.
    ///
    /// # Errors
    /// [`ConnectError`] when the runtime refuses.
    pub fn start_on(
        self,
        device: Box<dyn VulkanDevice>,
        params: StartParams,
    ) -> Result<OpenXrHeadset, ConnectError> {
        // SAFETY: the implementor vouches for the handles; the headset holds the device until it is dropped itself.
        let mut headset = unsafe { self.start(device.handles(), params) }?;
        headset.keep(device);
        Ok(headset)
    }
}

/// The recommended size, no larger than allowed; never 0, since no image is.
fn sized(recommended: u32, largest: u32) -> u32 {
    recommended.min(largest).max(1)
}

/// What a call made for which the runtime asks Vulkan: either may refuse.
fn made_by_vulkan<T>(
    call: &'static str,
    made: xr::Result<Result<T, i32>>,
) -> Result<T, ConnectError> {
    made.map_err(|code| refused(call, code))?
        .map_err(|code| ConnectError::Vulkan {
            call,
            result: vk::Result::from_raw(code),
        })
}

/// ash and the `openxr` crate name the same C function by types of their own.
fn function(pointer: vk::PFN_vkGetInstanceProcAddr) -> xr::sys::platform::VkGetInstanceProcAddr {
    // SAFETY: both are C function pointers that take a dispatchable handle (a pointer) and a string and give a function.
    unsafe {
        transmute::<vk::PFN_vkGetInstanceProcAddr, xr::sys::platform::VkGetInstanceProcAddr>(
            pointer,
        )
    }
}
