//! An OpenXR API layer between a program and the runtime, by which a test makes the runtime end a session that the program did not ask to
//! end: what headsets do when a person chooses *quit* in their menu, or take the headset's cable out.
//!
//! Monado has no way to be told that from outside: `monado-ctl` and libmonado move the focus and the origin only, a service that is asked to end
//! closes its sockets as a killed one does, and nothing in it ever announces a loss. So this crate is built as a library for the loader too,
//! and the loader puts it under the program as it would any layer. While the file that [`TELL`] names holds
//!
//! - `exit`, the layer asks the real runtime once to end the session. All that follows (STOPPING, IDLE, EXITING) is the runtime's own, and
//!   to the program it comes by itself;
//! - `loss`, the layer tells once that the session is about to be lost, which is the one state that Monado never reaches.
//!
//! Nothing here may panic: it runs in another program's process.

#![allow(
    unsafe_code,
    reason = "the loader calls by C's rules; each function says what it relies on"
)]

use std::ffi::{CStr, OsString, c_char};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use openxr_sys as sys;
use sys::Result as Code;
use sys::{Handle as _, pfn};

/// The layer's name, for `XR_ENABLE_API_LAYERS`.
pub const NAME: &str = "XR_APILAYER_RAMUS_teller";

/// The environment variable with the path of the file that says what to tell.
pub const TELL: &str = "RAMUS_TELLER";

/// Where Debian's own layers are described; naming a folder of our own hides them, so both are named.
const SYSTEM_LAYERS: &str = "/usr/share/openxr/1/api_layers/explicit.d";

/// Describes the layer to the loader in `folder`, and gives what a program's environment needs besides
/// [`crate::service::Service::environment`]. The library lies beside the test's own binary.
///
/// # Errors
/// Where the library is not there, or the folder cannot be written to.
pub fn environment(folder: &Path) -> std::io::Result<Vec<(&'static str, OsString)>> {
    let name = format!(
        "{}ramus_monado{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    let binary = std::env::current_exe()?;
    let library = binary.with_file_name(name).canonicalize()?;
    let manifest = format!(
        r#"{{"file_format_version": "1.0.0", "api_layer": {{"name": "{NAME}", "library_path": "{}", "api_version": "1.0", "implementation_version": "1", "description": "Ends sessions for tests"}}}}"#,
        library.display()
    );
    std::fs::write(folder.join("teller.json"), manifest)?;
    let mut folders = folder.as_os_str().to_owned();
    folders.push(":");
    folders.push(SYSTEM_LAYERS);
    Ok(vec![
        ("XR_API_LAYER_PATH", folders),
        (
            "XR_ENABLE_API_LAYERS",
            format!("{NAME}:XR_APILAYER_LUNARG_core_validation").into(),
        ),
        (TELL, folder.join("tell").into()),
    ])
}

/// Says what to tell now, in the folder given to [`environment`]: `exit` or `loss`.
///
/// # Errors
/// Where the file cannot be written.
pub fn tell(folder: &Path, what: &str) -> std::io::Result<()> {
    // The layer must not read half a word.
    let whole = folder.join("tell.new");
    std::fs::write(&whole, what)?;
    std::fs::rename(whole, folder.join("tell"))
}

/// What lies under this layer.
static NEXT: OnceLock<pfn::GetInstanceProcAddr> = OnceLock::new();
static INSTANCE: AtomicU64 = AtomicU64::new(0);
static SESSION: AtomicU64 = AtomicU64::new(0);
static TOLD: AtomicBool = AtomicBool::new(false);
/// Kept from before the first thread of the program reads its environment again.
static FILE: Mutex<Option<OsString>> = Mutex::new(None);

/// The function of this name under this layer.
fn next(name: &CStr) -> Option<pfn::VoidFunction> {
    let mut function = None;
    let instance = sys::Instance::from_raw(INSTANCE.load(Ordering::Acquire));
    // SAFETY: the loader gave this function for the instance, the name ends with a zero, and the place is ours.
    let code = unsafe { NEXT.get()?(instance, name.as_ptr(), &raw mut function) };
    if code == Code::SUCCESS {
        function
    } else {
        None
    }
}

/// What is to be told and was not yet.
fn wanted() -> Option<&'static str> {
    if TOLD.load(Ordering::Relaxed) {
        return None;
    }
    let file = FILE
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
        .clone()?;
    match std::fs::read(file).ok()?.as_slice() {
        b"exit" => Some("exit"),
        b"loss" => Some("loss"),
        _ => None,
    }
}

