//! A runtime inside the test's own process: it gives what a test scripts, fails where a test wants it, and writes down
//! what a strict runtime would object to (the rules of Khronos' best-practices layer).
//!
//! Its state belongs to the thread, as each test does.

use std::cell::RefCell;
use std::collections::{HashMap, VecDeque};
use std::ffi::{CStr, c_char};
use std::ptr;

use ::openxr as xr;
use xr::sys::{self, Handle as _, Result as Code, pfn};

use super::connect::{ConnectError, connect_through};
use super::system::System;

mod events;

pub(super) use self::events::FakeEvent;
pub(super) use self::extensions::More;

/// Nanoseconds between two frames, unless a test says when they are shown.
const PERIOD: i64 = 11_000_000;

/// What came with `xrEndFrame`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Ended {
    pub(super) layers: u32,
    /// nearZ and farZ of the left eye's depth.
    pub(super) depth: Option<[f32; 2]>,
    /// Of the quad on top: x of its middle, and its width.
    pub(super) quad: Option<[f32; 2]>,
}

pub(super) struct Fake {
    /// Names of the calls so far.
    pub(super) calls: Vec<&'static str>,
    /// Pixels of the pictures that were shown, eye by eye.
    pub(super) shown: Vec<[i32; 2]>,
    /// The call that gives a code instead of doing its work, from now on.
    pub(super) fail: Option<(&'static str, Code)>,
    pub(super) extensions: Vec<&'static CStr>,
    pub(super) knows_1_1: bool,
    pub(super) formats: Vec<i64>,
    pub(super) most_layers: u32,
    pub(super) spaces: Vec<xr::ReferenceSpaceType>,
    pub(super) events: VecDeque<FakeEvent>,
    /// When the next frames are shown; after them one each period.
    pub(super) times: VecDeque<i64>,
    pub(super) should_render: bool,
    pub(super) views_known: xr::ViewStateFlags,
    pub(super) hands_known: xr::SpaceLocationFlags,
    /// Whether what is held cannot be seen; the action alone whose pose is not known.
    pub(super) controllers_lost: bool,
    pub(super) unknown: &'static str,
    /// What every number, and every axis of a stick, is.
    pub(super) number: f32,
    pub(super) button: bool,
    pub(super) orientation: [f32; 4],
    pub(super) fov: xr::Fovf,
    /// Where a strict runtime would have objected.
    pub(super) objections: Vec<String>,
    pub(super) ended: Vec<Ended>,
    pub(super) haptics: usize,
    /// How far the head had moved (z, in metres) in the views that were submitted: it moves with each time that it is located.
    pub(super) submitted: Vec<[f32; 2]>,
    /// Reference spaces that were made.
    pub(super) made: Vec<(xr::ReferenceSpaceType, f32)>,
    pub(super) api: Option<xr::Version>,
    /// By profile: actions and the paths that they were bound to.
    pub(super) bound: HashMap<String, Vec<(u64, String)>>,
    /// What the extensions say.
    pub(super) more: More,
    /// The profile of what is held in both hands,
    pub(super) held: &'static str,
    /// and what its parts say, by the end of their path, where that is not `number` or `button`.
    pub(super) parts: HashMap<&'static str, f32>,
    paths: Vec<String>,
    handles: u64,
    time: i64,
    running: bool,
    stage: u8,
    synced: bool,
    acquired: HashMap<u64, u8>,
    /// Names of the actions, and the actions of the spaces of controllers.
    actions: HashMap<u64, String>,
    of_controllers: HashMap<u64, String>,
    located: [sys::View; 2],
}

impl Default for Fake {
    fn default() -> Self {
        let view = sys::View {
            ty: sys::View::TYPE,
            next: ptr::null_mut(),
            pose: xr::Posef::IDENTITY,
            fov: xr::Fovf::default(),
        };
        Self {
            calls: Vec::new(),
            // Warm frames are to allocate nothing.
            shown: Vec::with_capacity(4096),
            fail: None,
            extensions: vec![
                c"XR_KHR_vulkan_enable2",
                c"XR_KHR_composition_layer_depth",
                c"XR_EXT_local_floor",
            ],
            knows_1_1: true,
            most_layers: 16,
            formats: vec![97, 50, 43, 126], // half floats, BGRA sRGB, RGBA sRGB, 32-bit depth
            spaces: vec![
                xr::ReferenceSpaceType::VIEW,
                xr::ReferenceSpaceType::LOCAL,
                xr::ReferenceSpaceType::STAGE,
                xr::ReferenceSpaceType::LOCAL_FLOOR,
            ],
            events: VecDeque::new(),
            times: VecDeque::new(),
            should_render: true,
            views_known: xr::ViewStateFlags::ORIENTATION_VALID | xr::ViewStateFlags::POSITION_VALID,
            hands_known: xr::SpaceLocationFlags::ORIENTATION_VALID
                | xr::SpaceLocationFlags::POSITION_VALID,
            controllers_lost: false,
            unknown: "",
            number: 0.5,
            button: true,
            orientation: [0.0, 0.0, 0.0, 1.0],
            fov: xr::Fovf {
                angle_left: -0.9,
                angle_right: 0.8,
                angle_up: 0.7,
                angle_down: -0.6,
            },
            objections: Vec::new(),
            ended: Vec::new(),
            haptics: 0,
            submitted: Vec::new(),
            made: Vec::new(),
            api: None,
            bound: HashMap::new(),
            more: More::default(),
            held: "/interaction_profiles/oculus/touch_controller",
            parts: HashMap::new(),
            paths: Vec::new(),
            handles: 100,
            time: 1_000_000_000,
            running: false,
            stage: 0,
            synced: false,
            acquired: HashMap::new(),
            actions: HashMap::new(),
            of_controllers: HashMap::new(),
            located: [view; 2],
        }
    }
}

impl Fake {
    fn expect(&mut self, holds: bool, what: &str) {
        if !holds {
            let call = self.calls.last().copied().unwrap_or_default();
            self.objections.push(format!("{call}: {what}"));
        }
    }

