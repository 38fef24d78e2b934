//! What can go wrong with the graphics, each in one sentence that says what would mend it.

use ash::vk;

/// An error of the renderer.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// There is no Vulkan loader.
    #[error(
        "there is no Vulkan loader on this machine ({0}); install it, on Debian: apt-get install libvulkan1 mesa-vulkan-drivers"
    )]
    NoLoader(String),
    /// The loader found no device that could draw.
    #[error(
        "Vulkan found no device{0}; install the driver of your graphics card, or for drawing by the processor, on Debian: apt-get install -t bookworm-backports mesa-vulkan-drivers"
    )]
    NoDevice(String),
    /// The driver lacks something that Ramus needs.
    #[error(
        "{device} (driver {driver}, Vulkan {version}) is too old for Ramus: it lacks {missing}; install a newer graphics driver (Mesa 23 or later, or the maker's current one)"
    )]
    OldDriver {
        /// The device's name.
        device: String,
        /// The driver's name and version.
        driver: String,
        /// The Vulkan version, as "1.1.230".
        version: String,
        /// What is missing.
        missing: String,
    },
    /// No memory on the device or the host.
    #[error(
        "the graphics memory is full ({0}); close other programs that draw, or show a smaller tree"
    )]
    OutOfMemory(&'static str),
    /// The device stopped answering.
    #[error(
        "the graphics device was lost ({0}): start Ramus again, and if that happens again, update the graphics driver"
    )]
    DeviceLost(&'static str),
    /// The host (an OpenXR runtime) could not make the Vulkan handles.
    #[error("the runtime could not set up Vulkan: {0}")]
    Host(String),
    /// No picture can be shown in a window.
    #[error(
        "no picture can be shown in the window ({0}): install the driver of your graphics card, or leave the window out with --headset simulated"
    )]
    NoWindow(String),
    /// Any other Vulkan error.
    #[error("the graphics driver failed at {0}: {1}")]
    Vulkan(&'static str, vk::Result),
    /// A request that cannot be met.
    #[error("{0}")]
    Unsupported(String),
}

impl RenderError {
    /// The error for a failed call; `what` names the call in plain words.
    pub fn from_vulkan(what: &'static str, result: vk::Result) -> Self {
        match result {
            vk::Result::ERROR_OUT_OF_HOST_MEMORY
            | vk::Result::ERROR_OUT_OF_DEVICE_MEMORY
            | vk::Result::ERROR_OUT_OF_POOL_MEMORY
            | vk::Result::ERROR_TOO_MANY_OBJECTS => Self::OutOfMemory(what),
            vk::Result::ERROR_DEVICE_LOST => Self::DeviceLost(what),
            other => Self::Vulkan(what, other),
        }
    }
}

/// Gives a Vulkan result the name of what was tried.
pub(crate) trait Trying<T> {
    /// Maps the error.
    fn trying(self, what: &'static str) -> Result<T, RenderError>;
}

impl<T> Trying<T> for Result<T, vk::Result> {
    fn trying(self, what: &'static str) -> Result<T, RenderError> {
        self.map_err(|result| RenderError::from_vulkan(what, result))
    }
}

impl<T> Trying<T> for Result<T, gpu_allocator::AllocationError> {
    fn trying(self, what: &'static str) -> Result<T, RenderError> {
        self.map_err(|error| match error {
            gpu_allocator::AllocationError::OutOfMemory => RenderError::OutOfMemory(what),
            other => RenderError::Unsupported(format!(
                "the graphics memory could not be set up for {what}: {other}"
            )),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_become_sentences() {
        for (result, word) in [
            (vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, "memory is full"),
            (vk::Result::ERROR_DEVICE_LOST, "was lost"),
            (vk::Result::ERROR_FORMAT_NOT_SUPPORTED, "failed at"),
        ] {
            let text = RenderError::from_vulkan("drawing", result).to_string();
            assert!(text.contains(word) && text.contains("drawing"), "{text}");
            assert!(!text.contains('\n'), "one line: {text}");
        }
    }
}
