// SPDX-License-Identifier: Apache-2.0
//! The bindings of bindgen, and nothing else, for the other modules of this crate only.
#![allow(
    dead_code,
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    rust_2018_idioms,
    unreachable_pub,
    unsafe_op_in_unsafe_fn,
    clippy::all,
    clippy::pedantic,
    clippy::undocumented_unsafe_blocks,
    reason = "bindgen wrote it"
)]
// Zephyr has empty structures, which are not C types for Rust; no function that is called here takes one.
#![allow(improper_ctypes, reason = "see above")]

include!(concat!(env!("OUT_DIR"), "/bindings.rs"));
