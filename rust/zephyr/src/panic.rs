// SPDX-License-Identifier: Apache-2.0
//! The panic handler: prints the panic and ends the program. It does not allocate and does not unwind.

use core::panic::PanicInfo;

use crate::raw;

/// The exit status of a program that panicked.
const STATUS: core::ffi::c_int = 101;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    // Earlier log messages come first. SAFETY: it has no precondition.
    unsafe { raw::lf_log_flush() };
    crate::console::print_line(format_args!("lf: {info}"));
    #[cfg(feature = "traces")]
    crate::trace::print_all();
    crate::c_api::call_fatal_hook(format_args!("{info}"));
    stop(STATUS)
}

/// Ends the program: on `native_sim` with this exit status, elsewhere by stopping the calling thread.
pub(crate) fn stop(status: core::ffi::c_int) -> ! {
    // SAFETY: it has no precondition.
    unsafe { raw::lf_exit(status) }
}
