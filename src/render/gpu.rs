//! The Vulkan device: instance, queue, memory, validation.
//!
//! Baseline: Vulkan 1.1 with multiview, dynamic rendering and synchronization2
//! (core in 1.3, else the extensions), so that PC drivers and streaming
//! runtimes fit. Each feature is asked for by its own small structure and never
//! by `VkPhysicalDeviceVulkan12Features`, because an OpenXR runtime may chain
//! its own and the two must not meet.

use std::{
    ffi::{CStr, c_char},
    mem::ManuallyDrop,
    ops::Deref,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use ramus_xr::vulkan::VulkanHost;

use super::{
    error::{RenderError, Trying as _},
    validation::{self, Messages},
};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";
const VALIDATION_FEATURES: &CStr = c"VK_EXT_validation_features";

/// How to open the device.
#[derive(Clone, Debug, Default)]
pub struct GpuParams {
    /// Turn the validation layer on, where it is installed.
    pub validation: bool,
    /// Turn synchronisation validation on too (needs `validation`).
    pub sync_validation: bool,
}

impl GpuParams {
    /// Everything checked: what tests use.
    pub const fn checked() -> Self {
        Self {
            validation: true,
            sync_validation: true,
        }
    }

    /// From the environment: `RAMUS_VALIDATION=1` checks everything.
    pub fn from_env() -> Self {
        if std::env::var_os("RAMUS_VALIDATION").is_some_and(|value| value == "1") {
            Self::checked()
        } else {
            Self::default()
        }
    }
}

/// What the device is called and what it can do, for `doctor` and messages.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// The device's name.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// Vulkan version, as "1.3.230".
    pub version: String,
    /// Whether the processor draws.
    pub software: bool,
    /// Whether the validation layer is on.
    pub validation: bool,
}

/// The function pointers that are core in 1.3 and extensions before.
pub(crate) struct Newer {
    pub(crate) begin_rendering: vk::PFN_vkCmdBeginRendering,
    pub(crate) end_rendering: vk::PFN_vkCmdEndRendering,
    pub(crate) barrier: vk::PFN_vkCmdPipelineBarrier2,
    pub(crate) submit: vk::PFN_vkQueueSubmit2,
}

/// The device and what belongs to it; shared by everything that holds Vulkan objects.
pub struct GpuInner {
    pub(crate) device: ash::Device,
    pub(crate) newer: Newer,
    pub(crate) limits: vk::PhysicalDeviceLimits,
    pub(crate) physical_device: vk::PhysicalDevice,
    pub(crate) family: u32,
    /// Bits of its times; 0: it tells none.
    pub(crate) tick_bits: u32,
    info: DeviceInfo,
    queue: Mutex<vk::Queue>,
    allocator: ManuallyDrop<Mutex<Allocator>>,
    messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<Messages>,
    /// Pipelines made so far.
    pipelines: AtomicU64,
    pub(crate) instance: ash::Instance,
    /// Holds the loader's library open.
    pub(crate) entry: ash::Entry,
}

/// A handle to the device; clones are cheap and keep it alive.
#[derive(Clone)]
pub struct Gpu {
    inner: Arc<GpuInner>,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.info.fmt(f)
    }
}

impl Deref for Gpu {
    type Target = GpuInner;

    fn deref(&self) -> &GpuInner {
        &self.inner
    }
}

