// SPDX-License-Identifier: Apache-2.0
//! The functions in C, as `src/lf_internal.h` and `include/lf.h` declare them.
//!
//! Generated C code has an entry for each id of the program's tables. Ports, actions and queues check their ids when
//! they are made; that makes calls with them sound.
use core::ffi::{c_char, c_int, c_void};

use lf_model::Tag;

/// A token, which only C reads.
#[repr(C)]
pub(crate) struct RawToken {
    _private: [u8; 0],
}

/// `tag_t`
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct RawTag {
    time: i64,
    microstep: u32,
}

impl From<Tag> for RawTag {
    fn from(tag: Tag) -> Self {
        Self { time: tag.time.as_nanos(), microstep: tag.microstep.0 }
    }
}

/// `lf_mode_change_t`
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct RawModeChange {
    pub(crate) mode: u16,
    pub(crate) history: bool,
}

/// The result of `lf_c_port_check` for good bytes.
pub(crate) const BYTES_GOOD: c_int = 0;
pub(crate) const BYTES_LENGTH: c_int = 1;
pub(crate) const BYTES_REMAINDER: c_int = 2;

unsafe extern "C" {
    // Generated code.
    pub(crate) static lf_port_count: u16;
    pub(crate) safe fn lf_construct();
    pub(crate) fn lf_give_parameter(parameter: u16, whole: i64, real: f64, text: *mut c_char) -> bool;
    pub(crate) safe fn lf_react(reaction: u16);
    pub(crate) safe fn lf_miss_deadline(reaction: u16);
    pub(crate) safe fn lf_handle_tardy(reaction: u16);
    pub(crate) safe fn lf_reset_mode(mode: u16);
    #[cfg(feature = "transients")]
    pub(crate) fn lf_handed_over(state: u16, size: *mut usize) -> *mut c_void;

    // tokens.c
    pub(crate) fn lf_c_token_retain(token: *mut RawToken);
    pub(crate) fn lf_c_token_release(token: *mut RawToken);
    #[cfg(feature = "traces")]
    pub(crate) fn lf_c_token_encode(token: *const RawToken, bytes: *mut u8, room: usize) -> usize;

    // cells.c
    pub(crate) safe fn lf_c_has_trigger(trigger: u16) -> bool;
    pub(crate) safe fn lf_c_shows_trigger(trigger: u16) -> bool;
    pub(crate) fn lf_c_port_is_present(port: u16) -> bool;
    pub(crate) fn lf_c_port_fill(port: u16, token: *mut RawToken, intended: RawTag);
    pub(crate) fn lf_c_port_clear(port: u16);
    pub(crate) fn lf_c_port_copy(from: u16, to: u16);
    pub(crate) fn lf_c_port_capture(from: u16, to: u16, trigger: u16) -> *mut RawToken;
    pub(crate) fn lf_c_port_encode(port: u16, bytes: *mut u8, room: usize) -> usize;
    pub(crate) fn lf_c_port_check(port: u16, bytes: *const u8, size: usize, expected: *mut usize) -> c_int;
    pub(crate) fn lf_c_port_decode(
        port: u16,
        trigger: u16,
        bytes: *const u8,
        size: usize,
        arrival: i64,
    ) -> *mut RawToken;
    pub(crate) fn lf_c_trigger_show(trigger: u16, token: *mut RawToken);
    pub(crate) fn lf_c_trigger_clear(trigger: u16);
    pub(crate) safe fn lf_c_trigger_has_type(trigger: u16, token_type: *const c_void) -> bool;
    pub(crate) safe fn lf_c_port_has_type(port: u16, token_type: *const c_void) -> bool;
    pub(crate) fn lf_c_run(body: unsafe extern "C" fn(u16), reaction: u16, running: *mut c_void);

    // linux.c or zephyr.c
    pub(crate) safe fn lf_c_begin();
    pub(crate) safe fn lf_c_running() -> *mut c_void;
    pub(crate) fn lf_c_set_running(running: *mut c_void);
    pub(crate) safe fn lf_c_clock() -> i64;

    // print.c
    pub(crate) fn lf_print_error(format: *const c_char, ...);
    pub(crate) fn lf_print_warning(format: *const c_char, ...);
}
