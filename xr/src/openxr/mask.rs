//! What the lenses hide, as the runtime tells it (XR_KHR_visibility_mask).

use std::ptr;

use ::openxr as xr;

use super::call::check;
use super::system::STEREO;
use crate::headset::HeadsetError;
use crate::mask::{MOST_CORNERS, VisibilityMask, triangles};

/// Asks for the mask of one view, and notes in `mask` if it is another one than before.
pub(super) fn update(
    session: &xr::Session<xr::Vulkan>,
    view: usize,
    mask: &mut VisibilityMask,
) -> Result<(), HeadsetError> {
    let Some(hidden) = mask.hidden.get_mut(view) else {
        return Ok(());
    };
    let asked = match ask(session, view) {
        Err(HeadsetError::Failed(why)) => {
            // All of it is drawn then, as without the extension.
            tracing::warn!("no visibility mask: {why}");
            Vec::new()
        }
        asked => asked?,
    };
    if *hidden != asked {
        *hidden = asked;
        mask.revision += 1;
    }
    Ok(())
}

fn ask(session: &xr::Session<xr::Vulkan>, view: usize) -> Result<Vec<[f32; 2]>, HeadsetError> {
    const CALL: &str = "xrGetVisibilityMaskKHR";
    let Some(functions) = &session.instance().exts().khr_visibility_mask else {
        return Ok(Vec::new());
    };
    let mut told = xr::sys::VisibilityMaskKHR {
        ty: xr::sys::VisibilityMaskKHR::TYPE,
        next: ptr::null_mut(),
        vertex_capacity_input: 0,
        vertex_count_output: 0,
        vertices: ptr::null_mut(),
        index_capacity_input: 0,
        index_count_output: 0,
        indices: ptr::null_mut(),
    };
    let get = |told: &mut xr::sys::VisibilityMaskKHR| {
        // SAFETY: the session is alive, and the struct is initialised and says how much room its arrays have.
        let code = unsafe {
            (functions.get_visibility_mask)(
                session.as_raw(),
                STEREO,
                u32::try_from(view).unwrap_or_default(),
                xr::VisibilityMaskTypeKHR::HIDDEN_TRIANGLE_MESH,
                told,
            )
        };
        check(CALL, code)
    };
    get(&mut told)?;
    let (corners, indices) = (told.vertex_count_output, told.index_count_output);
    let most = u32::try_from(MOST_CORNERS).unwrap_or(u32::MAX);
    if corners > most || indices > most {
        return Err(HeadsetError::Failed(format!(
            "{CALL} told of {corners} vertices and {indices} indices"
        )));
    }
    if indices == 0 {
        return Ok(Vec::new());
    }
    let mut places = vec![xr::Vector2f { x: 0.0, y: 0.0 }; corners as usize];
    let mut order = vec![0_u32; indices as usize];
    told.vertex_capacity_input = corners;
    told.vertices = places.as_mut_ptr();
    told.index_capacity_input = indices;
    told.indices = order.as_mut_ptr();
    get(&mut told)?;
    // A mask that shrank between the calls has filled less.
    places.truncate(told.vertex_count_output as usize);
    order.truncate(told.index_count_output as usize);
    let places: Vec<[f32; 2]> = places.iter().map(|place| [place.x, place.y]).collect();
    Ok(triangles(&places, &order))
}