impl Gpu {
    /// Opens the device that `host` chooses.
    ///
    /// # Errors
    /// [`RenderError`]: no loader, no device, a driver that is too old, or what the host says.
    pub fn new(host: &dyn VulkanHost, params: &GpuParams) -> Result<Self, RenderError> {
        // SAFETY: the loader's library is trusted, as for every Vulkan program.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|error| RenderError::NoLoader(one_line(&error.to_string())))?;
        let get_proc = entry.static_fn().get_instance_proc_addr;
        // SAFETY: no preconditions.
        let loader = unsafe { entry.try_enumerate_instance_version() }
            .trying("asking the Vulkan loader for its version")?
            .unwrap_or(vk::API_VERSION_1_0);
        let api_version = host.api_version(loader, vk::API_VERSION_1_3);

        let layers = available_layers(&entry)?;
        let validation = params.validation && layers;
        if params.validation && !layers {
            tracing::warn!(
                "the Vulkan validation layer is not installed; on Debian: apt-get install vulkan-validationlayers"
            );
        }
        let layer_names: &[*const c_char] = if validation {
            &[VALIDATION_LAYER.as_ptr()]
        } else {
            &[]
        };
        let extension_names: &[*const c_char] = if validation {
            &[
                ash::ext::debug_utils::NAME.as_ptr(),
                VALIDATION_FEATURES.as_ptr(),
            ]
        } else {
            &[]
        };
        let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let mut features =
            vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
        let application = vk::ApplicationInfo::default()
            .application_name(c"Ramus")
            .application_version(1)
            .engine_name(c"Ramus")
            .engine_version(1)
            .api_version(api_version);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(layer_names)
            .enabled_extension_names(extension_names);
        if validation && params.sync_validation {
            info = info.push_next(&mut features);
        }
        // SAFETY: everything `info` points to lives until the call returns.
        let handle = unsafe { host.create_instance(get_proc, &info) }?;
        // SAFETY: the instance was just made through this loader.
        let instance = unsafe { ash::Instance::load(entry.static_fn(), handle) };

        let messages = Box::<Messages>::default();
        let messenger = if validation {
            let functions = ash::ext::debug_utils::Instance::new(&entry, &instance);
            // SAFETY: `messages` is boxed and outlives the messenger (see `Drop`).
            let messenger = unsafe {
                functions.create_debug_utils_messenger(&validation::messenger(&messages), None)
            }
            .trying("turning validation on")?;
            Some((functions, messenger))
        } else {
            None
        };

        let opened = open_device(host, get_proc, &instance, api_version, validation);
        let Opened {
            physical_device,
            device,
            newer,
            family,
            tick_bits,
            info,
        } = match opened {
            Ok(opened) => opened,
            Err(error) => {
                // SAFETY: nothing else uses the messenger and the instance.
                unsafe {
                    if let Some((functions, messenger)) = &messenger {
                        functions.destroy_debug_utils_messenger(*messenger, None);
                    }
                    instance.destroy_instance(None);
                }
                return Err(error);
            }
        };
        // SAFETY: the family has at least one queue and one was asked for.
        let queue = unsafe { device.get_device_queue(family, 0) };
        // SAFETY: the device is alive.
        let limits = unsafe { instance.get_physical_device_properties(physical_device) }.limits;
        let mut debug_settings = gpu_allocator::AllocatorDebugSettings::default();
        debug_settings.log_leaks_on_shutdown = false;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device,
            debug_settings,
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })
        .trying("the device")?;
        Ok(Self {
            inner: Arc::new(GpuInner {
                device,
                newer,
                limits,
                physical_device,
                family,
                tick_bits,
                info,
                queue: Mutex::new(queue),
                allocator: ManuallyDrop::new(Mutex::new(allocator)),
                messenger,
                messages,
                pipelines: AtomicU64::new(0),
                instance,
                entry,
            }),
        })
    }
}

impl GpuInner {
    /// What the device is.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// What the validation layers said.
    pub fn messages(&self) -> &Messages {
        &self.messages
    }

    /// How many pipelines were made on this device so far; frames make none.
    #[must_use]
    pub fn pipelines_made(&self) -> u64 {
        self.pipelines.load(Ordering::Relaxed)
    }

    /// How many bytes of the device's memory buffers and images take, and how many it has given for them.
    #[must_use]
    pub fn memory(&self) -> [u64; 2] {
        let report = self.allocator().generate_report();
        [report.total_allocated_bytes, report.total_capacity_bytes]
    }