unsafe extern "system" fn create_session(
    instance: sys::Instance,
    info: *const sys::SessionCreateInfo,
    session: *mut sys::Session,
) -> Code {
    let Some(function) = next(c"xrCreateSession") else {
        return Code::ERROR_FUNCTION_UNSUPPORTED;
    };
    // SAFETY: the function has this type by its name; the arguments are the program's, passed on as they are.
    unsafe {
        let create: pfn::CreateSession = std::mem::transmute(function);
        let code = create(instance, info, session);
        if code == Code::SUCCESS {
            SESSION.store((*session).into_raw(), Ordering::Release);
        }
        code
    }
}

unsafe extern "system" fn poll_event(
    instance: sys::Instance,
    event: *mut sys::EventDataBuffer,
) -> Code {
    let session = sys::Session::from_raw(SESSION.load(Ordering::Acquire));
    match wanted() {
        Some("exit") => {
            if let Some(function) = next(c"xrRequestExitSession") {
                // SAFETY: the function has this type by its name, and the session is the one that was made.
                let code = unsafe {
                    let ask: pfn::RequestExitSession = std::mem::transmute(function);
                    ask(session)
                };
                // A session that does not run yet is asked again.
                TOLD.store(code == Code::SUCCESS, Ordering::Relaxed);
            }
        }
        Some(_) => {
            TOLD.store(true, Ordering::Relaxed);
            let lost = sys::EventDataSessionStateChanged {
                ty: sys::EventDataSessionStateChanged::TYPE,
                next: std::ptr::null(),
                session,
                state: sys::SessionState::LOSS_PENDING,
                time: sys::Time::from_nanos(1),
            };
            // SAFETY: the program gave a buffer for any event, which is as large and as aligned as the largest.
            unsafe {
                event
                    .cast::<sys::EventDataSessionStateChanged>()
                    .write(lost)
            };
            return Code::SUCCESS;
        }
        None => {}
    }
    let Some(function) = next(c"xrPollEvent") else {
        return Code::ERROR_FUNCTION_UNSUPPORTED;
    };
    // SAFETY: as above.
    unsafe {
        let poll: pfn::PollEvent = std::mem::transmute(function);
        poll(instance, event)
    }
}

unsafe extern "system" fn get_instance_proc_addr(
    instance: sys::Instance,
    name: *const c_char,
    function: *mut Option<pfn::VoidFunction>,
) -> Code {
    // SAFETY: the loader gives a name that ends with a zero and a place for the answer.
    unsafe {
        let ours: Option<pfn::VoidFunction> = match CStr::from_ptr(name).to_bytes() {
            b"xrCreateSession" => {
                Some(std::mem::transmute::<pfn::CreateSession, pfn::VoidFunction>(create_session))
            }
            b"xrPollEvent" => Some(std::mem::transmute::<pfn::PollEvent, pfn::VoidFunction>(
                poll_event,
            )),
            _ => None,
        };
        match (ours, NEXT.get()) {
            (Some(ours), _) => {
                *function = Some(ours);
                Code::SUCCESS
            }
            (None, Some(next)) => next(instance, name, function),
            (None, None) => Code::ERROR_FUNCTION_UNSUPPORTED,
        }
    }
}

unsafe extern "system" fn create_instance(
    info: *const sys::InstanceCreateInfo,
    layer: *const sys::ApiLayerCreateInfo,
    instance: *mut sys::Instance,
) -> Code {
    // SAFETY: the loader gives valid structures, ours first in the chain.
    unsafe {
        let mine = (*layer).next_info;
        if mine.is_null() {
            return Code::ERROR_INITIALIZATION_FAILED;
        }
        let (Some(address), Some(create)) = (
            (*mine).next_get_instance_proc_addr,
            (*mine).next_create_api_layer_instance,
        ) else {
            return Code::ERROR_INITIALIZATION_FAILED;
        };
        let mut below = *layer;
        below.next_info = (*mine).next;
        let code = create(info, &raw const below, instance);
        if code == Code::SUCCESS {
            // A second instance of one process goes through the same functions.
            let _ = NEXT.set(address);
            INSTANCE.store((*instance).into_raw(), Ordering::Release);
            *FILE.lock().unwrap_or_else(PoisonError::into_inner) = std::env::var_os(TELL);
        }
        code
    }
}

/// The loader's first call.
///
/// # Safety
/// The loader gives a request to be filled in.
#[unsafe(no_mangle)]
pub unsafe extern "system" fn xrNegotiateLoaderApiLayerInterface(
    _loader: *const sys::NegotiateLoaderInfo,
    _name: *const c_char,
    request: *mut sys::NegotiateApiLayerRequest,
) -> Code {
    if request.is_null() {
        return Code::ERROR_INITIALIZATION_FAILED;
    }
    // SAFETY: by the caller's word.
    unsafe {
        (*request).layer_interface_version = 1;
        (*request).layer_api_version = sys::Version::new(1, 1, 0);
        (*request).get_instance_proc_addr = Some(get_instance_proc_addr);
        (*request).create_api_layer_instance = Some(create_instance);
    }
    Code::SUCCESS
}
