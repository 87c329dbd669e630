// SPDX-License-Identifier: Apache-2.0
//! Bodies in C.

pub use lf_c::*;

/// How many bytes of an array or a text go to another federate at most, where the connection does not say it by
/// `@max_length`.
pub const PAYLOAD_BYTES: usize = 1 << 16;
