// SPDX-License-Identifier: Apache-2.0
//! The devices of an image's devicetree for the macro `device!`. This crate reads the header that Zephyr generates of
//! the devicetree, whose grammar is in Zephyr's `doc/build/dts/macros.bnf`, and writes a C file for drivers, and the
//! arms of the macro.
//!
//! A device has the name of its alias or its node label in C's form (`my-led` is `my_led`). One that is missing, or
//! cannot be used, is an error of the macro that says why, and lists the existing ones.
#![forbid(unsafe_code)]

mod header;
mod names;
mod sources;

pub use header::Devicetree;
