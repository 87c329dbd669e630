// SPDX-License-Identifier: Apache-2.0
//! Targets for fuzzers: each accepts any bytes, acts on them, and panics if an invariant does not hold.
//!
//! `fuzz/` hands them to libFuzzer; a test of this crate runs each for a fixed number of inputs, so that they cannot
//! rot. The *raw* targets treat their input as bytes from a peer; the *structured* ones as a list of sensible steps,
//! which reach deeper states.
#![forbid(unsafe_code)]

mod rti;
mod rti_oracle;
mod secure;
mod steps;
mod wire;

pub use lf_testkit::federate::{federate_raw, federate_structured};
pub use rti::rti_raw;
pub use secure::{secure_raw, secure_structured};
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
    ("secure_raw", secure_raw),
    ("secure_structured", secure_structured),
];
