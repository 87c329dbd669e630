// SPDX-License-Identifier: Apache-2.0
//! Bodies in C.

pub use lf_c::*;

/// The maximum number of bytes of an array or a text to another federate, unless the connection has a `@max_length`.
pub const PAYLOAD_BYTES: usize = 1 << 16;
