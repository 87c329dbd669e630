// SPDX-License-Identifier: Apache-2.0
//! See `lf_fuzz::secure_structured`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| lf_fuzz::secure_structured(data));
