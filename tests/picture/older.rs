//! Older Vulkan: what is too old is said in a sentence, and 1.1 and 1.2 with their extensions draw the same picture.

use ash::vk;
use ramus::render::{Gpu, GpuParams, Headless, RenderError, RendererParams, StereoMode};
use ramus_xr::vulkan::{HostError, VulkanHost};

use super::support::{device, shoot, silent, stage, standing};

/// The machine's device as if its driver ended at an older version.
struct Older(u32);

impl VulkanHost for Older {
    fn api_version(&self, _loader: u32, _wanted: u32) -> u32 {
        self.0
    }

    unsafe fn create_instance(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        info: &vk::InstanceCreateInfo<'_>,
    ) -> Result<vk::Instance, HostError> {
        // SAFETY: the caller's promise is passed on.
        unsafe { Headless::default().create_instance(get_instance_proc_addr, info) }
    }

    unsafe fn physical_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
    ) -> Result<vk::PhysicalDevice, HostError> {
        // SAFETY: the caller's promise is passed on.
        unsafe { Headless::default().physical_device(get_instance_proc_addr, instance) }
    }

    unsafe fn create_device(
        &self,
        get_instance_proc_addr: vk::PFN_vkGetInstanceProcAddr,
        instance: vk::Instance,
        physical_device: vk::PhysicalDevice,
        info: &vk::DeviceCreateInfo<'_>,
    ) -> Result<vk::Device, HostError> {
        let host = Headless::default();
        // SAFETY: the caller's promise is passed on.
        unsafe { host.create_device(get_instance_proc_addr, instance, physical_device, info) }
    }
}

#[test]
fn a_driver_that_is_too_old_is_named() {
    if device().is_none() {
        return;
    }
    match Gpu::new(&Older(vk::API_VERSION_1_0), &GpuParams::default()) {
        Err(error @ RenderError::OldDriver { .. }) => {
            let text = error.to_string();
            for word in ["too old", "Vulkan 1.1", "install a newer"] {
                assert!(text.contains(word), "{word}: {text}");
            }
        }
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("Vulkan 1.0 has no multiview"),
    }
}

#[test]
fn older_versions_with_extensions_draw_the_same_bits() {
    let Some(newest) = device() else { return };
    let params = RendererParams::new(96, 96, StereoMode::PerEye);
    let expected = shoot(&newest, &params, &stage(), &standing());
    for version in [vk::API_VERSION_1_1, vk::API_VERSION_1_2] {
        let gpu = Gpu::new(&Older(version), &GpuParams::checked()).unwrap();
        let shot = shoot(&gpu, &params, &stage(), &standing());
        assert!(shot.color == expected.color, "another picture");
        silent(&gpu);
    }
}
