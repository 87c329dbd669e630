// SPDX-License-Identifier: Apache-2.0
//! What C has of a device, and what its calls return.

use core::ffi::c_int;
use core::fmt;

use lf_devices::Problem;

use crate::raw;

/// What C has of a device: a constant of a type that its kind says. Only C looks into it.
#[repr(C)]
pub struct Spec {
    _opaque: [u8; 0],
}

impl Spec {
    /// As the type that it is.
    pub(super) fn raw<T>(&'static self) -> *const T {
        core::ptr::from_ref(self).cast()
    }

    /// The device of a constant that is a pointer to one; null without a driver.
    pub(super) fn device(&'static self) -> *const raw::device {
        // SAFETY: the caller has a constant of C of this type, which does not change.
        unsafe { *self.raw::<*const raw::device>() }
    }
}

impl fmt::Debug for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Spec")
    }
}

/// What a call of C's returns.
pub(super) fn outcome(result: c_int) -> Result<c_int, Problem> {
    if result >= 0 {
        return Ok(result);
    }
    // SAFETY: it has no precondition.
    Err(match unsafe { raw::lf_device_problem(result) } {
        raw::lf_device_problem::LF_DEVICE_NO_DRIVER => Problem::NoDriver,
        raw::lf_device_problem::LF_DEVICE_NOT_READY => Problem::NotReady,
        raw::lf_device_problem::LF_DEVICE_NOT_SUPPORTED => Problem::NotSupported,
        _ => Problem::Failed(-result),
    })
}
