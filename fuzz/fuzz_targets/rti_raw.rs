// SPDX-License-Identifier: Apache-2.0
//! See `lf_fuzz::rti_raw`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lf_fuzz::rti_raw(data));
