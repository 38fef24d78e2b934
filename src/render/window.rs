//! Plain Vulkan for a window: the instance and device that can also present.
//!
//! A window is one more [`VulkanHost`]: it adds the extensions of its display to those that [`Gpu`](super::Gpu) asks for and
//! chooses among devices that can present to it. The surface itself is made later ([`super::Surface`]), so that nothing is left
//! behind where the device cannot be made.

use std::ffi::{CStr, c_char};
use std::sync::Arc;

use ash::vk;
use ramus_xr::vulkan::{HostError, VulkanHost};
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use super::error::{RenderError, Trying as _};
use super::host::{entry, strongest};

/// A window of whatever library: Vulkan needs its handles alone.
pub trait DrawnWindow: HasWindowHandle + HasDisplayHandle {}

impl<Window: HasWindowHandle + HasDisplayHandle> DrawnWindow for Window {}

/// Makes Vulkan's objects for a window.
pub struct WindowHost {
    window: Arc<dyn DrawnWindow>,
}

impl WindowHost {
    /// For this window, which is kept until the host is dropped.
    #[must_use]
    pub fn new(window: Arc<dyn DrawnWindow>) -> Self {
        Self { window }
    }

    /// The instance's extensions that the window's display wants.
    fn extensions(&self) -> Result<&'static [*const c_char], RenderError> {
        let display = self.window.display_handle().map_err(no_window)?;
        ash_window::enumerate_required_extensions(display.as_raw())
            .map_err(|result| no_window(format!("its display is of an unknown kind: {result}")))
    }
}

/// Why the window cannot be drawn into.
pub(super) fn no_window(why: impl std::fmt::Display) -> RenderError {
    RenderError::NoWindow(why.to_string())
}

/// Makes the window's surface.
///
/// # Safety
/// The instance must have been made by a [`WindowHost`] for this window, and must outlive the surface, as must the window.
pub(super) unsafe fn make_surface(
    entry: &ash::Entry,
    instance: &ash::Instance,
    window: &dyn DrawnWindow,
) -> Result<vk::SurfaceKHR, RenderError> {
    let display = window.display_handle().map_err(no_window)?;
    let handle = window.window_handle().map_err(no_window)?;
    // SAFETY: the handles are alive while borrowed, the caller vouches for the rest.
    unsafe { ash_window::create_surface(entry, instance, display.as_raw(), handle.as_raw(), None) }
        .map_err(|result| no_window(format!("no surface: {result}")))
}

/// The first family that draws, as `Gpu` takes it.
fn drawing_family(instance: &ash::Instance, device: vk::PhysicalDevice) -> Option<u32> {
    // SAFETY: the device was enumerated from this instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let draws =
        |family: &vk::QueueFamilyProperties| family.queue_flags.contains(vk::QueueFlags::GRAPHICS);
    u32::try_from(families.iter().position(draws)?).ok()
}

fn has_swapchains(instance: &ash::Instance, device: vk::PhysicalDevice) -> bool {
    // SAFETY: as above.
    unsafe { instance.enumerate_device_extension_properties(device) }.is_ok_and(|extensions| {
        extensions.iter().any(|extension| {
            extension.extension_name_as_c_str() == Ok(ash::khr::swapchain::NAME as &CStr)
        })
    })
}

/// The names and `more`, as Vulkan wants them.
///
/// # Safety
/// `names` must point to `count` pointers, or `count` be 0.
unsafe fn joined(
    names: *const *const c_char,
    count: u32,
    more: &[*const c_char],
) -> Vec<*const c_char> {
    let mut all = more.to_vec();
    if count > 0 {
        // SAFETY: the caller vouches for both.
        all.extend_from_slice(unsafe { std::slice::from_raw_parts(names, count as usize) });
    }
    all
}

impl VulkanHost for WindowHost {
    unsafe fn create_instance(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<vk::Instance, HostError> {
        let (first, count) = (
            info.pp_enabled_extension_names,
            info.enabled_extension_count,
        );
        // SAFETY: the caller vouches for `info`.
        let names = unsafe { joined(first, count, self.extensions()?) };
        let info = info.enabled_extension_names(&names);
        // SAFETY: as above; the names live until the call returns.
        match unsafe { entry(get_instance_proc_addr).create_instance(&info, None) } {
            Ok(instance) => Ok(instance.handle()),
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => {
                Err(RenderError::NoDevice(String::new()).into())
            }
            Err(vk::Result::ERROR_EXTENSION_NOT_PRESENT) => {
                Err(no_window("the Vulkan driver knows no windows").into())
            }
            Err(result) => {
                Err(RenderError::from_vulkan("making the Vulkan instance", result).into())
            }
        }
    }

    unsafe fn physical_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
    ) -> Result<vk::PhysicalDevice, HostError> {
        let entry = entry(get_instance_proc_addr);
        // SAFETY: the instance is alive and was made through the same loader.
        let instance = unsafe { ash::Instance::load(entry.static_fn(), instance) };
        let functions = ash::khr::surface::Instance::new(&entry, &instance);
        // SAFETY: the instance is this host's; the surface goes at the end of this function.
        let surface = unsafe { make_surface(&entry, &instance, &*self.window) }?;
        let chosen = strongest(&instance, |device, _| {
            let family = drawing_family(&instance, device);
            has_swapchains(&instance, device)
                && family.is_some_and(|family| {
                    // SAFETY: device, family and surface are of this instance.
                    unsafe {
                        functions.get_physical_device_surface_support(device, family, surface)
                    }
                    .unwrap_or(false)
                })
        });
        // SAFETY: nothing else knows the surface.
        unsafe { functions.destroy_surface(surface, None) };
        Ok(chosen?.ok_or_else(|| no_window("no graphics device can present to it"))?)
    }

    unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, HostError> {
        let (first, count) = (
            info.pp_enabled_extension_names,
            info.enabled_extension_count,
        );
        let more = [ash::khr::swapchain::NAME.as_ptr()];
        // SAFETY: the caller vouches for `info`.
        let names = unsafe { joined(first, count, &more) };
        let info = info.enabled_extension_names(&names);
        // SAFETY: the caller vouches for the handles and `info`; the names live until the call returns.
        unsafe {
            let entry = entry(get_instance_proc_addr);
            let instance = ash::Instance::load(entry.static_fn(), instance);
            let device = instance.create_device(physical_device, &info, None);
            Ok(device.trying("making the Vulkan device")?.handle())
        }
    }
}
