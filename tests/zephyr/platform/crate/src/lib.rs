// SPDX-License-Identifier: Apache-2.0
//! Tests of the platform, run on the target by `src/main.c`.
#![no_std]

mod clock;
mod sockets;
mod threads;

use core::convert::Infallible;
use core::ffi::{CStr, c_char};

use lf::ZephyrPlatform;

/// The result of a test, with the violated condition.
type Outcome = Result<(), &'static CStr>;

/// Fails a test with the condition as its sentence.
macro_rules! ensure {
    ($condition:expr) => {
        if !$condition {
            // The texts of conditions contain no zero byte.
            const WRONG: &str = concat!("not true: ", stringify!($condition), "\0");
            return Err(core::ffi::CStr::from_bytes_until_nul(WRONG.as_bytes()).unwrap_or(c"not true"));
        }
    };
}
pub(crate) use ensure;

/// Exports the cases of a module to C.
macro_rules! cases {
    ($($module:ident::$name:ident),* $(,)?) => {
        $(
            #[unsafe(no_mangle)]
            extern "C" fn $name() -> *const c_char {
                match $module::$name() {
                    Ok(()) => core::ptr::null(),
                    Err(wrong) => wrong.as_ptr(),
                }
            }
        )*
    };
}

cases! {
    clock::clock_never_runs_backwards,
    clock::conversion_is_exact,
    clock::extension_carries_over_the_wrap,
    clock::extension_is_shared_by_readers,
    clock::wait_ends_at_its_time,
    clock::time_is_exact_over_the_wrap,
    threads::another_thread_ends_a_wait,
    threads::a_wake_up_is_not_lost_before_a_wait,
    threads::an_interrupt_ends_a_wait,
    threads::threads_are_reused_and_limited,
    threads::long_lines_keep_whole_characters,
    sockets::bytes_go_over_tcp_and_back,
    sockets::a_wait_for_a_silent_socket_ends_at_its_time,
    sockets::a_full_connection_would_block,
    sockets::datagrams_come_with_their_sender,
    sockets::a_refused_connection_is_reported,
    sockets::a_port_in_use_is_reported,
    sockets::a_stale_id_is_an_error,
    sockets::a_full_table_leaves_connections_waiting,
}

// The library also expects a federate; this program has none.
fn no_federate(_: &mut ZephyrPlatform) -> Result<(), Infallible> {
    Ok(())
}
lf::main!(no_federate, lf::log::LevelFilter::Info);

/// Returns the platform, or the sentence that there is none.
fn platform() -> Result<ZephyrPlatform, &'static CStr> {
    ZephyrPlatform::new().map_err(|_| c"there is no platform")
}