    pub(crate) fn pipeline_was_made(&self) {
        self.pipelines.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands one command buffer to the queue; it waits for one semaphore and signals another, where there are such.
    pub(crate) fn submit(
        &self,
        commands: vk::CommandBuffer,
        fence: vk::Fence,
        [wait, signal]: [Option<vk::Semaphore>; 2],
    ) -> Result<(), RenderError> {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let all = |semaphore: Option<vk::Semaphore>| {
            vk::SemaphoreSubmitInfo::default()
                .semaphore(semaphore.unwrap_or_default())
                .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
        };
        let (waits, signals) = ([all(wait)], [all(signal)]);
        let some = |semaphore: Option<vk::Semaphore>| usize::from(semaphore.is_some());
        let submit = vk::SubmitInfo2::default()
            .command_buffer_infos(&buffers)
            .wait_semaphore_infos(waits.get(..some(wait)).unwrap_or_default())
            .signal_semaphore_infos(signals.get(..some(signal)).unwrap_or_default());
        // SAFETY: the queue is locked, the command buffer recorded, the fence unsignalled.
        unsafe { (self.newer.submit)(*queue, 1, &raw const submit, fence) }
            .result()
            .trying("submitting a frame")
    }

    /// Hands a window's image to the screen; true where its swapchain fits no longer.
    pub(crate) fn present(
        &self,
        swapchains: &ash::khr::swapchain::Device,
        info: &vk::PresentInfoKHR<'_>,
    ) -> Result<bool, vk::Result> {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the queue is locked; the caller's image is acquired and its semaphore signalled by work handed over before.
        unsafe { swapchains.queue_present(*queue, info) }
    }

    /// Waits until the device has nothing to do. Only for ends and tests: it stalls.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`].
    pub fn wait_idle(&self) -> Result<(), RenderError> {
        let queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the queue is locked.
        unsafe { self.device.queue_wait_idle(*queue) }.trying("waiting for the device")
    }
}

impl Drop for GpuInner {
    fn drop(&mut self) {
        // SAFETY: everything made from the device holds a `Gpu`, so all of it is gone by now;
        // the allocator frees its blocks before the device, the messenger hears the device's end.
        unsafe {
            let _ = self.device.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.device.destroy_device(None);
            if let Some((functions, messenger)) = &self.messenger {
                functions.destroy_debug_utils_messenger(*messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

struct Opened {
    physical_device: vk::PhysicalDevice,
    device: ash::Device,
    newer: Newer,
    family: u32,
    tick_bits: u32,
    info: DeviceInfo,
}

fn open_device(
    host: &dyn VulkanHost,
    get_proc: vk::PFN_vkGetInstanceProcAddr,
    instance: &ash::Instance,
    api_version: u32,
    validation: bool,
) -> Result<Opened, RenderError> {
    // SAFETY: the instance is alive and the host's.
    let physical_device = unsafe { host.physical_device(get_proc, instance.handle()) }?;
    // SAFETY: the host's device.
    let properties = unsafe { instance.get_physical_device_properties(physical_device) };
    // SAFETY: as above.
    let extensions = unsafe { instance.enumerate_device_extension_properties(physical_device) }
        .trying("asking the driver for its extensions")?;
    let has = |name: &CStr| {
        extensions
            .iter()
            .any(|extension| extension.extension_name_as_c_str() == Ok(name))
    };
    let version = properties.api_version.min(api_version);
    let info = describe(
        instance,
        physical_device,
        &properties,
        has(ash::khr::driver_properties::NAME),
        validation,
    );
    let too_old = |missing: &str| RenderError::OldDriver {
        device: info.device.clone(),
        driver: info.driver.clone(),
        version: info.version.clone(),
        missing: missing.to_owned(),
    };

    if version < vk::API_VERSION_1_1 {
        return Err(too_old("Vulkan 1.1"));
    }
    let core = version >= vk::API_VERSION_1_3;
    let mut names: Vec<*const c_char> = Vec::new();
    if !core {
        let wanted: &[&CStr] = if version >= vk::API_VERSION_1_2 {
            &[
                ash::khr::dynamic_rendering::NAME,
                ash::khr::synchronization2::NAME,
            ]
        } else {
            &[
                ash::khr::dynamic_rendering::NAME,
                ash::khr::synchronization2::NAME,
                ash::khr::depth_stencil_resolve::NAME,
                ash::khr::create_renderpass2::NAME,
            ]
        };
        for name in wanted {
            if !has(name) {
                return Err(too_old(&name.to_string_lossy()));
            }
            names.push(name.as_ptr());
        }
    }

    let mut multiview = vk::PhysicalDeviceMultiviewFeatures::default();
    let mut dynamic = vk::PhysicalDeviceDynamicRenderingFeatures::default();
    let mut sync = vk::PhysicalDeviceSynchronization2Features::default();
    let mut found = vk::PhysicalDeviceFeatures2::default()
        .push_next(&mut multiview)
        .push_next(&mut dynamic)
        .push_next(&mut sync);
    // SAFETY: the chain is made of structures that this device knows (version and extensions were checked).
    unsafe { instance.get_physical_device_features2(physical_device, &mut found) };
    let many_draws =
        found.features.multi_draw_indirect & found.features.draw_indirect_first_instance;
    for (there, name) in [
        (multiview.multiview, "multiview"),
        (dynamic.dynamic_rendering, "dynamic rendering"),
        (sync.synchronization2, "synchronization2"),
        (many_draws, "indirect draws of many instances"),
    ] {
        if there == vk::FALSE {
            return Err(too_old(name));
        }
    }
    let counts = properties.limits.framebuffer_color_sample_counts
        & properties.limits.framebuffer_depth_sample_counts;
    if !counts.contains(vk::SampleCountFlags::TYPE_4) {
        return Err(too_old("4 samples a pixel"));
    }

    // SAFETY: as above.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical_device) };
    let family = families
        .iter()
        .position(|family| {
            let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
            family.queue_flags.contains(both)
        })
        .and_then(|index| u32::try_from(index).ok())
        .ok_or_else(|| too_old("a graphics queue"))?;

    let priorities = [1.0];
    let queues = [vk::DeviceQueueCreateInfo::default()
        .queue_family_index(family)
        .queue_priorities(&priorities)];
    let mut multiview = vk::PhysicalDeviceMultiviewFeatures::default().multiview(true);
    let mut dynamic = vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
    let mut sync = vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true);
    let features = vk::PhysicalDeviceFeatures::default()
        .multi_draw_indirect(true)
        .draw_indirect_first_instance(true);
    let create = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_features(&features)
        .enabled_extension_names(&names)
        .push_next(&mut multiview)
        .push_next(&mut dynamic)
        .push_next(&mut sync);
    // SAFETY: everything `create` points to lives until the call returns.
    let handle =
        unsafe { host.create_device(get_proc, instance.handle(), physical_device, &create) }?;
    // SAFETY: the device was just made from this instance.
    let device = unsafe { ash::Device::load(instance.fp_v1_0(), handle) };
    let newer = if core {
        let functions = device.fp_v1_3();
        Newer {
            begin_rendering: functions.cmd_begin_rendering,
            end_rendering: functions.cmd_end_rendering,
            barrier: functions.cmd_pipeline_barrier2,
            submit: functions.queue_submit2,
        }
    } else {
        let rendering = ash::khr::dynamic_rendering::Device::new(instance, &device);
        let sync = ash::khr::synchronization2::Device::new(instance, &device);
        Newer {
            begin_rendering: rendering.fp().cmd_begin_rendering_khr,
            end_rendering: rendering.fp().cmd_end_rendering_khr,
            barrier: sync.fp().cmd_pipeline_barrier2_khr,
            submit: sync.fp().queue_submit2_khr,
        }
    };
    Ok(Opened {
        physical_device,
        device,
        newer,
        family,
        tick_bits: families
            .get(family as usize)
            .map_or(0, |family| family.timestamp_valid_bits),
        info,
    })
}

fn describe(
    instance: &ash::Instance,
    physical_device: vk::PhysicalDevice,
    properties: &vk::PhysicalDeviceProperties,
    has_driver: bool,
    validation: bool,
) -> DeviceInfo {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    if has_driver {
        let mut chain = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
        // SAFETY: the device is alive and knows the extension that the structure belongs to.
        unsafe { instance.get_physical_device_properties2(physical_device, &mut chain) };
    }
    let name = format!(
        "{} {}",
        text(&driver.driver_name),
        text(&driver.driver_info)
    );
    let version = properties.api_version;
    DeviceInfo {
        device: text(&properties.device_name),
        driver: if has_driver {
            name.trim().to_owned()
        } else {
            format!("version {:#x}", properties.driver_version)
        },
        version: format!(
            "{}.{}.{}",
            vk::api_version_major(version),
            vk::api_version_minor(version),
            vk::api_version_patch(version)
        ),
        software: properties.device_type == vk::PhysicalDeviceType::CPU,
        validation,
    }
}

fn available_layers(entry: &ash::Entry) -> Result<bool, RenderError> {
    // SAFETY: no preconditions.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }
        .trying("asking for Vulkan's layers")?;
    Ok(layers
        .iter()
        .any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER)))
}

/// A fixed C string as text.
pub(crate) fn text(bytes: &[c_char]) -> String {
    bytes
        .iter()
        .take_while(|byte| **byte != 0)
        .map(|byte| char::from(byte.cast_unsigned()))
        .collect()
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
