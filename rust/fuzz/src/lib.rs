// SPDX-License-Identifier: Apache-2.0
//! Targets for fuzzers: each takes any bytes, does something with them, and panics if something does not hold that
//! always has to hold.
//!
//! `fuzz/` hands them to libFuzzer; a test of this crate runs each for a fixed number of inputs, so that they cannot
//! rot. The *raw* targets take their input for bytes from a peer; the *structured* ones for a list of sensible steps,
//! which get farther.
#![forbid(unsafe_code)]

mod rti;
mod rti_oracle;
mod steps;
mod wire;

pub use lf_testkit::federate::{federate_raw, federate_structured};
pub use rti::rti_raw;
pub use steps::{RawStep, rti_structured};
pub use wire::{wire_raw, wire_structured};

/// A target.
pub type Target = fn(&[u8]);

/// All targets with their names.
pub const TARGETS: &[(&str, Target)] = &[
    ("wire_raw", wire_raw),
    ("wire_structured", wire_structured),
    ("rti_raw", rti_raw),
    ("rti_structured", rti_structured),
    ("federate_raw", federate_raw),
    ("federate_structured", federate_structured),
];