    /// Room for the notes of so many more frames, so that taking them allocates nothing.
    pub(super) fn make_room(&mut self, frames: usize) {
        /// More than a frame's calls: two hands with nine states and two spaces each, and twenty of the frame itself.
        const CALLS: usize = 64;
        self.calls.reserve(frames * CALLS);
        self.ended.reserve(frames);
        self.submitted.reserve(frames);
    }

    /// What the part of the held controller says that an action is bound to, on one of its axes; none where it is bound to none.
    fn value(&self, asked: &sys::ActionStateGetInfo, axis: &str, usual: f32) -> Option<f32> {
        let hand = usize::try_from(asked.subaction_path.into_raw())
            .ok()?
            .checked_sub(1)?;
        let hand = self.paths.get(hand)?;
        let mut bound = self.bound.get(self.held)?.iter();
        let is_asked = |action: &u64| *action == asked.action.into_raw();
        let part = bound.find_map(|(action, path)| {
            path.strip_prefix(hand.as_str())
                .filter(|_| is_asked(action))
        })?;
        let told = self
            .parts
            .iter()
            .find(|(name, _)| name.strip_suffix(axis) == Some(part));
        Some(told.map_or(usual, |(_, value)| *value))
    }

    fn handle(&mut self) -> u64 {
        self.handles += 1;
        self.handles
    }
}

thread_local! {
    static FAKE: RefCell<Fake> = RefCell::new(Fake::default());
}

/// Reads or changes this thread's runtime.
pub(super) fn with<R>(use_it: impl FnOnce(&mut Fake) -> R) -> R {
    FAKE.with_borrow_mut(use_it)
}

/// Connects to this thread's runtime.
pub(super) fn connect() -> Result<System, ConnectError> {
    // SAFETY: the functions that it gives have the signatures of the specification (`find`).
    let entry = unsafe { xr::Entry::from_get_instance_proc_addr(get_instance_proc_addr, &()) }
        .map_err(|code| ConnectError::Failed {
            call: "entry",
            code,
        })?;
    connect_through(&entry, 1)
}

/// Does a call's work, unless the test wants it to fail.
fn call(name: &'static str, work: impl FnOnce(&mut Fake) -> Code) -> Code {
    with(|fake| {
        fake.calls.push(name);
        match fake.fail {
            Some((failing, code)) if failing == name => code,
            _ => work(fake),
        }
    })
}

/// The two-call idiom.
///
/// # Safety
/// `count` must be writable, and `out` for as many as `capacity` says.
unsafe fn fill<T: Clone>(items: &[T], capacity: u32, count: *mut u32, out: *mut T) -> Code {
    // SAFETY: the caller vouches for both.
    unsafe {
        *count = u32::try_from(items.len()).unwrap_or_default();
        if capacity == 0 {
            return Code::SUCCESS;
        }
        if (capacity as usize) < items.len() {
            return Code::ERROR_SIZE_INSUFFICIENT;
        }
        for (at, item) in items.iter().enumerate() {
            out.add(at).write(item.clone());
        }
    }
    Code::SUCCESS
}

fn text<const SIZE: usize>(text: &CStr) -> [c_char; SIZE] {
    let mut out = [0; SIZE];
    for (to, from) in out.iter_mut().zip(text.to_bytes()) {
        *to = from.cast_signed();
    }
    out
}

/// Defines functions of the C interface; the body runs with the runtime's state as `fake`.
macro_rules! functions {
    ($($name:literal $function:ident : $type:ident ($($argument:ident : $of:ty),* $(,)?) |$fake:ident| $body:block)*) => {
        $(
            unsafe extern "system" fn $function($($argument: $of),*) -> Code {
                // SAFETY: the arguments are the crate's own, valid by the specification.
                #[allow(unused_unsafe, reason = "some bodies touch no pointer")]
                call($name, |$fake| unsafe { $body })
            }
        )*

        /// The function of that name.
        pub(super) fn find(name: &CStr) -> Option<pfn::VoidFunction> {
            $(
                if name.to_bytes() == $name.as_bytes() {
                    let function: pfn::$type = $function;
                    // SAFETY: only the pointer's type is forgotten; the crate gives it back.
                    return Some(unsafe { std::mem::transmute::<pfn::$type, pfn::VoidFunction>(function) });
                }
            )*
            None
        }
    };
}

// Here, since it writes functions by the macro above.
mod extensions;

/// What Ramus does not use gives an error.
unsafe extern "system" fn unused() -> Code {
    Code::ERROR_FUNCTION_UNSUPPORTED
}

unsafe extern "system" fn get_instance_proc_addr(
    _: sys::Instance,
    name: *const c_char,
    function: *mut Option<pfn::VoidFunction>,
) -> Code {
    // SAFETY: only the pointer's type is forgotten; the C calling convention lets a function ignore its arguments.
    let unused = unsafe {
        std::mem::transmute::<unsafe extern "system" fn() -> Code, pfn::VoidFunction>(unused)
    };
    // SAFETY: the crate gives a C string and a place for the pointer.
    unsafe {
        let name = CStr::from_ptr(name);
        *function = find(name)
            .or_else(|| extensions::find(name))
            .or(Some(unused));
    }
    Code::SUCCESS
}

functions! {
    "xrEnumerateInstanceExtensionProperties" extensions: EnumerateInstanceExtensionProperties(
        _layer: *const c_char, capacity: u32, count: *mut u32, out: *mut sys::ExtensionProperties,
    ) |fake| {
        let offered: Vec<_> = fake.extensions.iter().map(|name| sys::ExtensionProperties {
            ty: sys::ExtensionProperties::TYPE,
            next: ptr::null_mut(),
            extension_name: text(name),
            extension_version: 1,
        }).collect();
        fill(&offered, capacity, count, out)
    }
    "xrCreateInstance" create_instance: CreateInstance(info: *const sys::InstanceCreateInfo, out: *mut sys::Instance) |fake| {
        let api = (*info).application_info.api_version;
        if api.minor() > 0 && !fake.knows_1_1 {
            return Code::ERROR_API_VERSION_UNSUPPORTED;
        }
        fake.api = Some(api);
        *out = sys::Instance::from_raw(1);
        Code::SUCCESS
    }
    "xrGetInstanceProperties" properties: GetInstanceProperties(_i: sys::Instance, out: *mut sys::InstanceProperties) |_fake| {
        (*out).runtime_name = text(c"Fake");
        (*out).runtime_version = xr::Version::new(1, 2, 3);
        Code::SUCCESS
    }
    "xrGetSystem" system: GetSystem(_i: sys::Instance, _info: *const sys::SystemGetInfo, out: *mut sys::SystemId) |_fake| {
        *out = sys::SystemId::from_raw(1);
        Code::SUCCESS
    }
    "xrGetSystemProperties" system_properties: GetSystemProperties(
        _i: sys::Instance, _s: sys::SystemId, out: *mut sys::SystemProperties,
    ) |fake| {
        (*out).system_name = text(c"Cardboard");
        let hands = (*out).next.cast::<sys::SystemHandTrackingPropertiesEXT>();
        if !hands.is_null() {
            (*hands).supports_hand_tracking = fake.more.sees_hands.into();
        }
        (*out).graphics_properties =
            sys::SystemGraphicsProperties { max_swapchain_image_height: 4096, max_swapchain_image_width: 4096, max_layer_count: fake.most_layers };
        Code::SUCCESS
    }
    "xrEnumerateViewConfigurationViews" configuration_views: EnumerateViewConfigurationViews(
        _i: sys::Instance, _s: sys::SystemId, _t: xr::ViewConfigurationType,
        capacity: u32, count: *mut u32, out: *mut sys::ViewConfigurationView,
    ) |_fake| {
        let view = sys::ViewConfigurationView {
            ty: sys::ViewConfigurationView::TYPE,
            next: ptr::null_mut(),
            recommended_image_rect_width: 640,
            max_image_rect_width: 2048,
            recommended_image_rect_height: 5000,
            max_image_rect_height: 4800,
            recommended_swapchain_sample_count: 1,
            max_swapchain_sample_count: 1,
        };
        fill(&[view; 2], capacity, count, out)
    }
    "xrEnumerateEnvironmentBlendModes" blend_modes: EnumerateEnvironmentBlendModes(
        _i: sys::Instance, _s: sys::SystemId, _t: xr::ViewConfigurationType,
        capacity: u32, count: *mut u32, out: *mut xr::EnvironmentBlendMode,
    ) |_fake| {
        fill(&[xr::EnvironmentBlendMode::ADDITIVE, xr::EnvironmentBlendMode::OPAQUE], capacity, count, out)
    }
    "xrGetVulkanGraphicsRequirements2KHR" requirements: GetVulkanGraphicsRequirements2KHR(
        _i: sys::Instance, _s: sys::SystemId, out: *mut sys::GraphicsRequirementsVulkanKHR,
    ) |_fake| {
        (*out).min_api_version_supported = xr::Version::new(1, 1, 0);
        (*out).max_api_version_supported = xr::Version::new(1, 4, 0);
        Code::SUCCESS
    }
    "xrCreateSession" create_session: CreateSession(
        _i: sys::Instance, _info: *const sys::SessionCreateInfo, out: *mut sys::Session,
    ) |fake| {
        let asked = fake.calls.contains(&"xrGetVulkanGraphicsRequirements2KHR");
        fake.expect(asked, "the graphics requirements were not asked for");
        *out = sys::Session::from_raw(2);
        Code::SUCCESS
    }
    "xrEnumerateReferenceSpaces" reference_spaces: EnumerateReferenceSpaces(
        _s: sys::Session, capacity: u32, count: *mut u32, out: *mut xr::ReferenceSpaceType,
    ) |fake| { fill(&fake.spaces, capacity, count, out) }
    "xrCreateReferenceSpace" reference_space: CreateReferenceSpace(
        _s: sys::Session, info: *const sys::ReferenceSpaceCreateInfo, out: *mut sys::Space,
    ) |fake| {
        fake.made.push(((*info).reference_space_type, (*info).pose_in_reference_space.position.y));
        *out = sys::Space::from_raw(fake.handle());
        Code::SUCCESS
    }
    "xrCreateActionSpace" action_space: CreateActionSpace(
        _s: sys::Session, info: *const sys::ActionSpaceCreateInfo, out: *mut sys::Space,
    ) |fake| {
        let space = fake.handle();
        let action = fake.actions.get(&(*info).action.into_raw()).cloned().unwrap_or_default();
        fake.of_controllers.insert(space, action);
        *out = sys::Space::from_raw(space);
        Code::SUCCESS
    }
    "xrStringToPath" string_to_path: StringToPath(_i: sys::Instance, string: *const c_char, out: *mut sys::Path) |fake| {
        let string = CStr::from_ptr(string).to_string_lossy().into_owned();
        let at = fake.paths.iter().position(|path| *path == string).unwrap_or_else(|| {
            fake.paths.push(string);
            fake.paths.len() - 1
        });
        *out = sys::Path::from_raw(at as u64 + 1);
        Code::SUCCESS
    }
    "xrPathToString" path_to_string: PathToString(
        _i: sys::Instance, path: sys::Path, capacity: u32, count: *mut u32, out: *mut c_char,
    ) |fake| {
        let path = &fake.paths[usize::try_from(path.into_raw()).unwrap_or_default() - 1];
        let text: Vec<c_char> = path.bytes().chain([0]).map(|byte| byte as c_char).collect();
        fill(&text, capacity, count, out)
    }
    "xrCreateActionSet" action_set: CreateActionSet(
        _i: sys::Instance, _info: *const sys::ActionSetCreateInfo, out: *mut sys::ActionSet,
    ) |fake| {
        *out = sys::ActionSet::from_raw(fake.handle());
        Code::SUCCESS
    }
    "xrCreateAction" action: CreateAction(
        _s: sys::ActionSet, info: *const sys::ActionCreateInfo, out: *mut sys::Action,
    ) |fake| {
        fake.expect((*info).count_subaction_paths == 2, "an action without both hands");
        let action = fake.handle();
        let name = CStr::from_ptr((*info).action_name.as_ptr()).to_string_lossy().into_owned();
        fake.actions.insert(action, name);
        *out = sys::Action::from_raw(action);
        Code::SUCCESS
    }
    "xrSuggestInteractionProfileBindings" suggest: SuggestInteractionProfileBindings(
        _i: sys::Instance, info: *const sys::InteractionProfileSuggestedBinding,
    ) |fake| {
        let info = &*info;
        let bindings = std::slice::from_raw_parts(info.suggested_bindings, info.count_suggested_bindings as usize);
        let path = |path: sys::Path| fake.paths[usize::try_from(path.into_raw()).unwrap_or_default() - 1].clone();
        let profile = path(info.interaction_profile);
        let bound: Vec<_> = bindings.iter().map(|binding| (binding.action.into_raw(), path(binding.binding))).collect();
        let palm = bound.iter().any(|(_, path)| path.contains("palm_ext"));
        if palm && fake.more.refuses_palms {
            return Code::ERROR_PATH_UNSUPPORTED;
        }
        let offered = fake.extensions.contains(&c"XR_EXT_palm_pose");
        fake.expect(!palm || offered, "a pose of an extension that is not there");
        fake.bound.insert(profile, bound);
        Code::SUCCESS
    }
    "xrAttachSessionActionSets" attach: AttachSessionActionSets(
        _s: sys::Session, _info: *const sys::SessionActionSetsAttachInfo,
    ) |_fake| { Code::SUCCESS }
    "xrGetCurrentInteractionProfile" profile: GetCurrentInteractionProfile(
        _s: sys::Session, _hand: sys::Path, out: *mut sys::InteractionProfileState,
    ) |fake| {
        let held = fake.paths.iter().position(|path| path == fake.held);
        (*out).interaction_profile = sys::Path::from_raw(held.map_or(0, |at| at as u64 + 1));
        Code::SUCCESS
    }
    "xrEnumerateSwapchainFormats" formats: EnumerateSwapchainFormats(
        _s: sys::Session, capacity: u32, count: *mut u32, out: *mut i64,
    ) |fake| { fill(&fake.formats, capacity, count, out) }
    "xrCreateSwapchain" swapchain: CreateSwapchain(
        _s: sys::Session, info: *const sys::SwapchainCreateInfo, out: *mut sys::Swapchain,
    ) |fake| {
        let info = &*info;
        fake.expect(matches!(info.array_size, 1 | 2) && info.face_count == 1 && info.mip_count == 1 && info.sample_count == 1, "shape");
        fake.expect(fake.formats.contains(&info.format), "a format that was not offered");
        *out = sys::Swapchain::from_raw(fake.handle());
        Code::SUCCESS
    }
    "xrEnumerateSwapchainImages" images: EnumerateSwapchainImages(
        chain: sys::Swapchain, capacity: u32, count: *mut u32, out: *mut sys::SwapchainImageBaseHeader,
    ) |_fake| {
        let images = [0, 1, 2].map(|at| sys::SwapchainImageVulkanKHR {
            ty: sys::SwapchainImageVulkanKHR::TYPE,
            next: ptr::null_mut(),
            image: chain.into_raw() * 10 + at,
        });
        fill(&images, capacity, count, out.cast())
    }
    "xrAcquireSwapchainImage" acquire: AcquireSwapchainImage(
        chain: sys::Swapchain, _info: *const sys::SwapchainImageAcquireInfo, out: *mut u32,
    ) |fake| {
        fake.expect(fake.stage == 2, "outside a frame");
        let before = fake.acquired.insert(chain.into_raw(), 1);
        fake.expect(matches!(before, None | Some(0)), "twice");
        *out = 1;
        Code::SUCCESS
    }
    "xrWaitSwapchainImage" wait_image: WaitSwapchainImage(
        chain: sys::Swapchain, _info: *const sys::SwapchainImageWaitInfo,
    ) |fake| {
        let before = fake.acquired.insert(chain.into_raw(), 2);
        fake.expect(before == Some(1), "not acquired");
        Code::SUCCESS
    }
    "xrReleaseSwapchainImage" release: ReleaseSwapchainImage(
        chain: sys::Swapchain, _info: *const sys::SwapchainImageReleaseInfo,
    ) |fake| {
        let before = fake.acquired.insert(chain.into_raw(), 0);
        fake.expect(before == Some(2), "not waited for");
        Code::SUCCESS
    }
    "xrBeginSession" begin_session: BeginSession(_s: sys::Session, _info: *const sys::SessionBeginInfo) |fake| {
        fake.expect(!fake.running, "it runs already");
        fake.running = true;
        fake.stage = 0;
        Code::SUCCESS
    }
    "xrEndSession" end_session: EndSession(_s: sys::Session) |fake| {
        fake.expect(fake.running && fake.stage == 0, "it does not run, or in the middle of a frame");
        fake.running = false;
        Code::SUCCESS
    }
    "xrRequestExitSession" request_exit: RequestExitSession(_s: sys::Session) |fake| {
        if !fake.running {
            return Code::ERROR_SESSION_NOT_RUNNING;
        }
        for state in [xr::SessionState::STOPPING, xr::SessionState::IDLE, xr::SessionState::EXITING] {
            fake.events.push_back(FakeEvent::State(state));
        }
        Code::SUCCESS
    }
    "xrPollEvent" poll: PollEvent(_i: sys::Instance, out: *mut sys::EventDataBuffer) |fake| {
        let Some(event) = fake.events.pop_front() else { return Code::EVENT_UNAVAILABLE };
        event.write(fake.time, out);
        Code::SUCCESS
    }
    "xrWaitFrame" wait_frame: WaitFrame(
        _s: sys::Session, _info: *const sys::FrameWaitInfo, out: *mut sys::FrameState,
    ) |fake| {
        fake.expect(fake.running && fake.stage == 0, "twice, or outside the session");
        fake.stage = 1;
        fake.synced = false;
        fake.time = fake.times.pop_front().unwrap_or_else(|| fake.time.wrapping_add(PERIOD));
        (*out).predicted_display_time = sys::Time::from_nanos(fake.time);
        (*out).predicted_display_period = sys::Duration::from_nanos(PERIOD);
        (*out).should_render = fake.should_render.into();
        Code::SUCCESS
    }
    "xrSyncActions" sync: SyncActions(_s: sys::Session, _info: *const sys::ActionsSyncInfo) |fake| {
        fake.expect(fake.stage == 1 && !fake.synced, "not once between wait and begin");
        fake.synced = true;
        Code::SUCCESS
    }
    "xrBeginFrame" begin_frame: BeginFrame(_s: sys::Session, _info: *const sys::FrameBeginInfo) |fake| {
        fake.expect(fake.running && fake.stage == 1, "without a wait");
        fake.stage = 2;
        Code::SUCCESS
    }
    "xrLocateViews" locate_views: LocateViews(
        _s: sys::Session, info: *const sys::ViewLocateInfo, state: *mut sys::ViewState,
        capacity: u32, count: *mut u32, out: *mut sys::View,
    ) |fake| {
        fake.expect((*info).display_time.as_nanos() == fake.time && fake.stage > 0, "with another time than the frame's");
        (*state).view_state_flags = fake.views_known;
        let [x, y, z, w] = fake.orientation;
        for (view, side) in fake.located.iter_mut().zip([-0.03, 0.03]) {
            let moved = view.pose.position.z + 0.001;
            view.pose = xr::Posef {
                orientation: xr::Quaternionf { x, y, z, w },
                position: xr::Vector3f { x: side, y: 1.7, z: moved },
            };
            view.fov = fake.fov;
        }
        fill(&fake.located, capacity, count, out)
    }
    "xrLocateSpace" locate_space: LocateSpace(
        space: sys::Space, _base: sys::Space, time: sys::Time, out: *mut sys::SpaceLocation,
    ) |fake| {
        fake.expect(time.as_nanos() == fake.time && fake.stage > 0, "with another time than the frame's");
        let of = fake.of_controllers.get(&space.into_raw()).map(String::as_str);
        let lost = of.is_some_and(|action| fake.held.is_empty() || fake.controllers_lost || action == fake.unknown);
        let palm = of == Some("palm");
        let bound = fake.bound.get(fake.held).is_some_and(|bound| bound.iter().any(|(_, path)| path.contains("palm_ext")));
        let lost = lost || palm && !bound;
        let height = if palm { 1.25 } else { 1.0 };
        (*out).location_flags = if lost { xr::SpaceLocationFlags::EMPTY } else { fake.hands_known };
        let [x, y, z, w] = fake.orientation;
        (*out).pose = xr::Posef {
            orientation: xr::Quaternionf { x, y, z, w },
            position: xr::Vector3f { x: 0.1, y: height, z: -0.3 },
        };
        Code::SUCCESS
    }
    "xrGetActionStateFloat" state_float: GetActionStateFloat(
        _s: sys::Session, info: *const sys::ActionStateGetInfo, out: *mut sys::ActionStateFloat,
    ) |fake| {
        let value = fake.value(&*info, "", fake.number);
        (*out).current_state = value.unwrap_or(0.0);
        (*out).changed_since_last_sync = sys::FALSE;
        (*out).last_change_time = sys::Time::from_nanos(0);
        (*out).is_active = value.is_some().into();
        Code::SUCCESS
    }
    "xrGetActionStateVector2f" state_vector: GetActionStateVector2f(
        _s: sys::Session, info: *const sys::ActionStateGetInfo, out: *mut sys::ActionStateVector2f,
    ) |fake| {
        let [x, y] = [("/x", fake.number), ("/y", -fake.number)].map(|(axis, usual)| fake.value(&*info, axis, usual));
        (*out).current_state = xr::Vector2f { x: x.unwrap_or(0.0), y: y.unwrap_or(0.0) };
        (*out).changed_since_last_sync = sys::FALSE;
        (*out).last_change_time = sys::Time::from_nanos(0);
        (*out).is_active = x.is_some().into();
        Code::SUCCESS
    }
    "xrGetActionStateBoolean" state_boolean: GetActionStateBoolean(
        _s: sys::Session, info: *const sys::ActionStateGetInfo, out: *mut sys::ActionStateBoolean,
    ) |fake| {
        let value = fake.value(&*info, "", if fake.button { 1.0 } else { 0.0 });
        (*out).current_state = value.is_some_and(|value| value > 0.5).into();
        (*out).changed_since_last_sync = sys::FALSE;
        (*out).last_change_time = sys::Time::from_nanos(0);
        (*out).is_active = value.is_some().into();
        Code::SUCCESS
    }
    "xrApplyHapticFeedback" haptic: ApplyHapticFeedback(
        _s: sys::Session, _info: *const sys::HapticActionInfo, _event: *const sys::HapticBaseHeader,
    ) |fake| {
        fake.haptics += 1;
        Code::SUCCESS
    }
    "xrEndFrame" end_frame: EndFrame(_s: sys::Session, info: *const sys::FrameEndInfo) |fake| {
        let info = &*info;
        fake.expect(fake.running && fake.stage == 2, "without a begin");
        fake.expect(info.display_time.as_nanos() == fake.time, "another time than the frame's");
        fake.expect(info.environment_blend_mode == xr::EnvironmentBlendMode::OPAQUE, "blend mode");
        fake.expect(fake.acquired.values().all(|stage| *stage == 0), "an image was not released");
        fake.stage = 0;
        let mut ended = Ended { layers: info.layer_count, ..Ended::default() };
        if info.layer_count > 0 {
            let layer = &*(*info.layers).cast::<sys::CompositionLayerProjection>();
            fake.expect(layer.ty == sys::CompositionLayerProjection::TYPE && layer.view_count == 2, "not a projection");
            let views = std::slice::from_raw_parts(layer.views, 2);
            for (at, view) in views.iter().enumerate() {
                let located = fake.located[at];
                let same = view.pose == located.pose && view.fov == located.fov;
                fake.expect(same, "another pose or field of view than located");
                fake.expect(view.sub_image.image_array_index == u32::from(at == 1), "the other eye's layer");
                let rect = view.sub_image.image_rect;
                fake.expect(rect.offset == sys::Offset2Di::default(), "a picture that begins elsewhere");
                fake.shown.push([rect.extent.width, rect.extent.height]);
            }
            fake.submitted.push([0, 1].map(|eye| views[eye].pose.position.z));
            if !views[0].next.is_null() {
                let depth = &*views[0].next.cast::<sys::CompositionLayerDepthInfoKHR>();
                ended.depth = Some([depth.near_z, depth.far_z]);
            }
        }
        for at in 1..info.layer_count as usize {
            let quad = &*(*info.layers.add(at)).cast::<sys::CompositionLayerQuad>();
            fake.expect(quad.ty == sys::CompositionLayerQuad::TYPE && quad.space.into_raw() != 0, "not a quad");
            fake.expect(quad.sub_image.image_array_index == 0, "a layer that a quad has not");
            ended.quad = Some([quad.pose.position.x, quad.size.width]);
        }
        fake.ended.push(ended);
        Code::SUCCESS
    }
    "xrDestroyInstance" destroy_instance: DestroyInstance(_i: sys::Instance) |_fake| { Code::SUCCESS }
    "xrDestroySession" destroy_session: DestroySession(_s: sys::Session) |_fake| { Code::SUCCESS }
}
