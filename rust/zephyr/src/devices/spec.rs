// SPDX-License-Identifier: Apache-2.0
//! What C has of a pin, and what its calls return.

use core::ffi::c_int;
use core::fmt;

use lf_devices::Problem;

use crate::raw;

/// What C has of a pin; only C looks into it.
#[repr(C)]
pub struct Spec {
    _opaque: [u8; 0],
}

impl Spec {
    pub(super) fn raw(&'static self) -> *const raw::gpio_dt_spec {
        core::ptr::from_ref(self).cast()
    }
}

impl fmt::Debug for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Spec")
    }
}

/// What a call of C's returns.
pub(super) fn outcome(result: c_int) -> Result<c_int, Problem> {
    // SAFETY: it has no precondition.
    match result {
        0.. => Ok(result),
        error => Err(match unsafe { raw::lf_pin_problem(error) } {
            raw::lf_pin_problem::LF_PIN_NO_DRIVER => Problem::NoDriver,
            raw::lf_pin_problem::LF_PIN_NOT_READY => Problem::NotReady,
            raw::lf_pin_problem::LF_PIN_NOT_SUPPORTED => Problem::NotSupported,
            _ => Problem::Failed(-error),
        }),
    }
}
