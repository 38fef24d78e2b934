//! What the validation layers say, kept and counted: a test that draws asserts that nothing was said.

use std::{
    ffi::{CStr, c_void},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
};

use ash::vk;

/// At most so many messages are kept; all are counted.
const KEPT: usize = 64;

/// Messages of the validation layers.
#[derive(Debug, Default)]
pub struct Messages {
    count: AtomicUsize,
    kept: Mutex<Vec<String>>,
}

impl Messages {
    /// How many warnings and errors came.
    pub fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }

    /// The first of them.
    pub fn list(&self) -> Vec<String> {
        self.kept
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    fn push(&self, text: String) {
        self.count.fetch_add(1, Ordering::Relaxed);
        tracing::warn!(target: "vulkan", "{text}");
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() < KEPT {
            kept.push(text);
        }
    }
}

/// The create info of a messenger that fills `messages`.
///
/// The returned value holds `messages`' address: it must outlive the messenger.
pub(crate) fn messenger(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(
            vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
        )
        .message_type(
            vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
        )
        .pfn_user_callback(Some(said))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast::<c_void>())
}

/// Called by the layers.
unsafe extern "system" fn said(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `user` is the address of a `Messages` that outlives the messenger; the layers
    // give a valid `data` with C strings or null.
    unsafe {
        if let (Some(messages), Some(data)) = (user.cast::<Messages>().as_ref(), data.as_ref()) {
            let text = |pointer: *const std::ffi::c_char| {
                if pointer.is_null() {
                    String::new()
                } else {
                    CStr::from_ptr(pointer).to_string_lossy().into_owned()
                }
            };
            messages.push(format!(
                "{}: {}",
                text(data.p_message_id_name),
                text(data.p_message)
            ));
        }
    }
    vk::FALSE
}
