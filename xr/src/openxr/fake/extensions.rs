//! Functions of the extensions, and what they say.

use std::ffi::CStr;
use std::slice;

use ::openxr as xr;
use xr::sys::{self, Handle as _, Result as Code, pfn};

use super::{call, fill};

/// What the extensions say.
pub(in crate::openxr) struct More {
    /// The triangles that each view hides: vertices and indices.
    pub(in crate::openxr) masks: [(Vec<[f32; 2]>, Vec<u32>); 2],
    /// The rates that are offered, in hertz, and those that were asked for.
    pub(in crate::openxr) rates: Vec<f32>,
    pub(in crate::openxr) asked_rates: Vec<f32>,
    /// Whether no binding to a palm's pose is taken, though the extension is there.
    pub(in crate::openxr) refuses_palms: bool,
    /// Whether the device has eyes for hands,
    pub(in crate::openxr) sees_hands: bool,
    /// and where both hands' joints are; none while it sees none.
    pub(in crate::openxr) joints: Option<[[f32; 3]; xr::HAND_JOINT_COUNT]>,
}

impl Default for More {
    fn default() -> Self {
        Self {
            masks: Default::default(),
            rates: vec![60.0, 72.0, 90.0, 120.0],
            asked_rates: Vec::new(),
            refuses_palms: false,
            sees_hands: true,
            joints: None,
        }
    }
}

functions! {
    "xrGetVisibilityMaskKHR" mask: GetVisibilityMaskKHR(
        _s: sys::Session, _t: xr::ViewConfigurationType, view: u32, kind: xr::VisibilityMaskTypeKHR, out: *mut sys::VisibilityMaskKHR,
    ) |fake| {
        fake.expect(kind == xr::VisibilityMaskTypeKHR::HIDDEN_TRIANGLE_MESH, "another mesh than the hidden one");
        let (vertices, indices) = fake.more.masks[view as usize].clone();
        let vertices: Vec<_> = vertices.iter().map(|[x, y]| xr::Vector2f { x: *x, y: *y }).collect();
        let out = &mut *out;
        let code = fill(&vertices, out.vertex_capacity_input, &mut out.vertex_count_output, out.vertices);
        if code != Code::SUCCESS {
            return code;
        }
        fill(&indices, out.index_capacity_input, &mut out.index_count_output, out.indices)
    }
    "xrEnumerateDisplayRefreshRatesFB" rates: EnumerateDisplayRefreshRatesFB(
        _s: sys::Session, capacity: u32, count: *mut u32, out: *mut f32,
    ) |fake| { fill(&fake.more.rates, capacity, count, out) }
    "xrGetDisplayRefreshRateFB" rate: GetDisplayRefreshRateFB(_s: sys::Session, out: *mut f32) |_fake| {
        *out = 72.0;
        Code::SUCCESS
    }
    "xrRequestDisplayRefreshRateFB" request_rate: RequestDisplayRefreshRateFB(_s: sys::Session, rate: f32) |fake| {
        let offered = fake.more.rates.contains(&rate);
        fake.expect(offered, "a rate that was not offered");
        fake.more.asked_rates.push(rate);
        Code::SUCCESS
    }
    "xrCreateHandTrackerEXT" hand_tracker: CreateHandTrackerEXT(
        _s: sys::Session, _info: *const sys::HandTrackerCreateInfoEXT, out: *mut sys::HandTrackerEXT,
    ) |fake| {
        *out = sys::HandTrackerEXT::from_raw(fake.handle());
        Code::SUCCESS
    }
    "xrDestroyHandTrackerEXT" destroy_hand_tracker: DestroyHandTrackerEXT(_t: sys::HandTrackerEXT) |_fake| { Code::SUCCESS }
    "xrLocateHandJointsEXT" locate_joints: LocateHandJointsEXT(
        _t: sys::HandTrackerEXT, info: *const sys::HandJointsLocateInfoEXT, out: *mut sys::HandJointLocationsEXT,
    ) |fake| {
        fake.expect((*info).time.as_nanos() == fake.time, "with another time than the frame's");
        let out = &mut *out;
        let places = slice::from_raw_parts_mut(out.joint_locations, out.joint_count as usize);
        out.is_active = fake.more.joints.is_some().into();
        let joints = fake.more.joints.unwrap_or_default();
        for (place, [x, y, z]) in places.iter_mut().zip(joints) {
            *place = sys::HandJointLocationEXT {
                location_flags: fake.hands_known,
                pose: xr::Posef { position: xr::Vector3f { x, y, z }, ..xr::Posef::IDENTITY },
                radius: 0.01,
            };
        }
        Code::SUCCESS
    }
}
