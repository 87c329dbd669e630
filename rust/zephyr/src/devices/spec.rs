// SPDX-License-Identifier: Apache-2.0
//! What C has of a device, and what its calls return.

use core::ffi::c_int;
use core::fmt;
use core::marker::PhantomData;

use lf_devices::Problem;

use crate::raw;

/// A constant of C of type `T`: what it has of a device. Only C looks into it.
#[repr(C)]
pub struct Spec<T> {
    _opaque: [u8; 0],
    _type: PhantomData<T>,
}

// SAFETY: nobody changes a constant, and what C does with the device that one leads to can be done in any thread.
unsafe impl<T> Sync for Spec<T> {}

impl<T> Spec<T> {
    /// The constant.
    pub(super) fn raw(&'static self) -> *const T {
        core::ptr::from_ref(self).cast()
    }
}

impl Spec<*const raw::device> {
    /// The device that it leads to; null without a driver.
    pub(super) fn device(&'static self) -> *const raw::device {
        // SAFETY: declarations of constants of C have their types, and a constant does not change.
        unsafe { *self.raw() }
    }
}

impl<T> fmt::Debug for Spec<T> {
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
