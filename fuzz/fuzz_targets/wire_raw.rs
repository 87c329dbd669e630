// SPDX-License-Identifier: Apache-2.0
//! See `lf_fuzz::wire_raw`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lf_fuzz::wire_raw(data));
