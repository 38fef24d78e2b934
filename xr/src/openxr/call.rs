//! From result codes to errors.

use ::openxr as xr;

use crate::headset::HeadsetError;

/// Turns what an OpenXR call gave into our error.
pub(super) trait Called<T> {
    /// `call` is the name of the OpenXR function.
    fn called(self, call: &'static str) -> Result<T, HeadsetError>;
}

impl<T> Called<T> for xr::Result<T> {
    fn called(self, call: &'static str) -> Result<T, HeadsetError> {
        self.map_err(|code| fault(call, code))
    }
}

/// Looks at a raw code: errors, and the successes that announce a loss.
pub(super) fn check(
    call: &'static str,
    code: xr::sys::Result,
) -> Result<xr::sys::Result, HeadsetError> {
    if code.into_raw() < 0 || code == xr::sys::Result::SESSION_LOSS_PENDING {
        Err(fault(call, code))
    } else {
        Ok(code)
    }
}

fn fault(call: &'static str, code: xr::sys::Result) -> HeadsetError {
    use ::openxr::sys::Result as Code;
    match code {
        Code::ERROR_INSTANCE_LOST
        | Code::ERROR_SESSION_LOST
        | Code::ERROR_RUNTIME_UNAVAILABLE
        | Code::SESSION_LOSS_PENDING => HeadsetError::Lost(format!("{code:?} from {call}")),
        _ => HeadsetError::Failed(format!("{call} gave {code:?}")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the codes say it")]

    use ::openxr::sys::Result as Code;

    use super::*;

    #[test]
    fn each_code_becomes_what_it_means() {
        for code in [
            Code::SUCCESS,
            Code::SESSION_NOT_FOCUSED,
            Code::FRAME_DISCARDED,
            Code::TIMEOUT_EXPIRED,
        ] {
            assert!(
                matches!(check("xrCall", code), Ok(same) if same == code),
                "{code:?}"
            );
        }
        for code in [
            Code::ERROR_INSTANCE_LOST,
            Code::ERROR_SESSION_LOST,
            Code::ERROR_RUNTIME_UNAVAILABLE,
            Code::SESSION_LOSS_PENDING,
        ] {
            assert!(
                matches!(check("xrCall", code), Err(HeadsetError::Lost(_))),
                "{code:?}"
            );
        }
        for code in [
            Code::ERROR_RUNTIME_FAILURE,
            Code::ERROR_POSE_INVALID,
            Code::from_raw(-1_234_567),
        ] {
            assert!(
                matches!(check("xrCall", code), Err(HeadsetError::Failed(_))),
                "{code:?}"
            );
        }
        let text =
            check("xrWaitFrame", Code::ERROR_SESSION_LOST).map_err(|error| error.to_string());
        assert!(text.is_err_and(|text| text.contains("ERROR_SESSION_LOST from xrWaitFrame")));
    }
}
