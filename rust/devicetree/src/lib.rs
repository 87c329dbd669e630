// SPDX-License-Identifier: Apache-2.0
//! What the macro `device!` finds in an image's devicetree: from the header that Zephyr generates of it, whose grammar
//! is in `doc/build/dts/macros.bnf` there, to a C file with what drivers need, and to arms of the macro.
//!
//! A device is found by its alias or its node label, in the form that C has of it (`my-led` is `my_led`). One that is
//! not there, or cannot be used, is an error of the macro that says why, and which ones there are.
#![forbid(unsafe_code)]

mod header;
mod names;
mod sources;

pub use header::Devicetree;
