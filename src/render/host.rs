//! Who makes the Vulkan handles: the program itself, or an OpenXR runtime.
//!
//! `XR_KHR_vulkan_enable2` wants the runtime between us and Vulkan for three calls: they are
//! the trait [`VulkanHost`] of `ramus_xr::vulkan`, which names handles only. Nothing else of the
//! headset's crate is known here but its images, which only a headset can make.

use ash::vk;
use ramus_xr::vulkan::{HostError, VulkanDevice, VulkanHandles, VulkanHost};

use super::error::{RenderError, Trying as _};
use super::gpu::Gpu;

impl From<HostError> for RenderError {
    /// Our own errors come back as they were; a runtime's are told in its words.
    fn from(error: HostError) -> Self {
        match error.downcast::<Self>() {
            Ok(ours) => *ours,
            Err(theirs) => Self::Host(theirs.to_string()),
        }
    }
}

// SAFETY: a `Gpu` keeps its device alive, and its queue is used by the thread that draws alone.
unsafe impl VulkanDevice for Gpu {
    fn handles(&self) -> VulkanHandles {
        VulkanHandles {
            instance: self.instance.handle(),
            physical_device: self.physical_device,
            device: self.device.handle(),
            queue_family: self.family,
            queue_index: 0,
        }
    }

    fn wait_idle(&self) {
        // A lost device has nothing to do any more either.
        let _ = super::gpu::GpuInner::wait_idle(self);
    }
}

/// Plain Vulkan without a headset: offscreen pictures, the simulated headset, tests.
#[derive(Clone, Debug, Default)]
pub struct Headless {
    /// Part of a device's name to prefer, in any case; the strongest kind of device when `None`.
    pub device: Option<String>,
}

impl VulkanHost for Headless {
    unsafe fn create_instance(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<vk::Instance, HostError> {
        let entry = entry(get_instance_proc_addr);
        // SAFETY: the caller vouches for `info`.
        match unsafe { entry.create_instance(info, None) } {
            Ok(instance) => Ok(instance.handle()),
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => {
                Err(RenderError::NoDevice(String::new()).into())
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
        // SAFETY: the instance is alive and was made through the same loader.
        let instance = unsafe {
            ash::Instance::load(
                &ash::StaticFn {
                    get_instance_proc_addr,
                },
                instance,
            )
        };
        let wanted = self.device.as_ref().map(|name| name.to_lowercase());
        strongest(&instance, |_, name| {
            wanted
                .as_ref()
                .is_none_or(|part| name.to_lowercase().contains(part.as_str()))
        })?
        .ok_or_else(|| {
            RenderError::NoDevice(
                self.device
                    .as_ref()
                    .map_or_else(String::new, |name| format!(" with '{name}' in its name")),
            )
            .into()
        })
    }

    unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, HostError> {
        // SAFETY: the caller vouches for the handles and `info`.
        unsafe {
            let instance = ash::Instance::load(
                &ash::StaticFn {
                    get_instance_proc_addr,
                },
                instance,
            );
            Ok(instance
                .create_device(physical_device, info, None)
                .trying("making the Vulkan device")?
                .handle())
        }
    }
}

/// The first device of the strongest kind among those that `will_do`, given the device and its name.
pub(super) fn strongest(
    instance: &ash::Instance,
    will_do: impl Fn(vk::PhysicalDevice, &str) -> bool,
) -> Result<Option<vk::PhysicalDevice>, RenderError> {
    // SAFETY: the instance is alive.
    let devices =
        unsafe { instance.enumerate_physical_devices() }.trying("looking for graphics devices")?;
    let ranked = devices.into_iter().filter_map(|device| {
        // SAFETY: the device was just enumerated.
        let properties = unsafe { instance.get_physical_device_properties(device) };
        let rank = match properties.device_type {
            vk::PhysicalDeviceType::DISCRETE_GPU => 4,
            vk::PhysicalDeviceType::INTEGRATED_GPU => 3,
            vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
            _ => 1,
        };
        will_do(device, &super::gpu::text(&properties.device_name)).then_some((rank, device))
    });
    // The first of the strongest kind: `max_by_key` would take the last.
    let best = ranked.rev().max_by_key(|(rank, _)| *rank);
    Ok(best.map(|(_, device)| device))
}

/// An entry that only knows where functions are found.
pub(super) fn entry(get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr) -> ash::Entry {
    // SAFETY: the pointer is the loader's, which outlives the entry: `Gpu` holds the library.
    unsafe {
        ash::Entry::from_static_fn(ash::StaticFn {
            get_instance_proc_addr,
        })
    }
}
