//! Who makes the Vulkan handles: the program itself, or an OpenXR runtime.
//!
//! `XR_KHR_vulkan_enable2` wants the runtime between us and Vulkan for three
//! calls. They are this trait, so that `render` need not know OpenXR; the
//! application implements it over the `xr` crate.

use ash::vk;

use super::error::{RenderError, Trying as _};

/// Makes the Vulkan instance and device, and says which physical device it must be.
pub trait VulkanHost {
    /// The Vulkan version to ask for, given the loader's; a host with an upper bound lowers it.
    fn api_version(&self, loader: u32) -> u32 {
        loader.min(vk::API_VERSION_1_3)
    }

    /// Makes the instance.
    ///
    /// # Errors
    /// [`RenderError`] when the host or the driver refuses.
    ///
    /// # Safety
    /// `info` must be valid for `vkCreateInstance`, and `get_instance_proc_addr` the loader's.
    unsafe fn create_instance(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<vk::Instance, RenderError>;

    /// Chooses the physical device.
    ///
    /// # Errors
    /// [`RenderError`] when there is none.
    ///
    /// # Safety
    /// `instance` must come from this host's `create_instance`.
    unsafe fn physical_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
    ) -> Result<vk::PhysicalDevice, RenderError>;

    /// Makes the device.
    ///
    /// # Errors
    /// [`RenderError`] when the host or the driver refuses.
    ///
    /// # Safety
    /// The handles must come from this host, and `info` be valid for `vkCreateDevice`.
    unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, RenderError>;
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
    ) -> Result<vk::Instance, RenderError> {
        let entry = entry(get_instance_proc_addr);
        // SAFETY: the caller vouches for `info`.
        match unsafe { entry.create_instance(info, None) } {
            Ok(instance) => Ok(instance.handle()),
            Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => Err(RenderError::NoDevice(String::new())),
            Err(result) => Err(RenderError::from_vulkan("making the Vulkan instance", result)),
        }
    }

    unsafe fn physical_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
    ) -> Result<vk::PhysicalDevice, RenderError> {
        // SAFETY: the instance is alive and was made through the same loader.
        let instance = unsafe { ash::Instance::load(&ash::StaticFn { get_instance_proc_addr }, instance) };
        // SAFETY: as above.
        let devices = unsafe { instance.enumerate_physical_devices() }.trying("looking for graphics devices")?;
        let wanted = self.device.as_ref().map(|name| name.to_lowercase());
        devices
            .into_iter()
            .filter_map(|device| {
                // SAFETY: the device was just enumerated.
                let properties = unsafe { instance.get_physical_device_properties(device) };
                let name = super::gpu::text(&properties.device_name).to_lowercase();
                let rank = match properties.device_type {
                    vk::PhysicalDeviceType::DISCRETE_GPU => 4,
                    vk::PhysicalDeviceType::INTEGRATED_GPU => 3,
                    vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
                    _ => 1,
                };
                wanted.as_ref().is_none_or(|part| name.contains(part.as_str())).then_some((rank, device))
            })
            // The first of the strongest kind: `max_by_key` would take the last.
            .rev()
            .max_by_key(|(rank, _)| *rank)
            .map(|(_, device)| device)
            .ok_or_else(|| {
                RenderError::NoDevice(self.device.as_ref().map_or_else(String::new, |name| format!(" with '{name}' in its name")))
            })
    }

    unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, RenderError> {
        // SAFETY: the caller vouches for the handles and `info`.
        unsafe {
            let instance = ash::Instance::load(&ash::StaticFn { get_instance_proc_addr }, instance);
            Ok(instance.create_device(physical_device, info, None).trying("making the Vulkan device")?.handle())
        }
    }
}

/// An entry that only knows where functions are found.
fn entry(get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr) -> ash::Entry {
    // SAFETY: the pointer is the loader's, which outlives the entry: `Gpu` holds the library.
    unsafe { ash::Entry::from_static_fn(ash::StaticFn { get_instance_proc_addr }) }
}
