// SPDX-License-Identifier: Apache-2.0
//! Bodies in C.

pub use lf_c::*;

/// How many bytes of an array or a text go to another federate at most, where the connection does not say it by
/// `@max_length`: what a block of the store for tokens has room for.
pub const PAYLOAD_BYTES: usize = crate::kconfig::LF_TOKEN_SIZE;
