// SPDX-License-Identifier: Apache-2.0
//! C's specification of a device, and the results of its calls.

use core::ffi::c_int;
use core::fmt;
use core::marker::PhantomData;

use lf_devices::Problem;

use crate::raw;

/// A constant of C of type `T`: the specification of a device. Only C reads it.
///
/// Rust cannot make one. An `unsafe extern` block declares it, whose author promises that C has it with that type.
#[repr(C)]
pub struct Spec<T> {
    _opaque: [u8; 0],
    _type: PhantomData<T>,
}

// SAFETY: a constant never changes, and C may use its device in any thread.
unsafe impl<T> Sync for Spec<T> {}

impl<T> Spec<T> {
    /// Returns a pointer to the constant.
    pub(super) fn raw(&'static self) -> *const T {
        core::ptr::from_ref(self).cast()
    }
}

impl Spec<*const raw::device> {
    /// Returns the device; null without a driver.
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

/// Converts the result of a call of C.
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
